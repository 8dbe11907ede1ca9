"""K-NET, Kinemetrics EVT, SAC and MiniSEED: ObsPy reads them, the unit and the sentences are ours.

K-NET files may not be handed on, so the one of ObsPy's own tests is read where it is installed, as are its EVT files.
"""

import gzip
import shutil
import struct
from io import BytesIO
from pathlib import Path

import numpy as np
import obspy
import pytest
from obspy import UTCDateTime

from pounding_risk.errors import RecordError
from pounding_risk.motions import catalogue
from pounding_risk.motions.ensemble import read_ensemble
from pounding_risk.motions.formats import read_components, read_file
from pounding_risk.motions.formats.evt import _is_evt, _read_evt
from pounding_risk.motions.formats.knet import _is_knet, _read_knet
from pounding_risk.motions.formats.mseed import _read_mseed
from pounding_risk.motions.formats.sac import _is_sac, _read_sac
from pounding_risk.motions.read import read_motion
from pounding_risk.motions.request import RecordRequest

G = 9.80665
OBSPY = Path(obspy.__file__).parent / "io"
KNET = OBSPY / "nied/tests/data/test.knet"
EVTS = {name: OBSPY / "kinemetrics/tests/data" / name for name in ("BI008_MEMA-04823.evt", "BX456_MOLA-02351.evt")}
OLD_K2 = OBSPY / "kinemetrics/tests/data/STNA.20020722.044649.evt.gz"
ETNA = EVTS["BI008_MEMA-04823.evt"]
HOW = (
    "or, where its samples are no counts, give their unit: "
    'records.unit = "cm/s^2" in a scene, unit="cm/s^2" in Python, --unit "cm/s^2" on the command line'
)


def refusal(read, raw, **choices):
    """What is said of bytes that are no record."""
    with pytest.raises(RecordError) as caught:
        read(BytesIO(raw), name="x", **choices)
    return str(caught.value)


# --- K-NET ------------------------------------------------------------------------------------------------


def test_knet_gives_the_peak_of_its_header():
    found = read_file(KNET)
    record, data = found.trace.stats.record, found.trace.data
    # The header rounds to 0.001 gal; it is without the offset of the whole record.
    assert np.abs(data - data.mean()).max() * 100 == pytest.approx(4.383, abs=5e-4)
    assert record.header_pga == pytest.approx(0.04383)
    origin = KNET.read_text().splitlines()[0].removeprefix("Origin Time").strip()
    assert UTCDateTime(origin.replace("/", "-")) - 9 * 3600 == UTCDateTime(record.event.removesuffix(" UTC"))
    assert (found.format, found.state, found.trace.stats.calib) == ("KNET", "raw", 1.0)
    assert (record.station, record.component, record.azimuth, record.magnitude) == ("AKT013", "EW", 90.0, 5.9)
    assert found.units == "units: counts, times 2.384185791e-06 m/s² per count"
    # 03:12:39 in Japan, less the 15 s of the recorder.
    assert found.trace.stats.starttime == obspy.UTCDateTime(1996, 8, 10, 18, 12, 24)
    assert (found.trace.stats.delta, len(data)) == (0.01, 5900)


def test_both_depths_of_a_kiknet_station_are_recordings_of_their_own(tmp_path):
    """Its borehole and its surface have two horizontals each; their files differ by the suffix alone."""
    raw = KNET.read_bytes().split(b"\n")
    first = next(place for place, line in enumerate(raw) if line.startswith(b"Memo.")) + 1
    last = len(raw) - 1 if raw[-1] else len(raw) - 2
    at = {"1": "NS1", "2": "EW1", "3": "UD1", "4": "NS2", "5": "EW2", "6": "UD2"}  # as NIED numbers them
    for number, component in at.items():
        # Each component has the samples in another order, line by line: six records, and no copy among them.
        order = np.random.default_rng(int(number)).permutation(np.arange(first, last))
        lines = [*raw[:first], *(raw[place] for place in order), *raw[last:]]
        named = [b"Dir.              " + number.encode() if line.startswith(b"Dir.") else line for line in lines]
        (tmp_path / f"AKT0139608110312.{component}").write_bytes(b"\n".join(named))
    request = RecordRequest((), (str(tmp_path),), None, None, None, ("as recorded",), "none", 0.0, direction=90.0)
    found = read_ensemble(request, tmp_path)
    assert [motion.record["component"] for motion in found.motions] == ["EW1 + NS1", "EW2 + NS2"]
    assert [motion.record["id"] for motion in found.motions] == [
        f"AKT0139608110312.EW{depth} + AKT0139608110312.NS{depth}" for depth in "12"
    ]
    assert len(found.left_out) == 2  # the verticals


def test_knet_refusals():
    raw = KNET.read_bytes()
    lines = raw.split(b"\n")
    assert refusal(_read_knet, b"x" + raw) == (
        "x: does not start with Origin Time, as a K-NET file does; check that this is one"
    )
    assert refusal(_read_knet, b"\n".join(lines[:-3])) == (
        "x: the header promises 5900 samples, 5888 found; the file is cut short: fetch it again"
    )
    assert refusal(_read_knet, raw.replace(b"4.383", b"5.383")) == (
        "x: Max. Acc. (gal): the header says that the largest sample is 5.383 gal, it is 4.38328; samples or header "
        "are damaged: fetch the file again"
    )
    assert refusal(_read_knet, raw.replace(b"2000(gal)", b"2000(mm) ")) == (
        'x: "Scale Factor      2000(mm) /8388608" does not say what a K-NET header says there; fetch it again'
    )
    assert refusal(_read_knet, raw.replace(b"Scale", b"Skale")) == (
        'x: has no line "Scale Factor" in its header; fetch the record again'
    )
    assert refusal(_read_knet, raw.replace(b"-18205", b"  nan ")) == (
        "x: cannot be read as K-NET (not every sample is a finite number); fetch the record again"
    )
    assert refusal(_read_knet, raw.replace(b"-18205", b"-182.5")) == (
        "x: cannot be read as K-NET (not every sample is a whole number); fetch the record again"
    )


# --- Kinemetrics ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", [*EVTS.values(), OLD_K2], ids=lambda path: path.name)
def test_evt_gives_the_counts_that_its_header_tells(tmp_path, path):
    """The recorder wrote the largest and the smallest count of each channel, and how many there are."""
    copy = tmp_path / "quake.evt"
    copy.write_bytes(gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes())
    found = read_components(copy)
    assert len(found) in (3, 6)
    for each in found:
        header = each.trace.stats.kinemetrics_evt
        counts = each.trace.data / (header.chan_fullscale / 2**23 / header.chan_sensitivity * G)
        # One rounding of the factor, of counts below 2^24.
        assert (counts.max(), counts.min()) == pytest.approx((header.maxpeak, header.minpeak), rel=1e-12)
        assert len(counts) == header.nscans
        assert (each.state, each.format, each.trace.stats.calib) == ("raw", "KINEMETRICS_EVT", 1.0)


def test_evt_in_si_is_obspys_with_standard_gravity():
    ours, theirs = _read_evt(ETNA)[0], obspy.read(str(ETNA), format="KINEMETRICS_EVT", apply_calib=True)[0]
    assert np.allclose(ours.data, theirs.data * (9.80665 / 9.81), rtol=1e-12, atol=0.0)
    assert obspy.read(str(ETNA), format="KINEMETRICS_EVT")[0].stats.calib == pytest.approx(1.16944e-6, rel=1e-5)
    assert ours.stats.record.units == "units: counts, times 1.169043779e-06 m/s² per count (2.5 V per g)"
    assert ours.stats.starttime == obspy.UTCDateTime(2013, 8, 15, 9, 20, 28)


def with_header(raw, place, value):
    """Bytes of the header changed, with the checksum that belongs to them."""
    raw = bytearray(raw)
    raw[place : place + len(value)] = value
    struct.pack_into(">H", raw, 14, sum(raw[16 : 16 + 2040]) & 0xFFFF)
    return bytes(raw)


def test_evt_refusals():
    raw = ETNA.read_bytes()
    damaged = bytearray(raw)
    damaged[30_000] ^= 1
    assert refusal(_read_evt, bytes(damaged)) == (
        "x: cannot be read as Kinemetrics EVT (the checksum of the frame at byte 29902 is wrong); fetch the record "
        "again"
    )
    assert refusal(_read_evt, raw[:30_000]) == (
        "x: is cut short, the frame at byte 29902 has 257 bytes, 82 are left; fetch it again"
    )
    assert refusal(_read_evt, raw[:29_902]) == (
        "x: cannot be read as Kinemetrics EVT (Bad number of blocks); fetch the record again"
    )
    sensor = 16 + 0x2C8 + 18  # of the first channel
    assert raw[sensor : sensor + 2] == b"\0\x20"
    changed = with_header(raw, sensor, b"\0\x02")
    assert [trace.stats.channel for trace in _read_evt(BytesIO(changed))] == ["1", "2"]
    for channel in range(3):
        changed = with_header(changed, sensor + 76 * channel, b"\0\x02")
    assert refusal(_read_evt, changed) == (
        "x: no channel is of an accelerometer (sensor types 2, 2, 2); take the record of an accelerograph"
    )


# --- SAC and MiniSEED -------------------------------------------------------------------------------------


@pytest.fixture
def sac(tmp_path):
    """The counts of a shipped record as ObsPy writes them to SAC, without the StationXML."""
    trace = obspy.read(str(catalogue.path("NAPA-HNE")), format="MSEED")[0]
    trace.write(str(tmp_path / "napa.sac"), format="SAC")
    return tmp_path / "napa.sac"


def test_sac_takes_its_unit_from_the_stationxml_beside_it(sac):
    shutil.copy(catalogue.records_folder() / "CE.68150.xml", sac.parent)
    found, shipped = read_file(sac), catalogue.load("NAPA-HNE")[0]
    # Counts below 2^24 are whole in the four bytes of a SAC sample.
    assert np.allclose(found.trace.data, shipped.data, rtol=1e-12, atol=1e-12)
    assert (found.trace.stats.delta, found.trace.stats.starttime) == (0.005, shipped.stats.starttime)
    assert (found.format, found.state) == ("SAC", "raw")
    assert found.units == "units: counts, divided by 213744.0378 counts per m/s² (CE.68150.xml)"


def test_sac_takes_its_unit_from_the_user(sac):
    with pytest.raises(RecordError) as caught:
        read_file(sac)
    assert str(caught.value) == (
        f"{sac}: the unit is unknown, a SAC file holds counts; put the StationXML of CE.68150..HNE beside it as "
        f"CE.68150.xml, {HOW}"
    )
    found = read_file(sac, unit="mm/s^2")
    counts = obspy.read(str(sac), format="SAC")[0].data
    assert np.array_equal(found.trace.data, counts.astype(float) * 0.001)
    assert (found.state, found.units) == ("processed", "units: mm/s^2, times 0.001")
    assert refusal(_read_sac, sac.read_bytes(), unit="counts") == (
        'x: unit as given: "counts" is not a unit of acceleration; write one such as "g", "cm/s^2" or "m/s^2"'
    )


def test_sac_of_either_byte_order(sac):
    trace = obspy.read(str(sac), format="SAC")[0]
    trace.write(str(sac), format="SAC", byteorder=">")
    assert _is_sac(sac)
    assert np.array_equal(read_file(sac, unit="m/s^2").trace.data, trace.data.astype(float))


def test_sac_refusals(sac):
    raw = sac.read_bytes()

    def changed(word, value):
        return raw[: 4 * word] + struct.pack("<i", value) + raw[4 * word + 4 :]

    assert refusal(_read_sac, raw[:-4], unit="g") == (
        f"x: has {len(raw) - 4} bytes, the SAC header promises 23800 samples, which take {len(raw)}; "
        "fetch the record again"
    )
    assert refusal(_read_sac, raw[:600], unit="g") == (
        "x: has no header of a binary SAC file; check that this is one, or fetch it again"
    )
    assert refusal(_read_sac, changed(105, 0), unit="g") == (
        "x: is no time series with equal steps, by its SAC header; resample it to equal steps"
    )
    assert refusal(_read_sac, changed(70 + 16, 7), unit="g") == (
        "x: its SAC header says that it holds a velocity; take the file of the acceleration"
    )
    assert refusal(_read_sac, changed(0, 0), unit="g") == (
        'x: DELTA is "0"; the time step must be a number of seconds greater than 0, from 1e-06 to 1 s: restore that '
        "line, or fetch the file again"
    )
    nan = raw[:700] + struct.pack("<f", np.nan) + raw[704:]
    assert refusal(_read_sac, nan, unit="g") == (
        "x: cannot be read as SAC (not every sample is a finite number); fetch the record again"
    )


def test_miniseed_takes_its_unit_from_the_user(tmp_path):
    copy = tmp_path / "x.mseed"
    shutil.copy(catalogue.path("CCC-HN1"), copy)  # whole numbers of micro-g
    with pytest.raises(RecordError, match="the unit is unknown"):
        read_file(copy)
    whole = read_file(copy, unit="g")
    assert (whole.state, whole.units) == ("raw", "units: g, times 9.80665")
    trace = obspy.read(str(copy), format="MSEED")[0]
    assert np.array_equal(whole.trace.data, trace.data * G)
    trace.data = trace.data * 1e-6 * G
    trace.write(str(copy), format="MSEED", encoding="FLOAT64")
    fractions = read_file(copy, unit="m/s^2")
    assert fractions.state == "processed"
    assert np.array_equal(fractions.trace.data, trace.data)
    # Where a StationXML file says what a count is, it is believed.
    shutil.copy(catalogue.path("CCC-HN1"), copy)
    shutil.copy(catalogue.records_folder() / "CI.CCC.xml", tmp_path)
    assert "counts per m/s²" in read_motion(copy, processing="none").processing[0]
    assert read_file(copy, unit="g").units.startswith("units: counts, divided by")


def test_miniseed_refusals():
    raw = catalogue.path("CCC-HN1").read_bytes()

    def changed(place, value):
        return raw[:place] + value + raw[place + len(value) :]

    def reason(raw):
        said = refusal(_read_mseed, raw, unit="g")
        assert said.startswith("x: cannot be read as MiniSEED (")
        assert said.endswith("); fetch the record again")
        return said[31:-25]

    first = 4096
    assert reason(changed(first + 6, b"X")) == (
        "block at byte 4096: it does not start with a number and the letter D, R, Q or M"
    )
    assert reason(changed(first + 8, b"\xff")) == "block at byte 4096: its station and channel are no plain letters"
    assert reason(changed(first + 24, b"\x99")) == "block at byte 4096: its time is no time of day"
    assert reason(changed(first + 32, b"\0\0")) == "block at byte 4096: its time or sampling rate is out of range"
    assert reason(changed(first + 44, b"\xff\xff")) == "block at byte 4096: its samples start at byte 65535 of 4096"
    assert reason(changed(first + 30, b"\x40\0")) == (
        "block at byte 4096: it promises 16384 samples, more than 4032 bytes hold"
    )
    assert reason(changed(first + 46, b"\0\0")) == (
        "block at byte 4096: it has no blockette 1000, which says how long it is"
    )
    assert reason(changed(first + 54, b"\x30")) == "block at byte 4096: its length of 2^48 bytes is out of range"
    assert refusal(_read_mseed, raw[:9000]) == (
        "x: is cut short, the block at byte 8192 has 4096 bytes, 808 are left; fetch the record again"
    )
    assert refusal(_read_mseed, b"MS\x03" + raw) == (
        "x: is MiniSEED of version 3, which ObsPy does not read; convert it to version 2"
    )
    assert refusal(_read_mseed, b"x" + raw) == (
        "x: does not hold MiniSEED, whatever its name says; fetch the record again"
    )


def test_each_is_told_by_its_content():
    for recognises in (_is_knet, _is_evt, _is_sac):
        assert not any(recognises(other) for other in (None, 3, "none", BytesIO(b""), BytesIO(b"K" + bytes(700))))
    assert _is_knet(KNET)
    assert _is_evt(ETNA)
