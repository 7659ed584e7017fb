(* A ladder that the program of PairLaw.v accepts is one as theories/PairExact.v has them. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.algebra_tactics Require Import ring.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Tails TailsSound PairLaw PairLawSound.
From Fairaudit Require Import Definitions Binomial PairExact.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- The order of the outcomes ---- *)

Section Order.
Implicit Types es : list (Z * Z).
Local Notation end_at es k := (nth (Z0, Z0) es k).

Lemma rising_from low up es k : rising low up es -> (k < size es)%N -> Z.le low (end_at es k).1 /\ Z.le up (end_at es k).2.
Proof.
elim: es low up k => //= e es IH low up [|k] /and3P[/Z.leb_le le1 /Z.leb_le le2 rest] //.
by rewrite ltnS => /(IH _ _ _ rest)[le3 le4]; split; [exact: Z.le_trans le1 le3 | exact: Z.le_trans le2 le4].
Qed.

Lemma rising_nth low up es j k : rising low up es -> (j <= k)%N -> (k < size es)%N ->
  Z.le (end_at es j).1 (end_at es k).1 /\ Z.le (end_at es j).2 (end_at es k).2.
Proof.
elim: es low up j k => //= e es IH low up [|j] [|k] // /and3P[_ _ rest]; first by split; lia.
  by rewrite ltnS => _ lt; apply: rising_from rest lt.
by rewrite !ltnS; apply: IH rest.
Qed.

Lemma size_scores n z2 : size (scores (Z.of_nat n) z2) = n.+1.
Proof.
have onto many k there : size (scores_onto many (Z.of_nat n) (Qnum z2) (Zpos (Qden z2)) k there) = (many + size there)%N.
  by elim: many k there => // many IH k there; rewrite [scores_onto _ _ _ _ _ _]/= IH addnS.
by rewrite /scores onto Nat2Z.id addn0.
Qed.

(* The scores of the program, which it makes sure rise; if they did not, all would be alike. *)
Definition scores_rise n z2 : bool := rising 0 1 (scores (Z.of_nat n) z2).
Definition high_score n z2 (a : nat) : nat := if scores_rise n z2 then Z.to_nat (end_at (scores (Z.of_nat n) z2) (minn a n)).2 else 1%N.
Definition low_score m z2 (b : nat) : nat := if scores_rise m z2 then Z.to_nat (end_at (scores (Z.of_nat m) z2) (minn b m)).1 else 1%N.

Definition order n m z2 : nat * nat -> nat * nat -> bool := by_scores (high_score n z2) (low_score m z2).

Lemma high_score_gt0 n z2 a : (0 < high_score n z2 a)%N.
Proof.
rewrite /high_score; case: ifP => // rise_; have := @rising_from _ _ _ (minn a n) rise_.
by rewrite size_scores ltnS geq_minr => /(_ isT)[_ one]; lia.
Qed.

Lemma min_le a a' n : (a <= a')%N -> (minn a n <= minn a' n)%N.
Proof. by move=> le; rewrite leq_min geq_minr andbT (leq_trans (geq_minl _ _)). Qed.

Lemma high_score_rises n z2 a a' : (a <= a')%N -> (high_score n z2 a <= high_score n z2 a')%N.
Proof.
rewrite /high_score; case: ifP => // rise_ /(@min_le _ _ n) le; have := rising_nth rise_ le.
by rewrite size_scores ltnS geq_minr => /(_ isT)[_ two]; lia.
Qed.

Lemma low_score_rises m z2 b b' : (b <= b')%N -> (low_score m z2 b <= low_score m z2 b')%N.
Proof.
rewrite /low_score; case: ifP => // rise_ /(@min_le _ _ m) le; have := rising_nth rise_ le.
by rewrite size_scores ltnS geq_minr => /(_ isT)[one _]; lia.
Qed.

Theorem order_total n m z2 o o' : order n m z2 o o' || order n m z2 o' o.
Proof. exact: by_scores_total. Qed.

Theorem order_transitive n m z2 o o' o'' : order n m z2 o o' -> order n m z2 o' o'' -> order n m z2 o o''.
Proof. exact: by_scores_transitive (@high_score_gt0 n z2) _ _ _. Qed.

Theorem order_staircase n m z2 a a' b b' o : order n m z2 (a, b) o -> (a' <= a)%N -> (b <= b')%N -> order n m z2 (a', b') o.
Proof. exact: by_scores_staircase (@high_score_rises n z2) (@low_score_rises m z2) _ _ _ _ _. Qed.

(* ---- Stairs ---- *)

Lemma later_onesP up bottom top at_ (ls : list (Z * Z)) : exists at', [/\ (at_ <= at')%N,
  later_ones up bottom top (Z.of_nat at_) (drop at_ ls) = (Z.of_nat at', drop at' ls) &
  forall b, (at_ <= b < at')%N -> Z.lt (Z.mul top (end_at ls b).1) (Z.mul up bottom)].
Proof.
move e : (drop at_ ls) => es; elim: es at_ e => [|x es IH] at_ e.
  by exists at_; split=> // [|b /andP[le lt]]; [rewrite e | rewrite ltnNge le in lt].
rewrite /=; case: ifP => [_|/Z.leb_gt later].
  by exists at_; split=> // [|b /andP[le lt]]; [rewrite e | rewrite ltnNge le in lt].
have e' : drop at_.+1 ls = es by rewrite -addn1 addnC -drop_drop e /= drop0.
have [at' [le eq_ all_later]] := IH at_.+1 e'; exists at'; split; first exact: ltnW.
  by rewrite -eq_; congr later_ones; lia.
move=> b /andP[]; rewrite leq_eqVlt => /orP[/eqP<- _|lt1 lt2]; last by apply: all_later; rewrite lt1.
by rewrite -(addn0 at_) -nth_drop e.
Qed.

Lemma stairs_ontoP bottom top (ls es : list (Z * Z)) done at_ low up : Z.le 0 bottom -> rising low up es ->
  (forall b, (b < at_)%N -> Z.lt (Z.mul top (end_at ls b).1) (Z.mul up bottom)) ->
  exists sn, stairs_onto done bottom top (Z.of_nat at_) (drop at_ ls) es = catrev done (map Z.of_nat sn) /\
    forall i b, (i < size es)%N -> (b < nth 0 sn i)%N -> Z.lt (Z.mul top (end_at ls b).1) (Z.mul (end_at es i).2 bottom).
Proof.
move=> bottom0; elim: es done at_ low up => [|e es IH] done at_ low up /=; first by exists [::].
case/and3P => _ /Z.leb_le le_up rest later.
have [at' [le -> all_later]] := later_onesP e.2 bottom top at_ ls.
have later' b : (b < at')%N -> Z.lt (Z.mul top (end_at ls b).1) (Z.mul e.2 bottom).
  move=> lt; case: (ltnP b at_) => [/later|ge]; last by apply: all_later; rewrite ge.
  by move: (Z.mul top _) => x; nia.
have [sn [-> all_i]] := IH (Z.of_nat at' :: done) at' _ _ rest later'.
exists (at' :: sn); split=> // -[|i] b /=; first by move=> _; apply: later'.
by rewrite ltnS; apply: all_i.
Qed.
End Order.

Lemma list_nth A (x0 : A) k xs : List.nth k xs x0 = nth x0 xs k.
Proof. by elim: xs k => [|x xs IH] [|k] //=. Qed.

Section Sound.
Variable R : realFieldType.
Local Notation embed := (@embed R).
Local Notation ratio := (@ratio R).

(* ---- Sums of what a law bounds ---- *)

Section Sums.
Variables (n : nat) (f : nat -> R) (L : sums) (c : R).
Hypotheses (f0 : forall j, 0 <= f j) (bound : bounded n f L).

Definition from k : R := \sum_(k <= j < n.+1) f j.

Lemma from_ge0 k : 0 <= from k. Proof. by apply: sumr_ge0. Qed.

Lemma fromS k : (k <= n)%N -> from k = f k + from k.+1.
Proof. by move=> kn; rewrite /from big_ltn. Qed.

Lemma from_le j k : (j <= k)%N -> from k <= from j.
Proof.
move=> jk; case: (leqP k n.+1) => [kn|nk]; last by rewrite {1}/from big_geq ?from_ge0 // ltnW.
by rewrite [leRHS](big_cat_nat _ _ _ jk kn) /= ler_addr; apply: sumr_ge0.
Qed.

(* The bounds of the sums from [at_] on, the last one being of all that are not listed *)
Definition are_tails at_ (ts : seq Z) : Prop := ts <> [::] /\ forall i, (i < size ts)%N -> from (at_ + i) <= embed (nth Z0 ts i).

Lemma sums_ontoP st done s (rs : seq Z) : (st + size rs <= n.+1)%N -> are_tails (st + size rs) (s :: done) ->
  (forall i, (i < size rs)%N -> f (st + i) <= embed (nth Z0 rs (size rs - i.+1))) -> are_tails st (sums_onto done s rs).
Proof.
elim: rs done s => [|r rs IH] done s; first by rewrite addn0.
rewrite /= addnS => small [_ low] term; have small' := ltnW small; apply: IH => //.
  split=> // -[|i] lt /=.
    rewrite addn0 fromS // addrC embedD; apply: ler_add; first by have := low 0%N isT; rewrite addn0.
    by have := term (size rs) (leqnn _); rewrite subnn.
  by have := low i; rewrite /= addnS -addSn; apply.
by move=> i lt; have := term i (leqW lt); rewrite subSS -(subnSK lt) /=.
Qed.

Lemma tailsP : exists st, [/\ start L = Z.of_nat st, are_tails st (tails L) & from 0 <= embed (everything L)].
Proof.
have [st [start_ size_ before_ terms_ after_]] := bound; exists st.
have tails_ : are_tails st (tails L).
  rewrite /tails -[rev_append _ _]/(rev (terms L)); apply: sums_ontoP; rewrite size_rev //.
    by split=> // -[|i] //=; rewrite addn0.
  move=> i lt; have lt' : (size (terms L) - i.+1 < size (terms L))%N by rewrite subnSK // leq_subr.
  by rewrite nth_rev // subnSK // subKn ?(ltnW lt) // terms_.
split=> //; rewrite /everything embedD /from (@big_cat_nat _ _ _ st) //=; last by rewrite (leq_trans _ size_) ?leq_addr.
apply: ler_add => //; have [some /(_ 0%N)] := tails_; rewrite addn0 /from; case: (tails L) some => // t ts _; exact.
Qed.

Lemma from_tail2 (t at_ : Z) a b ts :
  from_tail t at_ [:: a, b & ts] = if Z.ltb at_ t then from_tail t (Z.add at_ 1) (b :: ts) else (at_, [:: a, b & ts]).
Proof. by []. Qed.

Lemma from_tailP t at_ ts : are_tails at_ ts -> (at_ <= t)%N ->
  exists at', [/\ from_tail (Z.of_nat t) (Z.of_nat at_) ts = (Z.of_nat at', (from_tail (Z.of_nat t) (Z.of_nat at_) ts).2),
    (at' <= t)%N & are_tails at' (from_tail (Z.of_nat t) (Z.of_nat at_) ts).2].
Proof.
elim: ts at_ => [|a ts IH] at_ // tails_ le; first by exists at_.
case: ts IH tails_ => [|b ts] IH tails_; first by exists at_.
rewrite from_tail2.
case: ifP => [/Z.ltb_lt lt|_]; last by exists at_.
rewrite -of_nat_next; apply: IH; last by lia.
by case: tails_ => _ low; split=> // i lt_i; have := low i.+1 lt_i; rewrite addnS addSn.
Qed.

Lemma head_tail at_ ts t : are_tails at_ ts -> (at_ <= t)%N -> from t <= embed (hd Z0 ts).
Proof. by move=> [some /(_ 0%N)]; rewrite addn0; case: ts some => // a ts _ /(_ isT) low /from_le; move/le_trans; apply. Qed.

Lemma sum_of_firstP k at_ after_ ts s : (k <= n)%N -> (at_ + size ts <= n.+1)%N -> \sum_(0 <= j < at_) f j <= embed s ->
  (forall i, (i < size ts)%N -> f (at_ + i) <= embed (nth Z0 ts i)) -> from (at_ + size ts) <= embed after_ ->
  \sum_(0 <= j < k.+1) f j <= embed (sum_of_first (Z.sub (Z.add (Z.of_nat k) 1) (Z.of_nat at_)) after_ ts s).
Proof.
move=> kn; have part i j : (i <= j)%N -> \sum_(0 <= u < i) f u <= \sum_(0 <= u < j) f u.
  by move=> ij; rewrite [leRHS](@big_cat_nat _ _ _ i) //= ler_addl; apply: sumr_ge0.
elim: ts at_ s => [|t ts IH] at_ s small low term last /=; case: ifP => [/Z.ltb_lt more|/Z.ltb_ge enough].
- rewrite addn0 in last small; apply: le_trans (part k.+1 n.+1 kn) _.
  by rewrite (@big_cat_nat _ _ _ at_) //= embedD; apply: ler_add.
- by apply: le_trans low; apply: part; lia.
- rewrite -[Z.sub (Z.sub _ _) _]Z.sub_add_distr -(of_nat_next at_); apply: IH; rewrite ?addSnnS //.
    rewrite big_nat_recr //= embedD; apply: ler_add => //.
    by have := term 0%N isT; rewrite addn0.
  by move=> i lt; have := term i.+1 lt; rewrite addnS addSn.
- by apply: le_trans low; apply: part; lia.
Qed.
End Sums.

(* ---- Rare outcomes ---- *)

Lemma part_at_mostP s L share c x : 0 < c -> embed (sure L) <= c -> 0 <= ratio share -> x * c <= embed s -> part_at_most s L share -> x <= ratio share.
Proof.
move=> c0 le_c share0 low; have num0 : 0 <= embed (Qnum share).
  by move: share0; rewrite /FractionsSound.ratio pmulr_lge0 // invr_gt0 embed_pos.
rewrite /part_at_most -(embed_leE R) !embedM => le_sum.
rewrite /FractionsSound.ratio ler_pdivl_mulr ?embed_pos // -(ler_pmul2r c0) mulrAC.
apply: le_trans (_ : embed s * embed (Zpos (Qden share)) <= _); first by rewrite ler_pmul2r // embed_pos.
by apply: le_trans le_sum _; rewrite ler_wpmul2l.
Qed.

Section Rare.
Variables (n : nat) (p share : Q).
Hypotheses (p01 : 0 <= ratio p <= 1) (share0 : 0 <= ratio share).

Lemma rare_aboveP k : rare_above (law_at (Z.of_nat n) p) (Z.of_nat k) share -> at_least n (ratio p) k <= ratio share.
Proof.
have [c [c0 bound le_c]] := law_bounded n p01; apply: (part_at_mostP c0 le_c share0).
have f0 j : 0 <= successes n (ratio p) j * c by rewrite mulr_ge0 ?successes_ge0 // ltW.
have -> : at_least n (ratio p) k * c = from n (fun j => successes n (ratio p) j * c) k.
  by rewrite /from /at_least mulr_suml big_geq_mkord.
have [st [-> tails_ all_]] := tailsP bound; case: ifP => [_|/Z.ltb_ge le].
  by apply: le_trans all_; apply: from_le.
have le' : (st <= k)%N by lia.
have [at' [_ at_k tails']] := from_tailP tails_ le'.
exact: (head_tail f0 tails' at_k).
Qed.

Lemma rare_belowP k : (k <= n)%N -> rare_below (law_at (Z.of_nat n) p) (Z.of_nat k) share -> at_most n (ratio p) k <= ratio share.
Proof.
move=> kn; have [c [c0 bound le_c]] := law_bounded n p01; apply: (part_at_mostP c0 le_c share0).
have f0 j : 0 <= successes n (ratio p) j * c by rewrite mulr_ge0 ?successes_ge0 // ltW.
have [st [-> size_ before_ terms_ after_]] := bound.
rewrite /at_most mulr_suml -(big_mkord xpredT (fun j => successes n (ratio p) j * c)).
exact: (sum_of_firstP f0 kn size_ before_ terms_ after_).
Qed.
End Rare.

(* ---- The weight of a staircase ---- *)

Section Weight.
Variables (n m : nat) (f g : nat -> R) (H L : sums).
Hypotheses (f0 : forall j, 0 <= f j) (g0 : forall j, 0 <= g j) (boundH : bounded n f H) (boundL : bounded m g L).

Local Notation above_ := (from m g).

Lemma weight_fromS k all at_ ts t stairs u us s : weight_from k all at_ ts (t :: stairs) (u :: us) s =
  if Z.ltb t at_ then weight_from k all at_ ts stairs us (Z.add s (Z.mul u all))
  else if Z.ltb k t then weight_from k all at_ ts stairs us s
  else let (at_, ts) := from_tail t at_ ts in weight_from k all at_ ts stairs us (Z.add s (Z.mul u (hd Z0 ts))).
Proof. by []. Qed.

Lemma weight_fromP all at_ ts (sn : seq nat) us s i : above_ 0 <= embed all -> are_tails m g at_ ts ->
  (forall k, (k < size us)%N -> f (i + k) <= embed (nth Z0 us k)) ->
  embed s + \sum_(k < size us) f (i + k) * above_ (nth 0%N sn k) <=
    embed (weight_from (Z.of_nat m) all (Z.of_nat at_) ts (map Z.of_nat sn) us s).
Proof.
move=> all_; elim: us sn at_ ts s i => [|u us IH] sn at_ ts s i tails_ term; first by rewrite big_ord0 addr0; case: sn.
have le_all t : above_ t <= embed all by apply: le_trans all_; apply: from_le.
have term0 : f i <= embed u by have := term 0%N isT; rewrite addn0.
have rest k : (k < size us)%N -> f (i.+1 + k) <= embed (nth Z0 us k) by move=> lt; have := term k.+1 lt; rewrite addnS addSn.
rewrite big_ord_recl addn0 addrA; under eq_bigr do rewrite lift0 addnS -addSn.
case: sn => [|t sn].
  rewrite [weight_from _ _ _ _ _ _ _]/(weight_from (Z.of_nat m) all (Z.of_nat at_) ts (map Z.of_nat [::]) us (Z.add s (Z.mul u all))).
  apply: le_trans (IH [::] at_ ts _ i.+1 tails_ rest); rewrite embedD embedM.
  rewrite (eq_bigr (fun k : 'I__ => f (i.+1 + k) * above_ (nth 0%N [::] k))) ?ler_add2r ?ler_add2l => [|k _]; last by rewrite !nth_nil.
  by apply: ler_pmul => //; apply: from_ge0.
rewrite [nth _ _ _]/= [map _ _]/=; under eq_bigr do rewrite [nth _ _ _]/=.
rewrite weight_fromS.
case: ifP => [_|/Z.ltb_ge at_t].
  apply: le_trans (IH sn at_ ts _ i.+1 tails_ rest); rewrite embedD embedM ler_add2r ler_add2l.
  by apply: ler_pmul => //; apply: from_ge0.
case: ifP => [/Z.ltb_lt m_t|_].
  apply: le_trans (IH sn at_ ts _ i.+1 tails_ rest); rewrite ler_add2r {1}/from big_geq ?mulr0 ?addr0 //; lia.
have at_t' : (at_ <= t)%N by lia.
have [at' [-> at'_t tails']] := from_tailP tails_ at_t'.
apply: le_trans (IH sn at' _ _ i.+1 tails' rest); rewrite embedD embedM ler_add2r ler_add2l.
by apply: ler_pmul => //; [apply: from_ge0 | apply: (head_tail g0 tails' at'_t)].
Qed.

Lemma without_firstE k (ts : seq Z) : without_first (Z.of_nat k) ts = drop k ts.
Proof.
elim: ts k => [|t ts IH] k; first by case: k.
case: k => [|k] //.
rewrite -[without_first _ _]/(without_first (Z.sub (Z.of_nat k.+1) 1) ts) -(of_nat_last k); exact: IH.
Qed.

Lemma weightP (sn : seq nat) : \sum_(0 <= a < n.+1) f a * above_ (nth 0%N sn a) <= embed (weight (Z.of_nat m) (map Z.of_nat sn) H L).
Proof.
have [at_ [startL tails_ all_]] := tailsP boundL; have [st [startH size_ before_ terms_ after_]] := boundH.
rewrite /weight startL startH without_firstE -map_drop.
apply: le_trans (weight_fromP (drop st sn) _ all_ tails_ terms_).
have le_all t : above_ t <= embed (everything L) by apply: le_trans all_; apply: from_le.
have some u v : \sum_(u <= a < v) f a * above_ (nth 0%N sn a) <= (\sum_(u <= a < v) f a) * embed (everything L).
  by rewrite mulr_suml; apply: ler_sum => a _; apply: ler_wpmul2l.
have all0 : 0 <= embed (everything L) by apply: le_trans all_; apply: from_ge0.
rewrite (@big_cat_nat _ _ _ st) //=; last by rewrite (leq_trans _ size_) ?leq_addr.
rewrite (@big_cat_nat _ _ _ (st + size (terms H)) st) ?leq_addr //= embedM embedD mulrDl.
rewrite addrCA [X in _ <= X]addrC; apply: ler_add.
  rewrite -{1}[st]add0n [(st + _)%N]addnC big_addn addnK big_mkord le_eqVlt; apply/orP; left; apply/eqP; apply: eq_bigr => k _.
  by rewrite nth_drop addnC.
apply: ler_add; first by apply: le_trans (some _ _) _; apply: ler_wpmul2r.
by apply: le_trans (some _ _) _; apply: ler_wpmul2r.
Qed.
End Weight.

(* ---- Ladders ---- *)

Lemma imageE r q : ratio (PairLaw.image r q) = image (ratio r) (ratio q).
Proof. by rewrite /PairLaw.image /image (at_mostE R) ratio_one ratio_times; case: leP => _; rewrite ?ratio_one ?ratio_times. Qed.

Lemma last_is (q : Q) qs : List.last qs q = last q qs.
Proof.
case: qs => // x qs; rewrite [RHS]/=; elim: qs x => // y qs IH x.
by rewrite -[LHS]/(List.last (y :: qs) q) IH.
Qed.

Lemma guard_small level : 0 <= ratio level -> 0 <= ratio (guard_of level) <= ratio level.
Proof.
move=> l0; have c0 : 0 <= ratio (Qmake 1 50) by apply: ratio_ge0.
rewrite /guard_of ratio_times mulr_ge0 //=; have : ratio (Qmake 1 50) <= 1 by rewrite -ratio_one; apply: at_mostP.
by move=> le; rewrite -[leRHS]mulr1 ler_wpmul2l.
Qed.

Lemma shareE level : ratio (times (guard_of level) (Qmake 1 4)) = ratio (guard_of level) / 4%:R.
Proof. by rewrite ratio_times /FractionsSound.ratio /= embed1 mul1r (embed_nat R 4). Qed.

Section Ladder.
Variables (n m k k' : nat) (z2 : Q).
Hypotheses (kn : (k <= n)%N) (km : (k' <= m)%N) (rise_n : scores_rise n z2) (rise_m : scores_rise m z2).

Local Notation h := (scored (Z.of_nat n) (Z.of_nat k) z2).
Local Notation l := (scored (Z.of_nat m) (Z.of_nat k') z2).
Local Notation first := (order n m z2).

Lemma stairsP : exists sn, stairs h l = map Z.of_nat sn /\
  forall a b, (a <= n)%N -> (b <= m)%N -> first (a, b) (k, k') -> (nth 0%N sn a <= b)%N.
Proof.
rewrite /stairs /ends_at /= !Nat2Z.id !list_nth.
set es := scores (Z.of_nat n) z2; set ls := scores (Z.of_nat m) z2.
have [bottom0 _] : Z.le 0 (nth (Z0, Z0) ls k').1 /\ Z.le 1 (nth (Z0, Z0) ls k').2.
  by apply: (rising_from rise_m); rewrite size_scores.
have [|sn [e later]] := @stairs_ontoP _ (nth (Z0, Z0) es k).2 ls es [::] 0 _ _ bottom0 rise_n; first by move=> b; rewrite ltn0.
rewrite drop0 in e; exists sn; split; first exact: e.
move=> a b an bm; rewrite /order /by_scores /high_score /low_score rise_n rise_m /= !(minn_idPl _) // => le.
rewrite leqNgt; apply/negP => /later; rewrite size_scores ltnS an => /(_ isT).
have ends_ge x y (le_ : (y <= x)%N) (up : scores_rise x z2) : Z.le 0 (nth (Z0, Z0) (scores (Z.of_nat x) z2) y).1 /\ Z.le 1 (nth (Z0, Z0) (scores (Z.of_nat x) z2) y).2.
  by apply: (rising_from up); rewrite size_scores.
have [_ a1] := ends_ge _ _ an rise_n; have [_ k1] := ends_ge _ _ kn rise_n; have [b1 _] := ends_ge _ _ bm rise_m.
move: le a1 k1 b1; rewrite -/es -/ls => le a1 k1 b1; move: (nth _ es a).2 (nth _ es k).2 (nth _ ls b).1 (nth _ ls k').1 le a1 k1 b1 bottom0 => A K B C le A1 K1 B1 C1.
by move/Z.lt_nge; apply; nia.
Qed.

Variables r level : Q.
Hypotheses (r0 : 0 < ratio r) (level0 : 0 <= ratio level).

Lemma stepP sn q q' : stairs h l = map Z.of_nat sn ->
  (forall a b, (a <= n)%N -> (b <= m)%N -> first (a, b) (k, k') -> (nth 0%N sn a <= b)%N) ->
  0 <= ratio q -> 0 <= ratio q' <= 1 -> is_step h l (stairs h l) r (plus level (minus (guard_of level))) q q' ->
  step n m first (ratio level) (ratio (guard_of level)) (ratio r) (k, k') (ratio q) (ratio q').
Proof.
move=> -> least q0 q01; have i01 : 0 <= ratio (PairLaw.image r q) <= 1 by rewrite imageE image01 // ltW.
have [c [c0 boundH le_c]] := law_bounded n i01; have [d [d0 boundL le_d]] := law_bounded m q01.
rewrite /is_step /step -imageE /=; set goal := plus _ _; case/and3P.
rewrite -!(embed_leE R) embed0 !embedM => H0 L0 le_w.
have f0 j : 0 <= successes n (ratio (PairLaw.image r q)) j * c by rewrite mulr_ge0 ?successes_ge0 // ltW.
have g0 j : 0 <= successes m (ratio q') j * d by rewrite mulr_ge0 ?successes_ge0 // ltW.
have := weightP f0 g0 boundH boundL sn; move: (embed (weight _ _ _ _)) le_w => w le_w low.
have goalE : ratio level - ratio (guard_of level) = ratio goal by rewrite ratio_plus ratio_minus.
have num0 : 0 <= embed (Qnum goal).
  have : 0 <= ratio goal by rewrite -goalE subr_ge0; case/andP: (guard_small level0).
  by rewrite /FractionsSound.ratio pmulr_lge0 // invr_gt0 embed_pos.
rewrite goalE /FractionsSound.ratio ler_pdivl_mulr ?embed_pos // -(ler_pmul2r (mulr_gt0 c0 d0)) mulrAC.
apply: (@le_trans _ _ (w * embed (Zpos (Qden goal)))); last first.
  by apply: le_trans le_w _; rewrite ler_wpmul2l // ler_pmul.
rewrite ler_wpmul2r ?(ltW (embed_pos _ _)) //; apply: le_trans low.
rewrite prob_no_later' big_mkord mulr_suml; apply: ler_sum => a _; rewrite mulrACA; apply: ler_wpmul2l => //.
rewrite /chance_in /from mulr_suml big_geq_mkord big_mkcond [leRHS]big_mkcond; apply: ler_sum => b _ /=.
case: ifP => [ab|_]; last by case: ifP.
by rewrite (least a b _ _ ab) // -ltnS ltn_ord.
Qed.

Lemma rise_le1 q qs : rise q qs -> ratio q <= 1.
Proof.
elim: qs q => [|q' qs IH] q /=; first by rewrite (at_mostE R) ratio_one.
by rewrite (at_mostE R) -ltNge => /andP[/ltW le /IH]; apply: le_trans.
Qed.

Lemma last_le1 q qs : rise q qs -> ratio (last q qs) <= 1.
Proof. by elim: qs q => [|q' qs IH] q /=; [rewrite (at_mostE R) ratio_one | case/andP=> _ /IH]. Qed.

Lemma last_ge0 q qs : 0 <= ratio q -> rise q qs -> 0 <= ratio (last q qs).
Proof.
elim: qs q => //= x qs IH q q0 /andP[lt]; apply: IH.
by apply: le_trans q0 _; move: lt; rewrite (at_mostE R) -ltNge; apply: ltW.
Qed.

Lemma stepsP sn q qs : stairs h l = map Z.of_nat sn ->
  (forall a b, (a <= n)%N -> (b <= m)%N -> first (a, b) (k, k') -> (nth 0%N sn a <= b)%N) ->
  0 <= ratio q -> rise q qs -> all_steps (is_step h l (stairs h l) r (plus level (minus (guard_of level)))) q qs ->
  steps n m first (ratio level) (ratio (guard_of level)) (ratio r) (k, k') (ratio q) [seq ratio q' | q' <- qs].
Proof.
move=> e least; elim: qs q => //= q' qs IH q q0 /andP[lt rise_] /andP[one all_].
have lt' : ratio q < ratio q' by rewrite ltNge -(at_mostE R).
have q'0 := le_trans q0 (ltW lt').
split; first by apply: (stepP e least) => //; rewrite q'0 (rise_le1 rise_).
by split; [exact: ltW | exact: IH].
Qed.
End Ladder.

(* What the program accepts is a ladder of the order that the numbers of draws and the scale decide. *)
Theorem ladder_accepted_sound n m k k' z2 r level knots :
  ladder_accepted (scored (Z.of_nat n) (Z.of_nat k) z2) (scored (Z.of_nat m) (Z.of_nat k') z2) r level knots ->
  exists x qs, 0 < ratio r /\ ladder n m (order n m z2) (ratio level) (ratio (guard_of level)) (ratio r) (k, k') x qs.
Proof.
rewrite /ladder_accepted /is_cell /=.
case/and5P => /and4P[_ /Z.leb_le kn _ rise_n] /and4P[_ /Z.leb_le km _ rise_m] r0 _.
case/andP => level0; case: knots => // q qs /and3P[q0 rise_].
have kn' : (k <= n)%N by lia. have km' : (k' <= m)%N by lia.
rewrite (positive_fractionE R) in r0; rewrite !(nonnegativeE R) in level0 q0.
have /andP[g0 _] := guard_small level0.
have share0 : 0 <= ratio (times (guard_of level) (Qmake 1 4)) by rewrite shareE divr_ge0 ?ler0n.
have im01 x : 0 <= ratio x -> 0 <= ratio (PairLaw.image r x) <= 1 by move=> x0; rewrite imageE image01 // ltW.
have q1 := rise_le1 rise_; have q01 : 0 <= ratio q <= 1 by rewrite q0.
have last1 := last_le1 rise_; rewrite last_is.
have zeroE x : Fractions.at_most x zero -> 0 <= ratio x -> ratio x = 0 by rewrite (at_mostE R) ratio_zero => x0 x0'; apply/eqP; rewrite eq_le x0.
have pastE x : Fractions.at_most one (times r x) -> 1 <= ratio r * ratio x by rewrite (at_mostE R) ratio_one ratio_times.
case: qs rise_ last1 => [|q' qs] rise_ last1 accepted.
  exists (ratio q), [::]; do 2 (split=> //); split=> //; rewrite /apart -imageE -shareE.
  case/orP: accepted => /andP[].
    by move=> below /zeroE e; left; split; [exact: e | apply: rare_belowP below => //; apply: im01].
  move=> past above; right; split; first exact: rare_aboveP above.
  by case/orP: past => [below|/pastE]; [right; apply: rare_belowP below => //; apply: im01 | left].
case/and3P: accepted => start_ stop_ steps_.
have last0 := last_ge0 q0 rise_.
have up_n : scores_rise n z2 := rise_n; have up_m : scores_rise m z2 := rise_m.
have [sn [e least]] := stairsP kn' km' up_n up_m.
exists (ratio q), [seq ratio x | x <- q' :: qs]; do 2 (split=> //); split; first by rewrite last_map.
split.
- rewrite /starts -imageE -shareE; case/or3P: start_ => [/zeroE z|above|above].
  + by constructor 1; apply: z.
  + by constructor 2; apply: rare_aboveP above.
  + by constructor 3; apply: rare_aboveP above => //; apply: im01.
- rewrite /stops last_map -imageE -shareE; case/or4P: stop_ => [/pastE p|below|one_|below].
  + by constructor 1.
  + by constructor 2; apply: rare_belowP below => //; apply: im01.
  + by constructor 3; apply/eqP; rewrite eq_le last1 /=; move: one_; rewrite (at_mostE R) ratio_one.
  + by constructor 4; apply: rare_belowP below => //; rewrite last0.
- exact: (stepsP r0 level0 e least q0 rise_ steps_).
Qed.
End Sound.
