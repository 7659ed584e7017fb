(* How far cells may move while a verdict stands, and the ratios within a drift: which claims are accepted.

   This file only computes; DriftSound.v proves by T16 that they hold.  Each end of the expectation of a cell that moves is computed at a
   threshold, which is checked to be the one that gives it. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool path.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Table Statements Figures.
From FairauditChecker Require Nats.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* ---- A law with its utilities: the probability and the utility of each decision ---- *)

Definition spread_law := list (Q * Q).

Definition no_less (v w : Q) : Q := if at_most v w then w else v.
Definition no_more_of (v w : Q) : Q := if at_most v w then v else w.
Definition difference (v w : Q) : Q := plus v (minus w).

Definition mass_where (in_it : Q -> bool) (P : spread_law) : Q := total (map fst (filter (fun pg => in_it pg.2) P)).
Definition below (theta : Q) : spread_law -> Q := mass_where (fun g => ~~ at_most theta g).
Definition up_to (theta : Q) : spread_law -> Q := mass_where (fun g => at_most g theta).
Definition above (theta : Q) : spread_law -> Q := mass_where (fun g => ~~ at_most g theta).

(* The decisions that can be reached: all, or by a factor those that are made *)
Definition reachable (k : move) (P : spread_law) : list Q :=
  map snd (match k with By_variation => P | By_factor => filter (fun pg => positive_fraction pg.1) P end).
Definition top_of (gs : list Q) : Q := match gs with g :: rest => fold_left no_less rest g | [] => zero end.

Definition turned (P : spread_law) : spread_law := map (fun pg => (pg.1, minus pg.2)) P.

(* Where the masses of a list add up to so much *)
Fixpoint threshold (left : Q) (last : Q) (P : spread_law) : Q :=
  match P with
  | (p, g) :: rest => if at_most left p then g else threshold (difference left p) g rest
  | [] => last
  end.

(* E + eta (gamma - theta) + E max(0, theta - g), where it is the greatest expectation within eta *)
Definition variation_end (eta theta gamma mean : Q) (P : spread_law) : option Q :=
  if [&& at_most theta gamma, at_most (below theta P) eta & at_most eta (up_to theta P)] then
    Some (plus (plus mean (times eta (difference gamma theta)))
               (total (map (fun pg => times pg.1 (no_less zero (difference theta pg.2))) P)))
  else None.

(* theta + E h(g - theta), h being f times what is above 0, and what is below divided by f *)
Definition factor_end (f theta : Q) (P : spread_law) : option Q :=
  let inv := inverse f in
  let part (inside : Q) (times_in times_out : Q) := plus (times inside times_in) (times (difference one inside) times_out) in
  if at_most (part (above theta P) f inv) one && at_most one (part (below theta P) inv f) then
    Some (plus theta (total (map (fun pg => let z := difference pg.2 theta in times pg.1 (times z (if nonnegative z then f else inv))) P)))
  else None.

Definition by_utility (a b : Q * Q) : bool := at_most a.2 b.2.

Definition both_of (lo hi : option Q) : option (Q * Q) := match lo, hi with Some l, Some h => Some (minus l, h) | _, _ => None end.

(* The least and the greatest expectation of a law that moves so far; none: however far by a factor *)
Definition ends_of_law (k : move) (amount : option Q) (mean : Q) (P : spread_law) : option (Q * Q) :=
  let rising := sort by_utility P in
  let falling := rev_append rising [] in
  match k, amount with
  | By_factor, None => Some (minus (top_of (reachable k (turned P))), top_of (reachable k P))
  | By_variation, None => Some (minus (top_of (reachable k (turned P))), top_of (reachable k P))
  | By_variation, Some eta =>
      both_of (variation_end eta (minus (threshold eta zero falling)) (top_of (reachable k (turned P))) (minus mean) (turned P))
              (variation_end eta (threshold eta zero rising) (top_of (reachable k P)) mean P)
  | By_factor, Some f =>
      let s := inverse (plus one f) in
      both_of (factor_end f (minus (threshold s zero rising)) (turned P)) (factor_end f (threshold s zero falling) P)
  end.

(* ---- Cells ---- *)

Definition mover := (row * list Q)%type. (* with the utilities of the decisions *)

Definition movers_of (T : table) (F : list (Z * list row)) : list (Z * list mover) :=
  map (fun rc => (rc.1.1, combine rc.1.2 (map (gains_of T) rc.2.2))) (combine F (runs context (cells T))).

Definition law_with_gains (c : mover) : spread_law := combine (law_of c.1) c.2.
Definition ends_of (k : move) (amount : option Q) (c : mover) : option (Q * Q) := ends_of_law k amount (mean c.1) (law_with_gains c).

Definition all_given (T : table) : bool :=
  match utility T with
  | Some _ => true
  | None => forallb (fun c => forallb (fun g => match g with Some _ => true | None => false end) (gains c)) (cells T)
  end.

Fixpoint all_some {A} (done : list A) (xs : list (option A)) : option (list A) :=
  match xs with Some x :: rest => all_some (x :: done) rest | None :: _ => None | [] => Some (rev_append done []) end.

(* Cells with their masses, of which a mean is taken *)
Definition massed := list (Q * mover).
Definition mean_over (ms : list (Q * Q)) : Q := times (inverse (sum (map fst ms))) (sum (map (fun mv => times mv.1 mv.2) ms)).

Definition ends_over (k : move) (amount : option Q) (cs : massed) : option (Q * Q) :=
  option_map (fun es => (mean_over (combine (map fst cs) (map fst es)), mean_over (combine (map fst cs) (map snd es))))
    (all_some [] (map (fun mc => ends_of k amount mc.2) cs)).

(* ---- A side of a named pair ---- *)

Record side := Side {
  at_end : Q;       (* the mean when all its cells have moved so far *)
  in_the_end : Q;   (* when they have moved as far as they can *)
  reached : Q;      (* the total variation from which on no cell moves on *)
  constant : bool   (* no move changes it *)
}.

Definition directed (up : bool) (P : spread_law) : spread_law := if up then P else turned P.
Definition signed_as (up : bool) (v : Q) : Q := if up then v else minus v.

Definition last_of (k : move) (up : bool) (c : mover) : Q := signed_as up (top_of (reachable k (directed up (law_with_gains c)))).
Definition reached_by (up : bool) (c : mover) : Q :=
  let P := directed up (law_with_gains c) in below (top_of (map snd P)) P.
Definition is_constant (k : move) (c : mover) : bool :=
  let P := law_with_gains c in at_most (top_of (reachable k P)) (minus (top_of (reachable k (turned P)))).

Definition side_of (k : move) (amount : option Q) (up : bool) (cs : massed) : option side :=
  option_map (fun e : Q * Q => Side (if up then e.2 else e.1) (mean_over (map (fun mc => (mc.1, last_of k up mc.2)) cs))
                                    (top_of (map (fun mc => reached_by up mc.2) cs)) (forallb (fun mc => is_constant k mc.2) cs))
    (ends_over k amount cs).

(* ---- The greatest quotient of one end and another end of another mean ---- *)

Definition quotient_of (p q : Q) : option Q := if Qnum q =? 0 then if Qnum p =? 0 then Some one else None else Some (times p (inverse q)).
Definition larger (v w : option Q) : option Q := if not_above w v then v else w.

Fixpoint widest_from (best : option Q) (top bottom : Q) (es : list (Z * (Q * Q))) : option Q :=
  match es with
  | e :: rest =>
      widest_from (larger (larger best (quotient_of e.2.1 bottom)) (quotient_of top e.2.2)) (no_less top e.2.1) (no_more_of bottom e.2.2) rest
  | [] => best
  end.
Definition widest_of_ends (best : option Q) (es : list (Z * (Q * Q))) : option Q :=
  match es with e :: rest => widest_from best e.2.1 e.2.2 rest | [] => best end.

Definition greatest_of (blocks : list (list (Z * (Q * Q)))) : option Q := fold_left widest_of_ends blocks (Some one).

(* ---- What a claim is about ---- *)

Section Claims.
Variables (T : table) (A : list row). (* all groups *)

Definition compared_groups : list row := if with_means T then filter (fun r => positive_fraction (bulk r)) A else [].
Definition is_followed (fs : list Z) (a : Z) : bool := existsb (Z.eqb a) fs.

(* The cells of a context and a group, or of a group; those without mass have no part in a mean. *)
Definition cells_at (movers : list (Z * list mover)) (local : bool) (x a : Z) : massed :=
  if local then
    match find (fun xm => xm.1 =? x) movers with
    | Some xm => map (fun c => (one, c)) (filter (fun c => who c.1 =? a) xm.2)
    | None => []
    end
  else map (fun c => (bulk c.1, c)) (filter (fun c => (who c.1 =? a) && positive_fraction (bulk c.1)) (flat_map snd movers)).

(* The upper end of one and the lower end of another: top and bottom of quotients; or, of what no move avoids, the other way round *)
Definition oriented (worst : bool) (e : Q * Q) : Q * Q := if worst then (e.2, e.1) else e.

Definition local_ends (k : move) (amount : option Q) (worst : bool) (movers : list (Z * list mover)) : option (list (list (Z * (Q * Q)))) :=
  all_some [] (map (fun xm => all_some [] (map (fun c => option_map (fun e => (who c.1, oriented worst e)) (ends_of k amount c)) xm.2)) movers).

Definition group_ends (k : move) (amount : option Q) (worst : bool) (movers : list (Z * list mover)) : option (list (list (Z * (Q * Q)))) :=
  option_map (fun es => [es])
    (all_some [] (map (fun r => option_map (fun e => (who r, oriented worst e)) (ends_over k amount (cells_at movers false nothing (who r))))
                      compared_groups)).

Definition ends_everywhere (k : move) (amount : option Q) (worst local : bool) (movers : list (Z * list mover)) : option (option Q) :=
  option_map greatest_of (if local then local_ends k amount worst movers else group_ends k amount worst movers).

(* The sides of a pair that is named, if it is one that is compared *)
Definition sides_of (k : move) (amount : option Q) (worst local : bool) (movers : list (Z * list mover)) (fs : list Z) (p : option place) :
  option (side * side) :=
  match p with
  | None => None
  | Some p =>
      let there a := if local then true else is_followed fs a && existsb (fun r => who r =? a) compared_groups in
      let own a := cells_at movers local (at_context p) a in
      if [&& ~~ (higher p =? lower p), there (higher p), there (lower p), if local then true else at_context p =? nothing,
             match own (higher p) with [] => false | _ => true end & match own (lower p) with [] => false | _ => true end] then
        match side_of k amount worst (own (higher p)), side_of k amount (~~ worst) (own (lower p)) with
        | Some one, Some other => Some (one, other)
        | _, _ => None
        end
      else None
  end.

End Claims.

(* ---- The claims ---- *)

Definition is_zero (q : Q) : bool := Qnum q =? 0.
Definition same_extended (v w : option Q) : bool :=
  match v, w with Some v, Some w => at_most v w && at_most w v | None, None => true | _, _ => false end.
Definition same_number (v w : Q) : bool := at_most v w && at_most w v.

(* top = V bottom; both may be 0 whatever V is *)
Definition level (bound : option Q) (top bottom : Q) : bool :=
  (is_zero top && is_zero bottom) || match bound with Some V => same_number top (times V bottom) | None => false end.
Definition rises (bound : option Q) (top bottom : Q) : bool :=
  match bound with Some V => ~~ at_most top (times V bottom) | None => false end.

(* Of local ratios no means are followed. *)
Definition follows_groups (T : table) (local : bool) (fs : list Z) : bool :=
  if local then match fs with [] => true | _ => false end else forallb (inside (groups T)) fs.

Definition is_amount (k : move) (w : Q) : bool :=
  match k with By_variation => nonnegative w && at_most w one | By_factor => at_most one w end.

(* Undecided where some part is, and nothing else is false *)
Definition and_also (a b : option bool) : option bool :=
  match a, b with
  | Some false, _ | _, Some false => Some false
  | Some true, Some true => Some true
  | _, _ => None
  end.

(* [keeps r]: whether a ratio is within the limit, if that is decided; [bound]: the greatest that is, if it is rational *)
Section Limit.
Variables (T : table) (F : list (Z * list row)) (A : list row) (keeps : option Q -> option bool) (bound : option Q).

Definition exceeds_limit (r : option Q) : option bool := option_map negb (keeps r).

(* Within: all pairs stay so; and beyond an exact amount the pair does not *)
Definition within_stands (s : stand) (worst : option Q) (named : option (side * side)) : option bool :=
  and_also (keeps worst)
    (match named, no_further s, how_far s with
     | Some (high, low), true, Some _ =>
         Some (match bound with Some _ => level bound (at_end high) (at_end low) && rises bound (in_the_end high) (in_the_end low) | None => false end)
     | None, true, Some _ => Some false
     | Some (high, low), _, _ => Some (same_extended (quotient_of (at_end high) (at_end low)) worst)
     | None, _, _ => Some true
     end).

(* Exceeds: the pair does with any lesser move; and with an exact amount no pair has to *)
Definition exceeds_stands (s : stand) (best : option Q) (named : option (side * side)) : option bool :=
  match named with
  | None => Some false
  | Some (high, low) =>
      let moves := ~~ (constant high && constant low) in
      let apart := match moves_by s, how_far s with
        | By_variation, Some w => at_most w (reached high) || at_most w (reached low)
        | By_variation, None => false
        | By_factor, _ => moves
        end in
      let before := if level bound (at_end high) (at_end low) then Some apart else exceeds_limit (quotient_of (at_end high) (at_end low)) in
      and_also before
        (match no_further s, how_far s with
         | true, Some _ => Some (match bound with Some V => not_above best (Some V) | None => false end)
         | _, _ => Some true
         end)
  end.

Definition stand_holds (f : option figure) (s : stand) : option bool :=
  match f with
  | None => Some false
  | Some f =>
      let movers := movers_of T F in
      let local := is_local s in
      let worst := keeps_limit s in
      let amount := how_far s in
      let groups_known := follows_groups T local (followed s) in
      let all_followed := local || forallb (fun r => is_followed (followed s) (who r)) (compared_groups T A) in
      if ~~ [&& all_given T, groups_known, match amount with Some w => is_amount (moves_by s) w | None => no_further s end
             & match keeps (value f) with Some b => Bool.eqb b worst | None => true end]
      then Some false
      else match keeps (value f), all_followed, ends_everywhere T A (moves_by s) amount worst local movers with
      | Some _, true, Some extreme =>
          let named := sides_of T A (moves_by s) amount worst local movers (followed s) (turning s) in
          match turning s, named with
          | Some _, None => Some false
          | _, _ => if worst then within_stands s extreme named else exceeds_stands s extreme named
          end
      | _, _, _ => None
      end
  end.
End Limit.

Definition of_ratio (limit : Q) (r : option Q) : option bool := Some (not_above r (Some limit)).

Definition stands_for_ratio (T : table) (F : list (Z * list row)) (A : list row) (f : option figure) (s : stand) (limit : Q) : option bool :=
  if at_most one limit then stand_holds T F A (of_ratio limit) (Some limit) f s else Some false.

(* A limit on the logarithm, which no ratio of at most 1 is above *)
Definition of_nats (limit : Q) (r : option Q) : option bool := if not_above r (Some one) then Some true else Nats.log_at_most r limit.

Definition stands_for_log (T : table) (F : list (Z * list row)) (A : list row) (f : option figure) (s : stand) (limit : Q) : option bool :=
  if nonnegative limit then stand_holds T F A (of_nats limit) (if is_zero limit then Some one else None) f s else Some false.

(* A ratio of 1 names no pair, and any other one the pair that attains it. *)
Definition is_reached (v : option Q) (p : option place) (named : option (side * side)) : bool :=
  match p, named with
  | None, _ => same_extended v (Some one)
  | Some _, Some (high, low) => ~~ same_extended v (Some one) && same_extended (quotient_of (at_end high) (at_end low)) v
  | Some _, None => false
  end.

(* The greatest and the least ratio within a drift *)
Definition ratio_holds (T : table) (F : list (Z * list row)) (A : list row) (f : option figure) (local worst : bool) (eta : Q) (v : option Q)
  (p : option place) (fs : list Z) : option bool :=
  match f with
  | None => Some false
  | Some _ =>
      let movers := movers_of T F in
      let groups_known := follows_groups T local fs in
      let all_followed := local || forallb (fun r => is_followed fs (who r)) (compared_groups T A) in
      if ~~ [&& all_given T, groups_known & is_amount By_variation eta] then Some false
      else match all_followed, ends_everywhere T A By_variation (Some eta) worst local movers with
      | true, Some extreme =>
          Some (same_extended v extreme && is_reached v p (sides_of T A By_variation (Some eta) worst local movers fs p))
      | _, _ => None
      end
  end.
