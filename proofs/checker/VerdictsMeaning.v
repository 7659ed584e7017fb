(* What a verdict on a limit says of the ends of an interval, and what several of them say together: this file has to be read.

   It has no proofs.  That the interval holds of the population is said in DrawnMeaning.v.  "within" and "exceeds" then say something of the
   population, each by one end; "inconclusive" says of the ends alone that they decide nothing. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp Require Import reals.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Statements NatsSound Drawn Verdicts.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* A ratio (none: infinite) is at most the limit, or its logarithm is. *)
Definition keeps (R : realType) (l : limit_on) (v : option R) : bool :=
  if in_nats l then in_nats_at_most v (limit l) else if v is Some v then v <= ratio (limit l) else false.

(* What follows from the ends [least] and [most] *)
Definition verdict_follows (R : realType) (l : limit_on) (least most : option Q) (j : judgement) : Prop :=
  let exceeds := ~~ keeps l (omap (@ratio R) least) in
  let within := keeps l (omap (@ratio R) most) in
  match j with
  | Within => within && ~~ exceeds
  | Exceeds => exceeds && ~~ within
  | Inconclusive => within = exceeds
  | Depends => False
  end.

(* The probability with which some verdict may be wrong: of n limits on one quantity each has its own error where each end holds by itself;
   ends that hold together have one error for all. *)
Definition risk (R : realFieldType) (e : proof) (n : nat) : R :=
  let error := 1 - ratio (confidence_of e) in
  if ends_each e then n%:R * error else if n is _.+1 then error else 0.

Definition risk_of (R : realFieldType) (e : option proof) (n : nat) : R := if e is Some e then risk R e n else 0.

(* [on]: of each limit, whether it is on the local ratio *)
Definition together_at (R : realFieldType) (of_local of_global : option proof) (on : list bool) (c : Q) : Prop :=
  risk_of R of_local (count id on) + risk_of R of_global (count negb on) <= 1 - ratio c.
