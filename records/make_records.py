"""How the shipped MiniSEED and StationXML files were made; not needed to use the package.

    pip download --no-deps gmprocess==2.8.0
    pip install obspy h5py
    python records/make_records.py gmprocess-2.8.0-py3-none-any.whl records

The wheel of gmprocess (U.S. Geological Survey, CC0) carries both sources:

* ``CICCC.RAW``: the uncorrected accelerograms of station CI.CCC in the 2019 Ridgecrest M7.1 earthquake, text
  in g with six decimals. The first 150 s are kept as integers in micro-g, so nothing is rounded: 1 000 000
  counts are 1 g. A StationXML file states that sensitivity.
* ``workspace.h5``: the counts of station CE.68150 in the 2014 South Napa earthquake as the digitiser gave
  them, 119 s, and the StationXML of the Northern California Earthquake Data Center. Both are kept unchanged.
"""

from __future__ import annotations

import argparse
import io
import zipfile
from pathlib import Path

import h5py
import numpy as np
from obspy import Trace, UTCDateTime
from obspy.core.inventory import Channel, Inventory, Network, Response, Site, Station
from obspy.core.inventory.response import InstrumentSensitivity, ResponseStage

RIDGECREST = "gmprocess/data/demo/ci38457511/raw/CICCC.RAW"
NAPA = "gmprocess/data/demo/nc72282711/workspace.h5"
SECONDS = 150  # of the 354 s: 20 s before the earthquake, the shaking and its coda
COUNTS_PER_G = 1_000_000
STANDARD_GRAVITY = 9.80665
CHANNELS = {"90": ("HN2", 90.0, 0.0), "360": ("HN1", 0.0, 0.0), "Up": ("HNZ", 0.0, -90.0)}
CCC_START = UTCDateTime("2019-07-06T03:19:37.0")
COLUMN, COLUMNS = 9, 8  # the file's own statement: Format (8f9.6)


def ridgecrest_traces(text: str) -> list[Trace]:
    """The components of a CGS volume-1 text, cut to ``SECONDS``, as integer micro-g."""
    return [_component(block.splitlines()) for block in text.split("/&") if "Accelerogram points" in block]


def _component(lines: list[str]) -> Trace:
    """One block: a fixed text header, then columns of nine characters."""
    direction = next(line for line in lines if line.startswith("Chan ")).split(":")[1].split()[0]
    at = next(number for number, line in enumerate(lines) if "Accelerogram points" in line)
    points, rate = int(lines[at].split()[0]), float(lines[at].split()[4])
    values = []
    for line in lines[at + 1 :]:
        row = line.ljust(COLUMN * COLUMNS)
        cells = [row[start : start + COLUMN] for start in range(0, COLUMN * COLUMNS, COLUMN)]
        values += [float(cell) for cell in cells if cell.strip()]
    if len(values) != points:
        raise SystemExit(f"component {direction}: {points} points promised, {len(values)} found")
    counts = np.rint(np.array(values) * COUNTS_PER_G).astype(np.int32)
    channel = CHANNELS[direction][0]
    header = {"network": "CI", "station": "CCC", "channel": channel, "starttime": CCC_START}
    return Trace(counts[: int(SECONDS * rate)], {**header, "sampling_rate": rate})


def ridgecrest_inventory() -> Inventory:
    """The sensitivity of the integers above, as StationXML."""
    place = {"latitude": 35.524950, "longitude": -117.364500, "elevation": 670.0}
    gain = (COUNTS_PER_G / STANDARD_GRAVITY, 1.0, "M/S**2", "COUNTS")  # at 1 Hz
    sensitivity = InstrumentSensitivity(*gain)
    stage = ResponseStage(1, *gain)
    channels = [
        Channel(code, "", depth=0.0, azimuth=azimuth, dip=dip, sample_rate=100.0, **place)
        for code, azimuth, dip in CHANNELS.values()
    ]
    for channel in channels:
        channel.response = Response(instrument_sensitivity=sensitivity, response_stages=[stage])
    site = Site("China Lake NWC, Christmas Canyon Rd.")
    station = Station("CCC", site=site, channels=channels, creation_date=CCC_START, **place)
    network = Network("CI", [station], description="Southern California Seismic Network")
    return Inventory([network], source="pounding_risk", created=UTCDateTime("2019-07-06T00:00:00"))


def napa_traces(book: h5py.File) -> list[Trace]:
    """The unprocessed counts of CE.68150."""
    station = book["Waveforms/CE.68150"]
    traces = []
    for name in sorted(name for name in station if name.endswith("_unprocessed")):
        samples, facts = station[name][()], station[name].attrs
        channel = name.split("__")[0].split(".")[-1]
        header = {"network": "CE", "station": "68150", "channel": channel}
        start = UTCDateTime(ns=int(facts["starttime"]))
        rate = float(facts["sampling_rate"])
        traces.append(Trace(samples, {**header, "starttime": start, "sampling_rate": rate}))
    return traces


def main() -> None:
    """Write every shipped file into a folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("wheel", type=Path, help="gmprocess-2.8.0-py3-none-any.whl")
    parser.add_argument("folder", type=Path, help="where the files go")
    asked = parser.parse_args()
    with zipfile.ZipFile(asked.wheel) as wheel:
        ridgecrest = ridgecrest_traces(wheel.read(RIDGECREST).decode("ascii"))
        with h5py.File(io.BytesIO(wheel.read(NAPA))) as book:
            napa = napa_traces(book)
            (asked.folder / "CE.68150.xml").write_bytes(book["Waveforms/CE.68150/StationXML"][()].tobytes())
    ridgecrest_inventory().write(str(asked.folder / "CI.CCC.xml"), format="STATIONXML")
    for prefix, traces in (("CCC", ridgecrest), ("NAPA", napa)):
        for trace in traces:
            name = f"{prefix}-{trace.stats.channel}.mseed"
            trace.write(str(asked.folder / name), format="MSEED", encoding="STEIM2", reclen=4096)


if __name__ == "__main__":
    main()
