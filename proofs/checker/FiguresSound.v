(* The figures that are computed of a valid table are those of Meaning.v. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Distances Checker ListsSound TableSound WidestSound BlocksSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Figures.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).
Local Notation F := (rows_of T).
Local Notation G := (if with_means T then with_mass (group_rows T F) else [::]).

(* ---- Nothing is below 0 where no utility is ---- *)

Lemma sum_ge0_seq A (s : seq A) (f : A -> R) : (forall x, 0 <= f x) -> 0 <= \sum_(x <- s) f x.
Proof. by move=> f0; elim: s => [|x s IH]; rewrite ?big_nil // big_cons addr_ge0. Qed.

Lemma weight_ge0 x a u : 0 <= weight R T x a u.
Proof.
rewrite /weight; case e: (cell_at T x a) => [c|] //; have [cin _ _] := cell_atP e.
rewrite /Meaning.number nthE; case: (ltnP (Z.to_nat u) (size (weights c))) => lt; last by rewrite nth_default // ratio_zero.
exact/(weights_nonnegative R ok cin)/in_of_nth.
Qed.

Lemma law_nonnegative x a u : 0 <= law R T x a u.
Proof. by rewrite /law divr_ge0 ?weight_ge0 //; apply: sum_ge0_seq => v; apply: weight_ge0. Qed.

Lemma cell_mass_ge0 x a : 0 <= cell_mass R T x a.
Proof.
rewrite /cell_mass; case e: (cell_at T x a) => [c|] //; have [cin cx ca] := cell_atP e.
have := bulk_nonnegative R ok cin; rewrite -(cell_massE R ok cin) /cell_mass cx ca e.
by case: (population T).
Qed.

Lemma group_mass_ge0 a : 0 <= group_mass R T a.
Proof. by apply: sum_ge0_seq => x; apply: cell_mass_ge0. Qed.

Lemma group_law_ge0 a u : 0 <= group_law R T a u.
Proof.
rewrite /group_law divr_ge0 ?group_mass_ge0 //; apply: sum_ge0_seq => x.
by rewrite mulr_ge0 ?cell_mass_ge0 ?law_nonnegative.
Qed.

Section Unsigned.
Hypothesis unsigned : signed T = false.

Lemma given_ge0 g : List.In g (given T) -> 0 <= ratio g.
Proof.
move=> gin; rewrite -(nonnegativeE R) /nonnegative; move: unsigned; rewrite /signed => /negbT/negP no_negative.
rewrite Z.leb_antisym; apply/negP => g0; apply: no_negative; apply/existsb_exists; by exists g.
Qed.

Lemma gain_ge0 x a u : 0 <= gain R T x a u.
Proof.
rewrite /gain; case e: (utility T) => [gs|].
  rewrite /Meaning.number nthE; case: (ltnP (Z.to_nat u) (size gs)) => lt; last by rewrite nth_default // ratio_zero.
  by apply: given_ge0; rewrite /given e; apply: in_of_nth.
case e': (cell_at T x a) => [c|] //; have [cin _ _] := cell_atP e'.
rewrite nthE; case: (ltnP (Z.to_nat u) (size (gains c))) => lt; last by rewrite nth_default.
have := in_of_nth None lt; case: (nth _ _ _) => // g gin; apply: given_ge0; rewrite /given e.
by apply/in_flat_map; exists c; split=> //; apply/in_flat_map; exists (Some g); split=> //; left.
Qed.

Lemma expectation_ge0 x a : 0 <= expectation R T x a.
Proof. by apply: sum_ge0_seq => u; rewrite mulr_ge0 ?law_nonnegative ?gain_ge0. Qed.

Lemma amount_ge0 q s a : is_ratio q -> 0 <= amount R T q s a.
Proof.
case: s => [[r x] u]; case: q => // _ /=; rewrite ?expectation_ge0 ?law_nonnegative ?group_law_ge0 //.
rewrite /group_mean divr_ge0 ?group_mass_ge0 //; apply: sum_ge0_seq => y.
by rewrite mulr_ge0 ?cell_mass_ge0 ?expectation_ge0.
Qed.
End Unsigned.

(* ---- Ratios and differences ---- *)

Definition plain (q : quantity) : bool :=
  match q with Local | Global | Local_supremum | Global_supremum | Local_difference | Global_difference => true | _ => false end.

Lemma cover_of q : plain q -> cover R T q (blocks_of T F G q).
Proof.
case: q => //= _; [apply: cover_local | apply: cover_global | apply: cover_local_supremum | apply: cover_global_supremum
  | apply: cover_local | apply: cover_global] => //; by [left | right].
Qed.

Lemma found_witnessed q f : is_distance q = false -> figure_sound R T q (Some f) -> witnessed R T q (figure_of f).
Proof.
move=> nd [first value sides]; rewrite /witnessed -[witness _]/(place_found f) nd; split=> //; split=> //; exists ((high f).2, (low f).2) => //.
by rewrite /place_found setting_of_place higher_of_place lower_of_place.
Qed.

Lemma found_holds q f : is_distance q = false -> (forall o, q <> Odds_given_truth o) ->
  figure_sound R T q f -> figure_holds R T q (option_map figure_of f).
Proof.
move=> nd no_odds; have exE : exists_at_all R T q = exists p, compares R T q p by case: q no_odds {nd} => // o /(_ o).
case: f => [f sound|nobody]; last by rewrite /figure_holds exE.
rewrite /figure_holds [option_map _ _]/= exE; split; last exact: found_witnessed.
by case: sound => first _ _; exists (place_found f); case: first.
Qed.

Lemma plain_sound q : plain q -> figure_holds R T q (compute T F G q).
Proof.
move=> pq; have nd : is_distance q = false by case: q pq.
have no_odds o : q <> Odds_given_truth o by move=> e; rewrite e in pq.
have cov := cover_of pq; case rq: (is_ratio q).
  have -> : compute T F G q = if signed T then None else option_map figure_of (best_of widest_ratio (blocks_of T F G q)) by case: q rq {pq nd no_odds cov}.
  case sT: (signed T).
    have exE : exists_at_all R T q = exists p, compares R T q p by case: q no_odds {nd pq cov rq} => // o /(_ o).
    by rewrite /= exE => -[p]; rewrite /compares rq sT.
  have un : is_ratio q && signed T = false by rewrite rq sT.
  apply: found_holds => //; apply: (best_of_sound cov) => b bin; case: cov => rights _ _.
  apply: (widest_ratio_sound nd un rq (rights _ bin)) => e ein; case: (rights _ bin) => _ _ _ -> //.
  exact: amount_ge0.
have un : is_ratio q && signed T = false by rewrite rq.
have -> : compute T F G q = option_map figure_of (best_of widest_difference (blocks_of T F G q)) by case: q rq pq {nd no_odds cov un}.
apply: found_holds => //; apply: (best_of_sound cov) => b bin; case: cov => rights _ _.
exact: (widest_difference_sound nd un rq (rights _ bin)).
Qed.

(* ---- What is stated is what is computed ---- *)

Lemma same_valueE q r : same_value q r -> ratio q = ratio r.
Proof. by move/Z.eqb_eq; apply: ratio_eq. Qed.

Lemma same_extended v w : same_option same_value v w -> extended R v = extended R w.
Proof. by case: v w => [v|] [w|] //= /same_valueE ->. Qed.

Lemma same_listP (xs ys : list Z) : same_list Z.eqb xs ys -> xs = ys.
Proof. by elim: xs ys => [|x xs IH] [|y ys] //=; case: Z.eqb_spec => // -> /IH ->. Qed.

Lemma same_placeP p q : same_place p q -> p = q.
Proof. by case: p q => [a b c d e] [a' b' c' d' e'] /and5P[/= /Z.eqb_eq -> /Z.eqb_eq -> /Z.eqb_eq -> /Z.eqb_eq -> /Z.eqb_eq ->]. Qed.

Lemma same_figure_holds q f g : same_option same_figure f g -> figure_holds R T q g -> figure_holds R T q f.
Proof.
case: f g => [f|] [g|] //= /and4P[/same_extended ev /same_placeP ep eb /same_listP er] [ex [first value rest]].
split=> //; split; rewrite ?ep // ?ev //; case: ifP rest => nd [one two]; rewrite er; split=> //.
  by move: eb; rewrite one; case: (both f).
case: two => s es [hs ls]; move: eb; rewrite es; case: (both f) => // t /andP[/same_valueE t1 /same_valueE t2].
by exists t => //; rewrite t1 t2.
Qed.

Lemma same_quantityP q r : same_quantity q r -> q = r.
Proof. by case: q r => [||||||||a|a] [||||||||b|b] //= /eqb_prop ->. Qed.
End Figures.
