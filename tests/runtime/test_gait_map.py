from __future__ import annotations

import math
import shutil
import threading
from collections.abc import Callable
from dataclasses import FrozenInstanceError, replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.publishing import Parts, publish
from gaitflow.runtime import ArtifactError, GaitMap, OutOfDomain


@pytest.fixture(scope="module")
def gait_map(pristine: Path) -> GaitMap:
    return GaitMap.load(pristine)


def test_newest_version_is_loaded_by_semantic_order(parts: Parts, preferring: Callable[[str], Parts], tmp_path: Path):
    publish(tmp_path, parts, "1.9.0")
    publish(tmp_path, preferring("walking"), "1.10.0")
    assert str(GaitMap.load(tmp_path / "quickstart").manifest.version) == "1.10.0"
    assert GaitMap.load(str(tmp_path / "quickstart")).select(1.3, 0.6).gait == "walking"
    assert GaitMap.load(tmp_path / "quickstart" / "1.9.0").select(1.3, 0.6).gait == "gallop"


def test_nothing_to_load_says_what_makes_it(tmp_path: Path) -> None:
    with pytest.raises(ArtifactError, match=r"no artifact here.*gaitflow publish"):
        GaitMap.load(tmp_path / "none")
    with pytest.raises(ArtifactError, match=r"1\.0\.0/manifest\.json: cannot be read \(No such file"):
        GaitMap.load(tmp_path / "1.0.0")


@pytest.mark.parametrize("name", ["manifest.json", "classifier.onnx", "warmstarts.safetensors"])
@pytest.mark.parametrize("damage", ["flipped", "truncated", "missing"])
def test_a_damaged_file_is_named_on_load(artifact: Path, name: str, damage: str) -> None:
    content = bytearray((artifact / name).read_bytes())
    (artifact / name).unlink()
    if damage == "flipped":
        content[len(content) // 3] ^= 16
    if damage != "missing":
        (artifact / name).write_bytes(content[: -3 if damage == "truncated" else None])
    with pytest.raises(ArtifactError, match=name):
        GaitMap.load(artifact)


@pytest.mark.parametrize("damage", ["flipped", "truncated", "missing"])
def test_a_damaged_atlas_is_named_when_a_start_is_asked_for(artifact: Path, damage: str) -> None:
    content = bytearray((artifact / "atlas.safetensors").read_bytes())
    (artifact / "atlas.safetensors").unlink()
    if damage == "flipped":
        content[len(content) // 3] ^= 16
    if damage != "missing":
        (artifact / "atlas.safetensors").write_bytes(content[: -3 if damage == "truncated" else None])
    gait_map = GaitMap.load(artifact)
    choice = gait_map.select(1.3, 0.6)
    assert choice.gait == "gallop"
    for ask in (lambda: choice.warm_start, lambda: gait_map.plan(1.3, 0.6)):
        with pytest.raises(ArtifactError, match=r"atlas\.safetensors: "):
            ask()


def test_selecting_never_opens_the_problem(artifact: Path) -> None:
    (artifact / "problem.casadi").write_bytes(b"hostile")
    gait_map = GaitMap.load(artifact)
    assert gait_map.select(1.3, 0.6).warm_start is not None
    with pytest.raises(ArtifactError, match=r"problem\.casadi: its content is not what the manifest lists"):
        gait_map.plan(1.3, 0.6)


def test_choice_is_the_classifiers_with_all_gaits_ranked(gait_map: GaitMap) -> None:
    slow, fast = gait_map.select(speed=0.3, cycle_duration=0.6), gait_map.select(speed=1.3, cycle_duration=0.6)
    assert (slow.gait, slow.pattern, slow.in_domain) == ("walking", "0111/1101", True)
    assert (fast.gait, fast.pattern) == ("gallop", "0110/1100")
    assert [gait for gait, _ in fast.ranked] == ["gallop", "walking"]
    # softmax of -+(5 * 1.3 - 3.5)
    assert fast.probability == fast.ranked[0][1] == pytest.approx(1 / (1 + math.exp(-6.0)), abs=1e-6)
    assert sum(probability for _, probability in fast.ranked) == pytest.approx(1, abs=1e-6)
    with pytest.raises(FrozenInstanceError):
        fast.gait = "walking"


@pytest.mark.parametrize(("speed", "cycle"), [(2.2, 0.6), (0.05, 0.6), (0.9, 0.3), (0.9, 1.3), (2.0, 0.45), (2.1, 0.4)])
def test_outside_the_domain_nothing_is_said(gait_map: GaitMap, speed: float, cycle: float) -> None:
    choice = gait_map.select(speed, cycle)
    assert choice.in_domain is False
    assert choice.gait is choice.pattern is choice.warm_start is None
    assert choice.ranked == ()
    assert choice.probability == 0
    with pytest.raises(OutOfDomain, match=r"outside the map's .* to |without a feasible gait: \(2\.1 m/s, 0\.4 s\)"):
        gait_map.plan(speed, cycle)


@pytest.mark.parametrize(("speed", "cycle"), [(2.2, 0.6), (0.05, 0.6), (0.9, 1.3), (2.0, 0.45), (-1.0, 0.5)])
def test_beyond_the_domain_a_guess_has_to_be_asked_for(gait_map: GaitMap, speed: float, cycle: float) -> None:
    choice = gait_map.select(speed, cycle, beyond=True)
    assert choice.in_domain is False
    assert choice.distance == gait_map.select(speed, cycle).distance > 0
    assert choice.gait == ("gallop" if speed > 0.7 else "walking")
    assert len(choice.ranked) == 2 and choice.probability == choice.ranked[0][1] > 0.5
    start = choice.warm_start
    assert (start.gait, start.pattern) == (choice.gait, choice.pattern)
    assert start.times[-1] == pytest.approx(cycle)


def test_beyond_says_the_same_inside(gait_map: GaitMap) -> None:
    assert gait_map.select(0.77, 0.66, beyond=True) == gait_map.select(0.77, 0.66)
    assert gait_map.select(0.9, 0.666666667).distance == 0
    assert 0 < gait_map.select(0.77, 0.66).distance < 0.71


@pytest.mark.parametrize("far", [1e30, 1e300, -1e300])
@pytest.mark.filterwarnings("error")
def test_however_far_beyond_probabilities_stay_numbers(gait_map: GaitMap, far: float) -> None:
    for task in ((far, 0.6), (0.9, abs(far))):
        choice = gait_map.select(*task, beyond=True)
        assert sum(probability for _, probability in choice.ranked) == pytest.approx(1, abs=1e-6)
        assert choice.distance > 1e29


def test_no_cycle_lasts_nothing(gait_map: GaitMap) -> None:
    choice = gait_map.select(0.9, 0.0, beyond=True)
    assert (choice.gait, choice.warm_start, choice.in_domain) == (None, None, False)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, "0.9", None, True, 1j, [0.9], np.nan, 10**400])
def test_what_is_no_finite_number_is_named(gait_map: GaitMap, bad: object) -> None:
    for ask in (gait_map.select, gait_map.plan):
        with pytest.raises(ValueError, match=r"^speed = .*finite number"):
            ask(bad, 0.6)
        with pytest.raises(ValueError, match=r"^cycle_duration = .*finite number"):
            ask(0.9, cycle_duration=bad)


@pytest.mark.parametrize("number", [1, np.float32(1), np.int64(1), Fraction(1)])
def test_any_real_number_is_taken(gait_map: GaitMap, number: object) -> None:
    assert gait_map.select(number, number) == gait_map.select(1.0, 1.0)


def test_warm_start_is_much_nearer_the_optimum_than_the_mean(gait_map: GaitMap, parts: Parts) -> None:
    for speed, cycle in ((0.55, 0.63), (1.13, 0.85), (1.63, 0.52)):
        start, plan = gait_map.select(speed, cycle).warm_start, gait_map.plan(speed, cycle)
        assert (start.gait, start.pattern) == (plan.gait, plan.pattern)
        expected = parts.problem.layout.unpack(start.primal, cycle)
        np.testing.assert_allclose(start.base, expected.base)
        np.testing.assert_allclose(start.forces, expected.forces)
        mean = gait_map.mean_start(plan.gait, cycle)
        assert np.abs(start.base - plan.base).max() < 0.25 * np.abs(mean.base - plan.base).max()
        assert np.abs(start.durations - plan.durations).max() < 0.05 * cycle
        assert start.multipliers_bounds.shape == start.primal.shape
        assert start.multipliers_rows.shape == (parts.problem.ng,)


def test_warm_start_of_a_gait_without_nodes_there_is_its_regions_mean(parts: Parts, tmp_path: Path) -> None:
    bare = GaitMap.load(publish(tmp_path, replace(parts, atlas=parts.atlas.of([0]))))
    known, unknown = bare.select(0.3, 0.6), bare.select(1.3, 0.8)
    assert not np.array_equal(known.warm_start.primal, bare.mean_start("walking", 0.6).primal)
    np.testing.assert_array_equal(unknown.warm_start.primal, bare.mean_start("gallop", 0.8).primal)


def test_mean_start_of_a_gait_that_there_is_not(gait_map: GaitMap) -> None:
    with pytest.raises(ValueError, match="gait = 'trot': the map has walking, gallop"):
        gait_map.mean_start("trot", 0.6)


def test_mean_start_is_the_region_unpacked_for_the_cycle(gait_map: GaitMap, parts: Parts) -> None:
    start = gait_map.mean_start("gallop", 0.8)
    region, layout = parts.starts[1], parts.problem.layout
    expected = layout.unpack(region.primal, 0.8)
    assert (start.gait, start.pattern) == (region.gait, region.pattern)
    np.testing.assert_allclose(start.base, expected.base)
    np.testing.assert_allclose(start.forces, expected.forces)
    assert start.times[-1] == pytest.approx(0.8)
    np.testing.assert_array_equal(start.primal, region.primal)
    np.testing.assert_array_equal(start.multipliers_bounds, region.bounds)
    np.testing.assert_array_equal(start.multipliers_rows, region.rows)
    with pytest.raises(ValueError, match="read-only"):
        start.primal[0] = 1.0


number = st.floats(-0.5, 2.5)


@given(st.lists(st.tuples(number, number), min_size=1, max_size=40))
def test_many_equal_one_by_one(gait_map: GaitMap, tasks: list[tuple[float, float]]) -> None:
    many = gait_map.select_many(*np.array(tasks).T)
    for n, task in enumerate(tasks):
        one = gait_map.select(*task)
        assert many.in_domain[n] == one.in_domain
        assert many.gaits[n] == one.gait
        assert (gait_map.gaits[many.index[n]].name if many.index[n] >= 0 else None) == one.gait
        assert many.probability[n] == pytest.approx(one.probability, abs=1e-6)


def test_many_take_the_shape_of_their_arguments(gait_map: GaitMap) -> None:
    speeds, cycles = np.linspace(0.1, 2.1, 7)[:, None], np.linspace(0.4, 1.2, 3)
    many = gait_map.select_many(speeds, cycles)
    assert {array.shape for array in vars(many).values()} == {(7, 3)}
    assert gait_map.select_many(0.9, 0.6).gaits.shape == ()
    assert gait_map.select_many([], []).gaits.shape == (0,)
    assert gait_map.select_many([5.0], 0.6).gaits.tolist() == [None]


def test_bad_arrays_are_named_with_the_place(gait_map: GaitMap) -> None:
    with pytest.raises(ValueError, match=r"speeds\[1\] = nan: must be a finite number"):
        gait_map.select_many([0.9, np.nan], 0.6)
    with pytest.raises(ValueError, match=r"cycle_durations\[0, 1\] = inf"):
        gait_map.select_many(0.9, [[0.6, np.inf]])
    with pytest.raises(ValueError, match="speeds: must hold finite numbers"):
        gait_map.select_many(["fast"], 0.6)
    with pytest.raises(ValueError, match="broadcast"):
        gait_map.select_many([0.9, 1.0, 1.1], [0.6, 0.7])


def test_many_threads_get_the_answers_of_one(gait_map: GaitMap) -> None:
    rng = np.random.default_rng(1)
    tasks = rng.uniform((0.1, 0.4), (2.1, 1.2), (400, 2)).tolist()
    expected = [gait_map.select(*task) for task in tasks]
    wrong: list[object] = []
    barrier = threading.Barrier(8)

    def ask(offset: int) -> None:
        barrier.wait()
        for n in range(len(tasks)):
            m = (n * 7 + offset * 50) % len(tasks)
            if gait_map.select(*tasks[m]) != expected[m]:
                wrong.append(tasks[m])

    threads = [threading.Thread(target=ask, args=(offset,)) for offset in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def test_a_copied_artifact_answers_alike(pristine: Path, tmp_path: Path, gait_map: GaitMap) -> None:
    copy = GaitMap.load(shutil.copytree(pristine, tmp_path / "anywhere"))
    assert copy.select(0.77, 0.66) == gait_map.select(0.77, 0.66)
