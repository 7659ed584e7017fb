(* From JSON to the types of the format: a value of the wrong type is refused where it is read.

   This file only computes.  It follows docs/certificate.md, "Numbers and labels"; ReadingSound.v
   proves that rationals are read as they are written. *)

From Coq Require Import ZArith QArith List Ascii String.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditChecker Require Import Json.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.
Local Open Scope char_scope.

(* What is read, or why it cannot be *)
Inductive read (A : Type) := Good (a : A) | Bad (why : text).
Arguments Bad {A} why.

Definition bound {A B} (r : read A) (f : A -> read B) : read B := match r with Good a => f a | Bad why => Bad why end.
Notation "'let*' x := r 'in' f" := (bound r (fun x => f)) (at level 200, x pattern, r at level 100, f at level 200).

Definition bad {A} (why : string) : read A := Bad (of_string why).
Definition demand {A} (b : bool) (why : string) (r : read A) : read A := if b then r else bad why.

(* Where something is wrong *)
Definition at_place {A} (place : text) (r : read A) : read A :=
  match r with Good a => Good a | Bad why => Bad (place ++ " " :: why) end.

(* All of a list, and each with its number; both without recursion as deep as the list is long *)
Fixpoint each_onto {A B} (f : A -> read B) (done : list B) (xs : list A) : read (list B) :=
  match xs with
  | x :: rest => match f x with Good y => each_onto f (y :: done) rest | Bad why => Bad why end
  | [] => Good (rev_append done [])
  end.
Definition each {A B} (f : A -> read B) (xs : list A) : read (list B) := each_onto f [] xs.

Definition option_of {A} (f : json -> read A) (v : json) : read (option A) :=
  match v with Null => Good None | _ => let* a := f v in Good (Some a) end.

(* ---- Objects and lists ---- *)

Definition object_of (v : json) : read (list (text * json)) := match v with Members ms => Good ms | _ => bad "must be an object" end.
Definition list_of (v : json) : read (list json) := match v with Items vs => Good vs | _ => bad "must be a list" end.

Fixpoint found (k : text) (ms : list (text * json)) : option json :=
  match ms with m :: rest => if same k m.1 then Some m.2 else found k rest | [] => None end.

Definition has (k : text) (ms : list (text * json)) : bool := if found k ms is Some _ then true else false.
Definition among (ks : list text) (k : text) : bool := existsb (same k) ks.

(* An object with all of some keys, perhaps some of others, and no further ones *)
Definition fields (keys optional : list text) (v : json) : read (list (text * json)) :=
  let* ms := object_of v in
  demand (forallb (fun k => has k ms) keys) "lacks a key"
    (demand (forallb (fun m => among keys m.1 || among optional m.1) ms) "has an unknown key" (Good ms)).

Definition get {A} (f : json -> read A) (k : text) (ms : list (text * json)) : read A :=
  match found k ms with Some v => at_place k (f v) | None => bad "lacks a key" end.

Definition many {A} (f : json -> read A) (v : json) : read (list A) := let* vs := list_of v in each f vs.

Definition of_length {A} (n : Z) (xs : list A) : bool := (Z.of_nat (List.length xs) =? n)%Z.

Definition so_many {A} (n : Z) (f : json -> read A) (v : json) : read (list A) :=
  let* vs := list_of v in demand (of_length n vs) "has another length" (each f vs).

(* ---- Strings, integers, truth values ---- *)

(* A lone surrogate is written with the bytes ED A0 80 to ED BF BF, which nothing else has. *)
Fixpoint has_surrogate (s : text) : bool :=
  match s with
  | c :: ((d :: _) as rest) =>
      ((c =? "237") && match d with Ascii _ _ _ _ _ high _ _ => high end) || has_surrogate rest
  | _ => false
  end.

Definition string_of (v : json) : read text :=
  match v with Text t => demand (~~ has_surrogate t) "holds a lone surrogate" (Good t) | _ => bad "must be a string" end.

Definition integer_of (v : json) : read Z := match v with Int n => Good n | _ => bad "must be an integer" end.
Definition below (n : Z) (v : json) : read Z :=
  let* i := integer_of v in demand (i <? n)%Z "is out of range" (Good i).
Definition boolean_of (v : json) : read bool := match v with Bool b => Good b | _ => bad "must be true or false" end.

Fixpoint chosen {A} (choices : list (text * A)) (t : text) : read A :=
  match choices with (k, a) :: rest => if same k t then Good a else chosen rest t | [] => bad "is not one of those that there are" end.
Definition choice {A} (choices : list (text * A)) (v : json) : read A := let* t := string_of v in chosen choices t.

Definition distinct_ones (ts : list text) : bool := distinct ts.

(* Lists of labels are different if they are written differently, one after the other with their lengths told apart by quotes. *)
Definition spelled_out (ls : list text) : text := flat_map (fun l => flat_map (fun c => if c =? "," then [","; ","] else [c]) l ++ [","; "."]) ls.

Definition distinct_strings (v : json) : read (list text) :=
  let* ts := many string_of v in
  demand (match ts with [] => false | _ => true end) "must not be empty" (demand (distinct ts) "lists something twice" (Good ts)).

Definition label_lists (width : Z) (v : json) : read (list (list text)) :=
  let* ls := many (so_many width string_of) v in
  demand (match ls with [] => false | _ => true end) "must not be empty"
    (demand (distinct (map spelled_out ls)) "lists something twice" (Good ls)).

Definition hexadecimal_of (n : nat) (upper : bool) (v : json) : read text :=
  let* t := string_of v in
  let digit c := match looked_up c hexadecimal with
    | Some _ => upper || match c with Ascii _ _ _ _ _ lower _ _ => lower end
    | None => false end in
  demand (at_most n t && of_length (Z.of_nat n) t && forallb digit t) "must be hexadecimal digits" (Good t).

Definition digest_of : json -> read text := hexadecimal_of 64 false.

(* ---- Rationals ---- *)

(* Whether at most 100,000 digits stand there *)
Fixpoint short_enough (n : Z) (s : text) : bool :=
  match s with _ :: rest => if (n <=? 0)%Z then false else short_enough (n - 1) rest | [] => true end.
Definition digits_of (s : text) : option Z := if short_enough 100000 s then natural s else None.

(* The same in less time than the square of the length: pieces of 16 digits, each with the power of ten that is to multiply what stands
   before it, are together with pieces that are as long.  Of the list the i-th has together 2^i pieces, or is none; the first are the last. *)
Definition piece : Type := Z * Z.
Definition join (a b : piece) : piece := ((a.1 * b.2 + b.1)%Z, (a.2 * b.2)%Z).

Fixpoint pushed (a : piece) (before : list (option piece)) : list (option piece) :=
  match before with
  | Some b :: rest => None :: pushed (join b a) rest
  | None :: rest => Some a :: rest
  | [] => [Some a]
  end.

Fixpoint together (before : list (option piece)) : piece :=
  match before with Some b :: rest => join (together rest) b | None :: rest => together rest | [] => (0, 1)%Z end.

Fixpoint in_pieces (before : list (option piece)) (a : piece) (more : nat) (s : text) : option Z :=
  match s with
  | c :: rest =>
      match digit c, more with
      | Some d, S more => in_pieces before (10 * a.1 + d, 10 * a.2)%Z more rest
      | Some d, O => in_pieces (pushed a before) (d, 10%Z) 15 rest
      | None, _ => None
      end
  | [] => Some (together (pushed a before)).1
  end.

Definition natural_read (s : text) : option Z :=
  match s with
  | [] => None
  | c :: _ :: _ => if c =? "0" then None else in_pieces [] (0, 1)%Z 16 s
  | _ => in_pieces [] (0, 1)%Z 16 s
  end.
Definition digits_read (s : text) : option Z := if short_enough 100000 s then natural_read s else None.

(* What stands before the first of a character (in reverse), and after it, if there is one *)
Fixpoint cut (at_ : ascii) (before s : text) : text * option text :=
  match s with
  | c :: rest => if c =? at_ then (rev_append before [], Some rest) else cut at_ (c :: before) rest
  | [] => (rev_append before [], None)
  end.

Definition unsigned (s : text) : option Q :=
  match cut "/" [] s with
  | (above, None) => match digits_read above with Some n => Some (Qmake n 1) | None => None end
  | (above, Some below) =>
      match digits_read above, digits_read below with
      | Some n, Some (Zpos d) => if negb (Pos.eqb d 1) && (Z.gcd n (Zpos d) =? 1)%Z then Some (Qmake n d) else None
      | _, _ => None
      end
  end.

Definition rational (s : text) : option Q :=
  match s with
  | [] => None
  | c :: rest =>
      if c =? "-" then
        match unsigned rest with
        | Some q => if (Qnum q =? 0)%Z then None else Some (Qmake (Z.opp (Qnum q)) (Qden q))
        | None => None
        end
      else unsigned s
  end.

Definition rational_of (v : json) : read Q :=
  match v with
  | Text t => match rational t with Some q => Good q | None => bad "must be a rational in lowest terms" end
  | _ => bad "must be a rational, a string" end.

Definition not_negative (v : json) : read Q :=
  let* q := rational_of v in demand (0 <=? Qnum q)%Z "must not be negative" (Good q).

Definition inf : text := of_string "inf".

(* A rational, or infinity *)
Definition extended_of (v : json) : read (option Q) :=
  match v with Text t => if same t inf then Good None else let* q := rational_of v in Good (Some q) | _ => bad "must be a rational, a string" end.

(* ---- Numbers of labels ---- *)

Fixpoint same_labels (ls ms : list text) : bool :=
  match ls, ms with
  | l :: ls, m :: ms => same l m && same_labels ls ms
  | [], [] => true
  | _, _ => false
  end.

(* The number of the first that is so; [missing] if there is none *)
Definition missing : Z := -2.
Fixpoint position_from {A} (n : Z) (is_it : A -> bool) (xs : list A) : Z :=
  match xs with x :: rest => if is_it x then n else position_from (n + 1) is_it rest | [] => missing end.
Definition position {A} : (A -> bool) -> list A -> Z := position_from 0.
