(* What a certificate says of the log before it was counted cannot be altered under one header of a table.

   Certificate.v compares it with a digest in the header.  Here is proved what that is good for. *)

From Coq Require Import List Ascii String.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditChecker Require Import Json JsonSound Reading Canonical CanonicalValues Document Certificate.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.

(* ==== What is said (this part has to be read) ==== *)

(* None of the statements has a part that is false by the document alone. *)
Definition never_false (its : list item) : Prop := forall i, In i its -> ~ In (Fact false) (parts i).

(* The digests of two values tell them apart. *)
Definition told_apart (sha256 : text -> text) (v w : json) : Prop :=
  sha256 (table_text [v]) = sha256 (table_text [w]) -> table_text [v] = table_text [w].

(* ==== Proofs ==== *)

(* Two subjects say the same under one header, up to the order of members, if neither is found to be false: nothing is deleted, added or altered. *)
Theorem named_once sha256 header subject subject' k its its' :
  named_by_table sha256 header subject k = Good its -> named_by_table sha256 header subject' k = Good its' ->
  never_false its -> never_false its' ->
  (forall v w, found k subject = Some v -> found k subject' = Some w -> [/\ proper v, proper w & told_apart sha256 v w]) ->
  option_map by_keys (found k subject) = option_map by_keys (found k subject').
Proof.
rewrite /named_by_table.
case: (found k subject) => [v|]; case: (found k subject') => [w|] //=; case: (digest_in header k) => [d|] //=.
- move=> [<-] [<-] not_v not_w both; have [pv pw apart] := both v w erefl erefl.
  have [/sameP dv|differs] := boolP (same d (sha256 (table_text [v]))); last first.
    by case: (not_v _ (or_introl erefl)); left; rewrite (negbTE differs).
  have [/sameP dw|differs] := boolP (same d (sha256 (table_text [w]))); last first.
    by case: (not_w _ (or_introl erefl)); left; rewrite (negbTE differs).
  have one : table_text [v] = table_text [w] by apply: apart; rewrite -dv -dw.
  have : map by_keys [v] = map by_keys [w] by apply: table_text_one one => u [<-|[]].
  by case=> ->.
- by move=> [<-] [<-] _ not_w; case: (not_w _ (or_introl erefl)); left.
- by move=> [<-] [<-] not_v; case: (not_v _ (or_introl erefl)); left.
Qed.

Example named_once_applies : option_map by_keys (Some out_of_order) = option_map by_keys (Some (by_keys out_of_order)).
Proof.
have named v : table_text [v] = table_text [out_of_order] ->
    named_by_table id [([], Text (table_text [out_of_order]))] [([], v)] [] = Good [Item (of_string "subject.") [Fact true; Uncovered]].
  by rewrite /named_by_table /= => ->; vm_compute.
apply: (@named_once id _ [([], out_of_order)] [([], by_keys out_of_order)] [] _ _ (named _ _) (named _ _)) => //.
- by move=> i [<-|[]] [|[]].
- by move=> i [<-|[]] [|[]].
- by move=> v w [<-] [<-]; split; [exact: proper_out_of_order | exact: proper_in_order | rewrite /told_apart].
Qed.
