(* What PolicySuprema.v accepts is the greatest ratio over all policies behind the filters. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions T13 T17.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound PolicyLaw Likelihoods LikelihoodsSound PolicyClaims PolicyFacts PolicyMeans.
From FairauditChecker Require Import PolicySites PolicySitesSound PolicyWorthSound PolicySuprema.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

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
Local Notation U := (U S).
Local Notation memory := (memory S).
Local Notation kX := (kernel_MX R ok).
Local Notation kM := (kernel_MA_all R ok).
Local Notation w0 := (u0 ok).
Local Notation quantity := (@quantity R S).
Local Notation compared := (@compared R S).
Local Notation worth := (@worth R S).
Local Notation worth_ge0 := (@worth_ge0 R S ok).
Implicit Types (c : option X) (a : A) (T : Xt -> memory -> U -> R).

(* ---- Likelihoods of all releases ---- *)

Lemma all_releases P : (forall n, P n.+1) -> P (Pos.to_nat (releases S)).
Proof. by move=> all; have := Pos2Nat.is_pos (releases S); case: (Pos.to_nat _) => [/Nat.nlt_0_r|n]. Qed.

Definition row_likelihoods (a a' : nat) : likelihoods :=
  repeated (of_rows (nth [::] (rows_of S) a) (nth [::] (rows_of S) a')) (times_released S).

Lemma repeated_stands V s (a a' : A) : stands V s (MA a) (MA a') -> stands (V ^+ times_released S) (repeated s (times_released S)) (MA_all a) (MA_all a').
Proof.
move=> sS; rewrite /times_released /MA_all /memory.
by apply: (all_releases (P := fun n => stands (V ^+ n) (repeated s n) (@T17.releases R A (At S) MA n a) (@T17.releases R A (At S) MA n a'))) => n;
  apply: repeatedP.
Qed.

Lemma rows_stand (a a' : A) : stands (embed (rows_unit S)) (row_likelihoods a a') (MA_all a) (MA_all a').
Proof.
rewrite /rows_unit raisedP; apply: repeated_stands.
have size_M : size (group_matrix S) = true_groups S by rewrite multiplied_out_size.
have row (b : A) := lawful_product (group_filter_ok R ok) (ltn_ord b).
apply: (@of_rowsP R _ _ _ (released_groups S) (fun j => entry (group_matrix S) a j) (fun j => entry (group_matrix S) a' j)).
- by rewrite (@nth_map_in _ _ [::]) ?size_M // size_map_list; have [] := row a.
- by rewrite (@nth_map_in _ _ [::]) ?size_M // size_map_list; have [] := row a'.
- exact: unit_of_ge0.
- by move=> j _; rewrite !integersE ?size_M.
by move=> j _; split; [have [_ p _] := row a | have [_ p _] := row a']; exact: p.
Qed.

Lemma rows_unit_gt0 : 0 < embed (rows_unit S) :> R.
Proof. by rewrite /rows_unit raisedP exprn_gt0 //; apply/embed_gt0/Z.ltb_lt/common_gt0. Qed.

Lemma kinds_unit_gt0 : 0 < embed (kinds_unit S) :> R.
Proof. by rewrite /kinds_unit raisedP exprn_gt0 // units_gt0. Qed.

Lemma kinds_stand (a a' : A) : a != a' -> exists2 s, In s (all_kinds S) & stands (embed (kinds_unit S)) s (MA_all a) (MA_all a').
Proof.
move=> aa; have [s sin sS] := kindsP (group_filter_ok R ok) (ltn_ord a) (ltn_ord a') aa.
exists (repeated s (times_released S)); first by apply/in_map_iff; exists s.
by rewrite /kinds_unit raisedP; apply: repeated_stands.
Qed.

(* ---- Groups that are compared ---- *)

Lemma group_at c a : compared c a -> exists2 i, (i < size (groups_in S (place_of c)))%N & nth 0%N (groups_in S (place_of c)) i = a.
Proof.
case: c => [x _|m0] /=; first by exists (nat_of_ord a); rewrite ?size_seq_list // seq_nth_list.
by have [i [/ssrnat.ltP hi ei]] := In_nth _ _ 0%N (in_populated m0); exists i; rewrite -?list_nth.
Qed.

Lemma is_group c i : In i (groups_in S (place_of c)) -> exists2 a : A, i = a & compared c a.
Proof.
case: c => [x|] /=; last by move=> /(populatedP R)[a -> m0]; exists a.
by move=> /in_seq[_ /ssrnat.ltP hi]; exists (Ordinal hi).
Qed.

Section Proved.
Variables (test : Z -> likelihoods -> seq (seq Z) -> seq (seq Z) -> Q -> bool) (otherwise : nat -> nat -> bool) (c : option X) (floor : nat -> Q).
Local Notation sides := (sides S (rows_of S) (place_of c) floor).
Local Notation groups := (groups_in S (place_of c)).

Lemma side_at a : compared c a -> exists2 i, (i < size sides)%N &
  forall d, nth d sides i = Side a (nth [::] (rows_of S) a) (sites_at c a) (floor a).
Proof.
move=> /group_at[i hi ei]; exists i => [|d]; first by rewrite size_map_list.
by rewrite (@nth_map_in _ _ 0%N) // ei !list_nth.
Qed.

Lemma provedP : proved S (rows_of S) (all_kinds S) test otherwise (place_of c) floor ->
  forall a a', compared c a -> compared c a' -> a != a' -> otherwise a a' \/
    exists V s f, [/\ 0 < embed V :> R, stands (embed V) s (MA_all a) (MA_all a'), ratio f = ratio (floor a') :> R
      & test (Z.mul (unit_of (worths S (place_of c))) V) s (sites_at c a) (sites_at c a') f].
Proof.
rewrite /proved; cbv zeta => proofs a a' com com' aa.
have [i hi ei] := side_at com; have [i' hi' ei'] := side_at com'.
case e: sides proofs => [|first rest]; first by move: hi; rewrite e.
move=> /orP[/andP[/forallb_forall same /forallb_forall proofs]|/forallb_forall proofs].
  right; have eq t : In t (first :: rest) -> its_worth first = its_worth t /\ ratio (its_floor first) = ratio (its_floor t) :> R.
    by case=> [->|/same/andP[/same_listsP -> /(equalP R) ->]].
  have [s sin sS] := kinds_stand aa; exists (kinds_unit S), s, (its_floor first).
  have [w1 _] : its_worth first = its_worth (nth first sides i) /\ ratio (its_floor first) = ratio (its_floor (nth first sides i)) :> R.
    by apply: eq; rewrite -e; apply: in_nth.
  have [w2 f2] : its_worth first = its_worth (nth first sides i') /\ ratio (its_floor first) = ratio (its_floor (nth first sides i')) :> R.
    by apply: eq; rewrite -e; apply: in_nth.
  rewrite ei /= in w1; rewrite ei' /= in w2 f2; split=> //; first exact: kinds_unit_gt0.
  by rewrite -{1}w1 -w2; apply: proofs.
have ne : i' != i by apply: contraNneq aa => ii; have := ei first; rewrite -ii ei' => -[/val_inj ->].
have := proofs (nth first sides i, nth first sides i'); rewrite ei ei' /= => test_.
have inside : In (Side a (nth [::] (rows_of S) a) (sites_at c a) (floor a), Side a' (nth [::] (rows_of S) a') (sites_at c a') (floor a')) (ordered [::] (first :: rest)).
  by rewrite -e -(ei first) -(ei' first); apply: in_ordered => //; right; exists i'.
case/orP: (test_ inside) => h; last by left.
right; exists (rows_unit S), (row_likelihoods a a'), (floor a'); split=> //; [exact: rows_unit_gt0 | exact: rows_stand].
Qed.
End Proved.

(* ---- What sums over sites say ---- *)

Definition V_of (V : Q) : R := embed (Qnum V) / embed (Zpos (Qden V)).

(* The greatest excess of two groups: S(V) *)
Definition excess c a a' (V : R) : R := \sum_(i < sites_of c) \sum_w most w0 (worth c a i) (worth c a' i) V (MA_all a w) (MA_all a' w).

Lemma excessP c a a' (V : Q) W s : compared c a -> compared c a' -> stands (embed W) s (MA_all a) (MA_all a') ->
  embed (over_sites (fun alpha beta => sum_over top (Qnum V) (Zpos (Qden V)) alpha beta s) (sites_at c a) (sites_at c a')) =
  unit_in R c * embed (Zpos (Qden V)) * (embed W * excess c a a' (ratio V)).
Proof.
move=> com com' [ns e]; have [sa at_a] := sites_atP ok com; have [sa' at_a'] := sites_atP ok com'.
rewrite (@sites_topP R (decisions S) (sites_of c) w0 _ _ (unit_in R c) (worth c a) (worth c a') sa sa' (unit_in_gt0 R c)) //.
- rewrite /excess !mulr_sumr; apply: eq_bigr => i _; rewrite e //; exact: homogeneous_most.
- by move=> i hi; have [] := at_a i hi.
- by move=> i hi; have [] := at_a' i hi.
- by move=> i u hi; have [_ ->] := at_a i hi.
by move=> i u hi; have [_ ->] := at_a' i hi.
Qed.

Lemma no_excessP c a a' (V f : Q) W s : compared c a -> compared c a' -> 0 < embed W :> R ->
  stands (embed W) s (MA_all a) (MA_all a') -> no_excess V (Z.mul (unit_of (worths S (place_of c))) W) s (sites_at c a) (sites_at c a') f ->
  excess c a a' (ratio V) <= 0.
Proof.
move=> com com' W0 sS /(embed_le0 R); rewrite (excessP V com com' sS).
by rewrite pmulr_rle0 ?pmulr_rle0 // mulr_gt0 ?unit_in_gt0 ?embed_pos.
Qed.

Lemma in_places c : In (place_of c) (places S (~~ isSome c)).
Proof.
case: c => [x|]; last by left.
apply/in_map_iff; exists (nat_of_ord x); split=> //; apply/in_seq; split; [exact: Nat.le_0_l | apply/ssrnat.ltP/ltn_ord].
Qed.

Theorem never_exceededP means V : never_exceeded S means V -> bounded means (@of_any_policy R S) (ratio V).
Proof.
move=> /forallb_forall proofs E [T [kT eE]]; apply/withinP => c em a a' com com' aa; rewrite !(eq_quantity c _ eE).
have := proofs (place_of c); rewrite em => /(_ (in_places c)) /provedP/(_ a a' com com' aa)[//|[W [s [f [W0 sS _ le]]]]].
apply: le_trans (quantity_le ok c (ratio V) a a' kT) _; rewrite -[leRHS]addr0 ler_add2l.
exact: no_excessP le.
Qed.

(* A pair as it is named *)
Lemma is_pairP means p : is_pair S means p -> exists c a a', [/\ means = ~~ isSome c, in_true_context p = place_of c,
  higher_group p = a /\ lower_group p = a', compared c a /\ compared c a' & a != a'].
Proof.
rewrite /is_pair => /and4P[place /existsb_exists[h [inh /Nat.eqb_eq eh]] /existsb_exists[l [inl /Nat.eqb_eq el]] /negP ne].
have [c em ep] : exists2 c : option X, means = ~~ isSome c & in_true_context p = place_of c.
  case: (in_true_context p) place => [x /andP[/negbTE -> /Nat.ltb_lt/ssrnat.ltP hx]|]; last by exists None.
  by exists (Some (Ordinal hx)).
rewrite ep -eh in inh; rewrite ep -el in inl; have [a ea com] := is_group inh; have [a' ea' com'] := is_group inl.
exists c, a, a'; split=> //; apply/negP => /eqP e; apply: ne; apply/Nat.eqb_eq.
by rewrite ea ea' e.
Qed.

(* A policy that attains V at the pair *)
Definition attaining means (V : option Q) : Prop := exists c T a a', [/\ means = ~~ isSome c, policy T, compared c a /\ compared c a', a != a' &
  let E := Definitions.utility (induced MX MA_all T) g in
  if V is Some V then 0 < quantity c E a' /\ quantity c E a = ratio V * quantity c E a' else quantity c E a' = 0 /\ 0 < quantity c E a].

Lemma attainsP means V p : is_pair S means p -> attains S (Qnum V) (Zpos (Qden V)) p -> attaining means (Some V).
Proof.
case/is_pairP => c [a [a' [em ep [eh el] [com com'] aa]]]; rewrite /attains /with_pair ep eh el !list_nth -!/(sites_at c _) -/(row_likelihoods a a').
have sS := rows_stand a a'; have W0 := rows_unit_gt0; case/andP => /Z.eqb_eq/(congr1 (@embed R)); rewrite embed0 (excessP V com com' sS).
move=> /eqP; rewrite !mulf_eq0 (gt_eqF (unit_in_gt0 R c)) (gt_eqF (embed_pos R _)) (gt_eqF W0) /= => /eqP none /(embed_gt0 R) some.
have [sa at_a] := sites_atP ok com; have [sa' at_a'] := sites_atP ok com'.
have [ns e] := sS.
have := lt_le_trans some (@sites_takenP R (decisions S) (sites_of c) w0 _ _ (unit_in R c) (worth c a) (worth c a') sa sa' (unit_in_gt0 R c)
  (fun i hi => proj1 (at_a i hi)) (fun i hi => proj1 (at_a' i hi)) (fun i u hi => proj2 (at_a i hi) u) (fun i u hi => proj2 (at_a' i hi) u)
  (fun i u => worth_ge0 c a' i u) _ _ (Pos2Z.is_pos (Qden V)) _ ns).
rewrite pmulr_rgt0 ?unit_in_gt0 // => taken0.
pose d (i : nat) w := best w0 (choice w0 (worth c a i) (worth c a' i) (ratio V) (MA_all a w) (MA_all a' w)).
have Q0 w : 0 <= MA_all a' w by case: (kM a').
have best_d i w := @chosen R _ w0 (worth c a i) (worth c a' i) (ratio V) (fun u => worth_ge0 c a' i u) (MA_all a w) _ (Q0 w).
exists c, (@deciding R S c d), a, a'; split=> //; first exact: policy_deciding.
cbv zeta; rewrite !(quantity_deciding R ok); split.
  have : 0 < embed (rows_unit S) * \sum_(i < sites_of c) \sum_w takes_of w0 (worth c a i) (worth c a' i) (ratio V) (MA_all a w) (MA_all a' w).
    rewrite mulr_sumr; apply: lt_le_trans taken0 _; apply: ler_sum => i _; rewrite e //.
    by apply: homogeneous_takes => u; apply: worth_ge0.
  rewrite (pmulr_rgt0 _ W0) => /lt_le_trans; apply; apply: ler_sum => i _; apply: ler_sum => w _.
  by rewrite /takes_of Q0 -(proj2 (best_d i w)).
apply/eqP; rewrite -subr_eq0 -[X in _ == X]none /excess mulr_sumr -sumrB; apply/eqP; apply: eq_bigr => i _.
rewrite mulr_sumr -sumrB; apply: eq_bigr => w _; exact: (proj1 (best_d i w)).
Qed.

Lemma gives_nothingP means p : is_pair S means p -> gives_nothing S p -> attaining means None.
Proof.
case/is_pairP => c [a [a' [em ep [eh el] [com com'] aa]]].
rewrite /gives_nothing /with_pair ep eh el !list_nth -!/(sites_at c _) -/(row_likelihoods a a').
case/andP => free /(embed_gt0 R) some; have W0 := rows_unit_gt0; have [ns e] := rows_stand a a'.
have [sa at_a] := sites_atP ok com; have [sa' at_a'] := sites_atP ok com'.
have frees i : (i < sites_of c)%N -> exists u, worth c a' i u = 0.
  move=> hi; apply: (@some_freeP R (decisions S) (sites_of c) (sites_at c a') (unit_in R c) (worth c a') (unit_in_gt0 R c)
    (fun i hi => proj1 (at_a' i hi)) (fun i u hi => proj2 (at_a' i hi) u) _ hi).
  by apply: (@forallb_nth _ [::] _ _ _ free); rewrite sa'.
have := lt_le_trans some (@sites_freeP R (decisions S) (sites_of c) w0 _ _ (unit_in R c) (worth c a) (worth c a') sa sa' (unit_in_gt0 R c)
  (fun i hi => proj1 (at_a i hi)) (fun i hi => proj1 (at_a' i hi)) (fun i u hi => proj2 (at_a i hi) u) (fun i u hi => proj2 (at_a' i hi) u)
  (fun i u => worth_ge0 c a i u) _ ns frees).
rewrite pmulr_rgt0 ?unit_in_gt0 // => gain0.
pose d (i : nat) w := if MA_all a' w == 0 then best w0 (worth c a i) else best w0 (free_choice (worth c a) (worth c a') i).
exists c, (@deciding R S c d), a, a'; split=> //; first exact: policy_deciding.
cbv zeta; rewrite !(quantity_deciding R ok); split.
  apply: big1 => i _; apply: big1 => w _; rewrite /d; case: eqP => [->|_]; first by rewrite mul0r.
  have [-> _ _] := @best_freeP R (decisions S) w0 (worth c a) (worth c a') (fun i u => worth_ge0 c a i u) i (frees i (ltn_ord i)).
  by rewrite mulr0.
rewrite -(pmulr_rgt0 _ W0) mulr_sumr; apply: lt_le_trans gain0 _; apply: ler_sum => i _; rewrite e; last exact: homogeneous_free.
rewrite le_eqVlt; apply/orP; left; apply/eqP; congr (_ * _); apply: eq_bigr => w _; rewrite /free_of /d; case: eqP => // _.
have [_ -> _] := @best_freeP R (decisions S) w0 (worth c a) (worth c a') (fun i u => worth_ge0 c a i u) i (frees i (ltn_ord i)).
by [].
Qed.

(* ---- The greatest ratio of a class of policies ---- *)

Section Class.
Variables (means : bool) (class : (X -> A -> R) -> Prop).
Hypothesis class0 : forall E, class E -> forall x a, 0 <= E x a.

Lemma greatest_finite (V : Q) : 1 <= ratio V :> R -> bounded means class (ratio V) ->
  (ratio V = 1 :> R \/ exists c E a a', [/\ means = ~~ isSome c, class E, compared c a /\ compared c a', a != a' &
     0 < quantity c E a' /\ quantity c E a = ratio V * quantity c E a']) -> greatest_ratio means class (Some V).
Proof.
move=> V1 bound attained; split=> // V' V1'; split=> [bound'|le E inE]; last first.
  apply/withinP => c em a a' com com' aa; have := bound E inE; move/withinP => /(_ c em a a' com com' aa) /le_trans; apply.
  by apply: ler_wpmul2r => //; apply: (quantity_ge0 ok); apply: class0.
case: attained => [->//|[c [E [a [a' [em inE [com com'] aa [pos e]]]]]]].
by rewrite -(ler_pmul2r pos) -e; have := bound' E inE; move/withinP; apply.
Qed.

Lemma greatest_infinite : (exists c E a a', [/\ means = ~~ isSome c, class E, compared c a /\ compared c a', a != a' &
     quantity c E a' = 0 /\ 0 < quantity c E a]) -> greatest_ratio means class None.
Proof.
move=> [c [E [a [a' [em inE [com com'] aa [z pos]]]]]] V' bound'.
have := bound' E inE; move/withinP => /(_ c em a a' com com' aa).
by rewrite z mulr0 leNgt pos.
Qed.
End Class.

Theorem supremum_sound means V p : supremum_accepted S means V p = Some true -> greatest_ratio means (@of_any_policy R S) V.
Proof.
rewrite /supremum_accepted; case: ifP => // _ [].
have class0 (E : X -> A -> R) : of_any_policy E -> forall x a, 0 <= E x a.
  case=> T [kT eE] x a; rewrite eE; exact: (@utility_ge0 R X Xt A memory U MX MA_all g kX kM (@g_ge0 R S ok) T x a kT).
have by_policy v : attaining means v -> exists c E a a', [/\ means = ~~ isSome c, of_any_policy E, compared c a /\ compared c a', a != a' &
    if v is Some v then 0 < quantity c E a' /\ quantity c E a = ratio v * quantity c E a' else quantity c E a' = 0 /\ 0 < quantity c E a].
  by case=> c [T [a [a' [em kT com aa h]]]]; exists c, (Definitions.utility (induced MX MA_all T) g), a, a'; split=> //; exists T.
case: V => [V|]; case: p => [p|] //.
- case/and5P => /(at_mostP R); rewrite ratio_one => V1 _ pair_ /(attainsP pair_) at_ /never_exceededP bound.
  by apply: greatest_finite => //; right; apply: by_policy at_.
- case/and3P => /(at_mostP R); rewrite ratio_one => V1 /(at_mostP R); rewrite ratio_one => V1' /never_exceededP bound.
  by apply: greatest_finite => //; left; apply: le_anti; rewrite V1 V1'.
by case/andP => pair_ /(gives_nothingP pair_)/by_policy; apply: greatest_infinite.
Qed.
End Behind.
