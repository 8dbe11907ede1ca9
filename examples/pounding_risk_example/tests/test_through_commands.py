"""The extensions as a user meets them: through commands, scenes and the datasets that come of them."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from pounding_risk_example import laws
from typer.testing import CliRunner

import pounding_risk as pr
from pounding_risk.cli import app

ORIGIN = "pounding-risk-example 0.1.0"
SCENE = """
[[building]]
name = "low"
mass = "40 t"
period = "0.2 s"
damping = 0.05
[[building]]
name = "high"
mass = "80 t"
period = "0.5 s"
damping = 0.05
[[interface]]
gap = "5 mm"
contact_model = "viscous_elastoplastic"
stiffness = "2.75e9 N/m^1.5"
restitution = 0.65
yield_force = "450 kN"
[[records.generated]]
kind = "half_sine"
pga = "1 g"
length = "0.3 s"
"""
TWO_LAWS = 'grid.contact_model=["hunt_crossley", "twin"]'


@pytest.fixture(autouse=True)
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A scene file in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    return "scene.toml"


def run(*words: str) -> str:
    """The output of a command that ends well."""
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    return result.output


def test_they_are_listed_with_their_origin(scene):
    listed = run("models")
    assert listed.count(ORIGIN) == 7 and listed.count("loaded") == 7
    assert "Hunt and Crossley (1975)" in listed and "an example, no measurement" in listed
    assert "half_sine" in run("records", "list", "--generated")
    assert run("--help").splitlines()[-1].split()[0] == "period-ratio"
    assert run("period-ratio", scene) == "low to high: 0.4\n"
    known = json.loads(run("schema"))["$defs"]
    assert "hunt_crossley" in known["InterfaceTable"]["properties"]["contact_model"]["enum"]
    assert "weathered" in known["EffectsTable"]["properties"]


def test_a_scan_is_that_of_the_same_law_from_a_script(scene):
    """To the last bit; the dataset says where the law and the motion are from."""
    source = Path(laws.__file__).read_text("utf-8").replace("HuntCrossley", "Twin")
    exec(compile(source, "script", "exec"), {"__name__": "script"})
    results = pr.scan(scene_with(TWO_LAWS), check_fraction=0.0)
    first, second = (results.sel(contact_model=name) for name in ("hunt_crossley", "twin"))
    numbers = [name for name, variable in results.data_vars.items() if variable.dtype.kind in "fiu"]
    assert float(first["impact_count"].max()) > 0 and len(numbers) > 10
    for name in numbers:
        assert np.array_equal(first[name], second[name], equal_nan=True), name
    told = {"contact law hunt_crossley": ORIGIN, "kind of motion half_sine": ORIGIN}
    assert json.loads(results.attrs["plugins"]) == told
    assert json.loads(results.attrs["versions"])["pounding-risk-example"] == "0.1.0"
    assert set(json.loads(results.attrs["own_laws"])) == {"hunt_crossley", "twin"}


def test_effect_rule_and_format_through_commands(scene):
    run("scan", scene, "-o", "plain.nc", "--set", 'interface.yield_force="360 kN"')
    run("scan", scene, "-o", "weathered.nc", "--set", "effects.weathered={share = 0.8}")
    plain, weathered = (pr.open_results(Path(name)) for name in ("plain.nc", "weathered.nc"))
    force, expected = (float(results["peak_contact_force"].max()) for results in (weathered, plain))
    assert force == pytest.approx(expected, rel=1e-9) and force > 3.5e5
    assert json.loads(weathered.attrs["plugins"])["effect weathered"] == ORIGIN
    assert set(json.loads(weathered.attrs["own_laws"])) == {"effect weathered"}
    run("export", "plain.nc", "--to", "contact_json", "-o", "contact.json")
    assert json.loads(Path("contact.json").read_text("utf-8"))["contact"] == {"0.005": 1.0}
    ruled = run("separations", "plain.nc", "--height", "9 m", "--height", "12 m")
    assert re.search(r"height_ratio +\S.* 180 ", ruled)  # mm, as the column says


def scene_with(override: str) -> pr.Scene:
    """The scene with another value."""
    return pr.read_scene("scene.toml", [override])
