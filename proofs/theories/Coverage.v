(* The interval of a ratio from the ends of the means of all cells: with what probability it misses.

   Reading key.  Cell i has n i draws, each worth [worth i] with the probability p i and nothing else; its mean is E i.  Cells are
   compared within a block: those of a context, or the groups of the whole.  R is the greatest quotient of two different means of one
   block.  [at_most_ratio r] says R <= r; [at_least_ratio q] says R >= 1/q (infinite for q = 0).  A [box] is a list of ends of all
   means that the draws w allow at a level.  [proves_most] and [proves_least] say that a box proves an upper, or a lower end of R. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions Binomial Draws Ends.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Coverage.
Variables (R : realFieldType) (W I : finType) (B : eqType) (P : W -> R) (count : I -> W -> nat) (n : I -> nat) (p worth : I -> R) (block : I -> B).
Implicit Types (i j : I) (w : W) (q r level : R) (lo hi : I -> R).

Definition E i : R := worth i * p i.
Definition compared i j : bool := (block i == block j) && (i != j).
Definition at_most_ratio r : Prop := forall i j, compared i j -> E i <= r * E j.
Definition at_least_ratio q : Prop := exists i j, [/\ compared i j, E j <= q * E i & 0 < E i].

(* The draws say something of the mean. *)
Definition informative i : bool := (0 < n i)%N && (0 < worth i).

Definition box level w lo hi : Prop := forall i,
  [/\ 0 <= lo i, lo i <= hi i, hi i <= worth i, lo i = 0 \/ at_least (n i) (lo i / worth i) (count i w) <= level
    & hi i = worth i \/ at_most (n i) (hi i / worth i) (count i w) <= level].

Definition proves_most lo hi r : Prop := 0 <= r /\ forall i j, compared i j -> hi i <= r * lo j.
Definition proves_least lo hi q : Prop := exists i j, [/\ compared i j, hi j <= q * lo i, 0 <= q & 0 < lo i].

(* The box at the level u, or that at the level l, proves what is not true. *)
Definition misses_above u w : Prop := exists lo hi r, [/\ box u w lo hi, proves_most lo hi r & ~ at_most_ratio r].
Definition misses_below l w : Prop := exists lo hi q, [/\ box l w lo hi, proves_least lo hi q & ~ at_least_ratio q].

Hypotheses (lawP : law P) (p01 : forall i, 0 <= p i <= 1) (worth0 : forall i, 0 <= worth i) (drawn : counted P count n p).

Lemma E_ge0 i : 0 <= E i.
Proof. by rewrite mulr_ge0 //; case/andP: (p01 i). Qed.

Lemma E_le i : E i <= worth i.
Proof. by rewrite ler_pimulr //; case/andP: (p01 i). Qed.

Lemma draws_of_small level i w : level < 1 -> at_most (n i) (p i) (count i w) <= level \/ at_least (n i) (p i) (count i w) <= level ->
  (0 < n i)%N.
Proof.
move=> l1; rewrite lt0n; case: eqP => // n0; have := proj1 (drawn i) w; rewrite n0 leqn0 => /eqP->.
by rewrite at_least_flip // !at_most_none => -[]; rewrite leNgt l1.
Qed.

(* A mean beyond an end has a small tail. *)
Lemma above_end level w lo hi i : level < 1 -> box level w lo hi -> hi i < E i ->
  informative i /\ at_most (n i) (p i) (count i w) <= level.
Proof.
move=> l1 /(_ i)[lo0 lohi hw _ tail] far; have /andP[p0 p1] := p01 i.
have hi0 := le_trans lo0 lohi; have w0 : 0 < worth i := le_lt_trans hi0 (lt_le_trans far (E_le i)).
have small : at_most (n i) (p i) (count i w) <= level.
  case: tail => [e|]; first by have := lt_le_trans far (E_le i); rewrite e ltxx.
  apply: le_trans; apply: at_most_falls; rewrite ?divr_ge0 //.
  by rewrite ler_pdivr_mulr // mulrC ltW.
by rewrite /informative w0 (draws_of_small l1 (or_introl small)).
Qed.

Lemma below_end level w lo hi i : level < 1 -> box level w lo hi -> E i < lo i ->
  informative i /\ at_least (n i) (p i) (count i w) <= level.
Proof.
move=> l1 /(_ i)[lo0 lohi hw tail _] far; have /andP[p0 p1] := p01 i.
have w0 : 0 < worth i := le_lt_trans (E_ge0 i) (lt_le_trans far (le_trans lohi hw)).
have small : at_least (n i) (p i) (count i w) <= level.
  case: tail => [e|]; first by move: far; rewrite e ltNge E_ge0.
  apply: le_trans; apply: at_least_rises => //; last by rewrite ler_pdivr_mulr // mul1r (le_trans lohi).
  by rewrite ler_pdivl_mulr // mulrC ltW.
by rewrite /informative w0 (draws_of_small l1 (or_intror small)).
Qed.

(* One pair is wrong whenever some pair is: that of the greatest quotient. *)
Lemma worst_pair i0 j0 : compared i0 j0 -> exists i j, compared i j /\
  forall r, 0 <= r -> forall i' j', compared i' j' -> r * E j' < E i' -> r * E j < E i.
Proof.
move=> c0; pose good (ij : I * I) := compared ij.1 ij.2 && (0 < E ij.1).
case: (boolP [exists ij, good ij]) => [/existsP[ij1 g1]|/existsPn none]; last first.
  exists i0, j0; split=> // r r0 i' j' c' far; have := none (i', j'); rewrite /good /= c' /= -leNgt => E0.
  by have := lt_le_trans far E0; rewrite ltNge mulr_ge0 ?E_ge0.
case: (@Order.TotalTheory.arg_minP _ R _ ij1 good (fun ij => E ij.2 / E ij.1) g1) => -[i j] /andP[/= c Ei] least.
exists i, j; split=> // r r0 i' j' c' far.
have Ei' : 0 < E i' by apply: le_lt_trans far; rewrite mulr_ge0 ?E_ge0.
have := least (i', j'); rewrite /good /= c' Ei' => /(_ isT).
rewrite ler_pdivr_mulr // mulrAC ler_pdivl_mulr // => le_q.
rewrite -(ltr_pmul2r Ei'); apply: (@le_lt_trans _ _ (r * E j' * E i)); last by rewrite mulrC ltr_pmul2l.
by rewrite -(mulrA r (E j)) -(mulrA r (E j')) ler_wpmul2l.
Qed.

Lemma miss_above u w i j : u < 1 -> compared i j ->
  (forall r, 0 <= r -> forall i' j', compared i' j' -> r * E j' < E i' -> r * E j < E i) ->
  misses_above u w ->
  informative i && (at_most (n i) (p i) (count i w) <= u) || informative j && (at_least (n j) (p j) (count j w) <= u).
Proof.
move=> u1 c worst [lo [hi [r [in_box [r0 ends] wrong]]]].
case: (leP (E i) (hi i)) => [Ei|/(above_end u1 in_box)[-> ->] //].
case: (leP (lo j) (E j)) => [Ej|/(below_end u1 in_box)[-> ->]]; last by rewrite orbT.
case: wrong => i' j' c'; rewrite leNgt; apply/negP => far; have := worst r r0 i' j' c' far.
by rewrite ltNge (le_trans Ei) // (le_trans (ends i j c)) // ler_wpmul2l.
Qed.

Lemma miss_below l w : l < 1 -> misses_below l w ->
  exists i, informative i && rare_at n p l l i (count i w).
Proof.
move=> l1 [lo [hi [q [in_box [i [j [c ends q0 lo0]]] wrong]]]].
case: (leP (E j) (hi j)) => [Ej|/(above_end l1 in_box)[inf small]]; last by exists j; rewrite /rare_at inf small orbT.
case: (leP (lo i) (E i)) => [Ei|/(below_end l1 in_box)[inf small]]; last by exists i; rewrite /rare_at inf small.
case: wrong; exists i, j; split=> //; last exact: lt_le_trans Ei.
by rewrite (le_trans Ej) // (le_trans ends) // ler_wpmul2l.
Qed.

(* ---- The probability of a miss ---- *)

(* K cells are informative, and no two that are compared have more than s of them. *)
Variables (K s : nat) (u l : R).
Hypotheses (all_K : K = #|[set i | informative i]|) (spanned : forall i j, compared i j -> (informative i + informative j <= s)%N) (sK : (s <= K)%N).
Hypotheses (l0 : 0 <= l) (lu : l <= u) (u1 : u < 1).

Variable (S : {set W}).
Hypothesis missed : forall w, w \in S -> misses_above u w \/ misses_below l w.

(* The levels at which the ends of a cell matter, of the pair (i, j). *)
Definition lower_level j k : R := if informative k then (if k == j then u else l) else 0.

Lemma lower_level_ge0 j k : 0 <= lower_level j k.
Proof. by rewrite /lower_level; case: ifP => // _; case: ifP => // _; apply: le_trans lu. Qed.

Lemma lower_level_ge j k : informative k -> l <= lower_level j k.
Proof. by rewrite /lower_level => ->; case: ifP. Qed.

Lemma missed_rare i j : compared i j -> 
  (forall r, 0 <= r -> forall i' j', compared i' j' -> r * E j' < E i' -> r * E j < E i) ->
  S \subset rare count n p (lower_level j) (lower_level i).
Proof.
move=> c worst; apply/subsetP => w /missed[/(miss_above u1 c worst)|/(miss_below (le_lt_trans lu u1))[k]]; rewrite inE.
  by case/orP=> /andP[inf small]; apply/existsP; [exists i | exists j]; rewrite /rare_at /lower_level inf eqxx small ?orbT.
case/andP=> inf; rewrite /rare_at => /orP[] small; apply/existsP; exists k; rewrite /rare_at.
  by rewrite (le_trans small) // lower_level_ge.
by rewrite orbC (le_trans small) // lower_level_ge.
Qed.

Lemma sum_lower_level j : \sum_k lower_level j k = K%:R * l + (informative j)%:R * (u - l).
Proof.
rewrite (eq_bigr (fun k => (if informative k then l else 0) + (if k == j then (informative j)%:R * (u - l) else 0))) => [|k _].
  rewrite big_split /= -!big_mkcond /= big_pred1_eq sumr_const all_K; congr (_ + _).
  by rewrite mulr_natl; congr (_ *+ _); apply: eq_card => k; rewrite inE.
rewrite /lower_level; case: (k =P j) => [->|_]; case: (informative _); rewrite ?addr0 ?mul0r ?mul1r ?addr0 //.
by rewrite addrC subrK.
Qed.

Lemma compared_somewhere w : w \in S -> exists i j, compared i j.
Proof.
move=> /missed[[lo [hi [r [_ _ wrong]]]]|[lo [hi [q [_ [i [j [c _ _ _]]] _]]]]]; last by exists i, j.
case: (boolP [exists ij : I * I, compared ij.1 ij.2]) => [/existsP[[i j] c]|/existsPn none]; first by exists i, j.
by case: wrong => i j c; have := none (i, j); rewrite /= c.
Qed.

(* Whatever holds between cells: a pair can be wrong in s ends at the level u, all else at the level l. *)
Theorem box_misses : prob P S <= s%:R * u + (2 * K - s)%:R * l.
Proof.
have [->|[w wS]] := set_0Vmem S.
  rewrite /prob big_set0 addr_ge0 ?mulr_ge0 ?ler0n //; exact: le_trans lu.
have [i0 [j0 c0]] := compared_somewhere wS.
have [i [j [c worst]]] := worst_pair c0.
apply: le_trans (prob_le lawP (missed_rare c worst)) _.
apply: le_trans (rare_sum lawP p01 drawn (lower_level_ge0 j) (lower_level_ge0 i)) _.
rewrite big_split /= !sum_lower_level natrB ?(leq_trans sK) ?leq_pmull // natrM.
have := spanned c; rewrite -(ler_nat R) natrD; move: (informative i)%:R (informative j)%:R => ti tj t_s.
rewrite -subr_ge0 (_ : _ - _ = (s%:R - (ti + tj)) * (u - l)); last by ring.
by rewrite mulr_ge0 ?subr_ge0.
Qed.

Lemma prod_lower_level i j : compared i j -> u + l <= 1 ->
  (1 - u - l) ^+ s * (1 - 2%:R * l) ^+ (K - s) <= \prod_k (1 - lower_level j k - lower_level i k).
Proof.
move=> c ul; have ij : i != j by case/andP: c.
pose x := 1 - u - l; pose y := 1 - 2%:R * l; pose pair := [set k | informative k && (k \in [set i; j])].
have x0 : 0 <= x by rewrite /x -addrA -opprD subr_ge0.
have xy : x <= y by rewrite /x /y mulr_natl mulr2n opprD addrA ler_add2r ler_add2l ler_opp2.
have t_s : (#|pair| <= s)%N.
  apply: leq_trans (spanned c); rewrite /pair -sum1_card big_mkcond (bigD1 i) //= (bigD1 j) 1?eq_sym //= big1 => [|k /andP[ki kj]].
    by rewrite !inE !eqxx orbT !andbT addn0; case: (informative i); case: (informative j).
  by rewrite !inE (negbTE ki) (negbTE kj) andbF.
have -> : \prod_k (1 - lower_level j k - lower_level i k) = x ^+ #|pair| * y ^+ (K - #|pair|).
  rewrite (eq_bigr (fun k => if informative k then (if k \in [set i; j] then x else y) else 1)) => [|k _].
    rewrite -big_mkcond /= (bigID (fun k => k \in [set i; j])) /=; congr (_ * _).
      by rewrite (eq_bigr (fun=> x)) => [|k /andP[_ ->]] //; rewrite prodr_const; congr (_ ^+ _); apply: eq_card => k; rewrite -topredE /= !inE.
    rewrite (eq_bigr (fun=> y)) => [|k /andP[_ /negbTE->]] //; rewrite prodr_const; congr (_ ^+ _).
    have -> : (K - #|pair| = #|[set k | informative k] :\: [set i; j]|)%N.
      by rewrite cardsD all_K; congr (_ - _)%N; apply: eq_card => k; rewrite !inE.
    by apply: eq_card => k; rewrite -topredE /= !inE andbC.
  rewrite /lower_level !inE; case: (informative k); rewrite ?subr0 //.
  case: (k =P i) => [->|_]; rewrite ?(negbTE ij) /x /y /=; first by ring.
  by case: (k =P j) => _; ring.
rewrite -/x -/y -(subnKC t_s) exprD -mulrA ler_wpmul2l ?exprn_ge0 //.
rewrite (_ : K - #|pair| = (s - #|pair|) + (K - (#|pair| + (s - #|pair|))))%N; last first.
  by rewrite subnKC // addnC addnBA // subnK.
by rewrite exprD ler_wpmul2r ?exprn_ge0 ?ler_expn2r ?nnegrE // (le_trans x0).
Qed.

(* If the cells are independent, the chances that all ends are right multiply. *)
Theorem box_misses_independent : independent_counts P count -> u + l <= 1 ->
  prob P S <= 1 - (1 - u - l) ^+ s * (1 - 2%:R * l) ^+ (K - s).
Proof.
move=> ind ul; have l2 : 2%:R * l <= 1 by apply: le_trans ul; rewrite mulr_natl mulr2n ler_add2r.
have u0 := le_trans l0 lu; have [->|[w wS]] := set_0Vmem S.
  have x01 : 0 <= 1 - u - l <= 1 by rewrite -addrA -opprD subr_ge0 ul ger_addl oppr_le0 addr_ge0.
  have y01 : 0 <= 1 - 2%:R * l <= 1 by rewrite subr_ge0 l2 ger_addl oppr_le0 mulr_ge0 ?ler0n.
  case/andP: x01 => x0 x1; case/andP: y01 => y0 y1.
  by rewrite /prob big_set0 subr_ge0 mulr_ile1 ?exprn_ile1 ?exprn_ge0.
have [i0 [j0 c0]] := compared_somewhere wS; have [i [j [c worst]]] := worst_pair c0.
apply: le_trans (prob_le lawP (missed_rare c worst)) _.
apply: le_trans (rare_product lawP p01 drawn ind (lower_level_ge0 j) (lower_level_ge0 i) _) _ => [k|].
  have le_u j' k' : lower_level j' k' <= u by rewrite /lower_level; case: ifP => // _; case: ifP.
  case: (k =P j) => [->|/eqP kj]; last first.
    rewrite addrC (le_trans _ ul) // ler_add ?le_u // /lower_level (negbTE kj).
    by case: ifP.
  rewrite (le_trans _ ul) // ler_add ?le_u // /lower_level.
  by have /andP[_ /negbTE] := c; rewrite eq_sym => ->; case: ifP.
by rewrite ler_add2l ler_opp2 prod_lower_level.
Qed.

End Coverage.
