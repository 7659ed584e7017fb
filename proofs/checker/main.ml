(* fairaudit-check CERTIFICATE.json [--table FILE]: a line for each statement, true, FALSE or not covered; exit codes as in report.ml. *)

let read path =
  let channel = open_in_bin path in
  Fun.protect ~finally:(fun () -> close_in_noerr channel) (fun () -> really_input_string channel (in_channel_length channel))

let stop message = prerr_endline ("fairaudit-check: " ^ message); 2

let run path table =
  match Report.of_files (read path) (Option.map read table) with
  | [ line ], 2 -> stop line
  | lines, code -> List.iter print_endline lines; code
  | exception Sys_error what -> stop what
  | exception End_of_file -> stop "the file changed while it was read"

(* Files are lists of bytes: with the heap that OCaml begins with, most of the time would go into tidying it up. *)
let () =
  Gc.set { (Gc.get ()) with minor_heap_size = 1 lsl 20; major_heap_increment = 4 lsl 20; space_overhead = 1000; allocation_policy = 0 };
  exit
    (match Array.to_list Sys.argv with
     | [ _; path ] when path <> "--table" -> run path None
     | [ _; path; "--table"; table ] | [ _; "--table"; table; path ] -> run path (Some table)
     | _ -> stop "usage: fairaudit-check CERTIFICATE.json [--table FILE]")
