"use strict";
// The live page of heft: reads server-sent events, draws with uPlot. Keeps the last minute.
const KEEP = 1800;
const frames = [];          // one object a frame: {t, e: {channel: estimate}, truth}
const charts = new Map();   // title of the plot -> {plot, columns}
let postures = {};          // angles of the joints of each machine [rad]
let paused = false, dirty = false, layout = "", allMethods = false;

/** What speaks of a fault; everything else that is not trusted only waits for motion or time. */
const FAULT = /missing|rejected|repeats|contradict|other sign|jumped|disagree|does not follow|diverged|never changes|do not fit|does not fit|alike/;

// ---- frames

function add(frame) {
  const last = frames[frames.length - 1];
  // A run that starts anew starts a new minute.
  if (last && frame.t <= last.t) { if (frame.t === last.t) return; frames.length = 0; }
  const estimates = {};
  for (const e of frame.e) estimates[e.c] = e;
  frames.push({ t: frame.t, e: estimates, truth: frame.truth });
  postures = frame.p || {};
  if (frames.length > KEEP) frames.shift();
  dirty = true;
}

// ---- plots

/** The plots that the last frame calls for: title, place, and the columns of each. */
function wanted() {
  const last = frames[frames.length - 1];
  const plots = [];
  for (const [machine, definition] of Object.entries(DEFINITIONS)) {
    const every = Object.keys(last.e).filter((c) => c.startsWith(machine + "/")).sort();
    // The default method is the last by name; the others on demand.
    const channels = allMethods ? every : every.slice(-1);
    if (!channels.length) continue;
    let headline = -1;
    definition.parameters.forEach((parameter, i) => {
      if (parameter.headline) headline += 1;
      const place = parameter.headline ? headline : -1;
      const used = channels.filter((c) => frames.some((f) => f.e[c] && f.e[c].v[i][0] !== null));
      if (used.length) plots.push(parameterPlot(machine, parameter, i, place, used, channels));
    });
    plots.push(innovationPlot(definition, channels));
    for (const c of channels) if (last.e[c].f.some((f) => f > 0)) plots.push(forgettingPlot(c));
  }
  return plots;
}

const method = (c) => (frames[frames.length - 1].e[c] || {}).m || c;

function parameterPlot(machine, parameter, index, headline, used, channels) {
  const columns = [];
  for (const c of used) {
    const at = (f, k) => {
      const v = f.e[c] && f.e[c].v[index];
      if (!v || v[0] === null) return null;
      if (k === 0) return v[0];
      return v[1] === null ? null : v[0] + k * HALF_WIDTH_95 * v[1];
    };
    const hue = "--c" + (channels.indexOf(c) % 6);
    columns.push({ label: method(c), hue, get: (f) => at(f, 0), band: [(f) => at(f, -1), (f) => at(f, 1)] });
  }
  const truth = (f) => { const t = f.truth[machine]; return t ? t[index] : null; };
  if (frames.some((f) => truth(f) !== null)) columns.push({ label: "truth", hue: "--ink", dash: [5, 3], get: truth });
  // Shaded where the estimator that is trusted most has this parameter trusted.
  const trust = (f) => headline >= 0 && used.some((c) => f.e[c] && f.e[c].k[headline]);
  return { title: parameter.title, wide: headline >= 0, columns, trust: headline >= 0 ? trust : null };
}

function innovationPlot(definition, channels) {
  const columns = channels.map((c, i) => ({ label: method(c), hue: "--c" + (i % 6), get: (f) => (f.e[c] ? f.e[c].n : null) }));
  columns.push({ label: "verdict limit", hue: "--faint", dash: [2, 3], get: () => definition.nis.limit });
  columns.push({ label: "expected, 95 %", hue: "--faint", width: 0, get: () => null, band: [() => definition.nis.low, () => definition.nis.high] });
  return { title: "Mean normalised innovation squared [–]", wide: false, columns, trust: null };
}

function forgettingPlot(c) {
  const columns = ["inertia", "damping", "torque"].map((label, i) => ({ label, hue: "--c" + i, get: (f) => (f.e[c] ? f.e[c].f[i] : null) }));
  return { title: "Forgetting factors [–]: " + method(c), wide: false, columns, trust: null };
}

function data(columns) {
  const out = [frames.map((f) => f.t)];
  for (const c of columns) {
    out.push(frames.map(c.get));
    if (c.band) out.push(frames.map(c.band[0]), frames.map(c.band[1]));
  }
  return out;
}

/** Lines and bands whole, but for the widest quarter of each band: a filter that has seen nothing
 *  would flatten everything else. */
function range(columns, shown) {
  let low = Infinity, high = -Infinity;
  const see = (v) => { if (v !== null && v < low) low = v; if (v !== null && v > high) high = v; };
  for (const c of columns) {
    const widths = [];
    for (const f of shown) {
      see(c.get(f));
      if (c.band) { const a = c.band[0](f), b = c.band[1](f); if (a !== null && b !== null) widths.push([b - a, a, b]); }
    }
    widths.sort((a, b) => a[0] - b[0]).slice(0, Math.ceil(widths.length * 0.75)).forEach((w) => { see(w[1]); see(w[2]); });
  }
  if (!(low <= high)) return [0, 1];
  const room = 0.05 * (high - low) || 0.05 * Math.abs(high) || 1;
  return [low - room, high + room];
}

function make(wish, parent) {
  const figure = element("figure", undefined, wish.wide ? "wide" : "");
  figure.append(element("h3", wish.title + (wish.trust ? " – shaded: trusted" : "")));
  parent.append(figure);
  const series = [{ label: "t [s]", value: (u, v) => (v === null || v === undefined ? "–" : v.toFixed(2)) }], bands = [];
  const digits = (u, v, i, at) => {
    if (v === null || v === undefined) return "–";
    const edge = u.series[i + 2] && u.series[i + 2].label === "edge" ? u.data[i + 2][at] : null;
    return edge === null || edge === undefined ? grouped(Number(v.toPrecision(4))) : rounded(v, (edge - v) / HALF_WIDTH_95);
  };
  for (const c of wish.columns) {
    series.push({ label: c.label, stroke: () => colour(c.hue), width: c.width === undefined ? 1.5 : c.width, dash: c.dash, points: { show: false }, value: digits });
    if (c.band) {
      const at = series.length;
      const edge = { label: "edge", stroke: "transparent", width: 0, points: { show: false }, class: "edge" };
      series.push({ ...edge }, { ...edge });
      bands.push({ series: [at + 1, at], fill: () => colour(c.hue) + "33" });
    }
  }
  const options = {
    width: figure.clientWidth || 400, height: wish.wide ? 250 : 190, series, bands,
    legend: { live: true },
    cursor: { drag: { x: true, y: false }, sync: { key: "heft" } },
    scales: { x: { time: false }, y: { range: () => range(wish.columns, visible(wish.key)) } },
    axes: [{ ...axis, label: "time [s]", labelSize: 18, labelFont: "12px system-ui" }, { ...axis, size: room, values: (u, ticks) => ticks.map((v) => grouped(v)) }],
    hooks: {
      drawClear: [(u) => shade(u, wish.trust)],
      ready: [(u) => u.over.addEventListener("dblclick", () => { zoom = null; dirty = true; })],
      setSelect: [(u) => { if (u.select.width > 0) zoom = [u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x")]; dirty = true; }],
    },
  };
  const plot = new uPlot(options, data(wish.columns), figure);
  return { plot, wish, figure };
}

let zoom = null;
function visible() {
  return zoom ? frames.filter((f) => f.t >= zoom[0] && f.t <= zoom[1]) : frames;
}

function shade(u, trust) {
  if (!trust) return;
  const { left, top, width, height } = u.bbox;
  u.ctx.save();
  u.ctx.beginPath(); u.ctx.rect(left, top, width, height); u.ctx.clip();
  u.ctx.fillStyle = colour("--good") + "22";
  for (let i = 0; i < frames.length; i++) {
    if (!trust(frames[i])) continue;
    const from = frames[i].t;
    while (i + 1 < frames.length && trust(frames[i + 1])) i++;
    const to = (frames[i + 1] || frames[i]).t;
    const a = u.valToPos(from, "x", true), b = u.valToPos(to, "x", true);
    u.ctx.fillRect(a, top, Math.max(1, b - a), height);
  }
  u.ctx.restore();
}

function build(plots) {
  for (const chart of charts.values()) chart.plot.destroy();
  charts.clear();
  const parent = byId("plots");
  parent.replaceChildren();
  plots.forEach((wish, i) => charts.set(i, make(wish, parent)));
}

function draw() {
  requestAnimationFrame(draw);
  if (!dirty || paused || !frames.length) return;
  dirty = false;
  pose();
  const plots = wanted();
  const shape = JSON.stringify(plots.map((p) => [p.title, p.columns.map((c) => c.label)]));
  if (shape !== layout) { layout = shape; build(plots); }
  const times = visible();
  if (!times.length) return;
  const [from, to] = zoom || [frames[0].t, frames[frames.length - 1].t];
  for (const { plot, wish } of charts.values()) {
    const idle = plot.cursor.left === undefined || plot.cursor.left < 0;
    plot.batch(() => { plot.setData(data(wish.columns), false); plot.setScale("x", { min: from, max: to > from ? to : from + 1 }); });
    // Away from the cursor the legend tells the newest values.
    if (idle) plot.setLegend({ idx: frames.length - 1 }, false);
  }
}

// ---- words

/** Since when the newest verdict on a headline quantity of a channel holds [s]; null without frames. */
function since(channel, place) {
  const state = (f) => (f && f.e[channel] ? f.e[channel].k[place] : null);
  let i = frames.length - 1;
  if (i < 0 || state(frames[i]) === null) return null;
  while (i > 0 && state(frames[i - 1]) === state(frames[frames.length - 1])) i--;
  return frames[i].t;
}

/** The last trusted value leads; what is said now stands below it, with its reason and since when. */
function card(v, j, place) {
  const card = element("article", undefined, "verdict " + (j.trusted ? "trusted" : FAULT.test(j.verdict) ? "doubted fault" : "doubted"));
  const from = since(v.channel, place);
  const time = from === null ? "" : " since " + from.toFixed(1) + " s";
  card.append(element("p", j.title, "title"));
  if (j.trusted || j.last) {
    const shown = j.trusted ? j.now : j.last;
    card.append(element("p", shown.number, "number"), element("p", "95 %: " + shown.interval, "value"));
    card.append(element("p", j.trusted ? "trusted" + time : "last trusted value, " + age(v.time - j.last.time) + " old", "badge"));
  } else if (j.now) {
    // Faint: nobody should take it for a result.
    card.append(element("p", j.now.number, "number none"), element("p", "95 %: " + j.now.interval, "value"));
    card.append(element("p", "not trusted yet", "badge"));
  } else {
    card.append(element("p", "not trusted yet", "number none"));
  }
  card.append(element("p", (j.trusted ? "" : "Now, not trusted" + time + ": ") + j.value + ".", "value"));
  card.append(element("p", j.verdict));
  if (j.advice) card.append(element("p", j.advice, "advice"));
  card.append(element("p", v.channel + ", method " + v.method + ", t = " + v.time.toFixed(1) + " s", "when"));
  return card;
}

const age = (s) => (s < 90 ? s.toFixed(s < 10 ? 1 : 0) + " s" : (s / 60).toFixed(0) + " min");

// ---- the machine and its loads

/** Turns the joints of the drawings by the newest angles. */
function pose() {
  for (const [machine, angles] of Object.entries(postures)) {
    const figure = byId("posture-" + machine);
    if (!figure) continue;
    figure.hidden = false;
    const unknown = [];
    for (const joint of figure.querySelectorAll("[data-joint]")) {
      const angle = angles[joint.dataset.joint];
      const measured = angle !== undefined && angle !== null;
      joint.classList.toggle("unmeasured", !measured);
      if (measured) joint.setAttribute("transform", "rotate(" + (-angle * 180 / Math.PI).toFixed(1) + ")");
      else if (joint.dataset.joint.match(/boom|arm|bucket|lift|tilt/)) unknown.push(joint.dataset.joint.replace("_", " "));
    }
    figure.querySelector("figcaption").textContent = "Posture by the measured angles, not to scale." + (unknown.length ? " Dashed: " + unknown.join(", ") + " not measured." : "");
  }
}

/** What the truck is loaded by: the bucket now, the last load, the truck. */
function showLoads(loads) {
  byId("loads").hidden = !loads;
  if (!loads) return;
  const kg = (x) => grouped(Math.round(x)) + " kg";
  // No load weighs less than nothing, whatever the half width.
  const sure = (w) => "95 %: " + grouped(Math.round(Math.max(0, w.low))) + " to " + grouped(Math.round(w.high));
  const last = loads.carried || loads.loads[0], truck = loads.truck;
  const known = loads.now.age !== null;
  const tiles = [["in the bucket now", known ? kg(Math.max(0, loads.now.kg)) : "\u2013", known ? sure(loads.now) : "nothing was weighed yet"]];
  if (last) tiles.push(["load " + last.load + ", " + (last.stage === "settled" ? "final" : last.stage), kg(last.in_bucket.kg), sure(last.in_bucket) + (last.trusted ? ", trusted" : ", not trusted: " + last.reason)]);
  if (truck.total.loads) tiles.push(["truck " + truck.truck, kg(truck.total.kg), truck.total.loads + (truck.total.loads === 1 ? " load, " : " loads, ") + sure(truck.total)]);
  if (truck.target !== null) tiles.push([truck.remaining < 0 ? "too much" : "missing", kg(Math.abs(truck.remaining)), "of " + kg(truck.target)]);
  byId("tiles").replaceChildren(...tiles.map(([title, number, words]) => {
    const tile = element("div", undefined, "tile");
    tile.append(element("p", title, "title"), element("p", number, "number"), element("p", words, "when"));
    return tile;
  }));
}

function verdicts(list) {
  const cards = [];
  const machines = new Set();
  for (const v of list) {
    // The product's method comes first; the others on demand.
    if (machines.has(v.machine) && !allMethods) continue;
    machines.add(v.machine);
    v.judgements.forEach((j, place) => cards.push(card(v, j, place)));
  }
  if (cards.length) byId("verdicts").replaceChildren(...cards);
}

const seconds = (s) => (s < 1 ? Math.round(s * 1000) + " ms" : s.toFixed(1) + " s");

function rows(id, list, cells) {
  byId(id).replaceChildren(...list.map((item) => {
    const row = element("tr");
    for (const [text, bad] of cells(item)) row.append(element("td", text, bad ? "lost" : ""));
    return row;
  }));
}

function status(s) {
  verdicts(s.verdicts);
  showLoads(s.loads);
  rows("processes", s.processes, (p) => [[p.name + " (" + p.pid + ")"], [p.state, p.state === "waiting"], [p.rate.toFixed(0)], [p.age], [p.step], [p.late], [p.lost, p.lost > 0], [p.restarts, p.restarts > 0], [seconds(p.silent_s), p.silent_s > 1], [p.fault, p.fault !== "none"]]);
  rows("channels", s.channels, (c) => [[c.name], [c.rate.toFixed(0)], [grouped(c.count)], [c.lost, c.lost > 0], [seconds(c.silent_s), c.silent_s > 1]]);
  byId("link").textContent = (s.simulated ? "simulated: nothing is measured · " : "") + "live · " + s.viewers + (s.viewers === 1 ? " viewer" : " viewers") + (s.skipped ? " · " + s.skipped + " frames skipped by slow viewers" : "");
}

// ---- start

// What was known when the page was made: the verdict stands before the first event comes.
status(JSON.parse(byId("first").textContent));

const source = new EventSource("/events");
source.addEventListener("history", (e) => { frames.length = 0; JSON.parse(e.data).forEach(add); });
source.addEventListener("series", (e) => add(JSON.parse(e.data)));
source.addEventListener("status", (e) => status(JSON.parse(e.data)));
source.onerror = () => { byId("link").textContent = "the run has ended or cannot be reached; trying again …"; };
byId("pause").addEventListener("click", (e) => { paused = !paused; e.target.textContent = paused ? "Follow" : "Pause"; dirty = true; });
byId("methods").addEventListener("click", (e) => { allMethods = !allMethods; e.target.textContent = allMethods ? "Default method" : "All methods"; layout = ""; dirty = true; });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { layout = ""; dirty = true; });
addEventListener("resize", () => { for (const { plot, figure, wish } of charts.values()) plot.setSize({ width: figure.clientWidth, height: wish.wide ? 250 : 190 }); });
requestAnimationFrame(draw);
