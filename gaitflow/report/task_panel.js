// What #task tells of a task: its gait, its numbers, what came next, its motion. Needs motion_player.js.

let player = null;

// `robot` is what all motions of the map have in common, null without a motion.
function showTask(task, robot) {
  element("gait").textContent = task.found ? task.gait : "No gait found";
  element("gait").style.borderColor = task.colour || "#222";
  element("title").textContent = task.title;
  element("facts").replaceChildren(...task.facts.map(([name, value]) => {
    const fact = document.createElement("div");
    fact.append(cell("dt", name), cell("dd", value));
    return fact;
  }));
  element("rivals").hidden = task.rivals.length === 0;
  element("rivals").tBodies[0].replaceChildren(...task.rivals.map((rival) => {
    const row = document.createElement("tr");
    row.append(...rival.map((text) => cell("td", text)));
    return row;
  }));
  showMotion(task.motion && { ...robot, ...task.motion });
}

function cell(name, text) {
  const made = document.createElement(name);
  made.textContent = text;
  return made;
}

function showMotion(motion) {
  element("unstored").hidden = Boolean(motion);
  if (element("player")) element("player").hidden = !motion;
  if (!motion) return player?.setPlaying(false);
  if (player) player.show(motion);
  else player = motionPlayer(motion, element("player"));
}

function playTask() {
  const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
  if (player && !element("player").hidden) player.setPlaying(!still);
}
