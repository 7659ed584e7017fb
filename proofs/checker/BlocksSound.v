(* The blocks in which groups are compared leave out nobody, and have the numbers of Meaning.v. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures Checker ListsSound TableSound WidestSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Blocks.
Variables (R : realFieldType) (T : table).
Hypothesis ok : valid T.
Local Notation ratio := (@ratio R).
Local Notation number := (@ListsSound.number R).
Local Notation F := (rows_of T).
Local Notation G := (if with_means T then with_mass (group_rows T F) else [::]).

Definition entries_by (h : row -> Q) (rs : list row) : list (Z * Q) := map (fun r => (who r, h r)) rs.

Lemma entries_sorted h rs : sorted row_before rs -> sorted keyed (entries_by h rs).
Proof. by rewrite sorted_map. Qed.

(* ---- In a context ---- *)

Lemma context_rows_sorted x : sorted row_before (map (row_of T) (in_context T x)).
Proof.
rewrite sorted_map /in_context.
have : sorted comes_before [seq c <- cells T | Z.eqb (context c) x] by apply: (sorted_filter (comes_before_trans ok)); apply: cells_sorted.
have : all (fun c => Z.eqb (context c) x) [seq c <- cells T | Z.eqb (context c) x] by apply: filter_all.
case: [seq c <- _ | _] => //= c cs; elim: cs c => //= d cs IH c /and3P[/Z.eqb_eq cx /[dup] /Z.eqb_eq dx dx' all_] /andP[cd srt].
have := IH d; rewrite /= dx' all_ /= => /(_ isT srt) ->; rewrite andbT /row_before /=.
by move: cd; rewrite /comes_before cx dx Z.ltb_irrefl Z.eqb_refl.
Qed.

Lemma in_context_in x c : List.In c (in_context T x) -> List.In c (cells T) /\ context c = x.
Proof. by case/in_filter_seq => cin /Z.eqb_eq. Qed.

Lemma context_block q h s x rs : List.In (x, rs) F -> s \in settings T q ->
  (forall a, takes_part R T q s a = has_cell T x a) ->
  (forall c, List.In c (cells T) -> context c = x -> amount R T q s (group c) = ratio (h (row_of T c))) ->
  right R T q (Block s (entries_by h rs)).
Proof.
move=> xin s_in part amounts; have [-> _] := rows_of_in ok xin; split=> //=.
- exact/entries_sorted/context_rows_sorted.
- move=> a; rewrite part; split=> [/(has_cellP ok)[c cin [cx ca]]|[e /in_map_iff[r [<- /in_map_iff[c [<- /in_context_in[cin cx]]]]] /= <-]].
    exists (group c, h (row_of T c)) => //; apply/in_map_iff; exists (row_of T c); split=> //.
    by apply/in_map_iff; exists c; split=> //; apply/in_filter_seq; split=> //; apply/Z.eqb_eq.
  by apply/(has_cellP ok); exists c.
- by move=> e /in_map_iff[r [<- /in_map_iff[c [<- /in_context_in[cin cx]]]]]; rewrite amounts.
Qed.

(* ---- Of means ---- *)

Lemma with_meansE : with_means T = means_exist T.
Proof. by rewrite /with_means /means_exist (fullE ok). Qed.

Lemma in_G r : List.In r G -> [/\ means_exist T, List.In r (group_rows T F) & positive_fraction (bulk r)].
Proof. by rewrite with_meansE; case: ifP => // _ /in_filter_seq[]. Qed.

Lemma G_sorted : sorted row_before G.
Proof.
case: ifP => // _; apply: sorted_filter; last exact: group_rows_sorted.
by move=> r s t /Z.ltb_lt rs /Z.ltb_lt st; apply/Z.ltb_lt; lia.
Qed.

Lemma has_meanP a : has_mean R T a <-> exists2 r, List.In r G & who r = a.
Proof.
split=> [/and3P[exist ain mass0]|[r /in_G[exist rin pos] <-]].
  have nonempty : of_group a (cells T) <> [::] by move=> e; move: mass0; rewrite sum_of_masses1 // e big_nil ltxx.
  have rin := group_rows_have nonempty; rewrite with_meansE exist.
  exists (row_of_group (Z.to_nat (decisions T)) a (map (row_of T) (of_group a (cells T)))) => //; apply/in_filter_seq; split=> //.
  by rewrite (positive_fractionE R) -group_massE.
have [re nonempty] := group_rows_in rin; rewrite /has_mean exist /=; apply/andP; split.
  case e: (of_group (who r) (cells T)) nonempty => [|c cs] // _.
  have /in_filter_seq[cin /Z.eqb_eq <-] : List.In c (of_group (who r) (cells T)) by rewrite e; left.
  exact: group_inside.
by rewrite (group_massE R ok) -re -(positive_fractionE R).
Qed.

Lemma mean_of_row r : List.In r G -> group_mean R T (who r) = ratio (mean r).
Proof. by case/in_G => _ rin pos; have [re _] := group_rows_in rin; rewrite [in RHS]re; apply: group_meanE; rewrite // -re. Qed.

Lemma law_of_row r u : List.In r G -> u \in range (decisions T) -> group_law R T (who r) u = number u (law_of r).
Proof. by case/in_G => _ rin pos u_in; have [re _] := group_rows_in rin; rewrite [in RHS]re; apply: group_lawE; rewrite // -re. Qed.

Lemma means_block q h s : s \in settings T q -> (forall a, takes_part R T q s a = has_mean R T a) ->
  (forall r, List.In r G -> amount R T q s (who r) = ratio (h r)) ->
  right R T q (Block s (entries_by h G)).
Proof.
move=> s_in part amounts; split=> //=; first exact/entries_sorted/G_sorted.
- move=> a; rewrite part has_meanP; split=> [[r rin <-]|[e /in_map_iff[r [<- rin]] /= <-]]; last by exists r.
  by exists (who r, h r) => //; apply/in_map_iff; exists r.
- by move=> e /in_map_iff[r [<- rin]]; rewrite /= amounts.
Qed.

(* ---- Decisions ---- *)

Lemma of_decisionsE n x u laws :
  of_decisions n x u laws =
  [seq Block (nothing, x, Z.add u (Z.of_nat i)) (map (fun l => (l.1, nth zero l.2 i)) laws) | i <- iota 0 n].
Proof.
elim: n u laws => //= n IH u laws; rewrite Z.add_0_r IH (iotaDl 1 0) -map_comp; congr (_ :: _).
apply: eq_map => i /=; congr (Block _ _); first by congr (_, _, _); lia.
by elim: laws => //= l ls ->; case: l => a [|p ps] //=; rewrite nth_nil.
Qed.

Definition at_number (u : Z) (r : row) : Q := List.nth (Z.to_nat u) (law_of r) zero.

Lemma of_decisions_in n x rs b : List.In b (of_decisions n x Z0 (laws_of rs)) ->
  exists2 i, (i < n)%N & b = Block (nothing, x, Z.of_nat i) (entries_by (at_number (Z.of_nat i)) rs).
Proof.
rewrite of_decisionsE => /in_map_iff[i [<- iin]]; exists i.
  have : i \in iota 0 n by elim: (iota 0 n) iin => //= j js IH [->|/IH]; rewrite in_cons ?eqxx // => ->; rewrite orbT.
  by rewrite mem_iota.
rewrite Z.add_0_l; congr (Block _ _); rewrite /laws_of /entries_by; elim: (rs) => //= r rs' ->.
by rewrite /at_number Nat2Z.id nthE.
Qed.

Lemma of_decisions_have n x rs u : inside (Z.of_nat n) u ->
  List.In (Block (nothing, x, u) (entries_by (at_number u) rs)) (of_decisions n x Z0 (laws_of rs)).
Proof.
case/andP=> /Z.leb_le low /Z.ltb_lt high; rewrite of_decisionsE; apply/in_map_iff; exists (Z.to_nat u); split.
  rewrite Z.add_0_l Z2Nat.id //; congr (Block _ _); rewrite /laws_of /entries_by; elim: (rs) => //= r rs' ->.
  by rewrite /at_number nthE.
have : Z.to_nat u \in iota 0 n by rewrite mem_iota /= add0n; apply/ssrnat.ltP; lia.
by elim: (iota 0 n) => //= j js IH; rewrite in_cons => /orP[/eqP ->|/IH]; [left | right].
Qed.

Lemma later_decision r x u v : Z.lt u v -> setting_before (r, x, u) (r, x, v).
Proof. by move=> lt; rewrite /setting_before /= !Z.ltb_irrefl !Z.eqb_refl /= (proj2 (Z.ltb_lt _ _) lt). Qed.

Lemma later_context r x y u v : Z.lt x y -> setting_before (r, x, u) (r, y, v).
Proof. by move=> lt; rewrite /setting_before /= !Z.ltb_irrefl !Z.eqb_refl /= (proj2 (Z.ltb_lt _ _) lt). Qed.

Lemma of_decisions_sorted n x laws : sorted blocks_before (of_decisions n x Z0 laws).
Proof.
rewrite of_decisionsE sorted_map; apply: sub_sorted (iota_ltn_sorted _ _) => i j /ssrnat.ltP ij.
by apply: later_decision; lia.
Qed.

(* ---- All blocks of a quantity ---- *)

Lemma F_sorted_trans : transitive row_run_before.
Proof. by move=> k l m /Z.ltb_lt kl /Z.ltb_lt lm; apply/Z.ltb_lt; lia. Qed.

Lemma setting_in_context q p : compares R T q p -> setting_of p \in settings T q /\ takes_part R T q (setting_of p) (higher p).
Proof. by case/and5P. Qed.

Lemma cover_local q : q = Local \/ q = Local_difference -> cover R T q (map (fun xr => of_means xr.1 xr.2) F).
Proof.
move=> ql; split.
- move=> b /in_map_iff[[x rs] [<- xin]]; have [_ x_in] := rows_of_in ok xin.
  apply: (context_block (x := x)) => // [||c cin cx].
  + by case: ql => ->; apply: map_f.
  + by case: ql => ->.
  + by case: ql => -> /=; rewrite -cx expectationE.
- rewrite sorted_map; apply: sub_sorted (rows_of_sorted ok) => k l kl.
  by apply: later_context; apply/Z.ltb_lt.
- move=> p /setting_in_context[at_ part]; have : has_cell T (at_context p) (higher p) by case: ql part => ->.
  move/(rows_of_have ok) => xin; exists (of_means (at_context p) (map (row_of T) (in_context T (at_context p)))).
    by apply/in_map_iff; exists (at_context p, map (row_of T) (in_context T (at_context p))).
  by case: ql at_ => -> /mapP[x _]; rewrite /setting_of /= => -[-> -> ->].
Qed.

Lemma cover_global q : q = Global \/ q = Global_difference -> cover R T q [:: of_means nothing G].
Proof.
move=> qg; split=> //.
- move=> b [<-|[]]; apply: means_block => [|a|r rin]; case: qg => -> //; exact: mean_of_row.
- by move=> p /setting_in_context[at_ _]; exists (of_means nothing G); [left | case: qg at_ => ->; rewrite mem_seq1 => /eqP].
Qed.

Lemma decisions_id : Z.of_nat (Z.to_nat (decisions T)) = decisions T.
Proof. by rewrite Z2Nat.id //; have := decisions_gt0 ok; lia. Qed.

Lemma cover_local_supremum : cover R T Local_supremum (flat_map (fun xr => of_decisions (Z.to_nat (decisions T)) xr.1 Z0 (laws_of xr.2)) F).
Proof.
split.
- move=> b /in_flat_map[[x rs] [xin /of_decisions_in[i ilt ->]]] /=; have [_ x_in] := rows_of_in ok xin.
  apply: (context_block (x := x)) => // [|c cin cx].
    apply/allpairsP; exists (x, Z.of_nat i); split=> //=; rewrite mem_range; apply/andP.
    by split; [apply/Z.leb_le | apply/Z.ltb_lt; rewrite -decisions_id; apply: inj_lt; apply/ssrnat.ltP]; lia.
  by rewrite -cx /= lawE.
- apply: (flat_sorted blocks_before_trans F_sorted_trans (rows_of_sorted ok)) => [k _|k l b c _ _ kl]; first exact: of_decisions_sorted.
  move=> /of_decisions_in[i _ ->] /of_decisions_in[j _ ->].
  by apply: later_context; apply/Z.ltb_lt.
- move=> p /setting_in_context[/allpairsP[[x u] [/= xin uin e]] part].
  have : has_cell T x (higher p) by move: part; case: e => _ <- _.
  move/(rows_of_have ok) => rin; exists (Block (nothing, x, u) (entries_by (at_number u) (map (row_of T) (in_context T x)))) => //.
  apply/in_flat_map; exists (x, map (row_of T) (in_context T x)); split=> //; apply: of_decisions_have.
  by rewrite decisions_id -mem_range.
Qed.

Lemma cover_global_supremum : cover R T Global_supremum (of_decisions (Z.to_nat (decisions T)) nothing Z0 (laws_of G)).
Proof.
split.
- move=> b /of_decisions_in[i ilt ->].
  have i_in : Z.of_nat i \in range (decisions T).
    rewrite mem_range; apply/andP.
    by split; [apply/Z.leb_le | apply/Z.ltb_lt; rewrite -decisions_id; apply: inj_lt; apply/ssrnat.ltP]; lia.
  by apply: means_block => [|//|r rin /=]; [apply: map_f | apply: law_of_row].
- exact: of_decisions_sorted.
- move=> p /setting_in_context[/mapP[u uin e] _]; exists (Block (nothing, nothing, u) (entries_by (at_number u) G)) => //.
  by apply: of_decisions_have; rewrite decisions_id -mem_range.
Qed.
End Blocks.
