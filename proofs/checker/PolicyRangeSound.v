(* What PolicyRange.v accepts bounds the ratio of every policy, or of every one that keeps the floors, for every utility of the declared range. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions T13_range.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound PolicyLaw Likelihoods LikelihoodsSound PolicyClaims PolicyFacts PolicyBounds PolicyMeans.
From FairauditChecker Require Import PolicySites PolicySitesSound PolicyWorthSound PolicySupremaSound PolicyShown PolicyShownSound PolicyRange.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Range.
Variables (R : realFieldType) (S : behind).
Hypotheses (ok : valid S).
Local Notation number := (@number R).
Local Notation MX := (@MX R S).
Local Notation MA_all := (@MA_all R S).
Local Notation share := (@share R S).
Local Notation A := (A S).
Local Notation X := (X S).
Local Notation Xt := (Xt S).
Local Notation memory := (memory S).
Local Notation kX := (kernel_MX R ok).
Local Notation kM := (kernel_MA_all R ok).
Local Notation quantity := (@quantity R S).

Lemma bigmax_le (I : finType) (f : I -> R) c : 0 <= c -> (forall i, f i <= c) -> \big[Num.max/0]_i f i <= c.
Proof. by move=> c0 all; elim/big_rec: _ => // i x _ h; rewrite le_maxl all h. Qed.

Lemma effective_L_le : consistent S -> effective_L R S <= ratio (L_used S).
Proof.
move=> cons; have L0 := L_ge0 R ok cons; rewrite /effective_L; move: (spread_within R ok cons) L0; rewrite /L_used /effective.
case: (lipschitz (stated S)) => [q|] // within L0.
do 4 (apply: bigmax_le => // ?); by rewrite ler_subl_addl; apply: within.
Qed.

Lemma own_declaredE (field : declared_in -> option Q) (x : X) q otherwise : otherwise = Some q ->
  own_number R field x otherwise = ratio (own_declared S field x q).
Proof.
by move=> ->; rewrite /own_number /own /own_declared; case: (List.find _ _) => [d|] //; case: (field d).
Qed.

(* ---- One pair of rows ---- *)

Section Pair.
Variables (B : finType) (P P' : B -> R) (W : Z) (s : likelihoods) (high low : Q).
Hypotheses (W0 : Z.lt Z0 W) (sS : stands (embed W) s P P').
Local Notation gap_of := (lesser (L_used S) (difference high low)).

Lemma gapE : ratio gap_of = gap (ratio low) (ratio high) (ratio (L_used S)) :> R.
Proof. by rewrite ratio_lesser ratio_difference. Qed.

Lemma excessE k : ratio (PolicyRange.range_excess high low gap_of W s k) =
  T13_range.range_excess (ratio low) (ratio high) (ratio (L_used S)) P P' (ratio k) :> R.
Proof. by rewrite ratio_difference ratio_plus !ratio_times !ratio_difference ratio_one gapE (hockeyP k W0 sS). Qed.

Variables (V : Q) (e e' : R).
Hypothesis V1 : 1 <= ratio V :> R.

(* From one k to the ratio of two expectations e and e', of which the lower one has the floor *)
Lemma range_atP (ks : option (seq Q)) floor : (ks -> ratio floor <= e') -> range_at V ks high low gap_of floor W s ->
  (forall k, 0 <= k -> e <= k * e' + T13_range.range_excess (ratio low) (ratio high) (ratio (L_used S)) P P' k) ->
  (0 <= ratio high :> R -> e <= ratio high) -> e <= ratio V * e'.
Proof.
case: ks => [ks|] /= te accepted bound capped; last first.
  move/(at_mostP R): accepted; rewrite ratio_zero excessE => le.
  apply: le_trans (bound _ (le_trans ler01 V1)) _.
  by rewrite -[leRHS]addr0 ler_add2l.
have {}te := te isT; case/and3P: accepted => _ /(ratio_ge0 R) h0.
case/orP => [/(at_mostP R)|/existsb_exists[k [_ /and3P[/(ratio_ge0 R) k0 /(at_mostP R) kV /(at_mostP R)]]]].
  rewrite ratio_times => le; apply: le_trans (capped h0) (le_trans le _).
  by apply: ler_wpmul2l => //; apply: le_trans ler01 V1.
rewrite excessE ratio_times ratio_difference => le; apply: le_trans (bound _ k0) _.
rewrite -[X in _ <= X * _](subrK (ratio k)) addrC mulrDl ler_add2r; apply: le_trans le _.
by apply: ler_wpmul2l; rewrite ?subr_ge0.
Qed.
End Pair.

(* ---- Rows of means ---- *)

Lemma mean_stands (a a' : A) : 0 < mass_of R a -> 0 < mass_of R a' -> Z.lt Z0 (mean_unit S a a') /\
  stands (embed (mean_unit S a a')) (mean_likelihoods S (rows_of S) a a') (mean_row MA_all share a) (mean_row MA_all share a').
Proof.
move=> m0 m0'; set F := [:: shares S a; shares S a'].
have unit0 : Z.lt Z0 (unit_of F) by apply: common_gt0.
have rows0 : Z.lt Z0 (rows_unit S) by rewrite /rows_unit; elim: (times_released S) => //= n; apply: Z.mul_pos_pos; apply: common_gt0.
split; first exact: Z.mul_pos_pos.
have sizes (b : A) : size (shares S b) = true_contexts S by apply: shares_size.
have own : stands (embed (unit_of F)) (of_rows (nth [::] (integers F) 0) (nth [::] (integers F) 1)) (share a) (share a').
  apply: (stands_same (P := fun i : X => number (shares S a) i) (Q := fun i : X => number (shares S a') i)) => [|x|x]; last 2 first.
  - exact: shares_number.
  - exact: shares_number.
  apply: (@of_rowsP R _ _ _ (true_contexts S) (fun i => number (shares S a) i) (fun i => number (shares S a') i)).
  - by rewrite size_map_list sizes.
  - by rewrite size_map_list sizes.
  - exact: unit_of_ge0.
  - by move=> j _; rewrite !integersE.
  move=> j hj; rewrite -[j]/(nat_of_ord (Ordinal hj : X)) !shares_number //.
  by split; apply: (@share_ge0 R S ok).
have [ns e] := joint_stands own (rows_stand R ok a a').
rewrite /mean_likelihoods; cbv zeta; rewrite !list_nth; move: ns e; rewrite -/F /row_likelihoods.
move: (joint _ _) => s ns e; split; [exact: ns | move=> G hG].
by rewrite e // embedM pair_bigA.
Qed.

(* ---- Claims ---- *)

Lemma of_seq (x : X) : In (nat_of_ord x) (List.seq 0 (true_contexts S)).
Proof. by apply/in_seq; split; [exact: Nat.le_0_l | apply/ssrnat.ltP/ltn_ord]. Qed.

Section Utility.
Variables (U' : finType) (T : Xt -> memory -> U' -> R) (g' : U' -> X -> A -> R).
Hypothesis kT : policy T.
Local Notation E := (Definitions.utility (induced MX MA_all T) g').

Lemma law_both (B C : finType) (P : B -> R) (P' : C -> R) : law P -> law P' -> law (fun bc : B * C => P bc.1 * P' bc.2).
Proof. by move=> lP lP'; exact: (@kernel_both R unit_finType unit_finType B C (fun=> P) (fun=> P') (fun=> lP) (fun=> lP') (tt, tt)). Qed.

Section Means.
Variables (high low : R) (a a' : A).
Hypotheses (m0 : 0 < mass_of R a) (m0' : 0 < mass_of R a') (vg : valued low high g').
Hypothesis gL : forall u x b b', g' u x b <= g' u x b' + ratio (L_used S).

Lemma law_means (b : A) : 0 < mass_of R b -> law (mean_row MA_all share b).
Proof. by move=> mb; exact: (law_both (law_share ok mb) (kM b)). Qed.

Lemma mean_one_k k : 0 <= k -> mean E a <= k * mean E a' + T13_range.range_excess low high (ratio (L_used S)) (mean_row MA_all share a) (mean_row MA_all share a') k.
Proof.
move=> k0; have kX_ := kX; rewrite /mean !mean_response; apply: range_le => //; try by apply: law_means.
- by move=> xb; apply: response_ranged.
- by move=> xb; apply: response_ranged.
by move=> xb; apply: response_le.
Qed.

Lemma mean_capped : mean E a <= high.
Proof.
have kX_ := kX; rewrite /mean mean_response; have r xb : low <= response MX T g' xb.1 a xb.2 <= high by apply: response_ranged.
by case/andP: (expect_ranged (law_means m0) r).
Qed.
End Means.
End Utility.

Lemma range_within means V (ks : option (seq Q)) (E : X -> A -> R) : range_accepted S means V ks = Some true -> of_any_utility means E -> (ks -> keeps_floors E) -> within means (ratio V) E.
Proof.
rewrite /range_accepted; case et: (gamma (stated S)) => [high|] //; case el: (m (stated S)) => [low|] //.
case: ifP => // _ []; cbv zeta => /and5P[cons /(at_mostP R) + low_high /forallb_forall ranges accepted].
rewrite ratio_one => V1 [U' [T [g' [kT gL rg eE]]]] floors; apply/withinP => c em a a' com com' aa.
have L_le u x b b' : g' u x b <= g' u x b' + ratio (L_used S).
  by apply: le_trans (gL u x b b') _; rewrite ler_add2l effective_L_le.
have kept : ks -> ratio (floor_of S (place_of c) a') <= quantity c E a' by move=> /floors keep; apply: floor_ofP.
case: c em com com' kept => [x|] em com com' kept; rewrite em /= in accepted rg; last first.
  have vg : valued (ratio low) (ratio high) g' by move=> u x b; have := rg u x b; rewrite et el.
  have [W0 sS] := mean_stands com com'.
  have [i [hi ei]] := In_nth _ _ 0%N (in_populated com); have [i' [hi' ei']] := In_nth _ _ 0%N (in_populated com').
  have inside : In (nat_of_ord a, nat_of_ord a') (ordered [::] (populated S)).
    rewrite -ei !list_nth; apply: in_ordered; first exact/ssrnat.ltP.
    right; exists i'; split; [exact/ssrnat.ltP | | by rewrite -ei' list_nth].
    by apply: contraNneq aa => ii; rewrite -(val_eqE a a') /= -ei -ei' ii.
  have {}accepted := proj1 (forallb_forall _ _) accepted _ inside.
  apply: (range_atP W0 sS V1 kept accepted) => [k k0|_].
    by rewrite !(eq_quantity None _ eE); apply: mean_one_k.
  by rewrite (eq_quantity None _ eE); apply: mean_capped.
have {}accepted := proj1 (forallb_forall _ _) (proj1 (forallb_forall _ _) accepted _ (of_seq x)).
have [s sin sS] := kinds_stand R ok aa.
have W0 : Z.lt Z0 (kinds_unit S) by rewrite /kinds_unit; elim: (times_released S) => //= n h; apply: Z.mul_pos_pos => //; elim: (group_filter S) => // F fs IH; apply: Z.mul_pos_pos => //; apply: common_gt0.
have rx (b : A) u : ratio (own_declared S m_in x low) <= g' u x b <= ratio (own_declared S gamma_in x high).
  by move: (rg u x b); rewrite /m_at /gamma_at (own_declaredE _ _ el) (own_declaredE _ _ et).
apply: (range_atP W0 sS V1 kept (accepted s sin)) => [k k0|_] /=; rewrite !eE.
  exact: (range_one_k kX kM kT (rx a) (rx a') (fun u => L_le u x a a') k0).
by rewrite utility_response; case/andP: (expect_ranged (kM a) (response_in kX kT (rx a))).
Qed.

Theorem range_sound means V : range_accepted S means V None = Some true -> greatest_at_most means (@of_any_utility R S means) (Some V).
Proof. by move=> accepted E inE; apply: (range_within accepted inE). Qed.

Theorem floored_range_sound means V ks : range_accepted S means V (Some ks) = Some true ->
  greatest_at_most means (fun E : X -> A -> R => of_any_utility means E /\ keeps_floors E) (Some V).
Proof. by move=> accepted E [inE keep]; apply: (range_within accepted inE). Qed.
End Range.
