from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.problem import transcribe
from gaitflow.core.layout import Layout, knot_times

layouts = st.builds(
    Layout,
    dimension=st.sampled_from([2, 3]),
    legs=st.integers(1, 5),
    phases=st.integers(2, 6),
    knots_per_phase=st.integers(2, 5),
    weight=st.floats(1.0, 1e3),
)


@pytest.mark.parametrize("name", ["flat-effort", "flat-vibration", "slope20-vibration"])
def test_variable_counts_of_the_paper_in_the_plane(checkout: Path, name: str) -> None:
    """Section IV.B: 734 for a given gait and 742 for the MINLP."""
    problem = transcribe(load_scenario(checkout / f"configs/scenarios/half-cheetah-{name}.yaml"))
    assert problem.layout.nw == problem.nlp.numel_in(0) == 734
    assert problem.minlp.numel_in(0) == 742


def test_variable_counts_in_space(anymal: Scenario) -> None:
    """41 states of 24, 40 controls of 24 and 4 durations; a binary per leg and phase more for the MINLP."""
    problem = transcribe(anymal)
    assert problem.layout.nw == problem.nlp.numel_in(0) == 1948
    assert problem.minlp.numel_in(0) == 1964


@given(layouts)
def test_slices_cover_w_once(layout: Layout) -> None:
    slices = [layout.state(k) for k in range(layout.steps + 1)] + [layout.control(k) for k in range(layout.steps)]
    used = np.concatenate([np.arange(layout.nw)[part] for part in [*slices, layout.fractions]])
    assert sorted(used) == list(range(layout.nw))


@given(layouts, st.integers(0, 2**32 - 1), st.floats(0.1, 5.0))
def test_pack_is_the_inverse_of_unpack(layout: Layout, seed: int, cycle: float) -> None:
    w = np.random.default_rng(seed).normal(size=layout.nw)
    trajectory = layout.unpack(w, cycle)
    np.testing.assert_allclose(layout.pack(trajectory, cycle), w, rtol=1e-14)
    assert trajectory.base.shape == (layout.steps + 1, layout.nb)
    assert trajectory.feet.shape == (layout.steps + 1, layout.legs, layout.dimension)
    assert trajectory.forces.shape == trajectory.foot_velocities.shape == (layout.steps, layout.legs, layout.dimension)
    np.testing.assert_allclose(trajectory.times[-1], trajectory.durations.sum(), rtol=1e-12)


@given(layouts, st.integers(0, 2**32 - 1), st.floats(0.1, 5.0))
def test_named_slices_hold_what_they_say(layout: Layout, seed: int, cycle: float) -> None:
    w = np.random.default_rng(seed).normal(size=layout.nw)
    trajectory = layout.unpack(w, cycle)
    for knot in range(layout.steps + 1):
        np.testing.assert_array_equal(w[layout.state(knot)][: layout.nb], trajectory.base[knot])
        for leg in range(layout.legs):
            np.testing.assert_array_equal(w[layout.foot(knot, leg)], trajectory.feet[knot, leg])
    for step in range(layout.steps):
        for leg in range(layout.legs):
            np.testing.assert_array_equal(w[layout.force(step, leg)] * layout.weight, trajectory.forces[step, leg])
            np.testing.assert_array_equal(w[layout.foot_velocity(step, leg)], trajectory.foot_velocities[step, leg])
    np.testing.assert_array_equal(w[layout.fractions] * cycle, trajectory.durations)


def test_unpacked_arrays_own_their_numbers(planar: Scenario) -> None:
    layout = transcribe(planar).layout
    w = np.ones(layout.nw)
    trajectory = layout.unpack(w, 1.0)
    trajectory.base[:] = 7.0
    trajectory.forces[:] = 7.0
    assert (w == 1.0).all()


def test_knots_split_each_phase_evenly() -> None:
    times = knot_times(np.array([0.2, 0.6, 0.1]), 2)
    assert times == pytest.approx([0.0, 0.1, 0.2, 0.5, 0.8, 0.85, 0.9])
