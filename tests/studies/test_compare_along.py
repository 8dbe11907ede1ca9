"""A comparison of contact models along axes of numbers, and in a row whose interfaces have models of their own."""

import json
import sys
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from axes import WHEN, pair_text, row_text
from commands import done, refused, run
from figure_words import words_of
from sentences import refusal
from test_compare import made_up as compared
from uncertain import uncertain_text

import pounding_risk as pr
from pounding_risk import figures
from pounding_risk.figures.compare import agreement_figure, ratio_limits, ratio_ticks, reference_figure
from pounding_risk.questions.compare import sheet
from pounding_risk.render.terminal import print_sheet
from pounding_risk.reports.sections import models
from pounding_risk.results.attributes import SCENE_AXES
from pounding_risk.results.files import open_results
from pounding_risk.results.scene_axes import at_one_place, axis_text, selected
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.scene_axis import SceneAxis
from pounding_risk.scene.values import OF_EACH_INTERFACE
from pounding_risk.scene.variants import Variants
from pounding_risk.studies import compare as study_of_laws
from pounding_risk.studies import compare_findings
from pounding_risk.studies.compare import Request, comparable_models, with_equal_terms
from pounding_risk.studies.compare_along import along_finding, keys_along
from pounding_risk.studies.compare_findings import of_interface

LAWS = ["jankowski", "kelvin_voigt", "viscous_elastoplastic"]
PERIOD, RESTITUTION = "building.left.period", "interface.restitution"


@pytest.fixture(scope="module")
def text() -> str:
    return pair_text({PERIOD: ["0.3 s", "0.5 s", "0.7 s"], RESTITUTION: [0.5, 0.8]}, {"yield_force": ["3 MN", "inf"]})


@pytest.fixture(scope="module")
def whole(text) -> xr.Dataset:
    return pr.compare(parse_scene(text), laws=LAWS)


def equals_the_loop(text: str, whole: xr.Dataset, **options) -> None:
    """Each place has the variables and attributes of the comparison of `--set` there, but the history of one case."""
    study = parse_scene(text)
    variants = Variants(study)
    for number in range(variants.count):
        values = variants.overrides(number)
        here, alone = at_one_place(selected(whole, values)), pr.compare(parse_scene(text, overrides=values), **options)
        assert set(alone.variables) - set(here.variables) == {"history", "time"}
        assert not set(here.variables) - set(alone.variables)
        for name in map(str, here.variables):
            found, expected = here[name], alone[name]
            if "impact_step" in found.dims:  # padded to the longest impact of any place
                steps = expected.sizes["impact_step"]
                assert found.isel(impact_step=slice(steps, None)).isnull().all()
                found = found.isel(impact_step=slice(steps))
            assert (found.dims, found.dtype, str(found.attrs)) == (expected.dims, expected.dtype, str(expected.attrs))
            assert np.array_equal(found, expected, equal_nan=found.dtype.kind == "f"), name
        assert sorted(json.loads(here.attrs.pop("overrides"))) == sorted(json.loads(alone.attrs.pop("overrides")))
        for key in {*here.attrs, *alone.attrs} - set(WHEN):
            assert str(here.attrs.get(key)) == str(alone.attrs.get(key)), key


@pytest.mark.complete
def test_a_product_of_axes_equals_the_loop(text, whole):
    equals_the_loop(text, whole, laws=LAWS)
    findings = {
        at_one_place(selected(whole, Variants(parse_scene(text)).overrides(at))).attrs["finding"] for at in (0, 5)
    }
    assert len(findings) == 2  # the places differ, so that they cannot be exchanged
    assert whole["ratio_median"].sizes[RESTITUTION] == 2 and RESTITUTION not in whole["reduced_mass"].dims


def test_axes_of_a_row_that_move_together_equal_the_loop():
    axes = {"building.B.mass": ["200 t", "300 t"], "building.B.period": ["0.3 s", "0.5 s"]}
    text = row_text(axes | {"zip": [list(axes)]})
    options = {"laws": ["jankowski", "kelvin_voigt"], "relation": "published", "speed": 0.3}
    along = pr.compare(parse_scene(text), **options)
    equals_the_loop(text, along, **options)
    assert keys_along(along) == list(axes) and along["reduced_mass"].dims == ("building.B.mass", "interface")
    sentence = along.attrs["finding"]
    assert "both places" in sentence or "of 2 places" in sentence
    assert "building.B.mass = 200 t, building.B.period = 0.3 s" in sentence or "0.5 s" in sentence


def test_a_speed_that_is_an_axis_is_that_of_each_place():
    terms = 'equal_terms = {same = "peak force", speed = "0.5 m/s"}\n[records]'
    text = pair_text({"interface.equal_terms.speed": ["0.2 m/s", "0.8 m/s"]}).replace("[records]", terms)
    along = pr.compare(parse_scene(text), laws=LAWS[:2])
    equals_the_loop(text, along, laws=LAWS[:2])
    assert "speed" not in along.attrs
    assert at_one_place(along.isel({"interface.equal_terms.speed": [1]})).attrs["speed"] == 0.8


@pytest.mark.complete
def test_what_is_the_same_at_all_places_is_computed_once(text, monkeypatch):
    """The reference impacts depend on mass and restitution: of two periods and two restitutions there are two sets."""
    calls = []
    own = study_of_laws.reference_impacts
    monkeypatch.setattr(
        study_of_laws, "reference_impacts", lambda scene, stiffness: calls.append(scene) or own(scene, stiffness)
    )
    pr.compare(parse_scene(text), laws=LAWS[:2])
    assert len(calls) == 2


def test_laws_that_cannot_be_had_at_one_place_are_left_out_at_all():
    study = parse_scene(pair_text({RESTITUTION: [0.2, 0.65, 0.8]}))
    equal, reasons = with_equal_terms(study, Request())
    scenes = [Variants(study).scene(number) for number in range(3)]
    common = set.intersection(*(set(comparable_models(scene)) for scene in scenes))
    assert set(equal.grid.contact_models) == common and "bilinear" in set(comparable_models(scenes[1])) - common
    assert "bilinear: bilinear returns no e below 0.354" in reasons["left_out"]
    assert f"(at 1 of 3 places, the first {RESTITUTION} = 0.2)" in reasons["left_out"]
    assert "tabulated: the scene gives no table of forces" in reasons["left_out"]
    assert (equal.relation, reasons["unequal_e"]) == ("exact", "")


def test_one_relation_holds_at_all_places():
    """Where a law asked for has no exact one at a place, the published one holds everywhere, and why is told."""
    study = parse_scene(pair_text({RESTITUTION: [0.65, 0.2]}))
    equal, reasons = with_equal_terms(study, Request(laws=("jankowski", "bilinear")))
    variants = Variants(equal)
    assert [variants.scene(number).relation for number in range(2)] == ["published"] * 2
    assert reasons["unequal_e"].startswith("bilinear returns no e below 0.354")
    assert reasons["unequal_e"].endswith(f"(at 1 of 2 places, the first {RESTITUTION} = 0.2)")


def test_what_is_refused_at_some_places_is_told_with_the_first(says):
    study = parse_scene(pair_text({RESTITUTION: [0.65, 0.2]}))
    asked = Request(laws=("jankowski", "bilinear"), relation="exact")
    says(refusal(with_equal_terms, study, asked), refusal(with_equal_terms, study, Request(laws=("jankowski", "herz"))))


def test_one_place_is_the_comparison_of_the_scene_there():
    text = pair_text({PERIOD: ["0.4 s"]})
    one = pr.compare(parse_scene(text), laws=LAWS[:2])
    alone = pr.compare(parse_scene(text, overrides=(f"{PERIOD}='0.4 s'",)), laws=LAWS[:2])
    assert "history" in one and PERIOD not in one.dims
    assert one.attrs["finding"] == alone.attrs["finding"]
    assert np.array_equal(one["history"], alone["history"])


def test_samples_of_uncertain_numbers_are_refused(says):
    says(refusal(pr.compare, parse_scene(uncertain_text()), laws=LAWS[:2]))


# ------------------------------------------------------------------------------------------------ what is said
def made_up(factors: list[float], touching: list[bool]) -> xr.Dataset:
    """A comparison at places along a mass: under "other" the force is so many times as large, in contact or not."""
    parts, of_all = [], ["peak_displacement", "peak_floor_acceleration", "dissipates", "capped"]
    for factor, touched in zip(factors, touching, strict=True):
        one = compared(("base", "other")).isel(record=slice(3), gap=[0], yield_force=[1]).copy(deep=True)
        one["peak_contact_force"][{"contact_model": 1}] *= factor
        one["impact_count"][:] = 2 if touched else 0
        pair = one.drop_vars(of_all).expand_dims(interface=["left | right"]).transpose(..., "interface")
        one = pair.assign(one[of_all])
        parts.append(one.assign(compare_findings.tables(one, "base")))
    axis = SceneAxis(("building.left.mass",), (tuple(f"{100 + 50 * at} t" for at in range(len(factors))),))
    whole = xr.concat(parts, "building.left.mass", join="exact")
    masses = ("building.left.mass", [1e5 + 5e4 * at for at in range(len(factors))], {"units": "kg"})
    attrs = {"baseline": "base", "title": "made up", "same": "peak force", "speed": 0.5, "reference_law": "base"}
    return whole.assign_coords({"building.left.mass": masses}).assign_attrs(attrs | {SCENE_AXES: axis_text([axis])})


FINDINGS = {
    "matters at two of three": ([1.5, 1.05, 0.5], [True, True, True]),
    "no contact at one of two": ([1.05, 0.95], [True, False]),
    "no contact at any": ([1.5, 1.5], [False, False]),
    "the same at all": ([1.5, 1.5, 1.5], [True, True, True]),
    "nearly the same at all": ([1.5, 1.5, 1.4], [True, True, True]),
}


@pytest.mark.parametrize("words", FINDINGS)
def test_the_finding_tells_where_the_model_matters_and_where_most(words, says):
    says(along_finding(made_up(*FINDINGS[words])))


@pytest.mark.complete
def test_a_place_has_the_numbers_of_its_tables(whole, capsys):
    rows = sheet(whole)[-1]["rows"]
    keys = [[cell["text"] for cell in row[:2]] for row in rows]
    assert keys[:3] == [["0.3 s", "0.5"], ["0.3 s", "0.8"], ["0.5 s", "0.5"]]
    for row, at in zip(rows, np.ndindex(3, 2), strict=True):
        here = whole.isel(dict(zip((PERIOD, RESTITUTION), at, strict=True)))
        count = here["impact_count"].sel(contact_model="jankowski")
        assert row[2]["text"] == f"{int((count > 0).sum())} of {count.size}"
        (low, high), law = row[4]["parts"], row[4]["text"].partition("(")[2].removesuffix(")")
        cell = here.sel(output="peak contact force", contact_model=law)
        assert (low, high) == (float(cell["ratio_low"]), float(cell["ratio_high"]))
        others = here.sel(output="peak contact force")
        assert max(high, 1.0 / low) >= float(others["ratio_high"].max())
        assert max(high, 1.0 / low) >= 1.0 / float(others["ratio_low"].min())
    print_sheet(sheet(whole))
    told = capsys.readouterr().out
    assert whole.attrs["finding"] in told and "Comparison on equal terms at each place" in told
    assert told.count(" of 8 ") == 6 and "terms are equal at one speed only" in told


# ------------------------------------------------------------------------------------------------ figure
@pytest.mark.complete
def test_the_figure_has_a_line_for_each_law_with_its_bounds(whole):
    part = whole.isel({RESTITUTION: [1]})
    figure = figures.results_figure(part)
    panel = figure.axes[1]
    lines = {line.get_label(): line for line in panel.get_lines()}
    bands = iter(panel.collections)
    for law in LAWS[1:]:
        cell = part.isel({RESTITUTION: 0}).sel(output="peak contact force", contact_model=law)
        np.testing.assert_array_equal(lines[law].get_ydata(), cell["ratio_median"])
        np.testing.assert_array_equal(lines[law].get_xdata(), [0.3, 0.5, 0.7])
        heights = next(bands).get_paths()[0].vertices[:, 1]
        assert heights.max() == float(cell["ratio_high"].max()) and heights.min() == float(cell["ratio_low"].min())
    assert panel.get_title() == "peak contact force" and panel.get_xlabel() == f"{PERIOD} [s]"
    counted = figure.axes[5].get_lines()[0].get_ydata()
    touched = part["impact_count"].sel(contact_model="jankowski") > 0
    np.testing.assert_array_equal(counted, touched.transpose(PERIOD, ...).values.reshape(3, -1).sum(axis=1))
    words = words_of(figure).replace("\n", " ")
    assert along_finding(part).partition(";")[0] in words and "8 cases a law at each place" in words


def test_figures_of_one_place_and_of_more_than_one_axis(whole, says):
    says(refusal(figures.agreement_along_figure, whole), refusal(figures.agreement_figure, whole))
    here = whole.sel({PERIOD: 0.5, RESTITUTION: 0.8})
    says(refusal(figures.agreement_along_figure, here))
    figure = figures.results_figure(here)
    assert len(figure.axes) == 6  # no history
    assert at_one_place(here).attrs["finding"].split(";")[0] in words_of(figure).replace("\n", " ")


def test_a_law_beyond_the_scale_is_told():
    """As one on terms of its own may be, whose force is many times the baseline's."""
    made = made_up([1.2, 1.3, 1.4], [True] * 3)
    made["ratio_median"][{"contact_model": 1, "output": 1}] = [14.0, 12.0, 16.0]
    figure = figures.agreement_along_figure(made)
    told = [[text.get_text() for text in axis.texts] for axis in figure.axes[:2]]
    assert told == [[""], ["beyond: other, 12.00 to 16.00"]]


def test_values_along_an_axis_that_are_texts_are_points():
    """Of what has no order no line tells a course."""
    axis = SceneAxis(("interface.restitution",), (("concrete", "steel"),))
    made = made_up([1.5, 0.5], [True, True]).rename({"building.left.mass": "interface.restitution"})
    made = made.assign_coords({"interface.restitution": ["concrete", "steel"]})
    made = made.assign_attrs({SCENE_AXES: axis_text([axis])})
    panel = figures.agreement_along_figure(made).axes[1]
    line = next(line for line in panel.get_lines() if line.get_label() == "other")
    assert line.get_linestyle() == "None" and list(line.get_ydata()) == [1.5, 0.5]
    assert [label.get_text() for label in panel.get_xticklabels()] == ["concrete", "steel"]


@pytest.mark.parametrize("low", [0.1, 0.5, 0.6, 0.72, 0.8])
@pytest.mark.parametrize("high", [1.2, 1.3, 1.45, 1.9, 2.5, 10.0])
def test_ratios_have_three_to_six_ticks(low, high):
    limits = ratio_limits([low], [high])
    ticks = ratio_ticks(limits)
    assert 3 <= len(ticks) <= 6 and 1.0 in ticks and ticks == sorted(set(ticks))
    assert limits[0] <= ticks[0] and ticks[-1] <= limits[1]


# ------------------------------------------------------------------------------------------------ command
COMPARE = ("compare", "--law", "jankowski", "--law", "kelvin_voigt")


@pytest.fixture
def scene(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    text = pair_text({PERIOD: ["0.3 s", "0.5 s"], RESTITUTION: [0.5, 0.8]})
    Path("s.toml").write_text(text, encoding="utf-8")
    return Path("s.toml")


@pytest.mark.complete
def test_the_command_prints_writes_draws_and_chooses(scene):
    told = done(*COMPARE, scene, "-o", "c.nc", "--figure", "c.png", "--select", f"{RESTITUTION}=0.8")
    done(*COMPARE, scene, "-o", "c.nc", "--select", f"{RESTITUTION}=0.8")  # of the same study
    other = refused(*COMPARE, scene, "-o", "c.nc", "--select", f"{RESTITUTION}=0.5")
    assert "interface[0].restitution.value: was 0.8, is 0.5" in other
    stored = open_results(Path("c.nc"))
    assert stored.attrs["finding"] in told.stdout and stored["ratio_high"].dims[0] == PERIOD
    assert RESTITUTION not in stored.dims and Path("c.png").stat().st_size
    assert "With --select of one value along each axis all tables of that place are shown" in told.stdout
    one = done(*COMPARE, scene, "-o", "one.nc", "--select", f"{RESTITUTION}=0.8", "--select", f"{PERIOD}=300 ms")
    same = done(*COMPARE, scene, "-o", "set.nc", "--set", f"{RESTITUTION}=0.8", "--set", f"{PERIOD}=0.3 s")
    assert one.stdout.replace("one.nc", "set.nc") == same.stdout and "Ratio to jankowski" in one.stdout


def test_a_report_has_the_finding_and_a_row_for_each_place(whole):
    data = SimpleNamespace(pairs=(), laws=["jankowski"], others={"compare": whole}, results=whole)
    _, _, finding, *others, table = blocks = models.write(data)
    assert blocks[2:] == sheet(whole)
    assert finding["text"] == whole.attrs["finding"] and others[0]["rows"][0][0] == "equal terms"
    assert len(table["rows"]) == 6 and table["rows"][0][0]["text"] == "0.3 s"


@pytest.mark.parametrize("command", ["effects", "accuracy"])
def test_commands_of_one_scene_take_a_place_by_its_values(scene, monkeypatch, command):
    """They get the scene that `--set` of the values makes."""
    studies = []
    module = import_module(f"pounding_risk.lab.{command}")
    monkeypatch.setattr(module, command, lambda study, *_, **__: studies.append(study) or sys.exit(0))
    place = f"{RESTITUTION}=0.8", f"{PERIOD}=0.3 s"
    for option in ("--select", "--set"):
        run(command, scene, option, place[0], option, place[1])
    assert studies[0] == studies[1] and not studies[0].axes and studies[0].buildings[0].period == 0.3


MODELS = ("jankowski", "viscous_elastoplastic")  # without a cap, and with one
FAR = 10.0  # m, never closed


def mixed_scene(gaps: tuple[float, float], models: tuple[str, str] = MODELS) -> pr.Scene:
    """Three masses, and what stands between them."""
    return pr.Scene(
        [pr.SingleMass("A", 2e5, 0.5), pr.SingleMass("B", 1e5, 0.21), pr.SingleMass("C", 3e5, 0.33)],
        [
            pr.Interface(gap, model, "2.75e9 N/m^1.5", restitution=0.6, yield_force=force)
            for gap, model, force in zip(gaps, models, (8e5, 5e5), strict=True)
        ],
        pr.Records(["RSN6-180"], window=[0.0, "5 s"], pga="0.4 g"),
    )


def scanned(one: pr.Scene, **options):
    return one.scan(check_fraction=0.0, **options)


@pytest.mark.parametrize("place", [0, 1])
def test_where_one_interface_never_closes_it_is_a_row_of_the_other_model(place):
    gaps = (0.01, FAR) if place == 0 else (FAR, 0.01)
    mixed, alone = scanned(mixed_scene(gaps)), scanned(mixed_scene(gaps, (MODELS[place],) * 2))
    assert mixed["contact_model"].values.tolist() == [OF_EACH_INTERFACE]
    assert mixed["interface_contact_model"].values.tolist() == list(MODELS)
    assert int(mixed["impact_count"].sum()) > 0
    for name in mixed.data_vars:
        assert mixed[name].values.tobytes() == alone[name].values.tobytes(), name


def test_both_touch_and_the_law_with_a_cap_alone_keeps_it():
    some = scanned(mixed_scene((0.005, 0.005)).replace(yield_force=["300 kN", "700 kN", "inf"]))
    counts = some["impact_count"].isel(yield_force=0).values.ravel()
    assert (counts > 0).all()
    assert float(some["energy_residual"].max()) < 1e-6
    # The law without a cap is pressed beyond F_E, and counted; the one with a cap never transmits more.
    peak, forces = some["peak_contact_force"].squeeze(), some["yield_force"].values
    capped = peak.isel(interface=1).values
    assert (capped[:2] <= forces[:2] * (1 + 1e-9)).all() and capped[2] > forces[0]
    free = peak.isel(interface=0).values
    reached = some["yield_exceedance"].squeeze().isel(interface=0).values
    np.testing.assert_array_equal(reached, (free >= forces).astype(int))
    assert reached[0] == 1


@pytest.mark.complete
def test_a_comparison_is_calibrated_to_the_model_of_each_interface():
    """Where the other interface never closes, it is the comparison of a row of the one model."""
    for place, own in enumerate(MODELS):
        gaps = (0.005, FAR) if place == 0 else (FAR, 0.005)
        mixed = pr.compare(mixed_scene(gaps), laws=["hertz_damp"])
        alone = pr.compare(mixed_scene(gaps, (own, own)), laws=["hertz_damp"])
        assert mixed.attrs["baseline"] == mixed.attrs["reference_law"] == OF_EACH_INTERFACE
        here, there = (one.isel(interface=place) for one in (mixed, alone))
        assert int(here["impact_count"].min()) > 0
        for name in ("stiffness", "reference_peak_force", "peak_contact_force", "flips", "judged"):
            assert here[name].values.tobytes() == there[name].values.tobytes(), name
        assert mixed["ratio_median"].values.tobytes() == alone["ratio_median"].values.tobytes()
        moved = f"against {OF_EACH_INTERFACE}, peak contact force, {'A | B' if place == 0 else 'B | C'} is"
        assert mixed.attrs["finding"].startswith(f"The model matters here: {moved}")


def test_a_comparison_of_stiffnesses_in_two_units(capsys):
    """k beside β: every interface calibrates to its own, in its own unit."""
    row = mixed_scene((0.005, 0.005)).replace(
        'interface.2.contact_model="kelvin_voigt"', 'interface.2.stiffness="1e8 N/m"'
    )
    compared = pr.compare(row, laws=["hertz_damp", "kelvin_voigt"])
    own = compared.sel(contact_model=OF_EACH_INTERFACE)
    assert own["stiffness"].values.tolist() == [2.75e9, 1e8]
    assert [str(of_interface(compared, place)["stiffness_unit"].values[-1]) for place in (0, 1)] == ["N/m^1.5", "N/m"]
    forces = compared["reference_peak_force"].values
    np.testing.assert_allclose(forces, np.broadcast_to(forces[:, -1:], forces.shape), rtol=1e-6)
    assert compared["stiffness"].sel(contact_model="kelvin_voigt").values[1] == 1e8
    print_sheet(sheet(compared, "B | C"))
    assert f"Ratio to {OF_EACH_INTERFACE}" in capsys.readouterr().out
    for figure in (agreement_figure(compared), reference_figure(compared, interface="A | B")):
        assert "no force against" not in words_of(figure)
