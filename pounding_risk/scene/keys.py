"""Declaration of the keys of a scene: how a value is read and written, its words, example and default, in one place.

A table of a scene is a pydantic model, a `Table`, whose fields carry a `Key` each. From it follow the reader of scene
files with its sentences, the classes that scripts use, the JSON schema and the key tables of the docs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache, partial
from inspect import Parameter, Signature
from itertools import pairwise
from math import inf
from os import PathLike
from textwrap import wrap
from types import MappingProxyType
from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, ValidationError
from pydantic_core import CoreSchema, core_schema

from pounding_risk._common.words import meant_by, nearest
from pounding_risk.errors import SceneError
from pounding_risk.scene.not_modelled import instead_of, key_meant
from pounding_risk.scene.toml import Fault, KeyPath
from pounding_risk.units import EXAMPLES, Quantity, bounds, exact, parse, shown, si, written_example

LONGEST_AXIS = 10_000  # values of one list
REQUIRED, NOTHING = "required", "nothing"  # what holds where a key is left out
Number = Callable[[Any, Quantity], float]  # `parse` in files, where a number needs a unit; `si` in Python
Read = Callable[[Any, Number], Any]


class Unreadable(ValueError):
    """A value that a key cannot take; the sentence says what was found, what is allowed and the repair."""


class Several(Unreadable):
    """More than one fault in a value: the path below the key, and the sentence, of each."""

    def __init__(self, faults: list[tuple[KeyPath, str]]):
        self.faults = faults
        super().__init__("; ".join(sentence for _, sentence in faults))


def located(error: ValueError, *path: str | int) -> list[tuple[KeyPath, str]]:
    """The faults of a value that stands at this path below another: the path and the sentence of each."""
    faults = error.faults if isinstance(error, Several) else [((), str(error))]
    return [((*path, *below), sentence) for below, sentence in faults]


@dataclass(frozen=True)
class Key:
    """One key of a table.

    Attributes
    ----------
    words : str
        What it means.
    read : callable
        From the value as written, and `parse` or `si`, to SI numbers and names; raises Unreadable or QuantityError.
    example : str
        A value as a scene file has it.
    absent : str
        What holds where the key is left out.
    missing : str
        The sentence for a required key that is not there, where its example does not say it all.
    write : callable
        From the value that was read to the value as written.
    schema : dict
        JSON schema of the value as written; an entry that names laws or motions, to which plug-ins add, is a function.
    """

    words: str
    read: Read
    example: str
    absent: str = NOTHING
    missing: str = ""
    write: Callable[[Any], Any] = lambda value: value
    schema: Mapping[str, Any] = field(default_factory=dict)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(lambda value: self.read(plain(value), si))

    def defaults_to(self, value: Any) -> Any:
        """The field of a table that has this key, and this value where the key is left out."""
        table_field = Field(value)
        table_field.metadata.append(self)
        return table_field

    def required(self) -> Any:
        """The field of a table that must have this key."""
        key = replace(self, absent=REQUIRED) if self.absent == NOTHING else self
        return key.defaults_to(...)

    def lacks(self, name: str) -> str:
        """The sentence for the key of this name where it should be there and is not."""
        return self.missing or f"missing; write {name} = {self.example}"

    def documented(self, name: str, required: bool) -> list[str]:
        """The key as a parameter of its class, in the form of numpydoc."""
        unit = f" [{self.schema['x-unit']}]" if self.schema.get("x-unit", "1") != "1" else ""
        absent = "" if required else f" Without it: {self.absent}."
        words = f"{self.words.rstrip('.')}{unit}, such as {self.example}.{absent}"
        return [f"{name} : {self.kind}{'' if required else ', optional'}", *(f"    {row}" for row in wrap(words, 110))]

    @property
    def kind(self) -> str:
        """What Python may give, in words."""
        kinds = self.schema.get("type", "object")
        kinds = [kinds] if isinstance(kinds, str) else kinds
        if "x-unit" in self.schema:
            return "list of float or str" if "array" in kinds else "float or str"
        python_types = {"string": "str", "boolean": "bool", "integer": "int", "number": "float"}
        python_types |= {"array": "list", "object": "str or object"}
        return " or ".join(python_types[kind] for kind in kinds)

    def described(self) -> dict[str, Any]:
        """The key in a JSON schema; ``x-...`` says what a JSON schema has no keyword for."""
        schema = {key: value() if callable(value) else value for key, value in self.schema.items()}
        return {**schema, "description": self.words, "x-example": self.example, "x-absent": self.absent}


def _default(info: Any) -> Any:
    """The default of a key in a signature: None, for what is not given, in place of a model of several numbers."""
    if info.is_required():
        return Parameter.empty
    return None if hasattr(info.default, "_fields") else info.default


class Table(BaseModel):
    """A table of a scene; in Python an object with the same keys, whose numbers may be floats in SI.

    Keys may be given by position, in the order of the class. Raises SceneError with every fault.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)
    beside: ClassVar[Mapping[str, str]] = {}  # words on the parameters of Python that are no keys, by name

    def __init__(self, *values: Any, **keys: Any):
        names = self.key_names()
        if len(values) > len(names):
            raise SceneError(type(self).__name__, [f"{len(values)} values for its keys {', '.join(names)}"])
        if repeated_keys := [name for name in names[: len(values)] if name in keys]:
            raise SceneError(type(self).__name__, [f"{name}: given by position and by name" for name in repeated_keys])
        try:
            super().__init__(**dict(zip(names, values, strict=False)), **keys)
        except ValidationError as error:
            raise SceneError(type(self).__name__, list(self._sentences(error))) from None

    def __repr_args__(self) -> Iterator[tuple[str, Any]]:
        """What `repr` shows: the keys that are given."""
        return ((name, getattr(self, name)) for name in self.key_names() if name in self.model_fields_set)

    __str__ = BaseModel.__repr__

    @classmethod
    def __pydantic_init_subclass__(cls, **settings: Any) -> None:
        """Give the class a signature and the parameters of its docstring, from the declarations of its keys."""
        positional_kind, keyword_kind = Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY
        names, required = cls.key_names(), cls.required()
        # By position, every key before a required one is given too.
        optional_names = names[max((names.index(name) for name in required), default=-1) + 1 :]
        defaults = {name: _default(cls.model_fields[name]) for name in optional_names}
        cls.__signature__ = Signature(
            [
                *(Parameter(name, positional_kind, default=defaults.get(name, Parameter.empty)) for name in names),
                *(Parameter(name, keyword_kind, default=None) for name in cls.beside),
            ]
        )
        rows = [row for name, key in cls.keys().items() for row in key.documented(name, name in cls.required())]
        rows += [row for name, words in cls.beside.items() for row in (f"{name} : object, optional", f"    {words}")]
        if rows:
            cls.__doc__ = "\n".join([(cls.__doc__ or "").rstrip(), "", "Parameters", "----------", *rows, ""])

    @classmethod
    @cache
    def keys(cls) -> dict[str, Key]:
        """The declarations of its keys by name; a field without one is no key."""
        return {name: key for name, info in cls.model_fields.items() for key in info.metadata if isinstance(key, Key)}

    @classmethod
    def key_names(cls) -> list[str]:
        """Its keys, in the order in which Python may give them by position."""
        return list(cls.keys())

    @classmethod
    def required(cls) -> list[str]:
        """The keys that have no default."""
        return [name for name in cls.key_names() if cls.model_fields[name].is_required()]

    @classmethod
    def from_values(cls, values: Mapping[str, Any]) -> Any:
        """The table of values that have been read; all other keys have their defaults."""
        return cls.model_construct(_fields_set=set(values), **values)

    def updated(self, **values: Any) -> Any:
        """The table with these values, which are not checked."""
        return self.from_values({name: getattr(self, name) for name in self.model_fields_set} | values)

    def written(self) -> dict[str, Any]:
        """The keys that are given, as a scene file has them."""
        stated_keys = ((name, key) for name, key in self.keys().items() if name in self.model_fields_set)
        return {name: key.write(getattr(self, name)) for name, key in stated_keys}

    @classmethod
    def _sentences(cls, error: ValidationError) -> Iterator[str]:
        for fault in error.errors(include_url=False):
            name, cause = str(fault["loc"][0]), fault.get("ctx", {}).get("error")
            if fault["type"] == "missing":
                yield f"{name}: {cls.keys()[name].lacks(name)}"
            elif fault["type"] == "extra_forbidden":
                meant = key_meant(name, cls.key_names())
                hint = f' (did you mean "{meant}"?)' if meant else nearest(name, cls.key_names())
                hint += f"; it takes {', '.join(cls.key_names())}"
                yield f"{name}: unknown key{f'; {answer}' if (answer := instead_of(name)) else hint}"
            else:
                yield f"{name}: {cause}"


def plain(value: Any) -> Any:
    """A value of Python as a scene file has it: lists for tuples and arrays, text for paths."""
    if isinstance(value, PathLike):
        return str(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    if type(value) in (list, tuple):
        return [plain(element) for element in value]
    if type(value) is dict:
        return {key: plain(element) for key, element in value.items()}
    return value


def in_text(keys: Mapping[str, Key], table: Mapping[str, Any]) -> dict[str, Any]:
    """A table that Python gives as a dict, as a scene file has it: numbers in SI become text with their unit.

    A value that its key does not take stays as it is, for the reader of tables to refuse.
    """
    text_table = {}
    for name, value in table.items():
        text_table[name] = plain_value = plain(value)
        if name not in keys:
            continue
        with suppress(ValueError):
            keys[name].read(plain_value, parse)
            continue
        with suppress(ValueError):
            text_table[name] = keys[name].write(keys[name].read(plain_value, si))
    return text_table


@dataclass(frozen=True)
class Section:
    """A table of a scene file whose keys have been read, whatever is wrong with some of them."""

    kind: type[Table]
    path: KeyPath
    raw: Mapping[str, Any]  # as written
    values: Mapping[str, Any]  # in SI, of the keys that could be read

    def __contains__(self, key: str) -> bool:
        return key in self.raw

    def get(self, key: str, default: Any = None) -> Any:
        """The value of a key; the default where it is absent or could not be read."""
        return self.values.get(key, default)

    def fault(self, key: str, sentence: str, absent: bool = False) -> Fault:
        """A fault of one of its keys."""
        return Fault((*self.path, key), sentence, absent)


def repeated_names(tables: Sequence[Section], noun: str) -> Iterator[Fault]:
    """A fault for each table of an array with the name of an earlier one; ``noun`` is what a table describes."""
    first_index: dict[str, int] = {}
    for keys in tables:
        index, name = int(keys.path[1]), keys.get("name")
        if name and first_index.setdefault(name, index) != index:
            repair = f"give every {noun} a name of its own"
            yield keys.fault("name", f"{shown(name)} is the name of {noun} {first_index[name] + 1} too; {repair}")


@dataclass(frozen=True)
class Draft:
    """All tables of a scene whose keys have been read, before it is known whether they make a scene together."""

    raw: Mapping[str, Any]
    sections: Mapping[str, Sequence[Section]]
    axes: tuple[Any, ...] = ()  # of numbers, in [grid]: the path of each in the file, and its `SceneAxis`
    uncertain: tuple[Any, ...] = ()  # numbers of [uncertain], each a `PlacedNumber`

    def tables(self, name: str) -> Sequence[Section]:
        """The tables of an array of tables; what is no table is left out."""
        return self.sections.get(name, ())

    def table(self, name: str) -> Section:
        """A table that stands once; one without keys where it is absent."""
        return next(iter(self.tables(name)), Section(Table, (name,), {}, {}))

    def count(self, name: str, absent: int) -> int:
        """How many elements an array of tables has, tables or not; ``absent`` where there is none."""
        elements = self.raw.get(name)
        return len(elements) if isinstance(elements, list) else absent


def read_section(
    kind: type[Table], path: KeyPath, raw: Mapping[str, Any], keys: Mapping[str, Key], unknown: Callable[[str], str]
) -> tuple[Section, list[Fault]]:
    """Read every key of a table, with every fault.

    Parameters
    ----------
    kind : type of Table
        What the table is; its required keys must be there.
    path : tuple
        Where it stands in the scene.
    raw : mapping
        Its keys as written.
    keys : mapping of str to Key
        Declarations by name; those of other kinds too, whose values are read before their presence is refused.
    unknown : callable
        The sentence for a key that is not known.
    """
    values: dict[str, Any] = {}
    faults: list[Fault] = []
    for name, value in raw.items():
        if name not in keys:
            faults.append(Fault((*path, name), unknown(name)))
            continue
        try:
            values[name] = keys[name].read(value, parse)
        except ValueError as error:
            faults += [Fault(*fault) for fault in located(error, *path, name)]
    faults += [Fault((*path, name), keys[name].lacks(name), absent=True) for name in kind.required() if name not in raw]
    return Section(kind, path, raw, values), faults


# ------------------------------------------------------------------------------------------------ kinds of keys


def measured(quantity: Quantity, words: str, example: str = "", absent: str = NOTHING, missing: str = "") -> Key:
    """A quantity: text with a unit, or a plain number where it is dimensionless; its example by default."""
    kind = {"type": ["number", "string"]} if quantity.unit == "1" else {"type": "string"}
    return Key(
        words,
        lambda value, number: number(value, quantity),
        example or written_example(quantity),
        absent,
        missing,
        lambda value: exact(float(value), quantity),
        {**kind, **facts(quantity)},
    )


def facts(quantity: Quantity) -> dict[str, str]:
    """Unit and range of a key, for the schema."""
    return {"x-unit": quantity.unit, "x-range": bounds(quantity)}


def text(words: str, example: str, absent: str = NOTHING, missing: str = "") -> Key:
    """Text that is not blank."""
    refusal = f'is not a name; write text in quotes, such as "{example}"'
    schema = {"type": "string"}
    return Key(words, lambda value, number: text_from(value, refusal), f'"{example}"', absent, missing, schema=schema)


def text_from(value: Any, refusal: str) -> str:
    """The value, text that is not blank; ``refusal`` is the sentence on any other value, with the repair."""
    if not isinstance(value, str) or not value.strip():
        raise Unreadable(f"{shown(value)} {refusal}")
    return value


def file_name(value: Any, example: str) -> str:
    """The value, the name of a file beside the scene, such as the example."""
    return text_from(value, f"is not a file; write its name in quotes, such as {example}")


def flag(name: str, words: str, absent: str = "false") -> Key:
    """true or false, of the key of this name."""

    def read(value: Any, number: Number) -> bool:
        if not isinstance(value, bool):
            raise Unreadable(f"{shown(value)} is not true or false; write {name} = true, or remove it")
        return value

    return Key(words, read, "true", absent, schema={"type": "boolean"})


def one_of(
    allowed: Sequence[str],
    noun: str,
    words: str,
    example: str,
    absent: str = NOTHING,
    missing: str = "",
    elsewhere: Mapping[str, str] = MappingProxyType({}),
) -> Key:
    """One of these words; ``noun`` is what they are, with its article, ``elsewhere`` what other names mean here."""

    def read(value: Any, number: Number) -> str:
        if value not in allowed:
            meant_text = meant_by(value, elsewhere)
            hint = "" if meant_text else nearest(value, allowed)
            separator = " or " if len(allowed) == 2 else ", "
            raise Unreadable(
                f"{shown(value)} is not {noun}{hint}; it may be {separator.join(map(shown, allowed))}{meant_text}"
            )
        return str(value)

    return Key(words, read, example, absent, missing, schema={"enum": list(allowed)})


def whole(name: str, low: int, high: int, words: str, example: str, absent: str) -> Key:
    """A whole number, of the key of this name."""

    refusal = f"is not a whole number from {low} to {high}; write {name} = {example}"
    schema = {"type": "integer", "minimum": low, "maximum": high}
    return Key(words, lambda value, number: whole_from(value, low, high, refusal), example, absent, schema=schema)


def whole_from(value: Any, low: int, high: float, refusal: str) -> int:
    """The value, a whole number in a range; ``refusal`` is the sentence on any other value, with the repair."""
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise Unreadable(f"{shown(value)} {refusal}")
    return value


def by_address(words: str, example: str, absent: str) -> Key:
    """A table by the addresses of numbers, whose values are read where the scene is known."""

    def read(value: Any, number: Number) -> dict[str, Any]:
        if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
            raise Unreadable(f"{shown(value)} is not a table; write {example}")
        return value

    return Key(words, read, example, absent, schema={"type": "object"})


def one_or_more(refusal: str, words: str, example: str, absent: str) -> Key:
    """One name, or a list of them; ``refusal`` is the sentence on any other value, with the repair."""

    def read(value: Any, number: Number) -> tuple[str, ...]:
        names = value if isinstance(value, list) else [value]
        if not names or not all(isinstance(name, str) and name.strip() for name in names):
            raise Unreadable(f"{shown(value)} {refusal}")
        return tuple(names)

    def write(names: tuple[str, ...]) -> Any:
        return names[0] if len(names) == 1 else list(names)

    return Key(words, read, example, absent, write=write, schema={"type": ["string", "array"]})


def several(name: str, read_one: Read, words: str, example: str, absent: str) -> Key:
    """A list of names, each there once, of the key of this name."""

    def read(value: Any, number: Number) -> tuple[Any, ...]:
        elements = list_of(value, f"{name} = {example}")
        return tuple(each(elements, lambda element: read_one(element, number), distinct=True))

    return Key(words, read, example, absent, write=list, schema={"type": "array", "items": {"type": "string"}})


def axis(quantity: Quantity, words: str, example: str, absent: str) -> Key:
    """Values of the grid: an ascending list, or {start, stop, num}."""
    example_value = EXAMPLES[quantity.unit]

    def read(value: Any, number: Number) -> tuple[float, ...]:
        if isinstance(value, dict):
            return spaced(value, quantity, number)
        if not isinstance(value, list):
            raise Unreadable(
                f"{shown(value)} is not a list; write a list such as [{shown(example_value)}], "
                f"or {{start = ..., stop = {shown(example_value)}, num = 11}}"
            )
        elements = list_of(value, f"a list such as [{shown(example_value)}]")
        values = each(elements, lambda element: number(element, quantity), distinct=True)
        if any(after < before for before, after in pairwise(values)):
            order = [element for _, element in sorted(zip(values, value, strict=True), key=lambda pair: pair[0])]
            raise Unreadable(f"the values are not in ascending order; write {shown(order)}")
        return tuple(values)

    return Key(
        words,
        read,
        example,
        absent,
        write=lambda values: [exact(float(value), quantity) for value in values],
        schema={"type": ["array", "object"], **facts(quantity)},
    )


def spaced(value: dict[str, Any], quantity: Quantity, number: Number) -> tuple[float, ...]:
    """``num`` values from start to stop, both included, evenly spaced."""

    def bound(end: Any) -> float:
        limit = number(end, quantity)
        if limit == inf:
            raise Unreadable(f'{shown(end)} cannot bound even steps; write a list that ends with "inf" instead')
        return limit

    takes = "a range has start, stop and num"
    refusal = f"is not a count of values; write a whole number from 2 to {LONGEST_AXIS}"
    count = partial(whole_from, low=2, high=LONGEST_AXIS, refusal=refusal)
    kinds: dict[str, Callable[[Any], Any]] = {"start": bound, "stop": bound, "num": count}
    ends = options(value, kinds, tuple(kinds), lambda key: f"missing; {takes}", takes)
    if ends["stop"] <= ends["start"]:
        sentence = (
            f"{shown(value['stop'])} is not above start {shown(value['start'])}; "
            "swap them, or write a list with one value"
        )
        raise Several([(("stop",), sentence)])
    # In decimal fractions: the third of 51 values from 0 to 0.1 is 0.004, and no neighbour of it.
    start, stop, steps = Fraction(repr(ends["start"])), Fraction(repr(ends["stop"])), ends["num"] - 1
    return tuple(float(start + (stop - start) * step / steps) for step in range(steps + 1))


def list_of(value: Any, example: str) -> list[Any]:
    """A list that is neither empty nor absurdly long."""
    if not isinstance(value, list):
        raise Unreadable(f"{shown(value)} is not a list; write {example}")
    if not value:
        raise Unreadable(f"the list is empty; write {example}, or remove it")
    if len(value) > LONGEST_AXIS:
        raise Unreadable(f"the list has {len(value)} values, more than {LONGEST_AXIS}; split the scene in several")
    return value


def each(values: list[Any], read: Callable[[Any], Any], distinct: bool = False) -> list[Any]:
    """Every element read; all faults at once: of elements that fail and, if ``distinct``, of those that repeat."""
    elements: list[Any] = []
    faults: list[tuple[KeyPath, str]] = []
    first_values: dict[Any, Any] = {}
    for index, value in enumerate(values):
        try:
            elements.append(read(value))
        except ValueError as error:
            faults += located(error, index)
            continue
        if distinct and elements[-1] in first_values:
            first_value = first_values[elements[-1]]
            first_text = "" if first_value == value else f", first as {shown(first_value)}"
            faults.append(((index,), f"{shown(value)} stands twice{first_text}; remove one"))
        first_values.setdefault(elements[-1], value)
    if faults:
        raise Several(faults)
    return elements


def inline(kind: type[Table], name: str, value: Any, number: Number, example: str) -> Any:
    """The inline table of the key ``name`` as an object of its class; all faults at once."""
    if isinstance(value, kind):
        return value
    if not isinstance(value, dict):
        raise Unreadable(f"{shown(value)} is not a table; write {example}")
    keys = kind.keys()
    kinds = {key: lambda item, entry=entry: entry.read(item, number) for key, entry in keys.items()}
    return kind.from_values(
        options(value, kinds, kind.required(), lambda key: keys[key].lacks(key), f"{name} takes {', '.join(kinds)}")
    )


def options(
    value: Mapping[str, Any],
    kinds: Mapping[str, Callable[[Any], Any]],
    needed: Sequence[str],
    missing: Callable[[str], str],
    takes: str,
) -> dict[str, Any]:
    """The values of an inline table, each by its reader; all faults at once.

    Parameters
    ----------
    value : mapping
        The table as written.
    kinds : mapping of str to callable
        A reader for each key that it may have.
    needed : sequence of str
        Keys that must be there.
    missing : callable
        The sentence for one of them that is not.
    takes : str
        Which keys it takes, for one that is not known.
    """
    faults: list[tuple[KeyPath, str]] = []
    settings: dict[str, Any] = {}
    for key in [*value, *(key for key in needed if key not in value)]:
        try:
            if key not in kinds:
                raise Unreadable(f"unknown key{nearest(key, kinds)}; {takes}")
            if key not in value:
                raise Unreadable(missing(key))
            settings[key] = kinds[key](value[key])
        except ValueError as error:
            faults += located(error, key)
    if faults:
        raise Several(faults)
    return settings
