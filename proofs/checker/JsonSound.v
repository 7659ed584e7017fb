(* The reader of JSON.v is right: [parse s] is [Some v] exactly if the bytes s denote v.
   So they denote one value at most. *)

From Coq Require Import ZArith List Ascii Bool Orders Mergesort Permutation Sorted RelationClasses Lia.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditChecker Require Import Json JsonStrings.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.
Local Open Scope char_scope.


(* ==== Keys that differ ==== *)

Lemma sameP (s t : text) : reflect (s = t) (same s t).
Proof.
apply: (iffP idP) => [|<-].
  by elim: s t => [|c s IH] [|d t] //= /andP [/eqcP -> /IH ->].
by elim: s => //= c s ->; rewrite Ascii.eqb_refl.
Qed.

Lemma compare_trans (a b c : ascii) : Ascii.compare a b = Lt -> Ascii.compare b c = Lt -> Ascii.compare a c = Lt.
Proof. rewrite /Ascii.compare !N.compare_lt_iff; exact: N.lt_trans. Qed.

Lemma compare_refl a : Ascii.compare a a = Eq.
Proof. exact: N.compare_refl. Qed.

Lemma no_later_trans : Transitive no_later.
Proof.
move=> s t; elim: t s => [|d t IH] [|c s] [|e u] //=.
case cd: (Ascii.compare c d) => //; case de: (Ascii.compare d e) => //.
- rewrite -(Ascii.compare_eq_iff _ _ cd) in de; rewrite de; exact: IH.
- by rewrite (Ascii.compare_eq_iff _ _ cd) de.
- by rewrite -(Ascii.compare_eq_iff _ _ de) cd.
- by rewrite (compare_trans cd de).
Qed.

Lemma no_later_antisym s t : no_later s t -> no_later t s -> s = t.
Proof.
elim: s t => [|c s IH] [|d t] //=; rewrite (Ascii.compare_antisym d c).
case cd: (Ascii.compare c d) => //= st ts.
by rewrite (Ascii.compare_eq_iff _ _ cd) (IH _ st ts).
Qed.

Lemma sorted_differ ts : StronglySorted no_later ts -> neighbours_differ ts -> NoDup ts.
Proof.
elim=> {ts} [|s rest sorted IH least] differ; constructor; last first.
  by apply: IH; case: rest differ {sorted least} => //= t rest /andP [].
case: rest differ sorted IH least => [|t rest]; first by move=> _ _ _ _ [].
move=> /= /andP [/sameP st _] sorted _ least [ts|later]; first exact: st.
have := Forall_inv least; have /Forall_forall := Forall_inv_tail least; move=> /(_ _ later) _ le; apply: st.
apply: (no_later_antisym le); inversion sorted as [|? ? _ all]; exact: (proj1 (Forall_forall _ _) all).
Qed.

Lemma distinctP (ts : list text) : reflect (NoDup ts) (distinct ts).
Proof.
have perm := Sorting.Permuted_sort ts; apply: (iffP idP) => [differ|nodup].
  apply: (Permutation_NoDup (Permutation_sym perm)); apply: sorted_differ differ.
  apply: Sorting.StronglySorted_sort => s t u; exact: no_later_trans.
rewrite /distinct; have := Permutation_NoDup perm nodup.
elim: {perm ts nodup}(Sorting.sort ts) => [|s [|t rest] IH] // nd.
have [out nd'] : ~ In s (t :: rest) /\ NoDup (t :: rest) by inversion nd.
by apply/andP; split; [apply/sameP => st; apply: out; left | exact: IH].
Qed.

(* ==== Values ==== *)

Lemma blanks_nil : blanks []. Proof. by []. Qed.

Lemma blanks_more w c : blanks w -> blank c -> blanks (w ++ [c]).
Proof. by rewrite /blanks forallb_app => -> /= ->. Qed.

(* What stands before the next member of a list *)
Definition so_far (T : Type) (joined : text -> list T -> Prop) (before : list T) (s : text) : Prop :=
  (before = [] /\ s = []) \/ exists2 s0, s = s0 ++ [","] & joined s0 (rev before).

(* What the bytes up to here are, where a value may begin *)
Fixpoint opened (stack : list inside) (p : text) : Prop :=
  match stack with
  | [] => p = []
  | InItems vs :: outer => exists q w s, opened outer q /\ blanks w /\ so_far items vs s /\ p = q ++ w ++ "[" :: s
  | InMembers ms k :: outer => exists q w s w1 t w2,
      opened outer q /\ blanks w /\ so_far members ms s /\ blanks w1 /\ blanks w2 /\ spells t k
      /\ p = q ++ w ++ "{" :: s ++ w1 ++ quoted t ++ w2 ++ [":"]
  end.

(* What the bytes up to here are *)
Definition read_up_to (m : mode) (stack : list inside) (p : text) : Prop :=
  match m with
  | Awaiting _ => exists q w, opened stack q /\ blanks w /\ p = q ++ w
  | Naming ms may_end => exists q w s w1,
      opened stack q /\ blanks w /\ so_far members ms s /\ blanks w1 /\ (may_end -> ms = []) /\ p = q ++ w ++ "{" :: s ++ w1
  | Named ms k => exists q w s w1 t w2,
      opened stack q /\ blanks w /\ so_far members ms s /\ blanks w1 /\ spells t k /\ blanks w2
      /\ p = q ++ w ++ "{" :: s ++ w1 ++ quoted t ++ w2
  | Spelling None _ raw => exists q w, opened stack q /\ blanks w /\ p = q ++ w ++ quote :: rev raw
  | Spelling (Some ms) _ raw => exists q w s w1,
      opened stack q /\ blanks w /\ so_far members ms s /\ blanks w1 /\ p = q ++ w ++ "{" :: s ++ w1 ++ quote :: rev raw
  | Counting ds => exists q w, opened stack q /\ blanks w /\ p = q ++ w ++ rev ds
  | Word rest v => exists q w s, opened stack q /\ blanks w /\ value (s ++ rest) v /\ p = q ++ w ++ s
  | Ended v => exists q w s w', opened stack q /\ blanks w /\ blanks w' /\ value s v /\ p = q ++ w ++ s ++ w'
  end.

Lemma items_not_none s vs : items s vs -> vs <> [].
Proof. by case=> {s vs} [? ? _|? [|? ?]]. Qed.

Lemma members_not_none s ms : members s ms -> ms <> [].
Proof. by case=> {s ms} [? ? ? _|? [|? ?]]. Qed.

Lemma joined_item vs s t v : so_far items vs s -> element t v -> items (s ++ t) (rev (v :: vs)).
Proof.
case=> [[-> ->] el|[s0 -> it] el]; first exact: items_one.
have -> : (s0 ++ [","]) ++ t = s0 ++ "," :: t by flat.
exact: items_more.
Qed.

Lemma joined_member ms s t k v : so_far members ms s -> member t k v -> members (s ++ t) (rev ((k, v) :: ms)).
Proof.
case=> [[-> ->] el|[s0 -> it] el]; first exact: members_one.
have -> : (s0 ++ [","]) ++ t = s0 ++ "," :: t by flat.
exact: members_more.
Qed.

Lemma after_read c v stack p m stack' :
  read_up_to (Ended v) stack p -> after c v stack = Some (m, stack') -> read_up_to m stack' (p ++ [c]).
Proof.
case=> q [w [s [w' [op [bw [bw' [va ->]]]]]]]; rewrite /after; case: ifP => [bl [<- <-]|_].
  by exists q, w, s, (w' ++ [c]); split; [|split; [|split; [exact: blanks_more|split; [|flat]]]].
have el : element (w ++ s ++ w') v by exact: element_of.
case: stack op => [|[vs|ms k] outer] //=.
  case=> q0 [w0 [s0 [op0 [bw0 [far ->]]]]]; have it := joined_item far el.
  case: ifP => [/eqcP -> [<- <-]|_].
    exists (q0 ++ w0 ++ "[" :: (s0 ++ w ++ s ++ w') ++ [","]), []; split; last by split; last flat.
    by exists q0, w0, ((s0 ++ w ++ s ++ w') ++ [","]); split=> //; split=> //; split=> //; right; eexists.
  case: ifP => [/eqcP -> [<- <-]|//].
  exists q0, w0, ("[" :: (s0 ++ w ++ s ++ w') ++ ["]"]), []; rewrite rev_appendE; do 3 (split=> //); split; last by flat.
  exact: value_items.
case=> q0 [w0 [s0 [w1 [t [w2 [op0 [bw0 [far [bw1 [bw2 [sp ->]]]]]]]]]]].
have it := joined_member far (member_of bw1 bw2 sp el).
case: ifP => [/eqcP -> [<- <-]|_].
  eexists q0, w0, (_ ++ [","]), []; split; first by []; split; first by []; split; first by right; eexists; last exact: it.
  by do 2 split=> //; flat.
case: ifP => [/eqcP ->|//]; case: ifP => [/distinctP nodup [<- <-]|//]; rewrite rev_appendE in nodup *.
by eexists q0, w0, ("{" :: _ ++ ["}"]), []; do 3 (split=> //); split; [exact: value_members it nodup | flat].
Qed.

Lemma begun_read c may_end stack p m stack' :
  read_up_to (Awaiting may_end) stack p -> begun c may_end stack = Some (m, stack') -> read_up_to m stack' (p ++ [c]).
Proof.
case=> q [w [op [bw ->]]]; rewrite /begun; case: ifP => [bl [<- <-]|_].
  by exists q, (w ++ [c]); split=> //; split; [exact: blanks_more | flat].
case: ifP => [/eqcP -> [<- <-]|_]; first by exists q, w; do 2 split=> //; flat.
case: ifP => [_ [<- <-]|_]; first by exists q, w; do 2 split=> //; flat.
case: ifP => [/eqcP -> [<- <-]|_].
  by exists (q ++ w ++ ["["]), []; split; [exists q, w, []; do 2 split=> //; split; [left|] | split=> //; flat].
case: ifP => [/eqcP -> [<- <-]|_].
  by exists q, w, [], []; do 2 split=> //; split; [left | do 2 split=> //; flat].
case: ifP => [/eqcP -> [<- <-]|_]; first by exists q, w, ["n"]; do 2 split=> //; split; [exact: value_null | flat].
case: ifP => [/eqcP -> [<- <-]|_]; first by exists q, w, ["t"]; do 2 split=> //; split; [exact: value_true | flat].
case: ifP => [/eqcP -> [<- <-]|_]; first by exists q, w, ["f"]; do 2 split=> //; split; [exact: value_false | flat].
case: ifP => [/andP [/eqcP -> _]|//]; case: stack op => [|[[|v vs]|ms k] outer] //= [q0 [w0 [s0 [op0 [bw0 [far ->]]]]]] [<- <-].
case: far => [[_ ->]|[s1 _ /items_not_none]] //.
by exists q0, w0, ("[" :: w ++ ["]"]), []; do 3 (split=> //); split; [exact: value_no_items | flat].
Qed.

Lemma step_read c m stack p m' stack' : read_up_to m stack p -> step c m stack = Some (m', stack') -> read_up_to m' stack' (p ++ [c]).
Proof.
case: m => [e|ms e|ms k|to esc raw|ds|rest v|v] /=.
- exact: begun_read.
- case=> q [w [s [w1 [op [bw [far [bw1 [none ->]]]]]]]]; case: ifP => [bl [<- <-]|_].
    by exists q, w, s, (w1 ++ [c]); do 3 (split=> //); split; [exact: blanks_more | split=> //; flat].
  case: ifP => [/eqcP -> [<- <-]|_]; first by exists q, w, s, w1; do 4 (split=> //); flat.
  case: ifP => [/andP [/eqcP -> /none ms0] [<- <-]|//].
  case: far => [[_ ->]|[s1 _ joined]]; last by move: joined; rewrite ms0 => /members_not_none.
  by exists q, w, ("{" :: w1 ++ ["}"]), []; do 3 (split=> //); split; [exact: value_no_members | flat].
- case=> q [w [s [w1 [t [w2 [op [bw [far [bw1 [sp [bw2 ->]]]]]]]]]]]; case: ifP => [bl [<- <-]|_].
    by exists q, w, s, w1, t, (w2 ++ [c]); do 5 (split=> //); split; [exact: blanks_more | flat].
  case: ifP => [/eqcP -> [<- <-]|//].
  exists (q ++ w ++ "{" :: s ++ w1 ++ quoted t ++ w2 ++ [":"]), []; split; last by split=> //; flat.
  by exists q, w, s, w1, t, w2.
- case: esc => [rd [<- <-]|].
    by case: to rd => [ms|] /=; [case=> q [w [s [w1 [? [? [? [? ->]]]]]]]; exists q, w, s, w1; do 4 (split=> //) |
      case=> q [w [? [? ->]]]; exists q, w; do 2 (split=> //)]; flat.
  case: ifP => [/eqcP ->|_ rd [<- <-]]; last first.
    by case: to rd => [ms|] /=; [case=> q [w [s [w1 [? [? [? [? ->]]]]]]]; exists q, w, s, w1; do 4 (split=> //) |
      case=> q [w [? [? ->]]]; exists q, w; do 2 (split=> //)]; flat.
  case dec: (decoded [] (rev_append raw [])) => [t|] //; move/decoded_sound: dec; rewrite rev_appendE app_nil_r => sp.
  case: to => [ms|] rd [<- <-]; [move: rd => [q [w [s [w1 [? [? [? [? ->]]]]]]]] | move: rd => [q [w [? [? ->]]]]].
    by exists q, w, s, w1, (rev raw), []; do 6 (split=> //); rewrite /quoted; flat.
  by exists q, w, (quoted (rev raw)), []; do 3 (split=> //); split; [exact: value_text | rewrite /quoted; flat].
- case=> q [w [op [bw ->]]]; case: ifP => [_ [<- <-]|_]; first by exists q, w; do 2 split=> //; flat.
  case int: (integer _) => [n|] //; apply: after_read; rewrite rev_appendE app_nil_r in int.
  by exists q, w, (rev ds), []; do 3 (split=> //); split; [exact: value_int | flat].
- case=> q [w [s [op [bw [va ->]]]]]; case: rest va => [|d rest] // va; case: ifP => [/eqcP -> [<- <-]|//].
  case: rest va => [|d' rest] va; first by exists q, w, (s ++ [d]), []; do 3 (split=> //); split; [|flat].
  exists q, w, (s ++ [d]); do 2 (split=> //); split; last by flat.
  by have -> : (s ++ [d]) ++ d' :: rest = s ++ d :: d' :: rest by flat.
- exact: after_read.
Qed.

Lemma run_sound s : forall m stack p v, read_up_to m stack p -> run m stack s = Some v -> denotes (p ++ s) v.
Proof.
elim: s => [|c s IH] m stack p v rd /=; last first.
  case st: (step c m stack) => [[m' stack']|] // /(IH _ _ (p ++ [c])); rewrite -app_assoc; apply.
  exact: step_read st.
rewrite app_nil_r; case: m stack rd => [e|ms e|ms k|to esc raw|ds|rest u|u] [|frame stack] //=.
  case=> q [w [-> [bw ->]]]; rewrite rev_appendE app_nil_r; case int: integer => [n|] //= [<-].
  by have := element_of bw blanks_nil (value_int int); rewrite app_nil_r.

by case=> q [w [s [w' [-> [bw [bw' [va ->]]]]]]] [<-]; exact: (element_of bw bw' va).
Qed.

Theorem parse_sound s v : parse s = Some v -> denotes s v.
Proof. by apply: (@run_sound s _ _ []); exists [], []. Qed.

(* ==== All that bytes denote is read ==== *)

(* What ends an integer *)
Definition stops (r : text) : Prop := match r with c :: _ => is_digit c = false | [] => True end.

Lemma blank_stops w r : blanks w -> stops r -> stops (w ++ r).
Proof. by case: w => [//|c w] /andP [bl _] _; move: bl; rewrite /=; bits c. Qed.

Lemma run_blanks w : blanks w -> forall m stack r,
  (forall c, blank c -> step c m stack = Some (m, stack)) -> run m stack (w ++ r) = run m stack r.
Proof. by elim: w => [//|c w IH] /= /andP [bl bw] m stack r skip; rewrite skip // IH. Qed.

Lemma blank_after w v stack r : blanks w -> run (Ended v) stack (w ++ r) = run (Ended v) stack r.
Proof. by move=> bw; apply: run_blanks => // c bl; rewrite /= /after bl. Qed.

Lemma blank_before w e stack r : blanks w -> run (Awaiting e) stack (w ++ r) = run (Awaiting e) stack r.
Proof. by move=> bw; apply: run_blanks => // c bl; rewrite /= /begun bl. Qed.

Lemma blank_named w ms k stack r : blanks w -> run (Named ms k) stack (w ++ r) = run (Named ms k) stack r.
Proof. by move=> bw; apply: run_blanks => // c bl; rewrite /= bl. Qed.

Lemma blank_naming w ms e stack r : blanks w -> run (Naming ms e) stack (w ++ r) = run (Naming ms e) stack r.
Proof. by move=> bw; apply: run_blanks => // c bl; rewrite /= bl. Qed.

(* ---- Strings ---- *)

Definition inner (c : ascii) : bool := negb (c =? quote) && negb (c =? "\").

Lemma plain_inner c : plain c -> inner c. Proof. by bits c. Qed.
Lemma beyond_inner c : beyond_ascii c -> inner c. Proof. by bits c. Qed.
Lemma hexadecimal_inner c n : looked_up c hexadecimal = Some n -> inner c. Proof. by bits c. Qed.

Lemma hex4_inner a b c d u : hex4 a b c d = Some u -> [/\ inner a, inner b, inner c & inner d].
Proof.
rewrite /hex4; case ea: (looked_up a hexadecimal) => [?|] //; case eb: (looked_up b hexadecimal) => [?|] //.
by case ec: (looked_up c hexadecimal) => [?|] //; case ed: (looked_up d hexadecimal) => [?|] // _; split;
  apply: hexadecimal_inner; eassumption.
Qed.

Lemma run_inner to raw stack r c : inner c -> run (Spelling to false raw) stack (c :: r) = run (Spelling to false (c :: raw)) stack r.
Proof. by case/andP => /negbTE q /negbTE b /=; rewrite q b. Qed.

Lemma run_escape to raw stack e r :
  run (Spelling to false raw) stack ("\" :: e :: r) = run (Spelling to false (e :: "\" :: raw)) stack r.
Proof. by []. Qed.

Lemma run_spelled s t : spells s t -> forall to raw stack r,
  run (Spelling to false raw) stack (s ++ r) = run (Spelling to false (rev s ++ raw)) stack r.
Proof.
elim=> {s t} [|c s t pl _ IH|a b s t two _ IH|a b c s t three _ IH|a b c d s t four _ IH|e c s t short _ IH
             |a b c d u s t h single _ IH|a b c d high a' b' c' d' low s t h hi h' lo _ IH] to raw stack r.
- by [].
- by rewrite -app_comm_cons run_inner ?plain_inner // IH; congr run; congr Spelling; flat.
- have [/beyond_inner ia /beyond_inner ib] := two_beyond two.
  by rewrite [_ ++ r]/= !run_inner // IH; congr run; congr Spelling; flat.
- have [/beyond_inner ia [/beyond_inner ib /beyond_inner ic]] := three_beyond three.
  by rewrite [_ ++ r]/= !run_inner // IH; congr run; congr Spelling; flat.
- have [/beyond_inner ia [/beyond_inner ib [/beyond_inner ic /beyond_inner id]]] := four_beyond four.
  by rewrite [_ ++ r]/= !run_inner // IH; congr run; congr Spelling; flat.
- by rewrite [_ ++ r]/= run_escape IH; congr run; congr Spelling; flat.
- have [ia ib ic id] := hex4_inner h.
  by rewrite [_ ++ r]/= run_escape !run_inner // IH; congr run; congr Spelling; flat.
- have [ia ib ic id] := hex4_inner h; have [ia' ib' ic' id'] := hex4_inner h'.
  rewrite [_ ++ r]/= run_escape (run_inner _ _ _ _ ia) (run_inner _ _ _ _ ib) (run_inner _ _ _ _ ic) (run_inner _ _ _ _ id) run_escape.
  by rewrite !run_inner // IH; congr run; congr Spelling; flat.
Qed.

Lemma run_quoted s t to stack r : spells s t ->
  run (Spelling to false []) stack (s ++ quote :: r)
  = match to with None => run (Ended (Text t)) stack r | Some ms => run (Named ms t) stack r end.
Proof.
move=> sp; rewrite (run_spelled sp) app_nil_r /= rev_appendE rev_involutive app_nil_r (decoded_complete sp).
by case: to.
Qed.

(* ---- Integers ---- *)

Lemma written_digits s n m : written n s = Some m -> forallb is_digit s.
Proof. by elim: s n => //= c s IH n; rewrite /is_digit; case: (digit c) => // d /IH ->. Qed.

Lemma integer_digits s n : integer s = Some n -> s <> [] /\ forallb is_digit s.
Proof.
rewrite /integer; case: (at_most 18 s) => //; case: s => [//|c [|d s]]; rewrite /natural.
  by move/written_digits.
by case: (c =? "0") => // /written_digits.
Qed.

Lemma run_digits s ds stack r : forallb is_digit s -> run (Counting ds) stack (s ++ r) = run (Counting (rev s ++ ds)) stack r.
Proof.
elim: s ds => //= c s IH ds /andP [dc dg]; rewrite dc IH //; congr run; congr Counting; flat.
Qed.

Lemma begun_digit c may_end stack : is_digit c -> begun c may_end stack = Some (Counting [c], stack).
Proof. by bits c. Qed.

Lemma run_integer s n e stack r : integer s = Some n -> stops r -> run (Awaiting e) stack (s ++ r) = run (Ended (Int n)) stack r.
Proof.
move=> int; have [] := integer_digits int; case: s int => [//|c s] int _ /= /andP [dc dg] stop.
rewrite begun_digit // run_digits //.
have back : rev_append (rev s ++ [c]) [] = c :: s by rewrite rev_appendE rev_app_distr rev_involutive app_nil_r.
case: r stop => [|d r] /= stop; last by rewrite stop back int.
by rewrite back int; case: stack.
Qed.

(* ---- Values ---- *)

Scheme value_ind' := Induction for value Sort Prop
  with element_ind' := Induction for element Sort Prop
  with items_ind' := Induction for items Sort Prop
  with member_ind' := Induction for member Sort Prop
  with members_ind' := Induction for members Sort Prop.
Combined Scheme denoted_ind from value_ind', element_ind', items_ind', member_ind', members_ind'.

Definition passes (s : text) (v : json) : Prop :=
  forall e stack r, stops r -> run (Awaiting e) stack (s ++ r) = run (Ended v) stack r.

Lemma denoted_is_read :
  (forall s v, value s v -> passes s v)
  /\ (forall s v, element s v -> passes s v)
  /\ (forall s vs, items s vs -> exists vs0 v, vs = vs0 ++ [v] /\ forall e stack r, stops r ->
        run (Awaiting e) (InItems [] :: stack) (s ++ r) = run (Ended v) (InItems (rev vs0) :: stack) r)
  /\ (forall s k v, member s k v -> forall ms e stack r, stops r ->
        run (Naming ms e) stack (s ++ r) = run (Ended v) (InMembers ms k :: stack) r)
  /\ (forall s ms, members s ms -> exists ms0 k v, ms = ms0 ++ [(k, v)] /\ forall e stack r, stops r ->
        run (Naming [] e) stack (s ++ r) = run (Ended v) (InMembers (rev ms0) k :: stack) r).
Proof.
apply: (denoted_ind (P := fun s v _ => passes s v) (P0 := fun s v _ => passes s v)) => //.
- by move=> s n int e stack r; exact: run_integer.
- by move=> s t sp e stack r _; rewrite /quoted -app_comm_cons -app_assoc /= (run_quoted None stack r sp).
- by move=> w bw e stack r _; rewrite -app_comm_cons -app_assoc [LHS]/= blank_before.
- move=> s vs _ [vs0 [v [-> it]]] e stack r _; rewrite -app_comm_cons -app_assoc [LHS]/= it //=.
  by rewrite rev_appendE rev_involutive.
- by move=> w bw e stack r _; rewrite -app_comm_cons -app_assoc [LHS]/= blank_naming.
- move=> s ms _ [ms0 [k [v [-> it]]]] nodup e stack r _; rewrite -app_comm_cons -app_assoc [LHS]/= it //=.
  rewrite /after [distinct]lock /= -lock rev_appendE rev_involutive; by move/distinctP: nodup => ->.
- move=> w s w' v bw bw' _ IH e stack r stop; rewrite -!app_assoc blank_before // IH ?blank_after //.
  exact: blank_stops.
- by move=> s v _ IH; exists [], v; split=> // e stack r stop; exact: IH.
- move=> s vs t v _ [vs0 [v0 [-> it]]] _ IH; exists (vs0 ++ [v0]), v; split=> // e stack r stop.
  by rewrite -app_assoc it //= IH // rev_app_distr.
- move=> w s w' k t v bw bw' sp _ IH ms e stack r stop; rewrite -app_assoc blank_naming //.
  rewrite /quoted -app_assoc -app_comm_cons -app_assoc [LHS]/= (run_quoted _ _ _ sp) -app_assoc blank_named //=.
  exact: IH.
- by move=> s k v _ IH; exists [], k, v; split=> // e stack r stop; exact: IH.
- move=> s ms t k v _ [ms0 [k0 [v0 [-> it]]]] _ IH; exists (ms0 ++ [(k0, v0)]), k, v; split=> // e stack r stop.
  by rewrite -app_assoc it //= IH // rev_app_distr.
Qed.

Theorem parse_complete s v : denotes s v -> parse s = Some v.
Proof.
by move/(proj1 (proj2 denoted_is_read)) => /(_ false [] []); rewrite app_nil_r /parse => ->.
Qed.

(* Bytes denote one value at most. *)
Theorem denotes_one s v w : denotes s v -> denotes s w -> v = w.
Proof. by move=> /parse_complete sv /parse_complete; rewrite sv => -[]. Qed.
