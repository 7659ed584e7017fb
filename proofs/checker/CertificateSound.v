(* What it means that the checker calls a statement of a certificate true, and that it is so.

   The first part has to be read, with Document.v, PolicyDocument.v, DrawnText.v, BetsText.v, DriftText.v, TargetText.v and Certificate.v, which
   say what the parts of each statement are, Meaning.v, which says when a statement about a table holds, PolicyMeaning.v, which says it of a
   policy behind filters, DrawnMeaning.v, of a population, and VerdictsMeaning.v, of verdicts on it. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.analysis Require Import reals sequences exp.
From FairauditKernel Require Import Fractions FractionsSound.
From FairauditKernel Require WorstCase WorstCaseSound ClaimSound.
From FairauditChecker Require Import Json JsonSound Reading Table Statements Meaning Checker CheckerSound Nats NatsSound Document Drawn DrawnText Verdicts TargetText Certificate.
From FairauditChecker Require Import DriftNatsSound.
From FairauditChecker Require Chance DrawnMeaning DrawnSound VerdictsMeaning VerdictsSound.
From FairauditChecker Require Policy PolicyMeaning PolicyChecker PolicyCheckerSound PolicyShownSound.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Section Soundness.
Variable R : realType.
Variable sha256 : text -> text.

(* ==== What is true of a part of a statement (this part has to be read) ==== *)

Definition part_holds (c : certificate) (p : part) : Prop :=
  match p with
  | About s => holds R (about_table c) s
  | Worst_case about_local v _ =>
      if about_class c is Some (K, T) then
        [/\ about_local = WorstCase.local K, ClaimSound.somebody_compared T about_local & ClaimSound.claim_says R K T about_local v]
      else False
  | Log_is r low high => encloses_log low high (omap (@ratio R) r)
  | Log_at_most r limit b => b = in_nats_at_most (omap (@ratio R) r) limit
  | Stands_in_nats s limit => stands (about_table c) s (expR (@ratio R limit))
  | Of_policy s _ => if about_policy c is Some B then PolicyMeaning.policy_holds R B s else False
  | Allowed a => if about_policy c is Some B then PolicyMeaning.allows R B a else False
  | Unfiltered s => if without_filters c is Some T then holds R T s else False
  | Of_population local s =>
      if interval_in c local is Some i then
        [/\ about_interval i s, DrawnMeaning.population_holds R (about_table c) local (its_proof i)
          & if s is Its_frontier _ v ls then DrawnMeaning.hidden_needs R (about_table c) local (Drawn.least_of (its_proof i)) v ls else True]
      else False
  | Judged_by_ends local l j =>
      if interval_in c local is Some i then
        DrawnMeaning.population_holds R (about_table c) local (its_proof i) /\
        VerdictsMeaning.verdict_follows R l (Drawn.least_of (its_proof i)) (Drawn.most_of (its_proof i)) j
      else False
  | Hold_together on q =>
      VerdictsMeaning.together_at R (omap its_proof (local_interval c)) (omap its_proof (global_interval c)) on q
  | Of_means T s => holds R T s
  | Fact b => b
  | Uncovered => False
  end.

(* The bytes of a file denote a certificate, one of its statements has this name, its table and its policy are as the format
   demands, and the statement has parts, each of which is true. *)
Definition stated_and_true (file : text) (table_file : option text) (name : text) : Prop :=
  exists v c i,
    [/\ denotes file v, read_certificate sha256 v table_file = Good (Read c), well_formed c && valid (about_table c),
        In i (items c) /\ label i = name & parts i <> [::] /\ forall p, In p (parts i) -> part_holds c p].

(* ==== Proofs ==== *)

Lemma decided_true b : decided b = True_ -> b = Some true.
Proof. by case: b => [[]|]. Qed.

Lemma statement_true T s : valid T -> outcome_of (facts_of T) s = True_ -> holds R T s.
Proof.
move=> ok; rewrite /outcome_of; case true_: (is_true_of _ s); last by case: (under_drift _ s).
by move=> _; apply: statement_sound.
Qed.

Lemma drawn_true c local i : interval_in c local = Some i ->
  decided (if local then of_local (worked_out c) else of_global (worked_out c)) = True_ -> judged_by_draws (about_table c) local (its_proof i) = Some true.
Proof. by move=> found /decided_true; rewrite /worked_out /= /proved_by_draws; case: local found => ->. Qed.

Lemma judged_by_ends_true c local l j :
  outcome_of_part c (worked_out c) (Judged_by_ends local l j) = True_ -> part_holds c (Judged_by_ends local l j).
Proof.
rewrite /outcome_of_part /part_holds; case found: (interval_in c local) => [i|] //.
case proved_: (decided _) => // /decided_true judged_.
have drawn_ := drawn_true found proved_.
by split; [apply: DrawnSound.drawn_sound | apply: VerdictsSound.judged_by_interval_sound].
Qed.

Lemma hold_together_true c on q : outcome_of_part c (worked_out c) (Hold_together on q) = True_ -> part_holds c (Hold_together on q).
Proof. by rewrite /outcome_of_part /part_holds; case: ifP => // _ /decided_true[]; apply: VerdictsSound.hold_together_sound. Qed.

Lemma part_sound c p : well_formed c -> valid (about_table c) -> outcome_of_part c (worked_out c) p = True_ -> part_holds c p.
Proof.
move=> formed ok; case: p => [s|local v es|r low high|r limit b|s limit|s r|a|s|local s|local l j|on q|T s|b|].
- exact: statement_true.
- rewrite /=; case: (about_class c) => [[K T]|] //; case claimed: (WorstCase.claim_true K T local v es) => // _.
  exact: ClaimSound.claim_true_sound claimed.
- by rewrite /= => /decided_true; apply: enclosure_sound.
- rewrite /= => /decided_true; case log: (log_at_most r limit) => [b'|] //= [/Bool.eqb_prop ->].
  exact: log_at_most_sound log.
- rewrite /= /stands_in_nats => /decided_true.
  by apply: (stands_for_log_sound ok); have := figure_in_holds R ok (if is_local s then Local else Global); case: (is_local s).
- move: formed; rewrite /= /well_formed /about_policy; case: (its_subject c) => [//|B U] /andP[okB _] /decided_true.
  exact: PolicyCheckerSound.policy_claim_sound.
- move: formed; rewrite /= /well_formed /about_policy; case: (its_subject c) => [//|B U] /andP[okB _].
  by case fits: (PolicyShown.allowed B a) => // _; apply: PolicyShownSound.allowed_sound fits.
- move: formed; rewrite /= /well_formed /without_filters; case: (its_subject c) => [//|B [T|//]] /andP[_ okT] /=.
  exact: statement_true.
- rewrite /outcome_of_part /part_holds; case found: (interval_in c local) => [i|] //.
  case about: (about_interval i s) => // /(drawn_true found) drawn_.
  split=> //; first exact: DrawnSound.drawn_sound.
  by case: s about => // scope v ls /andP[_]; apply: DrawnSound.hidden_sound.
- exact: judged_by_ends_true.
- exact: hold_together_true.
- by rewrite /outcome_of_part /part_holds; case ok': (valid T) => // /(statement_true ok').
- by case: b.
- by [].
Qed.

Lemma both_true a b : both a b = True_ -> a = True_ /\ b = True_.
Proof. by case: a; case: b. Qed.

Lemma all_true (f : part -> outcome) ps o : fold_left (fun o p => both o (f p)) ps o = True_ -> o = True_ /\ forall p, In p ps -> f p = True_.
Proof.
elim: ps o => [|p ps IH] o //= /IH [/both_true [-> fp] rest]; split=> // q [<- //|]; exact: rest.
Qed.

Lemma item_true c D i name : outcome_of_item c D i = (name, True_) ->
  [/\ label i = name, parts i <> [::] & forall p, In p (parts i) -> outcome_of_part c D p = True_].
Proof.
rewrite /outcome_of_item; case: (parts i) => [|p ps] [-> // true_]; split=> //.
exact: (proj2 (@all_true (outcome_of_part c D) (p :: ps) True_ true_)).
Qed.

Theorem verified_sound file table_file os name :
  verified sha256 file table_file = Outcomes os -> In (name, True_) os -> stated_and_true file table_file name.
Proof.
rewrite /verified /parsed; case read_: (parse file) => [v|] //=.
case stated_: (read_certificate sha256 v table_file) => [[c|its|]|] //=.
  case formed: (well_formed c) => //=; case ok: (valid (about_table c)) => //=; case: ifP => // _ [<-].
  move=> /in_map_iff [i [/item_true[nameE some every] there]]; exists v, c, i; split=> //; first exact: parse_sound.
    by rewrite formed ok.
  by split=> // p /every true_; apply: part_sound.
by case=> <- /in_map_iff [i [? _]].
Qed.
End Soundness.
