"""What travels with the package: robots, scenarios, sweeps, profiles, the workflow, the first files of a workspace.

In a checkout `configs`, `workflow` and `profiles` are links to the folders at its top; a wheel holds their files.
"""

from __future__ import annotations

from pathlib import Path

_HERE = Path(__file__).parent

ROBOTS = _HERE / "configs" / "robots"
SCENARIOS = _HERE / "configs" / "scenarios"
SWEEPS = _HERE / "configs" / "sweeps"
PROFILES = _HERE / "profiles"
SNAKEFILE = _HERE / "workflow" / "Snakefile"
WORKSPACE = _HERE / "workspace"
