"""The card of a dataset, its README.md: what every column is, how to load it, how it was made, how to cite it.

The front matter is what the Hugging Face hub reads; its `configs` let `datasets` load each table by name.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gaitflow.publishing import citation
from gaitflow.publishing.dataset_facts import GAIT_COSTS, LABELS, DatasetFacts, Field, Table

KEPT_GAITS, KEPT_DEARER = 3, 0.15  # motions are kept of so many gaits of a task, as long as they are no dearer


def dataset_card(facts: DatasetFacts) -> str:
    """Markdown with YAML front matter, written from the facts and nothing else."""
    sections = (_front_matter, _what, _motions, _columns, _wins, _load, _made, _cite)
    return "\n".join(section(facts) for section in sections)


def _front_matter(facts: DatasetFacts) -> str:
    configs = "\n".join(f"- config_name: {table.name}\n  data_files: {table.file}" for table in facts.tables)
    default = f"- config_name: labels\n  data_files: {LABELS}"
    configs = configs.replace(default, f"{default}\n  default: true")
    return f"""---
license: bsd-3-clause
pretty_name: {facts.name} {facts.version}
tags:
- robotics
- legged-robots
- trajectory-optimization
configs:
{configs}
---
"""


def _what(facts: DatasetFacts) -> str:
    rows = "\n".join(f"| `{table.file}` | {table.rows} | {table.row} |" for table in facts.tables)
    return f"""# {facts.name} {facts.version}: solutions

{facts.scenario["description"]}

{facts.tasks} tasks over {", ".join(facts.axes)}; {facts.solved} of them have a feasible gait;
{facts.record["units"]} units of work.

| file | rows | a row |
| --- | --- | --- |
{rows}
"""


def _motions(facts: DatasetFacts) -> str:
    return f"""## Which rows have a motion

{facts.motions} of the {facts.tables[0].rows} rows of `{facts.tables[0].file}`: those where `base` is not null. Those of
a task's {KEPT_GAITS} cheapest gaits that are at most {KEPT_DEARER:.0%} dearer than the best keep their motion (fewer
gaits, or those of fewer tasks, where the file would be large), in the pattern that `{GAIT_COSTS}` names, with
multipliers to three digits; all other rows have nulls there.
"""


def _columns(facts: DatasetFacts) -> str:
    frame = (
        "SI units. The frame is the terrain's: x along the slope, z normal to it, the ground at z = 0. Arrays are flat "
        f"lists in row-major order; legs are {', '.join(leg['name'] for leg in facts.scenario['robot']['legs'])}."
    )
    return "\n".join(["## Columns", "", frame, "", *(_table(table) for table in facts.tables)])


def _table(table: Table) -> str:
    rows = [
        f"| `{one.name}` | {one.type} | {_shape(one)} | {one.column.unit} | {one.column.meaning} |"
        for one in table.fields
    ]
    return "\n".join([
        f"### {table.name}", "", "| column | type | shape | unit | meaning |", "| --- | --- | --- | --- | --- |",
        *rows, "",
    ])  # fmt: skip


def _shape(field: Field) -> str:
    return ", ".join("any" if size < 0 else str(size) for size in field.shape)


def _wins(facts: DatasetFacts) -> str:
    rows = "\n".join(f"| {split} | {gait} | {count} |" for (split, gait), count in facts.wins.items())
    return f"""## Best gaits

| tasks | gait | wins |
| --- | --- | --- |
{rows}
"""


def _load(facts: DatasetFacts) -> str:
    return f"""## Load it

From this folder, with pandas, polars, DuckDB, Hugging Face `datasets`, and with gaitflow, which checks the file's seal:

```python
import pandas as pd
labels = pd.read_parquet("{LABELS}")
print(labels.groupby("gait")["cost"].describe())
```

```python
import polars as pl
solutions = pl.scan_parquet("solutions.parquet").filter(pl.col("base").is_not_null())
print(solutions.select("speed", "cycle_duration", "gait", "cost", "base").collect())
```

```python
import duckdb
wins = duckdb.sql("SELECT gait, count(*) AS tasks FROM '{LABELS}' GROUP BY gait ORDER BY tasks DESC")
print(wins.fetchall())
```

```python
from os import getcwd
from datasets import load_dataset
labels = load_dataset(getcwd(), "labels", split="train")
```

```python
from gaitflow.dataset import load_solutions
for solution in load_solutions("."):
    print(solution.task.text(), solution.pattern, solution.cost)
```
"""


def _made(facts: DatasetFacts) -> str:
    makers = "\n".join(f"| {_maker(maker)} |" for maker in facts.record["made_by"])
    digest = facts.record["scenario_digest"]
    return f"""## How it was made

Every task was solved by gaitflow's search `{facts.scenario["strategy"]["name"]}`, on these machines; the metadata entry
`gaitflow` of the Parquet files has all of it, with the scenario whole and the solvers' options:

| code, machine, packages |
| --- |
{makers}

To make it again, check out that commit: `gaitflow solve {facts.name}`, then `gaitflow label {facts.name}`. The
scenario's SHA-256 is {digest}.
"""


def _maker(maker: Mapping[str, Any]) -> str:
    code, packages = maker["code"], ", ".join(f"{name} {version}" for name, version in maker["packages"].items())
    changed = " with uncommitted changes" if code.get("dirty") else ""
    where = f"{maker['cpu']}, {maker['system']}, Python {maker['python']}"
    return f"gaitflow {code['version']}, commit {code.get('commit', 'unknown')}{changed}; {where}; {packages}"


def _cite(facts: DatasetFacts) -> str:
    return f"""## Licence and citation

{citation.LICENCE}, as gaitflow itself. Please cite the paper, the software and this version:

```bibtex
{citation.PAPER}

{citation.software()}

{citation.dataset(facts.name, facts.version, facts.created[:4])}
```
"""
