(* The interval of a ratio by the exact pair bound: with what probability it misses.

   Reading key.  Cells, means and the ratio are those of Coverage.v; cells are independent, and every cell is worth something.  [first i j]
   orders the outcomes of the cells i and j.  An upper end r is proved by a ladder for every ordered pair, a lower end 1/q by
   one for some pair; the latter is at a level of its own, of which each of the M ordered pairs has its share. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions Binomial Draws Ends Coverage PairExact.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Interval.
Variables (R : realFieldType) (W I : finType) (B : eqType) (P : W -> R) (count : I -> W -> nat) (n : I -> nat) (p worth : I -> R) (block : I -> B).
Variable first : I -> I -> nat * nat -> nat * nat -> bool.

Local Notation E := (E p worth).
Local Notation compared := (compared block).

(* What was seen of two cells. *)
Definition both i j w : nat * nat := (count i w, count j w).

Definition pair_proves (level guard : R) i j (limit : R) w : Prop :=
  exists x qs, 0 < limit /\ ladder (n i) (n j) (first i j) level guard limit (both i j w) x qs.

Definition pairs_prove_most (level guard r : R) w : Prop :=
  0 <= r /\ forall i j, compared i j -> pair_proves level guard i j (r * worth j / worth i) w.

Definition pairs_prove_least (level guard q : R) w : Prop :=
  exists i j, compared i j /\ pair_proves level guard j i (q * worth i / worth j) w.

Hypotheses (lawP : law P) (p01 : forall i, 0 <= p i <= 1) (worth0 : forall i, 0 < worth i) (drawn : counted P count n p).
Hypothesis independent : independent_counts P count.
Hypothesis total : forall i j o o', first i j o o' || first i j o' o.
Hypothesis transitive_first : forall i j o o' o'', first i j o o' -> first i j o' o'' -> first i j o o''.
Hypothesis staircase : forall i j a a' b b' o, first i j (a, b) o -> (a' <= a)%N -> (b <= b')%N -> first i j (a', b') o.

Lemma prob_both i j a b : i != j -> prob P [set w | both i j w == (a, b)] = successes (n i) (p i) a * successes (n j) (p j) b.
Proof.
move=> ij; pose T k : pred nat := fun c => if k == i then c == a else if k == j then c == b else true.
rewrite (_ : [set w | _] = [set w | [forall k, T k (count k w)]]); last first.
  apply/setP => w; rewrite !inE; apply/eqP/forallP => [[ea eb] k|all_k].
    by rewrite /T; case: eqP => [->|_]; [rewrite /= ea | case: eqP => [->|//]; rewrite /= eb].
  have := all_k i; have := all_k j; rewrite /T eqxx eq_sym (negbTE ij) eqxx => /eqP eb /eqP ea.
  by rewrite /both ea eb.
rewrite (independent T) (bigD1 i) //= (bigD1 j) 1?eq_sym //= big1 => [|k /andP[ki kj]]; last first.
  rewrite (_ : [set w | _] = setT); first by rewrite -(proj2 lawP) /prob; apply: eq_bigl => w; rewrite inE.
  by apply/setP => w; rewrite !inE /T (negbTE ki) (negbTE kj).
rewrite mulr1; congr (_ * _).
  by rewrite -(proj2 (drawn i)) /prob; apply: eq_bigl => w; rewrite !inE /T eqxx.
by rewrite -(proj2 (drawn j)) /prob; apply: eq_bigl => w; rewrite !inE /T eqxx eq_sym (negbTE ij).
Qed.

(* Data for which a ladder proves p_i < limit p_j, although that is not so, have at most the probability of the level. *)
Lemma pair_misses level guard i j (S : {set W}) : i != j -> 0 <= guard -> guard <= level ->
  (forall w, w \in S -> exists limit, limit * p j <= p i /\ pair_proves level guard i j limit w) -> prob P S <= level.
Proof.
move=> ij g0 gl proved.
pose T := [set o : 'I_(n i).+1 * 'I_(n j).+1 | [exists w, (w \in S) && (both i j w == seen o)]].
have le_T : prob P S <= prob (joint (p i) (p j)) T.
  rewrite /prob (partition_big (fun w => (inord (count i w), inord (count j w)) : 'I_(n i).+1 * 'I_(n j).+1) (mem T)) /= => [|w wS]; last first.
    rewrite inE; apply/existsP; exists w; rewrite wS /both /seen /= !inordK ?eqxx // ltnS.
      by case: (drawn j) => le_n _; apply: le_n.
    by case: (drawn i) => le_n _; apply: le_n.
  apply: ler_sum => o oT; rewrite /joint -(prob_both _ _ ij) /prob [leRHS](bigID (mem S)) /=.
  rewrite (eq_bigl (fun w => (w \in [set w | both i j w == seen o]) && (w \in S))) => [|w].
    by rewrite ler_addl; apply: sumr_ge0 => w _; case: lawP.
  rewrite andbC inE; case: (w \in S); rewrite ?andbF // !andbT.
  have [le_i _] := drawn i; have [le_j _] := drawn j.
  apply/eqP/eqP => [<-|[ei ej]]; first by rewrite /both /seen /= !inordK ?ltnS.
  by case: o oT ei ej => a b /= _ -> ->; rewrite !inord_val.
apply: le_trans le_T _.
apply: (pair_exact (total i j) (@transitive_first i j) (@staircase i j) g0 gl (p01 i) (p01 j)) => o; rewrite inE => /existsP[w /andP[wS /eqP e]].
by have [limit [null [x [qs [l0 lad]]]]] := proved w wS; exists limit, x, qs; rewrite -e.
Qed.

Theorem pairs_upper level guard (S : {set W}) : 0 <= guard -> guard <= level ->
  (forall w, w \in S -> exists r, pairs_prove_most level guard r w /\ ~ at_most_ratio p worth block r) -> prob P S <= level.
Proof.
move=> g0 gl missed; have [->|[w0 w0S]] := set_0Vmem S; first by rewrite /prob big_set0 (le_trans g0).
have [i0 [j0 c0]] : exists i j, compared i j.
  have [r [_ wrong]] := missed w0 w0S; case: (boolP [exists ij : I * I, compared ij.1 ij.2]) => [/existsP[[i j] c]|/existsPn none]; first by exists i, j.
  by case: wrong => i j c; have := none (i, j); rewrite /= c.
have worth_ge0 i : 0 <= worth i := ltW (worth0 i).
have [i [j [c worst]]] := worst_pair p01 worth_ge0 c0; have /andP[_ ij] := c.
apply: (@pair_misses level guard i j) => // w /missed[r [[r0 all_ij] wrong]]; exists (r * worth j / worth i); split; last exact: all_ij.
have far : r * E j < E i.
  rewrite ltNge; apply/negP => le_r; apply: wrong => i' j' c'; rewrite leNgt; apply/negP => /(worst r r0 i' j' c').
  by rewrite ltNge le_r.
by rewrite mulrAC ler_pdivr_mulr // [p i * _]mulrC -mulrA; apply: ltW.
Qed.

Theorem pairs_lower level guard (S : {set W}) : 0 <= guard -> guard <= level ->
  (forall w, w \in S -> exists q, pairs_prove_least level guard q w /\ ~ at_least_ratio p worth block q) ->
  prob P S <= #|[set ij : I * I | compared ij.1 ij.2]|%:R * level.
Proof.
move=> g0 gl missed; have l0 := le_trans g0 gl.
have [->|[w0 w0S]] := set_0Vmem S; first by rewrite /prob big_set0 mulr_ge0 ?ler0n.
have [i0 [j0 _]] : exists i j, compared i j by have [q [[i [j [c _]]] _]] := missed w0 w0S; exists i, j.
have [f fP] : exists f : W -> I * I, forall w, w \in S -> compared (f w).1 (f w).2 /\
    exists q, pair_proves level guard (f w).2 (f w).1 (q * worth (f w).1 / worth (f w).2) w /\ ~ at_least_ratio p worth block q.
  apply: (@fin_all_exists W (fun=> (I * I)%type) (fun w ij => w \in S -> compared ij.1 ij.2 /\
    exists q, pair_proves level guard ij.2 ij.1 (q * worth ij.1 / worth ij.2) w /\ ~ at_least_ratio p worth block q)) => w; case: (boolP (w \in S)) => [/missed[q [[i [j [c pr]]] wrong]]|_]; last by exists (i0, j0).
  by exists (i, j) => _; split=> //; exists q.
rewrite /prob (partition_big f (fun ij => compared ij.1 ij.2)) /= => [|w /fP[] //].
apply: (@le_trans _ _ (\sum_(ij : I * I | compared ij.1 ij.2) level)); last first.
  by rewrite sumr_const mulr_natl le_eqVlt; apply/orP; left; apply/eqP; congr (_ *+ _); apply: eq_card => ij; rewrite inE.
apply: ler_sum => -[i j] /= c; have /andP[_ ij] := c.
rewrite (eq_bigl (fun w => w \in [set w in S | f w == (i, j)])) => [|w]; last by rewrite !inE.
apply: (@pair_misses level guard j i) => //; first by rewrite eq_sym.
move=> w; rewrite inE => /andP[wS /eqP e]; have [_ [q]] := fP w wS; rewrite e /= => -[pr wrong].
exists (q * worth i / worth j); split=> //; rewrite mulrAC ler_pdivr_mulr // [p j * _]mulrC -mulrA.
rewrite -/(E i) -/(E j) leNgt; apply/negP => far; apply: wrong; exists i, j; split=> //; first exact: ltW.
have Ej : 0 <= E j by rewrite mulr_ge0 ?(ltW (worth0 j)) //; case/andP: (p01 j).
have Ei : 0 <= E i by rewrite mulr_ge0 ?(ltW (worth0 i)) //; case/andP: (p01 i).
rewrite lt_neqAle Ei andbT eq_sym; apply/eqP => Ei0; have : 0 < q * E i := le_lt_trans Ej far.
by rewrite Ei0 mulr0 ltxx.
Qed.

End Interval.
