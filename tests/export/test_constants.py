"""Numbers that the C++ planner has from Python are Python's."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from gaitflow.core import check
from gaitflow.runtime import atlas, condensed, gait_map, refine, rivals, starts
from gaitflow.solvers import interior_point, kkt, point

CONSTANTS = {
    "interior_point.hpp": {
        "row_limit": interior_point.ROWS, "cost_limit": interior_point.COST, "dual_limit": interior_point.DUAL,
        "gap": interior_point.GAP, "largest_row": interior_point.LARGEST_ROW, "nearest": interior_point.NEAREST,
        "near": interior_point.NEAR, "least_stiffness": interior_point.LEAST_STIFFNESS, "held": interior_point.HELD,
        "short_step": interior_point.SHORT, "largest_multiplier": interior_point.LARGEST_MULTIPLIER,
        "unmet": interior_point.UNMET, "largest_of_all": interior_point.LARGEST_OF_ALL,
        "nearly_met": interior_point.NEARLY_MET, "early": interior_point.EARLY,
    },
    "kkt.hpp": {
        "dual": kkt.DUAL, "primal": kkt.PRIMAL, "least_lift": kkt.LEAST_LIFT, "raise": kkt.RAISE,
        "corrections": kkt.CORRECTIONS, "rounding": kkt.ROUNDING, "refinements": kkt.REFINEMENTS,
    },
    "point.hpp": {"largest_log": point.LARGEST_LOG},
    "condensed.hpp": {"largest_log": condensed.LARGEST_LOG},
    "starts.hpp": {
        "nominal_barrier": starts.NOMINAL_BARRIER, "primal_barrier": starts.PRIMAL_BARRIER,
        "node_barrier": starts.NODE_BARRIER, "mean_barrier": refine.MEAN_BARRIER, "least_cost": refine.LEAST_COST,
    },
    "refine.hpp": {
        "feasible_within": check.FEASIBLE, "limit": refine.LIMIT, "rival_limit": refine.RIVAL_LIMIT,
        "first_starts": refine.FIRST_STARTS, "promising_starts": refine.PROMISING_STARTS,
        "rival_starts": refine.RIVAL_STARTS,
    },
    "planner.hpp": {
        "least_saving": rivals.LEAST_SAVING, "great_saving": rivals.GREAT_SAVING, "even": rivals.EVEN,
        "likely_few": rivals.LIKELY_FEW, "likely": rivals.LIKELY, "likely_wide": rivals.LIKELY_WIDE,
        "unlikely": rivals.UNLIKELY, "few_axes": rivals.FEW_AXES, "surprise": rivals.SURPRISE,
        "surprised": rivals.SURPRISED,
    },
    "atlas.hpp": {
        "hardly_tried": atlas.HARDLY_TRIED, "hardly": atlas.HARDLY, "near_axes": atlas.NEAR_AXES,
        "most_below": atlas.MOST_BELOW, "most_off": atlas.MOST_OFF, "least_chance": atlas.LEAST_CHANCE,
        "alike": atlas.ALIKE,
    },
    "gait_map.hpp": {"farthest": gait_map.FARTHEST},
}  # fmt: skip


@pytest.mark.parametrize("header", CONSTANTS)
def test_the_headers_have_python_s(checkout: Path, header: str) -> None:
    text = (checkout / "gaitflow/export/cpp" / header).read_text(encoding="utf-8")
    declared = re.findall(r"constexpr [\w:]+ ([^;]+);", text)
    found = {name: float(value) for each in declared for name, value in re.findall(r"(\w+) = ([\d.e-]+)(?:,|$)", each)}
    assert {name: found.get(name) for name in CONSTANTS[header]} == CONSTANTS[header]
