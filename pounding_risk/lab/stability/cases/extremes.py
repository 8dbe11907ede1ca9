"""Hard cases of extreme numbers: masses, periods, stiffness, amplitude, damping, and long records."""

from __future__ import annotations

from functools import lru_cache
from math import inf, isnan, pi, sqrt

import numpy as np

from pounding_risk.lab.stability.case import BITS, ENERGY, FORCES, LEDGER, ONE, Bound, Group
from pounding_risk.lab.stability.trial import SOFT, STIFF, WALL, Ground, Trial, TrialScene, largest_difference, shaking
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver.counters import NOT_FINITE, STATUS, STEPS
from pounding_risk.solver.pair.api import free_response, oscillators, run
from pounding_risk.solver.pair.flight import Free
from pounding_risk.solver.pair.outputs import run_outputs
from pounding_risk.units import STANDARD_GRAVITY

SHORT_PERIOD = Bound(1e-3, 10.0, "(0.005 s / 0.5 s)² = 1e-4, and contacts as long as its period")
OF_SINES = Bound(1e-11, 0.0, "rounding of a difference of sines")
OF_SAMPLES = Bound(1e-11, 0.0, "rounding of 3,000 samples")
CANCELLATION = Bound(1e-11, 0.0, "rounding, and cancellation by 1/sqrt(1 − ζ²) = 7")
CLOCK = Bound(1e-10, 1e-3, "the clock of an hour rounds to 5e-13 s, contacts last 1e-2 s; so do the steps")
SIXTYFOLD = "sixty times the counts, the same peaks"

GROUP = Group("extreme numbers")
GROUP.energy("19d", "1 t beside 1e6 t", TrialScene(SOFT._replace(mass=1e3), STIFF._replace(mass=1e9)))
GROUP.energy("19e", "1e6 t beside 1 t", TrialScene(SOFT._replace(mass=1e9), STIFF._replace(mass=1e3)))
LONG, SHORT = SOFT._replace(period=3.0), STIFF._replace(period=0.005)
GROUP.energy("20b", "T = 0.005 s beside 3 s", TrialScene(LONG, SHORT, hertz=1e11, linear=1e9))
GROUP.energy("22a", "β = 1e13, k = 1e11", TrialScene(hertz=1e13, linear=1e11), FORCES)
GROUP.energy("37a", "100 g", TrialScene(ground=shaking(100.0 * STANDARD_GRAVITY)))
GROUP.energy("37b", "1e-12 g", TrialScene(ground=shaking(1e-12 * STANDARD_GRAVITY)))  # relative speeds of 1e-12 m/s
UNDAMPED = SOFT._replace(damping=0.0), STIFF._replace(damping=0.0)
GROUP.energy("40b", "two undamped buildings, shaken", TrialScene(*UNDAMPED, gap=0.005))
GROUP.energy("42b", "ζ = 0.99, shaken", TrialScene(SOFT._replace(damping=0.99), STIFF._replace(damping=0.99)))


@GROUP.case("20a", "neighbour of T = 0.005 s, a thousand times the mass", "as a rigid one", SHORT_PERIOD, FORCES)
def nearly_rigid(trial: Trial) -> float:
    """A neighbour of T = 0.005 s and of a thousand times the mass, against one that moves with the ground."""
    peaks = ("peak_opening", "peak_closing", "peak_displacement_left", "peak_contact_force")
    scene = TrialScene(gap=0.01)
    rigid = trial.solve(scene._replace(right=WALL))
    stiff = trial.solve(scene._replace(right=Building("stiff", 1e3 * SOFT.mass, 0.005, 0.05)))
    return largest_difference(stiff, rigid, only=peaks)


@GROUP.case("21", "β = 1e6, k = 1e5: contacts longer than a period", ENERGY, LEDGER, FORCES)
def cushion(trial: Trial) -> float:
    """β = 1e6, k = 1e5: contacts that last longer than the stiffer building's period; energy."""
    outputs = trial.solve(TrialScene(right=STIFF._replace(period=0.1), hertz=1e6, linear=1e5))
    mean = outputs["contact_time"] / outputs["impact_count"]
    return trial.unsound(outputs) if mean > 0.1 else inf


@GROUP.case("32", "NaN in a_g", "a status says so, and no output is a number", BITS)
def not_finite(trial: Trial) -> float:
    """A NaN in a_g, at sample 250: outputs that are numbers all the same, and runs that say nothing of it."""
    ground = shaking(4.0).copy()
    ground[250] = np.nan
    outputs = trial.solve(TrialScene(ground=ground), NOT_FINITE)
    reported = ("status", "steps")
    return float(sum(not isnan(output) and output != -1.0 for name, output in outputs.items() if name not in reported))


@GROUP.case("35", "a record of two samples", "closed form of the displacements", OF_SINES, ONE)
def two_samples(trial: Trial) -> float:
    """The shortest record: one ramp of 0.01 s from rest. u of each building against −∫∫ a_g, at T ≫ dt."""
    scene = TrialScene(*UNDAMPED, inf, ground=np.array([0.0, 6.0]))
    outputs = trial.solve(scene)
    worst = 0.0
    for side, building in (("left", scene.left), ("right", scene.right)):
        omega = 2.0 * pi / building.period
        exact = 600.0 * ramp_response(omega, 0.0, np.array([0.01]))[0]
        worst = max(worst, abs(outputs[f"peak_displacement_{side}"] / exact - 1.0))
    return worst


def ramp_response(omega: float, damping: float, time: Ground) -> Ground:
    """−u of an oscillator from rest under a_g = t: (t − 2ζ/ω)/ω² + e^(−ζωt) (2ζ/ω cos ω_d t + … sin ω_d t)/ω²."""
    wave = omega * sqrt(1.0 - damping * damping)
    fade = np.exp(-damping * omega * time)
    late = 2.0 * damping / omega
    # u(0) = u̇(0) = 0 fix both amplitudes of the free vibration.
    sine = (damping * omega * late - 1.0) / wave
    displacement = (time - late + fade * (late * np.cos(wave * time) + sine * np.sin(wave * time))) / omega**2
    return np.asarray(displacement)


def superposed(building: Building, ground: Ground, dt: float) -> Ground:
    """u at the samples as a sum of ramp responses, one for each change of the slope of a_g; no stepping."""
    slopes = np.diff(ground) / dt
    changes = np.concatenate([slopes[:1], np.diff(slopes)])
    time = dt * np.arange(len(ground), dtype=np.float64)
    response = ramp_response(2.0 * pi / building.period, building.damping, time)
    return np.asarray(-np.convolve(changes, response)[: len(ground)])


def free_motion(trial: Trial, building: Building, ground: Ground, dt: float) -> float:
    """The response without contact at the samples, against the sum of ramp responses."""
    free = free_response(oscillators(building, WALL), ground, dt)
    nodes = (len(free.ground) - 1) // (len(ground) - 1)
    exact = superposed(building, ground, dt)
    return float(np.abs(free.states[::nodes, 0] - exact).max() / np.abs(exact).max())


@GROUP.case("40", "no damping, 30 s of resonance", "superposed ramp responses", OF_SAMPLES, ONE)
def resonance(trial: Trial) -> float:
    """No damping, 30 s of a sine in the building's own period."""
    ground = np.sin(2.0 * pi * (np.arange(3001) * 0.01) / 0.5)
    return free_motion(trial, Building("undamped", 1e5, 0.5, 0.0), ground, 0.01)


@GROUP.case("42a", "ζ = 0.99, free motion", "superposed ramp responses", CANCELLATION, ONE)
def nearly_critical(trial: Trial) -> float:
    """Free motion with ζ = 0.99."""
    return free_motion(trial, Building("frame", 44.36e3, 0.208, 0.99), shaking(4.0), 0.01)


@lru_cache(maxsize=2)
def minutes(count: int) -> tuple[TrialScene, Free]:
    """So many minutes, each with 5 s of the same shaking at its start and then quiet, and their free response."""
    dt = 0.005
    minute = np.zeros(round(60.0 / dt))
    burst = shaking(4.0, dt)
    minute[: len(burst)] = burst
    scene = TrialScene(gap=0.005, ground=np.append(np.tile(minute, count), 0.0), dt=dt)
    return scene, free_response(oscillators(scene.left, scene.right), scene.ground, dt)


@GROUP.case("39", "one hour, 720,000 samples: sixty like minutes", SIXTYFOLD, CLOCK, FORCES)
def one_hour(trial: Trial) -> float:
    """720,000 samples: sixty minutes alike, against one of them. All counts sixtyfold, every peak the same.

    A minute's motion has fallen by 1e-15 when the next one shakes.
    """
    runs = []
    for count in (1, 60):
        scene, free = minutes(count)
        raw = run(oscillators(scene.left, scene.right), free, trial.interface(scene), trial.rtol)
        trial.steps += int(raw[STEPS])
        trial.status = trial.status or int(raw[STATUS])
        runs.append({name: float(output) for name, output in run_outputs(raw, scene.yield_force).items()})
    many = ("impact_count", "contact_time", "impulse")
    same = ("peak_closing", "peak_opening", "peak_contact_force", "peak_penetration", "peak_approach_speed")
    sixty = {name: 60.0 * runs[0][name] if name in many else runs[0][name] for name in (*many, *same)}
    return largest_difference(sixty, runs[1], only=(*many, *same))
