"""Scans along levels of intensity and of sequences of shocks: a loop of scans, and calls that read them."""

import json

import numpy as np
import pytest
import xarray as xr
from axes import equals_the_loop
from scenes import BOTH, FOUR_IN_A_ROW, scene_text, single, storeyed
from sentences import refusal

import pounding_risk as pr
from pounding_risk import assess
from pounding_risk.assessment.intensities import intensities
from pounding_risk.ensemble.plan.plan import plan as scan_plan
from pounding_risk.ensemble.scan import scan
from pounding_risk.motions.levels import Measure
from pounding_risk.motions.read import read_motion
from pounding_risk.motions.record import recording_numbers
from pounding_risk.questions import simulate as simulating
from pounding_risk.questions.rerun import rerun
from pounding_risk.results.amplitudes import intensity_unit
from pounding_risk.results.opened import Results
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import parse_scene
from pounding_risk.units import STANDARD_GRAVITY

G = 9.80665
RECORDS = {"names": ["RSN6-180", "RSN1690-090"], "window": ["0 s", "8 s"], "tail": "1 s"}
SA = {"measure": "sa", "period": "0.5 s", "levels": ["0.1 g", "0.4 g"]}
MEASURES = {
    "sa": SA,
    "pgv": {"measure": "pgv", "levels": ["8 cm/s", "40 cm/s"]},
    "sa_avg": {"measure": "sa_avg", "periods": ["0.2 s", "1 s"], "levels": ["0.1 g", "0.4 g"]},
    "scale": {"measure": "scale", "levels": [0.5, 4.5]},
}


def scene(grid=None, **records):
    text = scene_text(
        single("left", "10 t", "0.5 s"),
        single("right", "20 t", "0.3 s", damping=0.02),
        records=RECORDS | {"polarity": BOTH} | records,
        grid={"gap": ["5 mm", "20 mm"], "yield_force": ["40 kN", "inf"]} | (grid or {}),
        law="linear",
        gap="20 mm",
        yield_force="40 kN",
    )
    return parse_scene(text, "scene.toml")


@pytest.fixture(scope="module")
def scanned() -> dict[str, xr.Dataset]:
    """By measure a scan along two levels of it."""
    return {name: pr.scan(scene(intensity=table), check_fraction=0.0) for name, table in MEASURES.items()}


@pytest.fixture(scope="module")
def along_sa(scanned) -> xr.Dataset:
    return scanned["sa"]


def of_cases(dataset: xr.Dataset) -> xr.Dataset:
    """The outputs of cases and of motions without contact, and what the buildings felt."""
    return dataset.reset_coords(["record_pga_felt", "record_scale_factor"]).drop_vars("record_spectral_acceleration")


def assert_alike(dataset: xr.Dataset, other: xr.Dataset) -> None:
    """Every output is the same to the last bit."""
    first, second = of_cases(dataset), of_cases(other)
    assert set(first.data_vars) == set(second.data_vars)
    for name in first.data_vars:
        np.testing.assert_array_equal(first[name].values, second[name].values, err_msg=str(name))


# ------------------------------------------------------------------------------------------------ scanning
@pytest.mark.parametrize("place", [0, 1])
@pytest.mark.parametrize("name", ["sa", "scale"])
def test_levels_are_a_loop_of_scans(scanned, name, place):
    level = MEASURES[name]["levels"][place]
    records = {"sa": {"value": level, "period": "0.5 s"}} if name == "sa" else {"scale": level}
    assert_alike(scanned[name].isel(intensity=place), pr.scan(scene(**records), check_fraction=0.0))


@pytest.mark.parametrize("name", ["pgv", "sa_avg"])
def test_levels_of_other_measures_are_scans_times_their_factors(scanned, name):
    """Each record scaled alone by level over value; the product of the factor may round otherwise."""
    measure, levels = Results(scanned[name]).amplitudes[1:]
    for record in RECORDS["names"]:
        value = measure.of([read_motion(record).cut("0 s", "8 s")])[0]
        one = pr.scan(scene(names=[record], scale=float(levels[1] / value)), check_fraction=0.0)
        assert_alike(scanned[name].sel(record=[record]).isel(intensity=1), one)


def test_a_row_along_levels_is_a_loop_of_scans():
    row = FOUR_IN_A_ROW.replace('pga = "0.5 g"\n', "").replace('["0.5 s", "5.5 s"]', '["0.5 s", "3.5 s"]')
    table = 'intensity = {measure = "sa", period = "0.9 s", levels = ["0.1 g", "0.3 g"]}'
    small = ['grid.gap=["5 mm", "40 mm"]', 'grid.yield_force=["inf"]', 'records.names=["RSN6-180"]']
    levels = row.replace("[records]\n", f"[records]\n{table}\n")
    along = pr.scan(parse_scene(levels, "row.toml", small), check_fraction=0.0)
    one = [*small, 'records.sa={value = "0.3 g", period = "0.9 s"}']
    assert_alike(along.isel(intensity=1), pr.scan(parse_scene(row, "row.toml", one), check_fraction=0.0))


def test_the_dataset_says_what_its_levels_are(scanned):
    for name, dataset in scanned.items():
        assert dataset["peak_closing_free"].dims == ("record", "polarity", "intensity", "interface")
        assert dataset["impact_count"].dims[:4] == ("record", "polarity", "intensity", "contact_model")
        assert "pga" not in dataset.coords
        assert Results(dataset).measure.name == name
    about = scanned["sa_avg"]["intensity"].attrs
    assert about["units"] == "m/s2"
    words = "geometric mean of the pseudo-spectral acceleration at 10 periods from 0.2 s to"
    assert about["long_name"].startswith(words)
    assert scanned["pgv"]["intensity"].attrs["units"] == "m/s"
    assert scanned["scale"]["intensity"].values.tolist() == [0.5, 4.5]


def test_factors_and_peaks_are_told_by_record(along_sa):
    records = [read_motion(name).cut("0 s", "8 s") for name in RECORDS["names"]]
    factors = np.array([[0.1 * G, 0.4 * G]]) / Measure("sa", (0.5,)).of(records)[:, None]
    np.testing.assert_allclose(along_sa["record_scale_factor"], factors, rtol=1e-14)
    peaks = np.array([[motion.pga] for motion in records])
    np.testing.assert_allclose(along_sa["record_pga_felt"], factors * peaks, rtol=1e-14)
    np.testing.assert_allclose(along_sa["record_pgv"], Measure("pgv").of(records), rtol=1e-14)


def test_factors_outside_the_usual_range_are_flagged(scanned):
    """0.5 is within 0.25 to 4, 4.5 is not; a PGA is no other level of intensity."""
    flag = "scale factors to the amplitudes of the grid ({}) are outside 0.25 to 4; over all motions they are {}"
    assert scanned["scale"].attrs["flags"].count(flag.format("factor", "0.5 to 4.5")) == 2
    peaks = [read_motion(name).cut("0 s", "8 s").pga for name in RECORDS["names"]]
    small = 0.2 * min(peaks)
    shaken = scene({"pga": [f"{small} m/s2", f"{max(peaks)} m/s2"]})
    factors = f"{small / max(peaks):.3g} to {max(peaks) / min(peaks):.3g}"
    assert pr.scan(shaken).attrs["flags"].count(flag.format("PGA", factors)) == 2
    assert [len(record.flags) for record in pr.validate(shaken).records] == [1, 1]
    assert "scale factors" not in pr.scan(scene({"pga": [f"{1.01 * min(peaks)} m/s2"]})).attrs["flags"]
    assert "scale factors" not in pr.scan(scene(intensity={"measure": "scale", "levels": [1.0]})).attrs["flags"]


def test_a_plan_counts_levels():
    facts = dict(scan_plan(scene(intensity=SA)).facts())
    assert "2 levels of Sa(0.5 s)" in facts["cases"]
    assert facts["cases"].startswith("32 =")


# ------------------------------------------------------------------------------------------------ reading
@pytest.mark.complete
def test_a_file_keeps_the_measure(scanned, tmp_path):
    for name, dataset in scanned.items():
        pr.save(dataset, tmp_path / f"{name}.nc")
        again = pr.open_results(tmp_path / f"{name}.nc")
        assert Results(again).measure == Results(dataset).measure
        assert Results(again).usual_intensity == Results(dataset).usual_intensity
    again = rerun(tmp_path / "pgv.nc")
    assert again.differences == ()


def test_amplitudes_in_words(scanned):
    assert Results(scanned["sa"]).amplitude_words() == "at Sa(0.5 s) = 0.1 g to 0.4 g"
    assert Results(scanned["pgv"].isel(intensity=1)).amplitude_words() == "at PGV = 40 cm/s"
    assert Results(scanned["scale"]).amplitude_words() == "times 0.5 to 4.5"


@pytest.mark.parametrize("name", MEASURES)
def test_intensities_are_the_levels(scanned, name):
    """In the measure of the levels these; in every other one in proportion to the factors."""
    dataset = scanned[name]
    levels = dataset["intensity"].values
    own = "scale" if name == "scale" else Results(dataset).usual_intensity
    assert (own, intensity_unit(own)) == (Results(dataset).measure.intensity, dataset["intensity"].attrs["units"])
    np.testing.assert_array_equal(intensities(Results(dataset), own), np.tile(levels, (4, 1)))
    for other in ("pga", "pgv", "sa(0.4 s)", "sa_avg(0.2-1.5 s)", "sa(left)"):
        values = intensities(Results(dataset), other)
        assert values.shape == (4, 2)
        np.testing.assert_allclose(values[:, 1] / values[:, 0], levels[1] / levels[0], rtol=1e-9)


def test_intensities_in_another_measure_are_those_of_the_scaled_motions(along_sa):
    """Read from the dataset alone, against the motions themselves; spectra are read between their periods."""
    motions = [read_motion(name).cut("0 s", "8 s") for name in RECORDS["names"]]
    factors = along_sa["record_scale_factor"].values
    pairs = {"pgv": (Measure("pgv"), 1e-12), "sa_avg(0.2-1 s)": (Measure("sa_avg", (0.2, 1.0)), 0.03)}
    for word, (measure, near) in pairs.items():
        expected = np.repeat(measure.of(motions)[:, None] * factors, 2, axis=0)
        np.testing.assert_allclose(intensities(Results(along_sa), word), expected, rtol=near)


def test_levels_and_intensities_that_a_dataset_has_not_are_refused(along_sa, tmp_path, says):
    says(refusal(intensities, Results(along_sa), "scale"), refusal(intensities, Results(along_sa), "sa_avg(0.2-9 s)"))
    says(refusal(intensities, Results(along_sa.drop_vars("record_pgv")), "pgv"))
    study, out = scene(intensity=SA), tmp_path / "others.nc"
    others = {"pgas": [0.4 * G]}, {"intensity_levels": ["0.3 g"]}
    says([refusal(pr.histories, study, out, **levels) for levels in others])
    says(refusal(pr.assess, along_sa, pga="0.1 g"), refusal(pr.assess, along_sa, intensity_level="0.3 g"))
    says(refusal(pr.view, along_sa, tmp_path / "view.html", pgas=["0.4 g"]))


@pytest.mark.parametrize("name", MEASURES)
def test_one_run_is_that_of_the_scan(scanned, name):
    table = MEASURES[name]
    study = scene(intensity=table)
    which = {"record": "RSN1690-090", "intensity_level": table["levels"][1], "gap": "5 mm"}
    run = pr.simulate(study, **which)
    case = scanned[name].pounding.case(**which, yield_force="40 kN")
    for output in ("peak_contact_force", "impact_count", "peak_closing"):
        np.testing.assert_array_equal(run[output].values, case[output].values)
    largest = pr.simulate(study, record="RSN1690-090", gap="5 mm")["peak_closing"].values  # the level of an assessment
    cases = scanned[name].isel(intensity=-1).sel(record="RSN1690-090", polarity="as recorded", gap=0.005)
    np.testing.assert_array_equal(largest, cases["peak_closing"][0, 0])


@pytest.mark.complete
def test_histories_are_of_the_levels_asked_for(tmp_path):
    study = scene(intensity=SA)
    out = pr.histories(study, tmp_path / "runs.nc", records=["RSN6-180"], intensity_levels=["0.4 g"], gaps=[0.005])
    with xr.open_dataset(out) as runs:
        assert runs["intensity"].values.tolist() == [0.4 * G]
        run = pr.simulate(study, record="RSN6-180", intensity_level="0.4 g", gap="5 mm")
        force = runs["contact_force"].sel(polarity="as recorded", yield_force=4e4).values
        assert np.nanmax(force) <= run["peak_contact_force"].max()
        assert np.nanmax(force) > 0.0


@pytest.mark.complete
def test_the_verdict_is_at_one_level(along_sa):
    strongest = pr.assess(along_sa).interfaces[0]
    assert (strongest.amplitude, strongest.intensity, strongest.at) == (0.4 * G, "sa(0.5 s)", "at Sa(0.5 s) = 0.4 g")
    assert "Of the amplitudes 0.1 g and 0.4 g, 0.4 g is assessed: the largest." in strongest.verdict.evidence
    weakest = pr.assess(along_sa, intensity_level="0.1 g").interfaces[0]
    assert weakest.amplitude == 0.1 * G
    alone = pr.assess(along_sa.isel(intensity=0)).interfaces[0]
    assert (alone.verdict.sentence, alone.closing) == (weakest.verdict.sentence, weakest.closing)
    assert max(weakest.closing) < max(strongest.closing)


def test_a_level_of_a_grid_of_pga_is_its_pga(says):
    dataset = pr.scan(scene({"pga": ["0.1 g", "0.4 g"]}), check_fraction=0.0)
    assert pr.assess(dataset, intensity_level="0.1 g").as_dict() == pr.assess(dataset, pga="0.1 g").as_dict()
    says(refusal(pr.assess, dataset, pga="0.1 g", intensity_level="0.1 g"))


@pytest.mark.complete
def test_one_level_may_be_squeezed(along_sa):
    one = pr.scan(scene(intensity=SA | {"levels": ["0.4 g"]}), check_fraction=0.0)
    assert "intensity" not in one.dims
    assert float(one["intensity"]) == 0.4 * G
    selected = along_sa.sel(intensity=0.4 * G)
    for dataset in (one, selected, selected.squeeze()):
        assert pr.assess(dataset).interfaces[0].closing == pr.assess(along_sa).interfaces[0].closing
        opened = Results(dataset)
        np.testing.assert_array_equal(intensities(opened, opened.usual_intensity), np.full((4, 1), 0.4 * G))


@pytest.mark.complete
def test_other_calls_read_levels(along_sa, tmp_path):
    """Summary, display, report, page and figure are made of such a dataset."""
    assert pr.summary(along_sa).counts["cases"] == 32
    assert "Sa(0.5 s)" in repr(along_sa.pounding)
    page = pr.view(along_sa, tmp_path / "view.html", intensity_levels=["0.4 g"]).read_text(encoding="utf-8")
    assert '"0.4 g"' in page
    text = pr.report(along_sa, tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Sa(0.5 s) of 0.4 g" in text
    assert "amplitude (Sa(0.5 s))" in text
    assert along_sa.pounding.figure() is not None


def test_compare_runs_along_levels():
    study = scene({"gap": ["5 mm"], "yield_force": ["inf"]}, intensity=SA, names=["RSN6-180"])
    dataset = pr.compare(study, laws=["linear", "hertz"])
    assert dataset["impact_count"].sizes["intensity"] == 2
    assert dataset["history"].attrs["record"] == "RSN6-180"


@pytest.mark.complete
def test_axes_of_numbers_stand_beside_levels():
    periods = {'"building.left.period"': ["0.4 s", "0.6 s"]}
    text = scene(periods, intensity=SA, names=["RSN6-180"]).to_toml()
    dataset = equals_the_loop(text, ("flags",), check_fraction=0.0)  # they are of the periods of all places
    assert dataset["peak_closing_free"].dims[-4:] == ("record", "polarity", "intensity", "interface")


NAMES = {"names": ["RSN6-180"], "window": ["0 s", "8 s"], "pga": "0.4 g"}


def text_of(**records) -> str:
    """Two yielding buildings side by side."""
    sides = [storeyed(name, ["100 t"] * 2, stiffness, ["3 m"] * 2, storey_strengths="300 kN")
             for name, stiffness in (("A", "60 MN/m"), ("B", "90 MN/m"))]  # fmt: skip
    return scene_text(*sides, gap="8 mm", effects={"inelastic_storeys": {}}, records=NAMES | records)


def test_the_sequence_is_both_motions_with_still_ground_between():
    (motion,) = motions_of(parse_scene(text_of(aftershock="RSN753-000", pause="20 s", aftershock_ratio=0.5)))
    first = pr.read_motion("RSN6-180", window=(0.0, 8.0))
    after = pr.read_motion("RSN753-000")
    # The finer step of both; straight lines between samples change no peak.
    step = motion.dt
    assert step == min(first.dt, after.dt)
    begins = 8.0 + 20.0
    times = step * np.arange(motion.acceleration.size)
    known = np.where(times <= 8.0, np.interp(times, first.times, first.acceleration), 0.0)
    scaled = 0.5 * first.pga / after.pga * after.acceleration
    known += np.interp(times - begins, after.times, scaled, left=0.0, right=0.0)
    np.testing.assert_allclose(motion.acceleration, known, atol=1e-12 * first.pga)
    assert motion.duration == pytest.approx(begins + after.duration, abs=step)
    assert motion.pga == pytest.approx(first.pga, rel=1e-12)
    assert any("followed from 28 s on by RSN753-000" in words for words in motion.processing)
    assert motion.record["aftershock"]["name"] == "RSN753-000"


def test_with_a_direction_both_components_of_an_aftershock_are_one_name():
    """Turned by hand: 30 degrees from north, of components at 0 and 90. One id, or two, are told what to write."""
    turned = {"names": ["RSN6-180", "RSN6-270"], "direction": "30 deg", "pause": "5 s"}
    (motion,) = motions_of(parse_scene(text_of(**turned, aftershock="RSN753-000+RSN753-090")))
    north, east = (pr.read_motion(f"RSN753-{azimuth}").acceleration for azimuth in ("000", "090"))
    count = min(north.size, east.size)
    known = np.cos(np.radians(30.0)) * north[:count] + np.sin(np.radians(30.0)) * east[:count]
    np.testing.assert_allclose(motion.acceleration[-count:], known, atol=1e-12 * np.abs(known).max())
    for aftershock in ("RSN753-000", ["RSN753-000", "RSN753-090"]):
        told = refusal(motions_of, parse_scene(text_of(**turned, aftershock=aftershock)))
        assert "RSN753-000+RSN753-090" in told and "a pattern of files" in told
    alone = refusal(motions_of, parse_scene(text_of(aftershock="RSN753-000+RSN753-090")))
    assert "one record is needed here, and it is RSN753-000, RSN753-090" in alone


def test_a_plan_names_the_aftershock_its_pause_and_its_size():
    words = [dict(pr.validate(parse_scene(text_of(**NAMES | {"aftershock": "RSN753-000"} | more))).facts())["records"]
             for more in ({}, {"pause": "20 s", "aftershock_ratio": 0.5})]  # fmt: skip
    assert words[0].endswith("followed after 60 s by RSN753-000 with the factor of each motion")
    assert words[1].endswith("followed after 20 s by RSN753-000 at 0.5 of the PGA of each motion")


def test_without_a_ratio_both_have_one_factor_and_a_stronger_one_is_flagged():
    (motion,) = motions_of(parse_scene(text_of(aftershock="RSN753-000")))
    first, after = pr.read_motion("RSN6-180", window=(0.0, 8.0)), pr.read_motion("RSN753-000")
    assert np.abs(motion.acceleration[-after.acceleration.size :]).max() == pytest.approx(after.pga, rel=1e-12)
    assert any("its aftershock is stronger" in flag for flag in motion.flags) == (after.pga > first.pga)


def test_a_factor_of_the_aftershock_alone_is_flagged():
    """Of PGA p and q in the files the factor at a ratio r is r p / q, times that to the amplitude, if there is one."""
    first, after = pr.read_motion("RSN77-164").pga, pr.read_motion("RSN1690-090").pga

    def told(override: str = "", ratio: float | None = 0.8, after: str = "RSN1690-090") -> list[str]:
        sides = single("left", "300 t", "0.6 s"), single("right", "200 t", "0.5 s")
        records = {"names": ["RSN77-164"], "aftershock": after} | ({} if ratio is None else {"aftershock_ratio": ratio})
        (planned,) = pr.validate(parse_scene(scene_text(*sides, records=records)), [override] * bool(override)).records
        return [flag.removeprefix(f"{after}, after it: ") for flag in planned.flags if flag.startswith(after)]

    as_recorded, half_g = 0.8 * first / after, 0.8 * 0.5 * STANDARD_GRAVITY / after
    assert told() == [f"the scale factor {as_recorded:.4g} is outside 0.25 to 4"]
    assert told('records.pga="0.5 g"') == told(f"records.scale={0.5 * STANDARD_GRAVITY / first!r}")
    assert told('records.pga="0.5 g"') == [f"the scale factor {half_g:.4g} is outside 0.25 to 4"]
    assert told('grid.pga=["0.1 g", "0.5 g"]') == [
        f"scale factors {0.2 * half_g:.4g} to {half_g:.4g} are outside 0.25 to 4"
    ]
    assert told('records.pga="0.2 g"') == told(ratio=None) == []
    assert told(ratio=3.0, after="RSN6-180")[1:] == [
        f"PGA after scaling is {3.0 * first / STANDARD_GRAVITY:.3g} g, above 3 g: check the unit"
    ]
    assert told(after="ricker: pga=0.1 g, period=0.6 s, step=0.01 s") == []
    grid = {"building.left.mass": ["300 t", "310 t"]}
    sides = single("left", "300 t", "0.6 s"), single("right", "200 t", "0.5 s")
    sequence = {"names": ["RSN6-180"], "aftershock": "RSN1690-090", "aftershock_ratio": 3.0}
    along = pr.scan(parse_scene(scene_text(*sides, records=sequence, grid=grid)), check_fraction=0.0)
    assert "RSN1690-090, after it: the scale factor" in along.attrs["flags"]


def test_what_has_yielded_carries_over():
    """A second shock after a long pause: residual drift at its end is that of a run that begins from the first one's.

    With the aftershock nearly zero the residual drift is that of the first motion alone; with a strong one it is not.
    """

    def rest(**records) -> np.ndarray:
        run = pr.simulate(parse_scene(text_of(**records)))
        told = dict(simulating.sheet(run)[0]["rows"])["record"]["text"]
        assert told.endswith(", followed by RSN6-180") == ("aftershock" in records)
        caption = pr.figures.simulation_figure(run).get_supxlabel().replace("\n", " ")
        assert ("followed by RSN6-180" in caption) == ("aftershock" in records)
        return run["storey_residual_drift"].values

    alone, still = rest(tail="20 s"), rest(aftershock="RSN6-180", pause="20 s", aftershock_ratio=1e-6)
    strong = rest(aftershock="RSN6-180", pause="20 s", aftershock_ratio=2.0)
    assert alone.max() > 1e-3  # m
    np.testing.assert_allclose(still, alone, rtol=1e-4)  # driven by a millionth
    assert np.abs(strong - alone).max() > 1e-3
    study = parse_scene(text_of(aftershock="RSN6-180", pause="20 s", aftershock_ratio=2.0))
    assert parse_scene(study.to_toml()) == study


def test_motions_that_share_a_shock_are_of_one_recording():
    """By a shared aftershock, another component of it, or one that comes first elsewhere; unknown ones by their source.

    A recording whose aftershock is its own repetition, or stands behind it alone, counts by itself.
    """

    def numbers(*shocks: tuple[str, str]) -> list[int]:
        names, aftershock = ([*column] for column in zip(*shocks, strict=True))
        motions = motions_of(parse_scene(text_of(names=names, aftershock=aftershock, pause="1 s")))
        facts = json.loads(json.dumps([motion.record for motion in motions]))  # as a dataset has them
        return recording_numbers(facts, [motion.name for motion in motions]).tolist()

    own = numbers(("RSN6-180", "RSN6-180"), ("RSN753-000", "RSN1690-090"), ("RSN77-164", "RSN6-270"))
    assert own == [0, 1, 0]
    assert numbers(("RSN6-180", "RSN1690-090"), ("RSN753-000", "RSN1690-360"), ("RSN6-270", "RSN77-164")) == [0, 0, 0]
    pulses = [f"ricker: pga=0.2 g, period={period} s, step=0.005 s" for period in (0.5, 0.8)]
    assert numbers(*zip(["RSN6-180", "RSN753-000", "RSN77-164"], [*pulses, pulses[0]], strict=True)) == [0, 1, 0]


@pytest.mark.complete
def test_bounds_count_sequences_that_share_their_aftershock_once():
    """Three recordings, each with an aftershock of its own or all with one, which leaves nothing independent."""
    names = ["RSN6-180", "RSN753-000", "RSN77-164"]
    alone, own, one = (
        scan(parse_scene(text_of(names=names, **more)), check_fraction=0.0)
        for more in ({}, {"aftershock": names, "pause": "1 s"}, {"aftershock": "RSN1690-090", "pause": "1 s"})
    )
    found = [assess(dataset).interfaces[0].verdict for dataset in (alone, own, one)]
    assert [(verdict.motions, verdict.recordings) for verdict in found] == [(3, 3), (3, 3), (3, 1)]
    assert [verdict.independent for verdict in found] == [3.0, 3.0, 1.0]
    assert one["record_recording"].values.tolist() == [0, 0, 0]
    assert any("which count as one" in note for note in Results(one).notes)


def test_what_does_not_go_together_is_refused(says):
    says(refusal(parse_scene, text_of(pause="20 s", aftershock_ratio=0.5)))
    says(refusal(parse_scene, text_of(aftershock="RSN753-000", aftershock_ratio=0.0, pause="2 h")))
    says(refusal(motions_of, parse_scene(text_of(aftershock=["RSN753-000", "RSN6-180"]))))
    own = parse_scene(text_of(aftershock="RSN753-000"), overrides=['building.A.ground_record="RSN753-000"'])
    says(refusal(motions_of, own))
