"""Published folders at an address, such as s3://bucket/models/NAME or https://host/models/NAME/1.0.0.

A version is fetched whole into the cache of this user, each file checked against the manifest on its way; there it is
kept under the manifest's digest, so that what is found there is never an older one. Needs gaitflow[remote], and for
most protocols the package of their file system, such as s3fs.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import secrets
import shutil
from contextlib import suppress
from os import PathLike
from pathlib import Path
from typing import Any, NoReturn

from gaitflow.core.errors import ArtifactError
from gaitflow.runtime.files import LIMITS, MANIFEST, FileEntry
from gaitflow.runtime.versions import newest_of

MAX_FILES = 100
MAX_BYTES = 8 << 30  # of one file
_CHUNK = 1 << 20
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,100}")


def is_address(path: str | PathLike[str]) -> bool:
    """Whether this is the address of a published folder and no path on this machine."""
    return "://" in os.fspath(path)


def local_folder(path: str | PathLike[str]) -> Path:
    """The path itself, or where the folder at an address was fetched to. Raises as `fetch`."""
    return fetch(os.fspath(path)) if is_address(path) else Path(path)


def fetch(address: str) -> Path:
    """Fetch a published version, or the newest one below `address`, and return its folder on this machine.

    What was fetched before is not fetched again, except for its manifest. Raises ArtifactError that names the address:
    when it cannot be reached or holds nothing of ours, and when a file is not what the manifest lists.
    """
    system, root = _opened(address)
    try:
        place = _version(system, root, address)
        content = _read(system, f"{place}/{MANIFEST}", LIMITS[MANIFEST])
    except ArtifactError:
        raise
    except Exception as error:  # every file system raises errors of its own
        _unreachable(address, error)
    entries = _entries(content, f"{address}: {MANIFEST}")
    folder = _cache() / hashlib.sha256(content).hexdigest()
    if (folder / MANIFEST).exists():
        return folder
    scratch = folder.with_name(f".{folder.name[:16]}.{os.getpid()}-{secrets.token_hex(4)}")
    try:
        scratch.mkdir(parents=True)
        for name, entry in entries.items():
            _copy(system, f"{place}/{name}", scratch / name, entry, f"{address}: {name}")
        (scratch / MANIFEST).write_bytes(content)
        with suppress(OSError):  # another process was first, with the same bytes
            os.rename(scratch, folder)
    except OSError as error:
        raise ArtifactError(f"{address}: cannot be kept in {folder.parent} ({error.strerror or error})") from None
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return folder


def _opened(address: str) -> tuple[Any, str]:
    try:
        from fsspec.core import url_to_fs
    except ImportError:
        raise ArtifactError(f'{address}: an address needs fsspec: pip install "gaitflow[remote]"') from None
    try:
        system, root = url_to_fs(address)
    except (ImportError, ValueError) as error:
        raise ArtifactError(f"{address}: cannot be opened ({error})") from None
    return system, str(root).rstrip("/")


def _version(system: Any, root: str, address: str) -> str:
    """Where the manifest is: in the folder itself, or in the newest version below it."""
    if system.exists(f"{root}/{MANIFEST}"):
        return root
    names = [str(each).rstrip("/").rsplit("/", 1)[-1] for each in system.ls(root, detail=False)]
    newest = newest_of(names)
    if newest is None:
        raise ArtifactError(f"{address}: holds no {MANIFEST} and no versions such as 1.0.0")
    return f"{root}/{newest}"


def _read(system: Any, path: str, limit: int) -> bytes:
    with system.open(path, "rb") as file:
        content: bytes = file.read(limit + 1)
    if len(content) > limit:
        raise ArtifactError(f"{path}: has more than the {limit} bytes that it may have")
    return content


def _entries(content: bytes, where: str) -> dict[str, FileEntry]:
    """What the manifest of a map or a dataset lists; its other fields are read by who loads the folder."""
    try:
        files = {str(n): FileEntry(str(e["sha256"]), int(e["bytes"])) for n, e in json.loads(content)["files"].items()}
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise ArtifactError(f"{where}: is no manifest of a published map or dataset") from None
    sound = all(_NAME.fullmatch(name) and 0 <= entry.bytes <= MAX_BYTES for name, entry in files.items())
    if not sound or len(files) > MAX_FILES:
        raise ArtifactError(f"{where}: lists files that no published map or dataset has")
    return files


def _copy(system: Any, source: str, target: Path, entry: FileEntry, where: str) -> None:
    """Copy one file, reading no more than its entry says. Raises ArtifactError when it is not what the entry says."""
    total, left = hashlib.sha256(), entry.bytes
    try:
        with system.open(source, "rb") as file, open(target, "xb") as copy:
            while block := file.read(min(left + 1, _CHUNK)):
                left -= len(block)
                total.update(block)
                if left < 0:
                    break
                copy.write(block)
    except Exception as error:
        _unreachable(where, error)
    if left or total.hexdigest() != entry.sha256:
        raise ArtifactError(
            f"{where}: its content is not what the manifest lists (SHA-256 or size differs); not loaded"
        )


def _unreachable(where: str, error: Exception) -> NoReturn:
    told = " ".join(str(error).split()) or type(error).__name__
    raise ArtifactError(f"{where}: cannot be read ({told[:300]})") from None


def _cache() -> Path:
    """Where fetched versions are kept: gaitflow/ in the cache folder of this user."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gaitflow"
