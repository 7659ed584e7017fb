(* The interval of a ratio from bets on the contrast of two groups within a unit: with what probability it misses.

   Reading key.  D are the sampling units, which are independent: unit d turns out to be u with the probability Q d u, whatever that law is.
   w are the data of all units.  Groups of contexts are numbered by I; [compared i j] says that i and j are two groups of one context.
   [A i j] are the units that are bet on for i and j; of one of them [x i d u] is at least what it gets in group i, as a part
   of the range, and [y j d u] at most what it gets in j.  E are the means of the groups, on the same scale; [bets i j] are the
   shares of the capital that are bet, which are settled before the draws, as A is. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions Draws Ends Coverage.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Law.
Variables (R : realFieldType) (W : finType) (P : W -> R).
Hypothesis lawP : law P.

Lemma expect_average (T : Type) (s : seq T) (f : T -> W -> R) (c : R) :
  expect P (fun w => (\sum_(t <- s) f t w) / c) = (\sum_(t <- s) expect P (f t)) / c.
Proof.
rewrite /expect (eq_bigr (fun w => \sum_(t <- s) P w * f t w / c)) => [|w _]; last by rewrite mulrA mulr_sumr mulr_suml.
by rewrite exchange_big mulr_suml; apply: eq_bigr => t _; rewrite mulr_suml.
Qed.

(* Markov's inequality for what has at most the expectation 1 *)
Lemma markov (S : {set W}) (e : W -> R) alpha : 0 <= alpha -> (forall w, 0 <= e w) -> expect P e <= 1 ->
  (forall w, w \in S -> 1 <= alpha * e w) -> prob P S <= alpha.
Proof.
move=> a0 e0 mean1 large; apply: (@le_trans _ _ (alpha * expect P e)); last by rewrite ler_pimulr.
rewrite /prob /expect mulr_sumr big_mkcond; apply: ler_sum => w _; have P0 : 0 <= P w by case: lawP.
case: ifP => [/large big|_]; last by rewrite !mulr_ge0.
by rewrite mulrCA ler_pemulr.
Qed.

(* The number r may be chosen after looking, if what is won rises in r. *)
Lemma markov_after (S : {set W}) (ok : R -> Prop) (e : R -> W -> R) alpha : 0 <= alpha ->
  (forall r w, 0 <= r -> 0 <= e r w) -> (forall r s w, 0 <= r -> r <= s -> e r w <= e s w) ->
  (forall r, 0 <= r -> ok r -> expect P (e r) <= 1) ->
  (forall w, w \in S -> exists r, [/\ 0 <= r, ok r & 1 <= alpha * e r w]) -> prob P S <= alpha.
Proof.
move=> a0 e0 rises mean1 large.
have all_at s : {subset s <= S} -> s = [::] \/ exists r, [/\ 0 <= r, ok r & forall w, w \in s -> 1 <= alpha * e r w].
  elim: s => [|w s IH] sub; first by left.
  right; have [r [r0 okr big]] := large w (sub w (mem_head w s)).
  have [|->|[r' [r'0 okr' big']]] := IH; first by move=> v vs; apply: sub; rewrite inE vs orbT.
    by exists r; split=> // v; rewrite inE => /eqP->.
  have up q q' v : 0 <= q -> q <= q' -> 1 <= alpha * e q v -> 1 <= alpha * e q' v.
    by move=> q0 le big_q; apply: le_trans big_q _; rewrite ler_wpmul2l // rises.
  have [le|/ltW le] := leP r r'.
    by exists r'; split=> // v; rewrite inE => /orP[/eqP->|/big' //]; apply: up big.
  by exists r; split=> // v; rewrite inE => /orP[/eqP-> //|/big']; apply: up.
case: (all_at (enum S)) => [w|none|[r [r0 okr big]]]; first by rewrite mem_enum.
  by rewrite /prob big1 // => w; rewrite -mem_enum none.
by apply: (@markov S (e r)) => // [w||w wS]; [exact: e0|exact: mean1|apply: big; rewrite mem_enum].
Qed.
End Law.

(* Each datum is of one kind or of another one. *)
Lemma of_two_kinds (W : finType) (S : {set W}) (A B : W -> Prop) : (forall w, w \in S -> A w \/ B w) ->
  exists S1 S2 : {set W}, [/\ forall w, w \in S1 -> A w, forall w, w \in S2 -> B w & S \subset S1 :|: S2].
Proof.
move=> kinds; have [] : exists S1 S2 : {set W}, [/\ forall w, w \in S1 -> A w, forall w, w \in S2 -> B w & {subset enum S <= S1 :|: S2}].
  have : {subset enum S <= S} by move=> w; rewrite mem_enum.
  elim: (enum S) => [|w s IH] sub; first by exists set0, set0; split=> // w; rewrite inE.
  have [|S1 [S2 [all1 all2 cover]]] := IH; first by move=> v vs; apply: sub; rewrite inE vs orbT.
  have [a|b] := kinds w (sub w (mem_head w s)).
    exists (w |: S1), S2; split=> // v; first by rewrite !inE => /orP[/eqP->|/all1].
    by rewrite !inE => /orP[->//|/cover]; rewrite inE -orbA => ->; rewrite orbT.
  exists S1, (w |: S2); split=> // v; first by rewrite !inE => /orP[/eqP->|/all2].
  by rewrite !inE => /orP[->|/cover]; rewrite ?orbT // inE => /orP[]->; rewrite ?orbT.
move=> S1 [S2 [all1 all2 cover]]; exists S1, S2; split=> //.
by apply/subsetP => w wS; apply: cover; rewrite mem_enum.
Qed.

Section Wealth.
Variables (R : realFieldType) (D U : finType) (Q : D -> U -> R).
Implicit Types (A : pred D) (x y : D -> U -> R) (bets : seq R) (r : R) (w : {ffun D -> U}).

(* All units are independent. *)
Definition units_law (w : {ffun D -> U}) : R := drawn id Q w.

Definition won A x y r (l : R) (w : {ffun D -> U}) : R := \prod_(d | A d) (1 + l * (r * y d (w d) - x d (w d))).
Definition wealth bets A x y r (w : {ffun D -> U}) : R := (\sum_(l <- bets) won A x y r l w) / (size bets)%:R.

Hypothesis laws : kernel Q.

Lemma law_units : law units_law. Proof. exact: (law_drawn id laws). Qed.

Variables (A : pred D) (x y : D -> U -> R) (bets : seq R).
Hypotheses (x1 : forall d u, x d u <= 1) (y0 : forall d u, 0 <= y d u) (bets01 : forall l, l \in bets -> 0 <= l <= 1).

Lemma won_ge0 r l w : 0 <= r -> l \in bets -> 0 <= won A x y r l w.
Proof.
move=> r0 /bets01/andP[l0 l1]; apply: prodr_ge0 => d _; apply: (@le_trans _ _ (1 - l)); first by rewrite subr_ge0.
by rewrite ler_add2l -mulrN1 ler_wpmul2l // ler_oppl opprB (le_trans _ (x1 d (w d))) // ler_subl_addr ler_addl mulr_ge0.
Qed.

Lemma wealth_ge0 r w : 0 <= r -> 0 <= wealth bets A x y r w.
Proof. by move=> r0; rewrite /wealth; apply: divr_ge0; last exact: ler0n; rewrite big_seq; apply: sumr_ge0 => l; apply: won_ge0. Qed.

Lemma wealth_rises r s w : 0 <= r -> r <= s -> wealth bets A x y r w <= wealth bets A x y s w.
Proof.
move=> r0 rs; rewrite /wealth ler_wpmul2r ?invr_ge0 ?ler0n // !big_seq; apply: ler_sum => l lin.
have /andP[l0 l1] := bets01 lin; apply: ler_prod => d _; apply/andP; split.
  apply: (@le_trans _ _ (1 - l)); first by rewrite subr_ge0.
  by rewrite ler_add2l -mulrN1 ler_wpmul2l // ler_oppl opprB (le_trans _ (x1 d (w d))) // ler_subl_addr ler_addl mulr_ge0.
by rewrite ler_add2l ler_wpmul2l // ler_add2r ler_wpmul2r.
Qed.

Lemma mean_won r l : 0 <= r -> l \in bets -> (forall d, A d -> r * expect (Q d) (y d) <= expect (Q d) (x d)) ->
  expect units_law (won A x y r l) <= 1.
Proof.
move=> r0 lin null; have /andP[l0 l1] := bets01 lin.
pose F d u := if A d then 1 + l * (r * y d u - x d u) else 1.
have -> : expect units_law (won A x y r l) = \prod_d \sum_u Q d u * F d u.
  rewrite bigA_distr_bigA /expect; apply: eq_bigr => w _.
  by rewrite /units_law /drawn /won [X in _ * X]big_mkcond -big_split.
apply: (@le_trans _ _ (\prod_(d : D) 1)); last by rewrite big1_eq.
apply: ler_prod => d _; apply/andP; split.
  apply: sumr_ge0 => u _; apply: mulr_ge0; first by case: (laws d).
  rewrite /F; case: (A d); last exact: ler01.
  apply: (@le_trans _ _ (1 - l)); first by rewrite subr_ge0.
  by rewrite ler_add2l -mulrN1 ler_wpmul2l // ler_oppl opprB (le_trans _ (x1 d u)) // ler_subl_addr ler_addl mulr_ge0.
rewrite /F; case Ad: (A d); last by rewrite (eq_bigr (Q d)) ?(proj2 (laws d)) // => u _; rewrite mulr1.
have -> : \sum_u Q d u * (1 + l * (r * y d u - x d u)) = 1 + l * (r * expect (Q d) (y d) - expect (Q d) (x d)).
  rewrite (eq_bigr (fun u => Q d u + l * (r * (Q d u * y d u) - Q d u * x d u))) => [|u _]; last by ring.
  by rewrite big_split -mulr_sumr sumrB -mulr_sumr (proj2 (laws d)).
by rewrite -[leRHS]addr0 ler_add2l mulr_ge0_le0 // subr_le0 null.
Qed.

Lemma mean_wealth r : 0 <= r -> (forall d, A d -> r * expect (Q d) (y d) <= expect (Q d) (x d)) ->
  expect units_law (wealth bets A x y r) <= 1.
Proof.
move=> r0 null; case: (posnP (size bets)) => [none|some].
  by rewrite /expect big1 ?ler01 // => w _; rewrite /wealth none invr0 !mulr0.
have -> : expect units_law (wealth bets A x y r) = (\sum_(l <- bets) expect units_law (won A x y r l)) / (size bets)%:R.
  exact: expect_average.
rewrite ler_pdivr_mulr ?ltr0n // mul1r -sum1_size natr_sum !big_seq; apply: ler_sum => l lin.
exact: mean_won.
Qed.
End Wealth.

Section Interval.
Variables (R : realFieldType) (D U I : finType) (B : eqType) (Q : D -> U -> R) (block : I -> B) (E : I -> R).
Variables (A : I -> I -> pred D) (x y : I -> D -> U -> R) (bets : I -> I -> seq R).

Definition wealth_of (i j : I) r (w : {ffun D -> U}) : R := wealth (bets i j) (A i j) (x i) (y j) r w.
Definition mean_of_pairs (pairs : seq (I * I)) r (w : {ffun D -> U}) : R := (\sum_(p <- pairs) wealth_of p.1 p.2 r w) / (size pairs)%:R.

Hypotheses (laws : kernel Q) (E0 : forall i, 0 <= E i).
Hypotheses (x1 : forall i d u, x i d u <= 1) (y0 : forall j d u, 0 <= y j d u) (bets01 : forall i j l, l \in bets i j -> 0 <= l <= 1).
(* Units that are bet on have the means of their groups; what is missing counts as more in the first group, and as less in the second. *)
Hypothesis means : forall i j d, compared block i j -> A i j d -> E i <= expect (Q d) (x i d) /\ expect (Q d) (y j d) <= E j.

Variable alpha : R.
Hypothesis alpha0 : 0 <= alpha.

Lemma compared_sym i j : compared block i j = compared block j i.
Proof. by rewrite /compared eq_sym [i == j]eq_sym. Qed.

Lemma null_mean i j r : compared block i j -> 0 <= r -> r * E j <= E i -> expect (units_law Q) (wealth_of i j r) <= 1.
Proof.
move=> c r0 null; apply: mean_wealth => // [|d Ad]; first exact: bets01.
by have [le ge] := means c Ad; apply: le_trans (le_trans null le); rewrite ler_wpmul2l.
Qed.

(* Somebody can name an upper end r that is wrong although the bets of every pair won 1/alpha at it. *)
Definition proves_wrong_upper w : Prop :=
  exists r, [/\ 0 <= r, ~ at_most_ratio (fun=> 1) E block r & forall i j, compared block i j -> 1 <= alpha * wealth_of i j r w].

(* Somebody can name a lower end 1/r that is wrong although the bets of these pairs, with roles exchanged, won 1/alpha at r on average. *)
Definition proves_wrong_lower pairs w : Prop :=
  exists r, [/\ 0 < r, ~ at_least_ratio (fun=> 1) E block r & 1 <= alpha * mean_of_pairs pairs r w].

Theorem bets_upper (S : {set {ffun D -> U}}) : (forall w, w \in S -> proves_wrong_upper w) ->
  prob (units_law Q) S <= alpha.
Proof.
move=> wrong; have [->|[w0 /wrong[r0 [_ far _]]]] := set_0Vmem S; first by rewrite /prob big_set0.
have one01 (i : I) : 0 <= (1 : R) <= 1 by rewrite ler01 lexx.
have EE i : Coverage.E (fun=> 1) E i = E i by rewrite /Coverage.E mulr1.
have far_pair r : ~ at_most_ratio (fun=> 1) E block r -> exists i j, compared block i j /\ r * E j < E i.
  move=> no; have [/existsP[i /existsP[j /andP[c lt]]]|none] := boolP [exists i, exists j, compared block i j && (r * E j < E i)].
    by exists i, j.
  case: no => i j c; rewrite !EE leNgt; apply: contra none => lt.
  by apply/existsP; exists i; apply/existsP; exists j; rewrite c.
have [i0 [j0 [c0 _]]] := far_pair _ far.
have [i [j [c worst]]] := worst_pair (p := fun=> 1) one01 E0 c0.
apply: (@markov_after _ _ _ (law_units laws) S (fun r => r * E j < E i) (wealth_of i j)) => //.
- by move=> r w r0'; apply: wealth_ge0 => // l; apply: bets01.
- by move=> r s w; apply: wealth_rises => // l; apply: bets01.
- by move=> r r0' /ltW; apply: null_mean.
move=> w /wrong[r [r0' /far_pair[i' [j' [c' lt]]] won_all]]; exists r; split=> //; last exact: won_all.
by have := worst r r0' i' j' c'; rewrite !EE; apply.
Qed.

Theorem bets_lower pairs (S : {set {ffun D -> U}}) : (forall p, p \in pairs -> compared block p.1 p.2) ->
  (forall w, w \in S -> proves_wrong_lower pairs w) ->
  prob (units_law Q) S <= alpha.
Proof.
move=> all_compared wrong.
have null_all r : 0 < r -> ~ at_least_ratio (fun=> 1) E block r -> forall i j, compared block i j -> r * E j <= E i.
  move=> r0 no i j c; rewrite leNgt; apply/negP => lt; case: no; exists j, i; rewrite /Coverage.E !mulr1.
  split; [by rewrite compared_sym|exact: ltW|].
  by rewrite -(pmulr_rgt0 _ r0) (le_lt_trans (E0 i)).
apply: (@markov_after _ _ _ (law_units laws) S (fun r => forall i j, compared block i j -> r * E j <= E i) (mean_of_pairs pairs)) => //.
- by move=> r w r0; rewrite /mean_of_pairs; apply: divr_ge0; last exact: ler0n; apply: sumr_ge0 => p _; apply: wealth_ge0 => // l; apply: bets01.
- move=> r s w r0 rs; rewrite /mean_of_pairs ler_wpmul2r ?invr_ge0 ?ler0n //; apply: ler_sum => p _.
  by apply: wealth_rises => // l; apply: bets01.
2: by move=> w /wrong[r [r0 no big]]; exists r; split=> //; [exact: ltW|exact: null_all].
move=> r r0 null; case: (posnP (size pairs)) => [none|some].
  by rewrite /expect big1 ?ler01 // => w _; rewrite /mean_of_pairs none invr0 !mulr0.
have -> : expect (units_law Q) (mean_of_pairs pairs r) = (\sum_(p <- pairs) expect (units_law Q) (wealth_of p.1 p.2 r)) / (size pairs)%:R.
  exact: expect_average.
rewrite ler_pdivr_mulr ?ltr0n // mul1r -sum1_size natr_sum !big_seq; apply: ler_sum => p pin.
by apply: null_mean => //; [exact: all_compared|apply: null; exact: all_compared].
Qed.

(* Either end, each at the level alpha *)
Theorem bets_together pairs (S : {set {ffun D -> U}}) : (forall p, p \in pairs -> compared block p.1 p.2) ->
  (forall w, w \in S -> proves_wrong_upper w \/ proves_wrong_lower pairs w) -> prob (units_law Q) S <= alpha + alpha.
Proof.
move=> all_compared wrong; have [S1 [S2 [upper lower cover]]] := of_two_kinds wrong.
apply: le_trans (ler_add (bets_upper upper) (bets_lower all_compared lower)).
apply: le_trans (prob_le (law_units laws) cover) _; rewrite /prob (big_setID S1) /= setUK.
have P0 w : 0 <= units_law Q w by case: (law_units laws).
rewrite ler_add2l [leRHS](big_setID S1) /= setDUl setDv set0U ler_addr.
exact: sumr_ge0.
Qed.
End Interval.
