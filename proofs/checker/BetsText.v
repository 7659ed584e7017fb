(* Intervals by bets on contrasts within units as a certificate states them.

   This file only computes.  It follows docs/certificate-samples.md, region "paired".  A certificate lists what units got in the groups of
   each context; the header of its table names the digest of that list. *)

From Coq Require Import ZArith QArith List Ascii String.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditChecker Require Import Json Canonical Reading Statements Table TableText Document Drawn DrawnText.
From FairauditChecker Require Bets.
From FairauditKernel Require Import Fractions.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.

Definition k_missing := of_string "missing".
Definition k_measured := of_string "measured".

Definition is_paired (v : json) : bool :=
  match v with Members ms => match found k_region ms with Some (Text t) => same t (of_string "paired") | _ => false end | _ => false end.
Definition with_units (v : json) : bool := match v with Members ms => has k_units ms | _ => false end.

(* The digest of the profiles of the local interval that the header of a table names *)
Definition profiles_digest (h : json) : option text :=
  match h with
  | Members hs => match found k_profiles hs with
      | Some (Members ps) => match found k_local ps with Some (Text d) => Some d | _ => None end
      | _ => None end
  | _ => None
  end.

(* [n, [...]]: so many units; what is listed of them is not nothing, and not what was listed before. *)
Definition counted_of {A} (f : json -> read A) (nothing : A -> bool) (v : json) : read (Z * list A) :=
  match v with
  | Items [n; l] =>
      let* n := integer_of n in
      let* xs := many f l in
      demand (0 <? n)%Z "must be at least 1" (demand (~~ forallb nothing xs) "must not be nothing" (Good (n, xs)))
  | _ => bad "must be a list of 2 entries"
  end.
Definition counted_list_of {A} (f : json -> read A) (nothing : A -> bool) (v : json) : read (list (Z * list A)) :=
  let* vs := list_of v in
  let* es := each (counted_of f nothing) vs in
  demand (distinct (map (fun v => match v with Items [_; l] => canonical l | _ => [] end) vs)) "lists something twice" (Good es).

Definition profiles_of : json -> read (list (list Bets.entry)) :=
  many (counted_list_of (option_of not_negative) (fun v => match v with None => true | Some _ => false end)).
Definition rows_of : json -> read (list (list (Z * list Z))) := many (counted_list_of integer_of (Z.eqb 0)).

Definition range_between (v : json) : option text :=
  match v with
  | Items [Text low; Text high] => Some (of_string "whatever could have been drawn has a utility between " ++ low ++ of_string " and " ++ high)
  | _ => None
  end.

Definition read_ratio (v : json) : read (Q * option Q) :=
  match v with
  | Items [low; high] => let* l := rational_of low in let* h := extended_of high in Good (l, h)
  | _ => bad "must have 2 entries"
  end.

(* What is stated of the means over units, of the pools that the table counts *)
Definition measured_parts (a : about) (H : header) (T : table) (i : Bets.units) (v : json) : read (list part) :=
  let* _ := demand (match v with Null => false | _ => true end) "must not be null" (Good tt) in
  let* m := metric_of a H Local v in
  let means := match pools_of T true with Some ps => draws_in i ps | None => None end in
  let (own, theirs) := (columns_of a, columns_of (about_of H)) in
  Good ((if same_labels (of_group own) (of_group theirs) && same_labels (of_context own) (of_context theirs) then [] else [Fact false]) (* what names columns is of the columns of the table *)
        ++ map (fun p => match p with
             | About s => match means with Some ds => Of_means (means_table T ds) s | None => Fact false end
             | _ => p end) m.1).

Definition read_paired (is_named : json -> bool) (a : about) (H : header) (T : table) (v : json) : read drawn :=
  let units := with_units v in
  let* ms := fields ([k_confidence; k_ends; k_region; k_independent; k_method; k_limits; k_ratio; k_levels; k_missing; k_profiles]
                     ++ (if units then [k_units; k_estimand; k_measured] else [])) [] v in
  let* c := get rational_of k_confidence ms in
  let* written_c := get string_of k_confidence ms in
  let* apart := get (choice [(of_string "together", false); (of_string "each", true)]) k_ends ms in
  let* ind := get boolean_of k_independent ms in
  let* _ := get (choice methods) k_method ms in
  let* lim := get (option_of (two not_negative)) k_limits ms in
  let* r := get read_ratio k_ratio ms in
  let* ls := get (fields [k_upper; k_lower] []) k_levels ms in
  let* u := get not_negative k_upper ls in
  let* l := get not_negative k_lower ls in
  let* d := get (choice [(of_string "worst", false); (of_string "drop", true)]) k_missing ms in
  let* ps := get profiles_of k_profiles ms in
  let* rows := if units then let* us := get rows_of k_units ms in Good (Some us) else Good None in
  let* _ := if units then get (choice [(of_string "mean over units", tt)]) k_estimand ms else Good tt in
  let named := match found k_profiles ms with Some v => is_named v | None => false end in
  let i := Bets.Units c apart ind u l d lim rows ps named r.1 r.2 in
  let* beside := if units then get (measured_parts a H T i) k_measured ms else Good [] in
  let range := match found k_limits ms with Some v => range_between v | None => None end in
  demand (match lim with Some (low, high) => at_most low high | None => true end) "must have the lower one first"
    (demand (between_0_and_1 c) "must have a confidence between 0 and 1"
      (Good (Drawn (By_bets i) ((if apart then one_sided else together) ++ written_c) beside range))).

(* The interval of this quantity, where it is covered.  Units are those of the local interval of a ratio alone.  Beside it cells are not
   independent, and no unit may have several rows in one. *)
Definition drawn_with_units (is_named : json -> bool) (a : about) (H : header) (T : table) (local : bool) (all : list (text * json)) : option drawn :=
  let own := if local then k_local else k_global in
  match found own all with
  | Some v =>
      if is_paired v then
        if local && forallb (fun m => same m.1 own || ~~ with_units m.2) all then
          match pools_of T true, read_paired is_named a H T v with Some _, Good i => Some i | _, _ => None end
        else None
      else if existsb (fun m => is_paired m.2) all then
        match drawn_of T local (filter (fun m => ~~ is_paired m.2) all) with
        | Some i => if existsb (fun m => with_units m.2) all || cells_independent (its_proof i) then None else Some i
        | None => None
        end
      else drawn_of T local all
  | None => None
  end.
