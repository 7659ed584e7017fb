(* Claims about cells that move: what is accepted holds of the table. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Checker Drift TableSound FiguresSound.
From FairauditChecker Require Import MovedLaws MovedCells DriftCells DriftUnits DriftPairs DriftEnds DriftSides DriftSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Lemma and_alsoE a b : and_also a b = Some true -> a = Some true /\ b = Some true.
Proof. by case: a b => [[]|] [[]|]. Qed.

Section Claims.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).
Local Notation extended := (@extended R).
Local Notation movers := (movers_of T (rows_of T)).
Local Notation A := (group_rows T (rows_of T)).

Lemma figure_compares local f : figure_holds R T (ratio_of_all local) (Some f) ->
  [/\ exists_at_all R T (ratio_of_all local), compares R T (ratio_of_all local) (witness f),
      quantity_at R T (ratio_of_all local) (witness f) = extended (value f)
    & forall p, compares R T (ratio_of_all local) p -> no_more (quantity_at R T (ratio_of_all local) p) (extended (value f))].
Proof. by case=> ex [[comp firsts] <- _]; split=> // p /firsts[]. Qed.

Lemma ratio_of_all_is_ratio local : is_ratio (ratio_of_all local).
Proof. by case: local. Qed.

(* ---- How far a verdict stands ---- *)

Section Limit.
Variables (keeps : option Q -> option bool) (bound : option Q) (V : R).
Hypotheses (V1 : 1 <= V) (keepsE : forall r b, keeps r = Some b -> b = no_more (extended r) (Some V)).
Hypothesis boundE : forall b, bound = Some b -> ratio b = V.

Let V0 : 0 <= V := le_trans ler01 V1.

Lemma levelE top bottom : level bound top bottom -> ratio top = V * ratio bottom.
Proof.
case/orP => [/andP[]|]; first by rewrite /is_zero !(no_numeratorE R) => /eqP-> /eqP->; rewrite mulr0.
by case e: bound => [b|] // /andP[]; rewrite !(at_mostE R) ratio_times (boundE e) => le ge; apply: le_anti; rewrite le ge.
Qed.

Definition compared_pair k amount local up p high low : Prop :=
  [/\ compares R T (ratio_of_all local) p, higher p <> lower p,
      unit_of T local (at_context p) (higher p) <> [::] /\ unit_of T local (at_context p) (lower p) <> [::],
      side_of k amount up (movers_in T (unit_of T local (at_context p) (higher p))) = Some high
    & side_of k amount (~~ up) (movers_in T (unit_of T local (at_context p) (lower p))) = Some low].

(* A pair exceeds the limit, however its cells move before the amount. *)
Lemma exceeds_before k amount local p high low v D : signed T = false -> an_amount k amount ->
  compared_pair k amount local false p high low ->
  (if level bound (at_end high) (at_end low) then
     Some match k, amount with
       | By_variation, Some w => at_most w (reached high) || at_most w (reached low)
       | By_variation, None => false
       | By_factor, _ => ~~ (constant high && constant low)
       end
   else exceeds_limit keeps (quotient_of (at_end high) (at_end low))) = Some true ->
  before_amount amount v -> drifted T k v D -> one_exceeds T D local V.
Proof.
move=> unsigned amount_ok [comp ne [some some'] one other] apart before dr; exists p => //.
have mv : meant amount v by move: before; case: (amount) => //= w; apply: ltW.
have high_le := side_bounds ok amount_ok some one mv dr; have low_ge := side_bounds ok amount_ok some' other mv dr; rewrite /= in high_le low_ge.
have [h0 l0] := amount_in_ge0 ok unsigned dr comp.
move: apart; case: ifP => [lev [apart]|_].
  apply: above_exceeds => //; have lE := levelE lev.
  have strict : ratio (at_end high) < amount_in T D local (at_context p) (higher p) \/ amount_in T D local (at_context p) (lower p) < ratio (at_end low).
    have hb := side_before ok amount_ok some one before dr; have lb := side_before ok amount_ok some' other before dr.
    move: apart hb lb; case: (k) (amount) => [] [w|] //=; last by rewrite negb_and => /orP[c /(_ c)|c _ /(_ c)]; [left | right].
      by case/orP => [c /(_ c)|c _ /(_ c)]; [left | right].
    by rewrite negb_and => /orP[c /(_ c)|c _ /(_ c)]; [left | right].
  case: strict => strict; first by apply: le_lt_trans strict; rewrite lE; apply: ler_wpmul2l.
  apply: (@lt_le_trans _ _ (V * ratio (at_end low))); first by rewrite ltr_pmul2l // (lt_le_trans ltr01).
  by rewrite -lE.
rewrite /exceeds_limit; case keptE: (keeps _) => [b|] //= [/negbTE no]; have := keepsE keptE; rewrite no.
have ge0 : 0 <= ratio (at_end low) by apply: le_trans low_ge.
rewrite ratio_quotient_of // => kept; apply/negP => within; move: kept; rewrite (@no_more_through R _ _ (Some V) _ within) //.
apply: quotient_mono => //.
exact: (side_ge0 R ok unsigned amount_ok some one).
Qed.

(* Beyond the amount, a pair exceeds the limit. *)
Lemma within_ends k w local p high low v : signed T = false -> is_amount k w -> compared_pair k (Some w) local true p high low ->
  level bound (at_end high) (at_end low) -> rises bound (in_the_end high) (in_the_end low) -> ratio w < v ->
  exists2 D, drifted T k v D & one_exceeds T D local V.
Proof.
move=> unsigned amount_ok [comp ne [some some'] one other] lev up far.
have [D [t [t0 dr hE lE]]] := pair_rises ok (amount := Some w) amount_ok ne some some' one other (erefl (Some w)) far.
exists D => //; exists p => //; have [_ l0] := amount_in_ge0 ok unsigned dr comp; apply: above_exceeds => //.
rewrite hE lE (levelE lev) -subr_gt0.
have -> : (1 - t) * (V * ratio (at_end low)) + t * ratio (in_the_end high) - V * ((1 - t) * ratio (at_end low) + t * ratio (in_the_end low))
  = t * (ratio (in_the_end high) - V * ratio (in_the_end low)) by ring.
rewrite mulr_gt0 // subr_gt0; move: up; rewrite /rises; case e: bound => [b|] //; by rewrite (at_mostE R) ratio_times (boundE e) -ltNge.
Qed.

Lemma verdict_now local f (within : bool) : figure_holds R T (ratio_of_all local) (Some f) -> within = no_more (extended (value f)) (Some V) ->
  target_holds T (ratio_of_all local) V (if within then Within else Exceeds).
Proof.
move=> /figure_compares[ex comp value_f all_f]; case: within => now /=.
  by split=> // p comp_p; apply: no_more_through (all_f p comp_p) _; rewrite -now.
by exists (witness f) => //; rewrite value_f -now.
Qed.

Theorem stand_sound f s : figure_holds R T (ratio_of_all (is_local s)) f -> stand_holds T (rows_of T) A keeps bound f s = Some true -> stands T s V.
Proof.
case: f s => [f|//] [k local within amount exact_ turn fs] /= fig; have [ex comp0 _ _] := figure_compares fig; have unsigned := unsigned_of comp0.
rewrite /stand_holds /=; case: ifP => // /negbFE /and4P[_ _ amount_in verdict].
have amount_ok : an_amount k amount by move: amount_in; rewrite /an_amount; case: (amount).
case keeps_f: (keeps (value f)) verdict => [b|] //= /Bool.eqb_prop b_within; have now := keepsE keeps_f; rewrite {b}b_within in now keeps_f.
case: (local || _) => //; case every: (ends_everywhere _ _ _ _ _ _ _) => [g|] //.
have pairE high low : sides_of T A k amount within local movers fs turn = Some (high, low) -> exists p, compared_pair k amount local within p high low.
  case: (turn) => [p|] // /(sides_ofP R ok unsigned)[comp ne [at_ some] one other].
  by exists (placed local (at_context p) (higher p) (lower p)); rewrite /compared_pair -at_; split.
move: (sides_of T A k amount within local movers fs turn) pairE => named pairE found.
have {}found : (if within then within_stands keeps bound (Stand k local within amount exact_ turn fs) g named
                else exceeds_stands keeps bound (Stand k local within amount exact_ turn fs) g named) = Some true.
  by move: found; case: (turn) => [p|] //; case: (named).
rewrite /stands /=; case: within now keeps_f every pairE found => now keeps_f every pairE found; split=> /=.
- exact: (verdict_now fig now).
- move=> v D vw dr p comp; have mv : meant amount v by move: vw; case: (amount).
  apply: no_more_through (worst_bounds ok unsigned amount_ok every mv dr comp) _.
  by have [kept _] := and_alsoE found; rewrite -(keepsE kept).
- have [_ rest] := and_alsoE found; move: rest; case: (exact_) => //=; case is_w: amount => [w|] //; case e: named => [[high low]|] //=.
  case boundE_: bound => [b|] //; rewrite -boundE_ => -[/andP[lev up]] v far.
  have [p comp] := pairE high low e; rewrite is_w in comp amount_ok; exact: (within_ends unsigned amount_ok comp lev up far).
- exact: (verdict_now fig now).
- move=> v D vw dr; have mv : before_amount amount v by move: vw; case: (amount).
  move: found; rewrite /exceeds_stands; case e: named => [[high low]|] // /and_alsoE[first _]; have [p comp] := pairE high low e.
  exact: (exceeds_before unsigned amount_ok comp first mv dr).
move: found; rewrite /exceeds_stands; case: named {pairE} => [[high low]|] // /and_alsoE[_]; case: (exact_) => //=.
case is_w: amount => [w|] //; case boundE_: bound => [b|] // [small].
have [D dr all_] := best_attained R ok unsigned amount_ok is_w every; exists D => // p comp.
apply: no_more_through (all_ p comp) _; move: small; rewrite (not_above_extended R) /= (boundE boundE_); by [].
Qed.
End Limit.

Lemma stands_for_ratio_sound f s limit : figure_holds R T (ratio_of_all (is_local s)) f ->
  stands_for_ratio T (rows_of T) A f s limit = Some true -> stands T s (ratio limit).
Proof.
move=> fig; rewrite /stands_for_ratio; case: ifP => // limit1; apply: stand_sound fig.
- by move: limit1; rewrite (at_mostE R) ratio_one.
- by move=> r b [<-]; rewrite (not_above_extended R).
by move=> b [<-].
Qed.

(* ---- The ratios within a drift ---- *)

Lemma same_extendedE v w : Drift.same_extended v w -> extended v = extended w.
Proof.
by case: v w => [v|] [w|] //= /andP[]; rewrite !(at_mostE R) => le ge; congr Some; apply: le_anti; rewrite le ge.
Qed.

Definition flipped (p : place) : place := Place (at_rate p) (at_context p) (at_decision p) (lower p) (higher p).

Lemma compares_flipped local p : compares R T (ratio_of_all local) p -> compares R T (ratio_of_all local) (flipped p).
Proof.
by case: local => /and5P[sign_ set_ one other ne]; apply/and5P; split=> //; rewrite eq_sym.
Qed.

Lemma one_way_at_least_1 (D : Z -> Z -> Z -> R) local p : (exists k v, drifted T k v D) -> compares R T (ratio_of_all local) p ->
  no_more (Some 1) (ratio_in T D local p) \/ no_more (Some 1) (ratio_in T D local (flipped p)).
Proof.
move=> [k [v dr]] comp; have [h0 l0] := amount_in_ge0 ok (unsigned_of comp) dr comp.
rewrite /ratio_in -[at_context (flipped p)]/(at_context p) -[higher (flipped p)]/(lower p) -[lower (flipped p)]/(higher p).
move: (amount_in _ _ _ _ (higher p)) (amount_in _ _ _ _ (lower p)) h0 l0 => x y h0 l0.
have one_le (z u w : R) : 0 <= z -> z <= u -> 0 <= w -> w <= z -> no_more (Some 1) (quotient u w).
  by move=> z0 zu w0 wz; rewrite -[Some 1](quotient_same z); apply: quotient_mono.
by case: (leP x y) => [le|/ltW le]; [right; apply: (one_le x) | left; apply: (one_le y)].
Qed.

Lemma neither_above_1 (a b : R) : 0 <= a -> 0 <= b -> no_more (quotient a b) (Some 1) -> no_more (quotient b a) (Some 1) -> quotient a b = Some 1.
Proof.
move=> a0 b0; rewrite /quotient; case: (eqVneq b 0) => [_|bn]; case: (eqVneq a 0) => [_|an] //=.
have ap : 0 < a by rewrite lt_def an. have bp : 0 < b by rewrite lt_def bn.
rewrite !ler_pdivr_mulr // !mul1r => le ge; have -> : a = b by apply: le_anti; rewrite le ge.
by rewrite divff.
Qed.

Theorem ratio_holds_sound f local worst eta v p fs : figure_holds R T (ratio_of_all local) f ->
  ratio_holds T (rows_of T) A f local worst eta v p fs = Some true -> ratio_under_drift T local worst (ratio eta) (extended v).
Proof.
case: f => [f|//] fig; have [ex comp0 _ _] := figure_compares fig; have unsigned := unsigned_of comp0.
rewrite /ratio_holds; case: ifP => // /negbFE /and3P[_ _ eta_ok].
have amount_ok : an_amount By_variation (Some eta) := eta_ok.
case: (local || _) => //; case every: (ends_everywhere _ _ _ _ _ _ _) => [g|] // [/andP[/same_extendedE vE named]].
have st : starts By_variation (ratio eta : R) by apply: amount_starts.
have some_drift : exists D, drifted T By_variation (ratio eta) D.
  by exists (law R T); apply: (all_moved ok) => c c_in; apply: (law_itself ok c_in st).
have pairE high low : sides_of T A By_variation (Some eta) worst local movers fs p = Some (high, low) ->
    exists p, compared_pair By_variation (Some eta) local worst p high low.
  case: (p) => [q|] // /(sides_ofP R ok unsigned)[comp ne [at_ some] one other].
  by exists (placed local (at_context q) (higher q) (lower q)); rewrite /compared_pair -at_; split.
move: (sides_of T A By_variation (Some eta) worst local movers fs p) pairE named => sides pairE named.
rewrite /ratio_under_drift; split=> //; rewrite vE; case: worst every named pairE => every named pairE; split.
- by move=> D dr q comp; apply: (worst_bounds ok unsigned amount_ok every _ dr comp); rewrite /meant.
- case: p named => [q named|one_].
    case: sides named pairE => [[high low]|] //; rewrite /is_reached => /andP[_ /same_extendedE atE] /(_ _ _ erefl) pairE.
    have [p0 [comp ne [some some'] one other]] := pairE.
    have [D [dr hE lE]] := pair_attains R ok unsigned amount_ok ne some some' one other (erefl (Some eta)).
    exists D, p0; split=> //; rewrite /ratio_in hE lE -ratio_quotient_of ?atE ?vE //; exact: (side_ge0 R ok unsigned amount_ok some' other).
  have [D dr] := some_drift; have g1 : extended g = Some 1 by rewrite -vE; have /same_extendedE -> : Drift.same_extended v (Some one) := one_; rewrite /= ratio_one.
  have all_ q comp := worst_bounds (p := q) ok unsigned amount_ok every (lexx (ratio eta) : meant (Some eta) (ratio eta)) dr comp.
  exists D, (witness f); split=> //; rewrite g1 in all_ *.
  have [h0 l0] := amount_in_ge0 ok unsigned dr comp0.
  exact: (neither_above_1 h0 l0 (all_ _ comp0) (all_ _ (compares_flipped comp0))).
- move=> D dr; have mv : meant (Some eta) (ratio eta : R) by apply: lexx.
  case: p named => [q named|one_].
    case: sides named pairE => [[high low]|] //; rewrite /is_reached => /andP[_ /same_extendedE atE] /(_ _ _ erefl) pairE.
    have [p0 [comp ne [some some'] one other]] := pairE.
    have high_le := side_bounds ok amount_ok some one mv dr; have low_ge := side_bounds ok amount_ok some' other mv dr; rewrite /= in high_le low_ge.
    have low0 := side_ge0 R ok unsigned amount_ok some' other.
    exists p0 => //; rewrite -vE -atE ratio_quotient_of //; have [_ l0] := amount_in_ge0 ok unsigned dr comp.
    by apply: quotient_mono => //; exact: (side_ge0 R ok unsigned amount_ok some one).
  have g1 : extended g = Some 1 by rewrite -vE; have /same_extendedE -> : Drift.same_extended v (Some one) := one_; rewrite /= ratio_one.
  have drifts : exists k v, drifted T k v D by exists By_variation, (ratio eta).
  by rewrite g1; case: (one_way_at_least_1 drifts comp0) => one_way; [exists (witness f) | exists (flipped (witness f)); rewrite // compares_flipped].
exact: (best_attained R ok unsigned amount_ok (erefl (Some eta)) every).
Qed.
End Claims.
