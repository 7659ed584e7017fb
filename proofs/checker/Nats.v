(* Logarithms, in integers: on which side of a rational x the logarithm of a rational r >= 1 lies,
   and whether two decimals are its enclosure as docs/certificate.md defines it.

   This file only computes; NatsSound.v proves it right.  Nothing takes a logarithm: e^x is at least
   (1 + x/2^k)^(2^k), which k squarings of m*2^s make, rounded down to so many bits each time; so is
   e^-x, whose inverse bounds e^x from above.  What a precision does not decide, the next one may. *)

From Coq Require Import ZArith QArith String Ascii List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* ---- A number m * 2^s that is at most e^x ---- *)

Record binary := Binary { mantissa : Z; exponent : Z }.

(* At most v, with [bits] bits after the leading one *)
Definition shortened (bits : Z) (v : binary) : binary :=
  let cut := Z.log2 (mantissa v) - bits in
  if 0 <? cut then Binary (Z.shiftr (mantissa v) cut) (exponent v + cut) else v.

Definition squared (v : binary) : binary := Binary (mantissa v * mantissa v) (2 * exponent v).

Fixpoint squared_often (bits : Z) (k : nat) (v : binary) : binary :=
  match k with O => v | S k => squared_often bits k (shortened bits (squared v)) end.

(* 1 + x/2^k rounded down, and 0 if that is negative *)
Definition tangent (bits k : Z) (x : Q) : binary :=
  let d := Z.shiftl (Zpos (Qden x)) k in
  Binary (Z.max 0 (Z.shiftl (d + Qnum x) bits / d)) (- bits).

Definition exp_low (k : Z) (x : Q) : binary :=
  let bits := 2 * k + 64 in squared_often bits (Z.to_nat k) (tangent bits k x).

(* n/d < v *)
Definition less (n d : Z) (v : binary) : bool :=
  if 0 <=? exponent v then n <? Z.shiftl (mantissa v * d) (exponent v) else Z.shiftl n (- exponent v) <? mantissa v * d.

(* ---- On which side of x log r lies ---- *)

(* The numbers of squarings that are tried in turn; the last ones are for ratios made to lie close to e^x. *)
Definition precisions : list Z := [64; 160; 512; 2048; 16384].

Fixpoint side_at (ks : list Z) (r x : Q) : option comparison :=
  match ks with
  | [] => None
  | k :: rest =>
      if less (Qnum r) (Zpos (Qden r)) (exp_low k x) then Some Lt
      else if less (Zpos (Qden r)) (Qnum r) (exp_low k (Qopp x)) then Some Gt
      else side_at rest r x
  end.

(* Lt: log r < x, Eq: log r = x, Gt: log r > x; None: r < 1, x < 0, or not decided *)
Definition side (r x : Q) : option comparison :=
  let n := Qnum r in
  let d := Zpos (Qden r) in
  if n <? d then None
  else if Qnum x <? 0 then None
  else if n =? d then Some (0 ?= Qnum x)
  else if (Z.log2 n + 1) * Zpos (Qden x) <=? Qnum x then Some Lt (* log r < log2 n + 1 *)
  else if (n - d) * Zpos (Qden x) <=? Qnum x * d then Some Lt (* log r < r - 1 *)
  else if Qnum x * n <=? (n - d) * Zpos (Qden x) then Some Gt (* log r > 1 - 1/r *)
  else side_at precisions r x.

(* log r <= limit, for r >= 1 and limit >= 0; r = None is infinity *)
Definition log_at_most (r : option Q) (limit : Q) : option bool :=
  match r with
  | Some r => option_map (fun c => match c with Gt => false | _ => true end) (side r limit)
  | None => Some false
  end.

(* ---- Enclosures ---- *)

Definition units : positive := 1000000000000. (* the format has twelve decimals *)

(* lo/units <= log r < (lo + 1)/units *)
Definition log_floor_is (r : Q) (lo : Z) : option bool :=
  match side r (Qmake lo units), side r (Qmake (lo + 1) units) with
  | Some Lt, _ => Some false
  | _, Some Gt | _, Some Eq => Some false
  | Some _, Some Lt => Some true
  | _, _ => None
  end.

(* What texts say: the value of digits before or after the point is read from the left, and a decimal has twelve
   digits after the point, some before it, and no superfluous leading zeros.  Its value is given in units. *)
Definition digit (c : ascii) : option Z :=
  let n := Z.of_N (N_of_ascii c) - 48 in if (0 <=? n) && (n <=? 9) then Some n else None.

Fixpoint digits (value : Z) (cs : list ascii) : option Z :=
  match cs with
  | [] => Some value
  | c :: rest => match digit c with Some n => digits (10 * value + n) rest | None => None end
  end.

Definition point (c : ascii) : bool := Ascii.eqb c ".".

(* The text before the first point, and the one after it *)
Fixpoint parts (cs : list ascii) : list ascii * list ascii :=
  match cs with
  | c :: rest => if point c then ([], rest) else let (before, after) := parts rest in (c :: before, after)
  | [] => ([], [])
  end.

Definition decimal (cs : list ascii) : option Z :=
  let (before, after) := parts cs in
  match before with
  | [] => None
  | c :: rest =>
      if (Ascii.eqb c "0" && match rest with [] => false | _ => true end) || negb (Nat.eqb (length after) 12) then None
      else digits 0 (before ++ after)
  end.

Definition text_zero : list ascii := list_ascii_of_string "0".
Definition text_inf : list ascii := list_ascii_of_string "inf".
Definition is_text (a b : list ascii) : bool := if list_eq_dec ascii_dec a b then true else false.

(* Whether two texts are the enclosure of log r; r = None is infinity.  Texts that are none at all are not it. *)
Definition enclosure_is (r : option Q) (low high : list ascii) : option bool :=
  match r with
  | None => Some (is_text low text_inf && is_text high text_inf)
  | Some r =>
      if Qnum r =? Zpos (Qden r) then Some (is_text low text_zero && is_text high text_zero)
      else match decimal low, decimal high with
           | Some lo, Some hi => if hi =? lo + 1 then log_floor_is r lo else Some false
           | _, _ => Some false
           end
  end.
