"""The other ways to solve a pair, which benchmarks/ times, give the same answers; no clock is read here."""

from __future__ import annotations

import os
from pathlib import Path

import baseline
import executors
import ida
import numpy as np
import pytest
import row_scan
from processes import output
from rk4 import solve_rk4
from scipy_pair import solve_scipy

import pounding_risk as pr
import records
from pounding_risk.models.contact.laws import ViscousElastoplastic
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver.pair.api import Interface, oscillators, solve

LEFT, RIGHT = Building("left", 500e3, 0.5, 0.05), Building("right", 800e3, 1.0, 0.05)
DT = 0.01

pytestmark = pytest.mark.complete


def test_other_methods_agree_where_the_contact_yields():
    """Laws without a cap are those of test_side_by_side. Fixed steps are of first order: touches fall inside them."""
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
# Their `main` is called below and in test_side_by_side.
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
