"""Units at the door: a field's unit and bounds, stated once beside the field, and text to SI.

Inside the package everything is kg, m, s, N. Text with a unit ("44.36 t", "25 mm", "4.2e7 kN/m^1.5")
becomes a number here and nowhere else.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Collection, Mapping
from decimal import Decimal, InvalidOperation
from functools import lru_cache
from math import inf, isfinite, isnan
from types import MappingProxyType
from typing import Any, NamedTuple

from pounding_risk._common.words import meant_by, nearest
from pounding_risk.errors import PoundingError

STANDARD_GRAVITY = 9.80665  # m/s², exact by definition (3rd CGPM, 1901)


class QuantityError(PoundingError, ValueError):
    """Text that is not a value of a quantity; the sentence quotes it, and says what to write instead."""


class Quantity(NamedTuple):
    """What a number means: SI unit, the closed or open range it may lie in, and words for it.

    A bound is exclusive where its ``open_low`` or ``open_high`` flag is set. ``example`` is what a message
    suggests to write; without it a usual value of that unit is shown.
    """

    unit: str
    low: float
    high: float
    words: str
    open_low: bool = False
    open_high: bool = False
    example: str = ""

    def allows(self, value: float) -> bool:
        """True where ``value`` lies in the range; NaN never does."""
        above = value > self.low if self.open_low else value >= self.low
        below = value < self.high if self.open_high else value <= self.high
        return above and below


MASS = Quantity("kg", 0.0, inf, "mass", open_low=True, open_high=True)
PERIOD = Quantity("s", 0.0, inf, "period of vibration", open_low=True, open_high=True)
STIFFNESS = Quantity("N/m", 0.0, inf, "lateral stiffness", open_low=True, open_high=True, example="40.5 MN/m")
DAMPING = Quantity("1", 0.0, 1.0, "damping ratio", open_high=True, example="0.05")
FLOOR_MASS = Quantity("kg", 0.0, inf, "mass of a floor", open_low=True, open_high=True, example="44 t")
STOREY_HEIGHT = Quantity("m", 0.0, inf, "height", open_low=True, open_high=True, example="3 m")
HEIGHT = Quantity("m", 0.0, inf, "height above the ground", open_high=True, example="12 m")
INITIAL_DISPLACEMENT = Quantity("m", -inf, inf, "initial displacement", open_low=True, open_high=True, example="20 mm")
INITIAL_VELOCITY = Quantity("m/s", -inf, inf, "initial velocity", open_low=True, open_high=True, example="0.5 m/s")
GROUND_FACTOR = Quantity("1", -inf, inf, "factor on the ground motion", open_low=True, open_high=True, example="-1.0")
GROUND_DELAY = Quantity("s", 0.0, inf, "delay of the ground motion", open_high=True, example="0.1 s")
GROUND_VELOCITY = Quantity("m/s", -inf, inf, "ground velocity", open_low=True, open_high=True, example="0.1 m/s")
STOREY_STRENGTH = Quantity("N", 0.0, inf, "yield shear of a storey", open_low=True, example="1400 kN")
COLUMN_STRENGTH = Quantity("N", 0.0, inf, "strength of struck columns", open_low=True, open_high=True, example="300 kN")
LEVELS = Quantity("m", 1e-3, inf, "tolerance of levels", open_high=True, example="0.1 m")
GAP = Quantity("m", 0.0, inf, "clear distance at rest")
YIELD_FORCE = Quantity("N", 0.0, inf, "yield force F_E", open_low=True)
# Stiffer than any steel between two floors, at 1e15 N/m a run would follow vibrations of it alone.
LINK_STIFFNESS = Quantity("N/m", 0.0, 1e13, "stiffness of a link", example="20 MN/m")
LINK_STRENGTH = Quantity("N", 0.0, inf, "strength of a link", open_low=True, example="200 kN")
LINK_BREAKING_FORCE = Quantity("N", 0.0, inf, "breaking force of a link", open_low=True, example="300 kN")
LINK_SLACK = Quantity("m", 0.0, 100.0, "slack of a link", example="20 mm")
LINK_DAMPING = Quantity("N s/m", 0.0, 1e12, "coefficient of a damper", example="2 MN s/m")
LINK_BRACE = Quantity("N/m", 0.0, 1e13, "stiffness of a brace", open_low=True, example="100 MN/m")
LINK_EXPONENT = Quantity("1", 0.1, 2.0, "exponent of a damper", example="0.3")
RESTITUTION = Quantity("1", 0.0, 1.0, "coefficient of restitution e", open_low=True, example="0.65")
SPEED = Quantity("m/s", 0.0, inf, "approach speed", open_low=True, open_high=True)
FLOOR_LENGTH = Quantity("m", 0.0, inf, "length of a floor", open_low=True, open_high=True, example="20 m")
USUAL_FLOOR_LENGTH = 20.0  # m, where a building gives none, as the example of the key: no source has a usual length
WAVE_SPEED = Quantity("m/s", 0.0, inf, "wave speed", open_low=True, open_high=True, example="3500 m/s")
PGA = Quantity("m/s^2", 0.0, inf, "peak ground acceleration", open_low=True, open_high=True)
SCALE = Quantity("1", 0.0, inf, "scale factor", open_low=True, open_high=True, example="1.5")
STEP = Quantity("s", 0.0, 1.0, "time step of the samples", open_low=True, example="0.01 s")
TIME = Quantity("s", 0.0, inf, "time from the record's start", open_high=True, example="6 s")
DIRECTION = Quantity("deg", 0.0, 360.0, "direction clockwise from north", example="30 deg")
TAIL = Quantity("s", 0.0, inf, "duration of free vibration", open_high=True, example="5 s")
RTOL = Quantity("1", 1e-12, 1e-2, "relative tolerance", example="1e-6")
PROBABILITY = Quantity("1", 0.0, 1.0, "probability", open_low=True, open_high=True, example='"10 %" or 0.1')

# Usual units of the trade per SI unit, largest first, with their exact size: what `say` chooses from.
USUAL: dict[str, tuple[tuple[str, float], ...]] = {
    "kg": (("t", 1e3), ("kg", 1.0)),
    "s": (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)),
    "m": (("m", 1.0), ("mm", 1e-3), ("µm", 1e-6)),
    "N": (("MN", 1e6), ("kN", 1e3), ("N", 1.0)),
    "N/m": (("GN/m", 1e9), ("MN/m", 1e6), ("kN/m", 1e3), ("N/m", 1.0)),
    "N/m^1.5": (("kN/m^1.5", 1e3), ("N/m^1.5", 1.0)),
    "m/s": (("m/s", 1.0), ("mm/s", 1e-3)),
    "m/s^2": (("g", STANDARD_GRAVITY),),
    "J": (("MJ", 1e6), ("kJ", 1e3), ("J", 1.0)),
    "N s": (("kN s", 1e3), ("N s", 1.0)),
    "N s/m": (("MN s/m", 1e6), ("kN s/m", 1e3), ("N s/m", 1.0)),
}
# The unit in which tables, figures and pages show a value whatever its size, by the SI unit as datasets write it, and
# what the value is multiplied by.
SHOWN: dict[str, tuple[str, float]] = {
    "m": ("mm", 1e3),
    "N": ("kN", 1e-3),
    "N s": ("kN s", 1e-3),
    "J": ("kJ", 1e-3),
    "kg": ("t", 1e-3),
    "m/s2": ("g", 1.0 / STANDARD_GRAVITY),
    "%": ("%", 1e2),
    "s": ("s", 1.0),
    "m/s": ("m/s", 1.0),
    "N/m": ("kN/m", 1e-3),
    "N s/m": ("kN s/m", 1e-3),
    "N/m^1.5": ("kN/m^1.5", 1e-3),
    "1": ("", 1.0),
}
MISSING = "–"  # where there is no number
# The trade says 450 kN and 1300 kN, 350 mm and 0.007 s: a unit is left below this many of it.
FEWEST = {"m": 1.0, "mm": 0.01, "s": 0.001, "MN": 10.0, "GN/m": 10.0, "kN/m^1.5": 0.01, "g": 0.0}

EXAMPLES = {
    "kg": "44.36 t",
    "s": "0.208 s",
    "m": "25 mm",
    "N": "450 kN",
    "N/m": "8.9e5 kN/m",
    "N/m^1.5": "4.2e7 kN/m^1.5",
    "m/s": "0.5 m/s",
    "m/s^2": "0.5 g",
    "deg": "30 deg",
    "1": "0.5",
}
# What a unit measures, so that a wrong dimension can be named; the first match wins.
DIMENSIONS = {
    "kg": "a mass",
    "s": "a time",
    "m": "a length",
    "N": "a force",
    "m/s^2": "an acceleration",
    "m/s": "a speed",
    "N/m": "a linear stiffness (force/length)",
    "N/m^1.5": "an impact stiffness (force/length^1.5)",
    "Hz": "a frequency",
    "kg/s": "a mass flow",
    "Pa": "a pressure",
    "J": "an energy or a moment",
    "W": "a power",
    "N*s": "an impulse",
    "m^2": "an area",
    "m^3": "a volume",
    "kg/m^3": "a density",
    "kg/m": "a mass per length",
    "K": "a temperature",
    "A": "an electric current",
    "V": "a voltage",
    "tesla": "a magnetic field",
}
# Spellings offered when a unit is not known.
FAMILIAR = [
    "kg", "t", "s", "ms", "min", "m", "cm", "mm", "km", "N", "kN", "MN", "kN/m", "MN/m", "N/m", "kN/m^1.5", "N/m^1.5",
    "m/s", "mm/s", "m/s^2", "cm/s^2", "g", "Gal", "lb", "kip", "in", "ft", "J", "kJ",
]  # fmt: skip

_NUMBER = re.compile(
    r"\s*([+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|inf(?![a-z])|nan(?![a-z])))(.*)", re.DOTALL
)
# Names that pint would read one way and an engineer another.
AMBIGUOUS = {
    "ton": '1000, 907 or 1016 kg: write "t" for 1000 kg',
    "tons": '1000, 907 or 1016 kg: write "t" for 1000 kg',
    "mt": 'a thousandth of a tonne or a "metric ton": write "kg" or "t"',
}

# A unit is a product of names with plain exponents: nothing that could hide a second number.
_CELL = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_UNIT = re.compile(r"[A-Za-zµμΩ_][A-Za-zµμΩ_0-9²³ .*·/^()-]*")
_POWER = re.compile(r"(\^|\*\*)\s*\(?\s*(-?\d+(?:\.\d+)?(?:/[1-9]\d*)?)\s*\)?")


def parse(text: object, quantity: Quantity) -> float:
    """The value of ``text`` in the SI unit of ``quantity``.

    ``text`` is a number with a unit ("44.36 t", "0.5 g", "4.2e7 kN/m^1.5"), or "inf" where no limit is meant.
    "g" is standard gravity where the quantity is an acceleration, a gram anywhere else. A dimensionless quantity
    takes a plain number (0.05, "0.05") or a percentage ("5 %"), nothing else. The conversion is decimal and
    rounded once: "25 mm" is the float 0.025.

    Raises QuantityError for a missing, unknown or wrong unit, for what is no number, and out of range.
    """
    needed = article(quantity.words)
    if isinstance(text, bool) or not isinstance(text, str | int | float):
        raise QuantityError(f"{shown(text)} is not {needed}; {repair(quantity)}")
    match = _NUMBER.fullmatch(text if isinstance(text, str) else shown(text))
    if not match or (isinstance(text, str) and re.match(r"\s*[+-]?\d+,\d", text)):
        comma = " (write a decimal point, not a comma)" if match else ""
        kind = "a number" if quantity.unit == "1" else "a number with a unit"
        raise QuantityError(f"{shown(text)} is not {kind}{comma}; {repair(quantity)}")
    try:
        number = Decimal(match[1])
    except InvalidOperation:  # an exponent of more than eighteen digits
        number = Decimal("inf")
    if number.is_nan():
        raise QuantityError(f"{shown(text)} is not a number; {repair(quantity)}")
    unit = match[2].strip()
    if quantity.unit == "1":
        if unit not in ("", "%"):
            raise QuantityError(f"{shown(text)} has a unit, but {needed} is a plain number; {repair(quantity)}")
        value = float(number / 100 if unit else number)
    elif not unit and not number.is_infinite():
        raise QuantityError(f"{shown(text)} has no unit, and {needed} needs one; {repair(quantity)}")
    else:
        size, wrong = _size(unit, quantity.unit) if unit else (Decimal(1), "")
        if wrong:
            raise QuantityError(f"{shown(text)} {wrong}; {repair(quantity)}")
        try:
            value = float(number if number.is_infinite() else number * size)
        except ArithmeticError:  # past the range of a Decimal, far past that of a float
            value = inf
        value = inf if isnan(value) else value
    if not quantity.allows(value):
        raise QuantityError(f"{shown(text)} is out of range: {needed} must be {bounds(quantity)}; {repair(quantity)}")
    return value + 0.0  # no minus zero


def parse_cell(text: str, unit: str, quantity: Quantity) -> float:
    """The SI value of a cell of a table: a plain number where the head of its column has a unit, else with its own."""
    if unit and not _CELL.fullmatch(text.strip()):
        words = f"is not a plain number, and the column's unit is {unit}; write a number"
        raise QuantityError(f"{shown(text.strip())} {words}")
    return parse(f"{text.strip()} {unit}" if unit else text.strip(), quantity)


def si(value: Any, quantity: Quantity, name: str = "") -> float:
    """A number in the SI unit of ``quantity`` as it is, or text with a unit converted: what Python calls take.

    Parameters
    ----------
    value : float or str
        0.02 or "20 mm" where ``quantity`` is a length.
    quantity : Quantity
        What the number means, with its bounds.
    name : str
        The parameter, which the error names first.

    Raises
    ------
    QuantityError
        For what is no number, a wrong unit, and a value out of the bounds.
    """
    place = f"{name}: " if name else ""
    if isinstance(value, str | bool):
        try:
            return parse(value, quantity)
        except QuantityError as error:
            raise QuantityError(f"{place}{error}") from None
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise QuantityError(f"{place}{shown(value)} is not {article(quantity.words)}; {repair(quantity)}") from None
    if not quantity.allows(number):
        allowed = f"{article(quantity.words)} must be {bounds(quantity)}"
        raise QuantityError(f"{place}{number:g} is out of range: {allowed}; {repair(quantity)}")
    return number


def share(value: Any, name: str, *, low: float = 0.0, high: float = 1.0) -> float:
    """A probability, percentile or confidence as a fraction, by one convention for all three.

    A plain number below 1 is a fraction (0.16), one above 1 is in percent (84), text may say so itself ("84 %").
    1 alone could be either and is refused.

    Parameters
    ----------
    value : float or str
        0.84, 84, "84", "84 %" or "0.84".
    name : str
        The parameter or option, which the error names first.
    low, high : float
        The ends of the range, both excluded, as fractions.

    Raises
    ------
    QuantityError
        For what is no number, for 1, and for a share outside the range.
    """
    percent = Quantity("1", 0.0, inf, f"{name} (a share)", example=PROBABILITY.example)
    number = si(value, percent, name)
    written_as_percent = isinstance(value, str) and "%" in value
    if number == 1.0 and not written_as_percent:
        raise QuantityError(f'{name}: {shown(value)} could be 1 % or 100 %; write "1 %", or a fraction such as 0.01')
    fraction = number if written_as_percent or number < 1.0 else number / 100.0
    if not low < fraction < high:
        raise QuantityError(
            f"{name}: {shown(value)} is {100.0 * fraction:.6g} %; it must lie between {100.0 * low:g} % and "
            f"{100.0 * high:g} %, ends excluded"
        )
    return fraction


def repair(quantity: Quantity) -> str:
    """What to write instead: `write a mass such as "44.36 t"`."""
    return f"write {article(quantity.words)} such as {written_example(quantity)}"


def written_example(quantity: Quantity) -> str:
    """A value as a scene file has it: text with a unit in quotes, or a plain number."""
    example = quantity.example or EXAMPLES.get(quantity.unit, f"1 {quantity.unit}")
    return example if quantity.unit == "1" else f'"{example}"'


def bounds(quantity: Quantity) -> str:
    """The range in words: "greater than 0 kg and finite", "at least 0 and less than 1"."""
    unit = "" if quantity.unit == "1" else f" {quantity.unit}"
    words = []
    if quantity.low > -inf:
        words.append(f"{'greater than' if quantity.open_low else 'at least'} {quantity.low:g}{unit}")
    if quantity.high < inf:
        words.append(f"{'less than' if quantity.open_high else 'at most'} {quantity.high:g}{unit}")
    elif quantity.open_high:
        words.append("finite")
    return " and ".join(words) or "a number"


def say(value: float, quantity: Quantity, digits: int = 4) -> str:
    """``value`` (SI) as an engineer writes it: 44.36 t, 450 kN, 25 mm, 0.5 g; inf stays inf."""
    units = USUAL.get(quantity.unit, ((quantity.unit, 1.0),))
    if quantity.unit == "1" or not isfinite(value):
        return _digits(value, digits)
    if value == 0.0:
        return f"0 {'mm' if quantity.unit == 'm' else units[-1][0] if len(units) < 3 else quantity.unit}"
    for unit, size in units:
        if abs(value) >= size * FEWEST.get(unit, 1.0):
            break
    return f"{_digits(value / size, digits)} {unit}"


def say_in(value: float, unit: str, digits: int = 4) -> str:
    """``value`` (SI) in one of the units of `USUAL`, whatever its size: 0.9 mm beside 1200 mm."""
    size = next(size for units in USUAL.values() for name, size in units if name == unit) if value else 1.0
    return f"{_digits(value / size, digits)} {unit}"


def legible(value: Any) -> str:
    """A value as `exact` writes it, for a reader: 4 MN s/m of "4000000.0 N s/m"; other values as they are."""
    number, _, unit = str(value).partition(" ")
    try:
        return say(float(number), Quantity(unit or "1", -inf, inf, ""), 6)
    except ValueError:
        return str(value)


def exact(value: float, quantity: Quantity) -> str | float:
    """``value`` as text that `parse` turns into the very same float; a plain number where dimensionless."""
    if quantity.unit == "1":
        return value
    return f"{value!r} {quantity.unit}" if isfinite(value) else repr(value)


def article(words: str) -> str:
    """The words with "a" or "an" before them."""
    return f"{'an' if words.startswith(('a', 'e', 'i', 'o', 'u')) else 'a'} {words}"


def unknown(value: Any, kind: str, known: Collection[str], elsewhere: Mapping[str, str] = MappingProxyType({})) -> str:
    """What is wrong with a name that is none of the known ones: "5 is not a typology; it may be masonry, steel".

    ``elsewhere`` says what names of the field are called here: of these no known name is guessed from its letters.
    """
    meant = meant_by(value, elsewhere)
    return f"{shown(value)} is {kind}{'' if meant else nearest(value, known)}; it may be {', '.join(known)}{meant}"


def shown(value: Any) -> str:
    """A value as it stands in a scene file, shortened to 60 characters."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, str):
        text = f'"{value}"'
    elif isinstance(value, dict):
        text = "{" + ", ".join(f"{key} = {shown(item)}" for key, item in value.items()) + "}"
    elif isinstance(value, list | tuple):
        text = "[" + ", ".join(shown(item) for item in value[:8]) + (", ..." if len(value) > 8 else "") + "]"
    elif isinstance(value, int) and abs(value) >= 10**40:
        text = "an integer of more than 40 digits"
    else:
        text = str(value)
    text = "".join(letter if letter.isprintable() else repr(letter)[1:-1] for letter in text[:61])
    return text if len(text) <= 60 else text[:57] + "..."


def rounded(value: float, digits: int = 4) -> str:
    """Significant digits without a padded exponent; whole numbers up to 99999 in full; – for NaN, ∞ for inf."""
    if isnan(value):
        return MISSING
    if not isfinite(value):
        return "∞" if value > 0.0 else "-∞"
    return _digits(value + 0.0, digits)  # adding zero takes the sign from −0


def signed_percent(change: float) -> str:
    """A relative change in per cent with its sign, without the unit: to a tenth below 10 %; none is "0".

    The minus is that of print, as on the axes of figures; numbers of tables, which are copied, have a hyphen.
    """
    percent = round(100.0 * float(change), 1 if abs(change) < 0.0995 else 0)
    return "0" if percent == 0.0 else f"{percent:+g}".replace("-", "−")


def _digits(value: float, digits: int) -> str:
    """Significant digits without a padded exponent: 4.2e7, not 4.2e+07; whole numbers up to 99999 in full."""
    text = f"{value:.{digits}g}"
    if "e" in text and 1.0 <= abs(value) < 1e5:
        text = f"{float(text):.0f}"
    mantissa, _, exponent = text.partition("e")
    return f"{mantissa}e{int(exponent)}" if exponent else text


@lru_cache(maxsize=1)
def _registry() -> Any:
    """The one registry of units; Decimal keeps 25 mm exact.

    Loading pint and its registry takes half of the time in which a scene is checked: usual units do without.
    """
    if not sys.modules.get("pint", True):
        del sys.modules["pint"]  # the command line keeps other libraries from importing it
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


def _spelling(unit: str, target: str) -> str:
    """The unit in pint's spelling: m2, m^(3/2) and · are understood, g and gal follow the dimension of the target."""
    unit = unit.replace("·", "*")
    unit = re.sub(r"(?<=[A-Za-zµμ])(?=\d)", "^", unit)
    if target == "m/s^2":
        unit = {"g": "standard_gravity", "gal": "Gal"}.get(unit, unit)
    return unit


@lru_cache(maxsize=256)
def _size(unit: str, target: str) -> tuple[Decimal, str]:
    """How many ``target`` one ``unit`` is, or what is wrong with it."""
    spelling = _spelling(unit, target)
    if unit == "%":
        return Decimal(0), f"is a percentage, not {_kind(target)}"
    if unit in AMBIGUOUS:
        return Decimal(0), f'has the unit "{unit}", which could be {AMBIGUOUS[unit]}'
    if not _UNIT.fullmatch(spelling) or re.search(r"\d", _POWER.sub("", spelling).replace("g_0", "")):
        return Decimal(0), f"has {shown(unit)} after the number, which is not a unit"
    usual = dict(USUAL.get(target, ())) | {target: 1.0}
    if unit in usual:
        return Decimal(repr(usual[unit])), ""
    for measured, listed in USUAL.items():
        # A gram where the target is a mass is none of the accelerations.
        is_listed = unit in dict(listed) and measured in DIMENSIONS and target in USUAL
        if is_listed and _spelling(unit, measured) == spelling:
            return Decimal(0), _of_another_dimension(DIMENSIONS[measured], unit, target)
    return _size_by_pint(unit, spelling, target)


def _size_by_pint(unit: str, spelling: str, target: str) -> tuple[Decimal, str]:
    """As `_size`, for a unit in the registry's ``spelling``: any product of any units."""
    registry = _registry()
    try:
        one = registry.Quantity(Decimal(1), registry.parse_units(spelling))
        wanted = registry.parse_units(target)
        if one.dimensionality == wanted.dimensionality:
            return one.to(wanted).magnitude, ""
        measure = one.dimensionality
    except Exception:  # pint lets its own, tokenizer, syntax and arithmetic errors out
        return Decimal(0), f'has the unit "{unit}", which is not known{_meant(unit, FAMILIAR)}'
    for known, words in DIMENSIONS.items():
        if registry.parse_units(known).dimensionality == measure:
            return Decimal(0), _of_another_dimension(words, unit, target)
    kind = "a plain number or an angle" if not measure else f"of dimension {measure}"
    return Decimal(0), f"is {kind}, not {_kind(target)}"


def _of_another_dimension(words: str, unit: str, target: str) -> str:
    fitting = [known for known, _ in USUAL.get(target, ()) if known.lower() == unit.lower()]
    return f"is {words}, not {_kind(target)}{_meant(unit, fitting)}"


def _meant(unit: str, known: list[str]) -> str:
    """A likely spelling: the same letters in another case first, then the nearest."""
    return nearest(unit, [name for name in known if name.lower() == unit.lower()] or known, 0.5)


def _kind(unit: str) -> str:
    # An angle is a plain number to the registry, so that it cannot stand among the dimensions.
    return "an angle" if unit == "deg" else DIMENSIONS.get(unit, f"a quantity in {unit}")
