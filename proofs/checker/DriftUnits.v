(* What is compared under drift: cells, or means over the cells of a group; their ends, and the sides of a pair that is named. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From mathcomp.zify Require Import ssrZ.
From Fairaudit Require Import Definitions.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Drift ListsSound TableSound FiguresSound MovedLaws MovedCells DriftCells.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- Strictly before an end ---- *)

Section Before.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).
Local Notation n := (Z.to_nat (decisions T)).

Definition before_amount (amount : option Q) (v : R) : Prop := if amount is Some w then v < ratio w else True.

(* What is checked of one cell, so that its end is not reached before *)
Definition moves_on (k : move) (amount : option Q) (up : bool) (c : mover) : bool :=
  match k, amount with
  | By_variation, Some w => at_most w (reached_by up c)
  | By_variation, None => false
  | By_factor, _ => ~~ is_constant k c
  end.

Variables (c : cell) (v : R) (D : Z -> Z -> Z -> R).
Hypotheses (c_in : List.In c (cells T)).
Local Notation ps := (law_of (row_of T c)).
Local Notation gs := (gains_of T c).
Local Notation P := (@listed R n ps).
Local Notation E := (expectation_in T D (context c) (group c)).

Definition gains_as (up : bool) : list Q := if up then gs else map minus gs.

Lemma size_gains_as up : size (gains_as up) = n.
Proof. by case: up; rewrite /gains_as ?size_map; apply: size_gains. Qed.

Lemma directed_as up : directed up (law_with_gains (its T c)) = List.combine ps (gains_as up).
Proof. by rewrite /directed /law_with_gains; case: up => //; apply: turned_combine. Qed.

Lemma expect_as up (D' : 'I_n -> R) : expect D' (@listed R n (gains_as up)) = if up then expect D' (@listed R n gs) else - expect D' (@listed R n gs).
Proof. by case: up => //; rewrite -expectN; apply: eq_expect => // i; rewrite /gains_as listed_turned // size_gains. Qed.

Lemma cell_before k amount e up : an_amount k amount -> ends_of k amount (its T c) = Some e -> drifted T k v D -> before_amount amount v ->
  moves_on k amount up (its T c) -> if up then E < ratio e.2 else ratio e.1 < E.
Proof.
move=> amount_ok found dr before on; have lP := is_a_law R ok c_in.
have nD : near P k v (by_number (D (context c) (group c))) by apply/(movedE ok c_in); apply: dr; apply: has_cell_of.
have [bounds _] := are_its_ends R ok c_in amount_ok found.
pose b : R := if up then ratio e.2 else - ratio e.1.
suff : expect (by_number (D (context c) (group c))) (@listed R n (gains_as up)) < b.
  by rewrite expect_as /b -(expectation_in_list ok c_in); case: (up) => //; rewrite ltr_opp2.
have upper w D' : amount = Some w -> near P k (ratio w) D' -> expect D' (@listed R n (gains_as up)) <= b.
  move=> is_w nD'; have /andP[low high] : ratio e.1 <= expect D' (@listed R n gs) <= ratio e.2.
    by apply: (bounds (ratio w)) => //; rewrite is_w /=.
  by rewrite expect_as /b; case: (up); rewrite // ler_opp2.
have size_as := size_gains_as up; have size_ps := size_law ok c_in.
have top k' := top_reachable size_ps lP size_as k'.
have apart : ~~ is_constant By_factor (its T c) -> exists i j, [/\ 0 < P i, 0 < P j & @listed R n (gains_as up) i < @listed R n (gains_as up) j].
  rewrite /is_constant (at_mostE R) ratio_minus -ltNge /law_with_gains turned_combine.
  have [[i can_i gi] _] := top_reachable size_ps lP (size_gains ok c_in) By_factor.
  have size_t : size (map minus gs) = n by rewrite size_map size_gains.
  have [[j can_j gj] _] := top_reachable size_ps lP size_t By_factor.
  rewrite -gi -gj listed_turned ?size_gains // opprK => less.
  case: (up); [exists j, i | exists i, j]; split; try exact: can_i; try exact: can_j; rewrite //.
  by rewrite /gains_as !listed_turned ?size_gains // ltr_opp2.
case: k amount nD before on upper found {amount_ok bounds dr} => [] [w|] nD before on upper found //.
- apply: (variation_before lP nD before (fun D' => upper w D' erefl) (top By_variation)).
  by move: on; rewrite /moves_on /reached_by directed_as (at_mostE R) (ratio_below R size_ps size_as).
- have [i [j [Pi Pj less]]] := apart on.
  exact: (factor_before lP nD before (fun D' => upper w D' erefl) Pi Pj less).
have [i [j [Pi Pj less]]] := apart on.
have -> : b = ratio (top_of (reachable By_factor (List.combine ps (gains_as up)))).
  move: found; rewrite /ends_of /ends_of_law /b => -[<-]; case: (up) => //=.
  by rewrite ratio_minus opprK /law_with_gains turned_combine.
apply: (top_not_reached lP nD (top By_factor) Pi); apply: (lt_le_trans less).
by have [_] := top By_factor; apply.
Qed.
End Before.

(* ---- Means over cells ---- *)

Lemma sum_gt0_in (R : realFieldType) A (s : list A) (f : A -> R) y : (forall x, List.In x s -> 0 <= f x) -> List.In y s -> 0 < f y ->
  0 < \sum_(x <- s) f x.
Proof.
elim: s => //= x s IH ge0 [->|there] pos; rewrite big_cons.
  by apply: ltr_paddr => //; apply: sum_ge0_in => z zin; apply: ge0; right.
by apply: ltr_paddl; [apply: ge0; left | apply: IH => // z zin; apply: ge0; right].
Qed.

Lemma all_someE A (xs : list (option A)) ys : all_some [::] xs = Some ys -> xs = [seq Some y | y <- ys].
Proof.
suff gen done : all_some done xs = Some ys -> [seq Some y | y <- List.rev_append done [::]] ++ xs = [seq Some y | y <- ys] by move/gen.
elim: xs done => [|[x|] xs IH] done //=; first by case=> <-; rewrite cats0.
by move/IH => <-; rewrite !List.rev_append_rev !app_nil_r /= map_cat -catA.
Qed.

(* Values that are all there are those of a function. *)
Lemma all_some_map A C (f : A -> option C) (d : C) xs ys : all_some [::] [seq f x | x <- xs] = Some ys ->
  (forall x, List.In x xs -> f x = Some (odflt d (f x))) /\ ys = [seq odflt d (f x) | x <- xs].
Proof.
move/all_someE; elim: xs ys => [|x xs IH] [|y ys] //= [fx /IH[each ->]]; rewrite fx; split=> // z [<-|/each //].
by rewrite fx.
Qed.

Section Units.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).
Local Notation n := (Z.to_nat (decisions T)).

(* cells with masses above 0 *)
Definition bundle := list (Q * cell).
Definition movers_in (B : bundle) : massed := [seq (mc.1, its T mc.2) | mc <- B].
Definition is_bundle (B : bundle) : Prop := B <> [::] /\ forall m c, List.In (m, c) B -> List.In c (cells T) /\ 0 < ratio m.

Definition mean_in (B : bundle) (f : cell -> R) : R := (\sum_(mc <- B) ratio mc.1 * f mc.2) / \sum_(mc <- B) ratio mc.1.

Variable B : bundle.
Hypothesis bundled : is_bundle B.

Lemma bundle_mass : 0 < \sum_(mc <- B) ratio mc.1.
Proof.
have [some each] := bundled; case: B some each => // [[m c] rest] _ each; rewrite big_cons; apply: ltr_paddr.
  by apply: sum_ge0_in => -[m' c'] there; apply/ltW; have [] := each m' c' (or_intror there).
by have [] := each m c (or_introl erefl).
Qed.

Lemma mean_in_le f h : (forall m c, List.In (m, c) B -> f c <= h c) -> mean_in B f <= mean_in B h.
Proof.
move=> le; rewrite /mean_in ler_pmul2r ?invr_gt0 ?bundle_mass //.
rewrite -subr_ge0 -sumrB; apply: sum_ge0_in => -[m c] there /=; rewrite -mulrBr mulr_ge0 ?subr_ge0 ?(le _ _ there) //.
by have [_ each] := bundled; have [_ /ltW] := each _ _ there.
Qed.

Lemma mean_in_lt f h : (forall m c, List.In (m, c) B -> f c <= h c) -> (exists m c, List.In (m, c) B /\ f c < h c) -> mean_in B f < mean_in B h.
Proof.
move=> le [m [c [there lt]]]; rewrite /mean_in ltr_pmul2r ?invr_gt0 ?bundle_mass //.
rewrite -subr_gt0 -sumrB; have [_ each] := bundled; apply: (sum_gt0_in _ there) => [[m' c'] there'|] /=.
  by rewrite -mulrBr mulr_ge0 ?subr_ge0 ?(le _ _ there') //; have [_ /ltW] := each _ _ there'.
by rewrite -mulrBr mulr_gt0 ?subr_gt0 //; have [] := each _ _ there.
Qed.

Lemma mean_in_eq f h : (forall m c, List.In (m, c) B -> f c = h c) -> mean_in B f = mean_in B h.
Proof. by move=> e; rewrite /mean_in; congr (_ / _); apply: eq_sum_in => -[m c] there; rewrite /= (e _ _ there). Qed.

Lemma mean_in_mix t f h : mean_in B (fun c => (1 - t) * f c + t * h c) = (1 - t) * mean_in B f + t * mean_in B h.
Proof.
rewrite /mean_in !mulrA -mulrDl; congr (_ / _); rewrite !mulr_sumr -big_split; apply: eq_bigr => mc _ /=; ring.
Qed.

Lemma mean_in_const f v : (forall m c, List.In (m, c) B -> f c = v) -> mean_in B f = v.
Proof.
move=> e; rewrite (@mean_in_eq _ (fun=> v)) // /mean_in -mulr_suml mulrAC divff ?mul1r // gt_eqF //; exact: bundle_mass.
Qed.

Lemma ratio_mean_over (q : cell -> Q) : ratio (mean_over [seq (mc.1, q mc.2) | mc <- B]) = mean_in B (fun c => ratio (q c)).
Proof.
rewrite /mean_over ratio_times /mean_in mulrC !ratio_sum; congr (_ * _).
  by rewrite !big_map; apply: eq_bigr => mc _; rewrite /= ratio_times.
rewrite ratio_inverse; last by rewrite (positive_fractionE R) ratio_sum !big_map bundle_mass.
by rewrite ratio_sum !big_map.
Qed.

(* ---- Their ends ---- *)

Variables (k : move) (amount : option Q).
Hypothesis amount_ok : an_amount k amount.

Definition own_ends (c : cell) : Q * Q := odflt (zero, zero) (ends_of k amount (its T c)).
Definition has_ends (c : cell) : Prop := ends_of k amount (its T c) = Some (own_ends c).

Lemma ends_overE e : ends_over k amount (movers_in B) = Some e ->
  (forall m c, List.In (m, c) B -> has_ends c) /\
  (ratio e.1 = mean_in B (fun c => ratio (own_ends c).1) /\ ratio e.2 = mean_in B (fun c => ratio (own_ends c).2)).
Proof.
rewrite /ends_over; have -> : List.map (fun mc => ends_of k amount mc.2) (movers_in B) = [seq ends_of k amount (its T mc.2) | mc <- B].
  by rewrite /movers_in; elim: (B) => //= mc rest ->.
case es: (all_some _ _) => [ys|] //= [<-]; have [each ->] := all_some_map (zero, zero) es; split=> [m c there|].
  exact: each there.
split=> /=; rewrite -ratio_mean_over; congr (ratio (mean_over _)); elim: (B) => //= mc rest ->; by [].
Qed.
End Units.
