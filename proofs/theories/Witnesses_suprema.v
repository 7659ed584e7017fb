(* Hypotheses that can be met: T13 and T17, as claims cite them, applied (see Witnesses.v). *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions DP T1 T5 T12 T13 T13_near T13_floor T13_range T17 Partial Witnesses.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Local Notation no := false.

(* A yes is worth 1 and a no 0; the policies take the decision that is shown, in context and group. *)
Definition hit (u x a : bool) : rat := u%:R.
Definition say (b : bool) : bool := b.
Definition say_second (o : bool * bool) : bool := o.2.
Definition E_of (T : bool -> bool -> bool -> rat) : bool -> bool -> rat := utility (induced MX MA T) hit.
Definition M_of (T : bool -> bool -> bool -> rat) : bool -> rat := group_mean even (E_of T).
Definition exact : bool -> bool -> rat := @identity rat_realFieldType bool_finType.
Definition said : bool -> bool -> bool -> rat := fun _ => always _ say.

Lemma hit_ge0 u x a : 0 <= hit u x a. Proof. exact: ler0n. Qed.
Lemma even_ge0 a x : 0 <= even a x. Proof. by []. Qed.
Lemma k_exact : kernel exact. Proof. exact: kernel_identity. Qed.
Lemma true_no : true != no. Proof. by []. Qed.
Lemma one_le_two : 1 <= 2%:R :> rat. Proof. by []. Qed.

Lemma sum_pairs (F : bool * bool -> rat) :
  \sum_o F o = F (true, true) + F (true, false) + (F (false, true) + F (false, false)).
Proof.
rewrite (eq_bigr (fun o => F (o.1, o.2))) => [|[] //].
by rewrite -(pair_bigA _ (fun x y => F (x, y))) !big_bool.
Qed.

Lemma hit_2 T' : policy T' -> local_le 2%:R (E_of T').
Proof. by move=> kT'; apply: T2_pure; [exact: kX|exact: kT'|exact: hit_ge0| |exact: dA]. Qed.

Lemma mean_2 T' : policy T' -> global_le 2%:R (M_of T').
Proof. by move=> kT'; apply: T5_independent_filter; [exact: k_even|exact: kX|exact: kT'| |exact: hit_ge0| |exact: dA]. Qed.

Lemma surplus_2 x a a' : a != a' -> local_surplus true MA hit 2%:R x a a' <= 0.
Proof. by move=> _; apply/(T13_local true MA hit kX) => T' kT'; apply: hit_2. Qed.

Lemma mean_surplus_2 a a' : a != a' -> global_surplus true MX MA hit even 2%:R a a' <= 0.
Proof. by move=> _; apply/(T13_global true) => T' kT'; apply: mean_2. Qed.

(* ---- T13 ---- *)

Definition all_ones (o u : bool) : rat := 1.
Definition zeros (o u : bool) : rat := 0.
Lemma ones_ge0 o u : 0 <= all_ones o u. Proof. by []. Qed.
Lemma zeros_ge0 o u : 0 <= zeros o u. Proof. by []. Qed.

Example T13_any_policy_applies : surplus true all_ones all_ones 1 <= 0.
Proof. by apply/T13_any_policy => T' _; rewrite mul1r. Qed.

Example T13_deterministic_applies : exists d, 1 * value (always _ d) zeros < value (always _ d) all_ones.
Proof.
apply: (T13_deterministic (u0 := true)); rewrite ltNge; apply/negP => /T13_any_policy/(_ _ (@kernel_identity _ _)).
by rewrite /value !big_bool.
Qed.

Example T13_infinite_applies : exists T, [/\ kernel T, value T zeros = 0 & 0 < value T all_ones].
Proof. by apply/(T13_infinite true ones_ge0 zeros_ge0); exists say; rewrite big_bool. Qed.

Example T13_supremum_applies : (exists d, value (always _ d) zeros = 0 /\ 0 < value (always _ d) all_ones) \/
  (exists V, [/\ 1 <= V, surplus true all_ones zeros V <= 0 &
     V = 1 \/ exists d, 0 < value (always _ d) zeros /\ value (always _ d) all_ones = V * value (always _ d) zeros]).
Proof. exact: (T13_supremum true ones_ge0 zeros_ge0). Qed.

Example T13_local_ratio_applies : local_le 2%:R (E_of T).
Proof. by apply: (proj2 (T13_local_ratio true kX kA hit_ge0 one_le_two)); [exact: surplus_2|exact: kT]. Qed.

Example T13_local_supremum_applies x : E_of said x true = 2%:R * E_of said x false /\ 0 < E_of said x false.
Proof.
have e : \sum_b (MA true b * hit (say b) x true - 2%:R * (MA false b * hit (say b) x false)) = 0 by rewrite big_bool.
have pos : 0 < \sum_b MA false b * hit (say b) x false by rewrite big_bool.
by have [_ _ ? ? _] := T13_local_supremum (Xt := bool_finType) kX kA hit_ge0 one_le_two surplus_2 e pos.
Qed.

Example T13_local_infinite_applies x : utility (induced MX exact said) hit x false = 0 /\ 0 < utility (induced MX exact said) hit x true.
Proof.
have zero b : exact false b * hit (say b) x false = 0 by case: b.
by have [|_ ? ? _] := T13_local_infinite kX zero (a := true); rewrite ?big_bool.
Qed.

Example T13_global_ratio_applies : global_le 2%:R (M_of T).
Proof. by apply: (proj2 (T13_global_ratio true kX kA hit_ge0 even_ge0 one_le_two)); [exact: mean_surplus_2|exact: kT]. Qed.

Definition said_second : bool -> bool -> bool -> rat := by_shown _ say_second.

Lemma mean_attained : \sum_o (global_part MX MA hit even true o (say_second o) - 2%:R * global_part MX MA hit even false o (say_second o)) = 0.
Proof. by rewrite sum_pairs /global_part !big_bool. Qed.

Lemma mean_positive : 0 < \sum_o global_part MX MA hit even false o (say_second o).
Proof. by rewrite sum_pairs /global_part !big_bool. Qed.

Example T13_global_supremum_applies : M_of said_second true = 2%:R * M_of said_second false /\ 0 < M_of said_second false.
Proof.
by have [_ _ ? ? _] := T13_global_supremum kX kA hit_ge0 even_ge0 one_le_two mean_surplus_2 mean_attained mean_positive.
Qed.

Lemma nothing_lower o : global_part MX exact hit even false o (say_second o) = 0.
Proof. by case: o => [[] []]; rewrite /global_part !big_bool. Qed.

Lemma something_higher : 0 < \sum_o global_part MX exact hit even true o (say_second o).
Proof. by rewrite sum_pairs /global_part !big_bool. Qed.

Example T13_global_infinite_applies : group_mean even (utility (induced MX exact said_second) hit) false = 0.
Proof. by have [] := T13_global_infinite nothing_lower something_higher. Qed.

Example T13_merge_surplus_applies (one_class := fun _ : bool => tt) :
  surplus true (fun o u => MA true o.2 * hit u o.1 true) (fun o u => MA true o.2 * hit u o.1 true) 1 =
  surplus true (fun o u => merged one_class (MA true) o.2 * hit u o.1 true) (fun o u => merged one_class (MA true) o.2 * hit u o.1 true) 1.
Proof.
have M0 b : 0 <= MA true b by case: (kA true).
by apply: (T13_merge_surplus true M0 M0 _ (fun x u => hit u x true) (fun x u => hit u x true)) => b b' _; rewrite mulrC.
Qed.

(* ---- The same where only the first group has mass ---- *)

Lemma hit_partial T' : policy T' -> global_le_on has_mass 2%:R (group_mean some_mass (E_of T')).
Proof. by move=> kT'; apply: T5_independent_filter_partial; meet; [exact: law_some_mass|move=> [] []|exact: hit_ge0]. Qed.

Lemma surplus_partial a a' : has_mass a -> has_mass a' -> a != a' -> global_surplus true MX MA hit some_mass 2%:R a a' <= 0.
Proof. by case: a; case: a'. Qed.

Example T13_global_ratio_partial_applies : global_le_on has_mass 2%:R (group_mean some_mass (E_of T)).
Proof.
by apply: (proj2 (T13_global_ratio_partial kX kA law_some_mass true hit_ge0 one_le_two)); [exact: surplus_partial|exact: kT].
Qed.

Lemma both_mass a : law (even a). Proof. exact: k_even. Qed.

Example T13_global_supremum_partial_applies :
  group_mean even (E_of said_second) true = 2%:R * group_mean even (E_of said_second) false.
Proof.
have [_ _ _ ? _] := @T13_global_supremum_partial _ _ _ _ _ _ (fun=> true) MX MA even kX kA (fun a _ => both_mass a) true hit hit_ge0
  2%:R true false say_second isT isT one_le_two (fun a a' _ _ => @mean_surplus_2 a a') mean_attained mean_positive.
by [].
Qed.

Example T13_global_infinite_partial_applies : group_mean even (utility (induced MX exact said_second) hit) false = 0.
Proof. by have [] := T13_global_infinite_partial (massive := fun=> true) isT isT nothing_lower something_higher. Qed.

Lemma kT_E : 0 < M_of T false. Proof. by rewrite /M_of /group_mean /E_of /utility /expect /induced !big_bool. Qed.

Example attained_partial_applies : M_of T true / M_of T false <= 2%:R.
Proof.
apply: (@attained_partial _ _ _ _ _ _ (fun=> true) MX MA even hit (@policy _ _ _ _) T _ true false) => //; first exact: kT.
- exact: kT_E.
- by rewrite -/(M_of T true) divfK // gt_eqF // kT_E.
- by move=> T' kT' a a' _ _; apply: mean_2.
Qed.

(* ---- With floors ---- *)

Definition no_floor (x a : bool) : rat := 0.
Definition no_multiplier (x a : bool) : rat := 0.
Definition low_floor (x a : bool) : rat := 4%:R^-1.
Definition low_mean_floor (a : bool) : rat := 4%:R^-1.
Definition none (a : bool) : rat := 0.

Lemma sum_le0 (I : finType) (F : I -> rat) : (forall i, F i <= 0) -> \sum_i F i <= 0.
Proof. by move=> F0; rewrite -oppr_ge0 -sumrN; apply: sumr_ge0 => i _; rewrite oppr_ge0. Qed.

Lemma greatest_le0 (c : bool -> rat) : (forall u, c u <= 0) -> greatest true c <= 0.
Proof. by rewrite /greatest. Qed.

Lemma keeps_T : keeps MX MA hit even low_floor low_mean_floor T.
Proof.
split=> [x a|a]; first by case: x; case: a; rewrite /utility /expect /induced !big_bool.
by case: a; rewrite /group_mean /utility /expect /induced !big_bool.
Qed.


Lemma k_all_ones : kernel (fun _ u : bool => even u u). Proof. by move=> o; split=> [[]|] //; rewrite big_bool. Qed.
Definition flip (o u : bool) : rat := even u u.

Example T13_floor_applies : value flip all_ones <= 1 * value flip all_ones.
Proof.
apply: (@T13_floor _ _ _ unit_finType true flip all_ones all_ones (fun _ => all_ones) (fun=> 0) (fun=> 0) 1 k_all_ones) => // [_|].
  by rewrite /value !big_bool.
rewrite big1 => [|c _]; last by rewrite mulr0.
apply: sum_le0 => o; apply: greatest_le0 => u.
by rewrite /gain mul1r subrr add0r big1 // => c _; rewrite mul0r.
Qed.

Lemma no_gain (p q : bool * bool -> bool -> rat) V :
  (forall o u, p o u <= V * q o u) ->
  with_floors true MX MA hit even p q (fun _ _ => 0) (fun=> 0) V <= of_floors low_floor low_mean_floor (fun _ _ => 0) (fun=> 0).
Proof.
move=> pq; rewrite /of_floors !big1 ?addr0 => [|a _|x _]; last 2 first.
- by rewrite mul0r.
- by rewrite big1 // => a _; rewrite mul0r.
apply: sum_le0 => o; apply: greatest_le0 => u; rewrite /gain !big1 ?addr0 ?subr_le0 // => [a _|x _]; first by rewrite mul0r.
by rewrite big1 // => a _; rewrite mul0r.
Qed.

Lemma cell_2 x a a' o u : cell_part MX MA hit x a o u <= 2%:R * cell_part MX MA hit x a' o u.
Proof. by case: x; case: a; case: a'; case: u; case: o => [[] []]. Qed.

Lemma mean_part_2 a a' o u : global_part MX MA hit even a o u <= 2%:R * global_part MX MA hit even a' o u.
Proof. by case: a; case: a'; case: u; case: o => [[] []]; rewrite /global_part !big_bool. Qed.

Example T13_floor_local_applies x : E_of T x true <= 2%:R * E_of T x false.
Proof. by apply: (T13_floor_local kT keeps_T _ _ (no_gain (@cell_2 x true false))). Qed.

Example T13_floor_global_applies : M_of T true <= 2%:R * M_of T false.
Proof. by apply: (T13_floor_global kT keeps_T _ _ (no_gain (@mean_part_2 true false))). Qed.

Example T13_floor_one_k_applies x : E_of T x true <= 2%:R * E_of T x false.
Proof.
apply: (T13_floor_one_k (u0 := true) kX kT (proj1 keeps_T x false) (lexx 2%:R)); rewrite subrr mul0r.
exact: surplus_2.
Qed.

Example T13_floor_one_k_global_applies : M_of T true <= 2%:R * M_of T false.
Proof.
apply: (T13_floor_one_k_global (u0 := true) kT (proj2 keeps_T false) (lexx 2%:R)); rewrite subrr mul0r.
exact: mean_surplus_2.
Qed.

Example T13_mean_floor_applies a : Num.max (low_mean_floor a) (\sum_x even a x * low_floor x a) <= M_of T a.
Proof. exact: (T13_mean_floor even_ge0 a keeps_T). Qed.

Lemma E_gt0 x a : 0 < E_of T x a.
Proof. exact: lt_le_trans (proj1 keeps_T x a). Qed.

Example T13_floor_attained_applies : E_of T true true / E_of T true false <= 2%:R.
Proof.
apply: (T13_floor_attained kT keeps_T (E_gt0 true false)) => [|T' kT' _]; last exact: hit_2.
by rewrite divfK // gt_eqF // E_gt0.
Qed.

Example T13_floor_attained_global_applies : M_of T true / M_of T false <= 2%:R.
Proof.
apply: (T13_floor_attained_global kT keeps_T kT_E) => [|T' kT' _]; last exact: mean_2.
by rewrite divfK // gt_eqF // kT_E.
Qed.

(* ---- Near a policy ---- *)

Lemma take_nothing (U : finType) (D c : U -> rat) : law D -> from_least 0 D c (fun=> 0).
Proof. by move=> [D0 _]; split=> [|u v _]; [split=> [u|]; rewrite ?lexx ?D0 // big1|rewrite ltxx]. Qed.

Lemma k_joint o : law (joint T o). Proof. exact: kT. Qed.

Example T13_near_exists_applies : exists r, from_least 2%:R^-1 (MA true) (fun u => hit u true true) r.
Proof. by apply: T13_near_exists; [exact: kA|]. Qed.

Example T13_near_applies : moved_value true flip (fun _ _ => 0) (gain all_ones all_ones 1) <= 0.
Proof.
apply: (proj1 (@T13_near _ _ _ true 0 flip _ all_ones all_ones 1 k_all_ones _)) => [o|T' _ _]; last by rewrite mul1r.
by apply: take_nothing; apply: k_all_ones.
Qed.

Example T13_near_local_applies x :
  moved_value true (joint T) (fun _ _ => 0) (gain (cell_part MX MA hit x true) (cell_part MX MA hit x false) 2%:R) <= 0.
Proof.
apply: (proj1 (@T13_near_local _ _ _ _ _ _ true MX MA hit T 0 kT 2%:R _ x true false _)) => [o|T' kT' _].
  by apply: take_nothing; apply: k_joint.
exact: hit_2.
Qed.

Example T13_near_global_applies :
  moved_value true (joint T) (fun _ _ => 0) (gain (global_part MX MA hit even true) (global_part MX MA hit even false) 2%:R) <= 0.
Proof.
apply: (proj1 (@T13_near_global _ _ _ _ _ _ true MX MA hit even T 0 kT 2%:R _ true false _)) => [o|T' kT' _].
  by apply: take_nothing; apply: k_joint.
exact: mean_2.
Qed.

Lemma near_itself : near_policy T 0 T.
Proof. by move=> y b; rewrite /tv /hockey_stick big1 // => u _; rewrite mul1r subrr maxxx. Qed.

Example T13_near_attained_applies : E_of T true true / E_of T true false <= 2%:R.
Proof.
apply: (T13_near_attained kT near_itself (E_gt0 true false)) => [|T' kT' _]; last exact: hit_2.
by rewrite divfK // gt_eqF // E_gt0.
Qed.

Example T13_near_attained_global_applies : M_of T true / M_of T false <= 2%:R.
Proof.
apply: (T13_near_attained_global kT near_itself kT_E) => [|T' kT' _]; last exact: mean_2.
by rewrite divfK // gt_eqF // kT_E.
Qed.

(* ---- Every utility between 1 and 2 that ignores the group ---- *)

Lemma H2_mean (V : bool -> bool -> rat) a a' : (forall a x, 0 <= V a x) -> (forall a a' x, V a x = V a' x) ->
  hockey_stick 2%:R (mean_row MA V a) (mean_row MA V a') = 0.
Proof.
move=> V0 same; apply: big1 => xb _; apply/max_idPl; rewrite subr_le0 /mean_row (same a a') [X in _ <= X]mulrCA ler_wpmul2l //.
exact: dA.
Qed.

Local Notation K := (gap 1 2%:R 0).
Lemma gap_0 : K = 0 :> rat. Proof. by []. Qed.

Lemma ranged_g x a u : 1 <= g u x a <= 2%:R. Proof. exact: g_1_2. Qed.

Example T13_range_applies x a a' : E x a <= 2%:R * E x a'.
Proof. by apply: (T13_range kX kA kT (ranged_g x a) (ranged_g x a') (fun u => same_g u x a a')) => //; rewrite H2_0 gap_0. Qed.

Example T13_range_floor_applies x a a' :
  E x a <= (2%:R + Num.max 0 (K + (2%:R - K - 1) * hockey_stick 2%:R (MA a) (MA a') - (2%:R - 1) * 1) / 1) * E x a'.
Proof. by apply: (T13_range_floor kX kA kT (ranged_g x a) (ranged_g x a') (fun u => same_g u x a a') _ _ (floor_E x a')). Qed.

Example T13_range_cap_applies x a a' : E x a <= 2%:R / 1 * E x a'.
Proof. by apply: (T13_range_cap kX kA kT (ranged_g x a) _ _ (floor_E x a')). Qed.

Example T13_range_global_applies a a' : group_mean even E a <= 2%:R * group_mean even E a'.
Proof. by apply: (T13_range_global kX kA kT k_even g_1_2 same_g) => //; rewrite H2_mean // gap_0. Qed.

Lemma mean_floor a : 1 <= group_mean even E a.
Proof. by case: a; rewrite /group_mean /E /utility /expect /induced !big_bool. Qed.

Example T13_range_floor_global_applies a a' : group_mean even E a <=
  (2%:R + Num.max 0 (K + (2%:R - K - 1) * hockey_stick 2%:R (mean_row MA even a) (mean_row MA even a') - (2%:R - 1) * 1) / 1) * group_mean even E a'.
Proof. by apply: (@T13_range_floor_global _ _ _ _ _ _ MX MA T g kX kA kT even 1 2%:R 0 k_even g_1_2 same_g 1 2%:R a a') => //; exact: mean_floor. Qed.

Example T13_range_cap_global_applies a a' : group_mean even E a <= 2%:R / 1 * group_mean even E a'.
Proof. by apply: (@T13_range_cap_global _ _ _ _ _ _ MX MA T g kX kA kT even 1 2%:R k_even g_1_2 1 a a') => //; exact: mean_floor. Qed.

Example T13_range_sharp_applies : policy (@telling rat_realFieldType bool_finType).
Proof. by have [] := @T13_range_sharp _ _ _ MA true false 1 2%:R 0 2%:R kA true_no. Qed.

Lemma everybody a : (fun=> true) a -> law (even a). Proof. by move=> _; apply: k_even. Qed.

Example T13_range_global_partial_applies a a' : group_mean even E a <= 2%:R * group_mean even E a'.
Proof.
by apply: (T13_range_global_partial (massive := fun=> true) kX kA everybody kT isT isT g_1_2 same_g) => //; rewrite H2_mean // gap_0.
Qed.

Example T13_range_floor_global_partial_applies a a' : group_mean even E a <=
  (2%:R + Num.max 0 (K + (2%:R - K - 1) * hockey_stick 2%:R (mean_row MA even a) (mean_row MA even a') - (2%:R - 1) * 1) / 1) * group_mean even E a'.
Proof.
by apply: (T13_range_floor_global_partial (massive := fun=> true) kX kA everybody kT isT isT g_1_2 same_g _ _ (mean_floor a')).
Qed.

Example T13_range_cap_global_partial_applies a a' : group_mean even E a <= 2%:R / 1 * group_mean even E a'.
Proof. by apply: (T13_range_cap_global_partial (massive := fun=> true) kX kA everybody kT isT isT g_1_2 _ _ (mean_floor a')). Qed.

(* ---- Releases: nothing is released, so that groups are alike ---- *)

Local Notation word := {ffun 'I_0 -> bool}.
Local Notation M0 := (@releases rat_realFieldType bool_finType bool_finType MA 0).

Lemma dp_nothing : every_pair (pure_dp 1) M0.
Proof. by move=> a a' w; rewrite /releases !big_ord0 mul1r. Qed.

Lemma zero_even : forall a x, 0 <= even a x. Proof. by []. Qed.

Example T17_releases_applies x : local_surplus true M0 hit 1 x true false <= 0.
Proof.
apply: (proj1 (@T17_releases _ _ bool_finType _ _ _ true 0 MX MA hit kX kA hit_ge0 1 _)) => // T' kT'.
by apply: T2_pure; [exact: kX|exact: kT'|exact: hit_ge0| |exact: dp_nothing].
Qed.

Lemma mean_nothing (T' : bool -> word -> bool -> rat) : policy T' -> global_le 1 (group_mean even (utility (induced MX M0 T') hit)).
Proof. by move=> kT'; apply: T5_independent_filter; [exact: k_even|exact: kX|exact: kT'| |exact: hit_ge0| |exact: dp_nothing]. Qed.

Example T17_releases_global_applies : global_surplus true MX M0 hit even 1 true false <= 0.
Proof. by apply: (proj1 (@T17_releases_global _ _ _ _ _ _ true 0 MX MA hit even kX kA hit_ge0 zero_even 1 _)) => // T' /mean_nothing. Qed.

Example T17_releases_global_partial_applies : global_surplus true MX M0 hit even 1 true false <= 0.
Proof.
apply: (proj1 (@T17_releases_global_partial _ _ _ _ _ _ (fun=> true) MX MA even kX kA everybody true 0 hit 1 hit_ge0 _)) => //.
by move=> T' /mean_nothing le a a' _ _; apply: le.
Qed.
