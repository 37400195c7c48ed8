"""Where a file's numbers come from: scenario or unit, code, package versions, processor, solver options.

The record is JSON under the key `gaitflow` of a Parquet file's metadata. It names no host and no user.
"""

from __future__ import annotations

import functools
import json
import platform
import subprocess
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import gaitflow
from gaitflow.config.scenario import Scenario, digest_of
from gaitflow.tables.solver_code import solver_version

KEY = b"gaitflow"
FORMAT = 2  # 1: tasks were two columns, and the scenario had a terrain
READ = (1, 2)
PACKAGES = ("casadi", "qdldl", "numpy", "pyarrow", "pydantic")


def unit_record(
    digest: str, unit: Mapping[str, Any], solver_options: Mapping[str, Any], maker: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Record of one part of the store: the unit's digest and its whole JSON data, who solved it, and how.

    `maker` is another process that solved it, as `made_by` tells of this one.
    """
    return {
        "format": FORMAT,
        "kind": "unit",
        "unit_digest": digest,
        "unit": dict(unit),
        "solver_options": dict(solver_options),
        "made_by": made_by() if maker is None else dict(maker),
        "created": _now(),
    }


def dataset_record(
    scenario: Scenario,
    digests: Sequence[str],
    parts: Sequence[Mapping[str, Any]],
    part_of: Sequence[int],
    askings: int = 0,
    rounds: Sequence[Mapping[str, Any]] = (),
) -> dict[str, Any]:
    """Record of a collected dataset: the scenario whole, and what the records of its units have in common.

    `parts` are the distinct records of units, `part_of` says which of them each unit has; `made_by` and
    `solver_options` list the distinct ones, so that a dataset solved on two kinds of machine says so. Then
    `units_made_by` has a number in `made_by` for each unit, in the order in which the scenario is cut into them.
    `units` is how many there are, `units_digest` the digest of their sorted names. `askings`, where there were any, is
    how often certificates were asked while an adaptive sampling chose the tasks; `rounds`, where it was stopped in the
    middle of one, are its rounds.
    """
    makers = _distinct([part["made_by"] for part in parts])
    numbers = [makers.index(part["made_by"]) for part in parts]
    return {
        "format": FORMAT,
        "kind": "dataset",
        "scenario_digest": digest_of(scenario.as_data()),
        "scenario": scenario.as_data(),
        "units": len(digests),
        "units_digest": digest_of(sorted(digests)),
        "made_by": makers,
        **({"units_made_by": [numbers[part] for part in part_of]} if len(makers) > 1 else {}),
        "solver_options": _distinct([part["solver_options"] for part in parts]),
        **({"askings": askings} if askings else {}),
        **({"rounds": list(rounds)} if rounds else {}),
        "collected_by": made_by(),
        "created": _now(),
    }


def read_record(metadata: Mapping[bytes, bytes] | None, source: str) -> dict[str, Any]:
    """The record in a Parquet file's key-value metadata. Raises ValueError that names `source` without one we read."""
    try:
        record = json.loads((metadata or {})[KEY])
        kind, number = record["kind"], record["format"]
    except (KeyError, TypeError, ValueError, RecursionError):
        raise ValueError(f"{source}: carries no gaitflow record; it is not one of our files") from None
    if number not in READ or kind not in ("unit", "dataset"):
        raise ValueError(
            f"{source}: its record is {kind!r} of format {number!r}; this version reads the formats "
            f"{' and '.join(map(str, READ))}"
        )
    return dict(record)


@functools.cache
def made_by() -> dict[str, Any]:
    """This process: code version, solver code, package versions, Python, processor model."""
    return {
        "code": {"version": gaitflow.__version__, **_commit(), "solver": solver_version()["code"]},
        "packages": {name: found for name in PACKAGES if (found := _version(name))},
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "cpu": _processor(),
    }


def _commit() -> dict[str, Any]:
    """Commit and dirty flag when the package runs from its own checkout; nothing when it was installed."""
    package = Path(gaitflow.__file__).resolve().parent
    top = _git(package, "rev-parse", "--show-toplevel")
    if top is None or Path(top).resolve() != package.parent:
        return {}
    changes = _git(package, "status", "--porcelain", "--untracked-files=no")
    return {"commit": _git(package, "rev-parse", "HEAD"), "dirty": bool(changes)}


def _git(folder: Path, *arguments: str) -> str | None:
    try:
        done = subprocess.run(["git", *arguments], cwd=folder, capture_output=True, text=True, timeout=20, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()


def _processor() -> str:
    try:
        cpuinfo = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        cpuinfo = ""
    return processor_name(cpuinfo) or platform.processor() or platform.machine()


def processor_name(cpuinfo: str) -> str:
    """The model of the first processor in the text of /proc/cpuinfo, as `AMD EPYC (family 25, model 1)`; "" if unsaid.

    In a virtual machine the name alone is often that of several generations, one of which takes half the other's time.
    """
    first = cpuinfo.strip().partition("\n\n")[0]
    fields = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in first.splitlines())}
    name, numbers = fields.get("model name", ""), [fields.get(key) for key in ("cpu family", "model")]
    return f"{name} (family {numbers[0]}, model {numbers[1]})" if name and all(numbers) else name


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _distinct(items: list[Any]) -> list[Any]:
    texts = sorted({json.dumps(item, sort_keys=True) for item in items})
    return [json.loads(text) for text in texts]


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
