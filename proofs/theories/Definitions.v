(* The objects of docs/theory.md, over finite alphabets and an arbitrary ordered
   field R (the rationals, the reals).  Nothing here is assumed: there are only
   definitions and lemmas about sums.

   Reading key.  Where the page writes e^eps, the files write a number k; where it
   writes log R, they write R.  A bound "the ratio E a / E a' is at most r" is
   written E a <= r * E a', which gives 0/0 and c/0 the meaning of the page: 0/0
   satisfies it for every r >= 0 (parity), c/0 with c > 0 for none (infinity).

   The alphabet A of the groups and the alphabet At of what a group filter releases are
   two types.  Theorems speak of all contexts in X and all groups in A; Partial.v has them
   for tables with missing cells and for groups without mass. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Sums.
Variable R : realFieldType.
Implicit Types (A B C X Xt At U : finType).

(* A probability law on a finite alphabet. *)
Definition law A (P : A -> R) : Prop := (forall a, 0 <= P a) /\ \sum_a P a = 1.

(* A table with rows that sum to one: a filter, or a policy. *)
Definition kernel A B (M : A -> B -> R) : Prop := forall a, law (M a).

(* The expectation of g under P, and the probability of a set. *)
Definition expect A (P g : A -> R) : R := \sum_a P a * g a.
Definition prob A (P : A -> R) (S : {set A}) : R := \sum_(a in S) P a.

(* phi takes values in [lo, hi]; a test takes values in [0, 1]. *)
Definition ranged A (lo hi : R) (phi : A -> R) : Prop := forall a, lo <= phi a <= hi.
Definition test A (phi : A -> R) : Prop := ranged 0 1 phi.

(* First M, then N. *)
Definition after A B (C : finType) (N : A -> B -> R) (M : B -> C -> R) (a : A) (c : C) : R :=
  \sum_b N a b * M b c.

(* Independent filters of two attributes: the filter of the tuple. *)
Definition both A B (A' B' : finType) (M : A -> A' -> R) (N : B -> B' -> R)
  (ab : A * B) (ab' : A' * B') : R := M ab.1 ab'.1 * N ab.2 ab'.2.

(* The filter that releases the truth, and the law that always gives a0. *)
Definition point A (a0 a : A) : R := (a == a0)%:R.
Definition identity A (a a' : A) : R := (a == a')%:R.

(* ---- Privacy of one ordered pair of rows P = M(.|a), Q = M(.|a') ---- *)

(* H_k(P,Q), the hockey-stick divergence. *)
Definition hockey_stick A (k : R) (P Q : A -> R) : R := \sum_a Num.max 0 (P a - k * Q a).

(* Total variation distance. *)
Definition tv A (P Q : A -> R) : R := hockey_stick 1 P Q.

(* (log k, delta)-differential privacy, over events. *)
Definition dp A (k delta : R) (P Q : A -> R) : Prop :=
  forall S : {set A}, prob P S <= k * prob Q S + delta.

(* Pure privacy: likelihood ratios are at most k. *)
Definition pure_dp A (k : R) (P Q : A -> R) : Prop := forall a, P a <= k * Q a.

(* The pair lies above the trade-off function f: 1 - E_P phi >= f(E_Q phi) for every test. *)
Definition above A (f : R -> R) (P Q : A -> R) : Prop :=
  forall phi, test phi -> f (expect Q phi) <= 1 - expect P phi.

(* No test of level t has more power than b. *)
Definition power_le A (t b : R) (P Q : A -> R) : Prop :=
  forall phi, test phi -> expect Q phi <= t -> expect P phi <= b.

(* A filter has a property when every ordered pair of its rows has it. *)
Definition every_pair A B (pair : (B -> R) -> (B -> R) -> Prop) (M : A -> B -> R) : Prop :=
  forall a a', pair (M a) (M a').

(* k-ary randomized response: the truth with probability p, each lie with probability q. *)
Definition krr_lie A (p : R) : R := (1 - p) / (#|A|%:R - 1).
Definition krr A (p : R) (a b : A) : R := if a == b then p else krr_lie A p.

(* ---- Policies behind filters, and what is measured ---- *)

(* P(u|x,a) = sum of M_X(y|x) M_A(b|a) T(u|y,b): assumption M is this formula. *)
Definition induced (X Xt A At U : finType) (MX : X -> Xt -> R) (MA : A -> At -> R)
    (T : Xt -> At -> U -> R) (x : X) (a : A) (u : U) : R :=
  \sum_y \sum_b MX x y * MA a b * T y b u.

(* T is a policy: a law of decisions for everything that can be shown. *)
Definition policy (Xt At U : finType) (T : Xt -> At -> U -> R) : Prop := forall y, kernel (T y).

(* E(x,a), the expected utility of a person with (x,a). *)
Definition utility (X A U : finType) (P : X -> A -> U -> R) (g : U -> X -> A -> R) (x : X) (a : A) : R :=
  expect (P x a) (fun u => g u x a).

(* The response h(x,b) of the policy: what a person with (x,a) can expect once b is shown. *)
Definition response (X Xt A At U : finType) (MX : X -> Xt -> R) (T : Xt -> At -> U -> R)
    (g : U -> X -> A -> R) (x : X) (a : A) (b : At) : R :=
  \sum_y \sum_u MX x y * T y b u * g u x a.

(* g does not depend on the group. *)
Definition a_free (X A U : finType) (g : U -> X -> A -> R) : Prop := forall u x a a', g u x a = g u x a'.

(* g takes values in [lo, hi]. *)
Definition valued (X A U : finType) (lo hi : R) (g : U -> X -> A -> R) : Prop :=
  forall u x a, lo <= g u x a <= hi.

(* The group mean, with weights W a x = P(x|a); independence of X and A. *)
Definition group_mean (X A : finType) (W : A -> X -> R) (E : X -> A -> R) (a : A) : R :=
  \sum_x W a x * E x a.
Definition independent (X A : finType) (W : A -> X -> R) : Prop := forall a a' x, W a x = W a' x.

(* Local g-fairness: exp L <= r.  Global g-fairness: exp Lbar <= r. *)
Definition local_le (X A : finType) (r : R) (E : X -> A -> R) : Prop := forall x a a', E x a <= r * E x a'.
Definition global_le (A : finType) (r : R) (E : A -> R) : Prop := forall a a', E a <= r * E a'.

(* Everybody who is compared has at least tau. *)
Definition has_floor (X A : finType) (tau : R) (E : X -> A -> R) : Prop := forall x a, tau <= E x a.

End Sums.

(* ---- Lemmas about sums ---- *)

Section Lemmas.
Variable R : realFieldType.
Implicit Types (A B C X Xt At U : finType).

Lemma eq_expect A (P P' g g' : A -> R) : P =1 P' -> g =1 g' -> expect P g = expect P' g'.
Proof. by move=> eP eg; apply: eq_bigr => a _; rewrite eP eg. Qed.

Lemma expectD A (P g h : A -> R) : expect P (fun a => g a + h a) = expect P g + expect P h.
Proof. by rewrite /expect -big_split; apply: eq_bigr => a _; rewrite mulrDr. Qed.

Lemma expectZ A (P g : A -> R) c : expect P (fun a => c * g a) = c * expect P g.
Proof. by rewrite /expect mulr_sumr; apply: eq_bigr => a _; rewrite mulrCA. Qed.

Lemma expectN A (P g : A -> R) : expect P (fun a => - g a) = - expect P g.
Proof. by rewrite /expect -sumrN; apply: eq_bigr => a _; rewrite mulrN. Qed.

Lemma expectB A (P g h : A -> R) : expect P (fun a => g a - h a) = expect P g - expect P h.
Proof. by rewrite expectD expectN. Qed.

Lemma expect_cst A (P : A -> R) c : law P -> expect P (fun=> c) = c.
Proof. by case=> _ P1; rewrite /expect -mulr_suml P1 mul1r. Qed.

Lemma expect_le A (P g h : A -> R) : law P -> (forall a, g a <= h a) -> expect P g <= expect P h.
Proof. by case=> P0 _ gh; apply: ler_sum => a _; rewrite ler_wpmul2l. Qed.

Lemma expect_ge0 A (P g : A -> R) : law P -> (forall a, 0 <= g a) -> 0 <= expect P g.
Proof. by case=> P0 _ g0; apply: sumr_ge0 => a _; rewrite mulr_ge0. Qed.

Lemma expect_ranged A (P g : A -> R) lo hi : law P -> ranged lo hi g -> lo <= expect P g <= hi.
Proof.
move=> lP rg; rewrite -{1}(expect_cst lo lP) -{1}(expect_cst hi lP).
by apply/andP; split; apply: expect_le => // a; case/andP: (rg a).
Qed.

Lemma expect_diff A (P Q g : A -> R) k :
  expect P g - k * expect Q g = \sum_a (P a - k * Q a) * g a.
Proof.
rewrite /expect mulr_sumr -sumrB; apply: eq_bigr => a _.
by rewrite mulrBl mulrA.
Qed.

Lemma expect_point A (g : A -> R) a0 : expect (point R a0) g = g a0.
Proof.
rewrite /expect (bigD1 a0) //= big1 => [|a /negbTE na]; rewrite /point ?eqxx ?mul1r ?addr0 //.
by rewrite na mul0r.
Qed.

Lemma expect_pointr A (P : A -> R) a0 : expect P (point R a0) = P a0.
Proof. by rewrite -[RHS](expect_point P a0); apply: eq_bigr => a _; rewrite mulrC. Qed.

Lemma law_le1 A (P : A -> R) a : law P -> P a <= 1.
Proof.
case=> P0 <-; rewrite (bigD1 a) //= ler_addl.
by apply: sumr_ge0.
Qed.

Lemma prob_expect A (P : A -> R) (S : {set A}) : prob P S = expect P (fun a => (a \in S)%:R).
Proof.
rewrite /prob /expect big_mkcond; apply: eq_bigr => a _.
by case: (a \in S); rewrite ?mulr1 ?mulr0.
Qed.

Lemma test_indicator A (S : {set A}) : test (fun a => (a \in S)%:R : R).
Proof. by move=> a; case: (a \in S); rewrite ?lexx ?ler01. Qed.

Lemma test_cst A (c : R) : 0 <= c <= 1 -> test (fun _ : A => c).
Proof. by move=> c01 a. Qed.

Lemma test_neg A (phi : A -> R) : test phi -> test (fun a => 1 - phi a).
Proof.
move=> t a; case/andP: (t a) => p0 p1.
by rewrite subr_ge0 p1 /= ler_subl_addr ler_addl.
Qed.

Lemma test_scale A (phi : A -> R) c : 0 <= c <= 1 -> test phi -> test (fun a => c * phi a).
Proof.
move=> /andP[c0 c1] t a; case/andP: (t a) => p0 p1.
by rewrite mulr_ge0 //= mulr_ile1.
Qed.

Lemma law_point A (a0 : A) : law (point R a0).
Proof.
split=> [a|]; first by rewrite /point ler0n.
rewrite (bigD1 a0) //= big1 => [|a /negbTE na]; rewrite /point ?eqxx ?addr0 //.
by rewrite na.
Qed.

Lemma kernel_identity A : kernel (@identity R A).
Proof.
move=> a; split=> [b|]; first by rewrite /identity ler0n.
rewrite (bigD1 a) //= big1 => [|b /negbTE nb]; rewrite /identity ?eqxx ?addr0 //.
by rewrite eq_sym nb.
Qed.

Lemma kernel_after A B C (N : A -> B -> R) (M : B -> C -> R) :
  kernel N -> kernel M -> kernel (after N M).
Proof.
move=> kN kM a; split=> [c|].
  by apply: sumr_ge0 => b _; rewrite mulr_ge0 //; [case: (kN a)|case: (kM b)].
rewrite exchange_big -[RHS](proj2 (kN a)); apply: eq_bigr => b _.
by rewrite -mulr_sumr (proj2 (kM b)) mulr1.
Qed.

Lemma kernel_both A B A' B' (M : A -> A' -> R) (N : B -> B' -> R) :
  kernel M -> kernel N -> kernel (both M N).
Proof.
move=> kM kN ab; split=> [ab'|].
  by rewrite mulr_ge0 //; [case: (kM ab.1)|case: (kN ab.2)].
rewrite /both -(pair_bigA _ (fun a' b' => M ab.1 a' * N ab.2 b')) /=.
rewrite -[RHS](proj2 (kM ab.1)); apply: eq_bigr => a' _.
by rewrite -mulr_sumr (proj2 (kN ab.2)) mulr1.
Qed.

Lemma kernel_induced X Xt A At U (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R) x :
  kernel MX -> kernel MA -> policy T -> kernel (induced MX MA T x).
Proof.
move=> kX kA kT a; split=> [u|].
  apply: sumr_ge0 => y _; apply: sumr_ge0 => b' _; rewrite !mulr_ge0 //.
  - by case: (kX x).
  - by case: (kA a).
  - by case: (kT y b').
rewrite exchange_big /= -[RHS](proj2 (kX x)); apply: eq_bigr => y _.
rewrite exchange_big /= -[RHS]mulr1 -(proj2 (kA a)) mulr_sumr; apply: eq_bigr => b' _.
by rewrite -mulr_sumr (proj2 (kT y b')) mulr1.
Qed.

(* E(x,a) is the mean of the response under the row of the group filter. *)
Lemma utility_response X Xt A At U (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R)
    (g : U -> X -> A -> R) x a :
  utility (induced MX MA T) g x a = expect (MA a) (response MX T g x a).
Proof.
rewrite /utility /expect /induced /response.
transitivity (\sum_u \sum_y \sum_b MX x y * MA a b * T y b u * g u x a).
  apply: eq_bigr => u _; rewrite mulr_suml; apply: eq_bigr => y _.
  by rewrite mulr_suml.
rewrite exchange_big /=.
transitivity (\sum_y \sum_b \sum_u MX x y * MA a b * T y b u * g u x a).
  by apply: eq_bigr => y _; rewrite exchange_big.
rewrite exchange_big /=; apply: eq_bigr => b' _.
rewrite mulr_sumr; apply: eq_bigr => y _.
by rewrite mulr_sumr; apply: eq_bigr => u _; ring.
Qed.

Lemma response_free X Xt A At U (MX : X -> Xt -> R) (T : Xt -> At -> U -> R)
    (g : U -> X -> A -> R) x a a' :
  a_free g -> response MX T g x a =1 response MX T g x a'.
Proof.
by move=> fg b'; apply: eq_bigr => y _; apply: eq_bigr => u _; rewrite (fg u x a a').
Qed.

(* The response is the mean of g under a law, hence lies where g lies. *)
Lemma response_expect X Xt A At U (MX : X -> Xt -> R) (T : Xt -> At -> U -> R)
    (g : U -> X -> A -> R) x a b' :
  response MX T g x a b' = expect (MX x) (fun y => expect (T y b') (fun u => g u x a)).
Proof.
apply: eq_bigr => y _; rewrite /expect mulr_sumr.
by apply: eq_bigr => u _; rewrite mulrA.
Qed.

Lemma response_ranged X Xt A At U (MX : X -> Xt -> R) (T : Xt -> At -> U -> R)
    (g : U -> X -> A -> R) x a lo hi :
  kernel MX -> policy T -> valued lo hi g -> ranged lo hi (response MX T g x a).
Proof.
move=> kX kT vg b'; rewrite response_expect.
apply: expect_ranged => [|y]; first exact: kX.
by apply: expect_ranged => [|u]; [exact: kT|exact: vg].
Qed.

Lemma response_le X Xt A At U (MX : X -> Xt -> R) (T : Xt -> At -> U -> R)
    (g : U -> X -> A -> R) x a a' K b' :
  kernel MX -> policy T -> (forall u, g u x a <= g u x a' + K) ->
  response MX T g x a b' <= response MX T g x a' b' + K.
Proof.
move=> kX kT gK; rewrite !response_expect -{1}(expect_cst K (kX x)) -expectD.
apply: expect_le => // y; rewrite -(expect_cst K (kT y b')) -expectD.
by apply: expect_le => //; exact: kT.
Qed.

End Lemmas.
