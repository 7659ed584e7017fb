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

(* With one threshold the bound is attained: f P above it, P/f below it, and at it what is left. *)
Theorem T16_factor_attained f P g : law P -> 1 <= f ->
  exists theta D, [/\ law D, pure_dp f D P, pure_dp f P D & expect D g = factor_up f theta P g].
Proof.
move=> lP f1; have [P0 P1] := lP; have f0 : 0 < f := lt_le_trans ltr01 f1; have fn : f != 0 by rewrite gt_eqF.
have fi0 : 0 <= f^-1 by rewrite invr_ge0 ltW.
have fi1 : f^-1 <= f by apply: (le_trans _ f1); rewrite invf_le1.
pose over t : R := \sum_(u | t < g u) P u; pose under t : R := \sum_(u | g u < t) P u; pose at_ t : R := \sum_(u | g u == t) P u.
have parts t (F : U -> R) : \sum_u F u = \sum_(u | t < g u) F u + \sum_(u | g u < t) F u + \sum_(u | g u == t) F u.
  rewrite (bigID (fun u => t < g u)) /= -addrA; congr (_ + _); rewrite (bigID (fun u => g u < t)) /=.
  by congr (_ + _); apply: eq_bigl => u; case: ltrgtP.
have o0 t : 0 <= over t by apply: sumr_ge0.
have u0 t : 0 <= under t by apply: sumr_ge0.
have a0 t : 0 <= at_ t by apply: sumr_ge0.
have one t : over t + under t + at_ t = 1 by rewrite -P1 (parts t).
have [z _] : exists z : U, true.
  case: (pickP (fun _ : U => true)) => [z _|no]; first by exists z.
  by move: P1; rewrite big_pred0 // => /esym/eqP; rewrite oner_eq0.
have [zmax _ gmax] := @arg_maxP _ _ _ z xpredT g isT.
pose fits u := f * over (g u) + f^-1 * (under (g u) + at_ (g u)) <= 1.
have fmax : fits zmax.
  have e : over (g zmax) = 0 by rewrite /over big_pred0 // => u; apply/negbTE; rewrite -leNgt; apply: gmax.
  by rewrite /fits e mulr0 add0r -[_ + at_ _]add0r -{1}e addrA one mulr1 invf_le1.
have [w wfits wmin] := @arg_minP _ _ _ zmax fits g fmax; set t := g w in wmin.
have low : 1 <= f * (over t + at_ t) + f^-1 * under t.
  case: (pickP (fun u => g u < t)) => [u1 u1t|none]; last first.
    have e : under t = 0 by rewrite /under big_pred0.
    by rewrite e mulr0 addr0; have := one t; rewrite e addr0 => ->; rewrite mulr1.
  have [u2 u2t u2max] := @arg_maxP _ _ _ u1 (fun u => g u < t) g u1t.
  have no : ~~ fits u2 by apply: contraL u2t => /wmin; rewrite leNgt.
  have e1 : over (g u2) = over t + at_ t.
    rewrite /over /at_ (bigID (fun u => t < g u)) /=; congr (_ + _); apply: eq_bigl => u.
      by apply/andP/idP => [[]//|h]; split=> //; apply: lt_trans h.
    case: (ltrgtP (g u) t) => h; rewrite ?andbF ?andbT //; last by rewrite h; exact: u2t.
    by apply/negbTE; rewrite -leNgt; apply: u2max.
  have e2 : under (g u2) + at_ (g u2) = under t.
    by apply: (addrI (over t + at_ t)); rewrite -{1}e1 addrA one addrAC one.
  by move: no; rewrite /fits e1 e2 -ltNge => /ltW.
pose c := if at_ t == 0 then 1 else (1 - f * over t - f^-1 * under t) / at_ t.
have ce : c * at_ t = 1 - f * over t - f^-1 * under t.
  rewrite /c; case: eqP => [e|/eqP e]; last by rewrite divfK.
  rewrite e mulr0; apply/esym/eqP; rewrite -addrA -opprD subr_eq0 eq_le; move: low wfits.
  by rewrite /fits -/t e !addr0 => -> ->.
have cb : f^-1 <= c <= f.
  have [e|e] := eqVneq (at_ t) 0; first by rewrite /c e eqxx f1 invf_le1 ?f1.
  have pos : 0 < at_ t by rewrite lt_def e a0.
  rewrite -(ler_pmul2r pos) -[c <= f](ler_pmul2r pos) ce; apply/andP; split.
    by move: wfits; rewrite /fits -/t mulrDr -subr_ge0 => h; rewrite -subr_ge0 (le_trans h) // le_eqVlt; apply/orP; left; apply/eqP; ring.
  by move: low; rewrite mulrDr -subr_ge0 => h; rewrite -subr_ge0 (le_trans h) // le_eqVlt; apply/orP; left; apply/eqP; ring.
have [c1 c2] := andP cb; pose k u := if t < g u then f else if g u < t then f^-1 else c.
have k1 u : f^-1 <= k u by rewrite /k; case: ifP => // _; case: ifP.
have k2 u : k u <= f by rewrite /k; case: ifP => // _; case: ifP.
have kP : \sum_u k u * P u = 1.
  have -> : 1 = f * over t + f^-1 * under t + c * at_ t :> R by rewrite ce; ring.
  rewrite (parts t) /over /under /at_ !mulr_sumr; congr (_ + _ + _); apply: eq_bigr => u; rewrite /k; first by move=> ->.
    by move=> h; rewrite h ltNge (ltW h).
  by move/eqP->; rewrite ltxx.
exists t, (fun u => k u * P u); split.
- by split=> // u; rewrite mulr_ge0 // (le_trans fi0).
- by move=> u; apply: ler_wpmul2r.
- by move=> u; rewrite mulrA ler_pemull // -(mulfV fn) ler_pmul2l.
rewrite /factor_up; apply/eqP; rewrite addrC -subr_eq; apply/eqP.
transitivity (\sum_u k u * P u * (g u - t)).
  by under [RHS]eq_bigr do rewrite mulrBr; rewrite [RHS]sumrB -[X in _ = _ - X]mulr_suml kP mul1r addrC.
apply: eq_bigr => u _; rewrite /k; case: (ltrgtP t (g u)) => h.
- by rewrite (max_idPr _) ?subr_ge0 ?(ltW h) // (max_idPl _) ?subr_le0 ?(ltW h) // mul0r subr0; ring.
- by rewrite (max_idPl _) ?subr_le0 ?(ltW h) // (max_idPr _) ?subr_ge0 ?(ltW h) // mulr0; ring.
by rewrite -h subrr maxxx !mulr0 mul0r subr0 mulr0.
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

(* ---- The example of the page: success 1/2 and 2/5, a limit of 2, which holds up to a drift of 1/10 and is reached there ---- *)

Section Example.
Variable R : realFieldType.
Let success (p : R) (u : bool) : R := if u then p else 1 - p.
Let one (u : bool) : R := u%:R.

Let law_success p : 0 <= p <= 1 -> law (success p).
Proof. by case/andP=> p0 p1; split=> [[]|]; rewrite ?big_bool /success /= ?subr_ge0 // addrC subrK. Qed.

Theorem T16_example : let half : R := 2%:R^-1 in let p : R := 2%:R / 5%:R in let eta : R := 10%:R^-1 in
  [/\ law (success half), law (success p), up_end eta 1 0 (success half) one = 2%:R * down_end eta 0 1 (success p) one &
      law (success (half + eta)) /\ tv (success (half + eta)) (success half) <= eta].
Proof.
move=> half p eta; have n k : k.+1%:R != 0 :> R by rewrite pnatr_eq0.
have pos k : 0 < k.+1%:R :> R by rewrite ltr0n.
have e1 : 10%:R * eta = 1 by rewrite /eta mulfV.
have h10 : half = 5%:R * eta.
  by apply: (mulIf (n 1%N)); rewrite [LHS]mulVf // mulrAC -natrM e1.
have p10 : p = 4%:R * eta.
  by rewrite -[RHS](mulfK (n 4%N)) [4%:R * eta * _]mulrAC -natrM (_ : (4 * 5 = 2 * 10)%N) // natrM -(mulrA 2%:R) e1 mulr1.
have e0 : 0 < eta by rewrite invr_gt0.
have le k : (k <= 10)%N -> 0 <= k%:R * eta <= 1.
  move=> k10; apply/andP; split; first by apply: mulr_ge0; rewrite ?ler0n ?ltW.
  by rewrite -[leRHS]e1 ler_pmul2r ?ler_nat.
split.
- by rewrite h10; apply/law_success/le.
- by rewrite p10; apply/law_success/le.
- have z : Num.max 0 (0 - 1 : R) = 0 by apply/max_idPl; rewrite sub0r oppr_le0 ler01.
  by rewrite /up_end /down_end /expect !big_bool /success /one /= z !subrr !maxxx h10 p10; ring.
have -> : half + eta = 6%:R * eta by rewrite h10; ring.
split; first by apply/law_success/le.
rewrite /tv /hockey_stick big_bool /success /= !mul1r h10.
have -> : 6%:R * eta - 5%:R * eta = eta by ring.
have -> : 1 - 6%:R * eta - (1 - 5%:R * eta) = - eta by ring.
have m : Num.max 0 (- eta) = 0 by apply/max_idPl; rewrite oppr_le0 ltW.
by rewrite m addr0 (max_idPr (ltW e0)).
Qed.

End Example.
