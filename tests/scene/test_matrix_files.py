"""Matrices and modes in files beside a scene: every form that is read, and what is wrong with one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scenes import scene_text, single
from scipy.linalg import eigh
from sentences import refusal

import pounding_risk as pr
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
