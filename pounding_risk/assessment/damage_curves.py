"""Both curves of a damage state, with pounding and without, from demands over its threshold.

Read from one case of a dataset of `scan`: a gap, contact model and yield force. What a building would do without
contact is in the dataset for every motion, from the run in which nothing touches; a force of contact is then 0. Bounds
follow from a bootstrap of recordings, each sample of which gives both curves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.words import nearest
from pounding_risk.assessment.demands import by_amplitude
from pounding_risk.assessment.fragility import shown_as
from pounding_risk.assessment.hazard import Hazard
from pounding_risk.errors import PoundingError
from pounding_risk.results.attributes import collapsed, finite, isolated_buildings, moat_walls
from pounding_risk.results.opened import Results
from pounding_risk.statistics.damage_fits import METHODS, Capacities, Observed, capacities, expanded_tail
from pounding_risk.statistics.fragility import Fit, fragility_curve, of_one_intensity
from pounding_risk.units import YIELD_FORCE, say
from pounding_risk.units import shown as shown_text

Array = NDArray[np.float64]
Labels = NDArray[np.int64]

POUNDING = ("with", "without")
DRAWS, SEED = 1000, 20110314  # samples of recordings
NO_CONTACT = "no force acts between buildings without contact, so that no motion can reach the state"
LOST = 0.05  # share of samples without a value from which on there are no bounds
POINT = "contact_point_"
ROUNDED = 1e-12  # of a threshold: some bits of a double


class Motions(NamedTuple):
    """Intensities of the motions, (motions, levels), and their recordings."""

    ims: Array
    recordings: Labels
    records: tuple[str, ...]
    polarities: tuple[str, ...]

    @property
    def levels(self) -> Array | None:
        """The intensities that all motions have, level by level; None where they differ."""
        finite_ims = self.ims[np.isfinite(self.ims).all(axis=1)]
        is_common = len(finite_ims) > 0 and all(map(of_one_intensity, finite_ims.T))
        return np.asarray(np.median(finite_ims, axis=0)) if is_common else None


class Options(NamedTuple):
    """The options of `damage`, as they were read."""

    intensity: str
    method: str
    confidence: float
    hazard: Hazard | None
    at: float | None
    recordings: int
    fields: Array | None = None  # intensities of the events of ground-motion fields at the site

    @property
    def tails(self) -> tuple[float, float]:
        """The percentages between which the bounds lie, of a bootstrap of so many recordings."""
        tail = 100.0 * expanded_tail(self.confidence, self.recordings)
        return tail, 100.0 - tail


@dataclass(frozen=True)
class Curves:
    """Both curves of a state: with pounding, then without; ratios are with over without, with bounds."""

    state: Any
    ratios: Sequence[Array]  # demands over the threshold, (motions, levels), as `Demands` has them
    fits: Sequence[Fit]
    capacities: Sequence[Capacities]
    drawn: Sequence[Array]  # ln θ and β of samples of recordings, NaN where there is no curve

    @property
    def drawn_alike(self) -> tuple[Array, Array]:
        """The samples in which both have a curve."""
        has_both = np.isfinite(self.drawn[0]).all(axis=1) & np.isfinite(self.drawn[1]).all(axis=1)
        return self.drawn[0][has_both], self.drawn[1][has_both]

    @property
    def lost(self) -> int:
        """Samples in which one has no curve."""
        return len(self.drawn[0]) - len(self.drawn_alike[0])

    @property
    def is_known(self) -> bool:
        """Whether any run has the demand; the fault of the fits says why none has, and the state is left out."""
        return not np.isnan(self.ratios[0]).all()

    @property
    def is_compared(self) -> bool:
        """Whether both have a curve."""
        return not any(fit.fault for fit in self.fits)

    def probability(self, im: Any) -> list[Array]:
        """Probabilities of the state at these intensities, with pounding and without."""
        return [fragility_curve(im, fit.median, fit.dispersion) for fit in self.fits]

    def bounds(self, of_samples: Array, tails: tuple[float, float]) -> tuple[Array, Array]:
        """Bounds from values by sample along the first axis; NaN where too many samples have no curve."""
        if not self.is_compared or self.lost > LOST * len(self.drawn[0]):
            return np.full(of_samples.shape[1:], np.nan), np.full(of_samples.shape[1:], np.nan)
        has_enough = (~np.isnan(of_samples)).sum(axis=0) >= (1.0 - LOST) * len(self.drawn[0])
        filled = np.where(has_enough, of_samples, 0.0)
        # Each bound is one sample's own value, as a ratio may be infinite.
        low = np.nanpercentile(filled, tails[0], axis=0, method="lower")
        high = np.nanpercentile(filled, tails[1], axis=0, method="higher")
        return np.where(has_enough, low, np.nan), np.where(has_enough, high, np.nan)


def curves_of(case: xr.Dataset, state: Any, motions: Motions, options: Options, weights: Array) -> Curves:
    """Both curves of a state; a run that failed with contact is left out of both.

    Of a state whose demand or place the dataset lacks nothing is known, and the fault says why.
    """
    try:
        demands, lacking_text = demands_of(case, state), ""
    except Lacking as error:
        unknown_demands = np.full(motions.ims.shape, np.nan)
        demands, lacking_text = Demands(unknown_demands, unknown_demands), error.why
    is_known = np.isfinite(motions.ims) & ~np.isnan(demands.with_contact) & ~np.isnan(demands.without)
    method, intensity_text = METHODS[options.method], shown_as(options.intensity)
    ratios, fits, crossings, drawn = [], [], [], []
    for side, demand in zip(POUNDING, demands[:2], strict=True):
        ratios.append(np.where(is_known, demand, np.nan))
        observed = Observed(motions.ims, ratios[-1], motions.recordings, intensity_text, demands.jumps)
        fault = lacking_text or (NO_CONTACT if side == "without" and state.demand.interfaces else "")
        fits.append(Fit(fault=fault) if fault else method.fit(observed))
        crossings.append(capacities(motions.ims, ratios[-1], demands.jumps))
        drawn.append(np.full((len(weights), 2), np.nan) if fits[-1].fault else method.drawn(observed, weights))
    return Curves(state, ratios, fits, crossings, drawn)


class Lacking(PoundingError):
    """The dataset lacks what a state is of: its demand, or the place of it."""

    def __init__(self, state: Any, why: str) -> None:
        super().__init__(f"damage.{state.name}: {why}")
        self.why = why


class Demands(NamedTuple):
    """Demands of the motions over the threshold of a state, (motions, levels); NaN where a run failed.

    Infinite where the building collapses: no more is known of it than that it exceeds every threshold.
    """

    with_contact: Array
    without: Array
    jumps: bool = False  # of contact, which begins with a touch, or of storeys that yield: capped at a strength


def demands_of(case: xr.Dataset, state: Any) -> Demands:
    """The largest demands of the buildings and storeys, or interfaces and contact points, that a state is of.

    Each is over the threshold, from a dataset of `scan` at one gap, contact model and yield force. Raises Lacking for a
    building, interface or contact point that is not in the dataset, and a demand that it has not.
    """
    largest_demands = _of_interfaces if state.demand.interfaces else _of_links if state.demand.links else _of_buildings
    pair = [largest_demands(case, state, without) for without in (False, True)]
    jumps = bool(state.demand.interfaces) or state.demand.key == "link_spring_force"  # of springs that slip
    jumps = jumps or (state.demand.key == "storey_shear" and _may_yield(case, state))
    ratios = [np.where(np.isfinite(peaks), peaks, np.nan) / state.threshold for peaks in pair]
    if state.demand.of_structure:  # of buildings beside the one that collapses nothing is known
        fell = [by_amplitude(collapsed(case, without=without, building=state.building)) for without in (False, True)]
        if any(side.any() for side in fell):
            ratios = [np.where(side & np.isnan(ratio), np.inf, ratio) for side, ratio in zip(fell, ratios, strict=True)]
            return Demands(ratios[0], ratios[1], True)
    if jumps:  # a demand that is capped at the threshold may be less than it by rounding
        ratios = [np.where(np.isclose(ratio, 1.0, rtol=0.0, atol=ROUNDED), 1.0, ratio) for ratio in ratios]
    return Demands(ratios[0], ratios[1], jumps)


def _may_yield(case: xr.Dataset, state: Any) -> bool:
    """True where a storey that the state is of has a strength."""
    if "storey_ductility" not in case:
        return False
    ductility = case["storey_ductility"]
    if state.building:
        ductility = ductility.sel(building=state.building)
    if state.storey:
        ductility = ductility.isel(storey=state.storey - 1)
    return bool(np.isfinite(ductility.values).any())


def _of_buildings(case: xr.Dataset, state: Any, without: bool) -> Array:
    """The largest demand of the chosen buildings and storeys by motion and level."""
    demand, ending = state.demand, "_free" if without else ""
    names = list(map(str, case["building"].values))
    walls = [] if state.building else moat_walls(Results(case).scene)
    places = [i for i in _indices_of(case, state, "building") if not np.isnan(case["building_period"].values[i])]
    places = [place for place in places if names[place] not in walls]
    if state.building and not places:
        raise _lacking_demand(state, f"{state.building} is rigid and moves with the ground; name another building")
    # The displacement of a mass is the drift of a building without storeys alone, and each dataset has either.
    name = demand.storeys if "storey_displacement_free" in case else demand.mass
    if not name or not (demand.mass or f"{name}_free" in case):
        raise _lacking_demand(state, demand.absent)
    peaks = finite(case, f"{name}{ending}").isel(building=places)
    peaks = peaks if "storey" in peaks.dims else peaks.expand_dims(storey=[1], axis=-1)
    if state.storey > peaks.sizes["storey"]:
        raise _lacking_demand(state, f"storey {state.storey} is asked for, and the highest is {peaks.sizes['storey']}")
    storeys = slice(state.storey - 1, state.storey) if state.storey else slice(None)
    demands = by_amplitude(peaks, ["building", "storey"])[..., storeys]
    if demand.per_height:
        levels = case["floor_level"].transpose("building", "storey").values[places]
        heights = np.diff(levels, axis=1, prepend=0.0)  # NaN where there is no storey
        for place, row in zip(places, heights, strict=True):
            if np.isnan(row[0]):
                raise _lacking_demand(state, f"of {names[place]} {demand.absent}")
        demands = demands / heights[:, storeys]
    if demand.of_structure and not state.storey:  # isolators are made to move
        isolated = isolated_buildings(Results(case).scene)
        demands = demands.copy()
        demands[..., [names[place] in isolated for place in places], 0] = np.nan
    largest = np.fmax.reduce(demands, axis=(-2, -1))
    if without and not (np.isfinite(largest).any() or collapsed(case, without=True, building=state.building).any()):
        repair = f"it has no storey {state.storey}" if state.storey else demand.absent or "every run failed"
        raise _lacking_demand(state, repair)
    return np.asarray(largest)


def _of_interfaces(case: xr.Dataset, state: Any, without: bool) -> Array:
    """The largest demand of the chosen interfaces or contact points by motion and level; 0 without contact."""
    demand = state.demand
    is_chosen = np.isin(case["contact_point_interface"].values, _indices_of(case, state, "interface"))
    is_chosen &= np.isin(np.arange(is_chosen.size), _indices_of(case, state, "contact_point"))
    if demand.points:
        is_chosen &= case["contact_point_kind"].values.astype(str) == demand.points
    if not is_chosen.any():
        raise _lacking_demand(state, demand.absent or f"{state.contact_point} is no contact point of {state.interface}")
    name, place = f"{POINT}{demand.interfaces}", "contact_point"
    if name not in case:  # two single masses: their one contact point is their interface
        name, place = demand.interfaces, "interface"
    peaks = by_amplitude(finite(case, name).isel({place: np.flatnonzero(is_chosen)}), [place])
    point_limits = case.variables.get("contact_point_yield_force", case["yield_force"].variable).values
    limits = np.broadcast_to(point_limits, is_chosen.shape)[is_chosen]
    # A law that is capped yields without exceeding F_E; of another F_E is only compared with.
    is_capped = bool((peaks >= (1.0 - ROUNDED) * limits).any()) and not (peaks > (1.0 + ROUNDED) * limits).any()
    if is_capped and state.threshold > (1.0 + ROUNDED) * limits.max():
        limit_text = say(limits.max(), YIELD_FORCE, 6)
        raise _lacking_demand(
            state,
            f"contacts there yield at {limit_text} in the model, which no run exceeds; write a threshold of "
            f"{limit_text} or less, or scan with a larger {'column_' * bool(demand.points)}yield_force",
        )
    return np.zeros(peaks.shape[:2]) if without else np.asarray(peaks.max(axis=-1))


def _of_links(case: xr.Dataset, state: Any, without: bool) -> Array:
    """The largest demand of the links at the chosen interfaces by motion and level."""
    interfaces = _indices_of(case, state, "interface")
    name = state.demand.links + "_free" * without
    if name not in case:
        raise _lacking_demand(state, state.demand.absent)
    peaks = by_amplitude(finite(case, name).isel(interface=interfaces), ["interface"])
    largest = np.fmax.reduce(peaks, axis=-1)
    if without and not np.isfinite(largest).any():
        raise _lacking_demand(state, state.demand.absent)
    return np.asarray(largest)


def _indices_of(case: xr.Dataset, state: Any, place: str) -> list[int]:
    """Which buildings, interfaces or contact points a state is of: the one that it names, or all."""
    names, wanted_name = list(map(str, case[place].values)), getattr(state, place)
    if wanted_name and wanted_name not in names:
        hint = f"{shown_text(wanted_name)} is not in the dataset{nearest(wanted_name, names)}"
        raise Lacking(state, f"{place.replace('_', ' ')} {hint}, which has {', '.join(names)}")
    return [index for index, name in enumerate(names) if not wanted_name or name == wanted_name]


def _lacking_demand(state: Any, why: str) -> Lacking:
    return Lacking(state, f"{state.demand.key}: {why}")
