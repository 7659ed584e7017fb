(* The program of Pairs.v is right: what it accepts misses the truth at most with the probability that is said.

   Reading key.  Cells, data and samples are those of ChanceSound.v; cells are independent. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.algebra_tactics Require Import ring.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditKernel Require WorstCase.
From FairauditChecker Require Import Chance ChanceSound TailsSound Pairs PairLadderSound.
From FairauditChecker Require Figures PairLaw.
From Fairaudit Require Import Definitions Binomial Draws Ends Coverage PairExact PairInterval.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- Lists ---- *)

Lemma size_numbered A n (xs : seq A) : size (WorstCase.numbered n xs) = size xs.
Proof. by elim: xs n => //= x xs IH n; rewrite IH. Qed.

Lemma nth_numbered A (x0 : A) k xs i : (i < size xs)%N ->
  nth (Z0, x0) (WorstCase.numbered (Z.of_nat k) xs) i = (Z.of_nat (k + i), nth x0 xs i).
Proof.
elim: xs k i => // x xs IH k [|i] /=; first by rewrite addn0.
by rewrite ltnS addnS -addSn => /(IH k.+1) <-; congr nth; congr WorstCase.numbered; lia.
Qed.

Section Ordered.
Variables (A : Type) (block_of index : A -> Z).

Lemma in_runs xs x : List.In x xs -> exists ys, List.In (block_of x, ys) (Figures.runs block_of xs) /\ List.In x ys.
Proof.
elim: xs => //= y xs IH [->|/IH[ys]].
  case: (Figures.runs block_of xs) => [|[k zs] more]; first by exists [:: x]; split; left.
  by case: ifP => [/Z.eqb_eq ->|_]; [exists (x :: zs) | exists [:: x]]; split; left.
case: (Figures.runs block_of xs) => [|[k zs] more] /=; first by case.
case=> -[[<- <-]|kin] xin; case: ifP => [/Z.eqb_eq e|_].
- by exists (y :: zs); split; [left | right].
- by exists zs; split; [right; left|].
- by exists ys; split; [right|].
- by exists ys; split; [right; right|].
Qed.

Lemma same_run (rs : seq (Z * seq A)) k ys zs : uniq (map fst rs) -> List.In (k, ys) rs -> List.In (k, zs) rs -> ys = zs.
Proof.
have there k' us (rs' : seq (Z * seq A)) : List.In (k', us) rs' -> k' \in map fst rs'.
  by elim: rs' => //= r rs' IH [->|/IH]; rewrite inE ?eqxx // => ->; rewrite orbT.
elim: rs => //= -[k' us] rs IH /andP[new u] [[ek eu]|yin] [[fk fu]|zin].
- by rewrite -eu -fu.
- by case/negP: new; rewrite ek; apply: there zin.
- by case/negP: new; rewrite fk; apply: there yin.
- exact: IH.
Qed.

Lemma in_ordered xs x y : in_blocks block_of xs -> List.In x xs -> List.In y xs -> block_of x = block_of y -> index x <> index y ->
  List.In (x, y) (ordered block_of index xs).
Proof.
rewrite /in_blocks strictly_risingE => rise /in_runs[ys [yin xys]] /in_runs[zs [zin yzs]] e ne.
have tr : transitive Z.ltb by move=> a b c /Z.ltb_lt ? /Z.ltb_lt ?; apply/Z.ltb_lt; lia.
have irr : irreflexive Z.ltb by move=> a; apply/negP => /Z.ltb_lt; lia.
rewrite -e in zin; have ez := same_run (sorted_uniq tr irr rise) yin zin.
apply/in_flat_map; exists (block_of x, ys); split=> //; apply/in_flat_map; exists x; split=> //.
apply/in_map_iff; exists y; split=> //; apply/filter_In; split; first by rewrite ez.
by case: Z.eqb_spec.
Qed.
End Ordered.

Lemma all_belowP A (f : A -> list Q -> bool) xs ladders x : all_below f xs ladders -> List.In x xs -> exists knots, f x knots.
Proof. by elim: xs ladders => // y xs IH [|l ladders] //= /andP[one rest] [<-|/(IH _ rest)] //; exists l. Qed.

Lemma in_mem (A : eqType) (x : A) xs : List.In x xs -> x \in xs.
Proof. by elim: xs => //= y xs IH [->|/IH]; rewrite inE ?eqxx // => ->; rewrite orbT. Qed.

Section Sound.
Variables (R : realFieldType) (W : finType) (N : nat).
Variables (P : W -> R) (count : 'I_N -> W -> nat) (n : 'I_N -> nat) (p : 'I_N -> R) (blk : 'I_N -> Z) (v : 'I_N -> Q).
Local Notation ratio := (@ratio R).
Local Notation val i := (ratio (v i)).
Local Notation samples := (samples count n blk v).
Local Notation sample_of := (ChanceSound.sample_of count n blk v).

Hypotheses (lawP : law P) (p01 : forall i, 0 <= p i <= 1) (drawn : counted P count n p) (independent_ : independent_counts P count).

Let s0 : sample := Sample 0 0 0 zero.

Lemma nth_cells w (i : 'I_N) : nth (Z0, s0) (WorstCase.numbered 0 (samples w)) i = (Z.of_nat i, sample_of w i).
Proof. by rewrite (@nth_numbered _ s0 0) ?size_samples // nth_samples. Qed.

(* How many pairs are compared depends on the blocks alone. *)
Definition numbered_blocks : seq (Z * Z) := WorstCase.numbered 0 [seq blk i | i <- enum 'I_N].

Lemma blocksE w : blocks_of (samples w) = numbered_blocks.
Proof. by rewrite /blocks_of -[List.map _ _]/(map block (samples w)) -map_comp. Qed.

Definition pair_count : Z := Z.of_nat (length (ordered snd fst numbered_blocks)).

Lemma compared_count : in_blocks snd numbered_blocks -> (#|[set ij : 'I_N * 'I_N | compared blk ij.1 ij.2]| <= Z.to_nat pair_count)%N.
Proof.
move=> rise; rewrite /pair_count Nat2Z.id -[length _]/(size (ordered snd fst numbered_blocks)).
have size_blocks : size [seq blk i | i <- enum 'I_N] = N by rewrite size_map size_enum_ord.
have block_in (i : 'I_N) : List.In (Z.of_nat i, blk i) numbered_blocks.
  rewrite (_ : (Z.of_nat i, blk i) = nth (Z0, Z0) numbered_blocks i).
    by apply: ChanceSound.in_nth; rewrite size_numbered size_blocks.
  by rewrite (@nth_numbered _ Z0 0) ?size_blocks // (nth_map i) ?size_enum_ord // nth_ord_enum.
pose f (ij : 'I_N * 'I_N) := ((Z.of_nat ij.1, blk ij.1), (Z.of_nat ij.2, blk ij.2)).
have inj : injective f.
  by move=> [i j] [k l] [/Nat2Z.inj/val_inj-> _ /Nat2Z.inj/val_inj-> _].
rewrite cardE -(size_map f); apply: uniq_leq_size; first by rewrite (map_inj_uniq inj) enum_uniq.
move=> x /mapP[[i j]]; rewrite mem_enum inE /= => /andP[/eqP e ne] ->; apply: in_mem; apply: in_ordered => //=.
by move/Nat2Z.inj/val_inj => eij; move: ne; rewrite eij eqxx.
Qed.

(* What is settled before the draws *)
Definition alike (i j : by_pairs) : Prop := sure_at j = sure_at i /\ one_by_one j = one_by_one i.

Lemma alike_error i j : alike i j -> error j = error i /\ share j = share i.
Proof. by case=> c e; rewrite /share /error c e. Qed.

Lemma is_belowP z2 w (i j : 'I_N) r level knots : 0 < val i ->
  is_below r level (Scored (Z.of_nat i) (sample_of w i) (PairLaw.scores (Z.of_nat (n i)) z2), Scored (Z.of_nat j) (sample_of w j) (PairLaw.scores (Z.of_nat (n j)) z2)) knots ->
  pair_proves count n (fun i j => order (n i) (n j) z2) (ratio level) (ratio (PairLaw.guard_of level)) i j (ratio r * val j / val i) w.
Proof.
move=> vi /(@ladder_accepted_sound R (n i) (n j) (count i w) (count j w) z2)[x [qs []]].
rewrite ratio_times ratio_times ratio_inverse ?(positive_fractionE R) //= mulrA => r0 lad.
by exists x, qs; split.
Qed.

Section Settled.
Variable i : by_pairs.
Hypothesis c1 : ratio (sure_at i) <= 1.

Lemma errorE : ratio (error i) = 1 - ratio (sure_at i). Proof. exact: rest_ofE. Qed.

Lemma halfE : ratio (Qmake 1 2) = 1 / 2%:R. Proof. by rewrite /FractionsSound.ratio /= embed1 (embed_nat R 2). Qed.

Lemma share_ge0 : 0 <= ratio (share i).
Proof.
have e0 : 0 <= ratio (error i) by rewrite errorE subr_ge0.
rewrite /share; case: (one_by_one i) => //; rewrite ratio_times halfE; apply: mulr_ge0 => //.
by rewrite divr_ge0 ?ler01 ?ler0n.
Qed.

Lemma guard_ok level : 0 <= ratio level -> 0 <= ratio (PairLaw.guard_of level) /\ ratio (PairLaw.guard_of level) <= ratio level.
Proof. by move/guard_small/andP. Qed.

Lemma accepted_worth j w : pairs_accepted j (samples w) -> forall k, 0 < val k.
Proof.
case/and5P=> _ /List.forallb_forall all_ _ _ _ k; rewrite -(positive_fractionE R).
have := all_ (sample_of w k); apply; rewrite -(nth_samples count n blk v).
by apply: ChanceSound.in_nth; rewrite size_samples.
Qed.

Theorem upper_misses (S : {set W}) :
  (forall w, w \in S -> exists j, [/\ alike i j, pairs_accepted j (samples w) & ~ most_true p blk v (highest j)]) -> prob P S <= ratio (share i).
Proof.
move=> all_w; have [->|[w0 w0S]] := set_0Vmem S; first by rewrite /prob big_set0 share_ge0.
have [j0 [_ acc0 _]] := all_w w0 w0S; have worth0 := accepted_worth acc0.
have [g0 gl] := guard_ok share_ge0; pose z2 := PairLaw.order_scale (error i).
apply: (pairs_upper (worth := fun k => val k) (block := blk) (first := fun k l => order (n k) (n l) z2) lawP p01 worth0 drawn independent_
  (fun k l => @order_total (n k) (n l) z2) (fun k l => @order_transitive (n k) (n l) z2) (fun k l => @order_staircase (n k) (n l) z2) g0 gl).
move=> w /all_w[j [/alike_error[e1 e2] acc wrong]]; case/and5P: acc => _ _ _ _ /and5P[_ _ _ up _].
move: up wrong; rewrite /upper_proved /most_true; case: (highest j) => [r|]; last by case: (upper_ladders j) => // _ [].
case: (upper_ladders j) => // ladders; rewrite e1 e2 -/z2 => /and3P[/(at_mostP R) r1 rise below] wrong.
exists (ratio r); split=> //; split; first by apply: le_trans r1; rewrite ratio_one ler01.
move=> k l /andP[/eqP e ne].
pose scored_ (h : 'I_N) := Scored (Z.of_nat h) (sample_of w h) (PairLaw.scores (Z.of_nat (n h)) z2).
have there h : List.In (scored_ h) (scored_cells z2 (samples w)).
  apply/in_map_iff; exists (Z.of_nat h, sample_of w h); split=> //; rewrite -nth_cells.
  by apply: ChanceSound.in_nth; rewrite size_numbered size_samples.
have kl : List.In (scored_ k, scored_ l) (ordered Pairs.block_of its_number (scored_cells z2 (samples w))).
  by apply: in_ordered => //= /Nat2Z.inj/val_inj kl; move: ne; rewrite kl eqxx.
by have [knots below_] := all_belowP below kl; apply: is_belowP below_.
Qed.

Theorem lower_misses (S : {set W}) :
  (forall w, w \in S -> exists j, [/\ alike i j, pairs_accepted j (samples w) & ~ least_true p blk v (Some (lowest j))]) -> prob P S <= ratio (share i).
Proof.
move=> all_w; have [->|[w0 w0S]] := set_0Vmem S; first by rewrite /prob big_set0 share_ge0.
have [j0 [_ acc0 _]] := all_w w0 w0S; have worth0 := accepted_worth acc0.
case/and5P: acc0 => _ _; rewrite blocksE => rise; rewrite /how_many_pairs blocksE -/pair_count => M0 _.
pose level := part_of_pair pair_count (share i); pose z2 := PairLaw.order_scale (part_of_pair pair_count (error i)).
have M0' : 0 < embed pair_count :> R by apply: embed_gt0.
have levelE : ratio level = ratio (share i) / embed pair_count.
  by rewrite /level /part_of_pair ratio_times ratio_inverse ?numberE.
have level0 : 0 <= ratio level by rewrite levelE divr_ge0 ?share_ge0 // ltW.
have [g0 gl] := guard_ok level0.
apply: (@le_trans _ _ (#|[set ij : 'I_N * 'I_N | compared blk ij.1 ij.2]|%:R * ratio level)); last first.
  apply: (@le_trans _ _ (embed pair_count * ratio level)); last by rewrite levelE mulrCA divff ?mulr1 // gt_eqF.
  rewrite ler_wpmul2r // (_ : embed pair_count = (Z.to_nat pair_count)%:R); first by rewrite ler_nat compared_count.
  by rewrite -(embed_nat R) Z2Nat.id //; move/Z.ltb_lt: M0; lia.
apply: (pairs_lower (worth := fun k => val k) (block := blk) (first := fun k l => order (n k) (n l) z2) lawP p01 worth0 drawn independent_
  (fun k l => @order_total (n k) (n l) z2) (fun k l => @order_transitive (n k) (n l) z2) (fun k l => @order_staircase (n k) (n l) z2) g0 gl).
move=> w /all_w[j [/alike_error[e1 e2] acc wrong]]; case/and5P: acc => _ _ _ _ /and5P[_ _ _ _].
rewrite /how_many_pairs blocksE -/pair_count /lower_proved e1 e2 -/level -/z2.
case: (lower_ladder j) => [[[x y] knots]|]; last by case/andP=> /(at_mostP R); rewrite ratio_one => low _; case: wrong; left.
case ex: (cell_at _ x) => [c|] //; case ey: (cell_at _ y) => [d|] //.
have [x' [lt_x xE cE]] := cell_atE (Z0, s0) ex; have [y' [lt_y yE dE]] := cell_atE (Z0, s0) ey.
move: lt_x lt_y; rewrite size_numbered size_samples => lt_x lt_y; pose k := Ordinal lt_x; pose l := Ordinal lt_y.
rewrite cE dE -[x']/(nat_of_ord k) -[y']/(nat_of_ord l) !nth_cells => /and4P[/negP ne /Z.eqb_eq e].
rewrite (at_mostE R) -ltNge ratio_one => gt1 below.
exists (ratio (lowest j))^-1; split; last by move=> least_; apply: wrong; right.
exists k, l; split; last first.
  rewrite -ratio_inverse; first exact: is_belowP below.
  by rewrite (positive_fractionE R) (lt_trans ltr01).
rewrite /compared; apply/andP; split; first exact/eqP.
by apply/eqP => kl; apply: ne; apply/Z.eqb_eq; rewrite xE yE; move/(congr1 (@nat_of_ord N)): kl => /= ->.
Qed.

Theorem either_misses (S : {set W}) : ~~ one_by_one i ->
  (forall w, w \in S -> exists j, [/\ alike i j, pairs_accepted j (samples w) & ~ most_true p blk v (highest j) \/ ~ least_true p blk v (Some (lowest j))]) ->
  prob P S <= ratio (error i).
Proof.
move=> together all_w.
have [f fP] : exists f : W -> bool, forall w, w \in S -> exists j, [/\ alike i j, pairs_accepted j (samples w) &
    if f w then ~ most_true p blk v (highest j) else ~ least_true p blk v (Some (lowest j))].
  apply: (@fin_all_exists W (fun=> bool) (fun w b => w \in S -> exists j, [/\ alike i j, pairs_accepted j (samples w) &
    if b then ~ most_true p blk v (highest j) else ~ least_true p blk v (Some (lowest j))])) => w.
  case: (boolP (w \in S)) => [/all_w[j [al acc [up|low]]]|_]; [by exists true; exists j | by exists false; exists j | by exists true].
have -> : ratio (error i) = ratio (share i) + ratio (share i).
  by rewrite /share (negbTE together) ratio_times halfE -mulrDr -mulrDl -[1 + 1]/(2%:R) divff ?mulr1 // pnatr_eq0.
rewrite /prob (bigID f) /=; apply: ler_add.
  rewrite (eq_bigl (fun w => w \in [set w in S | f w])) => [|w]; last by rewrite inE.
  by apply: upper_misses => w; rewrite inE => /andP[/fP[j [al acc wrong]] fw]; exists j; rewrite fw in wrong.
rewrite (eq_bigl (fun w => w \in [set w in S | ~~ f w])) => [|w]; last by rewrite inE.
by apply: lower_misses => w; rewrite inE => /andP[/fP[j [al acc wrong]] /negbTE fw]; exists j; rewrite fw in wrong.
Qed.
End Settled.
End Sound.
