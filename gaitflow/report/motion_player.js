// Plays a motion on #view, with its gait diagram on #bars and the controls around them. Needs animation_view.js.

const element = (id) => document.getElementById(id);
const MARGIN = 44, ROW = 22; // px of the gait diagram
const TURN = 0.008, KEY_TURN = 0.1; // rad: a pixel of dragging, an arrow key

function drawGaitDiagram(canvas, motion, time) {
  const cycle = motion.times[motion.times.length - 1], legs = motion.legs.length;
  const [context, width, height] = prepared(canvas, ROW * legs + 30);
  const toPage = (t) => MARGIN + (t / cycle) * (width - MARGIN - 12);
  context.font = "14px system-ui, 'DejaVu Sans', sans-serif";
  motion.rows.forEach((row, leg) => {
    const top = leg * ROW + 3;
    context.fillStyle = motion.colours.pale;
    context.fillRect(toPage(0), top, toPage(cycle) - toPage(0), ROW - 7);
    context.fillStyle = motion.colours.stance;
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

// `keys` is the element whose keys play, pause and step; `motion` may be changed with `show`.
function motionPlayer(motion, keys) {
  const view = element("view"), bars = element("bars"), slider = element("time"), play = element("play");
  const corner = motion.planar ? [0, 0] : [0.45, 0.3];
  const camera = { azimuth: corner[0], elevation: corner[1] };
  const shown = { forces: element("forces").checked, boxes: element("boxes").checked };
  let robot, cycle, cycles, time, playing = false, last = null, request = 0;

  function show(other) {
    motion = other;
    robot = robotView(view, motion, camera, shown);
    cycle = motion.times[motion.times.length - 1];
    time = cycles = 0; // whole cycles walked so far
    draw();
  }

  function draw() {
    const degrees = (angle) => `${(Math.round((18000 * angle) / Math.PI) / 100 + 0).toFixed(2)}°`;
    const pose = robot.poseAt(time);
    robot.draw(pose, cycles);
    drawGaitDiagram(bars, motion, time);
    slider.value = String(Math.round((1000 * time) / cycle));
    slider.setAttribute("aria-valuetext", `${time.toFixed(3)} seconds`);
    const turns = motion.planar ? ["pitch (nose up)", degrees(-pose.angles[1])] :
      ["yaw, pitch, roll", pose.angles.map(degrees).join(", ")];
    const standing = motion.legs.filter((_, leg) => pose.standing[leg]).join(" ") || "none, in flight";
    element("state").textContent = `t = ${time.toFixed(3)} s · forward ${pose.velocity.toFixed(3)} m/s · ` +
      `height ${pose.position[2].toFixed(4)} m · ${turns.join(" ")} · standing: ${standing}`;
  }

  function frame(now) {
    if (last !== null) {
      const advanced = time + (Math.min(now - last, 100) / 1000) * Number(element("rate").value);
      cycles += Math.floor(advanced / cycle);
      time = advanced % cycle;
      draw();
    }
    last = now;
    request = requestAnimationFrame(frame);
  }

  function setPlaying(wanted) {
    playing = wanted;
    play.textContent = playing ? "Pause" : "Play";
    last = null;
    cancelAnimationFrame(request);
    if (playing) request = requestAnimationFrame(frame);
  }

  function seek(t) {
    setPlaying(false);
    time = Math.min(Math.max(t, 0), cycle);
    draw();
  }

  function stepBy(direction) {
    const step = robot.stepAt(time);
    const behind = time > motion.times[step] + 1e-9 ? step : step - 1;
    seek(motion.times[direction > 0 ? Math.min(step + 1, motion.times.length - 1) : Math.max(behind, 0)]);
  }

  function turnTo(azimuth, elevation) {
    if (motion.planar) return;
    camera.azimuth = azimuth;
    camera.elevation = Math.min(Math.max(elevation, -0.2), Math.PI / 2);
    draw();
  }

  function onDrag(canvas, moved) {
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      moved(event, true);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (canvas.hasPointerCapture(event.pointerId)) moved(event, false);
    });
  }

  play.addEventListener("click", () => setPlaying(!playing));
  slider.addEventListener("input", () => seek((Number(slider.value) / 1000) * cycle));
  for (const id of ["forces", "boxes"]) {
    element(id).addEventListener("change", (event) => {
      shown[id] = event.target.checked;
      draw();
    });
  }
  for (const button of document.querySelectorAll("[data-view]")) {
    button.addEventListener("click", () => turnTo(...button.dataset.view.split(" ").map(Number)));
  }
  onDrag(view, (event, first) => {
    if (!first) turnTo(camera.azimuth - TURN * event.movementX, camera.elevation + TURN * event.movementY);
  });
  onDrag(bars, (event) => seek(((event.offsetX - MARGIN) / (bars.clientWidth - MARGIN - 12)) * cycle));
  view.addEventListener("keydown", (event) => {
    const turn = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (event.key === "Home") turnTo(...corner);
    else if (turn) turnTo(camera.azimuth + KEY_TURN * turn[0], camera.elevation + KEY_TURN * turn[1]);
    else return;
    event.preventDefault();
  });
  keys.addEventListener("keydown", (event) => {
    const typing = ["BUTTON", "SELECT", "SUMMARY"].includes(event.target.tagName) || event.target.type === "checkbox";
    if (event.key === " " && !typing) setPlaying(!playing);
    else if (event.key === ",") stepBy(-1);
    else if (event.key === ".") stepBy(1);
    else return;
    event.preventDefault();
  });
  window.addEventListener("resize", () => { if (view.clientWidth) draw(); });

  show(motion);
  return { show, seek, setPlaying };
}
