(* What PolicyClaims.v accepts with multipliers k for the pairs of groups, and of the means of groups, is true; and so is all that it
   accepts by one theorem. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions DP Ratios T1 T3 T4 T5 T13 Rules.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound PolicyLaw Likelihoods LikelihoodsSound PolicyClaims PolicyFacts PolicyBounds.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Bounds.
Variables (R : realFieldType) (S : behind).
Hypotheses (ok : valid S) (cons : consistent S).
Local Notation MX := (@MX R S).
Local Notation MA := (@MA R S).
Local Notation T0 := (@T0 R S).
Local Notation g := (@g R S).
Local Notation A := (A S).
Local Notation X := (X S).
Local Notation kX := (kernel_MX R ok).
Local Notation kA := (kernel_MA R ok).
Local Notation g0 := (@g_ge0 R S ok).
Local Notation gam := (ratio (gamma_used S) : R).
Local Notation L := (ratio (L_used S) : R).

Lemma nonnegative_gt q : nonnegative q = false -> ratio q <= 0 :> R.
Proof.
rewrite /nonnegative => /Z.leb_gt/Z.lt_le_incl/Z.leb_le/(@embed_le0 R) h.
by rewrite /ratio pmulr_lle0 // invr_gt0 embed_pos.
Qed.

Lemma multiplied_boundP add weight shed t u k s : positive_fraction t ->
  ratio (multiplied_bound add weight shed t u k s) =
  ratio k + Num.max 0 (ratio add + ratio weight * ratio (hockey u k s) - (ratio k - 1) * ratio shed) / ratio t :> R.
Proof.
move=> t0; rewrite /multiplied_bound; set e := difference _ _.
have <- : ratio e = ratio add + ratio weight * ratio (hockey u k s) - (ratio k - 1) * ratio shed :> R.
  by rewrite ratio_difference ratio_plus !ratio_times ratio_difference ratio_one.
case n: (nonnegative e); last by rewrite (max_idPl (nonnegative_gt n)) mul0r addr0.
by rewrite ratio_plus ratio_times ratio_inverse // (max_idPr (ratio_ge0 R n)).
Qed.

(* From a bound by one k for every pair to a claim: H a a' k is what stands for the pair. *)
Lemma multipliers_sound (class : (X -> A -> R) -> Prop) (V : option Q) add weight shed t ks u pairs (H : A -> A -> Q -> R) :
  positive_fraction t -> multipliers_prove V add weight shed t ks u pairs ->
  (forall a a', a != a' -> exists2 s, In s pairs & forall k, nonnegative k -> H a a' k = ratio (hockey u k s)) ->
  (forall E, class E -> forall x a a' k, a != a' -> nonnegative k -> 0 <= E x a' /\
    E x a <= (ratio k + Num.max 0 (ratio add + ratio weight * H a a' k - (ratio k - 1) * ratio shed) / ratio t) * E x a') ->
  greatest_at_most false class V.
Proof.
case: V => [v|] //= t0 /forallb_forall proofs stand bound E inE x a a' aa.
have [s sin sE] := stand a a' aa; have /existsb_exists[k [_ /andP[k0 le]]] := proofs s sin.
have [E0 h] := bound E inE x a a' k aa k0; apply: le_trans h _; apply: ler_wpmul2r => //.
by rewrite sE // -multiplied_boundP //; apply: at_mostP.
Qed.

Local Notation H a a' k := (hockey_stick (ratio k) (MA a) (MA a')).

Lemma of_filterP (a a' : A) : a != a' -> exists2 s, In s (of_filter S).2 & forall k, nonnegative k -> H a a' k = ratio (hockey (of_filter S).1 k s).
Proof.
move=> aa; have [s sin sS] := kindsP (group_filter_ok R ok) (ltn_ord a) (ltn_ord a') aa.
exists s => // k _; rewrite (hockeyP k _ sS) //; elim: (group_filter S) => // F fs IH.
by rewrite [units _]/(Z.mul (unit_of F) (units fs)); apply: Z.mul_pos_pos => //; apply: common_gt0.
Qed.

Lemma with_floorQ s f : with_floor S s f -> exists t, [/\ floor_in S s = Some t, positive_fraction t & f t].
Proof. by rewrite /with_floor; case: (floor_in S s) => // t /andP[t0 ft]; exists t. Qed.

Lemma hockey_M t E (B : finType) (M : A -> B -> R) (T : Xt S -> B -> U S -> R) k a a' : floored_law t E M T ->
  hockey_stick k (M a) (M a') = hockey_stick k (MA a) (MA a').
Proof. by move=> F; rewrite /hockey_stick (sums F a a' (fun p q => Num.max 0 (p - k * q))). Qed.

Lemma max_of_ge0 (x k : R) : 0 <= x -> Num.max 0 (x - (k - 1) * ratio zero) = x.
Proof. by move=> x0; rewrite ratio_zero mulr0 subr0 (max_idPr x0). Qed.

Theorem T1_sound s V means ks : in_scope S s ->
  with_floor S s (fun t => multipliers_prove V (L_used S) (gamma_used S) zero t ks (of_filter S).1 (of_filter S).2) ->
  greatest_at_most false (class_of (R := R) (S := S) means s) V.
Proof.
move=> sc /with_floorQ[t [st t0 proofs]]; apply: (multipliers_sound t0 proofs of_filterP) => E inE x a a' k aa k0; cbv beta.
have [B [M [T F]]] := in_scopeP ok sc st inE; have [kM kT eE floor _ _] := F; rewrite !eE; split; first exact: E_ge0.
rewrite -(hockey_M _ _ _ F) max_of_ge0; last first.
  by apply: addr_ge0; [exact: L_ge0 | apply: mulr_ge0; [exact: gamma_ge0 | exact: hockey_stick_ge0]].
apply: (T1_filter kX kM kT) => //; [exact: ratio_gt0 | by rewrite -eE | exact: gamma_ge0 | exact: L_ge0 | exact: valued_g |].
by move=> u; apply: spread_within.
Qed.

Theorem T3_sound s V means ks : in_scope S s ->
  with_floor S s (fun t => at_most t (difference (gamma_used S) (L_used S)) &&
    multipliers_prove V (L_used S) (difference (gamma_used S) (L_used S)) zero t ks (of_filter S).1 (of_filter S).2) ->
  greatest_at_most false (class_of (R := R) (S := S) means s) V.
Proof.
move=> sc /with_floorQ[t [st t0 /andP[/(at_mostP R) tg proofs]]]; apply: (multipliers_sound t0 proofs of_filterP) => E inE x a a' k aa k0; cbv beta.
have [B [M [T F]]] := in_scopeP ok sc st inE; have [kM kT eE floor _ _] := F; rewrite !eE; split; first exact: E_ge0.
rewrite ratio_difference in tg *; have Lg : L <= gam by rewrite -subr_ge0; apply: le_trans tg; exact/ltW/ratio_gt0.
rewrite -(hockey_M _ _ _ F) max_of_ge0; last first.
  by apply: addr_ge0; [exact: L_ge0 | apply: mulr_ge0; [rewrite subr_ge0 | exact: hockey_stick_ge0]].
apply: (T3_K_one_k kX kM kT) => //; [exact: L_ge0 | exact: ratio_ge0 | exact: valued_g | | exact: ratio_gt0 | by rewrite -eE].
by move=> u; apply: spread_within.
Qed.

Theorem T4_sound V ks : one_release S -> a_free S -> positive_fraction (m_used S) ->
  multipliers_prove V zero (difference (gamma_used S) (m_used S)) (m_used S) (m_used S) ks (of_filter S).1 (of_filter S).2 ->
  greatest_at_most false (@of_any_policy R S) V.
Proof.
move=> one free m0 proofs; apply: (multipliers_sound m0 proofs of_filterP) => E [T [kT eE]] x a a' k aa k0; cbv beta.
rewrite !eE; have kM := kernel_MA_all R ok; split; first exact: E_ge0.
have -> : H a a' k = hockey_stick (ratio k) (MA_all R (S := S) a) (MA_all R (S := S) a').
  exact/esym/(all_once (proj1 (Pos.eqb_eq _ _) one) a a' (fun p q => Num.max 0 (p - ratio k * q))).
rewrite ratio_zero add0r ratio_difference.
exact: (T4_any_policy kX kM kT (ratio k) x a a' (valued_m R ok cons) (freeP R ok cons free) (ratio_gt0 R m0)).
Qed.

(* ---- Every group filter of this epsilon ---- *)

Lemma hockey_pair (n d : positive) k : ratio (hockey (Zpos (n + d)) k [:: (Zpos n, Zpos d); (Zpos d, Zpos n)]) =
  hockey_stick (ratio k) (truth (ratio (Qmake (Zpos n) d))) (lie (ratio (Qmake (Zpos n) d))) :> R.
Proof.
apply: hockeyP => //; split=> [t|F hF]; first by case=> [<-|[<-|//]]; split; apply/ltW/embed_pos.
rewrite !sum_cons sum_nil addr0 /= big_bool /truth /lie /ratio /=.
have d0 : embed (Zpos d) != 0 :> R by rewrite embed_neq0.
have e : embed (Zpos (n + d)) = embed (Zpos d) * (1 + embed (Zpos n) / embed (Zpos d)) :> R.
  by rewrite mulrDr mulr1 mulrCA divff // mulr1 -[Zpos (n + d)]/(Z.add (Zpos n) (Zpos d)) embedD addrC.
have s0 : 1 + embed (Zpos n) / embed (Zpos d) != 0 :> R.
  by apply/eqP => z; move: e; rewrite z mulr0 => /eqP; rewrite (negbTE (embed_neq0 R _)).
have U0 : 0 <= embed (Zpos (n + d)) :> R by apply/ltW/embed_pos.
have eT : embed (Zpos (n + d)) * (embed (Zpos n) / embed (Zpos d) / (1 + embed (Zpos n) / embed (Zpos d))) = embed (Zpos n) :> R.
  by rewrite e [_ / (1 + _)]mulrC mulrA mulfK // mulrC divfK.
have eL : embed (Zpos (n + d)) * (1 / (1 + embed (Zpos n) / embed (Zpos d))) = embed (Zpos d) :> R.
  by rewrite e mul1r mulfK.
by rewrite mulrDr -!hF // eT eL.
Qed.

Lemma hockey_certain k : nonnegative k -> ratio (hockey 1 k [:: (Zpos 1, Z0); (Z0, Zpos 1)]) = 1 :> R.
Proof.
move=> k0; rewrite (@hockeyP R 1 k _ [finType of bool] (fun b => b%:R) (fun b => (~~ b)%:R)) //; last first.
  split=> [t|F hF]; first by case=> [<-|[<-|//]]; rewrite /= ?embed0 ?embed1 ler01 lexx.
  by rewrite !sum_cons sum_nil addr0 /= big_bool /= embed0 embed1 mul1r.
rewrite /hockey_stick big_bool /= mulr0 subr0 mulr1 sub0r (max_idPr ler01) (max_idPl _) ?addr0 //.
by rewrite oppr_le0; apply: ratio_ge0.
Qed.

Theorem T3_group_sound V ks : a_free S ->
  with_floor S AnyGroupFilter (fun t => at_most t (gamma_used S) &&
    multipliers_prove V zero (gamma_used S) zero t ks (of_epsilon S).1 (of_epsilon S).2) ->
  greatest_at_most false (@of_group_filter R S) V.
Proof.
move=> free /with_floorQ[t [[<-] t0 /andP[_ proofs]]].
have floor : Rules.policy_floor MX T0 g (ratio (policy_floor S)) by apply: policy_floorP.
have kT := policy_T0 R ok.
pose Hk k := if epsilon S is Some e then hockey_stick (ratio k) (truth (ratio e)) (lie (ratio e)) else 1 : R.
apply: (@multipliers_sound _ V zero _ zero _ ks _ _ (fun _ _ => Hk) t0 proofs) => [a a' _|E [M [kM pM eE]] x a a' k aa k0].
  rewrite /Hk /of_epsilon; case e: (epsilon S) => [[n d]|]; last first.
    by exists [:: (Zpos 1, Z0); (Z0, Zpos 1)]; [left | move=> k k0; rewrite hockey_certain].
  have [e1 _] := epsilonP R ok e; case: n e e1 => [|n|n] e e1.
  - by move: e1; rewrite /ratio /= embed0 mul0r ler10.
  - by exists [:: (Zpos n, Zpos d); (Zpos d, Zpos n)]; [left | move=> k _; rewrite hockey_pair].
  - by move: e1; rewrite leNgt (le_lt_trans _ ltr01) // /ratio pmulr_lle0 ?invr_gt0 ?embed_pos // embed_le0.
rewrite !eE; split; first exact: E_ge0.
have H0 : 0 <= Hk k by rewrite /Hk; case: (epsilon S) => [e|]; rewrite ?hockey_stick_ge0 ?ler01.
rewrite ratio_zero add0r mulr0 subr0 (max_idPr _); last by apply: mulr_ge0; [exact: gamma_ge0 | ].
have := ratio_ge0 R k0; have := ratio_gt0 R t0; move: pM H0; rewrite /private /Hk -[exp_epsilon _]/(epsilon S).
case e: (epsilon S) => [b|] pM _ t1 k1.
  have [b1 _] := epsilonP R ok e.
  exact: (T3_any_filter kX kT x a a' kM (gamma_ge0 R ok cons) (valued_g R ok cons) (freeP R ok cons free) k1 b1 pM t1 floor).
have te : ratio (policy_floor S) <= Definitions.utility (induced MX M T0) g x a'.
  exact: (policy_floor_holds kX kM floor x a').
apply: ratio_weaken (T3_one_k kX kM kT (ratio k) a (gamma_ge0 R ok cons) (valued_g R ok cons) (freeP R ok cons free) t1 te).
  exact: E_ge0.
rewrite ler_add2l; apply: ler_wpmul2r; first by rewrite invr_ge0 ltW.
apply: ler_wpmul2l; first exact: gamma_ge0.
rewrite -(proj2 (kM a)); apply: ler_sum => b _; rewrite le_maxl (proj1 (kM a)) /= ler_subl_addr ler_addl.
by rewrite mulr_ge0 ?(proj1 (kM a')).
Qed.
End Bounds.
