(* fairaudit-lp CERTIFICATE.json [--table FILE]

   Exit codes: 0 there are claims by lp-dual and all are proved; 1 there is none, or one is not proved;
   2 malformed, not readable or wrong usage; 3 the table is not embedded and was not given. *)

let read path =
  let channel = open_in_bin path in
  Fun.protect ~finally:(fun () -> close_in_noerr channel) (fun () -> really_input_string channel (in_channel_length channel))

let lines_of path =
  let lines = String.split_on_char '\n' (read path) in
  List.filter_map (fun line -> if line = "" then None else Some (Json.parse line)) lines

let report judged =
  List.iter (fun ((c : Certificate.claim), proved) -> print_endline (c.shown ^ if proved then ": proved" else ": NOT proved")) judged;
  if judged = [] then print_endline "there is no claim by lp-dual";
  if judged <> [] && List.for_all snd judged then 0 else 1

let stop code message = prerr_endline ("fairaudit-lp: " ^ message); code

let run path table =
  try report (Certificate.judged (Json.parse (read path)) (Option.map lines_of table)) with
  | Json.Malformed what -> stop 2 ("malformed: " ^ what)
  | Certificate.Table_needed -> stop 3 "the certificate does not embed its table; give it with --table"
  | Sys_error what -> stop 2 what
  | End_of_file -> stop 2 "the file changed while it was read"
  | Stack_overflow | Out_of_memory -> stop 2 "the certificate needs more memory than there is"

let () =
  exit
    (match Array.to_list Sys.argv with
     | [ _; path ] when path <> "--table" -> run path None
     | [ _; path; "--table"; table ] | [ _; "--table"; table; path ] -> run path (Some table)
     | _ -> stop 2 "usage: fairaudit-lp CERTIFICATE.json [--table FILE]")
