(* Hypotheses that can be met: groups that nobody recorded (T15), and pruning in the search for subgroups (T18) (see Witnesses.v). *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions Rows T15_proxies T18 Witnesses.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* Two cells of weight 1, in each of which groups and decisions are as frequent and independent. *)
Definition weight (w : bool) : rat := 1.
Definition gain (w u : bool) : rat := worth u.
Definition quarter (w a u : bool) : rat := 4%:R^-1.
Definition at_1 (w : bool) : rat := 1.
Definition at_2 (w : bool) : rat := 2%:R.

Lemma weight_ge0 w : 0 <= weight w. Proof. by []. Qed.

Lemma division_quarter : division even quarter.
Proof. by move=> w; split=> [a u|u]; rewrite ?big_bool. Qed.

Lemma completion_quarter : completion even even quarter.
Proof. by split=> [|w a]; [exact: division_quarter|rewrite big_bool]. Qed.

Lemma mass_gt0 a : 0 < T15_proxies.mass weight even a. Proof. by rewrite /T15_proxies.mass big_bool. Qed.

Lemma one_set (a : bool) (F : bool -> rat) : \sum_(b in [set a]) F b = F a. Proof. exact: big_set1. Qed.

Lemma most_2 a : most weight even even gain at_2 [set a] = 2%:R.
Proof. by rewrite /most !big_bool !one_set. Qed.

Lemma least_1 a : least weight even even gain at_1 [set a] = 1.
Proof. by rewrite /least !big_bool !one_set. Qed.

Lemma mass_1 a : T15_proxies.mass weight even a = 1. Proof. by rewrite /T15_proxies.mass big_bool. Qed.

Example T15_cells_applies (a : bool) : least weight even even gain at_1 [set a] <= \sum_(b in [set a]) got weight gain quarter b <= most weight even even gain at_2 [set a].
Proof. exact: (T15_cells gain weight_ge0 at_1 at_2 [set a] completion_quarter). Qed.

Example T15_cells_pair_applies : mean weight even gain quarter true <= 2%:R * mean weight even gain quarter false.
Proof.
apply: (T15_cells_pair (theta := at_2) (theta' := at_1) weight_ge0 completion_quarter two0 (mass_gt0 _) (mass_gt0 _)).
by rewrite most_2 least_1 !mass_1.
Qed.

Example T15_cells_exceeds_applies : exists a a', [/\ a \in [set true], a' \in [set false] &
  4%:R^-1 * mean weight even gain quarter a' < mean weight even gain quarter a].
Proof.
apply: (T15_cells_exceeds (theta := at_1) (theta' := at_2) weight_ge0 completion_quarter _ mass_gt0) => //.
by rewrite most_2 least_1 !one_set !mass_1.
Qed.

Example T15_cells_attained_applies : exists j, completion even even j.
Proof. by have [|j [? _]] := @T15_cells_attained _ _ _ _ weight even even gain weight_ge0 k_even k_even true false; last by exists j. Qed.

Example T15_cells_interval_applies : got weight gain quarter true <= 2%:R * (\sum_w weight w * (\sum_u quarter w true u)).
Proof.
apply: (T15_cells_interval (l := even) (h := even) (theta := at_2) weight_ge0 division_quarter) => [w|]; first by rewrite big_bool.
by rewrite !big_bool.
Qed.

(* ---- T18: all rows are worth 1 ---- *)

Lemma zero_one : 0 <= 1 :> rat. Proof. by []. Qed.
Lemma one_ge0 i : 0 <= weight i. Proof. by []. Qed.
Lemma zero_or_one i : (weight i == 0) || (weight i == 1). Proof. by []. Qed.
Lemma passes j : (1 <= j <= #|[set: bool]|)%N -> passes_up weight 1 setT j /\ passes_down weight 1 setT j.
Proof. by have [_] := T18_example rat_realFieldType; apply. Qed.

Lemma all_rows : (1 <= #|[set: bool]|)%N. Proof. by rewrite cardsT card_bool. Qed.
Lemma sizes : (1 <= #|[set true]| < #|bool_finType|)%N. Proof. by rewrite cards1 card_bool. Qed.

Example rows_extremes_applies : exists S' : {set bool}, [/\ S' \subset [set: bool], #|S'| = 1%N & total weight S' = top weight setT 1].
Proof. by have [_ ? _] := rows_extremes weight all_rows. Qed.

Example T18_pruning_applies : differs_up weight 1 [set true].
Proof. exact: (T18_pruning (nmin := 1%N) zero_one isT (fun j jn _ => proj1 (passes jn)) (subsetT _) sizes). Qed.

Example T18_pruning_down_applies : differs_down weight 1 [set true].
Proof. exact: (T18_pruning_down (nmin := 1%N) zero_one isT (fun j jn _ => proj2 (passes jn)) (subsetT _) sizes). Qed.

Lemma first_row : (1 <= 1 <= #|[set: bool]|)%N. Proof. by rewrite all_rows. Qed.

Example T18_value_classes_applies : passes_up weight 1 [set: bool] 1.
Proof. exact: (T18_value_classes one_ge0 (lexx 1) all_rows (fun j jn _ _ => proj1 (passes jn)) first_row). Qed.

Example T18_value_classes_down_applies : passes_down weight 1 [set: bool] 1.
Proof. exact: (T18_value_classes_down one_ge0 (lexx 1) all_rows (fun j jn _ _ => proj2 (passes jn)) first_row). Qed.

Lemma at_ones (n : nat) : (n <= 2)%N -> (1 <= maxn 1 n <= #|[set: bool]|)%N.
Proof. by rewrite cardsT card_bool leq_maxl geq_max. Qed.

Example T18_zero_one_applies : passes_up weight 1 [set: bool] 1.
Proof.
have le : (#|positives weight setT| <= 2)%N by rewrite -card_bool max_card.
exact: (T18_zero_one one_ge0 zero_or_one (lexx 1) first_row (proj1 (passes (at_ones le))) first_row).
Qed.

Example T18_zero_one_down_applies : passes_down weight 1 [set: bool] 1.
Proof.
have le : (#|[set: bool]| - #|positives weight setT| <= 2)%N by rewrite (leq_trans (leq_subr _ _)) // -card_bool max_card.
exact: (T18_zero_one_down one_ge0 zero_or_one (lexx 1) first_row (proj2 (passes (at_ones le))) first_row).
Qed.
