(* An interval that is judged to be proved by the draws of a table holds of the population, as DrawnMeaning.v says. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From Fairaudit Require Import Definitions Draws Coverage.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Chance ChanceSound Drawn DrawnMeaning.
From FairauditChecker Require Statements Hidden HiddenSound Pairs PairsSound Bets BetsHold.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Lemma all_of_map A B (f : A -> option B) (xs : seq A) ys : all_of f xs = Some ys -> [seq f x | x <- xs] = [seq Some y | y <- ys].
Proof. by elim: xs ys => [|x xs IH] ys /=; [case=> <- | case: (f x) => // y; case: (all_of f xs) IH => // zs IH [<-] /=; rewrite (IH zs)]. Qed.

Lemma sum_from ns m : List.fold_left Z.add ns m = Z.add m (sum ns).
Proof.
rewrite /sum; elim: ns m => [|n ns IH] m /=; first by rewrite Z.add_0_r.
by rewrite IH (IH n) Z.add_assoc.
Qed.

Lemma sum_cons n ns : sum (n :: ns) = Z.add n (sum ns).
Proof. by rewrite {1}/sum /= sum_from. Qed.

Lemma sum_of_nat A (xs : seq A) (f : A -> nat) : sum [seq Z.of_nat (f x) | x <- xs] = Z.of_nat (\sum_(x <- xs) f x).
Proof. by elim: xs => [|x xs IH]; rewrite ?big_nil //= sum_cons IH big_cons Nat2Z.inj_add. Qed.

Lemma all_some (A : eqType) B (ok : A -> bool) (f : A -> B) xs ys :
  [seq if ok x then Some (f x) else None | x <- xs] = [seq Some y | y <- ys] -> {in xs, forall x, ok x} /\ ys = [seq f x | x <- xs].
Proof.
elim: xs ys => [|x xs IH] [|y ys] //= []; case okx: (ok x) => // -[->] /IH[all_ok ->]; split=> // z.
by rewrite inE => /orP[/eqP->|/all_ok].
Qed.

Section Sound.
Variables (R : realFieldType) (ps : list pool) (d : nat).
Local Notation N := (size ps).
Local Notation at_pool := (@pool_at ps).

Definition good (i : 'I_N) (u : 'I_d) : bool := ~~ is_nothing (nth zero (values (at_pool i)) u).
Definition top (i : 'I_N) : QArith_base.Q := greatest (values (at_pool i)).
Definition blk (i : 'I_N) : Z := of_block (at_pool i).

Variables (D : finType) (pool_of : D -> 'I_N).

Lemma sums_again (w : {ffun D -> 'I_d}) (i : 'I_N) :
  sum [seq Z.of_nat #|[set x | (pool_of x == i) && (w x == u)]| | u <- enum 'I_d] = Z.of_nat (Draws.draws pool_of i).
Proof.
rewrite sum_of_nat big_enum /= /Draws.draws -sum1_card (partition_big w xpredT) //=; congr Z.of_nat; apply: eq_bigr => u _.
by rewrite -sum1_card; apply: eq_bigl => x; rewrite !inE.
Qed.

Lemma worth_sum (w : {ffun D -> 'I_d}) (i : 'I_N) (us : seq 'I_d) (gs : seq QArith_base.Q) (f : 'I_d -> nat) k :
  [seq val u | u <- us] = iota k (size us) ->
  sum (List.map (fun gn : QArith_base.Q * Z => if is_nothing gn.1 then Z0 else gn.2) (List.combine (drop k gs) [seq Z.of_nat (f u) | u <- us])) =
  Z.of_nat (\sum_(u <- us | ~~ is_nothing (nth zero gs u)) f u).
Proof.
elim: us k => [|u us IH] k /=; first by rewrite big_nil; case: (drop k gs).
case=> uk rest; rewrite big_cons; have [lt|ge] := ltnP k (size gs).
  rewrite (drop_nth zero lt) /= sum_cons (IH k.+1 rest) uk.
  by case: (is_nothing _); rewrite /= ?Nat2Z.inj_add.
rewrite drop_oversize //= uk nth_default //= big1_seq // => v /andP[good_v vin]; move: good_v; rewrite nth_default //.
have : val v \in [seq val u | u <- us] by apply: map_f.
by rewrite rest mem_iota => /andP[kv _]; apply: leq_trans ge _; apply: ltnW.
Qed.

Lemma successes_again (w : {ffun D -> 'I_d}) (i : 'I_N) :
  sum (List.map (fun gn : QArith_base.Q * Z => if is_nothing gn.1 then Z0 else gn.2)
    (List.combine (values (at_pool i)) [seq Z.of_nat #|[set x | (pool_of x == i) && (w x == u)]| | u <- enum 'I_d])) = Z.of_nat (count pool_of good i w).
Proof.
rewrite -[values _]drop0 (worth_sum w i _ (fun u => #|[set x | (pool_of x == i) && (w x == u)]|)) ?val_enum_ord ?size_enum_ord //.
congr Z.of_nat; rewrite /count -sum1_card big_enum_cond /=.
rewrite [RHS](partition_big w (fun u => good i u)) /= => [|x]; last by rewrite inE => /andP[].
apply: eq_big => [u//|u gu].
by rewrite -sum1_card; apply: eq_bigl => x; rewrite !inE; case: (w x =P u) => [->|]; rewrite ?andbT ?andbF // /good gu ?andbT.
Qed.

Lemma samples_again (w : {ffun D -> 'I_d}) ss : all_of sample_of (counted_again pool_of w) = Some ss ->
  ss = samples (count pool_of good) (Draws.draws pool_of) blk top w /\
  forall i, nonnegative (top i) && forallb (fun q => is_nothing q || (at_most q (top i) && at_most (top i) q)) (values (at_pool i)).
Proof.
move=> /all_of_map; rewrite /counted_again -map_comp => e.
pose ok i := nonnegative (top i) && forallb (fun q => is_nothing q || (at_most q (top i) && at_most (top i) q)) (values (at_pool i)).
set F := (_ \o _) in e.
have FE i : F i = if ok i then Some (ChanceSound.sample_of (count pool_of good) (Draws.draws pool_of) blk top w i) else None.
  by rewrite /F /= /sample_of /= -/(top i) -/(ok i) sums_again successes_again.
move: e; rewrite (eq_map FE) => /all_some[all_ok ->]; split=> // i.
by apply: all_ok; rewrite mem_enum.
Qed.

(* ---- The means ---- *)

Variable Q : 'I_N -> 'I_d -> R.
Hypothesis laws : kernel Q.

Lemma mean_top i : forallb (fun q => is_nothing q || (at_most q (top i) && at_most (top i) q)) (values (at_pool i)) ->
  mean Q i = ratio (top i) * chance Q good i.
Proof.
move=> /List.forallb_forall one_value; rewrite /mean /chance mulr_sumr [RHS]big_mkcond; apply: eq_bigr => u _.
rewrite /worth_of /good; case nothing_: (is_nothing _) => /=.
  by move: nothing_; rewrite /is_nothing (no_numeratorE R) => /eqP ->; rewrite mulr0.
have [lt|ge] := ltnP u (size (values (at_pool i))); last by move: nothing_; rewrite nth_default.
move: (one_value _ (in_nth zero lt)); rewrite nothing_ /= => /andP[]; rewrite !(at_mostE R) => le ge.
by rewrite mulrC (@le_anti _ _ (ratio _) (ratio (top i))) // le ge.
Qed.

Hypothesis ok : forall i, nonnegative (top i) && forallb (fun q => is_nothing q || (at_most q (top i) && at_most (top i) q)) (values (at_pool i)).

Lemma worth0 i : nonnegative (top i). Proof. by case/andP: (ok i). Qed.

Lemma meanE i : mean Q i = E (chance Q good) (fun i => ratio (top i)) i.
Proof. by apply: mean_top; case/andP: (ok i). Qed.

Lemma most_trueE r : most_true (chance Q good) blk top r -> ratio_at_most Q r.
Proof. by case: r => // r all_ij i j ij; rewrite !meanE; apply: all_ij. Qed.

Lemma least_trueE r : least_true (chance Q good) blk top r -> ratio_at_least Q r.
Proof.
case: r => [r [le1|[i [j [ij le gt]]]]|[i [j [ij le gt]]]]; first by left.
- have [|gt1] := leP (ratio r) (1 : R); first by left.
  right; exists i, j; rewrite !meanE; split=> //.
  by rewrite -ler_pdivl_mull ?(lt_trans ltr01).
- exists i, j; rewrite !meanE; split=> //; apply/eqP; rewrite eq_le -{1}(mul0r (E (chance Q good) (fun i => ratio (top i)) i)) le /=.
  by apply: (E_ge0 (chance01 good laws)) => k; apply: ratio_ge0 (worth0 k).
Qed.

Lemma law_of ind P : drawn_from pool_of Q ind P -> exists P',
  [/\ law P', forall S, prob P S = prob P' S, Ends.counted P' (count pool_of good) (Draws.draws pool_of) (chance Q good)
    & ind -> Ends.independent_counts P' (count pool_of good)].
Proof.
have counted_ P' : (forall i, Draws.within pool_of Q P' i) -> Ends.counted P' (count pool_of good) (Draws.draws pool_of) (chance Q good).
  by move=> ind' i; split=> [w|j]; [exact: count_le | exact: (count_binomial good laws j (ind' i))].
case: ind => [all_w|[lawP ind']]; last by exists P; split=> //; apply: counted_.
exists (Draws.drawn pool_of Q); split=> [||| _ S].
- exact: law_drawn.
- by move=> S; apply: eq_bigr.
- by apply: counted_ => i; apply: within_drawn.
- exact: counts_independent.
Qed.
End Sound.

Lemma proved_by_poolsP i ps : proved_by_pools i ps ->
  exists ss, [/\ all_of sample_of ps = Some ss, in_proportion i ss, at_most (confidence i) one & box_accepted i ss].
Proof.
rewrite /proved_by_pools /judged_by_pools; case: (all_of sample_of ps) => [[|s ss]|] //; case: ifP => // _ /and3P[c1 prop_ acc].
by exists (s :: ss).
Qed.

Section Holds.
Variable R : realFieldType.

Theorem box_sound T local i : judged_by_draws T local (By_box i) = Some true -> box_holds R T local i.
Proof.
rewrite /judged_by_draws; case pools: (pools_of T local) => [ps|] // judged; exists ps.
have acc : proved_by_pools i ps by rewrite /proved_by_pools judged.
split=> // d Q D pool_of P laws; case/(law_of laws) => P' [lawP' eqP_ counted_ indep] above below.
have [_ [_ _ /(at_mostP R) c1 _]] := proved_by_poolsP acc; rewrite ratio_one in c1.
have none S : S = set0 -> prob P S <= 1 - ratio (confidence i) by move=> ->; rewrite /prob big_set0 subr_ge0.
have data w j : proved_by_pools j (counted_again pool_of w) ->
    [/\ in_proportion j (samples (count pool_of (@good ps d)) (Draws.draws pool_of) (@blk ps) (@top ps) w),
      box_accepted j (samples (count pool_of (@good ps d)) (Draws.draws pool_of) (@blk ps) (@top ps) w)
    & forall k : 'I_(size ps), nonnegative (top k) && forallb (fun q => is_nothing q || (at_most q (top k) && at_most (top k) q)) (values (pool_at k))].
  by case/proved_by_poolsP => ss [/samples_again[-> ok] prop_ _ acc_j]; split.
case apart: (each i); [split|] => S all_w; have [/none //|[w0 /[dup] w0S /all_w[j0 [_ /data[_ _ ok] _]]]] := set_0Vmem S; rewrite eqP_.
- apply: (box_upper (blk := @blk ps) lawP' (chance01 (@good ps d) laws) (worth0 ok) counted_ c1 indep) => w /all_w[j [[cj ej ij] /data[_ acc_j _] wrong]].
  exists j; split=> //; first by rewrite /settled_apart cj ej ij apart.
  by move/(most_trueE ok).
- apply: (box_lower (blk := @blk ps) lawP' (chance01 (@good ps d) laws) (worth0 ok) counted_ c1 indep) => w /all_w[j [[cj ej ij] /data[_ acc_j _] wrong]].
  exists j; split=> //; first by rewrite /settled_apart cj ej ij apart.
  by move/(least_trueE laws ok).
- apply: (box_proportional (blk := @blk ps) lawP' (chance01 (@good ps d) laws) (worth0 ok) counted_ c1 indep) => w /all_w[j [[cj ej ij] /data[prop_ acc_j _] wrong]].
  exists j; split=> //; first by rewrite cj ej ij apart.
  by case: wrong => wrong; [left => /(most_trueE ok) | right => /(least_trueE laws ok)].
Qed.

Lemma proved_by_laddersP i ps : proved_by_ladders i ps ->
  exists ss, [/\ all_of sample_of ps = Some ss, at_most (Pairs.sure_at i) one & Pairs.pairs_accepted i ss].
Proof.
rewrite /proved_by_ladders /judged_by_ladders; case: (all_of sample_of ps) => [[|s ss]|] //; case: ifP => // _ /andP[c1 acc].
by exists (s :: ss).
Qed.

Theorem pairs_sound T local i : judged_by_draws T local (By_pairs i) = Some true -> pairs_hold R T local i.
Proof.
rewrite /judged_by_draws; case pools: (pools_of T local) => [ps|] // judged; exists ps.
have acc : proved_by_ladders i ps by rewrite /proved_by_ladders judged.
split=> // d Q D pool_of P laws; case/(law_of laws) => P' [lawP' eqP_ counted_ /(_ isT) indep] above below.
have [_ [_ /(at_mostP R) c1 _]] := proved_by_laddersP acc; rewrite ratio_one in c1.
have none S : S = set0 -> prob P S <= 1 - ratio (Pairs.sure_at i) by move=> ->; rewrite /prob big_set0 subr_ge0.
have data w j : proved_by_ladders j (counted_again pool_of w) ->
    Pairs.pairs_accepted j (samples (count pool_of (@good ps d)) (Draws.draws pool_of) (@blk ps) (@top ps) w)
    /\ forall k : 'I_(size ps), nonnegative (top k) && forallb (fun q => is_nothing q || (at_most q (top k) && at_most (top k) q)) (values (pool_at k)).
  by case/proved_by_laddersP => ss [/samples_again[-> ok] _ acc_j]; split.
have share_each : Pairs.one_by_one i -> ratio (Pairs.share i) = 1 - ratio (Pairs.sure_at i) :> R.
  by move=> each_; rewrite /Pairs.share each_ PairsSound.errorE.
case apart: (Pairs.one_by_one i); [split|] => S all_w; have [/none //|[w0 /[dup] w0S /all_w[j0 [_ /data[_ ok] _]]]] := set_0Vmem S; rewrite eqP_.
- rewrite -share_each //; apply: (PairsSound.upper_misses (blk := @blk ps) (v := @top ps) lawP' (chance01 (@good ps d) laws) counted_ indep c1).
  by move=> w /all_w[j [alike_ /data[acc_j _] wrong]]; exists j; split; [exact: alike_ | exact: acc_j | move/(most_trueE ok)].
- rewrite -share_each //; apply: (PairsSound.lower_misses (blk := @blk ps) (v := @top ps) lawP' (chance01 (@good ps d) laws) counted_ indep c1).
  by move=> w /all_w[j [alike_ /data[acc_j _] wrong]]; exists j; split; [exact: alike_ | exact: acc_j | move/(least_trueE laws ok)].
- rewrite -PairsSound.errorE; apply: (PairsSound.either_misses (blk := @blk ps) (v := @top ps) lawP' (chance01 (@good ps d) laws) counted_ indep c1); first by rewrite apart.
  move=> w /all_w[j [alike_ /data[acc_j _] wrong]]; exists j; split; [exact: alike_ | exact: acc_j |].
  by case: wrong => wrong; [left => /(most_trueE ok) | right => /(least_trueE laws ok)].
Qed.

Theorem drawn_sound T local e : judged_by_draws T local e = Some true -> population_holds R T local e.
Proof. by case: e => i; [apply: box_sound | apply: pairs_sound | apply: BetsHold.bets_sound]. Qed.

Lemma judged_pools T local e : judged_by_draws T local e = Some true -> exists ps, pools_of T local = Some ps.
Proof. by rewrite /judged_by_draws; case: e => i; case: (pools_of T local) => // ps _; exists ps. Qed.

Theorem hidden_sound T local e v ls : judged_by_draws T local e = Some true -> Hidden.frontier_fits (least_of e) v ls ->
  hidden_needs R T local (least_of e) v ls.
Proof.
case/judged_pools => ps pools /(@HiddenSound.frontier_levels R)[first levels].
split=> //; exists ps; split=> // E l at_least_ /levels[to1 fits].
case: (least_of e) at_least_ fits => [r|] /=.
  case=> [r1|[i [j [comp le pos]]]] fits.
    by move: fits; rewrite /Hidden.level_fits; case: (Statements.balanced l) => // c /and4P[_]; rewrite (at_mostE R) -ltNge =>
      /(le_lt_trans to1)/lt_le_trans/(_ r1); rewrite ltxx.
  exists i, j; split=> // V k m p q f f' k1 m1 weak given.
  by apply: (HiddenSound.weaker_leaves (seen := Some r) to1 fits k1 m1 weak given).
case=> i [j [comp l0 pos]] fits; exists i, j; split=> // V k m p q f f' k1 m1 weak given.
by apply: (HiddenSound.weaker_leaves (seen := None) to1 fits k1 m1 weak given); rewrite gt_eqF.
Qed.

End Holds.
