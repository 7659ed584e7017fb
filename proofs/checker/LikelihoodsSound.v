(* The program of Likelihoods.v is right: sums over outputs of what depends on the two probabilities alone, and is homogeneous in them,
   are sums over its likelihoods.  H_k and S(V) are such sums. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions T13.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound Likelihoods.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Sound.
Variable R : realFieldType.
Implicit Types (s : likelihoods) (ss : seq likelihoods).
Local Notation homogeneous := (@homogeneous R).
Local Notation entry := (@entry R).

Definition sum_of (F : R -> R -> R) s : R := \sum_(t <- s) F (embed t.1) (embed t.2).
Definition nonneg s : Prop := forall t, In t s -> 0 <= embed t.1 :> R /\ 0 <= embed t.2 :> R.

Lemma sum_nil F : sum_of F [::] = 0. Proof. exact: big_nil. Qed.

Lemma sum_cons F t s : sum_of F (t :: s) = F (embed t.1) (embed t.2) + sum_of F s.
Proof. exact: big_cons. Qed.

Lemma sum_cat F s (t : likelihoods) : sum_of F (s ++ t) = sum_of F s + sum_of F t.
Proof. exact: big_cat. Qed.

Lemma nonneg_cons t s : nonneg (t :: s) -> [/\ 0 <= embed t.1 :> R, 0 <= embed t.2 :> R & nonneg s].
Proof. by move=> n; have [] := n t (or_introl erefl); split=> // u us; apply: n; right. Qed.

Lemma nonneg_add t s : 0 <= embed t.1 :> R -> 0 <= embed t.2 :> R -> nonneg s -> nonneg (t :: s).
Proof. by move=> p q n u [<-|us] //; apply: n. Qed.

Lemma nonneg_cat s (t : likelihoods) : nonneg s -> nonneg t -> nonneg (s ++ t).
Proof. by move=> ns nt u us; case: (in_app_or _ _ _ us) => h; [apply: ns | apply: nt]. Qed.

(* Two outputs of equal ratio are as one. *)
Lemma added F (p q p' q' : R) : homogeneous F -> 0 <= p -> 0 <= q -> 0 <= p' -> 0 <= q' -> p * q' = p' * q ->
  F p q + F p' q' = F (p + p') (q + q').
Proof.
move=> hF p0 q0 p0' q0' e; have F0 : F 0 0 = 0 by have := hF 0 0 0 (lexx 0); rewrite !mul0r.
have n0 : 0 <= p + q by rewrite addr_ge0.
have [z|nz] := eqVneq (p + q) 0.
  by move/eqP: z; rewrite paddr_eq0 // => /andP[/eqP-> /eqP->]; rewrite F0 !add0r.
pose c := (p' + q') / (p + q); have c0 : 0 <= c by rewrite divr_ge0 // addr_ge0.
have cp : c * p = p'.
  apply: (mulIf nz); rewrite /c mulrAC divfK // mulrDl mulrDr; rewrite [q' * p]mulrC e [p' * p]mulrC.
  by rewrite [p * p']mulrC.
have cq : c * q = q'.
  apply: (mulIf nz); rewrite /c mulrAC divfK // mulrDl mulrDr -e [q' * p]mulrC.
  by [].
have -> : p + p' = (1 + c) * p by rewrite mulrDl mul1r cp.
have -> : q + q' = (1 + c) * q by rewrite mulrDl mul1r cq.
by rewrite hF ?addr_ge0 ?ler01 // mulrDl mul1r -hF // cp cq.
Qed.

Lemma mergedP F s (t : likelihoods) : homogeneous F -> nonneg s -> nonneg t -> sum_of F (merged s t) = sum_of F s + sum_of F t /\ nonneg (merged s t).
Proof.
move=> hF; elim: s t => [|[p q] s IH] t; first by case: t => [|u t] _ nt; rewrite /= ?sum_nil ?add0r.
elim: t => [|[p' q'] t IHt] ns nt; first by rewrite /= sum_nil addr0.
have [/= p0 q0 ns'] := nonneg_cons ns; have [/= p0' q0' nt'] := nonneg_cons nt.
case e: (Z.compare _ _).
- have [e' n] := IH t ns' nt'; rewrite !sum_cons e' /= !embedD; split; last by apply: nonneg_add; rewrite //= embedD addr_ge0.
  rewrite -(added hF) //; first by rewrite addrACA.
  by rewrite -!embedM; move/Z.compare_eq: e => ->.
- have [e' n] := IH _ ns' nt; rewrite sum_cons e' !sum_cons /= addrA; split=> //; exact: nonneg_add.
- change (sum_of F ((p', q') :: merged ((p, q) :: s) t) = sum_of F ((p, q) :: s) + sum_of F ((p', q') :: t) /\
    nonneg ((p', q') :: merged ((p, q) :: s) t)).
  have [e' n] := IHt ns nt'; rewrite sum_cons e' !sum_cons /= [in LHS]addrCA; split=> //; exact: nonneg_add.
Qed.

Definition sums F ss : R := \sum_(s <- ss) sum_of F s.
Definition all_nonneg ss : Prop := forall s, In s ss -> nonneg s.

Lemma pairs_mergedP F n ss : homogeneous F -> (size ss <= n)%N -> all_nonneg ss ->
  sums F (merged_in_pairs ss) = sums F ss /\ all_nonneg (merged_in_pairs ss).
Proof.
move=> hF; elim: n ss => [|n IH] [|s [|t ss]] //= h ns.
have ns' : all_nonneg ss by move=> u us; apply: ns; right; right.
have [e n'] := IH ss (ltnW h) ns'.
have [e' n2] := mergedP hF (ns s (or_introl erefl)) (ns t (or_intror (or_introl erefl))).
rewrite /sums big_cons -/(sums _ _) e e' /sums !big_cons addrA; split=> // u [<-|us] //; exact: n'.
Qed.

Lemma all_mergedP F n ss : homogeneous F -> all_nonneg ss -> sum_of F (all_merged n ss) = sums F ss /\ nonneg (all_merged n ss).
Proof.
move=> hF; have whole us : all_nonneg us -> sum_of F (concat us) = sums F us /\ nonneg (concat us).
  elim: us => [|u us IH] ns; first by rewrite /sum_of /sums !big_nil.
  have ns' : all_nonneg us by move=> v vs; apply: ns; right.
  have [e n'] := IH ns'.
  by rewrite /= sum_cat e /sums big_cons; split=> //; apply: nonneg_cat => //; apply: ns; left.
elim: n ss => [|n IH] [|s [|t ss]] ns //=; try by rewrite /sums /sum_of !big_nil.
- by rewrite /sums big_seq1; split=> //; apply: ns; left.
- exact: (whole [:: s, t & ss]).
- by rewrite /sums big_seq1; split=> //; apply: ns; left.
have [e n'] := pairs_mergedP (n := size [:: s, t & ss]) hF (leqnn _) ns.
by have [] := IH (merged_in_pairs [:: s, t & ss]) n'; rewrite e.
Qed.

Lemma by_ratioP F s : homogeneous F -> nonneg s -> sum_of F (by_ratio s) = sum_of F s /\ nonneg (by_ratio s).
Proof.
move=> hF ns; have F0 : F 0 0 = 0 by have := hF 0 0 0 (lexx 0); rewrite !mul0r.
rewrite /by_ratio; set kept := List.map _ _; have nk : all_nonneg kept.
  by move=> u /in_map_iff[v [<- /filter_In[vs _]]] w [<-|//]; apply: ns.
have [e n] := all_mergedP 64 hF nk; rewrite e; split=> //.
rewrite /sums /kept; elim: s {ns kept nk e n} => [|[p q] s IH]; first by rewrite /sum_of !big_nil.
rewrite sum_cons -IH /=; case: andP => [[/Z.eqb_eq -> /Z.eqb_eq ->]|_] /=; first by rewrite F0 add0r.
by rewrite big_cons {1}/sum_of big_seq1.
Qed.

(* ---- Likelihoods stand for two rows P and Q, times a unit ---- *)

Definition stands (U : R) s (I : finType) (P Q : I -> R) : Prop :=
  nonneg s /\ forall F, homogeneous F -> sum_of F s = U * \sum_i F (P i) (Q i).

Lemma sum_products F s (t : likelihoods) : homogeneous F -> nonneg s -> nonneg t ->
  sum_of F (joint s t) = \sum_(a <- s) \sum_(b <- t) F (embed a.1 * embed b.1) (embed a.2 * embed b.2) /\ nonneg (joint s t).
Proof.
move=> hF ns nt; rewrite /joint; set all := flat_map _ _.
have n : nonneg all.
  move=> u /in_flat_map[a [as_ /in_map_iff[b [<- bt]]]] /=; rewrite !embedM.
  by have [a1 a2] := ns a as_; have [b1 b2] := nt b bt; rewrite !mulr_ge0.
have [-> n'] := by_ratioP hF n; split=> //; rewrite /all; elim: s {ns all n n'} => [|a s IH]; first by rewrite /sum_of !big_nil.
rewrite /= sum_cat IH big_cons; congr (_ + _).
rewrite /sum_of; elim: t {nt IH} => [|b t IHt]; first by rewrite !big_nil.
by rewrite /= !big_cons IHt /= !embedM.
Qed.

Lemma homogeneous_scaled F x y : homogeneous F -> homogeneous (fun p q => F (x * p) (y * q)).
Proof. by move=> hF c p q c0; rewrite -hF // !(mulrCA c). Qed.

Lemma homogeneous_sum F (I : finType) (P Q : I -> R) : homogeneous F -> homogeneous (fun p q => \sum_i F (p * P i) (q * Q i)).
Proof. by move=> hF c p q c0; rewrite mulr_sumr; apply: eq_bigr => i _; rewrite -hF // !mulrA. Qed.

Lemma joint_stands U U' s (t : likelihoods) (I J : finType) (P Q : I -> R) (P' Q' : J -> R) : stands U s P Q -> stands U' t P' Q' ->
  nonneg (joint s t) /\ forall F, homogeneous F -> sum_of F (joint s t) = U * U' * \sum_i \sum_j F (P i * P' j) (Q i * Q' j).
Proof.
move=> [ns sP] [nt tP]; split=> [|F hF]; first by have [] := sum_products (homogeneous_hockey_stick 0) ns nt.
have [-> _] := sum_products hF ns nt.
transitivity (\sum_(a <- s) U' * \sum_j F (embed a.1 * P' j) (embed a.2 * Q' j)).
  by apply: eq_bigr => a _; rewrite -(tP _ (homogeneous_scaled _ _ hF)).
by rewrite -mulr_sumr -/(sum_of (fun p q => \sum_j F (p * P' j) (q * Q' j)) s) sP ?mulrA 1?[U' * U]mulrC //; apply: homogeneous_sum.
Qed.

Lemma of_rowsP (p q : seq Z) (u : R) n (P Q : nat -> R) : size p = n -> size q = n -> 0 <= u ->
  (forall j, (j < n)%N -> integer R p j = u * P j /\ integer R q j = u * Q j) -> (forall j, (j < n)%N -> 0 <= P j /\ 0 <= Q j) ->
  stands u (of_rows p q) (fun j : 'I_n => P j) (fun j => Q j).
Proof.
move=> sp sq u0 e pos; have n0 : nonneg (combine p q).
  move=> t; move: e; rewrite -sp in sq pos *; elim: p q P Q sq pos {sp} => [|x p IH] [|y q] P Q //= [sq] pos e.
  case=> [<-|]; last by apply: (IH q (P \o succn) (Q \o succn)) => // j; [apply: (pos j.+1) | apply: (e j.+1)].
  by have [ex ey] := e 0%N isT; have [P0 Q0] := pos 0%N isT; rewrite /= -[embed x]/(integer R (x :: p) 0) ex -[embed y]/(integer R (y :: q) 0) ey !mulr_ge0.
split=> [|F hF]; first by have [] := by_ratioP (homogeneous_hockey_stick 0) n0.
have [-> _] := by_ratioP hF n0; rewrite mulr_sumr.
transitivity (\sum_(j < n) F (integer R p j) (integer R q j)); last first.
  by apply: eq_bigr => j _; have [-> ->] := e j (ltn_ord j); rewrite hF.
rewrite -sp in sq *; rewrite /sum_of; elim: p q sq {sp e pos n0} => [|x p IH] [|y q] //= sq; first by rewrite big_nil big_ord0.
by case: sq => sq; rewrite big_cons IH // big_ord_recl.
Qed.

(* ---- Kinds of pairs ---- *)

Lemma same_likelihoodsP s (t : likelihoods) : same_likelihoods s t -> s = t.
Proof.
elim: s t => [|[p q] s IH] [|[p' q'] t] //=; case: ifP => // /andP[/Z.eqb_eq -> /Z.eqb_eq ->] /IH ->.
by [].
Qed.

Lemma in_distinct s found ss : In s found \/ In s ss -> In s (distinct found ss).
Proof.
elim: ss found => [|t ss IH] found /=; first by case.
case=> [inF|[->|inS]]; apply: IH; [left | left | by right].
  by case: ifP => _ //; right.
case: ifP => [/existsb_exists[u [uF /same_likelihoodsP ->]]|_] //.
by left.
Qed.

Lemma in_ordered (T : Type) (d : T) (before xs : seq T) i y : (i < size xs)%N ->
  In y before \/ (exists j, [/\ (j < size xs)%N, j != i & y = nth d xs j]) -> In (nth d xs i, y) (ordered before xs).
Proof.
elim: xs before i => // x xs IH before [|i] /= h others; apply/in_or_app.
  left; apply/in_map_iff; exists y; split=> //; apply/in_or_app.
  by case: others => [yb|[[|j] [//= jx _ ->]]]; [left | right; apply: in_nth].
right; apply: IH => //; case: others => [yb|[[|j] [/= jx ji ->]]]; first by left; right.
  by left; left.
by right; exists j.
Qed.

Lemma in_factor_kinds F i i' : (i < size F)%N -> (i' < size F)%N -> i' != i ->
  In (of_rows (nth [::] (integers F) i) (nth [::] (integers F) i')) (factor_kinds F).
Proof.
move=> hi hi' ne; apply: in_distinct; right; apply/in_map_iff.
exists (nth [::] (integers F) i, nth [::] (integers F) i'); split=> //.
have sF : size (integers F) = size F by rewrite size_map_list.
by apply: in_ordered; rewrite sF //; right; exists i'.
Qed.

Lemma factor_stands F i i' : lawful_matrix R F -> (i < size F)%N -> (i' < size F)%N ->
  stands (embed (unit_of F)) (of_rows (nth [::] (integers F) i) (nth [::] (integers F) i'))
    (fun j : 'I_(width F) => entry F i j) (fun j => entry F i' j).
Proof.
move=> lF hi hi'; have [si pi _] := lF i hi; have [si' pi' _] := lF i' hi'.
apply: of_rowsP => //.
- by rewrite (@nth_map_in _ _ [::]) // size_map_list.
- by rewrite (@nth_map_in _ _ [::]) // size_map_list.
- by apply/ltW/embed_gt0/Z.ltb_lt/common_gt0.
- by move=> j _; rewrite !integersE.
by move=> j _; split; [exact: pi | exact: pi'].
Qed.

Lemma stands_same U s (I : finType) (P Q P' Q' : I -> R) : stands U s P Q -> P =1 P' -> Q =1 Q' -> stands U s P' Q'.
Proof. by move=> [n e] eP eQ; split=> // F hF; rewrite e //; congr (_ * _); apply: eq_bigr => i _; rewrite eP eQ. Qed.

(* A law with itself *)
Lemma agree_stands U n (P : 'I_n -> R) : 0 <= embed U :> R -> law P -> stands (embed U) [:: (U, U)] P P.
Proof.
move=> U0 [P0 P1]; split=> [t [<-|//]|F hF] //; rewrite /sum_of big_seq1 /=.
under eq_bigr => i _ do rewrite -[P i]mulr1 hF //.
by rewrite -mulr_suml P1 mul1r -hF // mulr1.
Qed.

(* Of a product: what stands for the rows of the first factor and for those of the others *)
Lemma product_stands F fs s (t : likelihoods) i i' k k' : lawful_filter R (F :: fs) -> (i < size F)%N -> (i' < size F)%N ->
  (k < inputs_of fs)%N -> (k' < inputs_of fs)%N ->
  stands (embed (unit_of F)) s (fun j : 'I_(width F) => entry F i j) (fun j => entry F i' j) ->
  stands (embed (units fs)) t (fun j : 'I_(outputs_of fs) => entry (multiplied_out fs) k j) (fun j => entry (multiplied_out fs) k' j) ->
  stands (embed (units (F :: fs))) (joint s t)
    (fun j : 'I_(outputs_of (F :: fs)) => entry (multiplied_out (F :: fs)) (i * inputs_of fs + k) j)
    (fun j => entry (multiplied_out (F :: fs)) (i' * inputs_of fs + k') j).
Proof.
move=> lFfs hi hi' hk hk' sS tS; have [n e] := joint_stands sS tS; split=> // G hG; rewrite e //.
rewrite [units (F :: fs)]/(Z.mul (unit_of F) (units fs)) embedM; congr (_ * _).
rewrite (sum_product _ _ (fun b => G (entry (multiplied_out (F :: fs)) (i * inputs_of fs + k) b)
  (entry (multiplied_out (F :: fs)) (i' * inputs_of fs + k') b))).
by apply: eq_bigr => j _; apply: eq_bigr => j' _; rewrite !product_entry.
Qed.

Lemma law_of_row fs a : lawful_filter R fs -> (a < inputs_of fs)%N -> law (fun b : 'I_(outputs_of fs) => entry (multiplied_out fs) a b).
Proof. by move=> lfs ha; have [_ p0 p1] := lawful_product lfs ha; split=> [b|]; [exact: p0 | exact: p1]. Qed.

Lemma units_ge0 fs : 0 <= embed (units fs) :> R. Proof. exact/ltW/units_gt0. Qed.

Lemma unit_of_ge0 F : 0 <= embed (unit_of F) :> R. Proof. by apply/ltW/embed_gt0/Z.ltb_lt/common_gt0. Qed.

(* Some kind stands for any two different inputs. *)
Theorem kindsP fs a a' : lawful_filter R fs -> (a < inputs_of fs)%N -> (a' < inputs_of fs)%N -> a != a' ->
  exists2 s, In s (kinds fs) & stands (embed (units fs)) s
    (fun b : 'I_(outputs_of fs) => entry (multiplied_out fs) a b) (fun b => entry (multiplied_out fs) a' b).
Proof.
elim: fs a a' => [|F fs IH] a a'; first by case: a a' => [|a] [|a'].
move=> lFfs; have [lF lfs] := lFfs; rewrite inputs_cons => /divmod[hi hk ea] /divmod[hi' hk' ea'].
have lawF j : (j < size F)%N -> law (fun b : 'I_(width F) => entry F j b).
  by move=> hj; have [_ p0 p1] := lF j hj; split=> [b|]; [exact: p0 | exact: p1].
rewrite ea ea' {ea ea'}; move: (a %/ _)%N (a %% _)%N (a' %/ _)%N (a' %% _)%N hi hk hi' hk' => i k i' k' hi hk hi' hk' ne.
have [ii|ii] := eqVneq i' i.
  rewrite ii in hi' ne *; have kk : k != k' by apply: contraNneq ne => ->.
  have [t tin tS] := IH k k' lfs hk hk' kk; exists (joint [:: (unit_of F, unit_of F)] t).
    by apply: in_distinct; right; apply/in_or_app; right; apply/in_map_iff; exists t.
  by apply: product_stands => //; apply: agree_stands; [apply: unit_of_ge0 | apply: lawF].
have own := in_factor_kinds hi hi' ii; have sS := factor_stands lF hi hi'.
have [kk|kk] := eqVneq k k'.
  exists (joint (of_rows (nth [::] (integers F) i) (nth [::] (integers F) i')) [:: (units fs, units fs)]).
    apply: in_distinct; right; apply/in_or_app; left; apply/in_flat_map; eexists; split; first exact: own.
    by apply/in_map_iff; exists [:: (units fs, units fs)]; split=> //; left.
  by apply: product_stands => //; rewrite -kk; apply: agree_stands; [apply: units_ge0 | apply: law_of_row].
have [t tin tS] := IH k k' lfs hk hk' kk; exists (joint (of_rows (nth [::] (integers F) i) (nth [::] (integers F) i')) t).
  apply: in_distinct; right; apply/in_or_app; left; apply/in_flat_map; eexists; split; first exact: own.
  by apply/in_map_iff; exists t; split=> //; right.
exact: product_stands.
Qed.

(* ---- H_k ---- *)

Lemma exceedingP k s : embed (exceeding k s) = sum_of (fun p q => Num.max 0 (p * embed (Zpos (Qden k)) - q * embed (Qnum k))) s :> R.
Proof.
have maxE x y : embed (Z.max x y) = Num.max (embed x) (embed y) :> R.
  case: (Z.max_spec x y) => -[h ->].
    by apply/esym/max_idPr/embed_le/Z.leb_le/Z.lt_le_incl.
  by apply/esym/max_idPl/embed_le/Z.leb_le.
elim: s => [|t s IH]; first by rewrite sum_nil embed0.
by rewrite sum_cons -IH [exceeding _ _]/(Z.add _ (exceeding k s)) embedD maxE embed0 -Z.add_opp_r embedD embedN !embedM.
Qed.

Theorem hockeyP U k s (I : finType) (P Q : I -> R) : Z.lt Z0 U -> stands (embed U) s P Q -> ratio (hockey U k s) = hockey_stick (ratio k) P Q.
Proof.
case: U => [|U|U] // _ [_ e]; rewrite /hockey ratio_reduced /ratio /= exceedingP e; last first.
  by move=> c p q c0; rewrite -!mulrA -mulrBr maxr_pmulr // mulr0.
rewrite -[Zpos (U * Qden k)]/(Z.mul (Zpos U) (Zpos (Qden k))) embedM /hockey_stick.
have U0 : embed (Zpos U) != 0 :> R by rewrite embed_neq0.
have K0 : 0 < embed (Zpos (Qden k)) :> R by rewrite embed_pos.
rewrite invfM mulrACA divff // mul1r mulr_suml; apply: eq_bigr => i _.
rewrite mulrC maxr_pmulr ?invr_ge0 ?(ltW K0) // mulr0; congr (Num.max 0 _).
by rewrite mulrBr [_ * (P i * _)]mulrC mulfK ?gt_eqF // mulrCA mulrC [_^-1 * _]mulrC.
Qed.
End Sound.
