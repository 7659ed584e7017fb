(* T13 when of the utility only a range is known: values in [m, gamma], and for two groups at most L apart.

   K is the smaller of L and gamma - m.  One number decides for every policy and every such utility: K + (gamma - K - m) H_V <= m (V - 1). *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T1 T13.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Range.
Variables (R : realFieldType) (m gamma L : R).
Implicit Types (k V tau : R).

Definition gap : R := Num.min L (gamma - m).

(* K + (gamma - K - m) H_k - (k - 1) m: what a numerator can exceed k times its denominator by. *)
Definition range_excess (B : finType) (P Q : B -> R) k : R :=
  gap + (gamma - gap - m) * hockey_stick k P Q - (k - 1) * m.

(* Responses h of one group and h' of the other, as far apart as the range allows. *)
Lemma range_le (B : finType) (P Q h h' : B -> R) k : law P -> law Q -> 0 <= k ->
  ranged m gamma h -> ranged m gamma h' -> (forall b, h b <= h' b + L) ->
  expect P h <= k * expect Q h' + range_excess P Q k.
Proof.
move=> lP lQ k0 rh rh' hL; pose w b := Num.min (gamma - gap) (h' b).
have hw b : h b <= gap + w b.
  case/andP: (rh b) => m_h h_g; case/andP: (rh' b) => m_h' h_g'; rewrite /w /gap.
  rewrite -ler_subl_addl le_minr; apply/andP; split; first by rewrite ler_add2r.
  rewrite ler_subl_addr; case: (leP L (gamma - m)) => _; first exact: hL.
  by rewrite addrCA (le_trans h_g) // ler_addl subr_ge0.
have wh b : w b <= h' b by rewrite le_minl lexx orbT.
have rw : ranged m (gamma - gap) w.
  move=> b; case/andP: (rh' b) => m_h' _; rewrite le_minr m_h' andbT le_minl lexx /= andbT.
  by rewrite ler_subr_addr addrC -ler_subr_addr /gap le_minl lexx orbT.
apply: (@le_trans _ _ (gap + expect P w)); first by rewrite -{1}(expect_cst gap lP) -expectD; apply: expect_le.
rewrite /range_excess -!addrA [leRHS]addrCA ler_add2l.
apply: le_trans (hockey_stick_ranged k lP lQ rw) _; rewrite -!addrA ler_add2r.
by apply: ler_wpmul2l => //; apply: expect_le.
Qed.

(* Sharp: responses that differ as much as the range allows, where it helps the numerator. *)
Definition high (B : finType) (P Q : B -> R) k b : R := if k * Q b <= P b then gamma else m + gap.
Definition low (B : finType) (P Q : B -> R) k b : R := if k * Q b <= P b then gamma - gap else m.

Lemma gap_ge0 : 0 <= L -> m <= gamma -> 0 <= gap.
Proof. by move=> L0 mg; rewrite le_minr L0 subr_ge0. Qed.

Lemma high_low (B : finType) (P Q : B -> R) k : 0 <= L -> m <= gamma ->
  [/\ ranged m gamma (high P Q k), ranged m gamma (low P Q k) & forall b, `|high P Q k b - low P Q k b| <= L].
Proof.
move=> L0 mg; have K0 := gap_ge0 L0 mg; have KL : gap <= L by rewrite le_minl lexx.
have Kw : gap <= gamma - m by rewrite le_minl lexx orbT.
split=> b; rewrite /high /low; case: ifP => _.
- by rewrite mg lexx.
- by rewrite ler_addl K0 addrC -ler_subr_addr.
- by rewrite ler_subr_addr addrC -ler_subr_addr Kw ler_subl_addr ler_addl.
- by rewrite lexx mg.
- by rewrite opprB addrCA subrr addr0 ger0_norm.
- by rewrite addrC addKr ger0_norm.
Qed.

Lemma high_low_excess (B : finType) (P Q : B -> R) k : law P -> law Q ->
  expect P (high P Q k) - k * expect Q (low P Q k) = range_excess P Q k.
Proof.
move=> lP lQ; rewrite /range_excess.
have -> : gap + (gamma - gap - m) * hockey_stick k P Q - (k - 1) * m =
    \sum_b (P b * gap + (gamma - gap - m) * Num.max 0 (P b - k * Q b) + (P b - k * Q b) * m).
  rewrite !big_split /= -!mulr_suml -mulr_sumr sumrB -mulr_sumr (proj2 lP) (proj2 lQ).
  by rewrite -[\sum_b Num.max _ _]/(hockey_stick k P Q); move: (hockey_stick k P Q) => H; ring.
rewrite /expect mulr_sumr -sumrB; apply: eq_bigr => b _; rewrite /high /low.
case: (leP (k * Q b) (P b)) => h.
  by rewrite (max_idPr _) ?subr_ge0 //; ring.
by rewrite (max_idPl _) ?subr_le0 ?ltW //; ring.
Qed.

(* From the excess to a bound: without a floor, and over one. *)
Lemma range_valid (B : finType) (P Q : B -> R) V : gap + (gamma - gap - m) * hockey_stick V P Q <= m * (V - 1) ->
  range_excess P Q V <= 0.
Proof. by rewrite /range_excess subr_le0 (mulrC m). Qed.

End Range.

(* ---- Policies behind filters ---- *)

Section Behind.
Variables (R : realFieldType) (X Xt A At U : finType).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R) (g : U -> X -> A -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (kT : policy T).
Implicit Types (m gamma L k V tau : R).
Local Notation E := (utility (induced MX MA T) g).
Local Notation H k a a' := (hockey_stick k (MA a) (MA a')).

Section Context.
Variables (x : X) (a a' : A) (m gamma L : R).

(* In context x: what is declared of the utility, of which nothing else is used. *)
Hypotheses (rg : forall u, m <= g u x a <= gamma) (rg' : forall u, m <= g u x a' <= gamma).
Hypothesis gL : forall u, g u x a <= g u x a' + L.
Local Notation K := (gap m gamma L).

Lemma response_in (c : A) : (forall u, m <= g u x c <= gamma) -> ranged m gamma (response MX T g x c).
Proof.
move=> rc b; rewrite response_expect; apply: expect_ranged => // y.
by apply: expect_ranged => //; apply: kT.
Qed.

Lemma range_one_k k : 0 <= k -> E x a <= k * E x a' + range_excess m gamma L (MA a) (MA a') k.
Proof.
move=> k0; rewrite !utility_response; apply: range_le => //; [exact: response_in|exact: response_in|].
by move=> b; apply: response_le.
Qed.

(* T13 for any utility of a range, every policy. *)
Theorem T13_range V : 0 <= V -> K + (gamma - K - m) * H V a a' <= m * (V - 1) -> E x a <= V * E x a'.
Proof. by move=> V0 /range_valid h; apply: le_trans (range_one_k V0) _; rewrite -[leRHS]addr0 ler_add2l. Qed.

(* The same for every policy that keeps a floor. *)
Theorem T13_range_floor tau k : 0 <= k -> 0 < tau -> tau <= E x a' ->
  E x a <= (k + Num.max 0 (K + (gamma - K - m) * H k a a' - (k - 1) * m) / tau) * E x a'.
Proof.
move=> k0 t0 te; apply: ratio_of_additive => //; first by rewrite le_maxr lexx.
by apply: le_trans (range_one_k k0) _; rewrite ler_add2l le_maxr lexx orbT.
Qed.

(* The cap gamma/tau. *)
Theorem T13_range_cap tau : 0 <= gamma -> 0 < tau -> tau <= E x a' -> E x a <= gamma / tau * E x a'.
Proof.
move=> g0 t0 te; apply: le_trans (ler_wpmul2l (divr_ge0 g0 (ltW t0)) te); rewrite divfK ?gt_eqF //.
by rewrite utility_response; case/andP: (expect_ranged (kA a) (response_in rg)).
Qed.

End Context.

(* Group means: the rows P(x|a) M_A(b|a). *)
Section Means.
Variables (W : A -> X -> R) (m gamma L : R).
Hypotheses (kW : kernel W) (vg : valued m gamma g).
Hypothesis gL : forall u x a a', g u x a <= g u x a' + L.
Local Notation M := (group_mean W E).
Local Notation K := (gap m gamma L).

Definition mean_row (a : A) (xb : X * At) : R := W a xb.1 * MA a xb.2.

Lemma law_mean_row a : law (mean_row a).
Proof. exact: (kernel_both kW kA (a, a)). Qed.

Lemma mean_response a : M a = expect (mean_row a) (fun xb => response MX T g xb.1 a xb.2).
Proof.
rewrite /group_mean /expect -(pair_bigA _ (fun x b => mean_row a (x, b) * response MX T g x a b)) /=.
apply: eq_bigr => x _; rewrite utility_response mulr_sumr; apply: eq_bigr => b _.
by rewrite mulrA.
Qed.

Lemma range_one_k_mean a a' k : 0 <= k ->
  M a <= k * M a' + range_excess m gamma L (mean_row a) (mean_row a') k.
Proof.
move=> k0; rewrite !mean_response; apply: range_le => //; try exact: law_mean_row.
- by move=> xb; apply: response_ranged.
- by move=> xb; apply: response_ranged.
by move=> xb; apply: response_le.
Qed.

Theorem T13_range_global V a a' : 0 <= V ->
  K + (gamma - K - m) * hockey_stick V (mean_row a) (mean_row a') <= m * (V - 1) -> M a <= V * M a'.
Proof. by move=> V0 /range_valid h; apply: le_trans (range_one_k_mean a a' V0) _; rewrite -[leRHS]addr0 ler_add2l. Qed.

Theorem T13_range_floor_global tau k a a' : 0 <= k -> 0 < tau -> tau <= M a' ->
  M a <= (k + Num.max 0 (K + (gamma - K - m) * hockey_stick k (mean_row a) (mean_row a') - (k - 1) * m) / tau) * M a'.
Proof.
move=> k0 t0 te; apply: ratio_of_additive => //; first by rewrite le_maxr lexx.
by apply: le_trans (range_one_k_mean a a' k0) _; rewrite ler_add2l le_maxr lexx orbT.
Qed.

Theorem T13_range_cap_global tau a a' : 0 <= gamma -> 0 < tau -> tau <= M a' -> M a <= gamma / tau * M a'.
Proof.
move=> g0 t0 te; apply: le_trans (ler_wpmul2l (divr_ge0 g0 (ltW t0)) te); rewrite divfK ?gt_eqF //.
rewrite mean_response; have r xb : m <= response MX T g xb.1 a xb.2 <= gamma by apply: response_ranged.
by case/andP: (expect_ranged (law_mean_row a) r).
Qed.

End Means.
End Behind.

(* ---- Sharp, if the decisions tell the released values apart ---- *)

Section Sharp.
Variables (R : realFieldType) (A At : finType) (MA : A -> At -> R) (a a' : A) (m gamma L V : R).
Hypotheses (kA : kernel MA) (aa' : a != a') (m0 : 0 <= m) (mg : m <= gamma) (L0 : 0 <= L).

(* The decision is the released value; group a has the high utility, all others the low one. *)
Definition telling (_ : unit) (b : At) : At -> R := point R b.
Definition telling_utility (u : At) (_ : unit) (c : A) : R :=
  if c == a then high m gamma L (MA a) (MA a') V u else low m gamma L (MA a) (MA a') V u.

Theorem T13_range_sharp :
  let E := utility (induced (@no_context R unit_finType) MA telling) telling_utility tt in
  [/\ policy telling, valued m gamma telling_utility, (forall u x c c', `|telling_utility u x c - telling_utility u x c'| <= L) &
      E a - V * E a' = gap m gamma L + (gamma - gap m gamma L - m) * hockey_stick V (MA a) (MA a') - (V - 1) * m].
Proof.
have [rh rl hl] := high_low (MA a) (MA a') V L0 mg; split.
- by move=> y b; apply: law_point.
- by move=> u x c; rewrite /telling_utility; case: (c == a); [apply: rh|apply: rl].
- move=> u x c c'; rewrite /telling_utility; case: (c == a); case: (c' == a); rewrite ?subrr ?normr0 ?hl //.
  by rewrite distrC hl.
have e c : utility (induced (@no_context R unit_finType) MA telling) telling_utility tt c =
    expect (MA c) (fun b => telling_utility b tt c).
  rewrite utility_response; apply: eq_expect => // b; rewrite /response big_unit.
  under eq_bigr do rewrite /no_context mul1r; exact: (expect_point (fun u => telling_utility u tt c) b).
rewrite !e -[RHS](high_low_excess m gamma L V (kA a) (kA a')); congr (_ - V * _); apply: eq_expect => // b.
  by rewrite /telling_utility eqxx.
by rewrite /telling_utility eq_sym (negbTE aa').
Qed.

End Sharp.
