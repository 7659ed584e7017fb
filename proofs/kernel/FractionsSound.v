(* What integers and fractions are in an ordered field, and that programs compute with them as they should. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.algebra_tactics Require Import ring.
From FairauditKernel Require Import Fractions.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ==== What the numbers mean (this part has to be read) ==== *)

(* an integer as an element of the field *)
Definition embed {R : realFieldType} (z : Z) : R := (int_of_Z z)%:~R.

(* a fraction *)
Definition ratio {R : realFieldType} (q : Q) : R := embed (Qnum q) / embed (Zpos (Qden q)).

Arguments embed {R} z : simpl never.
Arguments ratio {R} q : simpl never.

(* ==== Proofs ==== *)

Section Meaning.
Variable R : realFieldType.
Local Notation embed := (@embed R).
Local Notation ratio := (@ratio R).

Lemma embedD a b : embed (Z.add a b) = embed a + embed b.
Proof. by rewrite /embed -[Z.add a b]/(a + b) !rmorphD. Qed.

Lemma embedM a b : embed (Z.mul a b) = embed a * embed b.
Proof. by rewrite /embed -[Z.mul a b]/(a * b) !rmorphM. Qed.

Lemma embedN a : embed (Z.opp a) = - embed a.
Proof. by rewrite /embed -[Z.opp a]/(- a) !rmorphN. Qed.

Lemma embed0 : embed Z0 = 0. Proof. by []. Qed.
Lemma embed1 : embed (Zpos xH) = 1. Proof. by []. Qed.

Lemma embed_ge0 a : Z.leb Z0 a -> 0 <= embed a.
Proof. by case: a => // p _; rewrite /embed /= ler0n. Qed.

Lemma embed_gt0 a : Z.ltb Z0 a -> 0 < embed a.
Proof. case: a => // p _; rewrite /embed /= ltr0n; apply/ssrnat.ltP; exact: Pos2Nat.is_pos. Qed.

Lemma embed_pos p : 0 < embed (Zpos p). Proof. exact: embed_gt0. Qed.

Lemma embed_le0 a : Z.leb a Z0 -> embed a <= 0.
Proof.
move=> /Z.leb_le /Z.opp_nonneg_nonpos /Z.leb_le /embed_ge0.
by rewrite embedN oppr_ge0.
Qed.

Lemma embed_le a b : Z.leb a b -> embed a <= embed b.
Proof.
move=> /Z.leb_le /Zle_minus_le_0 /Z.leb_le /embed_ge0.
by rewrite -Z.add_opp_r embedD embedN subr_ge0.
Qed.

Lemma embed_neq0 p : embed (Zpos p) != 0 :> R.
Proof. by rewrite gt_eqF // embed_pos. Qed.

Lemma ratio_eq (q r : Q) : Z.mul (Qnum q) (Zpos (Qden r)) = Z.mul (Qnum r) (Zpos (Qden q)) -> ratio q = ratio r.
Proof.
by move=> e; apply/eqP; rewrite /ratio eqr_div ?embed_neq0 // -!embedM e.
Qed.

Lemma ratio_reduced q : ratio (reduced q) = ratio q.
Proof.
rewrite /reduced; case: q => n d /=.
have [n' n'E] := Z.gcd_divide_l n (Zpos d); have [d' d'E] := Z.gcd_divide_r n (Zpos d).
have g0 : Z.gcd n (Zpos d) <> Z0 by move=> e; rewrite e Z.mul_0_r in d'E.
rewrite [in Z.div (Zpos d)]d'E Z.div_mul // [in Z.div n]n'E Z.div_mul //.
case: d' d'E => [|p|p] // d'E; apply: ratio_eq => /=.
by rewrite [in RHS]n'E [in LHS]d'E; ring.
Qed.

Lemma ratio_plus q r : ratio (plus q r) = ratio q + ratio r.
Proof.
rewrite ratio_reduced /ratio /= Pos2Z.inj_mul embedD !embedM addf_div ?embed_neq0 //.
Qed.

Lemma ratio_times q r : ratio (times q r) = ratio q * ratio r.
Proof. by rewrite ratio_reduced /ratio /= Pos2Z.inj_mul !embedM mulf_div. Qed.

Lemma ratio_minus q : ratio (minus q) = - ratio q.
Proof. by rewrite /ratio /= embedN mulNr. Qed.

Lemma ratio_inverse q : positive_fraction q -> ratio (inverse q) = (ratio q)^-1.
Proof. by case: q => [[|n|n] d] // _; rewrite /ratio /inverse /= invf_div. Qed.

Lemma ratio_zero : ratio zero = 0. Proof. by rewrite /ratio /= embed0 mul0r. Qed.
Lemma ratio_one : ratio one = 1. Proof. by rewrite /ratio /= embed1 divr1. Qed.

Lemma ratio_ge0 q : nonnegative q -> 0 <= ratio q.
Proof. by move=> /embed_ge0 q0; rewrite /ratio divr_ge0 // ltW // embed_pos. Qed.

Lemma ratio_gt0 q : positive_fraction q -> 0 < ratio q.
Proof. by move=> /embed_gt0 q0; rewrite /ratio divr_gt0 // embed_pos. Qed.

Lemma at_mostP q r : at_most q r -> ratio q <= ratio r.
Proof.
move=> /embed_le; rewrite !embedM /ratio => le.
by rewrite ler_pdivr_mulr ?embed_pos // mulrAC ler_pdivl_mulr ?embed_pos.
Qed.

Lemma equalP q r : equal q r -> ratio q = ratio r.
Proof. by case/andP => /Z.eqb_eq num /Z.eqb_eq den; apply: ratio_eq; rewrite num den. Qed.

Lemma ratio_total qs : ratio (total qs) = \sum_(q <- qs) ratio q.
Proof. by elim: qs => [|q qs IH]; rewrite ?big_nil ?ratio_zero // big_cons -IH -ratio_plus. Qed.

(* What is decided of fractions is so in the field, and only then. *)

Lemma embed_leE a b : (embed a <= embed b) = Z.leb a b.
Proof.
apply/idP/idP => [|/embed_le //]; apply: contraTT => /negbTE ab; rewrite -ltNge.
have : Z.ltb Z0 (Z.sub a b) by move/Z.leb_gt: ab => ab; apply/Z.ltb_lt; apply/Z.lt_0_sub.
by move/embed_gt0; rewrite -Z.add_opp_r embedD embedN subr_gt0.
Qed.

Lemma at_mostE q r : at_most q r = (ratio q <= ratio r).
Proof.
by rewrite /at_most -embed_leE !embedM /ratio ler_pdivr_mulr ?embed_pos // mulrAC ler_pdivl_mulr ?embed_pos.
Qed.

Lemma positive_fractionE q : positive_fraction q = (0 < ratio q).
Proof.
rewrite /positive_fraction /ratio pmulr_lgt0 ?invr_gt0 ?embed_pos // -embed0 ltNge embed_leE.
by rewrite Z.ltb_antisym.
Qed.

Lemma nonnegativeE q : nonnegative q = (0 <= ratio q).
Proof. by rewrite /nonnegative /ratio pmulr_lge0 ?invr_gt0 ?embed_pos // -embed0 embed_leE. Qed.

Lemma no_numeratorE q : Z.eqb (Qnum q) Z0 = (ratio q == 0).
Proof.
rewrite eq_le -nonnegativeE -ratio_zero -at_mostE /at_most /nonnegative /= Z.mul_1_r.
by apply/Z.eqb_spec/andP => [->|[/Z.leb_le low /Z.leb_le high]]; [split | apply: Z.le_antisymm].
Qed.

(* ---- Sums over lists ---- *)

Lemma eq_sum_in A (s : list A) (F G : A -> R) : (forall x, In x s -> F x = G x) -> \sum_(x <- s) F x = \sum_(x <- s) G x.
Proof.
elim: s => [|x s IH] e; rewrite ?big_nil // !big_cons e; last by left.
by rewrite IH // => y ys; apply: e; right.
Qed.

Lemma sum_ge0_in A (s : list A) (F : A -> R) : (forall x, In x s -> 0 <= F x) -> 0 <= \sum_(x <- s) F x.
Proof.
elim: s => [|x s IH] e; rewrite ?big_nil // big_cons addr_ge0 //; first by apply: e; left.
by apply: IH => y ys; apply: e; right.
Qed.

(* A weighted mean lies between the ends of what it is a mean of. *)
Lemma mean_between A (s : list A) (w f : A -> R) lo hi :
  (forall x, In x s -> 0 <= w x) -> (forall x, In x s -> lo <= f x <= hi) -> 0 < \sum_(x <- s) w x ->
  lo <= (\sum_(x <- s) w x * f x) / (\sum_(x <- s) w x) <= hi.
Proof.
move=> w0 between W0; rewrite ler_pdivl_mulr // ler_pdivr_mulr // !mulr_sumr.
apply/andP; split; rewrite -subr_ge0 -sumrB; apply: sum_ge0_in => x xs; have /andP[low high] := between x xs.
- by rewrite [lo * _]mulrC -mulrBr mulr_ge0 ?w0 // subr_ge0.
- by rewrite [hi * _]mulrC -mulrBr mulr_ge0 ?w0 // subr_ge0.
Qed.
End Meaning.
