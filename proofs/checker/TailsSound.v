(* The program of Tails.v is right: what it accepts is so in every ordered field. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Binomial.
From FairauditKernel Require Import FractionsSound.
From FairauditChecker Require Import Tails.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Sound.
Variable R : realFieldType.
Local Notation embed := (@embed R).
Local Notation ratio := (@ratio R).

Lemma embed_nat m : embed (Z.of_nat m) = m%:R.
Proof. by elim: m => // m IH; rewrite Nat2Z.inj_succ -Z.add_1_l embedD IH mulrS. Qed.

Lemma embed_raised x e : embed (raised x e) = embed x ^+ Pos.to_nat e.
Proof.
elim: e => [e IH|e IH|] /=; rewrite ?embedM ?IH ?expr1 //.
  by rewrite Pos2Nat.inj_xI exprS -exprD; congr (_ * _ ^+ _); lia.
by rewrite Pos2Nat.inj_xO -exprD; congr (_ ^+ _); lia.
Qed.

Lemma embed_power x m : embed (power x (Z.of_nat m)) = embed x ^+ m.
Proof. by case: m => [|m] //; rewrite /power /Z.of_nat embed_raised SuccNat2Pos.id_succ. Qed.

Lemma above_ge x y : 0 < embed y -> embed x <= embed (above x y) * embed y.
Proof.
rewrite -embed0 ltNge embed_leE => /negbTE/Z.leb_gt y0; rewrite -embedM embed_leE; apply/Z.leb_le.
rewrite /above; have := Z.mul_div_le (- x) y y0; lia.
Qed.

Lemma embed_falling m x r : (m <= x)%N -> embed (falling m (Z.of_nat x) r) = embed r * (x ^_ m)%:R.
Proof.
elim: m x r => [|m IH] x r mx; first by rewrite /= ffactn0 mulr1.
case: x mx => // x mx; rewrite -[falling _ _ _]/(falling m (Z.sub (Z.of_nat x.+1) 1) (Z.mul r (Z.of_nat x.+1))).
by rewrite (_ : Z.sub _ 1 = Z.of_nat x) ?IH //; [rewrite embedM ffactnS natrM embed_nat mulrA | lia].
Qed.

Section Terms.
Variables (N : nat) (a b : Z).
Hypotheses (a0 : 0 < embed a) (b0 : 0 < embed b).

(* C(n,j) a^j b^(n-j) *)
Definition term_of j : R := 'C(N, j)%:R * embed a ^+ j * embed b ^+ (N - j).

Lemma term_ge0 j : 0 <= term_of j.
Proof. by rewrite /term_of !mulr_ge0 ?ler0n ?exprn_ge0 // ltW. Qed.

Lemma term_step j : (j < N)%N -> term_of j * ((N - j)%:R * embed a) = term_of j.+1 * (j.+1%:R * embed b).
Proof.
move=> jN; have := mul_bin_left N j => /(congr1 (fun m => m%:R : R)); rewrite !natrM => e.
rewrite /term_of -(subnSK jN) !exprS.
transitivity ((N - j)%:R * 'C(N, j)%:R * (embed a * embed a ^+ j * embed b ^+ (N - j.+1) * embed b)); first by rewrite subnSK //; ring.
by rewrite -e; ring.
Qed.

Lemma odds (i : nat) : (i < N)%N -> embed (Z.mul (Z.add (Z.sub (Z.of_nat N) (Z.of_nat i.+1)) 1) a) = (N - i)%:R * embed a.
Proof. by move=> iN; rewrite embedM (_ : Z.add _ 1 = Z.of_nat (N - i)) ?embed_nat //; lia. Qed.

(* Where a step down does not make the term greater, no later one does. *)
Lemma falls m j : (m < N)%N -> m.+1%:R * embed b <= (N - m)%:R * embed a -> (j <= m.+1)%N -> term_of j <= term_of m.+1.
Proof.
move=> mN down; move: {j}(m.+1 - j)%N {-2}j (erefl (m.+1 - j)%N) => k; elim: k => [|k IH] j e jm.
  by have -> : j = m.+1 by lia.
have jN : (j < N)%N by lia.
apply: (@le_trans _ _ (term_of j.+1)); last by apply: IH; lia.
have c0 : 0 < (N - j)%:R * embed a by rewrite mulr_gt0 // ltr0n subn_gt0.
rewrite -(ler_pmul2r c0) term_step //; apply: ler_wpmul2l; first exact: term_ge0.
apply: le_trans (_ : (N - m)%:R * embed a <= _); last by rewrite ler_pmul2r // ler_nat; lia.
by apply: le_trans down; rewrite ler_pmul2r // ler_nat; lia.
Qed.

Lemma sum_down_ge m term result T X : (m <= N)%N -> 0 <= T -> 0 <= X -> term_of m * X <= embed term * T ->
  (\sum_(j < m) term_of j) * X + embed result * T <= embed (sum_down m (Z.of_nat N) (Z.of_nat m) a b term result) * T.
Proof.
move=> mN T0 X0; elim: m mN term result => [|m IH] mN term result le_m; first by rewrite big_ord0 mul0r add0r.
pose up := Z.mul (Z.of_nat m.+1) b; pose down := Z.mul (Z.add (Z.sub (Z.of_nat N) (Z.of_nat m.+1)) 1) a.
have upE : embed up = m.+1%:R * embed b by rewrite embedM embed_nat.
have downE : embed down = (N - m)%:R * embed a by rewrite /down odds.
have down0 : 0 < embed down by rewrite downE mulr_gt0 // ltr0n subn_gt0.
pose next := above (Z.mul term up) down.
rewrite -[sum_down _ _ _ _ _ _ _]/(if Z.eqb term 1 && Z.leb up down then Z.add result (Z.of_nat m.+1) else
  sum_down m (Z.of_nat N) (Z.sub (Z.of_nat m.+1) 1) a b next (Z.add result next)).
case: ifP => [/andP[/Z.eqb_eq term1]|_].
  rewrite -(embed_leE R) upE downE => far; rewrite embedD embed_nat mulrDl addrC ler_add2l mulr_suml.
  apply: (@le_trans _ _ (\sum_(j < m.+1) T)); last by rewrite sumr_const card_ord mulr_natl.
  apply: ler_sum => j _; move: le_m; rewrite term1 embed1 mul1r; apply: le_trans.
  by rewrite ler_wpmul2r // (falls mN far) // ltnW.
have next_ge : term_of m * X <= embed next * T.
  rewrite -(ler_pmul2r down0) mulrAC downE term_step // -upE -downE.
  apply: (@le_trans _ _ (embed (Z.mul term up) * T)); first by rewrite embedM mulrAC [X in _ <= X]mulrAC ler_wpmul2r // upE mulr_ge0 ?ler0n ?ltW.
  by rewrite [X in _ <= X]mulrAC ler_wpmul2r // above_ge.
have -> : Z.sub (Z.of_nat m.+1) 1 = Z.of_nat m by lia.
apply: le_trans (IH (ltnW mN) next (Z.add result next) next_ge).
by rewrite big_ord_recr /= embedD !mulrDl -addrA ler_add2l addrC ler_add2l.
Qed.

(* m! times the sum *)
Definition sum_of m : R := \sum_(j < m.+1) term_of j.

Lemma sum_upE m many term result : (many + m <= N)%N -> embed term = (N ^_ m)%:R * embed a ^+ m ->
  embed result * embed b ^+ (N - m) = m`!%:R * sum_of m ->
  embed (sum_up many (Z.of_nat N) (Z.of_nat m.+1) a b term result) * embed b ^+ (N - (many + m)) = (many + m)`!%:R * sum_of (many + m).
Proof.
elim: many m term result => [|many IH] m term result mN termE resultE; first exact: resultE.
pose next := Z.mul (Z.mul term (Z.add (Z.sub (Z.of_nat N) (Z.of_nat m.+1)) 1)) a.
rewrite -[sum_up _ _ _ _ _ _ _]/(sum_up many (Z.of_nat N) (Z.add (Z.of_nat m.+1) 1) a b next
  (Z.add (Z.mul (Z.mul result (Z.of_nat m.+1)) b) next)).
have -> : Z.add (Z.of_nat m.+1) 1 = Z.of_nat m.+2 by lia.
have nextE : embed next = (N ^_ m.+1)%:R * embed a ^+ m.+1.
  rewrite /next -Z.mul_assoc embedM odds ?termE; last by lia.
  by rewrite ffactnSr natrM exprS; ring.
move: next nextE => next nextE; rewrite addSnnS; apply: IH => //; first by lia.
rewrite embedD !embedM embed_nat mulrDl nextE /sum_of big_ord_recr mulrDr; congr (_ + _).
  transitivity (m.+1%:R * (embed result * embed b ^+ (N - m))); last by rewrite resultE factS natrM mulrA.
  by rewrite -(subnSK (_ : m < N)%N) ?exprS; [ring | lia].
by rewrite /term_of /= -bin_ffact natrM; ring.
Qed.

End Terms.

(* The sum of the terms is the tail, times what all terms add up to. *)
Lemma tail_of_terms N k (a b : Z) : 0 < embed (Z.add a b) -> (k <= N)%N ->
  at_most N (embed a / embed (Z.add a b)) k * embed (Z.add a b) ^+ N = \sum_(j < k.+1) term_of N a b j.
Proof.
move=> d0 kN; rewrite /at_most mulr_suml; apply: eq_bigr => j _; have jN : (j <= N)%N by apply: leq_trans kN; rewrite -ltnS.
have d1 : embed (Z.add a b) != 0 by rewrite gt_eqF.
rewrite /successes /term_of (_ : 1 - embed a / embed (Z.add a b) = embed b / embed (Z.add a b)); last first.
  by rewrite -{1}(divff d1) -mulrBl embedD addrC addKr.
rewrite !expr_div_n (_ : embed (Z.add a b) ^+ N = embed (Z.add a b) ^+ j * embed (Z.add a b) ^+ (N - j)); last by rewrite -exprD subnKC.
move: (expf_neq0 j d1) (expf_neq0 (N - j) d1); move: (embed (Z.add a b) ^+ j) (embed (Z.add a b) ^+ (N - j)) => x y x0 y0.
by rewrite [LHS]mulrACA divfK // -[X in X * _]mulrA divfK.
Qed.

Lemma unit_gt0 : 0 < embed unit. Proof. by rewrite (embed_power 2 256) exprn_gt0 // embed_pos. Qed.

Lemma odds_at_mostP N k a b level : 0 < embed a -> 0 < embed b -> (k < N)%N ->
  odds_at_most (Z.of_nat N) (Z.of_nat k) a b level -> at_most N (embed a / embed (Z.add a b)) k <= ratio level.
Proof.
move=> a0 b0 kN; have d0 : 0 < embed (Z.add a b) by rewrite embedD addr_gt0.
have dN : 0 < embed (Z.add a b) ^+ N by rewrite exprn_gt0.
have fk : 0 < k`!%:R :> R by rewrite ltr0n fact_gt0.
have l0 : 0 < embed (Zpos (Qden level)) by exact: embed_pos.
have restE : embed (power b (Z.sub (Z.of_nat N) (Z.of_nat k))) = embed b ^+ (N - k).
  by rewrite (_ : Z.sub _ _ = Z.of_nat (N - k)) ?embed_power //; lia.
have kf : embed (falling k (Z.of_nat k) 1) = k`!%:R by rewrite embed_falling // embed1 mul1r ffactnn.
suff : sum_of N a b k * embed (Zpos (Qden level)) <= embed (Qnum level) * embed (Z.add a b) ^+ N -> at_most N (embed a / embed (Z.add a b)) k <= ratio level.
  move=> enough acc; apply: enough; move: acc; rewrite /odds_at_most Nat2Z.id; move: near unit unit_gt0 => small X X0.
  case: ifP => [|_].
    rewrite -(embed_leE R) !embedM restE !embed_power embed_falling ?(ltnW kN) // kf embed1 mul1r => le_bound _.
    rewrite -(ler_pmul2r fk) -(ler_pmul2r X0).
    have sums : sum_of N a b k * embed X <= embed (sum_down k (Z.of_nat N) (Z.of_nat k) a b X X) * term_of N a b k.
      have le_t : term_of N a b k * embed X <= embed X * term_of N a b k by rewrite mulrC.
      have := sum_down_ge a0 b0 X (ltnW kN) (term_ge0 N a0 b0 k) (ltW X0) le_t.
      by rewrite /sum_of big_ord_recr mulrDl [embed X * _]mulrC.
    move: le_bound; rewrite -bin_ffact natrM => le_bound.
    set down := embed (sum_down _ _ _ _ _ _ _) in le_bound sums.
    rewrite mulrAC; apply: (@le_trans _ _ (down * term_of N a b k * (embed (Zpos (Qden level)) * k`!%:R))).
      rewrite [X in X <= _](_ : _ = sum_of N a b k * embed X * (embed (Zpos (Qden level)) * k`!%:R)); last by ring.
      by rewrite ler_wpmul2r // mulr_ge0 ?ltW.
    by apply: le_trans (le_trans le_bound _); rewrite /term_of le_eqVlt; apply/orP; left; apply/eqP; ring.
  case: ifP => [_|//].
  rewrite -(embed_leE R) !embedM restE embed_power kf => le_sum.
  have start : 1 * embed b ^+ (N - 0) = 0`!%:R * sum_of N a b 0.
    by rewrite /sum_of big_ord1 /term_of bin0 subn0 fact0 expr0 !mul1r.
  have := @sum_upE N a b a0 b0 0 k (Zpos xH) (Zpos xH); rewrite addn0 ffactn0 expr0 embed1 mulr1 => /(_ (ltnW kN) erefl start) sumE.
  rewrite -(ler_pmul2r fk) mulrAC [X in X * _ <= _]mulrC -sumE.
  by apply: le_trans le_sum _; rewrite le_eqVlt; apply/orP; left; apply/eqP; ring.
move=> sum_le; rewrite /FractionsSound.ratio (ler_pdivl_mulr _ _ l0) -(ler_pmul2r dN) [X in X <= _]mulrAC (tail_of_terms d0 (ltnW kN)).
exact: sum_le.
Qed.

Lemma level_ge1 level : Z.leb (Zpos (Qden level)) (Qnum level) -> 1 <= ratio level.
Proof. by move=> le; rewrite /FractionsSound.ratio ler_pdivl_mulr ?embed_pos // mul1r embed_leE. Qed.

(* What the program accepts is so, for the tail of every p from 0 to 1. *)
Theorem tail_at_most_sound N k p level : (k <= N)%N -> 0 <= ratio p <= 1 ->
  tail_at_most (Z.of_nat N) (Z.of_nat k) p level -> at_most N (ratio p) k <= ratio level.
Proof.
move=> kN p01; rewrite /tail_at_most; case: ifP => [_ /level_ge1|/negbT].
  apply: le_trans; rewrite -[leRHS](@at_most_all R N (ratio p) N) //; exact: at_most_le.
rewrite negb_or -Z.ltb_antisym -Z.ltb_antisym => /andP[a0 /Z.ltb_lt kN'].
case: ifP => [b1|/negbT].
  have : 1 <= ratio p by apply: level_ge1; move/Z.leb_le: b1 => b1; apply/Z.leb_le; lia.
  case/andP: p01 => _ p1 p1'; have -> : ratio p = 1 by apply/eqP; rewrite eq_le p1.
  rewrite -(embed_leE R) => l0; have kN1 : (k < N)%N by lia.
  apply: le_trans (_ : 0 <= _); last by rewrite /FractionsSound.ratio divr_ge0 // ltW // embed_pos.
  rewrite /at_most big1 // => j _; rewrite /successes subrr expr0n subn_eq0 leqNgt (leq_trans (ltn_ord j) kN1) mulr0 //.
rewrite -Z.ltb_antisym => b0 acc.
have -> : ratio p = embed (Qnum p) / embed (Z.add (Qnum p) (Z.sub (Zpos (Qden p)) (Qnum p))).
  by rewrite /FractionsSound.ratio; congr (_ / embed _); lia.
by apply: odds_at_mostP acc; rewrite ?embed_gt0 //; lia.
Qed.

End Sound.
