(* What a certificate of a policy behind filters states besides what one of a table does: the privacy of the filters, what was
   declared, and claims by theorems about policies.

   This file only computes.  It follows docs/certificate-policy.md.  Claims that PolicyChecker.v does not judge are not covered. *)

From Coq Require Import ZArith QArith List Ascii String.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Policy PolicyClaims.
From FairauditChecker Require Import Json Canonical Reading Table Statements TableText ClassText Document PolicyText.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.

Definition k_exp_epsilon := of_string "exp_epsilon".
Definition k_attributes := of_string "attributes".
Definition k_multipliers := of_string "multipliers".
Definition k_raw_ratio := of_string "raw_ratio".
Definition k_composition := of_string "composition".
Definition k_attained := of_string "attained".
Definition k_unfiltered := of_string "unfiltered".
Definition k_policy := of_string "policy".
Definition k_floors := of_string "floors".

(* ---- Privacy: e^epsilon as Policy.v defines it, of each factor and of all of them ---- *)

Definition privacy_of (v : json) : read (option Q * list (option Q)) :=
  let* ms := fields [k_exp_epsilon; k_attributes] [] v in
  let* e := get extended_of k_exp_epsilon ms in
  let* es := get (many extended_of) k_attributes ms in Good (e, es).

Fixpoint same_ratios (es es' : list (option Q)) : bool :=
  match es, es' with
  | e :: rest, e' :: rest' => PolicyClaims.same_extended e e' && same_ratios rest rest'
  | [], [] => true
  | _, _ => false
  end.

Definition privacy_items (name : text) (stated : option (option Q * list (option Q))) (fs : option (list Policy.matrix)) : list item :=
  let label := of_string "subject.privacy." ++ name in
  match stated, fs with
  | Some (e, es), Some fs =>
      [Item (label ++ of_string ".exp_epsilon") [Fact (PolicyClaims.same_extended e (Policy.exp_epsilon fs))];
       Item (label ++ of_string ".attributes") [Fact (same_ratios es (map Policy.factor_epsilon fs))]]
  | None, None => [Item label [Fact true]]
  | _, _ => [Item label [Fact false]]
  end.

Definition read_privacy (B : Policy.behind) (v : json) : read (list item) :=
  let* ms := fields [k_group; k_context] [] v in
  let* g := get privacy_of k_group ms in
  let* x := get (option_of privacy_of) k_context ms in
  Good (privacy_items k_group (Some g) (Some (Policy.group_filter B))
        ++ privacy_items k_context x (match Policy.context_filter B with Policy.Filtered fs => Some fs | Policy.AsIs _ => None end)).

(* ---- What was declared, beside the constants that are stated of the table ---- *)

Definition declared_item (name : text) (declared : option Q) (own : statement) (fits : Q -> bool) : list item :=
  match declared with Some q => [Item (of_string "subject.declared." ++ name) [About own; Fact (fits q)]] | None => [] end.

Fixpoint own_items (i last : Z) (ds : list Policy.declared_in) : list item :=
  match ds with
  | d :: rest =>
      let x := Policy.in_context d in
      Item (in_list "subject.declared.by_context" i) (if (last <? x)%Z then [Allowed (Policy.In_context d)] else [Fact false])
      :: own_items (i + 1) (Z.max last x) rest
  | [] => []
  end.

Definition declared_items (D : Policy.declared) (v : json) : read (list item) :=
  let* ms := object_of v in
  let* gamma := get rational_of k_gamma ms in
  let* m := get rational_of k_m ms in
  let* tau := get (option_of rational_of) k_tau ms in
  let* l := get rational_of k_lipschitz ms in
  Good (declared_item k_gamma (Policy.gamma D) (Gamma_is gamma) (Fractions.at_most gamma)
        ++ declared_item k_m (Policy.m D) (Least_is m) (fun q => Fractions.at_most q m)
        ++ declared_item k_tau (Policy.tau D) (Tau_is tau) (fun q => match tau with Some t => Fractions.at_most q t | None => false end)
        ++ declared_item k_lipschitz (Policy.lipschitz D) (Lipschitz_is l) (Fractions.at_most l)
        ++ (match Policy.global_tau D with
            | Some t => [Item (of_string "subject.declared.global_tau") [Allowed (Policy.Of_means t)]]
            | None => [] end)
        ++ own_items 0 (-1) (Policy.by_context D)).

(* ---- Claims ---- *)

Definition any_policy := of_string "any policy behind this filter".
Definition floored := any_policy ++ of_string " that keeps the declared floor".
Definition near_this := any_policy ++ of_string " within the declared drift of this one".
Definition any_range := any_policy ++ of_string ", any utility of the declared range".
Definition floored_range := floored ++ of_string ", any utility of the declared range".
Definition any_group_filter := of_string "this policy and context filter, any group filter at most this epsilon that releases the same values".
Definition any_context_filter := of_string "this policy and group filter, any context filter that releases these contexts".

Definition scopes : list (text * Policy.scope) :=
  [(this_law, Policy.ThisLaw); (any_policy, Policy.AnyPolicy); (floored, Policy.KeepingFloor);
   (any_range, Policy.AnyUtility); (floored_range, Policy.AnyUtilityKeepingFloors);
   (any_group_filter, Policy.AnyGroupFilter); (any_context_filter, Policy.AnyContextFilter)].

Definition alone (r : Policy.reason) (e : json) : read Policy.reason := let* _ := fields [] [] e in Good r.
Definition with_ratio (k : text) (r : option Q -> Policy.reason) (e : json) : read Policy.reason :=
  let* ms := fields [k] [] e in let* x := get extended_of k ms in Good (r x).
Definition with_multipliers (r : list Q -> Policy.reason) (e : json) : read Policy.reason :=
  let* ms := fields [k_multipliers] [] e in
  let* ks := get (many not_negative) k_multipliers ms in
  demand (match ks with [] => false | _ => true end) "must have multipliers" (Good (r ks)).

Definition t13 := of_string "T13".
Definition t5_decision := of_string "T5-decision".

(* The theorems that bound the local ratio, or that of means, in a scope; and how their evidence is read *)
Definition reasons_in (s : Policy.scope) (means : bool) : list (text * (json -> read Policy.reason)) :=
  let with_floor := [(of_string "T1-paper", alone Policy.ByT1paper); (of_string "T1", with_multipliers Policy.ByT1);
                     (of_string "T3", with_multipliers Policy.ByT3); (of_string "floor", alone Policy.ByFloor)] in
  match s, means with
  | Policy.ThisLaw, false | Policy.KeepingFloor, false => with_floor
  | Policy.AnyPolicy, false => [(of_string "T2", alone Policy.ByT2); (of_string "T4", with_multipliers Policy.ByT4)]
  | Policy.AnyPolicy, true => [(t5, alone Policy.ByT5); (t5_decision, with_ratio k_composition Policy.ByT5decision)]
  | Policy.AnyGroupFilter, false =>
      [(of_string "T3", with_multipliers Policy.ByT3); (of_string "T12", with_ratio k_raw_ratio Policy.ByT12)]
  | Policy.AnyContextFilter, false => [(of_string "T8", alone Policy.ByT8)]
  | Policy.AnyUtility, _ => [(t13, alone (Policy.ByT13range []))]
  | Policy.AnyUtilityKeepingFloors, _ => [(t13, with_multipliers Policy.ByT13range)]
  | _, _ => []
  end.

Section Claims.
(* The header of the induced law; and the ratio that the metrics state, local or not: a bound below it is of no use. *)
Variables (H : header) (ratio_of : bool -> option (option Q)).

Definition and_no_metric_exceeds (local : bool) (x : option Q) (p : part) : list part :=
  match ratio_of local with
  | Some r => [p; About (Quantity_is (if local then Local else Global) r); Fact (PolicyClaims.no_more r x)]
  | None => [Fact false]
  end.

Definition suprema_scopes : list (text * Policy.scope) := [(any_policy, Policy.AnyPolicy); (near_this, Policy.NearThis); (floored, Policy.KeepingFloors)].
Definition suprema : list (text * bool) := [(of_string "local_ratio_supremum", false); (of_string "global_ratio_supremum", true)].

(* A place where groups are compared; nothing where there is no such place *)
Definition place_in (ms : list (text * json)) : read (option Policy.pair) :=
  let* x := get (option_of (many string_of)) k_context ms in
  let* h := get (many string_of) k_higher ms in
  let* l := get (many string_of) k_lower ms in
  let hi := number_of (groups_of H) h in
  let lo := number_of (groups_of H) l in
  let xi := match x with Some ls => number_of (contexts_of H) ls | None => 0%Z end in
  Good (if ((0 <=? hi) && (0 <=? lo) && (0 <=? xi))%Z
        then Some (Policy.Pair (option_map (fun=> Z.to_nat xi) x) (Z.to_nat hi) (Z.to_nat lo)) else None).
Definition place_of (v : json) : read (option Policy.pair) := let* ms := fields [k_context; k_higher; k_lower] [] v in place_in ms.

(* Where a greatest ratio is attained *)
Definition attained_of (e : json) : read (option (option Policy.pair)) :=
  let* ms := fields [k_attained] [] e in
  match found k_attained ms with
  | Some (Members _ as v) => let* p := at_place k_attained (place_of v) in Good (option_map Some p)
  | Some Null => Good (Some None)
  | _ => bad "must be an object or null"
  end.

(* A floor, of a context or of a mean, with its multiplier; numbers that are too great are of nothing. *)
Definition at_the_most (n : Z) (v : json) : read nat :=
  let* i := integer_of v in demand (0 <=? i)%Z "is out of range" (Good (Z.to_nat (if (i <? n)%Z then i else n))).
Definition floor_in_list (v : json) : read (option nat * nat * Q) :=
  let* vs := list_of v in
  match vs with
  | [x; a; y] =>
      let* x := option_of (at_the_most (size (contexts_of H))) x in
      let* a := at_the_most (size (groups_of H)) a in
      let* y := not_negative y in
      demand (positive_fraction y) "must be positive" (Good (x, a, y))
  | _ => bad "must have 3 entries"
  end.
Definition priced_of (v : json) : read (option Policy.priced) :=
  let* ms := fields [k_context; k_higher; k_lower; k_floors] [] v in
  let* p := place_in ms in
  let* fs := get (many floor_in_list) k_floors ms in
  Good (option_map (fun p => Policy.Priced p fs) p).

(* A policy that attains a ratio *)
Definition shown_policy_of (v : json) : read (option (Policy.pair * list (list Policy.vector))) :=
  let* ms := fields [k_attained; k_rows] [] v in
  let* p := get place_of k_attained ms in
  let* rows := get (many (many (many not_negative))) k_rows ms in
  Good (option_map (fun p => (p, rows)) p).

(* What proves a greatest ratio over the policies that keep the floors; nothing where it names what is not there *)
Definition floored_of (e : json) : read (option Policy.reason) :=
  let* ms := fields [k_multipliers; k_pairs; k_policy] [] e in
  let* ks := get (many not_negative) k_multipliers ms in
  let* ps := get (many priced_of) k_pairs ms in
  let* w := get (option_of shown_policy_of) k_policy ms in
  Good (match all_there ps [], w with
    | Some ps, Some (Some w) => Some (Policy.ByT13floors ks ps (Some w))
    | Some ps, None => Some (Policy.ByT13floors ks ps None)
    | _, _ => None
    end).

(* Theorems of which every claim is covered: what is none of the above is no claim of the format. *)
Definition of_policies : list text :=
  [t13; t5; t5_decision; of_string "T1"; of_string "T1-paper"; of_string "T2"; of_string "T3"; of_string "T4"; of_string "T8"; of_string "T12";
   of_string "floor"].
Definition no_such_claim (b : text) : list part := [if among of_policies b then Fact false else Uncovered].

Definition policy_parts (q r b s : text) (x : option Q) (e : json) : read (list part) :=
  let of_means := if same q q_global_ratio then Some true else if same q q_local_ratio then Some false else None in
  match of_means, in_table scopes s with
  | Some means, Some sc =>
      match same r upper_bound, in_table (reasons_in sc means) b with
      | true, Some f => let* why := f e in Good (and_no_metric_exceeds (~~ means) x (Of_policy (Policy.Statement means false x sc) why))
      | _, _ => Good (no_such_claim b)
      end
  | None, _ =>
      let exact := same r equality in
      match in_table suprema q, same b t13 && (exact || same r upper_bound), in_table suprema_scopes s with
      | Some means, true, Some sc =>
          let claimed why := match why with
            | Some why => and_no_metric_exceeds (~~ means) x (Of_policy (Policy.Statement means exact x sc) why)
            | None => [Fact false] end in
          match sc, exact with
          | Policy.AnyPolicy, true | Policy.NearThis, true => let* place := attained_of e in Good (claimed (option_map Policy.ByT13 place))
          | Policy.KeepingFloors, _ => let* why := floored_of e in Good (claimed why)
          | _, _ => Good (no_such_claim b)
          end
      | _, _, _ => Good (no_such_claim b)
      end
  | _, _ => Good (no_such_claim b)
  end.

Definition is_uncovered (ps : list part) : bool := match ps with [Uncovered] => true | _ => false end.

Definition read_policy_claim (digest : text) (i : Z) (v : json) : read claim :=
  let* c := read_claim digest None i v in
  match is_uncovered (proved_by c), key c with
  | true, [q; r; b; s] =>
      let* ms := object_of v in
      let* x := get extended_of k_value ms in
      let* ps := get (policy_parts q r b s x) k_evidence ms in
      Good (Claim (key c) (said c) ps (~~ is_uncovered ps) (assumed c))
  | _, _ => Good c
  end.
End Claims.

(* ---- What claims have to list that they rest on ---- *)

Definition fresh := of_string
  "the filter's draws for group and context are independent of each other and of everything else, fresh for each decision, and the decision depends on group and context only through what the filters release".
Definition stated_population := of_string "the contexts of each group are distributed as in the stated population".
Definition declared_floor (tau : text) : text :=
  of_string "every compared group's expected utility is at least " ++ tau ++ of_string " behind the filter (declared)".

Definition declared_range (m gamma l : text) : text :=
  of_string "every utility is between " ++ m ++ of_string " and " ++ gamma
  ++ of_string ", and for the same decision and context the utilities of two groups differ by at most " ++ l ++ of_string " (declared)".

Definition declared_floor_in (context tau : text) : text :=
  of_string "in context " ++ context ++ of_string ", every compared group's expected utility is at least " ++ tau
  ++ of_string " behind the filter (declared)".
Definition declared_mean_floor (tau : text) : text :=
  of_string "every compared group's mean utility is at least " ++ tau ++ of_string " behind the filter (declared)".
Definition declared_range_in (context m gamma : text) : text :=
  of_string "in context " ++ context ++ of_string ", every utility is between " ++ m ++ of_string " and " ++ gamma ++ of_string " (declared)".
Definition declared_drift (drift : text) : text :=
  of_string "for everything that the filters release, the law of the decision is within total variation " ++ drift
  ++ of_string " of the law of this policy (declared)".
Definition so_many_releases (n : Z) : text :=
  of_string "one memory sees at most " ++ decimal n ++ of_string " releases of a group, each drawn afresh (declared)".

(* A list of labels as JSON, with other characters than ASCII as they are *)
Definition written_byte (c : ascii) : text :=
  match c with
  | Ascii _ _ _ _ _ _ _ true => [c]
  | _ => if (c =? "127")%char then [c] else escaped_byte c
  end.
Definition written_labels (v : json) : text :=
  let label l := match l with Text t => quote :: flat_map written_byte t ++ [quote] | _ => [] end in
  match v with
  | Items (l :: ls) => of_string "[" ++ label l ++ flat_map (fun l => of_string ", " ++ label l) ls ++ of_string "]"
  | _ => of_string "[]"
  end.

(* Of what was declared, of the constants that are stated of the table, and of so many releases *)
Section Needed.
Variables (declared constants : list (text * json)) (releases : Z).

Definition text_in (ms : list (text * json)) (k : text) : text := match found k ms with Some (Text t) => t | _ => [] end.
Definition of_own (f : list (text * json) -> list text) : list text :=
  match found k_by_context declared with
  | Some (Items vs) => flat_map (fun v => match v with Members ms => f ms | _ => [] end) vs
  | _ => []
  end.
Definition above_zero (ms : list (text * json)) (k : text) (sentence : text -> text) : list text :=
  match found k ms with Some (Text t) => if same t (of_string "0") then [] else [sentence t] | _ => [] end.
Definition context_in (ms : list (text * json)) : text := match found k_context ms with Some v => written_labels v | None => [] end.

Definition floors_needed : list text :=
  above_zero declared k_tau declared_floor
  ++ of_own (fun ms => above_zero ms k_tau (declared_floor_in (context_in ms)))
  ++ above_zero declared k_global_tau declared_mean_floor.

Definition ranges_needed (local : bool) : list text :=
  let otherwise ms k := text_in (if has k ms then ms else declared) k in
  declared_range (text_in declared k_m) (text_in declared k_gamma) (text_in (if has k_lipschitz declared then declared else constants) k_lipschitz)
  :: (if local then of_own (fun ms =>
        if has k_gamma ms || has k_m ms then [declared_range_in (context_in ms) (otherwise ms k_m) (otherwise ms k_gamma)] else []) else []).

Definition needed_by_t13 (means : bool) (s : text) : list text :=
  key_if means stated_population
  ++ (if same s floored || same s floored_range then floors_needed else [])
  ++ (if same s any_range || same s floored_range then ranges_needed (~~ means) else [])
  ++ (if same s near_this then [declared_drift (text_in declared k_max_drift)] else [])
  ++ key_if (1 <? releases)%Z (so_many_releases releases).

Definition needed_for (c : claim) : option (list text) :=
  match key c with
  | [q; _; b; s] =>
      Some (fresh ::
        (if same b t13 then needed_by_t13 (same q q_global_ratio || same q (of_string "global_ratio_supremum")) s
         else key_if (same s any_policy && (same b t5 || same b t5_decision)) stated_population
              ++ key_if (same s floored) (declared_floor (text_in declared k_tau))))
  | _ => None
  end.

Definition lists_what_is_needed (c : claim) : bool :=
  match needed_for c with
  | Some needed => of_length (size needed) (assumed c) && forallb (among (assumed c)) needed
  | None => false
  end.
End Needed.
