(* What policy and filters of a certificate are, if it is well formed; and that the table which Policy.v computes is that of the law
   which they induce. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Valid.
Variables (R : realFieldType) (S : behind).
Hypothesis ok : valid S.
Local Notation number := (@number R).
Local Notation entry := (@entry R).
Local Notation MX := (@MX R S).
Local Notation MA := (@MA R S).
Local Notation T0 := (@T0 R S).
Local Notation g := (@g R S).

Lemma shapedP (T : Type) n k (rows : seq (seq T)) : shaped n k rows ->
  size rows = n /\ forall i, (i < n)%N -> size (nth [::] rows i) = k.
Proof.
case/andP => /longP <- all_k; split=> // i h; apply: longP.
exact: (@forallb_nth _ [::] _ _ i all_k h).
Qed.

Lemma group_filter_ok : lawful_filter R (group_filter S).
Proof. by move: ok; rewrite /valid => /andP[/valid_filterP]. Qed.

Lemma context_filter_ok : if context_filter S is Filtered fs then lawful_filter R fs else True.
Proof. by move: ok => /andP[_ /andP[]]; case: (context_filter S) => // fs /valid_filterP. Qed.

Lemma two_groups : (1 < true_groups S)%N.
Proof. by move: ok => /and3P[_ _ /andP[/Nat.leb_le/ssrnat.leP]]. Qed.

Lemma some_context : (0 < true_contexts S)%N.
Proof.
move: ok => /and3P[_ + _]; rewrite /true_contexts; case: (context_filter S) => [fs|[|n]] //.
case/andP => _; rewrite /inputs_of; elim: fs => //= F fs IH /andP[/and3P[_ some _] /IH more].
by rewrite -[Nat.mul _ _]/(muln _ _) muln_gt0 more andbT; case: F some.
Qed.

Lemma some_decision : (0 < decisions S)%N.
Proof. by move: ok => /and4P[_ _ _ /andP[]]; case: (decisions S). Qed.

Lemma laws_shaped : size (policy_laws S) = released_contexts S /\
  forall y, (y < released_contexts S)%N -> size (nth [::] (policy_laws S) y) = released_groups S.
Proof. by move: ok => /and5P[_ _ _ _ /andP[/shapedP]]. Qed.

Lemma laws_lawful y b : (y < released_contexts S)%N -> (b < released_groups S)%N ->
  lawful R (decisions S) (nth [::] (nth [::] (policy_laws S) y) b).
Proof.
move=> hy hb; have [sy sb] := laws_shaped.
move: ok => /and5P[_ _ _ _ /and4P[_ all_laws _ _]]; apply: is_lawP.
apply: (@forallb_nth _ [::] (is_law (decisions S))); last by rewrite sb.
by apply: (@forallb_nth _ [::] _ _ y all_laws); rewrite sy.
Qed.

Lemma gains_ok x a : (x < true_contexts S)%N -> (a < true_groups S)%N -> size (gains S x a) = decisions S /\ forall u, 0 <= number (gains S x a) u.
Proof.
move=> hx ha; move: ok => /and5P[_ _ _ _ /and4P[_ _ + _]]; rewrite /valid_worth /gains.
case: (utility S) => [v /andP[/longP s v0]|gs /andP[/shapedP[sx sa] all_gs]].
  by split=> // u; apply: number_ge0.
rewrite !list_nth.
have : long (decisions S) (nth [::] (nth [::] gs x) a) && forallb nonnegative (nth [::] (nth [::] gs x) a).
  apply: (@forallb_nth _ [::] (fun v => long (decisions S) v && forallb nonnegative v)); last by rewrite sa.
  by apply: (@forallb_nth _ [::] _ _ x all_gs); rewrite sx.
by case/andP => /longP s v0; split=> // u; apply: number_ge0.
Qed.

Lemma kernel_of_rows n m (M : seq (seq Q)) : (forall i, (i < n)%N -> lawful R m (nth [::] M i)) ->
  kernel (fun (i : 'I_n) (j : 'I_m) => entry M i j).
Proof. by move=> rows i; have [_ r0 r1] := rows i (ltn_ord i); split=> [j|]; [exact: r0|exact: r1]. Qed.

Lemma kernel_MA : kernel MA.
Proof. by apply: kernel_of_rows => i; apply/lawful_product/group_filter_ok. Qed.

Lemma kernel_MX : kernel MX.
Proof.
rewrite /PolicyMeaning.MX /context_matrix; move: context_filter_ok.
rewrite /X /Xt /true_contexts /released_contexts; case: (context_filter S) => [fs ok_fs|n _].
  by apply: kernel_of_rows => i; apply: lawful_product.
move=> i; have [p0 p1] := @kernel_identity R [finType of 'I_n] i.
by split=> [j|]; [rewrite identity_entry // ler0n | rewrite -[RHS]p1; apply: eq_bigr => j _; rewrite identity_entry].
Qed.

Lemma policy_T0 : policy T0.
Proof.
move=> y b; have [_ p0 p1] := laws_lawful (ltn_ord y) (ltn_ord b).
by split=> [u|]; [exact: p0|exact: p1].
Qed.

Lemma g_ge0 u x a : 0 <= g u x a.
Proof. by have [_] := gains_ok (ltn_ord x) (ltn_ord a); apply. Qed.

Definition u0 : U S := Ordinal some_decision.

Lemma mass_ge0 x a : 0 <= mass R (S := S) x a.
Proof.
rewrite /mass; move: ok => /and5P[_ _ _ _ /and4P[_ _ _ ]].
case: (population S) => [masses|_]; last exact: ler01.
case/andP => /shapedP[sx sa] /and3P[_ /forallb_forall m0 _]; apply/ratio_ge0/m0/in_concat.
exists (nth [::] masses x); split; apply: in_nth; rewrite ?sx ?sa //.
Qed.

(* ---- The induced law ---- *)

Definition scale : R :=
  embed (common (concat (concat (policy_laws S)))) * embed (units (group_filter S)) *
  (if context_filter S is Filtered fs then embed (units fs) else 1).

Lemma scale_gt0 : 0 < scale.
Proof.
rewrite /scale !mulr_gt0 ?units_gt0 //; first by apply/embed_gt0/Z.ltb_lt/common_gt0.
by case: (context_filter S) => [fs|_]; rewrite ?units_gt0 ?ltr01.
Qed.

Let d := common (concat (concat (policy_laws S))).
Let over_row row := List.map (over d) (concat row).

Lemma over_row_size y : (y < released_contexts S)%N -> size (over_row (nth [::] (policy_laws S) y)) = (released_groups S * decisions S)%N.
Proof.
move=> hy; have [_ sb] := laws_shaped; rewrite size_map_list (@size_concat _ _ (decisions S)) ?sb // => b hb.
by have [s _ _] := laws_lawful hy hb.
Qed.

Lemma over_rowE y b u : (y < released_contexts S)%N -> (b < released_groups S)%N -> (u < decisions S)%N ->
  integer R (over_row (nth [::] (policy_laws S) y)) (b * decisions S + u) =
  embed d * number (nth [::] (nth [::] (policy_laws S) y) b) u.
Proof.
move=> hy hb hu; have [sy sb] := laws_shaped.
have rows i : (i < size (nth [::] (policy_laws S) y))%N -> size (nth [::] (nth [::] (policy_laws S) y) i) = decisions S.
  by rewrite sb // => hi; have [s _ _] := laws_lawful hy hi.
rewrite over_numbers => [|q].
  by rewrite /PolicyMeaning.number (@nth_concat _ zero _ (decisions S)) // sb.
case/in_concat => law [in_row in_law]; apply/common_divide/in_concat; exists law; split=> //.
apply/in_concat; exists (nth [::] (policy_laws S) y); split=> //.
by apply: in_nth; rewrite sy.
Qed.

Let row_of y := mixed (decisions S) (group_filter S) (over_row (nth [::] (policy_laws S) y)).
Let n := (true_groups S * decisions S)%N.

Lemma row_of_size y : (y < released_contexts S)%N -> size (row_of y) = n.
Proof. by move=> hy; apply: (@mixed_size R); [apply: group_filter_ok | apply: over_row_size]. Qed.

Let by_released := List.map (fun row => mixed (decisions S) (group_filter S) (over_row row)) (policy_laws S).

Lemma by_releasedE y : (y < released_contexts S)%N -> nth [::] by_released y = row_of y.
Proof. by move=> hy; rewrite (@nth_map_in _ _ [::]) // (proj1 laws_shaped). Qed.

Lemma by_released_size : size by_released = released_contexts S.
Proof. by rewrite size_map_list (proj1 laws_shaped). Qed.

Lemma concat_size : size (concat by_released) = (released_contexts S * n)%N.
Proof.
rewrite (@size_concat _ _ n) by_released_size // => y hy.
by rewrite by_releasedE // row_of_size.
Qed.

Lemma weights_size x a : (x < true_contexts S)%N -> (a < true_groups S)%N ->
  size (nth [::] (nth [::] (induced_weights S) x) a) = decisions S.
Proof.
move=> hx ha; rewrite /induced_weights (@nth_map_in _ _ [::]) ?size_pieces // size_piece // size_piece //.
move: hx context_filter_ok concat_size; rewrite -/d -/n /true_contexts /released_contexts /by_released /over_row.
case: (context_filter S) => // fs _ ok_fs sall.
by rewrite (@mixed_size R).
Qed.

Theorem induced_weightsP (x : X S) (a : A S) (u : U S) :
  integer R (nth [::] (nth [::] (induced_weights S) x) a) u = scale * induced MX MA T0 x a u.
Proof.
have hx := ltn_ord x; have ha := ltn_ord a; have hu := ltn_ord u.
have srow y : (y < size by_released)%N -> size (nth [::] by_released y) = n.
  by rewrite by_released_size => hy; rewrite by_releasedE // row_of_size.
have sall := concat_size.
have at_y y : (y < released_contexts S)%N -> integer R (concat by_released) (y * n + (a * decisions S + u)) =
    embed d * embed (units (group_filter S)) * \sum_b MA a b * entry (nth [::] (policy_laws S) y) b u.
  have place : (a * decisions S + u < n)%N := ltn_place ha hu.
  move=> hy; rewrite /integer (@nth_concat _ Z0 _ n _ _ srow) ?by_released_size // by_releasedE //.
  rewrite -[LHS]/(integer R _ _) (mixedP _ _ ha hu); [|exact: group_filter_ok|exact: over_row_size].
  rewrite [embed d * _]mulrC -mulrA [in RHS]mulr_sumr; congr (_ * _); apply: eq_bigr => b _.
  by rewrite over_rowE ?ltn_ord // mulrCA.
rewrite /induced_weights /integer (@nth_map_in _ _ [::]) ?size_pieces // (@nth_pieces _ Z0) ?size_pieces // (@nth_pieces _ Z0) ?ltn_place //.
rewrite -/d -/by_released -[LHS]/(integer R _ _) /induced.
under [in RHS]eq_bigr => y _ do under eq_bigr => b _ do rewrite -mulrA.
under [in RHS]eq_bigr => y _ do rewrite -mulr_sumr.
move: hx context_filter_ok sall at_y {srow}; rewrite /scale -/d /PolicyMeaning.MX /context_matrix.
move: x; rewrite /X /Xt /T0 /true_contexts /released_contexts; case: (context_filter S) => [fs|k] x hx ok_fs sall at_y.
  rewrite mixedP ?ltn_place // [embed d * _ * _]mulrC -mulrA; congr (_ * _).
  by rewrite mulr_sumr; apply: eq_bigr => y _; rewrite at_y // mulrCA.
rewrite mulr1 at_y //; congr (_ * _); rewrite (bigD1 x) //= identity_entry // eqxx mul1r [X in _ + X]big1 ?addr0 // => y /negbTE yx.
by rewrite identity_entry // eq_sym [_ == _]yx mul0r.
Qed.
End Valid.
