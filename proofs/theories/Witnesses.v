(* Hypotheses that can be met.  A theorem whose hypotheses contradict each other says nothing, so every theorem that a
   claim cites is applied here, and in the other files whose names begin with Witnesses, to objects that meet all of
   them: [X_applies] is what the theorem [X] then says of them.  Nothing is left as a hypothesis in these files. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions DP Ratios T1 T3 T4 T5 T8 T12 Rules Partial.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* Two contexts, groups, released values and decisions.  The group filter tells the truth twice as often as not, the
   context filter three times, the policy says yes three times as often where yes is shown.  A yes is worth 2, a no 1. *)
Definition two_three (k : nat) (a b : bool) : rat := coin_filter (k%:R : rat) a b.
Definition MX := two_three 3.
Definition MA := two_three 2.
Definition T (y b u : bool) : rat := two_three 3 b u.
Definition g (u x a : bool) : rat := if u then 2%:R else 1.
Definition worth (u : bool) : rat := if u then 2%:R else 1.
Definition W (a x : bool) : rat := two_three 3 a x.
Definition even (a x : bool) : rat := 2%:R^-1.
Definition E : bool -> bool -> rat := utility (induced MX MA T) g.
Definition phi (b : bool) : rat := b%:R.

Lemma kernel_coin k : (0 < k)%N -> kernel (two_three k).
Proof. by move=> k1; have [] := @T12_sharp rat_realFieldType k%:R 1; rewrite ?ler1n. Qed.

Lemma dp_coin k : (0 < k)%N -> every_pair (pure_dp k%:R) (two_three k).
Proof. by move=> k1; have [] := @T12_sharp rat_realFieldType k%:R 1; rewrite ?ler1n. Qed.

Lemma kX : kernel MX. Proof. exact: kernel_coin. Qed.
Lemma kA : kernel MA. Proof. exact: kernel_coin. Qed.
Lemma kT : policy T. Proof. by move=> y; apply: kernel_coin. Qed.
Lemma kW : kernel W. Proof. exact: kernel_coin. Qed.
Lemma k_even : kernel even. Proof. by move=> a; split=> [[]|] //; rewrite big_bool. Qed.
Lemma dX : every_pair (pure_dp 3%:R) MX. Proof. exact: dp_coin. Qed.
Lemma dA : every_pair (pure_dp 2%:R) MA. Proof. exact: dp_coin. Qed.
Lemma ddA : every_pair (dp 2%:R 0) MA. Proof. by move=> a a'; apply/pure_dp_dp; apply: dA. Qed.
Lemma free_g : a_free g. Proof. by []. Qed.
Lemma g_1_2 : valued 1 2%:R g. Proof. by case. Qed.
Lemma g_0_2 : valued 0 2%:R g. Proof. by case. Qed.
Lemma g_ge0 u x a : 0 <= g u x a. Proof. by case: u. Qed.
Lemma worth_ge0 u : 0 <= worth u. Proof. by case: u. Qed.
Lemma same_g u x a a' : g u x a <= g u x a' + 0. Proof. by rewrite addr0. Qed.
Lemma near_g u x a a' : `|g u x a - g u x a'| <= 0. Proof. by rewrite subrr normr0. Qed.
Lemma floor_E : has_floor 1 E. Proof. by move=> x a; case/andP: (utility_ranged kX kA kT x a g_1_2). Qed.
Lemma test_phi : test phi. Proof. by case. Qed.
Lemma two0 : 0 <= 2%:R :> rat. Proof. by []. Qed.

Ltac meet := first [exact: kX|exact: kA|exact: kT|exact: kW|exact: k_even|exact: dA|exact: dX|exact: g_ge0|exact: g_0_2|exact: g_1_2|done|idtac].

(* ---- T1, floor, T2 ---- *)

Example T1_one_k_applies x a a' : E x a <= 2%:R * E x a' + 0 + 2%:R * hockey_stick 2%:R (MA a) (MA a').
Proof. by apply: (T1_one_k kX kA kT _ g_0_2) => u; apply: same_g. Qed.

Example T1_additive_applies x a a' : E x a <= 2%:R * E x a' + 0 + 0 * 2%:R.
Proof. exact: (T1_additive kX kA kT two0 g_0_2 (K := fun _ _ => 0) near_g ddA). Qed.

Example T1_filter_applies x a a' : E x a <= (1 + (0 + 2%:R * hockey_stick 1 (MA a) (MA a')) / 1) * E x a'.
Proof. by apply: (T1_filter kX kA kT 1 _ (floor_E x a')) => // [|u]; [exact: g_0_2|exact: same_g]. Qed.

Example T1_tight_applies : local_le (2%:R + (0 + 0 * 2%:R) / 1) E.
Proof. by apply: (T1_tight kX kA kT two0 _ g_0_2 near_g _ ddA _ floor_E). Qed.

Example T1_paper_applies : local_le (2%:R * (1 + (0 + 0 * 2%:R) / 1)) E.
Proof. by apply: (T1_paper kX kA kT two0 _ g_0_2 near_g _ _ ddA _ floor_E). Qed.

Example T1_cap_applies : local_le (2%:R / 1) E.
Proof. by apply: (T1_cap kX kA kT g_0_2 _ floor_E). Qed.

Example T2_pure_applies : local_le 2%:R E.
Proof. exact: (T2_pure kX kT g_ge0 free_g dA). Qed.

Example T2_sharp_applies x : policy (grant (point rat_realFieldType true)) /\
  utility (induced (@no_context _ _) MA (grant (point _ true))) (granted 0 1) x true =
  2%:R * utility (induced (@no_context rat_realFieldType bool_finType) MA (grant (point _ true))) (granted 0 1) x false.
Proof.
have odds : MA true true = 2%:R * MA false true by [].
by have [] := @T2_sharp _ bool_finType _ _ MA true false true 2%:R 1 x kA odds.
Qed.

(* ---- T3, T4 ---- *)

Example certificate_one_k_applies :
  expect (MA true) phi <= (1 + hockey_stick 1 (MA true) (MA false) / 3%:R^-1) * expect (MA false) phi.
Proof. by apply: (certificate_one_k _ _ test_phi) => //; rewrite /expect big_bool. Qed.

Example T3_one_k_applies x a a' : E x a <= (1 + 2%:R * hockey_stick 1 (MA a) (MA a') / 1) * E x a'.
Proof. by apply: (T3_one_k kX kA kT 1 a two0 g_0_2 free_g _ (floor_E x a')). Qed.

Example T3_K_one_k_applies x a a' : E x a <= (1 + (1 + (2%:R - 1) * hockey_stick 1 (MA a) (MA a')) / 1) * E x a'.
Proof. by apply: (T3_K_one_k kX kA kT _ _ _ g_0_2 _ _ (floor_E x a')) => // u; rewrite ler_addl. Qed.

Lemma floor_T : policy_floor MX T g 1.
Proof. by move=> x a y b _; case/andP: (expect_ranged (kT y b) (g_1_2^~ x ^~ a)). Qed.

Example T3_any_filter_applies x a a' :
  E x a <= (1 + 2%:R * hockey_stick 1 (truth 2%:R) (lie 2%:R) / 1) * E x a'.
Proof. by apply: (T3_any_filter kX kT x a a' kA two0 g_0_2 free_g _ _ dA _ floor_T). Qed.

Example T3_any_filter_released_applies x a a' :
  E x a <= (1 + 2%:R * hockey_stick 1 (truth 2%:R) (lie 2%:R) / 1) * E x a'.
Proof.
apply: (@T3_any_filter_released _ _ _ _ _ _ (fun=> true) _ _ _ _ kX kA kT) => //; try exact: dA; try exact: g_0_2.
by move=> x' a'' y b My _; apply: (@floor_T x' a'' y b My).
Qed.

Example pure_dp_hockey_stick_applies a a' :
  hockey_stick 1 (MA a) (MA a') <= hockey_stick 1 (truth 2%:R) (lie 2%:R).
Proof. by apply: pure_dp_hockey_stick => //; try exact: kA; exact: dA. Qed.

Lemma H2_0 a a' : hockey_stick 2%:R (MA a) (MA a') = 0.
Proof. by apply: big1 => b _; apply/max_idPl; rewrite subr_le0; apply: dA. Qed.

Example T3_class_applies : expect (MA true) worth <= 2%:R * expect (MA false) worth.
Proof.
apply: (T3_class (kA true) (kA false) (m := 1) (gamma := 2%:R) (t := 1) (k := 2%:R)) => //; first by case.
- by rewrite /expect big_bool.
- by rewrite H2_0.
Qed.

Example T3_class_no_floor_applies : expect (MA true) worth <= 2%:R * expect (MA false) worth.
Proof. by apply: T3_class_no_floor (H2_0 true false) _; [exact: kA|exact: worth_ge0|]. Qed.

Example T4_one_k_applies x a a' :
  E x a <= (2%:R + Num.max 0 ((2%:R - 1) * hockey_stick 2%:R (MA a) (MA a') - (2%:R - 1) * 1) / 1) * E x a'.
Proof. by apply: (T4_one_k kX kA kT _ a g_1_2 free_g _ (floor_E x a')). Qed.

Example T4_any_policy_applies x a a' :
  E x a <= (2%:R + Num.max 0 ((2%:R - 1) * hockey_stick 2%:R (MA a) (MA a') - (2%:R - 1) * 1) / 1) * E x a'.
Proof. by apply: (T4_any_policy kX kA kT _ x a a' g_1_2 free_g). Qed.

(* ---- T5 ---- *)

Lemma even_independent : independent even. Proof. by []. Qed.

Example T5_independent_applies : global_le 2%:R (group_mean even E).
Proof. exact: (T5_independent k_even even_independent T2_pure_applies). Qed.

Example T5_independent_filter_applies : global_le 2%:R (group_mean even E).
Proof. exact: (T5_independent_filter k_even kX kT even_independent g_ge0 free_g dA). Qed.

Example T5_decision_applies : global_le (2%:R * 3%:R) (group_mean W (utility (induced MX MA T) (fun u _ _ => worth u))).
Proof. exact: (T5_decision kW kX kA kT worth_ge0 dA (released_by_filter kW dX)). Qed.

(* The second group has no mass, and a row that is no law; its cell in the second context is missing. *)
Definition some_mass (a x : bool) : rat := if a then 2%:R^-1 else 7%:R.
Definition has_mass (a : bool) : bool := a.
Definition there (x a : bool) : bool := x || a.

Lemma law_some_mass a : has_mass a -> law (some_mass a).
Proof. by case: a => // _; split=> [[]|] //; rewrite big_bool. Qed.

Example T5_independent_partial_applies : global_le_on has_mass 2%:R (group_mean some_mass E).
Proof.
apply: (@T5_independent_partial _ _ _ there) => [[] [] //|[] [] []//|[] []//|].
by move=> x a a' _ _; apply: T2_pure_applies.
Qed.

Example T5_independent_filter_partial_applies : global_le_on has_mass 2%:R (group_mean some_mass E).
Proof. by apply: T5_independent_filter_partial; meet; [exact: law_some_mass|move=> [] []]. Qed.

Example T5_decision_partial_applies :
  global_le_on has_mass (2%:R * 1) (group_mean some_mass (utility (induced MX MA T) (fun u _ _ => worth u))).
Proof.
by apply: T5_decision_partial; meet; [exact: law_some_mass|exact: worth_ge0|move=> [] [] // _ _ y; rewrite mul1r].
Qed.

(* ---- T8, T12 ---- *)

Definition shown_as_it_is : bool -> bool -> rat := utility (induced (@identity _ bool_finType) MA T) (fun u _ _ => worth u).
Definition filtered : bool -> bool -> rat := utility (induced MX MA T) (fun u _ _ => worth u).

Lemma fair_as_it_is : local_le 2%:R shown_as_it_is.
Proof. by apply: (T2_pure (@kernel_identity _ _) kT _ _ dA) => // u x a; apply: worth_ge0. Qed.

Example T8_context_filter_applies : local_le 2%:R filtered.
Proof. exact: (T8_context_filter kX fair_as_it_is). Qed.

Example T8_all_compared_applies : filtered true true <= 2%:R * filtered true false.
Proof.
by apply: (T8_all_compared kX (compared := there) (compared_shown := fun _ _ => true)) => // y a a' _ _; apply: fair_as_it_is.
Qed.

Example T8_released_applies : local_le 2%:R filtered.
Proof. by apply: (T8_released kX (released := fun=> true)) => // y a a' _; apply: fair_as_it_is. Qed.

(* The policy's own ratio is at most 2, as that of any utility between 1 and 2. *)
Lemma own_ratio x a b b' : response MX T g x a b <= 2%:R * response MX T g x a b'.
Proof.
have /andP[_ le] := response_ranged x a kX kT g_1_2 b; have /andP[ge _] := response_ranged x a kX kT g_1_2 b'.
by apply: le_trans le _; rewrite ler_pmulr.
Qed.

Example T12_contraction_applies : local_le (contraction 2%:R 2%:R) E.
Proof. by apply: (T12_contraction kX kA kT _ _ g_ge0 free_g own_ratio dA). Qed.

Example T12_any_filter_applies : local_le 2%:R E.
Proof. exact: (T12_any_filter kA free_g own_ratio). Qed.

Example T12_released_applies : local_le (contraction 2%:R 2%:R) E.
Proof. by apply: (T12_released kX kA kT (released := fun=> true) _ _ _ g_ge0 free_g _ dA) => // x a b b' _ _; apply: own_ratio. Qed.

Example T12_any_filter_released_applies : local_le 2%:R E.
Proof. by apply: (T12_any_filter_released kX kA kT (released := fun=> true) _ free_g) => // x a b b' _ _; apply: own_ratio. Qed.
