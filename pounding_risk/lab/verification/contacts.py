"""Published relations of contacts: impacts under every law, twins and a wall, two Kelvin-Voigt laws, plateaus."""

from __future__ import annotations

from math import atan2, cos, exp, hypot, inf, log, nan, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pounding_risk.lab.verification.case import read_case, shipped
from pounding_risk.lab.verification.property import POINTS, Panel, Property, Reading, near, series
from pounding_risk.models.contact.impulsive import INSTANT_LAWS
from pounding_risk.models.contact.laws import LAWS, SHIPPED, stiffness_quantity
from pounding_risk.scene.buildings import RigidWall, SingleMass
from pounding_risk.scene.interfaces import Interface
from pounding_risk.scene.records import Records
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.tables import Solver
from pounding_risk.studies import demo
from pounding_risk.studies.impact import impact
from pounding_risk.studies.simulate import simulate

RTOL = 1e-9
MARGIN = 100.0 * RTOL
SHARP = 1e-9
OF_IMPACTS = "a thousand times the tolerance of an impact, 1e-12"
OF_RUNS = f"100 times the tolerance of the runs, {RTOL:g}"
TIME, FORCE = "time [s]", "contact force [kN]"

# ------------------------------------------------------------------------------------------ one impact, every law

STRIKER, STRUCK, SPEED, SPECIFIED = 300e3, 500e3, 0.5, 0.65  # kg, kg, m/s, restitution
STIFFNESS = {"N/m": 9.35e7, "N/m^1.5": 2.75e9}
YIELD = 0.6  # of the force without a cap, for laws that have one
CAPPED = ("van_mier", "viscous_elastoplastic")
DESIGN = 0.02  # m, penetration for which the bilinear law is made


def impacts() -> dict[str, Any]:
    """The impact of two floors under every law that ships and has a stiffness."""
    runs = {}
    for name in SHIPPED:
        kind: Any = LAWS[name]
        if "stiffness" not in kind._fields:
            continue
        stiffness = STIFFNESS[stiffness_quantity(kind).unit]
        law = kind(stiffness, DESIGN) if "design_penetration" in kind._fields else kind(stiffness)
        keys: dict[str, Any] = {"restitution": SPECIFIED} if kind.needs_restitution else {}
        whole = impact(law, SPEED, STRIKER, STRUCK, **keys)
        runs[name] = whole
        if name in CAPPED:
            runs[name] = impact(law, SPEED, STRIKER, STRUCK, **keys, yield_force=YIELD * whole.peak_force)
    return runs


def instant_impacts() -> dict[str, tuple[float, float]]:
    """Restitution of the models that have no force against penetration: that of their formula, and ours.

    Bars of one section, of 10 and 20 m, part when the wave is back in the shorter one: e is the ratio of their lengths.
    """
    newton = INSTANT_LAWS["stereomechanical"]()
    pairs = {
        "stereomechanical": (SPECIFIED, impact(newton, SPEED, STRIKER, STRUCK, restitution=SPECIFIED)),
        "merged": (0.0, impact(INSTANT_LAWS["merged"](), SPEED, STRIKER, STRUCK)),
        "distributed_mass": (0.5, impact(INSTANT_LAWS["distributed_mass"](10.0, 20.0), SPEED, STRIKER, 2.0 * STRIKER)),
    }
    return {name: (known, one.restitution) for name, (known, one) in pairs.items()}


def restitutions() -> dict[str, float]:
    """Restitution in closed form, of the laws that have one, for `SPECIFIED`."""
    from scipy.optimize import brentq

    decrement = log(SPECIFIED)
    viscous = -decrement / hypot(pi, decrement)
    whole = sqrt(1.0 - viscous**2)
    turned = pi - atan2(2.0 * viscous * whole, 1.0 - 2.0 * viscous**2)
    approach = (1.0 - SPECIFIED**2) / (SPECIFIED * (SPECIFIED * (pi - 2.0) + 2.0))
    inner = sqrt(1.0 - approach**2)
    damped = 0.75 * (1.0 - SPECIFIED**2)
    return {
        **dict.fromkeys(("linear", "hertz", "van_mier"), 1.0),
        **dict.fromkeys(("kelvin_voigt", "hertz_damp_exact"), SPECIFIED),
        "kelvin_voigt_tension_cut": exp(-viscous / whole * turned),
        "modified_kelvin_voigt": exp(-approach / inner * atan2(inner, approach)),
        "hertz_damp": float(brentq(lambda e: log((1.0 + damped) / (1.0 - damped * e)) - damped * (1.0 + e), 0.1, 1.0)),
    }


def isolated_impacts() -> Property:
    """Restitution of one impact under every law, and its loss of energy against that of an instant impact."""
    runs = impacts()
    mass = STRIKER * STRUCK / (STRIKER + STRUCK)
    known = restitutions()
    readings = []
    for name, run in runs.items():
        if name in known:
            readings.append(near(f"{name}: restitution", known[name], run.restitution, SHARP, OF_IMPACTS))
        energy = run.energy_lost / (0.5 * mass * SPEED**2) + run.restitution**2
        readings.append(near(f"{name}: work of the force over m v²/2, and e²", 1.0, energy, SHARP, OF_IMPACTS))
    for name, (e, ours) in instant_impacts().items():
        readings.append(near(f"{name}: restitution", e, ours, SHARP, OF_IMPACTS))
    time = tuple(series(name, run.time * 1e3, run.force * 1e-3) for name, run in runs.items())
    depth = tuple(series(name, run.penetration * 1e3, run.force * 1e-3) for name, run in runs.items())
    es = [run.restitution for run in runs.values()]
    return Property(
        "isolated_impacts",
        "One impact of two floors under every law",
        "Goldsmith (2001)",
        "Goldsmith, W. (2001), Impact: the theory and physical behaviour of colliding solids, Dover, chapter 1",
        "",
        "derived",
        "textbook relation; restitutions of the laws' authors, where their equations have a closed form, derived again",
        "whatever the law, the force takes (1 − e²) m v²/2 of the energy, with the restitution e that the law achieves",
        tuple(readings),
        f"For a specified e = {SPECIFIED:g}, the laws return {min(es):.2f} to {max(es):.2f}; {len(known)} of "
        f"{len(runs)} are closed forms",
        "300 t against 500 t at 0.5 m/s; 9.35e7 N/m, or 2.75e9 N/m$^{1.5}$ for Hertz's power; "
        f"{' and '.join(CAPPED)} yield at {100.0 * YIELD:g} % of their force",
        (Panel(("time [ms]", FORCE), time), Panel(("penetration [mm]", FORCE), depth)),
    )


# --------------------------------------------------------------------------------------- twins and the fixed wall

TWIN: dict[str, Any] = {"mass": 25.0, "stiffness": 98696.0, "damping": 0.07}  # those of SDND102
TWIN_SPEED = 0.1  # m/s, at which both are released towards one another
TWIN_GAP = 1e-3  # m, between the twins
TWIN_STIFFNESS = {"linear": 2.88e7, "kelvin_voigt": 2.88e7, "jankowski": 1e9}  # N/m or N/m^1.5, between the twins
TWIN_LENGTH = 1.0  # s


def twin_runs(law: str) -> tuple[xr.Dataset, xr.Dataset]:
    """Twins released towards one another, and one of them towards a wall at half the gap.

    Half the penetration and half the relative mass: the wall's stiffness is the pair's times 2, or times 2^1.5 for
    Hertz's power.
    """
    kind: Any = LAWS[law]
    linear = stiffness_quantity(kind).unit == "N/m"
    contact: dict[str, Any] = {"contact_model": law, **({"restitution": 0.65} if kind.needs_restitution else {})}
    made: Any = [{"kind": "still", "duration": f"{TWIN_LENGTH} s"}]
    still = Records(generated=made)
    left = SingleMass(name="left", **TWIN, initial_velocity=TWIN_SPEED)
    right = SingleMass(name="right", **TWIN, initial_velocity=-TWIN_SPEED)
    pair = Interface(gap=TWIN_GAP, stiffness=TWIN_STIFFNESS[law], **contact)
    stiffer = TWIN_STIFFNESS[law] * (2.0 if linear else 2.0**1.5)
    wall = Interface(gap=0.5 * TWIN_GAP, stiffness=stiffer, **contact)
    solver = Solver(rtol=RTOL)
    twins = simulate(Scene([left, right], [pair], still, solver=solver))
    return twins, simulate(Scene([left, RigidWall(name="wall")], [wall], still, solver=solver))


def twins_and_wall() -> Property:
    """Histories of twins, and of one of them in front of a wall."""
    readings, first_runs = [], None
    for law in TWIN_STIFFNESS:
        twins, wall = twin_runs(law)
        at = np.intersect1d(twins["time"].values, wall["time"].values)  # nodes of both, where no curve is laid between
        moves = [_at_nodes(twins, "left", at), -_at_nodes(twins, "right", at), _at_nodes(wall, "left", at)]
        peak = float(np.abs(moves[2]).max())
        for words, other in (("left twin", moves[0]), ("right twin, mirrored", moves[1])):
            words = f"{law}: {words}, farthest from the building at the wall over its peak"
            difference = float(np.abs(other - moves[2]).max()) / peak
            readings.append(Reading(words, 0.0, difference, 0.0, MARGIN, "", OF_RUNS))
        force = twins["peak_contact_force"].item() / wall["peak_contact_force"].item()
        readings.append(near(f"{law}: peak contact force over that at the wall", 1.0, force, MARGIN, OF_RUNS))
        ours, at_wall = (float(run["impact_count"].item()) for run in (twins, wall))
        readings.append(near(f"{law}: number of contacts", at_wall, ours, 0.0, "a count"))
        first_runs = first_runs or (twins, wall)
    assert first_runs is not None
    twins, wall = first_runs
    fine, few = np.linspace(0.0, 0.4, 801), np.linspace(0.0, 0.4, 41)
    moved = (
        series("one building before a wall", fine, 1e3 * _displacement(wall, "left", fine)),
        series("left twin", few, 1e3 * _displacement(twins, "left", few), POINTS),
        series("right twin, mirrored", few, -1e3 * _displacement(twins, "right", few), POINTS),
    )
    return Property(
        "twins_and_wall",
        "Two equal buildings that strike one another, and one that strikes a wall",
        "code_aster SDND102",
        "EDF R&D, code_aster, validation manual V5.01.102: SDND102, shock of two equal oscillators",
        "https://github.com/ehmoussi/code_aster",
        "read",
        "the relation and the system read; released here, where the source shakes them",
        "two equal oscillators in opposite motion are one oscillator before a fixed wall at half the gap",
        tuple(readings),
        f"Twins strike one another as one of them strikes a wall: {len(readings)} readings within 100 times the "
        "tolerance",
        f"25 kg, 10 Hz, damping 7 %, released at {TWIN_SPEED:g} m/s towards one another, gap 1 mm; linear contact of "
        "2.88e7 N/m, twice that at the wall at 0.5 mm (other laws in the table)",
        (Panel((TIME, "displacement [mm]"), moved),),
    )


def _at_nodes(run: xr.Dataset, building: str, times: Any) -> Any:
    """Displacement at nodes of a run."""
    values = run["displacement"].sel(building=building).isel(storey=0).values
    return values[np.searchsorted(run["time"].values, times)]


def _displacement(run: xr.Dataset, building: str, at: Any) -> Any:
    """Displacement at times, by the cubic through the displacements and velocities of the nodes."""
    from scipy.interpolate import CubicHermiteSpline

    values = run[["displacement", "velocity"]].sel(building=building).isel(storey=0)
    times, indices = np.unique(run["time"].values, return_index=True)
    return CubicHermiteSpline(times, values["displacement"].values[indices], values["velocity"].values[indices])(at)


# ----------------------------------------------------------------------------------------- two Kelvin-Voigt laws

WHOLE, CUT = "kelvin_voigt", "kelvin_voigt_tension_cut"
DROP_CASE = "sdnd108b"
DIGITS = 5e-7  # relative, of the published values: half a unit of the sixth digit
HEIGHT_AT = 1.1  # s
MASS, SPRING, DASHPOT, GRAVITY, DROP, START = 1.0, 100.0, 5.0, 10.0, 2.0, 1.0  # of SDND108 B, SI


class Drop(NamedTuple):
    """What the drop on a stop with a dashpot gives in closed form."""

    lets_go: float  # s
    height: float  # m above the stop's far side, at `HEIGHT_AT`: negative below the point of release


def drop(is_cut: bool) -> Drop:
    """SDND108 B in closed form: the mass lets go where the penetration is zero, or where the force is."""
    from scipy.optimize import brentq

    touch = (-START + sqrt(START**2 + 2.0 * GRAVITY * DROP)) / GRAVITY
    speed, rate = START + GRAVITY * touch, 0.5 * DASHPOT / MASS
    omega, sag = sqrt(SPRING / MASS - rate**2), MASS * GRAVITY / SPRING
    sine_part = (speed - rate * sag) / omega

    def state(time: float) -> tuple[float, float]:
        turn, decay = omega * time, exp(-rate * time)
        swing = -sag * cos(turn) + sine_part * sin(turn)
        slope = omega * (sag * sin(turn) + sine_part * cos(turn))
        return sag + decay * swing, decay * (slope - rate * swing)

    def ends(time: float) -> float:
        depth, velocity = state(time)
        return SPRING * depth + (DASHPOT * velocity if is_cut else 0.0)

    lasting = float(brentq(ends, 1.5 / omega, 4.5 / omega, xtol=1e-15))
    depth, velocity = state(lasting)
    after = HEIGHT_AT - touch - lasting
    return Drop(touch + lasting, -(DROP + depth + velocity * after + 0.5 * GRAVITY * after**2))


def kelvin_voigt_laws() -> Property:
    """The drop of SDND108 B under both Kelvin-Voigt laws."""
    case = read_case(shipped()[DROP_CASE])
    scene: Any = case.subject
    runs = {law: simulate(scene.updated(rtol=RTOL), law=law) for law in (WHOLE, CUT)}
    closed_forms = [one for one in case.published if one.quantity == "displacement" and one.kind == "closed form"]
    points = {value.at["time"]: value.printed.value for value in closed_forms}
    published = points[HEIGHT_AT]
    heights = {law: -float(_displacement(run, "mass", HEIGHT_AT)) for law, run in runs.items()}
    forces = {law: run["contact_force"].squeeze(drop=True) for law, run in runs.items()}
    difference = heights[CUT] / published - 1.0
    least = {law: float(force.min()) for law, force in forces.items()}
    cut, at = drop(True).height, f"{WHOLE}: height at {HEIGHT_AT:g} s"
    rounding = MARGIN * float(forces[CUT].max())
    readings = [
        near(at, published, heights[WHOLE], DIGITS * abs(published), "the sixth digit printed", "m"),
        near(f"{CUT}{at.removeprefix(WHOLE)}", cut, heights[CUT], MARGIN * abs(cut), OF_RUNS, "m"),
        Reading(
            f"{CUT}: that height over the published one, less 1",
            *(cut / published - 1.0, difference, -inf, -DIGITS, ""),
            "farther than the sixth digit: the published value is not that of this law",
        ),
        Reading(f"{WHOLE}: least contact force", nan, least[WHOLE], -inf, -rounding, "N", "it pulls"),
        Reading(f"{CUT}: least contact force", 0.0, least[CUT], -rounding, 0.0, "N", "it never pulls"),
    ]
    times = np.linspace(0.5, 1.2, 701)
    drawn = [series(law, times, -_displacement(run, "mass", times)) for law, run in runs.items()]
    drawn.append(series("published", list(points), list(points.values()), POINTS))
    pressed = {law: force[(force["time"] > 0.5) & (force["time"] < 1.0)] for law, force in forces.items()}
    of_force = tuple(series(law, force["time"].values, force.values) for law, force in pressed.items())
    panels = Panel((TIME, "height [m]"), tuple(drawn)), Panel((TIME, "contact force [N]"), of_force)
    return Property(
        "kelvin_voigt_laws",
        "A mass that falls on a spring and a dashpot, which pull or not before they let go",
        "code_aster SDND108 B",
        case.about.citation,
        case.about.url,
        "read",
        "read",
        "take-off and heights of a stop that holds on until the penetration is zero",
        tuple(readings),
        f"The published heights are those of {WHOLE}; {CUT} is {100.0 * abs(difference):.2g} % off",
        "1 kg, let go at 1 m/s 2 m above a stop of 100 N/m and 5 N s/m, g = 10 m/s²",
        panels,
    )


# -------------------------------------------------------------------------------- figures 4 and 8 of the first paper


def _plateau(one: Any) -> float:
    """Time at the largest force [s]."""
    top = one.time[one.force >= one.peak_force * (1.0 - 1e-6)]
    return float(top[-1] - top[0]) if top.size > 1 else 0.0


def plateaus() -> Property:
    """Van Mier's plateaus, as figure 4 of Khatiwada et al. (2011) draws them."""
    results = demo.figure_4()
    heavy, light, slow, slow_light = results
    at_top = f"{100.0 * 1e-6:g} %"
    readings = (
        Reading(
            "peak force at 2.5 m/s, 570 kg over 290 kg",
            *(1.0, heavy.peak_force / light.peak_force, 1.0 - MARGIN, 1.0 + MARGIN, ""),
            "almost identical in the tests; equal under a cap",
        ),
        Reading(
            "duration of the plateau at 2.5 m/s, 570 kg over 290 kg",
            *(nan, _plateau(heavy) / _plateau(light), 1.0, inf, ""),
            "longer for the heavier striker",
        ),
        Reading(
            "duration of the plateau at 0.5 m/s, both strikers",
            *(0.0, _plateau(slow) + _plateau(slow_light), 0.0, 0.0, "s"),
            f"there is none; a plateau is within {at_top} of the peak",
        ),
    )
    names = [f"{mass:g} kg, {speed:g} m/s" for mass, speed in demo.STRIKERS]
    drawn = tuple(series(name, one.time * 1e3, one.force * 1e-3) for name, one in zip(names, results, strict=True))
    return Property(
        "plateaus",
        "Peak force and plateau of four strikers of concrete",
        "van Mier et al. (1991)",
        "van Mier, J. G. M., Pruijssers, A. F., Reinhardt, H. W. and Monnier, T. (1991), Load-time response of "
        "colliding concrete bodies, Journal of Structural Engineering 117(2), 354-374; in Khatiwada et al. (2011), "
        "figure 4",
        "",
        "quoted",
        "through Khatiwada et al. (2011); no number is printed there",
        "peak forces are almost the same for both masses, their plateau is longer for the heavier one; at 0.5 m/s "
        "there is none",
        readings,
        f"Equal peaks, a plateau {_plateau(heavy) / _plateau(light):.2g} times as long for the heavier striker, none "
        "at 0.5 m/s",
        demo.STRIKER_NOTE,
        (Panel(("time [ms]", FORCE), drawn),),
    )


def yielding_contact() -> Property:
    """The relative displacement with and without yielding, as figure 8 of Khatiwada et al. (2011) draws it."""
    elastic, plastic = demo.figure_8(demo.scene("paper"))
    moves = [run["relative_displacement"].squeeze(drop=True) for run in (elastic, plastic)]
    first = float(plastic["first_yield_time"].item())
    before = [move.sel(time=slice(None, first - 1e-9)).values for move in moves]
    count = min(map(len, before)) - 1  # the last step before the yield ends on it in one run and passes it in the other
    peaks = [float(np.abs(move).max()) for move in moves]
    named = zip(("nonlinear viscoelastic", "viscous elastoplastic"), moves, strict=True)
    drawn = tuple(series(name, move["time"].values, 1e3 * move.values) for name, move in named)
    readings = (
        Reading("time of the first yield", 2.4, first, 2.35, 2.45, "s", "half a unit of the digit printed"),
        Reading(
            "largest difference before it",
            *(0.0, float(np.abs(before[0][:count] - before[1][:count]).max()), 0.0, 0.0, "m"),
            "the two graphs are identical",
        ),
        Reading(
            "peak with yielding over peak without", nan, peaks[1] / peaks[0], 0.0, 1.0, "", "less, as expected there"
        ),
    )
    return Property(
        "yielding_contact",
        "Relative displacement of a frame and a masonry building, with and without yielding of the contact",
        "Khatiwada et al. (2011)",
        "Khatiwada, S., Chouw, N. and Butterworth, J. W. (2011), Development of pounding model for adjacent "
        "structures in earthquakes, Proceedings of the Ninth Pacific Conference on Earthquake Engineering, Auckland",
        "",
        "read",
        "read; its yield force and damping are not published, so that the property is that such ones exist",
        "identical until 2.4 s, where the contact yields; then the largest relative displacement is less",
        readings,
        f"Identical until {first:.2f} s; then the peak is {peaks[1] * 1e3:.1f} mm with yielding, {peaks[0] * 1e3:.1f} "
        "mm without",
        "El Centro 1940 at 0.5 g; F_E = 450 kN and damping 5 % assumed".replace("F_E", "$F_E$"),
        (Panel((TIME, "relative displacement [mm]"), drawn),),
    )
