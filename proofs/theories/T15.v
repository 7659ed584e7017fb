(* T15, first part: rows whose group was not recorded.

   Reading key.  I is the set of the N rows without a group, v their utilities; an assignment f gives each of them to a receiver: a group that is
   compared, or nobody who is.  A receiver c has n c labelled rows with the sum s c, and gets l c to h c of the others.  "The ratio of a to a' is
   at most V" is mean f a <= V * mean f a'. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From mathcomp.zify Require Import zify.
From Fairaudit Require Import Rows.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- Numbers of rows between limits ---- *)

Section Numbers.
Variables (C : finType) (P : pred C) (l h : C -> nat).

Lemma numbers_between M : (forall c, l c <= h c)%N -> (\sum_(c | P c) l c <= M <= \sum_(c | P c) h c)%N ->
  exists2 m : C -> nat, (forall c, l c <= m c <= h c)%N & (\sum_(c | P c) m c = M)%N.
Proof.
move=> lh /andP[lM]; rewrite -(subnKC lM); elim: (M - _)%N => [|d IH] le.
  by exists l => [c|]; rewrite ?leqnn ?lh ?addn0.
have [|m mlh msum] := IH; first by apply: leq_trans le; rewrite addnS.
have [c /andP[Pc mc]] : exists c, P c && (m c < h c)%N.
  apply/existsP; apply: contraLR le; rewrite negb_exists => /forallP all; rewrite -ltnNge addnS ltnS -msum.
  by apply: leq_sum => c Pc; have := all c; rewrite Pc /= -leqNgt.
exists (fun x => if x == c then (m x).+1 else m x) => [x|].
  have /andP[h1 h2] := mlh x; case: eqP => [->|_]; last by rewrite h1.
  by rewrite mc andbT; apply: leqW; have /andP[] := mlh c.
rewrite (bigD1 c) //= eqxx addSn addnS -msum (bigD1 c (P := P)) //=; congr (_ + _).+1.
by apply: eq_bigr => x /andP[_ /negbTE->].
Qed.

End Numbers.

Section T15.
Variables (R : realFieldType) (I C : finType) (v : I -> R) (s : C -> R) (n l h : C -> nat).
Hypothesis lh : forall c, (l c <= h c)%N.
Implicit Types (f : I -> C) (V : R).
Local Notation N := #|I|.
Local Notation top := (top v setT).
Local Notation bottom := (bottom v setT).

Definition received f c : {set I} := [set i | f i == c].
Definition admissible f : Prop := forall c, (l c <= #|received f c| <= h c)%N.
Definition mean f c : R := (s c + total v (received f c)) / (n c + #|received f c|)%:R.

(* The mean of c with the i best rows, and with the j worst ones. *)
Definition with_best c i : R := (s c + top i) / (n c + i)%:R.
Definition with_worst c j : R := (s c + bottom j) / (n c + j)%:R.

Lemma received_sum f : (\sum_c #|received f c| = N)%N.
Proof.
rewrite -cardsT -sum1_card (partition_big f xpredT) //=; apply: eq_bigr => c _.
by rewrite -sum1_card; apply: eq_bigl => i; rewrite !inE.
Qed.

(* The numbers i, j that a pair may get, so that the others can get the rest. *)
Variables a a' : C.
Hypothesis ne : a != a'.
Local Notation other := (fun c : C => (c != a) && (c != a')).

Definition allowed i j : bool := [&& (l a <= i <= h a)%N, (l a' <= j <= h a')%N,
  (i + j + \sum_(c | other c) l c <= N)%N & (N <= i + j + \sum_(c | other c) h c)%N].

Lemma sum_pair (F : C -> nat) : (\sum_c F c = F a + F a' + \sum_(c | other c) F c)%N.
Proof. by rewrite (bigD1 a) //= (bigD1 a') ?addnA // eq_sym. Qed.

Lemma admissible_allowed f : admissible f -> allowed #|received f a| #|received f a'|.
Proof.
move=> ad; rewrite /allowed !ad /=; have := received_sum f; rewrite sum_pair => e; rewrite -e.
by rewrite !leq_add2l; apply/andP; split; apply: leq_sum => c _; case/andP: (ad c).
Qed.

(* The assignment that gives the best i rows to a, the worst j to a', and the numbers m to the others. *)
Lemma assignment i j : allowed i j -> exists f,
  [/\ admissible f, mean f a = with_best a i & mean f a' = with_worst a' j].
Proof.
case/and4P=> ia ja low high; have ij : (i + j <= N)%N := leq_trans (leq_addr _ _) low.
pose r := ranked v setT; have ur : uniq r := uniq_ranked v setT.
have sr : size r = N by rewrite size_ranked cardsT.
have inr x : x \in r by rewrite mem_ranked inE.
have an : (a' == a) = false by rewrite eq_sym (negbTE ne).
have [m mlh msum] : exists2 m : C -> nat, (forall c, l c <= m c <= h c)%N & (\sum_(c | other c) m c = N - (i + j))%N.
  by apply: numbers_between => //; apply/andP; split; lia.
pose mid := flatten [seq nseq (m c) c | c <- enum (fun c => other c)].
have cmid c : count_mem c mid = (if other c then m c else 0)%N.
  rewrite count_flatten sumnE !big_map big_enum /=; under eq_bigr do rewrite count_nseq /=.
  case: ifP => oc; first rewrite (bigD1 c) //= eqxx mul1n big1 ?addn0 // => x /andP[_ /negbTE-> //].
  by rewrite big1 // => x; rewrite unfold_in => ox; case: eqP => // e; rewrite -e ox in oc.
have smid : size mid = (N - (i + j))%N.
  by rewrite size_flatten sumnE /shape !big_map big_enum /= -msum; apply: eq_bigr => c _; rewrite size_nseq.
pose word := nseq i a ++ (mid ++ nseq j a'); have sw : size word = N by rewrite !size_cat !size_nseq smid; lia.
pose f x := nth a word (index x r).
have cf c : #|received f c| = count_mem c word.
  have -> : word = [seq f x | x <- r].
    apply: (@eq_from_nth _ a) => [|p pw]; first by rewrite size_map sr.
    have pr : (p < size r)%N by rewrite sr -sw.
    have [x0 _] : exists x0, x0 \in r by case: (r) pr => // x0 r' _; exists x0; rewrite mem_head.
    by rewrite (nth_map x0) // /f index_uniq.
  rewrite count_map -size_filter -(card_uniqP (filter_uniq _ ur)); apply: eq_card => x.
  by rewrite !inE mem_filter inr andbT.
have ca : count_mem a word = i by rewrite !count_cat !count_nseq cmid /= !eqxx an /=; lia.
have ca' : count_mem a' word = j by rewrite !count_cat !count_nseq cmid /= !eqxx (negbTE ne) /= andbF; lia.
have amid x c : x \in mid -> ~~ other c -> x != c.
  by move=> xm oc; apply: contraNneq oc => <-; move: xm; rewrite -has_pred1 has_count cmid; case: ifP.
have sum_of (t d : seq I) c : r = t ++ d \/ r = d ++ t -> (forall x, x \in t -> f x = c) -> (forall x, x \in d -> f x != c) ->
    total v (received f c) = \sum_(x <- t) v x.
  move=> split ft fd; have -> : total v (received f c) = \sum_(x <- r | f x == c) v x.
    rewrite -[RHS]big_filter [RHS]big_uniq ?filter_uniq //; apply: eq_bigl => x; by rewrite inE mem_filter inr andbT.
  have eT : \sum_(x <- t | f x == c) v x = \sum_(x <- t) v x.
    by rewrite big_seq_cond [RHS]big_seq; apply: eq_bigl => x; case: (boolP (x \in t)) => //= /ft->; rewrite eqxx.
  have eD : \sum_(x <- d | f x == c) v x = 0.
    by rewrite big_seq_cond big_pred0 // => x; case: (boolP (x \in d)) => //= /fd/negbTE.
  by case: split => ->; rewrite big_cat /= eT eD ?addr0 ?add0r.
exists f; split.
- move=> c; rewrite cf; have [->|ca1] := eqVneq c a; first by rewrite ca.
  have [->|ca2] := eqVneq c a'; first by rewrite ca'.
  rewrite !count_cat !count_nseq cmid /= ca1 ca2 ![_ == c]eq_sym (negbTE ca1) (negbTE ca2) /= addn0.
  exact: mlh.
- rewrite /mean cf ca /with_best (sum_of (take i r) (drop i r)) ?cat_take_drop //; first by left.
    by move=> x xt; rewrite /f nth_cat size_nseq -in_take // xt nth_nseq -in_take // xt.
  move=> x xd; have far : (i <= index x r)%N.
    rewrite leqNgt -in_take //; apply/negP => xt.
    by move: ur; rewrite -(cat_take_drop i r) cat_uniq => /and3P[_ /hasPn/(_ _ xd)]; rewrite /= xt.
  rewrite /f nth_cat size_nseq ltnNge far /=; have : (index x r - i < size (mid ++ nseq j a'))%N.
    by have := inr x; rewrite -index_mem sr -sw [size word]size_cat size_nseq; lia.
  move/(mem_nth a); rewrite mem_cat => /orP[/amid|/nseqP[-> _]]; last by rewrite an.
  by apply; rewrite eqxx.
rewrite /mean cf ca' /with_worst (sum_of (drop (N - j) r) (take (N - j) r)) ?cat_take_drop; last 1 first.
- move=> x xt; have near : (index x r < N - j)%N by rewrite -in_take.
  rewrite /f nth_cat size_nseq; case: ltnP => [lt|ge]; first by rewrite nth_nseq lt.
  rewrite nth_cat smid; case: ltnP => [lt|]; last by lia.
  by apply: amid; rewrite ?mem_nth ?smid // eqxx andbF.
- by rewrite /Rows.bottom cardsT.
- by right.
move=> x xd; have far : (N - j <= index x r)%N.
  rewrite leqNgt -in_take //; apply/negP => xt.
  by move: ur; rewrite -(cat_take_drop (N - j) r) cat_uniq => /and3P[_ /hasPn/(_ _ xd)]; rewrite /= xt.
have lt := inr x; rewrite -index_mem sr in lt.
have [far1 far2] : (i <= index x r /\ N - (i + j) <= index x r - i)%N by clear -far ij lt; lia.
have last : (index x r - i - (N - (i + j)) < j)%N by clear -far ij lt; lia.
by rewrite /f nth_cat size_nseq ltnNge far1 /= nth_cat smid ltnNge far2 /= nth_nseq last.
Qed.

(* Every assignment has a ratio of at most V exactly if every allowed (i, j) has, with the best i rows above and the worst j below. *)
Theorem T15_greatest V : 0 <= V ->
  (forall f, admissible f -> mean f a <= V * mean f a') <-> (forall i j, allowed i j -> with_best a i <= V * with_worst a' j).
Proof.
move=> V0; split=> [all i j /assignment[f [ad <- <-]]|all f ad]; first exact: all.
have sub c : received f c \subset setT by apply: subsetT.
apply: (@le_trans _ _ (with_best a #|received f a|)).
  by apply: ler_wpmul2r; rewrite ?invr_ge0 ?ler0n // ler_add2l top_ge.
apply: le_trans (all _ _ (admissible_allowed ad)) _; apply: ler_wpmul2l => //.
by apply: ler_wpmul2r; rewrite ?invr_ge0 ?ler0n // ler_add2l bottom_le.
Qed.

End T15.

(* ---- The running mean: how many rows make a mean least ---- *)

Section RunningMean.
Variables (R : realFieldType) (N n : nat) (s : R) (t w : nat -> R).
Hypotheses (n0 : (0 < n)%N) (step : forall j, (j < N)%N -> t j.+1 = t j + w j).
Hypothesis rising : forall i j, (i <= j < N)%N -> w i <= w j.

Definition running j : R := (s + t j) / (n + j)%:R.

Lemma running_step j : (j < N)%N -> running j.+1 = (running j * (n + j)%:R + w j) / ((n + j)%:R + 1).
Proof.
move=> jN; rewrite /running divfK ?pnatr_eq0 -?lt0n ?addn_gt0 ?n0 // step // addrA addnS -addn1 natrD.
by [].
Qed.

Lemma running_falls j : (j < N)%N -> w j <= running j -> running j.+1 <= running j.
Proof.
move=> jN le; have pos : 0 < (n + j)%:R + 1 :> R by apply: ltr_paddl; rewrite ?ler0n ?ltr01.
rewrite running_step // ler_pdivr_mulr // mulrDr mulr1.
by rewrite ler_add2l.
Qed.

Lemma running_rises j : (j < N)%N -> running j <= w j -> running j <= running j.+1 <= w j.
Proof.
move=> jN le; have pos : 0 < (n + j)%:R + 1 :> R by apply: ltr_paddl; rewrite ?ler0n ?ltr01.
rewrite running_step // ler_pdivl_mulr // ler_pdivr_mulr // !mulrDr !mulr1 ler_add2l le /= ler_add2r.
by apply: ler_wpmul2r; rewrite ?ler0n.
Qed.

(* The mean falls while the next value lies below it, and does not fall any more after that; so the number of the limits [lo, hi] that is nearest
   to the turn gives the least mean. *)
Theorem T15_running_mean turn lo hi : (turn <= N)%N -> (lo <= hi <= N)%N -> (forall i, (i < turn)%N -> w i <= running i) ->
  ((turn < N)%N -> running turn <= w turn) -> forall j, (lo <= j <= hi)%N -> running (minn hi (maxn lo turn)) <= running j.
Proof.
move=> tN /andP[lh hN] before after; have fall j k : (j <= k <= turn)%N -> running k <= running j.
  case/andP; elim: k => [|k IH]; first by rewrite leqn0 => /eqP->.
  rewrite leq_eqVlt => /orP[/eqP-> //|]; rewrite ltnS => jk kt; apply: le_trans (IH jk (ltnW kt)).
  by apply: running_falls; [apply: leq_trans tN|apply: before].
have above k : (turn <= k < N)%N -> running k <= w k.
  case/andP; elim: k => [|k IH].
    by rewrite leqn0 => /eqP e N0; rewrite -e; apply: after; rewrite e.
  rewrite leq_eqVlt => /orP[/eqP<- //|]; rewrite ltnS => tk kN.
  have /andP[_ le] := running_rises (ltnW kN) (IH tk (ltnW kN)).
  by apply: le_trans le _; apply: rising; rewrite leqnSn.
have rise j k : (turn <= j <= k)%N -> (k <= N)%N -> running j <= running k.
  case/andP=> tj; elim: k => [|k IH]; first by rewrite leqn0 => /eqP->.
  rewrite leq_eqVlt => /orP[/eqP-> //|]; rewrite ltnS => jk kN; apply: le_trans (IH jk (ltnW kN)) _.
  by case/andP: (running_rises kN (above k (introT andP (conj (leq_trans tj jk) kN)))).
move=> j /andP[lj jh]; have [h|h] := leqP hi (maxn lo turn).
  case: (leqP lo turn) h => lt h; last by have -> : hi = j by lia.
  by apply: fall; rewrite jh.
case: (leqP lo turn) h => lt h; last by apply: rise; rewrite ?(ltnW lt) // (leq_trans jh).
have [jt|tj] := leqP j turn; first by apply: fall; rewrite jt leqnn.
by apply: rise; rewrite ?leqnn ?(ltnW tj) // (leq_trans jh).
Qed.

End RunningMean.

(* The worst rows are such values, and so are the best ones with the sign changed. *)
Section Turn.
Variables (R : realFieldType) (I C : finType) (v : I -> R) (s : C -> R) (n : C -> nat) (c : C).
Hypothesis n0 : (0 < n c)%N.
Local Notation N := #|I|.
Local Notation best := (ranked_value v setT).
Local Notation worst i := (ranked_value v setT (N - i.+1)).
Local Notation below := (with_worst v s n c).
Local Notation above := (with_best v s n c).

Theorem T15_least_mean turn lo hi : (turn <= N)%N -> (lo <= hi <= N)%N -> (forall i, (i < turn)%N -> worst i <= below i) ->
  ((turn < N)%N -> below turn <= worst turn) -> forall j, (lo <= j <= hi)%N -> below (minn hi (maxn lo turn)) <= below j.
Proof.
apply: (T15_running_mean (t := bottom v setT) (w := fun i => worst i)) => // [j|i j /andP[ij jN]].
  by rewrite -cardsT => jN; apply: bottomS.
by apply: ranked_le; rewrite cardsT; lia.
Qed.

Theorem T15_greatest_mean turn lo hi : (turn <= N)%N -> (lo <= hi <= N)%N -> (forall i, (i < turn)%N -> above i <= best i) ->
  ((turn < N)%N -> best turn <= above turn) -> forall j, (lo <= j <= hi)%N -> above j <= above (minn hi (maxn lo turn)).
Proof.
move=> tN lh before after j jlh; have e i : running (n c) (- s c) (fun k => - top v setT k) i = - above i.
  by rewrite /running /with_best -opprD mulNr.
rewrite -ler_opp2 -!e.
apply: (T15_running_mean (N := N) (w := fun i => - best i)) jlh => // [k|i k ik|i it|tlt].
- by rewrite -cardsT => kN; rewrite topS // opprD.
- by rewrite ler_opp2; apply: ranked_le; rewrite cardsT.
- by rewrite e ler_opp2; apply: before.
by rewrite e ler_opp2; apply: after.
Qed.

End Turn.
