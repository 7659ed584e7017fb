(* The greatest total variation distance, with its first pair: the program of Distances.v finds it. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.algebra_tactics Require Import ring.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Distances Checker ListsSound TableSound WidestSound BlocksSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Laws.
Variable R : realFieldType.
Local Notation ratio := (@ratio R).
Local Notation embed := (@embed R).
Local Notation number := (@ListsSound.number R).

Definition excess (p q : R) : R := Num.max 0 (p - q).

Lemma distance_ofE n ps qs : of_length n ps -> of_length n qs ->
  ratio (distance_of ps qs) = \sum_(u <- range n) excess (number u ps) (number u qs).
Proof.
move=> /of_lengthP[_ e] /of_lengthP[_ e'].
rewrite (sum_range_nat n (fun i => excess (ratio (List.nth i ps zero)) (ratio (List.nth i qs zero)))) -e.
have : size ps = size qs by rewrite e e'.
elim: ps qs {e e'} => [|p ps IH] [|q qs] //= => [_|[e]]; first by rewrite big_nil ratio_zero.
rewrite big_nat_recl //= -(IH qs e) (at_mostE R) /excess.
case: ifP => [le|/negbT]; first by rewrite max_l ?add0r // subr_le0.
by rewrite -ltNge => lt; rewrite max_r ?subr_ge0 ?(ltW lt) // !ratio_plus ratio_minus.
Qed.

Lemma raised_fromE n ps qs : of_length n ps -> of_length n qs ->
  raised_from Z0 ps qs = [seq u <- range n | 0 < number u ps - number u qs].
Proof.
move=> /of_lengthP[_ e] /of_lengthP[_ e']; rewrite rangeE -e.
have : size ps = size qs by rewrite e e'.
have -> : [seq u <- [seq Z.of_nat i | i <- iota 0 (size ps)] | 0 < number u ps - number u qs] =
    [seq Z.of_nat i | i <- [seq i <- iota 0 (size ps) | 0 < ratio (List.nth (i - 0) ps zero) - ratio (List.nth (i - 0) qs zero)]].
  by rewrite filter_map; congr map; apply: eq_filter => i /=; rewrite /number Nat2Z.id subn0.
rewrite -[Z0]/(Z.of_nat 0); move: {e e'} 0%N => k.
elim: ps qs k => [|p ps IH] [|q qs] k //= [e].
have -> : [seq i <- iota k.+1 (size ps) | 0 < ratio (List.nth (i - k) (p :: ps) zero) - ratio (List.nth (i - k) (q :: qs) zero)] =
    [seq i <- iota k.+1 (size ps) | 0 < ratio (List.nth (i - k.+1) ps zero) - ratio (List.nth (i - k.+1) qs zero)].
  by apply: eq_in_filter => i; rewrite mem_iota => /andP[ki _]; rewrite -(subnSK ki).
rewrite subnn subr_gt0 (at_mostE R) -[Z.add _ _]/(Z.add (Z.of_nat k) 1).
have -> : Z.add (Z.of_nat k) 1 = Z.of_nat k.+1 by lia.
by rewrite (IH qs k.+1 e) ltNge; case: ifP.
Qed.

(* ---- Rounded numbers ---- *)

Lemma embed_ltE a b : (embed a < embed b) = Z.ltb a b.
Proof. by rewrite ltNge embed_leE Z.ltb_antisym. Qed.

Lemma scale_gt0 : 0 < embed scale. Proof. exact: embed_pos. Qed.

Lemma roundedP q : embed (rounded q) <= ratio q * embed scale /\ ratio q * embed scale < embed (Z.add (rounded q) 1).
Proof.
have d0 := embed_pos R (Qden q); have e : ratio q * embed scale = embed (Z.mul (Qnum q) scale) / embed (Zpos (Qden q)).
  by rewrite /FractionsSound.ratio embedM mulrAC.
have pos : Z.lt 0 (Zpos (Qden q)) by [].
have := Z.mul_div_le (Z.mul (Qnum q) scale) _ pos; have := Z.mul_succ_div_gt (Z.mul (Qnum q) scale) _ pos.
rewrite -/(rounded q) -Z.add_1_r => gt le; split; rewrite e.
  by rewrite ler_pdivl_mulr // -embedM embed_leE; apply/Z.leb_le; lia.
by rewrite ltr_pdivr_mulr // -embedM embed_ltE; apply/Z.ltb_lt; lia.
Qed.

Lemma rough_distanceP n ps qs : of_length n ps -> of_length n qs ->
  ratio (distance_of ps qs) * embed scale <= embed (rough_distance (map rounded ps) (map rounded qs)).
Proof.
move=> /of_lengthP[_ e] /of_lengthP[_ e']; have : size ps = size qs by rewrite e e'.
elim: ps qs {e e'} => [|p ps IH] [|q qs] //= => [_|[e]]; first by rewrite ratio_zero mul0r embed0.
have {}IH := IH qs e; rewrite embedD (at_mostE R).
have [pl ph] := roundedP p; have [ql qh] := roundedP q.
case: (Z.ltb_spec (rounded p) (rounded q)) => [lt|ge].
  have pq : ratio p <= ratio q.
    rewrite -(ler_pmul2r scale_gt0); apply: le_trans (ltW ph) (le_trans _ ql); rewrite embed_leE; apply/Z.leb_le; lia.
  by rewrite pq embed0 add0r.
have one_step : (ratio p - ratio q) * embed scale <= embed (Z.add (Z.sub (rounded p) (rounded q)) 1).
  rewrite mulrBl -Z.add_opp_r -Z.add_assoc [Z.add (Z.opp _) 1]Z.add_comm Z.add_assoc embedD embedN.
  by apply: ler_sub ql; apply: ltW.
have ge0 : 0 <= embed (Z.add (Z.sub (rounded p) (rounded q)) 1) by rewrite -(embed0 R) embed_leE; apply/Z.leb_le; lia.
case: ifP => _; first by rewrite -[X in X <= _]add0r ler_add.
by rewrite !ratio_plus ratio_minus mulrDl ler_add.
Qed.
End Laws.
