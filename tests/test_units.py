"""Text with units to SI and back: values exact, and every refusal in its own words."""

from math import inf, isnan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from processes import output
from sentences import refusal

from pounding_risk import units
from pounding_risk.units import (
    DAMPING,
    GAP,
    MASS,
    PERIOD,
    PGA,
    RESTITUTION,
    RTOL,
    SPEED,
    STANDARD_GRAVITY,
    STIFFNESS,
    USUAL,
    YIELD_FORCE,
    Quantity,
    QuantityError,
    bounds,
    exact,
    legible,
    parse,
    say,
    share,
    shown,
    si,
    signed_percent,
)

HERTZ = Quantity("N/m^1.5", 0.0, inf, "impact stiffness β", open_low=True, open_high=True)
DIMENSIONAL = [MASS, PERIOD, GAP, YIELD_FORCE, STIFFNESS, HERTZ, SPEED, PGA]


READ = [
    (MASS, {"44.36 t": 44360.0, "44.36t": 44360.0, "500 g": 0.5, "1 lb": 0.45359237}),  # a gram, not gravity
    (PERIOD, {"0.208 s": 0.208, "7 ms": 0.007}),
    (GAP, {"25 mm": 0.025, "2.5 cm": 0.025, "0 mm": 0.0, "-0 mm": 0.0, "1 in": 0.0254}),
    (PGA, {"0.5 g": 4.903325, "0.5g": 4.903325}),  # gravity, not a gram
    (PGA, {"490.3325 gal": 4.903325, "490.3325 cm/s^2": 4.903325, "3 m/s2": 3.0, "3 m/s²": 3.0}),  # not a gallon
    (HERTZ, {f"4.2e7 {unit}": 4.2e10 for unit in ("kN/m^1.5", "kN/m**1.5", "kN/m1.5", "kN/m^(3/2)")}),
    (HERTZ, {"1 N·mm^-1.5": 1000.0**1.5}),
    (STIFFNESS, {"40.5 MN/m": 4.05e7}),
    (YIELD_FORCE, {"450 kN": 450e3, "inf": inf, inf: inf, "inf kN": inf}),
    (DAMPING, {"5 %": 0.05, "0.05": 0.05, 0.05: 0.05, 0: 0.0}),
    (RESTITUTION, {1: 1.0}),
    (RTOL, {1e-6: 1e-6}),
    (SPEED, {"0.5\u00a0m/s": 0.5}),  # a no-break space, as pasted from a document
]


@pytest.mark.parametrize(
    ("text", "quantity", "value"),
    [(text, quantity, value) for quantity, values in READ for text, value in values.items()],
)
def test_reads(text, quantity, value):
    found = parse(text, quantity)
    assert found == value
    assert isinstance(found, float)
    assert str(found)[0] != "-"


REFUSED = [
    (MASS, ["44.36 kg/s", "0.5 g_0", "5 V/m", 44.36, "44.36", "44.36 tt", "44 tons", "44 mt", "44 5 t", "1,5 t"]),
    (MASS, ["heavy", "", "nan t", True, None, ["1 t"], "-3 t", "inf", "1e400 t"]),
    (YIELD_FORCE, ["450 kg", "450 kn", "450 KN", "5 kN/3", "0 kN"]),
    (GAP, ["5 %", 0, "3 bananas", "-5 mm"]),
    (PERIOD, ["5 rad"]),
    (HERTZ, ["5 kN/m"]),
    (PGA, ["0.5 m/s"]),
    (DAMPING, [float("nan"), 5, "5 mm", 10**400]),
    (RESTITUTION, [0]),
]


@pytest.mark.parametrize(
    ("text", "quantity"),
    [(text, quantity) for quantity, texts in REFUSED for text in texts],
    ids=lambda each: getattr(each, "words", repr(each)[:20]),
)
def test_refuses(text, quantity, says):
    says(refusal(parse, text, quantity, kind=QuantityError))


SAID = [
    (MASS, {44360.0: "44.36 t", 570.0: "570 kg"}),
    (PERIOD, {0.208: "0.208 s", 0.007: "0.007 s"}),
    (GAP, {0.025: "25 mm", 0.0: "0 mm", 1.25: "1.25 m", 3e-7: "0.3 µm"}),
    (YIELD_FORCE, {450e3: "450 kN", 1.3e6: "1300 kN", 36e6: "36 MN", inf: "inf"}),
    (PGA, {4.903325: "0.5 g"}),
    (HERTZ, {4.2e10: "4.2e7 kN/m^1.5"}),
    (STIFFNESS, {4.05e7: "40.5 MN/m"}),
    (DAMPING, {0.05: "0.05"}),
    (Quantity("J", 0.0, inf, "energy"), {12345.678: "12.35 kJ"}),
    (Quantity("N*s", 0.0, inf, "impulse"), {2.0: "2 N*s"}),
]


@pytest.mark.parametrize(
    ("value", "quantity", "text"), [(value, quantity, text) for quantity, said in SAID for value, text in said.items()]
)
def test_says(value, quantity, text):
    assert say(value, quantity) == text


positive = st.floats(1e-6, 1e12)


@settings(deadline=None)
@given(value=positive, quantity=st.sampled_from(DIMENSIONAL))
def test_exact_text_reads_back_to_the_same_bits(value, quantity):
    assert parse(exact(value, quantity), quantity) == value


@settings(deadline=None)
@given(value=positive, quantity=st.sampled_from(DIMENSIONAL))
def test_readable_text_reads_back_to_its_digits(value, quantity):
    assert parse(say(value, quantity, 6), quantity) == pytest.approx(value, rel=1e-5)


@settings(deadline=None)
@given(
    number=st.decimals("1e-3", "1e6", places=6),
    pair=st.sampled_from([(unit, key) for key, listed in USUAL.items() for unit, _ in listed]),
)
def test_usual_units_have_the_size_pint_gives_them(number, pair):
    """To the bit, as usual units are read without it."""
    unit, key = pair
    quantity = Quantity(key, 0.0, inf, "thing")
    exact_size, wrong = units._size_by_pint(unit, units._spelling(unit, key), key)
    assert wrong == ""
    assert parse(f"{number} {unit}", quantity) == float(number * exact_size)


@pytest.mark.parametrize("target", USUAL)
def test_usual_units_of_another_dimension_are_refused_as_pint_refuses_them(target):
    for unit in {unit for listed in USUAL.values() for unit, _ in listed}:
        assert units._size(unit, target) == units._size_by_pint(unit, units._spelling(unit, target), target), unit


@settings(deadline=None, max_examples=300)
@given(text=st.one_of(st.text(max_size=20), st.text("0123456789.eE+-^*/()%gmskNt ²µ_", max_size=14).map("5 {}".format)))
@pytest.mark.complete
def test_any_text_is_a_value_or_a_sentence(text):
    for quantity in (MASS, PGA, DAMPING):
        try:
            value = parse(text, quantity)
        except QuantityError as error:
            assert "\n" not in str(error)
            assert "write a" in str(error)
        else:
            assert quantity.allows(value)
            assert not isnan(value)


@pytest.mark.parametrize(
    ("change", "text"),
    [(0.0, "0"), (-1e-5, "0"), (0.0215, "+2.1"), (-0.094, "−9.4"), (0.0994, "+9.9"), (0.0996, "+10"), (-0.526, "−53")],
)
def test_a_change_in_per_cent_has_one_sign_in_all_sentences(change, text):
    assert signed_percent(change) == text


def test_gravity_and_ranges_in_words():
    assert parse("1 g", PGA) == STANDARD_GRAVITY
    assert bounds(RTOL) == "at least 1e-12 and at most 0.01"
    assert bounds(Quantity("s/m", -inf, inf, "linear coefficient")) == "a number"
    assert not MASS.allows(float("nan"))


def test_values_are_shown_as_in_a_file_and_short():
    assert shown({"a": [1, True], "b": "x\ny"}) == '{a = [1, true], b = "x\\ny"}'
    assert len(shown("x" * 1000)) == 60
    assert shown(list(range(20))) == "[0, 1, 2, 3, 4, 5, 6, 7, ...]"


@pytest.mark.complete
def test_pint_is_not_imported_before_it_is_needed():
    code = (
        "import sys, pounding_risk.units as q\n"
        "q.say(1.0, q.GAP), q.parse('4.2e7 kN/m^1.5', q.Quantity('N/m^1.5', 0.0, 1e99, '')), q.parse('0.5 g', q.PGA)\n"
        "assert 'pint' not in sys.modules\n"
        "q.parse('1 cm', q.GAP)\n"
        "assert 'pint' in sys.modules"
    )
    output("-c", code)


@pytest.mark.complete
def test_pint_is_found_where_the_command_line_keeps_it_from_other_libraries():
    code = (
        "import sys\n"
        "from pounding_risk import cli, units\n"
        "cli._block_imports(['scan', 'scene.toml'])\n"
        "import xarray\n"
        "xarray.Dataset({'a': ('x', [1.0])})\n"
        "assert not sys.modules.get('pint') and not sys.modules.get('dask')\n"
        "assert units.parse('1 cm', units.GAP) == 0.01\n"
        "assert sys.modules['pint'].__name__ == 'pint'"
    )
    output("-c", code)


@pytest.mark.parametrize("value", [0.02, "20 mm", "0.02 m"])
def test_a_call_takes_si_or_text(value):
    assert si(value, GAP) == 0.02


@pytest.mark.parametrize("value", ["20", "20 s", -0.1, None, [0.02], "a lot"])
def test_a_call_refuses_what_is_no_length_by_the_name_of_its_parameter(value):
    with pytest.raises(QuantityError, match=r"^gap: .*; write a clear distance at rest such as "):
        si(value, GAP, "gap")


@pytest.mark.parametrize("value", [0.84, 84, 84.0, "84", "0.84", "84 %", "84%"])
def test_shares_have_one_convention(value):
    assert share(value, "percentile") == 0.84


@pytest.mark.parametrize("value", [1, 1.0, "1", 0, "0 %", "100 %", 100, 101, -3, "x", True, None])
def test_shares_that_could_be_two_things_or_none_are_refused(value):
    with pytest.raises(QuantityError, match=r"^target: "):
        share(value, "target")


def test_a_share_keeps_to_its_range():
    assert share("1 %", "target") == 0.01
    with pytest.raises(QuantityError, match=r"is 0\.9 %; it must lie between 50 % and 100 %"):
        share("0.9 %", "percentile", low=0.5)


def test_an_exact_text_is_told_as_an_engineer_writes_it():
    texts = ("4000000.0 N s/m", "0.0 N s/m", "1500000.0 N", "20.0 m", 0.65, "concrete", "inf")
    assert [legible(text) for text in texts] == ["4 MN s/m", "0 N s/m", "1500 kN", "20 m", "0.65", "concrete", "inf"]
