// Steps of a run: what the page shows at each, and how one goes from step to step.

const byId = id => document.getElementById(id);
const run = JSON.parse(byId("data").textContent);
const steps = [];
// Each step holds what it changes; the rest is as before.
for (const change of run.steps) steps.push({ ...steps[steps.length - 1], ...change });

let place = 0, chosenRow = 0, timer = null;
const picture = new Picture(byId("picture"), run.instance, say);
const chart = new BoundChart(byId("chart"), steps, go);
const tree = Object.keys(run.tree).length > 1 ? new Tree(byId("tree"), run.tree, say) : null;
const shows = field => steps.some(step => step[field]);

function say(text, redraw) {
  byId("readout").textContent = text;
  if (redraw) drawPicture();
}

// The rows of a step, those that the point breaks most first.
function rowsOf(step) {
  const short = row => (row.left === null ? 0 : row.right - row.left);
  return [...step.rows].sort((one, two) => short(two) - short(one));
}

function drawPicture() {
  // The run ends with its best plan, where the last step has no legs of its own to show.
  const ends = place === steps.length - 1 && !(steps[place].legs || []).length;
  const options = { numbers: byId("numbers").checked, incumbent: byId("incumbent").checked || ends };
  picture.draw(steps[place], rowsOf(steps[place])[chosenRow], options);
}

function drawFigures(step) {
  const gap = step.value !== null && step.lower !== null && step.value > 0 ? Math.max(0, 100 * (step.value - step.lower) / step.value) : null;
  const unit = " " + run.unit;
  const figures = [
    ["proved bound", step.lower === null ? "–" : step.lower.toFixed(2) + unit],
    ["best plan", step.value === null ? "–" : step.value.toFixed(2) + unit],
    ["gap", gap === null ? "–" : gap.toFixed(3) + " %"],
    [run.here, Number.isFinite(step.bound) ? step.bound.toFixed(2) + unit : "–"],
  ];
  byId("figures").replaceChildren(...figures.map(([term, text]) => {
    const box = document.createElement("div");
    for (const [tag, content] of [["dt", term], ["dd", text]]) box.appendChild(document.createElement(tag)).textContent = content;
    return box;
  }));
}

// A contour of which all entry points are in a set is named once.
function namesOf(members) {
  const { names, contours, contour_of } = run.instance;
  const whole = node => members.filter(other => contour_of[other] === contour_of[node]).length === contour_of.filter(c => c === contour_of[node]).length;
  return [...new Set(members.map(node => (node < contour_of.length && whole(node) ? contours[contour_of[node]] : names[node])))].join(", ");
}

function setsOf(row) {
  return row.sets.map(([name, members]) => `${name} = {${namesOf(members)}}`).join("; ");
}

function rowItem(row, index) {
  const item = document.createElement("li"), broken = row.left !== null;
  const box = item.appendChild(document.createElement(broken ? "button" : "div"));
  const add = (tag, text) => { box.appendChild(document.createElement(tag)).textContent = text; };
  add("b", broken ? row.tag : `${row.tag} × ${row.count}`);
  add("code", row.symbols);
  add("span", row.words);
  if (!broken) { box.className = "family"; return item; }
  add("small", `here ${short(row.left)} on the left, at least ${short(row.right)} is asked for: short by ${short(row.right - row.left)}`);
  add("small", setsOf(row));
  box.setAttribute("aria-pressed", index === chosenRow);
  box.addEventListener("click", () => { chosenRow = index; drawRows(steps[place]); drawPicture(); });
  return item;
}

function drawRows(step) {
  const rows = rowsOf(step), scrolled = byId("rows").scrollTop;
  const cuts = rows.length && rows[0].left !== null;
  byId("rows-title").textContent = !rows.length ? "No new rows in this step" : cuts ? `New cuts (${rows.length}); choose one to see its set` : "Rows of the model";
  byId("rows").replaceChildren(...rows.map(rowItem));
  byId("rows").scrollTop = scrolled;
}

function draw() {
  const step = steps[place];
  byId("text").textContent = step.text;
  drawFigures(step);
  drawRows(step);
  drawPicture();
  chart.draw(place);
  if (shows("thresholds")) drawThresholds(byId("thresholds"), step, run.objective === "makespan");
  if (shows("states")) {
    drawStates(byId("states"), step.states);
    const sizes = (step.memories || []).map(members => members.length);
    const total = (step.states || []).reduce((sum, count) => sum + count, 0);
    byId("memories").textContent = sizes.length ? `${total} states in all. A contour remembers ${short(sizes.reduce((a, b) => a + b, 0) / sizes.length)} others on average, ${Math.max(...sizes)} at most.` : "";
  }
  if (tree) tree.draw(step, byId("tree-scroll"));
  byId("slider").value = place;
  byId("slider").setAttribute("aria-valuetext", `step ${place + 1} of ${steps.length}: ${step.text}`);
  byId("place").textContent = `${place + 1} / ${steps.length}`;
}

function go(index) {
  place = Math.min(steps.length - 1, Math.max(0, index));
  chosenRow = 0;
  byId("rows").scrollTop = 0;
  if (place === steps.length - 1) pause();
  draw();
}

function pause() {
  clearInterval(timer);
  timer = null;
  byId("play").textContent = "Play";
  byId("play").setAttribute("aria-label", "Play");
}

function start() {
  if (place === steps.length - 1) go(0);
  clearInterval(timer);
  timer = setInterval(() => go(place + 1), Number(byId("pace").value));
  byId("play").textContent = "Pause";
  byId("play").setAttribute("aria-label", "Pause");
}

const toggle = () => (timer === null ? start() : pause());
const MOVES = { ArrowLeft: () => go(place - 1), ArrowRight: () => go(place + 1), Home: () => go(0), End: () => go(steps.length - 1) };

function press(event) {
  const tag = event.target.tagName;
  if (event.ctrlKey || event.metaKey || event.altKey || tag === "SELECT") return;
  if (event.key === " " && tag !== "BUTTON" && event.target.type !== "checkbox") { event.preventDefault(); toggle(); }
  if (event.key in MOVES) { event.preventDefault(); pause(); MOVES[event.key](); }
}

function sample(attributes, name) {
  const svg = document.createElementNS(NS, "svg");
  svg.setAttribute("viewBox", "0 0 34 14");
  make(name || "line", { x1: 1, x2: 33, y1: 7, y2: 7, ...attributes }, svg);
  return svg;
}

function legend(id, entries) {
  byId(id).replaceChildren(...entries.map(([svg, text]) => {
    const item = document.createElement("li");
    item.append(svg, text);
    return item;
  }));
}

function legends() {
  const edge = value => sample({ class: "edge head-0", ...lineOf(value) });
  const entries = [[edge(1), "edge of value 1"], [edge(0.6), "at least 1/2"], [edge(0.25), "below 1/2"]];
  const bar = sample({ class: "edge head-1", d: "M1,7H33M17,1V13", "stroke-width": 2.5 }, "path");
  if (run.instance.homes.length > 1) entries.push([bar, "second head (bar, squares)"]);
  if (shows("visits")) {
    const hollow = sample({ class: "contour open", cx: 17, cy: 7, r: 5 }, "circle");
    entries.splice(0, 3, [edge(1), "made once"], [edge(2), "more often"], [hollow, "not visited"]);
  }
  if (shows("owners")) entries.splice(0, 3, [edge(1), "best tour known"]);
  legend("legend", entries);
  legend("chart-legend", [[sample({ class: "line-value" }), "best plan"], [sample({ class: "line-lower" }), "proved bound"], [sample({ class: "line-here" }), run.here]]);
  legend("tree-legend", Object.entries(STATES).map(([state, text]) => [sample({ class: "node " + state, d: SHAPES[state], transform: "translate(17,7) scale(.9)" }, "path"), text]));
  legend("thresholds-legend", [
    [sample({ class: "mark head-0", cx: 17, cy: 7, r: 4 }, "circle"), "T_1, at least"], [sample({ class: "mark head-1", x: 13, y: 3, width: 8, height: 8 }, "rect"), "T_2, at least"],
    [sample({ class: "head-0", "stroke-width": 2, x1: 17, x2: 17, y1: 1, y2: 13 }), "up to the best tour known; filled: both meet"],
    [sample({ class: "threshold" }), "threshold of this step"],
  ]);
}

function fit() {
  picture.fit();
  chart.fit();
  if (tree) tree.fit(byId("tree-scroll").clientWidth);
  draw();
}

run.here = shows("thresholds") ? "bound at this threshold" : shows("states") ? "bound of this pass" : "bound of this node";
byId("slider").max = steps.length - 1;
byId("thresholds-part").hidden = !shows("thresholds");
byId("states-part").hidden = !shows("states");
byId("rows-part").hidden = !steps.some(step => step.rows.length);
byId("tree-part").hidden = !tree;
byId("tree-note").textContent = run.tree_left_out ? `${run.tree_left_out} later nodes are not drawn.` : "";
byId("rule").textContent = run.stride > 1
  ? `The run had ${run.events} events; shown are the first ${run.first}, of the later ones each ${run.stride}th, all that found a better plan, and the last.`
  : `All ${run.events} events of the run are shown.`;
byId("readout").textContent = "Point at or tap an edge or a contour for its numbers" + (shows("memories") ? ", and for what a contour remembers." : ".");
byId("slider").addEventListener("input", () => { pause(); go(Number(byId("slider").value)); });
for (const [id, key] of [["first", "Home"], ["back", "ArrowLeft"], ["next", "ArrowRight"], ["last", "End"]]) {
  byId(id).addEventListener("click", () => { pause(); MOVES[key](); });
}
byId("play").addEventListener("click", toggle);
byId("pace").addEventListener("change", () => timer !== null && start());
for (const id of ["numbers", "incumbent"]) byId(id).addEventListener("change", drawPicture);
document.addEventListener("keydown", press);
window.addEventListener("resize", fit);
legends();
fit();
