(* The local ratio over all policies behind known filters and all utilities of a declared range: which claims are accepted.

   This file only computes; PolicyRangeSound.v proves it right. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Policy Likelihoods PolicyClaims.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Section Behind.
Variable S : behind.

(* gamma_x and m_x: those declared of the context, else those of all *)
Definition own_declared (field : declared_in -> option Q) (x : nat) (otherwise : Q) : Q :=
  match find (fun d => Z.eqb (in_context d) (Z.of_nat x)) (by_context (stated S)) with
  | Some d => match field d with Some q => q | None => otherwise end
  | None => otherwise
  end.

Definition range_in (V top low : Q) (x : nat) : bool :=
  let top_x := own_declared gamma_in x top in
  let low_x := own_declared m_in x low in
  let width := difference top_x low_x in
  let gap := lesser (L_used S) width in
  at_most low_x top_x
  && forallb (fun s =>
       at_most (plus gap (times (difference (difference top_x gap) low_x) (hockey (of_filter S).1 V s)))
               (times low_x (difference V one)))
     (of_filter S).2.
End Behind.

Definition range_accepted (S : behind) (V : Q) : bool :=
  match gamma (stated S), m (stated S) with
  | Some top, Some low =>
      [&& consistent S, one_release S, at_most one V, at_most low top & forallb (range_in S V top low) (seq 0 (true_contexts S))]
  | _, _ => false
  end.
