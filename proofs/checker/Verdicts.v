(* Whether a limit on a ratio of the population is kept, by the ends of its interval, and whether the intervals hold together.

   This file only computes; VerdictsMeaning.v says what it means and VerdictsSound.v proves it.  It follows docs/certificate-samples.md,
   "Targets".  A verdict rests on one end: it is "within" by the upper one, "exceeds" by the lower one. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Statements Nats Drawn.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

(* A limit on a ratio: on itself, or in nats on its logarithm *)
Record limit_on := Limit { in_nats : bool; limit : Q }.

(* Whether an end (none: infinite) is at most the limit; none: not decided *)
Definition end_keeps (l : limit_on) (r : option Q) : option bool :=
  if in_nats l then log_at_most r (limit l) else Some (match r with Some r => at_most r (limit l) | None => false end).

(* Neither is so, or both where the ends cross: then the ends decide nothing. *)
Definition verdict_by_ends (l : limit_on) (least most : option Q) : option judgement :=
  match end_keeps l least, end_keeps l most with
  | Some true, Some true => Some Within
  | Some false, Some false => Some Exceeds
  | Some _, Some _ => Some Inconclusive
  | _, _ => None
  end.

Definition same_verdict (j k : judgement) : bool :=
  match j, k with Within, Within | Exceeds, Exceeds | Inconclusive, Inconclusive => true | _, _ => false end.

Definition judged_by_interval (e : proof) (l : limit_on) (j : judgement) : option bool :=
  option_map (same_verdict j) (verdict_by_ends l (least_of e) (most_of e)).

(* ---- How often verdicts may be wrong ---- *)

Definition error_of (e : proof) : Q := plus one (minus (confidence_of e)).

(* Of n limits on one quantity: where each end holds by itself each has its own error, else they have one together. *)
Definition error_for (e : proof) (n : nat) : Q :=
  if ends_each e then times (Qmake (Z.of_nat n) 1) (error_of e) else match n with O => zero | S _ => error_of e end.

(* [on]: of each limit, whether it is on the local ratio *)
Definition limits_on (local : bool) (on : list bool) : nat := length (filter (Bool.eqb local) on).

Definition spent_on (e : option proof) (n : nat) : Q := match e with Some e => error_for e n | None => zero end.
Definition spent (of_local of_global : option proof) (on : list bool) : Q :=
  plus (spent_on of_local (limits_on true on)) (spent_on of_global (limits_on false on)).

Definition hold_together (of_local of_global : option proof) (on : list bool) (c : Q) : bool :=
  at_most (plus (spent of_local of_global on) c) one.
