"""Ten gaps, contact counts and multiples of the study of codes' gaps, by state transitions of NumPy and SciPy alone."""

import json
from itertools import combinations, pairwise
from math import ceil, hypot, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

import pounding_risk as pr

PERIODS = (0.1, 0.5, 0.9, 1.3, 3.0)
PAIRS = list(combinations(range(len(PERIODS)), 2))
NAMES = ["RSN6-180", "RSN77-254", "RSN753-000", "RSN1690-090", "NAPA-HNE"]
PARTS = 16  # of a sample


def displacement(acceleration: np.ndarray, dt: float, period: float, damping: float) -> np.ndarray:
    """Of an oscillator at rest, at parts of the samples, the ground's acceleration straight between these."""
    omega = 2.0 * pi / period
    system = np.zeros((4, 4))
    system[0, 1] = system[2, 3] = 1.0
    system[1] = -(omega**2), -2.0 * damping * omega, -1.0, 0.0
    advances = np.array([expm(system * dt * part / PARTS) for part in range(1, PARTS + 1)])
    state, found = np.zeros(2), [np.zeros(1)]
    for first, second in pairwise(acceleration):
        parts = advances @ np.array([*state, first, (second - first) / dt])
        found.append(parts[:, 0])
        state = parts[-1, :2]
    return np.concatenate(found)


@pytest.fixture(scope="module")
def histories() -> dict[str, list[np.ndarray]]:
    """Displacements of the five oscillators under each motion."""
    motions = [pr.read_motion(name, pga="0.3 g") for name in NAMES]
    return {
        name: [displacement(motion.acceleration, motion.dt, period, 0.05) for period in PERIODS]
        for name, motion in zip(NAMES, motions, strict=True)
    }


@pytest.fixture(scope="module")
def gaps() -> Any:
    """The same by the package, both directions of each motion."""
    records = pr.Records(NAMES, pga="0.3 g", polarity=["as recorded", "reversed"])
    return pr.spectra(records, periods=list(PERIODS), damping=0.05, percentiles=[50], motions=True)


def functions_of(notebook: Path) -> dict[str, Any]:
    """The functions of the study, from the cell of its notebook that has its table, without what that prints."""
    cells = ["".join(cell["source"]) for cell in json.loads(notebook.read_text("utf-8"))["cells"]]
    source = next(cell for cell in cells if "def asked_in" in cell)
    names = {"np": np, "pr": pr, "PGA": 0.3, "HIGHEST": {"china": 35.0}}
    exec(source[: source.index("\nfor z, d in")], names)
    return names


def test_ten_gaps(histories, gaps):
    """Peaks between parts of a sample are missed by (ω h)² / 8, at 0.1 s and 0.625 ms 2e-4; twice for a difference."""
    needed = gaps["required_gap_of_motion"].sel(polarity="as recorded")
    for place, (one, other) in enumerate(PAIRS):
        name = NAMES[place % len(NAMES)]
        sides = histories[name][one], histories[name][other]
        found = needed.sel(record=name).isel(left_period=one, right_period=other).item()
        assert found == pytest.approx((sides[0] - sides[1]).max(), rel=5e-4)
        peaks = [gaps[f"{side}_displacement_of_record"].sel(record=name) for side in ("left", "right")]
        known = [peaks[0].isel(left_period=one).item(), peaks[1].isel(right_period=other).item()]
        assert known == pytest.approx([np.abs(side).max() for side in sides], rel=5e-4)


def test_contact_counts_and_multiples_of_the_study(histories, gaps, root):
    """P(contact), and multiples of the gap, at every pair: of SRSS, and of China's rule, which goes by heights.

    Gaps are off by 5e-4 at most, so that a motion which needs as much as that counts or not.
    """
    study = functions_of(root / "notebooks" / "code_gaps.ipynb")
    needed, peaks = study["needed_in"](gaps)
    both = gaps["left_period"].values[list(study["pairs_of"](gaps))]
    asked = study["asked_in"](both, 0.05, np.median(peaks, axis=(0, 1)))
    srss, china = asked["srss"], asked["china"]
    medians = [
        sorted(float(np.abs(histories[name][k]).max()) for name in NAMES)[len(NAMES) // 2] for k in range(len(PERIODS))
    ]
    unsure = 0
    order = [(long, short) for long in range(len(PERIODS)) for short in range(long)]
    for place, (long, short) in enumerate(order):
        needs = []
        for name in NAMES:
            difference = histories[name][long] - histories[name][short]
            needs += [max(difference.max(), 0.0), max(-difference.min(), 0.0)]
        lower = (PERIODS[short] / 0.0466) ** (1.0 / 0.9)  # m
        known = hypot(medians[long], medians[short]), 0.1 + 0.02 * max(lower - 15.0, 0.0) / 3.0
        tallest = (PERIODS[long] / 0.0466) ** (1.0 / 0.9)
        assert np.isnan(china[place]) == (tallest > 35.0)
        for gap, rule in zip(known, (srss, china), strict=True):
            if np.isnan(rule[place]):
                continue
            assert rule[place] == pytest.approx(gap, rel=5e-4)
            found = study["summary"](needed[..., [place]], [rule[[place]]])[0]
            least, most = (sum(need > gap * share for need in needs) for share in (1.0 + 5e-4, 1.0 - 5e-4))
            assert least <= round(len(needs) * found[0]) <= most <= least + 1
            unsure += most - least
            # So many of the ten motions need no more.
            ranks = [ceil(round((1.0 - target) * len(needs), 9)) for target in (0.16, 0.10, 0.02)]
            assert found[1:] == pytest.approx([sorted(needs)[rank - 1] / gap for rank in ranks], rel=5e-4)
    assert unsure <= 2
