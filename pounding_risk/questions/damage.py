"""Fragility of damage states with pounding and without, from a dataset of `scan`. Nothing is run.

Both curves are of the same motions: that without pounding is from the motion of each building without any contact,
which the dataset has for every motion. Their ratio has bounds from a bootstrap of whole recordings in which each sample
gives both curves.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pounding_risk._common.dates import created
from pounding_risk._common.letters import csv_text
from pounding_risk._common.words import nearest
from pounding_risk.assessment.damage_curves import DRAWS, SEED, Motions, Options, curves_of
from pounding_risk.assessment.damage_dataset import dataset_of
from pounding_risk.assessment.damage_words import POUNDING, case_words, finding, gap_words, measure_words, notes_of
from pounding_risk.assessment.gmfs import Fields
from pounding_risk.assessment.hazard import COVERED, Hazard, HazardSpectrum
from pounding_risk.assessment.intensities import check_intensity, intensities, shaking_of
from pounding_risk.assessment.options import USUAL_CONFIDENCE
from pounding_risk.errors import PoundingError
from pounding_risk.figures.damage import damage_caption, damage_figure
from pounding_risk.questions._declaration import text_file
from pounding_risk.questions.notes import of_keys
from pounding_risk.questions.rates import AT_LEAST, at_least
from pounding_risk.render.sheet import Block, Row, count, figure, head, listing, number, paragraph, table, with_bounds
from pounding_risk.results.amplitudes import intensity_quantity, place_of
from pounding_risk.results.attributes import as_text, collapsed
from pounding_risk.results.check import missing_named
from pounding_risk.results.files import open_scan
from pounding_risk.results.opened import Results
from pounding_risk.results.variables import NOT_RUN
from pounding_risk.statistics.damage_fits import METHODS, bootstrap_weights
from pounding_risk.statistics.proportions import numbered
from pounding_risk.units import share, shown, si

ORDER = 137
FIGURES = {"": "damage.damage_figure", "ida": "damage.ida_figure"}
KEPT = ("scene", "scene_resolved", "records", "versions", "title", "unused_keys")  # attributes of the scan
NO_STATES = (
    'the scene has no [[damage]]; write a file of [[damage]] tables, name = "slight" and drift = "0.5 %" in each, '
    "and give it as states (--states FILE)"
)
EVENT_BOUNDS = (
    "Bounds of probabilities in an event carry what the motions leave open of the fragility, that the events are a "
    "sample, and those without a row at the site, which count as without failure."
)


@missing_named()
def damage(
    results: xr.Dataset | str | Path,
    *,
    states: Any = None,
    gap: float | str | None = None,
    contact_model: str | None = None,
    yield_force: float | str | None = None,
    method: str | None = None,
    intensity: str | None = None,
    at: float | str | None = None,
    hazard: Hazard | HazardSpectrum | str | Path | None = None,
    confidence: float | str = USUAL_CONFIDENCE,
    gmfs: Fields | str | Path | None = None,
) -> xr.Dataset:
    """Fragility of damage states with pounding and without.

    Parameters
    ----------
    results : xarray.Dataset, str or Path
        A dataset of `scan`, or the file it is in.
    states : path, str, or sequence of DamageState or dict, optional
        States in place of those of the scene: a TOML file of [[damage]] tables, or such tables.
    gap : float or str, optional
        One of the grid's [m, or text with a unit]; the one nearest to the scene's own by default.
    contact_model : str, optional
        One of the grid's; the scene's own by default.
    yield_force : float or str, optional
        One of the grid's [N, or text with a unit]; the one nearest to the scene's own by default.
    method : {"stripes", "ida", "cloud"}, optional
        How curves follow from demands; by default stripes at several levels or with collapses, else a cloud.
    intensity : str, optional
        Intensity of the curves, as `assess` takes it.
    at : float or str, optional
        The intensity at which both probabilities are compared [SI, or text with a unit]; by default the one at which
        half of the motions would reach the state without pounding.
    hazard : Hazard, HazardSpectrum, str or Path, optional
        A hazard curve, or spectra, as `assess` takes it; annual rates follow from it.
    confidence : float or str
        Confidence of all bounds, above 50 %.
    gmfs : Fields, str or Path, optional
        Ground-motion fields of OpenQuake, as `assess` takes them; probabilities in an event follow from them.

    Returns
    -------
    xarray.Dataset
        By state and pounding ("with", "without"): ``median`` and ``dispersion`` with standard errors, ``probability``
        along ``im``, ``reached`` of ``runs`` along ``level``, ``demand_ratio`` and ``capacity`` of each motion, and
        percentiles of demands; ``median_ratio`` and ``probability_ratio`` are with over without. Of a state whose
        demand or place the dataset lacks all are NaN, and ``fault`` says why. The attribute ``finding`` is a sentence,
        ``assumptions`` lists what is assumed and left out, as JSON.

    Raises
    ------
    PoundingError
        For a dataset that is none of `scan`, one without states where none are given, a value that its grid has not,
        and where it lacks the demand or the place of every state.
    SceneError
        For states with faults.
    """
    opened = open_scan(results)
    dataset = opened.dataset
    if states is None:
        states = opened.scene.get("damage")
        if not states:
            raise PoundingError(f"{opened.name}: {NO_STATES}")
    from pounding_risk.scene.damage import read_states  # with pydantic

    read = read_states(states, list(map(str, dataset["building"].values)))
    case = _case_of(opened, {"gap": gap, "contact_model": contact_model, "yield_force": yield_force})
    shaking = shaking_of(opened, hazard, gmfs, intensity)
    word, fields = shaking.intensity, shaking.fields
    if shaking.hazard is not None:
        check_intensity(opened, word, shaking.hazard.name)
    motions = _motions(opened, word)
    if method is not None and method not in METHODS:
        hint = nearest(str(method), METHODS)
        raise PoundingError(f"method: {shown(method)} is none{hint}; write {', '.join(METHODS)}")
    # Of a collapse a cloud has no demand.
    has_collapse = any(bool(collapsed(case, without=without).any()) for without in (False, True))
    options = Options(
        intensity=word,
        method=method or ("stripes" if motions.ims.shape[1] > 1 or has_collapse else "cloud"),
        confidence=share(confidence, "confidence", low=0.5),
        hazard=shaking.hazard,
        at=None if at is None else si(at, intensity_quantity(word), "at"),
        recordings=int(motions.recordings.max(initial=0)) + 1,
        fields=shaking.events(opened),
    )
    weights = bootstrap_weights(motions.recordings, DRAWS, SEED)
    curves = [curves_of(case, state, motions, options, weights) for state in read]
    if not any(pair.is_known for pair in curves):
        raise PoundingError("\n".join(f"damage.{pair.state.name}: {pair.fits[0].fault}" for pair in curves))
    answer = dataset_of(curves, motions, options, case)
    notes = [*notes_of(curves, motions, options, opened), *(f"{note}." for note in opened.nearest_notes)]
    notes += [*([shaking.reading] if shaking.reading else [])]
    if fields is not None:
        notes += [f"{fields.source}: {' '.join(fields.reading)}", EVENT_BOUNDS]
    answer.attrs |= {
        **{name: dataset.attrs[name] for name in KEPT if name in dataset.attrs},
        "Conventions": "CF-1.11",
        "source": "pounding_risk: fragility of damage states from runs with and without contact",
        "amplitude": opened.amplitude_words(),
        "finding": finding(answer),
        "assumptions": as_text(notes),
        **created("pounding_risk.damage"),
    }
    return answer


def _case_of(opened: Results, requested: Mapping[str, Any]) -> xr.Dataset:
    """The case of the scene, or at the requested places of its grid. Raises PoundingError where not every run is."""
    places = {axis: place_of(axis, opened.values_along(axis), at) for axis, at in requested.items() if at is not None}
    case = opened.dataset.isel({axis: opened.scene_case[axis] for axis in requested} | places)
    if unpushed := Results(case).unpushed:
        raise PoundingError(
            f"damage: {unpushed} of {case['status'].size} runs at a gap of {gap_words(case)} are "
            f"{NOT_RUN}, and curves of the others would be those of motions that do not collide; take a gap that no "
            "motion closes, or compute the building in place of displacement_history"
        )
    return case


def _motions(results: Results, intensity: str) -> Motions:
    """The motions of a dataset, record by record and polarity by polarity; a record without motion has no intensity."""
    records, polarities = (tuple(map(str, results.dataset[axis].values)) for axis in ("record", "polarity"))
    is_still = np.repeat(~results.is_shaking, len(polarities))
    ims = np.where(is_still[:, None], np.nan, intensities(results, intensity))
    return Motions(ims, numbered(np.repeat(results.recordings, len(polarities))), records, polarities)


def damage_table(dataset: xr.Dataset) -> str:
    """One row for each state and side as CSV, in SI; what is not known is empty."""
    single = [name for name in dataset.data_vars if dataset[name].dims in (("state",), ("state", "pounding"))]
    gaps = {"gap [m]": float(dataset["gap"])}
    if "interface_gap" in dataset.variables:  # of a row whose gaps differ
        gaps = {f"gap of {pair.item()} [m]": float(pair["interface_gap"]) for pair in dataset["interface"]}
    rows = []
    for state in map(str, dataset["state"].values):
        for side in POUNDING:
            curve = dataset.sel(state=state, pounding=side)
            row: dict[str, Any] = {"state": state, "reached_by": str(curve["state_words"].item()), "pounding": side}
            row |= {"intensity": dataset.attrs["intensity"], "method": dataset.attrs["method"]}
            row |= gaps | {"contact_model": str(dataset["contact_model"].item())}
            row |= {"yield_force [N]": float(dataset["yield_force"])}
            row |= {"runs": int(curve["runs"].sum()), "reached": int(curve["reached"].sum())}
            row |= {f"{name} [{dataset[name].attrs['units']}]": curve[name].item() for name in single}
            rows.append(row | {"fault": str(curve["fault"].item())})
    numbers = (["" if isinstance(fact, float) and isnan(fact) else fact for fact in row.values()] for row in rows)
    return csv_text([list(rows[0]), *numbers])


FILES = {"out": text_file("", ".csv", damage_table)}


def sheet(dataset: xr.Dataset) -> list[Block]:
    """Curves, ratios, annual rates, probabilities in an event, and notes.

    Without rates where the answer is without a hazard, and without an event where it has no fields.
    """
    case = case_words(dataset)
    caption = f"Fragility of each damage state with pounding and without, and the ratio; {damage_caption(dataset)}"
    return [
        paragraph(f"{finding(dataset)}."),
        figure("damage", lambda: damage_figure(dataset, titled=False), f"{caption}.", f"{finding(dataset)}."),
        _curves(dataset, case),
        _ratios(dataset),
        *([_rates(dataset)] if "annual_rate" in dataset else []),
        *([_events(dataset)] if "event_probability" in dataset else []),
        listing([*of_keys(dataset.attrs), *json.loads(dataset.attrs["assumptions"])]),
    ]


def _curves(dataset: xr.Dataset, case: str) -> Block:
    measure, unit = measure_words(dataset)
    heads = ["state", "reached at", "pounding", "reached in", "of", head(f"median {measure}", unit), "dispersion"]
    heads += ["s.e. of ln median", "s.e. of dispersion"]
    rows: list[Row] = []
    for state in dataset["state"].values:
        for side in POUNDING:
            curve = dataset.sel(state=state, pounding=side)
            row: Row = [str(state), str(curve["state_words"].item()), side]
            row += [count(curve["reached"].sum()), count(curve["runs"].sum()), number(curve["median"], unit, 3)]
            row += [number(curve[name], digits=3) for name in ("dispersion", "median_error", "dispersion_error")]
            rows.append(row)
    return table(f"Fragilities of the damage states; {case}.", heads, rows)


def _ratios(dataset: xr.Dataset) -> Block:
    _, unit = measure_words(dataset)
    heads = ["state", "median, with over without", "bounds", head("at", unit), "P without", "P with", "ratio of P"]
    heads += ["bounds"]
    rows: list[Row] = []
    for state in dataset["state"].values:
        part = dataset.sel(state=state)
        row: Row = [str(state), *with_bounds(part, "median_ratio"), number(part["at_intensity"], unit, 3)]
        row += [number(part["probability_at"].sel(pounding=side), digits=3) for side in ("without", "with")]
        rows.append([*row, *with_bounds(part, "probability_ratio_at")])
    return table("What pounding changes: medians, and probabilities at one intensity.", heads, rows)


def _rates(dataset: xr.Dataset) -> Block:
    heads = ["state", "with", "bounds", "without", "bounds", "ratio", "bounds", head("share beyond the curve", "%")]
    rows: list[Row] = []
    for state in dataset["state"].values:
        part = dataset.sel(state=state)
        sides = [part.sel(pounding=side) for side in ("with", "without")]
        row: Row = [str(state), *(cell for side in sides for cell in _rate(side))]
        missing = max(float(side["annual_rate_missing"]) for side in sides)
        rows.append([*row, *with_bounds(part, "annual_rate_ratio"), number(missing, "%", 2)])
    caption = (
        "Annual rates with pounding and without. Share beyond the curve: what part of the rate lies beyond the ends "
        "of the hazard curve, were it continued at the slope of its last rows."
    )
    if (dataset["annual_rate_missing"] > COVERED).any():
        caption += f" {AT_LEAST}Two such numbers have no ratio."
    return table(caption, heads, rows)


def _events(dataset: xr.Dataset) -> Block:
    heads = ["state", "with", "bounds", "without", "bounds"]
    rows: list[Row] = []
    for state in dataset["state"].values:
        sides = [dataset.sel(state=state, pounding=side) for side in ("with", "without")]
        rows.append([str(state), *(cell for side in sides for cell in with_bounds(side, "event_probability"))])
    return table("Probability in an event, with pounding and without.", heads, rows)


def _rate(side: xr.Dataset) -> Row:
    """The annual rate at one side with its bounds, "at least" where the hazard curve ends too early."""
    rate, bounds = with_bounds(side, "annual_rate")
    return [at_least(rate, float(side["annual_rate_missing"]) > COVERED), bounds]
