(* T4: a utility that ignores the group and has a floor m of its own. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T1 T3.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section T4.
Variables (R : realFieldType) (X Xt A At U : finType).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R) (g : U -> X -> A -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (kT : policy T).

Local Notation E := (utility (induced MX MA T) g).
Local Notation H k a a' := (hockey_stick k (MA a) (MA a')).

(* T4, one k: R <= k + max(0, (gamma - m) H_k - (k - 1) m)/tau. *)
Theorem T4_one_k m gamma tau k x a a' : valued m gamma g -> a_free g -> 0 < tau -> tau <= E x a' ->
  E x a <= (k + Num.max 0 ((gamma - m) * H k a a' - (k - 1) * m) / tau) * E x a'.
Proof.
move=> vg fg t0 te; apply: ratio_of_additive => //; first by rewrite le_maxr lexx.
have := hockey_stick_ranged k (kA a) (kA a') (response_ranged x a' kX kT vg).
rewrite -utility_response -addrA (_ : expect _ _ = E x a); last first.
  by rewrite utility_response; apply: eq_expect => // b; apply: response_free.
by move/le_trans; apply; rewrite ler_add2l le_maxr lexx orbT.
Qed.

(* T4 without any assumption about the policy: tau := m > 0 is a floor by itself. *)
Theorem T4_any_policy m gamma k x a a' : valued m gamma g -> a_free g -> 0 < m ->
  E x a <= (k + Num.max 0 ((gamma - m) * H k a a' - (k - 1) * m) / m) * E x a'.
Proof.
move=> vg fg m0; apply: T4_one_k => //.
by case/andP: (utility_ranged kX kA kT x a' vg).
Qed.

(* T4, first form: R is at most the greatest of (m + (gamma - m)(1 - f(s)))/(m + (gamma - m)s) over s >= s0. *)
Theorem T4_tradeoff m gamma tau f r : 0 < m -> m < gamma -> valued m gamma g -> a_free g ->
  every_pair (above f) MA -> has_floor tau E ->
  (forall s, (tau - m) / (gamma - m) <= s -> 0 <= s -> s <= 1 ->
     (m + (gamma - m) * (1 - f s)) / (m + (gamma - m) * s) <= r) ->
  local_le r E.
Proof.
move=> m0 mg vg fg ab fl sup x a a'.
have w0 : 0 < gamma - m by rewrite subr_gt0.
pose h := response MX T g x a'; pose phi b := (gamma - m)^-1 * (h b - m).
have tphi : test phi.
  move=> b; case/andP: (response_ranged x a' kX kT vg b) => l u.
  rewrite /phi mulr_ge0 ?invr_ge0 ?(ltW w0) ?subr_ge0 //= mulrC ler_pdivr_mulr // mul1r.
  by rewrite ler_add2r.
have eE c : expect (MA c) h = m + (gamma - m) * expect (MA c) phi.
  by rewrite expectZ mulVKf ?gt_eqF // expectB expect_cst // addrCA subrr addr0.
have ea : E x a = expect (MA a) h.
  by rewrite utility_response; apply: eq_expect => // b; apply: response_free.
have ea' : E x a' = expect (MA a') h by rewrite utility_response.
have := fl x a'; rewrite ea ea' !eE; set p := expect _ phi; set s := expect (MA a') phi => te.
have /andP[s0 s1] : 0 <= s <= 1 := expect_ranged (kA a') tphi.
have d0 : 0 < m + (gamma - m) * s by rewrite ltr_paddr // mulr_ge0 // ltW.
rewrite -ler_pdivr_mulr //; apply: le_trans (sup s _ s0 s1).
  rewrite ler_pmul2r ?invr_gt0 // ler_add2l ler_pmul2l // ler_subr_addl -ler_subr_addr.
  exact: ab.
by rewrite ler_pdivr_mulr // ler_subl_addl mulrC.
Qed.

End T4.

(* ---- The one-k form of T4 is exact for a known pair of rows ---- *)

Section Exact.
Variables (R : realFieldType) (B : finType) (P Q : B -> R) (m gamma tau : R).
Hypotheses (lP : law P) (lQ : law Q) (m0 : 0 < m) (mg : m < gamma) (m_tau : m <= tau) (tau_g : tau <= gamma).
Local Notation w := (gamma - m).
Let w0 : 0 < w. Proof. by rewrite subr_gt0. Qed.

(* The part of the certificate above k. *)
Definition excess (k : R) : R := w * hockey_stick k P Q - (k - 1) * m.

(* Of all k, some k has excess 0, and the event {P > kQ} attains the ratio k. *)
Lemma excess_zero : exists k, [/\ 0 <= k, excess k = 0 &
  let S := [set b | k * Q b < P b] in m + w * prob P S = k * (m + w * prob Q S)].
Proof.
pose num (S : {set B}) := m + w * prob P S; pose den (S : {set B}) := m + w * prob Q S.
have n0 S : 0 < num S.
  by rewrite ltr_paddr // mulr_ge0 ?(ltW w0) // sumr_ge0 // => b _; case: lP.
have d0 S : 0 < den S.
  by rewrite ltr_paddr // mulr_ge0 ?(ltW w0) // sumr_ge0 // => b _; case: lQ.
have [S _ Smax] := @arg_maxP _ _ _ set0 xpredT (fun S => num S / den S) isT.
set k := num S / den S in Smax; exists k.
have kS V : num V <= k * den V by rewrite -ler_pdivr_mulr //; apply: Smax.
have kE : num S = k * den S by rewrite /k divfK // gt_eqF.
have exc V : w * (prob P V - k * prob Q V) - (k - 1) * m = num V - k * den V by rewrite /num /den; ring.
pose V := [set b | k * Q b < P b].
have eV : excess k = num V - k * den V by rewrite /excess hockey_stick_attained exc.
have z : excess k = 0.
  apply: le_anti; rewrite {1}eV subr_le0 kS /=.
  have := hockey_stick_test k P Q (test_indicator R S); rewrite -!prob_expect -ler_subl_addl => h.
  have : 0 <= num S - k * den S by rewrite kE subrr.
  by rewrite -exc => /le_trans; apply; rewrite /excess ler_add2r ler_pmul2l.
split=> //; first by rewrite divr_ge0 // ltW.
by apply/eqP; rewrite -subr_eq0 -[_ - _]/(num V - k * den V) -eV z.
Qed.

Lemma excess_mono k k' : k <= k' -> excess k' <= excess k.
Proof.
move=> kk; rewrite /excess ler_sub //; last by rewrite ler_pmul2r // ler_add2r.
rewrite ler_pmul2l //; apply: ler_sum => b _; rewrite le_maxl le_maxr lexx /= le_maxr.
by apply/orP; right; rewrite ler_add2l ler_opp2 ler_wpmul2r //; case: lQ.
Qed.

(* T4 is exact: some k and some response m + (gamma - m) phi turn its certificate into an equality. *)
Theorem T4_certificate_exact : exists k phi, let h := fun b => m + w * phi b in
  [/\ 0 <= k, test phi, tau <= expect Q h & expect P h = (k + Num.max 0 (excess k) / tau) * expect Q h].
Proof.
have hE L phi : law L -> expect L (fun b => m + w * phi b) = m + w * expect L phi.
  by move=> lL; rewrite expectD expectZ expect_cst.
have t0 : 0 < tau := lt_le_trans m0 m_tau.
have [k [k0 ke kS]] := excess_zero; set S := [set b | _ < _] in kS.
have by_zero : tau <= m + w * prob Q S -> exists k phi, let h := fun b => m + w * phi b in
  [/\ 0 <= k, test phi, tau <= expect Q h & expect P h = (k + Num.max 0 (excess k) / tau) * expect Q h].
  move=> fl; exists k, (fun b => (b \in S)%:R) => /=; rewrite !hE // -!prob_expect ke maxxx mul0r addr0.
  by split=> //; apply: test_indicator.
move: m_tau; rewrite le_eqVlt => /orP[/eqP e|mt].
  apply: by_zero; rewrite -e ler_addl mulr_ge0 ?(ltW w0) // sumr_ge0 // => b _.
  by case: lQ.
pose s := (tau - m) / w; have s0 : 0 < s by rewrite divr_gt0 // subr_gt0.
have s1 : s <= 1 by rewrite ler_pdivr_mulr // mul1r ler_add2r.
have sE : m + w * s = tau by rewrite /s mulrC divfK ?gt_eqF // addrCA subrr addr0.
have [k1 [k10 kc lo hi]] := threshold lP lQ s0 s1.
have [phi [te eQ eP]] := threshold_test lQ s0 lo hi.
case: (leP 0 (excess k1)) => ex.
  exists k1, phi; rewrite /= !hE // eQ eP sE; split=> //.
  rewrite (max_idPr ex) !mulrDl !divfK ?gt_eqF // /excess -sE.
  by ring.
have kk : k < k1 by rewrite ltNge; apply/negP => /excess_mono; rewrite ke leNgt ex.
apply: by_zero; rewrite -sE ler_add2l ler_pmul2l //; apply: le_trans hi _.
rewrite !prob_expect; apply: ler_sum => b _; rewrite !inE.
have Q0 : 0 <= Q b by case: lQ.
have [e|qn] := eqVneq (Q b) 0; first by rewrite e !mul0r.
apply: ler_wpmul2l => //; case: (leP (k1 * Q b) (P b)) => h; last by rewrite ler0n.
by rewrite (lt_le_trans _ h) // ltr_pmul2r // lt_def qn.
Qed.

End Exact.
