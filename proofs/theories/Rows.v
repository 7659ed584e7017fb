(* Rows with a utility each: the sum of the j best and of the j worst rows of a set.

   Reading key.  [ranked S] lists the rows of S, the best first; [top S j] is the sum of its first j utilities, [bottom S j] that of its last j.
   How ties are ranked does not matter. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Rows.
Variables (R : realFieldType) (I : finType) (g : I -> R).
Implicit Types (S : {set I}) (j : nat) (theta : R).

Definition total S : R := \sum_(i in S) g i.
Definition mean S : R := total S / #|S|%:R.

Definition ranked S : seq I := sort (fun i k => g k <= g i) (enum S).
Definition top S j : R := \sum_(i <- take j (ranked S)) g i.
Definition bottom S j : R := \sum_(i <- drop (#|S| - j) (ranked S)) g i.

(* The utility of the row ranked j + 1. *)
Definition ranked_value S j : R := nth 0 [seq g i | i <- ranked S] j.

Lemma size_ranked S : size (ranked S) = #|S|.
Proof. by rewrite size_sort -cardE. Qed.

Lemma uniq_ranked S : uniq (ranked S).
Proof. by rewrite sort_uniq enum_uniq. Qed.

Lemma mem_ranked S i : (i \in ranked S) = (i \in S).
Proof. by rewrite mem_sort mem_enum. Qed.

Lemma sum_ranked S (F : I -> R) : \sum_(i <- ranked S) F i = \sum_(i in S) F i.
Proof. by rewrite -big_enum /=; apply: perm_big; rewrite perm_sort. Qed.

Lemma ranked_le S j k : (j <= k < #|S|)%N -> ranked_value S k <= ranked_value S j.
Proof.
move=> /andP[jk kS]; have tr : transitive (fun x y : R => y <= x) by move=> x y z /= h h'; apply: le_trans h.
have so : sorted (fun x y : R => y <= x) [seq g i | i <- ranked S].
  by rewrite sorted_map; apply: sort_sorted => i i'; apply: le_total.
apply: (sorted_leq_nth tr _ 0 so) => //; rewrite ?inE ?size_map ?size_ranked //.
exact: leq_ltn_trans jk kS.
Qed.

Lemma ranked_value_index S i : i \in S -> ranked_value S (index i (ranked S)) = g i.
Proof. by move=> iS; rewrite /ranked_value (nth_map i) ?nth_index ?index_mem ?mem_ranked. Qed.

Lemma ranked_value_in S j : (j < #|S|)%N -> exists2 i, i \in S & ranked_value S j = g i.
Proof.
move=> jS; have [i _] : exists i, i \in S by apply/card_gt0P; apply: leq_ltn_trans jS.
exists (nth i (ranked S) j); first by rewrite -mem_ranked mem_nth ?size_ranked.
by rewrite /ranked_value (nth_map i) ?size_ranked.
Qed.

Lemma topS S j : (j < #|S|)%N -> top S j.+1 = top S j + ranked_value S j.
Proof.
move=> jS; have [i _] : exists i, i \in S by apply/card_gt0P; apply: leq_ltn_trans jS.
rewrite /top (take_nth i) ?size_ranked // -cats1 big_cat big_seq1 /ranked_value (nth_map i) ?size_ranked //.
Qed.

Lemma top0 S : top S 0 = 0.
Proof. by rewrite /top take0 big_nil. Qed.

Lemma top_bottom S j : (j <= #|S|)%N -> top S (#|S| - j) + bottom S j = total S.
Proof. by move=> jS; rewrite /top /bottom -big_cat cat_take_drop sum_ranked. Qed.

Lemma bottomE S j : (j <= #|S|)%N -> bottom S j = total S - top S (#|S| - j).
Proof. by move=> jS; rewrite -(top_bottom jS) addrC addKr. Qed.

Lemma bottomS S j : (j < #|S|)%N -> bottom S j.+1 = bottom S j + ranked_value S (#|S| - j.+1).
Proof.
move=> jS; rewrite !bottomE ?(ltnW jS) // -(subnSK jS) topS; last by rewrite subnSK ?leq_subr.
by ring.
Qed.

(* A bound by one threshold theta, whatever it is. *)
Lemma threshold S (S' : {set I}) theta : S' \subset S -> total S' <= theta * #|S'|%:R + \sum_(i in S) Num.max 0 (g i - theta).
Proof.
move=> sub; rewrite -ler_subl_addl (_ : total S' - _ = \sum_(i in S') (g i - theta)); last first.
  by rewrite sumrB sumr_const mulr_natr.
apply: (@le_trans _ _ (\sum_(i in S') Num.max 0 (g i - theta))).
  by apply: ler_sum => i _; rewrite le_maxr lexx orbT.
rewrite [leRHS](big_setID S') /= (setIidPr sub) ler_addl; apply: sumr_ge0 => i _.
by rewrite le_maxr lexx.
Qed.

(* The utility of the j-th row is a threshold that gives the sum of the best exactly. *)
Lemma top_threshold S j : (j <= #|S|)%N ->
  top S j = ranked_value S j.-1 * j%:R + \sum_(i in S) Num.max 0 (g i - ranked_value S j.-1).
Proof.
move=> jS; set theta := ranked_value S j.-1; rewrite -sum_ranked -[in X in _ + X](cat_take_drop j (ranked S)) big_cat /=.
rewrite [X in _ + (_ + X)]big_seq [X in _ + (_ + X)]big1 => [|i iD]; last first.
  have iS : i \in S by rewrite -mem_ranked; apply: mem_drop iD.
  have far : (j <= index i (ranked S))%N.
    rewrite leqNgt; apply/negP; rewrite -in_take ?mem_ranked // => iT.
    by have := uniq_ranked S; rewrite -(cat_take_drop j (ranked S)) cat_uniq => /and3P[_ /hasPn/(_ _ iD)]; rewrite /= iT.
  apply/max_idPl; rewrite subr_le0 -(ranked_value_index iS); apply: ranked_le.
  by rewrite (leq_trans (leq_pred j) far) -size_ranked index_mem mem_ranked.
rewrite addr0 [X in _ + X](_ : _ = \sum_(i <- take j (ranked S)) (g i - theta)); last first.
  rewrite !big_seq; apply: eq_bigr => i iT; have iS : i \in S by rewrite -mem_ranked; apply: mem_take iT.
  apply/max_idPr; rewrite subr_ge0 -(ranked_value_index iS); apply: ranked_le.
  have near : (index i (ranked S) < j)%N by rewrite -in_take ?mem_ranked.
  by case: j jS near {theta iT} => // j jS near /=; rewrite -ltnS near.
rewrite sumrB -/(top S j) big_const_seq count_predT iter_addr_0 size_takel ?size_ranked // -mulr_natr.
by ring.
Qed.

(* Any j rows have at most the sum of the j best, and at least that of the j worst; both are attained. *)
Lemma top_ge S (S' : {set I}) : S' \subset S -> total S' <= top S #|S'|.
Proof. by move=> sub; rewrite top_threshold ?subset_leq_card //; apply: threshold. Qed.

Lemma bottom_le S (S' : {set I}) : S' \subset S -> bottom S #|S'| <= total S'.
Proof.
move=> sub; rewrite bottomE ?subset_leq_card // ler_subl_addr.
have -> : (#|S| - #|S'|)%N = #|S :\: S'| by rewrite cardsD (setIidPr sub).
rewrite {1}/total (big_setID S') /= (setIidPr sub) ler_add2l.
by apply: top_ge; apply: subsetDl.
Qed.

Lemma rows_of_seq S (s : seq I) : uniq s -> {subset s <= S} ->
  [/\ [set i in s] \subset S, #|[set i in s]| = size s & total [set i in s] = \sum_(i <- s) g i].
Proof.
move=> us sub; split; first by apply/subsetP => i; rewrite inE; apply: sub.
  by rewrite cardsE; apply/card_uniqP.
by rewrite /total big_uniq //=; apply: eq_bigl => i; rewrite inE.
Qed.

Theorem rows_extremes S j : (j <= #|S|)%N ->
  [/\ forall S', S' \subset S -> #|S'| = j -> bottom S j <= total S' <= top S j,
      exists S', [/\ S' \subset S, #|S'| = j & total S' = top S j] &
      exists S', [/\ S' \subset S, #|S'| = j & total S' = bottom S j]].
Proof.
move=> jS; split=> [S' sub <-||]; first by rewrite bottom_le ?top_ge.
- have [|i /mem_take|sub card e] := @rows_of_seq S (take j (ranked S)); rewrite ?take_uniq ?uniq_ranked ?mem_ranked //.
  by exists [set i in take j (ranked S)]; split=> //; rewrite card size_takel ?size_ranked.
have [|i /mem_drop|sub card e] := @rows_of_seq S (drop (#|S| - j) (ranked S)); rewrite ?drop_uniq ?uniq_ranked ?mem_ranked //.
by exists [set i in drop (#|S| - j) (ranked S)]; split=> //; rewrite card size_drop size_ranked subKn.
Qed.

End Rows.
