(* What Nats.v decides about logarithms is true of the real logarithm.

   The reals, exp and log are those of mathcomp-analysis, which rest on its three classical axioms. *)

From Coq Require Import ZArith QArith List Ascii.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.algebra_tactics Require Import ring.
From mathcomp.analysis Require Import reals sequences exp.
From Fairaudit Require Import Instances.
From FairauditKernel Require Import LinearProgram Fractions FractionsSound.
From FairauditChecker Require Import Nats.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Soundness.
Variable R : realType.
Local Notation ratio := (@ratio R).

(* ---- What is decided (this part has to be read) ---- *)

Definition decimal_value (lo : Z) : R := ratio (Qmake lo units).

(* log v <= limit; v = None is infinity *)
Definition in_nats_at_most (v : option R) (limit : Q) : bool := if v is Some v then ln v <= ratio limit else false.

(* Two texts are the enclosure of log v: 12 decimals, rounded down, and 10^-12 more. *)
Definition encloses_log (low high : list ascii) (v : option R) : Prop :=
  match v with
  | None => low = text_inf /\ high = text_inf
  | Some v =>
      if v == 1 then low = text_zero /\ high = text_zero
      else exists lo, [/\ decimal low = Some lo, decimal high = Some (Z.add lo 1) & decimal_value lo <= ln v < decimal_value (Z.add lo 1)]
  end.

(* ---- Proofs ---- *)

Local Notation two := (2%:R : R).
Local Notation pow e := (two ^ int_of_Z e).

Let two_gt0 : 0 < two. Proof. by rewrite ltr0n. Qed.
Let two_neq0 : two != 0. Proof. by rewrite gt_eqF. Qed.
Let pow_gt0 e : 0 < pow e. Proof. exact: exprz_gt0. Qed.

Lemma powD e f : pow (Z.add e f) = pow e * pow f.
Proof. by rewrite -expfzDr // -[Z.add e f]/(e + f) rmorphD. Qed.

Lemma powN e : pow (Z.opp e) = (pow e)^-1.
Proof. by rewrite -[Z.opp e]/(- e) rmorphN invr_expz. Qed.

Lemma pow_embed e : Z.le Z0 e -> embed (Z.pow 2 e) = pow e.
Proof.
move: e; apply: natlike_ind => [|e e0 IH]; first by rewrite /= embed1.
by rewrite Z.pow_succ_r // embedM IH -Z.add_1_r Z.add_comm powD.
Qed.

Lemma shiftl_embed m e : Z.le Z0 e -> embed (Z.shiftl m e) = embed m * pow e.
Proof. by move=> e0; rewrite Z.shiftl_mul_pow2 // embedM pow_embed. Qed.

Lemma embedB (a b : Z) : embed (Z.sub a b) = embed a - embed b :> R.
Proof. by rewrite -Z.add_opp_r embedD embedN. Qed.

Lemma embed_lt (a b : Z) : Z.ltb a b -> embed a < embed b :> R.
Proof.
move=> /Z.ltb_lt /Z.lt_0_sub /Z.ltb_lt /(embed_gt0 R).
by rewrite -Z.add_opp_r embedD embedN subr_gt0.
Qed.

(* ---- Numbers that are at most e^y ---- *)

Definition number (v : binary) : R := embed (mantissa v) * pow (exponent v).

Definition below_exp (v : binary) (y : R) : Prop := Z.le Z0 (mantissa v) /\ number v <= expR y.

Lemma below_shortened bits v y : below_exp v y -> below_exp (shortened bits v) y.
Proof.
rewrite /shortened; case: v => m s [/= m0 le]; case: ifP => // /Z.ltb_lt c0; split=> /=.
  by apply/Z.shiftr_nonneg.
apply: le_trans le; rewrite /number /= Z.add_comm powD mulrA ler_wpmul2r ?(ltW (pow_gt0 _)) //.
have c0' := Z.lt_le_incl _ _ c0; rewrite -pow_embed // -embedM Z.shiftr_div_pow2 // Z.mul_comm.
by apply/embed_le/Z.leb_le/Z.mul_div_le/Z.pow_pos_nonneg.
Qed.

Lemma below_squared v y : below_exp v y -> below_exp (squared v) (y + y).
Proof.
case: v => m s [/= m0 le]; split=> /=; first exact: Z.mul_nonneg_nonneg.
have n0 : 0 <= number (Binary m s) by rewrite mulr_ge0 ?(ltW (pow_gt0 _)) // embed_ge0 //; apply/Z.leb_le.
suff -> : number (squared (Binary m s)) = number (Binary m s) * number (Binary m s) by rewrite expRD ler_pmul.
rewrite /number -[exponent (squared _)]/(Z.mul 2 s) -Z.add_diag powD embedM /=; by ring.
Qed.

Lemma below_squared_often bits k v y : below_exp v y -> below_exp (squared_often bits k v) (y * two ^+ k).
Proof.
elim: k v y => [|k IH] v y low; first by rewrite expr0 mulr1.
rewrite exprS mulrA mulr_natr mulr2n; apply: IH; exact/below_shortened/below_squared.
Qed.

Lemma below_tangent bits k x : Z.le Z0 bits -> Z.le Z0 k -> below_exp (tangent bits k x) (ratio x / pow k).
Proof.
move=> b0 k0; rewrite /tangent; set d := Z.shiftl _ k; set a := Z.add d _.
have d0 : Z.lt Z0 d by rewrite /d Z.shiftl_mul_pow2 //; apply: Z.mul_pos_pos => //; apply: Z.pow_pos_nonneg.
have D0 : 0 < embed d :> R by apply/embed_gt0/Z.ltb_lt.
split; first exact: Z.le_max_l.
rewrite /number [mantissa _]/= [exponent _]/=.
case: (Z.max_spec Z0 (Z.div (Z.shiftl a bits) d)) => [[_ ->]|[_ ->]]; last by rewrite embed0 mul0r ltW // expR_gt0.
apply: le_trans (Instances.tangent _); rewrite powN ler_pdivr_mulr //.
have -> : 1 + ratio x / pow k = embed a / embed d.
  rewrite /a embedD /d shiftl_embed // mulrDl divff -?shiftl_embed // ?gt_eqF //.
  by rewrite shiftl_embed // /ratio invfM mulrA.
rewrite mulrAC ler_pdivl_mulr // -shiftl_embed // -embedM; apply/embed_le/Z.leb_le.
by rewrite Z.mul_comm; apply: Z.mul_div_le.
Qed.

Lemma below_exp_low k x : Z.le Z0 k -> below_exp (exp_low k x) (ratio x).
Proof.
move=> k0; rewrite /exp_low -[ratio x](@divfK _ (two ^+ Z.to_nat k)) ?expf_neq0 //.
apply: below_squared_often; have -> : two ^+ Z.to_nat k = pow k.
  by case: k k0 => [|k|k] //= _; rewrite -exprnP.
by apply: below_tangent => //; apply: Z.add_nonneg_nonneg => //; apply: Z.mul_nonneg_nonneg.
Qed.

Lemma lessP n d v : Z.lt Z0 d -> less n d v -> embed n / embed d < number v.
Proof.
move=> d0; have D0 : 0 < embed d :> R by apply/embed_gt0/Z.ltb_lt.
rewrite /less /number ltr_pdivr_mulr // mulrAC -embedM; case: (Z.leb_spec Z0 (exponent v)) => e0 /embed_lt.
  by rewrite shiftl_embed.
by rewrite shiftl_embed ?powN ?ltr_pdivr_mulr //; apply/Z.opp_nonneg_nonpos/Z.lt_le_incl.
Qed.

Lemma number_less n d k x : Z.lt Z0 d -> Z.le Z0 k -> less n d (exp_low k x) -> embed n / embed d < expR (ratio x).
Proof. by move=> d0 k0 /(lessP d0) lt; apply: lt_le_trans lt (below_exp_low x k0).2. Qed.

Lemma two_le_e n : two ^+ n <= expR n%:R.
Proof.
rewrite -[n%:R]mulr1 expRMm ler_expn2r ?nnegrE ?ler0n ?(ltW (expR_gt0 _)) //.
by rewrite (le_trans _ (Instances.tangent 1)) // -natrD.
Qed.

Lemma strict_tangent y : - two < y -> y != 0 -> 1 + y < expR y.
Proof.
move=> y2 y0; have half : y / two + y / two = y by field.
have pos : 0 <= 1 + y / two by rewrite -(pmulr_lge0 _ two_gt0) mulrDl divfK // mul1r -ler_subl_addl sub0r ltW.
rewrite -[y in expR y]half expRD.
apply: (@lt_le_trans _ _ ((1 + y / two) * (1 + y / two))); last by rewrite ler_pmul // Instances.tangent.
have -> : (1 + y / two) * (1 + y / two) = 1 + (y / two + y / two) + (y / two) ^+ 2 by ring.
by rewrite half ltr_addl exprn_even_gt0 // mulf_neq0 // invr_eq0.
Qed.

(* ---- On which side of x the logarithm lies ---- *)

Definition on_side (c : comparison) (a b : R) : Prop := match c with Lt => a < b | Eq => a = b | Gt => b < a end.

Section Side.
Variables (r x : Q) (r1 : Z.leb (Zpos (Qden r)) (Qnum r)).

Let n0 : Z.lt Z0 (Qnum r). Proof. by apply: Z.lt_le_trans (Pos2Z.is_pos _) _; apply/Z.leb_le; apply: r1. Qed.
Let N0 : 0 < embed (Qnum r) :> R. Proof. exact/embed_gt0/Z.ltb_lt. Qed.
Let D0 : 0 < embed (Zpos (Qden r)) :> R. Proof. exact: embed_pos. Qed.

Lemma ratio_r_gt0 : 0 < ratio r. Proof. exact: divr_gt0. Qed.

Lemma ln_lt y : ratio r < expR y -> ln (ratio r) < y.
Proof. by rewrite -{2}(expK y) ltr_ln ?posrE ?expR_gt0 // ratio_r_gt0. Qed.

Lemma lt_ln y : expR y < ratio r -> y < ln (ratio r).
Proof. by rewrite -{2}(expK y) ltr_ln ?posrE ?expR_gt0 // ratio_r_gt0. Qed.

Lemma side_atP ks c : all (Z.leb Z0) ks -> side_at ks r x = Some c -> on_side c (ln (ratio r)) (ratio x).
Proof.
elim: ks => //= k ks IH /andP[/Z.leb_le k0 ks0]; case: ifP => [lt [<-]|_]; first exact/ln_lt/(number_less _ k0 lt).
case: ifP => [lt [<-]|_]; last exact: IH.
apply: lt_ln; have := number_less n0 k0 lt; rewrite ratio_minus expRN -[in X in X -> _]invf_div.
by rewrite ltf_pinv // posrE ?expR_gt0 // ratio_r_gt0.
Qed.
End Side.

Lemma side_sound r x c : side r x = Some c -> on_side c (ln (ratio r)) (ratio x).
Proof.
rewrite /side; case: (Z.ltb_spec (Qnum r)) => // r1; case: (Z.ltb_spec (Qnum x)) => // x0.
have {}r1 : Z.leb (Zpos (Qden r)) (Qnum r) by apply/Z.leb_le.
have d0 : 0 < embed (Zpos (Qden r)) :> R := embed_pos _ _.
have q0 : 0 < embed (Zpos (Qden x)) :> R := embed_pos _ _.
have n0 : Z.lt Z0 (Qnum r) by apply: Z.lt_le_trans (Pos2Z.is_pos _) _; apply/Z.leb_le; apply: r1.
case: Z.eqb_spec => [e [<-]|ne].
  have -> : ratio r = 1 by rewrite /ratio e divff ?gt_eqF.
  rewrite ln1 /ratio; case xE: (Qnum x) x0 => [|p|p] x0; last by case: x0.
    by rewrite embed0 mul0r.
  by apply: divr_gt0 => //; apply: embed_pos.
case: ifP => [big [<-]|_].
  apply: ln_lt => //; set l := Z.log2 (Qnum r); have l0 : Z.le Z0 l := Z.log2_nonneg _.
  have l1 : Z.le Z0 (Z.add l 1) by apply: Z.le_trans l0 _; apply: Z.le_succ_diag_r.
  have lt : embed (Qnum r) < pow (Z.add l 1).
    rewrite -pow_embed //; apply/embed_lt/Z.ltb_lt; by case: (Z.log2_spec _ n0).
  have ge1 : 1 <= embed (Zpos (Qden r)) :> R by rewrite -[1]embed1; apply/embed_le/Z.leb_le; case: (Qden r).
  apply: (@le_lt_trans _ _ (embed (Qnum r))).
    by rewrite ler_pdivr_mulr // ler_pemulr //; apply/embed_ge0/Z.leb_le/Z.lt_le_incl.
  apply: lt_le_trans lt _; apply: (@le_trans _ _ (expR (embed (Z.add l 1)))).
    case: (Z.add l 1) l1 => [|p|//] _ /=; first by rewrite embed0 expR0.
    by rewrite -exprnP; apply: two_le_e.
  by rewrite ler_expR ler_pdivl_mulr // -embedM; apply: embed_le.
have d0' : embed (Zpos (Qden r)) != 0 :> R by rewrite gt_eqF.
have N0 : 0 < embed (Qnum r) :> R by apply/embed_gt0/Z.ltb_lt.
have less1 : embed (Zpos (Qden r)) < embed (Qnum r) :> R.
  by apply/embed_lt/Z.ltb_lt; case/Z.leb_le/Z.le_lteq: r1 => // e'; case: ne.
have q0' : embed (Zpos (Qden x)) != 0 :> R by rewrite gt_eqF.
have n0' : embed (Qnum r) != 0 :> R by rewrite gt_eqF.
case: ifP => [/(embed_le R) close [<-]|_].
  apply: ln_lt => //; apply: (@lt_le_trans _ _ (expR (ratio r - 1))).
    have r1' : 0 < ratio r - 1 by rewrite subr_gt0 /ratio ltr_pdivl_mulr // mul1r.
    have := @strict_tangent (ratio r - 1); rewrite addrCA subrr addr0; apply; last by rewrite gt_eqF.
    by apply: lt_trans r1'; rewrite oppr_lt0.
  rewrite ler_expR /ratio; have -> : embed (Qnum r) / embed (Zpos (Qden r)) - 1 = (embed (Qnum r) - embed (Zpos (Qden r))) / embed (Zpos (Qden r)) :> R by field.
  by rewrite ler_pdivr_mulr // mulrAC ler_pdivl_mulr // -embedB -!embedM.
case: ifP => [/(embed_le R) close [<-]|_]; last by apply: side_atP.
have inv : (ratio r)^-1 = embed (Zpos (Qden r)) / embed (Qnum r) by rewrite /ratio invf_div.
apply: lt_ln => //; apply: (@le_lt_trans _ _ (expR (1 - (ratio r)^-1))).
  rewrite ler_expR inv /ratio; have -> : 1 - embed (Zpos (Qden r)) / embed (Qnum r) = (embed (Qnum r) - embed (Zpos (Qden r))) / embed (Qnum r) :> R by field.
  by rewrite ler_pdivr_mulr // mulrAC ler_pdivl_mulr // -embedB -!embedM.
have small : (ratio r)^-1 < 1 by rewrite inv ltr_pdivr_mulr // mul1r.
have small' : (ratio r)^-1 - 1 < 0 by rewrite subr_lt0.
rewrite -opprB expRN -[ratio r]invrK ltf_pinv ?posrE ?expR_gt0 ?invr_gt0 ?invrK ?ratio_r_gt0 //.
have := @strict_tangent ((ratio r)^-1 - 1); rewrite addrCA subrr addr0; apply; last by rewrite lt_eqF.
apply: (@lt_trans _ _ (- 1)); first by rewrite ltr_opp2 ltr1n.
by rewrite ltr_addr invr_gt0 ratio_r_gt0.
Qed.

(* ---- What is proved of the decisions that are used ---- *)

Theorem log_at_most_sound r limit b : log_at_most r limit = Some b -> b = in_nats_at_most (omap ratio r) limit.
Proof.
case: r => [r|] /=; last by case=> <-.
case e: (side r limit) => [c|] // [<-]; have := side_sound e.
by case: c {e} => [->|/ltW ->|] //=; rewrite ?lexx // => lt; rewrite leNgt lt.
Qed.

Lemma side_lt r x c : side r x = Some c -> (ln (ratio r) < ratio x) = match c with Lt => true | _ => false end.
Proof. by move/side_sound; case: c => [->|//|/ltW]; rewrite ?ltxx // ltNge => ->. Qed.

Lemma log_floor_sound r lo b : log_floor_is r lo = Some b ->
  b = (decimal_value lo <= ln (ratio r) < decimal_value (Z.add lo 1)).
Proof.
rewrite /log_floor_is /decimal_value leNgt; set low := Qmake lo _; set high := Qmake (Z.add lo 1) _.
case e1: (side r low) => [c1|]; case e2: (side r high) => [c2|].
- by rewrite (side_lt e1) (side_lt e2); case: c1 {e1}; case: c2 {e2} => // -[<-].
- by rewrite (side_lt e1); case: c1 {e1} => // -[<-].
- by rewrite (side_lt e2) andbC; case: c2 {e2} => // -[<-].
- by [].
Qed.

Lemma is_textP a b : is_text a b -> a = b.
Proof. by rewrite /is_text; case: list_eq_dec. Qed.

Theorem enclosure_sound r low high : enclosure_is r low high = Some true -> encloses_log low high (omap ratio r).
Proof.
case: r => [r|] /=; last by case=> /andP[/is_textP -> /is_textP ->].
have -> : (ratio r == 1) = Z.eqb (Qnum r) (Zpos (Qden r)).
  have d0 : embed (Zpos (Qden r)) != 0 :> R by rewrite gt_eqF // embed_pos.
  rewrite /FractionsSound.ratio -(inj_eq (mulIf d0)) divfK // mul1r.
  by rewrite /embed eqr_int; apply/eqP/Z.eqb_spec => [/(can_inj int_of_ZK)|->].
case: ifP => _; first by case=> /andP[/is_textP -> /is_textP ->].
case el: (decimal low) => [lo|] //; case eh: (decimal high) => [hi|] //.
case: Z.eqb_spec => // -> /log_floor_sound/esym between; by exists lo.
Qed.

(* ---- The same of lists, as files that are made of certificates state them ---- *)

Definition enclosed (e : option Q * list ascii * list ascii) : bool := if enclosure_is e.1.1 e.1.2 e.2 is Some true then true else false.

Theorem enclosures_sound es : forallb enclosed es -> forall e, List.In e es -> encloses_log e.1.2 e.2 (omap ratio e.1.1).
Proof.
move=> /forallb_forall checked e /checked; rewrite /enclosed.
by case c: (enclosure_is _ _ _) => [[|]|] // _; apply: enclosure_sound.
Qed.

(* a ratio, a limit in nats, and whether the ratio keeps it *)
Definition judged_in_nats (t : option Q * Q * bool) : bool := if log_at_most t.1.1 t.1.2 is Some b then Bool.eqb b t.2 else false.

Theorem limits_in_nats_sound ts : forallb judged_in_nats ts -> forall t, List.In t ts -> in_nats_at_most (omap ratio t.1.1) t.1.2 = t.2.
Proof.
move=> /forallb_forall checked t /checked; rewrite /judged_in_nats.
by case c: (log_at_most _ _) => [b|] // /Bool.eqb_prop <-; rewrite (log_at_most_sound c).
Qed.
End Soundness.
