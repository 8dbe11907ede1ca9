"""A scene as an OpenSeesPy script: it runs by itself, and its peaks come to those of the scene as its step shrinks."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scenes import rigid, scene_text, single, storeyed

import pounding_risk as pr
from pounding_risk.errors import PoundingError, SceneError

SHORT = {"window": ["0 s", "4 s"], "pga": "0.5 g"}
DAMPED = {"damping": 0.05}
FLATS = storeyed("flats", "100 t", "90 MN/m", "3 m", storeys=3, damping=0.05, damping_rule="stiffness")
SHOP = storeyed("shop", "150 t", "60 MN/m", "3 m", storeys=1, damping=0.05, damping_rule="stiffness")
PAIR = single("a", "500 t", "0.5 s"), single("b", "800 t", "1.0 s", damping=0.02)
SCENES = {
    "jankowski": scene_text(single("a", "500 t", "0.5 s", **DAMPED), PAIR[1], records=SHORT),
    "hertz_damp": scene_text(*PAIR, records=SHORT, law="hertz_damp"),
    "kelvin_voigt": scene_text(*PAIR, records=SHORT, law="kelvin_voigt", stiffness="93.5 kN/mm"),
    "a rigid wall": scene_text(single("a", "500 t", "0.5 s", **DAMPED), rigid(), records=SHORT, gap="15 mm"),
    "a row with storeys": scene_text(FLATS, SHOP, single("c", "200 t", "0.8 s", height="3 m"), records=SHORT),
}
OUTPUTS = ("peak_relative_displacement", "peak_contact_force")


def peaks_of(script: Path, step: float) -> dict[str, tuple[float, float]]:
    """Peak displacement [m] and force [N] of each contact that a run of a script prints."""
    done = subprocess.run([sys.executable, script, repr(step)], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    lines = done.stdout[done.stdout.index("contact ") :].partition("pounding-risk\n")[0].splitlines()[1:]
    return {line[:32].strip(): tuple(map(float, line[32:].split())) for line in lines}


@pytest.mark.parametrize("name", SCENES)
def test_the_script_agrees_as_its_step_shrinks(name, tmp_path):
    pytest.importorskip("openseespy.opensees", exc_type=ImportError)
    scene = pr.read_scene(SCENES[name])
    script = pr.export(scene, "opensees", tmp_path / "model.py").files[0]
    results = pr.scan(scene)
    errors = []
    for step in (2e-4, 5e-5):
        peaks = peaks_of(script, step)
        by_interface: dict[str, list[tuple[float, float]]] = {}
        for contact, values in peaks.items():
            by_interface.setdefault(contact.partition(",")[0], []).append(values)
        found = np.array([np.max(by_interface[str(interface)], axis=0) for interface in results["interface"].values])
        ours = np.column_stack(
            [results[f"peak_{kind}"].values.ravel() for kind in ("relative_displacement", "contact_force")]
        )
        errors.append(np.abs(found / ours - 1.0).max())
    # Second order where nothing touches, first where a touch is found at a step: a quarter of the step leaves at most
    # a half of the error, or what is left is below a thousandth.
    assert errors[1] < max(0.5 * errors[0], 1e-3)
    assert errors[1] < 0.02


def test_the_script_says_what_it_is_and_what_it_has_not(tmp_path, monkeypatch):
    # As a clone with pending changes states it, the longest there is.
    monkeypatch.setattr("pounding_risk.reports.exports.opensees.__version__", "10.11.12.dev1234+g0123456789.d20270101")
    text = scene_text(records=SHORT | {"polarity": ["as recorded", "reversed"]}, grid={"gap": ["5 mm", "10 mm"]})
    written = pr.export(pr.read_scene(text), "opensees", tmp_path / "model.py", gap="7 mm")
    script = written.files[0].read_text()
    compile(script, "model.py", "exec")
    assert "gap 0.007 m" in script and "- 1 further motion of the scene" in script
    assert "Units are N, kg, m and s" in script
    assert max(map(len, script.splitlines())) <= 120


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"law": "viscous_elastoplastic"}, "it has no material for ViscousElastoplastic"),
        ({"restitution": "concrete"}, "one e for every impact"),
        ({"effects": {"permanent_set": {}}, "law": "viscous_elastoplastic"}, "permanent_set"),
    ],
)
def test_what_opensees_cannot_say_is_refused_with_the_reason(changes, reason, tmp_path):
    scene = pr.read_scene(scene_text(**{"records": SHORT} | changes))
    with pytest.raises(SceneError, match=reason):
        pr.export(scene, "opensees", tmp_path / "model.py")
    assert not list(tmp_path.iterdir())


def test_results_in_place_of_a_scene_are_refused_and_the_reverse(tmp_path):
    scene = pr.read_scene(scene_text(records=SHORT))
    with pytest.raises(PoundingError, match="the dataset holds results; name the TOML file"):
        pr.export(pr.scan(scene), "opensees", tmp_path / "model.py")
    with pytest.raises(PoundingError, match=r"`pounding-risk scan scene\.toml -o results\.nc` writes them"):
        pr.export("scene.toml", "nrml", tmp_path / "f.xml")
    with pytest.raises(PoundingError, match="--discrete: has no effect on opensees"):
        pr.export(scene, "opensees", tmp_path / "model.py", discrete=True)
