(* What PolicyRange.v accepts bounds the local ratio of every policy, for every utility of the declared range. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions T13_range.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound PolicyLaw Likelihoods LikelihoodsSound PolicyClaims PolicyFacts PolicyBounds PolicyMultipliers PolicyRange.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Range.
Variables (R : realFieldType) (S : behind).
Hypotheses (ok : valid S) (cons : consistent S).

Lemma bigmax_le (I : finType) (f : I -> R) c : 0 <= c -> (forall i, f i <= c) -> \big[Num.max/0]_i f i <= c.
Proof. by move=> c0 all; elim/big_rec: _ => // i x _ h; rewrite le_maxl all h. Qed.

Lemma effective_L_le : effective_L R S <= ratio (L_used S).
Proof.
have L0 := L_ge0 R ok cons; rewrite /effective_L; move: (spread_within R ok cons) L0; rewrite /L_used /effective.
case: (lipschitz (stated S)) => [q|] // within L0.
do 4 (apply: bigmax_le => // ?); by rewrite ler_subl_addl; apply: within.
Qed.

Lemma own_declaredE (field : declared_in -> option Q) (x : X S) q otherwise : otherwise = Some q ->
  own_number R field x otherwise = ratio (own_declared S field x q).
Proof.
by move=> ->; rewrite /own_number /own /own_declared; case: (List.find _ _) => [d|] //; case: (field d).
Qed.

Theorem range_sound V : range_accepted S V -> greatest_at_most false (@of_any_utility R S false) (Some V).
Proof.
rewrite /range_accepted; case et: (gamma (stated S)) => [top|] //; case el: (m (stated S)) => [low|] //.
case/and5P => _ one /(at_mostP R); rewrite ratio_one => V1 _ /forallb_forall proofs E [U' [T [g' [kT gL rg eE]]]] x a a' aa.
have inx : In (nat_of_ord x) (List.seq 0 (true_contexts S)).
  by apply/in_seq; split; [exact: Nat.le_0_l | apply/ssrnat.ltP/ltn_ord].
have /andP[/(at_mostP R) mg /forallb_forall kinds_ok] := proofs _ inx.
have [s sin sE] := of_filterP R ok aa; have /(at_mostP R) := kinds_ok s sin.
rewrite ratio_plus !ratio_times !ratio_difference ratio_lesser ratio_difference ratio_one -sE; last first.
  by apply/Z.leb_le; case: (V) V1 => -[|n|n] d //=; rewrite /ratio leNgt (le_lt_trans _ ltr01) // pmulr_lle0 ?invr_gt0 ?embed_pos // embed_le0.
have once : hockey_stick (ratio V) (MA_all R (S := S) a) (MA_all R (S := S) a') = hockey_stick (ratio V) (MA R (S := S) a) (MA R (S := S) a').
  exact: (all_once (proj1 (Pos.eqb_eq _ _) one) a a' (fun p q => Num.max 0 (p - ratio V * q))).
rewrite -once => bound.
rewrite !eE; apply: (@T13_range R (X S) (Xt S) (A S) (memory S) U' _ _ T g' (kernel_MX R ok) (kernel_MA_all R ok) kT x a a'
  (ratio (own_declared S m_in x low)) (ratio (own_declared S gamma_in x top)) (ratio (L_used S))).
- by move=> u; move: (rg u x a); rewrite /m_at /gamma_at (own_declaredE _ _ el) (own_declaredE _ _ et).
- by move=> u; move: (rg u x a'); rewrite /m_at /gamma_at (own_declaredE _ _ el) (own_declaredE _ _ et).
- by move=> u; apply: le_trans (gL u x a a') _; rewrite ler_add2l effective_L_le.
- exact: le_trans ler01 V1.
exact: bound.
Qed.
End Range.
