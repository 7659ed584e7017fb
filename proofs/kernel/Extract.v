(* From Coq to OCaml: the checker, with Z as zarith's integers. *)

From Coq Require Import ZArith QArith Extraction ExtrOcamlBasic ExtrOcamlZBigInt.
From FairauditKernel Require Import LinearProgram WorstCase.

(* Coq's own gcd would take many steps; that of zarith is never negative either. *)
Extract Constant Z.gcd => "Big_int_Z.gcd_big_int".
Extract Constant Z.leb => "Big_int_Z.le_big_int".
Extract Constant Z.ltb => "Big_int_Z.lt_big_int".

Extraction "worst_case.ml" claim_true.
