"""From [[interface]] tables to what stands between neighbours: what makes a row, checks, and every value stated.

Two single masses that meet mass to mass are run by the pair's solver, everything else by that of rows: more than two
buildings, storeys, heights that differ, contact points of the scene's own, and effects that act on buildings.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from math import inf
from typing import Any, NamedTuple

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
from pounding_risk.models.structures.contact_points import (
    COLUMN,
    LevelRule,
    Point,
    automatic_points,
    floor_words,
    given_point,
    level_gap,
    usual_depth,
)
from pounding_risk.models.structures.links import LEAST_SLIP, Link
from pounding_risk.models.structures.plan import Plan
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.scene.building_keys import AnyBuilding
from pounding_risk.scene.buildings import RigidWall
from pounding_risk.scene.interfaces import (
    EQUAL_TERMS_EXAMPLE,
    MISSING_RESTITUTION,
    NO_RESTITUTION,
    OF_ONE_LAW,
    PARAMETERS,
    Interface,
    interface_name,
    known_models,
)
from pounding_risk.scene.keys import Draft, Section
from pounding_risk.scene.tables import Grid
from pounding_risk.scene.toml import Fault, KeyPath, as_list
from pounding_risk.units import STIFFNESS, STOREY_HEIGHT, QuantityError, exact, parse, repair, say, shown

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


# ------------------------------------------------------------------------------------------------ every value stated
ALWAYS_WRITTEN = {"gap", "contact_model", "yield_force", *OF_ONE_LAW}  # whatever the value, of a law that is run


class ResolvedInterface(Interface):
    """What stands between two neighbours: the keys of its table with every value stated, in SI, and where they meet.

    ``stiffness`` is a number [N/m or N/m^1.5], as the first contact model that takes one has it; None where none does.
    """

    points: tuple[Point, ...] = ()  # from the ground up
    levels: LevelRule = LevelRule()  # when two floors are one contact point
    links: tuple[Link, ...] = ()

    def as_written(self, gridded: Sequence[str]) -> dict[str, Any]:
        """The [[interface]] table, every value stated; ``gridded`` are the contact models of the grid."""
        models = (self.contact_model, *gridded)
        left_out = {key for key, law in OF_ONE_LAW.items() if law not in models}
        if self.restitution.words == NO_RESTITUTION:
            left_out.add("restitution")
        settings: dict[str, Any] = {
            key: setting
            for key in self.keys().keys() - left_out
            if (setting := getattr(self, key)) != type(self).model_fields[key].default
            or key in ALWAYS_WRITTEN
            or (key in OF_LINKS and self.links)
        }
        owner = stiff_model(str(self.contact_model), gridded)
        # A stiffness that is its table's own would stay when another table is given, were it written down.
        is_of_table = owner == TABULATED and self.table is not None and self.stiffness == self.table.stiffness
        if settings.pop("stiffness", None) is not None and owner is not None and not is_of_table:
            settings["stiffness"] = exact(float(self.stiffness), stiffness_quantity(CONTACT_MODELS[owner]))
        table: Interface = Interface.from_values(settings)
        return table.written()


def stiff_model(own: str, gridded: Iterable[str]) -> str | None:
    """The first of these contact models that takes a stiffness, or None: instant ones take none."""
    return next((name for name in (own, *gridded) if not is_instant(CONTACT_MODELS[name])), None)


def resolved_interfaces(
    draft: Draft, buildings: Sequence[Building | Storeys], grid: Grid, row: bool
) -> tuple[tuple[ResolvedInterface, ...], list[Fault]]:
    """What stands between each two buildings, from tables without a fault; one table is for all where there is one."""
    interfaces, faults = [], []
    tables = draft.tables("interface")
    # What one interface does not say of its contact is that of the first which does.
    inherited = ("contact_model", *PARAMETERS, "equal_terms")
    shared = {key: keys.get(key) for key in inherited for keys in tables[::-1] if key in keys}
    # In a row, a grid of one yield force is that of all interfaces.
    shared_force = {"yield_force": grid.yield_force[0]} if row and len(grid.yield_force) == 1 else {}
    depths = [keys.get("floor_depth") for keys in draft.tables("building")]
    stands_apart = len({repr(side.support) for side in buildings}) > 1 or "wave_passage" in draft.table("effects").raw
    has_bumper = "bumper_length" in varied(draft) or any("bumper_length" in keys for keys in tables)
    for place, sides in enumerate(pairwise(buildings)):
        keys = tables[min(place, len(tables) - 1)]
        table = Interface.from_values(shared | dict(keys.values) | shared_force)
        # What its table does not say of the contact is the first of the grid.
        contact_model = table.contact_model or grid.contact_model[0]
        owner = stiff_model(contact_model, grid.contact_model)
        stiffness = None
        if owner == TABULATED and table.stiffness is None:
            stiffness = table.table.stiffness
        elif owner is not None:
            stiffness = parse(table.stiffness, stiffness_quantity(CONTACT_MODELS[owner]))
        here = Beside(place, sides, (depths[place], depths[place + 1]), table, keys.path)
        points, wrong = _contact_points(here)
        wrong += _wrong_links(here, stands_apart=stands_apart)
        faults += wrong
        values = {key: getattr(table, key) for key in Interface.key_names()} | {
            "gap": grid.gap[0] if table.gap is None else table.gap,
            # As an axis has it, so that all scenes of the axis have one.
            "bumper_length": 0.0 if table.bumper_length is None and has_bumper else table.bumper_length,
            "contact_model": contact_model,
            "stiffness": stiffness,
            "points": points,
            "links": _links(here, points) if not wrong and OF_LINKS & {*keys.raw, *varied(draft)} else (),
            "levels": here.rule,
        }
        interfaces.append(ResolvedInterface.from_values(values))
    return tuple(interfaces), faults


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


def _contact_points(here: Beside) -> tuple[tuple[Point, ...], list[Fault]]:
    """The contact points of two neighbours, and what is wrong with them."""
    table, sides, rule = here.table, here.sides, here.rule
    if table.contact:
        wrong = [
            Fault((*here.base, "contact"), sentence)
            for floors in table.contact
            if (sentence := _misplaced(sides, floors, rule))
        ]
        meetings = [] if wrong else [given_point(*sides, *floors) for floors in table.contact]
    else:
        wrong = _too_deep(here)
        meetings = [] if wrong else automatic_points(*sides, rule.is_one)
    points = [Point(here.place, *meeting) for meeting in meetings]
    if not wrong and any(_plans_of(side) for side in sides):
        points, wrong = _at_both_ends(here, points)
    return tuple(points), wrong


def _plans_of(side: Building | Storeys) -> tuple[Plan, ...]:
    return side.plans if isinstance(side, Storeys) else ()


def _at_both_ends(here: Beside, points: Sequence[Point]) -> tuple[list[Point], list[Fault]]:
    """Contact points of floors that rotate: at both ends of what the faces of two floors share, where they do."""
    left, right = (side.name for side in here.sides)
    if any(point.kind == COLUMN for point in points):
        words = (
            f"floors that rotate meet floors, and here of {left} and {right} one meets a column; write contact with "
            "the floors that meet, or a floor_depth or tolerance by which their levels are one"
        )
        return [], [Fault((*here.base, "contact"), words)]
    shared = [point._replace(across=across) for point in points for across in _shared_ends(here.sides, point)]
    apart = [point for point in points if not _shared_ends(here.sides, point)]
    if apart and (here.table.contact or not shared):
        words = f"the faces of {left} and {right} do not meet"
        if shared:
            words += f" at {floor_words(apart[0].left_floor)} of {left}; remove it from contact, or correct plan:"
        else:
            words += ";"
        return [], [Fault(("building", here.place, "plan"), f"{words} their ends are in one coordinate across the row")]
    return shared, []


def _shared_ends(sides: tuple[Any, Any], point: Point) -> tuple[float, ...]:
    """Both ends of what the faces of the floors at a contact point share [m]; none where they share nothing."""
    floors = zip(sides, (point.left_floor, point.right_floor), strict=True)
    faces = [plans[int(floor) - 1].face for side, floor in floors if (plans := _plans_of(side))]
    low, high = max(face[0] for face in faces), min(face[1] for face in faces)  # without a plan one is as long
    return (low, high) if low < high else ()


def _links(here: Beside, points: Sequence[Point]) -> tuple[Link, ...]:
    """The links of two neighbours: where their table says, or at their highest contact point."""
    table = here.table
    places = table.link_at or ((points[-1].left_floor, points[-1].right_floor),)
    slack = -inf if table.link_slack is None else table.link_slack
    law = table.link_stiffness, table.link_damping, table.link_strength, slack, table.link_breaking_force
    brace = table.link_brace_stiffness or inf
    exponent = table.link_exponent or float(brace < inf)
    return tuple(Link(here.place, *floors, *law, exponent=exponent, brace=brace) for floors in places)


def _wrong_links(here: Beside, *, stands_apart: bool) -> list[Fault]:
    """Links at places that are none, between buildings of a row whose grounds differ, or too stiff to be followed."""
    table = here.table
    key = "link_stiffness" if table.link_stiffness else "link_damping"
    if any(_plans_of(side) for side in here.sides) and (table.link_stiffness or table.link_damping):
        return [Fault((*here.base, key), "links of floors that rotate are not computed; remove it, or plan")]
    if stands_apart and (table.link_stiffness or table.link_damping):
        words = "links are computed where all buildings stand on one ground motion; remove it, or what parts them"
        return [Fault((*here.base, key), words)]
    if table.link_strength < LEAST_SLIP * table.link_stiffness:
        slip, most = table.link_strength / table.link_stiffness, table.link_strength / LEAST_SLIP
        words = (
            f"{say(table.link_stiffness, STIFFNESS)} slips at link_strength after {slip:.2g} m; less than "
            f"{LEAST_SLIP:g} m cannot be followed, and sliding would be lost; write {say(most, STIFFNESS)} or less"
        )
        return [Fault((*here.base, "link_stiffness"), words)]
    return [
        Fault((*here.base, "link_at"), sentence)
        for floors in table.link_at
        if (sentence := _no_such_floor(here.sides, floors))
    ]


def _no_such_floor(sides: tuple[Any, Any], floors: tuple[float, float]) -> str:
    """Words on a place above a building's roof; "" where there is none."""
    for side, floor in zip(sides, floors, strict=True):
        count = len(side.masses) if isinstance(side, Storeys) else 1
        if floor > count:
            return (
                f"{floor_words(floor)} of {side.name}: {side.name} has {count} storey{'s' * (count != 1)}; write one "
                "of these"
            )
    return ""


def _too_deep(here: Beside) -> list[Fault]:
    """A tolerance, or depths of floors, by which a floor could meet two floors of the other building."""
    lowest = min((height for side in here.sides if isinstance(side, Storeys) for height in side.heights), default=inf)
    rule = here.rule
    reason = (
        f"is not below half of the lowest storey here, {say(lowest, STOREY_HEIGHT)}, so that a floor could meet two"
    )
    if rule.tolerance is not None:
        if rule.tolerance < 0.5 * lowest:
            return []
        repair = "write a smaller one, or the points themselves in contact"
        return [Fault((*here.base, "tolerance"), f"{say(rule.tolerance, STOREY_HEIGHT)} {reason}; {repair}")]
    wrong = []
    for side, depth in enumerate((rule.left_depth, rule.right_depth)):
        if depth >= 0.5 * lowest:
            usual = "" if here.depths[side] is not None else "missing, and the usual "
            repair = "write the depth of the floor slabs, or the points themselves in contact"
            path = ("building", here.place + side, "floor_depth")
            wrong.append(Fault(path, f"{usual}{say(depth, STOREY_HEIGHT)} {reason}; {repair}", absent=bool(usual)))
    return wrong


def _misplaced(sides: tuple[Any, Any], floors: tuple[float, float], rule: LevelRule) -> str:
    """What is wrong with a contact point that the scene gives; "" where nothing is."""
    words = [f"{floor_words(floor)} of {side.name}" for side, floor in zip(sides, floors, strict=True)]
    if absent := _no_such_floor(sides, floors):
        return absent
    if not any(floor == int(floor) or side.is_rigid for side, floor in zip(sides, floors, strict=True)):
        return f"{words[0]} against {words[1]}: a column meets a floor; write storey in place of one of them"
    difference, limit = level_gap(*sides, *floors), rule.largest
    if difference > limit:
        key = "floor_depth" if rule.tolerance is None else "tolerance"
        what = "the depth of a floor here," if rule.tolerance is None else "the tolerance of"
        return (
            f"{words[0]} and {words[1]} are {say(difference, STOREY_HEIGHT)} apart in level, more than {what} "
            f"{say(limit, STOREY_HEIGHT)}; correct the place, or write a larger {key}"
        )
    return ""
