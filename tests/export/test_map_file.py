"""map.bin, read back by nothing but its description in docs/other-languages.md."""

from __future__ import annotations

import hashlib
import struct
import zlib

import numpy as np
import pytest

from gaitflow.core.task import AXES
from gaitflow.export import Exported
from gaitflow.export.export import MAP
from gaitflow.runtime.artifact import load_artifact
from gaitflow.runtime.atlas import DOUBT, SUPPORT
from gaitflow.runtime.nearby import NEAREST, REACH
from gaitflow.solvers.point import GaitSpace


class Items:
    def __init__(self, content: bytes) -> None:
        self.content, self.at = content, 56

    def array(self, kind: str, *shape: int) -> np.ndarray:
        values = np.frombuffer(self.content, kind, int(np.prod(shape)), self.at).reshape(shape)
        self.at += -(-values.nbytes // 8) * 8
        return values

    def counts(self, number: int) -> list[int]:
        return self.array("<u8", number).tolist()

    def text(self) -> str:
        return self.array("u1", *self.counts(1)).tobytes().decode()

    def space(self, variables: int, rows: int) -> GaitSpace:
        return GaitSpace(*(self.array("<f8", size) for size in (variables, variables, rows, rows)))


def same(space: GaitSpace, other: GaitSpace) -> bool:
    names = ("lower", "upper", "lower_rows", "upper_rows")
    return all(np.array_equal(getattr(space, name), getattr(other, name)) for name in names)


@pytest.mark.parametrize("which", ["exported", "sloped_export"])
def test_it_holds_the_map(which: str, request: pytest.FixtureRequest) -> None:
    exported: Exported = request.getfixturevalue(which)
    content = (exported.folder / MAP).read_bytes()
    artifact = load_artifact(exported.model)
    manifest, tensors, atlas = artifact.manifest, artifact.tensors, artifact.atlas
    layout, domain, axes = manifest.layout, manifest.domain, manifest.space.ranged

    magic, number, crc, size, digest = struct.unpack("<8sIIQ32s", content[:56])
    assert (magic, number, size) == (b"gaitmap\n", 7, len(content))
    assert crc == zlib.crc32(content[16:])
    assert digest == hashlib.sha256((exported.model / "manifest.json").read_bytes()).digest()

    items = Items(content)
    assert (items.text(), items.text()) == ("quickstart", "1.0.0")
    parameters, ranged = items.counts(2)
    names = [items.text() for _ in range(parameters)]
    assert names == list(AXES)
    held = items.array("<f8", parameters)
    places = items.counts(ranged)
    assert tuple(names[place] for place in places) == axes
    task = manifest.space.task({axis: values[0] for axis, values in domain.axes.items()})
    assert np.array_equal(np.delete(task.parameters, places), np.delete(held, places)) and not held[places].any()

    sizes = items.counts(ranged)
    for values, each in zip(domain.axes.values(), sizes, strict=True):
        assert tuple(items.array("<f8", each)) == values
    assert np.array_equal(items.array("u1", *sizes), domain.feasible)

    sizes = items.counts(8)
    assert sizes[:3] == [layout.phases, layout.knots_per_phase, layout.legs]
    assert sizes[3:] == [layout.dimension, layout.nb, tensors.rows, layout.linear_forces, layout.energy]
    assert [items.text() for _ in range(layout.legs)] == ["F", "H"]
    assert np.array_equal(items.array("<f8", layout.knots_per_phase), layout.shares)
    assert np.array_equal(items.array("<f8", layout.nw), layout.scale(1.0))
    assert items.array("<f8", 1).tolist() == [manifest.cost_scale]

    kind, layers = items.counts(2)
    assert kind == 0
    for layer in range(layers):
        outputs, inputs = items.counts(2)
        weights, biases = items.array("<f4", inputs, outputs), items.array("<f4", outputs)
        assert inputs == len(axes) or layer
        if which == "exported":
            assert weights.tolist() == [[-5.0, 5.0], [0.0, 0.0]] and biases.tolist() == [3.5, -3.5]
    assert items.counts(1) == [0], "no votes, so no smoothing"
    assert items.array("<f4", 1).tolist() == [1.0 if which == "exported" else pytest.approx(0.7)]

    assert items.counts(1) == [len(manifest.gaits)]
    for index, gait in enumerate(manifest.gaits):
        assert [items.text() for _ in range(3)] == [gait.name, gait.key, gait.pattern]
        for vector in tensors.mean(index):
            assert np.array_equal(items.array("<f8", len(vector)), vector)
        assert same(items.space(layout.nw, tensors.rows), tensors.space(index))

    assert np.array_equal(items.array("<f8", ranged), atlas.steps)
    assert items.array("<f8", 5).tolist() == [atlas.barrier, REACH, NEAREST, SUPPORT, DOUBT]
    assert items.counts(1) == [len(atlas.sheets)] != [0]
    for sheet in atlas.sheets:
        assert items.counts(1) == [sheet.gait]
        assert items.text() == sheet.pattern
        assert same(items.space(layout.nw, tensors.rows), sheet.space)
        nodes, modes, numbers, infeasible = items.counts(4)
        assert items.array("<f8", 1).tolist() == [sheet.tear]
        assert np.array_equal(items.array("<f8", nodes, ranged), sheet.tasks)
        assert np.array_equal(items.array("<f8", infeasible, ranged), sheet.infeasible)
        assert np.array_equal(items.array("<f8", nodes), sheet.costs)
        assert np.array_equal(items.array("<f8", nodes, ranged), sheet.slopes)
        assert np.array_equal(items.array("<f4", numbers), sheet.mean)
        assert np.array_equal(items.array("<f4", modes, numbers), sheet.modes)
        assert np.array_equal(items.array("<f4", nodes, modes), sheet.coordinates)
        assert np.array_equal(items.array("<f4", nodes, ranged, modes), sheet.tangents)
    assert items.at == len(content)
