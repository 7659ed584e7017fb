(* The statements of a list that are all said to be true of a table hold of it: what files that are made of certificates use. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From FairauditChecker Require Import Table Statements Meaning Checker CheckerSound.
From FairauditChecker Require Policy PolicyMeaning PolicyChecker PolicyCheckerSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Definition found_true (o : outcome) : bool := if o is True_ then true else false.

Definition all_true (T : table) (ss : list statement) : bool := if check T ss is Some os then forallb found_true os else false.

Theorem all_true_hold (R : realFieldType) (T : table) (ss : list statement) : all_true T ss -> forall s, List.In s ss -> holds R T s.
Proof.
rewrite /all_true; case c: (check T ss) => [os|] // /forallb_forall found s inss; apply: (check_sound R c).
move: c; rewrite /check; case: (valid T) => // -[osE]; rewrite -{}osE in found *.
elim: ss inss found => //= t ss IH [->|inss] found; last by right; apply: IH => // o oin; apply: found; right.
by left; case: (outcome_of _ s) (found _ (or_introl erefl)).
Qed.

(* The same of claims about a policy behind filters *)
Definition claim_found_true (S : Policy.behind) (c : Policy.statement * Policy.reason) : bool :=
  if PolicyChecker.policy_claim S c.1 c.2 is Some true then true else false.

Definition all_claims_true (S : Policy.behind) (cs : list (Policy.statement * Policy.reason)) : bool :=
  Policy.valid S && forallb (claim_found_true S) cs.

Theorem all_claims_hold (R : realFieldType) (S : Policy.behind) (cs : list (Policy.statement * Policy.reason)) :
  all_claims_true S cs -> forall c, List.In c cs -> PolicyMeaning.policy_holds R S c.1.
Proof.
case/andP => ok /forallb_forall found c /found; rewrite /claim_found_true.
by case e: (PolicyChecker.policy_claim S c.1 c.2) => [[|]|] // _; apply: PolicyCheckerSound.policy_claim_sound ok e.
Qed.
