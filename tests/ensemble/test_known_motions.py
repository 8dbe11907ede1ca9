"""Buildings that move as files say: closings, gaps and P(contact) of a scan of the buildings that wrote the files."""

from pathlib import Path
from typing import Any

import commands
import numpy as np
import pytest
from lxml.html import document_fromstring
from scenes import rigid, scene_text, single, storeyed
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.demands import is_linear
from pounding_risk.ensemble import known_job
from pounding_risk.ensemble.known_job import extremes
from pounding_risk.results.opened import Results
from pounding_risk.results.variables import UNPUSHED
from pounding_risk.scene.known_motions import read_history
from pounding_risk.scene.reader import parse_scene

RECORDS = ("RSN6-180", "RSN753-000")  # of time steps of 10 and 5 ms
FRAME = storeyed("frame", ["60 t", "60 t", "50 t"], "30 MN/m", ["3 m"] * 3)
HALL = single("hall", "90 t", "0.3 s", height="7.2 m")  # its floor faces the columns of storey 3, 0.4 up
YIELDING = FRAME | {"storey_strengths": "150 kN"}
INELASTIC = {"inelastic_storeys": {"hardening": 0.05}}
GAPS = ["5 mm", "45 mm", "4 m"]
POINT = "contact_point_peak_closing_free"


def text_of(*buildings: dict[str, Any], effects: Any = None, **records: Any) -> str:
    """A scene of these buildings under both records, 15 s of each."""
    given = {"names": list(RECORDS), "window": ["0 s", "15 s"]} | records
    return scene_text(*buildings, records=given, effects=effects, grid={"gap": GAPS}, gap="45 mm")


def write(path: Path, times: np.ndarray, floors: np.ndarray, unit: float = 1e3) -> str:
    """A history [s, m] in mm, every digit kept; returns the name of the file."""
    head = ",".join(["time [s]", *(f"floor {floor} [mm]" for floor in range(1, floors.shape[1] + 1))])
    rows = [",".join(map(repr, map(float, (time, *(unit * row))))) for time, row in zip(times, floors, strict=True)]
    path.write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    return path.name


@pytest.fixture(scope="module", params=["linear", "inelastic"])
def reference(request, tmp_path_factory) -> tuple[Path, Any, dict[str, np.ndarray], dict[str, dict[str, Any]], Any]:
    """Folder, scan, times by record, motions (time, floor) by building and record; the frame and the effects."""
    folder = tmp_path_factory.mktemp(request.param)
    effects = INELASTIC if request.param == "inelastic" else None
    frame = YIELDING if effects else FRAME
    study = parse_scene(text_of(frame, HALL, effects=effects))
    pr.histories(study, folder / "h.nc", gaps=["4 m"])
    alone = pr.open_results(folder / "h.nc")
    times, moved = {}, {"frame": {}, "hall": {}}
    for record in RECORDS:
        one = alone.sel(record=record).isel(polarity=0, contact_model=0, gap=0, yield_force=0, missing_dims="ignore")
        time = one["time"].values
        known = np.isfinite(time)
        times[record] = time[known]
        for name, floors in (("frame", 3), ("hall", 1)):
            values = one["displacement"].sel(building=name).transpose("sample", "storey").values
            moved[name][record] = values[known, :floors]
    return folder, pr.scan(study, check_fraction=0.0), times, moved, (frame, effects)


def with_files(building: dict[str, Any], moved: dict[str, Any], times: Any, folder: Path) -> dict[str, Any]:
    """The building with its motion in files, one for each record."""
    name = building["name"]
    files = [write(folder / f"{name}-{record}.csv", times[record], floors) for record, floors in moved.items()]
    return building | {"displacement_history": files}


def scanned(folder: Path, *buildings: dict[str, Any], effects: Any = None, **records: Any) -> Any:
    path = folder / "scene.toml"
    path.write_text(text_of(*buildings, effects=effects, **records), encoding="utf-8")
    return pr.scan(path, check_fraction=0.0)


def at_level(frame: np.ndarray) -> np.ndarray:
    """The frame at 7.2 m, 0.4 up its storey 3."""
    return 0.6 * frame[:, 1] + 0.4 * frame[:, 2]


def test_both_known_are_the_reference_at_its_samples(reference):
    """By numpy from the samples, to rounding of the files; the reference's peaks between them by h² |ü| / 8 at most."""
    folder, computed, times, moved, (frame, effects) = reference
    buildings = (with_files(one, moved[one["name"]], times, folder) for one in (frame, HALL))
    known = scanned(folder, *buildings, effects=effects)
    for record in RECORDS:
        apart = at_level(moved["frame"][record]) - moved["hall"][record][:, 0]
        found = known[POINT].sel(record=record).item()
        assert found == pytest.approx(apart.max(), rel=1e-9)
        missed = computed[POINT].sel(record=record).item() - found
        # The second difference is that of ü at samples; between them it is a quarter more at most in these motions.
        assert -1e-12 < missed <= 1.25 * np.abs(np.diff(apart, 2)).max() / 8.0
        for name in ("frame", "hall"):
            peak = known["peak_displacement_free"].sel(record=record, building=name).item()
            assert peak == pytest.approx(np.abs(moved[name][record]).max(), rel=1e-9)
        drifts = np.abs(np.diff(moved["frame"][record], axis=1, prepend=0.0)).max(axis=0)
        found = known["storey_drift_free"].sel(record=record, building="frame").values.ravel()
        np.testing.assert_allclose(found, drifts, rtol=1e-9)
        assert np.isnan(known["storey_acceleration_free"].sel(record=record).values).all()
    answers = [pr.assess(one, target="20 %") for one in (computed, known)]
    theirs, ours = (one.interfaces[0].contact for one in answers)
    assert ours == theirs and (ours[0].count, ours[-1].count) == (2, 0)  # every share with its bounds
    for required, expected in zip(answers[1].interfaces[0].required, answers[0].interfaces[0].required, strict=True):
        assert required.gap == pytest.approx(expected.gap, rel=5e-3)  # of samples: peaks lie between them
    assert not is_linear(Results(known))
    assert not effects or float(computed["storey_ductility_free"].max()) > 1.5


@pytest.mark.parametrize("which", ["frame", "hall"])
def test_one_known_beside_one_computed(reference, which):
    """At samples of both the closing of the reference, or what the computed one does between them.

    That is a cubic by displacement and velocity: with h = 5 and 10 ms and T = 0.3 s its error of h⁴/384 ω⁴ u is below
    1e-5 of u. The known one is straight there, so that the peak is the reference's within h² |ü| / 8.
    """
    folder, computed, times, moved, (frame, effects) = reference
    sides = [one if one["name"] != which else with_files(one, moved[which], times, folder) for one in (frame, HALL)]
    known = scanned(folder, *sides, effects=effects)
    for record in RECORDS:
        apart = at_level(moved["frame"][record]) - moved["hall"][record][:, 0]
        found = known[POINT].sel(record=record).item()
        assert found >= apart.max() * (1.0 - 1e-9)
        missed = computed[POINT].sel(record=record).item() - found
        assert -1e-5 * apart.max() < missed <= 1.25 * np.abs(np.diff(apart, 2)).max() / 8.0
    other = "hall" if which == "frame" else "frame"
    theirs, ours = (one["storey_displacement_free"].sel(building=other).values for one in (computed, known))
    np.testing.assert_array_equal(ours, theirs)  # what is computed has the same bits


def test_beside_a_building_that_stands_still_the_closing_is_that_of_a_wall(tmp_path):
    """Of the solver's own peaks between samples; what is left is the cubics' error, h⁴/384 max|d⁴u/dt⁴|.

    Modes of 0.6, 0.22 and 0.15 s at h = 10 ms: (2 π h / T)⁴ / 384 is below 1e-4 of the third mode's share, which is
    some hundredth of the displacement.
    """
    still = write(tmp_path / "still.csv", np.arange(0.0, 15.001, 0.5), np.zeros((31, 1)))
    tall, window = HALL | {"height": "9 m"}, {"window": ["0 s", "15 s"]}
    known = scanned(tmp_path, FRAME, tall | {"displacement_history": [still] * 2}, **window)
    wall = pr.scan(parse_scene(text_of(FRAME, rigid(height="9 m"))), check_fraction=0.0)
    exact, found = wall[POINT].isel(contact_point=-1).values, known[POINT].isel(contact_point=-1).values
    np.testing.assert_allclose(found, exact, rtol=1e-6)


@pytest.fixture(scope="module")
def sines(tmp_path_factory) -> tuple[Path, dict[str, Any], dict[str, Any], tuple[np.ndarray, ...]]:
    """Folder, frame and hall with motions of unlike time steps, the hall's uneven; and these motions."""
    folder = tmp_path_factory.mktemp("sines")
    slow = np.arange(0.0, 15.0001, 0.02)
    uneven = np.append(np.cumsum(np.resize([0.007, 0.004, 0.011], 2040)), 15.0)  # without a sample at 0 s
    frame = np.stack([0.01 * floor * np.sin(2.0 * np.pi * slow / 0.7) for floor in (1, 2, 3)], axis=1)
    hall = (0.02 * np.sin(2.0 * np.pi * uneven / 0.45))[:, None]
    one = FRAME | {"displacement_history": [write(folder / "frame.csv", slow, frame)] * 2}
    other = HALL | {"displacement_history": [write(folder / "hall.csv", uneven, hall)] * 2}
    return folder, one, other, (slow, frame, uneven, hall)


def test_histories_of_unlike_time_steps_are_straight_between_their_samples(sines):
    """The largest difference of two polygons is at a corner of either; by numpy's interpolation."""
    folder, frame, hall, (slow, moved, uneven, beside) = sines
    known = scanned(folder, frame, hall)
    corners = np.unique([*slow, *uneven])
    right = np.interp(corners, [0.0, *uneven], [0.0, *beside[:, 0]])  # from rest up to its first sample
    apart = np.interp(corners, slow, at_level(moved)) - right
    assert known[POINT].values.ravel() == pytest.approx([apart.max()] * 2, rel=1e-9)
    run = known.isel(gap=-1)
    assert run["peak_opening"].values.ravel() == pytest.approx([-apart.min()] * 2, rel=1e-9)
    assert (run["status"] == 0).all() and (run["impact_count"] == 0).all()


@pytest.mark.complete
def test_no_amplitude_scales_a_history(sines):
    """One amplitude is that of the records that the model was run with; a computed neighbour feels it."""
    folder, frame, hall, _ = sines
    plain, strong = (scanned(folder, frame, hall, **more) for more in ({}, {"pga": "0.9 g"}))
    np.testing.assert_array_equal(strong[POINT].values, plain[POINT].values)
    beside = scanned(folder, frame, HALL, pga="0.9 g"), scanned(folder, frame, HALL)
    peaks = [one["peak_displacement_free"].sel(building="hall").values for one in beside]
    np.testing.assert_allclose(peaks[0] / peaks[1], 0.9 * 9.80665 / beside[1]["record_pga"].values[:, None], rtol=1e-9)


def test_a_case_that_closes_the_gap_is_not_run_and_says_so(sines, tmp_path):
    folder, frame, hall, _ = sines
    known = scanned(folder, frame, hall)
    closed = known.isel(gap=0)
    assert (closed["status"] == UNPUSHED).all() and (closed["impact_count"] == -1).all()
    assert np.isnan(closed["peak_contact_force"]).all() and not known["simulated"].any()
    assert Results(known).run_counts["failed"] == 0 and Results(known).unpushed == 2
    told = f"{known.attrs['notes']} {pr.assess(known, gap='5 mm').interfaces[0].verdict.evidence}"
    for words in ("no contact is run", "frame.csv", "never scaled", "(second differences / 8)", "2 of 6 cases are not"):
        assert words in told
    rows = {each.row.rule: each.row for each in pr.assess(known).interfaces[0].separations}
    peaks = known["storey_displacement_free"].isel(record=0).values.reshape(2, -1)
    left, right = 0.6 * peaks[0, 1] + 0.4 * peaks[0, 2], peaks[1, 0]
    assert rows["abs"].separation == pytest.approx(left + right, rel=1e-9)
    assert "displacement_history" in rows["abs"].note and "linear model" not in rows["abs"].note
    page = tmp_path / "r.html"
    known.to_netcdf(tmp_path / "r.nc")
    commands.done("report", tmp_path / "r.nc", "-o", page)
    assert "no contact is run" in page.read_text("utf-8")
    told = " ".join(document_fromstring(page.read_text("utf-8")).text_content().split())
    section = told[told.rindex("with a run of their own") :][:400]
    counts = "with a run of their own0 known exactly without one4 not run, as a known motion would have to be pushed2"
    assert section.startswith(counts) and "failed0" in section
    commands.done("view", tmp_path / "r.nc", "-o", page)
    assert "2 not run, as a known motion would have to be pushed" in page.read_text("utf-8")
    told = refusal(pr.histories, tmp_path / "r.nc", tmp_path / "h.nc", folder=folder)
    assert "needs a building that can be pushed" in told


def test_fragilities_of_motions_that_do_not_collide_alone_are_refused(sines, tmp_path, says):
    """Of a gap that some motions close, runs with contact are missing for just those; without contact all are known."""
    folder, frame, hall, _ = sines
    known = scanned(folder, frame, hall)
    says(refusal(pr.damage, known, states=[{"name": "slight", "drift": "0.1 %"}], gap="5 mm"))
    pr.damage(known, states=[{"name": "slight", "drift": "0.1 %"}], gap=float(known["gap"].max()))
    known.to_netcdf(tmp_path / "r.nc")
    written = pr.export(tmp_path / "r.nc", "pelicun", tmp_path / "out", gap="5 mm")
    names = sorted(path.name for path in (tmp_path / "out").rglob("*contact.csv"))
    assert written and names and all("without" in name for name in names)


def test_a_row_with_one_known_building_computes_the_others(sines):
    folder, _, hall, _ = sines
    shop = single("shop", "60 t", "0.4 s", height="5 m")
    alone, known = scanned(folder, FRAME, shop, HALL), scanned(folder, FRAME, shop, hall)
    free = "peak_closing_free"
    np.testing.assert_array_equal(known[free].isel(interface=0), alone[free].isel(interface=0))
    assert (known[free].isel(interface=1) != alone[free].isel(interface=1)).all()
    assert (known["status"].isel(gap=0) == UNPUSHED).all() and (known["status"].isel(gap=-1) == 0).all()


@pytest.mark.complete
def test_neighbours_vary_along_axes_beside_a_known_motion(sines):
    folder, frame, _, _ = sines
    text = text_of(frame, HALL) + '"building.hall.period" = ["0.3 s", "0.5 s"]\n'  # [grid] stands last
    (folder / "axes.toml").write_text(text, encoding="utf-8")
    along = pr.scan(folder / "axes.toml", check_fraction=0.0)
    for place, period in enumerate(("0.3 s", "0.5 s")):
        one = scanned(folder, frame, HALL | {"period": period})
        here = along.isel({"building.hall.period": place})
        np.testing.assert_array_equal(here["peak_closing_free"], one["peak_closing_free"])


def test_a_path_with_velocities_is_the_cubic_through_them():
    """t³ from three samples of it: values and slopes at times between them, too."""
    samples, fine = np.array([0.0, 1.0, 3.0]), np.linspace(0.0, 3.0, 13)
    path = known_job.Path(samples, (samples**3)[:, None], (3.0 * samples**2)[:, None])
    values, starts, ends = path.pieces(fine, np.array([2.0]))
    np.testing.assert_allclose(values, 2.0 * fine**3, atol=1e-13)
    lengths = np.diff(fine)
    np.testing.assert_allclose(starts, 6.0 * fine[:-1] ** 2 * lengths, atol=1e-13)
    np.testing.assert_allclose(ends, 6.0 * fine[1:] ** 2 * lengths, atol=1e-13)


def test_cubics_have_their_extremes_inside():
    """Against the roots of numpy's polynomials, one interval at a time."""
    rng = np.random.default_rng(7)
    for _ in range(50):
        values, starts, ends = rng.normal(size=4), *rng.normal(scale=4.0, size=(2, 3))
        every = list(values)
        for low, high, start, end in zip(values, values[1:], starts, ends, strict=False):
            rise = high - low
            cubic = np.polynomial.Polynomial([low, start, 3.0 * rise - 2.0 * start - end, start + end - 2.0 * rise])
            real = [root.real for root in cubic.deriv().roots() if abs(root.imag) < 1e-12]
            every += [cubic(root) for root in real if 0.0 < root < 1.0]
        assert extremes(values, starts, ends) == pytest.approx((max(every), min(every)), rel=1e-9, abs=1e-9)
    straight = np.array([0.0, 1.0, 1.0, -2.0])
    assert extremes(straight, np.diff(straight), np.diff(straight)) == (1.0, -2.0)


def test_changed_files_are_another_scan(sines, tmp_path):
    _, _, _, (slow, moved, _, _) = sines
    out = tmp_path / "r.nc"
    own = FRAME | {"displacement_history": [write(tmp_path / "own.csv", slow, moved)] * 2}
    scene = tmp_path / "scene.toml"
    scene.write_text(text_of(own, rigid()), encoding="utf-8")
    pr.scan(scene, out, check_fraction=0.0)
    assert pr.rerun(out).same
    write(tmp_path / "own.csv", slow, 1.1 * moved)
    assert "the displacement_history of frame under RSN6-180: the sha256 of its file was" in refusal(pr.rerun, out)
    told = refusal(pr.scan, scene, out, check_fraction=0.0)
    assert "record RSN6-180: the displacement_history of a building under it is another file" in told


@pytest.mark.parametrize(
    "command", ["simulate", "histories", "compare", "accuracy", "effects", "advise", "amplification", "export"]
)
def test_what_runs_contact_refuses_a_known_motion(sines, command, tmp_path, says):
    folder, frame, hall, _ = sines
    (folder / "scene.toml").write_text(text_of(frame, hall), encoding="utf-8")
    words = {"export": ["--to", "opensees", "-o", str(tmp_path / "m.py")], "histories": ["-o", str(tmp_path / "h.nc")]}
    told = commands.refused(command, folder / "scene.toml", *words.get(command, []))
    says(told.replace(str(folder), "FOLDER"))


FAULTY = {
    "both polarities": ({}, {}, {"polarity": ["as recorded", "reversed"]}, None),
    "levels": ({}, {}, {"intensity": {"measure": "pga", "levels": ["0.1 g", "0.2 g"]}}, None),
    "a beginning, and own ground": ({"initial_velocity": "1 m/s"}, {"ground_delay": "0.1 s"}, {}, None),
    "a wave": ({}, {}, {}, {"wave_passage": {"velocity": "300 m/s", "distance": "10 m"}}),
    "one file for two records": ({"displacement_history": "frame.csv"}, {}, {}, None),
    "a longer record": ({}, {}, {"window": ["0 s", "20 s"]}, None),
    "a tail": ({}, {}, {"tail": "5 s"}, None),
    "no file": ({"displacement_history": ["frame.csv", "frame1.csv"]}, {}, {}, None),
    "floors of another building": ({"displacement_history": ["hall.csv", "hall.csv"]}, {}, {}, None),
    "a number": ({"displacement_history": 3}, {}, {}, None),
}


@pytest.mark.parametrize("case", FAULTY)
def test_what_a_history_does_not_go_with(sines, case, says):
    folder, frame, hall, _ = sines
    left, right, records, effects = FAULTY[case]
    told = refusal(scanned, folder, frame | left, hall | right, effects=effects, **records)
    says(told.replace(str(folder), "FOLDER"))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "time [s];floor 1 [mm]\n0;0\n",
        "time [s],roof [mm]\n0,0\n1,1\n",
        "time,floor 1\n0 s,0 mm\n1 s,1 zork\n2,3 mm\n",
        "time [s],floor 1 [mm]\n0,0\n0.01,nan\n0.02\n0.03,1 mm\n",
        "time [s],floor 1 [mm]\n0,0\n0.02,1\n0.02,2\n",
        "time [s],floor 1 [mm]\n1,0\n1.01,1\n",
        "time [s],floor 1 [mm]\n0,0\n",
    ],
)
def test_a_file_says_what_is_wrong_with_it(text, tmp_path, says):
    (tmp_path / "u.csv").write_text(text, encoding="utf-8")
    says(refusal(read_history, tmp_path / "u.csv", 1))


def test_a_history_in_any_unit_begins_at_rest(tmp_path):
    (tmp_path / "u.csv").write_text(
        "# own model\ntime [ms],floor 1 [cm],floor 2 [m]\n10,1,0.02\n20,-1,0.03\n", encoding="utf-8"
    )
    history = read_history(tmp_path / "u.csv", 2)
    np.testing.assert_allclose(history.times, [0.0, 0.01, 0.02])
    np.testing.assert_allclose(history.floors, [[0.0, 0.0], [0.01, 0.02], [-0.01, 0.03]])
