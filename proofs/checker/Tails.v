(* Whether a binomial tail is at most a level, in integers.

   This file only computes; TailsSound.v proves it right.  It follows docs/certificate-samples.md: a sum whose terms are
   rounded up decides nearly always, and the sum itself where the two are too close. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

Fixpoint raised (x : Z) (e : positive) : Z :=
  match e with
  | xH => x
  | xO e => let y := raised x e in y * y
  | xI e => let y := raised x e in x * (y * y)
  end.

Definition power (x e : Z) : Z := match e with Zpos e => raised x e | _ => 1 end.

(* x/y rounded up *)
Definition above (x y : Z) : Z := - ((- x) / y).

(* so many factors of x (x - 1) (x - 2) ..., times a number *)
Fixpoint falling (many : nat) (x result : Z) : Z :=
  match many with S m => falling m (x - 1) (result * x) | O => result end.

Definition unit : Z := power 2 256. (* of the term for k *)
Definition near : Z := power 2 64.  (* the part of a number that two are close by *)

(* The terms for i - 1, i - 2, ..., 0 of n draws, each a success with the odds a : b, rounded up, by that for i; i = many *)
Fixpoint sum_down (many : nat) (n i a b term result : Z) : Z :=
  match many with
  | S m =>
      let up := i * b in
      let down := (n - i + 1) * a in
      if (term =? 1) && (up <=? down) then result + i
      else let next := above (term * up) down in sum_down m n (i - 1) a b next (result + next)
  | O => result
  end.

(* k! times the sum of C(n,j) a^j b^(k-j) over all j <= k, from that for i - 1 and from n (n - 1) ... a^(i - 1) *)
Fixpoint sum_up (many : nat) (n i a b term result : Z) : Z :=
  match many with
  | S m => let next := term * (n - i + 1) * a in sum_up m n (i + 1) a b next (result * i * b + next)
  | O => result
  end.

(* At most k successes in n draws with the odds a : b, a, b > 0, have at most the chance level. *)
Definition odds_at_most (n k a b : Z) (level : Q) : bool :=
  let m := Z.to_nat k in
  let rest := power b (n - k) in
  let bound := falling m n 1 * power a k * rest * sum_down m n k a b unit unit * Zpos (Qden level) in
  let all := falling m k 1 * power (a + b) n in
  let most := Qnum level * all * unit in
  if bound <=? most then true
  else if bound * near <=? most * (near + 1) then sum_up m n 1 a b 1 1 * rest * Zpos (Qden level) <=? Qnum level * all
  else false.

(* The same of the probability p, and for 0 <= k. *)
Definition tail_at_most (n k : Z) (p level : Q) : bool :=
  let a := Qnum p in
  let b := Zpos (Qden p) - a in
  if (a <=? 0) || (n <=? k) then Zpos (Qden level) <=? Qnum level
  else if b <=? 0 then 0 <=? Qnum level
  else odds_at_most n k a b level.
