"""Hard cases of finding touches: grazing ones, several in one sample, and what a contact keeps of its touch."""

from __future__ import annotations

from itertools import pairwise
from math import inf

import numpy as np

from pounding_risk.lab.stability.case import BITS, FORCES, Bound, Group
from pounding_risk.lab.stability.cases.rest import bouncing
from pounding_risk.lab.stability.trial import SOFT, WALL, Trial, TrialScene, largest_difference
from pounding_risk.models.restitution import CONCRETE, Restitution
from pounding_risk.models.structures.sdof import Building

GROUP = Group("touches")

OVERLAP = 1e-6  # of the gap
BETWEEN = Bound(OVERLAP, 0.0, "the closing lies between the gap and that of the free motion")
AS_ENERGY = Bound(1e-11, 10.0, "as for the energy: two hundred steps, should all err alike")
FINER = "same count and peaks when sampled finer"
PEAKS = ("peak_closing", "peak_opening", "peak_contact_force", "peak_penetration")


@GROUP.case("8a", "gap = closing of the free motion × (1 + 1e-12)", "no contact; the free motion", BITS)
def just_not_touching(trial: Trial) -> float:
    """The gap is the closing of the free motion and a rounding: any difference from the run without contact."""
    free = trial.solve(TrialScene(gap=inf))
    return largest_difference(trial.solve(TrialScene(gap=free["peak_closing"] * (1.0 + 1e-12))), free)


@GROUP.case("8b", "gap = closing of the free motion × (1 − 1e-6)", "one contact; the same closing", BETWEEN, FORCES)
def just_touching(trial: Trial) -> float:
    """The gap is a millionth less: one touch, and by how much the largest closing differs from the free one."""
    free = trial.solve(TrialScene(gap=inf))
    outputs = trial.solve(TrialScene(gap=free["peak_closing"] * (1.0 - OVERLAP)))
    if outputs["impact_count"] != 1.0:
        return inf
    return abs(outputs["peak_closing"] / free["peak_closing"] - 1.0)


def finer(scene: TrialScene, parts: int) -> TrialScene:
    """The same a_g, with ``parts`` samples for each one; linear between samples, so the same motion."""
    count = (len(scene.ground) - 1) * parts + 1
    places = np.arange(count) / parts
    return scene._replace(ground=np.interp(places, np.arange(len(scene.ground)), scene.ground), dt=scene.dt / parts)


def resampled(trial: Trial, scene: TrialScene, parts: int) -> float:
    """Difference of two samplings of one motion; infinite where they count differently or never twice a sample."""
    starts = trial.follow(scene).contacts[:, 0]
    if not np.any(np.diff(starts) < scene.dt):
        return inf
    one, other = trial.solve(scene), trial.solve(finer(scene, parts))
    if one["impact_count"] != other["impact_count"]:
        return inf
    return largest_difference(one, other, only=(*PEAKS, "peak_displacement_left"))


@GROUP.case("9", "several contacts of a vibration within one sample", FINER, AS_ENERGY, FORCES)
def two_touches_in_one_sample(trial: Trial) -> float:
    """T = 0.1 s against a wall, kicked by one pulse of a record that has four samples a second."""
    quick, pulse = Building("quick", 2e5, 0.1, 0.02), np.zeros(10)
    pulse[1] = 3.0
    return resampled(trial, TrialScene(quick, WALL, hertz=2e10, linear=2e9, ground=pulse, dt=0.25), 16)


@GROUP.case("27", "several bounces within one sample", FINER, AS_ENERGY, FORCES)
def bounces_in_one_sample(trial: Trial) -> float:
    """Bounces under a sudden push, e = 0.9, in a record of ten samples a second."""
    return resampled(trial, bouncing(4.0, dt=0.1), 8)


@GROUP.case("13", "e(v) of concrete, record cut after one contact", "as with the e of its touch", BITS)
def restitution_is_that_of_the_touch(trial: Trial) -> float:
    """A record cut after the first contact: the run with e(v) differs from that with the e of its touch nowhere."""
    scene = TrialScene(gap=0.01, restitution=CONCRETE)
    contacts = trial.follow(scene).contacts
    if len(contacts) < 2:
        return inf
    # The cut lies at the end of a sample, past the first parting and short of the second touch.
    cut = int(np.ceil(contacts[0, 1] / scene.dt))
    if cut * scene.dt >= contacts[1, 0]:
        return inf
    first = scene._replace(ground=scene.ground[: cut + 1])
    frozen = Restitution(float(CONCRETE.at(contacts[0, 2])))
    return largest_difference(trial.solve(first), trial.solve(first._replace(restitution=frozen)))


@GROUP.case("47", "a record cut short", "the longer one takes no peak back", BITS)
def further_record(trial: Trial) -> float:
    """A record cut at two places: peaks and counts of the longer one that lie below those of the shorter one."""
    scene = TrialScene(SOFT, gap=0.005)
    runs = [trial.solve(scene._replace(ground=scene.ground[:count])) for count in (250, 350, 501)]
    names = (*PEAKS, "impact_count", "contact_time")
    missing = [max(0.0, one[name] - other[name]) for one, other in pairwise(runs) for name in names]
    touches = {outputs["first_impact_time"] for outputs in runs}
    return max(missing) if len(touches) == 1 else inf
