(* Hypotheses that can be met: bets on contrasts within units (see Witnesses.v).

   Two units, each of which gets 1 in both groups, or nothing, with the probability 1/2; one bet of half of the capital. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions Draws Coverage Ville Betting Witnesses.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Definition half : rat := 2%:R^-1.
Definition one_bet : seq rat := [:: half].
Definition fair (h : seq bool) (u : bool) : rat := even true u.
Definition got (u : bool) : rat := u%:R.
Definition gets (i d u : bool) : rat := got u.
Definition one_context (i : bool) : unit := tt.
Definition everybody (i j d : bool) : bool := true.
Definition halves (i : bool) : rat := half.
Definition no_gain : {set {ffun bool -> bool}} := [set [ffun=> false]].

Lemma law_fair h : law (fair h). Proof. exact: (k_even true). Qed.
Lemma half01 l : l \in one_bet -> 0 <= l <= 1. Proof. by rewrite inE => /eqP->. Qed.
Lemma got_1 u : got u <= 1. Proof. by case: u. Qed.
Lemma got_0 u : 0 <= got u. Proof. by case: u. Qed.
Lemma mean_got d : expect (even d) got = half. Proof. by rewrite /expect big_bool; apply/eqP. Qed.
Lemma alike h : 1 * expect (fair h) got <= expect (fair h) got. Proof. by rewrite mul1r. Qed.
Lemma means_got (i j d : bool) : compared one_context i j -> everybody i j d ->
  halves i <= expect (even d) (gets i d) /\ expect (even d) (gets j d) <= halves j.
Proof. by rewrite !mean_got. Qed.
Lemma one0 : 0 <= (1 : rat). Proof. by []. Qed.
Lemma halves0 i : 0 <= halves i. Proof. by []. Qed.

Lemma kept_factor (R : realFieldType) (l r : R) : 1 + l * (r * 0 - 0) = 1. Proof. by rewrite mulr0 subr0 mulr0 addr0. Qed.

Lemma kept_all r i j : wealth_of everybody gets gets (fun _ _ => one_bet) i j r [ffun=> false] = 1.
Proof.
rewrite /wealth_of /wealth big_seq1 divr1 /won big1 // => d _.
have -> : gets i d ([ffun=> false] d) = 0 by rewrite /gets ffunE.
have -> : gets j d ([ffun=> false] d) = 0 by rewrite /gets ffunE.
exact: kept_factor.
Qed.

Example ville_applies : 2%:R * prob (fun w : 3.-tuple bool => chance fair [::] w) [set w : 3.-tuple bool | ever (fun=> 1 : rat) 2%:R [::] w] <= 1.
Proof.
have super : supermartingale fair (fun=> 1 : rat) by move=> h; rewrite -mulr_suml (proj2 (law_fair h)).
exact: (ville law_fair 3 (fun=> one0) super two0).
Qed.

Example mixture_ville_applies :
  prob (fun w : 3.-tuple bool => chance fair [::] w) [set w : 3.-tuple bool | ever (capital got got 1 one_bet) half^-1 [::] w] <= half.
Proof. exact: (mixture_ville law_fair one0 got_1 got_0 _ half01 alike 3). Qed.

Lemma wrong_upper w : w \in no_gain -> proves_wrong_upper one_context halves everybody gets gets (fun _ _ => one_bet) 1 w.
Proof.
rewrite inE => /eqP->; exists 0; split=> // [most|i j _]; last by rewrite kept_all.
by have := most true false isT; rewrite /Coverage.E mul0r.
Qed.

Lemma wrong_lower w : w \in no_gain -> proves_wrong_lower one_context halves everybody gets gets (fun _ _ => one_bet) 1 [:: (true, false)] w.
Proof.
rewrite inE => /eqP->; exists half; split=> // [[i [j [_ le _]]]|]; first by move: le.
by rewrite /mean_of_pairs big_seq1 kept_all.
Qed.

Lemma one_pair p : p \in [:: (true, false)] -> compared one_context p.1 p.2. Proof. by rewrite inE => /eqP->. Qed.

Example bets_upper_applies : prob (units_law even) no_gain <= 1.
Proof. exact: (bets_upper k_even halves0 (fun _ _ => got_1) (fun _ _ => got_0) (fun _ _ => half01) means_got one0 wrong_upper). Qed.

Example bets_lower_applies : prob (units_law even) no_gain <= 1.
Proof. exact: (bets_lower k_even halves0 (fun _ _ => got_1) (fun _ _ => got_0) (fun _ _ => half01) means_got one0 one_pair wrong_lower). Qed.

Example bets_together_applies : prob (units_law even) no_gain <= 1 + 1.
Proof.
exact: (bets_together k_even halves0 (fun _ _ => got_1) (fun _ _ => got_0) (fun _ _ => half01) means_got one0 one_pair
  (fun w wS => or_intror (wrong_lower wS))).
Qed.
