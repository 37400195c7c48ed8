"""Damaged safetensors files: headers that lie, and tensors of other numbers, types and shapes."""

from __future__ import annotations

import json
import random
from typing import Any

import numpy as np
from safetensors.numpy import load, save

from benchmarks.hostile.fields import Path, damaged_field, fields_of, oddities_of

ODD_NUMBERS = (1e308, -1e308, 1e30, 1e15, -1e15, float("nan"), float("inf"), -float("inf"), -1.0, 0.0, 5e-324)
ODD_LENGTHS = (0, 1, 7, 2**31, 2**62, 2**64 - 1)
TYPES = (np.float32, np.float64, np.int32, np.uint8, np.float16, np.int64, np.bool_)
WAYS = ("number", "number", "number", "type", "shape", "missing", "extra", "header length", "many names", "swap")


def kind_of(name: str) -> str:
    """What a tensor is, whichever sheet of an atlas it is of: "3.modes" are "modes"."""
    return name.rpartition(".")[2]


def header_of(content: bytes) -> Any:
    """The JSON object at a file's beginning."""
    return json.loads(content[8 : 8 + int.from_bytes(content[:8], "little")])


def header_fields(content: bytes) -> list[tuple[Path, str]]:
    """Every field of the header, of sheets' tensors one a kind, with every damage it can have."""
    header = header_of(content)
    return [(path, oddity) for path in fields_of(header, kind_of) for oddity in oddities_of(header, path)]


def with_header(content: bytes, path: Path, oddity: str) -> bytes:
    """The file with one field of its header damaged, and the header's length made right again."""
    text = json.dumps(damaged_field(header_of(content), path, oddity)).encode()
    return len(text).to_bytes(8, "little") + text + content[8 + int.from_bytes(content[:8], "little") :]


def damaged(content: bytes, chance: random.Random) -> tuple[str, bytes]:
    """How a file was damaged, and what came of it."""
    tensors = {name: np.array(value) for name, value in load(content).items()}
    kind = chance.choice(sorted({kind_of(name) for name in tensors}))
    alike = [name for name in sorted(tensors) if kind_of(name) == kind]
    name, odd, everywhere = chance.choice(alike), chance.choice(ODD_NUMBERS), chance.random() < 0.5
    how, value = chance.choice(WAYS), tensors[name]
    match how:
        case "number":
            with np.errstate(all="ignore"):
                for each in alike if everywhere else [name]:
                    flat = tensors[each].reshape(-1)
                    flat[slice(None) if everywhere else chance.randrange(flat.size)] = np.array(odd).astype(flat.dtype)
        case "type":
            with np.errstate(all="ignore"):
                tensors[name] = value.astype(chance.choice(TYPES))
        case "shape":
            tensors[name] = chance.choice([value.ravel(), value[:0], value[None], np.concatenate([value, value])])
        case "missing":
            del tensors[name]
        case "extra":
            tensors[chance.choice(["extra", f"{name}.x", "a\nb"])] = value
        case "swap":
            other = chance.choice(sorted(tensors))
            tensors[name], tensors[other] = tensors[other], value
        case "many names":
            tensors |= {f"{i}.{kind}": value[:0] for i in range(20_000)}
        case "header length":
            return how, chance.choice(ODD_LENGTHS).to_bytes(8, "little") + content[8:]
    return how, save({key: np.ascontiguousarray(each) for key, each in tensors.items()})
