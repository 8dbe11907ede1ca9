"""Every dataset that a command writes keeps to the CF conventions that it declares, by the checker of IOOS."""

import json
import re
from datetime import UTC, datetime
from functools import lru_cache
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest
from scenes import scene_text, storeyed, two_records

import pounding_risk as pr
from pounding_risk._common.dates import created, now
from pounding_risk.errors import PoundingError
from pounding_risk.results.files import open_results, save
from pounding_risk.results.labels import CONVENTIONS
from pounding_risk.scene.reader import parse_scene

# A law that other tests compile too, in fixed steps and under a passing wave.
PAIR = two_records(law="viscous_elastoplastic")
PAIR = PAIR.replace('["5 mm", "10 mm", "20 mm", "40 mm"]', '["5 mm", "20 mm"]\nyield_force = ["100 kN", "inf"]')
AXES = """"building.left.mass" = ["10 t", "15 t"]
"building.right.period" = ["0.25 s", "0.3 s"]
zip = [["building.left.mass", "building.right.period"]]
"interface.restitution" = [0.5, 0.8]
"""
WAVE = '[effects]\nwave_passage = {velocity = "500 m/s", distance = "9 m"}\n'
ROW = scene_text(
    storeyed("A", ["20 t", "20 t"], "40 MN/m"),
    storeyed("B", ["30 t"], "90 MN/m"),
    law="linear",
    gap="5 mm",
    records={"window": ["0 s", "8 s"]},
    grid={"gap": ["5 mm", "20 mm"], "pga": ["0.3 g"]},
)


def written_by(command: str, folder: Path) -> Path:
    """A dataset of this command."""
    file = folder / f"{command.replace(' ', '-')}.nc"
    name, _, kind = command.partition(" ")
    study, laws = parse_scene(ROW if kind == "row" else PAIR), ["linear", "viscous_elastoplastic"]
    states = [pr.DamageState("tiles", displacement="9 mm"), pr.DamageState("blow", contact_force="1 kN")]
    write = {
        "scan": lambda: pr.scan(study, file, check_fraction=0.4),
        "simulate": lambda: save(pr.simulate(study), file),
        "histories": lambda: pr.histories(study, file, gaps=[0.005], most=20),
        "compare": lambda: pr.compare(study, file, laws=laws),
        "compare_along": lambda: pr.compare(parse_scene(PAIR + AXES), file, laws=laws),
        "accuracy": lambda: pr.accuracy(study, file, cases=2, budget=0.2, scipy=False),
        "damage": lambda: save(pr.damage(pr.scan(study, check_fraction=0.0), states=states, method="ida"), file),
        "effects": lambda: pr.effects(parse_scene(PAIR + WAVE), file, repeats=1),
    }
    write[name]()
    return file


# The axis counts seconds from the start of a record, which has no date here. CF keeps the standard name "time" for
# times since a date, so that giving it, as the checker recommends, would be false.
NO_DATE = "Coordinate variable 'time' should have standard_name='time', found: 'None'"
# CF recommends names of letters, digits and underscores, and requires none. The name of an axis of numbers is the
# address of what varies along it, as `--set` takes it.
AN_ADDRESS = re.compile(r"(variable|dimension) (building|interface|effects)\.[\w.]+ should begin with ")
COMMANDS = ["scan row", "simulate row", "histories row", "scan pair", "simulate pair", "histories pair", "damage pair"]
COMMANDS += ["effects", "accuracy", "compare", "compare_along"]


def complaints(file: Path, folder: Path) -> list[str]:
    """What the checker says against a file, of any weight."""
    from compliance_checker import runner

    runner.CheckSuite.load_all_available_checkers()
    told = folder / "told.json"
    version = CONVENTIONS.removeprefix("CF-")
    asked = (str(file), [f"cf:{version}"], 0, "strict")
    runner.ComplianceChecker.run_checker(*asked, output_filename=str(told), output_format=["json"])
    (found,) = json.loads(told.read_text()).values()
    weights = ("high_priorities", "medium_priorities", "low_priorities")
    return [
        f"{each['name']}: {line}"
        for weight in weights
        for each in found[weight]
        for line in each["msgs"]
        if line != NO_DATE and not AN_ADDRESS.match(line)
    ]


@pytest.fixture
def looked_at_once(monkeypatch) -> None:
    """What the checker asks of a whole file at each of its variables, it finds once: half of its time."""
    from compliance_checker.cf import util

    for name in ("get_auxiliary_coordinate_variables", "get_climatology_variable", "get_cell_boundary_variables"):
        monkeypatch.setattr(util, name, lru_cache(maxsize=1)(getattr(util, name)))


@pytest.mark.complete
@pytest.mark.usefixtures("looked_at_once")
@pytest.mark.parametrize("command", COMMANDS)
def test_the_checker_has_nothing_against_it_but_sees_faults(command, tmp_path):
    """Faults: a unit that is none, and a variable without a name for people."""
    file = written_by(command, tmp_path)
    dataset = open_results(file)
    assert dataset.attrs["Conventions"] == CONVENTIONS
    assert complaints(file, tmp_path) == []
    # The checker's own look at this fails on axes of texts, and then says nothing of numbers either.
    for axis in dataset.dims:
        if axis in dataset.coords and dataset[axis].dtype.kind in "if":
            steps = np.diff(dataset[axis].values)
            assert (steps > 0.0).all() or (steps < 0.0).all(), axis
    if command == "scan row":
        dataset["peak_drift"].attrs["units"] = "furlong of mine"
        del dataset["peak_displacement"].attrs["long_name"]
        save(dataset[["peak_drift", "peak_displacement"]], tmp_path / "faulty.nc")
        told = " ".join(complaints(tmp_path / "faulty.nc", tmp_path))
        assert "furlong of mine" in told and "peak_displacement" in told


def test_when_a_dataset_was_made_and_by_what(tmp_path, monkeypatch):
    """At the time that the environment fixes, or now; of a study that goes on, when it was begun."""
    assert now() == "2023-11-14T22:13:20+00:00"  # 1700000000 s after 1970, by the calendar of any Unix
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    before = datetime.now(UTC).replace(microsecond=0)
    made = datetime.fromisoformat(created("x")["date_created"])
    assert before <= made <= datetime.now(UTC)
    study = parse_scene(PAIR)
    first = pr.scan(study, tmp_path / "a.nc", command="pounding-risk scan a.toml -o a.nc")
    begun = json.loads((tmp_path / "a.study" / "study.json").read_text())["begun"]
    version = metadata.version("pounding-risk")
    assert first.attrs["date_created"] == begun
    assert first.attrs["history"] == f"{begun} pounding-risk scan a.toml -o a.nc (pounding-risk {version})"
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1800000000")
    kept = (tmp_path / "a.nc").read_bytes()
    pr.scan(study, tmp_path / "a.nc", command="pounding-risk scan a.toml -o a.nc")
    assert (tmp_path / "a.nc").read_bytes() == kept  # the same study, begun then
    pr.scan(study, tmp_path / "a.nc", new=True)
    assert open_results(tmp_path / "a.nc").attrs["date_created"] == "2027-01-15T08:00:00+00:00"
    for wrong in ("today", "-5", "9" * 30):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", wrong)
        with pytest.raises(PoundingError, match=re.escape(f"SOURCE_DATE_EPOCH is '{wrong}'")):
            now()
