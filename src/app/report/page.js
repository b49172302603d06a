"use strict";
/* Fills the page from its data and wires its controls. */
(() => {
  const { make, number, table, histogram, curve } = charts;
  const STATUS = ["two-contact", "osculating", "single-contact", "no-contact", "budget"];
  const STOPS_A_SECOND = 12;
  const CROWDED = 20000; /* more contacts than this hide the part: they are shown when asked for */
  const $ = (id) => document.getElementById(id);
  const data = JSON.parse($("data").textContent);

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const floats = (text) => new Float32Array(bytes(text).buffer);
  const words = (text) => new Uint32Array(bytes(text).buffer);
  const mesh = (m) => ({ kind: m.kind, points: floats(m.points), normals: new Int8Array(bytes(m.normals).buffer), indices: words(m.indices) });
  const size = Math.max(...data.summary.part.box_max_mm.map((c, k) => c - data.summary.part.box_min_mm[k]));
  const decimals = Math.min(9, Math.max(3, 4 - Math.floor(Math.log10(size))));
  const point = (v, places = decimals) => Array.from(v, (c) => String(Number(c.toFixed(places)) + 0)).join(", ");

  const stops = floats(data.stops.values), names = words(data.stops.names), count = data.stops.count;
  const stopAt = (i) => stops.subarray(viewer.STOP * i, viewer.STOP * (i + 1));
  const gapAt = (i) => { const s = stopAt(i); return Math.hypot(s[6] - s[9], s[7] - s[10], s[8] - s[11]); };
  const two = (i) => names[4 * i + 2] === 0;
  const tilted = (i) => names[4 * i + 2] <= 1;
  const v = data.verify, s = data.summary;

  function best(value, among) {
    let at = -1;
    for (let i = 0; i < count; i++) if (among(i) && (at < 0 || value(i) > value(at))) at = i;
    return Math.max(at, 0);
  }

  /* 0 over the middle of the part, 1 over its corners. */
  function offCentre(i) {
    const at = stopAt(i), low = s.part.box_min_mm, high = s.part.box_max_mm;
    const off = (k) => (2 * at[k] - low[k] - high[k]) / Math.max(1e-9, high[k] - low[k]);
    return Math.hypot(off(0), off(1)) / Math.SQRT2;
  }

  /* ---- text ---- */

  function head() {
    document.title = `${data.title} – Bitangent report`;
    $("title").textContent = data.title;
    $("subtitle").textContent = `${s.positions.toLocaleString("en")} tool positions, solved by ${s.backend} with a tolerance of ${number(s.tolerance_mm)} mm`;
    $("footer").textContent = `Bitangent ${s.version}. Millimetres and degrees; the part frame has z up, the tool comes from +z.`;
  }

  function card(value, text) {
    $("cards").append(make("li", {}, make("b", {}, value), make("span", {}, text)));
  }

  function summarise() {
    card(s.positions.toLocaleString("en"), "tool positions");
    card(`${number(100 * s.statuses["two-contact"] / Math.max(1, s.positions), 3)} %`, "touch at two points, P and Q");
    card(`${number(s.tilt_deg.median, 3)}°`, `median tilt, up to ${number(s.tilt_deg.max, 3)}°`);
    if (!v.missing) {
      card(`${number(v.max_gouge_mm, 3)} mm`, `greatest gouge found, moves between positions included; proven: no more than ${number(Math.max(v.position_bound_mm, v.motion_bound_mm), 3)} mm`);
      card(`${number(v.max_scallop_mm, 3)} mm`, "most left on the part");
      card(String(v.collisions), "collisions of shank or holder");
    }
    card(`${number(s.positions_per_second, 3)}`, `positions a second on ${s.threads} thread${s.threads === 1 ? "" : "s"}`);
    const meaning = { "two-contact": "P and Q apart", osculating: "P and Q at one place", "single-contact": "no second contact up to the largest tilt",
      "no-contact": "nothing of the part under the tool", budget: "safe, but not the closest", lift: "retract moves" };
    $("statuses").append(table("", ["status", "positions", "meaning"],
      Object.entries(s.statuses).filter(([, n]) => n > 0).map(([name, n]) => [name, n.toLocaleString("en"), meaning[name] || ""]), [1]));
    const box = s.part.box_max_mm.map((c, i) => number(c - s.part.box_min_mm[i]));
    $("settings").append(table("", null, [["part", s.part.file],
      ["size", `${box.join(" × ")} mm`],
      ["made of", `${s.part.surfaces} exact surface${s.part.surfaces === 1 ? "" : "s"}, ${s.part.triangles.toLocaleString("en")} triangles`],
      ...data.settings]));
  }

  function spreads() {
    const tilts = [], gaps = [];
    for (let i = 0; i < count; i++) {
      if (tilted(i)) tilts.push(stopAt(i)[12]);
      if (two(i)) gaps.push(gapAt(i));
    }
    histogram($("tilts"), "Tilt", "degrees", tilts);
    histogram($("gaps"), "Distance between P and Q", "mm", gaps);
  }

  function backends() {
    const rows = data.backends.map((b) => {
      const state = b.failed ? `failed: ${b.failed}` : b.state === "ready" ? (b.used ? "ready, made this path" : "ready") : b.state;
      return [b.name, state, b.positions ? b.positions.toLocaleString("en") : "–",
        b.positions ? number(b.positions / b.seconds, 3) : "–",
        b.difference_mm === undefined || b.difference_mm === null ? "–" : `${number(b.difference_mm, 2)} mm`, b.device || "–"];
    });
    $("backends").append(table("", ["back end", "state", "positions", "a second", "difference", "device"], rows, [2, 3, 4]));
  }

  function joints() {
    const m = data.machine;
    if (!m) return;
    $("machine-section").hidden = false;
    $("machine-note").textContent = `${m.name}: ${m.blocks.toLocaleString("en")} blocks, ${number(m.seconds)} s, of them ${number(m.cut_seconds)} s cutting; ` +
      `${m.retracts} retracts, ${m.rewinds} of them rewinds; ${m.slowed} blocks slowed. Dashed: limits of the joint.`;
    const all = floats(m.track), n = m.moments, times = new Float32Array(n);
    for (let i = 0; i < n; i++) times[i] = all[6 * i];
    m.joints.forEach((name, k) => {
      const values = new Float32Array(n);
      for (let i = 0; i < n; i++) values[i] = all[6 * i + 1 + k];
      if (n > 0) $("joints").append(curve(name, k < 3 ? "mm" : "degrees", times, values, m.limits[k], $("joints")));
    });
    $("joints").append(make("p", { class: "hint" }, "Time in seconds."));
  }

  /* ---- the map ---- */

  function deviation(map, code) {
    const limit = code < 0 ? -map.gouge_limit_mm : map.scallop_limit_mm;
    return limit * 10 ** ((Math.abs(code) - 0.5) / map.steps_per_decade);
  }

  function swatches(title, list) {
    const items = list.map(([colour, text]) => {
      const swatch = make("span", { class: "swatch" });
      swatch.style.background = colour;
      return make("li", {}, swatch, text);
    });
    $("map-legend").append(make("h3", {}, title), make("ul", { class: "swatches" }, ...items));
  }

  function legend(map, colour) {
    const code = (k) => Math.min(map.code_most, 1 + k * map.steps_per_decade);
    const side = (sign, limit) => [0, 1, 2, 3].map((k) =>
      [colour(sign * code(k)), `${k === 0 ? "just over " : ""}${number(limit * 10 ** k)} mm${k === 3 ? " and more" : ""}`]);
    swatches("Left on the part", side(1, map.scallop_limit_mm));
    swatches("Finished", [[colour(0), `from −${number(map.gouge_limit_mm)} to ${number(map.scallop_limit_mm)} mm`]]);
    swatches("Cut into it", side(-1, map.gouge_limit_mm));
  }

  function figures() {
    $("map-figures").append(make("h3", {}, "Figures"), table("", null, [
      ["greatest gouge", `${number(v.max_gouge_mm)} mm`],
      ["gouged area", `${number(v.gouge_area_mm2)} mm²`],
      ["proven: no deeper than", `${number(v.position_bound_mm)} mm at the positions, ${number(v.motion_bound_mm)} mm between them`],
      ["most left", `${number(v.max_scallop_mm)} mm`],
      ["mean left", `${number(v.mean_scallop_mm)} mm`],
      ["90 % have at most", `${number(v.p90_scallop_mm)} mm`],
      ["strip width", `${number(v.strip_width_mm)} mm`],
      ["uncut", `${number(v.uncut_mm2)} mm²`],
      ["collisions", v.collisions ? `${v.collisions}, up to ${number(v.collision_mm)} mm to back out` : "none"],
    ]));
  }

  /* Returns the map as colours for the 3D view, bottom row first, or null. */
  function drawMap() {
    if (v.missing) {
      $("map-note").textContent = `Not verified: ${v.missing}.`;
      $("map-note").className = "note";
      document.querySelector(".columns.map").remove();
      $("show-map").disabled = $("to-gouge").disabled = true;
      return null;
    }
    const map = v.map, codes = new Int8Array(bytes(map.codes).buffer), palette = bytes(map.palette);
    const rgb = (code) => palette.subarray(3 * (code + map.code_most), 3 * (code + map.code_most) + 3);
    const colour = (code) => `rgb(${rgb(code).join(" ")})`;
    const rgba = new Uint8Array(4 * map.width * map.height), canvas = $("map");
    for (let i = 0; i < codes.length; i++)
      if (codes[i] !== -128) { rgba.set(rgb(codes[i]), 4 * i); rgba[4 * i + 3] = 255; }
    canvas.width = map.width;
    canvas.height = map.height;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `The part from above, coloured by what the path leaves: greatest gouge ${number(v.max_gouge_mm)} mm, most left ${number(v.max_scallop_mm)} mm`);
    const image = new ImageData(map.width, map.height);
    for (let y = 0; y < map.height; y++)
      image.data.set(rgba.subarray(4 * map.width * y, 4 * map.width * (y + 1)), 4 * map.width * (map.height - 1 - y));
    canvas.getContext("2d").putImageData(image, 0, 0);
    canvas.addEventListener("pointermove", (e) => {
      const r = canvas.getBoundingClientRect();
      const i = Math.min(map.width - 1, Math.max(0, Math.floor((e.clientX - r.left) / r.width * map.width)));
      const j = Math.min(map.height - 1, Math.max(0, Math.floor((r.bottom - e.clientY) / r.height * map.height)));
      const code = codes[j * map.width + i];
      const text = code === -128 ? "no part" : code === 0 ? "finished" : code < 0 ? `gouged ${number(-deviation(map, code), 2)} mm` : `${number(deviation(map, code), 2)} mm left`;
      $("map-value").textContent = `x ${number(map.x_mm + i * map.cell_mm)}, y ${number(map.y_mm + j * map.cell_mm)} mm: ${text}`;
    });
    const shown = v.gouge_at_mm && v.max_gouge_mm > map.gouge_limit_mm;
    if (shown) {
      const mark = $("map-worst");
      mark.hidden = false;
      mark.style.left = `${100 * ((v.gouge_at_mm[0] - map.x_mm) / map.cell_mm + 0.5) / map.width}%`;
      mark.style.top = `${100 * (1 - ((v.gouge_at_mm[1] - map.y_mm) / map.cell_mm + 0.5) / map.height)}%`;
    }
    $("map-note").textContent = `The part from above, after the path was cut into a block, moves between the positions included; cells of ${number(map.cell_mm)} mm.` +
      (shown ? " Circle: the greatest gouge." : "");
    legend(map, colour);
    figures();
    return { width: map.width, height: map.height, x: map.x_mm, y: map.y_mm, cell: map.cell_mm, rgba };
  }

  /* ---- the view ---- */

  function tell(i) {
    const a = stopAt(i), status = names[4 * i + 2];
    const rows = [["position", `${i + 1} of ${count}`], ["pass, point", `${names[4 * i]}, ${names[4 * i + 1]}`], ["status", STATUS[status] || "–"],
      ["tilt", Number.isFinite(a[12]) ? `${number(a[12])}°` : "–"],
      ["P to Q", two(i) ? `${number(gapAt(i))} mm` : "–"], ["P", point(a.slice(6, 9))], ["Q", Number.isFinite(a[9]) ? point(a.slice(9, 12)) : "–"],
      ["tip", point(a.slice(0, 3))], ["axis", point(a.slice(3, 6), 5)]];
    $("stop").replaceChildren(...rows.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]));
  }

  function labels(view, here, gouge) {
    const near = Math.floor(view.at) === view.at, texts = [], tilt = here.tilt;
    if (view.show.tool && Number.isFinite(here.tip[0])) {
      const pair = Number.isFinite(here.q[0]) && here.status !== 1;
      const p = view.project(here.p), q = pair ? view.project(here.q) : null;
      const left = p && q && p[0] > q[0] ? 1 : -1; /* each label on its own side */
      if (near && Number.isFinite(here.p[0])) texts.push(["p", here.status === 1 ? "P = Q" : "P", here.p, [left, 1]]);
      if (near && pair) texts.push(["q", "Q", here.q, [-left, 1]]);
      const top = here.tip.map((c, k) => c + here.axis[k] * data.tool_height_mm * 1.08);
      texts.push(["tilt", Number.isFinite(tilt) ? `tilt ${number(tilt, 3)}°` : "no contact", top, [0, -1]]);
    }
    if (view.show.map && gouge) texts.push(["gouge", `gouge ${number(v.max_gouge_mm, 2)} mm`, v.gouge_at_mm, [0, -1]]);
    const stage = $("scene"), clamp = (x, most) => Math.min(most, Math.max(0, x));
    $("labels").replaceChildren(...texts.flatMap(([kind, text, place, side]) => {
      const at = view.project(place);
      if (!at) return [];
      const e = make("span", { class: kind }, text), half = 6 + 4.5 * text.length;
      const x = clamp(at[0] + 20 * side[0] - half, stage.clientWidth - 2 * half) + half;
      const y = clamp(at[1] + 20 * side[1] - 14, stage.clientHeight - 28) + 14;
      e.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -50%)`;
      return [e];
    }));
  }

  function makeView(map) {
    const low = s.part.box_min_mm, high = s.part.box_max_mm, tool = s.tool;
    try {
      return new viewer.Viewer($("scene"), { box: [low, high], mesh: mesh(data.mesh), solids: data.tool_solids.map(mesh), stops, names, map,
        reach: tool.major_radius_mm + tool.minor_radius_mm, height: data.tool_height_mm,
        upright: s.spin === "none" });
    } catch (error) {
      $("no-webgl").hidden = false;
      return null;
    }
  }

  function wire(view) {
    const range = $("position"), play = $("play");
    let last = 0;
    const go = (at) => {
      const i = Math.min(count - 1, Math.max(0, Math.floor(at)));
      if (view) { view.at = Math.min(count - 1, Math.max(0, at)); view.invalidate(); }
      range.value = String(i);
      range.setAttribute("aria-valuetext", `position ${i + 1} of ${count}, ${STATUS[names[4 * i + 2]] || ""}`);
      tell(i);
    };
    const playing = () => play.getAttribute("aria-pressed") === "true";
    const tick = (now) => {
      if (!playing() || !view) return;
      if (last > 0) go(view.at + (now - last) / 1000 * STOPS_A_SECOND);
      last = now;
      if (view.at >= count - 1) toggle();
      requestAnimationFrame(tick);
    };
    const toggle = () => {
      const on = !playing();
      play.setAttribute("aria-pressed", String(on));
      play.textContent = on ? "Pause" : "Play";
      last = 0;
      if (on && view && view.at >= count - 1) go(0);
      if (on) requestAnimationFrame(tick);
      else go(Number(range.value));
    };
    const halt = () => { if (playing()) toggle(); };
    const on = (id, act) => $(id).addEventListener("click", act);
    range.max = String(count - 1);
    range.addEventListener("input", () => { halt(); go(Number(range.value)); });
    on("play", toggle);
    on("previous", () => { halt(); go(Number(range.value) - 1); });
    on("next", () => { halt(); go(Number(range.value) + 1); });
    on("to-tilt", () => { halt(); go(best((i) => stopAt(i)[12], tilted)); });
    on("to-gap", () => { halt(); go(best(gapAt, two)); });
    on("to-gouge", () => {
      halt();
      if (v.gouge_line !== undefined) go(v.gouge_line);
      $("show-map").checked = true;
      $("show-map").dispatchEvent(new Event("change"));
    });
    if (!v.missing && v.gouge_line === undefined) $("to-gouge").disabled = true;
    for (const [id, from] of [["from-corner", "corner"], ["from-above", "above"], ["from-front", "front"], ["from-side", "side"], ["near-tool", "tool"]])
      on(id, () => view && view.look(from));
    for (const name of ["tool", "contacts", "path", "axes", "map"])
      $(`show-${name}`).addEventListener("change", (e) => { if (view) { view.show[name] = e.target.checked; view.invalidate(); } });
    $("scene").addEventListener("keydown", (e) => {
      const step = { ",": -1, ".": 1 }[e.key];
      if (e.ctrlKey || e.metaKey || e.altKey) return;
      if (step) { halt(); go(Number(range.value) + step); }
      else if (e.key === " ") toggle();
      else if (!view || !view.key(e.key)) return;
      e.preventDefault();
    });
    go(best((i) => gapAt(i) * (1.2 - offCentre(i)), two));
  }

  function theme(view) {
    const system = matchMedia("(prefers-color-scheme: dark)"), button = $("theme"), root = document.documentElement;
    const dark = () => root.dataset.theme ? root.dataset.theme === "dark" : system.matches;
    const apply = () => {
      button.textContent = dark() ? "Light colours" : "Dark colours";
      if (view) view.setTheme(dark());
    };
    button.addEventListener("click", () => { root.dataset.theme = dark() ? "light" : "dark"; apply(); });
    system.addEventListener("change", apply);
    apply();
  }

  head();
  summarise();
  spreads();
  backends();
  joints();
  const view = makeView(drawMap());
  const gouge = !v.missing && v.gouge_at_mm && v.max_gouge_mm > v.map.gouge_limit_mm;
  if (view && count > CROWDED) $("show-contacts").checked = view.show.contacts = false;
  if (view) view.onDraw = (here) => labels(view, here, gouge);
  wire(view);
  theme(view);
  window.report = { view, data }; /* for those who look closer */
})();
