(* What two rows of a product of filters give to its outputs, by likelihood ratio: outputs of equal ratio are added up factor by
   factor, and release by release, so that the product is never multiplied out.

   This file only computes; LikelihoodsSound.v proves it right. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Policy.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* Pairs (p, q): what the one row and the other give to some outputs of ratio p/q *)
Definition likelihoods : Type := list (Z * Z).

Fixpoint merged (s t : likelihoods) : likelihoods :=
  let fix with_s (t : likelihoods) : likelihoods :=
    match s, t with
    | [], _ => t
    | _, [] => s
    | (p, q) :: s', (p', q') :: t' =>
        match p * q' ?= p' * q with
        | Lt => (p, q) :: merged s' t
        | Gt => (p', q') :: with_s t'
        | Eq => (p + p', q + q') :: merged s' t'
        end
    end in
  with_s t.

Fixpoint merged_in_pairs (ss : list likelihoods) : list likelihoods :=
  match ss with s :: t :: rest => merged s t :: merged_in_pairs rest | _ => ss end.

Fixpoint all_merged (rounds : nat) (ss : list likelihoods) : likelihoods :=
  match rounds, ss with
  | _, [] => []
  | _, [s] => s
  | Datatypes.S n, _ => all_merged n (merged_in_pairs ss)
  | O, _ => concat ss
  end.

(* Equal ratios added up, outputs that neither row releases left out *)
Definition by_ratio (s : likelihoods) : likelihoods :=
  all_merged 64 (map (fun t => [t]) (filter (fun t => negb ((t.1 =? 0) && (t.2 =? 0))) s)).

(* Of outputs that are drawn independently *)
Definition joint (s t : likelihoods) : likelihoods :=
  by_ratio (flat_map (fun a => map (fun b => (a.1 * b.1, a.2 * b.2)) t) s).

Fixpoint power (s : likelihoods) (n : positive) : likelihoods :=
  match n with
  | xH => s
  | xO m => let r := power s m in joint r r
  | xI m => let r := power s m in joint s (joint r r)
  end.

(* ---- Different kinds of pairs ---- *)

Fixpoint same_likelihoods (s t : likelihoods) : bool :=
  match s, t with
  | [], [] => true
  | (p, q) :: s', (p', q') :: t' => if (p =? p') && (q =? q') then same_likelihoods s' t' else false
  | _, _ => false
  end.

Fixpoint distinct (found ss : list likelihoods) : list likelihoods :=
  match ss with
  | s :: rest => distinct (if existsb (same_likelihoods s) found then found else s :: found) rest
  | [] => found
  end.

(* All ordered pairs of entries at different places *)
Fixpoint ordered {A : Type} (before xs : list A) : list (A * A) :=
  match xs with
  | x :: rest => map (fun y => (x, y)) (before ++ rest) ++ ordered (x :: before) rest
  | [] => []
  end.

Definition of_rows (p q : list Z) : likelihoods := by_ratio (combine p q).

Definition factor_kinds (F : matrix) : list likelihoods :=
  distinct [] (map (fun rows => of_rows rows.1 rows.2) (ordered [] (integers F))).

(* Of two different inputs of a product, which differ in one factor at least *)
Fixpoint kinds (fs : list matrix) : list likelihoods :=
  match fs with
  | F :: rest =>
      let own := factor_kinds F in
      let others := kinds rest in
      distinct []
        (flat_map (fun s => map (joint s) ([(units rest, units rest)] :: others)) own
         ++ map (joint [(unit_of F, unit_of F)]) others)
  | [] => []
  end.

(* Of all ordered pairs of inputs, by the one and by the other *)
Definition pairwise (F : matrix) : list (list likelihoods) := let rows := integers F in map (fun p => map (of_rows p) rows) rows.

Fixpoint all_pairs (fs : list matrix) : list (list likelihoods) :=
  match fs with
  | F :: rest =>
      let others := all_pairs rest in
      flat_map (fun own => map (fun row => flat_map (fun s => map (joint s) row) own) others) (pairwise F)
  | [] => [[[(1, 1)]]]
  end.

(* ---- H_k: the sum of max(0, P - k Q) ---- *)

(* times the denominator of k; the unit is that of the likelihoods *)
Definition exceeding (k : Q) (s : likelihoods) : Z :=
  fold_right (fun t sum => Z.max 0 (t.1 * Zpos (Qden k) - t.2 * Qnum k) + sum) 0 s.

Definition hockey (u : Z) (k : Q) (s : likelihoods) : Q :=
  match u with Zpos d => reduced (Qmake (exceeding k s) (d * Qden k)) | _ => zero end.
