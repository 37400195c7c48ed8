"""The C++ reader gives the probabilities that onnxruntime gives, whichever method won; needs g++."""

from __future__ import annotations

import struct
import subprocess
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cpp_program import compiled, lines, run
from trained import HIGH, LOW, NAMES, fitted, grid_tasks

from gaitflow.export.classifier_data import ClassifierData, read_classifier
from gaitflow.export.forest import Forest
from gaitflow.export.map_file import map_bytes
from gaitflow.export.neighbours import Neighbours
from gaitflow.export.support_vectors import SupportVectors
from gaitflow.runtime.artifact import Artifact, load_artifact
from gaitflow.runtime.classifier import Classifier

pytestmark = pytest.mark.slow

SOURCE = Path(__file__).parent / "probabilities.cpp"
CARRIERS = {2: "half-cheetah-flat-effort/1.2.0", 3: "half-cheetah-exact-slopes/1.1.0"}  # a map by its number of axes
LIES = (0, 1, 2, 3, 255, 2**20, 2**31, 2**32 - 1, 0x7F7FFFFF, 0xFF7FFFFF)  # the last two are the largest floats
MODELS = sorted(
    str(path.parent.relative_to(path.parents[2]))
    for path in Path(__file__).parents[2].glob("models/*/*/classifier.onnx")
)


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compiled(SOURCE, tmp_path_factory.mktemp("program"), "-O2")


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With the address and undefined-behaviour sanitizers."""
    flags = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    return compiled(SOURCE, tmp_path_factory.mktemp("guarded"), *flags)


@pytest.fixture(scope="module")
def carrier(checkout: Path) -> Callable[[int, int], Artifact]:
    """A published map without its atlas, cut to so many axes and gaits."""

    def cut(axes: int, gaits: int) -> Artifact:
        artifact = load_artifact(checkout / "models" / CARRIERS[axes])
        manifest = replace(artifact.manifest, gaits=artifact.manifest.gaits[:gaits])
        assert (len(manifest.gaits), len(manifest.space.ranged)) == (gaits, axes)
        return replace(artifact, manifest=manifest, atlas=replace(artifact.atlas, sheets=()))

    return cut


def asked(program: Path, folder: Path, content: bytes, tasks: np.ndarray) -> np.ndarray:
    (folder / "map.bin").write_bytes(content)
    answer = run(program, folder / "map.bin", lines(tasks))
    assert answer.returncode == 0, answer.stderr
    return np.array([[float(number) for number in line.split()] for line in answer.stdout.splitlines()])


def check_same(found: np.ndarray, expected: np.ndarray, within: float = 1e-5) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=within)
    first, second = np.sort(expected, axis=1)[:, :-3:-1].T
    clear = first - second > 2 * within
    assert np.array_equal(found.argmax(axis=1)[clear], expected.argmax(axis=1)[clear])
    assert clear.any()


def queries(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Tasks [700, axes] inside a box, around it, and as far away as the reader asks for."""
    random, axes = np.random.default_rng(0), len(low)
    far = random.choice([-1.0, 1.0], (100, axes)) * 10 ** random.uniform(1, 6.5, (100, axes))
    inside, around = ((low - more * (high - low), high + more * (high - low)) for more in (0, 1))
    return np.concatenate([random.uniform(*inside, (400, axes)), random.uniform(*around, (200, axes)), far])


def by_onnxruntime(content: bytes, tasks: np.ndarray, gaits: int) -> np.ndarray:
    """As GaitMap asks it, one task at a time."""
    classifier = Classifier(content, tasks.shape[1], gaits, "here")
    clipped = np.clip(tasks, -1e6, 1e6).astype(np.float32)
    return np.concatenate([classifier(task[np.newaxis]) for task in clipped])


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("gaits", [2, 4])
@pytest.mark.parametrize("name", NAMES)
def test_each_kind_answers_as_onnxruntime_does(
    name: str, gaits: int, axes: int, program: Path, carrier: Callable[[int, int], Artifact], tmp_path: Path
) -> None:
    content = fitted(name, gaits, axes)
    tasks = np.concatenate([queries(np.array(LOW[:axes]), np.array(HIGH[:axes])), grid_tasks(axes)])
    map_file = map_bytes(carrier(axes, gaits), bytes(32), read_classifier(content, name, "here"))
    expected = by_onnxruntime(content, tasks, gaits)
    check_same(asked(program, tmp_path, map_file, tasks), expected)
    assert len(set(expected.argmax(axis=1))) == gaits


@pytest.mark.parametrize("gaits", [2, 4])
def test_a_task_on_a_threshold_goes_where_it_goes_in_the_graph(
    gaits: int, program: Path, carrier: Callable[[int, int], Artifact], tmp_path: Path
) -> None:
    content = fitted("forest", gaits)
    data = read_classifier(content, "forest", "here")
    assert isinstance(data.method, Forest)
    scaler, axis = data.method.scaler, data.method.axis
    exact = (data.method.threshold / scaler.scale[axis] + scaler.offset[axis]).astype(np.float32)
    around = [exact, np.nextafter(exact, np.float32(-np.inf)), np.nextafter(exact, np.float32(np.inf))]
    values, axes = np.unique(np.stack([np.concatenate(around), np.tile(axis, 3)]), axis=1)
    on = np.isin((values.astype(np.float32) - scaler.offset[axes.astype(int)]) * scaler.scale[axes.astype(int)],
                 data.method.threshold)  # fmt: skip
    assert on.sum() > 10
    tasks = np.random.default_rng(0).uniform(LOW[:2], HIGH[:2], (len(values), 2))
    tasks[np.arange(len(values)), axes.astype(int)] = values
    map_file = map_bytes(carrier(2, gaits), bytes(32), data)
    check_same(asked(program, tmp_path, map_file, tasks), by_onnxruntime(content, tasks, gaits), within=1e-6)


@pytest.mark.parametrize("axes", [2, 3])
def test_of_tasks_equally_far_the_first_vote(
    axes: int, program: Path, carrier: Callable[[int, int], Artifact], tmp_path: Path
) -> None:
    content = fitted("knn", 4, axes)
    data = read_classifier(content, "knn", "here")
    assert isinstance(data.method, Neighbours)
    random, known = np.random.default_rng(1), grid_tasks(axes)
    middles = (known[random.permutation(len(known))] + known[random.permutation(len(known))]) / 2
    far = np.array([[sign * 10.0**power] * axes for power in range(2, 7) for sign in (-1, 1)])
    tasks = np.concatenate([known, middles, far])
    apart = tasks.astype(np.float32)[:, np.newaxis] / data.method.scale - data.method.known
    distances = np.sort((apart * apart).sum(axis=-1), axis=1)
    assert (distances[:, data.method.nearest - 1] == distances[:, data.method.nearest]).sum() > 10
    map_file = map_bytes(carrier(axes, 4), bytes(32), data)
    check_same(asked(program, tmp_path, map_file, tasks), by_onnxruntime(content, tasks, 4), within=1e-6)


@pytest.mark.parametrize("model", MODELS)
def test_every_published_map_becomes_data_that_answers_as_it_does(
    model: str, checkout: Path, program: Path, tmp_path: Path
) -> None:
    folder = checkout / "models" / model
    artifact, content = load_artifact(folder), (folder / "classifier.onnx").read_bytes()
    manifest = artifact.manifest
    grid = list(manifest.domain.axes.values())
    low, high = (np.array([values[end] for values in grid]) for end in (0, -1))
    tasks = np.random.default_rng(0).uniform(low - 0.5 * (high - low), high + 0.5 * (high - low), (500, len(grid)))
    map_file = map_bytes(artifact, bytes(32), read_classifier(content, manifest.classifier_kind, model))
    expected = by_onnxruntime(content, tasks, len(manifest.gaits))
    check_same(asked(program, tmp_path, map_file, tasks), expected)


def resealed(content: bytes) -> bytes:
    """The file with the checksum that its bytes should have."""
    return content[:12] + struct.pack("<I", zlib.crc32(content[16:])) + content[16:]


@pytest.mark.parametrize("name", NAMES)
def test_a_classifier_that_lies_reads_no_foreign_memory(
    name: str, guarded: Path, carrier: Callable[[int, int], Artifact], tmp_path: Path
) -> None:
    """Any number of it may be wrong in a file whose checksum is right: an error or an answer, never a fault."""
    data, random, bad = read_classifier(fitted(name, 2), name, "here"), np.random.default_rng(2), tmp_path / "map.bin"
    content, part = map_bytes(carrier(2, 2), bytes(32), data), b"".join(data.items())
    begin, outcomes = content.index(part), set()
    assert begin % 4 == 0 and run_on(guarded, bad, content).returncode == 0
    heads = [place for place in range(0, len(part), 4) if place < 200 or place > len(part) - 60]
    for trial in range(80):
        place = int(random.choice(heads if trial % 2 else np.arange(0, len(part), 4)))
        wrong = struct.pack("<I", int(random.choice(LIES)))
        answer = run_on(guarded, bad, content[: begin + place] + wrong + content[begin + place + 4 :])
        assert answer.returncode in (0, 1) and "anitizer" not in answer.stderr, (place, answer.stderr)
        outcomes.add(answer.returncode)
    assert outcomes == {0, 1}


def run_on(program: Path, bad: Path, content: bytes) -> subprocess.CompletedProcess[str]:
    bad.write_bytes(resealed(content))
    return run(program, bad, "0.9 0.6\n1e9 -1e9\n")


def method_with(**changes: Callable[[Any], Any]) -> Callable[[ClassifierData], ClassifierData]:
    """Changes of the method's columns."""

    def spoil(data: ClassifierData) -> ClassifierData:
        columns = {name: change(getattr(data.method, name)) for name, change in changes.items()}
        return replace(data, method=replace(data.method, **columns))

    return spoil


def one_machine_less(data: ClassifierData) -> ClassifierData:
    assert isinstance(data.method, SupportVectors)
    return replace(data, method=replace(data.method, machines=data.method.machines[1:]))


@pytest.mark.parametrize(
    ("name", "spoil", "says"),
    [
        ("forest", method_with(below=np.zeros_like), "a tree of the forest leads back"),
        ("forest", method_with(above=lambda above: above + 10**6), "a tree of the forest leads nowhere"),
        ("forest", method_with(roots=lambda roots: roots + 10**6), "a tree of the forest leads nowhere"),
        ("forest", method_with(axis=lambda axis: axis + 2), "asks for an axis that the map has not"),
        ("forest", method_with(votes=lambda votes: -votes), "a vote of the forest is negative"),
        ("forest", method_with(votes=lambda votes: votes * np.nan), "a number is not finite"),
        ("forest", method_with(votes=lambda votes: votes[:, 1:]), "smoothing is not of its votes"),
        ("forest", lambda data: replace(data, smoothing=data.smoothing * 0), "smoothing is not positive"),
        ("forest", lambda data: replace(data, temperature=0.0), "temperature is not positive"),
        ("svm", one_machine_less, "the classifier has other gaits than the map"),
        ("svm", lambda data: replace(data, smoothing=np.ones(4)), "smoothing is not of its votes"),
        ("knn", method_with(gait=lambda gait: gait + 1), "a known task has a gait that the map has not"),
        ("knn", method_with(nearest=lambda nearest: 10**5), "there are fewer known tasks than vote"),
        ("knn", method_with(nearest=lambda nearest: 0), "no known tasks vote"),
        ("knn", method_with(scale=np.negative), "no positive scale"),
    ],
)
def test_a_damaged_classifier_is_refused(
    name: str,
    spoil: Callable[[ClassifierData], ClassifierData],
    says: str,
    guarded: Path,
    carrier: Callable[[int, int], Artifact],
    tmp_path: Path,
) -> None:
    data = spoil(read_classifier(fitted(name, 4), name, "here"))
    answer = run_on(guarded, tmp_path / "bad.bin", map_bytes(carrier(2, 4), bytes(32), data))
    assert answer.returncode == 1 and not answer.stdout
    assert says in answer.stderr and "bad.bin" in answer.stderr
