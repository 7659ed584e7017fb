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

Lemma means_ge0 j (w : {ffun D -> 'I_d}) : proved_by_pools j (counted_again pool_of w) -> forall i, 0 <= mean Q i.
Proof.
case/proved_by_poolsP => ss [/samples_again[_ ok] _ _ _] i.
by rewrite (meanE Q ok); apply: (E_ge0 (chance01 (@good ps d) laws)) => k; apply: ratio_ge0 (worth0 ok k).
Qed.

Lemma wrong_above t j (w : {ffun D -> 'I_d}) : proved_by_pools j (counted_again pool_of w) ->
  ~~ ratio_keeps Q t -> verdict_wrong Q t j -> ~ ratio_at_most Q (most j).
Proof.
move=> /means_ge0 ge0 over; rewrite /verdict_wrong (negPf over); case: (most j) => [r|] // le at_most_.
case/negP: over; apply/forallP => a; apply/forallP => b; apply/implyP => /at_most_/le_trans; apply.
by rewrite ler_wpmul2r.
Qed.

Lemma wrong_below t j (w : {ffun D -> 'I_d}) : 1 <= t -> proved_by_pools j (counted_again pool_of w) ->
  ratio_keeps Q t -> verdict_wrong Q t j -> ~ ratio_at_least Q (least j).
Proof.
move=> t1 /means_ge0 ge0 keeps; rewrite /verdict_wrong keeps.
have kept a b : are_compared a b -> mean Q a <= t * mean Q b by move/forallP/(_ a)/forallP/(_ b)/implyP: keeps => k /k.
case: (least j) => [r lt|_] /=; last by case=> a [b [/kept le b0 pos]]; move: le; rewrite b0 mulr0 leNgt pos.
case=> [r1|[a [b [/kept le ge pos]]]]; first by move: lt; rewrite ltNge (le_trans r1 t1).
have b0 : 0 < mean Q b.
  rewrite lt_neqAle ge0 andbT; apply/negP => /eqP e0; move: (lt_le_trans pos le).
  by rewrite -e0 mulr0 ltxx.
by move: (le_trans ge le); rewrite ler_pmul2r // leNgt lt.
Qed.

(* ---- Draws that are a part of what happens ---- *)

Variables (O : finType) (P : O -> R) (data : O -> {ffun D -> 'I_d}) (i : interval).
Hypothesis lawP : law P.

Lemma prob_image (S : {set O}) : prob P S <= prob (law_of_data P data) (data @: S).
Proof.
rewrite /prob /law_of_data (partition_big data (mem (data @: S))) /= => [|o oS]; last exact: imset_f.
apply: ler_sum => w _; rewrite [leLHS]big_mkcond [leRHS]big_mkcond /=; apply: ler_sum => o _.
by case: (data o == w); rewrite ?andbF // andbT; case: ifP => // _; case: lawP.
Qed.

Local Notation seldom_ := (seldom pool_of (law_of_data P data) i).

Lemma seldom_data (is_wrong : interval -> Prop) (S : {set O}) : seldom_ is_wrong ->
  (forall o, o \in S -> can_mislead pool_of i is_wrong (data o)) -> prob P S <= 1 - ratio (confidence i).
Proof. by move=> seldom_wrong misled; apply: le_trans (prob_image S) (seldom_wrong _ _) => w /imsetP[o oS ->]; apply: misled. Qed.

Local Notation above := (fun j => ~ ratio_at_most Q (most j)).
Local Notation below := (fun j => ~ ratio_at_least Q (least j)).

(* Whatever the ratio is, one verdict alone can be wrong, and it rests on one end. *)
Lemma one_limit t (S : {set O}) : 1 <= t -> seldom_ above -> seldom_ below ->
  (forall o, o \in S -> can_err Q pool_of i t (data o)) -> prob P S <= 1 - ratio (confidence i).
Proof.
move=> t1 seldom_above seldom_below errs.
have [keeps|over] := boolP (ratio_keeps Q t); [apply: (seldom_data seldom_below)|apply: (seldom_data seldom_above)] => o /errs[j [alike_ acc wrong]].
- by exists j; split=> //; apply: wrong_below t1 acc keeps wrong.
- by exists j; split=> //; apply: wrong_above acc over wrong.
Qed.

Lemma all_limits (S : {set O}) : seldom_ (fun j => above j \/ below j) ->
  (forall o, o \in S -> exists2 t, 1 <= t & can_err Q pool_of i t (data o)) -> prob P S <= 1 - ratio (confidence i).
Proof.
move=> seldom_wrong errs; apply: (seldom_data seldom_wrong) => o /errs[t t1 [j [alike_ acc wrong]]]; exists j; split=> //.
by have [keeps|over] := boolP (ratio_keeps Q t); [right; apply: wrong_below t1 acc keeps wrong|left; apply: wrong_above acc over wrong].
Qed.
End One.

Lemma prob_split (R : realFieldType) (O K : finType) (P : O -> R) (f : O -> K) (S : {set O}) :
  prob P S = \sum_k prob P [set o in S | f o == k].
Proof.
rewrite /prob (partition_big f xpredT) //; apply: eq_bigr => k _; apply: eq_bigl => o.
by rewrite inE.
Qed.

Section Together.
Variables (R : realFieldType) (T : table).
Variables (ps : bool -> list pool) (i : bool -> interval) (O : finType) (P : O -> R).
Local Notation d := (Z.to_nat (decisions T)).
Variables (Q : forall local, 'I_(size (ps local)) -> 'I_d -> R) (D : bool -> finType).
Variables (pool_of : forall local, D local -> 'I_(size (ps local))) (data : forall local, O -> {ffun D local -> 'I_d}).
Hypothesis lawP : law P.

(* Of the interval of a ratio that is judged: the program accepts it, and its draws are those of the population *)
Definition drawn_and_accepted (local : bool) : Prop :=
  [/\ pools_of T local = Some (ps local), judged_by_draws T local (By_box (i local)) = Some true, kernel (@Q local)
    & drawn_from (@pool_of local) (@Q local) (independent (i local)) (law_of_data P (@data local))].

Variables (on : seq bool) (ts : nat -> R).
Hypotheses (limits_ge1 : forall k, 1 <= ts k) (accepted : forall local, local \in on -> drawn_and_accepted local).

Definition somebody_errs (o : O) : Prop :=
  exists k : 'I_(size on), let local := nth false on k in can_err (@Q local) (@pool_of local) (i local) (ts k) (@data local o).
(* The verdicts on one quantity *)
Lemma of_one_quantity local (n := seq.count (pred1 local) on) (f : O -> 'I_(size on)) (S : {set O}) :
  (forall o, o \in S -> nth false on (f o) = local /\ can_err (@Q local) (@pool_of local) (i local) (ts (f o)) (@data local o)) ->
  \sum_(k : 'I_(size on) | nth false on k == local) prob P [set o in S | f o == k] <= risk R (By_box (i local)) n.
Proof.
move=> errs; have [there|none] := boolP (local \in on); last first.
  rewrite big1_seq => [|k /andP[/eqP kE _]]; last by case/negP: none; rewrite -kE mem_nth.
  by rewrite /risk /= /n (count_memPn none); case: (each _); rewrite ?mul0r.
have [pools judged laws drawn_] := accepted there; have [ps' [psE _ holds_]] := box_sound R judged.
move: psE holds_; rewrite pools => -[<-] /(_ _ _ _ _ laws drawn_).
rewrite /risk /=; case: (each (i local)) => [[above below]|either].
  have one (k : 'I_(size on)) : prob P [set o in S | f o == k] <= 1 - ratio (confidence (i local)).
    apply: (one_limit laws lawP (limits_ge1 k) above below) => o; rewrite inE => /andP[/errs[_ err] /eqP <-].
    exact: err.
  apply: le_trans (ler_sum _ (fun k _ => one k)) _.
  rewrite sumr_const mulr_natl; set m := #|_|; suff -> : m = n by rewrite lexx.
  rewrite /m /n -sum1_card -sum1_count (big_nth false) big_mkord; apply: eq_bigl => k.
  by rewrite inE.
have n0 : (0 < n)%N by rewrite /n -has_count; apply/hasP; exists local => //=.
rewrite -(prednK n0); apply: le_trans (all_limits laws lawP either (S := S) _); last first.
  by move=> o /errs[_ err]; exists (ts (f o)); [exact: limits_ge1|exact: err].
rewrite (prob_split P f) [leRHS](bigID (fun k : 'I_(size on) => nth false on k == local)) /= ler_addl.
by apply: sumr_ge0 => k _; apply: sumr_ge0 => o _; case: lawP.
Qed.

Lemma risks_add_up (S : {set O}) : (forall o, o \in S -> somebody_errs o) ->
  prob P S <= risk R (By_box (i true)) (seq.count id on) + risk R (By_box (i false)) (seq.count negb on).
Proof.
move=> errs; pose err o (k : 'I_(size on)) :=
  let local := nth false on k in can_err (@Q local) (@pool_of local) (i local) (ts k) (@data local o).
have [some|] := boolP (0 < size on)%N; last first.
  rewrite -eqn0Ngt size_eq0 => /eqP on0.
  have -> : prob P S = 0 by apply: big1 => o /errs[[k lt] _]; move: lt; rewrite on0.
  by rewrite {1 2}on0 /risk /=; case: (each _); case: (each _); rewrite ?mul0r addr0.
have [f fE] : exists f : O -> 'I_(size on), forall o, o \in S -> err o (f o).
  apply: (@fin_all_exists _ (fun=> 'I_(size on)) (fun o k => o \in S -> err o k)) => o.
  have [/errs[k err_k]|_] := boolP (o \in S); first by exists k.
  by exists (Ordinal some).
pose at_ local := [set o in S | nth false on (f o) == local].
have parts local :
    \sum_(k : 'I_(size on) | nth false on k == local) prob P [set o in S | f o == k] <= risk R (By_box (i local)) (seq.count (pred1 local) on).
  rewrite (eq_bigr (fun k => prob P [set o in at_ local | f o == k])) => [|k kE].
    by apply: of_one_quantity => o; rewrite inE => /andP[oS /eqP oE]; split=> //; have := fE o oS; rewrite /err oE.
  apply: eq_bigl => o; rewrite !inE; case: (f o =P k) => [->|]; rewrite ?andbF // kE ?andbT //.
rewrite (prob_split P f) (bigID (fun k : 'I_(size on) => nth false on k == true)) /=; apply: ler_add.
  by apply: le_trans (parts true) _; rewrite (@eq_count _ _ id) // => -[].
rewrite (eq_bigl (fun k : 'I_(size on) => nth false on k == false)) => [|k]; last by case: (nth _ _ _).
by apply: le_trans (parts false) _; rewrite (@eq_count _ _ negb) // => -[].
Qed.

Theorem verdicts_hold_together (of_local of_global : option proof) (c : QArith_base.Q) (S : {set O}) :
  (forall local, local \in on -> (if local then of_local else of_global) = Some (By_box (i local))) ->
  together_at R of_local of_global on c -> (forall o, o \in S -> somebody_errs o) -> prob P S <= 1 - ratio c.
Proof.
move=> stated add_up /risks_add_up /le_trans; apply; apply: le_trans add_up.
have risk0 e : risk R e 0 = 0 by rewrite /risk; case: (ends_each e); rewrite ?mul0r.
apply: ler_add; [rewrite -(@eq_count _ (pred1 true)) => [|[]//]|rewrite -(@eq_count _ (pred1 false)) => [|[]//]].
- have [/stated -> //|/count_memPn ->] := boolP (true \in on).
  by rewrite risk0; case: of_local {stated} => //= e; rewrite risk0.
- have [/stated -> //|/count_memPn ->] := boolP (false \in on).
  by rewrite risk0; case: of_global {stated} => //= e; rewrite risk0.
Qed.
End Together.
