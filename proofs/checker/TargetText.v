(* Limits and the verdict on them as a certificate states them.

   This file only computes.  It follows "Targets and verdict" of docs/certificate.md and "Targets" of docs/certificate-samples.md.  A limit is judged
   by a figure of the table, or by the ends of an interval of the population; what is judged otherwise is not covered. *)

From Coq Require Import ZArith QArith List Ascii String.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditChecker Require Import Json Canonical Reading Statements TableText ClassText Document DrawnText Verdicts.
From FairauditKernel Require Import Fractions.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.

Definition over_units_text := of_string "mean over units".

Inductive unit_of_limit := In_log | In_ratio | In_difference.

Definition judgements : list (text * option judgement) :=
  [(of_string "within", Some Within); (of_string "exceeds", Some Exceeds); (of_string "inconclusive", Some Inconclusive);
   (of_string "depends", Some Depends); (of_string "changed", None)].

(* What there is to judge a ratio of the population by *)
Inductive basis :=
| No_sample      (* probabilities were not drawn from one *)
| No_interval    (* no interval is stated *)
| An_interval (of_units : bool) (besides : list part) (* whether it is about means over units, and what is stated with it *)
| Not_read.      (* what is not covered *)

Record target := Target {
  about_local : bool;
  limit_unit : unit_of_limit;
  target_said : text;
  target_parts : list part;    (* by itself *)
  verdict_of : option judgement;
  of_population_at : option Q; (* the confidence at which it is judged of the population, by what is known of that *)
  spends : bool                (* whether by an interval *)
}.

Definition under_objection (judged : text) : bool := existsb (fun o => ends_with o judged) objections.
Definition of_population (judged : text) : bool := begins_with together judged.
Definition is_elsewhere (judged : text) : bool := of_population judged || under_objection judged.

Fixpoint without (before t : text) : text := match before, t with _ :: before, _ :: t => without before t | _, _ => t end.

Definition confidence_in (judged : text) : read Q :=
  let* c := rational_of (Text (without together judged)) in demand (between_0_and_1 c) "must have a confidence between 0 and 1" (Good c).

Definition judged_in_log (q : quantity) (stated : option (option Q)) (limit : Q) (j : option judgement) : list part :=
  match stated, j with
  | Some r, Some Within => [About (Quantity_is q r); Log_at_most r limit true]
  | Some r, Some Exceeds => [About (Quantity_is q r); Log_at_most r limit false]
  | None, Some Inconclusive => [About (Figure_is q None)]
  | _, _ => [Fact false]
  end.

Definition judged_by (b : basis) (local is_signed : bool) (l : limit_on) (j : option judgement) : list part :=
  match b, j with
  | No_sample, _ | _, None => [Fact false]
  | No_interval, Some Inconclusive => [Fact (~~ is_signed)]
  | No_interval, _ => [Fact false]
  | An_interval _ ps, Some j => Fact (~~ is_signed) :: Judged_by_ends local l j :: ps
  | Not_read, _ => [Uncovered]
  end.

(* [ratio_of local] is the ratio that the metrics state; [differences]: whether they state differences; [basis_of local]: of the population *)
Definition read_target (ratio_of : bool -> option (option Q)) (basis_of : bool -> basis) (is_signed differences : bool) (i : Z) (v : json) : read target :=
  let* ms := fields [k_quantity; k_limit; k_unit; k_judged; k_verdict] [k_estimand; k_tips] v in
  let* local := get (choice [(k_local, true); (k_global, false)]) k_quantity ms in
  let* limit := get not_negative k_limit ms in
  let* u := get (choice [(k_log, In_log); (k_ratio, In_ratio); (of_string "difference", In_difference)]) k_unit ms in
  let* judged := get string_of k_judged ms in
  let* j := get (choice judgements) k_verdict ms in
  let text_at k := match found k ms with Some (Text t) => t | _ => [] end in
  let said := in_a_row [in_list "targets" i; of_string ": "; text_at k_quantity; of_string " "; text_at k_unit; of_string ", limit ";
                        text_at k_limit; of_string ": "; text_at k_verdict;
                        if is_elsewhere judged then of_string " for " ++ canonical (Text judged) else []] in
  let q := if local then Local else Global in
  let of_ratio := match u with In_difference => false | _ => true end in
  let b := if of_ratio then basis_of local else Not_read in
  let* at_ := match of_population judged && ~~ under_objection judged, b with
    | true, Not_read => Good (Some None)
    | true, _ => let* c := confidence_in judged in Good (Some (Some c))
    | false, _ => Good None
    end in
  let covered_here := match at_ with Some (Some _) => true | _ => false end in
  let plain := same judged (of_string "this table") in
  let of_units := match b with An_interval over_units _ => covered_here && over_units | _ => false end in
  let* _ := if has k_estimand ms then get (choice [(over_units_text, tt)]) k_estimand ms else Good tt in
  let parts :=
    match at_ with
    | Some _ => judged_by b local is_signed (Limit (match u with In_log => true | _ => false end) limit) j
    | None =>
        if is_elsewhere judged then [Uncovered]
        else if ~~ plain then [Fact false]
        else match u with
        | In_difference =>
            match differences, j with
            | true, Some j => [About (Target_is By_difference local limit j)]
            | _, _ => [Fact false]
            end
        | In_ratio => match j with Some j => [Fact (~~ is_signed); About (Target_is By_ratio local limit j)] | None => [Fact false] end
        | In_log => Fact (~~ is_signed) :: judged_in_log q (ratio_of local) limit j
        end
    end in
  demand (match u with In_ratio => at_most one limit | _ => true end) "the limit of a ratio must be at least 1"
    (demand (~~ (plain || covered_here) || Bool.eqb (has k_estimand ms) of_units && ~~ has k_tips ms) "has a key that goes with other targets, or lacks one"
      (Good (Target local u said parts j (match at_ with Some c => c | None => None end)
        (match b with An_interval _ _ => covered_here | _ => false end)))).

Definition same_unit (u w : unit_of_limit) : bool :=
  match u, w with In_log, In_log | In_ratio, In_ratio | In_difference, In_difference => true | _, _ => false end.
Definition same_target (s t : target) : bool := Bool.eqb (about_local s) (about_local t) && same_unit (limit_unit s) (limit_unit t).

Definition has_uncovered (ps : list part) : bool := existsb (fun p => if p is Uncovered then true else false) ps.

(* What all verdicts on the population rest on: they name one confidence, at which the intervals hold together. *)
Definition shared_parts (ts : list target) : list part :=
  match flat_map (fun t => match of_population_at t with Some c => [c] | None => [] end) ts with
  | [] => []
  | c :: cs =>
      [Fact (forallb (fun d => at_most c d && at_most d c) cs);
       if existsb (fun t => has_uncovered (target_parts t)) ts then Uncovered
       else Hold_together (map about_local (filter spends ts)) c]
  end.

Fixpoint targets_once (shared : list part) (before ts : list target) : list item :=
  match ts with
  | t :: rest =>
      Item (target_said t)
        (if existsb (same_target t) before then [Fact false]
         else target_parts t ++ match of_population_at t with Some _ => shared | None => [] end)
      :: targets_once shared (t :: before) rest
  | [] => []
  end.

(* The verdict follows from those of the targets, which have to be true, where all of these are covered. *)
Definition verdict_parts (ts : list target) (v : text) : read (list part) :=
  let* stated := if same v (of_string "none") then Good (Some None)
                 else let* j := chosen judgements v in Good (option_map Some j) in
  Good (if existsb (fun t => has_uncovered (target_parts t)) ts then [Uncovered]
        else match all_there (map verdict_of ts) [], stated with
        | Some js, Some v => About (Verdict_is js v) :: flat_map target_parts ts ++ shared_parts ts
        | _, _ => [Fact false]
        end).
