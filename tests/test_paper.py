"""The paper's example: what it states, found from our own runs, and the demo that shows it."""

from __future__ import annotations

import json
from math import inf
from pathlib import Path

import numpy as np
import pytest

import pounding_risk as pr
from pounding_risk import figures, paper
from pounding_risk.study import AS_RECORDED, REVERSED


@pytest.fixture(scope="module")
def study():
    return paper.scene("paper")


@pytest.fixture(scope="module")
def runs(study):
    return paper.figure_8(study)


@pytest.fixture(scope="module")
def found(study):
    return paper.window(study)


def outputs(run) -> dict[str, float]:
    return json.loads(run.attrs["outputs"])


def test_the_scene_is_the_papers(study):
    """Masses, periods, gap, stiffness and window as printed in section 3 of the paper."""
    assert [b.mass for b in study.buildings] == [44360.0, 82600.0]
    assert [b.period for b in study.buildings] == [0.208, 0.007]
    assert (study.gap, study.stiffness, study.restitution_words) == (0.0, 4.2e10, "concrete")


def test_histories_are_identical_until_first_yield(runs):
    """Eq. (3) below F_E is eq. (2): the same numbers, to the bit, until the first yield at about 2.4 s."""
    plastic = runs[1]
    first = outputs(plastic)["first_yield_time"]
    assert 2.3 < first < 2.5
    before = [run.sel(time=slice(None, first - 1e-9)) for run in runs]
    # The last step before the yield ends on it in one run and passes it in the other.
    count = min(each.sizes["time"] for each in before) - 1
    for name in ("relative_displacement", "contact_force"):
        assert np.array_equal(before[0][name].values[:count], before[1][name].values[:count])


def test_then_the_peak_is_smaller(runs):
    peaks = [outputs(run)["peak_relative_displacement"] for run in runs]
    assert peaks[1] < 0.95 * peaks[0]
    assert all(outputs(run)["impact_count"] == 31 for run in runs)


def test_energy_closes_in_every_shipped_scene():
    for name in ("paper", "ensemble"):
        residual = pr.scan(paper.scene(name))["energy_residual"]
        assert float(residual.max()) < 1e-6


def test_energy_ledger_of_a_whole_run(runs):
    """W_ground = kinetic + strain + damping + contact, with the damping integrated apart: m 2ζω u̇² by trapezoid."""
    for run in runs:
        time, v = run["time"].values, run["velocity"].values
        taken = 0.0
        for side, (mass, period) in enumerate(((44360.0, 0.208), (82600.0, 0.007))):
            power = mass * 2.0 * 0.05 * (2.0 * np.pi / period) * v[:, side] ** 2
            taken += np.sum(0.5 * (power[1:] + power[:-1]) * np.diff(time))
        # The trapezoidal rule over steps of a tenth of the frame's period is good to some per cent.
        assert run["energy_damping"].values[-1] == pytest.approx(taken, rel=0.03)
        assert np.diff(run["energy_damping"].values).min() > -1e-9 * run["energy_ground"].values.max()


def test_window_of_yield_forces(found):
    """Inside it the statement holds; outside it, or with the record reversed, it does not."""
    assert 300e3 < found.low < 450e3 < found.high < 700e3
    line = found.searched.sel(polarity=AS_RECORDED).squeeze()
    force = line["yield_force"].values
    fits = paper.fitting(line)
    inside = (force >= found.low) & (force <= found.high)
    assert fits[inside].all() and not fits[(force > found.high) & (force < inf)].any()
    reversed_line = found.searched.sel(polarity=REVERSED).squeeze()
    without = float(reversed_line["peak_relative_displacement"].sel(yield_force=inf))
    assert (reversed_line["peak_relative_displacement"].values[inside] > without).all()


def test_figure_4_plateaus():
    """van Mier's findings: equal plateaus, longer for the heavier striker, none at 0.5 m/s."""
    slow, heavy, light = paper.figure_4()
    assert heavy.peak_force == light.peak_force == paper.STRIKER_STRENGTH
    assert figures._plateau(heavy) > 1.5 * figures._plateau(light) > 0.0
    assert slow.peak_force < 0.5 * paper.STRIKER_STRENGTH


def test_demo_writes_everything_and_says_what_it_found(tmp_path: Path):
    said: list[str] = []
    written = pr.demo(tmp_path / "out", said.append)
    assert {path.name for path in written.values()} == {path.name for path in (tmp_path / "out").iterdir()}
    assert all(path.stat().st_size > 10_000 for path in written.values())
    results = pr.open_results(written["ensemble.nc"])
    assert results.sizes["record"] == 5 and results.sizes["polarity"] == 2
    assert any("380 to 530 kN" in line for line in said)


def test_figures_state_their_numbers(runs, found):
    figure = figures.comparison_figure(list(runs))
    text = figure.get_suptitle()
    assert f"{outputs(runs[1])['peak_relative_displacement'] * 1e3:.2f} mm" in text
    assert f"{outputs(runs[1])['first_yield_time']:.2f} s" in text
    drawn = [figure, figures.window_figure(found.searched, (found.low, found.high)), figures.simulation_figure(runs[1])]
    drawn.append(figures.impact_figure(paper.figure_4()))
    for each in drawn:
        labels = [axes.get_ylabel() + axes.get_xlabel() for axes in each.axes]
        assert all("[" in label for label in labels), labels
        assert each.get_suptitle()


def test_figures_are_deterministic(found, tmp_path: Path):
    files = [tmp_path / name for name in ("a.png", "b.png")]
    for file in files:
        figures.window_figure(found.searched, (found.low, found.high)).savefig(file, metadata={"Software": None})
    assert files[0].read_bytes() == files[1].read_bytes()
