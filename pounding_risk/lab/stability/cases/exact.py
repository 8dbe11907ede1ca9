"""Hard cases that hold to the last bit: symmetries, scaling by powers of two, and what is known without a run."""

from __future__ import annotations

import re
from math import inf
from typing import Any

import numpy as np

from pounding_risk.lab.stability.case import ALL, BITS, HERTZ, LINEAR, ONE, POTENTIAL, Bound, Group
from pounding_risk.lab.stability.trial import SOFT, STIFF, Ground, Trial, TrialScene, largest_difference, shaking
from pounding_risk.solver.counters import STEPS
from pounding_risk.solver.pair.api import free_response, oscillators
from pounding_risk.solver.pair.flight import Free
from pounding_risk.solver.pair.grid import solve_grid
from pounding_risk.solver.pair.outputs import COLUMNS
from pounding_risk.solver.workspace import make_workspace

GROUP = Group("exact")

UNCHANGED = ("count", "status", "steps", "residual", "held", "demand", "exceedance")
YIELDING = 1.5e6  # N
USUAL = TrialScene(gap=0.005, yield_force=YIELDING)
PEAKS = ("peak_closing", "peak_opening", "peak_contact_force", "peak_penetration", "impact_count")


@GROUP.case("31", "seen from behind: −a_g, left for right", "the same run", BITS)
def mirror(trial: Trial) -> float:
    """The pair seen from behind: buildings swapped, the ground reversed."""
    return largest_difference(trial.solve(USUAL), swapped(trial.solve(from_behind(USUAL))))


def from_behind(scene: TrialScene) -> TrialScene:
    """A pair seen from behind."""
    return scene._replace(left=scene.right, right=scene.left, ground=-scene.ground)


def swapped(outputs: dict[str, float]) -> dict[str, float]:
    """Outputs with those of the left building under the names of the right one, and the reverse."""
    opposite = {"left": "right", "right": "left"}
    return {re.sub("(left|right)$", lambda side: opposite[side[0]], name): output for name, output in outputs.items()}


def scaled(outputs: dict[str, float], factors: dict[str, float]) -> dict[str, float]:
    """Outputs times the factor of the first key that stands in their name; what only counts stays as it is."""
    scaled_outputs = {}
    for name, output in outputs.items():
        factor = next((size for word, size in factors.items() if word in name), 1.0)
        scaled_outputs[name] = output if name.endswith(UNCHANGED) else factor * output
    return scaled_outputs


def factors(*, length: float = 1.0, time: float = 1.0, force: float = 1.0) -> dict[str, float]:
    """Factors of all outputs, by a part of their names; the first that fits counts."""
    return {
        "acceleration": length / time**2,
        "speed": length / time,
        "_time": time,
        "impulse": force * time,
        "energy": force * length,
        "force": force,
        "shear": force,
        "displacement": length,
        "penetration": length,
        "peak_closing": length,
        "peak_opening": length,
    }


def similar(trial: Trial, one: TrialScene, other: TrialScene, only: tuple[str, ...] = (), **sizes: float) -> float:
    """Largest difference of the outputs of one scene, times the factors of these sizes, from those of the other."""
    return largest_difference(scaled(trial.solve(one), factors(**sizes)), trial.solve(other), only=only)


def heavier(scene: TrialScene, factor: float) -> TrialScene:
    """m, k, β and F_E times a power of two: the same motion, forces times it."""
    left, right = (building._replace(mass=factor * building.mass) for building in scene[:2])
    stiff = scene._replace(hertz=factor * scene.hertz, linear=factor * scene.linear)
    return stiff._replace(left=left, right=right, yield_force=factor * scene.yield_force)


def larger(scene: TrialScene, power: int) -> TrialScene:
    """a_g, gap and F_E times 16 to a power, β over 4 to it (16^1.5 = 64), k as it is: displacements times the first.

    And not times 4: the fourth root of a penetration, in Jankowski's dashpot, then doubles.
    """
    factor = 16.0**power
    scaled_scene = scene._replace(gap=factor * scene.gap, ground=factor * scene.ground)
    return scaled_scene._replace(hertz=scene.hertz / 4.0**power, yield_force=factor * scene.yield_force)


# Periods and dt times 16; a_g, k, β and F_E divided by 256.
LEFT, RIGHT = (building._replace(period=16.0 * building.period) for building in (SOFT, STIFF))
SOFTER = USUAL._replace(hertz=USUAL.hertz / 256.0, linear=USUAL.linear / 256.0, yield_force=YIELDING / 256.0)
SLOWER = SOFTER._replace(left=LEFT, right=RIGHT, ground=USUAL.ground / 256.0, dt=16.0 * USUAL.dt)
HEAVY, HUGE = ({"one": USUAL, "other": heavier(USUAL, factor), "force": factor} for factor in (4.0, 2.0**200))
SLOWED: dict[str, Any] = {"one": USUAL, "other": SLOWER, "time": 16.0, "force": 1.0 / 256.0}
CLOCK = Bound(1e-11, 1e-3, "the clock of a contact rounds with the time since the record began; so do the steps")
# The error control of laws in δ^1.5 takes its scale of depth from a search good to a tenth: peaks alone.
OF_HERTZ = Bound(
    1e-11, 10.0, "the steps differ: their scale of depth is a search good to a tenth, corners are stepped over"
)
for number, words, invariant, bound, laws, arguments in (
    ("41a", "masses, stiffnesses, F_E × 4", "same motion, forces × 4", BITS, ALL, HEAVY),
    ("41b", "the same × 2^200", "same motion, forces × it", BITS, ALL, HUGE),
    (
        *("41c", "a_g, gap, F_E × 16, β / 4", "displacements × 16", BITS, POTENTIAL),
        {"one": USUAL, "other": larger(USUAL, 1), "length": 16.0, "force": 16.0},
    ),
    ("41d", "time × 16, k and F_E / 256", "the same displacements", BITS, LINEAR, SLOWED),
    (
        *("41e", "time × 16, β and F_E / 256", "the same peaks", OF_HERTZ, HERTZ),
        {**SLOWED, "only": (*PEAKS, "contact_time")},
    ),
    ("43", "gap = inf", "a gap of 10 m", BITS, ALL, {"one": TrialScene(gap=inf), "other": TrialScene(gap=10.0)}),
    ("48", "the same run twice", "the same run", BITS, ALL, {"one": TrialScene(), "other": TrialScene()}),
):
    GROUP.case(number, words, invariant, bound, laws, **arguments)(similar)


@GROUP.case("37c", "a_g × 2^40, × 2^−40, no contact", "displacements × it", BITS)
def free_motion_scales(trial: Trial) -> float:
    """a_g times 2^40 and 2^−40 without contact: every displacement times it."""
    scene = TrialScene(gap=inf)
    scenes = {factor: scene._replace(ground=factor * scene.ground) for factor in (2.0**40, 2.0**-40)}
    return max(similar(trial, scene, other, length=factor, force=factor) for factor, other in scenes.items())


@GROUP.case("38a", "48 zeros before the record, no contact", "the same motion, later", BITS, ONE)
def quiet_before(trial: Trial) -> float:
    """48 zeros before a record that starts at zero: the free motion is that of the record, later."""
    pair, ground = oscillators(SOFT, STIFF), shaking(4.0)
    one = free_response(pair, ground, 0.01).states
    later = free_response(pair, np.append(np.zeros(48), ground), 0.01).states
    return float(np.abs(later[48:] - one).max() + np.abs(later[:48]).max())


@GROUP.case("38b", "48 zeros before the record", "the same peaks", CLOCK)
def quiet_before_contact(trial: Trial) -> float:
    """The same with contact, whose clock rounds otherwise at another time: difference of the peaks."""
    return similar(trial, USUAL, USUAL._replace(ground=np.append(np.zeros(48), USUAL.ground)), PEAKS)


@GROUP.case("45", "7 gaps × 4 yield forces, screened", "every case run by itself", BITS)
def pruned(trial: Trial) -> float:
    """Seven gaps and four yield forces with screening and without: columns that differ; inf where nothing was saved."""
    free = free_response(oscillators(SOFT, STIFF), shaking(4.0), 0.01)
    closing = float(free.high[:, 0].max())
    gaps = np.append(np.linspace(0.0, 0.9 * closing, 5), [closing, 2.0 * closing])
    forces = np.array([1e5, 1.5e6, 1e9, inf])
    (screened, few), (whole, many) = (grid_of(trial, TrialScene(), free, gaps, forces, one) for one in (True, False))
    is_same = (screened == whole) | (np.isnan(screened) & np.isnan(whole))
    return inf if few >= many else float(np.count_nonzero(~is_same))


def grid_of(
    trial: Trial, scene: TrialScene, free: Free, gaps: Ground, forces: Ground, screening: bool
) -> tuple[Ground, int]:
    """Every column but that of the steps of a pair's grid, and how many of its cases were simulated."""
    out = np.zeros((len(gaps), len(forces), COLUMNS))
    simulated = np.zeros(out.shape[:2], dtype=np.int8)
    pair, grid = oscillators(scene.left, scene.right), (gaps, forces, scene.restitution)
    solve_grid(pair, free, trial.law(scene), grid, trial.rtol, screening, make_workspace(), out, simulated)
    trial.steps += int(out[..., STEPS].sum())
    return np.delete(out, STEPS, axis=-1), int(simulated.sum())
