// The diagrams beside the picture: bounds over steps, thresholds, states by position, the tree.

function frame(svg, height) {
  const width = svg.clientWidth || 360;
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.style.height = height + "px";
  svg.replaceChildren();
  return width;
}

function scaleOf(low, high, from, to) {
  const span = high - low || 1;
  return value => from + (value - low) / span * (to - from);
}

function axis(svg, y, values, width) {
  for (const value of values) {
    make("line", { class: "axis", x1: 46, x2: width - 6, y1: y(value), y2: y(value) }, svg);
    // Four digits and more have no room for decimals.
    const digits = Math.abs(value) < 999.95 ? 1 : 0;
    make("text", { x: 42, y: y(value) + 4, "text-anchor": "end" }, svg, String(Number(value.toFixed(digits))));
  }
}

class BoundChart {
  constructor(svg, steps, go) {
    Object.assign(this, { svg, steps });
    svg.style.cursor = "pointer";
    svg.addEventListener("click", event => {
      const box = svg.getBoundingClientRect();
      const share = (event.clientX - box.left - 46) / (box.width - 56);
      go(Math.round(share * (steps.length - 1)));
    });
  }

  fit() {
    const { svg, steps } = this, height = 170, width = frame(svg, height);
    const figures = steps.flatMap(step => [step.value, step.lower]).filter(Number.isFinite);
    if (!figures.length) figures.push(0, 1);
    const low = Math.min(...figures), high = Math.max(...figures), room = 0.08 * (high - low || 1);
    const y = scaleOf(low - room, high + room, height - 22, 8);
    this.x = scaleOf(0, Math.max(1, steps.length - 1), 46, width - 10);
    axis(svg, y, [low, (low + high) / 2, high], width);
    make("text", { x: width - 10, y: height - 6, "text-anchor": "end" }, svg, `step ${steps.length}`);
    const clip = value => Math.min(height - 20, Math.max(6, y(value)));
    for (const [field, name] of [["bound", "here"], ["value", "value"], ["lower", "lower"]]) {
      make("path", { class: "line-" + name, d: this.path(field, clip, field !== "bound") }, svg);
    }
    this.cursor = make("line", { class: "cursor", y1: 4, y2: height - 18 }, svg);
  }

  path(field, y, stairs) {
    let text = "", last = null;
    this.steps.forEach((step, index) => {
      const value = step[field];
      if (!Number.isFinite(value)) { last = null; return; }
      const x = this.x(index).toFixed(1), at = y(value).toFixed(1);
      text += last === null ? `M${x},${at}` : stairs ? `H${x}V${at}` : `L${x},${at}`;
      last = at;
    });
    return text || "M0,0";
  }

  draw(index) {
    this.cursor.setAttribute("x1", this.x(index));
    this.cursor.setAttribute("x2", this.x(index));
  }
}

// Both heads' bounds at every threshold: T_1 grows, T_2 falls, the best makespan lies where they cross.
function drawThresholds(svg, step, makespan) {
  const height = 210, width = frame(svg, height), rows = step.thresholds;
  if (!rows || !rows.length) return;
  const figures = rows.flatMap(row => row.slice(2)).filter(Number.isFinite);
  const low = 0, high = Math.max(...figures);
  const y = scaleOf(low, high, height - 24, 8);
  const x = scaleOf(rows[0][0], rows[rows.length - 1][0], 54, width - 12);
  axis(svg, y, [low, high / 2, high], width);
  make("text", { x: 54, y: height - 6 }, svg, `x = ${Math.round(rows[0][0])} mm`);
  make("text", { x: width - 10, y: height - 6, "text-anchor": "end" }, svg, `${Math.round(rows[rows.length - 1][0])} mm`);
  const chosen = step.threshold;
  if (Number.isInteger(chosen)) make("line", { class: "threshold", x1: x(rows[chosen][0]), x2: x(rows[chosen][0]), y1: 4, y2: height - 22 }, svg);
  if (makespan) {
    for (const field of ["value", "lower"]) {
      if (step[field] !== null) make("line", { class: "line-" + field, x1: 46, x2: width - 6, y1: y(step[field]), y2: y(step[field]) }, svg);
    }
  }
  rows.forEach(row => [0, 1].forEach(head => {
    const [lower, upper] = row.slice(2 + 2 * head, 4 + 2 * head), at = x(row[0]) + (head ? 1.5 : -1.5);
    if (upper !== null) make("line", { class: `head-${head}`, "stroke-width": 2, x1: at, x2: at, y1: y(lower), y2: y(upper) }, svg);
    const r = upper === null ? 2 : 3.4, known = upper !== null && upper - lower < 1e-3 * (1 + upper);
    const fill = known ? `fill:var(--head-${head})` : "";
    const mark = head
      ? make("rect", { x: at - r, y: y(lower) - r, width: 2 * r, height: 2 * r }, svg)
      : make("circle", { cx: at, cy: y(lower), r }, svg);
    mark.setAttribute("class", `mark head-${head}`);
    mark.setAttribute("style", fill);
    make("title", {}, mark, `${row[1]} contours left: T_${head + 1} ≥ ${short(lower)} s` + (upper === null ? "" : `, ≤ ${short(upper)} s`));
  }));
}

function drawStates(svg, states) {
  const height = 130, width = frame(svg, height);
  if (!states || !states.length) return;
  const most = Math.max(10, ...states), y = scaleOf(0, Math.log10(most + 1), height - 22, 10);
  const wide = (width - 56) / states.length;
  for (let power = 1; power <= most; power *= 10) {
    const at = y(Math.log10(power + 1));
    make("line", { class: "axis", x1: 46, x2: width - 6, y1: at, y2: at }, svg);
    make("text", { x: 42, y: at + 4, "text-anchor": "end" }, svg, power >= 1000 ? power / 1000 + "k" : power);
  }
  states.forEach((count, position) => {
    const at = y(Math.log10(count + 1));
    const bar = make("rect", { class: "bar", x: 48 + position * wide, width: Math.max(1, wide - 1.5), y: at, height: height - 22 - at }, svg);
    make("title", {}, bar, `position ${position + 1}: ${count} states`);
  });
  make("text", { x: 48, y: height - 6 }, svg, "position 1");
  make("text", { x: width - 10, y: height - 6, "text-anchor": "end" }, svg, states.length);
}

const SHAPES = {
  open: "M-5,0a5,5 0 1,0 10,0a5,5 0 1,0 -10,0",
  divided: "M-5,0a5,5 0 1,0 10,0a5,5 0 1,0 -10,0",
  bound: "M-6,-2.5h12v5h-12z",
  infeasible: "M-5,-5L5,5M5,-5L-5,5",
  solution: "M0,-7L6,0L0,7L-6,0Z",
};
const STATES = { open: "open", divided: "divided in two", bound: "closed by its bound", infeasible: "nothing allowed", solution: "closed by a solution" };

const LEVEL = 26; // pixels from a node to its children

class Tree {
  constructor(svg, nodes, say) {
    Object.assign(this, { svg, nodes, marks: new Map() });
    this.place();
    for (const [number, node] of Object.entries(nodes)) {
      if (node.parent !== null) node.line = make("line", { class: "branch" }, svg);
    }
    for (const [number, node] of Object.entries(nodes)) {
      node.mark = make("path", {}, svg);
      node.title = make("title", {}, node.mark);
      node.mark.addEventListener("click", () => say(node.title.textContent));
    }
    this.ring = make("circle", { class: "ring", r: 10 }, svg);
  }

  // Leaves stand side by side, others over the middle of their children.
  place() {
    const children = new Map(), roots = [];
    for (const [number, node] of Object.entries(this.nodes)) {
      if (node.parent === null || !(node.parent in this.nodes)) roots.push(number);
      else children.set(String(node.parent), [...(children.get(String(node.parent)) || []), number]);
    }
    let leaves = 0, deepest = 0;
    const visit = (number, depth) => {
      const below = children.get(number) || [], node = this.nodes[number];
      below.forEach(child => visit(child, depth + 1));
      node.depth = depth;
      deepest = Math.max(deepest, depth);
      node.at = below.length ? below.reduce((sum, child) => sum + this.nodes[child].at, 0) / below.length : leaves++;
    };
    roots.forEach(root => visit(root, 0));
    this.leaves = leaves;
    this.deepest = deepest;
  }

  fit(room) {
    const gap = Math.max(18, (room - 30) / this.leaves), width = 30 + gap * this.leaves, height = 40 + LEVEL * this.deepest;
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.svg.style.width = width + "px";
    this.svg.style.height = height + "px";
    for (const node of Object.values(this.nodes)) Object.assign(node, { px: 15 + gap * (node.at + 0.5), py: 18 + LEVEL * node.depth });
    for (const node of Object.values(this.nodes)) {
      node.mark.setAttribute("transform", `translate(${node.px},${node.py})`);
      const above = this.nodes[node.parent];
      if (node.line && above) for (const [key, value] of Object.entries({ x1: above.px, y1: above.py, x2: node.px, y2: node.py })) node.line.setAttribute(key, value);
    }
  }

  draw(step, scroll) {
    for (const [number, node] of Object.entries(this.nodes)) {
      const seen = node.history.filter(entry => entry[0] <= step.at).pop();
      const state = seen ? seen[1] : "absent";
      node.mark.setAttribute("class", "node " + state);
      node.mark.setAttribute("d", SHAPES[state] || "M0,0");
      if (node.line) node.line.setAttribute("class", seen ? "branch" : "branch absent");
      node.title.textContent = seen ? `node ${number}${node.decision ? ", " + node.decision : ""}: ${STATES[state]}, bound ${short(seen[2])}` : "";
    }
    const current = this.nodes[step.branch];
    this.ring.setAttribute("visibility", current ? "visible" : "hidden");
    if (!current) return;
    this.ring.setAttribute("cx", current.px);
    this.ring.setAttribute("cy", current.py);
    scroll.scrollLeft = current.px - scroll.clientWidth / 2;
    scroll.scrollTop = current.py - scroll.clientHeight / 2;
  }
}
