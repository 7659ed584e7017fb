(* What PolicyFloors.v accepts is the greatest ratio over the policies that keep the declared floors, or a bound on it. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions T13 T17.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditChecker Require Import Policy PolicyMeaning PolicySound PolicyLaw Likelihoods LikelihoodsSound PolicyClaims PolicyFacts PolicyBounds PolicyMeans.
From FairauditChecker Require Import PolicySites PolicySitesSound PolicyWorthSound PolicySuprema PolicySupremaSound PolicyShown PolicyShownSound PolicyFloors.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Behind.
Variables (R : realFieldType) (S : behind).
Hypotheses (ok : valid S).
Local Notation number := (@number R).
Local Notation MX := (@MX R S).
Local Notation MA := (@MA R S).
Local Notation MA_all := (@MA_all R S).
Local Notation g := (@g R S).
Local Notation share := (@share R S).
Local Notation A := (A S).
Local Notation X := (X S).
Local Notation Xt := (Xt S).
Local Notation At := (At S).
Local Notation U := (U S).
Local Notation memory := (memory S).
Local Notation kX := (kernel_MX R ok).
Local Notation kM := (kernel_MA_all R ok).
Local Notation w0 := (u0 ok).
Local Notation quantity := (@quantity R S).
Local Notation compared := (@compared R S).
Local Notation worth := (@worth R S).
Implicit Types (c : option X) (a : A) (T : Xt -> memory -> U -> R).

(* ---- One k ---- *)

Lemma scaled_le (x y z e v f : R) : 0 < x -> 0 < y -> 0 < z -> x * y * (z * e) <= v * f * (x * z * y) -> e <= v * f.
Proof.
move=> x0 y0 z0; have c0 : 0 < x * y * z by rewrite !mulr_gt0.
have -> : x * y * (z * e) = x * y * z * e by ring.
have -> : v * f * (x * z * y) = x * y * z * (v * f) by ring.
by rewrite ler_pmul2l.
Qed.

Lemma one_kP c a a' V ks W s (f : Q) T : compared c a -> compared c a' -> 0 < embed W :> R ->
  stands (embed W) s (MA_all a) (MA_all a') ->
  one_k V ks (Z.mul (unit_of (worths S (place_of c))) W) s (sites_at c a) (sites_at c a') f -> policy T ->
  let E := Definitions.utility (induced MX MA_all T) g in ratio f <= quantity c E a' -> quantity c E a <= ratio V * quantity c E a'.
Proof.
move=> com com' W0 sS /existsb_exists[k [_ /andP[/(at_mostP R) kV /(at_mostP R) le]]] kT E floor.
have Z1 z : ratio (Qmake z 1) = embed z :> R by rewrite /ratio /= embed1 divr1.
move: le; rewrite Z1 (excessP ok k com com' sS) !ratio_times ratio_difference Z1 !embedM.
rewrite -/(unit_in R c) => /(scaled_le (unit_in_gt0 R c) (embed_pos R (Qden k)) W0) le'.
apply: le_trans (quantity_le ok c (ratio k) a a' kT) _.
rewrite -[X in _ <= X * _](subrK (ratio k)) addrC mulrDl ler_add2r; apply: le_trans le' _.
by apply: ler_wpmul2l; rewrite ?subr_ge0.
Qed.

(* ---- Multipliers of floors ---- *)

Definition shown c a (y : nat) (u : U) : R :=
  if c is Some x then entry (context_matrix S) x y * g u x a else worth c a y u.

Lemma quantity_shown c T a :
  quantity c (Definitions.utility (induced MX MA_all T) g) a = \sum_(y : Xt) \sum_w \sum_u T y w u * (MA_all a w * shown c a y u).
Proof.
rewrite pair_bigA; case: c => [x|] /=.
  rewrite cell_value; apply: eq_bigr => -[y w] _; apply: eq_bigr => u _.
  by rewrite /cell_part /= [MX x y * _]mulrC -mulrA.
by rewrite /mean mean_value; apply: eq_bigr => -[y w] _.
Qed.

Lemma shown_worthP c a : compared c a -> let v := shown_worth S (mean_worths S) (place_of c) a in
  size v = (released_contexts S * decisions S)%N /\ forall (y : Xt) (u : U), number v (y * decisions S + u) = shown c a y u.
Proof.
case: c => [x _|m0] /=; last by have [s e] := worthsP (c := None) ok m0; rewrite list_nth; split=> // y u; apply: e.
have [sm smx] := context_matrix_size R ok; have row := smx x (ltn_ord x); rewrite list_nth.
have sizes i : (i < size (nth [::] (context_matrix S) x))%N -> size (List.map (times (nth zero (nth [::] (context_matrix S) x) i)) (gains S x a)) = decisions S.
  by move=> _; rewrite size_map_list; have [] := gains_ok R ok (ltn_ord x) (ltn_ord a).
split=> [|y u]; first by rewrite (@size_flat_map _ _ zero _ (decisions S)) // row.
rewrite /number /PolicyMeaning.number (@nth_flat_map _ _ zero zero _ (decisions S)) ?row ?ltn_ord //; last by rewrite -row.
rewrite (@nth_map_in _ _ zero) ?ratio_times //; have [-> _] := gains_ok R ok (ltn_ord x) (ltn_ord a).
exact: ltn_ord.
Qed.

(* A term as it is meant: c and a are in range *)
Definition fits (t : term) c a : Prop := [/\ t.1.1 = place_of c, t.1.2 = a & compared c a].
Definition fitting (ts : seq term) : Prop := forall t, In t ts -> exists c a, fits t c a.

Section Terms.
Hypothesis one : one_release S.
Variables (T : Xt -> memory -> U -> R) (kT : policy T).
Local Notation E := (Definitions.utility (induced MX MA_all T) g).

(* What is in the numbers of a term, besides its multiplier *)
Definition of_term (t : term) (y : Xt) (b : At) (u : U) : R :=
  number (nth [::] (group_matrix S) t.1.2) b *
  number (nth [::] (pieces (released_contexts S) (decisions S) (shown_worth S (mean_worths S) t.1.1 t.1.2)) y) u.
Definition amount (e : memory -> At) (t : term) : R := \sum_(y : Xt) \sum_w \sum_u T y w u * of_term t y (e w) u.

Lemma of_termP t c a y b u : fits t c a -> of_term t y b u = MA a b * shown c a y u.
Proof.
case: t => -[c' a'] q [/= -> -> com]; rewrite /of_term /=; congr (_ * _).
by have [_ <-] := shown_worthP com; rewrite /number /PolicyMeaning.number (@nth_pieces _ zero) ?ltn_ord.
Qed.

Lemma amountP (e : memory -> At) t c a : (forall a w, MA_all a w = MA a (e w)) -> fits t c a -> amount e t = quantity c E a.
Proof.
move=> eM ft; rewrite quantity_shown; apply: eq_bigr => y _; apply: eq_bigr => w _; apply: eq_bigr => u _.
by rewrite (of_termP y (e w) u ft) eM.
Qed.

Lemma value_terms (ts : seq term) (e : memory -> At) :
  \sum_(y : Xt) \sum_w \sum_u T y w u * (\sum_(t <- ts) ratio t.2 * of_term t y (e w) u) = \sum_(t <- ts) ratio t.2 * amount e t.
Proof.
under eq_bigr => y _ do under eq_bigr => w _ do under eq_bigr => u _ do rewrite mulr_sumr.
transitivity (\sum_(t <- ts) \sum_(y : Xt) \sum_w \sum_u T y w u * (ratio t.2 * of_term t y (e w) u)).
  rewrite [RHS]exchange_big; apply: eq_bigr => y _; rewrite [RHS]exchange_big; apply: eq_bigr => w _; exact: exchange_big.
apply: eq_bigr => t _; rewrite mulr_sumr; apply: eq_bigr => y _; rewrite mulr_sumr; apply: eq_bigr => w _.
by rewrite mulr_sumr; apply: eq_bigr => u _; rewrite mulrCA.
Qed.

Lemma number_le_greatest (v : seq Q) (u : U) : size v = decisions S -> number v u <= ratio (greatest_of v).
Proof. by move=> sv; apply/greatest_of_ge/in_nth; rewrite sv ltn_ord. Qed.

Lemma greatest_sumP (ts : seq term) (e : memory -> At) : fitting ts -> (forall F : At -> R, \sum_w F (e w) = \sum_b F b) ->
  \sum_(y : Xt) \sum_w \sum_u T y w u * (\sum_(t <- ts) ratio t.2 * of_term t y (e w) u)
    <= ratio (greatest_sum S (mean_worths S) (group_matrix S) ts).
Proof.
move=> fit eS; rewrite /greatest_sum ratio_total.
set G := fun y => List.map _ (List.seq 0 (released_groups S)).
have -> : \sum_(q <- flat_map G (List.seq 0 (released_contexts S))) ratio q = \sum_(y : Xt) \sum_(b : At) number (G y) b :> R.
  have sG y : size (G y) = released_groups S by rewrite size_map_list size_seq_list.
  rewrite (big_nth zero) (@size_flat_map _ _ 0%N _ (released_groups S)) ?size_seq_list // big_mkord.
  rewrite (sum_product (released_contexts S) (released_groups S) (fun k => ratio (nth zero (flat_map G (List.seq 0 (released_contexts S))) k))).
  apply: eq_bigr => y _; apply: eq_bigr => b _.
  by rewrite (@nth_flat_map _ _ 0%N zero _ (released_groups S)) ?size_seq_list ?ltn_ord // seq_nth_list.
apply: ler_sum => y _; rewrite -(eS (fun b => number (G y) b)); apply: ler_sum => w _.
have -> : \sum_u T y w u * (\sum_(t <- ts) ratio t.2 * of_term t y (e w) u) =
    expect (T y w) (fun u => \sum_(t <- ts) ratio t.2 * of_term t y (e w) u) by [].
have lT := kT y w; rewrite -[leRHS](expect_cst _ lT); apply: expect_le => // u.
rewrite /number /PolicyMeaning.number /G (@nth_map_in _ _ 0%N) ?size_seq_list ?ltn_ord // seq_nth_list ?ltn_ord // add0n.
set terms := List.map _ (List.map _ _).
have terms_in t : In t terms -> size t.2 = decisions S.
  move=> /in_map_iff[p [<- /in_map_iff[p' [<- /in_map_iff[t' [<- ts_t']]]]]] /=.
  rewrite list_nth size_piece ?ltn_ord //; have [c [a [-> -> com]]] := fit t' ts_t'.
  by have [] := shown_worthP com.
have [sv ev] := @add_upP R (decisions S) terms terms_in.
apply: le_trans (number_le_greatest u sv); rewrite ev // /terms !big_map le_eqVlt; apply/orP; left; apply/eqP.
by apply: eq_bigr => t _; rewrite /= ratio_times !list_nth mulrA.
Qed.

Theorem by_floorsP V c a a' (floors : seq term) : compared c a -> compared c a' -> fitting floors -> keeps_floors E ->
  (forall f, In f floors -> 0 <= ratio f.2 :> R) ->
  (forall f, In f floors -> exists c a, fits f c a /\ ratio (declared_floor S f.1.1 f.1.2) <= quantity c E a) ->
  by_floors S (mean_worths S) (group_matrix S) V (place_of c) a a' floors -> quantity c E a <= ratio V * quantity c E a'.
Proof.
move=> com com' fit keep y0 floors_kept /(at_mostP R); rewrite ratio_total.
set ts := _ :: _ :: floors => le; have [e [eM eS]] := seen_once R one.
have amountE t d b : fits t d b -> amount e t = quantity d E b by apply: amountP.
have fit_ts : fitting ts by move=> t [<-|[<-|/fit//]]; [exists c, a | exists c, a'].
have := greatest_sumP fit_ts eS; rewrite value_terms !big_cons /=.
rewrite (amountE (place_of c, nat_of_ord a, Fractions.one) c a) // (amountE (place_of c, nat_of_ord a', minus V) c a') //.
rewrite ratio_one mul1r ratio_minus mulNr => /le_trans/(_ le); rewrite big_map.
rewrite addrA -ler_subr_addr => /le_trans h; rewrite -subr_le0; apply: h; rewrite subr_le0.
elim: floors y0 floors_kept {fit ts le fit_ts} => [|f fs IH] y0 kept; first by rewrite !big_nil.
rewrite !big_cons; apply: ler_add; last by apply: IH => t h; [apply: y0 | apply: kept]; right.
have [d [b [ft]]] := kept f (or_introl erefl); rewrite -(amountE _ _ _ ft) => kept_f.
by rewrite ratio_times ler_wpmul2l //; apply: y0; left.
Qed.
End Terms.

(* ---- Claims ---- *)

Definition keeping (E : X -> A -> R) : Prop := of_any_policy E /\ keeps_floors E.

(* A floor that is declared and positive is that of something which is compared. *)
Lemma declared_floorP (d : option nat) (i : nat) : positive_fraction (declared_floor S d i) ->
  exists c a, [/\ d = place_of c, i = a, compared c a & forall E : X -> A -> R, keeps_floors E -> ratio (declared_floor S d i) <= quantity c E a].
Proof.
rewrite /declared_floor; case: d => [x|].
  case: ifP => // /andP[/Nat.ltb_lt/ssrnat.ltP hx /Nat.ltb_lt/ssrnat.ltP hi] _.
  exists (Some (Ordinal hx)), (Ordinal hi); split=> // E [cells _] /=.
  have e := @floor_atP R S (Ordinal hx); rewrite /= in e; rewrite e; exact: cells.
case: ifP => // /existsb_exists[j [inj /Nat.eqb_eq ->]] _; have [a ea m0] := populatedP R inj.
exists None, a; split=> // E [_ means] /=; rewrite floor_of_meansP; exact: means.
Qed.

Lemma entries_fitP means pairs p : entries_fit S means pairs -> In p pairs ->
  forall f, In f (prices p) -> positive_fraction (declared_floor S f.1.1 f.1.2) /\ positive_fraction f.2.
Proof. by elim: pairs => //= r rest IH /and4P[_ /forallb_forall all _ fit] [<-|inp] f inf; [apply/andP/all | apply: IH]. Qed.

Lemma keeps_belowP means V ks pairs : entries_fit S means pairs -> keeps_below S V ks pairs means -> bounded means keeping (ratio V).
Proof.
move=> fit; rewrite /keeps_below; cbv zeta => /forallb_forall proofs E [[T [kT eE]] keep]; apply/withinP => c em a a' com com' aa.
rewrite !(eq_quantity c _ eE); have keepT : keeps_floors (Definitions.utility (induced MX MA_all T) g).
  by case: keep => cells mean_kept; split=> [x b|b m0]; [rewrite -eE | rewrite -(@eq_mean R S _ _ b (fun x => eE x b)); apply: mean_kept].
have := proofs (place_of c); rewrite em => /(_ (in_places c)) /(provedP ok)/(_ a a' com com' aa).
case=> [|[W [s [f [W0 sS ef]]]]]; last first.
  by move=> h; apply: (one_kP com com' W0 sS h kT); rewrite ef; apply: floor_ofP.
case found: (List.find (fun p => is_at (place_of c) a a' (priced_pair p)) pairs) => [p|] // /andP[one].
have [inp _] := find_some _ _ found; have fits_p := entries_fitP fit inp.
case: pairs inp {found fit proofs} => // r rest inp.
apply: by_floorsP => //.
- by move=> t /fits_p[/declared_floorP[d [b [ed eb comb _]]] _]; exists d, b; split.
- by move=> t /fits_p[_ pos]; rewrite ltW // ratio_gt0.
move=> t /fits_p[/declared_floorP[d [b [ed eb comb kept]]] _]; exists d, b; split; last exact: kept.
by split.
Qed.

Theorem floored_sound means exactly V ks pairs p : floored_accepted S means exactly V ks pairs p = Some true ->
  if exactly then greatest_ratio means keeping V else greatest_at_most means keeping V.
Proof.
rewrite /floored_accepted; case: ifP => // _ []; cbv zeta => /and5P[_ V1 needs fit /andP[bound policy_]].
have bounded_ v : V = Some v -> bounded means keeping (ratio v) by move=> e; move: bound; rewrite e; apply: keeps_belowP.
case: exactly V1 needs => V1 needs; last by case: (V) bounded_ => // v; apply.
have class0 (E : X -> A -> R) : keeping E -> forall x a, 0 <= E x a.
  by case=> -[T [kT eE]] _ x a; rewrite eE; exact: (@utility_ge0 R X Xt A memory U MX MA_all g kX kM (@g_ge0 R S ok) T x a kT).
have shows : p -> exists c E a a', [/\ means = ~~ isSome c, keeping E, compared c a /\ compared c a', a != a' &
    if V is Some v then 0 < quantity c E a' /\ quantity c E a = ratio v * quantity c E a' else quantity c E a' = 0 /\ 0 < quantity c E a].
  case: p policy_ {needs} => [[p rows]|] // /and4P[one pair_ laws /andP[keep ratio_]] _.
  have [c [a [a' [em ep [eh el] [com com'] aa]]]] := is_pairP R pair_.
  have told := told_of R ok laws.
  exists c, (Definitions.utility (induced MX MA (T_of R rows)) g), a, a'; split=> //.
    by split; [exact: (of_once one (policy_of R ok laws)) | exact: (keepsP told keep)].
  exact: (has_ratioP told ep eh el com com').
case: V V1 needs bounded_ shows {bound policy_} => [v|] /= V1 needs bounded_ shows.
  move/(at_mostP R): V1; rewrite ratio_one => V1; apply: (greatest_finite ok class0) => //; first exact: bounded_.
  case e: (at_most v Fractions.one) needs => needs.
    by left; move/(at_mostP R): e; rewrite ratio_one => e; apply: le_anti; rewrite V1 e.
  by right; apply: shows; case: (p) needs.
by apply: greatest_infinite; apply: shows; case: (p) needs.
Qed.
End Behind.
