(* A strict reader of JSON (RFC 8259), without what the format of certificates has no use for. *)

type t =
  | Null
  | Bool of bool
  | Int of int        (* at most 18 characters, and not "-0" *)
  | Other_number      (* any other number: nothing in a certificate is one *)
  | String of string  (* UTF-8; a lone surrogate, which only an escape can give, as three bytes *)
  | List of t list
  | Object of (string * t) list

exception Malformed of string

let deepest = 500

let fail at what = raise (Malformed (Printf.sprintf "%s at byte %d" what at))

(* Refuse what is not UTF-8: overlong forms, surrogates, and anything above U+10FFFF. *)
let check_utf8 s =
  let n = String.length s in
  let byte i = if i < n then Char.code s.[i] else 0 in
  let rec go i =
    if i < n then begin
      let b = byte i in
      let continued k = List.for_all (fun j -> byte (i + j) land 0xC0 = 0x80) (List.init k succ) in
      let b1 = byte (i + 1) in
      let length =
        if b < 0x80 then 1
        else if b >= 0xC2 && b <= 0xDF && continued 1 then 2
        else if b >= 0xE0 && b <= 0xEF && continued 2 && not (b = 0xE0 && b1 < 0xA0) && not (b = 0xED && b1 > 0x9F) then 3
        else if b >= 0xF0 && b <= 0xF4 && continued 3 && not (b = 0xF0 && b1 < 0x90) && not (b = 0xF4 && b1 > 0x8F) then 4
        else fail i "not UTF-8"
      in
      go (i + length)
    end
  in
  go 0

let add_utf8 buffer code =
  let add x = Buffer.add_char buffer (Char.chr x) in
  let tail shift = add (0x80 lor ((code lsr shift) land 0x3F)) in
  if code < 0x80 then add code
  else if code < 0x800 then (add (0xC0 lor (code lsr 6)); tail 0)
  else if code < 0x10000 then (add (0xE0 lor (code lsr 12)); tail 6; tail 0)
  else (add (0xF0 lor (code lsr 18)); tail 12; tail 6; tail 0)

let parse (s : string) : t =
  check_utf8 s;
  let n = String.length s in
  let pos = ref 0 in
  let peek () = if !pos < n then s.[!pos] else '\000' in
  let digit c = c >= '0' && c <= '9' in
  let rec blanks () = match peek () with ' ' | '\t' | '\n' | '\r' when !pos < n -> incr pos; blanks () | _ -> () in
  let expect c = if !pos < n && s.[!pos] = c then incr pos else fail !pos (Printf.sprintf "%C is missing" c) in
  let word w value =
    let k = String.length w in
    if !pos + k <= n && String.sub s !pos k = w then (pos := !pos + k; value) else fail !pos "no JSON value"
  in
  let hex4 () =
    if !pos + 4 > n then fail !pos "an escape is cut short";
    let value c =
      match c with
      | '0' .. '9' -> Char.code c - 48
      | 'a' .. 'f' -> Char.code c - 87
      | 'A' .. 'F' -> Char.code c - 55
      | _ -> fail !pos "an escape needs four hexadecimal digits"
    in
    let code = ref 0 in
    for i = 0 to 3 do code := (!code * 16) + value s.[!pos + i] done;
    pos := !pos + 4;
    !code
  in
  let escaped_unit buffer =
    let high = hex4 () in
    let pair =
      high >= 0xD800 && high <= 0xDBFF && !pos + 6 <= n && s.[!pos] = '\\' && s.[!pos + 1] = 'u'
      && begin
           let before = !pos in
           pos := before + 2;
           let low = hex4 () in
           if low >= 0xDC00 && low <= 0xDFFF then begin
             add_utf8 buffer (0x10000 + ((high - 0xD800) lsl 10) + (low - 0xDC00));
             true
           end
           else (pos := before; false)
         end
    in
    if not pair then add_utf8 buffer high
  in
  let text () =
    expect '"';
    let buffer = Buffer.create 16 in
    let rec go () =
      if !pos >= n then fail !pos "a string does not end";
      let c = s.[!pos] in
      incr pos;
      match c with
      | '"' -> Buffer.contents buffer
      | '\\' ->
          if !pos >= n then fail !pos "a string does not end";
          let e = s.[!pos] in
          incr pos;
          (match e with
           | '"' | '\\' | '/' -> Buffer.add_char buffer e
           | 'b' -> Buffer.add_char buffer '\b'
           | 'f' -> Buffer.add_char buffer '\012'
           | 'n' -> Buffer.add_char buffer '\n'
           | 'r' -> Buffer.add_char buffer '\r'
           | 't' -> Buffer.add_char buffer '\t'
           | 'u' -> escaped_unit buffer
           | _ -> fail (!pos - 1) "an unknown escape");
          go ()
      | c when Char.code c < 0x20 -> fail (!pos - 1) "a control character in a string"
      | c -> Buffer.add_char buffer c; go ()
    in
    go ()
  in
  let digits () =
    if not (digit (peek ())) then fail !pos "a digit is missing";
    while digit (peek ()) do incr pos done
  in
  let number () =
    let start = !pos in
    if peek () = '-' then incr pos;
    if peek () = '0' then incr pos else digits ();
    let whole = ref true in
    if peek () = '.' then (whole := false; incr pos; digits ());
    (match peek () with
     | 'e' | 'E' ->
         whole := false;
         incr pos;
         (match peek () with '+' | '-' -> incr pos | _ -> ());
         digits ()
     | _ -> ());
    let token = String.sub s start (!pos - start) in
    if !whole && String.length token <= 18 && token <> "-0" then Int (int_of_string token) else Other_number
  in
  let rec value depth =
    if depth > deepest then fail !pos "nested too deeply";
    blanks ();
    if !pos >= n then fail !pos "no JSON value";
    match s.[!pos] with
    | '{' -> incr pos; Object (members depth)
    | '[' -> incr pos; List (items depth)
    | '"' -> String (text ())
    | 't' -> word "true" (Bool true)
    | 'f' -> word "false" (Bool false)
    | 'n' -> word "null" Null
    | '-' | '0' .. '9' -> number ()
    | _ -> fail !pos "no JSON value"
  and items depth =
    blanks ();
    if peek () = ']' then (incr pos; [])
    else
      let rec go found =
        let item = value (depth + 1) in
        blanks ();
        if peek () = ',' then (incr pos; go (item :: found)) else (expect ']'; List.rev (item :: found))
      in
      go []
  and members depth =
    let seen = Hashtbl.create 8 in
    blanks ();
    if peek () = '}' then (incr pos; [])
    else
      let rec go found =
        blanks ();
        let at = !pos in
        let key = text () in
        if Hashtbl.mem seen key then fail at "a key that is there twice";
        Hashtbl.add seen key ();
        blanks ();
        expect ':';
        let item = value (depth + 1) in
        blanks ();
        if peek () = ',' then (incr pos; go ((key, item) :: found)) else (expect '}'; List.rev ((key, item) :: found))
      in
      go []
  in
  let result = value 0 in
  blanks ();
  if !pos < n then fail !pos "something follows the JSON value";
  result
