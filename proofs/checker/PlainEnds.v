(* The ends of means that an interval does not list, in closed form.

   This file only computes.  It follows docs/certificate-samples.md, "Plain ends".  Nothing is proved of it, and nothing has to be: whatever
   ends come out, Chance.v judges them by exact tails like those that are listed. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Nats Tails Chance.
From FairauditChecker Require PairLaw.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* Plain ends are multiples of 1/parts of the range of a cell, as is the logarithm of a level that they rest on. *)
Definition parts_bits : Z := 32.
Definition parts : Z := Z.shiftl 1 parts_bits.

(* ---- The least multiple of 1/parts that is at least log(1/level) ---- *)

(* It is above low, and at most high. *)
Fixpoint least_at_least (steps : nat) (r : Q) (low high : Z) : Z :=
  match steps with
  | S steps =>
      if high - low <=? 1 then high
      else let middle := (low + high) / 2 in
           match side r (Qmake middle (Z.to_pos parts)) with
           | Some Gt => least_at_least steps r middle high
           | _ => least_at_least steps r low middle
           end
  | O => high
  end.

(* For a level between 0 and 1; of a level of 0 there is none. *)
Definition reach_of (level : Q) : Z :=
  if positive_fraction level then
    let r := inverse level in
    let most := (Z.log2 (Qnum r) + 1) * parts in
    least_at_least (Z.to_nat (Z.log2 most) + 1) r 0 most
  else 0.

(* ---- The ends of n draws of which k are successes, in parts ---- *)

(* The least integer that is not negative and whose square is at least a quotient *)
Definition root_above (v d : Z) : Z := let least := above v d in if least <=? 0 then 0 else PairLaw.root (least - 1) + 1.

(* The least j for which p = j/parts is above z = k/n and n (p - z)^2 >= 2 v reach/parts, v being the greatest t (1 - t) between them *)
Definition plain_above (n k reach : Z) : Z :=
  let twice := 2 * reach in
  lesser parts
    (if n <=? 2 * k then above (k * parts + root_above (twice * parts * (k * (n - k))) n) n
     else if n * (n - 2 * k) * (n - 2 * k) * parts <? twice * n * n then above (k * parts + root_above (reach * (parts / 2) * (n * n)) n) n
     else let scaled := n * parts in
          above (parts * (2 * scaled * k + twice * n) + root_above (twice * parts * parts * (4 * scaled * k * (n - k) + twice * n * n)) 1)
                (2 * n * (scaled + twice))).

Definition plain_below (n k reach : Z) : Z :=
  let least := parts - plain_above n (n - k) reach in
  if (k <=? 0) || (k * parts <=? 4 * (least * n)) then least
  else
    let successes := k * n * parts in
    let halvings := above (13 * (successes + reach * n)) (9 * successes) in
    if halvings <=? parts_bits then Z.max least (k * parts / Z.shiftl n halvings) else least.

Definition range_of (s : sample) : ends := (zero, worth s).

Definition plain_of (reach : Z) (s : sample) : ends :=
  if informative s && (0 <? reach) then
    let end_at (j : Z) : Q := times (worth s) (Qmake j (Z.to_pos parts)) in
    let (n, k) := (draws s, successes s) in
    (end_at (plain_below n k reach), end_at (parts - plain_below n (n - k) reach))
  else range_of s.

(* ---- The ends of all cells, some of which are listed ---- *)

Inductive given := All (es : list ends) | Some_cells (of_cells : list (Z * ends)).

(* Cells go up; n is the number of the first sample. *)
Fixpoint filled (otherwise : sample -> ends) (done : list ends) (n : Z) (ss : list sample) (listed : list (Z * ends)) : option (list ends) :=
  match ss with
  | s :: ss =>
      match listed with
      | (i, e) :: rest =>
          if i =? n then filled otherwise (e :: done) (n + 1) ss rest else filled otherwise (otherwise s :: done) (n + 1) ss listed
      | [] => filled otherwise (otherwise s :: done) (n + 1) ss []
      end
  | [] => match listed with [] => Some (rev_append done []) | _ => None end
  end.

(* Where a cell is listed that there is not, no ends, which are those of no sample *)
Definition completed (otherwise : sample -> ends) (ss : list sample) (g : given) : list ends :=
  match g with
  | All es => es
  | Some_cells listed => match filled otherwise [] 0 ss listed with Some es => es | None => [] end
  end.
