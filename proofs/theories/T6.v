(* T6: over all utilities that ignore the group the worst is a single decision. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions Ratios.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Pair.
Variables (R : realFieldType) (U : finType) (P Q : U -> R).

(* T6 for one ordered pair: the greatest ratio of probabilities bounds the ratio of all expectations of g >= 0. *)
Theorem T6_upper r (g : U -> R) : pure_dp r P Q -> (forall u, 0 <= g u) -> expect P g <= r * expect Q g.
Proof. by move=> PQ g0; apply: ratio_of_weights. Qed.

End Pair.

Section Local.
Variables (R : realFieldType) (X A U : finType) (P : X -> A -> U -> R).

(* The utility 1{u}, the same for everybody. *)
Definition decision (u0 u : U) (x : X) (a : A) : R := point R u0 u.

Lemma decision_free u0 : a_free (decision u0).
Proof. by []. Qed.

Lemma decision_ge0 u0 u x a : 0 <= decision u0 u x a.
Proof. exact: ler0n. Qed.

Lemma utility_decision u x a : utility P (decision u) x a = P x a u.
Proof. exact: expect_pointr. Qed.

(* T6, local: r bounds R for every utility g(u,x) >= 0 if and only if it bounds every ratio P(u|x,a)/P(u|x,a'). *)
Theorem T6_local r :
  (forall g, a_free g -> (forall u x a, 0 <= g u x a) -> local_le r (utility P g)) <->
  (forall x a a', pure_dp r (P x a) (P x a')).
Proof.
split=> [bound x a a' u|PQ g fg g0 x a a'].
  by have := bound _ (decision_free u) (decision_ge0 u) x a a'; rewrite !utility_decision.
rewrite /utility; apply: le_trans (T6_upper (PQ x a a') (fun u => g0 u x a)) _.
by rewrite (eq_expect (P' := P x a') (g' := fun u => g u x a')) // => u; apply: fg.
Qed.

(* It is attained: for 1{u} the ratio of the groups is that of the probabilities of u. *)
Theorem T6_attained x a a' u r :
  P x a u = r * P x a' u -> utility P (decision u) x a = r * utility P (decision u) x a'.
Proof. by rewrite !utility_decision. Qed.

(* A decision that one group gets and the other never makes the supremum infinite. *)
Theorem T6_zero_denominator x a a' u :
  0 < P x a u -> P x a' u = 0 -> forall r, ~ local_le r (utility P (decision u)).
Proof. by move=> P0 Q0 r /(_ x a a'); rewrite !utility_decision Q0 mulr0 leNgt P0. Qed.

(* If no such decision exists the supremum is a maximum: some decision, context and pair of groups attain it. *)
Theorem T6_exists : (forall x, kernel (P x)) -> (forall x a a' u, P x a' u = 0 -> P x a u = 0) ->
  forall (x0 : X) (a0 : A), exists x a a' u, let r := P x a u / P x a' u in
  [/\ 0 < P x a' u, utility P (decision u) x a = r * utility P (decision u) x a' &
      forall g, a_free g -> (forall u x a, 0 <= g u x a) -> local_le r (utility P g)].
Proof.
move=> kP null x0 a0.
have P_ge0 x a u : 0 <= P x a u by case: (kP x a).
have [u0 u0_gt0] : exists u, 0 < P x0 a0 u.
  apply/existsP; apply: contraT => /existsPn none.
  have := proj2 (kP x0 a0); rewrite big1 => [/eqP|u _]; first by rewrite eq_sym oner_eq0.
  by apply/eqP; rewrite eq_le P_ge0 leNgt none.
pose ratio (c : X * A * A * U) := P c.1.1.1 c.1.1.2 c.2 / P c.1.1.1 c.1.2 c.2.
pose seen (c : X * A * A * U) := 0 < P c.1.1.1 c.1.2 c.2.
have [[[[x a] a'] u] u_seen maximal] := @arg_maxP _ R _ (x0, a0, a0, u0) seen ratio u0_gt0.
exists x, a, a', u => r; split=> //.
  by rewrite !utility_decision /r divfK // gt_eqF.
apply/T6_local => y b b' v; have [v_seen|] := boolP (seen (y, b, b', v)).
  by have := maximal _ v_seen; rewrite /ratio /= ler_pdivr_mulr.
rewrite /seen /= lt_neqAle P_ge0 andbT negbK eq_sym => /eqP v0.
by rewrite v0 (null _ _ _ _ v0) mulr0.
Qed.

(* If g may depend on the group the supremum is infinite, however fair the law is: g = 1{a = a0}. *)
Theorem T6_group_dependent : (forall x, kernel (P x)) -> forall (x : X) (a0 a1 : A), a1 != a0 ->
  forall r, ~ local_le r (utility P (fun _ _ a => point R a0 a)).
Proof.
move=> kP x a0 a1 a10 r /(_ x a0 a1); rewrite /utility !(expect_cst _ (kP x _)).
by rewrite /point eqxx (negbTE a10) mulr0 leNgt ltr01.
Qed.

End Local.

Section Global.
Variables (R : realFieldType) (X A U : finType) (P : X -> A -> U -> R) (W : A -> X -> R).

(* P(u|a) and P(u,x|a), from the weights W a x = P(x|a). *)
Definition group_law (a : A) (u : U) : R := \sum_x W a x * P x a u.
Definition joint_law (a : A) (ux : U * X) : R := W a ux.2 * P ux.2 a ux.1.

Lemma group_mean_group_law (g : U -> R) a :
  group_mean W (utility P (fun u _ _ => g u)) a = expect (group_law a) g.
Proof.
rewrite /group_mean /utility /expect /group_law.
transitivity (\sum_x \sum_u W a x * (P x a u * g u)); first by apply: eq_bigr => x _; rewrite mulr_sumr.
rewrite exchange_big; apply: eq_bigr => u _; rewrite mulr_suml.
by apply: eq_bigr => x _; rewrite mulrA.
Qed.

Lemma group_mean_joint_law (g : U -> X -> R) a :
  group_mean W (utility P (fun u x _ => g u x)) a = expect (joint_law a) (fun ux => g ux.1 ux.2).
Proof.
rewrite /expect /joint_law -(pair_bigA _ (fun u x => W a x * P x a u * g u x)) exchange_big.
by apply: eq_bigr => x _; rewrite mulr_sumr; apply: eq_bigr => u _; rewrite mulrA.
Qed.

(* T6, global: over all g(u) >= 0 the supremum of the global ratio is max P(u|a)/P(u|a'). *)
Theorem T6_global r :
  (forall g : U -> R, (forall u, 0 <= g u) -> global_le r (group_mean W (utility P (fun u _ _ => g u)))) <->
  (forall a a', pure_dp r (group_law a) (group_law a')).
Proof.
split=> [bound a a' u|PQ g g0 a a']; last by rewrite !group_mean_group_law; apply: T6_upper.
have := bound (point R u) (fun v => ler0n _ _) a a'.
by rewrite !group_mean_group_law !expect_pointr.
Qed.

(* It is attained by 1{u}. *)
Theorem T6_global_attained a u :
  group_mean W (utility P (fun v _ _ => point R u v)) a = group_law a u.
Proof. by rewrite group_mean_group_law expect_pointr. Qed.

(* If g may depend on the context as well, the global supremum is max P(u,x|a)/P(u,x|a'): the composition of the
   groups is included. *)
Theorem T6_global_contexts r :
  (forall g : U -> X -> R, (forall u x, 0 <= g u x) ->
    global_le r (group_mean W (utility P (fun u x _ => g u x)))) <->
  (forall a a', pure_dp r (joint_law a) (joint_law a')).
Proof.
split=> [bound a a' ux|PQ g g0 a a']; last by rewrite !group_mean_joint_law; apply: T6_upper.
have := bound (fun u x => point R ux (u, x)) (fun u x => ler0n _ _) a a'.
have picks b : expect (joint_law b) (fun v => point R ux (v.1, v.2)) = joint_law b ux.
  by rewrite -[RHS]expect_pointr; apply: eq_bigr; case.
by rewrite !group_mean_joint_law !picks.
Qed.

(* The global supremum too is infinite once g may depend on the group. *)
Theorem T6_global_group_dependent : (forall x, kernel (P x)) -> (forall a, law (W a)) ->
  forall a0 a1 : A, a1 != a0 -> forall r, ~ global_le r (group_mean W (utility P (fun _ _ a => point R a0 a))).
Proof.
move=> kP lW a0 a1 a10 r /(_ a0 a1).
have mean a : group_mean W (utility P (fun _ _ a => point R a0 a)) a = point R a0 a.
  rewrite /group_mean -[RHS](expect_cst (point R a0 a) (lW a)).
  by apply: eq_bigr => x _; rewrite /utility (expect_cst _ (kP x a)).
by rewrite !mean /point eqxx (negbTE a10) mulr0 leNgt ltr01.
Qed.

End Global.
