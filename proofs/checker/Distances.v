(* Total variation distances: the greatest one of a table, with the first pair that has it.

   This file only computes; DistancesSound.v proves it right.  All pairs are looked at, but
   most of them by rounded numbers alone, which show that they are not farther apart. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Table Statements Figures.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

Definition scale : Z := 268435456. (* 2^28 *)

Definition rounded (q : Q) : Z := Z.div (Qnum q * scale) (Zpos (Qden q)).

(* A group, its law, and that law in rounded numbers *)
Record side := Side { group_of : Z; exact_law : list Q; rough_law : list Z }.

Definition side_of (r : row) : side := Side (who r) (law_of r) (map rounded (law_of r)).

Fixpoint distance_of (p q : list Q) : Q :=
  match p, q with
  | a :: p, b :: q => if at_most a b then distance_of p q else plus (plus a (minus b)) (distance_of p q)
  | _, _ => zero
  end.

(* No less than the distance, times the scale *)
Fixpoint rough_distance (p q : list Z) : Z :=
  match p, q with
  | a :: p, b :: q => (if a <? b then 0 else a - b + 1) + rough_distance p q
  | _, _ => 0
  end.

Record farthest := Farthest { apart : Q; in_ : Z; one : side; other : side }.

Definition surely_not_farther (best : farthest) (s t : side) : bool :=
  rough_distance (rough_law s) (rough_law t) * Zpos (Qden (apart best)) <=? Qnum (apart best) * scale.

Definition farther (x : Z) (s t : side) (best : option farthest) : option farthest :=
  let next := Farthest (distance_of (exact_law s) (exact_law t)) x s t in
  match best with
  | None => Some next
  | Some b => if at_most (apart next) (apart b) then best else Some next
  end.

Definition compare_two (x : Z) (s : side) (best : option farthest) (t : side) : option farthest :=
  match best with
  | Some b => if surely_not_farther b s t then best else farther x s t best
  | None => farther x s t None
  end.

Fixpoint compare_all (x : Z) (ss : list side) (best : option farthest) : option farthest :=
  match ss with
  | s :: rest => compare_all x rest (fold_left (compare_two x s) rest best)
  | [] => best
  end.

Definition farthest_of (blocks : list (Z * list side)) : option farthest :=
  fold_left (fun best b => compare_all b.1 b.2 best) blocks None.

Fixpoint raised_from (u : Z) (p q : list Q) : list Z :=
  match p, q with
  | a :: p, b :: q => if at_most a b then raised_from (u + 1) p q else u :: raised_from (u + 1) p q
  | _, _ => []
  end.

Definition distance_figure (f : farthest) : figure :=
  Figure (Some (apart f)) (Place nothing (in_ f) nothing (group_of (one f)) (group_of (other f))) None
    (raised_from 0 (exact_law (one f)) (exact_law (other f))).
