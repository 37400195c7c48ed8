"""The C++ planner of an exported map beside `GaitMap.plan`: the same plans, and how long each takes."""

from __future__ import annotations

import json
import resource
import subprocess
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.document import document
from benchmarks.online.plan_times import warm_up
from benchmarks.paper.table import off_grid_places
from gaitflow.core.trajectory import Array
from gaitflow.runtime import GaitMap, Plan

TASKS, NUDGED = 1000, 100
SAME_COST, SAME_MOTION = 1e-6, 1e-6
EXAMPLES = Path(__file__).parents[2] / "examples" / "cpp"
NOTES = (
    "Tasks are random by `seed`, uniform in the map's domain, off its grid. A row a task: GaitMap.plan in this "
    "process, examples/cpp's plan in another, both of one thread; ms and cpp_ms are CPU time of a call. build_s is CPU "
    "time of compiling the map's C and the example, with -march=native.",
    f"same_plan: gait, pattern and path are Python's and the cost is to {SAME_COST:g} relative. by_ipopt: plans that "
    "Python had from IPOPT, which C++ has not; they are in no other number, and in C++ `not_refined` of them are.",
    "apart: the largest difference of the decision vectors (metres, rad, m/s, weights, cycles). nudged: that of "
    "Python's plan to Python's plan where the last bit of the first axis is another, of the first "
    f"{NUDGED} tasks: how far rounding alone moves a motion where the cost is flat. same_motion: share of `apart` "
    f"within {SAME_MOTION:g}.",
    "speedup: Python's CPU time over that of C++ on the same task.",
)


def run(artifact: Path, tasks: int = TASKS, seed: int = 0) -> dict[str, Any]:
    """The document. Raises ValueError where the domain has no tasks off its grid, RuntimeError where nothing builds."""
    gait_map = GaitMap.load(artifact)
    places = off_grid_places(gait_map.manifest.domain, tasks, seed)
    with tempfile.TemporaryDirectory() as scratch:
        program, build_s = built(artifact, Path(scratch))
        lines = "".join(line_of(place, gait_map.axes) for place in places)
        done = run_program([str(program), str(program.parents[1] / "map" / "map.bin")], lines)
    warm_up(gait_map)
    rows = [
        _row(gait_map, place, json.loads(answer), nudged=number < NUDGED)
        for number, (place, answer) in enumerate(zip(places, done.splitlines(), strict=True))
    ]
    return document("cpp", gait_map.manifest.name, rows, _summary(rows, build_s), NOTES)


def built(artifact: Path, scratch: Path) -> tuple[Path, float]:
    """The planner's program, of a map in `map` beside its folder, and the CPU time [s] of its build."""
    from gaitflow.export import export_c

    export, build = scratch / "map", scratch / "build"
    export_c(artifact, export)
    before = _children_s()
    for_this_processor = [f"-DCMAKE_{language}_FLAGS=-march=native" for language in ("C", "CXX")]
    run_program(["cmake", "-S", str(EXAMPLES), "-B", str(build), f"-Dgaitflow_map_DIR={export}", *for_this_processor])
    run_program(["cmake", "--build", str(build), "--target", "plan"])
    return build / "plan", _children_s() - before


def built_library(export: Path, build: Path) -> Path:
    """The folder where an export was built as a library that Python calls."""
    run_program(["cmake", "-S", str(export), "-B", str(build)])
    run_program(["cmake", "--build", str(build)])
    return build


def line_of(place: Mapping[str, float], axes: Sequence[str]) -> str:
    """A task as the programs of examples/cpp read it."""
    return " ".join(repr(place[axis]) for axis in axes) + "\n"


def run_program(command: Sequence[str], text: str = "") -> str:
    """What a program says to a text. Raises RuntimeError with its last words where it fails."""
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}: {(done.stdout + done.stderr)[-1000:]}")
    return done.stdout


class AskedInTurn:
    """A program of examples/cpp in a process of its own, asked line by line; it ends with this process."""

    def __init__(self, command: Sequence[str]) -> None:
        self._command = " ".join(command)
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)

    def __call__(self, line: str) -> dict[str, Any]:
        """Its answer. Raises RuntimeError where it gives none."""
        asked, told = self._process.stdin, self._process.stdout
        assert asked is not None and told is not None
        with suppress(BrokenPipeError):
            asked.write(line)
        answer = told.readline()
        if not answer:
            raise RuntimeError(f"{self._command}: ended with code {self._process.wait()} at {line!r}")
        found: dict[str, Any] = json.loads(answer)
        return found


def _children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _row(gait_map: GaitMap, place: Mapping[str, Any], answer: Mapping[str, Any], nudged: bool) -> dict[str, Any]:
    cpu = time.process_time()
    plan = gait_map.plan(**place)
    cpu = time.process_time() - cpu
    row = {
        **place,
        "gait": plan.gait,
        "path": plan.path,
        "by_ipopt": any("fallback" in outcome for _, outcome in plan.tried),
        "cpp_gait": answer["gait"],
        "cpp_path": answer["path"],
        "refined": answer["refined"],
        "same_pattern": answer["pattern"] == plan.pattern,
        "cost_error": abs(answer["cost"] / plan.cost - 1),
        "apart": _apart(_vector(gait_map, plan), _moving(gait_map, np.array(answer["primal"]))),
        "ms": cpu * 1e3,
        "cpp_ms": answer["cpu_us"] / 1e3,
    }
    if nudged:
        axis = gait_map.axes[0]
        beside: dict[str, Any] = {**place, axis: float(np.nextafter(place[axis], np.inf))}
        other = gait_map.plan(**beside)
        row["nudged"] = _apart(_vector(gait_map, plan), _vector(gait_map, other))
    return row


def _vector(gait_map: GaitMap, plan: Plan) -> Array:
    return _moving(gait_map, gait_map.manifest.layout.pack(plan, plan.task["cycle_duration"]))


def _moving(gait_map: GaitMap, vector: Array) -> Array:
    """The motion in a decision vector: without the contacts behind it, which the pattern fixes."""
    return vector[: gait_map.manifest.layout.fractions.stop]


def _apart(one: Array, other: Array) -> float:
    return float(np.abs(one - other).max())


def _summary(rows: Sequence[Mapping[str, Any]], build_s: float) -> dict[str, Any]:
    both = [row for row in rows if not row["by_ipopt"]]
    same = [
        row["gait"] == row["cpp_gait"]
        and row["path"] == row["cpp_path"]
        and row["same_pattern"]
        and row["cost_error"] <= SAME_COST
        for row in both
    ]
    apart = np.array([row["apart"] for row in both])
    nudged = np.array([row["nudged"] for row in both if "nudged" in row])
    python, cpp = (np.array([row[name] for row in both]) for name in ("ms", "cpp_ms"))
    return {
        "tasks": len(rows),
        "by_ipopt": len(rows) - len(both),
        "not_refined": sum(row["by_ipopt"] and not row["refined"] for row in rows),
        "same_plan": sum(same),
        "cost_error_max": max((row["cost_error"] for row, is_same in zip(both, same, strict=True) if is_same)),
        "same_motion": float((apart <= SAME_MOTION).mean()),
        **{f"apart_p{share}": float(np.percentile(apart, share)) for share in (50, 90, 99)},
        **{f"nudged_p{share}": float(np.percentile(nudged, share)) for share in (50, 90, 99)},
        **{f"plan_cpu_ms_p{share}": float(np.percentile(python, share)) for share in (50, 99)},
        **{f"cpp_cpu_ms_p{share}": float(np.percentile(cpp, share)) for share in (50, 99)},
        "speedup_median": float(np.median(python / cpp)),
        "build_s": build_s,
    }
