(* The program of Chance.v is right: what it accepts misses the truth at most with the probability that is said.

   Reading key.  There are N cells; the i-th is of block [blk i], has [n i] draws, each worth [ratio (v i)] with the probability p i and
   nothing else.  The data are w, of which [count i w] draws of cell i are worth something; [samples w] is what the program is given of
   them.  W is any finite set of data and P any law of them by which the counts are binomial; theories/Draws.v says when they are. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions Binomial Draws Ends Coverage.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Tails TailsSound LargeTails LargeTailsSound Chance.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Lemma uniq_map_eq (A B : eqType) (f : A -> B) (xs : seq A) x y : uniq (map f xs) -> x \in xs -> y \in xs -> f x = f y -> x = y.
Proof.
elim: xs => //= z xs IH /andP[new u]; rewrite !inE => /orP[/eqP->|xin] /orP[/eqP->|yin] // e; last exact: IH.
  by move: new; rewrite e map_f.
by move: new; rewrite -e map_f.
Qed.

Lemma sub_nat a b : (b <= a)%N -> Z.sub (Z.of_nat a) (Z.of_nat b) = Z.of_nat (a - b).
Proof. by move=> ba; lia. Qed.

Lemma sub_twice a b : (b <= a)%N -> Z.sub (Z.mul 2 (Z.of_nat a)) (Z.of_nat b) = Z.of_nat (2 * a - b).
Proof. by move=> ba; lia. Qed.

Lemma with_rest_in r x xs y : with_rest r x xs -> all_within r xs -> List.In y xs ->
  Z.le x.1 y.1 /\ (x.1 = y.1 -> within r x.2 y.2 /\ within r y.2 x.2).
Proof.
elim: xs x => //= z xs IH x; case: ifP => [/Z.eqb_eq e /and3P[xz zx wx] /andP[wz ws]|_ /Z.ltb_lt lt /andP[wz ws]] [<-|iny].
- by split; [lia | ].
- exact: IH.
- by split; lia.
- by have [le _] := IH z wz ws iny; split; lia.
Qed.

Lemma in_nth A (x0 : A) xs i : (i < size xs)%N -> List.In (nth x0 xs i) xs.
Proof. by elim: xs i => // x xs IH [|i] /=; [left | rewrite ltnS => lt; right; apply: IH]. Qed.

Lemma all_within_nth r x0 xs i j : all_within r xs -> (i < j < size xs)%N -> (nth x0 xs i).1 = (nth x0 xs j).1 ->
  within r (nth x0 xs i).2 (nth x0 xs j).2 /\ within r (nth x0 xs j).2 (nth x0 xs i).2.
Proof.
elim: xs i j => [|x xs IH] i j; first by rewrite ltn0 andbF.
case: j => // j /= /andP[wx ws]; case: i => [|i] /andP[ij js] /=; last by apply: IH => //; apply/andP.
by have [_] := with_rest_in wx ws (in_nth x0 js).
Qed.

Lemma nth_combine A B (a0 : A) (b0 : B) xs ys i : size xs = size ys -> nth (a0, b0) (List.combine xs ys) i = (nth a0 xs i, nth b0 ys i).
Proof. by elim: xs ys i => [|x xs IH] [|y ys] // [|i] //= [] /IH. Qed.

Lemma size_combine A B (xs : seq A) (ys : seq B) : size xs = size ys -> size (List.combine xs ys) = size xs.
Proof. by elim: xs ys => [|x xs IH] [|y ys] //= [] /IH ->. Qed.

Lemma cell_atE A (x0 : A) xs z x : cell_at xs z = Some x -> exists i, [/\ (i < size xs)%N, z = Z.of_nat i & x = nth x0 xs i].
Proof.
elim: xs z => //= y xs IH z; case: ifP => [/Z.eqb_eq -> [<-]|_ /IH[i [lt e ->]]]; first by exists 0%N.
by exists i.+1; split=> //; lia.
Qed.

Lemma power_positive d z : exists d', power (Zpos d) z = Zpos d'.
Proof.
case: z => [|e|e] /=; [by exists xH | | by exists xH].
elim: e => [e [d' /= ->]|e [d' /= ->]|]; [by exists (d * (d' * d'))%positive | by exists (d' * d')%positive | by exists d].
Qed.

Section Levels.
Variable R : realFieldType.
Local Notation ratio := (@ratio R).

Lemma rest_ofE q : ratio (rest_of q) = 1 - ratio q.
Proof. by rewrite ratio_plus ratio_one ratio_minus. Qed.

Lemma numberE z : ratio (number z) = embed z.
Proof. by rewrite /FractionsSound.ratio /= embed1 divr1. Qed.

Lemma to_theE q m : ratio (to_the q (Z.of_nat m)) = ratio q ^+ m.
Proof.
rewrite /to_the; have [d e] := power_positive (Qden q) (Z.of_nat m); rewrite e /FractionsSound.ratio /= expr_div_n -!embed_power.
by rewrite e.
Qed.

Lemma affordableE c (ind : bool) K k u l : (k <= K)%N -> affordable c ind (Z.of_nat K) (Z.of_nat k) u l ->
  k%:R * ratio u + (2 * K - k)%:R * ratio l <= 1 - ratio c \/
  [/\ ind, ratio u + ratio l <= 1 & 1 - (1 - ratio u - ratio l) ^+ k * (1 - 2%:R * ratio l) ^+ (K - k) <= 1 - ratio c].
Proof.
move=> kK; rewrite /affordable => /orP[sum|/and4P[ci ul _ product]]; [left | right].
  move: (at_mostP R sum); rewrite !ratio_plus !ratio_times ratio_one !numberE (sub_twice kK) !embed_nat.
  by rewrite ler_subr_addr.
move: (ratio_gt0 R ul) (at_mostP R product); rewrite ratio_times (sub_nat kK) !to_theE !rest_ofE !ratio_plus subr_gt0 => /ltW ul' le_c.
split=> //; rewrite ler_add2l ler_opp2 (le_trans le_c) // opprD addrA mulr_natl mulr2n //.
Qed.
End Levels.

Section Sound.
Variables (R : realFieldType) (W : finType) (N : nat).
Variables (P : W -> R) (count : 'I_N -> W -> nat) (n : 'I_N -> nat) (p : 'I_N -> R) (blk : 'I_N -> Z) (v : 'I_N -> Q).
Local Notation ratio := (@ratio R).
Local Notation val i := (ratio (v i)).

Definition sample_of w i : sample := Sample (blk i) (Z.of_nat (n i)) (Z.of_nat (count i w)) (v i).
Definition samples w : list sample := [seq sample_of w i | i <- enum 'I_N].

(* What an interval says of the true ratio. *)
Definition most_true (r : option Q) : Prop :=
  if r is Some r then at_most_ratio p (fun i => val i) blk (ratio r) else True.
Definition least_true (r : option Q) : Prop :=
  if r is Some r then ratio r <= 1 \/ at_least_ratio p (fun i => val i) blk (ratio r)^-1 else at_least_ratio p (fun i => val i) blk 0.

Hypotheses (lawP : law P) (p01 : forall i, 0 <= p i <= 1) (worth0 : forall i, nonnegative (v i)) (drawn : counted P count n p).

Let s0 : sample := Sample 0 0 0 zero.
Let e0 : ends := (zero, zero).

Lemma val_ge0 i : 0 <= val i. Proof. exact: ratio_ge0 (worth0 i). Qed.

Lemma size_samples w : size (samples w) = N.
Proof. by rewrite size_map size_enum_ord. Qed.

Lemma nth_samples w (i : 'I_N) : nth s0 (samples w) i = sample_of w i.
Proof. by rewrite (nth_map i) ?size_enum_ord // nth_ord_enum. Qed.

Lemma informativeE w i : Chance.informative (sample_of w i) = Coverage.informative n (fun i => val i) i.
Proof.
rewrite /Chance.informative /Coverage.informative /= (positive_fractionE R); congr (_ && _).
by case: (n i).
Qed.

Lemma part_ofE s q : positive_fraction (worth s) -> ratio (part_of s q) = ratio q / ratio (worth s).
Proof. by move=> w0; rewrite ratio_times ratio_inverse. Qed.

Lemma zeroE q : nonnegative q -> at_most q zero -> ratio q = 0.
Proof. by rewrite (nonnegativeE R) (at_mostE R) ratio_zero => q0 q1; apply/eqP; rewrite eq_le q0 q1. Qed.

Lemma all_hold_nth level ss es : all_hold level ss es ->
  size es = size ss /\ forall i, (i < size ss)%N -> ends_hold level (nth s0 ss i) (nth e0 es i).
Proof.
elim: ss es => [|s ss IH] [|e es] //= /andP[hold /IH[se all_i]]; split; first by rewrite se.
by case=> [|i] //; rewrite ltnS; apply: all_i.
Qed.

Lemma box_of level w es : all_hold level (samples w) es ->
  size es = N /\ box count n (fun i => val i) (ratio level) w (fun i => ratio (nth e0 es i).1) (fun i => ratio (nth e0 es i).2).
Proof.
case/all_hold_nth; rewrite size_samples => se all_i; split=> // i.
have := all_i i (ltn_ord i); rewrite nth_samples; case: (nth e0 es i) => lo hi /= /and4P[lo0 lohi hiv].
have kn : (count i w <= n i)%N by case: (drawn i).
have lo0' := ratio_ge0 R lo0; have lohi' := at_mostP R lohi; have hiv' := at_mostP R hiv.
have full : at_most (v i) hi -> ratio hi = val i by move=> /(at_mostP R) vhi; apply/eqP; rewrite eq_le hiv' vhi.
case: ifP => [/andP[_ v0]|_] /andP[].
  move=> below above; have v0' := ratio_gt0 R v0.
  have p01' q : 0 <= ratio q <= val i -> 0 <= ratio q / val i <= 1.
    by case/andP=> q0 q1; rewrite divr_ge0 ?val_ge0 //= ler_pdivr_mulr // mul1r.
  split=> //.
    case/orP: below => [/(zeroE lo0)|] tail; first by left.
    right; rewrite at_least_flip //.
    have := tail_holds_sound (leq_subr (count i w) (n i)) (p := rest_of (part_of (sample_of w i) lo)) (R := R) (level := level).
    rewrite rest_ofE part_ofE //= subr_ge0 ler_subl_addr ler_addl andbC.
    apply; first by apply: p01'; rewrite lo0' (le_trans lohi').
    by move: tail; rewrite /excluded_below [draws _]/= [successes _]/= (sub_nat kn).
  case/orP: above => [/full|] tail; first by left.
  right; have := tail_holds_sound kn (p := part_of (sample_of w i) hi) (R := R) (level := level).
  by rewrite part_ofE //=; apply=> //; apply: p01'; rewrite (le_trans lo0').
by move=> /(zeroE lo0) low /full high; split=> //; left.
Qed.

(* ---- How many cells ---- *)

Let K := #|[set i | Coverage.informative n (fun i => val i) i]|.

Lemma filterE w : filter Chance.informative (samples w) = [seq sample_of w i | i <- enum 'I_N & Coverage.informative n (fun i => val i) i].
Proof. by rewrite /samples filter_map; congr (map _ _); apply: eq_filter => i /=; rewrite informativeE. Qed.

Lemma usedE w : used (samples w) = Z.of_nat K.
Proof.
rewrite /used -[length _]/(size (filter Chance.informative (samples w))) filterE size_map /K cardE; congr (Z.of_nat (size _)).
rewrite [in LHS]enumT /enum_mem; apply: eq_filter => i.
by transitivity (i \in [set j | Coverage.informative n (fun i => val i) j]); rewrite ?inE.
Qed.

Lemma pair_informative i j : i != j -> (Coverage.informative n (fun i => val i) i + Coverage.informative n (fun i => val i) j <= K)%N.
Proof.
move=> ij; rewrite /K -sum1_card big_mkcond (bigD1 i) //= (bigD1 j) 1?eq_sym //= !inE addnA.
by apply: leq_trans (leq_addr _ _); case: (Coverage.informative _ _ i); case: (Coverage.informative _ _ j).
Qed.

Lemma strictly_risingE zs : strictly_rising zs = sorted Z.ltb zs.
Proof. by elim: zs => //= y [|z zs] //= ->. Qed.

Lemma rising_apart w i j : strictly_rising (List.map block (List.filter Chance.informative (samples w))) ->
  Coverage.informative n (fun i => val i) i -> Coverage.informative n (fun i => val i) j -> i != j -> blk i = blk j -> False.
Proof.
rewrite strictly_risingE -[List.map _ _]/(map block (filter Chance.informative (samples w))) filterE -map_comp => rise ii ij ne e.
have tr : transitive Z.ltb by move=> x y z /Z.ltb_lt a /Z.ltb_lt b; apply/Z.ltb_lt; lia.
have irr : irreflexive Z.ltb by move=> x; apply/negP => /Z.ltb_lt; lia.
by case/eqP: ne; apply: (uniq_map_eq (sorted_uniq tr irr rise)) => //=; rewrite mem_filter mem_enum ?ii ?ij.
Qed.

Let s w : nat := Z.to_nat (spanned (samples w)).

Lemma lesserE a b : lesser a b = Z.min a b.
Proof. by rewrite /lesser; case: Z.leb_spec => ?; lia. Qed.

Lemma spannedE w : spanned (samples w) = Z.of_nat (s w) /\ (s w <= K)%N /\
  forall i j, compared blk i j -> (Coverage.informative n (fun i => val i) i + Coverage.informative n (fun i => val i) j <= s w)%N.
Proof.
rewrite /s /spanned usedE !lesserE; case: ifP => [rise|_]; split; try lia; split; try lia.
  move=> i j /andP[/eqP e ne]; have := pair_informative ne; have := @rising_apart w i j rise.
  case: (Coverage.informative _ _ i) (Coverage.informative _ _ j) => -[] /= apart; [by case: (apart isT isT ne e) | lia..].
move=> i j /andP[/eqP e ne]; have := pair_informative ne.
by case: (Coverage.informative _ _ i) (Coverage.informative _ _ j) => -[] /=; lia.
Qed.

(* ---- The levels ---- *)

Lemma affordable_prob c (ind : bool) k (u l : Q) (S : {set W}) : (ind -> independent_counts P count) ->
  (k <= K)%N -> (forall i j, compared blk i j -> (Coverage.informative n (fun i => val i) i + Coverage.informative n (fun i => val i) j <= k)%N) ->
  affordable c ind (Z.of_nat K) (Z.of_nat k) u l -> 0 <= ratio l -> ratio l <= ratio u -> ratio u < 1 ->
  (forall w, w \in S -> misses_above count n p (fun i => val i) blk (ratio u) w \/ misses_below count n p (fun i => val i) blk (ratio l) w) ->
  prob P S <= 1 - ratio c.
Proof.
move=> indep kK span aff l0 lu u1 missed; case: (affordableE R kK aff) => [sum|[/indep ci ul product]].
  by apply: le_trans sum; apply: (box_misses lawP p01 val_ge0 drawn (erefl K) span kK l0 lu u1 missed).
by apply: le_trans product; apply: (box_misses_independent lawP p01 val_ge0 drawn (erefl K) span kK l0 lu u1 missed ci ul).
Qed.

(* ---- The ends of the ratio ---- *)

Lemma size_blocked w es : size es = N -> size (blocked (samples w) es) = N.
Proof. by move=> se; rewrite size_combine -[List.map _ _]/(map block (samples w)) size_map size_samples ?se. Qed.

Lemma nth_blocked w es (i : 'I_N) : size es = N -> nth (Z0, e0) (blocked (samples w) es) i = (blk i, nth e0 es i).
Proof.
move=> se; have e : size (map block (samples w)) = size es by rewrite size_map size_samples se.
by rewrite /blocked -[List.map _ _]/(map block (samples w)) (nth_combine _ _ _ e) (nth_map s0) ?size_samples // nth_samples.
Qed.

Lemma missed_above i w : upper_accepted i (samples w) -> ~ most_true (most i) ->
  misses_above count n p (fun i => val i) blk (ratio (upper_level i)) w.
Proof.
case/andP=> /box_of[se in_box]; rewrite /most_holds /most_true; case: (most i) => // r /andP[r1 all_r] wrong.
exists (fun j : 'I_N => ratio (nth e0 (upper i) j).1), (fun j : 'I_N => ratio (nth e0 (upper i) j).2), (ratio r); split=> //.
have r0 : 0 <= ratio r by apply: le_trans (at_mostP R r1); rewrite ratio_one ler01.
split=> // j k /andP[/eqP e ne].
have within_nth (x y : 'I_N) : (x < y)%N -> blk x = blk y ->
    within r (nth e0 (upper i) x) (nth e0 (upper i) y) /\ within r (nth e0 (upper i) y) (nth e0 (upper i) x).
  move=> xy exy; have := @all_within_nth r (Z0, e0) _ x y all_r; rewrite size_blocked // !nth_blocked // xy ltn_ord.
  by move=> /(_ isT exy).
have : within r (nth e0 (upper i) j) (nth e0 (upper i) k).
  case: (ltngtP j k) ne => [jk _|kj _|/val_inj ->]; last by rewrite eqxx.
  - by case: (within_nth _ _ jk e).
  - by case: (within_nth _ _ kj (esym e)).
by rewrite /within (at_mostE R) ratio_times.
Qed.

Lemma missed_below i w : lower_accepted i (samples w) -> ~ least_true (least i) ->
  misses_below count n p (fun i => val i) blk (ratio (lower_level i)) w.
Proof.
case/andP=> /box_of[se in_box]; rewrite /least_holds; case: (pair i) => [[y z]|]; last first.
  rewrite /least_true; case: (least i) => // r /andP[/(at_mostP R)]; rewrite ratio_one => r1 _ wrong.
  by case: wrong; left.
case ey: (cell_at _ y) => [a|] //; case ez: (cell_at _ z) => [b|] //.
have [j0 [lt_j -> ea]] := cell_atE (Z0, e0) ey; have [k0 [lt_k -> eb]] := cell_atE (Z0, e0) ez.
move: lt_j lt_k; rewrite size_blocked // => lt_j lt_k; pose j := Ordinal lt_j; pose k := Ordinal lt_k.
rewrite ea eb -[j0]/(nat_of_ord j) -[k0]/(nat_of_ord k) !nth_blocked //= => /and4P[/Z.eqb_eq e /negP ne lo0 ends_] wrong.
have jk : compared blk j k.
  by rewrite /compared e eqxx /=; apply/eqP => ejk; apply: ne; apply/Z.eqb_eq; rewrite -[j0]/(nat_of_ord j) ejk.
have lo0' := ratio_gt0 R lo0.
pose q : R := if least i is Some r then (ratio r)^-1 else 0.
exists (fun j : 'I_N => ratio (nth e0 (lower i) j).1), (fun j : 'I_N => ratio (nth e0 (lower i) j).2), q; split=> //; last first.
  by move: wrong; rewrite /q /least_true; case: (least i) => // r wrong true_; apply: wrong; right.
exists j, k; move: ends_; rewrite /q; case: (least i) => [r /and3P[r1 _]|]; rewrite (at_mostE R).
  have r0 : 0 < ratio r by apply: lt_le_trans (at_mostP R r1); rewrite ratio_one ltr01.
  by rewrite ratio_times => le_r; split; rewrite ?invr_ge0 ?(ltW r0) // mulrC ler_pdivl_mulr // mulrC.
by rewrite ratio_zero mul0r.
Qed.

(* ---- The theorems ---- *)

(* What is settled before the draws: the confidence, whether ends hold together, whether cells are independent, and the levels. *)
Definition settled (c : Q) (apart ind : bool) (u l : Q) (i : interval) : Prop :=
  [/\ confidence i = c, each i = apart, independent i = ind, upper_level i = u & lower_level i = l].

Definition settled_apart (c : Q) (ind : bool) (i : interval) : Prop := [/\ confidence i = c, each i = true & independent i = ind].

Lemma box_wider level level' w lo hi : level <= level' ->
  box count n (fun i => val i) level w lo hi -> box count n (fun i => val i) level' w lo hi.
Proof.
move=> le_l in_box i; have [lo0 lohi hiv low high] := in_box i; split=> //.
  by case: low => [|low]; [left | right; apply: le_trans le_l].
by case: high => [|high]; [left | right; apply: le_trans le_l].
Qed.

(* The greatest of the levels that were chosen serves for all data. *)
Lemma greatest_level (S : {set W}) w0 (level : interval -> Q) (A : interval -> W -> Prop) : w0 \in S ->
  (forall w, w \in S -> exists i, A i w) ->
  exists w' i', [/\ w' \in S, A i' w' & forall w, w \in S -> exists i, A i w /\ ratio (level i) <= ratio (level i')].
Proof.
move=> w0S some; have [i0 _] := some w0 w0S.
have [f fA] : exists f : W -> interval, forall w, w \in S -> A (f w) w.
  apply: (@fin_all_exists W (fun=> interval) (fun w i => w \in S -> A i w)) => w.
  by case: (boolP (w \in S)) => [/some[i Ai]|_]; [exists i | exists i0].
have [w' w'S top] := @Order.TotalTheory.arg_maxP _ R W w0 (mem S) (fun w => ratio (level (f w))) w0S.
by exists w', (f w'); split=> // [|w wS]; [apply: fA | exists (f w); split; [apply: fA | apply: top]].
Qed.

Lemma levels c ind apart (u l : Q) i w : settled c apart ind u l i -> levels_hold i (samples w) ->
  [/\ 0 <= ratio u < 1, 0 <= ratio l < 1 &
    if apart then affordable c ind (Z.of_nat K) (spanned (samples w)) u zero && affordable c ind (Z.of_nat K) (spanned (samples w)) l l
    else at_most l u && affordable c ind (Z.of_nat K) (spanned (samples w)) u l].
Proof.
case=> <- <- <- <- <-; rewrite /levels_hold usedE; case: ifP => _.
  case/andP=> /and4P[u0 l0 u0' l0'] aff; split=> //.
  - by rewrite (zeroE u0' u0) lexx ltr01.
  - by rewrite (zeroE l0' l0) lexx ltr01.
case/andP=> /and4P[/(ratio_gt0 R) u0 /(ratio_gt0 R) l0 /(ratio_gt0 R) u1 /(ratio_gt0 R) l1] aff; split=> //.
- by rewrite (ltW u0) /= -subr_gt0 -rest_ofE.
- by rewrite (ltW l0) /= -subr_gt0 -rest_ofE.
Qed.

Section Settled.
Variables (c : Q) (ind : bool) (u l : Q) (S : {set W}).
Hypotheses (c1 : ratio c <= 1) (indep : ind -> independent_counts P count).

(* Ends that hold together: for every law of the draws, the data for which there is some interval that the program accepts and of which
   one end is wrong have at most the probability 1 - c. *)
Theorem box_together :
  (forall w, w \in S -> exists i, [/\ settled c false ind u l i, box_accepted i (samples w) & ~ most_true (most i) \/ ~ least_true (least i)]) ->
  prob P S <= 1 - ratio c.
Proof.
move=> all_w; have [->|[w wS]] := set_0Vmem S; first by rewrite /prob big_set0 subr_ge0.
have [i [set_i /and3P[lev _ _] _]] := all_w w wS.
have [/andP[u0 u1] /andP[l0 l1] /andP[/(at_mostP R) lu]] := levels set_i lev.
have [-> [sK span]] := spannedE w => aff; apply: affordable_prob indep sK span aff l0 lu u1 _ => w' /all_w[j [[_ _ _ <- <-] /and3P[_ up low]]].
by case=> wrong; [left; apply: missed_above | right; apply: missed_below].
Qed.

(* Ends that hold each by itself: here levels, too, may be chosen after the draws were seen. *)
Theorem box_upper :
  (forall w, w \in S -> exists i, [/\ settled_apart c ind i, box_accepted i (samples w) & ~ most_true (most i)]) ->
  prob P S <= 1 - ratio c.
Proof.
move=> all_w; have [->|[w wS]] := set_0Vmem S; first by rewrite /prob big_set0 subr_ge0.
have [w' [i' [w'S [set_i /and3P[lev _ _] _] others]]] := greatest_level upper_level wS all_w.
have set_i' : settled c true ind (upper_level i') (lower_level i') i' by case: set_i.
have [/andP[u0 u1] _ /andP[aff _]] := levels set_i' lev; move: aff.
have [-> [sK span]] := spannedE w' => aff; apply: (affordable_prob indep sK span aff); rewrite ?ratio_zero // => x /others[j [[_ /and3P[_ up _] wrong] le_l]].
left; have [lo [hi [r [in_box ends_ false_]]]] := missed_above up wrong; exists lo, hi, r; split=> //.
exact: box_wider le_l in_box.
Qed.

Theorem box_lower :
  (forall w, w \in S -> exists i, [/\ settled_apart c ind i, box_accepted i (samples w) & ~ least_true (least i)]) ->
  prob P S <= 1 - ratio c.
Proof.
move=> all_w; have [->|[w wS]] := set_0Vmem S; first by rewrite /prob big_set0 subr_ge0.
have [w' [i' [w'S [set_i /and3P[lev _ _] _] others]]] := greatest_level lower_level wS all_w.
have set_i' : settled c true ind (upper_level i') (lower_level i') i' by case: set_i.
have [_ /andP[l0 l1] /andP[_ aff]] := levels set_i' lev; move: aff.
have [-> [sK span]] := spannedE w' => aff; apply: affordable_prob indep sK span aff l0 (lexx _) l1 _ => x /others[j [[_ /and3P[_ _ low] wrong] le_l]].
right; have [lo [hi [q [in_box ends_ false_]]]] := missed_below low wrong; exists lo, hi, q; split=> //.
exact: box_wider le_l in_box.
Qed.

(* If the levels of ends that hold together are in proportion, they may be chosen after looking as well. *)
Lemma spanned_same w w' : spanned (samples w) = spanned (samples w').
Proof.
have blocks x : List.map block (List.filter Chance.informative (samples x)) = [seq blk i | i <- enum 'I_N & Coverage.informative n (fun i => val i) i].
  by rewrite -[List.map _ _]/(map block (filter Chance.informative (samples x))) filterE -map_comp.
by rewrite /spanned !usedE !blocks.
Qed.

Lemma in_proportionE i w : each i = false -> in_proportion i (samples w) ->
  K = 0%N \/ (s w)%:R * ratio (upper_level i) = (2 * K - s w)%:R * ratio (lower_level i) :> R.
Proof.
have [e [sK _]] := spannedE w; rewrite /in_proportion usedE => -> /=.
case/orP=> [/Z.eqb_eq/(Nat2Z.inj K 0)|le]; [by left | right].
move: le; rewrite e (sub_twice sK) !(at_mostE R) !ratio_times !numberE !embed_nat => le; by apply/eqP; rewrite eq_le.
Qed.

Theorem box_proportional :
  (forall w, w \in S -> exists i, [/\ [/\ confidence i = c, each i = false & independent i = ind], in_proportion i (samples w),
    box_accepted i (samples w) & ~ most_true (most i) \/ ~ least_true (least i)]) ->
  prob P S <= 1 - ratio c.
Proof.
move=> all_w; have [->|[w wS]] := set_0Vmem S; first by rewrite /prob big_set0 subr_ge0.
have [w' [i' [w'S [[ci ei ii] prop_i /and3P[lev _ _] _] others]]] := greatest_level upper_level wS all_w.
have set_i : settled c false ind (upper_level i') (lower_level i') i' by [].
have [/andP[u0 u1] /andP[l0 l1] /andP[/(at_mostP R) lu]] := levels set_i lev.
have [-> [sK span]] := spannedE w' => aff; apply: (affordable_prob indep sK span aff l0 lu u1) => x /others[j [[[cj ej ij] prop_j /and3P[lev_j up low] wrong] le_u]].
have le_l : ratio (lower_level j) <= ratio (lower_level i').
  have set_j : settled c false ind (upper_level j) (lower_level j) j by [].
  have [_ /andP[lj0 _] /andP[/(at_mostP R) lju _]] := levels set_j lev_j.
  have sx : s x = s w' by rewrite /s (spanned_same x w').
  have [K0|K0] := posnP K.
    have /and4P[_ lz _ l0'] : [&& at_most (upper_level j) zero, at_most (lower_level j) zero, nonnegative (upper_level j) & nonnegative (lower_level j)].
      by move: lev_j; rewrite /levels_hold usedE K0 => /andP[].
    by rewrite (zeroE l0' lz).
  have pos : 0 < (2 * K - s w')%:R :> R by rewrite ltr0n subn_gt0 (leq_ltn_trans sK) // mul2n -addnn -[X in (X < _)%N]addn0 ltn_add2l.
  case: (in_proportionE ei prop_i) => [K0'|pi]; first by move: K0; rewrite K0'.
  case: (in_proportionE ej prop_j) => [K0'|]; first by move: K0; rewrite K0'.
  by rewrite sx => pj; rewrite -(ler_pmul2l pos) -pi -pj ler_wpmul2l ?ler0n.
case: wrong => wrong; [left | right].
  by have [lo [hi [r [in_box ends_ false_]]]] := missed_above up wrong; exists lo, hi, r; split=> //; apply: box_wider le_u in_box.
by have [lo [hi [q [in_box ends_ false_]]]] := missed_below low wrong; exists lo, hi, q; split=> //; apply: box_wider le_l in_box.
Qed.

End Settled.
End Sound.
