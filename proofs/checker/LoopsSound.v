(* Each loop of Loops.v is the function in whose place Extract.v puts it. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import ssreflect ssrfun ssrbool eqtype ssrnat seq path.
From FairauditKernel Require Import Fractions WorstCase.
From FairauditChecker Require Import Loops Json Canonical Table Figures LeftOut.
From FairauditChecker Require Drawn.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Section Lists.
Variables A B : Type.
Implicit Types (xs ys : list A).

Lemma turned (T : Type) (xs ys : list T) : rev_append xs ys = (List.rev xs ++ ys)%list.
Proof. exact: rev_append_rev. Qed.

Lemma turned_back (T : Type) (done : list T) : rev_append (List.rev done) [::] = done.
Proof. by rewrite turned List.rev_involutive List.app_nil_r. Qed.

Theorem app_is xs ys : loop_app xs ys = List.app xs ys.
Proof. by rewrite /loop_app !turned List.app_nil_r List.rev_involutive. Qed.

Theorem cat_is xs ys : loop_app xs ys = cat xs ys.
Proof. exact: app_is. Qed.

Theorem length_is xs : loop_length xs = List.length xs.
Proof.
have onto done : length_onto done xs = (done + List.length xs)%coq_nat by elim: xs done => [|x xs IH] done /=; [lia | rewrite IH; lia].
exact: onto.
Qed.

Theorem map_is (f : A -> B) xs : loop_map f xs = List.map f xs.
Proof.
have onto done : map_onto f done xs = (List.rev (List.map f xs) ++ done)%list.
  by elim: xs done => [|x xs IH] done //=; rewrite IH -List.app_assoc.
by rewrite /loop_map onto List.app_nil_r turned_back.
Qed.

Theorem seq_map_is (f : A -> B) xs : loop_map f xs = map f xs.
Proof. exact: map_is. Qed.

Theorem flat_map_is (f : A -> list B) xs : loop_flat_map f xs = List.flat_map f xs.
Proof.
have onto done : flat_map_onto f done xs = (List.rev (List.flat_map f xs) ++ done)%list.
  by elim: xs done => [|x xs IH] done //=; rewrite IH turned List.rev_app_distr List.app_assoc.
by rewrite /loop_flat_map onto List.app_nil_r turned_back.
Qed.

Theorem concat_is (xss : list (list A)) : loop_concat xss = List.concat xss.
Proof.
have onto done : concat_onto done xss = (List.rev (List.concat xss) ++ done)%list.
  by elim: xss done => [|xs xss IH] done //=; rewrite IH turned List.rev_app_distr List.app_assoc.
by rewrite /loop_concat onto List.app_nil_r turned_back.
Qed.

Theorem filter_is (f : A -> bool) xs : loop_filter f xs = List.filter f xs.
Proof.
have onto done : filter_onto f done xs = (List.rev (List.filter f xs) ++ done)%list.
  by elim: xs done => [|x xs IH] done //=; rewrite IH; case: (f x) => //=; rewrite -List.app_assoc.
by rewrite /loop_filter onto List.app_nil_r turned_back.
Qed.

Theorem combine_is xs (ys : list B) : loop_combine xs ys = List.combine xs ys.
Proof.
have onto done : combine_onto done xs ys = (List.rev (List.combine xs ys) ++ done)%list.
  by elim: xs ys done => [|x xs IH] [|y ys] done //=; rewrite IH -List.app_assoc.
by rewrite /loop_combine onto List.app_nil_r turned_back.
Qed.

Theorem numbered_is n xs : loop_numbered n xs = WorstCase.numbered n xs.
Proof.
have onto done : numbered_onto done n xs = (List.rev (WorstCase.numbered n xs) ++ done)%list.
  by elim: xs n done => [|x xs IH] n done //=; rewrite IH -List.app_assoc.
by rewrite /loop_numbered onto List.app_nil_r turned_back.
Qed.

Theorem runs_is (key : A -> Z) xs : loop_runs key xs = runs key xs.
Proof.
rewrite /loop_runs turned List.app_nil_r; rewrite -(List.fold_left_rev_right (fun x more => before_runs key more x)) List.rev_involutive.
by elim: xs => //= x xs ->; rewrite /before_runs; case: (runs key xs) => [|[k ys] more].
Qed.
End Lists.

Theorem aligned_is xs F : loop_aligned who xs F = aligned xs F.
Proof.
have onto done : aligned_onto who done xs F = (List.rev (aligned xs F) ++ done)%list.
  elim: xs F done => [|x xs IH] [|[y rs] more] done //=; first by rewrite IH -List.app_assoc.
  by case: (y =? x)%Z; rewrite IH /= -List.app_assoc.
by rewrite /loop_aligned onto List.app_nil_r turned_back.
Qed.

Theorem all_of_is (A B : Type) (f : A -> option B) xs : loop_all_of f xs = Drawn.all_of f xs.
Proof.
have onto done : all_of_onto f done xs = omap (fun ys => (List.rev done ++ ys)%list) (Drawn.all_of f xs).
  elim: xs done => [|x xs IH] done /=; first by rewrite turned.
  case: (f x) => // y; rewrite IH; case: (Drawn.all_of f xs) => //= ys.
  by rewrite -List.app_assoc.
by rewrite /loop_all_of onto; case: (Drawn.all_of f xs).
Qed.

Theorem compared_cells_is n before cs : loop_compared Drawn.context_of_cell n before cs = Drawn.compared_cells n before cs.
Proof.
have onto done : compared_onto Drawn.context_of_cell done n before cs = (List.rev (Drawn.compared_cells n before cs) ++ done)%list.
  elim: cs n before done => [|c cs IH] n before done //=.
  by case: ifP => _; [|case: ifP => _]; rewrite IH //= -List.app_assoc.
by rewrite /loop_compared onto List.app_nil_r turned_back.
Qed.

Theorem fold_right_is (A B : Type) (f : B -> A -> A) last xs : loop_fold_right f last xs = List.fold_right f last xs.
Proof. by rewrite /loop_fold_right turned List.app_nil_r -(List.fold_left_rev_right f (List.rev xs)) List.rev_involutive. Qed.

Theorem sums_of_two_is qs : loop_in_twos plus qs = sums_of_two qs.
Proof.
have onto done : in_twos_onto plus done qs = (List.rev done ++ sums_of_two qs)%list.
  have [n] := ubnP (size qs); elim: n qs done => // n IH [|q [|r qs]] done small /=; rewrite ?turned //.
  by rewrite IH /= -?List.app_assoc //; rewrite /= !ltnS in small; exact: ltnW.
exact: onto.
Qed.

(* ---- Numbers ---- *)

Theorem of_nat_is n : loop_of_nat n = Z.of_nat n.
Proof.
have onto done : of_nat_onto done n = (done + Z.of_nat n)%Z by elim: n done => [|n IH] done /=; [lia | rewrite IH; lia].
exact: onto.
Qed.

Theorem to_nat_is z : loop_to_nat z = Z.to_nat z.
Proof. case: z => //= p; rewrite Pos2Nat.inj_iter; elim: (Pos.to_nat p) => //= n ->; done. Qed.

Theorem seq_is start n : loop_seq start n = List.seq start n.
Proof.
have onto done : seq_onto done start n = (List.rev (List.seq start n) ++ done)%list.
  by elim: n start done => [|n IH] start done //=; rewrite IH -List.app_assoc.
by rewrite /loop_seq onto List.app_nil_r turned_back.
Qed.

Theorem range_is n : loop_range n = range n.
Proof.
rewrite /loop_range /range to_nat_is; have <- : Z.of_nat 0 = 0%Z by [].
have onto start done k : range_onto done (Z.of_nat start) k = (List.rev (List.map Z.of_nat (List.seq start k)) ++ done)%list.
  elim: k start done => [|k IH] start done //=; rewrite -List.app_assoc /= -IH; congr range_onto; lia.
by rewrite onto List.app_nil_r turned_back.
Qed.

(* ---- Sorting ---- *)

Section Sorting.
Variables (T : Type) (le : T -> T -> bool).

Lemma merge_is s t : loop_merge le s t = merge le s t.
Proof.
have onto steps done : (size s + size t <= size steps)%N -> merge_onto le steps done s t = (List.rev done ++ merge le s t)%list.
  elim: steps s t done => [|z steps IH] [|x s] [|y t] done //= enough; rewrite ?turned ?List.app_nil_r //.
  by case: ifP => _; rewrite IH /= -?List.app_assoc //; move: enough; rewrite ?addnS ?addSn ltnS.
apply: onto; rewrite turned -[(_ ++ _)%list]/(cat _ _) size_cat leq_add2r -[size (List.rev s)]/(List.length _) List.rev_length.
exact: leqnn.
Qed.

Lemma sort_push_is s ss : sort_push le s ss = merge_sort_push le s ss.
Proof. by elim: ss s => [|[|x t] ss IH] s //=; rewrite merge_is IH. Qed.

Lemma sort_pop_is s ss : sort_pop le s ss = merge_sort_pop le s ss.
Proof. by elim: ss s => [|t ss IH] s //=; rewrite merge_is IH. Qed.

Theorem sort_is s : loop_sort le s = sort le s.
Proof.
rewrite /loop_sort /sort; have [n] := ubnP (size s); elim: n s [::] => // n IH [|x [|y s]] ss small /=; rewrite ?sort_pop_is //.
by rewrite sort_push_is IH //; rewrite /= !ltnS in small; exact: ltnW.
Qed.
End Sorting.

(* The two sorts that are made by Coq's functor, of texts and of members, are the same program. *)

Section Texts.
Local Notation le := no_later.

Lemma texts_merge_is s t : loop_merge le s t = Json.Sorting.merge s t.
Proof.
rewrite merge_is; elim: s t => [|x s IH]; first by case.
by elim=> [|y t IHt] //=; case: ifP => _; [rewrite IH | exact: (f_equal (cons y) IHt)].
Qed.

Theorem texts_sort_is s : loop_stack_sort le s = Json.Sorting.sort s.
Proof.
have push stack l : stack_push le stack l = Json.Sorting.merge_list_to_stack stack l.
  by elim: stack l => [|[t|] stack IH] l //=; rewrite texts_merge_is IH.
have pop stack : stack_pop le stack = Json.Sorting.merge_stack stack.
  by elim: stack => [|[t|] stack IH] //=; rewrite texts_merge_is IH.
rewrite /loop_stack_sort /Json.Sorting.sort; elim: s [::] => [|x s IH] stack /=; [exact: pop | by rewrite push IH].
Qed.
End Texts.

Section Members.
Local Notation le := ByKey.leb.

Lemma members_merge_is s t : loop_merge le s t = SortingMembers.merge s t.
Proof.
rewrite merge_is; elim: s t => [|x s IH]; first by case.
by elim=> [|y t IHt] //=; rewrite -[no_later x.1 y.1]/(le x y); case: ifP => _; [rewrite IH | exact: (f_equal (cons y) IHt)].
Qed.

Theorem members_sort_is s : loop_stack_sort le s = SortingMembers.sort s.
Proof.
have push stack l : stack_push le stack l = SortingMembers.merge_list_to_stack stack l.
  by elim: stack l => [|[t|] stack IH] l //=; rewrite members_merge_is IH.
have pop stack : stack_pop le stack = SortingMembers.merge_stack stack.
  by elim: stack => [|[t|] stack IH] //=; rewrite members_merge_is IH.
rewrite /loop_stack_sort /SortingMembers.sort; elim: s [::] => [|x s IH] stack /=; [exact: pop | by rewrite push IH].
Qed.
End Members.
