(* What PolicyClaims.v accepts of the means of groups by T5 and T5-decision is true; and with it all that it accepts by one theorem. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP Ratios T1 T5 T13.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound PolicyLaw PolicyTable PolicyClaims PolicyFacts PolicyBounds PolicyMultipliers.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Means.
Variables (R : realFieldType) (S : behind).
Hypotheses (ok : valid S).
Local Notation number := (@number R).
Local Notation MX := (@MX R S).
Local Notation MA := (@MA R S).
Local Notation g := (@g R S).
Local Notation A := (A S).
Local Notation X := (X S).
Local Notation mass_of := (@mass_of R S).
Local Notation share := (@share R S).
Local Notation kX := (kernel_MX R ok).
Local Notation g0 := (@g_ge0 R S ok).

Lemma masses_size a : size (masses_of S a) = true_contexts S.
Proof. by rewrite size_map_list -size_length seq_length. Qed.

Lemma masses_number (x : X) (a : A) : number (masses_of S a) x = mass R x a.
Proof.
rewrite /number /PolicyMeaning.number /masses_of (@nth_map_in _ _ 0%N) -?size_length ?seq_length //.
rewrite -list_nth seq_nth; last by apply/ssrnat.ltP.
by rewrite /mass_in /mass; case: (population S) => [masses|]; rewrite ?list_nth ?ratio_one.
Qed.

Lemma total_masses (a : A) : ratio (total (masses_of S a)) = mass_of a.
Proof.
rewrite ratio_total -(sum_number R) masses_size; apply: eq_bigr => x _; exact: masses_number.
Qed.

Lemma positiveP q : reflect (0 < ratio q :> R) (positive_fraction q).
Proof.
case e: (positive_fraction q); constructor; first exact: ratio_gt0.
by apply/negP; rewrite -leNgt; apply: not_positive.
Qed.

Lemma in_populated (a : A) : 0 < mass_of a -> In (nat_of_ord a) (populated S).
Proof.
move=> m0; apply/filter_In; split; first by apply/in_seq; split; [exact: Nat.le_0_l | apply/ssrnat.ltP/ltn_ord].
by apply/positiveP; rewrite total_masses.
Qed.

Lemma populatedP i : In i (populated S) -> exists2 a : A, i = a & 0 < mass_of a.
Proof.
case/filter_In => /in_seq[_ /ssrnat.ltP h] /positiveP m0.
by exists (Ordinal h) => //; rewrite -total_masses.
Qed.

Lemma shares_number (x : X) (a : A) : 0 < mass_of a -> number (shares S a) x = share a x.
Proof.
move=> m0; rewrite /number /PolicyMeaning.number /shares (@nth_map_in _ _ zero) ?masses_size // ratio_times.
rewrite ratio_inverse; last by apply/positiveP; rewrite total_masses.
by rewrite total_masses -[ratio (nth _ _ _)]/(number (masses_of S a) x) masses_number mulrC.
Qed.

Lemma shares_size a : size (shares S a) = true_contexts S.
Proof. by rewrite size_map_list masses_size. Qed.

Lemma share_ge0 a x : 0 <= share a x.
Proof. by rewrite divr_ge0 ?mass_ge0 // sumr_ge0 // => y _; apply: mass_ge0. Qed.

Lemma law_share a : 0 < mass_of a -> law (share a).
Proof. by move=> m0; split=> [x|]; [exact: share_ge0 | rewrite -mulr_suml divff // gt_eqF]. Qed.

Lemma same_vectorP p q i : same_vector p q -> number p i = number q i.
Proof.
rewrite /number /PolicyMeaning.number; elim: p q i => [|x p IH] [|y q] // [|i] /=; case: ifP => // e; first by move=> _; apply: equalP.
exact: IH.
Qed.

Lemma independentP (a a' : A) x : independent S -> 0 < mass_of a -> 0 < mass_of a' -> share a x = share a' x.
Proof.
move=> ind m0 m0'; rewrite -!shares_number //; have inA := in_map (shares S) _ _ (in_populated m0).
have inA' := in_map (shares S) _ _ (in_populated m0'); move: ind inA inA'; rewrite /independent.
case: (List.map _ _) => // p rest /forallb_forall same.
have eq q : In q (p :: rest) -> number p x = number q x by case=> [->|/same/same_vectorP].
by move=> /eq <- /eq <-.
Qed.

Lemma bounded_means (class : (X -> A -> R) -> Prop) b (V : option Q) : no_more (Some b) V ->
  (forall E, class E -> forall a a', 0 < mass_of a -> 0 < mass_of a' -> 0 <= mean E a' /\ mean E a <= ratio b * mean E a') ->
  greatest_at_most true class V.
Proof.
case: V => [v|] //= /(at_mostP R) le all E inE a a' m0 m0' _; have [E0 h] := all E inE a a' m0 m0'.
by apply: le_trans h _; apply: ler_wpmul2r.
Qed.

Lemma means_ge0 (E : X -> A -> R) a : (forall x, 0 <= E x a) -> 0 <= mean E a.
Proof. by move=> E0; apply: sumr_ge0 => x _; rewrite mulr_ge0 ?share_ge0. Qed.

Lemma eq_mean (E E' : X -> A -> R) a : (forall x, E x a = E' x a) -> mean E a = mean E' a.
Proof. by move=> e; apply: eq_bigr => x _; rewrite e. Qed.

Theorem T5_sound V : consistent S -> one_release S -> a_free S -> epsilon S -> independent S -> no_more (epsilon S) V ->
  greatest_at_most true (@of_any_policy R S) V.
Proof.
move=> cons; case e: (epsilon S) => [b|] // one free _ ind le; have [_ pure] := epsilonP R ok e.
apply: bounded_means le _ => E [T [kT eE]] a a' m0 m0'; have E0 x c : 0 <= E x c by rewrite eE; exact: E_ge0 (kernel_MA_all R ok) kT.
split; first exact: means_ge0.
rewrite /mean /group_mean; under eq_bigr => x _ do rewrite (independentP x ind m0 m0').
apply: ratio_of_means => x; first exact: share_ge0.
by rewrite !eE; apply: (T2_pure kX kT g0 (freeP R ok cons free)); apply: pure_all.
Qed.

Lemma compositionP c y (a a' : A) : composition S = Some c -> (y < released_contexts S)%N -> 0 < mass_of a -> 0 < mass_of a' ->
  forall y' : Xt S, y = y' -> after share MX a y' <= ratio c * after share MX a' y'.
Proof.
move=> /(greater_ofP R)[_ all] hy m0 m0' y' yy; have [sm smx] := context_matrix_size R ok.
have rows i : (i < size (context_matrix S))%N -> size (nth [::] (context_matrix S) i) = released_contexts S by rewrite sm => /smx.
have [sc cE] := columnsP rows.
have [|q [qE q_le]] := all (nth [::] (released_shares S) y); first by apply: in_nth; rewrite size_map_list sc.
have value i : (i < size (populated S))%N -> exists2 b : A, nth 0%N (populated S) i = b &
    number (nth [::] (released_shares S) y) i = after share MX b y'.
  move=> hi; have [b eb mb] := populatedP (in_nth 0%N hi); exists b => //.
  rewrite /number /PolicyMeaning.number /released_shares (@nth_map_in _ _ [::]) ?sc // (@nth_map_in _ _ [::]) ?size_map_list //.
  rewrite (@nth_map_in _ _ 0%N) // eb (@expectedP R (true_contexts S)) ?shares_size ?(columns_size rows) //.
  apply: eq_bigr => x _; rewrite shares_number // mulrC; congr (_ * _).
  by have [|_ e] := cE x y _ hy; rewrite ?sm //= /PolicyMeaning.number e yy.
have at_group b : 0 < mass_of b -> exists2 i, (i < size (populated S))%N & number (nth [::] (released_shares S) y) i = after share MX b y'.
  move=> mb; have [i [hi ei]] := In_nth _ _ 0%N (in_populated mb).
  have hi' : (i < size (populated S))%N by apply/ssrnat.ltP.
  exists i => //; have [b' eb' ->] := value i hi'; congr (after _ _ _ _); apply: val_inj; rewrite /= -eb' -ei.
  by rewrite list_nth.
have sv : size (nth [::] (released_shares S) y) = size (populated S).
  by rewrite /released_shares (@nth_map_in _ _ [::]) ?sc // !size_map_list.
have after_ge0 b : 0 <= after share MX b y' by apply: sumr_ge0 => x _; rewrite mulr_ge0 ?share_ge0 //; case: (kX x).
have all0 i : 0 <= number (nth [::] (released_shares S) y) i.
  case: (ltnP i (size (populated S))) => hi; last by rewrite number_out // sv.
  by have [b _ ->] := value i hi.
have [i hi <-] := at_group a m0; have [j hj ej] := at_group a' m0'; rewrite -ej.
rewrite -sv in hi hj; have [_ le] := widestP qE all0 hi hj.
by apply: le_trans le _; rewrite ler_wpmul2r.
Qed.

Theorem T5_decision_sound V : one_release S -> (if utility S is OfDecision _ then true else false) -> epsilon S ->
  no_more (both times (epsilon S) (composition S)) V -> greatest_at_most true (@of_any_policy R S) V.
Proof.
move=> one of_decision; case e: (epsilon S) => [b|] // _; case c: (composition S) => [q|]; last by case: V.
move=> le; have [b1 pure] := epsilonP R ok e; have kM := kernel_MA_all R ok; have pure_M := pure_all one pure.
have [h gE] : exists h, forall u x a, g u x a = h u.
  exists (fun u => g u (Ordinal (some_context ok)) (Ordinal (ltnW (two_groups ok)))) => u x a.
  by rewrite /g /gains; case: (utility S) of_decision.
have h0 u : 0 <= h u by rewrite -(gE u (Ordinal (some_context ok)) (Ordinal (ltnW (two_groups ok)))) g0.
apply: bounded_means le _ => E [T [kT eE]] a a' m0 m0'; have E0 x d : 0 <= E x d by rewrite eE; exact: E_ge0.
split; first exact: means_ge0.
have mE d : mean E d = \sum_y after share MX d y * expect (MA_all R (S := S) d) (fun w => expect (T y w) h).
  rewrite -(group_mean_released share MX (MA_all R (S := S)) T h d); apply: eq_bigr => x _; congr (_ * _).
  by rewrite eE; apply: eq_bigr => u _; rewrite gE.
rewrite !mE ratio_times; apply: ratio_of_sums => y.
have T0 w : 0 <= expect (T y w) h by apply: expect_ge0 => //; apply: kT.
have mean0 d : 0 <= expect (MA_all R (S := S) d) (fun w => expect (T y w) h) by apply: expect_ge0 => //; apply: kM.
have -> : ratio b * ratio q * (after share MX a' y * expect (MA_all R (S := S) a') (fun w => expect (T y w) h))
        = ratio q * after share MX a' y * (ratio b * expect (MA_all R (S := S) a') (fun w => expect (T y w) h)) by ring.
apply: ler_pmul => //; last by apply: ratio_of_weights => // w; apply: pure_M.
  by apply: sumr_ge0 => x _; rewrite mulr_ge0 ?share_ge0 //; case: (kX x).
exact: (compositionP c (ltn_ord y) m0 m0').
Qed.

(* ---- Everything that is accepted by one theorem ---- *)

Theorem bound_accepted_sound s r : consistent S -> bound_accepted S s r -> ~~ exactly s -> policy_holds R S s.
Proof.
move=> cons; rewrite /policy_holds; case: s => means [] // V sc; rewrite /bound_accepted; cbn [Policy.value about of_means exactly].
case: r => [ks||  |ks|ks|  |c|  |raw|  |p|ks ps w|ks] //.
- by case/and3P => /negbTE -> scope h _; exact: (@T1_sound R S ok cons _ _ _ _ scope h).
- by case/and4P => /negbTE -> scope e h _; exact: (@T1_paper_sound R S ok cons _ _ _ scope e h).
- by case: sc => // /and5P[/negbTE -> one free e le] _; exact: (@T2_sound R S ok cons _ one free le e).
- case: sc; try by case/and3P => /negbTE -> scope h _; exact: (@T3_sound R S ok cons _ _ _ _ scope h).
  by case/and3P => /negbTE -> free h _; exact: (@T3_group_sound R S ok cons _ _ free h).
- by case: sc => // /and5P[/negbTE -> one free m0 h] _; exact: (@T4_sound R S ok cons _ _ one free m0 h).
- by case: sc => //; rewrite negbK => /and5P[-> _ one free /and3P[e ind le]] _; exact: (@T5_sound _ cons one free e ind le).
- by case: sc => //; rewrite negbK => /and5P[-> _ one dec /and3P[e _ le]] _; exact: (@T5_decision_sound _ one dec e le).
- by case: sc => // /and4P[/negbTE -> dec _ le] _; exact: (@T8_sound R S ok _ dec le).
- by case: sc => // /and4P[/negbTE -> free _ le] _; exact: (@T12_sound R S ok cons _ free le).
by case/and3P => /negbTE -> scope h _; exact: (@floor_sound R S ok cons _ _ _ scope h).
Qed.
End Means.
