"""Two components turned: closed forms, ObsPy's own rotation, energy, RotD."""

from math import cos, radians, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from obspy.signal.rotate import rotate2zne, rotate_ne_rt
from sentences import refusal

from pounding_risk.motions import intensity as measures
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.read import read_motion
from pounding_risk.motions.rotation import rotated

ROUNDING = 1e-13  # of a sum of two products, on samples of order 1
angles = st.floats(-400.0, 400.0)


def pair(one: float | None, other: float | None, n: int = 60) -> tuple[Motion, Motion]:
    samples = np.random.default_rng(7).standard_normal((2, n))
    records = ({"azimuth": one, "event": "x"}, {"azimuth": other, "event": "x"})
    return tuple(Motion(name, a, 0.01, r) for name, a, r in zip("ab", samples, records, strict=True))  # type: ignore


@given(angles)
def test_obspy_turns_them_alike(direction):
    """Radial and transverse of ObsPy point away from a back-azimuth: radial at ba + 180°, transverse 90° past it."""
    north, east = pair(0.0, 90.0)
    radial, transverse = rotate_ne_rt(north.acceleration, east.acceleration, (direction + 180.0) % 360.0)
    np.testing.assert_allclose(rotated(north, east, direction).acceleration, radial, atol=ROUNDING)
    np.testing.assert_allclose(rotated(north, east, direction + 90.0).acceleration, transverse, atol=ROUNDING)


@given(st.floats(0.0, 360.0), st.floats(20.0, 160.0), angles)
def test_components_at_any_angle_are_obspys(first, between, direction):
    """`rotate2zne` inverts the matrix of the directions; a vertical completes it. Near 20° it amplifies rounding."""
    second = first + between
    one, other = pair(first, second)
    up = np.zeros_like(one.acceleration)
    sets = (one.acceleration, first, 0.0), (other.acceleration, second, 0.0), (up, 0.0, -90.0)
    _, north, east = rotate2zne(*(value for each in sets for value in each))
    expected = north * cos(radians(direction)) + east * sin(radians(direction))
    made = rotated(one, other, direction)
    if abs(between - 90.0) <= 2.0:  # taken as perpendicular
        assert np.abs(made.acceleration - expected).max() <= 1.2 * sin(radians(2.0)) * 4.0
    else:
        np.testing.assert_allclose(made.acceleration, expected, atol=100 * ROUNDING)
        assert "were solved for as such" in made.processing[-1]


@given(angles, st.floats(0.0, 360.0), st.sampled_from([90.0, 270.0]))
def test_energy_is_kept(direction, first, between):
    """a² along and across add up to a1² + a2², whichever hand the second component is at."""
    one, other = pair(first, first + between)
    along, across = (rotated(one, other, direction + turn).acceleration for turn in (0.0, 90.0))
    np.testing.assert_allclose(along**2 + across**2, one.acceleration**2 + other.acceleration**2, atol=1e-12)


def test_spectra_of_every_direction_are_those_of_rotd():
    """37 of 180 directions of a real recording, against measures.rotated_spectra: 1e-5, what its maxima may be off."""
    one, other = (read_motion(f"RSN77-{azimuth}", window=(0.0, 15.0)) for azimuth in (164, 254))
    periods = [0.3, 1.0]
    both = measures.rotated_spectra((one.acceleration, other.acceleration), one.dt, periods)
    turned = [rotated(one, other, 164.0 + angle) for angle in range(0, 180, 5)]
    ours = measures.response_spectra([m.acceleration for m in turned], one.dt, periods).pseudo_acceleration
    np.testing.assert_allclose(ours.T, both.acceleration[:, ::5], rtol=1e-5)
    np.testing.assert_allclose([m.pga for m in turned], both.pga[::5], rtol=1e-13)


def test_what_was_done_is_told():
    one, other = (read_motion(f"RSN6-{azimuth}") for azimuth in (180, 270))
    made = rotated(one, other, 225.0)
    assert made.name == "RSN6-180+RSN6-270@225" and made.record["azimuth"] == 225.0
    assert made.record["event"] == one.record["event"] and made.record["id"] == "RSN6-180 + RSN6-270"
    assert made.record["sha256"] == f"{one.record['sha256']} + {other.record['sha256']}"
    assert made.processing[-2] == "cut: 0 s from the start, 0.26 s from the end of RSN6-180"  # 5372 and 5346 samples
    told = "rotation: RSN6-180 times 0.707107 and RSN6-270 times 0.707107, to 225° clockwise from north, "
    assert made.processing[-1] == told + "from 180° and 270°"
    assert made.processing[0] == "RSN6-180: units: g, times 9.80665 m/s²"
    assert made.acceleration.size == other.acceleration.size


def test_two_earthquakes_are_told():
    one, other = read_motion("RSN6-180"), read_motion("RSN77-254")
    words = "RSN6-180 and RSN77-254 are not of one event, date and station"
    assert words in rotated(one, other, 30.0).flags
    assert rotated(one, read_motion("RSN6-270"), 30.0).flags == ()


def test_unknown_azimuths_count_from_the_first():
    one, other = pair(None, None)
    made = rotated(one, other, 90.0)
    np.testing.assert_allclose(made.acceleration, other.acceleration, atol=1e-15)
    assert made.flags == ("the azimuths are unknown: 90° counts from a",) and made.record["azimuth"] is None
    given = rotated(one, other, 90.0, azimuths=(90.0, 180.0))
    np.testing.assert_allclose(given.acceleration, one.acceleration, atol=1e-15)
    assert given.flags == () and given.record["azimuth"] == 90.0


def test_known_starts_align_them():
    """The second started 0.05 s later and records on for longer."""
    whole = np.random.default_rng(3).standard_normal(100)
    one = Motion("a", whole[:80], 0.01, {"azimuth": 0.0, "start": "2019-07-06T03:19:30.000000Z"})
    other = Motion("b", whole[5:], 0.01, {"azimuth": 90.0, "start": "2019-07-06T03:19:30.050000Z"})
    for made in (rotated(one, other, 45.0), rotated(other, one, 45.0)):
        np.testing.assert_allclose(made.acceleration, np.sqrt(2.0) * whole[5:80], atol=1e-14)
        assert made.record["start"] == "2019-07-06T03:19:30.050000Z"
        assert made.flags == ()
    late = Motion("b", whole, 0.01, {"azimuth": 90.0, "start": "2019-07-06T03:19:30.004000Z"})
    assert rotated(one, late, 45.0).flags == ("a and b are sampled 4 ms apart, and were not interpolated",)


def test_without_starts_what_was_cut_aligns_them():
    """Pads of unlike length before both, as a filter keeps them; the same samples as with starts."""
    whole = np.random.default_rng(3).standard_normal(100)
    one = Motion("a", np.pad(whole, (7, 0)), 0.01, {"azimuth": 0.0, "cut_from_start": -0.07})
    other = Motion("b", np.pad(whole, (12, 0)), 0.01, {"azimuth": 90.0, "cut_from_start": -0.12})
    for made in (rotated(one, other, 45.0), rotated(other, one, 45.0)):
        np.testing.assert_allclose(made.acceleration[7:], np.sqrt(2.0) * whole, atol=1e-14)
        assert not made.acceleration[:7].any() and made.flags == ()


def test_a_raw_recording_is_aligned_by_its_clock():
    """Windows that start at different times of one clock are brought together again."""
    one = read_motion("CCC-HN1", window=(30.0, 60.0), processing="none")
    other = read_motion("CCC-HN2", window=(31.0, 59.0), processing="none")
    made = rotated(one, other, 0.0)
    assert made.duration == pytest.approx(28.0) and made.record["start"] == other.record["start"]
    np.testing.assert_allclose(made.acceleration, one.acceleration[100:2901], atol=1e-12)


def test_nothing_is_turned_that_does_not_fit(says):
    one, other = pair(0.0, 90.0)
    coarse = Motion("coarse", other.acceleration, 0.02, other.record)
    late = Motion("late", other.acceleration, 0.01, {"azimuth": 90.0, "start": "2020-01-01T00:00:00Z"})
    early = Motion("early", one.acceleration, 0.01, {"azimuth": 0.0, "start": "2019-01-01T00:00:00Z"})
    up = Motion("up", other.acceleration, 0.01, {"azimuth": None})
    near = Motion("near", other.acceleration, 0.01, {"azimuth": 184.0})
    says([refusal(rotated, one, second, 30.0) for second in (coarse, up, near)])
    says(refusal(rotated, early, late, 30.0), refusal(rotated, one, other, float("nan")))


def test_doubts_say_which_component_they_are_of():
    made = Motion("a", np.array([0.0, 1.0, 0.0]), 0.01, {"azimuth": 0.0}, flags=("clipped",))
    other = Motion("b", np.array([0.0, 1.0, 0.0]), 0.01, {"azimuth": 90.0}, flags=("clipped",))
    assert rotated(made, other, 30.0).flags == ("a: clipped", "b: clipped")
