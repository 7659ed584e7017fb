(* The canonical text of a string spells that string.  Of values besides strings CanonicalValues.v proves it. *)

From Coq Require Import List Ascii Bool.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditChecker Require Import Json JsonStrings Canonical.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.
Local Open Scope char_scope.

Lemma hexadecimal_digitK n : looked_up (hexadecimal_digit n) hexadecimal = Some n.
Proof. by case: n => [[[[] []] []] []]. Qed.

(* The six characters that stand for a unit are read as that unit. *)
Lemma spells_escaped u e s : is_high u && begins_with_low e = false -> spells e s -> spells (escaped_unit u ++ e) (utf8_of_unit u ++ s).
Proof.
case: u => [[[p q] r] t] single sp; apply: spells_unit => //.
by rewrite /hex4 !hexadecimal_digitK.
Qed.

Lemma low_escaped u e : begins_with_low (escaped_unit u ++ e) = is_low u.
Proof. by case: u => [[[p q] r] t]; rewrite /begins_with_low /= /hex4 !hexadecimal_digitK. Qed.

Lemma escaped_byte_spells c e s : ~~ beyond_ascii c -> spells e s ->
  spells (escaped_byte c ++ e) (c :: s) /\ begins_with_low (escaped_byte c ++ e) = false.
Proof.
move=> low sp; rewrite /escaped_byte.
have short d : looked_up d short_escapes = Some c -> (d =? "u") = false ->
    spells (["\"; d] ++ e) (c :: s) /\ begins_with_low (["\"; d] ++ e) = false.
  by move=> found notu; split; [exact: spells_short | case: (e) => [|? [|? [|? [|? ?]]]] //=; rewrite notu].
do 7 (case: ifP => [/eqcP e1|_]; first by subst c; exact: short).
case: ifP => [/andP [pl _]|pl].
  split; first exact: spells_plain.
  by case: (e) => [|? [|? [|? [|? [|? ?]]]]] //=; case: (eqcP c "\") => // c1; rewrite c1 in pl.
case: c low {short pl} => [h g f d' c' b a i] /negbTE i0; rewrite /= in i0; rewrite {}i0.
set u : unit16 := (zeros, zeros, (false, a, b, c'), (d', f, g, h)).
by split; [exact: (@spells_escaped u e s (erefl _) sp) | exact: (low_escaped u e)].
Qed.

Lemma escaped_two_spells c d e s : two_bytes c d -> spells e s ->
  spells (escaped_two c d ++ e) (c :: d :: s) /\ begins_with_low (escaped_two c d ++ e) = false.
Proof.
case: c => c5 c4 c3 c2 c1 [] [] [] //; rewrite /two_bytes ?andbF //.
case: d => d6 d5 d4 d3 d2 d1 [] [] //= some sp.
set u : unit16 := (zeros, (false, c1, c2, c3), (c4, c5, d1, d2), (d3, d4, d5, d6)).
split; last exact: (low_escaped u e).
have bytes : utf8_of_unit u = [Ascii c5 c4 c3 c2 c1 false true true; Ascii d6 d5 d4 d3 d2 d1 false true].
  by rewrite /utf8_of_unit /=; have -> : c1 || c2 || c3 || c4 by move: some; case: (c1); case: (c2); case: (c3); case: (c4).
by have := @spells_escaped u e s (erefl _) sp; rewrite bytes.
Qed.

Lemma escaped_three_spells c d e' e s : three_bytes c d e' -> spells e s ->
  spells (escaped_three c d e' ++ e) (c :: d :: e' :: s) /\ begins_with_low (escaped_three c d e' ++ e) = false.
Proof.
move=> three; have [c1 [c2 [c3 [c4 cE]]]] : exists c1 c2 c3 c4, c = Ascii c4 c3 c2 c1 false true true true.
  by move: three; rewrite /three_bytes => /andP [_]; bits c; case: (d) => // *; do 4 eexists.
move: three; rewrite {c}cE /three_bytes.
case: d => d6 d5 d4 d3 d2 d1 [] [] //; case: e' => e6 e5 e4 e3 e2 e1 [] [] //; rewrite [_ && _]/= => ok sp.
set u : unit16 := ((c1, c2, c3, c4), (d1, d2, d3, d4), (d5, d6, e1, e2), (e3, e4, e5, e6)).
have [high low] : is_high u = false /\ is_low u = false.
  by move: ok; rewrite /u /=; case: (c1); case: (c2); case: (c3); case: (c4); case: (d1); case: (d2).
split; last by have := low_escaped u e; rewrite low.
have bytes : utf8_of_unit u = [Ascii c4 c3 c2 c1 false true true true; Ascii d6 d5 d4 d3 d2 d1 false true; Ascii e6 e5 e4 e3 e2 e1 false true].
  rewrite /utf8_of_unit /=; have -> : c1 || c2 || c3 || c4 || d1 by move: ok; case: (c1); case: (c2); case: (c3); case: (c4); case: (d1).
  by [].
have single : is_high u && begins_with_low e = false by rewrite high.
by have := @spells_escaped u e s single sp; rewrite bytes.
Qed.

Lemma escaped_four_spells c d f g e s : four_bytes c d f g -> spells e s ->
  spells (escaped_four c d f g ++ e) (c :: d :: f :: g :: s) /\ begins_with_low (escaped_four c d f g ++ e) = false.
Proof.
move=> four; have [c1 [c2 [c3 cE]]] : exists c1 c2 c3, c = Ascii c3 c2 c1 false true true true true.
  by move: four; rewrite /four_bytes => /andP [_]; bits c; case: (d) => // *; do 3 eexists.
move: four; rewrite {c}cE /four_bytes.
case: d => d6 d5 d4 d3 d2 d1 [] [] //; case: f => f6 f5 f4 f3 f2 f1 [] [] //; case: g => g6 g5 g4 g3 g2 g1 [] [] //; rewrite [_ && _]/= => ok sp.
set pair := match c1, c2, c3, d1, d2 with
  | true, _, _, _, _ => (true, true, true, true)
  | _, a, b, c, d => (xorb a (negb d && negb c && negb b), xorb b (negb d && negb c), xorb c (negb d), negb d) end.
case pairE: pair => [[[h1 h2] h3] h4].
set high : unit16 := ((true, true, false, true), (true, false, h1, h2), (h3, h4, d3, d4), (d5, d6, f1, f2)).
set low : unit16 := ((true, true, false, true), (true, true, f3, f4), (f5, f6, g1, g2), (g3, g4, g5, g6)).
have text_ : escaped_four (Ascii c3 c2 c1 false true true true true) (Ascii d6 d5 d4 d3 d2 d1 false true)
    (Ascii f6 f5 f4 f3 f2 f1 false true) (Ascii g6 g5 g4 g3 g2 g1 false true) = escaped_unit high ++ escaped_unit low.
  by rewrite /escaped_four -/pair pairE.
have bytes : utf8_of_pair high low = [Ascii c3 c2 c1 false true true true true; Ascii d6 d5 d4 d3 d2 d1 false true;
    Ascii f6 f5 f4 f3 f2 f1 false true; Ascii g6 g5 g4 g3 g2 g1 false true].
  move: ok pairE; rewrite /pair /utf8_of_pair /=.
  by case: (c1); case: (c2); case: (c3); case: (d1); case: (d2) => //= _ [<- <- <- <-].
rewrite text_ -app_assoc; split; last exact: (low_escaped high).
have -> : forall t, Ascii c3 c2 c1 false true true true true :: Ascii d6 d5 d4 d3 d2 d1 false true
    :: Ascii f6 f5 f4 f3 f2 f1 false true :: Ascii g6 g5 g4 g3 g2 g1 false true :: t = utf8_of_pair high low ++ t by rewrite bytes.
by apply: spells_pair => //; rewrite /hex4 !hexadecimal_digitK.
Qed.

Lemma rev_append2 (T : Type) (p e read : list T) : rev (p ++ e) ++ read = rev e ++ rev_append p read.
Proof. by rewrite rev_appendE rev_app_distr app_assoc. Qed.

Lemma ascii_begins c : ~~ beyond_ascii c -> [/\ begins_two c = false, begins_three c = false & begins_four c = false].
Proof. by bits c. Qed.

(* UTF-8: strings of whole characters, without lone surrogates *)
Inductive whole : text -> Prop :=
| whole_nothing : whole []
| whole_byte c s : ~~ beyond_ascii c -> whole s -> whole (c :: s)
| whole_two a b s : two_bytes a b -> whole s -> whole (a :: b :: s)
| whole_three a b c s : three_bytes a b c -> whole s -> whole (a :: b :: c :: s)
| whole_four a b c d s : four_bytes a b c d -> whole s -> whole (a :: b :: c :: d :: s).

Lemma begins_2 a b : two_bytes a b -> begins_two a.
Proof. by rewrite /two_bytes => /andP [_]; bits a. Qed.
Lemma begins_3 a b c : three_bytes a b c -> begins_two a = false /\ begins_three a.
Proof. by rewrite /three_bytes => /andP [_]; bits a; case: b. Qed.
Lemma begins_4 a b c d : four_bytes a b c d -> [/\ begins_two a = false, begins_three a = false & begins_four a].
Proof. by rewrite /four_bytes => /andP [_]; bits a; case: b. Qed.

Lemma escaped_sound s : whole s -> exists2 e, spells e s & forall read, escaped_onto read s = rev e ++ read.
Proof.
elim=> {s} [|c s low _ [e sp escaped]|a b s two _ [e sp escaped]|a b c s three _ [e sp escaped]|a b c d s four _ [e sp escaped]].
- by exists []; first exact: spells_nothing.
- have [b2 b3 b4] := ascii_begins low.
  exists (escaped_byte c ++ e) => [|read]; first exact: (proj1 (escaped_byte_spells low sp)).
  by rewrite rev_append2 /= b2 b3 b4 escaped.
- exists (escaped_two a b ++ e) => [|read]; first exact: (proj1 (escaped_two_spells two sp)).
  by rewrite rev_append2 [LHS]/= (begins_2 two) escaped.
- have [b2 b3] := begins_3 three.
  exists (escaped_three a b c ++ e) => [|read]; first exact: (proj1 (escaped_three_spells three sp)).
  by rewrite rev_append2 [LHS]/= b2 b3 escaped.
- have [b2 b3 b4] := begins_4 four.
  exists (escaped_four a b c d ++ e) => [|read]; first exact: (proj1 (escaped_four_spells four sp)).
  by rewrite rev_append2 [LHS]/= b2 b3 b4 escaped.
Qed.

(* What stands for a string in a canonical text is, between its quotes, spelt for that string. *)
Theorem canonical_string s : whole s -> exists2 e, spells e s & forall read, string_onto read s = rev (quoted e) ++ read.
Proof.
move=> /escaped_sound [e sp escaped]; exists e => // read.
by rewrite /string_onto escaped /quoted /= rev_app_distr /= -app_assoc.
Qed.
