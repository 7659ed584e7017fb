(* What is computed of each cell and each group of a valid table is what Meaning.v says. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures ListsSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Tables.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).
Local Notation number := (@ListsSound.number R).

(* ---- What a valid table is ---- *)

Lemma decisions_gt0 : Z.lt 0 (decisions T).
Proof. by move: ok => /and5P[_ _ /Z.ltb_lt]. Qed.

Lemma cells_valid c : List.In c (cells T) -> valid_cell T c.
Proof. by move: ok => /and5P[_ _ _ _ /and4P[_ _ /forallb_forall all_valid _]]; apply: all_valid. Qed.

Lemma utility_length gs : utility T = Some gs -> of_length (decisions T) gs.
Proof. by move: ok => /and5P[_ _ _ + _] e; rewrite e. Qed.

Section OneCell.
Variable c : cell.
Hypothesis c_in : List.In c (cells T).

Lemma context_inside : context c \in range (contexts T).
Proof. by rewrite mem_range; have /and5P[] := cells_valid c_in. Qed.

Lemma group_inside : group c \in range (groups T).
Proof. by rewrite mem_range; have /and5P[] := cells_valid c_in. Qed.

Lemma weights_length : of_length (decisions T) (weights c).
Proof. by have /and5P[_ _] := cells_valid c_in. Qed.

Lemma weights_nonnegative q : List.In q (weights c) -> 0 <= ratio q.
Proof.
have /and5P[_ _ _ /forallb_forall nonneg _] := cells_valid c_in.
by move/nonneg; rewrite (nonnegativeE R).
Qed.

Lemma total_positive : positive_fraction (total (weights c)).
Proof.
have /and5P[_ _ _ _ /and4P[+ _ _ _]] := cells_valid c_in; case: (population T) => //.
all: by rewrite /is_one /positive_fraction => /Z.eqb_eq ->.
Qed.

Lemma total_gt0 : 0 < ratio (total (weights c)).
Proof. by rewrite -(positive_fractionE R) total_positive. Qed.

Lemma gains_length : of_length (decisions T) (gains_of T c).
Proof.
rewrite /gains_of; case e: (utility T) => [gs|]; first exact: utility_length.
have /and5P[_ _ _ _ /and4P[_ _ + _]] := cells_valid c_in; rewrite /valid_gains e => /andP[length_ok _].
by rewrite /of_length map_length.
Qed.

Lemma bulk_nonnegative : 0 <= ratio (bulk (row_of T c)).
Proof.
rewrite /row_of /=; have /and5P[_ _ _ _ /and4P[_ + _ _]] := cells_valid c_in; have := total_gt0.
by case: (population T) => [/ltW //|_|_ _]; rewrite ?ratio_one ?ler01 // (nonnegativeE R).
Qed.
End OneCell.

(* ---- Cells in their order ---- *)

Lemma in_orderE cs : in_order cs = sorted comes_before cs.
Proof. by elim: cs => // c [|d cs] // IH; rewrite -[LHS]/(comes_before c d && in_order (d :: cs)) IH. Qed.

Lemma comes_before_trans : transitive comes_before.
Proof.
rewrite /comes_before => d c e.
case/orP => [/Z.ltb_lt cd|/andP[/Z.eqb_eq -> /Z.ltb_lt cd]]; case/orP => [/Z.ltb_lt de|/andP[/Z.eqb_eq <- /Z.ltb_lt de]].
- by apply/orP; left; apply/Z.ltb_lt; lia.
- by apply/orP; left; apply/Z.ltb_lt; lia.
- by apply/orP; left; apply/Z.ltb_lt; lia.
- by apply/orP; right; rewrite Z.eqb_refl; apply/Z.ltb_lt; lia.
Qed.

Lemma cells_sorted : sorted comes_before (cells T).
Proof. by rewrite -in_orderE; move: ok => /and5P[_ _ _ _ /and4P[]]. Qed.

Lemma later_cell c cs d : sorted comes_before (c :: cs) -> List.In d cs -> comes_before c d.
Proof. by move=> /(order_path_min comes_before_trans); elim: cs => //= e cs IH /andP[ce later] [<-|/(IH later)]. Qed.

Lemma not_itself c d : comes_before c d -> context c = context d -> group c <> group d.
Proof. by rewrite /comes_before => + e e'; rewrite e e' !Z.ltb_irrefl andbF. Qed.

Definition cell_among (cs : list cell) (x a : Z) : option cell := List.find (fun c => Z.eqb (context c) x && Z.eqb (group c) a) cs.

Lemma cell_among_in cs x a c : cell_among cs x a = Some c -> [/\ List.In c cs, context c = x & group c = a].
Proof. by move=> e; have [cin /andP[/Z.eqb_eq cx /Z.eqb_eq ca]] := find_some _ _ e. Qed.

Lemma cell_atP x a c : cell_at T x a = Some c -> [/\ List.In c (cells T), context c = x & group c = a].
Proof. exact: cell_among_in. Qed.

Lemma cell_of c : List.In c (cells T) -> cell_at T (context c) (group c) = Some c.
Proof.
rewrite /cell_at; elim: (cells T) cells_sorted => //= d cs IH srt [->|cin]; first by rewrite !Z.eqb_refl.
case: ifP => [/andP[/Z.eqb_eq dx /Z.eqb_eq da]|_]; last by apply: IH cin; apply: path_sorted srt.
by case: (not_itself (later_cell srt cin) dx da).
Qed.

Lemma has_cellP x a : reflect (exists2 c, List.In c (cells T) & context c = x /\ group c = a) (has_cell T x a).
Proof.
rewrite /has_cell; case e: (cell_at T x a) => [c|]; constructor; first by have [] := cell_atP e; exists c.
by case=> c cin [cx ca]; have := cell_of cin; rewrite cx ca e.
Qed.

Lemma has_cell_of c : List.In c (cells T) -> has_cell T (context c) (group c).
Proof. by move=> cin; apply/has_cellP; exists c. Qed.

(* ---- The numbers of a cell ---- *)

Section OneCell'.
Variable c : cell.
Hypothesis c_in : List.In c (cells T).
Local Notation x := (context c).
Local Notation a := (group c).
Local Notation r := (row_of T c).

Lemma weightE u : weight R T x a u = number u (weights c).
Proof. by rewrite /weight cell_of. Qed.

Lemma row_totalE : row_total R T x a = ratio (total (weights c)).
Proof.
rewrite /row_total ratio_total -(sum_number R (weights_length c_in)).
by apply: eq_bigr => u _; apply: weightE.
Qed.

Lemma lawE u : law R T x a u = number u (law_of r).
Proof. by rewrite /law weightE row_totalE number_times ratio_inverse ?total_positive // mulrC. Qed.

Lemma law_length : of_length (decisions T) (law_of r).
Proof. by rewrite /of_length map_length; apply: weights_length. Qed.

Lemma gainE u : gain R T x a u = number u (gains_of T c).
Proof.
rewrite /gain /gains_of cell_of //; case: (utility T) => // ; rewrite /number.
by elim: (gains c) (Z.to_nat u) => [|g gs IH] [|i] /=; rewrite ?ratio_zero //; case: g; rewrite ?ratio_zero.
Qed.

Lemma expectationE : expectation R T x a = ratio (mean r).
Proof.
rewrite /expectation -(sum_number_product R law_length (gains_length c_in)).
by apply: eq_bigr => u _; rewrite lawE gainE.
Qed.

Lemma cell_massE : cell_mass R T x a = ratio (bulk r).
Proof. by rewrite /cell_mass cell_of //= ; case: (population T); rewrite ?row_totalE ?ratio_one. Qed.

Lemma law_ge0 u : 0 <= number u (law_of r).
Proof.
rewrite /number; case: (ltnP (Z.to_nat u) (size (law_of r))) => [lt|ge]; last by rewrite nthE nth_default // ratio_zero.
rewrite nthE; have [q qin <-] : exists2 q, List.In q (weights c) & times (inverse (total (weights c))) q = nth zero (law_of r) (Z.to_nat u).
  exists (nth zero (weights c) (Z.to_nat u)); first by apply: in_of_nth; rewrite size_map in lt.
  by rewrite (nth_map zero) //; rewrite size_map in lt.
by rewrite ratio_times ratio_inverse ?total_positive // mulr_ge0 ?invr_ge0 ?(ltW (total_gt0 c_in)) // (weights_nonnegative c_in).
Qed.
End OneCell'.

(* ---- Sums over the contexts of a group are sums over its cells ---- *)

Definition of_group (a : Z) (cs : list cell) : list cell := [seq c <- cs | Z.eqb (group c) a].

Lemma sum_over_cells (H : cell -> R) a :
  \sum_(x <- range (contexts T)) (if cell_at T x a is Some c then H c else 0) = \sum_(c <- of_group a (cells T)) H c.
Proof.
rewrite /cell_at.
have : forall c, List.In c (cells T) -> context c \in range (contexts T) by move=> c /context_inside.
elim: (cells T) cells_sorted => [|c cs IH] srt inside_; first by rewrite big_nil big1.
have {}IH := IH (path_sorted srt) (fun d dcs => inside_ d (or_intror dcs)).
rewrite /of_group /=; case: ifP => [/Z.eqb_eq ca | /negbT ca]; last first.
  by rewrite -IH; apply: eq_bigr => x _ /=; rewrite andbF.
have [x_in uniq_] := (inside_ c (or_introl erefl), range_uniq (contexts T)).
rewrite big_cons -IH (bigD1_seq (context c)) //= [in RHS](bigD1_seq (context c)) //= Z.eqb_refl /=; congr (_ + _).
have -> : List.find (fun d => Z.eqb (context d) (context c) && Z.eqb (group d) a) cs = None.
  case e: (List.find _ _) => [d|] //; have [din dx da] := cell_among_in e.
  by case: (not_itself (later_cell srt din)); rewrite ?dx ?da ?ca.
rewrite add0r; apply: eq_bigr => x /eqP xc; case: Z.eqb_spec => // e; by case: xc.
Qed.

Lemma sum_of_masses (f : Z -> R) (h : cell -> R) a :
  (forall c, List.In c (cells T) -> group c = a -> f (context c) = h c) ->
  \sum_(x <- range (contexts T)) cell_mass R T x a * f x = \sum_(c <- of_group a (cells T)) ratio (bulk (row_of T c)) * h c.
Proof.
move=> fh; rewrite -sum_over_cells; apply: eq_bigr => x _; rewrite /cell_mass; case e: (cell_at T x a) => [c|]; last by rewrite mul0r.
have [cin cx ca] := cell_atP e; rewrite -cx fh //; congr (_ * _).
by have := cell_massE cin; rewrite /cell_mass cx ca e.
Qed.

Lemma sum_of_masses1 a : group_mass R T a = \sum_(c <- of_group a (cells T)) ratio (bulk (row_of T c)).
Proof.
rewrite /group_mass -[RHS](eq_bigr _ (fun c _ => mulr1 _)) -(@sum_of_masses (fun=> 1)) //.
by apply: eq_bigr => x _; rewrite mulr1.
Qed.

(* ---- The rows by context, and those of groups ---- *)

Lemma cells_by_context : sorted (not_after context) (cells T).
Proof.
apply: sub_sorted cells_sorted => c d; rewrite /comes_before /not_after.
by case/orP => [/Z.ltb_lt lt|/andP[/Z.eqb_eq -> _]]; apply/Z.leb_le; lia.
Qed.

Definition in_context (x : Z) : list cell := [seq c <- cells T | Z.eqb (context c) x].

Lemma runs_of_cells :
  sorted (@run_before cell) (runs context (cells T))
  /\ forall x cs, List.In (x, cs) (runs context (cells T)) -> cs = in_context x /\ cs <> [::].
Proof. exact: runsP cells_by_context. Qed.

Lemma rows_of_in x rs : List.In (x, rs) (rows_of T) -> rs = map (row_of T) (in_context x) /\ x \in range (contexts T).
Proof.
case/in_map_iff => -[y cs] [[<- <-] yin] /=; have [-> nonempty] := (proj2 runs_of_cells) _ _ yin; split=> //.
move: (proj2 runs_of_cells _ _ yin); case=> csE; move: nonempty; rewrite csE; case e: (in_context y) => [|c rest] // _ _.
have /in_filter_seq[cin /Z.eqb_eq <-] : List.In c (in_context y) by rewrite e; left.
exact: context_inside.
Qed.

Lemma rows_of_have x a : has_cell T x a -> List.In (x, map (row_of T) (in_context x)) (rows_of T).
Proof.
case/has_cellP => c cin [<- _]; have [cs csin] := runs_have context cin.
have [csE _] := (proj2 runs_of_cells) _ _ csin; apply/in_map_iff; exists (context c, cs); split=> //=.
by rewrite csE.
Qed.

Definition row_run_before (k l : Z * list row) : bool := Z.ltb k.1 l.1.

Lemma rows_of_sorted : sorted row_run_before (rows_of T).
Proof. by rewrite /rows_of sorted_map; apply: sub_sorted (proj1 runs_of_cells). Qed.

Lemma all_rows : flat_map snd (rows_of T) = map (row_of T) (cells T).
Proof.
rewrite -[in RHS](flat_runs context (cells T)) /rows_of; elim: (runs _ _) => //= k ks ->.
by rewrite -map_app.
Qed.

Lemma rows_with_key a : with_key who a (map (row_of T) (cells T)) = map (row_of T) (of_group a (cells T)).
Proof. by rewrite /with_key /of_group filter_map. Qed.

Lemma group_rows_in r : List.In r (group_rows T (rows_of T)) ->
  r = row_of_group (Z.to_nat (decisions T)) (who r) (map (row_of T) (of_group (who r) (cells T))) /\ of_group (who r) (cells T) <> [::].
Proof.
case/in_map_iff => -[a rs] [<- ain]; rewrite all_rows in ain.
have [-> nonempty] := (proj2 (groupedP _ _)) _ _ ain; rewrite rows_with_key in nonempty *; split=> //= e.
by rewrite e in nonempty.
Qed.

Lemma group_rows_have a : of_group a (cells T) <> [::] ->
  List.In (row_of_group (Z.to_nat (decisions T)) a (map (row_of T) (of_group a (cells T)))) (group_rows T (rows_of T)).
Proof.
move=> nonempty; apply/in_map_iff; exists (a, map (row_of T) (of_group a (cells T))); split=> //.
rewrite all_rows -rows_with_key; apply: grouped_have; rewrite rows_with_key; by case: (of_group a (cells T)) nonempty.
Qed.

Definition row_before (r s : row) : bool := Z.ltb (who r) (who s).

Lemma group_rows_sorted : sorted row_before (group_rows T (rows_of T)).
Proof. by rewrite /group_rows sorted_map; apply: sub_sorted (proj1 (groupedP _ _)). Qed.

Section OneGroup.
Variable a : Z.
Local Notation rs := (map (row_of T) (of_group a (cells T))).
Local Notation r := (row_of_group (Z.to_nat (decisions T)) a rs).

Lemma group_massE : group_mass R T a = ratio (bulk r).
Proof. by rewrite sum_of_masses1 /= ratio_sum !big_map. Qed.

Lemma group_meanE : positive_fraction (bulk r) -> group_mean R T a = ratio (mean r).
Proof.
move=> pos; rewrite /group_mean group_massE [mean _]/= ratio_times (ratio_inverse _ pos) mulrC; congr (_ * _).
rewrite (@sum_of_masses (fun x => expectation R T x a) (fun c => ratio (mean (row_of T c)))) => [|c cin <-]; last exact: expectationE.
by rewrite ratio_sum !big_map; apply: eq_bigr => c _; rewrite ratio_times.
Qed.

Lemma group_lawE u : u \in range (decisions T) -> positive_fraction (bulk r) -> group_law R T a u = number u (law_of r).
Proof.
rewrite mem_range => u_in pos.
rewrite /group_law group_massE [law_of _]/= number_times (ratio_inverse _ pos) mulrC number_column_sums //; congr (_ * _).
rewrite (@sum_of_masses (fun x => law R T x a u) (fun c => number u (law_of (row_of T c)))) => [|c cin <-]; last exact: lawE.
by rewrite !big_map; apply: eq_bigr => c _; rewrite [RHS]number_times.
Qed.

Lemma group_law_length : of_length (decisions T) (law_of r).
Proof.
rewrite /of_length map_length [length _](size_column_sums (Z.to_nat (decisions T))) Z2Nat.id ?Z.eqb_refl //.
by have := decisions_gt0; lia.
Qed.
End OneGroup.

Lemma fullE : full T = complete T.
Proof.
have posc : Z.le 0 (contexts T) by move: ok => /and5P[/Z.ltb_lt]; lia.
have posg : Z.le 0 (groups T) by move: ok => /and5P[_ /Z.ltb_lt]; lia.
pose pairs := [seq (context c, group c) | c <- cells T].
pose grid := [seq (x, a) | x <- range (contexts T), a <- range (groups T)].
have pairsP xa : reflect (has_cell T xa.1 xa.2) (xa \in pairs).
  apply: (iffP idP) => [|/has_cellP[c cin [cx ca]]].
    rewrite /pairs; elim: (cells T) (@has_cell_of) => //= c cs IH has_; rewrite in_cons => /orP[/eqP -> /=|]; first by apply: has_; left.
    by apply: IH => d din; apply: has_; right.
  have -> : xa = (context c, group c) by case: xa cx ca => x a /= -> ->.
  by rewrite /pairs; elim: (cells T) cin => //= d ds IH [->|/IH]; rewrite in_cons ?eqxx // => ->; rewrite orbT.
have uniq_pairs : uniq pairs.
  rewrite /pairs; elim: (cells T) cells_sorted => //= c cs IH srt; rewrite IH ?(path_sorted srt) // andbT.
  have := later_cell srt; elim: cs {IH srt} => //= d cs IH later; rewrite in_cons negb_or IH ?andbT => [|e ein]; last by apply: later; right.
  by apply/eqP => -[cd cd']; apply: (not_itself (later d (or_introl erefl))).
have sub : {subset pairs <= grid}.
  by move=> [x a] /pairsP/has_cellP[c cin [/= <- <-]]; apply/allpairsP; exists (context c, group c); rewrite context_inside ?group_inside.
have size_pairs : size pairs = size (cells T) by rewrite size_map.
have uniq_grid : uniq grid by apply: allpairs_uniq => [||[x a] [y b] _ _ [-> ->]] //; apply: range_uniq.
have size_grid : Z.of_nat (size grid) = Z.mul (contexts T) (groups T).
  by rewrite size_allpairs !size_range Nat2Z.inj_mul !Z2Nat.id.
have completeP : complete T = all (fun xa => xa \in pairs) grid.
  apply/allP/allP => [all_ [x a] /allpairsP[[y b] [yin bin [-> ->]]]|all_ x xin].
    by apply/pairsP; have /allP := all_ _ yin; apply.
  by apply/allP => a ain; apply/(pairsP (x, a))/all_/allpairsP; exists (x, a).
rewrite completeP; have -> : full T = Z.eqb (Z.of_nat (size pairs)) (Z.of_nat (size grid)) by rewrite size_pairs size_grid.
apply/Z.eqb_spec/allP => [/Nat2Z.inj e xa|all_].
  by have [_ ->] := uniq_min_size uniq_pairs sub (eq_leq (esym e)).
by congr Z.of_nat; apply/eqP; rewrite eqn_leq !uniq_leq_size.
Qed.
End Tables.
