(* A hidden factor that is weaker than a frontier says does not bring a ratio down, by T14. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From mathcomp.zify Require Import ssrZ.
From Fairaudit Require T14.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Hidden.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- The balanced strength, in integers ---- *)

Lemma rounded_rootP p q n : Z.lt 0 q -> is_rounded_root p q n ->
  Z.le (Z.mul q n) (Z.mul p million) \/
  Z.le (Z.mul q (Z.add (Z.mul n n) (Z.mul million million))) (Z.mul (Z.mul 2 n) (Z.mul p million)).
Proof.
move=> q0; rewrite /is_rounded_root => /and3P[/orP[/Z.leb_le le|/Z.leb_le le] _ _]; first by left; lia.
right; apply: (Zmult_le_reg_r _ _ q); first lia.
by move: le; move: million => u; lia.
Qed.

Section Hidden.
Variable R : realFieldType.
Local Notation ratio := (@ratio R).
Local Notation embed := (@embed R).
Implicit Types (b e k m : R).

(* ---- What is weaker, in numbers ---- *)

Lemma weaker_than_ratio b e k m : 1 <= k -> 1 <= m -> k < b -> m < b -> b <= e -> 1 + m * k < e * (m + k).
Proof.
move=> k1 m1 kb mb be; have ke : k < e := lt_le_trans kb be.
have m0 : 0 < m := lt_le_trans ltr01 m1; have e1 : 1 <= e := le_trans k1 (ltW ke).
rewrite -subr_gt0; have -> : e * (m + k) - (1 + m * k) = m * (e - k) + (e * k - 1) by ring.
have p1 : 0 < m * (e - k) by rewrite mulr_gt0 ?subr_gt0.
have p2 : 0 <= e * k - 1 by rewrite subr_ge0 mulr_ege1.
exact: ltr_paddr p2 p1.
Qed.

Lemma weaker_than_root b e k m : 1 <= k -> 1 <= m -> k < b -> m < b -> b * b + 1 <= 2%:R * b * e -> 1 + m * k < e * (m + k).
Proof.
move=> k1 m1 kb mb be; have b1 : 1 < b := le_lt_trans k1 kb.
have b0 : 0 < b := lt_trans ltr01 b1.
have mk0 : 0 < m + k by rewrite addr_gt0 // (lt_le_trans ltr01).
have above x : 1 <= x -> 0 < b * x - 1.
  by move=> x1; rewrite subr_gt0 (lt_le_trans b1) // ler_pemulr // ltW.
rewrite -(ltr_pmul2l (_ : 0 < 2%:R * b)) ?mulr_gt0 ?ltr0n //.
apply: (@lt_le_trans _ _ ((b * b + 1) * (m + k))); last by rewrite [leRHS]mulrA; apply: ler_wpmul2r be; apply: ltW.
rewrite -subr_gt0.
have -> : (b * b + 1) * (m + k) - 2%:R * b * (1 + m * k) = (b - k) * (b * m - 1) + (b - m) * (b * k - 1) by ring.
by rewrite addr_gt0 // mulr_gt0 ?above // subr_gt0.
Qed.

Lemma weaker_than_pair e k0 m0 k m : 1 <= k -> 1 <= m -> 1 < e -> e < k0 -> m0 * (k0 - e) = e * k0 - 1 -> k < k0 -> m < m0 ->
  1 + m * k < e * (m + k).
Proof.
move=> k1 m1 e1 ek0 def kk mm; rewrite -subr_gt0.
have m0' : 0 < m := lt_le_trans ltr01 m1.
have [me|me] := leP m e.
  have p1 : 0 < (e - 1) * (m + 1) by rewrite mulr_gt0 ?subr_gt0 // addr_gt0 // ltr01.
  have p2 : 0 <= (k - 1) * (e - m) by rewrite mulr_ge0 ?subr_ge0.
  have -> : e * (m + k) - (1 + m * k) = (k - 1) * (e - m) + (e - 1) * (m + 1) by ring.
  exact: ltr_paddl p2 p1.
have d0 : 0 < k0 - e by rewrite subr_gt0.
have small : 0 < e * k0 - 1 - m * (k0 - e) by rewrite subr_gt0 -def ltr_pmul2r.
have p3 : 0 < (k0 - k) * (m - e) by rewrite mulr_gt0 ?subr_gt0.
have -> : e * (m + k) - (1 + m * k) = (k0 - k) * (m - e) + (e * k0 - 1 - m * (k0 - e)) by ring.
exact: addr_gt0.
Qed.

(* ---- What the program accepts ---- *)

Lemma equalsE q r : equals q r -> ratio q = ratio r.
Proof. by case/andP => /(@at_mostP R) le /(@at_mostP R) ge; apply: le_anti; rewrite le ge. Qed.

Lemma ratio_divided q r : positive_fraction r -> ratio (divided q r) = ratio q / ratio r.
Proof. by move=> r0; rewrite /divided ratio_times ratio_inverse. Qed.

Lemma square_cleared (a u c : R) : u != 0 -> (a / u * (a / u) + 1) * (u * u * c) = c * (a * a + u * u).
Proof.
move=> u0; have -> : (a / u * (a / u) + 1) * (u * u * c) = c * (a * a * (u^-1 * u) * (u^-1 * u) + u * u) by ring.
by rewrite mulVf // !mulr1.
Qed.

Lemma product_cleared (a b u c : R) : u != 0 -> c != 0 -> 2%:R * (a / u) * (b / c) * (u * u * c) = 2%:R * a * (b * u).
Proof.
move=> u0 c0; have -> : 2%:R * (a / u) * (b / c) * (u * u * c) = 2%:R * a * (b * u) * (u^-1 * u) * (c^-1 * c) by ring.
by rewrite !mulVf // !mulr1.
Qed.

Lemma balancedP (e b : Q) : is_balanced e b -> let x := ratio b in x <= ratio e \/ x * x + 1 <= 2%:R * x * ratio e.
Proof.
rewrite /is_balanced; set n := Z.div _ _ => /andP[/Z.eqb_eq whole root].
have -> : ratio b = ratio (Qmake n 1000000) by apply: ratio_eq; rewrite /= -whole.
move: root; set p := Qnum e; set q := Zpos (Qden e) => root.
have q0 : (0 : R) < embed q by apply: embed_pos.
have u0 : (0 : R) < embed 1000000 by apply: embed_pos.
rewrite /FractionsSound.ratio /= -/p -/q; set u := embed 1000000 in u0 *.
have [le|le] := rounded_rootP (erefl : Z.lt 0 q) root; rewrite /million in le.
  left; rewrite ler_pdivr_mulr // mulrAC ler_pdivl_mulr // mulrC -!embedM.
  by apply: embed_le; apply/Z.leb_le; lia.
right.
have leR := @embed_le R _ _ (introT (Z.leb_spec0 _ _) le); rewrite !(embedM, embedD) -/u in leR.
have two : embed 2 = 2%:R by [].
rewrite two in leR.
have un : u != 0 by rewrite gt_eqF. have qn : embed q != 0 by rewrite gt_eqF.
rewrite -(ler_pmul2r (_ : 0 < u * u * embed q)) ?mulr_gt0 //.
by rewrite square_cleared // product_cleared.
Qed.

(* ---- What a weaker factor leaves ---- *)

Section Explained.
Variables (V : finType) (k m : R) (p q e e' : V -> R) (high low : R).
Hypotheses (k1 : 1 <= k) (m1 : 1 <= m) (given : explained_by k m p q e e' high low).

Let law_p : Definitions.law p. Proof. by case: given => -[p0 p1] *; split=> // v; apply: ltW. Qed.
Let law_q : Definitions.law q. Proof. by case: given => _ [q0 q1] *; split=> // v; apply: ltW. Qed.

(* where the ratio is finite *)
Lemma finite_left (to r : R) : 0 <= to -> 0 < low -> high = r * low -> to * (1 + m * k) < r * (m + k) ->
  exists v, ~~ no_more (quotient (e v) (e' v)) (Some to).
Proof.
case: given => _ _ [pq qp] [e0 e0' s] [eh el] to0 low0 hr weak.
have big : to * (1 + m * k) * Definitions.expect q e' < (m + k) * Definitions.expect p e.
  by rewrite /Definitions.expect eh el hr [ltRHS]mulrA [_ * r]mulrC ltr_pmul2r.
have [v] := T14.T14_exceeds law_p law_q k1 m1 to0 pq qp e0 e0' s big.
move=> ve; exists v; rewrite /quotient; case: eqP => [z|/eqP nz].
  by rewrite z mulr0 in ve; rewrite gt_eqF.
by rewrite /= -ltNge ltr_pdivl_mulr // lt_def nz e0'.
Qed.

(* where it is infinite *)
Lemma infinite_left (to : R) : high != 0 -> low = 0 -> exists v, ~~ no_more (quotient (e v) (e' v)) (Some to).
Proof.
case: given => -[p0 _] [q0 _] _ [e0 e0' _] [eh el] h0 l0.
have zero v : e' v = 0.
  have := psumr_eq0P (P := xpredT) (fun v _ => mulr_ge0 (ltW (q0 v)) (e0' v)); rewrite el l0 => /(_ erefl v isT)/eqP.
  by rewrite mulf_eq0 gt_eqF // => /eqP.
have [v ev|none] := pickP (fun v => e v != 0); first by exists v; rewrite /quotient zero eqxx (negbTE ev).
move: h0; rewrite -eh big1 ?eqxx // => v _.
by have /negbFE/eqP -> := none v; rewrite mulr0.
Qed.
End Explained.


(* ---- Levels, and the frontier ---- *)

Lemma has_some A (a : pred A) s : has a s -> exists2 x, List.In x s & a x.
Proof. by elim: s => //= x s IH /orP[ax|/IH[y yin ay]]; [exists x; [left | ] | exists y; [right | ]]. Qed.

Lemma pairs_fit_in (x before : Q) ps s : pairs_fit x before ps -> List.In s ps -> ratio x <= ratio before ->
  ratio x < ratio s.1 /\ equals s.2 (strength_beside x s.1).
Proof.
elim: ps before => [//|[k m] rest IH] before /= /and3P[up fit rest_fit] [<-|inn] below; rewrite (at_mostE R) -ltNge in up.
  by split=> //; apply: le_lt_trans up.
by apply: IH rest_fit inn _; apply: le_trans below (ltW up).
Qed.

(* Where the ratio is at least what was seen, or infinite *)
Lemma weaker_leaves (seen : option Q) l (high low : R) (V : finType) k m (P Q e e' : V -> R) :
  1 <= ratio (down_to l) :> R -> level_fits seen l -> 1 <= k -> 1 <= m -> too_weak l k m -> explained_by k m P Q e e' high low ->
  (if seen is Some r then ratio r * low <= high /\ 0 < high else low = 0 /\ high != 0) ->
  exists v, ~~ no_more (quotient (e v) (e' v)) (Some (ratio (down_to l))).
Proof.
move=> to1; rewrite /level_fits => lf k1 m1 weak given.
case: seen lf => [r|]; case eb: (balanced l) => [b|] //; last by move=> _ [l0 h0]; apply: (infinite_left given).
case/and4P => pos above fit pairs [le h0].
have to0 : 0 < ratio (down_to l) :> R by rewrite -positive_fractionE.
rewrite (at_mostE R) -ltNge in above.
have low_ge : 0 <= low.
  case: given => _ [q0 _] _ [_ e0' _] [_ <-]; apply: sumr_ge0 => v _; apply: mulr_ge0; last exact: e0'.
  exact: ltW.
have [l0|lown] := eqVneq low 0; first by apply: (infinite_left given) => //; rewrite gt_eqF.
have lowp : 0 < low by rewrite lt_def lown.
apply: (finite_left (r := high / low) k1 m1 given (ltW to0) lowp); first by rewrite divfK.
have mk0 : 0 < m + k by rewrite addr_gt0 // (lt_le_trans ltr01).
apply: (@lt_le_trans _ _ (ratio r * (m + k))); last by apply: ler_wpmul2r; rewrite ?(ltW mk0) // ler_pdivl_mulr.
set E : R := ratio r / ratio (down_to l).
have E_is : ratio (divided r (down_to l)) = E by apply: ratio_divided.
have E1 : 1 < E by rewrite ltr_pdivl_mulr // mul1r.
rewrite mulrC -ltr_pdivl_mulr // mulrAC -/E.
case/orP: weak => [|/has_some[s sin /andP[ks ms]]].
  rewrite eb => /andP[kb mb].
  have [small|small] := balancedP fit; rewrite E_is in small.
    exact: weaker_than_ratio kb mb small.
  exact: weaker_than_root kb mb small.
have [up /equalsE m_is] := pairs_fit_in pairs sin (lexx _).
rewrite E_is in up.
apply: (weaker_than_pair k1 m1 E1 up _ ks ms).
have d0 : 0 < ratio s.1 - E by rewrite subr_gt0.
have pos_d : positive_fraction (plus s.1 (Fractions.minus (divided r (down_to l)))).
  by rewrite (positive_fractionE R) ratio_plus ratio_minus E_is.
rewrite m_is /strength_beside ratio_divided // !ratio_plus !ratio_minus ratio_times ratio_one E_is.
by rewrite mulfVK // gt_eqF.
Qed.

Lemma rising_above ls l : rising ls -> 1 <= ratio (down_to (List.hd l ls)) :> R -> List.In l ls -> 1 <= ratio (down_to l) :> R.
Proof.
elim: ls => [//|l0 [|l1 rest] IH] /= ris low [<-//|inn]; first by case: inn.
case/andP: ris; rewrite (at_mostE R) -ltNge => up ris.
by apply: IH => //=; apply: le_trans low (ltW up).
Qed.

Lemma frontier_levels seen v ls : frontier_fits seen v ls ->
  (if ls is l :: _ then ratio (down_to l) = 1 :> R /\ extended R v = extended R (balanced l) else False) /\
  forall l, List.In l ls -> 1 <= ratio (down_to l) :> R /\ level_fits seen l.
Proof.
case: ls => [//|l0 rest] /and4P[/equalsE one_ same ris all_fit].
rewrite ratio_one in one_; split=> [|l inn].
  by split=> //; case: v (balanced l0) same => [v|] [b|] //= /equalsE; rewrite /extended /= => ->.
split; last exact: (proj1 (forallb_forall _ _) all_fit).
by apply: (rising_above ris _ inn); rewrite /= one_.
Qed.

(* Of the table *)
Theorem frontier_sound T q f v ls : is_ratio q -> figure_holds R T q (Some f) -> frontier_fits (value f) v ls -> hidden_needs R T q v ls.
Proof.
move=> is_r [_ [[comp _] /esym val _]] /frontier_levels[first levels]; split=> // l /levels[to1 fits].
rewrite /quantity_at is_r in val.
exists (witness f) => // V k m P Q e e' k1 m1 weak given; apply: (weaker_leaves to1 fits k1 m1 weak given).
set high := amount R T q _ _ in val given *; set low := amount R T q _ (lower _) in val given *.
case ev: (value f) val fits => [r|]; rewrite /quotient.
  case: eqP => [_|/eqP lown]; first case: eqP => // _ [r_is].
    by rewrite /level_fits; case: (balanced l) => // b /and4P[_]; rewrite (at_mostE R) -ltNge r_is => /(le_lt_trans to1); rewrite ltxx.
  case=> r_is /=; rewrite /level_fits; case: (balanced l) => // b /and4P[_]; rewrite (at_mostE R) -ltNge => /(le_lt_trans to1) r1 _ _.
  have lowp : 0 < low.
    rewrite lt_def lown; case: given => _ [q0 _] _ [_ e0' _] [_ <-]; apply: sumr_ge0 => w _; apply: mulr_ge0; last exact: e0'.
    exact: ltW.
  have -> : high = ratio r * low by rewrite r_is divfK.
  by split=> //; rewrite mulr_gt0 // (lt_trans ltr01).
by case: eqP => [->|//]; case: eqP => // /eqP.
Qed.

End Hidden.
