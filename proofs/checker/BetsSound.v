(* What Bets.v computes is never more than the bets have won: each number is one of at most the true one. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.algebra_tactics Require Import ring.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Bets.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Sound.
Variable R : realFieldType.
Local Notation ratio := (@ratio R).
Local Notation embed := (@embed R).
Local Notation two := (2%:R : R).
Local Notation pow e := (two ^ int_of_Z e).

(* ---- Powers of two ---- *)

Let two_gt0 : 0 < two. Proof. by rewrite ltr0n. Qed.
Let two_neq0 : two != 0. Proof. by rewrite gt_eqF. Qed.
Let pow_gt0 e : 0 < pow e. Proof. exact: exprz_gt0. Qed.

Lemma powD e f : pow (Z.add e f) = pow e * pow f.
Proof. by rewrite -expfzDr // -[Z.add e f]/(e + f) rmorphD. Qed.

Lemma powN e : pow (Z.opp e) = (pow e)^-1.
Proof. by rewrite -[Z.opp e]/(- e) rmorphN invr_expz. Qed.

Lemma powK e : pow e * pow (Z.opp e) = 1.
Proof. by rewrite powN divff // gt_eqF. Qed.

Lemma pow_embed e : Z.le Z0 e -> embed (Z.pow 2 e) = pow e.
Proof.
move: e; apply: natlike_ind => [|e e0 IH]; first by rewrite /= embed1.
by rewrite Z.pow_succ_r // embedM IH -Z.add_1_r Z.add_comm powD.
Qed.

Lemma shiftl_embed m e : Z.le Z0 e -> embed (Z.shiftl m e) = embed m * pow e.
Proof. by move=> e0; rewrite Z.shiftl_mul_pow2 // embedM pow_embed. Qed.

Lemma div_embed m d : Z.lt Z0 d -> embed (Z.div m d) <= embed m / embed d.
Proof.
move=> d0; rewrite ler_pdivl_mulr; last by apply: embed_gt0; apply/Z.ltb_lt.
by rewrite -embedM Z.mul_comm; apply/embed_le/Z.leb_le/Z.mul_div_le.
Qed.

Lemma shift_le m e : embed (Z.shiftl m e) <= embed m * pow e.
Proof.
case: (Z.le_ge_cases 0 e) => [/shiftl_embed -> //|e0]; rewrite Z.shiftl_div_pow2 //.
have e1 : Z.le 0 (Z.opp e) by lia.
apply: le_trans (div_embed _ _) _; first exact: Z.pow_pos_nonneg.
by rewrite pow_embed // powN invrK.
Qed.

Lemma embed0_ge m : Z.le Z0 m -> 0 <= embed m.
Proof. by move/Z.leb_le; apply: embed_ge0. Qed.

(* ---- Numbers that are at most x ---- *)

Definition value (w : wealth) : R := embed w.1 * pow w.2.
Definition below (w : wealth) (x : R) : Prop := Z.le Z0 w.1 /\ value w <= x.

Lemma value_ge0 w x : below w x -> 0 <= value w.
Proof. by case=> /embed0_ge m0 _; rewrite mulr_ge0 // ltW. Qed.

Lemma below_le w x y : below w x -> x <= y -> below w y.
Proof. by case=> m0 le /(le_trans le). Qed.

Lemma below_one : below (Zpos xH, Z0) 1.
Proof. by split=> //; rewrite /value /= embed1 mul1r expr0z. Qed.

Lemma below_nothing e x : 0 <= x -> below (Z0, e) x.
Proof. by split=> //; rewrite /value /= embed0 mul0r. Qed.

Lemma below_trimmed w x : below w x -> below (trimmed w) x.
Proof.
rewrite /trimmed; case: w => m e [/= m0 le]; case: ifP => // _; move: (Z.sub _ _) => c; split; first exact/Z.shiftr_nonneg.
apply: le_trans le; rewrite /value -[Z.shiftr m c](Z.shiftl_opp_r m c) [(_, _).2]/= [(_, _).1]/= powD [pow e * _]mulrC mulrA.
by rewrite ler_wpmul2r ?(ltW (pow_gt0 _)) // -ler_pdivl_mulr // -powN shift_le.
Qed.

Lemma below_quotient a b : Z.le Z0 a -> Z.lt Z0 b -> below (quotient a b) (embed a / embed b).
Proof.
move=> a0 b0; rewrite /quotient; have : Z.le 0 (Z.max 0 (Z.sub (Z.add kept (bits b)) (bits a))) by exact: Z.le_max_l.
move: (Z.max _ _) => s s0; apply: below_trimmed; split; first by apply: Z.div_pos => //; apply/Z.shiftl_nonneg.
rewrite /value [(_, _).1]/= [(_, _).2]/= powN ler_pdivr_mulr //.
by apply: le_trans (div_embed _ b0) _; rewrite shiftl_embed // mulrAC.
Qed.

Lemma below_product v w x y : below v x -> below w y -> below (product v w) (x * y).
Proof.
move=> bv bw; apply: below_trimmed; split; first by case: bv => v0 _; case: bw => w0 _; apply: Z.mul_nonneg_nonneg.
have -> : value (Z.mul v.1 w.1, Z.add v.2 w.2) = value v * value w by rewrite /value /= embedM powD mulrACA.
by apply: ler_pmul; [exact: value_ge0 bv|exact: value_ge0 bw|case: bv|case: bw].
Qed.

Lemma below_raised w x n : below w x -> below (raised w n) (x ^+ Pos.to_nat n).
Proof.
move=> b; elim: n => [n IH|n IH|] /=; last by rewrite expr1 -[x]mul1r; apply: below_product below_one b.
  rewrite Pos2Nat.inj_xI; have -> : (S (2 * Pos.to_nat n) = (Pos.to_nat n + Pos.to_nat n).+1)%coq_nat%N by lia.
  by rewrite exprSr exprD; apply: below_product b; apply: below_product.
rewrite Pos2Nat.inj_xO; have -> : (2 * Pos.to_nat n = (Pos.to_nat n + Pos.to_nat n))%coq_nat%N by lia.
by rewrite exprD; apply: below_product.
Qed.

Lemma below_to_the w x n : below w x -> below (to_the w n) (x ^+ Z.to_nat n).
Proof. by case: n => [|n|n] b; [exact: below_one|exact: below_raised|exact: below_one]. Qed.

Lemma below_total A (ws : seq A) (f : A -> wealth) (x : A -> R) : (forall a, In a ws -> below (f a) (x a)) ->
  below (total [seq f a | a <- ws]) (\sum_(a <- ws) x a).
Proof.
move=> all_; rewrite /total; move: (Z.sub _ _) => least; apply: below_trimmed.
have onto s t : below (s, least) t -> below (List.fold_left (fun s w => Z.add s (Z.shiftl w.1 (Z.sub w.2 least))) [seq f a | a <- ws] s, least) (t + \sum_(a <- ws) x a).
  elim: ws s t all_ => [|a ws IH] s t all_ [s0 st] /=; first by rewrite big_nil addr0.
  rewrite big_cons addrA; apply: IH => [b bs|]; first by apply: all_; right.
  have [w0 wx] := all_ a (or_introl erefl); split.
    by apply: Z.add_nonneg_nonneg => //; apply/Z.shiftl_nonneg.
  rewrite /value [(_, _).1]/= embedD mulrDl; apply: ler_add => //; apply: le_trans wx.
  have -> : value (f a) = embed (f a).1 * pow (Z.sub (f a).2 least) * pow least by rewrite -mulrA -powD Z.sub_add.
  by rewrite ler_wpmul2r ?(ltW (pow_gt0 _)) // shift_le.
by rewrite -[X in below _ X]add0r; apply/onto/below_nothing.
Qed.

Lemma embed_size A (xs : seq A) : embed (Z.of_nat (length xs)) = (size xs)%:R.
Proof. by elim: xs => // x xs IH; rewrite [length _]/= Nat2Z.inj_succ -Z.add_1_l embedD IH mulrS. Qed.

Lemma below_mean A (ws : seq A) (f : A -> wealth) (x : A -> R) : (forall a, In a ws -> below (f a) (x a)) ->
  below (mean [seq f a | a <- ws]) ((\sum_(a <- ws) x a) / (size ws)%:R).
Proof.
move=> all_; rewrite /mean; have := below_total all_; case: (total _) => m e [m0 le]; rewrite -embed_size.
have : Z.le 0 kept by []. move: kept => k k0; change (Z.le 0 m) in m0.
have -> : length [seq f a | a <- ws] = length ws by elim: (ws) => //= b bs ->.
case: (Z.of_nat (length ws)) (Zle_0_nat (length ws)) => [_|n _|n []//]; last first.
  split; first by apply: Z.div_pos; [exact/Z.shiftl_nonneg|].
  rewrite /value [(_, _).1]/= [(_, _).2]/= ler_pdivl_mulr ?embed_pos // mulrAC; apply: le_trans le.
  have -> : value (m, e) = embed m * pow k * pow (Z.sub e k) by rewrite -mulrA -powD Zplus_minus.
  rewrite ler_wpmul2r ?(ltW (pow_gt0 _)) // -ler_pdivl_mulr ?embed_pos //.
  by apply: le_trans (div_embed _ _) _ => //; rewrite shiftl_embed.
by rewrite Zdiv_0_r embed0 invr0 mulr0; apply: below_nothing.
Qed.

(* ---- A level that is reached ---- *)

Lemma bits_low m : Z.lt 0 m -> pow (Z.sub (bits m) 1) <= embed m.
Proof.
move=> m0; rewrite /bits; case: (Z.leb_spec m 0) => [?|_]; first lia.
have -> : Z.sub (Z.add (Z.log2 m) 1) 1 = Z.log2 m by lia.
rewrite -pow_embed; last exact: Z.log2_nonneg.
by apply/embed_le/Z.leb_le; case: (Z.log2_spec m m0).
Qed.

Lemma bits_high m : Z.lt 0 m -> embed m <= pow (bits m).
Proof.
move=> m0; rewrite /bits; case: (Z.leb_spec m 0) => [?|_]; first lia.
rewrite -pow_embed; last by have := Z.log2_nonneg m; lia.
by apply/embed_le/Z.leb_le; case: (Z.log2_spec m m0); rewrite -Z.add_1_r => _ /Z.lt_le_incl.
Qed.

Lemma pow_le e f : Z.le e f -> pow e <= pow f.
Proof.
move=> ef; rewrite -(Z.sub_add e f) powD ler_pmull // -pow_embed; last lia.
by rewrite -(embed1 R); apply/embed_le/Z.leb_le; have := Z.pow_pos_nonneg 2 (Z.sub f e); lia.
Qed.

Lemma reachesP w level : reaches w level -> 1 <= ratio level * value w.
Proof.
case: w => m e; rewrite /reaches [(_, _).1]/= [(_, _).2]/=.
have -> : ratio level * value (m, e) = embed (Z.mul m (Qnum level)) * pow e / embed (Zpos (Qden level)).
  rewrite embedM /value /FractionsSound.ratio; move: (embed_neq0 R (Qden level)) (embed m) (pow e) => /=.
  by move: (embed (Qnum level)) (embed (Zpos (Qden level))) => a b b0 c d; field.
rewrite ler_pdivl_mulr ?embed_pos // mul1r.
move: (Z.mul m (Qnum level)) (Qden level) => {level} m' d; move: m' => {} m.
case: ifP => _.
  case: ifP => [/Z.leb_le e0|/Z.leb_nle e0] /(embed_le R); first by rewrite shiftl_embed.
  rewrite shiftl_embed; last lia.
  by rewrite powN => le; rewrite -ler_pdivr_mulr.
case/andP => /Z.ltb_lt m0 /Z.ltb_lt over.
apply: le_trans (bits_high _) _ => //; apply: (@le_trans _ _ (pow (Z.add (Z.sub (bits m) 1) e))); first by apply: pow_le; lia.
by rewrite powD ler_wpmul2r ?(ltW (pow_gt0 _)) ?bits_low.
Qed.

(* ---- What bets win ---- *)

Definition exact_factor (r l x y : R) : R := 1 + l * (r * y - x).
Definition exact_won (r : R) (cs : seq contrast) (l : R) : R :=
  \prod_(c <- cs) exact_factor r l (ratio (higher c)) (ratio (lower c)) ^+ Z.to_nat (number c).
Definition exact_wealth (r : R) (cs : seq contrast) : R :=
  (\sum_(l <- bets_for (count cs)) exact_won r cs (ratio l)) / (size (bets_for (count cs)))%:R.

Definition part (x : R) : Prop := 0 <= x <= 1.

Lemma bets_from01 most a b n l : part (ratio a) -> part (ratio b) -> In l (bets_from most a b n) -> part (ratio l).
Proof.
elim: most a b => [|most IH] a b pa pb /=; first by case=> // <-.
case=> [<- //|]; case: ifP => // _; apply: IH => //.
rewrite /part ratio_times; have /andP[a0 a1] := pa.
have h : ratio half = 2%:R^-1 by rewrite /FractionsSound.ratio /= embed1 mul1r.
rewrite h mulr_ge0 ?invr_ge0 ?ler0n //=.
by apply: le_trans a1; rewrite ler_pimulr // invf_le1 ?ltr0n // ler1n.
Qed.

Lemma bets01 n l : In l (bets_for n) -> part (ratio l).
Proof.
have frac a b : (Z.leb 0 a) && Z.leb a (Zpos b) -> part (ratio (Qmake a b)).
  case/andP => a0 ab; rewrite /part /ratio divr_ge0 ?embed_ge0 ?(ltW (embed_pos _ _)) //=.
  by rewrite ler_pdivr_mulr ?embed_pos // mul1r embed_le.
by apply: bets_from01; apply: frac.
Qed.

Lemma exact_factor_ge0 r l x y : 0 <= r -> part l -> part x -> part y -> 0 <= exact_factor r l x y.
Proof.
move=> r0 /andP[l0 l1] /andP[x0 x1] /andP[y0 y1].
apply: (@le_trans _ _ (1 - l)); first by rewrite subr_ge0.
by rewrite ler_add2l -mulrN1 ler_wpmul2l // ler_oppl opprB (le_trans _ x1) // ler_subl_addr ler_addl mulr_ge0.
Qed.

Definition in_parts (cs : seq contrast) : Prop := forall c, In c cs -> part (ratio (higher c)) /\ part (ratio (lower c)).

Lemma exact_won_ge0 r cs l : 0 <= r -> part l -> in_parts cs -> 0 <= exact_won r cs l.
Proof.
move=> r0 pl; elim: cs => [|c cs IH] parts; first by rewrite /exact_won big_nil ler01.
rewrite /exact_won big_cons mulr_ge0 //; last by apply: IH => d ds; apply: parts; right.
by have [px py] := parts c (or_introl erefl); apply/exprn_ge0/exact_factor_ge0.
Qed.

Lemma exact_wealth_ge0 r cs : 0 <= r -> in_parts cs -> 0 <= exact_wealth r cs.
Proof.
move=> r0 parts; apply: divr_ge0; last exact: ler0n.
by apply: sum_ge0_in => l /bets01 pl; apply: exact_won_ge0.
Qed.

Lemma below_factor limit bet c : 0 <= exact_factor (ratio limit) (ratio bet) (ratio (higher c)) (ratio (lower c)) ->
  below (factor limit bet c) (exact_factor (ratio limit) (ratio bet) (ratio (higher c)) (ratio (lower c))).
Proof.
case: limit => a b; case: bet => n d; case: c => k [p q] [u v] j; rewrite [higher _]/= [lower _]/= => f0.
pose D := Z.mul (Z.mul (Z.mul (Zpos d) (Zpos b)) (Zpos q)) (Zpos v).
pose A := Z.add D (Z.mul n (Z.sub (Z.mul (Z.mul a u) (Zpos q)) (Z.mul (Z.mul p (Zpos b)) (Zpos v)))).
have -> : factor (Qmake a b) (Qmake n d) (Contrast k (Qmake p q) (Qmake u v) j) = quotient A D by [].
have D0 : 0 < embed D by rewrite /D !embedM; do ?[apply: mulr_gt0]; exact: embed_pos.
have e : embed A / embed D = exact_factor (ratio (Qmake a b)) (ratio (Qmake n d)) (ratio (Qmake p q)) (ratio (Qmake u v)).
  rewrite /A /exact_factor /ratio embedD mulrDl divff ?gt_eqF //; congr (1 + _); rewrite /Qnum /Qden.
  rewrite embedM -Z.add_opp_r embedD embedN !embedM; do ?rewrite /D !embedM.
  have nz (z : positive) : embed (Zpos z) != 0 by rewrite embed_neq0.
  move: (nz b) (nz d) (nz q) (nz v); move: (embed (Zpos b)) (embed (Zpos d)) (embed (Zpos q)) (embed (Zpos v)) => b' d' q' v' ? ? ? ?.
  by field; do ?[apply/andP; split].
rewrite -e; apply: below_quotient; last by rewrite /D; lia.
apply/Z.leb_le; rewrite -(embed_leE R) embed0; move: f0; rewrite -e.
by rewrite pmulr_lge0 // invr_gt0.
Qed.

Lemma below_won limit cs l : 0 <= ratio limit -> part (ratio l) -> in_parts cs -> below (won limit cs l) (exact_won (ratio limit) cs (ratio l)).
Proof.
move=> r0 pl parts; rewrite /won /exact_won.
pose step w c := product w (to_the (factor limit l c) (number c)).
have onto w x : below w x -> below (List.fold_left step cs w)
    (x * \prod_(c <- cs) exact_factor (ratio limit) (ratio l) (ratio (higher c)) (ratio (lower c)) ^+ Z.to_nat (number c)).
  elim: cs w x parts => [|c cs IH] w x parts wx /=; first by rewrite big_nil mulr1.
  rewrite big_cons mulrA; apply: IH => [d ds|]; first by apply: parts; right.
  have [px py] := parts c (or_introl erefl).
  by apply: below_product => //; apply/below_to_the/below_factor/exact_factor_ge0.
by rewrite -[X in below _ X]mul1r; apply/onto/below_one.
Qed.

Lemma is_partP q : is_part q -> part (ratio q).
Proof. by case/andP => /(ratio_ge0 R) q0 /(at_mostP R); rewrite ratio_one /part q0. Qed.

Theorem wealth_below limit cs : 0 <= ratio limit -> 0 <= exact_wealth (ratio limit) cs ->
  below (wealth_of limit cs) (exact_wealth (ratio limit) cs).
Proof.
move=> r0 w0; rewrite /wealth_of; case: ifP => [/andP[_ /forallb_forall parts]|_]; last exact: below_nothing.
by apply: below_mean => l /bets01 pl; apply: below_won => // c /parts /andP[/is_partP pc /is_partP].
Qed.
End Sound.
