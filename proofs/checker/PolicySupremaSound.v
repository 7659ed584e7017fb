(* What PolicySuprema.v accepts is the greatest local ratio over all policies behind the filters. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions T13.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound PolicyLaw Likelihoods LikelihoodsSound PolicyClaims PolicyFacts PolicyBounds PolicySuprema.

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

Section Behind.
Variables (R : realFieldType) (S : behind).
Hypotheses (ok : valid S) (one : one_release S).
Local Notation MX := (@MX R S).
Local Notation MA := (@MA R S).
Local Notation MA_all := (@MA_all R S).
Local Notation g := (@g R S).
Local Notation A := (A S).
Local Notation X := (X S).
Local Notation kX := (kernel_MX R ok).
Local Notation kM := (kernel_MA_all R ok).
Local Notation g0 := (@g_ge0 R S ok).
Local Notation w0 := (u0 ok).

Definition worth_unit (x : X) : R := embed (unit_of (gains_of S x)).

Lemma worth_unit_gt0 x : 0 < worth_unit x.
Proof. by apply/embed_gt0/Z.ltb_lt/common_gt0. Qed.

Lemma gains_of_nth x (a : A) : nth [::] (gains_of S x) a = gains S x a.
Proof.
rewrite /gains_of (@nth_map_in _ _ 0%N) -?size_length ?seq_length //.
by rewrite -list_nth seq_nth //; apply/ssrnat.ltP.
Qed.

Lemma gains_of_size x : size (gains_of S x) = true_groups S.
Proof. by rewrite size_map_list -size_length seq_length. Qed.

Lemma worth_size (x : X) (a : A) : size (nth [::] (worth_at S x) a) = decisions S.
Proof.
rewrite /worth_at (@nth_map_in _ _ [::]) ?gains_of_size // size_map_list gains_of_nth.
by have [] := gains_ok R ok (ltn_ord x) (ltn_ord a).
Qed.

Lemma worthP (x : X) (a : A) (u : U S) : embed (nth Z0 (nth [::] (worth_at S x) a) u) = worth_unit x * g u x a.
Proof.
by rewrite -[LHS]/(integer R _ _) integersE ?gains_of_size // /entry /PolicyMeaning.entry gains_of_nth.
Qed.

Lemma rows_stand (a a' : A) : stands (embed (unit_of (group_matrix S))) (of_rows (nth [::] (rows_of S) a) (nth [::] (rows_of S) a')) (MA a) (MA a').
Proof.
have size_M : size (group_matrix S) = true_groups S by rewrite multiplied_out_size.
have row (c : A) := lawful_product (group_filter_ok R ok) (ltn_ord c).
apply: (@of_rowsP R _ _ _ (released_groups S) (fun j => entry (group_matrix S) a j) (fun j => entry (group_matrix S) a' j)).
- by rewrite (@nth_map_in _ _ [::]) ?size_M // size_map_list; have [] := row a.
- by rewrite (@nth_map_in _ _ [::]) ?size_M // size_map_list; have [] := row a'.
- exact: unit_of_ge0.
- by move=> j _; rewrite !integersE ?size_M.
by move=> j _; split; [have [_ p _] := row a | have [_ p _] := row a']; exact: p.
Qed.

Definition V_of (V : Q) : R := embed (Qnum V) / embed (Zpos (Qden V)).

Lemma V_ofE V : V_of V = ratio V. Proof. by []. Qed.

(* S(V) of the pair *)
Lemma surplus_once V (x : X) (a a' : A) : local_surplus w0 MA_all g V x a a' =
  \sum_b most w0 (fun u => g u x a) (fun u => g u x a') V (MA a b) (MA a' b).
Proof.
rewrite -(all_once (proj1 (Pos.eqb_eq _ _) one) a a' (most w0 (fun u => g u x a) (fun u => g u x a') V)).
by apply: eq_bigr => w _; apply: eq_greatest => u.
Qed.

Lemma surplus_le V (x : X) (a a' : A) s U : 0 < U -> stands U s (MA a) (MA a') ->
  Z.leb (sum_over top (Qnum V) (Zpos (Qden V)) (nth [::] (worth_at S x) a) (nth [::] (worth_at S x) a') s) Z0 ->
  local_surplus w0 MA_all g (ratio V) x a a' <= 0.
Proof.
move=> U0 [ns e] /(embed_le0 R); rewrite (@sum_topP R _ w0 _ _ _ _ _ _ _ (worth_size x a) (worth_size x a') (worth_unit_gt0 x) _ (worthP x a) (worthP x a')) //.
rewrite e; last exact: homogeneous_most.
by rewrite surplus_once pmulr_rle0 ?pmulr_rle0 ?mulr_gt0 ?worth_unit_gt0 ?embed_pos.
Qed.

Lemma same_numbersP v w : same_numbers v w -> v = w.
Proof. by elim: v w => [|a v IH] [|b w] //=; case: Z.eqb_spec => // -> /IH ->. Qed.

Lemma units_pos : 0 < embed (units (group_filter S)) :> R. Proof. exact: units_gt0. Qed.

Lemma context_provedP V (x : X) : context_proved S (rows_of S) (kinds (group_filter S)) (Qnum V) (Zpos (Qden V)) x ->
  forall a a' : A, a != a' -> local_surplus w0 MA_all g (ratio V) x a a' <= 0.
Proof.
rewrite /context_proved => proofs a a' aa.
have size_W : size (worth_at S x) = true_groups S by rewrite size_map_list gains_of_size.
case e: (worth_at S x) proofs => [|first rest] //.
case same: (forallb _ _) => /forallb_forall proofs.
  have eq c : In c (first :: rest) -> c = first.
    by case=> [->|/(proj1 (forallb_forall _ _) same)/same_numbersP].
  have [s sin sS] := kindsP (group_filter_ok R ok) (ltn_ord a) (ltn_ord a') aa.
  have sS' : stands (embed (units (group_filter S))) s (MA a) (MA a') := sS.
  have worth_first (c : A) : nth [::] (worth_at S x) c = first.
    by apply: eq; rewrite -e; apply: in_nth; rewrite size_W.
  have le0 := proofs s sin; rewrite -{1}(worth_first a) -(worth_first a') in le0.
  exact: (@surplus_le V x a a' s _ units_pos sS' le0).
have U0 : 0 < embed (unit_of (group_matrix S)) :> R by apply/embed_gt0/Z.ltb_lt/common_gt0.
apply: (@surplus_le V x a a' _ _ U0 (rows_stand a a')).
have sR : size (rows_of S) = size (worth_at S x) by rewrite size_map_list multiplied_out_size size_W.
have at_c (c : A) : nth ([::], [::]) (combine (rows_of S) (worth_at S x)) c = (nth [::] (rows_of S) c, nth [::] (worth_at S x) c).
  by rewrite nth_combine // sR size_W.
have := proofs (nth ([::], [::]) (combine (rows_of S) (worth_at S x)) a, nth ([::], [::]) (combine (rows_of S) (worth_at S x)) a').
rewrite !at_c /=; apply; rewrite -e -!at_c; apply: in_ordered; first by rewrite size_combine // sR size_W.
by right; exists a'; rewrite size_combine // sR size_W; split=> //; rewrite eq_sym.
Qed.

(* A policy that attains V at the pair *)
Lemma attainsP V p : 0 <= ratio V :> R -> attains S (Qnum V) (Zpos (Qden V)) p ->
  exists (T : Xt S -> memory S -> U S -> R) (x : X) (a a' : A), [/\ policy T, a != a',
    0 < Definitions.utility (induced MX MA_all T) g x a' &
    Definitions.utility (induced MX MA_all T) g x a = ratio V * Definitions.utility (induced MX MA_all T) g x a'].
Proof.
move=> V0; rewrite /attains; case: (in_true_context p) => [x0|] // /and5P[/Nat.ltb_lt/ssrnat.ltP hx /Nat.ltb_lt/ssrnat.ltP ha].
move=> /Nat.ltb_lt/ssrnat.ltP ha' differ /andP[excess0 taken0].
pose x : X := Ordinal hx; pose a : A := Ordinal ha; pose a' : A := Ordinal ha'.
rewrite !list_nth -[higher_group p]/(nat_of_ord a) -[lower_group p]/(nat_of_ord a') -[x0]/(nat_of_ord x) in excess0 taken0.
have aa : a != a' by apply/negP => /eqP e; move: differ; rewrite -[higher_group p]/(nat_of_ord a) e Nat.eqb_refl.
have [ns stand] := rows_stand a a'; set s := of_rows _ _ in ns stand excess0 taken0.
have U0 : 0 < embed (unit_of (group_matrix S)) :> R by apply/embed_gt0/Z.ltb_lt/common_gt0.
pose P := MA_all a; pose Q := MA_all a'; have kM := kernel_MA_all R ok.
have Q0 w : 0 <= Q w by case: (kM a').
pose F := most w0 (fun u => g u x a) (fun u => g u x a') (ratio V).
pose G := takes_of w0 (fun u => g u x a) (fun u => g u x a') (ratio V).
have once f : \sum_w f (P w) (Q w) = \sum_b f (MA a b) (MA a' b) := all_once (proj1 (Pos.eqb_eq _ _) one) a a' f.
have SF : \sum_w F (P w) (Q w) = 0.
  move: excess0 => /Z.eqb_eq /(congr1 (@embed R)); rewrite embed0.
  rewrite (@sum_topP R _ w0 _ _ _ _ _ _ _ (worth_size x a) (worth_size x a') (worth_unit_gt0 x) _ (worthP x a) (worthP x a')) //.
  rewrite stand; last exact: homogeneous_most.
  rewrite once => /eqP; rewrite !mulf_eq0 (gt_eqF (worth_unit_gt0 x)) (gt_eqF (embed_pos R _)) (gt_eqF U0) /=.
  by move/eqP.
have SG : 0 < \sum_w G (P w) (Q w).
  have le := @sum_takenP R _ w0 _ _ (Qnum V) _ _ _ _ (worth_size x a) (worth_size x a') (worth_unit_gt0 x) (Pos2Z.is_pos (Qden V))
    (worthP x a) (worthP x a') (fun u => g0 u x a') _ ns.
  have := lt_le_trans (embed_gt0 R taken0) le; rewrite stand; last by apply: homogeneous_takes => u; exact: g0.
  by rewrite once (pmulr_rgt0 _ (worth_unit_gt0 x)) (pmulr_rgt0 _ U0).
pose d w := best w0 (choice w0 (fun u => g u x a) (fun u => g u x a') (ratio V) (P w) (Q w)).
have best_d w := @chosen R _ w0 (fun u => g u x a) (fun u => g u x a') (ratio V) (fun u => g0 u x a') (P w) _ (Q0 w).
exists (fun=> always R d), x, a, a'.
have den : Definitions.utility (induced MX MA_all (fun=> always R d)) g x a' = \sum_w Q w * g (d w) x a'.
  exact: (@utility_always R X (Xt S) A (memory S) (U S) MX MA_all g kX d x a').
have num : Definitions.utility (induced MX MA_all (fun=> always R d)) g x a = \sum_w P w * g (d w) x a.
  exact: (@utility_always R X (Xt S) A (memory S) (U S) MX MA_all g kX d x a).
have kT : policy (fun _ : Xt S => always R d) by move=> y; apply: kernel_always.
split=> //.
  rewrite den; apply: lt_le_trans SG _; apply: ler_sum => w _.
  by rewrite /G /takes_of Q0 -(proj2 (best_d w)).
rewrite den num mulr_sumr; apply/eqP; rewrite -subr_eq0 -sumrB -[X in _ == X]SF; apply/eqP; apply: eq_bigr => w _.
exact: (proj1 (best_d w)).
Qed.

Theorem supremum_sound V p : supremum_accepted S V p -> greatest_ratio false (@of_any_policy R S) (Some V).
Proof.
case/and4P => _ /(at_mostP R); rewrite ratio_one => V1 /forallb_forall proofs attained.
have V0 : 0 <= ratio V :> R := le_trans ler01 V1.
have bound : bounded false (@of_any_policy R S) (ratio V).
  move=> E [T [kT eE]] x a a' aa; rewrite !eE.
  have inx : In (nat_of_ord x) (List.seq 0 (true_contexts S)).
    by apply/in_seq; split; [exact: Nat.le_0_l | apply/ssrnat.ltP/ltn_ord].
  have s0 := context_provedP (proofs _ inx) aa.
  exact: (proj2 (T13_local w0 MA_all g kX (ratio V) x a a') s0 T kT).
split=> // V' V1'; split=> [bound'|le E inE x a a' aa]; last first.
  apply: le_trans (bound E inE x a a' aa) _; apply: ler_wpmul2r => //.
  by have [T [kT ->]] := inE; apply: (utility_ge0 kX (kernel_MA_all R ok) g0).
case: p attained => [p|] /=; last by move=> /(at_mostP R); rewrite ratio_one => /le_trans; apply.
case/andP => /(attainsP V0)[T [x [a [a' [kT aa pos e]]]]] _.
rewrite -(ler_pmul2r pos) -e.
by have := bound' (fun x a => Definitions.utility (induced MX MA_all T) g x a); apply=> //; exists T.
Qed.
End Behind.
