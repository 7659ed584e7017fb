(* What a verdict on a limit says of the ends of an interval, and what several of them say together: this file has to be read.

   It has no proofs.  That the interval holds of the population is said in DrawnMeaning.v.  "within" and "exceeds" then say something of the
   population, each by one end; "inconclusive" says of the ends alone that they decide nothing. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.analysis Require Import reals sequences exp.
From FairauditKernel Require Import Fractions FractionsSound.
From Fairaudit Require Import Definitions.
From FairauditChecker Require Import Statements NatsSound Table Chance Drawn DrawnMeaning Verdicts.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* A ratio (none: infinite) is at most the limit, or its logarithm is. *)
Definition keeps (R : realType) (l : limit_on) (v : option R) : bool :=
  if in_nats l then in_nats_at_most v (limit l) else if v is Some v then v <= ratio (limit l) else false.

(* The number that a positive ratio then is at most *)
Definition number_of (R : realType) (l : limit_on) : R := if in_nats l then expR (ratio (limit l)) else ratio (limit l).

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

(* ---- How often one of several verdicts is wrong: TogetherSound.v proves that it is at most the risk ---- *)

Section Wrong.
Variables (R : realFieldType) (ps : list pool) (d : nat) (Q : 'I_(size ps) -> 'I_d -> R). (* the laws of the decisions in the pools *)

(* No two means that are compared have a quotient of more than t. *)
Definition ratio_keeps (t : R) : bool := [forall i, forall j, are_compared i j ==> (mean Q i <= t * mean Q j)].

(* The ends say "within" of the limit t, or "exceeds", which is false of the population. *)
Definition verdict_wrong (t : R) (least most : option QArith_base.Q) : bool :=
  if ratio_keeps t then if least is Some r then t < ratio r else true
  else if most is Some r then ratio r <= t else false.

(* About the data w somebody can write an interval that is accepted, but whose verdict on the limit t is wrong.  What bets on contrasts within
   units prove is about other data, and is left out here. *)
Definition can_err (D : finType) (pool_of : D -> 'I_(size ps)) (e : proof) (t : R) (w : {ffun D -> 'I_d}) : Prop :=
  match e with
  | By_box i => can_mislead pool_of i (fun j => verdict_wrong t (least j) (most j)) w
  | By_pairs i =>
      exists j, [/\ alike_pairs i j, proved_by_ladders j (counted_again pool_of w) & verdict_wrong t (Some (Pairs.lowest j)) (Pairs.highest j)]
  | By_bets _ => False
  end.

(* The draws of the pools are as the interval says that they are. *)
Definition drawn_as (D : finType) (pool_of : D -> 'I_(size ps)) (e : proof) (P : {ffun D -> 'I_d} -> R) : Prop :=
  match e with By_box i => drawn_from pool_of Q (independent i) P | By_pairs _ => drawn_from pool_of Q true P | By_bets _ => False end.
End Wrong.

(* The law of what is made of o, which has the law P *)
Definition law_of_data (R : realFieldType) (O W : finType) (P : O -> R) (f : O -> W) (w : W) : R := \sum_(o | f o == w) P o.
