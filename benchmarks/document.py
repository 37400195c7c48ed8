"""The JSON document of a bench: what was measured on which machine by which versions, and the summary in short."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from gaitflow.files import atomic_write
from gaitflow.tables.provenance import made_by

_NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")


def document(
    bench: str, scenario: str | None, rows: Sequence[Any], summary: Mapping[str, Any], notes: Sequence[str] = ()
) -> dict[str, Any]:
    """{bench, scenario, date (UTC), machine, versions, rows, summary, notes} of plain JSON data.

    `notes` say how to read the numbers. NaN and infinity, which JSON does not have, become null.
    """
    made = made_by()
    return {
        "bench": bench,
        "scenario": scenario,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "machine": machine(),
        "versions": {"gaitflow": made["code"], "python": made["python"], **made["packages"]},
        "rows": plain(rows),
        "summary": plain(summary),
        "notes": list(notes),
    }


def machine() -> dict[str, Any]:
    """Processor model, cores this process may use, memory [GiB] and system; no host name."""
    made = made_by()
    return {
        "cpu": made["cpu"],
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "memory_gib": round(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**30, 1),
        "system": made["system"],
    }


def plain(data: Any) -> Any:
    """The data as JSON can hold them: lists for tuples, Python's numbers for numpy's, null for NaN and infinity.

    Raises TypeError for anything else, naming its type.
    """
    match data:
        case Mapping():
            return {str(key): plain(value) for key, value in data.items()}
        case list() | tuple():
            return [plain(value) for value in data]
        case np.generic() | np.ndarray():
            return plain(data.tolist())
        case float():
            return data if math.isfinite(data) else None
        case str() | int() | None:  # bool is an int
            return data
    raise TypeError(f"a bench document cannot hold a {type(data).__name__}")


def write(done: Mapping[str, Any], folder: Path) -> Path:
    """Write a document to `<folder>/<bench>[-<scenario>].json`, replacing an older one whole. Raises WriteError.

    Raises ValueError for a name that is not lower-case words joined by "-".
    """
    names = [name for name in (done["bench"], done["scenario"]) if name is not None]
    for name in names:
        if not _NAME.fullmatch(name):
            raise ValueError(f"{name[:80]!r}: a bench or scenario is named by lower-case words joined by '-'")
    path = folder / f"{'-'.join(names)}.json"
    atomic_write(path, (json.dumps(done, indent=1, allow_nan=False) + "\n").encode())
    return path


def summary_table(done: Mapping[str, Any]) -> Table:
    """The summary to print: a line a number, or a line a method when the summary holds one object a method."""
    summary = done["summary"]
    title = " ".join(name for name in (done["bench"], done["scenario"]) if name)
    methods = {name: values for name, values in summary.items() if isinstance(values, Mapping)}
    if methods and len(methods) == len(summary):
        columns = list(dict.fromkeys(key for values in methods.values() for key in values))
        table = Table("method", *columns, title=title)
        for name, values in methods.items():
            table.add_row(name, *(_cell(values.get(key)) for key in columns))
        return table
    table = Table("", "", title=title, show_header=False)
    for key, value in summary.items():
        table.add_row(key, _cell(value))
    return table


def _cell(value: Any) -> str:
    match value:
        case None:
            return "N/A"
        case float():
            return f"{value:.4g}"
        case Mapping():
            between = "\n" if any(isinstance(inner, Mapping) for inner in value.values()) else ", "
            return between.join(f"{key} {_cell(inner)}" for key, inner in value.items())
        case list():
            return ", ".join(_cell(inner) for inner in value)
    return str(value)
