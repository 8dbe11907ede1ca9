"""Every contact model against its closed forms, limits and whole runs, and what each law says of itself.

A model that is added fails here until it has an entry in FACTS; a law of force that comes with the package is put to
every test by that entry alone. Each fact is a closed form (see closed_forms) or a sentence that says why there is none.
"""

import pathlib
from collections.abc import Callable
from math import inf, isnan, sqrt
from typing import Any, NamedTuple

import closed_forms as exact
import numpy as np
import pytest
from oracle_laws import exact_hertz_damp
from paths import Path, follow_pair
from scipy.integrate import quad

from pounding_risk.lab.stability.trial import SOFT, STIFF, WALL, largest_difference, shaking
from pounding_risk.models._discovery import classes_of, modules_in_order
from pounding_risk.models.contact import impulsive as instant
from pounding_risk.models.contact import laws as contact
from pounding_risk.models.contact.impulsive import CONTACT_MODELS, DistributedMass, Stereomechanical, is_instant
from pounding_risk.models.contact.law import complete, is_path_dependent
from pounding_risk.models.contact.laws import (
    EXACT,
    LAWS,
    Bilinear,
    Hertz,
    Jankowski,
    Linear,
    VanMier,
    stiffness_quantity,
)
from pounding_risk.models.restitution import CONCRETE, constant
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver.counters import COMPLETE
from pounding_risk.solver.pair.api import Interface, solve
from pounding_risk.solver.pair.isolated import Impact
from pounding_risk.solver.pair.law_verbs import ends_itself
from pounding_risk.studies.impact import impact

K, BETA, MASS, SPEED = 9.35e7, 2.75e9, 570.0, 0.5  # N/m, N/m^1.5, kg, m/s: concrete cubes
MODELS = tuple(CONTACT_MODELS)
ASKED = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.8, 0.9)
Peaks = tuple[float, float, float]
NO_E, NO_CAP, NO_STIFFNESS = "it is elastic as it is", "it has no yield force", "it has no stiffness that could grow"
JUMPS = "its velocities jump: no depth, no finite force"


class Facts(NamedTuple):
    """What one contact model must return, alone; a sentence stands where a model has no such thing."""

    law: Any  # the model, of MASS at SPEED
    restitution: Callable[[float], float]  # e achieved against a wall from the e asked for, by the published relation
    peaks: Callable[[float], Peaks] | str  # (penetration, force, duration) from the e asked for
    elastic: Any | str  # the law that it is at e = 1
    uncapped: Any | str = NO_CAP  # the law that it is at F_E = ∞
    stiff: str = ""  # why it does not tend to the instant impulse as its stiffness grows; "" where it does
    between: Callable[[float, float], float] | None = None  # e achieved between two masses, where it depends on them
    behind: Any = None  # the model with left for right, where it has a left and a right

    def achieved(self, striker: float, struck: float) -> float:
        """e between two masses, where 0.65 is asked for."""
        return self.between(striker, struck) if self.between else self.restitution(0.65)


def ratio(e: float) -> float:
    return exact.kelvin_voigt_ratio(e)


def modified(e: float) -> float:
    return exact.modified_kelvin_voigt_ratio(e)


def jankowski_peaks(e: float) -> Peaks:
    return exact.jankowski_impact(BETA, MASS, SPEED, exact.jankowski_ratio(e))


def jankowski_e(e: float) -> float:
    return exact.jankowski_restitution(exact.jankowski_ratio(e))


def damped(e_ratio: float, duration: float) -> Peaks:
    return *exact.damped_impact(K, MASS, SPEED, e_ratio), duration


HERTZ_DEPTH = exact.hertz_impact(BETA, MASS, SPEED)[0]
FACTS = {
    "linear": Facts(Linear(K), lambda e: 1.0, lambda e: exact.linear_impact(K, MASS, SPEED), NO_E),
    "kelvin_voigt": Facts(
        contact.KelvinVoigt(K),
        lambda e: e,
        lambda e: damped(ratio(e), exact.kelvin_voigt_impact(K, MASS, SPEED, ratio(e))[1]),
        Linear(K),
    ),
    "kelvin_voigt_tension_cut": Facts(
        contact.KelvinVoigtTensionCut(K),
        lambda e: exact.kelvin_voigt_cut_restitution(ratio(e)),
        lambda e: damped(ratio(e), exact.kelvin_voigt_cut_duration(K, MASS, ratio(e))),
        Linear(K),
    ),
    "modified_kelvin_voigt": Facts(
        contact.ModifiedKelvinVoigt(K),
        lambda e: exact.modified_kelvin_voigt_restitution(modified(e)),
        lambda e: damped(modified(e), exact.modified_kelvin_voigt_duration(K, MASS, modified(e))),
        Linear(K),
    ),
    "hertz": Facts(Hertz(BETA), lambda e: 1.0, lambda e: exact.hertz_impact(BETA, MASS, SPEED), NO_E),
    "hertz_damp": Facts(
        contact.HertzDamp(BETA),
        lambda e: exact.hertz_damp_restitution(exact.hertz_damp_factor(e)),
        lambda e: exact.hertz_damp_impact(BETA, MASS, SPEED, exact.hertz_damp_factor(e)),
        Hertz(BETA),
    ),
    "hertz_damp_exact": Facts(
        contact.HertzDampExact(BETA),
        lambda e: e,
        lambda e: exact.hertz_damp_impact(BETA, MASS, SPEED, exact_hertz_damp(e)),
        Hertz(BETA),
    ),
    "jankowski": Facts(Jankowski(BETA), jankowski_e, jankowski_peaks, Hertz(BETA)),
    "bilinear": Facts(
        contact.Bilinear(BETA),
        exact.bilinear_restitution,
        lambda e: exact.bilinear_impact(BETA, MASS, SPEED, exact.bilinear_share(e)),
        Linear(BETA * sqrt(HERTZ_DEPTH)),
    ),
    "van_mier": Facts(
        contact.VanMier(BETA), lambda e: 1.0, lambda e: exact.hertz_impact(BETA, MASS, SPEED), NO_E, Hertz(BETA)
    ),
    "viscous_elastoplastic": Facts(
        contact.ViscousElastoplastic(BETA), jankowski_e, jankowski_peaks, Hertz(BETA), Jankowski(BETA)
    ),
    # Its table of one straight line; others have their own tests.
    "tabulated": Facts(contact.Tabulated(K), lambda e: 1.0, lambda e: exact.linear_impact(K, MASS, SPEED), NO_E),
    "stereomechanical": Facts(Stereomechanical(), lambda e: e, JUMPS, Linear(K), stiff=NO_STIFFNESS),
    "distributed_mass": Facts(
        DistributedMass(10.0, 20.0, 3500.0, 3500.0),
        lambda e: 1.0,
        lambda e: (0.0, SPEED * MASS * 3500.0 / 10.0, 2.0 * 10.0 / 3500.0),  # v0 Z, until the wave is back
        "it has its own e, from its floors",
        stiff=NO_STIFFNESS,
        between=lambda striker, struck: exact.bars_restitution((striker, 10.0), (struck, 20.0)),
        behind=DistributedMass(20.0, 10.0, 3500.0, 3500.0),
    ),
    "merged": Facts(instant.Merged(), lambda e: 0.0, JUMPS, "it never rebounds, whatever e", stiff=NO_STIFFNESS),
}


def facts(name: str) -> Facts:
    """The entry of a model; a test fails with the repair where there is none."""
    if name not in FACTS:
        pytest.fail(
            f'the contact model {name} is not tested: write FACTS["{name}"] = Facts(law, restitution, peaks, elastic, '
            f"uncapped, stiff) in {pathlib.Path(__file__).name}, each a closed form or a sentence why it has none",
            pytrace=False,
        )
    return FACTS[name]


def alone(law: Any, e: Any, **more: float) -> Impact:
    return impact(law, SPEED, MASS, restitution=e, **more)


def peaks_of(found: Impact) -> Peaks:
    return found.peak_penetration, found.peak_force, found.duration


# ------------------------------------------------------------------------------------------ one isolated impact
@pytest.mark.parametrize("name", MODELS)
def test_what_a_model_lacks_is_said(name: str):
    """A law of force has closed forms, a damped one its elastic limit, a capped one its uncapped limit."""
    known, kind = facts(name), CONTACT_MODELS[name]
    assert type(known.law) is kind
    reasons = [each for each in (known.peaks, known.elastic, known.uncapped, known.stiff) if isinstance(each, str)]
    assert all(len(reason.split()) > 3 for reason in reasons if reason)
    assert isinstance(known.elastic, str) == (not kind.needs_restitution)
    assert isinstance(known.uncapped, str) == (not kind.capped)
    if not is_instant(kind):
        assert (isinstance(known.peaks, str), known.stiff) == (False, "")


@pytest.mark.parametrize("package", [contact, instant])
def test_every_class_of_a_folder_is_a_model(package):
    """A law without one of its methods would otherwise be no law, and nobody told."""
    known = [*CONTACT_MODELS.values(), *EXACT.values()]
    kinds = [kind for module in modules_in_order(package.__name__) for kind in classes_of(module).values()]
    assert [kind.__name__ for kind in kinds if kind not in known] == []


def test_no_fact_is_left_of_a_model_that_is_gone():
    assert set(FACTS) <= set(MODELS)


@pytest.mark.parametrize("name", MODELS)
def test_restitution_achieved(name: str):
    """The closed form, to 1e-9: the integration runs at 1e-12 and a contact takes some sixty steps."""
    known = facts(name)
    for e in ASKED:
        assert alone(known.law, e).restitution == pytest.approx(known.restitution(e), rel=1e-9), e


@pytest.mark.parametrize(("name", "table"), exact.ACHIEVED.items())
def test_restitution_achieved_in_the_tables(name: str, table: dict[float, float]):
    """Four digits, from an integration that knows no closed form; the capped law has that of its force."""
    assert tuple(table) == ASKED
    for law in (name, "viscous_elastoplastic") if name == "jankowski" else (name,):
        for e, achieved in table.items():
            assert alone(facts(law).law, e).restitution == pytest.approx(achieved, abs=5.1e-5)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("e", [0.5, 0.65, 0.9])
def test_penetration_peak_force_and_duration(name: str, e: float):
    """The closed form, to 1e-9 as e; a jump has no depth and no duration, and its force is no number."""
    known, found = facts(name), peaks_of(alone(facts(name).law, e))
    if isinstance(known.peaks, str):
        assert found[::2] == (0.0, 0.0) and isnan(found[1]), known.peaks
    else:
        assert found == pytest.approx(known.peaks(e), rel=1e-9)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("ratio", [1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_momentum_and_energy(name: str, ratio: float):
    """Momentum to 1e-12 of what the striker brought; work ½ m v0² (1 − e²), e the closed form; impulse (1 + e) m v0.

    Of a law of force only m = m1 m2 / (m1 + m2) counts: its peak is that against a wall with that mass.
    """
    mass, other, speed = 1e4, 1e4 * ratio, 0.8
    known = facts(name)
    found, e = impact(known.law, speed, mass, other, restitution=0.65), known.achieved(mass, other)
    reduced = mass * other / (mass + other)
    whole = 0.5 * reduced * speed**2
    assert abs(found.momentum_change * found.impulse) < 1e-12 * mass * speed
    assert found.energy_lost == pytest.approx(exact.energy_lost(reduced, speed, e), abs=1e-9 * whole)
    assert found.impulse == pytest.approx(exact.impulse(reduced, speed, e), rel=1e-9)
    if name in LAWS:
        wall = impact(known.law, speed, reduced, restitution=0.65)
        assert found.peak_force == pytest.approx(wall.peak_force, rel=1e-9) and isnan(wall.momentum_change)


# ------------------------------------------------------------------------------------------------------- limits
@pytest.mark.parametrize("name", [name for name in MODELS if CONTACT_MODELS[name].needs_restitution])
def test_full_restitution_is_the_elastic_law(name: str):
    """At e = 1 to 1e-9 as all impacts; at 1 − 1e-6 within 1e-5, for the damping is of the order of 1 − e."""
    known = facts(name)
    elastic = alone(known.elastic, 1.0)
    for e, bound in ((1.0, 1e-9), (1.0 - 1e-6, 1e-5)):
        found = alone(known.law, e)
        assert (found.restitution, found.impulse) == pytest.approx((1.0, elastic.impulse), rel=bound)
        assert abs(found.energy_lost) < bound * MASS * SPEED**2
        if not isinstance(known.peaks, str):
            assert peaks_of(found) == pytest.approx(peaks_of(elastic), rel=bound)


@pytest.mark.parametrize("name", [name for name in MODELS if CONTACT_MODELS[name].capped])
def test_cap_that_is_not_reached_changes_nothing(name: str):
    """F_E infinite, or above the largest force by 1e-9 of it: the law without a cap, to the bit."""
    known = facts(name)
    free = alone(known.uncapped, 0.65)
    for strength in (inf, free.peak_force * (1.0 + 1e-9)):
        capped = alone(known.law, 0.65, yield_force=strength)
        assert np.array_equal(capped.force, free.force) and capped.restitution == free.restitution
        assert peaks_of(capped) == peaks_of(free)


@pytest.mark.parametrize("name", MODELS)
def test_a_stiff_contact_tends_to_the_instant_impulse(name: str):
    """One touch of a wall: what differs from a jump by the law's own e goes with the contact's duration.

    That is 5 to 10 ms of a period of 0.5 s; a thousand times the stiffness cuts it to a 1/16 under β, a 1/32 under k.
    """
    known = facts(name)
    if known.stiff:
        assert "stiffness" not in known.law._fields, known.stiff
        return
    pulse = np.zeros(41)  # 0.4 s: the largest opening is past, the next touch not reached
    pulse[1:4] = -6.0
    softer = 1e13 if contact.stiffness_quantity(type(known.law)).unit == "N/m^1.5" else 1e12
    laws = (known.law._replace(stiffness=softer * factor) for factor in (1.0, 1e3))
    jump = solve(SOFT, WALL, Interface(0.008, Stereomechanical(), constant(known.restitution(0.65))), pulse, 0.01)
    stiff, stiffer = (solve(SOFT, WALL, Interface(0.008, law, constant(0.65)), pulse, 0.01) for law in laws)
    assert jump["impact_count"] == stiff["impact_count"] == stiffer["impact_count"] == 1.0
    for output in ("peak_opening", "impulse"):
        far, near = (abs(found[output] / jump[output] - 1.0) for found in (stiff, stiffer))
        assert far < 0.03
        assert near < far / 10.0


def test_van_mier_is_hertz_with_the_exponent_of_hertz():
    """n = 1.5, so that K_p = K_e, past yield in an impact and in a run; at rtol 1e-10 a run's peaks agree to 1e-8."""
    hertz = alone(Hertz(BETA), 1.0)
    same = alone(contact.VanMier(BETA, 1.5), 1.0, yield_force=0.5 * hertz.peak_force)
    assert peaks_of(same) == pytest.approx(peaks_of(hertz), rel=1e-9)
    runs = [
        solve(SOFT, STIFF, Interface(0.004, law, constant(1.0), 5e5), shaking(4.0, duration=2.0), 0.01, rtol=1e-10)
        for law in (Hertz(BETA), contact.VanMier(BETA, 1.5))
    ]
    assert runs[1]["yield_count"] == runs[0]["yield_count"] >= 1.0
    for output in ("peak_relative_displacement", "peak_contact_force", "peak_penetration", "impulse", "contact_time"):
        assert runs[1][output] == pytest.approx(runs[0][output], rel=1e-8), output


# -------------------------------------------------------------------------------------------------- a whole run
def run(name: str, mirrored: bool = False, right: Building = STIFF) -> dict[str, float]:
    """Two buildings out of tune, 3 s: several contacts; a capped law yields."""
    pair, sign = ((right, SOFT), -1.0) if mirrored else ((SOFT, right), 1.0)
    law = facts(name).behind if mirrored and facts(name).behind else facts(name).law
    there = Interface(0.003, law, CONCRETE, 5e5)
    return solve(*pair, there, sign * shaking(4.0, duration=3.0), 0.01)


@pytest.mark.parametrize("name", MODELS)
def test_energy_of_a_run_closes(name: str):
    """To the tolerance: a few contacts, whose steps of 0.05 rtol err either way. What returns e = 1 takes nothing."""
    found = run(name)
    assert found["status"] == COMPLETE and found["impact_count"] >= 3.0
    assert found["energy_residual"] <= 1e-6
    taken = found["energy_viscous"] + found["energy_plastic"]
    brought = 0.5 * found["peak_approach_speed"] ** 2 / (1.0 / SOFT.mass + 1.0 / STIFF.mass)
    assert taken > 0.01 * brought if facts(name).achieved(SOFT.mass, STIFF.mass) < 1.0 else abs(taken) < 1e-6 * brought
    assert found["yield_count"] >= 1.0 or not CONTACT_MODELS[name].capped


@pytest.mark.parametrize("right", [STIFF, WALL], ids=["mass", "wall"])
@pytest.mark.parametrize("name", MODELS)
def test_a_run_seen_from_behind_is_the_same(name: str, right: Building):
    """To the bit: left for right and the ground reversed swaps the buildings' outputs and no other."""
    one, other = run(name, right=right), run(name, mirrored=True, right=right)
    assert one["impact_count"] >= 1.0
    swap = {"left": "right", "right": "left"}
    stems = {key: key.rpartition("_") for key in one}
    twins = {key: other[f"{stem}_{swap[side]}" if side in swap else key] for key, (stem, _, side) in stems.items()}
    assert largest_difference(one, twins) == 0.0


@pytest.mark.parametrize("name", LAWS)
def test_force_pulls_only_where_published(name: str):
    for e in (0.1, 0.65, 1.0):
        smallest = alone(facts(name).law, e).force.min()
        assert (smallest < 0.0) == (name == "kelvin_voigt" and e < 1.0)


YIELD = 3e5  # N
DEPTHS = np.geomspace(1e-7, 1e-2, 21)  # m


def law_of(name: str):
    kind = LAWS[name]
    return kind(9.35e7) if stiffness_quantity(kind).unit == "N/m" else kind(2.75e9)


@pytest.mark.parametrize("name", LAWS)
def test_what_a_law_says_of_itself(name: str):
    """Its flags agree with its methods, so that whoever reads a flag reads the physics."""
    law = law_of(name)
    assert law.reference and law.__doc__
    assert law.capped == (law.ceiling(YIELD) == YIELD) and (law.capped or law.ceiling(YIELD) == inf)
    assert law.needs_restitution == (law.begin(0.5, 0.3, 570.0) != law.begin(0.9, 0.3, 570.0))
    assert law.floor() in (0.0, -inf)


@pytest.mark.parametrize("name", LAWS)
def test_a_law_without_a_damper_takes_no_viscous_energy(name: str):
    """Said of a law whose force follows from δ alone, whatever e is: what its contact takes is 0 J, and no rounding."""
    law = law_of(name)
    memory = law.begin(0.6, 0.5, 570.0)
    alike = all(law.force(memory, d, 0.4, True) == law.force(memory, d, -0.4, False) for d in DEPTHS)
    # That of the points of a table is path-dependent only where it has a way back.
    assert law.conserves() == (alike and (name == "tabulated" or not is_path_dependent(LAWS[name])))
    if law.conserves():
        assert ends_itself(law, memory, 1e-9, 1e6, 3e-7, 0.0) == (0.0, 0.0, 0.0)


def test_a_law_that_changes_the_force_of_one_without_a_damper_says_nothing_of_it():
    class Sticky(LAWS["linear"]):
        __slots__ = ()

        def begin(self, e, speed, mass):
            return 1.0

    assert not complete(Sticky)(1e8).conserves()


@pytest.mark.parametrize("name", [name for name, law in LAWS.items() if not is_path_dependent(law)])
def test_stored_energy_is_the_work_of_a_slow_push(name: str):
    """∫ min(F, plateau) dδ at rest; to 1e-10, what the quadrature resolves over the corner at yield."""
    law = law_of(name)
    for strength in (YIELD, inf):
        ceiling = law.ceiling(strength)

        def slow(depth: float, top: float = ceiling) -> float:
            free = law.force(0.0, depth, 0.0, False)
            return free if free <= top else law.plateau(depth, top)

        corner = (ceiling / law.stiffness) ** (2.0 / 3.0) if ceiling < inf else 0.0
        work = quad(slow, 0.0, 5e-3, points=[corner] if 0.0 < corner < 5e-3 else None, epsrel=1e-12, limit=200)[0]
        assert law.stored(5e-3, ceiling) == pytest.approx(work, rel=1e-10)


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 1.5])
def test_van_mier_past_yield(exponent: float):
    """K_p δ^n with K_p from continuity at F_E; n = 0 stays there, and n = 1.5 is a test of conformance."""
    law = VanMier(2.75e9, exponent)
    depth = (YIELD / 2.75e9) ** (2.0 / 3.0)
    for times in (1.0, 1.7, 8.0):
        assert law.plateau(times * depth, YIELD) == pytest.approx(YIELD * times**exponent, rel=1e-14)


@pytest.mark.parametrize("name", LAWS)
def test_a_touch_from_rest_has_a_finite_force(name: str):
    """v0 = 0 divides in the Hertz-damp laws; what a law remembers stays finite."""
    law = law_of(name)
    memory = law.begin(0.65, 0.0, 570.0)
    assert np.all(np.isfinite(memory)) and np.isfinite(law.force(memory, 1e-6, 1e-9, True))


@pytest.mark.parametrize("e", [0.3, 0.65, 1.0])
def test_bilinear_loop(e: float):
    """Force K δ_m at δ_m; the loop to δ_m and back takes β δ_m^2.5 (1 − e²) / 2.5; inside it the slope is K1."""
    law, depth = Bilinear(2.75e9, 0.004), 0.004
    memory = law.begin(e, 0.5, 570.0)
    back = law.turned(memory, depth, True)
    assert law.force(memory, depth, 0.1, True) == pytest.approx(2.75e9 * sqrt(depth) * depth, rel=1e-12)
    way = np.array(
        [law.force(memory, x, 0.1, True) - law.force(back, x, -0.1, False) for x in np.linspace(0, depth, 20001)]
    )
    # Piecewise linear: the sum over 20,000 parts is off by the square of one at four corners.
    assert np.trapezoid(way, dx=depth / 20000) == pytest.approx(
        2.75e9 * depth**2.5 * (1 - e * e) / 2.5, rel=1e-6, abs=1e-9
    )
    steep = (law.force(back, depth, 0, False) - law.force(back, depth - 1e-5, 0, False)) / 1e-5
    assert steep == pytest.approx(memory[0] + memory[1], rel=1e-9)
    again = law.turned(back, 0.5 * depth, False)  # reloading from the lower line starts with K1 as well
    assert law.force(again, 0.5 * depth, 0, True) == pytest.approx(law.force(back, 0.5 * depth, 0, False), rel=1e-12)
    more = law.force(again, 0.5 * depth + 1e-5, 0, True) - law.force(again, 0.5 * depth, 0, True)
    assert more / 1e-5 == pytest.approx(memory[0] + memory[1], rel=1e-9)
    # What is held is the work of the slow way out, two straight lines, so that the quadrature rounds only.
    out = quad(lambda x: law.force(back, x, -0.1, False), 0.0, depth, points=[0.9 * depth], epsrel=1e-12)[0]
    assert law.held(memory, 0.0, inf) == 0.0 and law.held(back, depth, inf) == pytest.approx(out, rel=1e-12)


@pytest.mark.parametrize(("e", "achieved"), exact.BILINEAR_DESIGN.items())
def test_bilinear_as_deep_as_designed(e: float, achieved: float):
    """Its table has three digits; the closed form is met to 1e-9, peak force, depth and loss with it."""
    stiffness, depth, mass = 2.75e9, 0.004, 570.0
    whole, loop = stiffness * sqrt(depth), stiffness * depth**2.5 * (1.0 - e * e) / 2.5
    speed = sqrt((whole * depth**2 + loop) / mass)
    found = impact(Bilinear(stiffness, depth), speed, mass, restitution=e)
    share = 0.4 * (1.0 - e * e)
    assert found.restitution == pytest.approx(sqrt((1.0 - share) / (1.0 + share)), rel=1e-9)
    assert found.restitution == pytest.approx(achieved, abs=5.1e-4)
    assert (found.peak_penetration, found.peak_force) == pytest.approx((depth, whole * depth), rel=1e-9)
    assert found.energy_lost == pytest.approx(loop, rel=1e-9)


class Loop(Path):
    """The bilinear law with a design penetration, at e = 0.65."""

    def __init__(self, stiffness: float, depth: float):
        loop, self.reach, self.anchor = stiffness * depth**2.5 * (1.0 - 0.65**2) / 2.5, 0.1 * depth, 0.0
        self.steep = stiffness * sqrt(depth) + loop / (0.1 * depth**2)
        self.flat = stiffness * sqrt(depth) - loop / (0.9 * depth**2)

    def begin(self):
        self.anchor = 0.0

    def force(self, delta):
        return self.flat * delta + (self.steep - self.flat) * float(np.clip(delta - self.anchor, 0.0, self.reach))

    def turned(self, delta, inwards):
        self.anchor = max(self.anchor, delta - self.reach) if inwards else min(self.anchor, delta)


def test_bilinear_run_against_scipy():
    """Whole run, path and all; to 1e-5, what the fine samples and SciPy's steps over the corners leave."""
    pair = Building("left", 500e3, 0.5, 0.05), Building("right", 800e3, 0.31, 0.05)
    ground = shaking(4.0, duration=3.0)
    found = solve(*pair, Interface(0.004, Bilinear(2.75e9, 0.005), constant(0.65)), ground, 0.01, rtol=1e-10)
    largest, force, touches = follow_pair(*pair, 0.004, Loop(2.75e9, 0.005), ground, 0.01)
    assert touches == found["impact_count"] >= 4.0
    assert found["energy_plastic"] > 0.0 == found["energy_viscous"]  # its loss is that of the path
    assert found["energy_residual"] < 1e-5 and found["lowest_contact_force"] >= 0.0 == found["permanent_set"]
    assert found["peak_relative_displacement"] == pytest.approx(largest, rel=1e-5)
    assert found["peak_contact_force"] == pytest.approx(force, rel=1e-4)
