(* T13: the greatest ratio that any policy attains behind given filters, for a given utility that may depend on the group.

   Reading key.  o is what a policy is shown, u a decision.  [value T p] is the numerator of a ratio for the policy T, a linear function of T,
   and [value T q] the denominator; p and q are nonnegative.  [surplus u0 p q V] is S(V) = sum over o of the greatest p(o,u) - V q(o,u); u0 is any
   decision and only says that there is one.  [always d] is the policy that takes the decision d(o) whenever o is shown.  "The ratio is at most V"
   is num <= V * den (see ratio_leP for V >= 1, where 0/0 = 1 and c/0 is infinite). *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- The greatest value of a function on a nonempty finite alphabet ---- *)

Section Greatest.
Variables (R : realFieldType) (U : finType) (u0 : U).
Implicit Types (c : U -> R).

Definition best c : U := [arg max_(u > u0) c u]%O.
Definition greatest c : R := c (best c).

Lemma greatest_ge c u : c u <= greatest c.
Proof. by rewrite /greatest /best; case: arg_maxP => // i _; apply. Qed.

Lemma greatest_le c b : (forall u, c u <= b) -> greatest c <= b.
Proof. by apply. Qed.

Lemma greatest_eq c u : (forall v, c v <= c u) -> greatest c = c u.
Proof. by move=> h; apply: le_anti; rewrite greatest_ge greatest_le. Qed.

Lemma eq_greatest c c' : c =1 c' -> greatest c = greatest c'.
Proof.
have le f f' : f =1 f' -> greatest f <= greatest f' by move=> e; apply: greatest_le => u; rewrite e greatest_ge.
by move=> e; apply: le_anti; rewrite !le // => u; rewrite e.
Qed.

Lemma greatest_scale s c : 0 <= s -> greatest (fun u => s * c u) = s * greatest c.
Proof. by move=> s0; apply: greatest_eq => v; apply: ler_wpmul2l => //; apply: greatest_ge. Qed.

End Greatest.

(* ---- Any policy, one ordered pair ---- *)

Section AnyPolicy.
Variables (R : realFieldType) (O U : finType) (u0 : U).
Implicit Types (T p q c : O -> U -> R) (d : O -> U) (V : R).

Definition value T c : R := \sum_o \sum_u T o u * c o u.
Definition always d : O -> U -> R := fun o => point R (d o).
Definition gain p q V : O -> U -> R := fun o u => p o u - V * q o u.
Definition surplus p q V : R := \sum_o greatest u0 (gain p q V o).

Lemma kernel_always d : kernel (always d).
Proof. by move=> o; apply: law_point. Qed.

Lemma value_always d c : value (always d) c = \sum_o c o (d o).
Proof. by apply: eq_bigr => o _; rewrite -[LHS]/(expect (point R (d o)) (c o)) expect_point. Qed.

Lemma eq_value T T' c c' : (forall o u, T o u = T' o u) -> (forall o u, c o u = c' o u) -> value T c = value T' c'.
Proof. by move=> eT ec; apply: eq_bigr => o _; apply: eq_bigr => u _; rewrite eT ec. Qed.

Lemma value_ge0 T c : kernel T -> (forall o u, 0 <= c o u) -> 0 <= value T c.
Proof. by move=> kT c0; apply: sumr_ge0 => o _; apply: (@expect_ge0 _ _ (T o) (c o)). Qed.

Lemma value_gain T p q V : value T (gain p q V) = value T p - V * value T q.
Proof.
rewrite /value mulr_sumr -sumrB; apply: eq_bigr => o _; rewrite mulr_sumr -sumrB; apply: eq_bigr => u _.
by rewrite /gain mulrBr mulrCA.
Qed.

Lemma valueD T c c' : value T (fun o u => c o u + c' o u) = value T c + value T c'.
Proof. by rewrite -big_split; apply: eq_bigr => o _; rewrite -big_split; apply: eq_bigr => u _; rewrite mulrDr. Qed.

Lemma value_sum (C : finType) T (y : C -> R) (e : C -> O -> U -> R) :
  value T (fun o u => \sum_c y c * e c o u) = \sum_c y c * value T (e c).
Proof.
transitivity (\sum_c \sum_o y c * \sum_u T o u * e c o u); last by apply: eq_bigr => c _; rewrite mulr_sumr.
rewrite exchange_big; apply: eq_bigr => o _.
transitivity (\sum_c \sum_u y c * (T o u * e c o u)); last by apply: eq_bigr => c _; rewrite mulr_sumr.
by rewrite exchange_big; apply: eq_bigr => u _; rewrite mulr_sumr; apply: eq_bigr => c _; rewrite mulrCA.
Qed.

Lemma law_greatest (D c : U -> R) : law D -> \sum_u D u * c u <= greatest u0 c.
Proof.
move=> lD; rewrite -(expect_cst (greatest u0 c) lD); apply: expect_le => // u.
exact: greatest_ge.
Qed.

Lemma value_le T c : kernel T -> value T c <= \sum_o greatest u0 (c o).
Proof. by move=> kT; apply: ler_sum => o _; apply: law_greatest. Qed.

Lemma value_best c : value (always (fun o => best u0 (c o))) c = \sum_o greatest u0 (c o).
Proof. exact: value_always. Qed.

(* The greatest value of a linear function of the policy, attained without lots. *)
Theorem T13_value c :
  (forall T, kernel T -> value T c <= \sum_o greatest u0 (c o)) /\
  exists d, value (always d) c = \sum_o greatest u0 (c o).
Proof. by split=> [T|]; [apply: value_le|exists (fun o => best u0 (c o)); apply: value_best]. Qed.

(* S(V) is the greatest excess of the numerator over V times the denominator. *)
Lemma surplus_ge T p q V : kernel T -> value T p <= V * value T q + surplus p q V.
Proof. by move=> kT; rewrite -ler_subl_addl -value_gain; apply: value_le. Qed.

Lemma surplus_attained p q V : exists d, value (always d) p = V * value (always d) q + surplus p q V.
Proof.
exists (fun o => best u0 (gain p q V o)); apply/eqP; rewrite -subr_eq0 opprD addrA -value_gain.
by rewrite value_best subrr.
Qed.

(* T13: every policy has a ratio of at most V exactly if S(V) <= 0.  If not, a policy without lots exceeds V. *)
Theorem T13_any_policy p q V :
  (forall T, kernel T -> value T p <= V * value T q) <-> surplus p q V <= 0.
Proof.
split=> [all|s T kT]; last by apply: le_trans (surplus_ge p q V kT) _; rewrite -[leRHS]addr0 ler_add2l.
have [d e] := surplus_attained p q V.
by have := all _ (kernel_always d); rewrite e -[leRHS]addr0 ler_add2l.
Qed.

Theorem T13_deterministic p q V : 0 < surplus p q V -> exists d, V * value (always d) q < value (always d) p.
Proof. by move=> s; have [d e] := surplus_attained p q V; exists d; rewrite e ltr_addl. Qed.

(* The conventions of the page, 0/0 = 1 and c/0 infinite: for V >= 1 they say num <= V * den. *)
Definition ratio_le (V num den : R) : Prop := if den == 0 then num = 0 /\ 1 <= V else num / den <= V.

Lemma ratio_leP V num den : 1 <= V -> 0 <= num -> 0 <= den -> ratio_le V num den <-> num <= V * den.
Proof.
move=> V1 n0 d0; rewrite /ratio_le; have [->|dn] := eqVneq den 0; last first.
  by rewrite ler_pdivr_mulr // lt_def dn.
rewrite mulr0; split=> [[-> _]//|n1]; split=> //.
by apply: le_anti; rewrite n1.
Qed.

(* Newton's method: behind a positive S(V) lies a greater ratio. *)
Theorem T13_newton p q V d : 0 < surplus p q V -> (forall o u, gain p q V o u <= gain p q V o (d o)) ->
  0 < value (always d) q -> V < value (always d) p / value (always d) q.
Proof.
move=> s dmax q0; rewrite ltr_pdivl_mulr // -subr_gt0 -value_gain; apply: lt_le_trans s _.
by rewrite value_always; apply: ler_sum => o _; apply: greatest_le.
Qed.

Section Nonnegative.
Variables p q : O -> U -> R.
Hypotheses (p0 : forall o u, 0 <= p o u) (q0 : forall o u, 0 <= q o u).

(* The ratio is infinite for some policy exactly if decisions with q = 0 everywhere leave something in the numerator. *)
Theorem T13_infinite :
  (exists T, [/\ kernel T, value T q = 0 & 0 < value T p]) <->
  (exists d, (forall o, q o (d o) = 0) /\ 0 < \sum_o p o (d o)).
Proof.
split=> [[T [kT Tq Tp]]|[d [dq dp]]]; last first.
  exists (always d); split; [exact: kernel_always| |by rewrite value_always].
  by rewrite value_always big1.
have T0 o u : 0 <= T o u by case: (kT o).
have z o u : T o u * q o u = 0.
  have i0 o' : 0 <= \sum_u T o' u * q o' u by apply: sumr_ge0 => v _; apply: mulr_ge0.
  have := psumr_eq0P (fun o' _ => i0 o') Tq; move=> /(_ o isT) zo.
  by apply: (psumr_eq0P (fun v _ => mulr_ge0 (T0 o v) (q0 o v)) zo).
pose f o u := if q o u == 0 then p o u else -1.
have some o : exists u, q o u = 0.
  case: (pickP (fun u => q o u == 0)) => [u /eqP e|no]; first by exists u.
  case: (kT o) => _; rewrite big1 => [/esym/eqP|u _]; first by rewrite oner_eq0.
  by have /eqP := z o u; rewrite mulf_eq0 no orbF => /eqP.
pose d o := best u0 (f o); exists d.
have dq o : q o (d o) = 0.
  have [u e] := some o; have := greatest_ge u0 (f o) u.
  rewrite /greatest -/(d o) /f e eqxx; case: eqP => // _ /(le_trans (p0 o u)).
  by rewrite ler0N1.
split=> //; apply: lt_le_trans Tp _; apply: ler_sum => o _.
rewrite -(expect_cst (p o (d o)) (kT o)); apply: ler_sum => u _.
have [e|] := eqVneq (q o u) 0.
  apply: ler_wpmul2l => //; have := greatest_ge u0 (f o) u.
  by rewrite /greatest -/(d o) /f e dq eqxx.
by move=> qn; have /eqP := z o u; rewrite mulf_eq0 (negbTE qn) orbF => /eqP ->; rewrite !mul0r.
Qed.

(* The greatest ratio exists and is attained without lots: it is infinite, or V with S(V) <= 0, and above 1 a policy has exactly it. *)
Theorem T13_supremum :
  (exists d, value (always d) q = 0 /\ 0 < value (always d) p) \/
  (exists V, [/\ 1 <= V, surplus p q V <= 0 &
     V = 1 \/ exists d, 0 < value (always d) q /\ value (always d) p = V * value (always d) q]).
Proof.
pose num (d : {ffun O -> U}) := value (always d) p; pose den (d : {ffun O -> U}) := value (always d) q.
have n0 (d : {ffun O -> U}) : 0 <= num d by apply: value_ge0 => //; apply: kernel_always.
have d0 (d : {ffun O -> U}) : 0 <= den d by apply: value_ge0 => //; apply: kernel_always.
case: (pickP (fun d : {ffun O -> U} => (den d == 0) && (0 < num d))) => [d /andP[/eqP dz dn]|fin].
  by left; exists d.
right; have [d _ dmax] := @arg_maxP _ _ _ [ffun=> u0] xpredT (fun d : {ffun O -> U} => num d / den d) isT.
set r := num d / den d in dmax.
exists (Num.max 1 r); split; first by rewrite le_maxr lexx.
  rewrite leNgt; apply/negP => /T13_deterministic[e].
  have fE c : value (always e) c = value (always [ffun o => e o]) c.
    by rewrite !value_always; apply: eq_bigr => o _; rewrite ffunE.
  set e' := [ffun o => e o] in fE; rewrite !fE -/(num e') -/(den e').
  case: (ltrgtP 0 (den e')) (d0 e') => [pos _||z _]; last 1 first.
  - by rewrite -z mulr0 => gt0; have := fin e'; rewrite -z eqxx gt0.
  - rewrite ltNge => /negP; apply; rewrite -ler_pdivr_mulr // le_maxr.
    by apply/orP; right; apply: dmax.
  - by [].
case: (leP r 1) => r1; first by left.
right; exists d; rewrite -/(num d) -/(den d).
have pos : 0 < den d.
  rewrite lt_def d0 andbT; apply/eqP => z; move: r1.
  by rewrite /r z invr0 mulr0 ltNge ler01.
by split=> //; rewrite divfK // gt_eqF.
Qed.

End Nonnegative.
End AnyPolicy.

(* ---- Within a context: what is released of the context drops out ---- *)

Section Local.
Variables (R : realFieldType) (X Xt A At U : finType) (u0 : U).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (g : U -> X -> A -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (g0 : forall u x a, 0 <= g u x a).
Implicit Types (T : Xt -> At -> U -> R) (d : At -> U) (V : R).
Local Notation E T := (utility (induced MX MA T) g).

(* p(o,u) of the page with o = b, the released group: q is that of the other group. *)
Definition local_part x a (b : At) u : R := MA a b * g u x a.
Definition local_surplus V x a a' : R := surplus u0 (local_part x a) (local_part x a') V.

Lemma local_part_ge0 x a b u : 0 <= local_part x a b u.
Proof. by apply: mulr_ge0 => //; case: (kA a). Qed.

Lemma policy_always d : policy (fun _ : Xt => always R d).
Proof. by move=> y; apply: kernel_always. Qed.

(* E(x,a) is the mean, over what is released of x, of a linear function of the policy. *)
Lemma utility_value T x a : E T x a = expect (MX x) (fun y => value (T y) (local_part x a)).
Proof.
rewrite utility_response /expect /value; under eq_bigr do rewrite mulr_sumr.
rewrite exchange_big; apply: eq_bigr => y _; rewrite mulr_sumr; apply: eq_bigr => b _.
by rewrite !mulr_sumr; apply: eq_bigr => u _; rewrite /local_part; ring.
Qed.

Lemma utility_always d x a : E (fun=> always R d) x a = \sum_b MA a b * g (d b) x a.
Proof. by rewrite utility_value expect_cst // value_always. Qed.

Lemma utility_ge0 T x a : policy T -> 0 <= E T x a.
Proof.
move=> kT; rewrite utility_value; apply: expect_ge0 => // y.
by apply: value_ge0 => // b u; apply: local_part_ge0.
Qed.

Lemma local_surplus_ge T V x a a' : policy T -> E T x a <= V * E T x a' + local_surplus V x a a'.
Proof.
move=> kT; rewrite !utility_value -expectZ -(expect_cst (local_surplus V x a a') (kX x)) -expectD.
by apply: expect_le => // y; apply: surplus_ge.
Qed.

(* T13 for an ordered pair of groups in a context. *)
Theorem T13_local V x a a' : (forall T, policy T -> E T x a <= V * E T x a') <-> local_surplus V x a a' <= 0.
Proof.
split=> [all|s T kT]; last by apply: le_trans (local_surplus_ge V x a a' kT) _; rewrite -[leRHS]addr0 ler_add2l.
have [d e] := surplus_attained u0 (local_part x a) (local_part x a') V.
have := all _ (policy_always d); rewrite !utility_value !expect_cst // e.
by rewrite -[leRHS]addr0 ler_add2l.
Qed.

(* R <= V for every policy, exactly if S(V) <= 0 for every context and every ordered pair of different groups. *)
Theorem T13_local_ratio V : 1 <= V ->
  (forall T, policy T -> local_le V (E T)) <-> (forall x a a', a != a' -> local_surplus V x a a' <= 0).
Proof.
move=> V1; split=> [all x a a' _|s T kT x a a']; first by apply/T13_local => T kT; apply: all.
have [<-|n] := eqVneq a a'; last by move/T13_local: (s x _ _ n); apply.
by rewrite ler_pemull // utility_ge0.
Qed.

(* The claim "the greatest R of any policy is V": S(V) <= 0 everywhere, and at one pair the decisions d give the excess 0 and a positive
   denominator.  Then R <= V for every policy, the policy that decides by d has the ratio V, and no lesser bound holds. *)
Theorem T13_local_supremum V x a a' d : 1 <= V -> (forall x a a', a != a' -> local_surplus V x a a' <= 0) ->
  \sum_b (MA a b * g (d b) x a - V * (MA a' b * g (d b) x a')) = 0 -> 0 < \sum_b MA a' b * g (d b) x a' ->
  let T := fun _ : Xt => always R d in
  [/\ forall T, policy T -> local_le V (E T), policy T, 0 < E T x a', E T x a = V * E T x a' &
      forall V', (forall T, policy T -> local_le V' (E T)) -> V <= V'].
Proof.
move=> V1 s z pos T; have kT : policy T := policy_always d.
have e : E T x a = V * E T x a'.
  by apply/eqP; rewrite -subr_eq0 !utility_always mulr_sumr -sumrB z.
have pos' : 0 < E T x a' by rewrite utility_always.
split=> // [|V' all]; first exact/T13_local_ratio.
by rewrite -(ler_pmul2r pos') -e; apply: all.
Qed.

(* The claim "the greatest R is infinite": decisions that leave one group nothing and the other something. *)
Theorem T13_local_infinite x a a' d : (forall b, MA a' b * g (d b) x a' = 0) -> 0 < \sum_b MA a b * g (d b) x a ->
  let T := fun _ : Xt => always R d in
  [/\ policy T, E T x a' = 0, 0 < E T x a & forall V, ~ (forall T, policy T -> local_le V (E T))].
Proof.
move=> z pos T; have kT : policy T := policy_always d.
have e : E T x a' = 0 by rewrite utility_always big1.
have pos' : 0 < E T x a by rewrite utility_always.
by split=> // V /(_ _ kT x a a'); rewrite e mulr0 leNgt pos'.
Qed.

End Local.

(* ---- Group means ---- *)

Section Global.
Variables (R : realFieldType) (X Xt A At U : finType) (u0 : U).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (g : U -> X -> A -> R) (W : A -> X -> R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (g0 : forall u x a, 0 <= g u x a) (W0 : forall a x, 0 <= W a x).
Implicit Types (T : Xt -> At -> U -> R) (d : Xt * At -> U) (V : R).
Local Notation M T := (group_mean W (utility (induced MX MA T) g)).

(* p(o,u) of the page with o = (y,b): W a x = P(x|a), and G_a(y,u) is what does not depend on the group filter. *)
Definition global_part a (o : Xt * At) u : R := MA a o.2 * \sum_x W a x * MX x o.1 * g u x a.
Definition global_surplus V a a' : R := surplus u0 (global_part a) (global_part a') V.
Definition joint T : Xt * At -> U -> R := fun o => T o.1 o.2.
Definition by_shown d : Xt -> At -> U -> R := fun y b => always R d (y, b).

Lemma kernel_joint T : policy T -> kernel (joint T).
Proof. by move=> kT o; apply: kT. Qed.

Lemma policy_by_shown d : policy (by_shown d).
Proof. by move=> y b; apply: kernel_always. Qed.

Lemma global_part_ge0 a o u : 0 <= global_part a o u.
Proof.
apply: mulr_ge0; first by case: (kA a).
by apply: sumr_ge0 => x _; rewrite !mulr_ge0 //; case: (kX x).
Qed.

(* The group mean is a linear function of the policy. *)
Lemma mean_value T a : M T a = value (joint T) (global_part a).
Proof.
rewrite /group_mean /value -(pair_bigA _ (fun y b => \sum_u T y b u * global_part a (y, b) u)) /=.
under eq_bigr => x _ do rewrite utility_value /expect mulr_sumr.
rewrite exchange_big; apply: eq_bigr => y _; rewrite /value.
under eq_bigr => x _ do rewrite !mulr_sumr.
rewrite exchange_big; apply: eq_bigr => b _.
under eq_bigr => x _ do rewrite !mulr_sumr.
rewrite exchange_big; apply: eq_bigr => u _; rewrite /global_part !mulr_sumr; apply: eq_bigr => x _.
by rewrite /local_part /=; ring.
Qed.

Lemma mean_by_shown d a : M (by_shown d) a = \sum_o global_part a o (d o).
Proof. by rewrite mean_value -value_always; apply: eq_value => -[y b] u. Qed.

Lemma mean_ge0 T a : policy T -> 0 <= M T a.
Proof.
move=> kT; rewrite mean_value; apply: value_ge0 => [|o u]; last exact: global_part_ge0.
exact: kernel_joint.
Qed.

(* The same for a single context: the numerator and the denominator of R as functions of everything that a policy does. *)
Definition cell_part x a (o : Xt * At) u : R := MX x o.1 * MA a o.2 * g u x a.

Lemma cell_part_ge0 x a o u : 0 <= cell_part x a o u.
Proof. by rewrite !mulr_ge0 //; [case: (kX x)|case: (kA a)]. Qed.

Lemma cell_value T x a : utility (induced MX MA T) g x a = value (joint T) (cell_part x a).
Proof.
rewrite utility_value /value -(pair_bigA _ (fun y b => \sum_u T y b u * cell_part x a (y, b) u)) /=.
apply: eq_bigr => y _; rewrite /value mulr_sumr; apply: eq_bigr => b _; rewrite mulr_sumr; apply: eq_bigr => u _.
by rewrite /cell_part /local_part /=; ring.
Qed.

(* T13 for an ordered pair of group means. *)
Theorem T13_global V a a' : (forall T, policy T -> M T a <= V * M T a') <-> global_surplus V a a' <= 0.
Proof.
split=> [all|/T13_any_policy s T kT]; last by rewrite !mean_value; apply/s/kernel_joint.
apply/T13_any_policy => T kT; have kT' : policy (fun y b => T (y, b)) by move=> y b; apply: kT.
have e c : M (fun y b => T (y, b)) c = value T (global_part c).
  by rewrite mean_value; apply: eq_value => -[y b] u.
by rewrite -!e; apply: all.
Qed.

Theorem T13_global_ratio V : 1 <= V ->
  (forall T, policy T -> global_le V (M T)) <-> (forall a a', a != a' -> global_surplus V a a' <= 0).
Proof.
move=> V1; split=> [all a a' _|s T kT a a']; first by apply/T13_global => T kT; apply: all.
have [<-|n] := eqVneq a a'; last by move/T13_global: (s _ _ n); apply.
by rewrite ler_pemull // mean_ge0.
Qed.

(* The claim "the greatest ratio of group means over all policies is V". *)
Theorem T13_global_supremum V a a' d : 1 <= V -> (forall a a', a != a' -> global_surplus V a a' <= 0) ->
  \sum_o (global_part a o (d o) - V * global_part a' o (d o)) = 0 -> 0 < \sum_o global_part a' o (d o) ->
  let T := by_shown d in
  [/\ forall T, policy T -> global_le V (M T), policy T, 0 < M T a', M T a = V * M T a' &
      forall V', (forall T, policy T -> global_le V' (M T)) -> V <= V'].
Proof.
move=> V1 s z pos T; have kT : policy T := policy_by_shown d.
have e : M T a = V * M T a'.
  by apply/eqP; rewrite -subr_eq0 !mean_by_shown mulr_sumr -sumrB z.
have pos' : 0 < M T a' by rewrite mean_by_shown.
split=> // [|V' all]; first exact/T13_global_ratio.
by rewrite -(ler_pmul2r pos') -e; apply: all.
Qed.

Theorem T13_global_infinite a a' d : (forall o, global_part a' o (d o) = 0) -> 0 < \sum_o global_part a o (d o) ->
  let T := by_shown d in
  [/\ policy T, M T a' = 0, 0 < M T a & forall V, ~ (forall T, policy T -> global_le V (M T))].
Proof.
move=> z pos T; have kT : policy T := policy_by_shown d.
have e : M T a' = 0 by rewrite mean_by_shown big1.
have pos' : 0 < M T a by rewrite mean_by_shown.
by split=> // V /(_ _ kT a a'); rewrite e mulr0 leNgt pos'.
Qed.

End Global.

(* ---- The least bound of a class of policies: what a policy of the class attains ---- *)

Section Class.
Variables (R : realFieldType) (T : Type) (class : T -> Prop) (num den : T -> R).

Theorem T13_attained t V : class t -> 0 < den t -> num t = V * den t ->
  forall V', (forall t, class t -> num t <= V' * den t) -> V <= V'.
Proof. by move=> ct pos e V' /(_ _ ct); rewrite e ler_pmul2r. Qed.

Theorem T13_attained_infinite t : class t -> den t = 0 -> 0 < num t ->
  forall V, ~ (forall t, class t -> num t <= V * den t).
Proof. by move=> ct z pos V /(_ _ ct); rewrite z mulr0 leNgt pos. Qed.

End Class.

(* ---- In a context, for a utility that ignores the group: a closed form ---- *)

Section Free.
Variables (R : realFieldType) (A At U : finType) (u0 : U) (P Q : At -> R) (h : U -> R) (m gamma : R).
Hypotheses (lP : law P) (lQ : law Q) (rh : ranged m gamma h).

(* S(V) <= (gamma - m) H_V - m (V - 1), with equality if m and gamma are values of the utility. *)
Lemma surplus_free_le V : surplus u0 (fun b u => P b * h u) (fun b u => Q b * h u) V <=
  (gamma - m) * hockey_stick V P Q - m * (V - 1).
Proof.
rewrite (_ : - (m * (V - 1)) = \sum_b (P b - V * Q b) * m); last first.
  by rewrite -mulr_suml sumrB -mulr_sumr (proj2 lP) (proj2 lQ); ring.
rewrite /hockey_stick mulr_sumr -big_split; apply: ler_sum => b _; apply: greatest_le => u.
have /andP[lo hi] := rh u; rewrite /gain.
have -> : P b * h u - V * (Q b * h u) = (P b - V * Q b) * h u by ring.
rewrite /= -ler_subl_addr -mulrBr mulrC; case: (leP 0 (P b - V * Q b)) => s.
  by apply: ler_wpmul2r => //; rewrite ler_add2r.
by rewrite mulr0 nmulr_lle0 // subr_ge0.
Qed.

Theorem T13_free V : (exists u, h u = m) -> (exists u, h u = gamma) ->
  surplus u0 (fun b u => P b * h u) (fun b u => Q b * h u) V = (gamma - m) * hockey_stick V P Q - m * (V - 1).
Proof.
move=> [u um] [v vg]; apply: le_anti; rewrite surplus_free_le /=.
rewrite (_ : - (m * (V - 1)) = \sum_b (P b - V * Q b) * m); last first.
  by rewrite -mulr_suml sumrB -mulr_sumr (proj2 lP) (proj2 lQ); ring.
rewrite /hockey_stick mulr_sumr -big_split; apply: ler_sum => b _ /=.
case: (leP 0 (P b - V * Q b)) => s.
  apply: le_trans (greatest_ge u0 _ v); rewrite /gain vg le_eqVlt; apply/orP; left; apply/eqP; ring.
by apply: le_trans (greatest_ge u0 _ u); rewrite /gain um mulr0 add0r le_eqVlt; apply/orP; left; apply/eqP; ring.
Qed.

End Free.

(* T13 in a context for a utility that ignores the group and has least value m and greatest gamma there. *)
Theorem T13_local_free (R : realFieldType) (X Xt A At U : finType) (MX : X -> Xt -> R) (MA : A -> At -> R)
    (g : U -> X -> A -> R) (m gamma V : R) x a a' : kernel MX -> kernel MA -> (forall u, g u x a = g u x a') ->
  (forall u, m <= g u x a <= gamma) -> (exists u, g u x a = m) -> (exists u, g u x a = gamma) ->
  (forall T, policy T -> utility (induced MX MA T) g x a <= V * utility (induced MX MA T) g x a') <->
  (gamma - m) * hockey_stick V (MA a) (MA a') <= m * (V - 1).
Proof.
move=> kX kA fg rg um ug; have [u0 _] := um.
apply: iff_trans; first exact: (T13_local u0 MA g kX V x a a').
rewrite -(subr_le0 (m * (V - 1))) -(T13_free u0 (kA a) (kA a') rg V um ug) /local_surplus.
rewrite (_ : surplus _ _ _ _ = surplus u0 (fun b u => MA a b * g u x a) (fun b u => MA a' b * g u x a) V) //.
by apply: eq_bigr => b _; apply: eq_greatest => u; rewrite /gain /local_part fg.
Qed.

(* ---- Outputs of equal likelihood ratio may be merged ---- *)

Section Merge.
Variables (R : realFieldType) (B C : finType) (f : B -> C).
Implicit Types (P Q : B -> R) (F : R -> R -> R).

(* f says into which class an output goes; a class has the sum of the probabilities. *)
Definition merged P (c : C) : R := \sum_(b | f b == c) P b.

(* Outputs of a class have the same likelihood ratio P : Q; an output of probability (0, 0) may be in any. *)
Definition alike P Q : Prop := forall b b', f b = f b' -> P b * Q b' = P b' * Q b.

(* What is summed over outputs is positively homogeneous in (P, Q). *)
Definition homogeneous F : Prop := forall s x y, 0 <= s -> F (s * x) (s * y) = s * F x y.

Lemma merged_ge0 P c : (forall b, 0 <= P b) -> 0 <= merged P c.
Proof. by move=> P0; apply: sumr_ge0. Qed.

Lemma law_merged P : law P -> law (merged P).
Proof.
move=> [P0 P1]; split=> [c|]; first exact: merged_ge0.
by rewrite -P1 (partition_big f xpredT).
Qed.

Theorem T13_merge F P Q : homogeneous F -> (forall b, 0 <= P b) -> (forall b, 0 <= Q b) -> alike P Q ->
  \sum_b F (P b) (Q b) = \sum_c F (merged P c) (merged Q c).
Proof.
move=> hF P0 Q0 al; rewrite (partition_big f xpredT) //=; apply: eq_bigr => c _.
have F0 : F 0 0 = 0 by have := hF 0 0 0 (lexx 0); rewrite !mul0r.
pose n := merged P c + merged Q c.
have n0 : 0 <= n by rewrite addr_ge0 ?merged_ge0.
have nE : n = \sum_(b | f b == c) (P b + Q b) by rewrite big_split.
have [z|nz] := eqVneq n 0.
  have PQ b : f b == c -> P b = 0 /\ Q b = 0.
    move=> fb; have s0 b' : f b' == c -> 0 <= P b' + Q b' by move=> _; rewrite addr_ge0.
    move: z; rewrite nE => /(psumr_eq0P s0) /(_ b fb)/eqP.
    by rewrite paddr_eq0 // => /andP[/eqP-> /eqP->].
  by rewrite /merged !big1 => [|b /PQ[]|b /PQ[]|b /PQ[-> ->]].
have key b : f b == c -> P b = (P b + Q b) / n * merged P c /\ Q b = (P b + Q b) / n * merged Q c.
  move=> /eqP fb.
  have kP : P b * n = (P b + Q b) * merged P c.
    rewrite /n mulrDr mulrDl; congr (_ + _); rewrite /merged !mulr_sumr; apply: eq_bigr => b' /eqP fb'.
    by rewrite [RHS]mulrC; apply: al; rewrite fb fb'.
  have kQ : Q b * n = (P b + Q b) * merged Q c.
    rewrite /n mulrDr mulrDl; congr (_ + _); rewrite /merged !mulr_sumr; apply: eq_bigr => b' /eqP fb'.
    by rewrite [LHS]mulrC; apply: al; rewrite fb fb'.
  by rewrite ![_ / n * _]mulrAC -kP -kQ !mulfK.
transitivity (\sum_(b | f b == c) (P b + Q b) / n * F (merged P c) (merged Q c)).
  apply: eq_bigr => b /key[eP eQ].
  by rewrite -hF -?eP -?eQ // divr_ge0 // addr_ge0.
by rewrite -mulr_suml -mulr_suml -nE divff // mul1r.
Qed.

(* S(V) and H_k are such sums.  In a context alpha and beta do not depend on y; of group means y is the released context. *)
Lemma homogeneous_greatest (U : finType) (u0 : U) (alpha beta : U -> R) V :
  homogeneous (fun x y => greatest u0 (fun u => x * alpha u - V * (y * beta u))).
Proof.
move=> s x y s0; rewrite -greatest_scale //; apply: eq_greatest => u.
by ring.
Qed.

Lemma homogeneous_hockey_stick k : homogeneous (fun x y => Num.max 0 (x - k * y)).
Proof.
move=> s x y s0; have -> : s * x - k * (s * y) = s * (x - k * y) by ring.
by rewrite maxr_pmulr // mulr0.
Qed.

End Merge.

(* One factor of a product of filters is merged at a time: the merged factor takes the place of the factor. *)
Section Factors.
Variables (R : realFieldType) (B C D : finType) (f : B -> C).
Variables (P Q : B -> R) (P' Q' : D -> R).
Hypotheses (P0 : forall b, 0 <= P b) (Q0 : forall b, 0 <= Q b) (P'0 : forall d, 0 <= P' d) (Q'0 : forall d, 0 <= Q' d).

Theorem T13_merge_factor (F : D -> R -> R -> R) : (forall d, homogeneous (F d)) -> alike f P Q ->
  \sum_b \sum_d F d (P b * P' d) (Q b * Q' d) = \sum_c \sum_d F d (merged f P c * P' d) (merged f Q c * Q' d).
Proof.
move=> hF al; rewrite exchange_big [RHS]exchange_big; apply: eq_bigr => d _.
apply: (T13_merge (F := fun x y => F d (x * P' d) (y * Q' d))) => // s x y s0.
by rewrite -!mulrA hF.
Qed.

(* Classes of one ratio in each factor have one ratio in the product. *)
Lemma alike_product (C' : finType) (f' : D -> C') : alike f P Q -> alike f' P' Q' ->
  alike (fun bd : B * D => (f bd.1, f' bd.2)) (fun bd => P bd.1 * P' bd.2) (fun bd => Q bd.1 * Q' bd.2).
Proof.
move=> al al' [b d] [b' d'] [/al e /al' e'] /=.
have -> : P b * P' d * (Q b' * Q' d') = P b * Q b' * (P' d * Q' d') by ring.
by rewrite e e'; ring.
Qed.

End Factors.

(* The instances that certificates use. *)
Section MergeInstances.
Variables (R : realFieldType) (B C Y U : finType) (u0 : U) (f : B -> C) (P Q : B -> R).
Hypotheses (P0 : forall b, 0 <= P b) (Q0 : forall b, 0 <= Q b) (al : alike f P Q).

Theorem T13_merge_surplus (alpha beta : Y -> U -> R) V :
  surplus u0 (fun o u => P o.2 * alpha o.1 u) (fun o u => Q o.2 * beta o.1 u) V =
  surplus u0 (fun o u => merged f P o.2 * alpha o.1 u) (fun o u => merged f Q o.2 * beta o.1 u) V.
Proof.
rewrite /surplus -(pair_bigA _ (fun y b => greatest u0 (gain (fun o u => P o.2 * alpha o.1 u) (fun o u => Q o.2 * beta o.1 u) V (y, b)))).
rewrite -(pair_bigA _ (fun y c => greatest u0 (gain (fun o u => merged f P o.2 * alpha o.1 u) (fun o u => merged f Q o.2 * beta o.1 u) V (y, c)))) /=.
apply: eq_bigr => y _; have := T13_merge (homogeneous_greatest u0 (alpha y) (beta y) V) P0 Q0 al; exact.
Qed.

Theorem T13_merge_local_surplus (alpha beta : U -> R) V :
  surplus u0 (fun b u => P b * alpha u) (fun b u => Q b * beta u) V =
  surplus u0 (fun c u => merged f P c * alpha u) (fun c u => merged f Q c * beta u) V.
Proof. exact: (T13_merge (homogeneous_greatest u0 alpha beta V)). Qed.

Theorem T13_merge_hockey_stick k : hockey_stick k P Q = hockey_stick k (merged f P) (merged f Q).
Proof. exact: (T13_merge (homogeneous_hockey_stick k)). Qed.

End MergeInstances.
