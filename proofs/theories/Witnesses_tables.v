(* Hypotheses that can be met: the theorems about tables that claims cite, applied (see Witnesses.v). *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions DP Ratios Rows T1 T6 T7 T12 T14 T15 T16 T19 Partial Witnesses.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* The law of a table: in both contexts the first group gets a yes with probability 2/3, the second with 1/3. *)
Definition P (x a u : bool) : rat := two_three 2 a u.

Lemma kP x : kernel (P x). Proof. exact: kernel_coin. Qed.
Lemma lP x a : law (P x a). Proof. exact: kP. Qed.
Lemma dP x a a' : pure_dp 2%:R (P x a) (P x a'). Proof. exact: dA. Qed.
Lemma P_gt0 x a u : 0 < P x a u. Proof. by case: a; case: u. Qed.
Lemma lA a : law (MA a). Proof. exact: kA. Qed.
Lemma tv_self (U : finType) (D : U -> rat) : tv D D = 0.
Proof. by apply: big1 => u _; rewrite mul1r subrr maxxx. Qed.

Lemma fair_P h : a_free h -> (forall u x a, 0 <= h u x a) -> local_le 2%:R (utility P h).
Proof. by move=> fh h0; apply: (proj2 (T6_local P 2%:R) _ h fh h0) => x a a'; apply: dP. Qed.

(* ---- T6, T7 ---- *)

Example T6_local_applies : local_le 2%:R (utility P g).
Proof. by apply: (proj2 (T6_local P 2%:R)) => [x a a'|//|]; [exact: dP|exact: g_ge0]. Qed.

Example T6_attained_applies x : utility P (decision _ true) x true = 2%:R * utility P (decision _ true) x false.
Proof. by apply: T6_attained. Qed.

Example T6_exists_applies : exists x a a' u, 0 < P x a' u /\
  utility P (decision _ u) x a = P x a u / P x a' u * utility P (decision _ u) x a'.
Proof.
have null x a a' u : P x a' u = 0 -> P x a u = 0 by move=> e; have := P_gt0 x a' u; rewrite e ltxx.
by have [x [a [a' [u [p e _]]]]] := T6_exists kP null true true; exists x, a, a', u.
Qed.

Example T6_zero_denominator_applies : ~ local_le 5%:R (utility (fun _ a u : bool => (a == u)%:R : rat) (decision _ true)).
Proof. by apply: (@T6_zero_denominator _ _ _ _ _ true true false true). Qed.

Example T6_global_applies : global_le 2%:R (group_mean even (utility P (fun u _ _ => worth u))).
Proof.
apply: (proj2 (T6_global P even 2%:R)); last exact: worth_ge0.
move=> a a' u; rewrite /group_law mulr_sumr; apply: ler_sum => x _.
by rewrite [X in _ <= X]mulrCA ler_wpmul2l // dP.
Qed.

Example T6_global_attained_applies a : group_mean even (utility P (fun v _ _ => point _ true v)) a = group_law P even a true.
Proof. exact: T6_global_attained. Qed.

(* The second group is missing in the second context, where the table holds no law. *)
Definition torn (x a u : bool) : rat := if there x a then P x a u else 5%:R.

Lemma law_torn x a : there x a -> law (torn x a).
Proof. by rewrite /torn => pa; split=> [u|]; rewrite pa; case: (lP x a). Qed.

Lemma dp_torn x a a' : there x a -> there x a' -> pure_dp 2%:R (torn x a) (torn x a').
Proof. by rewrite /torn => pa pa' u; rewrite pa pa' dP. Qed.

Example T6_local_partial_applies : local_le_on there 2%:R (utility torn g).
Proof. by apply: (proj2 (T6_local_partial there torn 2%:R)) => [x a a'|//|]; [exact: dp_torn|exact: g_ge0]. Qed.

Example T6_zero_denominator_partial_applies :
  ~ local_le_on there 5%:R (utility (fun _ a u : bool => (a == u)%:R : rat) (decision _ true)).
Proof. by apply: (@T6_zero_denominator_partial _ _ _ _ there _ true true false true). Qed.

Example T6_exists_partial_applies : exists x a a' u, [/\ there x a, there x a' & 0 < torn x a' u].
Proof.
have null x a a' u : there x a -> there x a' -> torn x a' u = 0 -> torn x a u = 0.
  by rewrite /torn => -> -> e; have := P_gt0 x a' u; rewrite e ltxx.
by have [x [a [a' [u [[p q] r _ _]]]]] := T6_exists_partial law_torn null (isT : there true true); exists x, a, a', u.
Qed.

Lemma dp_mass a a' : has_mass a -> has_mass a' -> pure_dp 2%:R (group_law torn some_mass a) (group_law torn some_mass a').
Proof. by case: a; case: a' => // _ _ []; rewrite /group_law !big_bool. Qed.

Example T6_global_partial_applies : global_le_on has_mass 2%:R (group_mean some_mass (utility torn (fun u _ _ => worth u))).
Proof. by apply: (proj2 (T6_global_partial has_mass torn some_mass 2%:R)); [exact: dp_mass|exact: worth_ge0]. Qed.

Example T7_symmetric_applies a a' : tv (MA a) (MA a') <= (2%:R - 1) / (2%:R + 1).
Proof. by apply: T7_symmetric; [exact: lA|exact: lA|exact: dA|exact: dA]. Qed.

Example T7_equalized_odds_applies x a a' : tv (P x a) (P x a') <= (2%:R - 1) / (2%:R + 1).
Proof. exact: (T7_equalized_odds kP fair_P). Qed.

Example T7_demographic_parity_applies a a' : tv (group_law P even a) (group_law P even a') <= (2%:R - 1) / (2%:R + 1).
Proof.
apply: (T7_demographic_parity kP) => [b|h h0 b b']; first exact: k_even.
apply: (proj2 (T6_global P even 2%:R) _ h h0 b b') => c c' u; rewrite /group_law mulr_sumr; apply: ler_sum => x _.
by rewrite [X in _ <= X]mulrCA ler_wpmul2l // dP.
Qed.

Example T7_equalized_odds_partial_applies : tv (torn true true) (torn true false) <= (2%:R - 1) / (2%:R + 1).
Proof.
apply: (T7_equalized_odds_partial law_torn) => // h fh h0.
by apply: (proj2 (T6_local_partial there torn 2%:R)) => // x a a'; apply: dp_torn.
Qed.

Example T7_demographic_parity_partial_applies :
  tv (group_law torn some_mass true) (group_law torn some_mass true) <= (2%:R - 1) / (2%:R + 1).
Proof.
apply: (T7_demographic_parity_partial law_some_mass (P := torn)) => //.
  by move=> x [] // _ _; apply: law_torn; case: x.
by move=> h h0; apply: (proj2 (T6_global_partial has_mass torn some_mass 2%:R)) => // a a'; apply: dp_mass.
Qed.

(* ---- T14: a factor that is twice as common in one group as in the other ---- *)

Definition flat (v : bool) : rat := 1.
Definition treble (v : bool) : rat := 3%:R.
Lemma spread_flat : spread 2%:R flat. Proof. by []. Qed.
Lemma ge0_flat v : 0 <= flat v. Proof. by []. Qed.
Lemma zero_one : 0 <= 1 :> rat. Proof. by []. Qed.
Lemma one_two : 1 <= 2%:R :> rat. Proof. by []. Qed.

Example T14_frontier_applies : (11%:R / 10%:R <= contraction 2%:R 2%:R :> rat) =
  (11%:R / 10%:R < 2%:R :> rat) && ((11%:R / 10%:R * 2%:R - 1) / (2%:R - 11%:R / 10%:R) <= 2%:R :> rat).
Proof. by apply: T14_frontier. Qed.

Example T14_hidden_applies : expect (MA true) flat <= 1 * contraction 2%:R 2%:R * expect (MA false) flat.
Proof. by apply: (T14_hidden (lA true) (lA false) one_two one_two _ (dA _ _) (dA _ _)) => //; right. Qed.

Example T14_exceeds_applies : exists v, 1 * flat v < treble v.
Proof.
apply: (T14_exceeds (lA true) (lA false) one_two one_two _ (dA _ _) (dA _ _)) => //; first by right.
by rewrite /expect !big_bool.
Qed.

Example T14_any_spread_applies : expect (MA true) flat <= 1 * 2%:R * expect (MA false) flat.
Proof. by apply: (T14_any_spread (lA true) (lA false) _ (dA _ _)). Qed.

Example T14_one_sided_applies :
  expect (MA true) flat <= 1 * (2%:R * 2%:R / (2%:R + 2%:R - 1)) * expect (MA false) flat.
Proof. by apply: (T14_one_sided (lA true) (lA false) one_two one_two _ (dA _ _)). Qed.

Example T14_one_sided_reversed_applies :
  expect (MA true) flat <= 1 * ((2%:R * 2%:R - 2%:R + 1) / 2%:R) * expect (MA false) flat.
Proof. by apply: (T14_one_sided_reversed (lA true) (lA false) one_two one_two _ (dA _ _)). Qed.

Example T14_sharp_applies : law (coin_filter (2%:R : rat) true) /\ pure_dp 2%:R (coin_filter (2%:R : rat) true) (coin_filter 2%:R false).
Proof. by have [[? ? ? ? ?] _] := T14_sharp one_two one_two zero_one. Qed.

Example T14_one_sided_sharp_applies : law (point rat_realFieldType true).
Proof. by have [] := T14_one_sided_sharp one_two one_two zero_one. Qed.

Example T14_one_sided_reversed_sharp_applies : law (point rat_realFieldType false).
Proof. by have [] := T14_one_sided_reversed_sharp one_two one_two zero_one. Qed.

Definition Sh (x a v : bool) : rat := MA a v.
Definition flat_law (xv : bool * bool) (a u : bool) : rat := 2%:R^-1.
Definition one (u : bool) (xv : bool * bool) (a : bool) : rat := 1.

Lemma fine_E xv a : utility flat_law one xv a = 1. Proof. by rewrite /utility /expect big_bool. Qed.

Example T14_local_applies : local_le (1 * contraction 2%:R 2%:R) (observed Sh flat_law one).
Proof.
apply: (@T14_local _ _ _ _ _ Sh flat_law one _ _ _ 2%:R 2%:R 1) => // [x a|xv a|x a a'|x a a'|xv a a'].
- exact: lA.
- by split=> [[]|] //; rewrite big_bool.
- exact: dA.
- by left=> v v'; rewrite !fine_E.
- by rewrite !fine_E.
Qed.

Example T14_local_partial_applies :
  local_le_on there (1 * contraction 2%:R 2%:R) (fun x a => expect (Sh x a) (fun v => flat v)).
Proof.
apply: (@T14_local_partial _ _ _ there _ Sh (fun _ v _ => flat v)) => // [x a _|x a a' _ _|x a a' _ _].
- exact: lA.
- exact: dA.
- by left.
Qed.

(* ---- T16: drift of each cell by 1/10 ---- *)

Definition tenth : rat := 10%:R^-1.
Definition worth_of := worth.
Lemma drift_self a : tv (MA a) (MA a) <= tenth. Proof. by rewrite tv_self. Qed.
Lemma worth_le u : worth u <= 2%:R. Proof. by case: u. Qed.
Lemma worth_ge u : 1 <= worth u. Proof. by case: u. Qed.

Example T16_up_applies : expect (MA true) worth <= up_end tenth 2%:R 1 (MA true) worth.
Proof. by apply: (T16_up (lA true) (lA true) (drift_self true) worth_le). Qed.

Example T16_down_applies : down_end tenth 1 2%:R (MA true) worth <= expect (MA true) worth.
Proof. by apply: (T16_down (lA true) (lA true) (drift_self true) worth_ge). Qed.

Example T16_attained_applies : exists theta D,
  [/\ theta <= 2%:R, law D, tv D (MA true) <= tenth & expect D worth = up_end tenth 2%:R theta (MA true) worth].
Proof. by apply: (@T16_attained _ _ tenth (MA true) worth true (lA true)) => // v; apply: worth_le. Qed.

Example T16_attained_down_applies : exists theta D,
  [/\ 1 <= theta, law D, tv D (MA true) <= tenth & expect D worth = down_end tenth 1 theta (MA true) worth].
Proof. by apply: (@T16_attained_down _ _ tenth (MA true) worth false (lA true)) => // v; apply: worth_ge. Qed.

Example T16_within_applies : expect (MA true) worth <= 2%:R * expect (MA false) worth.
Proof.
apply: (T16_within (lA true) (lA false) two0 worth_le worth_ge (theta := 1) (theta' := 2%:R) (eta := tenth)) => //; try exact: lA; try exact: drift_self.
by rewrite /up_end /down_end /expect !big_bool.
Qed.

Example T16_exceeds_applies : 2%:R^-1 * expect (MA false) worth < expect (MA true) worth.
Proof.
apply: (T16_exceeds (lA true) (lA false) _ worth_ge worth_le (theta := 2%:R) (theta' := 1) (eta := tenth)) => //; try exact: lA; try exact: drift_self.
by rewrite /up_end /down_end /expect !big_bool.
Qed.

Example T16_before_applies : 2%:R^-1 * expect (MA false) worth < expect (MA true) worth.
Proof.
apply: (T16_before (lA true) (lA false) _ worth_ge worth_le (theta := 2%:R) (theta' := 1) (eta := tenth) (zeta := 0)) => //;
  try exact: lA; try (by rewrite tv_self).
by rewrite /up_end /down_end /expect !big_bool.
Qed.

Example T16_worst_applies : exists D D', [/\ law D, law D', tv D (MA true) <= tenth & tv D' (MA false) <= tenth].
Proof. by have [|D [D' [h _]]] := @T16_worst _ _ (MA true) (MA false) worth worth tenth (lA true) (lA false); last by exists D, D'. Qed.

Lemma ends_meet (a a' : bool) : up_end tenth 2%:R 1 (MA a) worth <= 2%:R * down_end tenth 1 2%:R (MA a') worth.
Proof. by case: a; case: a'; rewrite /up_end /down_end /expect !big_bool. Qed.

Example T16_local_applies : local_le 2%:R (utility P g).
Proof.
apply: (@T16_local _ _ _ _ P g tenth 2%:R (fun _ _ => 2%:R) (fun _ _ => 1) (fun _ _ => 1) (fun _ _ => 2%:R) kP g_ge0) => //.
- by case.
- by move=> x a a' _; apply: ends_meet.
- by move=> x a; split; [exact: lP|rewrite tv_self].
Qed.

Example T16_local_partial_applies : local_le_on there 2%:R (utility torn g).
Proof.
apply: (@T16_local_partial _ _ _ _ there torn g tenth 2%:R (fun _ _ => 2%:R) (fun _ _ => 1) (fun _ _ => 1) (fun _ _ => 2%:R) law_torn) => //.
- by case.
- by move=> x a a' pa pa' _; rewrite /torn pa pa'; apply: ends_meet.
- by move=> x a pa; split; [exact: law_torn|rewrite tv_self].
Qed.

Lemma dp_self a : pure_dp 2%:R (MA a) (MA a). Proof. exact: dA. Qed.

Example T16_factor_up_applies : expect (MA true) worth <= factor_up 2%:R 1 (MA true) worth.
Proof. by apply: (T16_factor_up 1 worth (lA true) one_two (dp_self true) (dp_self true)). Qed.

Example T16_factor_down_applies : factor_down 2%:R 1 (MA true) worth <= expect (MA true) worth.
Proof. by apply: (T16_factor_down 1 worth (lA true) one_two (dp_self true) (dp_self true)). Qed.

Example T16_global_applies : group_mean MA E true <= factor_up 2%:R 1 (MA true) (fun _ => 2%:R).
Proof.
apply: (@T16_global _ _ _ MA MA E (fun _ _ => 2%:R) 2%:R kA one_two dp_self dp_self 1 true) => x.
by case/andP: (utility_ranged kX kA kT x true g_1_2).
Qed.

Example T16_global_down_applies : factor_down 2%:R 1 (MA true) (fun _ => 1) <= group_mean MA E true.
Proof.
apply: (@T16_global_down _ _ _ MA MA E (fun _ _ => 1) 2%:R kA one_two dp_self dp_self 1 true) => x.
by case/andP: (utility_ranged kX kA kT x true g_1_2).
Qed.

(* ---- T19: the second of two decisions is undecided ---- *)

Definition undecided : {set bool} := [set false].
Definition meant (i : bool) : rat := if i then 1 else 2%:R^-1.

Lemma meaning_meant : meaning flat undecided 0 1 meant.
Proof. by case; rewrite !inE. Qed.

Example T19_mean_applies : low flat flat undecided 0 <= mean flat meant <= high flat flat undecided 1.
Proof. by apply: T19_mean meaning_meant. Qed.

Example T19_attained_applies : exists2 v, meaning flat undecided 0 1 v & mean flat v = low flat flat undecided 0.
Proof.
apply: T19_attained => //; rewrite lexx /=.
by have /andP[] := T19_mean_applies; apply: le_trans.
Qed.

Example T19_population_applies : 0 <= mean flat meant <= 1.
Proof.
by apply: T19_population meaning_meant _ _ => //; rewrite /low /high /T19.mean /T19.worth !big_bool !inE.
Qed.

Definition at_least (a : bool) : rat := 1.
Definition at_most (a : bool) : rat := 2%:R.
Lemma between_ends : between at_least at_most at_least. Proof. by move=> a; rewrite lexx. Qed.

Example T19_greatest_applies : at_least true <= 2%:R * at_least false.
Proof. by apply: (T19_greatest (l := at_least) (h := at_most)). Qed.

Example T19_greatest_attained_applies : exists y, [/\ between at_least at_most y, y true = 2%:R & y false = 1].
Proof. by apply: (@T19_greatest_attained _ _ at_least at_most). Qed.

Example T19_least_applies : 2%:R^-1 * at_least false <= at_least true.
Proof. by apply: (@T19_least _ _ at_least at_most). Qed.

Example T19_level_applies : exists y, between at_least at_most y /\ forall a, 1 <= y a <= 2%:R.
Proof. by apply: (@T19_level _ _ at_least at_most _ 2%:R 1 1). Qed.

Example T19_equal_applies : exists y, between at_least at_most y /\ forall a, y a = 1.
Proof. by apply: (@T19_equal _ _ at_least at_most). Qed.

(* ---- T15: one row of unknown group, worth 2; both groups have one row, worth 1 ---- *)

Definition row (i : unit) : rat := 2%:R.
Definition labelled (c : bool) : rat := 1.
Definition how_many (c : bool) : nat := 1.
Definition none (c : bool) : nat := 0.
Definition to_first (i : unit) : bool := true.
Definition one_each (c : bool) : nat := 1.

Lemma received_unit (f : unit -> bool) c : received f c = if f tt == c then [set: unit] else set0.
Proof. by apply/setP => -[]; rewrite !inE; case: ifP; rewrite inE. Qed.

Lemma mean_unit f c : T15.mean row labelled how_many f c = if f tt == c then 3%:R / 2%:R else 1.
Proof.
rewrite /T15.mean /total received_unit; case: ifP => _; last by rewrite big_set0 cards0.
by rewrite cardsT card_unit (eq_bigl xpredT) => [|i]; rewrite ?inE // (bigD1 tt) //= big1 // => -[].
Qed.

Example T15_greatest_applies : with_best row labelled how_many true 1 <= 3%:R / 2%:R * with_worst row labelled how_many false 0.
Proof.
apply: (proj1 (@T15_greatest _ _ _ row labelled how_many none one_each _ true false _ (3%:R / 2%:R) _)) => // [f _|].
  by rewrite !mean_unit; case: (f tt).
by rewrite /allowed card_unit !big_pred0 // => -[].
Qed.

Lemma cards_unit : #|[set: unit]| = 1%N. Proof. by rewrite cardsT card_unit. Qed.

Lemma ranked_unit : ranked_value row setT 0 = 2%:R.
Proof. by have [|i _ ->] := @ranked_value_in _ _ row setT 0; rewrite ?cards_unit. Qed.

Lemma no_best : with_best row labelled how_many true 0 = 1.
Proof. by rewrite /with_best top0. Qed.

Lemma no_worst : with_worst row labelled how_many true 0 = 1.
Proof. by rewrite /with_worst /bottom subn0 drop_oversize ?size_ranked // big_nil. Qed.

(* The lower mean is the one without the row, the upper one that with it. *)
Example T15_least_mean_applies : with_worst row labelled how_many true 0 <= with_worst row labelled how_many true 1.
Proof.
apply: (@T15_least_mean _ _ _ row labelled how_many true _ 0 0 1) => //; first by rewrite card_unit.
by rewrite card_unit subnn ranked_unit no_worst.
Qed.

Example T15_greatest_mean_applies : with_best row labelled how_many true 0 <= with_best row labelled how_many true 1.
Proof.
apply: (@T15_greatest_mean _ _ _ row labelled how_many true _ 1 0 1); rewrite ?card_unit //.
by case=> // _; rewrite ranked_unit no_best.
Qed.
