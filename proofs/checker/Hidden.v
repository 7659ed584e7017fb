(* How strong a hidden factor would have to be to bring a ratio down: which frontiers are accepted.

   This file only computes; HiddenSound.v proves that a weaker factor does not do it, by T14. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Statements.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

Definition equals (q r : Q) : bool := at_most q r && at_most r q.
Definition divided (q r : Q) : Q := times q (inverse r).

(* e + sqrt(e^2 - 1), rounded down to six decimals: both strengths, where they are equal *)
Definition rounded_root (p q : Z) : Z := (p * 1000000 + Z.sqrt ((p * p - q * q) * (1000000 * 1000000))) / q.
Definition balanced_strength (e : Q) : Q := Qmake (rounded_root (Qnum e) (Zpos (Qden e))) 1000000.

(* the m that k needs *)
Definition strength_beside (e k : Q) : Q := divided (plus (times e k) (minus one)) (plus k (minus e)).

(* k goes up from before *)
Fixpoint pairs_fit (e before : Q) (ps : list (Q * Q)) : bool :=
  match ps with
  | (k, m) :: rest => [&& ~~ at_most k before, equals m (strength_beside e k) & pairs_fit e k rest]
  | [] => true
  end.

Definition level_fits (seen : option Q) (l : level) : bool :=
  match seen, balanced l with
  | None, None => equals (down_to l) one && match strengths l with [] => true | _ => false end
  | Some r, Some b =>
      let e := divided r (down_to l) in
      [&& positive_fraction (down_to l), ~~ at_most r (down_to l), equals b (balanced_strength e) & pairs_fit e e (strengths l)]
  | _, _ => false
  end.

Fixpoint rising (ls : list level) : bool :=
  match ls with
  | l :: ((l' :: _) as rest) => ~~ at_most (down_to l') (down_to l) && rising rest
  | _ => true
  end.

Definition frontier_fits (seen v : option Q) (ls : list level) : bool :=
  match ls with
  | l :: _ =>
      [&& equals (down_to l) one, match v, balanced l with Some v, Some b => equals v b | None, None => true | _, _ => false end,
          rising ls & forallb (level_fits seen) ls]
  | [] => false
  end.
