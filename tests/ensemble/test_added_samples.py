"""Samples that are added to a finished scan: the others are not solved again, and the whole is that of one scan."""

from __future__ import annotations

import pytest
from axes import same_scan
from sentences import refusal
from uncertain import RESTITUTION, THREE, uncertain_row_text, uncertain_text

from pounding_risk.ensemble import pair_job
from pounding_risk.ensemble.chunks import parted
from pounding_risk.ensemble.scan import scan, scan_shard
from pounding_risk.ensemble.status import status
from pounding_risk.results.files import open_results, save
from pounding_risk.scene.reader import parse_scene


def asked(samples, numbers=None, **more):
    return parse_scene(uncertain_text(numbers, samples=samples, **more))


@pytest.fixture
def solved(monkeypatch):
    """The scenes' numbers whose batches are solved."""
    numbers = []
    whole = pair_job.PairJob.solve

    def solve(self, batches, *stop):
        numbers.extend([self.number] * len(batches))
        return whole(self, batches, *stop)

    monkeypatch.setattr(pair_job.PairJob, "solve", solve)
    return numbers


@pytest.mark.complete
@pytest.mark.parametrize(("name", "first", "whole"), [("r.nc", 8, 16), ("r.zarr", 2, 3)])
def test_eight_and_eight_samples_are_sixteen(tmp_path, name, first, whole):
    """Every variable to the bit, and the attributes; the file that is replaced held the first of them."""
    target = tmp_path / name
    scan(asked(first), target, check_fraction=0.1)
    at_once = scan(asked(whole), check_fraction=0.1)
    same_scan(scan(asked(whole), target, check_fraction=0.1), at_once)
    same_scan(open_results(target), at_once)


@pytest.mark.complete
def test_only_the_missing_samples_are_solved(tmp_path, solved):
    target = tmp_path / "r.nc"
    scan(asked(4), target, check_fraction=0.0)
    solved.clear()
    scan(asked(7), target, check_fraction=0.0)
    assert sorted(set(solved)) == [4, 5, 6] and len(solved) == 3 * 2 * 2  # polarities and gaps
    assert not list((tmp_path / "r.study" / "parts").iterdir())


@pytest.mark.complete
def test_samples_beside_an_axis_are_added(tmp_path):
    """The axis of the restitution is faster than the samples, that of damping slower."""
    axes = {"interface.restitution": [0.5, 0.8], "building.right.damping": [0.02, 0.05]}
    numbers = {"building.left.period": THREE["building.left.period"], "method": "random"}
    target = tmp_path / "r.nc"
    scan(asked(2, numbers, axes=axes), target, check_fraction=0.0)
    added = scan(asked(3, numbers, axes=axes), target, check_fraction=0.0)
    same_scan(added, scan(asked(3, numbers, axes=axes), check_fraction=0.0))


def test_samples_of_a_row_are_added(tmp_path):
    """With the counts of its parts, and motions without contact that do not differ."""
    first, whole = (parse_scene(uncertain_row_text({"interface.restitution": RESTITUTION}, count)) for count in (1, 3))
    target = tmp_path / "r.nc"
    scan(first, target, check_fraction=0.0)
    same_scan(scan(whole, target, check_fraction=0.0), scan(whole, check_fraction=0.0))


def test_adding_goes_on_where_it_was_stopped(tmp_path, solved):
    """After one of two shards; the finished file stays until the whole is written."""
    target = tmp_path / "r.nc"
    scan(asked(2), target, check_fraction=0.0)
    before = target.read_bytes()
    state = scan_shard(asked(4), target, "2/2", check_fraction=0.0)
    assert (state.cases, state.done, state.total) == (8, 8 + 4, 16)  # half of the grid, half of which was known
    assert target.read_bytes() == before and status(target).cases == 12
    solved.clear()
    added = scan(asked(4), target, check_fraction=0.0)
    assert len(solved) == 4 and set(solved) <= {2, 3}
    same_scan(added, scan(asked(4), check_fraction=0.0))


def test_what_is_another_study_is_not_added_to(tmp_path, says):
    """Nor a selection of the same one."""
    four = scan(asked(4), tmp_path / "r.nc", check_fraction=0.0)
    part = save(four.isel(sample=slice(0, 2)), tmp_path / "part.nc")
    wider = THREE | {"building.left.mass": {"distribution": "normal", "mean": "500 t", "cov": 0.2}}
    others = asked(8, wider), asked(8, THREE | {"seed": 2}), asked(2), asked(8, solver={"rtol": 1e-7})
    says([refusal(scan, other, tmp_path / "r.nc", check_fraction=0.0) for other in others])
    says(refusal(scan, asked(8), tmp_path / "r.nc", check_fraction=0.5))
    says(refusal(scan, asked(8), part, check_fraction=0.0))


@pytest.mark.complete
def test_a_latin_hypercube_cannot_be_added_to(tmp_path, says):
    numbers, target = THREE | {"method": "latin hypercube"}, tmp_path / "r.nc"
    scan(asked(2, numbers), target, check_fraction=0.0)
    says(refusal(scan, asked(4, numbers), target, check_fraction=0.0))
    assert scan(asked(4, numbers), target, check_fraction=0.0, new=True).sizes["sample"] == 4


def test_ranges_are_parted_into_what_is_known_and_what_is_not():
    known = [range(2, 4), range(6, 9)]
    quarters = [range(start, start + 2) for start in range(0, 8, 2)]
    assert list(parted(range(0, 8), known)) == list(zip(quarters, (False, True, False, True), strict=True))
    assert list(parted(range(2, 3), known)) == [(range(2, 3), True)]
    assert list(parted(range(4, 6), [])) == [(range(4, 6), False)]
