"""The [[interface]] tables of a scene: gap and contact of two neighbours, and where they meet."""

from collections.abc import Iterable, Mapping
from math import inf
from typing import Any, ClassVar, NamedTuple

from pounding_risk import units
from pounding_risk._common.plugins import installed
from pounding_risk._common.words import nearest
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.contact.impulsive import CONTACT_MODELS, INSTANT_LAWS
from pounding_risk.models.contact.laws import LAWS, SHIPPED, stiffness_quantity
from pounding_risk.models.contact.laws.bilinear import DESIGN_PENETRATION
from pounding_risk.models.contact.laws.van_mier import EXPONENT
from pounding_risk.models.contact.relation import AS_PUBLISHED, faults, is_ratio, name_of, written_ratio
from pounding_risk.models.restitution import NAMED, Restitution, constant
from pounding_risk.models.structures.contact_points import floor_number, floor_words
from pounding_risk.scene.force_tables import FORCE_TABLE
from pounding_risk.scene.keys import (
    Key,
    Number,
    Several,
    Table,
    Unreadable,
    each,
    flag,
    inline,
    list_of,
    measured,
    one_of,
    options,
    several,
)
from pounding_risk.scene.not_modelled import LAWS_ELSEWHERE
from pounding_risk.scene.toml import KeyPath
from pounding_risk.units import exact, shown, unknown

EQUAL_TERMS = ("peak force", "penetration")  # in which laws with a k and laws with a β can be made to agree
EQUAL_TERMS_EXAMPLE = '{same = "peak force", speed = "0.5 m/s"}'
NO_RESTITUTION = "not given"
LATER_RESTITUTION = ("steel",)
# Keys that one contact model reads: the fields of the laws of the package, beside stiffness and table.
OF_ONE_LAW = {field: name for name in SHIPPED for field in LAWS[name]._fields if field not in ("stiffness", "table")}
PARAMETERS = (*OF_ONE_LAW, "table")  # of single laws, beside their stiffness
MEETING = '{left = "storey 2", right = "column 3 at 0.5"}'
MISSING_RESTITUTION = 'write restitution = 0.65, or restitution = "concrete"'


def known_law(name: str) -> Any:
    """The class of a contact model; raises PoundingError, with the nearest name, where there is none."""
    if not isinstance(name, str) or name not in CONTACT_MODELS:
        raise PoundingError(unknown_law(name))
    return CONTACT_MODELS[name]


def unknown_law(name: object) -> str:
    """A sentence for a contact model that is not there."""
    return unknown(name, "not a contact model", CONTACT_MODELS, LAWS_ELSEWHERE)


def known_models(names: Iterable[object]) -> list[str]:
    """The names among these that are contact models, each once."""
    return list(dict.fromkeys(name for name in names if isinstance(name, str) and name in CONTACT_MODELS))


def interface_name(left: str, right: str) -> str:
    """How the interface between two buildings is called."""
    return f"{left} | {right}"


def needed_restitution(name: str) -> str:
    """A sentence for a contact model that needs a restitution, in a scene that gives none."""
    return f"{name} needs a restitution, and the scene gives none; {MISSING_RESTITUTION}, in [[interface]]"


# ------------------------------------------------------------------------------------------------ keys


class GivenRestitution(NamedTuple):
    """A coefficient of restitution as a scene gives it."""

    rule: Restitution
    words: str  # the relation's name, the number, the damping ratio and its law, or NO_RESTITUTION
    relation: str = AS_PUBLISHED  # of restitution and damping

    def written(self) -> Any:
        """As a scene file has it."""
        ratio = self.words if self.words in NAMED or is_ratio(self.words) else self.rule.c0
        return ratio if self.relation == AS_PUBLISHED else {"value": ratio, "relation": self.relation}


def said_restitution(words: str) -> str:
    """The words of `GivenRestitution` for a reader: a damping ratio with the e that follows from it."""
    return written_ratio(words)[1] if is_ratio(words) else words


def _restitution(value: Any, number: Number) -> GivenRestitution:
    """e(v), the words for it, and its relation to damping: a value alone, or a table of value and relation."""
    if not isinstance(value, dict):
        return GivenRestitution(*_rule(value, number))
    flaws: list[tuple[KeyPath, str]] = [((key,), sentence) for key, sentence in faults(value)]
    try:
        rule, words = _rule(value.get("value", 1.0), number)  # a value that is missing is among the faults
    except ValueError as error:
        flaws.append((("value",), str(error)))
    if is_ratio(value.get("value")) and value.get("relation", AS_PUBLISHED) != AS_PUBLISHED:
        flaws.append((("relation",), "a damping ratio ξ is that of the published relation; remove relation, or give e"))
    if flaws:
        raise Several(flaws)
    return GivenRestitution(rule, words, value.get("relation", AS_PUBLISHED))


def _rule(value: Any, number: Number) -> tuple[Restitution, str]:
    """A number in (0, 1], the name of a relation e(v) or a damping ratio of a law; with the words for it."""
    if isinstance(value, Restitution):  # a scene file can state one by its name or by its number
        for name, relation in NAMED.items():
            if value == relation:
                return relation, name
        if value != Restitution(value.c0):
            names = ", ".join(NAMED)
            raise Unreadable(f"a relation e(v) of your own has no name in a scene; write e, or one of {names}")
        value = value.c0
    if is_ratio(value):
        e, _ = written_ratio(value)
        return constant(e), " ".join(value.replace("ξ", "xi").replace("=", " ").split())
    if isinstance(value, str) and value[:1].isalpha() and value.lower() not in ("inf", "nan"):
        if value in NAMED:
            return NAMED[value], value
        choices = ", ".join(f'"{name}"' for name in NAMED)
        if value in LATER_RESTITUTION:
            raise Unreadable(f"{shown(value)} is not in this version; write a number such as 0.6, or one of {choices}")
        raise Unreadable(
            f"{shown(value)} is not a named restitution{nearest(value, NAMED)}; "
            f"write a number such as 0.65, or one of {choices}"
        )
    e = number(value, units.RESTITUTION)
    return constant(e), f"{e!r}"


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
    "that of the first interface that has one, else the first of grid.contact_model",
    schema={"enum": lambda: [*SHIPPED, *sorted(installed()["laws"]), *INSTANT_LAWS]},
)


LAW_NAMES = several(
    "contact_model",
    _law_name,
    "Contact models; a dimension of the dataset.",
    '["jankowski", "hertz"]',
    "that of the interface",
)


def _contact_points(value: Any, number: Number) -> tuple[tuple[float, float], ...]:
    """The floor numbers of a scene's own contact points: (left, right) of each, in ascending order."""

    def meeting(point: Any) -> tuple[float, float]:
        if not isinstance(point, dict):
            raise Unreadable(f"{shown(point)} is not a contact point; write {MEETING}")
        sides = {"left": _floor, "right": _floor}
        missing, takes = f"missing; write {MEETING}", "a contact point has left and right"
        floors = options(point, sides, tuple(sides), lambda side: missing, takes)
        return floors["left"], floors["right"]

    return tuple(sorted(each(list_of(value, f"contact = [{MEETING}]"), meeting, distinct=True)))


def _meetings(words: str, example: str, absent: str) -> Key:
    """Places at which two buildings meet, in the words of [[interface]]."""
    return Key(
        words,
        _contact_points,
        example,
        absent,
        write=lambda points: [{"left": floor_words(left), "right": floor_words(right)} for left, right in points],
        schema={"type": "array", "items": {"type": "object", "required": ["left", "right"]}},
    )


def _floor(value: Any) -> float:
    floor = floor_number(value) if isinstance(value, str) else None
    if floor is None:
        raise Unreadable(
            f'{shown(value)} is not a place on a building; write "storey 2" for the floor on top of storey 2, '
            'or "column 3 at 0.5" for half-way up storey 3'
        )
    return floor


class EqualTerms(Table):
    """How the stiffness of the grid's other laws follows: equal ``same`` in an impact at ``speed``.

    It holds for the laws of the other family; with ``every_law`` for all but the scene's own, since equal β do not
    make equal blows either.
    """

    same: str = one_of(
        EQUAL_TERMS,
        "a common ground of contact models",
        "What the reference impact has in common under all laws.",
        f'"{EQUAL_TERMS[0]}"',
    ).required()
    speed: float = measured(units.SPEED, "Approach speed of the reference impact.").required()
    every_law: bool = flag("every_law", "true calibrates laws of the same unit too.").defaults_to(False)


class Interface(Table):
    """What stands between two neighbours: a gap, and what happens when it closes."""

    beside: ClassVar[Mapping[str, str]] = {
        "law": "A contact law of `pounding_risk.laws`, which stands for contact_model, stiffness and its parameters."
    }
    gap: Any = measured(
        units.GAP,
        "Clear distance between the buildings at rest; one [[interface]] between each two neighbours of a row.",
        absent="the first of grid.gap",
    ).defaults_to(None)
    contact_model: Any = LAW_NAME.defaults_to(None)
    # Its unit depends on the contact model; some models take none.
    stiffness: Any = Key(
        "Stiffness of the contact, k in N/m or β in N/m^1.5 as the contact model has it; for tabulated force over "
        "penetration at the table's last point, where another one than the table's own scales its forces.",
        lambda value, number: value,
        '"4.2e7 kN/m^1.5"',
        "required, unless no contact model takes one; for tabulated the table's own",
        'missing; write stiffness = "4.2e7 kN/m^1.5" (in N/m for the linear laws)',
        schema={"type": "string"},
    ).defaults_to(None)
    restitution: GivenRestitution = Key(
        'Coefficient of restitution e, a named relation e(v), or {value = 0.65, relation = "exact"}, where damping '
        "follows from e by the exact relation instead of the published one. A damping ratio ξ of a law, as papers "
        'give it, is written "xi 0.35 of jankowski": e follows from the published relation.',
        _restitution,
        '"concrete"',
        "required by models that damp or rebound by it",
        write=lambda given: given.written(),
        schema={"anyOf": [{"type": ["number", "string", "object"]}, {"enum": list(NAMED)}]},
    ).defaults_to(GivenRestitution(constant(1.0), NO_RESTITUTION))
    yield_force: float = measured(
        units.YIELD_FORCE, "Force F_E at which the contact yields; inf never yields.", absent='"inf"'
    ).defaults_to(inf)
    column_yield_force: float = measured(
        units.YIELD_FORCE,
        "Force at which a column that is hit part-way up yields: its shear strength.",
        '"200 kN"',
        '"inf"',
    ).defaults_to(inf)
    contact: tuple[tuple[float, float], ...] = _meetings(
        "Where the two meet, instead of where their levels say: storey 2 is the floor on top of it, "
        "column 3 at 0.5 half-way up storey 3.",
        '[{left = "storey 2", right = "storey 2"}, {left = "storey 3", right = "column 3 at 0.5"}]',
        "every floor below the lower roof meets the other's floor at its level, or its column",
    ).defaults_to(())
    link_stiffness: float = measured(
        units.LINK_STIFFNESS,
        "Stiffness of a linear link between the two, which pulls and pushes; at each place of link_at.",
        absent="no spring joins them",
    ).defaults_to(0.0)
    link_damping: float = measured(
        units.LINK_DAMPING,
        "Coefficient of a viscous damper between the two, beside the spring of the link.",
        absent="no damper joins them",
    ).defaults_to(0.0)
    link_exponent: float | None = measured(
        units.LINK_EXPONENT,
        "Power of the speed that the force of the damper is: link_damping × 1 m/s × (speed / 1 m/s)^link_exponent, "
        "linear below 1 mm/s.",
        absent="the damper is linear, and its peak force no output",
    ).defaults_to(None)
    link_brace_stiffness: float | None = measured(
        units.LINK_BRACE,
        "Stiffness of the brace that the damper acts on, in series with it; with link_stiffness, which is beside "
        "both, the element of Zener.",
        absent="the damper joins the two by itself",
    ).defaults_to(None)
    link_strength: float = measured(
        units.LINK_STRENGTH,
        "Force at which the spring of the link slips, in both directions: a friction damper on its brace, or one "
        "that yields.",
        absent="the spring is linear",
    ).defaults_to(inf)
    link_slack: float | None = measured(
        units.LINK_SLACK,
        "Stretch past which the spring of the link pulls; then it never pushes: a hook, a cable or a restrainer.",
        absent="the spring pulls and pushes",
    ).defaults_to(None)
    link_breaking_force: float = measured(
        units.LINK_BREAKING_FORCE,
        "Force at which the spring of the link breaks for good, pushed or pulled; with link_slack pulled alone.",
        absent="it never breaks",
    ).defaults_to(inf)
    link_at: tuple[tuple[float, float], ...] = _meetings(
        "Where links join the two, in the words of contact.",
        '[{left = "storey 3", right = "storey 3"}]',
        "their highest contact point",
    ).defaults_to(())
    bumper_length: float | None = measured(
        units.GAP._replace(words="length of a bumper"),
        "Length of the bumpers on one face, or on both together, at every contact point: it takes up part of the "
        "gap, and contact begins where the rest has closed.",
        '"40 mm"',
        "faces meet faces",
    ).defaults_to(None)
    tolerance: float | None = measured(
        units.LEVELS,
        "How far apart the levels of floors may be that meet floor to floor, in place of the floors' depth.",
        absent="floors meet where they overlap in height, by floor_depth",
    ).defaults_to(None)
    plastic_exponent: float = measured(
        EXPONENT,
        "Exponent n of the plastic branch, for van_mier.",
        absent="0, ideally plastic; in a row that of the first interface that has one",
    ).defaults_to(0.0)
    design_penetration: float = measured(
        DESIGN_PENETRATION,
        "Penetration for which bilinear is set up.",
        absent="the Hertz spring's at each approach speed; in a row that of the first interface that has one",
    ).defaults_to(0.0)
    table: Any = FORCE_TABLE.defaults_to(None)
    equal_terms: EqualTerms | None = Key(
        "Calibrates the grid's other laws to this one: what a reference impact has in common, at which approach "
        "speed, and with every_law = true for laws of the same unit too.",
        lambda value, number: inline(EqualTerms, "equal_terms", value, number, EQUAL_TERMS_EXAMPLE),
        EQUAL_TERMS_EXAMPLE,
        "one stiffness for laws of one unit; in a row that of the first interface that has it",
        write=lambda terms: terms.written(),
        schema={"$ref": "#/$defs/EqualTermsTable"},
    ).defaults_to(None)

    def __init__(self, *values: Any, law: Any = None, **keys: Any):
        law_keys = {} if law is None else _keys_of_law(law)
        if repeated_keys := [name for name in law_keys if name in keys]:
            raise SceneError("Interface", [f"{name}: law gives it already; remove one" for name in repeated_keys])
        if keys.get("restitution", self) is None:  # not given, as the signature has it
            del keys["restitution"]
        super().__init__(*values, **law_keys, **keys)

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
    # For a model that takes none or is not there the unit does not count: the checks of the scene report it.
    return table | {"stiffness": exact(float(stiffness), stiffness_quantity(LAWS.get(str(name), LAWS["hertz"])))}


def _keys_of_law(law: Any) -> dict[str, Any]:
    """The keys that a contact law stands for."""
    kind = type(law)
    fields: dict[str, Any] = law._asdict() if isinstance(law, tuple) and hasattr(law, "_asdict") else {}
    if name_of(kind) not in CONTACT_MODELS:
        raise SceneError("Interface", [f"law: {shown(law)} is not a contact law; it may be one of pounding_risk.laws"])
    keyless = fields.keys() - {"stiffness", *PARAMETERS}
    losses = [f"{key} = {fields[key]:g}" for key in sorted(keyless) if fields[key] != kind._field_defaults.get(key)]
    if losses:
        sentence = (
            f"law: {', '.join(losses)} of {kind.__name__} would be lost, as no key of a scene has it; make it the "
            "default of the field, or a law of its own"
        )
        raise SceneError("Interface", [sentence])
    if fields.get("stiffness") == getattr(fields.get("table"), "stiffness", None):
        del fields["stiffness"]  # that of its table
    return {
        "contact_model": name_of(kind),
        **{key: field for key, field in fields.items() if key in ("stiffness", *PARAMETERS)},
    }
