(* An interval that is judged to be proved by bets on contrasts within units holds of the population, as BetsMeaning.v says. *)

From Coq Require Import ZArith QArith List Permutation Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions Draws Coverage Betting.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Drawn BetsMeaning BetsProducts.
From FairauditChecker Require Bets BetsSound Figures ListsSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Local Notation Q := QArith_base.Q.
Local Notation contrast := Bets.contrast.

(* ---- The bets on units ---- *)

Section Units.
Variables (R : realFieldType) (ps : list pool) (limits : option (Q * Q)) (D U : finType) (unit_in : Z -> pred D).
Local Notation groups := 'I_(size ps).
Variables (gets : groups -> D -> U -> R) (seen : groups -> D -> U -> option Q) (dropped : bool) (P : D -> U -> R) (E : groups -> R).
Hypothesis units : are_units limits unit_in gets seen dropped P E.
Local Notation context_of := (@context_of ps).
Local Notation top_of := (top_of ps limits).

Definition top (i : groups) : Q := top_of (context_of i).
Definition positive (i : groups) : bool := positive_fraction (top i).
Definition bet_on_units (i j : groups) (d : D) : bool :=
  [&& positive i, unit_in (context_of i) d & ~~ dropped || [forall u, isSome (seen i d u) && isSome (seen j d u)]].
Definition x (i : groups) (d : D) (u : U) : R := ratio (first_part (top i) (seen i d u)).
Definition y (j : groups) (d : D) (u : U) : R := ratio (second_part (top j) (seen j d u)).
Definition bets (i j : groups) : seq R := [seq ratio l | l <- Bets.bets_for (Z.of_nat #|bet_on_units i j|)].
Definition scaled (i : groups) : R := if positive i then E i / ratio (top i) else E i.

Lemma part_of_top (i : groups) d u q : seen i d u = Some q -> positive i -> ratio (times q (inverse (top i))) = gets i d u / ratio (top i).
Proof. by move=> s p; rewrite ratio_times ratio_inverse // (as_seen units s). Qed.

Lemma part_at_most_1 (i : groups) d u : positive i -> gets i d u / ratio (top i) <= 1.
Proof.
by move=> p; have /andP[_ le] := in_range units i d u; rewrite ler_pdivr_mulr ?mul1r //; apply: ratio_gt0.
Qed.

Lemma part_ge0 (i : groups) d u : positive i -> 0 <= gets i d u / ratio (top i).
Proof.
by move=> p; have /andP[ge _] := in_range units i d u; apply: divr_ge0 => //; apply/ltW/ratio_gt0.
Qed.

Lemma not_positive (i : groups) q : ~~ positive i -> ratio (times q (inverse (top i))) = 0 :> R.
Proof.
rewrite /positive /positive_fraction /inverse ratio_times; case: (Qnum (top i)) => [|p|p] // _; by rewrite [X in _ * X]ratio_zero mulr0.
Qed.

Lemma x1 (i : groups) d u : x i d u <= 1.
Proof.
rewrite /x /first_part; case s: (seen i d u) => [q|]; last by rewrite ratio_one.
case: (boolP (positive i)) => p; first by rewrite (part_of_top s p) part_at_most_1.
by rewrite not_positive // ler01.
Qed.

Lemma y0 (j : groups) d u : 0 <= y j d u.
Proof.
rewrite /y /second_part; case s: (seen j d u) => [q|]; last by rewrite ratio_zero.
case: (boolP (positive j)) => p; first by rewrite (part_of_top s p) part_ge0.
by rewrite not_positive.
Qed.

Lemma bets01 (i j : groups) l : l \in bets i j -> 0 <= l <= 1.
Proof.
rewrite /bets; have := @BetsSound.bets01 R (Z.of_nat #|bet_on_units i j|).
elim: (Bets.bets_for _) => //= r rs IH all_; rewrite in_cons => /orP[/eqP ->|]; first by apply: all_; left.
by apply: IH => q qin; apply: all_; right.
Qed.

Lemma scaled_ge0 i : 0 <= scaled i.
Proof.
rewrite /scaled; case: (boolP (positive i)) => [p|_]; last exact: mean_ge0 units _.
by apply: divr_ge0; [exact: mean_ge0 units _|exact/ltW/ratio_gt0].
Qed.

Lemma scaled_means (i j : groups) d : compared context_of i j -> bet_on_units i j d ->
  scaled i <= expect (P d) (x i d) /\ expect (P d) (y j d) <= scaled j.
Proof.
case/andP => /eqP same _ /and3P[pi inx _].
have topE : top j = top i by rewrite /top same.
have pj : positive j by rewrite /positive topE.
have inj_ : unit_in (context_of j) d by rewrite -same.
have lawP := each_law units d.
have scale (k : groups) : unit_in (context_of k) d -> E k / ratio (top k) = expect (P d) (fun u => gets k d u / ratio (top k)).
  move=> ink; rewrite -(mean_of_units units ink) /expect mulr_suml; apply: eq_bigr => u _; by rewrite mulrA.
rewrite /scaled pi pj !scale //; split; apply: expect_le => // u; rewrite /x /y /first_part /second_part.
  case s: (seen i d u) => [q|]; first by rewrite (part_of_top s).
  by rewrite ratio_one part_at_most_1.
case s: (seen j d u) => [q|]; first by rewrite (part_of_top s).
by rewrite ratio_zero part_ge0.
Qed.

Lemma same_ratio (i j : groups) r : compared context_of i j ->
  (scaled i <= r * scaled j) = (E i <= r * E j).
Proof.
case/andP => /eqP same _; have topE : top j = top i by rewrite /top same.
rewrite /scaled; have -> : positive j = positive i by rewrite /positive topE.
by case: (boolP (positive i)) => // p; rewrite topE mulrA ler_pmul2r // invr_gt0; apply: ratio_gt0.
Qed.

(* ---- What the units that are listed won ---- *)

Definition groups_in (b : Z) : seq groups := [seq i <- enum 'I_(size ps) | context_of i == b].
Definition contrasts (b : Z) (es : seq Bets.entry) (kl : nat * nat) : seq contrast :=
  if positive_fraction (top_of b) then Bets.contrasts_of dropped [seq Bets.as_parts (top_of b) e | e <- es] kl else [::].

Section Data.
Variables (w : {ffun D -> U}) (b : Z) (es : seq Bets.entry).
Hypotheses (pos : forall e, In e es -> Z.lt 0 e.1) (listed : list_units unit_in seen w b es).
Variables (i j : groups) (k l : nat).
Hypotheses (kL : (k < size (groups_in b))%N) (lL : (l < size (groups_in b))%N).
Hypotheses (ki : seq.nth i (groups_in b) k = i) (lj : seq.nth j (groups_in b) l = j).

Lemma in_context_b a m : (m < size (groups_in b))%N -> seq.nth a (groups_in b) m = a -> context_of a = b.
Proof. by move=> mL e; have := mem_nth a mL; rewrite e mem_filter => /andP[/eqP]. Qed.

Lemma profile_at a m d u : (m < size (groups_in b))%N -> seq.nth a (groups_in b) m = a ->
  seq.nth None (profile_of seen b d u) m = seen a d u.
Proof. by move=> mL e; rewrite /profile_of (nth_map a) // e. Qed.

Lemma product_units (f : Q -> Q -> R) :
  \prod_(c <- contrasts b es (k, l)) power_of f c =
  \prod_(d | bet_on_units i j d) f (first_part (top i) (seen i d (w d))) (second_part (top j) (seen j d (w d)))
  /\ no_less (contrasts b es (k, l)).
Proof.
have bi := in_context_b kL ki; have bj := in_context_b lL lj.
have ti : top i = top_of b by rewrite /top bi.
have tj : top j = top_of b by rewrite /top bj.
rewrite /contrasts /bet_on_units /positive ti tj bi; case: (positive_fraction (top_of b)); last by rewrite big_nil big1 //; split=> // c [].
move: (product_contrasts f dropped (top_of b) k l pos) => /= [-> less]; split=> //.
rewrite (product_listed (fun p => one_unit f dropped (top_of b) (seq.nth None p k) (seq.nth None p l))).
rewrite (product_permutation _ listed) big_map big_filter big_enum_cond [RHS]big_mkcondr; apply: eq_big => // d _.
rewrite (profile_at _ _ kL ki) (profile_at _ _ lL lj) /one_unit /bet_on.
case: (boolP dropped) => [drop_|//] /=; congr (if _ then _ else _); apply/idP/forallP => [/andP[si sj] u|]; last by [].
by rewrite (by_design units drop_ i d u (w d)) si (by_design units drop_ j d u (w d)).
Qed.

Lemma count_units : Bets.count (contrasts b es (k, l)) = Z.of_nat #|bet_on_units i j|.
Proof.
have [] := product_units (fun _ _ => 2%:R); set cs := contrasts b es (k, l); rewrite prodr_const => two_ less.
have -> : Bets.count cs = Z.of_nat (\sum_(c <- cs) Z.to_nat (Bets.number c)).
  have onto n : List.fold_left (fun n c => Z.add n (Bets.number c)) cs n = Z.add n (Z.of_nat (\sum_(c <- cs) Z.to_nat (Bets.number c))).
    elim: cs n less {two_} => [|c cs IH] n less /=; first by rewrite big_nil Z.add_0_r.
    rewrite IH => [|d din]; last by apply: less; right.
    by rewrite big_cons Nat2Z.inj_add Z2Nat.id ?Z.add_assoc //; apply: less; left.
  by rewrite /Bets.count onto.
have two_neq1 : (2%:R : R) != 1 by rewrite (eqr_nat R 2 1).
congr Z.of_nat; apply: (ieexprIn (ltr0n R 2) two_neq1); rewrite -two_.
by elim: (cs) => [|c cs' IH]; rewrite ?big_nil // !big_cons exprD IH.
Qed.
End Data.

Lemma wealth_is w b es i j k l r : (forall e, In e es -> Z.lt 0 e.1) -> list_units unit_in seen w b es ->
  (k < size (groups_in b))%N -> (l < size (groups_in b))%N -> seq.nth i (groups_in b) k = i -> seq.nth j (groups_in b) l = j ->
  BetsSound.exact_wealth r (contrasts b es (k, l)) = wealth_of bet_on_units x y bets i j r w.
Proof.
move=> pos listed kL lL ki lj; rewrite /BetsSound.exact_wealth (count_units pos listed kL lL ki lj).
rewrite /wealth_of /wealth size_map big_map; congr (_ / _); apply: eq_bigr => q _.
have [is_ _] := product_units pos listed kL lL ki lj (fun p s => BetsSound.exact_factor r (ratio q) (ratio p) (ratio s)).
exact: is_.
Qed.

(* ---- All ordered pairs ---- *)

Lemma ordered_pairsP n k l : In (k, l) (Bets.ordered_pairs n) <-> [/\ (k < n)%N, (l < n)%N & k <> l].
Proof.
have seqP m : In m (List.seq 0 n) <-> (m < n)%N by rewrite in_seq; split=> [[_]|] h; [apply/ssrnat.ltP|split; [lia|apply/ssrnat.ltP]].
rewrite /Bets.ordered_pairs in_flat_map; split=> [[k' [/seqP k'n /in_flat_map[l' [/seqP l'n]]]]|[/seqP kn /seqP ln kl]].
  by case: Nat.eqb_spec => // kl [] // [<- <-]; split.
by exists k; split=> //; apply/in_flat_map; exists l; split=> //; case: Nat.eqb_spec => // _; left.
Qed.

Variable i0 : groups.
Definition index_pair (b : Z) (kl : nat * nat) : groups * groups := (seq.nth i0 (groups_in b) kl.1, seq.nth i0 (groups_in b) kl.2).
Definition index_pairs (bs : seq Z) : seq (groups * groups) :=
  List.flat_map (fun b => [seq index_pair b kl | kl <- Bets.ordered_pairs (size (groups_in b))]) bs.

Lemma groups_uniq b : uniq (groups_in b).
Proof. by apply/filter_uniq/enum_uniq. Qed.

Lemma index_pairs_compared bs p : In p (index_pairs bs) -> compared context_of p.1 p.2.
Proof.
case/in_flat_map => b [_ /in_map_iff[[k l] [<- /ordered_pairsP[kn ln kl]]]]; rewrite /compared /index_pair.
have := mem_nth i0 kn; have := mem_nth i0 ln; rewrite !mem_filter => /andP[/eqP -> _] /andP[/eqP -> _].
by rewrite eqxx /= nth_uniq ?groups_uniq //; apply/eqP.
Qed.

Lemma index_pairs_all bs i j : In (context_of i) bs -> compared context_of i j -> In (i, j) (index_pairs bs).
Proof.
move=> bin /andP[/eqP same /eqP ij]; apply/in_flat_map; exists (context_of i); split=> //.
have iL : i \in groups_in (context_of i) by rewrite mem_filter eqxx mem_enum.
have jL : j \in groups_in (context_of i) by rewrite mem_filter same eqxx mem_enum.
apply/in_map_iff; exists (index i (groups_in (context_of i)), index j (groups_in (context_of i))).
split; first by rewrite /index_pair !nth_index.
by apply/ordered_pairsP; split; rewrite ?index_mem // => e; apply: ij; rewrite -(nth_index i0 iL) e nth_index.
Qed.

(* The contrasts of a certificate are those of the pairs. *)
Definition related w (cs : seq contrast) (p : groups * groups) : Prop :=
  forall r, BetsSound.exact_wealth r cs = wealth_of bet_on_units x y bets p.1 p.2 r w.

Lemma Forall2_app_map A B (f : A -> seq contrast) (g : A -> B) (rel : seq contrast -> B -> Prop) (s : seq A) t u :
  (forall a, In a s -> rel (f a) (g a)) -> Forall2 rel t u -> Forall2 rel ([seq f a | a <- s] ++ t) ([seq g a | a <- s] ++ u).
Proof.
by move=> all_ tu; elim: s all_ => //= a s IH all_; constructor; [apply: all_; left|apply: IH => b bs; apply: all_; right].
Qed.

Lemma pairs_related w (xs : seq (Z * Bets.context)) ess :
  (forall bx, In bx xs -> Bets.top bx.2 = top_of bx.1 /\ size (Bets.drawn bx.2) = size (groups_in bx.1)) ->
  Forall2 (list_units unit_in seen w) [seq bx.1 | bx <- xs] ess ->
  List.forallb (fun xe : Bets.context * seq Bets.entry => Bets.are_drawn xe.1 xe.2) (List.combine [seq bx.2 | bx <- xs] ess) ->
  Forall2 (related w)
    (List.flat_map (fun xe : Bets.context * seq Bets.entry => Bets.pairs_of dropped xe.1 xe.2) (List.combine [seq bx.2 | bx <- xs] ess))
    (index_pairs [seq bx.1 | bx <- xs]).
Proof.
elim: xs ess => [|[b c] xs IH] ess good.
  by move=> /= F; inversion F.
case: ess => [|es ess] F; first by inversion F.
have {F} [listed F] : list_units unit_in seen w b es /\ Forall2 (list_units unit_in seen w) [seq bx.1 | bx <- xs] ess by inversion F; split.
have [/= topE sizeE] := good _ (or_introl erefl).
move=> /= /andP[drawn_ rest]; rewrite /Bets.pairs_of.
have pos e : In e es -> Z.lt 0 e.1.
  by move=> ein; case/andP: drawn_ => /forallb_forall /(_ e ein) /andP[/Z.ltb_lt].
have -> : length (Bets.drawn c) = size (groups_in b) by rewrite -sizeE.
rewrite topE; apply: (Forall2_app_map (f := contrasts b es)) => [[k l] /ordered_pairsP[kn ln kl] r|].
  by apply: wealth_is => //; apply: set_nth_default.
by apply: IH => // bx bxin; apply: good; right.
Qed.

Lemma block_in (i : groups) : In (context_of i) [seq bx.1 | bx <- Figures.grouped of_block ps].
Proof.
have nonempty : ListsSound.with_key of_block (context_of i) ps <> [::].
  rewrite /ListsSound.with_key; have : List.In (seq.nth (Pool 0 [::] [::]) ps i) ps by rewrite -nth_nth; apply: nth_In; apply/ssrnat.ltP.
  rewrite /BetsMeaning.context_of; move: (seq.nth _ ps i) => q; elim: (ps) => //= p qs IH [->|/IH nonempty]; first by rewrite Z.eqb_refl.
  by case: ifP.
have h := ListsSound.grouped_have nonempty.
by apply/in_map_iff; eexists; split; last exact: h.
Qed.

Lemma related_right w ts us p : Forall2 (related w) ts us -> In p us -> exists2 cs, In cs ts & related w cs p.
Proof.
elim=> // cs q ts' us' rel _ IH [<-|/IH[cs' csin rel']]; first by exists cs; [left|].
by exists cs'; [right|].
Qed.

Lemma related_left w ts us cs : Forall2 (related w) ts us -> In cs ts -> exists2 p, In p us & related w cs p.
Proof.
elim=> // ds q ts' us' rel _ IH [<-|/IH[p pin rel']]; first by exists q; [left|].
by exists p; [right|].
Qed.

Lemma related_sum w ts us r : Forall2 (related w) ts us ->
  (\sum_(cs <- ts) BetsSound.exact_wealth r cs) / (size ts)%:R = mean_of_pairs bet_on_units x y bets us r w.
Proof.
move=> F; rewrite /mean_of_pairs.
have [-> ->] : size ts = size us /\ \sum_(cs <- ts) BetsSound.exact_wealth r cs = \sum_(p <- us) wealth_of bet_on_units x y bets p.1 p.2 r w.
  by elim: F => [|cs p ts' us' rel _ [IHs IH]] /=; rewrite ?big_nil // !big_cons rel IH IHs.
by [].
Qed.

Lemma related_ge0 w cs p (r : R) : related w cs p -> 0 <= r -> 0 <= BetsSound.exact_wealth r cs.
Proof.
by move=> rel r0; rewrite rel /wealth_of; apply: (wealth_ge0 _ (@x1 p.1) (@y0 p.2) (@bets01 p.1 p.2)).
Qed.

Section Accepted.
Variables (w : {ffun D -> U}) (j : Bets.units) (xs : seq (Z * Bets.context)).
Hypotheses (same_drop : Bets.drop j = dropped)
  (blocks : [seq bx.1 | bx <- xs] = [seq bx.1 | bx <- Figures.grouped of_block ps])
  (good : forall bx, In bx xs -> Bets.top bx.2 = top_of bx.1 /\ size (Bets.drawn bx.2) = size (groups_in bx.1))
  (listed : list_all unit_in seen w (Bets.profiles j)) (acc : Bets.accepted j [seq bx.2 | bx <- xs]).

Definition all_pairs : seq (groups * groups) := index_pairs [seq bx.1 | bx <- Figures.grouped of_block ps].

Lemma accepted_parts : [/\ at_most (Bets.confidence j) one, Bets.most_holds j [seq bx.2 | bx <- xs], Bets.least_holds j [seq bx.2 | bx <- xs]
  & Forall2 (related w) (Bets.pairs j [seq bx.2 | bx <- xs]) all_pairs].
Proof.
move: acc => /and5P[_ _ c1 _ /and5P[_ _ drawn_ most_ least_]]; split=> //.
rewrite /all_pairs -blocks /Bets.pairs same_drop; apply: pairs_related => //.
by rewrite blocks; apply: listed.
Qed.

Lemma share_ge0 : 0 <= ratio (Bets.share j) :> R.
Proof.
have [/(at_mostP R) c1 _ _ _] := accepted_parts; rewrite ratio_one in c1.
rewrite /Bets.share ratio_times ratio_plus ratio_minus ratio_one mulr_ge0 ?subr_ge0 //; case: (Bets.each j); rewrite ?ratio_one ?ler01 //.
by apply: ratio_ge0.
Qed.

Lemma upper_won r : Bets.most j = Some r ->
  0 <= ratio r :> R /\ forall i k, compared context_of i k -> 1 <= ratio (Bets.share j) * wealth_of bet_on_units x y bets i k (ratio r) w.
Proof.
move=> most_; have [_ + _ rel] := accepted_parts; rewrite /Bets.most_holds most_ => /andP[/(at_mostP R) r1 /forallb_forall reach].
rewrite ratio_one in r1; have r0 : 0 <= ratio r :> R := le_trans ler01 r1.
split=> // i k c; have [cs csin rel_] := related_right rel (index_pairs_all (block_in i) c).
apply: le_trans (BetsSound.reachesP R (reach cs csin)) _; rewrite ler_wpmul2l ?share_ge0 // -[X in _ <= X]rel_.
by case: (BetsSound.wealth_below r0 (related_ge0 rel_ r0)).
Qed.

Lemma lower_won : ratio (Bets.least j) <= 1 :> R \/
  1 < ratio (Bets.least j) :> R /\
  1 <= ratio (Bets.share j) * mean_of_pairs bet_on_units x y bets all_pairs (ratio (inverse (Bets.least j))) w.
Proof.
have [_ _ + rel] := accepted_parts; case/andP => _; have [le1|gt1] := leP (ratio (Bets.least j)) (1 : R); first by left.
have -> /= : at_most (Bets.least j) one = false by rewrite (at_mostE R) ratio_one leNgt gt1.
move=> reach; right; split=> //.
have gt0 := lt_trans ltr01 gt1.
have r0 : 0 <= ratio (inverse (Bets.least j)) :> R by rewrite ratio_inverse ?(positive_fractionE R) // invr_ge0 ltW.
apply: le_trans (BetsSound.reachesP R reach) _; rewrite ler_wpmul2l ?share_ge0 // -(related_sum _ rel).
have all_below cs : In cs (Bets.pairs j [seq bx.2 | bx <- xs]) ->
    BetsSound.below (Bets.wealth_of (inverse (Bets.least j)) cs) (BetsSound.exact_wealth (ratio (inverse (Bets.least j)) : R) cs).
  by move=> csin; have [p _ rel_] := related_left rel csin; apply: (BetsSound.wealth_below r0 (related_ge0 rel_ r0)).
by case: (BetsSound.below_mean all_below).
Qed.
End Accepted.
End Units.

(* ---- The contexts of a table with other draws ---- *)

Lemma runs_map A B (f : A -> B) (key : B -> Z) s :
  Figures.runs key [seq f a | a <- s] = [seq (ks.1, [seq f a | a <- ks.2]) | ks <- Figures.runs (key \o f) s].
Proof.
elim: s => //= a s ->; case: (Figures.runs (key \o f) s) => //= -[k t] more /=.
by case: ifP.
Qed.

Lemma grouped_map A B (f : A -> B) (key : B -> Z) s :
  Figures.grouped key [seq f a | a <- s] = [seq (ks.1, [seq f a | a <- ks.2]) | ks <- Figures.grouped (key \o f) s].
Proof. by rewrite /Figures.grouped sort_map runs_map. Qed.

Section Contexts.
Variables (ps : list pool) (limits : option (Q * Q)) (ds : list tally).
Hypothesis sizes : size ds = size ps.
Local Notation xs := (contexts_of limits (zip ps ds)).
Local Notation of_draws := (fun z : pool * tally => of_block z.1).

Lemma psE : ps = [seq z.1 | z <- zip ps ds]. Proof. by rewrite -[RHS]/(unzip1 _) unzip1_zip // sizes. Qed.

Lemma blocks_same : [seq bx.1 | bx <- xs] = [seq bx.1 | bx <- Figures.grouped of_block ps].
Proof. by rewrite [in RHS]psE grouped_map /contexts_of -!map_comp. Qed.

Lemma flat_map_map A B C (f : A -> B) (g : B -> seq C) s : List.flat_map g [seq f a | a <- s] = List.flat_map (fun a => g (f a)) s.
Proof. by elim: s => //= a s ->. Qed.

Lemma contexts_good bx : In bx xs -> Bets.top bx.2 = top_of ps limits bx.1 /\ size (Bets.drawn bx.2) = size (groups_in ps bx.1).
Proof.
case/in_map_iff => -[b zs] [<- zin] /=; have [-> _] := (proj2 (ListsSound.groupedP of_draws _)) _ _ zin; rewrite /ListsSound.with_key; split.
  rewrite /top_of; case: (limits) => // ; rewrite [in RHS]psE filter_map flat_map_map //.
rewrite size_map.
have -> : size [seq z <- zip ps ds | Z.eqb (of_block z.1) b] = size [seq p <- ps | Z.eqb (of_block p) b].
  by rewrite [in RHS]psE filter_map size_map.
have psN : ps = [seq seq.nth (Pool 0 [::] [::]) ps (nat_of_ord i) | i <- enum 'I_(size ps)].
  by rewrite -[RHS]/(map (seq.nth (Pool 0 [::] [::]) ps \o @nat_of_ord _) _) map_comp val_enum_ord map_nth_iota0 // take_size.
by rewrite [in LHS]psN filter_map size_map.
Qed.
End Contexts.

(* ---- The interval ---- *)

Lemma combine_zip A B (s : seq A) (t : seq B) : List.combine s t = zip s t.
Proof. by elim: s t => [|a s IH] [|b t] //=; rewrite IH. Qed.

Lemma all_of_size A B (f : A -> option B) s t : all_of f s = Some t -> size t = size s.
Proof. by elim: s t => [|a s IH] t /=; [case=> <-|case: (f a) => // b; case: (all_of f s) IH => // u IH [<-] /=; rewrite (IH u)]. Qed.

Lemma draws_in_size i ps ds : draws_in i ps = Some ds -> size ds = size ps.
Proof.
rewrite /draws_in; case: (Bets.rows i) => [uss|[<-]]; last exact: size_map.
case: Nat.eqb_spec => // same; move/all_of_size ->; rewrite combine_zip size_zip.
by have -> : size uss = size ps := same; rewrite minnn.
Qed.

Section Holds.
Variables (R : realFieldType) (ps : list pool) (i : Bets.units) (D U : finType) (unit_in : Z -> pred D).
Variables (gets : 'I_(size ps) -> D -> U -> R) (seen : 'I_(size ps) -> D -> U -> option Q) (P : D -> U -> R) (E : 'I_(size ps) -> R).
Hypothesis units : are_units (Bets.limits i) unit_in gets seen (Bets.drop i) P E.
Variable i0 : 'I_(size ps).
Hypothesis c1 : at_most (Bets.confidence i) one.

Local Notation alpha := (ratio (Bets.share i) : R).
Local Notation above := (fun j => ~ ratio_at_most E (Bets.most j)).
Local Notation below := (fun j => ~ ratio_at_least E (Bets.least j)).
Local Notation bet_on := (bet_on_units (Bets.limits i) unit_in seen (Bets.drop i)).
Local Notation xs := (@x R ps (Bets.limits i) D U seen).
Local Notation ys := (@y R ps (Bets.limits i) D U seen).
Local Notation bets := (@bets R ps (Bets.limits i) D U unit_in seen (Bets.drop i)).
Local Notation means := (scaled (Bets.limits i) E).
Local Notation pairs := (all_pairs i0).

Lemma share_same j : alike i j -> Bets.share j = Bets.share i.
Proof. by case=> c e _ _; rewrite /Bets.share c e. Qed.

Lemma alpha_ge0 : 0 <= alpha.
Proof.
have := at_mostP R c1; rewrite ratio_one => c1'.
rewrite /Bets.share ratio_times ratio_plus ratio_minus ratio_one mulr_ge0 ?subr_ge0 //; case: (Bets.each i); rewrite ?ratio_one ?ler01 //.
by apply: ratio_ge0.
Qed.

Section Mislead.
Variables (w : {ffun D -> U}) (j : Bets.units) (ds : seq tally).
Hypotheses (same : alike i j) (sizes : size ds = size ps) (listed : list_all unit_in seen w (Bets.profiles j)) (proved_ : proved_by_units j (zip ps ds)).

Lemma accepted_j : Bets.accepted j [seq bx.2 | bx <- contexts_of (Bets.limits i) (zip ps ds)].
Proof. by move: proved_; rewrite /proved_by_units; case: same => _ _ _ ->; case: (zip ps ds). Qed.

Lemma wrong_above : ~ ratio_at_most E (Bets.most j) -> proves_wrong_upper (@context_of ps) means bet_on xs ys bets alpha w.
Proof.
case most_: (Bets.most j) => [r|] wrong; last by case: wrong.
have [_ _ same_drop _] := same.
have [r0 won_] := upper_won units i0 same_drop (blocks_same (Bets.limits i) sizes) (contexts_good (limits := Bets.limits i) sizes) listed accepted_j most_.
exists (ratio r); split=> // [all_|a b c]; last by rewrite -(share_same same); apply: won_.
by apply: wrong => a b c; rewrite -(same_ratio (Bets.limits i) E _ c); have := all_ a b c; rewrite /Coverage.E !mulr1.
Qed.

Lemma wrong_below : ~ ratio_at_least E (Bets.least j) -> proves_wrong_lower (@context_of ps) means bet_on xs ys bets alpha pairs w.
Proof.
move=> wrong; have [_ _ same_drop _] := same.
have [le1|[gt1 won_]] := lower_won units i0 same_drop (blocks_same (Bets.limits i) sizes) (contexts_good (limits := Bets.limits i) sizes) listed accepted_j.
  by case: wrong; left.
have gt0 := lt_trans ltr01 gt1.
have inv_ : ratio (inverse (Bets.least j)) = (ratio (Bets.least j))^-1 :> R by rewrite ratio_inverse // (positive_fractionE R).
exists (ratio (inverse (Bets.least j))); split; [by rewrite inv_ invr_gt0| |by rewrite -(share_same same)].
case=> a [b [c le pos]]; apply: wrong; right; exists a, b; move: le pos; rewrite /Coverage.E !mulr1 inv_ => le pos.
have c' : compared (@context_of ps) b a by rewrite compared_sym.
split=> //; first by move: le; rewrite (same_ratio (Bets.limits i) E _ c') ler_pdivl_mull.
move: pos; rewrite /scaled; case: ifP => // p; rewrite pmulr_lgt0 // invr_gt0; exact: ratio_gt0.
Qed.
End Mislead.

Lemma interval_holds :
  if Bets.each i then seldom unit_in seen P i above /\ seldom unit_in seen P i below
  else seldom unit_in seen P i (fun j => above j \/ below j).
Proof.
have E0 := scaled_ge0 units; have x1_ := x1 units; have y0_ := y0 units; have means_ := scaled_means units.
have bets01_ a b := @bets01 R ps (Bets.limits i) D U unit_in seen (Bets.drop i) a b.
have laws : kernel P := each_law units.
have compared_ p : p \in pairs -> compared (@context_of ps) p.1 p.2.
  move=> pin; apply: (@index_pairs_compared ps i0 [seq bx.1 | bx <- Figures.grouped of_block ps]).
  by move: pin; rewrite /all_pairs; elim: (index_pairs _ _) => //= q qs IH; rewrite in_cons => /orP[/eqP ->|/IH]; [left|right].
have alphaE : if Bets.each i then alpha = 1 - ratio (Bets.confidence i) else alpha + alpha = 1 - ratio (Bets.confidence i).
  rewrite /Bets.share ratio_times ratio_plus ratio_minus ratio_one; case: (Bets.each i) => /=; first by rewrite (ratio_one R) mulr1.
  have -> : ratio Bets.half = 2%:R^-1 :> R by rewrite /FractionsSound.ratio /= embed1 mul1r.
  by rewrite -splitr.
case: (Bets.each i) alphaE => alphaE; [split|] => S all_; rewrite -alphaE.
- apply: (bets_upper laws E0 x1_ y0_ bets01_ means_ alpha_ge0) => w /all_[j [ds [same sizes listed proved_ wrong]]].
  exact: (wrong_above same sizes listed proved_ wrong).
- apply: (bets_lower laws E0 x1_ y0_ bets01_ means_ alpha_ge0 compared_) => w /all_[j [ds [same sizes listed proved_ wrong]]].
  exact: (wrong_below same sizes listed proved_ wrong).
- apply: (bets_together laws E0 x1_ y0_ bets01_ means_ alpha_ge0 compared_) => w /all_[j [ds [same sizes listed proved_ [wrong|wrong]]]].
    by left; exact: (wrong_above same sizes listed proved_ wrong).
  by right; exact: (wrong_below same sizes listed proved_ wrong).
Qed.
End Holds.

Theorem bets_sound (R : realFieldType) T local i : judged_by_draws T local (By_bets i) = Some true -> local /\ bets_hold R T i.
Proof.
rewrite /judged_by_draws; case pools: (pools_of T local) => [ps|] //; case: local pools => // pools.
rewrite /judged_by_units; case: ifP => // _ [] /andP[_].
case drawn_: (draws_in i ps) => [ds|] //; rewrite combine_zip => proved_; split=> //; exists ps, ds.
split=> //; first exact: draws_in_size drawn_.
move=> D U unit_in gets seen P E units.
have acc : exists xs, Bets.accepted i xs /\ ps <> [::].
  by move: proved_; rewrite /proved_by_units; case: (ps) (ds) => [|p ps'] [|d ds'] //= acc; eexists; split; first exact: acc.
have [xs [/and5P[_ _ c1 _ _] nonempty]] := acc.
have i0 : 'I_(size ps) by case: (ps) nonempty => // p ps' _; exact: ord0.
exact: interval_holds units i0 c1.
Qed.
