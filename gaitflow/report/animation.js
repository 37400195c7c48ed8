"use strict";
// Draws the motion of #motion: the robot on #view, its gait diagram on #bars. "#t=0.3" in the address pauses at 0.3 s.

const motion = JSON.parse(document.getElementById("motion").textContent);
const element = (id) => document.getElementById(id);
const view = element("view"), bars = element("bars"), slider = element("time"), play = element("play");
const colours = motion.colours, legs = motion.legs.length, knots = motion.times.length;
const cycle = motion.times[knots - 1];
const CORNER = motion.planar ? [0, 0] : [0.45, 0.3];
const FEET_RADIUS = 5, TURN = 0.008, KEY_TURN = 0.1;

let [azimuth, elevation] = CORNER;
let time = 0, cycles = 0, playing = true, last = null;

// --- vectors -------------------------------------------------------------------------------------------------------
const add = (a, b) => a.map((x, i) => x + b[i]);
const subtract = (a, b) => a.map((x, i) => x - b[i]);
const scaled = (a, s) => a.map((x) => x * s);
const times = (matrix, v) => matrix.map((row) => row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);

function rotation([yaw, pitch, roll]) { // base to world, Rz(yaw) Ry(pitch) Rx(roll)
  const [cy, cp, cr] = [yaw, pitch, roll].map(Math.cos), [sy, sp, sr] = [yaw, pitch, roll].map(Math.sin);
  return [
    [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
    [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
    [-sp, cp * sr, cp * cr],
  ];
}

function uphill([x, y, z]) { // terrain frame to a level one
  const c = Math.cos(motion.slope), s = Math.sin(motion.slope);
  return [c * x - s * z, y, s * x + c * z];
}

function toView(v) { // x right, y up, z towards the reader
  const [ca, ce] = [azimuth, elevation].map(Math.cos), [sa, se] = [azimuth, elevation].map(Math.sin);
  return times([[ca, sa, 0], [-sa * se, ca * se, ce], [sa * ce, -ca * ce, se]], v);
}

// --- the robot at a time -------------------------------------------------------------------------------------------
function stepAt(t) {
  let step = motion.times.findIndex((knot) => knot > t) - 1;
  return step < 0 ? knots - 2 : step;
}

function phaseAt(t) {
  let end = 0;
  const phase = motion.durations.findIndex((duration) => (end += duration) > t);
  return phase < 0 ? motion.durations.length - 1 : phase;
}

function poseAt(t) {
  const step = stepAt(t), phase = phaseAt(t);
  const part = (t - motion.times[step]) / Math.max(motion.times[step + 1] - motion.times[step], 1e-12);
  const between = (values) => add(scaled(values[step], 1 - part), scaled(values[step + 1], part));
  const angles = between(motion.angles), position = between(motion.position), turn = rotation(angles);
  const toWorld = (v) => add(position, times(turn, v));
  const velocity = (motion.position[step + 1][0] - motion.position[step][0]) /
    Math.max(motion.times[step + 1] - motion.times[step], 1e-12);
  return {
    angles, position, toWorld, velocity,
    hips: motion.hips.map(toWorld),
    feet: motion.feet[step].map((foot, leg) => add(scaled(foot, 1 - part), scaled(motion.feet[step + 1][leg], part))),
    forces: motion.forces[step],
    standing: motion.rows.map((row) => row[phase] === "1"),
  };
}

// --- the view ------------------------------------------------------------------------------------------------------
function prepared(canvas, height) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth;
  const wanted = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== wanted[0] || canvas.height !== wanted[1]) [canvas.width, canvas.height] = wanted;
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return [context, width, height];
}

function drawView(pose) {
  const [context, width, height] = prepared(view, view.clientHeight);
  const reach = Math.max(...motion.body.map((corner) => Math.hypot(corner[0], corner[1]))) + 0.5 * motion.height;
  const scale = Math.min(width / (2.6 * reach), height / (2.1 * motion.height + 0.9 * reach * Math.sin(elevation)));
  const centre = [pose.position[0], 0, 0.55 * motion.height];
  const page = (point) => {
    const [x, y, z] = toView(uphill(subtract(point, centre)));
    return [width / 2 + scale * x, height / 2 - scale * y, z];
  };
  const line = (from, to, colour, thickness, dash = []) => {
    const [a, b] = [page(from), page(to)];
    context.strokeStyle = colour;
    context.lineWidth = thickness;
    context.lineCap = "round";
    context.setLineDash(dash);
    context.beginPath();
    context.moveTo(a[0], a[1]);
    context.lineTo(b[0], b[1]);
    context.stroke();
    context.setLineDash([]);
  };

  drawGround(pose, line, reach);
  const items = [];
  const depth = (...points) => points.reduce((sum, point) => sum + page(point)[2], 0) / points.length;
  pose.hips.forEach((hip, leg) => {
    items.push([depth(hip, pose.feet[leg]), () => drawLeg(context, page, line, hip, pose.feet[leg], pose.standing[leg])]);
    const foot = pose.feet[leg], below = [foot[0], foot[1], 0], boxCentre = motion.defaultFeet[leg];
    if (!motion.planar && foot[2] > 1e-3) items.push([-Infinity, () => line(foot, below, "#9a9a9a", 1, [2, 3])]);
    if (element("boxes").checked) items.push([-Infinity, () => drawBox(pose, boxCentre, line)]);
  });
  const corners = motion.body.map(pose.toWorld);
  items.push([depth(...corners), () => drawBody(context, page, corners)]);
  items.sort((a, b) => a[0] - b[0]).forEach(([, draw]) => draw());
  if (element("forces").checked) {
    pose.feet.forEach((foot, leg) => {
      const tip = add(foot, scaled(pose.forces[leg], motion.height));
      if (pose.standing[leg]) drawArrow(context, page(foot), page(tip));
    });
  }
}

function drawGround(pose, line, reach) {
  const cell = 0.25 * motion.height, far = Math.ceil((2.2 * reach) / cell), travelled = cycles * motion.advance;
  // The base of the first cycle is drawn for ever: the floor moves below it by whole cycles instead.
  const middle = Math.round((pose.position[0] + travelled) / cell) * cell - travelled;
  if (motion.planar) {
    line([middle - 4 * far * cell, 0, 0], [middle + 4 * far * cell, 0, 0], colours.ground, 1.5);
    for (let i = -4 * far; i <= 4 * far; i++) {
      const x = middle + i * cell;
      line([x, 0, 0], [x - 0.4 * cell, 0, -0.4 * cell], colours.swing, 1);
    }
    return;
  }
  for (let i = -far; i <= far; i++) {
    line([middle + i * cell, -far * cell, 0], [middle + i * cell, far * cell, 0], "#e6e6e3", 1);
    line([middle - far * cell, i * cell, 0], [middle + far * cell, i * cell, 0], "#e6e6e3", 1);
  }
}

function drawLeg(context, page, line, hip, foot, standing) {
  const colour = standing ? colours.stance : colours.swing;
  line(hip, foot, "#6b6b6b", 6);
  line(hip, foot, colour, 4);
  const [x, y] = page(foot);
  context.beginPath();
  context.arc(x, y, FEET_RADIUS, 0, 2 * Math.PI);
  context.fillStyle = colour;
  context.fill();
  context.lineWidth = 1.2;
  context.strokeStyle = "#6b6b6b";
  context.stroke();
}

const FACES = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];

function drawBody(context, page, corners) {
  const faces = FACES.map((face) => face.map((corner) => page(corners[corner])));
  faces.sort((a, b) => a.reduce((sum, p) => sum + p[2], 0) - b.reduce((sum, p) => sum + p[2], 0));
  for (const face of faces) {
    context.beginPath();
    face.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.closePath();
    context.fillStyle = "rgba(70, 70, 70, 0.62)";
    context.fill();
    context.strokeStyle = colours.body;
    context.lineWidth = 1.5;
    context.lineJoin = "round";
    context.stroke();
  }
}

function drawBox(pose, centre, line) {
  const corner = (i) => pose.toWorld(add(centre, motion.box.map((half, axis) => ((i >> axis) & 1 ? half : -half))));
  for (let i = 0; i < 8; i++) {
    for (let axis = 0; axis < 3; axis++) {
      if (!((i >> axis) & 1)) line(corner(i), corner(i | (1 << axis)), "#7a8b99", 1, [3, 3]);
    }
  }
}

function drawArrow(context, [x0, y0], [x1, y1]) {
  const length = Math.hypot(x1 - x0, y1 - y0);
  if (length < 2) return;
  const head = Math.min(9, 0.6 * length), ux = (x1 - x0) / length, uy = (y1 - y0) / length;
  context.strokeStyle = context.fillStyle = colours.force;
  context.lineWidth = 2.5;
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1 - head * ux, y1 - head * uy);
  context.stroke();
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x1 - head * ux - 0.5 * head * uy, y1 - head * uy + 0.5 * head * ux);
  context.lineTo(x1 - head * ux + 0.5 * head * uy, y1 - head * uy - 0.5 * head * ux);
  context.fill();
}

// --- the gait diagram ----------------------------------------------------------------------------------------------
const MARGIN = 44, ROW = 22;

function drawBars() {
  const [context, width, height] = prepared(bars, ROW * legs + 30);
  const toPage = (t) => MARGIN + (t / cycle) * (width - MARGIN - 12);
  context.font = "14px system-ui, 'DejaVu Sans', sans-serif";
  motion.rows.forEach((row, leg) => {
    const top = leg * ROW + 3;
    context.fillStyle = colours.pale;
    context.fillRect(toPage(0), top, toPage(cycle) - toPage(0), ROW - 7);
    context.fillStyle = colours.stance;
    let start = 0;
    motion.durations.forEach((duration, phase) => {
      if (row[phase] === "1") context.fillRect(toPage(start), top, toPage(start + duration) - toPage(start), ROW - 7);
      start += duration;
    });
    context.fillStyle = "#1f2328";
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.fillText(motion.legs[leg], MARGIN - 8, top + (ROW - 7) / 2);
  });
  context.textAlign = "center";
  context.textBaseline = "top";
  context.fillStyle = "#59636e";
  for (let i = 0; i <= 4; i++) {
    const t = (i * cycle) / 4;
    context.fillRect(toPage(t) - 0.5, legs * ROW, 1, 5);
    if (i === 4) context.textAlign = "right";
    context.fillText(`${t.toFixed(3)} s`, i === 4 ? width : toPage(t), legs * ROW + 8);
  }
  context.fillStyle = "#1f2328";
  context.fillRect(toPage(time) - 1, 0, 2, height - 26);
}

// --- time ----------------------------------------------------------------------------------------------------------
function draw() {
  const pose = poseAt(time), degrees = (angle) => `${((angle * 180) / Math.PI + 1e-9).toFixed(2)}°`;
  drawView(pose);
  drawBars();
  slider.value = String(Math.round((1000 * time) / cycle));
  slider.setAttribute("aria-valuetext", `${time.toFixed(3)} seconds`);
  const turns = motion.planar ? ["pitch (nose up)", degrees(-pose.angles[1])] :
    ["yaw, pitch, roll", pose.angles.map(degrees).join(", ")];
  const standing = motion.legs.filter((_, leg) => pose.standing[leg]).join(" ") || "none, in flight";
  element("state").textContent = `t = ${time.toFixed(3)} s · forward ${pose.velocity.toFixed(3)} m/s · ` +
    `height ${pose.position[2].toFixed(4)} m · ${turns.join(" ")} · standing: ${standing}`;
}

function frame(now) {
  if (playing && last !== null) {
    const advanced = time + (Math.min(now - last, 100) / 1000) * Number(element("rate").value);
    cycles += Math.floor(advanced / cycle);
    time = advanced % cycle;
    draw();
  }
  last = now;
  if (playing) requestAnimationFrame(frame);
}

function setPlaying(wanted) {
  playing = wanted;
  play.textContent = playing ? "Pause" : "Play";
  last = null;
  if (playing) requestAnimationFrame(frame);
}

function seek(t) {
  setPlaying(false);
  time = Math.min(Math.max(t, 0), cycle);
  draw();
}

function stepBy(direction) {
  const step = stepAt(time);
  const behind = time > motion.times[step] + 1e-9 ? step : step - 1;
  seek(motion.times[direction > 0 ? Math.min(step + 1, knots - 1) : Math.max(behind, 0)]);
}

function turnTo(newAzimuth, newElevation) {
  if (motion.planar) return;
  azimuth = newAzimuth;
  elevation = Math.min(Math.max(newElevation, -0.2), Math.PI / 2);
  draw();
}

// --- hands ---------------------------------------------------------------------------------------------------------
play.addEventListener("click", () => setPlaying(!playing));
slider.addEventListener("input", () => seek((Number(slider.value) / 1000) * cycle));
for (const id of ["forces", "boxes"]) element(id).addEventListener("change", draw);
for (const button of document.querySelectorAll("[data-view]")) {
  button.addEventListener("click", () => turnTo(...button.dataset.view.split(" ").map(Number)));
}

function dragged(canvas, moved) {
  canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); moved(event, true); });
  canvas.addEventListener("pointermove", (event) => { if (canvas.hasPointerCapture(event.pointerId)) moved(event, false); });
}
dragged(view, (event, first) => {
  if (!first) turnTo(azimuth - TURN * event.movementX, elevation + TURN * event.movementY);
});
dragged(bars, (event) => {
  seek(((event.offsetX - MARGIN) / (bars.clientWidth - MARGIN - 12)) * cycle);
});

view.addEventListener("keydown", (event) => {
  const turns = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  if (event.key === "Home") turnTo(...CORNER);
  else if (turns[event.key]) turnTo(azimuth + KEY_TURN * turns[event.key][0], elevation + KEY_TURN * turns[event.key][1]);
  else return;
  event.preventDefault();
});
document.addEventListener("keydown", (event) => {
  const typing = ["BUTTON", "SELECT", "SUMMARY"].includes(event.target.tagName) || event.target.type === "checkbox";
  if (event.key === " " && !typing) setPlaying(!playing);
  else if (event.key === ",") stepBy(-1);
  else if (event.key === ".") stepBy(1);
  else return;
  event.preventDefault();
});
window.addEventListener("resize", draw);

const asked = /^#t=([0-9.]+)$/.exec(location.hash);
draw();
if (asked) seek(Number(asked[1]));
else setPlaying(!window.matchMedia("(prefers-reduced-motion: reduce)").matches);
