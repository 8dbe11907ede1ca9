"""The same scene under many contact models on equal terms: does the conclusion depend on the model?

Stiffnesses of different laws cannot be compared (some are in N/m, some in N/m^1.5), and equal ones do not give equal
impacts. So every law is calibrated to one reference impact at each interface: that of the scene's own law with the
interface's stiffness and restitution, of the masses that strike there without springs or yielding. `scan` then runs the
grid with the calibrated laws, and `compare_findings` computes what differs.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from math import inf, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pounding_risk.ensemble.job_choice import job_kind
from pounding_risk.ensemble.laws import beyond_reach, check_reach
from pounding_risk.ensemble.replacing import check_replaceable_scene
from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.contact.impulsive import CONTACT_MODELS, needs_floors
from pounding_risk.models.contact.laws import stiffness_quantity
from pounding_risk.models.contact.relation import AS_ASKED, AS_PUBLISHED, misfit, relation_fault
from pounding_risk.models.effects import refusal
from pounding_risk.models.structures.contact_points import LevelRule
from pounding_risk.motions.levels import driven
from pounding_risk.results.along import Stack
from pounding_risk.results.attributes import VARIANTS, as_text
from pounding_risk.results.files import check_target
from pounding_risk.results.labels import described
from pounding_risk.results.run_labels import Case
from pounding_risk.results.scene_axes import at_one_place, axes_of
from pounding_risk.scene.interfaces import EQUAL_TERMS, NO_RESTITUTION, EqualTerms, known_law, unknown_law
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.scene_axis import count_of
from pounding_risk.scene.values import OF_EACH_INTERFACE
from pounding_risk.scene.variants import Variants, check_one_scene, where_words
from pounding_risk.solver.pair.isolated import Impact
from pounding_risk.studies import compare_findings as findings
from pounding_risk.studies.compare_along import along_finding
from pounding_risk.studies.histories import level_forces
from pounding_risk.studies.impact import impact
from pounding_risk.studies.simulate import run_of
from pounding_risk.studies.study import saved
from pounding_risk.units import SPEED, shown, si

USUAL_TERMS = EqualTerms(same=EQUAL_TERMS[0], speed=0.5)  # where neither the call nor the scene says otherwise
ELASTIC = 1e-6  # a law whose restitution is this close to 1 does not dissipate
IMPACT_COLUMNS = {
    "restitution_asked": ("1", "restitution that the relation gives for the reference impact"),
    "restitution": ("1", "restitution achieved in the reference impact"),
    "peak_force": ("N", "peak force of the reference impact"),
    "peak_penetration": ("m", "largest penetration of the reference impact"),
    "duration": ("s", "duration of the reference impact"),
}
TABLES = (*(f"ratio_{part}" for part in ("low", "median", "high")), "rank_agreement", "rank_agreement_lowest")
TABLES += ("flips", "judged", "gap_without_contact")
CURVES = {"time": ("s", "time since the touch"), "penetration": ("m", "penetration"), "force": ("N", "contact force")}
Known = dict[Any, list[Impact]]  # reference impacts by all that they depend on


def compare(
    study: Scene | str | Path,
    out: str | Path | None = None,
    *,
    laws: Sequence[str] = (),
    baseline: str | None = None,
    same: str | None = None,
    speed: float | str | None = None,
    relation: str | None = None,
    new: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Run a scene under several contact models on equal terms.

    At each interface every law gets the stiffness with which an impact of the reduced mass there at ``speed`` has the
    same peak force, or penetration, as under the scene's own law; all that have a restitution return the same e there.
    All interfaces of a row have one law at a time; where the scene's own differ, the baseline is the row with these.

    Parameters
    ----------
    study : Scene or path
        A scene, or the path of its TOML file.
    out : path, optional
        File for the dataset, ``.nc``.
    laws : sequence of str
        Contact models to compare. By default those of the scene's grid; where the grid names one, every model but those
        that the scene's solver does not compute, that lack a ``floor_length``, that an effect of the scene does not act
        on, or that cannot return the scene's e (the attribute ``left_out`` says so). Along axes of numbers of the scene
        a model that cannot be compared at one place is left out at all.
    baseline : str, optional
        Contact model beside which the others are set; the scene's own by default.
    same : {"peak force", "penetration"}, optional
        What the reference impacts have in common; the scene's ``equal_terms``, or "peak force", by default.
    speed : float or str, optional
        Speed of the reference impact, a number in m/s or a text with a unit; the scene's ``equal_terms``, or 0.5 m/s,
        by default.
    relation : {"exact", "published"}, optional
        How damping follows from e; "exact" by default, "published" where a law has no other (the attribute
        ``unequal_e`` says why), and then at every place along axes of numbers of the scene.
    new : bool
        Replace other results under the name ``out``.
    progress : callable, optional
        Called with the number of cases done and of all cases.

    Returns
    -------
    xarray.Dataset
        The dataset of `scan`, with ratios, ranks and conclusions set against the baseline, the reference impacts
        (``reference_...``, ``impact_...``), histories of one typical case, and the attribute ``finding``, a sentence.
        In a row ratios, ranks and conclusions are by interface, and the histories are those of the interface where the
        laws move the peak relative displacement most.

        Of a scene with axes of its numbers ratios, ranks, conclusions and gaps are along them, at each place as a
        comparison of the scene there has them; ``finding`` says how they change, and histories are left out. What
        ``sel`` leaves at one place has the finding of that place.

    Raises
    ------
    PoundingError
        As `scan`; for samples of uncertain numbers; and for an unknown law, baseline, speed, relation or ``same``, for
        fewer than two laws and, unless ``new``, if ``out`` holds other results. All before the first run.
    """
    target = None if out is None else check_target(out)
    study = as_scene(study)
    check_one_scene(study.updated(axes=tuple(axis for axis in study.axes if axis.dimension)), "compare")
    if study.axes and count_of(study.axes) == 1:
        study = Variants(study).scene(0)
    scene, reasons = with_equal_terms(study, Request(tuple(laws), baseline, (same, speed), relation))
    if target is not None:
        check_replaceable_scene(target, "compare", scene, new)
    runs, baseline = scan(scene, progress=progress), baseline or study.contact_model
    if study.axes:
        dataset = _compared_along_axes(scene, runs, baseline, reasons)
    else:
        dataset = _compared_scene(scene, runs, baseline, {})
        interface = findings.widest_interface(dataset)
        case = findings.typical_case(findings.at_interface(dataset, interface), baseline)
        dataset = dataset.assign(_typical_histories(scene, case, interface, baseline))
        dataset.attrs |= reasons | {"finding": findings.finding(dataset)}
    return saved(dataset, "compare", target)


# ------------------------------------------------------------------------------------------------------ equal terms


class Request(NamedTuple):
    """The options of a call of `compare`, whatever the scene."""

    laws: tuple[str, ...] = ()  # none for those of the grid, or for all
    baseline: str | None = None
    terms: tuple[str | None, float | str | None] = (None, None)  # what the reference impacts share, and their speed
    relation: str | None = None


def with_equal_terms(study: Scene, request: Request) -> tuple[Scene, dict[str, str]]:
    """The scene with its laws on equal terms, at every place along its axes, and attributes that say what is not so.

    Compared are the laws that can be at every place, under one relation: the exact one where all places have it.
    """
    places = {"": study}
    if study.axes:
        variants = Variants(study)
        places = {where_words(variants.overrides(number)): variants.scene(number) for number in range(variants.count)}
    left_out = ""
    if not request.laws and len(study.grid.contact_models) < 2:
        common = set.intersection(*(set(comparable_models(scene)) for scene in places.values()))
        laws = tuple(name for name in CONTACT_MODELS if name in common) or (study.contact_model,)
        request, left_out = request._replace(laws=laws), models_left_out(places)

    def on_terms(scene: Scene) -> tuple[Scene, str]:
        equal = on_equal_terms(scene, request.laws, request.baseline, request.terms)
        return with_damping_relation(equal, request.relation)

    equal = _at_all_places(places, on_terms)
    reasons = {place: cause for place, (_, cause) in equal.items() if cause}
    unequal_e = _with_places(reasons, len(places)) if reasons else ""
    attributes = {"left_out": left_out, "unequal_e": unequal_e}
    first, _ = next(iter(equal.values()))
    if not study.axes:
        return first, attributes

    def brought(scene: Scene) -> Scene:
        scene, _ = on_terms(scene)
        return scene.updated(relation=AS_PUBLISHED) if unequal_e else scene

    names = first.grid.contact_models
    _at_all_places(places, lambda scene: check_reach(brought(scene), names))
    base = study.updated(
        grid=study.grid._replace(contact_models=names),
        equal_terms=equal_terms_of(study, request.terms),
        relation=AS_PUBLISHED if unequal_e else first.relation,
        at_every_place=brought,
    )
    return base, attributes


def _at_all_places(places: dict[str, Scene], function: Callable[[Scene], Any]) -> dict[str, Any]:
    """The values of a function at every place; raises as it does, with the place where not all places raise it."""
    answers: dict[str, Any] = {}
    errors: dict[str, PoundingError] = {}
    for place, scene in places.items():
        try:
            answers[place] = function(scene)
        except PoundingError as error:
            errors[place] = error
    for place, first in errors.items():
        raise first if len(errors) == len(places) else PoundingError(f"{first} (at {place})")
    return answers


def _with_places(reasons: dict[str, str], count: int) -> str:
    """The first of the reasons by place, with its place and their number unless that is ``count``, of all places."""
    place, sentence = next(iter(reasons.items()))
    if len(reasons) == count:
        return sentence
    return f"{sentence} (at {len(reasons)} of {count} places, the first {place})"


def on_equal_terms(
    study: Scene, laws: Sequence[str], baseline: str | None, terms: tuple[str | None, float | str | None]
) -> Scene:
    """The study whose grid has the laws to compare, each with its calibrated stiffness; raises as `compare`."""
    names_known = (*CONTACT_MODELS, study.contact_model)
    if baseline is not None and (not isinstance(baseline, str) or baseline not in names_known):
        raise PoundingError(f"compare: the baseline {unknown_law(baseline)}")
    grid = study.grid.contact_models
    requested = tuple(laws) or (grid if len(grid) > 1 else comparable_models(study))
    names = tuple(dict.fromkeys((*requested, baseline or study.contact_model)))
    for name in study.models_of(*names):
        known_law(name)
        if fault := job_kind(study).unsolved(study, name) or study.lacks_table(name):
            raise PoundingError(f"compare: {name}: {fault}; leave it out")
    if len(names) < 2:
        raise PoundingError(f"compare: {names[0]} alone is no comparison; name another law, or none to run them all")
    for name in study.models_of(study.contact_model):
        if "stiffness" not in known_law(name)._fields:
            raise PoundingError(
                f"compare: {name} has no stiffness to which other laws could be calibrated; give the "
                "interface a contact_model that has one, and name this one as the baseline"
            )
    damped = [name for name in study.models_of(*names) if known_law(name).needs_restitution]
    if damped and _lacks_restitution(study):
        undamped = [name for name in comparable_models(study) if not known_law(name).needs_restitution]
        raise SceneError(
            study.source,
            [
                f"{', '.join(damped)} need{'s' if len(damped) == 1 else ''} a restitution, and the scene gives none; "
                'write restitution = 0.65, or restitution = "concrete", in [[interface]], '
                f"or compare {', '.join(undamped)} alone"
            ],
        )
    return study.updated(grid=study.grid._replace(contact_models=names), equal_terms=equal_terms_of(study, terms))


def equal_terms_of(study: Scene, terms: tuple[str | None, float | str | None]) -> EqualTerms:
    """What the reference impacts share, and their speed: those of the call, or of the scene, or the usual ones."""
    default = study.equal_terms or USUAL_TERMS
    same, speed = terms[0] or default.same, default.speed if terms[1] is None else terms[1]
    if same not in EQUAL_TERMS:
        raise PoundingError(f"compare: same is {shown(same)}; it may be {' or '.join(map(shown, EQUAL_TERMS))}")
    return EqualTerms(same=same, speed=si(speed, SPEED, "compare: speed"), every_law=True)


def with_damping_relation(study: Scene, relation: str | None) -> tuple[Scene, str]:
    """The study under a relation, by default that with which its laws return the same e; and why e is not the same."""
    names = study.models_of(*study.grid.contact_models)
    laws = [known_law(name) for name in names]
    if relation is not None:
        if fault := relation_fault(relation) or misfit(laws, relation):
            raise PoundingError(f"compare: {fault}")
        return study.updated(relation=relation), ""
    if not any(law.needs_restitution for law in laws):
        return study, ""
    exact = study.updated(relation=AS_ASKED)
    if fault := misfit(laws, AS_ASKED) or beyond_reach(exact, names):
        return study.updated(relation=AS_PUBLISHED), fault
    return exact, ""


def comparable_models(study: Scene) -> tuple[str, ...]:
    """Every contact model that can collide the scene's buildings, under its effects and with its e."""
    return tuple(name for name in CONTACT_MODELS if not _hindrance(study, name))


def models_left_out(places: dict[str, Scene]) -> str:
    """A sentence for the contact models that are not comparable at every place, with where; "" where all are."""
    reasons: dict[str, list[str]] = {}
    for name in CONTACT_MODELS:
        if by_place := {place: fault for place, scene in places.items() if (fault := _hindrance(scene, name))}:
            reasons.setdefault(_with_places(by_place, len(places)), []).append(name)
    return "; ".join(f"{', '.join(names)}: {fault}" for fault, names in reasons.items())


def _hindrance(study: Scene, name: str) -> str:
    """Why a contact model cannot be compared in this scene unless it is named; "" where it can."""
    law = known_law(name)
    if fault := job_kind(study).unsolved(study, name) or study.lacks_table(name):
        return fault
    if needs_floors(law) and (names := study.without_floor()):
        return f'{" and ".join(names)} without floor_length; write floor_length = "20 m" in [[building]] for it'
    for effect in study.effects:
        if fault := refusal(law, effect.name):
            return f"{fault}, under {effect.name}"
    if _lacks_restitution(study) or not law.needs_restitution:
        return ""
    return misfit([law], AS_ASKED) or beyond_reach(study.updated(relation=AS_ASKED), [name])


def _lacks_restitution(study: Scene) -> bool:
    """True where an interface of the scene gives no restitution."""
    return any(interface.restitution.words == NO_RESTITUTION for interface in study.interfaces)


# ------------------------------------------------------------------------------------------------------ the dataset


def _compared_scene(study: Scene, dataset: xr.Dataset, baseline: str, cache: Known) -> xr.Dataset:
    """The scan of a scene with the reference impacts, and what is set against the baseline."""
    dataset = dataset.assign(_reference_variables(study, dataset, cache))
    dataset = dataset.assign(findings.tables(dataset, baseline))
    terms = study.equal_terms or USUAL_TERMS
    return dataset.assign_attrs(
        baseline=baseline, reference_law=study.contact_model, same=terms.same, speed=terms.speed
    )


def _compared_along_axes(scene: Scene, runs: xr.Dataset, baseline: str, reasons: dict[str, str]) -> xr.Dataset:
    """The scan along axes with what a comparison adds at each place, and a finding on how that changes.

    Ratios, ranks, flips and gaps have all axes as dimensions, what describes the laws those along which it differs.
    """
    axes, cache = axes_of(runs), dict[Any, Any]()
    variants = Variants(scene, axes)
    attributes, stack = Stack(variants.shape), Stack(variants.shape)
    parts: list[xr.Dataset] = []
    for number in range(variants.count):
        places = zip(axes, variants.places(number), strict=True)
        part = at_one_place(runs.isel({axis.name: [place] for axis, place in places}))
        compared = _compared_scene(variants.scene(number), part, baseline, cache)
        facts = {name: compared.attrs[name] for name in ("same", "speed")}
        attributes.add(number, facts | {"finding": findings.finding(compared)})
        parts.append(compared.drop_vars(part.variables).drop_attrs(deep=False))
    facts = {name: compared.attrs[name] for name in ("baseline", "reference_law", "same", "speed")}
    facts = {name: fact for name, fact in facts.items() if name not in attributes.differing()}
    longest = max(part.sizes["impact_step"] for part in parts)
    for number, part in enumerate(parts):
        padded = part.pad(impact_step=(0, longest - part.sizes["impact_step"]))
        stack.add(number, {str(name): padded[name].values for name in padded.variables})
    variables: dict[str, Any] = {}
    for name, (along, stacked) in stack.reduced().items():
        variable = parts[0][name]
        if name in TABLES:
            along, stacked = tuple(range(len(axes))), np.stack([part[name].values for part in parts])
            stacked = stacked.reshape(*variants.shape, *variable.shape)
        variables[name] = ((*(axes[number].name for number in along), *variable.dims), stacked, variable.attrs)
    dataset = runs.assign(variables)
    lists = json.loads(runs.attrs[VARIANTS])
    lists["attributes"] += attributes.as_lists(whole=True)
    dataset.attrs |= facts | {VARIANTS: as_text(lists)} | reasons
    return dataset.assign_attrs(finding=along_finding(dataset))


def reference_impacts(study: Scene, stiffnesses: dict[str, float]) -> list[Impact]:
    """The reference impact of every law of the grid: the buildings' reduced mass against a wall, without yielding.

    ``study`` is the scene of one interface, as `Scene.at` gives it. Floors collide as they are: their impedances are no
    matter of the reduced mass.
    """
    terms = study.equal_terms or USUAL_TERMS
    wall = study.striking_mass, inf
    impacts = []
    for name in study.grid.contact_models:
        law, masses = study.law(name, stiffnesses.get(name)), wall
        if needs_floors(law):
            # A wall cannot strike.
            struck, other = sorted(study.buildings, key=lambda building: building.is_rigid)
            law, masses = law.between(struck, other), (struck.mass, inf if other.is_rigid else other.mass)
        impacts.append(impact(law, terms.speed, *masses, restitution=study.restitution))
    return impacts


def _reference_variables(study: Scene, dataset: xr.Dataset, cache: Known) -> dict[str, Any]:
    """Calibrated stiffness, restitution achieved, and the curves of the reference impacts, padded with NaN.

    Impacts in the ``cache`` are not computed again, and others are added to it.
    """
    names = study.grid.contact_models
    # A law without a stiffness may have none there.
    lists = {name: k for name, k in json.loads(dataset.attrs["stiffness"]).items() if k is not None}
    calibrated, masses, impacts = [], [], []
    for index in range(len(findings.interface_names(dataset))):
        scene = study.at(index)
        stiffnesses = {name: float(np.atleast_1d(k)[index]) for name, k in lists.items()}
        calibrated.append([stiffnesses.get(name, nan) for name in names])
        masses.append(scene.striking_mass)
        impacts.append(_reference_impacts_once(scene, stiffnesses, cache))
    variables = _facts_of_laws(study, impacts)
    axes = ("interface",) if "interface" in dataset.dims else ()

    def add(name: str, dims: tuple[str, ...], by_interface: list[Any], attributes: dict[str, str]) -> None:
        """A variable from its values at every interface, which are along the first axis of the dataset of a row."""
        variables[name] = ((*axes, *dims), np.array(by_interface if axes else by_interface[0]), attributes)

    words = "calibrated stiffness of the contact law, in the unit of stiffness_unit"
    add("stiffness", ("contact_model",), calibrated, {"long_name": words})
    add("reduced_mass", (), masses, described("kg", "reduced mass of the reference impact"))
    for name, (unit, words) in IMPACT_COLUMNS.items():
        columns = [[getattr(blow, name) for blow in row] for row in impacts]
        add(f"reference_{name}", ("contact_model",), columns, described(unit, words))
    longest = max(len(blow.time) for row in impacts for blow in row)
    for name, (unit, words) in CURVES.items():
        curves = np.full((len(impacts), len(names), longest), nan)
        for place in np.ndindex(curves.shape[:2]):
            curve = getattr(impacts[place[0]][place[1]], name)
            curves[place][: len(curve)] = curve
        facts = described(unit, f"{words}, reference impact; NaN after the parting")
        add(f"impact_{name}", ("contact_model", "impact_step"), list(curves), facts)
    return variables


def _facts_of_laws(study: Scene, impacts: Sequence[Sequence[Impact]]) -> dict[str, Any]:
    """Unit of the stiffness of each law, whether it dissipates and whether F_E acts in it; impacts by interface."""
    units, dissipates, capped = [], [], []
    for label, of_law in zip(study.grid.contact_models, zip(*impacts, strict=True), strict=True):
        models = [interface.contact_model for interface in study.interfaces] if label == OF_EACH_INTERFACE else [label]
        laws = [known_law(name) for name in models]
        law_units = [stiffness_quantity(law).unit if "stiffness" in law._fields else "" for law in laws]
        units.append(law_units[0] if len(set(law_units)) == 1 else findings.APART.join(law_units))
        dissipates.append(not all(blow.restitution > 1.0 - ELASTIC for blow in of_law))
        answers = {int(law.capped) for law in laws}
        capped.append(answers.pop() if len(answers) == 1 else findings.AT_SOME)
    elastic = {"long_name": "0 where the law is elastic, and without yielding returns all energy"}
    acts = {"long_name": "1 where the yield force acts in the law, -1 where at some interfaces only"}
    return {
        "stiffness_unit": ("contact_model", units, {"long_name": "unit of stiffness, several by interface"}),
        "dissipates": ("contact_model", np.array(dissipates, np.int8), elastic),
        "capped": ("contact_model", np.array(capped, np.int8), acts),
    }


def _reference_impacts_once(study: Scene, stiffnesses: dict[str, float], cache: Known) -> list[Impact]:
    """As `reference_impacts`; computed once for all scenes that have what they depend on in common."""
    interface_key = study.interfaces[0].updated(
        gap=0.0, yield_force=inf, column_yield_force=inf, contact=(), tolerance=None, points=(), levels=LevelRule()
    )
    has_floors = any(needs_floors(known_law(name)) for name in study.grid.contact_models)
    bodies = study.buildings if has_floors else study.striking_mass
    key = interface_key, bodies, study.grid.contact_models, tuple(stiffnesses.items())
    if key not in cache:
        cache[key] = reference_impacts(study, stiffnesses)
    return cache[key]


def _typical_histories(study: Scene, case: dict[str, int], interface: int, baseline: str) -> dict[str, Any]:
    """Relative displacement of one case, by its place on each axis, under every law at the samples of its record.

    At the contact point of the interface whose displacement is largest under the baseline; NaN once a run has failed.
    """
    grid, polarities = study.grid, study.records.polarities
    gap, force = grid.gaps[case["gap"]], grid.yield_forces[case["yield_force"]]
    level = grid.amplitudes[case.get(grid.measure.axis, 0)]
    motion = driven(motions_of(study)[case["record"]], polarities[case["polarity"]], level)
    gaps, forces = study.interface_gaps(gap), level_forces(study, force)
    samples = np.arange(len(motion.acceleration), dtype=np.float64) * motion.dt
    closings = []
    for law in grid.contact_models:
        run = run_of(study, Case(motion, law, gap, force, gaps, forces))
        point_histories = run["relative_displacement"].transpose("contact_point", "time").values
        closings.append([np.interp(samples, run["time"].values, history, right=nan) for history in point_histories])
    histories = np.array(closings)  # laws, contact points, samples
    indices = [index for index, point in enumerate(study.points) if point.interface == interface]
    largest = np.nanmax(np.abs(histories[grid.contact_models.index(baseline)][indices]), axis=-1)
    point = indices[int(largest.argmax())]
    name = study.interface_names[interface]
    attrs: dict[str, Any] = described("m", "relative displacement of a case of median spread") | {"record": motion.name}
    attrs |= {"polarity": polarities[case["polarity"]], "pga": motion.pga, "gap": float(gaps[interface])}
    attrs |= {"yield_force": float(forces[point]), "interface": name}
    attrs["contact_point"] = "{1:.3g} | {2:.3g}".format(*study.points[point]) if len(study.points) > 1 else name
    return {
        "time": ("time", samples, described("s", "time since the start of the record")),
        "history": (("contact_model", "time"), histories[:, point], attrs),
    }
