"""Animation of a run: one HTML file that holds data and script, and fetches nothing.

Displacements and gaps are drawn larger by one factor, so that walls meet where the buildings do. Between two frames
nothing of a contact is lost: each frame has the largest force since the last one, and where there is one shows the
buildings at that instant.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.written import write_file
from pounding_risk.assessment.row import building_shapes, force_text
from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import law_words
from pounding_risk.reports.html import packed, script_page
from pounding_risk.results.attributes import bumper_lengths, bumper_words
from pounding_risk.results.check import check_run
from pounding_risk.results.files import check_target
from pounding_risk.units import say_in

Array = NDArray[np.float64]
RATES = (50.0, 40.0, 30.0, 25.0, 20.0, 15.0, 10.0)  # frames a second; the first of which the page stays small is taken
LARGEST = 300_000  # bytes of a page
STEPS = 16_000  # of a displacement, from zero to the largest; a difference of two still fits 16 bits
FORCES = 32_000  # of a contact force
NEEDED = ("displacement", "contact_force")
HEAD_ATTRIBUTES = ("record", "polarity", "contact_model")  # attributes that stand in the head of the page


class Frames(NamedTuple):
    """Frames of an animation: instants [s], displacements [m] of all floors, and forces [N] of the contact points."""

    time: Array
    displacement: Array  # (frames, floors)
    force: Array  # (frames, contact points)
    rate: float  # frames a second


def animate(run: xr.Dataset, out: str | Path) -> Path:
    """Write the animation of one run.

    Parameters
    ----------
    run : xarray.Dataset
        A dataset of `simulate`: ``displacement`` (time, building, storey) [m], NaN where a building has no such storey,
        and ``contact_force`` (time, contact_point) [N]; the coordinates that describe buildings and contact points; and
        the gaps [m] as ``interface_gap`` (interface) or as the attribute ``gap``.
    out : str or Path
        The page, .html.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    PoundingError
        For another dataset, for one so long that the page would not be small, and for an ``out`` that cannot be
        written.
    """
    target = check_target(out, (".html",))
    missing = [name for name in NEEDED if name not in run]
    if missing or "contact_point" not in run.dims:
        raise PoundingError(
            f"the dataset has no {missing[0] if missing else 'contact points'}, so it is no run with its histories; "
            "write one with simulate -o run.nc"
        )
    check_run(run)
    if run.sizes["time"] < 2:
        raise PoundingError("the run has fewer than two instants; nothing moves")
    for rate in RATES:
        text = script_page("animation_page", _model(run, frames(run, rate)))
        if len(text.encode("utf-8")) <= LARGEST:
            return write_file(target, text)
    span = float(run["time"][-1] - run["time"][0])
    raise PoundingError(
        f"the run lasts {span:g} s with {run.sizes['building']} buildings, too much for a page of "
        f"{LARGEST // 1000} kB; choose a part of it, such as run.sel(time=slice(0, {span / 2:.3g}))"
    )


def frames(run: xr.Dataset, rate: float) -> Frames:
    """The run at so many frames a second.

    A frame stands for the time since the last one: its forces are the largest in it, and its displacements those at
    the instant of the largest of all, or at its end where nothing touches.
    """
    time = run["time"].values
    force = np.nan_to_num(run["contact_force"].transpose("time", "contact_point").values)
    displacements = run["displacement"].transpose("time", "building", "storey").values
    floors = displacements[:, np.isfinite(displacements).any(axis=0)]
    count = max(2, int(np.ceil((time[-1] - time[0]) * rate)) + 1)
    ends = np.minimum(time[0] + np.arange(count) / rate, time[-1])
    # The frame that each instant belongs to; one a rounding error past a frame's end belongs to it.
    after = np.searchsorted(ends + 1e-6 / rate, time)
    peaks = np.zeros((count, force.shape[1]))
    np.maximum.at(peaks, after, force)
    at = ends.copy()
    strongest = force.max(axis=1, initial=0.0)
    # In rising order of force, so that the strongest instant of a frame is the one that stays.
    order = np.argsort(strongest, kind="stable")
    order = order[strongest[order] > 0.0]
    at[after[order]] = time[order]
    shown = np.stack([np.interp(at, time, floor) for floor in floors.T], axis=1) if floors.size else floors[:count]
    return Frames(at, shown, peaks, rate)


def _model(run: xr.Dataset, motion: Frames) -> dict[str, Any]:
    """The data of the page; numbers of frames are differences to the frame before, packed."""
    largest = float(np.abs(motion.displacement).max(initial=0.0)) or 1.0
    peak = float(motion.force.max(initial=0.0))
    steps = np.rint(motion.displacement / largest * STEPS).astype(np.int16)
    forces = np.rint(motion.force / (peak or 1.0) * FORCES).astype(np.int16)
    has_floors = np.isfinite(run["displacement"].transpose("time", "building", "storey").values).any(axis=0)
    points = [run[f"contact_point_{name}"].values for name in ("interface", "left_floor", "right_floor", "kind")]
    return {
        "title": str(run.attrs.get("title") or "A run"),
        "facts": _facts(run, motion),
        "buildings": [
            {"name": shape.name, "levels": shape.levels, "rigid": shape.is_rigid, "floors": int(has_floors[k].sum())}
            for k, shape in enumerate(building_shapes(run))
        ],
        "gaps": _gaps(run),
        "bumpers": bumper_lengths(run),
        "points": [
            {"interface": int(k), "left": float(left), "right": float(right), "kind": str(kind), "label": str(label)}
            for k, left, right, kind, label in zip(*points, run["contact_point"].values, strict=True)
        ],
        "frames": len(motion.time),
        "rate": motion.rate,
        "time": [round(float(instant), 4) for instant in motion.time],
        "largest": largest / STEPS,
        "strongest": peak / FORCES,
        "displacement": packed(np.diff(steps, axis=0, prepend=0), "i2"),
        "force": packed(forces, "i2"),
    }


def _gaps(run: xr.Dataset) -> list[float]:
    if "interface_gap" in run.variables:
        return [float(gap) for gap in run["interface_gap"].values]
    return [float(run.attrs["gap"])] * (run.sizes["building"] - 1)


def _facts(run: xr.Dataset, motion: Frames) -> str:
    """Sentences on the run, and on the contacts that the animation shows."""
    facts = [law_words(str(run.attrs[name])) for name in HEAD_ATTRIBUTES if name in run.attrs]
    if "pga" in run.attrs:
        facts.append(f"{say_in(float(run.attrs['pga']), 'g')}")
    gaps = _gaps(run)
    widths = [f"{1e3 * gap:.3g}" for gap in dict.fromkeys((min(gaps), max(gaps)))]
    facts.append(f"{'gaps' if len(widths) > 1 else 'gap'} of {' to '.join(widths)} mm")
    if bumpers := bumper_words(bumper_lengths(run)):
        facts.append(f"{bumpers} in {'them' if len(widths) > 1 else 'it'}, drawn on the left face")
    if "link" in run.dims:
        facts.append("springs or dampers between neighbours not drawn")
    is_known = np.isfinite(run["building_height"].values)
    if not is_known.all():
        names_text = " and ".join(map(str, run["building"].values[~is_known]))
        facts.append(f"no height is given of {names_text}: the one drawn is nominal")
    if "floor_rotation" in run:
        facts.append("floors that rotate drawn at their centres of mass")
    if "ground_widening" in run:
        facts.append("each building relative to the ground under it")
    peak = float(motion.force.max(initial=0.0))
    touch_count = int((motion.force > 0.0).any(axis=0).sum())
    points = counted(motion.force.shape[1], "contact point")
    touch_text = f"{touch_count} of {points} touch{'es' * (touch_count == 1)}, with up to {force_text(peak)}"
    return f"{', '.join(facts)}. {touch_text if touch_count else 'Nothing touches'}."
