// The map on #map: regions and tasks of one slice, of which one task is chosen. Needs task_panel.js.

const data = JSON.parse(element("data").textContent);
const map = element("map"), sliders = [...document.querySelectorAll("#sliders input")];
const NEAR = 24; // px from a task that still point at it
let slice = 0, chosen = 0, marks = new Map(); // marks: SVG elements by task

const places = () => sliders.map((slider) => Number(slider.value));
const shownTasks = () => data.tasks.map((task, index) => [task, index]).filter(([task]) => task.slice === slice);

const described = (task) => `${task.title}: ${task.found ? task.gait : "no gait found"}`;

function svg(parent, name, attributes, text = "") {
  const made = document.createElementNS(map.namespaceURI, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  return parent.appendChild(made);
}

// --- where things are ----------------------------------------------------------------------------------------------
function frameOf() { // px: the box of the lowest to the highest task, with room for half a mark around it
  const width = map.clientWidth, strip = data.axes.length === 1;
  const height = strip ? 120 : Math.min(Math.max(0.78 * width, 260), 480);
  return { width, height, left: strip ? 24 : 70, right: width - 16, top: 16, bottom: height - 58 };
}

function placeOf(task) { // px of its middle
  const { left, right, top, bottom } = frameOf();
  const share = (axis, value) => (axis ? (value - axis.low) / (axis.high - axis.low || 1) : 0.5);
  const [x, y] = data.axes;
  return [left + share(x, task.x) * (right - left), bottom - share(y, task.y) * (bottom - top)];
}

function ticks({ low, high }, most) {
  const rough = (high - low) / most || 1, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough * (1 - 1e-9));
  const first = Math.ceil(low / step - 1e-9), count = Math.floor(high / step + 1e-9) - first + 1;
  return Array.from({ length: count }, (_, i) => Number(((first + i) * step).toPrecision(6)));
}

// --- drawing -------------------------------------------------------------------------------------------------------
function drawMap() {
  const { width, height, left, right, top, bottom } = frameOf();
  const held = marks.get(chosen) === document.activeElement;
  map.replaceChildren();
  map.setAttribute("viewBox", `0 0 ${width} ${height}`);
  map.setAttribute("height", height);
  const { regions, resolution } = data.slices[slice];
  const box = `translate(${left} ${bottom}) scale(${(right - left) / resolution} ${(top - bottom) / resolution})`;
  const group = svg(map, "g", { transform: box, "shape-rendering": "crispEdges" });
  for (const [colour, path] of regions) svg(group, "path", { d: path, fill: colour });
  drawAxes();
  marks = new Map(shownTasks().map(([task, index]) => [index, drawMark(task, index)]));
  markChosen();
  if (held) marks.get(chosen)?.focus({ preventScroll: true });
}

function drawAxes() {
  const { width, height, left, right, top, bottom } = frameOf(), [x, y] = data.axes;
  const low = bottom + 14;
  svg(map, "path", { d: `M${left - 10} ${low}H${right + 8}`, class: "axis" });
  for (const value of ticks(x, Math.max((right - left) / 60, 2))) {
    const [at] = placeOf({ x: value, y: 0 });
    svg(map, "path", { d: `M${at} ${low}v5`, class: "axis" });
    svg(map, "text", { x: at, y: low + 19, "text-anchor": "middle" }, value);
  }
  svg(map, "text", { x: (left + right) / 2, y: height - 6, "text-anchor": "middle" }, x.label);
  if (!y) return;
  svg(map, "path", { d: `M${left - 14} ${bottom + 10}V${top - 8}`, class: "axis" });
  for (const value of ticks(y, Math.max((bottom - top) / 40, 2))) {
    const at = placeOf({ x: 0, y: value })[1];
    svg(map, "path", { d: `M${left - 14} ${at}h-5`, class: "axis" });
    svg(map, "text", { x: left - 22, y: at + 4, "text-anchor": "end" }, value);
  }
  svg(map, "text", { transform: `translate(13 ${(top + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, y.label);
}

function drawMark(task, index) {
  const [x, y] = placeOf(task);
  const mark = svg(map, "g", { class: "task", role: "button", tabindex: -1, transform: `translate(${x} ${y})` });
  mark.setAttribute("aria-label", described(task));
  mark.dataset.task = index;
  svg(mark, "circle", { r: 12, class: "halo" });
  if (task.tied && !task.held_out) svg(mark, "circle", { r: 9.5, class: "tied" });
  const fill = task.between ? "#fff" : task.colour, stroke = task.between ? task.colour : "#222";
  const [size, thickness] = task.between ? [4, 2] : [5, 1];
  const diamond = `M0-${size}L${size} 0L0 ${size}L-${size} 0z`;
  if (!task.found) svg(mark, "path", { d: "M-5-5L5 5M-5 5L5-5", stroke: "#222", "stroke-width": 2 });
  else if (!task.held_out) svg(mark, "circle", { r: 6, fill, stroke });
  else svg(mark, "path", { d: diamond, fill, stroke, "stroke-width": thickness });
  return mark;
}

function markChosen() {
  for (const [index, mark] of marks) {
    mark.setAttribute("tabindex", index === chosen ? 0 : -1);
    mark.setAttribute("aria-pressed", index === chosen);
    mark.classList.toggle("chosen", index === chosen);
  }
}

function drawLegend() {
  for (const { name, colour, tasks } of data.gaits) {
    const item = element("legend").appendChild(document.createElement("li"));
    const swatch = item.appendChild(document.createElement("i"));
    swatch.style.background = colour;
    item.append(`${name} (${tasks})`);
  }
}

// --- choosing ------------------------------------------------------------------------------------------------------
function choose(index) {
  chosen = index;
  markChosen();
  showTask(data.tasks[index], data.robot);
  point(index);
}

function point(index) {
  element("pointed").textContent = described(data.tasks[index]);
}

function nearest([x, y], others = () => 0, most = Infinity) { // the shown task nearest to a place in px, or null
  let [best, least] = [null, most];
  for (const [task, index] of shownTasks()) {
    const [tx, ty] = placeOf(task), away = Math.hypot(tx - x, ty - y) + others(tx - x, ty - y);
    if (away < least) [best, least] = [index, away];
  }
  return best;
}

function pointedAt(event) {
  const box = map.getBoundingClientRect();
  return nearest([event.clientX - box.left, event.clientY - box.top], () => 0, NEAR);
}

function slide() {
  const wanted = places().join(), found = data.slices.findIndex((each) => each.place.join() === wanted);
  sliders.forEach((slider, axis) => {
    const text = data.sliders[axis].values[slider.value];
    slider.nextElementSibling.textContent = text;
    slider.setAttribute("aria-valuetext", text);
  });
  slice = found;
  const { x, y } = data.tasks[chosen], index = nearest(placeOf({ x, y }));
  drawMap();
  if (index === null) element("pointed").textContent = "No task in this slice.";
  else choose(index);
}

map.addEventListener("click", (event) => {
  const mark = event.detail === 0 ? event.target.closest(".task") : null; // a screen reader clicks without a place
  const index = mark ? Number(mark.dataset.task) : pointedAt(event);
  if (index === null) return;
  choose(index);
  marks.get(index).focus({ preventScroll: true });
  playTask();
});
map.addEventListener("pointermove", (event) => {
  const index = pointedAt(event);
  point(index ?? chosen);
  map.classList.toggle("pointing", index !== null);
});
map.addEventListener("pointerleave", () => point(chosen));
map.addEventListener("keydown", (event) => {
  const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  if (event.key === "Enter" || event.key === " ") playTask();
  else if (way) {
    // Ahead within a right angle, and rather straight on than near.
    const index = nearest(placeOf(data.tasks[chosen]), (dx, dy) => {
      const ahead = way[0] * dx + way[1] * dy, aside = Math.abs(way[0] * dy + way[1] * dx);
      return ahead < 1 || aside > ahead ? Infinity : 2 * aside;
    });
    if (index !== null) choose(index);
    marks.get(chosen).focus();
  } else return;
  event.preventDefault();
});
for (const slider of sliders) slider.addEventListener("input", slide);
window.addEventListener("resize", drawMap);

element("explorer").hidden = false;
drawLegend();
chosen = data.start;
slide();
