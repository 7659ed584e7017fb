(* What a statement about a policy behind filters says, in any ordered field.

   This file has to be read: it says what the checker proves of the numbers of a certificate.  It is written with the definitions of
   theories/Definitions.v: [induced] is assumption M, [utility] is E(x,a), [policy] and [kernel] are laws for everything that is shown. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions T17.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Definition number {R : realFieldType} (v : seq Q) (i : nat) : R := ratio (seq.nth zero v i).
Definition entry {R : realFieldType} (M : seq (seq Q)) (i j : nat) : R := number (seq.nth [::] M i) j.

Section Meaning.
Variables (R : realFieldType) (S : behind).

(* ---- The filters, the policy and the utility ---- *)

Definition X : finType := [finType of 'I_(true_contexts S)].
Definition Xt : finType := [finType of 'I_(released_contexts S)].
Definition A : finType := [finType of 'I_(true_groups S)].
Definition At : finType := [finType of 'I_(released_groups S)].
Definition U : finType := [finType of 'I_(decisions S)].

(* M_X(y|x) and M_A(b|a): the factors multiplied out *)
Definition MX (x : X) (y : Xt) : R := entry (context_matrix S) x y.
Definition MA (a : A) (b : At) : R := entry (group_matrix S) a b.

(* T(u|y,b), the policy of the certificate, and g(u,x,a) *)
Definition T0 (y : Xt) (b : At) (u : U) : R := entry (seq.nth [::] (policy_laws S) y) b u.
Definition g (u : U) (x : X) (a : A) : R := number (gains S x a) u.

(* E(x,a) of the law that policy and filters induce *)
Definition E0 : X -> A -> R := Definitions.utility (induced MX MA T0) g.

(* P(x,a): the stated masses, or the same for all cells *)
Definition mass (x : X) (a : A) : R := if population S is Some masses then entry masses x a else 1.
Definition mass_of (a : A) : R := \sum_x mass x a.
Definition share (a : A) (x : X) : R := mass x a / mass_of a.
Definition mean (E : X -> A -> R) (a : A) : R := group_mean share E a.

(* ---- What was declared ---- *)

Definition declared_number (q : option Q) : R := if q is Some q then ratio q else 0.

Definition own (x : X) : option declared_in := List.find (fun d => Z.eqb (in_context d) (Z.of_nat x)) (by_context (stated S)).
Definition own_number (field : declared_in -> option Q) (x : X) (otherwise : option Q) : R :=
  if own x is Some d then if field d is Some q then ratio q else declared_number otherwise else declared_number otherwise.

(* tau_x is the greater of the one of the context and the one of all; gamma_x and m_x are those of the context, else those of all. *)
Definition tau_at (x : X) : R := Num.max (declared_number (tau (stated S))) (own_number tau_in x None).
Definition gamma_at (x : X) : R := own_number gamma_in x (gamma (stated S)).
Definition m_at (x : X) : R := own_number m_in x (m (stated S)).

(* L: the declared bound on how much two groups differ in g, or else how much they do *)
Definition spread : R := \big[Num.max/0]_u \big[Num.max/0]_x \big[Num.max/0]_a \big[Num.max/0]_a' (g u x a - g u x a').
Definition effective_L : R := if lipschitz (stated S) is Some L then ratio L else spread.

(* In a context no utility is above gamma or below m, and no expectation below tau; no mean of a group that has some mass is below a floor. *)
Definition allows (a : allowance) : Prop :=
  match a with
  | In_context d => exists x : X,
      [/\ Z.of_nat x = in_context d, if gamma_in d is Some q then forall u a, g u x a <= ratio q else True,
          if m_in d is Some q then forall u a, ratio q <= g u x a else True & if tau_in d is Some q then forall a, ratio q <= E0 x a else True]
  | Of_means t => forall a, 0 < mass_of a -> ratio t <= mean E0 a
  end.

(* ---- The greatest ratio of a class of expectations ---- *)

(* E(x,a) <= V E(x,a') for every two groups in every context; or the same of the means of groups that have some mass *)
Definition within (means : bool) (V : R) (E : X -> A -> R) : Prop :=
  if means then forall a a', 0 < mass_of a -> 0 < mass_of a' -> a != a' -> mean E a <= V * mean E a'
  else forall x a a', a != a' -> E x a <= V * E x a'.

Definition bounded (means : bool) (class : (X -> A -> R) -> Prop) (V : R) : Prop := forall E, class E -> within means V E.

(* V is the least bound that is at least 1; or there is none. *)
Definition greatest_ratio (means : bool) (class : (X -> A -> R) -> Prop) (V : option Q) : Prop :=
  if V is Some V then 1 <= ratio V :> R /\ (forall V', 1 <= V' -> (bounded means class V' <-> ratio V <= V'))
  else forall V', ~ bounded means class V'.

Definition greatest_at_most (means : bool) (class : (X -> A -> R) -> Prop) (V : option Q) : Prop :=
  if V is Some V then bounded means class (ratio V) else True.

(* ---- The classes: what the expectations of a scope are ---- *)

(* A policy that is shown [releases] releases of the group *)
Definition memory : finType := [finType of {ffun 'I_(Pos.to_nat (releases S)) -> At}].
Definition MA_all : A -> memory -> R := @T17.releases R A At MA (Pos.to_nat (releases S)).

Definition of_any_policy (E : X -> A -> R) : Prop :=
  exists T : Xt -> memory -> U -> R, policy T /\ forall x a, E x a = Definitions.utility (induced MX MA_all T) g x a.

Definition keeps_floors (E : X -> A -> R) : Prop :=
  (forall x a, tau_at x <= E x a) /\ (forall a, 0 < mass_of a -> declared_number (global_tau (stated S)) <= mean E a).

Definition of_policy_near (E : X -> A -> R) : Prop :=
  exists T : Xt -> At -> U -> R, [/\ policy T, forall y b, tv (T y b) (T0 y b) <= declared_number (max_drift (stated S)) &
    forall x a, E x a = Definitions.utility (induced MX MA T) g x a].

(* Whatever the decisions are, utilities of the declared range: of each context, or of all where means are compared *)
Definition of_any_utility (means : bool) (E : X -> A -> R) : Prop :=
  exists (U' : finType) (T : Xt -> memory -> U' -> R) (g' : U' -> X -> A -> R),
  [/\ policy T, forall u x a a', g' u x a <= g' u x a' + effective_L,
      forall u x a, if means then declared_number (m (stated S)) <= g' u x a <= declared_number (gamma (stated S))
                    else m_at x <= g' u x a <= gamma_at x &
      forall x a, E x a = Definitions.utility (induced MX MA_all T) g' x a].

(* Group filters: no entry is more than e^epsilon times another one of its column.  The At are the values that are reachable. *)
Definition private (e : option Q) (M : A -> At -> R) : Prop := if e is Some e then every_pair (pure_dp (ratio e)) M else True.

Definition of_group_filter (E : X -> A -> R) : Prop :=
  exists M : A -> At -> R,
  [/\ kernel M, private (exp_epsilon (group_filter S)) M & forall x a, E x a = Definitions.utility (induced MX M T0) g x a].

Definition of_context_filter (E : X -> A -> R) : Prop :=
  exists M : X -> Xt -> R, kernel M /\ forall x a, E x a = Definitions.utility (induced M MA T0) g x a.

(* ---- Statements ---- *)

Definition class_of (means : bool) (s : scope) : (X -> A -> R) -> Prop :=
  match s with
  | ThisLaw => fun E => forall x a, E x a = E0 x a
  | AnyPolicy => of_any_policy
  | KeepingFloor => fun E => of_any_policy E /\ forall x a, declared_number (tau (stated S)) <= E x a
  | KeepingFloors => fun E => of_any_policy E /\ keeps_floors E
  | NearThis => of_policy_near
  | AnyUtility => of_any_utility means
  | AnyUtilityKeepingFloors => fun E => of_any_utility means E /\ keeps_floors E
  | AnyGroupFilter => of_group_filter
  | AnyContextFilter => of_context_filter
  end.

Definition policy_holds (s : statement) : Prop :=
  (if exactly s then greatest_ratio else greatest_at_most) (of_means s) (class_of (of_means s) (about s)) (value s).
End Meaning.
