(* From Coq to OCaml: the checker of certificates, with Z as zarith's integers and ascii as char. *)

From Coq Require Import ZArith QArith Extraction ExtrOcamlBasic ExtrOcamlZBigInt ExtrOcamlChar.
From FairauditChecker Require Import Certificate.

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

Extraction "verified.ml" verified.
