(* Products over the contrasts that Bets.v makes of profiles, in which equal ones are put together, are products over units. *)

From Coq Require Import ZArith QArith List Permutation Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.algebra_tactics Require Import ring.
From FairauditKernel Require Import Fractions.
From FairauditKernel Require WorstCase.
From FairauditChecker Require Bets.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Local Notation Q := QArith_base.Q.
Local Notation contrast := Bets.contrast.

Lemma contrast_comparable : comparable contrast.
Proof. by rewrite /comparable /decidable => c d; do ?[decide equality]. Qed.
Definition contrast_eqMixin := comparableMixin contrast_comparable.
Canonical contrast_eqType := Eval hnf in EqType contrast contrast_eqMixin.

(* ---- Products over contrasts do not depend on how equal ones are put together ---- *)

Section Products.
Variables (R : realFieldType) (f : Q -> Q -> R).

Definition power_of (c : contrast) : R := f (Bets.higher c) (Bets.lower c) ^+ Z.to_nat (Bets.number c).
Definition no_less (cs : seq contrast) : Prop := forall c, In c cs -> Z.le 0 (Bets.number c).

Lemma product_sort le (cs : seq contrast) : \prod_(c <- sort le cs) power_of c = \prod_(c <- cs) power_of c.
Proof. by apply: perm_big; rewrite perm_sort. Qed.

Lemma in_sort le (cs : seq contrast) c : In c (sort le cs) -> In c cs.
Proof.
have in_mem (ds : seq contrast) : In c ds <-> c \in ds.
  by elim: ds => //= d ds IH; rewrite in_cons; split=> [[->|/IH ->]|/orP[/eqP->|/IH]]; rewrite ?eqxx ?orbT; auto.
by move/in_mem => cin; apply/in_mem; rewrite mem_sort in cin.
Qed.

Lemma equalQ p q : equal p q -> p = q.
Proof. by case: p q => [a b] [c d] /andP[/Z.eqb_eq n_ /Z.eqb_eq d_]; move: n_ d_ => /= -> [->].
Qed.

Lemma product_merged_onto done cs : no_less done -> no_less cs ->
  \prod_(c <- Bets.merged_onto done cs) power_of c = \prod_(c <- done) power_of c * \prod_(c <- cs) power_of c
  /\ no_less (Bets.merged_onto done cs).
Proof.
elim: cs done => [|c cs IH] done n1 n2; first by rewrite big_nil mulr1.
have c0 : Z.le 0 (Bets.number c) by apply: n2; left.
have n3 : no_less cs by move=> d din; apply: n2; right.
case: done n1 => [|d done] n1 /=.
  by have [d [<-|[]]|-> ?] := IH [:: c] _ n3 => //; rewrite big_seq1 big_nil mul1r big_cons.
have d0 : Z.le 0 (Bets.number d) by apply: n1; left.
have n4 : no_less done by move=> e ein; apply: n1; right.
case: ifP => [/andP[/equalQ h /equalQ l]|_].
  have [e [<- /=|/n4 //]|-> ?] := IH (Bets.Contrast (Z.add (Bets.number d) (Bets.number c)) (Bets.higher d) (Bets.lower d) (Bets.at_place d) :: done) _ n3.
    exact: Z.add_nonneg_nonneg.
  split=> //; rewrite !big_cons.
  have -> : power_of (Bets.Contrast (Z.add (Bets.number d) (Bets.number c)) (Bets.higher d) (Bets.lower d) (Bets.at_place d)) = power_of d * power_of c.
    by rewrite /power_of /= -h -l Z2Nat.inj_add // exprD.
  by rewrite -!mulrA; congr (_ * _); rewrite mulrCA.
have [e [<- //|/n1 //]|-> ?] := IH (c :: d :: done) _ n3.
by split=> //; rewrite !big_cons -mulrA mulrCA.
Qed.

Lemma product_merged cs : no_less cs -> \prod_(c <- Bets.in_order (Bets.merged cs)) power_of c = \prod_(c <- cs) power_of c
  /\ no_less (Bets.in_order (Bets.merged cs)).
Proof.
move=> n1; rewrite /Bets.in_order product_sort /Bets.merged.
have [c []|c /in_sort /n1 //|-> n2] := @product_merged_onto [::] (sort (fun c d => Bets.no_later (Bets.two_of c) (Bets.two_of d)) cs).
by split=> [|c /in_sort /n2 //]; rewrite big_nil mul1r product_sort.
Qed.
End Products.

(* ---- Products over the contrasts of a pair of groups are products over units ---- *)

Lemma nth_nth A (x : A) s k : List.nth k s x = seq.nth x s k.
Proof. by elim: s k => [|y s IH] [|k] /=. Qed.

Section Pairs.
Variables (R : realFieldType) (f : Q -> Q -> R) (drop : bool) (top : Q).
Implicit Types (es : seq Bets.entry) (p : Bets.profile) (x y : option Q).

(* What is taken for what a unit got in the first and in the second group, if it is bet on *)
Definition first_part x : Q := if x is Some q then times q (inverse top) else one.
Definition second_part y : Q := if y is Some q then times q (inverse top) else zero.
Definition bet_on x y : bool := ~~ drop || isSome x && isSome y.
Definition one_unit x y : R := if bet_on x y then f (first_part x) (second_part y) else 1.

Lemma product_entries k l es n : (forall e, In e es -> Z.lt 0 e.1) ->
  let cs := List.flat_map (fun ie : Z * Bets.entry => Bets.contrast_of drop k l ie.1 ie.2)
    (WorstCase.numbered n [seq Bets.as_parts top e | e <- es]) in
  \prod_(c <- cs) power_of f c = \prod_(e <- es) one_unit (seq.nth None e.2 k) (seq.nth None e.2 l) ^+ Z.to_nat e.1 /\ no_less cs.
Proof.
elim: es n => [|[m p] es IH] n pos /=; first by rewrite !big_nil; split=> // c [].
have pos' e : In e es -> Z.lt 0 e.1 by move=> ein; apply: pos; right.
move: (IH (Z.add n 1) pos') => /= [pr less].
have m0 : Z.lt 0 m by apply: (pos (m, p)); left.
rewrite big_cat big_cons -{}pr /=.
have got_ i : Bets.got i (Bets.as_parts top (m, p)) = option_map (fun q => times q (inverse top)) (seq.nth None p i).
  by rewrite /Bets.got /Bets.as_parts nth_nth; elim: p i {less pos} => [|v p IHp] [|i] //=.
have -> : \prod_(c <- Bets.contrast_of drop k l n (Bets.as_parts top (m, p))) power_of f c =
    one_unit (seq.nth None p k) (seq.nth None p l) ^+ Z.to_nat m.
  rewrite /Bets.contrast_of !got_ /one_unit /bet_on; case: (seq.nth None p k) => [u|]; case: (seq.nth None p l) => [v|] /=;
    by case: (drop) => /=; rewrite ?big_seq1 ?big_nil ?expr1n.
have m1 := Z.lt_le_incl _ _ m0.
split=> // c cin; case: (in_app_or _ _ _ cin) => [|/less //]; rewrite /Bets.contrast_of.
by case: (Bets.got k _) => [u|]; case: (Bets.got l _) => [v|]; case: (drop) => // -[<- //|[]].
Qed.

Lemma product_contrasts k l es : (forall e, In e es -> Z.lt 0 e.1) ->
  let cs := Bets.contrasts_of drop [seq Bets.as_parts top e | e <- es] (k, l) in
  \prod_(c <- cs) power_of f c = \prod_(e <- es) one_unit (seq.nth None e.2 k) (seq.nth None e.2 l) ^+ Z.to_nat e.1 /\ no_less cs.
Proof.
move=> pos /=; move: (product_entries k l Z0 pos) => /= [<- less].
by have [-> ?] := product_merged f less; split.
Qed.

Lemma product_listed (G : Bets.profile -> R) es :
  \prod_(e <- es) G e.2 ^+ Z.to_nat e.1 = \prod_(p <- flatten [seq nseq (Z.to_nat e.1) e.2 | e <- es]) G p.
Proof.
elim: es => [|e es IH]; first by rewrite !big_nil.
rewrite big_cons IH /= big_cat; congr (_ * _).
by elim: (Z.to_nat e.1) => [|n IHn]; rewrite ?big_nil //= big_cons exprS IHn.
Qed.

Lemma product_permutation A (G : A -> R) (s t : seq A) : Permutation s t -> \prod_(x <- s) G x = \prod_(x <- t) G x.
Proof.
elim=> //= [x s' t' _ IH|x y s'|s1 s2 s3 _ -> _ -> //]; first by rewrite !big_cons IH.
by rewrite !big_cons mulrCA.
Qed.
End Pairs.
