(* The widest ratio and difference, with its first place: the program of Figures.v finds it. *)

From Coq Require Import ZArith QArith List Lia.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.zify Require Import ssrZ.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Table Statements Meaning Figures.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Widest.
Variable R : realFieldType.
Local Notation ratio := (@ratio R).

(* ---- Ratios, infinite ones included ---- *)

Lemma no_more_refl (v : option R) : no_more v v. Proof. by case: v => /=. Qed.

Lemma no_more_trans (v u w : option R) : no_more u v -> no_more v w -> no_more u w.
Proof. by case: u v w => [u|] [v|] [w|] //=; apply: le_trans. Qed.

Lemma no_more_total (v w : option R) : ~~ no_more v w -> no_more w v.
Proof. by case: v w => [v|] [w|] //=; rewrite -ltNge; apply: ltW. Qed.

Lemma not_aboveE v w : not_above v w = no_more (extended R v) (extended R w).
Proof. by case: v w => [v|] [w|] //=; rewrite (at_mostE R). Qed.

(* ---- The order of places ---- *)

Lemma lexicographic_irr s : ~~ lexicographic s s.
Proof. by elim: s => //= x s IH; rewrite Z.ltb_irrefl Z.eqb_refl. Qed.

Lemma lexicographic_trans t s u : lexicographic s t -> lexicographic t u -> lexicographic s u.
Proof.
elim: s t u => [|x s IH] [|y t] [|z u] //= /orP[/Z.ltb_lt xy|/andP[/Z.eqb_eq -> st]] /orP[/Z.ltb_lt yz|/andP[/Z.eqb_eq <- tu]].
- by rewrite (proj2 (Z.ltb_lt _ _) (Z.lt_trans _ _ _ xy yz)).
- by rewrite (proj2 (Z.ltb_lt _ _) xy).
- by rewrite (proj2 (Z.ltb_lt _ _) yz).
- by rewrite Z.eqb_refl (IH _ _ st tu) orbT.
Qed.

Lemma lexicographic_asym s t : lexicographic s t -> ~~ lexicographic t s.
Proof. by move=> st; apply/negP => /(lexicographic_trans st); apply/negP; apply: lexicographic_irr. Qed.

Definition order_of_setting (s : setting) : list Z := let '(r, x, u) := s in [:: r; x; u].
Definition setting_before (s t : setting) : bool := lexicographic (order_of_setting s) (order_of_setting t).

Lemma order_of_place p : order_of p = order_of_setting (setting_of p) ++ [:: higher p; lower p].
Proof. by []. Qed.

Lemma before_same p q : setting_of p = setting_of q ->
  before p q = Z.ltb (higher p) (higher q) || Z.eqb (higher p) (higher q) && Z.ltb (lower p) (lower q).
Proof. by rewrite /before /= => -[-> -> ->]; rewrite !Z.ltb_irrefl !Z.eqb_refl /= andbF orbF. Qed.

Lemma lexicographic_cat s t s' t' : lexicographic s t -> lexicographic (s ++ s') (t ++ t').
Proof. by elim: s t => [|x s IH] [|y t] //= /orP[->|/andP[-> /IH ->]] //; rewrite orbT. Qed.

Lemma before_settings p q : setting_before (setting_of p) (setting_of q) -> before p q.
Proof. exact: lexicographic_cat. Qed.

(* ---- The first place with the greatest value, among some ---- *)

Section Among.
Variable worth_at : place -> option R.

Definition first_among (S : place -> Prop) (p : place) : Prop :=
  S p /\ forall p', S p' -> no_more (worth_at p') (worth_at p) /\ (before p' p -> worth_at p' <> worth_at p).

Lemma first_among_ext S S' p : (forall p', S p' <-> S' p') -> first_among S p -> first_among S' p.
Proof. by move=> e [Sp firsts]; split=> [|p' /e]; [apply/e | apply: firsts]. Qed.

Lemma first_of_both (S S' : place -> Prop) p p' :
  first_among S p -> first_among S' p' -> (forall a b, S a -> S' b -> ~~ before b a) ->
  first_among (fun a => S a \/ S' a) (if no_more (worth_at p') (worth_at p) then p else p').
Proof.
move=> [Sp first] [Sp' first'] apart; case: ifP => [le | /negbT gt].
  split=> [|a [/first //|Sa]]; first by left.
  split=> [|b]; last by have := apart _ _ Sp Sa; rewrite b.
  by apply: no_more_trans le; case: (first' _ Sa).
split=> [|a [Sa|/first' //]]; first by right.
have [le _] := first _ Sa; split=> [|_ e]; first exact: no_more_trans le (no_more_total gt).
by move: gt; rewrite -e le.
Qed.
End Among.

(* ---- Rows in the order of their keys ---- *)

Definition keyed (e f : Z * Q) : bool := Z.ltb e.1 f.1.

Lemma keyed_trans : transitive keyed.
Proof. by move=> f e g /Z.ltb_lt ef /Z.ltb_lt fg; apply/Z.ltb_lt; apply: Z.lt_trans fg. Qed.

Lemma sorted_head e es f : sorted keyed (e :: es) -> List.In f es -> Z.lt e.1 f.1.
Proof.
move=> /= /(order_path_min keyed_trans); elim: es => //= g es IH /andP[eg later].
by case=> [<-|fes]; [exact/Z.ltb_lt | exact: IH].
Qed.

Lemma sorted_tail e es : sorted keyed (e :: es) -> sorted keyed es.
Proof. exact: path_sorted. Qed.

Lemma same_key es e f : sorted keyed es -> List.In e es -> List.In f es -> e.1 = f.1 -> e = f.
Proof.
elim: es => //= g es IH srt [<-|ees] [<-|fes] // ef.
- by have := sorted_head srt fes; rewrite ef => /Z.lt_irrefl.
- by have := sorted_head srt ees; rewrite ef => /Z.lt_irrefl.
- exact: IH (sorted_tail srt) ees fes ef.
Qed.

Lemma in_last A (S : list A) e f : List.In e (S ++ [:: f]) <-> List.In e S \/ f = e.
Proof. by elim: S => [|g S IH] /=; tauto. Qed.

(* the first greatest and the first least of some rows *)
Definition first_top (S : list (Z * Q)) (t : Z * Q) : Prop :=
  List.In t S /\ forall e, List.In e S -> ratio e.2 <= ratio t.2 /\ (Z.lt e.1 t.1 -> ratio e.2 < ratio t.2).
Definition first_low (S : list (Z * Q)) (l : Z * Q) : Prop :=
  List.In l S /\ forall e, List.In e S -> ratio l.2 <= ratio e.2 /\ (Z.lt e.1 l.1 -> ratio l.2 < ratio e.2).

Lemma first_top_next S t f : first_top S t -> (forall e, List.In e S -> Z.lt e.1 f.1) ->
  first_top (S ++ [:: f]) (if at_most f.2 t.2 then t else f).
Proof.
move=> [tS tops] later; rewrite (at_mostE R); case: lerP => [le|gt].
  split=> [|e /in_last[/tops //|<-]]; first by apply/in_last; left.
  by split=> // ft; have := later _ tS; lia.
split=> [|e /in_last[eS|<-]]; first by apply/in_last; right.
  by have [le _] := tops _ eS; split=> [|_]; [apply: ltW|]; apply: le_lt_trans gt.
by split=> // /Z.lt_irrefl.
Qed.

Lemma first_low_next S l f : first_low S l -> (forall e, List.In e S -> Z.lt e.1 f.1) ->
  first_low (S ++ [:: f]) (if at_most l.2 f.2 then l else f).
Proof.
move=> [lS lows] later; rewrite (at_mostE R); case: lerP => [le|gt].
  split=> [|e /in_last[/lows //|<-]]; first by apply/in_last; left.
  by split=> // fl; have := later _ lS; lia.
split=> [|e /in_last[eS|<-]]; first by apply/in_last; right.
  by have [le _] := lows _ eS; split=> [|_]; [apply: ltW|]; apply: lt_le_trans le.
by split=> // /Z.lt_irrefl.
Qed.

Lemma extremesP rest S top low :
  sorted keyed rest -> (forall e f, List.In e S -> List.In f rest -> Z.lt e.1 f.1) -> first_top S top -> first_low S low ->
  let tl := extremes top low rest in first_top (S ++ rest) tl.1 /\ first_low (S ++ rest) tl.2.
Proof.
elim: rest S top low => [|f rest IH] S top low /= srt later ftop flow; first by rewrite cats0.
have -> : S ++ f :: rest = (S ++ [:: f]) ++ rest by rewrite -catA.
apply: IH.
- exact: sorted_tail srt.
- move=> e g /in_last[eS gr|<- gr]; first by apply: later => //; right.
  exact: sorted_head srt gr.
- by apply: first_top_next => // e eS; apply: later => //; left.
- by apply: first_low_next => // e eS; apply: later => //; left.
Qed.

Lemma extremes_of e f rest (es := e :: f :: rest) : sorted keyed es ->
  let tl := extremes e e (f :: rest) in first_top es tl.1 /\ first_low es tl.2.
Proof.
move=> srt; apply: (@extremesP _ [:: e]); first exact: sorted_tail srt.
- by move=> g h [<-|//]; apply: sorted_head srt.
- by split=> [|g [<-|//]]; [left | split=> // /Z.lt_irrefl].
- by split=> [|g [<-|//]]; [left | split=> // /Z.lt_irrefl].
Qed.

Lemma find_first (P : Z * Q -> bool) es h : sorted keyed es -> List.find P es = Some h ->
  [/\ List.In h es, P h & forall e, List.In e es -> Z.lt e.1 h.1 -> ~~ P e].
Proof.
elim: es => //= e es IH srt; case Pe: (P e) => found.
  by move: found => [<-]; split=> // [|g [->|/(sorted_head srt)]]; [left | move/Z.lt_irrefl | lia].
have [hes Ph firsts] := IH (sorted_tail srt) found.
by split=> // [|g [<- _|]]; [right | rewrite Pe | apply: firsts].
Qed.

Lemma find_some_of (P : Z * Q -> bool) es e : List.In e es -> P e -> exists h, List.find P es = Some h.
Proof. by elim: es => //= f es IH [->|/IH next] Pe; [rewrite Pe; exists e | case: (P f); [exists f | apply: next]]. Qed.
(* ---- One block ---- *)

Section Block.
Variables (T : table) (q : quantity).
Hypothesis no_distance : is_distance q = false.
Hypothesis unsigned : is_ratio q && signed T = false.
Local Notation quantity_at := (quantity_at R T q).
Local Notation compares := (compares R T q).

(* A block has all groups that take part, in order, with their numbers. *)
Definition right (b : block) : Prop :=
  [/\ at_ b \in settings T q, sorted keyed (entries b),
      forall a, takes_part R T q (at_ b) a <-> exists2 e, List.In e (entries b) & e.1 = a
    & forall e, List.In e (entries b) -> ratio e.2 = amount R T q (at_ b) e.1].

Definition place_found (f : found) : place := place_of (place_at f) (high f).1 (low f).1.

Definition found_in (b : block) (f : found) : Prop :=
  [/\ first_among quantity_at (fun p => compares p /\ setting_of p = at_ b) (place_found f), place_at f = at_ b,
      quantity_at (place_found f) = extended R (worth f)
    & ratio (high f).2 = amount R T q (at_ b) (high f).1 /\ ratio (low f).2 = amount R T q (at_ b) (low f).1].

Definition sound_on (of_block : block -> option found) (b : block) : Prop :=
  if of_block b is Some f then found_in b f else forall p, compares p -> setting_of p <> at_ b.

Lemma place_ofE p : place_of (setting_of p) (higher p) (lower p) = p. Proof. by case: p. Qed.
Lemma setting_of_place s h l : setting_of (place_of s h l) = s. Proof. by case: s => [[r x] u]. Qed.
Lemma higher_of_place s h l : higher (place_of s h l) = h. Proof. by case: s => [[r x] u]. Qed.
Lemma lower_of_place s h l : lower (place_of s h l) = l. Proof. by case: s => [[r x] u]. Qed.

Lemma before_place s h l h' l' :
  before (place_of s h l) (place_of s h' l') = Z.ltb h h' || Z.eqb h h' && Z.ltb l l'.
Proof. by rewrite before_same ?setting_of_place // !higher_of_place !lower_of_place. Qed.

(* What the two numbers give *)
Definition of_sides (h l : R) : option R := if is_ratio q then quotient h l else Some (h - l).

Lemma quantity_of_place s h l : quantity_at (place_of s h l) = of_sides (amount R T q s h) (amount R T q s l).
Proof. by rewrite /quantity_at setting_of_place higher_of_place lower_of_place no_distance. Qed.

Section Right.
Variable b : block.
Hypothesis b_right : right b.
Local Notation es := (entries b).

Lemma compares_pair p : setting_of p = at_ b ->
  compares p <-> exists h l, [/\ List.In h es, List.In l es, h.1 <> l.1 & p = place_of (at_ b) h.1 l.1].
Proof.
case: b_right => at_b srt part amounts e; rewrite /compares unsigned e at_b no_distance /=; split.
  case/and3P => /part[h hes eh] /part[l les el] /eqP differ; exists h, l.
  by rewrite -e eh el place_ofE; split=> //; rewrite -eh -el in differ.
move=> [h [l [hes les differ ->]]]; rewrite higher_of_place lower_of_place; apply/and3P; split; last exact/eqP.
  by apply/part; exists h.
by apply/part; exists l.
Qed.

Lemma found_of v h l :
  List.In h es -> List.In l es -> h.1 <> l.1 -> of_sides (ratio h.2) (ratio l.2) = extended R v ->
  (forall h' l', List.In h' es -> List.In l' es -> h'.1 <> l'.1 ->
     no_more (of_sides (ratio h'.2) (ratio l'.2)) (extended R v)
     /\ (Z.lt h'.1 h.1 \/ h' = h /\ Z.lt l'.1 l.1 -> of_sides (ratio h'.2) (ratio l'.2) <> extended R v)) ->
  found_in b (Found v (at_ b) h l).
Proof.
case: (b_right) => at_b srt part amounts hes les differ value firsts.
rewrite /found_in /place_found /= quantity_of_place -!amounts //; split=> //; split=> /=.
  split; last exact: setting_of_place.
  by apply/compares_pair; [apply: setting_of_place | exists h, l].
move=> p' [comp same]; have [h' [l' [h'es l'es differ' ->]]] := iffLR (compares_pair same) comp.
rewrite !quantity_of_place -!amounts // value; have [le first] := firsts _ _ h'es l'es differ'.
split=> //; rewrite before_place => /orP[/Z.ltb_lt hh|/andP[/Z.eqb_eq hh /Z.ltb_lt ll]]; apply: first; first by left.
by right; split=> //; apply: same_key srt h'es hes hh.
Qed.

Lemma too_few : (forall h l, List.In h es -> List.In l es -> h.1 = l.1) -> forall p, compares p -> setting_of p <> at_ b.
Proof. by move=> few p comp same; have [h [l [hes les differ _]]] := iffLR (compares_pair same) comp; apply: differ; apply: few. Qed.

(* The first two rows, where all numbers are equal *)
Lemma first_two e f rest v : es = e :: f :: rest ->
  (forall h l, List.In h es -> List.In l es -> of_sides (ratio h.2) (ratio l.2) = extended R v) ->
  found_in b (Found v (at_ b) e f).
Proof.
move=> ees all_equal; have srt : sorted keyed es by case: b_right.
have ef : Z.lt e.1 f.1 by rewrite ees in srt; apply: sorted_head srt _; left.
have [ein fin] : List.In e es /\ List.In f es by rewrite ees; split; [left | right; left].
apply: found_of => //; [by lia | exact: all_equal |] => h l hes les differ; rewrite all_equal //.
split; first exact: no_more_refl.
have after_e g : List.In g es -> g = e \/ Z.lt e.1 g.1.
  by rewrite ees => -[->|gin]; [left | right; rewrite ees in srt; apply: sorted_head srt gin].
have after_f g : List.In g es -> g = e \/ g = f \/ Z.lt f.1 g.1.
  rewrite ees => -[->|[->|gin]]; [by left | by right; left | right; right].
  by rewrite ees in srt; apply: sorted_head (sorted_tail srt) gin.
case=> [he|[he le]]; first by case: (after_e _ hes) => [hE|]; [rewrite hE in he; lia | lia].
by case: (after_f _ les) => [lE|[lE|]]; [case: differ; rewrite he lE | rewrite lE in le; lia | lia].
Qed.

Lemma widest_cases equal of_two :
  widest equal of_two b =
  if es is e :: f :: rest then
    let tl := extremes e e (f :: rest) in
    if at_most tl.1.2 tl.2.2 then Some (Found (Some equal) (at_ b) e f)
    else let vh := of_two tl.1 tl.2 es in Some (Found vh.1 (at_ b) vh.2 tl.2)
  else None.
Proof.
by rewrite /widest; case: es => [|e [|f rest]] //; case: (extremes _ _ _) => top low; case: ifP => // _; case: (of_two _ _ _).
Qed.

Lemma fewer_than_two : (if es is _ :: _ :: _ then false else true) -> forall h l, List.In h es -> List.In l es -> h.1 = l.1.
Proof. by case: es => [|e [|f rest]] //= _ h l [<-|[]] [<-|[]]. Qed.

End Right.

Lemma widest_difference_sound b : is_ratio q = false -> right b -> sound_on widest_difference b.
Proof.
move=> no_ratio rb; rewrite /sound_on /widest_difference widest_cases.
case ees: (entries b) => [|e [|f rest]]; try by apply: too_few => //; apply: fewer_than_two => //; rewrite ees.
have srt : sorted keyed (entries b) by case: rb.
rewrite ees in srt; have := extremes_of srt; case: (extremes e e _) => top low /= [[tin tops] [lin lows]].
rewrite (at_mostE R); case: lerP => [flat|steep]; rewrite -ees in tin lin tops lows.
  apply: (first_two rb ees) => h l /[dup] /tops[ht _] /lows[hl _] /[dup] /tops[lt _] /lows[ll _].
  rewrite /of_sides no_ratio /= ratio_zero; congr Some; apply/eqP; rewrite subr_eq0 eq_le.
  by rewrite (le_trans ht (le_trans flat ll)) (le_trans lt (le_trans flat hl)).
apply: found_of => //.
- by move=> e12; move: steep; rewrite (same_key _ tin lin e12) ?ltxx //; case: rb.
- by rewrite /of_sides no_ratio /= ratio_plus ratio_minus.
move=> h l hin lin' _; rewrite /of_sides no_ratio /= ratio_plus ratio_minus.
have [ht hlt] := tops _ hin; have [ll llt] := lows _ lin'.
split; first exact: ler_sub.
by case=> [/hlt lt|[-> /llt lt]] [e0]; [have := ltr_le_sub lt ll | have := ler_lt_sub (lexx (ratio top.2)) lt]; rewrite e0 ltxx.
Qed.

Lemma widest_ratio_sound b : is_ratio q -> right b -> (forall e, List.In e (entries b) -> 0 <= ratio e.2) -> sound_on widest_ratio b.
Proof.
move=> has_ratio rb nonneg; rewrite /sound_on /widest_ratio widest_cases.
have sides h l : of_sides h l = quotient h l by rewrite /of_sides has_ratio.
case ees: (entries b) => [|e [|f rest]]; try by apply: too_few => //; apply: fewer_than_two => //; rewrite ees.
have srt : sorted keyed (entries b) by case: rb.
have := srt; rewrite {1}ees => srt'; have := extremes_of srt'; case: (extremes e e _) => top low /= [[tin tops] [lin lows]].
rewrite (at_mostE R); case: lerP => [flat|steep]; rewrite -ees in tin lin tops lows *.
  apply: (first_two rb ees) => h l /[dup] /tops[ht _] /lows[hl _] /[dup] /tops[lt _] /lows[ll _].
  have -> : ratio h.2 = ratio l.2 by apply/eqP; rewrite eq_le (le_trans ht (le_trans flat ll)) (le_trans lt (le_trans flat hl)).
  by rewrite sides /quotient /= ratio_one; case: eqP => // /eqP l0; rewrite divff.
have top0 : 0 < ratio top.2 by apply: le_lt_trans steep; apply: nonneg.
have other h : List.In h (entries b) -> 0 < ratio h.2 -> ratio low.2 = 0 -> h.1 <> low.1.
  by move=> hin h0 l0 e12; move: h0; rewrite (same_key srt hin lin e12) l0 ltxx.
rewrite /over_least (no_numeratorE R); case: eqP => [low0|/eqP low0] /=.
  have [h found] := find_some_of (P := fun e => positive_fraction e.2) tin (etrans (positive_fractionE R _) top0).
  rewrite found; have [hin] := find_first srt found; rewrite (positive_fractionE R) => h0 firsts.
  apply: found_of => //; first exact: other.
    by rewrite sides /quotient low0 eqxx gt_eqF.
  move=> h' l' h'in l'in _; split; first by rewrite /=; case: of_sides.
  rewrite sides /quotient; case=> [lt|[-> lt]].
    have := firsts _ h'in lt; rewrite (positive_fractionE R) -leNgt => h'0.
    have -> : ratio h'.2 = 0 by apply/eqP; rewrite eq_le h'0 nonneg.
    by case: ifP => // _; rewrite eqxx.
  by have [_ /(_ lt)] := lows _ l'in; rewrite low0 => l'0; rewrite gt_eqF.
have low_gt0 : 0 < ratio low.2 by rewrite lt_def low0 nonneg.
have value : ratio (times top.2 (inverse low.2)) = ratio top.2 / ratio low.2.
  by rewrite ratio_times ratio_inverse // (positive_fractionE R).
apply: found_of => //.
- by move=> e12; move: steep; rewrite (same_key srt tin lin e12) ltxx.
- by rewrite sides /quotient (negbTE low0) /= value.
move=> h l hin lin' _; have [ht hlt] := tops _ hin; have [ll llt] := lows _ lin'.
have l0 : 0 < ratio l.2 by apply: lt_le_trans ll.
rewrite sides /quotient gt_eqF //= value; split.
  by rewrite ler_pdivr_mulr // mulrAC ler_pdivl_mulr // ler_pmul // ?nonneg // ltW.
move=> first [] /eqP; rewrite eqr_div ?(gt_eqF l0) ?(gt_eqF low_gt0) // => /eqP e0.
suff : ratio h.2 * ratio low.2 < ratio top.2 * ratio l.2 by rewrite e0 ltxx.
case: first => [/hlt lt|[-> /llt lt]]; last by rewrite ltr_pmul2l.
by apply: lt_le_trans (_ : ratio top.2 * ratio low.2 <= _); [rewrite ltr_pmul2r | rewrite ler_pmul2l].
Qed.

(* ---- Several blocks ---- *)

Definition blocks_before (b c : block) : bool := setting_before (at_ b) (at_ c).

(* Blocks in order that leave out nobody who is compared *)
Definition cover (bs : list block) : Prop :=
  [/\ forall b, List.In b bs -> right b, sorted blocks_before bs
    & forall p, compares p -> exists2 b, List.In b bs & setting_of p = at_ b].

Definition figure_sound (f : option found) : Prop :=
  if f is Some f then
    [/\ first_greatest R T q (place_found f), quantity_at (place_found f) = extended R (worth f)
      & ratio (high f).2 = amount R T q (place_at f) (high f).1 /\ ratio (low f).2 = amount R T q (place_at f) (low f).1]
  else ~ exists p, compares p.

Lemma blocks_before_trans : transitive blocks_before.
Proof. by move=> b c d; apply: lexicographic_trans. Qed.

Definition in_some (bs : list block) (p : place) : Prop := compares p /\ exists2 b, List.In b bs & setting_of p = at_ b.

Definition best_so_far (bs : list block) (f : option found) : Prop :=
  if f is Some f then
    [/\ first_among quantity_at (in_some bs) (place_found f), quantity_at (place_found f) = extended R (worth f)
      & ratio (high f).2 = amount R T q (place_at f) (high f).1 /\ ratio (low f).2 = amount R T q (place_at f) (low f).1]
  else forall p, ~ in_some bs p.

Lemma in_some_last bs b p : in_some (bs ++ [:: b]) p <-> in_some bs p \/ compares p /\ setting_of p = at_ b.
Proof.
split=> [[comp [c /in_last[cbs|<-] e]]|[[comp [c cbs e]]|[comp e]]]; [by left; split=> //; exists c | by right | |].
  by split=> //; exists c => //; apply/in_last; left.
by split=> //; exists b => //; apply/in_last; right.
Qed.

Lemma better_sound of_block bs b best :
  sound_on of_block b -> (forall c, List.In c bs -> blocks_before c b) ->
  best_so_far bs best -> best_so_far (bs ++ [:: b]) (better best (of_block b)).
Proof.
rewrite /sound_on; case: (of_block b) => [n|] sound later; last first.
  case: best => [f [first value sides]|nobody] /=.
    split=> //; apply: first_among_ext first => p; split=> [/(fun h => or_introl h)/in_some_last //|/in_some_last[//|[comp]]].
    by move/(sound _ comp).
  by move=> p /in_some_last[/nobody //|[comp]]; apply: sound.
case: sound => first at_n value sides; rewrite -at_n in sides.
case: best => [f [ffirst fvalue fsides]|nobody] /=; last first.
  split=> //; apply: first_among_ext first => p; rewrite in_some_last; split=> [[comp same]|[/nobody //|//]]; by right.
have apart p p' : in_some bs p -> compares p' /\ setting_of p' = at_ b -> ~~ before p' p.
  move=> [_ [c cbs e]] [_ e']; apply: lexicographic_asym; rewrite -/(before p p'); apply: before_settings.
  by rewrite e e'; apply: later.
have := first_of_both ffirst first apart; rewrite fvalue value -not_aboveE.
by case: ifP => _ both; split=> //; apply: first_among_ext both => p; apply: iff_sym; apply: in_some_last.
Qed.

Lemma best_from of_block bs : sorted blocks_before bs -> (forall b, List.In b bs -> sound_on of_block b) ->
  forall cs done best, done ++ cs = bs -> best_so_far done best ->
  best_so_far bs (fold_left (fun best b => better best (of_block b)) cs best).
Proof.
move=> srt sound; elim=> [|b cs IH] done best e so_far; first by rewrite -e cats0.
apply: (IH (done ++ [:: b])); first by rewrite -catA.
apply: better_sound so_far.
  by apply: sound; rewrite -e; apply: (in_or_app done (b :: cs)); right; left.
move=> c cdone; move: srt; rewrite -e; elim: done cdone {IH e} => //= d done IH [->|cdone] path_d.
  by have := order_path_min blocks_before_trans path_d; rewrite all_cat => /andP[_ /andP[]].
by apply: IH => //; apply: path_sorted path_d.
Qed.

Lemma best_of_sound of_block bs : cover bs -> (forall b, List.In b bs -> sound_on of_block b) -> figure_sound (best_of of_block bs).
Proof.
case=> rights srt all_covered sound.
suff so_far : best_so_far bs (best_of of_block bs).
  move: so_far; case: (best_of _ _) => [f [first value sides]|nobody] /=; last first.
    by case=> p comp; apply: (nobody p); split=> //; apply: all_covered.
  split=> //; have [[comp _] firsts] := first; split=> // p' comp'.
  by apply: firsts; split=> //; apply: all_covered.
by apply: (best_from srt sound (done := [::])) => // p [_ [b []]].
Qed.
End Block.
End Widest.
