"""Fragilities in NRML and for pelicun: what a reader of the file finds is the fitted curve."""

import csv
import json
from dataclasses import replace
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from scipy import stats
from sweeps import sweep

import pounding_risk as pr
from pounding_risk.render.sheet import strength
from pounding_risk.reports.exports._fragilities import Intensity, _curve
from pounding_risk.units import STANDARD_GRAVITY

SPACE = {"n": "http://openquake.org/xmlns/nrml/0.5"}


def model_of(file) -> Xml.Element:
    """The fragility model of a file."""
    root = Xml.parse(file).getroot()
    assert root.tag == f"{{{SPACE['n']}}}nrml"
    (model,) = root
    return model


def lognormal_of(params: Xml.Element) -> tuple[float, float]:
    """Median and dispersion from the mean and deviation of the intensity itself, held against SciPy's lognormal."""
    mean, deviation = float(params.get("mean")), float(params.get("stddev"))
    dispersion = np.sqrt(np.log1p((deviation / mean) ** 2))
    median = mean / np.exp(0.5 * dispersion**2)
    known = stats.lognorm(dispersion, scale=median)
    assert (known.mean(), known.std()) == pytest.approx((mean, deviation), rel=1e-12)
    return median, dispersion


@pytest.mark.parametrize("kind", ["contact", "yield"])
def test_the_curves_are_those_of_the_assessment(results, tmp_path, kind):
    written = pr.export(results, "nrml", tmp_path / "f.xml", of=kind, intensity="pga")
    model = model_of(written.files[0])
    interface = pr.assess(results, intensity="pga").interfaces[0]
    gap = interface.gap if kind == "contact" else interface.yield_gap
    fitted = [one for one in interface.fragility if one.what == kind and one.gap == gap and not one.fault]
    functions = model.findall("n:fragilityFunction", SPACE)
    assert len(functions) == len(fitted) > 0
    for function, one in zip(functions, fitted, strict=True):
        assert function.find("n:imls", SPACE).get("imt") == "PGA"
        median, dispersion = lognormal_of(function.find("n:params", SPACE))
        # 16 digits are written; two exponentials and a logarithm are rounded.
        assert (median * STANDARD_GRAVITY, dispersion) == pytest.approx((one.median, one.dispersion), rel=1e-12)
    state = model.find("n:limitStates", SPACE).text
    assert {params.get("ls") for params in model.iter(f"{{{SPACE['n']}}}params")} == {state}


def test_probabilities_at_intensities_are_those_of_the_curve(results, tmp_path):
    pr.export(results, "nrml", tmp_path / "c.xml", intensity="sa(1 s)")
    pr.export(results, "nrml", tmp_path / "d.xml", intensity="sa(1 s)", discrete=True)
    (params,) = model_of(tmp_path / "c.xml").iter(f"{{{SPACE['n']}}}params")
    median, dispersion = lognormal_of(params)
    (imls,) = model_of(tmp_path / "d.xml").iter(f"{{{SPACE['n']}}}imls")
    (poes,) = model_of(tmp_path / "d.xml").iter(f"{{{SPACE['n']}}}poes")
    assert imls.get("imt") == "SA(1)"
    levels, shares = (np.array(element.text.split(), dtype=float) for element in (imls, poes))
    # Eight digits of each probability are written.
    assert shares == pytest.approx(stats.norm.cdf(np.log(levels / median) / dispersion), rel=1e-7)
    assert (np.diff(levels) > 0.0).all() and shares[0] < 1e-4 and shares[-1] > 1.0 - 1e-4


def test_identifiers_are_those_that_nrml_allows(results, tmp_path):
    pr.export(results, "nrml", tmp_path / "f.xml", of="yield", intensity="pga")
    names = [function.get("id") for function in model_of(tmp_path / "f.xml").iter(f"{{{SPACE['n']}}}fragilityFunction")]
    assert names and len(set(names)) == len(names)
    for name in names:
        assert set(name) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_") and len(name) <= 100


def test_columns_with_a_strength_of_their_own_are_called_as_in_the_tables(results):
    fitted = next(one for one in pr.assess(results, intensity="pga").interfaces[0].fragility if one.what == "yield")
    curve = _curve(replace(fitted, yield_force=np.inf), Intensity("PGA", "g", STANDARD_GRAVITY, "pga"))
    assert f"under {fitted.contact_model} at F_E {strength(np.inf)['text']}, " in curve.words


def test_a_description_tells_the_error_of_the_fit(results, tmp_path):
    written = pr.export(results, "nrml", tmp_path / "f.xml", intensity="pga")
    words = model_of(tmp_path / "f.xml").find("n:description", SPACE).text
    assert "standard error of its logarithm" in words and "pounding-risk" in words
    assert any("no uncertainty of the buildings" in sentence for sentence in written.notes)


def with_dispersions(damaged, *values):
    """The damage states of the frame with other dispersions with pounding, of the slight and the moderate one."""
    changed = damaged.copy(deep=True)
    for state, value in zip(("slight, cracks", "moderate"), values, strict=True):
        changed["dispersion"].loc[{"state": state, "pounding": "with"}] = value
    return changed


@pytest.mark.parametrize("without", [False, True])
def test_states_of_one_demand_are_limit_states_in_order(results, damaged, tmp_path, without):
    asked = {"of": "damage", "intensity": "pga", "without": without}
    written = pr.export(results, "nrml", tmp_path / "f.xml", **asked)
    names = [file.name for file in written.files]
    # Without pounding no force acts between buildings, and one model is left, which has the name itself.
    expected = ["f.xml"] if without else ["f-floor-displacement-of-a-frame.xml", "f-contact-force.xml"]
    assert names == expected
    assert any(sentence.startswith("blow, without pounding: no curve") for sentence in written.notes) == without
    model = model_of(written.files[0])
    assert model.find("n:limitStates", SPACE).text.split() == ["slight-cracks", "moderate"]
    (function,) = model.findall("n:fragilityFunction", SPACE)
    assert function.get("id") == "floor-displacement-of-a-frame"
    side = "without" if without else "with"
    for params, state in zip(function.findall("n:params", SPACE), ("slight, cracks", "moderate"), strict=True):
        one = damaged.sel(state=state, pounding=side)
        median, dispersion = lognormal_of(params)
        assert median * STANDARD_GRAVITY == pytest.approx(float(one["median"]), rel=1e-12)
        assert dispersion == pytest.approx(float(one["dispersion"]), rel=1e-12)
        low, high = (float(function.find("n:imls", SPACE).get(name)) for name in ("minIML", "maxIML"))
        assert low <= median * np.exp(-3.99 * dispersion) and high >= median * np.exp(3.99 * dispersion)
    words = model.find("n:description", SPACE).text
    assert f"{side} pounding" in words and ("gap 60 mm" in words) != without


def test_curves_that_cross_are_models_of_their_own(damaged, tmp_path):
    medians = damaged["median"].sel(pounding="with", state=["slight, cracks", "moderate"]).values / STANDARD_GRAVITY
    written = pr.export(with_dispersions(damaged, 0.3, 0.6), "nrml", tmp_path / "f.xml", discrete=True)
    assert len(written.files) == 3
    states = [model_of(file).find("n:limitStates", SPACE).text for file in written.files]
    assert states == ["slight-cracks", "moderate", "blow"]
    # Where both curves have the same argument: by bisection, not by the closed form.
    low, high = 1e-3, float(medians[0])
    for _ in range(60):
        middle = 0.5 * (low + high)
        apart = np.log(middle / medians[0]) / 0.3 - np.log(middle / medians[1]) / 0.6
        low, high = (middle, high) if apart < 0.0 else (low, middle)
    assert any(f"cross at PGA {middle:.3g} g" in sentence for sentence in written.notes)
    together = pr.export(with_dispersions(damaged, 0.4, 0.4), "nrml", tmp_path / "g.xml", discrete=True)
    assert len(together.files) == 2 and not any("cross" in sentence for sentence in together.notes)
    first, second = (
        np.array(poes.text.split(), dtype=float) for poes in model_of(together.files[0]).iter(f"{{{SPACE['n']}}}poes")
    )
    assert (first >= second).all() and first[0] < 1e-4 and second[-1] > 1.0 - 1e-4


def test_openquake_reads_the_same_curve(results, tmp_path):
    """Where its engine is installed, which no extra of this project brings."""
    nrml = pytest.importorskip("openquake.hazardlib.nrml")
    pytest.importorskip("openquake.risklib.read_nrml")
    pr.export(results, "nrml", tmp_path / "f.xml", intensity="pga")
    model = nrml.to_python(str(tmp_path / "f.xml"))
    (functions,) = model.values()
    one = pr.assess(results, intensity="pga").interfaces[0]
    (fitted,) = (curve for curve in one.fragility if curve.what == "contact" and curve.gap == one.gap)
    (built,) = functions.build(model.limitStates, 50, 0)
    levels = np.linspace(0.5, 2.0, 7) * fitted.median / STANDARD_GRAVITY
    assert built(levels) == pytest.approx(fitted.probability(levels * STANDARD_GRAVITY), rel=1e-9)


@pytest.mark.parametrize("discrete", [False, True])
def test_openquake_reads_the_same_states(results, damaged, tmp_path, discrete):
    """Where its engine is installed, which no extra of this project brings."""
    nrml = pytest.importorskip("openquake.hazardlib.nrml")
    pytest.importorskip("openquake.risklib.read_nrml")
    scientific = pytest.importorskip("openquake.risklib.scientific")
    for without in (False, True):
        asked = {"of": "damage", "intensity": "pga", "without": without, "discrete": discrete}
        file = pr.export(results, "nrml", tmp_path / "f.xml", **asked).files[0]
        model = nrml.to_python(str(file))
        assert model.limitStates == ["slight-cracks", "moderate"]
        (functions,) = model.values()
        built = functions.build(model.limitStates, 50, 0)
        for function, state in zip(built, ("slight, cracks", "moderate"), strict=True):
            one = damaged.sel(state=state, pounding="without" if without else "with")
            median, dispersion = float(one["median"]) / STANDARD_GRAVITY, float(one["dispersion"])
            # Between its levels the engine takes straight lines for a discrete curve.
            levels = np.array(functions.imls) if discrete else median * np.array([0.5, 0.8, 1.0, 1.5])
            exact = stats.norm.cdf(np.log(levels / median) / dispersion)
            assert function(levels) == pytest.approx(exact, rel=1e-7 if discrete else 1e-9, abs=1e-12)
        # The engine's shares without damage, slight and moderate. Those below 1e-7 it takes for 0: of curves that cross
        # the negative ones too, so that they would no more come to 1.
        shares = scientific.scenario_damage(built, levels)
        reached = [function(levels) for function in built]
        assert shares == pytest.approx(np.array([1.0 - reached[0], reached[0] - reached[1], reached[1]]), abs=1e-7)
        assert shares.sum(axis=0) == pytest.approx(1.0, abs=2e-7)


FRAME = "PND.damage.floor_displacement_of_a_frame"


@pytest.fixture(scope="module")
def written(results, tmp_path_factory):
    """Demands at 0.3 g, and fragilities against PGA."""
    return pr.export(results, "pelicun", tmp_path_factory.mktemp("p") / "demands", pga="0.3 g", intensity="pga")


def rows_of(written, name="fragility.csv") -> list[dict[str, str]]:
    """The rows of a written table by the names of its columns."""
    (file,) = (file for file in written.files if file.name == name)
    with file.open(newline="") as text:
        return list(csv.DictReader(text))


def test_medians_and_dispersions_are_those_of_the_assessment(results, damaged, written):
    rows = {row["ID"]: row for row in rows_of(written)}
    one = pr.assess(results, intensity="pga").interfaces[0]
    expected = {}
    for curve in one.fragility:
        if curve.what == "contact" and curve.gap == one.gap:
            expected["PND.contact.a_frame_wall_gap_60_mm"] = [(curve.median, curve.dispersion)]
        if curve.what == "yield" and not curve.fault:
            name = f"PND.yield.a_frame_wall_gap_60_mm_viscous_elastoplastic_FE_{curve.yield_force / 1e3:g}_kN"
            expected[name] = [(curve.median, curve.dispersion)]
    for side in ("with", "without"):
        states = [damaged.sel(state=state, pounding=side) for state in ("slight, cracks", "moderate")]
        expected[f"{FRAME}.{side}"] = [(float(state["median"]), float(state["dispersion"])) for state in states]
    blow = damaged.sel(state="blow", pounding="with")
    expected["PND.damage.contact_force.with"] = [(float(blow["median"]), float(blow["dispersion"]))]
    assert set(rows) == set(expected)
    for name, curves in expected.items():
        row = rows[name]
        assert (row["Demand-Type"], row["Demand-Unit"]) == ("Peak Ground Acceleration", "g")
        # Not directional would be 1.2 times the demand.
        assert (row["Incomplete"], row["Demand-Offset"], row["Demand-Directional"]) == ("0", "0", "1")
        for number, (median, dispersion) in enumerate(curves, start=1):
            assert row[f"LS{number}-Family"] == "lognormal"
            assert float(row[f"LS{number}-Theta_0"]) * STANDARD_GRAVITY == pytest.approx(median, rel=1e-14)
            assert float(row[f"LS{number}-Theta_1"]) == dispersion
        assert len(curves) == 2 or row["LS2-Theta_0"] == ""
    words = json.loads(written.files[-1].read_text(encoding="utf-8"))
    assert set(words) == {"_GeneralInformation", *expected}
    assert "with pounding" in words[f"{FRAME}.with"]["LimitStates"]["LS2"]["DS2"]["Description"]


@pytest.mark.complete
def test_the_demand_of_fragilities_is_in_every_file_of_demands(results, written, tmp_path):
    for name in ("a-frame-with-contact.csv", "wall-without-contact.csv"):
        units, *rows = rows_of(written, name)
        assert units["1-PGA-0-1"] == "mps2"
        assert [float(row["1-PGA-0-1"]) for row in rows] == pytest.approx([0.3 * STANDARD_GRAVITY] * 8, rel=1e-12)
    other = pr.export(results, "pelicun", tmp_path / "sa", pga="0.3 g", intensity="sa(1 s)")
    assert {row["Demand-Type"] for row in rows_of(other)} == {"Spectral Acceleration|1"}
    _, *rows = rows_of(other, "a-frame-with-contact.csv")
    at = results["record_spectral_acceleration"].interp(period=1.0)  # linear: near enough to tell a wrong motion
    expected = np.repeat((at / results["record_pga"]).values, 2) * 0.3 * STANDARD_GRAVITY
    assert [float(row["1-SA_1-0-1"]) for row in rows] == pytest.approx(expected, rel=0.02)


def test_damage_states_alone(results, damaged, tmp_path):
    written = pr.export(damaged, "pelicun", tmp_path / "of-damage")
    assert [file.name for file in written.files] == ["fragility.csv", "fragility.json"]
    assert {row["ID"].split(".")[1] for row in rows_of(written)} == {"damage"}
    asked = {"pga": "0.3 g", "intensity": "pga", "of": "yield"}
    assert len(rows_of(pr.export(results, "pelicun", tmp_path / "of-yielding", **asked))) == 2
    # One side without a curve is told.
    blow = damaged.sel(state=["blow"])
    told = pr.export(blow, "pelicun", tmp_path / "of-blow", of="damage").notes
    assert any(sentence.startswith("damage without pounding: the results hold no fragility") for sentence in told)


@pytest.mark.parametrize(("to", "name"), sweep([("nrml", "f.xml"), ("pelicun", "folder")], ("pelicun", "folder")))
def test_the_method_of_damage_states_is_an_option_and_is_said(results, damaged, to, name, tmp_path):
    """Both formats alike: the method that `damage` was run with, and no amplitude, which such curves need not."""
    written = pr.export(results, to, tmp_path / name, of="damage", intensity="pga", method="ida")
    said = "curves of damage states: ida, maximum likelihood of the intensity"
    assert any(sentence.startswith(said) for sentence in written.notes), written.notes
    usual = pr.export(damaged, to, tmp_path / f"usual-{name}", of="damage").notes
    assert any(sentence.startswith("curves of damage states: stripes, maximum likelihood of") for sentence in usual)
    if to == "pelicun":
        assert any(each.startswith("no demands are written") and "--pga" not in each for each in written.notes)
        curve = pr.damage(results, intensity="pga", method="ida").sel(state="moderate", pounding="with")
        (row,) = (row for row in rows_of(written) if row["ID"] == f"{FRAME}.with")
        assert float(row["LS2-Theta_0"]) * STANDARD_GRAVITY == pytest.approx(float(curve["median"]), rel=1e-14)


def test_pelicun_samples_the_states_of_the_curves(written):
    """Where it is installed, which no extra of this project brings: demands and fragilities to damage, end to end."""
    assessment = pytest.importorskip("pelicun.assessment")
    pandas = pytest.importorskip("pandas")
    folder, rows, blocks = written.files[0].parent, rows_of(written), 500
    asked = assessment.Assessment({"PrintLog": False, "Seed": 1})
    asked.stories = 1
    asked.demand.load_sample(str(folder / "a-frame-with-contact.csv"))
    names = [row["ID"] for row in rows]
    about = {"Units": "ea", "Location": "0", "Direction": "1", "Theta_0": 1.0, "Blocks": blocks}
    asked.asset.load_cmp_model({"marginals": pandas.DataFrame(about, index=pandas.Index(names))})
    asked.asset.generate_cmp_sample(8)
    asked.damage.load_model_parameters([str(folder / "fragility.csv")], set(names))
    asked.damage.calculate()
    sample = asked.damage.ds_model.sample
    for row in rows:
        curves = [(float(row[f"LS{n}-Theta_0"]), float(row[f"LS{n}-Theta_1"])) for n in (1, 2) if row[f"LS{n}-Theta_0"]]
        reached = [1.0, *(stats.lognorm.cdf(0.3, dispersion, scale=median) for median, dispersion in curves), 0.0]
        for state, share in enumerate(-np.diff(reached)):
            of_motions = sample[(row["ID"], "0", "1", "0", str(state))].mean()  # share of the blocks
            error = np.sqrt(share * (1.0 - share) / (8 * blocks))
            assert of_motions == pytest.approx(share, abs=4.0 * error + 1e-12)
