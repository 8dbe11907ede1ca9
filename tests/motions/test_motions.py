"""Records in, motions out: published peaks, exact scaling, and the sentence of every refusal.

The names of `pounding_risk.motions` are found, imported late, and have documented parameters.
"""

import gzip
import shutil
import subprocess
import sys

import numpy as np
import obspy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sentences import refusal

from pounding_risk import motions
from pounding_risk.errors import RecordError
from pounding_risk.motions import catalogue
from pounding_risk.motions.formats.geonet import _read_geonet
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.processing import DEFAULT_CHAIN, Step, known_steps
from pounding_risk.motions.processing.signals import butterworth, onset
from pounding_risk.motions.read import read_motion, read_stream, read_trace
from pounding_risk.motions.rotation import rotated
from pounding_risk.motions.write import write_motion

G = 9.80665
HALF_G = 0.5 * G
# The corners that the U.S. Geological Survey's gmprocess chose for this recording from its noise.
GMPROCESS = [
    {"step": "mean"},
    {"step": "taper"},
    {"step": "bandpass", "low": "0.0618 Hz", "high": "37.5 Hz"},
    {"step": "baseline", "order": 6},
]
RAW = [entry.id for entry in catalogue.entries() if entry.state == "raw"]
PROCESSED = [entry.id for entry in catalogue.entries() if entry.state == "processed"]


def peaks(motion):
    """PGA [g], PGV [cm/s], PGD [cm], last displacement over PGD."""
    velocity, displacement = motion.velocity_displacement()
    pgd = np.abs(displacement).max()
    return motion.pga / G, 100 * np.abs(velocity).max(), 100 * pgd, displacement[-1] / pgd


# --- the paper's input ------------------------------------------------------------------------------------


def test_el_centro_as_the_paper_uses_it(says):
    motion = read_motion("RSN6-180", window=(0.0, 6.0), pga=HALF_G)
    assert len(motion.acceleration) == 601
    assert motion.duration == pytest.approx(6.0)
    assert motion.pga == pytest.approx(HALF_G, rel=1e-12)
    assert motion.record["pga_recorded"] / G == pytest.approx(0.2808, abs=5e-5)
    assert motion.record["sha256"] == catalogue.entry("RSN6-180").sha256
    assert motion.flags == ()
    says(motion.processing)


@pytest.mark.parametrize(
    ("record", "window", "samples"),
    [("RSN6-180", (1.0, 6.0), slice(100, 601)), ("CCC-HN1", (20.0, 60.0), slice(2000, 6001))],
)
def test_a_processed_record_and_a_raw_one_are_cut_after_their_chain(record, window, samples):
    whole, part = read_motion(record), read_motion(record, window=window)
    assert np.array_equal(part.acceleration, whole.acceleration[samples])
    assert part.processing[:-1] == whole.processing


@pytest.mark.parametrize("extra", [[], [{"step": "bandpass", "low": "0.1 Hz", "high": "25 Hz"}]], ids=["", "filter"])
def test_el_centro_with_baseline_correction(extra):
    steps = [*extra, {"step": "baseline"}]
    motion = read_motion("RSN6-180", window=("0 s", "6 s"), pga="0.5 g", processing=steps)
    assert motion.pga == pytest.approx(HALF_G, rel=1e-12)
    assert len(motion.acceleration) == 601
    assert any(sentence.startswith("baseline: ") for sentence in motion.processing)
    as_published = read_motion("RSN6-180", window=(0.0, 6.0), pga=HALF_G).acceleration
    assert np.abs(motion.acceleration - as_published).max() < 0.02 * HALF_G


def test_published_velocity_and_displacement_of_el_centro():
    pga, pgv, pgd, _ = peaks(read_motion("RSN6-180"))
    assert (pga, pgv, pgd) == pytest.approx((0.2808, 30.9, 8.7), rel=0.005)


# --- raw records ------------------------------------------------------------------------------------------


def test_the_raw_record_drifts():
    """As distributed, 150 of 354 s; the mean before the earthquake makes it worse: the baseline shifts."""
    raw = read_motion("CCC-HN1", processing="none")
    assert np.abs(raw.acceleration - raw.acceleration.mean()).max() / G == pytest.approx(0.4711, abs=5e-5)
    assert raw.velocity_displacement()[1][-1] == pytest.approx(12.2165, abs=1e-3)
    less_mean = read_motion("CCC-HN1", processing=[{"step": "mean"}])
    assert less_mean.velocity_displacement()[1][-1] < -15.0


@pytest.mark.parametrize(
    ("record", "low", "pga", "off_pga", "others", "off"),
    [
        ("CCC-HN1", "0.0618 Hz", 0.4701, 1e-4, (78.1, 28.0), 0.005),
        ("CCC-HN2", "0.0618 Hz", 0.5604, 1e-4, (41.8, 25.9), 0.005),
        ("CCC-HNZ", "0.0247 Hz", 0.3607, 0.02 * 0.3607, (16.9, 4.0), 0.02),  # the vertical with its own corner
    ],
)
def test_the_chain_gives_gmprocess_peaks(record, low, pga, off_pga, others, off):
    steps = [{**step, "low": low} if "low" in step else step for step in GMPROCESS]
    found_pga, pgv, pgd, rest = peaks(read_motion(record, processing=steps))
    assert found_pga == pytest.approx(pga, abs=off_pga)
    assert (pgv, pgd) == pytest.approx(others, rel=off)
    assert abs(rest) < 0.02


@pytest.mark.parametrize(("record", "pga"), [("NAPA-HNE", 0.373), ("NAPA-HNN", 0.339), ("NAPA-HNZ", 0.215)])
def test_the_default_chain_gives_the_published_napa_peaks(record, pga):
    assert read_motion(record).pga / G == pytest.approx(pga, abs=6e-4)


@pytest.mark.parametrize("record", RAW)
def test_the_default_chain_brings_every_raw_record_to_rest(record):
    motion = read_motion(record)
    velocity, displacement = motion.velocity_displacement()
    assert abs(displacement[-1]) < 0.02 * np.abs(displacement).max()
    assert abs(velocity[-1]) < 0.005 * np.abs(velocity).max()
    assert motion.flags == ()
    assert [sentence.split(":")[0] for sentence in motion.processing] == [
        "units", *(step.name for step in DEFAULT_CHAIN)
    ]  # fmt: skip


@pytest.mark.parametrize("record", RAW)
def test_the_arrival_is_seen_on_every_component(record):
    trace = catalogue.load(record)[0]
    expected = 22.5 if record.startswith("CCC") else 25.2  # P wave: 34 km and 4 km from the epicentre
    assert onset(trace.data, trace.stats.delta) == pytest.approx(expected, abs=0.3)


@pytest.mark.parametrize("record", PROCESSED)
def test_processed_records_are_left_alone(record):
    assert np.array_equal(read_motion(record).acceleration, catalogue.load(record)[0].data)


# --- one door ---------------------------------------------------------------------------------------------


def test_id_path_and_trace_agree(tmp_path):
    copy = tmp_path / "mine.AT2"
    shutil.copy(catalogue.path("RSN6-180"), copy)
    motions = [read_motion(given) for given in ("RSN6-180", copy, str(copy), catalogue.load("RSN6-180")[0])]
    assert all(np.array_equal(motion.acceleration, motions[0].acceleration) for motion in motions)
    assert [motion.name for motion in motions[:3]] == ["RSN6-180", "mine", "mine"]
    assert motions[1].record["sha256"] == motions[0].record["sha256"]
    assert motions[1].record["event"] == "Imperial Valley-02"


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 32767), st.integers(0, 127)), min_size=1, max_size=4))
def test_a_damaged_miniseed_file_is_refused_or_whole(tmp_path_factory, changes):
    folder = tmp_path_factory.getbasetemp()  # bytes stay below 128: ObsPy prints tracebacks at others
    shutil.copy(catalogue.records_folder() / "CI.CCC.xml", folder)
    raw = bytearray(catalogue.path("CCC-HN1").read_bytes())
    for place, value in changes:
        raw[place] = value
    (folder / "damaged.mseed").write_bytes(raw)
    try:
        motion = read_motion(folder / "damaged.mseed", processing="none")
    except RecordError as error:
        assert str(folder) in str(error)
        return
    assert np.isfinite(motion.acceleration).all()
    assert len(motion.acceleration) == 15000


def test_a_stream_goes_in_and_a_stream_comes_out(root, tmp_path):
    """Every component of a file, as ObsPy has it; a raw trace of our readers stays raw in anyone's hands."""
    path = tmp_path / "THZ.V1A"
    path.write_bytes(gzip.decompress((root / "tests/data/formats/geonet-thz.v1a.gz").read_bytes()))
    stream = read_stream(path)
    assert [trace.stats.record.component for trace in stream] == ["S90E", "N00E", "Up"]
    assert all("bandpass" in " ".join(trace.stats.processing) for trace in stream)
    for trace in stream:
        motion = read_motion(f"{path}#{trace.stats.record.component}")
        assert np.array_equal(trace.data, motion.acceleration)
    raw = _read_geonet(path)
    again = read_stream(raw)
    assert [trace.stats.npts for trace in raw] == [trace.stats.npts for trace in again]
    assert all(np.array_equal(one.data, other.data) for one, other in zip(stream, again, strict=True))
    assert np.array_equal(read_stream("RSN6-180")[0].data, read_motion("RSN6-180").acceleration)


def test_the_history_is_in_the_trace_and_in_the_motion(says):
    choices = {"window": (0.0, 6.0), "pga": HALF_G, "polarity": "reversed", "tail": 2.0}
    motion, trace = read_motion("RSN6-180", **choices), read_trace("RSN6-180", **choices)
    assert tuple(trace.stats.processing) == motion.processing
    says(motion.processing)
    assert np.array_equal(trace.data, motion.acceleration)
    assert len(motion.acceleration) == 802
    assert not motion.acceleration[601:].any()


@pytest.mark.parametrize(("asked", "zeros"), [(0.0, 0), (0.05, 1), (0.2, 1), (0.3, 2), (0.31, 2), (0.6, 3), (1.0, 5)])
@pytest.mark.parametrize("last", [0.0, -0.3])
def test_a_tail_is_never_shorter_than_asked_for(asked, zeros, last):
    """Whole steps of 0.2 s, rounded up; a motion that ends off zero first goes to it over one step."""
    motion = Motion("m", np.array([1.0, 0.5, last]), 0.2, {}).with_tail(asked)
    off_zero = int(last != 0.0 and asked > 0.0)
    assert motion.tail == zeros + off_zero and motion.acceleration.size == 3 + zeros + off_zero
    np.testing.assert_array_equal(motion.without_tail().acceleration, [1.0, 0.5, last])


def test_a_motion_lasts_until_the_last_building_has_had_it():
    """Whole steps, rounded up; what stands for one lag goes with another, and the tail and the intensity stay."""
    motion = Motion("m", np.array([1.0, 0.5, -0.3]), 0.2, {}).with_tail(0.4)
    for lag, zeros in ((0.0, 0), (0.2, 1), (0.21, 2), (0.6, 3), (0.05, 1)):
        motion = motion.reaching(lag)
        assert (motion.late, motion.tail, motion.acceleration.size) == (zeros, 3 + zeros, 6 + zeros)
        assert not motion.acceleration[3:].any() and motion.without_tail().acceleration.size == 3


def test_a_trace_keeps_its_history_and_its_samples():
    trace = catalogue.load("RSN6-180")[0].detrend("demean")
    before = trace.copy()
    motion = read_motion(trace, scale=2.0)
    assert trace == before
    assert "detrend" in motion.processing[0]
    assert motion.processing[-1].startswith("scale: times 2,")


@pytest.mark.parametrize("record", [entry.id for entry in catalogue.entries()])
def test_scaling_is_exact(record):
    motion = read_motion(record, pga=HALF_G)
    assert abs(motion.pga - HALF_G) <= 1e-12 * HALF_G
    assert abs(motion.scaled_to(1.0).pga - 1.0) <= 1e-12


def test_a_motion_turns_scales_and_swings_out():
    motion = read_motion("RSN6-180", window=(0.0, 6.0))
    turned = motion.reversed()
    assert np.array_equal(turned.acceleration, -motion.acceleration)
    assert (motion.record["polarity"], turned.record["polarity"]) == ("as recorded", "reversed")
    assert np.array_equal(turned.reversed().acceleration, motion.acceleration)
    assert motion.with_tail(3.0).duration == pytest.approx(9.01)
    assert np.array_equal(motion.scaled_to("0.5 g").acceleration, read_motion(
        "RSN6-180", window=(0.0, 6.0), pga=HALF_G).acceleration)  # fmt: skip
    assert motion.times[-1] == pytest.approx(6.0)
    with pytest.raises(ValueError, match="read-only"):
        motion.acceleration[0] = 1.0


# --- refusals and doubts ----------------------------------------------------------------------------------


def changed(**stats):
    """El Centro with other samples or header."""
    trace = catalogue.load("RSN6-180")[0]
    samples = stats.pop("data", None)
    if samples is not None:
        trace.data = samples(trace.data.copy())
    for key, value in stats.items():
        trace.stats[key] = value
    trace.stats.station, trace.stats.channel = "ELC", "180"
    return trace


def with_nan(samples):
    samples[812] = np.nan
    return samples


BAD_RECORDS = {
    "a sample that is no number": lambda: changed(data=with_nan),
    "one sample": lambda: changed(data=lambda a: a[:1]),
    "no sample": lambda: changed(data=lambda a: a[:0]),
    "gaps": lambda: changed(data=lambda a: np.ma.masked_greater(a, 2.0)),
    "no step": lambda: changed(sampling_rate=0.0),
    "a step backwards": lambda: changed(sampling_rate=-100.0),
    "counts": lambda: changed(calib=2e-06),
    "complex numbers": lambda: changed(data=lambda a: a * 1j),
    "beyond all ground": lambda: changed(data=lambda a: a * 1e200),
    "no trace": lambda: obspy.Stream(),
    "a number for a record": lambda: 3,
    "an unknown id": lambda: "RSN6-18",
    "no motion": lambda: changed(data=np.zeros_like),
}
BAD_CHOICES = {
    "a tail of ages": {"tail": 1e12},
    "two amplitudes": {"pga": 1.0, "scale": 2.0},
    "no amplitude": {"pga": 0.0},
    "an amplitude in metres": {"pga": "0.5 m"},
    "no polarity": {"polarity": "up"},
    "half a window": {"window": 6.0},
    "an empty window": {"window": (6.0, 6.0)},
    "a window after the end": {"window": (60.0, 70.0)},
    "a window between samples": {"window": (1.001, 1.008)},
    "no chain": {"processing": "best"},
    "an unknown step": {"processing": [{"step": "bandpas"}]},
    "an unknown option": {"processing": [{"step": "mean"}, {"step": "bandpass", "lo": 1}]},
    "an option of another step": {"processing": [{"step": "trend", "of": 1}]},
    "a word for a step": {"processing": ["mean"]},
    "an unknown choice": {"processing": [{"step": "mean", "of": "all"}]},
    "a corner in seconds": {"processing": [{"step": "bandpass", "low": "0.1 s"}]},
    "a corner above Nyquist": {"processing": [{"step": "bandpass", "low": 1.0, "high": 60.0}]},
    "a corner below a cycle": {"processing": [{"step": "bandpass", "low": 1e-6}]},
    "a step of time too short": {"processing": [{"step": "resample", "dt": 1e-7}]},
    "a taper longer than the record": {"processing": [{"step": "taper", "lead": 60.0}]},
    "a baseline of order 1": {"processing": [{"step": "baseline", "order": 1}]},
}


@pytest.mark.parametrize("name", [*BAD_RECORDS, *BAD_CHOICES])
def test_what_cannot_be_used_is_refused_in_a_sentence(name, says):
    source = BAD_RECORDS[name]() if name in BAD_RECORDS else "RSN6-180"
    says(refusal(read_motion, source, **BAD_CHOICES.get(name, {})))


def test_streams_of_more_than_one_trace(says):
    east, north = catalogue.load("NAPA-HNE")[0], catalogue.load("NAPA-HNN")[0]
    early, late = (east.slice(endtime=east.stats.starttime + 10), east.slice(starttime=east.stats.starttime + 14))
    other = late.copy()
    other.stats.sampling_rate = 100.0
    for traces in ([east, north], [early, late], [early, other]):
        says(refusal(read_motion, obspy.Stream(traces)))


def test_a_motion_made_by_hand_is_checked(says):
    says(refusal(Motion, "mine", np.zeros(5), 0.0, {}), refusal(Motion, "mine", np.zeros(1), 0.01, {}))


DOUBTS = {
    "a PGA above 3 g": (lambda: changed(data=lambda a: a * 20), {}),
    "a PGA below 0.001 g": (lambda: changed(data=lambda a: a / 1000.0), {}),
    "scaled above 3 g": ("RSN6-180", {"pga": 4 * G}),
    "a small factor": ("RSN6-180", {"pga": 0.05 * G}),
    "a late trigger": ("RSN1690-UP", {}),
    "a coarse step": (lambda: changed(delta=0.04), {}),
    "a window past the end": ("RSN6-180", {"window": (0, 99)}),
    "a window without the shaking": ("CCC-HN1", {"window": (0, 6)}),
    "a mean left in": ("NAPA-HNZ", {"processing": "none"}),
    "no quiet before": ("RSN6-180", {"processing": [{"step": "mean"}]}),
    "a taper in the shaking": ("RSN6-180", {"processing": [{"step": "taper", "lead": 2.7}]}),
    "a filter without a taper": ("NAPA-HNZ", {"processing": [{"step": "bandpass"}]}),
    "a corner below a cycle": ("RSN6-180", {"processing": [{"step": "bandpass", "low": 0.01}]}),
}


@pytest.mark.parametrize("name", DOUBTS)
def test_doubts_are_flagged(name, says):
    source, choices = DOUBTS[name]
    says(read_motion(source() if callable(source) else source, **choices).flags)


# --- the steps --------------------------------------------------------------------------------------------


def test_every_step_has_a_name_a_sentence_and_finite_samples():
    samples, dt = catalogue.load("CCC-HN1")[0].data, 0.01
    for name, known in known_steps().items():
        done = Step(name, {}).apply(samples, dt)
        assert done.sentence.startswith(f"{name}: ")
        assert np.isfinite(done.samples).all()
        assert known.function.__doc__


OPTIONS = {
    "bandpass": ({}, {"pads": "kept"}, {"low": 0.0}, {"high": np.inf}, {"corners": "default"}),
    "baseline": ({}, {"order": 20.0}, {"scheme": "bilinear"}, {"scheme": "bilinear", "start": 1.0}),
    "resample": ({}, {"dt": 0.0123}, {"dt": 0.1, "method": "fourier"}),
    "trend": ({}, {"order": 20.0}),
}


@settings(max_examples=60)
@given(
    st.integers(2, 3000),
    st.sampled_from([0.001, 0.005, 0.02, 0.2, 10.0]),
    st.sampled_from(["noise", "nothing", "level", "pulse", "sudden", "wandering"]),
    st.integers(0, 99),
)
@pytest.mark.complete
def test_no_step_fails_without_a_sentence(count, dt, kind, seed):
    """Records of any length, step and shape: new samples, all finite, or a RecordError; no warning either."""
    random = np.random.default_rng(seed).normal(size=count)
    place = np.arange(count) / count
    samples = {
        "noise": random,
        "nothing": np.zeros(count),
        "level": np.full(count, 3.3),
        "pulse": (np.arange(count) == count // 2).astype(float),
        "sudden": random * np.where(place > 0.4, 1.0, 1e-4),
        "wandering": 1e6 * np.cumsum(random),
    }[kind]
    for name in known_steps():
        for options in OPTIONS.get(name, ({},)):
            try:
                done = Step(name, options).apply(samples, dt)
            except RecordError:
                continue
            assert len(done.samples) >= 2
            assert np.isfinite(done.samples).all()


def test_the_corners_are_the_half_power_points():
    frequency = np.array([0.0, 0.1, 1.0, 25.0])
    gain = butterworth(frequency, 0.1, 25.0, 5.0)
    assert gain[0] == 0.0
    assert gain[[1, 3]] ** 2 == pytest.approx([0.5, 0.5], rel=1e-9)
    assert gain[2] == pytest.approx(1.0, abs=1e-7)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), min_size=5, max_size=5), st.sampled_from([0.005, 0.01, 0.02]))
def test_baseline_correction_removes_a_drift_and_nothing_else(coefficients, dt):
    """A polynomial drift of order 6 in displacement on the real motion leaves no trace."""
    place = np.linspace(0.0, 1.0, 3000)
    drift = sum(c * place**power for power, c in enumerate(coefficients))
    corrected = Step("baseline", {}).apply(drift, dt).samples
    assert np.abs(corrected).max() < 2e-3 * (np.abs(drift).max() + 1e-9)


@settings(max_examples=40)
@given(st.integers(1, 20), st.lists(st.floats(-1.0, 1.0), min_size=21, max_size=21), st.floats(0.01, 100.0))
def test_a_trend_of_any_order_takes_such_a_polynomial_away(order, coefficients, factor):
    """And leaves what it leaves of the motion alone: orthogonal shapes are fitted to 1e-12 at order 20 too."""
    samples = catalogue.load("RSN6-180")[0].data
    place = np.linspace(-1.0, 1.0, len(samples))
    added = factor * np.polynomial.chebyshev.chebval(place, coefficients[: order + 1])
    step = Step("trend", {"order": float(order)})
    with_it, without = step.apply(samples + added, 0.01).samples, step.apply(samples, 0.01).samples
    assert np.abs(with_it - without).max() < 1e-12 * (np.abs(added).max() + 10.0)
    assert np.allclose(step.apply(factor * samples, 0.01).samples, factor * without, atol=1e-10 * factor)


def test_a_trend_says_its_order(says):
    samples = catalogue.load("RSN6-180")[0].data
    says(Step("trend", {"order": 3.0}).apply(samples, 0.01).sentence)
    says(refusal(Step("trend", {"order": 2.5}).apply, samples, 0.01))


@settings(max_examples=20)
@given(st.floats(0.02, 0.5), st.floats(5.0, 40.0), st.integers(1, 10), st.sampled_from(["CCC-HN1", "NAPA-HNZ"]))
def test_time_reversal_and_filter_commute(low, high, order, record):
    """To the rounding of two transforms, whatever the corners, the order and the record."""
    samples, dt = catalogue.load(record)[0].data[:4000], catalogue.load(record)[0].stats.delta
    options = {"low": low, "high": high, "order": float(order)}
    there = Step("bandpass", options).apply(samples, dt).samples
    back = Step("bandpass", options).apply(samples[::-1], dt).samples[::-1]
    assert np.abs(there - back).max() < 1e-11 * np.abs(samples).max()


def test_a_trace_that_tells_no_time_has_no_date():
    """ObsPy lets such a trace start in 1970, which no record did."""
    record = read_motion(obspy.Trace(np.sin(np.arange(0.0, 9.0, 0.01)), {"delta": 0.01})).record
    assert (record["date"], record.get("start")) == ("", None)


def test_a_written_motion_starts_when_it_did(tmp_path):
    """Components that start apart are aligned by it, also after they were written."""
    motion = read_motion("NAPA-HNE", window=(5.0, 60.0))
    write_motion(motion, tmp_path / "x.csv")
    assert read_motion(tmp_path / "x.csv").record["start"] == motion.record["start"]
    write_motion(read_motion("RSN6-180"), tmp_path / "y.csv")  # PEER tells the day alone
    assert "start" not in read_motion(tmp_path / "y.csv").record


def test_a_time_step_may_be_text(tmp_path):
    path = tmp_path / "x.txt"
    path.write_text("0.1\n0.2\n-0.1\n")
    assert read_motion(path, unit="g", dt="10 ms").dt == read_motion(path, unit="g", dt=0.01).dt == 0.01
    assert read_stream(path, unit="g", dt="10 ms")[0].stats.delta == 0.01
    with pytest.raises(RecordError, match="has no unit, and a time step of the samples needs one"):
        read_motion(path, unit="g", dt="0.01")


def test_a_raw_record_stays_raw_through_rotation_and_resampling(tmp_path):
    """Neither takes its offset and drift: read again, it is corrected like any raw one."""
    one, other = (read_motion(name, processing="none") for name in ("CCC-HN1", "CCC-HN2"))
    for motion in (
        rotated(one, other, 30.0),
        read_motion("CCC-HN1", processing=[{"step": "resample", "dt": "0.005 s"}]),
    ):
        write_motion(motion, tmp_path / "raw.csv")
        assert read_motion(tmp_path / "raw.csv", processing="none").record["state"] == "raw"
    write_motion(rotated(*(read_motion(name) for name in ("CCC-HN1", "CCC-HN2")), 30.0), tmp_path / "done.csv")
    assert read_motion(tmp_path / "done.csv").record["state"] == "processed"


def test_other_names_are_refused():
    assert set(motions.__all__) <= set(dir(motions))
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        motions.nothing  # noqa: B018 (the look-up is what is tested)


def test_importing_the_namespace_imports_no_library():
    code = "import sys, pounding_risk.motions; print(sorted({'numpy', 'obspy', 'numba', 'scipy'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
