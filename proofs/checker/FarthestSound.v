(* The greatest distance of a table, with its first pair of groups. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Distances Checker.
From FairauditChecker Require Import ListsSound TableSound WidestSound BlocksSound DistancesSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- All pairs, in order ---- *)

Definition triple : Type := (Z * side * side)%type.

Fixpoint pairs_of (x : Z) (ss : list side) : list triple :=
  match ss with
  | s :: rest => map (fun t => (x, s, t)) rest ++ pairs_of x rest
  | [::] => [::]
  end.

Definition step (best : option farthest) (t : triple) : option farthest := compare_two t.1.1 t.1.2 best t.2.

Lemma compare_allE x ss best : compare_all x ss best = fold_left step (pairs_of x ss) best.
Proof.
elim: ss best => //= s rest IH best; rewrite fold_left_app IH; congr fold_left.
by elim: (rest) best {IH} => //= t ts IH best; rewrite IH.
Qed.

Lemma farthest_ofE blocks : farthest_of blocks = fold_left step (flat_map (fun b => pairs_of b.1 b.2) blocks) None.
Proof. by rewrite /farthest_of; elim: blocks None => //= b bs IH best; rewrite fold_left_app -compare_allE IH. Qed.

Definition side_before (s t : side) : bool := Z.ltb (group_of s) (group_of t).

Lemma side_before_trans : transitive side_before.
Proof. by move=> s t u /Z.ltb_lt ab /Z.ltb_lt bc; apply/Z.ltb_lt; lia. Qed.

Definition place_of_pair (t : triple) : place := Place nothing t.1.1 nothing (group_of t.1.2) (group_of t.2).
Definition pair_before (t u : triple) : bool := before (place_of_pair t) (place_of_pair u).

Lemma pair_before_trans : transitive pair_before.
Proof. by move=> s t u; apply: lexicographic_trans. Qed.

Lemma later_side s ss t : sorted side_before (s :: ss) -> List.In t ss -> Z.lt (group_of s) (group_of t).
Proof.
by move=> /= /(order_path_min side_before_trans); elim: ss => //= u ss IH /andP[/Z.ltb_lt su all_] [<-|/(IH all_)].
Qed.

Lemma pairs_in x ss t : sorted side_before ss -> List.In t (pairs_of x ss) ->
  [/\ t.1.1 = x, List.In t.1.2 ss, List.In t.2 ss & Z.lt (group_of t.1.2) (group_of t.2)].
Proof.
elim: ss => //= s rest IH srt tin.
case: (in_app_or (List.map (fun t => (x, s, t)) rest) (pairs_of x rest) t tin) => {tin} [/in_map_iff[u [<- uin]]|/(IH (path_sorted srt))[-> ain bin lt]].
  by split=> //=; [left | right | apply: later_side srt uin].
by split=> //; right.
Qed.

Lemma pairs_have x ss s t : sorted side_before ss -> List.In s ss -> List.In t ss -> Z.lt (group_of s) (group_of t) ->
  List.In (x, s, t) (pairs_of x ss).
Proof.
elim: ss => //= u rest IH srt sin tin lt; apply: (in_or_app (List.map (fun t => (x, u, t)) rest) (pairs_of x rest)).
case: sin => [us|sin]; last case: tin => [ut|tin].
- left; rewrite us; apply: (in_map (fun t => (x, s, t))); case: tin => [ut|//]; by rewrite -us -ut in lt; lia.
- by have := later_side srt sin; rewrite ut; lia.
- by right; apply: IH => //; apply: path_sorted srt.
Qed.

Lemma pairs_sorted x ss : sorted side_before ss -> sorted pair_before (pairs_of x ss).
Proof.
elim: ss => //= s rest IH srt; rewrite sorted_pairwise; last exact: pair_before_trans.
rewrite pairwise_cat -!sorted_pairwise; try exact: pair_before_trans.
rewrite IH ?(path_sorted srt) // andbT; apply/andP; split.
  apply: in_all => t /in_map_iff[u [<- uin]]; apply: in_all => v vin.
  have [vx v1 _ _] := pairs_in (path_sorted srt) vin; have := later_side srt v1.
  have e : setting_of (place_of_pair (x, s, u)) = setting_of (place_of_pair v) by rewrite /setting_of /= vx.
  by rewrite /pair_before (before_same e) /= => lt; rewrite (proj2 (Z.ltb_lt _ _) lt).
rewrite sorted_map; apply: sub_sorted (path_sorted srt) => t u tu.
change (is_true (before (place_of_pair (x, s, t)) (place_of_pair (x, s, u)))).
by rewrite before_same //= Z.eqb_refl; apply/orP; right.
Qed.

(* ---- The best of all pairs ---- *)

Section Farthest.
Variables (R : realFieldType) (T : table) (q : quantity).
Hypothesis dq : is_distance q.
Local Notation ratio := (@ratio R).
Local Notation number := (@ListsSound.number R).
Local Notation quantity_at := (quantity_at R T q).

Definition apart_of (t : triple) : R := ratio (distance_of (exact_law t.1.2) (exact_law t.2)).

Definition well_measured (t : triple) : Prop :=
  quantity_at (place_of_pair t) = Some (apart_of t)
  /\ forall b, surely_not_farther b t.1.2 t.2 -> apart_of t <= ratio (apart b).

Definition pair_of (b : farthest) : triple := (in_ b, one b, other b).

Definition best_pair (done : list triple) (best : option farthest) : Prop :=
  if best is Some b then
    [/\ first_among quantity_at (fun p => exists2 t, List.In t done & p = place_of_pair t) (place_of_pair (pair_of b)),
        quantity_at (place_of_pair (pair_of b)) = Some (ratio (apart b)) & List.In (pair_of b) done]
  else done = [::].

Lemma step_best done best t :
  best_pair done best -> (forall d, List.In d done -> pair_before d t) -> well_measured t -> best_pair (done ++ [:: t]) (step best t).
Proof.
move=> so_far later [value screen].
have lone : first_among quantity_at (fun p => p = place_of_pair t) (place_of_pair t).
  by split=> // p ->; split=> [|b]; [apply: no_more_refl | have := lexicographic_irr (order_of (place_of_pair t)); rewrite -/(before _ _) b].
have fresh : step None t = Some (Farthest (distance_of (exact_law t.1.2) (exact_law t.2)) t.1.1 t.1.2 t.2) by [].
have same : pair_of (Farthest (distance_of (exact_law t.1.2) (exact_law t.2)) t.1.1 t.1.2 t.2) = t by case: (t) => -[].
case: best so_far => [b|->]; last first.
  rewrite fresh /best_pair same; split=> //; last by left.
  by apply: first_among_ext lone => p; split=> [->|[u [<-|[]] ->]] //; exists t => //; left.
move=> [first at_b b_in].
have -> : step (Some b) t = if apart_of t <= ratio (apart b) then Some b
    else Some (Farthest (distance_of (exact_law t.1.2) (exact_law t.2)) t.1.1 t.1.2 t.2).
  rewrite /step /compare_two; case sure: (surely_not_farther _ _ _); first by rewrite (screen _ sure).
  by rewrite /farther /= (at_mostE R).
have apart_places p p' : (exists2 u, List.In u done & p = place_of_pair u) -> p' = place_of_pair t -> ~~ before p' p.
  by move=> [u uin ->] ->; apply: lexicographic_asym; apply: later.
have ext p : (exists2 u, List.In u done & p = place_of_pair u) \/ p = place_of_pair t <-> exists2 u, List.In u (done ++ [:: t]) & p = place_of_pair u.
  split=> [[[u uin ->]|->]|[u /in_last[uin|<-] ->]]; [| |by left; exists u|by right].
    by exists u => //; apply/in_last; left.
  by exists t => //; apply/in_last; right.
have := first_of_both first lone apart_places; rewrite value at_b /=.
case: ifP => _ both; rewrite /best_pair ?same; split=> //; try by apply: first_among_ext both => p; apply: ext.
  by apply/in_last; left.
by apply/in_last; right.
Qed.

Lemma best_from cs done best : sorted pair_before (done ++ cs) -> (forall t, List.In t cs -> well_measured t) ->
  best_pair done best -> best_pair (done ++ cs) (fold_left step cs best).
Proof.
elim: cs done best => [|t cs IH] done best srt measured so_far; first by rewrite cats0.
have -> : done ++ t :: cs = (done ++ [:: t]) ++ cs by rewrite -catA.
apply: IH; first by rewrite -catA.
  by move=> u uin; apply: measured; right.
apply: step_best => //; last by apply: measured; left.
move=> d din; move: srt; elim: (done) din => //= e es IH' [->|din] path_e.
  by have := order_path_min pair_before_trans path_e; rewrite all_cat => /andP[_ /andP[]].
by apply: IH' => //; apply: path_sorted path_e.
Qed.

(* ---- The laws of the groups that take part, in order ---- *)

Definition sides_right (b : Z * list side) : Prop :=
  [/\ (nothing, b.1, nothing) \in settings T q, sorted side_before b.2,
      forall a, takes_part R T q (nothing, b.1, nothing) a <-> exists2 s, List.In s b.2 & group_of s = a
    & forall s, List.In s b.2 -> [/\ rough_law s = map rounded (exact_law s), of_length (decisions T) (exact_law s)
        & forall u, u \in range (decisions T) -> amount R T q (nothing, b.1, u) (group_of s) = number u (exact_law s)]].

Definition context_before (b c : Z * list side) : bool := Z.ltb b.1 c.1.

Definition sides_cover (bs : list (Z * list side)) : Prop :=
  [/\ forall b, List.In b bs -> sides_right b, sorted context_before bs
    & forall p, compares R T q p -> exists2 b, List.In b bs & setting_of p = (nothing, b.1, nothing)].

Lemma surplus_of x s t u : surplus R T q (place_of_pair (x, s, t)) u = amount R T q (nothing, x, u) (group_of s) - amount R T q (nothing, x, u) (group_of t).
Proof. by []. Qed.

Lemma measured_in b t : sides_right b -> List.In t (pairs_of b.1 b.2) -> well_measured t.
Proof.
move=> [_ srt _ laws] tin; have [tx s_in t_in _] := pairs_in srt tin.
have [r1 l1 a1] := laws _ s_in; have [r2 l2 a2] := laws _ t_in.
case: t tin tx s_in t_in r1 l1 a1 r2 l2 a2 => -[x s] t tin /= -> s_in t_in r1 l1 a1 r2 l2 a2; split.
  have -> : quantity_at (place_of_pair (b.1, s, t)) = Some (distance R T q (place_of_pair (b.1, s, t))).
    by rewrite /Meaning.quantity_at dq; case: (q) dq.
  congr Some; rewrite /apart_of /distance (distance_ofE R l1 l2); apply: eq_big_seq => u u_in.
  by rewrite surplus_of /excess -(a1 _ u_in) -(a2 _ u_in).
move=> f; rewrite /surely_not_farther r1 r2 /apart_of => /(embed_le R); rewrite !embedM => le.
have D0 := embed_pos R (Qden (apart f)); have S0 := scale_gt0 R; have rough := rough_distanceP R l1 l2.
rewrite -(ler_pmul2r S0); apply: le_trans rough _; rewrite /FractionsSound.ratio mulrAC ler_pdivl_mulr //.
Qed.

Lemma compared_pairs bs p : sides_cover bs -> compares R T q p <-> exists2 t, List.In t (flat_map (fun b => pairs_of b.1 b.2) bs) & p = place_of_pair t.
Proof.
move=> [rights srt all_]; split=> [comp|[t /in_flat_map[b [bin tin]] ->]].
  have [b bin e] := all_ _ comp; have [_ srt_b part _] := rights _ bin.
  move: comp => /and5P[_ _]; rewrite e dq => /part[s s_in sg] /part[t t_in tg] /Z.ltb_lt lt.
  exists (b.1, s, t); last by case: p e sg tg {lt} => r x u h l; rewrite /place_of_pair /setting_of /= => -[-> -> ->] -> ->.
  by apply/in_flat_map; exists b; split=> //; apply: pairs_have => //; rewrite sg tg.
have [at_b srt_b part _] := rights _ bin; have [tx s_in t_in lt] := pairs_in srt_b tin.
have nr : is_ratio q = false by case: (q) dq.
rewrite /compares nr dq /= /setting_of /= tx at_b /=; apply/and3P; split; last exact/Z.ltb_lt.
  by apply/part; exists t.1.2.
by apply/part; exists t.2.
Qed.

Lemma farthest_sound bs : sides_cover bs -> figure_holds R T q (option_map distance_figure (farthest_of bs)).
Proof.
move=> cov; have [rights srt all_] := cov; rewrite farthest_ofE; set L := flat_map _ _.
have exE : exists_at_all R T q = exists p, compares R T q p by case: (q) dq.
have srt_L : sorted pair_before L.
  apply: (flat_sorted pair_before_trans (lt := context_before) _ srt) => [b c d|b bin|b c t u bin cin bc tin uin].
  - by move=> /Z.ltb_lt cb /Z.ltb_lt bd; apply/Z.ltb_lt; lia.
  - by apply: pairs_sorted; have [] := rights _ bin.
  - have [tx _ _ _] := pairs_in (let: And4 _ s _ _ := rights _ bin in s) tin.
    have [ux _ _ _] := pairs_in (let: And4 _ s _ _ := rights _ cin in s) uin.
    by apply: before_settings; rewrite /setting_of /= tx ux; apply: later_context; apply/Z.ltb_lt.
have measured t : List.In t L -> well_measured t.
  by case/in_flat_map => b [bin tin]; apply: measured_in tin; apply: rights.
have := best_from (done := [::]) (best := None) srt_L measured erefl; rewrite [_ ++ _]/=.
case: (fold_left _ _ _) => [b [first value b_in]|none] /=; rewrite exE; last first.
  by move=> [p /(compared_pairs _ cov)[t]]; rewrite -/L none.
have comp : compares R T q (place_of_pair (pair_of b)) by apply/(compared_pairs _ cov); exists (pair_of b).
split; first by exists (place_of_pair (pair_of b)).
rewrite /witnessed -[witness _]/(place_of_pair (pair_of b)); split=> //.
  split=> // p' /(compared_pairs _ cov) p'in; case: first => _; exact.
rewrite dq; split=> //=; move: b_in => /in_flat_map[c [cin tin]]; have [_ srt_c _ laws] := rights _ cin.
have [/= tx s_in t_in _] := pairs_in srt_c tin; have [_ l1 a1] := laws _ s_in; have [_ l2 a2] := laws _ t_in.
rewrite (raised_fromE R l1 l2); apply: eq_in_filter => u u_in.
by rewrite surplus_of tx a1 ?a2.
Qed.
End Farthest.

(* ---- The blocks of a table ---- *)

Section Tables.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation F := (rows_of T).
Local Notation G := (if with_means T then with_mass (group_rows T F) else [::]).

Lemma equalized_odds_sound : figure_holds R T Equalized_odds (option_map distance_figure (farthest_of (map (fun xr => (xr.1, map side_of xr.2)) F))).
Proof.
apply: farthest_sound => //; split.
- move=> b /in_map_iff[[x rs] [<- xin]]; have [rsE x_in] := rows_of_in ok xin; split=> /=.
  + exact: (map_f (fun x => (nothing, x, nothing))).
  + by rewrite sorted_map; have := context_rows_sorted ok x; rewrite -rsE.
  + move=> a; split=> [/(has_cellP ok)[c cin [cx ca]]|[s /in_map_iff[r [<-]]]].
      exists (side_of (row_of T c)) => //; apply: in_map; rewrite rsE; apply: in_map.
      by apply/in_filter_seq; split=> //; apply/Z.eqb_eq.
    rewrite rsE => /in_map_iff[c [<- /in_context_in[cin cx]]] <-; by apply/(has_cellP ok); exists c.
  + move=> s /in_map_iff[r [<-]]; rewrite rsE => /in_map_iff[c [<- /in_context_in[cin cx]]]; split=> //; first exact: law_length.
    by move=> u _; rewrite -cx lawE.
- by rewrite sorted_map; apply: sub_sorted (rows_of_sorted ok).
- move=> p /and5P[_ at_ part _ _]; have xa : has_cell T (at_context p) (higher p) by [].
  exists (at_context p, map side_of (map (row_of T) (in_context T (at_context p)))).
    apply/in_map_iff; exists (at_context p, map (row_of T) (in_context T (at_context p))); split=> //; exact: rows_of_have xa.
  by move: at_ => /mapP[x _]; rewrite /setting_of /= => -[-> -> ->].
Qed.

Lemma demographic_parity_sound : figure_holds R T Demographic_parity (option_map distance_figure (farthest_of [:: (nothing, map side_of G)])).
Proof.
apply: farthest_sound => //; split=> //.
- move=> b [<-|[]]; split=> //=.
  + by rewrite sorted_map; apply: G_sorted.
  + move=> a; split=> [/(has_meanP R ok)[r rin <-]|[s /in_map_iff[r [<- rin]] <-]]; last by apply/(has_meanP R ok); exists r.
    by exists (side_of r) => //; apply: in_map.
  + move=> s /in_map_iff[r [<- rin]]; split=> //; last by move=> u u_in; apply: law_of_row.
    by have [_ gin _] := in_G ok rin; have [-> _] := group_rows_in gin; apply: group_law_length.
- by move=> p /and5P[_ at_ _ _ _]; exists (nothing, map side_of G); [left | move: at_; rewrite mem_seq1 => /eqP].
Qed.
End Tables.
