(* When an interval by bets on contrasts within units holds: this file has to be read.

   It has no proofs.  ps are the pools of draws that a table counts, one for each group of each context.  D are the sampling units, who are
   independent; unit d turns out to be u with the probability Q d u, whatever that law is.  A unit can be in several contexts, and in a
   context be seen in several groups.  Which units are in which context is settled.  What a unit gets in one group may depend in any
   way on what it gets in another one, but its expectation is the same for all units of the context.  As for other intervals, what holds is a
   property of the procedure: it has at most the probability 1 - c that somebody can write an interval about what the units got that
   is accepted and wrong, whoever writes it after seeing that. *)

From Coq Require Import ZArith QArith List Permutation.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From Fairaudit Require Import Definitions.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Drawn.
From FairauditChecker Require Bets.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Units.
Variables (R : realFieldType) (ps : list pool) (limits : option (QArith_base.Q * QArith_base.Q)).
Local Notation groups := 'I_(size ps).

Definition context_of (i : groups) : Z := of_block (nth (Pool 0 [::] [::]) ps i).
Definition are_compared (i j : groups) : bool := (context_of i == context_of j) && (i != j).

(* The greatest utility that there is in a context, or what was declared to be the greatest one *)
Definition top_of (b : Z) : QArith_base.Q :=
  if limits is Some l then l.2 else greatest (List.flat_map values [seq p <- ps | Z.eqb (of_block p) b]).

(* The greatest quotient of two means that are compared is at most r, or at least r; 0/0 = 1. *)
Definition ratio_at_most (E : groups -> R) (r : option QArith_base.Q) : Prop :=
  if r is Some r then forall i j, are_compared i j -> E i <= ratio r * E j else True.
Definition ratio_at_least (E : groups -> R) (r : QArith_base.Q) : Prop :=
  ratio r <= 1 :> R \/ exists i j, [/\ are_compared i j, ratio r * E j <= E i & 0 < E i].

(* ---- The units ---- *)

Variables (D U : finType) (unit_in : Z -> pred D).     (* which units are in a context *)
Variable gets : groups -> D -> U -> R.                  (* what a unit gets in a group, or would get, the mean over its rows there *)
Variable seen : groups -> D -> U -> option QArith_base.Q. (* that where it is seen *)

Record are_units (dropped : bool) (Q : D -> U -> R) (E : groups -> R) : Prop := {
  each_law : forall d, law (Q d);
  in_range : forall i d u, 0 <= gets i d u <= ratio (top_of (context_of i));
  as_seen : forall i d u q, seen i d u = Some q -> ratio q = gets i d u;
  mean_of_units : forall i d, unit_in (context_of i) d -> expect (Q d) (gets i d) = E i;
  mean_ge0 : forall i, 0 <= E i; (* which says something of groups without units only *)
  by_design : dropped -> forall i d u v, isSome (seen i d u) = isSome (seen i d v) (* where a unit is seen does not depend on what it gets. *)
}.

(* All units are independent. *)
Definition all_units (Q : D -> U -> R) (w : {ffun D -> U}) : R := \prod_d Q d (w d).

(* ---- What is written about data w ---- *)

(* The profiles list the units of all contexts, in whatever order. *)
Definition profile_of (b : Z) (d : D) (u : U) : Bets.profile := [seq seen i d u | i <- enum 'I_(size ps) & context_of i == b].
Definition list_units (w : {ffun D -> U}) (b : Z) (es : list Bets.entry) : Prop :=
  Permutation (flatten [seq nseq (Z.to_nat e.1) e.2 | e <- es]) [seq profile_of b d (w d) | d <- enum D & unit_in b d].
Definition list_all (w : {ffun D -> U}) (ess : list (list Bets.entry)) : Prop :=
  Forall2 (list_units w) [seq x.1 | x <- Figures.grouped of_block ps] ess.

(* What is settled before: not what was drawn. *)
Definition alike (i j : Bets.units) : Prop :=
  [/\ Bets.confidence j = Bets.confidence i, Bets.each j = Bets.each i, Bets.drop j = Bets.drop i & Bets.limits j = Bets.limits i].

(* Somebody can write an interval about the data, and what its table says was drawn, that is accepted and wrong. *)
Definition can_mislead (i : Bets.units) (is_wrong : Bets.units -> Prop) (w : {ffun D -> U}) : Prop :=
  exists j ds, [/\ alike i j, size ds = size ps, list_all w (Bets.profiles j), proved_by_units j (zip ps ds) & is_wrong j].

Definition seldom (Q : D -> U -> R) (i : Bets.units) (is_wrong : Bets.units -> Prop) : Prop :=
  forall S : {set {ffun D -> U}}, (forall w, w \in S -> can_mislead i is_wrong w) -> prob (all_units Q) S <= 1 - ratio (Bets.confidence i).
End Units.

(* Both ends hold together at the confidence, or each of them by itself. *)
Definition bets_hold (R : realFieldType) (T : table) (i : Bets.units) : Prop :=
  exists ps ds, [/\ pools_of T true = Some ps, draws_in i ps = Some ds, size ds = size ps, proved_by_units i (zip ps ds) &
    forall (D U : finType) (unit_in : Z -> pred D) (gets : 'I_(size ps) -> D -> U -> R) (seen : 'I_(size ps) -> D -> U -> option QArith_base.Q)
      (Q : D -> U -> R) (E : 'I_(size ps) -> R),
    are_units (Bets.limits i) unit_in gets seen (Bets.drop i) Q E ->
    let above j := ~ ratio_at_most E (Bets.most j) in
    let below j := ~ ratio_at_least E (Bets.least j) in
    if Bets.each i then seldom unit_in seen Q i above /\ seldom unit_in seen Q i below
    else seldom unit_in seen Q i (fun j => above j \/ below j)].
