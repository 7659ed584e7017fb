(* What the metrics leave out, compared with what is stated: one entry after the other, because a
   short table can leave out more than fits into memory.

   This file only computes; LeftOutSound.v proves it right. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Table Statements Figures.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* The groups of each context, of those without cells too *)
Fixpoint aligned (xs : list Z) (F : list (Z * list row)) : list (Z * list Z) :=
  match xs with
  | x :: rest =>
      match F with
      | (y, rs) :: more => if y =? x then (x, map who rs) :: aligned rest more else (x, []) :: aligned rest F
      | [] => (x, []) :: aligned rest []
      end
  | [] => []
  end.

(* Whether these are all groups but those of the keys, which are in order *)
Fixpoint same_missing (all keys stated : list Z) : bool :=
  match all with
  | a :: rest =>
      match keys with
      | k :: ks => if k =? a then same_missing rest ks stated
                   else match stated with s :: ss => if s =? a then same_missing rest keys ss else false | [] => false end
      | [] => match stated with s :: ss => if s =? a then same_missing rest [] ss else false | [] => false end
      end
  | [] => match stated with [] => true | _ => false end
  end.

Definition stated_missing (x : Z) (stated : list left_out) : list Z * list left_out :=
  match stated with
  | No_decisions y gs :: rest => if y =? x then (gs, rest) else ([], stated)
  | _ => ([], stated)
  end.

(* What follows the entries about groups without decisions, if these are as they should be *)
Fixpoint after_missing (all : list Z) (xks : list (Z * list Z)) (stated : list left_out) : option (list left_out) :=
  match xks with
  | xk :: more =>
      let '(gs, rest) := stated_missing xk.1 stated in
      if same_missing all xk.2 gs then after_missing all more rest else None
  | [] => Some stated
  end.

Definition is_missing (e : left_out) : bool := match e with No_decisions _ [] => true | _ => false end.

Definition one_entry (b : bool) (e : left_out) : list left_out := if b then [e] else [].
Definition two_of {A} (xs : list A) : bool := match xs with _ :: _ :: _ => true | _ => false end.
Definition some_of {A} (xs : list A) : bool := match xs with _ :: _ => true | [] => false end.

(* A: all groups that have a cell *)
Definition further_left_out (T : table) (xks : list (Z * list Z)) (A : list row) : list left_out :=
  flat_map (fun xk => one_entry (negb (two_of xk.2)) (Alone xk.1)) xks
  ++ (let empty := map who (filter (fun r => negb (positive_fraction (bulk r))) A) in one_entry (some_of empty) (No_population empty))
  ++ (if with_means T then one_entry (negb (two_of (filter (fun r => positive_fraction (bulk r)) A))) No_means_alone else [No_means_missing]).

(* By a rate, in a context or over all of them: groups that have a cell and no draws with the true label *)
Definition without_rate (r x : Z) (ts : list (Z * (Q * Q))) : list left_out :=
  let lacking := map fst (filter (fun t => negb (drawn t)) ts) in
  one_entry (some_of lacking) (No_rate r x lacking) ++ one_entry (two_of ts && negb (two_of (filter drawn ts))) (Rate_alone r x).

Definition rates_left_out (T : table) : list left_out :=
  match known T with
  | Some K =>
      flat_map (fun r => flat_map (fun b => without_rate r b.1 b.2)
                           (counts T K r false ++ if pooled K then counts T K r true else [])) [true_positives; false_positives]
  | None => []
  end.

Definition same_entry (e f : left_out) : bool :=
  let same := fix same (xs ys : list Z) : bool :=
    match xs, ys with x :: xs, y :: ys => if x =? y then same xs ys else false | [], [] => true | _, _ => false end in
  match e, f with
  | No_decisions x gs, No_decisions y hs => (x =? y) && same gs hs
  | Alone x, Alone y => x =? y
  | No_population gs, No_population hs => same gs hs
  | No_means_missing, No_means_missing | No_means_alone, No_means_alone => true
  | No_rate r x gs, No_rate s y hs => [&& r =? s, x =? y & same gs hs]
  | Rate_alone r x, Rate_alone s y => (r =? s) && (x =? y)
  | _, _ => false
  end.

Fixpoint same_entries (es fs : list left_out) : bool :=
  match es, fs with
  | e :: es, f :: fs => if same_entry e f then same_entries es fs else false
  | [], [] => true
  | _, _ => false
  end.

Definition left_out_as_stated (T : table) (F : list (Z * list row)) (A : list row) (stated : list left_out) : bool :=
  let xks := aligned (range (contexts T)) F in
  if existsb is_missing stated then false
  else match after_missing (range (groups T)) xks stated with
       | Some rest => same_entries rest (further_left_out T xks A ++ rates_left_out T)
       | None => false
       end.
