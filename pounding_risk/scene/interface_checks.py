"""Checks of the [[interface]] tables of a scene: faults that more than one key takes part in, and what makes a row.

Two single masses that meet mass to mass are run by the pair's solver, everything else by that of rows: more than two
buildings, storeys, heights that differ, contact points of the scene's own, and effects that act on buildings.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

from pounding_risk._common.counted import counted
from pounding_risk._common.words import nearest
from pounding_risk.models.contact.impulsive import CONTACT_MODELS, INSTANT_LAWS, is_instant, only_in_pairs
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
from pounding_risk.models.contact.table import TABULATED
from pounding_risk.models.effects import EFFECTS, PerInterface, acts_on_buildings
from pounding_risk.models.structures.contact_points import automatic_points
from pounding_risk.models.structures.sdof import Building
from pounding_risk.scene.building_keys import AnyBuilding
from pounding_risk.scene.buildings import RigidWall
from pounding_risk.scene.interfaces import (
    EQUAL_TERMS_EXAMPLE,
    MISSING_RESTITUTION,
    OF_ONE_LAW,
    Interface,
    interface_name,
    known_models,
)
from pounding_risk.scene.keys import Draft, Section
from pounding_risk.scene.toml import Fault, KeyPath, as_list
from pounding_risk.units import QuantityError, parse, repair, shown

OF_LINKS = {"link_stiffness", "link_damping"}  # keys by which an interface has links, whatever the values
OF_SPRING = ("link_strength", "link_slack", "link_breaking_force")
OF_DAMPER = ("link_exponent", "link_brace_stiffness")
# Keys that make a row of a pair of masses.
OF_POINTS = {"contact", "tolerance", "bumper_length", "column_yield_force"}
OF_POINTS |= {"link_at", *OF_LINKS, *OF_SPRING, *OF_DAMPER}
ROW_KEYS = {"floor_depth", "displacement_history"}  # of buildings, likewise


def varied(draft: Draft) -> set[Any]:
    """Keys of interfaces that are axes of the grid, or uncertain."""
    return {target[-1] for one in (*draft.axes, *draft.uncertain) for target in one.targets if target[0] == "interface"}


def _has_storeys(keys: Section) -> bool:
    return issubclass(keys.kind, AnyBuilding) and keys.kind.has_storeys


def is_row(draft: Draft) -> bool:
    """True for the tables of a row, false for those of a pair, whatever is wrong with either."""
    buildings = draft.tables("building")
    return (
        len(buildings) > 2
        or any(_has_storeys(keys) or ROW_KEYS & set(keys.raw) for keys in buildings)
        or any(OF_POINTS & set(keys.raw) for keys in draft.tables("interface"))
        or bool(OF_POINTS & varied(draft))
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
    most = max(draft.count("building", 0) - 1, 1)  # more are not looked into
    names = [str(keys.raw.get("name", "")) for keys in draft.tables("building")]
    between = [interface_name(left, right) for left, right in pairwise(names)]
    interfaces, grid = draft.tables("interface")[:most], draft.table("grid")
    yield from _count(draft, most)
    yield from _gridded(grid, between)
    yield from _per_interface(draft, most)
    if is_row(draft):
        yield from _instant(draft)
    models = [*as_list(grid.raw.get("contact_model")), *(keys.raw.get("contact_model") for keys in interfaces)]
    if TABULATED in models and interfaces and not any("table" in keys for keys in interfaces):
        # One fault: interfaces that give no table have that of the first that does.
        sentence = f"missing, and {TABULATED} needs it; {Interface.keys()['table'].lacks('table').partition('; ')[2]}"
        yield interfaces[0].fault("table", sentence, absent=True)
    first = next((keys.raw["contact_model"] for keys in interfaces if "contact_model" in keys), None)
    for keys in interfaces:
        index = int(keys.path[1])
        is_of_grid = "gap" in grid
        if is_of_grid and grid.raw.get("interface") in between:
            is_of_grid = (between if len(interfaces) == 1 else between[index : index + 1]) == [grid.raw["interface"]]
        if "gap" not in keys and not is_of_grid:
            yield keys.fault("gap", Interface.keys()["gap"].lacks("gap"), absent=True)
        if first is None and "contact_model" not in grid and keys is interfaces[0]:
            sentence = f'missing; write contact_model = "jankowski", or another of {", ".join(CONTACT_MODELS)}'
            yield keys.fault("contact_model", sentence, absent=True)
        written_models = keys.raw.get("contact_model", first)
        yield from _link(keys, varied(draft))
        refused = is_row(draft) and _not_in_row(draft, written_models)  # which says what to choose instead
        yield from _laws(keys, grid, None if refused else written_models)


def _link(keys: Section, along: set[Any]) -> Iterator[Fault]:
    """Keys of a link without what they are of, and keys that a link does not have together."""
    stated = {*keys.raw, *along}
    for of_link, needed, sentence in (
        (OF_SPRING, {"link_stiffness"}, 'is of the spring of a link; write link_stiffness = "20 MN/m" beside it'),
        (OF_DAMPER, {"link_damping"}, 'is of the damper of a link; write link_damping = "500 kN s/m" beside it'),
        (("link_at",), OF_LINKS, 'joins nothing; write link_stiffness = "20 MN/m" or link_damping = "2 MN s/m"'),
    ):
        yield from (keys.fault(key, sentence) for key in of_link if key in keys and not needed & stated)
    for key in (key for key in OF_SPRING if key in keys):
        words = f"a link has one law, here that of {key}; remove it, or {key}"
        yield from (keys.fault(damper, words) for damper in OF_DAMPER if damper in keys)
    for key, does in (("link_slack", "is slack"), ("link_breaking_force", "breaks")):
        if key in keys and "link_strength" in keys:
            yield keys.fault(key, f"a link slips or {does}, not both; remove it, or link_strength")
    if "link_breaking_force" in keys and (keys.get("link_damping", 0.0) or "link_damping" in along):
        sentence = "a damper beside the spring would go on after it has broken; remove it, or link_damping"
        yield keys.fault("link_breaking_force", sentence)


def _per_interface(draft: Draft, count: int) -> Iterator[Fault]:
    """Options of effects that are lists have one value for each of so many interfaces."""
    several = f", or {count}, one between each two neighbours from left to right" if count > 1 else ""
    for name, stated in draft.table("effects").raw.items():
        kinds = EFFECTS[name].options if name in EFFECTS and isinstance(stated, dict) else {}
        for key in (key for key, allowed in kinds.items() if isinstance(allowed, PerInterface)):
            value = stated.get(key)
            if isinstance(value, list) and len(value) not in (0, count):
                sentence = f"a list of {len(value)} for {counted(count, 'interface')}: write one value for all{several}"
                yield Fault(("effects", name, key), sentence)


def _count(draft: Draft, most: int) -> Iterator[Fault]:
    """One interface for all neighbours, or one between each two of them."""
    count, buildings = draft.count("interface", -1), draft.count("building", -1)
    if min(count, buildings) < 0 or count in (1, most):
        return
    if buildings <= 2:
        what = f"remove {count - 1}" if count else "write one [[interface]]"
        repair = f"there is one between two neighbours; {what}"
    else:
        repair = f"write {buildings - 1}, one between each two neighbours from left to right, or one for all of them"
    path: KeyPath = ("interface", count - 1) if count else ("interface",)
    yield Fault(path, f"{count} interfaces for {buildings} buildings: {repair}")


def _gridded(grid: Section, known: Sequence[str]) -> Iterator[Fault]:
    """The interface whose gap alone the grid varies: it is there, and so are its gaps."""
    name = grid.raw.get("interface")
    if not isinstance(name, str):
        return
    if name not in known:
        sentence = f"{shown(name)} is not an interface{nearest(name, known)}; it may be {', '.join(map(shown, known))}"
        yield grid.fault("interface", sentence)
    if "gap" not in grid:
        sentence = 'names the interface whose gap varies; write gap = ["25 mm", "50 mm"] in [grid] too'
        yield grid.fault("interface", sentence)


def _instant(draft: Draft) -> Iterator[Fault]:
    """Contact models whose velocities jump, in a row that they are not for."""
    gridded = as_list(draft.table("grid").raw.get("contact_model"))
    of_interfaces: list[tuple[KeyPath, Any]] = [
        ((*keys.path, "contact_model"), keys.raw["contact_model"])
        for keys in draft.tables("interface")
        if "contact_model" in keys
    ]
    of_grid: list[tuple[KeyPath, Any]] = [
        (("grid", "contact_model", place), name) for place, name in enumerate(gridded)
    ]
    for path, name in [*of_interfaces, *of_grid]:
        if why := _not_in_row(draft, name):
            yield Fault(path, f"{why}; choose among {', '.join(LAWS)}")
    kinds = {known in INSTANT_LAWS: (path, known) for path, name in of_interfaces for known in known_models([name])}
    if not gridded and len(kinds) == 2 and not _not_in_row(draft, kinds[True][1]):
        (path, name), other = kinds[True], kinds[False][1]
        why = f"a jump beside a contact of finite force, as {other} has it at another interface, is not computed"
        yield Fault(path, f"{name}: {why}; write models of one kind at all interfaces")


def _not_in_row(draft: Draft, name: object) -> str:
    """Why a contact model whose velocities jump is not for this row; "" for other names, and where it is."""
    if not isinstance(name, str) or name not in INSTANT_LAWS:
        return ""
    if why := only_in_pairs(INSTANT_LAWS[name]):
        return f"{name} is for a pair of single masses: {why}"
    if what := _more_than_masses(draft):
        why = "of floors that are joined and touch at one instant no law of impact is established (Halm and Posa 2021)"
        return f"{name} is for single masses that meet mass to mass, and {what}: {why}"
    return ""


def _more_than_masses(draft: Draft) -> str:
    """What makes a row more than single masses and walls that meet mass to mass; "" where nothing does."""
    buildings = draft.tables("building")
    for keys in buildings:
        if _has_storeys(keys):
            return f"{keys.raw.get('name', 'a building')} has storeys"
    if "soil_flexibility" in draft.table("effects").raw:
        return "soil_flexibility gives each a foundation of its own mass"
    for keys in draft.tables("interface"):
        if keys.get("link_stiffness") or keys.get("link_damping"):
            return "links join neighbours"
        if any(floor != 1.0 for floors in keys.get("contact", None) or () for floor in floors):
            return "contact gives places that are no floor of a mass"
    for pair in pairwise(buildings):
        if _heights_differ(pair):
            left, right = (keys.raw.get("name", "a building") for keys in pair)
            return f"{left} and {right} differ in height, so that one is met part-way up"
    return ""


def _laws(keys: Section, grid: Section, own_name: Any) -> Iterator[Fault]:
    """What the contact models of an interface, its own one by name first, need of its other keys."""
    gridded = as_list(grid.raw.get("contact_model"))
    used = known_models([*([] if own_name is None else [own_name]), *gridded])
    stiff = [name for name in used if not is_instant(CONTACT_MODELS[name])]
    own = stiff[0] if stiff else None  # whose unit the interface's stiffness has
    if "stiffness" not in keys and (stiff or not used) and own != TABULATED:
        yield keys.fault("stiffness", Interface.keys()["stiffness"].lacks("stiffness"), absent=True)
    damped = [name for name in used if CONTACT_MODELS[name].needs_restitution]  # type: ignore[attr-defined]
    if damped and "restitution" not in keys:
        sentence = f"missing, and {damped[0]} needs it; {MISSING_RESTITUTION}"
        yield keys.fault("restitution", sentence, absent=True)
    yield from _relation(keys, used)
    for key, law in OF_ONE_LAW.items():
        if key in keys and used and law not in used:
            yield keys.fault(key, f"only {law} has one, not {', '.join(used)}; remove it")
    if "stiffness" in keys and used and not stiff:
        yield keys.fault("stiffness", f"{', '.join(used)}: the velocities jump, and no stiffness acts; remove it")
    elif "stiffness" in keys:
        yield from _stiffness(keys, own)
    for position, name in enumerate(gridded) if own else ():
        if name in stiff and name != TABULATED and _unit(name) != _unit(str(own)) and "equal_terms" not in keys:
            sentence = (
                f"{name} takes a stiffness in {_unit(name)}, but the interface gives one in {_unit(str(own))} for "
                f"{own}; write equal_terms = {EQUAL_TERMS_EXAMPLE} in [[interface]], from which its stiffness follows"
            )
            yield Fault(("grid", "contact_model", position), sentence)


def _relation(keys: Section, used: Sequence[str]) -> Iterator[Fault]:
    """A relation that these contact models do not have, or under which they cannot return e."""
    written = keys.raw.get("restitution")
    relation = written.get("relation") if isinstance(written, dict) else AS_PUBLISHED
    wrong = misfit((CONTACT_MODELS[name] for name in used), relation) if relation in RELATIONS else ""
    if wrong:
        yield Fault((*keys.path, "restitution", "relation"), wrong)
    elif relation == AS_ASKED and (restitution := keys.get("restitution")):
        fixed = 1.0 if "design_penetration" in keys else 0.0
        for name in used:
            if beyond := out_of_reach(related(CONTACT_MODELS[name], AS_ASKED), least_of(restitution.rule), fixed):
                yield keys.fault("restitution", beyond)


def _stiffness(keys: Section, law: str | None) -> Iterator[Fault]:
    """A stiffness that is none, or of the other family than its law."""
    stiffness = keys.raw["stiffness"]
    if law in LAWS and _fits(stiffness, str(law)):
        return
    fitting = [name for name in LAWS if _fits(stiffness, name)]
    if law is None and fitting:
        return
    quantity = stiffness_quantity(LAWS[law or "jankowski"])
    try:
        parse(stiffness, quantity)
    except QuantityError as error:
        if law == TABULATED:
            wrong = str(error).removesuffix(repair(quantity))
            yield keys.fault("stiffness", f"{wrong}remove it: the forces of the table have their own stiffness")
            return
        fitting = [name for name in fitting if name != TABULATED]  # which has its stiffness from its table
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
