(* T18: the search for the worst subgroup may leave out all refinements of a node.

   Reading key.  I is the set of all N rows, S the rows of a node; a refinement of the node has some of them.  [differs_up V S'] says that the mean
   of the rows S' is at most V times that of all other rows, [differs_down V S'] that the mean of the others is at most V times that of S'; so
   max(r, 1/r) <= V is both. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From mathcomp.zify Require Import zify.
From Fairaudit Require Import Rows.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section T18.
Variables (R : realFieldType) (I : finType) (g : I -> R).
Implicit Types (S : {set I}) (j nmin : nat) (V : R).
Local Notation total := (total g).
Local Notation mean := (mean g).
Local Notation top := (top g).
Local Notation bottom := (bottom g).
Local Notation value := (ranked_value g).
Local Notation N := #|I|.
Local Notation Tot := (total setT).

Definition differs_up V S : Prop := mean S <= V * mean (~: S).
Definition differs_down V S : Prop := mean (~: S) <= V * mean S.

(* The tests of a node S at j: no j of its rows can do it. *)
Definition passes_up V S j : Prop := top S j * (N - j)%:R <= V * (Tot - top S j) * j%:R.
Definition passes_down V S j : Prop := (Tot - bottom S j) * j%:R <= V * bottom S j * (N - j)%:R.

Lemma total_others S : total (~: S) = Tot - total S.
Proof.
have -> : Tot = total S + total (~: S) by rewrite [Tot]/Rows.total (big_setID S) /= setTI setTD.
by rewrite addrC addKr.
Qed.

Lemma card_others S : #|~: S| = (N - #|S|)%N.
Proof. by rewrite cardsCs setCK. Qed.

Lemma mean_le V (S B : {set I}) : (0 < #|S|)%N -> (0 < #|B|)%N ->
  (mean S <= V * mean B) = (total S * #|B|%:R <= V * total B * #|S|%:R).
Proof.
move=> A0 B0; rewrite /Rows.mean mulrA ler_pdivr_mulr ?ltr0n // mulrAC ler_pdivl_mulr ?ltr0n //.
Qed.

(* A subgroup of all rows is none: it passes anyway. *)
Lemma passes_all V S j : (j <= #|S|)%N -> ~~ (j < N)%N -> passes_up V S j /\ passes_down V S j.
Proof.
rewrite -leqNgt => jS Nj; have SN : (#|S| <= N)%N := max_card _.
have e : j = #|S| by apply/eqP; rewrite eqn_leq jS (leq_trans SN).
have eS : S = setT by apply/eqP; rewrite eqEcard subsetT cardsT (leq_trans Nj).
have eN : j = N by rewrite e eS cardsT.
have eT : top S j = Tot.
  have := top_bottom g (leq0n #|S|); rewrite subn0 /Rows.bottom subn0 drop_oversize ?size_ranked // big_nil addr0.
  by rewrite e => ->; rewrite eS.
have eB : bottom S j = Tot by rewrite bottomE // e subnn top0 subr0 eS.
by rewrite /passes_up /passes_down eT eB eN subnn subrr !mulr0 mul0r.
Qed.

(* Pruning: tests at all sizes that a refinement may have. *)
Theorem T18_pruning V nmin S : 0 <= V -> (0 < nmin)%N ->
  (forall j, (nmin <= j <= #|S|)%N -> (j < N)%N -> passes_up V S j) ->
  forall S' : {set I}, S' \subset S -> (nmin <= #|S'| < N)%N -> differs_up V S'.
Proof.
move=> V0 n0 test S' sub /andP[nS SN]; have S0 : (0 < #|S'|)%N := leq_trans n0 nS.
rewrite /differs_up mean_le ?card_others ?subn_gt0 // total_others; have le := top_ge g sub.
apply: le_trans (ler_wpmul2r (ler0n _ _) le) _; apply: le_trans (test _ _ SN) _; first by rewrite nS subset_leq_card.
by apply: ler_wpmul2r; rewrite ?ler0n //; apply: ler_wpmul2l => //; rewrite ler_add2l ler_opp2.
Qed.

Theorem T18_pruning_down V nmin S : 0 <= V -> (0 < nmin)%N ->
  (forall j, (nmin <= j <= #|S|)%N -> (j < N)%N -> passes_down V S j) ->
  forall S' : {set I}, S' \subset S -> (nmin <= #|S'| < N)%N -> differs_down V S'.
Proof.
move=> V0 n0 test S' sub /andP[nS SN]; have S0 : (0 < #|S'|)%N := leq_trans n0 nS.
rewrite /differs_down mean_le ?card_others ?subn_gt0 // total_others; have le := bottom_le g sub.
apply: (@le_trans _ _ ((Tot - bottom S #|S'|) * #|S'|%:R)); first by apply: ler_wpmul2r; rewrite ?ler0n //; rewrite ler_add2l ler_opp2.
apply: le_trans (test _ _ SN) _; first by rewrite nS subset_leq_card.
by apply: ler_wpmul2r; rewrite ?ler0n //; apply: ler_wpmul2l.
Qed.

(* ---- The ends of value classes suffice ---- *)

(* A sum that grows by t(j+1) - t(j) = v(j) >= 0; x t(j) + y j + c t(j) j is convex in j while v is constant. *)
Lemma between (t v : nat -> R) x y c j1 j2 j : 0 <= c -> (forall i, (j1 <= i < j2)%N -> t i.+1 = t i + v i) ->
  (forall i, (j1 <= i < j2)%N -> v i = v j1) -> 0 <= v j1 -> (j1 <= j <= j2)%N ->
  let f i := x * t i + y * i%:R + c * t i * i%:R in f j1 <= 0 -> f j2 <= 0 -> f j <= 0.
Proof.
move=> c0 step same v0 /andP[j1j jj2] f f1 f2.
have tE i : (j1 <= i <= j2)%N -> t i = t j1 + (i%:R - j1%:R) * v j1.
  move=> /andP[]; elim: i => [|i IH] lo hi.
    by move: lo; rewrite leqn0 => /eqP->; rewrite subrr mul0r addr0.
  move: lo; rewrite leq_eqVlt => /orP[/eqP<-|]; first by rewrite subrr mul0r addr0.
  rewrite ltnS => lo; rewrite step ?lo // same ?lo // IH ?lo ?(ltnW hi) // -addn1 natrD.
  by ring.
have [e|ne] := eqVneq j1 j2; first by have -> : j = j1 by apply/eqP; rewrite eqn_leq j1j e jj2.
have pos : 0 < j2%:R - j1%:R :> R by rewrite subr_gt0 ltr_nat ltn_neqAle ne (leq_trans j1j jj2).
rewrite -(pmulr_rle0 _ pos); set a : R := j%:R - j1%:R; set b : R := j2%:R - j%:R.
have a0 : 0 <= a by rewrite subr_ge0 ler_nat.
have b0 : 0 <= b by rewrite subr_ge0 ler_nat.
have -> : (j2%:R - j1%:R) * f j = b * f j1 + a * f j2 - a * b * (j2%:R - j1%:R) * (c * v j1).
  by rewrite /f (tE j) ?j1j // (tE j2) ?(leq_trans j1j) ?leqnn // /a /b; ring.
rewrite -[leRHS]addr0 ler_add ?oppr_le0 ?mulr_ge0 ?(ltW pos) // -[leRHS]addr0.
by rewrite ler_add // mulr_ge0_le0.
Qed.

(* Tests at lo and wherever v changes suffice. *)
Lemma between_ends (t v : nat -> R) x y c lo hi : 0 <= c -> (forall i, (i < hi)%N -> t i.+1 = t i + v i) ->
  (forall i, (i < hi)%N -> 0 <= v i) ->
  let f i := x * t i + y * i%:R + c * t i * i%:R in
  (forall j, (lo <= j <= hi)%N -> [|| j == lo, j == hi | v j.-1 != v j] -> f j <= 0) ->
  forall j, (lo <= j <= hi)%N -> f j <= 0.
Proof.
move=> c0 step v0 f ends j /andP[lj jh]; pose e k := [|| k == lo, k == hi | v k.-1 != v k].
have ex1 : exists k, ((lo <= k <= j) && e k)%N by exists lo; rewrite leqnn lj /e eqxx.
have ub k : ((lo <= k <= j) && e k)%N -> (k <= j)%N by case/andP=> /andP[].
have ex2 : exists k, ((j <= k <= hi) && e k)%N by exists hi; rewrite leqnn jh /e eqxx orbT.
case: (ex_maxnP ex1 ub) => j1 /andP[/andP[lj1 j1j] e1] max1; case: (ex_minnP ex2) => j2 /andP[/andP[jj2 j2h] e2] min2.
have j12 := leq_trans j1j jj2.
have [ej|ej] := boolP (e j); first by apply: ends ej; rewrite lj.
have j1lt : (j1 < j)%N by rewrite ltn_neqAle j1j andbT; apply: contraNneq ej => <-.
have inner k : (j1 < k < j2)%N -> ~~ e k.
  move=> /andP[j1k kj2]; apply/negP => ek; case: (leqP k j) => kj.
    by have := max1 k; rewrite ek (leq_trans lj1 (ltnW j1k)) kj leqNgt j1k => /(_ isT).
  by have := min2 k; rewrite ek (ltnW kj) (leq_trans (ltnW kj2) j2h) leqNgt kj2 => /(_ isT).
have same i : (j1 <= i < j2)%N -> v i = v j1.
  case/andP; elim: i => [|i IH]; first by rewrite leqn0 => /eqP->.
  rewrite leq_eqVlt => /orP[/eqP-> //|]; rewrite ltnS => j1i ij2; rewrite -(IH j1i (ltnW ij2)).
  have := inner i.+1; rewrite ltnS j1i ij2 => /(_ isT); rewrite /e !negb_or negbK => /and3P[_ _ /eqP/=->//].
apply: (between (t := t) (v := v) (j1 := j1) (j2 := j2)) => //.
- by move=> i /andP[_ ij2]; apply: step; apply: leq_trans j2h.
- by apply: v0; apply: leq_trans j2h; apply: leq_trans jj2.
- by rewrite j1j.
- by apply: ends e1; rewrite lj1 (leq_trans j12).
- by apply: ends e2; rewrite (leq_trans lj1).
Qed.

Hypothesis g0 : forall i, 0 <= g i.

Lemma value_ge0 S j : (j < #|S|)%N -> 0 <= value S j.
Proof. by move=> /(ranked_value_in g)[i _ ->]. Qed.

(* Tests at n_min and at the ends of value classes beyond it; the node itself is one. *)
Theorem T18_value_classes V nmin S : 1 <= V -> (nmin <= #|S|)%N ->
  (forall j, (nmin <= j <= #|S|)%N -> [|| j == nmin, j == #|S| | value S j.-1 != value S j] -> (j < N)%N -> passes_up V S j) ->
  forall j, (nmin <= j <= #|S|)%N -> passes_up V S j.
Proof.
move=> V1 nS ends j jn; have SN : (#|S| <= N)%N := max_card _.
have passE i : (i <= #|S|)%N -> (N%:R * top S i + (- (V * Tot)) * i%:R + (V - 1) * top S i * i%:R <= 0) =
    (top S i * (N - i)%:R <= V * (Tot - top S i) * i%:R).
  move=> iS; rewrite -[RHS]subr_le0 natrB ?(leq_trans iS) //; congr (_ <= 0); ring.
have /andP[_ jS] := jn; rewrite /passes_up -passE //.
apply: (between_ends (t := top S) (v := value S) (lo := nmin) (hi := #|S|)) => // [|i|i|i].
- by rewrite subr_ge0.
- exact: topS.
- exact: value_ge0.
move=> /andP[ni iS] e; rewrite passE //; have [iN|] := boolP (i < N)%N; first by apply: ends; rewrite ?ni.
by case/(passes_all V iS).
Qed.

Theorem T18_value_classes_down V nmin S : 1 <= V -> (nmin <= #|S|)%N ->
  let worst i := value S (#|S| - i.+1) in
  (forall j, (nmin <= j <= #|S|)%N -> [|| j == nmin, j == #|S| | worst j.-1 != worst j] -> (j < N)%N -> passes_down V S j) ->
  forall j, (nmin <= j <= #|S|)%N -> passes_down V S j.
Proof.
move=> V1 nS worst ends j jn; have SN : (#|S| <= N)%N := max_card _.
have passE i : (i <= #|S|)%N -> ((- (V * N%:R)) * bottom S i + Tot * i%:R + (V - 1) * bottom S i * i%:R <= 0) =
    ((Tot - bottom S i) * i%:R <= V * bottom S i * (N - i)%:R).
  move=> iS; rewrite -[RHS]subr_le0 natrB ?(leq_trans iS) //; congr (_ <= 0); ring.
have /andP[_ jS] := jn; rewrite /passes_down -passE //.
apply: (between_ends (t := bottom S) (v := worst) (lo := nmin) (hi := #|S|)) => // [|i|i|i].
- by rewrite subr_ge0.
- exact: bottomS.
- by move=> iS; apply: value_ge0; rewrite ltn_subrL /= (leq_trans _ iS).
move=> /andP[ni iS] e; rewrite passE //; have [iN|] := boolP (i < N)%N; first by apply: ends; rewrite ?ni.
by case/(passes_all V iS).
Qed.

(* ---- Utilities 0 and 1: one test ---- *)

Hypothesis g01 : forall i, (g i == 0) || (g i == 1).
Definition positives S : {set I} := [set i in S | g i == 1].

Lemma total01 S : total S = #|positives S|%:R.
Proof.
rewrite /Rows.total (bigID (fun i => g i == 1)) /= [X in _ + X]big1 => [|i /andP[_ /negbTE n1]]; last first.
  by have := g01 i; rewrite n1 orbF => /eqP.
rewrite addr0 (eq_bigr (fun=> 1)) => [|i /andP[_ /eqP//]].
by rewrite sumr_const /positives; congr (_ *+ _); apply: eq_card => i; rewrite inE.
Qed.

Lemma positives_le S : (#|positives S| <= #|S|)%N.
Proof. by apply: subset_leq_card; apply/subsetP => i; rewrite inE => /andP[]. Qed.

Lemma top01 S j : (j <= #|S|)%N -> top S j = (minn #|positives S| j)%:R.
Proof.
move=> jS; have sub : positives S \subset S by apply/subsetP => i; rewrite inE => /andP[].
have some k : (k <= #|positives S|)%N -> k%:R <= top S k.
  move=> ks; have [_ [S' [subS' <- _]] _] := rows_extremes g ks.
  have eS : positives S' = S'.
    by apply/setP => i; rewrite inE; case: (boolP (i \in S')) => //= /(subsetP subS'); rewrite inE => /andP[].
  by rewrite -[in X in X <= _]eS -total01; apply: top_ge; apply: subset_trans sub.
apply: le_anti; apply/andP; split.
  have [_ [S' [subS' <- <-]] _] := rows_extremes g jS; rewrite total01 ler_nat leq_min positives_le andbT.
  by apply: subset_leq_card; apply/subsetP => i; rewrite !inE => /andP[/(subsetP subS')-> ->].
have [sj|js] := leqP #|positives S| j; last by apply: some; apply: ltnW.
rewrite -(subnKC sj); have : (#|positives S| + (j - #|positives S|) <= #|S|)%N by rewrite subnKC.
elim: (j - _)%N => [|d IH]; first by rewrite addn0 => _; apply: some.
rewrite addnS => dS; rewrite topS //; apply: le_trans (IH (ltnW dS)) _.
by rewrite ler_addl value_ge0.
Qed.

Lemma bottom01 S j : (j <= #|S|)%N -> bottom S j = (j - (#|S| - #|positives S|))%:R.
Proof.
move=> jS; have sS := positives_le S; rewrite bottomE // total01 top01 ?leq_subr // -natrB ?geq_minl //; congr (_%:R).
by lia.
Qed.

Lemma positives_sub S : #|positives S|%:R <= Tot.
Proof. by rewrite total01 ler_nat; apply: subset_leq_card; apply/subsetP => i; rewrite !inE => /andP[_ ->]. Qed.

Lemma positives_others S : Tot + (#|S| - #|positives S|)%:R <= N%:R.
Proof.
have -> : Tot = #|positives S|%:R + total (~: S) by rewrite total_others -total01 addrC subrK.
have -> : N%:R = #|S|%:R + #|~: S|%:R :> R by rewrite -natrD cardsC.
rewrite natrB ?positives_le // addrAC [X in X + _]addrC subrK ler_add2l total01 ler_nat.
exact: positives_le.
Qed.

(* s positives: the test at max(n_min, s). *)
Theorem T18_zero_one V nmin S : 1 <= V -> (0 < nmin <= #|S|)%N ->
  passes_up V S (maxn nmin #|positives S|) -> forall j, (nmin <= j <= #|S|)%N -> passes_up V S j.
Proof.
set s := #|positives S|; move=> V1 /andP[n0 nS] test j /andP[nj jS].
have V0 : 0 <= V := le_trans ler01 V1; have sS : (s <= #|S|)%N := positives_le S.
have SN : (#|S| <= N)%N := max_card _; have sT : s%:R <= Tot := positives_sub S.
rewrite /passes_up top01 // -/s; have [sj|js] := leqP s j.
  move: test; rewrite /passes_up top01 ?geq_max ?nS // -/s (minn_idPl _) ?leq_maxr // => test.
  apply: (@le_trans _ _ (s%:R * (N - maxn nmin s)%:R)).
    by rewrite ler_wpmul2l ?ler0n // ler_nat leq_sub2l // geq_max nj.
  apply: le_trans test _; apply: ler_wpmul2l; first by rewrite mulr_ge0 ?subr_ge0.
  by rewrite ler_nat geq_max nj.
have ns : maxn nmin s = s by apply/maxn_idPr; apply: leq_trans nj (ltnW js).
have s0 : 0 < s%:R :> R by rewrite ltr0n (leq_trans n0) // (leq_trans nj (ltnW js)).
move: test; rewrite /passes_up ns top01 // -/s minnn mulrC ler_pmul2r // => test.
rewrite mulrC; apply: ler_wpmul2r; first exact: ler0n.
have -> : (N - j)%:R = (N - s)%:R + (s - j)%:R :> R by rewrite -natrD; congr (_%:R); lia.
have -> : V * (Tot - j%:R) = V * (Tot - s%:R) + V * (s - j)%:R by rewrite natrB 1?ltnW //; ring.
by rewrite ler_add // ler_pemull ?ler0n.
Qed.

(* z zeros: the test at max(n_min, z). *)
Theorem T18_zero_one_down V nmin S : 1 <= V -> (0 < nmin <= #|S|)%N ->
  passes_down V S (maxn nmin (#|S| - #|positives S|)) -> forall j, (nmin <= j <= #|S|)%N -> passes_down V S j.
Proof.
set s := #|positives S|; set z := (#|S| - s)%N; move=> V1 /andP[n0 nS] test j /andP[nj jS].
have V0 : 0 <= V := le_trans ler01 V1; have sS : (s <= #|S|)%N := positives_le S.
have SN : (#|S| <= N)%N := max_card _; have sT : s%:R <= Tot := positives_sub S.
have zS : (maxn nmin z <= #|S|)%N by rewrite geq_max nS leq_subr.
move: test; rewrite /passes_down !bottom01 // -/s -/z; have [nz|zn] := leqP nmin z.
  rewrite subnn subr0 mulr0 mul0r => test.
  have z0 : 0 < z%:R :> R by rewrite ltr0n (leq_trans n0).
  have T0 : Tot = 0.
    apply: le_anti; rewrite (le_trans (ler0n _ _) sT) andbT.
    by move: test; rewrite -[X in _ <= X](mul0r z%:R) ler_pmul2r.
  have s0 : s = 0%N by apply/eqP; rewrite -leqn0 -(ler_nat R); apply: le_trans sT _; rewrite T0.
  have -> : (j - z = 0)%N by apply/eqP; rewrite subn_eq0 /z s0 subn0.
  by rewrite T0 subrr mul0r mulr0 mul0r.
have [-> //|ne] := eqVneq j nmin; have {ne nj} nj : (nmin < j)%N by rewrite ltn_neqAle eq_sym ne.
have DN : Tot + z%:R <= N%:R := positives_others S.
have sz : (s + z = #|S|)%N by rewrite /z subnKC.
clearbody z; have zj := ltn_trans zn nj; rewrite !natrB ?(ltnW zn) ?(ltnW zj) ?(leq_trans _ SN) // => test.
set D := Tot + z%:R in DN.
have a0 : 0 < nmin%:R - z%:R :> R by rewrite subr_gt0 ltr_nat.
have b0 : 0 < N%:R - nmin%:R :> R by rewrite subr_gt0 ltr_nat (leq_trans nj) // (leq_trans jS).
have c0 : 0 <= j%:R - z%:R :> R by rewrite subr_ge0 ler_nat ltnW.
have d0 : 0 <= N%:R - j%:R :> R by rewrite subr_ge0 ler_nat (leq_trans jS).
have e0 : 0 <= j%:R - nmin%:R :> R by rewrite subr_ge0 ler_nat ltnW.
have f0 : 0 <= D - j%:R.
  rewrite subr_ge0 -ler_subl_addr; apply: le_trans sT.
  by rewrite ler_subl_addr -natrD ler_nat sz.
rewrite -(ler_pmul2r a0) -(ler_pmul2r b0).
have le1 : (D - j%:R) * (N%:R - nmin%:R) <= (D - nmin%:R) * (N%:R - j%:R).
  rewrite -subr_ge0 [leRHS](_ : _ = (N%:R - D) * (j%:R - nmin%:R)); last by ring.
  by apply: mulr_ge0 => //; rewrite subr_ge0.
have le2 : j%:R * (nmin%:R - z%:R) <= nmin%:R * (j%:R - z%:R) :> R.
  rewrite -subr_ge0 [leRHS](_ : _ = z%:R * (j%:R - nmin%:R)); last by ring.
  by rewrite mulr_ge0 ?ler0n.
have -> : (Tot - (j%:R - z%:R)) * j%:R * (nmin%:R - z%:R) * (N%:R - nmin%:R) =
  ((D - j%:R) * (N%:R - nmin%:R)) * (j%:R * (nmin%:R - z%:R)) by rewrite /D; ring.
apply: (@le_trans _ _ (((D - nmin%:R) * (N%:R - j%:R)) * (nmin%:R * (j%:R - z%:R)))).
  by apply: ler_pmul => //; rewrite mulr_ge0 ?ler0n ?(ltW b0) ?(ltW a0).
have -> : (D - nmin%:R) * (N%:R - j%:R) * (nmin%:R * (j%:R - z%:R)) =
  ((Tot - (nmin%:R - z%:R)) * nmin%:R) * ((N%:R - j%:R) * (j%:R - z%:R)) by rewrite /D; ring.
have -> : V * (j%:R - z%:R) * (N%:R - j%:R) * (nmin%:R - z%:R) * (N%:R - nmin%:R) =
  (V * (nmin%:R - z%:R) * (N%:R - nmin%:R)) * ((N%:R - j%:R) * (j%:R - z%:R)) by ring.
by apply: ler_wpmul2r; rewrite ?ler0n //; rewrite mulr_ge0.
Qed.

End T18.

(* ---- An instance: two rows of utility 1 pass every test with V = 1 ---- *)

Theorem T18_example (R : realFieldType) : let g (i : bool) : R := 1 in
  (forall i, (g i == 0) || (g i == 1)) /\ forall j, (1 <= j <= #|[set: bool]|)%N -> passes_up g 1 setT j /\ passes_down g 1 setT j.
Proof.
move=> g; have g0 i : 0 <= g i by apply: ler01.
have g01 i : (g i == 0) || (g i == 1) by rewrite eqxx orbT.
have pos : #|positives g setT| = 2%N by rewrite /positives (eq_card (B := setT)) ?cardsT ?card_bool // => i; rewrite !inE eqxx.
have two : #|[set: bool]| = 2%N by rewrite cardsT card_bool.
have tot : total g setT = 2%:R by rewrite total01 // pos.
split=> // j; rewrite two => j2; rewrite /passes_up /passes_down top01 ?bottom01 ?two ?pos ?card_bool ?tot //; try by case/andP: j2.
by case/andP: j2; case: j => [|[|[|j]]] //= _ _; rewrite /minn /= ?subnn ?subn1 ?subn0 ?mul1r ?mulr1 -?natrB ?subrr ?mul0r ?mulr0.
Qed.
