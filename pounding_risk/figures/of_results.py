"""The figure of a dataset by its name, whichever call made the dataset."""

from __future__ import annotations

from collections.abc import Callable
from inspect import signature
from typing import Any

import xarray as xr

from pounding_risk import figures
from pounding_risk._common.words import nearest
from pounding_risk.assessment.along import assess_along
from pounding_risk.assessment.assess import assess
from pounding_risk.assessment.row import row_case
from pounding_risk.assessment.separations.table import code_table
from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import Figure
from pounding_risk.results.check import check_labels, check_run, check_scan, kind_of, missing_named
from pounding_risk.results.files import open_with_axes
from pounding_risk.results.scene_axes import at_one_place, is_drawn_along
from pounding_risk.units import shown

# Names of the figures of each call's datasets, the usual one first. `NAME_figure` of this folder draws it: of the
# dataset, or of its subject. `pounding-risk draw --figure NAME=FILE` draws any of them.
FIGURES = {
    "scan": ("scan", "ratio", "assessment", "separations", "elevation", "plan", "profiles", "along"),
    "compare": ("agreement", "reference", "agreement_along", "scan", "ratio"),
    "simulate": ("simulation", "hysteresis"),
    "accuracy": ("accuracy",),
    "effects": ("effects",),
    "spectra": ("gap_spectra",),
    "uncertainty": ("uncertainty",),
    "amplification": ("amplification",),
    "damage": ("damage", "ida"),
}
SUBJECTS: dict[str, Callable[..., Any]] = {
    "assessment": assess,
    "separations": code_table,
    "elevation": row_case,
    "plan": row_case,
    "profiles": row_case,
    "along": assess_along,
}
# The figures of several places along axes of numbers of the scene, by the call; all others take one place.
ALONG = {"scan": "along", "compare": "agreement_along"}
CHECKS: dict[str, Callable[..., None]] = {"scan": check_scan, "compare": check_scan, "simulate": check_run}
AT_ONE_PLACE: dict[str, Callable[..., Any]] = {
    "scan": lambda results: open_with_axes(results, "the dataset").dataset,
    "compare": at_one_place,
}


@missing_named()
def results_figure(results: xr.Dataset, kind: str | None = None, *, note: str = "", **options: Any) -> Figure:
    """The figure of a dataset that has this name, or its usual one.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `scan`, `simulate`, `compare`, `accuracy`, `effects`, `spectra`, `amplification`,
        `uncertainty` or `damage`.
    kind : str, optional
        Of a scan "scan", "ratio", "assessment", "separations", "elevation", "plan" or "profiles", and with
        several values along axes of numbers of its scene "along"; of a run "simulation" or "hysteresis"; of a
        comparison "agreement", "reference", "scan" or "ratio", and along such an axis "agreement_along";
        "accuracy", "effects", "gap_spectra", "amplification" and "uncertainty"; of damage states "damage" and
        "ida". By default the first of these that the dataset has.
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
    call = kind_of(results)
    names = FIGURES.get(call, ())
    if not names:
        subject_text = f"a dataset of {call}" if call else "a dataset that pounding_risk did not make"
        raise PoundingError(f"{subject_text} has no figure here; draw its variables with their own method plot")
    name = ALONG[call] if call in ALONG and is_drawn_along(results) else names[0]
    name = name if kind is None else kind
    if name not in names:
        hint = nearest(str(name), names)
        raise PoundingError(f"figure: {shown(name)} is none of this dataset{hint}; it has {', '.join(names)}")
    draw, subject_of = getattr(figures, f"{name}_figure"), SUBJECTS.get(name)
    draw_options, subject_options = _options(draw), () if subject_of is None else _options(subject_of)
    for option in options:
        if option not in (*draw_options, *subject_options):
            known = [name for name in (*subject_options, *draw_options) if name != "note"]
            options_text = f"takes {', '.join(known)}" if known else "takes none"
            raise PoundingError(
                f"figure: {name} has no option {option}{nearest(option, known)}; it {options_text} beside note"
            )
    subject: Any = results
    if call in AT_ONE_PLACE and name not in ALONG.values():
        subject = AT_ONE_PLACE[call](results)
    CHECKS.get(call, check_labels)(subject)
    if subject_of is not None:
        subject = subject_of(subject, **{key: value for key, value in options.items() if key not in draw_options})
    return draw(subject, note=note, **{key: value for key, value in options.items() if key in draw_options})


def _options(function: Callable[..., Any]) -> tuple[str, ...]:
    """Names of the parameters after the first."""
    return tuple(signature(function).parameters)[1:]
