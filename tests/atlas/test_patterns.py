"""Few patterns that are the best of their gait wherever it matters."""

from __future__ import annotations

import pandas as pd
from tiny_map import scenario_of

from gaitflow.atlas.patterns import full_patterns, map_symmetry
from gaitflow.config.scenario import Range, Transcription
from gaitflow.core.gaits import NO_SYMMETRY, Pattern, Symmetry, gait_of

# One gait of three phases, one of which lasts two.
FIRST, SECOND, THIRD = "0010/1110", "0110/1110", "0100/1100"
OTHER = "0001/0100"


def key(pattern: str) -> str:
    return gait_of(Pattern.from_text(pattern)).text


def frames(costs: dict[float, dict[str, float]], split: str = "grid") -> tuple[pd.DataFrame, pd.DataFrame]:
    """Solutions by speed and pattern, and the gaits' costs."""
    rows = [
        {"speed": v, "cycle_duration": 0.8, "split": split, "pattern": pattern, "status": "solved", "violation": 0.0}
        | {"cost": cost, "gait": key(pattern)}
        for v, row in costs.items()
        for pattern, cost in row.items()
    ]
    solutions = pd.DataFrame(rows)
    task = ["speed", "cycle_duration", "split"]
    least = solutions.groupby([*task, "gait"])["cost"].min().reset_index().rename(columns={"gait": "gait_key"})
    best = least.groupby(task)["cost"].transform("min")
    return solutions, least.assign(gait=least["gait_key"], excess=least["cost"] / best - 1)


def chosen(costs: dict[float, dict[str, float]], *gaits: str, split: str = "grid") -> set[str]:
    return set(full_patterns(*frames(costs, split), gaits or (key(FIRST),), 1e-3, NO_SYMMETRY))


def test_the_patterns_of_these_tests_are_one_gait() -> None:
    assert key(FIRST) == key(SECOND) == key(THIRD) != key(OTHER)


def test_one_pattern_that_is_nearly_the_best_everywhere_is_enough() -> None:
    assert chosen({0.1: {FIRST: 1.0, SECOND: 1.1}, 0.3: {FIRST: 1.0005, SECOND: 1.0}}) == {FIRST}


def test_every_pattern_that_some_task_needs_is_taken_and_no_other() -> None:
    costs = {0.1: {FIRST: 1.0, SECOND: 1.1, THIRD: 1.2}, 0.3: {FIRST: 1.1, SECOND: 1.0, THIRD: 1.2}}
    assert chosen(costs) == {FIRST, SECOND}


def test_only_where_a_gait_is_nearly_the_best_it_matters() -> None:
    far = {0.1: {FIRST: 1.0, SECOND: 1.1}, 0.3: {FIRST: 1.1, SECOND: 1.0, OTHER: 0.5}}
    assert chosen(far) == {FIRST}


def test_gaits_that_are_not_asked_for_have_no_pattern() -> None:
    costs = {0.1: {FIRST: 1.0, OTHER: 1.0}}
    assert chosen(costs) == {FIRST}
    assert chosen(costs, key(OTHER)) == {OTHER}
    assert full_patterns(*frames(costs), [key(OTHER), key(FIRST)], 1e-3, NO_SYMMETRY) == {
        FIRST: key(FIRST),
        OTHER: key(OTHER),
    }


def test_held_out_tasks_tell_nothing() -> None:
    assert chosen({0.1: {FIRST: 1.0}}, split="held_out") == set()


def test_what_failed_the_check_is_no_solution() -> None:
    solutions, costs = frames({0.1: {FIRST: 1.0, SECOND: 0.9}})
    solutions.loc[solutions["pattern"] == SECOND, "violation"] = 1e-3
    assert set(full_patterns(solutions, costs, [key(FIRST)], 1e-3, NO_SYMMETRY)) == {FIRST}


def test_a_pattern_that_is_another_gait_elsewhere_in_the_map_is_left_out() -> None:
    """At a task that time reversal leaves as it is, a pattern stands for its own reversal, too."""
    twins = "0011/0010", "0001/0011"
    assert key(twins[0]) != key(twins[1]), "by themselves they are two gaits"
    both = Symmetry(reversal=(1, 0))
    assert gait_of(Pattern.from_text(twins[0]), both) == gait_of(Pattern.from_text(twins[1]), both)
    solutions, costs = frames({0.1: {twins[0]: 1.0, twins[1]: 1.0}})
    merged = gait_of(Pattern.from_text(twins[0]), both).text
    solutions["gait"], costs["gait"], costs["gait_key"] = merged, "limping", merged
    own = next(twin for twin in twins if key(twin) == merged)
    assert full_patterns(solutions, costs.iloc[:1], ["limping"], 1e-3, NO_SYMMETRY) == {own: "limping"}


def test_a_symmetry_of_a_map_is_one_of_all_its_tasks() -> None:
    exact = Transcription(integrator="momentum", forces="linear")
    level = scenario_of().model_copy(update={"transcription": exact})
    assert map_symmetry(level).reversal is not None
    slopes = scenario_of(slope=Range(start=-10.0, stop=10.0, count=3)).model_copy(update={"transcription": exact})
    assert slopes.symmetry(slopes.tasks.space.task({"speed": 1.0, "cycle_duration": 0.6, "slope": 0.0})).reversal
    assert map_symmetry(slopes) == NO_SYMMETRY
