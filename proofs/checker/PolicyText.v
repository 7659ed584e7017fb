(* From JSON to a policy behind filters: the header with its filters, the rows, the true cells and what was declared, as
   docs/certificate-policy.md describes them.

   This file only computes.  What a policy has to be beyond the types of its parts is demanded by [valid] of Policy.v. *)

From Coq Require Import ZArith QArith List Ascii String.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditKernel Require WorstCase.
From FairauditChecker Require Import Json Reading Table TableText ClassText Document.
From FairauditChecker Require Policy.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.

Definition k_filters := of_string "filters".
Definition k_inputs := of_string "inputs".
Definition k_outputs := of_string "outputs".
Definition k_releases := of_string "releases".
Definition k_draws := of_string "draws".
Definition k_true_context := of_string "true_context".
Definition k_true_group := of_string "true_group".
Definition k_global_tau := of_string "global_tau".
Definition k_by_context := of_string "by_context".
Definition policy_kind := of_string "policy".

Definition says_policy (ms : list (text * json)) : bool := match found k_kind ms with Some (Text t) => same t policy_kind | _ => false end.

(* Kind, columns and population are those of probabilities; no certificate says of itself that it is of both kinds. *)
Definition as_probabilities (ms : list (text * json)) : list (text * json) :=
  map (fun m => if same m.1 k_kind then (m.1, Text (of_string "probabilities")) else m) ms.

(* ---- Filters ---- *)

Record factor := Factor { covers : Z; inputs : list (list text); outputs : list (list text); entries : Policy.matrix }.

Fixpoint kept {A} (used : list bool) (xs : list A) : list A :=
  match used, xs with b :: us, x :: rest => if b then x :: kept us rest else kept us rest | _, _ => [] end.

(* Without the outputs that no input releases *)
Definition read_factor (v : json) : read factor :=
  let* ms := fields [k_inputs; k_outputs; k_rows] [] v in
  let* first := get list_of k_inputs ms in
  let* width := match first with Items ls :: _ => Good (size ls) | _ => bad "must list labels" end in
  let* ins := get (label_lists width) k_inputs ms in
  let* outs := get (label_lists width) k_outputs ms in
  let n := size outs in
  let* rows := get (so_many (size ins) (so_many n not_negative)) k_rows ms in
  let used := map Policy.some_positive (Policy.columns (List.length outs) rows) in
  demand (0 <? width)%Z "must list labels"
    (demand (forallb (fun row => equal (total row) one) rows) "has probabilities that do not sum to 1"
      (Good (Factor width ins (kept used outs) (map (kept used) rows)))).

Definition read_filter (columns_there : Z) (v : json) : read (list factor) :=
  let* fs := many read_factor v in
  demand (match fs with [] => false | _ => true end && (fold_right (fun f n => covers f + n) 0 fs =? columns_there))%Z
    "must have factors that cover the columns together" (Good fs).

Fixpoint joined (lists : list (list (list text))) : list (list text) :=
  match lists with l :: rest => let others := joined rest in flat_map (fun part => map (app part) others) l | [] => [[]] end.
Definition how_many (lists : list (list (list text))) : Z := fold_right (fun l n => size l * n)%Z 1%Z lists.

Record filters := Filters { of_groups : list factor; of_contexts : option (list factor); released_times : positive }.

Definition read_filters (a : about) (v : json) : read filters :=
  let* ms := fields [k_group; k_context] [k_releases] v in
  let* n := match found k_releases ms with
    | Some v => let* n := at_place k_releases (integer_of v) in
                demand ((2 <=? n) && (n <=? 10000))%Z "must have releases from 2 to 10000" (Good (Z.to_pos n))
    | None => Good 1%positive end in
  let* gs := get (read_filter (size (of_group (columns_of a)))) k_group ms in
  let* xs := get (option_of (read_filter (size (of_context (columns_of a))))) k_context ms in
  demand (2 <=? how_many (map inputs gs))%Z "has fewer than two true groups" (Good (Filters gs xs n)).

(* ---- Labels: of what is true, and of what is released ---- *)

Section Labels.
Variables (H : header) (F : filters).

Definition true_group_lists : list (list (list text)) := map inputs (of_groups F).
Definition true_context_lists : list (list (list text)) := match of_contexts F with Some fs => map inputs fs | None => [contexts_of H] end.
Definition released_group_lists : list (list (list text)) := map outputs (of_groups F).
Definition released_context_lists : list (list (list text)) :=
  match of_contexts F with Some fs => map outputs fs | None => [contexts_of H] end.

(* What takes more than this is left to others. *)
Definition too_large : bool :=
  let cells := (how_many true_context_lists * how_many true_group_lists)%Z in
  ((20000 <? cells) || (200000 <? cells * size (decisions_of H))
   || (200000 <? how_many true_group_lists * how_many released_group_lists)
   || (200000 <? how_many true_context_lists * how_many released_context_lists)
   || (200000 <? how_many true_context_lists * how_many released_group_lists * size (decisions_of H)))%Z.

(* The header of the induced law *)
Definition true_header : header :=
  Header (about_of H) (decisions_of H) (joined true_group_lists) (joined true_context_lists) (utility_of H) None false.

(* ---- The rows of the policy ---- *)

Record policy_row := Row { at_x : Z; at_a : Z; row_weights : list Q; drawn : bool }.

Definition read_row (v : json) : read policy_row :=
  let n := List.length (decisions_of H) in
  let* ms := fields [k_context; k_group; k_weights] [k_draws] v in
  let* x := get (below (size (contexts_of H))) k_context ms in
  let* a := get (below (size (groups_of H))) k_group ms in
  let* ws := get (so_many (size (decisions_of H)) not_negative) k_weights ms in
  let* d := match found k_draws ms with
    | Some v => let* d := at_place k_draws (integer_of v) in
                demand ((0 <? d) && (Z.modulo d (Policy.common (map reduced ws)) =? 0))%Z "has draws that do not fit its weights" (Good true)
    | None => Good false end in
  demand ((0 <=? x) && (0 <=? a))%Z "is out of range"
    (demand (Policy.is_law n ws) "has weights that do not sum to 1" (Good (Row x a ws d))).

Fixpoint rows_in_order (rows : list policy_row) : bool :=
  match rows with
  | r :: ((s :: _) as rest) => ((at_x r <? at_x s) || ((at_x r =? at_x s) && (at_a r <? at_a s)))%Z && rows_in_order rest
  | _ => true
  end.

(* The law of a row, if there is one *)
Definition rows_at (rows : list policy_row) (x : Z) : list policy_row := filter (fun r => at_x r =? x)%Z rows.
Fixpoint law_at (rows : list policy_row) (a : Z) : option (list Q) :=
  match rows with r :: rest => if (at_a r =? a)%Z then Some (row_weights r) else law_at rest a | [] => None end.

(* By context and by group; nothing where one lacks *)
Definition laws_of (rows : list policy_row) (xs gs : list (list text)) : option (list (list (list Q))) :=
  let places := map (number_of (groups_of H)) gs in
  all_there (map (fun x => let here := rows_at rows (number_of (contexts_of H) x) in all_there (map (law_at here) places) []) xs) [].

(* ---- True cells ---- *)

Definition weighted : bool := match population_of (about_of H) with Given => true | _ => false end.
Definition by_cell : bool := match utility_of H with None => true | Some _ => false end.
Definition is_true_cell (v : json) : bool := match v with Members ms => has k_true_group ms | _ => false end.

Fixpoint rows_before (rows : list json) (done : list json) : list json * list json :=
  match rows with v :: rest => if is_true_cell v then (rev_append done [], rows) else rows_before rest (v :: done) | [] => (rev_append done [], []) end.

Definition read_true_cell (i : Z) (v : json) : read (Q * list Q) :=
  let n := how_many true_group_lists in
  let* ms := fields ([k_true_context; k_true_group] ++ key_if weighted k_mass ++ key_if by_cell k_utility) [] v in
  let* x := get integer_of k_true_context ms in
  let* a := get integer_of k_true_group ms in
  let* m := if_there weighted one (get not_negative k_mass ms) in
  let* g := if_there by_cell [] (get (so_many (size (decisions_of H)) rational_of) k_utility ms) in
  demand ((x * n + a =? i) && (0 <=? a) && (a <? n))%Z "is not the next true cell" (Good (m, g)).

Definition read_true_cells (vs : list json) : read (list (Q * list Q)) :=
  let n := if weighted || by_cell then (how_many true_context_lists * how_many true_group_lists)%Z else 0%Z in
  demand (of_length n vs) "does not list every true cell, or some that are not needed"
    (each (fun iv => read_true_cell iv.1 iv.2) (WorstCase.numbered 0 vs)).

(* ---- The policy ---- *)

Definition matrices (fs : list factor) : list Policy.matrix := map entries fs.

Definition behind_of (D : Policy.declared) (laws : list (list (list Q))) (cells : list (Q * list Q)) : Policy.behind :=
  let tx := Z.to_nat (how_many true_context_lists) in
  let ta := Z.to_nat (how_many true_group_lists) in
  Policy.Behind (matrices (of_groups F))
    (match of_contexts F with Some fs => Policy.Filtered (matrices fs) | None => Policy.AsIs (List.length (contexts_of H)) end)
    (released_times F) (List.length (decisions_of H)) laws
    (if weighted then Some (Policy.pieces tx ta (map fst cells)) else None)
    (match utility_of H with Some g => Policy.OfDecision g | None => Policy.OfCell (Policy.pieces tx ta (map snd cells)) end)
    D.

(* The table of the policy without its filters, where what it sees can be what is true: the law T(u|x,a) *)
Definition unfiltered_table (B : Policy.behind) (rows : list policy_row) : option table :=
  let cell_of x al := Cell (Z.of_nat x) (Z.of_nat al.1) al.2 (if by_cell then map Some (Policy.gains B x al.1) else [])
                        (Policy.mass_in B x al.1) [] in
  option_map (fun laws => Table (how_many true_context_lists) (how_many true_group_lists) (size (decisions_of H))
      (if weighted then Given else Alike) (utility_of H) None
      (flat_map (fun xl => map (cell_of xl.1) (Policy.numbered xl.2)) (Policy.numbered laws)))
    (laws_of rows (joined true_context_lists) (joined true_group_lists)).
End Labels.

(* ---- What was declared ---- *)

Definition maybe (k : text) (ms : list (text * json)) : read (option Q) :=
  match found k ms with Some v => let* q := at_place k (not_negative v) in Good (Some q) | None => Good None end.

Definition declared_in_of (H : header) (v : json) : read (list text * Policy.declared_in) :=
  let* ms := fields [k_context] [k_gamma; k_m; k_tau] v in
  let* ls := get (many string_of) k_context ms in
  let* gamma := maybe (k_gamma) ms in
  let* m := maybe (k_m) ms in
  let* tau := maybe k_tau ms in
  demand (match ms with [_] => false | _ => true end) "must have gamma, m or tau"
    (Good (ls, Policy.DeclaredIn (number_of (contexts_of H) ls) gamma m tau)).

(* The header is that of the induced law. *)
Definition read_declared (H : header) (v : json) : read Policy.declared :=
  let* ms := fields [] [k_gamma; k_m; k_tau; k_lipschitz; k_global_tau; k_max_drift; k_by_context] v in
  let* gamma := maybe (k_gamma) ms in
  let* m := maybe (k_m) ms in
  let* tau := maybe k_tau ms in
  let* l := maybe (k_lipschitz) ms in
  let* mean := maybe k_global_tau ms in
  let* drift := maybe k_max_drift ms in
  let* own := match found k_by_context ms with
    | Some v => let* es := at_place k_by_context (many (declared_in_of H) v) in
                demand (match es with [] => false | _ => true end) "must not be empty"
                  (demand (distinct (map (fun e => spelled_out e.1) es)) "lists a context twice" (Good (map snd es)))
    | None => Good [] end in
  demand (match drift with Some q => Fractions.at_most q one | None => true end) "has a drift of more than 1"
    (Good (Policy.Declared gamma m tau l mean drift own)).
