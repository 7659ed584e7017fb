(* T12: what a purely private filter leaves of the policy's own ratio. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T1.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section T12.
Variable R : realFieldType.
Implicit Types (k r : R).

(* (1 + R0 e^eps)/(R0 + e^eps) *)
Definition contraction (k r : R) : R := (1 + r * k) / (r + k).

(* One ordered pair: responses whose ratios are at most r, laws whose ratios are at most k. *)
Lemma contraction_pair (B : finType) k r (P Q h : B -> R) : law P -> law Q -> 1 <= k -> 1 <= r ->
  pure_dp k P Q -> pure_dp k Q P -> (forall b, 0 <= h b) -> (forall b b', h b <= r * h b') ->
  expect P h <= contraction k r * expect Q h.
Proof.
move=> lP lQ k1 r1 PQ QP h0 hr.
have [b0 _] : exists b : B, true.
  case: (pickP (fun _ : B => true)) => [b _|no]; first by exists b.
  by case: lP => _; rewrite big_pred0 // => /esym/eqP; rewrite oner_eq0.
have [b1 _ hmin] := @arg_minP _ _ _ b0 xpredT h isT.
set lo := h b1 in hmin; have den : 0 < r + k by rewrite addr_gt0 ?(lt_le_trans ltr01).
rewrite /contraction mulrAC ler_pdivl_mulr // mulrC -subr_le0 /expect !mulr_suml -sumrB.
apply: (@le_trans _ _ (\sum_b r * (k + 1) * lo * (P b - Q b))); last first.
  by rewrite -mulr_sumr sumrB (proj2 lP) (proj2 lQ) subrr mulr0.
apply: ler_sum => b _; rewrite -subr_le0.
have -> : P b * h b * (r + k) - Q b * h b * (1 + r * k) - r * (k + 1) * lo * (P b - Q b) =
  - ((r * lo - h b) * (k * P b - Q b) + r * ((h b - lo) * (k * Q b - P b))) by ring.
rewrite oppr_le0 addr_ge0 ?mulr_ge0 ?subr_ge0 ?(le_trans ler01) //; last exact: hmin.
exact: hr.
Qed.

Variables (X Xt A At U : finType).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R) (g : U -> X -> A -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (kT : policy T).
Local Notation E := (utility (induced MX MA T) g).

(* T12: if the responses to any two released values have ratio at most R0, then behind any purely
   eps-private group filter R <= (1 + R0 e^eps)/(R0 + e^eps).  No floor, no gamma. *)
Theorem T12_contraction k r : 1 <= k -> 1 <= r -> (forall u x a, 0 <= g u x a) -> a_free g ->
  (forall x a b b', response MX T g x a b <= r * response MX T g x a b') ->
  every_pair (pure_dp k) MA -> local_le (contraction k r) E.
Proof.
move=> k1 r1 g0 fg hr d x a a'; rewrite !utility_response.
rewrite (eq_expect (P' := MA a) (g' := response MX T g x a') _ (response_free MX T x a a' fg)) //.
apply: contraction_pair => // b.
rewrite response_expect; apply: expect_ge0 => // y.
by apply: expect_ge0 => [|u]; [exact: kT|exact: g0].
Qed.

(* T12 at eps = infinity: behind any group filter, private or not, R is at most R0. *)
Theorem T12_any_filter r : a_free g ->
  (forall x a b b', response MX T g x a b <= r * response MX T g x a b') -> local_le r E.
Proof.
move=> fg hr x a a'; rewrite !utility_response.
rewrite (eq_expect (P' := MA a) (g' := response MX T g x a') _ (response_free MX T x a a' fg)) //.
set h := response MX T g x a'.
rewrite -(expect_cst (r * _) (kA a)); apply: (expect_le (kA a)) => b.
by rewrite -expectZ -(expect_cst (h b) (kA a')); apply: (expect_le (kA a')) => b'; apply: hr.
Qed.

(* tanh(L/2) for L = log r. *)
Definition tanh_half (r : R) : R := (r - 1) / (r + 1).

(* T12 in the form of the page: tanh(L/2) <= tanh(L0/2) tanh(eps/2), with equality for the bound. *)
Theorem T12_tanh k r : 1 <= k -> 1 <= r -> tanh_half (contraction k r) = tanh_half r * tanh_half k.
Proof.
move=> k1 r1; rewrite /tanh_half /contraction.
have k0 : 0 < k + 1 by rewrite addr_gt0 // (lt_le_trans ltr01).
have r0 : 0 < r + 1 by rewrite addr_gt0 // (lt_le_trans ltr01).
have den : r + k != 0 by rewrite gt_eqF // addr_gt0 // (lt_le_trans ltr01).
have -> : (1 + r * k) / (r + k) - 1 = (r - 1) * (k - 1) / (r + k).
  by rewrite -{2}(divff den) -mulrBl; congr (_ / _); ring.
have -> : (1 + r * k) / (r + k) + 1 = (r + 1) * (k + 1) / (r + k).
  by rewrite -{2}(divff den) -mulrDl; congr (_ / _); ring.
rewrite invf_div [LHS]mulrA divfK //.
by rewrite invfM mulrACA.
Qed.

Lemma tanh_half_mono r r' : 0 <= r -> r <= r' -> tanh_half r <= tanh_half r'.
Proof.
move=> r0 rr; have p1 : 0 < r + 1 by apply: ltr_paddl => //; apply: ltr01.
have p2 : 0 < r' + 1 by apply: ltr_paddl; [apply: le_trans rr|exact: ltr01].
rewrite /tanh_half ler_pdivr_mulr // mulrAC ler_pdivl_mulr // -subr_ge0.
have -> : (r' - 1) * (r + 1) - (r - 1) * (r' + 1) = 2%:R * (r' - r) by ring.
by rewrite mulr_ge0 ?ler0n // subr_ge0.
Qed.

(* The same for the measured ratio of one pair. *)
Theorem T12_tanh_pair k r x a a' : 1 <= k -> 1 <= r -> (forall u x a, 0 <= g u x a) -> a_free g ->
  (forall x a b b', response MX T g x a b <= r * response MX T g x a b') ->
  every_pair (pure_dp k) MA -> 0 < E x a' ->
  tanh_half (E x a / E x a') <= tanh_half r * tanh_half k.
Proof.
move=> k1 r1 g0 fg hr d e0; rewrite -T12_tanh //; apply: tanh_half_mono; last first.
  by rewrite ler_pdivr_mulr //; apply: T12_contraction.
apply: divr_ge0; last exact: ltW.
by apply: expect_ge0 => [|u]; [exact: kernel_induced|exact: g0].
Qed.

(* T12 is never worse than T2 (e^eps) or the policy's own ratio R0. *)
Theorem T12_never_worse k r : 1 <= k -> 1 <= r -> contraction k r <= k /\ contraction k r <= r.
Proof.
move=> k1 r1; have den : 0 < r + k by rewrite addr_gt0 // (lt_le_trans ltr01).
have k0 : 0 <= k := le_trans ler01 k1.
split; rewrite ler_pdivr_mulr // -subr_ge0.
  have -> : k * (r + k) - (1 + r * k) = (k - 1) * (k + 1) by ring.
  by rewrite mulr_ge0 ?subr_ge0 ?addr_ge0 ?ler01.
have -> : r * (r + k) - (1 + r * k) = (r - 1) * (r + 1) by ring.
by rewrite mulr_ge0 ?subr_ge0 ?addr_ge0 ?ler01 ?(le_trans ler01 r1).
Qed.

(* Section 9, a relative: L_eo <= TV of the group filter times TV of the policy. *)
Theorem L_eo_contraction (D : R) x a a' : 0 <= D -> (forall y b b', tv (T y b) (T y b') <= D) ->
  tv (induced MX MA T x a) (induced MX MA T x a') <= D * tv (MA a) (MA a').
Proof.
move=> D0 hD; rewrite {1}/tv hockey_stick_attained mul1r; set S := [set u | _ < _].
pose i (u : U) (_ : X) (_ : A) : R := (u \in S)%:R; pose h := response MX T i x a.
have pE c : prob (induced MX MA T x c) S = expect (MA c) h.
  by rewrite prob_expect -[LHS]/(utility (induced MX MA T) i x c) utility_response.
have hle b b' : h b <= h b' + D.
  rewrite /h !response_expect -{1}(expect_cst D (kX x)) -expectD; apply: expect_le => // y.
  rewrite -!prob_expect -[prob (T y b') S]mul1r.
  by apply: (proj2 (dp_hockey_stick 1 D (T y b) (T y b'))); apply: hD.
have [b0 _] : exists b : At, true.
  case: (pickP (fun _ : At => true)) => [b _|no]; first by exists b.
  by case: (kA a) => _; rewrite big_pred0 // => /esym/eqP; rewrite oner_eq0.
have [b1 _ hmin] := @arg_minP _ _ _ b0 xpredT h isT.
have rh : ranged (h b1) (h b1 + D) h by move=> b; rewrite hle andbT; apply: hmin.
have := hockey_stick_ranged 1 (kA a) (kA a') rh.
rewrite subrr mul0r subr0 mul1r (addrC (h b1)) addrK => le.
by rewrite !pE ler_subl_addl.
Qed.

(* T12 is sharp: rows (k,1)/(1+k) and (1,k)/(1+k), responses (R0, 1). *)
Definition coin_filter (k : R) (a b : bool) : R := (if a == b then k else 1) / (1 + k).
Definition coin_response (r : R) (b : bool) : R := if b then r else 1.

Theorem T12_sharp k r : 1 <= k -> 1 <= r ->
  [/\ kernel (coin_filter k), every_pair (pure_dp k) (coin_filter k),
      forall b b', coin_response r b <= r * coin_response r b' &
      expect (coin_filter k true) (coin_response r) =
        contraction k r * expect (coin_filter k false) (coin_response r)].
Proof.
move=> k1 r1; have k0 : 0 < 1 + k by rewrite addr_gt0 // (lt_le_trans ltr01).
have kp : 0 <= k := le_trans ler01 k1.
have kk : 1 <= k * k by rewrite -[1]mul1r ler_pmul.
have rr : 1 <= r * r by rewrite -[1]mul1r ler_pmul.
have rp : 0 <= r := le_trans ler01 r1.
split.
- move=> a; split=> [b|]; first by apply: divr_ge0; [case: (a == b); rewrite ?ler01|exact: ltW].
  case: a; rewrite /coin_filter big_bool /= -mulrDl ?(addrC k) divff ?gt_eqF //.
- move=> a a' b; rewrite /coin_filter mulrA ler_pmul2r ?invr_gt0 //.
  by case: (a == b); case: (a' == b); rewrite ?mulr1 ?ler_pemulr.
- by case=> [] []; rewrite /coin_response ?mulr1 // ler_pemulr.
rewrite /expect !big_bool /coin_filter /coin_response /contraction /= !mulr1.
have den : r + k != 0 by rewrite gt_eqF // addr_gt0 // (lt_le_trans ltr01).
have -> : 1 / (1 + k) * r + k / (1 + k) = (r + k) / (1 + k) by rewrite mulrAC mul1r -mulrDl.
have -> : k / (1 + k) * r + 1 / (1 + k) = (1 + r * k) / (1 + k).
  by rewrite mulrAC -mulrDl (addrC _ 1) (mulrC k).
by rewrite mulrA divfK.
Qed.

End T12.
