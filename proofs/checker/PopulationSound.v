(* What an accepted interval says of a population.

   Reading key.  Every draw d is of cell [cell d] and is what the law [Q (cell d)] gives, a decision say; it is worth [ratio (v i)] in cell i
   if it is [good] there, else nothing.  The data w are all draws; the program is given how many there are of each cell and how many of
   them are good.  S is any set of data for each of which somebody can write an interval that the program accepts and that is wrong.  In words:
   whatever the laws are, and whoever writes the interval after seeing the draws, S has at most the probability 1 - c.
   The first form is for draws that are independent within each cell, the second for cells that are independent of each other, too. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions Draws Ends.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Chance ChanceSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Population.
Variables (R : realFieldType) (D U : finType) (N : nat) (cell : D -> 'I_N) (Q : 'I_N -> U -> R) (good : 'I_N -> pred U).
Variables (blk : 'I_N -> Z) (v : 'I_N -> QArith_base.Q).
Hypotheses (laws : kernel Q) (worth0 : forall i, nonnegative (v i)).

Definition true_upper_end (r : option QArith_base.Q) : Prop := most_true (chance Q good) blk v r.
Definition true_lower_end (r : option QArith_base.Q) : Prop := least_true (chance Q good) blk v r.

Definition wrong (i : interval) : Prop := ~ true_upper_end (most i) \/ ~ true_lower_end (least i).
Definition wrong_above (i : interval) : Prop := ~ true_upper_end (most i).
Definition wrong_below (i : interval) : Prop := ~ true_lower_end (least i).

(* Somebody can write such an interval about the data w.  Of ends that hold together the levels u and l are settled before the draws, of ends
   that hold each by itself they, too, may be chosen after seeing them. *)
Definition somebody_can (c : QArith_base.Q) (ind : bool) (u l : QArith_base.Q) (is_wrong : interval -> Prop) (w : {ffun D -> U}) : Prop :=
  exists i, [/\ settled c false ind u l i, box_accepted i (samples (count cell good) (Draws.draws cell) blk v w) & is_wrong i].
Definition somebody_can_apart (c : QArith_base.Q) (ind : bool) (is_wrong : interval -> Prop) (w : {ffun D -> U}) : Prop :=
  exists i, [/\ settled_apart c ind i, box_accepted i (samples (count cell good) (Draws.draws cell) blk v w) & is_wrong i].

Variables (c u l : QArith_base.Q) (S : {set {ffun D -> U}}).
Hypothesis c1 : ratio c <= 1 :> R.

Section Within.
Variable P : {ffun D -> U} -> R.
Hypotheses (lawP : law P) (ind : forall i, Draws.within cell Q P i).

Lemma counted_within : counted P (count cell good) (Draws.draws cell) (chance Q good).
Proof. by move=> i; split=> [w|j]; [exact: count_le | exact: (count_binomial good laws j (ind i))]. Qed.

Theorem population_together : (forall w, w \in S -> somebody_can c false u l wrong w) -> prob P S <= 1 - ratio c.
Proof. by apply: (box_together lawP (chance01 good laws) worth0 counted_within c1); last by []. Qed.

Theorem population_upper : (forall w, w \in S -> somebody_can_apart c false wrong_above w) -> prob P S <= 1 - ratio c.
Proof. by apply: (box_upper lawP (chance01 good laws) worth0 counted_within c1); last by []. Qed.

Theorem population_lower : (forall w, w \in S -> somebody_can_apart c false wrong_below w) -> prob P S <= 1 - ratio c.
Proof. by apply: (box_lower lawP (chance01 good laws) worth0 counted_within c1); last by []. Qed.
End Within.

Section Independent.
Variable b : bool. (* whether the interval says that cells are independent *)
Local Notation P := (drawn cell Q).

Lemma independent_drawn : b -> independent_counts P (count cell good).
Proof. by move=> _ T; apply: counts_independent. Qed.

Lemma counted_drawn : counted P (count cell good) (Draws.draws cell) (chance Q good).
Proof. by apply: counted_within => i; apply: within_drawn. Qed.

Theorem independent_together : (forall w, w \in S -> somebody_can c b u l wrong w) -> prob P S <= 1 - ratio c.
Proof. by apply: (box_together (law_drawn cell laws) (chance01 good laws) worth0 counted_drawn c1 independent_drawn). Qed.

Theorem independent_upper : (forall w, w \in S -> somebody_can_apart c b wrong_above w) -> prob P S <= 1 - ratio c.
Proof. by apply: (box_upper (law_drawn cell laws) (chance01 good laws) worth0 counted_drawn c1 independent_drawn). Qed.

Theorem independent_lower : (forall w, w \in S -> somebody_can_apart c b wrong_below w) -> prob P S <= 1 - ratio c.
Proof. by apply: (box_lower (law_drawn cell laws) (chance01 good laws) worth0 counted_drawn c1 independent_drawn). Qed.
End Independent.
End Population.
