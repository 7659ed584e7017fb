(* T14: a context that nobody recorded.

   Reading key.  Within a context V is the hidden factor, p and q are its laws P(.|x,a) and P(.|x,a'), e and e' the expectations of the two groups
   given V, so that E(x,a) = expect p e and E(x,a') = expect q e'.  "The ratio is at most r for every v" is e v <= r * e' v. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T1 T12.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section T14.
Variables (R : realFieldType).
Implicit Types (V : finType) (k m r : R).

(* The values of h differ by at most a factor m; where P gives mass. *)
Definition spread V m (h : V -> R) : Prop := forall v v', h v <= m * h v'.
Definition spread_on V m (P h : V -> R) : Prop := forall v v', 0 < P v -> 0 < P v' -> h v <= m * h v'.

(* ---- Shares within [1/k, k] ---- *)

(* T14: E(a) <= r (1 + mk)/(m + k) E(a') if every v has a ratio of at most r, so r >= R_obs (m + k)/(1 + mk). *)
Theorem T14_hidden V k m r (p q e e' : V -> R) : law p -> law q -> 1 <= k -> 1 <= m -> 0 <= r ->
  pure_dp k p q -> pure_dp k q p -> (forall v, 0 <= e v) -> (forall v, 0 <= e' v) -> spread m e \/ spread m e' ->
  (forall v, e v <= r * e' v) -> expect p e <= r * contraction k m * expect q e'.
Proof.
move=> lp lq k1 m1 r0 pq qp e0 e0' [s|s] hr.
  apply: le_trans (contraction_pair lp lq k1 m1 pq qp e0 s) _; rewrite [r * _]mulrC -[leRHS]mulrA.
  apply: ler_wpmul2l; first by rewrite divr_ge0 ?addr_ge0 ?mulr_ge0 ?ler01 ?(le_trans ler01).
  by rewrite -expectZ; apply: expect_le.
apply: (@le_trans _ _ (r * expect p e')); first by rewrite -expectZ; apply: expect_le.
by rewrite -mulrA; apply: ler_wpmul2l => //; apply: contraction_pair.
Qed.

(* The claim "it exceeds R*, with the declared hidden context": some v has a greater ratio than R*. *)
Theorem T14_exceeds V k m r (p q e e' : V -> R) : law p -> law q -> 1 <= k -> 1 <= m -> 0 <= r ->
  pure_dp k p q -> pure_dp k q p -> (forall v, 0 <= e v) -> (forall v, 0 <= e' v) -> spread m e \/ spread m e' ->
  r * (1 + m * k) * expect q e' < (m + k) * expect p e -> exists v, r * e' v < e v.
Proof.
move=> lp lq k1 m1 r0 pq qp e0 e0' s big; case: (pickP (fun v => r * e' v < e v)) => [v h|none]; first by exists v.
have den : 0 < m + k by rewrite addr_gt0 ?(lt_le_trans ltr01).
have hr v : e v <= r * e' v by rewrite leNgt none.
have := T14_hidden lp lq k1 m1 r0 pq qp e0 e0' s hr.
rewrite /contraction mulrAC mulrA -mulrA mulrA ler_pdivl_mulr // [_ * (m + k)]mulrC leNgt.
by rewrite mulrAC big.
Qed.

(* No bound on the spread: a factor k. *)
Theorem T14_any_spread V k r (p q e e' : V -> R) : law p -> law q -> 0 <= r -> pure_dp k p q ->
  (forall v, 0 <= e' v) -> (forall v, e v <= r * e' v) -> expect p e <= r * k * expect q e'.
Proof.
move=> lp lq r0 pq e0 hr; rewrite -mulrA -!expectZ; apply: ler_sum => v _.
apply: (@le_trans _ _ (p v * (r * e' v))); first by rewrite ler_wpmul2l //; case: lp.
by rewrite mulrCA [leRHS]mulrCA; apply: ler_wpmul2l => //; rewrite [leRHS]mulrCA mulrA; apply: ler_wpmul2r.
Qed.

(* ---- Only one side is bounded; supports may differ ---- *)

(* Some value is the least where P gives mass. *)
Lemma least_on V (P h : V -> R) : law P -> exists2 v, 0 < P v & forall w, 0 < P w -> h v <= h w.
Proof.
move=> [P0 P1]; have [v0 v0P] : exists v, 0 < P v.
  case: (pickP (fun v => 0 < P v)) => [v h0|none]; first by exists v.
  move/eqP: P1; rewrite big1 => [|v _]; first by rewrite eq_sym oner_eq0.
  by apply/eqP; move: (P0 v); rewrite le_eqVlt none orbF eq_sym.
have [v vP vmin] := @arg_minP _ _ _ v0 (fun v => 0 < P v) h v0P.
by exists v.
Qed.

(* P(v|a) <= k P(v|a'), and the spread of a', whose support is the larger. *)
Theorem T14_one_sided V k m r (p q e e' : V -> R) : law p -> law q -> 1 <= k -> 1 <= m -> 0 <= r ->
  pure_dp k p q -> (forall v, 0 <= e' v) -> spread_on m q e' -> (forall v, 0 < p v -> e v <= r * e' v) ->
  expect p e <= r * (m * k / (m + k - 1)) * expect q e'.
Proof.
move=> lp lq k1 m1 r0 pq e0 s hr; have [[p0 p1] [q0 q1]] := (lp, lq).
apply: (@le_trans _ _ (r * expect p e')).
  rewrite -expectZ; apply: ler_sum => v _; have := p0 v; rewrite le_eqVlt => /orP[/eqP<-|pv]; first by rewrite !mul0r.
  by apply: ler_wpmul2l => //; apply: hr.
rewrite -mulrA; apply: ler_wpmul2l => //.
have den : 0 < m + k - 1 by rewrite -addrA ltr_paddr ?subr_ge0 // (lt_le_trans ltr01).
have [v0 v0q least] := least_on e' lq; set lo := e' v0 in least.
rewrite mulrAC ler_pdivl_mulr // [_ * (m + k - 1)]mulrC -subr_le0 /expect !mulr_sumr -sumrB.
apply: (@le_trans _ _ (\sum_v m * k * lo * (p v - q v))); last by rewrite -mulr_sumr sumrB p1 q1 subrr mulr0.
apply: ler_sum => v _; have := q0 v; rewrite le_eqVlt => /orP[/eqP qv|qv].
  have -> : p v = 0 by apply: le_anti; rewrite p0 andbT; have := pq v; rewrite -qv mulr0.
  by rewrite -qv !mul0r !mulr0 !subrr mulr0.
rewrite -subr_le0.
have -> : (m + k - 1) * (p v * e' v) - m * k * (q v * e' v) - m * k * lo * (p v - q v) =
  - (m * ((k * q v - p v) * (e' v - lo)) + (k - 1) * (p v * (m * lo - e' v))) by ring.
rewrite oppr_le0 addr_ge0 ?mulr_ge0 ?subr_ge0 ?(le_trans ler01 m1) //; first exact: least.
exact: s.
Qed.

(* P(v|a') <= k P(v|a), and the spread of a. *)
Theorem T14_one_sided_reversed V k m r (p q e e' : V -> R) : law p -> law q -> 1 <= k -> 1 <= m -> 0 <= r ->
  pure_dp k q p -> (forall v, 0 <= e v) -> spread_on m p e -> (forall v, 0 < q v -> e v <= r * e' v) ->
  expect p e <= r * ((m * k - m + 1) / k) * expect q e'.
Proof.
move=> lp lq k1 m1 r0 qp e0 s hr; have [[p0 p1] [q0 q1]] := (lp, lq).
have den : 0 < k := lt_le_trans ltr01 k1.
have num : 0 <= m * k - m + 1.
  rewrite addr_ge0 ?ler01 // -[X in _ - X]mulr1 -mulrBr mulr_ge0 ?subr_ge0 //.
  exact: le_trans m1.
apply: (@le_trans _ _ ((m * k - m + 1) / k * expect q e)); last first.
  rewrite [r * _]mulrC -[leRHS]mulrA; apply: ler_wpmul2l; first by rewrite divr_ge0 ?(ltW den).
  rewrite -expectZ; apply: ler_sum => v _; have := q0 v; rewrite le_eqVlt => /orP[/eqP<-|qv]; first by rewrite !mul0r.
  by apply: ler_wpmul2l => //; apply: hr.
have [v0 v0p least] := least_on e lp; set lo := e v0 in least.
rewrite mulrAC ler_pdivl_mulr // [expect p e * k]mulrC -subr_le0 /expect !mulr_sumr -sumrB.
apply: (@le_trans _ _ (\sum_v k * m * lo * (p v - q v))); last by rewrite -mulr_sumr sumrB p1 q1 subrr mulr0.
apply: ler_sum => v _; have := p0 v; rewrite le_eqVlt => /orP[/eqP pv|pv].
  have -> : q v = 0 by apply: le_anti; rewrite q0 andbT; have := qp v; rewrite -pv mulr0.
  by rewrite -pv !mul0r !mulr0 !subrr mulr0.
rewrite -subr_le0.
have -> : k * (p v * e v) - (m * k - m + 1) * (q v * e v) - k * m * lo * (p v - q v) =
  - ((k * p v - q v) * (m * lo - e v) + (k - 1) * m * (q v * (e v - lo))) by ring.
rewrite oppr_le0 addr_ge0 ?mulr_ge0 ?subr_ge0 ?(le_trans ler01 m1) //; last exact: least.
exact: s.
Qed.

(* ---- Sharp, and the frontier ---- *)

(* One hidden factor with two values attains it. *)
Theorem T14_sharp k m r : 1 <= k -> 1 <= m -> 0 <= r ->
  let p := coin_filter k true in let q := coin_filter k false in
  let e' := coin_response m in let e v := r * e' v in
  [/\ law p, law q, pure_dp k p q, pure_dp k q p & spread m e'] /\
  [/\ spread m e, expect q e' > 0 & expect p e = r * contraction k m * expect q e'].
Proof.
move=> k1 m1 r0 p q e' e; have [kc pure s eq] := T12_sharp k1 m1.
have e0' v : 0 < e' v by rewrite /e' /coin_response; case: v; rewrite ?ltr01 // (lt_le_trans ltr01).
have q0 v : 0 < q v.
  by rewrite /q /coin_filter divr_gt0 ?addr_gt0 ?ltr01 ?(lt_le_trans ltr01) //; case: eqP; rewrite ?ltr01 ?(lt_le_trans ltr01).
split; split => //; try exact: kc; try exact: pure.
- by move=> v v'; rewrite mulrCA; apply: ler_wpmul2l.
- by rewrite /expect big_bool addr_gt0 // mulr_gt0.
by rewrite expectZ eq mulrA.
Qed.

Theorem T14_one_sided_sharp k m r : 1 <= k -> 1 <= m -> 0 <= r ->
  let p := point R true in let q (v : bool) := if v then k^-1 else 1 - k^-1 in
  let e' := coin_response m in let e v := r * e' v in
  [/\ law p, law q, pure_dp k p q, spread m e' & expect p e = r * (m * k / (m + k - 1)) * expect q e'].
Proof.
move=> k1 m1 r0 p q e' e; have k0 : 0 < k := lt_le_trans ltr01 k1.
have den : m + k - 1 != 0 by rewrite gt_eqF // -addrA ltr_paddr ?subr_ge0 // (lt_le_trans ltr01).
have kn : k != 0 by rewrite gt_eqF.
split.
- exact: law_point.
- split=> [v|]; last by rewrite big_bool /= addrC subrK.
  by case: v; rewrite /q ?invr_ge0 ?(ltW k0) // subr_ge0 invf_le1.
- by move=> v; case: v; rewrite /p /q /point /= ?divff // mulr_ge0 ?(ltW k0) // subr_ge0 invf_le1.
- by have [] := T12_sharp k1 m1.
rewrite expectZ expect_point -mulrA; congr (_ * _); rewrite /expect big_bool /= /e' /coin_response mulr1.
have -> : k^-1 * m + (1 - k^-1) = (m + k - 1) / k by rewrite !mulrDl mulNr divff // mul1r mulrC addrA.
by rewrite mulrA divfK // mulfK.
Qed.

Theorem T14_one_sided_reversed_sharp k m r : 1 <= k -> 1 <= m -> 0 <= r ->
  let p (v : bool) := if v then 1 - k^-1 else k^-1 in let q := point R false in
  let e' := coin_response m in let e v := r * e' v in
  [/\ law p, law q, pure_dp k q p, spread m e & expect p e = r * ((m * k - m + 1) / k) * expect q e'].
Proof.
move=> k1 m1 r0 p q e' e; have k0 : 0 < k := lt_le_trans ltr01 k1.
have kn : k != 0 by rewrite gt_eqF.
split.
- split=> [v|]; last by rewrite big_bool /= subrK.
  by case: v; rewrite /p ?invr_ge0 ?(ltW k0) // subr_ge0 invf_le1.
- exact: law_point.
- by move=> v; case: v; rewrite /p /q /point /= ?divff // mulr_ge0 ?(ltW k0) // subr_ge0 invf_le1.
- by move=> v v'; rewrite mulrCA; apply: ler_wpmul2l => //; have [_ _ s _] := T12_sharp k1 m1; apply: s.
rewrite expectZ expect_point -mulrA; congr (_ * _); rewrite /expect big_bool /= /e' /coin_response !mulr1.
apply: (mulIf kn); rewrite divfK //; transitivity (m * k - k^-1 * k * m + k^-1 * k); first by ring.
by rewrite mulVf // mul1r.
Qed.

(* How large k and m have to be to explain a ratio rho = R_obs/R* away: the factor of T14 reaches rho. *)
Theorem T14_frontier k m rho : 1 <= k -> 1 <= m -> 1 < rho ->
  (rho <= contraction k m) = (rho < k) && ((rho * k - 1) / (k - rho) <= m).
Proof.
move=> k1 m1 rho1; have den : 0 < m + k by rewrite addr_gt0 ?(lt_le_trans ltr01).
rewrite /contraction ler_pdivl_mulr //; have [rk|kr] := ltP rho k.
  rewrite ler_pdivr_mulr ?subr_gt0 //= -subr_ge0 -[RHS]subr_ge0; congr (_ <= _); ring.
apply/negbTE; rewrite -ltNge -subr_gt0.
have -> : rho * (m + k) - (1 + m * k) = m * (rho - k) + (rho * k - 1) by ring.
have rho0 : 0 < rho := lt_trans ltr01 rho1.
have lt1 : 1 < rho * k by apply: lt_le_trans rho1 _; apply: ler_pemulr => //; apply: ltW.
apply: ltr_paddl; last by rewrite subr_gt0.
by apply: mulr_ge0; rewrite ?subr_ge0 // (le_trans ler01 m1).
Qed.

(* ---- The other way: how much unfairness may be hidden ---- *)

(* Each v has a share of at least pi in both groups, the spreads are m1 and m2; with pi = 0 the factor is m1 m2. *)
Theorem T14_hidden_most V pi m1 m2 (p q e e' : V -> R) v : law p -> law q -> 1 <= m1 -> 1 <= m2 ->
  0 <= pi -> pi <= p v -> pi <= q v -> (forall v, 0 <= e v) -> (forall v, 0 <= e' v) -> spread m1 e -> spread m2 e' ->
  e v * ((pi * m1 + 1 - pi) * expect q e') <= m1 * (pi + (1 - pi) * m2) * expect p e * e' v.
Proof.
move=> lp lq h1 h2 pi0 pv qv e0 e0' s s'; have m0 : 0 < m1 := lt_le_trans ltr01 h1.
have m0' : 0 < m2 := lt_le_trans ltr01 h2.
have rest (P : V -> R) : law P -> \sum_(w | w != v) P w = 1 - P v.
  by case=> _ P1; rewrite -P1 [in RHS](bigD1 v) //= [in RHS]addrC addKr.
have low : e v * (pi * m1 + 1 - pi) <= m1 * expect p e.
  apply: (@le_trans _ _ (m1 * (p v * e v) + (1 - p v) * e v)).
    rewrite -subr_ge0 [leRHS](_ : _ = (p v - pi) * (m1 - 1) * e v); last by ring.
    by rewrite !mulr_ge0 ?subr_ge0.
  rewrite /expect [in leRHS](bigD1 v) //= mulrDr ler_add2l -(rest p lp) mulr_suml mulr_sumr; apply: ler_sum => w _.
  by rewrite mulrCA ler_wpmul2l ?s //; case: lp.
have up : expect q e' <= (pi + (1 - pi) * m2) * e' v.
  apply: (@le_trans _ _ (q v * e' v + (1 - q v) * (m2 * e' v))).
    rewrite /expect (bigD1 v) //= ler_add2l -(rest q lq) mulr_suml; apply: ler_sum => w _.
    by rewrite ler_wpmul2l ?s' //; case: lq.
  rewrite -subr_ge0 [leRHS](_ : _ = (q v - pi) * (m2 - 1) * e' v); last by ring.
  by rewrite !mulr_ge0 ?subr_ge0.
rewrite mulrA -!mulrA [leRHS]mulrA [m1 * _]mulrC.
have -> : (pi + (1 - pi) * m2) * m1 * (expect p e * e' v) = m1 * expect p e * ((pi + (1 - pi) * m2) * e' v) by ring.
rewrite mulrA; apply: ler_pmul => //; last by apply: expect_ge0.
rewrite mulr_ge0 // -addrA addr_ge0 ?mulr_ge0 ?(ltW m0) // subr_ge0; apply: le_trans pv _.
exact: law_le1.
Qed.

Theorem T14_hidden_most_attained pi m1 m2 : 0 <= pi -> pi <= 1 - pi -> 1 <= m1 -> 1 <= m2 ->
  let p (v : bool) := if v then pi else 1 - pi in
  let e (v : bool) := if v then m1 else 1 in let e' (v : bool) := if v then 1 else m2 in
  [/\ law p, forall v, pi <= p v, spread m1 e, spread m2 e' &
    e true * ((pi * m1 + 1 - pi) * expect p e') = m1 * (pi + (1 - pi) * m2) * expect p e * e' true].
Proof.
move=> pi0 piH h1 h2 p e e'; have mm m : 1 <= m -> 1 <= m * m by move=> m1'; rewrite -[1]mul1r ler_pmul ?ler01.
split.
- split=> [v|]; last by rewrite big_bool /= addrC subrK.
  by case: v => //=; apply: le_trans piH.
- by case.
- by case; case; rewrite /e ?mulr1 ?mm //; apply: ler_pemulr => //; apply: le_trans h1.
- by case; case; rewrite /e' ?mulr1 ?mm //; apply: ler_pemulr => //; apply: le_trans h2.
rewrite /expect !big_bool /p /e /e' /=; ring.
Qed.

(* ---- All contexts and pairs ---- *)

Variables (X A U Hid : finType) (Sh : X -> A -> Hid -> R) (P : X * Hid -> A -> U -> R) (g : U -> X * Hid -> A -> R).
Hypotheses (kS : forall x, kernel (Sh x)) (kP : forall xv, kernel (P xv)) (g0 : forall u xv a, 0 <= g u xv a).

(* E(x,v,a), and E(x,a) as it was observed: the mean over the hidden factor. *)
Local Notation fine := (utility P g).
Definition observed (x : X) (a : A) : R := expect (Sh x a) (fun v => fine (x, v) a).

(* If R <= r with the hidden context, then R_obs <= r (1 + mk)/(m + k). *)
Theorem T14_local k m r : 1 <= k -> 1 <= m -> 0 <= r -> (forall x a a', pure_dp k (Sh x a) (Sh x a')) ->
  (forall x a a', spread m (fun v => fine (x, v) a) \/ spread m (fun v => fine (x, v) a')) ->
  local_le r fine -> local_le (r * contraction k m) observed.
Proof.
move=> k1 m1 r0 sh s hr x a a'; apply: T14_hidden => //; try exact: kS.
- by move=> v; apply: expect_ge0 => [|u]; [exact: kP|exact: g0].
- by move=> v; apply: expect_ge0 => [|u]; [exact: kP|exact: g0].
Qed.

End T14.
