(* What holds of a population: intervals of a ratio from independent draws of decisions that are worth something or nothing.

   Reading key.  Every draw d is of cell [cell d] and has the law [Q (cell d)]; a draw u of cell i is worth [worth i] if it is [good],
   else nothing.  S is any set of data for each of which there is some box that the data allow at the levels u (for the upper end) and l
   (for the lower end) and that proves an end on the wrong side of the true ratio: the levels are chosen before the draws, all else of a
   box, also which end it is about, may be chosen after seeing them. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions Binomial Draws Ends Coverage.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Population.
Variables (R : realFieldType) (D I U : finType) (B : eqType) (cell : D -> I) (Q : I -> U -> R) (good : I -> pred U).
Variables (worth : I -> R) (block : I -> B).
Hypotheses (laws : kernel Q) (worth0 : forall i, 0 <= worth i).

Local Notation n := (draws cell).
Local Notation p := (chance Q good).

(* The utility of a draw, whose expectation is the mean of its cell. *)
Definition gain i u : R := if good i u then worth i else 0.

Theorem gain_mean i : expect (Q i) (gain i) = E p worth i.
Proof.
rewrite /expect /E /chance mulr_sumr [RHS]big_mkcond; apply: eq_bigr => u _; rewrite /gain.
by case: ifP => _; rewrite ?mulr0 // mulrC.
Qed.

Variables (u l : R) (K s : nat).
Hypotheses (l0 : 0 <= l) (lu : l <= u) (u1 : u < 1).
(* K cells are informative, no two that are compared have more than s of them. *)
Hypotheses (all_K : K = #|[set i | informative n worth i]|) (sK : (s <= K)%N).
Hypothesis spanned : forall i j, compared block i j -> (informative n worth i + informative n worth j <= s)%N.

Variable S : {set {ffun D -> U}}.
Hypothesis missed : forall w, w \in S ->
  misses_above (count cell good) n p worth block u w \/ misses_below (count cell good) n p worth block l w.

(* Independent draws within each cell, and anything between cells: whatever the laws are, an interval misses at most with this probability. *)
Theorem binomial_interval P : law P -> (forall i, within cell Q P i) -> prob P S <= s%:R * u + (2 * K - s)%:R * l.
Proof.
move=> lawP ind; apply: (box_misses lawP) missed => // i; first exact: chance01.
by split=> [w|j]; [exact: count_le | exact: (count_binomial good laws _ (ind i))].
Qed.

(* All draws independent. *)
Theorem binomial_interval_independent : u + l <= 1 ->
  prob (drawn cell Q) S <= 1 - (1 - u - l) ^+ s * (1 - 2%:R * l) ^+ (K - s).
Proof.
move=> ul; apply: (box_misses_independent (law_drawn cell laws)) missed _ ul => // [i|i|]; first exact: chance01.
  by split=> [w|j]; [exact: count_le | exact: (count_binomial good laws _ (within_drawn cell laws i))].
by move=> T; apply: counts_independent.
Qed.

End Population.
