(* The canonical text of a value denotes the same value with the members of each object in the order of their keys. *)

From Coq Require Import ZArith List Ascii String Bool Permutation Sorted Lia.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditChecker Require Import Json JsonStrings JsonSound Canonical CanonicalSound.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.
Local Open Scope char_scope.

(* ==== What is said of it (this part has to be read) ==== *)

(* Members by the bytes of their keys, in every object *)
Fixpoint by_keys (v : json) : json :=
  match v with
  | Items vs => Items (map by_keys vs)
  | Members ms => Members (SortingMembers.sort (map (fun m => (fst m, by_keys (snd m))) ms))
  | _ => v
  end.

(* Values of certificates: integers of at most 18 digits, strings of whole characters, and keys that differ *)
Fixpoint proper (v : json) : Prop :=
  match v with
  | Null | Bool _ => True
  | Int n => (0 <= n < 10 ^ 18)%Z
  | Text t => whole t
  | Items vs => fold_right (fun v rest => proper v /\ rest) True vs
  | Members ms => NoDup (map fst ms) /\ fold_right (fun m rest => (whole (fst m) /\ proper (snd m)) /\ rest) True ms
  end.

(* ==== Proofs ==== *)

Lemma folded (A : Type) (P : A -> Prop) xs : fold_right (fun x rest => P x /\ rest) True xs -> forall x, In x xs -> P x.
Proof. by elim: xs => //= x xs IH [Px rest] y [<-|/(IH rest)]. Qed.

Lemma json_induction (P : json -> Prop) :
  P Null -> (forall b, P (Bool b)) -> (forall n, P (Int n)) -> (forall t, P (Text t)) ->
  (forall vs, (forall v, In v vs -> P v) -> P (Items vs)) -> (forall ms, (forall m, In m ms -> P (snd m)) -> P (Members ms)) -> forall v, P v.
Proof.
move=> pn pb pi pt items members; fix IH 1 => -[|b|n|t|vs|ms]; [exact: pn | exact: pb | exact: pi | exact: pt | |].
- by apply: items; elim: vs => [v []|v vs rest w [<-|]]; [exact: IH | exact: rest].
- by apply: members; elim: ms => [m []|m ms rest w [<-|]]; [exact: IH | exact: rest].
Qed.

(* ---- Integers ---- *)

Lemma digit_of n : (0 <= n < 10)%Z -> digit (ascii_of_N (48 + Z.to_N n)) = Some n.
Proof.
move=> range; have : n = 0%Z \/ n = 1%Z \/ n = 2%Z \/ n = 3%Z \/ n = 4%Z \/ n = 5%Z \/ n = 6%Z \/ n = 7%Z \/ n = 8%Z \/ n = 9%Z by lia.
by move=> [->|[->|[->|[->|[->|[->|[->|[->|[->|->]]]]]]]]].
Qed.

Lemma digits_onto_step fuel n after : digits_onto (S fuel) n after =
  let d := ascii_of_N (48 + Z.to_N (n mod 10)) in if (n / 10 =? 0)%Z then d :: after else digits_onto fuel (n / 10) (d :: after).
Proof. by rewrite /digits_onto -/digits_onto /Z.div /Z.modulo; case: (Z.div_eucl n 10). Qed.

Lemma digits_written fuel n after : (0 <= n < 10 ^ Z.of_nat (S fuel))%Z ->
  [/\ written 0 (digits_onto (S fuel) n after) = written n after,
      (List.length (digits_onto (S fuel) n after) <= S fuel + List.length after)%nat
    & exists c rest, digits_onto (S fuel) n after = c :: rest /\ ((c =? "0") = false \/ n = 0%Z /\ rest = after)].
Proof.
elim: fuel n after => [|fuel IH] n after range.
all: rewrite digits_onto_step; have last := Z.mod_pos_bound n 10 (eq_refl _); have eq := Z.div_mod n 10 (ltac:(lia)).
all: have dE := digit_of last; set d := ascii_of_N _ in dE *; cbv zeta.
all: have wr m : written m (d :: after) = written (10 * m + n mod 10)%Z after by move: dE; rewrite /=; case: (digit d) => // z [->].
all: have head : (n / 10 = 0)%Z -> (d =? "0") = false \/ n = 0%Z /\ after = after.
1, 3: move=> none; case: (Z.eq_dec n 0) => [->|n0]; [by right | left; apply/eqcP => d0; move: dE; rewrite d0 => -[]; lia].
  have none : (n / 10 = 0)%Z by apply: Z.div_small; move: range; rewrite /=; lia.
  rewrite none; split; [by rewrite wr; congr written; lia | by [] | by exists d, after; split=> //; apply: head].
case: Z.eqb_spec => [none|some].
  split; [by rewrite wr; congr written; lia | by rewrite /=; lia | by exists d, after; split=> //; apply: head].
have small : (0 <= n / 10 < 10 ^ Z.of_nat (S fuel))%Z.
  split; first by apply: Z.div_pos (proj1 range) _; lia.
  by apply: Z.div_lt_upper_bound; [lia | rewrite -Z.pow_succ_r -?Nat2Z.inj_succ; [exact: (proj2 range) | lia]].
have [w len [c [rest [e c0]]]] := IH _ (d :: after) small.
split; [by rewrite w wr; congr written; lia | by move: len => /=; lia |].
by exists c, rest; split=> //; case: c0 => [|[]]; [left | lia].
Qed.

Lemma at_most_length n (s : text) : (List.length s <= n)%nat -> at_most n s.
Proof. by elim: s n => [|c s IH] [|n] //= le; [lia | apply: IH; lia]. Qed.

Lemma decimal_integer n : (0 <= n < 10 ^ 18)%Z -> integer (decimal n) = Some n.
Proof.
move=> range; have [w len [c [rest [e c0]]]] := @digits_written 17 n [] range.
rewrite /decimal /integer at_most_length; last exact: len.
rewrite e in w *; case: rest e w c0 => [|d rest] _ w; first by move=> _; exact: w.
by case=> [c0|[_ //]]; rewrite /natural c0; exact: w.
Qed.

(* ---- Sorting looks at keys alone ---- *)

Section Keyed.
Variable f : text * json -> text * json.
Hypothesis same_key : forall m, fst (f m) = fst m.
Import SortingMembers.

Lemma merge_map ms ns : merge (map f ms) (map f ns) = map f (merge ms ns).
Proof.
elim: ms ns => [|m ms IH] ns; first by case: ns.
elim: ns => [//|n ns IHn].
have step (xs ys : list (text * json)) x y : merge (x :: xs) (y :: ys) =
  if ByKey.leb x y then x :: merge xs (y :: ys) else y :: merge (x :: xs) ys by [].
rewrite -[map f (m :: ms)]/(f m :: map f ms) -[map f (n :: ns)]/(f n :: map f ns) !step /ByKey.leb !same_key.
by case: (no_later _ _); [rewrite -[f n :: _]/(map f (n :: ns)) IH | rewrite -[f m :: _]/(map f (m :: ms)) IHn].
Qed.

Lemma onto_stack_map stack ms :
  merge_list_to_stack (map (option_map (map f)) stack) (map f ms) = map (option_map (map f)) (merge_list_to_stack stack ms).
Proof. by elim: stack ms => [|[ns|] stack IH] ms //=; rewrite merge_map IH. Qed.

Lemma stack_map stack : merge_stack (map (option_map (map f)) stack) = map f (merge_stack stack).
Proof. by elim: stack => [|[ns|] stack IH] //=; rewrite IH // merge_map. Qed.

Lemma iter_map stack ms : iter_merge (map (option_map (map f)) stack) (map f ms) = map f (iter_merge stack ms).
Proof.
elim: ms stack => [|m ms IH] stack /=; first exact: stack_map.
by rewrite (onto_stack_map stack [m]) IH.
Qed.

Lemma sort_map ms : sort (map f ms) = map f (sort ms).
Proof. exact: (iter_map [] ms). Qed.
End Keyed.

Theorem by_keys_in_order ms : exists ns, by_keys (Members ms) = Members ns /\
  StronglySorted no_later (map fst ns) /\ Permutation (map (fun m => (fst m, by_keys (snd m))) ms) ns.
Proof.
exists (SortingMembers.sort (map (fun m => (fst m, by_keys (snd m))) ms)); split=> //; split; last exact: SortingMembers.Permuted_sort.
have := SortingMembers.StronglySorted_sort (map (fun m => (fst m, by_keys (snd m))) ms) (fun m n k => @no_later_trans (fst m) (fst n) (fst k)).
elim=> {ms} [|m ns _ IH all_]; constructor=> //.
by elim: all_ => [|n ns' mn _ IH']; constructor.
Qed.

(* ---- Lists and objects ---- *)

(* The loops of Canonical.v, by themselves *)
Fixpoint items_onto (done : text) (between : ascii) (vs : list json) : text :=
  match vs with v :: rest => items_onto (canonical_onto (between :: done) v) "," rest | [] => "]" :: done end.
Fixpoint texts (ms : list (text * json)) : list (text * json) :=
  match ms with (k, v) :: rest => (k, Text (canonical_onto (":" :: string_onto [] k) v)) :: texts rest | [] => [] end.
Fixpoint joined (done : text) (between : ascii) (ms : list (text * json)) : text :=
  match ms with (_, Text t) :: rest => joined (rev_append (rev_append t []) (between :: done)) "," rest | _ => "}" :: done end.

Lemma canonical_items done v vs : canonical_onto done (Items (v :: vs)) = items_onto done "[" (v :: vs).
Proof. by []. Qed.

Lemma canonical_members done ms : canonical_onto done (Members ms) =
  match SortingMembers.sort (texts ms) with [] => "}" :: "{" :: done | sorted => joined done "{" sorted end.
Proof. by []. Qed.

Definition text_of (m : text * json) : text * json := (fst m, Text (canonical_onto (":" :: string_onto [] (fst m)) (snd m))).

Lemma textsE ms : texts ms = map text_of ms.
Proof. by elim: ms => //= -[k v] ms ->. Qed.

Lemma element_alone s v : value s v -> element s v.
Proof. by move=> val; rewrite -[s]app_nil_r; apply: (@element_of [] s []). Qed.

Lemma items_first s v t vs : element s v -> items t vs -> items (s ++ "," :: t) (v :: vs).
Proof.
move=> el; elim=> {t vs} [t w elw|t vs u w _ IH elw]; first by apply: (@items_more s [v]) => //; exact: items_one.
by rewrite app_comm_cons app_assoc app_comm_cons; apply: items_more.
Qed.

Lemma members_first s k v t ms : member s k v -> members t ms -> members (s ++ "," :: t) ((k, v) :: ms).
Proof.
move=> mem; elim=> {t ms} [t l w meml|t ms u l w _ IH meml]; first by apply: (@members_more s [(k, v)]) => //; exact: members_one.
by rewrite app_comm_cons app_assoc app_comm_cons; apply: members_more.
Qed.

(* No line ends in a canonical text. *)
Definition in_line (s : text) : bool := forallb (fun c => ~~ (c =? "010")) s.

Lemma in_line_app s t : in_line (s ++ t) = in_line s && in_line t.
Proof. exact: forallb_app. Qed.

Lemma spelt_in_line s t : spells s t -> in_line s.
Proof.
have beyond c : beyond_ascii c -> ~~ (c =? "010") by bits c.
have hex c n : looked_up c hexadecimal = Some n -> ~~ (c =? "010") by bits c.
have four a b c d u : hex4 a b c d = Some u -> in_line [a; b; c; d].
  rewrite /hex4; case ea: (looked_up a _) => [?|] //; case eb: (looked_up b _) => [?|] //.
  case ec: (looked_up c _) => [?|] //; case ed: (looked_up d _) => [?|] // _.
  by rewrite /in_line /= (hex _ _ ea) (hex _ _ eb) (hex _ _ ec) (hex _ _ ed).
elim=> {s t} [//|c s t pl _ IH|a b s t two _ IH|a b c s t three _ IH|a b c d s t fourth _ IH|e c s t short _ IH
             |a b c d u s t h _ _ IH|a b c d high a' b' c' d' low s t h _ h' _ _ IH].
- by apply/andP; split=> //; move: pl; bits c.
- by have [a1 b1] := two_beyond two; rewrite /in_line /= !beyond.
- by have [a1 [b1 c1]] := three_beyond three; rewrite /in_line /= !beyond.
- by have [a1 [b1 [c1 d1]]] := four_beyond fourth; rewrite /in_line /= !beyond.
- by apply/andP; split=> //; apply/andP; split=> //; move: short; bits e.
- by rewrite -[_ :: _]/(["\"; "u"] ++ [a; b; c; d] ++ s) !in_line_app (four _ _ _ _ _ h) IH.
- by rewrite -[_ :: _]/(["\"; "u"] ++ [a; b; c; d] ++ ["\"; "u"] ++ [a'; b'; c'; d'] ++ s) !in_line_app (four _ _ _ _ _ h) (four _ _ _ _ _ h') IH.
Qed.

Lemma integer_in_line s n : integer s = Some n -> in_line s.
Proof.
move=> /integer_digits[_]; rewrite /in_line; elim: s => //= c s IH /andP[dc /IH ->].
by rewrite andbT; move: dc; bits c.
Qed.

Lemma quoted_in_line s t : spells s t -> in_line (quoted s).
Proof. by move=> /spelt_in_line inl; rewrite /quoted -[_ :: _]/([quote] ++ s ++ [quote]) !in_line_app inl. Qed.

Definition written_out (v : json) : Prop :=
  exists e, [/\ value e (by_keys v), in_line e & forall done, canonical_onto done v = rev e ++ done].

Lemma items_written vs : vs <> [] -> (forall v, In v vs -> written_out v) ->
  exists s, [/\ items s (map by_keys vs), in_line s & forall done between, items_onto done between vs = "]" :: rev s ++ between :: done].
Proof.
elim: vs => //= v [|u vs] IH _ all_.
  have [e [val inl text_]] := all_ v (or_introl erefl).
  by exists e; split=> // [|done between]; [exact/items_one/element_alone | rewrite /= text_].
have [e [val inl text_]] := all_ v (or_introl erefl).
have [//|s [its inls more]] := IH _ (fun w win => all_ w (or_intror win)).
exists (e ++ "," :: s); split=> [||done between]; first exact: items_first (element_alone val) its.
  by rewrite in_line_app inl.
rewrite -[LHS]/(items_onto (canonical_onto (between :: done) v) "," (u :: vs)) more text_; congr cons.
by rewrite rev_app_distr /= -!app_assoc.
Qed.

Definition keyed (m : text * json) : text * json := (fst m, by_keys (snd m)).

Lemma member_written m : whole (fst m) -> written_out (snd m) ->
  exists e, [/\ member e (fst m) (by_keys (snd m)), in_line e & text_of m = (fst m, Text (rev e))].
Proof.
case: m => k v /canonical_string[e sp text_] [e' [val inl text']].
exists (quoted e ++ ":" :: e'); split; first exact: (@member_of [] e [] k e' _ blanks_nil blanks_nil sp (element_alone val)).
  by rewrite in_line_app (quoted_in_line sp).
by rewrite /text_of [fst _]/= [snd _]/= text_ text' app_nil_r (rev_app_distr (quoted e)) [rev (":" :: e')]/= -app_assoc.
Qed.

Lemma members_written ms : ms <> [] -> (forall m, In m ms -> whole (fst m) /\ written_out (snd m)) ->
  exists s, [/\ members s (map keyed ms), in_line s
    & forall done between, joined done between (map text_of ms) = "}" :: rev s ++ between :: done].
Proof.
have step done between k t rest : joined done between ((k, Text t) :: rest) = joined (t ++ between :: done) "," rest.
  by rewrite [LHS]/= !rev_append_rev app_nil_r rev_involutive.
elim: ms => // m [|n ms] IH _ all_.
  have [wh wr] := all_ m (or_introl erefl); have [e [mem inl text_]] := member_written wh wr.
  by exists e; split=> // [|done between]; [exact: members_one | rewrite map_cons text_ step].
have [wh wr] := all_ m (or_introl erefl); have [e [mem inl text_]] := member_written wh wr.
have [//|s [mems inls more]] := IH _ (fun w win => all_ w (or_intror win)).
exists (e ++ "," :: s); split=> [||done between]; first exact: members_first mem mems.
  by rewrite in_line_app inl.
rewrite map_cons text_ step more; congr cons.
by rewrite rev_app_distr /= -!app_assoc.
Qed.

Lemma canonical_written v : proper v -> written_out v.
Proof.
have closed c s d : in_line [c] -> in_line [d] -> in_line s -> in_line (c :: s ++ [d]).
  by move=> c1 d1 inl; rewrite -[_ :: _]/([c] ++ s ++ [d]) !in_line_app c1 inl.
elim/json_induction: v => [|[]|n|t|vs IH|ms IH].
- by exists (of_string "null"); split=> //; exact: value_null.
- by exists (of_string "true"); split=> //; exact: value_true.
- by exists (of_string "false"); split=> //; exact: value_false.
- move=> range; have int := decimal_integer range; exists (decimal n); split=> [||done]; first exact: value_int.
    exact: integer_in_line int.
  by rewrite /= rev_append_rev.
- by move=> /canonical_string[e sp text_]; exists (quoted e); split=> //; [exact: value_text | exact: quoted_in_line sp].
- move=> all_; case: vs IH all_ => [|v vs] IH all_; first by exists ["["; "]"]; split=> //; exact: (@value_no_items [] blanks_nil).
  have [//|w win|s [its inl text_]] := @items_written (v :: vs); first by apply: IH => //; exact: folded all_ _ win.
  exists ("[" :: s ++ ["]"]); split=> [||done]; [exact: value_items | exact: closed |].
  by rewrite canonical_items text_ /= rev_app_distr /= -app_assoc.
move=> [differ all_].
have sorted_texts : SortingMembers.sort (texts ms) = map text_of (SortingMembers.sort ms) by rewrite textsE sort_map.
have sorted_values : by_keys (Members ms) = Members (map keyed (SortingMembers.sort ms)) by rewrite -sort_map.
have perm := SortingMembers.Permuted_sort ms.
rewrite /written_out sorted_values; case e0: (SortingMembers.sort ms) perm sorted_texts => [|m ns] perm sorted_texts.
  exists ["{"; "}"]; split=> // [|done]; first exact: (@value_no_members [] blanks_nil).
  by rewrite canonical_members sorted_texts.
have [//|w win|s [mems inl text_]] := @members_written (m :: ns).
  have win' : In w ms by apply: Permutation_in win; exact: Permutation_sym.
  by have [wh pr] := folded all_ win'; split=> //; apply: IH.
exists ("{" :: s ++ ["}"]); split=> [||done]; last first.
- rewrite canonical_members sorted_texts -[LHS]/(joined done "{" (map text_of (m :: ns))) text_.
  by rewrite /= rev_app_distr /= -app_assoc.
- exact: closed.
apply: value_members => //; have -> : map fst (map keyed (m :: ns)) = map fst (m :: ns) by rewrite map_map.
exact: (Permutation_NoDup (Permutation_map fst perm) differ).
Qed.

Lemma canonical_is v : proper v -> [/\ value (canonical v) (by_keys v), in_line (canonical v) & forall done, canonical_onto done v = rev (canonical v) ++ done].
Proof.
move=> /canonical_written[e [val inl text_]].
by have -> : canonical v = e by rewrite /canonical text_ app_nil_r rev_append_rev rev_involutive app_nil_r.
Qed.

(* The canonical text of a value is read as that value, with its members in order. *)
Theorem canonical_denotes v : proper v -> denotes (canonical v) (by_keys v).
Proof. by case/canonical_is => val _ _; exact: element_alone. Qed.

Corollary canonical_parsed v : proper v -> parse (canonical v) = Some (by_keys v).
Proof. by move=> /canonical_denotes/parse_complete. Qed.

(* What has the same canonical text is the same but for the order of members. *)
Corollary canonical_one v w : proper v -> proper w -> canonical v = canonical w -> by_keys v = by_keys w.
Proof. by move=> /canonical_parsed pv /canonical_parsed pw same_text; move: pv; rewrite same_text pw => -[]. Qed.

(* The text of a table is made of lines, each of which is the canonical text of a value. *)
Theorem table_text_lines vs : (forall v, In v vs -> proper v) -> table_text vs = flat_map (fun v => canonical v ++ ["010"]) vs.
Proof.
move=> all_; suff onto done : lines_onto done vs = rev (flat_map (fun v => canonical v ++ ["010"]) vs) ++ done.
  by rewrite /table_text onto app_nil_r rev_append_rev rev_involutive app_nil_r.
elim: vs all_ done => [//|v vs IH] all_ done; have [_ _ text_] := canonical_is (all_ v (or_introl erefl)).
rewrite [LHS]/= IH => [|w win]; last by apply: all_; right.
by rewrite text_ [flat_map _ (v :: vs)]/= !rev_app_distr -!app_assoc.
Qed.

Lemma first_line s t s' t' : in_line s -> in_line s' -> s ++ "010" :: t = s' ++ "010" :: t' -> s = s' /\ t = t'.
Proof.
elim: s s' => [|c s IH] [|d s'] //= inl inl'; first by case.
- by case=> e _; move: inl'; rewrite -e.
- by case=> e _; move: inl; rewrite e.
move: inl inl' => /andP[_ inl] /andP[_ inl'] [-> /(IH _ inl inl')[-> ->]] //.
Qed.

(* What has the same text is the same table, but for the order of members. *)
Theorem table_text_one vs ws : (forall v, In v vs -> proper v) -> (forall w, In w ws -> proper w) ->
  table_text vs = table_text ws -> map by_keys vs = map by_keys ws.
Proof.
move=> allv allw; rewrite !table_text_lines //.
elim: vs ws allv allw => [|v vs IH] [|w ws] allv allw //=; rewrite -?app_assoc; try by case: (canonical _).
have [pv pw] := (allv v (or_introl erefl), allw w (or_introl erefl)).
have [_ inlv _] := canonical_is pv; have [_ inlw _] := canonical_is pw.
move=> /(first_line inlv inlw)[same_text rest]; rewrite (canonical_one pv pw same_text); congr cons.
by apply: IH rest => [u uin|u uin]; [apply: allv; right | apply: allw; right].
Qed.

(* A value whose members are not in order meets what the theorems ask for. *)
Definition out_of_order : json := Members [(of_string "b", Int 12); (of_string "a", Items [Null; Text (of_string "x")])].

Lemma whole_ascii s : forallb (fun c => ~~ beyond_ascii c) s -> whole s.
Proof. by elim: s => [|c s IH] /=; [move=> _; exact: whole_nothing | case/andP => low /IH; exact: whole_byte]. Qed.

Lemma proper_out_of_order : proper out_of_order.
Proof.
split; first by constructor; [case | constructor; [case | constructor]].
by split; [split; [exact: whole_ascii | split] | split; [split; [exact: whole_ascii | split; [|split; [exact: whole_ascii|]]]|]].
Qed.

Lemma proper_in_order : proper (by_keys out_of_order).
Proof.
rewrite /=; split; first by constructor; [case | constructor; [case | constructor]].
by split; [split; [exact: whole_ascii | split; [|split; [exact: whole_ascii|]]] | split; [split; [exact: whole_ascii | split]|]].
Qed.

Example canonical_denotes_applies : denotes (of_string "{""a"":[null,""x""],""b"":12}") (by_keys out_of_order).
Proof. exact: (canonical_denotes proper_out_of_order). Qed.

Example canonical_parsed_applies : parse (of_string "{""a"":[null,""x""],""b"":12}") = Some (by_keys out_of_order).
Proof. exact: (canonical_parsed proper_out_of_order). Qed.

Example table_text_lines_applies : table_text [out_of_order] = of_string "{""a"":[null,""x""],""b"":12}" ++ ["010"].
Proof. by rewrite table_text_lines => [|v [<-|[]]] //; exact: proper_out_of_order. Qed.

Example table_text_one_applies : map by_keys [out_of_order] = map by_keys [by_keys out_of_order].
Proof. by apply: table_text_one => [v [<-|[]]|v [<-|[]]|] //; [exact: proper_out_of_order | exact: proper_in_order]. Qed.

Example canonical_one_applies : by_keys out_of_order = by_keys (by_keys out_of_order).
Proof. by apply: canonical_one; [exact: proper_out_of_order | exact: proper_in_order |]. Qed.
