"""Hard cases of closed gaps and of contacts that come to rest."""

from __future__ import annotations

from math import inf, isnan
from typing import NamedTuple

import numpy as np

from pounding_risk.lab.stability.case import BITS, CAPPED, DAMPED, LEDGER, PATH, POTENTIAL, Bound, Group
from pounding_risk.lab.stability.trial import SOFT, STIFF, Trial, TrialScene, push, shaking
from pounding_risk.models.restitution import Restitution
from pounding_risk.models.structures.sdof import Building

GROUP = Group("rest")
GROUP.energy("3", "no gap, different buildings, shaken", TrialScene())
LIGHT = Building("light", 7.8e3, 1.8, 0.058)  # leans on the heavy one throughout
HEAVY = SOFT._replace(period=1.4)
GROUP.energy("46", "a light building leans on a heavy one, shaken", TrialScene(HEAVY, LIGHT, ground=shaking(6.0)))

RESTING = Bound(1e-12, 0.0, "rounding: what it vibrated has died away, whatever the tolerance")
SHRUNK = Bound(1e-9, 1.0, "the vibration falls by 1e-11 in the 20 s; at rest each step renews its error")
ON_PLATEAU = "F = F_E throughout; energy closes"
IN_BALANCE = "rests in balance, with a force of its loop"
STATIC = "comes to rest on the static solution"
# Damped well, so that a building that is let alone is at rest within seconds.
LEANING, PROP = SOFT._replace(damping=0.3), STIFF._replace(damping=0.3)
LEVEL = -3.0  # m/s²: pushes the softer building, on the left, towards the other
GENTLE = -0.02  # m/s²


@GROUP.case("1", "no gap, at rest, still ground", "every output is 0", BITS, gap=0.0)
@GROUP.case("36", "a gap, at rest, still ground", "every output is 0", BITS, gap=0.02)
def still_ground(trial: Trial, gap: float) -> float:
    """Largest output of a pair at rest that stays at rest; the energy residual is 0/0 there and must be 0."""
    outputs = trial.solve(TrialScene(gap=gap, ground=np.zeros(200)))
    return max(abs(output) for output in outputs.values() if not isnan(output))


@GROUP.case("2", "no gap, two equal buildings, shaken", "no relative motion, no contact", BITS)
def twins(trial: Trial) -> float:
    """Relative displacement and count of two equal buildings without a gap."""
    outputs = trial.solve(TrialScene(right=SOFT))
    return max(outputs["peak_relative_displacement"], outputs["impact_count"])


class Static(NamedTuple):
    """Where two buildings come to rest that a steady ground acceleration presses together."""

    force: float
    penetration: float


def static_solution(trial: Trial, scene: TrialScene, level: float) -> Static:
    """F and δ with k1 u1 + F = −m1 a, k2 u2 − F = −m2 a, δ = u1 − u2 − gap, F the law's force at rest."""
    from scipy.optimize import brentq

    law, (left, right) = trial.law(scene), (scene.left, scene.right)
    ceiling = law.ceiling(scene.yield_force)
    memory = law.begin(scene.restitution.at(0.0), 0.0, 1.0 / (1.0 / left.mass + 1.0 / right.mass))
    give = 1.0 / left.stiffness + 1.0 / right.stiffness
    overlap = -level * (left.mass / left.stiffness - right.mass / right.stiffness) - scene.gap

    def force(delta: float) -> float:
        free = float(law.force(memory, delta, 0.0, False))
        return free if free < ceiling else float(law.plateau(delta, ceiling))

    delta = brentq(lambda depth: depth + give * force(depth) - overlap, 0.0, overlap, xtol=1e-300, rtol=1e-14)
    return Static(force(delta), delta)


def unrest(trial: Trial, scene: TrialScene) -> float:
    """How far the end of a long push lies from the static solution, in force and in penetration."""
    steps = trial.follow(scene).steps
    resting = static_solution(trial, scene, float(scene.ground[-1]))
    end = len(scene.ground) * scene.dt
    if not len(steps) or steps[-1, 0] < end - 2.0 * scene.dt:
        return inf  # no longer in contact
    depth = steps[-1, 1] - steps[-1, 2] - scene.gap
    return max(abs(steps[-1, 5] / resting.force - 1.0), abs(depth / resting.penetration - 1.0))


@GROUP.case("5", "pressed together by a lasting push", STATIC, RESTING, POTENTIAL)
def resting(trial: Trial) -> float:
    """A push that rises over 1 s and stays for 30 s, from a closed gap.

    A gentle one: the touch is from rest, where the Hertz-damp laws have a damper that lets the buildings creep to
    their place in a time that grows with the force (100 s at 3 m/s²).
    """
    return unrest(trial, TrialScene(LEANING, PROP, ground=push(GENTLE, 1.0, 30.0)))


@GROUP.case("5b", "pressed together by a lasting push, a law with a path", IN_BALANCE, RESTING, PATH)
def resting_in_balance(trial: Trial) -> float:
    """The same for a law whose force at rest depends on its path: forces out of balance, over the contact's.

    k1 u1 + F = −m1 a and k2 u2 − F = −m2 a; infinite where F is not between the ends of the law's loop at this δ.
    """
    scene = TrialScene(LEANING, PROP, ground=push(LEVEL, 1.0, 60.0))
    last = trial.follow(scene).steps[-1]
    left, right, force = last[1], last[2], last[5]
    delta, law = left - right - scene.gap, trial.law(scene)
    memory = law.begin(scene.restitution.at(0.0), 0.0, 1.0 / (1.0 / LEANING.mass + 1.0 / PROP.mass))
    upper = law.force(memory, delta, 0.0, True)
    # The lower line ends what a turn at twice this penetration unloads to.
    lower = law.force(law.turned(memory, 2.0 * delta, True), delta, 0.0, False)
    if not lower * (1.0 - 1e-9) <= force <= upper * (1.0 + 1e-9):
        return inf
    missed_left = LEANING.stiffness * left + force + LEANING.mass * LEVEL
    missed_right = PROP.stiffness * right - force + PROP.mass * LEVEL
    return max(abs(missed_left), abs(missed_right)) / force


def bouncing(hold: float, dt: float = 0.02) -> TrialScene:
    """A sudden push over a gap that leaves 1.7 mm of it, e = 0.9: a bounce, smaller ones after it, rest."""
    pair, ground = (SOFT._replace(damping=0.1), STIFF._replace(damping=0.1)), push(LEVEL, 0.1, hold, dt)
    return TrialScene(*pair, gap=0.01, hertz=1e11, linear=1e10, restitution=Restitution(0.9), ground=ground, dt=dt)


@GROUP.case("26", "bounces that shrink, e = 0.9, under a push", STATIC, SHRUNK, POTENTIAL)
def chattering(trial: Trial) -> float:
    """Bounces that shrink to rest within 20 s; infinite where there were fewer than five."""
    scene = bouncing(20.0)
    bounces = len(trial.follow(scene).contacts)
    trial.solve(scene)
    return unrest(trial, scene) if bounces >= 5 else inf


@GROUP.case("6", "a push that needs three times F_E", "rests with F = F_E on the static solution", RESTING, CAPPED)
def pushed_past_yielding(trial: Trial) -> float:
    """A push that needs three times F_E to be held: F = F_E, and the structures carry the rest."""
    scene = TrialScene(LEANING, PROP, ground=push(LEVEL, 1.0, 30.0))
    return unrest(trial, scene._replace(yield_force=static_solution(trial, scene, LEVEL).force / 3.0))


@GROUP.case("18", "shaken on the plateau, approach and retreat in turn", ON_PLATEAU, LEDGER, CAPPED)
def shaken_on_the_plateau(trial: Trial) -> float:
    """The same shaken, so that approach and retreat change within the plateau: energy; inf where F leaves F_E."""
    pushed = TrialScene(LEANING, PROP, ground=push(LEVEL, 1.0, 8.0))
    strength = static_solution(trial, pushed, LEVEL).force / 3.0
    ground = pushed.ground.copy()
    ground[300:801] += shaking(0.5)
    scene = pushed._replace(yield_force=strength, ground=ground)
    steps = trial.follow(scene).steps
    on_plateau = steps[(steps[:, 0] > 3.1) & (steps[:, 0] < 7.9)]
    turns = np.count_nonzero(np.diff(np.sign(on_plateau[:, 3] - on_plateau[:, 4])))
    if turns < 5 or np.any(on_plateau[:, 5] != strength):
        return inf
    outputs = trial.solve(scene)
    return inf if outputs["peak_contact_force"] != strength else trial.unsound(outputs)


@GROUP.case("7", "a push taken back slowly", "parts once", BITS)
def released(trial: Trial) -> float:
    """A push that rests, then is taken back over 4 s: partings after the rest, but for the one there must be."""
    scene = TrialScene(LEANING, PROP, ground=push(LEVEL, 1.0, 15.0, release=4.0))
    return float(abs(np.count_nonzero(trial.follow(scene).contacts[:, 1] > 12.0) - 1))


@GROUP.case("25", "pressed together, e = 0.05", "one contact, which does not end", BITS, DAMPED)
def never_parting(trial: Trial) -> float:
    """e = 0.05 and a push that stays: contacts that have not ended with the record, but for the one there must be."""
    scene = TrialScene(LEANING, PROP, restitution=Restitution(0.05), ground=push(LEVEL, 1.0, 10.0))
    contacts = trial.follow(scene).contacts
    trial.solve(scene)
    end = (len(scene.ground) - 1) * scene.dt
    return float(abs(np.count_nonzero(contacts[:, 1] >= end * (1.0 - 1e-9)) - 1))
