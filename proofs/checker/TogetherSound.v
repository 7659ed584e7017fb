(* Several verdicts on one population: that any of them is wrong has at most the probability that their errors add up to.

   Reading key.  What happens is o, of the law P; of it the draws of the pools of the local ratio are one part, data true o, those of the pools
   of the global ratio another one, data false o, and how the two are related does not matter.  [on] says of each limit whether it is on the
   local ratio, [ts k] is the limit with the number k.  S is any set of o for each of which somebody can write intervals about the data that the
   program accepts, and of which one gives a wrong verdict on one of the limits. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions Draws Coverage.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Chance ChanceSound Drawn DrawnMeaning DrawnSound VerdictsMeaning.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section One.
Variables (R : realFieldType) (ps : list pool) (d : nat) (Q : 'I_(size ps) -> 'I_d -> R) (D : finType) (pool_of : D -> 'I_(size ps)).
Hypothesis laws : kernel Q.
Local Notation ratio := (@ratio R).

Lemma means_ge0 ss (w : {ffun D -> 'I_d}) : all_of sample_of (counted_again pool_of w) = Some ss -> forall i, 0 <= mean Q i.
Proof.
case/samples_again => _ ok i; rewrite (meanE Q ok).
by apply: (E_ge0 (chance01 (@good ps d) laws)) => k; apply: ratio_ge0 (worth0 ok k).
Qed.

Section Ends.
Variables (least most : option QArith_base.Q) (t : R).
Hypothesis ge0 : forall i, 0 <= mean Q i.

Lemma wrong_above : ~~ ratio_keeps Q t -> verdict_wrong Q t least most -> ~ ratio_at_most Q most.
Proof.
move=> over; rewrite /verdict_wrong (negPf over); case: most => [r|] // le at_most_.
case/negP: over; apply/forallP => a; apply/forallP => b; apply/implyP => /at_most_/le_trans; apply.
by rewrite ler_wpmul2r.
Qed.

Lemma wrong_below : 1 <= t -> ratio_keeps Q t -> verdict_wrong Q t least most -> ~ ratio_at_least Q least.
Proof.
move=> t1 keeps; rewrite /verdict_wrong keeps.
have kept a b : are_compared a b -> mean Q a <= t * mean Q b by move/forallP/(_ a)/forallP/(_ b)/implyP: keeps => k /k.
case: least => [r lt|_] /=; last by case=> a [b [/kept le b0 pos]]; move: le; rewrite b0 mulr0 leNgt pos.
case=> [r1|[a [b [/kept le ge pos]]]]; first by move: lt; rewrite ltNge (le_trans r1 t1).
have b0 : 0 < mean Q b.
  rewrite lt_neqAle ge0 andbT; apply/negP => /eqP e0; move: (lt_le_trans pos le).
  by rewrite -e0 mulr0 ltxx.
by move: (le_trans ge le); rewrite ler_pmul2r // leNgt lt.
Qed.
End Ends.

(* ---- Draws that are a part of what happens ---- *)

Variables (O : finType) (P : O -> R) (data : O -> {ffun D -> 'I_d}).
Hypothesis lawP : law P.

Lemma prob_image (S : {set O}) : prob P S <= prob (law_of_data P data) (data @: S).
Proof.
rewrite /prob /law_of_data (partition_big data (mem (data @: S))) /= => [|o oS]; last exact: imset_f.
apply: ler_sum => w _; rewrite [leLHS]big_mkcond [leRHS]big_mkcond /=; apply: ler_sum => o _.
by case: (data o == w); rewrite ?andbF // andbT; case: ifP => // _; case: lawP.
Qed.

(* Intervals of one kind: their ends, and which are accepted about the data, with what was settled before *)
Section Kind.
Variables (J : Type) (least_end most_end : J -> option QArith_base.Q) (accepted_ : J -> {ffun D -> 'I_d} -> Prop) (error : R).
Hypothesis ge0 : forall j w, accepted_ j w -> forall i, 0 <= mean Q i.

Let misled (is_wrong : J -> Prop) w : Prop := exists2 j, accepted_ j w & is_wrong j.
Let seldom_ (is_wrong : J -> Prop) : Prop :=
  forall S : {set {ffun D -> 'I_d}}, (forall w, w \in S -> misled is_wrong w) -> prob (law_of_data P data) S <= error.
Let errs t w : Prop := misled (fun j => verdict_wrong Q t (least_end j) (most_end j)) w.
Let above j := ~ ratio_at_most Q (most_end j).
Let below j := ~ ratio_at_least Q (least_end j).

Lemma seldom_data (is_wrong : J -> Prop) (S : {set O}) : seldom_ is_wrong -> (forall o, o \in S -> misled is_wrong (data o)) -> prob P S <= error.
Proof. by move=> seldom_wrong mis; apply: le_trans (prob_image S) (seldom_wrong _ _) => w /imsetP[o oS ->]; apply: mis. Qed.

(* Whatever the ratio is, one verdict alone can be wrong, and it rests on one end. *)
Lemma one_limit t (S : {set O}) : seldom_ above -> seldom_ below -> 1 <= t -> (forall o, o \in S -> errs t (data o)) -> prob P S <= error.
Proof.
move=> seldom_above seldom_below t1 wrong_.
have [keeps|over] := boolP (ratio_keeps Q t); [apply: (seldom_data seldom_below)|apply: (seldom_data seldom_above)] => o /wrong_[j acc wrong].
- by exists j => //; apply: wrong_below (ge0 acc) t1 keeps wrong.
- by exists j => //; apply: wrong_above (ge0 acc) over wrong.
Qed.

Lemma all_limits (S : {set O}) : seldom_ (fun j => above j \/ below j) ->
  (forall o, o \in S -> exists2 t, 1 <= t & errs t (data o)) -> prob P S <= error.
Proof.
move=> seldom_wrong wrong_; apply: (seldom_data seldom_wrong) => o /wrong_[t t1 [j acc wrong]]; exists j => //.
have [keeps|over] := boolP (ratio_keeps Q t); [right|left].
- by apply: wrong_below (ge0 acc) t1 keeps wrong.
- by apply: wrong_above (ge0 acc) over wrong.
Qed.
End Kind.
End One.

(* The error of an interval of each kind *)
Section By_proof.
Variables (R : realFieldType) (T : table) (local : bool) (ps : list pool) (e : proof).
Local Notation d := (Z.to_nat (decisions T)).
Variables (Q : 'I_(size ps) -> 'I_d -> R) (D : finType) (pool_of : D -> 'I_(size ps)) (O : finType) (P : O -> R) (data : O -> {ffun D -> 'I_d}).
Hypotheses (laws : kernel Q) (lawP : law P) (pools : pools_of T local = Some ps) (judged : judged_by_draws T local e = Some true).
Hypothesis draws : drawn_as Q pool_of e (law_of_data P data).
Local Notation error := (1 - ratio (confidence_of e)).

Lemma errors_seldom :
  if ends_each e then forall t (S : {set O}), 1 <= t -> (forall o, o \in S -> can_err Q pool_of e t (data o)) -> prob P S <= error
  else forall S : {set O}, (forall o, o \in S -> exists2 t, 1 <= t & can_err Q pool_of e t (data o)) -> prob P S <= error.
Proof.
move: judged draws; case: e => [i|i|i] judged_ /= drawn_ //.
- have [ps' [psE _ holds_]] := box_sound R judged_; move: psE holds_; rewrite pools => -[<-] /(_ _ _ _ _ laws drawn_).
  pose acc j (w : {ffun D -> 'I_d}) := alike i j /\ proved_by_pools j (counted_again pool_of w).
  have ge0 j w : acc j w -> forall k, 0 <= mean Q k by case=> _ /proved_by_poolsP[ss [/(means_ge0 laws)]].
  have sel is_wrong : seldom pool_of (law_of_data P data) i is_wrong -> forall S : {set {ffun D -> 'I_d}},
      (forall w, w \in S -> exists2 j, acc j w & is_wrong j) -> prob (law_of_data P data) S <= 1 - ratio (confidence i).
    by move=> seldom_ S mis; apply: seldom_ => w /mis[j [al pr] wr]; exists j.
  case: (each i) => [[/sel above /sel below] t S t1 errs|/sel either S errs].
    by apply: (one_limit lawP ge0 above below t1) => o /errs[j [al pr wr]]; exists j.
  by apply: (all_limits lawP ge0 either) => o /errs[t t1 [j [al pr wr]]]; exists t => //; exists j.
- have [ps' [psE _ holds_]] := pairs_sound R judged_; move: psE holds_; rewrite pools => -[<-] /(_ _ _ _ _ laws drawn_).
  pose acc j (w : {ffun D -> 'I_d}) := alike_pairs i j /\ proved_by_ladders j (counted_again pool_of w).
  have ge0 j w : acc j w -> forall k, 0 <= mean Q k by case=> _ /proved_by_laddersP[ss [/(means_ge0 laws)]].
  have sel is_wrong : seldom_by_pairs pool_of (law_of_data P data) i is_wrong -> forall S : {set {ffun D -> 'I_d}},
      (forall w, w \in S -> exists2 j, acc j w & is_wrong j) -> prob (law_of_data P data) S <= 1 - ratio (Pairs.sure_at i).
    by move=> seldom_ S mis; apply: seldom_ => w /mis[j [al pr] wr]; exists j.
  case: (Pairs.one_by_one i) => [[/sel above /sel below] t S t1 errs|/sel either S errs].
    by apply: (one_limit (least_end := fun j => Some (Pairs.lowest j)) lawP ge0 above below t1) => o /errs[j [al pr wr]]; exists j.
  by apply: (all_limits (least_end := fun j => Some (Pairs.lowest j)) lawP ge0 either) => o /errs[t t1 [j [al pr wr]]]; exists t => //; exists j.
Qed.
End By_proof.

Lemma prob_split (R : realFieldType) (O K : finType) (P : O -> R) (f : O -> K) (S : {set O}) :
  prob P S = \sum_k prob P [set o in S | f o == k].
Proof.
rewrite /prob (partition_big f xpredT) //; apply: eq_bigr => k _; apply: eq_bigl => o.
by rewrite inE.
Qed.

Section Together.
Variables (R : realFieldType) (T : table).
Variables (ps : bool -> list pool) (e : bool -> proof) (O : finType) (P : O -> R).
Local Notation d := (Z.to_nat (decisions T)).
Variables (Q : forall local, 'I_(size (ps local)) -> 'I_d -> R) (D : bool -> finType).
Variables (pool_of : forall local, D local -> 'I_(size (ps local))) (data : forall local, O -> {ffun D local -> 'I_d}).
Hypothesis lawP : law P.

(* Of the interval of a ratio that is judged: the program accepts it, and its draws are those of the population *)
Definition drawn_and_accepted (local : bool) : Prop :=
  [/\ pools_of T local = Some (ps local), judged_by_draws T local (e local) = Some true, kernel (@Q local)
    & drawn_as (@Q local) (@pool_of local) (e local) (law_of_data P (@data local))].

Variables (on : seq bool) (ts : nat -> R).
Hypotheses (limits_ge1 : forall k, 1 <= ts k) (accepted : forall local, local \in on -> drawn_and_accepted local).

Definition somebody_errs (o : O) : Prop :=
  exists k : 'I_(size on), let local := nth false on k in can_err (@Q local) (@pool_of local) (e local) (ts k) (@data local o).
(* The verdicts on one quantity *)
Lemma of_one_quantity local (n := seq.count (pred1 local) on) (f : O -> 'I_(size on)) (S : {set O}) :
  (forall o, o \in S -> nth false on (f o) = local /\ can_err (@Q local) (@pool_of local) (e local) (ts (f o)) (@data local o)) ->
  \sum_(k : 'I_(size on) | nth false on k == local) prob P [set o in S | f o == k] <= risk R (e local) n.
Proof.
move=> errs; have [there|none] := boolP (local \in on); last first.
  rewrite big1_seq => [|k /andP[/eqP kE _]]; last by case/negP: none; rewrite -kE mem_nth.
  by rewrite /risk /n (count_memPn none); case: (ends_each _); rewrite ?mul0r.
have [pools judged laws drawn_] := accepted there.
have := errors_seldom laws lawP pools judged drawn_; rewrite /risk; case: (ends_each (e local)) => [each_|either].
  have one (k : 'I_(size on)) : prob P [set o in S | f o == k] <= 1 - ratio (confidence_of (e local)).
    apply: (each_ _ _ (limits_ge1 k)) => o; rewrite inE => /andP[/errs[_ err] /eqP <-].
    exact: err.
  apply: le_trans (ler_sum _ (fun k _ => one k)) _.
  rewrite sumr_const mulr_natl; set m := #|_|; suff -> : m = n by rewrite lexx.
  rewrite /m /n -sum1_card -sum1_count (big_nth false) big_mkord; apply: eq_bigl => k.
  by rewrite inE.
have n0 : (0 < n)%N by rewrite /n -has_count; apply/hasP; exists local => //=.
rewrite -(prednK n0); apply: le_trans (either S _); last first.
  by move=> o /errs[_ err]; exists (ts (f o)); [exact: limits_ge1|exact: err].
rewrite (prob_split P f) [leRHS](bigID (fun k : 'I_(size on) => nth false on k == local)) /= ler_addl.
by apply: sumr_ge0 => k _; apply: sumr_ge0 => o _; case: lawP.
Qed.

Lemma risks_add_up (S : {set O}) : (forall o, o \in S -> somebody_errs o) ->
  prob P S <= risk R (e true) (seq.count id on) + risk R (e false) (seq.count negb on).
Proof.
move=> errs; pose err o (k : 'I_(size on)) :=
  let local := nth false on k in can_err (@Q local) (@pool_of local) (e local) (ts k) (@data local o).
have [some|] := boolP (0 < size on)%N; last first.
  rewrite -eqn0Ngt size_eq0 => /eqP on0.
  have -> : prob P S = 0 by apply: big1 => o /errs[[k lt] _]; move: lt; rewrite on0.
  by rewrite {1 2}on0 /risk /=; case: (ends_each _); case: (ends_each _); rewrite ?mul0r addr0.
have [f fE] : exists f : O -> 'I_(size on), forall o, o \in S -> err o (f o).
  apply: (@fin_all_exists _ (fun=> 'I_(size on)) (fun o k => o \in S -> err o k)) => o.
  have [/errs[k err_k]|_] := boolP (o \in S); first by exists k.
  by exists (Ordinal some).
pose at_ local := [set o in S | nth false on (f o) == local].
have parts local :
    \sum_(k : 'I_(size on) | nth false on k == local) prob P [set o in S | f o == k] <= risk R (e local) (seq.count (pred1 local) on).
  rewrite (eq_bigr (fun k => prob P [set o in at_ local | f o == k])) => [|k kE].
    by apply: of_one_quantity => o; rewrite inE => /andP[oS /eqP oE]; split=> //; have := fE o oS; rewrite /err oE.
  apply: eq_bigl => o; rewrite !inE; case: (f o =P k) => [->|]; rewrite ?andbF // kE ?andbT //.
rewrite (prob_split P f) (bigID (fun k : 'I_(size on) => nth false on k == true)) /=; apply: ler_add.
  by apply: le_trans (parts true) _; rewrite (@eq_count _ _ id) // => -[].
rewrite (eq_bigl (fun k : 'I_(size on) => nth false on k == false)) => [|k]; last by case: (nth _ _ _).
by apply: le_trans (parts false) _; rewrite (@eq_count _ _ negb) // => -[].
Qed.

Theorem verdicts_hold_together (of_local of_global : option proof) (c : QArith_base.Q) (S : {set O}) :
  (forall local, local \in on -> (if local then of_local else of_global) = Some (e local)) ->
  together_at R of_local of_global on c -> (forall o, o \in S -> somebody_errs o) -> prob P S <= 1 - ratio c.
Proof.
move=> stated add_up /risks_add_up /le_trans; apply; apply: le_trans add_up.
have risk0 e0 : risk R e0 0 = 0 by rewrite /risk; case: (ends_each e0); rewrite ?mul0r.
apply: ler_add; [rewrite -(@eq_count _ (pred1 true)) => [|[]//]|rewrite -(@eq_count _ (pred1 false)) => [|[]//]].
- have [/stated -> //|/count_memPn ->] := boolP (true \in on).
  by rewrite risk0; case: of_local {stated} => //= e0; rewrite risk0.
- have [/stated -> //|/count_memPn ->] := boolP (false \in on).
  by rewrite risk0; case: of_global {stated} => //= e0; rewrite risk0.
Qed.
End Together.
