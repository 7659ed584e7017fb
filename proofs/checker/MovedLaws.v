(* Laws that move: two of them mixed move no farther, and what bounds the expectation of a moved law is attained, but by no lesser move.

   P is the law of decisions of a cell, D what it may have become, g the utility.  Bounds are those of T16. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions T16.
From FairauditChecker Require Import Statements.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Moved.
Variables (R : realFieldType) (U : finType) (P g : U -> R).
Hypothesis lP : law P.
Implicit Types (k : move) (v w t : R) (D : U -> R).

Definition near k v D : Prop :=
  law D /\ match k with By_variation => tv D P <= v | By_factor => pure_dp v D P /\ pure_dp v P D end.

(* The decisions that can be reached, and the greatest utility of one *)
Definition can_be k u : Prop := k = By_factor -> 0 < P u.
Definition top_is k (top : R) : Prop := (exists2 u, can_be k u & g u = top) /\ forall u, can_be k u -> g u <= top.
Definition starts k v : Prop := match k with By_variation => 0 <= v | By_factor => 1 <= v end.

Lemma all_can u : can_be By_variation u.
Proof. by []. Qed.

Definition mix t D D' (u : U) : R := (1 - t) * D u + t * D' u.

Lemma expect_mix t D D' : expect (mix t D D') g = (1 - t) * expect D g + t * expect D' g.
Proof. by rewrite /expect !mulr_sumr -big_split; apply: eq_bigr => u _; rewrite /mix mulrDl !mulrA. Qed.

Lemma law_mix t D D' : 0 <= t <= 1 -> law D -> law D' -> law (mix t D D').
Proof.
move=> /andP[t0 t1] [D0 D1] [D'0 D'1]; split=> [u|].
  by rewrite /mix addr_ge0 // mulr_ge0 // subr_ge0.
by rewrite big_split /= -!mulr_sumr D1 D'1 !mulr1 subrK.
Qed.

Lemma tv_mix t D D' : 0 <= t <= 1 -> tv (mix t D D') P <= (1 - t) * tv D P + t * tv D' P.
Proof.
move=> /andP[t0 t1]; have t1' : 0 <= 1 - t by rewrite subr_ge0.
rewrite /tv /hockey_stick !mulr_sumr -big_split; apply: ler_sum => u _; rewrite !mul1r le_maxl; apply/andP; split.
  by rewrite addr_ge0 // mulr_ge0 // le_maxr lexx.
have -> : mix t D D' u - P u = (1 - t) * (D u - P u) + t * (D' u - P u) by rewrite /mix; ring.
by rewrite ler_add // ler_wpmul2l // le_maxr lexx orbT.
Qed.

Lemma tv_at_most_1 D : law D -> tv D P <= 1.
Proof.
move=> [D0 D1]; have [P0 _] := lP; rewrite -D1; apply: ler_sum => u _.
by rewrite mul1r le_maxl D0 /= ler_subl_addr ler_addl.
Qed.

Lemma tv_ge0 D : 0 <= tv D P.
Proof. by apply: sumr_ge0 => u _; rewrite le_maxr lexx. Qed.

Lemma near_mix k v t D D' : 0 <= t <= 1 -> near k v D -> near k v D' -> near k v (mix t D D').
Proof.
move=> t01 [lD nD] [lD' nD']; split; first exact: law_mix.
have [t0 t1] := andP t01; have t1' : 0 <= 1 - t by rewrite subr_ge0.
have combine (a b c d : R) : a <= c -> b <= d -> (1 - t) * a + t * b <= (1 - t) * c + t * d.
  by move=> ac bd; rewrite ler_add // ler_wpmul2l.
case: k nD nD' => [nD nD'|[a b] [a' b']]; last first.
  split=> u; first by rewrite -[leRHS](_ : (1 - t) * (v * P u) + t * (v * P u) = _); [apply: combine | ring].
  rewrite -[leLHS](_ : (1 - t) * P u + t * P u = _); last by ring.
  by rewrite mulrDr ![v * (_ * _)]mulrCA; apply: combine.
apply: le_trans (tv_mix _ _ t01) _; rewrite -[leRHS](_ : (1 - t) * v + t * v = _); last by ring.
exact: combine.
Qed.

Lemma near_farther k v w D : near k v D -> v <= w -> near k w D.
Proof.
move=> [lD nD] vw; split=> //; have [D0 _] := lD; have [P0 _] := lP; case: k nD => [|[a b]]; first by move/le_trans; apply.
by split=> u; [apply: le_trans (a u) _ | apply: le_trans (b u) _]; apply: ler_wpmul2r.
Qed.

(* A little of what is reached in the end can be mixed in, when the move may be farther. *)
Lemma can_rise k v w D u : starts k v -> v < w -> near k v D -> can_be k u ->
  exists2 t0, 0 < t0 <= 1 & forall t, 0 <= t <= t0 -> near k w (mix t D (point R u)).
Proof.
move=> st vw [lD nD] can; have [D0 _] := lD; have [P0 _] := lP; case: k st nD can => /= [v0 nD _|v1 [a b] /(_ erefl) Pu].
  exists (Num.min 1 (w - v)); first by rewrite lt_minr ltr01 subr_gt0 vw /= le_minl lexx.
  move=> t /andP[t0]; rewrite le_minr => /andP[t1 tw]; have t01 : 0 <= t <= 1 by rewrite t0.
  split; first by apply: law_mix => //; apply: law_point.
  apply: le_trans (tv_mix _ _ t01) _; apply: (@le_trans _ _ (v + t)); last by rewrite -ler_subr_addl.
  rewrite ler_add //; last by rewrite ler_pimulr // tv_at_most_1 //; apply: law_point.
  by rewrite (le_trans (_ : _ <= tv D P)) // ler_pimull ?tv_ge0 // ler_subl_addr ler_addl.
have v0 : 0 < v := lt_le_trans ltr01 v1; have w0 : 0 < w := lt_trans v0 vw.
have s0 : 0 < (w - v) * P u by rewrite mulr_gt0 // subr_gt0.
have r0 : 0 < 1 - v / w by rewrite subr_gt0 ltr_pdivr_mulr // mul1r.
exists (Num.min 1 (Num.min ((w - v) * P u) (1 - v / w))); first by rewrite !lt_minr ltr01 s0 r0 /= le_minl lexx.
move=> t /andP[t0]; rewrite !le_minr => /and3P[t1 ts tr]; have t01 : 0 <= t <= 1 by rewrite t0.
have lower z : (1 - t) * D z <= D z by rewrite ler_pimull // ler_subl_addr ler_addl.
have vwP z : v * P z <= w * P z by rewrite ler_wpmul2r // ltW.
split; first by apply: law_mix => //; apply: law_point.
split=> z; rewrite /mix /point.
  case: (eqVneq z u) => [->|_]; last by rewrite mulr0 addr0 (le_trans (lower z)) // (le_trans (a z)).
  rewrite mulr1 (le_trans (ler_add (lower u) ts)) // -(ler_add2r (- ((w - v) * P u))) addrK (le_trans (a u)) //.
  by rewrite le_eqVlt; apply/orP; left; apply/eqP; ring.
apply: (le_trans (b z)); rewrite mulrDr; apply: (@le_trans _ _ (w * ((1 - t) * D z))); last by rewrite ler_addl !mulr_ge0 ?ler0n // ltW.
rewrite mulrA ler_wpmul2r //; move: tr; rewrite ler_subr_addr -ler_subr_addl => /(ler_wpmul2l (ltW w0)).
by rewrite mulrCA mulfV ?gt_eqF // mulr1.
Qed.

(* ---- A bound that some move reaches is reached by no lesser one ---- *)

Lemma below_top k top D : law D -> (forall u, ~ can_be k u -> D u = 0) -> top_is k top -> expect D g <= top.
Proof.
move=> [D0 D1] off [_ up]; rewrite -[top]mul1r -D1 mulr_suml; apply: ler_sum => u _.
case: (ltrP 0 (P u)) => Pu; first by rewrite ler_wpmul2l //; apply: up.
case: k off up => off up; first by rewrite ler_wpmul2l //; apply: up.
by rewrite off ?mul0r // => /(_ erefl); rewrite ltNge Pu.
Qed.

Lemma variation_before v w D hi top : near By_variation v D -> v < w -> (forall D', near By_variation w D' -> expect D' g <= hi) ->
  top_is By_variation top -> w <= \sum_(u | g u < top) P u -> expect D g < hi.
Proof.
move=> nD vw bound [[u _ gu] up] far; have [lD near_] := nD; have v0 : 0 <= v := le_trans (tv_ge0 D) near_.
rewrite ltNge; apply/negP => le; have [t /andP[t0 t1] mixed] := can_rise (k := By_variation) v0 vw nD (all_can u).
have {}mixed : near By_variation w (mix t D (point R u)) by apply: mixed; rewrite lexx ltW.
have := le_trans (bound _ mixed) le; rewrite expect_mix expect_point gu.
have -> : (1 - t) * expect D g + t * top = expect D g + t * (top - expect D g) by ring.
rewrite ger_addl pmulr_rle0 // subr_le0 => top_le; have [D0 D1] := lD.
have gap0 z : 0 <= D z * (top - g z) by rewrite mulr_ge0 // subr_ge0; apply: up.
have none z : g z < top -> D z = 0.
  have : \sum_z D z * (top - g z) <= 0.
    under eq_bigr do rewrite mulrBr; rewrite sumrB -mulr_suml D1 mul1r subr_le0; exact: top_le.
  move=> sum0 gz; have : D z * (top - g z) <= 0.
    by apply: le_trans sum0; rewrite (bigD1 z) //= ler_addl; apply: sumr_ge0 => y _.
  by rewrite pmulr_lle0 ?subr_gt0 // => Dz; apply/eqP; rewrite eq_le Dz D0.
have : w <= tv D P; last by rewrite leNgt (le_lt_trans near_ vw).
apply: (le_trans far); rewrite /tv /hockey_stick.
have [P0 P1] := lP.
have -> : \sum_u Num.max 0 (D u - 1 * P u) = \sum_u Num.max 0 (P u - D u).
  apply/eqP; rewrite -subr_eq0 -sumrB; apply/eqP; transitivity (\sum_u (D u - P u)); last by rewrite sumrB D1 P1 subrr.
  apply: eq_bigr => z _; rewrite mul1r; case: (leP 0 (D z - P z)) => s.
    by rewrite (max_idPl _) ?subr0 // -oppr_ge0 opprB.
  by rewrite (max_idPr _) ?sub0r ?opprB // -oppr_le0 opprB ltW.
rewrite big_mkcond; apply: ler_sum => z _; case: ifP => [/none->|_]; first by rewrite subr0 le_maxr lexx orbT.
by rewrite le_maxr lexx.
Qed.

Lemma factor_before v w D hi u u' : near By_factor v D -> v < w -> (forall D', near By_factor w D' -> expect D' g <= hi) ->
  0 < P u -> 0 < P u' -> g u < g u' -> expect D g < hi.
Proof.
move=> [lD [a b]] vw bound Pu Pu' less; have [D0 D1] := lD; have [P0 _] := lP.
have Du : 0 < D u by rewrite lt_def D0 andbT; apply: contraTneq Pu => e; rewrite -leNgt (le_trans (b u)) // e mulr0.
have v0 : 0 < v by have := lt_le_trans Pu (b u); rewrite pmulr_lgt0.
have w0 : 0 < w := lt_trans v0 vw; have ne : u' != u by apply: contraTneq less => ->; rewrite ltxx.
have slack : 0 < D u - P u / w.
  rewrite subr_gt0 ltr_pdivr_mulr //; apply: (le_lt_trans (b u)); rewrite mulrC ltr_pmul2l //.
pose e := Num.min ((w - v) * P u') (D u - P u / w).
have e0 : 0 < e by rewrite lt_minr slack mulr_gt0 // subr_gt0.
have e1 : e <= (w - v) * P u' by rewrite le_minl lexx.
have e2 : e <= D u - P u / w by rewrite le_minl lexx orbT.
pose D' z := D z + e * (point R u' z - point R u z).
have at_u : D' u = D u - e by rewrite /D' /point eqxx eq_sym (negbTE ne) sub0r mulrN1.
have at_u' : D' u' = D u' + e by rewrite /D' /point eqxx (negbTE ne) subr0 mulr1.
have at_z z : z != u -> z != u' -> D' z = D z by rewrite /D' /point => /negbTE-> /negbTE->; rewrite subrr mulr0 addr0.
have least : P u / w <= D' u by rewrite at_u ler_subr_addr addrC -ler_subr_addr.
have sum_point z : \sum_y point R z y = 1 by case: (law_point R z).
have nD' : near By_factor w D'.
  split; first split=> [z|].
  - case: (eqVneq z u) => [->|zu]; first by apply: le_trans least; rewrite divr_ge0 // ltW.
    by case: (eqVneq z u') => [->|zu']; rewrite ?at_u' ?at_z // addr_ge0 // ltW.
  - by rewrite big_split /= D1 -mulr_sumr sumrB !sum_point subrr mulr0 addr0.
  have vwP z : v * P z <= w * P z by rewrite ler_wpmul2r // ltW.
  split=> z; (case: (eqVneq z u) => [->|zu]; last case: (eqVneq z u') => [->|zu']).
  - rewrite at_u (le_trans _ (vwP u)) // (le_trans _ (a u)) // ler_subl_addr ler_addl ltW //.
  - rewrite at_u' (le_trans (ler_add (a u') e1)) // le_eqVlt; apply/orP; left; apply/eqP; ring.
  - by rewrite at_z // (le_trans (a z)).
  - by move: least; rewrite ler_pdivr_mulr // mulrC.
  - rewrite at_u' (le_trans (b u')) // (le_trans (_ : _ <= w * D u')) ?ler_wpmul2r ?(ltW vw) // ler_wpmul2l ?(ltW w0) // ler_addl ltW //.
  - by rewrite at_z // (le_trans (b z)) // ler_wpmul2r // ltW.
have := bound _ nD'; apply: lt_le_trans.
have -> : expect D' g = expect D g + e * (g u' - g u).
  transitivity (expect D g + e * (expect (point R u') g - expect (point R u) g)); last by rewrite !expect_point.
  rewrite /expect -sumrB mulr_sumr -big_split; apply: eq_bigr => z _ /=.
  by rewrite /D'; ring.
by rewrite ltr_addl mulr_gt0 // subr_gt0.
Qed.

Lemma top_not_reached v D top u : near By_factor v D -> top_is By_factor top -> 0 < P u -> g u < top -> expect D g < top.
Proof.
move=> [[D0 D1] [a b]] [_ up] Pu less.
have Du : 0 < D u by rewrite lt_def D0 andbT; apply: contraTneq Pu => e; rewrite -leNgt (le_trans (b u)) // e mulr0.
rewrite -subr_gt0 -[top]mul1r -{1}D1 mulr_suml -sumrB (bigD1 u) //=; apply: ltr_paddr.
  apply: sumr_ge0 => z _; rewrite -mulrBr; case: (ltrP 0 (P z)) => Pz; first by rewrite mulr_ge0 // subr_ge0; apply: up.
  have [P0 _] := lP; have Pz0 : P z = 0 by apply/eqP; rewrite eq_le Pz P0.
  have -> : D z = 0; last by rewrite mul0r.
  by apply/eqP; rewrite eq_le D0 andbT; have := a z; rewrite Pz0 mulr0.
by rewrite -mulrBr mulr_gt0 // subr_gt0.
Qed.

(* ---- The ends of T16, with the threshold that attains them ---- *)

Definition below_ (theta : R) : R := \sum_(u | g u < theta) P u.
Definition up_to (theta : R) : R := \sum_(u | g u <= theta) P u.

Lemma variation_threshold eta gamma theta theta' : below_ theta <= eta <= up_to theta -> up_end eta gamma theta P g <= up_end eta gamma theta' P g.
Proof.
move=> /andP[low high]; have [P0 _] := lP.
suff [k kk] : exists2 k : U -> R, forall u, 0 <= k u <= 1 /\ Num.max 0 (theta - g u) = k u * (theta - g u) & 0 <= (theta' - theta) * (expect P k - eta).
  move=> sum0; rewrite -subr_ge0 (le_trans sum0) // -subr_ge0.
  have -> : up_end eta gamma theta' P g - up_end eta gamma theta P g - (theta' - theta) * (expect P k - eta)
    = expect P (fun u => Num.max 0 (theta' - g u)) - expect P (fun u => k u * (theta' - g u)).
    have -> : expect P (fun u => k u * (theta' - g u)) = expect P (fun u => Num.max 0 (theta - g u)) + (theta' - theta) * expect P k.
      rewrite -expectZ -expectD; apply: eq_expect => // u; have [_ ->] := kk u; ring.
    by rewrite /up_end; ring.
  rewrite -expectB; apply: sumr_ge0 => u _; rewrite mulr_ge0 // subr_ge0; have [/andP[k0 k1] _] := kk u.
  case: (leP 0 (theta' - g u)) => s; first by rewrite ler_pimull.
  by rewrite mulr_ge0_le0 // ltW.
case: (lerP theta theta') => le.
  exists (fun u => (g u <= theta)%R%:R) => [u|].
    case: (leP (g u) theta) => s; rewrite ?mul1r ?mul0r ?ler01 ?lexx; split=> //; first by rewrite (max_idPr _) ?subr_ge0.
    by rewrite (max_idPl _) // subr_le0 ltW.
  rewrite mulr_ge0 ?subr_ge0 // (le_trans high) // le_eqVlt; apply/orP; left; apply/eqP; rewrite /up_to big_mkcond.
  by apply: eq_bigr => u _; case: ifP => _; rewrite ?mulr1 ?mulr0.
exists (fun u => (g u < theta)%R%:R) => [u|].
  case: (ltP (g u) theta) => s; rewrite ?mul1r ?mul0r ?ler01 ?lexx; split=> //; first by rewrite (max_idPr _) ?subr_ge0 // ltW.
  by rewrite (max_idPl _) // subr_le0.
rewrite mulr_le0 ?subr_le0 ?(ltW le) // (le_trans _ low) // le_eqVlt; apply/orP; left; apply/eqP; rewrite /below_ [RHS]big_mkcond.
by apply: eq_bigr => u _; case: ifP => _; rewrite ?mulr1 ?mulr0.
Qed.

Lemma variation_attained eta gamma theta : 0 <= eta <= 1 -> top_is By_variation gamma -> theta <= gamma -> below_ theta <= eta <= up_to theta ->
  (forall D, near By_variation eta D -> expect D g <= up_end eta gamma theta P g)
  /\ exists2 D, near By_variation eta D & expect D g = up_end eta gamma theta P g.
Proof.
move=> e01 [[u _ gu] up] th fits.
have all_le z : g z <= gamma by apply: up.
have bound D : near By_variation eta D -> expect D g <= up_end eta gamma theta P g by move=> [lD nD]; apply: T16_up.
split=> //; have [|theta' [D [th' lD nD e]]] := @T16_attained R U eta P g u lP e01; first by move=> z; rewrite gu.
have nearD : near By_variation eta D by [].
exists D => //; apply: le_anti; rewrite bound //= e gu; exact: variation_threshold.
Qed.

Definition above_ (theta : R) : R := \sum_(u | theta < g u) P u.

Lemma factor_threshold f theta theta' : 1 <= f -> above_ theta * f + (1 - above_ theta) / f <= 1 <= (1 - below_ theta) * f + below_ theta / f ->
  factor_up f theta P g <= factor_up f theta' P g.
Proof.
move=> f1 /andP[low high]; have [P0 P1] := lP; have f0 : 0 < f := lt_le_trans ltr01 f1.
have fi0 : 0 <= f^-1 by rewrite invr_ge0 ltW.
have fi1 : f^-1 <= f by apply: (le_trans _ f1); rewrite invf_le1.
pose h (z : R) := f * Num.max 0 z - Num.max 0 (- z) / f.
have hE th : factor_up f th P g = th + expect P (fun u => h (g u - th)).
  by congr (_ + _); apply: eq_expect => // u; rewrite /h opprB.
have h_up z : 0 <= z -> h z = f * z.
  by move=> z0; rewrite /h (max_idPr z0) (max_idPl _) ?mul0r ?subr0 // oppr_le0.
have h_down z : z <= 0 -> h z = z / f.
  by move=> z0; rewrite /h (max_idPl z0) (max_idPr _) ?oppr_ge0 // mulr0 sub0r mulNr opprK.
have h_above c z : f^-1 <= c <= f -> c * z <= h z.
  move=> /andP[c1 c2]; case: (lerP 0 z) => z0; first by rewrite h_up // ler_wpmul2r.
  by rewrite h_down ?(ltW z0) // mulrC ler_wnmul2l // ltW.
suff [c cc] : exists2 c : U -> R, forall u, f^-1 <= c u <= f /\ h (g u - theta) = c u * (g u - theta) & 0 <= (theta' - theta) * (1 - expect P c).
  move=> sum0; rewrite !hE -subr_ge0 (le_trans sum0) // -subr_ge0.
  have -> : theta' + expect P (fun u => h (g u - theta')) - (theta + expect P (fun u => h (g u - theta))) - (theta' - theta) * (1 - expect P c)
    = expect P (fun u => h (g u - theta')) - expect P (fun u => c u * (g u - theta')).
    have -> : expect P (fun u => c u * (g u - theta')) = expect P (fun u => h (g u - theta)) - (theta' - theta) * expect P c.
      rewrite -expectZ -expectB; apply: eq_expect => // u; have [_ ->] := cc u; ring.
    by ring.
  rewrite -expectB; apply: sumr_ge0 => u _; rewrite mulr_ge0 // subr_ge0; have [bounds _] := cc u; exact: h_above.
have rest (A : pred U) : 1 - \sum_(u | A u) P u = \sum_(u | ~~ A u) P u by rewrite -P1 (bigID A) /= addrAC subrr add0r.
have two (A : pred U) : expect P (fun u => if A u then f else f^-1) = (\sum_(u | A u) P u) * f + (1 - \sum_(u | A u) P u) / f.
  rewrite rest /expect (bigID A) /= !mulr_suml; congr (_ + _); apply: eq_bigr => u; first by move=> ->.
  by move/negbTE->.
have fst u (A : pred U) : f^-1 <= (if A u then f else f^-1) <= f by case: ifP => _; rewrite ?lexx ?fi1.
case: (lerP theta theta') => le.
  exists (fun u => if theta < g u then f else f^-1) => [u|]; last by rewrite mulr_ge0 ?subr_ge0 // two.
  split; first exact: (fst u (fun u => theta < g u)).
  case: (ltP theta (g u)) => s; first by rewrite h_up // subr_ge0 ltW.
  by rewrite h_down ?subr_le0 // mulrC.
exists (fun u => if theta <= g u then f else f^-1) => [u|]; last first.
  rewrite mulr_le0 ?subr_le0 ?(ltW le) // two (le_trans high) // le_eqVlt; apply/orP; left; apply/eqP.
  have -> : \sum_(u | theta <= g u) P u = 1 - below_ theta; last by ring.
  by rewrite rest; apply: eq_bigl => u; rewrite leNgt.
split; first exact: (fst u (fun u => theta <= g u)).
case: (leP theta (g u)) => s; first by rewrite h_up // subr_ge0.
by rewrite h_down ?subr_le0 ?(ltW s) // mulrC.
Qed.

Lemma factor_attained f theta : 1 <= f -> above_ theta * f + (1 - above_ theta) / f <= 1 <= (1 - below_ theta) * f + below_ theta / f ->
  (forall D, near By_factor f D -> expect D g <= factor_up f theta P g)
  /\ exists2 D, near By_factor f D & expect D g = factor_up f theta P g.
Proof.
move=> f1 fits; have bound D : near By_factor f D -> expect D g <= factor_up f theta P g.
  by move=> [lD [a b]]; apply: T16_factor_up.
split=> //; have [theta' [D [lD a b e]]] := T16_factor_attained g lP f1.
have nearD : near By_factor f D by [].
exists D => //; apply: le_anti; rewrite bound //= e; exact: factor_threshold.
Qed.
End Moved.
