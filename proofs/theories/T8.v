(* T8: filtering the context does not raise local g-fairness of a utility g = g(u). *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions Ratios.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section T8.
Variables (R : realFieldType) (X Xt A At U : finType).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R) (g : U -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (kT : policy T).

(* Every value that M_X releases is itself a context: unfiltered, the policy sees the context as it is. *)
Let filtered : X -> A -> R := utility (induced MX MA T) (fun u _ _ => g u).
Let unfiltered : Xt -> A -> R := utility (induced (@identity R Xt) MA T) (fun u _ _ => g u).

Lemma unfilteredE y a : unfiltered y a = expect (MA a) (fun b => expect (T y b) g).
Proof.
rewrite /unfiltered utility_response; apply: eq_bigr => b _; rewrite response_expect; congr (_ * _).
rewrite -(expect_point (fun y => expect (T y b) g) y); apply: eq_bigr => z _.
by rewrite /identity /point eq_sym.
Qed.

(* The filtered utility is the mean of the unfiltered ones at the released contexts. *)
Lemma filteredE x a : filtered x a = expect (MX x) (fun y => unfiltered y a).
Proof.
rewrite /filtered utility_response.
transitivity (\sum_b \sum_y MA a b * (MX x y * expect (T y b) g)).
  by apply: eq_bigr => b _; rewrite response_expect -mulr_sumr.
rewrite exchange_big; apply: eq_bigr => y _; rewrite unfilteredE mulr_sumr.
by apply: eq_bigr => b _; rewrite mulrCA.
Qed.

(* T8: L with M_X is at most L without, taken over the contexts that are released. *)
Theorem T8_context_filter r : local_le r unfiltered -> local_le r filtered.
Proof.
move=> fair x a a'; rewrite !filteredE; apply: ratio_of_means => y //.
by case: (kX x).
Qed.

(* T8 with compared cells: it is enough that groups that are compared in a context are compared in every context that
   it can release. *)
Theorem T8_all_compared (compared : X -> A -> bool) (compared_shown : Xt -> A -> bool) r :
  (forall x y a, compared x a -> 0 < MX x y -> compared_shown y a) ->
  (forall y a a', compared_shown y a -> compared_shown y a' -> unfiltered y a <= r * unfiltered y a') ->
  forall x a a', compared x a -> compared x a' -> filtered x a <= r * filtered x a'.
Proof.
move=> closed fair x a a' xa xa'; rewrite !filteredE /expect mulr_sumr; apply: ler_sum => y _.
have M0 : 0 <= MX x y by case: (kX x).
rewrite mulrCA; move: M0; rewrite le_eqVlt => /orP[/eqP<-|M0]; first by rewrite !mul0r.
by apply: ler_wpmul2l; [apply: ltW|apply: fair; apply: closed M0].
Qed.

(* T8 as claims have it: for every context filter that releases these contexts and no others. *)
Theorem T8_released (released : Xt -> bool) r : (forall x y, 0 < MX x y -> released y) ->
  (forall y a a', released y -> unfiltered y a <= r * unfiltered y a') -> local_le r filtered.
Proof.
move=> only fair x a a'.
apply: (@T8_all_compared (fun _ _ => true) (fun y _ => released y)) => // [{}x y _ _|y b b' yr _]; first exact: only.
exact: fair.
Qed.

(* When T8 holds with equality: the filtered ratio of a to a' at x is the worst unfiltered one exactly when every
   context that x can release has that ratio (where neither group gets anything it has every ratio). *)
Theorem T8_equality r x a a' : local_le r unfiltered ->
  (filtered x a = r * filtered x a' <->
   forall y, 0 < MX x y -> unfiltered y a = r * unfiltered y a').
Proof.
move=> fair; have M0 y : 0 <= MX x y by case: (kX x).
have gap_ge0 y : 0 <= MX x y * (r * unfiltered y a' - unfiltered y a) by rewrite mulr_ge0 // subr_ge0.
have gap : r * filtered x a' - filtered x a = \sum_y MX x y * (r * unfiltered y a' - unfiltered y a).
  rewrite !filteredE /expect mulr_sumr -sumrB; apply: eq_bigr => y _; ring.
split=> [same y My|same].
  have := sum_eq0 gap_ge0; rewrite -gap same subrr => /(_ erefl y) /eqP.
  by rewrite mulf_eq0 gt_eqF //= subr_eq0 => /eqP.
apply/eqP; rewrite eq_sym -subr_eq0 gap big1 // => y _.
have := M0 y; rewrite le_eqVlt => /orP[/eqP<-|My]; first by rewrite mul0r.
by rewrite same // subrr mulr0.
Qed.

End T8.

(* The paper's example: for the global figure nothing of the kind holds, even when X and A are independent.  The
   policy says yes where context and group agree; the filter of X is log 3-private; R-bar goes from 1 to 4. *)
Section Counterexample.
Let matching (x a u : bool) : rat := ((x == a) == u)%:R.
Let blur (x y : bool) : rat :=
  (if x then if y then 9%:R else 1 else if y then 7%:R else 3%:R) / 10%:R.
Let half (a : bool) (x : bool) : rat := 2%:R^-1.
Let yes (u : bool) (x : bool) (a : bool) : rat := u%:R.
Let before : bool -> rat := group_mean half (utility (induced (@identity _ [finType of bool]) (@identity _ [finType of bool]) matching) yes).
Let behind : bool -> rat := group_mean half (utility (induced blur (@identity _ [finType of bool]) matching) yes).

Theorem T8_global_counterexample :
  [/\ kernel blur /\ every_pair (pure_dp 3%:R) blur,
      policy matching /\ kernel half /\ independent half,
      global_le 1 before,
      behind true = 4%:R * behind false & 0 < behind false].
Proof.
split; [split|split; [|split]| | |].
- by case; split=> [[]|] //; rewrite big_bool.
- by do 3!case.
- by do 2!case; split=> [[]|] //; rewrite big_bool.
- by move=> a; split=> [x|] //; rewrite big_bool.
- by [].
- by do 2!case; rewrite /before /group_mean /utility /expect /induced !big_bool.
- by rewrite /behind /group_mean /utility /expect /induced !big_bool.
- by rewrite /behind /group_mean /utility /expect /induced !big_bool.
Qed.

(* So no factor below 4 bounds the filtered global ratio. *)
Corollary T8_global_counterexample_ratio r : global_le r behind -> 4%:R <= r.
Proof.
have [_ _ _ ratio pos] := T8_global_counterexample; move=> /(_ true false).
by rewrite ratio ler_pmul2r.
Qed.

End Counterexample.
