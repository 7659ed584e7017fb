(* The numbers that rules about policies use are what they should be: e^epsilon, the constants of the utility, expectations. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From Fairaudit Require Import Definitions DP T17.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound PolicyLaw PolicyTable PolicyClaims.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Numbers.
Variable R : realFieldType.
Local Notation number := (@number R).
Local Notation entry := (@entry R).
Implicit Types (v : seq Q).

Lemma number_out v i : (size v <= i)%N -> number v i = 0.
Proof. by move=> h; rewrite /number /PolicyMeaning.number nth_default // ratio_zero. Qed.

Lemma at_mostN q r : at_most q r = false -> ratio r <= ratio q :> R.
Proof. by rewrite /at_most => /Z.leb_gt/Z.lt_le_incl/Z.leb_le; apply: at_mostP. Qed.

Lemma ratio_greater q r : ratio (greater q r) = Num.max (ratio q) (ratio r) :> R.
Proof. by rewrite /greater; case: ifP => [/(at_mostP R)/max_idPr-> | /at_mostN/max_idPl->]. Qed.

Lemma ratio_lesser q r : ratio (lesser q r) = Num.min (ratio q) (ratio r) :> R.
Proof. by rewrite /lesser; case: ifP => [/(at_mostP R)/min_idPl-> | /at_mostN/min_idPr->]. Qed.

Lemma ratio_difference q r : ratio (difference q r) = ratio q - ratio r :> R.
Proof. by rewrite ratio_plus ratio_minus. Qed.

Lemma greatest_of_ge v q : In q v -> ratio q <= ratio (greatest_of v) :> R.
Proof.
case: v => // p v /=; elim: v p => [|r v IH] p /=; first by case=> // ->.
by rewrite ratio_greater le_maxr => -[->|[->|h]]; rewrite ?lexx // IH ?orbT //; [left | right].
Qed.

Lemma least_of_le v q : In q v -> ratio (least_of v) <= ratio q :> R.
Proof.
case: v => // p v /=; elim: v p => [|r v IH] p /=; first by case=> // ->.
by rewrite ratio_lesser le_minl => -[->|[->|h]]; rewrite ?lexx // IH ?orbT //; [left | right].
Qed.

Lemma not_positive q : positive_fraction q = false -> ratio q <= 0 :> R.
Proof.
rewrite /positive_fraction => /Z.ltb_ge/Z.leb_le/(@embed_le0 R) h.
by rewrite /ratio pmulr_lle0 // invr_gt0 embed_pos.
Qed.

Lemma quotientP p q r : quotient p q = Some r -> 0 <= ratio p :> R -> 0 <= ratio q :> R -> 0 <= ratio r :> R /\ ratio p <= ratio r * ratio q :> R.
Proof.
rewrite /quotient; case e: (positive_fraction q) => [|].
  move=> [<-] p0 q0; have q1 := ratio_gt0 R e; rewrite ratio_times ratio_inverse // divfK ?gt_eqF //.
  by rewrite divr_ge0.
case f: (positive_fraction p) => // -[<-] p0 q0; rewrite ratio_one mul1r ler01; split=> //.
exact: le_trans (not_positive f) q0.
Qed.

Lemma nonneg_at v i : (forall j, 0 <= number v j) -> (i < size v)%N -> 0 <= ratio (greatest_of v) :> R.
Proof. by move=> v0 h; apply: le_trans (v0 i) (greatest_of_ge (in_nth zero h)). Qed.

Lemma least_ge0 v : (forall j, 0 <= number v j) -> 0 <= ratio (least_of v) :> R.
Proof.
case: v => [|q v] v0; first by rewrite ratio_zero.
elim: v q v0 => [|r v IH] q v0; first exact: (v0 0%N).
rewrite /= ratio_lesser le_minr (v0 1%N) /=; apply: IH => -[|j]; first exact: (v0 0%N).
exact: (v0 j.+2).
Qed.

(* The greatest ratio of two numbers of a list *)
Lemma widestP v r i j : widest v = Some r -> (forall j, 0 <= number v j) -> (i < size v)%N -> (j < size v)%N ->
  0 <= ratio r :> R /\ number v i <= ratio r * number v j.
Proof.
move=> e v0 hi hj; have [r0 le] := quotientP e (nonneg_at v0 hi) (least_ge0 v0).
split=> //; apply: le_trans (greatest_of_ge (in_nth zero hi)) (le_trans le _).
by apply: ler_wpmul2l => //; apply/least_of_le/in_nth.
Qed.

(* The greatest of several, if none is infinite *)
Lemma greater_ofP (A : Type) (f : A -> option Q) (s : seq A) r : fold_right (both greater) (Some one) (List.map f s) = Some r ->
  1 <= ratio r :> R /\ forall x, In x s -> exists q, f x = Some q /\ ratio q <= ratio r :> R.
Proof.
elim: s r => [|x s IH] r /=; first by case=> <-; rewrite ratio_one.
case e: (f x) => [q|] //; case e': (fold_right _ _ _) => [q'|] // [<-].
have [one_le all] := IH _ e'; rewrite ratio_greater le_maxr one_le orbT; split=> // y [<-|/all[p [ep le]]].
  by exists q; rewrite e le_maxr lexx.
by exists p; rewrite ep le_maxr le orbT.
Qed.

Lemma columnsP n (F : matrix) : (forall i, (i < size F)%N -> size (nth [::] F i) = n) ->
  size (columns n F) = n /\ forall i j, (i < size F)%N -> (j < n)%N ->
    size (nth [::] (columns n F) j) = size F /\ nth zero (nth [::] (columns n F) j) i = nth zero (nth [::] F i) j.
Proof.
elim: F => [|row F IH] rows /=; first by rewrite -size_length repeat_length; split.
have [i|sc cE] := IH; first exact: (rows i.+1).
have row_n : size row = n := rows 0%N isT.
rewrite size_map_list size_combine row_n ?sc //; split=> // i j iF jn.
have at_j : nth [::] (List.map (fun t => t.1 :: t.2) (combine row (columns n F))) j = nth zero row j :: nth [::] (columns n F) j.
  by rewrite (@nth_map_in _ _ (zero, [::])) ?size_combine ?sc ?row_n // nth_combine ?sc ?row_n.
rewrite at_j; case: i iF => [|i] iF; last by have [/= -> ->] := cE i j iF jn.
split=> //=; congr _.+1; case: F {IH rows iF at_j} sc cE => [|r F] sc cE; last by have [] := cE 0%N j isT jn.
by rewrite /= nth_repeat.
Qed.

Lemma columns_size n (F : matrix) j : (forall i, (i < size F)%N -> size (nth [::] F i) = n) -> (j < n)%N ->
  size (nth [::] (columns n F) j) = size F.
Proof.
move=> rows jn; have [sc cE] := columnsP rows; case: F {rows sc} cE => [|row F] cE; last by have [] := cE 0%N j isT jn.
by rewrite /= nth_repeat.
Qed.

(* ---- e^epsilon ---- *)

Lemma factor_epsilonP F e : lawful_matrix R F -> factor_epsilon F = Some e ->
  1 <= ratio e :> R /\ forall i i' j, (i < size F)%N -> (i' < size F)%N -> (j < width F)%N -> entry F i j <= ratio e * entry F i' j.
Proof.
move=> lF /greater_ofP[one_le all]; split=> // i i' j iF iF' jF.
have rows k : (k < size F)%N -> size (nth [::] F k) = width F by move=> /lF[].
have [sc cE] := columnsP rows.
have [|q [qE q_le]] := all (nth [::] (columns (width F) F) j); first by apply: in_nth; rewrite sc.
have [si ei] := cE i j iF jF; have [_ ei'] := cE i' j iF' jF.
have v0 k : 0 <= number (nth [::] (columns (width F) F) j) k.
  case: (ltnP k (size F)) => h; last by rewrite /number /PolicyMeaning.number nth_default ?si // ratio_zero.
  have [_ ek] := cE k j h jF; rewrite /number /PolicyMeaning.number ek; have [_ + _] := lF k h; exact.
have [q0] : 0 <= ratio q :> R /\ number (nth [::] (columns (width F) F) j) i <= ratio q * number (nth [::] (columns (width F) F) j) i'.
  by apply: (widestP qE v0); rewrite si.
rewrite /number /entry /PolicyMeaning.entry /PolicyMeaning.number ei ei' => le.
apply: le_trans le _; apply: ler_wpmul2r => //; have [_ + _] := lF i' iF'; exact.
Qed.

Lemma exp_epsilonP fs e : lawful_filter R fs -> exp_epsilon fs = Some e ->
  1 <= ratio e :> R /\ forall a a' b, (a < inputs_of fs)%N -> (a' < inputs_of fs)%N -> (b < outputs_of fs)%N ->
    entry (multiplied_out fs) a b <= ratio e * entry (multiplied_out fs) a' b.
Proof.
elim: fs e => [|F fs IH] e.
  by move=> _ [<-]; rewrite ratio_one; split=> // -[|//] [|//] b _ _ _; rewrite mul1r.
move=> lFfs; have [lF lfs] := lFfs; rewrite [exp_epsilon _]/(both times (factor_epsilon F) (exp_epsilon fs)).
case eF: (factor_epsilon F) => [e1|] //; case efs: (exp_epsilon fs) => [e2|] // [<-].
have [one1 le1] := factor_epsilonP lF eF; have [one2 le2] := IH _ lfs efs.
rewrite ratio_times; split=> [|a a' b]; first by rewrite -[1]mulr1 ler_pmul ?ler01.
rewrite inputs_cons outputs_cons => /divmod[i1 i2 ->] /divmod[i1' i2' ->] /divmod[j1 j2 ->].
rewrite !product_entry // [X in _ <= X]mulrACA; apply: ler_pmul; [| |exact: le1|exact: le2].
  by have [_ + _] := lF _ i1; apply.
by have [_ + _] := lawful_product lfs i2; apply.
Qed.
End Numbers.

(* ---- A policy and its filters ---- *)

Section Behind.
Variables (R : realFieldType) (S : behind).
Hypothesis ok : valid S.
Local Notation number := (@number R).
Local Notation MX := (@MX R S).
Local Notation MA := (@MA R S).
Local Notation g := (@g R S).

Lemma epsilonP e : epsilon S = Some e -> 1 <= ratio e :> R /\ every_pair (pure_dp (ratio e)) MA.
Proof.
move=> /(exp_epsilonP (group_filter_ok R ok))[one_le le]; split=> // a a' b; apply: le; exact: ltn_ord.
Qed.

Lemma kernel_MA_all : kernel (@MA_all R S).
Proof. exact/kernel_releases/kernel_MA. Qed.

Lemma all_once : releases S = 1%positive -> forall a a' (f : R -> R -> R),
  \sum_w f (MA_all R (S := S) a w) (MA_all R (S := S) a' w) = \sum_b f (MA a b) (MA a' b).
Proof.
move=> e a a' f; have : Pos.to_nat (releases S) = 1%N by rewrite e Pos2Nat.inj_1.
rewrite /MA_all /memory; move: (Pos.to_nat _) => n ->.
rewrite (reindex_onto (fun b => [ffun=> b] : {ffun 'I_1 -> At S}) (fun w => w ord0)) /= => [|w _].
  by apply: eq_big => b; rewrite ?ffunE ?eqxx // => _; rewrite /T17.releases !big_ord1 !ffunE.
by apply/ffunP => i; rewrite ffunE (ord1 i).
Qed.

Lemma pure_all e : one_release S -> every_pair (pure_dp e) MA -> every_pair (pure_dp e) (@MA_all R S).
Proof.
move=> /Pos.eqb_eq one d a a'; have : Pos.to_nat (releases S) = 1%N by rewrite one Pos2Nat.inj_1.
by rewrite /MA_all /memory; move: (Pos.to_nat _) => n -> w; rewrite /T17.releases !big_ord1; apply: d.
Qed.

(* ---- The constants of the utility ---- *)

Hypothesis cons : consistent S.

Lemma in_all_gains x a u : (x < true_contexts S)%N -> (a < true_groups S)%N -> (u < decisions S)%N ->
  In (nth zero (gains S x a) u) (all_gains S).
Proof.
move=> hx ha hu; have [] := gains_ok R ok hx ha; move: ok => /and5P[_ _ _ _ /and4P[_ _ + _]].
rewrite /valid_worth /gains /all_gains; case: (utility S) => [v _ s _|gs /andP[/shapedP[sx sa] _]]; first by apply: in_nth; rewrite s.
rewrite !list_nth => s _; apply/in_concat; exists (nth [::] (nth [::] gs x) a); split; last by apply: in_nth; rewrite s.
apply/in_concat; exists (nth [::] gs x); split; apply: in_nth; by rewrite ?sx ?sa.
Qed.

Lemma g_within u x a : ratio (m_used S) <= g u x a <= ratio (gamma_used S).
Proof.
case/and3P: cons => /(at_mostP R) top /(at_mostP R) low _.
have inside := in_all_gains (ltn_ord x) (ltn_ord a) (ltn_ord u).
by rewrite (le_trans low (least_of_le R inside)) (le_trans (greatest_of_ge R inside) top).
Qed.

Lemma m_le_gamma : ratio (m_used S) <= ratio (gamma_used S) :> R.
Proof.
have := g_within (Ordinal (some_decision ok)) (Ordinal (some_context ok)) (Ordinal (ltnW (two_groups ok))).
by case/andP => /le_trans; apply.
Qed.

Lemma fold_greater (A : Type) (f : A -> Q) (s : seq A) x : In x s ->
  ratio (f x) <= ratio (fold_right (fun y most => greater (f y) most) zero s) :> R.
Proof.
by elim: s => //= y s IH; rewrite ratio_greater le_maxr => -[->|/IH->]; rewrite ?lexx ?orbT.
Qed.

Lemma spread_within u x a a' : g u x a <= g u x a' + ratio (L_used S).
Proof.
case/and3P: cons => _ _ /(at_mostP R) L_ge; rewrite -ler_subl_addl; apply: le_trans L_ge.
move: ok => /and5P[_ _ _ _ /and4P[_ _ + _]].
rewrite /valid_worth /g /gains /spread_of; case: (utility S) => [v _|gs /andP[/shapedP[sx sa] rows_ok]].
  by rewrite subrr ratio_zero.
have in_x : In (nth [::] gs x) gs by apply: in_nth; rewrite sx.
apply: le_trans (fold_greater _ in_x); rewrite !list_nth /spread_in.
have rows i : (i < size (nth [::] gs x))%N -> size (nth [::] (nth [::] gs x) i) = decisions S.
  rewrite sa // => hi; have := @forallb_nth _ [::] _ _ x rows_ok; rewrite sx => /(_ (ltn_ord x)) row_ok.
  by have := @forallb_nth _ [::] _ _ i row_ok; rewrite sa // => /(_ hi)/andP[/longP].
have [sc cE] := columnsP rows.
have in_u : In (nth [::] (columns (decisions S) (nth [::] gs x)) u) (columns (decisions S) (nth [::] gs x)) by apply: in_nth; rewrite sc.
apply: le_trans (fold_greater _ in_u); rewrite ratio_difference.
have at_c (c : A S) : number (nth [::] (nth [::] gs x) c) u = number (nth [::] (columns (decisions S) (nth [::] gs x)) u) c /\
    In (nth zero (nth [::] (columns (decisions S) (nth [::] gs x)) u) c) (nth [::] (columns (decisions S) (nth [::] gs x)) u).
  have [||s e] := cE c u; rewrite ?sa // /PolicyMeaning.number e; split=> //.
  by rewrite -e; apply: in_nth; rewrite s sa.
have [-> in_a] := at_c a; have [-> in_a'] := at_c a'.
by apply: ler_sub; [apply: greatest_of_ge | apply: least_of_le].
Qed.

Lemma freeP : a_free S -> Definitions.a_free g.
Proof.
move=> /Z.eqb_eq L0 u x a a'; have zero_L : ratio (L_used S) = 0 :> R by rewrite /ratio L0 embed0 mul0r.
have le c c' : g u x c <= g u x c' by rewrite -[leRHS]addr0 -zero_L spread_within.
by apply: le_anti; rewrite !le.
Qed.

Lemma L_ge0 : 0 <= ratio (L_used S) :> R.
Proof.
have x := Ordinal (some_context ok); have a : A S := Ordinal (ltnW (two_groups ok)).
by have := spread_within (Ordinal (some_decision ok)) x a a; rewrite ler_addl.
Qed.

Lemma gamma_ge0 : 0 <= ratio (gamma_used S) :> R.
Proof.
have x := Ordinal (some_context ok); have a : A S := Ordinal (ltnW (two_groups ok)).
have /andP[_] := g_within (Ordinal (some_decision ok)) x a.
by apply: le_trans; apply: g_ge0.
Qed.

(* ---- Expectations ---- *)

Lemma expectedP n (p v : seq Q) : size p = n -> size v = n -> ratio (expected p v) = \sum_(i < n) number p i * number v i :> R.
Proof.
move=> <- {n}; elim: p v => [|x p IH] [|y v] //= => [_|[sv]]; first by rewrite big_ord0 /expected /= ratio_zero.
by rewrite big_ord_recl -IH // /expected /= ratio_plus ratio_times.
Qed.

Lemma weights_number (x : X S) (a : A S) (u : U S) : number (law_of (weights_at S x a)) u = induced MX MA (@T0 R S) x a u.
Proof.
rewrite -(induced_weight R ok x a u) /Meaning.weight cell_atP // /Meaning.number Nat2Z.id list_nth.
by [].
Qed.

Lemma numberedE (T : Type) (d : T) (s : seq T) i : (i < size s)%N -> nth (0%N, d) (numbered s) i = (i, nth d s i).
Proof.
move=> h; rewrite /numbered nth_combine -?size_length ?seq_length //; congr (_, _).
by rewrite -list_nth seq_nth //; apply/ssrnat.ltP.
Qed.

Lemma expectationP (x : X S) (a : A S) : ratio (nth zero (nth [::] (expectations S) x) a) = E0 R x a.
Proof.
have size_x : size (induced_weights S) = true_contexts S by rewrite size_map_list size_pieces.
have size_a : size (nth [::] (induced_weights S) x) = true_groups S by rewrite (@nth_map_in _ _ [::]) ?size_pieces.
have sn (T : Type) (s : seq T) : size (numbered s) = size s by rewrite /numbered size_combine -?size_length ?seq_length.
rewrite /expectations (@nth_map_in _ _ (0%N, [::])) ?sn ?size_x // (numberedE [::]) ?size_x //=.
rewrite (@nth_map_in _ _ (0%N, [::])) ?sn ?size_a // (numberedE [::]) ?size_a //=.
rewrite (@expectedP (decisions S)) /E0 ?(proj1 (gains_ok R ok _ _)) //.
  by apply: eq_bigr => u _; rewrite -weights_number.
have := weights_size R ok (ltn_ord x) (ltn_ord a); rewrite /law_of => e.
by case: (fold_right _ _ _) => [|t|t]; rewrite size_map_list.
Qed.

Lemma tau_of_lawP (x : X S) (a : A S) : ratio (tau_of_law S) <= E0 R x a.
Proof.
have sn (T : Type) (s : seq T) : size (numbered s) = size s by rewrite /numbered size_combine -?size_length ?seq_length.
have size_x : size (induced_weights S) = true_contexts S by rewrite size_map_list size_pieces.
have size_a : size (nth [::] (induced_weights S) x) = true_groups S by rewrite (@nth_map_in _ _ [::]) ?size_pieces.
rewrite -expectationP; apply: least_of_le; apply/in_concat; exists (nth [::] (expectations S) x).
split; apply: in_nth; first by rewrite size_map_list sn size_x.
by rewrite (@nth_map_in _ _ (0%N, [::])) ?sn ?size_x // size_map_list sn (numberedE [::]) ?size_x //= size_a.
Qed.
End Behind.
