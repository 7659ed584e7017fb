(* T13 with floors: multipliers that bound the ratio of every policy that keeps them. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T13.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- Any linear floors: e_c . T >= tau_c ---- *)

Section Floors.
Variables (R : realFieldType) (O U C : finType) (u0 : U).
Implicit Types (T p q : O -> U -> R) (V k : R).

(* Sum over o of the greatest p - V q + sum over c of y_c e_c. *)
Definition floored_surplus p q (e : C -> O -> U -> R) (y : C -> R) V : R :=
  \sum_o greatest u0 (fun u => gain p q V o u + \sum_c y c * e c o u).

(* Any y >= 0 with floored_surplus <= sum of y_c tau_c is a proof, whoever found it. *)
Theorem T13_floor T p q (e : C -> O -> U -> R) (tau y : C -> R) V : kernel T ->
  (forall c, tau c <= value T (e c)) -> (forall c, 0 <= y c) -> floored_surplus p q e y V <= \sum_c y c * tau c ->
  value T p <= V * value T q.
Proof.
move=> kT keeps y0 h; rewrite -subr_le0 -value_gain.
have le : value T (fun o u => gain p q V o u + \sum_c y c * e c o u) <= \sum_c y c * tau c.
  by apply: le_trans h; apply: value_le.
move: le; rewrite valueD value_sum -ler_subr_addr => /le_trans; apply; rewrite subr_le0.
by apply: ler_sum => c _; apply: ler_wpmul2l.
Qed.

(* A floor of the denominator alone, with k = V - y. *)
Theorem T13_floor_one_k_pair T p q tau V k : kernel T -> tau <= value T q -> k <= V ->
  surplus u0 p q k <= (V - k) * tau -> value T p <= V * value T q.
Proof.
move=> kT te kV h; apply: le_trans (surplus_ge u0 p q k kT) _.
rewrite -[X in _ <= X * _](subrK k) addrC mulrDl ler_add2r; apply: le_trans h _.
by apply: ler_wpmul2l; rewrite ?subr_ge0.
Qed.

End Floors.

(* ---- Policies behind filters ---- *)

Section Behind.
Variables (R : realFieldType) (X Xt A At U : finType) (u0 : U).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (g : U -> X -> A -> R) (W : A -> X -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (g0 : forall u x a, 0 <= g u x a) (W0 : forall a x, 0 <= W a x).
Implicit Types (T : Xt -> At -> U -> R) (V k : R).
Local Notation E T := (utility (induced MX MA T) g).
Local Notation M T := (group_mean W (E T)).
Local Notation cell := (cell_part MX MA g).
Local Notation mean := (global_part MX MA g W).

(* tau x a is the floor of E(x,a), mean_tau a that of the mean of a; 0 where none is declared, which every policy keeps. *)
Variables (tau : X -> A -> R) (mean_tau : A -> R).
Definition keeps T : Prop := (forall x a, tau x a <= E T x a) /\ (forall a, mean_tau a <= M T a).

(* Multipliers of the floors: y of the cells, z of the means. *)
Implicit Types (y : X -> A -> R) (z : A -> R).

Definition with_floors (p q : Xt * At -> U -> R) y z V : R :=
  \sum_o greatest u0 (fun u => gain p q V o u + (\sum_x \sum_a y x a * cell x a o u + \sum_a z a * mean a o u)).
Definition of_floors y z : R := \sum_x \sum_a y x a * tau x a + \sum_a z a * mean_tau a.

Lemma floor_certificate T p q y z V : policy T -> keeps T -> (forall x a, 0 <= y x a) -> (forall a, 0 <= z a) ->
  with_floors p q y z V <= of_floors y z -> value (joint T) p <= V * value (joint T) q.
Proof.
move=> kT [cells means] y0 z0 h; have kJ := kernel_joint kT.
pose e (c : (X * A) + A) := match c with inl xa => cell xa.1 xa.2 | inr a => mean a end.
pose t (c : (X * A) + A) := match c with inl xa => tau xa.1 xa.2 | inr a => mean_tau a end.
pose w (c : (X * A) + A) := match c with inl xa => y xa.1 xa.2 | inr a => z a end.
have sumE (F : (X * A) + A -> R) : \sum_c F c = \sum_x \sum_a F (inl (x, a)) + \sum_a F (inr a).
  by rewrite big_sumType /= pair_bigA; congr (_ + _); apply: eq_bigr => -[].
apply: (@T13_floor _ _ _ _ u0 (joint T) p q e t w) => //.
- by case=> [[x a]|a] /=; rewrite -?cell_value -?mean_value.
- by case=> [[x a]|a] /=.
rewrite sumE /= (_ : floored_surplus _ _ _ _ _ _ = with_floors p q y z V) //.
by apply: eq_bigr => o _; apply: eq_greatest => u; rewrite sumE.
Qed.

(* Expected utilities in a context: multipliers of any floors. *)
Theorem T13_floor_local T y z V x a a' : policy T -> keeps T -> (forall x a, 0 <= y x a) -> (forall a, 0 <= z a) ->
  with_floors (cell x a) (cell x a') y z V <= of_floors y z -> E T x a <= V * E T x a'.
Proof. by rewrite !cell_value; apply: floor_certificate. Qed.

(* Group means: multipliers of any floors. *)
Theorem T13_floor_global T y z V a a' : policy T -> keeps T -> (forall x a, 0 <= y x a) -> (forall a, 0 <= z a) ->
  with_floors (mean a) (mean a') y z V <= of_floors y z -> M T a <= V * M T a'.
Proof. by rewrite !mean_value; apply: floor_certificate. Qed.

(* One k and the floor t of the denominator: S(k) <= (V - k) t, with the S of T13, in which the context filter drops out. *)
Theorem T13_floor_one_k T t V k x a a' : policy T -> t <= E T x a' -> k <= V ->
  local_surplus u0 MA g k x a a' <= (V - k) * t -> E T x a <= V * E T x a'.
Proof.
move=> kT te kV h; apply: le_trans (local_surplus_ge u0 MA g kX k x a a' kT) _.
rewrite -[X in _ <= X * _](subrK k) addrC mulrDl ler_add2r; apply: le_trans h _.
by apply: ler_wpmul2l; rewrite ?subr_ge0.
Qed.

Theorem T13_floor_one_k_global T t V k a a' : policy T -> t <= M T a' -> k <= V ->
  global_surplus u0 MX MA g W k a a' <= (V - k) * t -> M T a <= V * M T a'.
Proof. by move=> kT; rewrite !mean_value; apply: T13_floor_one_k_pair; apply: kernel_joint. Qed.

(* The floor of a mean: the declared one, and the mean of the floors of the cells. *)
Theorem T13_mean_floor T a : keeps T -> Num.max (mean_tau a) (\sum_x W a x * tau x a) <= M T a.
Proof.
move=> [cells means]; rewrite le_maxl means /=; apply: ler_sum => x _.
by apply: ler_wpmul2l.
Qed.

(* The claim "the greatest ratio of the policies that keep the floors is V": one of them has it. *)
Theorem T13_floor_attained T V x a a' : policy T -> keeps T -> 0 < E T x a' -> E T x a = V * E T x a' ->
  forall V', (forall T, policy T -> keeps T -> local_le V' (E T)) -> V <= V'.
Proof.
move=> kT ke pos e V' all; pose class T := policy T /\ keeps T.
apply: (@T13_attained _ _ class (fun T => E T x a) (fun T => E T x a') T) => // T' [kT' ke'].
exact: all.
Qed.

Theorem T13_floor_attained_global T V a a' : policy T -> keeps T -> 0 < M T a' -> M T a = V * M T a' ->
  forall V', (forall T, policy T -> keeps T -> global_le V' (M T)) -> V <= V'.
Proof.
move=> kT ke pos e V' all; pose class T := policy T /\ keeps T.
apply: (@T13_attained _ _ class (fun T => M T a) (fun T => M T a') T) => // T' [kT' ke'].
exact: all.
Qed.

End Behind.
