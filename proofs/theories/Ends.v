(* Ends of means that the draws of a cell exclude what is beyond: how probable it is that some are wrong.

   Reading key.  I are the cells; [counted] says that the number of good draws in cell i, of n i, is binomial with the
   mean p i; [independent_counts] that the numbers of different cells are independent.  The lower end of a cell is wrong at the
   level a i only if its upper tail at the true mean is at most a i, an upper end at b i only if the lower tail is at most b i. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions Binomial Draws.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Ends.
Variables (R : realFieldType) (W I : finType) (P : W -> R) (count : I -> W -> nat) (n : I -> nat) (p : I -> R).

Definition counted : Prop := forall i, (forall w, (count i w <= n i)%N) /\
  forall j, prob P [set w | count i w == j] = successes (n i) (p i) j.

Definition independent_counts : Prop := forall S : I -> pred nat,
  prob P [set w | [forall i, S i (count i w)]] = \prod_i prob P [set w | S i (count i w)].

(* Some tail of some cell at its true mean is that small. *)
Definition rare_at (a b : R) i (j : nat) : bool := (at_least (n i) (p i) j <= a) || (at_most (n i) (p i) j <= b).
Definition rare (a b : I -> R) : {set W} := [set w | [exists i, rare_at (a i) (b i) i (count i w)]].

Hypotheses (lawP : law P) (p01 : forall i, 0 <= p i <= 1) (drawn : counted).

Lemma prob_count_in i (S : pred nat) : prob P [set w | S (count i w)] = \sum_(j < (n i).+1 | S j) successes (n i) (p i) j.
Proof.
have [le_n bin] := drawn i.
rewrite /prob (partition_big (fun w => inord (count i w) : 'I_(n i).+1) (fun j => S j)) /= => [|w].
  apply: eq_bigr => j Sj; rewrite -bin /prob; apply: eq_bigl => w; rewrite !inE.
  apply/andP/eqP => [[_ /eqP<-]|e]; first by rewrite inordK // ltnS.
  by rewrite e; split=> //; apply/eqP/val_inj; rewrite /= inordK ?ltn_ord.
by rewrite inE inordK // ltnS.
Qed.

Lemma prob_le (S T : {set W}) : S \subset T -> prob P S <= prob P T.
Proof.
move=> sub; rewrite /prob [leRHS](big_setID S) /= (setIidPr sub) ler_addl.
by apply: sumr_ge0 => w _; case: lawP.
Qed.

Lemma prob_ge0 (S : {set W}) : 0 <= prob P S.
Proof. by apply: sumr_ge0 => w _; case: lawP. Qed.

Lemma prob_rare_at i a b : 0 <= a -> 0 <= b -> prob P [set w | rare_at a b i (count i w)] <= a + b.
Proof.
move=> a0 b0; have c0 j : 0 <= successes (n i) (p i) j by apply: successes_ge0.
rewrite (prob_count_in i (rare_at a b i)) (bigID (fun j : 'I_(n i).+1 => at_least (n i) (p i) j <= a)) /=.
apply: ler_add.
  rewrite (eq_bigl (fun j : 'I_(n i).+1 => at_least (n i) (p i) j <= a)) => [|j]; last by rewrite /rare_at; case: (_ <= a); rewrite ?andbF.
  exact: (@rare_high _ _ _ _ (fun j => at_least (n i) (p i) j <= a)).
apply: le_trans (@rare_low _ (n i) (p i) b (fun j => at_most (n i) (p i) j <= b) _ _ _) => //.
rewrite [leRHS](bigID (fun j : 'I_(n i).+1 => at_least (n i) (p i) j <= a)) /= addrC.
rewrite [X in X <= _](eq_bigl (fun j : 'I_(n i).+1 => (at_most (n i) (p i) j <= b) && ~~ (at_least (n i) (p i) j <= a))).
  by rewrite ler_addl; apply: sumr_ge0.
by move=> j; rewrite /rare_at; case: (_ <= a); rewrite ?andbF ?orbF.
Qed.

(* Whatever holds between cells, the errors of all ends add up. *)
Theorem rare_sum (a b : I -> R) : (forall i, 0 <= a i) -> (forall i, 0 <= b i) -> prob P (rare a b) <= \sum_i (a i + b i).
Proof.
move=> a0 b0; apply: le_trans (_ : \sum_i prob P [set w | rare_at (a i) (b i) i (count i w)] <= _); last first.
  by apply: ler_sum => i _; apply: prob_rare_at.
rewrite (eq_bigr (fun i => \sum_w (rare_at (a i) (b i) i (count i w))%:R * P w)) => [|i _]; last first.
  rewrite /prob big_mkcond; apply: eq_bigr => w _; rewrite inE.
  by case: ifP; rewrite ?mul1r ?mul0r.
rewrite exchange_big /prob [leLHS]big_mkcond /=; apply: ler_sum => w _; have P0 : 0 <= P w by case: lawP.
case: ifP => [|_]; last by apply: sumr_ge0 => i _; rewrite mulr_ge0 ?ler0n.
rewrite inE => /existsP[i ri]; rewrite (bigD1 i) //= ri mul1r ler_addl.
by apply: sumr_ge0 => j _; rewrite mulr_ge0 ?ler0n.
Qed.

Lemma prob_setC (S : {set W}) : prob P (~: S) = 1 - prob P S.
Proof.
rewrite -(proj2 lawP) (bigID (mem S)) /= /prob [X in _ = X - _]addrC addrK.
by apply: eq_bigl => w; rewrite inE.
Qed.

(* If cells are independent, all ends are right with at least the product of the chances of each cell. *)
Theorem rare_product (a b : I -> R) : independent_counts -> (forall i, 0 <= a i) -> (forall i, 0 <= b i) -> (forall i, a i + b i <= 1) ->
  prob P (rare a b) <= 1 - \prod_i (1 - a i - b i).
Proof.
move=> ind a0 b0 ab1; rewrite ler_subr_addl -ler_subr_addr -prob_setC.
rewrite (_ : ~: _ = [set w | [forall i, ~~ rare_at (a i) (b i) i (count i w)]]); last first.
  by apply/setP => w; rewrite !inE negb_exists.
rewrite (ind (fun i j => ~~ rare_at (a i) (b i) i j)); apply: ler_prod => i _.
rewrite -addrA -opprD subr_ge0 ab1 /=.
rewrite (_ : [set w | _] = ~: [set w | rare_at (a i) (b i) i (count i w)]); last by apply/setP => w; rewrite !inE.
by rewrite prob_setC ler_add2l ler_opp2 prob_rare_at.
Qed.

End Ends.
