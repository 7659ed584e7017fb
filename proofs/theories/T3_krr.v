(* T3 for k-ary randomized response: the closed form, that it bounds, and that it is attained. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T1 T3 T9.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Krr.
Variables (R : realFieldType) (A : finType).
Hypothesis two : (1 < #|A|)%N.
Variables (p t : R).
Local Notation n := (#|A|%:R : R).
Local Notation q := (krr_lie A p).
Hypotheses (p_lo : n^-1 <= p) (p_hi : p <= 1) (t0 : 0 < t) (t1 : t <= 1).

(* The closed form of the page, for p >= 1/k. *)
Definition krr_bound : R :=
  if t <= q then p / q else if t <= 1 - p then 1 + (p - q) / t else (1 - q / p * (1 - t)) / t.

Lemma krr_bound_small : t <= q -> krr_bound = p / q.
Proof. by rewrite /krr_bound => ->. Qed.

Lemma krr_bound_middle : q < t -> t <= 1 - p -> krr_bound = 1 + (p - q) / t.
Proof. by rewrite /krr_bound (leNgt t q) => -> ->. Qed.

Lemma krr_bound_large : q < t -> 1 - p < t -> krr_bound = (1 - q / p * (1 - t)) / t.
Proof. by rewrite /krr_bound !leNgt => -> ->. Qed.

Lemma p_gt0 : 0 < p.
Proof. by apply: lt_le_trans p_lo; rewrite invr_gt0 card_gt0. Qed.

Lemma lies : (n - 1) * q = 1 - p.
Proof. by rewrite mulrC divfK // gt_eqF // card1_gt0. Qed.

Lemma q_ge0 : 0 <= q.
Proof. by apply: divr_ge0; [rewrite subr_ge0|apply: ltW; apply: card1_gt0]. Qed.

Lemma q_le_p : q <= p.
Proof.
rewrite ler_pdivr_mulr ?card1_gt0 // mulrBr mulr1 ler_add2r mulrC.
by rewrite -ler_pdivr_mull ?card_gt0 // mulr1.
Qed.

Lemma krr_ge (a b : A) : q <= krr p a b :> R.
Proof. by rewrite /krr; case: (a == b) => //; apply: q_le_p. Qed.

Lemma krr_le (a b : A) : krr p a b <= p :> R.
Proof. by rewrite /krr; case: (a == b) => //; apply: q_le_p. Qed.

Lemma krrE (a b : A) : krr p a b = q + (p - q) * (a == b)%:R.
Proof.
by rewrite /krr; case: (a == b); rewrite ?mulr1 ?mulr0 ?addr0 // addrCA subrr addr0.
Qed.

Lemma kernel_krr : kernel (krr p : A -> A -> R).
Proof. by move=> a; apply: krr_law. Qed.

(* e^eps = p/q; delta = p - q at eps = 0; H_k = 1 - k at k = q/p. *)
Lemma krr_pure : 0 < q -> every_pair (pure_dp (p / q)) (krr p : A -> A -> R).
Proof.
move=> q0 a a' b; apply: le_trans (krr_le a b) _.
rewrite -[X in X <= _](divfK (x := q)) ?gt_eqF //.
by rewrite ler_pmul2l ?krr_ge //; apply: divr_gt0 => //; apply: p_gt0.
Qed.

Lemma krr_tv : every_pair (dp 1 (p - q)) (krr p : A -> A -> R).
Proof.
move=> a a'; apply/dp_hockey_stick.
apply: (@le_trans _ _ (\sum_b (p - q) * (a == b)%:R)); last first.
  by rewrite -mulr_sumr (proj2 (kernel_identity R a)) mulr1.
apply: ler_sum => b _; rewrite le_maxl mul1r mulr_ge0 ?ler0n ?subr_ge0 ?q_le_p //=.
by rewrite ler_subl_addr krrE addrC ler_add2l krr_ge.
Qed.

Lemma krr_low : every_pair (dp (q / p) (1 - q / p)) (krr p : A -> A -> R).
Proof.
move=> a a'; apply/dp_hockey_stick; rewrite /hockey_stick.
rewrite (eq_bigr (fun b => krr p a b - q / p * krr p a' b)) => [|b _].
  by rewrite sumrB -mulr_sumr (proj2 (kernel_krr a)) (proj2 (kernel_krr a')) mulr1.
apply/max_idPr; rewrite subr_ge0; apply: le_trans (krr_ge a b).
rewrite -[X in _ <= X](divfK (x := p)) ?gt_eqF ?p_gt0 //.
by apply: ler_wpmul2l; [rewrite divr_ge0 ?q_ge0 // ltW // p_gt0|exact: krr_le].
Qed.

Lemma krr_power a a' : power_le t (krr_bound * t) (krr p a) (krr p a' : A -> R).
Proof.
have tn : t != 0 by rewrite gt_eqF.
have p0 := p_gt0; have qp : 0 <= q / p by rewrite divr_ge0 ?q_ge0 // ltW.
case: (leP t q) => tq.
  have q0 : 0 < q := lt_le_trans t0 tq.
  rewrite krr_bound_small // -[_ * t]addr0; apply: power_dp.
    by rewrite divr_ge0 ?q_ge0 // ltW.
  by apply/pure_dp_dp; apply: krr_pure.
case: (leP t (1 - p)) => tp.
  rewrite krr_bound_middle // mulrDl divfK //.
  by apply: power_dp; [exact: ler01|exact: krr_tv].
rewrite krr_bound_large // divfK //.
have -> : 1 - q / p * (1 - t) = q / p * t + (1 - q / p) by ring.
by apply: power_dp => //; apply: krr_low.
Qed.

(* T3 for k-RR, one pair of groups: the floor is needed under the denominator only. *)
Theorem T3_krr_pair (X Xt U : finType) (MX : X -> Xt -> R) (T : Xt -> A -> U -> R) (g : U -> X -> A -> R)
    gamma x a a' :
  kernel MX -> policy T -> 0 < gamma -> valued 0 gamma g -> a_free g ->
  let E := utility (induced MX (krr p) T) g in t * gamma <= E x a' -> E x a <= krr_bound * E x a'.
Proof.
move=> kX kT g0 vg fg E fl.
have := T3_power kX kernel_krr kT g0 vg fg t0 (@krr_power a a') fl.
by rewrite mulfK // gt_eqF.
Qed.

(* T3 for k-RR: the closed form bounds R, for every policy that keeps the floor t gamma. *)
Theorem T3_krr (X Xt U : finType) (MX : X -> Xt -> R) (T : Xt -> A -> U -> R) (g : U -> X -> A -> R) gamma :
  kernel MX -> policy T -> 0 < gamma -> valued 0 gamma g -> a_free g ->
  has_floor (t * gamma) (utility (induced MX (krr p) T) g) ->
  local_le krr_bound (utility (induced MX (krr p) T) g).
Proof. by move=> kX kT g0 vg fg fl x a a'; apply: (@T3_krr_pair _ _ _ MX T g gamma). Qed.

Lemma expect_krr a (phi : A -> R) : expect (krr p a) phi = q * (\sum_b phi b) + (p - q) * phi a.
Proof.
rewrite -(expect_point phi a) /expect !mulr_sumr -big_split /=; apply: eq_bigr => b _.
by rewrite krrE /point (eq_sym a); ring.
Qed.

(* It is attained: by a test under which every group keeps the floor. *)
Lemma krr_attained_test (a0 a1 : A) : a0 != a1 -> exists phi : A -> R,
  [/\ test phi, forall a, t <= expect (krr p a) phi, expect (krr p a1) phi = t &
      expect (krr p a0) phi = krr_bound * t].
Proof.
move=> ne; have p0 := p_gt0; have qp := q_le_p; have q0 := q_ge0.
have pn : p != 0 by rewrite gt_eqF.
have tn : t != 0 by rewrite gt_eqF.
have pq0 : 0 <= p - q by rewrite subr_ge0.
have s1 b : \sum_a (a == b)%:R = 1 :> R := proj2 (law_point R b).
have nv c : \sum_(b : A) c = n * c :> R by apply: sum_cst.
case: (leP t q) => tq.
  have q1 : 0 < q := lt_le_trans t0 tq.
  have qn : q != 0 by rewrite gt_eqF.
  have d0 : 0 <= t / q by rewrite divr_ge0 // ltW.
  pose phi b : R := t / q * (b == a0)%:R.
  have E a : expect (krr p a) phi = t + (p - q) * (t / q) * (a == a0)%:R.
    by rewrite expect_krr /phi -mulr_sumr s1 mulr1 mulrC divfK // !mulrA.
  exists phi; split=> [b|a||].
  - rewrite /phi; case: (b == a0); rewrite ?mulr1 ?mulr0 ?lexx ?ler01 //.
    by rewrite d0 ler_pdivr_mulr // mul1r.
  - by rewrite E ler_addl mulr_ge0 ?ler0n // mulr_ge0.
  - by rewrite E eq_sym (negbTE ne) mulr0 addr0.
  - by rewrite E eqxx mulr1 krr_bound_small // mulrBl mulrA (mulrC q) divfK // addrCA subrr addr0 mulrAC.
case: (leP t (1 - p)) => tp.
  have n2 : 0 < n - 2%:R.
    rewrite subr_gt0 ltr_nat ltn_neqAle two andbT; apply/eqP => e.
    move: tp; rewrite -lies -e (_ : 2%:R - 1 = 1); last by ring.
    by rewrite mul1r leNgt tq.
  have q1 : 0 < q.
    rewrite lt_def q0 andbT; apply/eqP => e; move: tp; rewrite -lies e mulr0.
    by rewrite leNgt t0.
  have qn : q != 0 by rewrite gt_eqF.
  pose c := (t / q - 1) / (n - 2%:R).
  have c0 : 0 <= c by rewrite divr_ge0 ?(ltW n2) // subr_ge0 ler_pdivl_mulr // mul1r ltW.
  have c1 : c <= 1.
    rewrite ler_pdivr_mulr // mul1r ler_subl_addr ler_pdivr_mulr //.
    by rewrite (_ : n - 2%:R + 1 = n - 1) ?lies //; ring.
  pose phi b : R := c + (1 - c) * (b == a0)%:R - c * (b == a1)%:R.
  have E a : expect (krr p a) phi = t + (p - q) * phi a.
    rewrite expect_krr; congr (_ + _); rewrite sumrB big_split /= nv -!mulr_sumr !s1 !mulr1.
    have -> : n * c + (1 - c) - c = (n - 2%:R) * c + 1 by ring.
    by rewrite /c (mulrC _ (_ / _)) divfK ?gt_eqF // subrK mulrC divfK.
  have ph b : 0 <= phi b <= 1.
    rewrite /phi; case: (eqVneq b a0) => [->|_]; first by rewrite (negbTE ne) mulr1 mulr0 subr0 addrCA subrr addr0 ler01 lexx.
    by rewrite mulr0 addr0; case: (b == a1); rewrite ?mulr1 ?mulr0 ?subrr ?subr0 ?lexx ?ler01 ?c0 ?c1.
  exists phi; split=> // [a||].
  - by rewrite E ler_addl mulr_ge0 //; case/andP: (ph a).
  - by rewrite E /phi eqxx eq_sym (negbTE ne) mulr0 addr0 mulr1 subrr mulr0 addr0.
  - rewrite E /phi eqxx (negbTE ne) mulr0 subr0 mulr1 (addrCA c) subrr addr0 mulr1.
    by rewrite krr_bound_middle // mulrDl mul1r divfK.
pose c := (t - (1 - p)) / p.
have cp : c * p = t - (1 - p) by rewrite divfK.
have c0 : 0 <= c by rewrite divr_ge0 ?(ltW p0) // subr_ge0 ltW.
have c1 : c <= 1 by rewrite ler_pdivr_mulr // mul1r ler_subl_addr addrCA subrr addr0.
pose phi b : R := 1 - (1 - c) * (b == a1)%:R.
have E a : expect (krr p a) phi = 1 - p + q * c + (p - q) * phi a.
  rewrite expect_krr; congr (_ + _); rewrite sumrB -mulr_sumr s1 nv !mulr1 -lies.
  by ring.
have ph b : 0 <= phi b <= 1.
  rewrite /phi; case: (b == a1); rewrite ?mulr1 ?mulr0 ?subr0 ?lexx ?ler01 //.
  by rewrite opprB addrCA subrr addr0 c0 c1.
have E1 : expect (krr p a1) phi = t.
  rewrite E /phi eqxx mulr1 opprB addrCA subrr addr0.
  have -> : 1 - p + q * c + (p - q) * c = 1 - p + c * p by ring.
  by rewrite cp addrCA subrr addr0.
exists phi; split=> // [a|].
  have c1a : c <= phi a.
    rewrite /phi; case: (a == a1); rewrite ?mulr1 ?mulr0 ?subr0 //.
    by rewrite opprB addrCA subrr addr0.
  rewrite -E1 !E ler_add2l ler_wpmul2l // {1}/phi eqxx mulr1.
  by rewrite opprB addrCA subrr addr0.
rewrite E /phi (negbTE ne) mulr0 subr0 mulr1 krr_bound_large // divfK //.
have -> : q / p * (1 - t) = q * ((1 - t) / p) by rewrite mulrAC mulrA.
have -> : (1 - t) / p = 1 - c.
  by apply: (mulIf pn); rewrite divfK // mulrBl cp mul1r; ring.
by ring.
Qed.

Local Notation E gamma X phi :=
  (utility (induced (@no_context R X) (krr p) (grant phi)) (granted (X := X) (A := A) 0 gamma)).

(* The bound is attained by a policy under which every group keeps the floor. *)
Theorem T3_krr_attained (X : finType) gamma : 0 < gamma -> exists (phi : A -> R) (a a' : A),
  [/\ policy (grant phi), has_floor (t * gamma) (E gamma X phi) &
      forall x, E gamma X phi x a' = t * gamma /\ E gamma X phi x a = krr_bound * E gamma X phi x a'].
Proof.
move=> g0; have [a0 [a1 [_ _ ne]]] : exists a0 a1 : A, [/\ a0 \in A, a1 \in A & a0 != a1].
  by have /card_gt1P[a0 [a1 [h0 h1 ne]]] := two; exists a0, a1.
have [phi [te fl e1 e0]] := krr_attained_test ne.
have kk := kernel_krr.
exists phi, a0, a1; split=> [|x a|x]; first exact: policy_grant.
  by rewrite utility_grant // add0r subr0 mulrC ler_pmul2l.
by rewrite !utility_grant // !add0r subr0 e1 e0; split; [apply: mulrC|apply: mulrCA].
Qed.

(* Hence no smaller number bounds all policies with this floor. *)
Theorem T3_krr_least (X : finType) (x : X) gamma r : 0 < gamma ->
  (forall phi : A -> R, policy (grant phi) -> has_floor (t * gamma) (E gamma X phi) -> local_le r (E gamma X phi)) ->
  krr_bound <= r.
Proof.
move=> g0 h; have [phi [a [a' [po fl /(_ x)[e1 e0]]]]] := T3_krr_attained X g0.
by have := h _ po fl x a a'; rewrite e0 e1 ler_pmul2r // mulr_gt0.
Qed.

End Krr.
