(* Whether a binomial tail is at most a level, for few draws and for many.

   This file only computes; LargeTailsSound.v proves it right.  The law of PairLaw.v is summed from its mode outwards and decides at once where
   tail and level are not close.  Up to 5,000 draws the sum of Tails.v decides the rest.  Beyond, docs/certificate-samples.md has the Chernoff
   bound of the tail, sharpened, in the place of the tail.  That bound is compared with the level, too: all that is proved rests on the law, and
   the bound makes sure that no more is accepted than the page says. *)

From Coq Require Import ZArith QArith List.
From mathcomp Require Import ssreflect ssrfun ssrbool.
From FairauditKernel Require Import Fractions.
From FairauditChecker Require Import Nats Tails PairLaw.
Import ListNotations.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Local Open Scope Z_scope.

(* Binomial tails are summed up to this many draws. *)
Definition summed : Z := 5000.

(* ---- Products of powers of fractions, from below, with so many bits ---- *)

Definition bits : Z := 512.

Definition fraction_below (n d : Z) : binary :=
  let s := bits + Z.log2 d - Z.log2 n in if 0 <=? s then Binary (Z.shiftl n s / d) (- s) else Binary (n / d) 0.

Definition product (v w : binary) : binary := shortened bits (Binary (mantissa v * mantissa w) (exponent v + exponent w)).

Fixpoint raised_below (v : binary) (e : positive) : binary :=
  match e with
  | xH => v
  | xO e => let w := raised_below v e in product w w
  | xI e => let w := raised_below v e in product v (product w w)
  end.

Definition power_below (n d e : Z) : binary := match e with Zpos e => raised_below (fraction_below n d) e | _ => Binary 1 0 end.

Definition is_one_or_more (v : binary) : bool :=
  if 0 <=? exponent v then 1 <=? mantissa v else Z.shiftl 1 (- exponent v) <=? mantissa v.

(* ---- The bound ---- *)

(* At most k successes of n have, at the mean a/(a + b), at most the level by exp(-n D) sqrt(53 n / (333 k (n - k) (1 - rho)^2)), and by
   exp(-n D) alone if the root is not below 1 or k = 0; D is the relative entropy, rho = k b / ((n - k + 1) a). *)
Definition bound_is_small (n k a b : Z) (level : Q) : bool :=
  let all := a + b in
  let rest := n - k in
  let inverse := product (power_below (rest * all) (n * b) rest) (power_below (k * all) (n * a) k) in
  let far := product (product inverse inverse) (power_below (Qnum level) (Zpos (Qden level)) 2) in
  let step := rest + 1 in
  let gap := step * a - k * b in
  (* the root squared is top/bottom *)
  let top := 53 * n * (step * a) * (step * a) in
  let bottom := 333 * k * rest * gap * gap in
  is_one_or_more (if (0 <? k) && (top <? bottom) then product far (fraction_below bottom top) else far).

(* At most k successes of n, of the probability p each *)
Definition tail_by_law (n k : Z) (p level : Q) : bool := nonnegative level && rare_below (law_at n p) k level.

Definition bounded_tail (n k : Z) (p level : Q) : bool :=
  let a := Qnum p in
  let b := Zpos (Qden p) - a in
  [&& 0 <? a, k <? n
    & (b <=? 0) || [&& positive_fraction level, k * (a + b) <? n * a, bound_is_small n k a b level & tail_by_law n k p level]].

Definition tail_holds (n k : Z) (p level : Q) : bool :=
  if n <=? summed then tail_by_law n k p level || tail_at_most n k p level
  else nonnegative level && bounded_tail n k p level.
