"""Hard cases that hold to the last bit: symmetries, scaling by powers of two, and what is known without a run."""

from __future__ import annotations

from math import inf

import numpy as np

from pounding_risk.lab.stability.case import BITS, HERTZ, LINEAR, ONE, POTENTIAL, Bound, Group
from pounding_risk.lab.stability.trial import SOFT, STIFF, Trial, TrialScene, largest_difference, shaking
from pounding_risk.solver.counters import STEPS
from pounding_risk.solver.pair.api import free_response, oscillators
from pounding_risk.solver.pair.grid import solve_grid
from pounding_risk.solver.pair.outputs import COLUMNS
from pounding_risk.solver.workspace import make_workspace

GROUP = Group("exact")

UNCHANGED = ("count", "status", "steps", "residual", "held", "demand", "exceedance")
YIELDING = 1.5e6  # N


@GROUP.case("31", "seen from behind: −a_g, left for right", "the same run", BITS)
def mirror(trial: Trial) -> float:
    """The pair seen from behind: buildings swapped, the ground reversed."""
    scene = TrialScene(gap=0.005, yield_force=YIELDING)
    one = trial.solve(scene)
    other = trial.solve(scene._replace(left=STIFF, right=SOFT, ground=-scene.ground))
    swapped = {"left": "right", "right": "left"}
    back = {}
    for name, value in other.items():
        stem, _, side = name.rpartition("_")
        back[f"{stem}_{swapped[side]}" if side in swapped else name] = value
    return largest_difference(one, back)


def scaled(outputs: dict[str, float], factors: dict[str, float]) -> dict[str, float]:
    """Outputs times the factor of the first key that stands in their name; what only counts stays as it is."""
    wanted = {}
    for name, value in outputs.items():
        factor = next((size for part, size in factors.items() if part in name), 1.0)
        wanted[name] = value if name.endswith(UNCHANGED) else factor * value
    return wanted


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


@GROUP.case("41a", "masses, stiffnesses, F_E × 4", "same motion, forces × 4", BITS, factor=4.0)
@GROUP.case("41b", "the same × 2^200", "same motion, forces × it", BITS, factor=2.0**200)
def masses(trial: Trial, factor: float) -> float:
    """m, k, β and F_E times a power of two: the same motion, forces times it."""
    scene = TrialScene(gap=0.005, yield_force=YIELDING)
    heavy = TrialScene(
        SOFT._replace(mass=factor * SOFT.mass),
        STIFF._replace(mass=factor * STIFF.mass),
        scene.gap,
        factor * scene.hertz,
        factor * scene.linear,
        yield_force=factor * YIELDING,
    )
    return largest_difference(scaled(trial.solve(scene), factors(force=factor)), trial.solve(heavy))


@GROUP.case("41c", "a_g, gap, F_E × 16, β / 4", "displacements × 16", BITS, POTENTIAL)
def amplitude(trial: Trial) -> float:
    """a_g, gap and F_E times 16, β a quarter (16^1.5 = 64), k as it is: displacements times 16.

    16 and not 4: the fourth root of a penetration, in Jankowski's dashpot, then doubles.
    """
    scene = TrialScene(gap=0.005, yield_force=YIELDING)
    more = scene._replace(
        gap=16.0 * scene.gap,
        hertz=0.25 * scene.hertz,
        yield_force=16.0 * YIELDING,
        ground=16.0 * scene.ground,
    )
    return largest_difference(scaled(trial.solve(scene), factors(length=16.0, force=16.0)), trial.solve(more))


def slowed(trial: Trial) -> tuple[dict[str, float], dict[str, float]]:
    """Time times 16: periods and dt; a_g, k, β and F_E divided by 256. What must come out, and what does."""
    scene = TrialScene(gap=0.005, yield_force=YIELDING)
    slow = TrialScene(
        SOFT._replace(period=16.0 * SOFT.period),
        STIFF._replace(period=16.0 * STIFF.period),
        scene.gap,
        scene.hertz / 256.0,
        scene.linear / 256.0,
        yield_force=YIELDING / 256.0,
        ground=scene.ground / 256.0,
        dt=16.0 * scene.dt,
    )
    return scaled(trial.solve(scene), factors(time=16.0, force=1.0 / 256.0)), trial.solve(slow)


@GROUP.case("41d", "time × 16, k and F_E / 256", "the same displacements", BITS, LINEAR)
def slow_motion(trial: Trial) -> float:
    """Slowed 16 times: the largest difference of any output."""
    return largest_difference(*slowed(trial))


@GROUP.case(
    "41e",
    "time × 16, β and F_E / 256",
    "the same peaks",
    Bound(1e-11, 10.0, "the steps differ: their scale of depth is a search good to a tenth, corners are stepped over"),
    HERTZ,
)
def slow_motion_of_hertz(trial: Trial) -> float:
    """The same for laws in δ^1.5, whose error control takes its scale of depth from a search good to a tenth: peaks."""
    wanted, outputs = slowed(trial)
    peaks = ("peak_closing", "peak_opening", "peak_contact_force", "peak_penetration", "impact_count", "contact_time")
    return largest_difference(outputs, wanted, only=peaks)


@GROUP.case("37c", "a_g × 2^40, × 2^−40, no contact", "displacements × it", BITS)
def free_motion_scales(trial: Trial) -> float:
    """a_g times 2^40 and 2^−40 without contact: every displacement times it."""
    scene = TrialScene(gap=inf)
    one = trial.solve(scene)
    worst = 0.0
    for factor in (2.0**40, 2.0**-40):
        more = trial.solve(scene._replace(ground=factor * scene.ground))
        worst = max(worst, largest_difference(scaled(one, factors(length=factor, force=factor)), more))
    return worst


@GROUP.case("38a", "48 zeros before the record, no contact", "the same motion, later", BITS, ONE)
def quiet_before(trial: Trial) -> float:
    """48 zeros before a record that starts at zero: the free motion is that of the record, later."""
    pair, ground = oscillators(SOFT, STIFF), shaking(4.0)
    one = free_response(pair, ground, 0.01).states
    later = free_response(pair, np.append(np.zeros(48), ground), 0.01).states
    return float(np.abs(later[48:] - one).max() + np.abs(later[:48]).max())


@GROUP.case(
    "38b",
    "48 zeros before the record",
    "the same peaks",
    Bound(1e-11, 1e-3, "the clock of a contact rounds with the time since the record began; so do the steps"),
)
def quiet_before_contact(trial: Trial) -> float:
    """The same with contact, whose clock rounds otherwise at another time: difference of the peaks."""
    scene = TrialScene(gap=0.005, yield_force=YIELDING)
    one = trial.solve(scene)
    later = trial.solve(scene._replace(ground=np.append(np.zeros(48), scene.ground)))
    peaks = ("peak_closing", "peak_opening", "peak_contact_force", "peak_penetration", "impact_count")
    return largest_difference(one, later, only=peaks)


@GROUP.case("43", "gap = inf", "a gap of 10 m", BITS)
def infinite_gap(trial: Trial) -> float:
    """gap = inf, and a gap that the free motion does not close: any difference."""
    return largest_difference(trial.solve(TrialScene(gap=inf)), trial.solve(TrialScene(gap=10.0)))


@GROUP.case("48", "the same run twice", "the same run", BITS)
def same_again(trial: Trial) -> float:
    """Largest difference of two runs of one case."""
    return largest_difference(trial.solve(TrialScene()), trial.solve(TrialScene()))


@GROUP.case("45", "7 gaps × 4 yield forces, screened", "every case run by itself", BITS)
def pruned(trial: Trial) -> float:
    """Seven gaps and four yield forces with screening and without: columns that differ; inf where nothing was saved."""
    pair = oscillators(SOFT, STIFF)
    free = free_response(pair, shaking(4.0), 0.01)
    closing = float(free.high[:, 0].max())
    gaps = np.append(np.linspace(0.0, 0.9 * closing, 5), [closing, 2.0 * closing])
    forces = np.array([1e5, 1.5e6, 1e9, inf])
    answers, runs = [], []
    for screening in (True, False):
        out = np.zeros((len(gaps), len(forces), COLUMNS))
        how = np.zeros((len(gaps), len(forces)), dtype=np.int8)
        grid = (gaps, forces, TrialScene().restitution)
        solve_grid(pair, free, trial.law(TrialScene()), grid, trial.rtol, screening, make_workspace(), out, how)
        trial.steps += int(out[..., STEPS].sum())
        answers.append(np.delete(out, STEPS, axis=-1))
        runs.append(int(how.sum()))
    same = (answers[0] == answers[1]) | (np.isnan(answers[0]) & np.isnan(answers[1]))
    return inf if runs[0] >= runs[1] else float(np.count_nonzero(~same))
