"""Self-similarity of buildings that pound under pulses: scaled responses depend on dimensionless groups alone.

Displacements over a_p T_p² and forces over m a_p, of a pulse of amplitude a_p and period T_p, depend on ratios: of the
periods to T_p, of the masses, of the gap to a_p T_p² and of the contact's stiffness. Peaks under different pulses
therefore lie on one curve.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk.lab.verification.property import LINE, POINTS, Panel, Property, Reading, Series, series
from pounding_risk.scene.buildings import SingleMass
from pounding_risk.scene.interfaces import Interface
from pounding_risk.scene.records import Records
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.tables import Solver
from pounding_risk.studies.simulate import simulate

PULSES = ((1.0, 0.5), (4.0, 0.5), (2.5, 1.25))  # a_p [m/s²], T_p [s]
RATIOS = tuple(np.geomspace(0.3, 2.0, 18).tolist())  # period of the left building over T_p
OTHER = 0.35  # period of the right building over that of the left one
MASSES = (2e5, 3e5)  # kg
GAP = 0.001  # of a_p T_p²
STIFFNESS = 4000.0  # of the left mass over T_p², and for Hertz's power over the root of a_p T_p² as well
SAMPLES = 64  # in a period of the pulse
REST = 2.0  # periods of the pulse, behind it
LAWS = ("kelvin_voigt", "jankowski")
RTOL = 1e-9
MARGIN = 100.0  # times the tolerance of the runs


def pulse_peaks(law: str, amplitude: float, duration: float, ratio: float) -> NDArray[np.float64]:
    """Peak displacements of both buildings [m], peak contact force [N] and number of contacts, under a Ricker pulse."""
    length = amplitude * duration**2
    power = sqrt(length) if law == "jankowski" else 1.0
    pulse: Any = {
        "kind": "ricker",
        "pga": f"{amplitude!r} m/s^2",
        "period": f"{duration!r} s",
        "step": f"{duration / SAMPLES!r} s",
    }
    left = SingleMass(name="left", mass=MASSES[0], period=ratio * duration, damping=0.05)
    right = SingleMass(name="right", mass=MASSES[1], period=OTHER * ratio * duration, damping=0.05)
    stiffness = STIFFNESS * MASSES[0] / duration**2 / power
    interface = Interface(gap=GAP * length, contact_model=law, stiffness=stiffness, restitution=0.65)
    records = Records(generated=(pulse,), tail=REST * duration)
    run = simulate(Scene([left, right], [interface], records, solver=Solver(rtol=RTOL)))
    return np.array([*run["peak_displacement"].values, run["peak_contact_force"].item(), run["impact_count"].item()])


def self_similarity() -> Property:
    """Peaks under three pulses, scaled, over the ratio of the building's period to the pulse's."""
    readings, drawn = [], {}
    for law in LAWS:
        peaks = np.array([[pulse_peaks(law, *pulse, ratio) for ratio in RATIOS] for pulse in PULSES])
        lengths = np.array([amplitude * duration**2 for amplitude, duration in PULSES])[:, None]
        forces = np.array([MASSES[0] * amplitude for amplitude, _ in PULSES])[:, None]
        for words, scaled in (
            ("peak displacement of the left building", peaks[..., 0] / lengths),
            ("peak displacement of the right building", peaks[..., 1] / lengths),
            ("peak contact force", peaks[..., 2] / forces),
        ):
            difference = float(np.abs(scaled / scaled[0] - 1.0).max())
            readings.append(
                Reading(
                    f"{words}, {law}: farthest from the first pulse's curve, as a share",
                    *(0.0, difference, 0.0, MARGIN * RTOL, ""),
                    f"{MARGIN:g} times the tolerance of the runs, {RTOL:g}",
                )
            )
        drawn[law] = peaks[..., 2], peaks[..., 2] / forces
    plain, collapsed = drawn[LAWS[0]]
    names = [f"{amplitude:g} m/s², {duration:g} s" for amplitude, duration in PULSES]
    axis = "period of the left building over $T_p$"
    largest = max(reading.ours for reading in readings)
    return Property(
        "self_similarity",
        "Buildings that pound under pulses are self-similar",
        "Dimitrakopoulos, Kappos and Makris (2009)",
        "Dimitrakopoulos, E. G., Kappos, A. J. and Makris, N. (2009), Dimensional analysis of yielding and pounding "
        "structures for records without distinct pulses, Soil Dynamics and Earthquake Engineering 29(7), 1170-1180; "
        "and, of the same year, Dimensional analysis of the earthquake-induced pounding between adjacent structures",
        "https://doi.org/10.1016/j.soildyn.2009.02.006",
        "derived",
        "the idea through texts that cite the source; that it holds follows from the units of the equations",
        "displacements over a_p T_p² and forces over m a_p depend on dimensionless groups alone",
        tuple(readings),
        f"Three pulses, one curve: scaled peaks agree to {largest:.0e}",
        f"Ricker pulses of amplitude $a_p$ and period $T_p$; masses of {MASSES[0] / 1e3:g} t and {MASSES[1] / 1e3:g} "
        f"t, {LAWS[0]} contact (jankowski in the table), e = 0.65, gap {GAP:g} of $a_p T_p^2$",
        (
            Panel((axis, "peak contact force [kN]"), _curves(names, plain * 1e-3), "as they are"),
            Panel((axis, "peak contact force over $m a_p$"), _curves(names, collapsed), "over $m a_p$"),
        ),
    )


def _curves(names: list[str], rows: NDArray[np.float64]) -> tuple[Series, ...]:
    """The first pulse as a line, the others as points, which are seen where they lie on it."""
    looks = (LINE, *(POINTS for _ in names[1:]))
    return tuple(series(name, RATIOS, row, look) for name, row, look in zip(names, rows, looks, strict=True))
