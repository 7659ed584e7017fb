(* From JSON to a class of utilities and to the evidence of claims about it, as docs/certificate-worst-case.md describes them.

   This file only computes.  The class and the table are given to kernel/WorstCase.v as it wants them. *)

From Coq Require Import ZArith QArith List Ascii String.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require WorstCase.
From FairauditChecker Require Import Json Reading Table TableText.
From FairauditKernel Require Import Fractions.
Import ListNotations.


Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.

Definition k_quantity := of_string "quantity".
Definition k_gamma := of_string "gamma".
Definition k_m := of_string "m".
Definition k_tau := of_string "tau".
Definition k_tau_on := of_string "tau_on".
Definition k_blind := of_string "blind".
Definition k_lipschitz := of_string "lipschitz".
Definition k_metric := of_string "metric".
Definition k_order := of_string "order".
Definition k_rows := of_string "rows".
Definition k_family := of_string "family".
Definition k_terms := of_string "terms".
Definition k_bound := of_string "bound".
Definition k_names := of_string "names".
Definition k_lower := of_string "lower".
Definition k_upper := of_string "upper".
Definition k_features := of_string "features".
Definition k_coefficients := of_string "coefficients".
Definition k_pairs := of_string "pairs".
Definition k_theta := of_string "theta".
Definition k_higher := of_string "higher".
Definition k_multipliers := of_string "multipliers".

(* ---- The class ---- *)

Definition is_zero (q : Q) : bool := (Qnum q =? 0)%Z.

(* 0 on the diagonal alone, and d(i,j) <= d(i,k) + d(j,k) *)
Definition distances_hold (d : list (list Q)) : bool :=
  forallb (fun ir => forallb (fun jq => Bool.eqb (is_zero jq.2) (ir.1 =? jq.1)%Z) (WorstCase.numbered 0 ir.2)) (WorstCase.numbered 0 d)
  && forallb (fun r => forallb (fun qs : Q * list Q =>
       forallb (fun p : Q * Q => at_most qs.1 (plus p.1 p.2)) (combine r qs.2)) (combine r d)) d.

Fixpoint columns_of_rows (n : nat) (rows : list (list Q)) : list (list Q) :=
  match n with S n => map (hd Fractions.zero) rows :: columns_of_rows n (map (@tl Q) rows) | O => [] end.

Fixpoint same_rows (rs ss : list (list Q)) : bool :=
  match rs, ss with
  | r :: rs, s :: ss => forallb (fun p => equal p.1 p.2) (combine r s) && same_rows rs ss
  | _, _ => true
  end.

Definition metric_of (v : json) : read (list (list Q)) :=
  let* vs := list_of v in
  let* d := each (so_many (size vs) not_negative) vs in
  demand (same_rows d (columns_of_rows (List.length d) d) && distances_hold d) "is not a metric" (Good d).

Definition term_of (blind : bool) (v : json) : read WorstCase.term :=
  let* vs := list_of v in
  match vs with
  | [x; a; u; c] =>
      let* x := integer_of x in
      let* a := match blind, a with true, Null => Good (-1)%Z | true, _ => bad "names a group, but the class is blind" | false, a => integer_of a end in
      let* u := integer_of u in
      let* c := rational_of c in
      Good (WorstCase.Term x a u c)
  | _ => bad "must have 4 entries"
  end.

Definition constraint_of (blind : bool) (v : json) : read (list WorstCase.term * Q) :=
  let* ms := fields [k_terms; k_bound] [] v in
  let* ts := get (many (term_of blind)) k_terms ms in
  let* b := get rational_of k_bound ms in
  Good (ts, b).

Definition family_row_of (n : Z) (v : json) : read (list Q * Q) :=
  let* ms := fields [k_coefficients; k_bound] [] v in
  let* cs := get (so_many n rational_of) k_coefficients ms in
  let* b := get rational_of k_bound ms in
  Good (cs, b).

(* with the features, by cell and decision *)
Definition family_of (v : json) : read (WorstCase.family * list (list (list Q))) :=
  let* ms := fields [k_names; k_lower; k_upper; k_features; k_rows] [] v in
  let* names := get distinct_strings k_names ms in
  let n := size names in
  let* lower := get (so_many n rational_of) k_lower ms in
  let* upper := get (so_many n rational_of) k_upper ms in
  let* fs := get (many (many (so_many n rational_of))) k_features ms in
  let* rows := get (many (family_row_of n)) k_rows ms in
  demand (forallb (fun e => at_most e.1 e.2) (combine lower upper)) "has a lower end above the upper end"
    (Good (WorstCase.Family lower upper rows, fs)).

Record stated_class := StatedClass { class_of : WorstCase.utilities; features_of : list (list (list Q)) }.

Definition pair_of_decisions (decisions : list text) (v : json) : read (Z * Z) :=
  let* ts := so_many 2 string_of v in
  match map (fun t => position (same t) decisions) ts with
  | [l; h] => demand ((0 <=? l) && (0 <=? h))%Z "names a decision that the table does not have" (Good (l, h))
  | _ => bad "must have 2 entries"
  end.

Definition read_class (H : header) (v : json) : read stated_class :=
  let* ms := fields [k_quantity; k_gamma; k_m; k_tau; k_tau_on; k_blind; k_lipschitz; k_metric; k_order; k_rows; k_family] [] v in
  let* blind := get boolean_of k_blind ms in
  let* gamma := get not_negative k_gamma ms in
  let* m := get not_negative k_m ms in
  let* tau := get (option_of not_negative) k_tau ms in
  let* lipschitz := get (option_of not_negative) k_lipschitz ms in
  let* local := get (choice [(k_local, true); (k_global, false)]) k_quantity ms in
  let* on_pair := get (choice [(of_string "pair", true); (of_string "all", false)]) k_tau_on ms in
  let* metric := get (option_of metric_of) k_metric ms in
  let* order := get (many (pair_of_decisions (decisions_of H))) k_order ms in
  let* rows := get (many (constraint_of blind)) k_rows ms in
  let* family := get (option_of family_of) k_family ms in
  demand (~~ is_zero gamma && at_most m gamma) "gamma must be positive and at least m"
  (demand (match tau with Some t => at_most t gamma | None => true end) "tau must be at most gamma"
  (demand (match blind, lipschitz with true, Some _ => false | _, _ => true end) "a blind class has no Lipschitz constant"
  (demand (match metric with Some d => of_length (size (groups_of H)) d | None => true end) "the metric must have a row for each group"
  (Good (StatedClass (WorstCase.Utilities local gamma m tau on_pair blind lipschitz metric order rows (option_map fst family))
          (match family with Some f => f.2 | None => [] end)))))).

(* ---- The table, as that kernel has it ---- *)

Section For_class.
Variables (H : header) (S : stated_class) (cs : list cell).
Let K := class_of S.

Definition range_of (n : Z) : list Z := Table.range n.

Fixpoint outcomes_from (u : Z) (ws : list Q) (gs : list Q) (fs : list (list Q)) : list WorstCase.outcome :=
  match ws with
  | w :: ws => WorstCase.Outcome u w (hd [] fs) (hd Fractions.zero gs) :: outcomes_from (u + 1) ws (tl gs) (tl fs)
  | [] => []
  end.

Definition kernel_cell (c : cell) (fs : list (list Q)) : WorstCase.cell :=
  let gs := match utility_of H with Some gs => gs | None => map (fun g => match g with Some g => g | None => Fractions.zero end) (gains c) end in
  WorstCase.Cell (context c) (group c) (outcomes_from 0 (weights c) gs fs) (mass c).

Fixpoint kernel_cells (cs : list cell) (fs : list (list (list Q))) : list WorstCase.cell :=
  match cs with c :: cs => kernel_cell c (hd [] fs) :: kernel_cells cs (tl fs) | [] => [] end.

Definition kernel_table : WorstCase.table :=
  WorstCase.Table (range_of (size (contexts_of H))) (range_of (size (groups_of H)))
    (match population_of (about_of H) with Counted => WorstCase.Counted | Given => WorstCase.Given | Alike => WorstCase.Alike end)
    (kernel_cells cs (features_of S)).

Definition term_exists (t : WorstCase.term) : bool :=
  (WorstCase.of_decision t <? size (decisions_of H))%Z
  && existsb (fun c => (context c =? WorstCase.of_context t)%Z && (WorstCase.blind K || (group c =? WorstCase.of_group t)%Z)) cs.

Fixpoint alike_features (cs : list cell) (fs : list (list (list Q))) : bool :=
  match cs, fs with
  | c :: ((d :: _) as cs), f :: ((g :: _) as fs) => (if (context c =? context d)%Z then same_rows f g else true) && alike_features cs fs
  | _, _ => true
  end.

(* Whether class and table fit *)
Definition fits : read unit :=
  demand (forallb (fun r => forallb term_exists r.1) (WorstCase.rows K)) "a constraint names what the table does not have"
  (match WorstCase.parameters K with
   | None => Good tt
   | Some _ =>
       demand (of_length (size cs) (features_of S) && forallb (of_length (size (decisions_of H))) (features_of S))
         "features must have one list for each cell and decision"
       (demand (if WorstCase.blind K then alike_features cs (features_of S) else true) "features differ between groups, but the class is blind" (Good tt))
   end).
End For_class.

(* ---- Evidence ---- *)

Fixpoint increasing {A} (less : A -> A -> bool) (xs : list A) : bool :=
  match xs with x :: ((y :: _) as rest) => less x y && increasing less rest | _ => true end.

Definition multiplier_of (v : json) : read (Z * Q) :=
  let* vs := list_of v in
  match vs with
  | [i; y] => let* i := integer_of i in let* y := not_negative y in demand (~~ is_zero y) "must be positive" (Good (i, y))
  | _ => bad "must have 2 entries"
  end.

Definition multipliers_of (v : json) : read (list (Z * Q)) :=
  let* ys := many multiplier_of v in demand (increasing (fun y z => (y.1 <? z.1)%Z) ys) "numbers must increase" (Good ys).

Definition pair_of (local : bool) (v : json) : read WorstCase.evidence :=
  let* ms := fields ((if local then [k_context] else []) ++ [k_higher; k_lower; k_multipliers]) [] v in
  let* x := if local then get integer_of k_context ms else Good (-1)%Z in
  let* h := get integer_of k_higher ms in
  let* l := get integer_of k_lower ms in
  let* ys := get multipliers_of k_multipliers ms in
  Good (WorstCase.Evidence x h l ys).

Definition pair_before (e f : WorstCase.evidence) : bool :=
  ((WorstCase.at_context e <? WorstCase.at_context f) || ((WorstCase.at_context e =? WorstCase.at_context f)
    && ((WorstCase.higher e <? WorstCase.higher f) || ((WorstCase.higher e =? WorstCase.higher f) && (WorstCase.lower_group e <? WorstCase.lower_group f)))))%Z.

Definition pairs_of (local : bool) (K : option WorstCase.utilities) (v : json) : read (list WorstCase.evidence) :=
  let parameters := match K with Some K => WorstCase.parameters K | None => None end in
  let* ms := fields (k_pairs :: match parameters with Some _ => [k_theta] | None => [] end) [] v in
  let* es := get (many (pair_of local)) k_pairs ms in
  let* _ := match parameters with Some F => get (so_many (size (WorstCase.lower F)) rational_of) k_theta ms | None => Good [] end in
  demand (increasing pair_before es) "pairs must increase" (Good es).
