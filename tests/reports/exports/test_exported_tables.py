"""Demands for pelicun and CSV tables hold the numbers of the dataset, with their units."""

import csv
from pathlib import Path

import numpy as np
import pytest
from scenes import BOTH, scene_text, single, storeyed

import pounding_risk as pr
from pounding_risk.studies.demo import text_of


@pytest.fixture(scope="module")
def results():
    """A row of a building with two storeys and a single mass, under two motions and their reverse."""
    text = scene_text(
        storeyed("flats", "100 t", "90 MN/m", "3 m", storeys=2, damping=0.05),
        single("a shop", "150 t", "0.4 s", height="3 m", damping=0.05),
        records={"names": ["RSN6-180", "RSN753-000"], "polarity": BOTH, "window": ["0 s", "10 s"], "pga": "0.4 g"},
        gap="5 mm",
    )
    return pr.scan(pr.read_scene(text))


def rows_of(file: Path) -> list[list[str]]:
    """The rows of a CSV file."""
    with file.open(newline="") as text:
        return list(csv.reader(text))


def test_demands_are_those_of_the_runs(results, tmp_path, says):
    written = pr.export(results, "pelicun", tmp_path / "demands")
    says([file.name for file in written.files])
    for file, ending in zip(written.files, ["", "_free"] * 2, strict=True):
        head, units, *rows = rows_of(file)
        place = list(results["building"].values).index("flats" if "flats" in file.name else "a shop")
        one = results.isel(building=place, gap=0, yield_force=0, contact_model=0)
        floors = int(one["building_storeys"])
        names = [
            "1-PFA-0-1",
            *(f"1-PFA-{k + 1}-1" for k in range(floors)),
            *(f"1-PID-{k + 1}-1" for k in range(floors)),
        ]
        assert head == ["", *names]
        assert units == ["Units", *["mps2"] * (floors + 1), *["rad"] * floors]
        values = np.array(rows, dtype=float)[:, 1:]
        assert len(values) == 4
        pga = np.repeat(0.4 * 9.80665, 4)
        accelerations = one[f"storey_acceleration{ending}"].values.reshape(4, -1)[:, :floors]
        ratios = one[f"storey_drift{ending}"].values.reshape(4, -1)[:, :floors] / 3.0
        assert values == pytest.approx(np.column_stack([pga, accelerations, ratios]), rel=1e-12)
    with_contact, without = (np.array(rows_of(file)[2:], dtype=float) for file in written.files[:2])
    assert (with_contact[:, 2] > without[:, 2]).any()  # a strike is felt


def test_demands_of_a_row_name_the_gaps_of_all_interfaces(tmp_path):
    row = pr.read_scene(text_of("row"), ["records.window=['0 s', '3 s']"])
    told = pr.export(pr.scan(row), "pelicun", tmp_path / "demands").notes[0]
    # Floors meet between flats and shop alone, where no F_E is given; the F_E of offices | flats is that of no contact.
    contacts = "jankowski, F_E = 400 kN of columns, floors without yielding"
    assert told == f"demands are those at gaps of 20 to 30 mm, {contacts}"


def test_single_masses_have_a_drift_ratio_where_their_height_is_known(tmp_path):
    pair = single("frame", "100 t", "0.8 s", height="6 m"), single("wall", "200 t", "0.3 s")
    text = scene_text(*pair, gap="10 mm", records={"window": ["0 s", "6 s"]})
    written = pr.export(pr.scan(pr.read_scene(text)), "pelicun", tmp_path / "demands")
    assert rows_of(written.files[0])[0] == ["", "1-PFA-0-1", "1-PFA-1-1", "1-PID-1-1"]
    assert rows_of(written.files[2])[0] == ["", "1-PFA-0-1", "1-PFA-1-1"]
    assert "wall: no storey drift ratios, as the scene gives it no heights" in written.notes


def test_motions_whose_run_failed_are_left_out_and_told(results, tmp_path):
    failed = results.copy(deep=True)
    failed["status"][{"record": 1, "polarity": 0}] = 1
    written = pr.export(failed, "pelicun", tmp_path / "demands")
    assert [row[0] for row in rows_of(written.files[0])[2:]] == ["0", "1", "3"]
    assert "1 run failed; their motions are in no file" in written.notes


def test_tables_hold_every_number(results, tmp_path):
    written = pr.export(results, "csv", tmp_path / "tables")
    seen = set()
    for file in written.files:
        head, *rows = rows_of(file)
        assert rows
        for column, name in enumerate(head):
            variable, _, unit = name.partition(" [")
            if variable not in results.data_vars or "flag_meanings" in results[variable].attrs:
                continue
            assert (unit.removesuffix("]") or "1") == results[variable].attrs.get("units", "1")
            values = results[variable].values.ravel()
            numbers = np.array([float(row[column]) for row in rows if row[column]])
            assert np.array_equal(numbers, values[np.isfinite(values)])
            seen.add(variable)
    own = {"record", "polarity", "gap", "yield_force"}
    numeric = {
        name
        for name in results.data_vars
        if own & set(results[name].dims) and "flag_meanings" not in results[name].attrs
    }
    assert seen == numeric - {"record_spectral_acceleration"}


def test_tables_say_the_gap_and_the_strength_of_each_row(results, tmp_path):
    """The axis gap is the gap of one interface, and stood alone beside the numbers of the others."""
    law = {"contact_model": "jankowski", "stiffness": "8e10 N/m^1.5", "restitution": 0.65}
    houses = [
        single(name, "150 t", period, height="3 m")
        for name, period in zip("ABC", ("0.4 s", "0.3 s", "0.5 s"), strict=True)
    ]
    text = scene_text(*houses, interfaces=[{"gap": "5 mm", **law}, {"gap": "60 mm", **law}])
    (file,) = (file for file in pr.export(pr.scan(pr.read_scene(text)), "csv", tmp_path / "row").files
               if file.name == "interfaces.csv")  # fmt: skip
    head, *rows = rows_of(file)
    own = {(row[head.index("interface")], row[head.index("interface_gap [m]")]) for row in rows}
    assert own == {("A | B", "0.005"), ("B | C", "0.06")}
    heads = {file.stem: set(rows_of(file)[0]) for file in pr.export(results, "csv", tmp_path / "tables").files}
    assert heads["contact_points"] >= {"contact_point_level [m]", "contact_point_yield_force [N]"}
    assert "floor_level [m]" in heads["storeys"] and "building_mass [kg]" not in heads["storeys"]
    assert "building_period [s]" in heads["buildings_without_contact"]


@pytest.mark.complete
def test_pelicun_reads_the_demands(results, tmp_path):
    """Where it is installed, which no extra of this project brings."""
    assessment = pytest.importorskip("pelicun.assessment")
    written = pr.export(results, "pelicun", tmp_path / "demands")
    asked = assessment.Assessment({"PrintLog": False, "Seed": 1})
    asked.demand.load_sample(str(written.files[0]))
    sample, units = asked.demand.save_sample(save_units=True)
    values = np.array(rows_of(written.files[0])[2:], dtype=float)[:, 1:]
    assert sample.to_numpy() == pytest.approx(values, rel=1e-12)
    assert set(units) == {"mps2", "rad"}
