(* T3 under (eps, delta) is sharp: each of its three terms is attained, by one filter with four outputs. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T1 T3.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Sharp.
Variable R : realFieldType.
Variables (k delta : R).
Hypotheses (k1 : 1 <= k) (d0 : 0 <= delta) (d1 : delta <= 1).

(* The probability of the lie in the part that is randomized response. *)
Definition w : R := (1 - delta) / (1 + k).

(* Two groups.  The outputs (true, s) reveal the group s outright, with probability delta; the outputs
   (false, s) are randomized response with ratio k. *)
Definition four (a : bool) (b : bool * bool) : R :=
  if b.1 then (if b.2 == a then delta else 0) else (if b.2 == a then k * w else w).

Let kp : 0 < 1 + k. Proof. by rewrite addr_gt0 // (lt_le_trans ltr01). Qed.
Let k0 : 0 < k. Proof. exact: lt_le_trans ltr01 k1. Qed.
Let kn : k != 0. Proof. by rewrite gt_eqF // k0. Qed.
Let w0 : 0 <= w. Proof. by apply: divr_ge0; [rewrite subr_ge0|exact: ltW kp]. Qed.
Let wE : 1 - delta = w + k * w.
Proof. by rewrite -{1}[w]mul1r -mulrDl mulrC divfK // gt_eqF. Qed.

Lemma sum_four (f : bool * bool -> R) :
  \sum_b f b = f (true, true) + f (true, false) + (f (false, true) + f (false, false)).
Proof.
transitivity (\sum_u \sum_v f (u, v)); last by rewrite !big_bool.
by rewrite pair_bigA; apply: eq_bigr => -[].
Qed.

Lemma kernel_four : kernel four.
Proof.
move=> a; split=> [b|].
  by rewrite /four; case: b.1; case: (b.2 == a) => //; apply: mulr_ge0 => //; apply: ltW.
have e : delta + (w + k * w) = 1 by rewrite -wE addrCA subrr addr0.
by rewrite sum_four /four /=; case: a; rewrite /= ?addr0 ?add0r // -[RHS]e; congr (_ + _); rewrite addrC.
Qed.

Lemma dp_four : every_pair (dp k delta) four.
Proof.
have kw : w <= k * w by rewrite ler_pemull.
have kw0 : 0 <= k * w := le_trans w0 kw.
have kkw : w <= k * (k * w) by apply: le_trans kw _; rewrite ler_pemull.
have kkw' : k * w <= k * (k * w) by rewrite ler_pmul2l.
have dk : delta <= k * delta by rewrite ler_pemull.
have kd0 : 0 <= k * delta := le_trans d0 dk.
have md : Num.max 0 delta = delta by apply/max_idPr.
have z (x y : R) : x <= y -> Num.max 0 (x - y) = 0 by move=> h; apply/max_idPl; rewrite subr_le0.
move=> a a'; apply/dp_hockey_stick; rewrite /hockey_stick sum_four /four /=.
by case: a; case: a' => /=; rewrite ?mulr0 ?subr0 ?maxxx ?md !z // ?addr0 ?add0r.
Qed.

(* A test by its four values, in falling order of the likelihood ratio of group true to group false. *)
Definition test4 (y1 y2 y3 y4 : R) (b : bool * bool) : R :=
  if b.1 then (if b.2 then y1 else y4) else (if b.2 then y2 else y3).

Lemma expect_true y1 y2 y3 y4 : expect (four true) (test4 y1 y2 y3 y4) = delta * y1 + k * w * y2 + w * y3.
Proof. by rewrite /expect sum_four /four /test4 /= mul0r addr0 addrA. Qed.

Lemma expect_false y1 y2 y3 y4 : expect (four false) (test4 y1 y2 y3 y4) = w * y2 + k * w * y3 + delta * y4.
Proof. by rewrite /expect sum_four /four /test4 /= mul0r add0r addrC. Qed.

Variable t : R.
Hypotheses (t0 : 0 < t) (t1 : t <= 1).
Let tn : t != 0. Proof. by rewrite gt_eqF. Qed.

(* phi attains the ratio r with the floor t for both groups. *)
Definition attains (r : R) : Prop := exists phi : bool * bool -> R,
  [/\ test phi, t <= expect (four true) phi, expect (four false) phi = t &
      expect (four true) phi = r * t].

(* The term e^eps + delta/t, for t up to (1 - delta)/(1 + e^eps). *)
Lemma T3_sharp_one_k : t <= w -> attains (k + delta / t).
Proof.
move=> tw; have wp : 0 < w := lt_le_trans t0 tw; have wn : w != 0 by rewrite gt_eqF.
have e : expect (four true) (test4 1 (t / w) 0 0) = k * t + delta.
  by rewrite expect_true mulr1 mulr0 addr0 -mulrA (mulrC w) divfK // addrC.
exists (test4 1 (t / w) 0 0); split.
- move=> [[] []]; rewrite /test4 /= ?lexx ?ler01 //.
  by rewrite divr_ge0 ?(ltW t0) //= ler_pdivr_mulr // mul1r.
- by rewrite e -[X in X <= _]addr0 ler_add // ler_pemull // ltW.
- by rewrite expect_false !mulr0 !addr0 mulrC divfK.
- by rewrite e mulrDl divfK.
Qed.

(* The term (1 - e^-eps (1 - delta - t))/t, between. *)
Lemma T3_sharp_reversed : w <= t -> t <= 1 - delta -> attains ((1 - (1 - delta - t) / k) / t).
Proof.
move=> wt td; have wp : 0 < w.
  by rewrite divr_gt0 // (lt_le_trans t0).
have wn : w != 0 by rewrite gt_eqF.
have kwp : 0 < k * w by rewrite mulr_gt0.
pose c := (t - w) / (k * w); have cE : c * (k * w) = t - w by rewrite divfK // gt_eqF.
have e : expect (four true) (test4 1 1 c 0) = 1 - (1 - delta - t) / k.
  rewrite expect_true !mulr1; apply: (mulfI kn); rewrite [RHS]mulrBr [k * (_ / k)]mulrC divfK //.
  have -> : k * (delta + k * w + w * c) = k * (delta + k * w) + c * (k * w) by ring.
  by rewrite cE wE -[delta](subKr 1) wE; ring.
exists (test4 1 1 c 0); split.
- move=> [[] []]; rewrite /test4 /= ?lexx ?ler01 //.
  rewrite divr_ge0 ?subr_ge0 ?(ltW kwp) //= ler_pdivr_mulr // mul1r.
  by rewrite ler_subl_addl -wE.
- rewrite e ler_subr_addr -ler_subr_addl ler_pdivr_mulr //.
  apply: (@le_trans _ _ (1 - t)); first by rewrite ler_add2r ler_subl_addr ler_addl.
  by rewrite ler_pemulr // subr_ge0.
- by rewrite expect_false mulr1 mulr0 addr0 mulrC cE addrCA subrr addr0.
- by rewrite e divfK.
Qed.

(* The cap 1/t, for t from 1 - delta. *)
Lemma T3_sharp_cap : 1 - delta <= t -> attains (1 / t).
Proof.
move=> td; pose c := (t - (1 - delta)) / delta.
have cE : delta * c = t - (1 - delta).
  case: (eqVneq delta 0) => [e|ne]; last by rewrite mulrC divfK.
  by rewrite e mul0r; apply/esym/eqP; rewrite subr_eq0 eq_le subr0 t1 -[1]subr0 -e td.
have e : expect (four true) (test4 1 1 1 c) = 1.
  by rewrite expect_true !mulr1 -addrA (addrC (k * w)) -wE addrCA subrr addr0.
exists (test4 1 1 1 c); split.
- move=> [[] []]; rewrite /test4 /= ?lexx ?ler01 //.
  rewrite divr_ge0 ?subr_ge0 //=; case: (eqVneq delta 0) => [z|ne].
    by rewrite /c z invr0 mulr0 ler01.
  by rewrite ler_pdivr_mulr ?lt_def ?ne // mul1r ler_subl_addr addrCA subrr addr0.
- by rewrite e.
- by rewrite expect_false !mulr1 -wE cE addrCA subrr addr0.
- by rewrite e divfK.
Qed.

(* T3 under (eps, delta): the least of the three terms is attained, at every t. *)
Lemma eps_delta_attained : attains (eps_delta_bound k delta t).
Proof.
have e2 : k + delta / t = (k * t + delta) / t by rewrite mulrDl mulfK.
have le x y : x <= y -> x / t <= y / t by move=> h; rewrite ler_pmul2r ?invr_gt0.
pose D := 1 - delta - t * (1 + k).
have d12 : 1 - (k * t + delta) = D + t by rewrite /D; ring.
have d23 : 1 - (1 - delta - t) / k - (k * t + delta) = (k - 1) * D / k.
  apply: (mulIf kn); rewrite !mulrBl !divfK // /D; ring.
have km : 0 <= k - 1 by rewrite subr_ge0.
have ik : 0 <= k^-1 by rewrite invr_ge0 ltW.
rewrite /eps_delta_bound; case: (leP t w) => tw.
  have D0 : 0 <= D by rewrite subr_ge0 -ler_pdivl_mulr.
  have l1 : k + delta / t <= 1 / t by rewrite e2 le // -subr_ge0 d12 addr_ge0 // ltW.
  have l2 : k + delta / t <= (1 - (1 - delta - t) / k) / t.
    by rewrite e2 le // -subr_ge0 d23 !mulr_ge0.
  by rewrite (min_idPl l2) (min_idPr l1); apply: T3_sharp_one_k.
have D0 : D <= 0 by rewrite subr_le0 -ler_pdivr_mulr // ltW.
case: (leP t (1 - delta)) => td.
  have l1 : (1 - (1 - delta - t) / k) / t <= 1 / t.
    by apply: le; rewrite ler_subl_addr ler_addl mulr_ge0 // subr_ge0.
  have l2 : (1 - (1 - delta - t) / k) / t <= k + delta / t.
    by rewrite e2 le // -subr_le0 d23 mulr_le0_ge0 // mulr_ge0_le0.
  by rewrite (min_idPr l2) (min_idPr l1); apply: T3_sharp_reversed => //; apply: ltW.
have l1 : 1 / t <= k + delta / t.
  rewrite e2 le // -ler_subl_addr; apply: le_trans (ltW td) _.
  by rewrite ler_pemull // ltW.
have l2 : 1 / t <= (1 - (1 - delta - t) / k) / t.
  rewrite le // ler_addl oppr_ge0 mulr_le0_ge0 // subr_le0; exact: ltW.
have -> : Num.min (1 / t) (Num.min (k + delta / t) ((1 - (1 - delta - t) / k) / t)) = 1 / t.
  by apply/min_idPl; rewrite le_minr l1 l2.
by apply: T3_sharp_cap; apply: ltW.
Qed.

(* T3 under (eps, delta) is sharp: for every t there are an (eps, delta)-private filter, a policy and a
   utility that ignores the group such that both groups keep the floor and R equals the bound. *)
Theorem T3_sharp (X : finType) gamma : 0 < gamma -> exists phi : bool * bool -> R,
  let E := utility (induced (@no_context R X) four (grant phi)) (granted 0 gamma) in
  [/\ kernel four, every_pair (dp k delta) four, policy (grant phi), has_floor (t * gamma) E &
      forall x, E x false = t * gamma /\ E x true = eps_delta_bound k delta t * E x false].
Proof.
move=> g0; have [phi [te fl e1 e0]] := eps_delta_attained; exists phi.
have kf := kernel_four; split=> //=; first exact: dp_four.
- exact: policy_grant.
- move=> x a; rewrite utility_grant // add0r subr0 mulrC ler_pmul2l //.
  by case: a => //; rewrite e1.
- by move=> x; rewrite !utility_grant // !add0r subr0 e1 e0; split; [apply: mulrC|apply: mulrCA].
Qed.

End Sharp.
