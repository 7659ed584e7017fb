(* The greatest ratio over the policies near the one of the certificate: which claims are accepted.

   This file only computes; PolicyNearSound.v proves it right.  For all that is released, mass eta leaves the decisions with the least
   p - V q for one with the greatest.  That no policy near gains more is proved by a threshold for each of them; a policy that
   attains the value is found, written out and looked at. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Policy Likelihoods PolicyClaims PolicySites PolicyShown PolicyFloors.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

Definition least_z (xs : list Z) : Z := match xs with x :: rest => fold_right lesser_z x rest | [] => 0 end.
Definition sum_z (xs : list Z) : Z := fold_right Z.add 0 xs.

(* The greatest sum of masses t times values c when mass eta = moved/den may move, times den; t/unit is a law *)
Definition bound_by (moved den : Z) (cts : list (Z * Z)) (highest threshold : Z) : Z :=
  moved * (highest - threshold) + den * sum_z (map (fun ct => ct.2 * Z.max ct.1 threshold) cts).
Definition greatest_near (moved den : Z) (cts : list (Z * Z)) : Z :=
  let cs := map fst cts in let highest := greatest_z cs in least_z (map (bound_by moved den cts highest) cs).

Section Behind.
Variable S : behind.

Definition law_unit : Z := common (concat (concat (policy_laws S))).
Definition law_weights : list (list (list Z)) := map (map (map (over law_unit))) (policy_laws S).

(* What decisions are worth wherever something is released besides the group, by group and by released context *)
Definition shown_worths (means : matrix) (c : option nat) : matrix := map (shown_worth S means c) (seq 0 (true_groups S)).
Definition shown_sites (W : matrix) : list (list (list Z)) := map (pieces (released_contexts S) (decisions S)) (integers W).

Definition all_zero (v : list Z) : bool := forallb (Z.eqb 0) v.

(* Sum over what is released of the greatest p - V q near this policy, V = n/d and eta = moved/den; the weights are over the unit. *)
Definition sum_near (unit : Z) (weights : list (list (list Z))) (n d moved den : Z) (row row' : list Z) (alphas betas : list (list Z)) : Z :=
  sum_z (map (fun w =>
    let '(alpha, beta, laws) := w in
    if all_zero alpha && all_zero beta then 0
    else sum_z (map (fun rl =>
      greatest_near (moved * unit) den
        (combine (map (fun v => rl.1.1 * v.1 * d - rl.1.2 * v.2 * n) (combine alpha beta)) rl.2)) (combine (combine row row') laws)))
    (combine (combine alphas betas) weights)).

Definition never_near (unit : Z) (weights : list (list (list Z))) (eta V : Q) (rows : list (list Z)) (means : matrix) (c : option nat) : bool :=
  let sites := shown_sites (shown_worths means c) in
  let sides := map (fun a => (nth a rows [], nth a sites [])) (groups_in S c) in
  forallb (fun ab => sum_near unit weights (Qnum V) (Zpos (Qden V)) (Qnum eta) (Zpos (Qden eta)) ab.1.1 ab.2.1 ab.1.2 ab.2.2 <=? 0) (ordered [] sides).

(* ---- A policy that gains most ---- *)

(* Decisions with the two numbers by which they are ordered, and their masses *)
Definition entry_of : Type := (Q * Q) * (nat * Q).
Definition before (e f : entry_of) : bool :=
  if equal e.1.1 f.1.1 then at_most e.1.2 f.1.2 else at_most e.1.1 f.1.1.
Fixpoint insert (e : entry_of) (es : list entry_of) : list entry_of :=
  match es with f :: rest => if before e f then e :: es else f :: insert e rest | [] => [e] end.
Definition in_order (es : list entry_of) : list entry_of := fold_right insert [] es.

(* Move so much from the first ones to the last *)
Fixpoint shifted (left gone : Q) (es : list entry_of) : list (nat * Q) :=
  match es with
  | [e] => let part := lesser left e.2.2 in [(e.2.1, plus (difference e.2.2 part) (plus gone left))]
  | e :: rest => let part := lesser left e.2.2 in (e.2.1, difference e.2.2 part) :: shifted (difference left part) (plus gone part) rest
  | [] => []
  end.

Definition mass_at (ms : list (nat * Q)) (u : nat) : Q := match find (fun m => Nat.eqb m.1 u) ms with Some m => m.2 | None => zero end.

(* The law that gains most of p - V q, and of those of q; or the one that leaves nothing of q and gains most of p, if there is one *)
Definition moved_law (eta : Q) (V : option Q) (p q law : vector) : vector :=
  let all := combine (combine p q) (numbered law) in
  let us := seq 0 (decisions S) in
  match V with
  | Some V =>
      let ms := shifted eta zero (in_order (map (fun e => ((difference e.1.1 (times V e.1.2), e.1.2), e.2)) all)) in
      map (mass_at ms) us
  | None =>
      let free := filter (fun e => zero_fraction e.1.2) all in
      let lost := total (map (fun e => if zero_fraction e.1.2 then zero else e.2.2) all) in
      let left := difference eta lost in
      if nonnegative left then let ms := shifted left lost (in_order (map (fun e => ((e.1.1, zero), e.2)) free)) in map (mass_at ms) us
      else law
  end.

Definition moved_laws (eta : Q) (V : option Q) (p : pair) : list (list vector) :=
  let means := match in_true_context p with Some _ => [] | None => mean_worths S end in
  let worth a := pieces (released_contexts S) (decisions S) (shown_worth S means (in_true_context p) a) in
  let row a := nth a (group_matrix S) [] in
  map (fun w =>
    map (fun rl => moved_law eta V (map (times rl.1.1) w.1.1) (map (times rl.1.2) w.1.2) rl.2)
        (combine (combine (row (higher_group p)) (row (lower_group p))) w.2))
    (combine (combine (worth (higher_group p)) (worth (lower_group p))) (policy_laws S)).

(* ---- Claims ---- *)

(* No law is farther away than eta, in total variation *)
Definition far (p q : vector) : Q := total (map (fun t => let e := difference t.1 t.2 in if nonnegative e then e else zero) (combine p q)).
Definition all_near (eta : Q) (rows : list (list vector)) : bool :=
  forallb (fun t => forallb (fun l => at_most (far l.1 l.2) eta) (combine t.1 t.2)) (combine rows (policy_laws S)).

Definition attained_near (eta : Q) (V : option Q) (p : pair) : bool :=
  let rows := moved_laws eta V p in
  are_laws S rows && all_near eta rows && has_ratio S (expectations (with_laws S rows)) V p.

(* So much work is left to others. *)
Definition work_near (means : bool) : Z :=
  let size := Z.of_nat in
  size (true_groups S) * size (true_groups S) * size (released_groups S) * size (decisions S) * size (decisions S)
  * (if means then size (released_contexts S)
     else size (true_contexts S) * match context_filter S with Filtered _ => size (released_contexts S) | AsIs _ => 1 end).

Definition near_accepted (means : bool) (V : option Q) (attained : option pair) : option bool :=
  match max_drift (stated S) with
  | Some eta =>
      if 20000000 <? work_near means then None
      else Some [&& one_release S,
        match V with
        | Some V =>
            at_most one V
            && (let rows := rows_of S in
                let worths := if means then mean_worths S else [] in
                let unit := law_unit in
                let weights := law_weights in
                forallb (never_near unit weights eta V rows worths) (places S means))
        | None => true
        end
        & match V, attained with
          | Some V, None => at_most V one
          | Some V, Some p => [&& ~~ at_most V one, is_pair S means p & attained_near eta (Some V) p]
          | None, Some p => is_pair S means p && attained_near eta None p
          | None, None => false
          end]
  | None => Some false
  end.
End Behind.
