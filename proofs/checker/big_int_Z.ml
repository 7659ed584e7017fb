(* In JavaScript: what extraction uses of zarith's Big_int_Z, by BigInt; bigint.js has the primitives. *)

type big_int
external big_int_of_int : int -> big_int = "fairaudit_of_int"
external int_of_big_int : big_int -> int = "fairaudit_to_int"
external add_big_int : big_int -> big_int -> big_int = "fairaudit_add"
external sub_big_int : big_int -> big_int -> big_int = "fairaudit_sub"
external mult_big_int : big_int -> big_int -> big_int = "fairaudit_mult"
external minus_big_int : big_int -> big_int = "fairaudit_minus"
external truncated : big_int -> big_int -> big_int = "fairaudit_truncated"
external compare_big_int : big_int -> big_int -> int = "fairaudit_compare"
external eq_big_int : big_int -> big_int -> bool = "fairaudit_eq"
external le_big_int : big_int -> big_int -> bool = "fairaudit_le"
external lt_big_int : big_int -> big_int -> bool = "fairaudit_lt"
external shift_left_big_int : big_int -> int -> big_int = "fairaudit_left"
external shift_right_big_int : big_int -> int -> big_int = "fairaudit_right"

let zero_big_int = big_int_of_int 0
let unit_big_int = big_int_of_int 1
let sign_big_int x = compare_big_int x zero_big_int
let abs_big_int x = if lt_big_int x zero_big_int then minus_big_int x else x
let max_big_int x y = if lt_big_int x y then y else x
let add_int_big_int n x = add_big_int (big_int_of_int n) x
let mult_int_big_int n x = mult_big_int (big_int_of_int n) x
let succ_big_int x = add_big_int x unit_big_int

(* x = q y + r, with 0 <= r < |y| *)
let quomod_big_int x y =
  let q = truncated x y in
  let r = sub_big_int x (mult_big_int q y) in
  if le_big_int zero_big_int r then (q, r)
  else if lt_big_int zero_big_int y then (sub_big_int q unit_big_int, add_big_int r y)
  else (succ_big_int q, sub_big_int r y)

let div_big_int x y = fst (quomod_big_int x y)
let mod_big_int x y = snd (quomod_big_int x y)
let rec gcd_big_int x y = if eq_big_int y zero_big_int then abs_big_int x else gcd_big_int y (sub_big_int x (mult_big_int (truncated x y) y))
