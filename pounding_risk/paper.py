"""The demo: the pair of the 2011 paper, its two figures, the search for its yield force, and a small ensemble."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from importlib.resources import files
from math import inf
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from pounding_risk import figures
from pounding_risk.collision import impact
from pounding_risk.ensemble import scan
from pounding_risk.history import simulate
from pounding_risk.models.contact import ViscousElastoplastic
from pounding_risk.models.restitution import CONCRETE
from pounding_risk.results import save
from pounding_risk.scenario import parse_scene
from pounding_risk.study import AS_RECORDED, Study

STATED_TIME = (2.3, 2.5)  # s; "identical until 2.4 seconds" (Khatiwada et al. 2011, section 3)
SEARCHED = np.linspace(100e3, 1.5e6, 141)  # N; yield forces tried
# Figure 4 of the paper: strikers of van Mier et al. (1991). Stiffness and F_E are not published; β as for concrete in
# Jankowski (2005), and a plateau below the 441 kN that the lighter striker would reach without one.
STRIKERS = ((570.0, 0.5), (570.0, 2.5), (290.0, 2.5))  # kg, m/s
STRIKER_LAW = ViscousElastoplastic(2.75e9)  # type: ignore[call-arg]
STRIKER_STRENGTH = 300e3  # N


class Window(NamedTuple):
    """Yield forces for which the paper's statement holds: first yield at about 2.4 s, then a smaller peak."""

    low: float  # N
    high: float  # N
    searched: xr.Dataset  # the scan behind it


def scene(name: str) -> Study:
    """A scene that comes with the package: "paper" or "ensemble"."""
    text = (files("pounding_risk") / "scenes" / f"{name}.toml").read_text(encoding="utf-8")
    return parse_scene(text, source=f"{name}.toml")


def figure_8(study: Study) -> tuple[xr.Dataset, xr.Dataset]:
    """Histories of the paper's pair under both laws: nonlinear viscoelastic, viscous elastoplastic."""
    return simulate(study, law="jankowski", yield_force=inf), simulate(study)


def figure_4() -> list:
    """Isolated impacts of the strikers on a fixed body, under the capped law."""
    return [
        impact(STRIKER_LAW, speed, mass, restitution=CONCRETE, yield_force=STRIKER_STRENGTH) for mass, speed in STRIKERS
    ]


def window(study: Study) -> Window:
    """Search the yield forces that fit the paper's statement, under the record as recorded.

    F_E fits where yielding starts within `STATED_TIME` and the peak relative displacement is smaller than without
    yielding. The window returned is the longest run of fitting forces.
    """
    grid = study.grid._replace(yield_forces=(*SEARCHED, inf), gaps=(study.gap,))
    searched = scan(replace(study, grid=grid))
    fits = fitting(searched.sel(polarity=AS_RECORDED).squeeze())
    runs = np.split(np.flatnonzero(fits), np.flatnonzero(np.diff(np.flatnonzero(fits)) > 1) + 1)
    longest = max(runs, key=len)
    forces = searched["yield_force"].values
    return Window(float(forces[longest[0]]), float(forces[longest[-1]]), searched)


def fitting(line: xr.Dataset) -> np.ndarray:
    """For a scan along yield_force alone: where the paper's statement holds."""
    first = line["first_yield_time"].values
    peak = line["peak_relative_displacement"].values
    without = peak[np.isinf(line["yield_force"].values)][0]
    return (first >= STATED_TIME[0]) & (first <= STATED_TIME[1]) & (peak < without)


def demo(folder: str | Path = "pounding-demo", say: Callable[[str], None] = print) -> dict[str, Path]:
    """Run the paper's example and write its figures and datasets into ``folder``; returns what was written."""
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    study = scene("paper")
    say("The pair of Khatiwada et al. (2011) under El Centro 1940 at 0.5 g; 5 % damping and F_E = 450 kN are assumed.")
    elastic, plastic = figure_8(study)
    found = window(study)
    ensemble = scan(scene("ensemble"))
    drawn = {
        "paper.png": figures.comparison_figure([elastic, plastic]),
        "impacts.png": figures.impact_figure(figure_4()),
        "yield_force.png": figures.window_figure(found.searched, (found.low, found.high)),
        "map.png": figures.scan_figure(ensemble),
    }
    written = {name: target / name for name in drawn}
    for name, figure in drawn.items():
        figure.savefig(written[name], dpi=120, metadata={"Software": None})
    for name, dataset in {"paper.nc": plastic, "ensemble.nc": ensemble}.items():
        written[name] = save(dataset, target / name)
    for line in findings(elastic, plastic, found, ensemble):
        say(line)
    return written


def findings(elastic: xr.Dataset, plastic: xr.Dataset, found: Window, ensemble: xr.Dataset) -> list[str]:
    """What the demo shows, in sentences with numbers."""
    peaks = [float(np.abs(run["relative_displacement"]).max()) * 1e3 for run in (elastic, plastic)]
    line = found.searched.squeeze()
    first = json.loads(plastic.attrs["outputs"])["first_yield_time"]
    peak = line["peak_relative_displacement"]
    lower = (peak.isel(yield_force=slice(0, -1)) < peak.isel(yield_force=-1)).mean("yield_force")
    shares = {str(name): float(lower.sel(polarity=name)) for name in line["polarity"].values}
    contact = float((ensemble["impact_count"] > 0).mean())
    return [
        f"Identical until {first:.2f} s; then the peak relative displacement is {peaks[1]:.2f} mm with yielding, "
        f"{peaks[0]:.2f} mm without.",
        f"The paper's statement holds for F_E from {found.low / 1e3:.0f} to {found.high / 1e3:.0f} kN.",
        "Yielding lowers the peak for "
        + ", ".join(f"{share:.0%} of the F_E tried ({name})" for name, share in shares.items())
        + ": one run proves nothing.",
        f"Ensemble: {ensemble['status'].size} cases, {int(ensemble['simulated'].sum())} of them run, "
        f"{contact:.0%} with contact.",
    ]
