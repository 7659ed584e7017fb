(* T16: drift.  The law of each cell may move, every cell by itself: by a total variation of at most eta, or by a factor of at most f.

   Reading key.  P is the law of decisions of a cell as it was measured, D a law that it may have now, g the utility of that cell.
   [up_end eta gamma theta P g] bounds the expectation from above, [down_end eta m theta P g] from below, with any threshold theta. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T13 T13_near.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- Total variation ---- *)

Section Cell.
Variables (R : realFieldType) (U : finType).
Implicit Types (P D g : U -> R) (eta theta gamma m f : R).

Definition up_end eta gamma theta P g : R := expect P g + eta * (gamma - theta) + expect P (fun u => Num.max 0 (theta - g u)).
Definition down_end eta m theta P g : R := expect P g - eta * (theta - m) - expect P (fun u => Num.max 0 (g u - theta)).

Lemma down_endN eta m theta P g : down_end eta m theta P g = - up_end eta (- m) (- theta) P (fun u => - g u).
Proof.
rewrite /down_end /up_end expectN; have -> : expect P (fun u => Num.max 0 (- theta - - g u)) = expect P (fun u => Num.max 0 (g u - theta)).
  by apply: eq_bigr => u _; rewrite opprK addrC.
by ring.
Qed.

(* Any threshold is a proof of the ends. *)
Theorem T16_up eta gamma theta P D g : law P -> law D -> tv D P <= eta -> (forall u, g u <= gamma) -> theta <= gamma ->
  expect D g <= up_end eta gamma theta P g.
Proof. by move=> lP lD near gg tg; apply: near_bound. Qed.

Theorem T16_down eta m theta P D g : law P -> law D -> tv D P <= eta -> (forall u, m <= g u) -> m <= theta ->
  down_end eta m theta P g <= expect D g.
Proof.
move=> lP lD near gm mt; rewrite down_endN ler_oppl -expectN; apply: T16_up => // [u|]; rewrite ler_opp2 //.
Qed.

(* With one threshold the end is attained: u is a decision with the greatest utility. *)
Theorem T16_attained eta P g u : law P -> 0 <= eta <= 1 -> (forall v, g v <= g u) ->
  exists theta D, [/\ theta <= g u, law D, tv D P <= eta & expect D g = up_end eta (g u) theta P g].
Proof.
move=> lP e01 gu; have [r fl] := T13_near_exists g lP e01; have gE : greatest u g = g u by apply: greatest_eq.
have [theta th le] := near_threshold u fl; rewrite gE in th le; have [pr _] := fl.
have lD := law_moved u lP pr; have near := tv_moved u pr.
exists theta, (moved eta P r u); split=> //; apply: le_anti; rewrite T16_up //=.
by rewrite /expect (expect_moved u g pr) /up_end -addrA ler_add2l.
Qed.

Theorem T16_attained_down eta P g u : law P -> 0 <= eta <= 1 -> (forall v, g u <= g v) ->
  exists theta D, [/\ g u <= theta, law D, tv D P <= eta & expect D g = down_end eta (g u) theta P g].
Proof.
move=> lP e01 gu; have [|theta [D [th lD near e]]] := @T16_attained eta P (fun v => - g v) u lP e01.
  by move=> v; rewrite ler_opp2.
exists (- theta), D; split=> //; first by rewrite ler_oppr.
by rewrite down_endN opprK -e expectN opprK.
Qed.

End Cell.

(* ---- Verdicts about a pair of cells: P, g of (x,a) and Q, h of (x,a') ---- *)

Section Pair.
Variables (R : realFieldType) (U : finType) (P Q g h : U -> R) (V eta gamma gamma' m m' theta theta' : R).
Hypotheses (lP : law P) (lQ : law Q) (V0 : 0 <= V).

(* Within, for every drift up to eta. *)
Theorem T16_within D D' : (forall u, g u <= gamma) -> (forall u, m' <= h u) -> theta <= gamma -> m' <= theta' ->
  up_end eta gamma theta P g <= V * down_end eta m' theta' Q h ->
  law D -> law D' -> tv D P <= eta -> tv D' Q <= eta -> expect D g <= V * expect D' h.
Proof.
move=> gg hm tg mt le lD lD' near near'; apply: le_trans (T16_up lP lD near gg tg) _; apply: le_trans le _.
by apply: ler_wpmul2l => //; apply: T16_down.
Qed.

(* Exceeds, for every drift up to eta. *)
Theorem T16_exceeds D D' : (forall u, m <= g u) -> (forall u, h u <= gamma') -> m <= theta -> theta' <= gamma' ->
  V * up_end eta gamma' theta' Q h < down_end eta m theta P g ->
  law D -> law D' -> tv D P <= eta -> tv D' Q <= eta -> V * expect D' h < expect D g.
Proof.
move=> gm hg mt tg lt lD lD' near near'; apply: lt_le_trans (T16_down lP lD near gm mt); apply: le_lt_trans lt.
by apply: ler_wpmul2l => //; apply: T16_up.
Qed.

(* Exceeds, for every drift below eta, if the ends meet at eta and were apart before. *)
Theorem T16_before D D' zeta : (forall u, m <= g u) -> (forall u, h u <= gamma') -> m <= theta -> theta' <= gamma' ->
  V * up_end eta gamma' theta' Q h <= down_end eta m theta P g -> 0 < (theta - m) + V * (gamma' - theta') -> zeta < eta ->
  law D -> law D' -> tv D P <= zeta -> tv D' Q <= zeta -> V * expect D' h < expect D g.
Proof.
move=> gm hg mt tg le apart less lD lD' near near'; apply: lt_le_trans (T16_down lP lD near gm mt).
apply: (@le_lt_trans _ _ (V * up_end zeta gamma' theta' Q h)); first by apply: ler_wpmul2l => //; apply: T16_up.
have -> : up_end zeta gamma' theta' Q h = up_end eta gamma' theta' Q h - (eta - zeta) * (gamma' - theta') by rewrite /up_end; ring.
have -> : down_end zeta m theta P g = down_end eta m theta P g + (eta - zeta) * (theta - m) by rewrite /down_end; ring.
rewrite mulrBr ltr_subl_addr -addrA; apply: le_lt_trans le _; rewrite ltr_addl.
have -> : (eta - zeta) * (theta - m) + V * ((eta - zeta) * (gamma' - theta')) =
  (eta - zeta) * ((theta - m) + V * (gamma' - theta')) by ring.
by rewrite mulr_gt0 ?subr_gt0.
Qed.

(* The greatest ratio within eta is attained: one law has the greatest expectation, another one the least of the other cell. *)
Theorem T16_worst : 0 <= eta <= 1 -> exists D D', [/\ law D, law D', tv D P <= eta & tv D' Q <= eta] /\
  forall B B', law B -> law B' -> tv B P <= eta -> tv B' Q <= eta -> expect B g <= expect D g /\ expect D' h <= expect B' h.
Proof.
move=> e01; have [u0 _] : exists u : U, true.
  case: (pickP (fun _ : U => true)) => [u _|no]; first by exists u.
  by case: lP => _; rewrite big_pred0 // => /esym/eqP; rewrite oner_eq0.
have [u _ umax] := @arg_maxP _ _ _ u0 xpredT g isT; have [v _ vmin] := @arg_minP _ _ _ u0 xpredT h isT.
have gu w : g w <= g u by apply: umax.
have hv w : h v <= h w by apply: vmin.
have [t [D [tg lD near e]]] := T16_attained lP e01 gu.
have [t' [D' [tm lD' near' e']]] := T16_attained_down lQ e01 hv.
exists D, D'; split=> // B B' lB lB' nearB nearB'; split; first by rewrite e; apply: T16_up.
by rewrite e'; apply: T16_down.
Qed.

End Pair.

(* ---- All cells ---- *)

Section Local.
Variables (R : realFieldType) (X A U : finType) (P : X -> A -> U -> R) (g : U -> X -> A -> R).
Variables (eta V : R) (gamma m theta theta' : X -> A -> R).
Hypotheses (kP : forall x, kernel (P x)) (g0 : forall u x a, 0 <= g u x a) (V1 : 1 <= V).
Hypotheses (range : forall u x a, m x a <= g u x a <= gamma x a) (above : forall x a, theta x a <= gamma x a).
Hypothesis below : forall x a, m x a <= theta' x a.

Definition drifted (D : X -> A -> U -> R) : Prop := forall x a, law (D x a) /\ tv (D x a) (P x a) <= eta.

(* "Within the declared drift": one threshold for each cell and side. *)
Theorem T16_local : (forall x a a', a != a' ->
    up_end eta (gamma x a) (theta x a) (P x a) (fun u => g u x a) <= V * down_end eta (m x a') (theta' x a') (P x a') (fun u => g u x a')) ->
  forall D, drifted D -> local_le V (utility D g).
Proof.
move=> ends D dr x a a'; have V0 : 0 <= V := le_trans ler01 V1.
have [lD near] := dr x a; have [lD' near'] := dr x a'; have [<-|ne] := eqVneq a a'.
  by rewrite ler_pemull // expect_ge0.
apply: (T16_within (kP x a) (kP x a') V0 (gamma := gamma x a) (m' := m x a')) (ends x a a' ne) lD lD' near near' => // u.
  by case/andP: (range u x a).
by case/andP: (range u x a').
Qed.

End Local.

(* ---- A factor: D/P in [1/f, f] ---- *)

Section Factor.
Variables (R : realFieldType) (U : finType).
Implicit Types (P D g : U -> R) (theta f : R).

Definition factor_up f theta P g : R :=
  theta + expect P (fun u => f * Num.max 0 (g u - theta) - Num.max 0 (theta - g u) / f).
Definition factor_down f theta P g : R :=
  theta - expect P (fun u => f * Num.max 0 (theta - g u) - Num.max 0 (g u - theta) / f).

Theorem T16_factor_up f theta P D g : law D -> 1 <= f -> pure_dp f D P -> pure_dp f P D ->
  expect D g <= factor_up f theta P g.
Proof.
move=> lD f1 DP PD; have f0 : 0 < f := lt_le_trans ltr01 f1.
rewrite /factor_up -ler_subl_addl -[X in _ - X](expect_cst theta lD) -expectB; apply: ler_sum => u _.
case: (leP 0 (g u - theta)) => s.
  rewrite (max_idPl _ : Num.max 0 (theta - g u) = 0) ?mul0r ?subr0; last by rewrite -oppr_ge0 opprB.
  by rewrite mulrA [P u * f]mulrC; apply: ler_wpmul2r.
have s' : 0 <= theta - g u by rewrite -oppr_le0 opprB ltW.
rewrite (max_idPr s') mulr0 sub0r -opprB !mulrN ler_opp2 mulrA mulrAC; apply: ler_wpmul2r => //.
by rewrite ler_pdivr_mulr // mulrC.
Qed.

Theorem T16_factor_down f theta P D g : law D -> 1 <= f -> pure_dp f D P -> pure_dp f P D ->
  factor_down f theta P g <= expect D g.
Proof.
move=> lD f1 DP PD; have := T16_factor_up (- theta) (fun u => - g u) lD f1 DP PD.
rewrite expectN ler_oppl => le; apply: le_trans le; rewrite /factor_up /factor_down opprD opprK ler_add2l ler_opp2.
rewrite le_eqVlt; apply/orP; left; apply/eqP; apply: eq_bigr => u _.
by rewrite !opprK ![- _ + _]addrC.
Qed.

(* The worst ratio is at most f^2 times the measured one. *)
Theorem T16_factor_square f r P Q D D' g h : 0 <= r -> 1 <= f -> pure_dp f D P -> pure_dp f Q D' ->
  (forall u, 0 <= g u) -> (forall u, 0 <= h u) -> expect P g <= r * expect Q h -> expect D g <= f ^+ 2 * r * expect D' h.
Proof.
move=> r0 f1 DP QD g0 h0 le; have f0 : 0 <= f := le_trans ler01 f1.
apply: (@le_trans _ _ (f * expect P g)).
  by rewrite -expectZ; apply: ler_sum => u _; rewrite mulrCA mulrA; apply: ler_wpmul2r.
have -> : f ^+ 2 * r * expect D' h = f * (r * (f * expect D' h)) by ring.
apply: ler_wpmul2l => //; apply: le_trans le _; apply: ler_wpmul2l => //.
by rewrite -expectZ; apply: ler_sum => u _; rewrite mulrCA mulrA; apply: ler_wpmul2r.
Qed.

End Factor.

(* ---- Group means: the shares of the contexts within a factor Gamma, the cells below (above) their ends ---- *)

Section Global.
Variables (R : realFieldType) (X A : finType) (W W' : A -> X -> R) (E low up : X -> A -> R) (Gamma : R).
Hypotheses (lW' : forall a, law (W' a)) (G1 : 1 <= Gamma).
Hypotheses (DP : forall a, pure_dp Gamma (W' a) (W a)) (PD : forall a, pure_dp Gamma (W a) (W' a)).

Theorem T16_global theta a : (forall x, E x a <= up x a) -> group_mean W' E a <= factor_up Gamma theta (W a) (up^~ a).
Proof.
move=> le; apply: le_trans (T16_factor_up theta (up^~ a) (lW' a) G1 (DP a) (PD a)).
exact: (expect_le (lW' a)).
Qed.

Theorem T16_global_down theta a : (forall x, low x a <= E x a) -> factor_down Gamma theta (W a) (low^~ a) <= group_mean W' E a.
Proof.
move=> le; apply: le_trans (T16_factor_down theta (low^~ a) (lW' a) G1 (DP a) (PD a)) _.
exact: (expect_le (lW' a)).
Qed.

End Global.
