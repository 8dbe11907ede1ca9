"""The real records that come with the project: found by id, checked by checksum, read in m/s².

``records/catalogue.toml`` names each with its origin and terms. Some files are shipped beside it; those whose
terms allow no copy are read from the installed package that carries them. A file is used only if its sha256
is the one of the catalogue, so that a result can be traced to the bytes of its records.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from hashlib import sha256
from importlib import metadata
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from pounding_risk.errors import RecordError
from pounding_risk.motions.generated import is_recipe
from pounding_risk.motions.record import Source
from pounding_risk.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from obspy import Stream

CATALOGUE = "catalogue.toml"
NEAREST, SHORTEST_WORD = 3, 4  # ids that are suggested; letters by which a station is looked for
PER = {"g": STANDARD_GRAVITY, "m/s^2": 1.0}  # m/s²


@dataclass(frozen=True)
class Entry:
    """A component of a recording in the catalogue, and what its file must hold.

    ``pga_g`` is max|a| as recorded [standard gravity]: of the samples where they are processed, of the
    samples less their mean where they are raw. ``sensitivity`` is in counts per m/s², 1 for a file of
    physical values.
    """

    id: str
    event: str
    magnitude: float
    date: str  # year-month-day
    station: str
    component: str
    azimuth: float | None  # degrees clockwise from north; None for a vertical
    state: str  # "raw" or "processed"
    format: str  # ObsPy's name of the file format
    file: str  # below the records folder, or below the package's site folder
    sha256: str
    pga_g: float
    dt: float  # s
    npts: int
    origin: str
    terms: str
    sensitivity: float = 1.0
    package: str = ""  # the distribution that carries the file; "" where it is shipped
    version: str = ""
    note: str = ""

    @property
    def horizontal(self) -> bool:
        """True for a horizontal component, which has an azimuth."""
        return self.azimuth is not None

    @property
    def pga(self) -> float:
        """Peak ground acceleration max|a| of the record as it is in its file [m/s²]."""
        return self.pga_g * STANDARD_GRAVITY

    @property
    def duration(self) -> float:
        """Time from the first sample to the last [s]."""
        return (self.npts - 1) * self.dt


def records_folder() -> Path:
    """The folder of the catalogue and the shipped records: in the installed package, or beside it.

    Raises RecordError where neither is there.
    """
    installed = Path(__file__).resolve().parent / "records"
    checkout = Path(__file__).resolve().parents[2] / "records"
    for folder in (installed, checkout):
        if (folder / CATALOGUE).is_file():
            return folder
    raise RecordError(
        f"{installed}: no {CATALOGUE} there, nor in {checkout}; the installation "
        "is incomplete: pip install --force-reinstall pounding-risk"
    )


def entries() -> list[Entry]:
    """List the records of the catalogue.

    Returns
    -------
    list of Entry
        Every record, in the order of the catalogue.
    """
    return list(_catalogue().values())


def entry(id: str, also: Iterable[str] = ()) -> Entry:
    """The record of an id; raises RecordError for another id, with the nearest ones, those of ``also`` included."""
    entries_by_id = _catalogue()
    if id not in entries_by_id:
        near = similar(id, also)
        meant = f"did you mean {' or '.join(near)}?" if near else f"the catalogue has {', '.join(entries_by_id)}"
        raise RecordError(f'"{id}" is not a record of the catalogue; {meant}')
    return entries_by_id[id]


def path(id: str) -> Path:
    """The path of the file of a record.

    Raises RecordError for an unknown id, a package that is not installed, and a missing file.
    """
    record = entry(id)
    if not record.package:
        file = records_folder() / record.file
        repair = "the installation is incomplete: pip install --force-reinstall pounding-risk"
    else:
        repair = f"pip install {record.package}=={record.version}"
        try:
            installed = metadata.distribution(record.package)
        except metadata.PackageNotFoundError:
            raise RecordError(
                f'record "{id}" is read from the package {record.package}, which is not installed; {repair}'
            ) from None
        file = Path(str(installed.locate_file(record.file)))
        if installed.version != record.version:
            repair = f"{record.package} {installed.version} is installed, {record.version} is needed: {repair}"
    if not file.is_file():
        raise RecordError(f'record "{id}": no such file {file}; {repair}')
    return file


def read_bytes(id: str) -> bytes:
    """The bytes of the file of a record; raises RecordError where their sha256 is not the catalogue's."""
    record, file = entry(id), path(id)
    raw = file.read_bytes()
    digest = sha256(raw).hexdigest()
    if digest != record.sha256:
        package = f"{record.package}=={record.version}" if record.package else "pounding-risk"
        raise RecordError(
            f'record "{id}": {file} has sha256 {digest[:12]}..., the catalogue says {record.sha256[:12]}...: '
            f"the file was changed; pip install --force-reinstall {package}"
        )
    return raw


def load(id: str) -> Stream:
    """The record as an ObsPy stream of one trace: acceleration in m/s², float64, ``stats.calib`` 1.

    Nothing is processed: raw records keep their offset and drift.

    Raises RecordError for an unknown id, a missing package or file, and a file that is not the catalogue's.
    """
    record = entry(id)
    raw = read_bytes(id)
    if record.format == "PEER_AT2":
        from pounding_risk.motions.formats.peer_at2 import FORMAT  # reads without the entry point, too

        stream = FORMAT.read(BytesIO(raw), name=record.file)
    else:
        import obspy  # takes 0.2 s, and listing the catalogue needs none of it

        stream = obspy.read(BytesIO(raw), format=record.format)
    if len(stream) != 1:
        raise RecordError(f'record "{id}": {len(stream)} traces in {record.file}, the catalogue promises one')
    trace = stream[0]
    trace.data = trace.data.astype(float) / record.sensitivity
    trace.stats.calib = 1.0
    if trace.stats.npts != record.npts or trace.stats.delta != record.dt:
        raise RecordError(
            f'record "{id}": {trace.stats.npts} samples at {trace.stats.delta:g} s in {record.file}, the '
            f"catalogue promises {record.npts} at {record.dt:g} s"
        )
    return stream


def source(id: str, also: Iterable[str] = ()) -> Source:
    """The record as a source, with its facts; raises as `load`, and as `entry`."""
    known = entry(id, also)
    trace = load(id)[0]
    keys = ("id", "event", "magnitude", "date", "station", "component", "azimuth", "state", "format", "file")
    record = {key: getattr(known, key) for key in (*keys, "package", "version", "sha256", "origin", "terms", "note")}
    if known.format == "PEER_AT2":
        return Source(id, trace, record, "units: g, times 9.80665 m/s²")
    record["start"] = trace.stats.starttime.isoformat()
    return Source(id, trace, record, f"units: counts, divided by {known.sensitivity:.10g} counts per m/s²")


@lru_cache(maxsize=1)
def _catalogue() -> dict[str, Entry]:
    """Every record by its id; a component's keys override those of its recording and source."""
    tables = tomllib.loads((records_folder() / CATALOGUE).read_text(encoding="utf-8"))
    records: dict[str, Entry] = {}
    for recording in tables["recording"]:
        shared = {key: fact for key, fact in recording.items() if key not in ("component", "source")}
        source = tables["source"][recording["source"]]
        for component in recording["component"]:
            facts = {**source, **shared, **component, "date": recording["date"].isoformat()}
            facts["azimuth"] = float(facts["azimuth"]) if "azimuth" in facts else None
            if "sensitivity" in facts:
                facts["sensitivity"] = facts["sensitivity"]["counts"] / PER[facts["sensitivity"]["per"]]
            records[facts["id"]] = Entry(**facts)
    return records


def similar(id: str, also: Iterable[str] = ()) -> list[str]:
    """Ids near to the one requested, best first: of the same letters, then similar, then by earthquake or station.

    Ids of the same recording come alone where there are any; ``also`` are ids beside those of the catalogue.
    """
    names = [*_catalogue(), *also]
    same = [name for name in names if name.lower() == id.lower()]
    sisters = [name for name in names if name.lower().partition("-")[0] == id.lower().partition("-")[0]]
    folded = {name.lower(): name for name in sisters or names}
    near = same or [folded[name] for name in get_close_matches(id.lower(), list(folded), NEAREST, 0.6)]
    word = _letters(id)
    if near or len(word) < SHORTEST_WORD:
        return near
    named = [record for record in entries() if word in _letters(f"{record.event} {record.station}")]
    return [record.id for record in named if record.horizontal][:NEAREST]


def _letters(text: str) -> str:
    return "".join(letter for letter in text.lower() if letter.isalnum())


def has(id: str) -> bool:
    """True for an id of the catalogue."""
    return id in _catalogue()


def is_file(name: str) -> bool:
    """True for what names a file, or a pattern of them, rather than an id, ids joined by "+" or a generated motion."""
    return not is_recipe(name) and not all(map(has, name.split("+")))
