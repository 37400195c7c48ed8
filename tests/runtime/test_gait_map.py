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
from tiny_map import TinyMap, linear_classifier, scenario_of, write_map

from gaitflow.config.scenario import Range
from gaitflow.core.domain import Domain
from gaitflow.problem import transcribe
from gaitflow.runtime import ArtifactError, GaitMap, OutOfDomain
from gaitflow.runtime.atlas import Atlas


@pytest.fixture(scope="module")
def gait_map(pristine: Path) -> GaitMap:
    return GaitMap.load(pristine)


def bare(tiny: TinyMap) -> TinyMap:
    """The same map whose atlas knows nothing."""
    return replace(tiny, atlas=Atlas.empty(tuple(tiny.domain.axes)))


def test_newest_version_is_loaded_by_semantic_order(
    tiny: TinyMap, preferring: Callable[[str], TinyMap], tmp_path: Path
) -> None:
    write_map(bare(tiny), tmp_path / "quickstart", "1.9.0")
    write_map(bare(preferring("walking")), tmp_path / "quickstart", "1.10.0")
    assert str(GaitMap.load(tmp_path / "quickstart").manifest.version) == "1.10.0"
    assert GaitMap.load(str(tmp_path / "quickstart")).select(1.3, 0.6).gait == "walking"
    assert GaitMap.load(tmp_path / "quickstart" / "1.9.0").select(1.3, 0.6).gait == "gallop"


def test_nothing_to_load_says_what_makes_it(tmp_path: Path) -> None:
    with pytest.raises(ArtifactError, match=r"no map here.*gaitflow publish"):
        GaitMap.load(tmp_path / "none")
    with pytest.raises(ArtifactError, match=r"1\.0\.0/manifest\.json: cannot be read \(No such file"):
        GaitMap.load(tmp_path / "1.0.0")


@pytest.mark.parametrize("name", ["manifest.json", "classifier.onnx", "warmstarts.safetensors", "atlas.safetensors"])
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


def test_selecting_never_opens_what_only_plans_need(artifact: Path) -> None:
    (artifact / "problem_check.safetensors").write_bytes(b"hostile")
    gait_map = GaitMap.load(artifact)
    assert gait_map.select(1.3, 0.6).warm_start is not None
    with pytest.raises(ArtifactError, match=r"problem_check\.safetensors: its content is not what the manifest lists"):
        gait_map.plan(1.3, 0.6)


def test_the_gait_is_the_cheapest_with_all_gaits_and_their_probabilities(gait_map: GaitMap) -> None:
    slow, fast = gait_map.select(speed=0.3, cycle_duration=0.6), gait_map.select(speed=1.7, cycle_duration=0.6)
    assert (slow.gait, slow.pattern, slow.in_domain) == ("walking", "0111/1101", True)
    assert (fast.gait, fast.pattern) == ("gallop", "0110/1100")
    assert (fast.speed, fast.cycle_duration, dict(fast.task)) == (1.7, 0.6, {"speed": 1.7, "cycle_duration": 0.6})
    assert sorted(gait for gait, _ in fast.ranked) == ["gallop", "walking"]
    # softmax of -+(5 * 1.7 - 3.5)
    assert fast.probability == fast.ranked[0][1] == pytest.approx(1 / (1 + math.exp(-10.0)), abs=1e-6)
    assert sum(probability for _, probability in fast.ranked) == pytest.approx(1, abs=1e-6)
    with pytest.raises(FrozenInstanceError):
        fast.gait = "walking"


def test_the_classifier_has_no_say_where_the_atlas_knows_and_all_where_not(
    tiny: TinyMap, preferring: Callable[[str], TinyMap], gait_map: GaitMap, tmp_path: Path
) -> None:
    wrong = GaitMap.load(write_map(preferring("gallop"), tmp_path / "wrong"))
    blind = GaitMap.load(write_map(bare(preferring("gallop")), tmp_path / "blind"))
    half = GaitMap.load(write_map(replace(preferring("gallop"), atlas=tiny.atlas.of([0])), tmp_path / "half"))
    for each, gait in ((wrong, "walking"), (blind, "gallop"), (half, "walking")):
        choice = each.select(0.3, 0.6)
        assert choice.gait == choice.ranked[0][0] == gait
        assert choice.probability == pytest.approx(1 / (1 + math.exp(4.0 if gait == "walking" else -4.0)), abs=1e-6)
        assert each.select_many(0.3, 0.6).gaits[()] == gait
        assert each.plan(0.3, 0.6).tried[0][0] == gait, "plan tries what select names"


@pytest.mark.parametrize(("speed", "cycle"), [(2.2, 0.6), (0.05, 0.6), (0.9, 0.3), (0.9, 1.3), (2.0, 0.45), (2.1, 0.4)])
def test_outside_the_domain_nothing_is_said(gait_map: GaitMap, speed: float, cycle: float) -> None:
    choice = gait_map.select(speed, cycle)
    assert choice.in_domain is False
    assert choice.gait is choice.pattern is choice.warm_start is None
    assert choice.ranked == ()
    assert choice.probability == 0
    with pytest.raises(OutOfDomain, match=r"outside the map's .* to |without a feasible gait: \(2\.1 m/s, 0\.4 s\)"):
        gait_map.plan(speed, cycle)


@pytest.mark.parametrize(
    ("speed", "cycle", "gait"),
    [
        (2.2, 0.6, "gallop"),
        (0.05, 0.6, "walking"),
        (2.0, 0.45, "gallop"),
        (-1.0, 0.5, "walking"),  # out of the atlas' reach, as the next one: the classifier's word
        (9.0, 0.6, "gallop"),
    ],
)
def test_beyond_the_domain_a_guess_has_to_be_asked_for(
    gait_map: GaitMap, speed: float, cycle: float, gait: str
) -> None:
    choice = gait_map.select(speed, cycle, beyond=True)
    assert choice.in_domain is False
    assert choice.distance == gait_map.select(speed, cycle).distance > 0
    assert choice.gait == gait
    assert len(choice.ranked) == 2 and choice.probability == choice.ranked[0][1]
    start = choice.warm_start
    assert (start.gait, start.pattern) == (choice.gait, choice.pattern)
    assert start.times[-1] == pytest.approx(cycle, rel=1e-4), "the start is rounded, and moved far along its tangents"


def test_beyond_says_the_same_inside(gait_map: GaitMap) -> None:
    assert gait_map.select(0.77, 0.66, beyond=True) == gait_map.select(0.77, 0.66)
    assert gait_map.select(0.9, 0.666666667).distance == 0
    assert 0 < gait_map.select(0.77, 0.66).distance < 0.71


@pytest.mark.parametrize("task", [(1e30, 0.6), (-1e300, 0.6), (0.9, 1e300), (0.9, 0.0), (0.9, -0.6), (25.0, 0.6)])
@pytest.mark.filterwarnings("error")
def test_what_is_not_physical_has_no_guess_either(gait_map: GaitMap, task: tuple[float, float]) -> None:
    choice = gait_map.select(*task, beyond=True)
    assert (choice.gait, choice.warm_start, choice.in_domain) == (None, None, False)
    assert choice.distance > 0
    with pytest.raises(OutOfDomain, match="is outside the map's"):
        gait_map.plan(*task, beyond=True)


def test_an_axis_that_the_map_lacks_is_named_with_those_it_has(gait_map: GaitMap) -> None:
    for ask in (gait_map.select, gait_map.plan, gait_map.select_many):
        with pytest.raises(ValueError, match=r"'height' is unknown here; the axes are speed, cycle_duration"):
            ask(speed=0.9, cycle_duration=0.6, height=1.0)
        with pytest.raises(ValueError, match=r"slope = 5: it is fixed at 0 deg here; the axes are speed, cycle_dur"):
            ask(0.9, 0.6, slope=5.0)
    for ask in (gait_map.select, gait_map.plan):
        with pytest.raises(
            ValueError, match=r"needs speed, cycle_duration as well; the axes are speed, cycle_duration"
        ):
            ask()
    with pytest.raises(ValueError, match=r"needs cycle_duration as well; the axes are speed, cycle_duration"):
        gait_map.select_many(0.9)


def test_an_axis_that_the_map_holds_may_be_given(gait_map: GaitMap) -> None:
    assert gait_map.select(0.9, 0.6, slope=0.0, friction=0.8) == gait_map.select(0.9, 0.6)
    many = gait_map.select_many([0.9, 1.0], 0.6, friction=[[0.8], [0.8], [0.8]])
    assert many.gaits.shape == (3, 2)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, "0.9", True, 1j, [0.9], np.nan, 10**400])
def test_what_is_no_finite_number_is_named(gait_map: GaitMap, bad: object) -> None:
    for ask in (gait_map.select, gait_map.plan):
        with pytest.raises(ValueError, match=r"^speed = .*finite number"):
            ask(bad, 0.6)
        with pytest.raises(ValueError, match=r"^cycle_duration = .*finite number"):
            ask(0.9, cycle_duration=bad)


@pytest.mark.parametrize("number", [1, np.float32(1), np.int64(1), Fraction(1)])
def test_any_real_number_is_taken(gait_map: GaitMap, number: object) -> None:
    assert gait_map.select(number, number) == gait_map.select(1.0, 1.0)


def test_warm_start_is_much_nearer_the_optimum_than_the_mean(gait_map: GaitMap, tiny: TinyMap) -> None:
    for speed, cycle in ((0.55, 0.63), (1.13, 0.85), (1.63, 0.52)):
        start, plan = gait_map.select(speed, cycle).warm_start, gait_map.plan(speed, cycle)
        assert (start.gait, start.pattern) == (plan.gait, plan.pattern)
        expected = tiny.problem.layout.unpack(start.primal, cycle)
        np.testing.assert_allclose(start.base, expected.base)
        np.testing.assert_allclose(start.forces, expected.forces)
        mean = gait_map.mean_start(plan.gait, cycle)
        away, off = (np.abs(each.base - plan.base)[:, :3].max() for each in (start, mean))
        assert away < 0.5 * off, "position and pitch"
        assert np.abs(start.durations - plan.durations).max() < 0.05 * cycle
        assert start.multipliers_bounds.shape == start.primal.shape
        assert start.multipliers_rows.shape == (tiny.problem.ng,)


def test_warm_start_of_a_gait_without_nodes_there_is_its_regions_mean(tiny: TinyMap, tmp_path: Path) -> None:
    half = GaitMap.load(write_map(replace(tiny, atlas=tiny.atlas.of([0])), tmp_path))
    known, unknown = half.select(0.3, 0.6), half.select(2.1, 0.8)
    assert not np.array_equal(known.warm_start.primal, half.mean_start("walking", 0.6).primal)
    np.testing.assert_array_equal(unknown.warm_start.primal, half.mean_start("gallop", 0.8).primal)


def test_mean_start_of_a_gait_that_there_is_not(gait_map: GaitMap) -> None:
    with pytest.raises(ValueError, match="gait = 'trot': the map has walking, gallop"):
        gait_map.mean_start("trot", 0.6)


def test_mean_start_is_the_region_unpacked_for_the_cycle(gait_map: GaitMap, tiny: TinyMap) -> None:
    start = gait_map.mean_start("gallop", 0.8)
    region, layout = tiny.starts[1], tiny.problem.layout
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
    with pytest.raises(ValueError, match=r"speed\[1\] = nan: must be a finite number"):
        gait_map.select_many([0.9, np.nan], 0.6)
    with pytest.raises(ValueError, match=r"cycle_duration\[0, 1\] = inf"):
        gait_map.select_many(0.9, [[0.6, np.inf]])
    with pytest.raises(ValueError, match="speed: must hold finite numbers"):
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


@pytest.fixture(scope="module")
def one_axis(tiny: TinyMap, tmp_path_factory: pytest.TempPathFactory) -> GaitMap:
    """A map over slopes at one speed and cycle duration, without an atlas."""
    scenario = scenario_of(speed=0.5, cycle_duration=0.666666667, slope=Range(start=-10.0, stop=10.0, count=3))
    problem = transcribe(scenario)
    domain = Domain({"slope": (-10.0, 0.0, 10.0)}, np.array([True, True, True]))
    made = replace(
        tiny,
        problem=problem,
        domain=domain,
        classifier=linear_classifier([-1.0, 1.0], [0.0, 0.0], axes=1),
        atlas=Atlas.empty(("slope",)),
    )
    return GaitMap.load(write_map(made, tmp_path_factory.mktemp("one") / "slope"))


def test_a_map_with_one_axis_works_as_well(one_axis: GaitMap) -> None:
    assert one_axis.axes == ("slope",)
    choice = one_axis.select(slope=-5.0)
    assert choice == one_axis.select(0.5, 0.666666667, slope=-5.0)
    assert (choice.gait, choice.in_domain) == ("walking", True)
    assert dict(choice.task) == {"speed": 0.5, "cycle_duration": 0.666666667, "slope": -5.0}
    assert choice.warm_start.times[-1] == pytest.approx(0.666666667)
    assert one_axis.select_many(slope=[-20.0, -5.0, 5.0]).gaits.tolist() == [None, "walking", "gallop"]
    with pytest.raises(ValueError, match=r"needs slope as well; the axes are slope"):
        one_axis.select(0.5, 0.666666667)
    with pytest.raises(ValueError, match=r"speed = 0.6: it is fixed at 0.5 m/s here"):
        one_axis.select(0.6, 0.666666667, slope=1.0)
    with pytest.raises(OutOfDomain, match=r"slope = 11 deg is outside the map's -10 deg to 10 deg"):
        one_axis.plan(slope=11.0)
    plan = one_axis.plan(slope=4.0)
    assert plan.feasible and dict(plan.task) == {"speed": 0.5, "cycle_duration": 0.666666667, "slope": 4.0}
    assert plan.base[-1, 0] - plan.base[0, 0] == pytest.approx(0.5 * 0.666666667)
