"""Buildings that pound under pulses are self-similar: scaled responses depend on dimensionless groups alone."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

SCRIPT = runpy.run_path(str(Path(__file__).resolve().parents[2] / "docs" / "generation" / "similarity.py"))
PULSES, peaks = SCRIPT["PULSES"], SCRIPT["peaks"]


@pytest.mark.parametrize("law", ["kelvin_voigt", "jankowski"])
@pytest.mark.parametrize("ratio", [0.4, 0.9, 1.7])
def test_peaks_under_pulses_collapse(tmp_path, law: str, ratio: float):
    """Dimitrakopoulos, Kappos and Makris (2009): time and amplitude scaled, at rtol 1e-9; and they do pound."""
    found = np.array([peaks(tmp_path, law, amplitude, duration, ratio) for amplitude, duration in PULSES])
    amplitudes, durations = np.array(PULSES).T
    assert (found[:, 3] == found[0, 3]).all() and found[0, 3] >= 1
    scale = np.column_stack([amplitudes * durations**2, amplitudes * durations**2, amplitudes])
    scaled = found[:, :3] / scale
    np.testing.assert_allclose(scaled, scaled[[0, 0, 0]], rtol=1e-7)
    assert (np.ptp(found[:, :3], axis=0) > 0.5 * found[0, :3]).all()  # the peaks themselves differ
