(* From JSON to a table: the header and the rows, as docs/certificate.md describes them.

   This file only computes.  What a table has to be beyond the types of its parts is demanded by [valid] of Table.v. *)

From Coq Require Import ZArith QArith List Ascii String.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Json Reading Table.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.

Definition k_kind := of_string "kind".
Definition k_columns := of_string "columns".
Definition k_population := of_string "population".
Definition k_decision := of_string "decision".
Definition k_group := of_string "group".
Definition k_context := of_string "context".
Definition k_truth := of_string "truth".
Definition k_format := of_string "format".
Definition k_decisions := of_string "decisions".
Definition k_groups := of_string "groups".
Definition k_contexts := of_string "contexts".
Definition k_utility := of_string "utility".
Definition k_salt := of_string "salt".
Definition k_profiles := of_string "profiles".
Definition k_unknown := of_string "unknown".
Definition k_preparation := of_string "preparation".
Definition k_evaluation := of_string "evaluation".
Definition k_truths := of_string "truths".
Definition k_weights := of_string "weights".
Definition k_mass := of_string "mass".
Definition k_local := of_string "local".
Definition k_global := of_string "global".

(* ---- What certificate and header agree on ---- *)

Inductive kind := Counts | Probabilities.

Record columns := Columns { of_decision : text; of_group : list text; of_context : list text; of_truth : option text }.
Record about := About { kind_of : kind; population_of : masses; columns_of : columns }.

Definition has_truth (ms : list (text * json)) : bool :=
  match found k_columns ms with Some (Members cs) => has k_truth cs | _ => false end.

Definition read_columns (v : json) : read columns :=
  let* ms := fields [k_decision; k_group; k_context] [k_truth] v in
  let* d := get string_of k_decision ms in
  let* gs := get (many string_of) k_group ms in
  let* xs := get (many string_of) k_context ms in
  let* t := match found k_truth ms with Some v => let* t := string_of v in Good (Some t) | None => Good None end in
  let names := d :: gs ++ xs ++ match t with Some t => [t] | None => [] end in
  demand (match gs with [] => false | _ => true end) "must name at least one column of groups"
    (demand (distinct names) "names a column twice" (Good (Columns d gs xs t))).

Definition read_about (ms : list (text * json)) : read about :=
  let* k := get (choice [(of_string "counts", Counts); (of_string "probabilities", Probabilities)]) k_kind ms in
  let* p := get (choice (match k with
    | Counts => [(of_string "counts", Counted)]
    | Probabilities => [(of_string "weights", Given); (of_string "equal", Alike)] end)) k_population ms in
  let* cs := get read_columns k_columns ms in
  demand (match k, of_truth cs with Probabilities, Some _ => false | _, _ => true end) "only counts have true labels" (Good (About k p cs)).

Definition same_about (a b : about) : bool * bool * bool :=
  (match kind_of a, kind_of b with Counts, Counts | Probabilities, Probabilities => true | _, _ => false end,
   match population_of a, population_of b with Counted, Counted | Given, Given | Alike, Alike => true | _, _ => false end,
   let c := columns_of a in let d := columns_of b in
   [&& same (of_decision c) (of_decision d), same_labels (of_group c) (of_group d), same_labels (of_context c) (of_context d)
     & match of_truth c, of_truth d with Some s, Some t => same s t | None, None => true | _, _ => false end]).

(* ---- The header ---- *)

Record header := Header {
  about_of : about;
  decisions_of : list text;
  groups_of : list (list text);
  contexts_of : list (list text);
  utility_of : option (list Q);
  truths_of : option (list text);
  has_unknown : bool
}.

Definition size {A} (xs : list A) : Z := Z.of_nat (List.length xs).

Definition read_header (v : json) : read header :=
  let* all := object_of v in
  let truths := if has_truth all then [k_truths] else [] in
  let* ms := fields ([k_format; k_kind; k_columns; k_population; k_decisions; k_groups; k_contexts; k_utility] ++ truths)
               [k_salt; k_profiles; k_unknown; k_preparation; k_evaluation] v in
  let* _ := get (choice [(of_string "fairaudit-table/1", tt)]) k_format ms in
  let* _ := match found k_salt ms with Some v => at_place k_salt (hexadecimal_of 32 true v) | None => Good [] end in
  let* a := read_about ms in
  let* ds := get distinct_strings k_decisions ms in
  let* gs := get (label_lists (size (of_group (columns_of a)))) k_groups ms in
  let* xs := get (label_lists (size (of_context (columns_of a)))) k_contexts ms in
  let* u := get (option_of (so_many (size ds) rational_of)) k_utility ms in
  let* ts := match found k_truths ms with Some v => let* ts := at_place k_truths (distinct_strings v) in Good (Some ts) | None => Good None end in
  let* unknown := match found k_unknown ms with
    | Some (Bool true) => demand (match kind_of a, ts with Counts, None => true | _, _ => false end) "decisions of unknown group do not go with that" (Good true)
    | Some _ => bad "must be true where it is stated"
    | None => Good false end in
  let* _ := match found k_profiles ms with
    | Some v => let* ps := fields [] [k_local; k_global] v in each digest_of (map snd ps)
    | None => Good [] end in
  let* _ := each (fun k => match found k ms with Some v => at_place k (digest_of v) | None => Good [] end) [k_preparation; k_evaluation] in
  Good (Header a ds gs xs u ts unknown).

(* ---- The rows ---- *)

Section Rows.
Variable H : header.

Definition row_keys : list text :=
  [k_context; k_group; k_weights] ++ match population_of (about_of H) with Given => [k_mass] | _ => [] end
  ++ match utility_of H with None => [k_utility] | Some _ => [] end ++ match truths_of H with Some _ => [k_truth] | None => [] end.

Let n : Z := size (decisions_of H).
Let contexts_there : Z := size (contexts_of H).
Let groups_there : Z := size (groups_of H).

Definition read_cell (keys : list text) (v : json) : read cell :=
  let* ms := fields keys [] v in
  let* x := get (below contexts_there) k_context ms in
  let* a := get (below groups_there) k_group ms in
  let* ws := get (so_many n not_negative) k_weights ms in
  let* gs := match utility_of H with None => get (so_many n (option_of rational_of)) k_utility ms | Some _ => Good [] end in
  let* m := match population_of (about_of H) with Given => get not_negative k_mass ms | _ => Good Fractions.zero end in
  let* ts := match truths_of H with Some ts => get (so_many (size ts) (so_many n not_negative)) k_truth ms | None => Good [] end in
  Good (Cell x a ws gs m ts).

(* Lines about decisions of unknown group, which follow the cells, are left to others. *)
Definition is_unknown (v : json) : bool := match v with Members ms => has k_unknown ms | _ => false end.

Fixpoint cells_before (rows : list json) (done : list json) : list json * list json :=
  match rows with
  | v :: rest => if has_unknown H && is_unknown v then (rev_append done [], rows) else cells_before rest (v :: done)
  | [] => (rev_append done [], [])
  end.

Definition read_cells (rows : list json) : read (list cell) :=
  let (before, after) := cells_before rows [] in
  demand (forallb is_unknown after) "has a cell after the decisions of unknown group"
    (demand (if has_unknown H then match after with [] => false | _ => true end else true) "has no decisions of unknown group"
      (let keys := row_keys in each (read_cell keys) before)).
End Rows.

(* ---- The positive decisions and the positive true label ---- *)

Definition read_positive (H : header) (v : json) : read (option truth) :=
  let* ms := fields [k_decision; k_truth] [] v in
  let* ds := get distinct_strings k_decision ms in
  let* t := get string_of k_truth ms in
  match truths_of H with
  | None => Good None
  | Some ts =>
      let us := map (fun d => position (same d) (decisions_of H)) ds in
      demand (forallb (fun p => (p.1 <? p.2)%Z) (combine us (tl us))) "positive decisions are not in the order of the decisions"
        (Good (Some (Truth us (position (same t) ts) (size ts) (match of_context (columns_of (about_of H)) with [] => false | _ => true end))))
  end.

Definition table_of (H : header) (K : option truth) (cs : list cell) : table :=
  Table (size (contexts_of H)) (size (groups_of H)) (size (decisions_of H)) (population_of (about_of H)) (utility_of H) K cs.

(* ---- Labels that evidently are no spellings of one another ---- *)

Definition white (c : ascii) : bool := blank c || Ascii.eqb c "011" || Ascii.eqb c "012".
Definition lower (c : ascii) : ascii :=
  match c with
  | Ascii b0 b1 b2 b3 b4 false true false => if Ascii.leb "A" c && Ascii.leb c "Z" then Ascii b0 b1 b2 b3 b4 true true false else c
  | _ => c
  end.

(* What a label of plain ASCII folds to, but for its white space; nothing for other labels *)
Fixpoint folded_onto (done s : text) : option text :=
  match s with
  | c :: rest => if white c then folded_onto done rest else if Ascii.leb "!" c && Ascii.leb c "~" then folded_onto (lower c :: done) rest else None
  | [] => Some (rev_append done [])
  end.

(* Numbers are the same in several spellings, but not those of digits alone, and what has no digit is none. *)
Definition of_numbers : text := list_ascii_of_string "0123456789.+-e".
Definition never_a_second_spelling (k : text) : bool :=
  existsb (fun c => ~~ existsb (Ascii.eqb c) of_numbers) k || ~~ existsb is_digit k || match natural_read k with Some _ => true | None => false end.

(* in reverse *)
Fixpoint without_equal_neighbours (done ts : list text) : list text :=
  match ts with
  | s :: ((t :: _) as rest) => without_equal_neighbours (if same s t then done else s :: done) rest
  | _ => rev_append ts done
  end.

Definition evidently_different (labels : list text) : bool :=
  match without_equal_neighbours [] (Sorting.sort labels) with
  | [] | [_] => true
  | ls =>
      let ks := map (folded_onto []) ls in
      forallb (fun k => match k with Some k => never_a_second_spelling k | None => false end) ks
      && distinct (flat_map (fun k => match k with Some k => [k] | None => [] end) ks)
  end.

Fixpoint by_column {A} (names : list A) (ls : list (list text)) : list (list text) :=
  match names with _ :: rest => map (hd []) ls :: by_column rest (map (@tl text) ls) | [] => [] end.

Definition no_spellings (H : header) : bool :=
  let cs := columns_of (about_of H) in
  forallb evidently_different
    (decisions_of H :: by_column (of_group cs) (groups_of H) ++ by_column (of_context cs) (contexts_of H)
     ++ match truths_of H with Some ts => [ts] | None => [] end).
