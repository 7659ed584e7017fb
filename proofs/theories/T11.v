(* T11: an audit as refutation.  P is the law of decisions at true (x,a), measured end to end. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T1.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section T11.
Variables (R : realFieldType) (X A At U : finType).
Variables (P : X -> A -> U -> R) (MA : A -> At -> R).

(* Assumption M with the group filter M_A: some context filter and some policy that sees released values alone
   produce the law. *)
Definition assumption_M : Prop :=
  kernel MA /\ exists (Xt : finType) (MX : X -> Xt -> R) (T : Xt -> At -> U -> R),
    [/\ kernel MX, policy T & forall x a u, P x a u = induced MX MA T x a u].

Variable g : U -> X -> A -> R.
Hypotheses (fg : a_free g) (g0 : forall u x a, 0 <= g u x a).
Let E := utility P g.

(* T2 for the deployed law. *)
Lemma audit_bound k : assumption_M -> every_pair (pure_dp k) MA -> local_le k E.
Proof.
move=> [kA [Xt [MX [T [kX kT law_eq]]]]] dpA x a a'.
have same b : E x b = utility (induced MX MA T) g x b by apply: eq_expect => // u; apply: law_eq.
by rewrite !same; apply: T2_pure.
Qed.

(* T11: R > e^eps refutes that the filter is eps-private or that assumption M holds.  Where E(x,a') = 0 the premise
   says E(x,a) > 0; 0/0 satisfies no premise and is no evidence. *)
Theorem T11_refutation k x a a' : k * E x a' < E x a -> ~ (assumption_M /\ every_pair (pure_dp k) MA).
Proof. by move=> exceeds [holds dpA]; move: exceeds; rewrite ltNge audit_bound. Qed.

(* If assumption M is not in doubt, the filter is not eps-private ... *)
Theorem T11_not_private k x a a' : assumption_M -> k * E x a' < E x a -> ~ every_pair (pure_dp k) MA.
Proof. by move=> holds /T11_refutation no dpA; apply: no. Qed.

(* ... and if the filter is known to be eps-private, assumption M fails. *)
Theorem T11_not_assumption_M k x a a' : every_pair (pure_dp k) MA -> k * E x a' < E x a -> ~ assumption_M.
Proof. by move=> dpA /T11_refutation no holds; apply: no. Qed.

(* The test is sound.  Samples w have law D; ratio is at most the true R (at most every r >= 1 that bounds all ratios,
   so 0/0 counts as 1); lower w is a lower confidence limit of it at level 1 - alpha.  If the filter is eps-private
   and assumption M holds, rejecting where lower w > e^eps errs with probability at most alpha. *)
Theorem T11_test (Om : finType) (D : Om -> R) (lower : Om -> R) (ratio alpha k : R) (a0 : A) :
  law D -> (forall r, 1 <= r -> local_le r E -> ratio <= r) ->
  1 - alpha <= prob D [set w | lower w <= ratio] ->
  assumption_M -> every_pair (pure_dp k) MA ->
  prob D [set w | k < lower w] <= alpha.
Proof.
move=> [D0 D1] true_ratio covers holds dpA.
have k1 : 1 <= k by case: holds => kA _; apply: pure_dp_ge1 (dpA a0 a0).
have le_k : ratio <= k by apply: true_ratio => //; apply: audit_bound.
rewrite -[alpha](subKr 1); apply: le_trans (_ : 1 - prob D [set w | lower w <= ratio] <= _); last first.
  by rewrite ler_add2l ler_opp2.
rewrite ler_subr_addr -D1 /prob [X in X + _]big_mkcond [X in _ + X]big_mkcond -big_split.
apply: ler_sum => w _; rewrite !inE; case: (ltP k (lower w)) => h1 /=; last by rewrite add0r; case: ifP.
case: (leP (lower w) ratio) => h2; last by rewrite addr0.
by have := le_lt_trans (le_trans h2 le_k) h1; rewrite ltxx.
Qed.

End T11.
