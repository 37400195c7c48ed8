"""The C++ reader and the C functions give what Python gives; needs cmake, cc and g++."""

from __future__ import annotations

import itertools
import json
import struct
import subprocess
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi
import numpy as np
import pytest
from cpp_program import SANITIZED, built, lines, run

from gaitflow.export import Exported
from gaitflow.export.functions import c_files
from gaitflow.export.map_file import MAGIC
from gaitflow.runtime import GaitMap
from gaitflow.runtime.artifact import Artifact, load_artifact
from gaitflow.runtime.problem import load_problem
from gaitflow.solvers.program import Program, derivatives

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Exported], Path]:
    """The example built with an export, once for each of the problems."""
    done: dict[bytes, Path] = {}

    def program(export: Exported) -> Path:
        problem = (export.folder / "problem.c").read_bytes()
        if problem not in done:
            done[problem] = built(export.folder, tmp_path_factory.mktemp("build"), "ask")
        return done[problem]

    return program


@pytest.fixture(scope="module")
def guarded(exported: Exported, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example with the address and undefined-behaviour sanitizers in its C++ part."""
    return built(exported.folder, tmp_path_factory.mktemp("guarded"), "ask", f"{SANITIZED}address,undefined")


def tasks_of(model: Path) -> list[tuple[float, ...]]:
    """1,000 random tasks, a third of them outside the domain, and those where comparisons are closest."""
    artifact = load_artifact(model)
    random, grid = np.random.default_rng(0), [np.array(values) for values in artifact.manifest.domain.axes.values()]
    wide = [(values[0] - 0.1 * np.ptp(values), values[-1] + 0.1 * np.ptp(values)) for values in grid]
    scattered = random.uniform(*np.transpose(wide), (1000, len(grid)))
    nodes = np.concatenate([sheet.tasks for sheet in artifact.atlas.sheets])
    chosen = nodes[random.permutation(len(nodes))[:150]]
    middles = (chosen[1:] + chosen[:-1]) / 2
    corners = np.array(list(itertools.product(*grid)))
    edges = [corners + shift * (-1.0) ** np.arange(len(grid)) for shift in (0, 5e-10, 2e-9, -2e-9)]
    return [tuple(task) for task in np.concatenate([scattered, chosen, middles, *edges]).tolist()]


@pytest.mark.parametrize("which", ["exported", "crowded_export", "sloped_export"])
def test_the_example_answers_as_python_does(
    programs: Callable[[Exported], Path], which: str, request: pytest.FixtureRequest
) -> None:
    export: Exported = request.getfixturevalue(which)
    gait_map, artifact = GaitMap.load(export.model), load_artifact(export.model)
    problem = load_problem(export.model, artifact.manifest, artifact.tensors.rows)
    program = Program(problem, derivatives(problem))
    tasks = tasks_of(export.model)
    answers = run(programs(export), export.folder / "map.bin", lines(tasks))
    assert answers.returncode == 0, answers.stderr
    found = [json.loads(line) for line in answers.stdout.splitlines()]
    predicted = 0
    for task, answer in zip(tasks, found, strict=True):
        values = dict(zip(gait_map.axes, task, strict=True))
        choice = gait_map.select(**values)
        assert {axis: answer[axis] for axis in values} == values and answer["in_domain"] == choice.in_domain
        if choice.gait is None:
            assert "gait" not in answer
            continue
        assert answer["gait"] == choice.gait, (task, choice.ranked)
        probabilities = [dict(choice.ranked)[gait.name] for gait in gait_map.gaits]
        np.testing.assert_allclose(answer["probabilities"], probabilities, atol=1e-5)
        assert answer["probability"] == pytest.approx(choice.probability, abs=1e-5)
        predicted += check_start(answer, artifact, choice.warm_start, problem, program)
    inside = sum(answer["in_domain"] for answer in found[:1000])
    assert 250 < inside < 900, "the random tasks are inside and outside"
    assert predicted > 250, "most warm starts come from the atlas"
    assert len({answer.get("gait") for answer in found}) == 3


def check_start(answer: dict[str, Any], artifact: Artifact, start: Any, problem: Any, program: Program) -> bool:
    assert answer["pattern"] == start.pattern
    for name in ("primal", "multipliers_bounds", "multipliers_rows"):
        expected = getattr(start, name)
        np.testing.assert_allclose(answer[name], expected, rtol=1e-9, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(answer["times"], start.times, rtol=1e-9, atol=1e-12)
    for name in ("feet", "end_forces"):
        expected = getattr(start, name).ravel()
        np.testing.assert_allclose(answer[name], expected, rtol=1e-9, atol=1e-12 * np.abs(expected).max())
    space = artifact.manifest.space
    task = space.task({axis: answer[axis] for axis in space.ranged}).parameters
    cost, rows = (np.asarray(each).ravel() for each in problem.function(answer["primal"], task))
    np.testing.assert_allclose(answer["cost"], cost[0], rtol=1e-12)
    np.testing.assert_allclose(answer["rows"], rows, rtol=1e-12, atol=1e-12 * max(1.0, np.abs(rows).max()))
    program.evaluate(start.primal, task, start.multipliers_rows)
    total = program.gradient + start.multipliers_bounds
    places, values = program.jacobian_places, program.jacobian
    np.add.at(total, places[1], values * start.multipliers_rows[places[0]])
    free = np.setdiff1d(np.arange(len(total)), fixed_by(artifact, start.pattern))
    assert answer["stationarity"] == pytest.approx(np.abs(total[free]).max(), rel=1e-6, abs=1e-9 * np.abs(total).max())
    means = [artifact.tensors.mean(gait)[0] for gait in range(len(artifact.manifest.gaits))]
    return not any(np.array_equal(start.primal, mean) for mean in means)


def fixed_by(artifact: Artifact, pattern: str) -> np.ndarray:
    index = [gait.pattern for gait in artifact.manifest.gaits].index(pattern)
    space = artifact.tensors.space(index)
    return np.flatnonzero(space.lower == space.upper)


def test_the_functions_are_those_of_python_with_their_sparsity(exported: Exported, tmp_path: Path) -> None:
    artifact = load_artifact(exported.model)
    library = shared(tmp_path, exported.folder)
    problem = load_problem(exported.model, artifact.manifest, artifact.tensors.rows)
    reference = derivatives(problem)
    start = GaitMap.load(exported.model).select(0.9, 0.6).warm_start
    assert start is not None
    task = artifact.manifest.space.task({"speed": 0.9, "cycle_duration": 0.6}).parameters
    expected = reference(start.primal, task, start.multipliers_rows)
    functions = {
        name: casadi.external(f"quickstart_{name}", str(library)) for name in ("problem", "gradient", "jacobian")
    }
    hessian = casadi.external("quickstart_hessian", str(library))
    found = [
        *functions["problem"](start.primal, task),
        *(functions[name](start.primal, task) for name in ("gradient", "jacobian")),
    ]
    found.append(hessian(start.primal, task, start.multipliers_rows))
    for name, mine, theirs in zip(("cost", "rows", "gradient", "jacobian", "hessian"), found, expected, strict=True):
        assert mine.sparsity() == theirs.sparsity(), name
        assert np.abs(np.array(theirs.nonzeros())).max() > 0
        np.testing.assert_allclose(mine.nonzeros(), theirs.nonzeros(), rtol=1e-12, atol=1e-12, err_msg=name)


def shared(folder: Path, *exports: Path) -> Path:
    """The C files of exports as one library."""
    library = folder / "functions.so"
    sources = [str(path) for export in exports for path in sorted(export.glob("*.c"))]
    command = ["cc", "-O1", "-shared", "-fPIC", "-Wl,--no-undefined", "-o", str(library), *sources, "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return library


def test_two_maps_link_into_one_program(exported: Exported, tmp_path: Path) -> None:
    artifact = load_artifact(exported.model)
    problem = load_problem(exported.model, artifact.manifest, artifact.tensors.rows)
    other = tmp_path / "other"
    other.mkdir()
    feet = np.array([leg["default_foot"] for leg in artifact.manifest.scenario["robot"]["legs"]])
    for name, content in c_files(problem, artifact.manifest.layout, feet, "2d-other").items():
        (other / name).write_bytes(content)
    library = shared(tmp_path, exported.folder, other)
    for name in ("quickstart_problem", "map_2d_other_problem"):
        assert casadi.external(name, str(library)).numel_out(1) == problem.function.numel_out(1)


def resealed(content: bytes) -> bytes:
    """The file with the checksum and the size that its bytes should have."""
    content = content[:16] + struct.pack("<Q", len(content)) + content[24:]
    return content[:12] + struct.pack("<I", zlib.crc32(content[16:])) + content[16:]


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda content: content[:-1], "but it should have"),
        (lambda content: content + b"\0" * 8, "but it should have"),
        (lambda content: b"", "this is no map.bin"),
        (lambda content: b"PK" + content[2:], "this is no map.bin"),
        (lambda content: content[:2000] + bytes([content[2000] ^ 1]) + content[2001:], "its checksum is wrong"),
        (lambda content: content[:30] + bytes([content[30] ^ 1]) + content[31:], "its checksum is wrong"),
        (lambda content: content[:8] + struct.pack("<I", 1) + content[12:], "has format 1, this reader knows format 7"),
        (lambda content: resealed(content + b"\0" * 8), "something follows after its end"),
        (lambda content: resealed(content[:-8]), "longer than the file"),
        (lambda content: resealed(content[:-16] + struct.pack("<ff", 3e38, 3e38) + content[-8:]), "beyond 1e15"),
        (lambda content: resealed(content[:56] + struct.pack("<Q", 2**63) + content[64:]), "a text is too long"),
    ],
    ids=["short", "long", "empty", "other", "flipped", "digest", "older", "more", "less", "huge number", "huge text"],
)  # fmt: skip
def test_a_damaged_file_is_refused(guarded: Path, exported: Exported, tmp_path: Path, spoil: Any, says: str) -> None:
    content = (exported.folder / "map.bin").read_bytes()
    assert content.startswith(MAGIC) and resealed(content) == content
    bad = tmp_path / "bad.bin"
    bad.write_bytes(spoil(content))
    answer = run(guarded, bad, "0.9 0.6\n")
    assert answer.returncode == 1
    assert says in answer.stderr and str(bad) in answer.stderr
    assert not answer.stdout


def test_a_file_that_lies_reads_no_foreign_memory(guarded: Path, exported: Exported, tmp_path: Path) -> None:
    """Any number may be wrong in a file whose checksum is right: an error or an answer, never a fault."""
    random, bad = np.random.default_rng(2), tmp_path / "bad.bin"
    content = (exported.folder / "map.bin").read_bytes()
    words = np.frombuffer(content, dtype="<u8")
    counts = np.flatnonzero(words < 2**20)  # what could be a count, an index or a pattern
    values = (0, 1, 2, 3, 255, 2**31, 2**32 + 1, 2**63, 2**64 - 1)
    outcomes = set()
    for _ in range(200):
        spoilt = words.copy()
        places = counts if random.random() < 0.7 else np.arange(7, len(words))
        place = random.choice(places[places >= 7][:400] if random.random() < 0.5 else places[places >= 7])
        spoilt[place] = random.choice(np.array(values, dtype=np.uint64))
        bad.write_bytes(resealed(spoilt.tobytes()))
        answer = run(guarded, bad, "0.9 0.6\n0.31 0.62\n")
        assert answer.returncode in (0, 1) and "anitizer" not in answer.stderr, (place, answer.stderr)
        outcomes.add(answer.returncode)
    assert outcomes == {0, 1}


def test_what_it_cannot_read_it_names(guarded: Path, exported: Exported, tmp_path: Path) -> None:
    missing = run(guarded, tmp_path / "none.bin", "")
    assert missing.returncode == 1 and "none.bin: cannot be read" in missing.stderr
    for text in ("0.9 0.6\n0.9 fast\n", "0.9 0.6\nnan 0.6\n", "0.9 0.6\n0.9"):
        odd = run(guarded, exported.folder / "map.bin", text)
        assert odd.returncode == 1 and "line 2: write 2 numbers" in odd.stderr
    assert len(odd.stdout.splitlines()) == 1
    huge = run(guarded, exported.folder / "map.bin", "1e308 0.6\n-1e308 -0.0\n")
    assert [json.loads(line)["in_domain"] for line in huge.stdout.splitlines()] == [False, False]
