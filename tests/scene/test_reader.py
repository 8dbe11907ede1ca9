"""Scene files: what is read, what is written back, and every refusal in its own words."""

from math import inf, pi, sqrt

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_cases import cases
from sentences import refusal

from pounding_risk.errors import SceneError
from pounding_risk.models.contact.laws import LAWS, Hertz, Linear, VanMier
from pounding_risk.models.restitution import CONCRETE, Restitution
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.formats import matching
from pounding_risk.motions.processing import read_steps
from pounding_risk.motions.request import Spectral
from pounding_risk.scene import records as scene_records
from pounding_risk.scene import sections
from pounding_risk.scene.interfaces import EqualTerms
from pounding_risk.scene.reader import parse_scene, read_scene
from pounding_risk.scene.scene import Scene, scene_of
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
G = 9.80665  # m/s²


@pytest.fixture(autouse=True)
def catalogue(monkeypatch):
    """A catalogue of three, so that sentences do not change with the records that ship."""
    monkeypatch.setattr(scene_records, "catalogue_ids", lambda: ["RSN6-180", "RSN6-270", "CI.CCC-HN1"])


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
    assert found.records[8:] == ("", "", "", None, None, None, None, (), "", None, (), 60.0, None, False)
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


VARIED = [  # beside the keys by themselves, in test_keys
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
    assert [{"step": step.name, **step.options} for step in found.records.processing] == STEPS
    assert hash(found.records) == hash(parse_scene(found.to_toml()).records)
    assert read_steps(found.records.processing) == read_steps(STEPS)
    assert (
        'processing = [{step = "mean"}, {step = "bandpass", low = "0.1 Hz", high = "40.0 Hz"}, '
        '{step = "baseline", order = 6.0}]'
    ) in found.to_toml()


def test_steps_may_be_set_from_outside():
    found = parse_scene(SHORT, overrides=['records.processing=[{step = "trend"}]'])
    assert [{"step": step.name, **step.options} for step in found.records.processing] == [{"step": "trend"}]


def test_a_law_that_the_scene_cannot_give(says):
    found = parse_scene(SHORT)
    says([refusal(found.law, law) for law in ("jankowski", "linear", "distributed_mass")])
    says([refusal(ask, "jankowsky") for ask in (found.law, found.needs_equal_terms)])


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
    with pytest.raises(SceneError) as error:
        parse_scene(text, "scene.toml", overrides)
    assert error.value.faults == sentences


HEAD, INTERFACE = SHORT.split("[[interface]]")
FIRST, SECOND = HEAD.split("[[building]]")[1:]
# Scenes that lack or bend whole sections.
WHOLE = {
    "no section": "x = 1\n",
    "one table of interfaces": SHORT.replace("[[interface]]", "[interface]"),
    "records that are a number": "records = 3\n" + SHORT.partition("[records]")[0],
    "buildings that are numbers": f"building = [3, 4]\n[[interface]]{INTERFACE}",
    "one building": f"[[building]]{FIRST}[[interface]]{INTERFACE}",
    "two walls": SHORT.replace('period = "0.208 s"', "rigid = true").replace('period = "0.007 s"', "rigid = true"),
    "no gap and no model": SHORT.replace('gap = "25 mm"\ncontact_model = "hertz"\n', ""),
    "lists in lists": "a = " + "[" * 100_000,
    "several in the order of the file": (
        DESIGN.replace("[solver]\nrtol = 1e-6", "[solver]\nrtol = 2")
        .replace("44.36 t", "44.36 m")
        .replace('"RSN6-180"', '\n  "RSN6-180",\n  "RSN7"\n')
        .replace('"450 kN" ', "450 ")
        .replace('["200 kN", "400 kN", "inf"]', '["200 kN", 4, "7 s"]')
    ),
    "a step of an array of tables": SHORT
    + '[[records.processing]]\nstep = "mean"\n[[records.processing]]\nstep = "baseline"\norder = 60\n',
}


@pytest.mark.parametrize("text", WHOLE.values(), ids=WHOLE)
def test_faults_of_the_whole(text, says):
    says(refusal(parse_scene, text, "my/scene.toml"))


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


def test_overrides_of_sections_that_are_not_there(says):
    assert parse_scene(SHORT, overrides=["grid.gap=['1 mm']"]).grid.gaps == (0.001,)
    says(refusal(parse_scene, "x = 1", overrides=["interface.gap=1 mm"]))


def test_files_that_are_no_scene(tmp_path, says):
    (tmp_path / "scene.toml").write_text(SHORT, encoding="utf-8")
    (tmp_path / "empty.toml").write_text(" \n")
    (tmp_path / "latin.toml").write_bytes(b'[scene]\nname = "Br\xfccke"\n')
    (tmp_path / "mark.toml").write_bytes(b"\xef\xbb\xbf" + SHORT.replace("\n", "\r\n").encode())
    none = ("scen.toml", "no/such.toml", ".", "empty.toml", "latin.toml")
    says([refusal(read_scene, tmp_path / name) for name in none])
    assert read_scene(tmp_path / "mark.toml") == read_scene(str(tmp_path / "scene.toml"), ["scene.name=mark"])


def test_record_files_are_found_beside_the_scene(tmp_path, says):
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
    says(refusal(read_scene, scene))


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


def is_a_scene_or_sentences(tables) -> None:
    """What these tables make is written and read again; or every fault is one line that names its place."""
    try:
        found = scene_of(tables)
    except SceneError as error:
        assert error.faults
        assert all("\n" not in fault and ": " in fault for fault in error.faults)
    else:
        assert isinstance(found, Scene)
        assert parse_scene(found.to_toml()) == found


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
    is_a_scene_or_sentences(tables)
