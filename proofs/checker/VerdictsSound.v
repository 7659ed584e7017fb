(* What is decided of limits on ratios of the population is so, as VerdictsMeaning.v says it. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.analysis Require Import reals sequences exp.
From FairauditKernel Require Import LinearProgram Fractions FractionsSound.
From FairauditChecker Require Import TailsSound Statements Nats NatsSound Chance Drawn DrawnMeaning DrawnSound Verdicts VerdictsMeaning.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Ends.
Variable R : realType.

Lemma end_keepsP l r b : end_keeps l r = Some b -> b = keeps l (omap (@ratio R) r).
Proof.
rewrite /end_keeps /keeps; case: (in_nats l); first exact: log_at_most_sound.
by case: r => [r|] [<-] //; rewrite (at_mostE R).
Qed.

(* In nats, too, a limit is a number. *)
Lemma keepsE l (v : R) : 0 < v -> keeps l (Some v) = (v <= number_of R l).
Proof. by move=> v0; rewrite /keeps /number_of; case: (in_nats l) => //=; rewrite -ler_expR lnK. Qed.

Lemma judged_by_interval_sound e l j : judged_by_interval e l j = Some true -> verdict_follows R l (least_of e) (most_of e) j.
Proof.
rewrite /judged_by_interval /verdict_by_ends /verdict_follows.
case lowE: (end_keeps l (least_of e)) => [a|] //; case highE: (end_keeps l (most_of e)) => [b|]; last by case: a {lowE}.
by rewrite -(end_keepsP lowE) -(end_keepsP highE); case: a {lowE}; case: b {highE}; case: j.
Qed.

(* Ends that are accepted are at least 1. *)
Lemma ends_positive j ps : proved_by_pools j ps ->
  (if most j is Some r then 0 < ratio r :> R else true) /\ (if least j is Some r then 0 < ratio r :> R else true).
Proof.
have above r : at_most one r -> 0 < ratio r :> R by rewrite (at_mostE R) ratio_one; exact: lt_le_trans ltr01.
case/proved_by_poolsP => ss [_ _ _ /and3P[_ /andP[_ high] /andP[_ low]]]; split.
  by case: (most j) high => // r /andP[/above].
move: low; rewrite /least_holds; case: (least j) => [r|] //; case: (pair j) => [[a b]|]; last by case/andP => _ /above.
by case: (cell_at _ a) => // x; case: (cell_at _ b) => // y /and4P[_ _ _ /and3P[/above]].
Qed.

(* A verdict that follows from the ends and is false of the population is wrong in the sense of VerdictsMeaning.v. *)
Lemma false_verdict ps d (Q : 'I_(size ps) -> 'I_d -> R) l j v qs : proved_by_pools j qs ->
  verdict_follows R l (least j) (most j) v ->
  match v with Within => ~~ ratio_keeps Q (number_of R l) | Exceeds => ratio_keeps Q (number_of R l) | _ => false end ->
  verdict_wrong Q (number_of R l) (least j) (most j).
Proof.
case/ends_positive => high low; rewrite /verdict_follows /verdict_wrong; case: v => //.
- case/andP => keep _ /negPf ->; case: (most j) high keep => [r|] /= r0; last by rewrite /keeps; case: (in_nats l).
  by rewrite keepsE.
- case/andP => over _ ->; case: (least j) low over => [r|] //= r0.
  by rewrite keepsE // -ltNge.
Qed.
End Ends.

Section Together.
Variable R : realFieldType.
Local Notation ratio := (@ratio R).

Lemma error_ofE e : ratio (error_of e) = 1 - ratio (confidence_of e).
Proof. by rewrite /error_of ratio_plus ratio_minus ratio_one. Qed.

Lemma error_forE e n : ratio (error_for e n) = risk R e n.
Proof.
rewrite /error_for /risk; case: (ends_each e); last by case: n => [|n]; rewrite ?ratio_zero ?error_ofE.
by rewrite ratio_times error_ofE /ratio /= embed1 divr1 embed_nat.
Qed.

Lemma limits_onE local on : limits_on local on = count (if local then id else negb) on.
Proof. by rewrite /limits_on; elim: on => //= b on <-; case: local; case: b. Qed.

Lemma hold_together_sound l g on c : hold_together l g on c -> together_at R l g on c.
Proof.
have oneE e n : ratio (spent_on e n) = risk_of R e n by case: e => [e|] /=; rewrite ?error_forE ?ratio_zero.
rewrite /hold_together /together_at (at_mostE R) !ratio_plus /spent !oneE !limits_onE ratio_one => le.
by rewrite ler_subr_addr.
Qed.
End Together.
