(* Sums, ranges and runs: the programs on lists that figures are computed with. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Figures.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- Ranges ---- *)

Lemma rangeE n : range n = [seq Z.of_nat i | i <- iota 0 (Z.to_nat n)].
Proof. by rewrite /range; congr map; elim: (Z.to_nat n) 0%N => //= k IH m; rewrite IH. Qed.

Lemma mem_range n i : (i \in range n) = inside n i.
Proof.
rewrite rangeE /inside; apply/mapP/andP => [[k]|[/Z.leb_le low /Z.ltb_lt high]].
  by rewrite mem_iota /= add0n => /ssrnat.ltP kn ->; split; [apply/Z.leb_le | apply/Z.ltb_lt]; lia.
by exists (Z.to_nat i); [rewrite mem_iota /= add0n; apply/ssrnat.ltP | rewrite Z2Nat.id]; lia.
Qed.

Lemma range_uniq n : uniq (range n).
Proof. by rewrite rangeE map_inj_uniq ?iota_uniq // => i j /Nat2Z.inj. Qed.

Lemma size_range n : size (range n) = Z.to_nat n.
Proof. by rewrite rangeE size_map size_iota. Qed.

Lemma range_sorted n : sorted Z.ltb (range n).
Proof.
rewrite rangeE sorted_map; apply: sub_sorted (iota_ltn_sorted _ _) => i j /ssrnat.ltP ij /=.
by apply/Z.ltb_lt; lia.
Qed.

Lemma of_lengthP A n (xs : list A) : of_length n xs -> Z.le Z0 n /\ size xs = Z.to_nat n.
Proof.
rewrite /of_length -/(size xs) => /Z.eqb_eq <-; split; first exact: Nat2Z.is_nonneg.
by rewrite Nat2Z.id.
Qed.

(* ---- The numbers of a list ---- *)

Lemma nthE A (d : A) xs i : List.nth i xs d = nth d xs i.
Proof. by elim: xs i => [|x xs IH] [|i] //=. Qed.

Lemma in_of_nth A (d : A) xs i : (i < size xs)%N -> List.In (nth d xs i) xs.
Proof. by elim: xs i => [|x xs IH] [|i] //= ilt; [left | right; apply: IH]. Qed.

Lemma nth_of_in A (d : A) xs x : List.In x xs -> exists2 i, (i < size xs)%N & nth d xs i = x.
Proof. by elim: xs => //= y xs IH [<-|/IH[i ilt <-]]; [exists 0%N | exists i.+1]. Qed.

Lemma in_filter_seq A (P : pred A) xs x : List.In x (filter P xs) <-> List.In x xs /\ P x.
Proof.
elim: xs => [|y xs IH] /=; first by split=> // -[].
case: ifP => Py /=; split.
- by case=> [<-|/IH[]]; [split=> //; left | split=> //; right].
- by case=> [[->|xin] Px]; [left | right; apply/IH].
- by case/IH; split=> //; right.
- by case=> [[yx|xin] Px]; [rewrite yx Px in Py | apply/IH].
Qed.

Lemma in_all A (P : pred A) s : (forall x, List.In x s -> P x) -> all P s.
Proof. by elim: s => //= x s IH all_; rewrite all_ ?IH //; [move=> y yin; apply: all_; right | left]. Qed.

Lemma flat_sorted A B (f : A -> list B) (before : rel B) (lt : rel A) s : transitive before -> transitive lt -> sorted lt s ->
  (forall k, List.In k s -> sorted before (f k)) ->
  (forall k l b c, List.In k s -> List.In l s -> lt k l -> List.In b (f k) -> List.In c (f l) -> before b c) ->
  sorted before (flat_map f s).
Proof.
move=> tr lt_trans; elim: s => //= k s IH srt each across.
rewrite sorted_pairwise // pairwise_cat -!sorted_pairwise // each ?IH; last 4 first.
- exact: path_sorted srt.
- by move=> l lin; apply: each; right.
- by move=> l m b c lin min; apply: across; right.
- by left.
rewrite !andbT; have := order_path_min lt_trans srt => later.
have {}later l : List.In l s -> lt k l by elim: (s) later => //= m s' IH' /andP[km all_] [<-|/(IH' all_)].
apply: in_all => b bin; apply: in_all => c /in_flat_map[l [lin cin]].
by apply: across (later _ lin) bin cin; [left | right].
Qed.

Section Sums.
Variable R : realFieldType.
Local Notation ratio := (@ratio R).

Lemma ratio_sums_of_two qs : \sum_(q <- sums_of_two qs) ratio q = \sum_(q <- qs) ratio q.
Proof.
have [n] := ubnP (size qs); elim: n qs => // n IH [|q [|r rest]] //= lt.
by rewrite !big_cons IH ?ratio_plus ?addrA //; apply: leq_trans (leqnSn _) _; rewrite ltnS in lt.
Qed.

Lemma ratio_halved n qs : \sum_(q <- halved n qs) ratio q = \sum_(q <- qs) ratio q.
Proof. by elim: n qs => [|n IH] [|q [|r rest]] //; rewrite -[halved _ _]/(halved n (sums_of_two (q :: r :: rest))) IH ratio_sums_of_two. Qed.

Lemma ratio_sum qs : ratio (sum qs) = \sum_(q <- qs) ratio q.
Proof. by rewrite /sum ratio_total ratio_halved. Qed.

(* the u-th number of a list, as in Meaning.v *)
Definition number (u : Z) (qs : list Q) : R := ratio (List.nth (Z.to_nat u) qs zero).

Lemma sum_range_nat n (F : nat -> R) : \sum_(u <- range n) F (Z.to_nat u) = \sum_(0 <= i < Z.to_nat n) F i.
Proof. by rewrite rangeE big_map /index_iota subn0; apply: eq_bigr => i _; rewrite Nat2Z.id. Qed.

Lemma sum_number n qs : of_length n qs -> \sum_(u <- range n) number u qs = \sum_(q <- qs) ratio q.
Proof.
move=> /of_lengthP[_ e]; rewrite (sum_range_nat n (fun i => ratio (List.nth i qs zero))) -e [RHS](big_nth zero).
by apply: eq_bigr => i _; rewrite nthE.
Qed.

Lemma sum_number_product n ps qs : of_length n ps -> of_length n qs ->
  \sum_(u <- range n) number u ps * number u qs = ratio (total (map (fun pq => times pq.1 pq.2) (combine ps qs))).
Proof.
move=> /of_lengthP[_ e] /of_lengthP[_ e'].
rewrite (sum_range_nat n (fun i => ratio (List.nth i ps zero) * ratio (List.nth i qs zero))) -e ratio_total big_map.
have : size ps = size qs by rewrite e e'.
elim: ps qs {e e'} => [|p ps IH] [|q qs] //= => [_|[e]]; first by rewrite !big_nil.
by rewrite big_cons big_nat_recl //= ratio_times -IH.
Qed.

Lemma number_times m u qs : number u (map (times m) qs) = ratio m * number u qs.
Proof.
rewrite /number; elim: qs (Z.to_nat u) => [|q qs IH] [|i] //=; rewrite ?ratio_zero ?mulr0 // ratio_times //.
Qed.

Lemma number_column_sums n rows u : inside n u ->
  number u (column_sums (Z.to_nat n) rows) = \sum_(r <- rows) number u r.
Proof.
case/andP=> /Z.leb_le low /Z.ltb_lt high; rewrite /number.
have : (Z.to_nat u < Z.to_nat n)%N by apply/ssrnat.ltP; lia.
move: (Z.to_nat u) (Z.to_nat n) => i k; elim: k i rows => // k IH [|i] rows /= lt.
  by rewrite ratio_sum big_map; apply: eq_bigr => r _; case: r.
by rewrite IH // big_map; apply: eq_bigr => r _; case: r => //=; case: (i).
Qed.

Lemma size_column_sums n rows : size (column_sums n rows) = n.
Proof. by elim: n rows => //= n IH rows; rewrite IH. Qed.
End Sums.

(* ---- Runs ---- *)

Section Runs.
Variables (A : Type) (key : A -> Z).

Definition with_key (k : Z) (xs : list A) : list A := [seq x <- xs | Z.eqb (key x) k].
Definition run_before (k l : Z * list A) : bool := Z.ltb k.1 l.1.

Lemma run_before_trans : transitive run_before.
Proof. by move=> k l m /Z.ltb_lt kl /Z.ltb_lt lm; apply/Z.ltb_lt; apply: Z.lt_trans lm. Qed.

Lemma flat_runs xs : flat_map snd (runs key xs) = xs.
Proof.
elim: xs => //= x xs; case: (runs key xs) => [|[k ys] more] //= e; first by rewrite -e.
by case: ifP => _ /=; rewrite -e.
Qed.

Lemma runs_head x xs : exists ys more, runs key (x :: xs) = (key x, x :: ys) :: more.
Proof.
rewrite /=; case: (runs key xs) => [|[k ys] more]; first by exists [::], [::].
by case: ifP => [/Z.eqb_eq ->|_]; [exists ys, more | exists [::], ((k, ys) :: more)].
Qed.

Lemma runsP xs : sorted (not_after key) xs ->
  sorted run_before (runs key xs) /\ forall k ys, List.In (k, ys) (runs key xs) -> ys = with_key k xs /\ ys <> [::].
Proof.
elim: xs => [|x xs IH] srt; first by split=> // k ys [].
have {IH} [IHs IHk] := IH (path_sorted srt).
case: xs srt IHs IHk => [|y xs] srt IHs IHk /=.
  split=> // k ys [[<- <-]|[]]; split=> //; by rewrite /with_key /= Z.eqb_refl.
have xy : Z.le (key x) (key y) by move: srt => /= /andP[/Z.leb_le].
have [ys [more e]] := runs_head y xs; rewrite -/(runs key (y :: xs)) e in IHs IHk *.
have later k zs : List.In (k, zs) more -> Z.lt (key y) k.
  have := order_path_min run_before_trans IHs; elim: (more) => //= l ls IH /andP[/Z.ltb_lt yl all_] [e'|]; [by rewrite e' in yl | exact: IH].
case: ifP => [/Z.eqb_eq e1 | /Z.eqb_neq ne].
  split=> [|k zs [[<- <-]|kin]]; first by move: IHs; case: (more) => //= l ls; rewrite /run_before /= e1.
    by split=> //; have [-> _] := IHk _ _ (or_introl erefl); rewrite /with_key /= e1 !Z.eqb_refl.
  have [-> nonempty] := IHk _ _ (or_intror kin); split=> //; rewrite /with_key [in RHS]/=.
  by have := later _ _ kin; case: Z.eqb_spec => // xk; lia.
split=> [|k zs [[<- <-]|kin]]; first by move: IHs => /= ->; rewrite andbT; apply/Z.ltb_lt => /=; lia.
  split=> //; rewrite Z.eqb_refl; case: Z.eqb_spec => [yx|_]; first by case: ne.
  rewrite /with_key; suff -> : [seq z <- xs | Z.eqb (key z) (key x)] = [::] by [].
  have le_trans : transitive (not_after key) by move=> a b c /Z.leb_le ab /Z.leb_le bc; apply/Z.leb_le; apply: Z.le_trans bc.
  have /= /andP[_ /(order_path_min le_trans)] := srt.
  elim: (xs) => //= z zs' IH /andP[/Z.leb_le yz /IH ->].
  by case: Z.eqb_spec => // zx; lia.
have [-> nonempty] := IHk _ _ kin; split=> //; rewrite /with_key [in RHS]/=.
suff : Z.lt (key x) k by case: Z.eqb_spec => // xk; lia.
case: kin => [[<- _]|/later]; last by lia.
by lia.
Qed.

Lemma runs_have xs x : List.In x xs -> exists ys, List.In (key x, ys) (runs key xs).
Proof.
elim: xs => //= y xs IH [->|/IH[ys]]; first by have [ys [more /= ->]] := runs_head x xs; exists (x :: ys); left.
case: (runs key xs) => [|[k zs] more] //= [[<- _]|kin]; case: ifP => [/Z.eqb_eq e|_].
- by exists (y :: zs); left.
- by exists zs; right; left.
- by exists ys; right.
- by exists ys; right; right.
Qed.

Lemma not_after_total : ssrbool.total (not_after key).
Proof. by move=> x y; apply/orP; rewrite /not_after; case: (Z.leb_spec (key x) (key y)) => h; [left | right; apply/Z.leb_le; lia]. Qed.

Lemma not_after_trans : transitive (not_after key).
Proof. by move=> a b c /Z.leb_le ab /Z.leb_le bc; apply/Z.leb_le; apply: Z.le_trans bc. Qed.

Lemma with_key_sort k xs : with_key k (sort (not_after key) xs) = with_key k xs.
Proof.
rewrite /with_key filter_sort; [|exact: not_after_total|exact: not_after_trans].
apply: sorted_sort; first exact: not_after_trans.
have : all (fun x => Z.eqb (key x) k) [seq x <- xs | Z.eqb (key x) k] by apply: filter_all.
case: [seq _ <- _ | _] => //= x ys /andP[/Z.eqb_eq xk]; elim: ys x xk => //= y ys IH x xk /andP[/Z.eqb_eq yk all_].
by rewrite IH // /not_after xk yk Z.leb_refl.
Qed.

Lemma groupedP xs :
  sorted run_before (grouped key xs) /\ forall k ys, List.In (k, ys) (grouped key xs) -> ys = with_key k xs /\ ys <> [::].
Proof.
have [srt have_] := runsP (sort_sorted not_after_total xs); split=> // k ys /have_[-> nonempty].
by rewrite with_key_sort in nonempty *.
Qed.

Lemma grouped_have xs k : with_key k xs <> [::] -> List.In (k, with_key k xs) (grouped key xs).
Proof.
rewrite -with_key_sort => nonempty.
have [x xin xk] : exists2 x, List.In x (sort (not_after key) xs) & key x = k.
  move: nonempty; rewrite /with_key; elim: (sort _ _) => //= x ys IH.
  by case: ifP => [/Z.eqb_eq e _|_ /IH[z]]; [exists x; [left|] | exists z; [right|]].
have [ys yin] := runs_have xin; rewrite xk in yin.
by have [ye _] := (proj2 (groupedP xs)) _ _ yin; rewrite with_key_sort -ye.
Qed.
End Runs.
