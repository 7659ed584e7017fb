(* The ratio over all policies behind known filters, or all that keep the declared floors, and all utilities of a declared range: which
   claims are accepted.

   This file only computes; PolicyRangeSound.v proves it right. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Policy Likelihoods PolicyClaims PolicySites PolicyShown.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

(* Whether V bounds the ratio for two rows and utilities from low to high, which two groups have at most gap apart: by V itself, or by one of
   some multipliers where the lower group has the floor. *)
Definition range_excess (high low gap : Q) (unit : Z) (s : likelihoods) (k : Q) : Q :=
  difference (plus gap (times (difference (difference high gap) low) (hockey unit k s))) (times (difference k one) low).

Definition range_at (V : Q) (multipliers : option (list Q)) (high low gap floor : Q) (unit : Z) (s : likelihoods) : bool :=
  match multipliers with
  | None => at_most (range_excess high low gap unit s V) zero
  | Some ks =>
      [&& positive_fraction floor, nonnegative high
        & at_most high (times V floor)
          || existsb (fun k => [&& nonnegative k, at_most k V & at_most (range_excess high low gap unit s k) (times (difference V k) floor)]) ks]
  end.

Section Behind.
Variable S : behind.

(* Rows of means: those of the contexts of each group, and of what is released of the group *)
Definition mean_unit (a a' : nat) : Z := Z.mul (unit_of [shares S a; shares S a']) (rows_unit S).
Definition mean_likelihoods (rows : list (list Z)) (a a' : nat) : likelihoods :=
  let of_contexts := integers [shares S a; shares S a'] in
  joint (of_rows (nth 0 of_contexts []) (nth 1 of_contexts []))
    (repeated (of_rows (nth a rows []) (nth a' rows [])) (times_released S)).

(* So much work is left to others. *)
Definition work_of_range (means : bool) : Z :=
  let size := Z.of_nat in
  if means then Z.mul (Z.mul (size (true_groups S)) (size (true_groups S)))
                  (Z.mul (size (true_contexts S)) (if one_release S then size (released_groups S) else 3000%Z))
  else 0%Z.

Definition range_accepted (means : bool) (V : Q) (multipliers : option (list Q)) : option bool :=
  match gamma (stated S), m (stated S) with
  | Some high, Some low =>
      if ~~ manageable S (kinds (group_filter S)) || Z.ltb 5000000 (work_of_range means) then None
      else
        let high_at x := own_declared S gamma_in x high in
        let low_at x := own_declared S m_in x low in
        let gap_of high low := lesser (L_used S) (difference high low) in
        let contexts := seq 0 (true_contexts S) in
        Some [&& consistent S, at_most one V, at_most low high, forallb (fun x => at_most (low_at x) (high_at x)) contexts
          & if means then
              let rows := rows_of S in
              let floor := floor_of S None in
              forallb (fun ab => range_at V multipliers high low (gap_of high low) (floor ab.2) (mean_unit ab.1 ab.2) (mean_likelihoods rows ab.1 ab.2))
                (ordered [] (populated S))
            else
              let pairs := all_kinds S in
              forallb (fun x =>
                let h := high_at x in let l := low_at x in
                forallb (range_at V multipliers h l (gap_of h l) (floor_at S x) (kinds_unit S)) pairs) contexts]
  | _, _ => Some false
  end.
End Behind.
