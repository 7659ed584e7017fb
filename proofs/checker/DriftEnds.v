(* The greatest quotient of ends bounds all that are compared, and where no quotient has to be above a number, all cells can be moved so
   that none is. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Drift.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Quotients.
Variable R : realFieldType.
Local Notation ratio := (@ratio R).
Local Notation extended := (@extended R).
Implicit Types (x y t V : R).

Lemma no_more_refl (v : option R) : no_more v v.
Proof. by case: v => //= v. Qed.

Lemma no_more_through (v u w : option R) : no_more v u -> no_more u w -> no_more v w.
Proof. by case: v u w => [v|] [u|] [w|] //=; apply: le_trans. Qed.

Lemma quotient_mono t t' (b b' : R) : 0 <= t -> t <= t' -> 0 <= b' -> b' <= b -> no_more (quotient t b) (quotient t' b').
Proof.
move=> t0 tt b0 bb; rewrite /quotient; case: (eqVneq b' 0) => [e|n].
  case: (eqVneq t' 0) => [e'|//]; first last.
    by case: (eqVneq b 0) => // _; case: (eqVneq t 0).
  have -> : t = 0 by apply: le_anti; rewrite t0 -e' tt.
  by rewrite eqxx; case: (eqVneq b 0) => [_|_] /=; rewrite ?mul0r ?ler01 ?lexx.
have bp : 0 < b' by rewrite lt_def n.
have bq : 0 < b := lt_le_trans bp bb.
rewrite gt_eqF //=; apply: (@le_trans _ _ (t' / b)); first by rewrite ler_pmul2r ?invr_gt0.
by rewrite ler_wpmul2l ?(le_trans t0) // ler_pinv // inE unitfE gt_eqF.
Qed.

Lemma above_exceeds V x y : 0 <= y -> 0 <= V -> V * y < x -> ~~ no_more (quotient x y) (Some V).
Proof.
move=> y0 V0 lt; rewrite /quotient; case: (eqVneq y 0) => [e|n].
  by rewrite e mulr0 in lt; rewrite gt_eqF.
by rewrite /= -ltNge ltr_pdivl_mulr // lt_def n.
Qed.

Lemma quotient_same x : quotient x x = Some 1.
Proof. by rewrite /quotient; case: (eqVneq x 0) => // n; rewrite divff. Qed.

Lemma ratio_quotient_of p q : 0 <= ratio q -> extended (quotient_of p q) = quotient (ratio p) (ratio q).
Proof.
rewrite /quotient_of /quotient !(no_numeratorE R); case: (eqVneq (ratio q) 0) => [_ _|n q0].
  by case: (eqVneq (ratio p) 0) => _ //=; rewrite ratio_one.
by rewrite /= ratio_times ratio_inverse // (positive_fractionE R) lt_def n.
Qed.

Lemma not_above_extended v w : not_above v w = no_more (extended v) (extended w).
Proof. by case: v w => [v|] [w|] //=; rewrite (at_mostE R). Qed.

Lemma largerP v w : no_more (extended v) (extended (larger v w)) /\ no_more (extended w) (extended (larger v w)).
Proof.
rewrite /larger not_above_extended; case: ifP => [le|/negbT gt]; split=> //; try exact: no_more_refl.
by case: v w gt => [v|] [w|] //=; rewrite -ltNge => /ltW.
Qed.

(* ---- The greatest quotient ---- *)

Definition top_end (e : Z * (Q * Q)) : R := ratio e.2.1.
Definition bottom_end (e : Z * (Q * Q)) : R := ratio e.2.2.
Definition nonneg_ends (es : list (Z * (Q * Q))) : Prop := forall e, List.In e es -> 0 <= top_end e /\ 0 <= bottom_end e.

Lemma widest_fromP es best top bottom : nonneg_ends es -> 0 <= ratio top -> 0 <= ratio bottom ->
  let r := extended (widest_from best top bottom es) in
  [/\ no_more (extended best) r, forall e t, List.In e es -> 0 <= t -> t <= ratio top -> no_more (quotient t (bottom_end e)) r,
      forall e b, List.In e es -> ratio bottom <= b -> no_more (quotient (top_end e) b) r
    & forall e f, List.In e es -> List.In f es -> e.1 <> f.1 -> no_more (quotient (top_end e) (bottom_end f)) r].
Proof.
elim: es best top bottom => [|e es IH] best top bottom nonneg top0 bottom0 /=; first by split=> //; apply: no_more_refl.
set best' := larger _ _; set top' := no_less _ _; set bottom' := no_more_of _ _.
have topE : ratio top' = Num.max (ratio top) (top_end e) by rewrite /top' /no_less (at_mostE R); case: leP.
have bottomE : ratio bottom' = Num.min (ratio bottom) (bottom_end e) by rewrite /bottom' /no_more_of (at_mostE R); case: leP.
have [et eb] := nonneg e (or_introl erefl).
have [||| in_best tops bottoms pairs] := IH best' top' bottom'.
- by move=> f fin; apply: nonneg; right.
- by rewrite topE le_maxr top0.
- by rewrite bottomE le_minr bottom0.
have [a1 a2] := largerP (larger best (quotient_of e.2.1 bottom)) (quotient_of top e.2.2).
have [b1 b2] := largerP best (quotient_of e.2.1 bottom).
have into v : no_more v (extended best') -> no_more v (extended (widest_from best' top' bottom' es)).
  by move/no_more_through; apply.
have own t : 0 <= t -> t <= ratio top -> no_more (quotient t (bottom_end e)) (extended (widest_from best' top' bottom' es)).
  move=> t0 tt; apply: into; apply: no_more_through a2; rewrite ratio_quotient_of //; exact: quotient_mono.
have own' b : ratio bottom <= b -> no_more (quotient (top_end e) b) (extended (widest_from best' top' bottom' es)).
  move=> bb; apply: into; apply: (no_more_through _ a1); apply: (no_more_through _ b2); rewrite ratio_quotient_of //; exact: quotient_mono.
split.
- by apply: into; apply: (no_more_through b1 a1).
- by move=> f t [<-|fin] t0 tt; [apply: own | apply: tops => //; rewrite topE le_maxr tt].
- by move=> f b [<-|fin] bb; [apply: own' | apply: bottoms => //; rewrite bottomE le_minl bb].
move=> f h [<-|fin] [<-|hin] ne //.
- by apply: tops => //; rewrite topE le_maxr lexx orbT.
- by apply: bottoms => //; rewrite bottomE le_minl lexx orbT.
exact: pairs.
Qed.

Lemma widest_ofP best es : nonneg_ends es ->
  no_more (extended best) (extended (widest_of_ends best es)) /\
  forall e f, List.In e es -> List.In f es -> e.1 <> f.1 -> no_more (quotient (top_end e) (bottom_end f)) (extended (widest_of_ends best es)).
Proof.
case: es => [|e es] nonneg /=; first by split=> //; apply: no_more_refl.
have [et eb] := nonneg e (or_introl erefl).
have [|in_best tops bottoms pairs] := @widest_fromP es best e.2.1 e.2.2 _ et eb; first by move=> f fin; apply: nonneg; right.
by split=> // f h [<-|fin] [<-|hin] ne //; [apply: tops | apply: bottoms | apply: pairs].
Qed.

Lemma greatest_ofP blocks : (forall b, List.In b blocks -> nonneg_ends b) ->
  no_more (Some 1) (extended (greatest_of blocks)) /\
  forall b e f, List.In b blocks -> List.In e b -> List.In f b -> e.1 <> f.1 -> no_more (quotient (top_end e) (bottom_end f)) (extended (greatest_of blocks)).
Proof.
rewrite /greatest_of; have -> : Some (1 : R) = extended (Some one) by rewrite /= ratio_one.
move: (Some one) => best; elim: blocks best => [|b blocks IH] best nonneg /=; first by split=> //; apply: no_more_refl.
have [in_best pairs] := widest_ofP best (nonneg b (or_introl erefl)).
have [|in_rest others] := IH (widest_of_ends best b); first by move=> d din; apply: nonneg; right.
split; first exact: no_more_through in_best in_rest.
move=> d e f [<-|din] ein fin ne; last exact: (others d).
exact: no_more_through (pairs e f ein fin ne) in_rest.
Qed.

(* ---- All are moved together as far as their ends let them ---- *)

Section Together.
Variables (A : Type) (s : list A) (lo hi : A -> R).
Hypothesis ends : forall a, List.In a s -> 0 <= lo a /\ lo a <= hi a.

Definition most_low : R := \big[Num.max/0]_(a <- s) lo a.
Definition meeting : R := \big[Num.min/most_low]_(a <- s) hi a.
Definition together (a : A) : R := Num.max (lo a) meeting.

Lemma most_lowP r : (forall a, List.In a r -> lo a <= \big[Num.max/0]_(a <- r) lo a) /\
  (\big[Num.max/0]_(a <- r) lo a = 0 \/ exists2 a, List.In a r & lo a = \big[Num.max/0]_(a <- r) lo a).
Proof.
elim: r => [|a r [le at_]]; first by split=> //; left; rewrite big_nil.
rewrite big_cons; split=> [c [<-|/le cin]|]; rewrite ?le_maxr ?lexx ?cin ?orbT //.
by case: (leP (lo a) (\big[Num.max/0]_(c <- r) lo c)) => _; [case: at_ => [->|[c cin e]]; [left | right; exists c; [right|]] | right; exists a; [left|]].
Qed.

Lemma meetingP r m : (forall a, List.In a r -> \big[Num.min/m]_(a <- r) hi a <= hi a) /\ \big[Num.min/m]_(a <- r) hi a <= m /\
  (\big[Num.min/m]_(a <- r) hi a = m \/ exists2 a, List.In a r & hi a = \big[Num.min/m]_(a <- r) hi a).
Proof.
elim: r => [|a r [le [below at_]]]; first by rewrite big_nil; split=> //; split=> //; left.
rewrite big_cons; split=> [c [<-|/le cin]|]; rewrite ?le_minl ?lexx ?cin ?orbT //; split; first by rewrite below orbT.
by case: (leP (hi a) (\big[Num.min/m]_(c <- r) hi c)) => _; [right; exists a; [left|] | case: at_ => [->|[c cin e]]; [left | right; exists c; [right|]]].
Qed.

Lemma together_between a : List.In a s -> lo a <= together a <= hi a.
Proof.
move=> ain; have [_ le] := ends ain; rewrite /together le_maxr lexx /= le_maxl le.
by have [+ _] := meetingP s most_low; apply.
Qed.

(* Then all are the same, or no ratio is above that of a lower end and an upper end which do not meet. *)
Lemma together_ratio a b : List.In a s -> List.In b s -> quotient (together a) (together b) = Some 1 \/
  exists i j, [/\ List.In i s, List.In j s, hi j < lo i & no_more (quotient (together a) (together b)) (quotient (lo i) (hi j))].
Proof.
move=> ain bin; have [low low_at] := most_lowP s; have [_ [below at_]] := meetingP s most_low.
rewrite -/most_low in low low_at; rewrite -/meeting in below at_.
have top c : List.In c s -> together c <= most_low by move=> cin; rewrite /together le_maxl low.
have bottom c : meeting <= together c by rewrite /together le_maxr lexx orbT.
case: at_ => [same|[j jin hj]].
  have all_same c : List.In c s -> together c = most_low by move=> cin; apply: le_anti; rewrite top //= -same bottom.
  by left; rewrite !all_same // quotient_same.
case: (ltrP meeting most_low) => lt; last first.
  have same : meeting = most_low by apply: le_anti; rewrite below lt.
  have all_same c : List.In c s -> together c = most_low by move=> cin; apply: le_anti; rewrite top //= -same bottom.
  by left; rewrite !all_same // quotient_same.
have hj0 : 0 <= hi j by have [j0 jle] := ends jin; apply: le_trans jle.
case: low_at => [zero_|[i iin li]]; first by move: lt; rewrite zero_ -hj ltNge hj0.
right; exists i, j; split=> //; first by rewrite hj li.
apply: quotient_mono => //; rewrite ?li ?hj ?top //.
by have [a0 _] := ends ain; rewrite /together le_maxr a0.
Qed.
End Together.
End Quotients.
