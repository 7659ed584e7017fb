(* Products of any number of filters, one for each attribute: what is known of the factors gives what is known of the
   product, which is never written out. *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.algebra_tactics Require Import ring.
From Fairaudit Require Import Definitions DP T13.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Section Products.
Variable R : realFieldType.

(* A factor: the filter of one attribute. *)
Record factor := Factor { input : finType; output : finType; row : input -> output -> R }.
Implicit Types (f : factor) (fs : seq factor) (k : factor -> R).

(* Inputs and outputs of the product are tuples, with one entry for each factor; probabilities multiply. *)
Fixpoint inputs fs : finType := if fs is f :: rest then [finType of input f * inputs rest] else [finType of unit].
Fixpoint outputs fs : finType := if fs is f :: rest then [finType of output f * outputs rest] else [finType of unit].
Fixpoint product fs : inputs fs -> outputs fs -> R :=
  match fs with
  | f :: rest => both (@row f) (@product rest)
  | [::] => fun _ _ => 1
  end.

Fixpoint every (p : factor -> Prop) fs : Prop := if fs is f :: rest then p f /\ every p rest else True.

Lemma sum_unit (F : unit -> R) : \sum_o F o = F tt.
Proof. by rewrite (bigD1 tt) //= big1 ?addr0 // => -[]. Qed.

Theorem product_kernel fs : every (fun f => kernel (@row f)) fs -> kernel (@product fs).
Proof.
elim: fs => [_ a|f fs IH /= [kf kfs]]; first by split=> [o|]; rewrite ?ler01 // sum_unit.
exact: kernel_both kf (IH kfs).
Qed.

(* ---- Privacy: ratios multiply over the attributes that differ ---- *)

(* The product of the e^eps, k f for the factor f, of the attributes in which two persons differ. *)
Fixpoint differing k fs : inputs fs -> inputs fs -> R :=
  match fs with
  | f :: rest => fun a a' => (if a.1 == a'.1 then 1 else k f) * @differing k rest a.2 a'.2
  | [::] => fun _ _ => 1
  end.

Theorem product_pure_dp k fs : every (fun f => kernel (@row f) /\ every_pair (pure_dp (k f)) (@row f)) fs ->
  forall a a', pure_dp (differing k a a') (@product fs a) (@product fs a').
Proof.
elim: fs => [_ a a' o|f fs IH /= [[kf df] dfs] [a b] [a' b']]; first by rewrite /= mulr1.
have kfs : kernel (@product fs).
  by apply: product_kernel; elim: (fs) dfs => //= h hs IHs [[kh _] /IHs].
have k0 : 0 <= (if a == a' then 1 else k f).
  by case: ifP => _; rewrite ?ler01 // (le_trans ler01) // (pure_dp_ge1 (kf a) (kf a')).
apply: pure_dp_products => //; [by case: (kf a)|by case: (kfs b)|by case: (kf a')| |exact: IH].
by case: ifP => [/eqP->|_] // o; rewrite mul1r.
Qed.

(* So the e^eps of a product is at most the product of those of its factors ... *)
Lemma differing_le k fs (a a' : inputs fs) : every (fun f => 1 <= k f) fs ->
  0 <= differing k a a' <= \prod_(f <- fs) k f.
Proof.
elim: fs a a' => [a a' _|f fs IH [a b] [a' b'] /= [kf kfs]]; first by rewrite big_nil /= ler01 lexx.
have k0 : 0 <= k f := le_trans ler01 kf; have /andP[d0 d1] := IH b b' kfs.
rewrite big_cons; case: ifP => _; rewrite ?mul1r ?mulr_ge0 // ?ler_wpmul2l ?d0 //=.
by apply: (le_trans d1); rewrite ler_pemull // (le_trans d0 d1).
Qed.

Theorem product_every_pair k fs : every (fun f => [/\ kernel (@row f), every_pair (pure_dp (k f)) (@row f) & 1 <= k f]) fs ->
  every_pair (pure_dp (\prod_(f <- fs) k f)) (@product fs).
Proof.
move=> all_f a a' o.
have dp : every (fun f => kernel (@row f) /\ every_pair (pure_dp (k f)) (@row f)) fs.
  by elim: (fs) all_f => //= f fs' IH [[? ? _] /IH].
have k1 : every (fun f => 1 <= k f) fs by elim: (fs) all_f => //= f fs' IH [[? ? ?] /IH].
have kp : kernel (@product fs) by apply: product_kernel; elim: (fs) dp => //= f fs' IH [[? ?] /IH].
apply: le_trans (product_pure_dp dp a a' o) _; apply: ler_wpmul2r; first by case: (kp a').
by case/andP: (differing_le a a' k1).
Qed.

(* ... and it is that product where each factor attains its own. *)
Theorem product_attained k fs :
  every (fun f => exists a a' b, @row f a b = k f * @row f a' b /\ 0 < @row f a' b) fs ->
  exists a a' b, @product fs a b = (\prod_(f <- fs) k f) * @product fs a' b /\ 0 < @product fs a' b.
Proof.
elim: fs => [_|f fs IH /= [[a [a' [b [e p]]]] /IH[c [c' [d [e' p']]]]]].
  by exists tt, tt, tt; rewrite big_nil mulr1 ltr01.
exists (a, c), (a', c'), (b, d); rewrite big_cons /= /both /= e e' mulr_gt0 //.
by rewrite mulrACA.
Qed.

(* ---- H_k and S(V) of a product, by merging outputs of equal likelihood ratio in each factor ---- *)

Section Merging.
(* Into which class an output of a factor goes, for two inputs. *)
Variables (class : factor -> finType) (class_of : forall f, input f -> input f -> output f -> class f).

Fixpoint classes fs : finType := if fs is f :: rest then [finType of class f * classes rest] else [finType of unit].

(* The rows of two inputs over tuples of classes: products of the merged rows of the factors. *)
Fixpoint merged_rows fs : inputs fs -> inputs fs -> (classes fs -> R) * (classes fs -> R) :=
  match fs with
  | f :: rest => fun a a' =>
      let first := class_of a.1 a'.1 in
      let others := @merged_rows rest a.2 a'.2 in
      (fun c => merged first (@row f a.1) c.1 * others.1 c.2, fun c => merged first (@row f a'.1) c.1 * others.2 c.2)
  | [::] => fun _ _ => (fun=> 1, fun=> 1)
  end.

Hypothesis equal_ratios : forall f a a', alike (@class_of f a a') (@row f a) (@row f a').

Theorem product_merged fs (F : R -> R -> R) : every (fun f => kernel (@row f)) fs -> homogeneous F -> forall a a',
  \sum_o F (@product fs a o) (@product fs a' o) = \sum_c F ((merged_rows a a').1 c) ((merged_rows a a').2 c).
Proof.
elim: fs F => [F _ _ a a'|f fs IH F /= [kf kfs] hF [a b] [a' b']] //=.
rewrite -(pair_bigA _ (fun o p => F (@row f a o * product b p) (@row f a' o * product b' p))) /=.
rewrite -(pair_bigA _ (fun c d => F (merged (class_of a a') (@row f a) c * (merged_rows b b').1 d)
                                    (merged (class_of a a') (@row f a') c * (merged_rows b b').2 d))) /=.
have row0 c o : 0 <= @row f c o by case: (kf c).
have /= -> := T13_merge_factor (product b) (product b') (row0 a) (row0 a') (fun _ => hF) (@equal_ratios f a a').
apply: eq_bigr => c _; apply: (IH (fun x y => F (merged _ _ c * x) (merged _ _ c * y))) => // s x y s0.
by rewrite ![_ * (s * _)]mulrCA hF.
Qed.

Theorem product_hockey_stick fs (k : R) a a' : every (fun f => kernel (@row f)) fs ->
  hockey_stick k (@product fs a) (@product fs a') = hockey_stick k (merged_rows a a').1 (merged_rows a a').2.
Proof. by move=> kfs; apply: product_merged kfs (homogeneous_hockey_stick k) a a'. Qed.

Theorem product_surplus fs (U : finType) (u0 : U) (alpha beta : U -> R) V a a' : every (fun f => kernel (@row f)) fs ->
  surplus u0 (fun o u => @product fs a o * alpha u) (fun o u => @product fs a' o * beta u) V =
  surplus u0 (fun c u => (merged_rows a a').1 c * alpha u) (fun c u => (merged_rows a a').2 c * beta u) V.
Proof. by move=> kfs; apply: product_merged kfs (homogeneous_greatest u0 alpha beta V) a a'. Qed.

End Merging.
End Products.
