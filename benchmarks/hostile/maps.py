"""Damaged maps, their digests made right again: loaded, asked, now and then asked for a motion."""

from __future__ import annotations

import json
import random
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import onnx
from onnx import helper, numpy_helper
from safetensors.numpy import load, save

from benchmarks.hostile.damage import damaged_bytes, damaged_data
from benchmarks.hostile.sandbox import Unsound
from gaitflow.core.errors import ArtifactError
from gaitflow.runtime import GaitMap
from gaitflow.runtime.files import ATLAS, CLASSIFIER, CONTENT, MANIFEST, PROBLEM_CHECK, WARM_STARTS, entry_of
from gaitflow.runtime.manifest import SELF_DIGEST
from gaitflow.runtime.tensors import WarmStart

REFUSALS = (ArtifactError,)
PLAN_EVERY = 25  # a motion takes as long as a hundred answers
PLACES = (0.0, 0.1, 0.23, 0.37, 0.5, 0.66, 0.82)  # parts of the way along all axes
ODD_NUMBERS = (1e308, -1e308, 1e30, float("nan"), float("inf"), -float("inf"), -1.0, 0.0, 5e-324)


def damage(folder: Path, outside: Path, chance: random.Random) -> str:
    """Damage the map in a folder and make its digests right again; what was done."""
    manifest = json.loads((folder / MANIFEST).read_bytes())
    what = chance.choice(["manifest", "manifest", "bytes", "tensors", "tensors", "graph", "graph", "link"])
    if what == "manifest":
        part = chance.choice(["scenario", "scenario", "all"])
        how, changed = damaged_data(manifest[part] if part == "scenario" else manifest, chance)
        manifest = manifest | {part: changed} if part == "scenario" else changed
        what = f"manifest {part} {how}"
    elif what == "link":
        name = chance.choice(CONTENT)
        (outside / name).write_bytes((folder / name).read_bytes())
        (folder / name).unlink()
        (folder / name).symlink_to(outside / name)
    else:
        names = {"bytes": CONTENT, "tensors": (WARM_STARTS, ATLAS, PROBLEM_CHECK), "graph": (CLASSIFIER,)}[what]
        name = chance.choice(names)
        content = (folder / name).read_bytes()
        if what == "bytes":
            how, content = damaged_bytes(content, chance)
        elif what == "tensors":
            how, content = _damaged_tensors(content, chance)
        else:
            how, content = _damaged_graph(content, outside, chance)
        (folder / name).write_bytes(content)
        manifest["files"][name] = asdict(entry_of(content))
        what = f"{name} {what} {how}"
    (folder / MANIFEST).write_bytes(_encoded(manifest))
    return what


def ask(folder: Path, number: int) -> Any:
    """What the map says of a few tasks. Raises ArtifactError, Unsound."""
    gait_map, said = GaitMap.load(folder), []
    axes = gait_map.manifest.domain.axes
    for part in PLACES:
        task: dict[str, Any] = {axis: values[0] + part * (values[-1] - values[0]) for axis, values in axes.items()}
        choice = gait_map.select(**task)
        start = None if choice.gait is None else choice.warm_start
        if start is not None:
            _check(start)
            if not 0 <= choice.probability <= 1.001 or choice.gait not in [gait.name for gait in gait_map.gaits]:
                raise Unsound(f"{choice.gait} with the probability {choice.probability}")
        length = None if start is None else float(np.abs(start.primal).sum())
        said.append([choice.gait, choice.pattern, choice.in_domain, choice.probability, length])
    for gait in gait_map.gaits:
        _check(gait_map.mean_start(gait.name, 0.6))
    if number % PLAN_EVERY == 0:
        middle: dict[str, Any] = gait_map.manifest.domain.middle
        plan = gait_map.plan(**middle)
        if plan.feasible and not np.isfinite(plan.cost):
            raise Unsound(f"a feasible plan of the cost {plan.cost}")
    return said


def _check(start: WarmStart) -> None:
    vectors = (start.primal, start.multipliers_bounds, start.multipliers_rows, start.base, start.forces)
    if not all(np.isfinite(each).all() for each in vectors):
        raise Unsound(f"the start of {start.gait} is not finite")


def _encoded(manifest: Any) -> bytes:
    """As `manifest.encode` writes it, and whatever JSON can hold besides."""
    if not isinstance(manifest, dict):
        return json.dumps(manifest).encode()
    rest = {key: value for key, value in manifest.items() if key != SELF_DIGEST}
    text = (json.dumps(rest, sort_keys=True, indent=1) + "\n").encode()
    return (json.dumps(rest | {SELF_DIGEST: sha256(text).hexdigest()}, sort_keys=True, indent=1) + "\n").encode()


def _damaged_tensors(content: bytes, chance: random.Random) -> tuple[str, bytes]:
    tensors = {name: np.array(value) for name, value in load(content).items()}
    kind = chance.choice(sorted({name.rpartition(".")[2] for name in tensors}))  # of a sheet: "costs", "modes", ...
    alike = [name for name in sorted(tensors) if name.rpartition(".")[2] == kind]
    name, odd, everywhere = chance.choice(alike), chance.choice(ODD_NUMBERS), chance.random() < 0.5
    how, value = chance.choice(["number", "number", "number", "type", "shape", "missing", "extra"]), tensors[name]
    match how:
        case "number":
            with np.errstate(all="ignore"):
                for each in alike if everywhere else [name]:
                    flat = tensors[each].reshape(-1)
                    flat[slice(None) if everywhere else chance.randrange(flat.size)] = np.array(odd).astype(flat.dtype)
        case "type":
            with np.errstate(all="ignore"):
                tensors[name] = value.astype(chance.choice([np.float32, np.float64, np.int32, np.uint8, np.float16]))
        case "shape":
            tensors[name] = chance.choice([value.ravel(), value[:0], value[None], np.concatenate([value, value])])
        case "missing":
            del tensors[name]
        case _:
            tensors[chance.choice(["extra", f"{name}.x"])] = value
    return how, save({key: np.ascontiguousarray(each) for key, each in tensors.items()})


def _damaged_graph(content: bytes, outside: Path, chance: random.Random) -> tuple[str, bytes]:
    model = onnx.load_model_from_string(content)
    graph = model.graph
    how = chance.choice(
        ["operator", "attribute", "constant", "constant", "input", "missing", "loop", "grow", "external"]
    )
    node = chance.choice(graph.node)
    match how:
        case "operator":
            node.op_type = chance.choice(["Loop", "If", "Sqrt", "Relu", "Softmax", "Log", "Einsum", "Gemm", "TopK"])
        case "attribute" if node.attribute:
            attribute = chance.choice(node.attribute)
            attribute.i, attribute.f = chance.choice([-1, 0, 2**40]), chance.choice(ODD_NUMBERS[:4])
            for numbers in (attribute.ints, attribute.floats):
                if numbers:
                    numbers[chance.randrange(len(numbers))] = chance.choice([-1, 0, 1, 10**9])
        case "constant" if graph.initializer:
            chosen = chance.choice(graph.initializer)
            value = np.array(numpy_helper.to_array(chosen))
            if value.dtype.kind == "f":
                with np.errstate(all="ignore"):
                    value = chance.choice(
                        [value * np.float32(1e30), value * np.float32("nan"), value.ravel()[:1], -value]
                    )
            chosen.CopyFrom(numpy_helper.from_array(np.ascontiguousarray(value), chosen.name))
        case "input" if node.input:
            others = [*node.output, *(each.name for each in graph.input)]
            node.input[chance.randrange(len(node.input))] = chance.choice(others)
        case "missing":
            graph.node.remove(node)
        case "grow":
            last, first = graph.node[-1], graph.node[-1].input[0]
            for i in range(chance.choice([1, 30])):
                graph.node.insert(len(graph.node) - 1, helper.make_node("Concat", [first, first], [f"g{i}"], axis=1))
                first = f"g{i}"
            last.input[0] = first
        case "external" if graph.initializer:
            tensor = chance.choice(graph.initializer)
            (outside / "weights.bin").write_bytes(tensor.raw_data or bytes(64))
            tensor.ClearField("raw_data")
            tensor.data_location = onnx.TensorProto.EXTERNAL
            entry = tensor.external_data.add()
            entry.key, entry.value = "location", chance.choice([str(outside / "weights.bin"), "../outside/weights.bin"])
        case _:
            body = helper.make_graph([helper.make_node("Identity", ["go"], ["on"])], "b", [], [])
            graph.node.insert(0, helper.make_node("Loop", ["", ""], ["never"], body=body))
    return how, model.SerializeToString()
