(* Hypotheses that can be met: further forms of privacy, T13, T14, T16 and T17 (see Witnesses.v). *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions DP Ratios T1 T12 T13 T13_near T13_floor T14 T15 T16 T17 Witnesses Witnesses_tables Witnesses_suprema.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Lemma MA0 a b : 0 <= MA a b. Proof. by case: (kA a). Qed.
Lemma MX0 a b : 0 <= MX a b. Proof. by case: (kX a). Qed.
Lemma alike_all a a' : alike (fun _ : bool => tt) (MA a) (MA a) -> alike (fun b : bool => b) (MA a) (MA a').
Proof. by move=> _ b b' ->. Qed.
Definition own (b : bool) : bool := b.
Lemma alike_own a a' : alike own (MA a) (MA a'). Proof. by move=> b b' e; have -> : b = b' := e. Qed.

(* ---- Privacy ---- *)

Example dp_functions_applies : expect (MA true) worth <= 2%:R * expect (MA false) worth + 0 * 2%:R.
Proof. by apply: (proj1 (@dp_functions _ _ 2%:R 0 2%:R (MA true) (MA false) _) (ddA _ _)) => // -[]. Qed.

Example pure_dp_products_applies :
  pure_dp (2%:R * 3%:R) (fun ab : bool * bool => MA true ab.1 * MX true ab.2) (fun ab => MA false ab.1 * MX false ab.2).
Proof. exact: (pure_dp_products (MA0 true) (MX0 true) (MA0 false) two0 (dA _ _) (dX _ _)). Qed.

Example dp_hockey_stick_applies : hockey_stick 2%:R (MA true) (MA false) <= 0.
Proof. exact: (proj1 (dp_hockey_stick _ _ _ _) (ddA true false)). Qed.

Example pure_dp_dp_applies : dp 2%:R 0 (MA true) (MA false).
Proof. exact: (proj1 (pure_dp_dp _ _ _) (dA true false)). Qed.

(* ---- T13 ---- *)

Definition gains (o u : bool) : rat := MA true o * u%:R.
Definition loses (o u : bool) : rat := MA false o * u%:R.

Example T13_value_applies : value flip all_ones <= \sum_o greatest true (all_ones o).
Proof. exact: (proj1 (T13_value true all_ones) flip k_all_ones). Qed.

Example T13_attained_applies : E_of T true true / E_of T true false <= 2%:R.
Proof.
apply: (@T13_attained _ _ (@policy _ _ _ _) (fun T => E_of T true true) (fun T => E_of T true false) T) => //; first exact: kT.
- exact: E_gt0.
- by rewrite divfK // gt_eqF // E_gt0.
- by move=> T' kT'; apply: hit_2.
Qed.

Example T13_attained_infinite_applies : ~ 1 <= 5%:R * (fun _ : unit => 0 : rat) tt.
Proof.
by move=> le; apply: (@T13_attained_infinite _ unit (fun _ => True) (fun _ => 1 : rat) (fun _ => 0) tt _ _ _ 5%:R).
Qed.

Example T13_newton_applies : 1 < value (always _ say) gains / value (always _ say) loses.
Proof.
apply: (T13_newton (u0 := true)) => [|[] [] //|]; last by rewrite /value !big_bool.
rewrite ltNge; apply/negP => /T13_any_policy/(_ (always _ say)) le.
have {}le := le (fun o => law_point _ (say o)); move: le; apply/negP.
by rewrite /value !big_bool.
Qed.

Example T13_local_applies x : local_surplus true MA hit 2%:R x true false <= 0.
Proof. by apply/(T13_local true MA hit kX) => T' kT'; apply: hit_2. Qed.

Example T13_global_applies : global_surplus true MX MA hit even 2%:R true false <= 0.
Proof. by apply/(T13_global true) => T' kT'; apply: mean_2. Qed.

Lemma ranged_worth : ranged 1 2%:R worth. Proof. by case. Qed.

Example T13_free_applies : surplus true (fun b u => MA true b * worth u) (fun b u => MA false b * worth u) 2%:R =
  (2%:R - 1) * hockey_stick 2%:R (MA true) (MA false) - 1 * (2%:R - 1).
Proof. by apply: (T13_free true (lA true) (lA false) ranged_worth); [exists false|exists true]. Qed.

Example T13_local_free_applies x : E x true <= 2%:R * E x false.
Proof.
have least : exists u, g u x true = 1 by exists false.
have most : exists u, g u x true = 2%:R by exists true.
have same u : g u x true = g u x false by [].
have free := T13_local_free 2%:R kX kA same (fun u => g_1_2 u x true) least most.
by apply: (proj2 free) => //; [rewrite H2_0|exact: kT].
Qed.

Example T13_merge_applies : \sum_b (MA true b + MA false b) = \sum_c (merged own (MA true) c + merged own (MA false) c).
Proof. by apply: (T13_merge (F := fun x y => x + y) _ (MA0 _) (MA0 _) (alike_own _ _)) => s x y _; rewrite mulrDr. Qed.

Example T13_merge_factor_applies : \sum_b \sum_d (MA true b * MX true d + MA false b * MX false d) =
  \sum_c \sum_d (merged own (MA true) c * MX true d + merged own (MA false) c * MX false d).
Proof.
apply: (T13_merge_factor (MX true) (MX false) (MA0 _) (MA0 _) (F := fun _ x y => x + y) _ (alike_own _ _)) => d s x y _.
by rewrite mulrDr.
Qed.

Example T13_merge_local_surplus_applies : surplus true (fun b u => MA true b * worth u) (fun b u => MA false b * worth u) 2%:R =
  surplus true (fun c u => merged own (MA true) c * worth u) (fun c u => merged own (MA false) c * worth u) 2%:R.
Proof. exact: (T13_merge_local_surplus true (MA0 _) (MA0 _) (alike_own _ _)). Qed.

Example T13_merge_hockey_stick_applies : hockey_stick 2%:R (MA true) (MA false) =
  hockey_stick 2%:R (merged own (MA true)) (merged own (MA false)).
Proof. exact: (T13_merge_hockey_stick (MA0 _) (MA0 _) (alike_own _ _)). Qed.

Example T13_floor_one_k_pair_applies : value flip all_ones <= 1 * value flip all_ones.
Proof.
apply: (@T13_floor_one_k_pair _ _ _ true flip all_ones all_ones 0 1 1 k_all_ones) => //; first by rewrite /value !big_bool.
by rewrite subrr mul0r; apply: T13_any_policy_applies.
Qed.

Example T13_near_law_applies : \sum_u MA true u * worth u <= \sum_u MA true u * worth u + \sum_u 0 * (greatest true worth - worth u).
Proof. by apply: (T13_near_law true (lA true) (take_nothing worth (lA true)) (lA true)); rewrite tv_self. Qed.

Definition yes (o : bool) : bool := true.
Definition pays (o u : bool) : rat := worth u.

Lemma greatest_pays o : pays o (yes o) = greatest true (pays o).
Proof. by apply/eqP; rewrite eq_le greatest_ge /=; apply: worth_le. Qed.

Example T13_near_value_applies : kernel (moved_policy 0 flip (fun _ _ => 0) yes).
Proof.
have [||_ ? _ _] := @T13_near_value _ _ _ true 0 flip (fun _ _ => 0) pays yes k_all_ones => // o; last exact: greatest_pays.
by apply: take_nothing; apply: k_all_ones.
Qed.

Example T13_near_0_applies : moved_value true flip (fun _ _ => 0) pays = value flip pays.
Proof. by apply: T13_near_0 => o; apply: take_nothing; apply: k_all_ones. Qed.

Example T13_near_1_applies : exists r, moved_value true flip r (gain all_ones all_ones 1) = surplus true all_ones all_ones 1.
Proof.
have [r rP] : exists r, from_least 1 (even true) (gain all_ones all_ones 1 true) r by apply: T13_near_exists; [exact: k_even|].
by exists (fun=> r); apply: T13_near_1 => // o; apply: k_all_ones.
Qed.

(* ---- T17 ---- *)

Example T17_monotone_applies x : local_surplus true (@releases _ _ _ MA 1) hit 2%:R x true false <= local_surplus true (@releases _ _ _ MA 2) hit 2%:R x true false.
Proof. exact: (T17_monotone true 1 hit kA). Qed.

Example T17_monotone_global_applies :
  global_surplus true MX (@releases _ _ _ MA 1) hit even 2%:R true false <= global_surplus true MX (@releases _ _ _ MA 2) hit even 2%:R true false.
Proof. exact: (T17_monotone_global true 1 MX hit even kA). Qed.

Example T17_monotone_hockey_stick_applies :
  hockey_stick 2%:R (@releases _ _ _ MA 1 true) (@releases _ _ _ MA 1 false) <= hockey_stick 2%:R (@releases _ _ _ MA 2 true) (@releases _ _ _ MA 2 false).
Proof. exact: (T17_monotone_hockey_stick 1 kA). Qed.

Example T17_types_applies : alike (@type_of bool_finType 2) (@releases _ _ _ MA 2 true) (@releases _ _ _ MA 2 false).
Proof. exact: T17_types. Qed.

Example T17_merged_applies : \sum_w (@releases _ _ _ MA 3 true w + @releases _ _ _ MA 3 false w) =
  \sum_b \sum_c (MA true b * merged (@type_of bool_finType 2) (@releases _ _ _ MA 2 true) c +
                 MA false b * merged (@type_of bool_finType 2) (@releases _ _ _ MA 2 false) c).
Proof. by apply: (T17_merged kA (F := fun x y => x + y) _ (@T17_types _ _ _ MA true false 2)) => s x y _; rewrite mulrDr. Qed.

Example T17_krr_classes_applies : alike (@class_of bool_finType true false 2) (@releases rat_realFieldType _ _ (krr 1) 2 true) (releases (krr 1) false).
Proof. exact: (T17_krr_classes 1 true_no). Qed.

Example T17_krr_masses_applies (s := ord0) : merged (@class_of bool_finType true false 1) (@releases rat_realFieldType _ _ (krr 1) 1 true) s =
  \sum_(j < 2) \sum_(i < (1 - j).+1 | (1 - j + i == s)%N) ('C(1, j) * 'C(1 - j, i))%:R * (1 ^+ i * krr_lie bool_finType 1 ^+ j * (1 - 1 - krr_lie bool_finType 1) ^+ (1 - j - i)).
Proof. by have [|? _] := @T17_krr_masses rat_realFieldType bool_finType 1 true false 1 true_no _ s; rewrite ?card_bool. Qed.

(* ---- T14, T15, T16 ---- *)

Example T14_hidden_most_applies : flat true * ((0 * 2%:R + 1 - 0) * expect (MA false) flat) <=
  2%:R * (0 + (1 - 0) * 2%:R) * expect (MA true) flat * flat true.
Proof.
by apply: (@T14_hidden_most _ _ 0 2%:R 2%:R (MA true) (MA false) flat flat true (lA true) (lA false)) => //; apply: MA0.
Qed.

Example T14_hidden_most_attained_applies : spread 2%:R (fun v : bool => if v then 2%:R else 1 : rat).
Proof. by have [] := @T14_hidden_most_attained rat_realFieldType 0 2%:R 2%:R. Qed.

Example T15_running_mean_applies : running 1 1 (fun j => j%:R : rat) 0 <= running 1 1 (fun j => j%:R : rat) 1.
Proof.
apply: (@T15_running_mean _ 1 1 1 (fun j => j%:R) (fun=> 1) _ _ _ 0 0 1) => // j _.
by rewrite -addn1 natrD.
Qed.

Example T16_factor_attained_applies : exists theta D, [/\ law D, pure_dp 2%:R D (MA true) & expect D worth = factor_up 2%:R theta (MA true) worth].
Proof. by have [|theta [D [? ? _ ?]]] := @T16_factor_attained _ _ 2%:R (MA true) worth (lA true); last by exists theta, D. Qed.

Example T16_factor_square_applies : expect (MA true) worth <= 2%:R ^+ 2 * 2%:R * expect (MA false) worth.
Proof.
apply: (T16_factor_square two0 one_two (dp_self true) (dp_self false) worth_ge0 worth_ge0).
by rewrite /expect !big_bool.
Qed.
