(* Hypotheses that can be met: an interval by bets on contrasts within units.

   Ten units got 1 in both groups of a context: at the confidence 1/2 no group gets more than twice as much as the other. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Drawn.
From FairauditChecker Require Bets BetsSound BetsMeaning BetsHold.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Definition two_times : QArith_base.Q := Qmake 2 1.
Definition a_half : QArith_base.Q := Qmake 1 2.
Definition ten_alike : seq Bets.contrast := [:: Bets.Contrast (Zpos 10) one one Z0].
Definition of_ten (a : Z) : cell := Cell Z0 a [:: Qmake 10 1; zero] [::] zero [::].
Definition table_of_ten : table := Table (Zpos 1) (Zpos 2) (Zpos 2) Counted (Some [:: one; zero]) None [:: of_ten Z0; of_ten (Zpos 1)].
Definition interval_of_ten : Bets.units :=
  Bets.Units a_half true false a_half a_half false None None [:: [:: (Zpos 10, [:: Some one; Some one])]] true one (Some two_times).

Lemma two_times_ge0 : 0 <= ratio two_times :> rat. Proof. exact: ratio_ge0. Qed.

Lemma ten_alike_ge0 : 0 <= BetsSound.exact_wealth (ratio two_times) ten_alike :> rat.
Proof.
have part_one : BetsSound.part (ratio one : rat) by rewrite /BetsSound.part ratio_one ler01 lexx.
by apply: BetsSound.exact_wealth_ge0 two_times_ge0 _ => c [<-|//]; split.
Qed.

Lemma of_ten_judged : judged_by_draws table_of_ten true (By_bets interval_of_ten) = Some true.
Proof. by vm_compute. Qed.

Example wealth_below_applies : BetsSound.below (Bets.wealth_of two_times ten_alike) (BetsSound.exact_wealth (ratio two_times) ten_alike : rat).
Proof. exact: (BetsSound.wealth_below two_times_ge0 ten_alike_ge0). Qed.

Example bets_sound_applies : true /\ BetsMeaning.bets_hold [realFieldType of rat] table_of_ten interval_of_ten.
Proof. exact: (BetsHold.bets_sound _ of_ten_judged). Qed.
