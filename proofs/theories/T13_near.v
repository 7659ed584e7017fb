(* T13 near a policy: all policies within total variation eta of a given one, for everything that is shown.

   Reading key.  eta is moved from the decisions with the least c to one with the greatest: [from_least eta T c r] says that r is the mass that
   is taken, no more of a decision than T has, eta in all, and nothing of a decision before all decisions with a lesser c are used up.  How ties
   are broken does not matter. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T13.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- One law of decisions ---- *)

Section OneLaw.
Variables (R : realFieldType) (U : finType) (u0 : U).
Implicit Types (D T r c : U -> R) (eta theta : R).

Definition part_of eta T r : Prop := (forall u, 0 <= r u <= T u) /\ \sum_u r u = eta.
Definition from_least eta T c r : Prop := part_of eta T r /\ forall u v, c u < c v -> 0 < r v -> r u = T u.

(* T without r, and eta more on u. *)
Definition moved eta T r u v : R := T v - r v + eta * point R u v.

Lemma law_moved eta T r u : law T -> part_of eta T r -> law (moved eta T r u).
Proof.
move=> [T0 T1] [rT r1]; have e0 : 0 <= eta by rewrite -r1; apply: sumr_ge0 => v _; case/andP: (rT v).
split=> [v|]; first by rewrite addr_ge0 ?subr_ge0 ?mulr_ge0 //; [case/andP: (rT v)|case: (law_point R u)].
rewrite big_split /= sumrB T1 r1 -mulr_sumr (proj2 (law_point R u)).
by ring.
Qed.

Lemma tv_moved eta T r u : part_of eta T r -> tv (moved eta T r u) T <= eta.
Proof.
move=> [rT r1]; have e0 : 0 <= eta by rewrite -r1; apply: sumr_ge0 => v _; case/andP: (rT v).
rewrite -[leRHS]mulr1 -(proj2 (law_point R u)) mulr_sumr; apply: ler_sum => v _.
have p0 : 0 <= eta * point R u v by rewrite mulr_ge0 //; case: (law_point R u).
rewrite le_maxl p0 /= mul1r /moved ler_subl_addr (addrC _ (T v)) ler_add2r ler_subl_addl ler_addr.
by case/andP: (rT v).
Qed.

(* What the move changes. *)
Lemma expect_moved eta T r u c : part_of eta T r ->
  \sum_v moved eta T r u v * c v = \sum_v T v * c v + \sum_v r v * (c u - c v).
Proof.
move=> [_ r1]; have -> : \sum_v r v * (c u - c v) = eta * c u - \sum_v r v * c v.
  by under eq_bigr do rewrite mulrBr; rewrite sumrB -mulr_suml r1.
rewrite -[in eta * c u](expect_point c u) /expect mulr_sumr -sumrB -big_split; apply: eq_bigr => v _ /=.
by rewrite /moved; ring.
Qed.

(* A bound by one threshold theta, whatever it is: eta moves from theta or above to the greatest, what lies below theta is lifted to it. *)
Lemma near_bound eta theta top T D c : law T -> law D -> tv D T <= eta -> (forall u, c u <= top) -> theta <= top ->
  \sum_u D u * c u <= \sum_u T u * c u + eta * (top - theta) + \sum_u T u * Num.max 0 (theta - c u).
Proof.
move=> lT lD near ctop th.
have -> : \sum_u D u * c u = \sum_u T u * c u + \sum_u (D u - T u) * (c u - theta).
  under [X in _ + X]eq_bigr do rewrite mulrBr; rewrite sumrB -[X in _ + (_ - X)]mulr_suml sumrB (proj2 lD) (proj2 lT) subrr.
  rewrite mul0r subr0 -big_split; apply: eq_bigr => u _ /=; ring.
rewrite -addrA ler_add2l; apply: le_trans (ler_add (ler_wpmul2r _ near) (lexx _)); last by rewrite subr_ge0.
rewrite /tv /hockey_stick mulr_suml -big_split; apply: ler_sum => u _ /=; rewrite mul1r.
have D0 : 0 <= D u by case: lD.
have T0 : 0 <= T u by case: lT.
have cu : c u <= top := ctop u.
case: (leP 0 (D u - T u)) => s.
  apply: (@le_trans _ _ ((D u - T u) * (top - theta))); first by rewrite ler_wpmul2l // ler_add2r.
  by rewrite ler_addl mulr_ge0 // le_maxr lexx.
rewrite mul0r add0r; case: (leP 0 (theta - c u)) => h.
  rewrite -mulrNN !opprB; apply: ler_wpmul2r => //.
  by rewrite ler_subl_addl ler_addr.
by rewrite mulr0 nmulr_rle0 // subr_ge0 ltW // -subr_lt0.
Qed.

(* A threshold with which that bound is what is moved. *)
Lemma near_threshold eta T c r : from_least eta T c r -> exists2 theta, theta <= greatest u0 c &
  eta * (greatest u0 c - theta) + \sum_u T u * Num.max 0 (theta - c u) <= \sum_u r u * (greatest u0 c - c u).
Proof.
move=> [[rT r1] least]; set top := greatest u0 c.
case: (pickP (fun u => r u != T u)) => [u1 u1n|all]; last first.
  exists top => //; rewrite subrr mulr0 add0r; apply: ler_sum => u _.
  by have /negbFE/eqP-> := all u; rewrite (max_idPr _) // subr_ge0 greatest_ge.
have [w wn wmin] := @arg_minP _ _ _ u1 (fun u => r u != T u) c u1n.
exists (c w); first exact: greatest_ge.
rewrite -r1 mulr_suml -big_split; apply: ler_sum => u _ /=; case/andP: (rT u) => ru0 ruT.
rewrite (_ : r u * (top - c u) = r u * (top - c w) + r u * (c w - c u)); last by ring.
rewrite ler_add2l; case: (ltrgtP (c u) (c w)) => h.
- have -> : r u = T u by apply/eqP/negbNE/negP => /wmin; rewrite leNgt h.
  by rewrite (max_idPr _) // subr_ge0 ltW.
- have -> : r u = 0.
    apply/eqP; move: ru0; rewrite le_eqVlt eq_sym => /orP[//|pos].
    by move: wn; rewrite (least _ _ h pos) eqxx.
  by rewrite (max_idPl _) ?mulr0 ?mul0r // subr_le0 ltW.
by rewrite h subrr maxxx !mulr0.
Qed.

(* No law within eta gains more than eta taken from the least and put on the greatest. *)
Theorem T13_near_law eta T c r D : law T -> from_least eta T c r -> law D -> tv D T <= eta ->
  \sum_u D u * c u <= \sum_u T u * c u + \sum_u r u * (greatest u0 c - c u).
Proof.
move=> lT fl lD near; have [theta th le] := near_threshold fl.
apply: le_trans (near_bound lT lD near (greatest_ge u0 c) th) _.
by rewrite -addrA ler_add2l.
Qed.

(* Such an r exists for every eta of T's mass: take decisions in rising order of c. *)
Fixpoint take_in_order (eta : R) T (s : seq U) : U -> R :=
  if s is v :: s' then
    let first := Num.min (T v) eta in fun u => if u == v then first else take_in_order (eta - first) T s' u
  else fun=> 0.

Lemma take_part eta T s u : (forall v, 0 <= T v) -> 0 <= eta -> 0 <= take_in_order eta T s u <= T u.
Proof.
move=> T0; elim: s eta => [|v s IH] eta e0 /=; first by rewrite lexx T0.
case: eqP => [->|_]; first by rewrite le_minr T0 e0 le_minl lexx.
by apply: IH; rewrite subr_ge0 le_minl lexx orbT.
Qed.

Lemma take_outside eta T s u : u \notin s -> take_in_order eta T s u = 0.
Proof.
elim: s eta => //= v s IH eta; rewrite inE negb_or => /andP[/negbTE-> us].
exact: IH.
Qed.

Lemma take_sum eta T s : uniq s -> (forall v, 0 <= T v) -> 0 <= eta ->
  \sum_(u <- s) take_in_order eta T s u = Num.min (\sum_(u <- s) T u) eta.
Proof.
move=> us T0; elim: s us eta => [|v s IH] /= us eta e0; first by rewrite !big_nil (min_idPl e0).
case/andP: us => vs us; rewrite !big_cons eqxx; set first := Num.min _ _.
have first_le : first <= eta by rewrite le_minl lexx orbT.
rewrite (eq_big_seq (take_in_order (eta - first) T s)) => [|u us' /=]; last first.
  by case: eqP => // e; rewrite -e us' in vs.
rewrite IH ?subr_ge0 // addr_minr (addrC first (eta - first)) subrK /first.
have S0 : 0 <= \sum_(u <- s) T u by apply: sumr_ge0.
case: (leP (T v) eta) => // h; rewrite (min_idPr _) ?ler_addl // (min_idPr _) //.
by apply: le_trans (ltW h) _; rewrite ler_addl.
Qed.

Lemma take_least eta T c s : (forall v, 0 <= T v) -> 0 <= eta -> uniq s -> sorted (relpre c <=%R) s ->
  forall u v, u \in s -> v \in s -> c u < c v -> 0 < take_in_order eta T s v -> take_in_order eta T s u = T u.
Proof.
move=> T0; elim: s eta => [//|w s IH] eta e0 /= /andP[ws us] so u v; rewrite !inE.
have le_w x : x \in s -> c w <= c x.
  have tr : transitive (relpre c <=%R) by move=> a b d /=; apply: le_trans.
  by move: so; rewrite (path_sortedE tr) => /andP[/allP h _] /h.
have so' : sorted (relpre c <=%R) s := path_sorted so.
have zero x : take_in_order 0 T s x = 0.
  elim: {IH ws us so le_w so'} s => //= a s IHs; rewrite (min_idPr (T0 a)) subrr.
  by case: eqP.
case: (eqVneq u w) => [->|uw] /= ui; case: (eqVneq v w) => [->|vw] /= vi; rewrite ?ltxx //.
- move=> lt; case: (leP (T w) eta) => // h; rewrite subrr zero ltxx //.
- by move=> lt; have := le_w u ui; rewrite leNgt lt.
by apply: IH => //; rewrite subr_ge0 le_minl lexx orbT.
Qed.

Definition rising c : seq U := sort (relpre c <=%R) (enum U).
Definition from_worst eta T c : U -> R := take_in_order eta T (rising c).

Lemma from_worst_least eta T c : law T -> 0 <= eta <= 1 -> from_least eta T c (from_worst eta T c).
Proof.
move=> [T0 T1] /andP[e0 e1]; have us : uniq (rising c) by rewrite sort_uniq enum_uniq.
have ins u : u \in rising c by rewrite mem_sort mem_enum.
have sumE (F : U -> R) : \sum_u F u = \sum_(u <- rising c) F u.
  by rewrite -big_enum; apply/esym/perm_big; rewrite perm_sort.
have so : sorted (relpre c <=%R) (rising c) by apply: sort_sorted => a b; apply: le_total.
split; last by move=> u v; apply: take_least.
split=> [u|]; first exact: take_part.
by rewrite sumE take_sum // -sumE T1 (min_idPr e1).
Qed.

Theorem T13_near_exists eta T c : law T -> 0 <= eta <= 1 -> exists r, from_least eta T c r.
Proof. by move=> lT e01; exists (from_worst eta T c); apply: from_worst_least. Qed.

End OneLaw.

(* ---- Policies ---- *)

Section Near.
Variables (R : realFieldType) (O U : finType) (u0 : U).
Implicit Types (T r p q c : O -> U -> R) (d : O -> U) (V eta : R).

(* T' is within eta of T for everything that is shown. *)
Definition near eta T T' : Prop := forall o, tv (T' o) (T o) <= eta.

(* What moving r to the greatest c makes of the value of T. *)
Definition moved_value T r c : R := value T c + \sum_o \sum_u r o u * (greatest u0 (c o) - c o u).

(* The policy that moves r(o) to d(o). *)
Definition moved_policy eta T r d : O -> U -> R := fun o => moved eta (T o) (r o) (d o).

Lemma kernel_moved eta T r d : kernel T -> (forall o, part_of eta (T o) (r o)) -> kernel (moved_policy eta T r d).
Proof. by move=> kT pr o; apply: law_moved. Qed.

Lemma near_moved eta T r d : (forall o, part_of eta (T o) (r o)) -> near eta T (moved_policy eta T r d).
Proof. by move=> pr o; apply: tv_moved. Qed.

Lemma value_moved eta T r c d : (forall o, part_of eta (T o) (r o)) -> (forall o, c o (d o) = greatest u0 (c o)) ->
  value (moved_policy eta T r d) c = moved_value T r c.
Proof. by move=> pr dmax; rewrite /moved_value -big_split; apply: eq_bigr => o _; rewrite expect_moved // dmax. Qed.

Lemma near_le eta T T' r c : kernel T -> kernel T' -> near eta T T' -> (forall o, from_least eta (T o) (c o) (r o)) ->
  value T' c <= moved_value T r c.
Proof.
move=> kT kT' ne fl; rewrite /moved_value -big_split; apply: ler_sum => o _.
exact: T13_near_law.
Qed.

(* The greatest value near a policy, and that it is attained. *)
Theorem T13_near_value eta T r c d : kernel T -> (forall o, from_least eta (T o) (c o) (r o)) ->
  (forall o, c o (d o) = greatest u0 (c o)) ->
  [/\ forall T', kernel T' -> near eta T T' -> value T' c <= moved_value T r c,
      kernel (moved_policy eta T r d), near eta T (moved_policy eta T r d) & value (moved_policy eta T r d) c = moved_value T r c].
Proof.
move=> kT fl dmax; have pr o : part_of eta (T o) (r o) by case: (fl o).
by split=> [T' kT' ne|||]; [apply: near_le ne fl|apply: kernel_moved|apply: near_moved|apply: value_moved].
Qed.

(* Near T every ratio is at most V exactly if the greatest value of p - V q there is at most 0. *)
Theorem T13_near eta T r p q V : kernel T -> (forall o, from_least eta (T o) (gain p q V o) (r o)) ->
  (forall T', kernel T' -> near eta T T' -> value T' p <= V * value T' q) <-> moved_value T r (gain p q V) <= 0.
Proof.
move=> kT fl; pose d o := best u0 (gain p q V o).
have [all kT' ne e] := T13_near_value kT fl (fun o => erefl : gain p q V o (d o) = greatest u0 (gain p q V o)).
split=> [h|h T2 k2 n2]; first by rewrite -e value_gain subr_le0; apply: h.
by rewrite -subr_le0 -value_gain; apply: le_trans h; apply: all.
Qed.

(* The two ends: eta = 0 is the policy itself, eta = 1 is every policy. *)
Theorem T13_near_0 T r c : (forall o, from_least 0 (T o) (c o) (r o)) -> moved_value T r c = value T c.
Proof.
move=> fl; rewrite /moved_value big1 ?addr0 // => o _; rewrite big1 // => u _.
case: (fl o) => -[rT r1] _; have r0 v : 0 <= r o v by case/andP: (rT v).
by rewrite (psumr_eq0P (fun v _ => r0 v) r1) // mul0r.
Qed.

Theorem T13_near_1 T r p q V : kernel T -> (forall o, from_least 1 (T o) (gain p q V o) (r o)) ->
  moved_value T r (gain p q V) = surplus u0 p q V.
Proof.
move=> kT fl; rewrite /moved_value -big_split; apply: eq_bigr => o _ /=.
case: (fl o) => -[rT r1] _; have e u : r o u = T o u.
  apply/esym/eqP; rewrite -subr_eq0; apply/eqP; move: u isT; apply: psumr_eq0P => [u _|].
    by rewrite subr_ge0; case/andP: (rT u).
  by rewrite sumrB r1 (proj2 (kT o)) subrr.
rewrite -[RHS](expect_cst _ (kT o)) -big_split; apply: eq_bigr => u _ /=.
by rewrite e; ring.
Qed.

End Near.

(* ---- Policies behind filters ---- *)

Section Behind.
Variables (R : realFieldType) (X Xt A At U : finType) (u0 : U).
Variables (MX : X -> Xt -> R) (MA : A -> At -> R) (g : U -> X -> A -> R) (W : A -> X -> R) (T : Xt -> At -> U -> R) (eta : R).
Hypotheses (kX : kernel MX) (kA : kernel MA) (g0 : forall u x a, 0 <= g u x a) (W0 : forall a x, 0 <= W a x) (kT : policy T).
Implicit Types (V : R) (r : Xt * At -> U -> R).
Local Notation E T := (utility (induced MX MA T) g).
Local Notation M T := (group_mean W (E T)).
Local Notation cell := (cell_part MX MA g).
Local Notation mean := (global_part MX MA g W).

Definition near_policy T' : Prop := forall y b, tv (T' y b) (T y b) <= eta.

Lemma near_joint T' : near_policy T' -> near eta (joint T) (joint T').
Proof. by move=> n o; apply: n. Qed.

Lemma near_behind p q r V (num den : (Xt -> At -> U -> R) -> R) :
  (forall T', num T' = value (joint T') p) -> (forall T', den T' = value (joint T') q) ->
  (forall o, from_least eta (joint T o) (gain p q V o) (r o)) ->
  (forall T', policy T' -> near_policy T' -> num T' <= V * den T') <-> moved_value u0 (joint T) r (gain p q V) <= 0.
Proof.
move=> en ed fl; split=> [all|h T' kT' ne]; last first.
  by rewrite en ed; apply: (proj2 (T13_near u0 (kernel_joint kT) fl) h); [apply: kernel_joint|apply: near_joint].
apply: (proj1 (T13_near u0 (kernel_joint kT) fl)) => T' kT' ne.
have e c : value T' c = value (joint (fun y b => T' (y, b))) c by apply: eq_value => -[y b] u.
rewrite !e -en -ed; apply: all => [y b|y b]; first exact: kT'.
exact: (ne (y, b)).
Qed.

(* T13 near this policy: expected utilities in a context, and group means. *)
Theorem T13_near_local V r x a a' : (forall o, from_least eta (joint T o) (gain (cell x a) (cell x a') V o) (r o)) ->
  (forall T', policy T' -> near_policy T' -> E T' x a <= V * E T' x a') <->
  moved_value u0 (joint T) r (gain (cell x a) (cell x a') V) <= 0.
Proof. by apply: near_behind => T'; apply: cell_value. Qed.

Theorem T13_near_global V r a a' : (forall o, from_least eta (joint T o) (gain (mean a) (mean a') V o) (r o)) ->
  (forall T', policy T' -> near_policy T' -> M T' a <= V * M T' a') <->
  moved_value u0 (joint T) r (gain (mean a) (mean a') V) <= 0.
Proof. by apply: near_behind => T'; apply: mean_value. Qed.

(* The claim "the greatest ratio near this policy is V": a policy near this one has it. *)
Theorem T13_near_attained T' V x a a' : policy T' -> near_policy T' -> 0 < E T' x a' -> E T' x a = V * E T' x a' ->
  forall V', (forall T', policy T' -> near_policy T' -> local_le V' (E T')) -> V <= V'.
Proof.
move=> kT' ne pos e V' all; pose class T := policy T /\ near_policy T.
apply: (@T13_attained _ _ class (fun T => E T x a) (fun T => E T x a') T') => // T2 [k2 n2].
exact: all.
Qed.

Theorem T13_near_attained_global T' V a a' : policy T' -> near_policy T' -> 0 < M T' a' -> M T' a = V * M T' a' ->
  forall V', (forall T', policy T' -> near_policy T' -> global_le V' (M T')) -> V <= V'.
Proof.
move=> kT' ne pos e V' all; pose class T := policy T /\ near_policy T.
apply: (@T13_attained _ _ class (fun T => M T a) (fun T => M T a') T') => // T2 [k2 n2].
exact: all.
Qed.

End Behind.
