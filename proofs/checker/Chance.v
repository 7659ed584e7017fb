(* Whether a box of ends of means proves an interval of a ratio, by exact binomial tails.

   This file only computes; ChanceSound.v proves: whatever the means are, what it accepts is wrong at most with the
   probability 1 - confidence.  It follows docs/certificate-samples.md, region "box", for cells of the kind "counts" whose draws
   are worth a number or nothing.  Cells are in the order of the table, those of a block next to each other. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Tails LargeTails.
From FairauditChecker Require PairLaw.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* One compared cell: so many of its draws were worth [worth], the others nothing. *)
Record sample := Sample {
  block : Z;        (* the number of the context; 0 for the global ratio *)
  draws : Z;
  successes : Z;
  worth : Q         (* the greatest utility, the end [high] of the range of the cell; [low] is 0 *)
}.

(* "upper" and "lower" of the evidence with the ends of all cells, [lo, hi] *)
Definition ends : Type := Q * Q.

Record interval := Interval {
  confidence : Q;
  each : bool;                (* "ends" is "each" *)
  independent : bool;         (* cells were declared independent *)
  upper_level : Q;            (* "levels": "upper" *)
  lower_level : Q;            (* "levels": "lower" *)
  upper : list ends;
  lower : list ends;
  pair : option (Z * Z);      (* the higher and the lower cell that prove R_lo, counted from 0 over all cells *)
  least : option Q;           (* R_lo; none: infinite *)
  most : option Q             (* R_hi *)
}.

Definition informative (s : sample) : bool := (0 <? draws s) && positive_fraction (worth s).

(* What it takes to sum the tails of all cells, a number of terms for each that goes up with the root of its draws: what takes longer is
   not covered, so that a browser judges the rest in seconds. *)
Definition most_work : Z := 50000.
Definition work (ss : list sample) : Z := fold_left (fun w s => if informative s then w + PairLaw.root (draws s) + 10 else w) ss 0.
Definition is_short (ss : list sample) : bool := work ss <=? most_work.

(* ---- The ends of a cell ---- *)

Definition part_of (s : sample) (mean : Q) : Q := times mean (inverse (worth s)).
Definition rest_of (p : Q) : Q := plus one (minus p).

Definition excluded_above (level : Q) (s : sample) (hi : Q) : bool := tail_holds (draws s) (successes s) (part_of s hi) level.
Definition excluded_below (level : Q) (s : sample) (lo : Q) : bool :=
  tail_holds (draws s) (draws s - successes s) (rest_of (part_of s lo)) level.

Definition ends_hold (level : Q) (s : sample) (e : ends) : bool :=
  let (lo, hi) := e in
  [&& nonnegative lo, at_most lo hi, at_most hi (worth s) &
      if informative s then
        (at_most lo zero || excluded_below level s lo) && (at_most (worth s) hi || excluded_above level s hi)
      else at_most lo zero && at_most (worth s) hi].

Fixpoint all_hold (level : Q) (ss : list sample) (es : list ends) : bool :=
  match ss, es with
  | s :: ss, e :: es => ends_hold level s e && all_hold level ss es
  | [], [] => true
  | _, _ => false
  end.

(* ---- The levels ---- *)

Fixpoint strictly_rising (zs : list Z) : bool :=
  match zs with y :: ((z :: _) as rest) => (y <? z) && strictly_rising rest | _ => true end.

Definition number (n : Z) : Q := Qmake n 1.
Definition to_the (q : Q) (n : Z) : Q := Qmake (power (Qnum q) n) (match power (Zpos (Qden q)) n with Zpos d => d | _ => xH end).

(* How many cells are informative, and how many of them two compared cells can be. *)
Definition used (ss : list sample) : Z := Z.of_nat (length (filter informative ss)).
Definition lesser (a b : Z) : Z := if a <=? b then a else b.
Definition spanned (ss : list sample) : Z :=
  if strictly_rising (map block (filter informative ss)) then lesser 1 (used ss) else lesser 2 (used ss).

(* The chance that one of s ends at the level u, or of the 2K - s others at the level l, is wrong, is at most 1 - c; if cells are independent
   chances that all are right multiply. *)
Definition affordable (c : Q) (ind : bool) (K s : Z) (u l : Q) : bool :=
  at_most (plus (plus (times (number s) u) (times (number (2 * K - s)) l)) c) one
  || [&& ind, positive_fraction (rest_of (plus u l)), positive_fraction (rest_of (plus l l))
       & at_most c (times (to_the (rest_of (plus u l)) s) (to_the (rest_of (plus l l)) (K - s)))].

Definition levels_hold (i : interval) (ss : list sample) : bool :=
  let (K, s) := (used ss, spanned ss) in
  let (u, l) := (upper_level i, lower_level i) in
  (if K =? 0 then [&& at_most u zero, at_most l zero, nonnegative u & nonnegative l]
   else [&& positive_fraction u, positive_fraction l, positive_fraction (rest_of u) & positive_fraction (rest_of l)])
  && if each i then affordable (confidence i) (independent i) K s u zero && affordable (confidence i) (independent i) K s l l
     else at_most l u && affordable (confidence i) (independent i) K s u l.

(* Of ends that hold together one number is free in the levels then; it may be chosen after the draws were seen. *)
Definition in_proportion (i : interval) (ss : list sample) : bool :=
  let (K, s) := (used ss, spanned ss) in
  [|| each i, K =? 0
    | let (a, b) := (times (number s) (upper_level i), times (number (2 * K - s)) (lower_level i)) in at_most a b && at_most b a].

(* ---- The ends of the ratio ---- *)

Definition cell_ends : Type := Z * ends. (* with the block *)

Definition within (r : Q) (e f : ends) : bool := at_most e.2 (times r f.1).

Fixpoint with_rest (r : Q) (x : cell_ends) (xs : list cell_ends) : bool :=
  match xs with
  | y :: rest => if x.1 =? y.1 then [&& within r x.2 y.2, within r y.2 x.2 & with_rest r x rest] else x.1 <? y.1
  | [] => true
  end.

(* Of any two cells of one block none has a mean of more than r times that of the other. *)
Fixpoint all_within (r : Q) (xs : list cell_ends) : bool :=
  match xs with x :: rest => with_rest r x rest && all_within r rest | [] => true end.

Definition most_holds (r : option Q) (xs : list cell_ends) : bool :=
  match r with Some r => at_most one r && all_within r xs | None => true end.

Fixpoint cell_at {A} (xs : list A) (i : Z) : option A :=
  match xs with x :: rest => if i =? 0 then Some x else cell_at rest (i - 1) | [] => None end.

Definition least_holds (r : option Q) (p : option (Z * Z)) (xs : list cell_ends) : bool :=
  match p with
  | None => match r with Some r => at_most r one && at_most one r | None => false end
  | Some (i, j) =>
      match cell_at xs i, cell_at xs j with
      | Some x, Some y =>
          [&& x.1 =? y.1, negb (i =? j), positive_fraction x.2.1
            & match r with
              | Some r => [&& at_most one r, negb (at_most r one) & at_most (times r y.2.2) x.2.1]
              | None => at_most y.2.2 zero
              end]
      | _, _ => false
      end
  end.

(* ---- The interval ---- *)

Definition blocked (ss : list sample) (es : list ends) : list cell_ends := combine (map block ss) es.

Definition upper_accepted (i : interval) (ss : list sample) : bool :=
  all_hold (upper_level i) ss (upper i) && most_holds (most i) (blocked ss (upper i)).

Definition lower_accepted (i : interval) (ss : list sample) : bool :=
  all_hold (lower_level i) ss (lower i) && least_holds (least i) (pair i) (blocked ss (lower i)).

Definition box_accepted (i : interval) (ss : list sample) : bool :=
  [&& levels_hold i ss, upper_accepted i ss & lower_accepted i ss].
