(* Whether a ladder of knots proves that the mean of one binomial cell is less than a multiple of that of another one, in integers.

   This file only computes; PairLawSound.v proves: what it accepts is a ladder as theories/PairExact.v has them.  It follows
   docs/certificate-samples.md, region "pairs": outcomes are ordered by score ends, a binomial law is summed from its mode outwards with
   terms that are rounded up, and what those leave out is bounded. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Tails.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* ---- Score ends ---- *)

Definition fixed : Z := power 2 64. (* 1, of score ends and of the term of a law at its mode *)

(* Newton's steps from above to the root, rounded down.  Nothing is proved of it: that score ends rise is checked of the numbers themselves. *)
Fixpoint root_from (steps : nat) (x guess : Z) : Z :=
  match steps with
  | S more => let next := (guess + x / guess) / 2 in if next <? guess then root_from more x next else guess
  | O => guess
  end.
Definition root (x : Z) : Z := if x <=? 0 then 0 else root_from (Z.to_nat (Z.log2 x + 2)) x (power 2 (Z.log2 x / 2 + 1)).

(* The floors of [fixed] times the roots of (x - k/n)^2 = (a/b) x (1 - x)/n, the lower one first *)
Definition score_ends (n a b k : Z) : Z * Z :=
  let radicand := a * n * (4 * b * k * (n - k) + a * n) * (fixed * fixed) in
  let r := root radicand in
  let twice := n * (2 * b * k + a) * fixed in
  let below := 2 * n * (b * n + a) in
  ((twice - r - (if r * r =? radicand then 0 else 1)) / below, (twice + r) / below).

(* those for k, k - 1, ..., 0 before what is there *)
Fixpoint scores_onto (many : nat) (n a b k : Z) (there : list (Z * Z)) : list (Z * Z) :=
  match many with S m => scores_onto m n a b (k - 1) (score_ends n a b k :: there) | O => there end.
Definition scores (n : Z) (z2 : Q) : list (Z * Z) := scores_onto (S (Z.to_nat n)) n (Qnum z2) (Zpos (Qden z2)) n [].

(* Both ends rise, from [low] and [up] on. *)
Fixpoint rising (low up : Z) (es : list (Z * Z)) : bool :=
  match es with e :: rest => [&& low <=? e.1, up <=? e.2 & rising e.1 e.2 rest] | [] => true end.

(* A cell: its draws, how many were successes, and the score ends of each number of them *)
Record cell := Cell { drawn : Z; successful : Z; ends : list (Z * Z) }.

Definition ends_at (h : cell) (k : Z) : Z * Z := nth (Z.to_nat k) (ends h) (0, 0).

(* Outcomes of the lower cell that come later than what was observed, with an upper end of the higher one *)
Fixpoint later_ones (up bottom top at_ : Z) (es : list (Z * Z)) : Z * list (Z * Z) :=
  match es with
  | e :: rest => if up * bottom <=? top * e.1 then (at_, es) else later_ones up bottom top (at_ + 1) rest
  | [] => (at_, [])
  end.

(* For each outcome of the higher cell the least one of the lower cell that comes no later than what was observed *)
Fixpoint stairs_onto (done : list Z) (bottom top at_ : Z) (others es : list (Z * Z)) : list Z :=
  match es with
  | e :: rest => let (at_, others) := later_ones e.2 bottom top at_ others in stairs_onto (at_ :: done) bottom top at_ others rest
  | [] => rev_append done []
  end.
Definition stairs (h l : cell) : list Z :=
  stairs_onto [] (ends_at l (successful l)).1 (ends_at h (successful h)).2 0 (ends l) (ends h).

(* ---- Binomial laws ---- *)

(* Terms from the [start]-th on and the sums of those before and after, from above; the sum of all from below *)
Record sums := Sums { start : Z; terms : list Z; before : Z; after : Z; sure : Z }.

(* The terms on one side of the mode, the farthest first, a bound of those beyond, and a bound of the sum of all from below.  Quotients of
   successive terms are count a / (divisor b): at most 1, so that the i-th term is too great by less than i, and a term that is no greater is the last, or one after so many steps. *)
Fixpoint side (many : nat) (count divisor i term a b : Z) (done : list Z) (least : Z) : list Z * Z * Z :=
  match many with
  | S m =>
      if i <? term then
        let next := above (term * (count * a)) (divisor * b) in
        side m (count - 1) (divisor + 1) (i + 1) next a b (next :: done) (least + (next - (i + 1)))
      else (done, above (term * (count * a)) (divisor * b - count * a), least)
  | O => (done, above (term * (count * a)) (divisor * b - count * a), least)
  end.

(* More steps than it takes until terms are no greater than their distance from the mode: a bound of those beyond holds after any number of
   steps but none. *)
Definition enough (n count : Z) : nat := let most := Z.max 0 (8 * root n) + 128 in Z.to_nat (if count <=? most then count else most).

(* Of n draws, each a success with the odds a : b *)
Definition binomial (n a b : Z) : sums :=
  if a <=? 0 then Sums 0 [fixed] 0 0 fixed
  else if b <=? 0 then Sums n [fixed] 0 0 fixed
  else
    let mode := (n + 1) * a / (a + b) in
    let '(up, after, one) := side (enough n (n - mode)) (n - mode) (mode + 1) 0 fixed a b [] fixed in
    let '(down, before, both) := side (enough n mode) mode (n - mode + 1) 0 fixed b a [] one in
    Sums (mode - Z.of_nat (length down)) (down ++ fixed :: rev_append up []) before after both.

Definition law_at (n : Z) (p : Q) : sums := binomial n (Qnum p) (Zpos (Qden p) - Qnum p).

(* The first so many terms, and what comes after all of them if that is not enough *)
Fixpoint sum_of_first (many after : Z) (ts : list Z) (sum : Z) : Z :=
  match ts with
  | t :: rest => if 0 <? many then sum_of_first (many - 1) after rest (sum + t) else sum
  | [] => if 0 <? many then sum + after else sum
  end.

(* For each term the sum of it and all that follow, then that of those after *)
Fixpoint sums_onto (done : list Z) (sum : Z) (reversed : list Z) : list Z :=
  match reversed with t :: rest => sums_onto (sum :: done) (sum + t) rest | [] => sum :: done end.
Definition tails (L : sums) : list Z := sums_onto [] (after L) (rev_append (terms L) []).

Definition everything (L : sums) : Z := before L + hd 0 (tails L).

(* From the tails of the outcomes from [at_] on, those from t on; the last one stands for all that are not listed. *)
Fixpoint from_tail (t at_ : Z) (ts : list Z) : Z * list Z :=
  match ts with _ :: ((_ :: _) as rest) => if at_ <? t then from_tail t (at_ + 1) rest else (at_, ts) | _ => (at_, ts) end.

Definition part_at_most (sum : Z) (L : sums) (share : Q) : bool := sum * Zpos (Qden share) <=? Qnum share * sure L.

(* At most k, or at least k, successes have at most a share. *)
Definition rare_below (L : sums) (k : Z) (share : Q) : bool :=
  part_at_most (sum_of_first (k + 1 - start L) (after L) (terms L) (before L)) L share.
Definition rare_above (L : sums) (k : Z) (share : Q) : bool :=
  part_at_most (if k <? start L then everything L else hd 0 (from_tail k (start L) (tails L)).2) L share.

(* ---- Steps ---- *)

(* The sum, over the outcomes of the higher cell that are listed, of the term times the tail from the stair on *)
Fixpoint weight_from (m all at_ : Z) (tails stairs terms : list Z) (sum : Z) : Z :=
  match terms, stairs with
  | u :: us, t :: rest =>
      if t <? at_ then weight_from m all at_ tails rest us (sum + u * all)
      else if m <? t then weight_from m all at_ tails rest us sum
      else let (at_, tails) := from_tail t at_ tails in weight_from m all at_ tails rest us (sum + u * hd 0 tails)
  | u :: us, [] => weight_from m all at_ tails [] us (sum + u * all)
  | [], _ => sum
  end.

Fixpoint without_first (many : Z) (ts : list Z) : list Z :=
  match ts with _ :: rest => if 0 <? many then without_first (many - 1) rest else ts | [] => [] end.

Definition weight (m : Z) (stairs : list Z) (H L : sums) : Z :=
  let all := everything L in
  weight_from m all (start L) (tails L) (without_first (start H) stairs) (terms H) ((before H + after H) * all).

(* min(1, r q) *)
Definition image (r q : Q) : Q := let r_q := times r q in if at_most one r_q then one else r_q.

Definition is_step (h l : cell) (stairs : list Z) (r goal q q' : Q) : bool :=
  let H := law_at (drawn h) (image r q) in
  let L := law_at (drawn l) q' in
  [&& 0 <=? sure H, 0 <=? sure L
    & weight (drawn l) stairs H L * Zpos (Qden goal) <=? Qnum goal * (sure H * sure L)].

(* ---- Ladders ---- *)

(* z^2, by the level of a one-sided end *)
Definition order_scale (level : Q) : Q :=
  if at_most (Qmake 1 100) level then Qmake 25 16 else if at_most (Qmake 1 2000) level then Qmake 4 1 else Qmake 9 1.

Definition scored (n k : Z) (z2 : Q) : cell := Cell n k (scores n z2).

Definition is_cell (h : cell) : bool :=
  [&& 0 <=? successful h, successful h <=? drawn h, 1 <=? drawn h & rising 0 1 (ends h)].

Fixpoint rise (q : Q) (qs : list Q) : bool :=
  match qs with q' :: rest => negb (at_most q' q) && rise q' rest | [] => at_most q one end.

Fixpoint all_steps (step : Q -> Q -> bool) (q : Q) (qs : list Q) : bool :=
  match qs with q' :: rest => step q q' && all_steps step q' rest | [] => true end.

Definition guard_of (level : Q) : Q := times level (Qmake 1 50).

(* The knots prove that the mean of h is less than r times that of l. *)
Definition ladder_accepted (h l : cell) (r level : Q) (knots : list Q) : bool :=
  let share := times (guard_of level) (Qmake 1 4) in
  let goal := plus level (minus (guard_of level)) in
  [&& is_cell h, is_cell l, positive_fraction r, 0 <? successful l, nonnegative level
    & match knots with
      | [] => false
      | q :: qs =>
          let last := List.last qs q in
          [&& nonnegative q, rise q qs
            & match qs with
              | [] =>
                  let beyond := rare_below (law_at (drawn h) (image r q)) (successful h) share in
                  (beyond && at_most q zero)
                  || ((beyond || at_most one (times r q)) && rare_above (law_at (drawn l) q) (successful l) share)
              | _ =>
                  [&& [|| at_most q zero, rare_above (law_at (drawn l) q) (successful l) share
                        | rare_above (law_at (drawn h) (image r q)) (successful h) share],
                      [|| at_most one (times r last), rare_below (law_at (drawn h) (image r last)) (successful h) share, at_most one last
                        | rare_below (law_at (drawn l) last) (successful l) share]
                    & let s := stairs h l in all_steps (is_step h l s r goal) q qs]
              end]
      end].
