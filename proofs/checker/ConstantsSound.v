(* The constants of the utility are computed as Meaning.v has them. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Checker ListsSound TableSound BlocksSound FiguresSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Extremes.
Variable R : realFieldType.
Local Notation ratio := (@ratio R).

Lemma fold_greater qs q : let g := fold_left greater qs q in
  (g = q \/ List.In g qs) /\ (ratio q <= ratio g /\ forall r, List.In r qs -> ratio r <= ratio g).
Proof.
elim: qs q => [|p qs IH] q /=; first by split; [left | split].
have [picked [least all_]] := IH (greater q p).
have [le_q le_p] : ratio q <= ratio (greater q p) /\ ratio p <= ratio (greater q p).
  by rewrite /greater (at_mostE R); case: ifP => [le|/negbT]; [by split | rewrite -ltNge => /ltW le; by split].
split; last by split=> [|r [<-|/all_ //]]; apply: le_trans least.
by case: picked => [->|]; [rewrite /greater; case: ifP => _; [right; left | left] | right; right].
Qed.

Lemma greatest_inP qs : if greatest_in qs is Some g then List.In g qs /\ forall q, List.In q qs -> ratio q <= ratio g else qs = [::].
Proof.
case: qs => //= q qs; have [picked [least all_]] := fold_greater qs q.
by split=> [|r [<-|/all_]] //; case: picked => [->|]; [left | right].
Qed.

Lemma fold_lesser qs q : let g := fold_left lesser qs q in
  (g = q \/ List.In g qs) /\ (ratio g <= ratio q /\ forall r, List.In r qs -> ratio g <= ratio r).
Proof.
elim: qs q => [|p qs IH] q /=; first by split; [left | split].
have [picked [least all_]] := IH (lesser q p).
have [le_q le_p] : ratio (lesser q p) <= ratio q /\ ratio (lesser q p) <= ratio p.
  by rewrite /lesser (at_mostE R); case: ifP => [le|/negbT]; [by split | rewrite -ltNge => /ltW le; by split].
split; last by split=> [|r [<-|/all_ //]]; apply: le_trans least _.
by case: picked => [->|]; [rewrite /lesser; case: ifP => _; [left | right; left] | right; right].
Qed.

Lemma least_inP qs : if least_in qs is Some g then List.In g qs /\ forall q, List.In q qs -> ratio g <= ratio q else qs = [::].
Proof.
case: qs => //= q qs; have [picked [least all_]] := fold_lesser qs q.
by split=> [|r [<-|/all_]] //; case: picked => [->|]; [left | right].
Qed.
End Extremes.

Section Constants.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).
Local Notation F := (rows_of T).

Lemma gamma_sound g : greatest_in (given T) = Some g -> is_greatest (is_given T) (ratio g).
Proof. by move=> e; have := greatest_inP R (given T); rewrite e => -[gin le]; split=> [|w [q qin ->]]; [exists g | apply: le]. Qed.

Lemma least_sound g : least_in (given T) = Some g -> is_least (is_given T) (ratio g).
Proof. by move=> e; have := least_inP R (given T); rewrite e => -[gin le]; split=> [|w [q qin ->]]; [exists g | apply: le]. Qed.

(* ---- tau ---- *)

Definition means_compared : list Q := flat_map (fun xr => match xr.2 with _ :: _ :: _ => map mean xr.2 | _ => [::] end) F.

Lemma row_sorted_head r rs s : sorted row_before (r :: rs) -> List.In s rs -> Z.lt (who r) (who s).
Proof.
have tr : transitive row_before by move=> a b c /Z.ltb_lt ab /Z.ltb_lt bc; apply/Z.ltb_lt; lia.
by move=> /= /(order_path_min tr); elim: rs => //= t rs IH /andP[/Z.ltb_lt rt all_] [<-|/(IH all_)].
Qed.

Lemma means_comparedP v : compared_expectation T v <-> exists2 q, List.In q means_compared & v = ratio q.
Proof.
split=> [[x [a [b [xa xb ab ->]]]]|[q /in_flat_map[[x rs] [xin qin]] ->]].
  case/(has_cellP ok): (xa) => c cin [cx ca]; case/(has_cellP ok): xb => d din [dx da].
  exists (mean (row_of T c)); last by rewrite -cx -ca expectationE.
  apply/in_flat_map; exists (x, map (row_of T) (in_context T x)); split; first exact: rows_of_have xa.
  have mem e : List.In e (cells T) -> context e = x -> List.In e (in_context T x).
    by move=> ein ex; apply/in_filter_seq; split=> //; apply/Z.eqb_eq.
  have := mem c cin cx; have := mem d din dx.
  case e: (in_context T x) => [|f [|g fs]] //=; first by move=> [fd|[]] [fc|[]]; case: ab; rewrite -ca -da -fd -fc.
  have mapped l : List.In c l -> List.In (mean (row_of T c)) (List.map mean (List.map (row_of T) l)) by move=> cl; do 2 apply: in_map.
  by move=> _; apply: (mapped (f :: g :: fs)).
have [rsE x_in] := rows_of_in ok xin; have := context_rows_sorted ok x; rewrite -rsE => srt.
have rows r : List.In r rs -> exists c, [/\ List.In c (cells T), context c = x & r = row_of T c].
  by rewrite rsE => /in_map_iff[c [<- /in_context_in[cin cx]]]; exists c.
have [qin' [r1 [r2 [rest rs2]]]] : List.In q (List.map mean rs) /\ exists r1 r2 rest, rs = r1 :: r2 :: rest.
  by move: qin => /=; case: (rs) => [|r1 [|r2 rest]] //= h; split=> //; exists r1, r2, rest.
have [r [<- rin]] := iffLR (in_map_iff _ _ _) qin'; have [c [cin cx re]] := rows _ rin.
rewrite rs2 in srt rin rows.
have [s sin differ] : exists2 s, List.In s (r1 :: r2 :: rest) & who r <> who s.
  case: rin => [<-|rin]; first by exists r2; [right; left | have := row_sorted_head srt (or_introl erefl); lia].
  by exists r1; [left | have := row_sorted_head srt rin; lia].
have [d [din dx se]] := rows _ sin; exists x, (group c), (group d).
split; [by rewrite -cx has_cell_of | by rewrite -dx has_cell_of | by move: differ; rewrite re se | by rewrite re -cx expectationE].
Qed.

Lemma tau_sound v : same_option same_value v (least_in means_compared) -> holds R T (Tau_is v).
Proof.
have := least_inP R means_compared; case: (least_in _) v => [g|] [v|] //=.
  move=> [gin le] /(same_valueE R) ->; split; first by apply/means_comparedP; exists g.
  by move=> w /means_comparedP[q qin ->]; apply: le.
by move=> nobody _ [w /means_comparedP[q]]; rewrite nobody.
Qed.

(* ---- How much the utility depends on the group ---- *)

Definition stated_of (gs : list (option Q)) : list Q := flat_map (fun g => match g with Some g => [:: g] | None => [::] end) gs.

Lemma in_stated gs g : List.In g (stated_of gs) <-> List.In (Some g) gs.
Proof.
split=> [/in_flat_map[[h|] [hin]]|gin]; [by case=> [<-|[]] | by [] |].
by apply/in_flat_map; exists (Some g); split=> //; left.
Qed.

Lemma spread_cases gs : (ratio (spread gs) = 0 /\ stated_of gs = [::])
  \/ exists g h, [/\ List.In (Some g) gs, List.In (Some h) gs & ratio (spread gs) = ratio g - ratio h].
Proof.
rewrite /spread -/(stated_of gs); have := greatest_inP R (stated_of gs); have := least_inP R (stated_of gs).
case: (greatest_in _) => [g|]; case: (least_in _) => [l|]; try by move=> *; left; rewrite ratio_zero.
move=> [lin _] [gin _]; right; exists g, l; rewrite ratio_plus ratio_minus; split=> //; exact/in_stated.
Qed.

Lemma spread_greatest gs g h : List.In (Some g) gs -> List.In (Some h) gs -> ratio g - ratio h <= ratio (spread gs).
Proof.
move=> /in_stated gin /in_stated hin; rewrite /spread -/(stated_of gs).
have := greatest_inP R (stated_of gs); have := least_inP R (stated_of gs).
case: (greatest_in _) => [g'|]; case: (least_in _) => [l|]; try by move=> e; rewrite e in gin.
  by move=> [_ low] [_ high]; rewrite ratio_plus ratio_minus ler_sub // ?high ?low.
by move=> _ e; rewrite e in gin.
Qed.

Lemma in_spreads n rows s : List.In s (spreads n rows) <-> exists2 i, (i < n)%N & s = spread (map (fun r => List.nth i r None) rows).
Proof.
elim: n rows => [|n IH] rows /=; first by split=> // -[].
have e0 : map (hd None) rows = map (fun r : list (option Q) => List.nth 0 r None) rows by apply: eq_map => -[].
have e1 i : map (fun r => List.nth i r None) (map (@tl (option Q)) rows) = map (fun r : list (option Q) => List.nth i.+1 r None) rows.
  by rewrite -map_comp; apply: eq_map => -[|g gs] //=; case: (i).
rewrite IH; split=> [[<-|[i ilt ->]]|[[|i] ilt ->]].
- by exists 0%N => //; rewrite -e0.
- by exists i.+1 => //; rewrite -e1.
- by left; rewrite -e0.
- by right; exists i => //; rewrite -e1.
Qed.

Definition all_spreads : list Q := flat_map (fun xcs => spreads (Z.to_nat (decisions T)) (map gains xcs.2)) (runs context (cells T)).

Hypothesis own : utility T = None.

Lemma column_in x u g : List.In (Some g) (map (fun r => List.nth u r None) (map gains (in_context T x))) <->
  exists a, stated_gain T x a (Z.of_nat u) = Some g.
Proof.
split=> [/in_map_iff[gs [e /in_map_iff[c [ce /in_context_in[cin cx]]]]]|[a]].
  by exists (group c); rewrite /stated_gain -cx cell_of // Nat2Z.id ce.
rewrite /stated_gain; case e: (cell_at T x a) => [c|] // gE; have [cin cx _] := cell_atP e.
apply/in_map_iff; exists (gains c); split; first by rewrite Nat2Z.id in gE.
by apply/in_map_iff; exists c; split=> //; apply/in_filter_seq; split=> //; apply/Z.eqb_eq.
Qed.

Lemma in_decisions i : (i < Z.to_nat (decisions T))%N -> Z.of_nat i \in range (decisions T).
Proof.
move=> /ssrnat.ltP lt; rewrite mem_range; apply/andP; split; [apply/Z.leb_le | apply/Z.ltb_lt]; lia.
Qed.

Lemma spreads_are_gaps s : List.In s all_spreads -> ratio s = 0 \/ gap_of_groups T (ratio s).
Proof.
case/in_flat_map => -[x cs] [xin /in_spreads[i ilt ->]]; have [-> _] := (proj2 (runs_of_cells ok)) _ _ xin => /=.
case: (spread_cases (map (fun r => List.nth i r None) (map gains (in_context T x)))) => [[-> _]|[g [h [gin hin ->]]]]; [by left | right].
have [a ga] := (iffLR (column_in _ _ _) gin); have [b hb] := (iffLR (column_in _ _ _) hin).
by split=> //; exists x, a, b, (Z.of_nat i), g, h; split=> //; apply: in_decisions.
Qed.

Lemma gaps_below w : gap_of_groups T w -> exists2 s, List.In s all_spreads & w <= ratio s.
Proof.
case=> _ [x [a [b [u [g [h [u_in ga hb ->]]]]]]].
have /andP[/Z.leb_le u0 /Z.ltb_lt un] : inside (decisions T) u by rewrite -mem_range.
exists (spread (map (fun r => List.nth (Z.to_nat u) r None) (map gains (in_context T x)))).
  have xa : has_cell T x a by move: ga; rewrite /stated_gain /has_cell; case: (cell_at T x a).
  case/(has_cellP ok): xa => c cin [cx _]; have [cs csin] := runs_have context cin.
  have [csE _] := (proj2 (runs_of_cells ok)) _ _ csin; apply/in_flat_map; exists (context c, cs); split=> //.
  by apply/in_spreads; exists (Z.to_nat u); [apply/ssrnat.ltP; lia | rewrite csE cx].
by apply: spread_greatest; apply/column_in; [exists a | exists b]; rewrite Z2Nat.id.
Qed.

Lemma lipschitz_own : lipschitz T = fold_left greater all_spreads zero.
Proof. by rewrite /lipschitz own. Qed.

Lemma lipschitz_sound_own : lipschitz_is T (ratio (lipschitz T)).
Proof.
rewrite lipschitz_own; have [picked [least all_]] := fold_greater R all_spreads zero; split.
  by move=> w /gaps_below[s sin le]; apply: le_trans le (all_ _ sin).
have [zero_|gap] : ratio (fold_left greater all_spreads zero) = 0 \/ gap_of_groups T (ratio (fold_left greater all_spreads zero)).
- by case: picked => [->|/spreads_are_gaps //]; left; rewrite ratio_zero.
- rewrite zero_; case some: (has (fun c => has (fun u => if List.nth (Z.to_nat u) (gains c) None is Some _ then true else false) (range (decisions T))) (cells T)).
    left; split=> //; have [c cin /hasP[u u_in]] : exists2 c, List.In c (cells T) & has (fun u => if List.nth (Z.to_nat u) (gains c) None is Some _ then true else false) (range (decisions T)).
      by elim: (cells T) some => //= c cs IH /orP[yes|/IH[d din yes]]; [exists c; [left|] | exists d; [right|]].
    case e: (List.nth _ _ _) => [g|] // _; exists (context c), (group c), (group c), u, g, g.
    by split; rewrite ?subrr // /stated_gain cell_of.
  right; split=> // -[w [_ [x [a [b [u [g [h [u_in ga _ _]]]]]]]]]; move/negP: some; apply.
  move: ga; rewrite /stated_gain; case e: (cell_at T x a) => [c|] // gE; have [cin _ _] := cell_atP e.
  have : has (fun u => if List.nth (Z.to_nat u) (gains c) None is Some _ then true else false) (range (decisions T)).
    by apply/hasP; exists u => //; rewrite gE.
  by elim: (cells T) cin => //= d ds IH [->|/IH yes] yes'; rewrite ?yes' // yes // orbT.
by left.
Qed.
End Constants.

Section Lipschitz.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).

Lemma lipschitz_sound : lipschitz_is T (ratio (lipschitz T)).
Proof.
case own: (utility T) => [gs|]; last exact: lipschitz_sound_own.
rewrite /lipschitz own ratio_zero; split=> [w [e]|]; first by rewrite own in e.
by right; split=> // -[w [e]]; rewrite own in e.
Qed.

Lemma depends_sound b : Bool.eqb b (positive_fraction (lipschitz T)) -> holds R T (Depends_on_group_is b).
Proof.
move/eqb_prop => -> /=; rewrite (positive_fractionE R); have [below exact_] := lipschitz_sound.
split=> [pos|[w gap w0]]; last by apply: lt_le_trans w0 (below _ gap).
by case: exact_ => [gap|[e _]]; [exists (ratio (lipschitz T)) | rewrite e ltxx in pos].
Qed.
End Lipschitz.
