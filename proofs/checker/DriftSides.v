(* What the program finds of all pairs of a table under drift, and of both sides of a pair that is named. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From mathcomp.zify Require Import ssrZ.
From Fairaudit Require Import Definitions.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Checker Drift ListsSound TableSound BlocksSound FiguresSound.
From FairauditChecker Require Import MovedLaws MovedCells DriftCells DriftUnits DriftPairs DriftEnds.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Sides.
Variables (R : realFieldType) (T : table).
Hypotheses (ok : valid T) (unsigned : signed T = false).
Variables (k : move) (amount : option Q) (local : bool).
Hypothesis amount_ok : an_amount k amount.
Local Notation ratio := (@ratio R).
Local Notation movers := (movers_of T (rows_of T)).
Local Notation A := (group_rows T (rows_of T)).
Local Notation es := (own_ends T k amount).
Local Notation known := (has_ends T k amount).
Local Notation unit_ := (unit_of T local).
Local Notation E D c := (expectation_in T D (context c) (group c)).

Lemma known_ends c : known c -> ends_of k amount (its T c) = Some (es c).
Proof. by []. Qed.

Lemma own_ends_ge0 c : List.In c (cells T) -> known c -> 0 <= ratio (es c).1 /\ ratio (es c).1 <= ratio (es c).2.
Proof.
move=> c_in found; have lP := is_a_law R ok c_in.
have low_le : ratio (es c).1 <= ratio (es c).2.
  have dr : drifted T k (if amount is Some w then ratio w else if k is By_factor then 1 else 0) (law R T).
    apply: (all_moved ok) => d d_in; apply: (law_itself ok d_in); move: amount_ok.
    case: (amount) => [w|_]; first exact: amount_starts.
    by case: (k); rewrite /= ?lexx ?ler01.
  have mv : meant amount (if amount is Some w then ratio w else if k is By_factor then 1 else 0 : R) by case: (amount) => [w|] /=.
  by have /andP[low high] := cell_bounds ok c_in amount_ok found mv dr; apply: le_trans high.
split=> //; have [_ attained] := are_its_ends R ok c_in amount_ok found.
have gain0 (i : 'I_(Z.to_nat (decisions T))) : 0 <= listed R (gains_of T c) i by rewrite listed_gain // /by_number; apply: gain_ge0.
have lastE : amount = None -> ratio (es c).1 = last_on R T c k false.
  move=> none; rewrite /last_on /last_of /signed_as /directed /own_ends /ends_of /ends_of_law none.
  by case: (k).
have [none|[w is_w]] : amount = None \/ exists w, amount = Some w by case: (amount) => [w|]; [right; exists w | left].
  rewrite lastE //; have [[i _ gi] _] := last_top R ok c_in k false.
  by move: gi => /oppr_inj <-.
rewrite is_w in attained *; case: attained => -[D [[D0 _] _] <-] _; apply: sumr_ge0 => i _; by rewrite mulr_ge0.
Qed.

(* ---- One side ---- *)

Section OneSide.
Variables (x a : Z) (up : bool) (s : side).
Hypotheses (some : unit_ x a <> [::]) (found : side_of k amount up (movers_in T (unit_ x a)) = Some s).

Let bundled := unit_bundle R some.

Lemma sideE : [/\ forall m c, List.In (m, c) (unit_ x a) -> known c,
  ratio (at_end s) = mean_in (unit_ x a) (fun c => end_on R (es c) up), ratio (in_the_end s) = mean_in (unit_ x a) (fun c => last_on R T c k up),
  reached s = top_of (List.map (fun mc => reached_by up mc.2) (movers_in T (unit_ x a)))
  & constant s = forallb (fun mc => is_constant k mc.2) (movers_in T (unit_ x a))].
Proof.
move: found; rewrite /side_of; case over: (ends_over _ _ _) => [e|] //= [<-].
have [each [low high]] := ends_overE bundled over; split=> //=.
  by case: (up) => /=; rewrite ?low ?high.
rewrite -[RHS]/(mean_in _ (fun c => ratio (last_of k up (its T c)))) -(ratio_mean_over bundled (fun c => last_of k up (its T c))).
by congr (ratio (mean_over _)); rewrite /movers_in; elim: (unit_ x a) => //= mc rest ->.
Qed.

Lemma side_bounds v D : meant amount v -> drifted T k v D ->
  if up then amount_in T D local x a <= ratio (at_end s) else ratio (at_end s) <= amount_in T D local x a.
Proof.
move=> mv dr; have [each -> _ _ _] := sideE; rewrite (unit_amount ok D some).
have bounds m c : List.In (m, c) (unit_ x a) -> ratio (es c).1 <= E D c <= ratio (es c).2.
  by move=> there; have [c_in _ _ _] := in_unit R there; apply: (cell_bounds ok c_in amount_ok (each m c there) mv dr).
by rewrite /end_on; case: (up); apply: (mean_in_le bundled) => m c there; have /andP[] := bounds m c there.
Qed.

Lemma side_before v D : before_amount amount v -> drifted T k v D ->
  (match k, amount with By_variation, Some w => at_most w (reached s) | By_variation, None => false | By_factor, _ => ~~ constant s end) ->
  if up then amount_in T D local x a < ratio (at_end s) else ratio (at_end s) < amount_in T D local x a.
Proof.
move=> before dr on; have [each -> _ reachedE constantE] := sideE; rewrite (unit_amount ok D some).
have mv : meant amount v by move: before; case: (amount) => //= w; apply: ltW.
have bounds m c : List.In (m, c) (unit_ x a) -> ratio (es c).1 <= E D c <= ratio (es c).2.
  by move=> there; have [c_in _ _ _] := in_unit R there; apply: (cell_bounds ok c_in amount_ok (each m c there) mv dr).
have [m [c [there moving]]] : exists m c, List.In (m, c) (unit_ x a) /\ moves_on k amount up (its T c).
  have pick (f : mover -> bool) mv' : List.In mv' (movers_in T (unit_ x a)) -> f mv'.2 -> exists m c, List.In (m, c) (unit_ x a) /\ f (its T c).
    by case/in_map_iff => -[m c] [<- there] /= fc; exists m, c.
  have top : List.In (reached s) (List.map (fun mc => reached_by up mc.2) (movers_in T (unit_ x a))).
    rewrite reachedE; have [|there _] := @top_ofP R (List.map (fun mc => reached_by up mc.2) (movers_in T (unit_ x a))) => //.
    by move: some; case: (unit_ x a).
  have moving_factor : ~~ constant s -> exists m c, List.In (m, c) (unit_ x a) /\ ~~ is_constant k (its T c).
    rewrite constantE => no; have : existsb (fun mc => ~~ is_constant k mc.2) (movers_in T (unit_ x a)).
      by move: no; elim: (movers_in _ _) => //= mc rest IH; rewrite negb_and => /orP[->|/IH ->]; rewrite ?orbT.
    by case/existsb_exists => mc [mc_in nc]; exact: (pick (fun c => ~~ is_constant k c) mc mc_in nc).
  rewrite /moves_on; move: on moving_factor; case: k amount => [] [w|] //= on; try by move/(_ on).
  move=> _; case/in_map_iff: top => mc [e mc_in].
  by apply: (pick (fun c => at_most w (reached_by up c)) mc mc_in); rewrite e.
have [c_in _ _ _] := in_unit R there.
have strict := cell_before ok c_in amount_ok (each m c there) dr before moving.
rewrite /end_on; move: strict; case: (up) => strict; apply: (mean_in_lt bundled) => [m' c' there'|];
  by [have /andP[] := bounds m' c' there' | exists m, c].
Qed.

Lemma side_ge0 : 0 <= ratio (at_end s).
Proof.
have [each -> _ _ _] := sideE; rewrite -(@mean_in_const _ _ _ bundled (fun=> 0) 0) //; apply: (mean_in_le bundled) => m c there.
have [c_in _ _ _] := in_unit R there; have [low0 le] := own_ends_ge0 c_in (each _ _ there).
by rewrite /end_on; case: (up) => //; apply: le_trans le.
Qed.
End OneSide.

(* ---- A pair ---- *)

Section OnePair.
Variables (x h l : Z) (up : bool) (high low : side).
Hypotheses (ne : h <> l) (some_h : unit_ x h <> [::]) (some_l : unit_ x l <> [::]).
Hypotheses (found_h : side_of k amount up (movers_in T (unit_ x h)) = Some high).
Hypotheses (found_l : side_of k amount (~~ up) (movers_in T (unit_ x l)) = Some low).

Lemma pair_attains w : amount = Some w -> exists D, [/\ drifted T k (ratio w) D, amount_in T D local x h = ratio (at_end high)
  & amount_in T D local x l = ratio (at_end low)].
Proof.
move=> is_w; have [each_h -> _ _ _] := sideE some_h found_h; have [each_l -> _ _ _] := sideE some_l found_l.
have st : starts k (ratio w : R) by move: amount_ok; rewrite is_w; apply: amount_starts.
have attain side_ c : List.In c (cells T) -> known c ->
    exists2 D, moved T k (ratio w) (law R T (context c) (group c)) D &
      \sum_(u <- range (decisions T)) D u * gain R T (context c) (group c) u = end_on R (es c) side_.
  move=> c_in kc; apply: (cell_attains ok c_in amount_ok kc is_w).
  by have [_ le] := own_ends_ge0 c_in kc; rewrite /end_on; case: side_; rewrite lexx le.
apply: (move_both ok st ne some_h some_l) => m c there; have [c_in _ _ _] := in_unit R there; apply: attain => //.
  exact: each_h there.
exact: each_l there.
Qed.

Lemma pair_rises w v : amount = Some w -> ratio w < v -> exists D t, [/\ 0 < t, drifted T k v D,
    amount_in T D local x h = (1 - t) * ratio (at_end high) + t * ratio (in_the_end high)
  & amount_in T D local x l = (1 - t) * ratio (at_end low) + t * ratio (in_the_end low)].
Proof.
move=> is_w far; have [each_h -> -> _ _] := sideE some_h found_h; have [each_l -> -> _ _] := sideE some_l found_l.
have st : starts k (ratio w : R) by move: amount_ok; rewrite is_w; apply: amount_starts.
have st' : starts k v by move: st; case: (k) => /= st0; apply: le_trans (ltW far).
have common (B : bundle) side_ : (forall m c, List.In (m, c) B -> List.In c (cells T) /\ known c) -> exists2 t0, 0 < t0 <= 1 &
    forall t m c, 0 <= t <= t0 -> List.In (m, c) B -> exists2 D, moved T k v (law R T (context c) (group c)) D &
      \sum_(u <- range (decisions T)) D u * gain R T (context c) (group c) u = (1 - t) * end_on R (es c) side_ + t * last_on R T c k side_.
  elim: B => [|[m c] B IH] all_; first by exists 1; rewrite ?ltr01 ?lexx.
  have [|t1 /andP[t10 t11] rest] := IH; first by move=> m' c' there; apply: (all_ m'); right.
  have [c_in kc] := all_ m c (or_introl erefl).
  have [t2 /andP[t20 t21] own] := cell_rises ok c_in amount_ok kc side_ is_w far.
  exists (Num.min t1 t2); first by rewrite lt_minr t10 t20 le_minl t11.
  by move=> t m' c' /andP[t0]; rewrite le_minr => /andP[tt1 tt2] [[_ <-]|there]; [apply: own; rewrite t0 | apply: (rest t m' c'); rewrite ?t0].
have [|t1 /andP[t10 _] rise_h] := common (unit_ x h) up.
  by move=> m c there; have [c_in _ _ _] := in_unit R there; split=> //; apply: each_h there.
have [|t2 /andP[t20 _] rise_l] := common (unit_ x l) (~~ up).
  by move=> m c there; have [c_in _ _ _] := in_unit R there; split=> //; apply: each_l there.
pose t := Num.min t1 t2; have t0 : 0 < t by rewrite lt_minr t10 t20.
have tt1 : 0 <= t <= t1 by rewrite (ltW t0) le_minl lexx.
have tt2 : 0 <= t <= t2 by rewrite (ltW t0) le_minl lexx orbT.
have [D [dr eh el]] := move_both ok st' ne some_h some_l (fun m c there => rise_h t m c tt1 there) (fun m c there => rise_l t m c tt2 there).
by exists D, t; rewrite eh el !mean_in_mix.
Qed.
End OnePair.

(* ---- The pair that is named ---- *)

Lemma sides_ofP worst fs p high low : sides_of T A k amount worst local movers fs (Some p) = Some (high, low) ->
  let x := at_context p in
  [/\ compares R T (ratio_of_all local) (placed local x (higher p) (lower p)), higher p <> lower p,
      x = at_context (placed local x (higher p) (lower p)) /\ (unit_ x (higher p) <> [::] /\ unit_ x (lower p) <> [::]),
      side_of k amount worst (movers_in T (unit_ x (higher p))) = Some high
    & side_of k amount (~~ worst) (movers_in T (unit_ x (lower p))) = Some low].
Proof.
rewrite /sides_of !(cells_atE ok); case: ifP => // /and5P[/negP ne0 there there' at_ /andP[some some']].
have ne : higher p <> lower p by move=> e; apply: ne0; rewrite e Z.eqb_refl.
have nonempty B : (match movers_in T B with [::] => false | _ => true end) -> B <> [::] by case: B.
case one: (side_of _ _ _ _) => [s|] //; case other: (side_of _ _ _ _) => [s'|] // [<- <-].
move/nonempty: some => some; move/nonempty: some' => some'.
split=> //; last by split=> //; move: at_; rewrite /placed /=; case: (local) => // /Z.eqb_eq.
rewrite /compares unsigned andbF /placed /=.
have mean_of a : is_followed fs a && existsb (fun r => Z.eqb (who r) a) (compared_groups T A) -> has_mean R T a.
  by case/andP => _ /existsb_exists[r [rin /Z.eqb_eq e]]; apply/(has_meanP R ok); exists r.
move: there there' at_ some some'; case: (local) => there there' at_ some some' /=.
  have cell_of_unit a : unit_of T true (at_context p) a <> [::] -> has_cell T (at_context p) a.
    case e: (unit_of _ _ _ _) => [|[m c] rest] // _; have [] := @in_unit R T true (at_context p) a m c; first by rewrite e; left.
    by move=> c_in <- /(_ isT) <- _; apply: has_cell_of.
  have has_h := cell_of_unit _ some; rewrite has_h (cell_of_unit _ some') /=; apply/andP; split; last by apply/eqP.
  by apply: map_f; case/(has_cellP ok): has_h => c c_in [<- _]; apply: context_inside.
by rewrite (mean_of _ there) (mean_of _ there') /=; apply/eqP.
Qed.

(* ---- All pairs ---- *)

Local Notation top_ worst c := (end_on R (es c) worst).

Lemma everywhereP worst g : ends_everywhere T A k amount worst local movers = Some g ->
  no_more (Some 1) (extended R g) /\
  forall p, compares R T (ratio_of_all local) p -> let x := at_context p in
    [/\ higher p <> lower p, unit_ x (higher p) <> [::] /\ unit_ x (lower p) <> [::],
        (forall m c, List.In (m, c) (unit_ x (higher p)) -> known c) /\ (forall m c, List.In (m, c) (unit_ x (lower p)) -> known c)
      & no_more (quotient (mean_in (unit_ x (higher p)) (fun c => top_ worst c)) (mean_in (unit_ x (lower p)) (fun c => top_ (~~ worst) c))) (extended R g)].
Proof.
have orient (e : Q * Q) : (oriented worst e).1 = (if worst then e.2 else e.1) /\ (oriented worst e).2 = (if ~~ worst then e.2 else e.1).
  by rewrite /oriented; case: worst.
rewrite /ends_everywhere; case locally: local; last first.
  rewrite /group_ends; case all_: (all_some _ _) => [b|] //= [<-].
  have group_ r : List.In r (compared_groups T A) -> unit_of T false nothing (who r) <> [::].
    move=> rin; have mean_ : has_mean R T (who r) by apply/(has_meanP R ok); exists r.
    exact: (unit_of_mean ok mean_).
  pose f r := option_map (fun e => (who r, oriented worst e)) (ends_over k amount (cells_at movers false nothing (who r))).
  have [each bE] := all_some_map (xs := compared_groups T A) (f := f) (nothing, (zero, zero)) all_.
  have found r : List.In r (compared_groups T A) -> exists e, ends_over k amount (movers_in T (unit_of T false nothing (who r))) = Some e /\
      odflt (nothing, (zero, zero)) (f r) = (who r, oriented worst e).
    by move/each; rewrite /f (cells_atE ok); case: (ends_over _ _ _) => [e|] //= _; exists e.
  have nonneg : nonneg_ends R b.
    rewrite bE => e /in_map_iff[r [<- rin]]; have [e' [over ->]] := found r rin.
    have bundled := unit_bundle R (group_ r rin).
    have [knowns [lowE highE]] := ends_overE bundled over; rewrite /top_end /bottom_end /=.
    have [-> ->] := orient e'.
    have ge0 side_ : 0 <= mean_in (unit_of T false nothing (who r)) (fun c => ratio (if side_ then (es c).2 else (es c).1)).
      rewrite -(@mean_in_const _ _ _ bundled (fun=> 0) 0) //; apply: (mean_in_le bundled) => m c there.
      have [c_in _ _ _] := in_unit R there; have [low0 le] := own_ends_ge0 c_in (knowns _ _ there).
      by case: side_ => //; apply: le_trans le.
    by split; [case: (worst) | case: (~~ worst)]; rewrite ?lowE ?highE; [exact: (ge0 true) | exact: (ge0 false) | exact: (ge0 true) | exact: (ge0 false)].
  have [|one_ pairs] := @greatest_ofP R [:: b]; first by move=> d [<-|[]].
  split=> // p comp; have [x [h [l [pE ne some some']]]] := @comparesE R T ok false p comp; rewrite pE /= in some some' *.
  move: comp; rewrite pE /compares /= => /and4P[_ mean_h mean_l _].
  case/(has_meanP R ok): mean_h => r rin rE; case/(has_meanP R ok): mean_l => r' rin' rE'.
  have [e [over oe]] := found r rin; have [e' [over' oe']] := found r' rin'.
  have [knowns [lowE highE]] := ends_overE (unit_bundle R (group_ r rin)) over.
  have [knowns' [lowE' highE']] := ends_overE (unit_bundle R (group_ r' rin')) over'.
  rewrite rE rE' in knowns lowE highE knowns' lowE' highE'.
  split=> //; have := pairs b (who r, oriented worst e) (who r', oriented worst e'); rewrite /top_end /bottom_end /=.
  have [-> _] := orient e; have [_ ->] := orient e'; rewrite rE rE' /end_on => pairs_.
  have in_b r0 e0 : List.In r0 (compared_groups T A) -> odflt (nothing, (zero, zero)) (f r0) = (who r0, oriented worst e0) ->
      List.In (who r0, oriented worst e0) b by move=> r0in <-; rewrite bE; apply: (in_map (fun r => odflt (nothing, (zero, zero)) (f r))).
  have := pairs_ (or_introl erefl); rewrite -{1}rE -{1}rE' => /(_ (in_b _ _ rin oe) (in_b _ _ rin' oe') ne).
  by case: (worst) => /=; rewrite ?lowE ?highE ?lowE' ?highE'.
rewrite /local_ends moversE; case all_: (all_some _ _) => [bs|] //= [<-].
pose f c := option_map (fun e => (who (its T c).1, oriented worst e)) (ends_of k amount (its T c)).
pose F (xcs : Z * list cell) := all_some [::] [seq f c | c <- xcs.2].
have allE : all_some [::] [seq F xcs | xcs <- runs context (cells T)] = Some bs.
  rewrite -all_; congr all_some; elim: (runs _ _) => //= -[x cs] rest ->; congr (_ :: _).
  by rewrite /F /=; congr all_some; elim: cs => //= c cs ->.
have [each bsE] := all_some_map [::] allE.
have cell_entry x cs c : List.In (x, cs) (runs context (cells T)) -> List.In c cs -> known c /\
    List.In (group c, oriented worst (es c)) (odflt [::] (F (x, cs))).
  move=> run c_in; have := each _ run; rewrite {1}/F => /(all_some_map (nothing, (zero, zero)))[each_c bE].
  have := each_c c c_in; rewrite /f; case e: (ends_of _ _ _) => [e'|] //= _.
  have kc : known c by rewrite /has_ends /own_ends e.
  split=> //; rewrite bE; apply/in_map_iff; exists c; split=> //; by rewrite /f /own_ends e.
have nonneg b : List.In b bs -> nonneg_ends R b.
  rewrite bsE => /in_map_iff[[x cs] [<- run]] e; have := each _ run; rewrite {1}/F => /(all_some_map (nothing, (zero, zero)))[each_c ->].
  case/in_map_iff => c [<- c_in]; have [kc _] := cell_entry x cs c run c_in.
  have c_cells : List.In c (cells T) by have [csE _] := proj2 (runs_of_cells ok) _ _ run; move: c_in; rewrite csE => /in_context_in[].
  have [low0 le] := own_ends_ge0 c_cells kc; rewrite /f (known_ends kc) /top_end /bottom_end /=.
  by have [-> ->] := orient (es c); case: (worst) => /=; split=> //; apply: le_trans le.
have [one_ pairs] := greatest_ofP nonneg.
split=> // p comp; have [x [h [l [pE ne some some']]]] := @comparesE R T ok true p comp; rewrite pE /= in some some' *.
have the_cell a : unit_of T true x a <> [::] -> exists c cs, [/\ List.In (x, cs) (runs context (cells T)), List.In c cs, group c = a &
    forall m c', List.In (m, c') (unit_of T true x a) -> c' = c].
  case e: (unit_of T true x a) => [|[m c] rest] // _; have [] := @in_unit R T true x a m c; first by rewrite e; left.
  move=> c_in ca /(_ isT) cx _; have [cs run] := runs_have context c_in; rewrite cx in run; exists c, cs; split=> //.
    by have [-> _] := proj2 (runs_of_cells ok) _ _ run; apply/in_filter_seq; split=> //; apply/Z.eqb_eq.
  move=> m' c'; rewrite -e => there; have [c'_in c'a /(_ isT) c'x _] := in_unit R there.
  by have := cell_of ok c'_in; rewrite c'a c'x -ca -cx (cell_of ok c_in) => -[].
have [c [cs [run c_in ca only]]] := the_cell h some; have [c' [cs' [run' c_in' ca' only']]] := the_cell l some'.
have csE : cs' = cs by have [-> _] := proj2 (runs_of_cells ok) _ _ run; have [-> _] := proj2 (runs_of_cells ok) _ _ run'.
rewrite csE in run' c_in'; have [kc entry] := cell_entry x cs c run c_in; have [kc' entry'] := cell_entry x cs c' run c_in'.
split=> //; first by split=> m d there; [rewrite (only m d there) | rewrite (only' m d there)].
rewrite (mean_in_const (@unit_bundle R T true x h some) (v := end_on R (es c) worst)) => [|m d /only -> //].
rewrite (mean_in_const (@unit_bundle R T true x l some') (v := end_on R (es c') (~~ worst))) => [|m d /only' -> //].
have bin : List.In (odflt [::] (F (x, cs))) bs by rewrite bsE; apply: (in_map (fun xcs => odflt [::] (F xcs))).
have := pairs _ _ _ bin entry entry'; rewrite /top_end /bottom_end /= ca ca' => /(_ ne).
by have [-> _] := orient (es c); have [_ ->] := orient (es c').
Qed.
End Sides.
