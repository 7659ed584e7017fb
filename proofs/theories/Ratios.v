(* Elementary facts about sums and ratios that several theorems share.  "a / b <= r" is written [a <= r * b] throughout: where b > 0 it bounds
   the ratio; where b = 0 and a >= 0 it says a = 0, so 0/0 is parity and no finite r bounds c/0. *)
From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Ratios.
Variable R : realFieldType.
Implicit Types I : finType.

(* A ratio of sums is at most the greatest ratio of terms. *)
Lemma ratio_of_sums I (f h : I -> R) (r : R) :
  (forall i, f i <= r * h i) -> \sum_i f i <= r * \sum_i h i.
Proof. by move=> bound; rewrite mulr_sumr; apply: ler_sum. Qed.

(* The same with common nonnegative weights. *)
Lemma ratio_of_means I (w f h : I -> R) (r : R) :
  (forall i, 0 <= w i) -> (forall i, f i <= r * h i) -> \sum_i w i * f i <= r * \sum_i w i * h i.
Proof. by move=> w_ge0 bound; apply: ratio_of_sums => i; rewrite mulrCA ler_wpmul2l. Qed.

(* Two weightings whose ratio is at most c. *)
Lemma ratio_of_weights I (w v f : I -> R) (c : R) :
  (forall i, 0 <= f i) -> (forall i, w i <= c * v i) -> \sum_i w i * f i <= c * \sum_i v i * f i.
Proof. by move=> f_ge0 bound; apply: ratio_of_sums => i; rewrite mulrA ler_wpmul2r. Qed.

(* The mean of a constant under weights that sum to 1. *)
Lemma mean_const I (w : I -> R) (c : R) : \sum_i w i = 1 -> \sum_i w i * c = c.
Proof. by move=> w1; rewrite -mulr_suml w1 mul1r. Qed.

(* Bounds on a function bound its mean. *)
Lemma mean_le I (w f : I -> R) (c : R) :
  (forall i, 0 <= w i) -> \sum_i w i = 1 -> (forall i, f i <= c) -> \sum_i w i * f i <= c.
Proof. by move=> w_ge0 w1 fc; rewrite -[leRHS](mean_const c w1); apply: ler_sum => i _; apply: ler_wpmul2l. Qed.

Lemma mean_ge I (w f : I -> R) (c : R) :
  (forall i, 0 <= w i) -> \sum_i w i = 1 -> (forall i, c <= f i) -> c <= \sum_i w i * f i.
Proof. by move=> w_ge0 w1 fc; rewrite -[leLHS](mean_const c w1); apply: ler_sum => i _; apply: ler_wpmul2l. Qed.

(* The sum that picks a single index. *)
Lemma sum_indicator I (i0 : I) (f : I -> R) : \sum_i f i * (i == i0)%:R = f i0.
Proof.
rewrite (bigD1 i0) //= eqxx mulr1 big1 ?addr0 // => i i_neq.
by rewrite (negbTE i_neq) mulr0.
Qed.

(* A nonnegative sum that vanishes vanishes termwise. *)
Lemma sum_eq0 I (f : I -> R) : (forall i, 0 <= f i) -> \sum_i f i = 0 -> forall i, f i = 0.
Proof. by move=> f_ge0 /psumr_eq0P f0 i; apply: f0. Qed.

(* A minimum of two bounds. *)
Lemma le_min_mul (x y a b : R) : a <= x * b -> a <= y * b -> a <= Num.min x y * b.
Proof. by case: (leP x y). Qed.

(* From the complements' ratio to the third term of T3: (gamma - b) <= e * (gamma - a) and b >= tau. *)
Lemma complement_term (e gamma tau a b : R) :
  1 <= e -> 0 < gamma -> 0 < tau -> tau <= b -> gamma - b <= e * (gamma - a) ->
  a <= (1 - (1 - tau / gamma) / e) / (tau / gamma) * b.
Proof.
move=> e1 gamma0 tau0 floor bound; have e0 : 0 < e := lt_le_trans ltr01 e1.
have -> : (1 - (1 - tau / gamma) / e) / (tau / gamma) * b = (e * gamma - gamma + tau) * b / (tau * e).
  by field; rewrite !gt_eqF.
rewrite ler_pdivl_mulr ?mulr_gt0 // -subr_ge0.
have -> : (e * gamma - gamma + tau) * b - a * (tau * e)
        = tau * (e * (gamma - a) - (gamma - b)) + (e - 1) * gamma * (b - tau) by ring.
by rewrite addr_ge0 // !mulr_ge0 ?subr_ge0 // ltW.
Qed.

End Ratios.
