(* Ville's inequality on a finite alphabet, and the bets on the contrast of two groups within a unit.

   Reading key.  One letter of the alphabet U comes after the other, say what a unit gets in all groups; a history h is the word of those
   that came, the oldest first.  [K h u] is the probability that u comes after h, [chance h w] that the word w does.  [M h] is the
   capital after h; [ever b h w] says that it is at least b after h or at some time while w comes. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Ville.
Variables (R : realFieldType) (U : finType) (K : seq U -> U -> R) (M : seq U -> R).
Implicit Types (h w : seq U) (b : R).

Fixpoint chance h w : R := if w is u :: w then K h u * chance (rcons h u) w else 1.
Fixpoint ever b h w : bool := (b <= M h) || (if w is u :: w then ever b (rcons h u) w else false).

(* What is expected after one more letter is no more than what there is. *)
Definition supermartingale : Prop := forall h, \sum_u K h u * M (rcons h u) <= M h.

Hypothesis laws : forall h, law (K h).

Lemma sum_words n (F : seq U -> R) : \sum_(w : n.+1.-tuple U) F w = \sum_u \sum_(w : n.-tuple U) F (u :: w).
Proof.
rewrite pair_bigA /= (reindex (fun p : U * n.-tuple U => [tuple of p.1 :: p.2])) //.
exists (fun w : n.+1.-tuple U => (thead w, [tuple of behead w])) => [[u w] _|w _] /=; last by rewrite [RHS]tuple_eta.
by congr pair; apply: val_inj.
Qed.

Lemma sum_chance n h : \sum_(w : n.-tuple U) chance h w = 1.
Proof.
elim: n h => [|n IH] h; first by rewrite (big_pred1 [tuple]) // => w; apply/esym/eqP; exact: tuple0.
rewrite (sum_words n (chance h)) /= -(proj2 (laws h)); apply: eq_bigr => u _.
by rewrite -mulr_sumr IH mulr1.
Qed.

Lemma chance_ge0 h w : 0 <= chance h w.
Proof. by elim: w h => [|u w IH] h /=; rewrite ?ler01 ?mulr_ge0 //; case: (laws h). Qed.

Lemma law_chance n h : law (fun w : n.-tuple U => chance h w).
Proof. by split=> [w|]; [exact: chance_ge0|exact: sum_chance]. Qed.

(* In n steps a nonnegative supermartingale ever reaches b with at most the probability M [::] / b. *)
Theorem ville n b : (forall h, 0 <= M h) -> supermartingale -> 0 <= b ->
  b * prob (fun w : n.-tuple U => chance [::] w) [set w : n.-tuple U | ever b [::] w] <= M [::].
Proof.
move=> M0 super b0; rewrite /prob big_mkcond /=.
rewrite (eq_bigr (fun w : n.-tuple U => if ever b [::] w then chance [::] w else 0)) => [|w _]; last by rewrite inE.
elim: n [::] => [|n IH] h.
  rewrite (big_pred1 [tuple]) => [|w]; last by apply/esym/eqP; exact: tuple0.
  by rewrite /= orbF; case: ifP; rewrite ?mulr1 ?mulr0.
case: (boolP (b <= M h)) => [reached|not_yet].
  apply: le_trans reached; rewrite -[leRHS]mulr1 ler_wpmul2l // -(sum_chance n.+1 h); apply: ler_sum => w _.
  by case: ifP => // _; apply: chance_ge0.
rewrite (sum_words n (fun w => if ever b h w then chance h w else 0)) /=.
apply: le_trans (super h); rewrite mulr_sumr; apply: ler_sum => u _.
apply: (@le_trans _ _ (K h u * (b * \sum_(w : n.-tuple U) if ever b (rcons h u) w then chance (rcons h u) w else 0))); last first.
  by rewrite ler_wpmul2l //; case: (laws h).
rewrite mulrCA ler_wpmul2l // mulr_sumr; apply: ler_sum => w _; rewrite (negbTE not_yet) /=.
by case: ifP; rewrite ?mulr0.
Qed.
End Ville.

(* ---- Bets on the contrast of two groups within a unit ---- *)

Section Bets.
Variables (R : realFieldType) (U : finType) (K : seq U -> U -> R) (x y : U -> R) (r : R) (bets : seq R).
Implicit Types (l : R) (h : seq U).

Definition factor l u : R := 1 + l * (r * y u - x u).
Definition product l h : R := \prod_(u <- h) factor l u.
(* Each bet begins with an equal share of the capital 1. *)
Definition capital h : R := (\sum_(l <- bets) product l h) / (size bets)%:R.

Hypotheses (laws : forall h, law (K h)) (r0 : 0 <= r) (x1 : forall u, x u <= 1) (y0 : forall u, 0 <= y u).
Hypotheses (some : (0 < size bets)%N) (bets01 : forall l, l \in bets -> 0 <= l <= 1).
(* What comes next has, whatever came before, an expectation in the first group of at least r times that in the second. *)
Hypothesis null : forall h, r * expect (K h) y <= expect (K h) x.

Lemma factor_ge0 l u : l \in bets -> 0 <= factor l u.
Proof.
move=> /bets01/andP[l0 l1]; apply: (@le_trans _ _ (1 - l)); first by rewrite subr_ge0.
by rewrite ler_add2l -mulrN1 ler_wpmul2l // ler_oppl opprB (le_trans _ (x1 u)) // ler_subl_addr ler_addl mulr_ge0.
Qed.

Lemma factor_mean l h : l \in bets -> \sum_u K h u * factor l u <= 1.
Proof.
move=> /bets01/andP[l0 _].
have -> : \sum_u K h u * factor l u = 1 + l * (r * expect (K h) y - expect (K h) x).
  rewrite /expect -(proj2 (laws h)) !mulr_sumr -sumrB mulr_sumr -big_split /=.
  by apply: eq_bigr => u _; rewrite /factor; ring.
by rewrite -[leRHS]addr0 ler_add2l mulr_ge0_le0 // subr_le0.
Qed.

Lemma capital_ge0 h : 0 <= capital h.
Proof.
rewrite /capital; apply: divr_ge0; last exact: ler0n.
rewrite big_seq; apply: sumr_ge0 => l lin; rewrite /product.
by elim/big_ind: _ => [|a b|u _]; [exact: ler01|exact: mulr_ge0|exact: factor_ge0].
Qed.

Lemma capital_super : supermartingale K capital.
Proof.
move=> h; rewrite /capital (eq_bigr (fun u => \sum_(l <- bets) K h u * product l (rcons h u) / (size bets)%:R)) => [|u _]; last first.
  by rewrite -!mulr_suml -mulr_sumr -mulrA.
rewrite exchange_big /= mulr_suml !big_seq; apply: ler_sum => l lin.
rewrite -mulr_suml ler_wpmul2r ?invr_ge0 ?ler0n //.
rewrite (eq_bigr (fun u => K h u * factor l u * product l h)) => [|u _]; last by rewrite /product -cats1 big_cat big_seq1 /= -mulrA [_ * factor _ _]mulrC.
rewrite -mulr_suml ler_pimull ?factor_mean //.
by rewrite /product; elim/big_ind: _ => [|a b|u _]; [exact: ler01|exact: mulr_ge0|exact: factor_ge0].
Qed.

(* The mixture of the bets ever has 1/alpha with at most the probability alpha, however many letters come. *)
Theorem mixture_ville n alpha : 0 < alpha ->
  prob (fun w : n.-tuple U => chance K [::] w) [set w : n.-tuple U | ever capital alpha^-1 [::] w] <= alpha.
Proof.
move=> alpha0; have := @ville _ _ K capital laws n alpha^-1 capital_ge0 capital_super.
rewrite invr_ge0 ltW // => /(_ isT); rewrite ler_pdivr_mull // => bound.
apply: le_trans bound _; rewrite /capital (eq_bigr (fun=> 1)) => [|l _]; last by rewrite /product big_nil.
by rewrite big_const_seq count_predT iter_addr_0 divff ?mulr1 // pnatr_eq0 -lt0n.
Qed.
End Bets.
