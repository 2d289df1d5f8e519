// The plots of a report, to look closer at: drag over a stretch of time, and every plot follows. The
// SVG stays for print, and where no script runs.
const HUES = { truth: "--ink", trusted: "--good", holds: "--c0", limit: "--faint" };
const DASHES = { truth: [5, 3], limit: [2, 3] };
const hue = (item) => HUES[item.class] || "--c" + item.class.slice(1);
const WIDE = 260, HALF = 210;
const charts = [];
const all = JSON.parse(byId("plots").textContent);
const whole = [Math.min(...all.map((d) => d.x[0])), Math.max(...all.map((d) => d.x[1]))];
let shown = whole; // stretch of time on the screen

/** Position in the ascending `times` of the last that is not after `t`. */
function before(times, t) {
  let low = 0, high = times.length;
  while (low < high) { const middle = (low + high) >> 1; if (times[middle] <= t) low = middle + 1; else high = middle; }
  return Math.max(low - 1, 0);
}

/** The interval of the band at time `t`. */
function bandAt(item, t) {
  const [times, low, high] = item.band;
  const at = before(times, t);
  return low[at] === null || high[at] === null ? null : [low[at], high[at]];
}

/** Lines whole, bands but for their widest tenth, as in the SVG: a filter that has seen nothing would
 *  flatten everything else. Nothing that the quantity cannot be, unless a line goes there. */
function range(data, from, to) {
  if (data.y) return data.y;
  const least = data.possible[0] === null ? -Infinity : data.possible[0];
  const most = data.possible[1] === null ? Infinity : data.possible[1];
  let low = Infinity, high = -Infinity;
  const see = (v) => { if (v !== null) { low = Math.min(low, v); high = Math.max(high, v); } };
  for (const item of data.items) {
    if (item.line) {
      const [times, values] = item.line;
      // One more at either side: the line goes on beyond the edge.
      for (let i = before(times, from); i < times.length && (i === 0 || times[i - 1] <= to); i++) see(values[i]);
    } else if (item.band) {
      const widths = [];
      item.band[0].forEach((t, i) => {
        const a = item.band[1][i], b = item.band[2][i];
        if (t >= from && t <= to && a !== null && b !== null) widths.push([b - a, a, b]);
      });
      widths.sort((a, b) => a[0] - b[0]).slice(0, Math.ceil(widths.length * 0.9)).forEach((w) => { see(Math.max(w[1], least)); see(Math.min(w[2], most)); });
    } else if (item.level !== undefined) see(item.level);
  }
  if (!(low <= high)) return [0, 1];
  const room = 0.05 * (high - low) || 0.05 * Math.abs(high) || 1;
  return [Math.max(low === 0 ? 0 : low - room, Math.min(least, low)), Math.min(high + room, Math.max(most, high))];
}

/** Stretches and bands, behind the lines. */
function paint(u, data) {
  const { left, top, width, height } = u.bbox;
  const x = (t) => u.valToPos(t, "x", true), y = (v) => u.valToPos(v, "y", true);
  u.ctx.save();
  u.ctx.beginPath(); u.ctx.rect(left, top, width, height); u.ctx.clip();
  for (const item of data.items) {
    if (item.shade) {
      u.ctx.fillStyle = colour(hue(item)) + "22";
      item.shade[0].forEach((from, i) => u.ctx.fillRect(x(from), top, Math.max(1, x(item.shade[1][i]) - x(from)), height));
    } else if (item.band) {
      const [times, low, high] = item.band;
      u.ctx.fillStyle = colour(hue(item)) + (data.names.length ? "99" : "33");
      for (let from = 0, i = 0; i <= times.length; i++) {
        if (i < times.length && times[i] !== null && low[i] !== null && high[i] !== null) continue;
        if (i - from > 1) {
          u.ctx.beginPath();
          for (let k = from; k < i; k++) u.ctx.lineTo(x(times[k]), y(high[k]));
          for (let k = i - 1; k >= from; k--) u.ctx.lineTo(x(times[k]), y(low[k]));
          u.ctx.fill();
        }
        from = i + 1;
      }
    } else if (item.level !== undefined) {
      u.ctx.strokeStyle = colour(hue(item));
      u.ctx.setLineDash(DASHES.limit);
      u.ctx.beginPath(); u.ctx.moveTo(left, y(item.level)); u.ctx.lineTo(left + width, y(item.level)); u.ctx.stroke();
      u.ctx.setLineDash([]);
    }
  }
  u.ctx.restore();
}

/** Lines were thinned each on its own: the place of the value of `series` next to the cursor. */
function nearest(u, series, at) {
  const values = u.data[series], times = u.data[0];
  if (series === 0 || values[at] !== undefined) return at;
  let a = at, b = at;
  while (a > 0 && values[a] === undefined) a--;
  while (b < values.length - 1 && values[b] === undefined) b++;
  if (values[a] === undefined) return b;
  return values[b] === undefined || times[at] - times[a] <= times[b] - times[at] ? a : b;
}

function zoom(from, to) {
  shown = [from, to];
  for (const { plot } of charts) plot.setScale("x", { min: from, max: to });
}

function make(figure, data) {
  const lines = data.items.filter((item) => item.line);
  const labels = data.items.filter((item) => item.label && !item.line);
  const heading = element("h3", data.title);
  for (const item of labels) {
    const mark = element("span", item.label, "mark");
    mark.style.setProperty("--hue", "var(" + hue(item) + ")");
    heading.append(" ", mark);
  }
  const chart = element("div", undefined, "chart");
  chart.append(heading);
  figure.prepend(chart);
  figure.classList.add("drawn");
  const text = (line) => (u, v, series, at) => {
    if (v === null || v === undefined) return "–";
    const band = data.items.find((item) => item.band && item.class === line.class);
    const ends = band && bandAt(band, u.data[0][at]);
    return ends ? rounded(v, (ends[1] - ends[0]) / (2 * HALF_WIDTH_95)) : grouped(Number(v.toPrecision(4)));
  };
  const series = [{ label: "t [s]", value: (u, v) => (v === null || v === undefined ? "–" : v.toFixed(2)) }];
  for (const line of lines) series.push({ label: line.label, stroke: () => colour(hue(line)), width: 1.5, dash: DASHES[line.class], points: { show: false }, value: text(line) });
  const columns = lines.length ? uPlot.join(lines.map((line) => line.line)) : [data.x, [null, null]];
  // Without a line there is nothing to read off, but the scale wants a series.
  if (!lines.length) series.push({ label: "", show: true, points: { show: false }, class: "edge" });
  const places = data.names.map((n) => n[0]), names = data.names.map((n) => n[1]);
  const ordinate = names.length
    ? { ...axis, size: 24 + 7 * Math.max(...names.map((name) => name.length)), splits: () => places, values: () => names, grid: { show: false } }
    : { ...axis, size: room, values: (u, ticks) => ticks.map((v) => grouped(v)) };
  const size = () => ({ width: figure.clientWidth || 360, height: figure.classList.contains("wide") ? WIDE : HALF });
  const plot = new uPlot({
    ...size(), series,
    cursor: {
      drag: { x: true, y: false, setScale: false },
      sync: { key: "heft", filters: { pub: (type) => type === "mousemove" || type === "mouseleave" } },
      dataIdx: nearest,
    },
    scales: { x: { time: false, range: (u, from, to) => [from, to] }, y: { range: () => range(data, ...shown) } },
    axes: [{ ...axis, size: 30 }, ordinate],
    hooks: {
      drawClear: [(u) => paint(u, data)],
      ready: [(u) => u.over.addEventListener("dblclick", () => zoom(...whole))],
      setSelect: [(u) => {
        if (!(u.select.width > 2)) return;
        const [from, to] = [u.select.left, u.select.left + u.select.width].map((p) => u.posToVal(p, "x"));
        u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        zoom(from, to);
      }],
    },
  }, columns, chart);
  charts.push({ plot, size });
}

document.querySelectorAll("figure[data-plot]").forEach((figure) => make(figure, all[figure.dataset.plot]));
zoom(...whole);
const hint = element("p", "Drag over a plot to look closer, double-click for the whole; the numbers follow the cursor.", "note screen");
const first = document.querySelector("figure[data-plot]");
if (first) first.closest("section").querySelector("h2").after(hint);
const redraw = () => charts.forEach(({ plot }) => plot.redraw());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
addEventListener("resize", () => charts.forEach(({ plot, size }) => plot.setSize(size())));
