(* T4: a utility that ignores the group and has a floor m of its own. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T1 T3.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section T4.
Variables (R : realFieldType) (X Xt A At U : finType).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R) (g : U -> X -> A -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (kT : policy T).

Local Notation E := (utility (induced MX MA T) g).
Local Notation H k a a' := (hockey_stick k (MA a) (MA a')).

(* T4, one k: R <= k + max(0, (gamma - m) H_k - (k - 1) m)/tau. *)
Theorem T4_one_k m gamma tau k x a a' : valued m gamma g -> a_free g -> 0 < tau -> tau <= E x a' ->
  E x a <= (k + Num.max 0 ((gamma - m) * H k a a' - (k - 1) * m) / tau) * E x a'.
Proof.
move=> vg fg t0 te; apply: ratio_of_additive => //; first by rewrite le_maxr lexx.
have := hockey_stick_ranged k (kA a) (kA a') (response_ranged x a' kX kT vg).
rewrite -utility_response -addrA (_ : expect _ _ = E x a); last first.
  by rewrite utility_response; apply: eq_expect => // b; apply: response_free.
by move/le_trans; apply; rewrite ler_add2l le_maxr lexx orbT.
Qed.

(* T4 without any assumption about the policy: tau := m > 0 is a floor by itself. *)
Theorem T4_any_policy m gamma k x a a' : valued m gamma g -> a_free g -> 0 < m ->
  E x a <= (k + Num.max 0 ((gamma - m) * H k a a' - (k - 1) * m) / m) * E x a'.
Proof.
move=> vg fg m0; apply: T4_one_k => //.
by case/andP: (utility_ranged kX kA kT x a' vg).
Qed.

(* T4, first form: R is at most the greatest of (m + (gamma - m)(1 - f(s)))/(m + (gamma - m)s) over s >= s0. *)
Theorem T4_tradeoff m gamma tau f r : 0 < m -> m < gamma -> valued m gamma g -> a_free g ->
  every_pair (above f) MA -> has_floor tau E ->
  (forall s, (tau - m) / (gamma - m) <= s -> 0 <= s -> s <= 1 ->
     (m + (gamma - m) * (1 - f s)) / (m + (gamma - m) * s) <= r) ->
  local_le r E.
Proof.
move=> m0 mg vg fg ab fl sup x a a'.
have w0 : 0 < gamma - m by rewrite subr_gt0.
pose h := response MX T g x a'; pose phi b := (gamma - m)^-1 * (h b - m).
have tphi : test phi.
  move=> b; case/andP: (response_ranged x a' kX kT vg b) => l u.
  rewrite /phi mulr_ge0 ?invr_ge0 ?(ltW w0) ?subr_ge0 //= mulrC ler_pdivr_mulr // mul1r.
  by rewrite ler_add2r.
have eE c : expect (MA c) h = m + (gamma - m) * expect (MA c) phi.
  by rewrite expectZ mulVKf ?gt_eqF // expectB expect_cst // addrCA subrr addr0.
have ea : E x a = expect (MA a) h.
  by rewrite utility_response; apply: eq_expect => // b; apply: response_free.
have ea' : E x a' = expect (MA a') h by rewrite utility_response.
have := fl x a'; rewrite ea ea' !eE; set p := expect _ phi; set s := expect (MA a') phi => te.
have /andP[s0 s1] : 0 <= s <= 1 := expect_ranged (kA a') tphi.
have d0 : 0 < m + (gamma - m) * s by rewrite ltr_paddr // mulr_ge0 // ltW.
rewrite -ler_pdivr_mulr //; apply: le_trans (sup s _ s0 s1).
  rewrite ler_pmul2r ?invr_gt0 // ler_add2l ler_pmul2l // ler_subr_addl -ler_subr_addr.
  exact: ab.
by rewrite ler_pdivr_mulr // ler_subl_addl mulrC.
Qed.

End T4.
