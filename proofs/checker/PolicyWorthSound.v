(* What a ratio is of, in a context or of means, as a sum over sites of what decisions are worth; and that PolicySites.v has these
   numbers: of every two groups that are compared a test sees what stands for them. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions T13 T17.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound PolicyLaw Likelihoods LikelihoodsSound PolicyClaims PolicyFacts PolicyBounds PolicyMultipliers PolicyMeans.
From FairauditChecker Require Import PolicySites PolicySitesSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Behind.
Variables (R : realFieldType) (S : behind).
Hypotheses (ok : valid S).
Local Notation number := (@number R).
Local Notation MX := (@MX R S).
Local Notation MA := (@MA R S).
Local Notation MA_all := (@MA_all R S).
Local Notation g := (@g R S).
Local Notation A := (A S).
Local Notation X := (X S).
Local Notation Xt := (Xt S).
Local Notation U := (U S).
Local Notation memory := (memory S).
Local Notation share := (@share R S).
Local Notation mass_of := (@mass_of R S).
Local Notation kX := (kernel_MX R ok).
Local Notation kM := (kernel_MA_all R ok).
Local Notation g0 := (@g_ge0 R S ok).
Local Notation w0 := (u0 ok).
Implicit Types (c : option X) (a : A) (T : Xt -> memory -> U -> R).

(* ---- What a ratio is of: expectations in a context, or the means of groups that have some mass ---- *)

Definition quantity c (E : X -> A -> R) a : R := if c is Some x then E x a else mean E a.
Definition compared c a : Prop := if c is Some _ then True else 0 < mass_of a.
Definition place_of c : option nat := omap (@nat_of_ord _) c.

Lemma withinP means V E :
  within means V E <-> forall c, means = ~~ isSome c -> forall a a', compared c a -> compared c a' -> a != a' -> quantity c E a <= V * quantity c E a'.
Proof.
rewrite /within; case: means; split=> h; try by [].
- by case=> [x|] // _ a a' ma ma' aa; apply: h.
- by move=> a a' ma ma' aa; apply: (h None).
- by case=> [x|] // _ a a' _ _ aa; apply: h.
by move=> x a a' aa; apply: (h (Some x)).
Qed.

Lemma eq_quantity c (E E' : X -> A -> R) a : (forall x a, E x a = E' x a) -> quantity c E a = quantity c E' a.
Proof. by move=> e; case: c => [x|] /=; [apply: e | apply: eq_mean]. Qed.

Lemma quantity_ge0 c (E : X -> A -> R) a : (forall x a, 0 <= E x a) -> 0 <= quantity c E a.
Proof. by move=> E0; case: c => [x|] /=; [apply: E0 | apply: (@means_ge0 R S ok)]. Qed.

(* ---- Sums over sites ---- *)

Definition worth c a (i : nat) (u : U) : R :=
  if c is Some x then g u x a else \sum_x share a x * entry (context_matrix S) x i * g u x a.
Definition sites_of c : nat := sites_in S (place_of c).

Lemma worth_ge0 c a i u : 0 <= worth c a i u.
Proof.
case: c => [x|]; first exact: g0.
apply: sumr_ge0 => x _; apply: mulr_ge0; last exact: g0.
apply: mulr_ge0; first exact: (@share_ge0 R S ok a x).
case: (ltnP i (released_contexts S)) => hi.
  by have [p _] := kX x; exact: (p (Ordinal hi)).
have [sm smx] := context_matrix_size R ok; rewrite /entry /PolicyMeaning.entry number_out //.
by rewrite smx.
Qed.

Local Notation E T := (Definitions.utility (induced MX MA_all T) g).

Lemma global_partE a o u : global_part MX MA_all g share a o u = MA_all a o.2 * worth None a o.1 u.
Proof. by []. Qed.

(* What a policy makes of two groups differs by no more than the best decision at each site does. *)
Lemma quantity_le c T V a a' : policy T ->
  quantity c (E T) a <= V * quantity c (E T) a' +
    \sum_(i < sites_of c) \sum_w most w0 (worth c a i) (worth c a' i) V (MA_all a w) (MA_all a' w).
Proof.
move=> kT; case: c => [x|] /=.
  by rewrite big_ord1; apply: (@local_surplus_ge R X Xt A memory U w0 MX MA_all g kX T V x a a' kT).
rewrite /mean !mean_value pair_bigA.
exact: (@surplus_ge R _ U w0 (T13.joint T) (global_part MX MA_all g share a) (global_part MX MA_all g share a') V (kernel_joint kT)).
Qed.

(* The policy that decides by d, which is given the site and what is released of the group *)
Definition deciding c (d : nat -> memory -> U) : Xt -> memory -> U -> R :=
  fun y w => point R (d (if c is Some _ then 0%N else nat_of_ord y) w).

Lemma policy_deciding c d : policy (deciding c d).
Proof. by move=> y w; apply: law_point. Qed.

Lemma quantity_deciding c d a :
  quantity c (E (deciding c d)) a = \sum_(i < sites_of c) \sum_w MA_all a w * worth c a i (d i w).
Proof.
case: c => [x|] /=.
  by rewrite big_ord1; apply: (@utility_always R X Xt A memory U MX MA_all g kX (d 0%N) x a).
rewrite /mean mean_value pair_bigA; apply: eq_bigr => -[y w] _ /=.
exact: (expect_point (global_part MX MA_all g share a (y, w)) (d y w)).
Qed.

(* ---- The numbers of the program ---- *)

Lemma add_upP n (ts : seq (Q * vector)) : (forall t, In t ts -> size t.2 = n) ->
  size (add_up n ts) = n /\ forall u, (u < n)%N -> number (add_up n ts) u = \sum_(t <- ts) ratio t.1 * number t.2 u.
Proof.
elim: ts => [|t ts IH] sizes.
  split=> [|u hu]; first by rewrite /= -size_length repeat_length.
  by rewrite big_nil /number /PolicyMeaning.number nth_repeat // ratio_zero.
have [|s e] := IH; first by move=> v vs; apply: sizes; right.
have st : size t.2 = n by apply: sizes; left.
have -> : add_up n (t :: ts) = if zero_fraction t.1 then add_up n ts
    else List.map (fun pq => plus (times t.1 pq.1) pq.2) (combine t.2 (add_up n ts)) by [].
case z: (zero_fraction t.1).
  by split=> // u hu; rewrite big_cons e // /ratio; move/Z.eqb_eq: z => ->; rewrite embed0 !mul0r add0r.
split=> [|u hu]; first by rewrite size_map_list size_combine ?st ?s.
rewrite big_cons -e // /number /PolicyMeaning.number (@nth_map_in _ _ (zero, zero)) ?size_combine ?st ?s //.
by rewrite nth_combine ?st ?s //= ratio_plus ratio_times.
Qed.

Local Notation seen_as := (columns (released_contexts S) (context_matrix S)).

Lemma seen_asP : size seen_as = released_contexts S /\ forall y (x : X), (y < released_contexts S)%N ->
  size (nth [::] seen_as y) = true_contexts S /\ number (nth [::] seen_as y) x = entry (context_matrix S) x y.
Proof.
have [sm smx] := context_matrix_size R ok.
have rows i : (i < size (context_matrix S))%N -> size (nth [::] (context_matrix S) i) = released_contexts S by rewrite sm => /smx.
have [sc cE] := columnsP rows; split=> // y x hy; have [|s e] := cE x y _ hy; first by rewrite sm.
by rewrite s sm /number /PolicyMeaning.number e.
Qed.

Lemma seq_nth_list k n i : (i < n)%N -> nth 0%N (List.seq k n) i = (k + i)%N.
Proof. by elim: n k i => // n IH k [|i] /= h; rewrite ?addn0 // IH // addSnnS. Qed.

Lemma size_seq_list k n : size (List.seq k n) = n. Proof. by rewrite -size_length seq_length. Qed.

Definition mean_terms (a y : nat) : seq (Q * vector) :=
  List.map (fun t => (times t.1.1 t.1.2, gains S t.2 a))
    (combine (combine (shares S a) (nth [::] seen_as y)) (List.seq 0 (true_contexts S))).

Lemma mean_site (a : A) y u : 0 < mass_of a -> (y < released_contexts S)%N -> (u < decisions S)%N ->
  size (add_up (decisions S) (mean_terms a y)) = decisions S /\
  number (add_up (decisions S) (mean_terms a y)) u = \sum_(x : X) share a x * entry (context_matrix S) x y * number (gains S x a) u.
Proof.
move=> m0 hy hu; have [sc cE] := seen_asP.
have sy : size (nth [::] seen_as y) = true_contexts S by have [] := cE y (Ordinal (some_context ok)) hy.
have ss : size (shares S a) = true_contexts S by apply: shares_size.
rewrite /mean_terms; set all := combine _ _.
have sall : size all = true_contexts S by rewrite size_combine ?size_combine ?ss ?sy ?size_seq_list.
have at_x x : (x < true_contexts S)%N ->
    nth ((zero, zero), 0%N) all x = ((nth zero (shares S a) x, nth zero (nth [::] seen_as y) x), x).
  by move=> hx; rewrite /all nth_combine ?size_combine ?ss ?sy ?size_seq_list // nth_combine ?ss ?sy // seq_nth_list.
have [|s e] := @add_upP (decisions S) (List.map (fun t => (times t.1.1 t.1.2, gains S t.2 a)) all).
  move=> t /in_map_iff[x [<- /(In_nth _ _ ((zero, zero), 0%N))[i [/ssrnat.ltP]]]]; rewrite size_length sall list_nth => hi.
  by rewrite at_x // => <- /=; have [] := gains_ok R ok hi (ltn_ord a).
split=> //; rewrite e // big_map (big_nth ((zero, zero), 0%N)) sall big_mkord; apply: eq_bigr => x _.
rewrite at_x ?ltn_ord //= ratio_times; congr (_ * _ * _); first by rewrite -[LHS]/(number (shares S a) x) shares_number.
by have [_ <-] := cE y x hy.
Qed.

Definition Row c (a : nat) := nth [::] (worths S (place_of c)) a.

Lemma mean_row_of (a : A) : nth [::] (mean_worths S) a = mean_worth S seen_as a.
Proof. by rewrite /mean_worths (@nth_map_in _ _ 0%N) ?size_seq_list // seq_nth_list. Qed.

Lemma worths_size c : size (worths S (place_of c)) = true_groups S.
Proof. by case: c => [x|] /=; rewrite ?size_map_list size_seq_list. Qed.

Lemma worthsP c (a : A) : compared c a -> size (Row c a) = (sites_of c * decisions S)%N /\
  forall i (u : U), (i < sites_of c)%N -> number (Row c a) (i * decisions S + u) = worth c a i u.
Proof.
rewrite /Row; case: c => [x _|] /=.
  have e : nth [::] (gains_of S x) a = gains S x a by rewrite /gains_of (@nth_map_in _ _ 0%N) ?size_seq_list // seq_nth_list.
  rewrite e mul1n; split=> [|i u hi]; first by have [] := gains_ok R ok (ltn_ord x) (ltn_ord a).
  by case: i hi => // _; rewrite mul0n add0n.
move=> m0; have [sc _] := seen_asP; rewrite mean_row_of /mean_worth.
have sizes i : (i < size seen_as)%N -> size (add_up (decisions S) (mean_terms a i)) = decisions S.
  by rewrite sc => hi; have [] := mean_site m0 hi (some_decision ok).
split=> [|i u hi]; first by rewrite (@size_flat_map _ _ [::] _ (decisions S)) // sc.
have [_ <-] := mean_site m0 hi (ltn_ord u).
rewrite /number /PolicyMeaning.number (@nth_flat_map _ _ [::] zero _ (decisions S)) ?sc ?ltn_ord //.
by rewrite sc in sizes; exact: sizes.
Qed.

Definition unit_in c : R := embed (unit_of (worths S (place_of c))).

Lemma unit_in_gt0 c : 0 < unit_in c.
Proof. by apply/embed_gt0/Z.ltb_lt/common_gt0. Qed.

Definition sites_at c (a : nat) : seq (seq Z) :=
  nth [::] (List.map (pieces (sites_in S (place_of c)) (decisions S)) (integers (worths S (place_of c)))) a.

Lemma sites_atP c (a : A) : compared c a -> size (sites_at c a) = sites_of c /\ forall i, (i < sites_of c)%N ->
  size (nth [::] (sites_at c a) i) = decisions S /\ forall u : U, embed (nth Z0 (nth [::] (sites_at c a) i) u) = unit_in c * worth c a i u.
Proof.
move=> com; have [s e] := worthsP com; have sw : (a < size (worths S (place_of c)))%N by rewrite worths_size.
have si : size (nth [::] (integers (worths S (place_of c))) a) = (sites_of c * decisions S)%N.
  by rewrite /integers (@nth_map_in _ _ [::]) // size_map_list s.
rewrite /sites_at (@nth_map_in _ _ [::]) ?size_map_list // size_pieces; split=> // i hi; split=> [|u].
  exact: size_piece.
rewrite (@nth_pieces _ Z0) // -[embed _]/(integer R _ _) integersE //.
by rewrite -e.
Qed.
End Behind.
