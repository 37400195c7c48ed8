"use strict";
// The robot in space on a canvas, at any time of a motion.

const FOOT_RADIUS = 5; // px
const FACES = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];

// --- vectors -----------------------------------------------------------------------------------------------------
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

function rotated([x, y, z], angle) { // about the vertical
  const c = Math.cos(angle), s = Math.sin(angle);
  return [c * x - s * y, s * x + c * y, z];
}

// `motion` is what gaitflow.report.animation writes. `camera` {azimuth, elevation} [rad] and `shown` {forces, boxes}
// are read whenever a pose is drawn, `cycles` whole cycles after the first.
function robotView(canvas, motion, camera, shown) {
  const colours = motion.colours, knots = motion.times.length;

  function uphill([x, y, z]) { // terrain frame to a level one
    const c = Math.cos(motion.slope), s = Math.sin(motion.slope);
    return [c * x - s * z, y, s * x + c * z];
  }

  function toView(v) { // x right, y up, z towards the reader
    const angles = [camera.azimuth, camera.elevation], [ca, ce] = angles.map(Math.cos), [sa, se] = angles.map(Math.sin);
    return times([[ca, sa, 0], [-sa * se, ca * se, ce], [sa * ce, -ca * ce, se]], v);
  }

  // --- the robot at a time ------------------------------------------------------------------------------------------
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
    const h = Math.max(motion.times[step + 1] - motion.times[step], 1e-12);
    const line = (first, last) => add(scaled(first, 1 - part), scaled(last, part));
    const between = (values) => line(values[step], values[step + 1]);
    const mean = (values) => scaled(subtract(values[step + 1], values[step]), 1 / h);
    const path = (values, rates) => { // the cubic through both ends and their rates, or the straight line
      if (!motion.curved) return between(values);
      const first = scaled(subtract(rates[step], mean(values)), 1 - part);
      const last = scaled(subtract(rates[step + 1], mean(values)), part);
      return add(between(values), scaled(subtract(first, last), h * part * (1 - part)));
    };
    const angles = path(motion.angles, motion.angleRates), position = path(motion.position, motion.velocity);
    const turn = rotation(angles), toWorld = (v) => add(position, times(turn, v));
    const heading = (1 - part) * motion.headings[step] + part * motion.headings[step + 1];
    const velocity = motion.curved ? between(motion.velocity) : mean(motion.position);
    return {
      angles, position, toWorld, heading,
      velocity: rotated(velocity, -heading)[0],
      middle: [position[0], between(motion.path)[1], 0.55 * motion.height],
      hips: motion.hips.map(toWorld),
      feet: motion.feet[step].map((foot, leg) => add(scaled(foot, 1 - part), scaled(motion.feet[step + 1][leg], part))),
      forces: motion.forces[step].map((force, leg) => line(force, motion.endForces[step][leg])),
      standing: motion.rows.map((row) => row[phase] === "1"),
    };
  }

  // --- the view -----------------------------------------------------------------------------------------------------
  function draw(pose, cycles) {
    const [context, width, height] = prepared(canvas, canvas.clientHeight);
    const reach = Math.max(...motion.body.map((corner) => Math.hypot(corner[0], corner[1]))) + 0.5 * motion.height;
    const above = 0.9 * reach * Math.sin(camera.elevation);
    const scale = Math.min(width / (2.6 * reach), height / (2.1 * motion.height + above));
    const page = (point) => {
      const [x, y, z] = toView(uphill(rotated(subtract(point, pose.middle), -pose.heading)));
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

    drawGround(pose, cycles, line, reach);
    const items = [];
    const depth = (...points) => points.reduce((sum, point) => sum + page(point)[2], 0) / points.length;
    pose.hips.forEach((hip, leg) => {
      const foot = pose.feet[leg], below = [foot[0], foot[1], 0], boxCentre = motion.defaultFeet[leg];
      items.push([depth(hip, foot), () => drawLeg(context, page, line, hip, foot, pose.standing[leg])]);
      if (!motion.planar && foot[2] > 1e-3) items.push([-Infinity, () => line(foot, below, "#9a9a9a", 1, [2, 3])]);
      if (shown.boxes) items.push([-Infinity, () => drawBox(pose, boxCentre, line)]);
    });
    const corners = motion.body.map(pose.toWorld);
    items.push([depth(...corners), () => drawBody(context, page, corners)]);
    items.sort((a, b) => a[0] - b[0]).forEach(([, draw]) => draw());
    if (shown.forces) {
      pose.feet.forEach((foot, leg) => {
        const tip = add(foot, scaled(pose.forces[leg], motion.height));
        if (pose.standing[leg]) drawArrow(context, page(foot), page(tip), colours.force);
      });
    }
  }

  // The motion of the first cycle is drawn for ever; the floor goes back by a whole cycle's twist each time instead.
  function floorFrame(cycles) {
    const [dx, dy] = motion.path[knots - 1], turn = motion.headings[knots - 1];
    let origin = [0, 0, 0];
    for (let i = 0; i < (turn ? cycles : 0); i++) origin = add(origin, rotated([dx, dy, 0], i * turn));
    if (!turn) origin = [cycles * dx, cycles * dy, 0];
    return {
      toFloor: (point) => add(origin, rotated(point, cycles * turn)),
      fromFloor: (point) => rotated(subtract(point, origin), -cycles * turn),
    };
  }

  function drawGround(pose, cycles, line, reach) {
    const cell = 0.25 * motion.height, far = Math.ceil((2.2 * reach) / cell);
    const { toFloor, fromFloor } = floorFrame(cycles);
    const [mx, my] = toFloor([pose.middle[0], pose.middle[1], 0]).map((x) => Math.round(x / cell) * cell);
    const drawn = (from, to, ...style) => line(fromFloor(from), fromFloor(to), ...style);
    if (motion.planar) {
      drawn([mx - 4 * far * cell, 0, 0], [mx + 4 * far * cell, 0, 0], colours.ground, 1.5);
      for (let i = -4 * far; i <= 4 * far; i++) {
        const x = mx + i * cell;
        drawn([x, 0, 0], [x - 0.4 * cell, 0, -0.4 * cell], colours.swing, 1);
      }
      return;
    }
    for (let i = -far; i <= far; i++) {
      drawn([mx + i * cell, my - far * cell, 0], [mx + i * cell, my + far * cell, 0], "#e6e6e3", 1);
      drawn([mx - far * cell, my + i * cell, 0], [mx + far * cell, my + i * cell, 0], "#e6e6e3", 1);
    }
  }

  function drawLeg(context, page, line, hip, foot, standing) {
    const colour = standing ? colours.stance : colours.swing;
    line(hip, foot, "#6b6b6b", 6);
    line(hip, foot, colour, 4);
    const [x, y] = page(foot);
    context.beginPath();
    context.arc(x, y, FOOT_RADIUS, 0, 2 * Math.PI);
    context.fillStyle = colour;
    context.fill();
    context.lineWidth = 1.2;
    context.strokeStyle = "#6b6b6b";
    context.stroke();
  }

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

  return { stepAt, poseAt, draw };
}
