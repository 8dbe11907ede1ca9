"""Pictures of a row as files: in elevation, in plan, by storey, and a run as an animation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from pounding_risk.assessment.row import RowCase, row_case
from pounding_risk.errors import PoundingError
from pounding_risk.results.files import check_target, open_results
from pounding_risk.results.selected_axes import with_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

FIGURES = (".png", ".svg", ".pdf")
Footprints = Mapping[str, ArrayLike | Sequence[ArrayLike]]


def draw(
    results: xr.Dataset | str | Path | Sequence[xr.Dataset | str | Path],
    *,
    elevation: str | Path | None = None,
    plan: str | Path | None = None,
    profiles: str | Path | None = None,
    animation: str | Path | None = None,
    street: str | Path | Footprints | None = None,
    building: Sequence[str] = (),
    gap: float | str | None = None,
    contact_model: str | None = None,
    yield_force: float | str | None = None,
    pga: float | str | None = None,
) -> tuple[Path, ...]:
    """Write pictures of a row (.png, .svg or .pdf; the animation .html), and return their paths.

    ``results`` is the dataset of a scan, of several rows for a ``plan`` of them all, or for ``animation`` one run with
    its histories. ``street`` gives the plan its footprints: a GeoJSON as `read_block` takes it, or corners [m] by
    name. ``building`` are those of the profiles. ``gap`` [m], ``contact_model``, ``yield_force`` [N] and ``pga`` [m/s²]
    choose the cell as `row_case` does. Raises PoundingError for what cannot be drawn and for a target that cannot be
    written, before anything is.
    """
    wanted = {"elevation": elevation, "plan": plan, "profiles": profiles}
    targets = {name: check_target(path, FIGURES) for name, path in wanted.items() if path is not None}
    moving = None if animation is None else check_target(animation, (".html",))
    if not targets and moving is None:
        raise PoundingError("nothing to draw; name a file for elevation, plan, profiles or animation")
    listed = [results] if isinstance(results, str | Path) or not isinstance(results, Sequence) else list(results)
    if len(listed) > 1 and (set(targets) != {"plan"} or moving is not None):
        raise PoundingError(f"{len(listed)} datasets are given: only a plan shows several rows; name one dataset")
    opened = [with_axes(open_results(dataset) if isinstance(dataset, str | Path) else dataset) for dataset in listed]
    written = () if moving is None else (_animated(opened[0], moving),)
    if not targets:
        return written
    options = {"gap": gap, "contact_model": contact_model, "yield_force": yield_force, "pga": pga}
    cases = [row_case(dataset, **options) for dataset in opened]  # type: ignore[arg-type]
    drawn = {name: _figure(name, cases, street, building) for name in targets}
    from pounding_risk.figures.style import write

    return (*written, *(write(drawn[name], target) for name, target in targets.items()))


def _animated(run: xr.Dataset, target: Path) -> Path:
    from pounding_risk.reports.animation import animate

    return animate(run, target)


def _figure(name: str, cases: list[RowCase], street: Any, building: Sequence[str]) -> Figure:
    if name == "elevation":
        from pounding_risk.figures.elevation import elevation_figure

        return elevation_figure(cases[0])
    if name == "profiles":
        from pounding_risk.figures.storey_profiles import profiles_figure

        return profiles_figure(cases[0], building)
    from pounding_risk.figures.plan_view import plan_figure

    footprints = footprints_of(street) if isinstance(street, str | Path) else street
    return plan_figure(cases, footprints)


def footprints_of(street: str | Path) -> dict[str, tuple[Any, ...]]:
    """Outer rings [m] of every building of a GeoJSON, by name; raises as `read_block`, and for a table without any."""
    from pounding_risk.scene.street.rows import read_block

    block = read_block(street)
    houses = [*(house for row in block.rows for house in row.buildings), *block.in_no_row]
    footprints = {house.name: house.footprint.rings for house in houses if house.footprint is not None}
    if not footprints:
        raise PoundingError(f"{street}: has no footprints; a plan to scale needs a GeoJSON with polygons")
    return footprints
