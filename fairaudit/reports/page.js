// Shows what the verified program (proofs/checker) finds of the certificate in this page, and lists the rows of its table.
// It judges no statement: it compares what stands on the page with the certificate. Text from the certificate is only ever set as text.
"use strict";
(() => {
  const PAGE = 10;
  const CHOICES = 300;
  const LISTED = 500;
  const PATIENCE = 120_000;
  const at = (id) => document.getElementById(id);

  // Rationals [n, d] with d >= 0; [1, 0] is infinite.
  const ZERO = [0n, 1n];
  const abs = (a) => (a < 0n ? -a : a);
  const gcd = (a, b) => { while (b) [a, b] = [b, a % b]; return a; };
  const rational = (s) => { if (s === "inf") return [1n, 0n]; const [n, d] = s.split("/"); return [BigInt(n), d === undefined ? 1n : BigInt(d)]; };
  const lowest = ([n, d]) => { if (d === 0n) return [1n, 0n]; const g = gcd(abs(n), d); return [n / g, d / g]; };
  const text = (r) => { const [n, d] = lowest(r); return d === 0n ? "inf" : d === 1n ? String(n) : n + "/" + d; };
  const compare = (a, b) => { const l = a[0] * b[1], r = b[0] * a[1]; return l < r ? -1 : l > r ? 1 : 0; };
  const minus = (a, b) => [a[0] * b[1] - b[0] * a[1], a[1] * b[1]];
  const quotient = (a, b) => (b[0] === 0n ? (a[0] === 0n ? [1n, 1n] : [1n, 0n]) : [a[0] * b[1], a[1] * b[0]]);
  const most = (a, b) => (compare(a, b) < 0 ? b : a);
  const least = (a, b) => (compare(a, b) > 0 ? b : a);
  const sum = (list) => list.reduce((a, b) => a + b, 0n);
  function whole(list) {  // integers over a denominator
    const d = list.reduce((m, r) => (m === r[1] ? m : (m / gcd(m, r[1])) * r[1]), 1n);
    return [list.map((r) => r[0] * (d / r[1])), d];
  }
  function decimals([n, d], places = 4) {  // some significant digits
    if (d === 0n) return "infinite";
    if (n === 0n) return "0";
    if (n < 0n) return "-" + decimals([-n, d], places);
    let power = String(n).length - String(d).length;
    let digits = 0n;
    const start = 10n ** BigInt(places - 1);
    for (let i = 0; i < 3; i++) {
      const shift = places - 1 - power;
      const top = shift >= 0 ? n * 10n ** BigInt(shift) : n, bottom = shift >= 0 ? d : d * 10n ** BigInt(-shift);
      digits = (2n * top + bottom) / (2n * bottom);
      if (digits < start) power--; else if (digits >= 10n * start) power++; else break;
    }
    return String(Number(digits + "e" + (power - places + 1)));
  }
  function near(r, said, sharp = 1000n) {  // whether decimals are a rounded rational
    const match = /^(-?)(\d+)(?:\.(\d+))?(?:e([+-]\d+))?$/.exec(said);
    if (!match) return false;
    const places = (match[3] || "").length, power = Number(match[4] || 0) - places, n = BigInt(match[1] + match[2] + (match[3] || ""));
    if (Math.abs(power) > 200000) return false;
    const v = power >= 0 ? [n * 10n ** BigInt(power), 1n] : [n, 10n ** BigInt(-power)], gap = minus(r, v);
    return compare([abs(gap[0]) * sharp, gap[1]], [abs(r[0]), r[1]]) <= 0;
  }

  // Give the page a turn when 40 ms have passed.
  let since = performance.now();
  const channel = new MessageChannel();
  const turn = () => new Promise((resolve) => { channel.port1.onmessage = () => { since = performance.now(); resolve(); }; channel.port2.postMessage(0); });
  const late = () => performance.now() - since > 40;

  const printable = (s) => s.replace(/[\p{Cc}\p{Cf}\p{Co}\p{Cn}\p{Zl}\p{Zp}]/gu, (c) => "\\u{" + c.codePointAt(0).toString(16) + "}").slice(0, 200);
  function element(tag, content) { const node = document.createElement(tag); node.textContent = content; return node; }

  // ---- The rows of the table ----

  const columnOf = (name) => [...document.querySelectorAll("#complete th")].findIndex((e) => e.dataset.is === name);
  const product = (lists) => lists.reduce((made, list) => made.flatMap((head) => list.map((part) => head.concat(part))), [[]]);

  // What each row of the table gets. What a policy gives behind its filters is not in its table: there the page has to say it.
  async function cellsOf(doc) {
    const { header, rows } = doc.subject.table, { group, context } = header.filters || {};
    const contexts = context ? product(context.map((f) => f.inputs)) : header.contexts, groups = group ? product(group.map((f) => f.inputs)) : header.groups;
    const made = { contexts, groups, cells: [], own: Boolean(header.filters) }, shared = header.utility && header.utility.map(rational);
    if (made.own) {
      const written = [...document.querySelectorAll("#rows tr")].map((row) => row.lastElementChild.textContent);
      if (written.some((exact) => !/^(inf|-?\d+(\/\d+)?)$/.test(exact))) return made;
      made.cells = written.map((exact, i) => ({ x: Math.floor(i / groups.length), a: i % groups.length, e: rational(exact) }));
      return made;
    }
    for (const row of rows) {
      if ("unknown" in row) continue;
      const g = shared || row.utility.map((v) => (v === null ? ZERO : rational(v)));
      const [w, d] = whole(row.weights.map(rational)), [worth, unit] = whole(g);
      made.cells.push({ x: row.context, a: row.group, w, d, g, e: [sum(w.map((p, u) => p * worth[u])), sum(w) * unit] });
      if (late()) await turn();
    }
    return made;
  }
  function amountText(r) {
    const [n, d] = lowest(r);
    if (d === 1n) return n.toLocaleString("en");
    if (n >= 100n * d) return ((10n * n) / d / 10n).toLocaleString("en") + "." + ((10n * n) / d) % 10n;
    let power = 0;
    while ((10n ** BigInt(power) * n) / d < 1000n && power < 300) power++;
    return String(Number((10n ** BigInt(power) * n) / d + "e-" + power));
  }

  // The rows that stand on the page, or, of a table with too many for that, made as they are looked at.
  function lookUp(doc, { contexts: contextLabels, groups: groupLabels, cells: listed }) {
    const box = at("lookup");
    if (!box || listed.length < 2) return;
    const about = doc.subject, burden = about.utility.burden === true, signed = about.utility.m.startsWith("-"), hasContexts = about.columns.context.length > 0;
    const name = (label) => printable(label.join(" / ")), contexts = contextLabels.map(name), groups = groupLabels.map(name);
    const body = at("rows"), written = [...body.children], heads = [...document.querySelectorAll("#complete th")].map((e) => e.textContent);
    const percent = columnOf("rate") >= 0, counts = columnOf("decisions") >= 0;
    const amount = ({ e }) => (percent ? (e[0] === 0n || e[0] === e[1] ? decimals([100n * e[0], e[1]]) : Number(decimals([100n * e[0], e[1]], 3)).toPrecision(3)) + "\u00a0%" : decimals(e));
    const best = new Map(), pick = burden ? least : most;
    for (const c of listed) best.set(c.x, best.has(c.x) ? pick(best.get(c.x), c.e) : c.e);
    const far = (c, b = best.get(c.x)) => (signed ? minus(most(b, c.e), least(b, c.e)) : quotient(most(b, c.e), least(b, c.e)));
    const make = (c) => {
      const row = document.createElement("tr"), exact = text(c.e);
      const own = counts && percent ? sum(c.w.filter((_, u) => c.g[u][0])) : 0n;
      const cells = [...(hasContexts ? [contexts[c.x]] : []), groups[c.a], ...(counts ? [amountText([sum(c.w), c.d])] : []),
        ...(counts && percent ? [amountText([own, c.d])] : []), amount(c), compare(c.e, best.get(c.x)) === 0 ? "best" : decimals(far(c)), exact.length > 60 ? "(" + exact.length + " characters)" : exact];
      cells.forEach((v, i) => { const cell = document.createElement("td"); cell.append(element("bdi", v)); cell.dataset.l = heads[i]; row.append(cell); });
      return row;
    };
    const list = listed.map((c, i) => ({ c, row: written.length ? () => written[i] : () => make(c) }));
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
      const out = at("compared"), two = x === null && contexts.length > 1 ? [] : pair.map((a) => listed.find((c) => c.x === (x || 0) && c.a === a)).filter(Boolean);
      out.textContent = "";
      if (two.length === 2 && two[0] !== two[1]) {
        const [p, q] = compare(two[0].e, two[1].e) < 0 ? [two[1], two[0]] : two, r = far(q, p.e), exact = text(r);
        out.append(element("bdi", groups[p.a]), " " + amount(p) + " against ", element("bdi", groups[q.a]), " " + amount(q) + ": ", element("strong", decimals(r) + (signed ? " apart" : " times")), exact.length > 60 ? "" : " (" + exact + ")");
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

  // ---- What stands on the page, beside the certificate: a sentence for each thing that differs ----

  function figuresThatDiffer(doc) {
    const of = (path) => path.split(".").reduce((v, k) => (v === null || v === undefined ? v : v[k]), doc);
    const same = (node) => node.textContent.trim() === String(of(node.dataset.path));
    const close = (node) => {
      const exact = of(node.dataset.near), said = node.textContent.trim();
      return exact === "inf" ? said === "infinite" : typeof exact === "string" && near(rational(exact), said);
    };
    const tone = document.querySelector(".verdict");
    const wrong = [...document.querySelectorAll("[data-path]")].filter((e) => !same(e)).length + [...document.querySelectorAll("[data-near]")].filter((e) => !close(e)).length
      + (tone && tone.classList.contains(doc.verdict) ? 0 : 1);
    return wrong ? [wrong + " of the figures that stand on this page differ from the certificate"] : [];
  }
  async function rowsThatDiffer(doc, { contexts, groups, cells: listed, own }) {  // exactly where they say so, and rounded where they do not
    const rows = [...document.querySelectorAll("#rows tr")];
    if (!rows.length || own) return [];
    const last = document.querySelectorAll("#complete th").length - 1, rate = columnOf("rate"), decisions = columnOf("decisions"), hasContexts = doc.subject.columns.context.length > 0;
    let wrong = rows.length === listed.length ? 0 : 1;
    for (const [i, c] of listed.entries()) {
      const cells = rows[i] ? [...rows[i].children].map((e) => e.textContent) : [], exact = cells[last] || "";
      const names = [...(hasContexts ? [contexts[c.x]] : []), groups[c.a]];
      const fits = names.every((l, k) => !/^[ -~]{0,100}$/.test(l.join(" / ")) || cells[k] === printable(l.join(" / "))) && (exact === "in the certificate" || exact === text(c.e))
        && (rate < 0 || near([100n * c.e[0], c.e[1]], (cells[rate] || "").replace(/\s%$/, ""), 200n)) && (decisions < 0 || !/^[0-9,]{1,19}$/.test(cells[decisions]) || cells[decisions] === amountText([sum(c.w), c.d]));
      if (!fits) wrong++;
      if (late()) await turn();
    }
    return wrong ? [wrong + " of the rows of the table that stand on this page differ from the certificate"] : [];
  }

  // ---- The verified program, in a worker of its own: its exit code, and then a line for each statement ----

  const VERIFIED = "verified.js";
  const ANSWER = `onmessage = ({ data }) => {
    const bytes = new TextEncoder().encode(data);
    let text = "";
    for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
    postMessage(fairauditVerified(text));
  };`;
  const judged = (source) => new Promise((resolve) => {
    const failed = () => resolve("3\nnothing was judged: the program could not run in this browser");
    try {
      const own = globalThis.trustedTypes ? trustedTypes.createPolicy("fairaudit", { createScriptURL: (url) => url }) : { createScriptURL: (url) => url };
      const url = URL.createObjectURL(new Blob([VERIFIED, ANSWER], { type: "text/javascript" })), worker = new Worker(own.createScriptURL(url));
      const close = (then) => (event) => { clearTimeout(limit); worker.terminate(); URL.revokeObjectURL(url); then(event); };
      const limit = setTimeout(close(() => resolve("3\nnothing was judged: the program took longer than " + PATIENCE / 1000 + " seconds")), PATIENCE);
      worker.onmessage = close(({ data }) => resolve(data));
      worker.onerror = close(failed);
      worker.postMessage(source);
    } catch (error) { failed(); }
  });

  const OUTCOMES = [["FALSE", "✗ FALSE: "], ["true", "✓ "], ["not covered", "– not checked in this page, use fairaudit verify: "]];
  function report(answer, differing) {
    const [code, ...lines] = answer.split("\n"), told = lines.map((line) => [line.slice(0, line.indexOf(": ")), line.slice(line.indexOf(": ") + 2)]);
    const [wrong, good, open] = OUTCOMES.map(([word]) => told.filter(([outcome]) => outcome === word));
    const box = at("check"), list = at("finding-list"), end = (state, bold, rest) => { box.textContent = ""; box.dataset.state = state; box.append(element("strong", bold), " " + rest + " "); };
    const verdict = open.some(([, what]) => what === "verdict") ? ", the verdict among them," : "";
    if (code === "2") end("refused", "✗ This is no certificate of the format:", printable(lines.join(" ").replace(/^malformed: /, "")) + ". Do not use this page.");
    else if (wrong.length) end("differs", "✗ Checked in your browser: " + wrong.length + " of " + told.length + " statements are FALSE.", "Do not use this page.");
    else if (differing.length) end("differs", "✗ This page does not show what its certificate says:", differing.join("; ") + ". Do not use this page.");
    else if (good.length) {
      end("agrees", "✓ Checked in your browser, by a program that is itself proved: " + good.length + " statements are true.",
        open.length ? open.length + " more" + verdict + (open.length === 1 ? " is" : " are") + " not checked in this page: use fairaudit verify." : "");
    } else {
      const why = open.length ? "its program covers none of the " + open.length + " statements" : printable(lines.join(" ").replace(/^nothing was judged: |; give it.*/g, ""));
      end("unknown", "Nothing was judged in this page:", why + ". Use fairaudit verify.");
    }
    if (code !== "2") {
      for (const what of differing) list.append(element("li", "✗ " + what));
      for (const [outcome, sign] of OUTCOMES) for (const [, what] of told.filter(([word]) => word === outcome).slice(0, LISTED)) list.append(element("li", sign + printable(what)));
    }
    box.append("A forged page could say this too: ");
    const link = element("a", "how to verify"); link.href = "#verify"; box.append(link, ".");
    at("findings").hidden = !list.children.length;
    at("findings").open = wrong.length + differing.length > 0;
    document.documentElement.dataset.checked = box.dataset.state;
  }

  async function run() {
    const source = at("certificate").textContent, answer = judged(source);
    at("check").textContent = "Checking the certificate in this page …";
    let differing = [];
    try {
      const doc = JSON.parse(source);
      differing = figuresThatDiffer(doc);
      if (doc.subject.table.header) {
        const found = await cellsOf(doc);
        differing.push(...await rowsThatDiffer(doc, found));
        lookUp(doc, found);
      }
    } catch (error) { differing.push("the page cannot show this certificate: " + error.message); }
    report(await answer, differing);
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
