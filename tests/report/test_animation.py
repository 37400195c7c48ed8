"""The animation: complete, self-contained, nothing in it runs that came from a dataset; drawn by a real browser."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import subprocess
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from browser import PROGRAM

from gaitflow.report.animation import animation_page
from gaitflow.report.stored import scenario_of

COLOUR = "#117733"
HOSTILE = '</script><script>alert("gait")</script><img src=x onerror=alert(1)>'


class Elements(HTMLParser):
    """Start tags with their attributes, and the text inside script elements."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[str] = []
        self.text = ""
        self._inside = ""
        self.feed(html)

    def handle_starttag(self, tag, attrs) -> None:
        self.tags.append((tag, dict(attrs)))
        self._inside = tag
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag) -> None:
        self._inside = ""

    def handle_data(self, data) -> None:
        if self._inside == "script":
            self.scripts[-1] += data
        elif self._inside != "style":
            self.text += data


@pytest.fixture(scope="module")
def page(trot, anymal) -> str:
    return animation_page(trot, anymal, "walking trot", COLOUR)


def data_of(html: str) -> dict:
    return json.loads(Elements(html).scripts[0])


def test_it_says_what_it_shows(page, trot) -> None:
    text = Elements(page).text
    for part in ("walking trot", "anymal_b", "anymal-flat-vibration", "0.3 m/s", "0.8 s", trot.pattern, "feasible"):
        assert part in text
    assert "NOT feasible" not in text
    for kind in ("dynamics", "kinematic box", "slip in stance"):
        assert kind in text


def test_the_data_are_the_stored_motion(page, trot, anymal) -> None:
    data, trajectory = data_of(page), trot.trajectory
    weight = anymal.robot.mass * 9.81
    np.testing.assert_allclose(data["position"], trajectory.base[:, :3], atol=1e-5)
    np.testing.assert_allclose(data["angles"], trajectory.base[:, 3:6], atol=1e-5)
    np.testing.assert_allclose(data["feet"], trajectory.feet, atol=1e-5)
    np.testing.assert_allclose(np.array(data["forces"]) * weight, trajectory.forces, atol=1e-5 * weight)
    np.testing.assert_allclose(np.array(data["endForces"]) * weight, trajectory.end_forces, atol=1e-5 * weight)
    np.testing.assert_allclose(data["path"][-1], [0.3 * 0.8, 0.0], atol=1e-5)
    assert not data["curved"]
    np.testing.assert_allclose(np.cumsum(data["durations"])[-1], 0.8, atol=1e-4)
    assert data["rows"] == trot.pattern.split("/") and data["legs"] == ["LF", "RF", "LH", "RH"]
    assert not data["planar"]


def test_a_motion_that_is_not_feasible_says_so(trot, anymal) -> None:
    lifted = trot.trajectory.feet + np.array([0.0, 0.0, 0.5])
    broken = replace(trot, trajectory=replace(trot.trajectory, feet=lifted), violation=0.0)
    text = Elements(animation_page(broken, anymal, "walking trot", COLOUR)).text
    assert "NOT feasible" in text and "above 1e-6" in text


def test_nothing_is_loaded_from_elsewhere(page) -> None:
    elements = Elements(page)
    assert not {tag for tag, _ in elements.tags} & {"link", "img", "iframe", "object", "embed", "base"}
    assert not [value for _, found in elements.tags for name, value in found.items() if name in ("src", "href")]
    assert not re.search(r"https?://|url\(|@import|fetch\(|XMLHttpRequest", page)
    assert len(page) < 1_000_000


def test_only_the_script_and_the_style_that_the_policy_names_may_run(page) -> None:
    elements = Elements(page)
    (policy,) = [found["content"] for tag, found in elements.tags if found.get("http-equiv")]
    assert "default-src 'none'" in policy and "unsafe" not in policy
    code = elements.scripts[1]
    assert f"sha256-{base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()}" in policy
    assert not [name for _, found in elements.tags for name in found if name.startswith("on") or name == "style"]


def test_text_of_a_dataset_is_text(trot, anymal) -> None:
    """Names that the scenario's checks would refuse, in every place where a name goes."""
    first, *others = anymal.robot.legs
    legs = (first.model_copy(update={"name": HOSTILE}), *others)
    robot = anymal.robot.model_copy(update={"name": HOSTILE, "legs": legs})
    html = animation_page(trot, anymal.model_copy(update={"name": HOSTILE, "robot": robot}), HOSTILE, COLOUR)
    elements = Elements(html)
    assert len(elements.scripts) == 2 and "img" not in {tag for tag, _ in elements.tags}
    assert elements.text.count(HOSTILE) == 5  # robot and gait in the title, gait, robot, scenario in the heading
    assert data_of(html)["legs"][0] == HOSTILE


def test_a_planar_robot_is_seen_from_the_side(published) -> None:
    solution = next(row for row in published if row.trajectory is not None)
    html = animation_page(solution, scenario_of(published), "gallop", COLOUR)
    assert data_of(html)["planar"]
    assert not [found for _, found in Elements(html).tags if "data-view" in found]
    assert np.abs(np.array(data_of(html)["feet"])[..., 1]).max() == 0


def browse(address: str, *options: str) -> subprocess.CompletedProcess[str]:
    """What chromium printed; fails when the page threw or was refused anything."""
    quiet = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--enable-logging=stderr"]
    command = [str(PROGRAM), *quiet, "--window-size=1000,900", *options, address]
    done = subprocess.run(command, capture_output=True, text=True, timeout=90, check=True)
    assert "CONSOLE" not in done.stderr, done.stderr
    return done


needs_browser = pytest.mark.skipif(PROGRAM is None, reason="needs the browser chromium or google-chrome")

# A visitor: every control once, what the page says after it.
VISIT = """
const said = [], slider = element("time"), play = element("play"), view = element("view");
const say = () => said.push(element("state").textContent.split(" ")[2] + " " + play.textContent);
const press = (key, where = document.body) => where.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
const picture = () => view.toDataURL();
say();
press("."); say();
press(","); say();
slider.value = "500"; slider.dispatchEvent(new Event("input")); say();
press(" "); say();
press(" "); say();
const before = picture();
press("ArrowLeft", view); const turned = picture();
press("Home", view); const back = picture();
element("boxes").click(); const boxes = picture();
element("forces").click(); const bare = picture();
document.querySelector("[data-view='0 1.5708']").click(); const above = picture();
said.push([before !== turned, before === back, boxes !== back, bare !== boxes, above !== bare].join(" "));
document.body.innerHTML = "";
document.body.textContent = said.join("; ");
"""


@pytest.mark.slow
@needs_browser
def test_every_control_works(page, trot, tmp_path: Path) -> None:
    file = tmp_path / "motion.html"
    free = re.sub(r"<meta http-equiv[^>]*>", "", page)  # the page's own policy would not let a visitor's script run
    file.write_text(free.replace("</body>", f"<script>{VISIT}</script></body>"), encoding="utf-8")
    dom = browse(f"{file.as_uri()}#t=0.3", "--dump-dom").stdout
    times = trot.trajectory.times
    after = times[times > 0.3 + 1e-9][0]
    before = times[times < after - 1e-9][-1]
    expected = ["0.300 Play", f"{after:.3f} Play", f"{before:.3f} Play", "0.400 Play", "0.400 Pause", "0.400 Play"]
    assert "; ".join([*expected, "true true true true true"]) in dom


@pytest.mark.slow
@needs_browser
def test_a_browser_draws_it(page, tmp_path: Path) -> None:
    file = tmp_path / "motion.html"
    file.write_text(page, encoding="utf-8")
    pictures = []
    for time in (0.05, 0.3):
        target = tmp_path / f"{time}.png"
        browse(f"{file.as_uri()}#t={time}", f"--screenshot={target}")
        pictures.append(matplotlib.image.imread(target)[..., :3])
    one, two = pictures
    assert np.abs(one - two).max(axis=2).mean() > 0.005  # legs, forces and the cursor moved
    red = (one[..., 0] > 0.7) & (one[..., 1:].max(axis=2) < 0.2)
    assert red.sum() > 100  # force arrows
    green = np.abs(one - np.array([0x11, 0x77, 0x33]) / 255).max(axis=2) < 0.02
    assert green.sum() > 10_000  # contact bars and standing legs
