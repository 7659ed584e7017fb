(* Policies behind the same filters that are written out, or are near the one of the certificate; the floors that policies keep; and
   whether what was declared allows for what the table has.

   This file only computes; PolicyShownSound.v proves it right. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Policy PolicyClaims PolicySites.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Section Behind.
Variable S : behind.

(* ---- Another policy, by released context and released group ---- *)

Definition with_laws (rows : list (list vector)) : behind :=
  Behind (group_filter S) (context_filter S) (releases S) (decisions S) rows (population S) (utility S) (stated S).

Definition are_laws (rows : list (list vector)) : bool :=
  shaped (released_contexts S) (released_groups S) rows && forallb (forallb (is_law (decisions S))) rows.

(* Of expectations E(x,a), by true context and true group: that of a context, or the mean of a group *)
Definition quantity_of (es : list (list Q)) (c : option nat) (a : nat) : Q :=
  match c with
  | Some x => nth a (nth x es []) zero
  | None => expected (shares S a) (map (fun row => nth a row zero) es)
  end.

Definition has_ratio (es : list (list Q)) (V : option Q) (p : pair) : bool :=
  let above := quantity_of es (in_true_context p) (higher_group p) in
  let below := quantity_of es (in_true_context p) (lower_group p) in
  match V with
  | Some V => let most := times V below in [&& positive_fraction below, at_most above most & at_most most above]
  | None => zero_fraction below && positive_fraction above
  end.

(* ---- Floors ---- *)

(* What is declared of a context, else of all *)
Definition own_declared (field : declared_in -> option Q) (x : nat) (otherwise : Q) : Q :=
  match find (fun d => Z.eqb (in_context d) (Z.of_nat x)) (by_context (stated S)) with
  | Some d => match field d with Some q => q | None => otherwise end
  | None => otherwise
  end.

Definition or_zero (q : option Q) : Q := match q with Some q => q | None => zero end.
Definition floor_at (x : nat) : Q := greater (or_zero (tau (stated S))) (own_declared tau_in x zero).
Definition floor_of_means : Q := or_zero (global_tau (stated S)).

(* What the floors leave for what is compared *)
Definition floor_of (c : option nat) : nat -> Q :=
  match c with
  | Some x => let t := floor_at x in fun _ => t
  | None => let ts := map floor_at (seq 0 (true_contexts S)) in fun a => greater floor_of_means (expected (shares S a) ts)
  end.

Definition some_floor : bool := existsb positive_fraction (floor_of_means :: map floor_at (seq 0 (true_contexts S))).

Definition keeps (es : list (list Q)) : bool :=
  forallb (fun x => forallb (at_most (floor_at x)) (nth x es [])) (seq 0 (true_contexts S))
  && forallb (fun a => at_most floor_of_means (quantity_of es None a)) (populated S).

(* ---- What was declared ---- *)

Definition if_declared (q : option Q) (fits : Q -> bool) : bool := match q with Some q => fits q | None => true end.

Definition allowed (a : allowance) : bool :=
  match a with
  | In_context d =>
      let x := Z.to_nat (in_context d) in
      let gains := concat (gains_of S x) in
      [&& Z.leb 0 (in_context d), Nat.ltb x (true_contexts S), if_declared (gamma_in d) (at_most (greatest_of gains)),
          if_declared (m_in d) (fun q => at_most q (least_of gains))
        & if_declared (tau_in d) (fun q => at_most q (least_of (nth x (expectations S) [])))]
  | Of_means t => let es := expectations S in forallb (fun a => at_most t (quantity_of es None a)) (populated S)
  end.
End Behind.
