(* What PolicyShown.v says of policies that are written out, of floors and of what was declared is true. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions T13 T17.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound PolicyLaw PolicyTable PolicyClaims PolicyFacts PolicyMeans.
From FairauditChecker Require Import PolicySites PolicyWorthSound PolicyShown.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Expectations.
Variables (R : realFieldType) (S : behind).
Hypotheses (ok : valid S).
Local Notation number := (@number R).
Local Notation A := (A S).
Local Notation X := (X S).
Local Notation quantity := (@quantity R S).
Local Notation compared := (@compared R S).

Lemma mean_numbers (v : seq Q) (f : X -> R) (a : A) : size v = true_contexts S -> (forall x : X, number v x = f x) ->
  0 < mass_of R a -> ratio (expected (shares S a) v) = \sum_x share R a x * f x.
Proof.
move=> sv e m0; rewrite (@expectedP R (true_contexts S)) ?shares_size //; apply: eq_bigr => x _.
by rewrite -(shares_number x m0) e.
Qed.

(* Numbers that are expectations E(x,a) *)
Definition tells (es : seq (seq Q)) (E : X -> A -> R) : Prop :=
  size es = true_contexts S /\ forall (x : X), size (nth [::] es x) = true_groups S /\ forall a : A, number (nth [::] es x) a = E x a.

Section Told.
Variables (es : seq (seq Q)) (E : X -> A -> R).
Hypothesis told : tells es E.

Lemma quantity_ofP (c : option X) (a : A) : compared c a -> ratio (quantity_of S es (place_of c) a) = quantity c E a.
Proof.
case: told => se e; case: c => [x _|m0] /=; first by rewrite !list_nth; have [_ <-] := e x.
apply: mean_numbers => // [|x]; first by rewrite size_map_list.
rewrite /number /PolicyMeaning.number (@nth_map_in _ _ [::]) ?se // list_nth.
by have [_ <-] := e x.
Qed.

Lemma has_ratioP (V : option Q) (c : option X) p (a a' : A) : in_true_context p = place_of c -> higher_group p = a -> lower_group p = a' ->
  compared c a -> compared c a' -> has_ratio S es V p ->
  if V is Some V then 0 < quantity c E a' /\ quantity c E a = ratio V * quantity c E a' else quantity c E a' = 0 /\ 0 < quantity c E a.
Proof.
rewrite /has_ratio => -> -> -> com com'; rewrite -!quantity_ofP //; case: V => [V|].
  case/and3P => /(ratio_gt0 R) pos /(at_mostP R) le /(at_mostP R) ge; split=> //.
  by rewrite -ratio_times; apply: le_anti; rewrite le ge.
by case/andP => /Z.eqb_eq z /(ratio_gt0 R) pos; split=> //; rewrite /ratio z embed0 mul0r.
Qed.

(* ---- Floors ---- *)

Lemma floor_atP (x : X) : ratio (floor_at S x) = tau_at R x.
Proof.
rewrite /floor_at ratio_greater /tau_at /or_zero; congr (Num.max _ _); first by case: (tau (stated S)) => [q|] //=; rewrite ratio_zero.
rewrite /own_number /own /own_declared; case: (List.find _ _) => [d|] /=; last exact: ratio_zero.
by case: (tau_in d) => [q|] //; rewrite ratio_zero.
Qed.

Lemma floor_of_meansP : ratio (floor_of_means S) = declared_number R (global_tau (stated S)).
Proof. by rewrite /floor_of_means; case: (global_tau _) => [q|] //=; rewrite ratio_zero. Qed.

Lemma keepsP : keeps S es -> keeps_floors E.
Proof.
case: told => se e; case/andP => /forallb_forall cells /forallb_forall means; split=> [x a|a m0].
  have [sx <-] := e x; rewrite -floor_atP; apply: at_mostP.
  have inx : In (nat_of_ord x) (List.seq 0 (true_contexts S)) by apply/in_seq; split; [exact: Nat.le_0_l | apply/ssrnat.ltP/ltn_ord].
  have /forallb_forall := cells _ inx; rewrite list_nth; apply; apply: in_nth.
  by rewrite sx ltn_ord.
rewrite -floor_of_meansP -[mean E a]/(quantity None E a) -quantity_ofP //; apply: at_mostP.
exact: (means _ (in_populated m0)).
Qed.
End Told.

(* What everybody who is compared has, if all floors are kept *)
Lemma floor_ofP (E : X -> A -> R) (c : option X) (a : A) : keeps_floors E -> compared c a ->
  ratio (floor_of S (place_of c) a) <= quantity c E a.
Proof.
case: c => [x|] [cells means] com /=; first by rewrite floor_atP.
rewrite ratio_greater floor_of_meansP le_maxl means //= (@mean_numbers _ (fun x => tau_at R x)) //.
- by apply: ler_sum => x _; apply: ler_wpmul2l => //; apply: (@share_ge0 R S ok).
- by rewrite size_map_list size_seq_list.
by move=> x; rewrite -floor_atP /number /PolicyMeaning.number (@nth_map_in _ _ 0%N) ?size_seq_list // seq_nth_list.
Qed.

Lemma expectations_tell : tells (expectations S) (E0 R (S := S)).
Proof.
have sn (T : Type) (s : seq T) : size (numbered s) = size s by rewrite /numbered size_combine -?size_length ?seq_length.
have size_x : size (induced_weights S) = true_contexts S by rewrite size_map_list size_pieces.
split=> [|x]; first by rewrite size_map_list sn size_x.
split=> [|a]; last exact: expectationP.
rewrite /expectations (@nth_map_in _ _ (0%N, [::])) ?sn ?size_x // size_map_list sn (numberedE [::]) ?size_x //=.
by rewrite (@nth_map_in _ _ [::]) ?size_pieces.
Qed.
End Expectations.

Section Behind.
Variables (R : realFieldType) (S : behind).
Hypotheses (ok : valid S).
Local Notation MX := (@MX R S).
Local Notation MA := (@MA R S).
Local Notation MA_all := (@MA_all R S).
Local Notation g := (@g R S).
Local Notation A := (A S).
Local Notation X := (X S).
Local Notation Xt := (Xt S).
Local Notation At := (At S).
Local Notation U := (U S).
Local Notation memory := (memory S).

(* ---- What was declared ---- *)

Lemma in_gains (x : X) (a : A) (u : U) : In (nth zero (gains S x a) u) (concat (gains_of S x)).
Proof.
apply/in_concat; exists (gains S x a); split.
  apply/in_map_iff; exists (nat_of_ord a); split=> //; apply/in_seq; split; [exact: Nat.le_0_l | apply/ssrnat.ltP/ltn_ord].
by apply: in_nth; have [->] := gains_ok R ok (ltn_ord x) (ltn_ord a).
Qed.

Theorem allowed_sound d : allowed S d -> allows R S d.
Proof.
have [se e] := expectations_tell R ok; case: d => [d|t] /=; last first.
  move=> /forallb_forall all a m0; rewrite -[mean _ a]/(PolicyWorthSound.quantity None (E0 R (S := S)) a) -(quantity_ofP (conj se e)) //.
  by apply: at_mostP; exact: (all _ (in_populated m0)).
case/and5P => /Z.leb_le d0 /Nat.ltb_lt/ssrnat.ltP hx top low floor; exists (Ordinal hx); split.
- by rewrite /= Z2Nat.id.
- move: top; case: (gamma_in d) => [q|] // /(at_mostP R) top u a; apply: le_trans top.
  by apply: greatest_of_ge; apply: (in_gains (Ordinal hx)).
- move: low; case: (m_in d) => [q|] // /(at_mostP R) low u a; apply: le_trans low _.
  by apply: least_of_le; apply: (in_gains (Ordinal hx)).
move: floor; case: (tau_in d) => [q|] // /(at_mostP R) floor a; have [sx <-] := e (Ordinal hx); apply: le_trans floor _.
by apply: least_of_le; rewrite list_nth; apply: in_nth; rewrite sx ltn_ord.
Qed.

(* ---- One release is seen as such ---- *)

Hypothesis one : one_release S.

Lemma seen_once : exists e : memory -> At, (forall a w, MA_all a w = MA a (e w)) /\ forall F : At -> R, \sum_w F (e w) = \sum_b F b.
Proof.
have n1 : Pos.to_nat (releases S) = 1%N by move/Pos.eqb_eq: one => ->; rewrite Pos2Nat.inj_1.
rewrite /PolicyMeaning.MA_all /memory; move: (Pos.to_nat _) n1 => n ->.
exists (fun w : {ffun 'I_1 -> At} => w ord0); split=> [a w|F]; first by rewrite /T17.releases big_ord1.
rewrite (reindex_onto (fun b => [ffun=> b] : {ffun 'I_1 -> At}) (fun w => w ord0)) /= => [|w _].
  by apply: eq_big => b; rewrite ffunE // eqxx.
by apply/ffunP => i; rewrite ffunE (ord1 i).
Qed.

Lemma of_once (T : Xt -> At -> U -> R) : policy T -> of_any_policy (Definitions.utility (induced MX MA T) g).
Proof.
move=> kT; have [e [eM eS]] := seen_once; exists (fun y w => T y (e w)); split=> [y w|x a]; first exact: kT.
apply: eq_bigr => u _; congr (_ * _); apply: eq_bigr => y _.
by under [RHS]eq_bigr => w _ do rewrite eM; rewrite (eS (fun b => MX x y * MA a b * T y b u)).
Qed.

(* ---- A policy that is written out ---- *)

Variable rows : seq (seq vector).
Hypothesis laws : are_laws S rows.

Lemma with_laws_valid : valid (with_laws S rows).
Proof.
move: ok laws; rewrite /valid /are_laws => /and5P[gf cf two dec /and4P[_ _ w p]] /andP[shape all].
by apply/and5P; split=> //; apply/and4P; split.
Qed.

Definition T_of (y : Xt) (b : At) (u : U) : R := entry (nth [::] rows y) b u.

Lemma policy_of : policy T_of.
Proof. exact: (@policy_T0 R (with_laws S rows) with_laws_valid). Qed.

Lemma told_of : @tells R S (expectations (with_laws S rows)) (Definitions.utility (induced MX MA T_of) g).
Proof. exact: (@expectations_tell R (with_laws S rows) with_laws_valid). Qed.
End Behind.
