"""Uncertain numbers of a scene: how they are read, refused and written, and the axis of their samples."""

import numpy as np
import pytest
from axes import pair_text
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import scene_text
from sentences import refusal
from uncertain import MASS, PERIOD, RESTITUTION, THREE, uncertain_text

import pounding_risk as pr
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.uncertain import sample_axis
from pounding_risk.scene.variants import Variants

TIED = {"between": ["building.left.period", "building.left.mass"], "value": 0.5}


def refused(numbers, *overrides, **more):
    return refusal(parse_scene, uncertain_text(numbers, **more), overrides=overrides)


def test_samples_are_an_axis_along_which_all_numbers_move():
    study = parse_scene(uncertain_text(axes={"building.right.damping": [0.02, 0.05]}))
    grid, samples = study.axes
    assert grid.name == "building.right.damping"
    assert (samples.name, samples.size, samples.keys) == ("sample", 4, tuple(THREE))
    assert samples.values == study.uncertain.values_at(study.uncertain.points())
    assert samples.labels()["sample"] == ((0, 1, 2, 3), "1")
    made = Variants(study).scene(4 + 2)  # the second damping, the third sample
    assert made.buildings[0].period == float(samples.values[0][2].removesuffix(" s"))
    assert made.resolved()["building"][1]["damping"] == 0.05
    assert made.uncertain is None and made.axes == ()


def test_the_scene_s_own_value_stands_in_for_a_centre_that_is_left_out(says):
    own = parse_scene(uncertain_text({"building.left.period": {"distribution": "lognormal", "dispersion": 0.2}}))
    assert own.uncertain == parse_scene(uncertain_text({"building.left.period": PERIOD})).uncertain
    says(refused({"building.mass": {"distribution": "normal", "cov": 0.1}}))  # 500 t and 800 t


@pytest.mark.parametrize(
    "spelling", ['building.left.period = {distribution = "lognormal", dispersion = 0.2}', '"building.1.period" = {P}']
)
@pytest.mark.complete
def test_every_spelling_of_an_address_is_read(spelling):
    body = spelling.replace("{P}", '{distribution = "lognormal", dispersion = 0.2}')
    text = f"{pair_text({})}\n[uncertain]\n{body}\n"
    study = parse_scene(text)
    assert study.uncertain.samples == 256 and study.uncertain.method == "sobol" and study.uncertain.seed == 1
    assert study.uncertain.numbers[0].words() == "lognormal, median 0.5 s, dispersion 0.2"


def test_a_number_that_is_set_is_uncertain_no_more():
    numbers = THREE | {"correlations": [TIED]}
    study = parse_scene(uncertain_text(numbers), overrides=['building.1.period="0.4 s"'])
    assert study.uncertain.keys == ("building.left.mass", "interface.restitution")
    assert study.uncertain.correlations == () and study.buildings[0].period == 0.4
    assert parse_scene(uncertain_text(), overrides=["uncertain.samples=0"]).uncertain is None
    everything = ['building.left.period="0.4 s"', 'building.left.mass="4 t"', "interface.restitution=0.5"]
    assert parse_scene(uncertain_text(numbers), overrides=everything).axes == ()
    changed = parse_scene(uncertain_text(), overrides=['uncertain."building.left.period".dispersion=0.5'])
    assert changed.uncertain.numbers[0].distribution.dispersion == 0.5


def test_python_gives_numbers_in_si_and_text():
    study = parse_scene(uncertain_text(THREE | {"correlations": [TIED], "seed": 3, "method": "random"}, samples=8))
    numbers = {
        "building.left.period": {"distribution": "lognormal", "median": 0.5, "dispersion": 0.2},
        "building.left.mass": {"distribution": "normal", "mean": np.float64(5e5), "deviation": 5e4},
        "interface.restitution": RESTITUTION,
    }
    given = {"samples": 8, "method": "random", "seed": 3, "correlations": [TIED]}
    bare = parse_scene(pair_text({}))
    for uncertain in (pr.Uncertain(numbers, **given), {**numbers, **given}, study.uncertain):
        assert bare.replace(uncertain=uncertain) == study
    parts = {"grid": pr.Grid(gap=["10 mm", "60 mm"]), "uncertain": pr.Uncertain(numbers, **given), "name": "scene"}
    assert pr.Scene(bare.buildings, bare.interfaces, bare.resolved()["records"], **parts) == study
    assert study.replace(samples=16).axes[0].size == 16


def test_samples_are_added_by_asking_for_more():
    few = parse_scene(uncertain_text(samples=8))
    many = few.replace(samples=16).axes[0]
    assert [values[:8] for values in many.values] == list(few.axes[0].values)


def test_other_points_take_the_same_way(says):
    study = parse_scene(uncertain_text())
    points = np.random.default_rng(5).random((6, 3))
    other = study.with_samples(points)
    assert other.axes == (sample_axis(study.uncertain, points),)
    assert parse_scene(other.to_toml()) == other
    assert study.with_samples(study.uncertain.points()).axes == study.axes
    says(refusal(study.with_samples, points[:, :2]), refusal(parse_scene(pair_text({})).with_samples, points))


def test_what_was_cut_and_unbalanced_points_are_told(says):
    wide = {"interface.restitution": {"distribution": "normal", "mean": 0.65, "deviation": 0.3}}
    tied = THREE | {"method": "latin hypercube", "correlations": [TIED]}
    texts = (uncertain_text(wide, samples=6), uncertain_text(), uncertain_text(tied, samples=8))
    says([list(parse_scene(text).uncertain.notes()) or "nothing" for text in texts])


def test_stiffness_of_contact_has_the_unit_of_its_law():
    for spread in (
        {"distribution": "lognormal", "dispersion": 0.3},
        {"distribution": "uniform", "low": "2e9 N/m^1.5", "high": "3e9 N/m^1.5"},
    ):
        study = parse_scene(uncertain_text({"interface.stiffness": spread}))
        assert study.axes[0].values[0][0].endswith(" N/m^1.5")
        assert Variants(study).scene(0).stiffness != study.stiffness


def test_parameters_of_effects_and_values_of_lists_may_be_uncertain():
    wave = {"wave_passage": {"velocity": "500 m/s", "distance": "20 m"}}
    speed = {"effects.wave_passage.velocity": {"distribution": "lognormal", "dispersion": 0.4}}
    study = parse_scene(uncertain_text(speed, effects=wave))
    assert study.axes[0].values[0][0].endswith(" m/s")
    displaced = {"building.left.initial_displacement": {"distribution": "normal", "mean": "0 m", "deviation": "1 mm"}}
    assert parse_scene(uncertain_text(displaced)).axes[0].size == 4


def test_an_uncertain_gap_is_that_of_each_sample(says):
    gap = {"interface.gap": {"distribution": "uniform", "low": "8 mm", "high": "12 mm"}}
    (study, again) = (
        parse_scene(scene_text() + f"[uncertain]\nsamples = 4\n'interface.gap' = {words}")
        for words in ('{distribution = "uniform", low = "8 mm", high = "12 mm"}',) * 2
    )
    assert study == again == parse_scene(study.to_toml())
    assert study.grid.gaps == (0.01,)
    gaps = [Variants(study).scene(place).gap for place in range(4)]
    assert len(set(gaps)) == 4 and all(0.008 < one < 0.012 for one in gaps)
    says(refused(gap))


def of_mass(**keys):
    return {"building.left.mass": keys}


def discrete(key, *values, **more):
    return {key: {"distribution": "discrete", "values": [*values], **more}}


def tied(*pairs, value=0.5):
    return THREE | {"correlations": [{"between": [*pair], "value": value} for pair in pairs]}


ONE, OTHER, THIRD = THREE
REFUSED = {
    "an unknown building": {"building.lef.mass": MASS},
    "a key of the records": {"records.scale": PERIOD},
    "a key of the solver": {"solver.rtol": PERIOD},
    "no section": {"foo.bar": PERIOD},
    "no key": {"mass": PERIOD},
    "nothing": {},
    "a value": {"building.left.mass": "5 t"},
    "no distribution": of_mass(mean="5 t"),
    "an unknown distribution": of_mass(**MASS | {"distribution": "nomal"}),
    "an unknown parameter": of_mass(**MASS, meen="5 t"),
    "no deviation": of_mass(distribution="normal"),
    "a mean in s": of_mass(**MASS | {"mean": "5 s"}),
    "a mean without unit": of_mass(**MASS | {"mean": 5}),
    "a negative cov": of_mass(**MASS | {"cov": -0.1}),
    "all of it outside": of_mass(**MASS | {"mean": "-5000 t", "cov": 0.01}),
    "bounds that are swapped": of_mass(**MASS, low="6 t", high="5 t"),
    "all of it below its bound": of_mass(**MASS, low="5000 t"),
    "a negative median": {"building.left.period": PERIOD | {"median": "-1 s"}},
    "an empty range": {"interface.restitution": {"distribution": "uniform", "low": 0.8, "high": 0.4}},
    "a mode outside": {"interface.gap": {"distribution": "triangular", "low": "5 mm", "mode": "9 mm", "high": "8 mm"}},
    "a name spread evenly": {"interface.contact_model": PERIOD},
    "contact models": discrete("interface.contact_model", "jankowski", "hertz_damp"),
    "truths": discrete("building.left.rigid", True),
    "a value twice": discrete("building.left.mass", "5 t", "5000 kg"),
    "weights that are too many": discrete("building.left.mass", "5 t", weights=[1, 2]),
    "a key twice": THREE | {"building.1.mass": MASS},
    "a correlation of 1": tied((ONE, OTHER), value=1.0),
    "a correlation of another number": tied(("building.left.perod", OTHER)),
    "a correlation twice": tied((ONE, OTHER), (ONE, OTHER)),
    "a correlation with itself": tied((OTHER, OTHER)),
    "a number of correlations": THREE | {"correlations": 3},
    "correlations that no numbers have": tied((ONE, OTHER), (OTHER, THIRD), (THIRD, ONE), value=-0.9),
    "an unknown method": THREE | {"method": "halton"},
    "-1 samples": THREE | {"samples": -1},
    "half a seed": THREE | {"seed": 0.5},
    "points of two coordinates": THREE | {"points": [[0.5, 0.5]]},
    "points that are too few": THREE | {"points": [[0.5, 0.5, 0.5]]},
    "a point outside": THREE | {"points": [[0.5, 0.5, 1.5]]},
    "an unknown key": THREE | {"sampls": 5},
}


@pytest.mark.parametrize("numbers", REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_uncertain_is_refused_with_the_repair(numbers, says):
    says(refused(numbers))


def test_a_key_that_is_set_elsewhere_too_is_refused(says):
    says(refused({"building.left.mass": MASS}, axes={"building.1.mass": ["5 t", "6 t"]}))
    both = {"building.damping": {"distribution": "uniform", "low": 0.02, "high": 0.05}}
    says(refused(both, "building.left.damping=0.03"))


def test_a_sample_that_makes_no_scene_is_told_with_its_values(says):
    """Displacements close the gap of 10 mm beyond touch in some samples."""
    moved = {"building.left.initial_displacement": {"distribution": "uniform", "low": "0 mm", "high": "30 mm"}}
    says(refused(moved, samples=8))


def seconds(low: float, high: float) -> st.SearchStrategy[str]:
    return st.floats(low, high).map("{!r} s".format)


def of_kind(kind: str, **keys: st.SearchStrategy) -> st.SearchStrategy:
    return st.fixed_dictionaries({"distribution": st.just(kind), **keys})


KINDS = st.one_of(
    of_kind("lognormal", median=seconds(0.2, 2.0), dispersion=st.floats(0.01, 1.0)),
    of_kind("normal", mean=seconds(0.2, 2.0), cov=st.floats(0.01, 0.5), low=st.just("0.05 s")),
    st.builds(
        lambda low, width: {"distribution": "uniform", "low": f"{low!r} s", "high": f"{low + width!r} s"},
        st.floats(0.1, 2.0),
        st.floats(0.1, 1.0),
    ),
    of_kind("discrete", values=st.lists(seconds(0.1, 2.0), min_size=1, max_size=3, unique=True)),
)


@settings(max_examples=25, deadline=None)
@given(
    kinds=st.tuples(KINDS, KINDS),
    samples=st.integers(1, 5),
    method=st.sampled_from(["sobol", "latin hypercube", "random"]),
    value=st.floats(-0.99, 0.99),
)
@pytest.mark.complete
def test_a_scene_with_uncertain_numbers_is_written_and_read_back(kinds, samples, method, value):
    numbers = dict(zip(("building.left.period", "building.right.period"), kinds, strict=True))
    numbers |= {"method": method, "correlations": [{"between": [*numbers], "value": value}]}
    study = parse_scene(uncertain_text(numbers, samples=samples))
    again = parse_scene(study.to_toml())
    assert again == study and again.axes == study.axes and hash(again) == hash(study)
    assert again.to_toml() == study.to_toml()
