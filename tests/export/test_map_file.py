"""map.bin, read back by nothing but its description in docs/other-languages.md."""

from __future__ import annotations

import hashlib
import struct
import zlib

import numpy as np

from gaitflow.export import Exported
from gaitflow.export.export import MAP
from gaitflow.runtime import GaitMap
from gaitflow.runtime.gait_map import load_atlas
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


def test_it_holds_the_map(exported: Exported) -> None:
    content = (exported.folder / MAP).read_bytes()
    gait_map = GaitMap.load(exported.model)
    manifest, tensors = gait_map.manifest, gait_map._tensors
    atlas, layout, domain = load_atlas(exported.model, manifest), manifest.layout, manifest.domain

    magic, number, crc, size, digest = struct.unpack("<8sIIQ32s", content[:56])
    assert (magic, number, size) == (b"gaitmap\n", 1, len(content))
    assert crc == zlib.crc32(content[16:])
    assert digest == hashlib.sha256((exported.model / "manifest.json").read_bytes()).digest()

    items = Items(content)
    assert (items.text(), items.text()) == ("quickstart", "1.0.0")
    speeds, cycles = items.counts(2)
    assert tuple(items.array("<f8", speeds)) == domain.speeds
    assert tuple(items.array("<f8", cycles)) == domain.cycle_durations
    assert np.array_equal(items.array("u1", speeds, cycles), np.array(domain.feasible))

    sizes = items.counts(6)
    assert sizes == [
        layout.phases,
        layout.knots_per_phase,
        len(layout.legs),
        layout.dimension,
        layout.base,
        layout.rows,
    ]
    assert tuple(items.text() for _ in layout.legs) == layout.legs
    assert np.array_equal(items.array("<f8", layout.variables), tensors.scale)

    assert items.counts(1) == [1]
    outputs, inputs = items.counts(2)
    assert (outputs, inputs) == (2, 2)
    assert items.array("<f4", inputs, outputs).tolist() == [[-5.0, 5.0], [0.0, 0.0]]
    assert items.array("<f4", outputs).tolist() == [3.5, -3.5]
    assert items.array("<f4", 1).tolist() == [1.0]

    assert items.counts(1) == [len(manifest.gaits)]
    for index, gait in enumerate(manifest.gaits):
        assert [items.text() for _ in range(3)] == [gait.name, gait.key, gait.pattern]
        for vector in tensors.mean(index):
            assert np.array_equal(items.array("<f8", len(vector)), vector)
        assert same(items.space(layout.variables, layout.rows), tensors.space(index))

    speeds, cycles = items.counts(2)
    assert tuple(items.array("<f8", speeds)) == atlas.speeds
    assert tuple(items.array("<f8", cycles)) == atlas.cycle_durations
    assert items.array("<f8", 1).tolist() == [atlas.barrier]
    assert items.counts(1) == [len(atlas.sheets)] != [0]
    for sheet in atlas.sheets:
        assert items.counts(1) == [sheet.gait]
        assert items.text() == sheet.pattern
        assert same(items.space(layout.variables, layout.rows), sheet.space)
        nodes, modes, numbers = items.counts(3)
        assert items.array("<f8", 1).tolist() == [sheet.tear]
        assert np.array_equal(items.array("<u4", nodes, 2), sheet.places)
        assert np.array_equal(items.array("<f8", nodes), sheet.costs)
        assert np.array_equal(items.array("<f4", numbers), sheet.mean)
        assert np.array_equal(items.array("<f4", modes, numbers), sheet.modes)
        assert np.array_equal(items.array("<f4", nodes, modes), sheet.coordinates)
    assert items.at == len(content)
