"""The command `records select`: records whose spectra come closest to a target, with their scale factors."""

from __future__ import annotations

from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pounding_risk.cli._common.files import announce, draw
from pounding_risk.cli._common.options import Figure, option, out_option, read_option
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.cli.records import _options as options
from pounding_risk.render.terminal import one_line, print_left_out, print_notes, print_pairs, print_table
from pounding_risk.units import DAMPING, PERIOD, PGA, Quantity

if TYPE_CHECKING:
    from pounding_risk.motions.selection import Selection

ORDER = 50


def select(
    target: Annotated[str, option("Target spectrum: a file, a code shape, or a record set.")],
    source: options.Sources = None,
    set: options.Set = None,
    range: Annotated[tuple[str, str], option("Periods at which spectra are compared.", metavar="FROM TO")] = (
        "0.2 s",
        "2 s",
    ),
    count: Annotated[int, option("Records to choose, or pairs.", min=1)] = 11,
    spectrum: Annotated[str, option("component; or geomean, rotd50, rotd100 of pairs with one factor.")] = "component",
    factor: Annotated[tuple[float, float], option("Limits of the scale factor.", metavar="LEAST MOST")] = (0.25, 4.0),
    per_event: Annotated[int | None, option("At most so many of one earthquake.", "any number", min=1)] = None,
    magnitude: Annotated[tuple[float, float] | None, option("Such as 6.5 7.5.", metavar="LEAST MOST")] = None,
    distance: Annotated[tuple[str, str] | None, option('Such as "10 km" "50 km".', metavar="LEAST MOST")] = None,
    vs30: Annotated[tuple[str, str] | None, option('Such as "180 m/s" "360 m/s".', metavar="LEAST MOST")] = None,
    pga: Annotated[
        tuple[str, str] | None, option('As recorded, such as "0.1 g" "0.5 g".', metavar="LEAST MOST")
    ] = None,
    poe: options.Poe = None,
    damping: options.Damping = "5 %",
    processing: options.Processing = None,
    unit: options.Unit = None,
    dt: options.Step = None,
    out: Annotated[Path | None, out_option("Write a manifest", ".csv")] = None,
    figure: Figure = None,
) -> None:
    """Choose records whose spectra come closest to a target, each with its factor."""
    from pounding_risk.motions.manifest import write_manifest
    from pounding_risk.motions.selection import select as run

    request = options.record_request(processing)
    length = Quantity("m", 0.0, inf, "distance", example="10 km")
    velocity = Quantity("m/s", 0.0, inf, "shear-wave velocity", example="360 m/s")
    bounds: dict[str, Any] = {"periods": tuple(read_option("--range", text, PERIOD) for text in range)}
    if distance is not None:
        bounds["distance_km"] = tuple(read_option("--distance", text, length) / 1e3 for text in distance)
    if vs30 is not None:
        bounds["vs30"] = tuple(read_option("--vs30", text, velocity) for text in vs30)
    if pga is not None:
        bounds["pga"] = tuple(read_option("--pga", text, PGA) for text in pga)
    goal = options.target_spectrum(target, read_option("--damping", damping, DAMPING), poe)
    with ProgressDisplay("select", "records") as progress:
        sources = options.find_sources(source or (), set, options.stated_facts(unit, dt), horizontal=True)
        motions = options.treat(request, sources.groups, progress)
    choices: dict[str, Any] = {"count": count, "spectrum": spectrum, "limits": factor, "per_event": per_event}
    selection = run(motions, goal, **choices, magnitude=magnitude, **bounds)
    print_selection(selection)
    print_left_out(sources.left_out)
    if out is not None:
        write_manifest(selection.motions(), out)
    announce(out)
    draw(figure, "motions.selection_figure", selection)


def print_selection(selection: Selection) -> None:
    """Print the chosen records, closest first, each with its factor, then what was chosen from and how."""
    formats = {"magnitude": "{:.4g}", "distance_km": "{:.4g} km"}
    rows = [
        (
            row.name,
            f"{row.factor:.3f}{' (limit)' if row.limited else ''}",
            f"{row.misfit:.3f}",
            *("–" if row.known(key) is None else words.format(float(row.known(key))) for key, words in formats.items()),
            one_line(", ".join(str(row.known(key)) for key in ("event", "date") if row.known(key))),
        )
        for row in selection.rows
    ]
    print_table(("record", "factor", "misfit", "magnitude", "distance", "event"), rows, "lrrrrl")
    print()
    pairs = (sentence.partition(": ") for sentence in selection.words())
    print_pairs((heading, words) for heading, _, words in pairs)
    print_notes(f"{row.name}: {doubt}" for row in selection.rows for doubt in row.doubts)
