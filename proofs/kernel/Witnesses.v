(* Hypotheses that can be met: the theorems behind claims by lp-dual, applied (see theories/Witnesses.v). *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From FairauditKernel Require Import Fractions FractionsSound LinearProgram WorstCase WorstCaseSound ClaimSound.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* One context, two groups, one decision with a utility between 1 and 2: no ratio exceeds 2. *)
Definition only (a : Z) : cell := Cell Z0 a [Outcome Z0 one [] one] one.
Definition small : table := Table [Z0] [Z0; Zpos 1] Alike [only Z0; only (Zpos 1)].
Definition free_utilities (about_local : bool) : utilities :=
  Utilities about_local (Qmake 2 1) one None false false None None [] [] None.
Definition flat : utility rat_realFieldType := fun _ _ _ => 1.

Lemma in_flat b : in_class (free_utilities b) small flat.
Proof. by split=> //= c; case=> [<-|[<-|[]]] [] //. Qed.

Example lp_check_sound_applies : value_at (R := rat_realFieldType) (fun _ : nat => 1) (Row [] (Zneg 1)) <= 0.
Proof.
by apply: (@lp_check_sound rat_realFieldType _ eqn leq (fun j k => @eqP _ j k) (fun=> 1) (Zpos 1) (fun=> Zpos 1) (fun=> Zpos 1) _ (Zpos 1) _ []) => // j;
  rewrite mulr1 lexx.
Qed.

Example worst_case_local_applies : expectation flat (only Z0) <= ratio (Qmake 2 1) * expectation flat (only (Zpos 1)).
Proof. by apply: (@worst_case_local _ (free_utilities true) small (Qmake 2 1) [] _ _ _ (in_flat true)) => //; [left|right; left|left]. Qed.

Example worst_case_global_applies : group_mean small flat Z0 <= ratio (Qmake 2 1) * group_mean small flat (Zpos 1).
Proof. by apply: (@worst_case_global _ (free_utilities false) small (Qmake 2 1) [] _ _ _ (in_flat false)) => //; [left|right; left]. Qed.

Example claim_true_sound_applies : somebody_compared small true /\ claim_says rat_realFieldType (free_utilities true) small true (Some (Qmake 2 1)).
Proof. by have [] := @claim_true_sound rat_realFieldType (free_utilities true) small true (Some (Qmake 2 1)) []. Qed.
