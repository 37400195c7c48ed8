"""Published maps of formats 1 and 2 load and select; they plan for who trusts the code in them."""

from __future__ import annotations

import json
import shutil
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import load_file

from gaitflow.core import check
from gaitflow.runtime import ArtifactError, GaitMap
from gaitflow.runtime.files import ATLAS, PROBLEM, WARM_STARTS, entry_of
from gaitflow.runtime.manifest import encode

MODELS = Path(__file__).parents[2] / "models"
FIRST, SECOND = (MODELS / "half-cheetah-slope20-vibration" / version for version in ("1.0.0", "1.1.0"))
TASKS = [(0.3, 0.8), (0.9, 0.6), (1.7, 0.6)]


@pytest.fixture
def second(tmp_path: Path) -> Path:
    """A map of format 2 of one's own."""
    return Path(shutil.copytree(SECOND, tmp_path / "1.1.0"))


def edited(folder: Path, *path: str, value: object) -> None:
    """Replace a value of the manifest and make its digests anew."""
    data = json.loads((folder / "manifest.json").read_text())
    holder = data
    for step in path[:-1]:
        holder = holder[step]
    holder[path[-1]] = value
    for name in data["files"]:
        data["files"][name] = asdict(entry_of((folder / name).read_bytes()))
    (folder / "manifest.json").write_bytes(encode(data))


def older() -> list[Path]:
    """Folders of the published maps of formats 1 and 2."""
    manifests = sorted(MODELS.glob("*/*/manifest.json"))
    return [file.parent for file in manifests if json.loads(file.read_text())["format"] < 3]


@pytest.mark.parametrize("folder", older(), ids=lambda path: f"{path.parent.name}-{path.name}")
def test_every_older_map_loads_and_selects(folder: Path) -> None:
    gait_map = GaitMap.load(folder)
    manifest = gait_map.manifest
    assert manifest.format == (1 if folder.name == "1.0.0" else 2)
    assert gait_map.axes == ("speed", "cycle_duration")
    choice = gait_map.select(**manifest.domain.middle)
    assert choice.in_domain and choice.gait in {gait.name for gait in gait_map.gaits}
    assert choice.warm_start.pattern == choice.pattern
    slope = 20.0 if "slope20" in folder.parent.name else 0.0
    assert gait_map.select(**manifest.domain.middle, slope=slope) == choice


@pytest.mark.parametrize("folder", [FIRST, SECOND], ids=["format 1", "format 2"])
def test_plans_need_trust_in_the_code_and_pass_todays_check(folder: Path) -> None:
    with pytest.raises(ArtifactError, match=r"problem\.casadi: .* holds its problem as code.*trust_code=True"):
        GaitMap.load(folder).plan(*TASKS[0])
    gait_map = GaitMap.load(folder, trust_code=True)
    for speed, cycle in TASKS:
        choice, plan = gait_map.select(speed, cycle), gait_map.plan(speed, cycle)
        task = gait_map.manifest.space.task({"speed": speed, "cycle_duration": cycle})
        assert task["slope"] == 20.0
        assert plan.feasible and check.worst(gait_map.manifest.scenario, plan, task, plan.pattern) <= 1e-6
        assert plan.tried[0][0] == choice.gait
        np.testing.assert_array_equal(plan.forces, plan.end_forces)


def test_format_1_starts_at_a_regions_mean() -> None:
    gait_map = GaitMap.load(FIRST)
    choice = gait_map.select(0.9, 0.6)
    np.testing.assert_array_equal(choice.warm_start.primal, gait_map.mean_start(choice.gait, 0.6).primal)
    probabilities = [probability for _, probability in choice.ranked]
    assert probabilities == sorted(probabilities, reverse=True), "without an atlas the likeliest comes first"


def test_gridded_nodes_keep_their_costs_and_get_tangents() -> None:
    stored, gait_map = load_file(SECOND / ATLAS), GaitMap.load(SECOND)
    atlas = gait_map._artifact.atlas
    grid = stored["speeds"], stored["cycle_durations"]
    assert len(atlas.sheets) == stored["sheets"][0]
    for number, sheet in enumerate(atlas.sheets):
        places = stored[f"{number}.places"]
        np.testing.assert_allclose(sheet.tasks[:, 0], grid[0][places[:, 0]])
        np.testing.assert_allclose(sheet.tasks[:, 1], grid[1][places[:, 1]])
        for task, cost in list(zip(sheet.tasks, sheet.costs, strict=True))[::17]:
            assert atlas.costs(task)[0][number] == pytest.approx(cost)
        by_place = {tuple(place): n for n, place in enumerate(places.tolist())}
        checked = 0
        for (i, j), n in by_place.items():
            below, above = by_place.get((i - 1, j)), by_place.get((i + 1, j))
            if below is None or above is None:
                continue
            near = [np.linalg.norm(sheet.coordinates[m] - sheet.coordinates[n]) <= sheet.tear for m in (below, above)]
            if all(near):
                slope = np.log(sheet.costs[above] / sheet.costs[below]) / (grid[0][i + 1] - grid[0][i - 1])
                assert sheet.slopes[n, 0] == pytest.approx(slope)
                checked += 1
        assert checked


def test_a_lone_node_has_no_tangent() -> None:
    atlas = GaitMap.load(SECOND)._artifact.atlas
    lone = [(sheet, n) for sheet in atlas.sheets for n in np.flatnonzero((sheet.slopes == 0).all(axis=1))]
    for sheet, n in lone:
        assert not sheet.tangents[n].any()


@pytest.mark.parametrize("name", [WARM_STARTS, ATLAS])
def test_damage_is_named(second: Path, name: str) -> None:
    content = bytearray((second / name).read_bytes())
    content[len(content) // 3] ^= 16
    (second / name).write_bytes(content)
    with pytest.raises(ArtifactError, match=name):
        GaitMap.load(second)


@pytest.mark.parametrize("content", [b"", b"garbage", b"\xff\xfe\x00"])
def test_code_that_is_no_function_is_refused(second: Path, content: bytes) -> None:
    (second / PROBLEM).write_bytes(content)
    with pytest.raises(ArtifactError, match=r"problem\.casadi: its content is not what the manifest lists"):
        GaitMap.load(second, trust_code=True).plan(0.9, 0.6)
    edited(second, "cost_scale", value=1.0)
    with pytest.raises(ArtifactError, match=r"problem\.casadi: CasADi .* cannot read it"):
        GaitMap.load(second, trust_code=True).plan(0.9, 0.6)


def test_a_function_of_something_else_is_refused(second: Path) -> None:
    casadi = pytest.importorskip("casadi")
    x = casadi.SX.sym("x", 3)
    (second / PROBLEM).write_text(casadi.Function("f", [x], [x]).serialize())
    edited(second, "cost_scale", value=1.0)
    with pytest.raises(ArtifactError, match=r"maps \[\(3, 1\)\] to \[\(3, 1\)\]; expected w \[734\]"):
        GaitMap.load(second, trust_code=True).plan(0.9, 0.6)


@pytest.mark.parametrize(
    ("path", "value", "fault"),
    [
        (("layout", "phases"), 10**9, "layout.phases = 1000000000: must be an integer from 4 to 4"),
        (("layout", "variables"), 735, "layout.variables = 735"),
        (("layout", "legs"), ["F"], "layout.legs"),
        (("domain", "speed"), [0.1, 0.1], "each above the one before"),
        (("scenario", "terrain"), {}, "without tasks.axes"),
        (("scenario", "robot"), {}, "scenario.robot.name: is missing"),
    ],
)
def test_a_wrong_field_is_named(second: Path, path: tuple[str, ...], value: object, fault: str) -> None:
    edited(second, *path, value=value)
    with pytest.raises(ArtifactError) as caught:
        GaitMap.load(second)
    assert fault in str(caught.value)
