from __future__ import annotations

import errno
import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from gaitflow.files import WriteError, atomic_write, inside, make_folder, new_file, publish_once, sha256_file


def test_atomic_write_replaces_and_leaves_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "new" / "file"
    atomic_write(path, b"old")
    atomic_write(path, b"new")
    assert path.read_bytes() == b"new"
    assert os.listdir(path.parent) == ["file"]


def test_first_complete_file_wins(tmp_path: Path) -> None:
    path = tmp_path / "file"
    assert publish_once(path, b"first")
    assert not publish_once(path, b"second")
    assert path.read_bytes() == b"first"
    assert os.listdir(tmp_path) == ["file"]


def test_of_many_writers_exactly_one_wins(tmp_path: Path) -> None:
    path, wins = tmp_path / "file", []
    writers = [threading.Thread(target=lambda i=i: wins.append((publish_once(path, b"%d" % i), i))) for i in range(8)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    winners = [i for won, i in wins if won]
    assert len(wins) == 8 and len(winners) == 1
    assert path.read_bytes() == b"%d" % winners[0]


def test_nothing_is_visible_before_the_end_and_nothing_stays_after_an_error(tmp_path: Path) -> None:
    path = tmp_path / "file"
    with pytest.raises(RuntimeError), new_file(path, replace=True) as file:
        file.write(b"half")
        file.flush()
        assert not path.exists()
        raise RuntimeError
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("call", ["fsync", "link"])
def test_full_disk_names_path_and_way_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, call, full)
    with pytest.raises(WriteError, match=r"part\.bin: cannot be written .*free some space") as caught:
        publish_once(tmp_path / "part.bin", b"data")
    assert caught.value.errno == errno.ENOSPC
    assert os.listdir(tmp_path) == []


def test_a_really_full_device_is_reported(tmp_path: Path) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full")
    with pytest.raises(WriteError, match="No space left"), new_file(tmp_path / "file", replace=True) as file:
        with open("/dev/full", "wb", buffering=0) as full:
            full.write(b"x")
        file.write(b"never")
    assert os.listdir(tmp_path) == []


def test_a_folder_that_is_a_file_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(WriteError, match="cannot be written"):
        atomic_write(tmp_path / "file" / "below", b"")


@pytest.mark.parametrize("name", ["..", "../x", "a/../../x", "/etc/passwd", ".", "", "link/x"])
def test_paths_out_of_the_folder_are_refused(tmp_path: Path, name: str) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "link").symlink_to(tmp_path)
    with pytest.raises(ValueError, match="leads out of"):
        inside(folder, name)


def test_path_inside_is_resolved(tmp_path: Path) -> None:
    assert inside(tmp_path, "a/../b.json") == tmp_path.resolve() / "b.json"


def test_sha256_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"abc")
    assert sha256_file(tmp_path / "file") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"


def test_a_folder_is_made_with_those_above_it(tmp_path: Path) -> None:
    make_folder(tmp_path / "a" / "b")
    make_folder(tmp_path / "a" / "b")
    assert (tmp_path / "a" / "b").is_dir()
    (tmp_path / "file").write_text("")
    with pytest.raises(WriteError) as raised:
        make_folder(tmp_path / "file" / "b")
    assert str(raised.value).startswith(f"{tmp_path / 'file' / 'b'}: cannot be written (Not a directory); ")


# Root may write anywhere, unless the kernel is told not to let it.
READ_ONLY = """
import sys
from pathlib import Path
from gaitflow.files import WriteError, atomic_write, make_folder
for write in (lambda: make_folder(Path(sys.argv[1])), lambda: atomic_write(Path(sys.argv[1], "new", "file"), b"")):
    try:
        write()
    except WriteError as error:
        print(error)
"""


@pytest.mark.skipif(shutil.which("setpriv") is None, reason="needs setpriv of util-linux")
def test_a_read_only_folder_is_named_with_the_way_out(tmp_path: Path) -> None:
    tmp_path.chmod(0o555)
    command = [sys.executable, "-c", READ_ONLY, str(tmp_path)]
    if os.geteuid() == 0:
        powers = "-dac_override,-dac_read_search"
        command = ["setpriv", "--bounding-set", powers, "--inh-caps", powers, *command]
    told = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    tmp_path.chmod(0o755)
    assert len(told) == 2 and all(
        "(Permission denied); give yourself the right to write there" in line for line in told
    )
