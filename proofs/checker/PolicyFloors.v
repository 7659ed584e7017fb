(* The greatest ratio over the policies that keep the declared floors: which claims are accepted.

   This file only computes; PolicyFloorsSound.v proves it right.  That no such policy has a greater ratio is proved for each pair by
   one multiplier k of the floor of the lower group, or by multipliers of any floors; that one has it is seen from the policy. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Policy Likelihoods PolicyClaims PolicySites PolicyShown.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

(* S(k) <= (V - k) floor for some k <= V in the list; the unit is that of sums. *)
Definition one_k (V : Q) (ks : list Q) (unit : Z) (s : likelihoods) (alphas betas : list (list Z)) (floor : Q) : bool :=
  existsb (fun k =>
    at_most k V
    && at_most (Qmake (over_sites (fun alpha beta => sum_over top (Qnum k) (Zpos (Qden k)) alpha beta s) alphas betas) 1)
         (times (times (difference V k) floor) (Qmake (unit * Zpos (Qden k)) 1))) ks.

Section Behind.
Variable S : behind.

(* What a decision adds to a quantity wherever the filters release something, besides the likelihood of the group: by released context and
   decision; the means of groups are given. *)
Definition shown_worth (means : matrix) (c : option nat) (a : nat) : vector :=
  match c with
  | Some x => flat_map (fun w => map (times w) (gains S x a)) (nth x (context_matrix S) [])
  | None => nth a means []
  end.

(* The sum over all that is released of the greatest of a sum of multiples of what a decision adds to quantities *)
Definition term : Type := option nat * nat * Q.
Definition greatest_sum (means rows : matrix) (terms : list term) : Q :=
  let parts := map (fun t => (t.2, nth t.1.2 rows [], pieces (released_contexts S) (decisions S) (shown_worth means t.1.1 t.1.2))) terms in
  total (flat_map (fun y =>
      let here := map (fun p => (p.1.1, p.1.2, nth y p.2 [])) parts in
      map (fun b => greatest_of (add_up (decisions S) (map (fun p => (times p.1.1 (nth b p.1.2 zero), p.2)) here)))
        (seq 0 (released_groups S)))
    (seq 0 (released_contexts S))).

(* The floor of an expectation, or of a mean; 0 where there is none *)
Definition declared_floor (c : option nat) (a : nat) : Q :=
  match c with
  | Some x => if Nat.ltb x (true_contexts S) && Nat.ltb a (true_groups S) then floor_at S x else zero
  | None => if existsb (Nat.eqb a) (populated S) then floor_of_means S else zero
  end.

Definition by_floors (means rows : matrix) (V : Q) (c : option nat) (a a' : nat) (floors : list term) : bool :=
  at_most (greatest_sum means rows ((c, a, one) :: (c, a', minus V) :: floors))
          (total (map (fun f => times f.2 (declared_floor f.1.1 f.1.2)) floors)).

Definition same_context (c d : option nat) : bool :=
  match c, d with Some x, Some y => Nat.eqb x y | None, None => true | _, _ => false end.
Definition is_at (c : option nat) (a a' : nat) (p : pair) : bool :=
  [&& same_context (in_true_context p) c, Nat.eqb (higher_group p) a & Nat.eqb (lower_group p) a'].

Definition keeps_below (V : Q) (ks : list Q) (pairs : list priced) (is_of_means : bool) : bool :=
  let rows := rows_of S in
  let kinds_of_pairs := all_kinds S in
  let means := match pairs with [] => [] | _ => mean_worths S end in
  let M := match pairs with nil => nil | _ => group_matrix S end in
  let otherwise c a a' :=
    match find (fun p => is_at c a a' (priced_pair p)) pairs with
    | Some p => one_release S && by_floors means M V c a a' (prices p)
    | None => false
    end in
  forallb (fun c => proved S rows kinds_of_pairs (one_k V (V :: ks)) (otherwise c) c (floor_of S c)) (places S is_of_means).

(* Each entry is for another pair that is compared, and every floor of it is declared and positive. *)
Fixpoint entries_fit (is_of_means : bool) (pairs : list priced) : bool :=
  match pairs with
  | p :: rest =>
      let at_ := priced_pair p in
      [&& is_pair S is_of_means at_, forallb (fun f => positive_fraction (declared_floor f.1.1 f.1.2) && positive_fraction f.2) (prices p),
          ~~ existsb (fun r => is_at (in_true_context at_) (higher_group at_) (lower_group at_) (priced_pair r)) rest
        & entries_fit is_of_means rest]
  | [] => true
  end.

(* So much work is left to others. *)
Definition work_of (pairs : list priced) : Z :=
  (fold_right (fun p n => Z.of_nat (length (prices p)) + 2 + n) 0
   pairs * Z.of_nat (released_contexts S) * Z.of_nat (released_groups S) * Z.of_nat (decisions S))%Z.

Definition floored_accepted (is_of_means exactly : bool) (V : option Q) (ks : list Q) (pairs : list priced)
    (policy : option (pair * list (list vector))) : option bool :=
  if ~~ manageable S (kinds (group_filter S)) || (5000000 <? work_of pairs)%Z then None
  else
    let is_one := match V with Some V => at_most V one | None => false end in
    Some [&& some_floor S, match V with Some V => at_most one V | None => exactly end,
             Bool.eqb (match policy with Some _ => true | None => false end) (exactly && ~~ is_one),
             entries_fit is_of_means pairs, match V with Some V => keeps_below V ks pairs is_of_means | None => true end
           & match policy with
             | Some (p, rows) =>
                 [&& one_release S, is_pair S is_of_means p, are_laws S rows
                   & let es := expectations (with_laws S rows) in keeps S es && has_ratio S es V p]
             | None => true
             end].
End Behind.
