"""`gaitflow plan`: a motion for one task from a published map."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gaitflow.cli.errors import bad_input, fail, print_json, refused_artifact
from gaitflow.cli.options import json_option, map_argument, task_options
from gaitflow.core.task import AXES

if TYPE_CHECKING:
    from gaitflow.runtime import ChosenValue, Plan
    from gaitflow.runtime.left_out import Per

PLAN_KEYS = (
    "gait", "pattern", "probability", "in_domain", "distance", "durations", "cost", "cost_of_transport", "feasible",
    "violation", "path", "iterations", "select_ms", "predict_ms", "refine_ms", "time_ms",
)  # fmt: skip


@click.command()
@map_argument
@task_options
@click.option("--gait", help="Plan this gait of the map instead of the cheapest.")
@click.option(
    "--per",
    type=click.Choice(["second", "metre"]),
    default="second",
    show_default=True,
    help="Choose an axis that is left out by cost per second or per metre.",
)
@click.option("--beyond", is_flag=True, help="Plan also outside the map's domain; the motion is checked all the same.")
@click.option("--trust-code", is_flag=True, help="Run the code that maps of formats 1 and 2 hold as their problem.")
@json_option
def plan(
    artifact: Path,
    axes: dict[str, Any],
    gait: str | None,
    per: Per,
    beyond: bool,
    trust_code: bool,
    as_json: bool,
) -> None:
    """Choose a gait from MAP and plan its motion.

    MAP is the folder of a version, or its parent; then the newest version is taken. A task needs a value on every axis
    of the map, on most maps speed and cycle duration. You may leave out one axis of the command; the map then takes the
    value that costs least.

    \b
    Example: gaitflow plan models/quickstart --speed 0.9 --cycle 0.6 --json
             gaitflow plan models/half-cheetah-exact-slopes --speed 0.9 --cycle 0.6 --slope -8
             gaitflow plan models/anymal-exact-vibration --speed 0.6 --gait trot
             gaitflow plan models/anymal-energy --cycle 0.6 --per metre
    """
    from gaitflow.runtime import GaitMap, OutOfDomain

    with bad_input(), refused_artifact("--trust-code"):
        try:
            answer = GaitMap.load(artifact, trust_code=trust_code).plan(gait=gait, per=per, beyond=beyond, **axes)
        except OutOfDomain as error:
            if as_json:
                print_json(refused_data(axes))
            fail(f"{error}{'' if beyond else '; --beyond plans all the same'}")
    if as_json:
        print_json(plan_data(answer))
    else:
        _say(answer)
    if not answer.feasible:
        sys.exit(1)


def plan_data(answer: Plan) -> dict[str, Any]:
    """A plan as plain data: its task, PLAN_KEYS, and `chosen`, what a value left to the map costs, if one was.

    The trajectory is left out, numbers that do not exist are None.
    """
    data = {key: getattr(answer, key) for key in PLAN_KEYS} | {"durations": answer.durations.tolist()}
    chosen = None if answer.chosen is None else _finite(vars(answer.chosen))
    return {"task": dict(answer.task), **_finite(data), "chosen": chosen}


def _finite(data: Mapping[str, Any]) -> dict[str, Any]:
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in data.items()}


def refused_data(axes: dict[str, float]) -> dict[str, Any]:
    """What stands in the place of a plan for a task outside the map's domain."""
    unknown = dict.fromkeys((*PLAN_KEYS, "chosen"))
    return {"task": axes} | unknown | {"in_domain": False, "feasible": False, "path": "refused"}


def _say(answer: Plan) -> None:
    if not answer.in_domain:
        click.echo(f"outside the map's domain, {answer.distance:.1f} steps of its grid from the nearest task")
    click.echo(f"task:        {', '.join(f'{axis} {x:g} {AXES[axis].unit}' for axis, x in answer.task.items())}")
    if answer.chosen is not None:
        _say_chosen(answer.chosen)
    click.echo(f"gait:        {answer.gait} ({answer.pattern}), probability {answer.probability:.2f}")
    click.echo(f"durations:   {', '.join(f'{d:.4f}' for d in answer.durations)} s")
    transport = answer.cost_of_transport
    beside = "" if transport is None else f" J a cycle, cost of transport {transport:.3f}"
    click.echo(f"cost:        {answer.cost:.6g}{beside}")
    click.echo(f"feasible:    {'yes' if answer.feasible else 'no'}, worst violation {answer.violation:.1e}")
    click.echo(f"path:        {answer.path}, {answer.iterations} iterations, {answer.time_ms:.1f} ms")


def _say_chosen(chosen: ChosenValue) -> None:
    edge = ", at the edge of the map's domain" if chosen.on_edge else ""
    rates = f"{chosen.cost_per_second:.6g} a second, {chosen.cost_per_metre:.6g} a metre"
    click.echo(f"chosen:      {AXES[chosen.axis].written(chosen.value)} {chosen.axis}, predicted cost {rates}{edge}")
