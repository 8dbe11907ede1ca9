"""Demands of the motions on one gap, from a dataset of `scan`: closing without contact, contact, yielding.

Nothing here runs a case; a dataset on disk is enough.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from dataclasses import replace
from math import inf, nan
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk.assessment.options import Criterion
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import LEVEL_AXIS, PGA_AXIS
from pounding_risk.results.attributes import (
    gaps_needed,
    has_histories,
    has_initial_motion,
    has_laws_of_links,
    isolated_buildings,
    no_response,
)
from pounding_risk.results.opened import Results
from pounding_risk.results.variables import UNPUSHED
from pounding_risk.statistics.proportions import Share, independent_motions, labels, logs_of, shares
from pounding_risk.statistics.required_gap import (
    EVERY_GAP,
    SAME_GAP,
    USUAL_PERCENTILES,
    RequiredGap,
    RunGaps,
    required_gaps,
)

Array = NDArray[np.float64]

AMPLITUDE_AXES = (PGA_AXIS, LEVEL_AXIS)  # of which a dataset has one at most
MOTION_AXES = ("record", "polarity", *AMPLITUDE_AXES)
# They leave the free motion linear. inelastic_storeys does not: twice the motion is not twice the closing.
LINEAR = {"permanent_set", "unloading_stiffness", "strain_rate", "wave_passage", "p_delta", "soil_flexibility"}
UNDEFINED = -1  # yield exceedance of a failed run, and where a jump has no force


class Motions(NamedTuple):
    """The motions of an ensemble, and how far each closes the gap without contact."""

    records: tuple[str, ...]  # by motion
    polarities: tuple[str, ...]
    recordings: NDArray[np.int64]  # numbers, equal for the components and polarities of one recording
    amplitudes: tuple[float | None, ...]  # SI, of the grid in its measure; None for motions as recorded
    closing: Array  # (motions, amplitudes) [m]
    finite: NDArray[np.bool_]  # (motions, amplitudes) False where the response is not finite, or the record is dead
    alone: Array | None = None  # of one interface of several: closing without contact anywhere, at most ``closing``
    run: RunGaps = EVERY_GAP  # gaps at which pushes by others are known


def is_linear(results: Results) -> bool:
    """True where the closing without contact is proportional to the motion, as no effect and no building yields.

    A known motion is that of a model of which nothing is known. Bumpers, and what follows from an initial motion, are
    parts of the closing that do not grow.
    """
    if np.any(results.dataset.coords.get("interface_bumper", 0.0) > 0.0):
        return False
    yields = has_histories(results.scene) or isolated_buildings(results.scene) or has_laws_of_links(results.scene)
    yields = yields or has_initial_motion(results.scene)
    return set(results.scene.get("effects", {})) <= LINEAR and not yields


def motions_of(results: Results) -> Motions:
    """The motions of one interface, a part of `Results.interfaces`, record by record and polarity by polarity.

    In a row what stands further along may push a building across a gap that the motion without contact leaves open:
    ``closing`` is then the most that is closed in such a run under any contact model and F_E, with the penetration if
    they touch. If they do not, that is the gap which this motion needs, as nothing happens there before they touch;
    where all gaps vary together it is so at this gap alone. A motion whose run at the widest gap fails, as where
    pounding makes a storey collapse, is not ``finite``: whether neighbours push the two together is not known.
    """
    dataset = results.dataset
    records, polarities = (list(map(str, dataset[axis].values)) for axis in ("record", "polarity"))
    closing = alone = by_amplitude(dataset["peak_closing_free"])
    is_pushed, run = "impact_count" in dataset and "interior" in dataset["building_position"].values, EVERY_GAP
    finite, polarity_count = _has_response(results), len(polarities)
    if is_pushed:
        gaps = np.sort(dataset["gap"].values).tolist()
        run = RunGaps(gaps[-1], tuple(gaps) if len(gaps) > 1 and "interface_gap" not in dataset.variables else ())
        closing = np.fmax(alone, by_amplitude(pushed_closing(dataset, dataset["gap"], MOTION_AXES)))
        for gap in run.steps or gaps[-1:]:
            closing = np.where(run_failed(results, alone, gap), np.fmax(closing, gap + 2.0 * SAME_GAP), closing)
        finite &= ~run_failed(results, alone, run.widest)
    return Motions(
        tuple(name for name in records for _ in polarities),
        tuple(polarities) * len(records),
        np.repeat(results.recordings, polarity_count),
        results.amplitudes.values,
        closing,
        finite,
        alone if is_pushed else None,
        run,
    )


def _has_response(results: Results) -> NDArray[np.bool_]:
    """(motions, amplitudes) True where the record holds a motion and the response without contact is finite."""
    shakes = np.repeat(results.is_shaking, results.dataset.sizes["polarity"])
    return np.isfinite(by_amplitude(gaps_needed(results.dataset))) & shakes[:, None]


def run_failed(results: Results, alone: Array, gap: float) -> NDArray[np.bool_]:
    """Where the run at a gap of the grid fails or a storey collapses in it, with a gap that is left open alone."""
    case = results.dataset.isel(
        results.scene_contact | {"gap": int(np.abs(results.dataset["gap"].values - gap).argmin())}
    )
    failed = (case["impact_count"] == UNDEFINED) & (case["status"] != UNPUSHED)
    return np.asarray(by_amplitude(failed), dtype=bool) & (alone <= gap)


def pushed_closing(runs: xr.Dataset, gaps: xr.DataArray, axes: Collection[Hashable]) -> xr.DataArray:
    """The most that is closed in runs at gaps which are left open alone, along these axes; NaN without."""
    reach = runs["peak_closing"].where((runs["impact_count"] != UNDEFINED) & (runs["peak_closing_free"] <= gaps))
    return reach.max([axis for axis in reach.dims if axis not in axes])


def touching(results: Results, motions: Motions, gap: float) -> Array:
    """Whether each motion brings contact at a gap, and whether it may: (2, motions, amplitudes).

    Of a pair that is what it closes. In a row contact elsewhere may push buildings together or keep them from meeting:
    at a gap of the grid it is what the run with all neighbours does, under the scene's own contact model and F_E, as
    `row.row_case` has it. At another gap it is ``closing`` of `motions_of`; a motion may bring contact that no run
    shows to leave the gap open. NaN and 1 where its run failed.
    """
    closes = motions.closing > gap
    places = np.flatnonzero(np.isclose(results.dataset["gap"].values, gap, rtol=0.0, atol=SAME_GAP))
    if motions.alone is None or not places.size:
        return np.stack([closes, motions.closing > motions.run.below(gap)]).astype(float)
    counts = by_amplitude(results.dataset["impact_count"].isel(results.scene_contact | {"gap": int(places[0])}))
    failed = run_failed(results, motions.alone, gap)
    touches = np.where(counts == UNDEFINED, closes, counts > 0)
    return np.stack([np.where(failed, nan, touches), touches | failed])


def by_motion(cases: xr.DataArray, inner: Sequence[str] = ()) -> Array:
    """Values as (motions, ...), the axes ``inner`` in this order."""
    table = cases.variable.transpose("record", "polarity", *inner).values  # without the coordinates, a copy of each
    return np.asarray(table.reshape(table.shape[0] * table.shape[1], *table.shape[2:]))


def by_amplitude(cases: xr.DataArray, inner: Sequence[str] = ()) -> Array:
    """Values as (motions, amplitudes, ...), whether or not there is an axis of amplitudes."""
    axes = [axis for axis in AMPLITUDE_AXES if axis in cases.dims]
    flat = by_motion(cases, [*axes, *inner])
    return flat if axes else flat[:, None]


def yields_of(results: xr.Dataset, gap: float) -> tuple[float, Array]:
    """Nearest gap of the grid, and whether each run yields there: (motions, amplitudes, models, finite yield forces).

    1 and 0; NaN where the run failed or yielding is not defined, as of an instant jump.
    """
    gaps = results["gap"].values
    nearest = int(np.abs(gaps - gap).argmin())
    exceeded = results["yield_exceedance"].isel(gap=nearest, yield_force=_may_yield(results))
    exceedance = by_amplitude(exceeded, ("contact_model", "yield_force"))
    return float(gaps[nearest]), np.where(exceedance == UNDEFINED, np.nan, exceedance.astype(float))


def finite_forces(results: xr.Dataset) -> Array:
    """The grid's yield forces [N] without inf, which never yields, unless columns have a yield force of their own."""
    return np.asarray(results["yield_force"].values[_may_yield(results)])


def _may_yield(results: xr.Dataset) -> NDArray[np.bool_]:
    """Yield forces of the grid under which some contact may yield, as a mask."""
    if "contact_point_yield_force" not in results.variables:
        return np.asarray(np.isfinite(results["yield_force"].values))
    # By the grid's yield force where floors meet; a column keeps its own.
    point_forces = results.variables["contact_point_yield_force"]
    sizes = {"yield_force": results.sizes["yield_force"], "contact_point": results.sizes["contact_point"]}
    return np.asarray(np.isfinite(point_forces.set_dims(sizes).transpose(*sizes).values).any(axis=1))


class Contact(NamedTuple):
    """What the motions of one interface close, at one amplitude."""

    gap: float  # m, the assessed one
    every: Motions  # at all amplitudes
    level: int  # index of the amplitude
    at: str  # the amplitude in words
    motions: Motions  # at this amplitude, with a finite response
    independent: float  # motions that these stand for
    shares: tuple[Share, ...]  # that close each gap of the grid, and the assessed one
    required: dict[float, RequiredGap]  # by percentile [%]
    touched: NDArray[np.bool_]  # by motion: contact at the assessed gap
    may_touch: NDArray[np.bool_]  # by motion: contact that no run excludes
    lost: int  # motions without a finite response at this amplitude, or whose run at the gap fails

    @property
    def weight(self) -> float:
        """What one motion counts for, at most 1."""
        return self.independent / len(self.motions.records)

    @property
    def at_gap(self) -> Share:
        """The share of the motions that close the assessed gap."""
        return next(share for share in self.shares if share.gap == self.gap)

    def with_lost(self, criterion: Criterion) -> tuple[Share, RequiredGap]:
        """The share at the assessed gap and the required gap, no gap being wide enough for a motion that is lost.

        The lower bound of the share counts them as none.
        """
        share, required = self.at_gap, self.required[criterion.percentile]
        if not self.lost:
            return share, required
        contact_flags = np.array([self.touched, self.may_touch], dtype=float)
        touched = np.pad(contact_flags, ((0, 0), (0, self.lost)), constant_values=nan)
        closing = np.pad(self.motions.closing[:, 0], (0, self.lost), constant_values=inf)
        (required,) = required_gaps(closing, self.weight, (criterion.percentile,), criterion.confidence)
        share = share_with_lost(touched[:, None], self.gap, self.weight, criterion.confidence)
        return share, required.in_row(self.every.run)


def share_with_lost(touched: Array, gap: float, weight: float, confidence: float) -> Share:
    """The share of the motions with contact at any interface, of which those that are lost count as contact.

    The lower bound of the share counts them as none.

    Parameters
    ----------
    touched : array
        1 where a motion brings contact, 0 where not, NaN where it is lost, and the same of whether it may, as
        `touching` has both: (2, interfaces, motions).
    gap : float
        The gap that the share is of [m].
    weight : float
        What one motion counts for, at most 1.
    confidence : float
        Confidence of the bounds.
    """
    share, upper, lower = (
        shares(np.nan_to_num(flags, nan=lost_value).max(axis=0)[:, None], [{"gap": gap}], weight, confidence)[0]
        for flags, lost_value in ((touched[0], 1.0), (touched[1], 1.0), (touched[0], 0.0))
    )
    return replace(_with_upper(share, upper), low=lower.low, low_recordings=lower.low_recordings)


def _with_upper(share: Share, upper: Share) -> Share:
    """The share of the motions that bring contact, with the upper bounds of that of those which may."""
    return replace(share, high=upper.high, high_recordings=upper.high_recordings)


def contact_of(results: Results, index: int, gap: float | None, level: int | None, criterion: Criterion) -> Contact:
    """Contact at the interface ``index``, whose part of the results `Results.interfaces` gives.

    Without a gap [m] and the index of an amplitude the scene's own are taken. Raises PoundingError where no motion has
    a finite response.
    """
    gap = results.scene_gap(index) if gap is None else gap
    level = results.scene_level if level is None else level
    ensemble = motions_of(results)
    finite = np.flatnonzero(ensemble.finite[:, level] & ~np.isnan(touching(results, ensemble, gap)[0, :, level]))
    if not finite.size and ensemble.alone is not None:  # pushes by neighbours are known of none, the response alone is
        finite = np.flatnonzero(_has_response(results)[:, level])
    if not finite.size:
        at = results.amplitude_words(ensemble.amplitudes[level])
        why = no_response(results.at_level(level).dataset, at=at)
        if levels := np.asarray(ensemble.amplitudes)[ensemble.finite.any(axis=0)].tolist():
            option = "intensity-level" if results.amplitudes.axis == LEVEL_AXIS else "pga"
            why += f"; at {', '.join(map(results.amplitudes.words, levels))} motions can be assessed, with --{option}"
        raise PoundingError(why)
    part = finite, slice(level, level + 1)
    motions = Motions(
        tuple(ensemble.records[motion] for motion in finite),
        tuple(ensemble.polarities[motion] for motion in finite),
        labels(list(ensemble.recordings[finite])),
        (ensemble.amplitudes[level],),
        ensemble.closing[part],
        ensemble.finite[part],
        None if ensemble.alone is None else ensemble.alone[part],
        ensemble.run,
    )
    closing = motions.closing[:, 0]
    independent = independent_motions(logs_of(closing), motions.recordings)
    weight = independent / closing.size
    gaps = np.unique([*map(float, results.dataset["gap"].values), gap]).tolist()
    touched = np.stack([touching(results, ensemble, width)[:, finite, level] for width in gaps], axis=2) > 0.0
    percentiles = (*USUAL_PERCENTILES, criterion.percentile, criterion.target_percentile)
    at, at_gap = results.amplitude_words(ensemble.amplitudes[level]), touched[:, :, gaps.index(gap)]
    lost = len(ensemble.finite) - finite.size
    gap_labels = [{"gap": width} for width in gaps]
    touch, upper = (shares(flags.astype(float), gap_labels, weight, criterion.confidence) for flags in touched)
    needs = required_gaps(closing, weight, percentiles, criterion.confidence)
    required = {need.percentile: need.in_row(ensemble.run) for need in needs}
    return Contact(
        gap,
        ensemble,
        level,
        at,
        motions,
        independent,
        tuple(map(_with_upper, touch, upper)),
        required,
        at_gap[0],
        at_gap[1],
        lost,
    )
