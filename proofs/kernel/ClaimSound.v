(* What is extracted is claim_true of WorstCase.v: this file says what a claim by lp-dual means and proves that
   claim_true accepts no other. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From FairauditKernel Require Import Fractions FractionsSound LinearProgram WorstCase WorstCaseSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Claim.
Variables (R : realFieldType) (K : utilities) (T : table).
Local Notation ratio := (@ratio R).
Local Notation expectation := (@expectation R).
Local Notation group_mean := (@group_mean R T).

(* ==== What a claim means (this part has to be read) ==== *)

(* E(x,a) and the mean of E(.,a) of the utility that the table states *)
Definition stated_at (c : cell) : R :=
  (\sum_(o <- outcomes c) ratio (weight o) * ratio (stated o)) / \sum_(o <- outcomes c) ratio (weight o).

Definition mean_stated (a : Z) : R :=
  (\sum_(c <- of_that_group T a) mass_at R T c * stated_at c) / \sum_(c <- of_that_group T a) mass_at R T c.

Definition cells_in (x : Z) : list cell := List.filter (fun c => Z.eqb (context c) x) (cells T).

(* In each context: the ratio of the stated utility is at most v, and so is that of every utility of the class. *)
Definition local_at_most (v : Q) : Prop :=
  forall x, In x (contexts T) -> forall c d, In c (cells_in x) -> In d (cells_in x) ->
  stated_at c <= ratio v * stated_at d /\
  (group c <> group d -> forall g, in_class K T g -> local_floor K T g c d -> expectation g c <= ratio v * expectation g d).

(* The same for the means of groups. *)
Definition global_at_most (v : Q) : Prop :=
  forall a b, In a (everywhere T) -> In b (everywhere T) ->
  mean_stated a <= ratio v * mean_stated b /\
  (a <> b -> forall g, in_class K T g -> global_floor K T g a b -> group_mean g a <= ratio v * group_mean g b).

(* A value that is infinite (None) bounds nothing. *)
Definition claim_says (about_local : bool) (v : option Q) : Prop :=
  match v with
  | None => True
  | Some v => if about_local then local_at_most v else global_at_most v
  end.

(* Somebody is compared: two cells of a context, or the means of two groups. *)
Definition somebody_compared (about_local : bool) : Prop :=
  if about_local then exists2 x, In x (contexts T) & (2 <= length (cells_in x))%N else (2 <= length (everywhere T))%N.

(* ==== Proofs ==== *)

Hypothesis ok : valid K T.

Lemma stated_expectationP c : In c (cells T) -> ratio (stated_expectation c) = stated_at c.
Proof.
move=> cT; rewrite ratio_times ratio_inverse ?(weight_sum_gt0 ok) // ratio_weight_sum mulrC; congr (_ / _).
by rewrite ratio_total big_map; apply: eq_bigr => o _; rewrite ratio_times.
Qed.

Lemma stated_meanP a : populated T a -> ratio (stated_mean T a) = mean_stated a.
Proof.
move=> pop; rewrite ratio_times ratio_inverse // ratio_mass_of_group mulrC; congr (_ / _).
rewrite ratio_total big_map; apply: eq_sum_in => c /of_that_groupP cT.
by rewrite ratio_times ratio_mass stated_expectationP.
Qed.

Lemma everywhere_populated a : In a (everywhere T) -> populated T a.
Proof. by rewrite /everywhere; case: (population T); case: (complete T) => // /filter_In[]. Qed.

Lemma cells_in_cells x c : In c (cells_in x) -> In c (cells T) /\ context c = x.
Proof. by case/filter_In => cT /Z.eqb_eq. Qed.

Lemma within v : attained_within K T v ->
  forall qs, In qs (stated_values K T) -> forall p q, In p qs -> In q qs -> ratio p <= ratio v * ratio q.
Proof.
move=> /forallb_forall all_in qs inqs p q inp inq.
have /forallb_forall/(_ _ inp)/forallb_forall/(_ _ inq) := all_in _ inqs.
by move/(at_mostP R); rewrite ratio_times.
Qed.

End Claim.

Lemma comparesP K T : compares K T -> somebody_compared T (local K).
Proof.
rewrite /compares /stated_values /somebody_compared; case: (local K) => /existsb_exists[qs [inqs two]].
  move: inqs => /in_map_iff[x [e xT]]; exists x => //; move: two; rewrite -e /cells_in.
  by case: (List.filter _ _) => [|c [|d cs]].
by case: inqs two => [<-|[]]; case: (everywhere T) => [|a [|b cs]].
Qed.

(* What claim_true accepts is so, whether the claim is about the local ratio or the global one, finite or not. *)
Theorem claim_true_sound (R : realFieldType) (K : utilities) (T : table) about_local v es :
  claim_true K T about_local v es ->
  [/\ about_local = local K, somebody_compared T about_local & claim_says R K T about_local v].
Proof.
case/and3P => /Bool.eqb_prop -> /comparesP some bound; split=> //.
case: v bound => [v|] // /andP[att bnd]; have /and4P[ok _ _ _] := bnd.
rewrite /claim_says; case: ifP => loc.
  move=> x xT c d cx dx; have [cT xc] := cells_in_cells cx; have [dT xd] := cells_in_cells dx; split.
    rewrite -!(stated_expectationP R ok) //; have := within R att; rewrite /stated_values loc; apply.
    - by apply: in_map xT.
    - by apply: in_map.
    - by apply: in_map.
  move=> cd g gK fl; apply: (worst_case_local bnd loc gK) => //; first by rewrite xc.
  by rewrite xc xd.
move=> a b aT bT; split.
  rewrite -!(stated_meanP R ok); try exact: everywhere_populated.
  by have := within R att; rewrite /stated_values loc; apply; [left|apply: in_map|apply: in_map].
by move=> ab g gK fl; apply: (worst_case_global bnd) => //; rewrite loc.
Qed.
