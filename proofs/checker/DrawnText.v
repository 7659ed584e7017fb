(* Intervals and the claims about them as a certificate states them.

   This file only computes.  It follows docs/certificate-samples.md.  What is read are intervals of the regions "box" and "pairs" in tables
   of counts; what else there is has no interval here, and is not covered. *)

From Coq Require Import ZArith QArith List Ascii String.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditChecker Require Import Chance Json Reading Statements Table TableText Document Drawn.
From FairauditChecker Require Hidden Pairs PlainEnds Bets.
From FairauditKernel Require Import Fractions.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.

Definition k_confidence := of_string "confidence".
Definition k_ends := of_string "ends".
Definition k_region := of_string "region".
Definition k_independent := of_string "independent".
Definition k_method := of_string "method".
Definition k_limits := of_string "limits".
Definition k_levels := of_string "levels".
Definition k_upper := of_string "upper".
Definition k_lower := of_string "lower".
Definition k_pair := of_string "pair".
Definition k_interval := of_string "interval".
Definition k_units := of_string "units".
Definition k_knots := of_string "knots".

Definition methods : list (text * unit) := map (fun m => (of_string m, tt)) ["hoeffding-kl"; "empirical-bernstein"; "intersection"]%string.

(* ---- An interval ---- *)

(* The number of the i-th pool of a block, n being that of the first *)
Fixpoint number_in (ps : list pool) (n b i : Z) : option Z :=
  match ps with
  | p :: rest => if (of_block p =? b)%Z then if (i =? 0)%Z then Some n else number_in rest (n + 1) b (i - 1) else number_in rest (n + 1) b i
  | [] => None
  end.

Definition no_cell : Z := (-1)%Z.

Definition read_pair (ps : list pool) (v : json) : read (option (Z * Z)) :=
  match v with
  | Null => Good None
  | _ =>
      let* ns := so_many 3 integer_of v in
      match ns with
      | [b; i; j] =>
          let number k := match number_in ps 0 b k with Some n => n | None => no_cell end in
          demand (forallb (Z.leb 0) ns) "must not be negative" (Good (Some (number i, number j)))
      | _ => bad "must have 3 entries"
      end
  end.

Fixpoint rising (ns : list Z) : bool := match ns with i :: ((j :: _) as rest) => (i <? j)%Z && rising rest | _ => true end.

(* The ends of all cells, or of some *)
Definition read_ends (v : json) : read PlainEnds.given :=
  match v with
  | Members _ =>
      let* ms := fields [k_cells; k_ends] [] v in
      let* ns := get (many integer_of) k_cells ms in
      let* es := get (so_many (size ns) (two not_negative)) k_ends ms in
      demand (rising ns) "must have cells that go up" (Good (PlainEnds.Some_cells (combine ns es)))
  | _ => let* es := many (two not_negative) v in Good (PlainEnds.All es)
  end.

Definition between_0_and_1 (q : Q) : bool := positive_fraction q && positive_fraction (plus one (minus q)).

Definition together := of_string "population at confidence ".
Definition one_sided := of_string "population, one-sided at confidence ".

Definition read_interval (ps : list pool) (v : json) : read drawn :=
  let* ms := fields [k_confidence; k_ends; k_region; k_independent; k_method; k_limits; k_ratio; k_levels; k_upper; k_lower; k_pair] [] v in
  let* c := get rational_of k_confidence ms in
  let* written_c := get string_of k_confidence ms in
  let* apart := get (choice [(of_string "together", false); (of_string "each", true)]) k_ends ms in
  let* _ := get (choice [(of_string "box", tt)]) k_region ms in
  let* ind := get boolean_of k_independent ms in
  let* _ := get (choice methods) k_method ms in
  let* r := get (two extended_of) k_ratio ms in
  let* ls := get (fields [k_upper; k_lower] []) k_levels ms in
  let* u := get not_negative k_upper ls in
  let* l := get not_negative k_lower ls in
  let* up := get read_ends k_upper ms in
  let* low := get read_ends k_lower ms in
  let ss := match all_of sample_of ps with Some ss => if is_short ss then ss else [] | None => [] end in (* of what is not judged no ends *)
  let up := PlainEnds.completed (PlainEnds.plain_of (PlainEnds.reach_of u)) ss up in
  let low := PlainEnds.completed PlainEnds.range_of ss low in
  let* p := get (read_pair ps) k_pair ms in
  demand (match found k_limits ms with Some Null => true | _ => false end) "has limits"
    (demand (between_0_and_1 c) "must have a confidence between 0 and 1"
      (Good (Drawn (By_box (Interval c apart ind u l up low p r.1 r.2)) ((if apart then one_sided else together) ++ written_c) [] None))).

(* An interval by ladders for pairs of cells, without a split *)
Definition read_by_pairs (ps : list pool) (v : json) : read drawn :=
  let* ms := fields [k_confidence; k_ends; k_region; k_independent; k_method; k_limits; k_ratio; k_levels; k_upper; k_lower] [] v in
  let* c := get rational_of k_confidence ms in
  let* written_c := get string_of k_confidence ms in
  let* apart := get (choice [(of_string "together", false); (of_string "each", true)]) k_ends ms in
  let* _ := get (choice [(of_string "pairs", tt)]) k_region ms in
  let* ind := get boolean_of k_independent ms in
  let* _ := get (choice methods) k_method ms in
  let* r := get (two extended_of) k_ratio ms in
  let* ls := get (fields [k_upper; k_lower] []) k_levels ms in
  let* u := get not_negative k_upper ls in
  let* l := get not_negative k_lower ls in
  let* up := get (option_of (many (many not_negative))) k_upper ms in
  let* low := get (option_of (fun v =>
    let* es := fields [k_pair; k_knots] [] v in
    let* p := get (read_pair ps) k_pair es in
    let* knots := get (many not_negative) k_knots es in
    match p with Some p => Good (p, knots) | None => bad "must have a pair" end)) k_lower ms in
  demand (match found k_limits ms with Some Null => true | _ => false end) "has limits"
    (demand (between_0_and_1 c) "must have a confidence between 0 and 1"
      (match r.1 with
       | Some least => Good (Drawn (By_pairs (Pairs.By c apart ind (u, l) up low least r.2)) ((if apart then one_sided else together) ++ written_c) [] None)
       | None => bad "has a lower end that is infinite"
       end)).

(* The interval of this quantity, where it is covered: no interval of the certificate may then be about sampling units. *)
Definition drawn_of (T : table) (local : bool) (all : list (text * json)) : option drawn :=
  let of_rows v := match v with Members ms => ~~ has k_units ms && ~~ has k_profiles ms | _ => false end in
  match found (if local then k_local else k_global) all, pools_of T local with
  | Some v, Some ps =>
      if forallb (fun m => of_rows m.2) all then
        match read_interval ps v, read_by_pairs ps v with Good i, _ | _, Good i => Some i | _, _ => None end
      else None
  | _, _ => None
  end.

(* ---- What is stated by it ---- *)

Definition about_interval (i : drawn) (s : of_interval) : bool :=
  let no_more (a b : option Q) := match a, b with _, None => true | None, Some _ => false | Some a, Some b => at_most a b end in
  match s with
  | The_interval => true
  | Its_most scope v => same scope (its_scope i) && no_more (most_of (its_proof i)) v
  | Its_least scope v => [&& same scope (its_scope i), no_more (Some one) v & no_more v (least_of (its_proof i))]
  | Its_frontier scope v ls => same scope (its_scope i) && Hidden.frontier_fits (least_of (its_proof i)) v ls
  end.

(* The method that claims name *)
Definition method_of (e : Drawn.proof) : text :=
  of_string match e with By_box _ => "binomial" | By_pairs _ => "pair-exact" | By_bets _ => "paired-betting" end.

Definition about_local (c : claim) : bool :=
  match key c with q :: _ => same q q_local_ratio || same q (of_string "local_hidden_context") | [] => true end.

Definition population_parts (i : drawn) (c : claim) (v : json) : read (list part) :=
  match key c with
  | [q; r; b; s] =>
      let local := same q q_local_ratio in
      if [&& same b (method_of (its_proof i)), local || same q q_global_ratio, same r upper_bound || same r lower_bound
           & begins_with together s || begins_with one_sided s] then
        let* ms := object_of v in
        let* x := get extended_of k_value ms in
        let* name := get (fun e => let* es := fields [k_interval] [] e in get string_of k_interval es) k_evidence ms in
        Good (Of_population local (if same r upper_bound then Its_most s x else Its_least s x)
              :: Fact (same name (if local then k_local else k_global)) :: besides i)
      else if [&& same b t14, among [of_string "local_hidden_context"; of_string "global_hidden_context"] q, same r lower_bound,
                  begins_with together s || begins_with one_sided s & ~~ existsb (fun o => ends_with o s) objections] then
        let* ms := object_of v in
        let* x := get extended_of k_value ms in
        let* ls := get (fun e => let* es := fields [k_frontier] [] e in get frontier_of k_frontier es) k_evidence ms in
        Good (Of_population (about_local c) (Its_frontier s x ls) :: besides i)
      else Good (proved_by c)
  | _ => Good (proved_by c)
  end.

(* ---- What claims have to list ---- *)

Definition draws_sentence := of_string
  "the draws within a cell are independent, each with the law of the cell, and how many there are does not depend on how they came out".
Definition pooled_sentence := of_string "the contexts of each group were drawn from its population, not set by design".
Definition range_sentence (gamma : text) := of_string "whatever could have been drawn has a utility between 0 and " ++ gamma.
Definition own_range_sentence := of_string
  "whatever could have been drawn in a cell has a utility between 0 and the greatest that a decision has there".
Definition chosen_sentence := of_string "utility, method and confidence were chosen without looking at the draws".
Definition cells_sentence := of_string "the draws of different cells are independent of each other".
Definition one_row_sentence := of_string "a sampling unit can have no more than one row in a cell, as is the case here".
Definition paired_sentence := of_string
  "different sampling units are independent, how many there are does not depend on how they came out, and what a unit gets in a group of a context, the mean over its rows there, has the same expectation for all units of the context, also for those not seen in that group; what a unit gets in one group may depend in any way on what it gets in another".
Definition by_design_sentence := of_string
  "in which groups a unit was not seen is by design: it does not depend on what the unit got, or would have got".

Definition lists_what_it_assumes (H : header) (gamma : text) (local : bool) (i : drawn) (listed : list text) : bool :=
  let range := match declared_range i with Some t => t | None => if utility_of H is Some _ then range_sentence gamma else own_range_sentence end in
  let common := [chosen_sentence; range] ++ key_if (~~ local) pooled_sentence in
  let needed := match its_proof i with
    | By_bets b => paired_sentence :: common ++ key_if (Bets.drop b) by_design_sentence
    | e => draws_sentence :: common ++ key_if (cells_independent e) cells_sentence
    end in
  let allowed := needed ++ match its_proof i with By_bets _ => [] | _ => key_if local one_row_sentence end in
  [&& forallb (among listed) needed, forallb (among allowed) listed & distinct listed].

(* A claim about an interval that is covered, if it lists all that it assumes and nothing else *)
Definition with_population (H : header) (gamma : text) (interval_of : bool -> option drawn) (c : claim) (v : json) : read claim :=
  match proved_by c with
  | [Uncovered] =>
      match interval_of (about_local c) with
      | None => Good c
      | Some i =>
          let* ps := population_parts i c v in
          Good (match ps with
            | Of_population local _ :: _ =>
                if lists_what_it_assumes H gamma local i (assumed c) then Claim (key c) (said c) ps false (assumed c) else c
            | _ => c
            end)
      end
  | _ => Good c
  end.

Definition is_about (local : bool) (c : claim) : bool :=
  match proved_by c with Of_population l (Its_most _ _ | Its_least _ _) :: _ => Bool.eqb l local | _ => false end.

(* An interval is covered if a claim says what it rests on. *)
Definition interval_items (interval_of : bool -> option drawn) (claims : list claim) (all : option json) : list item :=
  match all with
  | None => []
  | Some v =>
      let ms := match v with Members ms => ms | _ => [] end in
      let one (name : text) (local : bool) :=
        if has name ms then
          [Item (k_intervals ++ of_string "." ++ name)
            (if existsb (is_about local) claims then
               Of_population local The_interval :: match interval_of local with Some i => besides i | None => [] end else [Uncovered])]
        else [] in
      one k_local true ++ one k_global false
      ++ (match ms with
          | [] => [Item k_intervals [Uncovered]]
          | _ => if forallb (fun m => among [k_local; k_global] m.1) ms then [] else [Item k_intervals [Uncovered]]
          end)
  end.
