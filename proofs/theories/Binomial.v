(* The binomial law, its tails, and why a tail at the true mean is seldom small.

   Reading key.  [successes n p j] is the chance of j successes in n independent draws, each a success with
   probability p; [at_most n p k] and [at_least n p k] are the two tails, the numbers T- and T+ of the page
   docs/certificate-samples.md at the mean p. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Binomial.
Variable R : realFieldType.
Implicit Types (n j k : nat) (p q b : R) (S : pred nat).

Definition successes n p j : R := 'C(n, j)%:R * p ^+ j * (1 - p) ^+ (n - j).
Definition at_most n p k : R := \sum_(j < k.+1) successes n p j.
Definition at_least n p k : R := \sum_(j < n.+1 | (k <= j)%N) successes n p j.

Lemma successes_ge0 n p j : 0 <= p <= 1 -> 0 <= successes n p j.
Proof. by case/andP=> p0 p1; rewrite /successes !mulr_ge0 ?ler0n ?exprn_ge0 ?subr_ge0. Qed.

Lemma successes_beyond n p j : (n < j)%N -> successes n p j = 0.
Proof. by move=> nj; rewrite /successes bin_small ?mul0r. Qed.

Lemma successesS n p j : successes n.+1 p j.+1 = p * successes n p j + (1 - p) * successes n p j.+1.
Proof.
rewrite /successes binS subSS natrD exprS; case: (ltnP j n) => jn.
  by rewrite -(subnSK jn) exprS; ring.
by rewrite (bin_small (_ : n < j.+1)%N) ?ltnS // !mul0r mulr0 addr0 add0r; ring.
Qed.

Lemma successes0 n p : successes n.+1 p 0 = (1 - p) * successes n p 0.
Proof. by rewrite /successes !bin0 !subn0 exprS; ring. Qed.

Lemma at_mostS n p k : at_most n.+1 p k.+1 = p * at_most n p k + (1 - p) * at_most n p k.+1.
Proof.
rewrite /at_most [LHS]big_ord_recl [X in _ = _ + _ * X]big_ord_recl mulrDr addrCA successes0; congr (_ + _).
by rewrite !mulr_sumr -big_split; apply: eq_bigr => i _; rewrite [LHS]successesS.
Qed.

Lemma at_most0 n p : at_most n.+1 p 0 = (1 - p) * at_most n p 0.
Proof. by rewrite /at_most !big_ord1 successes0. Qed.

Lemma at_most_none p k : at_most 0 p k = 1.
Proof.
rewrite /at_most big_ord_recl big1 => [|i _]; last by rewrite successes_beyond.
by rewrite /successes bin0 !expr0 !mulr1 addr0.
Qed.

Lemma at_most_le n p k j : 0 <= p <= 1 -> (k <= j)%N -> at_most n p k <= at_most n p j.
Proof.
move=> p01 kj; rewrite /at_most -!(big_mkord xpredT (successes n p)) (@big_cat_nat _ _ _ k.+1 0 j.+1) //= ler_addl.
by apply: sumr_ge0 => i _; apply: successes_ge0.
Qed.

Lemma at_most_all n p k : (n <= k)%N -> at_most n p k = 1.
Proof.
elim: n k => [|n IH] [|k] //; rewrite ?at_most_none // ltnS => nk.
by rewrite at_mostS !IH ?(leq_trans nk) //; ring.
Qed.

Lemma at_most_ge0 n p k : 0 <= p <= 1 -> 0 <= at_most n p k.
Proof. by move=> p01; apply: sumr_ge0 => i _; apply: successes_ge0. Qed.

(* The lower tail falls in the mean. *)
Theorem at_most_falls n k p q : 0 <= p -> p <= q -> q <= 1 -> at_most n q k <= at_most n p k.
Proof.
move=> p0 pq q1; have q0 := le_trans p0 pq; have p1 := le_trans pq q1.
elim: n k => [|n IH] [|k]; rewrite ?at_most_none // ?at_most0 ?at_mostS.
  by apply: ler_pmul => //; rewrite ?subr_ge0 ?ler_add2l ?ler_opp2 ?at_most_ge0 ?q0.
apply: (@le_trans _ _ (q * at_most n p k + (1 - q) * at_most n p k.+1)).
  by rewrite ler_add ?ler_wpmul2l ?subr_ge0.
have := @at_most_le n p k k.+1; rewrite p0 p1 leqnSn => /(_ isT isT); rewrite -subr_ge0 => d0.
rewrite -subr_ge0 (_ : _ - _ = (q - p) * (at_most n p k.+1 - at_most n p k)); last by ring.
by rewrite mulr_ge0 // subr_ge0.
Qed.

(* Successes and failures exchanged. *)
Lemma successes_flip n p j : (j <= n)%N -> successes n (1 - p) (n - j) = successes n p j.
Proof. by move=> jn; rewrite /successes bin_sub // subKn // subKr; ring. Qed.

Lemma at_least_flip n p k : (k <= n)%N -> at_least n p k = at_most n (1 - p) (n - k).
Proof.
move=> kn; rewrite /at_least /at_most -(big_mkord (fun j => k <= j)%N) -(big_mkord xpredT) big_nat_rev /=.
rewrite [RHS](big_nat_widen _ _ n.+1) ?ltnS ?leq_subr //= big_nat_cond [RHS]big_nat_cond.
apply: eq_big => [j|j /andP[/andP[_ jn] _]].
  rewrite add0n subSS; case: (ltnP j n.+1) => //=; rewrite ltnS => jn.
  by rewrite ltnS leq_subRL // [RHS]leq_subRL // addnC.
by rewrite add0n subSS -[in RHS](subKn (_ : j <= n)%N) // successes_flip ?leq_subr.
Qed.

Theorem at_least_rises n k p q : 0 <= p -> p <= q -> q <= 1 -> at_least n p k <= at_least n q k.
Proof.
move=> p0 pq q1; case: (leqP k n) => kn.
  by rewrite !at_least_flip // at_most_falls ?subr_ge0 ?ler_add2l ?ler_opp2 ?ler_subl_addr ?ler_addl.
by rewrite /at_least !big_pred0 // => j; apply/negbTE; rewrite -ltnNge (leq_ltn_trans _ kn) // -ltnS.
Qed.

Lemma at_least_le n p k j : 0 <= p <= 1 -> (k <= j)%N -> at_least n p j <= at_least n p k.
Proof.
move=> p01 kj; rewrite /at_least [leRHS](bigID (fun i : 'I_n.+1 => j <= i)%N) /=.
rewrite [X in X + _](eq_bigl (fun i : 'I_n.+1 => j <= i)%N) => [|i]; last first.
  by case: (leqP j i) => ji; rewrite ?andbF // (leq_trans kj ji).
by rewrite ler_addl; apply: sumr_ge0 => i _; apply: successes_ge0.
Qed.

(* Outcomes whose tail at the true mean is at most b have together at most the chance b: a tail is
   stochastically at least uniform. *)
Theorem rare_low n p b S : 0 <= p <= 1 -> 0 <= b -> (forall j, S j -> at_most n p j <= b) ->
  \sum_(j < n.+1 | S j) successes n p j <= b.
Proof.
move=> p01 b0 small; case: (boolP [exists j : 'I_n.+1, S j]) => [/existsP[j0 S0]|/existsPn none]; last first.
  by rewrite big_pred0 // => j; apply/negbTE/none.
have [m Sm top] := @arg_maxnP _ j0 (fun j : 'I_n.+1 => S j) (fun j : 'I_n.+1 => nat_of_ord j) S0.
apply: le_trans (small _ Sm); rewrite /at_most -(big_mkord xpredT) (big_nat_widen _ _ n.+1) ?ltn_ord //= big_mkord.
rewrite [leRHS](bigID (fun j : 'I_n.+1 => S j)) /= [X in _ <= X + _](eq_bigl (fun j : 'I_n.+1 => S j)) => [|j].
  by rewrite ler_addl; apply: sumr_ge0 => j _; apply: successes_ge0.
by case: (boolP (S j)) => Sj; rewrite ?andbF // andbT ltnS; apply: top.
Qed.

Theorem rare_high n p b S : 0 <= p <= 1 -> 0 <= b -> (forall j, S j -> at_least n p j <= b) ->
  \sum_(j < n.+1 | S j) successes n p j <= b.
Proof.
move=> p01 b0 small; case: (boolP [exists j : 'I_n.+1, S j]) => [/existsP[j0 S0]|/existsPn none]; last first.
  by rewrite big_pred0 // => j; apply/negbTE/none.
have [m Sm least] := @arg_minnP _ j0 (fun j : 'I_n.+1 => S j) (fun j : 'I_n.+1 => nat_of_ord j) S0.
apply: le_trans (small _ Sm); rewrite /at_least [leRHS](bigID (fun j : 'I_n.+1 => S j)) /=.
rewrite [X in _ <= X + _](eq_bigl (fun j : 'I_n.+1 => S j)) => [|j].
  by rewrite ler_addl; apply: sumr_ge0 => j _; apply: successes_ge0.
by case: (boolP (S j)) => Sj; rewrite ?andbF // andbT; apply: least.
Qed.

End Binomial.
