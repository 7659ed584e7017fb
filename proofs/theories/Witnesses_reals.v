(* Hypotheses that can be met: the theorems of Instances.v, over any field of real numbers (see Witnesses.v). *)

From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra.
From mathcomp.analysis Require Import reals sequences exp.
From Fairaudit Require Import Definitions DP T1 T3 T12 Instances.

Set Implicit Arguments.
Unset Strict Implicit.
Unset Printing Implicit Defensive.

Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* Randomized response with e^eps = e; a policy that grants with probability 1/2; a grant is worth 1. *)
Definition coin (R : realType) : bool -> bool -> R := coin_filter (expR 1).
Definition half (R : realType) : R := 2%:R^-1.
Definition lots (R : realType) : unit -> bool -> bool -> R := grant (fun=> half R).
Definition shown (R : realType) : bool -> unit -> R := @no_context R bool_finType.
Definition grants (R : realType) : bool -> bool -> bool -> R := granted 0 1.
Definition gets (R : realType) : bool -> bool -> R := utility (induced (@shown R) (@coin R) (@lots R)) (@grants R).

Lemma k_coin (R : realType) : kernel (@coin R).
Proof. by have [] := @gdp_coin R 1 ler01. Qed.

Lemma dp_coin (R : realType) : every_pair (pure_dp (expR 1)) (@coin R).
Proof.
have k1 : 1 <= expR 1 :> R by rewrite -{1}expR0 ler_expR ler01.
by have [] := T12_sharp k1 (lexx 1).
Qed.

Lemma half_01 (R : realType) : 0 < half R < 1.
Proof. by rewrite /half invr_gt0 ltr0n invf_lt1 ?ltr0n // ltr1n. Qed.

Lemma k_lots (R : realType) : policy (@lots R).
Proof. by apply: policy_grant; apply: test_cst; have /andP[/ltW-> /ltW->] := half_01 R. Qed.

Lemma k_shown (R : realType) : kernel (@shown R). Proof. exact: kernel_no_context. Qed.
Lemma v_grants (R : realType) : valued 0 1 (@grants R). Proof. by apply: granted_valued; apply: ler01. Qed.
Lemma grants_ge0 (R : realType) u x a : 0 <= @grants R u x a. Proof. by case/andP: (v_grants R u x a). Qed.

Lemma gets_half (R : realType) x a : gets R x a = half R.
Proof. by rewrite /gets utility_grant ?expect_cst; [rewrite add0r subr0 mul1r|exact: k_coin|exact: k_coin]. Qed.

Lemma gets_gt0 (R : realType) x a : 0 < gets R x a.
Proof. by rewrite gets_half; case/andP: (half_01 R). Qed.

Lemma floor_gets (R : realType) : has_floor (half R * 1) (gets R).
Proof. by move=> x a; rewrite gets_half mulr1. Qed.

Example T3_gdp_applies (R : realType) : local_le (logistic (logit (half R) + 2%:R * 1) / half R) (gets R).
Proof.
have [_ d] := @gdp_coin R 1 ler01.
exact: (T3_gdp (@k_shown R) (@k_coin R) (@k_lots R) (@logistic_distribution R) ltr01 (@v_grants R) (granted_free _ _) (half_01 R) d (@floor_gets R)).
Qed.

Example T1_paper_log_applies (R : realType) x a a' : ln (gets R x a / gets R x a') <= 1 + ln (1 + (0 + 0 * 1) / half R).
Proof.
have /andP[h0 _] := half_01 R.
have dp0 : every_pair (dp (expR 1) 0) (@coin R) by move=> b b'; apply/pure_dp_dp; apply: dp_coin.
have alike u y b b' : `|@grants R u y b - @grants R u y b'| <= 0 by rewrite subrr normr0.
have fl : has_floor (half R) (gets R) by move=> y b; rewrite -[half R]mulr1; apply: floor_gets.
exact: (T1_paper_log (@k_shown R) (@k_coin R) (@k_lots R) x a a' ler01 (lexx 0) (@v_grants R) alike (lexx 0) ler01 dp0 h0 fl).
Qed.

Example T2_log_applies (R : realType) x a a' : ln (gets R x a / gets R x a') <= 1.
Proof.
exact: (T2_log (@k_shown R) (@k_lots R) (@grants_ge0 R) (granted_free _ _) (@dp_coin R) (gets_gt0 R x a) (gets_gt0 R x a')).
Qed.

Example T12_tanh_log_applies (R : realType) x a a' :
  tanh (ln (gets R x a / gets R x a') / 2%:R) <= tanh (ln 1 / 2%:R) * tanh (1 / 2%:R).
Proof.
have own y c b b' : response (@shown R) (@lots R) (@grants R) y c b <= 1 * response (@shown R) (@lots R) (@grants R) y c b'.
  by rewrite mul1r.
exact: (T12_tanh_log (@k_shown R) (@k_coin R) (@k_lots R) ler01 (lexx 1) (@grants_ge0 R) (granted_free _ _) own (@dp_coin R)
  (gets_gt0 R x a) (gets_gt0 R x a')).
Qed.

Example logistic_distribution_applies (R : realType) : distribution (@logistic R) (@logit R).
Proof. exact: logistic_distribution. Qed.

Example gdp_logistic_applies (R : realType) a a' : gdp (@logistic R) (@logit R) (2%:R * 1) (coin R a) (coin R a').
Proof. by apply: gdp_logistic; [exact: k_coin|exact: k_coin|exact: dp_coin|exact: dp_coin]. Qed.

Example gdp_coin_applies (R : realType) : every_pair (gdp (@logistic R) (@logit R) (2%:R * 1)) (coin_filter (expR 1)).
Proof. by have [] := @gdp_coin R 1 ler01. Qed.

(* A filter that releases nothing has every Renyi privacy. *)
Definition silent (R : realType) : bool -> unit -> R := @no_context R bool_finType.
Definition quiet_lots (R : realType) : unit -> unit -> bool -> R := grant (fun=> half R).
Definition quiet (R : realType) : bool -> bool -> R := utility (induced (@shown R) (@silent R) (@quiet_lots R)) (@grants R).

Lemma k_quiet (R : realType) : policy (@quiet_lots R).
Proof. by apply: policy_grant; apply: test_cst; have /andP[/ltW-> /ltW->] := half_01 R. Qed.

Lemma floor_quiet (R : realType) : has_floor (half R * 1) (quiet R).
Proof.
move=> x a; rewrite /quiet utility_grant ?expect_cst; try exact: kernel_no_context.
by rewrite add0r subr0 mul1r mulr1.
Qed.

Lemma silent_renyi (R : realType) (a rho : R) : 1 < a -> 0 <= rho -> every_pair (renyi_le a rho) (@silent R).
Proof.
move=> a1 r0 b b'; split=> [c /eqP|]; first by rewrite /silent /no_context oner_eq0.
have p0 : 0 <= (a - 1) * rho by rewrite mulr_ge0 // subr_ge0 ltW.
by rewrite big_unit /pw /silent /no_context oner_eq0 ln1 !mulr0 expR0 mulr1 -{1}expR0 ler_expR.
Qed.

Lemma one_two (R : realType) : 1 < 2%:R :> R. Proof. by rewrite ltr1n. Qed.

Example T3_renyi_applies (R : realType) : local_le (expR ((2%:R - 1) * 1 / 2%:R) * expR (- ln (half R) / 2%:R)) (quiet R).
Proof.
have /andP[h0 h1] := half_01 R.
exact: (T3_renyi (@k_shown R) (@kernel_no_context R _) (@k_quiet R) ltr01 (@v_grants R) (granted_free _ _) h0 (@floor_quiet R)
  (one_two R) (silent_renyi (one_two R) ler01)).
Qed.

Example T3_renyi_reversed_applies (R : realType) :
  local_le ((1 - expR (- 1) * expR (2%:R / (2%:R - 1) * ln (1 - half R))) / half R) (quiet R).
Proof.
have /andP[h0 h1] := half_01 R.
exact: (T3_renyi_reversed (@k_shown R) (@kernel_no_context R _) (@k_quiet R) ltr01 (@v_grants R) (granted_free _ _) h0 (@floor_quiet R)
  (one_two R) h1 (silent_renyi (one_two R) ler01)).
Qed.

Definition small (R : realType) : R := ln 2%:R / 2%:R.
Lemma small_gt0 (R : realType) : 0 < small R. Proof. by rewrite /small divr_gt0 ?ltr0n // ln_gt0 // one_two. Qed.
Lemma small_lt (R : realType) : small R < ln (half R)^-1.
Proof.
have l0 : 0 < ln 2%:R :> R by rewrite ln_gt0 // one_two.
by rewrite /small /half invrK ltr_pdivr_mulr ?ltr0n // ltr_pmulr // one_two.
Qed.

Lemma silent_zcdp (R : realType) : every_pair (zcdp (small R)) (@silent R).
Proof. by move=> b b' a a1; apply: silent_renyi => //; rewrite mulr_ge0 ?(ltW (small_gt0 R)) // ltW // (lt_trans ltr01). Qed.

Example T3_zcdp_applies (R : realType) : local_le (expR (2%:R * Num.sqrt (small R * ln (half R)^-1) - small R)) (quiet R).
Proof.
have /andP[h0 h1] := half_01 R.
exact: (T3_zcdp (@k_shown R) (@kernel_no_context R _) (@k_quiet R) ltr01 (@v_grants R) (granted_free _ _) h0 (@floor_quiet R)
  (small_gt0 R) (small_lt R) (@silent_zcdp R)).
Qed.

Example T3_zcdp_reversed_applies (R : realType) :
  local_le ((1 - expR (- (Num.sqrt (small R) + Num.sqrt (ln (1 - half R)^-1)) ^+ 2)) / half R) (quiet R).
Proof.
have /andP[h0 h1] := half_01 R.
exact: (T3_zcdp_reversed (@k_shown R) (@kernel_no_context R _) (@k_quiet R) ltr01 (@v_grants R) (granted_free _ _) h0 (@floor_quiet R)
  (small_gt0 R) h1 (@silent_zcdp R)).
Qed.
