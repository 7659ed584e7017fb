(* What PolicyClaims.v accepts by one theorem is true of every law in the scope of the claim. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP Ratios T1 T3 T4 T12 T13 Rules.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound PolicyLaw PolicyTable Likelihoods PolicyClaims PolicyFacts.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Bounds.
Variables (R : realFieldType) (S : behind).
Hypotheses (ok : valid S) (cons : consistent S).
Local Notation MX := (@MX R S).
Local Notation MA := (@MA R S).
Local Notation T0 := (@T0 R S).
Local Notation g := (@g R S).
Local Notation A := (A S).
Local Notation X := (X S).
Local Notation number := (@number R).
Local Notation kX := (kernel_MX R ok).
Local Notation kA := (kernel_MA R ok).
Local Notation g0 := (@g_ge0 R S ok).

Lemma bounded_local (class : (X -> A -> R) -> Prop) b (V : option Q) : no_more (Some b) V ->
  (forall E, class E -> forall x a a', a != a' -> 0 <= E x a' /\ E x a <= ratio b * E x a') -> greatest_at_most false class V.
Proof.
case: V => [v|] //= /(at_mostP R) le all E inE x a a' aa; have [E0 h] := all E inE x a a' aa.
by apply: le_trans h _; apply: ler_wpmul2r.
Qed.

Lemma no_moreP p V : no_more p V -> if V is Some v then exists2 b, p = Some b & ratio b <= ratio v :> R else True.
Proof. by case: p V => [b|] [v|] // /(at_mostP R); exists b. Qed.

Lemma E_ge0 (B : finType) (M : A -> B -> R) (T : Xt S -> B -> U S -> R) x a : kernel M -> policy T ->
  0 <= Definitions.utility (induced MX M T) g x a.
Proof. by move=> kM kT; apply: (utility_ge0 kX kM g0). Qed.

Theorem T2_sound V : one_release S -> a_free S -> no_more (epsilon S) V -> epsilon S ->
  greatest_at_most false (@of_any_policy R S) V.
Proof.
case e: (epsilon S) => [b|] // one free le _; have [_ pure] := epsilonP R ok e.
apply: bounded_local le _ => E [T [kT eE]] x a a' _; rewrite !eE; split.
  exact: E_ge0 (kernel_MA_all R ok) kT.
by apply: (T2_pure kX kT g0 (freeP R ok cons free)); apply: pure_all.
Qed.

(* A law in the scope of a claim with a floor: that of this policy, or of any policy that keeps the floor *)
Record floored_law (t : R) (E : X -> A -> R) (B : finType) (M : A -> B -> R) (T : Xt S -> B -> U S -> R) : Prop := FlooredLaw {
  kernel_M : kernel M;
  policy_T : policy T;
  is_E : forall x a, E x a = Definitions.utility (induced MX M T) g x a;
  keeps_t : has_floor t E;
  sums : forall a a' (f : R -> R -> R), \sum_w f (M a w) (M a' w) = \sum_b f (MA a b) (MA a' b);
  pures : forall e, every_pair (pure_dp e) MA -> every_pair (pure_dp e) M
}.

Lemma in_scopeP s t means E : in_scope S s -> floor_in S s = Some t -> class_of means s E ->
  exists (B : finType) (M : A -> B -> R) (T : Xt S -> B -> U S -> R), floored_law (ratio t) E M T.
Proof.
case: s => // [_ [<-] eE|one e [[T [kT eE]] floor]].
  exists (At S), MA, T0; split=> //; [exact: kA | exact: policy_T0 | by move=> x a; rewrite eE; apply: tau_of_lawP].
exists (memory S), (@MA_all R S), T; split=> //.
- exact: kernel_MA_all.
- by move=> x a; move: (floor x a); rewrite -[tau (stated S)]/(floor_in S KeepingFloor) e.
- by apply: all_once; apply/Pos.eqb_eq.
- by move=> e'; apply: pure_all.
Qed.

Lemma with_floorP s f : with_floor S s f ->
  exists t, [/\ floor_in S s = Some t, ratio (inverse t) = (ratio t)^-1 :> R, 0 < ratio t :> R & f t].
Proof. by rewrite /with_floor; case: (floor_in S s) => // t /andP[t0 ft]; exists t; rewrite ratio_inverse // ratio_gt0. Qed.

Lemma valued_g : valued 0 (ratio (gamma_used S)) g.
Proof. by move=> u x a; rewrite g0; have /andP[] := g_within R ok cons u x a. Qed.

Lemma valued_m : valued (ratio (m_used S)) (ratio (gamma_used S)) g.
Proof. exact: g_within. Qed.

Lemma spread_norm u x a a' : `|g u x a - g u x a'| <= ratio (L_used S).
Proof. by rewrite ler_norml ler_oppl opprB !ler_subl_addl !spread_within. Qed.

Theorem T1_paper_sound s V means : in_scope S s -> epsilon S ->
  with_floor S s (fun t => no_more (both times (epsilon S) (Some (plus one (times (L_used S) (inverse t))))) V) ->
  greatest_at_most false (class_of (R := R) (S := S) means s) V.
Proof.
case e: (epsilon S) => [b|] // sc _ /with_floorP[t [st ti t0 le]]; have [b1 pure] := epsilonP R ok e.
apply: bounded_local le _ => E inE x a a' _; have [B [M [T F]]] := in_scopeP sc st inE.
have [kM kT eE floor _ pures] := F; rewrite !eE; split; first exact: E_ge0.
rewrite ratio_times ratio_plus ratio_one ratio_times ti -[ratio (L_used S)]addr0 -(mul0r (ratio (gamma_used S))).
apply: (T1_paper kX kM kT _ (lexx 0) valued_g spread_norm) => //; [exact: gamma_ge0 | exact: L_ge0 | |].
  by move=> c c'; apply/pure_dp_dp/pures.
by move=> y c; rewrite -eE.
Qed.

Theorem floor_sound s V means : in_scope S s ->
  with_floor S s (fun t => no_more (Some (times (gamma_used S) (inverse t))) V) ->
  greatest_at_most false (class_of (R := R) (S := S) means s) V.
Proof.
move=> sc /with_floorP[t [st ti t0 le]].
apply: bounded_local le _ => E inE x a a' _; have [B [M [T F]]] := in_scopeP sc st inE.
have [kM kT eE floor _ pures] := F; rewrite !eE; split; first exact: E_ge0.
rewrite ratio_times ti; apply: (T1_cap kX kM kT valued_g t0) => y c.
by rewrite -eE.
Qed.

(* ---- This policy behind other group filters ---- *)

Lemma answersE x y b : (x < true_contexts S)%N -> (y < released_contexts S)%N -> (b < released_groups S)%N ->
  ratio (nth zero (nth [::] (answers S x) y) b) =
  \sum_(u < decisions S) number (nth [::] (nth [::] (policy_laws S) y) b) u * number (gains S x 0) u.
Proof.
move=> hx hy hb; have [sy sb] := laws_shaped ok.
rewrite /answers (@nth_map_in _ _ [::]) ?sy // (@nth_map_in _ _ [::]) ?sb //; apply: expectedP.
  by have [] := laws_lawful R ok hy hb.
by have [] := gains_ok R ok hx (ltnW (two_groups ok)).
Qed.

Lemma answersP (x : X) (y : Xt S) (b : At S) (a : A) : a_free S ->
  ratio (nth zero (nth [::] (answers S x) y) b) = expect (T0 y b) (fun u => g u x a).
Proof.
move=> free; rewrite answersE ?ltn_ord //; apply: eq_bigr => u _; congr (_ * _).
exact: (freeP R ok cons free u x (Ordinal (ltnW (two_groups ok))) a).
Qed.

Lemma answers_size x y : (y < released_contexts S)%N ->
  size (answers S x) = released_contexts S /\ size (nth [::] (answers S x) y) = released_groups S.
Proof.
move=> hy; have [sy sb] := laws_shaped ok.
by rewrite /answers size_map_list (@nth_map_in _ _ [::]) ?sy // size_map_list sb.
Qed.

Lemma context_matrix_size : size (context_matrix S) = true_contexts S /\
  forall x, (x < true_contexts S)%N -> size (nth [::] (context_matrix S) x) = released_contexts S.
Proof.
rewrite /context_matrix /true_contexts /released_contexts; move: (context_filter_ok R ok).
case: (context_filter S) => [fs lfs|n _].
  by rewrite multiplied_out_size; split=> // x /(lawful_product lfs)[].
split; first exact: identity_size.
elim: n => // n IH [|x] h /=; first by rewrite -size_length repeat_length.
by rewrite (@nth_map_in _ _ [::]) ?identity_size //= IH.
Qed.

Lemma policy_floorP : a_free S -> Rules.policy_floor MX T0 g (ratio (PolicyClaims.policy_floor S)).
Proof.
move=> free x a y b M0; rewrite -(answersP x y b a free); apply: least_of_le; apply/in_flat_map.
have [sm smx] := context_matrix_size; have [sa sab] := answers_size x (ltn_ord y).
exists (nat_of_ord x, nth [::] (context_matrix S) x); split; first by apply/(in_numbered [::]); rewrite sm ltn_ord.
apply/in_flat_map; exists (nth zero (nth [::] (context_matrix S) x) y, nth [::] (answers S x) y); split.
  rewrite -nth_combine ?smx ?sa ?ltn_ord //; apply: in_nth; by rewrite size_combine ?smx ?sa.
have : positive_fraction (nth zero (nth [::] (context_matrix S) x) y).
  case e: (positive_fraction _) => //; have := not_positive R e.
  by rewrite leNgt -[ratio _]/(MX x y) M0.
by move=> /= ->; apply: in_nth; rewrite sab.
Qed.

Lemma responsesP (x : X) (b : At S) (a : A) : a_free S ->
  number (nth [::] (responses S) x) b = response MX T0 g x a b.
Proof.
move=> free; have [sm smx] := context_matrix_size.
have rows i : (i < size (answers S x))%N -> size (nth [::] (answers S x) i) = released_groups S.
  move=> hi; have := answers_size x (y := i); rewrite /answers size_map_list (proj1 (laws_shaped ok)) in hi.
  by move=> /(_ hi)[].
have sn (T : Type) (s : seq T) : size (numbered s) = size s by rewrite /numbered size_combine -?size_length ?seq_length.
have sa : size (answers S x) = released_contexts S by rewrite /answers size_map_list (proj1 (laws_shaped ok)).
have [sc cE] := columnsP rows.
rewrite /number /PolicyMeaning.number /responses (@nth_map_in _ _ (0%N, [::])) ?sn ?sm // (numberedE [::]) ?sm //=.
rewrite (@nth_map_in _ _ [::]) ?sc // (@expectedP R (released_contexts S)) ?smx // ?(columns_size rows) ?sa //.
rewrite response_expect /expect; apply: eq_bigr => y _; congr (_ * _).
rewrite -/(expect _ _) -(answersP x y b a free) /number /PolicyMeaning.number.
by have [|//|_ ->] := cE y b; rewrite ?sa.
Qed.

Lemma response_ge0 (x : X) (b : At S) (a : A) : 0 <= response MX T0 g x a b.
Proof.
rewrite response_expect; apply: expect_ge0 => [|y]; first exact: kX.
by apply: expect_ge0 => [|u]; [exact: (policy_T0 R ok) | exact: g0].
Qed.

Lemma raw_ratioP r : a_free S -> raw_ratio S = Some r -> 1 <= ratio r :> R /\
  forall (x : X) (a : A) (b b' : At S), response MX T0 g x a b <= ratio r * response MX T0 g x a b'.
Proof.
move=> free /(greater_ofP R)[one_le all]; split=> // x a b b'; have [sm smx] := context_matrix_size.
have sn (T : Type) (s : seq T) : size (numbered s) = size s by rewrite /numbered size_combine -?size_length ?seq_length.
have sr : size (responses S) = true_contexts S by rewrite size_map_list sn sm.
have [|q [qE q_le]] := all (nth [::] (responses S) x); first by apply: in_nth; rewrite sr.
have sb : size (nth [::] (responses S) x) = released_groups S.
  rewrite /responses (@nth_map_in _ _ (0%N, [::])) ?sn ?sm // (numberedE [::]) ?sm //= size_map_list.
  have rows i : (i < size (answers S x))%N -> size (nth [::] (answers S x) i) = released_groups S.
    by rewrite size_map_list (proj1 (laws_shaped ok)) => hi; have [] := answers_size x hi.
  exact: (proj1 (columnsP rows)).
have r0 c : (c < released_groups S)%N -> 0 <= number (nth [::] (responses S) x) c.
  by move=> hc; rewrite (responsesP x (Ordinal hc) a free) response_ge0.
have all0 c : 0 <= number (nth [::] (responses S) x) c.
  case: (ltnP c (released_groups S)) => hc; first exact: r0.
  by rewrite number_out // sb.
have hb (c : At S) : (c < size (nth [::] (responses S) x))%N by rewrite sb.
have [_ le] := widestP qE all0 (hb b) (hb b'); rewrite -!(responsesP x _ a free).
by apply: le_trans le _; rewrite ler_wpmul2r.
Qed.

Lemma mean_ratio (B : finType) (P Q h : B -> R) r : law P -> law Q -> (forall b b', h b <= r * h b') -> expect P h <= r * expect Q h.
Proof.
move=> [P0 P1] [Q0 Q1] le; rewrite -expectZ; apply: mean_ge => // b'.
by apply: mean_le.
Qed.

Theorem T12_sound V : a_free S -> no_more (contraction_of (epsilon S) (raw_ratio S)) V ->
  greatest_at_most false (@of_group_filter R S) V.
Proof.
case: V => [v|] // free le; case r: (raw_ratio S) le => [r0|]; case e: (epsilon S) => [b|] //= le.
- have [b1 pure] := epsilonP R ok e; have [r1 resp] := raw_ratioP free r.
  apply: (@bounded_local _ _ (Some v) le) => E [M [kM pM eE]] x a a' _; rewrite !eE; split; first exact: E_ge0 kM (policy_T0 R ok).
  rewrite /private -[exp_epsilon _]/(epsilon S) e in pM; have d0 : 0 < ratio r0 + ratio b :> R by rewrite addr_gt0 // (lt_le_trans ltr01).
  have -> : ratio (times (plus one (times r0 b)) (inverse (plus r0 b))) = contraction (ratio b) (ratio r0) :> R.
    rewrite ratio_times ratio_inverse ?ratio_plus ?ratio_times ?ratio_one //.
    by case f: (positive_fraction _) => //; move/(not_positive R): f; rewrite ratio_plus leNgt d0.
  exact: (T12_contraction kX kM (policy_T0 R ok) b1 r1 g0 (freeP R ok cons free) resp pM).
- have [r1 resp] := raw_ratioP free r.
  apply: (@bounded_local _ _ (Some v) le) => E [M [kM pM eE]] x a a' _; rewrite !eE; split; first exact: E_ge0 kM (policy_T0 R ok).
  rewrite !utility_response.
  rewrite (eq_expect (P' := M a) (g' := response MX T0 g x a') _ (response_free MX T0 x a a' (freeP R ok cons free))) //.
  by apply: mean_ratio; [exact: kM | exact: kM | move=> c c'; apply: resp].
have [b1 pure] := epsilonP R ok e.
apply: (@bounded_local _ _ (Some v) le) => E [M [kM pM eE]] x a a' _; rewrite !eE; split; first exact: E_ge0 kM (policy_T0 R ok).
by rewrite /private -[exp_epsilon _]/(epsilon S) e in pM; apply: (T2_pure kX (policy_T0 R ok) g0 (freeP R ok cons free)).
Qed.

(* ---- This policy behind other context filters ---- *)

Lemma context_ratioP r : (if utility S is OfDecision _ then true else false) -> context_ratio S = Some r ->
  forall (y : Xt S) (x : X) (a a' : A),
    expect (MA a) (fun b => expect (T0 y b) (fun u => g u x a)) <= ratio r * expect (MA a') (fun b => expect (T0 y b) (fun u => g u x a')).
Proof.
move=> of_decision /(greater_ofP R)[one_le all] y x a a'.
have same x' c : gains S x' c = gains S 0 0 by rewrite /gains; case: (utility S) of_decision.
have [sa sab] := answers_size 0 (ltn_ord y).
have rows_size : size (group_matrix S) = true_groups S by rewrite multiplied_out_size.
have value c : number (nth [::] (unfiltered_contexts S) y) (nat_of_ord c) = expect (MA c) (fun b => expect (T0 y b) (fun u => g u x c)).
  rewrite /number /PolicyMeaning.number /unfiltered_contexts (@nth_map_in _ _ [::]) ?sa // (@nth_map_in _ _ [::]) ?rows_size //.
  rewrite (@expectedP R (released_groups S)) ?sab //; last by have [] := lawful_product (group_filter_ok R ok) (ltn_ord c).
  apply: eq_bigr => b _; congr (_ * _); rewrite /number /PolicyMeaning.number answersE ?ltn_ord ?(some_context ok) //.
  by apply: eq_bigr => u _; rewrite /g (same x c).
have [|q [qE q_le]] := all (nth [::] (unfiltered_contexts S) y); first by apply: in_nth; rewrite size_map_list sa.
have su : size (nth [::] (unfiltered_contexts S) y) = true_groups S.
  by rewrite /unfiltered_contexts (@nth_map_in _ _ [::]) ?sa // size_map_list rows_size.
have value0 c : 0 <= number (nth [::] (unfiltered_contexts S) y) c.
  case: (ltnP c (true_groups S)) => hc; last by rewrite number_out // su.
  rewrite (value (Ordinal hc)); apply: expect_ge0 => [|b]; first exact: kA.
  by apply: expect_ge0 => [|u]; [exact: (policy_T0 R ok) | exact: g0].
have ha (c : A) : (c < size (nth [::] (unfiltered_contexts S) y))%N by rewrite su.
have [_ le] := widestP qE value0 (ha a) (ha a'); rewrite -!value.
by apply: le_trans le _; rewrite ler_wpmul2r.
Qed.

Theorem T8_sound V : (if utility S is OfDecision _ then true else false) -> no_more (context_ratio S) V ->
  greatest_at_most false (@of_context_filter R S) V.
Proof.
move=> of_decision; case r: (context_ratio S) => [q|]; case: V => [v|] // le.
have bound := context_ratioP of_decision r.
apply: (@bounded_local _ _ (Some v) le) => E [M [kM eE]] x a a' _; rewrite !eE; split.
  exact: (utility_ge0 kM kA g0 x a' (policy_T0 R ok)).
have F c : Definitions.utility (induced M MA T0) g x c = \sum_y M x y * expect (MA c) (fun b => expect (T0 y b) (fun u => g u x c)).
  rewrite utility_response.
  transitivity (\sum_b \sum_y MA c b * (M x y * expect (T0 y b) (fun u => g u x c))).
    by apply: eq_bigr => b _; rewrite response_expect -mulr_sumr.
  rewrite exchange_big; apply: eq_bigr => y _; rewrite mulr_sumr.
  by apply: eq_bigr => b _; rewrite mulrCA.
rewrite !F; apply: ratio_of_means => y; first by case: (kM x).
exact: bound.
Qed.
End Bounds.
