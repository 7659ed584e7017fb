(* A certificate as it stands: which table it is about, and what it states of it.

   This file only computes.  It follows docs/certificate.md.  Each statement of the certificate becomes an item, of parts that all
   have to be true.  What this reader does not know, but other checkers do, becomes a part that is not covered; what is not as
   the page describes it is malformed. *)

From Coq Require Import ZArith QArith List Ascii String.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require WorstCase.
From FairauditChecker Require Policy Drawn.
From FairauditChecker Require Import Json Canonical Reading Table Statements TableText ClassText Verdicts.
From FairauditKernel Require Import Fractions.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.

(* What is said of the interval of a ratio of the population: itself, or a claim with its scope about an end *)
Inductive of_interval := The_interval | Its_most (scope : text) (v : option Q) | Its_least (scope : text) (v : option Q)
| Its_frontier (scope : text) (v : option Q) (levels : list level). (* what a hidden factor has to be to bring down its lower end *)

Inductive part :=
| About (s : statement)                                        (* what is stated of the table *)
| Worst_case (local : bool) (v : option Q) (es : list WorstCase.evidence) (* of every utility of the class, the ratio is at most v *)
| Log_is (r : option Q) (low high : text)                      (* the two decimals enclose log r *)
| Log_at_most (r : option Q) (limit : Q) (b : bool)            (* whether log r is at most the limit *)
| Stands_in_nats (s : stand) (limit : Q)                        (* how far cells may move while a verdict on log r stands *)
| Of_policy (s : Policy.statement) (r : Policy.reason)          (* what is claimed of a policy behind filters, by a theorem *)
| Allowed (a : Policy.allowance)                                (* what was declared of a policy allows for what its table has *)
| Unfiltered (s : statement)                                   (* what is stated of the table of the policy without its filters *)
| Of_population (local : bool) (s : of_interval)                (* what is stated of the population that was drawn from *)
| Judged_by_ends (local : bool) (l : limit_on) (j : judgement)  (* the verdict on a limit, by the ends of the interval *)
| Hold_together (on : list bool) (c : Q)                        (* such verdicts, on local ratios or not, are together at this confidence *)
| Of_means (T : table) (s : statement)                          (* what is stated of the means over units, which are those of this table *)
| Fact (b : bool)                                              (* what the document alone decides: labels, digests *)
| Uncovered.

Record item := Item { label : text; parts : list part }.

Inductive subject :=
| A_table (T : table) (C : option (WorstCase.utilities * WorstCase.table)) (* with a class of utilities, if there is one *)
| A_policy (B : Policy.behind) (unfiltered : option table).                (* without its filters, where that makes sense *)

(* An interval as it is stated, with what proves it, and the scope of the claims about it; what is stated with it of the draws; what claims
   say of the range, if it is declared *)
Record drawn := Drawn { its_proof : Drawn.proof; its_scope : text; besides : list part; declared_range : option text }.

Record certificate := Certificate {
  its_subject : subject;
  local_interval : option drawn; (* of the ratio of the population, where what is stated of it is covered *)
  global_interval : option drawn;
  items : list item;
  unasked : bool (* a claim lists assumptions that it does not rest on *)
}.

(* Figures of a policy are those of the law that it induces with its filters. *)
Definition about_table (c : certificate) : table := match its_subject c with A_table T _ => T | A_policy B _ => Policy.induced_table B end.
Definition about_class (c : certificate) := match its_subject c with A_table _ C => C | A_policy _ _ => None end.
Definition about_policy (c : certificate) := match its_subject c with A_policy B _ => Some B | A_table _ _ => None end.
Definition interval_in (c : certificate) (local : bool) : option drawn := if local then local_interval c else global_interval c.
Definition without_filters (c : certificate) := match its_subject c with A_policy _ T => T | A_table _ _ => None end.

(* ---- Names ---- *)

Definition k_subject := of_string "subject".
Definition k_metrics := of_string "metrics".
Definition k_not_compared := of_string "not_compared".
Definition k_claims := of_string "claims".
Definition k_targets := of_string "targets".
Definition k_verdict := of_string "verdict".
Definition k_versions := of_string "versions".
Definition k_intervals := of_string "intervals".
Definition k_changed := of_string "changed".
Definition k_table := of_string "table".
Definition k_sha256 := of_string "sha256".
Definition k_cells := of_string "cells".
Definition k_header := of_string "header".
Definition k_class := of_string "class".
Definition k_positive := of_string "positive".
Definition k_privacy := of_string "privacy".
Definition k_declared := of_string "declared".
Definition k_spellings := of_string "spellings".
Definition k_undecided := of_string "undecided".
Definition k_unknown_shares := of_string "unknown_shares".
Definition k_max_drift := of_string "max_drift".
Definition k_depends := of_string "depends_on_group".
Definition k_burden := of_string "burden".
Definition k_ratio := of_string "ratio".
Definition k_log := of_string "log".
Definition k_value := of_string "value".
Definition k_witness := of_string "witness".
Definition k_expectations := of_string "expectations".
Definition k_probabilities := of_string "probabilities".
Definition k_rate := of_string "rate".
Definition k_rates := of_string "rates".
Definition k_reason := of_string "reason".
Definition k_relation := of_string "relation".
Definition k_scope := of_string "scope".
Definition k_by := of_string "by".
Definition k_assumptions := of_string "assumptions".
Definition k_evidence := of_string "evidence".
Definition k_supremum := of_string "supremum".
Definition k_limit := of_string "limit".
Definition k_unit := of_string "unit".
Definition k_judged := of_string "judged".
Definition k_estimand := of_string "estimand".
Definition k_tips := of_string "tips".
Definition k_frontier := of_string "frontier".
Definition k_to := of_string "to".
Definition k_balanced := of_string "balanced".

Definition named (before : string) (v : json) : text := of_string before ++ canonical v.
(* One text after the other, without recursion as deep as they are long *)
Definition in_a_row (ts : list text) : text := fold_right (fun t rest => rev_append (rev_append t []) rest) [] ts.
Definition in_list (name : string) (i : Z) : text := of_string name ++ of_string "[" ++ decimal i ++ of_string "]".

(* ---- Labels and their numbers ---- *)

(* The columns are those that the certificate names, the labels those of the table. *)
Section Labels.
Variables (A : about) (H : header).

Definition number_of (labels : list (list text)) (ls : list text) : Z := position (same_labels ls) labels.

(* {column: label}, one for each column *)
Definition labelled (names : list text) (v : json) : read (list text) :=
  let* ms := fields names [] v in each (fun k => get string_of k ms) names.

Definition group_of (v : json) : read Z :=
  let* ls := labelled (of_group (columns_of A)) v in Good (number_of (groups_of H) ls).
Definition context_of (v : json) : read Z :=
  let* ls := labelled (of_context (columns_of A)) v in Good (number_of (contexts_of H) ls).
Definition decision_of (v : json) : read Z := let* t := string_of v in Good (position (same t) (decisions_of H)).
Definition group_list_of (v : json) : read Z :=
  let* ls := so_many (size (of_group (columns_of A))) string_of v in Good (number_of (groups_of H) ls).
Definition context_list_of (v : json) : read Z :=
  let* ls := so_many (size (of_context (columns_of A))) string_of v in Good (number_of (contexts_of H) ls).

Definition two {A} (f : json -> read A) (v : json) : read (A * A) :=
  let* xs := so_many 2 f v in match xs with [a; b] => Good (a, b) | _ => bad "must have 2 entries" end.

(* ---- Metrics ---- *)

Definition rate_names : list (text * Z) :=
  [(of_string "true_positive_rate", true_positives); (of_string "false_positive_rate", false_positives)].

Record shape := Shape { is_ratio : bool; with_context : bool; with_decision : bool; with_decisions : bool; with_rate : bool; of_two : text }.

Definition shape_of (q : quantity) : shape :=
  match q with
  | Local => Shape true true false false false k_expectations
  | Global => Shape true false false false false k_expectations
  | Equalized_odds => Shape false true false true false []
  | Demographic_parity => Shape false false false true false []
  | Local_supremum => Shape true true true false false k_probabilities
  | Global_supremum => Shape true false true false false k_probabilities
  | Local_difference => Shape false true false false false k_expectations
  | Global_difference => Shape false false false false false k_expectations
  | Equal_opportunity o | Odds_given_truth o => Shape false (~~ o) false false true k_rates
  end.

Definition key_if (b : bool) (k : text) : list text := if b then [k] else [].

Definition if_there {A} (b : bool) (none : A) (r : read A) : read A := if b then r else Good none.

Definition witness_of (s : shape) (v : option Q) (w : json) : read figure :=
  let keys := key_if (with_context s) k_context ++ key_if (with_decision s) k_decision ++ key_if (with_decisions s) k_decisions
              ++ key_if (with_rate s) k_rate ++ [k_higher; k_lower] ++ match of_two s with [] => [] | k => [k] end in
  let* ms := fields keys [] w in
  let* x := if_there (with_context s) nothing (get context_of k_context ms) in
  let* u := if_there (with_decision s) nothing (get decision_of k_decision ms) in
  let* us := if_there (with_decisions s) [] (get (many decision_of) k_decisions ms) in
  let* r := if_there (with_rate s) nothing (get (choice rate_names) k_rate ms) in
  let* h := get group_of k_higher ms in
  let* l := get group_of k_lower ms in
  let* b := match of_two s with [] => Good None | k => let* b := get (two rational_of) k ms in Good (Some b) end in
  Good (Figure v (Place r x u h l) b us).

Definition decimal_form (t : text) : bool :=
  same t (of_string "0") || same t inf
  || match cut "." [] t with (above, Some below) =>
       match natural_read above with Some _ => of_length 12 below && forallb is_digit below | None => false end
     | _ => false end.

Definition log_text_of (v : json) : read text := let* t := string_of v in demand (decimal_form t) "must have twelve decimals" (Good t).

(* The parts that state a metric, and its ratio *)
Definition metric_of (q : quantity) (v : json) : read (list part * option (option Q)) :=
  match v with
  | Null => Good ([About (Figure_is q None)], None)
  | _ =>
      let s := shape_of q in
      if is_ratio s then
        let* ms := fields [k_ratio; k_log; k_witness] [] v in
        let* r := get extended_of k_ratio ms in
        let* l := get (two log_text_of) k_log ms in
        let* f := get (witness_of s r) k_witness ms in
        Good ([About (Figure_is q (Some f)); Log_is r l.1 l.2], Some r)
      else
        let* ms := fields [k_value; k_witness] [] v in
        let* r := get rational_of k_value ms in
        let* f := get (witness_of s (Some r)) k_witness ms in
        Good ([About (Figure_is q (Some f))], Some (Some r))
  end.

Definition rate_entry_of (overall : bool) (v : json) : read (Z * Z * Q) :=
  let* ms := fields (key_if (~~ overall) k_context ++ [k_group; k_rate]) [] v in
  let* x := if_there (~~ overall) nothing (get context_of k_context ms) in
  let* a := get group_of k_group ms in
  let* q := get rational_of k_rate ms in
  Good (x, a, q).

(* ---- What was not compared ---- *)

Definition reasons : list (text * Z) :=
  [(of_string "no decisions recorded", 0); (of_string "fewer than two groups", 1); (of_string "no population", 2);
   (of_string "a group is missing in a context and no population was given", 3);
   (of_string "no decisions with the positive true label", 4); (of_string "no decisions with another true label", 5)]%Z.

Definition rate_quantities : list (text * (Z * bool)) :=
  [(of_string "true_positive_rate", (true_positives, false)); (of_string "true_positive_rate_overall", (true_positives, true));
   (of_string "false_positive_rate", (false_positives, false)); (of_string "false_positive_rate_overall", (false_positives, true))].

Definition exactly (keys : list text) (ms : list (text * json)) : bool :=
  forallb (fun k => has k ms) keys && forallb (fun m => among keys m.1) ms.

(* An entry as the format knows them; nothing where it can only be false *)
Definition left_out_of (truth_known : bool) (v : json) : read (option left_out) :=
  let* ms := object_of v in
  let quantity_with keys := truth_known && exactly (k_quantity :: keys) ms in
  let shapes := [exactly [k_context; k_groups; k_reason] ms; exactly [k_context; k_reason] ms; exactly [k_groups; k_reason] ms;
                 exactly [k_quantity; k_reason] ms; quantity_with [k_context; k_groups; k_reason]; quantity_with [k_context; k_reason];
                 quantity_with [k_groups; k_reason]] in
  let* _ := demand (existsb id shapes) "has other keys than it may have" (Good tt) in
  let* why := get string_of k_reason ms in
  let* x := if_there (has k_context ms) nothing (get context_list_of k_context ms) in
  let* gs := if_there (has k_groups ms) [] (get (many group_list_of) k_groups ms) in
  let* q := if_there (has k_quantity ms) [] (get string_of k_quantity ms) in
  let reason := match chosen reasons why with Good n => n | Bad _ => missing end in
  let of_rate := match chosen rate_quantities q with Good r => Some r | Bad _ => None end in
  let wanted (r : Z) := (reason =? (if r =? true_positives then 4 else 5))%Z in
  let some_groups := match gs with [] => false | _ => true end in
  Good (match has k_quantity ms, has k_context ms, has k_groups ms with
  | false, true, true => if (reason =? 0)%Z && some_groups then Some (No_decisions x gs) else None
  | false, true, false => if (reason =? 1)%Z then Some (Alone x) else None
  | false, false, _ => if (reason =? 2)%Z && some_groups then Some (No_population gs) else None
  | true, with_x, with_gs =>
      match same q k_global && ~~ with_x && ~~ with_gs, of_rate with
      | true, _ => if (reason =? 3)%Z then Some No_means_missing else if (reason =? 1)%Z then Some No_means_alone else None
      | false, Some (r, overall) =>
          if Bool.eqb overall with_x then None
          else if with_gs then if wanted r && some_groups then Some (No_rate r x gs) else None
          else if (reason =? 1)%Z then Some (Rate_alone r x) else None
      | false, None => None
      end
  end).

Fixpoint all_there {A} (xs : list (option A)) (done : list A) : option (list A) :=
  match xs with Some x :: rest => all_there rest (x :: done) | None :: _ => None | [] => Some (rev_append done []) end.
End Labels.

(* ---- Metrics, by the columns that there are ---- *)

Definition plain_metrics : list (text * quantity) :=
  [(k_local, Local); (k_global, Global); (of_string "demographic_parity", Demographic_parity); (of_string "equalized_odds", Equalized_odds);
   (of_string "local_supremum", Local_supremum); (of_string "global_supremum", Global_supremum)].
Definition difference_metrics : list (text * quantity) :=
  [(of_string "local_difference", Local_difference); (of_string "global_difference", Global_difference)].
Definition truth_metrics (pooled : bool) : list (text * quantity) :=
  [(of_string "equal_opportunity", Equal_opportunity false); (of_string "equalized_odds_true_label", Odds_given_truth false)]
  ++ if pooled then
       [(of_string "equal_opportunity_overall", Equal_opportunity true); (of_string "equalized_odds_true_label_overall", Odds_given_truth true)]
     else [].
Definition rate_metrics (pooled : bool) : list (text * (Z * bool)) := filter (fun r => pooled || ~~ r.2.2) rate_quantities.

(* ---- Claims ---- *)

(* What makes a claim of this quantity, relation and method about this law true, besides its evidence *)
Inductive rule := Of_table (s : option Q -> statement) | Of_supremum (local : bool) (q : quantity) | Of_hidden (local : bool).

Definition by_enumeration : list (text * quantity) :=
  [(of_string "local_ratio", Local); (of_string "global_ratio", Global); (of_string "demographic_parity", Demographic_parity);
   (of_string "equalized_odds", Equalized_odds)] ++ difference_metrics ++ truth_metrics true.

Definition equality := of_string "=".
Definition upper_bound := of_string "<=".
Definition lower_bound := of_string ">=".
Definition this_law := of_string "this law".
Definition every_utility := of_string "every utility of the class".
Definition enumeration := of_string "enumeration".
Definition lp_dual := of_string "lp-dual".
Definition t5 := of_string "T5".
Definition t6 := of_string "T6".
Definition t7 := of_string "T7".
Definition t14 := of_string "T14".
Definition q_local_ratio := of_string "local_ratio".
Definition q_global_ratio := of_string "global_ratio".

Definition in_table {A} (choices : list (text * A)) (t : text) : option A := match chosen choices t with Good a => Some a | Bad _ => None end.

Definition rule_of (quantity relation by_ scope : text) : option rule :=
  if ~~ same scope this_law then None
  else if same relation equality && same by_ enumeration then
    option_map (fun q => Of_table (Quantity_is q)) (in_table by_enumeration quantity)
  else if same relation equality && same by_ t6 then
    option_map (fun l => Of_table (Supremum_is l))
      (in_table [(of_string "local_ratio_supremum", true); (of_string "global_ratio_supremum", false)] quantity)
  else if same relation upper_bound && same by_ t7 then
    option_map (fun lq : bool * Statements.quantity => Of_supremum lq.1 lq.2)
      (in_table [(of_string "equalized_odds", (true, Equalized_odds)); (of_string "demographic_parity", (false, Demographic_parity))] quantity)
  else if same relation lower_bound && same by_ t14 then
    option_map Of_hidden (in_table [(of_string "local_hidden_context", true); (of_string "global_hidden_context", false)] quantity)
  else if [&& same relation upper_bound, same by_ t5 & same quantity q_global_ratio] then Some (Of_table (Quantity_at_most By_T5 Global))
  else None.

(* Methods of which every claim is covered: what is not one of the above is no claim of the format. *)
Definition never_otherwise (by_ scope : text) : bool :=
  [|| same by_ enumeration, same by_ t6, same by_ t7, same by_ lp_dual | same by_ t5 && same scope this_law].

(* What it takes to bring a ratio down, for 1 and for targets *)
Definition no_more_than (most : Z) {A} (xs : list A) : read (list A) := demand (size xs <=? most)%Z "has too many entries" (Good xs).

Definition level_of (v : json) : read level :=
  let* ms := fields [k_to; k_balanced; k_pairs] [] v in
  let* ps := get (many (two not_negative)) k_pairs ms in
  let* ps := no_more_than 16 ps in
  let* t := get not_negative k_to ms in
  let* b := get extended_of k_balanced ms in
  Good (Level t b ps).

Definition frontier_of (v : json) : read (list level) :=
  let* vs := list_of v in
  let* vs := no_more_than 8 vs in
  demand (match vs with [] => false | _ => true end) "must have an entry" (each level_of vs).

Definition is_object (v : json) : read unit := let* _ := object_of v in Good tt.

Record claim := Claim { key : list text; said : text; proved_by : list part; is_covered : bool; assumed : list text }.

Definition read_claim (digest : text) (K : option WorstCase.utilities) (i : Z) (v : json) : read claim :=
  let* ms := fields [k_quantity; k_relation; k_value; k_scope; k_by; k_assumptions; k_evidence] [] v in
  let* q := get string_of k_quantity ms in
  let* r := get string_of k_relation ms in
  let* b := get string_of k_by ms in
  let* s := get string_of k_scope ms in
  let* x := get extended_of k_value ms in
  let* assumptions := get (many string_of) k_assumptions ms in
  let value := match found k_value ms with Some (Text t) => t | _ => [] end in
  let said := in_a_row [in_list "claims" i; of_string ": "; canonical (Text q); of_string " "; canonical (Text r); of_string " "; value;
                        of_string " by "; canonical (Text b)] in
  let evidence_of {A} (f : json -> read A) := get f k_evidence ms in
  let is_worst := [&& same b lp_dual, same r upper_bound & same s every_utility] in
  let* parts :=
    match rule_of q r b s with
    | Some (Of_table st) =>
        let* d := evidence_of (fun e => let* es := fields [k_table] [] e in get digest_of k_table es) in
        Good [About (st x); Fact (same d digest)]
    | Some (Of_supremum local quantity) =>
        let* R := evidence_of (fun e => let* es := fields [k_supremum] [] e in get extended_of k_supremum es) in
        Good [About (Quantity_at_most By_T7 quantity x); About (Supremum_is local R)]
    | Some (Of_hidden local) =>
        let* ls := evidence_of (fun e => let* es := fields [k_frontier] [] e in get frontier_of k_frontier es) in
        Good [About (Hidden_needs local x ls)]
    | None =>
        match is_worst, same q q_local_ratio, same q q_global_ratio with
        | true, true, _ => let* es := evidence_of (pairs_of true K) in Good [Worst_case true x es]
        | true, _, true => let* es := evidence_of (pairs_of false K) in Good [Worst_case false x es]
        | _, _, _ => let* _ := evidence_of is_object in Good [if never_otherwise b s then Fact false else Uncovered]
        end
    end in
  Good (Claim [q; r; b; s] said parts (match parts with [Uncovered] => false | _ => true end) assumptions).

(* A claim that occurs twice is false. *)
Fixpoint without_repeats (before : list (list text)) (cs : list claim) : list item :=
  match cs with
  | c :: rest =>
      Item (said c) (if existsb (same_labels (key c)) before then [Fact false] else proved_by c)
      :: without_repeats (key c :: before) rest
  | [] => []
  end.

(* ---- What statements are about, besides this table ---- *)

(* What follows a comma in a scope, or in what is judged, says what it takes into account. *)
Fixpoint begins_with (s t : text) : bool :=
  match s, t with [], _ => true | c :: s, d :: t => Ascii.eqb c d && begins_with s t | _, [] => false end.
Definition ends_with (s t : text) : bool := begins_with (rev_append s []) (rev_append t []).

Definition objections : list text :=
  [of_string ", whoever the unknown are"; of_string ", with the declared hidden context"; of_string ", within the declared drift";
   of_string ", whatever the undecided meant"].
