"""Change of the results and computing time by each effect: the scene with none, with each alone, and with all."""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import xarray as xr

from pounding_risk.ensemble.job_choice import job_kind
from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.lab.accuracy_bench import bench_of
from pounding_risk.lab.effects_findings import ALL, COMPARED, NONE, finding
from pounding_risk.models.effects import EFFECTS, acts_on_buildings, acts_on_ground, acts_on_law, refusal
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.results.attributes import as_text
from pounding_risk.results.labels import described
from pounding_risk.scene.interfaces import known_law
from pounding_risk.scene.notes import unused_keys
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene, scene_of
from pounding_risk.scene.tables import Effect
from pounding_risk.scene.variants import check_one_scene
from pounding_risk.studies.study import check_out, saved
from pounding_risk.units import Quantity, parse, si

CASES_TIMED = 24
REPEATS = Quantity("1", 1.0, inf, "number of repetitions", open_high=True, example="5")


def effects(
    study: Scene | str | Path,
    out: str | Path | None = None,
    *,
    repeats: int = 5,
    new: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """What each effect changes in a scene, and what it costs.

    The effects are those of the scene. Where it names none, they are all that act on the ground, or in a row on its
    buildings, or on one of its contact models, with the options of their examples; the attribute ``left_out`` says why
    one that the scene refuses is not among them. An effect that acts on another is switched on with it. Contact models
    that one of the effects does not act on are left out.

    Parameters
    ----------
    study : Scene or path
        A scene, or the path of its TOML file.
    out : path, optional
        File for the dataset, ``.nc``.
    repeats : int
        Timed repetitions, of which the median counts.
    new : bool
        Replace other results under the name ``out``.
    progress : callable, optional
        Called with the number of steps done and of all steps.

    Returns
    -------
    xarray.Dataset
        Along effects and the dimensions of `scan`: the outputs of `COMPARED`, ``yield_exceedance``, ``status``,
        ``acts_on_all`` [1 where the effects also act on cases that do not yield], ``time`` [s of the processor per run,
        every case run] and ``time_ratio``, over the scene without effects. The attribute ``finding`` is a sentence.

    Raises
    ------
    PoundingError
        As `scan`; also, unless ``new``, if ``out`` holds results of another command.
    """
    si(repeats, REPEATS, "effects: repeats")
    target = check_out(out, "effects", new)
    study = as_scene(study)
    check_one_scene(study, "effects")
    laws = study.grid.contact_models
    # Effects of buildings are of rows: a pair would be compared with another solver.
    has_storeys = job_kind(study).has_storeys
    offered = [] if study.effects else [name for name in EFFECTS if has_storeys or not acts_on_buildings(name)]
    unsuited = {name: why for name in offered if (why := _unsuited(study, name))}
    acting = [name for name in offered if name not in unsuited and any(_acts(study, name, law) for law in laws)]
    switched = study.effects or tuple(_example(name) for name in acting)
    kept_laws = tuple(law for law in laws if all(_acts(study, effect.name, law) for effect in switched))
    study = study.updated(grid=study.grid._replace(contact_models=kept_laws))
    scenes = [(name, study.updated(effects=chosen)) for name, chosen in combinations(switched).items()]
    report = progress or (lambda done, total: None)
    scans = []
    for number, (_, scene) in enumerate(scenes):
        scans.append(scan(scene, check_fraction=0.0))
        report(number + 1, len(scenes) + 1)
    times = run_times([scene for _, scene in scenes], repeats)
    report(len(scenes) + 1, len(scenes) + 1)
    dataset = _dataset(scenes, scans, times)
    dataset.attrs |= {"effects": as_text({effect.name: effect.written() for effect in switched})}
    dataset.attrs |= {"unused_keys": as_text(unused_keys(study.updated(effects=switched)))}
    dropped_laws = [law for law in laws if law not in kept_laws]
    reasons = [f"{', '.join(dropped_laws)}: not every effect here acts on it"] if dropped_laws else []
    dataset.attrs["left_out"] = "; ".join([*reasons, *unsuited.values()])
    return saved(dataset, "effects", target, finding=finding(dataset))


def combinations(switched: tuple[Effect, ...]) -> dict[str, tuple[Effect, ...]]:
    """None, each alone with what it acts on, and all together, by the words for it."""
    by_name = {effect.name: effect for effect in switched}
    sets: dict[str, tuple[Effect, ...]] = {NONE: ()}
    for name, effect in by_name.items():
        needs = tuple(by_name.get(needed, Effect(needed)) for needed in EFFECTS[name].needs)
        sets[" + ".join([*(needed.name for needed in needs), name])] = (*needs, effect)
    if len(by_name) > 1 and set(switched) != set(sets[list(sets)[-1]]):
        sets[ALL] = switched
    return sets


def _example(name: str) -> Effect:
    """An effect with the options of its examples: what may be left out is left out, the last word of a choice."""
    kind: Any = EFFECTS[name]
    options = {
        key: parse(allowed.example, allowed) if isinstance(allowed, Quantity) else allowed[-1]
        for key, allowed in kind.options.items()
        if key not in kind.optional
    }
    return Effect(name, tuple(sorted(options.items())))


def _acts(study: Scene, effect: str, label: str) -> bool:
    """True where an effect acts on every contact model that a label of the grid stands for."""
    return not any(refusal(known_law(name), effect) for name in study.models_of(label))


def _unsuited(study: Scene, effect: str) -> str:
    """Why the example of an effect has no place in a scene that names none; "" where it has."""
    if not acts_on_ground(effect) and not acts_on_buildings(effect):
        return ""
    if effect == "inelastic_storeys" and not any(building.strengths for building in study.buildings):
        return "inelastic_storeys: no building gives storey_strengths"
    try:
        for building in study.buildings if acts_on_buildings(effect) else ():
            chain_of(building, (_example(effect),))
    except PoundingError as error:
        return str(error)
    try:  # the scene's own checks, which refuse soil where velocities jump
        scene_of({**study.resolved(), "effects": {effect: _example(effect).written()}})
    except SceneError as error:
        # Without the effect the scene has no fault: any fault is of the effect.
        return next((fault for fault in error.faults if effect in fault), f"{effect}: {error.faults[0]}")
    return ""


def run_times(scenes: list[Scene], repeats: int) -> np.ndarray:
    """Processor time of one run [s] under each scene, (scenes, repeats); the scenes take turns."""
    benches = [bench_of(scene, CASES_TIMED) for scene in scenes]
    times = np.zeros((len(scenes), repeats))
    for number in range(-1, repeats):  # the first round compiles and warms the caches
        for row, (bench, scene) in enumerate(zip(benches, scenes, strict=True)):
            outcome = bench.event(scene.rtol)
            if number >= 0:
                # The motion without contact is common to all cases of a record.
                times[row, number] = outcome.seconds - (outcome.free_seconds * len(bench.motions) / bench.size)
    return times


def _dataset(scenes: list[tuple[str, Scene]], scans: list[xr.Dataset], times: np.ndarray) -> xr.Dataset:
    names = [name for name, _ in scenes]
    variables = [*COMPARED, "yield_exceedance", "status"]
    dataset = xr.concat([scan[variables] for scan in scans], dim="effects", combine_attrs="override")
    dataset = dataset.assign_coords(effects=("effects", names, {"long_name": "effects that act"}))
    medians = np.array([median(row) for row in times])
    dataset["time"] = ("effects", medians, described("s", "processor time of one run"))
    acts_on_all = [any(not acts_on_law(effect.name) for effect in scene.effects) for _, scene in scenes]
    words = "1 where the effects act on cases that do not yield, too"
    dataset["acts_on_all"] = ("effects", np.array(acts_on_all, dtype=np.int8), described("1", words))
    words = "time of one run over that without effects"
    dataset["time_ratio"] = ("effects", medians / medians[0], described("1", words))
    dataset.attrs = {key: attribute for key, attribute in scans[0].attrs.items() if key != "scene_resolved"}
    dataset.attrs["references"] = "; ".join(dict.fromkeys(scan.attrs["references"] for scan in scans))
    return dataset
