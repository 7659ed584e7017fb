//Provides: fairaudit_of_int const
function fairaudit_of_int(n) { return BigInt(n); }
//Provides: fairaudit_to_int const
function fairaudit_to_int(x) { return Number(x); }
//Provides: fairaudit_add const
function fairaudit_add(x, y) { return x + y; }
//Provides: fairaudit_sub const
function fairaudit_sub(x, y) { return x - y; }
//Provides: fairaudit_mult const
function fairaudit_mult(x, y) { return x * y; }
//Provides: fairaudit_minus const
function fairaudit_minus(x) { return -x; }
//Provides: fairaudit_truncated const
function fairaudit_truncated(x, y) { return x / y; }
//Provides: fairaudit_compare const
function fairaudit_compare(x, y) { return x < y ? -1 : x > y ? 1 : 0; }
//Provides: fairaudit_eq const
function fairaudit_eq(x, y) { return x === y ? 1 : 0; }
//Provides: fairaudit_le const
function fairaudit_le(x, y) { return x <= y ? 1 : 0; }
//Provides: fairaudit_lt const
function fairaudit_lt(x, y) { return x < y ? 1 : 0; }
//Provides: fairaudit_left const
function fairaudit_left(x, n) { return x << BigInt(n); }
//Provides: fairaudit_right const
function fairaudit_right(x, n) { return x >> BigInt(n); }
//Provides: fairaudit_provide
//Requires: caml_string_of_jsbytes, caml_jsbytes_of_string, caml_call_gen
function fairaudit_provide(check) {
  // From the bytes of a certificate, one character for each, to what is found: a line for each statement.
  globalThis.fairauditVerified = function (bytes) {
    return caml_jsbytes_of_string(caml_call_gen(check, [caml_string_of_jsbytes(bytes)]));
  };
}
