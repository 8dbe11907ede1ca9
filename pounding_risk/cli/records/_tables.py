"""The tables of the `records` commands: lists of records, what is known of one, what processing did."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pounding_risk.cli._common.tables import engineering, print_pairs, print_table
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.motions.catalogue import Entry
    from pounding_risk.motions.motion import Motion
    from pounding_risk.motions.record import Source
    from pounding_risk.motions.selection import Selection

SPECTRUM = (0.2, 0.5, 1.0, 2.0)  # s
HEADS = ("record", "event", "date", "station", "component", "state", "PGA", "duration", "dt")
# Facts of a record that have a unit: the unit, and what to call them where the key is no word.
UNITS = {"distance_km": "km", "azimuth": "° from north", "vs30": "m/s"}
FREQUENCIES = ("low_corner", "high_corner", "lowest_usable_frequency")  # Hz
SIZES = {"header_pga": "m/s2", "header_pgv": "m/s", "header_pgd": "m", "pgv_peer": "m/s"}


def print_records(entries: Sequence[Entry]) -> None:
    """The catalogue, one line a record."""
    print_table(HEADS, [_line(asdict(each), each.pga, each.duration, each.dt) for each in entries], "llllllrrr")


def print_sources(sources: Sequence[Source]) -> None:
    """Records that were read, one line each."""
    from pounding_risk.motions.source import file_name

    rows = []
    for each in sources:
        stats = each.trace.stats
        facts = {**each.record, "id": file_name(each)}
        rows.append(_line(facts, each.record["pga_recorded"], (stats.npts - 1) * stats.delta, stats.delta))
    print_table(HEADS, rows, "llllllrrr")


def _line(facts: Mapping[str, Any], pga: float, duration: float, dt: float) -> tuple[str, ...]:
    words = [_one_line(facts.get(key) or "") for key in ("id", "event", "date", "station", "component", "state")]
    return *words, engineering(pga, "m/s2", 3), f"{duration:.4g} s", f"{dt:.4g} s"


def print_record(entry: Entry) -> None:
    """All that the catalogue says about one record, where its file is, and how strong its motion is."""
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
    found = True
    try:
        values["file"] = str(path(entry.id))
    except PoundingError as error:
        found, values["file"] = False, str(error)
    print_pairs((key, _one_line(value)) for key, value in values.items())
    if found:
        from pounding_risk.motions.source import open_source

        print_strength(open_source(entry.id))


def print_source(source: Source) -> None:
    """All that a file says about its record, and how strong its motion is."""
    stats = source.trace.stats
    values = {key: _told(key, value) for key, value in source.record.items() if value not in ("", None)}
    del values["pga_recorded"]
    if values.get("source") == values.get("file"):
        values.pop("source", None)
    values |= {"units": source.units.removeprefix("units: "), "npts": str(stats.npts), "dt": f"{stats.delta:g} s"}
    values |= {"duration": f"{(stats.npts - 1) * stats.delta:g} s"}
    values |= {"PGA": engineering(source.record["pga_recorded"], "m/s2")}
    print_pairs((key.removesuffix("_km").replace("_", " "), _one_line(value)) for key, value in values.items())
    print_strength(source)


def _told(key: str, value: Any) -> str:
    if key in FREQUENCIES:
        return f"{value:.4g} Hz"
    if key in SIZES:
        return engineering(float(value), SIZES[key])
    if isinstance(value, float):
        unit = UNITS.get(key, "")
        return f"{value:g}{unit if unit.startswith('°') else f' {unit}'}".rstrip()
    return str(value)


def print_strength(source: Source) -> None:
    """The measures of a record as a run takes it, and what a user should know of it."""
    from pounding_risk.motions.read import read_motion

    motion = read_motion(source)
    print()
    print_table(("measure", "value", "meaning"), _measures(motion), "lrl")
    print()
    print_table(("check, as recorded", "met", "found", "allowed"), _findings(source), "llll")
    print_notes(motion.flags)


def _findings(source: Source) -> Iterator[tuple[str, str, str, str]]:
    """What the checks find in a record before anything is done to it."""
    from pounding_risk.motions.quality import quality

    trace = source.trace
    for each in quality(trace.data, trace.stats.delta, state=source.record["state"]):
        yield each.check, "yes" if each.passed else "no", each.found, each.allowed


def _measures(motion: Motion) -> Iterator[tuple[str, str, str]]:
    """The intensity of a record as a run takes it: name, value, meaning."""
    from pounding_risk.motions.intensity import measure, response_spectra
    from pounding_risk.motions.record import RAW

    found = measure(motion.acceleration, motion.dt)
    state = ", processed as for a run" if motion.record["state"] == RAW else ""
    yield "PGA", engineering(found.pga, "m/s2"), f"peak ground acceleration{state}"
    yield "PGV", engineering(found.pgv, "m/s"), "peak ground velocity"
    yield "PGD", engineering(found.pgd, "m"), "peak ground displacement"
    yield "Arias", engineering(found.arias, "m/s"), "Arias intensity"
    yield "CAV", engineering(found.cav, "m/s"), "cumulative absolute velocity"
    yield "D5-75", engineering(found.d5_75, "s"), "from 5 to 75 % of the Arias intensity"
    yield "D5-95", engineering(found.d5_95, "s"), "from 5 to 95 % of the Arias intensity"
    spectra = response_spectra(motion.acceleration, motion.dt, SPECTRUM)
    for period, value in zip(SPECTRUM, spectra.pseudo_acceleration, strict=True):
        yield f"Sa({period:g} s)", engineering(value, "m/s2"), "pseudo-spectral acceleration, damping 5 %, as in codes"


def print_processed(motions: Sequence[Motion], targets: Sequence[Path | None]) -> None:
    """What became of each record: its steps and doubts, then a line of numbers each."""
    for motion in motions:
        print(motion.name)
        print("\n".join(f"  {_one_line(sentence)}" for sentence in motion.processing))
        print("".join(f"  note: {flag}\n" for flag in motion.flags))
    heads = ("record", "PGA as recorded", "PGA", "PGV", "PGD", "velocity at the end", "displacement at the end", "dt")
    rows = [_processed(motion) for motion in motions]
    if any(targets):
        rows = [(*row, str(target)) for row, target in zip(rows, targets, strict=True)]
        print_table((*heads, "written"), rows, "lrrrrrrrl")
    else:
        print_table(heads, rows, "lrrrrrrr")


def _processed(motion: Motion) -> tuple[str, ...]:
    from pounding_risk.motions.intensity import measure

    found = measure(motion.acceleration, motion.dt)
    velocity, displacement = motion.velocity_displacement()
    return (
        motion.name,
        engineering(motion.record.get("pga_recorded", nan), "m/s2"),  # a turned motion was not recorded
        engineering(found.pga, "m/s2"),
        engineering(found.pgv, "m/s", 3),
        engineering(found.pgd, "m", 3),
        engineering(velocity[-1], "m/s", 2),
        engineering(displacement[-1], "m", 2),
        f"{motion.dt:.4g} s",
    )


def print_selection(selection: Selection) -> None:
    """What was chosen, closest first, with the factor of each, then the choice in sentences."""
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


def print_notes(notes: Iterable[str]) -> None:
    """A line for each doubt."""
    for note in notes:
        print(f"note: {note}")


def print_left_out(left_out: Iterable[str]) -> None:
    """A line for each file or component that is not taken."""
    print_notes(f"left out: {sentence}" for sentence in left_out)


def _one_line(words: Any) -> str:
    return " ".join(str(words).split())
