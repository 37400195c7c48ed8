"use strict";
// A simulated walk on #view, its contacts on #bars. "#t=1.5" in the address pauses at 1.5 s.

const walk = JSON.parse(document.getElementById("walk").textContent);
const element = (id) => document.getElementById(id);
const view = element("view"), bars = element("bars"), colours = walk.colours;
const end = Math.max(walk.times[walk.times.length - 1], 1e-9);
const MARGIN = 44, ROW = 22, TURN = 0.008, KEY_TURN = 0.1;
let azimuth = 0.45, elevation = 0.25, time = 0, playing = true, last = null;

function momentAt(t) {
  const next = walk.times.findIndex((each) => each > t);
  return next < 0 ? walk.times.length - 1 : Math.max(next - 1, 0);
}

function drawView() {
  const [context, width, height] = prepared(view, view.clientHeight);
  const moment = momentAt(time), middle = walk.middle[moment], top = walk.height;
  const [ca, ce] = [azimuth, elevation].map(Math.cos), [sa, se] = [azimuth, elevation].map(Math.sin);
  const scale = Math.min(width / (5 * top), height / (2.3 * top));
  const page = (point) => { // x right, y up, z towards the reader
    const [x, y, z] = [point[0] - middle[0], point[1] - middle[1], point[2] - walk.ground - 0.55 * top];
    return [
      width / 2 + scale * (ca * x + sa * y),
      height / 2 - scale * (-sa * se * x + ca * se * y + ce * z),
      sa * ce * x - ca * ce * y + se * z,
    ];
  };
  const line = (from, to, colour, thickness) => {
    const [a, b] = [page(from), page(to)];
    context.strokeStyle = colour;
    context.lineWidth = thickness;
    context.lineCap = "round";
    context.beginPath();
    context.moveTo(a[0], a[1]);
    context.lineTo(b[0], b[1]);
    context.stroke();
  };
  const cell = 0.5 * top, far = 9, [gx, gy] = [0, 1].map((axis) => Math.round(middle[axis] / cell) * cell);
  for (let i = -far; i <= far; i++) {
    const [x, y, r, z] = [gx + i * cell, gy + i * cell, far * cell, walk.ground];
    line([x, gy - r, z], [x, gy + r, z], "#e6e6e3", 1);
    line([gx - r, y, z], [gx + r, y, z], "#e6e6e3", 1);
  }
  const legs = walk.legs[moment].map((points, leg) => [points, walk.forces[moment][leg]]);
  const depth = ([points]) => points.reduce((sum, point) => sum + page(point)[2], 0);
  legs.sort((a, b) => depth(a) - depth(b)).forEach(([points, force], place) => {
    if (place === Math.floor(legs.length / 2)) drawBody(line, walk.body[moment]);
    const carries = force.some((x) => x !== 0), colour = carries ? colours.stance : colours.swing;
    for (const [thickness, shade] of [[7, "#6b6b6b"], [5, colour]]) {
      for (let i = 1; i < points.length; i++) line(points[i - 1], points[i], shade, thickness);
    }
    const foot = points[points.length - 1], [x, y] = page(foot);
    context.fillStyle = colour;
    context.beginPath();
    context.arc(x, y, 6, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
    const tip = foot.map((value, axis) => value + force[axis] * top);
    if (carries) drawArrow(context, page(foot), page(tip), colours.force);
  });
}

function drawBody(line, corners) {
  for (const [a, b] of walk.edges) line(corners[a], corners[b], colours.body, 2);
}

function drawBars() {
  const [context, width, height] = prepared(bars, ROW * walk.names.length + 24);
  const span = Math.min(4 * walk.period, end), from = Math.min(Math.max(time - span / 2, 0), Math.max(end - span, 0));
  const toPage = (t) => MARGIN + ((t - from) / span) * (width - MARGIN - 12);
  context.font = "14px system-ui, 'DejaVu Sans', sans-serif";
  walk.names.forEach((name, leg) => {
    const top = leg * ROW + 3;
    context.fillStyle = colours.pale;
    context.fillRect(toPage(from), top, toPage(from + span) - toPage(from), ROW - 7);
    context.fillStyle = colours.stance;
    walk.touching.forEach((row, i) => {
      const t = i * walk.touchingStep;
      if (row[leg] && t >= from && t < from + span) {
        context.fillRect(toPage(t), top, toPage(t + walk.touchingStep) - toPage(t) + 0.5, ROW - 7);
      }
    });
    context.fillStyle = "#1f2328";
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.fillText(name, MARGIN - 8, top + (ROW - 7) / 2);
  });
  context.fillRect(toPage(time) - 1, 0, 2, height - 20);
}

function draw() {
  drawView();
  drawBars();
  const moment = momentAt(time), x = walk.middle[moment][0];
  element("time").value = String(Math.round((1000 * time) / end));
  element("state").textContent = `t = ${time.toFixed(2)} s · ${x.toFixed(2)} m along x`;
}

function frame(now) {
  if (playing && last !== null) {
    time = (time + (Math.min(now - last, 100) / 1000) * Number(element("rate").value)) % end;
    draw();
  }
  last = now;
  if (playing) requestAnimationFrame(frame);
}

function setPlaying(wanted) {
  playing = wanted;
  element("play").textContent = playing ? "Pause" : "Play";
  last = null;
  if (playing) requestAnimationFrame(frame);
}

function seek(t) {
  setPlaying(false);
  time = Math.min(Math.max(t, 0), end);
  draw();
}

function turnBy(sideways, upwards) {
  azimuth += sideways;
  elevation = Math.min(Math.max(elevation + upwards, -0.2), Math.PI / 2);
  draw();
}

element("play").addEventListener("click", () => setPlaying(!playing));
element("time").addEventListener("input", () => seek((Number(element("time").value) / 1000) * end));
view.addEventListener("pointerdown", (event) => view.setPointerCapture(event.pointerId));
view.addEventListener("pointermove", (event) => {
  if (view.hasPointerCapture(event.pointerId)) turnBy(-TURN * event.movementX, TURN * event.movementY);
});
view.addEventListener("keydown", (event) => {
  const turns = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  if (!turns) return;
  turnBy(KEY_TURN * turns[0], KEY_TURN * turns[1]);
  event.preventDefault();
});
document.addEventListener("keydown", (event) => {
  if (event.key !== " " || ["BUTTON", "SELECT"].includes(event.target.tagName)) return;
  setPlaying(!playing);
  event.preventDefault();
});
window.addEventListener("resize", draw);

const asked = /^#t=([0-9.]+)$/.exec(location.hash);
draw();
if (asked) seek(Number(asked[1]));
else setPlaying(!window.matchMedia("(prefers-reduced-motion: reduce)").matches);
