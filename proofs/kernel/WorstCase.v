(* What a claim by lp-dual about the worst utility of a class says, and a program that checks it.

   This file only computes; WorstCaseSound.v proves it right.  It follows the page
   docs/certificate-worst-case.md: the same variables, boxes and constraints, in the same
   order.  Contexts, groups and decisions are the numbers of the header's lists.  A
   fraction is kept in lowest terms; the linear program itself is one of integers. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions LinearProgram.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* ---- The table and the class, as a certificate states them ---- *)

Record outcome := Outcome {
  decision : Z;
  weight : Q;            (* of the decision in its cell: a count or a probability *)
  features : list Q;     (* phi_1, ..., phi_K; none without a family *)
  stated : Q             (* the utility that the table gives, 0 where it gives none *)
}.

Record cell := Cell {
  context : Z;
  group : Z;
  outcomes : list outcome;
  weight_of_cell : Q     (* the mass, where masses are given *)
}.

(* The mass of a cell is the sum of its counts, or is given, or is 1. *)
Inductive masses := Counted | Given | Alike.

Record table := Table { contexts : list Z; groups : list Z; population : masses; cells : list cell }.

Record term := Term { of_context : Z; of_group : Z (* not read when the class is blind *); of_decision : Z; coefficient : Q }.

Record family := Family {
  lower : list Q;
  upper : list Q;
  family_rows : list (list Q * Q) (* sum_k coefficient_k theta_k <= bound *)
}.

Record utilities := Utilities {
  local : bool;                     (* the local ratio; else the global one *)
  gamma : Q;
  least : Q;
  tau : option Q;
  on_pair : bool;                   (* the floor is kept by the two groups compared; else by all groups compared *)
  blind : bool;
  lipschitz : option Q;
  metric : option (list (list Q));  (* the 0/1 metric if there is none *)
  order : list (Z * Z);             (* g of the first is at most g of the second *)
  rows : list (list term * Q);      (* sum of coefficient * g <= bound *)
  parameters : option family
}.

(* ---- Affine forms in the variables ---- *)

(* g(u,x,a), or g(u,x) as (x, _, u); the k-th parameter is (k, 0, 0) *)
Definition var : Type := Z * Z * Z.

Definition same (i j : var) : bool :=
  let '(a, b, c) := i in let '(d, e, f) := j in (a =? d) && (b =? e) && (c =? f).

Definition before (i j : var) : bool :=
  let '(a, b, c) := i in
  let '(d, e, f) := j in
  (a <? d) || ((a =? d) && ((b <? e) || ((b =? e) && (c <=? f)))).

Record form := Form { linear : list (var * Q); free : Q }.

Definition fixed (q : Q) : form := Form [] q.
Definition added (f h : form) : form := Form (linear f ++ linear h) (plus (free f) (free h)).
Definition multiplied (q : Q) (f : form) : form := Form (map (fun t => (t.1, times q t.2)) (linear f)) (times q (free f)).
Definition difference (f h : form) : form := added f (multiplied (minus one) h).
Definition sum_of_forms (fs : list form) : form := fold_right added (fixed zero) fs.

Fixpoint numbered {T : Type} (n : Z) (xs : list T) : list (Z * T) :=
  match xs with x :: rest => (n, x) :: numbered (n + 1) rest | [] => [] end.

Fixpoint entry {T : Type} (default : T) (xs : list T) (n : Z) : T :=
  match xs with
  | x :: rest => if n =? 0 then x else entry default rest (n - 1)
  | [] => default
  end.

Section Class.
Variables (K : utilities) (T : table).

(* sum_k phi_k theta_k *)
Definition in_parameters (phi : list Q) : form := Form (map (fun t => ((t.1, 0, 0), t.2)) (numbered 0 phi)) zero.

(* g at an outcome of a cell *)
Definition value (c : cell) (o : outcome) : form :=
  match parameters K with
  | Some _ => in_parameters (features o)
  | None => Form [((context c, (if blind K then -1 else group c), decision o), one)] zero
  end.

Definition weight_sum (c : cell) : Q := total (map weight (outcomes c)).

Definition mass (c : cell) : Q :=
  match population T with Counted => weight_sum c | Given => weight_of_cell c | Alike => one end.

(* E(x,a), and the mean of E(.,a) *)
Definition expectation_form (c : cell) : form :=
  multiplied (inverse (weight_sum c)) (sum_of_forms (map (fun o => multiplied (weight o) (value c o)) (outcomes c))).

Definition of_that_group (a : Z) : list cell := filter (fun c => group c =? a) (cells T).
Definition mass_of_group (a : Z) : Q := total (map mass (of_that_group a)).

Definition mean_form (a : Z) : form :=
  multiplied (inverse (mass_of_group a)) (sum_of_forms (map (fun c => multiplied (mass c) (expectation_form c)) (of_that_group a))).

(* ---- Constraints, each as its slack, a form that is at least 0 on the class ---- *)

Definition vacuous : form := fixed zero.

Definition outcome_for (c : cell) (u : Z) : option outcome := find (fun o => decision o =? u) (outcomes c).

Definition value_for (c : cell) (u : Z) : option form := option_map (value c) (outcome_for c u).

(* g(first) <= g(second) in a cell *)
Definition order_row (c : cell) (pair : Z * Z) : form :=
  match value_for c pair.1, value_for c pair.2 with
  | Some f, Some h => difference h f
  | _, _ => vacuous
  end.

(* One cell for each place where g can be chosen anew: all of them, or one for each context. *)
Fixpoint first_of_contexts (cs : list cell) (seen : list Z) : list cell :=
  match cs with
  | c :: rest =>
      if existsb (Z.eqb (context c)) seen then first_of_contexts rest seen
      else c :: first_of_contexts rest [context c]
  | [] => []
  end.

Definition concerned (x : option Z) : list cell :=
  match x with Some x => filter (fun c => context c =? x) (cells T) | None => cells T end.

Definition places (x : option Z) : list cell :=
  let cs := concerned x in if blind K then first_of_contexts cs [] else cs.

Definition distance (a b : Z) : Q := match metric K with Some d => entry zero (entry [] d a) b | None => one end.

Definition lipschitz_rows (L : Q) (x : option Z) : list form :=
  let cs := concerned x in
  flat_map
    (fun c =>
       flat_map
         (fun d =>
            if (context c =? context d) && negb (group c =? group d) then
              map
                (fun o =>
                   match value_for d (decision o) with
                   | Some h => difference (added (fixed (times L (distance (group c) (group d)))) h) (value c o)
                   | None => vacuous
                   end)
                (outcomes c)
            else [])
         cs)
    cs.

Definition cell_for (t : term) : option cell :=
  find (fun c => (context c =? of_context t) && (blind K || (group c =? of_group t))) (cells T).

Definition form_of_term (t : term) : option form :=
  match cell_for t with
  | Some c => option_map (multiplied (coefficient t)) (value_for c (of_decision t))
  | None => None
  end.

Fixpoint form_of_terms (ts : list term) : option form :=
  match ts with
  | t :: rest =>
      match form_of_term t, form_of_terms rest with
      | Some f, Some h => Some (added f h)
      | _, _ => None
      end
  | [] => Some (fixed zero)
  end.

Definition further_row (r : list term * Q) : form :=
  match form_of_terms r.1 with Some f => difference (fixed r.2) f | None => vacuous end.

Definition range_rows : list form :=
  flat_map
    (fun c => flat_map (fun o => [difference (value c o) (fixed (least K)); difference (fixed (gamma K)) (value c o)]) (outcomes c))
    (places None).

Definition constraints (x : option Z) : list form :=
  flat_map (fun c => map (order_row c) (order K)) (places x)
  ++ match lipschitz K with Some L => lipschitz_rows L x | None => [] end
  ++ map further_row (rows K)
  ++ match parameters K with
     | Some F => range_rows ++ map (fun r => difference (fixed r.2) (in_parameters r.1)) (family_rows F)
     | None => []
     end.

(* Whether contexts are coupled, so that the constraints of all of them concern every pair. *)
Definition coupled : bool :=
  match rows K, parameters K with [], None => false | _, _ => true end.

(* ---- The linear program of one pair ---- *)

Definition common (qs : list Q) : Z := fold_right (fun q d => Z.lcm (Zpos (Qden q)) d) 1 qs.
Definition fits (d : Z) (q : Q) : bool := d mod Zpos (Qden q) =? 0.
Definition over (d : Z) (q : Q) : Z := Qnum q * (d / Zpos (Qden q)). (* d * q, where it fits *)

Definition entries_of (f : form) : list Q := free f :: map snd (linear f).
Definition denominator (f : form) : Z := common (entries_of f).
Definition exact (f : form) : bool := (0 <? denominator f) && forallb (fits (denominator f)) (entries_of f).

Definition cleared (f : form) : row var :=
  let d := denominator f in Row (map (fun t => (t.1, over d t.2)) (linear f)) (over d (free f)).

(* The ends of the boxes of the variables *)
Definition ends : list Q := match parameters K with Some F => lower F ++ upper F | None => [least K; gamma K] end.
Definition unit : Z := common ends.
Definition box_low (j : var) : Q := match parameters K with Some F => entry zero (lower F) j.1.1 | None => least K end.
Definition box_high (j : var) : Q := match parameters K with Some F => entry zero (upper F) j.1.1 | None => gamma K end.

(* That [objective] is at most 0, by multiples of slacks; [u] is the value of [unit]. *)
Definition proved (u : Z) (objective : form) (ms : list (Q * form)) : bool :=
  let d := denominator objective in
  let dens := map (fun m => Qnum m.1 :: Zpos (Qden m.1) * denominator m.2 :: nil) ms in
  let scale := fold_right (fun m e => Z.lcm (Zpos (Qden m.1) * denominator m.2) e) d ms in
  [&& exact objective, forallb (fun m => exact m.2) ms
    & lp_check same before u (fun j => over u (box_low j)) (fun j => over u (box_high j)) (scale / d) (cleared objective)
        (map (fun m => (Qnum m.1 * (scale / (Zpos (Qden m.1) * denominator m.2)), cleared m.2)) ms)].

(* ---- A claim and its evidence ---- *)

(* Of a pair: its context (-1: the means of groups are compared), higher, lower, and its multipliers by constraint number *)
Record evidence := Evidence { at_context : Z; higher : Z; lower_group : Z; multipliers : list (Z * Q) }.

(* Choose constraints by their numbers, which increase; nothing if one does not exist. *)
Fixpoint chosen (n : Z) (ys : list (Z * Q)) (slacks : list form) : option (list (Q * form)) :=
  match slacks with
  | s :: rest =>
      match ys with
      | (i, y) :: ys' =>
          if i =? n then option_map (cons (y, s)) (chosen (n + 1) ys' rest) else chosen (n + 1) ys rest
      | [] => Some []
      end
  | [] => match ys with [] => Some [] | _ => None end
  end.

(* Groups that are compared with one another, with the forms of their expectations *)
Record setting := Setting {
  where_ : Z;
  compared : list (Z * form);
  alike : bool;             (* all of them have the same expectation *)
  of_setting : list form    (* the constraints besides the floors *)
}.

Definition pairs (gs : list (Z * form)) : list ((Z * form) * (Z * form)) :=
  flat_map (fun h => flat_map (fun l => if h.1 =? l.1 then [] else [(h, l)]) gs) gs.

Definition floor_row (t : Q) (g : Z * form) : form := difference g.2 (fixed t).

Definition floors (s : setting) (h l : Z * form) : list form :=
  match tau K with
  | None => []
  | Some t => map (floor_row t) (if on_pair K then [h; l] else compared s)
  end.

Definition about (s : setting) (h l : Z * form) (e : evidence) : bool :=
  (at_context e =? where_ s) && (higher e =? h.1) && (lower_group e =? l.1).

Definition greatest_floor : Q :=
  match tau K with Some t => if at_most t (least K) then least K else t | None => least K end.

(* gamma / floor <= v, so that no ratio exceeds v *)
Definition bounded (v : Q) : bool := positive_fraction greatest_floor && at_most (gamma K) (times v greatest_floor).

Definition pair_proved (u : Z) (v : Q) (s : setting) (es : list evidence) (pair : (Z * form) * (Z * form)) : bool :=
  let '(h, l) := pair in
  match find (about s h l) es with
  | None => alike s || bounded v
  | Some e =>
      match chosen 0 (multipliers e) (floors s h l ++ of_setting s) with
      | Some ms => proved u (difference h.2 (multiplied v l.2)) ms
      | None => false
      end
  end.

Definition setting_proved (u : Z) (v : Q) (es : list evidence) (s : setting) : bool :=
  let own := filter (fun e => at_context e =? where_ s) es in
  forallb (pair_proved u v s own) (pairs (compared s)).

(* The law of a cell, in lowest terms *)
Definition law (c : cell) : list (Z * Q) := map (fun o => (decision o, times (inverse (weight_sum c)) (weight o))) (outcomes c).

Fixpoint same_law (p q : list (Z * Q)) : bool :=
  match p, q with
  | [], [] => true
  | (u, a) :: p', (w, b) :: q' => [&& u =? w, equal a b & same_law p' q']
  | _, _ => false
  end.

Definition alike_in (cs : list cell) : bool :=
  let laws := map law cs in blind K && forallb (fun p => forallb (same_law p) laws) laws.

Definition populated (a : Z) : bool := positive_fraction (mass_of_group a).

Definition complete : bool := Z.of_nat (length (cells T)) =? Z.of_nat (length (contexts T)) * Z.of_nat (length (groups T)).

(* The groups whose means are compared *)
Definition everywhere : list Z :=
  match population T, complete with
  | Alike, false => []
  | _, _ => filter populated (groups T)
  end.

Definition settings : list setting :=
  let all := if coupled || negb (local K) then constraints None else [] in
  if local K then
    map
      (fun x =>
         let cs := filter (fun c => context c =? x) (cells T) in
         Setting x (map (fun c => (group c, expectation_form c)) cs) (alike_in cs) (if coupled then all else constraints (Some x)))
      (contexts T)
  else [Setting (-1) (map (fun a => (a, mean_form a)) everywhere) false all].

Definition valid_cell (c : cell) : bool :=
  [&& forallb (fun o => nonnegative (weight o)) (outcomes c), positive_fraction (weight_sum c) & nonnegative (weight_of_cell c)].

Definition valid : bool :=
  [&& forallb valid_cell (cells T), nonnegative (least K), at_most (least K) (gamma K), 0 <? unit & forallb (fits unit) ends].

(* Whether the evidence names a pair that is compared. *)
Definition named (ss : list setting) (e : evidence) : bool :=
  existsb
    (fun s => (where_ s =? at_context e) && negb (higher e =? lower_group e)
              && existsb (fun g => g.1 =? higher e) (compared s) && existsb (fun g => g.1 =? lower_group e) (compared s))
    ss.

(* The ratio of the two groups is at most v for every utility of the class: this is what is proved sound. *)
Definition bound_proved (v : Q) (es : list evidence) : bool :=
  let ss := settings in
  let u := unit in
  [&& valid, at_most one v, forallb (setting_proved u v es) ss & forallb (named ss) es].

(* ---- What the page demands besides: that the utility of the table has a ratio, and none above v ---- *)

Definition stated_expectation (c : cell) : Q :=
  times (inverse (weight_sum c)) (total (map (fun o => times (weight o) (stated o)) (outcomes c))).

Definition stated_mean (a : Z) : Q :=
  times (inverse (mass_of_group a)) (total (map (fun c => times (mass c) (stated_expectation c)) (of_that_group a))).

Definition stated_values : list (list Q) :=
  if local K then map (fun x => map stated_expectation (filter (fun c => context c =? x) (cells T))) (contexts T)
  else [map stated_mean everywhere].

Definition attained_within (v : Q) : bool :=
  forallb (fun qs => forallb (fun p => forallb (fun q => at_most p (times v q)) qs) qs) stated_values.

Definition compares : bool := existsb (fun qs => match qs with _ :: _ :: _ => true | _ => false end) stated_values.

(* The whole claim: [None] is infinity, [about_local] what the claim is about. *)
Definition claim_true (about_local : bool) (v : option Q) (es : list evidence) : bool :=
  [&& Bool.eqb about_local (local K), compares
    & match v with
      | None => true
      | Some v => attained_within v && bound_proved v es
      end].
End Class.
