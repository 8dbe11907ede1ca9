"""The command `records info`: all that is known of one record, and its intensity measures."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pounding_risk.cli._common.options import argument
from pounding_risk.cli.records._options import Step, Unit, stated_facts
from pounding_risk.errors import PoundingError
from pounding_risk.render.terminal import engineering, one_line, print_notes, print_pairs, print_table

if TYPE_CHECKING:
    from pounding_risk.motions.catalogue import Entry
    from pounding_risk.motions.record import Source

ORDER = 20
SPECTRUM = (0.2, 0.5, 1.0, 2.0)  # s
# Units of facts of a record, by key.
UNITS = {"distance_km": " km", "azimuth": "° from north", "vs30": " m/s"}
FREQUENCIES = ("low_corner", "high_corner", "lowest_usable_frequency")  # Hz
SIZES = {"header_pga": "m/s2", "header_pgv": "m/s", "header_pgd": "m", "pgv_peer": "m/s"}


def info(
    source: Annotated[
        str, argument("SOURCE", "An id, a file, file#component, a grid of sites, or a generated motion.")
    ],
    unit: Unit = None,
    dt: Step = None,
) -> None:
    """One record: origin, terms, checksum, where its file is, PGA to Sa."""
    from pounding_risk.motions.catalogue import entries, entry
    from pounding_risk.motions.formats import split_component
    from pounding_risk.motions.read import open_source
    from pounding_risk.motions.sites.event_grid import is_grid

    grid, site = split_component(source)
    if is_grid(grid):
        return print_grid(grid, site, stated_facts(unit, dt))
    if any(item.id == source for item in entries()):
        print_record(entry(source))
    else:
        print_source(open_source(source, **stated_facts(unit, dt)))


def print_grid(grid: Path, site: str, facts: dict[str, Any]) -> None:
    """Print the sites of a grid with the number and the factors of their motions, or the motions of one of them."""
    from pounding_risk.cli.records.list import print_sources
    from pounding_risk.motions.sites.event_grid import read_grid, site_motions, sources_at

    if site:
        sources = tuple(sources_at(grid, site, **facts))
        first = sources[0].record
        print(f"{first['site']} at {first['longitude']:g}, {first['latitude']:g}", end="")
        print(f", {first['site_distance_km']:.3g} km away\n" if "site_distance_km" in first else "\n")
        print_sources(sources)
        return print_notes(dict.fromkeys(doubt for source in sources for doubt in source.doubts))
    rows = []
    for one in read_grid(grid):
        factors = [motion.factor for motion in site_motions(one)]
        spread = f"{min(factors):.4g} to {max(factors):.4g}" if min(factors) < max(factors) else f"{factors[0]:.4g}"
        vs30 = "" if one.vs30 is None else f"{one.vs30:g} m/s"
        rows.append(
            (one.file.name, f"{one.place.longitude:g}", f"{one.place.latitude:g}", vs30, str(len(factors)), spread)
        )
    print_table(("site", "longitude", "latitude", "Vs30", "motions", "factors"), rows, "lrrrrr")


def print_record(entry: Entry) -> None:
    """Print the catalogue's entry of a record, where its file is, and its intensity measures and checks."""
    from pounding_risk.motions.catalogue import path

    facts = {key: fact for key, fact in asdict(entry).items() if fact not in ("", None)}
    facts |= {"dt": f"{entry.dt:g} s", "duration": f"{entry.duration:g} s", "PGA": engineering(entry.pga, "m/s2")}
    del facts["pga_g"]
    if entry.sensitivity == 1.0:
        del facts["sensitivity"]
    else:
        facts["sensitivity"] = f"{entry.sensitivity:.8g} counts per m/s²"
    if entry.azimuth is not None:
        facts["azimuth"] = f"{entry.azimuth:g}° from north"
    has_file = True
    try:
        facts["file"] = str(path(entry.id))
    except PoundingError as error:
        has_file, facts["file"] = False, str(error)
    print_pairs((key, one_line(fact)) for key, fact in facts.items())
    if has_file:
        from pounding_risk.motions.read import open_source

        _print_intensity(open_source(entry.id))


def print_source(source: Source) -> None:
    """Print what a file says of its record, and its intensity measures and checks."""
    stats = source.trace.stats
    facts = {key: _fact_words(key, fact) for key, fact in source.record.items() if fact not in ("", None)}
    del facts["pga_recorded"]
    if facts.get("source") == facts.get("file"):
        facts.pop("source", None)
    facts |= {"units": source.units.removeprefix("units: "), "npts": str(stats.npts), "dt": f"{stats.delta:g} s"}
    facts |= {"duration": f"{(stats.npts - 1) * stats.delta:g} s"}
    facts |= {"PGA": engineering(source.record["pga_recorded"], "m/s2")}
    print_pairs((key.removesuffix("_km").replace("_", " "), one_line(fact)) for key, fact in facts.items())
    _print_intensity(source)


def _fact_words(key: str, fact: Any) -> str:
    """A fact of a record with its unit."""
    if key in FREQUENCIES:
        return f"{fact:.4g} Hz"
    if key in SIZES:
        return engineering(float(fact), SIZES[key])
    return f"{fact:g}{UNITS.get(key, '')}" if isinstance(fact, float) else str(fact)


def _print_intensity(source: Source) -> None:
    """Print the intensity measures of a record as a run takes it, and the checks of its quality as it was recorded."""
    from pounding_risk.motions.intensity import measure, response_spectra
    from pounding_risk.motions.quality import quality
    from pounding_risk.motions.read import read_motion
    from pounding_risk.motions.record import RAW

    motion, trace = read_motion(source), source.trace
    measures = measure(motion.acceleration, motion.dt)
    state = ", processed as for a run" if motion.record["state"] == RAW else ""
    rows = [
        ("PGA", measures.pga, "m/s2", f"peak ground acceleration{state}"),
        ("PGV", measures.pgv, "m/s", "peak ground velocity"),
        ("PGD", measures.pgd, "m", "peak ground displacement"),
        ("Arias", measures.arias, "m/s", "Arias intensity"),
        ("CAV", measures.cav, "m/s", "cumulative absolute velocity"),
        ("D5-75", measures.d5_75, "s", "from 5 to 75 % of the Arias intensity"),
        ("D5-95", measures.d5_95, "s", "from 5 to 95 % of the Arias intensity"),
    ]
    spectra = response_spectra(motion.acceleration, motion.dt, SPECTRUM)
    for period, size in zip(SPECTRUM, spectra.pseudo_acceleration, strict=True):
        rows.append((f"Sa({period:g} s)", size, "m/s2", "pseudo-spectral acceleration, damping 5 %, as in codes"))
    print()
    cells = ((name, engineering(size, unit), meaning) for name, size, unit, meaning in rows)
    print_table(("measure", "value", "meaning"), cells, "lrl")
    print()
    findings = quality(trace.data, trace.stats.delta, state=source.record["state"])
    checks = ((one.check, "yes" if one.passed else "no", one.found, one.allowed) for one in findings)
    print_table(("check, as recorded", "met", "found", "allowed"), checks, "llll")
    print_notes(motion.flags)
