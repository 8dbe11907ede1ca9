"""Runs made again at a tighter tolerance: which, how far they move, which are called sensitive, what is told."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import scene_text, single

from pounding_risk.ensemble.scan import scan
from pounding_risk.ensemble.tolerance_check import AtLeastOne, changes, drawn, draws, is_sensitive
from pounding_risk.errors import PoundingError
from pounding_risk.results.summary import counted, failures
from pounding_risk.results.tolerance_check import findings, tighter
from pounding_risk.scene.reader import parse_scene
from pounding_risk.solver import counters as tally
from pounding_risk.solver.pair.outputs import COLUMNS, HIGH


def study(
    rtol: float = 1e-6,
    law: str = "viscous_elastoplastic",
    damping: float = 0.05,
    left: str = "0.5 s",
    length: str = "12 s",
    stiffness: str = "2.75e9 N/m^1.5",
    forces: tuple[str, ...] = ("800 kN", "inf"),
):
    text = scene_text(
        single("left", "500 t", left, damping=damping),
        single("right", "800 t", "1.0 s", damping=damping),
        law=law,
        gap="0 mm",
        stiffness=stiffness,
        records={"window": ["0 s", length]},
        grid={"gap": ["0 mm", "5 mm", "20 mm"], "yield_force": list(forces) or None},
        solver={"rtol": rtol},
    )
    return parse_scene(text)


def rows(**columns: list[float]) -> np.ndarray:
    """Raw rows of runs that are complete, with some columns given by the tally's name; ``HIGH`` is the largest u."""
    length = len(next(iter(columns.values())))
    raw = np.zeros((length, COLUMNS))
    for name, values in columns.items():
        raw[:, HIGH if name == "HIGH" else getattr(tally, name)] = values
    return raw


def test_what_is_drawn_depends_on_a_cases_place_in_the_grid_alone():
    whole = draws(range(0, 4000), 25)
    assert np.array_equal(whole[1000:1003], draws(range(1000, 1003), 25))
    assert len(np.unique(whole)) == whole.size and whole.min() >= 0.0 and whole.max() < 1.0
    # Uniform and unrelated from case to case: within four standard errors, 1/sqrt(12 n) and 1/sqrt(n), of what is even.
    assert abs(whole.mean() - 0.5) < 4.0 / np.sqrt(12.0 * whole.size)
    neighbours = np.corrcoef(whole.ravel()[:-1], whole.ravel()[1:])[0, 1]
    assert abs(neighbours) < 4.0 / np.sqrt(whole.size)


def test_the_sample_is_of_runs_that_were_made():
    batches, made = range(50, 450), np.zeros((400, 25), dtype=bool)
    made[:, ::2] = True
    places = drawn(batches, made, 0.3)
    assert not (places & ~made).any()
    # 5,200 runs: a share of 0.3 within four standard errors of a binomial count.
    assert abs(places.sum() - 0.3 * 5200) < 4.0 * np.sqrt(5200 * 0.3 * 0.7)
    assert np.array_equal(drawn(batches, made, 1.0), made) and not drawn(batches, made, 0.0).any()


@given(st.lists(st.integers(1, 7), min_size=1, max_size=6), st.integers(0, 2**31))
def test_one_run_at_least_is_made_again_whatever_the_blocks(sizes, seed):
    """The one with the smallest lot of those made, where none was drawn."""
    made = np.random.default_rng(seed).random((sum(sizes), 3)) < 0.5
    none, watch, start = np.full(made.shape, -1, dtype=np.int8), AtLeastOne(), 0
    for size in sizes:
        here = slice(start, start + size)
        watch.see(range(start, start + size), made[here], none[here])
        start += size
    lots = np.where(made, draws(range(start), 3), 2.0)
    expected = tuple(map(int, np.unravel_index(lots.argmin(), lots.shape))) if made.any() else None
    assert watch.missing == expected
    watch.see(range(start, start + 1), np.ones((1, 3), bool), np.array([[-1, 0, -1]], dtype=np.int8))
    assert watch.missing is None


def test_changes_are_relative_for_amounts_and_plain_for_counts():
    first = rows(HIGH=[0.1, 0.1, 0.0], PEAK_FORCE=[1e6, 2e6, 0.0], COUNT=[3, 5, 0], YIELDS=[1, 2, 0])
    second = rows(HIGH=[0.1, 0.2, 0.0], PEAK_FORCE=[1e6, 1e6, 0.0], COUNT=[3, 7, 0], YIELDS=[2, 0, 0])
    found = changes(first, second, np.full(3, 1e6))
    assert found["peak_relative_displacement"].tolist() == [0.0, 0.5, 0.0]
    assert found["peak_contact_force"].tolist() == [0.0, 1.0, 0.0]
    assert found["impact_count"].tolist() == [0.0, 2.0, 0.0]
    assert found["yield_exceedance"].tolist() == [0.0, 1.0, 0.0]
    assert is_sensitive(found, 1e-6).tolist() == [False, True, False]


def test_a_change_from_nothing_or_to_nothing_has_no_percentage():
    """A touch that the tighter run has and the looser one has not, or the other way: by no unit of force, and not 1."""
    first, second = rows(PEAK_FORCE=[0.0, 5e3, 1e6, 0.0]), rows(PEAK_FORCE=[5e3, 0.0, 1e6, 0.0])
    found = changes(first, second, np.full(4, np.inf))
    assert found["peak_contact_force"].tolist() == [np.inf, np.inf, 0.0, 0.0]
    assert is_sensitive(found, 1e-6).tolist() == [True, True, False, False]
    dataset = scan(study(length="3 s"), check_fraction=1.0).squeeze("interface")
    force = dataset["change_peak_contact_force"]
    force.values[np.unravel_index(np.nanargmax(force.values), force.shape)] = np.inf
    told = dict(findings(dataset))["recomputed"]
    assert "peak contact force moves from or to 0 in 1;" in told and "inf" not in told


@pytest.mark.parametrize("column", ["HIGH", "PEAK_FORCE", "COUNT", "YIELDS"])
def test_each_output_alone_makes_a_run_sensitive(column):
    """A change just over the limit does, one just under it does not; counts and flags may not change at all."""
    values = {"HIGH": [0.1, 0.1], "PEAK_FORCE": [1e6, 1e6], "COUNT": [3.0, 3.0], "YIELDS": [1.0, 1.0]}
    first = rows(**values)
    moved = {"HIGH": [0.1 * (1 + 9e-4), 0.1 * (1 + 1.1e-3)], "PEAK_FORCE": [1e6 * (1 - 9e-4), 1e6 * (1 - 1.1e-3)]}
    moved |= {"COUNT": [3.0, 4.0], "YIELDS": [2.0, 0.0]}
    second = rows(**(values | {column: moved[column]}))
    assert is_sensitive(changes(first, second, np.full(2, 1e6)), 1e-3).tolist() == [False, True]


@pytest.mark.parametrize("which", [0, 1])
def test_a_run_that_fails_once_is_sensitive(which):
    pair = [rows(HIGH=[0.1]), rows(HIGH=[0.1])]
    pair[which][0, tally.STATUS] = tally.ENERGY_OPEN
    found = changes(*pair, np.full(1, np.inf))
    assert all(np.isnan(values).all() for values in found.values())
    assert is_sensitive(found, 1e-6).tolist() == [True]


def test_the_tolerance_of_the_second_run():
    assert tighter(1e-6) == pytest.approx(1e-8)
    assert tighter(1e-12) == tighter(1e-11) == 1e-12


def test_changes_are_those_of_two_scans():
    """Every run checked: the differences equal those of a whole scan at the tighter tolerance, to the bit."""
    loose = scan(study(1e-4), check_fraction=1.0, screening=False)
    tight = scan(study(tighter(1e-4)), check_fraction=0.0, screening=False)
    loose, tight = (one.squeeze("interface") for one in (loose, tight))
    assert (loose["sensitive"] >= 0).all()
    for name in ("peak_relative_displacement", "peak_contact_force"):
        expected = np.abs(loose[name] - tight[name]) / np.abs(tight[name])
        assert np.array_equal(loose[f"change_{name}"], expected)
        assert float(expected.max()) > 0.0
    assert np.array_equal(loose["change_impact_count"], np.abs(loose["impact_count"] - tight["impact_count"]))


def test_only_the_sample_has_values():
    dataset = scan(study(), check_fraction=0.2)
    checked = dataset["sensitive"] >= 0
    assert 1 <= int(checked.sum()) == counted(dataset)["recomputed"] < int(dataset["simulated"].sum())
    assert not (checked & (dataset["simulated"] == 0)).any()
    least = scan(study(), check_fraction=1e-9)
    assert int((least["sensitive"] >= 0).sum()) == 1, "one at least"
    assert not np.isnan(dataset["change_peak_contact_force"].values[checked.values]).any()
    assert np.isnan(dataset["change_peak_contact_force"].values[~checked.values]).all()
    assert (*dataset["sensitive"].dims, "interface") == dataset["impact_count"].dims


def test_no_check_leaves_no_variables():
    dataset = scan(study(length="3 s"), check_fraction=0.0)
    assert not [name for name in dataset if "change" in name or name == "sensitive"]
    assert list(findings(dataset)) == []


def test_a_lossless_pair_with_a_closed_gap_is_sensitive():
    """Elastic contacts, no damping, gap closed: late histories grow by orders of magnitude from rounding."""
    wild = scan(study(1e-6, "hertz", 0.0, "0.13 s", length="50 s", forces=()), check_fraction=1.0)
    assert int((wild["sensitive"] == 1).sum()) >= 1
    told = dict(findings(wild))
    assert "runs at rtol 1e-08" in told["recomputed"] and "moves by more than rtol" in told["sensitive"]


def test_what_does_not_move_moves_by_zero():
    dataset = scan(study(length="3 s"), check_fraction=1.0)
    for name in ("change_peak_relative_displacement", "change_peak_contact_force"):
        dataset[name] = dataset[name].where(dataset["sensitive"] < 0, 0.0)
    assert "peak contact force moves by 0 (median), 0 (largest)" in dict(findings(dataset))["recomputed"]


@pytest.mark.parametrize("fraction", [-0.1, 1.5, np.nan])
def test_a_share_outside_its_range_is_refused(fraction):
    with pytest.raises(PoundingError, match=r"check_fraction: .* at least 0 and at most 1"):
        scan(study(), check_fraction=fraction)


@pytest.mark.complete
def test_failed_runs_are_counted_and_not_made_again():
    stiff = study(law="jankowski", stiffness="1e30 N/m^1.5", forces=(), length="2 s")
    dataset = scan(stiff, check_fraction=1.0)
    failed = failures(dataset)
    assert sum(failed.values()) >= 1 and set(failed) < set(tally.STATUS_SENTENCES.values())
    bad = dataset["status"].values != tally.COMPLETE
    assert np.isnan(dataset["peak_relative_displacement"].values[bad]).all()
    assert (dataset["impact_count"].values[bad] == -1).all()
    assert (dataset["sensitive"].values[bad] == -1).all()
