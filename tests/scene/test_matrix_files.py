"""Matrices and modes in files beside a scene, from other programs too (docs/own_model.md), and faults of theirs.

Oracles: SciPy's modes of a stiffness matrix, of which the tables have been written; and OpenSees, by its own
eigenvalues and by Newmark's rule, whose error has to fall as the square of its step.
"""

import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes import scene_text, single
from scipy.linalg import eigh
from sentences import refusal

import pounding_risk as pr
from pounding_risk.lab.accuracy_opensees import silenced
from pounding_risk.scene.reader import read_scene
from pounding_risk.scene.scene import Scene

K = np.array([[330.0, -150.0, 0.0], [-150.0, 240.0, -90.0], [0.0, -90.0, 90.0]])  # MN/m
HALL = ('name = "hall"', 'floor_masses = ["200 t", "200 t", "150 t"]', 'storey_heights = "4 m"')
HEAD = "# from a model of three floors\nfrequency [Hz],damping [%],floor 1,floor 2,floor 3,effective mass [t]\n"


def beside_a_mass(folder: Path, height: str, *keys: str) -> Scene:
    """A building with these keys beside a mass of a height, read from a file in the folder."""
    pair = scene_text(single("A", "80 t", "0.2 s"), single("B", "80 t", "0.3 s", height=height), gap="2 mm")
    (folder / "scene.toml").write_text("\n".join(("[[building]]", *keys, pair.partition('period = "0.2 s"\n')[2])))
    return read_scene(folder / "scene.toml")


def scene(folder: Path, *keys: str) -> Scene:
    """A hall with these keys."""
    return beside_a_mass(folder, "12 m", *HALL, *keys)


def test_every_form_of_a_matrix_is_the_same_scene(tmp_path):
    np.savetxt(tmp_path / "K.csv", 1e3 * K, delimiter=",", header="of a model")
    np.savetxt(tmp_path / "K.txt", K)  # between blanks, as OpenSees' printA
    np.save(tmp_path / "K.npy", K * 1e6)
    np.savez(tmp_path / "K.npz", K=K * 1e6, levels=np.arange(3))
    forms = ('file = "K.csv", unit = "kN/m"', 'file = "K.txt", unit = "MN/m"', 'file = "K.npy", unit = "N/m"',
             'file = "K.npz", unit = "N/m"', f'values = {K.tolist()}, unit = "MN/m"')  # fmt: skip
    scenes = [scene(tmp_path, f"stiffness_matrix = {{{form}}}") for form in forms]
    for other in scenes:
        assert other.buildings[0].stiffness_matrix == pytest.approx(np.array(scenes[-1].buildings[0].stiffness_matrix))
        text = other.to_toml()
        assert "K." not in text  # stands alone without the file
        assert read_scene(text).buildings == other.buildings
    rows = scene(tmp_path, 'stiffness_matrix = {file = "K.txt", unit = "1000 kN/m"}', "damping = 0.02")
    assert rows.buildings[0].damping == 0.02 and "K.txt" in rows.to_toml(as_written=True)


def test_modes_of_a_file_are_those_of_the_building(tmp_path):
    """Oracle: SciPy's modes of K, of which the file has two, in four digits."""
    masses = np.array([200.0, 200.0, 150.0])
    squares, known = eigh(1e3 * K, np.diag(masses))
    lines = [
        f"{rate:.4f},{damping},{','.join(f'{one:.4f}' for one in shape / shape[-1])},{(shape @ masses) ** 2:.1f}\n"
        for rate, damping, shape in zip(np.sqrt(squares[:2]) / (2 * np.pi), (5, 4), known.T, strict=False)
    ]
    (tmp_path / "modes.csv").write_text(HEAD + "".join(lines))
    stated = [float(line.partition(",")[0]) for line in lines]
    building = scene(tmp_path, 'modes = "modes.csv"').buildings[0]
    frequencies, forms = building.vibration()
    assert frequencies[:2] / (2 * np.pi) == pytest.approx(stated, rel=1e-12)
    assert forms[:, 0] / forms[-1, 0] == pytest.approx(known[:, 0] / known[-1, 0], abs=1e-4)  # of the digits
    damped = np.diag(forms.T @ building.matrices()[1] @ forms) / (2 * frequencies)
    assert damped == pytest.approx([0.05, 0.04, 0.04], rel=1e-9)
    assert pr.modes(scene(tmp_path, 'modes = "modes.csv"'))[0].periods[2] == pytest.approx(1 / stated[1] / 3, rel=1e-9)
    own = scene(tmp_path, 'modes = "modes.csv"', 'residual_period = "0.1 s"')
    assert pr.modes(own)[0].periods[2] == pytest.approx(0.1, rel=1e-9)


BROKEN = {
    "absent.csv": None,
    "words.csv": "a,b,c\n1,2,3\n",
    "uneven.csv": "1,2\n1\n",
    "empty.csv": "# nothing\n",
    "broken.npy": "no array",
}
BROKEN_MODES = {
    "absent": None,
    "no floors": "period [s]\n0.4\n",
    "no period": "floor 1,floor 2,floor 3\n1,1,1\n",
    "unknown": "period [s],storey 1\n0.4,1\n",
    "twice": "period [s],floor 1,floor 1\n0.4,1,1\n",
    "no unit": "period,floor 1,floor 2,floor 3\n0.4,1,1,1\n",
    "negative": "period [s],floor 1,floor 2,floor 3\n-0.4,1,1,1\n",
}


def test_files_that_hold_none_are_refused(tmp_path, says):
    for name, text in BROKEN.items():
        if text is not None:
            (tmp_path / name).write_text(text)
        faults = refusal(scene, tmp_path, f'stiffness_matrix = {{file = "{name}", unit = "kN/m"}}')
        says(faults.replace(str(tmp_path), ""))
    np.savez(tmp_path / "two.npz", K=K, M=K)
    says(refusal(scene, tmp_path, 'stiffness_matrix = {file = "two.npz", unit = "kN/m"}').replace(str(tmp_path), ""))
    for text in BROKEN_MODES.values():
        (tmp_path / "modes.csv").unlink(missing_ok=True)
        if text is not None:
            (tmp_path / "modes.csv").write_text(text)
        says(refusal(scene, tmp_path, 'modes = "modes.csv"').replace(str(tmp_path), ""))


def test_a_matrix_that_no_float_holds_in_its_unit_is_one_sentence(tmp_path):
    """1e308 MN/m overflows in N/m; a warning of NumPy would be an error here."""
    (tmp_path / "huge.csv").write_text("1e308,0,0\n0,1e308,0\n0,0,1e308\n")
    faults = refusal(scene, tmp_path, 'stiffness_matrix = {file = "huge.csv", unit = "MN/m"}', "damping = 0.05")
    assert "row 1, column 1 is no finite number" in faults


def test_keys_that_do_not_fit_are_refused(tmp_path, says):
    matrix = f'stiffness_matrix = {{values = {K.tolist()}, unit = "MN/m"}}'
    says(refusal(scene, tmp_path, "stiffness_matrix = [[1, 0], [0, 1]]"))
    says(refusal(scene, tmp_path, 'stiffness_matrix = {values = [[1, "2"], [0, true]], unit = "kN"}'))
    says(refusal(scene, tmp_path, 'stiffness_matrix = {file = "K.csv", values = [[1]], unit = "kN/m"}'))
    triangle = 'stiffness_matrix = {values = [[3, -1, 0], [2, -1], [1]], unit = "kN/m"}'
    says(refusal(scene, tmp_path, triangle, "damping = 0.05"))
    modes = 'modes = {period = ["0.4 s"], shape = [[1, 2, 3]]}'
    says(refusal(scene, tmp_path, modes, 'residual_period = "0.5 s"'))
    says(refusal(scene, tmp_path, matrix, 'storey_strengths = "1 MN"'))
    says(refusal(scene, tmp_path, matrix, 'storey_stiffnesses = "95 MN/m"', 'storey_strengths = "1 MN"'))
    says(refusal(scene, tmp_path, matrix, 'storey_stiffnesses = "95 MN/m"', "storeys = 3"))
    says(refusal(scene, tmp_path, matrix, 'initial_velocity = ["1 m/s"]', "floor_rows = [1, 1]"))
    says(refusal(scene, tmp_path, matrix, 'damping_matrix = {values = [[1]], unit = "kN s/m"}', "damping = 0.05"))
    says(refusal(scene, tmp_path, 'modes = {period = ["0.4 s"], shape = [[1, 1, 1], [1, 0, 1]]}', 'mass = "4 t"'))


# A frame of two floors whose rows are u and θ of each, in kN/m, kN and kN m; t, t m and t m².
FRAME_K = np.array([[240.0, 0.0, -120.0, 60.0], [0.0, 160.0, -60.0, 20.0], [-120.0, -60.0, 120.0, -60.0],
                    [60.0, 20.0, -60.0, 80.0]])  # fmt: skip
FRAME_M = np.array([[150.0, 0.0, 27.0, -6.5], [0.0, 8.0, 6.5, -1.5], [27.0, 6.5, 78.0, -11.0],
                    [-6.5, -1.5, -11.0, 4.0]])  # fmt: skip


def framed(folder: Path, *keys: str) -> Scene:
    """The frame beside a mass, with its matrices in files."""
    np.savetxt(folder / "K.csv", FRAME_K)
    np.savetxt(folder / "M.csv", FRAME_M)
    head = ('name = "frame"', 'storey_heights = "4 m"', 'stiffness_matrix = {file = "K.csv", unit = "MN/m"}')
    return beside_a_mass(folder, "8 m", *head, *keys)


OF_FRAME = ('mass_matrix = {file = "M.csv", unit = "t"}', "floor_rows = [1, 3]")


def test_a_mass_matrix_of_a_file_is_condensed_and_stands_in_the_scene_that_is_written(tmp_path):
    """Oracle: the definition, u = T u_f with the rotations free of load, and a_g on the displacements alone."""
    study = framed(tmp_path, *OF_FRAME, "along_rows = [1, 3]")
    turned = -np.linalg.solve(FRAME_K[np.ix_([1, 3], [1, 3])], FRAME_K[np.ix_([1, 3], [0, 2])])
    moved = np.array([[1.0, 0.0], turned[0], [0.0, 1.0], turned[1]])
    building = study.buildings[0]
    assert np.array(building.mass_matrix) == pytest.approx(1e3 * moved.T @ FRAME_M @ moved, rel=1e-12)
    assert building.masses == pytest.approx(1e3 * moved.T @ FRAME_M @ [1.0, 0.0, 1.0, 0.0], rel=1e-12)
    text = study.to_toml()
    assert "M.csv" not in text and "along_rows" not in text
    assert read_scene(text).buildings == study.buildings
    assert "M.csv" in study.to_toml(as_written=True)


def test_what_a_mass_matrix_lacks_is_said(tmp_path, says):
    says(refusal(framed, tmp_path, *OF_FRAME))
    says(refusal(framed, tmp_path, *OF_FRAME, "along_rows = [1, 3]", 'floor_masses = "150 t"'))
    says(refusal(framed, tmp_path, "floor_rows = [1, 3]"))
    says(refusal(framed, tmp_path, "floor_rows = [1, 3]", 'floor_masses = "150 t"', "along_rows = [1, 3]"))
    says(refusal(framed, tmp_path, 'mass_matrix = {file = "M.csv", unit = "m"}', "floor_rows = [1, 3]"))
    says(refusal(framed, tmp_path, 'mass_matrix = {file = "no.csv", unit = "t"}', "floor_rows = [1, 3]"))
    says(refusal(scene, tmp_path, OF_FRAME[0]))


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
