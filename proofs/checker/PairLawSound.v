(* The binomial laws of PairLaw.v are bounds of the true ones, in every ordered field. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Binomial.
From FairauditKernel Require Import FractionsSound.
From FairauditChecker Require Import Tails TailsSound PairLaw.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Lemma of_nat_next i : Z.of_nat i.+1 = Z.add (Z.of_nat i) 1. Proof. lia. Qed.
Lemma of_nat_last i : Z.of_nat i = Z.sub (Z.of_nat i.+1) 1. Proof. lia. Qed.

Lemma index_down m d i : (i < d)%N -> (d <= m)%N -> (m - d + i = m - (0 + (d - i.+1)).+1)%N. Proof. lia. Qed.
Lemma index_up m d i : (d <= i)%N -> (d <= m)%N -> (m - d + i = m + (i - d))%N. Proof. lia. Qed.
Lemma index_start m d : (d <= m)%N -> Z.sub (Z.of_nat m) (Z.of_nat d) = Z.of_nat (m - d). Proof. lia. Qed.

Section Sound.
Variable R : realFieldType.
Local Notation embed := (@embed R).
Local Notation ratio := (@ratio R).

Lemma above_lt x y : 0 < embed y -> embed (above x y) * embed y <= embed x + embed y.
Proof.
rewrite -embed0 ltNge embed_leE => /negbTE/Z.leb_gt y0; rewrite -embedM -embedD embed_leE; apply/Z.leb_le.
by rewrite /above; have := Z.mul_succ_div_gt (- x) y y0; lia.
Qed.

Lemma parts_of_all (B D F U E : R) : 0 <= B -> 0 <= E -> F + U + D <= B + (D + (F + (U + E))).
Proof. by move=> B0 E0; rewrite -subr_ge0 (_ : _ - _ = B + E); [rewrite addr_ge0 | ring]. Qed.

(* ---- One side of the mode ---- *)

Section Side.
Variables (s : nat -> R) (C D : nat) (a b : Z).
Hypotheses (a0 : 0 < embed a) (b0 : 0 < embed b) (s0 : forall i, 0 <= s i).
Hypothesis quotient : forall i, (i < C)%N -> s i.+1 * ((D + i)%:R * embed b) = s i * ((C - i)%:R * embed a).
Hypothesis falls : C%:R * embed a <= D%:R * embed b.

Let X i : R := (D + i)%:R * embed b.
Let Y i : R := (C - i)%:R * embed a.

Lemma X_up i j : (i <= j)%N -> X i <= X j.
Proof. by move=> ij; rewrite /X ler_pmul2r // ler_nat leq_add2l. Qed.

Lemma Y_down i j : (i <= j)%N -> Y j <= Y i.
Proof. by move=> ij; rewrite /Y ler_pmul2r // ler_nat leq_sub2l. Qed.

Lemma Y_ge0 i : 0 <= Y i. Proof. by rewrite /Y mulr_ge0 ?ler0n // ltW. Qed.

Lemma Y_le_X i : Y i <= X i.
Proof. by apply: le_trans (Y_down (leq0n i)) _; apply: le_trans (X_up (leq0n i)); rewrite /X /Y subn0 addn0. Qed.

Lemma Y_lt_X i : (0 < i)%N -> Y i < X i.
Proof.
move=> i0; apply: le_lt_trans (Y_down (leq0n i)) _; apply: lt_le_trans (X_up i0); rewrite /X /Y subn0.
by apply: le_lt_trans falls _; rewrite ltr_pmul2r // ltr_nat addn1.
Qed.

(* Quotients fall, so that a geometric series bounds what comes after a term. *)
Lemma geometric m i : (m + i = C)%N -> (\sum_(i.+1 <= k < C.+1) s k) * (X i - Y i) <= s i * Y i.
Proof.
elim: m i => [|m IH] i mi; first by rewrite big_geq ?mul0r ?(mulr_ge0 (s0 i) (Y_ge0 i)) // -mi.
have iC : (i < C)%N by rewrite -mi addSn ltnS leq_addl.
rewrite big_ltn; last by rewrite ltnS.
have := IH i.+1; rewrite addnS -addSn => /(_ mi).
set T := \sum_(_ <= _ < _) _ => le_T; have T0 : 0 <= T by apply: sumr_ge0.
rewrite /Y -(quotient iC) -/(X i) -/(Y i) mulrDl mulrBr -addrA ger_addl addrC subr_le0.
apply: (@le_trans _ _ (T * (X i.+1 - Y i.+1))).
  by rewrite ler_wpmul2l // ler_sub ?X_up ?Y_down.
by apply: le_trans le_T _; rewrite ler_wpmul2l // Y_down.
Qed.

Lemma sideS m count divisor i term done least : side m.+1 count divisor i term a b done least =
  if Z.ltb i term then
    let next := above (Z.mul term (Z.mul count a)) (Z.mul divisor b) in
    side m (Z.sub count 1) (Z.add divisor 1) (Z.add i 1) next a b (next :: done) (Z.add least (Z.sub next (Z.add i 1)))
  else (done, above (Z.mul term (Z.mul count a)) (Z.sub (Z.mul divisor b) (Z.mul count a)), least).
Proof. by []. Qed.

Lemma beyond_bounds c i term : (c + i = C)%N -> s i <= embed term -> (0 < i)%N || (c == 0)%N ->
  \sum_(i.+1 <= k < C.+1) s k
  <= embed (above (Z.mul term (Z.mul (Z.of_nat c) a)) (Z.sub (Z.mul (Z.of_nat (D + i)) b) (Z.mul (Z.of_nat c) a))).
Proof.
move=> ci low; case: (eqVneq c 0%N) ci => [-> ci _|c0 ci /orP[i0|//]].
  rewrite Z.mul_0_l Z.mul_0_r Z.sub_0_r big_geq; last by rewrite -ci.
  by rewrite (_ : above _ _ = Z0) ?embed0 // /above Z.opp_0 Zdiv_0_l.
have cE : (c = C - i)%N by rewrite -ci addnK.
set down := Z.mul (Z.of_nat (D + i)) b; set up := Z.mul (Z.of_nat c) a.
have downE : embed down = X i by rewrite embedM embed_nat.
have upE : embed up = Y i by rewrite /up embedM embed_nat cE.
have gap0 : 0 < embed (Z.sub down up) by rewrite -Z.add_opp_r embedD embedN downE upE subr_gt0 Y_lt_X.
rewrite -(ler_pmul2r gap0); apply: le_trans (above_ge _ gap0).
rewrite -Z.add_opp_r embedD embedN embedM downE upE; apply: le_trans (geometric ci) _.
by rewrite ler_wpmul2r ?Y_ge0.
Qed.

Lemma side_bounds m c i term done least : (c + i = C)%N -> (m <= c)%N -> [|| 0 < m, 0 < i | c == 0]%N ->
  s i <= embed term -> embed term <= s i + i%:R -> (i = 0%N -> Z.ltb 0 term) ->
  let r := side m (Z.of_nat c) (Z.of_nat (D + i)) (Z.of_nat i) term a b done least in
  exists us, [/\ r.1.1 = catrev us done, (size us <= m)%N,
    forall k, (k < size us)%N -> s (i + k).+1 <= embed (nth Z0 us k),
    \sum_((i + size us).+1 <= k < C.+1) s k <= embed r.1.2
    & embed r.2 <= embed least + \sum_(i.+1 <= k < (i + size us).+1) s k].
Proof.
elim: m c i term done least => [|m IH] c i term done least mi mc enough_ low high first.
  exists [::]; split=> //; rewrite ?addn0 ?[in X in _ <= _ + X]big_geq ?addr0 //=.
  by apply: beyond_bounds => //; rewrite ltnn in enough_.
case: c mi mc enough_ => [//|c] mi; rewrite ltnS => mc _.
have iC : (i < C)%N by rewrite -mi addSn ltnS leq_addl.
have mE : (c.+1 = C - i)%N by rewrite -mi addnK.
rewrite sideS; set down := Z.mul (Z.of_nat (D + i)) b; set up := Z.mul (Z.of_nat c.+1) a.
have downE : embed down = X i by rewrite embedM embed_nat.
have upE : embed up = Y i by rewrite /up embedM embed_nat mE.
have X0 : 0 < X i.
  case: (posnP i) => [i0|/Y_lt_X]; last by apply: le_lt_trans; apply: Y_ge0.
  apply: lt_le_trans (Y_le_X i); by rewrite /Y mulr_gt0 // ltr0n -mE.
case: ifP => [more|stop]; last first.
  exists [::]; split=> //=; rewrite ?addn0 ?[in X in _ <= _ + X]big_geq ?addr0 //.
  have i0 : (0 < i)%N by rewrite lt0n; apply/eqP => e; move: (first e); move: stop; rewrite e /= => ->.
  by apply: beyond_bounds => //; rewrite i0.
set next := above _ _.
have next_ge : s i.+1 <= embed next.
  rewrite -(ler_pmul2r X0) /X (quotient iC) -/(Y i) -/(X i) -downE.
  apply: le_trans (above_ge _ _); last by rewrite downE.
  by rewrite embedM upE ler_wpmul2r // Y_ge0.
have next_le : embed next <= s i.+1 + i.+1%:R.
  rewrite -(ler_pmul2r X0) -[in X in X <= _]downE; apply: le_trans (above_lt _ _) _; first by rewrite downE.
  rewrite embedM upE downE mulrDl {2}/X (quotient iC) -/(Y i) -[in X in _ <= _ + X]addn1 natrD mulrDl mul1r addrA ler_add2r.
  apply: (@le_trans _ _ ((s i + i%:R) * Y i)); first by rewrite ler_wpmul2r // Y_ge0.
  by rewrite mulrDl ler_add2l ler_wpmul2l ?ler0n ?Y_le_X.
have mi1 : (c + i.+1 = C)%N by rewrite addnS.
have some : [|| 0 < m, 0 < i.+1 | c == 0]%N by rewrite orbT.
have := IH c i.+1 next (next :: done) (Z.add least (Z.sub next (Z.add (Z.of_nat i) 1))) mi1 mc some next_ge next_le (fun e => match Nat.neq_succ_0 i e with end).
rewrite addnS (of_nat_next (D + i)) (of_nat_next i) (of_nat_last c).
case=> us [e size_us terms_ beyond sure_]; exists (next :: us); split.
- by rewrite e.
- by rewrite ltnS.
- by case=> [|k] /=; rewrite ?addn0 // ltnS => /terms_; rewrite addnS.
- by rewrite /= addnS -addSn.
apply: le_trans sure_ _; rewrite /= [in X in _ <= _ + X]big_ltn; last by rewrite ltnS addnS leq_addr.
rewrite addSnnS [in X in _ <= X]addrA ler_add2r -!Z.add_opp_r embedD embedD embedN ler_add2l ler_subl_addr.
by rewrite -of_nat_next embed_nat.
Qed.
End Side.

(* ---- Laws ---- *)

(* Numbers f are bounded by the terms of a law one by one, before and after them by sums. *)
Definition bounded n (f : nat -> R) (L : sums) : Prop := exists st,
  [/\ start L = Z.of_nat st, (st + size (terms L) <= n.+1)%N, \sum_(0 <= j < st) f j <= embed (before L),
      forall i, (i < size (terms L))%N -> f (st + i)%N <= embed (nth Z0 (terms L) i)
    & \sum_(st + size (terms L) <= j < n.+1) f j <= embed (after L)].

Lemma eq_bounded_to n f g L : (forall j, (j <= n)%N -> f j = g j) -> bounded n g L -> bounded n f L.
Proof.
move=> e [st [start_ size_ before_ terms_ after_]]; have below j : (j < st)%N -> (j <= n)%N.
  by move=> lt; rewrite -ltnS (leq_trans lt) // (leq_trans _ size_) // leq_addr.
exists st; split=> //.
- by rewrite (eq_big_nat _ _ (F2 := g)) // => j /andP[_ /below/e].
- by move=> i lt; rewrite e ?terms_ // -ltnS (leq_trans _ size_) // ltn_add2l.
- by rewrite (eq_big_nat _ _ (F2 := g)) // => j /andP[_ lt]; apply: e.
Qed.

Lemma eq_bounded n f g L : (forall j, f j = g j) -> bounded n g L -> bounded n f L.
Proof. by move=> e; apply: eq_bounded_to => j _. Qed.

Lemma fixed_gt0 : 0 < embed fixed. Proof. by rewrite (embed_power R 2 64) exprn_gt0 // embed_pos. Qed.

Lemma successes_term N (a b : Z) j : 0 < embed (Z.add a b) -> (j <= N)%N ->
  successes N (embed a / embed (Z.add a b)) j * embed (Z.add a b) ^+ N = term_of R N a b j.
Proof.
move=> d0 jN; have d1 : embed (Z.add a b) != 0 by rewrite gt_eqF.
rewrite /successes /term_of (_ : 1 - embed a / embed (Z.add a b) = embed b / embed (Z.add a b)); last first.
  by rewrite -{1}(divff d1) -mulrBl embedD addrC addKr.
rewrite !expr_div_n (_ : embed (Z.add a b) ^+ N = embed (Z.add a b) ^+ j * embed (Z.add a b) ^+ (N - j)); last by rewrite -exprD subnKC.
move: (expf_neq0 j d1) (expf_neq0 (N - j) d1); move: (embed (Z.add a b) ^+ j) (embed (Z.add a b) ^+ (N - j)) => x y x0 y0.
by rewrite [LHS]mulrACA divfK // -[X in X * _]mulrA divfK.
Qed.

Section Odds.
Variables (n : nat) (a b : Z).
Hypotheses (a0 : 0 < embed a) (b0 : 0 < embed b).
Local Notation t := (term_of R n a b).

Definition mode : nat := Z.to_nat (Z.div (Z.mul (Z.add (Z.of_nat n) 1) a) (Z.add a b)).

Lemma mode_fits : [/\ Z.of_nat mode = Z.div (Z.mul (Z.add (Z.of_nat n) 1) a) (Z.add a b), (mode <= n)%N,
  Z.le (Z.mul (Z.of_nat mode) b) (Z.mul (Z.of_nat (n - mode + 1)) a) & Z.le (Z.mul (Z.of_nat (n - mode)) a) (Z.mul (Z.of_nat (mode + 1)) b)].
Proof.
move: a0 b0; rewrite -!embed0 !ltNge !embed_leE => /negbTE/Z.leb_gt pa /negbTE/Z.leb_gt pb.
have d0 : Z.lt 0 (Z.add a b) by lia.
have low := Z.mul_div_le (Z.mul (Z.add (Z.of_nat n) 1) a) _ d0; have high := Z.mul_succ_div_gt (Z.mul (Z.add (Z.of_nat n) 1) a) _ d0.
rewrite /mode; set m := Z.div _ _ in low high *.
have m0 : Z.le 0 m by apply: Z.div_pos => //; lia.
have mn : Z.lt m (Z.add (Z.of_nat n) 1) by apply: Z.div_lt_upper_bound; nia.
rewrite Z2Nat.id //; split=> //; first by lia.
  by rewrite (_ : Z.of_nat _ = Z.sub (Z.add (Z.of_nat n) 1) m); lia.
rewrite (_ : Z.of_nat (n - _) = Z.sub (Z.of_nat n) m); last by lia.
by rewrite (_ : Z.of_nat (_ + 1) = Z.add m 1); lia.
Qed.

Lemma term_gt0 j : (j <= n)%N -> 0 < t j.
Proof. by move=> jn; rewrite /term_of !mulr_gt0 ?exprn_gt0 // ltr0n bin_gt0. Qed.

Let x : R := embed fixed / t mode.
Let f j : R := t j * x.

Lemma x_gt0 : 0 < x.
Proof. by rewrite divr_gt0 ?fixed_gt0 ?term_gt0 //; case: mode_fits. Qed.

Lemma f_mode : f mode = embed fixed.
Proof. by rewrite /f /x mulrC divfK // gt_eqF // term_gt0 //; case: mode_fits. Qed.

Lemma f_ge0 j : 0 <= f j.
Proof. by rewrite /f mulr_ge0 ?(ltW x_gt0) ?term_ge0. Qed.

Lemma sum_f : \sum_(0 <= j < n.+1) f j = embed (Z.add a b) ^+ n * x.
Proof.
have d0 : 0 < embed (Z.add a b) by rewrite embedD addr_gt0.
rewrite -mulr_suml big_mkord; congr (_ * _).
rewrite -(tail_of_terms d0 (leqnn n)) at_most_all ?mul1r //.
Qed.
Lemma sums_up u v : \sum_(u <= k < v) f (mode + k) = \sum_(mode + u <= j < mode + v) f j.
Proof. by rewrite [(mode + u)%N]addnC [(mode + v)%N]addnC big_addn addnK; apply: eq_bigr => k _; rewrite addnC. Qed.

Lemma sums_down u v : (u <= v)%N -> (v <= mode.+1)%N -> \sum_(u <= k < v) f (mode - k) = \sum_(mode.+1 - v <= j < mode.+1 - u) f j.
Proof.
elim: v => [|v IH] uv vm; first by move: uv; rewrite leqn0 => /eqP->; rewrite !big_geq.
have [e|lt] := leqP v.+1 u; first by rewrite !big_geq // leq_sub2l.
rewrite big_nat_recr //= IH ?(ltnW vm) //.
have shorter : (mode.+1 - v.+1 < mode.+1 - u)%N by rewrite ltn_sub2l // (leq_trans lt).
by rewrite [RHS](big_ltn shorter) addrC subSS subSn.
Qed.

Lemma up_quotient i : (i < n - mode)%N -> f (mode + i.+1) * ((mode + 1 + i)%:R * embed b) = f (mode + i) * ((n - mode - i)%:R * embed a).
Proof.
move=> lt; have jn : (mode + i < n)%N by rewrite -ltn_subRL.
by rewrite /f ![_ * x * _]mulrAC -subnDA term_step // addn1 addSn addnS.
Qed.

Lemma down_quotient i : (i < mode)%N -> f (mode - i.+1) * ((n - mode + 1 + i)%:R * embed a) = f (mode - i) * ((mode - i)%:R * embed b).
Proof.
have [_ mn _ _] := mode_fits; move: (mode) mn => m mn lt; have jn : (m - i.+1 < n)%N by lia.
rewrite /f ![_ * x * _]mulrAC (_ : (n - m + 1 + i = n - (m - i.+1))%N); last by lia.
by rewrite term_step // subnSK.
Qed.

Lemma below_fits : mode%:R * embed b <= (n - mode + 1)%:R * embed a.
Proof. by have [_ _ le _] := mode_fits; rewrite -!embed_nat -!embedM embed_leE; apply/Z.leb_le. Qed.
Lemma above_fits : (n - mode)%:R * embed a <= (mode + 1)%:R * embed b.
Proof. by have [_ _ _ le] := mode_fits; rewrite -!embed_nat -!embedM embed_leE; apply/Z.leb_le. Qed.

Lemma enoughP k c : exists m, [/\ enough (Z.of_nat k) (Z.of_nat c) = m, (m <= c)%N & [|| 0 < m, 0 < 0 | c == 0]%N].
Proof.
exists (enough (Z.of_nat k) (Z.of_nat c)); rewrite /enough; move: (root _) => r; split=> //.
  by case: ifP => [_|/Z.leb_gt]; lia.
have : (0 < Z.to_nat (if Z.leb (Z.of_nat c) (Z.add (Z.max 0 (Z.mul 8 r)) 128) then Z.of_nat c else Z.add (Z.max 0 (Z.mul 8 r)) 128))%N || (c == 0)%N.
  by case: ifP => [_|_]; case: c => [|c]; rewrite ?orbT ?orbF //; lia.
by case/orP=> ->; rewrite ?orbT.
Qed.

Lemma binomial_bounded : bounded n f (binomial (Z.of_nat n) a b) /\ embed (sure (binomial (Z.of_nat n) a b)) <= \sum_(0 <= j < n.+1) f j.
Proof.
have [modeE mn _ _] := mode_fits.
have no_sign (z : Z) : 0 < embed z -> Z.leb z 0 = false by rewrite -embed0 ltNge embed_leE => /negbTE.
rewrite /binomial (no_sign _ a0) (no_sign _ b0) -modeE.
rewrite (_ : Z.sub (Z.of_nat n) (Z.of_nat mode) = Z.of_nat (n - mode)); last by move: (mode) mn => m; lia.
rewrite (_ : Z.add (Z.of_nat (n - mode)) 1 = Z.of_nat (n - mode + 1 + 0)); last by lia.
rewrite (_ : Z.add (Z.of_nat mode) 1 = Z.of_nat (mode + 1 + 0)); last by lia.
have [m1 [-> m1_le m1_some]] := enoughP n (n - mode); have [m2 [-> m2_le m2_some]] := enoughP n mode.
have := @side_bounds (fun i => f (mode + i)) (n - mode) (mode + 1) a b a0 b0 (fun i => f_ge0 _) up_quotient above_fits m1 (n - mode) 0 fixed [::] fixed.
rewrite !addn0 f_mode addr0 => /(_ erefl m1_le m1_some (lexx _) (lexx _) (fun=> isT)).
case: (side _ _ _ _ _ _ _ _ _) => [[up after_] one] /= [us [-> small_us terms_us beyond_us sure_us]].
have := @side_bounds (fun i => f (mode - i)) mode (n - mode + 1) b a b0 a0 (fun i => f_ge0 _) down_quotient below_fits m2 mode 0 fixed [::] one.
rewrite !addn0 subn0 f_mode addr0 => /(_ erefl m2_le m2_some (lexx _) (lexx _) (fun=> isT)).
case: (side _ _ _ _ _ _ _ _ _) => [[down before_] two] /= [ds [-> small_ds terms_ds beyond_ds sure_ds]].
have size_us := leq_trans small_us m1_le; have size_ds := leq_trans small_ds m2_le.
rewrite -[rev_append _ _]/(rev (rev us)) revK -[(_ ++ _)%list]/(rev ds ++ fixed :: us) -[length _]/(size (rev ds)) size_rev.
move: sure_us sure_ds beyond_us beyond_ds; rewrite !add0n sums_up sums_down ?ltnS // sums_up sums_down ?ltnS //.
rewrite subnn !subSS subn0 addn1 !addnS subnKC // => sure_us sure_ds beyond_us beyond_ds; split.
  exists (mode - size ds)%N; rewrite /= size_cat size_rev /= addnA subnK //; split=> //.
  - exact: index_start.
  - by rewrite addnS ltnS -leq_subRL.
  - move=> i; rewrite nth_cat size_rev; case: (ltnP i (size ds)) => [lt _|ge more].
      by rewrite nth_rev // (index_down lt size_ds); apply: terms_ds; rewrite subnSK // leq_subr.
    rewrite (index_up ge size_ds); have : (i - size ds < (size us).+1)%N by rewrite ltn_subLR // addnS -addSn addnC.
    case: (i - size ds)%N => [|k] /=; first by rewrite addn0 f_mode.
    by rewrite ltnS; apply: terms_us.
  - by rewrite addnS.
apply: le_trans sure_ds _; apply: le_trans (ler_add sure_us (lexx _)) _.
have parts : (mode - size ds <= mode)%N by rewrite leq_subr.
have lt_n : (mode + size us < n.+1)%N by rewrite ltnS -leq_subRL.
rewrite (@big_cat_nat _ _ _ (mode - size ds) 0 n.+1) //=; last by rewrite (leq_trans parts) // leqW.
rewrite (@big_cat_nat _ _ _ mode (mode - size ds) n.+1) //=; last by rewrite leqW.
rewrite (@big_ltn _ _ _ mode) ?ltnS // f_mode (@big_cat_nat _ _ _ (mode + size us).+1 mode.+1 n.+1) ?ltnS ?leq_addr //=.
have s0 u v : 0 <= \sum_(u <= j < v) f j by apply: sumr_ge0 => j _; apply: f_ge0.
exact: parts_of_all.
Qed.
End Odds.

Lemma chance_one n q j : q = 1 -> successes n q j = (j == n)%:R :> R.
Proof.
move=> ->; rewrite /successes subrr expr1n mulr1; case: (ltngtP j n) => [lt|gt|->]; last by rewrite binn subnn mulr1.
  by rewrite expr0n subn_eq0 leqNgt lt mulr0.
by rewrite bin_small // mul0r.
Qed.

Lemma chance_zero n q j : q = 0 -> successes n q j = (j == 0%N)%:R :> R.
Proof. by move=> ->; rewrite /successes subr0 expr1n mulr1 expr0n; case: j => [|j]; rewrite ?bin0 ?mulr1 ?mulr0. Qed.

Lemma bounded_point n k : (k <= n)%N -> bounded n (fun j => (j == k)%:R * embed fixed) (Sums (Z.of_nat k) [:: fixed] 0 0 fixed).
Proof.
move=> kn; exists k; split; rewrite /= ?addn1 //.
- by rewrite big_nat big1 // => j /andP[_ jk]; rewrite ltn_eqF // mul0r.
- by case=> // _; rewrite addn0 eqxx mul1r.
- by rewrite big_nat big1 // => j /andP[kj _]; rewrite gtn_eqF // mul0r.
Qed.

(* What the program computes of a law, divided by one number, bounds its chances. *)
Theorem law_bounded n p : 0 <= ratio p <= 1 ->
  exists c, [/\ 0 < c, bounded n (fun j => successes n (ratio p) j * c) (law_at (Z.of_nat n) p) & embed (sure (law_at (Z.of_nat n) p)) <= c].
Proof.
case/andP=> p0 p1; rewrite /law_at; set a := Qnum p; set b := Z.sub _ a.
have dE : Zpos (Qden p) = Z.add a b by rewrite /b; lia.
case: (Z.leb_spec a 0) => [a0|a0].
  have p00 : ratio p = 0 by apply/eqP; rewrite eq_le p0 andbT pmulr_lle0 ?invr_gt0 ?embed_pos // embed_le0 //; apply/Z.leb_le.
  exists (embed fixed); rewrite /binomial (proj2 (Z.leb_le _ _) a0); split=> //; first exact: fixed_gt0.
  by apply: eq_bounded (bounded_point (leq0n n)) => j; rewrite (chance_zero n j p00).
case: (Z.leb_spec b 0) => [b0|b0].
  have p11 : ratio p = 1.
    apply/eqP; rewrite eq_le p1 /FractionsSound.ratio ler_pdivl_mulr ?embed_pos // mul1r embed_leE; apply/Z.leb_le; rewrite dE -/a; lia.
  exists (embed fixed); rewrite /binomial (proj2 (Z.leb_gt _ _) a0) (proj2 (Z.leb_le _ _) b0); split=> //; first exact: fixed_gt0.
  by apply: eq_bounded (bounded_point (leqnn n)) => j; rewrite (chance_one n j p11).
have a0' : 0 < embed a by apply: embed_gt0; apply/Z.ltb_lt.
have b0' : 0 < embed b by apply: embed_gt0; apply/Z.ltb_lt.
have d0 : 0 < embed (Z.add a b) by rewrite embedD addr_gt0.
have [_ mn _ _] := mode_fits n a0' b0'.
have [bound sure_] := binomial_bounded n a0' b0'.
have dn : 0 < embed (Z.add a b) ^+ n by rewrite exprn_gt0.
have x0 : 0 < embed fixed / term_of R n a b (mode n a b) by rewrite divr_gt0 ?fixed_gt0 ?term_gt0.
exists (embed (Z.add a b) ^+ n * (embed fixed / term_of R n a b (mode n a b))); split; first by rewrite mulr_gt0.
  apply: eq_bounded_to bound => j jn; rewrite /FractionsSound.ratio -/a dE mulrA successes_term //.
by apply: le_trans sure_ _; rewrite sum_f.
Qed.
End Sound.
