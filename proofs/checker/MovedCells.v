(* What the program computes of one cell that moves: ends that bound its expectation and are attained. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From mathcomp.zify Require Import ssrZ.
From Fairaudit Require Import Definitions T16.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Drift ListsSound MovedLaws.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Numbers.
Variable R : realFieldType.
Local Notation ratio := (@ratio R).

Lemma ratio_difference q r : ratio (difference q r) = ratio q - ratio r.
Proof. by rewrite /difference ratio_plus ratio_minus. Qed.

Lemma ratio_no_less q r : ratio (no_less q r) = Num.max (ratio q) (ratio r).
Proof. by rewrite /no_less (at_mostE R); case: leP. Qed.

Lemma ratio_no_more_of q r : ratio (no_more_of q r) = Num.min (ratio q) (ratio r).
Proof. by rewrite /no_more_of (at_mostE R); case: leP. Qed.

Lemma top_ofP gs : gs <> [::] -> List.In (top_of gs) gs /\ forall g, List.In g gs -> ratio g <= ratio (top_of gs).
Proof.
case: gs => // g gs _ /=; elim: gs g => [|h gs IH] g /=; first by split; [left | move=> q [->|]].
have [there above] := IH (no_less g h); split.
  by case: there => [<-|]; [rewrite /no_less; case: ifP => _; [right; left | left] | right; right].
have top_gh := above _ (or_introl erefl); rewrite ratio_no_less in top_gh.
move=> q [<-|[<-|qin]]; last by apply: above; right.
  by apply: le_trans top_gh; rewrite le_maxr lexx.
by apply: le_trans top_gh; rewrite le_maxr lexx orbT.
Qed.

(* ---- A law in lists ---- *)

Section Spread.
Variables (n : nat) (ps : list Q).
Hypothesis size_ps : size ps = n.

Definition listed (qs : list Q) (i : 'I_n) : R := ratio (nth zero qs i).
Local Notation P := (listed ps).
Hypothesis lP : law P.

Lemma sum_combined gs (F : Q -> Q -> R) : size gs = n ->
  \sum_(pg <- List.combine ps gs) F pg.1 pg.2 = \sum_(i < n) F (nth zero ps i) (nth zero gs i).
Proof.
move=> e; rewrite -(big_mkord xpredT (fun i => F (nth zero ps i) (nth zero gs i))) -size_ps; move: e; rewrite -size_ps.
elim: (ps) gs => [|p ps' IH] [|g gs] //=; first by rewrite big_nil big_geq.
by move=> [e]; rewrite big_cons big_nat_recl //= (IH gs e).
Qed.

Lemma turned_combine gs : turned (List.combine ps gs) = List.combine ps (map minus gs).
Proof. by rewrite /turned; elim: (ps) gs => [|p ps' IH] [|g gs] //=; rewrite IH. Qed.

Lemma listed_turned gs i : size gs = n -> listed (map minus gs) i = - listed gs i.
Proof. by move=> e; rewrite /listed (nth_map zero) ?e // ratio_minus. Qed.

Lemma in_combined gs p g : size gs = n -> List.In (p, g) (List.combine ps gs) <-> exists i : 'I_n, p = nth zero ps i /\ g = nth zero gs i.
Proof.
move=> e; split=> [|[i [-> ->]]].
  move: e; rewrite -size_ps; elim: (ps) gs => [|q ps' IH] [|h gs] //= [e] [[<- <-]|/(IH _ e)[i [-> ->]]].
    by exists ord0.
  by exists (lift ord0 i).
case: i => i ilt /=; move: ilt e; rewrite -size_ps; elim: (ps) gs i => [|q ps' IH] [|h gs] [|i] //=; first by left.
by move=> ilt [e]; right; apply: IH.
Qed.

Variable gs : list Q.
Hypothesis size_gs : size gs = n.
Local Notation g := (listed gs).
Local Notation L := (List.combine ps gs).

Lemma ratio_mass_where (f : Q -> bool) (h : pred R) : (forall q, f q = h (ratio q)) -> ratio (mass_where f L) = \sum_(i | h (g i)) P i.
Proof.
move=> fh; rewrite /mass_where ratio_total.
have -> : \sum_(q <- List.map fst (List.filter (fun pg : Q * Q => f pg.2) L)) ratio q = \sum_(pg <- L) (if h (ratio pg.2) then ratio pg.1 else 0).
  by elim: L => [|[p q] l IH] /=; rewrite ?big_nil // big_cons /= fh; case: ifP => _ /=; rewrite ?big_cons ?IH //= add0r.
by rewrite (sum_combined (fun p q => if h (ratio q) then ratio p else 0)) // [RHS]big_mkcond.
Qed.

Lemma ratio_below theta : ratio (below theta L) = below_ P g (ratio theta).
Proof. by apply: (@ratio_mass_where _ (fun v => v < ratio theta)) => q; rewrite (at_mostE R) ltNge. Qed.

Lemma ratio_up_to theta : ratio (Drift.up_to theta L) = MovedLaws.up_to P g (ratio theta).
Proof. by apply: (@ratio_mass_where _ (fun v => v <= ratio theta)) => q; rewrite (at_mostE R). Qed.

Lemma ratio_above theta : ratio (above theta L) = above_ P g (ratio theta).
Proof. by apply: (@ratio_mass_where _ (fun v => ratio theta < v)) => q; rewrite (at_mostE R) ltNge. Qed.

Lemma some_decision : exists i : 'I_n, 0 < P i.
Proof.
have [P0 P1] := lP; apply/existsP; apply: contraT => /existsPn none.
have := P1; rewrite big1 => [/eqP|i _]; first by rewrite eq_sym oner_eq0.
by apply/eqP; rewrite eq_le P0 andbT leNgt; apply: none.
Qed.

Lemma in_reachable k q : List.In q (reachable k L) <-> exists2 i, can_be P k i & q = nth zero gs i.
Proof.
rewrite /reachable; split=> [/in_map_iff[[p q'] [/= <-]]|[i can ->]].
  case: k => [/(in_combined _ _ size_gs)[i [_ ->]]|/in_filter_seq[/(in_combined _ _ size_gs)[i [-> ->]] pos]]; exists i => //.
  by move=> _; rewrite /listed -positive_fractionE.
apply/in_map_iff; exists (nth zero ps i, nth zero gs i); split=> //.
have there : List.In (nth zero ps i, nth zero gs i) L by apply/(in_combined _ _ size_gs); exists i.
by case: k can => // /(_ erefl) Pi; apply/in_filter_seq; split=> //=; rewrite (positive_fractionE R).
Qed.

Lemma top_reachable k : top_is P g k (ratio (top_of (reachable k L))).
Proof.
have [i Pi] := some_decision; have there : List.In (nth zero gs i) (reachable k L) by apply/in_reachable; exists i.
have [|/in_reachable[j can e] above] := @top_ofP (reachable k L); first by move=> e; rewrite e in there.
split; first by exists j; rewrite // e.
by move=> j' can'; apply: above; apply/in_reachable; exists j'.
Qed.

Definition is_upper k w hi : Prop := (forall D, near P k w D -> expect D g <= hi) /\ exists2 D, near P k w D & expect D g = hi.

Lemma expect_list (h : Q -> Q) (f : R -> R) : (forall q, ratio (h q) = f (ratio q)) ->
  ratio (total (List.map (fun pg : Q * Q => times pg.1 (h pg.2)) L)) = expect P (fun i => f (g i)).
Proof.
move=> hf; rewrite ratio_total big_map (eq_bigr (fun pg => ratio pg.1 * f (ratio pg.2))) => [|pg _]; last by rewrite ratio_times hf.
by rewrite (sum_combined (fun p q => ratio p * f (ratio q))).
Qed.

Lemma variation_endP eta theta mean hi : is_amount By_variation eta -> ratio mean = expect P g ->
  variation_end eta theta (top_of (reachable By_variation L)) mean L = Some hi -> is_upper By_variation (ratio eta) (ratio hi).
Proof.
move=> /andP[e0 e1] meanE; rewrite /variation_end; case: ifP => // /and3P[th low high] [<-].
rewrite (nonnegativeE R) in e0; rewrite (at_mostE R) ratio_one in e1.
rewrite !(at_mostE R) ratio_below ratio_up_to in th low high.
have [||||bound attained] := @variation_attained R _ P g lP (ratio eta) (ratio (top_of (reachable By_variation L))) (ratio theta).
- by rewrite e0.
- exact: top_reachable.
- exact: th.
- by rewrite low.
rewrite /is_upper !ratio_plus ratio_times ratio_difference meanE.
rewrite (@expect_list (fun q => no_less zero (difference theta q)) (fun v => Num.max 0 (ratio theta - v))) // => q.
by rewrite ratio_no_less ratio_zero ratio_difference.
Qed.

Lemma factor_endP f theta hi : is_amount By_factor f -> factor_end f theta L = Some hi -> is_upper By_factor (ratio f) (ratio hi).
Proof.
rewrite /is_amount (at_mostE R) ratio_one => f1; rewrite /factor_end; case: ifP => // /andP[low high] [<-].
have f0 : 0 < ratio f := lt_le_trans ltr01 f1.
have invE : ratio (inverse f) = (ratio f)^-1 by rewrite ratio_inverse ?(positive_fractionE R).
rewrite !(at_mostE R) !ratio_plus !ratio_times !ratio_difference invE ratio_one ratio_above ratio_below in low high.
have [|bound attained] := @factor_attained R _ P g lP (ratio f) (ratio theta) f1.
  by rewrite low /= addrC.
rewrite /is_upper ratio_plus.
pose h v := (v - ratio theta) * (if 0 <= v - ratio theta then ratio f else (ratio f)^-1).
rewrite (@expect_list (fun q => let z := difference q theta in times z (if nonnegative z then f else inverse f)) h) => [|q]; last first.
  by rewrite ratio_times (nonnegativeE R) ratio_difference /h; case: ifP; rewrite ?invE.
suff -> : ratio theta + expect P (fun i => h (g i)) = factor_up (ratio f) (ratio theta) P g by split.
congr (_ + _); apply: eq_expect => // i; rewrite /h; case: ifP => s.
  by rewrite (max_idPr s) (max_idPl _) ?mul0r ?subr0 1?mulrC // -oppr_ge0 opprB.
have {}s : listed gs i - ratio theta <= 0 by rewrite ltW // ltNge s.
rewrite (max_idPl s) mulr0 sub0r (max_idPr _); first by rewrite -[in LHS](opprB (ratio theta)) mulNr.
by rewrite subr_ge0 -subr_le0.
Qed.
End Spread.

(* ---- Both ends ---- *)

Definition meant (amount : option Q) (v : R) : Prop := if amount is Some w then v <= ratio w else True.
Definition an_amount (k : move) (amount : option Q) : bool := if amount is Some w then is_amount k w else true.

(* The ends bound every law that moves so far; if that is a number, both are attained. *)
Definition are_ends n (ps gs : list Q) k amount (e : Q * Q) : Prop :=
  (forall v (D : 'I_n -> R), meant amount v -> near (listed ps) k v D -> ratio e.1 <= expect D (listed gs) <= ratio e.2)
  /\ (if amount is Some w then
        (exists2 D : 'I_n -> R, near (listed ps) k (ratio w) D & expect D (listed gs) = ratio e.1)
        /\ (exists2 D : 'I_n -> R, near (listed ps) k (ratio w) D & expect D (listed gs) = ratio e.2)
      else True).

Lemma is_upper_turned n (ps gs : list Q) k w hi : size gs = n -> is_upper n ps (map minus gs) k w hi ->
  (forall D, near (@listed n ps) k w D -> - hi <= expect D (listed gs)) /\ exists2 D, near (@listed n ps) k w D & expect D (listed gs) = - hi.
Proof.
move=> e [bound [D nD eD]]; have turn D' : expect D' (@listed n (map minus gs)) = - expect D' (listed gs).
  by rewrite -expectN; apply: eq_expect => // i; apply: listed_turned.
split=> [D' nD'|]; first by rewrite ler_oppl -turn; apply: bound.
by exists D; rewrite // -eD turn opprK.
Qed.

Lemma ends_of_lawP n ps gs k amount mean e : size ps = n -> size gs = n -> law (@listed n ps) -> an_amount k amount ->
  ratio mean = expect (@listed n ps) (listed gs) -> ends_of_law k amount mean (List.combine ps gs) = Some e -> are_ends n ps gs k amount e.
Proof.
move=> size_ps size_gs lP ok meanE; have size_turned : size (map minus gs) = n by rewrite size_map.
have turned_mean : ratio (minus mean) = expect (@listed n ps) (listed (map minus gs)).
  by rewrite ratio_minus meanE -expectN; apply: eq_expect => // i; rewrite listed_turned.
have finite w (hi lo : Q) : amount = Some w -> is_upper n ps gs k (ratio w) (ratio hi) -> is_upper n ps (map minus gs) k (ratio w) (ratio lo) ->
    are_ends n ps gs k amount (minus lo, hi).
  move=> -> [above attained] /(is_upper_turned size_gs)[beneath attained']; split=> /=; rewrite ratio_minus.
    by move=> v D vw nD; have {}nD := near_farther lP nD vw; rewrite above ?beneath.
  by split.
rewrite /ends_of_law turned_combine; case: k amount ok finite => [] [w|] ok finite /=.
- case lo: (variation_end _ _ _ _ (List.combine ps (map minus gs))) => [l|]; case hi: (variation_end _ _ _ _ _) => [h|] //= [<-].
  by apply: finite; [|exact: (variation_endP _ _ _ ok meanE hi)|exact: (variation_endP _ _ _ ok turned_mean lo)].
- case=> <-; split=> //= v D _ [lD _]; rewrite ratio_minus ler_oppl.
  have t := top_reachable size_ps lP size_gs By_variation; have t' := top_reachable size_ps lP size_turned By_variation.
  rewrite (below_top (P := listed ps) lD _ t) ?andbT => [|i []//].
  apply: le_trans (below_top (P := listed ps) lD _ t') => [|i []//]; rewrite -expectN le_eqVlt; apply/orP; left; apply/eqP.
  by apply: eq_expect => // i; rewrite listed_turned.
- case lo: (factor_end _ _ (List.combine ps (map minus gs))) => [l|]; case hi: (factor_end _ _ _) => [h|] //= [<-].
  by apply: finite; [|exact: (factor_endP _ _ _ ok hi)|exact: (factor_endP _ _ _ ok lo)].
case=> <-; split=> //= v D _ [lD [a _]]; rewrite ratio_minus ler_oppl.
have off i : ~ can_be (listed ps) By_factor i -> D i = 0.
  move=> no; have Pi : listed ps i = 0 :> R.
    by apply/eqP; rewrite eq_le; have [P0 _] := lP; rewrite P0 andbT leNgt; apply/negP => pos; apply: no.
  by apply/eqP; rewrite eq_le; have [D0 _] := lD; rewrite D0 andbT; have := a i; rewrite Pi mulr0.
have t := top_reachable size_ps lP size_gs By_factor; have t' := top_reachable size_ps lP size_turned By_factor.
rewrite (below_top lD off t) andbT; apply: le_trans (below_top lD off t'); rewrite -expectN le_eqVlt; apply/orP; left; apply/eqP.
by apply: eq_expect => // i; rewrite listed_turned.
Qed.
End Numbers.
