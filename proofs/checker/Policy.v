(* A policy behind privacy filters, as a certificate states it, and the law that it induces.

   This file only computes; PolicyMeaning.v says what it is about.  It follows the page docs/certificate-policy.md.  Labels
   do not occur: inputs and outputs of a factor, true contexts, true groups, released values and decisions are numbered from 0
   in the order of that page.  The true groups are all ways to join one input of each factor of the group filter, the last factor
   varying fastest; released groups likewise with the outputs, and so are contexts. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Table.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

(* A row for each input and a column for each output: [rows] of a factor.  Outputs that no input releases are left out. *)
Definition matrix : Type := list (list Q).

Definition vector : Type := list Q.

Inductive seen :=
| Filtered (factors : list matrix)  (* filters.context *)
| AsIs (contexts : nat).            (* filters.context is null; so many contexts does the header have *)

(* The utility g *)
Inductive worth :=
| OfDecision (g : vector)              (* the header's utility, one number per decision *)
| OfCell (g : list (list vector)).     (* by true context and true group: utility of the lines of true cells *)

(* What subject.declared has of one context: context is its number among the true ones *)
Record declared_in := DeclaredIn { in_context : Z; gamma_in : option Q; m_in : option Q; tau_in : option Q }.

Record declared := Declared {
  gamma : option Q;
  m : option Q;
  tau : option Q;
  lipschitz : option Q;
  global_tau : option Q;
  max_drift : option Q;
  by_context : list declared_in
}.

Record behind := Behind {
  group_filter : list matrix;           (* filters.group *)
  context_filter : seen;                (* filters.context *)
  releases : positive;                  (* filters.releases, 1 where it is absent *)
  decisions : nat;                      (* how many the header has *)
  policy_laws : list (list vector);     (* weights of the policy's rows, by released context and released group *)
  population : option (list vector);    (* mass of the true cells, by true context and true group; None if the population is equal *)
  utility : worth;
  stated : declared                     (* subject.declared *)
}.

(* ---- Shapes ---- *)

Definition width (F : matrix) : nat := match F with row :: _ => length row | [] => O end.
Definition product_of (ns : list nat) : nat := fold_right Nat.mul 1%nat ns.

Definition inputs_of (fs : list matrix) : nat := product_of (map (@length vector) fs).
Definition outputs_of (fs : list matrix) : nat := product_of (map width fs).

Section Sizes.
Variable S : behind.

Definition true_groups : nat := inputs_of (group_filter S).
Definition released_groups : nat := outputs_of (group_filter S).
Definition true_contexts : nat := match context_filter S with Filtered fs => inputs_of fs | AsIs n => n end.
Definition released_contexts : nat := match context_filter S with Filtered fs => outputs_of fs | AsIs n => n end.
End Sizes.

(* ---- What makes a policy well formed ---- *)

Definition long {A : Type} (n : nat) (xs : list A) : bool := Nat.eqb (length xs) n.
Definition is_law (n : nat) (p : vector) : bool := [&& long n p, forallb nonnegative p & equal (total p) one].
Definition some_positive (p : vector) : bool := existsb positive_fraction p.

(* The columns of a matrix with n columns *)
Fixpoint columns (n : nat) (F : matrix) : list vector :=
  match F with
  | row :: rest => map (fun t => t.1 :: t.2) (combine row (columns n rest))
  | [] => repeat [] n
  end.

Definition valid_factor (F : matrix) : bool :=
  [&& forallb (is_law (width F)) F, negb (long 0 F) & forallb some_positive (columns (width F) F)].

Definition valid_filter (fs : list matrix) : bool := negb (long 0 fs) && forallb valid_factor fs.

Definition shaped {A : Type} (n k : nat) (rows : list (list A)) : bool := long n rows && forallb (long k) rows.

Definition valid_worth (S : behind) : bool :=
  match utility S with
  | OfDecision g => long (decisions S) g && forallb nonnegative g
  | OfCell gs =>
      shaped (true_contexts S) (true_groups S) gs
      && forallb (forallb (fun g => long (decisions S) g && forallb nonnegative g)) gs
  end.

Definition valid (S : behind) : bool :=
  [&& valid_filter (group_filter S),
      match context_filter S with Filtered fs => valid_filter fs | AsIs n => negb (Nat.eqb n 0) end,
      Nat.leb 2 (true_groups S), negb (Nat.eqb (decisions S) 0),
      shaped (released_contexts S) (released_groups S) (policy_laws S),
      forallb (forallb (is_law (decisions S))) (policy_laws S),
      valid_worth S
    & match population S with
      | Some masses => shaped (true_contexts S) (true_groups S) masses && is_law (length (concat masses)) (concat masses)
      | None => true
      end].

(* ---- The product of factors, multiplied out ---- *)

Definition outer (p q : vector) : vector := flat_map (fun x => map (times x) q) p.

Fixpoint multiplied_out (fs : list matrix) : matrix :=
  match fs with
  | F :: rest => flat_map (fun row => map (outer row) (multiplied_out rest)) F
  | [] => [[one]]
  end.

Fixpoint identity_matrix (n : nat) : matrix :=
  match n with
  | Datatypes.S k => (one :: repeat zero k) :: map (cons zero) (identity_matrix k)
  | O => []
  end.

Definition group_matrix (S : behind) : matrix := multiplied_out (group_filter S).
Definition context_matrix (S : behind) : matrix :=
  match context_filter S with Filtered fs => multiplied_out fs | AsIs n => identity_matrix n end.

(* ---- Integers over one denominator ---- *)

Definition common (qs : list Q) : Z := fold_right (fun q d => Z.lcm (Zpos (Qden q)) d) 1%Z qs.
Definition over (d : Z) (q : Q) : Z := Z.mul (Qnum q) (Z.div d (Zpos (Qden q))). (* d * q *)

Definition unit_of (F : matrix) : Z := common (concat F).
Definition integers (F : matrix) : list (list Z) := map (map (over (unit_of F))) F.
Definition units (fs : list matrix) : Z := fold_right (fun F d => Z.mul (unit_of F) d) 1%Z fs.

(* ---- The induced law, factor by factor: the product is never multiplied out ---- *)

(* Cut a list into k pieces of n. *)
Fixpoint pieces {A : Type} (k n : nat) (xs : list A) : list (list A) :=
  match k with
  | Datatypes.S k' => firstn n xs :: pieces k' n (skipn n xs)
  | O => []
  end.

(* sum over j of row_j times the j-th list, all of them with n numbers *)
Fixpoint mixture (n : nat) (row : list Z) (vs : list (list Z)) : list Z :=
  match row, vs with
  | p :: row', v :: vs' =>
      let rest := mixture n row' vs' in
      match p with Z0 => rest | _ => map (fun t => Z.add (Z.mul p t.1) t.2) (combine v rest) end
  | _, _ => repeat 0%Z n
  end.

(* Numbers by output of the product become numbers by input: n for each, which are mixed one by one.  They are to be divided by
   the units of the factors. *)
Fixpoint mixed (n : nat) (fs : list matrix) (vs : list Z) : list Z :=
  match fs with
  | F :: rest =>
      let by_output := map (mixed n rest) (pieces (width F) (outputs_of rest * n) vs) in
      flat_map (fun row => mixture (inputs_of rest * n) row by_output) (integers F)
  | [] => vs
  end.

(* For each true context and true group the numbers that are proportional to P(u|x,a) *)
Definition induced_weights (S : behind) : list (list (list Z)) :=
  let n := (true_groups S * decisions S)%nat in
  let d := common (concat (concat (policy_laws S))) in
  let by_released := map (fun row => mixed (decisions S) (group_filter S) (map (over d) (concat row))) (policy_laws S) in
  let all := match context_filter S with Filtered fs => mixed n fs (concat by_released) | AsIs _ => concat by_released end in
  map (pieces (true_groups S) (decisions S)) (pieces (true_contexts S) n all).

(* Divided by their sum *)
Definition law_of (ws : list Z) : vector :=
  match fold_right Z.add 0%Z ws with
  | Zpos t => map (fun w => reduced (Qmake w t)) ws
  | _ => map (fun=> zero) ws
  end.

(* ---- e^epsilon: the greatest ratio of two entries of a column, of a product the product; None is "inf" ---- *)

Definition greater (p q : Q) : Q := if at_most p q then q else p.
Definition lesser (p q : Q) : Q := if at_most p q then p else q.
Definition greatest_of (v : vector) : Q := match v with p :: rest => fold_right greater p rest | [] => zero end.
Definition least_of (v : vector) : Q := match v with p :: rest => fold_right lesser p rest | [] => zero end.

Definition quotient (p q : Q) : option Q := (* of numbers that are at least 0; 0/0 is 1 *)
  if positive_fraction q then Some (times p (inverse q)) else if positive_fraction p then None else Some one.

Definition widest (v : vector) : option Q := quotient (greatest_of v) (least_of v).

Definition both (f : Q -> Q -> Q) (p q : option Q) : option Q :=
  match p, q with Some p, Some q => Some (f p q) | _, _ => None end.

Definition factor_epsilon (F : matrix) : option Q := fold_right (both greater) (Some one) (map widest (columns (width F) F)).
Definition exp_epsilon (fs : list matrix) : option Q := fold_right (both times) (Some one) (map factor_epsilon fs).

(* ---- The utility of a true cell ---- *)

Definition gains (S : behind) (x a : nat) : vector :=
  match utility S with OfDecision g => g | OfCell gs => nth a (nth x gs []) [] end.

(* ---- The table of the induced law, by true context and true group ---- *)

Definition mass_in (S : behind) (x a : nat) : Q := match population S with Some masses => nth a (nth x masses []) zero | None => one end.

Definition induced_cell (S : behind) (x a : nat) (ws : list Z) : Table.cell :=
  Table.Cell (Z.of_nat x) (Z.of_nat a) (law_of ws)
    (match utility S with OfDecision _ => [] | OfCell _ => map Some (gains S x a) end) (mass_in S x a) [].

Definition numbered {A : Type} (xs : list A) : list (nat * A) := combine (seq 0 (length xs)) xs.

Definition induced_table (S : behind) : Table.table :=
  Table.Table (Z.of_nat (true_contexts S)) (Z.of_nat (true_groups S)) (Z.of_nat (decisions S))
    (match population S with Some _ => Table.Given | None => Table.Alike end)
    (match utility S with OfDecision g => Some g | OfCell _ => None end) None
    (flat_map (fun row => map (fun cell => induced_cell S row.1 cell.1 cell.2) (numbered row.2)) (numbered (induced_weights S))).

(* ---- What was declared allows for what the table has ---- *)

Inductive allowance :=
| In_context (d : declared_in)  (* of one context *)
| Of_means (tau : Q).           (* the floor of the means of groups *)

(* ---- What a claim about a policy says, and how it is proved ---- *)

(* scope, as it is in the page's table *)
Inductive scope :=
| ThisLaw
| AnyPolicy
| KeepingFloor       (* "that keeps the declared floor", of a theorem other than T13: tau of all contexts *)
| KeepingFloors      (* the same by T13: all declared floors *)
| NearThis
| AnyUtility
| AnyUtilityKeepingFloors
| AnyGroupFilter
| AnyContextFilter.

Record statement := Statement {
  of_means : bool;       (* quantity: global_ratio or global_ratio_supremum; else the local one *)
  exactly : bool;        (* relation is "=" *)
  value : option Q;      (* None is "inf" *)
  about : scope
}.

(* attained: the number of a true context, none where means are compared, and those of two true groups *)
Record pair := Pair { in_true_context : option nat; higher_group : nat; lower_group : nat }.

(* An entry of pairs; its floors are each of a true context, or none for that of a mean, and of a group, with the multiplier *)
Record priced := Priced { priced_pair : pair; prices : list (option nat * nat * Q) }.

(* by, with its evidence *)
Inductive reason :=
| ByT1 (multipliers : list Q)
| ByT1paper
| ByT2
| ByT3 (multipliers : list Q)
| ByT4 (multipliers : list Q)
| ByT5
| ByT5decision (composition : option Q)
| ByT8
| ByT12 (raw_ratio : option Q)
| ByFloor
| ByT13 (attained : option pair)                                            (* AnyPolicy, NearThis *)
| ByT13floors (multipliers : list Q) (pairs : list priced) (policy : option (pair * list (list vector))) (* KeepingFloors *)
| ByT13range (multipliers : list Q).                                         (* AnyUtility, where there are none; AnyUtilityKeepingFloors *)
