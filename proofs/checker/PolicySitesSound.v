(* The sums of PolicySites.v are what they should be: over sites, of the greatest excess and of what it takes. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions T13 T17.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound Likelihoods LikelihoodsSound PolicySites.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- The decision that is best, and of those the one that takes most ---- *)

Section Best.
Variables (R : realFieldType) (n : nat) (u0 : 'I_n) (alpha beta : 'I_n -> R) (V : R).
Hypothesis beta0 : forall u, 0 <= beta u.
Implicit Types (p q : R).

Definition net (p q : R) (u : 'I_n) : R := p * alpha u - V * (q * beta u).
Definition most (p q : R) : R := greatest u0 (net p q).
Definition choice (p q : R) (u : 'I_n) : R := if net p q u == most p q then q * beta u else -1.
Definition takes (p q : R) : R := greatest u0 (choice p q).

Lemma homogeneous_most : homogeneous most.
Proof. exact: homogeneous_greatest. Qed.

Lemma chosen p q : 0 <= q -> let u := best u0 (choice p q) in net p q u = most p q /\ q * beta u = takes p q.
Proof.
move=> q0 u; have ge := greatest_ge u0 (choice p q) (best u0 (net p q)).
have : 0 <= choice p q u.
  apply: le_trans ge; rewrite /choice -[net p q (best _ _)]/(most p q) eqxx mulr_ge0 //.
rewrite /takes /greatest -/u /choice; case: eqP => [e|_] //.
by rewrite ler0N1.
Qed.

Lemma takes_ge p q u : net p q u = most p q -> q * beta u <= takes p q.
Proof. by move=> e; apply: le_trans (greatest_ge u0 (choice p q) u); rewrite /choice e eqxx. Qed.

Lemma takes_eq p q u : net p q u = most p q -> (forall v, net p q v = most p q -> q * beta v <= q * beta u) -> 0 <= q ->
  takes p q = q * beta u.
Proof.
move=> e all q0; apply: le_anti; rewrite takes_ge // andbT; have [f <-] := chosen p q0; exact: all.
Qed.

Lemma takes0 : takes 0 0 = 0.
Proof.
have over0 v : net 0 0 v = 0 by rewrite /net !mul0r mulr0 subrr.
have most0 : most 0 0 = 0 by rewrite /most /greatest over0.
by have [_ <-] := chosen 0 (lexx 0); rewrite mul0r.
Qed.

Lemma takes_scaled s p q : 0 <= s -> 0 <= q -> takes (s * p) (s * q) = s * takes p q.
Proof.
have [-> _ _|sn s0 q0] := eqVneq s 0; first by rewrite !mul0r takes0.
have scale v : net (s * p) (s * q) v = s * net p q v by rewrite /net; ring.
have [f e] := chosen p q0; set u := best _ _ in f e; rewrite -e mulrA.
apply: takes_eq; last by rewrite mulr_ge0.
  by rewrite scale f homogeneous_most.
by move=> v; rewrite scale homogeneous_most // => /(mulfI sn) ev; rewrite -!mulrA ler_wpmul2l // e takes_ge.
Qed.

Definition takes_of (p q : R) : R := if 0 <= q then takes p q else 0.

Lemma homogeneous_takes : homogeneous takes_of.
Proof.
move=> s p q s0; rewrite /takes_of; case q0: (0 <= q); first by rewrite mulr_ge0 // takes_scaled.
have [->|sn] := eqVneq s 0; first by rewrite !mul0r lexx takes0.
by rewrite pmulr_rge0 ?q0 ?mulr0 // lt_def sn.
Qed.
End Best.

Section Integers.
Variable R : realFieldType.

Lemma embed_max x y : embed (Z.max x y) = Num.max (embed x) (embed y) :> R.
Proof.
case: (Z.max_spec x y) => -[h ->].
  by apply/esym/max_idPr/embed_le/Z.leb_le/Z.lt_le_incl.
by apply/esym/max_idPl/embed_le/Z.leb_le.
Qed.

Lemma greatest_z_ge xs x : In x xs -> embed x <= embed (greatest_z xs) :> R.
Proof.
case: xs => // y xs /=; elim: xs y => [|z xs IH] y /=; first by case=> // ->.
by rewrite embed_max le_maxr => -[->|[->|h]]; rewrite ?lexx // IH ?orbT //; [left | right].
Qed.

Lemma greatest_z_in xs : xs <> [::] -> In (greatest_z xs) xs.
Proof.
case: xs => // y xs _ /=; elim: xs y => [|z xs IH] y /=; first by left.
by case: (Z.max_spec z (fold_right Z.max y xs)) => -[_ ->]; [case: (IH y); [left | right; right] | right; left].
Qed.

Variables (k : nat) (u0 : 'I_k) (alpha beta : seq Z) (n d : Z) (c : R) (al be : 'I_k -> R).
Hypotheses (sa : size alpha = k) (sb : size beta = k) (c0 : 0 < c) (d0 : Z.lt Z0 d).
Hypotheses (alE : forall u : 'I_k, embed (nth Z0 alpha u) = c * al u) (beE : forall u : 'I_k, embed (nth Z0 beta u) = c * be u).
Hypothesis be0 : forall u, 0 <= be u.
Local Notation V := (embed n / embed d : R).
Local Notation most_ := (most u0 al be V).
Local Notation net_ := (net al be V).
Variable t : Z * Z.
Hypotheses (t1 : 0 <= embed t.1 :> R) (t2 : 0 <= embed t.2 :> R).
Local Notation es := (excesses n d alpha beta t).

Let ed : embed d != 0 :> R. Proof. by rewrite gt_eqF // embed_gt0 //; apply/Z.ltb_lt. Qed.
Let cd : 0 < c * embed d. Proof. by rewrite mulr_gt0 // embed_gt0 //; apply/Z.ltb_lt. Qed.

Lemma excesses_size : size es = k.
Proof. by rewrite size_map_list size_combine sa ?sb. Qed.

Lemma excessesE (u : 'I_k) : embed (nth (Z0, Z0) es u).1 = c * embed d * net_ (embed t.1) (embed t.2) u /\
  embed (nth (Z0, Z0) es u).2 = c * (embed t.2 * be u).
Proof.
rewrite (@nth_map_in _ _ (Z0, Z0)) ?size_combine ?sa ?sb // nth_combine ?sa ?sb //=; split.
  by rewrite -Z.add_opp_r embedD embedN !embedM alE beE /net; field.
by rewrite embedM beE mulrCA.
Qed.

Lemma in_excesses e : In e es -> exists u : 'I_k, e = nth (Z0, Z0) es u.
Proof.
move=> /(In_nth _ _ (Z0, Z0))[i [/ssrnat.ltP]]; rewrite size_length excesses_size list_nth => h <-.
by exists (Ordinal h).
Qed.

Lemma some_excess (f : Z * Z -> Z) : List.map f es <> [::].
Proof.
move=> z; have : (0 < size es)%N by rewrite excesses_size; apply: leq_ltn_trans (ltn_ord u0).
by rewrite -(size_map_list f) z.
Qed.

Lemma topP : embed (top es) = c * embed d * most_ (embed t.1) (embed t.2).
Proof.
have nonempty := @some_excess fst.
have [u eu] : exists u : 'I_k, embed (top es) = c * embed d * net_ (embed t.1) (embed t.2) u.
  rewrite /top; have /in_map_iff[e [<- /in_excesses[u ->]]] := greatest_z_in nonempty; exists u; exact: (proj1 (excessesE u)).
rewrite eu; congr (_ * _); apply/esym/greatest_eq => v; rewrite -(ler_pmul2l cd) -eu -(proj1 (excessesE v)).
apply/greatest_z_ge/in_map_iff; exists (nth (Z0, Z0) es v); split=> //; apply: in_nth.
by rewrite excesses_size.
Qed.

Lemma takenP : embed (taken es) <= c * takes u0 al be V (embed t.1) (embed t.2).
Proof.
have [_ t0] := @chosen R k u0 al be V be0 (embed t.1) _ t2.
have take0 : 0 <= takes u0 al be V (embed t.1) (embed t.2) by rewrite -t0 mulr_ge0.
have nonempty := @some_excess (fun e => if Z.eqb e.1 (top es) then e.2 else Z0).
rewrite /taken; have /in_map_iff[e [<- /in_excesses[u ->]]] := greatest_z_in nonempty.
have [e1 e2] := excessesE u; case: Z.eqb_spec => [same|_]; last by rewrite embed0 mulr_ge0 // ltW.
rewrite e2 ler_wpmul2l ?(ltW c0) //; apply: takes_ge => //.
by apply: (mulfI (lt0r_neq0 cd)); rewrite -e1 same topP.
Qed.
End Integers.

Section Sums.
Variables (R : realFieldType) (k : nat) (u0 : 'I_k) (alpha beta : seq Z) (n d : Z) (c : R) (al be : 'I_k -> R).
Hypotheses (sa : size alpha = k) (sb : size beta = k) (c0 : 0 < c) (d0 : Z.lt Z0 d).
Hypotheses (alE : forall u : 'I_k, embed (nth Z0 alpha u) = c * al u) (beE : forall u : 'I_k, embed (nth Z0 beta u) = c * be u).
Hypothesis be0 : forall u, 0 <= be u.
Local Notation V := (embed n / embed d : R).

Lemma sum_topP s : nonneg R s -> embed (sum_over top n d alpha beta s) = c * embed d * sum_of (most u0 al be V) s.
Proof.
elim: s => [|t s IH] ns; first by rewrite sum_nil mulr0 embed0.
have [t1 t2 ns'] := nonneg_cons ns; rewrite sum_cons [sum_over _ _ _ _ _ _]/(Z.add _ (sum_over top n d alpha beta s)) embedD IH //.
by rewrite (@topP R k u0 alpha beta n d c al be sa sb c0 d0 alE beE t) -mulrDr.
Qed.

Lemma sum_takenP s : nonneg R s -> embed (sum_over taken n d alpha beta s) <= c * sum_of (takes_of u0 al be V) s.
Proof.
elim: s => [|t s IH] ns; first by rewrite sum_nil mulr0 embed0.
have [t1 t2 ns'] := nonneg_cons ns; rewrite sum_cons [sum_over _ _ _ _ _ _]/(Z.add _ (sum_over taken n d alpha beta s)) embedD [leRHS]mulrDr.
apply: ler_add; last exact: IH.
by rewrite /takes_of t2; apply: takenP.
Qed.
End Sums.

(* ---- Sites ---- *)

Lemma embed_eq0 (R : realFieldType) z : (embed z == 0 :> R) = Z.eqb z Z0.
Proof. by rewrite -(@embed0 R) eq_le !embed_leE; case: z. Qed.

Section Sites.
Variables (R : realFieldType) (k m : nat) (u0 : 'I_k) (alphas betas : seq (seq Z)) (c : R) (al be : nat -> 'I_k -> R).
Hypotheses (sa : size alphas = m) (sb : size betas = m) (c0 : 0 < c).
Hypotheses (sai : forall i, (i < m)%N -> size (nth [::] alphas i) = k) (sbi : forall i, (i < m)%N -> size (nth [::] betas i) = k).
Hypotheses (alE : forall i (u : 'I_k), (i < m)%N -> embed (nth Z0 (nth [::] alphas i) u) = c * al i u).
Hypotheses (beE : forall i (u : 'I_k), (i < m)%N -> embed (nth Z0 (nth [::] betas i) u) = c * be i u).
Hypotheses (al0 : forall i u, 0 <= al i u) (be0 : forall i u, 0 <= be i u).

Lemma over_sitesP f : embed (over_sites f alphas betas) = \sum_(i < m) embed (f (nth [::] alphas i) (nth [::] betas i)) :> R.
Proof.
move: sa sb; rewrite /over_sites => <-; elim: (alphas) (betas) => [|a s IH] [|b t] //= => [_|[e]]; first by rewrite big_ord0 embed0.
by rewrite embedD IH // big_ord_recl.
Qed.

Section Value.
Variables (n d : Z).
Hypothesis d0 : Z.lt Z0 d.
Local Notation V := (embed n / embed d : R).

Lemma sites_topP s : nonneg R s -> embed (over_sites (fun alpha beta => sum_over top n d alpha beta s) alphas betas) =
  c * embed d * \sum_(i < m) sum_of (most u0 (al i) (be i) V) s.
Proof.
move=> ns; rewrite over_sitesP mulr_sumr; apply: eq_bigr => i _; have hi := ltn_ord i.
by apply: (@sum_topP R k u0 _ _ n d c _ _ (sai hi) (sbi hi) c0 d0) => // u; [apply: alE | apply: beE].
Qed.

Lemma sites_takenP s : nonneg R s -> embed (over_sites (fun alpha beta => sum_over taken n d alpha beta s) alphas betas) <=
  c * \sum_(i < m) sum_of (takes_of u0 (al i) (be i) V) s.
Proof.
move=> ns; rewrite over_sitesP mulr_sumr; apply: ler_sum => i _; have hi := ltn_ord i.
by apply: (@sum_takenP R k u0 _ _ n d c _ _ (sai hi) (sbi hi) c0 d0) => // u; [apply: alE | apply: beE].
Qed.
End Value.

(* What decisions are worth that leave the other group nothing *)
Definition all_worth i : R := greatest u0 (al i).
Definition free_choice i u : R := if be i u == 0 then al i u else -1.
Definition best_free i : R := greatest u0 (free_choice i).
Definition free_of i (p q : R) : R := p * (if q == 0 then all_worth i else best_free i).

Lemma homogeneous_free i : homogeneous (free_of i).
Proof.
move=> s p q s0; rewrite /free_of -mulrA; have [->|sn] := eqVneq s 0; first by rewrite !mul0r.
by rewrite mulf_eq0 (negbTE sn).
Qed.

Lemma some_freeP i : (i < m)%N -> some_free (nth [::] betas i) -> exists u, be i u = 0.
Proof.
move=> hi /existsb_exists[z [/(In_nth _ _ Z0)[j [/ssrnat.ltP hj <-]] /Z.eqb_eq]].
rewrite size_length sbi // in hj; rewrite list_nth => e; exists (Ordinal hj).
have /eqP := @beE i (Ordinal hj) hi; rewrite -e embed0 eq_sym mulf_eq0 (gt_eqF c0).
by move/eqP.
Qed.

Lemma best_freeP i : (exists u, be i u = 0) -> let u := best u0 (free_choice i) in [/\ be i u = 0, al i u = best_free i & 0 <= best_free i].
Proof.
move=> [v bv] u; have ge := greatest_ge u0 (free_choice i) v; move: ge; rewrite {1}/free_choice bv eqxx => ge.
have B0 : 0 <= best_free i by apply: le_trans ge.
have e : free_choice i u = best_free i by [].
by move: (B0); rewrite -e /free_choice; case: eqP => [b0|_] al_ge //; move: al_ge; rewrite ler0N1.
Qed.

Lemma free_worthP i s : (i < m)%N -> nonneg R s -> (exists u, be i u = 0) ->
  embed (free_worth (nth [::] alphas i) (nth [::] betas i) s) <= c * sum_of (free_of i) s.
Proof.
move=> hi ns some; have [_ _ B0] := best_freeP some.
set a := nth [::] alphas i; set b := nth [::] betas i.
have sai' : size a = k := sai hi; have sbi' : size b = k := sbi hi.
have in_a z : In z a -> exists u : 'I_k, embed z = c * al i u.
  move=> /(In_nth _ _ Z0)[j [/ssrnat.ltP hj <-]]; rewrite size_length sai' in hj; exists (Ordinal hj).
    by rewrite list_nth -(@alE i (Ordinal hj) hi).
have k0 : (0 < k)%N by apply: leq_ltn_trans (ltn_ord u0).
have all_le : embed (greatest_z a) <= c * all_worth i.
  have [|u ->] := in_a (greatest_z a); last by rewrite ler_wpmul2l ?(ltW c0) // greatest_ge.
  by apply: greatest_z_in => z; move: k0; rewrite -sai' z.
have free_le : embed (greatest_z (List.map (fun v => if Z.eqb v.2 Z0 then v.1 else Z0) (combine a b))) <= c * best_free i.
  have /greatest_z_in/in_map_iff[v [<- ]] : List.map (fun v => if Z.eqb v.2 Z0 then v.1 else Z0) (combine a b) <> [::].
    by move=> z; move: k0; rewrite -sai' -(size_combine (s' := b)) ?sbi' // -(size_map_list (fun v => if Z.eqb v.2 Z0 then v.1 else Z0)) z.
  move=> /(In_nth _ _ (Z0, Z0))[j [/ssrnat.ltP hj <-]]; rewrite size_length size_combine ?sai' ?sbi' // in hj.
  rewrite list_nth nth_combine ?sai' ?sbi' //=; case: Z.eqb_spec => [e|_]; last by rewrite embed0 mulr_ge0 // ltW.
  have /eqP := @beE i (Ordinal hj) hi; rewrite /= -/b e embed0 eq_sym mulf_eq0 (gt_eqF c0) /= => b0.
  rewrite -[j]/(nat_of_ord (Ordinal hj)) (@alE i (Ordinal hj) hi) ler_wpmul2l ?(ltW c0) //.
  by apply: le_trans (greatest_ge u0 _ (Ordinal hj)); rewrite /free_choice b0.
rewrite /free_worth; elim: s ns => [|t s IH] ns; first by rewrite sum_nil mulr0 embed0.
have [t1 _ ns'] := nonneg_cons ns; rewrite sum_cons [fold_right _ _ _]/(Z.add _ (fold_right _ _ s)) embedD embedM [leRHS]mulrDr.
apply: ler_add; last exact: IH.
by rewrite /free_of mulrCA ler_wpmul2l // embed_eq0; case: ifP.
Qed.

Lemma sites_freeP s : nonneg R s -> (forall i, (i < m)%N -> exists u, be i u = 0) ->
  embed (over_sites (fun alpha beta => free_worth alpha beta s) alphas betas) <= c * \sum_(i < m) sum_of (free_of i) s.
Proof.
move=> ns some; rewrite over_sitesP mulr_sumr; apply: ler_sum => i _; apply: free_worthP => //.
exact: some.
Qed.
End Sites.

(* ---- Several releases ---- *)

Section Repeated.
Variables (R : realFieldType) (A At : finType) (MA : A -> At -> R) (a a' : A) (U : R) (s : likelihoods).
Hypothesis once : stands U s (MA a) (MA a').

Lemma repeatedP n : stands (U ^+ n.+1) (repeated s n.+1) (@T17.releases R A At MA n.+1 a) (@T17.releases R A At MA n.+1 a').
Proof.
elim: n => [|n IH].
  have [ns e] := once; split=> // F hF; rewrite expr1 e // sum_words; congr (_ * _); apply: eq_bigr => b _.
  under eq_bigr => w _ do rewrite !releases_put /T17.releases !big_ord0 !mulr1.
  by rewrite sumr_const card_ffun card_ord expn0 mulr1n.
have [ns e] := joint_stands once IH; split=> // F hF; rewrite exprS e // sum_words; congr (_ * _).
by apply: eq_bigr => b _; apply: eq_bigr => w _; rewrite !releases_put.
Qed.
End Repeated.

Lemma raisedP (R : realFieldType) u n : embed (raised u n) = embed u ^+ n :> R.
Proof. by elim: n => [|n IH]; rewrite ?embed1 // exprS -IH -embedM. Qed.

Lemma same_numbersP v w : same_numbers v w -> v = w.
Proof. by elim: v w => [|a v IH] [|b w] //=; case: Z.eqb_spec => // -> /IH ->. Qed.

Lemma same_listsP v w : same_lists v w -> v = w.
Proof. by elim: v w => [|a v IH] [|b w] //=; case same: (same_numbers a b) => // /IH ->; rewrite (same_numbersP same). Qed.
