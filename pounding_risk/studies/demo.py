"""Runs of the demo: the pair of Khatiwada et al. (2011), the search for its yield force, and a small ensemble."""

from __future__ import annotations

from importlib.resources import files
from math import inf
from typing import NamedTuple

import numpy as np
import xarray as xr

from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.laws import ViscousElastoplastic
from pounding_risk.models.restitution import CONCRETE
from pounding_risk.motions.request import AS_RECORDED
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.scene import Scene
from pounding_risk.studies.impact import impact
from pounding_risk.studies.simulate import simulate
from pounding_risk.units import signed_percent

STATED_TIME = (2.3, 2.5)  # s; "identical until 2.4 seconds" (Khatiwada et al. 2011, section 3)
SEARCHED = np.linspace(100e3, 1.5e6, 281)  # N; yield forces tried, every 5 kN
# Figure 4 of the paper: strikers of van Mier et al. (1991). Stiffness and F_E are not published; β as for concrete in
# Jankowski (2005), and a plateau below the 441 kN that the lighter striker would reach without one.
STRIKERS = ((570.0, 2.5), (290.0, 2.5), (570.0, 0.5), (290.0, 0.5))  # kg, m/s
STRIKER_LAW = ViscousElastoplastic(2.75e9)
STRIKER_STRENGTH = 300e3  # N
STRIKER_NOTE = (
    f"β = {STRIKER_LAW.stiffness / 1e9:g}e9 N/m$^{{1.5}}$ and $F_E$ = {STRIKER_STRENGTH / 1e3:.0f} kN assumed, not "
    "published; e by the paper's eq. (4)"
)
NOTABLE = 0.01  # a peak that changes by less than this share is called unchanged


class Window(NamedTuple):
    """Yield forces for which the paper's statement holds: first yield at about 2.4 s, then a smaller peak."""

    low: float  # N
    high: float  # N
    searched: xr.Dataset  # the scan behind it


def scene(name: str) -> Scene:
    """A scene that comes with the package: "paper", "ensemble" or "compare"."""
    return parse_scene(text_of(name), source=f"{name}.toml")


def text_of(name: str) -> str:
    """The TOML of a scene that comes with the package."""
    return (files("pounding_risk.scene") / "shipped" / f"{name}.toml").read_text(encoding="utf-8")


def figure_8(study: Scene) -> tuple[xr.Dataset, xr.Dataset]:
    """Histories of the paper's pair under both laws: nonlinear viscoelastic, viscous elastoplastic."""
    return simulate(study, law="jankowski", yield_force=inf), simulate(study)


def figure_4() -> list:
    """Isolated impacts of the strikers on a fixed body, under the capped law."""
    return [
        impact(STRIKER_LAW, speed, mass, restitution=CONCRETE, yield_force=STRIKER_STRENGTH) for mass, speed in STRIKERS
    ]


def window(study: Scene) -> Window:
    """Search the yield forces that fit the paper's statement, under the record as recorded.

    F_E fits where yielding starts within `STATED_TIME` and the peak relative displacement is smaller than without
    yielding. The window returned is the longest run of fitting forces among `SEARCHED`. Raises PoundingError where
    none fits.
    """
    grid = study.grid._replace(yield_forces=(*SEARCHED, inf), gaps=(study.gap,))
    searched = scan(study.updated(grid=grid))
    indices = np.flatnonzero(fitting(searched.sel(polarity=AS_RECORDED).squeeze()))
    if not indices.size:
        tried = f"{SEARCHED[0] / 1e3:.0f} to {SEARCHED[-1] / 1e3:.0f} kN"
        raise PoundingError(
            f"{study.name}: no yield force of {tried} fits the paper's statement; is it the paper's pair?"
        )
    longest = max(np.split(indices, np.flatnonzero(np.diff(indices) > 1) + 1), key=len)
    forces = searched["yield_force"].values
    return Window(float(forces[longest[0]]), float(forces[longest[-1]]), searched)


def fitting(line: xr.Dataset) -> np.ndarray:
    """For a scan along yield_force alone: where the paper's statement holds."""
    first = line["first_yield_time"].values
    peak = line["peak_relative_displacement"].values
    elastic_peak = peak[np.isinf(line["yield_force"].values)][0]
    return (first >= STATED_TIME[0]) & (first <= STATED_TIME[1]) & (peak < elastic_peak)


def pair_findings(elastic: xr.Dataset, plastic: xr.Dataset) -> list[str]:
    """Both laws on the paper's pair, in sentences with numbers."""
    peaks = [float(np.abs(run["relative_displacement"]).max()) * 1e3 for run in (elastic, plastic)]
    first = float(plastic["first_yield_time"].min())
    contacts = plastic.sizes["contact"]
    yielding = int((plastic["contact_yields"] > 0).sum())
    return [
        f"Identical until {first:.2f} s; then the peak relative displacement is {peaks[1]:.2f} mm with yielding, "
        f"{peaks[0]:.2f} mm without ({yielding} of {contacts} contacts yield)."
    ]


def window_findings(fit: Window) -> list[str]:
    """Where the paper's statement holds and where it does not, in sentences with numbers."""
    line = fit.searched.squeeze()
    peak = line["peak_relative_displacement"]
    forces = line["yield_force"].values
    change = (peak / peak.isel(yield_force=int(np.isinf(forces).argmax())) - 1.0).isel(yield_force=np.isfinite(forces))
    inside = change.sel(yield_force=slice(fit.low, fit.high))
    by_polarity = []
    for name in map(str, line["polarity"].values):
        changes, changes_inside = change.sel(polarity=name).values, inside.sel(polarity=name).values
        largest = changes_inside[np.abs(changes_inside).argmax()]
        lowered, raised = _percent(changes < -NOTABLE), _percent(changes > NOTABLE)
        by_polarity.append(
            f"Record {name}: in that window yielding changes the peak by up to {signed_percent(largest)} %; over all "
            f"F_E tried it lowers the peak in {lowered}, raises it in {raised} (by more than 1 %)."
        )
    return [
        f"The paper's statement holds for F_E from {fit.low / 1e3:.0f} to {fit.high / 1e3:.0f} kN "
        f"({SEARCHED.size} values from {SEARCHED[0] / 1e3:.0f} to {SEARCHED[-1] / 1e3:.0f} kN tried).",
        *by_polarity,
    ]


def ensemble_findings(ensemble: xr.Dataset) -> list[str]:
    """The small grid in one sentence: what was run, and what yielding does there."""
    yields = ensemble["yield_exceedance"] == 1
    peak = ensemble["peak_relative_displacement"]
    change = (peak / peak.sel(yield_force=inf) - 1.0).where(yields)
    larger, smaller = int((change > NOTABLE).sum()), int((change < -NOTABLE).sum())
    return [
        f"Ensemble: {ensemble['status'].size} cases, {int(ensemble['simulated'].sum())} of them run, "
        f"{_percent(ensemble['impact_count'].values > 0)} with contact.",
        f"Of the {int(yields.sum())} cases that yield, {larger} have a larger peak than without yielding, {smaller} a "
        "smaller one (by more than 1 %): one run proves nothing.",
    ]


def _percent(cases: np.ndarray) -> str:
    return f"{100.0 * cases.mean():.0f} %"
