(* In JavaScript: the first line is the exit code, the others are those of report.ml. *)

external provide : (string -> string) -> unit = "fairaudit_provide"

let () = provide (fun file -> let lines, code = Report.of_files file None in String.concat "\n" (string_of_int code :: lines))
