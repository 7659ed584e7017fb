(* T10, counterbalancing.  Persons are put into slots in an order drawn uniformly
   over all orders, unseen and fresh; every profile passes the same filter M, and
   nothing else travels with a person.  The policy T sees the released profiles by
   slot; g u s is the utility of decision u to whoever has slot s: 1{s is chosen},
   a waiting time, a position.  [order p] is the slot of person p. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra all_fingroup.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP Ratios.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Counterbalancing.

Variable R : realFieldType.
Variables S A At : finType.
Variable M : A -> At -> R.
Hypothesis M_kernel : kernel M.

Let M_ge0 a v : 0 <= M a v.
Proof. by case: (M_kernel a). Qed.

Let M_sum1 a : \sum_v M a v = 1.
Proof. by case: (M_kernel a). Qed.

(* What the policy sees, given the order: independent releases, slot by slot. *)
Definition view_law (a : S -> A) (order : {perm S}) (v : {ffun S -> At}) : R :=
  \prod_s M (a ((order^-1)%g s)) (v s).

(* The expected utility of person i, with profiles a, when the policy's response to view v is h v s for slot s. *)
Definition chance (h : {ffun S -> At} -> S -> R) (a : S -> A) (i : S) : R :=
  (#|{perm S}|%:R)^-1 * \sum_(order : {perm S}) \sum_v view_law a order v * h v (order i).

(* The order in which persons i and j have traded places. *)
Let trade (i j : S) (order : {perm S}) : {perm S} := (tperm i j * order)%g.

Lemma view_law_by_person a (order : {perm S}) v : view_law a order v = \prod_p M (a p) (v (order p)).
Proof.
rewrite /view_law (reindex_inj (@perm_inj _ order)) /=.
by apply: eq_bigr => p _; rewrite permK.
Qed.

Lemma view_law_traded a i j (order : {perm S}) v :
  view_law a (trade i j order) v = \prod_p M (a (tperm i j p)) (v (order p)).
Proof.
rewrite view_law_by_person (reindex_inj (@perm_inj _ (tperm i j))) /=.
by apply: eq_bigr => p _; rewrite permM tpermK.
Qed.

Lemma view_law_ge0 a order v : 0 <= view_law a order v.
Proof. by apply: prodr_ge0. Qed.

Definition others (a : S -> A) (i j : S) (w : S -> At) : R := \prod_(p | (p != i) && (p != j)) M (a p) (w p).

Lemma view_law_split a i j (order : {perm S}) v : i != j ->
  view_law a order v = M (a i) (v (order i)) * M (a j) (v (order j)) * others a i j (v \o order).
Proof.
move=> ij; rewrite view_law_by_person (bigD1 i) //= (bigD1 j) /=; last by rewrite eq_sym.
by rewrite mulrA.
Qed.

Lemma view_law_traded_split a i j (order : {perm S}) v : i != j ->
  view_law a (trade i j order) v = M (a j) (v (order i)) * M (a i) (v (order j)) * others a i j (v \o order).
Proof.
move=> ij; rewrite view_law_traded (bigD1 i) //= (bigD1 j) /=; last by rewrite eq_sym.
rewrite tpermL tpermR mulrA; congr (_ * _); apply: eq_bigr => p /andP[pi pj].
by rewrite tpermD // eq_sym.
Qed.

Lemma others_ge0 a i j w : 0 <= others a i j w.
Proof. by apply: prodr_ge0. Qed.

Lemma chance_traded h a i j :
  chance h a j = (#|{perm S}|%:R)^-1 * \sum_(order : {perm S}) \sum_v view_law a (trade i j order) v * h v (order i).
Proof.
rewrite /chance; congr (_ * _); rewrite (reindex_inj (mulgI (tperm i j))) /=.
by apply: eq_bigr => order _; apply: eq_bigr => v _; rewrite permM tpermR.
Qed.

Lemma orders_gt0 : (0 : R) < (#|{perm S}|%:R)^-1.
Proof. by rewrite invr_gt0 ltr0n; apply/card_gt0P; exists 1%g. Qed.

Lemma chance_ratio (e : R) h a i j :
  every_pair (pure_dp e) M -> (forall v s, 0 <= h v s) ->
  chance h a i <= e ^+ 2 * chance h a j.
Proof.
move=> dp h_ge0; have e1 : 1 <= e := pure_dp_ge1 (M_kernel (a i)) (M_kernel (a i)) (dp (a i) (a i)); have e0 : 0 <= e := le_trans ler01 e1.
rewrite (chance_traded h a i j) mulrCA ler_wpmul2l ?(ltW orders_gt0) //.
apply: ratio_of_sums => order; apply: ratio_of_weights => // v.
have [<-|ij] := eqVneq i j.
  rewrite /trade tperm1 mul1g ler_pemull ?view_law_ge0 ?expr_ge1 //.
rewrite (view_law_split _ _ _ ij) (view_law_traded_split _ _ _ ij) mulrA ler_wpmul2r ?others_ge0 //.
by rewrite expr2 mulrACA; apply: ler_pmul => //; apply: dp.
Qed.

(* The hockey stick of M(a) x M(b) against M(b) x M(a). *)
Definition exchange_hockey (k : R) (a b : A) : R := hockey_stick k (both M M (a, b)) (both M M (b, a)).

Lemma exchange_hockeyE k a b :
  exchange_hockey k a b = \sum_v \sum_w Num.max 0 (M a v * M b w - k * (M b v * M a w)).
Proof.
by rewrite /exchange_hockey /hockey_stick /both -(pair_bigA _ (fun v w => Num.max 0 (M a v * M b w - k * (M b v * M a w)))).
Qed.

Lemma sum_others a i j (F : At -> At -> R) : i != j ->
  \sum_(w : {ffun S -> At}) F (w i) (w j) * others a i j w = \sum_b \sum_c F b c.
Proof.
move=> ij.
pose pick b c p x : R := if p == i then (b == x)%:R else if p == j then (c == x)%:R else M (a p) x.
have pick_sum b c : \sum_(w : {ffun S -> At}) (w i == b)%:R * (w j == c)%:R * others a i j w = 1.
  transitivity (\sum_(w : {ffun S -> At}) \prod_p pick b c p (w p)).
    apply: eq_bigr => w _; rewrite (bigD1 i) //= (bigD1 j) /=; last by rewrite eq_sym.
    rewrite /pick eqxx eq_sym [j == i]eq_sym (negbTE ij) eqxx mulrA [c == _]eq_sym; congr (_ * _).
    by apply: eq_bigr => p /andP[/negbTE-> /negbTE->].
  rewrite -(bigA_distr_bigA (fun p x => pick b c p x)) big1 // => p _; rewrite /pick.
  case: eqP => _; first by rewrite -[RHS](sum_indicator b (fun=> 1)); apply: eq_bigr => x _; rewrite mul1r eq_sym.
  case: eqP => _ //.
  by rewrite -[RHS](sum_indicator c (fun=> 1)); apply: eq_bigr => x _; rewrite mul1r eq_sym.
transitivity (\sum_(w : {ffun S -> At}) \sum_b \sum_c F b c * ((w i == b)%:R * (w j == c)%:R * others a i j w)).
  apply: eq_bigr => w _.
  rewrite (bigD1 (w i)) //= (bigD1 (w j)) //= !eqxx !mul1r big1 ?addr0; last first.
    by move=> c /negbTE c_neq; rewrite [w j == c]eq_sym c_neq mulr0 mul0r mulr0.
  rewrite big1 ?addr0 // => b /negbTE b_neq; rewrite big1 // => c _.
  by rewrite [w i == b]eq_sym b_neq !mul0r mulr0.
rewrite exchange_big /=; apply: eq_bigr => b _; rewrite exchange_big /=; apply: eq_bigr => c _.
by rewrite -mulr_sumr pick_sum mulr1.
Qed.

Lemma chance_hockey (k gamma : R) h a i j : i != j -> 
  (forall v, ranged 0 gamma (h v)) ->
  chance h a i <= k * chance h a j + gamma * exchange_hockey k (a i) (a j).
Proof.
move=> ij h_test; rewrite (chance_traded h a i j) -ler_subl_addl.
rewrite /chance [k * _]mulrCA -mulrBr [leLHS]mulrC ler_pdivr_mulr; last by have := orders_gt0; rewrite invr_gt0.
rewrite -sum1_card natr_sum mulr_sumr mulr_sumr -sumrB; apply: ler_sum => order _.
rewrite mulr1 mulr_sumr -sumrB.
pose F b c := gamma * Num.max 0 (M (a i) b * M (a j) c - k * (M (a j) b * M (a i) c)).
have -> : gamma * exchange_hockey k (a i) (a j) = \sum_b \sum_c F b c.
  by rewrite exchange_hockeyE mulr_sumr; apply: eq_bigr => b _; rewrite mulr_sumr.
rewrite -(sum_others a F ij).
pose turn (w : {ffun S -> At}) : {ffun S -> At} := [ffun s => w ((order^-1)%g s)].
have turn_inj : injective turn.
  by move=> w w' /ffunP eq_ww; apply/ffunP => p; have := eq_ww (order p); rewrite !ffunE permK.
rewrite (reindex_inj turn_inj) /=; apply: ler_sum => w _.
have turnK p : turn w (order p) = w p by rewrite ffunE permK.
rewrite (view_law_split _ _ _ ij) (view_law_traded_split _ _ _ ij) !turnK.
have -> : others a i j (turn w \o order) = others a i j w.
  by apply: eq_bigr => p _; rewrite /= turnK.
have /andP[h0 h1] := h_test (turn w) (order i).
set D := others a i j w; have D0 : 0 <= D := others_ge0 a i j w.
rewrite [leLHS](_ : _ = (M (a i) (w i) * M (a j) (w j) - k * (M (a j) (w i) * M (a i) (w j))) * h (turn w) (order i) * D); last by ring.
rewrite ler_wpmul2r // /F mulrC; set d := _ - _.
apply: (@le_trans _ _ (h (turn w) (order i) * Num.max 0 d)).
  by rewrite ler_wpmul2l // le_maxr lexx orbT.
by rewrite ler_wpmul2r // le_maxr lexx.
Qed.

Lemma chance_floor (k gamma tau : R) h a i j : i != j -> 0 < tau ->
  (forall v, ranged 0 gamma (h v)) -> tau <= chance h a j ->
  chance h a i <= (k + gamma * exchange_hockey k (a i) (a j) / tau) * chance h a j.
Proof.
move=> ij tau0 h_test floor; apply: le_trans (chance_hockey k a ij h_test) _.
rewrite mulrDl ler_add2l mulrAC ler_pdivl_mulr // ler_wpmul2l //.
case: (set_0Vmem [set: At]) => [At0|[v _]]; last first.
  have /andP[h0 h1] := h_test [ffun=> v] i.
  by rewrite mulr_ge0 ?hockey_stick_ge0 ?(le_trans h0 h1).
suff -> : exchange_hockey k (a i) (a j) = 0 by rewrite mulr0.
by rewrite exchange_hockeyE big1 // => v; have := in_setT v; rewrite At0 inE.
Qed.

Lemma chance_affine h a i (c : R) : chance (fun v s => c - h v s) a i = c - chance h a i.
Proof.
have view1 (order : {perm S}) : \sum_v view_law a order v = 1.
  rewrite /view_law -(bigA_distr_bigA (fun s x => M (a ((order^-1)%g s)) x)).
  by apply: big1 => s _; apply: M_sum1.
have inv : (#|{perm S}|%:R)^-1 * #|{perm S}|%:R = 1 :> R.
  by rewrite mulVf // -(invr_eq0 _) gt_eqF // orders_gt0.
rewrite /chance; transitivity ((#|{perm S}|%:R)^-1 * \sum_(order : {perm S}) (c - \sum_v view_law a order v * h v (order i))).
  congr (_ * _); apply: eq_bigr => order _.
  rewrite -[X in X - _](mean_const c (view1 order)) -sumrB.
  by apply: eq_bigr => v _; rewrite mulrBr.
by rewrite sumrB sumr_const -[c *+ _]mulr_natr mulrBr mulrCA inv mulr1.
Qed.

Lemma chance_floor_pure (e gamma tau : R) h a i j : 0 < tau ->
  every_pair (pure_dp e) M ->
  (forall v, ranged 0 gamma (h v)) -> tau <= chance h a j ->
  chance h a i <=
    Num.min (Num.min (gamma / tau) (e ^+ 2)) ((1 - (1 - tau / gamma) / e ^+ 2) / (tau / gamma)) * chance h a j.
Proof.
move=> tau0 dp h_test floor.
have e1 : 1 <= e := pure_dp_ge1 (M_kernel (a i)) (M_kernel (a i)) (dp (a i) (a i)); have E1 : 1 <= e ^+ 2 by rewrite expr_ge1 // (le_trans ler01).
have h_ge0 v s : 0 <= h v s by case/andP: (h_test v s).
have c_ge0 v s : 0 <= gamma - h v s by rewrite subr_ge0; case/andP: (h_test v s).
have chance_le k : chance h a k <= gamma.
  rewrite -subr_ge0 -chance_affine; apply: mulr_ge0; first exact/ltW/orders_gt0.
  by apply: sumr_ge0 => order _; apply: sumr_ge0 => v _; rewrite mulr_ge0 ?view_law_ge0.
have gamma0 : 0 < gamma by apply: lt_le_trans tau0 (le_trans floor (chance_le j)).
have cj0 : 0 < chance h a j by apply: lt_le_trans floor.
apply: le_min_mul; first apply: le_min_mul.
- rewrite mulrAC ler_pdivl_mulr //; apply: ler_pmul => //; last exact: ltW.
  apply: mulr_ge0; first exact/ltW/orders_gt0.
  by apply: sumr_ge0 => order _; apply: sumr_ge0 => v _; rewrite mulr_ge0 ?view_law_ge0.
- exact: chance_ratio.
apply: complement_term => //; have := chance_ratio a j i dp c_ge0.
by rewrite !chance_affine.
Qed.

(* ---- The theorems, for policies ---- *)

Variable U : finType.
Variable T : {ffun S -> At} -> U -> R.
Hypothesis T_kernel : kernel T.
Variable g : U -> S -> R.

(* The expected utility of person i: order, releases and decision are random. *)
Definition person_utility (a : S -> A) (i : S) : R := chance (fun v s => expect (T v) (fun u => g u s)) a i.

Let g_bounds (gamma : R) : (forall u s, 0 <= g u s <= gamma) ->
  forall v, ranged 0 gamma (fun s => expect (T v) (fun u => g u s)).
Proof. by move=> gb v s; apply: expect_ranged => [|u]; [apply: T_kernel|apply: gb]. Qed.

(* T10: the utilities of two persons differ by a factor of at most e^(2 eps), for every policy. *)
Theorem T10_persons (e : R) (a : S -> A) (i j : S) :
  every_pair (pure_dp e) M -> (forall u s, 0 <= g u s) ->
  person_utility a i <= e ^+ 2 * person_utility a j.
Proof.
move=> dp g_ge0; apply: chance_ratio => // v s.
by apply: expect_ge0 => //; apply: T_kernel.
Qed.

(* T10 with a floor, for a known filter: T3's one-k form on the pair M(a_i) x M(a_j) against M(a_j) x M(a_i). *)
Theorem T10_floor (k gamma tau : R) (a : S -> A) (i j : S) :
  i != j -> 0 < tau -> (forall u s, 0 <= g u s <= gamma) -> tau <= person_utility a j ->
  person_utility a i <=
    (k + gamma * hockey_stick k (both M M (a i, a j)) (both M M (a j, a i)) / tau) * person_utility a j.
Proof. by move=> ij tau0 gb floor; apply: chance_floor => //; apply: g_bounds. Qed.

(* T10 with a floor, when only eps is known: the terms of T3 at 2 eps, t = tau / gamma. *)
Theorem T10_floor_pure (e gamma tau : R) (a : S -> A) (i j : S) :
  0 < tau -> every_pair (pure_dp e) M -> (forall u s, 0 <= g u s <= gamma) -> tau <= person_utility a j ->
  person_utility a i <=
    Num.min (Num.min (gamma / tau) (e ^+ 2)) ((1 - (1 - tau / gamma) / e ^+ 2) / (tau / gamma))
    * person_utility a j.
Proof. by move=> tau0 dp gb floor; apply: chance_floor_pure => //; apply: g_bounds. Qed.

(* Fixed slots: person p always has slot p, and f u is a utility of the decision alone, such as 1{slot 1 is
   chosen}.  T2 bounds what the profiles can do: e^eps for each slot whose profile differs, whoever sits there.
   It says nothing about the position (Counterexamples.v: fixed_slots_counterexample). *)
Definition fixed_utility (f : U -> R) (a : S -> A) : R := \sum_v view_law a 1%g v * expect (T v) f.

Theorem T10_profiles_in_fixed_slots (e : R) (f : U -> R) (a a' : S -> A) :
  every_pair (pure_dp e) M -> (forall u, 0 <= f u) ->
  fixed_utility f a <= e ^+ #|[set p | a p != a' p]| * fixed_utility f a'.
Proof.
move=> dp f_ge0; apply: ratio_of_weights => v; first by apply: expect_ge0 => //; apply: T_kernel.
have -> : e ^+ #|[set p | a p != a' p]| = \prod_p (if a p != a' p then e else 1).
  by rewrite -prodr_const big_mkcond; apply: eq_bigr => p _; rewrite inE.
rewrite !view_law_by_person -big_split; apply: ler_prod => p _.
rewrite M_ge0 /=; case: eqP => [->|_] /=; first by rewrite mul1r.
exact: dp.
Qed.

(* Exchanging two profiles between fixed slots costs e^(2 eps). *)
Theorem T10_exchange_in_fixed_slots (e : R) (f : U -> R) (a : S -> A) (i j : S) :
  every_pair (pure_dp e) M -> (forall u, 0 <= f u) ->
  fixed_utility f a <= e ^+ 2 * fixed_utility f (fun p => a (tperm i j p)).
Proof.
move=> dp f_ge0; have e1 : 1 <= e := pure_dp_ge1 (M_kernel (a i)) (M_kernel (a i)) (dp (a i) (a i)).
apply: le_trans (T10_profiles_in_fixed_slots a (fun p => a (tperm i j p)) dp f_ge0) _.
apply: ler_wpmul2r.
  apply: sumr_ge0 => v _; rewrite mulr_ge0 ?view_law_ge0 //.
  by apply: expect_ge0 => //; apply: T_kernel.
apply: ler_weexpn2l => //; apply: leq_trans (subset_leq_card (_ : _ \subset [set i; j])) _; last first.
  by rewrite cards2; case: (i != j).
apply/subsetP => p; rewrite !inE; apply: contraR; rewrite negb_or => /andP[pi pj].
by rewrite tpermD // eq_sym.
Qed.

End Counterbalancing.

(* T10 for n persons of whom one or nobody is chosen: U = option S, and g = 1{this slot is chosen}. *)
Corollary T10_chosen (R : realFieldType) (S A At : finType) (M : A -> At -> R)
    (T : {ffun S -> At} -> option S -> R) (e : R) (a : S -> A) (i j : S) :
  kernel M -> kernel T -> every_pair (pure_dp e) M ->
  person_utility M T (fun u s => (u == Some s)%:R) a i <=
    e ^+ 2 * person_utility M T (fun u s => (u == Some s)%:R) a j.
Proof. by move=> kM kT dp; apply: T10_persons => // u s; rewrite ler0n. Qed.

(* ---- Two candidates, written out ---- *)

Section TwoCandidates.
Variable R : realFieldType.
Variables A At U : finType.
Variable M : A -> At -> R.
Hypothesis M_kernel : kernel M.
Variable T : At * At -> U -> R.   (* sees the releases in slot 1 and in slot 2 *)
Hypothesis T_kernel : kernel T.
Variable g : U -> bool -> R.      (* utility of the decision in slot 1 (true) and in slot 2 (false) *)

(* The candidate with profile a against one with profile b: slot 1 with probability 1/2, else slot 2. *)
Definition candidate_utility (a b : A) : R :=
  (expect (both M M (a, b)) (fun v => expect (T v) (fun u => g u true))
   + expect (both M M (b, a)) (fun v => expect (T v) (fun u => g u false))) / 2%:R.

(* T10 for two candidates: e^(2 eps), for every policy. *)
Theorem T10_two_candidates (e : R) (a b : A) :
  every_pair (pure_dp e) M -> (forall u s, 0 <= g u s) ->
  candidate_utility a b <= e ^+ 2 * candidate_utility b a.
Proof.
move=> dp g_ge0; rewrite /candidate_utility mulrA ler_wpmul2r ?invr_ge0 ?ler0n // mulrDr.
have pairs c d : pure_dp (e ^+ 2) (both M M (c, d)) (both M M (d, c)).
  move=> vw; rewrite /both /= expr2 mulrACA.
  by apply: ler_pmul; rewrite ?(proj1 (M_kernel _)) ?dp.
by apply: ler_add; apply: ratio_of_weights => v; try exact: pairs; apply: expect_ge0 => //; apply: T_kernel.
Qed.

(* Both ordered pairs have the same hockey stick: the coordinates trade places. *)
Lemma hockey_exchange (k : R) (a b : A) :
  hockey_stick k (both M M (b, a)) (both M M (a, b)) = hockey_stick k (both M M (a, b)) (both M M (b, a)).
Proof.
pose flip (v : At * At) := (v.2, v.1).
have flip_inj : injective flip by move=> [v w] [v' w'] [-> ->].
rewrite /hockey_stick (reindex_inj flip_inj); apply: eq_bigr => v _.
by rewrite /both /= [M b _ * _]mulrC [M a _ * _]mulrC.
Qed.

(* T10 with a floor, for a known filter, by one k. *)
Theorem T10_two_candidates_floor (k gamma tau : R) (a b : A) :
  0 < tau -> (forall u s, 0 <= g u s <= gamma) -> tau <= candidate_utility b a ->
  candidate_utility a b <=
    (k + gamma * hockey_stick k (both M M (a, b)) (both M M (b, a)) / tau) * candidate_utility b a.
Proof.
move=> tau0 gb floor.
have one (P Q : At * At -> R) s :
    expect P (fun v => expect (T v) (fun u => g u s)) <=
    k * expect Q (fun v => expect (T v) (fun u => g u s)) + gamma * hockey_stick k P Q.
  rewrite -ler_subl_addl expect_diff /hockey_stick mulr_sumr; apply: ler_sum => v _.
  have /andP[h0 h1] : 0 <= expect (T v) (fun u => g u s) <= gamma by apply: expect_ranged => [|u]; [apply: T_kernel|apply: gb].
  set d := P v - k * Q v; apply: (@le_trans _ _ (Num.max 0 d * expect (T v) (fun u => g u s))).
    by rewrite ler_wpmul2r // le_maxr lexx orbT.
  by rewrite mulrC ler_wpmul2r // le_maxr lexx.
have H0 := hockey_stick_ge0 k (both M M (a, b)) (both M M (b, a)).
have gamma_ge0 : 0 <= gamma * hockey_stick k (both M M (a, b)) (both M M (b, a)).
  have [v|noV] := pickP (fun v : At * At => true).
    have : 0 <= expect (T v) (fun u => g u true) <= gamma by apply: expect_ranged => [|u]; [apply: T_kernel|apply: gb].
    by case/andP=> h0 h1; rewrite mulr_ge0 // (le_trans h0 h1).
  by rewrite /hockey_stick big1 ?mulr0 // => v; have := noV v.
apply: (@le_trans _ _ (k * candidate_utility b a + gamma * hockey_stick k (both M M (a, b)) (both M M (b, a)))).
  have b1 := one (both M M (a, b)) (both M M (b, a)) true.
  have b2 := one (both M M (b, a)) (both M M (a, b)) false.
  rewrite hockey_exchange in b2; rewrite /candidate_utility ler_pdivr_mulr ?ltr0n //.
  apply: le_trans (ler_add b1 b2) _; rewrite le_eqVlt; apply/orP; left; apply/eqP.
  by field.
by rewrite mulrDl ler_add2l mulrAC ler_pdivl_mulr // ler_wpmul2l.
Qed.

(* T10 with a floor, when only eps is known: the terms of T3 at 2 eps. *)
Theorem T10_two_candidates_floor_pure (e gamma tau : R) (a b : A) :
  0 < tau -> every_pair (pure_dp e) M -> (forall u s, 0 <= g u s <= gamma) -> tau <= candidate_utility b a ->
  candidate_utility a b <=
    Num.min (Num.min (gamma / tau) (e ^+ 2)) ((1 - (1 - tau / gamma) / e ^+ 2) / (tau / gamma))
    * candidate_utility b a.
Proof.
move=> tau0 dp gb floor; have e1 : 1 <= e := pure_dp_ge1 (M_kernel a) (M_kernel a) (dp a a).
have E1 : 1 <= e ^+ 2 by rewrite expr_ge1 // (le_trans ler01).
have kM2 := kernel_both M_kernel M_kernel.
have ranges c d : 0 <= candidate_utility c d <= gamma.
  have slot s (v : At * At) : 0 <= expect (T v) (fun u => g u s) <= gamma.
    by apply: expect_ranged => [|u]; [apply: T_kernel|apply: gb].
  have /andP[l1 h1] := expect_ranged (kM2 (c, d)) (slot true).
  have /andP[l2 h2] := expect_ranged (kM2 (d, c)) (slot false).
  apply/andP; split; first by apply: divr_ge0; [apply: addr_ge0|apply: ler0n].
  by rewrite /candidate_utility ler_pdivr_mulr ?ltr0n // mulr_natr mulr2n ler_add.
have [/andP[c_ge0 c_le] /andP[_ d_le]] := (ranges a b, ranges b a).
have gamma0 : 0 < gamma by apply: lt_le_trans tau0 (le_trans floor d_le).
have g_ge0 u s : 0 <= g u s by case/andP: (gb u s).
apply: le_min_mul; first apply: le_min_mul.
- by rewrite mulrAC ler_pdivl_mulr //; apply: ler_pmul => //; apply: ltW.
- exact: T10_two_candidates.
apply: complement_term => //.
have pairs c d : pure_dp (e ^+ 2) (both M M (c, d)) (both M M (d, c)).
  move=> vw; rewrite /both /= expr2 mulrACA.
  by apply: ler_pmul; rewrite ?(proj1 (M_kernel _)) ?dp.
have rest c d s : gamma - expect (both M M (c, d)) (fun v => expect (T v) (fun u => g u s)) <=
    e ^+ 2 * (gamma - expect (both M M (d, c)) (fun v => expect (T v) (fun u => g u s))).
  rewrite -{1}(expect_cst gamma (kM2 (c, d))) -{2}(expect_cst gamma (kM2 (d, c))) -!expectB.
  apply: ratio_of_weights => [v|]; last exact: pairs.
  rewrite subr_ge0; suff /andP[] : 0 <= expect (T v) (fun u => g u s) <= gamma by [].
  by apply: expect_ranged => [|u]; [apply: T_kernel|apply: gb].
have half (x y : R) : gamma - (x + y) / 2%:R = ((gamma - x) + (gamma - y)) / 2%:R by field.
rewrite /candidate_utility !half mulrA ler_wpmul2r ?invr_ge0 ?ler0n // mulrDr.
by apply: ler_add; apply: rest.
Qed.

End TwoCandidates.
