// A row in elevation, moving: what is drawn at a frame, and how the frames run.
"use strict";

const WIDEST = 9; // m, of a building as drawn
const BROADEST = 1.5; // of the tallest building's height
const ALL = 150; // m, of all buildings of a long row together
const REACH = 0.35; // of a building's width, that the largest displacement is drawn
const LARGEST_MARK = 0.16; // of a building's width, radius of the strongest contact
const MOST_NAMED = 4; // contacts named at a time

const model = JSON.parse(document.getElementById("model").textContent);
const element = (id) => document.getElementById(id);
const state = { frame: 0, runs: false, since: 0, from: 0 };
const { buildings, points } = model;
const tallest = Math.max(...buildings.map((each) => each.levels[each.levels.length - 1]));
const width = Math.min(WIDEST, ALL / buildings.length, BROADEST * tallest);
let displacement; // one number for each frame and floor, in steps of model.largest
let force; // one for each frame and contact point, in steps of model.strongest
let strongest; // the largest force of each frame [N]
let scale = 1; // displacements and gaps are drawn larger so many times

/** The 16-bit numbers of a packed array; its bytes are sorted by their place in each number. */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const sorted = new Uint8Array(await new Response(stream).arrayBuffer());
  const count = sorted.length / 2;
  const joined = new Uint8Array(sorted.length);
  for (let place = 0; place < count; place += 1) {
    joined[2 * place] = sorted[place];
    joined[2 * place + 1] = sorted[count + place];
  }
  return new Int16Array(joined.buffer);
}

/** Differences from frame to frame, summed up. */
function summed(differences, floors) {
  for (let place = floors; place < differences.length; place += 1) differences[place] += differences[place - floors];
  return differences;
}

function add(parent, kind, attributes, text) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", kind);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== undefined) made.textContent = text;
  parent.append(made);
  return made;
}

/** The largest of 1, 2, 5, 10, 20 ... by which the largest displacement and gap stay within reach. */
function roundScale() {
  const steps = displacement.reduce((most, each) => Math.max(most, Math.abs(each)), 0);
  const widest = Math.max(steps * model.largest, 0.5 * Math.max(0, ...model.gaps), 1e-9);
  const most = (REACH * width) / widest;
  const power = 10 ** Math.floor(Math.log10(most));
  return Math.max(1, [5, 2, 1].map((digit) => digit * power).find((each) => each <= most));
}

/** Displacement of each floor of a building at a frame [m as drawn], the ground's first. */
function floorsAt(frame, building) {
  const found = [0];
  for (let floor = 0; floor < building.floors; floor += 1) {
    found.push(displacement[frame * model.floors + building.first + floor] * model.largest * scale);
  }
  while (found.length <= building.levels.length) found.push(building.floors ? found[found.length - 1] : 0);
  return found;
}

function outline(building, moved) {
  const heights = [0, ...building.levels];
  const side = (x) => heights.map((height, floor) => `${(x + moved[floor]).toFixed(3)} ${(-height).toFixed(3)}`);
  const slabs = heights.slice(1, -1).map((height, place) => {
    const x = building.wall + moved[place + 1];
    return `M${x.toFixed(3)} ${-height}h${width}`;
  });
  return `M${side(building.wall).join("L")}L${side(building.wall + width).reverse().join("L")}Z${slabs.join("")}`;
}

/** Where a floor number of a building is: between two floors, part-way along the column. */
function placeAt(building, moved, floor) {
  const heights = [0, ...building.levels];
  const below = Math.min(Math.floor(floor), heights.length - 1);
  const part = below + 1 < heights.length ? floor - below : 0;
  const between = (values) => values[below] + (part ? part * (values[below + 1] - values[below]) : 0);
  return { x: between(moved), y: -between(heights) };
}

function forceWords(value) {
  return value >= 1e6 ? `${(value / 1e6).toPrecision(3)} MN` : `${Number((value / 1e3).toPrecision(3))} kN`;
}

function layOut() {
  let wall = 0;
  let first = 0;
  buildings.forEach((building, place) => {
    Object.assign(building, { wall, first });
    first += building.floors;
    wall += width + scale * (model.gaps[place] || 0);
  });
  model.floors = first;
  const right = buildings[buildings.length - 1].wall + width;
  const margin = 0.6 * width;
  const row = element("row");
  const letters = 0.15 * width;
  const top = tallest + Math.max(0.12 * tallest, LARGEST_MARK * width);
  row.setAttribute("viewBox", `${-margin} ${-top} ${right + 2 * margin} ${top + 2.2 * letters}`);
  for (const building of buildings) {
    const still = building.levels.map(() => 0);
    add(row, "path", { class: "rest", d: outline(building, [0, ...still]) });
    building.path = add(row, "path", { class: `building ${building.rigid ? "rigid" : ""}` });
    const words = { x: building.wall + width / 2, y: 1.5 * letters, "text-anchor": "middle", "font-size": letters };
    add(row, "text", words, building.name);
  }
  add(row, "line", { class: "ground", x1: -margin, x2: right + margin, y1: 0, y2: 0 });
  for (const point of points) {
    const long = scale * (model.bumpers[point.interface] || 0);
    if (long > 0) point.bumper = add(row, "rect", { class: "bumper", width: long, height: 0.06 * width });
  }
  for (const point of points) point.mark = add(row, "circle", { class: "quiet", r: 0.03 * width });
  drawForces();
  element("at").max = model.frames - 1;
  const forces = `line: largest contact force, 0 to ${forceWords(Math.max(...strongest))}`;
  element("scale").textContent = `Given heights to scale; displacements and gaps × ${scale}; ${model.rate} frames a second; ${forces}.`;
}

function drawForces() {
  const graph = element("forces");
  const most = Math.max(...strongest, 1);
  graph.setAttribute("viewBox", `0 -1.05 ${model.frames - 1} 1.1`);
  const line = strongest.map((value, frame) => `${frame} ${(-value / most).toFixed(4)}`);
  add(graph, "path", { class: "line", d: `M${line.join("L")}` });
  graph.cursor = add(graph, "line", { class: "cursor", y1: -1.05, y2: 0.05 });
}

function draw() {
  const { frame } = state;
  const moved = buildings.map((building) => floorsAt(frame, building));
  buildings.forEach((building, place) => building.path.setAttribute("d", outline(building, moved[place])));
  const most = Math.max(...strongest, 1);
  const touching = [];
  points.forEach((point, place) => {
    const [left, right] = [buildings[point.interface], buildings[point.interface + 1]];
    const one = placeAt(left, moved[point.interface], point.left);
    const other = placeAt(right, moved[point.interface + 1], point.right);
    const value = force[frame * points.length + place] * model.strongest;
    const y = (one.y + other.y) / 2;
    if (point.bumper) {
      point.bumper.setAttribute("x", (left.wall + width + one.x).toFixed(3));
      point.bumper.setAttribute("y", (y - 0.03 * width).toFixed(3));
    }
    const x = (left.wall + width + one.x + right.wall + other.x) / 2;
    const radius = value > 0 ? Math.max(0.05, LARGEST_MARK * Math.sqrt(value / most)) * width : 0.03 * width;
    for (const [name, number] of [["cx", x], ["cy", y], ["r", radius]]) point.mark.setAttribute(name, number.toFixed(3));
    point.mark.setAttribute("class", value > 0 ? "touch" : "quiet");
    if (value > 0) {
      touching.push([value, point]);
      point.mark.parentNode.append(point.mark); // above the marks of other points at the same place
    }
  });
  touching.sort(([one], [other]) => other - one);
  const named = touching.slice(0, MOST_NAMED).map(([value, { label, kind }]) => `${label} (${kind}) ${forceWords(value)}`);
  if (touching.length > MOST_NAMED) named.push(`${touching.length - MOST_NAMED} more`);
  element("reading").textContent = `${model.time[frame].toFixed(3)} s. ${named.length ? `Contact: ${named.join("; ")}.` : ""}`;
  element("at").value = frame;
  element("at").setAttribute("aria-valuetext", `${model.time[frame].toFixed(2)} s`);
  const { cursor } = element("forces");
  cursor.setAttribute("x1", frame);
  cursor.setAttribute("x2", frame);
}

function show(frame) {
  state.frame = Math.max(0, Math.min(model.frames - 1, frame));
  Object.assign(state, { since: performance.now(), from: state.frame });
  draw();
}

function step(now) {
  if (!state.runs) return;
  const speed = Number(element("speed").value);
  const frame = Math.min(model.frames - 1, state.from + Math.floor((now - state.since) / 1000 * model.rate * speed));
  if (frame > state.frame) {
    state.frame = frame;
    draw();
  }
  if (frame === model.frames - 1) run(false);
  else requestAnimationFrame(step);
}

function run(runs) {
  state.runs = runs;
  element("play").textContent = runs ? "Pause" : "Play";
  if (!runs) return;
  show(state.frame === model.frames - 1 ? 0 : state.frame);
  requestAnimationFrame(step);
}

/** To the strongest frame of the next contact, or of the one before. */
function toContact(way) {
  run(false);
  let frame = state.frame;
  const touches = (place) => place >= 0 && place < model.frames && strongest[place] > 0;
  while (touches(frame)) frame += way; // out of this one
  while (frame >= 0 && frame < model.frames && !touches(frame)) frame += way;
  if (!touches(frame)) return;
  let best = frame;
  for (let place = frame; touches(place); place += way) if (strongest[place] > strongest[best]) best = place;
  show(best);
}

async function start() {
  element("facts").textContent = model.facts;
  const floors = buildings.reduce((sum, each) => sum + each.floors, 0);
  displacement = summed(await unpacked(model.displacement), floors);
  force = await unpacked(model.force);
  strongest = Array.from({ length: model.frames }, (_, frame) =>
    Math.max(0, ...force.subarray(frame * points.length, (frame + 1) * points.length)) * model.strongest);
  scale = roundScale();
  document.querySelector("main").hidden = false;
  layOut();
  show(0);
  element("play").addEventListener("click", () => run(!state.runs));
  element("speed").addEventListener("change", () => show(state.frame));
  element("at").addEventListener("input", (event) => { run(false); show(Number(event.target.value)); });
  element("before").addEventListener("click", () => toContact(-1));
  element("next").addEventListener("click", () => toContact(1));
  document.body.dataset.ready = "yes";
}

start().catch((error) => {
  element("trouble").hidden = false;
  element("trouble").textContent = `The page cannot show its run: ${error.message}. It needs a browser of 2023 or later.`;
});
