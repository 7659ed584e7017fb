(* The program of WorstCase.v is right: what it accepts is true of every utility of the class,
   with values in any ordered field. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.algebra_tactics Require Import ring.
From FairauditKernel Require Import Fractions FractionsSound LinearProgram WorstCase.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Soundness.
Variable R : realFieldType.
Local Notation embed := (@embed R).
Local Notation ratio := (@ratio R).

(* ==== What a class of utilities is (this part has to be read; all that follows it is checked by Coq) ==== *)

(* g(u,x,a), by context, group and decision.  What it is outside the table does not matter. *)
Definition utility : Type := Z -> Z -> Z -> R.

(* sum_k phi_k theta_k *)
Definition linear_in (theta : Z -> R) (phi : list Q) : R := \sum_(t <- numbered 0 phi) ratio t.2 * theta t.1.

(* E(x,a) and the mean of E(.,a) *)
Definition expectation (g : utility) (c : cell) : R :=
  (\sum_(o <- outcomes c) ratio (weight o) * g (context c) (group c) (decision o)) / \sum_(o <- outcomes c) ratio (weight o).

Definition mass_at (T : table) (c : cell) : R :=
  match population T with
  | Counted => \sum_(o <- outcomes c) ratio (weight o)
  | Given => ratio (weight_of_cell c)
  | Alike => 1
  end.

Definition group_mean (T : table) (g : utility) (a : Z) : R :=
  (\sum_(c <- of_that_group T a) mass_at T c * expectation g c) / \sum_(c <- of_that_group T a) mass_at T c.

(* The class, without its floor *)
Record in_class (K : utilities) (T : table) (g : utility) : Prop := InClass {
  in_range : forall x a u, ratio (least K) <= g x a u <= ratio (gamma K);
  is_blind : blind K -> forall x a a' u, g x a u = g x a' u;
  in_order : forall c, In c (cells T) -> forall pair, In pair (order K) ->
    g (context c) (group c) pair.1 <= g (context c) (group c) pair.2;
  is_lipschitz : forall L, lipschitz K = Some L -> forall c d, In c (cells T) -> In d (cells T) ->
    context c = context d -> group c <> group d -> forall u,
    g (context c) (group c) u - g (context d) (group d) u <= ratio L * ratio (distance K (group c) (group d));
  in_rows : forall r, In r (rows K) ->
    \sum_(t <- r.1) ratio (coefficient t) * g (of_context t) (of_group t) (of_decision t) <= ratio r.2;
  in_family : forall F, parameters K = Some F -> exists theta,
    [/\ forall k, ratio (entry zero (lower F) k) <= theta k <= ratio (entry zero (upper F) k),
        forall r, In r (family_rows F) -> linear_in theta r.1 <= ratio r.2
      & forall c, In c (cells T) -> forall o, In o (outcomes c) ->
          g (context c) (group c) (decision o) = linear_in theta (features o)]
}.

(* The floor, where the groups of two cells c and d of a context are compared *)
Definition local_floor (K : utilities) (T : table) (g : utility) (c d : cell) : Prop :=
  forall t, tau K = Some t ->
  if on_pair K then ratio t <= expectation g c /\ ratio t <= expectation g d
  else forall e, In e (cells T) -> context e = context c -> ratio t <= expectation g e.

(* The floor, where the means of two groups are compared *)
Definition global_floor (K : utilities) (T : table) (g : utility) (a b : Z) : Prop :=
  forall t, tau K = Some t ->
  if on_pair K then ratio t <= group_mean T g a /\ ratio t <= group_mean T g b
  else forall e, In e (everywhere T) -> ratio t <= group_mean T g e.

(* ==== Proofs ==== *)

(* ---- Forms ---- *)

Section Forms.
Variable v : var -> R.

Definition form_at (f : form) : R := \sum_(t <- linear f) ratio t.2 * v t.1 + ratio (free f).

Lemma form_fixed q : form_at (fixed q) = ratio q.
Proof. by rewrite /form_at /= big_nil add0r. Qed.

Lemma form_added f h : form_at (added f h) = form_at f + form_at h.
Proof. by rewrite /form_at /= big_cat ratio_plus /= addrACA. Qed.

Lemma form_multiplied q f : form_at (multiplied q f) = ratio q * form_at f.
Proof.
rewrite /form_at /= ratio_times mulrDr mulr_sumr big_map; congr (_ + _).
by apply: eq_bigr => t _; rewrite ratio_times mulrA.
Qed.

Lemma form_difference f h : form_at (difference f h) = form_at f - form_at h.
Proof. by rewrite form_added form_multiplied ratio_minus ratio_one mulN1r. Qed.

Lemma form_sum fs : form_at (sum_of_forms fs) = \sum_(f <- fs) form_at f.
Proof. by elim: fs => [|f fs IH]; rewrite ?big_nil ?form_fixed ?ratio_zero // big_cons -IH form_added. Qed.

Lemma form_in_parameters phi : form_at (in_parameters phi) = linear_in (fun k => v (k, Z0, Z0)) phi.
Proof. by rewrite /form_at /= ratio_zero addr0 big_map. Qed.

(* ---- Integers instead of fractions ---- *)

Lemma overP d q : fits d q -> embed (over d q) = embed d * ratio q.
Proof.
move=> /Z.eqb_eq e; have {2}-> : d = Z.mul (Zpos (Qden q)) (Z.div d (Zpos (Qden q))) by apply: Z_div_exact_2.
by rewrite /over /ratio !embedM; field; apply: embed_neq0.
Qed.

Lemma clearedP f : exact f -> value_at v (cleared f) = embed (denominator f) * form_at f.
Proof.
case/andP => _ /= /andP[fits0 fits1]; rewrite /value_at /sum_at /cleared /= overP // /form_at mulrDr; congr (_ + _).
rewrite big_map mulr_sumr; elim: (linear f) fits1 => [|t ts IH] /=; first by rewrite !big_nil.
by case/andP=> fit fit'; rewrite !big_cons IH // overP // mulrA.
Qed.
End Forms.

(* ---- Lists ---- *)

Lemma in_entry A (default : A) xs n : entry default xs n = default \/ In (entry default xs n) xs.
Proof.
elim: xs n => [|x xs IH] n /=; first by left.
case: ifP => _; first by right; left.
by case: (IH (Z.sub n 1)) => [->|?]; [left | right; right].
Qed.

Lemma in_chosen n ys slacks ms : chosen n ys slacks = Some ms -> forall m, In m ms -> In m.2 slacks.
Proof.
elim: slacks n ys ms => [|s rest IH] n [|[i y] ys] ms //=; try by case=> <-.
case: ifP => _; last by move=> /IH sub m /sub; right.
case e: (chosen _ ys rest) => [ms'|] //= [<-] m /= [<-|]; first by left.
by move/(IH _ _ _ e); right.
Qed.

Lemma in_first_of_contexts cs seen c : In c (first_of_contexts cs seen) -> In c cs.
Proof.
elim: cs seen => //= d cs IH seen; case: ifP => _; first by move/IH; right.
by case=> [->|/IH]; [left | right].
Qed.

(* ---- The linear program of a pair ---- *)

Section Class.
Variables (K : utilities) (T : table).
Hypothesis ok : valid K T.

Lemma unit_gt0 : 0 < embed (unit K) :> R.
Proof. by case/and5P: ok => _ _ _ /(embed_gt0 R). Qed.

Lemma fits_zero d : fits d zero. Proof. by rewrite /fits /= Z.mod_1_r. Qed.

Lemma fits_end q : In q (ends K) -> fits (unit K) q.
Proof. by case/and5P: ok => _ _ _ _ /forallb_forall; apply. Qed.

Lemma fits_box j : fits (unit K) (box_low K j) && fits (unit K) (box_high K j).
Proof.
rewrite /box_low /box_high; case e: (parameters K) => [F|].
  apply/andP; split.
    case: (in_entry zero (lower F) j.1.1) => [->|inF]; first exact: fits_zero.
    by apply: fits_end; rewrite /ends e; apply/in_or_app; left.
  case: (in_entry zero (upper F) j.1.1) => [->|inF]; first exact: fits_zero.
  by apply: fits_end; rewrite /ends e; apply/in_or_app; right.
by rewrite !fits_end // /ends e /=; [right; left | left].
Qed.

Lemma sameP j k : same j k -> j = k.
Proof. by case: j k => [[a b] c] [[d e] f] /andP[/andP[/Z.eqb_eq -> /Z.eqb_eq ->] /Z.eqb_eq ->]. Qed.

Variable v : var -> R.
Hypothesis in_box : forall j, ratio (box_low K j) <= v j <= ratio (box_high K j).

Lemma proved_sound objective ms :
  proved K (unit K) objective ms -> (forall m, In m ms -> 0 <= form_at v m.2) -> form_at v objective <= 0.
Proof.
case/and3P => exact0 /forallb_forall exacts checked rows0.
have := lp_check_sound sameP (v := v) _ checked.
rewrite clearedP // pmulr_rle0; last by case/andP: exact0 => /(embed_gt0 R).
apply=> [j | m].
  have /andP[low high] := fits_box j; rewrite !overP // !ler_pmul2l ?unit_gt0 //; exact: in_box.
case/in_map_iff => [m' [<- m'ms]] /=; rewrite clearedP ?exacts //.
apply: mulr_ge0; last exact: rows0.
by have /andP[/(embed_gt0 R)/ltW] := exacts _ m'ms.
Qed.

(* ---- Every constraint holds on the class ---- *)

Variable g : utility.
Hypothesis g_in : in_class K T g.
Hypothesis v_is_g : forall c, In c (cells T) -> forall o, In o (outcomes c) ->
  form_at v (value K c o) = g (context c) (group c) (decision o).
Hypothesis theta_rows : forall F, parameters K = Some F -> forall r, In r (family_rows F) ->
  linear_in (fun k => v (k, Z0, Z0)) r.1 <= ratio r.2.

Lemma value_forP c u f : In c (cells T) -> value_for K c u = Some f -> form_at v f = g (context c) (group c) u.
Proof.
rewrite /value_for /outcome_for => cT; case e: (List.find _ _) => [o|] //= [<-].
by have [oc /Z.eqb_eq <-] := find_some _ _ e; apply: v_is_g.
Qed.

Lemma vacuous_ge0 : 0 <= form_at v vacuous.
Proof. by rewrite form_fixed ratio_zero. Qed.

Lemma in_concerned x c : In c (concerned T x) -> In c (cells T).
Proof. by case: x => [x|] //= /filter_In[]. Qed.

Lemma in_places x c : In c (places K T x) -> In c (cells T).
Proof. by rewrite /places; case: ifP => _; [move/in_first_of_contexts/in_concerned | move/in_concerned]. Qed.

Lemma order_row_ge0 c pair : In c (cells T) -> In pair (order K) -> 0 <= form_at v (order_row K c pair).
Proof.
move=> cT inK; rewrite /order_row.
case e1: (value_for K c pair.1) => [f|]; last exact: vacuous_ge0.
case e2: (value_for K c pair.2) => [h|]; last exact: vacuous_ge0.
rewrite form_difference (value_forP cT e1) (value_forP cT e2) subr_ge0; exact: (in_order g_in).
Qed.

Lemma lipschitz_rows_ge0 L x f : lipschitz K = Some L -> In f (lipschitz_rows K T L x) -> 0 <= form_at v f.
Proof.
move=> KL /in_flat_map[c [/in_concerned cT]] /in_flat_map[d [/in_concerned dT]].
case: ifP => // /andP[/Z.eqb_eq xx /negP aa] /in_map_iff[o [<- oc]].
case e: (value_for K d (decision o)) => [h|]; last exact: vacuous_ge0.
rewrite form_difference form_added form_fixed ratio_times (value_forP dT e) (v_is_g cT oc) -addrA -opprB subr_ge0.
by apply: (is_lipschitz g_in) => // e'; apply: aa; apply/Z.eqb_eq.
Qed.

Lemma form_of_termP t f :
  form_of_term K T t = Some f -> form_at v f = ratio (coefficient t) * g (of_context t) (of_group t) (of_decision t).
Proof.
rewrite /form_of_term /cell_for; case e: (List.find _ _) => [c|] //.
have [cT /andP[/Z.eqb_eq <- same_group]] := find_some _ _ e.
case e': (value_for K c _) => [h|] //= [<-]; rewrite form_multiplied (value_forP cT e'); congr (_ * _).
by case/orP: same_group => [b | /Z.eqb_eq -> //]; apply: (is_blind g_in).
Qed.

Lemma further_row_ge0 r : In r (rows K) -> 0 <= form_at v (further_row K T r).
Proof.
move=> rK; rewrite /further_row; case e: (form_of_terms K T r.1) => [f|]; last exact: vacuous_ge0.
rewrite form_difference form_fixed subr_ge0; apply: le_trans (in_rows g_in rK).
suff -> : form_at v f = \sum_(t <- r.1) ratio (coefficient t) * g (of_context t) (of_group t) (of_decision t) by [].
elim: (r.1) f e => [|t ts IH] f /=; first by case=> <-; rewrite big_nil form_fixed ratio_zero.
case e1: (form_of_term K T t) => [f1|] //; case e2: (form_of_terms K T ts) => [f2|] // [<-].
by rewrite big_cons form_added (form_of_termP e1) (IH _ e2).
Qed.

Lemma constraints_ge0 x f : In f (constraints K T x) -> 0 <= form_at v f.
Proof.
rewrite /constraints => inC; case: (in_app_or _ _ _ inC) => {inC} [|inC].
  by case/in_flat_map => c [/in_places cT] /in_map_iff[pair [<- inK]]; apply: order_row_ge0.
case: (in_app_or _ _ _ inC) => {inC} [|inC].
  by case e: (lipschitz K) => [L|] //; apply: lipschitz_rows_ge0.
case: (in_app_or _ _ _ inC) => {inC} [/in_map_iff[r [<- rK]]|]; first exact: further_row_ge0.
case e: (parameters K) => [F|] // inC; case: (in_app_or _ _ _ inC) => {inC}.
  case/in_flat_map => c [/in_places cT] /in_flat_map[o [oc]] /=.
  have /andP[low high] := in_range g_in (context c) (group c) (decision o).
  by case=> [<-|[<-|//]]; rewrite form_difference form_fixed (v_is_g cT oc) subr_ge0.
by case/in_map_iff => r [<- rF]; rewrite form_difference form_fixed form_in_parameters subr_ge0; apply: theta_rows rF.
Qed.

(* ---- Expectations ---- *)

Lemma weight_ge0 c o : In c (cells T) -> In o (outcomes c) -> 0 <= ratio (weight o).
Proof.
case/and5P: ok => /forallb_forall cells_ok _ _ _ _ /cells_ok /and3P[/forallb_forall weights _ _] /weights; exact: ratio_ge0.
Qed.

Lemma weight_sum_gt0 c : In c (cells T) -> positive_fraction (weight_sum c).
Proof. by case/and5P: ok => /forallb_forall cells_ok _ _ _ _ /cells_ok /and3P[]. Qed.

Lemma ratio_weight_sum c : ratio (weight_sum c) = \sum_(o <- outcomes c) ratio (weight o).
Proof. by rewrite ratio_total big_map. Qed.

Lemma sum_of_weights_gt0 c : In c (cells T) -> 0 < \sum_(o <- outcomes c) ratio (weight o).
Proof. by move/weight_sum_gt0/(ratio_gt0 R); rewrite ratio_weight_sum. Qed.

Lemma expectation_formP c : In c (cells T) -> form_at v (expectation_form K c) = expectation g c.
Proof.
move=> cT; rewrite form_multiplied ratio_inverse ?weight_sum_gt0 // ratio_weight_sum mulrC /expectation; congr (_ / _).
rewrite form_sum big_map; apply: eq_sum_in => o oc; by rewrite form_multiplied v_is_g.
Qed.

Lemma expectation_between c : In c (cells T) -> ratio (least K) <= expectation g c <= ratio (gamma K).
Proof.
move=> cT; apply: mean_between => [o|o _|]; [exact: weight_ge0 | exact: (in_range g_in) | exact: sum_of_weights_gt0].
Qed.

Lemma ratio_mass c : ratio (mass T c) = mass_at T c.
Proof. by rewrite /mass /mass_at; case: (population T); rewrite ?ratio_weight_sum ?ratio_one. Qed.

Lemma mass_ge0 c : In c (cells T) -> 0 <= mass_at T c.
Proof.
move=> cT; rewrite /mass_at; case: (population T); [exact/ltW/sum_of_weights_gt0 | | exact: ler01].
by case/and5P: ok => /forallb_forall cells_ok _ _ _ _; have /and3P[_ _ /(ratio_ge0 R)] := cells_ok _ cT.
Qed.

Lemma ratio_mass_of_group a : ratio (mass_of_group T a) = \sum_(c <- of_that_group T a) mass_at T c.
Proof. by rewrite ratio_total big_map; apply: eq_bigr => c _; apply: ratio_mass. Qed.

Lemma of_that_groupP a c : In c (of_that_group T a) -> In c (cells T).
Proof. by case/filter_In. Qed.

Lemma mean_formP a : populated T a -> form_at v (mean_form K T a) = group_mean T g a.
Proof.
move=> pop; rewrite form_multiplied ratio_inverse // ratio_mass_of_group mulrC /group_mean; congr (_ / _).
rewrite form_sum big_map; apply: eq_sum_in => c /of_that_groupP cT.
by rewrite form_multiplied ratio_mass expectation_formP.
Qed.

Lemma mean_between_ends a : populated T a -> ratio (least K) <= group_mean T g a <= ratio (gamma K).
Proof.
move=> pop; apply: mean_between => [c /of_that_groupP|c /of_that_groupP|]; [exact: mass_ge0 | exact: expectation_between |].
by rewrite -ratio_mass_of_group; apply: ratio_gt0.
Qed.

Lemma expectation_of_law c : In c (cells T) ->
  expectation g c = \sum_(t <- law c) ratio t.2 * g (context c) (group c) t.1.
Proof.
move=> cT; rewrite /law big_map /expectation mulrC mulr_sumr; apply: eq_bigr => o _ /=.
by rewrite ratio_times ratio_inverse ?weight_sum_gt0 // ratio_weight_sum mulrA.
Qed.

Lemma alike_expectations c d : blind K -> In c (cells T) -> In d (cells T) -> context c = context d -> same_law (law c) (law d) ->
  expectation g c = expectation g d.
Proof.
move=> b cT dT xx; rewrite !expectation_of_law // xx.
elim: (law c) (law d) => [|[u p] ps IH] [|[w q] qs] //; first by rewrite !big_nil.
case/andP=> /Z.eqb_eq -> /andP[/(equalP R) pq /IH e].
by rewrite !big_cons /= pq e (is_blind g_in b _ (group c) (group d)).
Qed.

(* ---- Pairs ---- *)

Lemma in_pairs gs h l : In h gs -> In l gs -> h.1 <> l.1 -> In (h, l) (pairs gs).
Proof.
move=> hgs lgs differ; apply/in_flat_map; exists h; split=> //; apply/in_flat_map; exists l; split=> //.
by case: (Z.eqb_spec h.1 l.1) => //= _; left.
Qed.

Lemma greatest_floorP x :
  ratio (least K) <= x -> (forall t, tau K = Some t -> ratio t <= x) -> ratio (greatest_floor K) <= x.
Proof. by rewrite /greatest_floor; case: (tau K) => [t|] low floor //; case: ifP => _ //; apply: floor. Qed.

Lemma setting_sound value es s h l :
  setting_proved K (unit K) value es s -> at_most one value ->
  (forall f, In f (of_setting s) -> 0 <= form_at v f) ->
  In h (compared s) -> In l (compared s) -> h.1 <> l.1 ->
  (forall f, In f (floors K s h l) -> 0 <= form_at v f) ->
  form_at v h.2 <= ratio (gamma K) -> ratio (least K) <= form_at v l.2 ->
  (alike s -> form_at v h.2 = form_at v l.2) ->
  form_at v h.2 <= ratio value * form_at v l.2.
Proof.
move=> /forallb_forall proofs value1 rows0 hs ls differ floors0 high low same_expectation.
have l0 : 0 <= form_at v l.2 by apply: le_trans low; case/and5P: ok => _ /(ratio_ge0 R).
have v1 : 1 <= ratio value by rewrite -ratio_one; apply: at_mostP.
have := proofs _ (in_pairs hs ls differ); rewrite /pair_proved; case: (List.find _ _) => [e|].
  case ms: (chosen _ _ _) => [ms'|] // checked; rewrite -subr_le0 -form_multiplied -form_difference.
  apply: proved_sound checked _ => m /(in_chosen ms) inF.
  by case: (in_app_or _ _ _ inF); [exact: floors0 | exact: rows0].
case/orP => [/same_expectation -> | /andP[/(ratio_gt0 R) floor0 /(at_mostP R)]]; first exact: ler_pemull.
rewrite ratio_times => bound; apply: le_trans high (le_trans bound _).
rewrite ler_pmul2l; last exact: lt_le_trans v1.
apply: greatest_floorP => // t Kt; rewrite -subr_ge0 -(form_fixed v t) -form_difference.
apply: floors0; rewrite /floors Kt; apply: in_map; case: (on_pair K) => //=; by right; left.
Qed.
End Class.

(* A point of the variables for every utility of the class *)
Lemma point_of_class K T g : in_class K T g -> exists v : var -> R,
  [/\ forall j, ratio (box_low K j) <= v j <= ratio (box_high K j),
      forall c, In c (cells T) -> forall o, In o (outcomes c) -> form_at v (value K c o) = g (context c) (group c) (decision o)
    & forall F, parameters K = Some F -> forall r, In r (family_rows F) -> linear_in (fun k => v (k, Z0, Z0)) r.1 <= ratio r.2].
Proof.
move=> g_in; case e: (parameters K) => [F|].
  have [theta [box family_rows_hold makes]] := in_family g_in e; exists (fun j => theta j.1.1); split.
  - by move=> j; rewrite /box_low /box_high e; apply: box.
  - by move=> c cT o oc; rewrite /value e form_in_parameters (makes c cT o oc).
  - by move=> F' [<-].
exists (fun j => g j.1.1 j.1.2 j.2); split=> //.
- by move=> j; rewrite /box_low /box_high e; apply: (in_range g_in).
- move=> c cT o oc; rewrite /value e /form_at /= big_seq1 /= ratio_zero ratio_one addr0 mul1r.
  by case: ifP => // b; apply: (is_blind g_in b).
Qed.

(* ==== What is proved ==== *)

(* Where the check accepts a value, no utility of the class gives a greater ratio in any context: E(x,a) <= value * E(x,a'). *)
Theorem worst_case_local (K : utilities) (T : table) value es :
  bound_proved K T value es -> local K ->
  forall g, in_class K T g ->
  forall c d, In c (cells T) -> In d (cells T) -> In (context c) (contexts T) -> context c = context d -> group c <> group d ->
  local_floor K T g c d ->
  expectation g c <= ratio value * expectation g d.
Proof.
case/and4P => ok value1 /forallb_forall settings_ok _ is_local g g_in c d cT dT xT xx aa floor.
have [v [box v_is_g theta_rows]] := point_of_class g_in.
move: settings_ok; rewrite /settings is_local => settings_ok.
have := settings_ok _ (in_map _ _ _ xT); set s := Setting _ _ _ _ => checked.
have mem e : In e (cells T) -> context e = context c -> In (group e, expectation_form K e) (compared s).
  move=> eT ex; apply: (in_map (fun c => (group c, expectation_form K c))); apply/filter_In; split=> //; exact/Z.eqb_eq.
have E e : In e (cells T) -> form_at v (expectation_form K e) = expectation g e by move=> eT; exact: (expectation_formP ok v_is_g eT).
have := setting_sound (h := (group c, expectation_form K c)) (l := (group d, expectation_form K d)) ok box checked value1.
rewrite !E //; apply=> //; try exact: mem.
- rewrite /s /=; case: ifP => _ f; first by case: ifP => // _; exact: (constraints_ge0 g_in v_is_g theta_rows).
  exact: (constraints_ge0 g_in v_is_g theta_rows).
- rewrite /floors; move: floor; rewrite /local_floor; case: (tau K) => [t|] // /(_ t erefl) floor f /in_map_iff[[a h] [<-]].
  rewrite form_difference form_fixed subr_ge0; move: floor; case: ifP => _ floor /=.
    by case: floor => fc fd [[_ <-]|[[_ <-]|//]]; rewrite E.
  case/in_map_iff => e [[_ <-] /filter_In[eT /Z.eqb_eq ex]]; rewrite E //; exact: floor.
- by have /andP[] := expectation_between ok g_in cT.
- by have /andP[] := expectation_between ok g_in dT.
- move=> /= /andP[b /forallb_forall laws]; apply: (alike_expectations ok g_in b) => //.
  have inlaws e : In e (cells T) -> context e = context c -> In (law e) (List.map law (List.filter (fun e => Z.eqb (context e) (context c)) (cells T))).
    by move=> eT ex; apply: in_map; apply/filter_In; split=> //; exact/Z.eqb_eq.
  by have /forallb_forall := laws _ (inlaws c cT erefl); apply; apply: inlaws.
Qed.

(* The same for the means of groups. *)
Theorem worst_case_global (K : utilities) (T : table) value es :
  bound_proved K T value es -> ~~ local K ->
  forall g, in_class K T g ->
  forall a b, In a (everywhere T) -> In b (everywhere T) -> a <> b ->
  global_floor K T g a b ->
  group_mean T g a <= ratio value * group_mean T g b.
Proof.
case/and4P => ok value1 /forallb_forall settings_ok _ /negbTE is_global g g_in a b aT bT ab floor.
have [v [box v_is_g theta_rows]] := point_of_class g_in.
move: settings_ok; rewrite /settings is_global => settings_ok.
have := settings_ok _ (or_introl erefl); set s := Setting _ _ _ _ => checked.
have pop e : In e (everywhere T) -> populated T e.
  by rewrite /everywhere; case: (population T); case: (complete T) => // /filter_In[].
have E e : In e (everywhere T) -> form_at v (mean_form K T e) = group_mean T g e by move/pop=> pope; exact: (mean_formP ok v_is_g pope).
have mem e : In e (everywhere T) -> In (e, mean_form K T e) (compared s).
  exact: (in_map (fun a => (a, mean_form K T a))).
have := setting_sound (h := (a, mean_form K T a)) (l := (b, mean_form K T b)) ok box checked value1.
rewrite !E //; apply=> //; try exact: mem.
- by rewrite /s /= orbT => f; exact: (constraints_ge0 g_in v_is_g theta_rows).
- rewrite /floors; move: floor; rewrite /global_floor; case: (tau K) => [t|] // /(_ t erefl) floor f /in_map_iff[[e h] [<-]].
  rewrite form_difference form_fixed subr_ge0; move: floor; case: ifP => _ floor /=.
    by case: floor => fa fb [[_ <-]|[[_ <-]|//]]; rewrite E.
  by case/in_map_iff => e' [[_ <-] e'T]; rewrite E //; apply: floor.
- by have /andP[] := mean_between_ends ok g_in (pop _ aT).
- by have /andP[] := mean_between_ends ok g_in (pop _ bT).
Qed.
End Soundness.
