"""From [[interface]] tables to interfaces with every value stated: what makes a row, and checks.

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


def varied(draft: Draft, table: Section | None = None) -> set[Any]:
    """Keys of interfaces that are axes of the grid, or uncertain; of one ``table`` alone if it is given."""
    targets = (target for item in (*draft.axes, *draft.uncertain) for target in item.targets)
    base = ("interface",) if table is None else tuple(table.path)
    return {target[-1] for target in targets if target[: len(base)] == base}


def _has_storeys(keys: Section) -> bool:
    return issubclass(keys.kind, AnyBuilding) and keys.kind.has_storeys


def is_row(draft: Draft) -> bool:
    """True for the tables of a row, false for those of a pair, even where they have faults."""
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
    mass_floors = [(mass, floor) for point in points for mass, floor in zip(masses, point[:2], strict=True)]
    return any(floor != 1.0 and not mass.is_rigid for mass, floor in mass_floors)


def interface_checks(draft: Draft) -> Iterator[Fault]:
    """All faults that more than one key of the interfaces takes part in."""
    limit = max(draft.count("building", 0) - 1, 1)  # more are not looked into
    names = [str(keys.raw.get("name", "")) for keys in draft.tables("building")]
    labels = [interface_name(left, right) for left, right in pairwise(names)]
    interfaces, grid = draft.tables("interface")[:limit], draft.table("grid")
    yield from _count_faults(draft, limit)
    yield from _grid_interface_faults(grid, labels)
    yield from _option_list_faults(draft, limit)
    if is_row(draft):
        yield from _instant_law_faults(draft)
    models = [*as_list(grid.raw.get("contact_model")), *(keys.raw.get("contact_model") for keys in interfaces)]
    if TABULATED in models and interfaces and not any("table" in keys for keys in interfaces):
        # One fault: interfaces that give no table have that of the first that does.
        sentence = f"missing, and {TABULATED} needs it; {Interface.keys()['table'].lacks('table').partition('; ')[2]}"
        yield interfaces[0].fault("table", sentence, absent=True)
    first = next((keys.raw["contact_model"] for keys in interfaces if "contact_model" in keys), None)
    for keys in interfaces:
        index = int(keys.path[1])
        is_of_grid = "gap" in grid
        if is_of_grid and grid.raw.get("interface") in labels:
            is_of_grid = (labels if len(interfaces) == 1 else labels[index : index + 1]) == [grid.raw["interface"]]
        if "gap" not in keys and not is_of_grid:
            yield keys.fault("gap", Interface.keys()["gap"].lacks("gap"), absent=True)
        if first is None and "contact_model" not in grid and keys is interfaces[0]:
            sentence = f'missing; write contact_model = "jankowski", or another of {", ".join(CONTACT_MODELS)}'
            yield keys.fault("contact_model", sentence, absent=True)
        written_models = keys.raw.get("contact_model", first)
        yield from _link_key_faults(keys, varied(draft, keys))
        refusal = is_row(draft) and _not_in_row(draft, written_models)  # which says what to choose instead
        yield from _law_faults(keys, grid, None if refusal else written_models)


def _link_key_faults(keys: Section, varied_keys: set[Any]) -> Iterator[Fault]:
    """Faults for keys of a link without the key that they need, and for keys that exclude each other."""
    stated_keys = {*keys.raw, *varied_keys}
    for link_keys, needs, sentence in (
        (OF_SPRING, {"link_stiffness"}, 'is of the spring of a link; write link_stiffness = "20 MN/m" beside it'),
        (OF_DAMPER, {"link_damping"}, 'is of the damper of a link; write link_damping = "500 kN s/m" beside it'),
        (("link_at",), OF_LINKS, 'joins nothing; write link_stiffness = "20 MN/m" or link_damping = "2 MN s/m"'),
    ):
        yield from (keys.fault(key, sentence) for key in link_keys if key in keys and not needs & stated_keys)
    for key in (key for key in OF_SPRING if key in keys):
        words = f"a link has one law, here that of {key}; remove it, or {key}"
        yield from (keys.fault(damper, words) for damper in OF_DAMPER if damper in keys)
    for key, verb in (("link_slack", "is slack"), ("link_breaking_force", "breaks")):
        if key in keys and "link_strength" in keys:
            yield keys.fault(key, f"a link slips or {verb}, not both; remove it, or link_strength")
    if "link_breaking_force" in keys and (keys.get("link_damping", 0.0) or "link_damping" in varied_keys):
        sentence = "a damper beside the spring would go on after it has broken; remove it, or link_damping"
        yield keys.fault("link_breaking_force", sentence)


def _option_list_faults(draft: Draft, count: int) -> Iterator[Fault]:
    """Faults for options of effects that are lists without one value for each interface."""
    advice = f", or {count}, one between each two neighbours from left to right" if count > 1 else ""
    for name, entry in draft.table("effects").raw.items():
        kinds = EFFECTS[name].options if name in EFFECTS and isinstance(entry, dict) else {}
        for key in (key for key, kind in kinds.items() if isinstance(kind, PerInterface)):
            value = entry.get(key)
            if isinstance(value, list) and len(value) not in (0, count):
                sentence = f"a list of {len(value)} for {counted(count, 'interface')}: write one value for all{advice}"
                yield Fault(("effects", name, key), sentence)


def _count_faults(draft: Draft, limit: int) -> Iterator[Fault]:
    """A fault where there is neither one interface for all neighbours nor one between each two."""
    count, buildings = draft.count("interface", -1), draft.count("building", -1)
    if min(count, buildings) < 0 or count in (1, limit):
        return
    if buildings <= 2:
        advice = f"remove {count - 1}" if count else "write one [[interface]]"
        repair = f"there is one between two neighbours; {advice}"
    else:
        repair = f"write {buildings - 1}, one between each two neighbours from left to right, or one for all of them"
    path: KeyPath = ("interface", count - 1) if count else ("interface",)
    yield Fault(path, f"{count} interfaces for {buildings} buildings: {repair}")


def _grid_interface_faults(grid: Section, names: Sequence[str]) -> Iterator[Fault]:
    """Faults of [grid] interface, the only one whose gap varies: it must exist, and the grid have gaps."""
    name = grid.raw.get("interface")
    if not isinstance(name, str):
        return
    if name not in names:
        sentence = f"{shown(name)} is not an interface{nearest(name, names)}; it may be {', '.join(map(shown, names))}"
        yield grid.fault("interface", sentence)
    if "gap" not in grid:
        sentence = 'names the interface whose gap varies; write gap = ["25 mm", "50 mm"] in [grid] too'
        yield grid.fault("interface", sentence)


def _instant_law_faults(draft: Draft) -> Iterator[Fault]:
    """Faults for contact models whose velocities jump, in a row that cannot have them."""
    grid_models = as_list(draft.table("grid").raw.get("contact_model"))
    interface_models: list[tuple[KeyPath, Any]] = [
        ((*keys.path, "contact_model"), keys.raw["contact_model"])
        for keys in draft.tables("interface")
        if "contact_model" in keys
    ]
    grid_entries: list[tuple[KeyPath, Any]] = [
        (("grid", "contact_model", place), name) for place, name in enumerate(grid_models)
    ]
    for path, name in [*interface_models, *grid_entries]:
        if why := _not_in_row(draft, name):
            yield Fault(path, f"{why}; choose among {', '.join(LAWS)}")
    kinds = {model in INSTANT_LAWS: (path, model) for path, name in interface_models for model in known_models([name])}
    if not grid_models and len(kinds) == 2 and not _not_in_row(draft, kinds[True][1]):
        (path, name), other = kinds[True], kinds[False][1]
        why = f"a jump beside a contact of finite force, as {other} has it at another interface, is not computed"
        yield Fault(path, f"{name}: {why}; write models of one kind at all interfaces")


def _not_in_row(draft: Draft, name: object) -> str:
    """Why this row cannot have a contact model whose velocities jump; "" for other names, and where it can."""
    if not isinstance(name, str) or name not in INSTANT_LAWS:
        return ""
    if why := only_in_pairs(INSTANT_LAWS[name]):
        return f"{name} is for a pair of single masses: {why}"
    if cause := _more_than_masses(draft):
        why = "of floors that are joined and touch at one instant no law of impact is established (Halm and Posa 2021)"
        return f"{name} is for single masses that meet mass to mass, and {cause}: {why}"
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


def _law_faults(keys: Section, grid: Section, own_name: Any) -> Iterator[Fault]:
    """Faults of the keys that the contact models of an interface need; ``own_name`` is its own model."""
    grid_models = as_list(grid.raw.get("contact_model"))
    models = known_models([*([] if own_name is None else [own_name]), *grid_models])
    stiff_models = [name for name in models if not is_instant(CONTACT_MODELS[name])]
    owner = stiff_models[0] if stiff_models else None  # whose unit the interface's stiffness has
    if "stiffness" not in keys and (stiff_models or not models) and owner != TABULATED:
        yield keys.fault("stiffness", Interface.keys()["stiffness"].lacks("stiffness"), absent=True)
    damped_models = [name for name in models if CONTACT_MODELS[name].needs_restitution]  # type: ignore[attr-defined]
    if damped_models and "restitution" not in keys:
        sentence = f"missing, and {damped_models[0]} needs it; {MISSING_RESTITUTION}"
        yield keys.fault("restitution", sentence, absent=True)
    yield from _relation_faults(keys, models)
    for key, law in OF_ONE_LAW.items():
        if key in keys and models and law not in models:
            yield keys.fault(key, f"only {law} has one, not {', '.join(models)}; remove it")
    if "stiffness" in keys and models and not stiff_models:
        yield keys.fault("stiffness", f"{', '.join(models)}: the velocities jump, and no stiffness acts; remove it")
    elif "stiffness" in keys:
        yield from _stiffness_faults(keys, owner)
    for position, name in enumerate(grid_models) if owner else ():
        if (
            name in stiff_models
            and name != TABULATED
            and _unit(name) != _unit(str(owner))
            and "equal_terms" not in keys
        ):
            sentence = (
                f"{name} takes a stiffness in {_unit(name)}, but the interface gives one in {_unit(str(owner))} for "
                f"{owner}; write equal_terms = {EQUAL_TERMS_EXAMPLE} in [[interface]], from which its stiffness follows"
            )
            yield Fault(("grid", "contact_model", position), sentence)


def _relation_faults(keys: Section, models: Sequence[str]) -> Iterator[Fault]:
    """Faults for a relation that these contact models do not have, or under which they cannot return e."""
    value = keys.raw.get("restitution")
    relation = value.get("relation") if isinstance(value, dict) else AS_PUBLISHED
    flaw = misfit((CONTACT_MODELS[name] for name in models), relation) if relation in RELATIONS else ""
    if flaw:
        yield Fault((*keys.path, "restitution", "relation"), flaw)
    elif relation == AS_ASKED and (restitution := keys.get("restitution")):
        fixed = 1.0 if "design_penetration" in keys else 0.0
        for name in models:
            if excess := out_of_reach(related(CONTACT_MODELS[name], AS_ASKED), least_of(restitution.rule), fixed):
                yield keys.fault("restitution", excess)


def _stiffness_faults(keys: Section, law: str | None) -> Iterator[Fault]:
    """A fault for a stiffness that cannot be read, or has not the unit of its law."""
    stiffness = keys.raw["stiffness"]
    if law in LAWS and _fits_law(stiffness, str(law)):
        return
    models = [name for name in LAWS if _fits_law(stiffness, name)]
    if law is None and models:
        return
    quantity = stiffness_quantity(LAWS[law or "jankowski"])
    try:
        parse(stiffness, quantity)
    except QuantityError as error:
        if law == TABULATED:
            flaw = str(error).removesuffix(repair(quantity))
            yield keys.fault("stiffness", f"{flaw}remove it: the forces of the table have their own stiffness")
            return
        models = [name for name in models if name != TABULATED]  # which has its stiffness from its table
        choice = f" for {law}, or choose a contact model in {_unit(models[0])}: {', '.join(models)}" if models else ""
        yield keys.fault("stiffness", f"{error}{choice}")


def _fits_law(stiffness: object, law: str) -> bool:
    try:
        parse(stiffness, stiffness_quantity(LAWS[law]))
    except QuantityError:
        return False
    return True


def _unit(law: str) -> str:
    return stiffness_quantity(LAWS[law]).unit


# ------------------------------------------------------------------------------------------------ every value stated
ALWAYS_WRITTEN = {"gap", "contact_model", "yield_force", *OF_ONE_LAW}  # even with their default, of a law that is run


class ResolvedInterface(Interface):
    """What stands between two neighbours: the keys of its table with every value stated, in SI, and where they meet.

    ``stiffness`` is a number [N/m or N/m^1.5], as the first contact model that takes one has it; None where none does.
    """

    points: tuple[Point, ...] = ()  # from the ground up
    levels: LevelRule = LevelRule()  # when two floors are one contact point
    links: tuple[Link, ...] = ()

    def as_written(self, grid_models: Sequence[str]) -> dict[str, Any]:
        """The [[interface]] table, every value stated; ``grid_models`` are the contact models of the grid."""
        models = (self.contact_model, *grid_models)
        omitted_keys = {key for key, law in OF_ONE_LAW.items() if law not in models}
        if self.restitution.words == NO_RESTITUTION:
            omitted_keys.add("restitution")
        settings: dict[str, Any] = {
            key: setting
            for key in self.keys().keys() - omitted_keys
            if (setting := getattr(self, key)) != type(self).model_fields[key].default
            or key in ALWAYS_WRITTEN
            or (key in OF_LINKS and self.links)
        }
        owner = stiff_model(str(self.contact_model), grid_models)
        # The stiffness of the table itself is not written: it would stay when another table is given.
        is_of_table = owner == TABULATED and self.table is not None and self.stiffness == self.table.stiffness
        if settings.pop("stiffness", None) is not None and owner is not None and not is_of_table:
            settings["stiffness"] = exact(float(self.stiffness), stiffness_quantity(CONTACT_MODELS[owner]))
        table: Interface = Interface.from_values(settings)
        return table.written()


def stiff_model(own_model: str, grid_models: Iterable[str]) -> str | None:
    """The first of these contact models that takes a stiffness, or None: instant ones take none."""
    return next((name for name in (own_model, *grid_models) if not is_instant(CONTACT_MODELS[name])), None)


def resolved_interfaces(
    draft: Draft, buildings: Sequence[Building | Storeys], grid: Grid, row: bool
) -> tuple[tuple[ResolvedInterface, ...], list[Fault]]:
    """What stands between each two buildings, from tables without a fault; one table is for all where there is one."""
    interfaces, faults = [], []
    tables = draft.tables("interface")
    # A key of contact that one interface lacks is that of the first interface that has it.
    inherited_keys = ("contact_model", *PARAMETERS, "equal_terms")
    shared_keys = {key: keys.get(key) for key in inherited_keys for keys in tables[::-1] if key in keys}
    # In a row, a grid of one yield force is that of all interfaces.
    shared_force = {"yield_force": grid.yield_force[0]} if row and len(grid.yield_force) == 1 else {}
    depths = [keys.get("floor_depth") for keys in draft.tables("building")]
    stands_apart = len({repr(side.support) for side in buildings}) > 1 or "wave_passage" in draft.table("effects").raw
    has_bumper = "bumper_length" in varied(draft) or any("bumper_length" in keys for keys in tables)
    for place, sides in enumerate(pairwise(buildings)):
        keys = tables[min(place, len(tables) - 1)]
        table = Interface.from_values(shared_keys | dict(keys.values) | shared_force)
        # A contact model that no table gives is the first of the grid.
        contact_model = table.contact_model or grid.contact_model[0]
        owner = stiff_model(contact_model, grid.contact_model)
        stiffness = None
        if owner == TABULATED and table.stiffness is None:
            stiffness = table.table.stiffness
        elif owner is not None:
            stiffness = parse(table.stiffness, stiffness_quantity(CONTACT_MODELS[owner]))
        pair = Neighbours(place, sides, (depths[place], depths[place + 1]), table, keys.path)
        points, flaws = _contact_points(pair)
        flaws += _link_faults(pair, stands_apart=stands_apart)
        faults += flaws
        values = {key: getattr(table, key) for key in Interface.key_names()} | {
            "gap": grid.gap[0] if table.gap is None else table.gap,
            # As an axis has it, so that all scenes of the axis have one.
            "bumper_length": 0.0 if table.bumper_length is None and has_bumper else table.bumper_length,
            "contact_model": contact_model,
            "stiffness": stiffness,
            "points": points,
            "links": _links(pair, points) if not flaws and OF_LINKS & {*keys.raw, *varied(draft, keys)} else (),
            "levels": pair.rule,
        }
        interfaces.append(ResolvedInterface.from_values(values))
    return tuple(interfaces), faults


class Neighbours(NamedTuple):
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


def _contact_points(pair: Neighbours) -> tuple[tuple[Point, ...], list[Fault]]:
    """The contact points of two neighbours, and their faults."""
    table, sides, rule = pair.table, pair.sides, pair.rule
    if table.contact:
        flaws = [
            Fault((*pair.base, "contact"), sentence)
            for floors in table.contact
            if (sentence := _misplaced_words(sides, floors, rule))
        ]
        meetings = [] if flaws else [given_point(*sides, *floors) for floors in table.contact]
    else:
        flaws = _depth_faults(pair)
        meetings = [] if flaws else automatic_points(*sides, rule.is_one)
    points = [Point(pair.place, *meeting) for meeting in meetings]
    if not flaws and any(_plans_of(side) for side in sides):
        points, flaws = _points_at_both_ends(pair, points)
    return tuple(points), flaws


def _plans_of(side: Building | Storeys) -> tuple[Plan, ...]:
    return side.plans if isinstance(side, Storeys) else ()


def _points_at_both_ends(pair: Neighbours, points: Sequence[Point]) -> tuple[list[Point], list[Fault]]:
    """Contact points of floors that rotate: at both ends of the length that the faces of two floors share."""
    left, right = (side.name for side in pair.sides)
    if any(point.kind == COLUMN for point in points):
        words = (
            f"floors that rotate meet floors, and here of {left} and {right} one meets a column; write contact with "
            "the floors that meet, or a floor_depth or tolerance by which their levels are one"
        )
        return [], [Fault((*pair.base, "contact"), words)]
    ends = [point._replace(across=across) for point in points for across in _shared_ends(pair.sides, point)]
    misses = [point for point in points if not _shared_ends(pair.sides, point)]
    if misses and (pair.table.contact or not ends):
        words = f"the faces of {left} and {right} do not meet"
        if ends:
            words += f" at {floor_words(misses[0].left_floor)} of {left}; remove it from contact, or correct plan:"
        else:
            words += ";"
        return [], [Fault(("building", pair.place, "plan"), f"{words} their ends are in one coordinate across the row")]
    return ends, []


def _shared_ends(sides: tuple[Any, Any], point: Point) -> tuple[float, ...]:
    """Both ends of the length that the faces of the floors at a contact point share [m]; none where there is none."""
    floors = zip(sides, (point.left_floor, point.right_floor), strict=True)
    faces = [plans[int(floor) - 1].face for side, floor in floors if (plans := _plans_of(side))]
    low, high = max(face[0] for face in faces), min(face[1] for face in faces)  # a floor without a plan is as long
    return (low, high) if low < high else ()


def _links(pair: Neighbours, points: Sequence[Point]) -> tuple[Link, ...]:
    """The links of two neighbours: where their table says, or at their highest contact point."""
    table = pair.table
    places = table.link_at or ((points[-1].left_floor, points[-1].right_floor),)
    slack = -inf if table.link_slack is None else table.link_slack
    law = table.link_stiffness, table.link_damping, table.link_strength, slack, table.link_breaking_force
    brace = table.link_brace_stiffness or inf
    exponent = table.link_exponent or float(brace < inf)
    return tuple(Link(pair.place, *floors, *law, exponent=exponent, brace=brace) for floors in places)


def _link_faults(pair: Neighbours, *, stands_apart: bool) -> list[Fault]:
    """Faults for links at floors that do not exist, between buildings on unlike grounds, or too stiff to follow."""
    table = pair.table
    key = "link_stiffness" if table.link_stiffness else "link_damping"
    if any(_plans_of(side) for side in pair.sides) and (table.link_stiffness or table.link_damping):
        return [Fault((*pair.base, key), "links of floors that rotate are not computed; remove it, or plan")]
    if stands_apart and (table.link_stiffness or table.link_damping):
        words = "links are computed where all buildings stand on one ground motion; remove it, or what parts them"
        return [Fault((*pair.base, key), words)]
    if table.link_strength < LEAST_SLIP * table.link_stiffness:
        slip, limit = table.link_strength / table.link_stiffness, table.link_strength / LEAST_SLIP
        words = (
            f"{say(table.link_stiffness, STIFFNESS)} slips at link_strength after {slip:.2g} m; less than "
            f"{LEAST_SLIP:g} m cannot be followed, and sliding would be lost; write {say(limit, STIFFNESS)} or less"
        )
        return [Fault((*pair.base, "link_stiffness"), words)]
    return [
        Fault((*pair.base, "link_at"), sentence)
        for floors in table.link_at
        if (sentence := _missing_floor_words(pair.sides, floors))
    ]


def _missing_floor_words(sides: tuple[Any, Any], floors: tuple[float, float]) -> str:
    """A sentence on a place above a building's roof; "" where there is none."""
    for side, floor in zip(sides, floors, strict=True):
        count = len(side.masses) if isinstance(side, Storeys) else 1
        if floor > count:
            return (
                f"{floor_words(floor)} of {side.name}: {side.name} has {count} storey{'s' * (count != 1)}; write one "
                "of these"
            )
    return ""


def _depth_faults(pair: Neighbours) -> list[Fault]:
    """Faults for a tolerance, or depths, by which a floor could meet two floors of the other building."""
    lowest = min((height for side in pair.sides if isinstance(side, Storeys) for height in side.heights), default=inf)
    rule = pair.rule
    reason = (
        f"is not below half of the lowest storey here, {say(lowest, STOREY_HEIGHT)}, so that a floor could meet two"
    )
    if rule.tolerance is not None:
        if rule.tolerance < 0.5 * lowest:
            return []
        repair = "write a smaller one, or the points themselves in contact"
        return [Fault((*pair.base, "tolerance"), f"{say(rule.tolerance, STOREY_HEIGHT)} {reason}; {repair}")]
    flaws = []
    for side, depth in enumerate((rule.left_depth, rule.right_depth)):
        if depth >= 0.5 * lowest:
            prefix = "" if pair.depths[side] is not None else "missing, and the usual "
            repair = "write the depth of the floor slabs, or the points themselves in contact"
            path = ("building", pair.place + side, "floor_depth")
            flaws.append(Fault(path, f"{prefix}{say(depth, STOREY_HEIGHT)} {reason}; {repair}", absent=bool(prefix)))
    return flaws


def _misplaced_words(sides: tuple[Any, Any], floors: tuple[float, float], rule: LevelRule) -> str:
    """The fault of a contact point that the scene gives; "" where there is none."""
    words = [f"{floor_words(floor)} of {side.name}" for side, floor in zip(sides, floors, strict=True)]
    if absent_floor := _missing_floor_words(sides, floors):
        return absent_floor
    if not any(floor == int(floor) or side.is_rigid for side, floor in zip(sides, floors, strict=True)):
        return f"{words[0]} against {words[1]}: a column meets a floor; write storey in place of one of them"
    difference, limit = level_gap(*sides, *floors), rule.largest
    if difference > limit:
        key = "floor_depth" if rule.tolerance is None else "tolerance"
        words2 = "the depth of a floor here," if rule.tolerance is None else "the tolerance of"
        return (
            f"{words[0]} and {words[1]} are {say(difference, STOREY_HEIGHT)} apart in level, more than {words2} "
            f"{say(limit, STOREY_HEIGHT)}; correct the place, or write a larger {key}"
        )
    return ""
