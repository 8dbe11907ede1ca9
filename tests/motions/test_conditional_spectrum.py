"""Conditional spectra of OpenQuake, and the selection of records that have their mean and standard deviation."""

from __future__ import annotations

import numpy as np
import pytest
from damaged_tables import survey
from sentences import refusal
from test_selection import noise

from pounding_risk.errors import RecordError
from pounding_risk.motions.matching import Aim, Limits, correlation, match, simulated
from pounding_risk.motions.selection import select
from pounding_risk.motions.target_spectra import Target, read_conditional, read_target

G = 9.80665
PERIODS = np.geomspace(0.1, 2.0, 30)
WIDE = (
    "#,,,,\"generated_by='OpenQuake engine 3.13.0', imls=[0.6, 0.9], site_id=0, lon=23.7, lat=38.0\"\n"
    "sa_period,val0,std0,val1,std1\n"
    "0.0,0.4,0.3,0.5,0.28\n0.1,0.8,0.4,1.0,0.38\n0.5,0.6,1e-9,0.9,1e-9\n1.0,0.3,0.3,0.4,0.29\n2.0,0.12,0.6,0.2,0.55\n"
)
LONG = (
    "#,,,,\"generated_by='OpenQuake engine 3.21.0', site_id=0, lon=23.7, lat=38.0\"\npoe,stat,period,mea,std\n"
    "1.0E-01,mean,0.1,0.8,0.4\n1.0E-01,mean,0.5,0.6,0.01\n1.0E-01,mean,2.0,0.12,0.6\n"
    "2.0E-02,mean,0.1,1.0,0.38\n2.0E-02,mean,0.5,0.9,0.01\n2.0E-02,mean,2.0,0.2,0.55\n"
)


@pytest.mark.parametrize(
    ("text", "poe", "first", "count"),
    [(WIDE, "val0", 0.6, 5), (WIDE, "val1", 0.9, 5), (LONG, "0.1", 0.6, 3), (LONG, "0.02", 0.9, 3)],
)
def test_both_layouts_give_median_and_deviation(tmp_path, text, poe, first, count):
    path = tmp_path / "conditional-spectrum-0.csv"
    path.write_text(text)
    target = read_target(f"{path}#{poe}")
    assert target.at(0.5) == pytest.approx(first * G, rel=1e-12) and len(target.periods) == count
    assert target.pivot == 0.5 and target.deviation_at(0.5) < 0.011
    # by hand: between 0.5 and 2 s over ln(T), at 1 s half way, where the file has no row
    at_1s = 0.5 * (0.01 + 0.6 if poe == "0.1" else 0.01 + 0.55)
    assert target.deviation_at(1.0) == pytest.approx({"val0": 0.3, "val1": 0.29}.get(poe, at_1s))
    assert "conditional spectrum of OpenQuake at 23.7, 38.0" in target.origin
    assert target.name == f"conditional-spectrum-0#{poe}"


REFUSED = {
    "no probability chosen": (WIDE, ""),
    "another probability": (LONG, "#0.5"),
    "a negative ordinate": (LONG.replace("1.0,0.38", "-1.0,0.38"), "#0.02"),
    "a letter for a deviation": (LONG.replace("0.9,0.01", "0.9,x"), "#0.02"),
    "realisations": (LONG.replace("stat", "rlz_id").replace("mean,0.1", "1,0.1").replace("mean", "2"), "#0.02"),
    "no deviation": (WIDE.replace("std1", "dev1"), "#val1"),
    "a period twice": (WIDE.replace("0.1,0.8", "0.0,0.8"), "#val0"),
}


@pytest.mark.parametrize("words", REFUSED)
def test_files_that_cannot_be_used(tmp_path, says, words):
    (tmp_path / "cs.csv").write_text(REFUSED[words][0])
    says(refusal(read_target, f"{tmp_path / 'cs.csv'}{REFUSED[words][1]}"))
    says(refusal(read_target, f"{tmp_path / 'cs.csv'}{REFUSED[words][1] or '#val0'}", damping=0.03))


@pytest.mark.parametrize(("text", "poe"), [(WIDE, "val1"), (LONG, "0.02")])
@pytest.mark.complete
def test_damaged_files_are_read_soundly_or_refused_by_name(tmp_path, text, poe):
    path = tmp_path / "cs.csv"
    path.write_text(text)

    def check(spectrum):
        periods, median, deviation, _ = spectrum
        assert (median > 0.0).all() and (deviation >= 0.0).all() and (periods >= 0.0).all()

    outcomes = survey(path, lambda: read_conditional(path, poe), check, 1000)
    assert min(outcomes["read"], outcomes["refused"]) > 100


@pytest.mark.parametrize(
    ("first", "second", "value"),
    [(0.1, 0.5, 0.4745240873), (0.15, 0.5, 0.5734688765), (0.05, 0.15, 0.9153049738), (0.05, 0.1, 0.9421213925)],
)
def test_correlations_are_those_of_the_authors_program(first, second, value):
    """Numbers of Baker's MATLAB program, as openquake/hazardlib/tests/cross_correlation_test.py states them."""
    matrix = correlation(np.array([first, second]))
    np.testing.assert_allclose(matrix, [[1.0, value], [value, 1.0]], atol=1e-7)


def aim(pivot: float | None) -> Aim:
    spread = 0.6 * np.ones(30) if pivot is None else 0.45 * np.sqrt(np.abs(np.log(PERIODS / pivot)))
    return Aim(PERIODS, -0.8 * np.log(PERIODS), spread, pivot)


@pytest.mark.parametrize("pivot", [None, 0.5])
def test_simulated_spectra_have_mean_and_deviation_exactly(pivot):
    drawn = simulated(aim(pivot), 12)
    np.testing.assert_allclose(drawn.mean(axis=0), aim(pivot).mean, atol=1e-12)
    np.testing.assert_allclose(drawn.std(axis=0, ddof=1), aim(pivot).deviation, atol=1e-12)


def candidates(count: int = 300) -> np.ndarray:
    """ln Sa of made records: a level, a slope and a curvature over ln(T) each, and small ripples."""
    random = np.random.default_rng(7)
    x = np.log(PERIODS / 0.5)
    shapes = [random.normal(0, 0.7, count), random.normal(-0.7, 0.4, count), random.normal(0, 0.12, count)]
    return np.stack(shapes, axis=1) @ np.stack([np.ones(30), x, x**2]) + random.normal(0, 0.1, (count, 30))


@pytest.mark.parametrize("pivot", [None, 0.5])
def test_mean_and_deviation_are_matched(pivot):
    logs, wanted = candidates(), aim(pivot)
    fixed = None if pivot is None else wanted.mean[np.argmin(wanted.deviation)] - logs[:, np.argmin(wanted.deviation)]
    choices = match(logs, fixed, wanted, 20, Limits((0.1, 10.0)), ["one"] * len(logs))
    found = np.array([logs[one.position] + np.log(one.factor) for one in choices])
    assert len({one.position for one in choices}) == 20
    assert np.abs(found.mean(axis=0) - wanted.mean).max() < 0.06
    assert np.abs(found.std(axis=0, ddof=1) - wanted.deviation).max() < (0.2 if pivot is None else 0.12)
    if pivot is None:  # a closest fit to the mean leaves hardly any spread; the simulated levels bring it
        closest = logs + (wanted.mean - logs).mean(axis=1)[:, None]
        assert closest.std(axis=0, ddof=1).min() < 0.2 < found.std(axis=0, ddof=1).min()


def test_no_more_of_one_event_than_allowed():
    logs = candidates(40)
    events = [f"event {at % 4}" for at in range(40)]
    choices = match(logs, None, aim(None), 20, Limits((0.1, 10.0), 3), events)
    counts = np.unique([events[one.position] for one in choices], return_counts=True)[1]
    assert len(choices) == 12 and counts.tolist() == [3, 3, 3, 3]


def test_records_are_scaled_to_the_conditioning_period_and_told():
    periods = np.array([0.1, 0.5, 1.0])
    target = Target("cs", periods, np.array([6.0, 4.0, 2.0]), deviation=np.array([0.3, 0.0, 0.4]))
    motions = [noise(seed) for seed in range(30)]
    chosen = select(motions, target, periods=(0.2, 1.0), count=8, limits=(0.2, 5.0))
    np.testing.assert_allclose(chosen.spectra_at(np.array([0.5])), 4.0, rtol=1e-9)
    words = " ".join(chosen.words())
    assert "all scaled to the target at 0.5 s" in words and "off the target's, which is 0.0" in words
    closest = select(motions, Target("m", periods, target.acceleration), periods=(0.2, 1.0), count=8)
    goal = target.deviation_at(chosen.periods)
    assert np.abs(chosen.deviation - goal).mean() < np.abs(closest.deviation - goal).mean()
    with pytest.raises(
        RecordError, match=r"no record is left of 30: 30 for a factor to the target at 0.5 s outside the limits"
    ):
        select(motions, target, periods=(0.2, 1.0), count=8, limits=(50.0, 51.0))
