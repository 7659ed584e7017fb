(* The checker of statements about a table.

   This file only computes; CheckerSound.v proves: what is said to be true of a valid table
   holds of it. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Table Statements Figures Distances LeftOut.
From FairauditChecker Require Hidden Drift.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* ---- Equality ---- *)

Definition same_value (q r : Q) : bool := Qnum q * Zpos (Qden r) =? Qnum r * Zpos (Qden q).

Definition same_option {A} (same : A -> A -> bool) (x y : option A) : bool :=
  match x, y with
  | Some a, Some b => same a b
  | None, None => true
  | _, _ => false
  end.

Fixpoint same_list {A} (same : A -> A -> bool) (xs ys : list A) : bool :=
  match xs, ys with
  | x :: xs, y :: ys => if same x y then same_list same xs ys else false
  | [], [] => true
  | _, _ => false
  end.

Definition same_place (p q : place) : bool :=
  [&& at_rate p =? at_rate q, at_context p =? at_context q, at_decision p =? at_decision q, higher p =? higher q & lower p =? lower q].

Definition same_figure (f g : figure) : bool :=
  [&& same_option same_value (value f) (value g), same_place (witness f) (witness g),
      same_option (fun s t => same_value s.1 t.1 && same_value s.2 t.2) (both f) (both g) & same_list Z.eqb (raised f) (raised g)].

Definition same_quantity (q r : quantity) : bool :=
  match q, r with
  | Local, Local | Global, Global | Equalized_odds, Equalized_odds | Demographic_parity, Demographic_parity
  | Local_supremum, Local_supremum | Global_supremum, Global_supremum
  | Local_difference, Local_difference | Global_difference, Global_difference => true
  | Equal_opportunity a, Equal_opportunity b | Odds_given_truth a, Odds_given_truth b => Bool.eqb a b
  | _, _ => false
  end.

Definition same_judgement (j k : judgement) : bool :=
  match j, k with
  | Within, Within | Exceeds, Exceeds | Inconclusive, Inconclusive | Depends, Depends => true
  | _, _ => false
  end.

(* ---- All figures ---- *)

Record facts := Facts {
  subject : table;
  of_contexts : list (Z * list row);
  of_groups : list row;     (* those without mass included *)
  figures : list (quantity * option figure)
}.

Section Blocks.
Variables (T : table) (F : list (Z * list row)) (G : list row). (* by context; the groups whose means are compared *)

Definition blocks_of (q : quantity) : list block :=
  let n := Z.to_nat (decisions T) in
  match q with
  | Local | Local_difference => map (fun xr => of_means xr.1 xr.2) F
  | Global | Global_difference => [of_means nothing G]
  | Local_supremum => flat_map (fun xr => of_decisions n xr.1 0 (laws_of xr.2)) F
  | Global_supremum => of_decisions n nothing 0 (laws_of G)
  | _ => []
  end.

Definition figure_by_rates (rates : list Z) (overall : bool) : option found :=
  match known T with
  | Some K => best_of widest_difference (flat_map (fun r => map (fun b => of_rates r b.1 b.2) (counts T K r overall)) rates)
  | None => None
  end.

Definition compute (q : quantity) : option figure :=
  match q with
  | Local | Global | Local_supremum | Global_supremum =>
      if signed T then None else option_map figure_of (best_of widest_ratio (blocks_of q))
  | Local_difference | Global_difference => option_map figure_of (best_of widest_difference (blocks_of q))
  | Equalized_odds => option_map distance_figure (farthest_of (map (fun xr => (xr.1, map side_of xr.2)) F))
  | Demographic_parity => option_map distance_figure (farthest_of [(nothing, map side_of G)])
  | Equal_opportunity o => option_map figure_of (figure_by_rates [true_positives] o)
  | Odds_given_truth o =>
      match figure_by_rates [true_positives] o, figure_by_rates [false_positives] o with
      | Some _, Some _ => option_map figure_of (figure_by_rates [true_positives; false_positives] o)
      | _, _ => None
      end
  end.
End Blocks.

Definition quantities (T : table) : list quantity :=
  [Local; Global; Equalized_odds; Demographic_parity; Local_supremum; Global_supremum; Local_difference; Global_difference]
  ++ match known T with
     | Some _ => [Equal_opportunity false; Equal_opportunity true; Odds_given_truth false; Odds_given_truth true]
     | None => []
     end.

Definition with_mass (rs : list row) : list row := filter (fun r => positive_fraction (bulk r)) rs.

Definition facts_of (T : table) : facts :=
  let F := rows_of T in
  let A := group_rows T F in
  let G := if with_means T then with_mass A else [] in
  Facts T F A (map (fun q => (q, compute T F G q)) (quantities T)).

Definition figure_in (D : facts) (q : quantity) : option figure :=
  match find (fun qf => same_quantity qf.1 q) (figures D) with Some qf => qf.2 | None => None end.

(* ---- Rates ---- *)

Definition rates_in (T : table) (r : Z) (overall : bool) : list (Z * Z * Q) :=
  match known T with
  | Some K => flat_map (fun b => map (fun t => (b.1, t.1, (rate_of t).2)) (filter drawn b.2)) (counts T K r overall)
  | None => []
  end.

Definition same_rate (t u : Z * Z * Q) : bool := [&& t.1.1 =? u.1.1, t.1.2 =? u.1.2 & same_value t.2 u.2].

Definition rates_as_stated (T : table) (r : Z) (overall : bool) (rates : list (Z * Z * Q)) : bool :=
  match known T with Some _ => same_list same_rate rates (rates_in T r overall) | None => false end.

(* ---- The constants ---- *)

Definition greater (q r : Q) : Q := if at_most q r then r else q.
Definition lesser (q r : Q) : Q := if at_most q r then q else r.

Definition greatest_in (qs : list Q) : option Q := match qs with q :: rest => Some (fold_left greater rest q) | [] => None end.
Definition least_in (qs : list Q) : option Q := match qs with q :: rest => Some (fold_left lesser rest q) | [] => None end.

Definition compared_means (D : facts) : list Q :=
  flat_map (fun xr => match xr.2 with _ :: _ :: _ => map mean xr.2 | _ => [] end) (of_contexts D).

Definition spread (gs : list (option Q)) : Q :=
  let given := flat_map (fun g => match g with Some g => [g] | None => [] end) gs in
  match greatest_in given, least_in given with Some g, Some l => plus g (minus l) | _, _ => zero end.

Fixpoint spreads (n : nat) (rows : list (list (option Q))) : list Q :=
  match n with
  | S n => spread (map (hd None) rows) :: spreads n (map (@tl (option Q)) rows)
  | O => []
  end.

Definition lipschitz (T : table) : Q :=
  match utility T with
  | Some _ => zero
  | None => fold_left greater (flat_map (fun xcs => spreads (Z.to_nat (decisions T)) (map gains xcs.2)) (runs context (cells T))) zero
  end.

(* ---- Independence ---- *)

Definition independent (D : facts) : bool :=
  let masses := map bulk (of_groups D) in
  let all := sum masses in
  full (subject D)
  && forallb (fun xr => let here := sum (map bulk xr.2) in
                        forallb (fun rm => same_value (times (bulk rm.1) all) (times here rm.2)) (combine xr.2 masses)) (of_contexts D).

(* ---- Limits ---- *)

Definition judged (f : option figure) (limit : Q) : judgement :=
  match f with
  | None => Inconclusive
  | Some f => if not_above (value f) (Some limit) then Within else Exceeds
  end.

Definition overall (targets : list judgement) : option judgement :=
  if existsb (same_judgement Exceeds) targets then Some Exceeds
  else if existsb (same_judgement Depends) targets then Some Depends
  else if existsb (same_judgement Inconclusive) targets then Some Inconclusive
  else match targets with _ :: _ => Some Within | [] => None end.

(* (R-1)/(R+1), and 1 for an infinite R *)
Definition bound_of_distance (R : option Q) : Q :=
  match R with Some r => times (plus r (minus Fractions.one)) (inverse (plus r Fractions.one)) | None => Fractions.one end.

Definition bounds (f : option figure) (v : option Q) : bool := match f with Some f => not_above (value f) v | None => false end.

Definition equals (f : option figure) (v : option Q) : bool :=
  match f with Some f => same_option same_value (value f) v | None => false end.

Definition by_supremum (D : facts) (q : quantity) (v : option Q) : bool :=
  match q with
  | Equalized_odds => match figure_in D Local_supremum with Some f => same_option same_value (Some (bound_of_distance (value f))) v | None => false end
  | Demographic_parity => match figure_in D Global_supremum with Some f => same_option same_value (Some (bound_of_distance (value f))) v | None => false end
  | _ => false
  end.

(* ---- Statements ---- *)

(* What is stated of cells that move; none: not decided *)
Definition under_drift (D : facts) (s : statement) : option bool :=
  match s with
  | Stands st limit =>
      Drift.stands_for_ratio (subject D) (of_contexts D) (of_groups D) (figure_in D (if is_local st then Local else Global)) st limit
  | Ratio_under_drift local worst eta v p fs =>
      Drift.ratio_holds (subject D) (of_contexts D) (of_groups D) (figure_in D (if local then Local else Global)) local worst eta v p fs
  | _ => Some false
  end.

Definition stands_in_nats (D : facts) (st : stand) (limit : Q) : option bool :=
  Drift.stands_for_log (subject D) (of_contexts D) (of_groups D) (figure_in D (if is_local st then Local else Global)) st limit.

Definition is_true_of (D : facts) (s : statement) : bool :=
  match s with
  | Entries_are n => n =? Z.of_nat (length (cells (subject D))) * decisions (subject D)
  | Figure_is q f => same_option same_figure f (figure_in D q)
  | Gamma_is v => match greatest_in (given (subject D)) with Some g => same_value v g | None => false end
  | Least_is v => match least_in (given (subject D)) with Some g => same_value v g | None => false end
  | Tau_is v => same_option same_value v (least_in (compared_means D))
  | Lipschitz_is v => same_value v (lipschitz (subject D))
  | Depends_on_group_is b => Bool.eqb b (positive_fraction (lipschitz (subject D)))
  | Quantity_is q v => equals (figure_in D q) v
  | Supremum_is local v => equals (figure_in D (if local then Local_supremum else Global_supremum)) v
  | Quantity_at_most By_T5 q v => [&& same_quantity q Global, independent D, equals (figure_in D Local) v & bounds (figure_in D Global) v]
  | Quantity_at_most By_T7 q v => by_supremum D q v && bounds (figure_in D q) v
  | Hidden_needs local v ls => match figure_in D (if local then Local else Global) with Some f => Hidden.frontier_fits (value f) v ls | None => false end
  | Stands _ _ | Ratio_under_drift _ _ _ _ _ _ => match under_drift D s with Some b => b | None => false end
  | Target_is by_ local limit j => same_judgement j (judged (figure_in D (limited by_ local)) limit)
  | Verdict_is targets v => same_option same_judgement v (overall targets)
  | Not_compared_is entries => left_out_as_stated (subject D) (of_contexts D) (of_groups D) entries
  | Rates_are r overall rates => rates_as_stated (subject D) r overall rates
  end.

(* Of a table every statement is judged; other parts of a certificate may not be covered. *)
Inductive outcome := True_ | False_ | Not_covered.

Definition outcome_of (D : facts) (s : statement) : outcome :=
  if is_true_of D s then True_ else match under_drift D s with Some _ => False_ | None => Not_covered end.

(* The outcome of each statement; nothing where the table is malformed *)
Definition check (T : table) (ss : list statement) : option (list outcome) :=
  if valid T then let D := facts_of T in Some (map (outcome_of D) ss) else None.
