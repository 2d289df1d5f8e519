"use strict";
// What the live page and the report share: numbers, colours, axes.
/** Half the width of a 95 % interval, in standard deviations, as `estimation::HALF_WIDTH_95`. */
const HALF_WIDTH_95 = 1.96;

const byId = (id) => document.getElementById(id);
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// Thousands apart, as everywhere in heft.
const grouped = (v, places) => v.toLocaleString("en", { minimumFractionDigits: places || 0, maximumFractionDigits: places === undefined ? 6 : places }).replaceAll(",", "\u00a0").replace("-", "\u2212");

/** "8 257 ± 90": both with the places that two digits of the standard deviation need. */
function rounded(v, std) {
  if (!(std > 0)) return grouped(Number(v.toPrecision(4)));
  const places = 1 - Math.floor(Math.log10(std)), unit = 10 ** -Math.min(places, 0);
  const show = (x) => grouped(places < 0 ? Math.round(x / unit) * unit : x, Math.min(Math.max(places, 0), 9));
  return show(v) + " \u00b1 " + show(std);
}

function element(tag, text, className) {
  const e = document.createElement(tag);
  if (text !== undefined) e.textContent = text;
  if (className) e.className = className;
  return e;
}

const axis = { stroke: () => colour("--faint"), grid: { stroke: () => colour("--rule"), width: 1 }, ticks: { stroke: () => colour("--rule") }, font: "12px system-ui" };
/** Room for the longest label beside an axis [px]. */
const room = (u, labels) => 20 + 7 * Math.max(6, ...(labels || []).map((label) => label.length));
