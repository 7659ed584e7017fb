(* How fairaudit draws from a filter: the numerators of a row are added up, `secrets.randbelow` gives a number below their
   sum, and `bisect_right` finds where it falls.  Assumed is that the numbers are uniform and independent; proved is that
   what is released then has exactly the law of the filter's row, for any number of factors. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.

(* ---- One draw ---- *)

(* n_0, n_0 + n_1, ... *)
Definition cumulative (row : seq nat) : seq nat := scanl addn 0 row.

(* What Python says of i = bisect_right(c, r): the numbers before the place i are at most r, those from there on are greater. *)
Definition bisected (c : seq nat) (r i : nat) : Prop :=
  [/\ i <= size c, forall j, j < i -> nth 0 c j <= r & forall j, i <= j < size c -> r < nth 0 c j].

Lemma nth_sums m row j : j < size row -> nth 0 (scanl addn m row) j = m + sumn (take j.+1 row).
Proof.
elim: row m j => [|n s IH] m [|j] //= lt; first by rewrite take0 /= addn0.
by rewrite IH // addnA.
Qed.

Lemma nth_cumulative row j : j < size row -> nth 0 (cumulative row) j = sumn (take j.+1 row).
Proof. by move=> lt; rewrite nth_sums. Qed.

Section Draw.
Variables (row : seq nat) (draw : nat -> nat).
Hypothesis draw_bisects : forall r, bisected (cumulative row) r (draw r).
Local Notation D := (sumn row).

Lemma size_cumulative : size (cumulative row) = size row.
Proof. by rewrite /cumulative size_scanl. Qed.

Lemma sumn_takeS j : j < size row -> sumn (take j.+1 row) = sumn (take j row) + nth 0 row j.
Proof. by move=> lt; rewrite (take_nth 0) // -cats1 sumn_cat /= addn0. Qed.

Lemma sumn_take_le j : sumn (take j row) <= D.
Proof. by rewrite -{2}(cat_take_drop j row) sumn_cat leq_addr. Qed.

(* The place is j exactly for the numbers from n_0 + ... + n_(j-1) up to, and without, n_0 + ... + n_j. *)
Lemma draw_here r j : j < size row -> (draw r == j) = (sumn (take j row) <= r < sumn (take j.+1 row)).
Proof.
move=> lt; have [_ before after] := draw_bisects r; apply/eqP/andP => [e|[lo hi]].
  split; last by rewrite -nth_cumulative // after // e leqnn size_cumulative.
  case: j e lt => [|j] e lt; first by rewrite take0.
  by rewrite -nth_cumulative ?before ?e // ltnW.
apply/eqP; rewrite eqn_leq; apply/andP; split; rewrite leqNgt; apply/negP => h.
  by have := before _ h; rewrite nth_cumulative // leqNgt hi.
case: j lt lo hi h => [|j] // lt lo hi h.
have : r < nth 0 (cumulative row) j by apply: after; rewrite -ltnS h size_cumulative ltnW.
by rewrite nth_cumulative ?(ltnW lt) // ltnNge lo.
Qed.

Lemma draw_inside r : r < D -> draw r < size row.
Proof.
move=> rD; have [le before _] := draw_bisects r; rewrite ltn_neqAle -size_cumulative le andbT size_cumulative.
apply/eqP => e; case: (size row =P 0) => [/size0nil s0|/eqP]; first by move: rD; rewrite s0.
rewrite -lt0n => s0; have := before (size row).-1; rewrite e prednK // leqnn => /(_ isT).
by rewrite nth_cumulative ?prednK // take_size leqNgt rD.
Qed.

Lemma count_between lo hi n : lo <= hi <= n -> #|[set r : 'I_n | lo <= r < hi]| = hi - lo.
Proof.
move=> /andP[lh hn]; rewrite -sum1_card (eq_bigl (fun r : 'I_n => lo <= r < hi)) => [|r]; last by rewrite inE.
rewrite -(big_mkord (fun r => lo <= r < hi) (fun=> 1)) -[RHS]muln1 -sum_nat_const_nat.
rewrite (big_cat_nat _ _ _ (leq0n lo)) ?(leq_trans lh) //= (big_cat_nat _ _ _ lh) //=.
rewrite big1_seq => [|r /andP[/andP[lr _]]]; last by rewrite mem_index_iota /= ltnNge lr.
rewrite [X in _ + (_ + X)]big1_seq => [|r /andP[/andP[_ rh]]]; last by rewrite mem_index_iota leqNgt rh.
rewrite addn0 add0n big_nat_cond [RHS]big_nat_cond; apply: eq_bigl => r.
by rewrite andbT; case: (lo <= r < hi).
Qed.

(* Of the numbers below D, exactly n_j lead to the j-th output. *)
Theorem draws_counted j : #|[set r : 'I_D | draw r == j]| = nth 0 row j.
Proof.
case: (ltnP j (size row)) => [lt|ge].
  rewrite (eq_card (B := [set r : 'I_D | sumn (take j row) <= r < sumn (take j.+1 row)])) => [|r].
    by rewrite count_between ?sumn_takeS ?addKn // leq_addr -sumn_takeS // sumn_take_le.
  by rewrite !inE draw_here.
rewrite nth_default // eq_card0 // => r; rewrite !inE; apply/eqP => e.
by have := draw_inside (ltn_ord r); rewrite e ltnNge ge.
Qed.

End Draw.

(* ---- The law of what is released ---- *)

Section Law.
Variable R : realFieldType.
Local Open Scope ring_scope.

(* The numbers 0, ..., n - 1 with equal probabilities: what randbelow(n) is assumed to give. *)
Definition uniform n (r : 'I_n) : R := n%:R^-1.

(* How an output is found from a row and a number: any program that does what bisect_right is said to do. *)
Variable draw : seq nat -> nat -> nat.
Hypothesis draw_bisects : forall row r, bisected (cumulative row) r (draw row r).

(* The j-th entry of the row, as a probability. *)
Definition entry_of (row : seq nat) (j : nat) : R := (nth 0%N row j)%:R / (sumn row)%:R.

Theorem sampler_one row j : prob (@uniform (sumn row)) [set r : 'I_(sumn row) | draw row r == j] = entry_of row j.
Proof. by rewrite /prob /uniform sumr_const (draws_counted (draw_bisects row)) -[LHS]mulr_natl. Qed.

(* One number for each factor, independent: their law is the product. *)
Fixpoint numbers (rows : seq (seq nat)) : finType :=
  if rows is row :: rest then [finType of 'I_(sumn row) * numbers rest] else [finType of unit].
Fixpoint independent_uniform rows : numbers rows -> R :=
  match rows with
  | row :: rest => fun r => uniform r.1 * @independent_uniform rest r.2
  | [::] => fun=> 1
  end.

(* The word that is released: one output for each factor. *)
Fixpoint word rows : numbers rows -> seq nat :=
  match rows with
  | row :: rest => fun r => draw row r.1 :: @word rest r.2
  | [::] => fun=> [::]
  end.

(* The probability of the word w is the product of the entries of the rows. *)
Fixpoint product_entry (rows : seq (seq nat)) (w : seq nat) : R :=
  match rows, w with
  | row :: rest, j :: w' => entry_of row j * product_entry rest w'
  | [::], [::] => 1
  | _, _ => 0
  end.

Theorem sampler_law rows w : prob (@independent_uniform rows) [set r | word r == w] = product_entry rows w.
Proof.
elim: rows w => [|row rows IH] [|j w] /=; rewrite /prob.
- by rewrite (eq_bigl xpredT) => [|r]; rewrite ?inE // (bigD1 tt) //= big1 ?addr0 // => -[].
- by rewrite big_pred0 // => r; rewrite inE.
- by rewrite big_pred0 // => r; rewrite inE.
rewrite -IH -sampler_one /prob big_distrl /=.
transitivity (\sum_(r : 'I_(sumn row) | draw row r == j) \sum_(r' : numbers rows | word r' == w) uniform r * independent_uniform r').
  rewrite pair_big_dep /=; apply: eq_bigl => r; rewrite inE //.
rewrite [RHS](eq_bigl (fun r : 'I_(sumn row) => draw row r == j)) => [|r]; last by rewrite inE.
apply: eq_bigr => r _; rewrite mulr_sumr; apply: eq_bigl => r'; by rewrite inE.
Qed.

End Law.
