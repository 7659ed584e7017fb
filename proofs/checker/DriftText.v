(* What a certificate states of cells that move, as it stands: claims by T16 about this law, and targets that are judged within a drift.

   This file only computes.  It follows docs/certificate-objections.md. *)

From Coq Require Import ZArith QArith List Ascii String.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditChecker Require Import Json Reading Statements Table TableText ClassText Document TargetText.
From FairauditKernel Require Import Fractions.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.

Definition k_named_pair := of_string "pair".
Definition k_followed := of_string "followed".

Definition t16 := of_string "T16".
Definition this_law_drifting := of_string "this law, within the declared drift".

(* The drift that was declared: a total variation, also as it is written *)
Definition read_max_drift (subject : list (text * json)) : read (option (Q * text)) :=
  match found k_max_drift subject with
  | Some v =>
      at_place k_max_drift (let* q := not_negative v in let* t := string_of v in demand (at_most q one) "must be at most 1" (Good (Some (q, t))))
  | None => Good None
  end.

(* ---- Quantities: local or not, on the logarithm or not, by which move ---- *)

Definition radius_quantities : list (text * (bool * (bool * move))) :=
  [(of_string "local_ratio_radius", (true, (false, By_variation))); (of_string "local_log_radius", (true, (true, By_variation)));
   (of_string "global_ratio_radius", (false, (false, By_variation))); (of_string "global_log_radius", (false, (true, By_variation)));
   (of_string "local_ratio_factor", (true, (false, By_factor))); (of_string "local_log_factor", (true, (true, By_factor)));
   (of_string "global_ratio_factor", (false, (false, By_factor))); (of_string "global_log_factor", (false, (true, By_factor)))].

Definition standing : list (text * bool) := [(of_string "within", true); (of_string "exceeds", false)].

(* ---- Evidence ---- *)

Section Labels.
Variables (A : about) (H : header).

Definition place_of_pair (v : json) : read (option place) :=
  match v with
  | Null => Good None
  | _ =>
      let* ms := fields [k_context; k_higher; k_lower] [] v in
      let* x := get (option_of (many string_of)) k_context ms in
      let* h := get (many string_of) k_higher ms in
      let* l := get (many string_of) k_lower ms in
      Good (Some (Place nothing match x with Some x => number_of (contexts_of H) x | None => nothing end nothing
                        (number_of (groups_of H) h) (number_of (groups_of H) l)))
  end.

Fixpoint distinct_labels (ls : list (list text)) : bool :=
  match ls with l :: rest => ~~ existsb (same_labels l) rest && distinct_labels rest | [] => true end.

Definition followed_of (v : json) : read (list Z) :=
  let* ls := many (so_many (size (of_group (columns_of A))) string_of) v in
  demand (distinct_labels ls) "lists something twice" (Good (map (number_of (groups_of H)) ls)).

Definition drift_parts (drift : option Q) (q r s : text) (x : option Q) (e : json) : read (option (list part)) :=
  match in_table radius_quantities q with
  | Some (local, (log, k)) =>
      if same s this_law && (same r equality || same r lower_bound) then
        let* es := fields [k_named_pair; k_followed; k_limit; k_verdict] [] e in
        let* fs := get followed_of k_followed es in
        let* limit := get not_negative k_limit es in
        let* within := get (choice standing) k_verdict es in
        let* p := get place_of_pair k_named_pair es in
        let st := Stand k local within x (same r equality) p fs in
        if log then Good (Some [Stands_in_nats st limit])
        else demand (at_most one limit) "must be at least 1, being the limit of a ratio" (Good (Some [About (Stands st limit)]))
      else Good None
  | None =>
      if (same q q_local_ratio || same q q_global_ratio) && same s this_law_drifting && (same r upper_bound || same r lower_bound) then
        let* es := fields [k_named_pair; k_followed] [] e in
        let* fs := get followed_of k_followed es in
        let* p := get place_of_pair k_named_pair es in
        Good (Some (match drift with
                    | Some eta => [About (Ratio_under_drift (same q q_local_ratio) (same r upper_bound) eta x p fs)]
                    | None => [Fact false]
                    end))
      else Good None
  end.
End Labels.

(* ---- What claims have to list ---- *)

Definition same_range := of_string "an update brings no decision whose utility is outside the range that its cell has here".
Definition held_shares := of_string "the contexts of each group stay distributed as they are here".
Definition cell_drift (eta : text) : text :=
  of_string "in each cell the law of the decision moves by a total variation of at most " ++ eta ++ of_string " (declared)".

(* What was left out of the log is listed as well, where something was. *)
Definition lists_drift (needed : list text) (others_lost : bool) (listed : list text) : bool :=
  [&& forallb (among listed) needed, others_lost || forallb (among needed) listed & distinct listed].

Definition is_global (q : text) : bool := begins_with (of_string "global") q.

(* A claim by T16 about this law, if it lists all that it assumes and nothing else *)
Definition with_drift (A : about) (H : header) (drift : option (Q * text)) (others_lost : bool) (c : claim) (v : json) : read claim :=
  match proved_by c, key c with
  | [Uncovered], [q; r; b; s] =>
      if same b t16 then
        let* ms := object_of v in
        let* x := get extended_of k_value ms in
        let* ps := get (drift_parts A H (option_map fst drift) q r s x) k_evidence ms in
        Good (match ps with
          | Some ps =>
              let needed := same_range :: key_if (is_global q) held_shares
                            ++ match in_table radius_quantities q, drift with None, Some (_, eta) => [cell_drift eta] | _, _ => [] end in
              if lists_drift needed others_lost (assumed c) then Claim (key c) (said c) ps false (assumed c) else c
          | None => c
          end)
      else Good c
  | _, _ => Good c
  end.

(* ---- Targets that are judged of the table within the declared drift ---- *)

Definition table_drifting := of_string "this table, within the declared drift".

(* What is claimed of an end of the ratio within the drift; none where no claim is about it *)
Definition claimed_end (claims : list claim) (local worst : bool) : option (list part) :=
  option_map proved_by
    (find (fun c => same_labels (key c) [if local then q_local_ratio else q_global_ratio; if worst then upper_bound else lower_bound; t16;
                                         this_law_drifting]) claims).

(* The claim, and whether its value is within the limit; nothing where the claim is not covered *)
Definition judged_end (claims : list claim) (local worst : bool) (u : unit_of_limit) (limit : Q) (within : bool) : list part :=
  match claimed_end claims local worst with
  | Some [About (Ratio_under_drift l w eta v p fs)] =>
      About (Ratio_under_drift l w eta v p fs)
      :: [match u with
          | In_log => Log_at_most v limit within
          | _ => Fact (Bool.eqb within match v with Some v => at_most v limit | None => false end)
          end]
  | Some [Uncovered] => [Uncovered]
  | _ => [Fact false]
  end.

Definition judged_under_drift (claims : list claim) (v : json) (t : target) : target :=
  let ms := match v with Members ms => ms | _ => [] end in
  match target_parts t, found k_judged ms, get not_negative k_limit ms with
  | [Uncovered], Some (Text judged), Good limit =>
      if same judged table_drifting && ~~ (has k_estimand ms || has k_tips ms) then
        let end_ worst within := judged_end claims (about_local t) worst (limit_unit t) limit within in
        let parts :=
          match limit_unit t, verdict_of t with
          | In_difference, _ => [Uncovered]
          | _, Some Within => end_ true true
          | _, Some Exceeds => end_ false false
          | _, Some Depends => end_ true false ++ end_ false true
          | _, _ => [Uncovered]
          end in
        Target (about_local t) (limit_unit t) (target_said t) parts (verdict_of t) (of_population_at t) (spends t)
      else t
  | _, _, _ => t
  end.
