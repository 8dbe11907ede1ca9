"""Drawings of a row as files: in elevation, in plan, by storey, and a run as an animation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray as xr
from numpy.typing import ArrayLike

from pounding_risk import figures
from pounding_risk.assessment.row import RowCase, row_case
from pounding_risk.errors import PoundingError
from pounding_risk.results.files import check_target, open_results, open_with_axes

FIGURES = (".png", ".svg", ".pdf")
Footprints = Mapping[str, ArrayLike | Sequence[ArrayLike]]


def draw(
    results: xr.Dataset | str | Path | Sequence[xr.Dataset | str | Path],
    *,
    elevation: str | Path | None = None,
    plan: str | Path | None = None,
    profiles: str | Path | None = None,
    animation: str | Path | None = None,
    figure: Mapping[str, str | Path] | Sequence[str] = (),
    street: str | Path | Footprints | None = None,
    building: Sequence[str] = (),
    gap: float | str | None = None,
    contact_model: str | None = None,
    yield_force: float | str | None = None,
    pga: float | str | None = None,
    intensity_level: float | str | None = None,
) -> tuple[Path, ...]:
    """Draw a row: elevation, plan, storeys, animation.

    These are .png, .svg or .pdf, the animation .html. Any other figure of a dataset is drawn by its name.

    Parameters
    ----------
    results : xarray.Dataset, str, Path, or a sequence of these
        A dataset of `scan`, or its file; several of them for a plan of several rows; for an animation a run of
        `simulate`.
    elevation, plan, profiles, animation : str or Path, optional
        Files to write; one at least, or a figure.
    figure : mapping of str to str or Path, or sequence of str
        Files of further figures by their names, as `figures.results_figure` has them; or "ratio=ratio.png".
    street : str, Path or mapping, optional
        Footprints for the plan: a map of footprints as `read_block` takes it, the buildings.csv of `write_block`, or
        corners (n, 2) [m] by the building's name.
    building : sequence of str
        Names of the buildings whose profiles are drawn.
    gap : float or str, optional
        Gap of the cell that is drawn [m, or text with a unit], chosen as `row_case` does.
    contact_model : str, optional
        Contact model of that cell.
    yield_force : float or str, optional
        Yield force F_E of that cell [N, or text with a unit].
    pga : float or str, optional
        Amplitude of that cell [m/s2, or text with a unit].
    intensity_level : float or str, optional
        The same in the measure of the grid [SI, or text with a unit], where that may be another than PGA.

    Returns
    -------
    tuple of Path
        The files that were written.

    Raises
    ------
    PoundingError
        For what cannot be drawn and for a target that cannot be written, before anything is.
    """
    paths = {"elevation": elevation, "plan": plan, "profiles": profiles}
    targets = {name: check_target(path, FIGURES) for name, path in paths.items() if path is not None}
    moving = None if animation is None else check_target(animation, (".html",))
    named = {name: check_target(path, FIGURES) for name, path in _files_by_name(figure).items()}
    if not targets and not named and moving is None:
        raise PoundingError("nothing to draw; name a file for elevation, plan, profiles, animation or a figure")
    sources = [results] if isinstance(results, str | Path) or not isinstance(results, Sequence) else list(results)
    if len(sources) > 1 and (set(targets) != {"plan"} or named or moving is not None):
        raise PoundingError(f"{len(sources)} datasets are given: only a plan shows several rows; name one dataset")
    written = []
    if named:
        dataset = open_results(sources[0]) if isinstance(sources[0], str | Path) else sources[0]
        pictures = {name: figures.results_figure(dataset, name) for name in named}
        written = [figures.write(pictures[name], target) for name, target in named.items()]
    if not targets and moving is None:
        return tuple(written)
    opened = [open_with_axes(dataset).dataset for dataset in sources]
    if moving is not None:
        from pounding_risk.reports.animation import animate

        written.append(animate(opened[0], moving))
    if targets:
        case: dict[str, Any] = {"gap": gap, "contact_model": contact_model, "yield_force": yield_force}
        cases = [row_case(row, **case, pga=pga, intensity_level=intensity_level) for row in opened]
        written += _draw_rows(cases, targets, street, building)
    return tuple(written)


def _files_by_name(figure: Mapping[str, str | Path] | Sequence[str]) -> Mapping[str, str | Path]:
    """Files of figures by their names, which may be written as "ratio=ratio.png"."""
    if isinstance(figure, Mapping):
        return figure
    for word in figure:
        if "=" not in word:
            raise PoundingError(f'figure: "{word}" is not a name and a file; write one such as ratio=ratio.png')
    return dict(word.split("=", 1) for word in figure)


def _draw_rows(
    cases: Sequence[RowCase], targets: Mapping[str, Path], street: str | Path | Footprints | None, names: Sequence[str]
) -> list[Path]:
    """Write elevation, plan and profiles of rows; all are drawn before the first is written."""
    footprints = footprints_of(street, cases) if isinstance(street, str | Path) and "plan" in targets else street
    drawing = {
        "elevation": lambda: figures.elevation_figure(cases[0]),
        "plan": lambda: figures.plan_figure(cases, footprints),
        "profiles": lambda: figures.profiles_figure(cases[0], names),
    }
    pictures = {name: drawing[name]() for name in targets}
    return [figures.write(pictures[name], target) for name, target in targets.items()]


def footprints_of(street: str | Path, cases: Sequence[RowCase]) -> dict[Any, tuple[Any, ...]]:
    """Footprints of a street: outer rings (n, 2) [m] by the building's name.

    The file is a map of footprints as `read_block` takes it, or the buildings.csv that `write_block` writes. Where two
    streets have buildings of one name, those of a row are by its number too, and are of the street that the title of
    its scene begins with. Raises PoundingError as `read_block`, for a table without footprints, and where it is not
    known which street a row is of.
    """
    from pounding_risk.reports.exports._outlines import of_row
    from pounding_risk.streets.rows import footprint_rings

    footprints = footprint_rings(street)
    if not footprints:
        raise PoundingError(f"{street}: has no footprints; a plan to scale needs a map with polygons")
    by_name = {name: rings for (_, name), rings in footprints.items()}
    if len(by_name) == len(footprints):
        return by_name
    placed: dict[Any, tuple[Any, ...]] = {}
    for number, case in enumerate(cases):
        names = [building.name for building in case.buildings]
        rings_of_row = of_row(footprints, str(case.results.attrs["title"]), names, Path(street))
        placed |= {(number, name): rings for name, rings in zip(names, rings_of_row, strict=True)}
    drawn_ids = {id(rings) for rings in placed.values()}
    undrawn = {f"{of} {name}": rings for (of, name), rings in footprints.items() if id(rings) not in drawn_ids}
    return placed | undrawn
