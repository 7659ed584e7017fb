(* Which claims about policies behind filters are accepted: those that the page docs/certificate-policy.md calls true.

   This file only computes; PolicyBounds.v and others prove that what is accepted holds. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Policy Likelihoods.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

(* ---- Values that may be infinite ---- *)

Definition no_more (p q : option Q) : bool :=
  match p, q with
  | _, None => true
  | None, Some _ => false
  | Some p, Some q => at_most p q
  end.

Definition same_extended (p q : option Q) : bool :=
  match p, q with
  | None, None => true
  | Some p, Some q => at_most p q && at_most q p
  | _, _ => false
  end.

Definition greater_of (p q : option Q) : option Q := both greater p q.
Definition zero_fraction (q : Q) : bool := Z.eqb (Qnum q) 0.
Definition difference (p q : Q) : Q := plus p (minus q).

Section Behind.
Variable S : behind.

(* ---- Constants ---- *)

Definition all_gains : vector := match utility S with OfDecision g => g | OfCell gs => concat (concat gs) end.

(* How much two groups differ in the utility of a decision in a context *)
Definition spread_in (rows : list vector) : Q :=
  fold_right (fun column most => greater (difference (greatest_of column) (least_of column)) most) zero (columns (decisions S) rows).
Definition spread_of : Q :=
  match utility S with OfDecision _ => zero | OfCell gs => fold_right (fun rows most => greater (spread_in rows) most) zero gs end.

Definition effective (stated_one : option Q) (own : Q) : Q := match stated_one with Some q => q | None => own end.
Definition gamma_used : Q := effective (gamma (stated S)) (greatest_of all_gains).
Definition m_used : Q := effective (m (stated S)) (least_of all_gains).
Definition L_used : Q := effective (lipschitz (stated S)) spread_of.

(* Declared constants do not contradict the table *)
Definition consistent : bool :=
  [&& at_most (greatest_of all_gains) gamma_used, at_most m_used (least_of all_gains) & at_most spread_of L_used].

Definition a_free : bool := zero_fraction L_used.
Definition one_release : bool := Pos.eqb (releases S) 1.
Definition epsilon : option Q := exp_epsilon (group_filter S).

(* ---- Expectations ---- *)

Definition expected (p v : vector) : Q := total (map (fun t => times t.1 t.2) (combine p v)).

(* E(x,a) of the induced law, by true context and true group *)
Definition expectations : list (list Q) :=
  map (fun row => map (fun cell => expected (law_of cell.2) (gains S row.1 cell.1)) (numbered row.2)) (numbered (induced_weights S)).

Definition tau_of_law : Q := least_of (concat expectations).

(* Sum_u T(u|y,b) g(u,x), by y and b *)
Definition answers (x : nat) : list (list Q) := map (map (fun law => expected law (gains S x 0))) (policy_laws S).

(* The least answer to what a true context can release *)
Definition policy_floor : Q :=
  least_of (flat_map
    (fun xr => flat_map (fun ta => if positive_fraction ta.1 then ta.2 else []) (combine xr.2 (answers xr.1)))
    (numbered (context_matrix S))).

(* h(x,b), by x and b *)
Definition responses : list (list Q) :=
  map (fun xr => map (expected xr.2) (columns (released_groups S) (answers xr.1))) (numbered (context_matrix S)).

Definition raw_ratio : option Q := fold_right greater_of (Some one) (map widest responses).

(* Sum_b M_A(b|a) Sum_u T(u|y,b) g(u), by y and a *)
Definition unfiltered_contexts : list (list Q) := map (fun row => map (fun r => expected r row) (group_matrix S)) (answers 0).
Definition context_ratio : option Q := fold_right greater_of (Some one) (map widest unfiltered_contexts).

(* ---- Groups that have some mass, and their compositions ---- *)

Definition masses_of (a : nat) : vector := map (fun x => mass_in S x a) (seq 0 (true_contexts S)).
Definition populated : list nat := filter (fun a => positive_fraction (total (masses_of a))) (seq 0 (true_groups S)).
Definition shares (a : nat) : vector := let masses := masses_of a in let t := inverse (total masses) in map (times t) masses.

Definition compares_means : bool := Nat.leb 2 (length populated).

Fixpoint same_vector (p q : vector) : bool :=
  match p, q with [], [] => true | x :: p', y :: q' => if equal x y then same_vector p' q' else false | _, _ => false end.
Definition independent : bool := match map shares populated with p :: rest => forallb (same_vector p) rest | [] => true end.

(* P(y|a) of the released contexts y, by y and a *)
Definition released_shares : list vector :=
  let ps := map shares populated in map (fun column => map (expected column) ps) (columns (released_contexts S) (context_matrix S)).
Definition composition : option Q := fold_right greater_of (Some one) (map widest released_shares).

(* ---- Bounds by one theorem ---- *)

(* The floor of a claim by T1, T1-paper, T3 or floor *)
Definition floor_in (s : scope) : option Q :=
  match s with ThisLaw => Some tau_of_law | KeepingFloor => tau (stated S) | AnyGroupFilter => Some policy_floor | _ => None end.
Definition with_floor (s : scope) (f : Q -> bool) : bool :=
  match floor_in s with Some t => positive_fraction t && f t | None => false end.

(* (1 + r e)/(r + e), both possibly infinite *)
Definition contraction_of (e r : option Q) : option Q :=
  match e, r with
  | Some e, Some r => Some (times (plus one (times r e)) (inverse (plus r e)))
  | None, r => r
  | e, None => e
  end.

(* Whether k + max(0, add + weight H_k - (k - 1) shed)/t is at most V for some k in the list, for every kind of pair *)
Definition multiplied_bound (add weight shed t : Q) (u : Z) (k : Q) (s : likelihoods) : Q :=
  let excess := difference (plus add (times weight (hockey u k s))) (times (difference k one) shed) in
  if nonnegative excess then plus k (times excess (inverse t)) else k.

Definition multipliers_prove (V : option Q) (add weight shed t : Q) (ks : list Q) (u : Z) (pairs : list likelihoods) : bool :=
  match V with
  | None => match ks with [] => false | _ => true end
  | Some V => forallb (fun s => existsb (fun k => nonnegative k && at_most (multiplied_bound add weight shed t u k s) V) ks) pairs
  end.

Definition of_filter : Z * list likelihoods := (units (group_filter S), kinds (group_filter S)).

(* The one pair of rows that stands for all filters of this epsilon *)
Definition of_epsilon : Z * list likelihoods :=
  match epsilon with
  | Some e => let n := Qnum e in let d := Zpos (Qden e) in (Z.add n d, [[(n, d); (d, n)]])
  | None => (1%Z, [[(1%Z, 0%Z); (0%Z, 1%Z)]])
  end.

Definition in_scope (s : scope) : bool := match s with ThisLaw => true | KeepingFloor => one_release | _ => false end.

Definition bound_accepted (s : statement) (r : reason) : bool :=
  let V := value s in
  let local := negb (of_means s) in
  match r, about s with
  | ByT2, AnyPolicy => [&& local, one_release, a_free, epsilon & no_more epsilon V]
  | ByT1paper, c =>
      [&& local, in_scope c, epsilon
        & with_floor c (fun t => no_more (both times epsilon (Some (plus one (times L_used (inverse t))))) V)]
  | ByFloor, c => [&& local, in_scope c & with_floor c (fun t => no_more (Some (times gamma_used (inverse t))) V)]
  | ByT1 ks, c =>
      [&& local, in_scope c & with_floor c (fun t => multipliers_prove V L_used gamma_used zero t ks of_filter.1 of_filter.2)]
  | ByT3 ks, AnyGroupFilter =>
      [&& local, a_free
        & with_floor AnyGroupFilter (fun t => at_most t gamma_used && multipliers_prove V zero gamma_used zero t ks of_epsilon.1 of_epsilon.2)]
  | ByT3 ks, c =>
      [&& local, in_scope c
        & with_floor c (fun t =>
            at_most t (difference gamma_used L_used)
            && multipliers_prove V L_used (difference gamma_used L_used) zero t ks of_filter.1 of_filter.2)]
  | ByT4 ks, AnyPolicy =>
      [&& local, one_release, a_free, positive_fraction m_used
        & multipliers_prove V zero (difference gamma_used m_used) m_used m_used ks of_filter.1 of_filter.2]
  | ByT12 stated_ratio, AnyGroupFilter =>
      [&& local, a_free, same_extended stated_ratio raw_ratio & no_more (contraction_of epsilon raw_ratio) V]
  | ByT8, AnyContextFilter =>
      [&& local, match utility S with OfDecision _ => true | OfCell _ => false end,
          match context_filter S with Filtered _ => true | AsIs _ => false end & no_more context_ratio V]
  | ByT5, AnyPolicy => [&& ~~ local, compares_means, one_release, a_free, epsilon, independent & no_more epsilon V]
  | ByT5decision stated_ratio, AnyPolicy =>
      [&& ~~ local, compares_means, one_release, match utility S with OfDecision _ => true | OfCell _ => false end, epsilon,
          same_extended stated_ratio composition & no_more (both times epsilon composition) V]
  | _, _ => false
  end.
End Behind.
