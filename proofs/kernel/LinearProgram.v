(* The linear-programming kernel: integers only.

   A row is a sparse affine form  sum_j c_j v_j + c  in variables v_j, with integer
   coefficients.  Every variable lies in a box: lower j <= unit * v_j <= upper j.
   Multipliers are integers: where a certificate has fractions, these are brought over
   one common denominator, by which the objective is multiplied ([scale]).

   [lp_check] adds  scale * objective + sum_i y_i * row_i,  puts every variable at the
   end of its box that makes the sum greatest, and accepts if that is at most 0.
   [lp_check_sound]: then the objective is at most 0 at every point of the box where all
   rows are at least 0, in whatever ordered field the point lies. *)

From Coq Require Import ZArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.algebra_tactics Require Import ring.
From FairauditKernel Require Import FractionsSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.

Section Checker.
Variable var : Type.
Variables same before : var -> var -> bool. (* the same variable; some order, for sorting *)

Record row := Row { terms : list (var * Z); constant : Z }.

Definition of_var (t t' : var * Z) : bool := before t.1 t'.1.

(* Add up neighbours that are about the same variable. *)
Fixpoint merged (ts : list (var * Z)) : list (var * Z) :=
  match ts with
  | (j, c) :: rest =>
      match merged rest with
      | (k, d) :: further => if same j k then (k, Z.add c d) :: further else (j, c) :: (k, d) :: further
      | nil => (j, c) :: nil
      end
  | nil => nil
  end.

Definition scaled_terms (y : Z) (ts : list (var * Z)) : list (var * Z) := map (fun t => (t.1, Z.mul y t.2)) ts.

Fixpoint all_terms (ms : list (Z * row)) : list (var * Z) :=
  match ms with (y, r) :: rest => scaled_terms y (terms r) ++ all_terms rest | nil => nil end.

Fixpoint all_constants (ms : list (Z * row)) : Z :=
  match ms with (y, r) :: rest => Z.add (Z.mul y (constant r)) (all_constants rest) | nil => Z0 end.

Definition combination (ms : list (Z * row)) : row := Row (merged (sort of_var (all_terms ms))) (all_constants ms).

Section Box.
Variables (unit : Z) (lower upper : var -> Z).

Definition greatest_term (t : var * Z) : Z := Z.mul t.2 (if Z.ltb Z0 t.2 then upper t.1 else lower t.1).

Fixpoint greatest_sum (ts : list (var * Z)) : Z :=
  match ts with t :: rest => Z.add (greatest_term t) (greatest_sum rest) | nil => Z0 end.

(* [unit] times the greatest value that the form of the row takes on the box *)
Definition greatest (r : row) : Z := Z.add (greatest_sum (terms r)) (Z.mul unit (constant r)).

Definition lp_check (scale : Z) (objective : row) (ms : list (Z * row)) : bool :=
  [&& Z.ltb Z0 unit, Z.ltb Z0 scale, all (fun m => Z.leb Z0 m.1) ms
    & Z.leb (greatest (combination ((scale, objective) :: ms))) Z0].
End Box.
End Checker.

Section Soundness.
Variables (R : realFieldType) (var : eqType) (same before : var -> var -> bool).
Hypothesis sameP : forall j k, same j k -> j = k.
Local Open Scope ring_scope.
Variable v : var -> R. (* a point *)

(* The value of a row at the point. *)
Definition sum_at (ts : list (var * Z)) : R := \sum_(t <- ts) embed t.2 * v t.1.
Definition value_at (r : row var) : R := sum_at (terms r) + embed (constant r).

Lemma sum_at_merged ts : sum_at (merged same ts) = sum_at ts.
Proof.
rewrite /sum_at; elim: ts => //= [[j c] rest IH]; rewrite big_cons -IH /=.
case: (merged same rest) => [|[k d] further] /=; first by rewrite big_cons.
case: ifP => [/sameP -> | _]; rewrite !big_cons //=.
by rewrite embedD mulrDl addrA.
Qed.

Lemma sum_at_sort ts : sum_at (sort (of_var before) ts) = sum_at ts.
Proof. by rewrite /sum_at; apply: perm_big; rewrite perm_sort. Qed.

Lemma sum_at_all ms : sum_at (all_terms ms) + embed (all_constants ms) = \sum_(m <- ms) embed m.1 * value_at m.2.
Proof.
elim: ms => [|[y r] rest IH] /=; first by rewrite /sum_at !big_nil add0r.
rewrite big_cons -IH /sum_at big_cat /= embedD embedM /value_at mulrDr.
suff -> : \sum_(t <- scaled_terms y (terms r)) embed t.2 * v t.1 = embed y * sum_at (terms r) by ring.
by rewrite /scaled_terms big_map mulr_sumr; apply: eq_bigr => t _ /=; rewrite embedM mulrA.
Qed.

Lemma value_at_combination ms : value_at (combination same before ms) = \sum_(m <- ms) embed m.1 * value_at m.2.
Proof. by rewrite -sum_at_all /value_at /= sum_at_merged sum_at_sort. Qed.

Section Box.
Variables (unit : Z) (lower upper : var -> Z).
Hypothesis in_box : forall j, embed (lower j) <= embed unit * v j <= embed (upper j).

Lemma greatest_termP t : embed unit * (embed t.2 * v t.1) <= embed (greatest_term lower upper t).
Proof.
case: t => j c; rewrite /greatest_term embedM /= mulrCA.
have /andP[low high] := in_box j.
case: ifP => [/(embed_gt0 R)/ltW c0 | /negbT]; first by apply: ler_wpmul2l.
by rewrite -Z.leb_antisym => /(embed_le0 R) c0; apply: ler_wnmul2l.
Qed.

Lemma greatestP r : embed unit * value_at r <= embed (greatest unit lower upper r).
Proof.
rewrite /greatest embedD embedM mulrDr ler_add2r /sum_at.
elim: (terms r) => [|t ts IH] /=; first by rewrite big_nil mulr0.
by rewrite big_cons embedD mulrDr ler_add // greatest_termP.
Qed.

(* If the check accepts, the objective is at most 0 wherever all rows are at least 0. *)
Theorem lp_check_sound scale objective ms :
  lp_check same before unit lower upper scale objective ms ->
  (forall m, List.In m ms -> 0 <= value_at m.2) ->
  value_at objective <= 0.
Proof.
case/and4P => /(embed_gt0 R) unit0 /(embed_gt0 R) scale0 y0 /(embed_le0 R) sum0 rows0.
have := le_trans (greatestP _) sum0; rewrite pmulr_rle0 // value_at_combination big_cons /=.
have rest0 : 0 <= \sum_(m <- ms) embed m.1 * value_at m.2.
  elim: ms y0 rows0 {sum0} => [|m ms IH] /=; first by rewrite big_nil.
  case/andP=> m0 y0 rows0; rewrite big_cons addr_ge0 //; last by apply: IH => // m' ?; apply: rows0; right.
  by apply: mulr_ge0; [exact: embed_ge0 | apply: rows0; left].
move=> total0; have : embed scale * value_at objective <= 0 by apply: le_trans total0; rewrite ler_addl.
by rewrite pmulr_rle0.
Qed.
End Box.
End Soundness.
