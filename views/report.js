// What the report adds to its plain tables: rows in order of a column, filters, and two plans side by side.

const byId = id => document.getElementById(id);
const make = (tag, parent, text = "", attributes = {}) => {
  const element = parent.appendChild(document.createElement(tag));
  element.textContent = text;
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
};
const table = byId("parts");
const rows = [...table.querySelectorAll("tr[data-method]:not(.note)")];

// Sorting. A heading's button sorts upwards, then downwards, then as it was.

function key(row, column, isText) {
  const text = row.cells[column].textContent;
  if (isText) return text;
  const found = text.match(/-?\d+(\.\d+)?|inf/);
  return found ? (found[0] === "inf" ? Infinity : Number(found[0])) : null;
}

function compareKeys(one, two) {
  return typeof one === "string" ? one.localeCompare(two, undefined, { numeric: true }) : one - two;
}

// Rows with their notes below them, and the group they stand in at first.
function entriesOf(element) {
  const entries = [];
  for (const body of element.tBodies) {
    for (const row of body.rows) {
      if (row.classList.contains("note")) entries[entries.length - 1].lines.push(row);
      else entries.push({ lines: [row], body });
    }
  }
  return entries;
}

function sortable(element) {
  const entries = entriesOf(element), sorted = document.createElement("tbody");
  const headings = [...element.tHead.rows[0].cells];

  function sort(heading, order) {
    for (const other of headings) other.removeAttribute("aria-sort");
    if (order === "none") {
      sorted.remove();
      for (const { lines, body } of entries) body.append(...lines);
      return;
    }
    heading.setAttribute("aria-sort", order);
    const isText = heading.classList.contains("text"), sign = order === "ascending" ? 1 : -1;
    const keyed = entries.map(entry => [key(entry.lines[0], heading.cellIndex, isText), entry]);
    // What has no figure stands last either way.
    keyed.sort(([one], [two]) => (one === null || two === null ? (one === null) - (two === null) : sign * compareKeys(one, two)));
    element.append(sorted);
    for (const [, entry] of keyed) sorted.append(...entry.lines);
  }

  const next = { null: "ascending", ascending: "descending", descending: "none" };
  for (const heading of headings) {
    const text = heading.textContent;
    heading.textContent = "";
    const button = make("button", heading, text, { type: "button", title: `Sort by ${text}` });
    button.addEventListener("click", () => sort(heading, next[heading.getAttribute("aria-sort")]));
  }
}

// Filters, of rows and of the drawings below.

const distinct = field => [...new Set(rows.map(row => row.dataset[field]))];

function wanted({ dataset }) {
  const is = field => !byId(field).value || byId(field).value === dataset[field];
  return is("part") && is("asked") && [...byId("methods").querySelectorAll("input")].some(box => box.checked && box.value === dataset.method);
}

function filter() {
  for (const element of document.querySelectorAll("#parts tr[data-method], .plan[data-method]")) element.hidden = !wanted(element);
  // A drawing that is asked for does not stay behind a click.
  const count = rows.filter(row => !row.hidden).length, all = count === rows.length;
  for (const details of document.querySelectorAll(".plans details")) {
    details.hidden = !details.querySelector(".plan:not([hidden])");
    details.open = !all && !details.hidden;
  }
  byId("shown").textContent = all ? `all ${count} rows` : `${count} of ${rows.length} rows`;
}

function setUpFilters() {
  for (const [field, all] of [["part", "all parts"], ["asked", "all that is asked"]]) {
    const values = distinct(field);
    make("option", byId(field), all, { value: "" });
    for (const value of values) make("option", byId(field), value, { value });
    byId(field).closest("label").hidden = values.length < 2;
  }
  for (const method of distinct("method")) {
    const label = make("label", byId("methods"));
    make("input", label, "", { type: "checkbox", value: method, checked: "" });
    label.append(` ${method}`);
  }
  byId("filters").addEventListener("change", filter);
  byId("filters").addEventListener("submit", event => event.preventDefault());
  // The fields change after this event.
  byId("filters").addEventListener("reset", () => setTimeout(filter));
  byId("filters").hidden = false;
  filter();
}

// Two plans side by side, chosen by ticks in the table or by name.

const SLOTS = ["left", "right"];
const titleOf = id => byId(id).querySelector("figcaption").textContent;

function difference(left, right) {
  const [one, two] = [left, right].map(id => byId(id).dataset);
  if (left === right || one.part !== two.part || one.asked !== two.asked || !one.value || !two.value) return "";
  // Where zero deg C lies is arbitrary: of temperatures a share says nothing.
  if (one.unit === "deg C") {
    const degrees = two.value - one.value;
    if (Math.abs(degrees) < 0.005) return "Both have the same value.";
    return `The value on the right is ${Math.abs(degrees).toFixed(2)} deg C ${degrees > 0 ? "higher" : "lower"} than that on the left.`;
  }
  const share = 100 * (two.value - one.value) / one.value;
  if (!Number.isFinite(share) || Math.abs(share) < 0.0005) return "Both have the same value.";
  return `The value on the right is ${Math.abs(share).toFixed(3)} % ${share > 0 ? "larger" : "smaller"} than that on the left.`;
}

// A new plan takes the free place; without one, the plan on the right makes room on the left.
const withNew = ([left, right], id) => (left ? [right || left, id] : [id, right]);

function compare(chosen) {
  SLOTS.forEach((slot, place) => {
    byId(slot).value = chosen[place];
    byId(`${slot}-plan`).replaceChildren();
    if (!chosen[place]) return;
    const copy = byId(`${slot}-plan`).appendChild(byId(chosen[place]).cloneNode(true));
    copy.removeAttribute("id");
    copy.removeAttribute("data-method");
    copy.hidden = false;
  });
  for (const row of rows) {
    const box = row.querySelector("input");
    if (box) box.checked = chosen.includes(row.dataset.plan);
  }
  byId("difference").textContent = chosen.includes("") ? "" : difference(...chosen);
}

function setUpComparison() {
  const drawn = rows.filter(row => row.dataset.plan);
  if (drawn.length < 2) return;
  let chosen = [drawn[0].dataset.plan, drawn[1].dataset.plan];
  const choose = ids => compare(chosen = ids);
  make("th", table.tHead.rows[0], "compare", { class: "tick" });
  table.tHead.rows[0].prepend(table.tHead.rows[0].lastChild);
  for (const row of table.querySelectorAll("tr[data-method]")) {
    if (row.classList.contains("note")) { row.cells[0].colSpan += 1; continue; }
    const cell = make("td", row, "", { class: "tick" }), id = row.dataset.plan;
    row.prepend(cell);
    if (!id) continue;
    const box = make("input", cell, "", { type: "checkbox", "aria-label": `Show ${titleOf(id)} side by side` });
    box.addEventListener("change", () => choose(box.checked ? withNew(chosen, id) : chosen.map(other => (other === id ? "" : other))));
  }
  SLOTS.forEach((slot, place) => {
    make("option", byId(slot), "none", { value: "" });
    for (const row of drawn) make("option", byId(slot), titleOf(row.dataset.plan), { value: row.dataset.plan });
    byId(slot).addEventListener("change", () => choose(chosen.map((id, other) => (other === place ? byId(slot).value : id))));
  });
  byId("compare").hidden = false;
  compare(chosen);
}

for (const element of document.querySelectorAll("table")) sortable(element);
setUpFilters();
setUpComparison();
