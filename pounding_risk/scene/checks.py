"""What no single key can tell: keys that exclude, need or count each other, and words of later versions.

Every check reads the tables as written and yields its faults, whatever else is wrong with the scene.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pounding_risk.models.contact.impulsive import CONTACT_MODELS, INSTANT_LAWS, is_instant, needs_floors
from pounding_risk.models.contact.laws import LAWS, stiffness_quantity
from pounding_risk.models.contact.relation import (
    AS_ASKED,
    AS_PUBLISHED,
    RELATIONS,
    least_of,
    misfit,
    out_of_reach,
    related,
)
from pounding_risk.models.effects import EFFECTS, refusal
from pounding_risk.models.restitution import NAMED
from pounding_risk.scene.buildings import building_checks
from pounding_risk.scene.interfaces import is_row, lacks_gap, most_interfaces, row_checks
from pounding_risk.scene.scene import EQUAL_TERMS
from pounding_risk.scene.toml import Fault, as_list, table, tables
from pounding_risk.units import QuantityError, parse

# Words that a scene may use one day, by section: each with what this version offers instead.
LATER: Mapping[str, Mapping[str, str]] = {
    "records": {
        "components": 'written as direction = "30 deg", of the row; name both horizontal components in names or files',
    },
    "grid": {
        "scale": "a grid of scale factors is not in this version; write a grid of pga instead",
        "stiffness": "a grid of stiffnesses is not in this version; run one scene for each",
        "restitution": "a grid of restitutions is not in this version; run one scene for each",
    },
}
LATER_RESTITUTION = ("steel",)


def later_words(raw: dict[str, Any]) -> list[Fault]:
    """Take the words of later versions out of the tables; one fault each."""
    faults = []
    for section, words in LATER.items():
        found = tables(raw, section) if isinstance(raw.get(section), list) else [(None, table(raw, section))]
        for index, keys in found:
            base = (section,) if index is None else (section, index)
            for word in [key for key in keys if key in words]:
                del keys[word]
                faults.append(Fault((*base, word), words[word]))
    return faults


def across_keys(raw: Mapping[str, Any]) -> Iterator[Fault]:
    """All faults that more than one key takes part in."""
    yield from building_checks(raw)
    yield from row_checks(raw)
    yield from _interfaces(raw)
    yield from _floors(raw)
    yield from _effects(raw)


def _interfaces(raw: Mapping[str, Any]) -> Iterator[Fault]:
    grid, interfaces = table(raw, "grid"), tables(raw, "interface")[: most_interfaces(raw)]
    named = next((keys["contact_model"] for _, keys in interfaces if "contact_model" in keys), None)
    refused = isinstance(named, str) and named in INSTANT_LAWS and is_row(raw)  # which says what to choose instead
    for index, keys in interfaces:
        base = ("interface", index)
        if "gap" not in keys and lacks_gap(raw, index):
            yield Fault((*base, "gap"), 'missing; write gap = "25 mm"', absent=True)
        if named is None and "contact_model" not in grid and keys is interfaces[0][1]:
            yield Fault(
                (*base, "contact_model"),
                f'missing; write contact_model = "jankowski", or another of {", ".join(CONTACT_MODELS)}',
                absent=True,
            )
        yield from _laws(index, keys, grid, None if refused else named)


def _named(raw: Mapping[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """The first interface, and the contact models that the interfaces and the grid name."""
    keys = next((keys for _, keys in tables(raw, "interface")), {})
    told = [each.get("contact_model") for _, each in tables(raw, "interface")]
    names = [*told, *as_list(table(raw, "grid").get("contact_model"))]
    return keys, list(dict.fromkeys(name for name in names if isinstance(name, str) and name in CONTACT_MODELS))


def _floors(raw: Mapping[str, Any]) -> Iterator[Fault]:
    """Buildings whose floors a contact model collides, without their length."""
    users = [name for name in _named(raw)[1] if needs_floors(CONTACT_MODELS[name])]
    for index, keys in tables(raw, "building") if users else []:
        if keys.get("rigid") is not True and "floor_length" not in keys:
            yield Fault(
                ("building", index, "floor_length"),
                f'missing, and {users[0]} needs it; write floor_length = "20 m", the length of the floor along the row',
                absent=True,
            )


def _effects(raw: Mapping[str, Any]) -> Iterator[Fault]:
    """Effects without what they act on, or with a contact model that they do not act on."""
    asked = {name: options for name, options in table(raw, "effects").items() if name in EFFECTS}
    if not asked:
        return
    keys, laws = _named(raw)
    for name, options in asked.items():
        kind: Any = EFFECTS[name]
        for needed in kind.needs:
            if needed not in asked:
                yield Fault(("effects", name), f"acts on what {needed} leaves; write {needed} = {{}} as well")
        if isinstance(options, dict) and options.get("code") == "mc1990" and "strength" not in options:
            yield Fault(("effects", name), 'code mc1990 asks for the concrete; write strength = "30 MPa" as well')
        for law in laws:
            why = refusal(CONTACT_MODELS[law], name)
            if why:
                takers = ", ".join(other for other in LAWS if not refusal(LAWS[other]))
                yield Fault(
                    ("effects", name),
                    f"{law} {why}; remove {name}, or choose among {takers}",
                )
    exponent = keys.get("plastic_exponent", 0)
    if "permanent_set" in asked and "van_mier" in laws and exponent not in (0, 0.0, "0"):
        yield Fault(
            ("effects", "permanent_set"),
            "van_mier with a plastic_exponent above 0 hardens while it yields, and what it remembers of that is not "
            "published; remove plastic_exponent, or permanent_set",
        )


def _laws(index: int, keys: dict[str, Any], grid: dict[str, Any], own_name: Any) -> Iterator[Fault]:
    """What the contact models of a scene, its own one by name first, ask of an interface's other keys."""
    base = ("interface", index)
    gridded = [name for name in as_list(grid.get("contact_model")) if isinstance(name, str) and name in CONTACT_MODELS]
    named = (gridded[0] if gridded else None) if own_name is None else own_name
    first = named if isinstance(named, str) and named in CONTACT_MODELS else None
    used = dict.fromkeys([*([first] if first else []), *gridded])
    stiff = [name for name in used if not is_instant(CONTACT_MODELS[name])]
    own = stiff[0] if stiff else None  # whose unit the interface's stiffness has
    if "stiffness" not in keys and (stiff or not used):
        yield Fault(
            (*base, "stiffness"),
            'missing; write stiffness = "4.2e7 kN/m^1.5" (in N/m for the linear laws)',
            absent=True,
        )
    damped = [name for name in used if CONTACT_MODELS[name].needs_restitution]  # type: ignore[attr-defined]
    if damped and "restitution" not in keys:
        yield Fault(
            (*base, "restitution"),
            f'missing, and {damped[0]} needs it; write restitution = 0.65, or restitution = "concrete"',
            absent=True,
        )
    given = keys.get("restitution")
    relation = given.get("relation") if isinstance(given, dict) else AS_PUBLISHED
    wrong = misfit((CONTACT_MODELS[name] for name in used), relation) if relation in RELATIONS else ""
    if wrong:
        yield Fault((*base, "restitution", "relation"), wrong)
    elif isinstance(given, dict) and relation == AS_ASKED:
        yield from _reach(base, keys, given.get("value"), used)
    for key, law in (("plastic_exponent", "van_mier"), ("design_penetration", "bilinear")):
        if key in keys and used and law not in used:
            yield Fault((*base, key), f"only {law} has one, not {', '.join(used)}; remove it")
    if "stiffness" in keys and used and not stiff:
        yield Fault((*base, "stiffness"), f"{', '.join(used)}: the velocities jump, and no stiffness acts; remove it")
    elif "stiffness" in keys:
        yield from _stiffness(index, keys["stiffness"], own)
    if not own:
        return
    for position, name in enumerate(as_list(grid.get("contact_model"))):
        if name in stiff and _unit(name) != _unit(own) and "equal_terms" not in keys:
            yield Fault(
                ("grid", "contact_model", position),
                f"{name} takes a stiffness in {_unit(name)}, but the interface gives one in {_unit(own)} for "
                f'{own}; write equal_terms = {{same = "{EQUAL_TERMS[0]}", speed = "0.5 m/s"}} in '
                "[[interface]], from which its stiffness follows",
            )


def _reach(base: tuple[str | int, ...], keys: Mapping[str, Any], value: object, used: Iterable[str]) -> Iterator[Fault]:
    """A restitution that a contact model cannot return under the exact relation, where it is one at all."""
    if isinstance(value, str) and value in NAMED:
        least = least_of(NAMED[value])
    elif isinstance(value, int | float) and 0.0 < value <= 1.0:
        least = float(value)
    else:
        return
    fixed = 1.0 if "design_penetration" in keys else 0.0
    for name in used:
        law = CONTACT_MODELS[name]
        if beyond := out_of_reach(related(law, AS_ASKED), least, fixed):
            yield Fault((*base, "restitution"), beyond)


def _stiffness(index: int, stiffness: object, law: str | None) -> Iterator[Fault]:
    """A stiffness that is none, or of the other family than its law."""
    fitting = [name for name in LAWS if _fits(stiffness, name)]
    if law in fitting or (law is None and fitting):
        return
    try:
        parse(stiffness, stiffness_quantity(LAWS[law or "jankowski"]))
    except QuantityError as error:
        others = (
            f" for {law}, or choose a contact model in {_unit(fitting[0])}: {', '.join(fitting)}" if fitting else ""
        )
        yield Fault(("interface", index, "stiffness"), f"{error}{others}")


def _fits(stiffness: object, law: str) -> bool:
    try:
        parse(stiffness, stiffness_quantity(LAWS[law]))
    except QuantityError:
        return False
    return True


def _unit(law: str) -> str:
    return stiffness_quantity(LAWS[law]).unit
