(* Rationals are read as the format writes them, and every rational in one way only. *)

From Coq Require Import ZArith QArith List Ascii Lia.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditChecker Require Import Json JsonStrings JsonSound Reading.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.
Local Open Scope char_scope.

(* ==== What is written for a rational (this part has to be read) ==== *)

(* A numerator without a needless zero and, where the denominator is not 1, a slash and the denominator, in lowest terms; of at most
   100,000 digits each *)
Inductive writes_unsigned : text -> Q -> Prop :=
| writes_whole s n : digits_of s = Some n -> writes_unsigned s (Qmake n 1)
| writes_fraction s t n d : digits_of s = Some n -> digits_of t = Some (Zpos d) -> d <> 1%positive -> Z.gcd n (Zpos d) = 1%Z ->
    writes_unsigned (s ++ "/" :: t) (Qmake n d).

Inductive writes : text -> Q -> Prop :=
| writes_as_it_is s q : writes_unsigned s q -> writes s q
| writes_negative s q : writes_unsigned s q -> Qnum q <> 0%Z -> writes ("-" :: s) (Qmake (- Qnum q) (Qden q)).

(* ==== Proofs ==== *)

(* ---- Digits in pieces ---- *)

Lemma joinA a b c : join a (join b c) = join (join a b) c.
Proof. by case: a b c => [? ?] [? ?] [? ?]; rewrite /join /=; f_equal; ring. Qed.

Lemma together_pushed before a : together (pushed a before) = join (together before) a.
Proof. by elim: before a => [|[b|] before IH] a //=; rewrite IH joinA. Qed.

Lemma in_piecesE s : forall before a more, in_pieces before a more s = written (join (together before) a).1 s.
Proof.
elim: s => [|c s IH] before a more; first by rewrite [LHS]/= together_pushed.
have cons n : written n (c :: s) = match digit c with Some d => written (10 * n + d) s | None => None end by [].
rewrite cons /in_pieces -/in_pieces; case: (digit c) => [d|] //.
by case: more => [|more]; rewrite IH ?together_pushed; congr written; case: a => v p; case: (together before) => w q;
  rewrite /join /fst /snd; ring.
Qed.

Lemma digits_readE s : digits_read s = digits_of s.
Proof.
rewrite /digits_read /digits_of /natural_read /natural; case: short_enough => //.
by case: s => [|c [|d s]] //; rewrite !in_piecesE.
Qed.

Lemma cut_at c s : forall before a t, cut c before s = (a, t) ->
  exists a', a = rev before ++ a' /\ match t with
    | Some t => s = a' ++ c :: t
    | None => s = a' end.
Proof.
elim: s => [|d s IH] before a t /=; first by case=> <- <-; exists []; rewrite rev_append_rev.
case: (eqcP d c) => [->|_]; first by case=> <- <-; exists []; rewrite rev_append_rev.
move/IH => [a' [-> st]]; exists (d :: a'); split; first by rewrite /= -app_assoc.
by case: t st => [t|] ->.
Qed.

Lemma cut_plain c s before : forallb (fun d => negb (d =? c)) s -> cut c before s = (rev before ++ s, None).
Proof.
elim: s before => [|d s IH] before /=; first by rewrite rev_append_rev.
by case/andP => /negbTE -> /IH ->; rewrite /= -app_assoc.
Qed.

Lemma cut_there c s t before : forallb (fun d => negb (d =? c)) s -> cut c before (s ++ c :: t) = (rev before ++ s, Some t).
Proof.
elim: s before => [|d s IH] before /=; first by rewrite Ascii.eqb_refl rev_append_rev.
by case/andP => /negbTE -> /IH ->; rewrite /= -app_assoc.
Qed.

Lemma digit_other c d : is_digit c -> ~~ is_digit d -> (c =? d) = false.
Proof. by move=> dc dd; apply/eqcP => e; rewrite e in dc; rewrite dc in dd. Qed.

Lemma digits_of_digits s n : digits_of s = Some n -> s <> [] /\ forallb is_digit s.
Proof.
rewrite /digits_of; case: short_enough => //; case: s => [|c [|d s]] //; rewrite /natural.
  by move/written_digits.
by case: (c =? "0") => // /written_digits.
Qed.

Lemma no_slash s : forallb is_digit s -> forallb (fun d => negb (d =? "/")) s.
Proof. by elim: s => //= c s IH /andP [dc /IH ->]; rewrite digit_other. Qed.

Lemma unsignedP s q : unsigned s = Some q <-> writes_unsigned s q.
Proof.
rewrite /unsigned; split=> [|].
  case e: (cut "/" [] s) => [above [below|]]; have [a' [aE sE]] := cut_at e; rewrite /= in aE; subst a' s.
    rewrite !digits_readE; case na: (digits_of above) => [n|] //; case db: (digits_of below) => [[|d|d]|] //.
    case: ifP => // /andP [/negbTE d1 /Z.eqb_eq g] [<-].
    by apply: writes_fraction => // d1'; rewrite d1' in d1.
  by rewrite digits_readE; case na: (digits_of above) => [n|] // [<-]; exact: writes_whole.
case=> {s q} [s n sn|s t n d sn td d1 g].
  have [_ /no_slash plain_] := digits_of_digits sn.
  by rewrite cut_plain // [rev [] ++ s]/= digits_readE sn.
have [_ /no_slash plain_] := digits_of_digits sn.
rewrite cut_there // [rev [] ++ s]/= !digits_readE sn td; have -> : Pos.eqb d 1 = false by apply/Pos.eqb_neq.
by rewrite g.
Qed.

Lemma unsigned_first s q : writes_unsigned s q -> exists c rest, s = c :: rest /\ is_digit c.
Proof.
case=> {s q} [s n /digits_of_digits []|s t n d /digits_of_digits [some digits] _ _ _].
  by case: s => [//|c s] _ /= /andP [dc _]; exists c, s.
by case: s some digits => [//|c s] _ /= /andP [dc _]; exists c, (s ++ "/" :: t).
Qed.

(* What is read is what is written, and all that can be written is read. *)
Theorem rationalP s q : rational s = Some q <-> writes s q.
Proof.
split.
  case: s => [|c s] //; rewrite /rational; case: (eqcP c "-") => [->|_].
    case u: (unsigned s) => [p|] //; case: (Z.eqb_spec (Qnum p) 0) => // p0 [<-].
    by apply: writes_negative => //; apply/unsignedP.
  by move/unsignedP; exact: writes_as_it_is.
case=> {s q} [s q w|s q /unsignedP u q0].
  have [c [rest [sE dc]]] := unsigned_first w; move/unsignedP: w; rewrite {}sE /rational.
  by rewrite digit_other.
by rewrite /rational u; case: Z.eqb_spec.
Qed.
