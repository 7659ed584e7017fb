(* Tables with missing cells, groups without mass, and policies that are known only where something can be released.

   The other files speak of all contexts x and all groups a.  Here each theorem that claims cite is stated for the cells
   that are there, present x a, and for the groups that have mass, massive a.  Whatever stands in other cells, in other
   rows of W and in other rows of a policy has no part in it. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions DP Ratios T1 T3 T5 T6 T7 T8 T12 T13 T13_near T13_floor T13_range T14 T16 T17 Rules.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* exp L <= r among the cells that are there, exp Lbar <= r among the groups that have mass. *)
Definition local_le_on (R : realFieldType) (X A : finType) (present : X -> A -> bool) (r : R) (E : X -> A -> R) : Prop :=
  forall x a a', present x a -> present x a' -> E x a <= r * E x a'.
Definition global_le_on (R : realFieldType) (A : finType) (massive : A -> bool) (r : R) (M : A -> R) : Prop :=
  forall a a', massive a -> massive a' -> M a <= r * M a'.

(* ---- Tables ---- *)

Section Tables.
Variables (R : realFieldType) (X A U : finType) (present : X -> A -> bool) (massive : A -> bool).
Variables (P : X -> A -> U -> R) (W : A -> X -> R).
Implicit Types (r : R) (E : X -> A -> R) (M : A -> R).

(* The general lemma: in a context, the cells that are there make a full table over the groups that are there. *)
Definition groups_in (x : X) : finType := [finType of {a : A | present x a}].

Lemma local_le_onP r E :
  local_le_on present r E <-> forall x, local_le r (fun (_ : unit) (a : groups_in x) => E x (val a)).
Proof.
split=> [h x [] a a'|h x a a' pa pa']; first by apply: h; apply: valP.
exact: (h x tt (Sub a pa) (Sub a' pa')).
Qed.

(* The same for groups: those that have mass make a full table. *)
Definition groups_with_mass : finType := [finType of {a : A | massive a}].

Lemma global_le_onP r M : global_le_on massive r M <-> global_le r (fun a : groups_with_mass => M (val a)).
Proof.
split=> [h a a'|h a a' ma ma']; first by apply: h; apply: valP.
exact: (h (Sub a ma) (Sub a' ma')).
Qed.

(* A cell without mass may hold anything. *)
Theorem group_mean_partial E E' a : (forall x, W a x != 0 -> E x a = E' x a) -> group_mean W E a = group_mean W E' a.
Proof.
move=> same; apply: eq_bigr => x _; have [->|/same->//] := eqVneq (W a x) 0.
by rewrite !mul0r.
Qed.

Theorem group_law_partial P' a : (forall x, W a x != 0 -> P x a =1 P' x a) -> group_law P W a =1 group_law P' W a.
Proof.
move=> same u; apply: eq_bigr => x _; have [->|/same->//] := eqVneq (W a x) 0.
by rewrite !mul0r.
Qed.

(* T6, in contexts and of means. *)
Theorem T6_local_partial r :
  (forall g, a_free g -> (forall u x a, 0 <= g u x a) -> local_le_on present r (utility P g)) <->
  (forall x a a', present x a -> present x a' -> pure_dp r (P x a) (P x a')).
Proof.
split=> [h x a a' pa pa' u|h g fg g0 x a a' pa pa'].
  by have := h (decision R u) (fun _ _ _ _ => erefl) (fun v _ _ => ler0n R (v == u)) x a a' pa pa'; rewrite !utility_decision.
have -> : utility P g x a = expect (P x a) (fun u => g u x a') by apply: eq_expect => // u; apply: fg.
by apply: T6_upper => [|u]; [apply: h|apply: g0].
Qed.

Theorem T6_zero_denominator_partial x a a' u : present x a -> present x a' -> 0 < P x a u -> P x a' u = 0 ->
  forall r, ~ local_le_on present r (utility P (decision R u)).
Proof.
move=> pa pa' p0 p0' r /(_ x a a' pa pa'); rewrite !utility_decision p0' mulr0.
by rewrite leNgt p0.
Qed.

Theorem T6_exists_partial : (forall x a, present x a -> law (P x a)) ->
  (forall x a a' u, present x a -> present x a' -> P x a' u = 0 -> P x a u = 0) ->
  forall x0 a0, present x0 a0 -> exists x a a' u, let r := P x a u / P x a' u in
  [/\ present x a /\ present x a', 0 < P x a' u, utility P (decision R u) x a = r * utility P (decision R u) x a' &
      forall g, a_free g -> (forall u x a, 0 <= g u x a) -> local_le_on present r (utility P g)].
Proof.
move=> lP null x0 a0 p0.
have P_ge0 x a u : present x a -> 0 <= P x a u by move=> /lP[].
have [u0 u0_gt0] : exists u, 0 < P x0 a0 u.
  apply/existsP; apply: contraT => /existsPn none.
  have := proj2 (lP _ _ p0); rewrite big1 => [/eqP|u _]; first by rewrite eq_sym oner_eq0.
  by apply/eqP; rewrite eq_le P_ge0 // leNgt none.
pose ratio (c : X * A * A * U) := P c.1.1.1 c.1.1.2 c.2 / P c.1.1.1 c.1.2 c.2.
pose seen (c : X * A * A * U) := [&& present c.1.1.1 c.1.1.2, present c.1.1.1 c.1.2 & 0 < P c.1.1.1 c.1.2 c.2].
have seen0 : seen (x0, a0, a0, u0) by rewrite /seen /= p0.
have [[[[x a] a'] u] /and3P[/= pa pa' u_seen] maximal] := @arg_maxP _ R _ (x0, a0, a0, u0) seen ratio seen0.
exists x, a, a', u; split=> //; first by rewrite !utility_decision divfK // gt_eqF.
apply/T6_local_partial => y b b' pb pb' v; have [v_seen|] := boolP (seen (y, b, b', v)).
  have := maximal _ v_seen; rewrite /ratio /= ler_pdivr_mulr //.
  by case/and3P: v_seen.
rewrite /seen /= pb pb' lt_neqAle P_ge0 // andbT negbK eq_sym => /eqP v0.
by rewrite v0 (null _ _ _ _ pb pb' v0) mulr0.
Qed.

Theorem T6_global_partial r :
  (forall g : U -> R, (forall u, 0 <= g u) -> global_le_on massive r (group_mean W (utility P (fun u _ _ => g u)))) <->
  (forall a a', massive a -> massive a' -> pure_dp r (group_law P W a) (group_law P W a')).
Proof.
have [full_to full_from] := @T6_global R X groups_with_mass U (fun x a => P x (val a)) (fun a => W (val a)) r.
split=> [h a a' ma ma'|h g g0]; last first.
  by apply/global_le_onP; apply: full_from g0 => a a'; apply: h; apply: valP.
by apply: (full_to _ (Sub a ma) (Sub a' ma')) => g g0; have /global_le_onP := h g g0.
Qed.

(* T7 *)
Theorem T7_equalized_odds_partial r : (forall x a, present x a -> law (P x a)) ->
  (forall g, a_free g -> (forall u x a, 0 <= g u x a) -> local_le_on present r (utility P g)) ->
  forall x a a', present x a -> present x a' -> tv (P x a) (P x a') <= (r - 1) / (r + 1).
Proof.
move=> lP /T6_local_partial fair x a a' pa pa'.
by apply: T7_symmetric; [apply: lP|apply: lP|apply: fair|apply: fair].
Qed.

Lemma law_group_law a : law (W a) -> (forall x, W a x != 0 -> law (P x a)) -> law (group_law P W a).
Proof.
move=> [W0 W1] lP; split=> [u|].
  apply: sumr_ge0 => x _; have [->|/lP[P0 _]] := eqVneq (W a x) 0; first by rewrite mul0r.
  by rewrite mulr_ge0.
rewrite exchange_big -W1; apply: eq_bigr => x _; rewrite -mulr_sumr.
by have [->|/lP[_ ->]] := eqVneq (W a x) 0; rewrite ?mul0r ?mulr1.
Qed.

Theorem T7_demographic_parity_partial r : (forall a, massive a -> law (W a)) ->
  (forall x a, massive a -> W a x != 0 -> law (P x a)) ->
  (forall g : U -> R, (forall u, 0 <= g u) -> global_le_on massive r (group_mean W (utility P (fun u _ _ => g u)))) ->
  forall a a', massive a -> massive a' -> tv (group_law P W a) (group_law P W a') <= (r - 1) / (r + 1).
Proof.
move=> lW lP /T6_global_partial fair a a' ma ma'.
have l b : massive b -> law (group_law P W b) by move=> mb; apply: law_group_law => [|x]; [exact: lW|exact: lP].
by apply: T7_symmetric; [apply: l|apply: l|apply: fair|apply: fair].
Qed.

(* T5: if context and group are independent among the groups that have mass, every cell of positive mass being there. *)
Theorem T5_independent_partial r E : (forall a x, massive a -> 0 <= W a x) ->
  (forall a a' x, massive a -> massive a' -> W a x = W a' x) -> (forall a x, massive a -> W a x != 0 -> present x a) ->
  local_le_on present r E -> global_le_on massive r (group_mean W E).
Proof.
move=> W0 ind there fair a a' ma ma'; apply: ratio_of_sums => x; rewrite (ind a a') //.
have [->|w] := eqVneq (W a' x) 0; first by rewrite !mul0r mulr0.
rewrite mulrCA ler_wpmul2l ?W0 //; apply: fair; last exact: there w.
by apply: (there a x ma); rewrite (ind a a').
Qed.

(* T16: the verdict under drift, of the cells that are there. *)
Theorem T16_local_partial (g : U -> X -> A -> R) (eta V : R) (gamma m theta theta' : X -> A -> R) :
  (forall x a, present x a -> law (P x a)) -> 1 <= V ->
  (forall u x a, present x a -> [/\ 0 <= g u x a, m x a <= g u x a & g u x a <= gamma x a]) ->
  (forall x a, present x a -> theta x a <= gamma x a /\ m x a <= theta' x a) ->
  (forall x a a', present x a -> present x a' -> a != a' ->
    up_end eta (gamma x a) (theta x a) (P x a) (fun u => g u x a) <=
    V * down_end eta (m x a') (theta' x a') (P x a') (fun u => g u x a')) ->
  forall D, (forall x a, present x a -> law (D x a) /\ tv (D x a) (P x a) <= eta) -> local_le_on present V (utility D g).
Proof.
move=> lP V1 rg th ends D dr; apply/local_le_onP => x.
have := @T16_local R unit_finType (groups_in x) U (fun _ a => P x (val a)) (fun u _ a => g u x (val a)) eta V
  (fun _ a => gamma x (val a)) (fun _ a => m x (val a)) (fun _ a => theta x (val a)) (fun _ a => theta' x (val a)).
have pv (a : groups_in x) : present x (val a) by apply: valP.
apply=> // [_ a|u _ a|u _ a|_ a|_ a|_ a a' aa'|_ a]; first exact: lP.
- by have [] := rg u x _ (pv a).
- by have [_ -> ->] := rg u x _ (pv a).
- by have [] := th x _ (pv a).
- by have [] := th x _ (pv a).
- exact: ends.
- exact: dr.
Qed.

(* T14 among the groups that are there: among people who are alike in the hidden factor some ratio is at least as said. *)
Theorem T14_local_partial (Hid : finType) (Sh : X -> A -> Hid -> R) (fine : X -> Hid -> A -> R) k m r :
  (forall x a, present x a -> law (Sh x a)) -> (forall x v a, present x a -> 0 <= fine x v a) -> 1 <= k -> 1 <= m -> 0 <= r ->
  (forall x a a', present x a -> present x a' -> pure_dp k (Sh x a) (Sh x a')) ->
  (forall x a a', present x a -> present x a' -> spread m (fun v => fine x v a) \/ spread m (fun v => fine x v a')) ->
  (forall x v, local_le_on (fun _ : unit => present x) r (fun _ => fine x v)) ->
  local_le_on present (r * contraction k m) (fun x a => expect (Sh x a) (fun v => fine x v a)).
Proof.
move=> lS f0 k1 m1 r0 dpS spr fair x a a' pa pa'.
apply: (@T14_hidden _ _ k m) => //; try by [apply: lS|apply: dpS|move=> v; apply: f0|apply: spr].
by move=> v; apply: (fair x v tt).
Qed.

End Tables.

(* ---- Groups without mass behind filters ---- *)

Section Masses.
Variables (R : realFieldType) (X Xt A At U : finType) (massive : A -> bool).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (W : A -> X -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (lW : forall a, massive a -> law (W a)).
Implicit Types (T : Xt -> At -> U -> R) (g : U -> X -> A -> R) (V : R).
Local Notation M T g := (group_mean W (utility (induced MX MA T) g)).
Local Notation G := (groups_with_mass massive).

Let kG : kernel (fun a : G => MA (val a)). Proof. by move=> a; apply: kA. Qed.
Let lG (a : G) : law (W (val a)). Proof. by apply: lW; apply: valP. Qed.
Let W0 (a : G) x : 0 <= W (val a) x. Proof. by case: (lG a). Qed.

Theorem T5_independent_filter_partial T k g : policy T ->
  (forall a a' x, massive a -> massive a' -> W a x = W a' x) -> (forall u x a, 0 <= g u x a) -> a_free g ->
  every_pair (pure_dp k) MA -> global_le_on massive k (M T g).
Proof.
move=> kT ind g0 fg d; apply/global_le_onP.
suff full : global_le k (group_mean (fun a : G => W (val a)) (utility (induced MX (fun a : G => MA (val a)) T) (fun u x a => g u x (val a)))).
  exact: full.
by apply: T5_independent_filter => // a a' x; apply: ind; exact: valP.
Qed.

Theorem T5_decision_partial T (g : U -> R) k c : policy T -> (forall u, 0 <= g u) -> every_pair (pure_dp k) MA ->
  (forall a a', massive a -> massive a' -> pure_dp c (after W MX a) (after W MX a')) ->
  global_le_on massive (k * c) (M T (fun u _ _ => g u)).
Proof.
move=> kT g0 d dW; apply/global_le_onP.
suff full : global_le (k * c) (group_mean (fun a : G => W (val a)) (utility (induced MX (fun a : G => MA (val a)) T) (fun u _ _ => g u))).
  exact: full.
by apply: T5_decision => // a a'; apply: dW; apply: valP.
Qed.

Section Suprema.
Variables (u0 : U) (g : U -> X -> A -> R).
Hypothesis g0 : forall u x a, 0 <= g u x a.
Let gG (u : U) x (a : G) : R := g u x (val a).
Let gG0 u x a : 0 <= gG u x a. Proof. exact: g0. Qed.

Theorem T13_global_ratio_partial V : 1 <= V ->
  (forall T, policy T -> global_le_on massive V (M T g)) <->
  (forall a a', massive a -> massive a' -> a != a' -> global_surplus u0 MX MA g W V a a' <= 0).
Proof.
move=> V1; have [full_to full_from] := @T13_global_ratio R X Xt G At U u0 MX _ gG _ kX kG gG0 W0 V V1.
split=> [h a a' ma ma' aa'|h T kT].
  by apply: (full_to _ (Sub a ma) (Sub a' ma')) => // T kT; have /global_le_onP := h T kT.
by apply/global_le_onP; apply: full_from kT => a a' aa'; apply: h => //; apply: valP.
Qed.

(* That a policy attains V makes V least, whatever the masses: it is the pair (a,a') that shows it. *)
Theorem attained_partial (class : (Xt -> At -> U -> R) -> Prop) T V a a' : massive a -> massive a' ->
  class T -> 0 < M T g a' -> M T g a = V * M T g a' ->
  forall V', (forall T, class T -> global_le_on massive V' (M T g)) -> V <= V'.
Proof.
move=> ma ma' cT den num V' h.
apply: (T13_attained (num := fun T => M T g a) (den := fun T => M T g a') cT den num) => T' /h; exact.
Qed.

Theorem T13_global_supremum_partial V a a' (d : Xt * At -> U) : massive a -> massive a' -> 1 <= V ->
  (forall a a', massive a -> massive a' -> a != a' -> global_surplus u0 MX MA g W V a a' <= 0) ->
  \sum_o (global_part MX MA g W a o (d o) - V * global_part MX MA g W a' o (d o)) = 0 ->
  0 < \sum_o global_part MX MA g W a' o (d o) ->
  let T := by_shown R d in
  [/\ forall T, policy T -> global_le_on massive V (M T g), policy T, 0 < M T g a', M T g a = V * M T g a' &
      forall V', (forall T, policy T -> global_le_on massive V' (M T g)) -> V <= V'].
Proof.
move=> ma ma' V1 sur e den T.
have surG (b b' : G) : b != b' -> global_surplus u0 MX (fun a : G => MA (val a)) gG (fun a : G => W (val a)) V b b' <= 0.
  by move=> bb'; apply: sur => //; apply: valP.
have [le kT dT eT _] := @T13_global_supremum R X Xt G At U u0 MX _ gG _ kX kG gG0 W0 V (Sub a ma) (Sub a' ma') d V1 surG e den.
have leV T' : policy T' -> global_le_on massive V (M T' g) by move=> /le h; apply/global_le_onP.
by split=> //; apply: (attained_partial (class := @policy R Xt At U) ma ma' kT).
Qed.

Theorem T13_global_infinite_partial a a' (d : Xt * At -> U) : massive a -> massive a' ->
  (forall o, global_part MX MA g W a' o (d o) = 0) -> 0 < \sum_o global_part MX MA g W a o (d o) ->
  let T := by_shown R d in
  [/\ policy T, M T g a' = 0, 0 < M T g a & forall V, ~ (forall T, policy T -> global_le_on massive V (M T g))].
Proof.
move=> ma ma' zero pos T.
have [kT eT pT _] := T13_global_infinite zero pos.
by split=> // V /(_ T kT a a' ma ma'); rewrite eT mulr0 leNgt pT.
Qed.

End Suprema.

(* A range of utilities: the rows of the groups that have mass. *)
Section Range.
Variables (T : Xt -> At -> U -> R) (g : U -> X -> A -> R) (m gamma L : R) (a a' : A).
Hypotheses (kT : policy T) (ma : massive a) (ma' : massive a').
Hypotheses (vg : valued m gamma g) (gL : forall u x a a', g u x a <= g u x a' + L).
Local Notation K := (gap m gamma L).
Local Notation H k := (hockey_stick k (mean_row MA W a) (mean_row MA W a')).
Let gG (u : U) x (b : G) : R := g u x (val b).
Let vG : valued m gamma gG. Proof. by move=> u x b; apply: vg. Qed.
Let GL u x b b' : gG u x b <= gG u x b' + L. Proof. exact: gL. Qed.

Theorem T13_range_global_partial V : 0 <= V -> K + (gamma - K - m) * H V <= m * (V - 1) -> M T g a <= V * M T g a'.
Proof. exact: (@T13_range_global R X Xt G At U MX _ T gG kX kG kT _ m gamma L lG vG GL V (Sub a ma) (Sub a' ma')). Qed.

Theorem T13_range_floor_global_partial tau k : 0 <= k -> 0 < tau -> tau <= M T g a' ->
  M T g a <= (k + Num.max 0 (K + (gamma - K - m) * H k - (k - 1) * m) / tau) * M T g a'.
Proof. exact: (@T13_range_floor_global R X Xt G At U MX _ T gG kX kG kT _ m gamma L lG vG GL tau k (Sub a ma) (Sub a' ma')). Qed.

Theorem T13_range_cap_global_partial tau : 0 <= gamma -> 0 < tau -> tau <= M T g a' -> M T g a <= gamma / tau * M T g a'.
Proof. exact: (@T13_range_cap_global R X Xt G At U MX _ T gG kX kG kT _ m gamma lG vG tau (Sub a ma) (Sub a' ma')). Qed.

End Range.

(* n releases of the group *)
Theorem T17_releases_global_partial (u0 : U) n g V : (forall u x a, 0 <= g u x a) -> 1 <= V ->
  (forall T : Xt -> {ffun 'I_n -> At} -> U -> R, policy T ->
     global_le_on massive V (group_mean W (utility (induced MX (@releases R A At MA n) T) g))) <->
  (forall a a', massive a -> massive a' -> a != a' -> global_surplus u0 MX (@releases R A At MA n) g W V a a' <= 0).
Proof.
move=> g0 V1.
have [full_to full_from] := @T17_releases_global R X Xt G At U u0 n MX _ (fun u x (a : G) => g u x (val a)) _ kX kG
  (fun u x a => g0 u x (val a)) W0 V V1.
split=> [h a a' ma ma' aa'|h T kT].
  by apply: (full_to _ (Sub a ma) (Sub a' ma')) => // T kT; have /global_le_onP := h T kT.
by apply/global_le_onP; apply: full_from kT => a a' aa'; apply: h => //; apply: valP.
Qed.

End Masses.

(* ---- Policies that are known where something can be released ---- *)

Section Released.
Variables (R : realFieldType) (X Xt A At U : finType) (released : Xt -> At -> bool).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA).
Hypothesis all_released : forall x a y b, 0 < MX x y -> 0 < MA a b -> released y b.
Hypothesis rows : forall y b, released y b -> law (T y b).

(* The policy that repeats a known row y0, b0 where there is none. *)
Definition completed (y0 : Xt) (b0 : At) (y : Xt) (b : At) : U -> R := if released y b then T y b else T y0 b0.

(* The general lemma: a table that has a row for everything that can be released is as good as a policy.  All that is
   proved of every policy is so proved of it. *)
Theorem policy_completed y0 b0 : released y0 b0 ->
  [/\ policy (completed y0 b0), forall y b, released y b -> completed y0 b0 y b = T y b &
      forall x a, induced MX MA (completed y0 b0) x a =1 induced MX MA T x a].
Proof.
move=> r0; split=> [y b|y b|x a u]; first by rewrite /completed; case: ifP => [/rows//|_]; apply: rows.
  by rewrite /completed => ->.
apply: eq_bigr => y _; apply: eq_bigr => b _; rewrite /completed; case: ifP => // nr.
have X0 : 0 <= MX x y by case: (kX x).
have A0 : 0 <= MA a b by case: (kA a).
have : (MX x y == 0) || (MA a b == 0).
  by apply: contraFT nr; rewrite negb_or => /andP[xn an]; apply: (@all_released x a); rewrite lt_def ?xn ?an.
by case/orP => /eqP->; rewrite ?mulr0 !mul0r.
Qed.

(* Something is released. *)
Lemma something_released (x : X) (a : A) : exists y b, released y b.
Proof.
have pick (B : finType) (Q : B -> R) : law Q -> exists b, 0 < Q b.
  move=> [Q0 Q1]; apply/existsP; apply: contraT => /existsPn none.
  have : \sum_b Q b = 0 by rewrite big1 // => b _; apply/eqP; rewrite eq_le Q0 leNgt none.
  by rewrite Q1 => /eqP; rewrite oner_eq0.
have [y My] := pick _ _ (kX x); have [b Mb] := pick _ _ (kA a).
by exists y, b; apply: all_released My Mb.
Qed.

End Released.

Section AnyFilter.
Variables (R : realFieldType) (X Xt A At U : finType) (released : At -> bool).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R) (g : U -> X -> A -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (kT : policy T) (only : forall a b, 0 < MA a b -> released b).
Local Notation E := (utility (induced MX MA T) g).

(* Where nothing is released, what another value is answered with serves as well. *)
Lemma answered (x : X) (a : A) : exists (T' : Xt -> At -> U -> R) (f : At -> At),
  [/\ policy T', forall x a, utility (induced MX MA T') g x a = E x a, forall b, released (f b) &
      forall y b, T' y b = T y (f b)].
Proof.
have [_ [b0 r0]] := @something_released R X Xt A At (fun _ => released) MX MA kX kA (fun _ a _ b _ => @only a b) x a.
pose f b := if released b then b else b0; exists (fun y b => T y (f b)), f; split=> // [y b|{}x {}a|b].
- exact: kT.
- apply: eq_expect => // u; apply: eq_bigr => y _; apply: eq_bigr => b _; rewrite /f; case: ifP => // nr.
  have [-> | nz] := eqVneq (MA a b) 0; first by rewrite mulr0 !mul0r.
  have M0 : 0 <= MA a b by case: (kA a).
  by move: nr; rewrite (@only a b) // lt_def nz.
- by rewrite /f; case: ifP.
Qed.

(* T12, with R0 over what can be released. *)
Theorem T12_released k r : 1 <= k -> 1 <= r -> (forall u x a, 0 <= g u x a) -> a_free g ->
  (forall x a b b', released b -> released b' -> response MX T g x a b <= r * response MX T g x a b') ->
  every_pair (pure_dp k) MA -> local_le (contraction k r) E.
Proof.
move=> k1 r1 g0 fg hr d x a a'; have [T' [f [kT' same rel fE]]] := answered x a.
rewrite -!same; apply: T12_contraction => // {}x {}a b b'.
have e c : response MX T' g x a c = response MX T g x a (f c) by apply: eq_bigr => y _; apply: eq_bigr => u _; rewrite fE.
by rewrite !e; apply: hr.
Qed.

Theorem T12_any_filter_released r : a_free g ->
  (forall x a b b', released b -> released b' -> response MX T g x a b <= r * response MX T g x a b') -> local_le r E.
Proof.
move=> fg hr x a a'; have [T' [f [kT' same rel fE]]] := answered x a.
rewrite -!same; apply: T12_any_filter => // {}x {}a b b'.
have e c : response MX T' g x a c = response MX T g x a (f c) by apply: eq_bigr => y _; apply: eq_bigr => u _; rewrite fE.
by rewrite !e; apply: hr.
Qed.

(* T3 by eps alone, with the floor of the policy over what can be released. *)
Theorem T3_any_filter_released gamma tau k e x a a' : 0 <= gamma -> valued 0 gamma g -> a_free g ->
  0 <= k -> 1 <= e -> every_pair (pure_dp e) MA -> 0 < tau ->
  (forall x a y b, 0 < MX x y -> released b -> tau <= expect (T y b) (fun u => g u x a)) ->
  E x a <= (k + gamma * hockey_stick k (truth e) (lie e) / tau) * E x a'.
Proof.
move=> g0 vg fg k0 e1 d t0 floor; have [T' [f [kT' same rel fE]]] := answered x a.
by rewrite -!same; apply: T3_any_filter => // {}x {}a y b My; rewrite fE; apply: floor.
Qed.

End AnyFilter.
