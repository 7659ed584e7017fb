(* Privacy of one ordered pair of rows: the three ways to state (eps, delta) are one. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section DP.
Variables (R : realFieldType) (A : finType).
Implicit Types (P Q phi : A -> R) (k t : R).

Lemma hockey_stick_ge0 k P Q : 0 <= hockey_stick k P Q.
Proof. by apply: sumr_ge0 => a _; rewrite le_maxr lexx. Qed.

(* The event on which P exceeds kQ attains the hockey stick ... *)
Lemma hockey_stick_attained k P Q :
  hockey_stick k P Q = prob P [set a | k * Q a < P a] - k * prob Q [set a | k * Q a < P a].
Proof.
rewrite !prob_expect expect_diff; apply: eq_bigr => a _; rewrite inE.
case: (ltP (k * Q a) (P a)) => h; rewrite ?mulr1 ?mulr0.
  by apply/max_idPr; rewrite subr_ge0 ltW.
by apply/max_idPl; rewrite subr_le0.
Qed.

(* ... and no test, randomized or not, exceeds it. *)
Lemma hockey_stick_test k P Q phi :
  test phi -> expect P phi <= k * expect Q phi + hockey_stick k P Q.
Proof.
move=> t; rewrite -ler_subl_addl expect_diff; apply: ler_sum => a _.
case/andP: (t a) => p0 p1; case: (leP 0 (P a - k * Q a)) => h.
  by rewrite ler_pimulr.
by rewrite nmulr_rle0.
Qed.

(* The same for a response with values in [m, gamma]. *)
Lemma hockey_stick_ranged k m gamma P Q (h : A -> R) : law P -> law Q -> ranged m gamma h ->
  expect P h <= k * expect Q h + (gamma - m) * hockey_stick k P Q - (k - 1) * m.
Proof.
move=> lP lQ rh; rewrite -addrA -ler_subl_addl.
rewrite (_ : (k - 1) * m = - (expect P (fun=> m) - k * expect Q (fun=> m))); last first.
  by rewrite !expect_cst //; ring.
rewrite opprK -ler_subl_addr !expect_diff -sumrB /hockey_stick mulr_sumr; apply: ler_sum => a _.
case/andP: (rh a) => h0 h1; rewrite -mulrBr; case: (leP 0 (P a - k * Q a)) => pos.
  by rewrite mulrC ler_wpmul2r // ler_add2r.
by rewrite mulr0 nmulr_rle0 // subr_ge0.
Qed.

(* Section 2 (definition): H_k is the least delta for which the pair is (log k, delta)-private. *)
Theorem dp_hockey_stick k delta P Q : dp k delta P Q <-> hockey_stick k P Q <= delta.
Proof.
split=> [d|h S]; first by rewrite hockey_stick_attained ler_subl_addl; exact: d.
rewrite !prob_expect; apply: le_trans (hockey_stick_test k P Q (test_indicator R S)) _.
by rewrite ler_add2l.
Qed.

(* Section 3: the inequality over events is the inequality over all utilities with values in [0, gamma]. *)
Theorem dp_functions k delta gamma P Q : 0 < gamma ->
  (dp k delta P Q <->
   forall g : A -> R, ranged 0 gamma g -> expect P g <= k * expect Q g + delta * gamma).
Proof.
move=> g0; split=> [/dp_hockey_stick h g rg|h S].
  have tg : test (fun a => gamma^-1 * g a).
    move=> a; case/andP: (rg a) => ga0 gag.
    by rewrite mulr_ge0 ?invr_ge0 ?(ltW g0) //= mulrC ler_pdivr_mulr // mul1r.
  have := hockey_stick_test k P Q tg; rewrite !expectZ => le.
  rewrite -(ler_pmul2l (x := gamma^-1)) ?invr_gt0 //; apply: le_trans le _.
  rewrite mulrDr mulrCA ler_add2l mulrC -mulrA divff ?mulr1 //.
  by rewrite gt_eqF.
have rS : ranged 0 gamma (fun a => gamma * (a \in S)%:R).
  by move=> a; case: (a \in S); rewrite ?mulr1 ?mulr0 ?lexx ?(ltW g0).
have := h _ rS; rewrite !expectZ -!prob_expect mulrCA (mulrC delta) -mulrDr.
by rewrite ler_pmul2l.
Qed.

(* Section 2: bounded likelihood ratios are (eps, 0)-privacy. *)
Theorem pure_dp_dp k P Q : pure_dp k P Q <-> dp k 0 P Q.
Proof.
split=> [h|h a].
  by apply/dp_hockey_stick; rewrite /hockey_stick big1 // => a _; apply/max_idPl; rewrite subr_le0.
by have := h [set a]; rewrite /prob !big_set1 addr0.
Qed.

(* Weaker parameters stay valid. *)
Lemma dp_weaken k k' delta delta' P Q :
  law Q -> k <= k' -> delta <= delta' -> dp k delta P Q -> dp k' delta' P Q.
Proof.
move=> [Q0 _] kk dd h S; apply: le_trans (h S) _; apply: ler_add => //.
by apply: ler_wpmul2r => //; apply: sumr_ge0.
Qed.

(* H_0 = 1: k = 0 is the cap 1/t. *)
Lemma hockey_stick0 P Q : law P -> hockey_stick 0 P Q = 1.
Proof.
move=> [P0 <-]; apply: eq_bigr => a _; rewrite mul0r subr0.
by apply/max_idPr.
Qed.

(* A law cannot be private below eps = 0 without delta. *)
Lemma pure_dp_ge1 k P Q : law P -> law Q -> pure_dp k P Q -> 1 <= k.
Proof.
move=> [_ P1] [_ Q1] h; rewrite -P1 -[k]mulr1 -Q1 mulr_sumr.
by apply: ler_sum.
Qed.

(* Total variation is symmetric. *)
Lemma tv_sym P Q : law P -> law Q -> tv P Q = tv Q P.
Proof.
move=> [_ P1] [_ Q1]; apply/eqP; rewrite -subr_eq0 -sumrB.
rewrite (eq_bigr (fun a => P a - Q a)) => [|a _]; first by rewrite sumrB P1 Q1 subrr.
rewrite !mul1r -(opprB (P a)); case: (leP 0 (P a - Q a)) => h.
  by rewrite (_ : Num.max 0 (- _) = 0) ?subr0 //; apply/max_idPl; rewrite oppr_le0.
by rewrite sub0r (_ : Num.max 0 (- _) = - (P a - Q a)) ?opprK //; apply/max_idPr; rewrite oppr_ge0 ltW.
Qed.

End DP.

Section Products.
Variables (R : realFieldType) (A A' : finType).

(* Section 2: likelihood ratios of tuples multiply, so the budgets of the attributes that differ add. *)
Theorem pure_dp_products k k' (P Q : A -> R) (P' Q' : A' -> R) :
  (forall a, 0 <= P a) -> (forall a, 0 <= P' a) -> (forall a, 0 <= Q a) -> 0 <= k ->
  pure_dp k P Q -> pure_dp k' P' Q' ->
  pure_dp (k * k') (fun ab => P ab.1 * P' ab.2) (fun ab => Q ab.1 * Q' ab.2).
Proof.
move=> P0 P'0 Q0 k0 h h' ab.
have -> : k * k' * (Q ab.1 * Q' ab.2) = (k * Q ab.1) * (k' * Q' ab.2) by ring.
by apply: ler_pmul.
Qed.

End Products.
