"""Python calls take a quantity with its unit wherever they take a number that has one, and refuse what is none."""

import tomllib
from dataclasses import asdict, is_dataclass

import pytest
import xarray as xr
from scenes import scene_text, single
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.row import row_case
from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.laws import Jankowski
from pounding_risk.streets.defaults import Rules
from pounding_risk.studies.histories import chosen, values_of
from pounding_risk.units import STANDARD_GRAVITY

G = STANDARD_GRAVITY
SCENE = scene_text(
    single("A", "44 t", "0.2 s", height="3 m"),
    single("B", "80 t", "0.1 s", height="3 m"),
    law="viscous_elastoplastic",
    gap="2 mm",
    records={"window": ["0 s", "3 s"], "pga": "0.5 g"},
    grid={"gap": ["2 mm", "8 mm"], "yield_force": ["50 kN", "inf"]},
)
ROW = SCENE.replace("[records]", "tolerance = '60 mm'\n[records]")  # a key of rows makes the pair one
LAW = Jankowski(2.75e9)


@pytest.fixture(scope="module")
def study():
    return pr.read_scene(tomllib.loads(SCENE))


@pytest.fixture(scope="module")
def results(study) -> xr.Dataset:
    return pr.scan(study, check_fraction=0.0)


@pytest.fixture(scope="module")
def row() -> xr.Dataset:
    return pr.scan(tomllib.loads(ROW), check_fraction="0 %")


def test_a_scene_may_be_a_dict(study, tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(SCENE)
    assert pr.read_scene(file) == pr.read_scene(tomllib.loads(SCENE) | {"scene": {"name": "scene"}})
    changed = pr.read_scene(tomllib.loads(SCENE), 'interface.gap="5 mm"')  # one override needs no list
    assert changed.gap == 0.005
    assert pr.validate(tomllib.loads(SCENE)).cases == 4
    assert pr.validate(tomllib.loads(SCENE), ['grid.gap=["1 mm"]']).changes
    with pytest.raises(PoundingError, match=r"building.A.mass.*is not a mass"):
        pr.read_scene({**tomllib.loads(SCENE), "building": [{"name": "A", "mass": []}, {"name": "B", "rigid": True}]})
    for wrong in (None, 3, []):
        assert "is no scene" in refusal(pr.read_scene, wrong)


# The call with a value, the value as text, and as the number in SI that it stands for.
CALLS = {
    "simulate: gap": (lambda study, _, value: pr.simulate(study, gap=value), "20 mm", 0.02),
    "simulate: yield_force": (lambda study, _, value: pr.simulate(study, yield_force=value), "200 kN", 2e5),
    "simulate: pga": (lambda study, _, value: pr.simulate(study, pga=value), "0.4 g", 0.4 * G),
    "gap": (lambda _, results, value: pr.assess(results, gap=value), "90 mm", 0.09),
    "impact: speed": (lambda *given: pr.impact(LAW, given[2], 570.0), "500 mm/s", 0.5),
    "impact: mass": (lambda *given: pr.impact(LAW, 0.5, given[2]), "0.57 t", 570.0),
    "impact: other_mass": (lambda *given: pr.impact(LAW, 0.5, 570.0, given[2]), "2 t", 2000.0),
    "impact: yield_force": (lambda *given: pr.impact(LAW, 0.5, 570.0, yield_force=given[2]), "2 kN", 2000.0),
    "impact: Jankowski: stiffness": (
        lambda *given: pr.impact(Jankowski(given[2]), 0.5, 570.0),
        "2.75e6 kN/m^1.5",
        2.75e9,
    ),
    "gap ": (lambda study, _, value: chosen(values_of(study, ["x"]), {"gap": [value]}), "8 mm", 0.008),
    "yield force": (lambda study, _, value: chosen(values_of(study, ["x"]), {"yield_force": [value]}), "50 kN", 5e4),
    "rules, storey_height": (lambda *given: Rules(storey_height=given[2]), "350 cm", 3.5),
    "rules, gap": (lambda *given: Rules(gap=given[2]), "20 mm", 0.02),
    "check_fraction": (lambda study, _, value: pr.scan(study, check_fraction=value).attrs["options"], "50 %", 0.5),
}


def whole(result) -> str:
    """Every digit of a result, NaN equal to NaN; results show a few facts of themselves at a prompt only."""
    return repr(asdict(result) if is_dataclass(result) else result)


@pytest.mark.parametrize("name", CALLS)
def test_text_with_a_unit_is_the_number_that_it_stands_for(name, study, results):
    call, text, number = CALLS[name]
    assert whole(call(study, results, text)) == whole(call(study, results, number))


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize(
    "wrong",
    ["20 apples", "abc", [], object(), float("nan"), -3.0],
    ids=lambda wrong: str(wrong) if isinstance(wrong, str | float) else type(wrong).__name__,
)
def test_what_is_no_quantity_is_refused_by_its_name(name, wrong, study, results):
    assert refusal(CALLS[name][0], study, results, wrong).startswith(f"{name.strip()}: ")


def test_cells_of_a_row_are_chosen_by_quantities(row):
    told = row_case(row, gap="8 mm", yield_force="50 kN")
    assert told.gaps == row_case(row, gap=0.008, yield_force=5e4).gaps == (0.008,)
    assert "gap: " in refusal(row_case, row, gap="8 kg")


def test_restitution_is_a_number_a_share_or_a_name():
    achieved = [pr.impact(LAW, 0.5, 570.0, restitution=e).restitution for e in ("65 %", "0.65", 0.65)]
    assert len(set(achieved)) == 1
    for wrong in (float("nan"), -1, 0.0, "steel", [], None):
        assert "restitution" in refusal(pr.impact, LAW, 0.5, 570.0, restitution=wrong)
    assert "is not a contact law" in refusal(pr.impact, "jankowski", 0.5, 570.0)


def test_names_that_are_no_text_are_refused(study):
    for wrong in (3, ["hertz"], object()):
        assert "is not a contact model" in refusal(pr.simulate, study, law=wrong)
    for wrong in ("2", 2.5, -1, True, ["2"]):
        with pytest.raises(PoundingError, match=r"workers is .* number of threads"):
            pr.scan(study, workers=wrong)


def test_equal_terms_that_no_stiffness_meets_are_told():
    """2.75 N/m^1.5 for 2.75e9: no linear stiffness above 100 N/m gives so small a force."""
    terms = 'interface.equal_terms={same="peak force", speed="0.5 m/s"}'
    asked = ['interface.stiffness="2.75 N/m^1.5"', terms, 'grid.contact_model=["viscous_elastoplastic", "linear"]']
    with pytest.raises(PoundingError, match=r"equal_terms: no stiffness of linear.*check interface\.stiffness"):
        pr.scan(pr.read_scene(tomllib.loads(SCENE), asked), check_fraction=0.0)
