(* What the checker of claims about policies says to be true holds: of every law in the scope of the claim, in any ordered field. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From FairauditChecker Require Import Policy PolicyMeaning PolicyClaims PolicyMeans PolicySuprema PolicySupremaSound PolicyFloors PolicyFloorsSound PolicyNear PolicyNearSound PolicyRange PolicyRangeSound PolicyChecker.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Theorem policy_claim_sound (R : realFieldType) (S : behind) (s : statement) (r : reason) :
  valid S -> policy_claim S s r = Some true -> policy_holds R S s.
Proof.
have sound : [&& consistent S, ~~ exactly s & bound_accepted S s r] -> valid S -> policy_holds R S s.
  by case/and3P => cons not_exactly accepted ok; exact: (@bound_accepted_sound R S ok s r cons accepted not_exactly).
move=> ok; have some b : Some b = Some true -> b by case=> ->.
case: r sound => [ks||  |ks|ks|  |c|  |raw|  |p|ks ps w|ks] sound //; try by move=> /some/sound; apply.
- rewrite /policy_claim /supremum_claim /policy_holds {sound}; case: s => means exact V sc; cbn [about Policy.value exactly of_means].
  case: sc => //; case: exact => // accepted; first exact: (@supremum_sound R S ok means V p accepted).
  case drift: (max_drift (stated S)) => [eta|]; first exact: (@near_sound R S ok eta means V p drift accepted).
  by move: accepted; rewrite /near_accepted drift.
- rewrite /policy_claim /floored_claim /policy_holds {sound}; case: s => means exact V sc; cbn [about Policy.value exactly of_means].
  case: sc => // /(@floored_sound R S ok means exact V ks ps w).
  by case: exact.
rewrite /policy_claim /range_claim /policy_holds {sound}; case: s => means exact V sc; cbn [about Policy.value exactly of_means].
case: sc => //; case: exact => //; case: V => [V|] //; last exact: (@floored_range_sound R S ok means V ks).
case: ks => //; exact: (@range_sound R S ok means V).
Qed.
