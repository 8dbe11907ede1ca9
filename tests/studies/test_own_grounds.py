"""Scenes whose buildings stand on grounds of their own: keys, records, every command, displacements in space."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes import rigid, scene_text, single, storeyed
from sentences import refusal

import pounding_risk as pr
from pounding_risk import figures
from pounding_risk.errors import RecordError, SceneError
from pounding_risk.lab.stability.trial import shaking
from pounding_risk.models.ground import Support
from pounding_risk.motions.intensity import response_spectra
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.own_grounds import set_beside
from pounding_risk.questions import simulate as simulate_question
from pounding_risk.results.opened import Results
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import parse_scene

pytestmark = pytest.mark.complete

HINGE = 1.0 / (20.0 * np.pi)  # 1/ω of 10 Hz
FEW = {"gap": ["5 mm", "20 mm"]}


def pair(left: dict[str, Any] | None = None, right: dict[str, Any] | None = None, **more: Any) -> pr.Scene:
    """Two masses that meet, with further keys for each."""
    one, other = single("left", "10 t", "0.5 s", **(left or {})), single("right", "20 t", "0.3 s", **(right or {}))
    options = {"records": {"window": ["0 s", "6 s"]}, "grid": FEW, "law": "linear", "gap": "5 mm"} | more
    return parse_scene(scene_text(one, other, **options))


def scanned(scene: pr.Scene) -> Any:
    return pr.scan(scene, check_fraction=0.0)


def same_bits(one: Any, other: Any) -> None:
    """All that two scans hold beside what they say of their scenes and motions."""
    assert set(one.data_vars) == set(other.data_vars)
    for name in one.data_vars:
        if name != "record_spectral_acceleration":
            np.testing.assert_array_equal(one[name].values, other[name].values, err_msg=name)


def record(path: Path, samples: Any, dt: float = 0.01) -> str:
    """A file of samples [m/s²] in full digits, in a column."""
    times = dt * np.arange(len(samples))
    rows = [f"{time!r} {float(value)!r}" for time, value in zip(times.tolist(), samples, strict=True)]
    path.write_text("\n".join(["# time [s], acceleration [m/s^2]", *rows]) + "\n", encoding="utf-8")
    return str(path)


def of_file(path: str, **more: Any) -> dict[str, Any]:
    return {"files": [path], "processing": "none", "unit": "m/s^2", **more}


# -------------------------------------------------------------------------------------------------- keys


def test_keys_of_every_kind_are_read_and_written_back():
    keys = {"ground_factor": -1.0, "ground_delay": "40 ms", "ground_velocity": "-0.1 m/s", "ground_record": "RSN6-270"}
    typology = {"name": "T", "height": "9 m", "storeys": 3, "typology": "concrete_frame", "floor_mass": "50 t"}
    buildings = (
        single("M", "500 t", "0.5 s", height="9 m"),
        storeyed("S", "50 t", "80 MN/m", storeys=3, **keys),
        rigid("W", height="9 m", ground_factor=0.0),
        {**typology, **keys, "ground_record": ["RSN6-270"]},
    )
    between = {"gap": "20 mm", "contact_model": "linear", "stiffness": "1e5 kN/m"}
    scene = parse_scene(scene_text(*buildings, interfaces=[between]))
    support = Support(-1.0, 0.04, -0.1, ("RSN6-270",))
    assert [building.support for building in scene.buildings] == [Support(), support, Support(0.0), support]
    assert scene.supports == tuple(building.support for building in scene.buildings)
    assert parse_scene(scene.to_toml()) == scene
    assert pr.Scene(scene.buildings, scene.interfaces, pr.Records(["RSN6-180"])).supports == scene.supports
    assert "ground_" not in pair().to_toml()
    wall = pr.RigidWall("wall", ground_factor=0.0, ground_velocity=0.2)
    assert wall.structure().support == Support(0.0, velocity=0.2)


WAVE = {"wave_passage": {"velocity": "400 m/s", "distance": "30 m"}}
BETWEEN_WALLS = scene_text(
    *(rigid("W"), single("M", "10 t", "0.5 s"), rigid("E", ground_factor=-1.0)),
    interfaces=[{"gap": "10 mm", "contact_model": "stereomechanical", "restitution": 0.5}],
)
FAULTS = {
    "two delays": lambda: pair({"ground_delay": "0.1 s"}, {"ground_delay": "0.2 s"}),
    "a delay below zero": lambda: pair({}, {"ground_delay": "-0.1 s"}),
    "no record": lambda: pair({}, {"ground_record": []}),
    "an infinite factor": lambda: pair({}, {"ground_factor": "inf"}),
    "a delay beside a wave": lambda: pair({}, {"ground_delay": "0.1 s"}, effects=WAVE),
    "walls that would crush rigid bodies": lambda: parse_scene(BETWEEN_WALLS),
    "a delay longer than the record": lambda: scanned(pair({}, {"ground_delay": "7 s"})),
}


@pytest.mark.parametrize("words", FAULTS)
def test_what_grounds_cannot_be_is_refused(words, says):
    says(refusal(FAULTS[words], kind=SceneError))


def test_a_factor_may_stand_beside_a_wave():
    assert pair({}, {"ground_factor": -1.0}, effects=WAVE).supports == (Support(), Support(-1.0, 0.075))


# -------------------------------------------------------------------------------------------------- scans


LATE = [{"ground_delay": "0.5 s"}, {"ground_delay": "1 s"}, {"ground_delay": "0.4567 s"}]


@pytest.mark.complete
@pytest.mark.parametrize("keys", LATE, ids=str)
@pytest.mark.parametrize("solver", ["pair", "row"])
def test_a_building_that_is_reached_late_has_the_whole_motion(keys, solver):
    """Two equal buildings move alike, one later: equal peaks, by either solver; both are those of the motion alone."""
    one, other = (single(name, "40 t", "0.5 s", **own) for name, own in (("left", {}), ("right", keys)))
    records = {"names": ["RSN6-180"], "window": ["0 s", "3 s"], "polarity": ["as recorded"]}
    study = parse_scene(scene_text(one, other, law="linear", gap="2 m", records=records)).updated(
        is_row=solver == "row"
    )
    results, run = scanned(study), pr.simulate(study)
    peaks = results.peak_displacement_free.values.ravel()
    assert peaks[1] == pytest.approx(peaks[0], rel=1e-9)
    alone = response_spectra(motions_of(study)[0].without_tail().acceleration, 0.01, [0.5]).displacement[0]
    # A spectrum's peak is that of a parabola about the highest sample.
    assert peaks[0] == pytest.approx(alone, rel=1e-8)
    lag = study.lag
    assert 3.0 + lag - 1e-9 <= run["time"].values[-1] < 3.01 + lag
    widening = float(run.ground_widening[-1].values.ravel()[0])
    assert results.record_ground_widening_end.values.ravel()[0] == pytest.approx(widening, rel=1e-9)


def test_validate_says_how_long_a_run_lasts():
    plan = pr.validate(pair({}, {"ground_delay": "0.5 s"}, records={"window": ["0 s", "6 s"], "tail": "1 s"}))
    told = dict(plan.summary())["records"]
    assert told.endswith(
        "at least 1 s of free vibration after (whole time steps), 0.5 s longer for the building that is reached last"
    )
    assert plan.records[0].duration == pytest.approx(7.51)  # with the straight line to zero


def test_a_delay_alone_is_the_wave_to_the_bit():
    for towards, keys in (("right", ({}, {"ground_delay": "75 ms"})), ("left", ({"ground_delay": "75 ms"}, {}))):
        wave = {"wave_passage": {"velocity": "400 m/s", "distance": "30 m", "towards": towards}}
        one, other = scanned(pair(*keys)), scanned(pair(effects=wave))
        same_bits(one, other)
        assert one.record_ground_widening_largest.identical(other.record_ground_widening_largest)


def test_a_factor_of_all_buildings_is_that_of_the_records_to_the_bit():
    keys = {"ground_factor": 0.5}
    same_bits(scanned(pair(keys, keys)), scanned(pair(records={"window": ["0 s", "6 s"], "scale": 0.5})))


def test_a_record_of_its_own_that_is_the_shared_one_changes_no_bit(tmp_path):
    ground = shaking(4.0)[:300]
    path, copy = record(tmp_path / "a.txt", ground), record(tmp_path / "b.txt", ground)
    records = of_file(path, pga="0.4 g")
    own = pair({}, {"ground_record": copy}, records=records)
    assert motions_of(own)[0].own_grounds == ()
    same_bits(scanned(own), scanned(pair(records=records)))


def test_a_record_reversed_in_its_file_is_a_factor_of_minus_one_to_the_bit(tmp_path):
    ground = shaking(4.0)[:300]
    path, turned = record(tmp_path / "a.txt", ground), record(tmp_path / "b.txt", -ground)
    records = of_file(path, pga="0.4 g", polarity=["as recorded", "reversed"])
    own = scanned(pair({}, {"ground_record": turned}, records=records))
    same_bits(own, scanned(pair({}, {"ground_factor": -1.0}, records=records)))
    assert int(own.impact_count.max()) >= 3


def test_one_factor_scales_both_records(tmp_path):
    """To the PGA of the scene's record, which keeps the ratio that was recorded; in the grid too."""
    ground = shaking(4.0)[:300]
    path, other = record(tmp_path / "a.txt", ground), record(tmp_path / "b.txt", 0.5 * ground[::-1])
    for more in ({"records": of_file(path, pga="0.4 g")}, {"grid": {"pga": ["0.4 g"]}, "records": of_file(path)}):
        scene = pair({}, {"ground_record": other}, **more)
        wall = parse_scene(scene.to_toml())
        found = scanned(wall)
        assert found.record_pga_felt.values.ravel() == pytest.approx(0.4 * 9.80665)
    motion = motions_of(pair({}, {"ground_record": other}, records=of_file(path, pga="0.4 g")))[0]
    own = motion.own_grounds[1]
    assert np.abs(own).max() == pytest.approx(0.5 * motion.pga)
    assert any("beside it: b, times" in sentence for sentence in motion.processing)
    assert motion.digest != Motion("a", motion.acceleration, motion.dt, {}).digest


def test_a_record_for_each_record_of_the_scene(says):
    names = {"names": ["RSN6-180", "RSN1690-090"], "window": ["0 s", "6 s"]}
    scene = pair({}, {"ground_record": ["RSN6-270", "RSN6-270"]}, records=names)
    assert [len(motion.own_grounds) for motion in motions_of(scene)] == [2, 2]
    says(refusal(motions_of, pair({}, {"ground_record": ["RSN6-270", "RSN6-270"]}), kind=SceneError))


def test_bounds_hold_for_the_one_record_below_a_building():
    """Given that record the motions are independent: they stay two recordings, and the condition is stated."""
    names = {"names": ["RSN6-180", "RSN1690-090"], "window": ["0 s", "6 s"]}
    found = scanned(pair({}, {"ground_record": "RSN753-000"}, records=names))
    (note,) = [note for note in pr.assess(found).notes if "RSN753-000" in note]
    assert note.startswith("right: RSN753-000 stands below it in the motions of 2 recordings, which bounds count as")
    assert Results(found).recordings.tolist() == [0, 1]
    sisters = {"names": ["RSN6-180", "RSN6-270"], "window": ["0 s", "6 s"]}
    for key, records in ((["RSN753-000", "RSN77-164"], names), ("RSN753-000", sisters)):
        assert not any(
            "stands below" in note for note in pr.validate(pair({}, {"ground_record": key}, records=records)).notes
        )


def test_generated_motion_under_one_building():
    scene = pair({"ground_record": "harmonic: pga=0.2 g, period=0.4 s, cycles=5"})
    motion = motions_of(scene)[0]
    assert np.abs(motion.own_grounds[0]).max() == pytest.approx(0.2 * 9.80665, rel=1e-3)
    assert int(scanned(scene).impact_count.max()) >= 1


# -------------------------------------------------------------------------------------------------- beside each other


def motion(name: str, samples: Any, dt: float, **facts: Any) -> Motion:
    return Motion(name, np.asarray(samples, dtype=float), dt, facts)


def test_time_steps_that_fit_are_drawn_on_the_finer_one():
    fine, coarse = motion("fine", [0.0, 1.0, 2.0, 3.0, 4.0], 0.01), motion("coarse", [0.0, 4.0, 0.0], 0.02, factor=9.0)
    both = set_beside(fine, (None, coarse))
    np.testing.assert_array_equal(both.own_grounds[1], [0.0, 2.0, 4.0, 2.0, 0.0])
    other = set_beside(coarse, (fine, None))
    assert other.dt == 0.01
    np.testing.assert_array_equal(other.acceleration, [0.0, 2.0, 4.0, 2.0, 0.0])
    np.testing.assert_array_equal(other.own_grounds[0], 9.0 * fine.acceleration)


def test_records_of_unlike_length_end_with_zeros():
    long, short = motion("long", [0.0, 1.0, 2.0, 3.0], 0.01), motion("short", [0.0, 4.0], 0.01)
    np.testing.assert_array_equal(set_beside(long, (short, None)).own_grounds[0], [0.0, 4.0, 0.0, 0.0])
    grown = set_beside(short, (long, None))
    np.testing.assert_array_equal(grown.acceleration, [0.0, 4.0, 0.0, 0.0])
    assert any("zeros up to 0.03 s" in sentence for sentence in grown.processing)


def test_records_of_unlike_pads_begin_at_one_instant():
    """A filter keeps pads of its own length before each: 0.02 s and 0.01 s here."""
    first = motion("a", [0.0, 0.0, 1.0, 2.0, 0.0], 0.01, cut_from_start=-0.02)
    other = motion("b", [0.0, 4.0, 3.0, 0.0], 0.01, cut_from_start=-0.01)
    both = set_beside(first, (None, other))
    np.testing.assert_array_equal(both.own_grounds[1], [0.0, 0.0, 4.0, 3.0, 0.0])
    turned = set_beside(other, (first, None))
    np.testing.assert_array_equal(turned.acceleration, [0.0, 0.0, 4.0, 3.0, 0.0])
    assert turned.record["cut_from_start"] == -0.02
    assert any("zeros before b up to 0.01 s" in sentence for sentence in turned.processing)


def test_records_that_state_their_start_stand_at_that_time(says):
    """One recording, and a part of it that begins 0.03 s later, which stands on the samples that it was taken from."""
    whole, at = np.array([0.0, 1.0, -2.0, 3.0, 4.0, -5.0, 0.0]), "2019-07-06T03:19:{}"
    first = motion("whole", whole, 0.01, start=at.format("37.500000"))
    part = motion("part", whole[3:], 0.01, start=at.format("37.530000"))
    both = set_beside(first, (None, part))
    np.testing.assert_array_equal(both.own_grounds[1], [0.0, 0.0, 0.0, *whole[3:]])
    turned = set_beside(part, (first, None))
    np.testing.assert_array_equal(turned.acceleration, both.own_grounds[1])
    np.testing.assert_array_equal(turned.own_grounds[0], whole)
    assert turned.record["start"] == at.format("37.500000")
    apart = motion("part", whole[3:], 0.01, start=at.format("37.533000"))
    says(both.flags, turned.flags, set_beside(first, (None, apart)).flags)
    for start in ("", at.format("38.500000")):  # unknown, and of another earthquake: both begin together
        other = set_beside(first, (None, motion("other", whole[3:], 0.01, start=start)))
        np.testing.assert_array_equal(other.own_grounds[1], [*whole[3:], 0.0, 0.0, 0.0])
        assert not other.flags


def test_time_steps_that_do_not_fit_are_refused(says):
    fine, odd = motion("fine", [0.0, 1.0], 0.01), motion("odd", [0.0, 1.0], 0.015)
    says(refusal(set_beside, fine, (None, odd), kind=RecordError))


def test_what_is_done_to_a_motion_is_done_to_those_beside_it(says):
    both = set_beside(motion("a", [0.0, 1.0, 2.0], 0.01), (None, motion("b", [3.0, 0.0, 1.0], 0.01)))
    turned = both.scaled_to(4.0).reversed()
    np.testing.assert_array_equal(turned.own_grounds[1], [-6.0, -0.0, -2.0])
    says(refusal(both.cut, 0.0, 0.01, kind=RecordError))


# -------------------------------------------------------------------------------------------------- in space


def test_displacements_in_space_of_one_ground():
    """Under a constant acceleration the ground is at v t + a t²/2, and a floor there and where it is on it."""
    steady = {"kind": "constant_acceleration", "pga": "2 m/s^2", "duration": "1 s", "rise": "0 s"}
    speed = {"ground_velocity": "0.3 m/s"}
    scene = pr.Scene(
        [single("left", "10 t", "0.5 s", **speed), rigid(**speed)],
        [{"gap": "10 mm", "contact_model": "linear", "stiffness": "1e5 kN/m"}],
        {"generated": [steady]},
    )
    run = pr.simulate(scene)
    run = run.isel(time=run.time <= 1.0)  # then it stops within a sample
    time = run.time.values
    known = 0.3 * time + time**2
    for building in (0, 1):
        np.testing.assert_allclose(run.ground_displacement.isel(building=building), known, rtol=1e-11, atol=1e-15)
    moved = run.absolute_displacement.isel(building=0, storey=0)
    np.testing.assert_allclose(moved, known + run.displacement.isel(building=0, storey=0), rtol=1e-12)
    assert "relative to the ground under the building" in run.displacement.attrs["long_name"]
    assert "building_ground_acceleration" not in run


def test_displacements_in_space_close_the_gap():
    """δ = X_left − X_right, whatever the grounds do."""
    keys = {"ground_factor": -0.7, "ground_delay": "33 ms", "ground_velocity": "0.02 m/s"}
    run = pr.simulate(pair({}, keys))
    space = run.absolute_displacement.isel(storey=0)
    closing = space.isel(building=0) - space.isel(building=1)
    np.testing.assert_allclose(run.relative_displacement.isel(contact_point=0), closing, atol=1e-13)
    grounds = run.ground_displacement
    widening = grounds.isel(building=1) - grounds.isel(building=0)
    np.testing.assert_allclose(run.ground_widening.isel(interface=0), widening, atol=1e-13)


def test_twins_in_space_and_a_wall_that_stands_there():
    """The scene SDND102 A and its other form: half the gap, twice the stiffness, a wall on ground that never moves."""
    speed = f"{-HINGE!r} m/s"
    twin = {"mass": "25 kg", "stiffness": "98696 N/m", "damping": 0.07}
    records = {"generated": [{"kind": "harmonic", "pga": "1 m/s^2", "period": "0.1 s", "cycles": 10, "step": "1 ms"}]}

    def run(right: dict[str, Any], gap: str, stiffness: str) -> Any:
        scene = pr.Scene(
            [{"name": "left", **twin, "ground_velocity": speed}, right],
            [{"gap": gap, "contact_model": "linear", "stiffness": stiffness}],
            records,
        )
        return pr.simulate(scene.replace(rtol=1e-10))

    other = {"name": "right", **twin, "ground_factor": -1.0, "ground_velocity": f"{HINGE!r} m/s"}
    both = run(other, "1 mm", "2.88e7 N/m")
    wall = run({"name": "wall", "rigid": True, "ground_factor": 0.0}, "0.5 mm", "5.76e7 N/m")
    assert int(both.impact_count[0]) == int(wall.impact_count[0]) == 10
    samples = np.linspace(0.0, 1.0, 101)
    one, twin_of, alone = (
        np.interp(samples, each.time, each.absolute_displacement.isel(building=b, storey=0))
        for each, b in ((both, 0), (both, 1), (wall, 0))
    )
    np.testing.assert_allclose(one, alone, atol=1e-11)
    np.testing.assert_allclose(one, -twin_of, atol=1e-11)
    assert (wall.ground_displacement.isel(building=1) == 0.0).all()


def test_a_figure_in_space_says_so(says):
    run = pr.simulate(pair({}, {"ground_factor": -1.0}))
    labels = [axis.get_ylabel() for axis in figures.simulation_figure(run, absolute=True).axes]
    assert "displacement\nin space [mm]" in labels and "relative\ndisplacement [mm]" in labels
    assert "displacement\nin space [mm]" not in [axis.get_ylabel() for axis in figures.simulation_figure(run).axes]
    says(
        refusal(simulate_question.check, {"absolute": True}),
        refusal(figures.simulation_figure, run.drop_vars("absolute_displacement"), absolute=True),
    )


# -------------------------------------------------------------------------------------------------- commands


def test_what_grounds_do_to_the_gap_is_told_and_kept():
    scene = pair({}, {"ground_velocity": "-0.01 m/s"})
    (note,) = [note for note in pr.validate(scene).notes if "against each other" in note]
    assert "left | right: their grounds move by up to 60 mm against each other (RSN6-180, at 6 s)" in note
    assert "60 mm are left at the end" in note
    found = scanned(scene)
    assert note in found.attrs["notes"]
    assert found.record_ground_widening_largest.values == pytest.approx(0.06)
    assert found.record_ground_widening_end.values == pytest.approx(-0.06)
    assert "record_ground_widening_end" not in scanned(pair()).coords


def test_the_gap_that_is_needed_knows_the_grounds():
    found = scanned(pair({}, {"ground_factor": -1.0}))
    run = pr.simulate(pair({}, {"ground_factor": -1.0}), gap=10.0)
    assert found.peak_closing_free.item() == pytest.approx(float(run.peak_closing[0]), rel=1e-12)


def test_other_commands(tmp_path):
    """Results run again to the bit; histories have both displacements; other methods are left out, and it is said."""
    scene = pair({}, {"ground_factor": -1.0, "ground_velocity": "0.02 m/s"})
    results = tmp_path / "a.nc"
    pr.scan(scene, results, check_fraction=0.0)
    assert pr.rerun(results).same
    with pr.open_results(pr.histories(scene, tmp_path / "h.nc")) as written:
        whole = written.absolute_displacement - written.ground_displacement - written.displacement
        assert float(np.abs(whole).max()) < 1e-15
    bench = pr.accuracy(scene, cases=1)
    assert "ground of a building's own" in bench.attrs["left_out"]
    table = pr.effects(pair({}, {"ground_delay": "50 ms"}), repeats=1)
    assert "wave_passage" not in table.attrs["effects"] and "wave_passage" in table.attrs["left_out"]
    assert "stands on the motion times -1, ground that moves at 20 mm/s at first" in str(pr.validate(scene))


def row(**last: Any) -> pr.Scene:
    """Two equal buildings of two storeys and a wall, on three grounds."""
    storeys = {"masses": "40 t", "stiffnesses": "30 MN/m", "storeys": 2}
    left = storeyed("A", **storeys)
    middle = storeyed("B", **storeys, ground_factor=0.8, ground_delay="25 ms")
    between = {"gap": "10 mm", "contact_model": "linear", "stiffness": "1e5 kN/m"}
    return parse_scene(
        scene_text(left, middle, rigid("C", **last), interfaces=[between], records={"window": ["0 s", "4 s"]}, grid=FEW)
    )


def test_a_row_in_space(tmp_path):
    """What closes the gap at each contact point is the difference of its floors in space; scans and runs agree."""
    scene = row(ground_record="RSN6-270", ground_velocity="-0.01 m/s")
    run = pr.simulate(scene, gap="5 mm")
    space = run.absolute_displacement.values
    wall = run.ground_displacement.isel(building=2).values
    for number, point in enumerate(run.contact_point.values):
        closing = run.relative_displacement.isel(contact_point=number).values
        left, right = (int(run[f"contact_point_{side}_floor"][number]) for side in ("left", "right"))
        at = int(run.contact_point_interface[number])
        other = wall if at == 1 else space[:, 1, right - 1]
        np.testing.assert_allclose(closing, space[:, at, left - 1] - other, atol=1e-12, err_msg=str(point))
    assert int(run.impact_count.sum()) >= 2
    np.testing.assert_allclose(np.diff(run.ground_displacement.values, axis=1), run.ground_widening, atol=1e-12)
    found = pr.scan(scene, tmp_path / "row.nc", check_fraction=0.0)
    np.testing.assert_array_equal(run.peak_contact_force, found.peak_contact_force.isel(gap=0).values.ravel())
    assert found.record_ground_widening_largest.shape == (1, 2)
    assert (
        found.peak_floor_acceleration_free.isel(building=2).item() == np.abs(motions_of(scene)[0].own_grounds[2]).max()
    )
    assert pr.rerun(tmp_path / "row.nc").same
    bench = pr.accuracy(scene, cases=1)
    assert "ground of a building's own" in bench.attrs["left_out"]


def test_kernels_are_compiled_with_made_motions():
    """What stands beside a record is left out: the kernels are those of unlike grounds all the same."""
    scene = pair({}, {"ground_record": "RSN6-270"})
    kept = pr.cache(scene)
    pr.scan(scene, check_fraction=0.0)
    assert pr.cache() == kept


def test_a_record_that_is_not_there_is_told_when_the_scene_is_read(says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    says(
        refusal(pair, {}, {"ground_record": "nowhere.AT2"}, kind=SceneError),
        refusal(pair, {}, {"ground_record": ["RSN6-270", "nowhere.AT2"]}, kind=SceneError),
    )


def test_results_find_records_of_buildings_in_another_folder(tmp_path, says):
    ground = shaking(4.0)[:200]
    home, away = tmp_path / "home", tmp_path / "away"
    for folder in (home, away):
        folder.mkdir()
        record(folder / "a.txt", ground)
        record(folder / "b.txt", -0.5 * ground)
    one, other = single("left", "10 t", "0.5 s"), single("right", "20 t", "0.3 s", ground_record="b.txt")
    text = scene_text(one, other, records=of_file("a.txt", pga="0.3 g"), law="linear")
    (home / "scene.toml").write_text(text, encoding="utf-8")
    results = pr.scan(home / "scene.toml", away / "r.nc", check_fraction=0.0)
    (beside,) = json.loads(results.attrs["records"])[0]["beside"]
    assert beside["name"] == "b" and len(beside["sha256"]) == 64
    (home / "b.txt").unlink()
    assert pr.rerun(away / "r.nc").same  # beside the results
    record(away / "b.txt", 0.5 * ground)
    assert any("another motion" in note for note in pr.rerun(away / "r.nc").notes)
    (away / "b.txt").unlink()
    says(refusal(pr.rerun, away / "r.nc"))
