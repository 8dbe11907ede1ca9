"""Hard cases of a law's limits: restitution to 1 and to nothing, yield force to nothing and to infinity, stiffness."""

from __future__ import annotations

from math import inf, sqrt

import numpy as np

from pounding_risk.lab.stability.case import BITS, CAPPED, ENERGY, FORCES, LEDGER, PATH, POTENTIAL, Bound, Group
from pounding_risk.lab.stability.trial import NO_PULL, SOFT, STIFF, WALL, Trial, TrialScene, largest_difference, shaking
from pounding_risk.models.restitution import CONCRETE, Restitution
from pounding_risk.models.structures.sdof import Building

GROUP = Group("limits of a law")

CONTACT = Bound(1e-11, 1.0, "one contact at the tolerance; rounding")
CLOSED_FORM = Bound(1e-10, 1.0, "ten digits are given; one contact at the tolerance")
OF_CONCRETE = Bound(1e-11, 1.0, "e depends on ξ alone; one contact at the tolerance")
GHOSTS = Bound(1e-11, 10.0, "the free motion, integrated while in contact; as for the energy")
LOW_YIELD = Bound(1e-5, 1.0, "the loss falls as the yield force to the power 1.8: 0.009 at a tenth")
STIFF_LIMIT = Bound(0.01, 1.0, "the contact lasts 3e-3 of the period, in which the spring acts too")
TWO_CONTACTS = Bound(1e-11, 1.0, "two contacts at the tolerance; rounding")
NO_MASS = Bound(1e-11, 1.0, "e depends on no mass; two contacts at the tolerance")
CORNERS = Bound(1e-11, 30.0, "two contacts, whose corners the steps pass over; rounding")
GAINS_LITTLE = "gains at most 2 m/M v; e as against a wall"
ROUNDING = Bound(1e-12, 0.0, "rounding of some tens of steps; both masses are moved by the same force")
BLOCK, SPEED = TrialScene(hertz=2.75e9, linear=9.35e7), 0.5  # N/m^1.5, N/m, m/s: concrete cubes of 570 kg
MASS = 570.0

# What each law returns for a specified e = 0.01: its closed form, and for Jankowski's law, which has none, an
# independent integration at rtol 1e-12.
RETURNED = {
    "linear": 1.0,
    "kelvin_voigt": 0.01,
    "kelvin_voigt_tension_cut": 0.1728812380,
    "modified_kelvin_voigt": 0.0100497440,
    "hertz": 1.0,
    "hertz_damp": 0.6629851608,
    "hertz_damp_exact": 0.01,
    "jankowski": 0.0089519160,
    "bilinear": 0.605843397555,
    "van_mier": 1.0,
    "viscous_elastoplastic": 0.0089519160,
    "tabulated": 1.0,
}
KNOWN = tuple(name for name in FORCES if name in RETURNED)


@GROUP.case("10", "e = 1, two equal masses", "no speed is lost; velocities are exchanged", CONTACT, FORCES)
def full_restitution(trial: Trial) -> float:
    """e = 1: the speed lost, and by how much two equal masses fail to exchange theirs."""
    collision = trial.collide(BLOCK._replace(restitution=Restitution(1.0)), SPEED, MASS, MASS)
    return max(abs(1.0 - collision.restitution), abs(collision.impulse / (MASS * SPEED) - 1.0))


@GROUP.case("11", "e = 0.01, isolated impact", "the law's closed form of e", CLOSED_FORM, KNOWN)
def hardly_any_restitution(trial: Trial) -> float:
    """e = 0.01: the e returned, against the law's closed form."""
    collision = trial.collide(BLOCK._replace(restitution=Restitution(0.01)), SPEED, MASS)
    return abs(collision.restitution - RETURNED[trial.name])


@GROUP.case("24", "e = 0.01: dashpot of sixty times the critical", "F rises and falls once; no pull", BITS, FORCES)
def overdamped(trial: Trial) -> float:
    """e = 0.01, a dashpot of up to 60 times the critical: turns of the force beyond the three of a smooth history."""
    collision = trial.collide(BLOCK._replace(restitution=Restitution(0.01)), SPEED, MASS)
    # The Hertz-damp laws part with a force that is all but zero, to the tolerance of the rates.
    least = max(trial.rtol, NO_PULL) * collision.peak_force
    pulls = trial.name != "kelvin_voigt" and collision.force.min() < -least
    change = np.diff(collision.force)
    turns = np.count_nonzero(np.diff(np.sign(change[np.abs(change) > least])))
    return inf if pulls else max(0.0, turns - 3.0)


@GROUP.case("12a", "concrete at 5, 7.2 and 20 m/s", "e held at the end of its fit", OF_CONCRETE, FORCES)
def same_at_any_speed(trial: Trial) -> float:
    """Approaches of 5, 7.2 and 20 m/s on concrete: spread of the e returned, which is that of 5 m/s."""
    scene = BLOCK._replace(restitution=CONCRETE)
    returned = [trial.collide(scene, speed, MASS).restitution for speed in (5.0, 7.2, 20.0)]
    return float(np.ptp(returned))


@GROUP.case("12b", "a run past 7.1 m/s", ENERGY + ", e is held", LEDGER)
def faster_than_the_fit(trial: Trial) -> float:
    """A run with approaches past 7.1 m/s, where the published cubic is negative: energy; inf where none is held."""
    long, short = Building("long", 5e5, 3.0, 0.05), Building("short", 8e5, 0.5, 0.05)
    outputs = trial.solve(TrialScene(long, short, gap=0.3, restitution=CONCRETE, ground=shaking(60.0, duration=10.0)))
    is_fast = outputs["peak_approach_speed"] > 7.2 and outputs["restitution_held"] > 0.0
    return trial.unsound(outputs) if is_fast else inf


@GROUP.case("14", "F_E = 1e-9 N", "the motion without contact", GHOSTS, CAPPED)
def no_yield_force(trial: Trial) -> float:
    """F_E = 1e-9 N, the contact of two ghosts: difference from the motion without contact."""
    free = trial.solve(TrialScene(gap=inf))
    outputs = trial.solve(TrialScene(yield_force=1e-9))
    if outputs["impact_count"] < 1.0:
        return inf
    names = ("peak_closing", "peak_opening", "peak_displacement_left", "peak_displacement_right")
    return largest_difference(outputs, free, only=names)


@GROUP.case("15", "F_E = a thousandth of the peak force", "rebounds all but elastically", LOW_YIELD, CAPPED)
def low_yield_force(trial: Trial) -> float:
    """F_E = a thousandth of the uncapped peak: how far the rebound is from elastic, which it nears from below."""
    peak = trial.collide(BLOCK, SPEED, MASS).peak_force
    collision = trial.collide(BLOCK._replace(yield_force=1e-3 * peak), SPEED, MASS)
    return abs(1.0 - collision.restitution) if collision.peak_force == 1e-3 * peak else inf


@GROUP.case("16", "F_E above the largest force", "the law without a cap", BITS, CAPPED)
def high_yield_force(trial: Trial) -> float:
    """F_E infinite and a rounding above the largest force: any difference from the law without a cap."""
    scene = TrialScene(gap=0.005)
    bare = Trial("hertz" if trial.name == "van_mier" else "jankowski", trial.rtol)
    uncapped = bare.solve(scene)
    runs = trial.solve(scene), trial.solve(scene._replace(yield_force=uncapped["peak_contact_force"] * (1.0 + 1e-12)))
    return max(largest_difference(outputs, uncapped, but=("yield_demand",)) for outputs in runs)


@GROUP.case("17", "F_E just below the largest force, and far", "the largest force is F_E", BITS, CAPPED)
def yield_force_just_reached(trial: Trial) -> float:
    """F_E from just below the largest force down: the largest force is F_E, to the bit, up to that of no cap."""
    scene = TrialScene(gap=0.005)
    peak = trial.solve(scene)["peak_contact_force"]
    strengths = [share * peak for share in (1.0 - 1e-9, 0.999, 0.5, 0.05, 2.0)]
    capped = [trial.solve(scene._replace(yield_force=strength))["peak_contact_force"] for strength in strengths]
    return max(abs(force / min(strength, peak) - 1.0) for force, strength in zip(capped, strengths, strict=True))


@GROUP.case("23", "one impact on a wall, β = 1e13, k = 1e12", "the stereomechanical rebound", STIFF_LIMIT, FORCES)
def stiff_limit(trial: Trial) -> float:
    """An undamped oscillator hits a wall once: its next swing, against the stereomechanical one.

    The ground is still by then, so that the swing after the rebound is sqrt(gap² + (e v/ω)²), v the speed of the
    touch and e what the law returns.
    """
    swinging = Building("swinging", 2e5, 1.0, 0.0)
    ground = np.zeros(81)
    ground[1:10] = -3.0
    scene = TrialScene(swinging, WALL, gap=0.03, hertz=1e13, linear=1e12, ground=ground)
    contacts = trial.follow(scene).contacts
    if len(contacts) != 1:
        return inf
    speed = float(contacts[0, 2])
    e = trial.collide(scene, speed, swinging.mass).restitution
    omega = 2.0 * np.pi / swinging.period
    return abs(trial.solve(scene)["peak_opening"] / sqrt(scene.gap**2 + (e * speed / omega) ** 2) - 1.0)


@GROUP.case("22b", "free impact, β up to 1e13", "peak force ~ β^(2/5), k^(1/2)", TWO_CONTACTS, POTENTIAL)
@GROUP.case("22c", "free impact, β up to 1e13, a law with corners", "peak force ~ β^(2/5)", CORNERS, PATH)
def force_of_stiffness(trial: Trial) -> float:
    """β and 1024 β, up to 1e13: the peak force of a free impact grows by 1024^(2/5) = 16, of a linear law by 32."""
    power = 32.0 if trial.is_linear else 16.0
    soft = TrialScene(hertz=1e13 / 1024.0, linear=1e13 / 1024.0)
    soft_impact = trial.collide(soft, SPEED, STIFF.mass, SOFT.mass)
    stiff_impact = trial.collide(soft._replace(hertz=1e13, linear=1e13), SPEED, STIFF.mass, SOFT.mass)
    return abs(stiff_impact.peak_force / soft_impact.peak_force / power - 1.0)


@GROUP.case("19a", "two free masses, 1 : 1e6", "momentum", ROUNDING, ratio=1e6)
@GROUP.case("19b", "two free masses, 1e6 : 1", "momentum", ROUNDING, ratio=1e-6)
def momentum(trial: Trial, ratio: float) -> float:
    """Momentum that two free masses lose in an impact, over what the striker brought."""
    collision = trial.collide(BLOCK, SPEED, 1e4, 1e4 * ratio)
    return abs(collision.momentum_change * collision.impulse) / (1e4 * SPEED)


@GROUP.case("19c", "a mass struck by a millionth of it", GAINS_LITTLE, NO_MASS, FORCES)
def heavy_side_hardly_moves(trial: Trial) -> float:
    """A mass struck by a millionth of it: its speed beyond 2 m_light/m_heavy v, and e against that on a wall."""
    light, heavy = 1e3, 1e9
    collision = trial.collide(BLOCK, SPEED, light, heavy)
    gained = collision.impulse / heavy
    beyond = max(0.0, gained / (2.0 * light / heavy * SPEED) - 1.0)
    return max(beyond, abs(collision.restitution - trial.collide(BLOCK, SPEED, light).restitution))
