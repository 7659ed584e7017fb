(* What is found to be left out is all that is left out. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures LeftOut ListsSound TableSound BlocksSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Lemma ltb_trans : transitive Z.ltb.
Proof. by move=> a b c /Z.ltb_lt ab /Z.ltb_lt bc; apply/Z.ltb_lt; lia. Qed.

Lemma same_sorted s t : sorted Z.ltb s -> sorted Z.ltb t -> s =i t -> s = t.
Proof. by apply: irr_sorted_eq; [apply: ltb_trans | apply: Z.ltb_irrefl]. Qed.

Lemma head_not_in a s : sorted Z.ltb (a :: s) -> a \notin s.
Proof. by move=> /= /(order_path_min ltb_trans)/allP all_; apply/negP => /all_; rewrite Z.ltb_irrefl. Qed.

Definition missing (all keys : list Z) : list Z := [seq a <- all | a \notin keys].

Lemma same_missingP all keys gs : sorted Z.ltb all -> sorted Z.ltb keys -> {subset keys <= all} ->
  same_missing all keys gs -> gs = missing all keys.
Proof.
elim: all keys gs => [|a all IH] keys gs srt srtk sub /=; first by case: gs.
have srt' := path_sorted srt; have a_out := head_not_in srt.
case: keys srtk sub => [|k ks] srtk sub.
  have e0 : {subset [::] <= all} by [].
  by case: gs => [|s ss] //; case: Z.eqb_spec => // -> /(IH [::] ss srt' isT e0) ->.
case: Z.eqb_spec => [ka|ka].
  rewrite ka in srtk sub *; move/(IH _ _ srt' (path_sorted srtk)) => ->.
    rewrite /missing [in RHS]/= mem_head /=; apply: eq_in_filter => b bin; rewrite in_cons.
    by case: eqP => // e; rewrite -e bin in a_out.
  move=> b bks; have := sub b; rewrite !in_cons bks orbT => /(_ isT)/orP[/eqP e|//].
  by have := head_not_in srtk; rewrite -e bks.
case: gs => [|s ss] //; case: Z.eqb_spec => // -> same.
have a_key : a \notin k :: ks.
  apply/negP; rewrite in_cons => /orP[/eqP e|ain]; first by case: ka.
  have := sub k; rewrite !in_cons eqxx => /(_ isT)/orP[/eqP e|kin]; first by case: ka.
  have := order_path_min ltb_trans srtk => /allP/(_ _ ain)/Z.ltb_lt lt1.
  by have := order_path_min ltb_trans srt => /allP/(_ _ kin)/Z.ltb_lt lt2; lia.
rewrite (IH _ _ srt' srtk _ same) => [|b bin]; first by rewrite /missing [in RHS]/= a_key.
by have := sub _ bin; rewrite in_cons => /orP[/eqP e|//]; rewrite -e bin in a_key.
Qed.

Definition of_missing (all : list Z) (xk : Z * list Z) : list left_out :=
  where_ (missing all xk.2 != [::]) (No_decisions xk.1 (missing all xk.2)).

Lemma after_missingP all xks stated rest : sorted Z.ltb all ->
  (forall xk, List.In xk xks -> sorted Z.ltb xk.2 /\ {subset xk.2 <= all}) ->
  ~~ existsb is_missing stated -> after_missing all xks stated = Some rest ->
  stated = flatten [seq of_missing all xk | xk <- xks] ++ rest.
Proof.
move=> srt; elim: xks stated => [|[x k] xks IH] stated keys none_empty /=; first by move=> [->].
have [srtk sub] := keys (x, k) (or_introl erefl).
have {}keys xk : List.In xk xks -> sorted Z.ltb xk.2 /\ {subset xk.2 <= all} by move=> xin; apply: keys; right.
rewrite /stated_missing /of_missing /=; case: stated none_empty => [|e es] none_empty.
  case same: (same_missing all k [::]) => // /(IH _ keys none_empty) ->.
  by rewrite -(same_missingP srt srtk sub same) /=.
have skip : (if same_missing all k [::] then after_missing all xks (e :: es) else None) = Some rest ->
    e :: es = where_ (missing all k != [::]) (No_decisions x (missing all k)) ++ flatten [seq of_missing all xk | xk <- xks] ++ rest.
  case same: (same_missing all k [::]) => // /(IH _ keys none_empty) ->.
  by rewrite -(same_missingP srt srtk sub same) /=.
rewrite -catA; case: e none_empty skip => [y gs|y|gs|||r y gs|r y] none_empty skip //.
case: Z.eqb_spec => [yx|_]; last exact: skip.
move: none_empty; rewrite /= negb_or => /andP[nonempty none_empty].
case same: (same_missing all k gs) => // /(IH _ keys none_empty) ->.
by rewrite -(same_missingP srt srtk sub same) yx; case: (gs) nonempty.
Qed.

Lemma alignedP xs F (w : Z -> list Z) : sorted Z.ltb xs -> sorted row_run_before F ->
  (forall k, List.In k F -> k.1 \in xs /\ map who k.2 = w k.1) ->
  (forall x, x \in xs -> (forall rs, ~ List.In (x, rs) F) -> w x = [::]) ->
  aligned xs F = [seq (x, w x) | x <- xs].
Proof.
elim: xs F => //= x xs IH F srt srtF rows none.
have x_out := head_not_in srt; have srt' := path_sorted srt.
case: F srtF rows none => [|[y rs] more] srtF rows none.
  have -> : w x = [::] by apply: none => [|rs []]; rewrite ?mem_head.
  congr (_ :: _); apply: IH => // x' x'in _; apply: none => [|rs []].
  by rewrite in_cons x'in orbT.
have later k : List.In k more -> Z.lt y k.1.
  have tr : transitive row_run_before by move=> a b c /Z.ltb_lt ab /Z.ltb_lt bc; apply/Z.ltb_lt; lia.
  have := order_path_min tr srtF; elim: (more) => //= l ls IH' /andP[/Z.ltb_lt yl all_] [<-|/(IH' all_)] //.
have [y_in y_who] := rows (y, rs) (or_introl erefl); have {}y_who : List.map who rs = w y := y_who.
have greater k : List.In k more -> k.1 \in x :: xs by move=> kin; have [] := rows k (or_intror kin).
have x_least z : z \in xs -> Z.lt x z by move=> zin; have := order_path_min ltb_trans srt => /allP/(_ _ zin)/Z.ltb_lt.
case: Z.eqb_spec => [yx|yx].
  rewrite -yx y_who; congr (_ :: _); apply: IH => // [|k kin|x' x'in nobody]; first exact: path_sorted srtF.
    have [kx kw] := rows k (or_intror kin); split=> //.
    by move: kx; rewrite in_cons => /orP[/eqP e|//]; have := later _ kin; rewrite e yx; lia.
  apply: none => [|rs' [[e _]|/nobody //]]; first by rewrite in_cons x'in orbT.
  by rewrite -yx e x'in in x_out.
have y_xs : y \in xs by move: y_in; rewrite in_cons => /orP[/eqP e|//]; case: yx.
have -> : w x = [::].
  by apply: none => [|rs' [[e _]|kin]]; [rewrite mem_head | case: yx | have := later _ kin; have := x_least _ y_xs; rewrite /=; lia].
congr (_ :: _); apply: IH => // [k [<-|kin]|x' x'in nobody]; first by split.
  have [kx kw] := rows k (or_intror kin); split=> //.
  by move: kx; rewrite in_cons => /orP[/eqP e|//]; have := later _ kin; have := x_least _ y_xs; rewrite e; lia.
by apply: none => //; rewrite in_cons x'in orbT.
Qed.

Section Tables.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation F := (rows_of T).
Local Notation A := (group_rows T F).

Lemma who_filter (P : row -> bool) (p : pred Z) rs : sorted row_before rs ->
  (forall a, (a \in range (groups T)) && p a <-> exists2 r, List.In r rs /\ P r & who r = a) ->
  map who (filter P rs) = [seq a <- range (groups T) | p a].
Proof.
move=> srt same; apply: same_sorted.
- rewrite sorted_map; apply: sorted_filter srt.
  by move=> r s t /Z.ltb_lt rs' /Z.ltb_lt st; apply/Z.ltb_lt; lia.
- exact: (sorted_filter ltb_trans) (range_sorted _).
move=> a; rewrite mem_filter andbC; apply/idP/idP => [ain|/same[r [rin Pr] <-]].
  apply/same; elim: (rs) ain => //= r s IH; case: ifP => Pr; last by move=> /IH[t [tin Pt] e]; exists t => //; split=> //; right.
  rewrite in_cons => /orP[/eqP ->|/IH[t [tin Pt] e]]; first by exists r => //; split=> //; left.
  by exists t => //; split=> //; right.
elim: (rs) rin => //= s t IH [->|/IH in_]; first by rewrite Pr in_cons eqxx.
by case: ifP => // _; rewrite in_cons in_ orbT.
Qed.

Lemma who_context x rs : List.In (x, rs) F -> map who rs = with_cell T x.
Proof.
move=> xin; have [-> _] := rows_of_in ok xin; rewrite -[map (row_of T) _]filter_predT; apply: who_filter.
  exact: context_rows_sorted.
move=> a; split=> [/andP[_ /(has_cellP ok)[c cin [cx ca]]]|[r [rin _] <-]].
  exists (row_of T c) => //; split=> //; apply: in_map.
  by apply/in_filter_seq; split=> //; apply/Z.eqb_eq.
move: rin => /in_map_iff[c [<- /in_context_in[cin <-]]] /=.
by rewrite (group_inside ok) // has_cell_of.
Qed.

Lemma aligned_rows : aligned (range (contexts T)) F = [seq (x, with_cell T x) | x <- range (contexts T)].
Proof.
apply: alignedP; [exact: range_sorted | exact: rows_of_sorted | |].
  by move=> [x rs] xin; split; [have [] := rows_of_in ok xin | apply: who_context].
move=> x _ nobody; rewrite /with_cell -(filter_pred0 (range (groups T))); apply: eq_filter => a /=; apply/negP => xa.
exact: (nobody _ (rows_of_have ok xa)).
Qed.

Lemma occurs_row a : (a \in range (groups T)) && occurs T a <-> exists2 r, List.In r A & who r = a.
Proof.
split=> [/andP[_ /hasP[x _ /(has_cellP ok)[c cin [_ ca]]]]|[r rin <-]].
  have nonempty : of_group a (cells T) <> [::].
    have : List.In c (of_group a (cells T)) by apply/in_filter_seq; split=> //; apply/Z.eqb_eq.
    by case: (of_group a (cells T)).
  by exists (row_of_group (Z.to_nat (decisions T)) a (map (row_of T) (of_group a (cells T)))) => //; apply: group_rows_have.
have [_ nonempty] := group_rows_in rin; case e: (of_group (who r) (cells T)) nonempty => [|c cs] // _.
have /in_filter_seq[cin /Z.eqb_eq <-] : List.In c (of_group (who r) (cells T)) by rewrite e; left.
rewrite (group_inside ok cin); apply/hasP; exists (context c); [exact: context_inside | exact: has_cell_of].
Qed.

Lemma mass_of_row r : List.In r A -> (0 < group_mass R T (who r)) = positive_fraction (bulk r).
Proof. by move=> rin; have [re _] := group_rows_in rin; rewrite (positive_fractionE R) (group_massE R ok) -re. Qed.

Lemma mass_occurs a : 0 < group_mass R T a -> occurs T a.
Proof.
rewrite (sum_of_masses1 R ok); case e: (of_group a (cells T)) => [|c cs]; first by rewrite big_nil ltxx.
move=> _; have /in_filter_seq[cin /Z.eqb_eq <-] : List.In c (of_group a (cells T)) by rewrite e; left.
by apply/hasP; exists (context c); [exact: context_inside | exact: has_cell_of].
Qed.

Lemma populated_rows : map who (filter (fun r => positive_fraction (bulk r)) A) = populated R T.
Proof.
apply: who_filter => [|a]; first exact: group_rows_sorted.
split=> [/andP[ain mass0]|[r [rin pos] <-]]; last first.
  have /andP[-> _] : (who r \in range (groups T)) && occurs T (who r) by apply/occurs_row; exists r.
  by rewrite mass_of_row.
have [r rin e] : exists2 r, List.In r A & who r = a by apply/occurs_row; rewrite ain mass_occurs.
by exists r => //; split=> //; rewrite -mass_of_row // e.
Qed.

Lemma empty_rows : map who (filter (fun r => negb (positive_fraction (bulk r))) A) =
  [seq a <- range (groups T) | occurs T a && ~~ (0 < group_mass R T a)].
Proof.
apply: who_filter => [|a]; first exact: group_rows_sorted.
split=> [/and3P[ain oc mass0]|[r [rin pos] <-]]; last first.
  have /andP[-> ->] : (who r \in range (groups T)) && occurs T (who r) by apply/occurs_row; exists r.
  by rewrite mass_of_row.
have [r rin e] : exists2 r, List.In r A & who r = a by apply/occurs_row; rewrite ain oc.
by exists r => //; split=> //; rewrite -mass_of_row // e.
Qed.

Lemma two_ofE A' (s : list A') : two_of s = (1 < size s)%N. Proof. by case: s => [|x [|y s]]. Qed.

Lemma empty_rows' : List.map who (List.filter (fun r => negb (positive_fraction (bulk r))) A) =
  [seq a <- range (groups T) | occurs T a && ~~ (0 < group_mass R T a)].
Proof. exact: empty_rows. Qed.

Lemma two_populated : two_of (List.filter (fun r => positive_fraction (bulk r)) A) = at_least_two (populated R T).
Proof. by rewrite two_ofE -populated_rows /at_least_two size_map. Qed.

Lemma missing_without x : missing (range (groups T)) (with_cell T x) = without_cell T x.
Proof. by apply: eq_in_filter => a ain; rewrite mem_filter ain andbT. Qed.

Lemma same_entriesP es fs : same_entries es fs -> es = fs.
Proof.
elim: es fs => [|e es IH] [|f fs] //=; case same: (same_entry e f) => // /IH ->; congr (_ :: _).
have same_numbers xs ys : (fix same (xs ys : list Z) : bool :=
    match xs, ys with x :: xs, y :: ys => if Z.eqb x y then same xs ys else false | [::], [::] => true | _, _ => false end) xs ys -> xs = ys.
  by elim: xs ys => [|x xs IH'] [|y ys] //; case: Z.eqb_spec => // -> /IH' ->.
case: e f same => [x gs|x|gs|||r x gs|r x] [y hs|y|hs|||s y hs|s y] //=.
- by case/andP => /Z.eqb_eq -> /same_numbers ->.
- by move/Z.eqb_eq ->.
- by move/same_numbers ->.
- by case/and3P => /Z.eqb_eq -> /Z.eqb_eq -> /same_numbers ->.
- by case/andP => /Z.eqb_eq -> /Z.eqb_eq ->.
Qed.

(* What is said of rates is proved in RatesSound.v. *)
Definition all_rates_left_out : list left_out :=
  if known T is Some K then
    flatten [seq flatten [seq rate_left_out R T r x | x <- range (contexts T)] ++ (if pooled K then rate_left_out R T r nothing else [::])
            | r <- [:: true_positives; false_positives]]
  else [::].

Lemma left_out_sound stated : rates_left_out T = all_rates_left_out -> left_out_as_stated T F A stated -> stated = all_left_out R T.
Proof.
move=> of_rates; rewrite /left_out_as_stated aligned_rows; case none_empty: (existsb is_missing stated) => //.
case after: (after_missing _ _ _) => [rest|] // /same_entriesP e.
rewrite (after_missingP (range_sorted _) _ (negbT none_empty) after); last first.
  move=> xk /in_map_iff[x [<- _]] /=; split; first exact: (sorted_filter ltb_trans) (range_sorted _).
  by move=> a; rewrite mem_filter => /andP[].
rewrite /all_left_out -map_comp; congr (_ ++ _).
  by congr flatten; apply: eq_map => x; rewrite /= /of_missing /= missing_without.
have appE (s t : list left_out) : (s ++ t)%list = s ++ t by [].
rewrite e /further_left_out of_rates !appE -!catA; congr (_ ++ _).
  elim: (range (contexts T)) => //= x xs ->; congr (_ ++ _).
  by rewrite two_ofE /at_least_two; case: (_ < _)%N.
rewrite empty_rows' two_populated (with_meansE ok); congr (_ ++ _).
by case: [seq _ <- _ | _].
Qed.
End Tables.
