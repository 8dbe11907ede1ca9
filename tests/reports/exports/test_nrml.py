"""Fragilities in NRML: what a reader of the file finds is the fitted curve."""

from __future__ import annotations

from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from scenes import BOTH, scene_text, single
from scipy import stats

import pounding_risk as pr
from pounding_risk.errors import PoundingError
from pounding_risk.units import STANDARD_GRAVITY

RECORDS = ["RSN6-180", "RSN753-000", "CCC-HN1", "NAPA-HNE"]
SPACE = {"n": "http://openquake.org/xmlns/nrml/0.5"}


@pytest.fixture(scope="module")
def results():
    """A pair whose contact under four motions, at three amplitudes, is not the same."""
    text = scene_text(
        single("a frame", "500 t", "1.0 s", damping=0.05),
        single("wall", "800 t", "0.5 s", damping=0.05),
        records={
            "names": ["RSN6-180", "RSN753-000", "CCC-HN1", "NAPA-HNE"],
            "polarity": BOTH,
            "window": ["0 s", "30 s"],
        },
        grid={"pga": ["0.1 g", "0.3 g", "0.6 g"], "yield_force": ["2 MN", "4 MN"]},
        law="viscous_elastoplastic",
        gap="60 mm",
        yield_force="4 MN",
    )
    return pr.scan(pr.read_scene(text))


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


def test_a_description_tells_the_error_of_the_fit(results, tmp_path):
    written = pr.export(results, "nrml", tmp_path / "f.xml", intensity="pga")
    words = model_of(tmp_path / "f.xml").find("n:description", SPACE).text
    assert "standard error of its logarithm" in words and "pounding-risk" in words
    assert any("no uncertainty of the buildings" in sentence for sentence in written.told)


def test_what_has_no_name_elsewhere_is_refused(results, tmp_path):
    with pytest.raises(PoundingError, match="write a period among them, or pga"):
        pr.export(results, "nrml", tmp_path / "f.xml", intensity="sa(1 s, 2 %)")
    with pytest.raises(PoundingError, match="hold no fragility of contact: one recording has no dispersion"):
        pr.export(results.isel(pga=[1], record=[0], polarity=[0]), "nrml", tmp_path / "f.xml", intensity="pga")
    with pytest.raises(PoundingError, match=r'"nmrl" is no format \(did you mean "nrml"\?\)'):
        pr.export(results, "nmrl", tmp_path / "f.xml")
    with pytest.raises(PoundingError, match=r"a file that ends in \.xml"):
        pr.export(results, "nrml", tmp_path / "f.txt")
    with pytest.raises(PoundingError, match="--of: 'collapse' is none"):
        pr.export(results, "nrml", tmp_path / "f.xml", of="collapse")
    assert not list(tmp_path.iterdir())


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
