(* T5: from local to global fairness.  W a x = P(x|a) are the compositions of the groups. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP Ratios T1.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Composition.
Variables (R : realFieldType) (X A : finType) (W : A -> X -> R) (E : X -> A -> R).
Hypothesis lW : forall a, law (W a).

(* T5.1: if X and A are independent, the global ratio is at most the local one. *)
Theorem T5_independent r : independent W -> local_le r E -> global_le r (group_mean W E).
Proof.
move=> ind fair a a'; rewrite /group_mean.
rewrite (eq_bigr (fun x => W a' x * E x a)) => [|x _]; last by rewrite (ind a a').
by apply: ratio_of_means => // x; case: (lW a').
Qed.

(* T5.2: always, the global ratio is at most the greatest ratio of P(x|a)E(x,a) to P(x|a')E(x,a'). *)
Theorem T5_general r : (forall x a a', W a x * E x a <= r * (W a' x * E x a')) -> global_le r (group_mean W E).
Proof. by move=> bound a a'; apply: ratio_of_sums. Qed.

(* ... which is at most R times the greatest ratio of P(x|a) to P(x|a'). *)
Theorem T5_general_global r c : (forall x a, 0 <= E x a) -> local_le r E -> every_pair (pure_dp c) W ->
  global_le (r * c) (group_mean W E).
Proof.
move=> E0 fair comp; apply: T5_general => x a a'.
apply: (@le_trans _ _ (c * W a' x * E x a)); first by rewrite ler_wpmul2r ?comp.
have -> : r * c * (W a' x * E x a') = c * W a' x * (r * E x a') by ring.
apply: ler_wpmul2l; last exact: fair.
by apply: le_trans (comp a a' x); case: (lW a).
Qed.

End Composition.

Section Filters.
Variables (R : realFieldType) (X Xt A At U : finType) (W : A -> X -> R).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R).
Hypotheses (lW : forall a, law (W a)) (kX : kernel MX) (kA : kernel MA) (kT : policy T).

(* T5.1 with T2: independent X and A, a utility that ignores the group, a purely eps-private group filter. *)
Theorem T5_independent_filter k (g : U -> X -> A -> R) :
  independent W -> (forall u x a, 0 <= g u x a) -> a_free g -> every_pair (pure_dp k) MA ->
  global_le k (group_mean W (utility (induced MX MA T) g)).
Proof. by move=> ind g0 fg dpA; apply: T5_independent => //; apply: T2_pure. Qed.

(* ---- T5.3: utilities of the decision alone ---- *)

Variable g : U -> R.
Hypothesis g0 : forall u, 0 <= g u.
Let E := utility (induced MX MA T) (fun u _ _ => g u).

(* after W MX a y = P(y|a), the law of the released context in group a.  By assumption M the two releases are
   independent given the group. *)
Lemma group_mean_released a :
  group_mean W E a = \sum_y after W MX a y * expect (MA a) (fun b => expect (T y b) g).
Proof.
rewrite /group_mean.
transitivity (\sum_x \sum_y W a x * (MX x y * expect (MA a) (fun b => expect (T y b) g))).
  apply: eq_bigr => x _; rewrite -mulr_sumr; congr (_ * _); rewrite /E utility_response.
  transitivity (\sum_b \sum_y MA a b * (MX x y * expect (T y b) g)).
    by apply: eq_bigr => b _; rewrite response_expect -mulr_sumr.
  rewrite exchange_big; apply: eq_bigr => y _; rewrite mulr_sumr.
  by apply: eq_bigr => b _; rewrite mulrCA.
rewrite exchange_big; apply: eq_bigr => y _; rewrite /after mulr_suml.
by apply: eq_bigr => x _; rewrite mulrA.
Qed.

(* T5.3: R-bar <= e^(eps_A) times the greatest ratio of released contexts, P(y|a) to P(y|a'). *)
Theorem T5_decision k c : every_pair (pure_dp k) MA -> every_pair (pure_dp c) (after W MX) ->
  global_le (k * c) (group_mean W E).
Proof.
move=> dpA dpW a a'; rewrite !group_mean_released; apply: ratio_of_sums => y.
have T0 b : 0 <= expect (T y b) g by apply: expect_ge0 => //; apply: kT.
have mean0 b : 0 <= expect (MA b) (fun b => expect (T y b) g) by apply: expect_ge0 => //; apply: kA.
have -> : k * c * (after W MX a' y * expect (MA a') (fun b => expect (T y b) g))
        = c * after W MX a' y * (k * expect (MA a') (fun b => expect (T y b) g)) by ring.
apply: ler_pmul => //; last by apply: ratio_of_weights => // b; apply: dpA.
  by apply: sumr_ge0 => x _; rewrite mulr_ge0 ?(proj1 (lW a)) ?(proj1 (kX x)).
exact: dpW.
Qed.

(* The second factor is at most e^(eps_X) and at most the greatest ratio of P(x|a) to P(x|a'). *)
Lemma released_by_filter kx : every_pair (pure_dp kx) MX -> every_pair (pure_dp kx) (after W MX).
Proof.
move=> dpX a a' y; rewrite /after.
apply: mean_le => [x||x]; [by case: (lW a)|by case: (lW a)|].
rewrite mulr_sumr; under eq_bigr do rewrite mulrCA.
by apply: mean_ge => [x'||x']; [case: (lW a')|case: (lW a')|apply: dpX].
Qed.

Lemma released_by_composition c : every_pair (pure_dp c) W -> every_pair (pure_dp c) (after W MX).
Proof. by move=> dpW a a' y; apply: ratio_of_weights => x; [case: (kX x)|apply: dpW]. Qed.

Theorem T5_decision_min k kx c :
  every_pair (pure_dp k) MA -> every_pair (pure_dp kx) MX -> every_pair (pure_dp c) W ->
  global_le (k * Num.min kx c) (group_mean W E).
Proof.
move=> dpA dpX dpW; apply: T5_decision => // a a' y.
by apply: le_min_mul; [apply: released_by_filter|apply: released_by_composition].
Qed.

End Filters.

(* ---- T5.4: a floor under the group means ---- *)

Section Floor.
Variables (R : realFieldType) (X Xt A At U : finType) (W : A -> X -> R).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R) (g : U -> X -> A -> R).
Hypotheses (lW : forall a, law (W a)) (kX : kernel MX) (kA : kernel MA) (kT : policy T).

(* The rows P(x|a) M_A(b|a), in place of those of M_A. *)
Definition context_release (a : A) (xb : X * At) : R := W a xb.1 * MA a xb.2.

Lemma kernel_context_release : kernel context_release.
Proof.
move=> a; split=> [xb|]; first by rewrite mulr_ge0 ?(proj1 (lW a)) ?(proj1 (kA a)).
rewrite /context_release -(pair_bigA _ (fun x b => W a x * MA a b)) -[RHS](proj2 (lW a)).
by apply: eq_bigr => x _; rewrite -mulr_sumr (proj2 (kA a)) mulr1.
Qed.

Lemma group_mean_context_release a0 a : a_free g ->
  group_mean W (utility (induced MX MA T) g) a =
  expect (context_release a) (fun xb => response MX T g xb.1 a0 xb.2).
Proof.
move=> fg; rewrite /expect /context_release.
rewrite -(pair_bigA _ (fun x b => W a x * MA a b * response MX T g x a0 b)); apply: eq_bigr => x _.
rewrite utility_response mulr_sumr; apply: eq_bigr => b _.
by rewrite mulrA (response_free MX T x a a0 fg).
Qed.

(* T5.4: T3's certificate with these rows.  With gamma = max g, a floor tau under the group mean of a', and any k:
   R-bar <= k + gamma H_k / tau; T3's exactness of the best k applies to the rows as they stand. *)
Theorem T5_floor gamma tau k a a' : a_free g -> 0 <= gamma -> valued 0 gamma g ->
  0 < tau -> tau <= group_mean W (utility (induced MX MA T) g) a' ->
  group_mean W (utility (induced MX MA T) g) a <=
    (k + gamma * hockey_stick k (context_release a) (context_release a') / tau)
    * group_mean W (utility (induced MX MA T) g) a'.
Proof.
move=> fg gamma0 vg tau0 floor; apply: ratio_of_additive => //; first by rewrite mulr_ge0 ?hockey_stick_ge0.
rewrite !(group_mean_context_release a' _ fg).
have := hockey_stick_ranged k (kernel_context_release a) (kernel_context_release a')
  (h := fun xb => response MX T g xb.1 a' xb.2) (m := 0) (gamma := gamma).
rewrite mulr0 !subr0; apply=> xb; exact: response_ranged.
Qed.

End Floor.

(* ---- What fails without the assumptions ---- *)

Section Counterexamples.
Let spread (a x : bool) : rat := (if a == x then 3%:R else 1) / 4%:R.   (* three quarters meet their own context *)
Let yes (u : bool) (x a : bool) : rat := u%:R.

(* "Equal treatment in every context implies global fairness" is false: the open context says yes to everybody, the
   closed one to nobody, and R = 1 while R-bar = 3. *)
Let by_context (x a u : bool) : rat := (u == x)%:R.

Theorem T5_counterexample :
  [/\ kernel spread, forall x, kernel (by_context x), local_le 1 (utility by_context yes),
      group_mean spread (utility by_context yes) true = 3%:R * group_mean spread (utility by_context yes) false &
      0 < group_mean spread (utility by_context yes) false].
Proof.
split.
- by case; split=> [[]|] //; rewrite big_bool.
- by do 2!case; split=> [[]|] //; rewrite big_bool.
- by do 3!case; rewrite /utility /expect !big_bool.
- by rewrite /group_mean /utility /expect !big_bool.
- by rewrite /group_mean /utility /expect !big_bool.
Qed.

(* T5.3 is false for g(u,x): both filters release nothing, yet g = 1{x is the open context} has R-bar = 3.  A filter
   hides x from the policy, not from g. *)
Let nothing (x y : bool) : rat := 2%:R^-1.
Let always (y b u : bool) : rat := u%:R.
Let place (u x a : bool) : rat := x%:R.
Let placed := group_mean spread (utility (induced nothing nothing always) place).

Theorem T5_decision_counterexample :
  [/\ every_pair (pure_dp 1) nothing, every_pair (pure_dp 1) (after spread nothing), a_free place,
      placed true = 3%:R * placed false & 0 < placed false].
Proof.
split.
- by move=> a a' y; rewrite mul1r.
- by do 3!case; rewrite /after !big_bool.
- by [].
- by rewrite /placed /group_mean /utility /expect /induced !big_bool.
- by rewrite /placed /group_mean /utility /expect /induced !big_bool.
Qed.

(* At eps_A = 0 the composition of the groups remains: the group filter releases nothing, the policy reads the
   context, g is the decision alone, and R-bar = 3.  So some targets for R-bar cannot be met by filtering A. *)
Let remaining := group_mean spread (utility (induced (@identity _ [finType of bool]) nothing by_context) yes).

Theorem T5_residue_counterexample :
  [/\ every_pair (pure_dp 1) nothing, local_le 1 (utility (induced (@identity _ [finType of bool]) nothing by_context) yes),
      remaining true = 3%:R * remaining false & 0 < remaining false].
Proof.
split.
- by move=> a a' y; rewrite mul1r.
- by do 3!case; rewrite /utility /expect /induced !big_bool.
- by rewrite /remaining /group_mean /utility /expect /induced !big_bool.
- by rewrite /remaining /group_mean /utility /expect /induced !big_bool.
Qed.

End Counterexamples.
