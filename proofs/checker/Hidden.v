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

(* n is (p + sqrt(p^2 - q^2))/q in millionths, rounded down. *)
Definition million : Z := 1000000.
Definition is_rounded_root (p q n : Z) : bool :=
  let d := q * n - p * million in
  let square := (p * p - q * q) * (million * million) in
  [&& (d <=? 0) || (d * d <=? square), 0 <? d + q & square <? (d + q) * (d + q)].

(* b is e + sqrt(e^2 - 1), rounded down to six decimals: both strengths, where they are equal. *)
Definition is_balanced (e b : Q) : bool :=
  let n := Qnum b * million / Zpos (Qden b) in
  (n * Zpos (Qden b) =? Qnum b * million) && is_rounded_root (Qnum e) (Zpos (Qden e)) n.

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
      [&& positive_fraction (down_to l), ~~ at_most r (down_to l), is_balanced e b & pairs_fit e e (strengths l)]
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
