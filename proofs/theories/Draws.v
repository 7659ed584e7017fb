(* Independent draws in cells, and how many of them are worth something.

   Reading key.  D is the set of the draws, [cell d] the cell that draw d is from, and Q i the law of a draw in cell i:
   of the decision u, or of what else is drawn.  [good i u] says that u is worth something in cell i.  The data are
   all that was drawn, w.  [drawn] is the law of the data when all draws are independent; [within P i] says of any law P of
   the data that the draws of cell i are independent, each with the law Q i, whatever holds between cells. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions Binomial.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Draws.
Variables (R : realFieldType) (D I U : finType) (cell : D -> I) (Q : I -> U -> R) (good : I -> pred U).
Implicit Types (P : {ffun D -> U} -> R) (w : {ffun D -> U}) (i : I) (B W : {set D}).

(* How many draws a cell has, how many of them are good, and the probability that one is. *)
Definition draws i : nat := #|[set d | cell d == i]|.
Definition count i w : nat := #|[set d | (cell d == i) && good i (w d)]|.
Definition chance i : R := \sum_(u | good i u) Q i u.

Definition drawn w : R := \prod_d Q (cell d) (w d).

Definition within P i : Prop := forall T : D -> pred U,
  prob P [set w : {ffun D -> U} | [forall d, (cell d == i) ==> T d (w d)]] = \prod_(d | cell d == i) \sum_(u | T d u) Q i u.

Hypothesis laws : kernel Q.

Lemma chance01 i : 0 <= chance i <= 1.
Proof.
have [Q0 Q1] := laws i; rewrite sumr_ge0 //= -Q1 [leRHS](bigID (good i)) /= ler_addl.
exact: sumr_ge0.
Qed.

Lemma bad i : \sum_(u | ~~ good i u) Q i u = 1 - chance i.
Proof. by rewrite -(proj2 (laws i)) [X in X - _](bigID (good i)) /= addrC addKr. Qed.

Lemma count_le i w : (count i w <= draws i)%N.
Proof. by apply/subset_leq_card/subsetP => d; rewrite !inE => /andP[]. Qed.

(* The chance that the draws of a cell that are good are just those in B. *)
Definition chance_of i B : R := \prod_(d | cell d == i) (if d \in B then chance i else 1 - chance i).

Lemma chance_ofE i B : B \subset [set d | cell d == i] -> chance_of i B = chance i ^+ #|B| * (1 - chance i) ^+ (draws i - #|B|).
Proof.
move=> sub; rewrite /chance_of (bigID (mem B)) /=; congr (_ * _).
  rewrite (eq_big (mem B) (fun=> chance i)) ?prodr_const // => [d|d /andP[_ ->]] //.
  by apply: andb_idl => /(subsetP sub); rewrite inE.
have -> : (draws i - #|B| = #|[set d | cell d == i] :\: B|)%N by rewrite cardsD (setIidPr sub).
rewrite -prodr_const; apply: eq_big => [d|d /andP[_ /negbTE->]] //.
by rewrite !inE andbC.
Qed.

Lemma sum_good i d B : \sum_(u | good i u == (d \in B)) Q i u = if d \in B then chance i else 1 - chance i.
Proof. by case: ifP => _; rewrite -?bad; apply: eq_bigl => u; [rewrite eqb_id|rewrite eqbF_neg]. Qed.

Lemma prob_count P i (S : pred nat) : within P i ->
  prob P [set w | S (count i w)] = \sum_(B : {set D} | (B \subset [set d | cell d == i]) && S #|B|) chance_of i B.
Proof.
move=> ind; rewrite /prob (partition_big (fun w => [set d | (cell d == i) && good i (w d)])
  (fun B => (B \subset [set d | cell d == i]) && S #|B|)) /= => [|w]; last first.
  by rewrite inE /count => ->; rewrite andbT; apply/subsetP => d; rewrite !inE => /andP[].
apply: eq_bigr => B /andP[sub SB].
transitivity (prob P [set w : {ffun D -> U} | [forall d, (cell d == i) ==> (good i (w d) == (d \in B))]]).
  rewrite /prob; apply: eq_bigl => w; rewrite !inE; apply/andP/forallP => [[_ /eqP<-] d|all_d].
    by rewrite inE; case: (cell d == i) => //=; rewrite eqxx.
  have eB : [set d | (cell d == i) && good i (w d)] = B.
    apply/setP => d; rewrite inE; have := all_d d; case: (boolP (cell d == i)) => //= [_ /eqP->//|out _].
    by apply/esym/negbTE; apply: contra out => /(subsetP sub); rewrite inE.
  by rewrite /count eB SB !eqxx.
by rewrite (ind (fun d u => good i u == (d \in B))); apply: eq_bigr => d _; exact: sum_good.
Qed.

(* Of independent draws in a cell the number of good ones is binomial. *)
Theorem count_binomial P i (j : nat) : within P i -> prob P [set w | count i w == j] = successes (draws i) (chance i) j.
Proof.
move=> /(@prob_count P i (pred1 j)) -> /=.
rewrite (eq_bigr (fun=> chance i ^+ j * (1 - chance i) ^+ (draws i - j))) => [|B /andP[sub /eqP<-]]; last exact: chance_ofE.
rewrite sumr_const /successes /draws -cards_draws -mulrA mulr_natl; congr (_ *+ _).
by apply: eq_card => B; rewrite !inE.
Qed.

(* ---- All draws independent ---- *)

Lemma prob_drawn (T : D -> pred U) : prob drawn [set w : {ffun D -> U} | [forall d, T d (w d)]] = \prod_d \sum_(u | T d u) Q (cell d) u.
Proof.
rewrite bigA_distr_big_dep; apply: eq_big => // w.
by rewrite inE; apply/forallP/familyP.
Qed.

Lemma law_drawn : law drawn.
Proof.
split=> [w|]; first by apply: prodr_ge0 => d _; case: (laws (cell d)).
have e1 : \prod_d (\sum_u Q (cell d) u) = 1 by apply: big1 => d _; case: (laws (cell d)).
have := prob_drawn (fun _ => xpredT); rewrite e1 /prob => <-.
by apply: eq_bigl => w; rewrite inE; apply/esym/forallP.
Qed.

Theorem within_drawn i : within drawn i.
Proof.
move=> T; rewrite (_ : [set w | _] = [set w : {ffun D -> U} | [forall d, ((cell d != i) || T d (w d))]]); last first.
  by apply/setP => w; rewrite !inE; apply: eq_forallb => d; rewrite implybE.
rewrite (prob_drawn (fun d u => (cell d != i) || T d u)) (bigID (fun d => cell d == i)) /=.
rewrite [X in _ * X]big1 ?mulr1 => [|d ne]; last first.
  by rewrite (eq_bigl xpredT) ?(proj2 (laws _)) // => u; rewrite ne.
by apply: eq_bigr => d /eqP ->; apply: eq_bigl => u; rewrite eqxx.
Qed.

Lemma prob_good W : prob drawn [set w : {ffun D -> U} | [set d | good (cell d) (w d)] == W] = \prod_i chance_of i (W :&: [set d | cell d == i]).
Proof.
rewrite (_ : [set w | _] = [set w : {ffun D -> U} | [forall d, good (cell d) (w d) == (d \in W)]]); last first.
  apply/setP => w; rewrite !inE; apply/eqP/forallP => [<- d|e]; first by rewrite inE.
  by apply/setP => d; rewrite inE (eqP (e d)).
rewrite (prob_drawn (fun d u => good (cell d) u == (d \in W))) (partition_big cell xpredT) //=.
apply: eq_bigr => i _; apply: eq_bigr => d /eqP ci.
by rewrite sum_good !inE ci eqxx andbT.
Qed.

Lemma countE i w : count i w = #|[set d | good (cell d) (w d)] :&: [set d | cell d == i]|.
Proof. by apply: eq_card => d; rewrite !inE andbC; case: (cell d =P i) => [->|]; rewrite ?andbF. Qed.

(* The numbers of good draws of different cells are then independent. *)
Theorem counts_independent (S : I -> pred nat) :
  prob drawn [set w | [forall i, S i (count i w)]] = \prod_i prob drawn [set w | S i (count i w)].
Proof.
pose part W := [ffun i => W :&: [set d | cell d == i]].
pose join (f : {ffun I -> {set D}}) := \bigcup_i f i.
rewrite [RHS](eq_bigr _ (fun i _ => prob_count (S i) (within_drawn i))) bigA_distr_big_dep.
rewrite /prob (partition_big (fun w => [set d | good (cell d) (w d)])
  (fun W => [forall i, S i #|W :&: [set d | cell d == i]|])) /= => [|w]; last first.
  by rewrite inE => /forallP all_i; apply/forallP => i; rewrite -countE.
rewrite [LHS](reindex_onto join part) /= => [|W _]; last first.
  apply/setP => d; apply/bigcupP/idP => [[i _]|dW]; first by rewrite ffunE inE => /andP[].
  by exists (cell d); rewrite // ffunE !inE dW eqxx.
have cells (f : {ffun I -> {set D}}) : part (join f) = f <-> forall i, f i \subset [set d | cell d == i].
  split=> [e i|sub]; first by rewrite -e ffunE subsetIr.
  apply/ffunP => i; rewrite ffunE; apply/setP => d; rewrite !inE; apply/andP/idP => [[/bigcupP[j _ dj] /eqP ci]|di].
    by have := subsetP (sub j) d dj; rewrite inE ci => /eqP ij; rewrite ij.
  by split; [apply/bigcupP; exists i | have := subsetP (sub i) d di; rewrite inE].
apply: eq_big => [f|f /andP[/forallP Sf /eqP ef]].
  apply/andP/familyP => [[/forallP Sf /eqP ef] i|all_i].
    have := Sf i; rewrite -topredE /= => Si; rewrite (proj1 (cells f) ef) /=.
    by move: Si; rewrite -[X in X :&: _]/(join f) -{2}ef ffunE.
  have ef : part (join f) = f by apply/cells => i; have := all_i i; rewrite -topredE => /andP[].
  split; last exact/eqP.
  apply/forallP => i; have := all_i i; rewrite -topredE => /andP[_].
  by rewrite -{1}ef ffunE.
transitivity (prob drawn [set w : {ffun D -> U} | [set d | good (cell d) (w d)] == join f]).
  apply: eq_bigl => w; rewrite !inE; case: eqP => [ew|]; rewrite ?andbF // andbT.
  by apply/forallP => i; rewrite countE ew; apply: Sf.
by rewrite prob_good; apply: eq_bigr => i _; rewrite -{2}ef ffunE.
Qed.

End Draws.
