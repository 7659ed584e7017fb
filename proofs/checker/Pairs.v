(* Whether ladders for pairs of cells prove an interval of a ratio.

   This file only computes; PairsSound.v proves: whatever the means are, what it accepts is wrong at most with the probability
   1 - confidence.  It follows docs/certificate-samples.md, region "pairs" without a split.  Cells are in the order of the table, those of
   a block next to each other. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditKernel Require WorstCase.
From FairauditChecker Require Import Chance.
From FairauditChecker Require Figures PairLaw.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

Record by_pairs := By {
  sure_at : Q;                                (* "confidence" *)
  one_by_one : bool;                          (* "ends" is "each" *)
  apart : bool;                               (* "independent": cells were declared independent *)
  pair_levels : Q * Q;                        (* "levels": "upper", "lower" *)
  upper_ladders : option (list (list Q));     (* "upper": knots for each ordered pair of each block in turn *)
  lower_ladder : option ((Z * Z) * list Q);   (* "lower": the higher and the lower cell, counted from 0 over all cells, and knots *)
  lowest : Q;                                 (* R_lo *)
  highest : option Q                          (* R_hi; none: infinite *)
}.

(* ---- Pairs that are compared ---- *)

Section Ordered.
Variables (A : Type) (block_of index : A -> Z).

Definition partners (ys : list A) : list (A * A) :=
  flat_map (fun x => map (fun y => (x, y)) (filter (fun y => negb (index x =? index y)) ys)) ys.

(* The ordered pairs of different members of each block in turn *)
Definition ordered (xs : list A) : list (A * A) := flat_map (fun run => partners run.2) (Figures.runs block_of xs).

(* No block comes twice. *)
Definition in_blocks (xs : list A) : bool := strictly_rising (map fst (Figures.runs block_of xs)).
End Ordered.

Definition blocks_of (ss : list sample) : list (Z * Z) := WorstCase.numbered 0 (map block ss).
Definition how_many_pairs (ss : list sample) : Z := Z.of_nat (length (ordered snd fst (blocks_of ss))).

(* A cell with its number and its score ends *)
Record scored_cell := Scored { its_number : Z; its_sample : sample; its_ends : list (Z * Z) }.

Definition scored_cells (z2 : Q) (ss : list sample) : list scored_cell :=
  map (fun ns : Z * sample => Scored ns.1 ns.2 (PairLaw.scores (draws ns.2) z2)) (WorstCase.numbered 0 ss).

Definition block_of (x : scored_cell) : Z := block (its_sample x).

(* The knots prove that the mean of one cell is less than r times that of the other. *)
Definition is_below (r level : Q) (xy : scored_cell * scored_cell) (knots : list Q) : bool :=
  let (x, y) := xy in
  let cell_of z := PairLaw.Cell (draws (its_sample z)) (successes (its_sample z)) (its_ends z) in
  PairLaw.ladder_accepted (cell_of x) (cell_of y) (times r (times (worth (its_sample y)) (inverse (worth (its_sample x))))) level knots.

Fixpoint all_below {A} (f : A -> list Q -> bool) (xs : list A) (ladders : list (list Q)) : bool :=
  match xs, ladders with x :: xs, l :: ladders => f x l && all_below f xs ladders | [], [] => true | _, _ => false end.

(* ---- The interval ---- *)

Definition same_number (q r : Q) : bool := at_most q r && at_most r q.

(* The error of an end, that of each pair for the lower end, and what orders the outcomes for each of them *)
Definition error (i : by_pairs) : Q := rest_of (sure_at i).
Definition share (i : by_pairs) : Q := if one_by_one i then error i else times (error i) (Qmake 1 2).
Definition part_of_pair (M : Z) (q : Q) : Q := times q (inverse (number M)).

Definition upper_proved (i : by_pairs) (ss : list sample) : bool :=
  match highest i, upper_ladders i with
  | None, None => true
  | Some r, Some ladders =>
      let xs := scored_cells (PairLaw.order_scale (error i)) ss in
      [&& at_most one r, in_blocks block_of xs & all_below (is_below r (share i)) (ordered block_of its_number xs) ladders]
  | _, _ => false
  end.

Definition lower_proved (i : by_pairs) (M : Z) (ss : list sample) : bool :=
  match lower_ladder i with
  | None => same_number (lowest i) one
  | Some ((x, y), knots) =>
      let cells := WorstCase.numbered 0 ss in
      let z2 := PairLaw.order_scale (part_of_pair M (error i)) in
      let scored c := Scored (fst c) (snd c) (PairLaw.scores (draws (snd c)) z2) in
      match cell_at cells x, cell_at cells y with
      | Some c, Some d =>
          [&& negb (x =? y), block c.2 =? block d.2, negb (at_most (lowest i) one)
            & is_below (inverse (lowest i)) (part_of_pair M (share i)) (scored d, scored c) knots]
      | _, _ => false
      end
  end.

Definition pairs_accepted (i : by_pairs) (ss : list sample) : bool :=
  let M := how_many_pairs ss in
  [&& apart i, forallb (fun s => positive_fraction (worth s)) ss, in_blocks snd (blocks_of ss), 0 <? M,
      same_number (pair_levels i).1 (share i), same_number (pair_levels i).2 (part_of_pair M (share i)), at_most one (lowest i),
      upper_proved i ss & lower_proved i M ss].
