(* JSON, so far as certificates use it: what it denotes, and a program that reads it.

   The first part has to be read: the grammar, after RFC 8259.  It has integers of at most
   18 digits as its only numbers, no object with a repeated key, and strings as the bytes
   of their UTF-8; a lone surrogate, which only an escape can give, as three bytes.
   JsonSound.v proves that [parse] gives what the bytes denote, and that they denote one
   value at most.  The program goes through the bytes once, whatever they are, with what is
   open on a list of its own. *)

From Coq Require Import ZArith List Ascii String Bool Orders Mergesort.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.
Local Open Scope char_scope.

Definition text : Type := list ascii.

Inductive json :=
| Null
| Bool (b : bool)
| Int (n : Z)
| Text (t : text)
| Items (vs : list json)
| Members (ms : list (text * json)).

Notation "c =? d" := (Ascii.eqb c d) : char_scope.

Fixpoint same (s t : text) : bool :=
  match s, t with
  | c :: s', d :: t' => (c =? d) && same s' t'
  | [], [] => true
  | _, _ => false
  end.

Definition of_string : string -> text := list_ascii_of_string.
Definition quote : ascii := """".

(* ==== What bytes denote (this part has to be read) ==== *)

Definition blank (c : ascii) : bool := (c =? " ") || (c =? "009") || (c =? "010") || (c =? "013").

(* ---- Integers ---- *)

Definition digit (c : ascii) : option Z :=
  if c =? "0" then Some 0%Z else if c =? "1" then Some 1%Z else if c =? "2" then Some 2%Z else if c =? "3" then Some 3%Z
  else if c =? "4" then Some 4%Z else if c =? "5" then Some 5%Z else if c =? "6" then Some 6%Z else if c =? "7" then Some 7%Z
  else if c =? "8" then Some 8%Z else if c =? "9" then Some 9%Z else None.

Definition is_digit (c : ascii) : bool := match digit c with Some _ => true | None => false end.

(* The number that digits write after those of n *)
Fixpoint written (n : Z) (s : text) : option Z :=
  match s with
  | c :: rest => match digit c with Some d => written (10 * n + d) rest | None => None end
  | [] => Some n
  end.

(* At least one digit, and no needless zero *)
Definition natural (s : text) : option Z :=
  match s with
  | [] => None
  | c :: _ :: _ => if c =? "0" then None else written 0 s
  | _ => written 0 s
  end.

Fixpoint at_most (n : nat) (s : text) : bool :=
  match s, n with [], _ => true | _ :: rest, S m => at_most m rest | _ :: _, O => false end.

Definition integer (s : text) : option Z := if at_most 18 s then natural s else None.

(* ---- Strings ---- *)

(* Four bits, the highest first *)
Definition nibble : Type := bool * bool * bool * bool.

Definition hexadecimal : list (ascii * nibble) :=
  [("0", (false, false, false, false)); ("1", (false, false, false, true)); ("2", (false, false, true, false)); ("3", (false, false, true, true));
   ("4", (false, true, false, false)); ("5", (false, true, false, true)); ("6", (false, true, true, false)); ("7", (false, true, true, true));
   ("8", (true, false, false, false)); ("9", (true, false, false, true)); ("a", (true, false, true, false)); ("b", (true, false, true, true));
   ("c", (true, true, false, false)); ("d", (true, true, false, true)); ("e", (true, true, true, false)); ("f", (true, true, true, true));
   ("A", (true, false, true, false)); ("B", (true, false, true, true)); ("C", (true, true, false, false)); ("D", (true, true, false, true));
   ("E", (true, true, true, false)); ("F", (true, true, true, true))].

Fixpoint looked_up {T : Type} (c : ascii) (of : list (ascii * T)) : option T :=
  match of with (d, x) :: rest => if c =? d then Some x else looked_up c rest | [] => None end.

(* A unit of UTF-16, as four nibbles *)
Definition unit16 : Type := nibble * nibble * nibble * nibble.

Definition hex4 (a b c d : ascii) : option unit16 :=
  match looked_up a hexadecimal, looked_up b hexadecimal, looked_up c hexadecimal, looked_up d hexadecimal with
  | Some p, Some q, Some r, Some s => Some (p, q, r, s)
  | _, _, _, _ => None
  end.

(* D800 to DBFF and DC00 to DFFF, the halves of surrogate pairs *)
Definition is_high (u : unit16) : bool :=
  match u with ((true, true, false, true), (true, false, _, _), _, _) => true | _ => false end.
Definition is_low (u : unit16) : bool :=
  match u with ((true, true, false, true), (true, true, _, _), _, _) => true | _ => false end.

(* A byte by its bits, the highest first *)
Definition byte (a b c d e f g h : bool) : ascii := Ascii h g f e d c b a.

(* The UTF-8 of U+0000 to U+FFFF: 0xxxxxxx; 110xxxxx 10xxxxxx; 1110xxxx 10xxxxxx 10xxxxxx *)
Definition utf8_of_unit (u : unit16) : text :=
  let '((p1, p2, p3, p4), (q1, q2, q3, q4), (r1, r2, r3, r4), (s1, s2, s3, s4)) := u in
  if p1 || p2 || p3 || p4 || q1 then
    [byte true true true false p1 p2 p3 p4; byte true false q1 q2 q3 q4 r1 r2; byte true false r3 r4 s1 s2 s3 s4]
  else if q2 || q3 || q4 || r1 then [byte true true false q2 q3 q4 r1 r2; byte true false r3 r4 s1 s2 s3 s4]
  else [byte false r2 r3 r4 s1 s2 s3 s4].

(* The UTF-8 of a surrogate pair, 11110xxx 10xxxxxx 10xxxxxx 10xxxxxx: 2^16 is added to the ten bits and ten bits of the halves *)
Definition utf8_of_pair (high low : unit16) : text :=
  let '(_, (_, _, a, b), (c, d, e, f), (g, h, i, j)) := high in
  let '(_, (_, _, k, l), (m, n, o, p), (q, r, s, t)) := low in
  let d' := negb d in
  let c' := xorb c d in
  let b' := xorb b (c && d) in
  let a' := xorb a (b && c && d) in
  let carry := a && b && c && d in
  [byte true true true true false carry a' b'; byte true false c' d' e f g h;
   byte true false i j k l m n; byte true false o p q r s t].

Definition follows (c : ascii) : bool := match c with Ascii _ _ _ _ _ _ false true => true | _ => false end.

(* The lengths of the characters of more than one byte that UTF-8 has: no overlong form, no surrogate, nothing above U+10FFFF *)
Definition two_bytes (a b : ascii) : bool :=
  follows b && match a with Ascii _ a1 a2 a3 a4 false true true => a1 || a2 || a3 || a4 | _ => false end.

Definition three_bytes (a b c : ascii) : bool :=
  follows b && follows c
  && match a, b with
     | Ascii false false false false false true true true, Ascii _ _ _ _ _ high _ _ => high
     | Ascii true false true true false true true true, Ascii _ _ _ _ _ high _ _ => negb high
     | Ascii _ _ _ _ false true true true, _ => true
     | _, _ => false
     end.

Definition four_bytes (a b c d : ascii) : bool :=
  follows b && follows c && follows d
  && match a, b with
     | Ascii false false false false true true true true, Ascii _ _ _ _ low high _ _ => low || high
     | Ascii false false true false true true true true, Ascii _ _ _ _ low high _ _ => negb (low || high)
     | Ascii _ _ false false true true true true, _ => true
     | Ascii _ _ _ _ _ _ _ _, _ => false
     end.

(* A byte that stands for itself in a string *)
Definition plain (c : ascii) : bool :=
  match c with
  | Ascii _ _ _ _ _ _ _ true => false
  | Ascii _ _ _ _ _ false false _ => false
  | _ => negb (c =? quote) && negb (c =? "\")
  end.

Definition short_escapes : list (ascii * ascii) :=
  [(quote, quote); ("\", "\"); ("/", "/"); ("b", "008"); ("f", "012"); ("n", "010"); ("r", "013"); ("t", "009")].

Definition begins_with_low (s : text) : bool :=
  match s with
  | x :: y :: a :: b :: c :: d :: _ =>
      (x =? "\") && (y =? "u") && match hex4 a b c d with Some u => is_low u | None => false end
  | _ => false
  end.

(* [spells s t]: between its quotes, s is written for the string t *)
Inductive spells : text -> text -> Prop :=
| spells_nothing : spells [] []
| spells_plain c s t : plain c = true -> spells s t -> spells (c :: s) (c :: t)
| spells_two a b s t : two_bytes a b = true -> spells s t -> spells (a :: b :: s) (a :: b :: t)
| spells_three a b c s t : three_bytes a b c = true -> spells s t -> spells (a :: b :: c :: s) (a :: b :: c :: t)
| spells_four a b c d s t : four_bytes a b c d = true -> spells s t -> spells (a :: b :: c :: d :: s) (a :: b :: c :: d :: t)
| spells_short e c s t : looked_up e short_escapes = Some c -> spells s t -> spells ("\" :: e :: s) (c :: t)
| spells_unit a b c d u s t : hex4 a b c d = Some u -> is_high u && begins_with_low s = false -> spells s t ->
    spells ("\" :: "u" :: a :: b :: c :: d :: s) (utf8_of_unit u ++ t)
| spells_pair a b c d high a' b' c' d' low s t :
    hex4 a b c d = Some high -> is_high high = true -> hex4 a' b' c' d' = Some low -> is_low low = true -> spells s t ->
    spells ("\" :: "u" :: a :: b :: c :: d :: "\" :: "u" :: a' :: b' :: c' :: d' :: s) (utf8_of_pair high low ++ t).

(* ---- Values ---- *)

Definition blanks (s : text) : Prop := forallb blank s = true.
Definition quoted (s : text) : text := quote :: s ++ [quote].

Inductive value : text -> json -> Prop :=
| value_null : value (of_string "null") Null
| value_true : value (of_string "true") (Bool true)
| value_false : value (of_string "false") (Bool false)
| value_int s n : integer s = Some n -> value s (Int n)
| value_text s t : spells s t -> value (quoted s) (Text t)
| value_no_items w : blanks w -> value ("[" :: w ++ ["]"]) (Items [])
| value_items s vs : items s vs -> value ("[" :: s ++ ["]"]) (Items vs)
| value_no_members w : blanks w -> value ("{" :: w ++ ["}"]) (Members [])
| value_members s ms : members s ms -> NoDup (map fst ms) -> value ("{" :: s ++ ["}"]) (Members ms)
with element : text -> json -> Prop :=
| element_of w s w' v : blanks w -> blanks w' -> value s v -> element (w ++ s ++ w') v
with items : text -> list json -> Prop :=
| items_one s v : element s v -> items s [v]
| items_more s vs t v : items s vs -> element t v -> items (s ++ "," :: t) (vs ++ [v])
with member : text -> text -> json -> Prop :=
| member_of w s w' k t v : blanks w -> blanks w' -> spells s k -> element t v -> member (w ++ quoted s ++ w' ++ ":" :: t) k v
with members : text -> list (text * json) -> Prop :=
| members_one s k v : member s k v -> members s [(k, v)]
| members_more s ms t k v : members s ms -> member t k v -> members (s ++ "," :: t) (ms ++ [(k, v)]).

(* A whole file *)
Definition denotes (s : text) (v : json) : Prop := element s v.

(* ==== The program ==== *)

(* ---- Strings ---- *)

(* What is spelled, after what has been read of it (in reverse) *)
Fixpoint decoded (read : text) (s : text) : option text :=
  match s with
  | [] => Some (rev_append read [])
  | c :: s1 =>
      if plain c then decoded (c :: read) s1
      else match s1 with
      | [] => None
      | e :: s2 =>
          if negb (c =? "\") then
            if two_bytes c e then decoded (e :: c :: read) s2
            else match s2 with
            | [] => None
            | f :: s3 =>
                if three_bytes c e f then decoded (f :: e :: c :: read) s3
                else match s3 with
                | [] => None
                | g :: s4 => if four_bytes c e f g then decoded (g :: f :: e :: c :: read) s4 else None
                end
            end
          else if e =? "u" then
            match s2 with
            | a :: b :: c :: d :: s3 =>
                match hex4 a b c d with
                | None => None
                | Some u =>
                    if is_high u && begins_with_low s3 then
                      match s3 with
                      | _ :: _ :: a' :: b' :: c' :: d' :: s4 =>
                          match hex4 a' b' c' d' with
                          | Some low => decoded (rev_append (utf8_of_pair u low) read) s4
                          | None => None
                          end
                      | _ => None
                      end
                    else decoded (rev_append (utf8_of_unit u) read) s3
                end
            | _ => None
            end
          else match looked_up e short_escapes with Some d => decoded (d :: read) s2 | None => None end
      end
  end.

(* ---- Keys that differ ---- *)

Fixpoint no_later (s t : text) : bool :=
  match s, t with
  | c :: s', d :: t' => match Ascii.compare c d with Lt => true | Eq => no_later s' t' | Gt => false end
  | [], _ => true
  | _, [] => false
  end.

Module ByBytes <: TotalLeBool.
Definition t := text.
Definition leb := no_later.
Lemma leb_total (s t : text) : no_later s t = true \/ no_later t s = true.
Proof.
revert t; induction s as [|c s IH]; intros [|d t]; simpl; auto.
rewrite (Ascii.compare_antisym d c); destruct (Ascii.compare c d); simpl; auto.
Qed.
End ByBytes.

Module Sorting := Sort ByBytes.

Fixpoint neighbours_differ (ts : list text) : bool :=
  match ts with s :: ((t :: _) as rest) => negb (same s t) && neighbours_differ rest | _ => true end.

Definition distinct (ts : list text) : bool := neighbours_differ (Sorting.sort ts).

(* ---- Values ---- *)

(* What is open around a value: lists and objects, with what they have before it (in reverse) *)
Inductive inside := InItems (before : list json) | InMembers (before : list (text * json)) (key : text).

Inductive mode :=
| Awaiting (may_end : bool)                           (* a value, or the end of a list that has none yet *)
| Naming (before : list (text * json)) (may_end : bool) (* a key after those members, or the end of an object that has none yet *)
| Named (before : list (text * json)) (key : text)    (* the colon *)
| Spelling (key_after : option (list (text * json))) (escaped : bool) (raw : text)  (* the rest of a string, which is a key or a value *)
| Counting (digits : text)                            (* perhaps further digits *)
| Word (rest : text) (v : json)                       (* the rest of null, true or false *)
| Ended (v : json).                                   (* what follows a value *)

Definition state : Type := mode * list inside.

Definition after (c : ascii) (v : json) (stack : list inside) : option state :=
  if blank c then Some (Ended v, stack)
  else match stack with
  | InItems vs :: outer =>
      if c =? "," then Some (Awaiting false, InItems (v :: vs) :: outer)
      else if c =? "]" then Some (Ended (Items (rev_append vs [v])), outer)
      else None
  | InMembers ms k :: outer =>
      if c =? "," then Some (Naming ((k, v) :: ms) false, outer)
      else if c =? "}" then
        let all := rev_append ms [(k, v)] in
        if distinct (map fst all) then Some (Ended (Members all), outer) else None
      else None
  | [] => None
  end.

Definition begun (c : ascii) (may_end : bool) (stack : list inside) : option state :=
  if blank c then Some (Awaiting may_end, stack)
  else if c =? quote then Some (Spelling None false [], stack)
  else if is_digit c then Some (Counting [c], stack)
  else if c =? "[" then Some (Awaiting true, InItems [] :: stack)
  else if c =? "{" then Some (Naming [] true, stack)
  else if c =? "n" then Some (Word (of_string "ull") Null, stack)
  else if c =? "t" then Some (Word (of_string "rue") (Bool true), stack)
  else if c =? "f" then Some (Word (of_string "alse") (Bool false), stack)
  else if (c =? "]") && may_end then
    match stack with InItems [] :: outer => Some (Ended (Items []), outer) | _ => None end
  else None.

Definition step (c : ascii) (m : mode) (stack : list inside) : option state :=
  match m with
  | Awaiting may_end => begun c may_end stack
  | Naming ms may_end =>
      if blank c then Some (Naming ms may_end, stack)
      else if c =? quote then Some (Spelling (Some ms) false [], stack)
      else if (c =? "}") && may_end then Some (Ended (Members []), stack)
      else None
  | Named ms k =>
      if blank c then Some (Named ms k, stack)
      else if c =? ":" then Some (Awaiting false, InMembers ms k :: stack)
      else None
  | Spelling to true raw => Some (Spelling to false (c :: raw), stack)
  | Spelling to false raw =>
      if c =? quote then
        match decoded [] (rev_append raw []), to with
        | Some t, None => Some (Ended (Text t), stack)
        | Some k, Some ms => Some (Named ms k, stack)
        | None, _ => None
        end
      else Some (Spelling to (c =? "\") (c :: raw), stack)
  | Counting ds =>
      if is_digit c then Some (Counting (c :: ds), stack)
      else match integer (rev_append ds []) with Some n => after c (Int n) stack | None => None end
  | Word (d :: rest) v => if c =? d then Some (match rest with [] => Ended v | _ => Word rest v end, stack) else None
  | Word [] _ => None
  | Ended v => after c v stack
  end.

Definition finished (m : mode) (stack : list inside) : option json :=
  match m, stack with
  | Ended v, [] => Some v
  | Counting ds, [] => option_map Int (integer (rev_append ds []))
  | _, _ => None
  end.

Fixpoint run (m : mode) (stack : list inside) (s : text) : option json :=
  match s with
  | [] => finished m stack
  | c :: rest => match step c m stack with Some (m', stack') => run m' stack' rest | None => None end
  end.

Definition parse (s : text) : option json := run (Awaiting false) [] s.
