(* The canonical text of a JSON value: sorted keys, no white space, every character beyond ASCII escaped.

   This file only computes.  [canonical] says what the text is; [canonical_onto] writes the same in reverse, without
   recursion as deep as a string or list is long. *)

From Coq Require Import ZArith List Ascii String Bool Orders Mergesort.
From FairauditChecker Require Import Json.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.
Local Open Scope char_scope.

(* ---- Strings ---- *)

Definition hexadecimal_digit (n : nibble) : ascii :=
  let '(a, b, c, d) := n in
  let least := if b then if c then if d then "7" else "6" else if d then "5" else "4" else if c then if d then "3" else "2" else if d then "1" else "0" in
  if a then
    if b then if c then if d then "f" else "e" else if d then "d" else "c" else if c then if d then "b" else "a" else if d then "9" else "8"
  else least.

Definition escaped_unit (u : unit16) : text :=
  let '(p, q, r, s) := u in ["\"; "u"; hexadecimal_digit p; hexadecimal_digit q; hexadecimal_digit r; hexadecimal_digit s].

Definition zeros : nibble := (false, false, false, false).

(* A byte that stands for a character of ASCII *)
Definition escaped_byte (c : ascii) : text :=
  if c =? quote then ["\"; quote] else if c =? "\" then ["\"; "\"] else if c =? "008" then ["\"; "b"] else if c =? "012" then ["\"; "f"]
  else if c =? "010" then ["\"; "n"] else if c =? "013" then ["\"; "r"] else if c =? "009" then ["\"; "t"]
  else if plain c && negb (c =? "127") then [c]
  else match c with Ascii h g f e d c b a => escaped_unit (zeros, zeros, (a, b, c, d), (e, f, g, h)) end.

(* 110xxxxx 10xxxxxx *)
Definition escaped_two (c d : ascii) : text :=
  match c, d with
  | Ascii c5 c4 c3 c2 c1 _ _ _, Ascii d6 d5 d4 d3 d2 d1 _ _ =>
      escaped_unit (zeros, (false, c1, c2, c3), (c4, c5, d1, d2), (d3, d4, d5, d6))
  end.

(* 1110xxxx 10xxxxxx 10xxxxxx *)
Definition escaped_three (c d e : ascii) : text :=
  match c, d, e with
  | Ascii c4 c3 c2 c1 _ _ _ _, Ascii d6 d5 d4 d3 d2 d1 _ _, Ascii e6 e5 e4 e3 e2 e1 _ _ =>
      escaped_unit ((c1, c2, c3, c4), (d1, d2, d3, d4), (d5, d6, e1, e2), (e3, e4, e5, e6))
  end.

(* 11110xxx 10xxxxxx 10xxxxxx 10xxxxxx: a surrogate pair, 2^16 taken away *)
Definition escaped_four (c d e f : ascii) : text :=
  match c, d, e, f with
  | Ascii c3 c2 c1 _ _ _ _ _, Ascii d6 d5 d4 d3 d2 d1 _ _, Ascii e6 e5 e4 e3 e2 e1 _ _, Ascii f6 f5 f4 f3 f2 f1 _ _ =>
      let '(h1, h2, h3, h4) := match c1, c2, c3, d1, d2 with
        | true, _, _, _, _ => (true, true, true, true)
        | _, a, b, c, d =>
            let d' := negb d in
            let c' := xorb c d' in
            let b' := xorb b (d' && negb c) in
            let a' := xorb a (d' && negb c && negb b) in
            (a', b', c', d')
        end in
      escaped_unit ((true, true, false, true), (true, false, h1, h2), (h3, h4, d3, d4), (d5, d6, e1, e2))
      ++ escaped_unit ((true, true, false, true), (true, true, e3, e4), (e5, e6, f1, f2), (f3, f4, f5, f6))
  end.

(* Whether a byte begins a character of two, of three, of four bytes *)
Definition begins_two (c : ascii) : bool := match c with Ascii _ _ _ _ _ false true true => true | _ => false end.
Definition begins_three (c : ascii) : bool := match c with Ascii _ _ _ _ false true true true => true | _ => false end.
Definition begins_four (c : ascii) : bool := match c with Ascii _ _ _ false true true true true => true | _ => false end.

Fixpoint escaped_onto (done s : text) : text :=
  match s with
  | [] => done
  | c :: s1 =>
      if begins_two c then match s1 with d :: s2 => escaped_onto (rev_append (escaped_two c d) done) s2 | _ => done end
      else if begins_three c then
        match s1 with d :: e :: s3 => escaped_onto (rev_append (escaped_three c d e) done) s3 | _ => done end
      else if begins_four c then
        match s1 with d :: e :: f :: s4 => escaped_onto (rev_append (escaped_four c d e f) done) s4 | _ => done end
      else escaped_onto (rev_append (escaped_byte c) done) s1
  end.

Definition string_onto (done s : text) : text := quote :: escaped_onto (quote :: done) s.

(* ---- Integers ---- *)

Fixpoint digits_onto (fuel : nat) (n : Z) (after : text) : text :=
  match fuel with
  | S fuel =>
      let (above, last) := Z.div_eucl n 10 in
      let d := ascii_of_N (48 + Z.to_N last) in
      if (above =? 0)%Z then d :: after else digits_onto fuel above (d :: after)
  | O => after
  end.
Definition decimal (n : Z) : text := digits_onto 18 n [].

(* ---- Values ---- *)

Module ByKey <: TotalLeBool.
Definition t : Type := text * json.
Definition leb (m n : t) : bool := no_later (fst m) (fst n).
Lemma leb_total (m n : t) : leb m n = true \/ leb n m = true.
Proof.
exact (ByBytes.leb_total (fst m) (fst n)).
Qed.
End ByKey.

Module SortingMembers := Sort ByKey.

Fixpoint canonical_onto (done : text) (v : json) {struct v} : text :=
  match v with
  | Null => rev_append (of_string "null") done
  | Bool true => rev_append (of_string "true") done
  | Bool false => rev_append (of_string "false") done
  | Int n => rev_append (decimal n) done
  | Text t => string_onto done t
  | Items [] => "]" :: "[" :: done
  | Items vs =>
      let fix items_onto (done : text) (between : ascii) (vs : list json) : text :=
        match vs with
        | v :: rest => items_onto (canonical_onto (between :: done) v) "," rest
        | [] => "]" :: done
        end
      in items_onto done "[" vs
  | Members ms =>
      (* the text of each member is made first, and then they are sorted by key *)
      let fix texts (ms : list (text * json)) : list (text * json) :=
        match ms with
        | (k, v) :: rest => (k, Text (canonical_onto (":" :: string_onto [] k) v)) :: texts rest
        | [] => []
        end
      in
      let fix joined (done : text) (between : ascii) (ms : list (text * json)) : text :=
        match ms with
        | (_, Text t) :: rest => joined (rev_append (rev_append t []) (between :: done)) "," rest
        | _ => "}" :: done
        end
      in match SortingMembers.sort (texts ms) with [] => "}" :: "{" :: done | sorted => joined done "{" sorted end
  end.

Definition canonical (v : json) : text := rev_append (canonical_onto [] v) [].

(* The text of a table: a line for each value, ended by a line feed *)
Fixpoint lines_onto (done : text) (vs : list json) : text :=
  match vs with v :: rest => lines_onto ("010" :: canonical_onto done v) rest | [] => done end.
Definition table_text (vs : list json) : text := rev_append (lines_onto [] vs) [].
