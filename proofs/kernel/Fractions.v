(* Fractions in lowest terms, as programs compute with them.

   This file only computes; FractionsSound.v says what a fraction is in an ordered field. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

Definition reduced (q : Q) : Q :=
  let g := Z.gcd (Qnum q) (Zpos (Qden q)) in
  match Z.div (Zpos (Qden q)) g with Zpos d => Qmake (Z.div (Qnum q) g) d | _ => q end.

Definition plus (q r : Q) : Q := reduced (Qplus q r).
Definition times (q r : Q) : Q := reduced (Qmult q r).
Definition minus (q : Q) : Q := Qmake (Z.opp (Qnum q)) (Qden q).
Definition inverse (q : Q) : Q := match Qnum q with Zpos n => Qmake (Zpos (Qden q)) n | _ => Qmake 0 1 end. (* of a positive fraction *)
Definition zero : Q := Qmake 0 1.
Definition one : Q := Qmake 1 1.
Definition nonnegative (q : Q) : bool := 0 <=? Qnum q.
Definition positive_fraction (q : Q) : bool := 0 <? Qnum q.
Definition at_most (q r : Q) : bool := Qnum q * Zpos (Qden r) <=? Qnum r * Zpos (Qden q).
Definition equal (q r : Q) : bool := (Qnum q =? Qnum r) && (Zpos (Qden q) =? Zpos (Qden r)).
Definition total (qs : list Q) : Q := fold_right plus zero qs.
