(* What a certificate can state about a table.

   This file only has types.  When a statement holds is said in Meaning.v. *)

From Coq Require Import ZArith QArith List.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

(* What a figure is the greatest value of. *)
Inductive quantity :=
| Local | Global                                (* ratios of expectations: in a context, and of means over the contexts *)
| Equalized_odds | Demographic_parity           (* total variation distances of laws, likewise *)
| Local_supremum | Global_supremum              (* ratios of probabilities of a decision *)
| Local_difference | Global_difference          (* differences of expectations *)
| Equal_opportunity (overall : bool)            (* differences of true positive rates: in a context, or over all of them *)
| Odds_given_truth (overall : bool).            (* and of false positive rates *)

(* The number of what does not apply: of the context of what is about means, say. *)
Definition nothing : Z := (-1)%Z.

(* Rates are of those with the positive true label, or of all others. *)
Definition true_positives : Z := 0%Z.
Definition false_positives : Z := 1%Z.

(* Where two groups are compared. *)
Record place := Place {
  at_rate : Z;
  at_context : Z;
  at_decision : Z;
  higher : Z;
  lower : Z
}.

(* A figure with its witness: the first place where the greatest value is attained. *)
Record figure := Figure {
  value : option Q;      (* none: infinite *)
  witness : place;
  both : option (Q * Q); (* the two expectations, probabilities or rates *)
  raised : list Z        (* of a distance of laws: the decisions that the higher one makes more likely *)
}.

(* Limits are on a ratio, or on a difference.  Those in nats are a statement of their own. *)
Inductive measured := By_ratio | By_difference.

Definition limited (by_ : measured) (local : bool) : quantity :=
  match by_, local with
  | By_ratio, true => Local
  | By_ratio, false => Global
  | By_difference, true => Local_difference
  | By_difference, false => Global_difference
  end.

Inductive judgement := Within | Exceeds | Inconclusive | Depends.

(* What nobody was compared by, and why. *)
Inductive left_out :=
| No_decisions (context : Z) (groups : list Z)       (* no decisions recorded *)
| Alone (context : Z)                                 (* fewer than two groups *)
| No_population (groups : list Z)
| No_means_missing                                    (* a group is missing in a context and no population was given *)
| No_means_alone                                      (* fewer than two groups *)
| No_rate (rate context : Z) (groups : list Z)        (* no decisions with the (or without the) positive true label; the context is nothing: overall *)
| Rate_alone (rate context : Z).                      (* fewer than two groups *)

(* What it takes to bring a ratio down to a number: a hidden factor is too weak if both its strengths are below [balanced] (none: whatever
   they are), or one below each of a pair. *)
Record level := Level { down_to : Q; balanced : option Q; strengths : list (Q * Q) }.

(* How the law of a cell moves: by a total variation, or by a factor of each probability. *)
Inductive move := By_variation | By_factor.

(* How far all cells may move, each by itself, while what a table gives for a limit on a ratio stands; with what shows it. *)
Record stand := Stand {
  moves_by : move;
  is_local : bool;           (* of the local ratio, or of the global one *)
  keeps_limit : bool;        (* the ratio is within the limit, and stays so up to [how_far]; or exceeds it, and does below [how_far] *)
  how_far : option Q;        (* none: however far they move *)
  no_further : bool;         (* and no farther *)
  turning : option place;    (* where that is so *)
  followed : list Z          (* groups whose means are summed *)
}.

(* The theorem by which a bound is claimed. *)
Inductive theorem_cited := By_T5 | By_T7.

Inductive statement :=
(* the number of entries: rows times decisions *)
| Entries_are (n : Z)
(* the figures; none: nobody is compared *)
| Figure_is (q : quantity) (f : option figure)
| Rates_are (rate : Z) (overall : bool) (rates : list (Z * Z * Q)) (* context (nothing: overall), group, rate *)
(* the constants of the utility *)
| Gamma_is (v : Q)
| Least_is (v : Q)
| Tau_is (v : option Q)
| Lipschitz_is (v : Q)
| Depends_on_group_is (b : bool)
(* what is left out *)
| Not_compared_is (entries : list left_out)
(* claims: by enumeration, by T6, and bounds by T5 and T7 *)
| Quantity_is (q : quantity) (v : option Q)
| Supremum_is (local : bool) (v : option Q)
| Quantity_at_most (by_ : theorem_cited) (q : quantity) (v : option Q)
(* by T14: how strong a hidden factor has to be at the least to bring a ratio down to 1, and to targets; v is what brings it down to 1 *)
| Hidden_needs (local : bool) (v : option Q) (levels : list level)
(* by T16: how far cells may move while a verdict on a ratio stands; and the greatest or the least ratio when each moves by no more than eta *)
| Stands (s : stand) (limit : Q)
| Ratio_under_drift (local greatest : bool) (eta : Q) (v : option Q) (reaching : option place) (followed : list Z)
(* limits: on a local or global ratio or difference *)
| Target_is (by_ : measured) (local : bool) (limit : Q) (j : judgement)
(* the verdict, by those of all targets, those in nats included; none without targets *)
| Verdict_is (targets : list judgement) (v : option judgement).
