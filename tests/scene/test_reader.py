"""Scene files: what is read, what is written back, and every refusal in its own words."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, pi, sqrt

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_cases import cases

from pounding_risk._common.letters import refused
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.contact.laws import LAWS, Hertz, Linear, VanMier
from pounding_risk.models.restitution import CONCRETE, Restitution
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.processing import read_steps
from pounding_risk.motions.request import Spectral, matching
from pounding_risk.scene import records as scene_records
from pounding_risk.scene import sections
from pounding_risk.scene.interfaces import EqualTerms
from pounding_risk.scene.reader import parse_scene, read_scene
from pounding_risk.scene.scene import scene_of
from pounding_risk.scene.toml import key_lines

# The scene of the design, as written there.
DESIGN = """\
[scene]
name = "Frame beside masonry, El Centro 1940"

[[building]]                     # left to right
name = "frame"
mass = "44.36 t"                 # or floor_masses with storey_stiffnesses or storey_heights
period = "0.208 s"               # or stiffness = "40.5 MN/m"; rigid = true; or a code period
damping = 0.05

[[building]]
name = "masonry"
mass = "82.60 t"
period = "0.007 s"
damping = 0.05

[[interface]]                    # one per neighbouring pair, in order
gap = "0 mm"
contact_model = "viscous_elastoplastic"
stiffness = "4.2e7 kN/m^1.5"     # N/m for the linear laws
restitution = "concrete"         # a number, or a named relation
yield_force = "450 kN"           # optional; absent = no yielding
# equal_terms = {same = "peak force", speed = "0.5 m/s"}   # stiffness of the other laws

[effects]                        # absent = none
# permanent_set = {}
# strain_rate = {code = "mc2010", length = "0.6 m"}

[records]
names = ["RSN6-180"]             # from the catalogue; or files = ["my/*.AT2"]; or set = "fema-p695-farfield"
window = ["0 s", "6 s"]
pga = "0.5 g"                    # absent = as recorded; or scale = 1.5
polarity = ["as recorded"]       # "reversed", or both
processing = "auto"              # raw records get the default chain, processed ones (AT2 ...) are left alone
tail = "0 s"                     # a run ends with its record; a tail adds free vibration

[grid]                           # each key a dataset dimension; absent = the value above
gap = {start = "0 mm", stop = "100 mm", num = 51}
yield_force = ["200 kN", "400 kN", "inf"]
contact_model = ["jankowski", "viscous_elastoplastic"]
pga = ["0.2 g", "0.5 g"]

[solver]
rtol = 1e-6
"""

# The shortest scene: what has no default.
SHORT = """\
[[building]]
name = "frame"
mass = "44.36 t"
period = "0.208 s"
[[building]]
name = "masonry"
mass = "82.60 t"
period = "0.007 s"
[[interface]]
gap = "25 mm"
contact_model = "hertz"
stiffness = "4.2e7 kN/m^1.5"
[records]
names = ["RSN6-180"]
"""
ALL_LAWS = (
    "linear, kelvin_voigt, kelvin_voigt_tension_cut, modified_kelvin_voigt, hertz, hertz_damp, "
    "hertz_damp_exact, jankowski, bilinear, van_mier, viscous_elastoplastic, tabulated, stereomechanical, merged, "
    "distributed_mass"
)
G = 9.80665  # m/s²


@pytest.fixture(autouse=True)
def catalogue(monkeypatch):
    """A catalogue of three, so that sentences do not change with the records that ship."""
    monkeypatch.setattr(scene_records, "catalogue_ids", lambda: ["RSN6-180", "RSN6-270", "CI.CCC-HN1"])


def faults(text: str, overrides: Sequence[str] = ()) -> list[str]:
    with pytest.raises(SceneError) as error:
        parse_scene(text, "scene.toml", overrides)
    return error.value.faults


def test_the_scene_of_the_design():
    found = parse_scene(DESIGN)
    assert found.name == "Frame beside masonry, El Centro 1940"
    assert found.buildings == (
        Building("frame", 44360.0, 0.208, 0.05),
        Building("masonry", 82600.0, 0.007, 0.05),
    )
    contact = found.gap, found.contact_model, found.stiffness, found.yield_force
    assert contact == (0.0, "viscous_elastoplastic", 4.2e10, 450e3)
    assert (found.restitution, found.restitution_words) == (CONCRETE, "concrete")
    assert found.equal_terms is None
    assert found.records[:8] == (("RSN6-180",), (), (0.0, 6.0), 0.5 * G, None, ("as recorded",), "auto", 0.0)
    assert found.records[8:] == ("", "", "", None, None, None, None, (), "", None)
    assert found.grid.gaps == tuple(number / 500 for number in range(51))
    assert found.grid.yield_forces == (200e3, 400e3, inf)
    assert found.grid.contact_models == ("jankowski", "viscous_elastoplastic")
    assert found.grid.levels == (1.96133, 4.903325)
    assert found.rtol == 1e-6
    assert found.text == DESIGN


def test_defaults():
    found = parse_scene(SHORT, "folder/short.toml")
    assert found.name == "short"
    assert [building.damping for building in found.buildings] == [0.05, 0.05]
    assert (found.yield_force, found.restitution, found.interfaces[0].plastic_exponent) == (inf, Restitution(1.0), 0.0)
    assert found.records[:8] == (("RSN6-180",), (), None, None, None, ("as recorded",), "auto", 0.0)
    assert found.grid == ((0.025,), (inf,), ("hertz",), (None,))
    assert (found.rtol, found.restitution_words) == (1e-6, "not given")


def test_interface_values_may_come_from_the_grid_alone():
    text = SHORT.replace('gap = "25 mm"\ncontact_model = "hertz"\n', "")
    found = parse_scene(text + '[grid]\ngap = ["1 mm", "2 mm"]\ncontact_model = ["van_mier", "hertz"]\n')
    assert (found.gap, found.contact_model) == (0.001, "van_mier")


def test_a_building_by_stiffness_and_a_rigid_one():
    text = SHORT.replace('period = "0.208 s"', 'stiffness = "40.5 MN/m"').replace('period = "0.007 s"', "rigid = true")
    left, right = parse_scene(text).buildings
    assert left.period == 2 * pi * sqrt(44360 / 40.5e6)
    assert left.stiffness == pytest.approx(40.5e6, rel=1e-14)
    assert right == Building.rigid("masonry", 82600.0)
    assert parse_scene(text.replace('mass = "82.60 t"\n', "")).buildings[1] == Building.rigid("masonry")


@pytest.mark.parametrize("polarity", ['["as recorded", "reversed"]', '["reversed"]', '"reversed"'])
def test_polarity_is_a_word_or_a_list(polarity):
    found = parse_scene(SHORT + f"polarity = {polarity}\n").records.polarities
    assert found == (("as recorded", "reversed") if "as" in polarity else ("reversed",))


def test_laws_of_a_study():
    text = SHORT.replace("[records]", 'equal_terms = {same = "peak force", speed = "0.5 m/s"}\n[records]')
    text = text.replace('contact_model = "hertz"', 'contact_model = "van_mier"\nplastic_exponent = 0.5')
    found = parse_scene(text + '[grid]\ncontact_model = ["hertz", "linear"]\n')
    assert found.equal_terms == EqualTerms(same="peak force", speed=0.5)
    assert found.law() == VanMier(4.2e10, 0.5)
    assert found.law("hertz") == Hertz(4.2e10)
    assert found.law("linear", 1e9) == Linear(1e9)
    assert [name for name in LAWS if found.needs_equal_terms(name)] == list(LAWS)[:4]


VARIED = [  # beside the keys by themselves, in test_declarations
    DESIGN,
    SHORT,
    SHORT.replace("[records]", 'equal_terms = {same = "peak force", speed = "50 cm/s"}\n[records]')
    + '[grid]\ncontact_model = ["hertz", "linear"]\n',
    SHORT + 'scale = 1.5\npolarity = ["as recorded", "reversed"]\nprocessing = "none"\ntail = "5 s"\n',
    SHORT
    + """processing = [
        {step = "window", start = "10 s"}, {step = "mean", of = "whole"}, {step = "baseline", order = 4},
        {step = "bandpass", low = "50 mHz", high = "inf"},
    ]\n""",
    SHORT.replace('name = "frame"', r'name = "a \"b\" \\ .é"'),
]


@pytest.mark.parametrize("text", VARIED)
def test_round_trip(text):
    found = parse_scene(text, "short.toml")
    assert parse_scene(found.to_toml()) == found
    assert scene_of(found.resolved()) == found
    again = parse_scene(found.to_toml())
    assert again.to_toml() == found.to_toml()


STEPS = [{"step": "mean"}, {"step": "bandpass", "low": 0.1, "high": 40.0}, {"step": "baseline", "order": 6.0}]


@pytest.mark.parametrize(
    "written",
    [
        'processing = [{step = "mean"}, {step = "bandpass", low = "100 mHz", high = "40 Hz"}, '
        '{step = "baseline", order = 6}]',
        '[[records.processing]]\nstep = "mean"\n[[records.processing]]\nstep = "bandpass"\nlow = "0.1 Hz"\n'
        'high = "40 Hz"\n[[records.processing]]\nstep = "baseline"\norder = "6"',
    ],
)
def test_processing_may_be_a_list_of_steps(written):
    """The study carries them in SI, hashable, and as `read_motion` takes them."""
    found = parse_scene(SHORT + written + "\n")
    assert isinstance(found.records.processing, tuple)
    assert [dict(step) for step in found.records.processing] == STEPS
    assert hash(found.records) == hash(parse_scene(found.to_toml()).records)
    assert read_steps(found.records.processing) == read_steps(STEPS)
    assert (
        'processing = [{step = "mean"}, {step = "bandpass", low = "0.1 Hz", high = "40.0 Hz"}, '
        '{step = "baseline", order = 6.0}]'
    ) in found.to_toml()


def test_a_faulty_step_of_an_array_of_tables_has_its_line():
    steps = '[[records.processing]]\nstep = "mean"\n[[records.processing]]\nstep = "baseline"\norder = 60\n'
    assert faults(SHORT + steps) == [
        "line 19, records.processing.2.order: 60 is out of range: an order must be at least 1 and at most 20; "
        "write an order such as 5"
    ]


def test_steps_may_be_set_from_outside():
    found = parse_scene(SHORT, overrides=['records.processing=[{step = "trend"}]'])
    assert [dict(step) for step in found.records.processing] == [{"step": "trend"}]


def test_a_law_that_the_scene_cannot_give():
    found = parse_scene(SHORT)
    for law, sentence in (
        ("jankowski", "jankowski needs a restitution, and the scene gives none; write restitution = 0.65, or "),
        ("linear", "linear takes a stiffness in N/m, the scene gives one in N/m^1.5 for hertz; write equal_terms = {"),
        ("distributed_mass", "distributed_mass needs a length of every floor, frame has none; write floor_length = "),
    ):
        with pytest.raises(SceneError) as error:
            found.law(law)
        (fault,) = error.value.faults
        assert fault.startswith(sentence)
    for ask in (found.law, found.needs_equal_terms):
        with pytest.raises(PoundingError) as wrong:
            ask("jankowsky")
        sentence = f'"jankowsky" is not a contact model (did you mean "jankowski"?); it may be {ALL_LAWS}'
        assert str(wrong.value) == sentence


@settings(deadline=None, max_examples=40)
@given(
    numbers=st.tuples(*[st.floats(1.0, 1e9)] * 5),
    fraction=st.floats(1e-3, 0.999),
    gaps=st.sets(st.floats(0.0, 10.0), min_size=1, max_size=6),
    name=st.text(st.characters(codec="utf-8"), min_size=1).filter(str.strip).filter(lambda name: not refused(name)),
)
def test_round_trip_of_any_numbers(numbers, fraction, gaps, name):
    base = parse_scene(DESIGN)
    mass, period, stiffness, force, tail = numbers
    changed = base.updated(
        gap=min(gaps),
        stiffness=stiffness,
        restitution=Restitution(fraction),
        restitution_words=repr(fraction),
        yield_force=force,
        name=name,
        buildings=(Building("left", mass, period, fraction), base.buildings[1]),
        records=base.records._replace(tail=tail, window=(tail, 2 * tail)),
        grid=base.grid._replace(gaps=tuple(sorted(gaps))),
    )
    assert parse_scene(changed.to_toml()) == changed


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ('set = "fema-p695-nearfield-pulse"', {"set": "fema-p695-nearfield-pulse", "names": ()}),
        ('names = ["RSN6-180", "RSN6-270"]\ndirection = "30 deg"', {"direction": 30.0}),
        ('names = ["RSN6-180"]\nunit = "cm/s^2"\ndt = "10 ms"', {"unit": "cm/s^2", "dt": 0.01}),
        (
            'names = ["RSN6-180"]\nsa = {value = "0.4 g", period = "1 s", damping = "2 %"}',
            {"sa": Spectral(1.0, 0.02, 0.4 * G)},
        ),
        ('names = ["RSN6-180"]\nto_median = "pgv"\nscale = 2', {"to_median": "pgv", "scale": 2.0}),
        ('names = ["RSN6-180"]\nto_median = {period = "0.5 s"}', {"to_median": Spectral(0.5)}),
    ],
)
def test_records_and_what_is_done_to_them(lines, expected):
    found = parse_scene(SHORT.replace('names = ["RSN6-180"]', lines))
    assert {key: getattr(found.records, key) for key in expected} == expected
    assert parse_scene(found.to_toml()) == found


def test_a_study_from_a_dict_keeps_the_dict_and_has_a_text():
    tables = parse_scene(SHORT).resolved()
    found = scene_of(tables, overrides=["interface.gap=30 mm"])
    assert tables["interface"][0]["gap"] == "0.025 m"
    assert found.gap == 0.03
    assert parse_scene(found.text) == found


@pytest.mark.parametrize(("text", "overrides", "sentences"), cases("scene_faults.txt", DESIGN))
def test_each_fault(text, overrides, sentences):
    assert faults(text, overrides) == sentences


# Scenes that lack or bend whole sections.
WHOLE = [
    (
        "x = 1\n",
        [
            f"line 1, x: unknown section; sections are {', '.join(sections.KEYS)}",
            "building: missing; write two [[building]] tables, left and right, each with name, mass and period",
            "interface: missing; write one [[interface]] with gap, contact_model and stiffness",
            'records: missing; write [records] with names = ["RSN6-180"], files = ["my/*.AT2"], or set = "..."',
        ],
    ),
    (
        SHORT.replace("[[interface]]", "[interface]"),
        ["line 9, interface: one table, where each interface is a table of a list; write [[interface]] with "],
    ),
    (
        "records = 3\n" + SHORT.partition("[records]")[0],
        ["line 1, records: 3 is not a table; write [records] and its keys below"],
    ),
    (
        "building = [3, 4]\n" + "[[interface]]" + SHORT.partition("[[interface]]")[2],
        [f"line 1, building.{at}: {value} is not a table; write [[building]] and " for at, value in ((1, 3), (2, 4))],
    ),
    (
        "\n".join(SHORT.split("\n")[:4] + SHORT.split("\n")[8:]),
        ["line 1, building: 1 building: a scene has two, left and right; write a second [[building]] (rigid = true "],
    ),
    (
        SHORT.replace('period = "0.208 s"', "rigid = true").replace('period = "0.007 s"', "rigid = true"),
        ["line 8, building.masonry.rigid: both buildings are rigid, so that no run is needed; give one of them a mass"],
    ),
    (
        SHORT.replace('gap = "25 mm"\ncontact_model = "hertz"\n', ""),
        [
            'line 9, interface.gap: missing; write gap = "25 mm"',
            f'line 9, interface.contact_model: missing; write contact_model = "jankowski", or another of {ALL_LAWS}',
        ],
    ),
    ("a = " + "[" * 100_000, ["lists or tables are nested too deeply; a scene needs three levels"]),
]


@pytest.mark.parametrize(("text", "sentences"), WHOLE)
def test_faults_of_the_whole(text, sentences):
    for fault, sentence in zip(faults(text), sentences, strict=True):
        assert fault.startswith(sentence)


def test_all_faults_at_once_in_the_order_of_the_file():
    text = (
        DESIGN.replace("[solver]\nrtol = 1e-6", "[solver]\nrtol = 2")
        .replace("44.36 t", "44.36 m")
        .replace('"RSN6-180"', '\n  "RSN6-180",\n  "RSN7"\n')
        .replace('"450 kN" ', "450 ")
        .replace('["200 kN", "400 kN", "inf"]', '["200 kN", 4, "7 s"]')
    )
    with pytest.raises(SceneError) as error:
        parse_scene(text, "my/scene.toml")
    starts = [fault.partition(":")[0] for fault in error.value.faults]
    assert starts == [
        "line 6, building.frame.mass",
        "line 21, interface.yield_force",
        "line 29, records.names.2",
        "line 41, grid.yield_force.2",
        "line 41, grid.yield_force.3",
        "line 46, solver.rtol",
    ]
    assert str(error.value).startswith("my/scene.toml: 6 faults\n  - line 6, building.frame.mass: ")


def test_lines_of_keys():
    text = 'a = 1\n\n[t]\n"b c".d = [\n 1,\n 2]\ne = """\nx = 1\n"""\n[[u]]\n[[u]]\nf = {g = 1}\n[u.v]\nh = 1\n'
    lines = key_lines(text)
    assert lines[("a",)] == 1
    assert lines[("t", "b c", "d")] == lines[("t", "b c", "d", 1)] == 4
    assert lines[("t", "e")] == 7
    assert (lines[("u", 0)], lines[("u", 1)], lines[("u", 1, "f", "g")]) == (10, 11, 12)
    assert (lines[("u", 1, "v")], lines[("u", 1, "v", "h")]) == (13, 14)
    assert ("x",) not in lines


@pytest.mark.parametrize(
    ("override", "pick", "value"),
    [
        ('interface.gap="20 mm"', lambda found: found.gap, 0.02),
        ("interface.gap=20 mm", lambda found: found.gap, 0.02),
        ("interface.1.gap = 20 mm", lambda found: found.gap, 0.02),
        ("building.frame.mass=50 t", lambda found: [one.mass for one in found.buildings], [5e4, 82600.0]),
        ("building.2.mass=50 t", lambda found: [one.mass for one in found.buildings], [44360.0, 5e4]),
        ("building.damping=0.02", lambda found: [one.damping for one in found.buildings], [0.02, 0.02]),
        ("solver.rtol=1e-9", lambda found: found.rtol, 1e-9),
        ("grid.gap=['1 mm', '2 mm']", lambda found: found.grid.gaps, (0.001, 0.002)),
        ("interface.yield_force=inf", lambda found: found.yield_force, inf),
    ],
)
def test_overrides(override, pick, value):
    found = parse_scene(DESIGN, overrides=[override])
    assert pick(found) == value
    assert found.overrides == (override,)


def test_overrides_of_sections_that_are_not_there():
    assert parse_scene(SHORT, overrides=["grid.gap=['1 mm']"]).grid.gaps == (0.001,)
    assert faults("x = 1", ("interface.gap=1 mm",)) == ["--set interface.gap: the scene has no [[interface]] to change"]


def test_files_that_are_no_scene(tmp_path):
    (tmp_path / "scene.toml").write_text(SHORT, encoding="utf-8")
    (tmp_path / "empty.toml").write_text(" \n")
    (tmp_path / "latin.toml").write_bytes(b'[scene]\nname = "Br\xfccke"\n')
    (tmp_path / "mark.toml").write_bytes(b"\xef\xbb\xbf" + SHORT.replace("\n", "\r\n").encode())
    sentences = {
        "scen.toml": 'no such file (did you mean "scene.toml"?); check the name and the folder',
        "no/such.toml": "no such file; check the name and the folder",
        ".": "this is a folder; name a scene file (.toml) in it",
        "empty.toml": "the file is empty; a scene needs [[building]], [[interface]] and [records]",
        "latin.toml": "line 2: byte 0xfc is not UTF-8; save the file with that encoding",
    }
    for name, sentence in sentences.items():
        with pytest.raises(SceneError) as error:
            read_scene(tmp_path / name)
        assert error.value.faults == [sentence]
        assert error.value.source == str(tmp_path / name)
    assert read_scene(tmp_path / "mark.toml") == read_scene(str(tmp_path / "scene.toml"), ["scene.name=mark"])


def test_record_files_are_found_beside_the_scene(tmp_path):
    (tmp_path / "my").mkdir()
    for name in ("b.AT2", "a.AT2", "odd[1].AT2", "c.txt"):
        (tmp_path / "my" / name).touch()
    scene = tmp_path / "scene.toml"
    scene.write_text(SHORT.replace('names = ["RSN6-180"]', 'files = ["my/odd[1].AT2", "my/*.AT2"]'))
    found = read_scene(scene)
    assert found.records.files == ("my/odd[1].AT2", "my/*.AT2")
    assert [[path.name for path in matching(found.folder, pattern)] for pattern in found.records.files] == [
        ["odd[1].AT2"],
        ["a.AT2", "b.AT2", "odd[1].AT2"],
    ]
    scene.write_text(SHORT.replace('names = ["RSN6-180"]', 'files = ["my/A.AT3", "my/*.mseed"]'))
    with pytest.raises(SceneError) as error:
        read_scene(scene)
    folder, advice = tmp_path.resolve(), "files are relative to the scene file's folder"
    assert error.value.faults == [
        f'line 14, records.files.1: no file answers to "my/A.AT3" in {folder} (did you mean "a.AT2"?); {advice}',
        f'line 14, records.files.2: no file answers to "my/*.mseed" in {folder}; {advice}',
    ]


def test_processing_in_the_schema_is_a_word_or_steps():
    words, steps = sections.schema()["$defs"]["RecordsTable"]["properties"]["processing"]["anyOf"]
    assert (words["enum"], steps["type"]) == (["auto", "none"], "array")


JUNK = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.floats(),
        st.text(max_size=6),
        st.sampled_from(["1 mm", "2 t", "hertz", "linear", "inf", "reversed", "RSN6-180", "as recorded"]),
    ),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=4), inner, max_size=3)),
    max_leaves=4,
)


@settings(deadline=None, max_examples=150)
@given(data=st.data())
def test_any_scene_is_a_study_or_sentences(data):
    tables = parse_scene(DESIGN).resolved()
    for _ in range(data.draw(st.integers(1, 3))):
        section = data.draw(st.sampled_from([*sections.KEYS, "other"]))
        keys = tables.get(section)
        if isinstance(keys, list) and keys:
            keys = data.draw(st.sampled_from(keys))
        if isinstance(keys, dict) and data.draw(st.booleans()):
            known = sections.KNOWN.get(section, [])
            keys[data.draw(st.sampled_from([*known, "x y"]))] = data.draw(JUNK)
        else:
            tables[section] = data.draw(JUNK)
    try:
        found = scene_of(tables)
    except SceneError as error:
        assert error.faults
        assert all("\n" not in fault and ": " in fault for fault in error.faults)
    else:
        assert parse_scene(found.to_toml()) == found
