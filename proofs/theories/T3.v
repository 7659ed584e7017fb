(* T3: a utility that ignores the group (or nearly so), with a floor under the expected utility. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T1.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- Tests of one ordered pair of rows ---- *)

Section Pair.
Variables (R : realFieldType) (A : finType).
Implicit Types (P Q phi : A -> R) (k t : R).

(* Section 9, the certificate behind T3: one number k bounds the ratio for every test. *)
Theorem certificate_one_k k t P Q phi : test phi -> 0 < t -> t <= expect Q phi ->
  expect P phi <= (k + hockey_stick k P Q / t) * expect Q phi.
Proof.
by move=> te t0 fl; apply: ratio_of_additive => //; [apply: hockey_stick_ge0|apply: hockey_stick_test].
Qed.

Lemma prob_mono Q (S S' : {set A}) : (forall a, 0 <= Q a) -> S \subset S' -> prob Q S <= prob Q S'.
Proof.
move=> Q0 /subsetP sub; rewrite !prob_expect; apply: ler_sum => a _; apply: ler_wpmul2l => //.
by case h: (a \in S); rewrite ?(sub _ h) ?ler0n.
Qed.

(* Neyman and Pearson: the multiplier is 0 or a likelihood ratio. *)
Lemma threshold t P Q : law P -> law Q -> 0 < t -> t <= 1 ->
  exists k, [/\ 0 <= k, k = 0 \/ exists2 b, 0 < Q b & k = P b / Q b,
    prob Q [set a | k * Q a < P a] <= t & t <= prob Q [set a | k * Q a <= P a]].
Proof.
move=> lP lQ t0 t1; case: (lP) => P0 P1; case: (lQ) => Q0 Q1.
pose ratio a := P a / Q a; pose cand o := if o is Some a then ratio a else 0.
pose ok (o : option A) := if o is Some a then 0 < Q a else true.
pose G k := prob Q [set a | k * Q a < P a].
have ratioE a c : 0 < Q a -> (ratio a <= c) = (P a <= c * Q a).
  by move=> q0; rewrite /ratio ler_pdivr_mulr.
have [b1 b1q] : exists b, 0 < Q b.
  case: (pickP (fun b => 0 < Q b)) => [b h|no]; first by exists b.
  have : \sum_a Q a <= 0.
    by rewrite big1 // => a _; apply: le_anti; rewrite Q0 andbT leNgt no.
  by rewrite Q1 ler10.
have [o0 o0ok] : exists o, ok o && (G (cand o) <= t).
  have [b bq bmax] := @arg_maxP _ _ _ b1 (fun b => 0 < Q b) ratio b1q.
  exists (Some b); rewrite /= bq /= /G prob_expect /expect big1 ?(ltW t0) // => a _.
  rewrite inE; case: (ltP (ratio b * Q a)) => h; last by rewrite mulr0.
  case: (ltP 0 (Q a)) => q0.
    by have : ratio a <= ratio b := bmax a q0; rewrite ratioE // => /(lt_le_trans h); rewrite ltxx.
  by rewrite (le_anti (y := 0) (x := Q a)) ?q0 ?Q0 // mul0r.
have [o /andP[ook oG] omin] := @arg_minP _ _ _ o0 (fun o => ok o && (G (cand o) <= t)) cand o0ok.
exists (cand o); split.
- by case: (o) => //= a; rewrite divr_ge0.
- by case: (o) ook => /= [a qa|_]; [right; exists a|left].
- by [].
rewrite leNgt; apply/negP => lt.
have [a1 a1lt] : exists a, P a < cand o * Q a.
  case: (pickP (fun a => P a < cand o * Q a)) => [a h|no]; first by exists a.
  move: lt; rewrite (_ : [set _ | _] = [set: A]); last by apply/setP => a; rewrite !inE leNgt no.
  by rewrite /prob (eq_bigl xpredT) => [|a]; rewrite ?inE // Q1 ltNge t1.
have pos a : P a < cand o * Q a -> 0 < Q a.
  move=> h; rewrite lt0r Q0 andbT; apply/eqP => q0; move: h; rewrite q0 mulr0.
  by rewrite ltNge P0.
have [a0 a0lt a0max] := @arg_maxP _ _ _ a1 (fun a => P a < cand o * Q a) ratio a1lt.
have : ratio a0 < cand o by rewrite /ratio ltr_pdivr_mulr ?pos.
suff ok0 : ok (Some a0) && (G (cand (Some a0)) <= t).
  by have : cand o <= ratio a0 := omin _ ok0; rewrite leNgt => /negbTE->.
rewrite /= pos //=; apply/ltW; apply: le_lt_trans lt; apply: prob_mono => //.
apply/subsetP => a; rewrite !inE => h; rewrite leNgt; apply/negP => h'.
by have : ratio a <= ratio a0 := a0max a h'; rewrite ratioE ?pos // => /(lt_le_trans h); rewrite ltxx.
Qed.

(* Section 9: the least right side over k is attained.  At every level t there are a k (0 or a
   likelihood ratio) and a test phi of level t that turn the certificate into an equality. *)
Theorem certificate_exact t P Q : law P -> law Q -> 0 < t -> t <= 1 ->
  exists k phi, [/\ 0 <= k, k = 0 \/ (exists2 b, 0 < Q b & k = P b / Q b), test phi,
    expect Q phi = t & expect P phi = (k + hockey_stick k P Q / t) * t].
Proof.
move=> lP lQ t0 t1; have [k [k0 kc lo hi]] := threshold lP lQ t0 t1.
set S := [set a | _ < _] in lo; pose V := [set a | k * Q a == P a].
have SV : [set a | k * Q a <= P a] = S :|: V.
  by apply/setP => a; rewrite !inE le_eqVlt orbC.
have dis : [disjoint S & V].
  by rewrite -setI_eq0; apply/eqP/setP => a; rewrite !inE; case: (ltgtP (k * Q a) (P a)).
have Q0 a : 0 <= Q a by case: lQ.
have V0 : 0 <= prob Q V by apply: sumr_ge0.
have {}hi : t <= prob Q S + prob Q V.
  apply: le_trans hi _; rewrite SV !prob_expect -expectD le_eqVlt; apply/orP; left; apply/eqP.
  apply: eq_expect => // a; rewrite inE; case: (boolP (a \in S)) => [aS|_] /=; last by rewrite add0r.
  by rewrite (disjointFr dis aS) addr0.
pose c := (t - prob Q S) / prob Q V.
have cV : c * prob Q V = t - prob Q S.
  rewrite /c; case: (eqVneq (prob Q V) 0) hi => [->|ne _]; last by rewrite mulfVK.
  by rewrite addr0 mulr0 => hi; apply/esym/eqP; rewrite subr_eq0 eq_le hi lo.
have c0 : 0 <= c by rewrite divr_ge0 // subr_ge0.
have c1 : c <= 1.
  case: (eqVneq (prob Q V) 0) => [e|ne]; first by rewrite /c e invr0 mulr0 ler01.
  by rewrite ler_pdivr_mulr ?mul1r ?ler_subl_addl // lt0r ne.
pose phi a : R := (a \in S)%:R + c * (a \in V)%:R.
have EQ : expect Q phi = t.
  by rewrite expectD expectZ -!prob_expect cV addrCA subrr addr0.
exists k, phi; split=> // [a|].
  rewrite /phi; case: (boolP (a \in S)) => aS.
    by rewrite (disjointFr dis aS) mulr0 addr0 ler01 lexx.
  by rewrite add0r; case: (a \in V); rewrite ?mulr1 ?mulr0 ?c0 ?c1 ?lexx ?ler01.
have e : expect P phi - k * expect Q phi = hockey_stick k P Q.
  rewrite expect_diff; apply: eq_bigr => a _; rewrite /phi !inE.
  case: (ltgtP (k * Q a) (P a)) => h.
  - by rewrite mulr0 addr0 mulr1; apply/esym/max_idPr; rewrite subr_ge0 ltW.
  - by rewrite mulr0 addr0 mulr0; apply/esym/max_idPl; rewrite subr_le0 ltW.
  - by rewrite h subrr mul0r maxxx.
by rewrite mulrDl divfK ?gt_eqF // -e EQ; ring.
Qed.

End Pair.
