"""Loops of storeys that yield, of one run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import QUIET, STYLES, motion_words, plain, title, wrapped
from pounding_risk.results.attributes import isolated_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

MOST = 9  # panels: the storeys that yield most
WIDE = 3  # panels beside each other


def hysteresis_figure(run: xr.Dataset, note: str = "") -> Figure:
    """Shear against drift of each storey that yields, those with the largest ductility first.

    Parameters
    ----------
    run : xarray.Dataset
        A run of `simulate` of a row in which storeys may yield.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        At most nine panels.

    Raises
    ------
    PoundingError
        If no storey of the run may yield.
    """
    if "storey_force" not in run:
        raise PoundingError("hysteresis: no storey of the run may yield; write storey_strengths and inelastic_storeys")
    ductility = run["storey_ductility"].transpose("building", "storey").values
    places = [tuple(place) for place in np.argwhere(np.isfinite(ductility))]
    places.sort(key=lambda place: -ductility[place])
    drawn = places[:MOST]
    isolated = isolated_of(run)
    drifts = 1e3 * run["drift"].transpose("time", "building", "storey").values
    shears = 1e-3 * run["storey_force"].transpose("time", "building", "storey").values
    figure, axes = wrapped(len(drawn), WIDE, (0.6, 1.2), (3.4, 2.8))
    for axis, (building, storey) in zip(axes.flat, drawn, strict=False):
        axis.axhline(0.0, color=QUIET, linewidth=0.6)
        axis.axvline(0.0, color=QUIET, linewidth=0.6)
        axis.plot(drifts[:, building, storey], shears[:, building, storey], color=STYLES[0][0], linewidth=1.0)
        name = str(run["building"].values[building])
        part = f"storey {storey + 1}" if storey or name not in isolated else "isolators"
        axis.set_title(f"{plain(name)}, {part}: ductility {ductility[building, storey]:.3g}", fontsize=9)
        axis.set_xlabel("drift [mm]")
        axis.set_ylabel("storey shear [kN]")
    yields = int((ductility[np.isfinite(ductility)] > 1.0).sum())
    left_out = f"; {len(drawn)} of {len(places)} are drawn" if len(places) > len(drawn) else ""
    headline = f"{yields} of {len(places)} storeys that may yield do so"
    title(figure, headline, f"{plain(motion_words(run.attrs))}{left_out}", plain(note))
    return figure
