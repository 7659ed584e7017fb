(* T15, second part: nobody's group is recorded, but of each cell w it is known which share belongs to which group.

   Reading key.  Pw w is the share of the cell w, K w u = P(u|w), share w a = P(a|w).  A completion j says how each cell is divided,
   j w a u = P(a,u|w); [got j a] is what the group a gets in it, E(a) P(a), and [mass a] = P(a).  A group takes a slice of each cell.
   theta w is a threshold, whatever it is. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T13 T13_near.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- One cell ---- *)

Section Slice.
Variables (R : realFieldType) (U : finType).
Implicit Types (T r c : U -> R) (s theta : R).

Lemma slice_le s T r c theta : part_of s T r -> \sum_u r u * c u <= theta * s + \sum_u T u * Num.max 0 (c u - theta).
Proof.
move=> [rT r1]; rewrite -ler_subl_addl -r1 mulr_sumr -sumrB; apply: ler_sum => u _; case/andP: (rT u) => r0 rTu.
rewrite [theta * _]mulrC -mulrBr; apply: (@le_trans _ _ (r u * Num.max 0 (c u - theta))).
  by apply: ler_wpmul2l => //; rewrite le_maxr lexx orbT.
by apply: ler_wpmul2r => //; rewrite le_maxr lexx.
Qed.

Lemma slice_ge s T r c theta : part_of s T r -> theta * s - \sum_u T u * Num.max 0 (theta - c u) <= \sum_u r u * c u.
Proof.
move=> pr; have le := slice_le (fun u => - c u) (- theta) pr; rewrite -ler_opp2.
have -> : - (\sum_u r u * c u) = \sum_u r u * - c u by rewrite -sumrN; apply: eq_bigr => u _; rewrite mulrN.
apply: le_trans le _; rewrite opprB mulNr addrC ler_add2r le_eqVlt; apply/orP; left; apply/eqP; apply: eq_bigr => u _.
by rewrite opprK addrC.
Qed.

(* What is taken from the least is the worst slice. *)
Lemma least_slice s T r r' c : from_least s T c r -> part_of s T r' -> \sum_u r u * c u <= \sum_u r' u * c u.
Proof.
move=> [[rT r1] least] [rT' r1']; have [u0 _ | no] := pickP (fun _ : U => true); last by rewrite !big_pred0.
have [theta [below above]] : exists theta, (forall u, c u < theta -> r u = T u) /\ (forall u, theta < c u -> r u = 0).
  case: (pickP (fun u => r u != T u)) => [u1 u1n|all]; last first.
    exists (greatest u0 c); split=> [u _|u]; first by have /negbFE/eqP := all u.
    by rewrite ltNge greatest_ge.
  have [w wn wmin] := @arg_minP _ _ _ u1 (fun u => r u != T u) c u1n.
  exists (c w); split=> u h; first by apply/eqP/negbNE/negP => /wmin; rewrite leNgt h.
  apply/eqP; case/andP: (rT u); rewrite le_eqVlt eq_sym => /orP[//|pos] _.
  by move: wn; rewrite (least _ _ h pos) eqxx.
have z : \sum_u (r' u - r u) = 0 by rewrite sumrB r1 r1' subrr.
rewrite -subr_ge0 -sumrB (_ : \sum_u _ = \sum_u (r' u - r u) * (c u - theta)); last first.
  under [RHS]eq_bigr do rewrite mulrBr; rewrite [RHS]sumrB -[X in _ = _ - X]mulr_suml z mul0r subr0.
  by apply: eq_bigr => u _; rewrite mulrBl.
apply: sumr_ge0 => u _; case/andP: (rT' u) => r0 rT'u; case: (ltrgtP (c u) theta) => h.
- by rewrite (below _ h) -mulrNN mulr_ge0 // oppr_ge0 subr_le0 // ltW.
- by rewrite (above _ h) subr0 mulr_ge0 // subr_ge0 ltW.
by rewrite h subrr mulr0.
Qed.

(* The rest of a slice. *)
Lemma part_rest s T r : law T -> part_of s T r -> part_of (1 - s) T (fun u => T u - r u).
Proof.
move=> [T0 T1] [rT r1]; split=> [u|]; last by rewrite sumrB T1 r1.
by case/andP: (rT u) => r0 rTu; rewrite subr_ge0 rTu ler_subl_addr ler_addl.
Qed.

(* A smaller slice lies within a greater one. *)
Lemma worst_mono s s' T c u : s <= s' -> from_worst s T c u <= from_worst s' T c u.
Proof.
rewrite /from_worst; elim: (rising c) s s' => //= v l IH s s' le; case: eqP => _.
  by rewrite le_minr !le_minl lexx le orbT.
apply: IH; case: (leP (T v) s) => h; case: (leP (T v) s') => h'; rewrite ?subrr ?ler_add2r ?subr_ge0 //.
by have := le_trans h le; rewrite leNgt h'.
Qed.

End Slice.

(* ---- All cells ---- *)

Section Cells.
Variables (R : realFieldType) (W A U : finType).
Variables (Pw : W -> R) (K : W -> U -> R) (share : W -> A -> R) (g : W -> U -> R).
Hypotheses (Pw0 : forall w, 0 <= Pw w) (kK : kernel K) (kS : kernel share).
Implicit Types (j : W -> A -> U -> R) (S : {set A}) (theta : W -> R).

(* A division of each cell in which nobody is counted twice or left out. *)
Definition division j : Prop := forall w, (forall a u, 0 <= j w a u) /\ (forall u, \sum_a j w a u = K w u).
Definition completion j : Prop := division j /\ forall w a, \sum_u j w a u = share w a.

Definition got j a : R := \sum_w Pw w * \sum_u j w a u * g w u.
Definition mass a : R := \sum_w Pw w * share w a.
Definition mean j a : R := got j a / mass a.

(* The ends of what the groups S get together, by thresholds. *)
Definition most theta S : R := \sum_w Pw w * (theta w * (\sum_(a in S) share w a) + \sum_u K w u * Num.max 0 (g w u - theta w)).
Definition least theta S : R := \sum_w Pw w * (theta w * (\sum_(a in S) share w a) - \sum_u K w u * Num.max 0 (theta w - g w u)).

Lemma part_union j S w : completion j -> part_of (\sum_(a in S) share w a) (K w) (fun u => \sum_(a in S) j w a u).
Proof.
move=> [dj sj]; have [j0 jK] := dj w; split=> [u|].
  rewrite sumr_ge0 //= -jK [leRHS](bigID (mem S)) /= ler_addl.
  by apply: sumr_ge0.
by rewrite exchange_big; apply: eq_bigr => a _; apply: sj.
Qed.

Lemma got_union j S : \sum_(a in S) got j a = \sum_w Pw w * \sum_u (\sum_(a in S) j w a u) * g w u.
Proof.
rewrite /got exchange_big; apply: eq_bigr => w _; rewrite -mulr_sumr exchange_big; congr (_ * _).
by apply: eq_bigr => u _; rewrite mulr_suml.
Qed.

(* Any thresholds bound what groups get together; one group is S = [set a]. *)
Theorem T15_cells j theta theta' S : completion j -> least theta S <= \sum_(a in S) got j a <= most theta' S.
Proof.
move=> cj; rewrite got_union; apply/andP; split; apply: ler_sum => w _; apply: ler_wpmul2l => //.
  exact: (slice_ge (g w) (theta w) (part_union S w cj)).
exact: (slice_le (g w) (theta' w) (part_union S w cj)).
Qed.

(* The ratio of a pair. *)
Theorem T15_cells_pair j theta theta' V a a' : completion j -> 0 <= V -> 0 < mass a -> 0 < mass a' ->
  most theta [set a] / mass a <= V * (least theta' [set a'] / mass a') -> mean j a <= V * mean j a'.
Proof.
move=> cj V0 pa pa' le; have := T15_cells theta theta [set a] cj; have := T15_cells theta' theta' [set a'] cj.
rewrite !big_set1 => /andP[lo _] /andP[_ hi]; apply: (@le_trans _ _ (most theta [set a] / mass a)).
  by rewrite /mean ler_pmul2r ?invr_gt0.
by apply: le_trans le _; apply: ler_wpmul2l => //; rewrite /mean ler_pmul2r ?invr_gt0.
Qed.

(* If the groups S must get, in the mean, more than V times what the groups S' can get, then in every completion two of them are so far apart. *)
Theorem T15_cells_exceeds j theta theta' V S (S' : {set A}) : completion j -> 0 <= V -> (forall a, 0 < mass a) ->
  V * most theta' S' * (\sum_(a in S) mass a) < least theta S * (\sum_(a in S') mass a) ->
  exists a a', [/\ a \in S, a' \in S' & V * mean j a' < mean j a].
Proof.
move=> cj V0 pm far.
case: (pickP (fun aa : A * A => [&& aa.1 \in S, aa.2 \in S' & V * mean j aa.2 < mean j aa.1])) => [[a a'] /and3P[]|none].
  by exists a, a'.
have gm a : got j a = mean j a * mass a by rewrite /mean divfK // gt_eqF.
have le a a' : a \in S -> a' \in S' -> mean j a <= V * mean j a'.
  by move=> aS aS'; have := none (a, a'); rewrite /= aS aS' /= => /negbT; rewrite -leNgt.
have [/andP[lo _] /andP[_ hi]] := (T15_cells theta theta S cj, T15_cells theta' theta' S' cj).
have m0 (B : {set A}) : 0 <= \sum_(a in B) mass a by apply: sumr_ge0 => a _; apply: ltW.
have : (\sum_(a in S) got j a) * (\sum_(a' in S') mass a') <= (\sum_(a in S) mass a) * (\sum_(a' in S') V * got j a').
  rewrite !big_distrlr /=; apply: ler_sum => a aS; apply: ler_sum => a' aS'.
  rewrite !gm [leRHS](_ : _ = V * mean j a' * (mass a * mass a')); last by ring.
  by rewrite -mulrA; apply: ler_wpmul2r; [apply: mulr_ge0; apply: ltW|apply: le].
rewrite -mulr_sumr leNgt => /negP[]; apply: (@lt_le_trans _ _ (least theta S * (\sum_(a in S') mass a))).
  by apply: le_lt_trans far; rewrite mulrC; apply: ler_wpmul2r => //; apply: ler_wpmul2l.
by apply: ler_wpmul2r.
Qed.

(* The extremes of a pair are attained together: a takes the best slice of each cell, a' the worst. *)
Theorem T15_cells_attained a a' : a != a' -> exists j, completion j /\
  forall j', completion j' -> got j' a <= got j a /\ got j a' <= got j' a'.
Proof.
move=> ne; pose lo w := from_worst (share w a') (K w) (g w); pose keep w := from_worst (1 - share w a) (K w) (g w).
have s0 w c : 0 <= share w c by case: (kS w).
have two w : share w a' <= 1 - share w a.
  rewrite ler_subr_addr -(proj2 (kS w)) (bigD1 a') //= ler_add2l (bigD1 a) //= ler_addl.
  by apply: sumr_ge0.
have s1 w c : share w c <= 1 by apply: law_le1.
have [flo fkeep] : (forall w, from_least (share w a') (K w) (g w) (lo w)) /\ (forall w, from_least (1 - share w a) (K w) (g w) (keep w)).
  by split=> w; apply: from_worst_least; rewrite ?s0 ?s1 // subr_ge0 s1 ler_subl_addr ler_addl s0.
pose between w u := keep w u - lo w u; pose left w := 1 - share w a - share w a'.
have b0 w u : 0 <= between w u by rewrite subr_ge0 worst_mono.
have bsum w : \sum_u between w u = left w by rewrite sumrB (proj2 (proj1 (fkeep w))) (proj2 (proj1 (flo w))).
have an : (a' == a) = false by rewrite eq_sym (negbTE ne).
have divided (F : A -> R) : \sum_c F c = F a + (F a' + \sum_(c | (c != a) && (c != a')) F c).
  by rewrite (bigD1 a) //= (bigD1 a') //= an.
have others w : \sum_(c | (c != a) && (c != a')) share w c = left w.
  have := proj2 (kS w); rewrite divided /left => <-; set r := \sum_(c | _) _; ring.
have l0 w : 0 <= left w by rewrite subr_ge0.
pose j w c u := if c == a then K w u - keep w u else if c == a' then lo w u else between w u * share w c / left w.
have cj : completion j.
  split=> [w|w c]; first split=> [c u|u].
  - rewrite /j; case: eqP => _; first by rewrite subr_ge0; case/andP: (proj1 (proj1 (fkeep w)) u).
    case: eqP => _; first by case/andP: (proj1 (proj1 (flo w)) u).
    by rewrite divr_ge0 ?mulr_ge0.
  - rewrite divided {1 2}/j eqxx an eqxx (eq_bigr (fun c => between w u / left w * share w c)) => [|c /andP[/negbTE ca /negbTE ca']].
      rewrite -mulr_sumr others; have [z|z] := eqVneq (left w) 0; last by rewrite divfK // /between; ring.
      have bz : between w u = 0 by apply: (psumr_eq0P (P := xpredT) (F := between w)); rewrite ?bsum.
      by rewrite bz !mul0r addr0; move/eqP: bz; rewrite subr_eq0 => /eqP->; rewrite subrK.
    by rewrite /j ca ca' mulrAC.
  rewrite /j; case: eqP => [->|/eqP/negbTE ca].
    by rewrite sumrB (proj2 (kK w)) (proj2 (proj1 (fkeep w))) opprB addrC subrK.
  case: eqP => [->|/eqP/negbTE ca']; first by rewrite (proj2 (proj1 (flo w))).
  rewrite -mulr_suml -mulr_suml bsum; have [z|z] := eqVneq (left w) 0; last by rewrite mulrAC divff // mul1r.
  rewrite z !mul0r; apply/esym; apply: (psumr_eq0P (P := fun c => (c != a) && (c != a')) (fun c _ => s0 w c)); rewrite ?ca ?ca' //.
  by rewrite others.
exists j; split=> // j' cj'.
have slice w c : part_of (share w c) (K w) (j' w c).
  have := part_union [set c] w cj'; rewrite big_set1 => -[h1 h2]; split=> [u|]; first by have := h1 u; rewrite big_set1.
  by rewrite -[RHS]h2; apply: eq_bigr => u _; rewrite big_set1.
split; apply: ler_sum => w _; apply: ler_wpmul2l => //.
  have rest r : \sum_u (K w u - r u) * g w u = \sum_u K w u * g w u - \sum_u r u * g w u.
    by rewrite -sumrB; apply: eq_bigr => u _; rewrite mulrBl.
  have := least_slice (fkeep w) (part_rest (kK w) (slice w a)); rewrite /j eqxx !rest => le.
  by rewrite ler_subr_addr -ler_subr_addl.
by rewrite /j an eqxx; apply: (least_slice (flo w) (slice w a')).
Qed.

(* Shares within intervals [l, h]: V bounds the mean of a group if the greatest excess over V of a slice is nowhere positive in sum. *)
Theorem T15_cells_interval j (l h : W -> A -> R) theta V a : division j -> (forall w, l w a <= \sum_u j w a u <= h w a) ->
  \sum_w Pw w * (\sum_u K w u * Num.max 0 (g w u - theta w) + Num.max (l w a * (theta w - V)) (h w a * (theta w - V))) <= 0 ->
  got j a <= V * (\sum_w Pw w * (\sum_u j w a u)).
Proof.
move=> dj lh le; rewrite -subr_le0; apply: le_trans le; rewrite mulr_sumr -sumrB; apply: ler_sum => w _.
rewrite mulrCA -mulrBr; apply: ler_wpmul2l => //; set s := \sum_u j w a u.
have pr : part_of s (K w) (j w a).
  split=> // u; have [j0 jK] := dj w; rewrite j0 -jK (bigD1 a) //= ler_addl.
  by apply: sumr_ge0.
rewrite ler_subl_addr; apply: le_trans (slice_le (g w) (theta w) pr) _.
rewrite addrC -addrA ler_add2l -ler_subl_addr -mulrBl; case/andP: (lh w); rewrite -/s => ls sh.
rewrite le_maxr mulrC; apply/orP; case: (leP 0 (theta w - V)) => t; [right; apply: ler_wpmul2r|left; apply: ler_wnmul2r] => //.
exact: ltW.
Qed.

End Cells.
