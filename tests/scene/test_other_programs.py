"""docs/own_model.md: its scenes, and its recipes on tables in the format of ETABS and SAP2000 and on an OpenSees model.

Oracles: SciPy's modes of a stiffness matrix, of which the tables have been written; and OpenSees, by its own
eigenvalues and by Newmark's rule, whose error has to fall as the square of its step.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh

import pounding_risk as pr
from pounding_risk.lab.accuracy_opensees import silenced

ROOT = Path(__file__).resolve().parents[2]
TABLES = ROOT / "tests" / "data" / "other_programs"
PAGE = (ROOT / "docs" / "own_model.md").read_text("utf-8")
SECTIONS = dict(zip(re.findall(r"^## (.+)$", PAGE, re.M), re.split(r"^## .+$", PAGE, flags=re.M)[1:], strict=True))

MASSES = np.array([200.0, 200.0, 150.0])  # t
STIFFNESS = np.array([[320.0, -180.0, 30.0], [-180.0, 230.0, -90.0], [30.0, -90.0, 65.0]])  # MN/m
SQUARES, FORMS = eigh(1e3 * STIFFNESS, np.diag(MASSES))
PERIODS = 2.0 * np.pi / np.sqrt(SQUARES)


def blocks(section: str, language: str = "python") -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", SECTIONS[section], re.M | re.S)


def run(*sections: str) -> dict[str, Any]:
    """What the Python of some sections leaves, run one after the other."""
    names: dict[str, Any] = {}
    for section in ("Functions for the tables", *sections):
        for block in blocks(section):
            exec(compile(block, section, "exec"), names)
    return names


def vibration(scene: pr.Scene) -> tuple[np.ndarray, np.ndarray]:
    """Periods of the first building, and its shapes of unit modal mass in t."""
    frequencies, shapes = scene.buildings[0].vibration()
    return 2.0 * np.pi / frequencies, shapes * np.sqrt(1e3)


@pytest.fixture
def tables(monkeypatch, tmp_path) -> Path:
    """The tables, in a folder where the page runs."""
    shutil.copytree(TABLES, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("name", "digits"),
    [("tower", 6e-4), ("block", 6e-7)],  # of ETABS and SAP2000: half the last digit of the table's periods [s]
)
@pytest.mark.parametrize("heads", ["of the API", "of the screen"])
def test_tables_give_the_building_that_they_are_of(tables, name, digits, heads):
    """Shapes within 1e-6, the last digit of the tables and what their other directions have."""
    if heads == "of the screen":
        for file in tables.glob("*/*.csv"):
            words = {"OutputCase": "Output Case", "StepNum": "Step Number", "UX": "Ux", "MassX": "Mass X"}
            text = file.read_text("utf-8")
            for key, shown in words.items():
                text = text.replace(key, shown)
            file.write_text(text, "utf-8-sig")
    names = run("ETABS", "SAP2000", "The scene")
    scene = names["beside_a_wall"](names[name])
    periods, shapes = vibration(scene)
    assert periods == pytest.approx(PERIODS, abs=digits)
    np.testing.assert_allclose(shapes, FORMS * np.sign(FORMS[-1]), atol=1e-6)
    assert scene.buildings[0].levels == pytest.approx((4.0, 7.5, 11.0))
    assert scene.buildings[0].masses == pytest.approx(1e3 * MASSES)
    if name == "tower":  # the scene that the page writes needs no table
        shutil.rmtree(tables / "etabs")
        assert pr.modes(pr.read_scene("scene.toml"))[0].periods == pytest.approx(periods, rel=1e-9)


@pytest.mark.parametrize("section", ["By its stiffness matrix", "By its modes"])
def test_scenes_of_the_page_are_that_frame(tmp_path, section):
    """Periods of the modes' table are its own; its shapes, in three digits, and masses are those of SciPy."""
    for table in blocks(section, "text"):
        (tmp_path / "modes.csv").write_text(table)
        rows = np.genfromtxt(table.splitlines()[1:], delimiter=",")
        shown = FORMS[:, :2] / FORMS[-1, :2]
        np.testing.assert_allclose(rows[:, 3:].T, shown, atol=6e-4)
        assert rows[:, 2] == pytest.approx((MASSES @ FORMS[:, :2]) ** 2, abs=0.06)
    contact = 'gap = "5 cm"\ncontact_model = "hertz"\nstiffness = "2.7e10 N/m^1.5"\n[records]\nnames = ["RSN6-180"]\n'
    wall = f'[[building]]\nname = "wall"\nrigid = true\n[[interface]]\n{contact}'
    (tmp_path / "scene.toml").write_text(blocks(section, "toml")[0] + wall)
    periods, _ = vibration(pr.read_scene(tmp_path / "scene.toml"))
    if section == "By its modes":
        assert periods == pytest.approx([0.679, 0.24, 0.08], rel=1e-9)
    else:
        assert periods == pytest.approx(PERIODS, rel=1e-9)


@pytest.fixture
def opensees(tables, ops) -> Any:
    yield ops
    ops.wipe()


def by_newmark(ops: Any, ground: np.ndarray, dt: float, step: float, beta: float) -> np.ndarray:
    """The roof's displacement at the samples of a ground motion, by average acceleration from rest."""
    parts = round(dt / step)
    exec(compile(blocks("OpenSees")[0], "frame", "exec"), {"np": np})
    ops.rayleigh(0.0, 0.0, beta, 0.0)
    ops.timeSeries("Path", 1, "-dt", dt, "-values", *ground.tolist())
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    for node in (11, 12, 21, 22, 31, 32):  # at rest the first sample acts already
        ops.setNodeAccel(node, 1, -float(ground[0]), "-commit")
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("FullGeneral")
    ops.algorithm("Linear")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    roof = [0.0]
    for _ in range(ground.size - 1):
        assert ops.analyze(parts, step) == 0
        roof.append(ops.nodeDisp(31, 1))
    return np.array(roof)


def test_a_model_of_opensees_has_its_periods_and_its_response(opensees):
    """Periods within 1e-6; errors of Newmark's rule fall as the square of its step, within 1 %: the next is h⁴."""
    with silenced():
        names = run("ETABS", "OpenSees", "The scene")
        known = 2.0 * np.pi / np.sqrt(opensees.eigen("-fullGenLapack", 3))
    scenes = {name: names["beside_a_wall"](names[name]) for name in ("frame", "exact", "massive")}
    for scene in scenes.values():
        assert pr.modes(scene)[0].periods == pytest.approx(known, rel=1e-6)
    shaken = scenes["exact"].replace(records=pr.Records(["RSN6-180"], window=["0 s", "8 s"]))
    free = pr.simulate(shaken, gap="1 m")
    dt, count = 0.01, 801
    at = np.searchsorted(free.time.values, np.arange(count) * dt - 1e-9)
    ground, ours = free.ground_acceleration.values[at], free.displacement.values[at, 0, 2]
    assert free.impact_count.item() == 0
    with silenced():
        beta = 2.0 * 0.03 * known[0] / (2.0 * np.pi)
        errors = [np.abs(by_newmark(opensees, ground, dt, dt / parts, beta) - ours).max() for parts in (4, 8, 16)]
    assert errors[-1] < 1e-4 * np.abs(ours).max()
    assert np.array(errors[:-1]) / errors[1:] == pytest.approx(4.0, rel=0.01), errors


def test_members_with_masses_of_their_own_are_a_mass_matrix(opensees):
    """Columns of 900 kg/m and beams of 10 t/m, consistent. A condensed model is slower in no mode (Guyan).

    Its first period is within 1e-5 of the own one of OpenSees, its second within 1e-3.
    """
    model, *matrices = blocks("OpenSees")
    for part, mass in (("0.0108, 1)", 900.0), ("0.009, 1)", 10e3)):
        assert part in model
        model = model.replace(part, f'{part[:-1]}, "-mass", {mass}, "-cMass")')
    model = re.sub(r"^    ops.mass.*$", "", model, flags=re.M)
    names: dict[str, Any] = {"np": np, "pr": pr, "write_modes": lambda *_: None}
    with silenced():
        for block in (model, *matrices):
            exec(compile(block.replace("frame = pr.ModalBuilding", "# frame ="), "frame", "exec"), names)
        known = 2.0 * np.pi / np.sqrt(opensees.eigen("-fullGenLapack", 3))
    contact = pr.Interface("50 mm", "jankowski", "1e11 N/m^1.5", restitution=0.65)
    scene = pr.Scene([names["massive"], pr.RigidWall("wall")], [contact], pr.Records(["RSN6-180"]))
    building = scene.buildings[0]
    periods = 2.0 * np.pi / building.vibration().frequencies
    assert (periods <= known * (1.0 + 1e-9)).all()
    assert periods[:2] == pytest.approx(known[:2], rel=1e-3) and periods[0] == pytest.approx(known[0], rel=1e-5)
    assert sum(building.masses) == pytest.approx(3 * 80e3 + 2 * 900.0 * (11.0 - 0.5 * 4.0), rel=1e-2)
