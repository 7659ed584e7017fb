(* An example that meets the hypotheses of the theorem on several verdicts on one population. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions Draws.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Chance Drawn DrawnMeaning VerdictsMeaning TogetherSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* One context and two groups, of each of which two were decided upon, one of them well; an interval from 1 to infinity, at confidence 3/4. *)
Definition two_groups : table :=
  Table 1 2 2 Counted (Some [:: one; zero]) None
    [:: Cell 0 0 [:: one; one] [::] zero [::]; Cell 0 1 [:: one; one] [::] zero [::]].

Definition sixteenth : QArith_base.Q := Qmake 1 16.
Definition all_of_them : list ends := [:: (zero, one); (zero, one)].
Definition unbounded : interval := Interval (Qmake 3 4) false true sixteenth sixteenth all_of_them all_of_them None (Some one) None.
Definition its_pools (local : bool) : list pool := if pools_of two_groups local is Some ps then ps else [::].

Definition decision : finType := [finType of 'I_(Z.to_nat (decisions two_groups))].
Definition no_draws (local : bool) (o : unit) : {ffun void -> decision} := finfun (of_void decision).
Definition from_nowhere (local : bool) : void -> 'I_(size (its_pools local)) := of_void _.
Definition always_well (local : bool) (i : 'I_(size (its_pools local))) (u : decision) : rat := if val u == 0%N then 1 else 0.
Definition certainly (o : unit) : rat := 1.

Lemma certain : law certainly.
Proof. by split=> // ; rewrite big_const card_unit. Qed.

Lemma its_poolsE local : pools_of two_groups local = Some (its_pools local).
Proof. by case: local; vm_compute. Qed.

Lemma it_is_accepted local : judged_by_draws two_groups local (By_box unbounded) = Some true.
Proof. by case: local; vm_compute. Qed.

Lemma laws_of_decisions local : kernel (@always_well local).
Proof. by move=> i; split=> [u|]; rewrite /always_well; [case: ifP|rewrite big_ord_recl big1]. Qed.

Lemma drawn_so local : drawn_from (@from_nowhere local) (@always_well local) true (law_of_data certainly (@no_draws local)).
Proof.
move=> w; rewrite /law_of_data /drawn [RHS]big1 => [|[]//].
rewrite (eq_bigl xpredT) => [|o]; first by case: certain.
by apply/eqP/ffunP => -[].
Qed.

Example verdicts_hold_together_applies : prob certainly set0 <= 1 - ratio (Qmake 1 2).
Proof.
apply: (@verdicts_hold_together _ two_groups its_pools (fun=> By_box unbounded) _ certainly always_well (fun=> void_finType) from_nowhere no_draws certain
  [:: true; false] (fun=> 2%:R) _ _ (Some (By_box unbounded)) (Some (By_box unbounded))) => // [local _|local _|o].
- by split; [exact: its_poolsE|exact: it_is_accepted|exact: laws_of_decisions|exact: drawn_so].
- by case: local.
- by rewrite inE.
Qed.
