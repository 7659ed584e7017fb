(* What a table means, and when a statement about it holds: this file has to be read.

   It has no proofs.  R is any ordered field: the rationals, the reals.  Contexts x, groups
   a, b and decisions u are numbers, counted from 0 in the order of the header.  The table
   is the one of a certificate, or that of the law which a policy and its filters induce. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Meaning.
Variables (R : realFieldType) (T : table).
Local Notation ratio := (@ratio R).

(* ---- The laws, masses and expectations of a table ---- *)

Definition cell_at (x a : Z) : option cell := List.find (fun c => Z.eqb (context c) x && Z.eqb (group c) a) (cells T).
Definition has_cell (x a : Z) : bool := if cell_at x a is Some _ then true else false.

(* the u-th of a list *)
Definition number (u : Z) (qs : list Q) : R := ratio (List.nth (Z.to_nat u) qs zero).

(* A cell that is not there has weights 0, and no mass. *)
Definition weight (x a u : Z) : R := if cell_at x a is Some c then number u (weights c) else 0.
Definition row_total (x a : Z) : R := \sum_(u <- range (decisions T)) weight x a u.

(* P(u|x,a) *)
Definition law (x a u : Z) : R := weight x a u / row_total x a.

(* g(u,x,a); 0 where it was not given, as it may be for decisions that were never made *)
Definition gain (x a u : Z) : R :=
  match utility T, cell_at x a with
  | Some gs, _ => number u gs
  | None, Some c => if List.nth (Z.to_nat u) (gains c) None is Some g then ratio g else 0
  | None, None => 0
  end.

(* E(x,a) *)
Definition expectation (x a : Z) : R := \sum_(u <- range (decisions T)) law x a u * gain x a u.

(* M(x,a), and M(.,a) *)
Definition cell_mass (x a : Z) : R :=
  if cell_at x a is Some c then
    match population T with Counted => row_total x a | Given => ratio (mass c) | Alike => 1 end
  else 0.
Definition group_mass (a : Z) : R := \sum_(x <- range (contexts T)) cell_mass x a.

(* P(u|a), and the mean of E(.,a) *)
Definition group_law (a u : Z) : R := (\sum_(x <- range (contexts T)) cell_mass x a * law x a u) / group_mass a.
Definition group_mean (a : Z) : R := (\sum_(x <- range (contexts T)) cell_mass x a * expectation x a) / group_mass a.

(* ---- Which groups are compared ---- *)

Definition complete : bool := all (fun x => all (has_cell x) (range (groups T))) (range (contexts T)).

(* By their means: those of positive mass; none if no population was given and some cell is missing. *)
Definition means_exist : bool := if population T is Alike then complete else true.
Definition has_mean (a : Z) : bool := [&& means_exist, a \in range (groups T) & 0 < group_mass a].

(* ---- Given the true label ---- *)

(* the counts of a cell whose true label is the positive one (rate 0), or another one (rate 1); and those among them whose decision is positive *)
Definition wanted (K : truth) (r : Z) : list Z := [seq t <- range (labels K) | (t == positive_label K) == (r == true_positives)].
Definition labelled (r x a : Z) (us : truth -> list Z) : R :=
  match known T, cell_at x a with
  | Some K, Some c => \sum_(t <- wanted K r) \sum_(u <- us K) number u (List.nth (Z.to_nat t) (by_truth c) nil)
  | _, _ => 0
  end.
Definition draws (r x a : Z) : R := labelled r x a (fun=> range (decisions T)).
Definition positives (r x a : Z) : R := labelled r x a positive_decisions.

(* over all contexts, where the context is nothing *)
Definition over_contexts (f : Z -> R) (x : Z) : R := if x == nothing then \sum_(y <- range (contexts T)) f y else f x.
Definition all_draws (r x a : Z) : R := over_contexts (fun y => draws r y a) x.
Definition rate (r x a : Z) : R := over_contexts (fun y => positives r y a) x / all_draws r x a.

(* ---- The quantities ---- *)

(* 0/0 = 1, and c/0 is infinite *)
Definition quotient (p q : R) : option R := if q == 0 then if p == 0 then Some 1 else None else Some (p / q).

Definition no_more (v w : option R) : bool :=
  match v, w with
  | _, None => true
  | None, Some _ => false
  | Some v, Some w => v <= w
  end.

Definition is_ratio (q : quantity) : bool :=
  match q with Local | Global | Local_supremum | Global_supremum => true | _ => false end.
Definition is_distance (q : quantity) : bool := match q with Equalized_odds | Demographic_parity => true | _ => false end.

(* Where groups are compared: the rate, the context and the decision that it is about, in this order of importance. *)
Definition setting : Type := (Z * Z * Z)%type.
Definition setting_of (p : place) : setting := (at_rate p, at_context p, at_decision p).

Definition contexts_or_none (overall : bool) : list Z := if overall then [:: nothing] else range (contexts T).

Definition settings (q : quantity) : list setting :=
  match q with
  | Local | Equalized_odds | Local_difference => [seq (nothing, x, nothing) | x <- range (contexts T)]
  | Global | Demographic_parity | Global_difference => [:: (nothing, nothing, nothing)]
  | Local_supremum => [seq (nothing, x, u) | x <- range (contexts T), u <- range (decisions T)]
  | Global_supremum => [seq (nothing, nothing, u) | u <- range (decisions T)]
  | Equal_opportunity o => [seq (true_positives, x, nothing) | x <- contexts_or_none o]
  | Odds_given_truth o => [seq (r, x, nothing) | r <- [:: true_positives; false_positives], x <- contexts_or_none o]
  end.

(* Whether a group is compared there, and by which number. *)
Definition takes_part (q : quantity) (s : setting) (a : Z) : bool :=
  let '(r, x, u) := s in
  match q with
  | Local | Equalized_odds | Local_supremum | Local_difference => has_cell x a
  | Global | Demographic_parity | Global_supremum | Global_difference => has_mean a
  | Equal_opportunity _ | Odds_given_truth _ => (a \in range (groups T)) && (0 < all_draws r x a)
  end.

Definition amount (q : quantity) (s : setting) (a : Z) : R :=
  let '(r, x, u) := s in
  match q with
  | Local | Local_difference => expectation x a
  | Global | Global_difference => group_mean a
  | Equalized_odds | Local_supremum => law x a u
  | Demographic_parity | Global_supremum => group_law a u
  | Equal_opportunity _ | Odds_given_truth _ => rate r x a
  end.

(* Of utilities below 0 there are no ratios.  A distance is the same both ways: the first of the two groups is called the higher one. *)
Definition compares (q : quantity) (p : place) : bool :=
  [&& ~~ (is_ratio q && signed T), setting_of p \in settings q, takes_part q (setting_of p) (higher p), takes_part q (setting_of p) (lower p)
    & if is_distance q then Z.ltb (higher p) (lower p) else higher p != lower p].

(* How much more likely a decision is for the higher one *)
Definition surplus (q : quantity) (p : place) (u : Z) : R :=
  let s := (at_rate p, at_context p, u) in amount q s (higher p) - amount q s (lower p).

(* the total variation distance *)
Definition distance (q : quantity) (p : place) : R := \sum_(u <- range (decisions T)) Num.max 0 (surplus q p u).

Definition quantity_at (q : quantity) (p : place) : option R :=
  let high := amount q (setting_of p) (higher p) in
  let low := amount q (setting_of p) (lower p) in
  if is_ratio q then quotient high low else if is_distance q then Some (distance q p) else Some (high - low).

(* ---- Figures: the greatest value, and the first place that has it ---- *)

Definition order_of (p : place) : list Z := [:: at_rate p; at_context p; at_decision p; higher p; lower p].

Fixpoint lexicographic (xs ys : list Z) : bool :=
  match xs, ys with
  | x :: xs, y :: ys => Z.ltb x y || (Z.eqb x y && lexicographic xs ys)
  | _, _ => false
  end.
Definition before (p q : place) : bool := lexicographic (order_of p) (order_of q).

Definition greatest (q : quantity) (v : option R) : Prop :=
  (exists2 p, compares q p & quantity_at q p = v) /\ forall p, compares q p -> no_more (quantity_at q p) v.

Definition first_greatest (q : quantity) (p : place) : Prop :=
  compares q p /\ forall p', compares q p' ->
    no_more (quantity_at q p') (quantity_at q p) /\ (before p' p -> quantity_at q p' <> quantity_at q p).

Definition extended (v : option Q) : option R := omap ratio v.

(* Rates of both kinds are compared where each is compared somewhere. *)
Definition exists_at_all (q : quantity) : Prop :=
  match q with
  | Odds_given_truth _ => (exists2 p, compares q p & at_rate p = true_positives) /\ (exists2 p, compares q p & at_rate p = false_positives)
  | _ => exists p, compares q p
  end.

Definition witnessed (q : quantity) (f : figure) : Prop :=
  let p := witness f in
  [/\ first_greatest q p, quantity_at q p = extended (value f)
    & if is_distance q then both f = None /\ raised f = [seq u <- range (decisions T) | 0 < surplus q p u]
      else raised f = [::] /\
           exists2 s, both f = Some s & ratio s.1 = amount q (setting_of p) (higher p) /\ ratio s.2 = amount q (setting_of p) (lower p)].

Definition figure_holds (q : quantity) (f : option figure) : Prop :=
  if f is Some f then exists_at_all q /\ witnessed q f else ~ exists_at_all q.

(* ---- Rates ---- *)

Definition rate_places (overall : bool) : list (Z * Z) :=
  if overall then [seq (nothing, a) | a <- range (groups T)] else [seq (x, a) | x <- range (contexts T), a <- range (groups T)].

Definition rates_hold (r : Z) (overall : bool) (rates : list (Z * Z * Q)) : Prop :=
  [/\ known T <> None,
      [seq t.1 | t <- rates] = [seq xa <- rate_places overall | 0 < all_draws r xa.1 xa.2]
    & forall t, List.In t rates -> rate r t.1.1 t.1.2 = ratio t.2].

(* ---- The constants of the utility ---- *)

Definition is_greatest (among : R -> Prop) (v : R) : Prop := among v /\ forall w, among w -> w <= v.
Definition is_least (among : R -> Prop) (v : R) : Prop := among v /\ forall w, among w -> v <= w.
Definition is_given (v : R) : Prop := exists2 g, List.In g (given T) & v = ratio g.

Definition compared_expectation (v : R) : Prop := exists x a b, [/\ has_cell x a, has_cell x b, a <> b & v = expectation x a].

(* g(u,x,a) - g(u,x,b), where both are given with their cells *)
Definition stated_gain (x a u : Z) : option Q :=
  if cell_at x a is Some c then List.nth (Z.to_nat u) (gains c) None else None.
Definition gap_of_groups (v : R) : Prop :=
  utility T = None /\ exists x a b u g h,
    [/\ u \in range (decisions T), stated_gain x a u = Some g, stated_gain x b u = Some h & v = ratio g - ratio h].

Definition lipschitz_is (v : R) : Prop :=
  (forall w, gap_of_groups w -> w <= v) /\ (gap_of_groups v \/ v = 0 /\ ~ exists w, gap_of_groups w).

(* ---- What is left out ---- *)

Definition without_cell (x : Z) : list Z := [seq a <- range (groups T) | ~~ has_cell x a].
Definition with_cell (x : Z) : list Z := [seq a <- range (groups T) | has_cell x a].
Definition occurs (a : Z) : bool := has (fun x => has_cell x a) (range (contexts T)).
Definition populated : list Z := [seq a <- range (groups T) | 0 < group_mass a].

Definition at_least_two (s : list Z) : bool := (1 < size s)%N.
Definition where_ (b : bool) (e : left_out) : list left_out := if b then [:: e] else [::].

(* of the groups with a cell in a context, or anywhere: those with the rate, and those without *)
Definition rate_left_out (r x : Z) : list left_out :=
  let here := [seq a <- range (groups T) | if x == nothing then occurs a else has_cell x a] in
  let lacking := [seq a <- here | ~~ (0 < all_draws r x a)] in
  where_ (lacking != [::]) (No_rate r x lacking)
  ++ where_ (at_least_two here && ~~ at_least_two [seq a <- here | 0 < all_draws r x a]) (Rate_alone r x).

Definition all_left_out : list left_out :=
  flatten [seq where_ (without_cell x != [::]) (No_decisions x (without_cell x)) | x <- range (contexts T)]
  ++ flatten [seq where_ (~~ at_least_two (with_cell x)) (Alone x) | x <- range (contexts T)]
  ++ (let empty := [seq a <- range (groups T) | occurs a && ~~ (0 < group_mass a)] in where_ (empty != [::]) (No_population empty))
  ++ (if means_exist then where_ (~~ at_least_two populated) No_means_alone else [:: No_means_missing])
  ++ (if known T is Some K then
        flatten [seq flatten [seq rate_left_out r x | x <- range (contexts T)] ++ (if pooled K then rate_left_out r nothing else [::])
                | r <- [:: true_positives; false_positives]]
      else [::]).

(* ---- Claims ---- *)

(* T6: no utility that ignores the group gives a greater ratio in any context, and one gives this; likewise of means, with a utility of the decision. *)
Definition mean_under (P : Z -> R) (g : Z -> R) : R := \sum_(u <- range (decisions T)) P u * g u.

Definition supremum_holds (local : bool) (v : option R) : Prop :=
  let ratio_under x a b g :=
    if local then quotient (mean_under (law x a) g) (mean_under (law x b) g)
    else quotient (mean_under (group_law a) g) (mean_under (group_law b) g) in
  let together x a b := (if local then has_cell x a && has_cell x b else has_mean a && has_mean b) && (a != b) in
  (forall x a b g, together x a b -> (forall u, 0 <= g u) -> no_more (ratio_under x a b g) v)
  /\ exists x a b g, [/\ together x a b, forall u, 0 <= g u & ratio_under x a b g = v].

(* Context and group are independent: M(x,a) M = M(x,.) M(.,a), and there is a cell for each context and group. *)
Definition total_mass : R := \sum_(a <- range (groups T)) group_mass a.
Definition context_mass (x : Z) : R := \sum_(a <- range (groups T)) cell_mass x a.
Definition independent : Prop :=
  complete /\ forall x a, x \in range (contexts T) -> a \in range (groups T) ->
    cell_mass x a * total_mass = context_mass x * group_mass a.

Definition bounded_by (q : quantity) (v : option R) : Prop :=
  exists_at_all q /\ forall p, compares q p -> no_more (quantity_at q p) v.

(* ---- A hidden factor ---- *)

(* Two expectations, explained by a factor with finitely many values: p and q are its laws in the two groups, e and e' what they get at each
   of its values.  Each value is at most k times as common in one group as in the other, and what one of them gets differs at most m times. *)
Definition explained_by (V : finType) (k m : R) (p q e e' : V -> R) (high low : R) : Prop :=
  [/\ (forall v, 0 < p v) /\ \sum_v p v = 1, (forall v, 0 < q v) /\ \sum_v q v = 1,
      (forall v, p v <= k * q v) /\ (forall v, q v <= k * p v),
      [/\ forall v, 0 <= e v, forall v, 0 <= e' v & (forall v w, e v <= m * e w) \/ (forall v w, e' v <= m * e' w)]
    & \sum_v p v * e v = high /\ \sum_v q v * e' v = low].

Definition too_weak (l : level) (k m : R) : bool :=
  match balanced l with Some b => (k < ratio b) && (m < ratio b) | None => true end
  || has (fun s => (k < ratio s.1) && (m < ratio s.2)) (strengths l).

(* Some two groups are compared of which every explanation that is too weak leaves a ratio above the number, at some value of the factor. *)
Definition not_explained (q : quantity) (l : level) : Prop :=
  exists2 p, compares q p & forall (V : finType) (k m : R) (P Q e e' : V -> R), 1 <= k -> 1 <= m -> too_weak l k m ->
    explained_by k m P Q e e' (amount q (setting_of p) (higher p)) (amount q (setting_of p) (lower p)) ->
    exists v, ~~ no_more (quotient (e v) (e' v)) (Some (ratio (down_to l))).

Definition hidden_needs (q : quantity) (v : option Q) (ls : list level) : Prop :=
  (if ls is l :: _ then ratio (down_to l) = 1 /\ extended v = extended (balanced l) else False)
  /\ forall l, List.In l ls -> not_explained q l.

(* ---- Limits ---- *)

Definition target_holds (q : quantity) (limit : R) (j : judgement) : Prop :=
  match j with
  | Within => exists_at_all q /\ forall p, compares q p -> no_more (quantity_at q p) (Some limit)
  | Exceeds => exists2 p, compares q p & ~~ no_more (quantity_at q p) (Some limit)
  | Inconclusive => ~ exists_at_all q
  | Depends => False
  end.

(* ---- Drift ---- *)

(* D u x a, the law of the decision that each cell may have now; each group has its contexts as often as before. *)
Definition is_law (D : Z -> R) : Prop := (forall u, u \in range (decisions T) -> 0 <= D u) /\ \sum_(u <- range (decisions T)) D u = 1.

(* within a total variation of v, or each probability within a factor of v *)
Definition moved (k : move) (v : R) (P D : Z -> R) : Prop :=
  is_law D /\
  match k with
  | By_variation => \sum_(u <- range (decisions T)) Num.max 0 (D u - P u) <= v
  | By_factor => forall u, u \in range (decisions T) -> D u <= v * P u /\ P u <= v * D u
  end.
Definition drifted (k : move) (v : R) (D : Z -> Z -> Z -> R) : Prop := forall x a, has_cell x a -> moved k v (law x a) (D x a).

Definition expectation_in (D : Z -> Z -> Z -> R) (x a : Z) : R := \sum_(u <- range (decisions T)) D x a u * gain x a u.
Definition group_mean_in (D : Z -> Z -> Z -> R) (a : Z) : R :=
  (\sum_(x <- range (contexts T)) cell_mass x a * expectation_in D x a) / group_mass a.
Definition amount_in (D : Z -> Z -> Z -> R) (local : bool) (x a : Z) : R := if local then expectation_in D x a else group_mean_in D a.

(* Of the places where a ratio is compared *)
Definition ratio_of_all (local : bool) : quantity := if local then Local else Global.
Definition ratio_in (D : Z -> Z -> Z -> R) (local : bool) (p : place) : option R :=
  quotient (amount_in D local (at_context p) (higher p)) (amount_in D local (at_context p) (lower p)).

Definition all_within (D : Z -> Z -> Z -> R) (local : bool) (limit : R) : Prop :=
  forall p, compares (ratio_of_all local) p -> no_more (ratio_in D local p) (Some limit).
Definition one_exceeds (D : Z -> Z -> Z -> R) (local : bool) (limit : R) : Prop :=
  exists2 p, compares (ratio_of_all local) p & ~~ no_more (ratio_in D local p) (Some limit).

(* The table gives the verdict, and so does whatever drift is meant.  If no farther: within is ended by some drift that is farther by as
   little as one likes, and exceeds by some drift that is as far. *)
Definition stands (s : stand) (limit : R) : Prop :=
  let local := is_local s in
  let so D := if keeps_limit s then all_within D local limit else one_exceeds D local limit in
  let meant v := match how_far s with Some w => if keeps_limit s then v <= ratio w else v < ratio w | None => true end in
  [/\ target_holds (ratio_of_all local) limit (if keeps_limit s then Within else Exceeds),
      forall v D, meant v -> drifted (moves_by s) v D -> so D
    & match no_further s, how_far s with
      | true, Some w =>
          if keeps_limit s then forall v, ratio w < v -> exists2 D, drifted (moves_by s) v D & one_exceeds D local limit
          else exists2 D, drifted (moves_by s) (ratio w) D & all_within D local limit
      | _, _ => True
      end].

(* v is the greatest ratio of two groups that such a drift can bring about, or the least that the greatest of all ratios can have. *)
Definition ratio_under_drift (local greatest_ : bool) (eta : R) (v : option R) : Prop :=
  exists_at_all (ratio_of_all local) /\
  if greatest_ then
    (forall D, drifted By_variation eta D -> forall p, compares (ratio_of_all local) p -> no_more (ratio_in D local p) v) /\
    exists D p, [/\ drifted By_variation eta D, compares (ratio_of_all local) p & ratio_in D local p = v]
  else
    (forall D, drifted By_variation eta D -> exists2 p, compares (ratio_of_all local) p & no_more v (ratio_in D local p)) /\
    exists2 D, drifted By_variation eta D & forall p, compares (ratio_of_all local) p -> no_more (ratio_in D local p) v.

(* Exceeds if any target is exceeded, else depends if any depends, else inconclusive if any is, else within; none without targets. *)
Definition verdict_of (targets : list judgement) : option judgement :=
  let is_there (f : judgement -> bool) := has f targets in
  if is_there (fun j => if j is Exceeds then true else false) then Some Exceeds
  else if is_there (fun j => if j is Depends then true else false) then Some Depends
  else if is_there (fun j => if j is Inconclusive then true else false) then Some Inconclusive
  else if targets is _ :: _ then Some Within else None.

(* ---- When a statement holds ---- *)

Definition holds (s : statement) : Prop :=
  match s with
  | Entries_are n => n = Z.mul (Z.of_nat (size (cells T))) (decisions T)
  | Figure_is q f => figure_holds q f
  | Rates_are r overall rates => rates_hold r overall rates
  | Gamma_is v => is_greatest is_given (ratio v)
  | Least_is v => is_least is_given (ratio v)
  | Tau_is (Some v) => is_least compared_expectation (ratio v)
  | Tau_is None => ~ exists v, compared_expectation v
  | Lipschitz_is v => lipschitz_is (ratio v)
  | Depends_on_group_is b => b <-> exists2 w, gap_of_groups w & 0 < w
  | Not_compared_is entries => entries = all_left_out
  | Quantity_is q v => exists_at_all q /\ greatest q (extended v)
  | Supremum_is local v => supremum_holds local (extended v)
  | Quantity_at_most By_T5 q v => [/\ q = Global, independent & bounded_by q (extended v)]
  | Quantity_at_most By_T7 q v => bounded_by q (extended v)
  | Hidden_needs local v levels => hidden_needs (if local then Local else Global) v levels
  | Stands s limit => stands s (ratio limit)
  | Ratio_under_drift local greatest_ eta v _ _ => ratio_under_drift local greatest_ (ratio eta) (extended v)
  | Target_is by_ local limit j => target_holds (limited by_ local) (ratio limit) j
  | Verdict_is targets v => v = verdict_of targets
  end.
End Meaning.
