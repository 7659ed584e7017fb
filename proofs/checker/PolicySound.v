(* The program of Policy.v is right about the filters and the law that they induce. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* ---- Lists, by position ---- *)

Section Lists.
Variables (T T' : Type) (d : T) (d' : T').

Lemma size_length (s : seq T) : length s = size s. Proof. by []. Qed.

Lemma list_nth (s : seq T) n : List.nth n s d = nth d s n.
Proof. by elim: s n => [|x s IH] [|n] //=. Qed.

Lemma longP n (s : seq T) : long n s -> size s = n. Proof. by move/Nat.eqb_eq. Qed.

Lemma forallb_nth (p : T -> bool) s i : forallb p s -> (i < size s)%N -> p (nth d s i).
Proof. by elim: s i => // x s IH [|i] /= /andP[px ps] // is_; apply: IH. Qed.

Lemma nth_map_in (f : T -> T') s i : (i < size s)%N -> nth d' (List.map f s) i = f (nth d s i).
Proof. by elim: s i => // x s IH [|i] //= is_; apply: IH. Qed.

Lemma size_map_list (f : T -> T') s : size (List.map f s) = size s.
Proof. by elim: s => //= x s ->. Qed.

(* A list of lists that all have m entries, one behind the other *)
Lemma size_flat_map (f : T -> seq T') m s : (forall i, (i < size s)%N -> size (f (nth d s i)) = m) ->
  size (flat_map f s) = (size s * m)%N.
Proof.
elim: s => // x s IH e; rewrite [flat_map _ _]/(f x ++ flat_map f s) size_cat IH => [|i is_]; last exact: (e i.+1).
by rewrite mulSn (e 0%N).
Qed.

Lemma nth_flat_map (f : T -> seq T') m s i j : (forall i, (i < size s)%N -> size (f (nth d s i)) = m) ->
  (i < size s)%N -> (j < m)%N -> nth d' (flat_map f s) (i * m + j) = nth d' (f (nth d s i)) j.
Proof.
elim: s i => // x s IH i e is_ jm; rewrite [flat_map _ _]/(f x ++ flat_map f s) nth_cat (e 0%N) //.
case: i is_ => [|i] is_; first by rewrite mul0n add0n jm.
rewrite mulSn -addnA ltnNge leq_addr /= addKn; apply: IH => // k ks; exact: (e k.+1).
Qed.

Lemma size_pieces k m (s : seq T) : size (pieces k m s) = k.
Proof. by elim: k s => //= k IH s; rewrite IH. Qed.

Lemma nth_firstn m (s : seq T) j : (j < m)%N -> nth d (firstn m s) j = nth d s j.
Proof. by elim: m s j => // m IH [|x s] [|j] //= jm; apply: IH. Qed.

Lemma nth_skipn m (s : seq T) j : nth d (skipn m s) j = nth d s (m + j).
Proof. by elim: m s j => // m IH [|x s] j //=; rewrite nth_nil. Qed.

Lemma size_skipn m (s : seq T) : size (skipn m s) = (size s - m)%N.
Proof. by elim: m s => [|m IH] [|x s] //=; rewrite ?subn0 // subSS IH. Qed.

Lemma size_firstn m (s : seq T) : (m <= size s)%N -> size (firstn m s) = m.
Proof. by elim: m s => // m IH [|x s] //= h; rewrite IH. Qed.

Lemma nth_pieces k m (s : seq T) i j : (i < k)%N -> (j < m)%N -> nth d (nth [::] (pieces k m s) i) j = nth d s (i * m + j).
Proof.
elim: k s i => // k IH s [|i] /= ik jm; first by rewrite nth_firstn.
by rewrite IH // nth_skipn mulSn addnA.
Qed.

Lemma size_piece k m (s : seq T) i : size s = (k * m)%N -> (i < k)%N -> size (nth [::] (pieces k m s) i) = m.
Proof.
elim: k s i => // k IH s [|i] /= e ik; first by rewrite size_firstn // e mulSn leq_addr.
by apply: IH => //; rewrite size_skipn e mulSn addKn.
Qed.

End Lists.

Lemma divmod k m n : (k < n * m)%N -> [/\ (k %/ m < n)%N, (k %% m < m)%N & k = (k %/ m * m + k %% m)%N].
Proof.
case: m => [|m] h; first by rewrite muln0 in h.
by split; [rewrite ltn_divLR | rewrite ltn_pmod | rewrite -divn_eq].
Qed.

Lemma ltn_place i j n m : (i < n)%N -> (j < m)%N -> (i * m + j < n * m)%N.
Proof.
move=> ni jm; apply: (@leq_trans (i.+1 * m)); last by rewrite leq_mul2r ni orbT.
by rewrite mulSn addnC ltn_add2r.
Qed.

Section Sound.
Variable R : realFieldType.
Local Notation number := (@number R).
Local Notation entry := (@entry R).

(* A sum over the positions of a product *)
Lemma sum_product n m (f : nat -> R) : \sum_(k < n * m) f k = \sum_(i < n) \sum_(j < m) f (i * m + j)%N.
Proof.
rewrite -[LHS](big_mkord xpredT f) -[RHS](big_mkord xpredT (fun i => \sum_(j < m) f (i * m + j)%N)).
elim: n => [|n IH]; first by rewrite mul0n !big_geq.
rewrite big_nat_recr //= -IH mulSn addnC (@big_cat_nat _ _ _ (n * m)%N) //= ?leq_addr //; congr (_ + _).
rewrite -{1}[(n * m)%N]add0n [in X in \sum_(_ <= i < X) _]addnC big_addn addnK big_mkord.
by apply: eq_bigr => j _; rewrite addnC.
Qed.

Lemma sum_number (v : seq Q) : \sum_(i < size v) number v i = \sum_(q <- v) ratio q :> R.
Proof. by rewrite (big_nth zero) big_mkord. Qed.

Lemma number_ge0 (v : seq Q) i : forallb nonnegative v -> 0 <= number v i.
Proof.
move=> v0; rewrite /number /PolicyMeaning.number; case: (ltnP i (size v)) => h; first exact/ratio_ge0/forallb_nth.
by rewrite nth_default // ratio_zero.
Qed.

(* A row of numbers that is a law *)
Definition lawful (n : nat) (v : seq Q) : Prop := [/\ size v = n, forall i, 0 <= number v i & \sum_(i < n) number v i = 1].

Lemma is_lawP n v : is_law n v -> lawful n v.
Proof.
case/and3P => /longP <- v0 /(@equalP R) t1; split=> // [i|]; first exact: number_ge0.
by rewrite sum_number -ratio_total t1 ratio_one.
Qed.

Lemma outer_size (p q : seq Q) : size (outer p q) = (size p * size q)%N.
Proof. by apply: (@size_flat_map _ _ zero) => i _; rewrite size_map_list. Qed.

Lemma outerP (p q : seq Q) i j : (i < size p)%N -> (j < size q)%N ->
  number (outer p q) (i * size q + j) = number p i * number q j.
Proof.
move=> ip jq; rewrite /number /PolicyMeaning.number (@nth_flat_map _ _ zero zero _ (size q)) // => [|k _]; last by rewrite size_map_list.
by rewrite (nth_map_in zero) // ratio_times.
Qed.

Lemma lawful_outer n m p q : lawful n p -> lawful m q -> lawful (n * m) (outer p q).
Proof.
move=> [<- p0 p1] [<- q0 q1]; split=> [|k|]; first exact: outer_size.
  case: (ltnP k (size p * size q)) => h.
    by have [i j ->] := divmod h; rewrite outerP // mulr_ge0.
  by rewrite /number /PolicyMeaning.number nth_default ?ratio_zero // outer_size.
rewrite sum_product -[RHS]p1; apply: eq_bigr => i _.
under eq_bigr do rewrite outerP //.
by rewrite -mulr_sumr q1 mulr1.
Qed.

(* ---- Factors and their products ---- *)

Definition lawful_matrix (F : matrix) : Prop := forall i, (i < size F)%N -> lawful (width F) (nth [::] F i).
Definition lawful_filter (fs : list matrix) : Prop := foldr (fun F P => lawful_matrix F /\ P) True fs.

Lemma valid_factorP F : valid_factor F -> lawful_matrix F.
Proof. by case/and3P => rows _ _ i iF; apply/is_lawP/forallb_nth. Qed.

Lemma valid_filterP fs : valid_filter fs -> lawful_filter fs.
Proof. by case/andP=> _; elim: fs => //= F fs IH /andP[/valid_factorP vF /IH]. Qed.

Lemma inputs_cons F fs : inputs_of (F :: fs) = (size F * inputs_of fs)%N. Proof. by []. Qed.
Lemma outputs_cons F fs : outputs_of (F :: fs) = (width F * outputs_of fs)%N. Proof. by []. Qed.

Lemma multiplied_out_size fs : size (multiplied_out fs) = inputs_of fs.
Proof.
elim: fs => // F fs IH; rewrite inputs_cons -IH.
by apply: (@size_flat_map _ _ [::]) => i _; rewrite size_map_list.
Qed.

Lemma multiplied_out_row F fs i i' : (i < size F)%N -> (i' < inputs_of fs)%N ->
  nth [::] (multiplied_out (F :: fs)) (i * inputs_of fs + i') = outer (nth [::] F i) (nth [::] (multiplied_out fs) i').
Proof.
move=> iF ifs; rewrite (@nth_flat_map _ _ [::] [::] _ (inputs_of fs)) // => [|k _].
  by rewrite (nth_map_in [::]) // multiplied_out_size.
by rewrite size_map_list multiplied_out_size.
Qed.

Lemma lawful_product fs a : lawful_filter fs -> (a < inputs_of fs)%N -> lawful (outputs_of fs) (nth [::] (multiplied_out fs) a).
Proof.
elim: fs a => [a _|F fs IH a [lF lfs]].
  case: a => // _; split=> // [[|i]|]; rewrite ?big_ord1 /number /PolicyMeaning.number /= ?ratio_one ?nth_nil ?ratio_zero ?ler01 //.
rewrite inputs_cons => aF; have [i i' ->] := divmod aF.
by rewrite multiplied_out_row //; apply: lawful_outer; [apply: lF | apply: IH].
Qed.

Lemma product_entry F fs i i' j j' : lawful_filter (F :: fs) -> (i < size F)%N -> (i' < inputs_of fs)%N ->
  (j < width F)%N -> (j' < outputs_of fs)%N ->
  entry (multiplied_out (F :: fs)) (i * inputs_of fs + i') (j * outputs_of fs + j') = entry F i j * entry (multiplied_out fs) i' j'.
Proof.
move=> [lF lfs] iF ifs jF jfs; rewrite /entry /PolicyMeaning.entry multiplied_out_row //.
have [sF _ _] := lF i iF; have [sfs _ _] := lawful_product lfs ifs.
by rewrite -sfs outerP ?sF ?sfs.
Qed.

(* ---- Integers over one denominator ---- *)

Lemma common_gt0 qs : Z.lt Z0 (common qs).
Proof.
elim: qs => // q qs IH; rewrite [common _]/(Z.lcm _ (common qs)).
have := Z.lcm_nonneg (Zpos (Qden q)) (common qs); rewrite Z.le_lteq => -[//|/esym/Z.lcm_eq_0[//|]].
by move=> e; rewrite e in IH.
Qed.

Lemma common_divide qs q : In q qs -> Z.divide (Zpos (Qden q)) (common qs).
Proof.
elim: qs q => // r qs IH q [->|/IH h]; first exact: Z.divide_lcm_l.
exact: Z.divide_trans h (Z.divide_lcm_r _ _).
Qed.

Lemma overE d q : Z.divide (Zpos (Qden q)) d -> embed (over d q) = embed d * ratio q :> R.
Proof.
case=> e ->; rewrite /over Z.div_mul // /ratio !embedM.
by rewrite -mulrA [embed (Zpos _) * _]mulrC divfK ?embed_neq0 // mulrC.
Qed.

Lemma in_nth (T : Type) (d : T) s i : (i < size s)%N -> In (nth d s i) s.
Proof. by elim: s i => // x s IH [|i] /=; [left | move=> h; right; apply: IH]. Qed.

Definition integer (v : seq Z) (i : nat) : R := embed (nth Z0 v i).

Lemma over_numbers d v i : (forall q, In q v -> Z.divide (Zpos (Qden q)) d) -> integer (List.map (over d) v) i = embed d * number v i.
Proof.
move=> dv; rewrite /integer; case: (ltnP i (size v)) => h.
  by rewrite (@nth_map_in _ _ zero) // overE //; apply/dv/in_nth.
by rewrite /number /PolicyMeaning.number !nth_default ?size_map_list // ratio_zero mulr0.
Qed.

Lemma integersE F i j : (i < size F)%N -> integer (nth [::] (integers F) i) j = embed (unit_of F) * entry F i j.
Proof.
move=> iF; rewrite /integers (@nth_map_in _ _ [::]) // over_numbers // => q qr; apply: common_divide.
by apply/in_concat; exists (nth [::] F i); split=> //; apply: in_nth.
Qed.

Lemma units_gt0 fs : 0 < embed (units fs) :> R.
Proof.
elim: fs => [|F fs IH]; first by rewrite embed1 ltr01.
rewrite [units _]/(Z.mul (unit_of F) (units fs)) embedM mulr_gt0 //; apply: embed_gt0.
by apply/Z.ltb_lt/common_gt0.
Qed.

(* ---- The induced law ---- *)

Lemma nth_combine (T T' : Type) (d : T) (d' : T') s s' i : size s = size s' -> (i < size s)%N ->
  nth (d, d') (combine s s') i = (nth d s i, nth d' s' i).
Proof. by elim: s s' i => [|x s IH] [|y s'] [|i] //= [e] h; apply: IH. Qed.

Lemma size_combine (T T' : Type) (s : seq T) (s' : seq T') : size s = size s' -> size (combine s s') = size s.
Proof. by elim: s s' => [|x s IH] [|y s'] //= [/IH->]. Qed.

Lemma mixture_size n row vs : (forall j, (j < size vs)%N -> size (nth [::] vs j) = n) -> size (mixture n row vs) = n.
Proof.
elim: row vs => [|p row IH] [|v vs] // sv; try by rewrite [mixture _ _ _]/(repeat Z0 n) -size_length repeat_length.
have sr : size (mixture n row vs) = n by apply: IH => j; apply: (sv j.+1).
have sv0 : size v = n := sv 0%N isT.
by case: p => [|p|p] //=; rewrite size_map_list size_combine ?sr ?sv0.
Qed.

Lemma nth_repeat (T : Type) (d x : T) n i : (i < n)%N -> nth d (repeat x n) i = x.
Proof. by elim: n i => // n IH [|i] //= h; apply: IH. Qed.

Lemma mixtureP n row vs t : size vs = size row -> (forall j, (j < size vs)%N -> size (nth [::] vs j) = n) -> (t < n)%N ->
  integer (mixture n row vs) t = \sum_(j < size row) integer row j * integer (nth [::] vs j) t.
Proof.
elim: row vs => [|p row IH] [|v vs] //= => [_ _ tn|[e] sv tn].
  by rewrite big_ord0 /integer nth_repeat // embed0.
rewrite big_ord_recl /= -IH // => [|j]; last exact: (sv j.+1).
have sr : size (mixture n row vs) = n by apply: mixture_size => j; apply: (sv j.+1).
have sv0 : size v = n := sv 0%N isT.
have main : integer (List.map (fun t => Z.add (Z.mul p t.1) t.2) (combine v (mixture n row vs))) t =
    embed p * integer v t + integer (mixture n row vs) t.
  by rewrite /integer (@nth_map_in _ _ (Z0, Z0)) ?size_combine ?sr ?sv0 // nth_combine ?sr ?sv0 //= embedD embedM.
by case: p main => [|p|p] main //; rewrite [integer (Z0 :: _) 0]embed0 mul0r add0r.
Qed.

Lemma mixed_size n fs vs : lawful_filter fs -> size vs = (outputs_of fs * n)%N -> size (mixed n fs vs) = (inputs_of fs * n)%N.
Proof.
elim: fs vs => [|F fs IH] vs; first by rewrite /inputs_of /outputs_of /= mul1n.
move=> [lF lfs]; rewrite outputs_cons inputs_cons -!mulnA => sv.
have -> : size F = size (integers F) by rewrite size_map_list.
apply: (@size_flat_map _ _ [::]) => i _; apply: mixture_size => j; rewrite size_map_list size_pieces => jF.
by rewrite (@nth_map_in _ _ [::]) ?size_pieces // IH // size_piece.
Qed.

Lemma mixedP n fs vs a u : lawful_filter fs -> size vs = (outputs_of fs * n)%N -> (a < inputs_of fs)%N -> (u < n)%N ->
  integer (mixed n fs vs) (a * n + u) =
  embed (units fs) * \sum_(b < outputs_of fs) entry (multiplied_out fs) a b * integer vs (b * n + u).
Proof.
elim: fs vs a => [|F fs IH] vs a.
  case: a => // _ _ _ _; rewrite /outputs_of /= big_ord1 embed1 !mul1r mul0n add0n.
  by rewrite /entry /PolicyMeaning.entry /PolicyMeaning.number /= ratio_one mul1r.
move=> [lF lfs]; rewrite outputs_cons inputs_cons -mulnA => sv /divmod[iF ifs ->] un.
set i := (a %/ _)%N in iF *; set i' := (a %% _)%N in ifs *.
have spiece j : (j < width F)%N -> size (nth [::] (pieces (width F) (outputs_of fs * n) vs) j) = (outputs_of fs * n)%N.
  by move=> jF; apply: size_piece.
have smixed j : (j < width F)%N ->
    nth [::] (List.map (mixed n fs) (pieces (width F) (outputs_of fs * n) vs)) j = mixed n fs (nth [::] (pieces (width F) (outputs_of fs * n) vs) j).
  by move=> jF; rewrite (@nth_map_in _ _ [::]) ?size_pieces.
have [srow _ _] := lF i iF.
have srow' : size (nth [::] (integers F) i) = width F by rewrite (@nth_map_in _ _ [::]) // size_map_list srow.
have place : (i' * n + u < inputs_of fs * n)%N := ltn_place ifs un.
rewrite mulnDl -mulnA -addnA /integer /mixed -/mixed (@nth_flat_map _ _ [::] Z0 _ (inputs_of fs * n)%N) ?size_map_list //; last first.
  move=> k _; apply: mixture_size => j; rewrite size_map_list size_pieces => jF.
  by rewrite smixed // mixed_size // spiece.
rewrite -[LHS]/(integer _ _) mixtureP ?srow' ?size_map_list ?size_pieces // => [|j jF]; last by rewrite smixed // mixed_size // spiece.
rewrite (sum_product _ _ (fun b => entry (multiplied_out (F :: fs)) (i * inputs_of fs + i') b * embed (nth Z0 vs (b * n + u)))).
rewrite mulr_sumr; apply: eq_bigr => j _.
have -> : \sum_(j' < outputs_of fs) entry (multiplied_out (F :: fs)) (i * inputs_of fs + i') (j * outputs_of fs + j') *
    embed (nth Z0 vs ((j * outputs_of fs + j') * n + u)) =
    entry F i j * \sum_(j' < outputs_of fs) entry (multiplied_out fs) i' j' *
      integer (nth [::] (pieces (width F) (outputs_of fs * n) vs) j) (j' * n + u).
  rewrite mulr_sumr; apply: eq_bigr => j' _; rewrite product_entry // -[LHS]mulrA; congr (_ * (_ * _)).
  by rewrite /integer (@nth_pieces _ Z0) //; [rewrite mulnA addnA -mulnDl | apply: ltn_place].
rewrite integersE // smixed // IH // ?spiece //.
by rewrite [units (F :: fs)]/(Z.mul (unit_of F) (units fs)) embedM mulrACA.
Qed.

Lemma concat_flat_map (T : Type) (s : seq (seq T)) : concat s = flat_map id s.
Proof. by elim: s => //= x s ->. Qed.

Lemma nth_concat (T : Type) (d : T) s m i j : (forall i, (i < size s)%N -> size (nth [::] s i) = m) ->
  (i < size s)%N -> (j < m)%N -> nth d (concat s) (i * m + j) = nth d (nth [::] s i) j.
Proof. by move=> sm is_ jm; rewrite concat_flat_map (@nth_flat_map _ _ [::] d _ m). Qed.

Lemma size_concat (T : Type) (s : seq (seq T)) m : (forall i, (i < size s)%N -> size (nth [::] s i) = m) ->
  size (concat s) = (size s * m)%N.
Proof. by move=> sm; rewrite concat_flat_map (@size_flat_map _ _ [::] _ m). Qed.

Lemma identity_size n : size (identity_matrix n) = n.
Proof. by elim: n => //= n IH; rewrite size_map_list IH. Qed.

Lemma identity_entry n i j : (i < n)%N -> (j < n)%N -> entry (identity_matrix n) i j = (i == j)%:R.
Proof.
rewrite /entry /PolicyMeaning.entry; elim: n i j => // n IH [|i] [|j] //= ni nj; rewrite /PolicyMeaning.number /=.
- exact: ratio_one.
- by rewrite nth_repeat // ratio_zero.
- by rewrite (@nth_map_in _ _ [::]) ?identity_size //= ratio_zero.
- by rewrite (@nth_map_in _ _ [::]) ?identity_size //=; apply: IH.
Qed.
End Sound.
