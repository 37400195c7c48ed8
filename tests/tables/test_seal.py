from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pytest

from gaitflow.tables.seal import BrokenSeal, check_seal, write_sealed


@pytest.fixture
def sealed(tmp_path: Path) -> Path:
    path = tmp_path / "sealed.parquet"
    table = pa.table({"x": [1.0, 2.0, 3.0], "name": ["a", "b", None]})
    with open(path, "xb+") as file:
        write_sealed(file, table.schema, [table], {"format": 1})
    return path


def test_a_sealed_file_is_sound(sealed: Path) -> None:
    check_seal(sealed)


def test_every_single_flipped_bit_is_found(sealed: Path) -> None:
    sound = sealed.read_bytes()
    for i in range(len(sound)):
        sealed.write_bytes(sound[:i] + bytes([sound[i] ^ (1 << i % 8)]) + sound[i + 1 :])
        with pytest.raises(BrokenSeal):
            check_seal(sealed)


def test_every_truncation_and_anything_appended_is_found(sealed: Path) -> None:
    sound = sealed.read_bytes()
    for broken in [*(sound[:n] for n in range(len(sound))), sound + b"\0", sound + sound]:
        sealed.write_bytes(broken)
        with pytest.raises(BrokenSeal):
            check_seal(sealed)
