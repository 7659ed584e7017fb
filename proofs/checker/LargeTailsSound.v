(* Tails of many draws that are found to be at most a level are. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Tails TailsSound PairLaw PairLadderSound LargeTails.
From Fairaudit Require Import Binomial.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Sound.
Variable R : realFieldType.
Local Notation ratio := (@ratio R).

(* What the program accepts is so, for the tail of every p from 0 to 1. *)
Theorem tail_holds_sound N k p level : (k <= N)%N -> 0 <= ratio p <= 1 ->
  tail_holds (Z.of_nat N) (Z.of_nat k) p level -> at_most N (ratio p) k <= ratio level.
Proof.
move=> kN p01; have by_law : tail_by_law (Z.of_nat N) (Z.of_nat k) p level -> at_most N (ratio p) k <= ratio level.
  by case/andP=> level0; apply: rare_belowP => //; apply: ratio_ge0.
rewrite /tail_holds; case: ifP => [_ /orP[//|]|_]; first exact: tail_at_most_sound.
case/andP=> level0 /and3P[a0 /Z.ltb_lt lt /orP[b0|/and4P[_ _ _]]]; last exact: by_law.
have kN' : (k < N)%N by lia.
have -> : ratio p = 1.
  apply/eqP; rewrite eq_le; case/andP: p01 => _ -> /=; apply: level_ge1; apply/Z.leb_le; move/Z.leb_le: b0 => b0; lia.
apply: le_trans (_ : 0 <= _); last exact: ratio_ge0.
by rewrite /at_most big1 // => j _; rewrite /successes subrr expr0n subn_eq0 leqNgt (leq_trans (ltn_ord j) kN') mulr0.
Qed.
End Sound.
