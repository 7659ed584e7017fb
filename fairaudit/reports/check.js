// Recomputes the figures of the certificate in this page from its table, in whole numbers (BigInt), as docs/certificate.md describes them.
// Works in slices, so that the page stays responsive. Text from the certificate is only ever set as text.
"use strict";
(() => {
  const PAIRS = 400000;
  const WORK = 4000000;
  const PAGE = 10;
  const CHOICES = 300;
  const ONE = [1n, 1n], ZERO = [0n, 1n], INF = [1n, 0n];
  const at = (id) => document.getElementById(id);

  // Rationals [n, d] with d >= 0; [1, 0] is infinite.
  const abs = (a) => (a < 0n ? -a : a);
  const gcd = (a, b) => { while (b) [a, b] = [b, a % b]; return a; };
  const lcm = (a, b) => (a === b ? a : (a / gcd(a, b)) * b);
  const lowest = ([n, d]) => { if (d === 0n) return INF; const g = gcd(abs(n), d); return [n / g, d / g]; };
  const rational = (s) => { if (s === "inf") return INF; const [n, d] = s.split("/"); return [BigInt(n), d === undefined ? 1n : BigInt(d)]; };
  const text = (r) => { const [n, d] = lowest(r); return d === 0n ? "inf" : d === 1n ? String(n) : n + "/" + d; };
  const compare = (a, b) => { const l = a[0] * b[1], r = b[0] * a[1]; return l < r ? -1 : l > r ? 1 : 0; };
  const add = (a, b) => (a[1] === b[1] ? [a[0] + b[0], a[1]] : [a[0] * b[1] + b[0] * a[1], a[1] * b[1]]);
  const minus = (a, b) => add(a, [-b[0], b[1]]);
  const times = (a, b) => [a[0] * b[0], a[1] * b[1]];
  const over = (a, b) => times(a, [b[1], b[0]]);
  const most = (a, b) => (compare(a, b) < 0 ? b : a);
  const least = (a, b) => (compare(a, b) > 0 ? b : a);
  const quotient = (a, b) => (b[0] === 0n ? (a[0] === 0n ? ONE : INF) : over(a, b));
  const total = (values) => values.reduce((sum, v) => lowest(add(sum, v)), ZERO);
  const whole = (list) => { const d = list.reduce((m, r) => lcm(m, r[1]), 1n); return [list.map((r) => r[0] * (d / r[1])), d]; };
  const sum = (list) => list.reduce((a, b) => a + b, 0n);

  function decimals([n, d], places = 4) {  // some significant digits
    if (d === 0n) return "infinite";
    if (n === 0n) return "0";
    if (n < 0n) return "-" + decimals([-n, d], places);
    let power = String(n).length - String(d).length;
    let digits = 0n;
    const least_ = 10n ** BigInt(places - 1);
    for (let i = 0; i < 3; i++) {
      const shift = places - 1 - power;
      const top = shift >= 0 ? n * 10n ** BigInt(shift) : n, bottom = shift >= 0 ? d : d * 10n ** BigInt(-shift);
      digits = (2n * top + bottom) / (2n * bottom);
      if (digits < least_) power--; else if (digits >= 10n * least_) power++; else break;
    }
    return String(Number(digits + "e" + (power - places + 1)));
  }

  // log of a ratio, enclosed: [lo, hi] in units of 2^-bits.
  function series(n, d, bits) {  // 2 atanh(n/d) for 0 <= n/d <= 1/3
    const z = (n << bits) / d, square = (z * z) >> bits;
    let power = z, result = 0n, k = 1n;
    while (power > 0n) { result += power / k; power = (power * square) >> bits; k += 2n; }
    return 2n * result;
  }
  function logarithm([n, d], bits) {
    let k = 0n, top = n, bottom = d;
    while (top > 2n * bottom) { bottom <<= 1n; k++; }
    const slack = 4n * bits + 8n * (k + 1n);
    const middle = series(top - bottom, top + bottom, bits) + k * series(1n, 3n, bits);
    return [middle - slack, middle + slack];
  }
  function logText(r) {
    if (compare(r, ONE) === 0) return ["0", "0"];
    if (r[1] === 0n) return ["inf", "inf"];
    for (let bits = 128n; ; bits *= 2n) {
      const [lo, hi] = logarithm(r, bits).map((v) => (v * 10n ** 12n) >> bits);
      if (lo === hi) return [lo, lo + 1n].map((v) => { const s = String(v).padStart(13, "0"); return s.slice(0, -12) + "." + s.slice(-12); });
    }
  }
  function logAtMost(r, limit) {
    if (r[1] === 0n) return false;
    if (compare(r, ONE) === 0) return true;
    if (limit[0] === 0n) return false;
    for (let bits = 64n; ; bits *= 2n) {
      const [lo, hi] = logarithm(r, bits), low = (limit[0] << bits) / limit[1];
      if (hi <= low) return true;
      if (lo > low + 1n) return false;
    }
  }

  // SHA-256, so that it also runs where the page is not a secure context.
  function sha256(bytes) {
    const K = [], H = [];
    const primes = [];
    for (let c = 2; primes.length < 64; c++) if (primes.every((p) => c % p)) primes.push(c);
    const bits = (x) => Math.floor((x - Math.floor(x)) * 4294967296) | 0;
    primes.forEach((p, i) => { K.push(bits(Math.cbrt(p))); if (i < 8) H.push(bits(Math.sqrt(p))); });
    const length = bytes.length, padded = new Uint8Array(((length + 72) >> 6) << 6), view = new DataView(padded.buffer);
    padded.set(bytes); padded[length] = 128;
    view.setUint32(padded.length - 8, Math.floor(length / 536870912)); view.setUint32(padded.length - 4, (length << 3) >>> 0);
    const w = new Int32Array(64), rot = (x, n) => (x >>> n) | (x << (32 - n));
    return { padded, view, H, K, w, rot, done: 0 };
  }
  function hashBlocks(s, until) {
    const { view, H, K, w, rot } = s;
    for (; s.done < until; s.done += 64) {
      for (let i = 0; i < 64; i++) {
        if (i < 16) { w[i] = view.getInt32(s.done + 4 * i); continue; }
        const a = w[i - 15], b = w[i - 2];
        w[i] = (w[i - 16] + (rot(a, 7) ^ rot(a, 18) ^ (a >>> 3)) + w[i - 7] + (rot(b, 17) ^ rot(b, 19) ^ (b >>> 10))) | 0;
      }
      let [a, b, c, d, e, f, g, h] = H;
      for (let i = 0; i < 64; i++) {
        const x = (h + (rot(e, 6) ^ rot(e, 11) ^ rot(e, 25)) + ((e & f) ^ (~e & g)) + K[i] + w[i]) | 0;
        const y = ((rot(a, 2) ^ rot(a, 13) ^ rot(a, 22)) + ((a & b) ^ (a & c) ^ (b & c))) | 0;
        h = g; g = f; f = e; e = (d + x) | 0; d = c; c = b; b = a; a = (x + y) | 0;
      }
      [a, b, c, d, e, f, g, h].forEach((v, i) => { H[i] = (H[i] + v) | 0; });
    }
  }

  // Give the page a turn when 40 ms have passed.
  let since = performance.now();
  const channel = new MessageChannel();
  const turn = () => new Promise((resolve) => { channel.port1.onmessage = () => { since = performance.now(); resolve(); }; channel.port2.postMessage(0); });
  const late = () => performance.now() - since > 40;

  const sorted = (v) => (Array.isArray(v) ? v.map(sorted) : v !== null && typeof v === "object"
    ? Object.fromEntries(Object.keys(v).sort().map((k) => [k, sorted(v[k])])) : v);
  const canonical = (v) => JSON.stringify(sorted(v)).replace(/[^ -~]/g, (c) => "\\u" + c.charCodeAt(0).toString(16).padStart(4, "0"));
  const same = (a, b) => canonical(a) === canonical(b);

  // What is wrong with the shape of a value, by a JSON Schema as certificate.schema.json uses it; nothing if it fits. The rows of the
  // table, which may be many, are put on the list `later`, if there is one.
  const SCHEMA = "certificate.schema.json";
  const EFFORT = 5e8;  // products of digits in greatest common divisors: about two seconds
  const TOO_LONG = "its numbers are too long for a page";
  let effort = 0;
  const kindOf = (v) => (v === null ? "null" : Array.isArray(v) ? "array" : Number.isInteger(v) ? "integer" : typeof v);
  function misfit(value, schema, where, later) {
    if (typeof schema === "boolean") return schema ? "" : where + " must not be there";
    const own = kindOf(value), fits = (s, v) => !misfit(v === undefined ? value : v, s, where, null);
    const first = (list) => { for (const found of list) if (found) return found; return ""; };
    const known = {
      $ref: (s) => misfit(value, s.slice(2).split("/").reduce((v, k) => v[k], SCHEMA), where, later),
      type: (s) => ([].concat(s).some((t) => t === own || (t === "number" && own === "integer")) ? "" : where + " must be of the type " + [].concat(s).join(" or ")),
      const: (s) => (same(s, value) ? "" : where + " must be " + JSON.stringify(s)),
      enum: (s) => (s.some((v) => same(v, value)) ? "" : where + " is none of the values that may stand there"),
      pattern: (s) => {
        if (own !== "string") return "";
        if (!new RegExp(s, "u").test(value)) return where + " is not written as the format wants it";
        const [n, d] = value.slice(value.lastIndexOf(" ") + 1).split("/");
        if (d && (effort += n.length * d.length) > EFFORT) throw new Error(TOO_LONG);
        return d && gcd(abs(BigInt(n)), BigInt(d)) !== 1n ? where + " is not in lowest terms" : "";
      },
      maxLength: (s) => (own === "string" && [...value].length > s ? where + " is too long" : ""),
      minimum: (s) => (own === "integer" && value < s ? where + " is too small" : ""),
      maximum: (s) => (own === "integer" && value > s ? where + " is too great" : ""),
      minItems: (s) => (own === "array" && value.length < s ? where + " lacks an entry" : ""),
      maxItems: (s) => (own === "array" && value.length > s ? where + " has an entry too many" : ""),
      uniqueItems: (s) => (s && own === "array" && new Set(value.map(canonical)).size < value.length ? where + " lists something twice" : ""),
      prefixItems: (s) => (own === "array" ? first(s.map((t, i) => (i < value.length ? misfit(value[i], t, where + "[" + i + "]", later) : ""))) : ""),
      items: (s) => {
        if (own !== "array") return "";
        const rest = value.map((v, i) => [v, s, where + "[" + i + "]"]).slice((schema.prefixItems || []).length);
        if (later && where === "subject.table.rows") { later.push(...rest); return ""; }
        for (const [v, t, place] of rest) { const found = misfit(v, t, place, later); if (found) return found; }
        return "";
      },
      contains: (s) => (own === "array" && !value.some((v) => fits(s, v)) ? where + " lacks an entry" : ""),
      required: (s) => (own === "object" ? first(s.map((k) => (Object.hasOwn(value, k) ? "" : where + " lacks the key " + JSON.stringify(k)))) : ""),
      properties: (s) => (own === "object" ? first(Object.keys(s).map((k) => (Object.hasOwn(value, k) ? misfit(value[k], s[k], where ? where + "." + k : k, later) : ""))) : ""),
      additionalProperties: (s) => (own === "object" ? first(Object.keys(value).map((k) => (Object.hasOwn(schema.properties || {}, k) ? ""
        : s === false ? where + " has the unknown key " + JSON.stringify(k) : misfit(value[k], s, where + "." + k, later)))) : ""),
      propertyNames: (s) => (own === "object" ? first(Object.keys(value).map((k) => (fits(s, k) ? "" : where + " has the unknown key " + JSON.stringify(k)))) : ""),
      minProperties: (s) => (own === "object" && Object.keys(value).length < s ? where + " lacks a key" : ""),
      maxProperties: (s) => (own === "object" && Object.keys(value).length > s ? where + " has a key too many" : ""),
      dependentRequired: (s) => (own === "object" ? first(Object.keys(s).map((k) => (Object.hasOwn(value, k) ? known.required(s[k]) : ""))) : ""),
      dependentSchemas: (s) => (own === "object" ? first(Object.keys(s).map((k) => (Object.hasOwn(value, k) ? misfit(value, s[k], where, later) : ""))) : ""),
      allOf: (s) => first(s.map((t) => misfit(value, t, where, later))),
      anyOf: (s) => (s.some((t) => fits(t)) ? "" : where + " has none of the shapes that may stand there"),
      oneOf: (s) => (s.filter((t) => fits(t)).length === 1 ? "" : where + " has none of the shapes that may stand there"),
      not: (s) => (fits(s) ? where + " must not have this shape" : ""),
      if: (s) => { const next = fits(s) ? schema.then : schema.else; return next === undefined ? "" : misfit(value, next, where, later); },
      then: () => "",
      else: () => "",
      $defs: () => "",
    };
    return first(Object.keys(schema).map((key) => (Object.hasOwn(known, key) ? known[key](schema[key]) : "the page does not know the rule " + key)));
  }
  async function malformed(source, doc) {
    // What JSON.parse hides: repeated keys, and numbers that are no integers as the format writes them.
    const tokens = source.matchAll(/"(?:[^"\\]|\\.)*"(\s*:)?|-?[0-9][0-9.eE+-]*/g);
    let keys = 0;
    for (const [token, colon] of tokens) {
      if (colon) keys++;
      else if (token[0] !== '"' && !/^(0|[1-9][0-9]{0,17})$/.test(token)) return "the number " + token.slice(0, 40) + " is not written as the format wants it";
    }
    const count = (v) => (v === null || typeof v !== "object" ? 0 : (Array.isArray(v) ? 0 : Object.keys(v).length) + Object.values(v).reduce((t, w) => t + count(w), 0));
    if (late()) await turn();
    if (keys !== count(doc)) return "an object repeats a key";
    if (late()) await turn();
    const later = [], found = misfit(doc, SCHEMA, "", later);
    if (found) return found;
    for (const [row, schema, where] of later) { const wrong = misfit(row, schema, where, null); if (wrong) return wrong; if (late()) await turn(); }
    return "";
  }

  async function digest(table) {
    const parts = [canonical(table.header) + "\n"];
    for (const row of table.rows) { parts.push(canonical(row) + "\n"); if (late()) await turn(); }
    const state = sha256(new TextEncoder().encode(parts.join("")));
    while (state.done < state.padded.length) { hashBlocks(state, Math.min(state.done + 65536, state.padded.length)); if (late()) await turn(); }
    return state.H.map((v) => (v >>> 0).toString(16).padStart(8, "0")).join("");
  }

  // The law: cells with integer weights w of sum s, over the denominator d of counts, mass, utility g and expectation e.
  function cell(x, a, weights, g, mass) {
    const [w, d] = whole(weights), s = sum(w);
    const known = g.map((v) => (v === null ? ZERO : v)), [top, bottom] = whole(known);
    return { x, a, w, d, s, g, mass: mass || [s, d], e: [w.reduce((t, v, u) => t + v * top[u], 0n), s * bottom] };
  }
  async function readLaw(header, rows) {
    const shared = header.utility && header.utility.map(rational), cells = [];
    for (const row of rows) {
      if ("unknown" in row) continue;
      const g = shared || row.utility.map((v) => (v === null ? null : rational(v)));
      const mass = header.population === "counts" ? null : header.population === "weights" ? rational(row.mass) : ONE;
      cells.push(cell(row.context, row.group, row.weights.map(rational), g, mass));
      if (late()) await turn();
    }
    return lawOf(header.contexts, header.groups, cells, header, shared);
  }
  function lawOf(contexts, groups, cells, header, shared) {
    const byContext = [];
    for (const c of cells) { const last = byContext[byContext.length - 1]; if (last && last[0].x === c.x) last.push(c); else byContext.push([c]); }
    const law = { contexts, groups, cells, byContext, population: header.population, columns: header.columns, decisions: header.decisions, shared };
    law.complete = cells.length === contexts.length * groups.length;
    const masses = new Map();
    for (const c of cells) masses.set(c.a, (masses.get(c.a) || []).concat([c]));
    law.byGroup = [...masses].sort((p, q) => p[0] - q[0]);
    law.positive = law.byGroup.filter(([, list]) => list.some((c) => c.mass[0] > 0n));
    law.lacking = law.population === "equal" && !law.complete;
    law.global = law.lacking || law.positive.length < 2 ? [] : law.positive;
    return law;
  }

  // Filters: rows of integers over a denominator, along the axis of each factor.
  const product = (lists) => lists.reduce((made, list) => made.flatMap((head) => list.map((part) => head.concat(part))), [[]]);
  function readFilter(factors) {
    const list = factors.map((f) => {
      const [flat, d] = whole(f.rows.flat().map(rational));
      return { rows: f.rows.map((r, i) => flat.slice(i * r.length, (i + 1) * r.length)), d, inputs: f.inputs, outputs: f.outputs };
    });
    return { list, inputs: product(list.map((f) => f.inputs)), outputs: product(list.map((f) => f.outputs)), d: list.reduce((p, f) => p * f.d, 1n),
      rows() { return list.reduce((made, f) => made.flatMap((head) => f.rows.map((r) => head.flatMap((p) => r.map((q) => p * q)))), [[1n]]); } };
  }
  async function through(filter, vectors) {  // vectors: one per released value, mixed into one per input
    let block = vectors, sizes = filter.list.map((f) => f.outputs.length);
    for (const [axis, f] of filter.list.entries()) {
      const before = sizes.slice(0, axis).reduce((p, n) => p * n, 1), after = sizes.slice(axis + 1).reduce((p, n) => p * n, 1), made = [];
      for (let i = 0; i < before; i++) for (const row of f.rows) {
        for (let k = 0; k < after; k++) {
          const target = vectors[0].map(() => 0n);
          row.forEach((p, j) => { if (p) { const v = block[(i * row.length + j) * after + k]; for (let u = 0; u < v.length; u++) target[u] += p * v[u]; } });
          made.push(target);
        }
        if (late()) await turn();
      }
      sizes[axis] = f.rows.length; block = made;
    }
    return block;
  }
  const key = (label) => JSON.stringify(label);

  async function readPolicy(header, rows) {
    const shared = header.utility && header.utility.map(rational), decisions = header.decisions.length;
    const shown = rows.filter((r) => "weights" in r), listed = rows.filter((r) => !("weights" in r));
    const group = readFilter(header.filters.group), context = header.filters.context && readFilter(header.filters.context);
    const [flat, scale] = whole(shown.flatMap((r) => r.weights.map(rational)));
    const place = new Map(shown.map((r, i) => [r.context + "," + r.group, flat.slice(i * decisions, (i + 1) * decisions)]));
    const find = (labels) => { const m = new Map(labels.map((l, i) => [key(l), i])); return (l) => m.get(key(l)); };
    const xOf = find(header.contexts), aOf = find(header.groups), nothing = Array(decisions).fill(0n);
    const contexts = context ? context.inputs : header.contexts, released = context ? context.outputs : header.contexts;
    const all = group.rows(), reach = group.outputs.map((_, j) => all.some((r) => r[j] > 0n));
    const size = contexts.length * Math.max(group.inputs.length, group.outputs.length) * decisions * (context ? released.length : 1);
    if (size > WORK) return null;
    const row = (x, a) => place.get(xOf(x) + "," + aOf(a)) || nothing;
    const policy = { group, context, contexts, released, scale, reach, all, groups: group.inputs, row, decisions };
    policy.raw = [];  // per released context, a vector for each released group
    policy.mixed = [];  // the same per true group
    for (const x of released) {
      const block = group.outputs.map((a) => row(x, a));
      policy.raw.push(block); policy.mixed.push(await through(group, block));
      if (late()) await turn();
    }
    const cross = async (blocks, count) => {  // mix over released contexts
      if (!context) return blocks;
      const flatBlocks = blocks.map((b) => b.flat()), made = await through(context, flatBlocks);
      return made.map((v) => Array.from({ length: count }, (_, a) => v.slice(a * decisions, (a + 1) * decisions)));
    };
    policy.response = await cross(policy.raw, group.outputs.length);
    const induced = await cross(policy.mixed, group.inputs.length), true_ = new Map(listed.map((r) => [r.true_context + "," + r.true_group, r]));
    const entry = (x, a) => true_.get(x + "," + a);
    policy.g = (x, a) => shared || entry(x, a).utility.map(rational);
    const make = async (rowOf) => {
      const cells = [];
      for (let x = 0; x < contexts.length; x++) for (let a = 0; a < group.inputs.length; a++) {
        const mass = header.population === "weights" ? rational(entry(x, a).mass) : ONE;
        cells.push(cell(x, a, rowOf(x, a).map((w) => [w, 1n]), policy.g(x, a), mass));
        if (late()) await turn();
      }
      return lawOf(contexts, group.inputs, cells, header, shared);
    };
    const law = await make((x, a) => induced[x][a]);
    const known = contexts.every((x) => xOf(x) !== undefined) && group.inputs.every((a) => aOf(a) !== undefined)
      && contexts.every((x) => group.inputs.every((a) => place.has(xOf(x) + "," + aOf(a))));
    policy.unfiltered = known ? await make((x, a) => row(contexts[x], group.inputs[a])) : null;
    law.policy = policy;
    return law;
  }

  // Metrics. A block is a list of [group, value]; the first greatest quotient wins.
  const named = (columns, label) => Object.fromEntries(columns.map((c, i) => [c, label[i]]));
  async function greatest(blocks, contrast = quotient) {
    let best = null;
    for (const block of blocks) {
      let top = block.list[0][1], low = top;
      for (const [, v] of block.list) { if (compare(v, top) > 0) top = v; if (compare(v, low) < 0) low = v; }
      const r = contrast(top, low);
      if (!best || compare(r, best.r) > 0) best = { r, block, top, low };
      if (late()) await turn();
    }
    if (!best) return null;
    const list = best.block.list, first = (test) => list.find(([, v]) => test(v));
    let pair = [list[0], list[1]];
    if (compare(best.r, contrast === minus ? ZERO : ONE) !== 0) {
      pair = best.r[1] === 0n ? [first((v) => v[0] > 0n), first((v) => v[0] === 0n)]
        : [first((v) => compare(v, best.top) === 0), first((v) => compare(v, best.low) === 0)];
    }
    return { r: best.r, block: best.block, higher: pair[0], lower: pair[1] };
  }
  function stated(law, found, valued, apart = false) {
    if (!found) return null;
    const w = {};
    if (found.block.x !== undefined) w.context = named(law.columns.context, law.contexts[found.block.x]);
    if (found.block.u !== undefined) w.decision = law.decisions[found.block.u];
    w.higher = named(law.columns.group, law.groups[found.higher[0]]); w.lower = named(law.columns.group, law.groups[found.lower[0]]);
    w[valued] = [text(found.higher[1]), text(found.lower[1])];
    return apart ? { value: text(found.r), witness: w } : { ratio: text(found.r), log: logText(found.r), witness: w };
  }
  async function distance(law, blocks) {  // blocks: {x, list: [[group, w, s]]}
    const pairs = blocks.reduce((n, b) => n + b.list.length * (b.list.length - 1) / 2, 0), two = law.decisions.length <= 2;
    if (!blocks.length) return null;
    if (!two && pairs * law.decisions.length > PAIRS) return undefined;
    let best = null;
    const keep = (v, block, i, j) => { if (!best || compare(v, best.v) > 0) best = { v, block, i, j }; };
    for (const block of blocks) {
      const list = block.list;
      if (two) {
        const p = list.map(([, w, s]) => [w[0], s]);
        let top = p[0], low = p[0];
        for (const v of p) { top = most(top, v); low = least(low, v); }
        const end = (v) => (compare(v, top) === 0 ? 1 : compare(v, low) === 0 ? -1 : 0);
        if (compare(top, low) === 0) keep(ZERO, block, 0, 1);
        else {
          const ends = p.map(end), i = ends.findIndex((e, n) => e && ends.indexOf(-e, n + 1) > 0);
          keep(minus(top, low), block, i, ends.indexOf(-ends[i], i + 1));
        }
        if (late()) await turn();
        continue;
      }
      for (let i = 0; i < list.length; i++) {
        for (let j = i + 1; j < list.length; j++) {
          const [, p, s] = list[i], [, q, t] = list[j];
          let above = 0n;
          for (let u = 0; u < p.length; u++) { const v = p[u] * t - q[u] * s; if (v > 0n) above += v; }
          keep([above, s * t], block, i, j);
        }
        if (late()) await turn();
      }
    }
    const [a, p, s] = best.block.list[best.i], [b, q, t] = best.block.list[best.j], w = {};
    if (best.block.x !== undefined) w.context = named(law.columns.context, law.contexts[best.block.x]);
    w.higher = named(law.columns.group, law.groups[a]); w.lower = named(law.columns.group, law.groups[b]);
    w.decisions = law.decisions.filter((_, u) => p[u] * t > q[u] * s);
    return { value: text(best.v), witness: w };
  }
  const localBlocks = (law) => law.byContext.filter((b) => b.length > 1);
  async function groupLaws(law) {
    const made = [];
    for (const [a, list] of law.global) {
      const mass = total(list.map((c) => c.mass));
      const mean = over(total(list.map((c) => times(c.mass, c.e))), mass);
      const shares = [];
      for (let u = 0; u < law.decisions.length; u++) { shares.push(total(list.map((c) => times(c.mass, [c.w[u], c.s])))); if (late()) await turn(); }
      const [w] = whole(shares);
      made.push({ a, mean, w, s: sum(w) });
    }
    return made;
  }
  async function ratios(law, groups, contrast = quotient) {
    const local = await greatest(localBlocks(law).map((b) => ({ x: b[0].x, list: b.map((c) => [c.a, c.e]) })), contrast);
    const overall = await greatest(groups.length ? [{ list: groups.map((g) => [g.a, g.mean]) }] : [], contrast);
    return { local: stated(law, local, "expectations", contrast === minus), global: stated(law, overall, "expectations", contrast === minus) };
  }
  async function apart(law, groups) {  // differences, which do not depend on the origin of the utility
    const found = await ratios(law, groups, minus);
    return { local_difference: found.local, global_difference: found.global };
  }
  async function overUnits(law, units, contrast = quotient) {  // the greatest contrast of the means over units, cell by cell as they are compared
    const lists = units[Symbol.iterator](), mean = (c) => {
      const draws = lists.next().value, sums = draws.map(([n, rows]) => {
        const [g, d] = whole(c.g.map((v) => v || ZERO));
        return [BigInt(n) * rows.reduce((t, k, u) => t + BigInt(k) * g[u], 0n), d * BigInt(rows.reduce((t, k) => t + k, 0))];
      });
      return over(total(sums), [draws.reduce((t, [n]) => t + BigInt(n), 0n), 1n]);
    };
    const blocks = localBlocks(law).map((b) => ({ x: b[0].x, list: b.map((c) => [c.a, mean(c)]) }));
    return stated(law, await greatest(blocks, contrast), "expectations", contrast === minus);
  }
  async function measure(law, groups) {
    const blocks = localBlocks(law), each = law.decisions.map((_, u) => u);
    const signed = law.cells.some((c) => c.g.some((v) => v !== null && v[0] < 0n)) || (law.shared || []).some((v) => v[0] < 0n);
    const found = signed ? { local: null, global: null } : await ratios(law, groups);
    found.equalized_odds = await distance(law, blocks.map((b) => ({ x: b[0].x, list: b.map((c) => [c.a, c.w, c.s]) })));
    found.demographic_parity = await distance(law, groups.length ? [{ list: groups.map((g) => [g.a, g.w, g.s]) }] : []);
    const chances = blocks.flatMap((b) => each.map((u) => ({ x: b[0].x, u, list: b.map((c) => [c.a, [c.w[u], c.s]]) })));
    if (signed) return { ...found, local_supremum: null, global_supremum: null };
    found.local_supremum = stated(law, await greatest(chances), "probabilities");
    const overall = groups.length ? each.map((u) => ({ u, list: groups.map((g) => [g.a, [g.w[u], g.s]]) })) : [];
    found.global_supremum = stated(law, await greatest(overall), "probabilities");
    return found;
  }
  async function constants(law) {
    let gamma = null, m = null, gap = ZERO, tau = null;
    const see = (v) => { if (v !== null) { gamma = gamma ? most(gamma, v) : v; m = m ? least(m, v) : v; } };
    if (law.shared) law.shared.forEach(see);
    for (const block of law.byContext) {
      if (!law.shared) {
        for (const c of block) c.g.forEach(see);
        law.decisions.forEach((_, u) => {
          const given = block.map((c) => c.g[u]).filter((v) => v !== null);
          if (given.length > 1) gap = most(gap, minus(given.reduce(most), given.reduce(least)));
        });
      }
      if (block.length > 1) for (const c of block) tau = tau ? least(tau, c.e) : c.e;
      if (late()) await turn();
    }
    return { gamma, m, tau, lipschitz: gap };
  }
  function notCompared(law) {
    const present = law.contexts.map(() => new Set()), out = [];
    for (const c of law.cells) present[c.x].add(c.a);
    law.contexts.forEach((x, i) => {
      if (present[i].size < law.groups.length) out.push({ context: x, groups: law.groups.filter((_, a) => !present[i].has(a)), reason: "no decisions recorded" });
    });
    law.contexts.forEach((x, i) => { if (present[i].size < 2) out.push({ context: x, reason: "fewer than two groups" }); });
    const good = new Set(law.positive.map(([a]) => a)), weightless = law.byGroup.filter(([a]) => !good.has(a));
    if (weightless.length) out.push({ groups: weightless.map(([a]) => law.groups[a]), reason: "no population" });
    if (!law.global.length) out.push({ quantity: "global", reason: law.lacking ? "a group is missing in a context and no population was given" : "fewer than two groups" });
    return out;
  }
  // Given the true label: rates of positive decisions among those with the positive true label, and among the others.
  const KINDS = ["true_positive_rate", "false_positive_rate"], OVERALL = "_overall", ODDS = ["equal_opportunity", "equalized_odds_true_label"];
  const DIFFERENCES = ODDS.concat(ODDS.map((name) => name + OVERALL));
  const LACKING = ["no decisions with the positive true label", "no decisions with another true label"];
  async function givenTruth(law, rows, truths, positive) {
    const own = truths.indexOf(positive.truth), places = positive.decision.map((label) => law.decisions.indexOf(label));
    const given = { sums: own >= 0 && !places.includes(-1) && places.every((u, i) => i === 0 || u > places[i - 1]) && places.length > 0, rates: {}, differences: {}, left: [] };
    if (!given.sums) return given;
    const cells = [];
    for (const row of rows) {
      const parts = row.truth.map((list) => list.map(rational));
      given.sums = given.sums && parts.length === truths.length && parts.every((p) => p.length === law.decisions.length && p.every((v) => v[0] >= 0n))
        && row.weights.every((w, u) => compare(total(parts.map((p) => p[u])), rational(w)) === 0);
      if (!given.sums) return given;
      const share = (wanted) => {
        const lists = parts.filter((_, t) => (t === own) === wanted);
        return { k: total(lists.flatMap((p) => places.map((u) => p[u]))), n: total(lists.flat()) };
      };
      cells.push({ x: row.context, a: row.group, of: [share(true), share(false)] });
      if (late()) await turn();
    }
    const byGroup = law.groups.map((_, a) => cells.filter((c) => c.a === a)).filter((list) => list.length);
    const pooled = byGroup.map((list) => ({ a: list[0].a, of: KINDS.map((_, i) => ({ k: total(list.map((c) => c.of[i].k)), n: total(list.map((c) => c.of[i].n)) })) }));
    const place = (c) => ({ ...(c.x === undefined ? {} : { context: named(law.columns.context, law.contexts[c.x]) }), group: named(law.columns.group, law.groups[c.a]) });
    const widest = {};
    for (const [i, kind] of KINDS.entries()) {
      for (const [suffix, list] of [["", cells]].concat(law.columns.context.length ? [[OVERALL, pooled]] : [])) {
        const known = list.filter((c) => c.of[i].n[0] > 0n).map((c) => ({ ...c, rate: over(c.of[i].k, c.of[i].n) })), blocks = new Map();
        given.rates[kind + suffix] = known.map((c) => ({ ...place(c), rate: text(c.rate) }));
        for (const c of list) blocks.set(c.x, (blocks.get(c.x) || []).concat([c]));
        let best = null;
        for (const [x, all] of blocks) {
          const block = known.filter((c) => c.x === x), at_ = { quantity: kind + suffix, ...(x === undefined ? {} : { context: law.contexts[x] }) };
          const lacking = all.filter((c) => c.of[i].n[0] === 0n).map((c) => law.groups[c.a]);
          if (lacking.length) given.left.push({ ...at_, groups: lacking, reason: LACKING[i] });
          if (block.length < 2 && all.length > 1) given.left.push({ ...at_, reason: "fewer than two groups" });
          if (block.length < 2) continue;
          const high = block.reduce((t, c) => (compare(c.rate, t.rate) > 0 ? c : t)), low = block.reduce((t, c) => (compare(c.rate, t.rate) < 0 ? c : t));
          const v = minus(high.rate, low.rate);
          if (!best || compare(v, best.v) > 0) best = { v, high, low: v[0] === 0n ? block[1] : low };
          if (late()) await turn();
        }
        const where = best && place(best.high);
        widest[kind + suffix] = best && { v: best.v, entry: { value: text(best.v), witness: { ...("context" in where ? { context: where.context } : {}), rate: kind,
          higher: where.group, lower: place(best.low).group, rates: [text(best.high.rate), text(best.low.rate)] } } };
      }
    }
    for (const suffix of law.columns.context.length ? ["", OVERALL] : [""]) {
      const [t, f] = KINDS.map((kind) => widest[kind + suffix]);
      given.differences[ODDS[0] + suffix] = t && t.entry;
      given.differences[ODDS[1] + suffix] = t && f && (compare(f.v, t.v) > 0 ? f : t).entry;
    }
    return given;
  }
  function independent(law) {
    if (!law.complete) return false;
    const [mass] = whole(law.cells.map((c) => c.mass)), rows = new Map(), columns = new Map(), all = sum(mass);
    law.cells.forEach((c, i) => { rows.set(c.x, (rows.get(c.x) || 0n) + mass[i]); columns.set(c.a, (columns.get(c.a) || 0n) + mass[i]); });
    return law.cells.every((c, i) => mass[i] * all === rows.get(c.x) * columns.get(c.a));
  }

  // Bounds of a policy behind filters: docs/certificate-policy.md.
  const hockeyStick = (p, q, k, d) => [p.reduce((t, v, i) => { const e = v * k[1] - k[0] * q[i]; return e > 0n ? t + e : t; }, 0n), k[1] * d];
  async function everyPair(rows, d, multipliers, holds, skip) {
    if (rows.length * (rows.length - 1) * (rows[0] || []).length * Math.max(1, multipliers.length) > WORK) return undefined;
    for (const p of rows) for (const q of rows) {
      if (p === q || (skip && skip(p, q))) continue;
      if (!multipliers.some((k) => holds(k, hockeyStick(p, q, k, d)))) return false;
      if (late()) await turn();
    }
    return true;
  }
  async function extremes(policy, blind) {  // the policy floor, and R0
    let low = null, raw = ONE;
    const rows = policy.context && policy.context.rows(), d = policy.context ? policy.context.d : 1n;
    for (let x = 0; x < policy.contexts.length; x++) {
      const values = [], seen = rows ? policy.released.map((_, k) => k).filter((k) => rows[x][k] > 0n) : [x];
      for (let j = 0; j < policy.reach.length; j++) {
        if (!policy.reach[j]) continue;
        for (let a = 0; a < (blind ? 1 : policy.groups.length); a++) {
          const [g, bottom] = whole(policy.g(x, a)), worth = (v) => [v.reduce((t, p, u) => t + p * g[u], 0n), policy.scale * bottom];
          for (const k of seen) { const v = worth(policy.raw[k][j]); low = low ? least(low, v) : v; }
          const [n, e] = worth(policy.response[x][j]);
          if (a === 0) values.push([n, e * d]);
        }
        if (late()) await turn();
      }
      raw = most(raw, quotient(values.reduce(most), values.reduce(least)));
    }
    return { floor: low, raw };
  }
  function composition(law) {
    const policy = law.policy, good = law.global.map(([a]) => a), of = new Map(good.map((a) => [a, new Array(policy.contexts.length).fill(ZERO)]));
    for (const c of law.cells) if (of.has(c.a)) of.get(c.a)[c.x] = c.mass;
    const shares = good.map((a) => {
      const [mass] = whole(of.get(a)), all = sum(mass), d = policy.context ? policy.context.d : 1n;
      const rows = policy.context ? policy.context.rows() : null;
      const shown = policy.released.map((_, k) => (rows ? mass.reduce((t, m, x) => t + m * rows[x][k], 0n) : mass[k]));
      return shown.map((v) => [v, all * d]);
    });
    let worst = ONE;
    policy.released.forEach((_, k) => {
      const values = shares.map((s) => s[k]), top = values.reduce(most);
      if (top[0] > 0n) worst = most(worst, quotient(top, values.reduce(least)));
    });
    return worst;
  }

  // The worst policy behind the filters (T13): what each decision under each release adds to the expected utility of a group.
  function contributions(f, local) {
    const { law } = f, { policy } = law, rows = policy.context && policy.context.rows();
    const lists = local ? policy.contexts.map((_, x) => [x, policy.groups.map((_, a) => [a, [policy.g(x, a)]])]) : [[null, law.global.map(([a, list]) => {
      const all = total(list.map((c) => c.mass)), share = list.map((c) => [c.x, over(c.mass, all)]);
      return [a, policy.released.map((_, k) => [...Array(policy.decisions).keys()].map((u) => total(share.map(([x, s]) => {
        const seen = rows ? [rows[x][k], policy.context.d] : x === k ? ONE : ZERO;
        return seen[0] === 0n ? ZERO : times(times(s, seen), policy.g(x, a)[u]);
      }))))];
    })]];
    return lists.map(([x, groups]) => {
      const [flat] = whole(groups.flatMap(([, g]) => g.flat()));
      let at_ = 0;
      return { x, groups: groups.map(([a, g]) => {
        const worth = g.map((row) => row.map(() => flat[at_++]));
        return [a, policy.all[a].flatMap((chance) => worth.map((row) => row.map((v) => chance * v)))];
      }) };
    });
  }
  async function worstPolicies(claim, value, f) {  // no policy exceeds the value, and the worst one for the pair that is named has it
    const { policy } = f.law, local = claim.quantity === "local_ratio_supremum", where = claim.evidence.attained;
    const size = policy.contexts.length * policy.groups.length ** 2 * policy.all[0].length * policy.decisions;
    if (f.doc.subject.table.header.filters.releases || size > WORK) return undefined;
    const blocks = contributions(f, local), infinite = value[1] === 0n, [n, d] = value;
    for (const { groups } of infinite ? [] : blocks) for (const [a, p] of groups) for (const [b, q] of groups) {
      if (a === b) continue;
      let sum_ = 0n;
      p.forEach((row, o) => { let best = null; row.forEach((v, u) => { const c = d * v - n * q[o][u]; if (best === null || c > best) best = c; }); sum_ += best; });
      if (sum_ > 0n) return false;
      if (late()) await turn();
    }
    if (compare(value, ONE) === 0) return where === null;
    if (!where) return false;
    const same_ = (list, label) => list.findIndex((l) => key(l) === key(label));
    const block = blocks.find((b) => b.x === (local ? same_(policy.contexts, where.context) : null)), group = (label) => block && block.groups.find(([a]) => a === same_(policy.groups, label));
    const high = group(where.higher), low = group(where.lower);
    if (!high || !low || high === low || local !== (where.context !== null)) return false;
    let gap = 0n, bottom = 0n;
    for (const [o, row] of high[1].entries()) {
      let best = null;
      row.forEach((v, u) => {
        const q = low[1][o][u], c = infinite ? [-q, v] : [d * v - n * q, q];
        if (best === null || c[0] > best[0] || (c[0] === best[0] && c[1] > best[1])) best = c;
      });
      gap += best[0]; bottom += best[1];
    }
    return gap === 0n && bottom > 0n;
  }
  async function anyUtility(claim, value, f) {  // no policy exceeds the value, whatever the utility of the declared range is
    const { law, declared } = f, { policy } = law, { gamma, m } = declared, local = claim.quantity === "local_ratio";
    if (!gamma || !m || value[1] === 0n) return false;
    if (f.doc.subject.declared.by_context || f.doc.subject.table.header.filters.releases) return undefined;
    const width = minus(gamma, m), gap = least(f.effective.gap, width), right = times(m, minus(value, ONE));
    const holds = (_, h) => compare(add(gap, times(minus(width, gap), h)), right) <= 0;
    if (local) return everyPair(policy.all, policy.group.d, [value], holds);
    if (policy.contexts.length * policy.all[0].length * law.global.length ** 2 > WORK) return undefined;
    const joint = law.global.map(([a, list]) => {
      const all = total(list.map((c) => c.mass)), shares = new Map(list.map((c) => [c.x, over(c.mass, all)]));
      return policy.contexts.flatMap((_, x) => policy.all[a].map((chance) => times(shares.get(x) || ZERO, [chance, policy.group.d])));
    });
    const [flat, scale] = whole(joint.flat()), width_ = joint[0].length;
    return everyPair(joint.map((_, i) => flat.slice(i * width_, (i + 1) * width_)), scale, [value], holds);
  }

  // Which claims there are: relation, source, quantities, scopes, and what the certificate has to be about.
  const LAW = "this law", POLICIES = "any policy behind this filter", FLOORED = POLICIES + " that keeps the declared floor";
  const GROUP_FILTERS = "this policy and context filter, any group filter at most this epsilon that releases the same values";
  const CONTEXT_FILTERS = "this policy and group filter, any context filter that releases these contexts";
  const NEAR = POLICIES + " within the declared drift of this one", RANGE = POLICIES + ", any utility of the declared range";
  const RANGE_FLOORED = FLOORED + ", any utility of the declared range";
  const CLASS = "every utility of the class", RATIOS = ["local_ratio", "global_ratio"], POPULATION = "population at confidence ", ONE_SIDED = "population, one-sided at confidence ";
  const WHOEVER_IN_LAW = LAW + ", whoever the unknown are";
  const OBJECTIONS = ["whoever the unknown are", "with the declared hidden context", "within the declared drift", "whatever the undecided meant"];
  const LAW_DRIFTING = LAW + ", " + OBJECTIONS[2], ONE_SIDED_DRIFTING = ONE_SIDED + ", " + OBJECTIONS[2];
  const under = (scope, objection) => scope + ", " + objection, HIDDEN = OBJECTIONS[1], WHATEVER = OBJECTIONS[3];
  const objection = (scope) => OBJECTIONS.find((o) => scope.endsWith(", " + o)), generic = (scope) => scope.replace(/^(population(?:, one-sided)? at confidence )[^,]+/, "$1");
  const EXPECTED = ["local_difference", "global_difference"];
  const QUANTITIES = [...RATIOS, ...EXPECTED, ...DIFFERENCES, "demographic_parity", "equalized_odds", "local_ratio_supremum", "global_ratio_supremum"];
  const KNOWN = [
    ["=", "enumeration", ["local_ratio", "global_ratio", "local_difference", "global_difference", "demographic_parity", "equalized_odds", "equal_opportunity", "equalized_odds_true_label", "equal_opportunity_overall", "equalized_odds_true_label_overall"], [LAW], "any"],
    ["=", "T6", ["local_ratio_supremum", "global_ratio_supremum"], [LAW], "any"],
    ["<=", "T7", ["demographic_parity", "equalized_odds"], [LAW], "any"],
    ["<=", "T5", ["global_ratio"], [LAW], "any"],
    ["<=", "T15", RATIOS, [WHOEVER_IN_LAW], "any"],
    [">=", "T15", RATIOS, [WHOEVER_IN_LAW], "any"],
    ["<=", "T19", RATIOS, [under(LAW, WHATEVER)], "any"],
    [">=", "T19", RATIOS, [under(LAW, WHATEVER)], "any"],
    ["<=", "T19", RATIOS, [under(POPULATION, WHATEVER), under(ONE_SIDED, WHATEVER)], "sample"],
    [">=", "T19", RATIOS, [under(POPULATION, WHATEVER), under(ONE_SIDED, WHATEVER)], "sample"],
    ["<=", "T2", ["local_ratio"], [POLICIES], "policy"],
    ["<=", "T12", ["local_ratio"], [GROUP_FILTERS], "policy"],
    ["<=", "T4", ["local_ratio"], [POLICIES], "policy"],
    ["<=", "T3", ["local_ratio"], [GROUP_FILTERS], "policy"],
    ["<=", "floor", ["local_ratio"], [LAW, FLOORED], "policy"],
    ["<=", "T1", ["local_ratio"], [LAW, FLOORED], "policy"],
    ["<=", "T1-paper", ["local_ratio"], [LAW, FLOORED], "policy"],
    ["<=", "T3", ["local_ratio"], [LAW, FLOORED], "policy"],
    ["<=", "T5", ["global_ratio"], [POLICIES], "policy"],
    ["<=", "T5-decision", ["global_ratio"], [POLICIES], "policy"],
    ["<=", "T8", ["local_ratio"], [CONTEXT_FILTERS], "policy"],
    ["=", "T13", ["local_ratio_supremum", "global_ratio_supremum"], [POLICIES], "policy"],
    ["=", "T13", ["local_ratio_supremum", "global_ratio_supremum"], [NEAR], "policy"],
    ["=", "T13", ["local_ratio_supremum", "global_ratio_supremum"], [FLOORED], "policy"],
    ["<=", "T13", ["local_ratio_supremum", "global_ratio_supremum"], [FLOORED], "policy"],
    ["<=", "T13", RATIOS, [RANGE_FLOORED], "policy"],
    ["<=", "T13", RATIOS, [RANGE], "policy"],
    ["=", "T16", ["local_ratio_radius", "local_log_radius", "global_ratio_radius", "global_log_radius", "local_ratio_factor", "local_log_factor", "global_ratio_factor", "global_log_factor"], [LAW], "table"],
    [">=", "T16", ["local_ratio_radius", "local_log_radius", "global_ratio_radius", "global_log_radius", "local_ratio_factor", "local_log_factor", "global_ratio_factor", "global_log_factor"], [LAW], "table"],
    [">=", "T16", ["local_ratio_radius", "local_log_radius", "global_ratio_radius", "global_log_radius"], [ONE_SIDED], "sample"],
    ["<=", "T16", RATIOS, [LAW_DRIFTING], "table"],
    [">=", "T16", RATIOS, [LAW_DRIFTING], "table"],
    ["<=", "T16", RATIOS, [ONE_SIDED_DRIFTING], "sample"],
    [">=", "T16", RATIOS, [ONE_SIDED_DRIFTING], "sample"],
    ["<=", "T3", RATIOS, [CLASS], "class"],
    ["<=", "lp-dual", RATIOS, [CLASS], "class"],
    [">=", "T14", ["local_hidden_context", "global_hidden_context"], [LAW, POPULATION, ONE_SIDED], "any"],
    [">=", "T14", RATIOS, [under(LAW, HIDDEN), under(POPULATION, HIDDEN), under(ONE_SIDED, HIDDEN)], "any"],
  ];
  const BY_REGION = { pairs: ["pair-exact"], contrasts: ["symmetric-betting"], paired: ["paired-betting"] };  // which name the method of their claims
  const aboutPopulation = (claim) => "interval" in claim.evidence && [POPULATION, ONE_SIDED].some((opening) => claim.scope.startsWith(opening));
  // Of drift: a scope that names a confidence has it after its opening.
  const isScope = (scope, known) => known.startsWith(ONE_SIDED)
    ? scope.startsWith(ONE_SIDED) && scope.endsWith(known.slice(ONE_SIDED.length)) && !OBJECTIONS.some((under) => !known.endsWith(under) && scope.endsWith(under)) : scope === known;
  const listedDrift = (claim) => KNOWN.some(([relation, by, quantities, scopes]) => by === "T16" && relation === claim.relation
    && quantities.includes(claim.quantity) && scopes.some((known) => isScope(claim.scope, known)) && claim.assumptions.length > 0);
  function listed(claim, f) {
    if (claim.by === "T16") return !f.law.policy && listedDrift(claim);
    if (aboutPopulation(claim)) {
      const interval = (f.doc.intervals || {})[claim.evidence.interval];
      const difference = DIFFERENCES.includes(claim.quantity);
      if (difference && (claim.quantity !== claim.evidence.interval || claim.by !== "binomial")) return false;
      const expected = EXPECTED.includes(claim.quantity) && claim.quantity === claim.evidence.interval;
      return (difference || expected || (RATIOS.includes(claim.quantity) && claim.quantity === claim.evidence.interval + "_ratio")) && [">=", "<="].includes(claim.relation) && interval && claim.scope === (interval.ends === "each" ? ONE_SIDED : POPULATION) + interval.confidence
        && (BY_REGION[interval.region] || ["binomial", interval.method]).includes(claim.by) && claim.assumptions.length > 0;
    }
    const kind = KNOWN.find(([relation, by, quantities, scopes]) => relation === claim.relation && by === claim.by
      && quantities.includes(claim.quantity) && scopes.includes(generic(claim.scope)));
    if (!kind) return false;
    const about = kind[4], policy = Boolean(f.law.policy);
    if ((about === "class" && !f.doc.subject.class) || (about === "policy" && !policy)) return false;
    if (policy && claim.assumptions.length === 0) return false;
    return !("table" in claim.evidence) || claim.evidence.table === f.doc.subject.table.sha256;
  }

  // What ratios can be whatever undecided decisions meant (T19): each mean that is compared with all of them worth the least, and the most.
  function meantEnds(f, local) {
    const { decisions, least: low, most: high } = f.doc.subject.undecided, names = new Set(decisions);
    const is = f.law.decisions.map((u) => names.has(u));
    const valued = (c, worth) => {
      const [top, bottom] = whole(c.g.map((v, u) => (is[u] ? worth : v === null ? ZERO : v)));
      return [c.w.reduce((t, v, u) => t + v * top[u], 0n), c.s * bottom];
    };
    const mean = (list, worth) => over(total(list.map((c) => times(c.mass, valued(c, worth)))), total(list.map((c) => c.mass)));
    const ends = [low, high].map(rational), place = (x, a) => JSON.stringify([x === null ? null : f.law.contexts[x], f.law.groups[a]]);
    if (local) return f.law.byContext.filter((list) => list.length > 1).map((list) => list.map((c) => [place(c.x, c.a), ...ends.map((v) => valued(c, v))]));
    return f.law.global.length ? [f.law.global.map(([a, list]) => [place(null, a), ...ends.map((v) => mean(list, v))])] : [];
  }
  function judgeMeant(claim, f) {
    const value = rational(claim.value), local = claim.quantity === "local_ratio", up = claim.relation === "<=";
    const about = f.doc.subject.undecided, sampled = claim.scope.startsWith("population");
    if (!about || !claim.assumptions.some((text) => text.startsWith("whatever they meant, ") && text.endsWith(` from ${about.least} to ${about.most}`))) return false;
    if (sampled) {
      const interval = (f.doc.intervals || {})[claim.evidence.ends];
      if (!interval || claim.quantity !== claim.evidence.ends + "_ratio") return false;
      if (claim.scope !== under((interval.ends === "each" ? ONE_SIDED : POPULATION) + interval.confidence, WHATEVER)) return false;
      const [lo, hi] = interval.ratio.map(rational);
      return (up ? compare(value, hi) >= 0 : compare(value, ONE) >= 0 && compare(value, lo) <= 0) ? undefined : false;
    }
    const blocks = meantEnds(f, local), pair = claim.evidence.pair;
    if (blocks.reduce((n, b) => n + b.length, 0) > WORK) return undefined;
    let found = ONE;
    for (const block of blocks) {
      if (up) {
        const tops = [...block].sort((p, q) => -compare(p[2], q[2])).slice(0, 2), bottoms = [...block].sort((p, q) => compare(p[1], q[1])).slice(0, 2);
        for (const p of tops) for (const q of bottoms) if (p !== q) found = most(found, quotient(p[2], q[1]));
      } else {
        const high = block.map((e) => e[1]).reduce(most), low = block.map((e) => e[2]).reduce(least);
        if (compare(high, low) > 0) found = most(found, quotient(high, low));
      }
    }
    if (compare(value, found) !== 0 || (pair === null) !== (compare(found, ONE) === 0)) return false;
    if (pair === null) return true;
    const name = (group) => JSON.stringify([pair.context, group]), side = up ? 2 : 1;
    const named = blocks.map((block) => [pair.higher, pair.lower].map((g) => block.find((e) => e[0] === name(g)))).find(([p, q]) => p && q && p !== q);
    return Boolean(named) && compare(quotient(named[0][side], named[1][3 - side]), found) === 0;
  }
  function judgedMeant(target, f, atMost) {  // of a table by both ends, which are attained
    const sampled = target.judged.startsWith(POPULATION);
    if (target.unit === "difference" || (sampled ? !f.together : target.judged !== under("this table", WHATEVER))) return false;
    const interval = (f.doc.intervals || {})[target.quantity], openings = sampled ? [POPULATION, ONE_SIDED] : [LAW];
    if (target.estimand !== (sampled && interval && interval.units ? "mean over units" : undefined)) return false;
    const own = f.doc.claims.filter((c) => c.by === "T19" && c.quantity === target.quantity + "_ratio" && openings.some((o) => c.scope.startsWith(o)));
    const end = (relation, otherwise) => own.filter((c) => c.relation === relation).map((c) => rational(c.value))[0] || otherwise;
    const exceeds = !atMost(end(">=", ONE)), within = atMost(end("<=", INF));
    const open = !sampled && own.length === 2 ? "depends" : "inconclusive";
    return target.verdict === (exceeds === within ? open : exceeds ? "exceeds" : "within") ? (sampled ? undefined : true) : false;
  }

  // Each rule says true, false, or undefined when it is not recomputed here.
  async function judgeClaim(claim, f) {
    if (!listed(claim, f)) return false;
    if (claim.by === "T16") return undefined;
    if (claim.by === "T14") return hiddenContext(claim, f);
    if (claim.by === "T19") return f.metric(claim.quantity) === null ? false : judgeMeant(claim, f);
    const value = rational(claim.value), by = claim.by, metric = f.metric(by === "T13" ? claim.quantity.replace("_supremum", "") : claim.quantity);
    if (metric === undefined) return undefined;
    if (metric === null) return false;
    if (objection(claim.scope)) return undefined;
    if (aboutPopulation(claim)) {
      const interval = f.doc.intervals[claim.evidence.interval], [lo, hi] = (interval.ratio || interval.difference).map(rational);
      const fits = claim.relation === "<=" ? compare(value, hi) >= 0 : compare(value, interval.ratio ? ONE : ZERO) >= 0 && compare(value, lo) <= 0;
      return fits ? undefined : false;
    }
    if (by === "T13") return compare(metric, value) > 0 ? false : claim.scope === POLICIES ? worstPolicies(claim, value, f) : claim.scope === RANGE ? anyUtility(claim, value, f) : undefined;
    if (claim.relation === "=") return compare(value, metric) === 0;
    if (compare(metric, value) > 0) return false;
    if (by === "T7") {
      const r = f.metric(claim.quantity === "equalized_odds" ? "local_ratio_supremum" : "global_ratio_supremum");
      const bound = r[1] === 0n ? ONE : over(minus(r, ONE), add(r, ONE));
      return compare(value, bound) === 0 && text(r) === claim.evidence.supremum;
    }
    if (claim.scope === CLASS) {
      if (claim.quantity !== f.doc.subject.class.quantity + "_ratio") return false;
      return by === "T3" ? f.closedForm(claim, value) : undefined;
    }
    if (by === "T5" && claim.scope === LAW) return compare(value, f.metric("local_ratio")) === 0 && independent(f.law);
    return judgeBound(claim, value, f);
  }
  function hiddenContext(claim, f) {  // what an unrecorded factor would have to be, or what a declared one leaves of a ratio
    const name = claim.quantity.split("_")[0], sampled = claim.scope.startsWith("population"), interval = (f.doc.intervals || {})[name];
    const metric = f.metric(name + "_ratio"), scope = claim.scope.replace(", " + HIDDEN, "");
    if (metric === null || metric === undefined) return metric === null ? false : undefined;
    if (sampled && (!interval || !interval.ratio || scope !== (interval.ends === "each" ? ONE_SIDED : POPULATION) + interval.confidence)) return false;
    const seen = sampled ? rational(interval.ratio[0]) : metric, value = rational(claim.value), given = claim.evidence.hidden_context;
    const good = given ? leaves(given, seen, value) : frontier(claim.evidence.frontier, seen, value);
    return good && sampled ? undefined : good;
  }
  function leaves(given, seen, value) {
    const k = rational(given.k), infinite = given.m === "inf", m = infinite ? ONE : rational(given.m), km = times(k, m);
    if (compare(k, ONE) < 0 || compare(m, ONE) < 0) return false;
    const part = infinite ? (given.direction === "lower" ? (compare(k, ONE) === 0 ? ONE : ZERO) : over(ONE, k))
      : { both: () => over(add(m, k), add(ONE, km)), higher: () => over(minus(add(m, k), ONE), km), lower: () => over(k, add(minus(km, m), ONE)) }[given.direction]();
    return compare(value, seen[1] === 0n ? (part[0] > 0n ? INF : ONE) : most(ONE, times(seen, part))) === 0;
  }
  function frontier(levels, seen, value) {
    const TWO = [2n, 1n], small = [1n, 1000000n], fits = (b, q) => compare(add(times(b, b), ONE), times(TWO, times(b, q))) <= 0;
    let last = ZERO;
    if (!levels.length || compare(rational(levels[0].to), ONE) !== 0 || compare(rational(levels[0].balanced), value) !== 0) return false;
    return levels.every((level) => {
      const to = rational(level.to), b = rational(level.balanced);
      if (compare(to, last) <= 0 || compare(seen, to) <= 0) return false;
      last = to;
      if (seen[1] === 0n || b[1] === 0n) return seen[1] === 0n && b[1] === 0n && !level.pairs.length && levels.length === 1;
      const q = over(seen, to);
      let before = q;
      if (1000000n % b[1] !== 0n || compare(b, ONE) < 0 || !fits(b, q) || fits(add(b, small), q)) return false;
      return level.pairs.every(([one, other]) => {
        const k = rational(one), rises = compare(k, before) > 0;
        before = k;
        return rises && compare(rational(other), over(minus(times(q, k), ONE), minus(k, q))) === 0;
      });
    });
  }
  async function judgeBound(claim, value, f) {
    const { policy } = f.law, { gamma, m, gap } = f.effective, blind = gap[0] === 0n, factor = f.factor, finite = factor[1] !== 0n, by = claim.by;
    const multipliers = (claim.evidence.multipliers || []).map(rational), infinite = value[1] === 0n;
    const any = claim.scope === POLICIES, floored = claim.scope === FLOORED;
    if ((any || floored) && f.doc.subject.table.header.filters.releases) return false; // these theorems are about one release
    if (by === "T2") return any && blind && finite && compare(value, factor) >= 0;
    if (by === "T5") return any && blind && finite && independent(f.law) && compare(value, factor) >= 0;
    if (by === "T5-decision") {
      const c = composition(f.law);
      return any && Boolean(f.law.shared) && finite && text(c) === claim.evidence.composition && compare(value, times(factor, c)) >= 0;
    }
    if (by === "T8") {
      if (!policy.context || !f.law.shared) return false;
      const rows = policy.context.rows(), seen = policy.released.map((_, k) => k).filter((k) => rows.some((r) => r[k] > 0n));
      const [g] = whole(f.law.shared), worth = (v) => [v.reduce((t, p, u) => t + p * g[u], 0n), 1n];
      const found = await greatest(seen.map((k) => ({ x: k, list: policy.mixed[k].map((v, a) => [a, worth(v)]) })));
      return compare(value, found.r) >= 0;
    }
    if (by === "T12") {
      const { raw } = await f.extremes();
      const bound = !finite ? raw : raw[1] === 0n ? factor : over(add(ONE, times(raw, factor)), add(raw, factor));
      return blind && text(raw) === claim.evidence.raw_ratio && compare(value, bound) >= 0;
    }
    if (by === "T4") {
      if (!any || !blind || m[0] === 0n) return false;
      const rest = (k) => times(minus(k, ONE), m);
      return infinite || everyPair(policy.all, policy.group.d, multipliers,
        (k, h) => compare(add(k, over(most(ZERO, minus(times(minus(gamma, m), h), rest(k))), m)), value) <= 0);
    }
    if (by === "T3" && claim.scope === GROUP_FILTERS) {
      const tau = (await f.extremes()).floor;
      if (!blind || tau[0] === 0n || compare(tau, gamma) > 0) return false;
      const p = finite ? [factor[0], factor[1]] : [1n, 0n], q = finite ? [factor[1], factor[0]] : [0n, 1n];
      return infinite || multipliers.some((k) => compare(add(k, over(times(gamma, hockeyStick(p, q, k, sum(p))), tau)), value) <= 0);
    }
    if (!["floor", "T1", "T1-paper", "T3"].includes(by)) return undefined; // a theorem that has no rule here is for fairaudit verify
    const tau = floored ? f.declared.tau : claim.scope === LAW ? f.constants.tau : null;
    if (!tau || tau[0] === 0n) return false;
    if (by === "floor") return compare(value, over(gamma, tau)) >= 0;
    if (by === "T1-paper") return finite && compare(value, times(factor, add(ONE, over(gap, tau)))) >= 0;
    if (by === "T1") return infinite || everyPair(policy.all, policy.group.d, multipliers, (k, h) => compare(add(k, over(add(gap, times(h, gamma)), tau)), value) <= 0);
    if (by === "T3") {
      const span = minus(gamma, gap);
      if (compare(tau, span) > 0) return false;
      return infinite || everyPair(policy.all, policy.group.d, multipliers, (k, h) => compare(add(k, over(add(gap, times(span, h)), tau)), value) <= 0);
    }
    return undefined;
  }
  async function closedForm(claim, value, law, of, groups) {
    const gamma = rational(of.gamma), m = rational(of.m), low = most(of.tau === null ? ZERO : rational(of.tau), m);
    if (!of.blind || (of.tau !== null && of.tau_on !== "all") || of.order.length || of.rows.length || of.lipschitz !== null || of.family) return false;
    if (value[1] === 0n) return true;
    const multipliers = claim.evidence.multipliers.map(rational);
    const holds = (k, h) => {
      if (low[0] === 0n) return h[0] === 0n && compare(k, value) <= 0;
      const extra = most(ZERO, minus(times(minus(gamma, m), h), times(minus(k, ONE), m)));
      return compare(add(times(k, low), extra), times(value, low)) <= 0;
    };
    if (of.quantity === "global" && law.contexts.length > 1) {
      const joint = law.global.map(([, list]) => {
        const mass = total(list.map((c) => c.mass)), flat = law.contexts.flatMap(() => law.decisions.map(() => ZERO));
        list.forEach((c) => c.w.forEach((w, u) => { flat[c.x * law.decisions.length + u] = over(times(c.mass, [w, c.s]), mass); }));
        return flat;
      });
      const [all, d] = whole(joint.flat()), size = joint[0].length;
      const rows = joint.map((_, i) => all.slice(i * size, (i + 1) * size));
      return everyPair(rows, d, multipliers, holds, (p, q) => p.every((v, i) => v === q[i]));
    }
    const blocks = of.quantity === "local" ? localBlocks(law).map((b) => b.map((c) => [c.w, c.s])) : [groups.map((g) => [g.w, g.s])];
    for (const block of blocks) {
      const d = block.reduce((t, [, s]) => lcm(t, s), 1n), rows = block.map(([w, s]) => w.map((v) => v * (d / s)));
      const fine = await everyPair(rows, d, multipliers, holds, (p, q) => p.every((v, i) => v === q[i]));
      if (!fine) return fine;
    }
    return true;
  }

  const judgedBy = (target) => target.quantity + (target.unit === "difference" ? "_difference" : "");
  function holdTogether(doc) {  // verdicts about the population: one confidence, which the intervals share
    const judged = doc.targets.filter((t) => t.judged.startsWith(POPULATION)), said = new Set(judged.map((t) => t.judged));
    if (!judged.length) return true;
    if (said.size > 1 || doc.subject.kind === "probabilities") return false;
    const named = judged.map(judgedBy).filter((q) => q in (doc.intervals || {})), each = (q) => doc.intervals[q].ends === "each";
    const names = [...named.filter(each), ...new Set(named.filter((q) => !each(q)))];  // each end by itself: every target has its own error
    const error = (c) => minus(ONE, rational(c)), spent = names.reduce((t, q) => add(t, error(doc.intervals[q].confidence)), ZERO);
    return compare(spent, error(judged[0].judged.slice(POPULATION.length).split(", ")[0])) <= 0;
  }
  function withdrawn(doc) {  // the ratios of a stream that a window contradicts
    if (!doc.changed) return [];
    return doc.changed.quantity === "global" && doc.subject.columns.context.length ? ["global"] : ["local", "global"];
  }
  function overall(doc) {
    const verdicts = doc.targets.map((t) => t.verdict), gone = withdrawn(doc);
    if (gone.length && (!doc.targets.length || doc.targets.some((t) => gone.includes(t.quantity)))) return "changed";
    return ["exceeds", "depends", "inconclusive", "within"].find((v) => verdicts.includes(v)) || "none";
  }
  function withHidden(target, f, atMost) {  // by what the declared factor leaves of the ratio, at the least
    const sampled = target.judged.startsWith(POPULATION), own = f.doc.claims.filter((c) => c.by === "T14" && c.quantity === target.quantity + "_ratio" && c.scope.startsWith("population") === sampled);
    if ((!sampled && !target.judged.startsWith("this table")) || (sampled && !f.together) || target.unit === "difference") return false;
    const interval = (f.doc.intervals || {})[target.quantity];
    if (!own.length || target.estimand !== (sampled && interval && interval.units ? "mean over units" : undefined)) return false;
    const exceeds = own.some((c) => !atMost(rational(c.value)));
    return target.verdict === (exceeds ? "exceeds" : "inconclusive") ? (sampled ? undefined : true) : false;
  }
  function judgeTarget(target, f) {  // true, false, or undefined when it rests on an interval
    const apart_ = target.unit === "difference", key_ = target.quantity + (apart_ ? "_difference" : "_ratio");
    const r = f.metric(key_), limit = rational(target.limit);
    if (r === undefined) return undefined;
    if (!["local", "global"].includes(target.quantity) || !["ratio", "log", "difference"].includes(target.unit)) return false;
    if (apart_ ? !(key_ in f.doc.metrics) : f.constants.m[0] < 0n) return false;  // of utilities below 0 there are differences only
    const atMost = (v) => (target.unit !== "log" ? compare(v, limit) <= 0 : logAtMost(v, limit));
    if (Boolean(f.doc.subject.table.header.unknown) !== (target.judged.split(", ")[1] === OBJECTIONS[0])) return false;
    if (Boolean(f.doc.subject.undecided) !== (objection(target.judged) === WHATEVER)) return false;
    if (objection(target.judged) === WHATEVER) return judgedMeant(target, f, atMost);
    if (objection(target.judged) === HIDDEN) return withHidden(target, f, atMost);
    if (objection(target.judged)) return undefined;
    if (target.judged === "this table") return !("estimand" in target) && target.verdict === (r === null ? "inconclusive" : atMost(r) ? "within" : "exceeds");
    if (!target.judged.startsWith(POPULATION) || !f.together) return false;
    if (!apart_ && withdrawn(f.doc).includes(target.quantity)) return ["changed", "exceeds"].includes(target.verdict) ? undefined : false;
    const interval = (f.doc.intervals || {})[judgedBy(target)];
    if (target.estimand !== (interval && interval.units ? "mean over units" : undefined)) return false;
    let [low, high] = interval ? (interval.ratio || interval.difference).map(rational) : [apart_ ? ZERO : ONE, INF], open = false;
    for (const claim of f.doc.claims) {
      const own = !apart_ && claim.quantity === key_ && claim.relation === "<=", declared = f.doc.subject.declared || {};
      const needs = { T2: [], T5: [], "T5-decision": [], T4: ["gamma", "m"] }[claim.by];
      const floored = claim.scope === FLOORED && "gamma" in declared;
      const any = claim.scope === POLICIES && needs && needs.every((n) => n in declared);
      const range = claim.by === "T13" && "gamma" in declared && "m" in declared && ("lipschitz" in declared || !f.doc.subject.utility.depends_on_group);
      open = open || (own && claim.scope === POLICIES && !needs);
      if (own && (any || floored || range)) high = least(high, rational(claim.value));
    }
    const exceeds = !atMost(low), within = atMost(high);  // both where the ends cross
    return target.verdict === (exceeds === within ? "inconclusive" : exceeds ? "exceeds" : "within") || open ? undefined : false;
  }

  function shownFigures(doc, say) {
    const of = (path) => path.split(".").reduce((v, k) => (v === null || v === undefined ? v : v[k]), doc);
    let wrong = 0, count = 0;
    for (const node of document.querySelectorAll("[data-path]")) { count++; if (node.textContent.trim() !== String(of(node.dataset.path))) wrong++; }
    for (const node of document.querySelectorAll("[data-near]")) {
      count++;
      const exact = of(node.dataset.near), said = node.textContent.trim();
      const close = exact === "inf" ? said === "infinite" : typeof exact === "string" && near(rational(exact), said);
      if (!close) wrong++;
    }
    const tone = document.querySelector(".verdict");
    count++;
    if (!tone || !tone.classList.contains(doc.verdict)) wrong++;
    say("the " + count + " figures of the certificate that stand on this page", wrong === 0, wrong ? wrong + " of them differ from the certificate" : "");
  }
  function near(r, said, sharp = 1000n) {
    const match = /^(\d+)(?:\.(\d+))?(?:e([+-]\d+))?$/.exec(said);
    if (!match) return false;
    const places = (match[2] || "").length, power = Number(match[3] || 0) - places, n = BigInt(match[1] + (match[2] || ""));
    if (Math.abs(power) > 200000) return false;
    const v = power >= 0 ? [n * 10n ** BigInt(power), 1n] : [n, 10n ** BigInt(-power)], gap = minus(r, v);
    return compare([abs(gap[0]) * sharp, gap[1]], r) <= 0;
  }

  async function check(doc) {
    const findings = [], say = (what, good, why) => findings.push({ what, good, why: why || "" });
    shownFigures(doc, say);
    const about = doc.subject, table = about.table;
    if (!table.header) return { findings, law: null };
    const own = { kind: about.kind, columns: about.columns, population: about.population };
    say("the table is of the kind that the certificate names", Object.keys(own).every((k) => same(own[k], table.header[k])));
    const filled = table.rows.filter((row) => "weights" in row).length * table.header.decisions.length;
    say("number of entries of the table", filled === table.cells);
    say("digest of the table", (await digest(table)) === table.sha256);
    const law = about.kind === "policy" ? await readPolicy(table.header, table.rows) : await readLaw(table.header, table.rows);
    if (!law) { say("the law behind the filters", undefined, "too large for this page"); return { findings, law }; }
    law.burden = about.utility.burden === true; law.signed = about.utility.m.startsWith("-");
    await shownRows(law, say);
    const groups = await groupLaws(law), metrics = await measure(law, groups), found = await constants(law);
    const asked = EXPECTED.some((name) => name in doc.metrics);
    if (asked) Object.assign(metrics, await apart(law, groups));
    if (found.m[0] < 0n) say("of utilities below 0 differences are stated", asked && !law.policy && !about.class);
    const stateable = { gamma: text(found.gamma), m: text(found.m), tau: found.tau && text(found.tau), lipschitz: text(found.lipschitz), depends_on_group: found.lipschitz[0] > 0n };
    say("constants of the utility", same(about.utility.burden === true ? { ...stateable, burden: true } : stateable, about.utility));
    const given = table.header.truths ? await givenTruth(law, table.rows, table.header.truths, about.positive) : null;
    if (given) {
      say("the true labels add up to the decisions, and the positive ones are among them", given.sums);
      Object.assign(metrics, given.rates, given.differences);
    }
    for (const [name, metric] of Object.entries(metrics)) {
      say("metric " + name.replace(/_/g, " "), metric === undefined ? undefined : same(metric, doc.metrics[name]), metric === undefined ? "too many pairs for this page" : "");
    }
    if (law.policy) {
      const before = law.policy.unfiltered && await ratios(law.policy.unfiltered, await groupLaws(law.policy.unfiltered));
      say("the policy without its filters", same(before, doc.metrics.unfiltered));
      const worst = (rows) => rows.reduce((w, p) => rows.reduce((v, q) => (p === q ? v : p.reduce((t, e, i) => (e === 0n ? t : most(t, quotient([e, 1n], [q[i], 1n]))), v)), w), ONE);
      const state = (f) => f && { exp_epsilon: text(f.list.reduce((p, x) => { const w = worst(x.rows); return p[1] === 0n || w[1] === 0n ? INF : times(p, w); }, ONE)), attributes: f.list.map((x) => text(worst(x.rows))) };
      law.privacy = { group: state(law.policy.group), context: state(law.policy.context) };
      say("privacy of the filters", same(law.privacy, about.privacy));
    }
    say("what was not compared", same(notCompared(law).concat(given ? given.left : []), doc.not_compared));
    if (about.undecided) {
      const { decisions, least: low, most: high } = about.undecided, all = new Set(table.header.decisions);
      say("what is undecided are decisions of the table, and their range holds every utility", decisions.every((u) => all.has(u)) && decisions.length < all.size
        && compare(rational(low), found.m) <= 0 && compare(rational(high), found.gamma) >= 0 && !table.header.truths && !table.header.unknown && !asked);
    }
    const declared = Object.fromEntries(Object.entries(about.declared || {}).flatMap(([k, v]) => (typeof v === "string" ? [[k, rational(v)]] : [])));
    const value = (m) => (m === undefined ? undefined : m === null ? null : rational("ratio" in m ? m.ratio : m.value));
    const of = { local_ratio: "local", global_ratio: "global", local_ratio_supremum: "local_supremum", global_ratio_supremum: "global_supremum" };
    const { gamma, m, lipschitz, tau } = declared;
    if (about.declared) {
      say("declared constants do not contradict the table", (!gamma || compare(gamma, found.gamma) >= 0) && (!lipschitz || compare(lipschitz, found.lipschitz) >= 0)
        && (!m || compare(m, found.m) <= 0) && (!tau || !found.tau || compare(tau, found.tau) <= 0));
    }
    const twice = (list) => new Set(list).size < list.length;
    say("no claim or target stands twice", !twice(doc.claims.map((c) => JSON.stringify([c.quantity, c.relation, c.by, c.scope])))
      && !twice(doc.targets.map((t) => t.quantity + " " + t.unit)));
    let kept = null;
    const f = {
      doc, law, declared, constants: found, metric: (q) => (QUANTITIES.includes(q) && (of[q] || q) in metrics ? value(metrics[of[q] || q]) : null), together: holdTogether(doc), factor: law.privacy ? rational(law.privacy.group.exp_epsilon) : ONE,
      effective: { gamma: declared.gamma || found.gamma, m: declared.m || found.m, gap: declared.lipschitz || found.lipschitz },
      extremes: async () => { kept = kept || await extremes(law.policy, Boolean(law.shared)); return kept; },
      closedForm: (claim, v) => (about.class ? closedForm(claim, v, law, about.class, groups) : false),
    };
    for (const claim of doc.claims) {
      const good = await judgeClaim(claim, f);
      const why = good !== undefined ? "" : claim.scope.startsWith("population") ? "follows from the interval, which only fairaudit verify checks" : "only fairaudit verify checks this";
      say("claim " + claim.quantity.replace(/_/g, " ") + " " + claim.relation + " " + claim.value.slice(0, 60) + " by " + claim.by + ", about " + claim.scope, good, why);
    }
    const { local, local_difference: between } = doc.intervals || {};
    if (between && between.units) say("the difference of the means over units", between.estimand === "mean over units" && same(await overUnits(law, between.units, minus), between.measured));
    if (local && local.units) say("the ratio of the means over units", local.estimand === "mean over units" && same(await overUnits(law, local.units), local.measured));
    for (const name of Object.keys(doc.intervals || {})) say("interval of the " + (DIFFERENCES.includes(name) ? "difference " + name.replace(/_/g, " ") : EXPECTED.includes(name) ? name.replace("_", " ") : name + " ratio"), undefined, "only fairaudit verify checks this");
    for (const [key, what] of [["preparation", "what was done to the log before it was counted"], ["evaluation", "how answers were read in the evaluation log"], ["spellings", "labels that differ in spelling alone"]]) {
      if (doc.subject[key]) say(what, undefined, "only fairaudit verify checks this");
    }
    for (const t of doc.targets) {
      const good = judgeTarget(t, f);
      say("target " + t.quantity + " " + t.unit + " at most " + t.limit.slice(0, 60) + ": " + t.verdict, good, good === undefined ? "follows from the interval, which only fairaudit verify checks" : "");
    }
    say("the overall verdict follows from the targets", doc.verdict === overall(doc));
    return { findings, law };
  }

  const printable = (s) => s.replace(/[\p{Cc}\p{Cf}\p{Co}\p{Cn}\p{Zl}\p{Zp}]/gu, (c) => "\\u{" + c.codePointAt(0).toString(16) + "}").slice(0, 200);
  function element(tag, content) { const node = document.createElement(tag); node.textContent = content; return node; }
  function report(findings, whole) {
    const box = at("check"), wrong = findings.filter((f) => f.good === false), open = findings.filter((f) => f.good === undefined), good = findings.length - wrong.length - open.length;
    box.textContent = "";
    if (wrong.length) {
      box.dataset.state = "differs";
      box.append(element("strong", "✗ Recomputed in your browser: " + wrong.length + " of " + findings.length + " statements are FALSE. "), "Do not use this page. ");
    } else if (!whole) {
      box.dataset.state = "unknown";
      box.append(element("strong", "The certificate does not hold its table: nothing was recomputed here. "), "Whoever has the table can verify it. ");
    } else {
      box.dataset.state = "agrees";
      box.append(element("strong", "✓ Recomputed in your browser: " + good + " statements agree with the table. "));
      if (open.length) box.append(open.length + " more " + (open.length === 1 ? "is" : "are") + " for fairaudit verify to check. ");
    }
    box.append("A forged page could say this too: ");
    const link = element("a", "how to verify"); link.href = "#verify"; box.append(link, ".");
    const list = at("finding-list");
    list.textContent = "";
    for (const f of [...wrong, ...findings.filter((g) => g.good !== false)].slice(0, 500)) {
      list.append(element("li", (f.good ? "✓ " : f.good === false ? "✗ FALSE: " : "– not recomputed: ") + printable(f.what) + (f.why ? " (" + f.why + ")" : "")));
    }
    at("findings").hidden = false;
    at("findings").open = wrong.length > 0;
  }

  function refuse(why, what) {
    const box = at("check");
    box.textContent = "";
    box.dataset.state = "refused";
    box.append(element("strong", "✗ " + why + ": "), printable(what) + ". Nothing was recomputed. Do not use this page.");
  }

  // The rows of the complete table: those that stand on the page, or, of a table with too many for that, made as they are looked at.
  function lookUp(law) {
    const box = at("lookup");
    if (!box || law.cells.length < 2) return;
    const contextColumns = law.columns.context, name = (label) => printable(label.join(" / "));
    const contexts = law.contexts.map(name), groups = law.groups.map(name), body = at("rows"), written = [...body.children];
    const heads = [...document.querySelectorAll("#complete th")].map((e) => e.textContent), burden = law.burden;
    const percent = columnOf("rate") >= 0, counts = columnOf("decisions") >= 0;
    const amount = (c) => (percent ? (c.e[0] === 0n || compare(c.e, ONE) === 0 ? decimals([100n * c.e[0], c.e[1]]) : Number(decimals([100n * c.e[0], c.e[1]], 3)).toPrecision(3)) + "\u00a0%" : decimals(c.e));
    const best = new Map();
    const bestOf = (c) => {
      if (!best.size) for (const b of law.byContext) best.set(b[0].x, b.map((o) => o.e).reduce(burden ? least : most));
      return best.get(c.x);
    };
    const far = (c) => { const b = bestOf(c); return law.signed ? minus(most(b, c.e), least(b, c.e)) : quotient(most(b, c.e), least(b, c.e)); };
    const make = (c) => {
      const row = document.createElement("tr"), exact = text(c.e), r = far(c), kept = counts ? over([sum(c.w), 1n], [c.d, 1n]) : null;
      const own = c.w.reduce((t, w, u) => (c.g[u] && c.g[u][0] ? t + w : t), 0n);
      const cells = [...(contextColumns.length ? [contexts[c.x]] : []), groups[c.a], ...(counts ? [amountText(kept)] : []),
        ...(counts && percent ? [amountText([own, c.d])] : []), amount(c), compare(c.e, bestOf(c)) === 0 ? "best" : decimals(r), exact.length > 60 ? "(" + exact.length + " characters)" : exact];
      cells.forEach((v, i) => { const cell = document.createElement("td"); cell.append(element("bdi", v)); cell.dataset.l = heads[i]; row.append(cell); });
      return row;
    };
    const list = law.cells.map((c, i) => ({ c, row: written.length ? () => written[i] : () => make(c) }));
    let first = 0, shown = list;
    const draw = () => {
      body.replaceChildren(...shown.slice(first, first + PAGE).map((e) => e.row()));
      at("where").textContent = shown.length ? (first + 1) + " to " + Math.min(first + PAGE, shown.length) + " of " + shown.length.toLocaleString("en") : "nothing found";
      at("back").disabled = first === 0; at("next").disabled = first + PAGE >= shown.length;
    };
    const chosen = (id) => (at(id) && at(id).value !== "" ? Number(at(id).value) : null);
    const choose = () => {
      const words = at("find").value.toLowerCase(), order = at("order").value, x = chosen("context"), pair = [chosen("group"), chosen("against")].filter((a) => a !== null);
      shown = list.filter(({ c }) => (!words || contexts[c.x].toLowerCase().includes(words) || groups[c.a].toLowerCase().includes(words))
        && (x === null || c.x === x) && (!pair.length || pair.includes(c.a)));
      if (order !== "table") {
        const keyed = shown.map((e) => [order === "far" ? far(e.c) : e.c.e, e]);
        keyed.sort((p, q) => (order === "low" ? compare(p[0], q[0]) : compare(q[0], p[0])));
        shown = keyed.map((k) => k[1]);
      }
      const out = at("compared"), two = x === null && contexts.length > 1 ? [] : pair.map((a) => law.cells.find((c) => c.x === (x || 0) && c.a === a)).filter(Boolean);
      out.textContent = "";
      if (two.length === 2 && two[0] !== two[1]) {
        const [p, q] = compare(two[0].e, two[1].e) < 0 ? [two[1], two[0]] : two, r = law.signed ? minus(p.e, q.e) : quotient(p.e, q.e), exact = text(r);
        out.append(element("bdi", groups[p.a]), " " + amount(p) + " against ", element("bdi", groups[q.a]), " " + amount(q) + ": ", element("strong", decimals(r) + (law.signed ? " apart" : " times")), exact.length > 60 ? "" : " (" + exact + ")");
      }
      first = 0; draw();
    };
    let pending = 0;
    at("find").addEventListener("input", () => { clearTimeout(pending); pending = setTimeout(choose, 150); });
    at("order").addEventListener("change", choose);
    const fill = (id, names) => { for (const [i, v] of names.entries()) { const o = element("option", v); o.value = i; at(id).append(o); } at(id).addEventListener("change", choose); };
    if (groups.length <= CHOICES && contexts.length <= CHOICES) {
      if (at("context")) fill("context", contexts);
      fill("group", groups); fill("against", groups);
      at("choice").hidden = false;
    }
    at("back").addEventListener("click", () => { first = Math.max(0, first - PAGE); draw(); });
    at("next").addEventListener("click", () => { first += PAGE; draw(); });
    addEventListener("beforeprint", () => { body.replaceChildren(...list.map((e) => e.row())); });
    addEventListener("afterprint", draw);
    draw();
    if (at("hint")) at("hint").textContent = "Choose a context and groups; printing lists all " + list.length.toLocaleString("en") + " rows.";
    box.hidden = at("turn").hidden = at("all").hidden = false; at("all").open = true;
  }
  const columnOf = (name) => [...document.querySelectorAll("#complete th")].findIndex((e) => e.dataset.is === name);
  function amountText(r) {
    const [n, d] = lowest(r);
    if (d === 1n) return n.toLocaleString("en");
    if (n >= 100n * d) return ((10n * n) / d / 10n).toLocaleString("en") + "." + ((10n * n) / d) % 10n;
    let power = 0;
    while ((10n ** BigInt(power) * n) / d < 1000n && power < 300) power++;
    return String(Number((10n ** BigInt(power) * n) / d + "e-" + power));
  }

  // Whether the rows that stand on the page are those of the table, in its order: exactly where they say so, and rounded where they do not.
  async function shownRows(law, say) {
    const rows = [...document.querySelectorAll("#rows tr")];
    if (!rows.length) return;
    const last = document.querySelectorAll("#complete th").length - 1, rate = columnOf("rate"), decisions = columnOf("decisions");
    const label = (l) => printable(l.join(" / "));
    let wrong = rows.length === law.cells.length ? 0 : 1;
    for (const [i, c] of law.cells.entries()) {
      const cells = rows[i] ? [...rows[i].children].map((e) => e.textContent) : [], exact = cells[last] || "";
      const names = [...(law.columns.context.length ? [law.contexts[c.x]] : []), law.groups[c.a]];
      const fits = names.every((l, k) => !/^[ -~]{0,100}$/.test(l.join(" / ")) || cells[k] === label(l)) && (exact === "in the certificate" || exact === text(c.e))
        && (rate < 0 || near([100n * c.e[0], c.e[1]], (cells[rate] || "").replace(/\s%$/, ""), 200n)) && (decisions < 0 || !/^[0-9,]{1,19}$/.test(cells[decisions]) || cells[decisions] === amountText([sum(c.w), c.d]));
      if (!fits) wrong++;
      if (late()) await turn();
    }
    say("the " + rows.length + " rows of the table that stand on this page", wrong === 0, wrong ? wrong + " of them differ from the table" : "");
  }

  // The program of proofs/checker, which is itself proved, in a worker of its own: a line for each statement, after one with the exit code.
  const VERIFIED = "verified.js";
  const ANSWER = `onmessage = ({ data }) => {
    const bytes = new TextEncoder().encode(data);
    let text = "";
    for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
    postMessage(fairauditVerified(text));
  };`;
  function prove(source) {
    const box = at("proved"), list = at("proved-list");
    const end = (state, bold, rest) => {
      box.textContent = "";
      box.dataset.state = state;
      box.append(element("strong", bold), " " + rest);
      document.documentElement.dataset.proved = state;
    };
    const failed = () => end("unknown", "The verified program could not run in this browser.", "It comes with fairaudit as a command, too.");
    const found = ({ data }) => {
      const [code, ...lines] = data.split("\n"), told = lines.map((line) => [line.slice(0, line.indexOf(": ")), line.slice(line.indexOf(": ") + 2)]);
      const count = (word) => told.filter(([outcome]) => outcome === word).length, wrong = count("FALSE"), good = count("true"), open = count("not covered");
      if (code === "2") end("refused", "✗ The verified program refuses this certificate:", printable(lines.join(" ")) + " Do not use this page.");
      else if (!good && !wrong) end("unknown", "The verified program judges nothing of this certificate.", "Use fairaudit verify.");
      else if (wrong) end("differs", "✗ By the verified program " + wrong + " of " + told.length + " statements are FALSE.", "Do not use this page.");
      else end("agrees", "✓ By the verified program " + good + " statements are true.", open ? open + " are not checked by it: use fairaudit verify." : "");
      for (const [outcome, what] of told.slice(0, 500)) {
        list.append(element("li", ({ true: "✓ ", FALSE: "✗ FALSE: " }[outcome] || "– not checked in this page, use fairaudit verify: ") + printable(what)));
      }
      at("proofs").hidden = false;
      const top = at("check"), bad = ["refused", "differs"];
      if (bad.includes(box.dataset.state) && !bad.includes(top.dataset.state)) { top.dataset.state = box.dataset.state; top.textContent = box.textContent; document.documentElement.dataset.checked = box.dataset.state; }
    };
    box.hidden = false;
    box.textContent = "The verified program is reading the certificate …";
    try {
      const own = globalThis.trustedTypes ? trustedTypes.createPolicy("fairaudit", { createScriptURL: (url) => url }) : { createScriptURL: (url) => url };
      const url = URL.createObjectURL(new Blob([VERIFIED, ANSWER], { type: "text/javascript" })), worker = new Worker(own.createScriptURL(url));
      const close = (then) => (event) => { then(event); worker.terminate(); URL.revokeObjectURL(url); };
      worker.onmessage = close(found); worker.onerror = close(failed);
      worker.postMessage(source);
    } catch (error) { failed(); }
  }

  async function run() {
    const box = at("check"), source = at("certificate").textContent;
    box.textContent = "Recomputing the figures from the table in this page …";
    await turn();
    let findings, law = null;
    try {
      const doc = JSON.parse(source), wrong = await malformed(source, doc);
      if (wrong) refuse("This is no certificate of the format", wrong);
      else {
        ({ findings, law } = await check(doc));
        report(findings, law || doc.subject.table.header);
      }
    } catch (error) {
      if (error.message === TOO_LONG) refuse("This page does not check its certificate, fairaudit verify does", TOO_LONG);
      else report([{ what: "the certificate in this page cannot be read: " + error.message, good: false, why: "" }], true);
    }
    if (law) lookUp(law);
    document.documentElement.dataset.checked = box.dataset.state;
    prove(source);
  }

  const save = at("save");
  save.hidden = false;
  save.addEventListener("click", () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([at("certificate").textContent + "\n"], { type: "application/json" }));
    link.download = "certificate.json"; link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
  addEventListener("beforeprint", () => { for (const d of document.querySelectorAll("details")) d.open = true; });
  run();
})();
