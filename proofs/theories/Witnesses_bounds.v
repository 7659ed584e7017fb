(* Hypotheses that can be met: further bounds of docs/theory.md, which users are given and no claim cites (see Witnesses.v). *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra all_fingroup.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP Ratios T1 T3 T3_krr T3_sharp T4 T5 T6 T7 T8 T9 T10 T11 T12 T13 Products Sampler Witnesses.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Definition half : rat := 2%:R^-1.
Lemma law_MA a : law (MA a). Proof. exact: kA. Qed.
Lemma half_floor : has_floor (half * 2%:R) E. Proof. by rewrite /half mulVf //; apply: floor_E. Qed.

(* No pair of rows lies below this curve: a power is at most twice the level. *)
Definition curve (alpha : rat) : rat := 1 - 2%:R * alpha.
Lemma above_curve : every_pair (above curve) MA.
Proof.
move=> a a' f tf; rewrite ler_add2l ler_opp2 /expect mulr_sumr; apply: ler_sum => b _.
by rewrite mulrA ler_wpmul2r ?dA //; case/andP: (tf b).
Qed.

(* ---- T1, T3, T4 ---- *)

Example T1_pairs_applies x a a' : E x a <= (2%:R + (0 + 0 * 2%:R) / 1) * E x a'.
Proof. by apply: (T1_pairs kX kA kT two0 _ g_0_2 (K := fun _ _ => 0 : rat) near_g _ ddA _ floor_E). Qed.

Example certificate_exact_applies : exists (k : rat) f, [/\ 0 <= k, test f & expect (MA false) f = half].
Proof.
by have [k [f [? _ ? ? _]]] := @certificate_exact rat_realFieldType _ half (MA true) (MA false) (law_MA _) (law_MA _) isT isT; exists k, f.
Qed.

Example T3_one_k_dp_applies x a a' : E x a <= (2%:R + 2%:R * 0 / 1) * E x a'.
Proof. by apply: (T3_one_k_dp kX kA kT two0 g_0_2 free_g _ _ (floor_E x a')) => //; apply: ddA. Qed.

Example T3_power_applies x a a' : E x a <= 1 / half * E x a'.
Proof. by apply: (T3_power kX kA kT _ g_0_2 free_g _ _ (half_floor x a')) => //; apply: power_cap; apply: law_MA. Qed.

Example T3_tradeoff_applies : local_le ((1 - curve half) / half) E.
Proof. by apply: (T3_tradeoff kX kA kT _ g_0_2 free_g _ _ above_curve half_floor). Qed.

Example T3_eps_delta_applies : local_le (eps_delta_bound 2%:R 0 half) E.
Proof. by apply: (T3_eps_delta kX kA kT _ g_0_2 free_g _ _ ddA half_floor). Qed.

Lemma same_half u x a a' : g u x a <= g u x a' + half. Proof. by rewrite ler_addl. Qed.
Lemma near_half u x a a' : `|g u x a - g u x a'| <= half. Proof. by rewrite subrr normr0. Qed.

Example T3_K_power_applies x a a' : E x a <= (half + (2%:R - half) * 1) / 1 * E x a'.
Proof.
apply: (T3_K_power kX kA kT _ _ g_0_2 (fun u => same_half u x a a') _ (floor_E x a')) => //.
by apply: power_cap; apply: law_MA.
Qed.

Example T3_K_tradeoff_applies : local_le ((half + (2%:R - half) * (1 - curve (1 / (2%:R - half)))) / 1) E.
Proof. by apply: (T3_K_tradeoff kX kA kT _ _ g_0_2 near_half _ _ above_curve floor_E). Qed.

Example T3_exact_applies : exists f : bool -> rat, policy (grant f).
Proof. by have [k [r [f [a [a' [_ ? _ _]]]]]] := @T3_exact rat_realFieldType bool_finType _ _ MA kA true half 2%:R isT isT isT; exists f. Qed.

Example T3_sharp_applies : exists f : bool * bool -> rat, policy (grant f).
Proof. by have [f [_ _ ? _ _]] := @T3_sharp rat_realFieldType 2%:R half isT isT isT half isT isT bool_finType 2%:R isT; exists f. Qed.

Lemma two_groups : (1 < #|bool_finType|)%N. Proof. by rewrite card_bool. Qed.
Lemma lowest p : half <= p -> (#|bool_finType|%:R : rat)^-1 <= p. Proof. by rewrite card_bool. Qed.
Definition most : rat := 2%:R / 3%:R.
Lemma low_most : (#|bool_finType|%:R : rat)^-1 <= most. Proof. exact: lowest. Qed.
Lemma low_half : (#|bool_finType|%:R : rat)^-1 <= half. Proof. exact: lowest. Qed.
Definition krr_E (x a : bool) : rat := utility (induced MX (krr most) T) g x a.

Lemma kernel_most : kernel (krr most : bool -> bool -> rat).
Proof. by move=> a; split=> [b|]; [|rewrite big_bool]; rewrite /krr /krr_lie card_bool; case: a; try case: b. Qed.

Lemma floor_krr : has_floor (half * 2%:R) krr_E.
Proof. by move=> x a; rewrite /half mulVf //; case/andP: (utility_ranged kX kernel_most kT x a g_1_2). Qed.

Example T3_krr_pair_applies x a a' : krr_E x a <= krr_bound bool_finType most half * krr_E x a'.
Proof. by apply: (T3_krr_pair two_groups low_most _ _ a kX kT _ g_0_2 free_g (floor_krr x a')). Qed.

Example T3_krr_applies : local_le (krr_bound bool_finType most half) krr_E.
Proof. by apply: (T3_krr two_groups low_most _ _ kX kT _ g_0_2 free_g floor_krr). Qed.

Example T3_krr_attained_applies : exists f : bool -> rat, policy (grant f).
Proof. by have [f [a [a' [? _ _]]]] := @T3_krr_attained rat_realFieldType _ two_groups most half low_most isT isT isT bool_finType 2%:R isT; exists f. Qed.

Example T3_krr_least_applies (x : bool) : krr_bound bool_finType most half <= krr_bound bool_finType most half.
Proof.
apply: (@T3_krr_least rat_realFieldType _ two_groups most half low_most isT isT isT _ x 2%:R _ isT) => f kf fl.
apply: (T3_krr two_groups low_most _ _ _ kf _ _ _ fl) => //; [exact: kernel_no_context|exact: granted_valued].
Qed.

Example T4_tradeoff_applies : local_le 2%:R E.
Proof.
apply: (T4_tradeoff kX kA kT _ _ g_1_2 free_g above_curve floor_E) => // s _ s0 s1.
rewrite /curve opprB addrCA subrr addr0 (_ : 2%:R - 1 = 1 :> rat) // !mul1r ler_pdivr_mulr ?ltr_paddr //.
by rewrite mulrDr mulr1 ler_add2r.
Qed.

Example T4_certificate_exact_applies : exists f : bool -> rat, test f.
Proof.
by have [k [f [_ ? _ _]]] := @T4_certificate_exact rat_realFieldType _ (MA true) (MA false) 1 2%:R 1 (law_MA _) (law_MA _) isT isT isT isT; exists f.
Qed.

(* ---- T5 to T8 ---- *)

Lemma dW : every_pair (pure_dp 3%:R) W. Proof. exact: dX. Qed.
Lemma E_ge0 x a : 0 <= E x a. Proof. exact: le_trans (floor_E x a). Qed.

Example T5_general_global_applies : global_le (2%:R * 3%:R) (group_mean W E).
Proof. exact: (T5_general_global kW E_ge0 T2_pure_applies dW). Qed.

Example T5_general_applies : global_le (2%:R * 3%:R) (group_mean W E).
Proof.
apply: T5_general => x a a'; apply: (@le_trans _ _ (3%:R * W a' x * E x a)); first by rewrite ler_wpmul2r ?E_ge0 ?dW.
have W0 : 0 <= 3%:R * W a' x by rewrite mulr_ge0 //; case: (kW a').
have -> : 2%:R * 3%:R * (W a' x * E x a') = 3%:R * W a' x * (2%:R * E x a') by ring.
exact: ler_wpmul2l W0 _ _ (T2_pure_applies x a a').
Qed.

Example T5_decision_min_applies : global_le (2%:R * Num.min 3%:R 3%:R) (group_mean W (utility (induced MX MA T) (fun u _ _ => worth u))).
Proof. exact: (T5_decision_min kW kX kA kT worth_ge0 dA dX dW). Qed.

Lemma mean_W a : 1 <= group_mean W E a.
Proof. by case: a; rewrite /group_mean /E /utility /expect /induced !big_bool. Qed.

Example T5_floor_applies a a' : group_mean W E a <=
  (1 + 2%:R * hockey_stick 1 (context_release W MA a) (context_release W MA a') / 1) * group_mean W E a'.
Proof. by apply: (@T5_floor _ _ _ _ _ _ W MX MA T g kW kX kA kT 2%:R 1 1 a a') => //; first [exact: g_0_2|exact: mean_W]. Qed.

Definition rows (x a u : bool) : rat := MA a u.
Lemma k_rows x : kernel (rows x). Proof. exact: kA. Qed.

Example T6_upper_applies : expect (MA true) worth <= 2%:R * expect (MA false) worth.
Proof. exact: (T6_upper (dA true false) worth_ge0). Qed.

Example T6_group_dependent_applies (x : bool) : ~ local_le 5%:R (utility rows (fun _ _ a => point _ true a)).
Proof. by apply: (T6_group_dependent k_rows x (a0 := true) (a1 := false)). Qed.

Example T6_global_group_dependent_applies : ~ global_le 5%:R (group_mean W (utility rows (fun _ _ a => point _ true a))).
Proof. by apply: (T6_global_group_dependent k_rows (fun a => kW a) (a0 := true) (a1 := false)). Qed.

Example T7_product_applies : (2%:R * 2%:R - 1) * tv (MA true) (MA false) <= (2%:R - 1) * (2%:R - 1).
Proof. exact: (T7_product (law_MA _) (law_MA _) (dA _ _) (dA _ _)). Qed.

Example T7_one_sided_applies : tv (MA true) (MA false) <= (2%:R - 1) * (2%:R - 1) / (2%:R * 2%:R - 1).
Proof. exact: (T7_one_sided (law_MA _) (law_MA _) (dA _ _) (dA _ _)). Qed.

Example T7_filter_applies x a a' : tv (induced MX MA T x a) (induced MX MA T x a') <= (2%:R - 1) / (2%:R + 1).
Proof. exact: (T7_filter kX kA kT dA). Qed.

Example T6_global_contexts_applies : global_le 2%:R (group_mean even (utility rows (fun u x _ => g u x true))).
Proof.
apply: (proj2 (T6_global_contexts rows even 2%:R)) => [a a' ux|u x]; last exact: g_ge0.
by rewrite /joint_law [X in _ <= X]mulrCA ler_wpmul2l // dA.
Qed.

Lemma fair_rows h : a_free h -> (forall u x a, 0 <= h u x a) -> local_le 2%:R (utility rows h).
Proof. by move=> fh h0; apply: (proj2 (T6_local rows 2%:R) _ h fh h0) => x a a'; apply: dA. Qed.

Example T7_form_applies : (2%:R - 1) / (2%:R + 1) <= (2%:R - 1) / 2%:R :> rat.
Proof. by apply: T7_form. Qed.

Example T7_paper_applies : tv (MA true) (MA false) <= 2%:R - 1.
Proof. exact: (T7_paper (law_MA _) (law_MA _) (dA _ _) (dA _ _)). Qed.

Example T7_sharp_applies : law (lean (2%:R : rat)).
Proof. by have [] := @T7_sharp rat_realFieldType 2%:R. Qed.

Example T7_paper_equalized_odds_applies x a a' : tv (rows x a) (rows x a') <= 2%:R - 1.
Proof. exact: (T7_paper_equalized_odds k_rows fair_rows). Qed.

(* A filter of the context changes nothing where the policy is the same for all. *)
Example T8_equality_applies : utility (induced MX MA (fun _ _ : bool => even true)) (fun u _ _ => worth u) true true =
  1 * utility (induced MX MA (fun _ _ : bool => even true)) (fun u _ _ => worth u) true false.
Proof.
have same y a a' : utility (induced (@identity _ bool_finType) MA (fun _ _ : bool => even true)) (fun u _ _ => worth u) y a =
    1 * utility (induced (@identity _ bool_finType) MA (fun _ _ : bool => even true)) (fun u _ _ => worth u) y a'.
  by case: y; case: a; case: a'; rewrite /utility /expect /induced !big_bool.
apply: (proj2 (T8_equality kX true true false _)) => [y a a'|y _]; last exact: same.
by rewrite (same y a a').
Qed.

(* ---- T9 ---- *)

Example T9_krr_applies : exists r : rat, r <= 1.
Proof. by have [r [_ ? _]] := @T9_krr rat_realFieldType _ two_groups most half low_half isT isT; exists r. Qed.

Example T9_krr_degrades_applies : degrades (krr half : bool -> bool -> rat) (krr most).
Proof. by apply: T9_krr_degrades; [exact: two_groups|exact: low_half| |]. Qed.

Example T9_products_applies : degrades (both (krr half) (krr half) : bool * bool -> bool * bool -> rat) (both (krr most) (krr most)).
Proof. exact: (T9_products T9_krr_degrades_applies T9_krr_degrades_applies). Qed.

Lemma fair_krr : local_le 2%:R krr_E.
Proof.
move=> x a a'; have /andP[_ le] := utility_ranged kX kernel_most kT x a g_1_2; apply: le_trans le _.
by rewrite ler_pmulr //; case/andP: (utility_ranged kX kernel_most kT x a' g_1_2).
Qed.

Example T9_local_applies : local_le 2%:R (utility (induced MX (krr half) T) g).
Proof. exact: (T9_local free_g T9_krr_degrades_applies fair_krr). Qed.

Example T9_global_applies : global_le 2%:R (group_mean even (utility (induced MX (krr half) T) g)).
Proof. exact: (T9_global free_g even_independent T9_krr_degrades_applies (T5_independent k_even even_independent fair_krr)). Qed.

Example T9_monotone_applies : local_le 2%:R (utility (induced MX (krr half) T) g).
Proof. by apply: (T9_monotone two_groups free_g low_half _ _ fair_krr). Qed.

Example T9_pair_applies x : utility (induced MX (krr half) T) g x true <= 2%:R * utility (induced MX (krr half) T) g x false.
Proof. by apply: (T9_pair two_groups free_g kX kT g_ge0 low_half _ _ _ (fair_krr x true false)). Qed.

Definition pairs_policy (y : bool) (b : bool * bool) : bool -> rat := T y b.1.
Definition pairs_utility (u x : bool) (ab : bool * bool) : rat := worth u.

Lemma kernel_both_most : kernel (both (krr most) (krr most) : bool * bool -> bool * bool -> rat).
Proof. exact: (kernel_both kernel_most kernel_most). Qed.

Example T9_products_monotone_applies :
  local_le 2%:R (utility (induced MX (both (krr half) (krr half)) pairs_policy) pairs_utility).
Proof.
apply: (T9_products_monotone (p := most) (s := most) two_groups two_groups _ low_half _ _ low_half) => // x a a'.
have kP : policy pairs_policy by move=> y b; apply: kT.
have v : valued 1 2%:R pairs_utility by move=> u y b; apply: (g_1_2 u y true).
have /andP[_ le] := utility_ranged kX kernel_both_most kP x a v; apply: le_trans le _.
by rewrite ler_pmulr //; case/andP: (utility_ranged kX kernel_both_most kP x a' v).
Qed.

(* ---- T10 ---- *)

Definition always_even (B : finType) (v : B) (u : bool) : rat := even u u.
Definition sure (u s : bool) : rat := 1.
Lemma k_always (B : finType) : kernel (@always_even B). Proof. by move=> v; split=> [[]|] //; rewrite big_bool. Qed.
Lemma sure_01 u s : 0 <= sure u s <= 1. Proof. by []. Qed.
Lemma sure_ge0 u s : 0 <= sure u s. Proof. by []. Qed.
Lemma ones_ge0 (u : bool) : 0 <= (fun _ : bool => 1 : rat) u. Proof. by []. Qed.
Local Notation persons := (fun s : bool => s).

Lemma person_sure i : person_utility MA (@always_even _) sure persons i = 1.
Proof.
rewrite /person_utility; transitivity (chance MA (fun v s => 1 - (fun _ _ => 0) v s) persons i); last first.
  rewrite (chance_affine kA) /chance big1 ?mulr0 ?subr0 // => o _.
  by rewrite big1 // => v _; rewrite mulr0.
by rewrite /chance; congr (_ * _); apply: eq_bigr => o _; apply: eq_bigr => v _; rewrite subr0 expect_cst //; apply: k_always.
Qed.

Example T10_persons_applies i j : person_utility MA (@always_even _) sure persons i <= 2%:R ^+ 2 * person_utility MA (@always_even _) sure persons j.
Proof. exact: (T10_persons kA (@k_always _) persons i j dA sure_ge0). Qed.

Example T10_floor_applies : person_utility MA (@always_even _) sure persons true <=
  (1 + 1 * hockey_stick 1 (both MA MA (true, false)) (both MA MA (false, true)) / 1) * person_utility MA (@always_even _) sure persons false.
Proof. by apply: (T10_floor kA (@k_always _) 1 (i := true) (j := false)) => //; rewrite person_sure. Qed.

Example T10_floor_pure_applies : person_utility MA (@always_even _) sure persons true <=
  Num.min (Num.min (1 / 1) (2%:R ^+ 2)) ((1 - (1 - 1 / 1) / 2%:R ^+ 2) / (1 / 1)) * person_utility MA (@always_even _) sure persons false.
Proof. by apply: (T10_floor_pure kA (@k_always _) true (j := false) _ dA sure_01); rewrite ?person_sure. Qed.

Example T10_profiles_in_fixed_slots_applies (f := fun _ : bool => 1 : rat) : fixed_utility (S := bool_finType) MA (@always_even [finType of {ffun bool -> bool}]) f persons <=
  2%:R ^+ #|[set p : bool | persons p != true]| * fixed_utility (S := bool_finType) MA (@always_even [finType of {ffun bool -> bool}]) f (fun=> true).
Proof. exact: (T10_profiles_in_fixed_slots kA (@k_always _) persons (fun=> true) dA ones_ge0). Qed.

Example T10_exchange_in_fixed_slots_applies (f := fun _ : bool => 1 : rat) : fixed_utility (S := bool_finType) MA (@always_even [finType of {ffun bool -> bool}]) f persons <=
  2%:R ^+ 2 * fixed_utility (S := bool_finType) MA (@always_even [finType of {ffun bool -> bool}]) f (fun p => tperm true false p).
Proof. exact: (T10_exchange_in_fixed_slots kA (@k_always _) persons true false dA ones_ge0). Qed.

Definition nobody (v : {ffun bool -> bool}) : option bool -> rat := point _ None.

Example T10_chosen_applies : person_utility MA nobody (fun u s => (u == Some s)%:R) persons true <=
  2%:R ^+ 2 * person_utility MA nobody (fun u s => (u == Some s)%:R) persons false.
Proof. by apply: (T10_chosen persons true false kA _ dA) => v; apply: law_point. Qed.

Lemma candidate_sure a b : candidate_utility MA (@always_even _) sure a b = 1.
Proof.
have e v : expect (@always_even _ v) (fun u => sure u true) = 1 :> rat by rewrite expect_cst //; apply: k_always.
rewrite /candidate_utility; do 2 rewrite (eq_expect (g' := fun=> 1) (fun=> erefl _)) //.
by rewrite !expect_cst //; apply: kernel_both; exact: kA.
Qed.

Example T10_two_candidates_applies : candidate_utility MA (@always_even _) sure true false <= 2%:R ^+ 2 * candidate_utility MA (@always_even _) sure false true.
Proof. exact: (T10_two_candidates kA (@k_always _) true false dA sure_ge0). Qed.

Example T10_two_candidates_floor_applies : candidate_utility MA (@always_even _) sure true false <=
  (1 + 1 * hockey_stick 1 (both MA MA (true, false)) (both MA MA (false, true)) / 1) * candidate_utility MA (@always_even _) sure false true.
Proof. by apply: (T10_two_candidates_floor (@k_always _) 1) => //; rewrite candidate_sure. Qed.

Example T10_two_candidates_floor_pure_applies : candidate_utility MA (@always_even _) sure true false <=
  Num.min (Num.min (1 / 1) (2%:R ^+ 2)) ((1 - (1 - 1 / 1) / 2%:R ^+ 2) / (1 / 1)) * candidate_utility MA (@always_even _) sure false true.
Proof. by apply: (T10_two_candidates_floor_pure kA (@k_always _) _ dA sure_01); rewrite ?candidate_sure. Qed.

(* ---- T11: the table is 2/3, 1/3 and the filter is said to have e^eps = 1 ---- *)

Definition hit_yes (u x a : bool) : rat := u%:R.
Lemma hit_yes_ge0 u x a : 0 <= hit_yes u x a. Proof. exact: ler0n. Qed.
Lemma exceeds x : 1 * utility rows hit_yes x false < utility rows hit_yes x true.
Proof. by case: x; rewrite /utility /expect !big_bool. Qed.

Lemma M_rows : assumption_M rows MA.
Proof.
split; first exact: kA.
exists unit_finType, (@no_context _ bool_finType), (fun _ b => point _ b); split=> [|y b|x a u]; [exact: kernel_no_context|exact: law_point|].
by rewrite /induced big_unit /rows /no_context -[LHS](expect_pointr (MA a) u); apply: eq_bigr => b _; rewrite /point mul1r eq_sym.
Qed.

Example T11_refutation_applies : ~ (assumption_M rows MA /\ every_pair (pure_dp 1) MA).
Proof. by apply: (T11_refutation _ hit_yes_ge0 (exceeds true)). Qed.

Example T11_not_private_applies : ~ every_pair (pure_dp 1) MA.
Proof. by apply: (T11_not_private _ hit_yes_ge0 M_rows (exceeds true)). Qed.

Definition constant_filter (a b : bool) : rat := even a b.

Example T11_not_assumption_M_applies : ~ assumption_M rows constant_filter.
Proof. by apply: (T11_not_assumption_M _ hit_yes_ge0 _ (exceeds true)) => // a a' b; rewrite mul1r. Qed.

Example T11_test_applies : prob (MA true) [set w | 2%:R < (fun _ : bool => 1 : rat) w] <= 0.
Proof.
apply: (@T11_test _ _ _ _ _ rows MA hit_yes _ hit_yes_ge0 _ (MA true) (fun=> 1) 1 0 2%:R true) => //.
- exact: law_MA.
- by rewrite subr0 /prob (eq_bigl xpredT) ?big_bool // => w; rewrite inE lexx.
- exact: M_rows.
- exact: dA.
Qed.

(* ---- T12 ---- *)

Lemma E_gt0 x a : 0 < E x a. Proof. exact: lt_le_trans (floor_E x a). Qed.

Example T12_tanh_applies : tanh_half (contraction 2%:R 2%:R) = tanh_half 2%:R * tanh_half 2%:R :> rat.
Proof. by apply: T12_tanh. Qed.

Example T12_tanh_pair_applies x a a' : tanh_half (E x a / E x a') <= tanh_half 2%:R * tanh_half 2%:R.
Proof. by apply: (T12_tanh_pair kX kA kT a _ _ g_ge0 free_g own_ratio dA (E_gt0 x a')). Qed.

Example T12_never_worse_applies : contraction 2%:R 2%:R <= 2%:R :> rat.
Proof. by have [] := @T12_never_worse rat_realFieldType 2%:R 2%:R. Qed.

Example T12_sharp_applies : kernel (coin_filter (2%:R : rat)).
Proof. by have [] := @T12_sharp rat_realFieldType 2%:R 2%:R. Qed.

Example L_eo_contraction_applies x a a' : tv (induced MX MA T x a) (induced MX MA T x a') <= 1 * tv (MA a) (MA a').
Proof.
apply: (L_eo_contraction kX kA) => // y b b'; have /dp_hockey_stick := proj1 (pure_dp_dp 3%:R (T y b) (T y b')) (dX b b').
by move=> _; case: b; case: b'; rewrite /tv /hockey_stick big_bool.
Qed.

(* ---- Products and draws ---- *)

Definition two_factors : seq (factor rat_realFieldType) := [:: Factor MA; Factor MX].
Definition e_eps (f : factor rat_realFieldType) : rat := 3%:R.

Lemma k_factors : every (fun f => kernel (@Products.row _ f)) two_factors.
Proof. by split; [exact: kA|split; [exact: kX|]]. Qed.

Lemma dA3 : every_pair (pure_dp 3%:R) MA.
Proof. by move=> a a' b; apply: le_trans (dA a a' b) _; apply: ler_wpmul2r => //; case: (kA a'). Qed.

Example product_kernel_applies : kernel (@product _ two_factors).
Proof. exact: (product_kernel k_factors). Qed.

Example product_pure_dp_applies a a' : pure_dp (differing e_eps a a') (@product _ two_factors a) (@product _ two_factors a').
Proof. by apply: product_pure_dp; split; [split; [exact: kA|exact: dA3]|split; [split; [exact: kX|exact: dX]|]]. Qed.

Example product_every_pair_applies : every_pair (pure_dp (\prod_(f <- two_factors) e_eps f)) (@product _ two_factors).
Proof. by apply: product_every_pair; split; [split; [exact: kA|exact: dA3|]|split; [split; [exact: kX|exact: dX|]|]]. Qed.

Example product_attained_applies : exists a a' b, 0 < @product _ [:: Factor MX] a' b /\
  @product _ [:: Factor MX] a b = (\prod_(f <- [:: Factor MX]) e_eps f) * @product _ [:: Factor MX] a' b.
Proof.
have [|a [a' [b [? ?]]]] := @product_attained rat_realFieldType e_eps [:: Factor MX]; last by exists a, a', b.
by split=> //; exists true, false, true.
Qed.

(* each output is a class of its own *)
Definition itself (f : factor rat_realFieldType) (a a' : input f) (b : output f) : output f := b.
Lemma alike_itself f a a' : alike (@itself f a a') (@Products.row _ f a) (@Products.row _ f a').
Proof. by move=> b b' e; have -> : b = b' := e. Qed.

Example product_hockey_stick_applies a a' : hockey_stick 2%:R (@product _ two_factors a) (@product _ two_factors a') =
  hockey_stick 2%:R (merged_rows itself a a').1 (merged_rows itself a a').2.
Proof. exact: (product_hockey_stick alike_itself 2%:R a a' k_factors). Qed.

Example product_merged_applies a a' : \sum_o (@product _ two_factors a o + @product _ two_factors a' o) =
  \sum_c ((merged_rows itself a a').1 c + (merged_rows itself a a').2 c).
Proof. by apply: (product_merged alike_itself (F := fun x y => x + y) k_factors) => s x y _; rewrite mulrDr. Qed.

Example product_surplus_applies a a' : surplus true (fun o u => @product _ two_factors a o * worth u) (fun o u => @product _ two_factors a' o * worth u) 2%:R =
  surplus true (fun c u => (merged_rows itself a a').1 c * worth u) (fun c u => (merged_rows itself a a').2 c * worth u) 2%:R.
Proof. exact: (product_surplus alike_itself true worth worth 2%:R a a' k_factors). Qed.

(* bisect_right, as it may be written *)
Definition find_draw (row : seq nat) (r : nat) : nat := find (fun c => r < c)%N (cumulative row).

Lemma find_bisects row r : bisected (cumulative row) r (find_draw row r).
Proof.
split=> [|j lt|j /andP[ge lt]]; first exact: find_size.
  by have := before_find 0%N lt; rewrite ltnNge => /negbFE.
have some : has (fun c => r < c)%N (cumulative row) by rewrite has_find (leq_ltn_trans ge).
apply: leq_trans (nth_find 0%N some) _; rewrite size_scanl in lt.
have lt' : (find_draw row r < size row)%N := leq_ltn_trans ge lt.
rewrite -/(find_draw row r) !nth_cumulative // -(subnKC ge) -addSn takeD sumn_cat.
exact: leq_addr.
Qed.

(* one chance in three for the first output, two for the second *)
Definition thirds : seq nat := [:: 1; 2]%N.

Example draws_counted_applies : #|[set r : 'I_(sumn thirds) | find_draw thirds r == 1%N]| = 2%N.
Proof. exact: (draws_counted (find_bisects thirds) 1%N). Qed.

Example sampler_one_applies : prob (@uniform rat_realFieldType (sumn thirds)) [set r : 'I_(sumn thirds) | find_draw thirds r == 1%N] = 2%:R / 3%:R.
Proof. exact: (sampler_one _ find_bisects thirds 1%N). Qed.

Example sampler_law_applies : prob (@independent_uniform rat_realFieldType [:: thirds; thirds]) [set r | word find_draw r == [:: 1; 0]%N] =
  2%:R / 3%:R * (1 / 3%:R * 1).
Proof. exact: (sampler_law _ find_bisects [:: thirds; thirds] [:: 1; 0]%N). Qed.
