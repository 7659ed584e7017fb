(* T3: a utility that ignores the group (or nearly so), with a floor under the expected utility. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T1.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- Tests of one ordered pair of rows ---- *)

Section Pair.
Variables (R : realFieldType) (A : finType).
Implicit Types (P Q phi : A -> R) (k t : R).

(* Section 9, the certificate behind T3: one number k bounds the ratio for every test. *)
Theorem certificate_one_k k t P Q phi : test phi -> 0 < t -> t <= expect Q phi ->
  expect P phi <= (k + hockey_stick k P Q / t) * expect Q phi.
Proof.
by move=> te t0 fl; apply: ratio_of_additive => //; [apply: hockey_stick_ge0|apply: hockey_stick_test].
Qed.

Lemma prob_mono Q (S S' : {set A}) : (forall a, 0 <= Q a) -> S \subset S' -> prob Q S <= prob Q S'.
Proof.
move=> Q0 /subsetP sub; rewrite !prob_expect; apply: ler_sum => a _; apply: ler_wpmul2l => //.
by case h: (a \in S); rewrite ?(sub _ h) ?ler0n.
Qed.

(* Neyman and Pearson: the multiplier is 0 or a likelihood ratio. *)
Lemma threshold t P Q : law P -> law Q -> 0 < t -> t <= 1 ->
  exists k, [/\ 0 <= k, k = 0 \/ exists2 b, 0 < Q b & k = P b / Q b,
    prob Q [set a | k * Q a < P a] <= t & t <= prob Q [set a | k * Q a <= P a]].
Proof.
move=> lP lQ t0 t1; case: (lP) => P0 P1; case: (lQ) => Q0 Q1.
pose ratio a := P a / Q a; pose cand o := if o is Some a then ratio a else 0.
pose ok (o : option A) := if o is Some a then 0 < Q a else true.
pose G k := prob Q [set a | k * Q a < P a].
have ratioE a c : 0 < Q a -> (ratio a <= c) = (P a <= c * Q a).
  by move=> q0; rewrite /ratio ler_pdivr_mulr.
have [b1 b1q] : exists b, 0 < Q b.
  case: (pickP (fun b => 0 < Q b)) => [b h|no]; first by exists b.
  have : \sum_a Q a <= 0.
    by rewrite big1 // => a _; apply: le_anti; rewrite Q0 andbT leNgt no.
  by rewrite Q1 ler10.
have [o0 o0ok] : exists o, ok o && (G (cand o) <= t).
  have [b bq bmax] := @arg_maxP _ _ _ b1 (fun b => 0 < Q b) ratio b1q.
  exists (Some b); rewrite /= bq /= /G prob_expect /expect big1 ?(ltW t0) // => a _.
  rewrite inE; case: (ltP (ratio b * Q a)) => h; last by rewrite mulr0.
  case: (ltP 0 (Q a)) => q0.
    by have : ratio a <= ratio b := bmax a q0; rewrite ratioE // => /(lt_le_trans h); rewrite ltxx.
  by rewrite (le_anti (y := 0) (x := Q a)) ?q0 ?Q0 // mul0r.
have [o /andP[ook oG] omin] := @arg_minP _ _ _ o0 (fun o => ok o && (G (cand o) <= t)) cand o0ok.
exists (cand o); split.
- by case: (o) => //= a; rewrite divr_ge0.
- by case: (o) ook => /= [a qa|_]; [right; exists a|left].
- by [].
rewrite leNgt; apply/negP => lt.
have [a1 a1lt] : exists a, P a < cand o * Q a.
  case: (pickP (fun a => P a < cand o * Q a)) => [a h|no]; first by exists a.
  move: lt; rewrite (_ : [set _ | _] = [set: A]); last by apply/setP => a; rewrite !inE leNgt no.
  by rewrite /prob (eq_bigl xpredT) => [|a]; rewrite ?inE // Q1 ltNge t1.
have pos a : P a < cand o * Q a -> 0 < Q a.
  move=> h; rewrite lt0r Q0 andbT; apply/eqP => q0; move: h; rewrite q0 mulr0.
  by rewrite ltNge P0.
have [a0 a0lt a0max] := @arg_maxP _ _ _ a1 (fun a => P a < cand o * Q a) ratio a1lt.
have : ratio a0 < cand o by rewrite /ratio ltr_pdivr_mulr ?pos.
suff ok0 : ok (Some a0) && (G (cand (Some a0)) <= t).
  by have : cand o <= ratio a0 := omin _ ok0; rewrite leNgt => /negbTE->.
rewrite /= pos //=; apply/ltW; apply: le_lt_trans lt; apply: prob_mono => //.
apply/subsetP => a; rewrite !inE => h; rewrite leNgt; apply/negP => h'.
by have : ratio a <= ratio a0 := a0max a h'; rewrite ratioE ?pos // => /(lt_le_trans h); rewrite ltxx.
Qed.

(* At such a threshold a test of level t turns the certificate into an equality. *)
Lemma threshold_test t k P Q : law Q -> 0 < t ->
  prob Q [set a | k * Q a < P a] <= t -> t <= prob Q [set a | k * Q a <= P a] ->
  exists phi, [/\ test phi, expect Q phi = t & expect P phi = (k + hockey_stick k P Q / t) * t].
Proof.
move=> lQ t0 lo hi.
set S := [set a | _ < _] in lo; pose V := [set a | k * Q a == P a].
have SV : [set a | k * Q a <= P a] = S :|: V.
  by apply/setP => a; rewrite !inE le_eqVlt orbC.
have dis : [disjoint S & V].
  by rewrite -setI_eq0; apply/eqP/setP => a; rewrite !inE; case: (ltgtP (k * Q a) (P a)).
have Q0 a : 0 <= Q a by case: lQ.
have V0 : 0 <= prob Q V by apply: sumr_ge0.
have {}hi : t <= prob Q S + prob Q V.
  apply: le_trans hi _; rewrite SV !prob_expect -expectD le_eqVlt; apply/orP; left; apply/eqP.
  apply: eq_expect => // a; rewrite inE; case: (boolP (a \in S)) => [aS|_] /=; last by rewrite add0r.
  by rewrite (disjointFr dis aS) addr0.
pose c := (t - prob Q S) / prob Q V.
have cV : c * prob Q V = t - prob Q S.
  rewrite /c; case: (eqVneq (prob Q V) 0) hi => [->|ne _]; last by rewrite mulfVK.
  by rewrite addr0 mulr0 => hi; apply/esym/eqP; rewrite subr_eq0 eq_le hi lo.
have c0 : 0 <= c by rewrite divr_ge0 // subr_ge0.
have c1 : c <= 1.
  case: (eqVneq (prob Q V) 0) => [e|ne]; first by rewrite /c e invr0 mulr0 ler01.
  by rewrite ler_pdivr_mulr ?mul1r ?ler_subl_addl // lt0r ne.
pose phi a : R := (a \in S)%:R + c * (a \in V)%:R.
have EQ : expect Q phi = t.
  by rewrite expectD expectZ -!prob_expect cV addrCA subrr addr0.
exists phi; split=> // [a|].
  rewrite /phi; case: (boolP (a \in S)) => aS.
    by rewrite (disjointFr dis aS) mulr0 addr0 ler01 lexx.
  by rewrite add0r; case: (a \in V); rewrite ?mulr1 ?mulr0 ?c0 ?c1 ?lexx ?ler01.
have e : expect P phi - k * expect Q phi = hockey_stick k P Q.
  rewrite expect_diff; apply: eq_bigr => a _; rewrite /phi !inE.
  case: (ltgtP (k * Q a) (P a)) => h.
  - by rewrite mulr0 addr0 mulr1; apply/esym/max_idPr; rewrite subr_ge0 ltW.
  - by rewrite mulr0 addr0 mulr0; apply/esym/max_idPl; rewrite subr_le0 ltW.
  - by rewrite h subrr mul0r maxxx.
by rewrite mulrDl divfK ?gt_eqF // -e EQ; ring.
Qed.

(* Section 9: the least right side over k is attained.  At every level t there are a k (0 or a
   likelihood ratio) and a test phi of level t that turn the certificate into an equality. *)
Theorem certificate_exact t P Q : law P -> law Q -> 0 < t -> t <= 1 ->
  exists k phi, [/\ 0 <= k, k = 0 \/ (exists2 b, 0 < Q b & k = P b / Q b), test phi,
    expect Q phi = t & expect P phi = (k + hockey_stick k P Q / t) * t].
Proof.
move=> lP lQ t0 t1; have [k [k0 kc lo hi]] := threshold lP lQ t0 t1.
by have [phi [te eQ eP]] := threshold_test lQ t0 lo hi; exists k, phi.
Qed.

End Pair.

(* ---- Power of tests at a level: each notion of privacy bounds it ---- *)

Section Power.
Variables (R : realFieldType) (A : finType).
Implicit Types (P Q phi : A -> R) (k t : R).

(* If no test of level t has more power than b, every test with E_Q phi >= t has ratio at most b/t. *)
Lemma power_ratio t b P Q phi : law Q -> 0 < t -> power_le t b P Q -> test phi ->
  t <= expect Q phi -> expect P phi <= b / t * expect Q phi.
Proof.
move=> lQ t0 pw te fl; set s := expect Q phi in fl *.
have s0 : 0 < s := lt_le_trans t0 fl.
have c01 : 0 <= t / s <= 1 by rewrite divr_ge0 ?(ltW t0) ?(ltW s0) //= ler_pdivr_mulr // mul1r.
have := pw _ (test_scale c01 te); rewrite !expectZ divfK ?gt_eqF // => /(_ (lexx _)) h.
by rewrite mulrAC -mulrA -invf_div ler_pdivl_mulr ?divr_gt0 // mulrC.
Qed.

(* The cap. *)
Lemma power_cap t P Q : law P -> power_le t 1 P Q.
Proof. by move=> lP phi te _; case/andP: (expect_ranged lP te). Qed.

(* One k. *)
Lemma power_one_k t k P Q : 0 <= k -> power_le t (k * t + hockey_stick k P Q) P Q.
Proof.
move=> k0 phi te le; apply: le_trans (hockey_stick_test k P Q te) _.
by rewrite ler_add2r ler_wpmul2l.
Qed.

Lemma power_dp t k delta P Q : 0 <= k -> dp k delta P Q -> power_le t (k * t + delta) P Q.
Proof.
move=> k0 /dp_hockey_stick d phi te le; apply: le_trans (hockey_stick_test k P Q te) _.
by apply: ler_add => //; apply: ler_wpmul2l.
Qed.

(* The same privacy, read in the other order and for 1 - phi. *)
Lemma power_dp_reversed t k delta P Q : law P -> law Q -> 0 < k -> dp k delta Q P ->
  power_le t (1 - (1 - delta - t) / k) P Q.
Proof.
move=> lP lQ k0 /dp_hockey_stick d phi te le.
have := hockey_stick_test k Q P (test_neg te); rewrite !expectB !expect_cst // => h.
have {}h : 1 - expect Q phi <= k * (1 - expect P phi) + delta.
  by apply: le_trans h _; rewrite ler_add2l.
rewrite ler_subr_addr -ler_subr_addl ler_pdivr_mulr // mulrC.
by rewrite addrAC ler_subl_addr; apply: le_trans h; rewrite ler_add2l ler_opp2.
Qed.

(* A trade-off function at one level.  Neither convexity nor symmetry is needed if every ordered pair lies above it. *)
Lemma power_at_level t e P Q : law P -> law Q -> t <= 1 ->
  (forall phi, test phi -> expect Q phi = t -> e <= 1 - expect P phi) -> power_le t (1 - e) P Q.
Proof.
move=> lP lQ t1 ab phi te le; set s := expect Q phi in le.
have := le; rewrite le_eqVlt => /orP[/eqP e'|lt].
  by rewrite ler_subr_addl -ler_subr_addr; apply: ab.
have s1 : 0 < 1 - s by rewrite subr_gt0 (lt_le_trans lt).
pose c := (1 - t) / (1 - s).
have c0 : 0 <= c by apply: divr_ge0; [rewrite subr_ge0|exact: ltW].
have c1 : c <= 1 by rewrite ler_pdivr_mulr // mul1r ler_add2l ler_opp2.
have te' : test (fun a => 1 - c * (1 - phi a)) by apply: test_neg (test_scale _ (test_neg te)); rewrite c0.
have ex L : law L -> expect L (fun a => 1 - c * (1 - phi a)) = 1 - c * (1 - expect L phi).
  by move=> lL; rewrite expectB expectZ expectB expect_cst.
have lev : expect Q (fun a => 1 - c * (1 - phi a)) = t.
  by rewrite ex // -/s divfK ?gt_eqF // opprB addrCA subrr addr0.
have := ab _ te' lev; rewrite ex // => h.
rewrite ler_subr_addl -ler_subr_addr; apply: le_trans h _.
rewrite opprB addrCA subrr addr0 ler_pimull //.
by rewrite subr_ge0; case/andP: (expect_ranged lP te).
Qed.

Lemma power_above t f P Q : law P -> law Q -> t <= 1 -> above f P Q -> power_le t (1 - f t) P Q.
Proof. by move=> lP lQ t1 ab; apply: power_at_level => // phi te <-; apply: ab. Qed.

(* Both orders of a pair.  finv is the inverse of f: the least type II error that f allows at a level.
   What holds of (Q, P) with f holds of (P, Q) with finv ... *)
Lemma above_inverse (f finv : R -> R) P Q : law P -> law Q ->
  (forall alpha beta, 0 <= beta <= 1 -> f beta <= alpha -> finv alpha <= beta) ->
  above f Q P -> above finv P Q.
Proof.
move=> lP lQ inv ab phi te; apply: inv.
  by rewrite subr_ge0 ler_subl_addr ler_addl andbC; apply/andP; case/andP: (expect_ranged lP te).
have := ab _ (test_neg te); rewrite !expectB !expect_cst // opprB addrCA subrr addr0.
by [].
Qed.

(* ... so a curve known for both orders may be replaced by max(f, finv), ... *)
Lemma above_max (f finv : R -> R) P Q : law P -> law Q ->
  (forall alpha beta, 0 <= beta <= 1 -> f beta <= alpha -> finv alpha <= beta) ->
  above f P Q -> above f Q P -> above (fun alpha => Num.max (f alpha) (finv alpha)) P Q.
Proof.
move=> lP lQ inv ab ba phi te; rewrite le_maxl ab //=.
exact: (above_inverse lP lQ inv ba).
Qed.

(* ... and a curve known for one order covers both as min(f, finv). *)
Lemma above_min (f finv : R -> R) P Q : law P -> law Q ->
  (forall alpha beta, 0 <= beta <= 1 -> f beta <= alpha -> finv alpha <= beta) ->
  above f P Q -> let h := fun alpha => Num.min (f alpha) (finv alpha) in above h P Q /\ above h Q P.
Proof.
move=> lP lQ inv ab /=; split=> phi te; rewrite le_minl; first by rewrite ab.
by rewrite (above_inverse lQ lP inv ab te) orbT.
Qed.

(* Gaussian privacy, in terms of a symmetric distribution function Phi and its inverse on (0,1): it speaks of tests
   with 0 < E_Q phi < 1.  (At E_Q phi = 1 the curve would have to be 0, and Phi is positive everywhere.) *)
Definition gdp_curve (Phi Phi_inv : R -> R) (mu alpha : R) : R := Phi (Phi_inv (1 - alpha) - mu).

Definition gdp (Phi Phi_inv : R -> R) (mu : R) P Q : Prop :=
  forall phi, test phi -> 0 < expect Q phi < 1 -> gdp_curve Phi Phi_inv mu (expect Q phi) <= 1 - expect P phi.

(* Phi has values in (0,1), takes all of them, each once, and is symmetric. *)
Definition distribution (Phi Phi_inv : R -> R) : Prop :=
  [/\ forall z, 0 < Phi z < 1, forall z, Phi_inv (Phi z) = z, forall p, 0 < p < 1 -> Phi (Phi_inv p) = p
    & forall z, Phi (- z) = 1 - Phi z].

Lemma gdp_curveE Phi Phi_inv mu t : distribution Phi Phi_inv -> 0 < t < 1 ->
  1 - gdp_curve Phi Phi_inv mu t = Phi (Phi_inv t + mu).
Proof.
move=> [_ invK PhiK sym] t01; have inv : Phi_inv (1 - t) = - Phi_inv t by rewrite -{1}(PhiK t t01) -sym invK.
by rewrite /gdp_curve inv -opprD sym opprB addrCA subrr addr0.
Qed.

End Power.

(* ---- T3 for a policy behind a group filter ---- *)

Section T3.
Variables (R : realFieldType) (X Xt A At U : finType).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (T : Xt -> At -> U -> R) (g : U -> X -> A -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (kT : policy T).

Local Notation E := (utility (induced MX MA T) g).
Local Notation H k a a' := (hockey_stick k (MA a) (MA a')).

(* T3, one k (any k, for each ordered pair its own): R <= k + gamma H_k / tau. *)
Theorem T3_one_k gamma tau k x a a' : 0 <= gamma -> valued 0 gamma g -> a_free g ->
  0 < tau -> tau <= E x a' -> E x a <= (k + gamma * H k a a' / tau) * E x a'.
Proof.
move=> g0 vg fg t0 te.
have := T1_filter kX kA kT k t0 te g0 (lexx 0) vg (a := a).
by rewrite add0r; apply=> u; rewrite addr0 (fg u x a a').
Qed.

(* T3 from (log k, delta) of that ordered pair. *)
Theorem T3_one_k_dp gamma tau k delta x a a' : 0 <= gamma -> valued 0 gamma g -> a_free g ->
  dp k delta (MA a) (MA a') -> 0 < tau -> tau <= E x a' ->
  E x a <= (k + gamma * delta / tau) * E x a'.
Proof.
move=> g0 vg fg /dp_hockey_stick d t0 te.
apply: ratio_weaken (T3_one_k k a g0 vg fg t0 te); first exact: le_trans (ltW t0) te.
rewrite ler_add2l; apply: ler_wpmul2r; first by rewrite invr_ge0 ltW.
exact: ler_wpmul2l.
Qed.

(* T3 for a g that depends on the group by at most K: R <= k + (K + (gamma - K) H_k)/tau. *)
Theorem T3_K_one_k gamma tau K k x a a' : 0 <= K -> K <= gamma -> 0 <= k -> valued 0 gamma g ->
  (forall u, g u x a <= g u x a' + K) -> 0 < tau -> tau <= E x a' ->
  E x a <= (k + (K + (gamma - K) * H k a a') / tau) * E x a'.
Proof.
move=> K0 Kg k0 vg gK t0 te; apply: ratio_of_additive => //.
  by rewrite addr_ge0 // mulr_ge0 ?subr_ge0 // hockey_stick_ge0.
pose h' := response MX T g x a'; pose w b := Num.min (gamma - K) (h' b).
have h'0 : ranged 0 gamma h' by apply: response_ranged.
have rw : ranged 0 (gamma - K) w.
  by move=> b; rewrite /w le_minr le_minl lexx subr_ge0 Kg; case/andP: (h'0 b) => ->.
have step : E x a <= expect (MA a) w + K.
  rewrite utility_response -{1}(expect_cst K (kA a)) -expectD; apply: expect_le => // b.
  rewrite -ler_subl_addr /w le_minr !ler_subl_addr subrK response_le // andbT.
  by case/andP: (response_ranged x a kX kT vg b).
have := hockey_stick_ranged k (kA a) (kA a') rw; rewrite mulr0 !subr0 => le.
have wle : expect (MA a') w <= E x a'.
  by rewrite utility_response; apply: expect_le => // b; rewrite /w le_minl lexx orbT.
apply: le_trans step _; rewrite (addrC K) addrA ler_add2r; apply: le_trans le _.
by rewrite ler_add2r ler_wpmul2l.
Qed.

(* T3 from the power of the best test at level t = tau/gamma: R <= power/t. *)
Theorem T3_power gamma t b x a a' : 0 < gamma -> valued 0 gamma g -> a_free g -> 0 < t ->
  power_le t b (MA a) (MA a') -> t * gamma <= E x a' -> E x a <= b / t * E x a'.
Proof.
move=> g0 vg fg t0 pw te; pose phi c := gamma^-1 * response MX T g x a' c.
have ig : 0 < gamma^-1 by rewrite invr_gt0.
have tphi : test phi.
  move=> c; case/andP: (response_ranged x a' kX kT vg c) => l h.
  rewrite /phi mulr_ge0 ?(ltW ig) //= mulrC ler_pdivr_mulr // mul1r //.
have := power_ratio (kA a') t0 pw tphi; rewrite !expectZ -utility_response => le.
have ea : E x a = expect (MA a) (response MX T g x a').
  by rewrite utility_response; apply: eq_expect => // c; apply: response_free.
rewrite ea -(ler_pmul2l ig) mulrCA; apply: le.
by rewrite mulrC ler_pdivl_mulr.
Qed.

(* T3: if every ordered pair of rows lies above f, then R <= (1 - f(t))/t. *)
Theorem T3_tradeoff gamma t f : 0 < gamma -> valued 0 gamma g -> a_free g -> 0 < t -> t <= 1 ->
  every_pair (above f) MA -> has_floor (t * gamma) E -> local_le ((1 - f t) / t) E.
Proof.
move=> g0 vg fg t0 t1 ab fl x a a'; apply: (T3_power g0 vg fg t0 _ (fl x a')).
exact: power_above.
Qed.

(* T3 under mu-GDP: R <= Phi(Phi^-1(t) + mu)/t for 0 < t < 1.  (At t = 1 everybody gets gamma, and R = 1.) *)
Theorem T3_gdp gamma t mu Phi Phi_inv : distribution Phi Phi_inv ->
  0 < gamma -> valued 0 gamma g -> a_free g -> 0 < t < 1 ->
  every_pair (gdp Phi Phi_inv mu) MA -> has_floor (t * gamma) E ->
  local_le (Phi (Phi_inv t + mu) / t) E.
Proof.
move=> dis g0 vg fg t01 ab fl x a a'; have /andP[t0 t1] := t01.
rewrite -(gdp_curveE _ dis t01); apply: (T3_power g0 vg fg t0 _ (fl x a')).
by apply: power_at_level => // [|phi te e]; [exact: ltW|rewrite -e; apply: ab; rewrite // e].
Qed.

(* T3 under (eps, delta), the three terms: 1/t, e^eps + delta/t, (1 - e^-eps (1 - delta - t))/t. *)
Definition eps_delta_bound (k delta t : R) : R :=
  Num.min (1 / t) (Num.min (k + delta / t) ((1 - (1 - delta - t) / k) / t)).

Theorem T3_eps_delta gamma t k delta : 0 < gamma -> valued 0 gamma g -> a_free g -> 0 < t -> 0 < k ->
  every_pair (dp k delta) MA -> has_floor (t * gamma) E -> local_le (eps_delta_bound k delta t) E.
Proof.
move=> g0 vg fg t0 k0 d fl x a a'; rewrite /eps_delta_bound /Num.min.
have key b : power_le t b (MA a) (MA a') -> E x a <= b / t * E x a'.
  by move=> pw; apply: (T3_power g0 vg fg t0 pw (fl x a')).
case: ifP => _; first by apply: key; apply: power_cap.
case: ifP => _; last by apply: key; apply: power_dp_reversed.
have -> : k + delta / t = (k * t + delta) / t by rewrite mulrDl mulfK ?gt_eqF.
by apply: key; apply: power_dp => //; apply: ltW.
Qed.

(* T3 for a g that depends on the group by at most K, from the power at level tau/(gamma - K). *)
Theorem T3_K_power gamma tau K b x a a' : 0 <= K -> K < gamma -> valued 0 gamma g ->
  (forall u, g u x a <= g u x a' + K) -> 0 < tau -> tau <= E x a' ->
  power_le (tau / (gamma - K)) b (MA a) (MA a') ->
  E x a <= (K + (gamma - K) * b) / tau * E x a'.
Proof.
move=> K0 Kg vg gK t0 te pw.
have w0 : 0 < gamma - K by rewrite subr_gt0.
have wn : gamma - K != 0 by rewrite gt_eqF.
pose h' := response MX T g x a'; pose phi c := Num.min 1 (h' c / (gamma - K)).
have h'0 : ranged 0 gamma h' by apply: response_ranged.
have rw : test phi.
  move=> c; rewrite /phi le_minr le_minl lexx ler01 divr_ge0 ?(ltW w0) //.
  by case/andP: (h'0 c).
have step : E x a <= (gamma - K) * expect (MA a) phi + K.
  rewrite utility_response -expectZ -{2}(expect_cst K (kA a)) -expectD; apply: expect_le => // c.
  rewrite -ler_subl_addr /phi minr_pmulr ?(ltW w0) // mulr1 mulrC divfK //.
  rewrite le_minr !ler_subl_addr subrK response_le // andbT.
  by case/andP: (response_ranged x a kX kT vg c).
have le : (gamma - K) * expect (MA a') phi <= E x a'.
  rewrite utility_response -expectZ; apply: expect_le => // c.
  by rewrite /phi mulrC -ler_pdivl_mulr // le_minl lexx orbT.
set e' := E x a' in te le *; set t := tau / _ in pw.
have t0' : 0 < t by rewrite divr_gt0.
have tn : tau != 0 by rewrite gt_eqF.
have b0 : 0 <= b.
  have := pw (fun=> 0); rewrite !expect_cst //; apply; last exact: ltW.
  by move=> c; rewrite lexx ler01.
have main : expect (MA a) phi <= b / tau * e'.
  case: (leP t (expect (MA a') phi)) => h.
    apply: le_trans (power_ratio (kA a') t0' pw rw h) _.
    have -> : b / t * expect (MA a') phi = b / tau * ((gamma - K) * expect (MA a') phi).
      by rewrite /t invf_div !mulrA; congr (_ * _); rewrite -!mulrA; congr (_ * _); apply: mulrC.
    by apply: ler_wpmul2l => //; rewrite divr_ge0 // ltW.
  apply: le_trans (pw _ rw (ltW h)) _; rewrite -mulrA ler_pemulr //.
  by rewrite mulrC ler_pdivl_mulr // mul1r.
apply: le_trans step _; rewrite addrC [(K + _) / _]mulrDl mulrDl; apply: ler_add.
  by rewrite -mulrA ler_pemulr // mulrC ler_pdivl_mulr // mul1r.
by rewrite -!mulrA ler_pmul2l // mulrA.
Qed.

(* The same from a trade-off function: R <= (K + (gamma - K)(1 - f(tau/(gamma - K))))/tau if tau <= gamma - K.
   (Otherwise the cap gamma/tau remains: T1_cap.) *)
Theorem T3_K_tradeoff gamma tau K f : 0 <= K -> K < gamma -> valued 0 gamma g ->
  (forall u x a a', `|g u x a - g u x a'| <= K) -> 0 < tau -> tau <= gamma - K ->
  every_pair (above f) MA -> has_floor tau E ->
  local_le ((K + (gamma - K) * (1 - f (tau / (gamma - K)))) / tau) E.
Proof.
move=> K0 Kg vg gK t0 tg ab fl x a a'; apply: (T3_K_power K0 Kg vg) => //.
- by move=> u; rewrite -ler_subl_addl; apply: le_trans (ler_norm _) (gK _ _ _ _).
- by apply: power_above => //; rewrite ler_pdivr_mulr ?mul1r // subr_gt0.
Qed.

End T3.

(* ---- T3 is exact for a known filter ---- *)

Section Exact.
Variables (R : realFieldType) (X A At : finType) (MA : A -> At -> R).
Hypothesis kA : kernel MA.

(* There is one multiplier for each ordered pair of rows such that the greatest of their certificates
   bounds every policy with the floor (T3_one_k), and is attained by a policy under which every group
   keeps the floor. *)
Theorem T3_exact (a0 : A) t gamma : 0 < t -> t <= 1 -> 0 < gamma ->
  exists (k : A -> A -> R) (r : R) (phi : At -> R) (a a' : A),
  [/\ forall a a', 0 <= k a a' /\ k a a' + hockey_stick (k a a') (MA a) (MA a') / t <= r,
      policy (grant phi),
      has_floor (t * gamma) (utility (induced (@no_context R X) MA (grant phi)) (granted 0 gamma)) &
      forall x, let E := utility (induced (@no_context R X) MA (grant phi)) (granted 0 gamma) in
        E x a = r * E x a'].
Proof.
move=> t0 t1 g0.
have /fin_all_exists[c cP] (p : A * A) : exists kphi : R * (At -> R), [/\ 0 <= kphi.1, test kphi.2,
    expect (MA p.2) kphi.2 = t & expect (MA p.1) kphi.2 = (kphi.1 + hockey_stick kphi.1 (MA p.1) (MA p.2) / t) * t].
  by have [k [phi [k0 _ te eQ eP]]] := certificate_exact (kA p.1) (kA p.2) t0 t1; exists (k, phi).
pose val p := (c p).1 + hockey_stick (c p).1 (MA p.1) (MA p.2) / t.
have [p _ pmax] := @arg_maxP _ _ _ (a0, a0) xpredT val isT.
have [_ te eQ eP] := cP p; set phi := (c p).2 in te eQ eP; rewrite -/(val p) in eP.
have [a2 _ a2min] := @arg_minP _ _ _ a0 xpredT (fun a => expect (MA a) phi) isT.
set s := expect (MA a2) phi in a2min.
have st : s <= t by rewrite -eQ; apply: a2min.
have [psi [tpsi fl at2 at1]] : exists psi, [/\ test psi, forall a, t <= expect (MA a) psi,
    expect (MA a2) psi = t & val p * t <= expect (MA p.1) psi].
  move: st; rewrite le_eqVlt => /orP[/eqP e|lt].
    exists phi; rewrite eP -/s e; split=> // a.
    by rewrite -e; apply: a2min.
  have s1 : 0 < 1 - s by rewrite subr_gt0 (lt_le_trans lt).
  pose d := (1 - t) / (1 - s).
  have d0 : 0 <= d by apply: divr_ge0; [rewrite subr_ge0|exact: ltW].
  have d1 : d <= 1 by rewrite ler_pdivr_mulr // mul1r ler_add2l ler_opp2 ltW.
  have ex a : expect (MA a) (fun b => 1 - d * (1 - phi b)) = 1 - d * (1 - expect (MA a) phi).
    by rewrite expectB expectZ expectB !expect_cst.
  have dE : d * (1 - s) = 1 - t by rewrite divfK // gt_eqF.
  exists (fun b => 1 - d * (1 - phi b)); split.
  - by apply: test_neg (test_scale _ (test_neg te)); rewrite d0.
  - move=> a; rewrite ex ler_subr_addr -ler_subr_addl -dE ler_wpmul2l // ler_add2l ler_opp2.
    exact: a2min.
  - by rewrite ex -/s dE opprB addrCA subrr addr0.
  - rewrite ex -eP ler_subr_addr -ler_subr_addl ler_pimull //.
    by rewrite subr_ge0; case/andP: (expect_ranged (kA p.1) te).
exists (fun a a' => (c (a, a')).1), (val p), psi, p.1, a2; split=> [a a'||x a|x].
- by have [k0 _ _ _] := cP (a, a'); split=> //; apply: pmax (a, a') isT.
- exact: policy_grant.
- by rewrite utility_grant // add0r subr0 mulrC ler_pmul2l.
rewrite /= !utility_grant // !add0r subr0 mulrCA; congr (_ * _); rewrite at2.
apply/eqP; rewrite eq_le at1 andbT.
have [k0 _ _ _] := cP (p.1, a2).
apply: le_trans (certificate_one_k (c (p.1, a2)).1 (MA p.1) tpsi t0 (fl a2)) _.
by rewrite at2 ler_pmul2r //; apply: pmax (p.1, a2) isT.
Qed.

End Exact.
