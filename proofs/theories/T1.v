(* T1 and T2: the bounds of a private group filter, for every policy behind it. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Ratios.
Variable R : realFieldType.
Implicit Types (e c k r tau : R).

(* From an additive bound to a ratio: the floor is needed under the denominator. *)
Lemma ratio_of_additive e e' k c tau : 0 < tau -> tau <= e' -> 0 <= c ->
  e <= k * e' + c -> e <= (k + c / tau) * e'.
Proof.
move=> t0 te c0 h; apply: le_trans h _; rewrite mulrDl ler_add2l.
by rewrite -mulrA ler_pemulr // mulrC ler_pdivl_mulr // mul1r.
Qed.

Lemma ratio_weaken e e' r r' : 0 <= e' -> r <= r' -> e <= r * e' -> e <= r' * e'.
Proof. by move=> e0 rr h; apply: le_trans h _; apply: ler_wpmul2r. Qed.

End Ratios.

Section T1.
Variables (R : realFieldType) (X Xt A At U : finType).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R) (g : U -> X -> A -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (kT : policy T).

Local Notation E := (utility (induced MX MA T) g).
Local Notation H k a a' := (hockey_stick k (MA a) (MA a')).

(* Replacing the person's own group by another one in g costs at most K. *)
Lemma utility_le_shift x a a' K : (forall u, g u x a <= g u x a' + K) ->
  E x a <= expect (MA a) (response MX T g x a') + K.
Proof.
move=> gK; rewrite utility_response -{1}(expect_cst K (kA a)) -expectD.
by apply: expect_le => // b; apply: response_le.
Qed.

(* Expected utilities lie where g lies. *)
Lemma utility_ranged lo hi x a : valued lo hi g -> lo <= E x a <= hi.
Proof. by move=> vg; rewrite utility_response; apply: expect_ranged => //; apply: response_ranged. Qed.

(* T1, for one multiplier k >= 0 and one ordered pair of groups. *)
Theorem T1_one_k gamma K k x a a' : valued 0 gamma g -> (forall u, g u x a <= g u x a' + K) ->
  E x a <= k * E x a' + K + gamma * H k a a'.
Proof.
move=> vg gK; apply: le_trans (utility_le_shift gK) _; rewrite addrAC ler_add2r.
rewrite utility_response.
have := hockey_stick_ranged k (kA a) (kA a') (response_ranged x a' kX kT vg).
by rewrite mulr0 !subr0.
Qed.

(* T1, additive form: an (eps, delta)-private filter gives E(x,a) <= e^eps E(x,a') + K + delta gamma.
   K(a,a') = L_A d(a,a') is any bound on how much g differs between the two groups. *)
Theorem T1_additive gamma k delta (K : A -> A -> R) :
  0 <= gamma -> valued 0 gamma g -> (forall u x a a', `|g u x a - g u x a'| <= K a a') ->
  every_pair (dp k delta) MA ->
  forall x a a', E x a <= k * E x a' + K a a' + delta * gamma.
Proof.
move=> g0 vg gK d x a a'.
have gK' u : g u x a <= g u x a' + K a a'.
  by rewrite -ler_subl_addl; apply: le_trans (ler_norm _) (gK _ _ _ _).
apply: le_trans (T1_one_k k vg gK') _; rewrite ler_add2l mulrC.
by apply: ler_wpmul2r => //; apply/dp_hockey_stick; apply: d.
Qed.

(* T1 for a known filter, with a multiplier k for each ordered pair: R <= k + (K + gamma H_k)/tau. *)
Theorem T1_filter gamma tau K k x a a' :
  0 < tau -> tau <= E x a' -> 0 <= gamma -> 0 <= K -> valued 0 gamma g ->
  (forall u, g u x a <= g u x a' + K) ->
  E x a <= (k + (K + gamma * H k a a') / tau) * E x a'.
Proof.
move=> t0 te g0 K0 vg gK; apply: ratio_of_additive => //.
  by rewrite addr_ge0 // mulr_ge0 // hockey_stick_ge0.
by rewrite addrA; apply: T1_one_k.
Qed.

(* T1: R <= e^eps + (K + delta gamma)/tau for every pair of groups, with the K of the pair. *)
Theorem T1_pairs gamma k delta (K : A -> A -> R) tau :
  0 <= gamma -> 0 <= delta -> valued 0 gamma g ->
  (forall u x a a', `|g u x a - g u x a'| <= K a a') -> (forall a a', 0 <= K a a') ->
  every_pair (dp k delta) MA -> 0 < tau -> has_floor tau E ->
  forall x a a', E x a <= (k + (K a a' + delta * gamma) / tau) * E x a'.
Proof.
move=> g0 d0 vg gK K0 d t0 fl x a a'; apply: ratio_of_additive => //.
  by rewrite addr_ge0 // mulr_ge0.
by rewrite addrA; apply: T1_additive.
Qed.

(* T1, tight form: R <= e^eps + (K + delta gamma)/tau with K the greatest of them. *)
Theorem T1_tight gamma k delta K tau :
  0 <= gamma -> 0 <= delta -> valued 0 gamma g ->
  (forall u x a a', `|g u x a - g u x a'| <= K) -> 0 <= K ->
  every_pair (dp k delta) MA -> 0 < tau -> has_floor tau E ->
  local_le (k + (K + delta * gamma) / tau) E.
Proof. by move=> g0 d0 vg gK K0 d t0 fl x a a'; apply: (@T1_pairs gamma k delta (fun _ _ => K)). Qed.

(* The paper's form of T1, R <= e^eps (1 + (K + delta gamma)/tau): it follows from the tight form. *)
Theorem T1_paper gamma k delta K tau :
  0 <= gamma -> 0 <= delta -> valued 0 gamma g ->
  (forall u x a a', `|g u x a - g u x a'| <= K) -> 0 <= K -> 1 <= k ->
  every_pair (dp k delta) MA -> 0 < tau -> has_floor tau E ->
  local_le (k * (1 + (K + delta * gamma) / tau)) E.
Proof.
move=> g0 d0 vg gK K0 k1 d t0 fl x a a'.
apply: ratio_weaken (T1_tight g0 d0 vg gK K0 d t0 fl x a a').
  exact: le_trans (ltW t0) (fl x a').
by rewrite mulrDr mulr1 ler_add2l ler_pemull // divr_ge0 ?(ltW t0) // addr_ge0 // mulr_ge0.
Qed.

(* The cap: R <= gamma/tau whatever the filter is. *)
Theorem T1_cap gamma tau : valued 0 gamma g -> 0 < tau -> has_floor tau E -> local_le (gamma / tau) E.
Proof.
move=> vg t0 fl x a a'; have /andP[_ le] := utility_ranged x a vg.
have /andP[e0 _] := utility_ranged x a vg.
apply: le_trans le _; rewrite -mulrA ler_pemulr ?(le_trans _ (fl x a')) //; last first.
  by rewrite mulrC ler_pdivl_mulr // mul1r.
by apply: le_trans e0 _; have /andP[] := utility_ranged x a vg.
Qed.

(* T2: behind a purely eps-private filter a g that ignores the group has R <= e^eps, for every
   policy and without a floor. *)
Theorem T2_pure k : (forall u x a, 0 <= g u x a) -> a_free g ->
  every_pair (pure_dp k) MA -> local_le k E.
Proof.
move=> g0 fg d x a a'; rewrite !utility_response.
rewrite (eq_expect (P' := MA a) (g' := response MX T g x a') _ (response_free MX T x a a' fg)) //.
rewrite /expect mulr_sumr; apply: ler_sum => b _; rewrite mulrA; apply: ler_wpmul2r; last exact: d.
by rewrite response_expect; apply: expect_ge0 => // y; apply: expect_ge0 => [|u]; [exact: kT|exact: g0].
Qed.

End T1.

Section Attained.
Variables (R : realFieldType) (X A At : finType) (MA : A -> At -> R).

(* The policy that grants with probability phi(b) when b is shown, and the utility gamma of a grant:
   every test is the response of a policy. *)
Definition grant (phi : At -> R) (_ : unit) (b : At) (u : bool) : R := if u then phi b else 1 - phi b.
Definition granted (lo hi : R) (u : bool) (x : X) (a : A) : R := if u then hi else lo.
Definition no_context (x : X) (y : unit) : R := 1.

Lemma big_unit (f : unit -> R) : \sum_y f y = f tt.
Proof. by rewrite (bigD1 tt) //= big1 ?addr0 // => -[]. Qed.

Lemma policy_grant phi : test phi -> policy (grant phi).
Proof.
move=> t y b; split=> [u|]; last by rewrite big_bool /=; ring.
by case/andP: (t b) => p0 p1; case: u; rewrite /grant ?subr_ge0.
Qed.

Lemma kernel_no_context : kernel no_context.
Proof. by move=> x; split=> [y|]; rewrite ?big_unit // /no_context ler01. Qed.

Lemma granted_free lo hi : a_free (granted lo hi).
Proof. by []. Qed.

Lemma granted_valued lo hi : lo <= hi -> valued lo hi (granted lo hi).
Proof. by move=> h [] x a; rewrite /granted /= lexx ?andbT. Qed.

Lemma utility_grant phi lo hi x a : kernel MA ->
  utility (induced no_context MA (grant phi)) (granted lo hi) x a = lo + (hi - lo) * expect (MA a) phi.
Proof.
move=> kA; rewrite utility_response; transitivity (expect (MA a) (fun b => lo + (hi - lo) * phi b)).
  2: by rewrite expectD expectZ expect_cst.
apply: eq_expect => // b; rewrite /response big_unit big_bool /= /no_context.
by ring.
Qed.

(* T2 is sharp: for the pair of groups and the released value with the greatest ratio k, the policy
   that grants on that value alone has E(x,a) = k E(x,a'). *)
Theorem T2_sharp a a' b k gamma x : kernel MA -> MA a b = k * MA a' b ->
  let E := utility (induced no_context MA (grant (point R b))) (granted 0 gamma) x in
  [/\ policy (grant (point R b)), E a = k * E a' & E a' = gamma * MA a' b].
Proof.
move=> kA h /=; split.
- by apply: policy_grant => c; rewrite /point; case: (c == b); rewrite ?lexx ?ler01.
- by rewrite !utility_grant // !add0r subr0 mulrCA; congr (_ * _); rewrite !expect_pointr.
- by rewrite utility_grant // add0r subr0 expect_pointr.
Qed.

End Attained.
