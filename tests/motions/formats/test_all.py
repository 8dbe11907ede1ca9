"""Every format against every sample: what it holds, by whom it is claimed, and what is said of faults and damage.

Samples are the files of tests/data/formats named after a format, the catalogue's, and those that ObsPy ships for its
own tests. Were a file claimed twice, the order of a list would decide how it is read.
"""

import gzip
import inspect
import json
import os
import subprocess
import sys
from importlib import metadata
from io import BytesIO
from pathlib import Path

import damage
import numpy as np
import obspy
import pytest
import test_columns
import test_cosmos
import test_csmip
import test_esm
import test_geonet
import test_native
import test_peer_at2
import test_smc
from real_files import DATA, G, read
from sentences import refusal

from pounding_risk.motions import catalogue
from pounding_risk.motions.formats import formats, read_components, readable

FORMATS = {format.name: format for format in formats()}
STATED = {"SAC": {"unit": "m/s^2"}, "SIMCENTER": {"unit": "g"}}  # what the samples of a format need to be said
# The tests of each text format, which have tables of its SPELLINGS and of BAD files.
MODULES = {
    "COSMOS": test_cosmos,
    "CSMIP": test_csmip,
    "ESM": test_esm,
    "GEONET": test_geonet,
    "PEER_AT2": test_peer_at2,
    "SMC": test_smc,
}
BAD = {**{name: module.BAD for name, module in MODULES.items()}, "COLUMNS": test_columns.BAD, **test_native.bad()}
# Of a file's first component, by how much the largest sample may differ from the header's [m/s²]: digits of either.
PEAKS = {
    **{"cosmos-pomona.v1c": 1e-13, "cosmos-bremner.v2c": 1e-13, "cosmos-yucaipa.v1": 5e-6},
    **{"csmip-parkfield.v2": 1e-13, "csmip-pomona.v1": 1e-5, "csmip-hesperia.raw": 5e-3},
    **{"esm-dlfa-hne.asc": 5e-9, "esm-dlfa-hnn.asc": 5e-9, "geonet-thz.v1a": 5e-5, "geonet-thz.v2a": 5e-5},
    **{"smc-shafter.smc": 5e-5, "smc-alhambra-raw.smc": 5e-5, "smc-alhambra-up.smc": 5e-5},
}
MANY, FEW = 2000, 60
TIME_LIMIT = 300  # s, for all damaged files of all formats: a hang, as they take about 20


@pytest.fixture(scope="session")
def samples(tmp_path_factory):
    """Paths of whole files of each format, by its name."""
    folder = tmp_path_factory.mktemp("formats")
    found = {name: [] for name in FORMATS}
    for path in sorted(DATA.glob("*-*")):
        target = folder / path.name.removesuffix(".gz")
        target.write_bytes(gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes())
        found[path.name.partition("-")[0].upper()].append(target)
    for entry in catalogue.entries():
        found[entry.format].append(catalogue.path(entry.id))
    found["KNET"].append(damage.KNET)
    found["KINEMETRICS_EVT"] += damage.EVTS
    found["SAC"].append(folder / "napa.sac")
    found["SAC"][-1].write_bytes(damage.written(damage.whole_numbers(2000), "SAC"))
    return found


def facts(trace, name):
    """What a trace and its header say, in lines."""
    stats, data = trace.stats, trace.data
    yield f"{trace.id}: {stats.npts} samples every {stats.delta:.9g} s from {stats.starttime}, in {data.dtype}"
    numbers = (data[0], data[-1], data.min(), data.max(), np.abs(data).mean())
    yield "  first, last, least, largest, mean size: " + ", ".join(f"{number:.8g}" for number in numbers)
    yield "  " + ", ".join(f"{key}: {value}" for key, value in stats.record.items())
    own = stats.get(name.lower(), {})
    if 0 < len(own) < 20:
        yield "  " + ", ".join(f"{key}: {value}" for key, value in own.items())


@pytest.mark.parametrize("name", FORMATS)
def test_what_the_files_hold(samples, name, says):
    assert samples[name], f"put a file {name.lower()}-*.* into {DATA}"
    for path in samples[name]:
        traces = FORMATS[name].read(path, folder=path.parent, **STATED.get(name, {}))
        says(path.name, [list(facts(trace, name)) for trace in traces])
        for trace in traces:
            peak = trace.stats.record.get("header_pga")
            assert path.name not in PEAKS or abs(np.abs(trace.data).max() - peak) <= PEAKS[path.name]


@pytest.mark.parametrize("name", FORMATS)
def test_what_the_short_files_hold(name, says, tmp_path):
    for raw in damage.short_files()[name]:
        unit = damage.unit_of(FORMATS[name])
        assert damage.outcome(FORMATS[name], raw, tmp_path / "short", unit, through_a_file=False) == "read"
        traces = FORMATS[name].read(BytesIO(raw), folder=catalogue.records_folder(), unit=unit)
        says([f"{trace.id}: " + ", ".join(f"{value:.9g}" for value in trace.data[:12]) for trace in traces])


@pytest.mark.parametrize(("name", "words"), [(name, words) for name in BAD for words in BAD[name]])
def test_files_with_faults(tmp_path, says, name, words):
    """Texts through a file of its suffix; columns and binary files, whose unit is given, from memory."""
    found = BAD[name][words]
    text, choices = found if isinstance(found, tuple) else (found, {"unit": "g"} if isinstance(found, bytes) else {})
    if name in MODULES:
        path = tmp_path / f"x{FORMATS[name].suffixes[0]}"
        path.write_bytes(raw_of(text))
        says(refusal(read_components, path))
    else:
        says(refusal(FORMATS[name].read, BytesIO(raw_of(text)), name="x", **choices))


@pytest.mark.parametrize("name", FORMATS)
def test_each_format_recognises_its_own_files_and_no_others(samples, name):
    for owner, paths in samples.items():
        for path in paths:
            with path.open("rb") as opened:
                claimed = [FORMATS[name].recognises(source) for source in (path, opened, BytesIO(path.read_bytes()))]
                assert opened.tell() == 0, "the position was moved"
            assert claimed == [owner == name] * 3, f"{name} on {path.name}"


@pytest.mark.parametrize("name", FORMATS)
def test_no_format_stumbles_over_what_is_no_file(name, tmp_path):
    others = (None, 3, tmp_path, tmp_path / "none", BytesIO(b""), BytesIO(b"\xff" * 9000), BytesIO(b"K" + bytes(9000)))
    assert [FORMATS[name].recognises(other) for other in others] == [False] * len(others)


@pytest.mark.parametrize("name", FORMATS)
def test_path_open_file_and_bytes_agree(samples, name):
    for path in samples[name]:
        choices = {"folder": path.parent, **STATED.get(name, {})}
        with path.open("rb") as opened:
            streams = [
                FORMATS[name].read(source, **choices)
                for source in (path, str(path), opened, BytesIO(path.read_bytes()))
            ]
        found = read_components(path, **STATED.get(name, {}))
        assert {each.format for each in found} == {name}
        for traces in [*streams[1:], [each.trace for each in found]]:
            for trace, first in zip(traces, streams[0], strict=True):
                assert np.array_equal(trace.data, first.data)
                assert trace.data.dtype == np.float64
                assert trace.stats.calib == 1.0
                assert (trace.id, trace.stats.delta, trace.stats.record) == (
                    (first.id, first.stats.delta, first.stats.record)
                )


@pytest.mark.parametrize("name", FORMATS)
def test_components_of_a_file_have_names_of_their_own(samples, name):
    for path in samples[name]:
        found = read_components(path, **STATED.get(name, {}))
        names = {each.component.lower() for each in found}
        assert len(names) == len(found)
        assert len(found) == 1 or all(names)


@pytest.mark.parametrize(
    "name", [name for name in FORMATS if "headonly" in inspect.signature(FORMATS[name].read).parameters]
)
def test_a_head_alone_has_the_numbers_and_no_samples(samples, name):
    for path in samples[name]:
        whole, heads = (FORMATS[name].read(path, headonly, **STATED.get(name, {})) for headonly in (False, True))
        for trace, head in zip(whole, heads, strict=True):
            assert (head.stats.npts, len(head.data)) == (len(trace.data), 0)
            assert (head.id, head.stats.delta, head.stats.record.units) == (
                (trace.id, trace.stats.delta, trace.stats.record.units)
            )


def raw_of(text):
    return text if isinstance(text, bytes) else text.encode("latin-1")


@pytest.mark.parametrize(("name", "words"), [(name, words) for name in MODULES for words in MODULES[name].SPELLINGS])
def test_spellings_that_mean_the_same(name, words):
    one, other = (FORMATS[name].read(BytesIO(raw_of(text))) for text in MODULES[name].SPELLINGS[words])
    for trace, same in zip(one, other, strict=True):
        assert np.array_equal(trace.data, same.data)
        assert (trace.stats.delta, trace.stats.record.state) == (same.stats.delta, same.stats.record.state)


FILM = pytest.mark.parametrize(
    ("film", "size", "units"),
    [
        (test_csmip.film, 0.1 * G, "units: g/10, times 0.980665 m/s²"),
        (test_smc.film, 0.01, "units: cm/s², times 0.01"),
    ],
    ids=["CSMIP", "SMC"],
)


@FILM
def test_film_at_even_times_is_read_as_such(film, size, units):
    trace = read(film(0.005 * np.arange(6), test_smc.VALUES))[0]
    assert trace.stats.delta == pytest.approx(0.005, rel=1e-12)
    assert trace.data == pytest.approx(size * np.array(test_smc.VALUES), rel=1e-12)
    assert (trace.stats.record.state, trace.stats.record.units) == ("raw", units)


@FILM
def test_film_at_uneven_times_is_read_on_straight_lines_at_the_step_that_is_asked_for(film, size, units):
    trace = read(film([0.0, 0.004, 0.010, 0.014, 0.020, 0.030], test_smc.VALUES), dt=0.005)[0]
    expected = [1.0, 2.0 + 1.0 / 6.0, 3.0, 4.0 + 1.0 / 6.0, 5.0, -0.5, -6.0]
    assert trace.data == pytest.approx(size * np.array(expected), rel=1e-12)
    assert (trace.stats.npts, trace.stats.delta) == (7, 0.005)
    assert trace.stats.record.units == f"{units}, uneven times read at every 0.005 s"


def test_the_list_of_formats_names_each():
    assert all(format.words in readable() for format in FORMATS.values())


@pytest.mark.parametrize("name", [name for name, format in FORMATS.items() if not (format.native or format.needs)])
def test_obspy_reads_the_format_by_itself(samples, name):
    """Through the entry points of the installed package, in anyone's script."""
    if not metadata.entry_points(group="obspy.plugin.waveform", name=name):
        pytest.skip("the package is not installed, so ObsPy cannot know its formats")
    for path in samples[name]:
        assert {trace.stats._format for trace in obspy.read(str(path))} == {name}


# --- damage -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FORMATS)
def test_damaged_files_end_in_a_sentence_or_in_sound_samples(name, tmp_path):
    """A few of those below, in every run of the tests."""
    found = damage.survey(FORMATS[name], damage.originals(name), FEW, tmp_path)
    assert found["faults"] == []
    assert found["refused"] > FEW // 2


@pytest.fixture(scope="module")
def report():
    """What came of thousands of damaged files, by format, from a process that may crash or hang."""
    script = Path(damage.__file__)
    # Of the package, of this folder, and of what its modules share with other tests.
    paths = os.pathsep.join(map(str, (Path(catalogue.__file__).parents[2], script.parent, script.parents[2])))
    environment = {**os.environ, "PYTHONPATH": paths, "PYTHONHASHSEED": "0"}
    run = subprocess.run(
        [sys.executable, str(script), str(MANY)], env=environment, capture_output=True, text=True, timeout=TIME_LIMIT
    )
    assert run.stderr == "", "something was printed, or the process crashed"
    assert run.returncode == 0, run.stdout[-500:]
    return {line["format"]: line for line in map(json.loads, run.stdout.splitlines()) if "faults" in line}


@pytest.mark.complete
@pytest.mark.parametrize("name", FORMATS)
def test_thousands_of_damaged_files(report, name):
    found = report[name]
    assert found["faults"] == []
    assert found["refused"] + found["read"] == MANY
    assert found["refused"] > MANY // 2  # most damage of a file this short is to its header or its layout
