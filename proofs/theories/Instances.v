(* The forms with real logarithms and exponentials: T1 and T2 in nats, T12 with tanh, and T3 under Renyi
   privacy and zCDP.  This file alone uses mathcomp-analysis, whose reals rest on the usual classical
   axioms (Print Assumptions lists them); everything it uses from the other files is axiom-free. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From mathcomp.analysis Require Import reals topology derive normedtype realfun sequences exp.
From Fairaudit Require Import Definitions DP T1 T3 T12.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Import numFieldTopology.Exports numFieldNormedType.Exports.
Local Open Scope ring_scope.

Section Exponential.
Variable R : realType.
Implicit Types (x y z a : R).

(* The graph of exp lies above its tangents. *)
Lemma tangent x : 1 + x <= expR x.
Proof.
case: (leP 0 x) => [/expR_ge1Dx//|x0].
have [|c] := @MVT_segment R expR expR x 0 (ltW x0) (fun z _ => is_derive_expR z).
  by apply/continuous_subspaceT => ?; exact: continuous_expR.
rewrite in_itv /= expR0 sub0r => /andP[_ c0] e.
have c1 : expR c <= 1 by rewrite -expR0 ler_expR.
have : expR c * - x <= - x by rewrite ler_pimull // oppr_ge0 ltW.
by rewrite -e ler_subl_addr addrC -ler_subl_addr opprK.
Qed.

Lemma tangent_at m x : expR m * (1 + x - m) <= expR x.
Proof.
rewrite -{2}(subrK m x) [x - m + m]addrC expRD ler_pmul2l ?expR_gt0 //.
by rewrite -addrA; apply: tangent.
Qed.

Lemma expR_ln x : 0 < x -> expR (ln x) = x.
Proof. by move=> x0; apply: lnK; rewrite posrE. Qed.

(* x^a, with 0^a = 0. *)
Definition pw x a : R := if x == 0 then 0 else expR (a * ln x).

Lemma pw_ge0 x a : 0 <= pw x a.
Proof. by rewrite /pw; case: eqP => // _; rewrite ltW // expR_gt0. Qed.

(* The tangent of x^a y^(1-a) along the ray x/y = exp w. *)
Lemma pw_tangent a w x y : 1 < a -> 0 <= x -> 0 < y ->
  a * expR ((a - 1) * w) * x - (a - 1) * expR (a * w) * y <= pw x a * pw y (1 - a).
Proof.
move=> a1; rewrite le_eqVlt => /orP[/eqP<-|x0] y0.
  have -> : pw 0 a = 0 by rewrite /pw eqxx.
  rewrite mulr0 mul0r sub0r oppr_le0 !mulr_ge0 ?subr_ge0 ?(ltW a1) ?(ltW y0) //.
  exact: ltW (expR_gt0 _).
rewrite /pw (gt_eqF x0) (gt_eqF y0) -expRD.
set X := a * ln x + _; pose Y := a * w + ln y; pose m := (a - 1) * w + ln x.
have -> : a * expR ((a - 1) * w) * x = a * expR m by rewrite /m expRD (expR_ln x0) mulrA.
have -> : (a - 1) * expR (a * w) * y = (a - 1) * expR Y by rewrite /Y expRD (expR_ln y0) mulrA.
rewrite ler_subl_addr; apply: le_trans (ler_add (tangent_at m X) (ler_wpmul2l _ (tangent_at m Y))); last first.
  by rewrite subr_ge0 ltW.
have -> : expR m * (1 + X - m) + (a - 1) * (expR m * (1 + Y - m)) =
   expR m * (a + (X + (a - 1) * Y - a * m)) by ring.
have -> : X + (a - 1) * Y - a * m = 0 by rewrite /X /Y /m; ring.
by rewrite addr0 mulrC.
Qed.

End Exponential.

Section Renyi.
Variables (R : realType) (B : finType).
Implicit Types (P Q phi : B -> R) (a rho t : R).

(* D_a(P||Q) <= rho for an order a > 1: supports agree and the moment is at most exp((a-1) rho). *)
Definition renyi_le a rho P Q : Prop :=
  (forall b, Q b = 0 -> P b = 0) /\ \sum_b pw (P b) a * pw (Q b) (1 - a) <= expR ((a - 1) * rho).

Definition zcdp rho P Q : Prop := forall a, 1 < a -> renyi_le a (rho * a) P Q.

(* Hoelder's inequality for a test, in logarithms. *)
Lemma renyi_test a rho P Q phi : 1 < a -> law P -> law Q -> renyi_le a rho P Q -> test phi ->
  0 < expect P phi -> 0 < expect Q phi /\
  a * ln (expect P phi) + (1 - a) * ln (expect Q phi) <= (a - 1) * rho.
Proof.
move=> a1 lP lQ [ac mom] te p0; case: (lP) => P0 _; case: (lQ) => Q0 _.
set p := expect P phi in p0 *; set q := expect Q phi.
have ph0 b : 0 <= phi b by case/andP: (te b).
have q0 : 0 < q.
  rewrite lt_def expect_ge0 // andbT; apply/eqP => q0.
  have z b : Q b * phi b = 0.
    have/eqP := q0; rewrite psumr_eq0 => [/allP h|c _]; last by rewrite mulr_ge0.
    by apply/eqP; apply: (implyP (h b (mem_index_enum b))).
  move: p0; rewrite /p /expect big1 ?ltxx // => b _.
  by have /eqP := z b; rewrite mulf_eq0 => /orP[/eqP/ac->|/eqP->]; rewrite ?mul0r ?mulr0.
split=> //; pose w := ln p - ln q; set Z := a * ln p + _.
have Zp : expR ((a - 1) * w) * p = expR Z.
  by rewrite -{1}(expR_ln p0) -expRD; congr expR; rewrite /w /Z; ring.
have Zq : expR (a * w) * q = expR Z.
  by rewrite -{1}(expR_ln q0) -expRD; congr expR; rewrite /w /Z; ring.
rewrite -ler_expR; apply: le_trans mom.
have -> : expR Z = a * expR ((a - 1) * w) * p - (a - 1) * expR (a * w) * q.
  by rewrite -!mulrA Zp Zq; ring.
rewrite /p /q /expect !mulr_sumr -sumrB; apply: ler_sum => b _.
have -> : a * expR ((a - 1) * w) * (P b * phi b) - (a - 1) * expR (a * w) * (Q b * phi b) =
  (a * expR ((a - 1) * w) * P b - (a - 1) * expR (a * w) * Q b) * phi b by ring.
have [b0|bn] := eqVneq (Q b) 0.
  by rewrite b0 (ac _ b0) !mulr0 subrr mul0r mulr_ge0 // pw_ge0.
have m0 : 0 <= pw (P b) a * pw (Q b) (1 - a) by rewrite mulr_ge0 // pw_ge0.
apply: (@le_trans _ _ (pw (P b) a * pw (Q b) (1 - a) * phi b)).
  by apply: ler_wpmul2r => //; apply: pw_tangent => //; rewrite lt_def bn Q0.
by rewrite ler_pimulr //; case/andP: (te b).
Qed.

(* Power of a test of level t under Renyi privacy. *)
Lemma power_renyi a rho t P Q : 1 < a -> law P -> law Q -> 0 < t -> renyi_le a rho P Q ->
  power_le t (expR ((a - 1) * (rho + ln t) / a)) P Q.
Proof.
move=> a1 lP lQ t0 rd phi te le; case: (leP (expect P phi) 0) => p0.
  by apply: le_trans p0 _; rewrite ltW // expR_gt0.
have [q0 h] := renyi_test a1 lP lQ rd te p0.
have a0 : 0 < a := lt_trans ltr01 a1.
rewrite -[X in X <= _](expR_ln p0) ler_expR ler_pdivl_mulr // mulrC.
have lq : ln (expect Q phi) <= ln t by rewrite ler_ln ?posrE.
rewrite mulrDr; have {}h : a * ln (expect P phi) <= (a - 1) * rho + (a - 1) * ln (expect Q phi).
  by rewrite -ler_subl_addr; apply: le_trans h; rewrite le_eqVlt; apply/orP; left; apply/eqP; ring.
by apply: le_trans h _; rewrite ler_add2l ler_wpmul2l // subr_ge0 ltW.
Qed.

(* The same in the other order, for 1 - phi. *)
Lemma power_renyi_reversed a rho t P Q : 1 < a -> law P -> law Q -> t < 1 -> renyi_le a rho Q P ->
  power_le t (1 - expR (- rho + a / (a - 1) * ln (1 - t))) P Q.
Proof.
move=> a1 lP lQ t1 rd phi te le.
have am : 0 < a - 1 by rewrite subr_gt0.
have exP : expect P (fun b => 1 - phi b) = 1 - expect P phi by rewrite expectB expect_cst.
have exQ : expect Q (fun b => 1 - phi b) = 1 - expect Q phi by rewrite expectB expect_cst.
have lt1 : 0 < 1 - t by rewrite subr_gt0.
have qt : 1 - t <= 1 - expect Q phi by rewrite ler_add2l ler_opp2.
have q0 : 0 < 1 - expect Q phi := lt_le_trans lt1 qt.
have := renyi_test a1 lQ lP rd (test_neg te); rewrite exP exQ => /(_ q0)[p0 h].
rewrite ler_subr_addr -ler_subr_addl -[X in _ <= X](expR_ln p0) ler_expR.
rewrite -(ler_pmul2l am) mulrDr mulrA mulrCA divff ?gt_eqF // mulr1.
have lq : ln (1 - t) <= ln (1 - expect Q phi) by rewrite ler_ln ?posrE.
have {}h : a * ln (1 - expect Q phi) - (a - 1) * rho <= (a - 1) * ln (1 - expect P phi).
  rewrite ler_subl_addr -ler_subl_addl; apply: le_trans h.
  by rewrite le_eqVlt; apply/orP; left; apply/eqP; ring.
apply: le_trans h; rewrite mulrN addrC ler_add2r ler_pmul2l //.
exact: lt_trans ltr01 a1.
Qed.

End Renyi.

(* A distribution function at hand: the logistic one.  (The Gaussian one is no instance only because the library of
   real numbers that is used here does not have it.) *)
Section Logistic.
Variable R : realType.
Implicit Types z p : R.

Definition logistic z : R := expR z / (1 + expR z).
Definition logit p : R := ln (p / (1 - p)).

Theorem logistic_distribution : distribution logistic logit.
Proof.
have den z : 0 < 1 + expR z :> R by rewrite addr_gt0 ?ltr01 ?expR_gt0.
have dn z : 1 + expR z != 0 :> R by rewrite gt_eqF.
have oneE z : 1 - logistic z = (1 + expR z)^-1.
  by rewrite /logistic -{1}(divff (dn z)) -mulrBl addrK mul1r.
split=> [z|z|p /andP[p0 p1]|z].
- by rewrite divr_gt0 ?expR_gt0 //= ltr_pdivr_mulr // mul1r ltr_addr ltr01.
- by rewrite /logit oneE invrK /logistic divfK // expK.
- have q0 : 0 < 1 - p by rewrite subr_gt0.
  rewrite /logistic /logit expR_ln ?divr_gt0 // -{2}(divff (lt0r_neq0 q0)) -mulrDl subrK.
  by rewrite div1r invrK divfK ?gt_eqF.
- have e0 := expR_gt0 z; rewrite oneE /logistic expRN; move: (expR z) e0 (dn z) => e e0 en.
  by field; rewrite en gt_eqF //= gt_eqF // addr_gt0.
Qed.

(* Pure privacy in both orders lies above the logistic curve with mu = 2 eps. *)
Theorem gdp_logistic (B : finType) eps (P Q : B -> R) : law P -> law Q ->
  pure_dp (expR eps) P Q -> pure_dp (expR eps) Q P -> gdp logistic logit (2%:R * eps) P Q.
Proof.
move=> lP lQ PQ QP phi te /andP[s0 s1]; set s := expect Q phi in s0 s1 *; set p := expect P phi.
have mono (P' Q' f : B -> R) : (forall b, 0 <= f b) -> pure_dp (expR eps) P' Q' -> expect P' f <= expR eps * expect Q' f.
  by move=> f0 d; rewrite /expect mulr_sumr; apply: ler_sum => b _; rewrite mulrA ler_wpmul2r ?d.
have ps : p <= expR eps * s by apply: mono => // b; case/andP: (te b).
have sp : 1 - s <= expR eps * (1 - p).
  have neg L : law L -> 1 - expect L phi = expect L (fun b => 1 - phi b) by move=> lL; rewrite expectB expect_cst.
  rewrite /s /p (neg _ lQ) (neg _ lP); apply: mono => // b.
  by rewrite subr_ge0; case/andP: (te b).
have k0 : 0 < expR eps := expR_gt0 _; have q0 : 0 < 1 - s by rewrite subr_gt0.
have p0 : 0 <= p by apply: expect_ge0 => // b; case/andP: (te b).
have -> : gdp_curve logistic logit (2%:R * eps) s = (1 - s) / (s * expR eps ^+ 2 + (1 - s)).
  have s1' : 1 - (1 - s) = s by ring.
  rewrite /gdp_curve /logistic /logit s1' expRD expR_ln ?divr_gt0 // expRN.
  have -> : expR (2%:R * eps) = expR eps ^+ 2 by rewrite -[2%:R]/(1 + 1) mulrDl mul1r expRD.
  by field; rewrite !gt_eqF //= ?expR_gt0 // addr_gt0 // mulr_gt0 // exprn_gt0.
rewrite ler_pdivr_mulr; last by rewrite addr_gt0 // mulr_gt0 // exprn_gt0.
rewrite -subr_ge0.
have -> : (1 - p) * (s * expR eps ^+ 2 + (1 - s)) - (1 - s) = expR eps * s * (expR eps * (1 - p)) - p * (1 - s) by ring.
by rewrite subr_ge0 ler_pmul // ltW.
Qed.

(* So T3_gdp has instances: randomized response over two values, with rows that differ. *)
Theorem gdp_coin eps : 0 <= eps ->
  kernel (coin_filter (expR eps)) /\ every_pair (gdp logistic logit (2%:R * eps)) (coin_filter (expR eps)).
Proof.
move=> e0; have k1 : 1 <= expR eps by rewrite -expR0 ler_expR.
have [k d _ _] := T12_sharp k1 (lexx 1).
by split=> // a a'; apply: gdp_logistic => //; apply: d.
Qed.

End Logistic.

Section T3.
Variables (R : realType) (X Xt A At U : finType).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R) (g : U -> X -> A -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (kT : policy T).
Local Notation E := (utility (induced MX MA T) g).

(* T1, the paper's form in nats: L <= eps + log(1 + (K + delta gamma)/tau). *)
Theorem T1_paper_log gamma eps delta K tau x a a' :
  0 <= gamma -> 0 <= delta -> valued 0 gamma g ->
  (forall u x a a', `|g u x a - g u x a'| <= K) -> 0 <= K -> 0 <= eps ->
  every_pair (dp (expR eps) delta) MA -> 0 < tau -> has_floor tau E ->
  ln (E x a / E x a') <= eps + ln (1 + (K + delta * gamma) / tau).
Proof.
move=> g0 d0 vg gK K0 e0 d t0 fl.
have k1 : 1 <= expR eps by rewrite -expR0 ler_expR.
have p c : 0 < E x c := lt_le_trans t0 (fl x c).
have c0 : 0 < 1 + (K + delta * gamma) / tau.
  by rewrite ltr_paddr // divr_ge0 ?(ltW t0) // addr_ge0 // mulr_ge0.
rewrite -ler_expR expRD !expR_ln // ?divr_gt0 // ler_pdivr_mulr //.
exact: (T1_paper kX kA kT g0 d0 vg gK K0 k1 d t0 fl).
Qed.

(* T2 in nats: L <= eps. *)
Theorem T2_log eps x a a' : (forall u x a, 0 <= g u x a) -> a_free g ->
  every_pair (pure_dp (expR eps)) MA -> 0 < E x a -> 0 < E x a' -> ln (E x a / E x a') <= eps.
Proof.
move=> g0 fg d p p'; rewrite -ler_expR expR_ln ?divr_gt0 // ler_pdivr_mulr //.
exact: (T2_pure kX kT g0 fg d).
Qed.

(* tanh(L/2) for L = log r is (r - 1)/(r + 1). *)
Definition tanh (z : R) : R := (expR z - expR (- z)) / (expR z + expR (- z)).

Lemma tanh_halfE r : 0 < r -> tanh (ln r / 2%:R) = tanh_half r.
Proof.
move=> r0; pose s := expR (ln r / 2%:R); have s0 : 0 < s := expR_gt0 _.
have sn : s != 0 by rewrite gt_eqF.
have ss : s * s = r by rewrite /s -expRD -mulrDl -mulr2n -mulr_natr mulfK ?pnatr_eq0 // expR_ln.
rewrite /tanh /tanh_half expRN -/s -ss.
have -> : s * s - 1 = s * (s - s^-1) by rewrite mulrBr divff.
have -> : s * s + 1 = s * (s + s^-1) by rewrite mulrDr divff.
by rewrite -mulf_div divff // mul1r.
Qed.

(* T12 as on the page: tanh(L/2) <= tanh(L0/2) tanh(eps/2). *)
Theorem T12_tanh_log eps r x a a' : 0 <= eps -> 1 <= r -> (forall u x a, 0 <= g u x a) -> a_free g ->
  (forall x a b b', response MX T g x a b <= r * response MX T g x a b') ->
  every_pair (pure_dp (expR eps)) MA -> 0 < E x a -> 0 < E x a' ->
  tanh (ln (E x a / E x a') / 2%:R) <= tanh (ln r / 2%:R) * tanh (eps / 2%:R).
Proof.
move=> e0 r1 g0 fg hr d p p'; have k1 : 1 <= expR eps by rewrite -expR0 ler_expR.
have -> : eps = ln (expR eps) by rewrite expK.
have r0 : 0 < r := lt_le_trans ltr01 r1.
rewrite !tanh_halfE ?divr_gt0 ?expR_gt0 //.
by apply: T12_tanh_pair.
Qed.

Variables (gamma t : R).
Hypotheses (g0 : 0 < gamma) (vg : valued 0 gamma g) (fg : a_free g) (t0 : 0 < t).
Hypothesis fl : has_floor (t * gamma) E.

Let t_inv : t^-1 = expR (- ln t). Proof. by rewrite expRN expR_ln. Qed.

(* T3 under Renyi privacy of order a: R <= e^((a-1) rho / a) t^(-1/a). *)
Theorem T3_renyi a rho : 1 < a -> every_pair (renyi_le a rho) MA ->
  local_le (expR ((a - 1) * rho / a) * expR (- ln t / a)) E.
Proof.
move=> a1 rd x c c'; have an : a != 0 by rewrite gt_eqF // (lt_trans ltr01).
have -> : expR ((a - 1) * rho / a) * expR (- ln t / a) = expR ((a - 1) * (rho + ln t) / a) / t.
  rewrite t_inv -!expRD; congr expR; apply: (mulIf an); rewrite !mulrDl !divfK //.
  by ring.
apply: (T3_power kX kA kT g0 vg fg t0 _ (fl x c')).
exact: power_renyi.
Qed.

(* ... and R <= (1 - e^(-rho) (1-t)^(a/(a-1)))/t. *)
Theorem T3_renyi_reversed a rho : 1 < a -> t < 1 -> every_pair (renyi_le a rho) MA ->
  local_le ((1 - expR (- rho) * expR (a / (a - 1) * ln (1 - t))) / t) E.
Proof.
move=> a1 t1 rd x c c'; rewrite -expRD.
apply: (T3_power kX kA kT g0 vg fg t0 _ (fl x c')).
exact: power_renyi_reversed.
Qed.

(* T3 under rho-zCDP: log R <= 2 sqrt(rho log(1/t)) - rho if rho < log(1/t). *)
Theorem T3_zcdp rho : 0 < rho -> rho < ln t^-1 -> every_pair (zcdp rho) MA ->
  local_le (expR (2%:R * Num.sqrt (rho * ln t^-1) - rho)) E.
Proof.
move=> r0 rl z; have lp : 0 < ln t^-1 := lt_trans r0 rl.
have lE : ln t = - ln t^-1 by rewrite lnV ?posrE // opprK.
pose s := Num.sqrt rho; pose r := Num.sqrt (ln t^-1).
have s0 : 0 < s by rewrite sqrtr_gt0.
have q0 : 0 < r by rewrite sqrtr_gt0.
have sn : s != 0 by rewrite gt_eqF.
have rn : r != 0 by rewrite gt_eqF.
have s2 : s * s = rho by rewrite -expr2 sqr_sqrtr // ltW.
have r2 : r * r = ln t^-1 by rewrite -expr2 sqr_sqrtr // ltW.
pose a := r / s; have an : a != 0 by rewrite mulf_neq0 // invr_eq0.
have a1 : 1 < a by rewrite ltr_pdivl_mulr // mul1r ltr_sqrt.
have main := @T3_renyi a (rho * a) a1 (fun c c' => z c c' a a1).
rewrite (_ : expR _ = expR ((a - 1) * (rho * a) / a) * expR (- ln t / a)) //.
rewrite -expRD; congr expR; rewrite sqrtrM ?(ltW r0) // -/s -/r.
rewrite (mulrA _ rho a) mulfK // lE opprK -r2 -s2 /a invf_div.
have -> : r * r * (s / r) = r * s by rewrite mulrACA [r / r]divff ?mulr1.
have -> : (r / s - 1) * (s * s) = r * s - s * s.
  by rewrite mulrBl mul1r mulrA divfK.
by ring.
Qed.

(* ... and R <= (1 - e^(-(sqrt rho + sqrt log(1/(1-t)))^2))/t. *)
Theorem T3_zcdp_reversed rho : 0 < rho -> t < 1 -> every_pair (zcdp rho) MA ->
  local_le ((1 - expR (- (Num.sqrt rho + Num.sqrt (ln (1 - t)^-1)) ^+ 2)) / t) E.
Proof.
move=> r0 t1 z; have u0 : 0 < 1 - t by rewrite subr_gt0.
have lE : ln (1 - t) = - ln (1 - t)^-1 by rewrite lnV ?posrE // opprK.
have lp : 0 < ln (1 - t)^-1.
  by rewrite ln_gt0 // invf_gt1 // ltr_subl_addr ltr_addl.
pose s := Num.sqrt rho; pose r := Num.sqrt (ln (1 - t)^-1).
have s0 : 0 < s by rewrite sqrtr_gt0.
have q0 : 0 < r by rewrite sqrtr_gt0.
have sn : s != 0 by rewrite gt_eqF.
have rn : r != 0 by rewrite gt_eqF.
have s2 : s * s = rho by rewrite -expr2 sqr_sqrtr // ltW.
have r2 : r * r = ln (1 - t)^-1 by rewrite -expr2 sqr_sqrtr // ltW.
pose a := 1 + r / s; have a1 : 1 < a by rewrite ltr_addl divr_gt0.
have main := @T3_renyi_reversed a (rho * a) a1 t1 (fun c c' => z c c' a a1).
rewrite (_ : expR _ = expR (- (rho * a)) * expR (a / (a - 1) * ln (1 - t))) //.
rewrite -expRD; congr expR; rewrite -/s -/r lE -r2 -s2.
have -> : a - 1 = r / s by rewrite /a addrAC subrr add0r.
have -> : s * s * a = s * s + s * r by rewrite /a mulrDr mulr1 -mulrA [s * (r / s)]mulrC divfK.
have -> : a / (r / s) * - (r * r) = - (r * r + s * r).
  rewrite mulrN; congr (- _); rewrite invf_div /a mulrDl mul1r.
  have -> : r / s * (s / r) = 1 by rewrite mulrA divfK // divff.
  by rewrite mulrDl mul1r [s / r * _]mulrA divfK // addrC.
by ring.
Qed.

End T3.
