"""Records in, motions out: published peaks, exact scaling, and the sentence of every refusal."""

import gzip
import shutil

import numpy as np
import obspy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pounding_risk.errors import RecordError
from pounding_risk.motions import catalogue
from pounding_risk.motions.formats.geonet import _read_geonet
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.processing import DEFAULT_CHAIN, Step, known_steps, read_steps
from pounding_risk.motions.processing.signals import butterworth, onset, velocity_displacement
from pounding_risk.motions.read import read_motion, read_stream, read_trace
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


def test_el_centro_as_the_paper_uses_it():
    motion = read_motion("RSN6-180", window=(0.0, 6.0), pga=HALF_G)
    assert len(motion.acceleration) == 601
    assert motion.duration == pytest.approx(6.0)
    assert motion.pga == pytest.approx(HALF_G, rel=1e-12)
    assert motion.record["pga_recorded"] / G == pytest.approx(0.2808, abs=5e-5)
    assert motion.record["sha256"] == catalogue.entry("RSN6-180").sha256
    assert motion.flags == ()
    assert motion.processing == (
        "units: g, times 9.80665 m/s²",
        "window: kept 0 s to 6 s (601 samples)",
        "scale: times 1.780655317, from PGA 0.2808 g to 0.5 g",
    )


def test_a_window_leaves_a_processed_record_as_it_is():
    whole = read_motion("RSN6-180")
    assert np.array_equal(read_motion("RSN6-180", window=(1.0, 6.0)).acceleration, whole.acceleration[100:601])


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
    ("record", "pga", "pgv", "pgd"),
    [("CCC-HN1", 0.4701, 78.1, 28.0), ("CCC-HN2", 0.5604, 41.8, 25.9)],
)
def test_the_chain_gives_gmprocess_peaks(record, pga, pgv, pgd):
    found = peaks(read_motion(record, processing=GMPROCESS))
    assert found[0] == pytest.approx(pga, abs=1e-4)
    assert found[1] == pytest.approx(pgv, rel=0.005)
    assert found[2] == pytest.approx(pgd, rel=0.005)
    assert abs(found[3]) < 0.02


def test_the_vertical_with_its_own_corners():
    steps = [*GMPROCESS[:2], {"step": "bandpass", "low": "0.0247 Hz", "high": "37.5 Hz"}, GMPROCESS[3]]
    pga, pgv, pgd, rest = peaks(read_motion("CCC-HNZ", processing=steps))
    assert (pga, pgv, pgd) == pytest.approx((0.3607, 16.9, 4.0), rel=0.02)
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


def test_a_raw_record_is_cut_after_its_chain():
    whole = read_motion("CCC-HN1")
    part = read_motion("CCC-HN1", window=(20.0, 60.0))
    assert np.array_equal(part.acceleration, whole.acceleration[2000:6001])
    assert part.processing[:-1] == whole.processing


def test_a_window_can_be_a_step_too():
    steps = [{"step": "window", "start": "20 s", "end": "60 s"}, *GMPROCESS]
    trace = read_trace("CCC-HN1", processing=steps)
    assert trace.stats.npts == 4001
    assert trace.stats.starttime == catalogue.load("CCC-HN1")[0].stats.starttime + 20.0
    assert trace.stats.processing[1] == "window: kept 20 s to 60 s (4001 samples)"


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


def test_a_miniseed_file_takes_its_unit_from_the_stationxml_beside_it():
    by_path, by_id = read_motion(catalogue.path("NAPA-HNE")), read_motion("NAPA-HNE")
    assert np.allclose(by_path.acceleration, by_id.acceleration, rtol=1e-12, atol=1e-12)
    assert by_path.processing[0] == "units: counts, divided by 213744.0378 counts per m/s² (CE.68150.xml)"


def test_a_miniseed_file_without_a_unit_is_refused(tmp_path):
    copy = tmp_path / "x.mseed"
    shutil.copy(catalogue.path("NAPA-HNE"), copy)
    with pytest.raises(RecordError) as caught:
        read_motion(copy)
    assert str(caught.value) == (
        f"{copy}: the unit is unknown, a MiniSEED file holds counts; put the StationXML of CE.68150..HNE "
        "beside it as CE.68150.xml, or, where its samples are no counts, give their unit: "
        'records.unit = "cm/s^2" in a scene, unit="cm/s^2" in Python, --unit "cm/s^2" on the command line'
    )


@pytest.mark.parametrize("size", [60, 4000, 9000, 32000])
def test_a_cut_miniseed_file_is_refused(tmp_path, size):
    copy = tmp_path / "CCC-HN1.mseed"
    copy.write_bytes(catalogue.path("CCC-HN1").read_bytes()[:size])
    shutil.copy(catalogue.records_folder() / "CI.CCC.xml", tmp_path)
    with pytest.raises(RecordError, match=r"CCC-HN1\.mseed: (cannot be read as MiniSEED|is cut short)"):
        read_motion(copy)


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


def test_the_history_is_in_the_trace_and_in_the_motion():
    choices = {"window": (0.0, 6.0), "pga": HALF_G, "polarity": "reversed", "tail": 2.0}
    motion, trace = read_motion("RSN6-180", **choices), read_trace("RSN6-180", **choices)
    assert tuple(trace.stats.processing) == motion.processing
    assert motion.processing[-3:] == (
        "polarity: reversed",
        "scale: times 1.780655317, from PGA 0.2808 g to 0.5 g",
        "tail: 2 s of zeros added, after a straight line to zero over 0.01 s",
    )
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


REFUSED = [
    (
        lambda: changed(data=with_nan),
        {},
        ".ELC..180: 1 sample is not finite, the first at index 812 (t = 8.12 s); repair or replace the record",
    ),
    (lambda: changed(data=lambda a: a[:1]), {}, ".ELC..180: has 1 sample; a record needs at least 2"),
    (lambda: changed(data=lambda a: a[:0]), {}, ".ELC..180: has 0 samples; a record needs at least 2"),
    (
        lambda: changed(data=lambda a: np.ma.masked_greater(a, 2.0)),
        {},
        ".ELC..180: has gaps (14 samples are missing); cut or fill them before",
    ),
    (
        lambda: changed(sampling_rate=0.0),
        {},
        ".ELC..180: the time step is 0 s; it must be greater than 0: check the record",
    ),
    (
        lambda: changed(sampling_rate=-100.0),
        {},
        ".ELC..180: the time step is -0.01 s; it must be greater than 0: check the record",
    ),
    (
        lambda: changed(calib=2e-06),
        {},
        ".ELC..180: the trace has calib 2e-06, so its samples are no m/s² yet; multiply them by "
        "it and set stats.calib = 1",
    ),
    (
        lambda: changed(data=lambda a: a * 1j),
        {},
        ".ELC..180: its samples are complex numbers; hand over the real part of them",
    ),
    (
        lambda: changed(data=lambda a: a * 1e200),
        {},
        ".ELC..180: a sample of 2.75e+200 m/s² is no motion of the ground; check the unit, or the scaling",
    ),
    (
        lambda: "RSN6-180",
        {"tail": 1e12},
        "a tail of 1e+12 s makes 100000000000000 samples, 20000000 are allowed; write a shorter one",
    ),
    (lambda: obspy.Stream(), {}, "the ObsPy stream: holds no samples; check the file"),
    (lambda: 3, {}, "3 is not a record; give an id of the catalogue, a path, or an ObsPy trace in m/s²"),
    (
        lambda: "RSN6-18",
        {},
        '"RSN6-18" is not a record of the catalogue; did you mean RSN6-180 or RSN6-UP or RSN6-270?',
    ),
    (
        lambda: "RSN6-180",
        {"pga": 1.0, "scale": 2.0},
        "pga and scale are both given, and each sets the amplitude; remove one",
    ),
    (
        lambda: "RSN6-180",
        {"pga": 0.0},
        "pga: 0 is out of range: a peak ground acceleration must be greater than 0 m/s^2 and "
        'finite; write a peak ground acceleration such as "0.5 g"',
    ),
    (
        lambda: "RSN6-180",
        {"pga": "0.5 m"},
        'pga: "0.5 m" is a length, not an acceleration; write a peak ground acceleration such as "0.5 g"',
    ),
    (
        lambda: "RSN6-180",
        {"polarity": "up"},
        'polarity: "up" is not one; it may be "as recorded" or "reversed"',
    ),
    (
        lambda: "RSN6-180",
        {"window": 6.0},
        "window: 6.0 is not a start and an end; give two times such as (0.0, 6.0)",
    ),
    (
        lambda: "RSN6-180",
        {"window": (6.0, 6.0)},
        "the window 6 s to 6 s is empty; write a start before the end",
    ),
    (
        lambda: "RSN6-180",
        {"window": (60.0, 70.0)},
        "the window starts at 60 s, the record ends at 53.71 s; write a start before that",
    ),
    (
        lambda: "RSN6-180",
        {"window": (1.001, 1.008)},
        "the window 1.001 s to 1.008 s has fewer than 2 samples, 0.01 s apart; write a later end",
    ),
    (
        lambda: changed(data=np.zeros_like),
        {"pga": 1.0},
        ".ELC..180: every sample is 0 m/s²: the record holds no motion; check its sensitivity and unit, or leave the "
        "record out",
    ),
    (
        lambda: "RSN6-180",
        {"processing": "best"},
        'processing: "best" is not one; it may be "auto", "none" or a list of steps such as '
        '[{step = "mean"}, {step = "bandpass", low = "0.1 Hz"}]',
    ),
    (
        lambda: "RSN6-180",
        {"processing": [{"step": "bandpas"}]},
        'processing, step 1: "bandpas" is not a step (did you mean "bandpass"?); it may be '
        "bandpass, baseline, mean, resample, taper, trend, window",
    ),
    (
        lambda: "RSN6-180",
        {"processing": [{"step": "mean"}, {"step": "bandpass", "lo": 1}]},
        'processing, step 2: "bandpass" has no option "lo" (did you mean "low"?); it takes low, high, order, '
        "corners, pads",
    ),
    (
        lambda: "RSN6-180",
        {"processing": [{"step": "trend", "of": 1}]},
        'processing, step 1: "trend" has no option "of"; it takes order',
    ),
    (
        lambda: "RSN6-180",
        {"processing": ["mean"]},
        'processing, step 1: "mean" names no step; write a table such as {step = "mean"}',
    ),
    (
        lambda: "RSN6-180",
        {"processing": [{"step": "mean", "of": "all"}]},
        'processing, step 1, of: "all" is not a choice; it may be "pre-event" or "whole"',
    ),
    (
        lambda: "RSN6-180",
        {"processing": [{"step": "bandpass", "low": "0.1 s"}]},
        'processing, step 1, low: "0.1 s" is a time, not a frequency; write a corner frequency such as "0.1 Hz"',
    ),
    (
        lambda: "RSN6-180",
        {"processing": [{"step": "bandpass", "low": 1.0, "high": 60.0}]},
        "the corners 1 and 60 Hz do not fit a time step of 0.01 s; they must rise and stay below "
        "the Nyquist frequency of 50 Hz (inf for no upper corner)",
    ),
    (
        lambda: "RSN6-180",
        {"processing": [{"step": "bandpass", "low": 1e-6}]},
        "the corner 1e-06 Hz is 5.4e-05 of a cycle in the record of 53.71 s; write 0.00037 Hz or more",
    ),
    (
        lambda: "RSN6-180",
        {"processing": [{"step": "resample", "dt": 1e-7}]},
        "a time step of 1e-07 s makes 537100001 samples, 20000000 are allowed; write a longer one",
    ),
    (
        lambda: "RSN6-180",
        {"processing": [{"step": "taper", "lead": 60.0}]},
        "a taper of 60 s and 5 s does not fit a record of 53.71 s; write shorter",
    ),
    (
        lambda: "RSN6-180",
        {"processing": [{"step": "baseline", "order": 1}]},
        "the order of a baseline is 1; it must be a whole number from 2 to 20",
    ),
]


@pytest.mark.parametrize(("source", "choices", "sentence"), REFUSED, ids=range(len(REFUSED)))
def test_what_cannot_be_used_is_refused_in_a_sentence(source, choices, sentence):
    with pytest.raises(RecordError) as caught:
        read_motion(source(), **choices)
    assert str(caught.value) == sentence


def test_streams_of_more_than_one_trace():
    east, north = catalogue.load("NAPA-HNE")[0], catalogue.load("NAPA-HNN")[0]
    early, late = (
        east.slice(endtime=east.stats.starttime + 10),
        east.slice(starttime=east.stats.starttime + 14),
    )
    other = late.copy()
    other.stats.sampling_rate = 100.0
    for traces, words in [
        ([east, north], r"holds 2 components \(CE.68150..HNE, CE.68150..HNN\), one is needed"),
        ([early, late], r"is in 2 pieces, with gaps or overlaps .* the first at 2014-08-24T10:20:31"),
        ([early, other], "has time steps of 0.005 and 0.01 s in one record"),
    ]:
        with pytest.raises(RecordError, match=words):
            read_motion(obspy.Stream(traces))


def test_a_motion_made_by_hand_is_checked():
    with pytest.raises(RecordError, match="mine: the time step is 0 s"):
        Motion("mine", np.zeros(5), 0.0, {})
    with pytest.raises(RecordError, match="mine: has 1 sample; a record needs at least 2"):
        Motion("mine", np.zeros(1), 0.01, {})


@pytest.mark.parametrize(
    ("source", "choices", "flag"),
    [
        (lambda: changed(data=lambda a: a * 20), {}, "PGA as recorded is 5.62 g, above 3 g: check the unit"),
        (
            lambda: changed(data=lambda a: a / 1000.0),
            {},
            "PGA as recorded is 0.000281 g, below 0.001 g: check the unit",
        ),
        (lambda: "RSN6-180", {"pga": 4 * G}, "PGA after scaling is 4 g, above 3 g: check the unit"),
        (lambda: "RSN6-180", {"pga": 0.05 * G}, "the scale factor 0.1781 is outside 0.25 to 4"),
        (
            lambda: "RSN1690-UP",
            {},
            "the motion starts at 26.1 % of its PGA: a late trigger, or a cut in motion",
        ),
        (lambda: changed(delta=0.04), {}, "the time step 0.04 s is longer than 0.02 s: peaks may be missed"),
        (
            lambda: "RSN6-180",
            {"window": (0, 99)},
            "the requested window ends at 99 s, the record already at 53.71 s",
        ),
        (
            lambda: "CCC-HN1",
            {"window": (0, 6)},
            "the window leaves the strong shaking out: its PGA is 0.0032 % of the record's",
        ),
        (
            lambda: "NAPA-HNZ",
            {"processing": "none"},
            "the mean of the record is 17 % of its PGA: subtract it",
        ),
        (
            lambda: "RSN6-180",
            {"processing": [{"step": "mean"}]},
            "less than 1 s before the earthquake arrives: the mean of the whole record was taken",
        ),
        (
            lambda: "RSN6-180",
            {"processing": [{"step": "taper", "lead": 2.7}]},
            "processing changed PGA by -8.9 %",
        ),
        (
            lambda: "NAPA-HNZ",
            {"processing": [{"step": "bandpass"}]},
            "the record was filtered with ends above 2 % of its peak: subtract the mean and taper before",
        ),
        (
            lambda: "RSN6-180",
            {"processing": [{"step": "bandpass", "low": 0.01}]},
            "the lower corner 0.01 Hz is below one cycle in the record of 53.71 s",
        ),
    ],
    ids=range(13),
)
def test_doubts_are_flagged(source, choices, flag):
    assert flag in read_motion(source(), **choices).flags


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


def test_options_are_si_or_text_with_a_unit():
    text, numbers = ({"step": "bandpass", "low": low, "high": high} for low, high in (("0.1 Hz", "25 Hz"), (0.1, 25)))
    assert read_steps([text]) == read_steps([numbers]) == (Step("bandpass", {"low": 0.1, "high": 25.0}),)


def test_the_corners_are_the_half_power_points():
    frequency = np.array([0.0, 0.1, 1.0, 25.0])
    gain = butterworth(frequency, 0.1, 25.0, 5.0)
    assert gain[0] == 0.0
    assert gain[[1, 3]] ** 2 == pytest.approx([0.5, 0.5], rel=1e-9)
    assert gain[2] == pytest.approx(1.0, abs=1e-7)


def test_an_acausal_filter_knows_no_direction_of_time():
    samples = catalogue.load("CCC-HN1")[0].data
    samples = Step("taper", {"lead": 1.0, "tail": 5.0}).apply(samples - samples.mean(), 0.01).samples
    there = Step("bandpass", {}).apply(samples, 0.01).samples
    back = Step("bandpass", {}).apply(samples[::-1], 0.01).samples[::-1]
    assert np.abs(there - back).max() < 1e-9 * np.abs(there).max()


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), min_size=5, max_size=5), st.sampled_from([0.005, 0.01, 0.02]))
def test_baseline_correction_removes_a_drift_and_nothing_else(coefficients, dt):
    """A polynomial drift of order 6 in displacement on the real motion leaves no trace."""
    place = np.linspace(0.0, 1.0, 3000)
    drift = sum(c * place**power for power, c in enumerate(coefficients))
    corrected = Step("baseline", {}).apply(drift, dt).samples
    assert np.abs(corrected).max() < 2e-3 * (np.abs(drift).max() + 1e-9)


@settings(max_examples=25, deadline=None)
@given(st.floats(-2.0, 2.0), st.floats(-0.1, 0.1), st.floats(0.01, 100.0))
def test_steps_do_not_mind_offset_and_scale(offset, slope, factor):
    samples = catalogue.load("RSN753-000")[0].data
    time = np.arange(len(samples)) * 0.005
    trend = Step("trend", {})
    plain = trend.apply(samples, 0.005).samples
    assert np.allclose(trend.apply(samples + offset + slope * time, 0.005).samples, plain, atol=1e-10)
    assert np.allclose(trend.apply(factor * samples, 0.005).samples, factor * plain, atol=1e-10 * factor)


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


def test_a_trend_says_its_order():
    samples = catalogue.load("RSN6-180")[0].data
    assert Step("trend", {"order": 3.0}).apply(samples, 0.01).sentence == (
        "trend: subtracted a polynomial of order 3 in acceleration"
    )
    with pytest.raises(RecordError, match=r"the order of a trend is 2\.5; it must be a whole number from 1 to 20"):
        Step("trend", {"order": 2.5}).apply(samples, 0.01)


@settings(max_examples=20)
@given(st.floats(0.02, 0.5), st.floats(5.0, 40.0), st.integers(1, 10), st.sampled_from(["CCC-HN1", "NAPA-HNZ"]))
def test_time_reversal_and_filter_commute(low, high, order, record):
    """To the rounding of two transforms, whatever the corners, the order and the record."""
    samples, dt = catalogue.load(record)[0].data[:4000], catalogue.load(record)[0].stats.delta
    options = {"low": low, "high": high, "order": float(order)}
    there = Step("bandpass", options).apply(samples, dt).samples
    back = Step("bandpass", options).apply(samples[::-1], dt).samples[::-1]
    assert np.abs(there - back).max() < 1e-11 * np.abs(samples).max()


def test_velocity_and_displacement_of_a_constant_acceleration():
    velocity, displacement = velocity_displacement(np.full(101, 2.0), 0.01)
    assert velocity[-1] == pytest.approx(2.0)
    assert displacement[-1] == pytest.approx(1.0)


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
