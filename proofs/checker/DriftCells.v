(* The cells of a table under drift: their ends bound what Meaning.v says, and all cells can be moved at once, each as one likes. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From mathcomp.zify Require Import ssrZ.
From Fairaudit Require Import Definitions.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Drift ListsSound TableSound FiguresSound MovedLaws MovedCells.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Cells.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).
Local Notation n := (Z.to_nat (decisions T)).

Lemma sum_range (f : Z -> R) : \sum_(u <- range (decisions T)) f u = \sum_(i < n) f (Z.of_nat i).
Proof. by rewrite rangeE big_map -(big_mkord xpredT (fun i => f (Z.of_nat i))) /index_iota subn0. Qed.

Lemma in_decisions u : u \in range (decisions T) <-> exists i : 'I_n, u = Z.of_nat i.
Proof.
rewrite mem_range /inside; split=> [/andP[/Z.leb_le low /Z.ltb_lt high]|[i ->]].
  have lt : (Z.to_nat u < n)%N by apply/ssrnat.ltP; lia.
  by exists (Ordinal lt); rewrite /= Z2Nat.id.
by have /ssrnat.ltP lt := ltn_ord i; apply/andP; split; [apply/Z.leb_le | apply/Z.ltb_lt]; lia.
Qed.

Definition by_number (D : Z -> R) (i : 'I_n) : R := D (Z.of_nat i).
Definition by_decision (D : 'I_n -> R) (u : Z) : R := if insub (Z.to_nat u) is Some i then D i else 0.

Lemma by_decisionK D i : by_number (by_decision D) i = D i.
Proof. by rewrite /by_number /by_decision Nat2Z.id valK. Qed.

Lemma amount_starts k w : is_amount k w -> starts k (ratio w : R).
Proof. by case: k => /=; [move=> /andP[]; rewrite (nonnegativeE R) | rewrite (at_mostE R) ratio_one]. Qed.

Section OneCell.
Variable c : cell.
Hypothesis c_in : List.In c (cells T).
Local Notation x := (context c).
Local Notation a := (group c).
Definition its : mover := (row_of T c, gains_of T c).
Local Notation ps := (law_of (row_of T c)).
Local Notation gs := (gains_of T c).
Local Notation P := (@listed R n ps).
Local Notation g := (@listed R n gs).

Lemma size_law : size ps = n. Proof. by have /of_lengthP[_] := law_length ok c_in. Qed.
Lemma size_gains : size gs = n. Proof. by have /of_lengthP[_] := gains_length ok c_in. Qed.

Lemma listed_law i : P i = by_number (law R T x a) i.
Proof. by rewrite /by_number lawE // /number Nat2Z.id nthE. Qed.

Lemma listed_gain i : g i = by_number (gain R T x a) i.
Proof. by rewrite /by_number gainE // /number Nat2Z.id nthE. Qed.

Lemma expectation_list : expectation R T x a = expect P g.
Proof. by rewrite /expectation sum_range; apply: eq_bigr => i _; rewrite listed_law listed_gain. Qed.

Lemma is_a_law : Definitions.law P.
Proof.
split=> [i|]; first by rewrite listed_law; apply: law_nonnegative.
transitivity (\sum_(u <- range (decisions T)) law R T x a u).
  by rewrite sum_range; apply: eq_bigr => i _; rewrite listed_law.
rewrite /law -mulr_suml -/(row_total R T x a) divff // row_totalE // gt_eqF //; exact: (total_gt0 R ok c_in).
Qed.

Lemma expectation_in_list D : expectation_in T D x a = expect (by_number (D x a)) g.
Proof. by rewrite /expectation_in sum_range; apply: eq_bigr => i _; rewrite listed_gain. Qed.

Lemma movedE k v D : moved T k v (law R T x a) D <-> near P k v (by_number D).
Proof.
have same (F : Z -> Prop) : (forall u, u \in range (decisions T) -> F u) <-> forall i : 'I_n, F (Z.of_nat i).
  by split=> [all_ i|all_ u /in_decisions[i ->]] //; apply: all_; apply/in_decisions; exists i.
rewrite /moved /is_law /near /Definitions.law sum_range; have eP i : P i = law R T x a (Z.of_nat i) := listed_law i.
split=> -[[D0 D1] nD]; split=> //.
- by split=> // i; apply: (proj1 (same (fun u => 0 <= D u))).
- case: k nD => [|both].
    by rewrite sum_range /tv /hockey_stick; under [X in _ -> is_true (X <= _)]eq_bigr do rewrite mul1r eP.
  by split=> i; have [one two] := proj1 (same (fun u => D u <= v * law R T x a u /\ law R T x a u <= v * D u)) both i; rewrite eP.
- by split=> //; apply/(same (fun u => 0 <= D u)).
- case: k nD => [|[one two]].
    by rewrite sum_range /tv /hockey_stick; under eq_bigr do rewrite mul1r eP.
  by apply/(same (fun u => D u <= v * law R T x a u /\ law R T x a u <= v * D u)) => i; rewrite -eP; split; [apply: one | apply: two].
Qed.

Lemma by_decision_moved k v D : near P k v D -> moved T k v (law R T x a) (by_decision D).
Proof.
move=> nD; apply/movedE; have [[D0 D1] rest] := nD.
have e : by_number (by_decision D) =1 D := by_decisionK D.
split; first by split=> [i|]; rewrite ?e // (eq_bigr _ (fun i _ => e i)).
case: k rest {nD} => [|[one two]]; first by rewrite /tv /hockey_stick; under [X in _ -> is_true (X <= _)]eq_bigr do rewrite e.
by split=> i; rewrite e.
Qed.

Lemma by_decision_expect D : \sum_(u <- range (decisions T)) by_decision D u * gain R T x a u = expect D g.
Proof. by rewrite sum_range; apply: eq_bigr => i _; rewrite -[by_decision D _]/(by_number _ i) by_decisionK listed_gain. Qed.

(* ---- The ends that the program finds ---- *)

Variables (k : move) (amount : option Q) (e : Q * Q).
Hypothesis amount_ok : an_amount k amount.
Hypothesis found : ends_of k amount its = Some e.

Lemma are_its_ends : are_ends R n ps gs k amount e.
Proof.
apply: (ends_of_lawP size_law size_gains is_a_law amount_ok _ found).
by rewrite -expectation_list expectationE.
Qed.

Lemma cell_bounds v D : meant amount v -> drifted T k v D -> ratio e.1 <= expectation_in T D x a <= ratio e.2.
Proof.
move=> mv dr; have [bounds _] := are_its_ends; rewrite expectation_in_list; apply: (bounds v) => //.
by apply/movedE; apply: dr; apply: has_cell_of.
Qed.

Local Notation value D := (\sum_(u <- range (decisions T)) D u * gain R T x a u).

(* Each value between the ends is attained. *)
Lemma cell_attains w v : amount = Some w -> ratio e.1 <= v <= ratio e.2 -> exists2 D, moved T k (ratio w) (law R T x a) D & value D = v.
Proof.
move=> is_w between; have [_] := are_its_ends; rewrite is_w => -[[D nD eD] [D' nD' eD']].
suff [t t01 e_t] : exists2 t, 0 <= t <= 1 & (1 - t) * ratio e.1 + t * ratio e.2 = v.
  exists (by_decision (mix t D D')); first by apply: by_decision_moved; apply: near_mix => //; exact: is_a_law.
  by rewrite by_decision_expect expect_mix eD eD'.
have [low high] := andP between; have [same|less] := eqVneq (ratio e.1 : R) (ratio e.2).
  exists 0; rewrite ?lexx ?ler01 // subr0 mul1r mul0r addr0; apply: le_anti; rewrite low /= same.
  by rewrite -[leRHS]same in high; rewrite same in high.
have pos : 0 < ratio e.2 - ratio e.1 :> R by rewrite subr_gt0 lt_def eq_sym less (le_trans low).
exists ((v - ratio e.1) / (ratio e.2 - ratio e.1)).
  by rewrite divr_ge0 ?subr_ge0 ?(le_trans low) //= ler_pdivr_mulr // mul1r ler_add2r.
have -> : (1 - (v - ratio e.1) / (ratio e.2 - ratio e.1)) * ratio e.1 + (v - ratio e.1) / (ratio e.2 - ratio e.1) * ratio e.2
  = ratio e.1 + (v - ratio e.1) / (ratio e.2 - ratio e.1) * (ratio e.2 - ratio e.1) by ring.
by rewrite divfK ?gt_eqF // addrC subrK.
Qed.

Definition end_on (up : bool) : R := ratio (if up then e.2 else e.1).
Definition last_on (up : bool) : R := ratio (last_of k up its).

(* The greatest utility of those that can be reached, as seen in a direction *)
Lemma last_top up : top_is P (fun i => if up then g i else - g i) k (if up then last_on up else - last_on up).
Proof.
rewrite /last_on /last_of /signed_as /directed /law_with_gains /=; case: up.
  exact: (top_reachable size_law is_a_law size_gains).
rewrite ratio_minus opprK turned_combine; have := top_reachable (R := R) size_law is_a_law (gs := map minus gs) _ k; rewrite size_map => /(_ size_gains).
by case=> [[i can <-] top]; split=> [|i' /top]; rewrite ?listed_turned ?size_gains //; exists i; rewrite // listed_turned ?size_gains.
Qed.

(* With a move that may be farther, the end is moved on towards the last value. *)
Lemma cell_rises w v up : amount = Some w -> ratio w < v ->
  exists2 t0, 0 < t0 <= 1 & forall t, 0 <= t <= t0 ->
    exists2 D, moved T k v (law R T x a) D & value D = (1 - t) * end_on up + t * last_on up.
Proof.
move=> is_w far; have [_] := are_its_ends; rewrite is_w => -[[D nD eD] [D' nD' eD']].
have [[i can gi] _] := last_top up.
have st : starts k (ratio w).
  by move: amount_ok; rewrite is_w; apply: amount_starts.
have nE : near P k (ratio w) (if up then D' else D) by case: up {can gi}.
have [t0 t01 mixed] := can_rise is_a_law st far nE can.
exists t0 => // t /mixed nM; exists (by_decision (mix t (if up then D' else D) (point R i))); first exact: by_decision_moved.
rewrite by_decision_expect expect_mix expect_point /end_on; congr (_ * _ + _ * _); first by case: up {can gi nE mixed nM}.
by move: gi; case: up {can nE mixed nM} => // /oppr_inj.
Qed.
End OneCell.

(* ---- All cells at once ---- *)

Lemma choose (Phi : cell -> (Z -> R) -> Prop) : (forall c, List.In c (cells T) -> exists D, Phi c D) ->
  exists D : Z -> Z -> Z -> R, forall c, List.In c (cells T) -> Phi c (D (context c) (group c)).
Proof.
have := cells_sorted ok; elim: (cells T) => [|c cs IH] srt each; first by exists (fun _ _ _ => 0).
have [|D chosen] := IH (path_sorted srt); first by move=> d din; apply: each; right.
have [Dc Phic] := each c (or_introl erefl).
exists (fun x a => if Z.eqb x (context c) && Z.eqb a (group c) then Dc else D x a) => d [<-|din]; first by rewrite !Z.eqb_refl.
case: ifP => [/andP[/Z.eqb_eq ex /Z.eqb_eq ea]|_]; last exact: chosen.
by have := not_itself (later_cell ok srt din) (esym ex); rewrite ea.
Qed.

Lemma all_moved k v D : (forall c, List.In c (cells T) -> moved T k v (law R T (context c) (group c)) (D (context c) (group c))) -> drifted T k v D.
Proof. by move=> each x a /(has_cellP ok)[c cin [<- <-]]; apply: each. Qed.
End Cells.
