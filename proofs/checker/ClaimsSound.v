(* Claims by theorems, for a table: T6, and the independence that T5 needs. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Checker ListsSound TableSound WidestSound BlocksSound FiguresSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Claims.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).

(* ---- T6 ---- *)

Lemma no_more_quotient (p q r : R) : 0 <= p -> 0 <= q -> no_more (quotient p q) (Some r) -> p <= r * q.
Proof.
move=> p0 q0; rewrite /quotient; case: (eqVneq q 0) => [->|qn]; first by case: (eqVneq p 0) => [->|] //= _; rewrite mulr0.
by rewrite /= ler_pdivr_mulr // lt_def qn.
Qed.

Lemma both_ways (p q r : R) : 0 <= p -> 0 <= q ->
  no_more (quotient p q) (Some r) -> no_more (quotient q p) (Some r) -> 1 <= r.
Proof.
move=> p0 q0; rewrite /quotient; case: (eqVneq p 0) => [_|pn]; case: (eqVneq q 0) => [_|qn] //= le le'; have {}p0 : 0 < p by rewrite lt_def pn.
have {}q0 : 0 < q by rewrite lt_def qn.
case: (lerP p q) => [pq|/ltW qp]; first by apply: le_trans le'; rewrite ler_pdivl_mulr // mul1r.
by apply: le_trans le; rewrite ler_pdivl_mulr // mul1r.
Qed.

Lemma mean_under_indicator (P : Z -> R) u : u \in range (decisions T) -> mean_under T P (fun v => (v == u)%:R) = P u.
Proof.
move=> u_in; rewrite /mean_under (bigD1_seq u) ?range_uniq //= eqxx mulr1 big1_seq ?addr0 // => v /andP[/negbTE vu _].
by rewrite vu mulr0.
Qed.

Lemma supremum_bound (P P' : Z -> R) (r : R) :
  (forall u, 0 <= P u) -> (forall u, 0 <= P' u) ->
  (forall u, u \in range (decisions T) -> no_more (quotient (P u) (P' u)) (Some r)) -> 1 <= r ->
  forall g : Z -> R, (forall u, 0 <= g u) -> no_more (quotient (mean_under T P g) (mean_under T P' g)) (Some r).
Proof.
move=> P0 P'0 each r1 g g0; have le : mean_under T P g <= r * mean_under T P' g.
  rewrite /mean_under mulr_sumr; rewrite big_seq [X in _ <= X]big_seq; apply: ler_sum => u u_in; rewrite mulrA ler_wpmul2r //.
  exact/no_more_quotient/each.
have M0 : 0 <= mean_under T P g by apply: sum_ge0_seq => u; rewrite mulr_ge0.
have M'0 : 0 <= mean_under T P' g by apply: sum_ge0_seq => u; rewrite mulr_ge0.
rewrite /quotient; case: (eqVneq (mean_under T P' g) 0) => [e|n] /=; last by rewrite ler_pdivr_mulr // lt_def n.
by rewrite e mulr0 in le; rewrite (_ : mean_under T P g == 0) // eq_le le M0.
Qed.

Lemma first_decision : Z0 \in range (decisions T).
Proof. by rewrite mem_range /inside /=; apply/Z.ltb_lt; apply: decisions_gt0. Qed.

Lemma compares_suprema (local : bool) x u a b : signed T = false ->
  (if local then has_cell T x a && has_cell T x b else has_mean R T a && has_mean R T b) && (a != b) -> u \in range (decisions T) ->
  compares R T (if local then Local_supremum else Global_supremum) (Place nothing (if local then x else nothing) u a b).
Proof.
move=> unsigned; case: local => /andP[/andP[pa pb] ab] u_in; rewrite /compares /= unsigned /= ?pa ?pb ?ab ?andbT.
  apply/allpairsP; exists (x, u); split=> //=; case/(has_cellP ok): pa => c cin [<- _]; exact: context_inside.
by apply: map_f.
Qed.

Lemma supremum_sound (local : bool) (v : option R) :
  greatest T (if local then Local_supremum else Global_supremum) v -> supremum_holds T local v.
Proof.
set q := if local then _ else _ => -[[p comp value] bound].
have unsigned : signed T = false.
  by move: comp; rewrite /compares /q; case: (local) => /andP[/= /negbTE].
have bound_of x a b u : (if local then has_cell T x a && has_cell T x b else has_mean R T a && has_mean R T b) && (a != b) ->
    u \in range (decisions T) ->
    no_more (if local then quotient (law R T x a u) (law R T x b u) else quotient (group_law R T a u) (group_law R T b u)) v.
  move=> together u_in; have := bound _ (compares_suprema unsigned together u_in).
  by rewrite /q; case: (local) {together}.
split.
  move=> x a b g together g0; case: v bound_of {value bound} => [r|] bound_of; last by case: ifP => _; case: quotient.
  have swapped : (if local then has_cell T x b && has_cell T x a else has_mean R T b && has_mean R T a) && (b != a).
    by move: together; case: (local) => /andP[/andP[-> ->]]; rewrite eq_sym.
  have := bound_of x a b _ together first_decision; have := bound_of x b a _ swapped first_decision.
  have := fun u => bound_of x a b u together; case: (local) => each below above.
    by apply: supremum_bound => // [u|u|]; rewrite ?law_nonnegative //; apply: both_ways above below; apply: law_nonnegative.
  by apply: supremum_bound => // [u|u|]; rewrite ?group_law_ge0 //; apply: both_ways above below; apply: group_law_ge0.
exists (at_context p), (higher p), (lower p), (fun w => (w == at_decision p)%:R).
split; [|by move=> u; rewrite ler0n|].
  by move: comp => /and5P[_ _]; rewrite /q; case: (local) => /= -> -> ->.
have u_in : at_decision p \in range (decisions T).
  move: comp => /and5P[_ + _ _ _]; rewrite /q; case: (local) => [/allpairsP[[x u] [/= _ uin [_ _ ->]]]|/mapP[u uin [_ _ ->]]] //.
by rewrite !mean_under_indicator // -value /q; case: (local).
Qed.

(* ---- Independence ---- *)

Local Notation F := (rows_of T).
Local Notation A := (group_rows T F).

Lemma who_of rs : sorted row_before rs -> (forall a, a \in range (groups T) <-> exists2 r, List.In r rs & who r = a) ->
  map who rs = range (groups T).
Proof.
move=> srt same; have tr : transitive Z.ltb by move=> a b c /Z.ltb_lt ab /Z.ltb_lt bc; apply/Z.ltb_lt; lia.
apply: (irr_sorted_eq tr _ _ (range_sorted _)) => [a|| a]; [exact: Z.ltb_irrefl | by rewrite sorted_map |].
apply/idP/idP => [|/same[r rin <-]].
  by move=> ain; apply/same; elim: (rs) ain => //= r s IH; rewrite in_cons => /orP[/eqP ->|/IH[t tin <-]]; [exists r; [left|] | exists t; [right|]].
by elim: (rs) rin => //= s t IH [->|/IH]; rewrite in_cons ?eqxx // => ->; rewrite orbT.
Qed.

Hypothesis full_ : complete T.

Lemma has_all x a : x \in range (contexts T) -> a \in range (groups T) -> has_cell T x a.
Proof. by move=> xin ain; have /allP/(_ _ xin)/allP := full_; apply. Qed.

Lemma who_in_context x : x \in range (contexts T) -> map who (map (row_of T) (in_context T x)) = range (groups T).
Proof.
move=> xin; apply: who_of; first exact: context_rows_sorted.
move=> a; split=> [ain|[r /in_map_iff[c [<- /in_context_in[cin cx]]] <-]]; last exact: group_inside.
case/(has_cellP ok): (has_all xin ain) => c cin [cx ca]; exists (row_of T c) => //; apply: in_map.
by apply/in_filter_seq; split=> //; apply/Z.eqb_eq.
Qed.

Lemma some_context : Z0 \in range (contexts T).
Proof. by rewrite mem_range /inside /=; move: ok => /and5P[/Z.ltb_lt lt _ _ _ _]; apply/Z.ltb_lt. Qed.

Lemma of_group_nonempty a : (of_group a (cells T) <> [::]) <-> exists x, has_cell T x a.
Proof.
split=> [|[x /(has_cellP ok)[c cin [_ ca]]] e].
  case e: (of_group a (cells T)) => [|c cs] // _.
  have /in_filter_seq[cin /Z.eqb_eq ca] : List.In c (of_group a (cells T)) by rewrite e; left.
  by exists (context c); rewrite -ca has_cell_of.
have : List.In c (of_group a (cells T)) by apply/in_filter_seq; split=> //; apply/Z.eqb_eq.
by rewrite e.
Qed.

Lemma who_of_groups : map who A = range (groups T).
Proof.
apply: who_of; first exact: group_rows_sorted.
move=> a; split=> [ain|[r rin <-]].
  have nonempty : of_group a (cells T) <> [::] by apply/of_group_nonempty; exists Z0; apply: has_all some_context ain.
  by exists (row_of_group (Z.to_nat (decisions T)) a (map (row_of T) (of_group a (cells T)))) => //; apply: group_rows_have.
have [_ /of_group_nonempty[x /(has_cellP ok)[c cin [_ <-]]]] := group_rows_in rin; exact: group_inside.
Qed.

Lemma combined rs ss : map who rs = map who ss -> forall r, List.In r rs ->
  exists s, [/\ List.In s ss, who s = who r & List.In (r, bulk s) (combine rs (map bulk ss))].
Proof.
elim: rs ss => [|r rs IH] [|s ss] //= [e /IH{}IH] t [<-|/IH[s' [s'in e' in_]]]; first by exists s; split=> //; left.
by exists s'; split=> //; right.
Qed.

Lemma bulk_of_group r : List.In r A -> ratio (bulk r) = group_mass R T (who r).
Proof. by move=> rin; have [re _] := group_rows_in rin; rewrite (group_massE R ok) -re. Qed.

Lemma sum_by_who rs (f : Z -> R) : (forall r, List.In r rs -> ratio (bulk r) = f (who r)) ->
  ratio (sum (map bulk rs)) = \sum_(a <- map who rs) f a.
Proof. by move=> e; rewrite ratio_sum !big_map; apply: eq_sum_in. Qed.

Lemma independent_rows x rs : List.In (x, rs) F ->
  forallb (fun rm => same_value (times (bulk rm.1) (sum (map bulk A))) (times (sum (map bulk rs)) rm.2)) (combine rs (map bulk A)) ->
  forall a, a \in range (groups T) -> cell_mass R T x a * total_mass R T = context_mass R T x * group_mass R T a.
Proof.
move=> xin /forallb_forall each a ain; have [rsE x_in] := rows_of_in ok xin.
have whos : map who rs = range (groups T) by rewrite rsE who_in_context.
have [r rin ra] : exists2 r, List.In r rs & who r = a.
  by move: ain; rewrite -whos; elim: (rs) => //= s t IH; rewrite in_cons => /orP[/eqP ->|/IH[r rin <-]]; [exists s; [left|] | exists r; [right|]].
have cell_of_row s : List.In s rs -> ratio (bulk s) = cell_mass R T x (who s).
  by rewrite rsE => /in_map_iff[c [<- /in_context_in[cin <-]]]; rewrite cell_massE.
have [s [sin sa rs_in]] := combined (etrans whos (esym who_of_groups)) rin.
have := same_valueE R (each _ rs_in); rewrite !ratio_times /= (sum_by_who bulk_of_group) who_of_groups.
by rewrite (sum_by_who cell_of_row) whos (cell_of_row _ rin) (bulk_of_group sin) sa ra.
Qed.
End Claims.

Lemma independent_sound (R : realFieldType) (T : table) : valid T -> Checker.independent (facts_of T) -> Meaning.independent R T.
Proof.
move=> ok; rewrite /Checker.independent /= (fullE ok) => /andP[full_ /forallb_forall each]; split=> // x a xin ain.
have rin := rows_of_have ok (has_all full_ xin ain).
by apply: (independent_rows R ok full_ rin) ain; apply: each _ rin.
Qed.
