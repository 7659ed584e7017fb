(* What is accepted of cells that move holds of the table, by T16: how far a verdict stands, and the ratios within a drift. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Checker Drift ListsSound TableSound BlocksSound FiguresSound.
From FairauditChecker Require Import MovedLaws MovedCells DriftCells DriftUnits DriftPairs DriftEnds DriftSides.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Sound.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).
Local Notation movers := (movers_of T (rows_of T)).
Local Notation A := (group_rows T (rows_of T)).

Lemma mem_In (a : Z) (s : list Z) : (a \in s) <-> List.In a s.
Proof.
elim: s => //= b s IH; rewrite in_cons; split=> [/orP[/eqP->|/IH]|[->|/IH ->]]; [by left | by right | by rewrite eqxx | by rewrite orbT].
Qed.

Lemma convex_between (t a b : R) : 0 <= t -> t <= 1 -> a <= b -> a <= (1 - t) * a + t * b <= b.
Proof.
move=> t0 t1 ab; have -> : (1 - t) * a + t * b = a + t * (b - a) by ring.
have d0 : 0 <= b - a by rewrite subr_ge0.
by rewrite ler_addl mulr_ge0 //= -ler_subr_addl ler_pimull.
Qed.

(* ---- Amounts are not below 0 ---- *)

Lemma amount_in_ge0 k v (D : Z -> Z -> Z -> R) local p : signed T = false -> drifted T k v D -> compares R T (ratio_of_all local) p ->
  0 <= amount_in T D local (at_context p) (higher p) /\ 0 <= amount_in T D local (at_context p) (lower p).
Proof.
move=> unsigned dr comp; have E0 x a : has_cell T x a -> 0 <= expectation_in T D x a.
  move=> there; have [[D0 _] _] := dr x a there; rewrite /expectation_in big_seq; apply: sumr_ge0 => u u_in.
  by rewrite mulr_ge0 ?D0 ?gain_ge0.
have M0 a : 0 <= group_mean_in T D a.
  rewrite /group_mean_in divr_ge0 ?group_mass_ge0 //; apply: sum_ge0_in => x _; case there: (has_cell T x a).
    by rewrite mulr_ge0 ?cell_mass_ge0 ?E0.
  by move: there; rewrite /cell_mass /has_cell; case: (cell_at T x a) => // _; rewrite mul0r.
have [x [h [l [pE _ _ _]]]] := comparesE ok comp; rewrite pE; move: comp; rewrite pE /amount_in /compares /=.
by case: local {pE} => //= /and5P[_ _ ph pl _]; rewrite !E0.
Qed.

Lemma unsigned_of local p : compares R T (ratio_of_all local) p -> signed T = false.
Proof. by case: local => /and5P[]; rewrite /= => /negbTE. Qed.

Lemma law_amounts local p : amount_in T (law R T) local (at_context p) (higher p) = amount R T (ratio_of_all local) (setting_of p) (higher p) /\
  amount_in T (law R T) local (at_context p) (lower p) = amount R T (ratio_of_all local) (setting_of p) (lower p).
Proof. by case: local; split. Qed.

Section Claim.
Variables (k : move) (amount : option Q) (local : bool).
Hypotheses (unsigned : signed T = false) (amount_ok : an_amount k amount).
Local Notation es := (own_ends T k amount).
Local Notation known := (has_ends T k amount).
Local Notation unit_ := (unit_of T local).
Local Notation q := (ratio_of_all local).

Lemma unit_between x a v (D : Z -> Z -> Z -> R) (up : bool) : unit_ x a <> [::] -> (forall m c, List.In (m, c) (unit_ x a) -> known c) -> meant amount v ->
  drifted T k v D ->
  if up then amount_in T D local x a <= mean_in (unit_ x a) (fun c => end_on R (es c) true)
  else mean_in (unit_ x a) (fun c => end_on R (es c) false) <= amount_in T D local x a.
Proof.
move=> some each mv dr; rewrite (unit_amount ok D some); have bundled := unit_bundle R some.
have bounds m c : List.In (m, c) (unit_ x a) -> ratio (es c).1 <= expectation_in T D (context c) (group c) <= ratio (es c).2.
  by move=> there; have [c_in _ _ _] := in_unit R there; apply: (cell_bounds ok c_in amount_ok (each m c there) mv dr).
by case: up; apply: (mean_in_le bundled) => m c there; have /andP[] := bounds m c there.
Qed.

Lemma unit_ge0 x a up : unit_ x a <> [::] -> (forall m c, List.In (m, c) (unit_ x a) -> known c) ->
  0 <= mean_in (unit_ x a) (fun c => end_on R (es c) up).
Proof.
move=> some each; have bundled := unit_bundle R some; rewrite -(@mean_in_const _ _ _ bundled (fun=> 0) 0) //; apply: (mean_in_le bundled) => m c there.
have [c_in _ _ _] := in_unit R there; have [low0 le] := own_ends_ge0 R ok unsigned amount_ok c_in (each _ _ there).
by rewrite /end_on; case: up => //; apply: le_trans le.
Qed.

(* No drift brings a ratio above the greatest quotient of an upper end and a lower one. *)
Lemma worst_bounds g v (D : Z -> Z -> Z -> R) p : ends_everywhere T A k amount true local movers = Some g -> meant amount v -> drifted T k v D ->
  compares R T q p -> no_more (ratio_in T D local p) (extended R g).
Proof.
move=> every mv dr comp; have [_ pairs] := everywhereP R ok unsigned amount_ok every.
have [_ [some some'] [each each'] le] := pairs p comp; apply: no_more_through le; have [h0 l0] := amount_in_ge0 unsigned dr comp.
apply: quotient_mono => //; first exact: (unit_between true some each mv dr).
  exact: unit_ge0.
exact: (unit_between false some' each' mv dr).
Qed.

(* All cells can be moved so that no ratio is above the greatest quotient of a lower end and an upper one. *)
Lemma best_attained w g : amount = Some w -> ends_everywhere T A k amount false local movers = Some g ->
  exists2 D, drifted T k (ratio w) D & forall p, compares R T q p -> no_more (ratio_in T D local p) (extended R g).
Proof.
move=> is_w every; have [one_ pairs] := everywhereP R ok unsigned amount_ok every.
have st : starts k (ratio w : R) by move: amount_ok; rewrite is_w; apply: amount_starts.
pose lo x a := mean_in (unit_ x a) (fun c => end_on R (es c) false).
pose hi x a := mean_in (unit_ x a) (fun c => end_on R (es c) true).
pose found c := if ends_of k amount (its T c) is Some _ then true else false.
have foundE c : found c -> known c by rewrite /found /has_ends /own_ends; case: (ends_of _ _ _).
pose at_ x : setting := (nothing, if local then x else nothing, nothing).
pose member x a := takes_part R T q (at_ x) a && all (fun mc => found mc.2) (unit_ x a).
pose s x := [seq a <- range (groups T) | member x a].
have takes_some x a : takes_part R T q (at_ x) a -> (local = false -> x = nothing) -> unit_ x a <> [::].
  rewrite /at_; case: (local) => /= part at_x; last exact: (unit_of_mean ok part).
  case/(has_cellP ok): part => c c_in [cx ca]; have /(is_inP (T := T) true x a c_in) [m mc] : is_in T true x a c by rewrite /is_in cx ca !Z.eqb_refl.
  by move=> e; move: mc; rewrite /unit_of e.
have member_known x a m c : member x a -> List.In (m, c) (unit_ x a) -> known c.
  by case/andP=> _ all_ there; apply: foundE; elim: (unit_ x a) all_ there => //= mc B IH /andP[one rest] [e|/(IH rest) //]; rewrite e in one.
have in_s x a : List.In a (s x) -> member x a by case/in_filter_seq.
have ends x a : (local = false -> x = nothing) -> List.In a (s x) -> 0 <= lo x a /\ lo x a <= hi x a.
  move=> at_x /in_s mem; have [part _] := andP mem; have some := takes_some x a part at_x; have each m c := @member_known x a m c mem.
  split; first exact: unit_ge0.
  apply: (mean_in_le (unit_bundle R some)) => m c there; have [c_in _ _ _] := in_unit R there.
  by have [] := own_ends_ge0 R ok unsigned amount_ok c_in (each _ _ there).
pose goal_ x a := together (s x) (lo x) (hi x) a.
pose theta x a := if lo x a == hi x a then 0 else (goal_ x a - lo x a) / (hi x a - lo x a).
have between x a : (local = false -> x = nothing) -> List.In a (s x) ->
    0 <= theta x a <= 1 /\ (1 - theta x a) * lo x a + theta x a * hi x a = goal_ x a.
  move=> at_x ain; have /andP[low high] := together_between (ends x ^~ at_x) ain; rewrite -/(goal_ x a) in low high.
  rewrite /theta; case: eqVneq => [e|ne].
    by rewrite lexx ler01 subr0 mul1r mul0r addr0; split=> //; apply: le_anti; rewrite low {1}e high.
  have pos : 0 < hi x a - lo x a by rewrite subr_gt0 lt_def eq_sym ne (le_trans low).
  split; first by rewrite divr_ge0 ?subr_ge0 ?(le_trans low) //= ler_pdivr_mulr // mul1r ler_add2r.
  have -> : (1 - (goal_ x a - lo x a) / (hi x a - lo x a)) * lo x a + (goal_ x a - lo x a) / (hi x a - lo x a) * hi x a
    = lo x a + (goal_ x a - lo x a) / (hi x a - lo x a) * (hi x a - lo x a) by ring.
  by rewrite divfK ?gt_eqF // addrC subrK.
pose X c := if local then context c else nothing.
have X_ok c : local = false -> X c = nothing by rewrite /X => ->.
have [|D chosen] := @choose R T ok (fun c D => moved T k (ratio w) (law R T (context c) (group c)) D
   /\ (List.In (group c) (s (X c)) -> known c -> \sum_(u <- range (decisions T)) D u * gain R T (context c) (group c) u =
       (1 - theta (X c) (group c)) * end_on R (es c) false + theta (X c) (group c) * end_on R (es c) true)).
  move=> c c_in; case fc: (found c); last by exists (law R T (context c) (group c)); split; [exact: law_itself | rewrite /found in fc; rewrite /has_ends => _; case: (ends_of _ _ _) fc].
  have kc := foundE c fc; have [low0 le] := own_ends_ge0 R ok unsigned amount_ok c_in kc.
  case mem: ((group c) \in s (X c)); last first.
    exists (law R T (context c) (group c)); split; first exact: law_itself.
    by move=> /mem_In; rewrite mem.
  have [/andP[t0 t1] _] := between (X c) (group c) (X_ok c) (proj1 (mem_In _ _) mem).
  have [D mD vD] := cell_attains ok c_in amount_ok kc is_w
    (v := (1 - theta (X c) (group c)) * end_on R (es c) false + theta (X c) (group c) * end_on R (es c) true) (convex_between t0 t1 le).
  by exists D.
exists D; first by apply: (all_moved ok) => c /chosen[].
move=> p comp; have [ne [some some'] [each each'] _] := pairs p comp.
have [x0 [h [l [pE _ _ _]]]] := comparesE ok comp; set x := at_context p in some some' each each'.
have at_x : local = false -> x = nothing by rewrite /x pE /= => ->.
have settingE : setting_of p = at_ x by rewrite /x pE /at_ /setting_of /=; case: (local).
have parts : takes_part R T q (at_ x) (higher p) /\ takes_part R T q (at_ x) (lower p) by rewrite -settingE; case/and5P: comp.
have known_all a : (forall m c, List.In (m, c) (unit_ x a) -> known c) -> all (fun mc => found mc.2) (unit_ x a).
  move=> all_; apply: in_all => -[m c] there; rewrite /found; by rewrite (all_ m c there).
have inside_ a : unit_ x a <> [::] -> a \in range (groups T).
  case e: (unit_ x a) => [|[m c] B] // _; have [] := @in_unit R T local x a m c; first by rewrite e; left.
  by move=> c_in <- _ _; apply: group_inside.
have mem a : takes_part R T q (at_ x) a -> unit_ x a <> [::] -> (forall m c, List.In (m, c) (unit_ x a) -> known c) -> List.In a (s x).
  by move=> part sm ea; apply/in_filter_seq; split; [apply/mem_In/inside_ | rewrite /member part known_all].
have amountE a : List.In a (s x) -> unit_ x a <> [::] -> amount_in T D local x a = goal_ x a.
  move=> ain sm; have [_ <-] := between x a at_x ain; rewrite (unit_amount ok D sm) /lo /hi -mean_in_mix; apply: mean_in_eq => m c there.
  have [c_in ca cx _] := in_unit R there; have [_ chosen_] := chosen c c_in.
  have Xx : X c = x.
    have [locally|locally] : local = true \/ local = false by case: (local); [left | right].
      by rewrite /X locally; apply: cx; rewrite locally.
    by rewrite /X locally at_x.
  rewrite Xx ca in chosen_; rewrite /expectation_in ca; apply: chosen_ => //; exact: (member_known x a m c (in_s x a ain) there).
have [mem_h mem_l] := (mem _ (proj1 parts) some each, mem _ (proj2 parts) some' each').
rewrite /ratio_in -/x !amountE //; have [->|[i [j [iin jin lt le]]]] := together_ratio (ends x ^~ at_x) mem_h mem_l; first exact: one_.
apply: (no_more_through le); have [/andP[part_i _] /andP[part_j _]] := (in_s x i iin, in_s x j jin).
have ij : i <> j by move=> e; move: lt; rewrite -e => lt; have [_] := ends x i at_x iin; rewrite leNgt lt.
have comp' : compares R T q (Place (at_rate p) x (at_decision p) i j).
  rewrite -settingE in part_i part_j; have /and5P[sign_ set_ _ _ _] := comp.
  by apply/and5P; split=> //; move/eqP: ij; case: (local).
by have [_ _ _] := pairs _ comp'.
Qed.
End Claim.
End Sound.
