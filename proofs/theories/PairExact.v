(* The exact bound of two independent binomial cells.

   Reading key.  The outcomes are pairs o = (k, k') of successes among n draws of the higher cell and m of the lower one, with the means p and q.
   [first o o'] says that o comes no later than o' in the order of the outcomes, whatever that is; [no_later o] is the set S of the page
   docs/certificate-samples.md, region "pairs".  [ladder r o qs] is what a checker makes sure of: knots qs that prove p < r q at the
   level [level], of which [guard] is for means far from what was seen. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions Binomial.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Monotone.
Variable R : realFieldType.
Implicit Types (n : nat) (p q : R) (S : pred nat).

(* The chance of a set of outcomes that has all smaller ones, or all greater ones, too. *)
Definition chance_in n p S : R := \sum_(a < n.+1 | S a) successes n p a.

Lemma chance_falls n p q S : (forall a a', S a -> (a' <= a)%N -> S a') -> 0 <= p -> p <= q -> q <= 1 -> chance_in n q S <= chance_in n p S.
Proof.
move=> down p0 pq q1; rewrite /chance_in; case: (boolP [exists a : 'I_n.+1, S a]) => [/existsP[a0 S0]|/existsPn none]; last first.
  by rewrite !big_pred0 // => a; apply/negbTE/none.
have [a Sa top] := @arg_maxnP _ a0 (fun a : 'I_n.+1 => S a) (fun a : 'I_n.+1 => nat_of_ord a) S0.
have sum x : \sum_(b < n.+1 | S b) successes n x b = at_most n x a.
  rewrite /at_most -(big_mkord xpredT) (big_nat_widen _ _ n.+1) ?ltn_ord //= big_mkord.
  by apply: eq_bigl => b; rewrite ltnS; apply/idP/idP => [/top|/(down _ _ Sa)].
by rewrite !sum at_most_falls.
Qed.

Lemma chance_rises n p q S : (forall a a', S a -> (a <= a')%N -> S a') -> 0 <= p -> p <= q -> q <= 1 -> chance_in n p S <= chance_in n q S.
Proof.
move=> up p0 pq q1; rewrite /chance_in; case: (boolP [exists a : 'I_n.+1, S a]) => [/existsP[a0 S0]|/existsPn none]; last first.
  by rewrite !big_pred0 // => a; apply/negbTE/none.
have [a Sa bottom] := @arg_minnP _ a0 (fun a : 'I_n.+1 => S a) (fun a : 'I_n.+1 => nat_of_ord a) S0.
have sum x : \sum_(b < n.+1 | S b) successes n x b = at_least n x a.
  by rewrite /at_least; apply: eq_bigl => b; apply/idP/idP => [/bottom|/(up _ _ Sa)].
by rewrite !sum at_least_rises.
Qed.
End Monotone.

Section Pair.
Variables (R : realFieldType) (n m : nat) (first : nat * nat -> nat * nat -> bool).
Hypothesis total : forall o o', first o o' || first o' o.
Hypothesis transitive_first : forall o o' o'', first o o' -> first o' o'' -> first o o''.
(* Fewer successes of the higher cell, or more of the lower one, come no later. *)
Hypothesis staircase : forall a a' b b' o, first (a, b) o -> (a' <= a)%N -> (b <= b')%N -> first (a', b') o.

Definition outcome : Type := ('I_n.+1 * 'I_m.+1)%type.
Definition seen (o : 'I_n.+1 * 'I_m.+1) : nat * nat := (nat_of_ord o.1, nat_of_ord o.2).
Definition joint (p q : R) (o : 'I_n.+1 * 'I_m.+1) : R := successes n p o.1 * successes m q o.2.

Definition no_later (o : nat * nat) : {set 'I_n.+1 * 'I_m.+1} := [set x | first (seen x) o].

Lemma joint_ge0 p q o : 0 <= p <= 1 -> 0 <= q <= 1 -> 0 <= joint p q o.
Proof. by move=> p01 q01; rewrite mulr_ge0 ?successes_ge0. Qed.

Lemma prob_pairs p q (S : {set 'I_n.+1 * 'I_m.+1}) :
  prob (joint p q) S = \sum_a \sum_b if (a, b) \in S then successes n p (nat_of_ord a) * successes m q (nat_of_ord b) else 0.
Proof. by rewrite /prob big_mkcond pair_bigA; apply: eq_bigr => -[a b] _. Qed.

Lemma prob_no_later p q o :
  prob (joint p q) (no_later o) = \sum_(b < m.+1) chance_in n p (fun a => first (a, nat_of_ord b) o) * successes m q b.
Proof.
rewrite prob_pairs exchange_big /=.
apply: eq_bigr => b _; rewrite /chance_in mulr_suml [RHS]big_mkcond; apply: eq_bigr => a _.
by rewrite inE.
Qed.

Lemma prob_no_later' p q o :
  prob (joint p q) (no_later o) = \sum_(a < n.+1) successes n p a * chance_in m q (fun b => first (nat_of_ord a, b) o).
Proof.
rewrite prob_pairs.
apply: eq_bigr => a _; rewrite /chance_in mulr_sumr [RHS]big_mkcond; apply: eq_bigr => b _.
by rewrite inE.
Qed.

(* The chance falls in the higher mean and rises in the lower one. *)
Theorem no_later_monotone p p' q q' o : 0 <= p' -> p' <= p -> p <= 1 -> 0 <= q -> q <= q' -> q' <= 1 ->
  prob (joint p q) (no_later o) <= prob (joint p' q') (no_later o).
Proof.
move=> p0 pp p1 q0 qq q1; apply: (@le_trans _ _ (prob (joint p' q) (no_later o))).
  rewrite !prob_no_later; apply: ler_sum => b _; apply: ler_wpmul2r.
    by rewrite successes_ge0 // q0 (le_trans qq).
  by apply: chance_falls => // a a' Sa le_a; apply: staircase Sa le_a (leqnn _).
rewrite !prob_no_later'; apply: ler_sum => a _; apply: ler_wpmul2l.
  by rewrite successes_ge0 // p0 (le_trans pp).
by apply: chance_rises => // b b' Sb le_b; apply: staircase Sb (leqnn _) le_b.
Qed.

(* The chance of what comes no later than what was seen is seldom small. *)
Theorem no_later_rare p q b : 0 <= p <= 1 -> 0 <= q <= 1 -> 0 <= b ->
  prob (joint p q) [set o | prob (joint p q) (no_later (seen o)) <= b] <= b.
Proof.
move=> p01 q01 b0; set S := [set o | _]; have [->|[o0 o0S]] := set_0Vmem S; first by rewrite /prob big_set0.
have [o oS greatest] := @arg_maxnP _ o0 (fun o => o \in S) (fun o => #|no_later (seen o)|) o0S.
apply: (@le_trans _ _ (prob (joint p q) (no_later (seen o)))); last by move: oS; rewrite inE.
have sub : S \subset no_later (seen o).
  apply/subsetP => x xS; rewrite inE; apply/negPn/negP => late; have := total (seen x) (seen o); rewrite (negbTE late) /= => o_x.
  have : (#|no_later (seen o)| < #|no_later (seen x)|)%N.
    apply: proper_card; apply/properP; split.
      by apply/subsetP => y; rewrite !inE => y_o; apply: transitive_first y_o o_x.
    exists x; rewrite inE ?(negbTE late) //.
    by have := total (seen x) (seen x); rewrite orbb.
  by rewrite ltnNge => /negP; apply; apply: greatest.
rewrite /prob [leRHS](big_setID S) /= (setIidPr sub) ler_addl.
by apply: sumr_ge0 => x _; apply: joint_ge0.
Qed.

(* ---- Ladders ---- *)

Variables (level guard : R).
Hypotheses (guard0 : 0 <= guard) (guard_level : guard <= level).
Let share : R := guard / 4%:R.

(* The least mean of the higher cell with p >= r q *)
Definition image (r q : R) : R := Num.min 1 (r * q).

Definition starts r (o : nat * nat) q : Prop := [\/ q = 0, at_least m q o.2 <= share | at_least n (image r q) o.1 <= share].
Definition stops r (o : nat * nat) q : Prop :=
  [\/ 1 <= r * q, at_most n (image r q) o.1 <= share, q = 1 | at_most m q o.2 <= share].
Definition step r (o : nat * nat) q q' : Prop := prob (joint (image r q) q') (no_later o) <= level - guard.

(* Knots of at least two, of which each two neighbours are a step *)
Fixpoint steps r o (q : R) (qs : seq R) : Prop :=
  if qs is q' :: rest then step r o q q' /\ q <= q' /\ steps r o q' rest else True.

(* Of a single knot: the ends of the two means are apart already. *)
Definition apart r (o : nat * nat) q : Prop :=
  (q = 0 /\ at_most n (image r q) o.1 <= share) \/
  (at_least m q o.2 <= share /\ (1 <= r * q \/ at_most n (image r q) o.1 <= share)).

Definition ladder r (o : nat * nat) (q : R) (qs : seq R) : Prop :=
  0 <= q /\ last q qs <= 1 /\ if qs is [::] then apart r o q else [/\ starts r o q, stops r o (last q qs) & steps r o q qs].

Section Null.
Variables (p q : R).
Hypotheses (p01 : 0 <= p <= 1) (q01 : 0 <= q <= 1).

(* A tail of one of the two is small at its own mean. *)
Definition far (o : nat * nat) : bool :=
  [|| at_most n p o.1 <= share, at_least n p o.1 <= share, at_most m q o.2 <= share | at_least m q o.2 <= share].

Lemma image01 r x : 0 <= r -> 0 <= x -> 0 <= image r x <= 1.
Proof. by move=> r0 x0; rewrite /image le_minl lexx /= le_minr ler01 mulr_ge0. Qed.

Lemma steps_le r o x qs : steps r o x qs -> x <= last x qs.
Proof. by elim: qs x => //= y qs IH x [_ [xy /IH]]; apply: le_trans. Qed.

(* There is a step below which p and above which q are. *)
Lemma between r o x qs : 0 <= r -> r * q <= p -> steps r o x qs -> qs != [::] -> image r x <= p -> q <= last x qs -> 0 <= x -> last x qs <= 1 ->
  prob (joint p q) (no_later o) <= level - guard.
Proof.
move=> r0 null; have /andP[p0 p1] := p01; have /andP[q0 q1] := q01.
elim: qs x => //= y qs IH x [one [xy rest]] _ xp q_last x0 last1; have y0 := le_trans x0 xy.
case: (leP q y) => [qy|/ltW yq].
  have /andP[i0 i1] := image01 r0 x0; apply: le_trans one; apply: no_later_monotone => //.
  exact: le_trans (steps_le rest) last1.
case: qs IH rest q_last last1 => [|z qs] IH rest q_last last1.
  have e : q = y by apply/eqP; rewrite eq_le q_last yq.
  have /andP[i0 i1] := image01 r0 x0; apply: le_trans one; apply: no_later_monotone => //; by rewrite e.
apply: (IH y) => //; rewrite /image le_minl; apply/orP; right.
by apply: le_trans null; apply: ler_wpmul2l.
Qed.

(* Under the null a ladder proves something only about outcomes that are rare. *)
Lemma ladder_rare r o x qs : 0 < r -> r * q <= p -> ladder r o x qs -> far o \/ prob (joint p q) (no_later o) <= level - guard.
Proof.
move=> r0 null [x0 [last1]]; have /andP[p0 p1] := p01; have /andP[q0 q1] := q01.
case: (boolP (far o)) => [_|/norP[lo_n /norP[hi_n /norP[lo_m hi_m]]]]; first by left.
have low y : 0 <= y -> y <= 1 -> at_least m y o.2 <= share -> y < q.
  by move=> y0 y1 small; rewrite ltNge; apply/negP => qy; case/negP: hi_m; apply: le_trans small; apply: at_least_rises.
have high y : 0 <= y -> y <= 1 -> at_most m y o.2 <= share -> q < y.
  by move=> y0 y1 small; rewrite ltNge; apply/negP => yq; case/negP: lo_m; apply: le_trans small; apply: at_most_falls.
have low_p y : 0 <= y -> y <= 1 -> at_least n y o.1 <= share -> y < p.
  by move=> y0 y1 small; rewrite ltNge; apply/negP => py; case/negP: hi_n; apply: le_trans small; apply: at_least_rises.
have high_p y : 0 <= y -> y <= 1 -> at_most n y o.1 <= share -> p < y.
  by move=> y0 y1 small; rewrite ltNge; apply/negP => yp; case/negP: lo_n; apply: le_trans small; apply: at_most_falls.
have im y : 0 <= y -> y <= q -> image r y <= p.
  by move=> y0 yq; rewrite /image le_minl; apply/orP; right; apply: le_trans null; rewrite ler_pmul2l.
have below y : 0 <= y -> p < image r y -> q < y.
  by move=> y0 py; rewrite ltNge; apply/negP => /(im _ y0); rewrite leNgt py.
case: qs last1 => [/= x1 ap|y qs last1 [start stop st]].
  exfalso; case: ap => [[e /high_p]|[/(low _ x0 x1) xq]].
    have /andP[i0 i1] := image01 (ltW r0) x0; move/(_ i0 i1)/(below _ x0); rewrite e.
    by rewrite ltNge q0.
  case=> [rx|/high_p].
    have : r * x < r * q by rewrite ltr_pmul2l.
    by rewrite ltNge (le_trans null) // (le_trans p1).
  have /andP[i0 i1] := image01 (ltW r0) x0; move/(_ i0 i1)/(below _ x0).
  by rewrite ltNge (ltW xq).
right; have x_last := steps_le st; have l0 := le_trans x0 x_last; have x1 := le_trans x_last last1.
apply: (between (ltW r0) null st) => //.
  case: start => [->|/(low _ x0 x1)/ltW|]; try exact: im.
  have /andP[i0 i1] := image01 (ltW r0) x0; move/(low_p _ i0 i1); exact: ltW.
case: stop => [rl||->|/(high _ l0 last1)/ltW] //.
  by rewrite -(ler_pmul2l r0) (le_trans null) // (le_trans p1).
have /andP[i0 i1] := image01 (ltW r0) l0; move/(high_p _ i0 i1)/(below _ l0); exact: ltW.
Qed.

Lemma prob_first (T : pred nat) : prob (joint p q) [set o : 'I_n.+1 * 'I_m.+1 | T o.1] = \sum_(a < n.+1 | T a) successes n p a.
Proof.
rewrite prob_pairs [RHS]big_mkcond; apply: eq_bigr => a _; under eq_bigr do rewrite inE /=.
case: ifP => _; last by rewrite big1.
have := at_most_all q (leqnn m); rewrite /at_most => e.
by rewrite -mulr_sumr e mulr1.
Qed.

Lemma prob_second (T : pred nat) : prob (joint p q) [set o : 'I_n.+1 * 'I_m.+1 | T o.2] = \sum_(b < m.+1 | T b) successes m q b.
Proof.
rewrite prob_pairs exchange_big [RHS]big_mkcond; apply: eq_bigr => b _; under eq_bigr do rewrite inE /=.
case: ifP => _; last by rewrite big1.
have := at_most_all p (leqnn n); rewrite /at_most => e.
by rewrite -mulr_suml e mul1r.
Qed.

Lemma prob_or (S T : {set 'I_n.+1 * 'I_m.+1}) : prob (joint p q) (S :|: T) <= prob (joint p q) S + prob (joint p q) T.
Proof.
rewrite /prob (big_setID S) /= setUK setDUl setDv set0U ler_add2l [leRHS](big_setID S) /= addrC ler_addl.
by apply: sumr_ge0 => x _; apply: joint_ge0.
Qed.

(* Whatever was seen, and whichever ratio and knots were chosen then: if p >= r q, the outcomes for which a ladder proves p < r q have at
   most the probability [level]. *)
Theorem pair_exact (S : {set 'I_n.+1 * 'I_m.+1}) :
  (forall o, o \in S -> exists r x qs, [/\ 0 < r, r * q <= p & ladder r (seen o) x qs]) -> prob (joint p q) S <= level.
Proof.
move=> proved; have share0 : 0 <= share by rewrite divr_ge0 ?ler0n.
pose V := [set o | prob (joint p q) (no_later (seen o)) <= level - guard].
pose A := [set o : 'I_n.+1 * 'I_m.+1 | at_most n p o.1 <= share]; pose B := [set o : 'I_n.+1 * 'I_m.+1 | at_least n p o.1 <= share].
pose C := [set o : 'I_n.+1 * 'I_m.+1 | at_most m q o.2 <= share]; pose D := [set o : 'I_n.+1 * 'I_m.+1 | at_least m q o.2 <= share].
have sub : S \subset V :|: (A :|: (B :|: (C :|: D))).
  apply/subsetP => o /proved[r [x [qs [r0 null /(ladder_rare r0 null)]]]]; rewrite !inE => -[|->] //.
  by rewrite /far /seen /= => ->; rewrite orbT.
have le_S : prob (joint p q) S <= prob (joint p q) (V :|: (A :|: (B :|: (C :|: D)))).
  rewrite /prob [leRHS](big_setID S) /= (setIidPr sub) ler_addl; apply: sumr_ge0 => x _; exact: joint_ge0.
apply: le_trans le_S _.
have VV : prob (joint p q) V <= level - guard by apply: no_later_rare; rewrite ?subr_ge0.
have AA : prob (joint p q) A <= share.
  by rewrite (prob_first (fun a => at_most n p a <= share)); exact: (@rare_low _ n p share (fun a => at_most n p a <= share)).
have BB : prob (joint p q) B <= share.
  by rewrite (prob_first (fun a => at_least n p a <= share)); exact: (@rare_high _ n p share (fun a => at_least n p a <= share)).
have CC : prob (joint p q) C <= share.
  by rewrite (prob_second (fun a => at_most m q a <= share)); exact: (@rare_low _ m q share (fun a => at_most m q a <= share)).
have DD : prob (joint p q) D <= share.
  by rewrite (prob_second (fun a => at_least m q a <= share)); exact: (@rare_high _ m q share (fun a => at_least m q a <= share)).
have four : share + (share + (share + share)) = guard.
  by rewrite /share -!mulrDl -[RHS](@mulfK _ 4%:R) ?pnatr_eq0 //; congr (_ / _); ring.
rewrite -(subrK guard level) -{2}four.
apply: le_trans (prob_or _ _) _; apply: ler_add => //.
by do 2 (apply: le_trans (prob_or _ _) _; apply: ler_add => //); apply: le_trans (prob_or _ _) _; apply: ler_add.
Qed.

End Null.
End Pair.

(* Such an order: by the quotient of two scores, that of the higher cell above, of which 1/0 is the last. *)
Section Scores.
Variables high low : nat -> nat.
Hypotheses (high0 : forall a, (0 < high a)%N) (high_rises : forall a a', (a <= a')%N -> (high a <= high a')%N).
Hypothesis low_rises : forall b b', (b <= b')%N -> (low b <= low b')%N.

Definition by_scores (o o' : nat * nat) : bool := (high o.1 * low o'.2 <= high o'.1 * low o.2)%N.

Theorem by_scores_total o o' : by_scores o o' || by_scores o' o.
Proof. exact: leq_total. Qed.

Theorem by_scores_transitive o o' o'' : by_scores o o' -> by_scores o' o'' -> by_scores o o''.
Proof.
rewrite /by_scores => one two; case: (posnP (low o'.2)) => [z|l0].
  have : (low o''.2 <= 0)%N by rewrite -(leq_pmul2l (high0 o'.1)) muln0 (leq_trans two) // z muln0.
  by rewrite leqn0 => /eqP ->; rewrite muln0.
rewrite -(leq_pmul2r (high0 o'.1)) -(leq_pmul2r l0).
apply: (@leq_trans (high o.1 * low o'.2 * (high o''.1 * low o'.2))%N).
  by rewrite -mulnA (mulnC (high o'.1)) mulnACA (mulnC (low o''.2)) leq_mul2l two orbT.
have e h l z t : (h * l * z * t = z * l * (h * t))%N by rewrite -mulnA (mulnC h) mulnACA (mulnC l).
by rewrite e leq_mul2r one orbT.
Qed.

Theorem by_scores_staircase a a' b b' o : by_scores (a, b) o -> (a' <= a)%N -> (b <= b')%N -> by_scores (a', b') o.
Proof.
rewrite /by_scores /= => ab aa bb; apply: leq_trans (leq_trans ab _); first by rewrite leq_mul2r high_rises ?orbT.
by rewrite leq_mul2l low_rises ?orbT.
Qed.
End Scores.
