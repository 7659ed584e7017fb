(* What the checker accepts holds of the table: the main theorem. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Distances Checker.
From FairauditChecker Require Import ListsSound TableSound WidestSound BlocksSound FiguresSound FarthestSound ConstantsSound ClaimsSound LeftOutSound RatesSound HiddenSound DriftClaimsSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Statements.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).
Local Notation D := (facts_of T).

Lemma compute_sound q :
  figure_holds R T q (compute T (rows_of T) (if with_means T then with_mass (group_rows T (rows_of T)) else [::]) q).
Proof.
case: q => [||||||||o|o]; try exact: (plain_sound R ok).
- exact: (equalized_odds_sound R ok).
- exact: (demographic_parity_sound R ok).
- exact: (equal_opportunity_sound R ok).
- exact: (odds_sound R ok).
Qed.

(* What is not computed of a table without true labels is that nobody is compared. *)
Lemma figure_in_holds q : figure_holds R T q (figure_in D q).
Proof.
have := compute_sound q; rewrite /figure_in; case e: (List.find _ _) => [[q' f]|].
  by have [/in_map_iff[r [[<- <-] _]] /= /same_quantityP rq] := find_some _ _ e; rewrite rq.
have q_out : ~ List.In q (quantities T).
  move=> qin; have := find_none _ _ e (q, compute T (rows_of T) _ q) (in_map _ _ _ qin).
  by case: (q) => //= b; rewrite Bool.eqb_reflx.
have [of_q unknown] : of_rate q /\ known T = None.
  by move: q_out; rewrite /quantities; case: (known T) => [K|]; case: (q) => [||||||||[]|[]] out; try (by split); case: out => /=; tauto.
by case: q of_q {e q_out} => // o _; rewrite /compute /figure_by_rates unknown.
Qed.

Lemma figure_is q f : is_true_of D (Figure_is q f) -> holds R T (Figure_is q f).
Proof. by move/(@same_figure_holds R T q); apply; apply: figure_in_holds. Qed.

(* the greatest value, where the figure is one *)
Lemma figure_value q f : figure_holds R T q (Some f) -> exists_at_all R T q /\ greatest T q (extended R (value f)).
Proof.
move=> [ex [[comp firsts] value _]]; split=> //; split; first by exists (witness f).
by move=> p /firsts[le _]; rewrite -value.
Qed.

Lemma quantity_is q v : is_true_of D (Quantity_is q v) -> holds R T (Quantity_is q v).
Proof.
rewrite /= /equals; have := figure_in_holds q; case: (figure_in D q) => // f /figure_value[ex great].
by move/(@same_extended R) => <-.
Qed.

Lemma same_judgementP j k : same_judgement j k -> j = k.
Proof. by case: j; case: k. Qed.

Lemma target_is by_ local limit j : is_true_of D (Target_is by_ local limit j) -> holds R T (Target_is by_ local limit j).
Proof.
move/same_judgementP => -> /=; have := figure_in_holds (limited by_ local); rewrite /judged.
case: (figure_in D _) => [f /figure_value[ex [[p comp value] bound]]|//] /=.
rewrite (not_aboveE R); case: ifP => [le|/negbT gt]; first by split=> // p' /bound; move/no_more_trans; apply.
by exists p; rewrite // value.
Qed.

Lemma verdict_is targets v : is_true_of D (Verdict_is targets v) -> holds R T (Verdict_is targets v).
Proof.
rewrite /= => same; have -> : v = overall targets by case: v (overall targets) same => [v|] [w|] //= /same_judgementP ->.
have existsE f g : f =1 g -> existsb f targets = has g targets by move=> e; elim: (targets) => //= t ts ->; rewrite e.
rewrite /overall /verdict_of (existsE _ (fun j => if j is Exceeds then true else false)); last by case.
rewrite (existsE _ (fun j => if j is Depends then true else false)); last by case.
rewrite (existsE _ (fun j => if j is Inconclusive then true else false)); last by case.
by case: (targets).
Qed.

Lemma entries_are n : is_true_of D (Entries_are n) -> holds R T (Entries_are n).
Proof. by move/Z.eqb_eq. Qed.

Lemma gamma_is v : is_true_of D (Gamma_is v) -> holds R T (Gamma_is v).
Proof. by rewrite /=; case e: (greatest_in _) => [g|] // /(same_valueE R) ->; apply: gamma_sound. Qed.

Lemma least_is v : is_true_of D (Least_is v) -> holds R T (Least_is v).
Proof. by rewrite /=; case e: (least_in _) => [g|] // /(same_valueE R) ->; apply: least_sound. Qed.

Lemma lipschitz_is_ v : is_true_of D (Lipschitz_is v) -> holds R T (Lipschitz_is v).
Proof. by move=> /(same_valueE R) /= ->; apply: lipschitz_sound. Qed.

Lemma equals_value q v : equals (figure_in D q) v -> exists_at_all R T q /\ greatest T q (extended R v).
Proof. exact: quantity_is. Qed.

Lemma supremum_is local v : is_true_of D (Supremum_is local v) -> holds R T (Supremum_is local v).
Proof. by move=> /= /equals_value[_]; apply: supremum_sound. Qed.

Lemma bounds_hold q v : bounds (figure_in D q) v -> bounded_by T q (extended R v).
Proof.
rewrite /bounds; have := figure_in_holds q; case: (figure_in D q) => // f /figure_value[ex [_ below]].
by rewrite (not_aboveE R) => le; split=> // p /below; move/no_more_trans; apply.
Qed.

Lemma quantity_at_most_ by_ q v : is_true_of D (Quantity_at_most by_ q v) -> holds R T (Quantity_at_most by_ q v).
Proof.
case: by_ => /=.
  case/and4P => /same_quantityP -> indep _ le; split=> //; last exact: bounds_hold.
  exact: independent_sound.
by case/andP => _; apply: bounds_hold.
Qed.

Lemma hidden_needs_ local v ls : is_true_of D (Hidden_needs local v ls) -> holds R T (Hidden_needs local v ls).
Proof.
rewrite /=; have := figure_in_holds (if local then Local else Global); case: (figure_in D _) => [f|//] fits; apply: (frontier_sound _ fits).
by case: (local).
Qed.

Lemma stands_ s limit : is_true_of D (Stands s limit) -> holds R T (Stands s limit).
Proof.
rewrite /is_true_of /under_drift /=; case e: (Drift.stands_for_ratio _ _ _ _ _ _) => [[]|] // _.
exact: (stands_for_ratio_sound ok (figure_in_holds (ratio_of_all (is_local s))) e).
Qed.

Lemma ratio_under_drift_ local worst eta v p fs :
  is_true_of D (Ratio_under_drift local worst eta v p fs) -> holds R T (Ratio_under_drift local worst eta v p fs).
Proof.
rewrite /is_true_of /under_drift /=; case e: (Drift.ratio_holds _ _ _ _ _ _ _ _ _ _) => [[]|] // _.
exact: (ratio_holds_sound ok (figure_in_holds (ratio_of_all local)) e).
Qed.

Lemma rates_are r o rates : is_true_of D (Rates_are r o rates) -> holds R T (Rates_are r o rates).
Proof.
move=> stated; case known_: (known T) => [K|]; first exact: (@rates_sound R T ok K known_ r o rates).
by rewrite /= /rates_as_stated known_ in stated.
Qed.

Lemma not_compared_is entries : is_true_of D (Not_compared_is entries) -> holds R T (Not_compared_is entries).
Proof. exact/(left_out_sound ok)/rates_left_out_sound. Qed.

Lemma statement_sound s : is_true_of D s -> holds R T s.
Proof.
case: s => [n|q f|r o rates|v|v|v|v|b|entries|q v|local v|by_ q v|local v ls|s limit|local worst eta v p fs|by_ local limit j|targets v].
- exact: entries_are.
- exact: figure_is.
- exact: rates_are.
- exact: gamma_is.
- exact: least_is.
- exact: tau_sound.
- exact: lipschitz_is_.
- exact: depends_sound.
- exact: not_compared_is.
- exact: quantity_is.
- exact: supremum_is.
- exact: quantity_at_most_.
- exact: hidden_needs_.
- exact: stands_.
- exact: ratio_under_drift_.
- exact: target_is.
- exact: verdict_is.
Qed.
End Statements.

(* What is said to be true of a table holds of it, with numbers of any ordered field. *)
Theorem check_sound (R : realFieldType) (T : table) (ss : list statement) (os : list outcome) :
  check T ss = Some os -> forall s, List.In (s, True_) (zip ss os) -> holds R T s.
Proof.
rewrite /check; case ok: (valid T) => // -[<-] s.
elim: ss => //= t ss IH [[<-]|/IH //].
rewrite /outcome_of; case true_: (is_true_of _ t); last by case: (under_drift _ t).
by move=> _; apply: statement_sound.
Qed.
