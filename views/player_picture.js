"use strict";
// The picture of a step from above: legs by value, sets of the chosen row, contours by head or by visits.

const NS = "http://www.w3.org/2000/svg";

function make(name, attributes, parent, text) {
  const element = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  if (parent) parent.appendChild(element);
  return element;
}

function short(number) {
  return number === null || number === undefined ? "–" : String(Math.round(number * 1000) / 1000);
}

// Width, dash and the words of a leg's value: no colour needed to tell them apart.
function lineOf(value) {
  const dash = value > 0.999 ? "" : value >= 0.5 ? "9 4" : "2 4";
  return { "stroke-width": value > 1.001 ? 5 : 1.2 + 2.3 * Math.min(1, value), "stroke-dasharray": dash };
}

class Picture {
  constructor(svg, part, say) {
    Object.assign(this, { svg, part, say, chosenContour: null });
    this.layers = {};
    const defs = make("defs", {}, svg);
    for (const [id, turn] of [["h", 45], ["t", -45]]) {
      const pattern = make("pattern", { id: "hatch-" + id, width: 8, height: 8, patternUnits: "userSpaceOnUse", patternTransform: `rotate(${turn})` }, defs);
      make("line", { x1: 0, y1: 0, x2: 0, y2: 8, stroke: id === "h" ? "var(--head-2)" : "var(--head-4)", "stroke-width": 1.6, opacity: 0.6 }, pattern);
    }
    for (const name of ["outlines", "best", "sets", "threshold", "legs", "contours", "labels"]) this.layers[name] = make("g", {}, svg);
  }

  // Pixels are units, so that lines and letters keep their size on any screen.
  fit() {
    const points = [...this.part.nodes, ...this.part.outlines.flatMap(outline => outline || [])];
    const xs = points.map(p => p[0]), ys = points.map(p => p[1]);
    const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    const width = this.svg.clientWidth || 600, margin = 30;
    const most = Math.min(0.68 * window.innerHeight, 1.2 * width);
    const wide = Math.max(right - left, 1e-9), tall = Math.max(high - low, 1e-9);
    const scale = Math.min((width - 2 * margin) / wide, (most - 2 * margin) / tall);
    const height = Math.max(160, scale * tall + 2 * margin);
    this.x = x => width / 2 + (x - (left + right) / 2) * scale;
    this.y = y => height / 2 - (y - (low + high) / 2) * scale;
    this.height = height;
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.svg.style.height = height + "px";
  }

  at(node) {
    const [x, y] = this.part.nodes[node];
    return [this.x(x), this.y(y)];
  }

  draw(step, row, options) {
    for (const layer of Object.values(this.layers)) layer.replaceChildren();
    for (const outline of this.part.outlines) {
      if (outline) make("polygon", { class: "outline", points: outline.map(p => [this.x(p[0]), this.y(p[1])].join()).join(" ") }, this.layers.outlines);
    }
    if (options.incumbent) this.drawBest(step.best || []);
    if (row && row.left !== null) this.drawSets(row);
    if (this.chosenContour !== null && step.memories) this.drawMemory(step.memories[this.chosenContour]);
    if (step.thresholds && step.threshold !== null && step.threshold !== undefined) this.drawThreshold(step.thresholds[step.threshold][0]);
    for (const leg of step.legs || []) this.drawLeg(leg, options.numbers);
    this.drawContours(step, options.numbers);
  }

  drawBest(tours) {
    for (const tour of tours) {
      if (tour.length > 1) make("polygon", { class: "best", points: tour.map(node => this.at(node).join()).join(" ") }, this.layers.best);
    }
  }

  drawLeg([start, end, value, head], numbered) {
    const [x1, y1] = this.at(start), [x2, y2] = this.at(end);
    const layer = this.layers.legs, ends = { x1, y1, x2, y2 };
    make("line", { class: `edge head-${head}`, ...ends, ...lineOf(value) }, layer);
    const [mx, my] = [(x1 + x2) / 2, (y1 + y2) / 2], length = Math.hypot(x2 - x1, y2 - y1) || 1;
    if (head === 1) { // a bar across marks the second head without colour
      const [dx, dy] = [5 * (y2 - y1) / length, -5 * (x2 - x1) / length];
      make("line", { class: "edge head-1", x1: mx - dx, y1: my - dy, x2: mx + dx, y2: my + dy, "stroke-width": 2 }, layer);
    }
    const names = this.part.names, heads = this.part.homes.length > 1 ? ` of head ${head + 1}` : "";
    const text = `edge ${names[start]} – ${names[end]}${heads}: ${short(value)}`;
    const hit = make("line", { class: "hit", ...ends }, layer);
    make("title", {}, hit, text);
    hit.addEventListener("pointerenter", () => this.say(text));
    hit.addEventListener("click", () => this.say(text));
    if (numbered && value < 0.999) make("text", { class: "edge-number", x: mx + 3, y: my - 3 }, this.layers.labels, short(value));
  }

  drawSets(row) {
    for (const [name, members] of row.sets) {
      const kind = name === "S" || name === "H" ? "h" : name.startsWith("T") ? "t" : "m";
      this.drawBlob(members, kind, name);
      if (kind === "h") for (const node of members) {
        const [cx, cy] = this.at(node);
        make("circle", { class: "member", cx, cy, r: 8 }, this.layers.sets);
      }
    }
  }

  drawMemory(contours) {
    const { contour_of } = this.part;
    const nodes = contours.map(contour => contour_of.indexOf(contour));
    const own = contour_of.indexOf(this.chosenContour);
    for (const node of nodes) {
      const [x1, y1] = this.at(own), [cx, cy] = this.at(node);
      make("line", { class: "blob m", x1, y1, x2: cx, y2: cy }, this.layers.sets);
      make("rect", { class: "member", x: cx - 8, y: cy - 8, width: 16, height: 16 }, this.layers.sets);
    }
  }

  drawBlob(members, kind, name) {
    const reach = kind === "t" ? 10 : kind === "h" ? 15 : 12, ring = [];
    for (const node of members) {
      const [x, y] = this.at(node);
      for (let i = 0; i < 12; i++) ring.push([x + reach * Math.cos(i * Math.PI / 6), y + reach * Math.sin(i * Math.PI / 6)]);
    }
    const around = hull(ring);
    make("polygon", { class: `blob ${kind}`, points: around.map(p => p.join()).join(" ") }, this.layers.sets);
    const top = around.reduce((best, p) => (p[1] < best[1] ? p : best));
    make("text", { class: "blob-name", x: top[0], y: Math.max(14, top[1] - 3), "text-anchor": "middle" }, this.layers.labels, name);
  }

  drawThreshold(x) {
    make("line", { class: "threshold", x1: this.x(x), x2: this.x(x), y1: 0, y2: this.height }, this.layers.threshold);
  }

  drawContours(step, numbered) {
    const { contour_of, homes, contours } = this.part, layer = this.layers.contours;
    const several = contour_of.length > contours.length;
    contour_of.forEach((contour, node) => {
      const [x, y] = this.at(node), owner = step.owners ? step.owners[contour] : null;
      const visits = step.visits && step.visits.length ? step.visits[contour] : 1;
      const kind = owner === 0 ? " left" : owner === 1 ? " right" : owner === -1 || visits === 0 ? " open" : "";
      const r = several ? 3 : 4.5;
      const shape = owner === 1
        ? make("rect", { class: "contour" + kind, x: x - r, y: y - r, width: 2 * r, height: 2 * r }, layer)
        : make("circle", { class: "contour" + kind, cx: x, cy: y, r }, layer);
      const text = this.describe(contour, step, owner, visits);
      make("title", {}, shape, text);
      shape.addEventListener("pointerenter", () => this.say(text));
      shape.addEventListener("click", () => { this.chosenContour = contour; this.say(text, true); });
      if (node > 0 && contour_of[node - 1] === contour) return;
      if (visits > 1) make("text", { class: "edge-number", x: x + 6, y: y - 5 }, this.layers.labels, visits + "×");
      else if (numbered) make("text", { class: "edge-number", x: x + 6, y: y + 4 }, this.layers.labels, step.prices ? short(step.prices[contour]) : contours[contour]);
    });
    homes.forEach((node, head) => {
      if (node === null) return;
      const [x, y] = this.at(node);
      make("path", { class: "home", d: `M${x - 8},${y + 7} V${y - 1} L${x},${y - 9} L${x + 8},${y - 1} V${y + 7} Z` }, layer);
      if (homes.length > 1) make("text", { x: x - 3.5, y: y + 5 }, this.layers.labels, head + 1);
    });
  }

  describe(contour, step, owner, visits) {
    const parts = [`contour ${this.part.contours[contour]}`];
    if (owner !== null) parts.push(owner < 0 ? "head not decided" : `head ${owner + 1}`);
    if (step.prices) {
      const members = step.memories[contour].map(other => this.part.contours[other]);
      parts.push(`visited ${visits}×`, `price ${short(step.prices[contour])} mm`, `remembers ${members.join(", ") || "nothing"}`);
    }
    return parts.join(", ");
  }
}

// Convex hull by Andrew's monotone chain.
function hull(points) {
  const sorted = [...points].sort((p, q) => p[0] - q[0] || p[1] - q[1]);
  const turn = (o, p, q) => (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0]);
  const half = list => {
    const chain = [];
    for (const p of list) {
      while (chain.length > 1 && turn(chain[chain.length - 2], chain[chain.length - 1], p) <= 0) chain.pop();
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}
