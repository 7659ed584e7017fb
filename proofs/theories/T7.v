(* T7: what a bound for all utilities that ignore the group says about total variation. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP Ratios T6.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Pair.
Variables (R : realFieldType) (U : finType) (P Q : U -> R).
Hypotheses (lP : law P) (lQ : law Q).

Let S : {set U} := [set u | Q u < P u].

(* TV(P,Q) = P(S) - Q(S) for the set S of decisions that P gives more often. *)
Lemma tv_prob : tv P Q = prob P S - prob Q S.
Proof.
rewrite /tv /hockey_stick /prob -sumrB [RHS]big_mkcond; apply: eq_bigr => u _.
by rewrite mul1r inE -subr_gt0; case: ltP.
Qed.

Lemma prob_compl (P' : U -> R) : law P' -> prob P' (~: S) = 1 - prob P' S.
Proof.
case=> _ P1; apply/eqP; rewrite eq_sym subr_eq -P1 (bigID (mem S)) /= addrC; apply/eqP.
by congr (_ + _); apply: eq_bigl => u; rewrite !inE.
Qed.

Lemma tv_le1 : tv P Q <= 1.
Proof.
rewrite tv_prob ler_subl_addr -[leLHS]addr0; apply: ler_add; last first.
  by apply: sumr_ge0 => u _; case: lQ.
rewrite -subr_ge0 -prob_compl //; apply: sumr_ge0 => u _; by case: lP.
Qed.

(* T7 with the one-sided suprema R1 = max P/Q and R2 = max Q/P, without a division. *)
Theorem T7_product R1 R2 : pure_dp R1 P Q -> pure_dp R2 Q P ->
  (R1 * R2 - 1) * tv P Q <= (R1 - 1) * (R2 - 1).
Proof.
move=> PQ QP; have r1 := pure_dp_ge1 lP lQ PQ.
have r2 := pure_dp_ge1 lQ lP QP.
have on_S : prob P S <= R1 * prob Q S by rewrite mulr_sumr; apply: ler_sum.
have off_S : 1 - prob Q S <= R2 * (1 - prob P S).
  by rewrite -!prob_compl // mulr_sumr; apply: ler_sum.
rewrite tv_prob -subr_ge0.
have -> : (R1 - 1) * (R2 - 1) - (R1 * R2 - 1) * (prob P S - prob Q S)
        = (R2 - 1) * (R1 * prob Q S - prob P S) + (R1 - 1) * (R2 * (1 - prob P S) - (1 - prob Q S)) by ring.
by rewrite addr_ge0 // mulr_ge0 // subr_ge0.
Qed.

(* T7, one-sided: TV <= (R1 - 1)(R2 - 1)/(R1 R2 - 1); where both are 1 the laws agree and TV = 0 (0/0 is 0 here). *)
Theorem T7_one_sided R1 R2 : pure_dp R1 P Q -> pure_dp R2 Q P ->
  tv P Q <= (R1 - 1) * (R2 - 1) / (R1 * R2 - 1).
Proof.
move=> PQ QP; have r1 := pure_dp_ge1 lP lQ PQ.
have r2 := pure_dp_ge1 lQ lP QP.
have := mulr_ege1 r1 r2; rewrite le_eqVlt => /orP[/eqP one|gt1]; last first.
  by rewrite ler_pdivl_mulr ?subr_gt0 // mulrC; apply: T7_product.
have R11 : R1 = 1.
  by apply/eqP; rewrite eq_le r1 andbT one ler_pemulr // (le_trans ler01).
rewrite R11 subrr mul0r mul0r tv_prob subr_le0 /prob; apply: ler_sum => u _.
by have := PQ u; rewrite R11 mul1r.
Qed.

(* T7 with one R for both orders: TV <= (R - 1)/(R + 1). *)
Theorem T7_symmetric r : pure_dp r P Q -> pure_dp r Q P -> tv P Q <= (r - 1) / (r + 1).
Proof.
move=> PQ QP; have r1 := pure_dp_ge1 lP lQ PQ; have rp : 0 < r + 1 := ltr_paddl (le_trans ler01 r1) ltr01.
have [r_eq1|r_neq1] := eqVneq r 1.
  by have := T7_one_sided PQ QP; rewrite r_eq1 subrr !mul0r.
have r_gt1 : 0 < r - 1 by rewrite subr_gt0 lt_neqAle eq_sym r_neq1.
rewrite ler_pdivl_mulr // -(ler_pmul2r r_gt1).
rewrite -mulrA; have -> : (r + 1) * (r - 1) = r * r - 1 by ring.
by rewrite mulrC; apply: T7_product.
Qed.

End Pair.

Section Forms.
Variable R : realFieldType.
Implicit Types r : R.

(* The sharp form is at most half of the paper's R - 1. *)
Theorem T7_form r : 1 <= r -> (r - 1) / (r + 1) <= (r - 1) / 2%:R.
Proof.
move=> r1; have rp : 0 < r + 1 := ltr_paddl (le_trans ler01 r1) ltr01.
apply: ler_wpmul2l; first by rewrite subr_ge0.
by rewrite lef_pinv ?posrE ?ltr0n // -[2%:R]/(1 + 1) ler_add2r.
Qed.

(* The paper's form: TV <= R - 1. *)
Theorem T7_paper (U : finType) (P Q : U -> R) r :
  law P -> law Q -> pure_dp r P Q -> pure_dp r Q P -> tv P Q <= r - 1.
Proof.
move=> lP lQ PQ QP; have r1 := pure_dp_ge1 lP lQ PQ.
apply: le_trans (T7_symmetric lP lQ PQ QP) (le_trans (T7_form r1) _).
by rewrite ler_pdivr_mulr ?ltr0n // ler_pemulr ?subr_ge0 // (ler_nat _ 1 2).
Qed.

(* T7 is attained, for every R >= 1, by two decisions. *)
Definition lean r (u : bool) : R := (if u then r else 1) / (r + 1).
Definition tilt r (u : bool) : R := (if u then 1 else r) / (r + 1).

Theorem T7_sharp r : 1 <= r ->
  [/\ law (lean r), law (tilt r), pure_dp r (lean r) (tilt r), pure_dp r (tilt r) (lean r) &
      tv (lean r) (tilt r) = (r - 1) / (r + 1)].
Proof.
move=> r1; have r0 : 0 <= r := le_trans ler01 r1.
have rp : 0 < r + 1 := ltr_paddl r0 ltr01.
have rr : 1 <= r * r by rewrite mulr_ege1.
have nz : r + 1 != 0 by rewrite gt_eqF.
split.
- by split=> [[]|]; rewrite ?big_bool /lean /= ?divr_ge0 ?ler01 ?(ltW rp) // -mulrDl divff.
- by split=> [[]|]; rewrite ?big_bool /tilt /= ?divr_ge0 ?ler01 ?(ltW rp) // -mulrDl addrC divff // addrC.
- by case; rewrite /lean /tilt mulrA ler_pmul2r ?invr_gt0 // ?mulr1.
- by case; rewrite /lean /tilt mulrA ler_pmul2r ?invr_gt0 // ?mulr1.
have up : 0 <= (r - 1) / (r + 1) by rewrite divr_ge0 ?subr_ge0 // ltW.
have down : (1 - r) / (r + 1) <= 0 by rewrite mulr_le0_ge0 ?subr_le0 ?invr_ge0 // ltW.
rewrite /tv /hockey_stick big_bool /lean /tilt /= ![1 * (_ / _)]mul1r -!mulrBl.
by rewrite (max_idPr up) (max_idPl down) addr0.
Qed.

End Forms.

Section Fairness.
Variables (R : realFieldType) (X A U : finType) (P : X -> A -> U -> R) (W : A -> X -> R).
Hypothesis kP : forall x, kernel (P x).

(* Equalized odds: if r bounds R for every utility g(u,x) >= 0, then L_eo <= (r - 1)/(r + 1). *)
Theorem T7_equalized_odds r :
  (forall g, a_free g -> (forall u x a, 0 <= g u x a) -> local_le r (utility P g)) ->
  forall x a a', tv (P x a) (P x a') <= (r - 1) / (r + 1).
Proof. by move=> /T6_local PQ x a a'; apply: T7_symmetric => //; apply: kP. Qed.

(* Demographic parity: the same with the global ratio over all g(u) >= 0 and the laws P(u|a). *)
Theorem T7_demographic_parity r : (forall a, law (W a)) ->
  (forall g : U -> R, (forall u, 0 <= g u) -> global_le r (group_mean W (utility P (fun u _ _ => g u)))) ->
  forall a a', tv (group_law P W a) (group_law P W a') <= (r - 1) / (r + 1).
Proof.
move=> lW /T6_global PQ a a'.
have lg b : law (group_law P W b).
  split=> [u|]; first by apply: sumr_ge0 => x _; rewrite mulr_ge0 ?(proj1 (lW b)) ?(proj1 (kP x b)).
  rewrite exchange_big -[RHS](proj2 (lW b)); apply: eq_bigr => x _.
  by rewrite -mulr_sumr (proj2 (kP x b)) mulr1.
exact: T7_symmetric.
Qed.

(* The paper's form of both. *)
Theorem T7_paper_equalized_odds r :
  (forall g, a_free g -> (forall u x a, 0 <= g u x a) -> local_le r (utility P g)) ->
  forall x a a', tv (P x a) (P x a') <= r - 1.
Proof. by move=> /T6_local PQ x a a'; apply: T7_paper => //; apply: kP. Qed.

End Fairness.

(* Behind a purely eps-private group filter every policy has L_eo <= (e^eps - 1)/(e^eps + 1). *)
Theorem T7_filter (R : realFieldType) (X Xt A At U : finType)
    (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R) (k : R) :
  kernel MX -> kernel MA -> policy T -> every_pair (pure_dp k) MA ->
  forall x a a', tv (induced MX MA T x a) (induced MX MA T x a') <= (k - 1) / (k + 1).
Proof.
move=> kX kA kT dp x a a'.
have PQ b b' : pure_dp k (induced MX MA T x b) (induced MX MA T x b').
  move=> u; rewrite /induced; apply: ratio_of_sums => y; apply: ratio_of_sums => c.
  have -> : k * (MX x y * MA b' c * T y c u) = MX x y * (k * MA b' c) * T y c u by ring.
  by rewrite ler_wpmul2r ?(proj1 (kT y c)) // ler_wpmul2l ?(proj1 (kX x)) // dp.
by apply: T7_symmetric => //; apply: kernel_induced.
Qed.
