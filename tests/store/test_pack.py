from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from gaitflow.store.pack import DamagedPack, Packs, open_pack, write_pack

PARTS = {hashlib.sha256(bytes([i])).hexdigest(): bytes([i]) * (i * 7) for i in range(20)}
PARTS["00" * 32] = b"digests may end in zeros"


@pytest.fixture
def pack(tmp_path: Path) -> Path:
    return write_pack(tmp_path, [(digest, len(data)) for digest, data in PARTS.items()], PARTS.__getitem__)


def test_every_part_is_found_and_comes_back(pack: Path) -> None:
    opened = open_pack(pack)
    assert opened.digests() == sorted(PARTS)
    for digest, data in PARTS.items():
        number = opened.find(digest)
        assert number is not None and opened.read(number) == data
    assert opened.find("ff" * 32) is None and opened.find("00" * 31 + "01") is None


def test_the_same_parts_make_the_same_file(pack: Path, tmp_path: Path) -> None:
    before = pack.read_bytes()
    again = write_pack(tmp_path, [(d, len(x)) for d, x in reversed(PARTS.items())], PARTS.__getitem__)
    assert again == pack and again.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == [pack.name]


def test_a_part_that_changes_while_it_is_packed_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="has 3 bytes, had 4"):
        write_pack(tmp_path, [("ab" * 32, 4)], lambda digest: b"abc")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("length", [0, 10, 24, 100, -1])
def test_a_truncated_pack_is_found(pack: Path, length: int) -> None:
    pack.write_bytes(pack.read_bytes()[:length])
    with pytest.raises(DamagedPack, match=pack.name):
        open_pack(pack)


@pytest.mark.parametrize("at", [0, 17, 30, 24 + 33, 24 + 48 * 20 + 47])
def test_a_flipped_bit_of_the_index_is_found(pack: Path, at: int) -> None:
    data = bytearray(pack.read_bytes())
    data[at] ^= 1
    pack.write_bytes(data)
    with pytest.raises(DamagedPack):
        open_pack(pack)


@pytest.mark.parametrize("offset", [0, 5, 2**63, 2**64 - 1])
def test_an_index_that_lies_is_refused_even_under_its_own_name(tmp_path: Path, offset: int) -> None:
    head = b"gaitflow pack 1\n" + (1).to_bytes(8, "little")
    head += bytes(32) + offset.to_bytes(8, "little") + (2**64 - offset + 74 if offset else 4).to_bytes(9, "little")[:8]
    path = tmp_path / f"{hashlib.sha256(head).hexdigest()}.pack"
    path.write_bytes(head + b"PAR1")
    with pytest.raises(DamagedPack, match="not what its index tells"):
        open_pack(path)


def test_packs_come_and_go_under_an_open_store(pack: Path, tmp_path: Path) -> None:
    packs = Packs(tmp_path)
    (tmp_path / "notes.txt").write_text("no pack")
    assert [each.path for each in packs.all()] == [pack] and packs.find("00" * 32) is not None
    other = write_pack(tmp_path, [("ff" * 32, 2)], lambda digest: b"hi")
    found = packs.find("ff" * 32)
    assert found is not None and found[0].path == other
    pack.unlink()
    assert packs.find("00" * 32) is None
    other.write_bytes(b"broken")
    assert list(Packs(tmp_path).all()) == [] and list(packs.damaged()) == [other]
    assert list(Packs(tmp_path / "none").all()) == [] and Packs(tmp_path / "none").damaged() == {}
