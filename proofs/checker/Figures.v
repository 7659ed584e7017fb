(* The figures of a table: what is computed, once for each context and each group.

   This file only computes; FiguresSound.v proves it right.  Where groups are compared, the
   greatest and the least number decide, so that not all pairs have to be looked at. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool path.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Table Statements.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* ---- Sums, in which long denominators meet late ---- *)

Fixpoint sums_of_two (qs : list Q) : list Q :=
  match qs with
  | q :: r :: rest => plus q r :: sums_of_two rest
  | _ => qs
  end.

Fixpoint halved (n : nat) (qs : list Q) : list Q :=
  match n, qs with
  | S n, _ :: _ :: _ => halved n (sums_of_two qs)
  | _, _ => qs
  end.

Definition sum (qs : list Q) : Q := total (halved 40 qs).

(* ---- Rows that follow one another and have the same key ---- *)

Section Runs.
Variables (A : Type) (key : A -> Z).

Fixpoint runs (xs : list A) : list (Z * list A) :=
  match xs with
  | x :: rest =>
      match runs rest with
      | (k, ys) :: more => if k =? key x then (k, x :: ys) :: more else (key x, [x]) :: (k, ys) :: more
      | [] => [(key x, [x])]
      end
  | [] => []
  end.

Definition not_after (x y : A) : bool := key x <=? key y.
Definition grouped (xs : list A) : list (Z * list A) := runs (sort not_after xs).
End Runs.

(* ---- What is computed of each cell, and of each group ---- *)

(* A group, P(.|x,a) or P(.|a), E(x,a) or the mean of E(.,a), and the mass *)
Record row := Row { who : Z; law_of : list Q; mean : Q; bulk : Q }.

Definition gains_of (T : table) (c : cell) : list Q :=
  match utility T with
  | Some gs => gs
  | None => map (fun g => match g with Some g => g | None => zero end) (gains c)
  end.

Definition row_of (T : table) (c : cell) : row :=
  let W := total (weights c) in
  let law := map (times (inverse W)) (weights c) in
  Row (group c) law (total (map (fun pg => times pg.1 pg.2) (combine law (gains_of T c))))
    (match population T with Counted => W | Given => mass c | Alike => one end).

(* The sums of the entries of lists that are equally long *)
Fixpoint column_sums (n : nat) (rows : list (list Q)) : list Q :=
  match n with
  | S n => sum (map (hd zero) rows) :: column_sums n (map (@tl Q) rows)
  | O => []
  end.

Definition row_of_group (n : nat) (a : Z) (rows : list row) : row :=
  let M := sum (map bulk rows) in
  let m := inverse M in
  Row a
    (map (times m) (column_sums n (map (fun r => map (times (bulk r)) (law_of r)) rows)))
    (times m (sum (map (fun r => times (bulk r) (mean r)) rows)))
    M.

Definition rows_of (T : table) : list (Z * list row) := map (fun xcs => (xcs.1, map (row_of T) xcs.2)) (runs context (cells T)).

(* those without mass included *)
Definition group_rows (T : table) (by_context : list (Z * list row)) : list row :=
  map (fun ars => row_of_group (Z.to_nat (decisions T)) ars.1 ars.2) (grouped who (flat_map snd by_context)).

Definition full (T : table) : bool := Z.of_nat (length (cells T)) =? contexts T * groups T.
Definition with_means (T : table) : bool := match population T with Alike => full T | _ => true end.

(* ---- Rates: of each cell and of each group over all contexts, how many draws and how many of them are positive ---- *)

Definition numbered {A} (xs : list A) : list (Z * A) := combine (map Z.of_nat (seq 0 (length xs))) xs.

(* The entries at increasing places, in reverse; the first of the row is at i. *)
Fixpoint picked_onto (done : list Q) (i : Z) (us : list Z) (row : list Q) : list Q :=
  match us, row with
  | u :: more, q :: rest => if u =? i then picked_onto (q :: done) (i + 1) more rest else picked_onto done (i + 1) us rest
  | _, _ => done
  end.

Definition counted (K : truth) (r : Z) (c : cell) : Z * (Q * Q) :=
  let rows := map snd (filter (fun t => Bool.eqb (t.1 =? positive_label K) (r =? true_positives)) (numbered (by_truth c))) in
  (group c, (total (map total rows), total (map (fun row => total (picked_onto [] 0 (positive_decisions K) row)) rows))).

(* by context, or all of a group together *)
Definition counted_in (T : table) (K : truth) (r : Z) : list (Z * list (Z * (Q * Q))) :=
  map (fun xcs => (xcs.1, map (counted K r) xcs.2)) (runs context (cells T)).

Definition added (a : Z) (counts : list (Q * Q)) : Z * (Q * Q) := (a, (sum (map fst counts), sum (map snd counts))).

Definition counted_over_all (T : table) (K : truth) (r : Z) : list (Z * list (Z * (Q * Q))) :=
  [(nothing, map (fun ats => added ats.1 (map snd ats.2)) (grouped fst (map (counted K r) (cells T))))].

Definition counts (T : table) (K : truth) (r : Z) (overall : bool) : list (Z * list (Z * (Q * Q))) :=
  if overall then counted_over_all T K r else counted_in T K r.

Definition rate_of (t : Z * (Q * Q)) : Z * Q := (t.1, times t.2.2 (inverse t.2.1)).
Definition drawn (t : Z * (Q * Q)) : bool := positive_fraction t.2.1.

(* ---- Where groups are compared: a rate, a context, a decision; and the number of each group ---- *)

Record block := Block { at_ : Z * Z * Z; entries : list (Z * Q) }.

Definition of_means (x : Z) (rows : list row) : block := Block (nothing, x, nothing) (map (fun r => (who r, mean r)) rows).

Fixpoint of_decisions (n : nat) (x u : Z) (laws : list (Z * list Q)) : list block :=
  match n with
  | S n => Block (nothing, x, u) (map (fun l => (l.1, hd zero l.2)) laws) :: of_decisions n x (u + 1) (map (fun l => (l.1, tl l.2)) laws)
  | O => []
  end.

Definition laws_of (rows : list row) : list (Z * list Q) := map (fun r => (who r, law_of r)) rows.

Definition of_rates (r x : Z) (ts : list (Z * (Q * Q))) : block := Block (r, x, nothing) (map rate_of (filter drawn ts)).

(* ---- The widest ratio and the widest difference of a block, and of several ---- *)

Fixpoint extremes (top low : Z * Q) (rest : list (Z * Q)) : (Z * Q) * (Z * Q) :=
  match rest with
  | e :: rest => extremes (if at_most e.2 top.2 then top else e) (if at_most low.2 e.2 then low else e) rest
  | [] => (top, low)
  end.

Record found := Found { worth : option Q; place_at : Z * Z * Z; high : Z * Q; low : Z * Q }.

Definition over_least (top low : Z * Q) (es : list (Z * Q)) : option Q * (Z * Q) :=
  if Qnum low.2 =? 0 then (None, match find (fun e => positive_fraction e.2) es with Some e => e | None => top end)
  else (Some (times top.2 (inverse low.2)), top).

Definition above_least (top low : Z * Q) (es : list (Z * Q)) : option Q * (Z * Q) := (Some (plus top.2 (minus low.2)), top).

(* [equal] is the value where all numbers are equal; the first two are then the first pair. *)
Definition widest (equal : Q) (of_two : Z * Q -> Z * Q -> list (Z * Q) -> option Q * (Z * Q)) (b : block) : option found :=
  match entries b with
  | e :: f :: rest =>
      let '(top, low) := extremes e e (f :: rest) in
      if at_most top.2 low.2 then Some (Found (Some equal) (at_ b) e f)
      else let '(v, h) := of_two top low (entries b) in Some (Found v (at_ b) h low)
  | _ => None
  end.

Definition widest_ratio : block -> option found := widest one over_least.
Definition widest_difference : block -> option found := widest zero above_least.

Definition not_above (v w : option Q) : bool :=
  match v, w with
  | _, None => true
  | None, Some _ => false
  | Some v, Some w => at_most v w
  end.

(* Of equal ones the first *)
Definition better (best : option found) (next : option found) : option found :=
  match best, next with
  | Some b, Some n => if not_above (worth n) (worth b) then best else next
  | None, _ => next
  | _, None => best
  end.

Definition best_of (of_block : block -> option found) (bs : list block) : option found :=
  fold_left (fun best b => better best (of_block b)) bs None.

Definition place_of (s : Z * Z * Z) (h l : Z) : place := let '(r, x, u) := s in Place r x u h l.

Definition figure_of (f : found) : figure :=
  Figure (worth f) (place_of (place_at f) (high f).1 (low f).1) (Some ((high f).2, (low f).2)) [].
