"""A scene in words, as an engineer reads it."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isnan

from pounding_risk import units
from pounding_risk._common.counted import counted
from pounding_risk._common.words import short_list
from pounding_risk.models.contact.impulsive import is_instant
from pounding_risk.models.contact.laws import stiffness_quantity
from pounding_risk.models.contact.relation import AS_PUBLISHED
from pounding_risk.models.contact.table import TABULATED
from pounding_risk.models.effects import EFFECTS, option_words
from pounding_risk.models.ground import Support
from pounding_risk.models.structures.contact_points import COLUMN, LevelRule
from pounding_risk.models.structures.plan import Plan
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.levels import FACTOR, PEAK, say_level
from pounding_risk.motions.request import RecordRequest, Spectral
from pounding_risk.scene.building_tables import ACROSS, GYRATION
from pounding_risk.scene.interfaces import known_law, said_restitution
from pounding_risk.scene.motions import request_of
from pounding_risk.scene.notes import GivenKeys, given_keys, level_notes
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.tables import Effect
from pounding_risk.scene.values import OF_EACH_INTERFACE
from pounding_risk.units import Quantity, say

FEW = 4  # aftershocks that are named


def scene_words(study: Scene, records: int) -> list[tuple[str, str]]:
    """The scene in words: (label, words) of each row of a table."""
    stated_keys = given_keys(study)
    return [
        ("scene", study.name),
        *_places(study),
        *(("effect", _effect(effect, stated_keys)) for effect in study.effects),
        ("records", _amplitude(study, records)),
        ("polarity", " and ".join(study.records.polarities)),
        *_grid(study),
        ("tolerance", f"rtol {say(study.rtol, units.RTOL)}"),
    ]


def _places(study: Scene) -> list[tuple[str, str]]:
    """Buildings from left to right, each interface with its contact points, and contact models.

    Stiffness and restitution stand with the interface where there are several.
    """
    yielding, several = "inelastic_storeys" in dict(study.effects), len(study.interfaces) > 1
    sides = ["building"] * len(study.buildings) if several else ["left building", "right building"]
    words = [_building_words(building, yielding) + _ground_words(building.support) for building in study.buildings]
    rows = list(zip(sides, words, strict=True))
    for place, name in enumerate(study.interface_names):
        scene = study.at(place)
        words = [f"{name}: " * several + f"gap {say(scene.gap, units.GAP)}"]
        words += [f"bumpers of {say(length, units.GAP)} in it" for length in scene.bumpers if length]
        if several:
            words += [*_stiffness(scene), f"restitution {_restitution(scene)}"]
        if not _has_floors(scene):
            words.append(_strength(scene.yield_force))
        rows += [("interface", ", ".join(words)), *_points(scene), *_links(scene)]
    rows += [("contact model", words) for words in _laws(study)]
    rows += [] if several else [("restitution", _restitution(study))]
    return rows + [("note", f"{name}: {note}") for name, note in level_notes(study).items()]


def _stiffness(scene: Scene) -> list[str]:
    if scene.stiffness is None:
        return []
    return [f"stiffness {say(scene.stiffness, stiffness_quantity(known_law(scene.stiff_name)))}"]


def _strength(force: float) -> str:
    return "no yielding" if force == inf else f"yield force {say(force, units.YIELD_FORCE)}"


def _has_floors(scene: Scene) -> bool:
    """True where two neighbours do not just meet mass to mass."""
    has_storeys = any(isinstance(building, Storeys) for building in scene.buildings)
    return has_storeys or bool(scene.interfaces[0].contact) or any(point.kind == COLUMN for point in scene.points)


def _levels(rule: LevelRule) -> str:
    """The rule by which floors of two neighbours collide floor to floor."""
    if rule.tolerance is not None:
        return f"floors up to {say(rule.tolerance, units.STOREY_HEIGHT)} apart in level are one, by tolerance"
    depths = dict.fromkeys(say(depth, units.STOREY_HEIGHT) for depth in (rule.left_depth, rule.right_depth))
    return f"floors {' and '.join(depths)} deep are one where they overlap in height, by floor_depth"


def _points(scene: Scene) -> list[tuple[str, str]]:
    """The rule of levels, and contact points by kind with the yield force of each; nothing of two masses."""
    if not _has_floors(scene):
        return []
    (interface,), (left, right) = scene.interfaces, scene.buildings
    rows = [] if interface.contact else [("levels", _levels(interface.levels))]
    meetings = [(point.kind, force) for point, force in zip(interface.points, scene.point_yield_forces(), strict=True)]
    for kind, force in sorted(dict.fromkeys(meetings), key=lambda one: one[0] == COLUMN):
        places = [
            f"{_place(point.left_floor, left)}, {_place(point.right_floor, right)}"
            + ("" if isnan(point.level) else f" at {say(point.level, units.STOREY_HEIGHT)}")
            + ("" if point.across == inf else f", {say(point.across, ACROSS)} across")
            for point, meeting in zip(interface.points, meetings, strict=True)
            if meeting == (kind, force)
        ]
        rows += [("contact points", f"floor to {kind}, {_strength(force)}: {'; '.join(places)}")] if places else []
    return rows


def _links(scene: Scene) -> list[tuple[str, str]]:
    """The links of an interface; spring and dashpot are the same at every place."""
    left, right = scene.buildings
    links = scene.links
    places = [f"{_place(link.left_floor, left)}, {_place(link.right_floor, right)}" for link in links]
    if not places:
        return []
    link = scene.links[0]
    slips = f", slips at {say(link.strength, units.LINK_STRENGTH)}" if link.strength < inf else ""
    hooks = f", pulls past a slack of {say(link.slack, units.LINK_SLACK)}" if link.slack > -inf else ""
    breaks = f", breaks at {say(link.breaking, units.LINK_BREAKING_FORCE)}" if link.breaking < inf else ""
    spring = f"{say(link.stiffness, units.LINK_STIFFNESS)}{slips}{hooks}{breaks}"
    power = f" at 1 m/s, by the power {link.exponent:g} of the speed" if link.exponent else ""
    brace = f" on a brace of {say(link.brace, units.LINK_BRACE)}" if link.is_braced else ""
    return [("link", f"{spring} and {say(link.damping, units.LINK_DAMPING)}{power}{brace}: {'; '.join(places)}")]


def _place(floor: float, building: Building | Storeys) -> str:
    """A place on a building; a wall has no columns."""
    if floor == int(floor):
        return f"storey {int(floor)} of {building.name}"
    return building.name if building.is_rigid else f"column {int(floor) + 1} of {building.name}"


def _ground_words(support: Support) -> str:
    """The ground of a building in words; nothing where it has the records as they are."""
    words = [f"record {', '.join(support.records)}"] if support.records else []
    words += [f"the motion times {say(support.factor, units.GROUND_FACTOR)}"] if support.factor != 1.0 else []
    words += [f"{say(support.delay, units.GROUND_DELAY)} later"] if support.delay else []
    words += (
        [f"ground that moves at {say(support.velocity, units.GROUND_VELOCITY)} at first"] if support.velocity else []
    )
    return f"; stands on {', '.join(words)}" if words else ""


def _building_words(building: Building | Storeys, yielding: bool) -> str:
    """A building in words, without its ground; ``yielding`` where an effect lets storeys yield."""
    if isinstance(building, Storeys):
        count = len(building.masses)
        yield_text = ""
        if building.strengths:
            law = f", {building.hysteresis.rule} hysteresis" if building.hysteresis else ""
            yield_text = (
                f", with yield shears{law}" if yielding else ", elastic (yield shears act under inelastic_storeys)"
            )
        matrices = "mass and stiffness matrices" if building.mass_matrix else "a stiffness matrix"
        matrix_text = f", joined by {matrices}" if building.stiffness_matrix else ""
        interior = len(building.interior_masses)
        matrix_text += f" with {counted(interior, 'interior mode')}" if interior else ""
        return (
            f"{building.name}: {count} storey{'s' * (count != 1)}{matrix_text}, "
            f"{say(building.height, units.STOREY_HEIGHT)}, {say(building.mass, units.MASS)}, "
            f"period {say(building.period, units.PERIOD)}, damping ratio {say(building.damping, units.DAMPING)} "
            f"({building.damping_rule}){yield_text}{_special_words(building)}"
            + _initial_state_words(building.initial_displacement, building.initial_velocity)
        )
    height = f", height {say(building.height, units.HEIGHT)}" if building.height else ""
    mass = say(building.mass, units.MASS) if building.mass < inf else "any mass"
    if building.is_rigid:
        return f"{building.name}: {mass}, rigid (moves with the ground){height}"
    floor_text = ""
    if building.floor_length:
        length, speed = say(building.floor_length, units.FLOOR_LENGTH), say(building.wave_speed, units.WAVE_SPEED)
        floor_text = f", floor {length} at {speed}"
    return (
        f"{building.name}: {mass}, period {say(building.period, units.PERIOD)}, "
        f"damping ratio {say(building.damping, units.DAMPING)}{floor_text}{height}"
        + _initial_state_words((building.initial_displacement,), (building.initial_velocity,))
    )


def _special_words(building: Storeys) -> str:
    """Plans of floors that rotate, or isolators with the period while they yield; nothing for other buildings."""
    if building.plans:
        words = [f"{_floors_of(building.plans, plan)}{_plan(plan)}" for plan in dict.fromkeys(building.plans)]
        return f", floors that rotate: {'; '.join(words)}"
    law = building.isolator_law
    if law is None or building.isolators is None:
        return ""
    return (
        f" above the slab, on isolators (storey 1) of {say(law.strength, units.YIELD_FORCE)} and "
        f"{say(law.soft, units.STIFFNESS)} past yield at {say(building.isolators.yield_displacement, units.GAP)}, "
        f"period {say(building.isolated_period, units.PERIOD)} while they yield"
    )


def _plan(plan: Plan) -> str:
    along = plan.eccentricity_along
    second_text = "" if along is None else f" across and {say(along, ACROSS)} along the row, both components of motion"
    ratio = "" if along is None else f", frequency across {plan.across_ratio:g} of that along"
    centre = f", centre of mass at {say(plan.centre_along, ACROSS)} along the row" if plan.centre_along else ""
    return (
        f"eccentricity {say(plan.eccentricity, ACROSS)}{second_text}, radius of gyration "
        f"{say(plan.gyration, GYRATION)}, torsional ratio {plan.torsional_ratio:g}{ratio}, faces from "
        f"{say(plan.face[0], ACROSS)} to {say(plan.face[1], ACROSS)}{centre}"
    )


def _floors_of(plans: Sequence[Plan], plan: Plan) -> str:
    """The floors that have a plan, such as "floors 1, 2: "; "" where all have it."""
    floors = [str(number) for number, item in enumerate(plans, 1) if item == plan]
    return "" if len(floors) == len(plans) else f"floor{'s' * (len(floors) > 1)} {', '.join(floors)}: "


def _initial_state_words(displacement: tuple[float, ...], velocity: tuple[float, ...]) -> str:
    """The initial state of a building, each quantity by its largest value; nothing at rest."""
    words = []
    if any(displacement):
        words.append(f"displaced by {say(max(displacement, key=abs), units.INITIAL_DISPLACEMENT)}")
    if any(velocity):
        words.append(f"moving at {say(max(velocity, key=abs), units.INITIAL_VELOCITY)}")
    return f", begins {' and '.join(words)}{' at most' * (len(displacement) > 1)}" if words else ""


JUMPS = "no stiffness: the velocities jump at a touch"


def _laws(study: Scene) -> list[str]:
    """Each contact model of the grid, with the origin of its stiffness."""
    terms = study.equal_terms
    models = []
    for name in study.grid.contact_models:
        if name == OF_EACH_INTERFACE:
            pairs = zip(study.interface_names, study.interfaces, strict=True)
            name = ", ".join(f"{item.contact_model} at {interface}" for interface, item in pairs)
            stiffness = "stiffness of each interface" if study.stiffness is not None else JUMPS
        elif is_instant(known_law(name)) or study.stiffness is None:
            stiffness = JUMPS
        elif len(study.interfaces) > 1 and not study.needs_equal_terms(name):
            stiffness = "stiffness of each interface"
        elif study.needs_equal_terms(name) and terms:
            stiffness = f"stiffness from equal {terms.same} at {terms.speed:g} m/s as {study.stiff_name}"
        else:
            (stiffness,) = _stiffness(study)
        tables = dict.fromkeys(one.table.words() for one in study.interfaces if one.table is not None)
        tables_text = f", {'; '.join(tables)}" if TABULATED in study.models_of(name) else ""
        models.append(f"{name}, {stiffness}{tables_text}")
    return models


def _restitution(study: Scene) -> str:
    rule = study.restitution
    exact_text = "" if study.relation == AS_PUBLISHED else ", returned exactly by an impact alone"
    if rule.c1 == rule.c2 == rule.c3 == 0.0:
        return f"{said_restitution(study.restitution_words)}{exact_text}"
    held_text = f", held beyond {rule.fastest:g} m/s" if rule.fastest < inf else ""
    return f"{study.restitution_words}: falls with the approach speed{held_text}{exact_text}"


def _effect(effect: Effect, given: GivenKeys) -> str:
    """An effect with its options; defaults are marked."""
    kind = EFFECTS[effect.name]
    values = {key: option_words(kind.options[key], value) for key, value in effect.options}
    values |= {key: words for key, words in kind.absent.items() if key not in values}
    values = {key: words for key, words in values.items() if not words.startswith("none")}
    set_keys = {key for key in values if ("effects", effect.name, key) in given}
    options = ", ".join(f"{key} {value}{' (default)' * (key not in set_keys)}" for key, value in values.items())
    return f"{effect.name}: {options}" if options else effect.name


def _amplitude(study: Scene, count: int) -> str:
    request, grid = study.records, study.grid
    scaling = "as recorded" if request.scale is None else f"times {request.scale:g}"
    if request.manifest:
        common_text = "" if request.scale is None else f", then all times {request.scale:g}"
        scaling = f"each times its factor of {request.manifest}{common_text}"
    if request.sa is not None and request.sa.value is not None:
        scaling = f"each scaled to {_spectral(request.sa)} of {say(request.sa.value, units.PGA)}"
    if request.to_median is not None:
        measure = request.to_median.upper() if isinstance(request.to_median, str) else _spectral(request.to_median)
        common_text = "" if request.scale is None else f", then all times {request.scale:g}"
        scaling = f"each scaled to the median {measure}{common_text}"
    if grid.amplitudes != (None,):
        levels = _span([level for level in grid.levels if level is not None], grid.measure.quantity)
        relation = f" ({grid.measure.relation})" if grid.measure.relation else ""
        measure_text = "" if grid.measure == PEAK else f"{grid.measure.words}{relation} of "
        is_factor = grid.measure.name == FACTOR
        scaling = f"{scaling}, then times {levels}" if is_factor else f"each scaled to {measure_text}{levels}"
    window = f", {request.window[0]:g} s to {request.window[1]:g} s" if request.window else ""
    tail = (
        f", at least {say(request.tail, units.TAIL)} of free vibration after (whole time steps)" if request.tail else ""
    )
    if study.lag:
        tail += f", {say(study.lag, units.GROUND_DELAY)} longer for the building that is reached last"
    direction = "" if request.direction is None else f", in the direction {request.direction:g}° from north"
    direction += ", and across it" * request_of(study).both
    return f"{count}{direction}{window}, {scaling}{tail}{_aftershock(request)}"


def _aftershock(request: RecordRequest) -> str:
    if not request.aftershock:
        return ""
    ratio = request.aftershock_ratio
    size = "with the factor of each motion" if ratio is None else f"at {ratio:g} of the PGA of each motion"
    return f", followed after {say(request.pause, units.TIME)} by {short_list(request.aftershock, FEW)} {size}"


def _spectral(spectral: Spectral) -> str:
    return f"Sa({spectral.period:g} s, {100.0 * spectral.damping:g} %)"


def _grid(study: Scene) -> list[tuple[str, str]]:
    """The dimensions that have more than one value."""
    gaps = f"gaps of {study.gridded_interface}" if study.gridded_interface else "gaps"
    axes = {gaps: (study.grid.gaps, units.GAP), "yield forces": (study.grid.yield_forces, units.YIELD_FORCE)}
    rows = [(name, _span(labels, quantity)) for name, (labels, quantity) in axes.items() if len(labels) > 1]
    axis_rows = (("axis", f"{', '.join(axis.keys)}: {axis.words()}") for axis in study.axes if not axis.dimension)
    drawn_rows = () if study.uncertain is None else study.uncertain.described()
    return [*axis_rows, *drawn_rows, *rows]


def _span(labels: Sequence[float], quantity: Quantity) -> str:
    return short_list([say_level(label, quantity, 4) for label in labels], 6)
