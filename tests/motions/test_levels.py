"""Levels of intensity: the measure of a scaled motion, found by other means, is the level."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson
from scipy.signal import StateSpace, lsim

from pounding_risk.errors import RecordError
from pounding_risk.motions.levels import Level, Measure, driven, read_measure, say_level
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.read import read_motion
from pounding_risk.motions.scaling import PGV
from pounding_risk.units import PGA

RANGES = ("sa_avg(200 ms-2 s)", "sa_avg(0.2 s to 2 s)", "sa_avg(2e-1-2 s)")  # other ways to write one
CRESTS = 2e-4  # of a peak at instants a fortieth of a step apart, which lie beside the local maximum


@pytest.fixture(scope="module")
def record() -> Motion:
    return read_motion("RSN6-180").cut("0 s", "8 s")


def finely(motion: Motion, parts: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Instants [s] between the samples, and the acceleration at each, linear between the samples."""
    times = np.linspace(0.0, motion.duration, parts * (motion.acceleration.size - 1) + 1)
    return times, np.interp(times, motion.times, motion.acceleration)


def spectral(motion: Motion, period: float, damping: float) -> float:
    """ω² max|u| by SciPy's simulation of the oscillator."""
    omega = 2.0 * np.pi / period
    oscillator = StateSpace([[0.0, 1.0], [-(omega**2), -2.0 * damping * omega]], [[0.0], [-1.0]], [[1.0, 0.0]], [[0.0]])
    times, ground = finely(motion)
    return float(omega**2 * np.abs(lsim(oscillator, ground, times)[1]).max())


@pytest.mark.parametrize(("period", "damping"), [(0.5, 0.05), (1.3, 0.02)])
def test_sa_of_the_scaled_motion_is_the_level(record, period, damping):
    scaled = Level(Measure("sa", (period,), damping), 3.0).of(record)
    assert spectral(scaled, period, damping) == pytest.approx(3.0, rel=CRESTS)


def test_the_geometric_mean_over_the_range_is_the_level(record):
    """Ten periods from 0.2 to 2 s, evenly in the logarithm, each by SciPy."""
    scaled = Level(Measure("sa_avg", (0.2, 2.0)), 3.0).of(record)
    periods = [0.2 * 10.0 ** (step / 9.0) for step in range(10)]
    values = [spectral(scaled, period, 0.05) for period in periods]
    assert np.prod(values) ** 0.1 == pytest.approx(3.0, rel=CRESTS)


def test_the_largest_velocity_is_the_level(record):
    scaled = Level(Measure("pgv"), 0.4).of(record)
    times, ground = finely(scaled)
    assert np.abs(cumulative_simpson(ground, x=times)).max() == pytest.approx(0.4, rel=1e-6)
    assert "to PGV of 40 cm/s" in scaled.processing[-1]


@pytest.mark.parametrize("measure", [Measure("pgv"), Measure("sa", (0.7,)), Measure("sa_avg", (0.2, 1.0))])
def test_the_factor_is_level_over_value_whatever_the_polarity(record, measure):
    value = measure.of([record])[0]
    for polarity, sign in (("as recorded", 1.0), ("reversed", -1.0)):
        scaled = driven(record, polarity, Level(measure, 2.5 * value))
        np.testing.assert_allclose(scaled.acceleration, sign * 2.5 * record.acceleration, rtol=1e-14)
        assert scaled.record["factor"] == pytest.approx(2.5, rel=1e-14)


@pytest.mark.parametrize("measure", [Measure("pgv"), Measure("sa", (3.0,), 0.0), Measure("sa_avg", (2.0, 4.0), 0.0)])
def test_a_tail_of_zeros_is_no_part_of_the_record(record, measure):
    """An undamped oscillator of a long period moves most after the record, which `sa` of a scene does not count."""
    short = record.cut("0 s", "3 s")
    longer = short.with_tail("9 s")
    assert measure.of([longer])[0] == measure.of([short])[0]
    scaled, alone = Level(measure, 1.0).of(longer), Level(measure, 1.0).of(short)
    np.testing.assert_array_equal(scaled.acceleration[: alone.acceleration.size], alone.acceleration)
    assert scaled.tail == longer.tail == longer.acceleration.size - short.acceleration.size > 0
    assert longer.first(short.acceleration.size + 5).tail == 5
    np.testing.assert_array_equal(longer.without_tail().acceleration, short.acceleration)


def test_a_factor_is_one_and_pga_is_as_before(record):
    np.testing.assert_array_equal(Level(Measure("scale"), 1.7).of(record).acceleration, 1.7 * record.acceleration)
    np.testing.assert_array_equal(Level(Measure(), 3.0).of(record).acceleration, record.scaled_to(3.0).acceleration)
    np.testing.assert_array_equal(driven(record, "as recorded", None).acceleration, record.acceleration)


@pytest.mark.parametrize("measure", [Measure("pgv"), Measure("sa", (0.7,)), Measure("sa_avg", (0.2, 1.0))])
def test_still_ground_has_no_level(measure):
    still = Motion("still", np.zeros(100), 0.01, {})
    assert measure.of([still])[0] == 0.0
    with pytest.raises(RecordError, match=r"still: what is to be scaled is 0, which no factor scales"):
        Level(measure, 1.0).of(still)


@pytest.mark.parametrize(
    ("word", "measure"),
    [
        ("pga", Measure()),
        ("pgv", Measure("pgv")),
        ("scale", Measure("scale")),
        ("sa(0.5 s)", Measure("sa", (0.5,))),
        ("sa(0.5 s, 2 %)", Measure("sa", (0.5,), 0.02)),
        ("sa_avg(0.2-2 s)", Measure("sa_avg", (0.2, 2.0))),
        ("sa_avg(0.2-2 s, 2 %)", Measure("sa_avg", (0.2, 2.0), 0.02)),
        *((word, Measure("sa_avg", (0.2, 2.0))) for word in RANGES),
        *((word, None) for word in ("pgd", "sa", "sa(left)", "sa(0.5)", "sa_avg(2-0.2 s)", "sa_avg(0.2 s)", "sa_avg")),
    ],
)
def test_a_measure_is_read_from_its_word(word, measure):
    assert measure is None or word in RANGES or measure.intensity == word
    assert read_measure(word) == measure


def test_values_are_said_in_the_units_of_the_trade():
    assert (say_level(0.4, PGV), say_level(0.2 * 9.80665, PGA)) == ("40 cm/s", "0.2 g")
    assert Measure("sa_avg", (0.2, 2.0), 0.02).words == "Sa_avg(0.2-2 s, 2 %)"
