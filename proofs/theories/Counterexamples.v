(* Statements that are false as the source paper or a careless reader has them, each with a counterexample over the
   rationals.  Numbers refer to the sections of docs/corrections.md.  Elsewhere: section 4 is T6_group_dependent,
   section 5 T5_counterexample, section 11 T7_sharp, sections 13 and 14 trap_shared_randomness and trap_one_order, the example for
   the global figure T8_global_counterexample.

   [forall r, ~ local_le r E] says that the ratio is infinite: no finite r bounds it. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T1 T10 Ratios.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* Sums over small alphabets, written out. *)
Lemma big_pairs (R : realFieldType) (f : bool * bool -> R) :
  \sum_v f v = f (true, true) + f (true, false) + (f (false, true) + f (false, false)).
Proof.
transitivity (\sum_v \sum_w f (v, w)); last by rewrite !big_bool.
by rewrite pair_bigA; apply: eq_bigr; case.
Qed.

Lemma big_three (R : realFieldType) (f : 'I_3 -> R) : \sum_i f i = f 0 + f 1 + f (1 + 1).
Proof. by rewrite !big_ord_recl big_ord0 addr0 addrA; congr (_ + _ + _); congr f; apply: val_inj. Qed.

(* Closed statements over the rationals are decided by computation. *)
Ltac decided := vm_compute; reflexivity.
Ltac computed := solve [decided | apply/eqP; decided | split; [apply/eqP; decided | decided]].
Ltac tables := rewrite /utility /expect /induced /group_mean /identity ?big_bool ?big_unit ?big_pairs ?big_bool; computed.

(* The coin that keeps the truth with probability p. *)
Definition coin (p : rat) (a b : bool) : rat := if a == b then p else 1 - p.
Definition nothing (a b : bool) : rat := 2%:R^-1.     (* releases a fair coin, eps = 0 *)
Definition as_it_is : bool -> bool -> rat := @identity _ [finType of bool].

Lemma kernel_coin p : 0 <= p <= 1 -> kernel (coin p).
Proof.
move=> /andP[p0 p1]; case; split=> [[]|]; rewrite /coin ?big_bool /= ?subr_ge0 //.
  by rewrite addrC subrK.
by rewrite subrK.
Qed.

Definition keep : rat := 7%:R / 10%:R.

Lemma kernel_keep : kernel (coin keep).
Proof. by apply: kernel_coin; computed. Qed.

Lemma kernel_nothing : kernel nothing.
Proof. by move=> a; split=> [b|] //; rewrite big_bool. Qed.

(* Policies that decide without chance. *)
Lemma policy_decides (Xt At : finType) (f : Xt -> At -> bool) : policy (fun y b u => (u == f y b)%:R : rat).
Proof. by move=> y b; apply: law_point. Qed.

Lemma nothing_private : every_pair (pure_dp 1) nothing.
Proof. by move=> a a' b; rewrite mul1r. Qed.

(* ---- 1. eps is not p/(1 - p) ---- *)

(* p/(1 - p) is e^eps: it is the least factor (7/3 for p = 7/10, and 1 for p = 1/2, that is eps = 0 and not 1) ... *)
Theorem epsilon_counterexample (p k : rat) : 2%:R^-1 <= p < 1 -> every_pair (pure_dp k) (coin p) <-> p / (1 - p) <= k.
Proof.
move=> /andP[p_half p1]; have q0 : 0 < 1 - p by rewrite subr_gt0.
have p0 : 0 < p by apply: lt_le_trans p_half; rewrite invr_gt0 ltr0n.
have qp : 1 - p <= p by rewrite ler_subl_addr; apply: le_trans (ler_add p_half p_half).
split=> [/(_ true false true)|k_ge]; first by rewrite ler_pdivr_mulr.
have pq : p <= k * (1 - p) by rewrite -ler_pdivr_mulr.
have k1 : 1 <= k by rewrite -(ler_pmul2r q0) mul1r (le_trans qp).
have pp : p <= k * p by rewrite ler_pemull // ltW.
have qq : 1 - p <= k * (1 - p) by rewrite ler_pemull // ltW.
by move=> a a' b; rewrite /coin; case: (a == b); case: (a' == b) => //; apply: le_trans pp.
Qed.

(* ... and for three values it is not even that: the odds 7/3 are too small, the ratio of truth to one lie is 14/3. *)
Definition document (a b : 'I_3) : rat := if a == b then keep else 3%:R / 20%:R.

Theorem epsilon_three_counterexample :
  ~ every_pair (pure_dp (keep / (1 - keep))) document /\ every_pair (pure_dp (14%:R / 3%:R)) document.
Proof.
split; last by move=> a a' b; rewrite /document; case: (a == b); case: (a' == b); computed.
by move=> h; have := h 0 1 0; apply/negP; computed.
Qed.

(* ---- 2. One attribute's eps for a tuple of six ---- *)

Local Definition six := both (coin keep) (both (coin keep) (both (coin keep) (both (coin keep) (both (coin keep) (coin keep))))).
Local Definition all_of (b : bool) := (b, (b, (b, (b, (b, b))))).

(* The policy that waits for the one release in which all six values are true has R = (7/3)^6. *)
Theorem tuple_counterexample :
  let E := utility (induced (@no_context _ unit_finType) six (grant (point _ (all_of true)))) (granted 0 1) tt in
  policy (grant (point rat_realFieldType (all_of true))) /\
  E (all_of true) = (7%:R / 3%:R) ^+ 6 * E (all_of false) /\ 0 < E (all_of false).
Proof.
have k6 : kernel six by do 5!(apply: kernel_both; first exact: kernel_keep); exact: kernel_keep.
have one : coin keep true true = 7%:R / 3%:R * coin keep false true by computed.
have lie : 0 < coin keep false true by computed.
have ratio : six (all_of true) (all_of true) = (7%:R / 3%:R) ^+ 6 * six (all_of false) (all_of true).
  rewrite /six /both /= one; move: (7%:R / 3%:R) (coin keep false true) => r c; ring.
have [pol same low] := T2_sharp 1 tt k6 ratio; split; [exact: pol|split; first exact: same].
rewrite low mul1r /six /both /=.
by do 5!(apply: (mulr_gt0 lie)).
Qed.

(* ---- 3. g = 1{choose a} depends on a ---- *)

(* A policy that always takes the same slot, behind a filter that releases nothing: eps = 0 and R is infinite. *)
Local Definition always (y b u : bool) : rat := (u == true)%:R.
Local Definition chosen (u x a : bool) : rat := (u == a)%:R.

Theorem fixed_slots_counterexample :
  [/\ policy always, every_pair (pure_dp 1) nothing &
      forall r, ~ local_le r (utility (induced nothing nothing always) chosen)].
Proof.
split; first exact: policy_decides.
  exact: nothing_private.
by move=> r /(_ true true false); rewrite (_ : utility _ _ true false = 0) ?mulr0; tables.
Qed.

(* One eps is not enough in random order either: the policy that takes whoever alone is shown as true, and nobody if
   both or none are, separates two persons by exactly e^(2 eps). *)
Local Definition alone (v : bool * bool) (u : option bool) : rat :=
  (u == if v.1 == v.2 then None else Some v.1)%:R.

Theorem one_profile_counterexample :
  let C := candidate_utility (coin keep) alone (fun u s => (u == Some s)%:R) in
  kernel alone /\ every_pair (pure_dp (7%:R / 3%:R)) (coin keep) /\
  C true false = (7%:R / 3%:R) ^+ 2 * C false true /\ 0 < C false true.
Proof.
have opt (f : option bool -> rat) : \sum_u f u = f None + (f (Some true) + f (Some false)).
  by rewrite (bigD1 None) //= (bigD1 (Some true)) //= (bigD1 (Some false)) //= big1 ?addr0 // => -[[]|].
move=> C; split; first by move=> v; apply: law_point.
split; first by do 3!case; computed.
by rewrite /C /candidate_utility /expect !big_pairs !opt; computed.
Qed.

(* A cyclic rotation in place of a uniform order is not enough: three persons with three different profiles, the
   slots turned by r = 0, 1, 2 with equal probability, and the policy that takes slot 0 when the persons seem to
   stand in their original order.  eps = log 2, and the chances differ by a factor of 2^3. *)
Local Definition mask (a b : 'I_3) : rat := if a == b then 2%:R^-1 else 4%:R^-1.
Definition rotation_view (r : 'I_3) (v : {ffun 'I_3 -> 'I_3}) : rat := \prod_s mask (s - r) (v s).
Definition rotation_chance (i : 'I_3) : rat :=
  3%:R^-1 * \sum_r \sum_v rotation_view r v * ((v == [ffun s => s]) && (i + r == 0))%:R.

Theorem rotation_counterexample :
  [/\ kernel mask, every_pair (pure_dp 2%:R) mask,
      rotation_chance 0 = 2%:R ^+ 3 * rotation_chance 1 & 0 < rotation_chance 1].
Proof.
have value i : rotation_chance i = 3%:R^-1 * \prod_s mask (s + i) s.
  congr (_ * _); rewrite (bigD1 (- i)) //= [X in _ + X]big1 ?addr0; last first.
    move=> r r_neq; apply: big1 => v _; rewrite addrC addr_eq0 (negbTE r_neq) andbF mulr0 //.
  rewrite (bigD1 [ffun s => s]) //= big1 ?addr0; last by move=> v /negbTE->; rewrite mulr0.
  rewrite eqxx addrN eqxx mulr1; apply: eq_bigr => s _; by rewrite ffunE opprK.
have three (f : 'I_3 -> rat) : \prod_s f s = f 0 * f 1 * f (1 + 1).
  by rewrite !big_ord_recl big_ord0 mulr1 mulrA; congr (_ * _ * _); congr f; apply: val_inj.
split.
- move=> a; split=> [b|]; first by rewrite /mask; case: ifP.
  by rewrite big_three; case: a => [[|[|[|]]] //] lt; computed.
- by move=> a a' b; rewrite /mask; case: (a == b); case: (a' == b); computed.
- by rewrite !value !three; computed.
- by rewrite value three; computed.
Qed.

(* ---- 6. Equality after filtering X can hold ---- *)

(* Half the chance for one group in either context: R = 2 before and behind a filter that releases every context
   with positive probability. *)
Local Definition twice (y b u : bool) : rat :=
  let p : rat := (if y then 2%:R else 1) * (if b then 2%:R else 1) / 5%:R in if u then p else 1 - p.
Local Definition yes (u x a : bool) : rat := u%:R.

Theorem equality_counterexample :
  let E := utility (induced (coin keep) as_it_is twice) yes in
  let E0 := utility (induced as_it_is as_it_is twice) yes in
  policy twice /\
  [/\ forall x y, 0 < coin keep x y, local_le 2%:R E0, forall x, E0 x true = 2%:R * E0 x false &
      forall x, E x true = 2%:R * E x false /\ 0 < E x false].
Proof.
move=> E E0; split; first by do 2!case; split=> [[]|]; rewrite ?big_bool; computed.
split; first by do 2!case; computed.
- by do 3!case; rewrite /E0; tables.
- by case; rewrite /E0; tables.
- by case; rewrite /E; tables.
Qed.

(* ---- 7. Waiting time depends on who one is ---- *)

(* The same order of delivery for everybody, behind a filter that releases nothing: 30 minutes against 10. *)
Local Definition wait (u x a : bool) : rat := if u == a then 10%:R else 30%:R.

Theorem waiting_time_counterexample :
  let E := utility (induced nothing nothing always) wait in
  policy always /\ every_pair (pure_dp 1) nothing /\ forall x, E x false = 3%:R * E x true /\ 0 < E x true.
Proof.
move=> E; split; first exact: policy_decides.
split; [apply: nothing_private|case; rewrite /E; tables].
Qed.

(* ---- 8. L_A belongs to g ---- *)

(* Policy and filter ignore the group, and L_A = 1; g ignores the group (L_A = 0), and R is infinite. *)
Local Definition by_group (y b u : bool) : rat := (u == b)%:R.

Theorem lipschitz_counterexample :
  policy always /\ policy by_group /\
  (forall x a a' u, induced nothing nothing always x a u = induced nothing nothing always x a' u) /\
  chosen true true true - chosen true true false = 1 /\
  a_free yes /\ forall r, ~ local_le r (utility (induced as_it_is as_it_is by_group) yes).
Proof.
do 2!(split; first exact: policy_decides).
split=> [x a a' u|]; first by [].
split; first by computed.
split=> // r /(_ true true false).
by rewrite (_ : utility _ _ true false = 0) ?mulr0; [apply/negP|]; tables.
Qed.

(* ---- 9. A floor cannot be had by rescaling ---- *)

(* A factor c leaves the share tau/gamma of every cell as it is, and a cell that has 0 keeps 0. *)
Theorem rescaling_counterexample (R : realFieldType) (X A U : finType) (P : X -> A -> U -> R)
    (g : U -> X -> A -> R) (c gamma : R) x a : c != 0 ->
  let scaled := utility P (fun u x a => c * g u x a) x a in
  scaled / (c * gamma) = utility P g x a / gamma /\ (utility P g x a = 0 -> scaled = 0).
Proof.
move=> c0 scaled; have -> : scaled = c * utility P g x a by apply: expectZ.
by split=> [|->]; rewrite ?mulr0 // -mulf_div divff // mul1r.
Qed.

(* Truncation from below makes a floor and another question: R = 9 becomes 19/11. *)
Local Definition rows (x a u : bool) : rat := coin (9%:R / 10%:R) a u.
Local Definition lifted (u x a : bool) : rat := if u then 1 else 2%:R^-1.

Theorem truncation_counterexample x :
  utility rows yes x true = 9%:R * utility rows yes x false /\
  utility rows lifted x true = 19%:R / 11%:R * utility rows lifted x false /\ 0 < utility rows yes x false.
Proof. by do 2?[split]; case: x; tables. Qed.

(* ---- 10. A smaller eps does not always lower the metric ---- *)

(* g depends on a: the policy opens the door that fits, only one group needs the ramp.  eps = infinity, log 3, 0. *)
Local Definition serves (u x a : bool) : rat := (u || ~~ a)%:R.

Theorem degradation_group_dependent_counterexample :
  let E veil := utility (induced as_it_is veil by_group) serves in
  policy by_group /\
  [/\ local_le 1 (E as_it_is), forall x, E (coin (3%:R / 4%:R)) x false = 4%:R / 3%:R * E (coin (3%:R / 4%:R)) x true &
      forall x, E nothing x false = 2%:R * E nothing x true].
Proof.
move=> E; split; first exact: policy_decides.
split; first by do 3!case; rewrite /E; tables.
  by case; rewrite /E; tables.
by case; rewrite /E; tables.
Qed.

(* The global figure, X and A dependent: a policy that leans the other way within each context balances the whole;
   without the group only the composition remains.  R-bar = 1 at eps = infinity, 3/2 at eps = 0. *)
Local Definition spread (a x : bool) : rat := (if a == x then 3%:R else 1) / 4%:R.
Local Definition leaning (y b u : bool) : rat :=
  let p : rat := if y then (if b then 3%:R / 4%:R else 1) else (if b then 4%:R^-1 else 2%:R^-1) in if u then p else 1 - p.

Theorem degradation_global_counterexample :
  let E veil := group_mean spread (utility (induced as_it_is veil leaning) yes) in
  [/\ policy leaning, global_le 1 (E as_it_is), E nothing true = 3%:R / 2%:R * E nothing false & 0 < E nothing false].
Proof.
move=> E; split; rewrite /E.
- by do 2!case; split=> [[]|] //; rewrite big_bool.
- by do 2!case; tables.
- by tables.
- by tables.
Qed.

(* Groups that are in the alphabet but not compared: a = (sex, age), old women and young men are there, sex alone is
   hidden.  The ratio goes from 1 over 5/3 to 3 as the filter hides more. *)
Local Definition approve (y : unit) (b : bool * bool) (u : bool) : rat :=
  let p : rat := if b.1 == b.2 then 2%:R^-1 else if b.2 then 0 else 1 in if u then p else 1 - p.

Theorem degradation_absent_group_counterexample :
  let E p := utility (induced (@no_context _ unit_finType) (both (coin p) as_it_is) approve) (fun u _ _ => u%:R) tt in
  policy approve /\
  [/\ E 1 (true, true) = E 1 (false, false),
      E (3%:R / 4%:R) (false, false) = 5%:R / 3%:R * E (3%:R / 4%:R) (true, true) &
      E (2%:R^-1) (false, false) = 3%:R * E (2%:R^-1) (true, true) /\ 0 < E (2%:R^-1) (true, true)].
Proof.
move=> E; split; first by case; case; do 2!case; split=> [[]|]; rewrite ?big_bool; computed.
rewrite /E; split; [| |split]; tables.
Qed.

(* ---- Traps of the theory page ---- *)

(* T4 at s0 alone is no bound: g has the values 1 and 11, tau = m = 1, so s0 = 0 where the form has the value 1. *)
Local Definition price (u x a : bool) : rat := if u then 11%:R else 1.

Theorem T4_at_s0_counterexample :
  let E := utility (induced nothing (coin (3%:R / 4%:R)) by_group) price in
  policy by_group /\ has_floor 1 E /\ forall x, E x true = 17%:R / 7%:R * E x false.
Proof.
move=> E; split; first exact: policy_decides.
split; first by do 2!case; rewrite /E; tables.
by case; rewrite /E; tables.
Qed.

(* T7 from a single utility: R = 1 for one g bounds no distance. *)
Theorem one_utility_counterexample :
  let P (x a u : bool) : rat := (u == a)%:R in
  (forall x, kernel (P x)) /\ local_le 1 (utility P (fun _ _ _ => 1)) /\ tv (P true true) (P true false) = 1.
Proof.
move=> P; split; first by move=> x a; apply: law_point.
split; first by do 3!case; tables.
by rewrite /tv /hockey_stick big_bool; computed.
Qed.

(* T8 for g(u,x): R goes from 1 to 2.  In one context every decision is worth 1, in the other only yes is. *)
Local Definition useful (u x a : bool) : rat := (u || ~~ x)%:R.
Local Definition harmless (y b u : bool) : rat := (u == (y || b))%:R.

Theorem context_utility_counterexample :
  let E veil := utility (induced veil as_it_is harmless) useful in
  policy harmless /\
  [/\ a_free useful, local_le 1 (E as_it_is), E nothing true true = 2%:R * E nothing true false & 0 < E nothing true false].
Proof.
move=> E; split; first exact: policy_decides.
split; rewrite /E.
- by [].
- by do 3!case; tables.
- by tables.
- by tables.
Qed.

(* T8 where a released context compares nobody: the groups of the context true have nothing before the filter (0/0,
   parity); behind it one of them has something and R is infinite. *)
Local Definition elsewhere (y b u : bool) : rat := (u == ~~ y && b)%:R.

Theorem uncompared_context_counterexample :
  let E veil := utility (induced veil as_it_is elsewhere) yes in
  policy elsewhere /\
  (forall a a', E as_it_is true a <= 1 * E as_it_is true a') /\
  E nothing true false = 0 /\ 0 < E nothing true true.
Proof.
move=> E; split; first exact: policy_decides.
split; first by do 2!case; rewrite /E; tables.
by rewrite /E; tables.
Qed.
