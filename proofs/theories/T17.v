(* T17: several fresh releases of the same group that reach one memory.

   n releases are one release by the filter whose output is the word of all n, so T13 (and T3, T4) holds with that filter in the place of the
   group filter, for policies that see the whole word. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T3_krr T13.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- The law of n releases ---- *)

Section Releases.
Variables (R : realFieldType) (A At : finType) (MA : A -> At -> R).

Definition releases n (a : A) (w : {ffun 'I_n -> At}) : R := \prod_i MA a (w i).

Lemma releases_ge0 n a w : kernel MA -> 0 <= @releases n a w.
Proof. by move=> kA; apply: prodr_ge0 => i _; case: (kA a). Qed.

Lemma kernel_releases n : kernel MA -> kernel (@releases n).
Proof.
move=> kA a; split=> [w|]; first exact: releases_ge0.
rewrite -(bigA_distr_bigA (fun (i : 'I_n) b => MA a b)); apply: big1 => i _.
by case: (kA a).
Qed.

(* One more release in front of a word. *)
Definition put n (b : At) (w : {ffun 'I_n -> At}) : {ffun 'I_n.+1 -> At} :=
  [ffun i => if unlift ord0 i is Some j then w j else b].
Definition rest n (w : {ffun 'I_n.+1 -> At}) : {ffun 'I_n -> At} := [ffun i => w (lift ord0 i)].

Lemma put0 n b (w : {ffun 'I_n -> At}) : put b w ord0 = b.
Proof. by rewrite ffunE unlift_none. Qed.

Lemma rest_put n b (w : {ffun 'I_n -> At}) : rest (put b w) = w.
Proof. by apply/ffunP => i; rewrite !ffunE liftK. Qed.

Lemma put_rest n (w : {ffun 'I_n.+1 -> At}) : put (w ord0) (rest w) = w.
Proof. by apply/ffunP => i; rewrite ffunE; case: unliftP => [j ->|->] //; rewrite ffunE. Qed.

Lemma releases_put n a b (w : {ffun 'I_n -> At}) : releases a (put b w) = MA a b * releases a w.
Proof.
rewrite /releases big_ord_recl put0; congr (_ * _).
by apply: eq_bigr => i _; rewrite ffunE liftK.
Qed.

Lemma sum_words n (F : {ffun 'I_n.+1 -> At} -> R) : \sum_w F w = \sum_b \sum_w F (put b w).
Proof.
rewrite pair_bigA /= (reindex (fun bw : At * {ffun 'I_n -> At} => put bw.1 bw.2)) //.
exists (fun w : {ffun 'I_n.+1 -> At} => (w ord0, rest w)) => [[b w] _|w _] /=; last exact: put_rest.
by rewrite put0 rest_put.
Qed.

(* Forgetting the first release leaves the law of the others. *)
Lemma merged_rest n a : kernel MA -> merged (@rest n) (releases a) =1 releases a.
Proof.
move=> kA w; rewrite /merged big_mkcond sum_words.
transitivity (\sum_b MA a b * releases a w); last by rewrite -mulr_suml (proj2 (kA a)) mul1r.
apply: eq_bigr => b _; rewrite (bigD1 w) //= rest_put eqxx releases_put big1 ?addr0 // => v /negbTE vw.
by rewrite rest_put vw.
Qed.

End Releases.

(* ---- T13 for policies that see n releases ---- *)

Section Exact.
Variables (R : realFieldType) (X Xt A At U : finType) (u0 : U) (n : nat).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (g : U -> X -> A -> R) (W : A -> X -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (g0 : forall u x a, 0 <= g u x a) (W0 : forall a x, 0 <= W a x).
Local Notation words := {ffun 'I_n -> At}.
Local Notation E T := (utility (induced MX (@releases R A At MA n) T) g).

Theorem T17_releases V : 1 <= V ->
  (forall T : Xt -> words -> U -> R, policy T -> local_le V (E T)) <->
  (forall x a a', a != a' -> local_surplus u0 (@releases R A At MA n) g V x a a' <= 0).
Proof. by apply: T13_local_ratio => //; apply: kernel_releases. Qed.

Theorem T17_releases_global V : 1 <= V ->
  (forall T : Xt -> words -> U -> R, policy T -> global_le V (group_mean W (E T))) <->
  (forall a a', a != a' -> global_surplus u0 MX (@releases R A At MA n) g W V a a' <= 0).
Proof. by apply: T13_global_ratio => //; apply: kernel_releases. Qed.

End Exact.

(* ---- To forget something never helps a policy ---- *)

Section Processing.
Variables (R : realFieldType) (B C Y U : finType) (u0 : U) (f : B -> C) (P Q : B -> R).

Lemma surplus_forget (alpha beta : Y -> U -> R) V :
  surplus u0 (fun o u => merged f P o.2 * alpha o.1 u) (fun o u => merged f Q o.2 * beta o.1 u) V <=
  surplus u0 (fun o u => P o.2 * alpha o.1 u) (fun o u => Q o.2 * beta o.1 u) V.
Proof.
pose F o := greatest u0 (gain (fun o u => P o.2 * alpha o.1 u) (fun o u => Q o.2 * beta o.1 u) V o).
pose G o := greatest u0 (gain (fun o u => merged f P o.2 * alpha o.1 u) (fun o u => merged f Q o.2 * beta o.1 u) V o).
rewrite /surplus -(pair_bigA _ (fun y c => G (y, c))) -(pair_bigA _ (fun y b => F (y, b))) /=.
apply: ler_sum => y _; rewrite [leRHS](partition_big f xpredT) //=; apply: ler_sum => c _; apply: greatest_le => u.
rewrite /gain /merged /= !mulr_suml mulr_sumr -sumrB; apply: ler_sum => b _.
exact: (greatest_ge u0 (gain (fun o u => P o.2 * alpha o.1 u) (fun o u => Q o.2 * beta o.1 u) V (y, b)) u).
Qed.

Lemma local_surplus_forget (alpha beta : U -> R) V :
  surplus u0 (fun c u => merged f P c * alpha u) (fun c u => merged f Q c * beta u) V <=
  surplus u0 (fun b u => P b * alpha u) (fun b u => Q b * beta u) V.
Proof.
rewrite /surplus [leRHS](partition_big f xpredT) //=; apply: ler_sum => c _; apply: greatest_le => u.
rewrite /gain /merged /= !mulr_suml mulr_sumr -sumrB; apply: ler_sum => b _.
exact: (greatest_ge u0 (gain (fun b u => P b * alpha u) (fun b u => Q b * beta u) V b) u).
Qed.

Lemma hockey_stick_forget k : hockey_stick k (merged f P) (merged f Q) <= hockey_stick k P Q.
Proof.
rewrite /hockey_stick [leRHS](partition_big f xpredT) //=; apply: ler_sum => c _.
rewrite le_maxl sumr_ge0 /= => [|b _]; last by rewrite le_maxr lexx.
by rewrite /merged mulr_sumr -sumrB; apply: ler_sum => b _; rewrite le_maxr lexx orbT.
Qed.

End Processing.

Section Monotone.
Variables (R : realFieldType) (X Xt A At U : finType) (u0 : U) (n : nat).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (g : U -> X -> A -> R) (W : A -> X -> R).
Hypotheses (kA : kernel MA).
Local Notation M n := (@releases R A At MA n).

(* S(V) does not fall with n: what n + 1 releases allow is at least what n allow. *)
Theorem T17_monotone V x a a' : local_surplus u0 (M n) g V x a a' <= local_surplus u0 (M n.+1) g V x a a'.
Proof.
apply: (le_trans _ (local_surplus_forget u0 (@rest At n) (M n.+1 a) (M n.+1 a') (fun u => g u x a) (fun u => g u x a') V)).
rewrite le_eqVlt; apply/orP; left; apply/eqP; apply: eq_bigr => w _; apply: eq_greatest => u.
by rewrite /gain /local_part !merged_rest.
Qed.

Theorem T17_monotone_global V a a' : global_surplus u0 MX (M n) g W V a a' <= global_surplus u0 MX (M n.+1) g W V a a'.
Proof.
pose G c y u : R := \sum_x W c x * MX x y * g u x c.
apply: (le_trans _ (surplus_forget u0 (@rest At n) (M n.+1 a) (M n.+1 a') (G a) (G a') V)).
rewrite le_eqVlt; apply/orP; left; apply/eqP; apply: eq_bigr => o _; apply: eq_greatest => u.
by rewrite /gain /global_part !merged_rest.
Qed.

(* Nor do H_k, and with them the bounds of T3 and T4. *)
Theorem T17_monotone_hockey_stick k a a' : hockey_stick k (M n a) (M n a') <= hockey_stick k (M n.+1 a) (M n.+1 a').
Proof.
apply: (le_trans _ (hockey_stick_forget (@rest At n) (M n.+1 a) (M n.+1 a') k)).
by rewrite le_eqVlt; apply/orP; left; apply/eqP; apply: eq_bigr => w _; rewrite !merged_rest.
Qed.

End Monotone.

(* ---- Classes of words ---- *)

Section Classes.
Variables (R : realFieldType) (A At : finType) (MA : A -> At -> R) (a a' : A).
Hypothesis kA : kernel MA.
Local Notation M n := (@releases R A At MA n).

(* Release by release: words of equal likelihood ratio are merged, then one more release is drawn. *)
Theorem T17_merged n (C : finType) (f : {ffun 'I_n -> At} -> C) (F : R -> R -> R) :
  homogeneous F -> alike f (M n a) (M n a') ->
  \sum_w F (M n.+1 a w) (M n.+1 a' w) =
  \sum_b \sum_c F (MA a b * merged f (M n a) c) (MA a' b * merged f (M n a') c).
Proof.
move=> hF al; rewrite sum_words; apply: eq_bigr => b _; under eq_bigr do rewrite !releases_put.
apply: (T13_merge (F := fun x y => F (MA a b * x) (MA a' b * y))) => // [s x y s0|w|w].
- by rewrite !(mulrCA _ s) hF.
- exact: releases_ge0.
- exact: releases_ge0.
Qed.

(* The type of a word: how often each value was released.  Words of a type have one probability. *)
Definition type_of n (w : {ffun 'I_n -> At}) : {ffun At -> 'I_n.+1} := [ffun b => inord #|[set i | w i == b]|].

Lemma type_count n (w : {ffun 'I_n -> At}) b : type_of w b = #|[set i | w i == b]| :> nat.
Proof. by rewrite ffunE inordK // ltnS -[X in (_ <= X)%N]card_ord max_card. Qed.

Lemma releases_type n c (w : {ffun 'I_n -> At}) : M n c w = \prod_b MA c b ^+ type_of w b.
Proof.
rewrite /releases (partition_big w xpredT) //=; apply: eq_bigr => b _.
rewrite (eq_bigr (fun=> MA c b)) => [|i /eqP-> //].
by rewrite prodr_const type_count; congr (_ ^+ _); apply: eq_card => i; rewrite inE.
Qed.

Theorem T17_types n : alike (@type_of n) (M n a) (M n a').
Proof. by move=> w w' e; rewrite !releases_type e. Qed.

End Classes.

(* ---- Randomized response: the classes #a - #a', and their masses ---- *)

Section Krr.
Variables (R : realFieldType) (A : finType) (p : R) (a a' : A) (n : nat).
Hypothesis aa' : a != a'.
Local Notation q := (krr_lie A p).
Local Notation M := (@releases R A A (@krr R A p) n).

(* 2 for the value a, 0 for a', 1 for any other: the sum over a word is n + #a - #a'. *)
Definition step (b : A) : nat := (if b == a then 2 else if b == a' then 0 else 1)%N.
Definition class_of (w : {ffun 'I_n -> A}) : 'I_(n.*2.+1) := inord (\sum_i step (w i))%N.

Lemma class_sum w : class_of w = (\sum_i step (w i))%N :> nat.
Proof.
rewrite inordK // ltnS -muln2 -[n in (n * 2)%N]card_ord -sum_nat_const; apply: leq_sum => i _.
by rewrite /step; case: ifP => // _; case: ifP.
Qed.

Definition shows (b : A) (w : {ffun 'I_n -> A}) : nat := (\sum_i (w i == b))%N.
Definition others (b : A) (w : {ffun 'I_n -> A}) : nat := (\sum_i (w i != b))%N.

Lemma shows_others b w : (shows b w + others b w = n)%N.
Proof.
rewrite -big_split /= -[RHS]card_ord -sum1_card; apply: eq_bigr => i _.
by case: (w i == b).
Qed.

(* The sum over a word is n + #a - #a'. *)
Lemma class_shows w : (class_of w + shows a' w = n + shows a w)%N.
Proof.
rewrite class_sum -[in RHS](card_ord n) -sum1_card -!big_split /=; apply: eq_bigr => i _.
rewrite /step; have [->|_] := eqVneq (w i) a; first by rewrite (negbTE aa').
by case: eqP.
Qed.

Lemma krr_word (c : A) w : M c w = p ^+ shows c w * q ^+ others c w.
Proof.
rewrite /releases -!prodrXr -big_split; apply: eq_bigr => i _ /=.
by rewrite /krr eq_sym; case: (w i == c); rewrite ?expr0 ?expr1 ?mulr1 ?mul1r.
Qed.

Theorem T17_krr_classes : alike class_of (M a) (M a').
Proof.
move=> w w' e; rewrite !krr_word.
have sum : (shows a w + shows a' w' = shows a w' + shows a' w)%N.
  apply/eqP; rewrite -(eqn_add2l n) addnA -class_shows e addnAC class_shows.
  by rewrite -addnA eqxx.
have sum' : (others a w + others a' w' = others a w' + others a' w)%N.
  apply/eqP; rewrite -(eqn_add2l (shows a w + shows a' w')) {2}sum addnACA !shows_others.
  by rewrite addnACA !shows_others.
by rewrite mulrACA [RHS]mulrACA -!exprD sum sum'.
Qed.

(* The masses of the classes are the coefficients of (p X^2 + (1 - p - q) X + q)^n for a, and for a' those with p and q exchanged. *)
Hypothesis two : (1 < #|A|)%N.
Local Notation r := (1 - p - q).


(* A release adds to a word's class: the polynomial of one release, and of a word. *)
Definition one_release (c : A) : {poly R} := \sum_b (krr p c b)%:P * 'X^(step b).

Lemma merged_coefficient c s : merged class_of (M c) s = (one_release c ^+ n)`_s.
Proof.
have -> : one_release c ^+ n = \sum_(w : {ffun 'I_n -> A}) (M c w)%:P * 'X^(\sum_i step (w i)).
  transitivity (\prod_(i < n) one_release c); first by rewrite prodr_const card_ord.
  rewrite /one_release bigA_distr_bigA; apply: eq_bigr => w _.
  by rewrite big_split /= prodrXr -rmorph_prod.
rewrite coef_sum /merged big_mkcond; apply: eq_bigr => w _.
rewrite coefCM coefXn -class_sum; case: (class_of w =P s) => [->|ne]; first by rewrite eqxx mulr1.
by rewrite eq_sym; case: eqP => [/ord_inj|_]; rewrite ?mulr0.
Qed.

Lemma big_two (F : A -> {poly R}) : \sum_b F b = F a + F a' + \sum_(b | (b != a) && (b != a')) F b.
Proof. by rewrite (bigD1 a) //= (bigD1 a') /= ?addrA // eq_sym. Qed.

Lemma others_mass : \sum_(b | (b != a) && (b != a')) q = r.
Proof.
have e : \sum_(b : A) q = q + (q + \sum_(b | (b != a) && (b != a')) q).
  by rewrite (bigD1 a) //= (bigD1 a') //= eq_sym.
rewrite sumr_const -mulr_natl in e; rewrite -(lies two p) mulrBl mul1r e.
by move: (\sum_(b | _) q) => S; ring.
Qed.

Lemma one_releaseE : one_release a = p%:P * 'X^2 + q%:P + r%:P * 'X /\ one_release a' = q%:P * 'X^2 + p%:P + r%:P * 'X.
Proof.
rewrite /one_release !big_two /krr /step !eqxx (negbTE aa') [a' == a]eq_sym (negbTE aa') !expr0 !mulr1.
have rest_mass (F : A -> {poly R}) : (forall b, b != a -> b != a' -> F b = q%:P * 'X^1) ->
    \sum_(b | (b != a) && (b != a')) F b = r%:P * 'X.
  move=> FE; rewrite -others_mass (eq_bigr (fun=> q%:P * 'X)) => [|b /andP[ba ba']]; last by rewrite FE ?expr1.
  by rewrite -mulr_suml rmorph_sum.
by split; rewrite rest_mass // => b ba ba'; rewrite (eq_sym _ b) (negbTE ba) (negbTE ba').
Qed.

Lemma regroup (S : comRingType) (x y z v : S) : x * v ^+ 2 + y + z * v = v * (z + x * v) + y.
Proof. by rewrite expr2; ring. Qed.

Lemma regroup_term (S : comRingType) (v w x y z k l : S) :
  l * (v * (k * (z * (x * w))) * y) = l * k * (x * y * z) * (v * w).
Proof. by ring. Qed.

Lemma trinomial (x y z : R) (s : nat) : ((x%:P * 'X^2 + y%:P + z%:P * 'X) ^+ n)`_s =
  \sum_(j < n.+1) \sum_(i < (n - j).+1 | (n - j + i == s)%N) ('C(n, j) * 'C(n - j, i))%:R * (x ^+ i * y ^+ j * z ^+ (n - j - i)).
Proof.
rewrite regroup exprDn coef_sum; apply: eq_bigr => j _; rewrite exprMn [in LHS]exprDn mulr_sumr mulr_suml -sumrMnl coef_sum.
rewrite [RHS]big_mkcond; apply: eq_bigr => i _.
have -> : 'X^(n - j) * ((z%:P ^+ (n - j - i) * (x%:P * 'X) ^+ i) *+ 'C(n - j, i)) * y%:P ^+ j *+ 'C(n, j) =
    (('C(n, j) * 'C(n - j, i))%:R * (x ^+ i * y ^+ j * z ^+ (n - j - i)))%:P * 'X^(n - j + i) :> {poly R}.
  rewrite -[_ *+ 'C(n, j)]mulr_natl -[_ *+ 'C(n - j, i)]mulr_natl.
  rewrite exprMn exprD !rmorphM /= !rmorphX /= natrM rmorphM /= !rmorph_nat.
  exact: regroup_term.
by rewrite coefCM coefXn eq_sym; case: eqP => _; rewrite ?mulr1 ?mulr0.
Qed.

(* The mass of a class: j releases of a', i of a, and n - j + i = s.  'C(n, j) 'C(n - j, i) = n!/(i! j! (n - i - j)!). *)
Theorem T17_krr_masses (s : 'I_(n.*2.+1)) :
  merged class_of (M a) s = \sum_(j < n.+1) \sum_(i < (n - j).+1 | (n - j + i == s)%N)
    ('C(n, j) * 'C(n - j, i))%:R * (p ^+ i * q ^+ j * r ^+ (n - j - i)) /\
  merged class_of (M a') s = \sum_(j < n.+1) \sum_(i < (n - j).+1 | (n - j + i == s)%N)
    ('C(n, j) * 'C(n - j, i))%:R * (q ^+ i * p ^+ j * r ^+ (n - j - i)).
Proof. by have [e e'] := one_releaseE; rewrite !merged_coefficient e e' !trinomial. Qed.

End Krr.
