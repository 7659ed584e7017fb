(* T9: degrading a randomized response never raises the ratios, if every group is compared. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section RandomizedResponse.
Variables (R : realFieldType) (A : finType).
Implicit Types (p l : R).

Local Notation n := (#|A|%:R : R).

(* M_p = l I + (1 - l) J with J the uniform table. *)
Definition smear (l : R) (a b : A) : R := l * (a == b)%:R + (1 - l) / n.
Definition weight (p : R) : R := (n * p - 1) / (n - 1).

Hypothesis two : (1 < #|A|)%N.

Lemma card_gt0 : 0 < n. Proof. by rewrite ltr0n (ltn_trans _ two). Qed.
Lemma card1_gt0 : 0 < n - 1. Proof. by rewrite subr_gt0 ltr1n. Qed.
Let n_neq0 : n != 0. Proof. by rewrite gt_eqF // card_gt0. Qed.
Let n1_neq0 : n - 1 != 0. Proof. by rewrite gt_eqF // card1_gt0. Qed.

Lemma sum_cst (c : R) : \sum_(a : A) c = n * c.
Proof. by rewrite sumr_const mulr_natl. Qed.

Lemma krr_smear p a b : krr p a b = smear (weight p) a b.
Proof.
have e : (1 - weight p) / n = krr_lie A p.
  have -> : 1 - weight p = n * (1 - p) / (n - 1).
    by rewrite /weight -{1}(divff n1_neq0) -mulrBl; congr (_ / _); ring.
  by rewrite /krr_lie mulrAC (mulrC n) mulfK.
rewrite /krr /smear e; case: (a == b); last by rewrite mulr0 add0r.
rewrite mulr1 /weight /krr_lie -mulrDl; apply/eqP; rewrite eq_sym.
by rewrite -(inj_eq (mulIf n1_neq0)) divfK //; apply/eqP; ring.
Qed.

Lemma smear_law l a : 0 <= l -> l <= 1 -> law (smear l a).
Proof.
move=> l0 l1; split=> [b|].
  apply: addr_ge0; first by rewrite mulr_ge0 ?ler0n.
  by apply: divr_ge0; [rewrite subr_ge0|rewrite ler0n].
rewrite big_split /= sum_cst mulrC divfK // -mulr_sumr.
by rewrite (proj2 (kernel_identity R a)) mulr1 addrCA subrr addr0.
Qed.

(* Such tables multiply in l. *)
Lemma smear_after l l' a b : after (smear l) (smear l') a b = smear (l * l') a b.
Proof.
transitivity (\sum_c (l * l' * ((a == c)%:R * (c == b)%:R) + l * ((1 - l') / n) * (a == c)%:R
   + l' * ((1 - l) / n) * (c == b)%:R + (1 - l) / n * ((1 - l') / n))).
  by apply: eq_bigr => c _; rewrite /smear; ring.
rewrite !big_split /= sum_cst -!mulr_sumr (proj2 (kernel_identity R a)).
have e1 : \sum_c (a == c)%:R * (c == b)%:R = (a == b)%:R :> R := expect_pointr (@identity R A a) b.
have e2 : \sum_c (c == b)%:R = 1 :> R := proj2 (law_point R b).
rewrite e1 e2.
rewrite /smear !mulr1 -!addrA; congr (_ + _).
rewrite (_ : n * _ = (1 - l) * ((1 - l') / n)); last first.
  by rewrite mulrA (mulrC n) divfK.
by rewrite !mulrA -!mulrDl; congr (_ / _); ring.
Qed.

Lemma weight01 p : n^-1 <= p -> p <= 1 -> 0 <= weight p /\ weight p <= 1.
Proof.
move=> lo hi; split.
  rewrite divr_ge0 ?(ltW card1_gt0) // subr_ge0.
  by rewrite mulrC -ler_pdivr_mulr ?card_gt0 // mul1r.
rewrite ler_pdivr_mulr ?card1_gt0 // mul1r ler_add2r.
by rewrite ler_pimulr // ler0n.
Qed.

(* Randomized response with p >= 1/k is a filter. *)
Lemma krr_law p (a : A) : n^-1 <= p -> p <= 1 -> law (krr p a).
Proof.
move=> lo hi; have [w0 w1] := weight01 lo hi; have [s0 s1] := smear_law a w0 w1.
by split=> [b|]; [rewrite krr_smear|rewrite -[RHS]s1; apply: eq_bigr => b _; rewrite krr_smear].
Qed.

(* T9: for 1/k <= p' <= p, M_p' = N M_p with N itself a randomized response. *)
Theorem T9_krr p p' : n^-1 <= p' -> p' <= p -> p <= 1 ->
  exists r, [/\ n^-1 <= r, r <= 1 & forall a b : A, krr p' a b = after (krr r) (krr p) a b].
Proof.
move=> lo le hi; have lo' := le_trans lo le; have hi' := le_trans le hi.
have [w0 w1] := weight01 lo' hi; have [v0 v1] := weight01 lo hi'.
have vw : weight p' <= weight p.
  by rewrite ler_pmul2r ?invr_gt0 ?card1_gt0 // ler_add2r ler_pmul2l // card_gt0.
have [l [l0 l1 lE]] : exists l, [/\ 0 <= l, l <= 1 & weight p' = l * weight p].
  case: (eqVneq (weight p) 0) => [e|ne].
    exists 1; rewrite ler01 lexx mul1r; split=> //.
    by apply: le_anti; rewrite vw e v0.
  exists (weight p' / weight p); rewrite divfK // divr_ge0 //; split=> //.
  by rewrite ler_pdivr_mulr ?mul1r // lt_def ne.
pose r := (1 + (n - 1) * l) / n.
have wr : weight r = l.
  rewrite /weight /r (mulrC n) divfK // addrAC subrr add0r mulrAC divff // mul1r.
  by [].
exists r; split=> [||a b].
- rewrite /r ler_pdivl_mulr ?card_gt0 // mulVf ?gt_eqF ?card_gt0 // ler_addl.
  by rewrite mulr_ge0 // ltW // card1_gt0.
- rewrite /r ler_pdivr_mulr ?card_gt0 // mul1r -ler_subr_addl.
  by rewrite ler_pimulr // ltW // card1_gt0.
rewrite krr_smear lE -wr -smear_after; apply: eq_bigr => c _.
by rewrite !krr_smear.
Qed.

End RandomizedResponse.

Section Degrade.
Variable R : realFieldType.

(* M' is M with further noise N on the truth: M' = N M. *)
Definition degrades (A At : finType) (M' M : A -> At -> R) : Prop :=
  exists2 N : A -> A -> R, kernel N & forall a b, M' a b = after N M a b.

Theorem T9_krr_degrades (A : finType) (p p' : R) : (1 < #|A|)%N ->
  #|A|%:R^-1 <= p' -> p' <= p -> p <= 1 -> degrades (@krr R A p') (krr p).
Proof.
move=> two lo le hi; have [r [r0 r1 e]] := T9_krr two lo le hi.
by exists (@krr R A r) => // a; apply: krr_law.
Qed.

Lemma degrades_refl (A At : finType) (M : A -> At -> R) : degrades M M.
Proof.
exists (@identity R A); first exact: kernel_identity.
move=> a b; rewrite -[LHS](expect_point (fun c => M c b) a); apply: eq_bigr => c _.
by rewrite /point /identity eq_sym.
Qed.

(* T9 for tuples: a product of degraded filters is the degraded product.  With degrades_refl: as any
   one of the keep probabilities falls.  Products of more than two filters by repetition. *)
Theorem T9_products (A At B Bt : finType) (M M' : A -> At -> R) (L L' : B -> Bt -> R) :
  degrades M' M -> degrades L' L -> degrades (both M' L') (both M L).
Proof.
move=> [N kN eN] [O kO eO]; exists (both N O); first exact: kernel_both.
move=> [a b] [a' b']; rewrite /both /= eN eO /after.
rewrite -(pair_bigA _ (fun c d => N a c * O b d * (M c a' * L d b'))) /=.
rewrite mulr_suml; apply: eq_bigr => c _; rewrite mulr_sumr.
by apply: eq_bigr => d _; rewrite mulrACA.
Qed.

Variables (X Xt A At U : finType).
Variables (MX : X -> Xt -> R) (MA MA' : A -> At -> R) (T : Xt -> At -> U -> R) (g : U -> X -> A -> R).
Hypothesis fg : a_free g.

Local Notation E := (utility (induced MX MA T) g).
Local Notation E' := (utility (induced MX MA' T) g).

(* The new values are means of old ones, with weights that depend on the groups alone. *)
Lemma utility_degraded N : (forall a b, MA' a b = after N MA a b) ->
  forall x a, E' x a = \sum_c N a c * E x c.
Proof.
move=> e x a; rewrite utility_response /expect.
transitivity (\sum_b \sum_c N a c * (MA c b * response MX T g x a b)).
  apply: eq_bigr => b _; rewrite e /after mulr_suml.
  by apply: eq_bigr => c _; rewrite mulrA.
rewrite exchange_big; apply: eq_bigr => c _ /=; rewrite -mulr_sumr utility_response.
by congr (_ * _); apply: eq_bigr => b _; rewrite (response_free MX T x a c fg).
Qed.

Lemma mean_ratio (N : A -> A -> R) (e : A -> R) r : kernel N -> global_le r e ->
  global_le r (fun a => expect (N a) e).
Proof.
move=> kN h a a'; rewrite -expectZ -[X in X <= _](expect_cst _ (kN a')).
apply: expect_le => // c'; rewrite -[X in _ <= X](expect_cst _ (kN a)).
by apply: expect_le => // c; apply: h.
Qed.

(* T9: if every group is compared in every context, more noise does not raise R. *)
Theorem T9_local r : degrades MA' MA -> local_le r E -> local_le r E'.
Proof.
move=> [N kN e] h x a a'; rewrite !(utility_degraded e).
by apply: (mean_ratio kN (e := E x)) => c c'; apply: h.
Qed.

(* T9: if X and A are independent, it does not raise Rbar. *)
Theorem T9_global (W : A -> X -> R) r : independent W -> degrades MA' MA ->
  global_le r (group_mean W E) -> global_le r (group_mean W E').
Proof.
move=> ind [N kN e] h.
have eE a : group_mean W E' a = expect (N a) (group_mean W E).
  rewrite /group_mean /expect.
  transitivity (\sum_x \sum_c N a c * (W c x * E x c)).
    apply: eq_bigr => x _; rewrite (utility_degraded e) mulr_sumr; apply: eq_bigr => c _.
    by rewrite mulrCA (ind a c).
  by rewrite exchange_big; apply: eq_bigr => c _ /=; rewrite mulr_sumr.
by move=> a a'; rewrite !eE; apply: (mean_ratio kN h).
Qed.

End Degrade.

Section Monotone.
Variables (R : realFieldType) (X Xt A U : finType).
Variables (MX : X -> Xt -> R) (T : Xt -> A -> U -> R) (g : U -> X -> A -> R).
Hypotheses (two : (1 < #|A|)%N) (fg : a_free g).

(* T9 for one randomized response: R does not fall as p grows. *)
Theorem T9_monotone p p' r : #|A|%:R^-1 <= p' -> p' <= p -> p <= 1 ->
  local_le r (utility (induced MX (krr p) T) g) -> local_le r (utility (induced MX (krr p') T) g).
Proof. by move=> lo le hi; apply: T9_local => //; apply: T9_krr_degrades. Qed.

(* The remark under T9: for one randomized response it is enough that the two groups are compared,
   as long as r >= 1. *)
Theorem T9_pair p p' r x a a' : kernel MX -> policy T -> (forall u x a, 0 <= g u x a) ->
  #|A|%:R^-1 <= p' -> p' <= p -> p <= 1 -> 1 <= r ->
  let E s := utility (induced MX (krr s) T) g x in E p a <= r * E p a' -> E p' a <= r * E p' a'.
Proof.
move=> kX kT g0 lo le hi r1 E h; have [s [s0 s1 e]] := T9_krr two lo le hi.
have kp : kernel (@krr R A p) by move=> c; apply: krr_law => //; apply: le_trans lo le.
have Ep c : 0 <= E p c by apply: expect_ge0 => [|u]; [exact: kernel_induced|exact: g0].
have [l0 l1] := weight01 two s0 s1; set l := weight A s in l0 l1.
pose d := (1 - l) / #|A|%:R * \sum_c E p c.
have d0 : 0 <= d.
  rewrite mulr_ge0 ?sumr_ge0 //; apply: divr_ge0; [by rewrite subr_ge0|exact: ler0n].
have EE c : E p' c = l * E p c + d.
  have -> : E p' c = \sum_b krr s c b * E p b := utility_degraded MX T fg e x c.
  rewrite /d -[E p c](expect_point (E p) c) /expect !mulr_sumr -big_split /=.
  by apply: eq_bigr => b _; rewrite (krr_smear two) /smear -/l /point (eq_sym b) mulrDl !mulrA.
rewrite !EE mulrDr mulrCA; apply: ler_add; first by rewrite ler_wpmul2l.
by rewrite ler_pemull.
Qed.

End Monotone.

Section MonotoneProducts.
Variables (R : realFieldType) (X Xt A B U : finType).
Variables (MX : X -> Xt -> R) (T : Xt -> A * B -> U -> R) (g : U -> X -> A * B -> R).
Hypotheses (twoA : (1 < #|A|)%N) (twoB : (1 < #|B|)%N) (fg : a_free g).

(* T9 for the tuple of two randomized responses: R does not fall as either keep probability grows. *)
Theorem T9_products_monotone p p' s s' r :
  #|A|%:R^-1 <= p' -> p' <= p -> p <= 1 -> #|B|%:R^-1 <= s' -> s' <= s -> s <= 1 ->
  local_le r (utility (induced MX (both (krr p) (krr s)) T) g) ->
  local_le r (utility (induced MX (both (krr p') (krr s')) T) g).
Proof.
move=> lo le hi lo' le' hi'; apply: T9_local => //; apply: T9_products; exact: T9_krr_degrades.
Qed.

End MonotoneProducts.
