(* Hypotheses that can be met: what is proved of ladders of pairs, applied (see theories/Witnesses.v). *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import PairExact.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import PairLaw PairLadderSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* None of eight draws of one cell, all of eight of another: its mean is below 3/2 of that of the other one, at the level 1/20, by one step. *)
Example ladder_accepted_sound_applies : exists (x : rat) qs, 0 < ratio (Qmake 3 2) :> rat /\
  ladder 8 8 (order 8 8 (Qmake 25 16)) (ratio (Qmake 1 20)) (ratio (guard_of (Qmake 1 20))) (ratio (Qmake 3 2)) (0, 8)%N x qs.
Proof. by apply: (@ladder_accepted_sound rat_realFieldType 8 8 0 8 _ _ _ [:: Qmake 3 10; Qmake 1 1]); vm_compute. Qed.
