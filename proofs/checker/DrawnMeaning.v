(* When an interval of the ratio of a population holds: this file has to be read.

   It has no proofs.  Drawn.v says which pools ps of draws a table counts.  A population is a law Q i of the decisions, for each pool i.
   There are as many draws of each pool as one likes, as long as how many does not depend on what is drawn.  The data w are the decisions that were drawn.  What holds is a property of the procedure,
   not of one interval: before the draws are seen, whatever the population is, it has at most the probability 1 - c that somebody can
   write an interval about the data which the program accepts and which is wrong.  The interval of a certificate is one that the program
   accepts about the data that its table counts. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From Fairaudit Require Import Definitions Draws.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Chance Drawn.
From FairauditChecker Require Statements Meaning Pairs Bets BetsMeaning.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Population.
Variables (R : realFieldType) (ps : list pool) (decisions : nat).

Definition no_pool : pool := Pool 0 [::] [::].
Definition pool_at (i : 'I_(size ps)) : pool := nth no_pool ps i.

(* What a decision is worth in a pool, and the mean under a law of the decisions *)
Definition worth_of (i : 'I_(size ps)) (u : 'I_decisions) : R := ratio (nth zero (values (pool_at i)) u).
Definition mean (Q : 'I_(size ps) -> 'I_decisions -> R) i : R := \sum_u Q i u * worth_of i u.

(* Two pools of one block *)
Definition are_compared (i j : 'I_(size ps)) : bool := (of_block (pool_at i) == of_block (pool_at j)) && (i != j).

(* The greatest quotient of two means that are compared is at most r, or at least r; 0/0 = 1, and none: infinite. *)
Definition ratio_at_most Q (r : option QArith_base.Q) : Prop :=
  if r is Some r then forall i j, are_compared i j -> mean Q i <= ratio r * mean Q j else True.
Definition means_at_least (E : 'I_(size ps) -> R) (r : option QArith_base.Q) : Prop :=
  match r with
  | Some r => ratio r <= 1 :> R \/ exists i j, [/\ are_compared i j, ratio r * E j <= E i & 0 < E i]
  | None => exists i j, [/\ are_compared i j, E j = 0 & 0 < E i]
  end.
Definition ratio_at_least Q : option QArith_base.Q -> Prop := means_at_least (mean Q).

(* ---- The draws ---- *)

Variables (D : finType) (pool_of : D -> 'I_(size ps)). (* from which pool each draw is *)

(* The pools with the counts of other data in the place of their own *)
Definition counted_again (w : {ffun D -> 'I_decisions}) : list pool :=
  [seq Pool (of_block (pool_at i)) (values (pool_at i)) [seq Z.of_nat #|[set d | (pool_of d == i) && (w d == u)]| | u <- enum 'I_decisions]
  | i <- enum 'I_(size ps)].

(* The draws of a pool are independent, each with its law; of independent pools all draws are. *)
Definition drawn_from Q (independent_pools : bool) (P : {ffun D -> 'I_decisions} -> R) : Prop :=
  if independent_pools then forall w, P w = Draws.drawn pool_of Q w else law P /\ forall i, Draws.within pool_of Q P i.

(* What is settled before the draws; levels are not. *)
Definition alike (i j : interval) : Prop := [/\ confidence j = confidence i, each j = each i & independent j = independent i].

(* Somebody can write an interval about the data that is accepted and wrong. *)
Definition can_mislead (i : interval) (is_wrong : interval -> Prop) w : Prop :=
  exists j, [/\ alike i j, proved_by_pools j (counted_again w) & is_wrong j].

Definition seldom (P : {ffun D -> 'I_decisions} -> R) (i : interval) (is_wrong : interval -> Prop) : Prop :=
  forall S : {set {ffun D -> 'I_decisions}}, (forall w, w \in S -> can_mislead i is_wrong w) -> prob P S <= 1 - ratio (confidence i).

(* The same of intervals by ladders for pairs of cells, of which the levels are no choice *)
Definition alike_pairs (i j : Pairs.by_pairs) : Prop := Pairs.sure_at j = Pairs.sure_at i /\ Pairs.one_by_one j = Pairs.one_by_one i.

Definition seldom_by_pairs (P : {ffun D -> 'I_decisions} -> R) (i : Pairs.by_pairs) (is_wrong : Pairs.by_pairs -> Prop) : Prop :=
  forall S : {set {ffun D -> 'I_decisions}},
    (forall w, w \in S -> exists j, [/\ alike_pairs i j, proved_by_ladders j (counted_again w) & is_wrong j]) -> prob P S <= 1 - ratio (Pairs.sure_at i).
End Population.

(* Whatever the means are whose ratio is at least this: some two groups are compared of which every explanation by a hidden factor that is too
   weak leaves a ratio above the number, at some value of the factor. *)
Definition hidden_needs (R : realFieldType) (T : table) (local : bool) (least v : option QArith_base.Q) (ls : list Statements.level) : Prop :=
  (if ls is l :: _ then ratio (Statements.down_to l) = 1 :> R /\ Meaning.extended R v = Meaning.extended R (Statements.balanced l) else False) /\
  exists ps, pools_of T local = Some ps /\
    forall (E : 'I_(size ps) -> R) (l : Statements.level),
    means_at_least E least -> List.In l ls ->
    exists i j, are_compared i j /\
      forall (V : finType) (k m : R) (p q e e' : V -> R), 1 <= k -> 1 <= m -> Meaning.too_weak l k m ->
        Meaning.explained_by k m p q e e' (E i) (E j) ->
        exists v, ~~ Meaning.no_more (Meaning.quotient (e v) (e' v)) (Some (ratio (Statements.down_to l))).

(* Both ends hold together at the confidence, or each of them by itself. *)
Definition box_holds (R : realFieldType) (T : table) (local : bool) (i : interval) : Prop :=
  exists ps, [/\ pools_of T local = Some ps, proved_by_pools i ps &
    let d := Z.to_nat (decisions T) in
    forall (Q : 'I_(size ps) -> 'I_d -> R) (D : finType) (pool_of : D -> 'I_(size ps)) (P : {ffun D -> 'I_d} -> R),
    kernel Q -> drawn_from pool_of Q (independent i) P ->
    let above j := ~ ratio_at_most Q (most j) in
    let below j := ~ ratio_at_least Q (least j) in
    if each i then seldom pool_of P i above /\ seldom pool_of P i below
    else seldom pool_of P i (fun j => above j \/ below j)].

(* Likewise by ladders for pairs of cells, which are for independent cells only *)
Definition pairs_hold (R : realFieldType) (T : table) (local : bool) (i : Pairs.by_pairs) : Prop :=
  exists ps, [/\ pools_of T local = Some ps, proved_by_ladders i ps &
    let d := Z.to_nat (decisions T) in
    forall (Q : 'I_(size ps) -> 'I_d -> R) (D : finType) (pool_of : D -> 'I_(size ps)) (P : {ffun D -> 'I_d} -> R),
    kernel Q -> drawn_from pool_of Q true P ->
    let above j := ~ ratio_at_most Q (Pairs.highest j) in
    let below j := ~ ratio_at_least Q (Some (Pairs.lowest j)) in
    if Pairs.one_by_one i then seldom_by_pairs pool_of P i above /\ seldom_by_pairs pool_of P i below
    else seldom_by_pairs pool_of P i (fun j => above j \/ below j)].

Definition population_holds (R : realFieldType) (T : table) (local : bool) (e : proof) : Prop :=
  match e with
  | By_box i => box_holds R T local i
  | By_pairs i => pairs_hold R T local i
  | By_bets i => local /\ BetsMeaning.bets_hold R T i
  end.
