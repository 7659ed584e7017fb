(* The checker of claims about a policy behind filters: true, false, or not covered.

   This file only computes; PolicyCheckerSound.v proves: of a policy that is well formed ([valid] of Policy.v), what is said to be
   true holds.  By T13 all is covered that the page has, but for several releases that take much work. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditChecker Require Import Policy PolicyClaims PolicySuprema PolicyFloors PolicyNear PolicyRange.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Definition supremum_claim (S : behind) (s : statement) (attained : option pair) : option bool :=
  match about s with
  | AnyPolicy => if exactly s then supremum_accepted S (of_means s) (value s) attained else None
  | NearThis => if exactly s then near_accepted S (of_means s) (value s) attained else None
  | _ => None
  end.

Definition floored_claim (S : behind) (s : statement) (ks : list Q) (pairs : list priced) (policy : option (pair * list (list vector))) : option bool :=
  match about s with
  | KeepingFloors => floored_accepted S (of_means s) (exactly s) (value s) ks pairs policy
  | _ => None
  end.

Definition range_claim (S : behind) (s : statement) (multipliers : list Q) : option bool :=
  match about s, exactly s, value s with
  | AnyUtility, false, Some V => match multipliers with nil => range_accepted S (of_means s) V None | _ => None end
  | AnyUtilityKeepingFloors, false, Some V => range_accepted S (of_means s) V (Some multipliers)
  | AnyUtility, false, None | AnyUtilityKeepingFloors, false, None => Some false
  | _, _, _ => None
  end.

Definition policy_claim (S : behind) (s : statement) (r : reason) : option bool :=
  match r with
  | ByT13 attained => supremum_claim S s attained
  | ByT13range multipliers => range_claim S s multipliers
  | ByT13floors ks pairs policy => floored_claim S s ks pairs policy
  | _ => Some [&& consistent S, ~~ exactly s & bound_accepted S s r]
  end.
