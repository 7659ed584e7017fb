(* Whether an interval of a ratio is proved by the draws that a table counts.

   This file only computes; DrawnMeaning.v says what it means and DrawnSound.v proves it.  It follows docs/certificate-samples.md for
   tables of counts.  A pool holds the draws that have one mean: of the local ratio those of a cell, in each context with two cells or
   more; of the global ratio those of a group in all contexts.  Pools of one block are compared. *)

From Coq Require Import ZArith QArith List Ascii.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Table Chance.
From FairauditChecker Require Figures Pairs Bets LargeTails.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

Record pool := Pool {
  of_block : Z;
  values : list Q; (* of each decision *)
  counts : list Z  (* how often it was drawn *)
}.

(* ---- The pools of a table ---- *)

Definition whole (q : Q) : option Z := match Qden q with xH => Some (Qnum q) | _ => None end.

Fixpoint all_of {A B} (f : A -> option B) (xs : list A) : option (list B) :=
  match xs with
  | x :: rest => match f x, all_of f rest with Some y, Some ys => Some (y :: ys) | _, _ => None end
  | [] => Some []
  end.

Definition values_of (T : table) (c : cell) : option (list Q) :=
  match utility T with Some gs => Some gs | None => all_of id (gains c) end.

Definition context_of_cell (c : cell) : Z := context c.

(* The cells of contexts with two or more, each with the number of its block; n is that of the block of the context [before]. *)
Fixpoint compared_cells (n before : Z) (cs : list cell) : list (Z * cell) :=
  match cs with
  | c :: rest =>
      if context c =? before then (n, c) :: compared_cells n before rest
      else if (match rest with d :: _ => context d =? context c | [] => false end) then (n + 1, c) :: compared_cells (n + 1) (context c) rest
      else compared_cells n before rest
  | [] => []
  end.

Definition local_pools (T : table) : option (list pool) :=
  all_of (fun nc : Z * cell =>
    match values_of T nc.2, all_of whole (weights nc.2) with Some gs, Some ns => Some (Pool nc.1 gs ns) | _, _ => None end)
    (compared_cells (-1) (-1) (cells T)).

Fixpoint added (ms ns : list Z) : list Z :=
  match ms, ns with m :: ms, n :: ns => m + n :: added ms ns | [], ns => ns | ms, [] => ms end.

Definition global_pools (T : table) : option (list pool) :=
  match utility T with
  | None => None
  | Some gs =>
      let own a := filter (fun c => group c =? a) (cells T) in
      all_of (fun cs => option_map (fun nss => Pool 0 gs (fold_left added nss [])) (all_of (fun c => all_of whole (weights c)) cs))
        (filter (fun cs => match cs with [] => false | _ => true end) (map own (range (groups T))))
  end.

(* None: what is not covered *)
Definition pools_of (T : table) (local : bool) : option (list pool) :=
  match population T with Counted => if local then local_pools T else global_pools T | _ => None end.

(* ---- Draws that are worth one number or nothing ---- *)

Definition sum (ns : list Z) : Z := fold_left Z.add ns 0.
Definition greatest (qs : list Q) : Q := fold_left (fun m q => if at_most q m then m else q) qs zero.
Definition is_nothing (q : Q) : bool := Qnum q =? 0.

Definition sample_of (p : pool) : option sample :=
  let v := greatest (values p) in
  if nonnegative v && forallb (fun q => is_nothing q || (at_most q v && at_most v q)) (values p) then
    Some (Sample (of_block p) (sum (counts p)) (sum (map (fun gn => if is_nothing gn.1 then 0 else gn.2) (combine (values p) (counts p)))) v)
  else None.

(* ---- The judgement ---- *)

(* None: not covered *)
Definition judged_by_pools (i : interval) (ps : list pool) : option bool :=
  match all_of sample_of ps with
  | Some ((_ :: _) as ss) => if is_short ss then Some [&& at_most (confidence i) one, in_proportion i ss & box_accepted i ss] else None
  | _ => None
  end.

Definition proved_by_pools (i : interval) (ps : list pool) : bool := match judged_by_pools i ps with Some b => b | None => false end.

(* Score ends are computed of so many outcomes, of all cells together; what is said of more is not covered. *)
Definition most_outcomes : Z := 100000.

(* The same of ladders for pairs of cells, which are for draws that are worth one number or nothing *)
Definition judged_by_ladders (i : Pairs.by_pairs) (ps : list pool) : option bool :=
  match all_of sample_of ps with
  | Some [] => None
  | Some ss => if sum (map draws ss) <=? most_outcomes then Some (at_most (Pairs.sure_at i) one && Pairs.pairs_accepted i ss) else None
  | None => Some false
  end.

Definition proved_by_ladders (i : Pairs.by_pairs) (ps : list pool) : bool := match judged_by_ladders i ps with Some b => b | None => false end.

(* ---- The judgement of bets within units ---- *)

Definition tally : Type := list (Q * Z). (* how often which value *)

Definition mean_of (t : tally) : Q := times (total (map (fun qn => times qn.1 (number qn.2)) t)) (inverse (number (sum (map snd t)))).

(* What units got on average in a pool, if so many had so many rows of each decision; none: the rows are not those that the table counts. *)
Definition draws_of_units (p : pool) (us : list (Z * list Z)) : option tally :=
  let all_rows := fold_left (fun ns u => added ns (map (Z.mul u.1) u.2)) us [] in
  if forallb (fun u => Nat.eqb (length u.2) (length (counts p))) us && Nat.eqb (length all_rows) (length (counts p))
     && forallb (fun mn => mn.1 =? mn.2) (combine all_rows (counts p))
  then Some (map (fun u => (mean_of (combine (values p) u.2), u.1)) us)
  else None.

Definition draws_in (i : Bets.units) (ps : list pool) : option (list tally) :=
  match Bets.rows i with
  | None => Some (map (fun p => combine (values p) (counts p)) ps)
  | Some uss => if Nat.eqb (length uss) (length ps) then all_of (fun pu : pool * list (Z * list Z) => draws_of_units pu.1 pu.2) (combine ps uss) else None
  end.

(* The means over units, as a table with a row for each cell that is compared, of one decision that is worth the mean *)
Definition means_table (T : table) (ds : list tally) : table :=
  Table (contexts T) (groups T) 1 Alike None None
    (map (fun cd : Z * cell * tally => Cell (context cd.1.2) (group cd.1.2) [one] [Some (mean_of cd.2)] zero [])
      (combine (compared_cells (-1) (-1) (cells T)) ds)).

(* The contexts of pools, each with its number: the greatest utility there, and what was drawn from its pools *)
Definition contexts_of (limits : option (Q * Q)) (xs : list (pool * tally)) : list (Z * Bets.context) :=
  map (fun bx : Z * list (pool * tally) =>
    (bx.1, Bets.Context (match limits with Some l => l.2 | None => greatest (flat_map (fun x => values x.1) bx.2) end) (map snd bx.2)))
    (Figures.grouped (fun x : pool * tally => of_block x.1) xs).

Definition proved_by_units (i : Bets.units) (xs : list (pool * tally)) : bool :=
  match xs with [] => false | _ => Bets.accepted i (map snd (contexts_of (Bets.limits i) xs)) end.

Definition within_limits (T : table) (limits : option (Q * Q)) : bool :=
  match limits with Some (low, high) => nonnegative low && forallb (fun g => at_most low g && at_most g high) (given T) | None => true end.

(* None: not covered *)
Definition judged_by_units (T : table) (i : Bets.units) (ps : list pool) : option bool :=
  if signed T then None
  else Some (within_limits T (Bets.limits i) && match draws_in i ps with Some ds => proved_by_units i (combine ps ds) | None => false end).

(* ---- Intervals by what proves them ---- *)

Inductive proof :=
| By_box (i : interval)         (* an end for each cell *)
| By_pairs (i : Pairs.by_pairs) (* a ladder for each pair of cells *)
| By_bets (i : Bets.units).     (* what units got in several groups *)

Definition most_of (e : proof) : option Q := match e with By_box i => most i | By_pairs i => Pairs.highest i | By_bets i => Bets.most i end.
Definition least_of (e : proof) : option Q :=
  match e with By_box i => least i | By_pairs i => Some (Pairs.lowest i) | By_bets i => Some (Bets.least i) end.
Definition cells_independent (e : proof) : bool :=
  match e with By_box i => independent i | By_pairs i => Pairs.apart i | By_bets i => Bets.independent i end.
Definition confidence_of (e : proof) : Q := match e with By_box i => confidence i | By_pairs i => Pairs.sure_at i | By_bets i => Bets.confidence i end.
Definition ends_each (e : proof) : bool := match e with By_box i => each i | By_pairs i => Pairs.one_by_one i | By_bets i => Bets.each i end.
Definition over_units (e : proof) : bool := match e with By_bets i => match Bets.rows i with Some _ => true | None => false end | _ => false end.

Definition judged_by_draws (T : table) (local : bool) (e : proof) : option bool :=
  match e with
  | By_box i => match pools_of T local with Some ps => judged_by_pools i ps | None => None end
  | By_pairs i => match pools_of T local with Some ps => judged_by_ladders i ps | None => None end
  | By_bets i => match pools_of T local with Some ps => if local then judged_by_units T i ps else Some false | None => None end
  end.
