(* The table that Policy.v computes is that of the law which a policy and its filters induce: what Meaning.v says of it is what
   PolicyMeaning.v says of the policy. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From Fairaudit Require Import Definitions.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Table Meaning.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound PolicyLaw.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Numbered.
Variables (T : Type) (d : T).

Lemma in_combine k (xs : seq T) t : In t (combine (List.seq k (length xs)) xs) <->
  (k <= t.1 < k + size xs)%N /\ t.2 = nth d xs (t.1 - k).
Proof.
elim: xs k t => [|x xs IH] k [n v] /=.
  by split=> // -[/andP[h]]; rewrite addn0 ltnNge h.
have step : (k < n)%N -> nth d (x :: xs) (n - k) = nth d xs (n - k.+1).
  by move=> h; rewrite -subnSK.
split=> [[[<- <-]|/IH[/= /andP[h h'] ->]]|].
- by rewrite leqnn subnn -[X in (X < _)%N]addn0 ltn_add2l.
- by rewrite (ltnW h) addnS -addSn h' step.
move=> [/andP[]]; rewrite leq_eqVlt => /orP[/eqP<-|h] h' e; first by left; rewrite e subnn.
by right; apply/IH; rewrite /= h addSn -addnS h' e step.
Qed.

Lemma in_numbered (xs : seq T) t : In t (numbered xs) <-> (t.1 < size xs)%N /\ t.2 = nth d xs t.1.
Proof. by rewrite /numbered in_combine add0n subn0. Qed.
End Numbered.

Lemma sum_range (R : realFieldType) n (F : Z -> R) : \sum_(u <- Table.range (Z.of_nat n)) F u = \sum_(i < n) F (Z.of_nat i).
Proof.
rewrite /Table.range Nat2Z.id.
have -> : List.map Z.of_nat (List.seq 0 n) = [seq Z.of_nat i | i <- iota 0 n].
  by elim: n 0%N => //= n IH m; rewrite IH.
by rewrite big_map -[n in iota 0 n]subn0 -/(index_iota 0 n) big_mkord.
Qed.

Section Induced.
Variables (R : realFieldType) (S : behind).
Hypothesis ok : valid S.
Local Notation T := (induced_table S).
Local Notation MX := (@MX R S).
Local Notation MA := (@MA R S).
Local Notation T0 := (@T0 R S).

Definition weights_at (x a : nat) : seq Z := nth [::] (nth [::] (induced_weights S) x) a.

Lemma in_cells c : In c (Table.cells T) <->
  exists x a, [/\ (x < true_contexts S)%N, (a < true_groups S)%N & c = induced_cell S x a (weights_at x a)].
Proof.
have sizes x : (x < true_contexts S)%N -> size (nth [::] (induced_weights S) x) = true_groups S.
  by move=> hx; rewrite (@nth_map_in _ _ [::]) ?size_pieces.
have size_x : size (induced_weights S) = true_contexts S by rewrite size_map_list size_pieces.
rewrite in_flat_map; split=> [[[x row] [/(in_numbered [::]) xr]]|[x [a [hx ha ->]]]].
  case: xr => /= hx -> /in_map_iff[[a ws] [<- /(in_numbered [::]) /= [ha ->]]].
  by rewrite size_x in hx; rewrite sizes // in ha; exists x, a.
exists (x, nth [::] (induced_weights S) x); split; first by apply/(in_numbered [::]); rewrite size_x.
by apply/in_map_iff; exists (a, weights_at x a); split=> //; apply/(in_numbered [::]); rewrite sizes.
Qed.

Lemma cell_atP (x : X S) (a : A S) : Meaning.cell_at T (Z.of_nat x) (Z.of_nat a) = Some (induced_cell S x a (weights_at x a)).
Proof.
rewrite /Meaning.cell_at; case e: (List.find _ _) => [c|].
  have [/in_cells[x' [a' [_ _ ->]]] /andP[/Z.eqb_eq ex /Z.eqb_eq ea]] := find_some _ _ e.
  by rewrite (Nat2Z.inj _ _ ex) (Nat2Z.inj _ _ ea).
have inside : In (induced_cell S x a (weights_at x a)) (Table.cells T).
  by apply/in_cells; exists x, a; split=> //; apply: ltn_ord.
by have := find_none _ _ e _ inside; rewrite /= !Z.eqb_refl.
Qed.

(* The numbers of a cell, divided by their sum *)
Lemma weight_sum (x : X S) (a : A S) : embed (fold_right Z.add Z0 (weights_at x a)) = scale R S.
Proof.
have size_w := weights_size R ok (ltn_ord x) (ltn_ord a).
have fold ws : embed (fold_right Z.add Z0 ws) = \sum_(i < size ws) integer R ws i.
  elim: ws => [|w ws IH]; first by rewrite big_ord0 embed0.
  by rewrite [fold_right _ _ _]/(Z.add w (fold_right Z.add Z0 ws)) embedD IH big_ord_recl.
rewrite fold [size _]size_w -[RHS]mulr1.
rewrite -(proj2 (kernel_induced x (kernel_MX R ok) (kernel_MA R ok) (policy_T0 R ok) a)) mulr_sumr.
by apply: eq_bigr => u _; apply: induced_weightsP.
Qed.

Theorem induced_weight (x : X S) (a : A S) (u : U S) :
  Meaning.weight R T (Z.of_nat x) (Z.of_nat a) (Z.of_nat u) = induced MX MA T0 x a u.
Proof.
rewrite /Meaning.weight cell_atP /Meaning.number Nat2Z.id list_nth /= /law_of.
have := weight_sum x a; have sc := scale_gt0 R S; have := induced_weightsP R ok x a u.
have hu : (u < size (weights_at x a))%N by rewrite [size _](weights_size R ok).
rewrite -/(weights_at x a); case: (fold_right _ _ _) => [|t|t] w total.
- by move: sc; rewrite -total embed0 ltxx.
- rewrite (@nth_map_in _ _ Z0) // ratio_reduced /ratio /= total -[embed (nth _ _ _)]/(integer R _ _) w.
  by rewrite mulrC mulKf // gt_eqF.
by have := embed_pos R t; rewrite -oppr_lt0 -embedN total ltNge (ltW sc).
Qed.

Theorem induced_law (x : X S) (a : A S) (u : U S) :
  Meaning.law R T (Z.of_nat x) (Z.of_nat a) (Z.of_nat u) = induced MX MA T0 x a u.
Proof.
rewrite /Meaning.law /Meaning.row_total sum_range.
under eq_bigr => v _ do rewrite induced_weight.
by rewrite (proj2 (kernel_induced x (kernel_MX R ok) (kernel_MA R ok) (policy_T0 R ok) a)) divr1 induced_weight.
Qed.

Lemma induced_gain (x : X S) (a : A S) (u : U S) : Meaning.gain R T (Z.of_nat x) (Z.of_nat a) (Z.of_nat u) = g R u x a.
Proof.
rewrite /Meaning.gain cell_atP /g /PolicyMeaning.number /= /gains; have := proj1 (gains_ok R ok (ltn_ord x) (ltn_ord a)).
rewrite /gains; case: (utility S) => [v _|gs]; first by rewrite /Meaning.number Nat2Z.id list_nth.
by rewrite !list_nth Nat2Z.id => e; rewrite (@nth_map_in _ _ zero) // e.
Qed.

(* E(x,a), P(x,a) and the means of groups *)
Theorem induced_expectation (x : X S) (a : A S) : Meaning.expectation R T (Z.of_nat x) (Z.of_nat a) = E0 R x a.
Proof. by rewrite /Meaning.expectation sum_range; apply: eq_bigr => u _; rewrite induced_law induced_gain. Qed.

Theorem induced_mass (x : X S) (a : A S) : Meaning.cell_mass R T (Z.of_nat x) (Z.of_nat a) = mass R x a.
Proof.
rewrite /Meaning.cell_mass cell_atP /mass /= /mass_in; case: (population S) => // masses.
by rewrite !list_nth.
Qed.

Theorem induced_mass_of (a : A S) : Meaning.group_mass R T (Z.of_nat a) = mass_of R a.
Proof. by rewrite /Meaning.group_mass sum_range; apply: eq_bigr => x _; rewrite induced_mass. Qed.

Theorem induced_mean (a : A S) : Meaning.group_mean R T (Z.of_nat a) = mean (E0 R (S := S)) a.
Proof.
rewrite /Meaning.group_mean sum_range induced_mass_of mulr_suml; apply: eq_bigr => x _.
by rewrite induced_mass induced_expectation /share mulrAC.
Qed.
End Induced.
