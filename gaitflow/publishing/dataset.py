"""Publishing a dataset: a version's folder appears whole, with a digest of every file, and never changes."""

from __future__ import annotations

import hashlib
import json
import os
import secrets
import shutil
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pandas as pd

from gaitflow.dataset.read import FILE_NAME, load_solutions
from gaitflow.files import atomic_write, sha256_file, sync_folder

MANIFEST = "manifest.json"
LABELS = "labels.parquet"
GAIT_COSTS = "gait_costs.parquet"
CARD = "README.md"
FORMAT = 1


class DatasetExists(ValueError):
    """The version is taken by a dataset with other content."""


def read_manifest(folder: Path) -> dict[str, Any]:
    """The manifest of a published dataset. Raises ValueError that names the file when it is not one we read."""
    path = folder / MANIFEST
    try:
        data = json.loads(path.read_bytes())
        number = data["format"]
    except (OSError, ValueError, KeyError, TypeError):
        raise ValueError(f"{path}: no readable manifest; is {folder} a published dataset?") from None
    if number != FORMAT:
        raise ValueError(f"{path}: has format {number!r}; this version of gaitflow reads {FORMAT}, update it")
    return dict(data)


def publish_dataset(target: Path, collected: Path, labels: Path, gait_costs: Path) -> str:
    """Publish the three files as the version folder `target`; returns the SHA-256 of its solutions.

    The files are copied; a folder that holds the same content is left as it is. Raises DatasetExists when `target`
    holds other content, ValueError when a file is not what it should be.
    """
    record = load_solutions(collected).record
    content = content_digest(record, pd.read_parquet(labels))
    if target.exists():
        if read_manifest(target)["content"] != content:
            raise DatasetExists(f"{target}: is published already with other content; a published version never changes")
        return str(read_manifest(target)["files"][FILE_NAME]["sha256"])
    scratch = target.parent / f".{target.name}.{os.getpid()}-{secrets.token_hex(4)}"
    try:
        for name, source in ((FILE_NAME, collected), (LABELS, labels), (GAIT_COSTS, gait_costs)):
            atomic_write(scratch / name, source.read_bytes())
        atomic_write(scratch / CARD, _card(target.name, record, pd.read_parquet(labels)).encode())
        names = (FILE_NAME, LABELS, GAIT_COSTS, CARD)
        files = {n: {"sha256": sha256_file(scratch / n), "bytes": (scratch / n).stat().st_size} for n in names}
        manifest = {
            "format": FORMAT,
            "scenario": record["scenario"]["name"],
            "version": target.name,
            "created": datetime.now(UTC).isoformat(timespec="seconds"),
            "content": content,
            "files": files,
        }
        atomic_write(scratch / MANIFEST, (json.dumps(manifest, indent=1, sort_keys=True) + "\n").encode())
        os.rename(scratch, target)
        sync_folder(target.parent)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return str(files[FILE_NAME]["sha256"])


def content_digest(record: Mapping[str, Any], labels: pd.DataFrame) -> str:
    """What makes two datasets the same: the units solved and the labels drawn from them, not when or where."""
    text = record["units_digest"] + labels[["speed", "cycle_duration", "split", "gait", "label"]].to_csv(index=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _card(version: str, record: Mapping[str, Any], labels: pd.DataFrame) -> str:
    scenario = record["scenario"]
    solved = labels[labels["status"] == "solved"]
    counts = solved.groupby(["split", "gait"]).size()
    cells = [(*key, count) for key, count in zip(counts.index.to_list(), counts, strict=True)]
    rows = "\n".join(f"| {split} | {gait} | {count} |" for split, gait, count in cells)
    return f"""# {scenario["name"]} {version}: solutions

{scenario["description"]}

{len(labels)} tasks, {len(solved)} of them with a feasible gait, from {record["units"]} units of work. Every row of
`{FILE_NAME}` is one pattern at one task; the cheapest gaits of each task keep their trajectory. `{LABELS}` has a row a
task, `{GAIT_COSTS}` the least cost of each gait at each task. Scenario, code version, package versions and processor
are in the Parquet metadata under `gaitflow`.

| tasks | gait | wins |
| --- | --- | --- |
{rows}

Read it:

```python
from gaitflow.dataset import load_solutions

for solution in load_solutions("datasets/{scenario["name"]}/{version}"):
    print(solution.speed, solution.cycle_duration, solution.pattern, solution.cost)
```

Licence: BSD-3-Clause, as the project.
"""
