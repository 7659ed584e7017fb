(* Loops, which take no room on the stack however long a list is, in the place of functions that recurse.

   LoopsSound.v proves that each is the same function; Extract.v then puts it in the place of the other, which is the one that
   definitions and proofs are about.  A browser has room for some ten thousand calls within calls, and a table may have more cells. *)

From Coq Require Import ZArith List.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope list_scope.

(* ---- Lists; what is done is in reverse ---- *)

Section Lists.
Variables A B : Type.

Definition loop_app (xs ys : list A) : list A := rev_append (rev_append xs []) ys.

Fixpoint length_onto (done : nat) (xs : list A) : nat := match xs with _ :: rest => length_onto (S done) rest | [] => done end.
Definition loop_length (xs : list A) : nat := length_onto O xs.

Fixpoint map_onto (f : A -> B) (done : list B) (xs : list A) : list B :=
  match xs with x :: rest => map_onto f (f x :: done) rest | [] => done end.
Definition loop_map (f : A -> B) (xs : list A) : list B := rev_append (map_onto f [] xs) [].

Fixpoint flat_map_onto (f : A -> list B) (done : list B) (xs : list A) : list B :=
  match xs with x :: rest => flat_map_onto f (rev_append (f x) done) rest | [] => done end.
Definition loop_flat_map (f : A -> list B) (xs : list A) : list B := rev_append (flat_map_onto f [] xs) [].

Fixpoint concat_onto (done : list A) (xss : list (list A)) : list A :=
  match xss with xs :: rest => concat_onto (rev_append xs done) rest | [] => done end.
Definition loop_concat (xss : list (list A)) : list A := rev_append (concat_onto [] xss) [].

Fixpoint filter_onto (f : A -> bool) (done : list A) (xs : list A) : list A :=
  match xs with x :: rest => filter_onto f (if f x then x :: done else done) rest | [] => done end.
Definition loop_filter (f : A -> bool) (xs : list A) : list A := rev_append (filter_onto f [] xs) [].

Fixpoint combine_onto (done : list (A * B)) (xs : list A) (ys : list B) : list (A * B) :=
  match xs, ys with x :: xs, y :: ys => combine_onto ((x, y) :: done) xs ys | _, _ => done end.
Definition loop_combine (xs : list A) (ys : list B) : list (A * B) := rev_append (combine_onto [] xs ys) [].

Fixpoint numbered_onto (done : list (Z * A)) (n : Z) (xs : list A) : list (Z * A) :=
  match xs with x :: rest => numbered_onto ((n, x) :: done) (n + 1)%Z rest | [] => done end.
Definition loop_numbered (n : Z) (xs : list A) : list (Z * A) := rev_append (numbered_onto [] n xs) [].

(* Rows that follow one another and have the same key: the runs with one more row before them *)
Definition before_runs (key : A -> Z) (more : list (Z * list A)) (x : A) : list (Z * list A) :=
  match more with
  | (k, ys) :: rest => if (k =? key x)%Z then (k, x :: ys) :: rest else (key x, [x]) :: more
  | [] => [(key x, [x])]
  end.
Definition loop_runs (key : A -> Z) (xs : list A) : list (Z * list A) := fold_left (before_runs key) (rev_append xs []) [].

Fixpoint aligned_onto (who : A -> Z) (done : list (Z * list Z)) (xs : list Z) (F : list (Z * list A)) : list (Z * list Z) :=
  match xs with
  | x :: rest =>
      match F with
      | (y, rs) :: more => if (y =? x)%Z then aligned_onto who ((x, map who rs) :: done) rest more else aligned_onto who ((x, []) :: done) rest F
      | [] => aligned_onto who ((x, []) :: done) rest []
      end
  | [] => done
  end.
Definition loop_aligned (who : A -> Z) (xs : list Z) (F : list (Z * list A)) : list (Z * list Z) := rev_append (aligned_onto who [] xs F) [].

Fixpoint all_of_onto (f : A -> option B) (done : list B) (xs : list A) : option (list B) :=
  match xs with
  | x :: rest => match f x with Some y => all_of_onto f (y :: done) rest | None => None end
  | [] => Some (rev_append done [])
  end.
Definition loop_all_of (f : A -> option B) (xs : list A) : option (list B) := all_of_onto f [] xs.

(* Of runs of two or more with the same key each with the number of its run; n is that of the run of [before] *)
Fixpoint compared_onto (key : A -> Z) (done : list (Z * A)) (n before : Z) (xs : list A) : list (Z * A) :=
  match xs with
  | x :: rest =>
      if (key x =? before)%Z then compared_onto key ((n, x) :: done) n before rest
      else if (match rest with y :: _ => key y =? key x | [] => false end)%Z then compared_onto key ((n + 1, x)%Z :: done) (n + 1) (key x) rest
      else compared_onto key done n before rest
  | [] => done
  end.
Definition loop_compared (key : A -> Z) (n before : Z) (xs : list A) : list (Z * A) := rev_append (compared_onto key [] n before xs) [].
End Lists.

Definition loop_fold_right (A B : Type) (f : B -> A -> A) (last : A) (xs : list B) : A := fold_left (fun a x => f x a) (rev_append xs []) last.

Fixpoint in_twos_onto (A : Type) (plus : A -> A -> A) (done xs : list A) : list A :=
  match xs with x :: y :: rest => in_twos_onto plus (plus x y :: done) rest | _ => rev_append done xs end.
Definition loop_in_twos (A : Type) (plus : A -> A -> A) (xs : list A) : list A := in_twos_onto plus [] xs.

(* ---- Numbers ---- *)

Fixpoint of_nat_onto (done : Z) (n : nat) : Z := match n with S n => of_nat_onto (done + 1)%Z n | O => done end.
Definition loop_of_nat (n : nat) : Z := of_nat_onto 0 n.

Definition loop_to_nat (z : Z) : nat := match z with Zpos p => Pos.iter S O p | _ => O end.

Fixpoint seq_onto (done : list nat) (start n : nat) : list nat := match n with S n => seq_onto (start :: done) (S start) n | O => done end.
Definition loop_seq (start n : nat) : list nat := rev_append (seq_onto [] start n) [].

Fixpoint range_onto (done : list Z) (start : Z) (n : nat) : list Z :=
  match n with S n => range_onto (start :: done) (start + 1)%Z n | O => done end.
Definition loop_range (n : Z) : list Z := rev_append (range_onto [] 0 (loop_to_nat n)) [].

(* ---- Sorting, of which merging alone takes room ---- *)

Section Sorting.
Variables (T : Type) (le : T -> T -> bool).

(* The steps are as many as there are entries in both lists. *)
Fixpoint merge_onto (steps done s t : list T) : list T :=
  match s, t with
  | [], _ => rev_append done t
  | _, [] => rev_append done s
  | x :: s', y :: t' =>
      match steps with
      | _ :: steps => if le x y then merge_onto steps (x :: done) s' t else merge_onto steps (y :: done) s t'
      | [] => []
      end
  end.
Definition loop_merge (s t : list T) : list T := merge_onto (rev_append s t) [] s t.

(* as in mathcomp's path.v *)
Fixpoint sort_push (s : list T) (ss : list (list T)) : list (list T) :=
  match ss with
  | [] => [s]
  | [] :: rest => s :: rest
  | t :: rest => [] :: sort_push (loop_merge t s) rest
  end.
Fixpoint sort_pop (s : list T) (ss : list (list T)) : list T :=
  match ss with t :: rest => sort_pop (loop_merge t s) rest | [] => s end.
Fixpoint sort_rec (ss : list (list T)) (s : list T) : list T :=
  match s with
  | x :: y :: rest => sort_rec (sort_push (if le x y then [x; y] else [y; x]) ss) rest
  | _ => sort_pop s ss
  end.
Definition loop_sort (s : list T) : list T := sort_rec [] s.

(* as in Coq's Mergesort.v *)
Fixpoint stack_push (stack : list (option (list T))) (s : list T) : list (option (list T)) :=
  match stack with
  | [] => [Some s]
  | None :: rest => Some s :: rest
  | Some t :: rest => None :: stack_push rest (loop_merge t s)
  end.
Fixpoint stack_pop (stack : list (option (list T))) : list T :=
  match stack with
  | [] => []
  | None :: rest => stack_pop rest
  | Some s :: rest => loop_merge s (stack_pop rest)
  end.
Fixpoint stack_rec (stack : list (option (list T))) (s : list T) : list T :=
  match s with x :: rest => stack_rec (stack_push stack [x]) rest | [] => stack_pop stack end.
Definition loop_stack_sort (s : list T) : list T := stack_rec [] s.
End Sorting.
