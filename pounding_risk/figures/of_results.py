"""The figure of a dataset by its name, whichever call made the dataset."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from inspect import signature
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk._common.words import nearest
from pounding_risk.assessment.along import assess_along
from pounding_risk.assessment.assess import assess
from pounding_risk.assessment.row import row_case
from pounding_risk.assessment.separations.table import code_table
from pounding_risk.errors import PoundingError
from pounding_risk.figures.accuracy import accuracy_figure
from pounding_risk.figures.along import along_figure
from pounding_risk.figures.amplification_chart import amplification_figure
from pounding_risk.figures.assess import assessment_figure
from pounding_risk.figures.compare import agreement_figure, reference_figure
from pounding_risk.figures.compare_along import agreement_along_figure
from pounding_risk.figures.damage import damage_figure, ida_figure
from pounding_risk.figures.effects import effects_figure
from pounding_risk.figures.elevation import elevation_figure
from pounding_risk.figures.plan_view import plan_figure
from pounding_risk.figures.scan import ratio_figure, scan_figure, window_figure
from pounding_risk.figures.separations import separations_figure
from pounding_risk.figures.simulate import simulation_figure
from pounding_risk.figures.spectra import gap_spectra_figure
from pounding_risk.figures.storey_profiles import profiles_figure
from pounding_risk.figures.uncertainty import uncertainty_figure
from pounding_risk.results.check import check_labels, check_run, check_scan, kind_of, missing_named
from pounding_risk.results.opened import with_axes
from pounding_risk.results.scene_axes import is_drawn_along, settled
from pounding_risk.units import shown

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


class Kind(NamedTuple):
    """A figure that a dataset may have."""

    of: tuple[str, ...]  # the calls whose datasets have it
    draw: Callable[..., Figure]
    made_by: Callable[..., Any] | None = None  # what makes its subject of the dataset, where that is another


# By name, which is that of the function without its ending. The first that a dataset has is drawn where none is named.
KINDS = {
    "agreement": Kind(("compare",), agreement_figure),
    "reference": Kind(("compare",), reference_figure),
    "agreement_along": Kind(("compare",), agreement_along_figure),
    "scan": Kind(("scan", "compare"), scan_figure),
    "simulation": Kind(("simulate",), simulation_figure),
    "accuracy": Kind(("accuracy",), accuracy_figure),
    "effects": Kind(("effects",), effects_figure),
    "gap_spectra": Kind(("spectra",), gap_spectra_figure),
    "uncertainty": Kind(("uncertainty",), uncertainty_figure),
    "amplification": Kind(("amplification",), amplification_figure),
    "damage": Kind(("damage",), damage_figure),
    "ida": Kind(("damage",), ida_figure),
    "ratio": Kind(("scan", "compare"), ratio_figure),
    "window": Kind(("scan",), window_figure),
    "assessment": Kind(("scan",), assessment_figure, assess),
    "separations": Kind(("scan",), separations_figure, code_table),
    "elevation": Kind(("scan",), elevation_figure, row_case),
    "plan": Kind(("scan",), plan_figure, row_case),
    "profiles": Kind(("scan",), profiles_figure, row_case),
    "along": Kind(("scan",), along_figure, assess_along),
}
CHECKS: dict[str, Callable[..., None]] = {"scan": check_scan, "compare": check_scan, "simulate": check_run}
# The figures of several places along axes of numbers of the scene, by the call; all others take one place.
ALONG = {"scan": "along", "compare": "agreement_along"}


@missing_named()
def results_figure(results: xr.Dataset, kind: str | None = None, *, note: str = "", **options: Any) -> Figure:
    """The figure of a dataset that has this name, or its usual one.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `scan`, `simulate`, `compare`, `accuracy`, `effects`, `spectra`, `amplification`,
        `uncertainty` or `damage`.
    kind : str, optional
        Of a scan "scan", "ratio", "window", "assessment", "separations", "elevation", "plan" or "profiles", and with
        several values along axes of numbers of its scene "along"; of a run "simulation"; of a comparison "agreement",
        "reference", "scan" or "ratio", and along such an axis "agreement_along"; "accuracy", "effects", "gap_spectra",
        "amplification" and "uncertainty"; of damage states "damage" and "ida". By default the first of these that the
        dataset has.
    note : str
        Added to the caption.
    **options
        Those of the figure's own function, which has the name with ``_figure``, and of what makes its subject:
        of `assess` for an assessment, of `assess_along` for what lies along axes, of `code_table` for separations, of
        `row_case` for elevation, plan and profiles.

    Returns
    -------
    matplotlib.figure.Figure
        The figure.

    Raises
    ------
    PoundingError
        For a dataset without figures, a name or an option that it has not, and as the functions named.
    """
    made_by = kind_of(results)
    kinds = [name for name, figure in KINDS.items() if made_by in figure.of]
    if not kinds:
        subject = f"a dataset of {made_by}" if made_by else "a dataset that pounding_risk did not make"
        raise PoundingError(f"{subject} has no figure here; draw its variables with their own method plot")
    usual = ALONG[made_by] if made_by in ALONG and is_drawn_along(results) else kinds[0]
    name = usual if kind is None else kind
    if name not in kinds:
        meant = nearest(str(name), kinds)
        raise PoundingError(f"figure: {shown(name)} is none of this dataset{meant}; it has {', '.join(kinds)}")
    figure = KINDS[name]
    draw_options = {key: value for key, value in options.items() if key in _options(figure.draw)}
    other_options = {key: value for key, value in options.items() if key not in draw_options}
    _check_options(name, other_options, () if figure.made_by is None else _options(figure.made_by))
    one_place = {"scan": with_axes, "compare": settled}.get(made_by) if name not in ALONG.values() else None
    dataset = results if one_place is None else one_place(results)
    CHECKS.get(made_by, check_labels)(dataset, "the dataset")
    return figure.draw(
        dataset if figure.made_by is None else figure.made_by(dataset, **other_options), note=note, **draw_options
    )


def _options(function: Callable[..., Any]) -> tuple[str, ...]:
    """Names of the parameters after the first."""
    return tuple(signature(function).parameters)[1:]


def _check_options(name: str, options: Iterable[str], known: tuple[str, ...]) -> None:
    allowed = [option for option in (*known, *_options(KINDS[name].draw)) if option != "note"]
    for option in options:
        if option not in known:
            has = f"takes {', '.join(allowed)}" if allowed else "takes none"
            raise PoundingError(
                f"figure: {name} has no option {option}{nearest(option, allowed)}; it {has} beside note"
            )
