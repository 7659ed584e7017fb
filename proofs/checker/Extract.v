(* From Coq to OCaml: the checker of certificates, with Z as zarith's integers and ascii as char. *)

From Coq Require Import ZArith QArith Extraction ExtrOcamlBasic ExtrOcamlZBigInt ExtrOcamlChar.
From FairauditChecker Require Loops.
From FairauditChecker Require Import Certificate.
From mathcomp Require seq path.
From FairauditKernel Require WorstCase.
From FairauditChecker Require Json Canonical Table Figures LeftOut Drawn.

(* Coq's own gcd would take many steps; that of zarith is never negative either. *)
Extract Constant Z.gcd => "Big_int_Z.gcd_big_int".
Extract Constant Z.leb => "Big_int_Z.le_big_int".
Extract Constant Z.ltb => "Big_int_Z.lt_big_int".

(* Coq's own log2 takes a bit at a time; here shifts find the place of the first bit. *)
Extract Constant Z.log2 =>
  "(fun x ->
     let open Big_int_Z in
     let reaches s = sign_big_int (shift_right_big_int x s) > 0 in
     let rec up s = if reaches s then up (2 * s) else s in
     let rec between low high =
       if high - low <= 1 then low else let mid = (low + high) / 2 in if reaches mid then between mid high else between low mid in
     if sign_big_int x <= 0 then zero_big_int else big_int_of_int (between 0 (up 1)))".

(* Loops in the place of functions that recurse: LoopsSound.v proves that each is the same function as the one that it replaces. *)
Extract Inlined Constant Datatypes.app => "loop_app".
Extract Inlined Constant seq.cat => "loop_app".
Extract Inlined Constant Datatypes.length => "loop_length".
Extract Inlined Constant List.map => "loop_map".
Extract Inlined Constant seq.map => "loop_map".
Extract Inlined Constant List.flat_map => "loop_flat_map".
Extract Inlined Constant List.fold_right => "loop_fold_right".
Extract Inlined Constant List.concat => "loop_concat".
Extract Inlined Constant List.filter => "loop_filter".
Extract Inlined Constant List.combine => "loop_combine".
Extract Inlined Constant List.seq => "loop_seq".
Extract Inlined Constant Z.of_nat => "loop_of_nat".
Extract Inlined Constant Z.to_nat => "loop_to_nat".
Extract Inlined Constant path.sort => "loop_sort".
Extract Inlined Constant Json.Sorting.sort => "(loop_stack_sort no_later)".
Extract Inlined Constant Canonical.SortingMembers.sort => "(loop_stack_sort ByKey.leb)".
Extract Inlined Constant WorstCase.numbered => "loop_numbered".
Extract Inlined Constant Table.range => "loop_range".
Extract Inlined Constant Figures.runs => "loop_runs".
Extract Inlined Constant Figures.sums_of_two => "(loop_in_twos plus)".
Extract Inlined Constant LeftOut.aligned => "(loop_aligned (fun r -> r.who))".
Extract Inlined Constant Drawn.all_of => "loop_all_of".
Extract Inlined Constant Drawn.compared_cells => "(loop_compared context_of_cell)".

Extraction "verified.ml"
  Loops.loop_app Loops.loop_length Loops.loop_map Loops.loop_flat_map Loops.loop_concat Loops.loop_filter Loops.loop_combine Loops.loop_seq
  Loops.loop_of_nat Loops.loop_to_nat Loops.loop_sort Loops.loop_stack_sort Loops.loop_numbered Loops.loop_range Loops.loop_runs
  Loops.loop_in_twos Loops.loop_fold_right Loops.loop_aligned Loops.loop_all_of Loops.loop_compared Drawn.context_of_cell Json.no_later Canonical.ByKey.leb verified.
