(* The pairs of a table under drift: what is compared is a mean over cells, and both sides of a pair reach their ends at once. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From mathcomp.zify Require Import ssrZ.
From Fairaudit Require Import Definitions.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Drift ListsSound TableSound BlocksSound FiguresSound.
From FairauditChecker Require Import MovedLaws MovedCells DriftCells DriftUnits.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Pairs.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).
Local Notation movers := (movers_of T (rows_of T)).
Local Notation A := (group_rows T (rows_of T)).

Lemma moversE : movers = [seq (xcs.1, [seq its T c | c <- xcs.2]) | xcs <- runs context (cells T)].
Proof.
rewrite /movers_of /rows_of; elim: (runs _ _) => //= -[x cs] rest ->; congr ((_, _) :: _).
by elim: cs => //= c cs ->.
Qed.

(* ---- What is compared ---- *)

Definition unit_of (local : bool) (x a : Z) : bundle :=
  if local then [seq (one, c) | c <- in_context T x & Z.eqb (group c) a]
  else [seq (bulk (row_of T c), c) | c <- cells T & Z.eqb (group c) a && positive_fraction (bulk (row_of T c))].

Lemma in_unit local x a m c : List.In (m, c) (unit_of local x a) ->
  [/\ List.In c (cells T), group c = a, local -> context c = x & 0 < ratio m].
Proof.
rewrite /unit_of; case: local => /in_map_iff[c' [[<- <-]]] /in_filter_seq[there].
  by move/Z.eqb_eq => ->; have [c_in ->] := in_context_in there; rewrite ratio_one ltr01.
by move=> /andP[/Z.eqb_eq -> pos]; rewrite -(positive_fractionE R).
Qed.

Definition is_in (local : bool) (x a : Z) (c : cell) : bool :=
  Z.eqb (group c) a && (if local then Z.eqb (context c) x else positive_fraction (bulk (row_of T c))).

Lemma is_inP local x a c : List.In c (cells T) -> is_in local x a c <-> exists m, List.In (m, c) (unit_of local x a).
Proof.
rewrite /is_in /unit_of => c_in; split=> [/andP[ga]|[m]]; case: local => [|].
- move=> cx; exists one; apply/in_map_iff; exists c; split=> //; apply/in_filter_seq; split=> //; exact/in_filter_seq.
- move=> pos; exists (bulk (row_of T c)); apply/in_map_iff; exists c; split=> //; apply/in_filter_seq; split; rewrite ?ga //.
- case/in_map_iff => c' [[_ <-]] /in_filter_seq[there ->]; have [_ ->] := in_context_in there; exact: Z.eqb_refl.
- by case/in_map_iff => c' [[_ <-]] /in_filter_seq[_].
Qed.

Lemma unit_bundle local x a : unit_of local x a <> [::] -> is_bundle R T (unit_of local x a).
Proof. by move=> some; split=> // m c /in_unit[]. Qed.

Lemma cells_atE local x a : cells_at movers local x a = movers_in T (unit_of local x a).
Proof.
have filter_its (f : mover -> bool) cs : List.filter f [seq its T c | c <- cs] = [seq its T c | c <- cs & f (its T c)].
  by elim: cs => //= c cs ->; case: ifP.
have with_mass_ (mass : cell -> Q) (mass_ : mover -> Q) cs : (forall c, mass_ (its T c) = mass c) ->
    List.map (fun c => (mass_ c, c)) [seq its T c | c <- cs] = movers_in T [seq (mass c, c) | c <- cs].
  by move=> e; elim: cs => //= c cs ->; rewrite e.
rewrite /cells_at moversE; case: local; last first.
  have -> : flat_map snd [seq (xcs.1, [seq its T c | c <- xcs.2]) | xcs <- runs context (cells T)] = [seq its T c | c <- cells T].
    by rewrite -[in RHS](flat_runs context (cells T)); elim: (runs _ _) => //= -[y cs] rest ->; rewrite map_cat.
  by rewrite filter_its (with_mass_ (fun c => bulk (row_of T c)) (fun c => bulk c.1)).
case e: (List.find _ _) => [[y ms]|].
  have [/in_map_iff[[y' cs] [[<- <-] there]] /Z.eqb_eq <-] := find_some _ _ e.
  by rewrite /= filter_its (with_mass_ (fun=> one) (fun=> one)) // (proj1 (proj2 (runs_of_cells ok) _ _ there)).
suff cs0 : in_context T x = [::] by rewrite /unit_of cs0.
case cs: (in_context T x) => [|c rest] //; have /in_context_in[c_in cx] : List.In c (in_context T x) by rewrite cs; left.
have [ys] := runs_have context c_in; rewrite cx => run.
have there : List.In (x, [seq its T c | c <- ys]) [seq (xcs.1, [seq its T c | c <- xcs.2]) | xcs <- runs context (cells T)].
  by apply/in_map_iff; exists (x, ys).
by have := find_none _ _ e _ there; rewrite /= Z.eqb_refl.
Qed.

Lemma unit_amount D local x a : unit_of local x a <> [::] ->
  amount_in (R := R) T D local x a = mean_in (unit_of local x a) (fun c => expectation_in T D (context c) (group c)).
Proof.
move=> some; have bundled := unit_bundle some; case: local some bundled => some bundled.
  rewrite (mean_in_const bundled (v := expectation_in T D x a)) // => m c /in_unit[_ <- /(_ isT) <- _] //.
rewrite /amount_in /group_mean_in /mean_in (@sum_of_masses _ _ ok _ (fun c => expectation_in T D (context c) (group c))) => [|c _ <- //].
rewrite sum_of_masses1 // /unit_of !big_map /of_group !big_filter.
have drop (f : cell -> R) : \sum_(c <- cells T | Z.eqb (group c) a) ratio (bulk (row_of T c)) * f c =
    \sum_(c <- cells T | Z.eqb (group c) a && positive_fraction (bulk (row_of T c))) ratio (bulk (row_of T c)) * f c.
  rewrite big_mkcond [RHS]big_mkcond; apply: eq_sum_in => c c_in; case: (Z.eqb _ _) => //=; case: ifP => // none.
  have := bulk_nonnegative R ok c_in; rewrite le_eqVlt -(positive_fractionE R) none orbF => /eqP <-.
  by rewrite mul0r.
rewrite drop; have := drop (fun=> 1).
by under eq_bigr do rewrite mulr1; under [X in _ = X -> _]eq_bigr do rewrite mulr1; move=> ->.
Qed.

Hypothesis unsigned : signed T = false.

Definition placed (local : bool) (x h l : Z) : place := Place nothing (if local then x else nothing) nothing h l.

Lemma unit_of_mean x a : has_mean R T a -> unit_of false x a <> [::].
Proof.
case/and3P => _ _; rewrite sum_of_masses1 // => pos e.
suff : \sum_(c <- of_group a (cells T)) ratio (bulk (row_of T c)) = 0 by move=> z; rewrite z ltxx in pos.
rewrite -[RHS](@big1_eq _ _ (GRing.add_monoid R) _ (of_group a (cells T)) xpredT); apply: eq_sum_in => c /in_filter_seq[c_in ca].
have := bulk_nonnegative R ok c_in; rewrite le_eqVlt => /orP[/eqP //|positive].
suff : List.In (bulk (row_of T c), c) (unit_of false x a) by rewrite e.
apply/in_map_iff; exists c; split=> //; apply/in_filter_seq; split=> //.
by rewrite ca (positive_fractionE R).
Qed.

Lemma comparesE local p : compares R T (ratio_of_all local) p -> exists x h l,
  [/\ p = placed local x h l, h <> l, unit_of local (at_context p) h <> [::] & unit_of local (at_context p) l <> [::]].
Proof.
have some_cell x a : has_cell T x a -> unit_of true x a <> [::].
  case/(has_cellP ok) => c c_in [cx ca] e; suff : List.In (one, c) (unit_of true x a) by rewrite e.
  apply/in_map_iff; exists c; split=> //; apply/in_filter_seq; split; last by apply/Z.eqb_eq.
  by apply/in_filter_seq; split=> //; apply/Z.eqb_eq.
case: p => r x u h l /and5P[_]; case: local => /=.
  case/mapP => y _ [-> -> ->] part part' /eqP ne; exists y, h, l; split=> //; exact: some_cell.
rewrite mem_seq1 => /eqP[-> -> ->] part part' /eqP ne; exists nothing, h, l; split=> //; exact: unit_of_mean.
Qed.

(* ---- Moving all cells, or those of a pair ---- *)

Lemma law_itself k v c : List.In c (cells T) -> starts k v -> moved T k v (law R T (context c) (group c)) (law R T (context c) (group c)).
Proof.
move=> c_in st; have [P0 P1] := is_a_law R ok c_in; split.
  split=> [u _|]; first exact: (law_nonnegative R ok).
  by rewrite sum_range -P1; apply: eq_bigr => i _; rewrite listed_law.
case: k st => /= st; first by rewrite big1 // => u _; rewrite subrr maxxx.
by move=> u _; rewrite !ler_pemull //; apply: (law_nonnegative R ok).
Qed.

Local Notation value c D := (\sum_(u <- range (decisions T)) D u * gain R T (context c) (group c) u).

(* Both of two bundles are moved as each of their cells can be. *)
Lemma move_both k v local x h l (f f' : cell -> R) : starts k v -> h <> l -> unit_of local x h <> [::] -> unit_of local x l <> [::] ->
  (forall m c, List.In (m, c) (unit_of local x h) -> exists2 D, moved T k v (law R T (context c) (group c)) D & value c D = f c) ->
  (forall m c, List.In (m, c) (unit_of local x l) -> exists2 D, moved T k v (law R T (context c) (group c)) D & value c D = f' c) ->
  exists D, [/\ drifted T k v D, amount_in T D local x h = mean_in (unit_of local x h) f
    & amount_in T D local x l = mean_in (unit_of local x l) f'].
Proof.
move=> st hl some some' each each'.
have [|D chosen] := @choose R T ok (fun c D => moved T k v (law R T (context c) (group c)) D
   /\ (is_in local x h c -> value c D = f c) /\ (is_in local x l c -> value c D = f' c)).
  move=> c c_in; case in_h: (is_in local x h c); [|case in_l: (is_in local x l c)].
  - have [m mc] := proj1 (is_inP local x h c_in) in_h; have [D mD vD] := each m c mc; exists D; split=> //; split=> // in_l.
    by case: hl; move: in_h in_l => /andP[/Z.eqb_eq <- _] /andP[/Z.eqb_eq <- _].
  - by have [m mc] := proj1 (is_inP local x l c_in) in_l; have [D mD vD] := each' m c mc; exists D.
  by exists (law R T (context c) (group c)); split; first exact: law_itself.
exists D; split; first by apply: (all_moved ok) => c /chosen[].
- rewrite unit_amount //; apply: mean_in_eq => m c mc; have [c_in _ _ _] := in_unit mc.
  by have [_ [vh _]] := chosen c c_in; apply: vh; apply/(is_inP local x h c_in); exists m.
rewrite unit_amount //; apply: mean_in_eq => m c mc; have [c_in _ _ _] := in_unit mc.
by have [_ [_ vl]] := chosen c c_in; apply: vl; apply/(is_inP local x l c_in); exists m.
Qed.
End Pairs.
