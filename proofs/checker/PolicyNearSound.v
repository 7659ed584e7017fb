(* What PolicyNear.v accepts is the greatest ratio over the policies near the one of the certificate. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions T13 T13_near.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound PolicyLaw Likelihoods LikelihoodsSound PolicyClaims PolicyFacts PolicyBounds PolicyMeans.
From FairauditChecker Require Import PolicySites PolicySitesSound PolicyWorthSound PolicySupremaSound PolicyShown PolicyShownSound PolicyFloors PolicyFloorsSound PolicyNear.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- One law ---- *)

Section OneLaw.
Variable R : realFieldType.

Lemma sum_zP (T : Type) (d : T) (s : seq T) f : embed (sum_z (List.map f s)) = \sum_(i < size s) embed (f (nth d s i)) :> R.
Proof. by elim: s => [|x s IH]; rewrite ?big_ord0 ?embed0 // big_ord_recl -IH -embedD. Qed.

Lemma least_z_in xs : xs <> [::] -> In (least_z xs) xs.
Proof.
case: xs => // y xs _ /=; elim: xs y => [|z xs IH] y /=; first by left.
rewrite [lesser_z z _]/lesser_z; case: ifP => _; first by right; left.
by case: (IH y) => h; [left | right; right].
Qed.

Variables (n : nat) (u0 : 'I_n) (cs ts : seq Z) (moved den unit : Z) (s : R) (c T : 'I_n -> R).
Hypotheses (sc : size cs = n) (st : size ts = n) (s0 : 0 < s) (den0 : Z.lt Z0 den) (unit0 : Z.lt Z0 unit).
Hypotheses (cE : forall u : 'I_n, embed (nth Z0 cs u) = s * c u) (tE : forall u : 'I_n, embed (nth Z0 ts u) = embed unit * T u).
Hypothesis lT : law T.
Local Notation eta := (embed moved / embed den : R).

Lemma greatest_nearP (D : 'I_n -> R) : law D -> tv D T <= eta ->
  s * (embed unit * embed den) * (\sum_u D u * c u) <= embed (greatest_near (Z.mul moved unit) den (combine cs ts)).
Proof.
move=> lD near; have n0 : (0 < n)%N by apply: leq_ltn_trans (ltn_ord u0).
have e0 : 0 < embed den :> R by apply/embed_gt0/Z.ltb_lt.
have w0 : 0 < embed unit :> R by apply/embed_gt0/Z.ltb_lt.
have sct : size (combine cs ts) = n by rewrite size_combine ?sc ?st.
have firsts : List.map fst (combine cs ts) = cs.
  have same : size cs = size ts by rewrite sc st.
  by move: same; elim: (cs) (ts) => [|x xs IH] [|y ys] //= [/IH->].
rewrite /greatest_near firsts; set highest := greatest_z cs.
have [v ->] : exists v : 'I_n, least_z (List.map (bound_by (Z.mul moved unit) den (combine cs ts) highest) cs) =
    bound_by (Z.mul moved unit) den (combine cs ts) highest (nth Z0 cs v).
  have /least_z_in/in_map_iff[z [<- /(In_nth _ _ Z0)[i [/ssrnat.ltP hi <-]]]] :
      List.map (bound_by (Z.mul moved unit) den (combine cs ts) highest) cs <> [::].
    by move=> z; move: n0; rewrite -sc -(size_map_list (bound_by (Z.mul moved unit) den (combine cs ts) highest)) z.
  by rewrite size_length sc in hi; exists (Ordinal hi); rewrite list_nth.
have top_ge (u : 'I_n) : c u <= embed highest / s.
  by rewrite ler_pdivl_mulr // mulrC -cE; apply/greatest_z_ge/in_nth; rewrite sc.
have := near_bound lT lD near top_ge (top_ge v).
rewrite -(ler_pmul2l (mulr_gt0 s0 (mulr_gt0 w0 e0))) => /le_trans; apply.
rewrite le_eqVlt; apply/orP; left; apply/eqP.
rewrite /bound_by embedD !embedM -Z.add_opp_r embedD embedN cE (sum_zP (Z0, Z0)) sct.
have -> : \sum_(i < n) embed (Z.mul (nth (Z0, Z0) (combine cs ts) i).2 (Z.max (nth (Z0, Z0) (combine cs ts) i).1 (nth Z0 cs v)))
    = s * embed unit * \sum_u (T u * c u + T u * Num.max 0 (c v - c u)) :> R.
  rewrite mulr_sumr; apply: eq_bigr => i _; rewrite nth_combine ?sc ?st //= embedM embed_max !cE tE -maxr_pmulr ?ltW //.
  have -> : Num.max (c i) (c v) = c i + Num.max 0 (c v - c i) by rewrite addr_maxr addr0 addrC subrK.
  by move: (Num.max _ _) => m; ring.
rewrite big_split /=; move: (\sum_u _) (\sum_u _) => x y; field.
by rewrite !gt_eqF.
Qed.
End OneLaw.

Section Behind.
Variables (R : realFieldType) (S : behind).
Hypotheses (ok : valid S).
Local Notation number := (@number R).
Local Notation MX := (@MX R S).
Local Notation MA := (@MA R S).
Local Notation T0 := (@T0 R S).
Local Notation g := (@g R S).
Local Notation share := (@share R S).
Local Notation A := (A S).
Local Notation X := (X S).
Local Notation Xt := (Xt S).
Local Notation At := (At S).
Local Notation U := (U S).
Local Notation quantity := (@quantity R S).
Local Notation compared := (@compared R S).
Local Notation shown := (@shown R S).
Local Notation w0 := (u0 ok).
Local Notation E_of T := (Definitions.utility (induced MX MA T) g).
Implicit Types (c : option X) (a : A) (T : Xt -> At -> U -> R).

Lemma quantity_seen c T a :
  quantity c (Definitions.utility (induced MX MA T) g) a = \sum_(y : Xt) \sum_(b : At) \sum_u T y b u * (MA a b * shown c a y u).
Proof.
rewrite pair_bigA; case: c => [x|] /=.
  rewrite cell_value; apply: eq_bigr => -[y b] _; apply: eq_bigr => u _.
  by rewrite /cell_part /= [MX x y * _]mulrC -mulrA.
by rewrite /mean mean_value; apply: eq_bigr => -[y b] _.
Qed.

(* ---- The numbers of the program ---- *)

Variable eta : Q.
Local Notation means_of c := (if isSome c then [::] else mean_worths S).
Definition near_unit c : R := embed (unit_of (shown_worths S (means_of c) (place_of c))).
Definition near_sites c (a : nat) : seq (seq Z) := nth [::] (shown_sites S (shown_worths S (means_of c) (place_of c))) a.

Lemma near_unit_gt0 c : 0 < near_unit c. Proof. by apply/embed_gt0/Z.ltb_lt/common_gt0. Qed.

Lemma shown_worth_alone c (a : nat) : shown_worth S (means_of c) (place_of c) a = shown_worth S (mean_worths S) (place_of c) a.
Proof. by case: c. Qed.

Lemma near_sitesP c (a : A) : compared c a -> size (near_sites c a) = released_contexts S /\ forall y : Xt,
  size (nth [::] (near_sites c a) y) = decisions S /\ forall u : U, embed (nth Z0 (nth [::] (near_sites c a) y) u) = near_unit c * shown c a y u.
Proof.
move=> com; have [s e] := shown_worthP ok com; rewrite -shown_worth_alone in s e.
have sw : size (shown_worths S (means_of c) (place_of c)) = true_groups S by rewrite size_map_list size_seq_list.
have at_a : nth [::] (shown_worths S (means_of c) (place_of c)) a = shown_worth S (means_of c) (place_of c) a.
  by rewrite /shown_worths (@nth_map_in _ _ 0%N) ?size_seq_list // seq_nth_list.
have si : size (nth [::] (integers (shown_worths S (means_of c) (place_of c))) a) = (released_contexts S * decisions S)%N.
  by rewrite /integers (@nth_map_in _ _ [::]) ?sw // size_map_list at_a s.
have -> : near_sites c a = pieces (released_contexts S) (decisions S) (nth [::] (integers (shown_worths S (means_of c) (place_of c))) a).
  by rewrite /near_sites /shown_sites (@nth_map_in _ _ [::]) // size_map_list sw ltn_ord.
rewrite size_pieces; split=> // y; split=> [|u]; first by rewrite size_piece ?ltn_ord.
rewrite (@nth_pieces _ Z0) ?ltn_ord // -[embed _]/(integer R _ _) integersE ?sw //.
by rewrite /entry /PolicyMeaning.entry at_a e.
Qed.

Definition row_unit : R := embed (unit_of (group_matrix S)).
Lemma row_unit_gt0 : 0 < row_unit. Proof. by apply/embed_gt0/Z.ltb_lt/common_gt0. Qed.

Lemma rows_ofP (a : A) : size (nth [::] (rows_of S) a) = released_groups S /\
  forall b : At, embed (nth Z0 (nth [::] (rows_of S) a) b) = row_unit * MA a b.
Proof.
have size_M : size (group_matrix S) = true_groups S by rewrite multiplied_out_size.
have [s _ _] := lawful_product (group_filter_ok R ok) (ltn_ord a).
split=> [|b]; first by rewrite (@nth_map_in _ _ [::]) ?size_M // size_map_list.
by rewrite -[LHS]/(integer R _ _) integersE ?size_M.
Qed.

Lemma law_weightsP : size (law_weights S) = released_contexts S /\ forall y : Xt, size (nth [::] (law_weights S) y) = released_groups S /\
  forall b : At, size (nth [::] (nth [::] (law_weights S) y) b) = decisions S /\
    forall u : U, embed (nth Z0 (nth [::] (nth [::] (law_weights S) y) b) u) = embed (law_unit S) * T0 y b u.
Proof.
have [sy sb] := laws_shaped ok; split=> [|y]; first by rewrite size_map_list sy.
rewrite /law_weights (@nth_map_in _ _ [::]) ?sy //; split=> [|b]; first by rewrite size_map_list sb.
have [su _ _] := laws_lawful R ok (ltn_ord y) (ltn_ord b).
rewrite (@nth_map_in _ _ [::]) ?sb //; split=> [|u]; first by rewrite size_map_list su.
rewrite -[LHS]/(integer R _ _) over_numbers // => q qin; apply: common_divide; apply/in_concat.
exists (nth [::] (nth [::] (policy_laws S) y) b); split=> //; apply/in_concat; exists (nth [::] (policy_laws S) y).
by split; apply: in_nth; rewrite ?sb ?sy.
Qed.

Lemma all_zeroP (v : seq Z) i : all_zero v -> nth Z0 v i = Z0.
Proof.
move=> zeros; case: (ltnP i (size v)) => h; last by rewrite nth_default.
by apply/esym/Z.eqb_eq; apply: (@forallb_nth _ Z0 _ _ _ zeros).
Qed.

Lemma nth_combine3 (T1 T2 T3 : Type) (d1 : T1) (d2 : T2) (d3 : T3) s1 s2 s3 i : size s1 = size s2 -> size s2 = size s3 -> (i < size s1)%N ->
  nth ((d1, d2), d3) (combine (combine s1 s2) s3) i = ((nth d1 s1 i, nth d2 s2 i), nth d3 s3 i).
Proof. by move=> e1 e2 hi; rewrite !nth_combine ?size_combine ?e1 // -e1. Qed.

Lemma size_combine3 (T1 T2 T3 : Type) (s1 : seq T1) (s2 : seq T2) (s3 : seq T3) : size s1 = size s2 -> size s2 = size s3 ->
  size (combine (combine s1 s2) s3) = size s1.
Proof. by move=> e1 e2; rewrite size_combine ?size_combine ?e1. Qed.

(* How much p - V q any policy nearby has *)
Lemma sum_nearP (V : Q) c a a' T : compared c a -> compared c a' -> policy T -> (forall y b, tv (T y b) (T0 y b) <= ratio eta) ->
  row_unit * near_unit c * embed (Zpos (Qden V)) * (embed (law_unit S) * embed (Zpos (Qden eta))) * (quantity c (E_of T) a - ratio V * quantity c (E_of T) a')
    <= embed (sum_near (law_unit S) (law_weights S) (Qnum V) (Zpos (Qden V)) (Qnum eta) (Zpos (Qden eta)) (nth [::] (rows_of S) a) (nth [::] (rows_of S) a')
                (near_sites c a) (near_sites c a')).
Proof.
move=> com com' kT near; have [sa at_a] := near_sitesP com; have [sa' at_a'] := near_sitesP com'.
have [sr r] := rows_ofP a; have [sr' r'] := rows_ofP a'; have [sl lw] := law_weightsP.
have d0 := embed_pos R (Qden V).
rewrite /sum_near (sum_zP R (([::], [::]), [::])) size_combine3 ?sa ?sa' ?sl //.
rewrite !quantity_seen mulr_sumr -sumrB mulr_sumr; apply: ler_sum => y _.
rewrite nth_combine3 ?sa ?sa' ?sl //.
have [sy ay] := at_a y; have [sy' ay'] := at_a' y; have [slb ly] := lw y.
set alpha := nth [::] (near_sites c a) y in sy ay *; set beta := nth [::] (near_sites c a') y in sy' ay' *.
have zero_worth v d (x : R) : all_zero v -> 0 < x -> (forall u : U, embed (nth Z0 v u) = x * d u) -> forall u, d u = 0.
  by move=> zeros x0 e u; have /eqP := e u; rewrite (all_zeroP u zeros) embed0 eq_sym mulf_eq0 (gt_eqF x0) => /eqP.
case: ifP => [/andP[za zb]|_].
  rewrite embed0 big1 => [|b _]; last by apply: big1 => u _; rewrite (zero_worth _ _ _ za (near_unit_gt0 c) ay) !mulr0.
  rewrite big1 => [|b _]; last by apply: big1 => u _; rewrite (zero_worth _ _ _ zb (near_unit_gt0 c) ay') !mulr0.
  by rewrite mulr0 subr0 mulr0.
rewrite (sum_zP R ((Z0, Z0), [::])) size_combine3 ?sr ?sr' ?slb // mulr_sumr -sumrB mulr_sumr; apply: ler_sum => b _.
rewrite nth_combine3 ?sr ?sr' ?slb //=; have [sw ew] := ly b.
pose cu (u : U) : R := MA a b * shown c a y u - ratio V * (MA a' b * shown c a' y u).
have -> : \sum_u T y b u * (MA a b * shown c a y u) - ratio V * (\sum_u T y b u * (MA a' b * shown c a' y u)) = \sum_u T y b u * cu u.
  by rewrite mulr_sumr -sumrB; apply: eq_bigr => u _; rewrite /cu mulrBr [ratio V * (T y b u * _)]mulrCA.
have unit0 : Z.lt Z0 (law_unit S) by apply: common_gt0.
apply: (@greatest_nearP R (decisions S) w0 _ _ (Qnum eta) (Zpos (Qden eta)) (law_unit S) _ cu (T0 y b)) => //.
- by rewrite size_map_list size_combine ?sy ?sy'.
- by rewrite !mulr_gt0 ?row_unit_gt0 ?near_unit_gt0.
- move=> u; rewrite (@nth_map_in _ _ (Z0, Z0)) ?size_combine ?sy ?sy' // nth_combine ?sy ?sy' //=.
  rewrite -Z.add_opp_r embedD embedN !embedM r r' ay ay' /cu /ratio.
  by move: (embed_neq0 R (Qden V)) (MA a b) (MA a' b) (shown c a y u) (shown c a' y u) (row_unit) (near_unit c) => dn x1 x2 x3 x4 x5 x6; field.
- exact: (policy_T0 R ok).
exact: kT.
Qed.

Theorem never_nearP V means : max_drift (stated S) = Some eta -> forallb (never_near S (law_unit S) (law_weights S) eta V (rows_of S) (if means then mean_worths S else [::])) (places S means) ->
  bounded means (@of_policy_near R S) (ratio V).
Proof.
move=> declared /forallb_forall proofs E [T [kT near eE]]; rewrite declared /= in near; apply/withinP => c em a a' com com' aa.
rewrite !(eq_quantity c _ eE); have := proofs (place_of c); rewrite em => /(_ (in_places c)).
have -> : (if ~~ isSome c then mean_worths S else [::]) = means_of c by case: (c).
rewrite /never_near => /forallb_forall pairs.
have [i hi ei] := group_at com; have [i' hi' ei'] := group_at com'.
set sides := List.map _ _ in pairs; have ss : size sides = size (groups_in S (place_of c)) by rewrite size_map_list.
have side_ j (b : A) : (j < size sides)%N -> nth 0%N (groups_in S (place_of c)) j = b ->
    nth ([::], [::]) sides j = (nth [::] (rows_of S) b, near_sites c b).
  by rewrite ss => hj ej; rewrite /sides (@nth_map_in _ _ 0%N) // ej !list_nth.
have ne : i' != i by apply: contraNneq aa => ii; rewrite -(val_eqE a a') /= -ei -ei' ii.
have hi_ : (i < size sides)%N by rewrite ss.
have hi_' : (i' < size sides)%N by rewrite ss.
have := pairs (nth ([::], [::]) sides i, nth ([::], [::]) sides i'); rewrite (side_ i a hi_ ei) (side_ i' a' hi_' ei') /= => test_.
have inside : In ((nth [::] (rows_of S) a, near_sites c a), (nth [::] (rows_of S) a', near_sites c a')) (ordered [::] sides).
  by rewrite -(side_ i a hi_ ei) -(side_ i' a' hi_' ei'); apply: in_ordered => //; right; exists i'.
have /(embed_le0 R) le := test_ inside.
have := le_trans (sum_nearP V com com' kT near) le; rewrite pmulr_rle0 ?subr_le0 //.
by rewrite !mulr_gt0 ?row_unit_gt0 ?near_unit_gt0 ?embed_pos //; apply/embed_gt0/Z.ltb_lt/common_gt0.
Qed.

(* ---- A policy that attains it ---- *)

Lemma farP (p q : seq Q) : size p = decisions S -> size q = decisions S ->
  ratio (far p q) = tv (fun u : U => number p u) (fun u => number q u).
Proof.
move=> sp sq; rewrite /far ratio_total big_map (big_nth (zero, zero)) size_combine ?sp ?sq // big_mkord.
apply: eq_bigr => u _; rewrite nth_combine ?sp ?sq //= mul1r -[number p u]/(ratio _) -[number q u]/(ratio _) -ratio_difference.
case e: (nonnegative _); first by rewrite (max_idPr _) // ratio_ge0.
by rewrite ratio_zero (max_idPl _) //; rewrite (nonnegativeE R) in e; move/negbT: e; rewrite -ltNge => /ltW.
Qed.

Lemma attained_nearP means V p : max_drift (stated S) = Some eta -> is_pair S means p -> attained_near S eta V p ->
  exists c E a a', [/\ means = ~~ isSome c, of_policy_near E, compared c a /\ compared c a', a != a' &
    if V is Some v then 0 < quantity c E a' /\ quantity c E a = ratio v * quantity c E a' else quantity c E a' = 0 /\ 0 < quantity c E a].
Proof.
move=> declared pair_; rewrite /attained_near; cbv zeta; set rows := moved_laws _ _ _ _ => /andP[/andP[laws near] ratio_].
have [c [a [a' [em ep [eh el] [com com'] aa]]]] := is_pairP R pair_.
have told := told_of R ok laws; have okw := with_laws_valid ok laws.
exists c, (Definitions.utility (induced MX MA (T_of R rows)) g), a, a'; split=> //; last exact: (has_ratioP told ep eh el com com').
exists (T_of R rows); split=> //; first exact: (policy_of R ok laws).
have [sy sb] := laws_shaped ok; case/andP: laws => /shapedP[sy' sb'] all y b; rewrite declared /=.
have hb : (b < released_groups S)%N := ltn_ord b; have hy : (y < released_contexts S)%N := ltn_ord y.
have := @forallb_nth _ ([::], [::]) _ _ y near; rewrite size_combine sy' ?sy // => /(_ hy).
rewrite nth_combine ?sy' ?sy // => /(@forallb_nth _ ([::], [::]) _ _ b); rewrite /= size_combine sb' ?sb // => /(_ hb).
rewrite nth_combine ?sb' ?sb //= => /(at_mostP R).
have [su _ _] := laws_lawful R ok hy hb.
have [su' _ _] := @laws_lawful R (with_laws S rows) okw y b hy hb.
by rewrite farP.
Qed.

Theorem near_sound means V p : max_drift (stated S) = Some eta -> near_accepted S means V p = Some true ->
  greatest_ratio means (@of_policy_near R S) V.
Proof.
move=> declared; rewrite /near_accepted declared; case: ifP => // _ [] /and3P[_ bound attained].
have class0 (E : X -> A -> R) : of_policy_near E -> forall x a, 0 <= E x a.
  by case=> T [kT _ eE] x a; rewrite eE; exact: (@utility_ge0 R X Xt A At U MX MA g (kernel_MX R ok) (kernel_MA R ok) (@g_ge0 R S ok) T x a kT).
case: V bound attained => [V|]; last by case: p => [p|] // _ /andP[pair_ /(attained_nearP declared pair_)]; apply: greatest_infinite.
case/andP => /(at_mostP R); rewrite ratio_one => V1 /(never_nearP declared) bound.
case: p => [p|]; last first.
  by move=> /(at_mostP R); rewrite ratio_one => V1'; apply: (greatest_finite ok) => //; left; apply: le_anti; rewrite V1 V1'.
case/and3P => _ pair_ /(attained_nearP declared pair_) at_.
by apply: (greatest_finite ok) => //; right.
Qed.
End Behind.
