"""The accessor ``pounding`` of datasets: the public calls as methods, one case by its values, and what it shows."""

import inspect
import tomllib
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import xarray as xr
from figure_words import words_of
from processes import output
from scenes import BOTH, scene_text, single
from sentences import refusal
from sweeps import sweep

import pounding_risk as pr
from pounding_risk.errors import PoundingError
from pounding_risk.figures.of_results import FIGURES, SUBJECTS
from pounding_risk.results.accessor import Pounding
from pounding_risk.units import STANDARD_GRAVITY

NAME = "A <b>pair</b> & more"
SCENE = scene_text(
    single("A <1>", "44 t", "0.2 s", height="3 m"),
    single("B", "80 t", "0.1 s", height="3 m"),
    name=NAME,
    law="viscous_elastoplastic",
    gap="2 mm",
    yield_force="100 kN",
    records={"names": ["RSN6-180", "RSN1690-090"], "window": ["0 s", "3 s"], "polarity": BOTH},
    grid={"gap": ["2 mm", "8 mm"], "yield_force": ["50 kN", "100 kN", "inf"], "pga": ["0.3 g", "0.5 g"]},
)
ROW = SCENE.replace("[records]", "tolerance = '60 mm'\n[records]").replace('"0.3 g", "0.5 g"', '"0.5 g"')
# The public call that each method is.
CALLS = {
    "assess": pr.assess,
    "setbacks": pr.setbacks,
    "damage": pr.damage,
    "report": pr.report,
    "figure": pr.figures.results_figure,
    "separations": pr.code_table,
    "summary": pr.summary,
    "view": pr.view,
    "draw": pr.draw,
    "animate": pr.animate,
    "save": pr.save,
}
OF_CASE = {"record": "RSN6-180", "polarity": "reversed", "pga": "0.5 g", "gap": "8 mm", "yield_force": "50 kN"}


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    return pr.scan(SCENE, check_fraction=0.0)


@pytest.fixture(scope="module")
def row() -> xr.Dataset:
    return pr.scan(ROW, check_fraction=0.0)


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return pr.simulate(SCENE, pga="0.5 g")


@pytest.mark.complete
def test_a_dataset_that_is_opened_has_it_without_another_import(results, tmp_path):
    """And no solver is needed to sum it up."""
    path = pr.save(results, tmp_path / "results.nc")
    code = "import sys; sys.modules['numba'] = None; import pounding_risk as pr; path = sys.argv[1]; "
    told = output("-c", code + "print(pr.open_results(path).pounding, pr.summary(path).counts['cases'])", path)
    assert told.startswith("<results of scan>\n") and NAME in told
    assert told.endswith(f" {results['status'].size}\n")


@pytest.mark.parametrize("name", CALLS)
def test_a_method_is_the_public_call_without_its_first_argument(results, name):
    method, function = getattr(results.pounding, name), CALLS[name]
    _, *others = inspect.signature(function).parameters.values()
    assert list(inspect.signature(method).parameters.values()) == others
    assert method.__doc__ == function.__doc__
    assert getattr(Pounding, name) is function


def test_methods_answer_as_the_calls_do(results, tmp_path):
    pounding, asked = results.pounding, {"gap": "90 mm", "pga": 0.5 * STANDARD_GRAVITY}
    assert pounding.assess(**asked).as_dict() == pr.assess(results, **asked).as_dict()
    assert pr.open_results(pounding.save(tmp_path / "again.nc")).identical(results)


def test_one_case_is_the_one_with_these_values(results):
    case = results.pounding.case(**OF_CASE)
    by_hand = results.sel(record="RSN6-180", polarity="reversed", gap=0.008, yield_force=5e4)
    assert case.identical(by_hand.isel(pga=1, contact_model=0))
    in_si = OF_CASE | {"pga": 0.5 * STANDARD_GRAVITY, "gap": 0.008, "yield_force": 5e4}
    assert results.pounding.case(**in_si).identical(case)
    assert case.pounding.case().identical(case), "what was selected is found again"
    assert case.pounding.case(gap="8 mm").identical(case)
    assert case.pounding.assess().interfaces[0].at == "at PGA 0.5 g"


@pytest.mark.parametrize("made", ["results", "row"])
def test_what_is_left_out_is_as_in_simulate(made, request):
    """The run and the case have the same contacts; the case of the scan comes from the compiled grid."""
    results = request.getfixturevalue(made)
    case = results.pounding.case(pga="0.5 g")
    assert {name: case[name].item() for name in ("record", "polarity", "gap", "yield_force")} == {
        "record": "RSN6-180",
        "polarity": "as recorded",
        "gap": 0.002,
        "yield_force": 1e5,
    }
    simulated = pr.simulate(SCENE if made == "results" else ROW, pga="0.5 g")
    assert int(case["impact_count"].sum()) == simulated.sizes["contact"] > 0


CASES = {
    "a gap of another grid": {"gap": "3 mm", "pga": "0.5 g"},
    "a gap in kg": {"gap": "3 kg", "pga": "0.5 g"},
    "an unknown record": {"record": "RSN6-18", "pga": "0.5 g"},
    "no amplitude": {},
}


@pytest.mark.parametrize("asked", CASES.values(), ids=CASES)
def test_a_case_that_is_not_there_is_told_with_what_is(results, asked, says):
    says(refusal(results.pounding.case, **asked))


def test_a_level_that_is_not_named_is_asked_for_by_its_own_name(says):
    """``intensity`` is that of fragilities: `--intensity 0.5` would be no level."""
    levels = {"intensity": {"measure": "scale", "levels": [0.5, 2.0]}, "window": ["0 s", "3 s"]}
    results = pr.scan(scene_text(law="linear", records=levels), check_fraction=0.0)
    says(refusal(results.pounding.case))


def test_the_scene_s_own_value_is_not_replaced_by_a_near_one(results, run, says):
    """The scene's gap is 2 mm: where the grid has lost it, none is guessed. A run has no cases."""
    says(
        refusal(results.assign_coords(gap=[0.003, 0.008]).pounding.case, pga="0.5 g"),
        refusal(results.isel(pga=0, drop=True).pounding.case, pga="0.5 g"),
        refusal(run.pounding.case, gap="2 mm"),
        refusal(run.pounding.assess),
    )


@pytest.mark.complete
def test_each_dataset_has_its_usual_figure(results, row, run):
    usual = {
        "scan": (results, pr.figures.scan_figure),
        "row": (row, pr.figures.scan_figure),
        "run": (run, pr.figures.simulation_figure),
    }
    for dataset, function in usual.values():
        assert words_of(dataset.pounding.figure(note="Of my own.")) == words_of(function(dataset, "Of my own."))
    assert words_of(row.pounding.figure("profiles", gap="8 mm", buildings=["B"])) == words_of(
        pr.figures.profiles_figure(pr.row_case(row, gap="8 mm"), ["B"])
    )
    assessed = results.pounding.figure("assessment", gap="90 mm", pga="0.3 g")
    assert words_of(assessed) == words_of(pr.figures.assessment_figure(pr.assess(results, gap="90 mm", pga="0.3 g")))


@pytest.mark.parametrize("kind", sweep(["scan", "ratio", "separations", "elevation", "plan"], "ratio"))
def test_each_figure_of_a_row_can_be_drawn_by_its_name(row, kind):
    assert words_of(row.pounding.figure(kind))


def test_each_figure_s_name_is_that_of_its_function():
    names = {name for of_call in FIGURES.values() for name in of_call}
    assert all(callable(getattr(pr.figures, f"{name}_figure")) for name in names) and set(SUBJECTS) <= names
    text = inspect.getdoc(pr.figures.results_figure)
    assert all(f'"{name}"' in text for name in names)


def test_the_page_names_every_figure_and_call():
    page = (Path(__file__).parents[2] / "docs" / "results.md").read_text("utf-8")
    assert [name for of_call in FIGURES.values() for name in of_call if f'"{name}"' not in page] == []
    methods = [name for name, each in vars(Pounding).items() if type(each).__name__ == "_Method"]
    assert methods and [name for name in methods if f"`.{name}(" not in page] == []


FIGURES_ASKED = {
    "an unknown figure": {"kind": "elevatoin"},
    "a figure of another command": {"kind": "simulation"},
    "an unknown option": {"kind": "elevation", "gapp": 1.0},
    "an option of another figure": {"gap": "8 mm"},
}


@pytest.mark.parametrize("asked", FIGURES_ASKED.values(), ids=FIGURES_ASKED)
def test_an_unknown_figure_or_option_is_told_with_the_known_ones(row, asked, says):
    says(refusal(lambda: row.pounding.figure(**asked)))


def test_separations_of_a_row_are_those_of_the_interface_that_is_named(row, says):
    name = "A <1> | B"
    assert row.pounding.separations(interface=name).as_dict() == pr.code_table(row.isel(interface=[0])).as_dict()
    says(refusal(row.pounding.separations, interface="A | C"))


def test_a_dataset_that_is_not_of_the_package_gets_a_sentence(says):
    other = xr.Dataset({f"v{number}": ("x", [1.0]) for number in range(5)})
    says([refusal(getattr(other.pounding, method)) for method in ("assess", "figure", "case", "summary")])
    assert "was not made by pounding_risk" in repr(other.pounding)
    assert ElementTree.fromstring(other.pounding._repr_html_()) is not None


@pytest.mark.parametrize(
    ("made", "facts"),
    [
        (
            "results",
            {
                "scene": NAME,
                "buildings": "A <1> | B",
                "record": "RSN6-180, RSN1690-090",
                "PGA": "0.3 g, 0.5 g",
                "gap": "2 mm, 8 mm",
                "yield force": "50 kN, 100 kN, inf",
                "contact model": "viscous_elastoplastic",
            },
        ),
        ("run", {"scene": NAME, "gap": "2 mm", "yield force": "100 kN", "PGA": "0.5 g", "status": "complete"}),
    ],
)
def test_it_shows_a_short_table(made, facts, request):
    dataset = request.getfixturevalue(made)
    shown = dict(dataset.pounding.facts())
    assert {name: shown[name] for name in facts} == facts
    assert ".pounding.figure()" in shown["go on with"]
    text = repr(dataset.pounding)
    assert len(text.splitlines()) <= 16 and all(words in text for words in facts.values())
    html = dataset.pounding._repr_html_()
    table = ElementTree.fromstring(html)  # well-formed, so that names with markup stay text
    assert [cell.text for cell in table.iter("td")] == list(shown.values())
    # It takes the colours of the page that it stands on, light or dark.
    assert "background" not in html and html.count("color") == html.count("color:inherit") > 0


def test_cases_are_counted_but_not_where_that_takes_long(results, monkeypatch):
    known = dict(results.pounding.facts())["cases"]
    simulated = int((results["simulated"] == 1).sum())
    assert known == f"{results['status'].size}, {simulated} simulated, {results['status'].size} complete"
    failed = results.assign(status=results["status"].where(results["gap"] > 0.002, 1))
    half = results["status"].size // 2
    assert dict(failed.pounding.facts())["cases"].endswith(f"{half} complete")
    monkeypatch.setattr("pounding_risk.results.accessor.MOST_COUNTED", 3)
    assert dict(results.pounding.facts())["cases"] == f"{half * 2}; .summary() counts those that are complete"


def test_datasets_of_the_other_calls_say_what_they_are_and_are_drawn(tmp_path, says):
    small = [*('grid.yield_force=["100 kN"]', 'grid.gap=["2 mm"]', 'grid.pga=["0.5 g"]'), 'records.names=["RSN6-180"]']
    scene = pr.read_scene(SCENE, small)
    made = {
        "compare": pr.compare(scene, laws=["jankowski", "viscous_elastoplastic"]),
        "accuracy": pr.accuracy(scene, cases=1, budget=0.1, scipy=False),
        "effects": pr.effects(pr.read_scene(tomllib.loads(SCENE) | {"effects": {"permanent_set": {}}}, small)),
        "histories": pr.open_results(pr.histories(scene, tmp_path / "runs.nc", polarities=["reversed"])),
    }
    for kind, dataset in made.items():
        assert dataset.pounding.kind == kind
        assert repr(dataset.pounding).startswith(f"<results of {kind}>\n  scene")
        if kind == "histories":
            says(refusal(dataset.pounding.figure))
        else:
            assert words_of(dataset.pounding.figure())
        assert f"a dataset of `{kind}`" in refusal(dataset.pounding.assess)
    assert made["histories"].pounding.case()["displacement"].dims[-1] == "sample"
    jankowski = made["compare"].pounding.case(contact_model="jankowski", polarity="reversed")
    assert jankowski["peak_contact_force"].size == 1


def test_the_text_of_a_scene_is_a_scene():
    """With line breaks, or a table in one line; a path has neither."""
    assert pr.read_scene(SCENE) == pr.read_scene(tomllib.loads(SCENE))
    assert "interface" in refusal(pr.read_scene, "[[building]]")
    with pytest.raises(PoundingError, match=r"no such file|does not exist|cannot be read"):
        pr.read_scene("scene-that-is-not-there.toml")
    assert pr.read_scene(SCENE, "interface.gap='5 mm'").gap == 0.005
