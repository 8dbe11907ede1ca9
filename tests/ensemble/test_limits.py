"""What no machine can hold is refused before memory is asked for: tried under a limit of the address space.

No clock is asserted: a limit on memory is what an allocation breaks.
"""

import json
import resource
import subprocess
import sys
import tracemalloc
from math import cos, pi
from pathlib import Path

import numpy as np
import pytest
from scenes import scene_text, single, storeyed
from sentences import refusal

from pounding_risk.ensemble import limits as work_limits
from pounding_risk.ensemble.plan.cost import MOST_BATCHES, few_batches
from pounding_risk.ensemble.plan.plan import validate
from pounding_risk.ensemble.plan.size import bytes_of
from pounding_risk.ensemble.row_grid import model_of
from pounding_risk.ensemble.row_job import LEAST_RESPONSES, RESPONSE_BYTES, RowJob
from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import RecordError, SceneError
from pounding_risk.motions import formats
from pounding_risk.motions.formats import matching
from pounding_risk.motions.read import read_motion
from pounding_risk.scene.reader import parse_scene
from pounding_risk.solver.pair.api import free_response, oscillators
from pounding_risk.solver.row.api import free_response as free_row_response
from pounding_risk.solver.row.layout import lay_out
from pounding_risk.streets.footprints import Outline, clear_distance

SCENE = scene_text(
    single("A", "44 t", "0.2 s"),
    single("B", "80 t", "0.1 s"),
    law="viscous_elastoplastic",
    gap="2 mm",
    records={"window": ["0 s", "2 s"]},
)
LIMIT = 4 * 10**9  # bytes of address space: the libraries take 2 GB of it, the faults took 4 to 8 GB
HUGE = [
    'grid.gap={start="0 mm", stop="100 mm", num=10000}',
    'grid.yield_force={start="1 kN", stop="100 kN", num=10000}',
    'grid.pga={start="0.1 g", stop="1 g", num=10000}',
]
LARGE = [HUGE[0], 'grid.pga={start="0.1 g", stop="1 g", num=1000}']  # ten million batches


def command(*words: str) -> tuple[int, str]:
    """A command under `LIMIT`: how it ended, and what it said."""
    told = subprocess.run(
        [sys.executable, "-m", "pounding_risk", *words],
        capture_output=True,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (LIMIT, LIMIT)),
        check=False,
    )
    return told.returncode, told.stdout + told.stderr


def with_overrides(overrides: list[str]) -> list[str]:
    return [part for text in overrides for part in ("--set", text)]


@pytest.fixture
def scene(tmp_path: Path) -> str:
    file = tmp_path / "scene.toml"
    file.write_text(SCENE)
    return str(file)


BEYOND = {
    "1e-5 s": 'building.B.period="1e-5 s"',
    "1e-7 s": 'building.B.period="1e-7 s"',
    "1e-30 kg": 'building.A.mass="1e-30 kg"',
    "20 001 parts": f"building.{'.'.join(['a'] * 20_000)}=1",
}


@pytest.mark.parametrize("override", BEYOND.values(), ids=BEYOND)
@pytest.mark.complete
def test_values_beyond_physics_are_refused(scene, override, says):
    ended, words = command("validate", scene, "--set", override)
    assert ended == 2 and "Traceback" not in words and len(words) < 2000
    says(words)


def test_a_building_faster_than_any_is_refused_by_its_stiffness_too():
    mass = SCENE.replace('period = "0.1 s"', 'stiffness = "1e15 N/m"')
    with pytest.raises(SceneError, match=r"building\.B: would vibrate with a period of .* s, and none"):
        parse_scene(mass, "scene.toml")
    storeys = SCENE.replace('mass = "80 t"\nperiod = "0.1 s"', (
        'floor_masses = ["40 t", "2 kg"]\nstorey_stiffnesses = "1e11 N/m"\nstorey_heights = "3 m"'
    ))  # fmt: skip
    told = refusal(parse_scene, storeys, "scene.toml", kind=SceneError)
    assert "building.B: floor 2 on its storeys would vibrate" in told


@pytest.mark.complete
def test_a_grid_that_no_disk_holds_is_refused(scene):
    ended, words = command("validate", scene, *with_overrides(HUGE))
    assert ended == 2 and "cases, and their dataset" in words and "no disk holds that" in words


@pytest.mark.complete
def test_a_large_grid_is_planned_from_some_of_its_batches(scene):
    ended, words = command("scan", "--plan", scene, *with_overrides(LARGE))
    assert ended == 0, words
    assert "; about " in next(line for line in words.splitlines() if line.startswith("batches"))


@pytest.mark.complete
def test_a_dotted_key_of_a_file_is_refused(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(SCENE + "a." * 20_000 + "b = 1\n")
    ended, words = command("validate", str(file))
    assert ended == 2 and f"line {SCENE.count(chr(10)) + 1}: a key of 20001 parts" in words


def test_a_scan_that_the_disk_or_the_memory_cannot_hold_is_refused(tmp_path, monkeypatch):
    study = parse_scene(SCENE, "scene.toml", ['grid.gap={start="0 mm", stop="10 mm", num=100}'])
    with monkeypatch.context() as patched:
        patched.setattr(work_limits.shutil, "disk_usage", lambda folder: type("Usage", (), {"free": 10_000}))
        with pytest.raises(SceneError, match=r"before compression, and .* are free in"):
            scan(study, tmp_path / "results.nc")
    assert list(tmp_path.iterdir()) == []
    monkeypatch.setattr(work_limits, "free_memory", lambda: 10_000.0)
    with pytest.raises(SceneError, match=r"one response takes .* of memory are free"):
        scan(study)
    monkeypatch.setattr("pounding_risk.ensemble.scan.check_memory", lambda *given: None)
    assert "scan into a file" in refusal(scan, study, kind=SceneError)


def test_the_size_of_a_response_is_told_beforehand():
    """At least what its arrays take, and less than four times that: NumPy's copies while it is made."""
    for period in ("0.1 s", "0.002 s"):
        study = parse_scene(SCENE, "scene.toml", [f'building.B.period="{period}"'])
        motion = read_motion("RSN6-180")
        free = free_response(oscillators(*study.pair), motion.acceleration, motion.dt)
        held = sum(each.nbytes for each in (free.ground, free.states, free.high, free.low))
        assert held < work_limits.response_bytes(study, motion) < 4 * held


@pytest.mark.parametrize("row", [False, pytest.param(True, marks=pytest.mark.complete)])
@pytest.mark.parametrize("distance", ["20 m", "20.3 m"])
def test_under_a_wave_the_size_is_told_too(row, distance):
    """More than is allocated at most while the motion is laid out and answered, as Python counts it, and not much."""
    wave = f'effects.wave_passage={{velocity = "500 m/s", distance = "{distance}"}}'
    third = '[[building]]\nname = "C"\nmass = "80 t"\nperiod = "0.3 s"\n'
    study = parse_scene(SCENE + third * row, "scene.toml", [wave])
    motion = read_motion("RSN6-180")

    def respond():
        if row:
            return free_row_response(model_of(study).row(motion.dt), motion.acceleration)
        return free_response(oscillators(*study.pair), motion.acceleration, motion.dt, study.supports)

    respond()  # compiles
    tracemalloc.start()
    respond()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < work_limits.response_bytes(study, motion) < 5 * peak
    still = work_limits.response_bytes(study.updated(effects=()), motion)
    assert peak > still  # which would have let it pass


@pytest.mark.complete
@pytest.mark.parametrize("effects", [{}, {"wave_passage": {"velocity": "400 m/s", "distance": ["30 m", "17 m"]}}])
def test_so_is_that_of_a_row(effects):
    """With all its floors; with a wave a sample has a node for each building, and each its own ground motion."""
    buildings = storeyed("a", "70 t", "40 MN/m", storeys=6), storeyed("b", "90 t", "90 MN/m", storeys=4)
    text = scene_text(*buildings, single("c", "80 t", "0.2 s", height="9 m"), gap="2 mm", effects=effects)
    study, motion = parse_scene(text), read_motion("RSN6-180")
    response = free_row_response(model_of(study).row(motion.dt), motion.acceleration)
    held = bytes_of(response)
    assert held < work_limits.response_bytes(study, motion) < 4 * held
    # What a scan keeps is bounded, however large a response is.
    assert RowJob.held_bytes(1000, held) <= max(RESPONSE_BYTES, LEAST_RESPONSES * held)
    assert RowJob.held_bytes(2, held) == 2 * held


def test_the_rate_of_a_row_is_a_bound():
    """Against the eigenvalues by which a row is laid out; half of a large step is one part of it, or less."""
    row = SCENE.replace('mass = "80 t"\nperiod = "0.1 s"', (
        'floor_masses = ["40 t", "30 t"]\nstorey_stiffnesses = ["60 MN/m", "90 MN/m"]\nstorey_heights = "3 m"'
    ))  # fmt: skip
    study = parse_scene(row, "scene.toml", ["effects.p_delta={}", 'building.A.height="6 m"'])
    model, dt = model_of(study), 100.0
    exact = lay_out(model.chains, model.points, dt).parts * work_limits.TURN / dt  # to one part of some thousand
    assert 0.999 * exact < work_limits.fastest_rate(study) < 2.0 * exact


def test_a_few_lines_stand_for_all():
    study = parse_scene(SCENE, "scene.toml", LARGE)
    few, share = few_batches(study, 2)
    batches = 2 * len(few.grid.gaps) * len(few.grid.amplitudes)
    assert batches <= MOST_BATCHES and share == batches / (2 * 10_000 * 1000)
    assert (few.grid.gaps[0], few.grid.gaps[-1]) == (study.grid.gaps[0], study.grid.gaps[-1])
    assert (few.grid.amplitudes[0], few.grid.amplitudes[-1]) == (study.grid.amplitudes[0], study.grid.amplitudes[-1])
    small = parse_scene(SCENE, "scene.toml")
    assert few_batches(small, 2) == (small, 1.0)
    assert validate(small).share == 1.0


def test_patterns_walk_through_so_many_files_only(tmp_path, monkeypatch):
    (tmp_path / "records").mkdir()
    for number in range(5):
        (tmp_path / "records" / f"{number}.AT2").touch()
    assert len(matching(tmp_path, "records/**/*.AT2")) == 5
    monkeypatch.setattr(formats, "MOST_ENTRIES", 4)
    for pattern in ("**/*.AT2", f"{tmp_path}/**/*", "rec*/**"):
        assert "more than 4 files and folders below it; name the folder" in refusal(
            matching, tmp_path, pattern, kind=RecordError
        )
    assert len(matching(tmp_path, "records/*.AT2")) == 5  # one folder is no walk
    scene = SCENE.replace('names = ["RSN6-180"]', 'files = ["**/*"]')
    with pytest.raises(SceneError, match=r"records\.files\.1: \*\*/\*: .* name the folder"):
        parse_scene(scene, str(tmp_path / "scene.toml"))


def ring(corners: int) -> np.ndarray:
    angles = 2.0 * pi * np.arange(corners) / corners
    return np.column_stack([np.cos(angles), np.sin(angles)])


def outline(corners: np.ndarray) -> Outline:
    return Outline(corners, np.roll(corners, -1, axis=0), corners.min(axis=0), corners.max(axis=0))


def test_the_distance_between_outlines_of_many_corners():
    """Two circles of radius 1 m: their centres' distance less two radii, to the sagitta of a side, 1 - cos(pi / n)."""
    count = 1500
    left, right = outline(ring(count)), outline(ring(count) + np.array([2.5, 0.0]))
    sagitta = 1.0 - cos(pi / count)
    assert clear_distance(left, right) == pytest.approx(0.5, abs=2.0 * sagitta)
    above = outline(ring(count) + np.array([2.5, 0.8]))
    # At v the walls are cos(asin(v)) from their centres; nearest where both are as far: v = 0.4.
    exact = 2.5 - 2.0 * (1.0 - 0.4**2) ** 0.5
    # The chords lie within, by a sagitta across their direction, that is cos(asin 0.4) along u.
    assert clear_distance(left, above) == pytest.approx(exact, abs=2.0 * sagitta / (1.0 - 0.4**2) ** 0.5)


@pytest.mark.complete
def test_a_street_of_many_corners_is_read(tmp_path):
    corners = [[10.0 + 1e-4 * x, 50.0 + 1e-4 * y] for x, y in ring(20_000).tolist()]
    features = []
    for name, shift in (("a", 0.0), ("b", 2.05e-4)):
        outline = [[x + shift, y] for x, y in corners]
        shape = {"type": "Polygon", "coordinates": [[*outline, outline[0]]]}
        features.append({"type": "Feature", "properties": {"name": name, "storeys": 3}, "geometry": shape})
    file = tmp_path / "ring.geojson"
    file.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    ended, words = command("block", str(file))
    assert ended == 0 and "a, b" in words, words
