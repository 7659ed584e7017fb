(* A decision table as a certificate states it, and what the format demands of one.

   This file only computes.  What a table means stands in Meaning.v.  Contexts, groups and
   decisions are numbers, counted from 0 in the order of the header. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* One row, of a context x and a group a. *)
Record cell := Cell {
  context : Z;
  group : Z;
  weights : list Q;         (* of each decision: counts, or probabilities *)
  gains : list (option Q);  (* g of each decision, where it was given; not read where g(u) is stated for the whole table *)
  mass : Q;                 (* P(x,a), where masses are given; else not read *)
  by_truth : list (list Q)  (* for each true label, the counts of the decisions; not read where true labels are unknown *)
}.

(* M(x,a) is the sum of the counts, or is given, or is 1. *)
Inductive masses := Counted | Given | Alike.

(* What counts as positive where true labels are known, and whether there are columns of contexts, over which rates can be pooled. *)
Record truth := Truth { positive_decisions : list Z; positive_label : Z; labels : Z (* how many *); pooled : bool }.

Record table := Table {
  contexts : Z;                 (* how many *)
  groups : Z;
  decisions : Z;
  population : masses;
  utility : option (list Q);    (* g(u), where it depends on the decision alone *)
  known : option truth;
  cells : list cell             (* by context and then by group *)
}.

Definition range (n : Z) : list Z := map Z.of_nat (seq 0 (Z.to_nat n)).

(* All utilities that are given, those of decisions that were never made included. *)
Definition given (T : table) : list Q :=
  match utility T with
  | Some gs => gs
  | None => flat_map (fun c => flat_map (fun g => match g with Some g => [g] | None => [] end) (gains c)) (cells T)
  end.

(* Of utilities below 0 there are no ratios. *)
Definition signed (T : table) : bool := existsb (fun g => Qnum g <? 0) (given T).

(* ---- What the format demands: a table that is not so is malformed ---- *)

Definition of_length {A} (n : Z) (xs : list A) : bool := Z.of_nat (length xs) =? n.
Definition inside (n i : Z) : bool := (0 <=? i) && (i <? n).
Definition is_one (q : Q) : bool := (Qnum q =? Zpos (Qden q)).

Definition gained (w : Q) (g : option Q) : bool := match g with Some _ => true | None => Qnum w =? 0 end.

Definition valid_gains (T : table) (c : cell) : bool :=
  match utility T with
  | Some _ => true
  | None => of_length (decisions T) (gains c) && forallb (fun wg => gained wg.1 wg.2) (combine (weights c) (gains c))
  end.

(* The sums of the rows, entry by entry *)
Definition added_up (n : Z) (rows : list (list Q)) : list Q :=
  fold_left (fun sums row => map (fun sr => plus sr.1 sr.2) (combine sums row)) rows (map (fun=> zero) (range n)).

Definition valid_truth (T : table) (c : cell) : bool :=
  match known T with
  | None => true
  | Some K =>
      [&& of_length (labels K) (by_truth c), forallb (of_length (decisions T)) (by_truth c),
          forallb (forallb nonnegative) (by_truth c)
        & forallb (fun sw => equal sw.1 (reduced sw.2)) (combine (added_up (decisions T) (by_truth c)) (weights c))]
  end.

Definition valid_cell (T : table) (c : cell) : bool :=
  [&& inside (contexts T) (context c), inside (groups T) (group c),
      of_length (decisions T) (weights c), forallb nonnegative (weights c),
      match population T with Counted => positive_fraction (total (weights c)) | _ => is_one (total (weights c)) end,
      match population T with Given => nonnegative (mass c) | _ => true end,
      valid_gains T c & valid_truth T c].

Definition comes_before (c d : cell) : bool :=
  (context c <? context d) || ((context c =? context d) && (group c <? group d)).

Fixpoint in_order (cs : list cell) : bool :=
  match cs with
  | c :: (d :: _) as rest => comes_before c d && in_order rest
  | _ => true
  end.

Fixpoint increasing (us : list Z) : bool :=
  match us with
  | u :: (v :: _) as rest => (u <? v) && increasing rest
  | _ => true
  end.

Definition valid (T : table) : bool :=
  [&& 0 <? contexts T, 0 <? groups T, 0 <? decisions T,
      match utility T with Some gs => of_length (decisions T) gs | None => match cells T with [] => false | _ => true end end,
      match population T with Given => is_one (total (map mass (cells T))) | _ => true end,
      match known T with
      | Some K => [&& match population T with Counted => true | _ => false end, inside (labels K) (positive_label K),
                      forallb (inside (decisions T)) (positive_decisions K) & increasing (positive_decisions K)]
      | None => true
      end,
      forallb (valid_cell T) (cells T) & in_order (cells T)].
