// The page's behaviour: what is chosen, the map of it, and the chosen and pinned cells in numbers.
"use strict";

const ALL = -1;
const STATISTICS = { median: "median", p84: "84th percentile", largest: "largest", smallest: "smallest" };
const COMPLETE = 0;
const NEEDED = "peak_closing_free"; // the gap that a motion needs
const MOST_TICKS = 13;
const SIMULATED = { 0: "known exactly from another run", 1: "a run of its own" };
const SENSITIVE = { "-1": "not recomputed", 0: "steady", 1: "sensitive" };

const model = JSON.parse(document.getElementById("model").textContent);
const axes = Object.fromEntries(model.axes.map((axis) => [axis.name, axis]));
const buildings = axes.building ? axes.building.labels : [];
const state = { picks: {}, output: 0, statistic: "median", steady: false, cell: { gap: 0, yield_force: 0 }, pins: {} };
let outputs = []; // one for each variable, or for each variable and building

const element = (id) => document.getElementById(id);
const size = (axis) => axes[axis].labels.length;
const plain = (name) => name.replaceAll("_", " ");

// ---- data ---------------------------------------------------------------------------------------------------------

/** The numbers of a packed variable; its bytes are sorted by their place in each number. */
async function unpacked(variable) {
  const bytes = Uint8Array.from(atob(variable.data), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const sorted = new Uint8Array(await new Response(stream).arrayBuffer());
  const count = sorted.length / 4;
  const joined = new Uint8Array(sorted.length);
  for (let byte = 0; byte < 4; byte += 1) {
    for (let place = 0; place < count; place += 1) joined[4 * place + byte] = sorted[byte * count + place];
  }
  return variable.kind === "f4" ? new Float32Array(joined.buffer) : new Int32Array(joined.buffer);
}

/** Unpack a variable in place, and note how far apart its neighbours along each axis stand. */
async function load(variable) {
  variable.values = await unpacked(variable);
  delete variable.data;
  variable.strides = [];
  let stride = 1;
  for (const axis of [...variable.dims].reverse()) {
    variable.strides.unshift(stride);
    stride *= size(axis);
  }
  return variable;
}

/** The stored number of a case. */
function stored(variable, place) {
  let offset = 0;
  variable.dims.forEach((axis, rank) => { offset += variable.strides[rank] * place[axis]; });
  return variable.values[offset];
}

/** An output of a complete case in the unit shown; NaN where it is not defined, which counts tell by −1. */
function reading(output, place) {
  const value = stored(output.variable, { ...place, building: buildingOf(output, place) });
  return output.variable.kind === "i4" && value < 0 ? NaN : value * output.variable.factor;
}

/** Of a row the building left or right of the interface; of a pair the output's own. */
const buildingOf = (output, place) => (output.side === undefined ? output.building : place.interface + output.side);

/** Every case that the picks mean at a cell: one, or one for each motion. */
function places(picks, cell) {
  let found = [{ ...cell }];
  for (const axis of model.pickers) {
    const wanted = picks[axis] === ALL ? [...Array(size(axis)).keys()] : [picks[axis]];
    found = found.flatMap((place) => wanted.map((index) => ({ ...place, [axis]: index })));
  }
  return found;
}

const isMany = (picks) => model.pickers.some((axis) => picks[axis] === ALL);
const hasFailed = (place) => stored(model.states.status, place) !== COMPLETE;

/** What an output is at a cell: {value, defined, failed, runs, motion}; value NaN where no case has one. */
function summary(output, picks, statistic, cell) {
  const result = { value: NaN, defined: 0, failed: 0, runs: 0, motion: "" };
  const found = [];
  for (const place of places(picks, cell)) {
    result.runs += 1;
    // What there is without contact stands whatever became of the run.
    if (!output.free && hasFailed(place)) {
      result.failed += 1;
      continue;
    }
    const value = reading(output, place);
    if (!Number.isNaN(value)) found.push({ value, place });
  }
  result.defined = found.length;
  if (!found.length) return result;
  found.sort((one, other) => one.value - other.value);
  if (output.variable.share) result.value = found.reduce((sum, each) => sum + each.value, 0) / found.length;
  else if (statistic === "largest" || statistic === "smallest") {
    const extreme = statistic === "largest" ? found[found.length - 1] : found[0];
    result.value = extreme.value;
    result.motion = motionWords(picks, extreme.place);
  } else {
    const rising = found.map((each) => each.value);
    const isNeeded = output.variable.name === NEEDED && statistic === "p84";
    result.value = isNeeded ? counted(rising, 0.84) : quantile(rising, statistic === "median" ? 0.5 : 0.84);
  }
  return result;
}

/** The smallest of ascending numbers that this share of them do not exceed, as an assessment counts required gaps. */
const counted = (values, share) => values[Math.ceil(share * values.length - 1e-9) - 1];

/** A quantile of ascending numbers, linear between them. */
function quantile(values, share) {
  const at = share * (values.length - 1);
  const low = Math.floor(at);
  const high = Math.min(low + 1, values.length - 1);
  return values[low] + (at - low) * (values[high] - values[low]);
}

// ---- words --------------------------------------------------------------------------------------------------------

function numberWords(value) {
  if (Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return "∞";
  if (Number.isInteger(value) && Math.abs(value) < 1e6) return String(value);
  const large = Math.abs(value) >= 1e6 || Math.abs(value) < 1e-3;
  return (large ? value.toExponential(3) : String(Number(value.toPrecision(4)))).replace("-", "−");
}

const withUnit = (axis, index) => `${axes[axis].labels[index]} ${axes[axis].unit}`.trim();
const isNumber = (label) => /^[0-9]/.test(label);
const forceWords = (index) => (isNumber(axes.yield_force.labels[index]) ? withUnit("yield_force", index) : axes.yield_force.labels[index]);
const cellWords = (cell) => `gap ${withUnit("gap", cell.gap)}, yield force ${forceWords(cell.yield_force)}`;
const motionWords = (picks, place) =>
  model.together.filter((axis) => picks[axis] === ALL).map((axis) => axes[axis].labels[place[axis]]).join(", ");

function pickWords(picks, axis) {
  if (picks[axis] !== ALL) return `${axes[axis].is_number ? `${axes[axis].title} ` : ""}${axes[axis].labels[picks[axis]]}`;
  return axis === "polarity" && size(axis) === 2 ? "both polarities" : `all ${size(axis)} ${plural(axes[axis].title)}`;
}

const plural = (word) => (word.endsWith("y") ? `${word.slice(0, -1)}ies` : `${word}s`);

/** A number with its unit; a share as yes or no, or of how many. */
function valueWords(output, result, many) {
  if (Number.isNaN(result.value)) return result.failed && result.failed === result.runs ? "× failed" : "–";
  // Of a time of the first touch, say, only motions with a touch have one.
  const some = result.defined < result.runs - result.failed ? ` (of ${result.defined})` : "";
  if (!output.variable.share) return `${numberWords(result.value)} ${output.variable.unit}`.trim() + some;
  if (!many) return result.value ? "yes" : "no";
  const percent = numberWords(Number((100 * result.value).toPrecision(3)));
  return `${percent} % (${Math.round(result.value * result.defined)} of ${result.defined})`;
}

function kindWords(output, picks, statistic) {
  if (!isMany(picks)) return "";
  return output.variable.share ? "share of motions" : STATISTICS[statistic];
}

/** How the cases of a cell ended, in a sentence. */
function endWords(picks, cell) {
  const found = places(picks, cell);
  const failed = found.filter(hasFailed);
  const reasons = [...new Set(failed.map((place) => model.statuses[stored(model.states.status, place)] || "unknown"))];
  if (found.length === 1) return failed.length ? `× failed: ${reasons[0]}` : "complete";
  const runs = `${found.length} motions`;
  return failed.length ? `${runs}, × ${failed.length} failed: ${reasons.join("; ")}` : `${runs}, all complete`;
}

/** Which of these words holds, or how often each does. */
function countWords(variable, words, picks, cell) {
  const counts = new Map();
  for (const place of places(picks, cell)) {
    const said = words[stored(variable, place)];
    counts.set(said, (counts.get(said) || 0) + 1);
  }
  const many = isMany(picks);
  return [...counts].map(([said, count]) => (many ? `${count} × ${said}` : said)).join("; ");
}

// ---- choices ------------------------------------------------------------------------------------------------------

function addSelect(title, options, chosen, change) {
  const label = document.createElement("label");
  const select = document.createElement("select");
  label.append(title, select);
  for (const [value, words] of options) select.add(new Option(words, value, false, String(value) === String(chosen)));
  select.name = title;
  select.addEventListener("change", () => { change(select.value); draw(); });
  element("picks").append(label);
  return select;
}

function addChoices() {
  for (const axis of model.pickers) {
    const options = axes[axis].labels.map((label, index) => {
      const note = axes[axis].notes[index];
      return [index, note ? `${label} (${note})` : label];
    });
    const together = model.together.includes(axis) && size(axis) > 1;
    state.picks[axis] = together ? ALL : model.start[axis] ?? 0;
    if (together) options.unshift([ALL, pickWords({ [axis]: ALL }, axis)]);
    addSelect(axes[axis].title, options, state.picks[axis], (value) => { state.picks[axis] = Number(value); });
  }
  const drawn = outputs.map((output, index) => [index, output]).filter(([, output]) => !output.free);
  const titled = ([index, output]) => [index, `${output.label} ${output.variable.unit && `[${output.variable.unit}]`}`.trim()];
  addSelect("output", drawn.map(titled), 0, (value) => { state.output = Number(value); });
  if (model.together.some((axis) => size(axis) > 1)) {
    const select = addSelect("of several motions", Object.entries(STATISTICS), "median", (value) => { state.statistic = value; });
    select.id = "statistic";
  }
  const label = document.createElement("label");
  label.className = "check";
  const check = Object.assign(document.createElement("input"), { type: "checkbox", id: "steady" });
  label.append(check, "one colour scale for all choices");
  check.addEventListener("change", () => { state.steady = check.checked; draw(); });
  element("picks").append(label);
}

function choose(cell) {
  const within = (axis) => Math.max(0, Math.min(size(axis) - 1, cell[axis]));
  state.cell = { gap: within("gap"), yield_force: within("yield_force") };
  draw();
}

function pin(letter) {
  state.pins[letter] = { picks: { ...state.picks }, statistic: state.statistic, cell: { ...state.cell } };
  draw();
}

function onKey(event) {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  const { gap, yield_force: force } = state.cell;
  const moves = {
    ArrowLeft: [gap - 1, force], ArrowRight: [gap + 1, force], ArrowDown: [gap, force - 1], ArrowUp: [gap, force + 1],
    Home: [0, force], End: [Infinity, force],
  };
  const letter = event.key.toUpperCase();
  if (moves[event.key]) choose({ gap: moves[event.key][0], yield_force: moves[event.key][1] });
  else if (letter === "A" || letter === "B") pin(letter);
  else return;
  event.preventDefault();
}

// ---- the map ------------------------------------------------------------------------------------------------------

/** Least and largest number of an output in all cases. */
function wholeRange(output) {
  if (!output.range) {
    output.range = [Infinity, -Infinity];
    const { values, kind, factor, dims, strides } = output.variable;
    const rank = output.side === undefined ? dims.indexOf("building") : -1; // of a row, over all buildings
    values.forEach((value, offset) => {
      if (Number.isNaN(value) || (kind === "i4" && value < 0)) return;
      if (rank >= 0 && Math.floor(offset / strides[rank]) % buildings.length !== output.building) return;
      output.range = [Math.min(output.range[0], value * factor), Math.max(output.range[1], value * factor)];
    });
  }
  return output.range;
}

function colours(output, cells) {
  const values = cells.flat().map((result) => result.value).filter(Number.isFinite);
  let [low, high] = [0, 1];
  if (!output.variable.share && values.length) {
    [low, high] = state.steady
      ? wholeRange(output) : values.reduce(([a, b], value) => [Math.min(a, value), Math.max(b, value)], [Infinity, -Infinity]);
    if (low === high) high = low + (Math.abs(low) || 1);
  }
  const bar = { title: { text: output.variable.unit ? `[${output.variable.unit}]` : "", side: "right" }, outlinewidth: 1 };
  if (output.variable.share && isMany(state.picks)) bar.tickformat = ".0%";
  else if (output.variable.share) Object.assign(bar, { tickvals: [0, 1], ticktext: ["no", "yes"] });
  return { zmin: low, zmax: high, colorbar: bar, showscale: values.length > 0 };
}

function axisLayout(axis) {
  const labels = axes[axis].labels;
  const every = Math.ceil(labels.length / MOST_TICKS);
  const shown = [...labels.keys()].filter((index) => index % every === 0 || !isNumber(labels[index]));
  return {
    title: { text: `${axes[axis].title.replace("F_E", "<i>F</i><sub>E</sub>")} [${axes[axis].unit}]`, standoff: 10 },
    tickvals: shown, ticktext: shown.map((index) => labels[index]),
    range: [-0.5, labels.length - 0.5], showgrid: false, zeroline: false, linecolor: "#555", mirror: true,
  };
}

const frame = (cell, color, width) => ({
  type: "rect", x0: cell.gap - 0.5, x1: cell.gap + 0.5, y0: cell.yield_force - 0.5, y1: cell.yield_force + 0.5,
  line: { color, width },
});

function pinNotes() {
  const letters = {};
  for (const letter of Object.keys(state.pins).sort()) {
    const { gap, yield_force: force } = state.pins[letter].cell;
    const key = `${gap} ${force}`;
    letters[key] = { gap, force, text: (letters[key]?.text || "") + letter };
  }
  return Object.values(letters).map(({ gap, force, text }) => ({
    x: gap, y: force, text: `<b>${text}</b>`, showarrow: false, bgcolor: "#fff", bordercolor: "#000", borderpad: 2,
    font: { color: "#000", size: 13 },
  }));
}

function drawMap(output) {
  const many = isMany(state.picks);
  const rows = [...axes.yield_force.labels.keys()];
  const columns = [...axes.gap.labels.keys()];
  const at = (force, gap) => summary(output, state.picks, state.statistic, { gap, yield_force: force });
  const cells = rows.map((force) => columns.map((gap) => at(force, gap)));
  const said = (result, gap, force) => {
    const failed = result.failed && result.failed < result.runs ? `<br>× ${result.failed} of ${result.runs} failed, left out` : "";
    return `${cellWords({ gap, yield_force: force })}<br><b>${valueWords(output, result, many)}</b>${failed}`;
  };
  const text = cells.map((row, force) => row.map((result, gap) => said(result, gap, force)));
  const failed = cells.flatMap((row, force) => row.map((result, gap) => ({ result, gap, force }))).filter(({ result }) => result.failed);
  const heat = {
    type: "heatmap", z: cells.map((row) => row.map(({ value }) => (Number.isFinite(value) ? value : null))), text,
    hoverinfo: "text", hoverongaps: true, colorscale: "Cividis", reversescale: true, xgap: 1, ygap: 1, ...colours(output, cells),
  };
  const crosses = {
    type: "scatter", mode: "markers", x: failed.map(({ gap }) => gap), y: failed.map(({ force }) => force),
    text: failed.map(({ result, gap, force }) => said(result, gap, force)), hoverinfo: "text", showlegend: false,
    marker: { symbol: "x", size: 11, color: "#000", line: { color: "#fff", width: 1.5 } },
  };
  const layout = {
    margin: { l: 75, r: 10, t: 34, b: 55 }, plot_bgcolor: "#fff", paper_bgcolor: "#fff", uirevision: "map",
    font: { family: 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif', size: 13, color: "#1a1a1a" },
    xaxis: axisLayout("gap"), yaxis: { ...axisLayout("yield_force"), automargin: true },
    shapes: [frame(state.cell, "#fff", 6), frame(state.cell, "#d55e00", 3)], annotations: pinNotes(),
  };
  // By name, because Plotly's own choice has a button that would upload the chart.
  const buttons = [["toImage"], ["zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d"]];
  const config = { responsive: true, displaylogo: false, modeBarButtons: buttons, plotlyServerURL: "" };
  return Plotly.react("map", [heat, crosses], layout, config);
}

function drawWords(output) {
  const many = isMany(state.picks);
  const kind = kindWords(output, state.picks, state.statistic);
  element("shown").textContent = `${output.label}${kind && `, ${kind}`}`;
  element("words").textContent = `${output.words}. Of ${model.pickers.map((axis) => pickWords(state.picks, axis)).join(", ")}.`;
  const result = summary(output, state.picks, state.statistic, state.cell);
  const under = result.motion && `, under ${result.motion}`;
  const ends = endWords(state.picks, state.cell);
  element("reading").textContent = `${cellWords(state.cell)}: ${valueWords(output, result, many)}${under}; ${ends}.`;
  const legend = [["chosen", "\u00a0", "the chosen cell"], ["", "\u00a0", "blank: not defined, such as the time of a touch where there is none"]];
  const marks = many ? "a run failed and is left out of the number" : "the run failed; no number";
  if (model.anyFailed) legend.push(["", "×", marks]);
  if (many) legend.push(["", "(of 7)", "so many of the motions have such a number"]);
  legend.push(["", "A", "pinned; its choices are listed in the table"]);
  const columns = model.pickers.includes("interface") ? ", but columns with a yield force of their own" : "";
  legend.push(["", "none", `on the axis of yield forces: nothing yields${columns}. Laws without a cap are the same at every yield force`]);
  element("legend").replaceChildren(...legend.map(([kindOf, mark, words]) => {
    const item = document.createElement("li");
    const sign = Object.assign(document.createElement("b"), { className: kindOf, textContent: mark });
    item.append(sign, words);
    return item;
  }));
}

// ---- the table ----------------------------------------------------------------------------------------------------

function tableCell(kind, words, className = "") {
  return Object.assign(document.createElement(kind), { textContent: words, className });
}

function tableRow(head, words, cells, className = "") {
  const row = Object.assign(document.createElement("tr"), { className });
  const name = tableCell("th", head);
  name.scope = "row";
  if (words) name.append(tableCell("small", words));
  row.append(name, ...cells);
  return row;
}

function headCell(title, shown) {
  const head = tableCell("th", title);
  head.scope = "col";
  const lines = [...model.pickers.map((axis) => pickWords(shown.picks, axis)), cellWords(shown.cell)];
  if (isMany(shown.picks)) lines.push(`${STATISTICS[shown.statistic]} of the motions`);
  head.append(...lines.map((line) => tableCell("span", line)));
  return head;
}

function ratioWords(output, result) {
  const [one, other] = result.map((each) => each.value);
  if (output.variable.share || !Number.isFinite(one) || !Number.isFinite(other) || one === 0) return "–";
  return numberWords(other / one);
}

function drawTable() {
  const columns = [["chosen cell", { picks: state.picks, statistic: state.statistic, cell: state.cell }]];
  for (const letter of ["A", "B"]) if (state.pins[letter]) columns.push([`pinned ${letter}`, state.pins[letter]]);
  const compares = columns.length === 3;
  const heads = columns.map(([title, shown]) => headCell(title, shown));
  if (compares) heads.push(Object.assign(tableCell("th", "B / A"), { scope: "col" }));
  const top = tableRow("output", "", heads);
  top.firstChild.scope = "col";
  element("table").tHead.replaceChildren(top);
  const said = (words) => [...columns.map(([, { picks, cell }]) => tableCell("td", words(picks, cell), "words")),
    ...(compares ? [tableCell("td", "")] : [])];
  const rows = [tableRow("how the run ended", "", said(endWords))];
  for (const [name, title, words] of [["simulated", "solved by", SIMULATED], ["sensitive", "recomputed at a tighter tolerance", SENSITIVE]]) {
    const variable = model.states[name];
    if (variable) rows.push(tableRow(title, "", said((picks, cell) => countWords(variable, words, picks, cell))));
  }
  outputs.forEach((output, index) => {
    const result = columns.map(([, { picks, statistic, cell }]) => summary(output, picks, statistic, cell));
    const cells = result.map((each, column) => tableCell("td", valueWords(output, each, isMany(columns[column][1].picks))));
    if (compares) cells.push(tableCell("td", ratioWords(output, result.slice(1))));
    const row = tableRow(output.label, output.words, cells, index === state.output ? "shown" : "");
    row.dataset.output = output.key;
    rows.push(row);
  });
  element("table").tBodies[0].replaceChildren(...rows);
}

// ---- storeys of a row ---------------------------------------------------------------------------------------------

const BANDS = [0.16, 0.5, 0.84];
const LOOKS = { free: ["#0072b2", "solid", "without contact"], struck: ["#d55e00", "dash", "with contact"] };

/** Three quantiles of a quantity of one storey over the motions that are picked; NaN where no run is complete. */
function spread(variable, building, storey, picks, cell) {
  const values = places(picks, cell).filter((place) => !hasFailed(place))
    .map((place) => stored(variable, { ...place, building, storey }) * variable.factor)
    .filter(Number.isFinite).sort((one, other) => one - other);
  return BANDS.map((share) => (values.length ? quantile(values, share) : NaN));
}

/** Lines of one building: one value all along a storey, or one at each floor. */
function profileTraces(quantity, building, axis) {
  const levels = model.profiles.levels[building];
  return Object.entries(LOOKS).flatMap(([kind, [color, dash, name]]) => {
    const found = levels.map((_, storey) => spread(quantity[kind], building, storey, state.picks, state.cell));
    const along = (rank) => (quantity.of_storey ? found.flatMap((each) => [each[rank], each[rank]]) : found.map((each) => each[rank]));
    const heights = quantity.of_storey ? levels.flatMap((level, storey) => [storey ? levels[storey - 1] : 0, level]) : levels;
    const shared = { type: "scatter", y: heights, xaxis: axis, yaxis: "y", hoverinfo: "x+y" };
    const band = { ...shared, mode: "lines", line: { width: 0 }, showlegend: false, hoverinfo: "skip" };
    const line = { ...shared, x: along(1), mode: quantity.of_storey ? "lines" : "lines+markers", name, showlegend: axis === "x",
      line: { color, dash, width: 2.5 }, legendgroup: kind };
    if (!isMany(state.picks)) return [line];
    return [{ ...band, x: along(0) }, { ...band, x: along(2), fill: "tonextx", fillcolor: `${color}2e` }, line];
  });
}

function drawProfiles() {
  if (!model.profiles) return null;
  const quantity = model.profiles.quantities[state.quantity];
  const at = state.picks.interface;
  const sides = [at, at + 1];
  const traces = sides.flatMap((building, side) => profileTraces(quantity, building, side ? "x2" : "x"));
  const reach = (axis) => Math.max(0, ...traces.filter((each) => each.xaxis === axis).flatMap((each) => each.x.filter(Number.isFinite)));
  const title = (building, axis) => ({
    title: { text: `${buildings[building]} [${quantity.struck.unit}]` }, range: [0, 1.05 * reach(axis) || 1], zeroline: false,
  });
  const marks = model.profiles.points.filter(([interface_]) => interface_ === at).map(([, level]) => ({
    type: "line", xref: "paper", x0: 0, x1: 1, y0: level, y1: level, line: { color: "#555", width: 1, dash: "dot" },
  }));
  const middle = isMany(state.picks) ? "Medians, and 16 to 84 % of the motions. " : "";
  element("storeys-words").textContent = `${middle}Dotted: levels of contact.`;
  const layout = {
    margin: { l: 55, r: 10, t: 10, b: 50 }, plot_bgcolor: "#fff", paper_bgcolor: "#fff", shapes: marks,
    font: { family: 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif', size: 13, color: "#1a1a1a" },
    xaxis: { ...title(sides[0], "x"), domain: [0, 0.48] }, xaxis2: { ...title(sides[1], "x2"), domain: [0.52, 1] },
    yaxis: { title: { text: "height [m]" }, rangemode: "tozero" }, legend: { orientation: "h", y: 1.1 },
  };
  return Plotly.react("profiles", traces, layout, { responsive: true, displayModeBar: false, plotlyServerURL: "" });
}

function addQuantities() {
  if (!model.profiles) return;
  element("storeys").hidden = false;
  state.quantity = 0;
  model.profiles.quantities.forEach(({ struck }, index) => element("quantity").add(new Option(`${plain(struck.name)} [${struck.unit}]`, index)));
  element("quantity").addEventListener("change", (event) => { state.quantity = Number(event.target.value); drawProfiles(); });
}

// ---- start --------------------------------------------------------------------------------------------------------

function draw() {
  const output = outputs[state.output];
  const select = element("statistic");
  if (select) select.disabled = !isMany(state.picks) || output.variable.share;
  drawWords(output);
  drawTable();
  drawProfiles();
  return drawMap(output);
}

/** One output for each variable, or for each building of a variable. */
function outputsOf(variable) {
  const free = !variable.dims.includes("gap");
  const label = plain(variable.name).replace(/ free$/, " without contact");
  const words = variable.words.replace(/; without contact$/, "");
  const shared = { variable, free, words };
  if (!variable.dims.includes("building")) return [{ ...shared, label, key: variable.name }];
  if (axes.interface) {
    return ["left", "right"].map((name, side) => ({ ...shared, side, label: `${label}, ${name}`, key: `${variable.name} ${name}` }));
  }
  return buildings.map((name, building) => ({ ...shared, building, label: `${label}, ${name}`, key: `${variable.name} ${building}` }));
}

async function start() {
  element("facts").textContent = model.facts.join(" ");
  element("scene").hidden = !model.scene;
  element("scene").querySelector("pre").textContent = model.scene;
  const deep = model.profiles ? model.profiles.quantities.flatMap(({ struck, free }) => [struck, free]) : [];
  if (model.profiles) axes.storey = { labels: [...Array(model.profiles.storeys).keys()] };
  await Promise.all([...Object.values(model.states), ...model.outputs, ...deep].map(load));
  outputs = model.outputs.flatMap(outputsOf);
  model.anyFailed = model.states.status.values.some((code) => code !== COMPLETE);
  state.cell = { gap: model.start.gap ?? 0, yield_force: model.start.yield_force ?? 0 };
  addChoices();
  addQuantities();
  document.querySelector("main").hidden = false;
  await draw();
  element("map").on("plotly_click", ({ points: [point] }) => choose({ gap: Math.round(point.x), yield_force: Math.round(point.y) }));
  element("map").addEventListener("keydown", onKey);
  for (const letter of ["A", "B"]) element(`pin-${letter}`).addEventListener("click", () => pin(letter));
  element("unpin").addEventListener("click", () => { state.pins = {}; draw(); });
  document.body.dataset.ready = "yes";
}

start().catch((error) => {
  element("trouble").hidden = false;
  element("trouble").textContent = `The page cannot show its data: ${error.message}. It needs a browser of 2023 or later.`;
});
