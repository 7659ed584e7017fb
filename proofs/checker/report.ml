(* What programs around the verified one share: a file as a list of bytes, and the outcomes as lines. *)

let bytes s =
  let rec from i rest = if i < 0 then rest else from (i - 1) (s.[i] :: rest) in
  from (String.length s - 1) []

(* Labels of a certificate stand in lines as JSON escapes them; nothing else but ASCII can be there. *)
let shown text =
  let one c = if c >= ' ' && c <= '~' then String.make 1 c else Printf.sprintf "\\x%02x" (Char.code c) in
  String.concat "" (List.rev (List.rev_map one text))

let word = function Verified.True_ -> "true" | Verified.False_ -> "FALSE" | Verified.Not_covered -> "not covered"

(* The lines, and the exit code: 0 all are true; 1 one is false; 2 malformed; 3 some are not covered, or nothing could be judged. *)
let of_files file table =
  match Verified.verified Sha256.hexadecimal (bytes file) (Option.map bytes table) with
  | Verified.Outcomes found ->
      let is outcome = List.exists (fun (_, o) -> o = outcome) found in
      let code = if is Verified.False_ then 1 else if is Verified.Not_covered then 3 else 0 in
      (List.rev (List.rev_map (fun (label, outcome) -> word outcome ^ ": " ^ shown label) found), code)
  | Verified.Malformed why -> ([ "malformed: " ^ shown why ], 2)
  | Verified.No_table -> ([ "nothing was judged: the certificate does not embed its table; give it with --table" ], 3)
  | exception (Stack_overflow | Out_of_memory) -> ([ "nothing was judged: the certificate needs more memory than there is" ], 3)
