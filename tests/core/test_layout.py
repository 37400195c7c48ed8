from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.config.scenario import load_scenario
from gaitflow.core.layout import Layout
from gaitflow.problem import transcribe

layouts = st.builds(
    Layout,
    dimension=st.sampled_from([2, 3]),
    legs=st.integers(1, 5),
    phases=st.integers(2, 6),
    knots_per_phase=st.integers(2, 5),
    weight=st.floats(1.0, 1e3),
    linear_forces=st.booleans(),
    grading=st.floats(0.0, 1.0),
    energy=st.booleans(),
)


@pytest.mark.parametrize("name", ["flat-effort", "flat-vibration", "slope20-vibration"])
def test_variable_counts_of_the_paper_in_the_plane(checkout: Path, name: str) -> None:
    """Section IV.B: 734 for a given gait and 742 for the MINLP."""
    problem = transcribe(load_scenario(checkout / f"configs/scenarios/half-cheetah-{name}.yaml"))
    assert problem.layout.nw == problem.nlp.numel_in(0) == 734
    assert problem.minlp.numel_in(0) == 742


def test_variable_counts_in_space(checkout: Path) -> None:
    """41 states of 24, 40 controls of 24 and 4 durations; a binary per leg and phase more for the MINLP."""
    problem = transcribe(load_scenario(checkout / "configs/scenarios/anymal-flat-vibration.yaml"))
    assert problem.layout.nw == problem.nlp.numel_in(0) == 1948
    assert problem.minlp.numel_in(0) == 1964


def test_linear_forces_add_those_at_the_ends_of_phases(checkout: Path) -> None:
    problem = transcribe(load_scenario(checkout / "configs/scenarios/half-cheetah-exact-effort.yaml"))
    assert problem.layout.linear_forces
    assert problem.layout.nw == problem.nlp.numel_in(0) == 734 + 4 * 2 * 2


@given(layouts)
def test_slices_cover_w_once(layout: Layout) -> None:
    slices = [layout.state(k) for k in range(layout.steps + 1)] + [layout.control(k) for k in range(layout.steps)]
    if layout.linear_forces:
        n = layout.knots_per_phase
        slices += [layout.end_force(p * n + n - 1, leg) for p in range(layout.phases) for leg in range(layout.legs)]
    if layout.energy:
        slices += [layout.contacts(leg) for leg in range(layout.legs)]
    used = np.concatenate([np.arange(layout.nw)[part] for part in [*slices, layout.fractions]])
    assert sorted(used) == list(range(layout.nw))


@given(layouts, st.integers(0, 2**32 - 1), st.floats(0.1, 5.0))
def test_pack_is_the_inverse_of_unpack(layout: Layout, seed: int, cycle: float) -> None:
    """But for the contacts, of which a trajectory knows nothing."""
    w = np.random.default_rng(seed).normal(size=layout.nw)
    w[layout.fractions.stop :] = 0.0
    trajectory = layout.unpack(w, cycle)
    np.testing.assert_allclose(layout.pack(trajectory, cycle), w, rtol=1e-14)
    assert trajectory.base.shape == (layout.steps + 1, layout.nb)
    assert trajectory.feet.shape == (layout.steps + 1, layout.legs, layout.dimension)
    for controls in (trajectory.forces, trajectory.end_forces, trajectory.foot_velocities):
        assert controls.shape == (layout.steps, layout.legs, layout.dimension)
    np.testing.assert_allclose(trajectory.times[-1], trajectory.durations.sum(), rtol=1e-12, atol=1e-12)


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
            ends = w[layout.end_force(step, leg)] * layout.weight
            np.testing.assert_array_equal(ends, trajectory.end_forces[step, leg])
            np.testing.assert_array_equal(w[layout.foot_velocity(step, leg)], trajectory.foot_velocities[step, leg])
    np.testing.assert_array_equal(w[layout.fractions] * cycle, trajectory.durations)


@given(layouts, st.integers(0, 2**32 - 1))
def test_forces_may_jump_between_phases_only(layout: Layout, seed: int) -> None:
    trajectory = layout.unpack(np.random.default_rng(seed).normal(size=layout.nw), 1.0)
    if not layout.linear_forces:
        np.testing.assert_array_equal(trajectory.end_forces, trajectory.forces)
        return
    jumps = np.abs(trajectory.end_forces[:-1] - trajectory.forces[1:]).max(axis=(1, 2)) > 0
    assert list(np.flatnonzero(jumps) + 1) == [p * layout.knots_per_phase for p in range(1, layout.phases)]


def test_unpacked_arrays_own_their_numbers() -> None:
    layout = Layout(2, 2, 4, 3, 137.0, linear_forces=True)
    w = np.ones(layout.nw)
    trajectory = layout.unpack(w, 1.0)
    trajectory.base[:] = 7.0
    trajectory.forces[:] = 7.0
    trajectory.end_forces[:] = 7.0
    assert (w == 1.0).all()


def test_knots_split_each_phase_evenly() -> None:
    times = Layout(2, 1, 3, 2, 1.0).times(np.array([0.2, 0.6, 0.1]))
    assert times == pytest.approx([0.0, 0.1, 0.2, 0.5, 0.8, 0.85, 0.9])


@pytest.mark.parametrize("grading", [0.3, 0.7, 1.0])
def test_graded_knots_are_finer_at_both_ends_of_a_phase(grading: float) -> None:
    layout = Layout(2, 1, 2, 10, 1.0, grading=grading)
    assert layout.shares.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(layout.shares, layout.shares[::-1], atol=1e-15)
    assert (np.diff(layout.shares[:5]) > 0).all()
    times = layout.times(np.array([0.2, 0.3]))
    assert times[[0, 10, 20]] == pytest.approx([0.0, 0.2, 0.5])


def test_the_first_step_by_hand() -> None:
    """Of ten: even a tenth, by a cosine (1 - cos 18 degrees) / 2."""
    cosine = (1 - np.cos(np.pi / 10)) / 2
    expected = {0.0: 0.1, 0.7: 0.03 + 0.7 * cosine, 1.0: cosine}
    for grading, share in expected.items():
        assert Layout(2, 1, 2, 10, 1.0, grading=grading).shares[0] == pytest.approx(share)


def test_a_scenario_older_than_linear_forces_has_held_ones() -> None:
    robot = {"dimension": 2, "mass": 14.0, "legs": [{}, {}]}
    layout = Layout.of({"robot": robot, "transcription": {"phases": 4, "knots_per_phase": 10}})
    assert (layout.linear_forces, layout.grading, layout.nw) == (False, 0.0, 734)
