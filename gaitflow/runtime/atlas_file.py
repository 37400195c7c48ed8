"""atlas.safetensors: what is in it, and how it is written; `gaitflow.runtime.atlas_reader` reads it.

Tensors: `axes` (names in ASCII, joined by commas, uint8), `steps` [a] and `barrier` [1] (float64), `sheets` [1]
(int32), `levels` of bounds (`gaitflow.runtime.levels`), and for every sheet "<number>.<name>": gait [1] (int32),
pattern [legs, phases] (uint8), lower, upper [nw], lower_rows, upper_rows [ng] (uint8: which level), and the fields of
`Sheet` by their names. Of these mean is float32, most others float64. modes, coordinates and tangents are int16 in
fixed point (`gaitflow.runtime.fixed_point`) with exponents, int16 as well, in "<number>.<name>_exponents" [1, c],
[1, k] and [1, a, k]. A sheet without infeasible places has no tensor of them.

A sheet that is the mirror image of another one has its gait, pattern and bounds, and instead of numbers `image_of` [1]
(int32), the number of the other, `image_places` [c] (int32) and `image_signs` [c] (int8), see `SheetImage`.

In older maps bounds are float64, and fixed point is float32 without exponents. Bounds of more than 256 values, and
numbers that fixed point would change, are written so today.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors.numpy import save

from gaitflow.runtime.atlas import Atlas, Sheet
from gaitflow.runtime.fixed_point import fixed_point, single
from gaitflow.runtime.levels import LEVELS, levelled, levels_of
from gaitflow.runtime.sheet_image import SheetImage

_NUMBERS = ("tasks", "costs", "slopes", "mean", "modes", "coordinates", "tangents")
ROUNDED_ALONG = {"modes": 0, "coordinates": 0, "tangents": 0}  # the axis whose numbers share an exponent
EXPONENTS = "_exponents"
BOUNDS = ("lower", "upper", "lower_rows", "upper_rows")
INFEASIBLE = "infeasible"
IMAGE_OF = "image_of"
OF_SHEET = ("gait", "pattern", *BOUNDS, *_NUMBERS, "tear")
OF_IMAGE = ("gait", "pattern", *BOUNDS, IMAGE_OF, "image_places", "image_signs")


def atlas_bytes(atlas: Atlas) -> bytes:
    """The file's content. Equal atlases give equal bytes."""
    tensors: dict[str, NDArray[Any]] = {
        "axes": np.frombuffer(",".join(atlas.axes).encode("ascii"), dtype=np.uint8),
        "steps": np.array(atlas.steps, dtype=np.float64),
        "barrier": np.array([atlas.barrier]),
        "sheets": np.array([len(atlas.sheets)], dtype=np.int32),
    }
    levels = levels_of(getattr(sheet.space, name) for sheet in atlas.sheets for name in BOUNDS)
    tensors |= {} if levels is None else {LEVELS: levels}
    written = {sheet.pattern: number for number, sheet in enumerate(atlas.sheets) if sheet.image is None}
    for number, sheet in enumerate(atlas.sheets):
        is_image = sheet.image is not None and sheet.image.of in written
        own = _image_tensors(sheet.image, written) if is_image else _number_tensors(sheet)
        own |= {name: levelled(getattr(sheet.space, name), levels) for name in BOUNDS}
        own |= {
            "gait": np.array([sheet.gait], dtype=np.int32),
            "pattern": np.array([[int(digit) for digit in row] for row in sheet.pattern.split("/")], dtype=np.uint8),
        }
        tensors |= {f"{number}.{name}": np.ascontiguousarray(value) for name, value in own.items()}
    return save(tensors)


def _number_tensors(sheet: Sheet) -> dict[str, NDArray[Any]]:
    own = {name: getattr(sheet, name) for name in _NUMBERS} | {"tear": np.array([sheet.tear])}
    own |= _in_fixed_point({name: own[name] for name in ROUNDED_ALONG})
    return own | ({INFEASIBLE: sheet.infeasible} if len(sheet.infeasible) else {})


def _image_tensors(image: SheetImage | None, written: Mapping[str, int]) -> dict[str, NDArray[Any]]:
    assert image is not None
    return {
        IMAGE_OF: np.array([written[image.of]], dtype=np.int32),
        "image_places": image.places.astype(np.int32),
        "image_signs": image.signs,
    }


def _in_fixed_point(arrays: Mapping[str, NDArray[np.float32]]) -> dict[str, NDArray[Any]]:
    """The arrays with their exponents; as they are where that would change any of them, as of older maps."""
    tensors: dict[str, NDArray[Any]] = {}
    for name, numbers in arrays.items():
        whole, exponents = fixed_point(numbers, ROUNDED_ALONG[name])
        if not np.array_equal(single(whole, exponents), numbers):
            return dict(arrays)
        tensors |= {name: whole, name + EXPONENTS: exponents}
    return tensors
