"""A contact law of the user's own: the example of docs/own_law.md, what is refused, and never an old number."""

import json
import os
import re
from collections.abc import Iterator
from math import sqrt
from pathlib import Path
from typing import Annotated, NamedTuple

import closed_forms as forms
import pytest
from processes import PACKAGE, output
from scenes import rigid, scene_text, single
from sentences import refusal

import pounding_risk as pr
from pounding_risk._jit import compile as _jit
from pounding_risk._jit.lowering.cache import is_foreign
from pounding_risk._jit.sources import INTERPRETED
from pounding_risk.models.contact import laws as contact
from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.contact.relation import name_of
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.sections import schema as scene_schema
from pounding_risk.solver.pair.law_verbs import depth_of


@pytest.fixture(autouse=True)
def laws() -> Iterator[None]:
    """Laws that a test makes known are forgotten after it."""
    kept = dict(LAWS)
    yield
    LAWS.clear()
    LAWS.update(kept)


def python(code: str, folder: Path, **more: str) -> str:
    """What a fresh interpreter prints that runs this code in this folder."""
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent), **more}
    return output("-c", code, cwd=folder, env=environment, timeout=600)


def fenced(root: Path, page: str, language: str) -> str:
    """The first block of a language on a page of the docs."""
    return re.findall(rf"^```{language}\n(.*?)^```$", (root / "docs" / page).read_text("utf-8"), re.S | re.M)[0]


@pytest.mark.complete
def test_the_example_of_the_page(root, tmp_path):
    """As it stands there, on the scene of docs/start.md, and its class defined again with twice the damping.

    Both e by the closed form of their damping, to the solver's 1e-9.
    """
    (tmp_path / "scene.toml").write_text(fenced(root, "start.md", "toml"), "utf-8")
    asked = (
        "\nimport json\nchosen = dict(gap=0.0, polarity='as recorded', yield_force=4.5e5, record='RSN6-180')\n"
        "forces = results.peak_contact_force.sel(chosen)\n"
        "own, other = (forces.sel(contact_model=law).item() for law in ('hunt_crossley', 'jankowski'))\n"
        "print(json.dumps([alone.law, alone.restitution, run.peak_contact_force.item(), own, other,"
        " run.status, sorted(set(results.status.values.ravel().tolist())), results.references, again.restitution]))"
    )
    example = fenced(root, "own_law.md", "python")
    assert example.count("1.5 * (1.0 - e)") == 1
    again = example.replace("1.5 * (1.0 - e)", "3.0 * (1.0 - e)").partition("scene = ")[0].replace("alone", "again")
    told = json.loads(python(example + again + asked, tmp_path))
    law, e, simulated, own, other, status, statuses, references, damped = told
    assert law == "hunt_crossley"
    assert e == pytest.approx(forms.hertz_damp_restitution(1.5 * (1.0 - 0.65)), abs=1e-9)
    assert damped == pytest.approx(forms.hertz_damp_restitution(3.0 * (1.0 - 0.65)), abs=1e-9)
    assert (status, statuses) == ("complete", [0])
    assert simulated == own != other
    assert references.endswith("; HuntCrossley, a law of the user's own")


def test_the_example_has_ten_lines_and_its_laws_source(root):
    """From the decorator to the last verb; the verbs may be read, and the six are there."""
    body = fenced(root, "own_law.md", "python").partition("@pr.contact_law")[2].partition("\n\n")[0]
    assert body.count("\n") <= 10
    assert all(re.search(rf"\b{verb}\b", body) for verb in vars(contact.ContactLaw) if not verb.startswith("_"))


def spring(factor: float, name: str = "Cushion") -> type:
    """A class of this very name, as a cell that is run again makes it: k δ times a factor."""

    class Cushion(NamedTuple):
        stiffness: Annotated[float, contact.LINEAR_STIFFNESS]
        capped, needs_restitution = False, False
        begin = contact.undamped

        def force(self, memory, delta, rate, approaching):
            return factor * self.stiffness * delta

        def stored(self, delta, strength):
            return 0.5 * factor * self.stiffness * delta * delta

        plateau, ceiling, floor = contact.flat, contact.never_yields, contact.may_pull

    Cushion.__name__ = name
    return pr.contact_law(Cushion)


def test_a_class_defined_again_answers_with_its_own_numbers():
    """Where stored energy is four times as large, the depth is half; compiled, and each as its own interpretation."""
    for factor in (1.0, 4.0, 16.0, 1.0):
        law = _jit.lowered(spring(factor)(1e8))
        # From the exact depth the search is at its end, and another law's would walk away from it.
        exact = sqrt(2.0 * 1e3 / (factor * 1e8))
        assert depth_of(law, 1e3, exact) == exact


def test_lowered_models_stay_what_they_are():
    """A user's class gets a name of its own, once; a class of the package keeps its own, and so its cached kernels."""
    law = spring(1.0)(100_000_000)
    found = _jit.lowered(law)
    assert isinstance(found, type(law)) and found == law and type(found.stiffness) is float
    assert type(_jit.lowered(found)) is type(found) is type(_jit.lowered(law))
    assert type(found).__name__ != type(_jit.lowered(spring(1.0)(1e8))).__name__
    assert type(_jit.lowered(contact.Hertz(1e9))) is contact.Hertz


MODULE = """
from typing import Annotated, NamedTuple
import pounding_risk as pr
from pounding_risk.models.contact import laws as contact

@pr.contact_law
class Pad(NamedTuple):
    stiffness: Annotated[float, contact.LINEAR_STIFFNESS]
    capped, needs_restitution = False, False
    begin, plateau, ceiling, floor = contact.undamped, contact.flat, contact.never_yields, contact.may_pull
    def force(self, memory, delta, rate, approaching):
        return FACTOR * self.stiffness * delta
    def stored(self, delta, strength):
        return 0.5 * FACTOR * self.stiffness * delta * delta
"""


@pytest.mark.complete
def test_an_edited_module_answers_with_its_own_numbers(tmp_path):
    """Two sessions with one compile cache: nothing of a law from outside the package is kept there."""
    code = (
        "from pads import Pad\nfrom pounding_risk._jit.compile import lowered\n"
        "from pounding_risk.solver.pair.law_verbs import depth_of\n"
        "from pounding_risk.models.contact.laws import Linear\n"
        "print(depth_of(lowered(Pad(1e8)), 1e3, EXACT), depth_of(Linear(1e8), 1e3, 1.0) > 0.0)"
    )
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    kept = []
    for factor in (1.0, 4.0):
        (tmp_path / "pads.py").write_text(MODULE.replace("FACTOR", repr(factor)), "utf-8")
        exact = sqrt(2.0 * 1e3 / (factor * 1e8))
        told = python(code.replace("EXACT", repr(exact)), tmp_path, **cache)
        assert told.split() == [repr(exact), "True"]
        kept.append(sorted(file.name for file in (tmp_path / "cache").rglob("*depth_of*.nbc")))
    assert kept[0] == kept[1] and (len(kept[0]) == 1 or INTERPRETED)


def test_foreign_types_are_found_within_others():
    """A law inside a contact, inside a tuple; a package's own are not foreign."""
    numba = pytest.importorskip("numba")
    own, pair = spring(1.0)(1e8), NamedTuple("Pair", [("law", object), ("mass", float)])
    assert is_foreign(numba.typeof(own))
    assert is_foreign(numba.typeof((1.0, (contact.Linear(1e8), own))))
    assert is_foreign(numba.typeof(pair(contact.Linear(1e8), 1.0)))
    assert not is_foreign(numba.typeof((1.0, (contact.Linear(1e8), 2))))


SCENE = scene_text(
    single("frame", "44.36 t", "0.3 s"), rigid(), law="cushion", gap="5 mm", stiffness="93.5 MN/m", restitution=None
)


def test_scenes_know_a_law_once_it_is_defined(says):
    says(refusal(parse_scene, SCENE))
    law = spring(1.0)
    found = parse_scene(SCENE)
    assert found.law() == law(93.5e6) and type(found.law()) is law
    assert parse_scene(found.to_toml()) == found
    again = spring(2.0)  # the same scene then has the new class
    assert type(found.law()) is again is not law
    assert name_of(again) == "cushion"
    says(refusal(parse_scene, SCENE.replace("93.5 MN/m", "4.2e10 N/m^1.5")))
    assert "cushion" not in json.dumps(scene_schema())  # the schema is that of the package


def test_a_number_that_no_key_of_a_scene_has_is_no_silent_loss(says):
    """A run would take the default of the class; an interface with that default is what it says."""

    class Pad(NamedTuple):
        stiffness: Annotated[float, contact.HERTZ_STIFFNESS]
        pad: float = 0.01
        capped, needs_restitution = False, False
        begin, force, stored = contact.undamped, contact.hertz_force, contact.hertz_energy
        plateau, ceiling, floor = contact.flat, contact.never_yields, contact.may_pull

    pr.contact_law(Pad)
    assert pr.Interface(law=Pad(1e9)).contact_model == "pad"
    says(refusal(pr.Interface, law=Pad(1e9, pad=0.02)))


def test_a_law_may_derive_from_one_of_the_package(says):
    """Its name, its source and its relation are its own: nothing is known of its damping."""

    @pr.contact_law
    class Felt(contact.Jankowski):
        def begin(self, e, speed, mass):
            return 0.0

    assert LAWS["felt"] is Felt and name_of(Felt) == "felt"
    assert Felt.reference == "Felt, a law of the user's own" != contact.Jankowski.reference
    scene = SCENE.replace("cushion", "felt").replace("93.5 MN/m", "4.2e10 N/m^1.5")
    says(refusal(parse_scene, scene))
    exact = scene.replace("[records]", 'restitution = {value = 0.65, relation = "exact"}\n[records]')
    says(refusal(parse_scene, exact))
    says(refusal(pr.impact, Felt(1e9), 0.5, 570.0, restitution=0.65, relation="exact"))


def test_a_source_that_is_given_is_kept():
    class Foam(contact.Linear):
        reference = "Foam makers (2020), data sheet"

    assert pr.contact_law(Foam).reference == "Foam makers (2020), data sheet"


def test_hard_cases_are_those_of_the_package(says):
    spring(1.0)
    says(refusal(pr.stability, law=["cushion"]))


class Empty(NamedTuple):
    depth: float


class Plain:
    pass


class Bare(NamedTuple):
    stiffness: float
    depth: float
    capped, needs_restitution = False, False
    begin, force, plateau = contact.undamped, contact.hertz_force, contact.flat
    stored, ceiling, floor = contact.hertz_energy, contact.never_yields, contact.may_pull


class Kneed(NamedTuple):
    stiffness: Annotated[float, contact.HERTZ_STIFFNESS]
    knee: float = 0.001
    capped, needs_restitution = False, False
    begin, force, plateau = contact.undamped, contact.hertz_force, contact.flat
    stored, ceiling, floor = contact.hertz_energy, contact.never_yields, contact.may_pull


class Turned(contact.Hertz):
    def begin(self, speed, e, mass):
        return 0.0


class Broken(contact.Hertz):
    capped = True

    def force(self, memory, delta, rate, approaching):
        return self.stifness * delta

    def stored(self, delta, strength):
        return float("nan")


NO_LAWS = [Empty, Plain, type("Hertz", (contact.Hertz,), {}), Bare, Kneed, Turned, Broken]


@pytest.mark.parametrize("law", NO_LAWS, ids=lambda law: law.__name__)
def test_every_fault_of_a_law_is_told_at_once(law: type, says):
    """Verbs are tried once; what is refused is not known afterwards."""
    before = dict(LAWS)
    says(refusal(pr.contact_law, law))
    assert before == LAWS
