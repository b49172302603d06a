"use strict";
/* Numbers, tables, histograms and curves. Every text goes in as text, never as markup. */
const charts = (() => {
  const SVG = "http://www.w3.org/2000/svg";

  /* An element with attributes and children; strings become text. */
  function make(name, attributes, ...children) {
    const e = document.createElement(name);
    for (const [key, value] of Object.entries(attributes || {})) e.setAttribute(key, value);
    for (const child of children) e.append(child);
    return e;
  }

  function draw(name, attributes, text) {
    const e = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) e.setAttribute(key, value);
    if (text !== undefined) e.textContent = text;
    return e;
  }

  /* A number as people read it; a dash where there is none. */
  function number(value, digits = 4) {
    if (value === null || value === undefined || !Number.isFinite(value)) return "–";
    if (value === 0) return "0";
    const size = Math.abs(value);
    if (size >= 1e6 || size < 1e-4) return value.toExponential(2);
    if (size >= 1000) return Math.round(value).toLocaleString("en");
    return String(Number(value.toPrecision(digits)));
  }

  /* rows: arrays of texts or elements; `right`: columns of numbers. */
  function table(caption, heads, rows, right = []) {
    const cell = (kind, i, content) => {
      const attributes = right.includes(i) ? { class: "right" } : {};
      if (kind === "th") attributes.scope = heads ? "col" : "row";
      return make(kind, attributes, content);
    };
    const t = make("table", {});
    if (caption) t.append(make("caption", {}, caption));
    if (heads) t.append(make("thead", {}, make("tr", {}, ...heads.map((h, i) => cell("th", i, h)))));
    const body = make("tbody", {});
    for (const row of rows) {
      const cells = row.map((c, i) => {
        if (i > 0) return cell("td", i, c);
        return make("th", { scope: "row" }, c);
      });
      body.append(make("tr", {}, ...cells));
    }
    t.append(body);
    return t;
  }

  /* 1, 2 or 5 times a power of ten that cuts `range` into at most `most`. */
  function step(range, most) {
    const raw = range / most, unit = 10 ** Math.floor(Math.log10(raw));
    for (const k of [1, 2, 5]) if (k * unit >= raw * (1 - 1e-9)) return k * unit;
    return 10 * unit;
  }

  function ticks(low, high, most) {
    const by = step(high - low, most), list = [];
    for (let k = Math.ceil(low / by - 1e-9); k * by <= high + 1e-9 * by; k++) list.push(Number((k * by).toPrecision(12)));
    return list;
  }

  function median(sorted) {
    const n = sorted.length;
    return n % 2 ? sorted[(n - 1) / 2] : (sorted[n / 2 - 1] + sorted[n / 2]) / 2;
  }

  /* Bins of a round width over all values. */
  function bins(values) {
    let low = Infinity, high = -Infinity;
    for (const v of values) { if (v < low) low = v; if (v > high) high = v; }
    const spread = high - low > 1e-9 * Math.max(1, Math.abs(high)) ? high - low : Math.max(1e-3, Math.abs(high) * 0.1);
    const width = step(spread, 30), first = Math.floor(low / width);
    const counts = new Array(Math.max(1, Math.floor(high / width) - first + 1)).fill(0);
    for (const v of values) counts[Math.min(counts.length - 1, Math.max(0, Math.floor(v / width) - first))]++;
    return { low: first * width, width, counts };
  }

  /* Width of a drawing in units: pixels where there are fewer, so that letters stay readable. */
  const room = (element, most) => Math.min(most, Math.max(320, element.clientWidth || most));

  function histogram(figure, title, unit, values) {
    figure.append(make("figcaption", {}, title));
    if (values.length === 0) {
      figure.append(make("p", {}, "No position has two contacts."));
      return;
    }
    const sorted = Float64Array.from(values).sort();
    const text = `from ${number(sorted[0])} to ${number(sorted[sorted.length - 1])} ${unit}, median ${number(median(sorted))} ${unit}`;
    const b = bins(values), most = Math.max(...b.counts);
    const W = room(figure, 520), H = 240, L = 46, B = 38, T = 10, R = 10;
    const x = (v) => L + (v - b.low) / (b.width * b.counts.length) * (W - L - R);
    const y = (n) => H - B - n / most * (H - B - T);
    const svg = draw("svg", { viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": `${title}: ${text}` });
    b.counts.forEach((n, i) => {
      const at = b.low + i * b.width;
      const bar = draw("rect", { class: "bars", x: x(at) + 0.5, y: y(n), width: Math.max(1, x(at + b.width) - x(at) - 1), height: H - B - y(n) });
      bar.append(draw("title", {}, `${number(at)} to ${number(at + b.width)} ${unit}: ${n}`));
      svg.append(bar);
    });
    svg.append(draw("path", { class: "axis", d: `M${L} ${T}V${H - B}H${W - R}` }));
    for (const v of ticks(b.low, b.low + b.width * b.counts.length, W / 65)) {
      svg.append(draw("text", { x: x(v), y: H - B + 16, "text-anchor": "middle" }, number(v)));
      svg.append(draw("path", { class: "axis", d: `M${x(v)} ${H - B}v4` }));
    }
    for (const n of ticks(0, most, 4).filter(Number.isInteger))
      svg.append(draw("text", { x: L - 6, y: y(n) + 4, "text-anchor": "end" }, String(n)));
    svg.append(draw("text", { x: (L + W - R) / 2, y: H - 5, "text-anchor": "middle" }, `${title}, ${unit}`));
    const rows = b.counts.map((n, i) => [`${number(b.low + i * b.width)} to ${number(b.low + (i + 1) * b.width)}`, String(n)]);
    figure.append(svg, make("p", { class: "hint" }, text),
      make("details", {}, make("summary", {}, "Numbers"), table("", [unit, "positions"], rows, [1])));
  }

  /* times and values: of the same length; limits [low, high], null where there is none; place: where
   * the figure will stand. */
  function curve(title, unit, times, values, limits, place) {
    let low = Infinity, high = -Infinity;
    for (const v of values) { if (v < low) low = v; if (v > high) high = v; }
    const text = `from ${number(low)} to ${number(high)} ${unit}`;
    const pad = Math.max((high - low) * 0.08, 1e-3 * Math.max(1, Math.abs(high)));
    const W = room(place, 1040), H = 150, L = 60, B = 30, T = 8, R = 12;
    const from = low - pad, to = high + pad, end = times[times.length - 1] || 1;
    const x = (t) => L + t / end * (W - L - R), y = (v) => H - B - (v - from) / (to - from) * (H - B - T);
    const svg = draw("svg", { viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": `Joint ${title} over time: ${text}` });
    for (const v of ticks(from, to, 4)) svg.append(draw("text", { x: L - 6, y: y(v) + 4, "text-anchor": "end" }, number(v)));
    for (const t of ticks(0, end, W / 100)) {
      svg.append(draw("text", { x: x(t), y: H - B + 16, "text-anchor": "middle" }, number(t)));
      svg.append(draw("path", { class: "axis", d: `M${x(t)} ${H - B}v4` }));
    }
    svg.append(draw("path", { class: "axis", d: `M${L} ${T}V${H - B}H${W - R}` }));
    for (const limit of limits)
      if (limit !== null && limit >= from && limit <= to)
        svg.append(draw("path", { class: "limit", d: `M${L} ${y(limit)}H${W - R}` }));
    /* Per pixel the lowest and the highest value: nothing is lost to the eye. */
    let d = `M${x(0).toFixed(1)} ${y(values[0]).toFixed(1)}`, column = -1, least = 0, most = 0, last = 0;
    const flush = () => { d += `L${column} ${y(least).toFixed(1)}V${y(most).toFixed(1)}V${y(last).toFixed(1)}`; };
    for (let i = 0; i < values.length; i++) {
      const c = Math.round(x(times[i]) * 2) / 2;
      if (c !== column && column >= 0) flush();
      if (c !== column) { column = c; least = most = values[i]; }
      least = Math.min(least, values[i]);
      most = Math.max(most, values[i]);
      last = values[i];
    }
    if (column >= 0) flush();
    svg.append(draw("path", { class: "curve", d }));
    return make("figure", {}, make("figcaption", {}, `${title}, ${unit}: ${text}`), svg);
  }

  return { make, number, table, histogram, curve };
})();
