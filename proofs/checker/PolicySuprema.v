(* The greatest ratio over all policies behind known filters, for the utility of the certificate: which claims are accepted.

   This file only computes; PolicySupremaSound.v proves it right. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Policy Likelihoods PolicyClaims PolicySites.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* S(V) <= 0 *)
Definition no_excess (V : Q) (_ : Z) (s : likelihoods) (alphas betas : list (list Z)) (_ : Q) : bool :=
  over_sites (fun alpha beta => sum_over top (Qnum V) (Zpos (Qden V)) alpha beta s) alphas betas <=? 0.

Section Behind.
Variable S : behind.

Definition never_exceeded (means : bool) (V : Q) : bool :=
  let rows := rows_of S in
  let pairs := all_kinds S in
  forallb (fun c => proved S rows pairs (no_excess V) (fun _ _ => false) c (fun=> zero)) (places S means).

(* Nothing where the releases are too many *)
Definition supremum_accepted (means : bool) (V : option Q) (attained : option pair) : option bool :=
  if ~~ manageable S (kinds (group_filter S)) then None
  else Some match V, attained with
  | Some V, Some p =>
      [&& at_most one V, ~~ at_most V one, is_pair S means p, attains S (Qnum V) (Zpos (Qden V)) p & never_exceeded means V]
  | Some V, None => [&& at_most one V, at_most V one & never_exceeded means V]
  | None, Some p => is_pair S means p && gives_nothing S p
  | None, None => false
  end.
End Behind.
