(* How far cells may move while a verdict on the logarithm of a ratio stands: what is accepted holds, for the real exponential. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.analysis Require Import reals sequences exp.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Nats NatsSound Drift DriftEnds DriftClaimsSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Logarithms.
Variables (R : realType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).

Lemma of_natsE limit r b : 0 <= ratio limit -> of_nats limit r = Some b -> b = no_more (extended R r) (Some (expR (ratio limit))).
Proof.
move=> limit0; have e1 : 1 <= expR (ratio limit) by rewrite -[1]expR0 ler_expR.
rewrite /of_nats (not_above_extended R) /= ratio_one; case: ifP => [le [<-]|/negbT gt /(log_at_most_sound R) ->].
  by rewrite (@no_more_through R _ _ (Some (expR (ratio limit))) le).
case: r gt => [r|] //=; rewrite -ltNge => gt; have pos : 0 < ratio r := lt_trans ltr01 gt.
by rewrite -[in RHS](lnK (x := ratio r)) ?posrE // ler_expR.
Qed.

Lemma stands_for_log_sound f s limit : figure_holds R T (ratio_of_all (is_local s)) f ->
  stands_for_log T (rows_of T) (group_rows T (rows_of T)) f s limit = Some true -> stands T s (expR (ratio limit)).
Proof.
move=> fig; rewrite /stands_for_log; case: ifP => //; rewrite (nonnegativeE R) => limit0; apply: stand_sound fig => //.
- by rewrite -[1]expR0 ler_expR.
- by move=> r b; apply: of_natsE.
by move=> b; rewrite /is_zero (no_numeratorE R); case: eqP => // -> [<-]; rewrite expR0 ratio_one.
Qed.
End Logarithms.
