// One motion that fills the page. "#t=0.3" in the address pauses at 0.3 s.

const player = motionPlayer(JSON.parse(element("motion").textContent), document);
const asked = /^#t=([0-9.]+)$/.exec(location.hash);
if (asked) player.seek(Number(asked[1]));
else player.setPlaying(!window.matchMedia("(prefers-reduced-motion: reduce)").matches);
