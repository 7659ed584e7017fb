(* What a decision is worth to a group wherever something is released besides the group, and the greatest excess p - V q over all
   policies behind the filters: in a context, and of the means of groups; of one release of the group, or of as many as one memory sees.

   This file only computes; PolicySitesSound.v proves it right.  A site is a released context, where means are compared, and there is
   one site where a context is compared, in which what is released of it drops out. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Policy Likelihoods PolicyClaims.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* ---- The greatest excess ---- *)

Definition lesser_z (x y : Z) : Z := if x <=? y then x else y.
Definition greatest_z (xs : list Z) : Z := match xs with x :: rest => fold_right Z.max x rest | [] => 0 end.

(* p - V q of each decision, where something of the likelihood t is released, times the denominator d of V = n/d; and q *)
Definition excesses (n d : Z) (alpha beta : list Z) (t : Z * Z) : list (Z * Z) :=
  map (fun v => (t.1 * v.1 * d - t.2 * v.2 * n, t.2 * v.2)) (combine alpha beta).
Definition top (es : list (Z * Z)) : Z := greatest_z (map fst es).
Definition taken (es : list (Z * Z)) : Z := greatest_z (map (fun e => if e.1 =? top es then e.2 else 0) es).

Definition sum_over (f : list (Z * Z) -> Z) (n d : Z) (alpha beta : list Z) (s : likelihoods) : Z :=
  fold_right (fun t sum => f (excesses n d alpha beta t) + sum) 0 s.

Definition over_sites (f : list Z -> list Z -> Z) (alphas betas : list (list Z)) : Z :=
  fold_right (fun ab sum => f ab.1 ab.2 + sum) 0 (combine alphas betas).

(* The greatest sum of p over decisions that leave the other group nothing; nothing where there are none *)
Definition free_worth (alpha beta : list Z) (s : likelihoods) : Z :=
  let all := greatest_z alpha in
  let free := greatest_z (map (fun v => if v.2 =? 0 then v.1 else 0) (combine alpha beta)) in
  fold_right (fun t sum => t.1 * (if t.2 =? 0 then all else free) + sum) 0 s.
Definition some_free (beta : list Z) : bool := existsb (Z.eqb 0) beta.

(* ---- Several releases ---- *)

(* The rows of n releases *)
Fixpoint repeated (s : likelihoods) (n : nat) : likelihoods :=
  match n with Datatypes.S ((Datatypes.S _) as m) => joint s (repeated s m) | _ => s end.
Fixpoint raised (u : Z) (n : nat) : Z := match n with Datatypes.S m => u * raised u m | O => 1 end.

(* At the most so many ratios do n releases have: n + i over i, of i + 1 ratios *)
Definition few_ratios (most : Z) (n : positive) (s : likelihoods) : bool :=
  fold_left (fun c i => if most <? c then c else c * (Zpos n + i) / i) (map (fun i => Z.of_nat i + 1) (seq 0 (Nat.pred (length s)))) 1 <=? most.

Fixpoint same_numbers (v w : list Z) : bool :=
  match v, w with [], [] => true | a :: v', b :: w' => if a =? b then same_numbers v' w' else false | _, _ => false end.
Fixpoint same_lists (vs ws : list (list Z)) : bool :=
  match vs, ws with [], [] => true | v :: vs', w :: ws' => if same_numbers v w then same_lists vs' ws' else false | _, _ => false end.

Section Behind.
Variable S : behind.

Definition times_released : nat := Pos.to_nat (releases S).

(* Several releases that take more than this are left to others. *)
Definition manageable (kinds_of_pairs : list likelihoods) : bool :=
  let groups := Z.of_nat (true_groups S) in
  one_release S
  || ((Zpos (releases S) <=? 200) && forallb (few_ratios (lesser_z 3000 (200000 / (groups * groups))) (releases S)) kinds_of_pairs).

(* ---- What decisions are worth ---- *)

(* In a context: g(u,x,a), by a *)
Definition gains_of (x : nat) : list vector := map (gains S x) (seq 0 (true_groups S)).

(* Sums of multiples of lists of n numbers *)
Definition add_up (n : nat) (terms : list (Q * vector)) : vector :=
  fold_right (fun t v => if zero_fraction t.1 then v else map (fun pq => plus (times t.1 pq.1) pq.2) (combine t.2 v)) (repeat zero n) terms.

(* Of means: G_a(y,u), the sum over x of P(x|a) M_X(y|x) g(u,x,a), by y and u; the columns are those of M_X. *)
Definition mean_worth (seen_as : list vector) (a : nat) : vector :=
  let p := shares S a in
  flat_map (fun column =>
    add_up (decisions S) (map (fun t => (times t.1.1 t.1.2, gains S t.2 a)) (combine (combine p column) (seq 0 (true_contexts S))))) seen_as.
Definition mean_worths : list vector :=
  let seen_as := columns (released_contexts S) (context_matrix S) in map (mean_worth seen_as) (seq 0 (true_groups S)).

(* A context is named where its ratio is meant, and none where that of means is. *)
Definition worths (c : option nat) : matrix := match c with Some x => gains_of x | None => mean_worths end.
Definition sites_in (c : option nat) : nat := match c with Some _ => 1%nat | None => released_contexts S end.
Definition groups_in (c : option nat) : list nat := match c with Some _ => seq 0 (true_groups S) | None => populated S end.
Definition places (means : bool) : list (option nat) := if means then [None] else map Some (seq 0 (true_contexts S)).

(* A group that is compared: its row of the group filter, what decisions are worth to it by site, and what it has at the least *)
Record side := Side { its_group : nat; its_row : list Z; its_worth : list (list Z); its_floor : Q }.

Definition rows_of : list (list Z) := integers (group_matrix S).
Definition rows_unit : Z := raised (unit_of (group_matrix S)) times_released.
Definition kinds_unit : Z := raised (units (group_filter S)) times_released.

Definition sides (rows : list (list Z)) (c : option nat) (floor : nat -> Q) : list side :=
  let ws := map (pieces (sites_in c) (decisions S)) (integers (worths c)) in
  map (fun a => Side a (nth a rows []) (nth a ws []) (floor a)) (groups_in c).

Definition alike (s t : side) : bool := same_lists (its_worth s) (its_worth t) && equal (its_floor s) (its_floor t).

(* Whether a test succeeds for every two of the groups that are compared: it is given the unit of all numbers, the likelihoods, and what
   decisions are worth to the higher group and to the lower one, which has some floor.  Where groups are alike, it is enough to
   test the kinds of pairs; where it fails, something else may be said of the pair. *)
Definition proved (rows : list (list Z)) (kinds_of_pairs : list likelihoods)
    (test : Z -> likelihoods -> list (list Z) -> list (list Z) -> Q -> bool) (otherwise : nat -> nat -> bool)
    (c : option nat) (floor : nat -> Q) : bool :=
  let unit := unit_of (worths c) in
  match sides rows c floor with
  | first :: rest =>
      (forallb (alike first) rest
       && forallb (fun s => test (unit * kinds_unit) s (its_worth first) (its_worth first) (its_floor first)) kinds_of_pairs)
      || forallb (fun ab =>
           test (unit * rows_unit) (repeated (of_rows (its_row ab.1) (its_row ab.2)) times_released) (its_worth ab.1) (its_worth ab.2)
             (its_floor ab.2)
           || otherwise (its_group ab.1) (its_group ab.2))
         (ordered [] (first :: rest))
  | [] => true
  end.

Definition all_kinds : list likelihoods := map (fun s => repeated s times_released) (kinds (group_filter S)).

(* ---- Where a value is attained ---- *)

Definition is_pair (means : bool) (p : pair) : bool :=
  let among g := existsb (Nat.eqb g) (groups_in (in_true_context p)) in
  [&& match in_true_context p with Some x => ~~ means && Nat.ltb x (true_contexts S) | None => means end,
      among (higher_group p), among (lower_group p) & ~~ Nat.eqb (higher_group p) (lower_group p)].

Definition with_pair {A : Type} (p : pair) (f : likelihoods -> list (list Z) -> list (list Z) -> A) : A :=
  let c := in_true_context p in
  let ws := map (pieces (sites_in c) (decisions S)) (integers (worths c)) in
  let rows := rows_of in
  f (repeated (of_rows (nth (higher_group p) rows []) (nth (lower_group p) rows [])) times_released)
    (nth (higher_group p) ws []) (nth (lower_group p) ws []).

Definition attains (n d : Z) (p : pair) : bool :=
  with_pair p (fun s alphas betas =>
    (over_sites (fun alpha beta => sum_over top n d alpha beta s) alphas betas =? 0)
    && (0 <? over_sites (fun alpha beta => sum_over taken n d alpha beta s) alphas betas)).

Definition gives_nothing (p : pair) : bool :=
  with_pair p (fun s alphas betas =>
    forallb some_free betas && (0 <? over_sites (fun alpha beta => free_worth alpha beta s) alphas betas)).
End Behind.
