(* Whether bets on the contrast of two groups within a unit prove an interval of a ratio.

   This file only computes; BetsSound.v proves that what is won is never more than the bets have won, and BetsHold.v what follows.  It
   follows docs/certificate-samples.md, region "paired".  What is won is a number of at least m 2^e, with 128 bits of m, every step rounded
   down; each step is that of the page, so that all who compute it come to the same number. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool seq path.
From FairauditKernel Require Import Fractions.
From FairauditKernel Require WorstCase.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* ---- Numbers that are rounded down ---- *)

Definition wealth : Type := Z * Z. (* (m, e): at least m 2^e *)

Definition kept : Z := 128. (* bits *)
Definition bits (m : Z) : Z := if m <=? 0 then 0 else Z.log2 m + 1.

Definition trimmed (w : wealth) : wealth :=
  let cut := bits w.1 - kept in if 0 <? cut then (Z.shiftr w.1 cut, w.2 + cut) else w.

Definition quotient (above below : Z) : wealth :=
  let shift := Z.max 0 (kept + bits below - bits above) in trimmed (Z.shiftl above shift / below, - shift).

Definition product (v w : wealth) : wealth := trimmed (v.1 * w.1, v.2 + w.2).

(* Digits of the exponent from the first on *)
Fixpoint raised (w : wealth) (n : positive) : wealth :=
  match n with
  | xH => product (1, 0) w
  | xO n => let v := raised w n in product v v
  | xI n => let v := raised w n in product (product v v) w
  end.
Definition to_the (w : wealth) (n : Z) : wealth := match n with Zpos n => raised w n | _ => (1, 0) end.

Definition greatest_bit (ws : list wealth) : option Z :=
  fold_left (fun t w => if w.1 =? 0 then t else let b := bits w.1 + w.2 in Some (match t with Some t => Z.max t b | None => b end)) ws None.

Definition total (ws : list wealth) : wealth :=
  let least := match greatest_bit ws with Some t => t | None => 0 end - 2 * kept in
  trimmed (fold_left (fun s w => s + Z.shiftl w.1 (w.2 - least)) ws 0, least).

Definition mean (ws : list wealth) : wealth :=
  let (m, e) := total ws in (Z.shiftl m kept / Z.of_nat (length ws), e - kept).

(* At least 1/level *)
Definition reaches (w : wealth) (level : Q) : bool :=
  let m := w.1 * Qnum level in
  let d := Zpos (Qden level) in
  let excess := bits m + w.2 - bits d in
  if (excess =? 0) || (excess =? 1) then (if 0 <=? w.2 then d <=? Z.shiftl m w.2 else Z.shiftl d (- w.2) <=? m)
  else (0 <? m) && (0 <? excess).

(* ---- Contrasts, and what bets on them win ---- *)

(* So many units got so much in the higher and in the lower group, as parts of the range; the place is that of the first of them. *)
Record contrast := Contrast { number : Z; higher : Q; lower : Q; at_place : Z }.

Definition count (cs : list contrast) : Z := fold_left (fun n c => n + number c) cs 0.

Definition half : Q := Qmake 1 2.
Definition spread : Q := Qmake 24 1.

(* The bets a, b, a/2, b/2, ..., up to the first one whose square times 2n is not more than 24 *)
Fixpoint bets_from (most : nat) (a b : Q) (n : Z) : list Q :=
  match most with
  | S most => a :: if at_most (times (times a a) (Qmake (2 * n) 1)) spread then [] else bets_from most b (times a half) n
  | O => [a]
  end.
Definition bets_for (n : Z) : list Q := bets_from (Z.to_nat (bits n + 4)) (Qmake 15 16) (Qmake 2 3) n.

(* 1 + bet (limit y - x) over one denominator *)
Definition factor (limit bet : Q) (c : contrast) : wealth :=
  let '(a, b) := (Qnum limit, Zpos (Qden limit)) in
  let '(p, q) := (Qnum (higher c), Zpos (Qden (higher c))) in
  let '(u, v) := (Qnum (lower c), Zpos (Qden (lower c))) in
  let below := Zpos (Qden bet) * b * q * v in
  quotient (below + Qnum bet * (a * u * q - p * b * v)) below.

Definition won (limit : Q) (cs : list contrast) (bet : Q) : wealth :=
  fold_left (fun w c => product w (to_the (factor limit bet c) (number c))) cs (1, 0).

Definition is_part (q : Q) : bool := nonnegative q && at_most q one.

Definition wealth_of (limit : Q) (cs : list contrast) : wealth :=
  if nonnegative limit && forallb (fun c => is_part (higher c) && is_part (lower c)) cs then mean (map (won limit cs) (bets_for (count cs)))
  else (0, 0).

(* ---- Equal contrasts are one, at the place of the first of them ---- *)

Fixpoint no_later (a b : list Z) : bool :=
  match a, b with x :: a, y :: b => if x =? y then no_later a b else x <? y | _, _ => true end.

Definition two_of (c : contrast) : list Z := [Qnum (higher c); Zpos (Qden (higher c)); Qnum (lower c); Zpos (Qden (lower c))].
Definition alike (c d : contrast) : bool := equal (higher c) (higher d) && equal (lower c) (lower d).

Fixpoint merged_onto (done cs : list contrast) : list contrast :=
  match cs with
  | c :: rest =>
      match done with
      | d :: before => if alike d c then merged_onto (Contrast (number d + number c) (higher d) (lower d) (at_place d) :: before) rest
                       else merged_onto (c :: done) rest
      | [] => merged_onto [c] rest
      end
  | [] => done
  end.
Definition merged (cs : list contrast) : list contrast := merged_onto [] (sort (fun c d => no_later (two_of c) (two_of d)) cs).
Definition in_order (cs : list contrast) : list contrast := sort (fun c d => at_place c <=? at_place d) cs.

(* ---- The units of a context ---- *)

Definition profile : Type := list (option Q). (* what a unit got in each group, none where it was not seen *)
Definition entry : Type := Z * profile.        (* so many units *)

Definition got (k : nat) (e : entry) : option Q := List.nth k e.2 None.
Definition as_parts (top : Q) (e : entry) : entry := (e.1, map (option_map (fun q => times q (inverse top))) e.2).

(* What is missing is the most in the first group and the least in the second, unless units that miss one are dropped. *)
Definition contrast_of (drop : bool) (k l : nat) (i : Z) (e : entry) : list contrast :=
  match got k e, got l e with
  | Some x, Some y => [Contrast e.1 x y i]
  | x, y => if drop then [] else [Contrast e.1 (match x with Some x => x | None => one end) (match y with Some y => y | None => zero end) i]
  end.

Definition contrasts_of (drop : bool) (es : list entry) (kl : nat * nat) : list contrast :=
  in_order (merged (flat_map (fun ie : Z * entry => contrast_of drop kl.1 kl.2 ie.1 ie.2) (WorstCase.numbered 0 es))).

Definition ordered_pairs (n : nat) : list (nat * nat) :=
  flat_map (fun k => flat_map (fun l => if Nat.eqb k l then [] else [(k, l)]) (List.seq 0 n)) (List.seq 0 n).

(* A context: the greatest utility there, and of each group how often each value was drawn *)
Record context := Context { top : Q; drawn : list (list (Q * Z)) }.

(* The contrasts of all ordered pairs of groups of a context *)
Definition pairs_of (drop : bool) (x : context) (es : list entry) : list (list contrast) :=
  let parts := map (as_parts (top x)) es in
  map (fun kl => if positive_fraction (top x) then contrasts_of drop parts kl else []) (ordered_pairs (length (drawn x))).

(* ---- Units have the values that the table counts ---- *)

Definition tally (qs : list (Q * Z)) : list contrast := merged (map (fun qn : Q * Z => Contrast qn.2 qn.1 zero 0) qs).
Fixpoint same_tally (cs ds : list contrast) : bool :=
  match cs, ds with
  | c :: cs, d :: ds => [&& number c =? number d, alike c d & same_tally cs ds]
  | [], [] => true
  | _, _ => false
  end.

Definition are_drawn (x : context) (es : list entry) : bool :=
  let n := length (drawn x) in
  forallb (fun e : entry => (0 <? e.1) && Nat.eqb (length e.2) n) es
  && forallb (fun kd => same_tally (tally (flat_map (fun e : entry => match got kd.1 e with Some q => [(q, e.1)] | None => [] end) es))
                                   (tally (filter (fun qn : Q * Z => ~~ (qn.2 =? 0)) kd.2)))
       (combine (List.seq 0 n) (drawn x)).

(* ---- The interval ---- *)

Record units := Units {
  confidence : Q;
  each : bool;                   (* "ends" is "each" *)
  independent : bool;
  upper_level : Q;               (* "levels" *)
  lower_level : Q;
  drop : bool;                   (* "missing" is "drop" *)
  limits : option (Q * Q);       (* the declared range of the utility *)
  rows : option (list (list (Z * list Z))); (* of units with several rows in a group: of each group, how many have how many rows of each decision *)
  profiles : list (list entry);
  are_named : bool;              (* The header of the table names their digest. *)
  least : Q;                     (* R_lo *)
  most : option Q                (* R_hi; none: infinite *)
}.

Definition same_number (q r : Q) : bool := at_most q r && at_most r q.
Definition share (i : units) : Q := times (plus one (minus (confidence i))) (if each i then one else half).

Definition pairs (i : units) (xs : list context) : list (list contrast) :=
  flat_map (fun xe => pairs_of (drop i) xe.1 xe.2) (combine xs (profiles i)).

Definition most_holds (i : units) (xs : list context) : bool :=
  match most i with
  | Some r => at_most one r && forallb (fun cs => reaches (wealth_of r cs) (share i)) (pairs i xs)
  | None => true
  end.
Definition least_holds (i : units) (xs : list context) : bool :=
  at_most one (least i)
  && (at_most (least i) one || reaches (mean (map (wealth_of (inverse (least i))) (pairs i xs))) (share i)).

Definition accepted (i : units) (xs : list context) : bool :=
  [&& are_named i, ~~ independent i, at_most (confidence i) one, same_number (upper_level i) (share i), same_number (lower_level i) (share i),
      Nat.eqb (length xs) (length (profiles i)), forallb (fun xe => are_drawn xe.1 xe.2) (combine xs (profiles i)), most_holds i xs
    & least_holds i xs].
