"""The [[interface]] tables of a scene: gap and contact of two neighbours, and where they meet.

Two single masses that meet mass to mass are run by the pair's solver, everything else by that of rows: more than two
buildings, storeys, heights that differ, contact points of the scene's own, and effects that act on buildings.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from math import inf
from typing import Annotated, Any, NamedTuple

from pounding_risk._common.counted import counted
from pounding_risk._common.words import nearest
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.contact.impulsive import CONTACT_MODELS, INSTANT_LAWS, is_instant
from pounding_risk.models.contact.laws import LAWS, SHIPPED, stiffness_quantity
from pounding_risk.models.contact.laws.bilinear import DESIGN_PENETRATION
from pounding_risk.models.contact.laws.van_mier import EXPONENT
from pounding_risk.models.contact.relation import (
    AS_ASKED,
    AS_PUBLISHED,
    RELATIONS,
    faults,
    is_ratio,
    least_of,
    misfit,
    name_of,
    out_of_reach,
    related,
    written_ratio,
)
from pounding_risk.models.effects import EFFECTS, PerInterface, acts_on_buildings
from pounding_risk.models.restitution import NAMED, Restitution, constant
from pounding_risk.models.structures.contact_points import (
    LevelRule,
    Meeting,
    Point,
    automatic_points,
    floor_number,
    floor_words,
    given_point,
    level_gap,
    usual_depth,
)
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.scene.buildings import RigidWall, ShearBuilding, TypologyBuilding
from pounding_risk.scene.keys import (
    REQUIRED,
    Draft,
    Key,
    Number,
    Section,
    Several,
    Table,
    Unreadable,
    each,
    flag,
    list_of,
    measured,
    options,
)
from pounding_risk.scene.toml import Fault, KeyPath
from pounding_risk.units import (
    GAP,
    LEVELS,
    RESTITUTION,
    SPEED,
    STOREY_HEIGHT,
    YIELD_FORCE,
    QuantityError,
    exact,
    parse,
    say,
    shown,
)

EQUAL_TERMS = ("peak force", "penetration")  # what laws with a k and laws with a β can be made to agree in
NO_RESTITUTION = "not given"
LATER_RESTITUTION = ("steel",)
PARAMETERS = ("plastic_exponent", "design_penetration")  # of single laws, beside their stiffness
OF_POINTS = ("contact", "tolerance", "column_yield_force")  # keys that a pair of masses has no use for
MEETING = '{left = "storey 2", right = "column 3 at 0.5"}'
_MISSING_RESTITUTION = 'write restitution = 0.65, or restitution = "concrete"'


def known_law(name: str) -> Any:
    """The class of a contact model; raises PoundingError, with the nearest name, where there is none."""
    if not isinstance(name, str) or name not in CONTACT_MODELS:
        raise PoundingError(unknown_law(name))
    return CONTACT_MODELS[name]


def unknown_law(name: object) -> str:
    """A sentence for a contact model that is not there."""
    hint = nearest(name, CONTACT_MODELS) if isinstance(name, str) else ""
    return f"{shown(name)} is not a contact model{hint}; it may be {', '.join(CONTACT_MODELS)}"


# ------------------------------------------------------------------------------------------------ keys


class GivenRestitution(NamedTuple):
    """A coefficient of restitution as a scene gives it."""

    rule: Restitution
    words: str  # the relation's name, the number, the damping ratio and its law, or NO_RESTITUTION
    relation: str = AS_PUBLISHED  # of restitution and damping

    def written(self) -> Any:
        """As a scene file has it."""
        value = self.words if self.words in NAMED or is_ratio(self.words) else self.rule.c0
        return value if self.relation == AS_PUBLISHED else {"value": value, "relation": self.relation}


def said_restitution(words: str) -> str:
    """The words of `GivenRestitution` for a reader: a damping ratio with the e that follows from it."""
    return written_ratio(words)[1] if is_ratio(words) else words


def _restitution(value: Any, number: Number) -> GivenRestitution:
    """e(v), the words for it, and its relation to damping: a value alone, or a table of value and relation."""
    if not isinstance(value, dict):
        return GivenRestitution(*_rule(value, number))
    wrong: list[tuple[KeyPath, str]] = [((key,), sentence) for key, sentence in faults(value)]
    try:
        rule, words = _rule(value.get("value", 1.0), number)  # a value that is missing is among the faults
    except ValueError as error:
        wrong.append((("value",), str(error)))
    if is_ratio(value.get("value")) and value.get("relation", AS_PUBLISHED) != AS_PUBLISHED:
        wrong.append((("relation",), "a damping ratio ξ is that of the published relation; remove relation, or give e"))
    if wrong:
        raise Several(wrong)
    return GivenRestitution(rule, words, value.get("relation", AS_PUBLISHED))


def _rule(value: Any, number: Number) -> tuple[Restitution, str]:
    """A number in (0, 1], the name of a relation e(v) or a damping ratio of a law; with the words for it."""
    if isinstance(value, Restitution):
        return _given_rule(value, number)
    if is_ratio(value):
        e, _ = written_ratio(value)
        return constant(e), " ".join(value.replace("ξ", "xi").replace("=", " ").split())
    if isinstance(value, str) and value[:1].isalpha() and value.lower() not in ("inf", "nan"):
        if value in NAMED:
            return NAMED[value], value
        names = ", ".join(f'"{name}"' for name in NAMED)
        if value in LATER_RESTITUTION:
            raise Unreadable(f"{shown(value)} is not in this version; write a number such as 0.6, or one of {names}")
        raise Unreadable(
            f"{shown(value)} is not a named restitution{nearest(value, NAMED)}; "
            f"write a number such as 0.65, or one of {names}"
        )
    e = number(value, RESTITUTION)
    return constant(e), f"{e!r}"


def _given_rule(rule: Restitution, number: Number) -> tuple[Restitution, str]:
    """A relation of `models.restitution`, which a scene file can state by its name or by its number."""
    for name, known in NAMED.items():
        if rule == known:
            return known, name
    if rule != Restitution(rule.c0):
        raise Unreadable(f"a relation e(v) of your own has no name in a scene; write e, or one of {', '.join(NAMED)}")
    return _rule(rule.c0, number)


def _law_name(value: Any, number: Number) -> str:
    """The name of a contact model."""
    if isinstance(value, str) and value in CONTACT_MODELS:
        return value
    if isinstance(value, str):
        raise Unreadable(unknown_law(value))
    raise Unreadable(f"{shown(value)} is not the name of a contact model; it may be {', '.join(CONTACT_MODELS)}")


LAW_NAME = Key(
    "The contact model.",
    _law_name,
    '"jankowski"',
    "the first of grid.contact_model",
    schema={"enum": [*SHIPPED, *INSTANT_LAWS]},
)


def _law_names(value: Any, number: Number) -> tuple[str, ...]:
    """The contact models of a grid, in the order written."""
    asked = list_of(value, 'contact_model = ["jankowski", "hertz"]')
    return tuple(each(asked, lambda name: _law_name(name, number), distinct=True))


LAW_NAMES = Key(
    "Contact models; a dimension of the dataset.",
    _law_names,
    '["jankowski", "hertz"]',
    "that of the interface",
    write=list,
    schema={"type": "array", "items": {"type": "string"}},
)


def _contact_points(value: Any, number: Number) -> tuple[tuple[float, float], ...]:
    """The floor numbers of a scene's own contact points: (left, right) of each, in ascending order."""
    return tuple(sorted(each(list_of(value, f"contact = [{MEETING}]"), _meeting, distinct=True)))


def _meeting(value: Any) -> tuple[float, float]:
    if not isinstance(value, dict):
        raise Unreadable(f"{shown(value)} is not a contact point; write {MEETING}")
    sides = {"left": _floor, "right": _floor}
    floors = options(value, sides, tuple(sides), f"missing; write {MEETING}", "a contact point has left and right")
    return floors["left"], floors["right"]


def _floor(value: Any) -> float:
    floor = floor_number(value) if isinstance(value, str) else None
    if floor is None:
        raise Unreadable(
            f'{shown(value)} is not a place on a building; write "storey 2" for the floor on top of storey 2, '
            'or "column 3 at 0.5" for half-way up storey 3'
        )
    return floor


def _same(value: Any, number: Number) -> str:
    """What the laws of both families have in common."""
    if value not in EQUAL_TERMS:
        known = " or ".join(f'"{terms}"' for terms in EQUAL_TERMS)
        hint = nearest(value, EQUAL_TERMS) if isinstance(value, str) else ""
        raise Unreadable(f"{shown(value)} is not a common ground of contact models{hint}; it may be {known}")
    return str(value)


class EqualTerms(Table):
    """How the stiffness of the grid's other laws follows: equal ``same`` in an impact at ``speed``.

    Of the laws of the other family; with ``every_law`` of all but the scene's own, since equal β do not make equal
    blows either.
    """

    same: Annotated[
        str,
        Key(
            "What the reference impact has in common under all laws.",
            _same,
            f'"{EQUAL_TERMS[0]}"',
            REQUIRED,
            f'missing; write same = "{EQUAL_TERMS[0]}"',
            schema={"enum": list(EQUAL_TERMS)},
        ),
    ]
    speed: Annotated[
        float,
        measured(
            SPEED, "Approach speed of the reference impact.", '"0.5 m/s"', REQUIRED, 'missing; write speed = "0.5 m/s"'
        ),
    ]
    every_law: Annotated[bool, flag("every_law", "true calibrates laws of the same unit too.")] = False


def _equal_terms(value: Any, number: Number) -> EqualTerms:
    if isinstance(value, EqualTerms):
        return value
    if not isinstance(value, dict):
        raise Unreadable(f'{shown(value)} is not a table; write {{same = "{EQUAL_TERMS[0]}", speed = "0.5 m/s"}}')
    keys = EqualTerms.keys()
    kinds = {name: lambda item, key=key: key.read(item, number) for name, key in keys.items()}
    values = options(value, kinds, (), "", f"equal_terms takes {', '.join(kinds)}")
    missing: list[tuple[KeyPath, str]] = [
        ((name,), keys[name].missing) for name in EqualTerms.required() if name not in value
    ]
    if missing:
        raise Several(missing)
    return EqualTerms.made(values)


class Interface(Table):
    """What stands between two neighbours: a gap, and what happens when it closes.

    A contact law of `pounding_risk.laws` may be given as ``law``, in place of contact model, stiffness and parameters.
    """

    gap: Annotated[
        float | None,
        measured(
            GAP,
            "Clear distance between the buildings at rest; one [[interface]] between each two neighbours of a row.",
            '"25 mm"',
            "the first of grid.gap",
            'missing; write gap = "25 mm"',
        ),
    ] = None
    contact_model: Annotated[str | None, LAW_NAME] = None
    # Its unit depends on the contact model; some models take none.
    stiffness: Annotated[
        Any,
        Key(
            "Stiffness of the contact, k in N/m or β in N/m^1.5 as the contact model has it.",
            lambda value, number: value,
            '"4.2e7 kN/m^1.5"',
            "required, unless no contact model takes one",
            'missing; write stiffness = "4.2e7 kN/m^1.5" (in N/m for the linear laws)',
            schema={"type": "string"},
        ),
    ] = None
    restitution: Annotated[
        GivenRestitution,
        Key(
            'Coefficient of restitution e, a named relation e(v), or {value = 0.65, relation = "exact"}, where damping '
            "follows from e by the exact relation instead of the published one. A damping ratio ξ of a law, as papers "
            'give it, is written "xi 0.35 of jankowski": e follows from the published relation.',
            _restitution,
            '"concrete"',
            "required by models that damp or rebound by it",
            write=lambda given: given.written(),
            schema={"anyOf": [{"type": ["number", "string", "object"]}, {"enum": list(NAMED)}]},
        ),
    ] = GivenRestitution(constant(1.0), NO_RESTITUTION)
    yield_force: Annotated[
        float, measured(YIELD_FORCE, "Force F_E at which the contact yields; inf never yields.", '"450 kN"', '"inf"')
    ] = inf
    column_yield_force: Annotated[
        float,
        measured(
            YIELD_FORCE,
            "Force at which a column that is hit part-way up yields: its shear strength.",
            '"200 kN"',
            '"inf"',
        ),
    ] = inf
    contact: Annotated[
        tuple[tuple[float, float], ...],
        Key(
            "Where the two meet, instead of where their levels say: storey 2 is the floor on top of it, "
            "column 3 at 0.5 half-way up storey 3.",
            _contact_points,
            '[{left = "storey 2", right = "storey 2"}, {left = "storey 3", right = "column 3 at 0.5"}]',
            "every floor below the lower roof meets the other's floor at its level, or its column",
            write=lambda points: [{"left": floor_words(one), "right": floor_words(other)} for one, other in points],
            schema={"type": "array", "items": {"type": "object", "required": ["left", "right"]}},
        ),
    ] = ()
    tolerance: Annotated[
        float | None,
        measured(
            LEVELS,
            "How far apart the levels of floors may be that meet floor to floor, in place of the floors' depth.",
            '"0.1 m"',
            "floors meet where they overlap in height, by floor_depth",
        ),
    ] = None
    plastic_exponent: Annotated[
        float, measured(EXPONENT, "Exponent n of the plastic branch, for van_mier.", "0.5", "0, ideally plastic")
    ] = 0.0
    design_penetration: Annotated[
        float,
        measured(
            DESIGN_PENETRATION,
            "Penetration for which bilinear is set up.",
            '"10 mm"',
            "the Hertz spring's at each approach speed",
        ),
    ] = 0.0
    equal_terms: Annotated[
        EqualTerms | None,
        Key(
            "Calibrates the grid's other laws to this one: what a reference impact has in common, at which approach "
            "speed, and with every_law = true for laws of the same unit too.",
            _equal_terms,
            '{same = "peak force", speed = "0.5 m/s"}',
            "one stiffness for laws of one unit",
            write=lambda terms: terms.written(),
            schema={"$ref": "#/$defs/EqualTermsTable"},
        ),
    ] = None

    def __init__(self, *values: Any, law: Any = None, **keys: Any):
        of_law = {} if law is None else _keys_of_law(law)
        if twice := [name for name in of_law if name in keys]:
            raise SceneError("Interface", [f"{name}: law gives it already; remove one" for name in twice])
        super().__init__(*values, **of_law, **keys)

    def written(self) -> dict[str, Any]:
        """As a scene file has it; a stiffness in SI has the unit of its contact model."""
        return with_stiffness_unit(super().written())


def with_stiffness_unit(table: dict[str, Any]) -> dict[str, Any]:
    """An [[interface]] table whose stiffness has the unit of its contact model, where it is a number in SI.

    Raises SceneError for a number where the table names no contact model.
    """
    stiffness, name = table.get("stiffness"), table.get("contact_model")
    if not isinstance(stiffness, float | int) or isinstance(stiffness, bool):
        return table
    if name is None:
        raise SceneError("Interface", ["stiffness: a number without a unit; write contact_model too"])
    # For a model that takes none or is not there the unit does not count: the checks of the scene tell it.
    law = LAWS.get(name, LAWS["hertz"])
    return table | {"stiffness": exact(float(stiffness), stiffness_quantity(law))}


def _keys_of_law(law: Any) -> dict[str, Any]:
    """The keys that a contact law stands for."""
    kind = type(law)
    values: dict[str, Any] = law._asdict() if isinstance(law, tuple) and hasattr(law, "_asdict") else {}
    if name_of(kind) not in CONTACT_MODELS:
        raise SceneError("Interface", [f"law: {shown(law)} is not a contact law; it may be one of pounding_risk.laws"])
    return {"contact_model": name_of(kind), **{key: value for key, value in values.items() if key in _OF_LAWS}}


_OF_LAWS = ("stiffness", *PARAMETERS)


# ------------------------------------------------------------------------------------------------ checks


def is_row(draft: Draft) -> bool:
    """True for the tables of a row, false for those of a pair, whatever is wrong with either."""
    buildings = draft.tables("building")
    return (
        len(buildings) > 2
        or any(keys.kind in (ShearBuilding, TypologyBuilding) or "floor_depth" in keys for keys in buildings)
        or any(key in keys for keys in draft.tables("interface") for key in OF_POINTS)
        or any(name in EFFECTS and acts_on_buildings(name) for name in draft.table("effects").raw)
        or (len(buildings) == 2 and _heights_differ(buildings))
    )


def _heights_differ(buildings: Sequence[Section]) -> bool:
    """True for two masses, or a mass and a wall, that meet part-way up one of the masses."""
    masses = []
    for keys in buildings:
        height = keys.get("height", None if "height" in keys else 0.0)
        if height is None:
            return False
        masses.append(Building("", 1.0, 0.0 if keys.kind is RigidWall else 1.0, 0.0, height=height))
    points = automatic_points(masses[0], masses[1])
    met = [(mass, floor) for point in points for mass, floor in zip(masses, point[:2], strict=True)]
    return any(floor != 1.0 and not mass.is_rigid for mass, floor in met)


def interface_checks(draft: Draft) -> Iterator[Fault]:
    """All faults that more than one key of the interfaces takes part in."""
    yield from _count(draft)
    yield from _gridded(draft)
    yield from _per_interface(draft)
    if is_row(draft):
        yield from _instant(draft)
    interfaces = draft.tables("interface")[: most_interfaces(draft)]
    first = next((keys.raw["contact_model"] for keys in interfaces if "contact_model" in keys), None)
    for keys in interfaces:
        if "gap" not in keys and _lacks_gap(draft, int(keys.path[1])):
            yield keys.fault("gap", Interface.keys()["gap"].missing, absent=True)
        if first is None and "contact_model" not in draft.table("grid") and keys is interfaces[0]:
            names = ", ".join(CONTACT_MODELS)
            sentence = f'missing; write contact_model = "jankowski", or another of {names}'
            yield keys.fault("contact_model", sentence, absent=True)
        own = keys.raw.get("contact_model", first)
        refused = isinstance(own, str) and own in INSTANT_LAWS and is_row(draft)  # which says what to choose instead
        yield from _laws(keys, draft.table("grid"), None if refused else own)


def _per_interface(draft: Draft) -> Iterator[Fault]:
    """Options of effects that are lists have one value for each interface."""
    count = most_interfaces(draft)
    several = f", or {count}, one between each two neighbours from left to right" if count > 1 else ""
    for name, given in draft.table("effects").raw.items():
        kinds = EFFECTS[name].options if name in EFFECTS and isinstance(given, dict) else {}
        for key in (key for key, allowed in kinds.items() if isinstance(allowed, PerInterface)):
            value = given.get(key)
            if isinstance(value, list) and len(value) not in (0, count):
                told = f"a list of {len(value)} for {counted(count, 'interface')}: write one value for all{several}"
                yield Fault(("effects", name, key), told)


def _count(draft: Draft) -> Iterator[Fault]:
    """One interface for all neighbours, or one between each two of them."""
    count, buildings = draft.count("interface", -1), draft.count("building", -1)
    if min(count, buildings) < 0 or count in (1, most_interfaces(draft)):
        return
    if buildings <= 2:
        repair = (
            f"there is one between two neighbours; {'remove ' + str(count - 1) if count else 'write one [[interface]]'}"
        )
    else:
        repair = f"write {buildings - 1}, one between each two neighbours from left to right, or one for all of them"
    yield Fault(
        ("interface", count - 1) if count else ("interface",), f"{count} interfaces for {buildings} buildings: {repair}"
    )


def most_interfaces(draft: Draft) -> int:
    """One fewer than there are buildings, one at least: more are not looked into."""
    return max(draft.count("building", 0) - 1, 1)


def _gridded(draft: Draft) -> Iterator[Fault]:
    """The interface whose gap alone the grid varies: it is there, and so are its gaps."""
    grid = draft.table("grid")
    named = grid.raw.get("interface")
    if not isinstance(named, str):
        return
    known = _names(draft)
    if named not in known:
        yield grid.fault(
            "interface",
            f"{shown(named)} is not an interface{nearest(named, known)}; it may be {', '.join(map(shown, known))}",
        )
    if "gap" not in grid:
        yield grid.fault(
            "interface", 'names the interface whose gap varies; write gap = ["25 mm", "50 mm"] in [grid] too'
        )


def interface_name(left: str, right: str) -> str:
    """How the interface between two buildings is called."""
    return f"{left} | {right}"


def _names(draft: Draft) -> list[str]:
    """The interfaces' names, left to right."""
    names = [str(keys.raw.get("name", "")) for keys in draft.tables("building")]
    return [interface_name(left, right) for left, right in pairwise(names)]


def _lacks_gap(draft: Draft, index: int) -> bool:
    """True for an interface whose gap neither it nor the grid tells."""
    grid, names = draft.table("grid"), _names(draft)
    if "gap" not in grid or grid.raw.get("interface") not in names:
        return "gap" not in grid
    mine = names if len(draft.tables("interface")) == 1 else names[index : index + 1]
    return mine != [grid.raw["interface"]]


def _instant(draft: Draft) -> Iterator[Fault]:
    """Contact models whose velocities jump, which only the pair knows."""
    gridded = draft.table("grid").raw.get("contact_model")
    named: list[tuple[KeyPath, Any]] = [
        *(((*keys.path, "contact_model"), keys.raw.get("contact_model")) for keys in draft.tables("interface")),
        *((("grid", "contact_model", place), name) for place, name in enumerate(_as_list(gridded))),
    ]
    for path, name in named:
        if isinstance(name, str) and name in INSTANT_LAWS:
            why = "of floors that touch at one instant, momentum and e leave the velocities open (Halm and Posa 2021)"
            yield Fault(path, f"{name} is for a pair of single masses: {why}; in a row choose among {', '.join(LAWS)}")


def _as_list(value: object) -> list[Any]:
    return value if isinstance(value, list) else []


def known_models(names: Iterable[object]) -> list[str]:
    """Those of these that are names of contact models, each once."""
    return list(dict.fromkeys(name for name in names if isinstance(name, str) and name in CONTACT_MODELS))


def _laws(keys: Section, grid: Section, own_name: Any) -> Iterator[Fault]:
    """What the contact models of an interface, its own one by name first, ask of its other keys."""
    asked = _as_list(grid.raw.get("contact_model"))
    gridded = known_models(asked)
    used = known_models([own_name] if own_name is not None else gridded[:1])
    used = list(dict.fromkeys([*used, *gridded]))
    stiff = [name for name in used if not is_instant(CONTACT_MODELS[name])]
    own = stiff[0] if stiff else None  # whose unit the interface's stiffness has
    if "stiffness" not in keys and (stiff or not used):
        yield keys.fault("stiffness", Interface.keys()["stiffness"].missing, absent=True)
    damped = [name for name in used if CONTACT_MODELS[name].needs_restitution]  # type: ignore[attr-defined]
    if damped and "restitution" not in keys:
        sentence = f"missing, and {damped[0]} needs it; {_MISSING_RESTITUTION}"
        yield keys.fault("restitution", sentence, absent=True)
    yield from _relation(keys, used)
    for key, law in (("plastic_exponent", "van_mier"), ("design_penetration", "bilinear")):
        if key in keys and used and law not in used:
            yield keys.fault(key, f"only {law} has one, not {', '.join(used)}; remove it")
    if "stiffness" in keys and used and not stiff:
        yield keys.fault("stiffness", f"{', '.join(used)}: the velocities jump, and no stiffness acts; remove it")
    elif "stiffness" in keys:
        yield from _stiffness(keys, own)
    if not own:
        return
    for position, name in enumerate(asked):
        if name in stiff and _unit(name) != _unit(own) and "equal_terms" not in keys:
            yield Fault(
                ("grid", "contact_model", position),
                f"{name} takes a stiffness in {_unit(name)}, but the interface gives one in {_unit(own)} for "
                f'{own}; write equal_terms = {{same = "{EQUAL_TERMS[0]}", speed = "0.5 m/s"}} in '
                "[[interface]], from which its stiffness follows",
            )


def _relation(keys: Section, used: Sequence[str]) -> Iterator[Fault]:
    """A relation that these contact models do not have, or under which they cannot return e."""
    written = keys.raw.get("restitution")
    relation = written.get("relation") if isinstance(written, dict) else AS_PUBLISHED
    wrong = misfit((CONTACT_MODELS[name] for name in used), relation) if relation in RELATIONS else ""
    if wrong:
        yield Fault((*keys.path, "restitution", "relation"), wrong)
    elif relation == AS_ASKED and (given := keys.get("restitution")):
        fixed = 1.0 if "design_penetration" in keys else 0.0
        for name in used:
            if beyond := out_of_reach(related(CONTACT_MODELS[name], AS_ASKED), least_of(given.rule), fixed):
                yield keys.fault("restitution", beyond)


def _stiffness(keys: Section, law: str | None) -> Iterator[Fault]:
    """A stiffness that is none, or of the other family than its law."""
    stiffness = keys.raw["stiffness"]
    fitting = [name for name in LAWS if _fits(stiffness, name)]
    if law in fitting or (law is None and fitting):
        return
    try:
        parse(stiffness, stiffness_quantity(LAWS[law or "jankowski"]))
    except QuantityError as error:
        others = (
            f" for {law}, or choose a contact model in {_unit(fitting[0])}: {', '.join(fitting)}" if fitting else ""
        )
        yield keys.fault("stiffness", f"{error}{others}")


def _fits(stiffness: object, law: str) -> bool:
    try:
        parse(stiffness, stiffness_quantity(LAWS[law]))
    except QuantityError:
        return False
    return True


def _unit(law: str) -> str:
    return stiffness_quantity(LAWS[law]).unit


# ------------------------------------------------------------------------------------------------ contact points


class Beside(NamedTuple):
    """Two neighbours with their tables: the left one's place in the row, from 0, and what stands between them."""

    place: int
    sides: tuple[Building | Storeys, Building | Storeys]
    depths: tuple[float | None, float | None]  # of their floors, as given [m]
    table: Interface
    base: KeyPath  # where the table stands

    @property
    def rule(self) -> LevelRule:
        """When two of their floors are one contact point."""
        left, right = (
            usual_depth(side) if depth is None else depth for side, depth in zip(self.sides, self.depths, strict=True)
        )
        return LevelRule(left, right, self.table.tolerance)


def contact_points(here: Beside) -> tuple[tuple[Point, ...], list[Fault]]:
    """The contact points of two neighbours, and what is wrong with them."""
    table, sides, rule = here.table, here.sides, here.rule
    if table.contact:
        wrong = [
            Fault((*here.base, "contact"), sentence)
            for floors in table.contact
            if (sentence := _misplaced(sides, floors, rule))
        ]
        points = [] if wrong else [given_point(*sides, *floors) for floors in table.contact]
        return _numbered(here.place, points), wrong
    if wrong := _too_deep(here):
        return (), wrong
    return _numbered(here.place, automatic_points(*sides, rule.is_one)), []


def _too_deep(here: Beside) -> list[Fault]:
    """A tolerance, or depths of floors, by which a floor could meet two floors of the other building."""
    lowest = min((height for side in here.sides if isinstance(side, Storeys) for height in side.heights), default=inf)
    rule = here.rule
    told = f"is not below half of the lowest storey here, {say(lowest, STOREY_HEIGHT)}, so that a floor could meet two"
    if rule.tolerance is not None:
        if rule.tolerance < 0.5 * lowest:
            return []
        repair = "write a smaller one, or the points themselves in contact"
        return [Fault((*here.base, "tolerance"), f"{say(rule.tolerance, STOREY_HEIGHT)} {told}; {repair}")]
    wrong = []
    for side, depth in enumerate((rule.left_depth, rule.right_depth)):
        if depth >= 0.5 * lowest:
            usual = "" if here.depths[side] is not None else "missing, and the usual "
            repair = "write the depth of the floor slabs, or the points themselves in contact"
            path = ("building", here.place + side, "floor_depth")
            wrong.append(Fault(path, f"{usual}{say(depth, STOREY_HEIGHT)} {told}; {repair}", absent=bool(usual)))
    return wrong


def _numbered(place: int, meetings: Sequence[Meeting]) -> tuple[Point, ...]:
    return tuple(Point(place, *meeting) for meeting in meetings)


def _misplaced(sides: tuple[Any, Any], floors: tuple[float, float], rule: LevelRule) -> str:
    """What is wrong with a contact point that the scene gives; "" where nothing is."""
    words = [f"{floor_words(floor)} of {side.name}" for side, floor in zip(sides, floors, strict=True)]
    for side, floor, told in zip(sides, floors, words, strict=True):
        count = len(side.masses) if isinstance(side, Storeys) else 1
        if floor > count:
            return f"{told}: {side.name} has {count} storey{'s' * (count != 1)}; write one of these"
    if not any(floor == int(floor) or side.is_rigid for side, floor in zip(sides, floors, strict=True)):
        return f"{words[0]} against {words[1]}: a column meets a floor; write storey in place of one of them"
    apart, limit = level_gap(*sides, *floors), rule.largest
    if apart > limit:
        key = "floor_depth" if rule.tolerance is None else "tolerance"
        what = "the depth of a floor here," if rule.tolerance is None else "the tolerance of"
        return (
            f"{words[0]} and {words[1]} are {say(apart, STOREY_HEIGHT)} apart in level, more than {what} "
            f"{say(limit, STOREY_HEIGHT)}; correct the place, or write a larger {key}"
        )
    return ""


class ResolvedInterface(NamedTuple):
    """What stands between two neighbours, every value stated."""

    gap: float  # m
    law_name: str  # name of its contact model
    stiffness: float | None  # N/m or N/m^1.5, as the first contact model that takes one has it
    restitution: Restitution
    restitution_words: str
    yield_force: float  # N, of floors; inf without yielding
    column_yield_force: float  # N, of columns that are hit part-way up; inf without yielding
    points: tuple[Point, ...]  # from the ground up
    levels: LevelRule = LevelRule()  # when two floors are one contact point
    given: bool = False  # whether the scene gives the points; else they follow from the heights
    relation: str = AS_PUBLISHED  # of restitution and damping
    plastic_exponent: float = 0.0  # of van_mier
    design_penetration: float = 0.0  # of bilinear [m]; 0 follows the approach speed
    equal_terms: EqualTerms | None = None


def stiff_model(own: str, gridded: Iterable[str]) -> str | None:
    """The first of these contact models that takes a stiffness, or None: instant ones take none."""
    return next((name for name in (own, *gridded) if not is_instant(CONTACT_MODELS[name])), None)


def resolved_interface(
    here: Beside, law_name: str, gridded: Iterable[str], gap: float, yield_force: float
) -> ResolvedInterface:
    """What stands between two neighbours whose tables have no fault, but for the points."""
    table = here.table
    owner = stiff_model(law_name, gridded)
    stiffness = None if owner is None else parse(table.stiffness, stiffness_quantity(CONTACT_MODELS[owner]))
    return ResolvedInterface(
        gap=gap,
        law_name=law_name,
        stiffness=stiffness,
        restitution=table.restitution.rule,
        restitution_words=table.restitution.words,
        yield_force=yield_force,
        column_yield_force=table.column_yield_force,
        points=(),
        levels=here.rule,
        given=bool(table.contact),
        relation=table.restitution.relation,
        plastic_exponent=table.plastic_exponent,
        design_penetration=table.design_penetration,
        equal_terms=table.equal_terms,
    )


def interface_table(between: ResolvedInterface, gridded: Sequence[str]) -> Interface:
    """The table of an interface, every value stated; keys that make a row only where they were given."""
    models = (between.law_name, *gridded)
    owner = stiff_model(between.law_name, gridded)
    values: dict[str, Any] = {"gap": between.gap, "contact_model": between.law_name}
    if between.stiffness is not None and owner is not None:
        values["stiffness"] = exact(float(between.stiffness), stiffness_quantity(CONTACT_MODELS[owner]))
    if between.restitution_words != NO_RESTITUTION:
        values["restitution"] = GivenRestitution(between.restitution, between.restitution_words, between.relation)
    values["yield_force"] = between.yield_force
    if "van_mier" in models:
        values["plastic_exponent"] = between.plastic_exponent
    if "bilinear" in models:
        values["design_penetration"] = between.design_penetration
    if between.equal_terms:
        values["equal_terms"] = between.equal_terms
    if between.column_yield_force < inf:
        values["column_yield_force"] = between.column_yield_force
    if between.levels.tolerance is not None:
        values["tolerance"] = between.levels.tolerance
    if between.given:
        values["contact"] = tuple((point.left_floor, point.right_floor) for point in between.points)
    return Interface.made(values)


def needed_restitution(name: str) -> str:
    """A sentence for a contact model that needs a restitution, in a scene that gives none."""
    return f"{name} needs a restitution, and the scene gives none; {_MISSING_RESTITUTION}, in [[interface]]"
