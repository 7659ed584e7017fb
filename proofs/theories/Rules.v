(* Three forms of T3 that certificates use as they stand: for every filter of an epsilon at once, for the filter's
   multipliers under a floor of the policy, and for every utility of a class under a given law. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T1 T3.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- The pair of rows that is the worst of a pure epsilon ---- *)

Section Extreme.
Variable R : realFieldType.

(* Randomized response over two values with e^eps = e: the truth e times as often as the lie. *)
Definition truth (e : R) (b : bool) : R := (if b then e else 1) / (1 + e).
Definition lie (e : R) (b : bool) : R := (if b then 1 else e) / (1 + e).

Lemma hockey_stick_extreme k e : hockey_stick k (truth e) (lie e) =
  Num.max 0 ((e - k) / (1 + e)) + Num.max 0 ((1 - k * e) / (1 + e)).
Proof. by rewrite /hockey_stick big_bool /truth /lie !mulrA -!mulrBl mulr1. Qed.

(* No pair of a filter with that epsilon has a greater H_k, for any k. *)
Theorem pure_dp_hockey_stick (A : finType) (P Q : A -> R) k e : law P -> law Q -> 0 <= k -> 1 <= e ->
  pure_dp e P Q -> pure_dp e Q P -> hockey_stick k P Q <= hockey_stick k (truth e) (lie e).
Proof.
move=> lP lQ k0 e1 PQ QP; have e0 : 0 < 1 + e by rewrite addr_gt0 // (lt_le_trans ltr01).
case: (leP e k) => [ek|/ltW ke].
  rewrite [hockey_stick k P Q](_ : _ = 0) ?hockey_stick_ge0 // /hockey_stick big1 // => a _.
  apply/max_idPl; rewrite subr_le0; apply: le_trans (PQ a) _; apply: ler_wpmul2r => //; by case: lQ.
rewrite hockey_stick_extreme; case: (leP (k * e) 1) => [small|/ltW large].
  have -> : hockey_stick k P Q = 1 - k.
    rewrite /hockey_stick (eq_bigr (fun a => P a - k * Q a)) => [|a _].
      by rewrite sumrB -mulr_sumr (proj2 lP) (proj2 lQ) mulr1.
    apply/max_idPr; rewrite subr_ge0; apply: le_trans (ler_wpmul2l k0 (QP a)) _.
    by rewrite mulrA ler_pimull //; case: lP.
  have -> : 1 - k = (e - k) / (1 + e) + (1 - k * e) / (1 + e).
  by rewrite -mulrDl (_ : e - k + (1 - k * e) = (1 - k) * (1 + e)) ?mulfK ?gt_eqF //; ring.
  by apply: ler_add; rewrite le_maxr lexx orbT.
apply: (@le_trans _ _ ((e - k) / (1 + e))); last by rewrite -[leLHS]addr0 ler_add // le_maxr lexx ?orbT.
rewrite hockey_stick_attained ler_pdivl_mulr //; set S := [set a | _].
set p := prob P S; set q := prob Q S.
have pq : p <= e * q by rewrite /p /q /prob mulr_sumr; apply: ler_sum.
have outside (L : A -> R) : law L -> 1 - prob L S = prob L (~: S).
  move=> [_ <-]; rewrite /prob (bigID (mem S)) /= addrC addKr; by apply: eq_bigl => a; rewrite in_setC.
have qp : 1 - q <= e * (1 - p) by rewrite !outside // /prob mulr_sumr; apply: ler_sum.
case: (ltrgtP e 1) => [||one]; [by rewrite ltNge e1 | move=> gt1 |].
  have d0 : 0 < e - 1 by rewrite subr_gt0.
  rewrite -subr_ge0 -(pmulr_rge0 _ d0).
  have -> : (e - 1) * (e - k - (p - k * q) * (1 + e)) = (k * e - 1) * (e * q - p) + (e - k) * (e * (1 - p) - (1 - q)) by ring.
  by rewrite addr_ge0 ?mulr_ge0 ?subr_ge0.
move: large ke pq qp; rewrite one mulr1 !mul1r => k1 k1' pq _.
have -> : k = 1 by apply/eqP; rewrite eq_le k1 k1'.
rewrite mul1r subrr; apply: mulr_le0_ge0; [by rewrite subr_le0 | by rewrite addr_ge0 ?ler01].
Qed.

End Extreme.

(* ---- A floor of the policy, and every filter of that epsilon ---- *)

Section AnyFilter.
Variables (R : realFieldType) (X Xt A At U : finType).
Variables (MX : X -> Xt -> R) (T : Xt -> At -> U -> R) (g : U -> X -> A -> R).
Hypotheses (kX : kernel MX) (kT : policy T).

(* Everything that can be released is answered with an expected utility of at least tau. *)
Definition policy_floor (tau : R) : Prop :=
  forall x a y b, 0 < MX x y -> tau <= expect (T y b) (fun u => g u x a).

(* The floor survives every group filter that releases these values. *)
Lemma policy_floor_holds MA tau : kernel MA -> policy_floor tau -> has_floor tau (utility (induced MX MA T) g).
Proof.
move=> kA floor x a; rewrite utility_response -(expect_cst tau (kA a)); apply: expect_le => // b.
rewrite response_expect -(expect_cst tau (kX x)); apply: ler_sum => y _.
have : 0 <= MX x y by case: (kX x).
rewrite le_eqVlt => /orP[/eqP <-|M0]; first by rewrite !mul0r.
by rewrite ler_pmul2l //; apply: floor.
Qed.

(* T3 for this policy and context filter behind any group filter with pure epsilon: the H_k of one pair serves for all. *)
Theorem T3_any_filter MA gamma tau k e x a a' : kernel MA -> 0 <= gamma -> valued 0 gamma g -> a_free g ->
  0 <= k -> 1 <= e -> every_pair (pure_dp e) MA -> 0 < tau -> policy_floor tau ->
  utility (induced MX MA T) g x a <= (k + gamma * hockey_stick k (truth e) (lie e) / tau) * utility (induced MX MA T) g x a'.
Proof.
move=> kA g0 vg fg k0 e1 d t0 floor; have te := policy_floor_holds kA floor x a'.
apply: ratio_weaken (T3_one_k kX kA kT k a g0 vg fg t0 te); first exact: le_trans (ltW t0) te.
rewrite ler_add2l ler_wpmul2r ?invr_ge0 ?(ltW t0) //; apply: ler_wpmul2l => //.
by apply: pure_dp_hockey_stick => //; apply: d.
Qed.

End AnyFilter.

(* ---- Every utility of a class, under a given law ---- *)

Section Class.
Variables (R : realFieldType) (B : finType) (P Q : B -> R).
Hypotheses (lP : law P) (lQ : law Q).

(* P and Q are the laws of two groups: P(u|x,a) in a context, or P(u,x|a) over all.  One k proves the bound r for every
   utility with values in [m, gamma] that keeps the floor t under the lower group. *)
Theorem T3_class m gamma t k r (g : B -> R) : ranged m gamma g -> 0 < t -> t <= expect Q g ->
  k * t + Num.max 0 ((gamma - m) * hockey_stick k P Q - (k - 1) * m) <= r * t ->
  expect P g <= r * expect Q g.
Proof.
move=> rg t0 floor bound; set c := Num.max _ _ in bound.
have c0 : 0 <= c by rewrite /c le_maxr lexx.
apply: (@ratio_weaken _ _ _ (k + c / t)); first exact: le_trans (ltW t0) floor.
  by rewrite -(ler_pmul2r t0) mulrDl divfK ?gt_eqF.
apply: ratio_of_additive => //; apply: le_trans (hockey_stick_ranged k lP lQ rg) _.
by rewrite -addrA ler_add2l /c le_maxr lexx orbT.
Qed.

(* Without a floor: if H_k = 0, every nonnegative utility has the ratio k at most. *)
Theorem T3_class_no_floor k r (g : B -> R) : (forall b, 0 <= g b) -> hockey_stick k P Q = 0 -> k <= r ->
  expect P g <= r * expect Q g.
Proof.
move=> g0 /eqP; rewrite psumr_eq0 => [/allP all0 kr|b _]; last by rewrite le_maxr lexx.
apply: (@ratio_weaken _ _ _ k) => //; first exact: expect_ge0.
rewrite /expect mulr_sumr; apply: ler_sum => b _; rewrite mulrA; apply: ler_wpmul2r => //.
have /implyP/(_ isT)/eqP := all0 b (mem_index_enum b).
by move/max_idPl; rewrite subr_le0.
Qed.

End Class.
