(* A whole certificate: from the bytes of its file, and of that of its table, to an outcome for each of its statements.

   This file only computes; CertificateSound.v says what an outcome means and proves it. *)

From Coq Require Import ZArith QArith List Ascii String.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require WorstCase.
From FairauditChecker Require Import Json Canonical Reading Table Statements Checker Nats TableText ClassText Document Drawn DrawnText BetsText Verdicts TargetText DriftText PolicyText PolicyDocument.
From FairauditChecker Require Policy PolicyChecker PolicyShown.
From FairauditKernel Require Import Fractions.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.

Section Reading.
Variable sha256 : text -> text. (* a digest in hexadecimal digits; nothing is assumed of it *)

(* ---- The table: embedded, or in a file ---- *)

Fixpoint lines_from (done : list text) (line : text) (s : text) : read (list text) :=
  match s with
  | c :: rest => if Ascii.eqb c "010" then lines_from (rev_append line [] :: done) [] rest else lines_from done (c :: line) rest
  | [] => match line with [] => Good (rev_append done []) | _ => bad "has a last line that does not end" end
  end.

Definition parsed (s : text) : read json := match parse s with Some v => Good v | None => bad "is not JSON as the format has it" end.

(* The values of the lines, of which the file has to be the canonical text *)
Definition table_file_of (s : text) : read (list json) :=
  let* ls := lines_from [] [] s in
  let* vs := each parsed ls in
  demand (same (table_text vs) s) "the table is not the canonical text of its values" (Good vs).

(* The lines of the table, whether the certificate holds them, and their digest; nothing where no table is there *)
Definition table_lines (given : list (text * json)) (file : option text) : read (option (list json * bool * text)) :=
  match has k_header given || has k_rows given with
  | true =>
      let* h := get (fun v => Good v) k_header given in
      let* rows := get list_of k_rows given in
      Good (Some (h :: rows, true, sha256 (table_text (h :: rows))))
  | false =>
      match file with
      | None => Good None
      | Some s => let* vs := table_file_of s in Good (Some (vs, false, sha256 s))
      end
  end.

(* ---- The certificate ---- *)

Definition constant_items (v : json) : read (list item) :=
  let* ms := fields [k_gamma; k_m; k_tau; k_lipschitz; k_depends] [k_burden] v in
  let* gamma := get rational_of k_gamma ms in
  let* m := get rational_of k_m ms in
  let* tau := get (option_of rational_of) k_tau ms in
  let* l := get rational_of k_lipschitz ms in
  let* d := get boolean_of k_depends ms in
  let stated k s := Item (of_string "subject.utility." ++ k) [About s] in
  demand (match found k_burden ms with Some (Bool true) | None => true | _ => false end) "burden must be true where it is stated"
    (Good [stated k_gamma (Gamma_is gamma); stated k_m (Least_is m); stated k_tau (Tau_is tau); stated k_lipschitz (Lipschitz_is l);
           stated k_depends (Depends_on_group_is d)]).

Definition metric_name (k : text) : text := of_string "metrics." ++ k.

Definition uncovered_items (names : list text) (ms : list (text * json)) (before : string) : list item :=
  map (fun k => Item (of_string before ++ k) [Uncovered]) (filter (fun k => has k ms) names).

Definition strings_of (v : json) : read unit :=
  let* ms := object_of v in
  let* _ := each (fun m => string_of (Text m.1)) ms in
  let* _ := each (fun m => string_of m.2) ms in Good tt.

Definition top_keys : list text := [k_format; k_subject; k_metrics; k_not_compared; k_claims; k_targets; k_verdict; k_versions].

Definition numbered_each {A} (f : Z -> json -> read A) (vs : list json) : read (list A) := each (fun iv => f iv.1 iv.2) (WorstCase.numbered 0 vs).

(* Of a policy behind filters that is too large for this reader: its statements, none of which is covered *)
Definition policy_items (top : list (text * json)) : read (list item) :=
  let* claims := get list_of k_claims top in
  let* cs := numbered_each (read_claim [] None) claims in
  Good ([Item k_subject [Uncovered]; Item k_metrics [Uncovered]; Item k_not_compared [Uncovered]]
        ++ map (fun c => Item (said c) [Uncovered]) cs ++ [Item k_targets [Uncovered]; Item k_verdict [Uncovered]]).

Definition extra_keys : list text := [k_spellings; k_undecided; k_unknown_shares; k_max_drift].

(* What the subject says of the log before it was counted is what the header of the table names by its digest.  No more of it is covered. *)
Definition digest_in (header : list (text * json)) (k : text) : option text :=
  match found k header with Some (Text d) => Some d | _ => None end.

Definition named_by_table (header subject : list (text * json)) (k : text) : read (list item) :=
  let its ps := Good [Item (of_string "subject." ++ k) ps] in
  match found k subject, digest_in header k with
  | Some v, Some d => its [Fact (same d (sha256 (table_text [v]))); Uncovered]
  | Some _, None => at_place k (bad "is not named by its digest in the header of the table")
  | None, Some _ => its [Fact false]
  | None, None => Good []
  end.

Definition log_items (first : json) (subject : list (text * json)) : read (list item) :=
  let* header := object_of first in
  let* before := named_by_table header subject k_preparation in
  let* read_as := named_by_table header subject k_evaluation in Good (before ++ read_as).

Definition read_table_certificate (top subject : list (text * json)) (file : option text) : read (option certificate) :=
  let* a := read_about subject in
  let* given := get (fields [k_sha256; k_cells] [k_header; k_rows]) k_table subject in
  let* stated_digest := get digest_of k_sha256 given in
  let* entries := get integer_of k_cells given in
  let* there := table_lines given file in
  match there with
  | None => Good None
  | Some ([], _, _) => bad "the table is empty"
  | Some (first :: rows, embedded, digest) =>
    let* H := at_place k_header (read_header first) in
    let* K := match found k_positive subject with Some v => at_place k_positive (read_positive H v) | None => Good None end in
    let* cs := at_place k_rows (read_cells H rows) in
    let* of_log := log_items first subject in
    let T := table_of H K cs in
    let* cl := match found k_class subject with Some v => let* s := at_place k_class (read_class H v) in Good (Some s) | None => Good None end in
    let* _ := match cl with Some s => at_place k_class (fits H s cs) | None => Good tt end in
    let C := match cl with Some s => Some (class_of s, kernel_table H s cs) | None => None end in
    let pooled := match of_context (columns_of a) with [] => false | _ => true end in
    let with_truth := match of_truth (columns_of a) with Some _ => true | None => false end in
    (* metrics *)
    let* all := get object_of k_metrics top in
    let differences := existsb (fun m => has m.1 all) difference_metrics in
    let names := plain_metrics ++ (if differences then difference_metrics else []) ++ (if with_truth then truth_metrics pooled else []) in
    let rates := if with_truth then rate_metrics pooled else [] in
    let* ms := get (fields (map fst names ++ map fst rates) []) k_metrics top in
    let* metrics := each (fun n => let* m := get (metric_of a H n.2) n.1 ms in Good (n.1, m)) names in
    let* rate_items := each (fun n =>
      let* ps := match found n.1 ms with
        | Some Null => Good [Fact (~~ embedded)]
        | Some v => let* es := at_place n.1 (many (rate_entry_of a H n.2.2) v) in
                    Good (if embedded then [About (Rates_are n.2.1 n.2.2 es)] else [Fact false])
        | None => Good [Fact false] end in
      Good (metric_name n.1, ps)) rates in
    let ratio_of (local : bool) := match in_table metrics (if local then k_local else k_global) with Some (_, r) => r | None => None end in
    let* entries_left := get (many (left_out_of a H with_truth)) k_not_compared top in
    (* claims and targets *)
    let special := [|| has_unknown H, has k_undecided subject | has k_changed top] in
    let stated_intervals := match found k_intervals top with Some (Members ms) => ms | _ => [] end in
    let covered := ~~ (special || has k_preparation subject || has k_evaluation subject) in
    let is_named v := match profiles_digest first with Some d => same d (sha256 (table_text [v])) | None => false end in
    let of_local := if covered then drawn_with_units is_named a H T true stated_intervals else None in
    let of_global := if covered then drawn_with_units is_named a H T false stated_intervals else None in
    let interval_of (local : bool) := if local then of_local else of_global in
    let gamma := match found k_utility subject with
      | Some (Members us) => match found k_gamma us with Some (Text t) => t | _ => [] end
      | _ => [] end in
    let* drift := read_max_drift subject in
    let others_lost := has k_preparation subject || has k_evaluation subject in
    let* claims := get (fun v => let* vs := list_of v in
      numbered_each (fun i v => let* c := read_claim digest (option_map class_of cl) i v in let* c := with_population H gamma interval_of c v in
                                with_drift a H drift others_lost c v) vs) k_claims top in
    let basis_of (local : bool) :=
      if ~~ covered then Not_read
      else match kind_of (about_of H) with
      | Probabilities => No_sample
      | Counts => if ~~ has (if local then k_local else k_global) stated_intervals then No_interval
                  else match interval_of local with
                       | Some i => if existsb (is_about local) claims then An_interval (over_units (its_proof i)) (besides i) else Not_read
                       | None => Not_read
                       end
      end in
    let* ts := get (fun v => let* vs := list_of v in
      numbered_each (fun i v => let* t := read_target ratio_of basis_of (signed T) differences i v in Good (judged_under_drift claims v t)) vs) k_targets top in
    let* verdict := get string_of k_verdict top in
    let* last := verdict_parts ts verdict in
    let* constants := get constant_items k_utility subject in
    let '(same_kind, same_population, same_columns) := same_about a (about_of H) in
    let judged_otherwise ps := if special then [Uncovered] else ps in
    let by_names ps := if same_columns then ps else Fact false :: ps in (* what names columns is of the columns of the table *)
    let its :=
      [Item (of_string "subject.table.sha256") [Fact (same stated_digest digest)];
       Item (of_string "subject.table.cells") [About (Entries_are entries)];
       Item (of_string "subject.kind") [Fact same_kind];
       Item (of_string "subject.population") [Fact same_population];
       Item (of_string "subject.columns") [Fact same_columns]]
      ++ (match file with Some s => if embedded then [Item (of_string "the table file") [Fact (same s (table_text (first :: rows)))]] else [] | None => [] end)
      ++ constants ++ of_log
      ++ uncovered_items (filter (fun k => ~~ same k k_max_drift) extra_keys) subject "subject."
      ++ (if has k_spellings subject || no_spellings H then [] else [Item (of_string "subject.spellings") [Uncovered]])
      ++ interval_items interval_of claims (found k_intervals top) ++ uncovered_items [k_changed] top ""
      ++ (match cl with Some _ => [Item (of_string "the utility is in subject.class") [Uncovered]] | None => [] end)
      ++ map (fun n => Item (metric_name n.1) (by_names n.2.1)) metrics
      ++ map (fun n => Item n.1 (by_names n.2)) rate_items
      ++ [Item k_not_compared [match all_there entries_left [] with Some es => About (Not_compared_is es) | None => Fact false end]]
      ++ without_repeats [] claims
      ++ map (fun t => Item (label t) (judged_otherwise (parts t))) (targets_once (shared_parts ts) [] ts)
      ++ [Item k_verdict (judged_otherwise last)] in
    demand (match cl with Some _ => ~~ has k_intervals top | None => true end) "has intervals, which do not go with a class of utilities"
    (demand (match kind_of a with Probabilities => ~~ has k_intervals top | Counts => true end) "has intervals, which are not for probabilities"
    (demand (~~ signed T || (differences && match cl with Some _ => false | None => true end)) "has utilities below 0, of which differences have to be stated"
    (Good (Some (Certificate (A_table T C) (interval_of true) (interval_of false) its (existsb (fun c => is_covered c && match assumed c with [] => false | _ => true end) claims
                                      && ~~ (has k_preparation subject || has k_evaluation subject)))))))
  end.

(* What is stated; of a policy that is too large for this reader, nothing is read. *)
Inductive stated := Read (c : certificate) | Too_large (its : list item) | Table_needed.

Definition unfiltered_item (a : about) (H : header) (there : bool) (v : json) : read item :=
  let* ps := match v with
    | Null => Good [Fact (~~ there)]
    | _ =>
        let* ms := fields [k_local; k_global] [] v in
        let* l := get (metric_of a H Local) k_local ms in
        let* g := get (metric_of a H Global) k_global ms in
        Good (if there then map (fun p => match p with About s => Unfiltered s | _ => p end) (l.1 ++ g.1) else [Fact false])
    end in
  Good (Item (metric_name k_unfiltered) ps).

Definition read_policy_certificate (top subject : list (text * json)) (file : option text) : read stated :=
  let uncovered := let* its := policy_items top in Good (Too_large its) in
  let* a := read_about (as_probabilities subject) in
  let* given := get (fields [k_sha256; k_cells] [k_header; k_rows]) k_table subject in
  let* stated_digest := get digest_of k_sha256 given in
  let* entries := get integer_of k_cells given in
  let* there := table_lines given file in
  match there with
  | None => Good Table_needed
  | Some ([], _, _) => bad "the table is empty"
  | Some (first :: rows, embedded, digest) =>
    let* hs := object_of first in
    if ~~ says_policy hs then uncovered else
    let* H := at_place k_header (read_header (Members (as_probabilities (filter (fun m => ~~ same m.1 k_filters) hs)))) in
    let* F := get (read_filters (about_of H)) k_filters hs in
    if too_large H F then uncovered else
    let* of_log := log_items first subject in
    let HT := true_header H F in
    let (policy_rows, cell_rows) := rows_before rows [] in
    let* rs := at_place k_rows (each (read_row H) policy_rows) in
    let* cells := at_place k_rows (read_true_cells H F cell_rows) in
    let lacks := bad "the table lacks a row of the policy for what the filters can release" in
    let* laws :=
      if (how_many (released_context_lists H F) * how_many (released_group_lists F) <=? size rs)%Z then
        match laws_of H rs (joined (released_context_lists H F)) (joined (released_group_lists F)) with Some ls => Good ls | None => lacks end
      else lacks in
    let* D := get (read_declared HT) k_declared subject in
    let B := behind_of H F D laws cells in
    let U := unfiltered_table H F B rs in
    let* privacy := get (read_privacy B) k_privacy subject in
    (* metrics *)
    let* all := get object_of k_metrics top in
    let differences := existsb (fun m => has m.1 all) difference_metrics in
    let names := plain_metrics ++ (if differences then difference_metrics else []) in
    let* ms := get (fields (k_unfiltered :: map fst names) []) k_metrics top in
    let* metrics := each (fun n => let* m := get (metric_of a HT n.2) n.1 ms in Good (n.1, m)) names in
    let* unfiltered := get (unfiltered_item a HT (match U with Some _ => true | None => false end)) k_unfiltered ms in
    let ratio_of (local : bool) := match in_table metrics (if local then k_local else k_global) with Some (_, r) => r | None => None end in
    let* entries_left := get (many (left_out_of a HT false)) k_not_compared top in
    (* claims and targets *)
    let* claims := get (fun v => let* vs := list_of v in numbered_each (read_policy_claim HT ratio_of digest) vs) k_claims top in
    let* ts := get (fun v => let* vs := list_of v in numbered_each (read_target ratio_of (fun _ => Not_read) false differences) vs) k_targets top in
    let* verdict := get string_of k_verdict top in
    let special := has k_undecided subject || has k_changed top in
    let* last := verdict_parts ts verdict in
    let* constants := get constant_items k_utility subject in
    let* declared := get (declared_items D) k_utility subject in
    let* ds := get object_of k_declared subject in
    let* us := get object_of k_utility subject in
    let '(same_kind, same_population, same_columns) := same_about a (about_of H) in
    let judged_otherwise ps := if special then [Uncovered] else ps in
    let by_names ps := if same_columns then ps else Fact false :: ps in
    let its :=
      [Item (of_string "subject.table.sha256") [Fact (same stated_digest digest)];
       Item (of_string "subject.table.cells") [Fact (entries =? size rs * size (decisions_of H))%Z];
       Item (of_string "subject.kind") [Fact same_kind];
       Item (of_string "subject.population") [Fact same_population];
       Item (of_string "subject.columns") [Fact same_columns]]
      ++ (match file with Some s => if embedded then [Item (of_string "the table file") [Fact (same s (table_text (first :: rows)))]] else [] | None => [] end)
      ++ constants ++ of_log ++ privacy ++ declared
      ++ uncovered_items extra_keys subject "subject."
      ++ (if has k_spellings subject || (no_spellings H && no_spellings HT) then [] else [Item (of_string "subject.spellings") [Uncovered]])
      ++ uncovered_items [k_intervals; k_changed] top ""
      ++ map (fun n => Item (metric_name n.1) (by_names n.2.1)) metrics
      ++ [Item (label unfiltered) (by_names (parts unfiltered))]
      ++ [Item k_not_compared [match all_there entries_left [] with Some es => About (Not_compared_is es) | None => Fact false end]]
      ++ without_repeats [] claims
      ++ (if (match claims with [] => false | _ => true end) && forallb (lists_what_is_needed ds us (Zpos (released_times F))) claims then []
          else [Item (of_string "the assumptions of the claims") [Uncovered]])
      ++ map (fun t => Item (label t) (judged_otherwise (parts t))) (targets_once (shared_parts ts) [] ts)
      ++ [Item k_verdict (judged_otherwise last)] in
    demand (rows_in_order rs) "the rows of the policy are not in order"
      (demand (forallb drawn rs || forallb (fun r => ~~ drawn r) rs) "the table gives draws for some rows of the policy only"
        (Good (Read (Certificate (A_policy B U) None None its false))))
  end.

Definition read_certificate (v : json) (file : option text) : read stated :=
  let* top := fields top_keys [k_intervals; k_changed] v in
  let* _ := get (choice [(of_string "fairaudit-certificate/1", tt)]) k_format top in
  let* _ := get strings_of k_versions top in
  let* all := get object_of k_subject top in
  let of_policy := match found k_kind all with Some (Text t) => same t (of_string "policy") | _ => false end in
  let keys := [k_kind; k_columns; k_population; k_table; k_utility] ++ (if of_policy then [k_privacy; k_declared] else [])
              ++ (if has_truth all then [k_positive] else []) in
  let optional := [k_preparation; k_spellings; k_undecided]
                  ++ (if of_policy then [] else [k_class; k_unknown_shares; k_max_drift; k_evaluation]) in
  let* subject := get (fields keys optional) k_subject top in
  if of_policy then read_policy_certificate top subject file
  else let* c := read_table_certificate top subject file in Good (match c with Some c => Read c | None => Table_needed end).

(* ---- Outcomes ---- *)

Definition decided (b : option bool) : outcome := match b with Some true => True_ | Some false => False_ | None => Not_covered end.

(* What is known of a certificate, found out once: the facts of its table, those of the policy without filters, and its intervals *)
Record computed := Computed { of_table : facts; of_unfiltered : option facts; of_local : option bool; of_global : option bool }.

(* Whether the draws that the table counts prove an interval *)
Definition proved_by_draws (c : certificate) (local : bool) : option bool :=
  match interval_in c local with Some i => judged_by_draws (about_table c) local (its_proof i) | None => None end.

Definition worked_out (c : certificate) : computed :=
  Computed (facts_of (about_table c)) (option_map facts_of (without_filters c)) (proved_by_draws c true) (proved_by_draws c false).

Definition outcome_of_part (c : certificate) (D : computed) (p : part) : outcome :=
  match p with
  | About s => outcome_of (of_table D) s
  | Worst_case local v es =>
      match about_class c with Some (K, T) => decided (Some (WorstCase.claim_true K T local v es)) | None => False_ end
  | Log_is r low high => decided (enclosure_is r low high)
  | Log_at_most r limit b => decided (option_map (Bool.eqb b) (log_at_most r limit))
  | Stands_in_nats s limit => decided (stands_in_nats (of_table D) s limit)
  | Of_policy s r => match about_policy c with Some B => decided (PolicyChecker.policy_claim B s r) | None => False_ end
  | Allowed a => match about_policy c with Some B => decided (Some (PolicyShown.allowed B a)) | None => False_ end
  | Unfiltered s => match of_unfiltered D with Some D => outcome_of D s | None => False_ end
  | Of_population local s =>
      match interval_in c local with
      | Some i => if about_interval i s then decided (if local then of_local D else of_global D) else False_
      | None => Not_covered
      end
  | Judged_by_ends local l j =>
      match interval_in c local with
      | Some i => match decided (if local then of_local D else of_global D) with True_ => decided (judged_by_interval (its_proof i) l j) | o => o end
      | None => Not_covered
      end
  | Hold_together on q =>
      let known local o := match o, limits_on local on with None, S _ => false | _, _ => true end in
      if known true (of_local D) && known false (of_global D)
      then decided (Some (hold_together (option_map its_proof (local_interval c)) (option_map its_proof (global_interval c)) on q))
      else Not_covered
  | Of_means T s => if valid T then outcome_of (facts_of T) s else False_
  | Fact b => decided (Some b)
  | Uncovered => Not_covered
  end.

(* All of it: false where some part is, else not covered where some part is not *)
Definition both (a b : outcome) : outcome :=
  match a, b with
  | False_, _ | _, False_ => False_
  | Not_covered, _ | _, Not_covered => Not_covered
  | True_, True_ => True_
  end.

(* An item without parts states nothing that could be true. *)
Definition outcome_of_item (c : certificate) (D : computed) (i : item) : text * outcome :=
  (label i, match parts i with [] => Not_covered | ps => fold_left (fun o p => both o (outcome_of_part c D p)) ps True_ end).

Definition is_false (o : outcome) : bool := match o with False_ => true | _ => false end.

Inductive report := Outcomes (os : list (text * outcome)) | Malformed (why : text) | No_table.

(* What the format demands of the policy, if it is one; its table is demanded to be valid as well *)
Definition well_formed (c : certificate) : bool :=
  match its_subject c with
  | A_table _ _ => true
  | A_policy B U => Policy.valid B && match U with Some T => valid T | None => true end
  end.

Definition judged (s : stated) : report :=
  match s with
  | Too_large its => Outcomes (map (fun i => (label i, Not_covered)) its)
  | Table_needed => No_table
  | Read c =>
      let T := about_table c in
      if well_formed c && valid T then
        let D := worked_out c in
        let os := map (outcome_of_item c D) (items c) in
        if unasked c && ~~ existsb (fun o => is_false o.2) os then Malformed (of_string "a claim lists assumptions that it does not rest on")
        else Outcomes os
      else Malformed (of_string "the table is not as the format demands")
  end.

(* From the bytes of a certificate, and of the file of its table if there is one *)
Definition verified (file : text) (table_file : option text) : report :=
  match (let* v := parsed file in read_certificate v table_file) with
  | Good s => judged s
  | Bad why => Malformed why
  end.
End Reading.
