"""Tables of the commands on records: lists of records, the facts of one, the results of processing and selection."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pounding_risk.cli._common.notes import print_notes
from pounding_risk.cli._common.tables import engineering, print_pairs, print_table
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.motions.catalogue import Entry
    from pounding_risk.motions.motion import Motion
    from pounding_risk.motions.record import Source
    from pounding_risk.motions.selection import Selection

SPECTRUM = (0.2, 0.5, 1.0, 2.0)  # s
HEADS = ("record", "event", "date", "station", "component", "state", "PGA", "duration", "dt")
# Units of facts of a record, by key.
UNITS = {"distance_km": "km", "azimuth": "° from north", "vs30": "m/s"}
FREQUENCIES = ("low_corner", "high_corner", "lowest_usable_frequency")  # Hz
SIZES = {"header_pga": "m/s2", "header_pgv": "m/s", "header_pgd": "m", "pgv_peer": "m/s"}


def print_records(entries: Sequence[Entry]) -> None:
    """Print entries of the catalogue, one line a record."""
    print_table(HEADS, [_cells(asdict(entry), entry.pga, entry.duration, entry.dt) for entry in entries], "llllllrrr")


def print_sources(sources: Sequence[Source]) -> None:
    """Print records that were read, one line each."""
    from pounding_risk.motions.source import file_name

    rows = []
    for source in sources:
        stats = source.trace.stats
        facts = {**source.record, "id": file_name(source)}
        rows.append(_cells(facts, source.record["pga_recorded"], (stats.npts - 1) * stats.delta, stats.delta))
    print_table(HEADS, rows, "llllllrrr")


def _cells(facts: Mapping[str, Any], pga: float, duration: float, dt: float) -> tuple[str, ...]:
    """Cells of a record, from its facts, PGA [m/s2], duration [s] and time step [s]."""
    words = [_one_line(facts.get(key) or "") for key in ("id", "event", "date", "station", "component", "state")]
    return *words, engineering(pga, "m/s2", 3), f"{duration:.4g} s", f"{dt:.4g} s"


def print_record(entry: Entry) -> None:
    """Print the catalogue's entry of a record, where its file is, and its intensity measures and checks."""
    from pounding_risk.motions.catalogue import path

    values = {key: value for key, value in asdict(entry).items() if value not in ("", None)}
    values |= {"dt": f"{entry.dt:g} s", "duration": f"{entry.duration:g} s", "PGA": engineering(entry.pga, "m/s2")}
    del values["pga_g"]
    if entry.sensitivity == 1.0:
        del values["sensitivity"]
    else:
        values["sensitivity"] = f"{entry.sensitivity:.8g} counts per m/s²"
    if entry.azimuth is not None:
        values["azimuth"] = f"{entry.azimuth:g}° from north"
    has_file = True
    try:
        values["file"] = str(path(entry.id))
    except PoundingError as error:
        has_file, values["file"] = False, str(error)
    print_pairs((key, _one_line(value)) for key, value in values.items())
    if has_file:
        from pounding_risk.motions.source import open_source

        _print_intensity(open_source(entry.id))


def print_source(source: Source) -> None:
    """Print what a file says of its record, and its intensity measures and checks."""
    stats = source.trace.stats
    values = {key: _fact_words(key, value) for key, value in source.record.items() if value not in ("", None)}
    del values["pga_recorded"]
    if values.get("source") == values.get("file"):
        values.pop("source", None)
    values |= {"units": source.units.removeprefix("units: "), "npts": str(stats.npts), "dt": f"{stats.delta:g} s"}
    values |= {"duration": f"{(stats.npts - 1) * stats.delta:g} s"}
    values |= {"PGA": engineering(source.record["pga_recorded"], "m/s2")}
    print_pairs((key.removesuffix("_km").replace("_", " "), _one_line(value)) for key, value in values.items())
    _print_intensity(source)


def _fact_words(key: str, value: Any) -> str:
    """A fact of a record with its unit."""
    if key in FREQUENCIES:
        return f"{value:.4g} Hz"
    if key in SIZES:
        return engineering(float(value), SIZES[key])
    if isinstance(value, float):
        unit = UNITS.get(key, "")
        return f"{value:g}{unit if unit.startswith('°') else f' {unit}'}".rstrip()
    return str(value)


def _print_intensity(source: Source) -> None:
    """Print the intensity measures of a record as a run takes it, and the checks of its quality."""
    from pounding_risk.motions.read import read_motion

    motion = read_motion(source)
    print()
    print_table(("measure", "value", "meaning"), _measures(motion), "lrl")
    print()
    print_table(("check, as recorded", "met", "found", "allowed"), _findings(source), "llll")
    print_notes(motion.flags)


def _findings(source: Source) -> Iterator[tuple[str, str, str, str]]:
    """Name, outcome, value and limit of each check of a record as it was recorded."""
    from pounding_risk.motions.quality import quality

    trace = source.trace
    for finding in quality(trace.data, trace.stats.delta, state=source.record["state"]):
        yield finding.check, "yes" if finding.passed else "no", finding.found, finding.allowed


def _measures(motion: Motion) -> Iterator[tuple[str, str, str]]:
    """Name, value and meaning of each intensity measure of a record as a run takes it."""
    from pounding_risk.motions.intensity import measure, response_spectra
    from pounding_risk.motions.record import RAW

    measures = measure(motion.acceleration, motion.dt)
    state = ", processed as for a run" if motion.record["state"] == RAW else ""
    yield "PGA", engineering(measures.pga, "m/s2"), f"peak ground acceleration{state}"
    yield "PGV", engineering(measures.pgv, "m/s"), "peak ground velocity"
    yield "PGD", engineering(measures.pgd, "m"), "peak ground displacement"
    yield "Arias", engineering(measures.arias, "m/s"), "Arias intensity"
    yield "CAV", engineering(measures.cav, "m/s"), "cumulative absolute velocity"
    yield "D5-75", engineering(measures.d5_75, "s"), "from 5 to 75 % of the Arias intensity"
    yield "D5-95", engineering(measures.d5_95, "s"), "from 5 to 95 % of the Arias intensity"
    spectra = response_spectra(motion.acceleration, motion.dt, SPECTRUM)
    for period, value in zip(SPECTRUM, spectra.pseudo_acceleration, strict=True):
        yield f"Sa({period:g} s)", engineering(value, "m/s2"), "pseudo-spectral acceleration, damping 5 %, as in codes"


def print_processed(motions: Sequence[Motion], targets: Sequence[Path | None]) -> None:
    """Print the processing steps and flags of each record, then a table with a line for each."""
    for motion in motions:
        print(motion.name)
        print("\n".join(f"  {_one_line(sentence)}" for sentence in motion.processing))
        print("".join(f"  note: {flag}\n" for flag in motion.flags))
    heads = ("record", "PGA as recorded", "PGA", "PGV", "PGD", "velocity at the end", "displacement at the end", "dt")
    rows = [_processed_cells(motion) for motion in motions]
    if any(targets):
        rows = [(*row, str(target)) for row, target in zip(rows, targets, strict=True)]
        print_table((*heads, "written"), rows, "lrrrrrrrl")
    else:
        print_table(heads, rows, "lrrrrrrr")


def _processed_cells(motion: Motion) -> tuple[str, ...]:
    from pounding_risk.motions.intensity import measure

    measures = measure(motion.acceleration, motion.dt)
    velocity, displacement = motion.velocity_displacement()
    return (
        motion.name,
        engineering(motion.record.get("pga_recorded", nan), "m/s2"),  # a turned motion was not recorded
        engineering(measures.pga, "m/s2"),
        engineering(measures.pgv, "m/s", 3),
        engineering(measures.pgd, "m", 3),
        engineering(velocity[-1], "m/s", 2),
        engineering(displacement[-1], "m", 2),
        f"{motion.dt:.4g} s",
    )


def print_selection(selection: Selection) -> None:
    """Print the chosen records, closest first, each with its factor, then what was chosen from and how."""
    rows = [
        (
            row.name,
            f"{row.factor:.3f}{' (limit)' if row.limited else ''}",
            f"{row.misfit:.3f}",
            *(_known(row.known(key), unit) for key, unit in (("magnitude", ""), ("distance_km", " km"))),
            _one_line(", ".join(str(row.known(key)) for key in ("event", "date") if row.known(key))),
        )
        for row in selection.rows
    ]
    print_table(("record", "factor", "misfit", "magnitude", "distance", "event"), rows, "lrrrrl")
    print()
    pairs = (sentence.partition(": ") for sentence in selection.words())
    print_pairs((what, words) for what, _, words in pairs)
    print_notes(f"{row.name}: {doubt}" for row in selection.rows for doubt in row.doubts)


def _known(value: Any, unit: str) -> str:
    return "–" if value is None else f"{float(value):.4g}{unit}"


def _one_line(words: Any) -> str:
    return " ".join(str(words).split())
