(* SHA-256 (FIPS 180-4) of a list of bytes, as 64 hexadecimal digits.  Int32 has the same arithmetic in JavaScript. *)

let k = [|
  0x428a2f98l; 0x71374491l; 0xb5c0fbcfl; 0xe9b5dba5l; 0x3956c25bl; 0x59f111f1l; 0x923f82a4l; 0xab1c5ed5l;
  0xd807aa98l; 0x12835b01l; 0x243185bel; 0x550c7dc3l; 0x72be5d74l; 0x80deb1fel; 0x9bdc06a7l; 0xc19bf174l;
  0xe49b69c1l; 0xefbe4786l; 0x0fc19dc6l; 0x240ca1ccl; 0x2de92c6fl; 0x4a7484aal; 0x5cb0a9dcl; 0x76f988dal;
  0x983e5152l; 0xa831c66dl; 0xb00327c8l; 0xbf597fc7l; 0xc6e00bf3l; 0xd5a79147l; 0x06ca6351l; 0x14292967l;
  0x27b70a85l; 0x2e1b2138l; 0x4d2c6dfcl; 0x53380d13l; 0x650a7354l; 0x766a0abbl; 0x81c2c92el; 0x92722c85l;
  0xa2bfe8a1l; 0xa81a664bl; 0xc24b8b70l; 0xc76c51a3l; 0xd192e819l; 0xd6990624l; 0xf40e3585l; 0x106aa070l;
  0x19a4c116l; 0x1e376c08l; 0x2748774cl; 0x34b0bcb5l; 0x391c0cb3l; 0x4ed8aa4al; 0x5b9cca4fl; 0x682e6ff3l;
  0x748f82eel; 0x78a5636fl; 0x84c87814l; 0x8cc70208l; 0x90befffal; 0xa4506cebl; 0xbef9a3f7l; 0xc67178f2l |]

let ( +: ) = Int32.add and ( ^: ) = Int32.logxor and ( &: ) = Int32.logand
let shift = Int32.shift_right_logical
let turn x n = Int32.logor (shift x n) (Int32.shift_left x (32 - n))

let block (h : int32 array) (bytes : Bytes.t) at =
  let w = Array.init 64 (fun i -> if i < 16 then Bytes.get_int32_be bytes (at + (4 * i)) else 0l) in
  for i = 16 to 63 do
    let s0 = turn w.(i - 15) 7 ^: turn w.(i - 15) 18 ^: shift w.(i - 15) 3 in
    let s1 = turn w.(i - 2) 17 ^: turn w.(i - 2) 19 ^: shift w.(i - 2) 10 in
    w.(i) <- w.(i - 16) +: s0 +: w.(i - 7) +: s1
  done;
  let v = Array.copy h in
  for i = 0 to 63 do
    let a = v.(0) and e = v.(4) in
    let s1 = turn e 6 ^: turn e 11 ^: turn e 25 and s0 = turn a 2 ^: turn a 13 ^: turn a 22 in
    let t1 = v.(7) +: s1 +: ((e &: v.(5)) ^: (Int32.lognot e &: v.(6))) +: k.(i) +: w.(i) in
    let t2 = s0 +: ((a &: v.(1)) ^: (a &: v.(2)) ^: (v.(1) &: v.(2))) in
    Array.blit v 0 v 1 7;
    v.(4) <- v.(4) +: t1;
    v.(0) <- t1 +: t2
  done;
  Array.iteri (fun i x -> h.(i) <- h.(i) +: x) v

let hexadecimal (s : char list) : char list =
  let n = List.length s in
  let bytes = Bytes.make ((n + 72) / 64 * 64) '\000' in
  List.iteri (Bytes.set bytes) s;
  Bytes.set bytes n '\128';
  Bytes.set_int64_be bytes (Bytes.length bytes - 8) (Int64.mul 8L (Int64.of_int n));
  let h = [| 0x6a09e667l; 0xbb67ae85l; 0x3c6ef372l; 0xa54ff53al; 0x510e527fl; 0x9b05688cl; 0x1f83d9abl; 0x5be0cd19l |] in
  for i = 0 to (Bytes.length bytes / 64) - 1 do block h bytes (64 * i) done;
  List.of_seq (String.to_seq (String.concat "" (Array.to_list (Array.map (Printf.sprintf "%08lx") h))))
