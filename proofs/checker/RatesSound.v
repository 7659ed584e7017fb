(* Rates given the true label: those that are listed, their greatest differences, and what is not compared by them. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures LeftOut Checker.
From FairauditChecker Require Import ListsSound TableSound WidestSound BlocksSound FiguresSound LeftOutSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- Lists ---- *)

Lemma numberedE A (d : A) xs : numbered xs = [seq (Z.of_nat i, nth d xs i) | i <- iota 0 (size xs)].
Proof.
suff from m : combine (List.map Z.of_nat (List.seq m (length xs))) xs = [seq (Z.of_nat (m + i), nth d xs i) | i <- iota 0 (size xs)] by exact: from.
elim: xs m => //= x xs IH m; rewrite addn0 IH (iotaDl 1 0) -map_comp; congr (_ :: _).
by apply: eq_map => i /=; rewrite addnS.
Qed.

Lemma flat_mapE A B (f : A -> list B) s : List.flat_map f s = flatten [seq f x | x <- s].
Proof. by elim: s => //= x s ->. Qed.

(* What nobody stands for is skipped. *)
Lemma flatten_keys A (g : Z -> list A) xs keys : sorted Z.ltb xs -> sorted Z.ltb keys -> {subset keys <= xs} ->
  (forall x, x \in xs -> x \notin keys -> g x = [::]) -> flatten [seq g x | x <- keys] = flatten [seq g x | x <- xs].
Proof.
move=> srt srtk sub none.
have -> : keys = [seq x <- xs | x \in keys].
  apply: same_sorted => // [|x]; first exact: (sorted_filter ltb_trans).
  by rewrite mem_filter; case xk: (x \in keys) => //; rewrite (sub _ xk).
elim: xs none {srt sub} => //= x xs IH none.
have {}IH := IH (fun y yin => none y (mem_behead (yin : y \in behead (x :: xs)))).
case xk: (x \in keys); first by rewrite /= IH.
by rewrite IH none ?mem_head ?xk.
Qed.

Lemma in_mapE (A : Type) (B : eqType) (f : A -> B) s b : b \in map f s <-> exists2 x, List.In x s & f x = b.
Proof.
elim: s => [|x s [IH1 IH2]] /=; first by split=> // -[].
rewrite in_cons; split; last by case=> y [->|yin] e; [rewrite e eqxx | rewrite IH2 ?orbT //; exists y].
by case/orP => [/eqP ->|/IH1[y yin e]]; [exists x; [left|] | exists y; [right|]].
Qed.

Lemma in_seqE (A : eqType) (x : A) s : x \in s <-> List.In x s.
Proof. by rewrite -[s in x \in s]map_id in_mapE; split=> [[y yin <-]|xin] //; exists x. Qed.

(* Whether anything was found in some block *)
Lemma best_of_some f bs :
  if best_of f bs is Some _ then exists2 b, List.In b bs & f b <> None else forall b, List.In b bs -> f b = None.
Proof.
rewrite /best_of; suff from acc : if fold_left (fun best b => better best (f b)) bs acc is Some _ then acc <> None \/ exists2 b, List.In b bs & f b <> None
    else acc = None /\ forall b, List.In b bs -> f b = None.
  by have := from None; case: (fold_left _ _ _) => [n|] [].
elim: bs acc => [|b bs IH] acc /=; first by case: acc => [n|]; [left | split].
have := IH (better acc (f b)); case: (fold_left _ _ _) => [n|[none nobody]].
  case=> [|[c cin fc]]; last by right; exists c => //; right.
  by case fb: (f b) => [m|]; [right; exists b; [left | rewrite fb] | case: (acc) => [m|] //; left].
have [-> fb] : acc = None /\ f b = None by move: none; case: (acc) => [?|]; case: (f b) => [?|] //=; case: ifP.
by split=> // c [<-|/nobody].
Qed.

Section Rates.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Variable K : truth.
Hypothesis known_ : known T = Some K.
Local Notation ratio := (@ratio R).
Local Notation number := (@ListsSound.number R).
Local Notation all_draws := (all_draws R T).

(* ---- What is counted of a cell ---- *)

Lemma increasingE us : increasing us = sorted Z.ltb us.
Proof. by elim: us => // u [|v us] // IH; rewrite -[LHS]/(Z.ltb u v && increasing (v :: us)) IH. Qed.

Lemma positive_increasing : sorted Z.ltb (positive_decisions K).
Proof. by move: ok => /and5P[_ _ _ _ /and4P[_ + _ _]]; rewrite known_ => /and4P[_ _ _]; rewrite increasingE. Qed.

Lemma ratio_picked us row : sorted Z.ltb us -> all (Z.leb Z0) us ->
  ratio (total (picked_onto [::] Z0 us row)) = \sum_(u <- us) number u row.
Proof.
rewrite ratio_total; suff from i done : sorted Z.ltb us -> all (Z.leb i) us ->
    \sum_(q <- picked_onto done i us row) ratio q = \sum_(q <- done) ratio q + \sum_(u <- us) number (Z.sub u i) row.
  by move=> srt above; rewrite from // big_nil add0r; apply: eq_bigr => u _; rewrite Z.sub_0_r.
elim: row us i done => [|q row IH] us i done srt above.
  have -> : picked_onto done i us [::] = done by case: us {srt above}.
  by rewrite [X in _ + X]big1 ?addr0 // => u _; rewrite /number; case: (Z.to_nat _) => [|n]; rewrite ratio_zero.
case: us srt above => [|u us] srt /=; first by rewrite big_nil addr0.
case/andP => /Z.leb_le iu above.
have later v : Z.lt i v -> number (Z.sub v i) (q :: row) = number (Z.sub v (Z.add i 1)) row.
  by move=> iv; rewrite /number (_ : Z.to_nat (Z.sub v i) = (Z.to_nat (Z.sub v (Z.add i 1))).+1) //; lia.
have after v : v \in us -> Z.lt u v by move=> vin; have := order_path_min ltb_trans srt => /allP/(_ _ vin)/Z.ltb_lt.
case: Z.eqb_spec => [ui|ui].
  rewrite IH; [|exact: path_sorted srt|by apply/allP => v /after uv; apply/Z.leb_le; lia].
  have at_once : number Z0 (q :: row) = ratio q by [].
  rewrite !big_cons ui Z.sub_diag at_once addrA [in RHS](addrC (\sum_(_ <- done) _)); congr (_ + _).
  by apply: eq_big_seq => v /after uv; rewrite later //; lia.
rewrite IH //; last first.
  by apply/allP => v; rewrite in_cons => /orP[/eqP ->|/after uv]; apply/Z.leb_le; lia.
congr (_ + _); apply: eq_big_seq => v; rewrite in_cons => /orP[/eqP ->|/after uv]; rewrite later //; lia.
Qed.

Lemma truth_lengths c : List.In c (cells T) ->
  of_length (labels K) (by_truth c) /\ forall row, List.In row (by_truth c) -> of_length (decisions T) row.
Proof.
move=> /(cells_valid ok)/and5P[_ _ _ _ /and4P[_ _ _]]; rewrite /valid_truth known_.
by case/and4P => len /forallb_forall rows _ _; split.
Qed.

Definition kept (r : Z) (xs : list (list Q)) : list (list Q) :=
  map snd (filter (fun t => Bool.eqb (Z.eqb t.1 (positive_label K)) (Z.eqb r true_positives)) (numbered xs)).

Lemma sum_wanted r xs (f : list Q -> R) : of_length (labels K) xs ->
  \sum_(t <- wanted K r) f (List.nth (Z.to_nat t) xs nil) = \sum_(row <- kept r xs) f row.
Proof.
move=> /of_lengthP[_ size_]; rewrite /wanted /kept big_filter rangeE !big_map big_filter (numberedE nil) big_map size_.
apply: eq_big => i /=; last by rewrite Nat2Z.id nthE.
have eqE (y z : Z) : (y == z) = Z.eqb y z by [].
by rewrite !eqE; case: (Z.eqb (Z.of_nat i) _); case: (Z.eqb r _).
Qed.

Lemma countedE r c : counted K r c =
  (group c, (total (map total (kept r (by_truth c))),
             total (map (fun row => total (picked_onto [::] Z0 (positive_decisions K) row)) (kept r (by_truth c))))).
Proof. by []. Qed.

Lemma kept_in r xs row : List.In row (kept r xs) -> List.In row xs.
Proof. by case/in_map_iff => -[i row'] [/= <-] /in_filter_seq[+ _]; apply: in_combine_r. Qed.

Lemma labelledE r x a us : labelled R T r x a us = if cell_at T x a is Some c then \sum_(row <- kept r (by_truth c)) \sum_(u <- us K) number u row else 0.
Proof.
rewrite /labelled known_; case e: (cell_at T x a) => [c|] //; have [cin _ _] := cell_atP e; have [len _] := truth_lengths cin.
exact: (sum_wanted r (fun row => \sum_(u <- us K) number u row) len).
Qed.

Lemma drawsE r x a : draws R T r x a = if cell_at T x a is Some c then ratio (counted K r c).2.1 else 0.
Proof.
rewrite /draws labelledE; case e: (cell_at T x a) => [c|] //; have [cin _ _] := cell_atP e; have [_ rows] := truth_lengths cin.
rewrite countedE /= ratio_total big_map; apply: eq_sum_in => row /kept_in/rows len.
by rewrite ratio_total sum_number.
Qed.

Lemma positivesE r x a : positives R T r x a = if cell_at T x a is Some c then ratio (counted K r c).2.2 else 0.
Proof.
rewrite /positives labelledE; case e: (cell_at T x a) => [c|] //.
rewrite countedE /= ratio_total big_map; apply: eq_bigr => row _.
rewrite ratio_picked //; first exact: positive_increasing.
by apply/allP => u /in_seqE; move: ok => /and5P[_ _ _ _ /and4P[_ + _ _]]; rewrite known_ => /and4P[_ _ /forallb_forall inside_ _] /inside_/andP[].
Qed.

(* ---- Of each context, and of all of them together ---- *)

Definition here (x a : Z) : bool := if x == nothing then occurs T a else has_cell T x a.

(* All groups that have a cell, in order, with the numbers that Meaning.v has *)
Definition counted_right (r x : Z) (ts : list (Z * (Q * Q))) : Prop :=
  map fst ts = [seq a <- range (groups T) | here x a]
  /\ forall t, List.In t ts -> all_draws r x t.1 = ratio t.2.1 /\ over_contexts T (fun y => positives R T r y t.1) x = ratio t.2.2.

Lemma context_something x : x \in range (contexts T) -> (x == nothing) = false.
Proof. by rewrite mem_range => /andP[/Z.leb_le le _]; apply/eqP; rewrite /nothing => e; lia. Qed.

Lemma counted_in_right r x ts : List.In (x, ts) (counted_in T K r) -> x \in range (contexts T) /\ counted_right r x ts.
Proof.
case/in_map_iff => -[y cs] [[<- <-] yin]; have [csE _] := (proj2 (runs_of_cells ok)) _ _ yin; rewrite csE in yin *.
have rin : List.In (y, map (row_of T) (in_context T y)) (rows_of T).
  by apply/in_map_iff; exists (y, in_context T y).
have [_ y_in] := rows_of_in ok rin; split=> //=; have y_some := context_something y_in; split.
  rewrite -map_comp [LHS](_ : _ = map group (in_context T y)) //; have := who_context ok rin; rewrite -map_comp [LHS]/= => ->.
  by apply: eq_filter => a; rewrite /here y_some.
move=> t /in_map_iff[c [<- /in_context_in[cin cx]]]; rewrite /all_draws /over_contexts y_some drawsE positivesE -cx.
by rewrite [(counted K r c).1]/= (cell_of ok cin).
Qed.

Lemma over_all (F : cell -> R) (f : Z -> Z -> R) a : (forall x, f x a = if cell_at T x a is Some c then F c else 0) ->
  over_contexts T (fun y => f y a) nothing = \sum_(c <- of_group a (cells T)) F c.
Proof. by move=> fE; rewrite /over_contexts eqxx -(sum_over_cells ok); apply: eq_bigr => x _. Qed.

Lemma added_draws a cs : ratio (added a cs).2.1 = \sum_(c <- cs) ratio c.1.
Proof. by rewrite /added ratio_sum big_map. Qed.

Lemma added_positives a cs : ratio (added a cs).2.2 = \sum_(c <- cs) ratio c.2.
Proof. by rewrite /added ratio_sum big_map. Qed.

Lemma counted_over_right r : counted_right r nothing (map (fun ats => added ats.1 (List.map snd ats.2)) (grouped fst (List.map (counted K r) (cells T)))).
Proof.
set G := grouped _ _; have [srt inG] : sorted (@run_before (Z * (Q * Q))) G /\ forall a ts, List.In (a, ts) G ->
    ts = map (counted K r) (of_group a (cells T)) /\ ts <> [::].
  have [srt inG] := groupedP fst (List.map (counted K r) (cells T)); split=> // a ts /inG[-> nonempty]; split=> //.
  by rewrite /with_key filter_map.
split; last first.
  move=> t tin; have [a [ts [/inG[-> _] ->]]] : exists a ts, List.In (a, ts) G /\ t = added a (List.map snd ts).
    by move/in_map_iff: tin => -[[a ts] [<- ain]]; exists a, ts.
  split; [rewrite (added_draws a) !big_map | rewrite (added_positives a) !big_map].
    by apply: (over_all (f := draws R T r)) => x; exact: drawsE.
  by apply: (over_all (f := positives R T r)) => x; exact: positivesE.
rewrite -map_comp [LHS](_ : _ = map fst G) //; apply: same_sorted.
- by rewrite sorted_map.
- exact: (sorted_filter ltb_trans) (range_sorted _).
move=> a; rewrite mem_filter /here eqxx; apply/idP/idP => [/in_mapE[[b ts] /inG[tsE nonempty] /= <-]|/andP[/hasP[x _ /(has_cellP ok)[c cin [_ ca]]] _]].
  case e: (of_group b (cells T)) tsE nonempty => [|c cs] -> // _.
  have /in_filter_seq[cin /Z.eqb_eq <-] : List.In c (of_group b (cells T)) by rewrite e; left.
  rewrite (group_inside ok cin) andbT; apply/hasP; exists (context c); [exact: context_inside | exact: has_cell_of].
have nonempty : with_key fst a (List.map (counted K r) (cells T)) <> [::].
  rewrite /with_key filter_map => /(congr1 size); rewrite size_map => /size0nil e.
  have : List.In c (of_group a (cells T)) by apply/in_filter_seq; split=> //; apply/Z.eqb_eq.
  by rewrite /of_group e.
by apply/in_mapE; exists (a, with_key fst a (List.map (counted K r) (cells T))); [exact: grouped_have|].
Qed.

Lemma countsP r o :
  [/\ sorted Z.ltb (map fst (counts T K r o)), {subset map fst (counts T K r o) <= contexts_or_none T o},
      forall b, List.In b (counts T K r o) -> counted_right r b.1 b.2
    & forall x a, x \in contexts_or_none T o -> here x a -> x \in map fst (counts T K r o)].
Proof.
case: o; split=> //=.
- by move=> b [<-|[]]; apply: counted_over_right.
- by rewrite /counted_in -map_comp sorted_map; apply: sub_sorted (proj1 (runs_of_cells ok)).
- by move=> x /in_mapE[[y ts] /counted_in_right[yin _] <-].
- by move=> [x ts] /counted_in_right[].
move=> x a xin; rewrite /here (context_something xin) => /(has_cellP ok)[c cin [cx _]].
have [cs csin] := runs_have context cin; apply/in_mapE; exists (x, map (counted K r) cs) => //.
by apply/in_map_iff; exists (x, cs); split=> //; rewrite -cx.
Qed.

Lemma draws_here r x a : 0 < all_draws r x a -> here x a.
Proof.
have none y : ~~ has_cell T y a -> draws R T r y a = 0 by rewrite drawsE /has_cell; case: (cell_at T y a).
rewrite /all_draws /over_contexts /here; case: ifP => _; last by apply: contraTT => /none ->; rewrite ltxx.
apply: contraTT => /hasPn nobody; rewrite big1_seq ?ltxx // => y /andP[_ /nobody]; exact: none.
Qed.

Lemma drawnE r x ts t : counted_right r x ts -> List.In t ts -> drawn t = (0 < all_draws r x t.1).
Proof. by case=> _ numbers /numbers[-> _]; rewrite /drawn (positive_fractionE R). Qed.

Lemma filter_keys (P : Z * (Q * Q) -> bool) (p : pred Z) ts : (forall t, List.In t ts -> P t = p t.1) -> map fst (filter P ts) = filter p (map fst ts).
Proof.
elim: ts => //= t ts IH same; rewrite same; last by left.
by rewrite -IH => [|u uin]; [case: ifP | apply: same; right].
Qed.

Lemma drawn_groups r x ts : counted_right r x ts -> map fst (filter drawn ts) = [seq a <- range (groups T) | 0 < all_draws r x a].
Proof.
move=> right_; rewrite (@filter_keys drawn (fun a => 0 < all_draws r x a)) => [|t tin]; last exact: (drawnE right_).
case: right_ => -> _; rewrite -filter_predI; apply: eq_filter => a /=.
by case pos: (0 < _) => //=; rewrite (draws_here pos).
Qed.

Lemma rate_ofE r x ts t : counted_right r x ts -> List.In t (filter drawn ts) -> rate R T r x t.1 = ratio (rate_of t).2.
Proof.
move=> [_ numbers] /in_filter_seq[/numbers[draws_ positives_] pos].
by rewrite /rate draws_ positives_ /= ratio_times ratio_inverse.
Qed.

(* ---- The rates that are listed ---- *)

Lemma rates_in_keys r o : map fst (rates_in T r o) = [seq xa <- rate_places T o | 0 < all_draws r xa.1 xa.2].
Proof.
have [srt sub rights all_here] := countsP r o.
pose g x := [seq (x, a) | a <- [seq a <- range (groups T) | 0 < all_draws r x a]].
have srt' : sorted Z.ltb (contexts_or_none T o) by case: (o) => //=; apply: range_sorted.
transitivity (flatten [seq g x | x <- contexts_or_none T o]); last first.
  rewrite /rate_places /contexts_or_none; case: (o) => /=; first by rewrite cats0 filter_map.
  by rewrite filter_flatten -map_comp; congr flatten; apply: eq_map => x /=; rewrite filter_map.
rewrite -(flatten_keys srt' srt sub); last first.
  move=> x xin x_out; rewrite /g (@eq_filter _ _ pred0) ?filter_pred0 // => a; apply: contraNF x_out => /draws_here; exact: all_here.
rewrite /rates_in known_ flat_mapE; elim: (counts T K r o) rights => //= b bs IH rights.
rewrite map_cat IH => [|c cin]; last by apply: rights; right.
congr (_ ++ _); rewrite /g -(drawn_groups (rights b (or_introl erefl))) -!map_comp; exact: eq_map.
Qed.

Lemma rates_in_values r o t : List.In t (rates_in T r o) -> rate R T r t.1.1 t.1.2 = ratio t.2.
Proof.
have [_ _ rights _] := countsP r o; rewrite /rates_in known_ => /in_flat_map[b [/rights b_right /in_map_iff[u [<- uin]]]].
exact: rate_ofE uin.
Qed.

Lemma rates_sound r o rates : rates_as_stated T r o rates -> rates_hold R T r o rates.
Proof.
rewrite /rates_as_stated known_ => same.
have [keys values] : map fst rates = map fst (rates_in T r o) /\
    forall t, List.In t rates -> exists2 u, List.In u (rates_in T r o) & t.1 = u.1 /\ ratio t.2 = ratio u.2.
  elim: rates (rates_in T r o) same => [|t ts IH] [|u us] //= ; case same_t: (same_rate t u) => // /IH[keys values].
  have [key value] : t.1 = u.1 /\ ratio t.2 = ratio u.2.
    by move: same_t => /and3P[/Z.eqb_eq e /Z.eqb_eq e' /(same_valueE R) ->]; split=> //; case: (t.1) (u.1) e e' => [? ?] [? ?] /= -> ->.
  by split=> [|v [<-|/values[w win ?]]]; [rewrite keys key | exists u; [left|] | exists w; [right|]].
split; [by rewrite known_ | by rewrite keys rates_in_keys |].
by move=> t /values[u uin [-> ->]]; apply: rates_in_values uin.
Qed.

(* ---- Who is not compared ---- *)

Lemma without_rateE r x ts : counted_right r x ts -> without_rate r x ts = rate_left_out R T r x.
Proof.
move=> right_; have [keys _] := right_; pose H := [seq a <- range (groups T) | here x a].
have lacking : List.map fst (List.filter (fun t => negb (drawn t)) ts) = [seq a <- H | ~~ (0 < all_draws r x a)].
  by rewrite /H -keys; apply: filter_keys => t /(drawnE right_) ->.
have two_here : two_of ts = at_least_two H by rewrite two_ofE /H -keys /at_least_two size_map.
have two_drawn : two_of (List.filter drawn ts) = at_least_two [seq a <- H | 0 < all_draws r x a].
  by rewrite two_ofE /H -keys -(@filter_keys drawn) ?/at_least_two ?size_map // => t; apply: drawnE.
rewrite /without_rate lacking two_here two_drawn /rate_left_out -/H.
by set L := [seq a <- H | ~~ _]; congr (_ ++ _); case: L.
Qed.

Lemma rates_left_outE : rates_left_out T = all_rates_left_out R T.
Proof.
have part r o : flatten [seq without_rate r b.1 b.2 | b <- counts T K r o] = flatten [seq rate_left_out R T r x | x <- contexts_or_none T o].
  have [srt sub rights all_here] := countsP r o.
  have srt' : sorted Z.ltb (contexts_or_none T o) by case: (o) => //=; apply: range_sorted.
  rewrite -(flatten_keys srt' srt sub) => [|x xin x_out].
    rewrite -map_comp; congr flatten; elim: (counts T K r o) rights => //= b bs IH rights.
    by rewrite IH => [|c cin]; [rewrite without_rateE //; apply: rights; left | apply: rights; right].
  rewrite /rate_left_out -/(here x) (@eq_in_filter _ (here x) pred0) ?filter_pred0 // => a _.
  by apply: contraNF x_out; apply: all_here.
rewrite /rates_left_out /all_rates_left_out known_ flat_mapE; congr flatten; apply: eq_map => r.
rewrite flat_mapE map_cat flatten_cat part; congr (_ ++ _).
by case: (pooled K) => //; rewrite part /= cats0.
Qed.

(* ---- The greatest differences ---- *)

Definition of_rate (q : quantity) : bool := match q with Equal_opportunity _ | Odds_given_truth _ => true | _ => false end.

Lemma rate_block q r x ts : of_rate q -> (r, x, nothing) \in settings T q -> counted_right r x ts -> right R T q (of_rates r x ts).
Proof.
move=> oq s_in right_; have keys := drawn_groups right_.
have part a : takes_part R T q (r, x, nothing) a = (a \in [seq a <- range (groups T) | 0 < all_draws r x a]).
  by rewrite mem_filter andbC; case: q oq {s_in}.
split=> //.
- have : sorted Z.ltb (map fst (filter drawn ts)) by rewrite keys; apply: (sorted_filter ltb_trans) (range_sorted _).
  by rewrite /of_rates /= !sorted_map.
- move=> a; rewrite -[at_ _]/(r, x, nothing) part -keys in_mapE; split=> [[t tin <-]|[e /in_map_iff[t [<- tin]] <-]]; last by exists t.
  by exists (rate_of t) => //; apply: in_map.
- move=> e /in_map_iff[t [<- tin]]; rewrite -(rate_ofE right_ tin).
  by case: q oq {s_in part}.
Qed.

Definition rate_blocks (rs : list Z) (o : bool) : list block := List.flat_map (fun r => List.map (fun b => of_rates r b.1 b.2) (counts T K r o)) rs.

Lemma rate_blocks_in rs o b : List.In b (rate_blocks rs o) ->
  exists r x ts, [/\ r \in rs, x \in contexts_or_none T o, counted_right r x ts & b = of_rates r x ts].
Proof.
case/in_flat_map => r [rin /in_map_iff[[x ts] [<- xin]]]; have [_ sub rights _] := countsP r o.
exists r, x, ts; split=> //; last exact: (rights (x, ts)).
  exact/in_seqE.
by apply: sub; apply/in_mapE; exists (x, ts).
Qed.

Section Covered.
Variables (q : quantity) (o : bool) (rs : list Z).
Hypothesis oq : of_rate q.
Hypothesis srt : sorted Z.ltb rs.
Hypothesis settingsE : forall s, s \in settings T q <-> exists r x, [/\ r \in rs, x \in contexts_or_none T o & s = (r, x, nothing)].

Lemma rate_blocks_right b : List.In b (rate_blocks rs o) -> right R T q b.
Proof.
case/rate_blocks_in => r [x [ts [rin xin right_ ->]]]; apply: rate_block => //.
by apply/settingsE; exists r, x.
Qed.

Lemma compared_in_block p : compares R T q p ->
  at_rate p \in rs /\ exists2 b, List.In b (rate_blocks [:: at_rate p] o) & setting_of p = at_ b.
Proof.
case/setting_in_context => /settingsE[r [x [rin xin e]]] part; have r_p : at_rate p = r by case: e.
have pos : 0 < all_draws r x (higher p) by move: part; rewrite e; case: (q) oq => // o' _ /andP[].
rewrite r_p; split=> //; have [_ _ _ all_here] := countsP r o.
have /in_mapE[[y ts] yin /= yx] := all_here _ _ xin (draws_here pos); rewrite {}yx in yin.
by exists (of_rates r x ts); rewrite // /rate_blocks /= List.app_nil_r; apply/in_map_iff; exists (x, ts).
Qed.

Lemma cover_rates : cover R T q (rate_blocks rs o).
Proof.
split=> [b||p /compared_in_block[rin [b]]]; first exact: rate_blocks_right.
- apply: (flat_sorted blocks_before_trans ltb_trans srt) => [r _|r s b c _ _ rs_ /in_map_iff[[x ts] [<- _]] /in_map_iff[[y us] [<- _]]].
    have [srt' _ _ _] := countsP r o; rewrite sorted_map; move: srt'; rewrite sorted_map.
    by apply: sub_sorted => k l kl; apply: later_context; apply/Z.ltb_lt.
  by rewrite /blocks_before /setting_before /= rs_.
rewrite /rate_blocks /= List.app_nil_r => bin at_b; exists b => //; apply/in_flat_map; exists (at_rate p); split=> //.
exact/in_seqE.
Qed.

Lemma plainly : is_distance q = false /\ is_ratio q = false.
Proof. by case: (q) oq. Qed.

Lemma rates_figure_sound : figure_sound R T q (best_of widest_difference (rate_blocks rs o)).
Proof.
have [nd nr] := plainly; have un : is_ratio q && signed T = false by rewrite nr.
apply: (best_of_sound cover_rates) => b bin; exact: (widest_difference_sound nd un nr (rate_blocks_right bin)).
Qed.

(* Whether anybody is compared by one of the rates *)
Lemma compared_by r : r \in rs -> best_of widest_difference (rate_blocks [:: r] o) <> None <-> exists2 p, compares R T q p & at_rate p = r.
Proof.
move=> rin; have [nd nr] := plainly; have un : is_ratio q && signed T = false by rewrite nr.
have inside_ b : List.In b (rate_blocks [:: r] o) -> List.In b (rate_blocks rs o).
  rewrite /rate_blocks /= List.app_nil_r => bin; apply/in_flat_map; exists r; split=> //.
  exact/in_seqE.
have sound b (bin : List.In b (rate_blocks [:: r] o)) := widest_difference_sound nd un nr (rate_blocks_right (inside_ _ bin)).
have := best_of_some widest_difference (rate_blocks [:: r] o); case: (best_of _ _) => [f [b bin some]|nobody]; split=> //.
  move=> _; have := sound _ bin; rewrite /sound_on; case: (widest_difference b) some => [g|] // _ [[[comp at_b] _] _ _ _].
  exists (place_found g) => //; move: at_b; have [r' [x [ts [r'in _ _ ->]]]] := rate_blocks_in bin.
  by move: r'in; rewrite mem_seq1 => /eqP -> [].
case=> p comp rp; have [_ [b bin at_b]] := compared_in_block comp; rewrite rp in bin.
by have := sound _ bin; rewrite /sound_on (nobody _ bin) => /(_ _ comp).
Qed.
End Covered.
End Rates.

(* ---- With true labels or without ---- *)

Section Figures.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.

Lemma rates_left_out_sound : rates_left_out T = all_rates_left_out R T.
Proof.
case known_: (known T) => [K|]; first exact: (rates_left_outE R ok known_).
by rewrite /rates_left_out /all_rates_left_out known_.
Qed.

Lemma nobody_by_rates q p : known T = None -> of_rate q -> ~~ compares R T q p.
Proof.
move=> unknown oq; have none r x a : all_draws R T r x a = 0.
  have each y : draws R T r y a = 0 by rewrite /draws /labelled unknown.
  by rewrite /all_draws /over_contexts; case: ifP => // _; apply: big1 => y _; apply: each.
rewrite /compares; case: p => r x u h l; rewrite /setting_of /=; case: q oq => // o _; rewrite none ltxx /= !andbF //.
Qed.

Lemma equal_opportunity_sound o : figure_holds R T (Equal_opportunity o) (option_map figure_of (figure_by_rates T [:: true_positives] o)).
Proof.
apply: found_holds => //; rewrite /figure_by_rates; case known_: (known T) => [K|]; last by case=> p; apply/negP/nobody_by_rates.
apply: (@rates_figure_sound R T ok K known_ (Equal_opportunity o) o [:: true_positives]) => //= s; split=> [/mapP[x xin ->]|[r [x [+ xin ->]]]]; first by exists true_positives, x.
by rewrite mem_seq1 => /eqP ->; apply: map_f.
Qed.

Lemma odds_sound o : figure_holds R T (Odds_given_truth o)
  (match figure_by_rates T [:: true_positives] o, figure_by_rates T [:: false_positives] o with
   | Some _, Some _ => option_map figure_of (figure_by_rates T [:: true_positives; false_positives] o)
   | _, _ => None
   end).
Proof.
rewrite /figure_by_rates; case known_: (known T) => [K|]; last first.
  by case=> -[p comp _]; have := nobody_by_rates p known_ (isT : of_rate (Odds_given_truth o)); rewrite comp.
rewrite -[List.flat_map _ [:: true_positives]]/(rate_blocks T K [:: true_positives] o).
rewrite -[List.flat_map _ [:: false_positives]]/(rate_blocks T K [:: false_positives] o).
rewrite -[List.flat_map _ [:: true_positives; false_positives]]/(rate_blocks T K [:: true_positives; false_positives] o).
have settingsE s : s \in settings T (Odds_given_truth o) <->
    exists r x, [/\ r \in [:: true_positives; false_positives], x \in contexts_or_none T o & s = (r, x, nothing)].
  by split=> [/allpairsP[[r x] [rin xin ->]]|[r [x [rin xin ->]]]]; [exists r, x | apply/allpairsP; exists (r, x)].
have srt : sorted Z.ltb [:: true_positives; false_positives] by [].
have by_ := compared_by R ok known_ (isT : of_rate (Odds_given_truth o)) settingsE.
have := by_ true_positives isT; case: (best_of _ (rate_blocks T K [:: true_positives] o)) => [f|] by_true; last first.
  by case=> /(proj2 by_true).
have := by_ false_positives isT; case: (best_of _ (rate_blocks T K [:: false_positives] o)) => [g|] by_false; last first.
  by case=> _ /(proj2 by_false).
have sound := rates_figure_sound R ok known_ (isT : of_rate (Odds_given_truth o)) srt settingsE.
have [ex ex'] : exists_at_all R T (Odds_given_truth o) by split; [apply/by_true | apply/by_false].
case: (best_of _ _) sound => [h|] sound; last by case: sound; case: ex => p comp _; exists p.
by split=> //; apply: found_witnessed.
Qed.
End Figures.
