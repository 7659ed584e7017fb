(* Strings of JSON: what the program of Json.v decodes is what the bytes spell, and nothing else. *)

From Coq Require Import ZArith List Ascii Bool Orders Mergesort Permutation Sorted RelationClasses Lia.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditChecker Require Import Json.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.
Local Open Scope char_scope.

Lemma rev_appendE (T : Type) (s t : list T) : rev_append s t = rev s ++ t.
Proof. exact: rev_append_rev. Qed.

Lemma eqcP (c d : ascii) : reflect (c = d) (c =? d).
Proof. exact: Ascii.eqb_spec. Qed.

Local Arguments looked_up : simpl never.

Ltac flat := rewrite ?app_nil_r; repeat progress rewrite /= -?app_assoc ?app_nil_r; reflexivity.

(* ==== Strings ==== *)

Lemma begins_with_lowP s : begins_with_low s -> exists a b c d low rest,
  [/\ s = "\" :: "u" :: a :: b :: c :: d :: rest, hex4 a b c d = Some low & is_low low].
Proof.
case: s => [|x [|y [|a [|b [|c [|d s]]]]]] //= /andP [] /andP [] /eqcP -> /eqcP ->.
by case e: (hex4 a b c d) => [low|] // ?; exists a, b, c, d, low, s.
Qed.

Lemma decoded_sound_below n : forall s read t, (length s <= n)%nat -> decoded read s = Some t -> exists2 u, t = rev read ++ u & spells s u.
Proof.
have empty read t : decoded read [] = Some t -> exists2 u, t = rev read ++ u & spells [] u.
  by move=> [<-]; exists []; [rewrite rev_appendE | constructor].
elim: n => [|n IH] [|c s1] read t le; try exact: empty; first by simpl in le; lia.
have {IH} go s' read' : decoded read' s' = Some t -> (length s' <= n)%nat -> exists2 u, t = rev read' ++ u & spells s' u.
  by move=> d le'; exact: IH.
rewrite [decoded _ _]/=.
case pl: (plain c).
  by move/go => -[|u -> sp]; [simpl in le; lia | exists (c :: u); [flat | exact: spells_plain]].
case: s1 le go => [|e s2] // le go; case: ifP => [_|/negbFE/eqcP ->].
  case two: (two_bytes c e).
    by move/go => -[|u -> sp]; [simpl in le; lia | exists (c :: e :: u); [flat | exact: spells_two]].
  case: s2 le go => [|f s3] // le go; case three: (three_bytes c e f).
    by move/go => -[|u -> sp]; [simpl in le; lia | exists (c :: e :: f :: u); [flat | exact: spells_three]].
  case: s3 le go => [|g s4] // le go; case four: (four_bytes c e f g) => //.
  by move/go => -[|u -> sp]; [simpl in le; lia | exists (c :: e :: f :: g :: u); [flat | exact: spells_four]].
case: ifP => [/eqcP ->|_].
  case: s2 le go => [|a [|b [|c' [|d s3]]]] // le go; case h: (hex4 a b c' d) => [unit|] //.
  case: ifP => [/andP [high low]|single].
    case: (begins_with_lowP low) => a' [b' [d' [f' [lower [rest [s3E h' low']]]]]]; subst s3; rewrite h'.
    move/go => -[|u -> sp]; first by simpl in le; lia.
    exists (utf8_of_pair unit lower ++ u); first by rewrite rev_appendE rev_app_distr rev_involutive; flat.
    exact: (spells_pair h high h' low').
  move/go => -[|u -> sp]; first by simpl in le; lia.
  exists (utf8_of_unit unit ++ u); first by rewrite rev_appendE rev_app_distr rev_involutive; flat.
  exact: spells_unit.
case short: (looked_up e short_escapes) => [d|] //.
by move/go => -[|u -> sp]; [simpl in le; lia | exists (d :: u); [flat | exact: spells_short]].
Qed.

Lemma decoded_sound s t : decoded [] s = Some t -> spells s t.
Proof. by move/(decoded_sound_below (le_n _)) => [u -> sp]. Qed.

Definition beyond_ascii (c : ascii) : bool := match c with Ascii _ _ _ _ _ _ _ b => b end.

Ltac bits c := case: c => [[] [] [] [] [] [] [] []].

Lemma beyond_plain c : beyond_ascii c -> plain c = false. Proof. by bits c. Qed.
Lemma beyond_quote c : beyond_ascii c -> (c =? quote) = false. Proof. by bits c. Qed.
Lemma beyond_backslash c : beyond_ascii c -> (c =? "\") = false. Proof. by bits c. Qed.
Lemma follows_beyond c : follows c -> beyond_ascii c. Proof. by case: c => [? ? ? ? ? ? [] []]. Qed.

Lemma two_beyond a b : two_bytes a b -> beyond_ascii a /\ beyond_ascii b.
Proof. by rewrite /two_bytes => /andP [/follows_beyond -> ]; case: a => [? ? ? ? ? [] [] []]. Qed.

Lemma three_beyond a b c : three_bytes a b c -> beyond_ascii a /\ beyond_ascii b /\ beyond_ascii c.
Proof. by rewrite /three_bytes => /andP [/andP [/follows_beyond -> /follows_beyond ->]]; bits a => //; case: b. Qed.

Lemma four_beyond a b c d : four_bytes a b c d -> beyond_ascii a /\ beyond_ascii b /\ beyond_ascii c /\ beyond_ascii d.
Proof.
by rewrite /four_bytes => /andP [/andP [/andP [/follows_beyond -> /follows_beyond ->] /follows_beyond ->]]; bits a => //; case: b.
Qed.

Lemma three_not_two a b c : three_bytes a b c -> two_bytes a b = false.
Proof. by rewrite /three_bytes /two_bytes => /andP [_]; bits a => //; case: b => [? ? ? ? ? [] ? ?] //; case: follows. Qed.

Lemma four_not_two a b c d : four_bytes a b c d -> two_bytes a b = false.
Proof. by rewrite /four_bytes /two_bytes => /andP [_]; bits a => //; case: b => [? ? ? ? [] [] ? ?] //; case: follows. Qed.

Lemma four_not_three a b c d : four_bytes a b c d -> three_bytes a b c = false.
Proof.
rewrite /four_bytes /three_bytes => /andP [_].
by bits a => //; case: b => [? ? ? ? [] [] ? ?] //; case: follows => //; case: follows.
Qed.

Lemma short_not_u e c : looked_up e short_escapes = Some c -> (e =? "u") = false.
Proof. by bits e. Qed.

Lemma decoded_unit read a b c d s : decoded read ("\" :: "u" :: a :: b :: c :: d :: s) =
  if hex4 a b c d is Some u then
    if is_high u && begins_with_low s then
      if s is _ :: _ :: a' :: b' :: c' :: d' :: s' then
        if hex4 a' b' c' d' is Some low then decoded (rev_append (utf8_of_pair u low) read) s' else None
      else None
    else decoded (rev_append (utf8_of_unit u) read) s
  else None.
Proof. by []. Qed.

Lemma decoded_pair read a b c d a' b' c' d' high low s :
  hex4 a b c d = Some high -> is_high high -> hex4 a' b' c' d' = Some low -> is_low low ->
  decoded read ("\" :: "u" :: a :: b :: c :: d :: "\" :: "u" :: a' :: b' :: c' :: d' :: s)
  = decoded (rev_append (utf8_of_pair high low) read) s.
Proof.
move=> h hi h' lo; have low' : begins_with_low ("\" :: "u" :: a' :: b' :: c' :: d' :: s) by rewrite /= h' lo.
by rewrite decoded_unit h hi low' h'.
Qed.

Lemma decoded_complete s t : spells s t -> forall read, decoded read s = Some (rev read ++ t).
Proof.
elim=> {s t} [|c s t pl _ IH|a b s t two _ IH|a b c s t three _ IH|a b c d s t four _ IH|e c s t short _ IH
             |a b c d u s t h single _ IH|a b c d high a' b' c' d' low s t h hi h' lo _ IH] read.
- by rewrite /= rev_appendE.
- by rewrite /= pl IH; flat.
- have [ba bb] := two_beyond two.
  by rewrite /= beyond_plain // beyond_backslash //= two IH; flat.
- have [ba _] := three_beyond three.
  by rewrite /= beyond_plain // beyond_backslash //= (three_not_two three) three IH; flat.
- have [ba _] := four_beyond four.
  by rewrite /= beyond_plain // beyond_backslash //= (four_not_two four) (four_not_three four) four IH; flat.
- by rewrite /= short (short_not_u short) IH; flat.
- rewrite decoded_unit h single IH rev_appendE rev_app_distr rev_involutive; flat.
- rewrite (decoded_pair _ _ h hi h' lo) IH rev_appendE rev_app_distr rev_involutive; flat.
Qed.

