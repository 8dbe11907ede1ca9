"""The identity of a study: what changes it, what does not, and in which words a difference is told."""

import doctest
import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
from processes import output
from scenes import FRAME, scene_text, single
from sentences import refusal

from pounding_risk.ensemble import identity as identities
from pounding_risk.ensemble.checkpoint.folder import About, Checkpoint
from pounding_risk.ensemble.identity import difference, difference_lines, digest, flattened, identity
from pounding_risk.ensemble.job import ScanInput
from pounding_risk.ensemble.job_choice import job_of
from pounding_risk.models.contact import laws as contact
from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.contact.register import law_digest
from pounding_risk.motions.motion import Motion
from pounding_risk.scene.motions import gathered
from pounding_risk.scene.reader import parse_scene

SCENE = scene_text(
    FRAME,
    single("masonry", "82.60 t", "0.1 s"),
    name="A pair",
    law="linear",
    gap="20 mm",
    stiffness="4.2e7 N/m",
    records={"names": ["RSN6-180", "RSN6-270"]},
    grid={"gap": ["0 mm", "5 mm", "1.0 m"]},
)


class Asked(NamedTuple):
    """What is to be computed."""

    study: Any
    motions: tuple[Motion, ...]
    screening: bool = True
    check_fraction: float = 0.0


CHANGED = (
    "pounding_risk: its source was changed since, in what numbers depend on (_jit, models, motions, scene, solver, "
    "ensemble, results, units.py)"
)


@pytest.fixture(autouse=True)
def laws() -> Iterator[None]:
    """Laws that a test makes known are forgotten after it."""
    kept = dict(LAWS)
    yield
    LAWS.clear()
    LAWS.update(kept)


def motion(name: str = "A", factor: float = 1.0, sha256: str = "aa", dt: float = 0.01) -> Motion:
    """A ground motion of few samples."""
    steps = ("mean removed", f"scaled by {factor:g}")
    return Motion(name, factor * np.array([0.0, 1.0, -0.5, 0.0]), dt, {"id": name, "sha256": sha256}, steps)


def asked(*overrides: str, motions: tuple[Motion, ...] = (), **choices: Any) -> Asked:
    """The scene with some changes."""
    return Asked(parse_scene(SCENE, "scene.toml", list(overrides)), motions or (motion(), motion("B")), **choices)


def told(one: Asked, other: Asked) -> list[str]:
    """Differences; the digests differ exactly where there is one."""
    old, new = identity(one), identity(other)
    found = difference(old, new)
    assert (digest(old) != digest(new)) == bool(found)
    assert difference(json.loads(json.dumps(old)), new) == found  # read back from a file it says the same
    return found


def test_what_asks_for_the_same_numbers_has_one_identity():
    """A quantity in another unit, the scene's text and its file do not count, nor that it was changed by a --set."""
    study = parse_scene(SCENE.replace('"20 mm"', '"2 cm"') + "# a comment\n", "other.toml", [])
    assert told(asked(), asked()._replace(study=study)) == []
    assert told(asked('interface.gap="25 mm"'), asked()._replace(study=study.updated(gap=0.025))) == []


def test_numbers_of_numpy_are_numbers():
    """As a search hands them over that makes its studies in Python."""
    study = asked().study
    numbers = {"rtol": np.float64(1e-6), "plastic_exponent": np.float64(study.interfaces[0].plastic_exponent)}
    same = study.updated(gap=np.float64(0.02), **numbers)
    assert told(asked(), asked()._replace(study=same)) == []
    assert told(asked(), asked(check_fraction=np.float64(0.0), screening=np.bool_(True))) == []
    assert difference({"options": {"a": np.int64(1)}}, {"options": {"a": 1}}) == []


GAPS = [f"{gap} mm" for gap in range(40)]
ANOTHER = [*GAPS[:17], "17.5 mm", *GAPS[18:]]
CHANGES = {
    "a gap": ['interface.gap="25 mm"'],
    "two keys": ['building.frame.damping="2 %"', "solver.rtol=1e-7"],
    "a grid that is shorter": ['grid.gap=["0 mm", "5 mm"]'],
    "a grid that was not there": ['grid.pga=["0.5 g", "1 g"]'],
    "a grid that is long": [f"grid.gap={json.dumps(GAPS)}"],
}


@pytest.mark.parametrize("overrides", CHANGES.values(), ids=CHANGES)
def test_a_changed_scene_is_told_key_by_key(overrides, says):
    says(told(asked(), asked(*overrides)))


def test_of_many_differences_the_first_are_listed():
    one, other = ({"scene": {"building": [{"period": period} for period in range(at, at + 20)]}} for at in (0, 1))
    lines = difference_lines(one, other).splitlines()[1:]
    assert lines == [*(f"  - building[{at}].period: was {at}, is {at + 1}" for at in range(8)), "  - and 12 more"]
    assert difference_lines(one, one) == ""


def test_long_lists_are_told_by_their_first_difference(says):
    long, another, longer = (asked(f"grid.gap={json.dumps(one)}") for one in (GAPS, ANOTHER, [*GAPS, "1 m"]))
    says(told(long, another), told(long, longer))


RECORDS = {
    "other bytes": (motion(), motion("B", sha256="bb")),
    "another scale": (motion(factor=2.0), motion("B")),
    "another time step": (motion(dt=0.005), motion("B")),
    "one less": (motion(),),
    "one more": (motion(), motion("B"), motion("C")),
    "another order": (motion("B"), motion()),
    "one twice": (motion(), motion("B"), motion()),
}


@pytest.mark.parametrize("motions", RECORDS.values(), ids=RECORDS)
def test_changed_records_are_told_by_name(motions, says):
    says(told(asked(), asked(motions=motions)))


def test_options_and_program_count(monkeypatch, says):
    says(told(asked(), asked(screening=False, check_fraction=0.01)))
    old = identity(asked())
    monkeypatch.setattr(identities, "package_digest", lambda: "another")
    assert difference(old, identity(asked())) == [CHANGED]
    newer = {**old, "program": {**old["program"], "numba": "9.0"}}
    assert difference(old, newer) == [f'numba: was "{old["program"]["numba"]}", is "9.0"']


def test_another_kind_of_processor_is_told_where_nothing_else_differs():
    """Libraries that choose their ways by processor give other last digits: parts of both would not fit together."""
    old, new = identity(asked(), "one"), identity(asked(), "another")
    (sentence,) = difference(old, new)
    assert "OPENBLAS_CORETYPE" in sentence and digest(old) != digest(new)


def test_a_title_counts_for_nothing():
    renamed = parse_scene(SCENE).updated(name="another title")
    assert told(asked(), asked()._replace(study=renamed)) == []


@pytest.mark.parametrize("effects", ["", 'soil_flexibility = {shear_wave_velocity = "200 m/s", radius = "8 m"}'])
def test_what_is_prepared_is_told_to_the_last_digit(effects):
    """One unit in the last place of one damping ratio is another preparation."""
    study = parse_scene(f"{SCENE}[effects]\n{effects}\n")  # an effect on buildings makes a row of a pair
    first, *others = study.buildings
    motions = gathered(study).motions
    once, again = (job_of(ScanInput(study, motions)).prepared for _ in range(2))
    assert once == again
    changed = first._replace(damping=float(np.nextafter(first.damping, 1.0)))
    assert job_of(ScanInput(study.updated(buildings=(changed, *others)), motions)).prepared != once


def test_the_digest_of_the_package_covers_what_computes(tmp_path, monkeypatch):
    """An edited command changes nothing, an edited kernel and an edited scan do."""
    for name in ("ensemble/identity.py", "cli/new.py", "ensemble/new.py", "solver/pair/grid.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("before", encoding="utf-8")
    monkeypatch.setattr(identities, "__file__", str(tmp_path / "ensemble" / "identity.py"))
    digests = [identities.package_digest()]
    for name in ("cli/new.py", "ensemble/new.py", "solver/pair/grid.py"):
        (tmp_path / name).write_text("after", encoding="utf-8")
        digests.append(identities.package_digest())
    assert digests[0] == digests[1] and len(set(digests)) == 3


@pytest.mark.complete
def test_a_comment_in_a_report_does_not_stop_a_half_done_scan(tmp_path, monkeypatch, says):
    """One in the ensemble does, with a reason that a user can read."""
    source = tmp_path / "pounding_risk"
    without = shutil.ignore_patterns("records", "__pycache__")
    shutil.copytree(Path(identities.__file__).parents[1], source, ignore=without)
    monkeypatch.setattr(identities, "__file__", str(source / "ensemble" / "identity.py"))

    def go_on():
        with Checkpoint.open(tmp_path / "results.study", identity(asked()), About(batches=10, width=1)) as checkpoint:
            if not checkpoint.done():
                checkpoint.keep(range(0, 4), {"raw": np.zeros((4, 1))}, 0.1)
            return checkpoint.done()

    assert go_on() == [range(0, 4)]
    for name in ("reports/html", "reports/explorer", "figures/style", "cli/__init__", "assessment/assess"):
        with open(source / f"{name}.py", "a", encoding="utf-8") as file:
            file.write("# A comment.\n")
    assert go_on() == [range(0, 4)]
    with open(source / "ensemble" / "threads.py", "a", encoding="utf-8") as file:
        file.write("# A comment.\n")
    says(refusal(go_on))


def test_examples_in_docstrings_are_right():
    assert doctest.testmod(identities).failed == 0
    nested = {"a": {"b": {}}, "c": [], "d": [{"e": 1}, {"e": [2, 3]}]}
    assert flattened(nested) == {"a.b": {}, "c": [], "d[0].e": 1, "d[1].e": [2, 3]}


CELL = """
from typing import Annotated, NamedTuple
import pounding_risk as pr
from pounding_risk.errors import PoundingError
from pounding_risk.models.contact import laws as contact
FACTOR = {factor}
def share(delta):
    return {share} * delta
@pr.contact_law
class Cushion(NamedTuple):
    stiffness: Annotated[float, contact.LINEAR_STIFFNESS]
    softness: float = {softness}
    capped, needs_restitution = False, False
    begin = contact.undamped
    def force(self, memory, delta, rate, approaching):
        return FACTOR * self.stiffness * share(delta) {formula}
    def stored(self, delta, strength):
        return 0.5 * self.stiffness * delta * delta
    plateau, ceiling, floor = contact.flat, contact.never_yields, contact.may_pull
"""
PLAIN = {"factor": 1.0, "share": 1.0, "softness": 0.5, "formula": ""}


def cell(**changed: Any) -> type:
    """A law as a notebook's cell defines it; run again with another number where one is given."""
    names: dict[str, Any] = {"__name__": "__main__"}
    exec(compile(CELL.format(**{**PLAIN, **changed}), "cell", "exec", dont_inherit=True), names)
    return names["Cushion"]


def test_a_law_of_ones_own_is_told_by_its_code():
    """Each kind of edit changes the digest; the same cell run again, further down and in use, does not."""
    plain = cell()
    before = law_digest(plain)
    for _ in range(1000):  # the interpreter rewrites the code of what is called often
        plain(1e8).force(0.0, 1e-3, 0.1, True)
    assert law_digest(plain) == law_digest(cell()) == before
    edits = [{"factor": 2.0}, {"share": 1}, {"softness": 0.6}, {"formula": "* 2.0"}, {"formula": "* delta"}]
    assert len({before, *(law_digest(cell(**edit)) for edit in edits)}) == 1 + len(edits)
    names: dict[str, Any] = {"__name__": "__main__"}
    exec(compile("\n\n\n# moved\n" + CELL.format(**PLAIN), "other", "exec", dont_inherit=True), names)
    assert law_digest(names["Cushion"]) == before


def test_a_law_of_ones_own_is_told_the_same_in_another_process():
    code = "from pounding_risk.models.contact.register import law_digest\nprint(law_digest(Cushion))"
    assert output("-c", CELL.format(**PLAIN) + code).strip() == law_digest(cell())


def test_a_closure_counts_with_what_it_holds():
    def spring(factor: float) -> type:
        class Spring(NamedTuple):
            stiffness: Annotated[float, contact.LINEAR_STIFFNESS]
            capped, needs_restitution = False, False

            def force(self, memory, delta, rate, approaching):
                return factor * self.stiffness * delta

        return Spring

    assert law_digest(spring(1.0)) == law_digest(spring(1.0)) != law_digest(spring(2.0))


def test_an_edited_law_is_told_where_the_scene_runs_it():
    cell()
    one = identity(asked('grid.contact_model=["linear", "cushion"]'))
    assert list(one["laws"]) == ["cushion"] and identity(asked())["laws"] == {}
    cell(formula="* 2.0")
    other = identity(asked('grid.contact_model=["linear", "cushion"]'))
    changed = "contact model cushion: its code, which is not this program's own, was changed since"
    assert difference(one, other) == [changed]
