"""Uncertain numbers of a scene: how they are read, refused and written, and the axis of their samples."""

from __future__ import annotations

import numpy as np
import pytest
from axes import pair_text
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import scene_text
from uncertain import MASS, PERIOD, RESTITUTION, THREE, uncertain_text

import pounding_risk as pr
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.uncertain import sample_axis
from pounding_risk.scene.variants import Variants

TIED = {"between": ["building.left.period", "building.left.mass"], "value": 0.5}


def faults(numbers, *overrides, **more):
    with pytest.raises(SceneError) as error:
        parse_scene(uncertain_text(numbers, **more), overrides=overrides)
    return [fault.partition(", ")[2] if fault.startswith("line") else fault for fault in error.value.faults]


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


def test_the_scene_s_own_value_stands_in_for_a_centre_that_is_left_out():
    own = parse_scene(uncertain_text({"building.left.period": {"distribution": "lognormal", "dispersion": 0.2}}))
    assert own.uncertain == parse_scene(uncertain_text({"building.left.period": PERIOD})).uncertain
    (sentence,) = faults({"building.mass": {"distribution": "normal", "cov": 0.1}})  # 500 t and 800 t
    assert sentence.startswith('uncertain."building.mass".mean: missing; write {')


@pytest.mark.parametrize(
    "spelling", ['building.left.period = {distribution = "lognormal", dispersion = 0.2}', '"building.1.period" = {P}']
)
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


def test_other_points_take_the_same_way():
    study = parse_scene(uncertain_text())
    points = np.random.default_rng(5).random((6, 3))
    other = study.with_samples(points)
    assert other.axes == (sample_axis(study.uncertain, points),)
    assert parse_scene(other.to_toml()) == other
    assert study.with_samples(study.uncertain.points()).axes == study.axes
    with pytest.raises(PoundingError, match=r"points of shape \(6, 2\): they are \(samples, 3\)"):
        study.with_samples(points[:, :2])
    with pytest.raises(SceneError, match=r"with_samples: the scene has no uncertain numbers; write \[uncertain\]"):
        parse_scene(pair_text({})).with_samples(points)


def test_what_was_cut_and_unbalanced_points_are_told():
    wide = {"interface.restitution": {"distribution": "normal", "mean": 0.65, "deviation": 0.3}}
    notes = list(parse_scene(uncertain_text(wide, samples=6)).uncertain.notes())
    assert notes == [
        "interface.restitution: normal, cut at 0 and 1, which leaves out 13.7 % of it; the samples are of the rest",
        "6 samples are no power of two, for which alone Sobol points are balanced; 4 or 8 are better spread",
    ]
    assert list(parse_scene(uncertain_text()).uncertain.notes()) == []
    tied = THREE | {"method": "latin hypercube", "correlations": [TIED]}
    (stratified,) = parse_scene(uncertain_text(tied, samples=8)).uncertain.notes()
    assert "building.left.mass are spread as of random points" in stratified


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


def test_an_uncertain_gap_is_that_of_each_sample():
    gap = {"interface.gap": {"distribution": "uniform", "low": "8 mm", "high": "12 mm"}}
    (study, again) = (
        parse_scene(scene_text() + f"[uncertain]\nsamples = 4\n'interface.gap' = {words}")
        for words in ('{distribution = "uniform", low = "8 mm", high = "12 mm"}',) * 2
    )
    assert study == again == parse_scene(study.to_toml())
    assert study.grid.gaps == (0.01,)
    gaps = [Variants(study).scene(place).gap for place in range(4)]
    assert len(set(gaps)) == 4 and all(0.008 < one < 0.012 for one in gaps)
    (sentence,) = faults(gap)
    assert (
        "[grid] has its own gap, and contact at any gap follows from the closing of each sample; remove one" in sentence
    )


@pytest.mark.parametrize(
    ("numbers", "sentence"),
    [
        (
            {"building.lef.mass": MASS},
            'uncertain."building.lef.mass": there is no building "lef" (did you mean "left"?)',
        ),
        ({"records.scale": PERIOD}, "no key of [records] is an uncertain number: records are read once"),
        ({"solver.rtol": PERIOD}, "no key of [solver] is an uncertain number"),
        ({"foo.bar": PERIOD}, "there is no such section"),
        ({"mass": PERIOD}, "is no key of the scene"),
        ({}, "uncertain: no number is uncertain; write"),
        ({"building.left.mass": "5 t"}, '"5 t" is not a distribution; write {distribution'),
        ({"building.left.mass": {"mean": "5 t"}}, "the distribution is missing"),
        (
            {"building.left.mass": MASS | {"distribution": "nomal"}},
            '"nomal" is not a distribution (did you mean "normal"?)',
        ),
        (
            {"building.left.mass": MASS | {"meen": "5 t"}},
            'unknown key (did you mean "mean"?); normal takes mean, deviation',
        ),
        ({"building.left.mass": {"distribution": "normal"}}, "one of the two"),
        ({"building.left.mass": MASS | {"mean": "5 s"}}, '"5 s" is a time, not a mass'),
        ({"building.left.mass": MASS | {"mean": 5}}, "5 has no unit"),
        ({"building.left.mass": MASS | {"cov": -0.1}}, "a cov must be greater than 0"),
        (
            {"building.left.mass": MASS | {"mean": "-5000 t", "cov": 0.01}},
            "lies outside of what the number may be, at least 1 kg",
        ),
        ({"building.left.mass": MASS | {"low": "6 t", "high": "5 t"}}, "low is not below high; swap them"),
        ({"building.left.mass": MASS | {"low": "5000 t"}}, 'lies outside of what the number may be, low "5000 t"'),
        ({"building.left.period": PERIOD | {"median": "-1 s"}}, "the median of a lognormal number is above 0"),
        ({"interface.restitution": {"distribution": "uniform", "low": 0.8, "high": 0.4}}, "low is not below high"),
        (
            {"interface.gap": {"distribution": "triangular", "low": "5 mm", "mode": "9 mm", "high": "8 mm"}},
            "low, mode and high are not in this order",
        ),
        ({"interface.contact_model": PERIOD}, 'write distribution = "discrete" and its values'),
        (
            {"interface.contact_model": {"distribution": "discrete", "values": ["jankowski", "hertz_damp"]}},
            "changes the contact models of the grid; write contact_model = [...] in [grid] instead",
        ),
        ({"building.left.rigid": {"distribution": "discrete", "values": [True]}}, "is no single value"),
        (
            {"building.left.mass": {"distribution": "discrete", "values": ["5 t", "5000 kg"]}},
            '"5000 kg" stands twice, first as "5 t"; remove one',
        ),
        (
            {"building.left.mass": {"distribution": "discrete", "values": ["5 t"], "weights": [1, 2]}},
            "1 values and 2 weights",
        ),
        (THREE | {"building.1.mass": MASS}, "sets what building.left.mass sets; remove one"),
        (THREE | {"correlations": [TIED | {"value": 1.0}]}, "a correlation must be greater than -1 and less than 1"),
        (
            THREE | {"correlations": [TIED | {"between": ["building.left.perod", "building.left.mass"]}]},
            '"building.left.perod" is no number of [uncertain] (did you mean "building.left.period"?)',
        ),
        (THREE | {"correlations": [TIED, TIED]}, "stand twice; remove one"),
        (THREE | {"correlations": [TIED | {"between": ["building.left.mass"] * 2}]}, "name two numbers"),
        (THREE | {"correlations": 3}, "3 is not a list"),
        (
            THREE
            | {
                "correlations": [
                    {"between": [one, other], "value": -0.9}
                    for one, other in zip([*THREE], [*THREE][1:] + [*THREE][:1], strict=True)
                ]
            },
            "no numbers have all of these together (-0.9 of building.left.period and building.left.mass; -0.9 of",
        ),
        (THREE | {"method": "halton"}, '"halton" is not a method'),
        (THREE | {"samples": -1}, "-1 is not a whole number from 0 to 100000; write samples = 512"),
        (THREE | {"seed": 0.5}, "0.5 is not a whole number"),
        (THREE | {"points": [[0.5, 0.5]]}, "a point has 2 coordinates, and 3 numbers are uncertain"),
        (THREE | {"points": [[0.5, 0.5, 0.5]]}, "4, and points gives 1; remove one of the two"),
        (THREE | {"points": [[0.5, 0.5, 1.5]]}, "out of range"),
        (THREE | {"sampls": 5}, 'unknown key (did you mean "samples"?)'),
    ],
)
def test_what_cannot_be_uncertain_is_refused_with_the_repair(numbers, sentence):
    assert any(sentence in fault for fault in faults(numbers)), faults(numbers)


def test_an_axis_of_the_grid_and_a_number_cannot_be_one():
    (sentence,) = faults({"building.left.mass": MASS}, axes={"building.1.mass": ["5 t", "6 t"]})
    assert "sets what the axis building.1.mass of [grid] sets; remove one" in sentence


def test_a_sample_that_makes_no_scene_is_told_with_its_values():
    """Displacements close the gap of 10 mm beyond touch in some samples."""
    moved = {"building.left.initial_displacement": {"distribution": "uniform", "low": "0 mm", "high": "30 mm"}}
    sentence = faults(moved, samples=8)[0]
    assert sentence.startswith("uncertain: sample 1 (building.left.initial_displacement = ")
    assert "they would stand in each other when the motion begins" in sentence


def test_a_part_that_is_set_is_refused():
    both = {"building.damping": {"distribution": "uniform", "low": 0.02, "high": 0.05}}
    (sentence,) = faults(both, "building.left.damping=0.03")
    assert "--set sets a part of what building.damping sets; set all of it" in sentence


KINDS = st.one_of(
    st.builds(
        lambda m, d: {"distribution": "lognormal", "median": f"{m!r} s", "dispersion": d},
        st.floats(0.2, 2.0),
        st.floats(0.01, 1.0),
    ),
    st.builds(
        lambda m, d: {"distribution": "normal", "mean": f"{m!r} s", "cov": d, "low": "0.05 s"},
        st.floats(0.2, 2.0),
        st.floats(0.01, 0.5),
    ),
    st.builds(
        lambda a, b: {"distribution": "uniform", "low": f"{a!r} s", "high": f"{a + b!r} s"},
        st.floats(0.1, 2.0),
        st.floats(0.1, 1.0),
    ),
    st.builds(
        lambda v: {"distribution": "discrete", "values": [f"{one!r} s" for one in v]},
        st.lists(st.floats(0.1, 2.0), min_size=1, max_size=3, unique=True),
    ),
)


@settings(max_examples=25, deadline=None)
@given(
    kinds=st.tuples(KINDS, KINDS),
    samples=st.integers(1, 5),
    method=st.sampled_from(["sobol", "latin hypercube", "random"]),
    value=st.floats(-0.99, 0.99),
)
def test_a_scene_with_uncertain_numbers_is_written_and_read_back(kinds, samples, method, value):
    numbers = dict(zip(("building.left.period", "building.right.period"), kinds, strict=True))
    numbers |= {"method": method, "correlations": [{"between": [*numbers], "value": value}]}
    study = parse_scene(uncertain_text(numbers, samples=samples))
    again = parse_scene(study.to_toml())
    assert again == study and again.axes == study.axes and hash(again) == hash(study)
    assert again.to_toml() == study.to_toml()
