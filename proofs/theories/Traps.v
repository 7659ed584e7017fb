(* The traps of the theory page: what fails when a condition is dropped, as counterexamples over any ordered field. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T1 T3.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Traps.
Variable R : realFieldType.
Definition half : R := 2%:R^-1.

Lemma half_gt0 : 0 < half. Proof. by rewrite invr_gt0 ltr0n. Qed.
Lemma half2 : half + half = 1.
Proof. by rewrite -mulr2n -(mulr_natl half 2) divff // pnatr_eq0. Qed.
Lemma half_le1 : half <= 1. Proof. by rewrite -half2 ler_addl ltW // half_gt0. Qed.

Lemma fair_coin : law (fun _ : bool => half).
Proof. by split=> [b|]; [rewrite ltW // half_gt0|rewrite big_bool /= half2]. Qed.

(* -- Trap: the floor must stand under the denominator. --

   A filter that is (0, 1/2)-private, a utility that ignores the group with gamma = 1.  The group of the
   numerator has the floor 1/2, so T1 would give R <= 1 + (1/2)/(1/2) = 2; but the other group gets
   nothing, and no finite bound holds. *)
Definition leaky (a b : bool) : R := if a then half else (~~ b)%:R.

Theorem trap_floor_at_numerator :
  let E := utility (induced (@no_context R unit_finType) leaky (grant (point R true))) (granted 0 1) in
  [/\ kernel leaky, every_pair (dp 1 half) leaky, policy (grant (point R true)), half <= E tt true /\ E tt false = 0
      & forall r, ~ local_le r E].
Proof.
have kl : kernel leaky.
  move=> a; split=> [b|]; first by rewrite /leaky; case: a; rewrite ?ler0n // ltW // half_gt0.
  by rewrite big_bool /leaky; case: a; rewrite /= ?half2 ?add0r.
have e a : utility (induced (@no_context R unit_finType) leaky (grant (point R true))) (granted 0 1) tt a = leaky a true.
  by rewrite utility_grant // add0r subr0 mul1r expect_pointr.
rewrite /=; split=> //.
- move=> a a'; apply/dp_hockey_stick; rewrite /hockey_stick big_bool /leaky !mul1r.
  have h0 := half_gt0; have h1 := half_le1.
  case: a; case: a' => /=; rewrite ?subrr ?maxxx ?addr0 ?subr0 ?sub0r //; try exact: ltW.
  + rewrite (max_idPr _) ?(ltW h0) // (max_idPl _) ?addr0 // subr_le0 //.
  + rewrite (max_idPl _) ?oppr_le0 ?(ltW h0) // add0r (max_idPr _) ?subr_ge0 //.
    by rewrite ler_subl_addr half2.
- apply: policy_grant => b; rewrite /point; case: (b == true); rewrite ?lexx ?ler01 //.
- by rewrite !e.
- move=> r /(_ tt true false); rewrite !e /= mulr0 leNgt half_gt0.
  by [].
Qed.

(* -- Trap: shared randomness breaks assumption M. --

   One fair coin W drives both filters: Xt = W, At = A xor W.  Each filter alone releases a fair coin,
   whatever x and a are (eps = 0).  The policy U = Xt xor At decides by the group: R = infinity. *)
Definition shared_law (x : unit) (a u : bool) : R := \sum_(w : bool) half * (u == (w (+) (a (+) w)))%:R.

Theorem trap_shared_randomness :
  [/\ forall (x : unit) y, \sum_(w : bool) half * (y == w)%:R = half,
      forall a y, \sum_(w : bool) half * (y == (a (+) w))%:R = half,
      forall x, kernel (shared_law x) &
      let E := utility shared_law (granted 0 1) in
      E tt true = 1 /\ E tt false = 0 /\ forall r, ~ local_le r E].
Proof.
have law_eq x a u : shared_law x a u = (u == a)%:R.
  rewrite /shared_law big_bool /= -mulrDr.
  by case: a; case: u => /=; rewrite ?addr0 ?mulr0 // mulrDr mulr1 half2.
have E a : utility shared_law (granted 0 1) tt a = a%:R.
  rewrite /utility /expect big_bool /= !law_eq /granted /= mulr1 mulr0 addr0.
  by case: a.
split.
- by move=> x y; rewrite big_bool /= -mulrDr; case: y; rewrite /= ?addr0 ?add0r mulr1.
- by move=> a y; rewrite big_bool /= -mulrDr; case: a; case: y; rewrite /= ?addr0 ?add0r mulr1.
- move=> x a; split=> [u|]; first by rewrite law_eq ler0n.
  by rewrite big_bool !law_eq; case: a; rewrite /= ?addr0 ?add0r.
rewrite /= !E; split=> //; split=> // r /(_ tt true false).
by rewrite !E mulr0 leNgt ltr01.
Qed.

(* -- Trap: equal treatment in every context is not global fairness. --

   Everybody in context true gets 1, everybody in context false gets 0 (L = 0); group true lives in
   context true, group false in both alike.  The group means are 1 and 1/2: Lbar = log 2. *)
Definition by_context (x a : bool) (u : bool) : R := (u == x)%:R.
Definition spread (a x : bool) : R := if a then x%:R else half.

Theorem trap_local_zero_global_positive :
  let E := utility by_context (granted 0 1) in
  [/\ forall x, kernel (by_context x), kernel spread, local_le 1 E,
      group_mean spread E true = 2%:R * group_mean spread E false & 0 < group_mean spread E false].
Proof.
have E x a : utility by_context (granted 0 1) x a = x%:R.
  rewrite /utility /expect big_bool /by_context /granted /= mulr1 mulr0 addr0.
  by case: x.
have m a : group_mean spread (utility by_context (granted 0 1)) a = spread a true.
  by rewrite /group_mean big_bool /= !E mulr1 mulr0 addr0.
rewrite /=; split.
- move=> x a; split=> [u|]; first by rewrite ler0n.
  by rewrite big_bool /by_context; case: x; rewrite /= ?addr0 ?add0r.
- move=> a; split=> [x|]; rewrite /spread; first by case: a; rewrite ?ler0n // ltW // half_gt0.
  by case: a; rewrite big_bool /= ?addr0 // half2.
- by move=> x a a'; rewrite !E mul1r.
- by rewrite !m /= divff // pnatr_eq0.
- by rewrite m /= half_gt0.
Qed.

(* -- Trap: the floor of one policy does not serve another. --

   At t = 1 the bound of T3 is 1: true of the policy that always grants.  Behind the same filter, with
   ratio k > 1, another policy with the same g has ratio k: the floor t = 1 was not its own. *)
Theorem trap_floor_of_another_policy (A At : finType) (MA : A -> At -> R) a a' b k :
  kernel MA -> MA a b = k * MA a' b -> 0 < MA a' b -> 1 < k ->
  let E phi := utility (induced (@no_context R unit_finType) MA (grant phi)) (granted 0 1) in
  [/\ has_floor 1 (E (fun=> 1)), local_le 1 (E (fun=> 1)) & ~ local_le 1 (E (point R b))].
Proof.
move=> kA e b0 k1 /=.
have E1 x c : utility (induced (@no_context R unit_finType) MA (grant (fun=> 1))) (granted 0 1) x c = 1.
  by rewrite utility_grant // add0r subr0 mul1r expect_cst.
split=> [x c|x c c'|/(_ tt a a')]; rewrite ?E1 ?mulr1 //.
rewrite !utility_grant // !add0r subr0 !mul1r !expect_pointr e leNgt.
by rewrite ltr_pmull // k1.
Qed.

(* -- Trap: a trade-off function that holds for one order of the pair does not cover the other. --

   P = (1/2, 1/2), Q = (0, 1).  The pair (P, Q) lies above f(alpha) = (1 - alpha)/2, so its ratio at
   t = 1/2 is at most (1 - f(1/2))/(1/2) = 3/2; in the other order it is 2. *)
Theorem trap_one_order :
  let P : bool -> R := fun=> half in let Q := point R true in let f := fun alpha : R => (1 - alpha) * half in
  [/\ above f P Q, (1 - f half) / half = 1 + half &
      exists phi, [/\ test phi, expect P phi = half & expect Q phi = 2%:R * expect P phi]].
Proof.
have h2 : 2%:R * half = 1 by rewrite divff // pnatr_eq0.
have hn : half != 0 by rewrite gt_eqF // half_gt0.
rewrite /=; split.
- move=> phi te; rewrite expect_point /expect big_bool.
  case/andP: (te false) => _ f1.
  have -> : 1 - (half * phi true + half * phi false) = (1 - phi true) * half + half * (1 - phi false).
    by rewrite -{1}half2; ring.
  by rewrite ler_addl mulr_ge0 ?subr_ge0 // ltW // half_gt0.
- by apply: (mulIf hn); rewrite divfK // -{1}half2; ring.
exists (point R true); split.
- by move=> b; rewrite /point; case: (b == true); rewrite ?lexx ?ler01.
- by rewrite expect_pointr.
- by rewrite !expect_pointr /point /= h2.
Qed.

End Traps.
