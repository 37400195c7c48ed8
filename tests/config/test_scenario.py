"""What a scenario file may say, what is said of one that may not, and what its digest depends on."""

from __future__ import annotations

import copy
import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import ValidationError

from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Scenario, digest_of, load_scenario

CONFIGS = Path(__file__).parents[2] / "configs"
QUICKSTART = CONFIGS / "scenarios" / "quickstart.yaml"
PAPER = ("half-cheetah-flat-effort", "half-cheetah-flat-vibration", "half-cheetah-slope20-vibration")
Edit = Callable[[dict[str, Any]], None]


@pytest.fixture
def configs(tmp_path: Path) -> Path:
    """A copy of configs/ to break."""
    return shutil.copytree(CONFIGS, tmp_path / "configs")


@pytest.fixture
def scenario_file(configs: Path) -> Path:
    return configs / "scenarios" / "quickstart.yaml"


def edited(path: Path, field: str, value: Any) -> Path:
    """The file with the field (dotted) set to the value, in place."""
    data = place = yaml.safe_load(path.read_text(encoding="utf-8"))
    *parents, last = field.split(".")
    for parent in parents:
        place = place.setdefault(parent, {})
    place[last] = value
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    return path


def refusal(path: Path, blamed: Path | None = None) -> str:
    """What load_scenario says, without the path of the blamed file, with which it must begin."""
    with pytest.raises(ConfigError) as caught:
        load_scenario(path)
    prefix = f"{blamed or path}: "
    assert str(caught.value).startswith(prefix)
    return str(caught.value).removeprefix(prefix)


@pytest.mark.parametrize("path", sorted((CONFIGS / "scenarios").glob("*.yaml")), ids=lambda path: path.stem)
def test_the_scenarios_of_the_project_load(path: Path) -> None:
    scenario = load_scenario(path)
    assert scenario.name == path.stem
    assert Scenario.from_data(scenario.as_data(), "copy") == scenario, "its JSON is all that a worker needs"


def test_the_scenarios_of_the_paper() -> None:
    """Section IV.A: 4 phases of 10 knots and 10 % of the cycle, Euler, the grid of Fig. 4, J1 or J2."""
    effort, flat, slope = (load_scenario(CONFIGS / "scenarios" / f"{name}.yaml") for name in PAPER)
    for scenario in (effort, flat, slope):
        steps = scenario.transcription
        assert (steps.phases, steps.knots_per_phase, steps.integrator) == (4, 10, "euler")
        assert steps.min_phase_fraction == 0.1
        assert scenario.stances_per_leg == 1
        assert tuple(scenario.tasks.ranges) == ("speed", "cycle_duration")
        assert scenario.tasks.ranges["speed"].values == (0.1, 0.3, 0.5, 0.7, 0.9, 1.1, 1.3, 1.5, 1.7, 1.9, 2.1, 2.3)
        assert scenario.tasks.ranges["cycle_duration"].values == (0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6)
        assert scenario.robot == effort.robot
    vibration = {"tangential_velocity": 1e6, "normal_velocity": 1e6, "tilt": 1e6, "tilt_rate": 1e6}
    assert {k: v for k, v in effort.objective.as_data().items() if v} == {"force": 1.0}
    assert {k: v for k, v in flat.objective.as_data().items() if v} == vibration
    assert slope.objective == flat.objective
    assert [scenario.tasks.axes.get("slope") for scenario in (effort, flat, slope)] == [None, None, 20.0]


@pytest.mark.parametrize(("paper", "exact"), [
    ("half-cheetah-flat-effort", "half-cheetah-exact-effort"),
    ("half-cheetah-flat-vibration", "half-cheetah-exact-vibration"),
    ("half-cheetah-slope20-vibration", "half-cheetah-exact-slope20-vibration"),
    ("anymal-flat-vibration", "anymal-exact-vibration"),
    ("go1-flat-vibration", "go1-exact-vibration"),
])  # fmt: skip
def test_an_exact_scenario_differs_from_the_papers_by_its_step_and_sampling_only(paper: str, exact: str) -> None:
    before, after = (load_scenario(CONFIGS / "scenarios" / f"{name}.yaml").as_data() for name in (paper, exact))
    step = {"integrator": "momentum", "forces": "linear", "grading": after["transcription"]["grading"]}
    assert after["transcription"] == before["transcription"] | step and step["grading"] > 0
    for data in (before, after):
        for key in ("name", "description", "transcription"):
            del data[key]
        data["tasks"] = {key: value for key, value in data["tasks"].items() if key not in ("held_out", "sampling")}
    assert before == after


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("colour", "red", "colour = 'red': unknown field; allowed: name, description, robot, objective, transcription"),
        ("terrain.slope_deg", 5.0, "terrain = {'slope_deg': 5.0}: unknown field; allowed: name,"),
        ("objective.tild", 5.0, "objective.tild = 5.0: unknown field, did you mean tilt? allowed: force, tangential_"),
        ("name", "Quick Start", "name = 'Quick Start': String should match pattern '^[a-z0-9]+(-[a-z0-9]+)*$'"),
        ("name", "../../etc", "name = '../../etc': String should match pattern"),
        ("tasks.axes.slope", 60, "tasks.axes: slope = 60: must lie in -59 to 59 deg"),
        ("tasks.axes.friction", 0, "tasks.axes: friction = 0: must lie in 0.01 to 5"),
        ("tasks.axes.friction", float("nan"), "tasks.axes.friction = nan: Input should be a finite number"),
        ("tasks.axes.friction", "rough", "tasks.axes.friction = 'rough': Input should be a valid number; this is text"),
        ("tasks.axes.speed.stop", float("inf"), "tasks.axes.speed.stop = inf: Input should be a finite number"),
        ("tasks.axes.speed.start", -20.1, "tasks.axes: speed = -20.1: must lie in -20 to 20 m/s"),
        ("tasks.axes.speed.stop", 0.05, "tasks.axes.speed: stop = 0.05, start = 0.1, count = 6: stop must be above"),
        ("tasks.axes.speed.count", 2.5, "tasks.axes.speed.count = 2.5: Input should be a valid integer"),
        ("tasks.axes.speed.cuont", 2, "tasks.axes.speed.cuont = 2: unknown field, did you mean count? allowed: start,"),
        ("tasks.axes.cycle_duration.start", 0, "tasks.axes: cycle_duration = 0: must lie in 0.01 to 20 s"),
        ("tasks.axes", {"speed": 0.5}, "tasks.axes: cycle_duration: missing; give it a value [s] or a range {start,"),
        ("tasks.axes", {"cycle_duration": 0.5}, "tasks.axes: no axis has a range: a map needs one at least, written"),
        ("tasks.axes.sped", 1.0, "tasks.axes: 'sped': unknown axis; did you mean speed? The axes are speed, lateral_"),
        ("tasks.axes." + "x" * 10_000, 1.0, "tasks.axes: 'xxxxxxxxxxxx...xxxxxxxxxxxxx': unknown axis; The axes are"),
        ("tasks.axes.yaw_rate", 0.5, "tasks.axes.yaw_rate: needs a robot with dimension 3, half_cheetah has 2"),
        (
            "tasks.axes.lateral_speed",
            {"start": 0, "stop": 1, "count": 2},
            "tasks.axes.lateral_speed: needs a robot with dimension 3, half_cheetah has 2; leave it out",
        ),
        (
            "tasks.axes",
            {axis: {"start": 0.5, "stop": 1.0, "count": 10_000} for axis in ("speed", "cycle_duration")},
            "tasks.axes: the grid of all ranges has 100000000 tasks: at most 1000000 are allowed",
        ),
        ("tasks.speed", {}, "tasks.speed = {}: unknown field; allowed: axes, held_out, held_out_seed"),
        ("tasks.held_out", 10**6, "tasks.held_out = 1000000: Input should be less than or equal to 100000"),
        ("objective", {}, "objective: at least one weight must be positive"),
        ("objective.force", -1.0, "objective.force = -1.0: Input should be greater than or equal to 0"),
        ("objective.lateral_foot", 2.0, "objective.lateral_foot = 2: needs a robot with dimension 3, half_cheetah"),
        (
            "transcription.min_phase_fraction",
            0.3,
            "transcription: min_phase_fraction = 0.3: phases = 4 of at least this part of the cycle do not fit into "
            "it; allowed is at most 1/4",
        ),
        ("transcription.phases", 1, "transcription.phases = 1: Input should be greater than or equal to 2"),
        ("transcription.phases", 1000, "transcription.phases = 1000: Input should be less than or equal to 12"),
        ("transcription.integrator", "rk5", "transcription.integrator = 'rk5': Input should be 'euler', 'rk4', 'mid"),
        ("stances_per_leg", 2, "stances_per_leg = 2: Input should be 1 or null"),
        (
            "strategy.name",
            "genetic",
            "strategy.name = 'genetic': Input should be 'patterns', 'guided', 'bonmin' or 'fixed_gait'",
        ),
        ("strategy.restarts", 0, "strategy.restarts = 0: Input should be greater than or equal to 1"),
        ("strategy.restarts", True, "strategy.restarts = True: Input should be a valid integer"),
        (
            "strategy.pattern",
            "0110/1100",
            "strategy: name = 'patterns', pattern = '0110/1100': a pattern is needed by the strategy 'fixed_gait', and "
            "allowed for no other",
        ),
        ("strategy.name", "fixed_gait", "strategy: name = 'fixed_gait', pattern = null: a pattern is needed by"),
        ("learning.folds", 1, "learning.folds = 1: Input should be greater than or equal to 2"),
        ("learning.learning_rates", [], "learning.learning_rates = []: Tuple should have at least 1 item"),
        ("learning.learning_rates", [-0.1], "learning.learning_rates.0 = -0.1: Input should be greater than 0"),
        ("learning.hidden_layers", [[]], "learning.hidden_layers.0 = []: Tuple should have at least 1 item"),
        ("objective", 5, "objective = 5: Input should be an object"),
        ("tasks.axes", [], "tasks.axes = []: Input should be an object"),
        ("tasks", None, "tasks = None: Input should be an object"),
    ],
)
def test_a_wrong_value_is_refused(scenario_file: Path, field: str, value: Any, said: str) -> None:
    answer = refusal(edited(scenario_file, field, value))
    assert answer.startswith(said)
    assert len(answer.splitlines()[0]) < 400
    assert field.startswith("learning") or "\n" not in answer, "one line says it"


def test_an_axis_given_twice_is_refused(scenario_file: Path) -> None:
    text = scenario_file.read_text(encoding="utf-8")
    line = "    speed: {start: 0.1, stop: 2.1, count: 6}\n"
    assert line in text
    scenario_file.write_text(text.replace(line, line + "    speed: 0.9\n"), encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load_scenario(scenario_file)
    number = text.split(line)[0].count("\n") + 2
    assert str(caught.value) == f"{scenario_file}, line {number}, column 5: not valid YAML ('speed' is given twice)"


@pytest.mark.parametrize("slope", [-5.0, {"start": 0.0, "stop": 5.0, "count": 2}])
def test_turning_on_a_slope_is_refused(scenario_file: Path, slope: Any) -> None:
    edited(scenario_file, "robot", "anymal")
    edited(scenario_file, "tasks.axes.yaw_rate", 0.5)
    assert load_scenario(scenario_file).tasks.varies("yaw_rate")
    assert refusal(edited(scenario_file, "tasks.axes.slope", slope)) == (
        "tasks.axes: yaw_rate and slope: turning on a slope is not periodic, as gravity turns against the body; leave "
        "one of them out"
    )
    edited(scenario_file, "tasks.axes.slope", 0.0)
    assert not load_scenario(scenario_file).tasks.varies("slope"), "level ground is no slope"


@pytest.mark.parametrize("pattern", ["0110", "0110/110", "0110/1102", "0110/1100/0011", "gallop", "٠١١٠/١١٠٠", ""])
def test_an_unknown_gait_pattern_is_refused(scenario_file: Path, pattern: str) -> None:
    edited(scenario_file, "strategy", {"name": "fixed_gait", "pattern": pattern})
    assert refusal(scenario_file) == (
        f"strategy.pattern = {pattern!r}: write 2 rows (legs F, H) of 4 digits 0 (swing) or 1 (stance), joined by '/'"
    )


def test_methods_that_compete_are_part_of_a_scenario_unless_they_are_all(scenario_file: Path) -> None:
    learning = {"folds": 3, "methods": ["svm", "knn"]}
    assert load_scenario(edited(scenario_file, "learning", learning)).as_data()["learning"]["methods"] == ["svm", "knn"]
    every = load_scenario(edited(scenario_file, "learning", {"folds": 3}))
    assert every.learning.methods == ("mlp", "svm", "forest", "knn")
    assert "methods" not in every.as_data()["learning"], "as before there was a choice"
    assert "learning.methods" in refusal(edited(scenario_file, "learning", {"methods": []}))
    assert "learning.methods.0 = 'tree'" in refusal(edited(scenario_file, "learning", {"methods": ["tree"]}))


def test_a_fixed_gait_is_accepted(scenario_file: Path) -> None:
    edited(scenario_file, "strategy", {"name": "fixed_gait", "pattern": "0110/1100"})
    assert load_scenario(scenario_file).strategy.pattern == "0110/1100"


@pytest.mark.parametrize("robot", ["wheeled", "half_cheeta", "../robots", "", 7, None, ["half_cheetah"]])
def test_an_unknown_robot_lists_the_known_ones(scenario_file: Path, robot: Any) -> None:
    known = ", ".join(sorted(path.stem for path in (CONFIGS / "robots").glob("*.yaml")))
    said = refusal(edited(scenario_file, "robot", robot))
    near = ", did you mean half_cheetah?" if "half_cheeta" in str(robot) else ";"
    assert said == f"robot = {robot!r}: unknown robot{near} allowed: {known}"


def test_no_robot(scenario_file: Path) -> None:
    data = yaml.safe_load(scenario_file.read_text(encoding="utf-8"))
    del data["robot"]
    scenario_file.write_text(yaml.safe_dump(data), encoding="utf-8")
    assert refusal(scenario_file) == "robot: missing; this field has no default"


def test_an_error_inside_the_robot_names_the_robots_file(configs: Path, scenario_file: Path) -> None:
    robot = edited(configs / "robots" / "half_cheetah.yaml", "mass", -14.0)
    assert refusal(scenario_file, blamed=robot.resolve()) == "mass = -14.0: Input should be greater than 0"


def test_a_robot_is_found_in_the_given_folder_then_beside_the_scenario_then_where_robots_ship(
    configs: Path, scenario_file: Path, tmp_path: Path
) -> None:
    own, alone = tmp_path / "own", tmp_path / "elsewhere" / "scenarios" / "quickstart.yaml"
    shutil.copytree(configs / "robots", own)
    edited(own / "half_cheetah.yaml", "mass", 20.0)
    edited(configs / "robots" / "half_cheetah.yaml", "mass", 17.0)
    alone.parent.mkdir(parents=True)
    shutil.copy(scenario_file, alone)
    assert load_scenario(scenario_file, robots=own).robot.mass == 20.0
    assert load_scenario(scenario_file, robots=tmp_path / "empty").robot.mass == 17.0
    assert load_scenario(alone, robots=tmp_path / "empty") == load_scenario(QUICKSTART)


def test_a_robot_by_path_lies_relative_to_its_scenario(configs: Path, scenario_file: Path) -> None:
    shutil.copy(configs / "robots" / "half_cheetah.yaml", scenario_file.parent / "mine.yaml")
    edited(scenario_file.parent / "mine.yaml", "mass", 17.0)
    assert load_scenario(edited(scenario_file, "robot", "mine.yaml")).robot.mass == 17.0
    missing = refusal(edited(scenario_file, "robot", "other.yaml"), blamed=scenario_file.parent / "other.yaml")
    assert missing == "cannot be read (No such file or directory)"


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "expected a mapping of fields (`field: value` lines), found nothing: the file is empty"),
        ("# only a comment\n", "found nothing: the file is empty"),
        ("- name: quickstart\n", "found a list, [{'name': 'quickstart'}]"),
        ("quickstart\n", "found a str, 'quickstart'"),
        ("#" * 100_001, "more than 100000 bytes, the most a configuration may have"),
        ("name: quickstart", "robot: missing; this field has no default"),
    ],
)
def test_a_file_that_is_no_scenario(scenario_file: Path, content: str, said: str) -> None:
    scenario_file.write_text(content, encoding="utf-8")
    assert said in refusal(scenario_file)


def test_a_file_that_is_no_yaml_names_the_line(scenario_file: Path) -> None:
    scenario_file.write_text("name: quickstart\ndescription: Fig. 4a: effort\n", encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load_scenario(scenario_file)
    assert str(caught.value).startswith(f"{scenario_file}, line 2, column 21: not valid YAML")


def test_a_scenario_is_frozen() -> None:
    scenario = load_scenario(QUICKSTART)
    with pytest.raises(ValidationError, match="frozen"):
        scenario.name = "other"  # type: ignore[misc]
    with pytest.raises(ValidationError, match="frozen"):
        scenario.tasks.ranges["speed"].count = 1  # type: ignore[misc]
    with pytest.raises(TypeError, match="frozen"):
        scenario.tasks.axes["speed"] = 1.0
    with pytest.raises(TypeError, match="frozen"):
        scenario.tasks.axes.update(speed=1.0)
    assert pickle.loads(pickle.dumps(scenario)) == copy.deepcopy(scenario) == scenario
    assert hash(scenario) == hash(load_scenario(QUICKSTART))


def reverse_fields(data: Any) -> Any:
    """The same data with every mapping written backwards."""
    if isinstance(data, dict):
        return {key: reverse_fields(value) for key, value in reversed(data.items())}
    return [reverse_fields(item) for item in data] if isinstance(data, list) else data


def test_the_digest_does_not_depend_on_how_the_file_is_written(scenario_file: Path) -> None:
    original = load_scenario(QUICKSTART)
    data = reverse_fields(yaml.safe_load(scenario_file.read_text(encoding="utf-8")))
    data["objective"] = {"force": 1}  # an integer for a float
    data["strategy"].pop("seed")  # left to its default, 0
    scenario_file.write_text("# a comment\n" + yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    rewritten = load_scenario(scenario_file)
    assert digest_of(rewritten.as_data()) == digest_of(original.as_data())
    assert rewritten.problem_digest == original.problem_digest


def test_a_digest_is_the_same_on_every_machine() -> None:
    """Fixed text in, fixed SHA-256 out: units of work are found again by it."""
    assert digest_of({"b": [1.0, 0.1], "a": None}) == "8bbc709ff14c82e01f927de7fbea0c0bb582bdbda0c46b1274adbad565a83caf"
    with pytest.raises(ValueError, match="Out of range float"):
        digest_of({"a": float("nan")})


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("name", "other"),
        ("description", "other"),
        ("tasks.axes.speed.count", 3),
        ("tasks.axes.friction", 0.7),
        ("tasks.held_out", 0),
        ("strategy.restarts", 9),
        ("learning.folds", 4),
        ("learning.max_epochs", 1),
    ],
)
def test_the_problem_digest_ignores_what_a_solve_does_not_see(scenario_file: Path, field: str, value: Any) -> None:
    before = load_scenario(scenario_file)
    after = load_scenario(edited(scenario_file, field, value))
    assert after.problem_digest == before.problem_digest
    assert digest_of(after.as_data()) != digest_of(before.as_data())


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("tasks.axes.slope", 1),
        ("tasks.axes.acceleration", {"start": 0.0, "stop": 1.0, "count": 2}),
        ("objective.tilt", 1.0),
        ("transcription.phases", 3),
        ("transcription.integrator", "rk4"),
        ("transcription.forces", "held"),
        ("transcription.grading", 0.25),
        ("stances_per_leg", None),
    ],
)
def test_the_problem_digest_follows_what_a_solve_sees(scenario_file: Path, field: str, value: Any) -> None:
    before = load_scenario(scenario_file).problem_digest
    assert load_scenario(edited(scenario_file, field, value)).problem_digest != before


def test_the_problem_digest_follows_the_robot(configs: Path, scenario_file: Path) -> None:
    before = load_scenario(scenario_file).problem_digest
    edited(configs / "robots" / "half_cheetah.yaml", "mass", 15.0)
    assert load_scenario(scenario_file).problem_digest != before
