"""Exact damping by choice: e achieved is e asked for; scenes, impacts and the command line say which relation."""

from decimal import Decimal, localcontext
from functools import cache, partial
from math import atan2, exp, inf, log, pi, sqrt

import closed_forms as forms
import numba
import numpy as np
import pytest
from commands import done, refused
from hypothesis import given
from hypothesis import strategies as st
from processes import compiled, interpreted
from scenes import rigid, scene_text, single
from scipy.integrate import solve_ivp
from sentences import refusal
from sweeps import sweep
from test_conformance import law_of

import pounding_risk as pr
from pounding_risk._jit.compile import lowered
from pounding_risk.ensemble.plan.scene_text import scene_words
from pounding_risk.models.contact import laws as contact
from pounding_risk.models.contact.damping import approach_ratio, speed_lost
from pounding_risk.models.contact.impulsive import CONTACT_MODELS, Stereomechanical
from pounding_risk.models.contact.laws import EXACT, LAWS, SHIPPED, Bilinear, Jankowski
from pounding_risk.models.contact.laws.bilinear import BILINEAR_LOWEST, bilinear_loop
from pounding_risk.models.contact.laws.hertz import exact_hertz_damping
from pounding_risk.models.contact.relation import name_of, restitution_of_ratio
from pounding_risk.models.restitution import CONCRETE, Restitution
from pounding_risk.results.labels import attributes
from pounding_risk.scene.reader import parse_scene

MASS, SPEED, BETA = 570.0, 0.5, 2.75e9
ASKED = (0.01, 0.02, 0.05, 0.1, 0.2, 0.35, exp(-1.0), 0.5, 0.65, 0.8, 0.9, 0.99, 0.9999, 1.0 - 1e-7, 1.0)
ELASTIC = [name for name in SHIPPED if not LAWS[name].needs_restitution]
ABLE = [name for name in SHIPPED if LAWS[name] in EXACT]
QUICK = ("jankowski", "bilinear")  # a power of 1.5 and a loop
LEAST = {"bilinear": BILINEAR_LOWEST}  # the least e that a law returns, where there is one
SPEEDS = (1e-3, 0.1, 0.5, 2.0, 5.0, 20.0)


def exact_law(name: str):
    law = law_of(name)
    return EXACT[type(law)](*law)


def test_every_law_with_damping_can():
    """Elastic laws have no loss to relate; every other law that comes with the package is able."""
    assert sorted([*ABLE, *ELASTIC]) == sorted(SHIPPED)
    for published, other in EXACT.items():
        assert issubclass(other, published) or (published.__name__, other) == ("HertzDamp", contact.HertzDampExact)


def achieved(name: str) -> dict[str, list]:
    """Pairs of e asked for and e achieved, of numbers and of concrete."""
    law, least = law_of(name), LEAST.get(name, 0.0)
    numbers, concrete = [], []
    for e in (least, *(e for e in ASKED if e > least)) if least else ASKED:
        for speed, mass, other in ((SPEED, MASS, inf), (3.0, MASS, 900.0)):
            found = pr.impact(law, speed, mass, other, restitution={"value": e, "relation": "exact"})
            numbers.append((e, found.restitution))
    for speed in SPEEDS:
        found = pr.impact(law, speed, MASS, restitution="concrete", relation="exact")
        concrete.append((found.restitution_asked, found.restitution))
    return {"numbers": numbers, "concrete": concrete}


@cache
def all_achieved(names: tuple[str, ...]) -> dict[str, dict[str, list]]:
    """`achieved` of these laws, by a process that compiles nothing: a law's kernel takes half a minute when it is new.

    Of an exact law only ``begin`` is its own, and that is held to its compiled form below; the rest is the published
    law's, which tests/jit/test_compile.py holds.
    """
    code = "import json\nfrom test_exact_damping import achieved\n"
    return interpreted(f"{code}print(json.dumps({{name: achieved(name) for name in {names}}}))")


def achieved_of(name: str) -> dict[str, list]:
    """`achieved` of a law, computed with the others of its line of tests."""
    return all_achieved(QUICK if name in QUICK else tuple(law for law in ABLE if law not in QUICK))[name]


@pytest.mark.parametrize("name", sweep(ABLE, *QUICK))
def test_restitution_achieved_is_that_asked_for(name: str):
    """1e-6 is promised; the relations are solved to rounding and impacts run at 1e-12, hence 1e-9 here."""
    pairs = achieved_of(name)["numbers"]
    least = LEAST.get(name, 0.0)
    assert len(pairs) == 2 * (sum(e > least for e in ASKED) + bool(least))
    for e, found in pairs:
        assert found == pytest.approx(e, abs=1e-9)


@pytest.mark.parametrize("name", sweep(ABLE, *QUICK))
def test_restitution_of_concrete_is_achieved_at_every_speed(name: str):
    """Past 5 m/s too, where e is held."""
    for speed, (asked, found) in zip(SPEEDS, achieved_of(name)["concrete"], strict=True):
        assert found == pytest.approx(CONCRETE.at(speed), abs=1e-8)
        assert asked == pytest.approx(CONCRETE.at(speed), abs=1e-15)


@numba.njit(error_model="numpy")
def begun(law, e, speed, mass):
    """The law's ``begin``, compiled."""
    return law.begin(e, speed, mass)


@pytest.mark.complete
@compiled
@pytest.mark.parametrize("name", ABLE)
def test_the_interpreted_damping_is_the_compiled_one(name: str):
    """An exact law differs from the published one in ``begin`` alone; to 1e-14, as products may be fused."""
    law = exact_law(name)
    verbs = [verb for verb in vars(contact.ContactLaw) if not verb.startswith("_")]
    own = [verb for verb in verbs if getattr(type(law), verb) is not getattr(LAWS[name], verb)]
    assert own == ([] if EXACT[LAWS[name]] is LAWS[name] else ["begin"])
    for e in (LEAST.get(name, 0.0), *ASKED):
        if e >= max(LEAST.get(name, 0.0), min(ASKED)):
            memory = np.ravel(law.begin(e, SPEED, MASS))
            assert np.ravel(begun(lowered(law), e, SPEED, MASS)) == pytest.approx(memory, rel=1e-14, abs=0.0)


def dimensionless_rebound(ratio: float, exponent: float, dashpot: float) -> float:
    """e of x'' = −x^n − 2 ξ x^p x' on approach and x'' = −x^n after, x'(0) = 1, by SciPy.

    In y = x^(1 + p), where the dashpot is linear, the start has no infinite slope:
    y' = (1 + p) x^p x'. After the turn the speed is sqrt(2 x^(n+1) / (n + 1)).
    """

    def motion(_, state):
        x = max(state[0], 0.0) ** (1.0 / (1.0 + dashpot))
        return (1.0 + dashpot) * x**dashpot * state[1], -(x**exponent) - 2.0 * ratio * x**dashpot * state[1]

    def turn(_, state):
        return state[1]

    turn.terminal = True
    # From rest x^p is zero, so the start is a little way in: x = t, and the work done so far is x^(n+1)/(n+1)
    # and 2 ξ x^(1+p)/(1+p), to first order; what is left out is of the order of the square of the latter.
    x = 1e-12
    y = x ** (1.0 + dashpot)
    start = [y, 1.0 - 2.0 * ratio * y / (1.0 + dashpot)]
    found = solve_ivp(motion, (0.0, 1e3), start, "DOP853", events=turn, rtol=1e-12, atol=1e-15)
    depth = found.y_events[0][0][0] ** (1.0 / (1.0 + dashpot))
    return sqrt(2.0 * depth ** (exponent + 1.0) / (exponent + 1.0))


@pytest.mark.parametrize("e", [0.02, 0.1, 0.3, 0.5, 0.65, 0.8, 0.95])
def test_one_relation_serves_jankowski_and_the_damper_on_approach(e: float):
    """SciPy's integration of the two laws, which knows nothing of the substitution; 1e-8, its start is of 1e-12."""
    modified = approach_ratio(e)
    assert dimensionless_rebound(modified, 1.0, 0.0) == pytest.approx(e, abs=1e-8)
    jankowski = contact.JankowskiExact(1.0).begin(e, 1.0, 1.0) / 2.0
    assert jankowski == pytest.approx(0.5 * sqrt(5.0) * modified, rel=1e-15)
    assert dimensionless_rebound(jankowski, 1.5, 0.25) == pytest.approx(e, abs=1e-8)


@pytest.mark.parametrize("e", [*np.geomspace(1e-9, 0.3, 12), *np.linspace(0.36, 0.375, 16), 0.5, 0.9, 1.0 - 1e-9])
def test_ratio_on_approach_is_inverted(e: float):
    """Against the closed form that the tests have, over its seam at ξ = 1 as well; 1e-12, the series' own.

    Where e is next to nothing, s/ξ of the closed form rounds: there the two ends are told by their limits.
    """
    ratio = approach_ratio(e)
    assert exp(-speed_lost(ratio)) == pytest.approx(e, rel=1e-12)
    if e > 1e-6:
        # atanh(s/ξ) loses what ξ² is above 1: 1e-16 ξ².
        assert forms.modified_kelvin_voigt_restitution(ratio) == pytest.approx(e, rel=1e-11 + 1e-15 * ratio**2)
    else:
        assert ratio == pytest.approx(0.5 / e, rel=1e-6)
    if 1.0 - e < 1e-6:
        assert ratio == pytest.approx(-2.0 * log(e) / pi, rel=1e-8)


def test_ratios_of_the_tables():
    """Published values and closed forms; five digits are printed."""
    modified = {0.4: 0.87904, 0.5: 0.59734, 0.6: 0.40474, 0.65: 0.32929, 0.7: 0.26388, 0.8: 0.15585, 0.9: 0.07004}
    tables = {
        "modified_kelvin_voigt": modified,
        "kelvin_voigt_tension_cut": {0.65: 0.14994, 0.5: 0.25528, 0.4: 0.35451},
        "kelvin_voigt": {0.65: 0.13585},
        "jankowski": forms.EXACT_JANKOWSKI,
        "viscous_elastoplastic": forms.EXACT_JANKOWSKI,
    }
    for name, table in tables.items():
        for e, ratio in table.items():
            memory = EXACT[LAWS[name]](4.0).begin(e, SPEED, 9.0)
            assert memory / (2.0 * sqrt(4.0 * 9.0)) == pytest.approx(ratio, abs=6e-6), (name, e)
    for e, factor in forms.EXACT_HERTZ_DAMP.items():
        assert EXACT[LAWS["hertz_damp"]](1.0).begin(e, SPEED, 1.0) * SPEED == pytest.approx(factor, abs=6e-6)
    for e in (0.14, 0.3, 0.65, 0.9):  # the closed form with ξ < 1 ends at e = exp(−2)
        ratio = EXACT[LAWS["kelvin_voigt_tension_cut"]](1.0).begin(e, SPEED, 1.0) / 2.0
        assert forms.kelvin_voigt_cut_restitution(ratio) == pytest.approx(e, rel=1e-12)


@pytest.mark.parametrize("lost", [1e-12, 1e-8, 1e-5, 9.99e-4, 1.01e-3, 0.01])
def test_penetration_damping_next_to_full_restitution(lost: float):
    """d against 60 digits of its equation, where doubles cancel; 1e-7, for Newton's rule keeps 1e-8 at the seam."""
    with localcontext() as context:
        context.prec = 60
        e = Decimal(1.0 - lost)
        low, high = (1 - e) * Decimal("1.4"), (1 - e) * Decimal("1.6")
        for _ in range(140):
            d = (low + high) / 2
            low, high = (d, high) if d * (1 + e) + (1 - d * e).ln() - (1 + d).ln() > 0 else (low, d)
    assert exact_hertz_damping(1.0 - lost) == pytest.approx(float(low), rel=1e-7)


@pytest.mark.parametrize("e", [BILINEAR_LOWEST, 0.3536, 0.36, 0.393, 0.5, 0.65, 0.8, 0.95, 1.0 - 1e-9, 1.0])
def test_loop_of_the_bilinear_law_is_inverted(e: float):
    """Against the closed form of e of a loop, which knows no cubic; 1e-14 over the slope de/dQ of at least 0.2."""
    share = bilinear_loop(e)
    assert 0.0 <= share <= 1.0
    assert forms.bilinear_loop_restitution(share) == pytest.approx(e, rel=1e-13)
    flat, steep, yields_at, anchor = contact.BilinearExact(BETA).begin(e, SPEED, MASS)
    depth = (1.25 * MASS * SPEED**2 / BETA) ** 0.4
    whole = BETA * sqrt(depth)
    # As published: K δ_m at δ_m, a tenth of the way elastic.
    assert (flat * depth + steep * yields_at, yields_at, anchor) == pytest.approx((whole * depth, 0.1 * depth, 0.0))
    assert (flat, steep * yields_at) == pytest.approx((whole * (1.0 - share), whole * depth * share))


def test_where_the_loop_of_the_bilinear_law_ends():
    """e = sqrt(1/8): all plastic, x = 0.45. Below, and under a fixed δ_m, there is no loop, and no number."""
    assert bilinear_loop(BILINEAR_LOWEST) == 1.0 and sqrt(0.125) == BILINEAR_LOWEST
    assert forms.bilinear_loop_restitution(1.0) == pytest.approx(BILINEAR_LOWEST, rel=1e-15)
    assert np.isnan(bilinear_loop(0.35))
    assert np.isnan(contact.BilinearExact(BETA, 0.004).begin(0.65, SPEED, MASS)[0])


def test_a_fixed_design_penetration_returns_another_e_at_every_speed():
    """Why it is refused: the published loop at half, once and twice the design speed, and a touch that cannot yield."""
    depth = 0.004
    speed = sqrt(0.8 * BETA * depth**2.5 / MASS)
    found = [pr.impact(Bilinear(BETA, depth), part * speed, MASS, restitution=0.65) for part in (0.1, 0.5, 1.0, 2.0)]
    assert found[0].restitution == pytest.approx(1.0, abs=1e-9)
    assert found[2].restitution == pytest.approx(forms.bilinear_restitution(0.65), rel=1e-9)
    assert abs(found[1].restitution - found[3].restitution) > 0.05


@pytest.mark.parametrize(("depth", "e"), [(0.0, 0.3), (0.004, 0.65)], ids=["a small e", "a design penetration"])
def test_what_the_bilinear_law_cannot_return_is_refused(depth: float, e: float, says):
    """By an impact, by the reader of a scene with its line, and by every command that is given a study of it."""
    law = Bilinear(BETA, depth) if depth else Bilinear(BETA)
    text = SCENE.replace("0.65", str(e)).replace("jankowski", "bilinear")
    if depth:
        text = text.replace('gap = "5 mm"', 'gap = "5 mm"\ndesign_penetration = "4 mm"')
    scene = parse_scene(text.replace("exact", "published")).updated(relation="exact")
    compared = partial(pr.compare, laws=["jankowski", "bilinear"], relation="exact")
    says(refusal(pr.impact, law, SPEED, MASS, restitution=e, relation="exact"), refusal(parse_scene, text))
    says([refusal(command, scene) for command in (pr.simulate, pr.scan, pr.validate, compared)])
    assert pr.validate(parse_scene(text.replace("exact", "published"))).cases == 1


def test_concrete_is_within_reach_of_every_law():
    """Its e is held at 0.393 past 5 m/s."""
    text = SCENE.replace("value = 0.65", 'value = "concrete"').replace("jankowski", "bilinear")
    assert pr.validate(parse_scene(text)).cases == 1


SCENE = scene_text(
    single("frame", "44.36 t", "0.3 s"),
    rigid(),
    gap="5 mm",
    restitution={"value": 0.65, "relation": "exact"},
    records={"window": ["0 s", "4 s"], "pga": "0.5 g"},
)


def test_a_scene_chooses_its_relation():
    found = parse_scene(SCENE)
    assert (found.relation, found.restitution, found.restitution_words) == ("exact", Restitution(0.65), "0.65")
    assert type(found.law()) is contact.JankowskiExact and name_of(type(found.law())) == "jankowski"
    assert type(found.law("hertz")).__name__ == "Hertz"  # elastic laws beside it are as they are
    assert 'restitution = {value = 0.65, relation = "exact"}' in found.to_toml()
    assert parse_scene(found.to_toml()) == found
    concrete = parse_scene(SCENE.replace("value = 0.65", 'value = "concrete"'))
    assert (concrete.relation, concrete.restitution) == ("exact", CONCRETE)
    assert parse_scene(concrete.to_toml()) == concrete != found


@pytest.mark.parametrize("words", ["0.65", "{value = 0.65}", '{value = 0.65, relation = "published"}'])
def test_published_is_the_default(words: str):
    """The same class, so the same compiled code, and the same text of the scene."""
    found = parse_scene(SCENE.replace('{value = 0.65, relation = "exact"}', words))
    assert found.relation == "published" and type(found.law()) is Jankowski
    assert "restitution = 0.65\n" in found.to_toml()


WRONG = {
    "a relation misspelt": ('"exact"', '"exakt"'),
    "a number as a relation": ('"exact"', "1"),
    "a key misspelt": ("relation =", "relations ="),
    "no value": ("value = 0.65, ", ""),
    "a name misspelt": ("value = 0.65", 'value = "concreet"'),
    "an elastic law": ('"jankowski"', '"hertz"'),
    "a law that hardens": ('"jankowski"', '"van_mier"'),
}


REFUSED = {words: partial(parse_scene, SCENE.replace(*change), "scene.toml") for words, change in WRONG.items()}


def test_elastic_laws_may_stand_beside_damped_ones(says):
    """As a baseline of a grid; only where no law has damping is the relation without meaning."""
    grid = '[grid]\ncontact_model = ["jankowski", "hertz"]\n'
    assert parse_scene(SCENE + grid).grid.contact_models == ("jankowski", "hertz")
    alone = grid.replace("jankowski", "van_mier")
    says(refusal(parse_scene, SCENE.replace('"jankowski"', '"hertz"') + alone))


def struck(restitution, relation="published"):
    return partial(pr.impact, law_of("linear"), SPEED, MASS, restitution=restitution, relation=relation)


REFUSED |= {
    "an impact of no relation in a table": struck({"value": 0.65, "relation": "best"}),
    "an impact of no relation": struck(0.65, "best"),
    "an impact of no value": struck({"relation": "exact"}),
    "an impact with another key": struck({"value": 0.65, "speed": 1.0}),
    "an impact of an elastic law": struck(0.65, "exact"),
    "a ratio without rebound": partial(restitution_of_ratio, 1.0 - 1e-16, "kelvin_voigt"),
}


def test_the_command_line_takes_a_relation_or_a_ratio(says):
    def told(*words: str) -> str:
        return done("impact", "--restitution", *words).output

    def achieved(told: str) -> list[str]:
        return [line.split()[2] for line in told.splitlines() if line.startswith("jankowski ")]

    assert achieved(told("0.65")) == ["0.6470"]
    assert achieved(told("0.65", "--relation", "exact")) == ["0.6500"]
    assert f"{restitution_of_ratio(0.35, 'jankowski'):.4f}" in told("xi 0.35 of jankowski")
    for words in (("--relation", "exat"), ("--relation", "exact", "--law", "hertz")):
        says(refused("impact", *words))


@pytest.mark.complete
def test_a_run_takes_the_relation():
    """The fastest contact with a hard wall is nearly an impact alone: 0.5 g over half a millisecond moves e by 1e-3."""
    hard = ["interface.stiffness=2.75e14 N/m^1.5"]
    exact, published = (
        pr.simulate(parse_scene(SCENE, overrides=[*hard, *words])) for words in ([], ["interface.restitution=0.65"])
    )
    for run, achieved in ((exact, 0.65), (published, forms.ACHIEVED["jankowski"][0.65])):
        assert run.attrs["status"] == "complete"
        fastest = int(run.contact_approach_speed.values.argmax())
        found = float(run.contact_rebound_speed[fastest] / run.contact_approach_speed[fastest])
        assert found == pytest.approx(achieved, abs=1e-3)
    results = pr.scan(parse_scene(SCENE, overrides=hard), check_fraction=0.0)
    assert results.attrs["restitution_relation"] == "exact"
    assert float(results.peak_contact_force.max()) == float(exact.contact_peak_force.max())


def test_kelvin_voigt_and_a_jump_are_exact_as_they_are():
    assert EXACT[contact.KelvinVoigt] is contact.KelvinVoigt
    for e in ASKED:
        found = pr.impact(Stereomechanical(), SPEED, MASS, restitution={"value": e, "relation": "exact"})
        assert found.restitution == pytest.approx(e, rel=1e-14)


# ------------------------------------------------------------------------------------------------ damping ratios


def scene(restitution):
    return parse_scene(scene_text(single("A", "40 t", "0.5 s"), single("B", "60 t", "0.3 s"), restitution=restitution))


@pytest.mark.parametrize("name", contact.RESTITUTION_OF_RATIO)
@given(ratio=st.floats(0.0, 0.95))
def test_the_law_damps_with_the_ratio_that_was_given(name, ratio):
    """With unit stiffness and mass a published law's damping is 2 ξ, computed by the law itself from e."""
    law = CONTACT_MODELS[name](1.0)
    # Both directions are a handful of operations: 1e-12 leaves room for e near 1, where ξ is a difference from 1.
    assert law.begin(restitution_of_ratio(ratio, name), 1.0, 1.0) / 2.0 == pytest.approx(ratio, rel=1e-12, abs=1e-15)


def test_a_scene_takes_a_ratio_and_states_e():
    study = scene("xi 0.35 of jankowski")
    assert study.restitution.c0 == restitution_of_ratio(0.35, "jankowski")
    said = f"{study.restitution.c0:.6g}, from ξ = 0.35 of jankowski"
    assert ("restitution", said) in scene_words(study, 1)
    assert attributes(study, (), ((study.law(),),), "pair")["restitution"] == said


def test_a_ratio_is_written_back_as_it_was_given():
    study = scene(" ξ = 0.35 of  jankowski")
    assert study == scene("xi 0.35 of jankowski") != scene(study.restitution.c0)
    assert parse_scene(study.to_toml()) == study
    assert 'restitution = "xi 0.35 of jankowski"' in study.to_toml()


NO_RATIOS = {
    "no law": "xi 0.35",
    "an elastic law": "xi 0.35 of hertz",
    "above 1": "xi 1.2 of kelvin_voigt",
    "below 0": "xi -0.1 of jankowski",
    "a letter": "xi a of jankowski",
    "of the exact relation": {"value": "xi 0.35 of jankowski", "relation": "exact"},
}


REFUSED |= {f"a ratio: {words}": partial(scene, ratio) for words, ratio in NO_RATIOS.items()}


@pytest.mark.parametrize("fault", REFUSED)
def test_what_is_wrong_with_a_restitution_is_told(fault: str, says):
    says(refusal(REFUSED[fault]))


@pytest.mark.parametrize("room", [9e-5, 3e-5, -3e-5, -9e-5])
def test_the_series_where_the_closed_forms_meet_is_theirs(room):
    """Both closed forms lose half of the digits at room 0 only; at 1e-5 they are good to 1e-12."""
    ratio = sqrt(1.0 - room)
    s = sqrt(abs((1.0 - ratio) * (1.0 + ratio)))
    closed = ratio / s * (atan2(s, ratio) if room > 0.0 else log(ratio + s))
    assert speed_lost(ratio) == pytest.approx(closed, abs=2e-12)
    assert abs(speed_lost(ratio) - 1.0) > 5e-6
