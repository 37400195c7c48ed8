from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from gaitflow.report.film import FRAMES_PER_SECOND, SLOWER, film

COLOUR = "#D55E00"


@pytest.fixture(scope="module")
def picture(solution_of, scenario) -> Image.Image:
    return Image.open(io.BytesIO(film(solution_of(1.5, 0.8, "gallop"), scenario, "gallop", COLOUR)))


def frames_of(picture: Image.Image) -> list[np.ndarray]:
    frames = []
    for number in range(picture.n_frames):
        picture.seek(number)
        frames.append(np.asarray(picture.convert("RGB"), dtype=float))
    return frames


def test_a_cycle_takes_as_long_as_it_says_and_starts_again(picture: Image.Image) -> None:
    assert picture.format == "GIF" and picture.info["loop"] == 0
    assert picture.n_frames == round(0.8 * SLOWER * FRAMES_PER_SECOND)
    assert picture.n_frames * picture.info["duration"] == pytest.approx(1000 * 0.8 * SLOWER)


def test_frames_move_and_the_last_one_leads_to_the_first(picture: Image.Image) -> None:
    frames = frames_of(picture)
    upper = [frame[: frame.shape[0] // 2] for frame in frames]  # without the bars' cursor, which jumps back
    changes = [np.abs(a - b).mean() for a, b in zip(upper, [*upper[1:], upper[0]], strict=True)]
    assert min(changes) > 0
    assert changes[-1] <= 1.5 * max(changes[:-1])
    assert np.abs(upper[0] - upper[len(upper) // 2]).mean() > np.median(changes)


def test_it_is_small_enough_for_a_page(solution_of, scenario) -> None:
    assert len(film(solution_of(1.5, 0.8, "gallop"), scenario, "gallop", COLOUR)) < 180_000


def test_a_solution_without_a_motion_is_refused(solution_of, scenario) -> None:
    with pytest.raises(ValueError, match="no trajectory"):
        film(replace(solution_of(1.5, 0.8, "gallop"), trajectory=None), scenario, "gallop", COLOUR)
