(* The greatest local ratio over all policies behind known filters, for the utility of the certificate: which claims are accepted.

   This file only computes; PolicySupremaSound.v proves it right.  Where a utility ignores the group in a context, pairs of groups are
   compared by their kinds, factor by factor; else by their rows of the product. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Policy Likelihoods PolicyClaims.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

Definition greatest_z (xs : list Z) : Z := match xs with x :: rest => fold_right Z.max x rest | [] => 0 end.

(* p - V q of each decision, where something of the likelihood t is released, times the denominator d of V = n/d; and q *)
Definition excesses (n d : Z) (alpha beta : list Z) (t : Z * Z) : list (Z * Z) :=
  map (fun v => (t.1 * v.1 * d - t.2 * v.2 * n, t.2 * v.2)) (combine alpha beta).
Definition top (es : list (Z * Z)) : Z := greatest_z (map fst es).
Definition taken (es : list (Z * Z)) : Z := greatest_z (map (fun e => if e.1 =? top es then e.2 else 0) es).

Definition sum_over (f : list (Z * Z) -> Z) (n d : Z) (alpha beta : list Z) (s : likelihoods) : Z :=
  fold_right (fun t sum => f (excesses n d alpha beta t) + sum) 0 s.

Section Behind.
Variable S : behind.

(* g(u,x,a) over one denominator, by a *)
Definition gains_of (x : nat) : list vector := map (gains S x) (seq 0 (true_groups S)).
Definition worth_at (x : nat) : list (list Z) := integers (gains_of x).

Fixpoint same_numbers (v w : list Z) : bool :=
  match v, w with [], [] => true | a :: v', b :: w' => if a =? b then same_numbers v' w' else false | _, _ => false end.

Definition rows_of : list (list Z) := integers (group_matrix S).

Definition context_proved (rows : list (list Z)) (pairs : list likelihoods) (n d : Z) (x : nat) : bool :=
  let worth := worth_at x in
  match worth with
  | first :: rest =>
      if forallb (same_numbers first) rest then forallb (fun s => sum_over top n d first first s <=? 0) pairs
      else
        forallb (fun ab => sum_over top n d ab.1.2 ab.2.2 (of_rows ab.1.1 ab.2.1) <=? 0) (ordered [] (combine rows worth))
  | [] => false
  end.

Definition attains (n d : Z) (p : pair) : bool :=
  match in_true_context p with
  | Some x =>
      let alpha := nth (higher_group p) (worth_at x) [] in
      let beta := nth (lower_group p) (worth_at x) [] in
      let s := of_rows (nth (higher_group p) rows_of []) (nth (lower_group p) rows_of []) in
      [&& Nat.ltb x (true_contexts S), Nat.ltb (higher_group p) (true_groups S), Nat.ltb (lower_group p) (true_groups S),
          negb (Nat.eqb (higher_group p) (lower_group p)), sum_over top n d alpha beta s =? 0 & 0 <? sum_over taken n d alpha beta s]
  | None => false
  end.

Definition supremum_accepted (V : Q) (attained : option pair) : bool :=
  let n := Qnum V in
  let d := Zpos (Qden V) in
  let rows := rows_of in
  let pairs := kinds (group_filter S) in
  [&& one_release S, at_most one V, forallb (context_proved rows pairs n d) (seq 0 (true_contexts S))
    & match attained with Some p => attains n d p && negb (at_most V one) | None => at_most V one end].
End Behind.
