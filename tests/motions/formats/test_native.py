"""K-NET, Kinemetrics EVT, SAC and MiniSEED: ObsPy reads them, the unit and the sentences are ours.

K-NET files may not be handed on, so the one of ObsPy's own tests is read where it is installed, as are its EVT files.
"""

import gzip
import re
import shutil
import struct
from io import BytesIO
from pathlib import Path

import numpy as np
import obspy
import pytest
from damage import EVTS, KNET, written
from obspy import UTCDateTime
from real_files import G
from sentences import refusal

from pounding_risk.errors import RecordError
from pounding_risk.motions import catalogue
from pounding_risk.motions.ensemble import read_ensemble
from pounding_risk.motions.formats import read_components, read_file
from pounding_risk.motions.formats.evt import _read_evt
from pounding_risk.motions.formats.sac import _is_sac
from pounding_risk.motions.read import open_source, read_motion
from pounding_risk.motions.record import is_vertical
from pounding_risk.motions.request import RecordRequest
from pounding_risk.motions.write import write_motion

ETNA = EVTS[0]
OLD_K2 = ETNA.parent / "STNA.20020722.044649.evt.gz"


def put(raw, place, value):
    """The bytes with others from a place on."""
    return raw[:place] + value + raw[place + len(value) :]


def with_sensors(raw, kind, count):
    """An EVT file whose first channels have a sensor of another kind, with the checksum of that header."""
    sensor = 16 + 0x2C8 + 18  # of the first channel
    assert raw[sensor : sensor + 2] == b"\0\x20"
    for channel in range(count):
        raw = put(raw, sensor + 76 * channel, kind)
    return put(raw, 14, struct.pack(">H", sum(raw[16 : 16 + 2040]) & 0xFFFF))


def sac_bytes():
    """The counts of a shipped record as ObsPy writes them to SAC."""
    return written(obspy.read(str(catalogue.path("NAPA-HNE")), format="MSEED")[0], "SAC")


def in_word(word, value):
    """A SAC file with another value in a word of its header, or among its samples."""
    return put(sac_bytes(), 4 * word, struct.pack("<f" if isinstance(value, float) else "<i", value))


def bad() -> dict[str, dict[str, bytes]]:
    """Files with faults, by format."""
    knet, etna, sac, mseed = (
        *(path.read_bytes() for path in (KNET, ETNA)),
        *(sac_bytes(), catalogue.path("CCC-HN1").read_bytes()),
    )
    block = 4096  # the second of the MiniSEED file
    return {
        "KNET": {
            "no origin time": b"x" + knet,
            "cut": b"\n".join(knet.split(b"\n")[:-3]),
            "another peak": knet.replace(b"4.383", b"5.383"),
            "another scale": knet.replace(b"2000(gal)", b"2000(mm) "),
            "no scale": knet.replace(b"Scale", b"Skale"),
            "nan": knet.replace(b"-18205", b"  nan "),
            "half a count": knet.replace(b"-18205", b"-182.5"),
        },
        "KINEMETRICS_EVT": {
            "a bit of a frame": put(etna, 30_000, bytes([etna[30_000] ^ 1])),
            "cut in a frame": etna[:30_000],
            "cut between frames": etna[:29_902],
            "no accelerometer": with_sensors(etna, b"\0\x02", 3),
        },
        "SAC": {
            "a sample less": sac[:-4],
            "cut in the header": sac[:600],
            "unequal steps": in_word(105, 0),
            "velocity": in_word(70 + 16, 7),
            "no step": in_word(0, 0),
            "nan": in_word(175, np.nan),
        },
        "MSEED": {
            "no number of a block": put(mseed, block + 6, b"X"),
            "a name in no letters": put(mseed, block + 8, b"\xff"),
            "no time of day": put(mseed, block + 24, b"\x99"),
            "no sampling rate": put(mseed, block + 32, b"\0\0"),
            "samples beyond the block": put(mseed, block + 44, b"\xff\xff"),
            "more samples than fit": put(mseed, block + 30, b"\x40\0"),
            "no blockette 1000": put(mseed, block + 46, b"\0\0"),
            "a block of 2^48 bytes": put(mseed, block + 54, b"\x30"),
            "cut": mseed[:9000],
            "version 3": b"MS\x03" + mseed,
            "no MiniSEED": b"x" + mseed,
        },
    }


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
    # 03:12:39 in Japan, less the 15 s of the recorder.
    assert found.trace.stats.starttime == obspy.UTCDateTime(1996, 8, 10, 18, 12, 24)


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
    request = RecordRequest(files=(str(tmp_path),), processing="none", direction=90.0)
    found = read_ensemble(request, tmp_path)
    assert [motion.record["component"] for motion in found.motions] == ["EW1 + NS1", "EW2 + NS2"]
    assert [motion.record["id"] for motion in found.motions] == [
        f"AKT0139608110312.EW{depth} + AKT0139608110312.NS{depth}" for depth in "12"
    ]
    assert len(found.left_out) == 2  # the verticals


# --- Kinemetrics ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", [*EVTS, OLD_K2], ids=lambda path: path.name)
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


def test_evt_in_si_is_obspys_with_standard_gravity(says):
    ours, theirs = _read_evt(ETNA)[0], obspy.read(str(ETNA), format="KINEMETRICS_EVT", apply_calib=True)[0]
    assert np.allclose(ours.data, theirs.data * (9.80665 / 9.81), rtol=1e-12, atol=0.0)
    assert obspy.read(str(ETNA), format="KINEMETRICS_EVT")[0].stats.calib == pytest.approx(1.16944e-6, rel=1e-5)
    says(ours.stats.record.units)
    assert ours.stats.starttime == obspy.UTCDateTime(2013, 8, 15, 9, 20, 28)


def test_evt_channels_of_accelerometers_are_read():
    changed = with_sensors(ETNA.read_bytes(), b"\0\x02", 1)
    assert [trace.stats.channel for trace in _read_evt(BytesIO(changed))] == ["1", "2"]


# --- SAC and MiniSEED -------------------------------------------------------------------------------------


@pytest.fixture
def sac(tmp_path):
    """The counts of a shipped record as ObsPy writes them to SAC, without the StationXML."""
    (tmp_path / "napa.sac").write_bytes(sac_bytes())
    return tmp_path / "napa.sac"


def test_sac_takes_its_unit_from_the_stationxml_beside_it(sac):
    shutil.copy(catalogue.records_folder() / "CE.68150.xml", sac.parent)
    found, shipped = read_file(sac), catalogue.load("NAPA-HNE")[0]
    # Counts below 2^24 are whole in the four bytes of a SAC sample.
    assert np.allclose(found.trace.data, shipped.data, rtol=1e-12, atol=1e-12)
    assert (found.trace.stats.delta, found.trace.stats.starttime) == (0.005, shipped.stats.starttime)
    assert (found.format, found.state) == ("SAC", "raw")
    assert found.units == "units: counts, divided by 213744.0378 counts per m/s² (CE.68150.xml)"


def test_sac_takes_its_unit_from_the_user(sac, says):
    says(refusal(read_file, sac))
    found = read_file(sac, unit="mm/s^2")
    counts = obspy.read(str(sac), format="SAC")[0].data
    assert np.array_equal(found.trace.data, counts.astype(float) * 0.001)
    assert (found.state, found.units) == ("processed", "units: mm/s^2, times 0.001")


def test_sac_of_either_byte_order(sac):
    trace = obspy.read(str(sac), format="SAC")[0]
    trace.write(str(sac), format="SAC", byteorder=">")
    assert _is_sac(sac)
    assert np.array_equal(read_file(sac, unit="m/s^2").trace.data, trace.data.astype(float))


def test_miniseed_takes_its_unit_from_the_user(tmp_path):
    copy = tmp_path / "x.mseed"
    shutil.copy(catalogue.path("CCC-HN1"), copy)  # whole numbers of micro-g
    assert "the unit is unknown" in refusal(read_file, copy, kind=RecordError)
    whole = read_file(copy, unit="g")
    assert (whole.state, whole.units) == ("raw", "units: g, times 9.80665")
    trace = obspy.read(str(copy), format="MSEED")[0]
    assert np.array_equal(whole.trace.data, trace.data * G)
    trace.data = trace.data * 1e-6 * G
    trace.write(str(copy), format="MSEED", encoding="FLOAT64")
    fractions = read_file(copy, unit="m/s^2")
    assert fractions.state == "processed"
    shutil.copy(catalogue.records_folder() / "CI.CCC.xml", tmp_path)
    told = read_motion(copy, unit="m/s^2").flags[0]
    assert told.endswith("(CI.CCC.xml)); where its samples are no counts, take that StationXML away")
    assert np.array_equal(fractions.trace.data, trace.data)
    # Where a StationXML file says what a count is, it is believed.
    shutil.copy(catalogue.path("CCC-HN1"), copy)
    shutil.copy(catalogue.records_folder() / "CI.CCC.xml", tmp_path)
    assert "counts per m/s²" in read_motion(copy, processing="none").processing[0]
    assert read_file(copy, unit="g").units.startswith("units: counts, divided by")


def sac_pair(folder: Path, north: float, east: float, **header: float) -> tuple[Path, Path]:
    """Two SAC files of a sine to the north and to the east, named so that east comes first."""
    paths = []
    for code, size in (("HNE", east), ("HNN", north)):
        trace = obspy.Trace(size * np.sin(np.arange(200) * 0.3), {"delta": 0.01, "channel": code, "station": "A"})
        if header:
            trace.stats.sac = {"cmpaz": header[code], "cmpinc": 90.0}
        paths.append(folder / f"{code}.sac")
        trace.write(str(paths[-1]), format="SAC")
    return tuple(paths)


@pytest.mark.parametrize("stated", [{}, {"HNE": 70.0, "HNN": 340.0}], ids=["by name", "CMPAZ"])
def test_sac_says_where_its_components_point(tmp_path, stated):
    """Along 30° from north the files are n cos(30° - a_n) + e cos(30° - a_e)."""
    sac_pair(tmp_path, 3.0, 1.0, **stated)
    request = RecordRequest(files=("*.sac",), processing="none", unit="m/s^2", direction=30.0)
    (motion,) = read_ensemble(request, tmp_path).motions
    north, east = np.radians([stated.get("HNN", 0.0), stated.get("HNE", 90.0)])
    size = 3.0 * np.cos(np.radians(30.0) - north) + np.cos(np.radians(30.0) - east)
    # SAC has samples of four bytes.
    np.testing.assert_allclose(motion.acceleration, size * np.sin(np.arange(200) * 0.3), atol=1e-6 * abs(size))
    assert not any("azimuths are unknown" in flag for flag in motion.flags)


def test_a_vertical_by_its_name_points_nowhere(tmp_path):
    """A channel Z of SAC whose CMPAZ is 0 and whose CMPINC is not set."""
    trace = obspy.Trace(np.sin(np.arange(200) * 0.3), {"delta": 0.01, "channel": "HNZ", "station": "A"})
    trace.stats.sac = {"cmpaz": 0.0}
    trace.write(str(tmp_path / "a.sac"), format="SAC")
    record = open_source(tmp_path / "a.sac", unit="m/s^2").record
    assert is_vertical(record) and record["azimuth"] is None


def test_a_vertical_is_one_by_its_direction_whatever_its_name(tmp_path):
    """A channel 3 with CMPINC 0 in SAC, as columns too, and with a dip of -90 degrees in a StationXML."""
    trace = obspy.Trace(np.sin(np.arange(200) * 0.3), {"delta": 0.01, "channel": "HN3", "station": "A"})
    trace.stats.sac = {"cmpaz": 0.0, "cmpinc": 0.0}
    trace.write(str(tmp_path / "a.sac"), format="SAC")
    assert is_vertical(open_source(tmp_path / "a.sac", unit="m/s^2").record)
    write_motion(read_motion(tmp_path / "a.sac", unit="m/s^2", processing="none"), tmp_path / "a.csv")
    assert is_vertical(open_source(tmp_path / "a.csv").record)
    level = (tmp_path / "a.csv").read_text("utf-8").replace("# vertical = True", "# vertical = false")
    (tmp_path / "level.csv").write_text(level, "utf-8")
    assert not is_vertical(open_source(tmp_path / "level.csv").record)
    shutil.copy(catalogue.path("CCC-HN1"), tmp_path / "CCC.mseed")
    text = (catalogue.records_folder() / "CI.CCC.xml").read_text("utf-8")
    (tmp_path / "CI.CCC.xml").write_text(re.sub(r"<Dip[^>]*>[^<]*</Dip>", "<Dip>-90</Dip>", text), "utf-8")
    assert is_vertical(open_source(tmp_path / "CCC.mseed").record)


def test_channels_that_measure_no_acceleration_are_passed_over(tmp_path):
    """One of two traces is a seismometer's by the StationXML; the other is read, and says so."""
    shutil.copy(catalogue.records_folder() / "CI.CCC.xml", tmp_path)
    text = (tmp_path / "CI.CCC.xml").read_text("utf-8")
    stream = obspy.read(str(catalogue.path("CCC-HN1")), format="MSEED")
    code = stream[0].stats.channel
    other = stream[0].copy()
    other.stats.channel = "HH1"
    channel = re.search(rf'<Channel code="{code}".*?</Channel>', text, re.S)[0]
    seismometer = channel.replace(f'code="{code}"', 'code="HH1"').replace("M/S**2", "M/S").replace("m/s**2", "m/s")
    (tmp_path / "CI.CCC.xml").write_text(text.replace(channel, channel + seismometer), "utf-8")
    obspy.Stream([stream[0], other]).write(str(tmp_path / "both.mseed"), format="MSEED")
    (one,) = read_components(tmp_path / "both.mseed")
    assert one.trace.stats.channel == code
    assert "1 of the file's channels measure no acceleration, such as CI.CCC" in one.units
    obspy.Stream([other]).write(str(tmp_path / "other.mseed"), format="MSEED")
    assert "which is no acceleration" in refusal(read_components, tmp_path / "other.mseed")


def test_a_sensitivity_in_volts_is_none_in_counts(tmp_path):
    shutil.copy(catalogue.path("CCC-HN1"), tmp_path / "CCC.mseed")
    text = (catalogue.records_folder() / "CI.CCC.xml").read_text("utf-8")
    volts = re.sub(r"(<OutputUnits>\s*<Name>)[^<]*", r"\g<1>V", text)
    (tmp_path / "CI.CCC.xml").write_text(volts, "utf-8")
    assert "is in V and not in counts" in refusal(read_file, tmp_path / "CCC.mseed")


@pytest.mark.filterwarnings("ignore:Set the output units of stage")
@pytest.mark.parametrize("factor", [1.04, 1.06, 2.0, -1.0, None])
def test_a_total_sensitivity_is_compared_with_the_gains_of_its_stages(tmp_path, factor, says):
    """ObsPy's removal of the response goes by the stages: 5 % is what the two may differ by."""
    path = Path(shutil.copy(catalogue.path("CCC-HN1"), tmp_path))
    inventory = obspy.read_inventory(str(catalogue.records_folder() / "CI.CCC.xml"))
    for channel in inventory[0][0]:
        if factor is None:
            channel.response.instrument_sensitivity = None
        else:
            channel.response.instrument_sensitivity.value *= factor
    inventory.write(str(tmp_path / "CI.CCC.xml"), format="STATIONXML")
    if factor == 1.04:
        by_stages = obspy.read(str(path), format="MSEED")[0].remove_response(inventory, output="ACC", water_level=None)
        ours = read_file(path).trace.data
        assert np.ptp(by_stages.data) / np.ptp(ours) == pytest.approx(factor, rel=1e-6)  # a float of a taper
    else:
        says(refusal(read_file, path).replace(str(tmp_path), "FOLDER"))
