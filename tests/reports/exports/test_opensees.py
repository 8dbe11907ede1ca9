"""A scene as an OpenSeesPy script: it runs by itself, and its peaks come to those of the scene as its step shrinks."""

from pathlib import Path

import numpy as np
import pytest
from processes import output
from scenes import rigid, scene_text, single, storeyed
from sweeps import sweep

import pounding_risk as pr
from pounding_risk.lab.accuracy_opensees import power_law
from pounding_risk.models.contact.register import LAWS

SHORT = {"window": ["0 s", "4 s"], "pga": "0.5 g"}
DAMPED = {"damping": 0.05}
FLATS = storeyed("flats", "100 t", "90 MN/m", "3 m", storeys=3, damping=0.05, damping_rule="stiffness")
SHOP = storeyed("shop", "150 t", "60 MN/m", "3 m", storeys=1, damping=0.05, damping_rule="stiffness")
PAIR = single("a", "500 t", "0.5 s"), single("b", "800 t", "1.0 s", damping=0.02)
FRAME = storeyed("frame", "100 t", "90 MN/m", "3 m", storeys=3, damping=0.05)
LOFT = storeyed("loft", "150 t", "160 MN/m", "4 m", storeys=2, damping=0.05)
PINCHED = {"rule": "peak_oriented", "backbone": [[4.0, 1.2], [12.0, 0.4]], "unloading": 0.4, "pinching_force": 0.3}
SOFT = storeyed("soft", ["100 t", "90 t"], "90 MN/m", "3 m", storey_strengths=["400 kN", "250 kN"], hysteresis=PINCHED)
PODIUM = {"face": ["-6 m", "10 m"], "eccentricity": "2 m", "gyration": "5 m", "torsional_ratio": 1.2}
TOWER = PODIUM | {"face": ["-4 m", "8 m"], "eccentricity": "-1 m", "gyration": "4 m"}
ROTATING = storeyed("hall", ["200 t", "150 t"], "90 MN/m", ["3 m", "3 m"], damping=0.05, plan=[PODIUM, TOWER])
ISOLATION = {"slab_mass": "100 t", "height": "3 m", "strength": "120 kN", "stiffness": "2 MN/m"}
YIELDS = {"inelastic_storeys": {}, "p_delta": {}}
STRENGTHS = {"yield_force": "4 MN", "column_yield_force": "600 kN"}
SCENES = {
    "jankowski": scene_text(single("a", "500 t", "0.5 s", **DAMPED), PAIR[1], records=SHORT),
    "hertz_damp": scene_text(*PAIR, records=SHORT, law="hertz_damp"),
    "kelvin_voigt": scene_text(*PAIR, records=SHORT, law="kelvin_voigt", stiffness="93.5 kN/mm"),
    "in touch at rest": scene_text(*PAIR, records=SHORT, law="hertz_damp", gap="0 mm"),
    "a rigid wall": scene_text(single("a", "500 t", "0.5 s", **DAMPED), rigid(), records=SHORT, gap="15 mm"),
    # Forces that the script computes: of a law without material, of floors against columns, modal damping.
    "viscous_elastoplastic": scene_text(*PAIR, records=SHORT, law="viscous_elastoplastic", yield_force="2 MN"),
    "no tension": scene_text(*PAIR, records=SHORT, law="kelvin_voigt_tension_cut", stiffness="93.5 kN/mm"),
    "columns": scene_text(FRAME, LOFT, records=SHORT, law="viscous_elastoplastic", **STRENGTHS),
    "elastic columns": scene_text(LOFT, rigid(height="9 m"), records=SHORT, law="hertz_damp_exact"),
    "pinched storeys and a link that slips": scene_text(
        SOFT, FLATS, records=SHORT, effects=YIELDS, link_stiffness="20 MN/m", link_strength="80 kN"
    ),
    "isolators and a hook": scene_text(
        storeyed("a", ["90 t"], "90 MN/m", ["3 m"], isolation=ISOLATION),
        SHOP,
        records=SHORT,
        gap="20 mm",
        link_stiffness="5 MN/m",
        link_slack="5 mm",
        link_at=[{"left": "storey 1", "right": "storey 1"}],
    ),
    "storeys that yield, forces that the script computes": scene_text(
        SOFT, LOFT, records=SHORT, effects=YIELDS, law="viscous_elastoplastic", **STRENGTHS
    ),
    "floors that rotate": scene_text(ROTATING, SHOP, records=SHORT, law="kelvin_voigt", stiffness="400 MN/m"),
    "a row with storeys": scene_text(FLATS, SHOP, single("c", "200 t", "0.8 s", height="3 m"), records=SHORT),
}


def peaks_of(script: Path, step: float) -> dict[str, tuple[float, float]]:
    """Peak displacement [m] and force [N] of each contact that a run of a script prints."""
    printed = output(script, repr(step))
    lines = printed[printed.index("contact ") :].partition("pounding-risk\n")[0].splitlines()[1:]
    return {line[:40].strip(): tuple(map(float, line[40:].split())) for line in lines}


@pytest.mark.parametrize("name", sweep(SCENES, "a rigid wall"))
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
    grid = {"gap": ["5 mm", "10 mm"], '"interface.restitution"': [0.5, 0.8]}
    text = scene_text(records=SHORT | {"polarity": ["as recorded", "reversed"]}, grid=grid)
    written = pr.export(pr.read_scene(text), "opensees", tmp_path / "model.py", gap="7 mm")
    script = written.files[0].read_text()
    compile(script, "model.py", "exec")
    assert "gap 7 mm" in script and "- 1 further motion of the scene" in script
    assert "uncertain numbers: interface.restitution as written" in script
    assert "Units are N, kg, m and s" in script
    assert max(map(len, script.splitlines())) <= 120


@pytest.mark.parametrize("title", [r"North\U wing", 'x""" + exit(3) + """'])
def test_a_name_is_no_part_of_the_script(title, tmp_path):
    """One with an escape of Python, and one that ends the text of the head and goes on as code."""
    scene = pr.read_scene(scene_text(*PAIR, records=SHORT)).updated(name=title)
    script = pr.export(scene, "opensees", tmp_path / "model.py").files[0].read_text()
    head = compile(script, "model.py", "exec").co_consts[0]
    assert head.startswith(title.replace('"""', "'''"))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("columns", "floor against a column"),
        ("floors that rotate", "for an end of a face that rotates"),
        ("no tension", "no material for kelvin_voigt_tension_cut"),
        ("in touch at rest", "no least speed of a touch"),
    ],
)
def test_what_the_script_computes_itself_is_said(name, words, tmp_path):
    written = pr.export(pr.read_scene(SCENES[name]), "opensees", tmp_path / "model.py")
    script = written.files[0].read_text()
    assert any(words in sentence for sentence in written.notes) and words in script.replace("\n  ", " ")
    assert "CONTACTS = {}" in script and max(map(len, script.splitlines())) <= 120


@pytest.mark.parametrize("law", ["jankowski", "hertz", "hertz_damp", "kelvin_voigt", "modified_kelvin_voigt",
                                 "viscous_elastoplastic", "kelvin_voigt_tension_cut", "hertz_damp_exact"])  # fmt: skip
def test_a_law_in_two_powers_is_the_law(law):
    """At random places, other ones than those at which it is read and compared."""
    own = LAWS[law](2.75e9)
    found = power_law(own, 0.65, 3e5, 1e6)
    random = np.random.default_rng(1)
    for touch, delta, rate in zip(*(random.uniform(low, 1.0, 200) for low in (0.01, 1e-6, -1.0)), strict=True):
        force = own.force(own.begin(0.65, touch, 3e5), delta, rate, rate > 0.0)
        capped = max(min(force, own.ceiling(1e6)), own.floor())
        assert found.force(touch, delta, rate) == pytest.approx(capped, rel=1e-9)
