"""Which contact to write into a scene: what depends on its stiffness, restitution, yield force and law, and what not.

One value at a time is changed around the scene, over few motions: enough to tell what decides an answer from what does
not, not to assess it. `advice_stiffness` has the range of stiffness and the published rules.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, isnan
from os import cpu_count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.order import evenly
from pounding_risk._common.progress import Progress
from pounding_risk._common.short_repr import ShortRepr
from pounding_risk._common.words import words_of
from pounding_risk.ensemble.scan import RunOptions, Scan
from pounding_risk.ensemble.threads import Threads
from pounding_risk.models.contact.impulsive import is_instant, needs_floors
from pounding_risk.models.contact.law import is_path_dependent
from pounding_risk.models.contact.relation import AS_PUBLISHED
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.contact_points import COLUMN, FLOOR
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.ensemble import MotionEnsemble
from pounding_risk.results.summary import COMPLETE
from pounding_risk.scene.interfaces import NO_RESTITUTION, known_law
from pounding_risk.scene.known_motions import check_computed
from pounding_risk.scene.motions import gathered
from pounding_risk.scene.notes import unused_keys
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene, own_amplitude
from pounding_risk.scene.uncertain import stated
from pounding_risk.studies.advice_stiffness import StiffnessRange, ms, stiffness_range
from pounding_risk.studies.compare import USUAL_TERMS, comparable_models, on_equal_terms, with_damping_relation
from pounding_risk.studies.impact import impact
from pounding_risk.units import FLOOR_LENGTH, GAP, USUAL_FLOOR_LENGTH, YIELD_FORCE, say, shown, si, signed_percent

MOST_MOTIONS = 4  # records that are run, evenly spaced over those of the scene
MULTIPLES = (0.01, 0.1, 1.0, 10.0, 100.0)  # of the scene's stiffness that are run
JUDGED = 10.0  # multiples up to this one, up and down, count for the verdict
RESTITUTIONS = (0.5, 0.65, 0.8)  # the usual 0.5 to 0.75 of concrete and a little beyond
FORCE_SHARES = (0.5, 0.25)  # of the median peak contact force, where the scene's contact does not yield
FORCE_MULTIPLES = (0.5, 2.0, inf)  # of the scene's yield force, where it does
# Laws that dissipate, so that all return the same e; elastic ones differ by that, and jumps have no force.
LAWS = ("kelvin_voigt_tension_cut", "modified_kelvin_voigt", "hertz_damp_exact", "jankowski")
LITTLE, MUCH = 0.05, 0.25  # change of a median from which an output depends somewhat, and depends
NOT, SOMEWHAT, DEPENDS = "does not depend", "somewhat", "depends"
STIFFNESS, RESTITUTION, FORCE, LAW = FACTORS = ("stiffness", "restitution", "F_E", "law")
PROPOSED = "proposed stiffness"  # of all interfaces together, where another one than the scene's is proposed


# Outputs that are judged, of each building and of each interface.
OF_BUILDINGS = words_of("peak_displacement", "peak_storey_shear", "peak_floor_acceleration")
OF_INTERFACES = words_of("peak_contact_force", "impulse", "impact_count")
OUTPUTS = OF_BUILDINGS | OF_INTERFACES
SAME_AS_DISPLACEMENT = "peak_storey_shear"  # of a single mass


@dataclass(frozen=True, repr=False)
class Influence(ShortRepr):
    """Change of one output at one place by one factor, over the cases with contact there."""

    factor: str  # one of `FACTORS`, or `PROPOSED`
    output: str  # one of `OUTPUTS`
    place: str  # building, or "left | right"
    tried: tuple[str, ...]  # the values of the factor, in words
    medians: tuple[float, ...]  # median change of the cases by each, relative to the scene's; NaN where none is defined
    largest: float  # largest change, up or down, of a single case by a value that counts
    counts: tuple[bool, ...]  # which values count for the verdict

    @property
    def _judged(self) -> list[float]:
        """The median changes by the values that count, where they are defined."""
        return [
            median for median, counts in zip(self.medians, self.counts, strict=True) if counts and not isnan(median)
        ]

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest median change by the values that count, 0 among them, as the scene's own is."""
        return min(0.0, *self._judged, 0.0), max(0.0, *self._judged, 0.0)

    @property
    def verdict(self) -> str:
        """`NOT` below 5 %, `SOMEWHAT` up to 25 %, `DEPENDS` above; "" where no change is defined."""
        if not self._judged:
            return ""
        largest = max(map(abs, self.ends))
        return NOT if largest < LITTLE else SOMEWHAT if largest <= MUCH else DEPENDS

    @property
    def range_words(self) -> str:
        """The median changes in per cent: "-60 to +151 %"."""
        low, high = map(signed_percent, self.ends)
        return "0 %" if low == high == "0" else f"{low} to {high} %"

    @property
    def words(self) -> str:
        """The verdict with the changes, and the largest of a single case where that is another class."""
        if not self.verdict:
            return "–"
        stands_out = self.largest > 2.0 * max(*map(abs, self.ends), MUCH)
        case_text = f", one case by {100.0 * self.largest:.0f} %" if stands_out else ""
        return f"{self.verdict}, {self.range_words}{case_text}"

    def facts(self) -> Iterable[tuple[str, str]]:
        """Rows of the short table: the factor, the output with its place, and the verdict."""
        yield "factor", self.factor
        yield "output", f"{OUTPUTS[self.output]}, {self.place}"
        yield "verdict", self.words


class Line(NamedTuple):
    """What to write for one key of an [[interface]], and why; an empty line where there is nothing to write."""

    interface: str  # "" for all
    line: str
    why: str


@dataclass(frozen=True, repr=False)
class Advice(ShortRepr):
    """Advice on the contact of a scene: see `advise`."""

    scene: str
    gap: str  # in words
    motions: tuple[str, ...]  # that were run
    cases: int
    touched: int  # cases with contact anywhere
    lines: tuple[Line, ...]
    ranges: tuple[StiffnessRange, ...]  # of each interface whose law has a stiffness
    influences: tuple[Influence, ...]
    now: dict[tuple[str, str], float]  # median of each output at each place with the scene's contact, where defined
    left_out: tuple[str, ...]  # what does not apply, was not run, or is assumed
    finding: str

    def facts(self) -> Iterable[tuple[str, str]]:
        """The finding and the lines to write."""
        yield "scene", self.scene
        yield "cases", f"{self.cases}, {self.touched} with contact, at a gap of {self.gap}"
        for line in self.lines:
            if not (line.line or line.interface):
                continue
            yield "write", f"{line.line or 'nothing'}{f' ({line.interface})' if line.interface else ''}"
        yield "finding", self.finding

    def influence(self, factor: str, output: str, place: str) -> Influence | None:
        """That of one factor on one output at one place; None where it was not run."""
        return next(
            (one for one in self.influences if (one.factor, one.output, one.place) == (factor, output, place)), None
        )


class Trial(NamedTuple):
    """One factor's scenes: in words what each has in place of the scene's own, and if it counts for the verdict."""

    factor: str
    tried: tuple[str, ...]
    scenes: tuple[Scene, ...]  # of `LAW` one, whose grid has the scene's own law and those that are tried
    counts: tuple[bool, ...]


def advise(
    study: Scene | str | Path,
    *,
    gap: float | str | None = None,
    floor_length: float | str = USUAL_FLOOR_LENGTH,
    progress: Progress | None = None,
) -> Advice:
    """What to write for the contact, and what depends on it.

    Stiffness, restitution, yield force and contact law are changed one at a time, under four records at most, in every
    polarity, at the largest amplitude of the grid and at one gap.

    Parameters
    ----------
    study : Scene or path
        A scene, or the path of its TOML file.
    gap : float or str, optional
        The gap, a number in m or a text with a unit; the scene's own by default.
    floor_length : float or str
        Length of the floors of buildings that give none, of storeys for example: a number in m or a text with a unit.
    progress : callable, optional
        Called with the number of scans done and of all scans.

    Returns
    -------
    Advice
        Lines to write, the range of stiffness of each interface with the published rules, the influences, and what was
        left out.

    Raises
    ------
    PoundingError
        As `scan`, and for a gap or length that cannot be read.
    """
    length = si(floor_length, FLOOR_LENGTH, "advise: floor_length")
    written = as_scene(study)
    study = _scene_of_one_case(written.updated(axes=()), gap)
    check_computed(study, "advise")
    ensemble = gathered(study)
    subset = ensemble._replace(motions=tuple(ensemble.motions[k] for k in evenly(len(ensemble.motions), MOST_MOTIONS)))
    base = _scan_under(study, subset)
    touched = _case_values(base, "impact_count") > 0.0
    strikes = [_hardest_strike(base, study, index) for index in range(len(study.interfaces))]
    ranges = tuple(
        stiffness_range(study, index, study.points[point], speed, length)
        for index, (point, speed) in enumerate(strikes)
        if _has_stiffness(study, index)
    )
    skipped = _factors_not_varied(study)
    fastest = None if LAW in skipped else max(speed for _, speed in strikes)
    trials = _factor_trials(study, base, ranges, fastest) if touched.any() else ()
    runs = _trial_runs(study, base, [trial for trial in trials if trial.factor not in skipped], subset, progress)
    influences = tuple(influence for run in runs for influence in _influences(study, run, touched))
    walls = {band.wall for band in ranges}  # what moves a wall is next to nothing, however much of it
    # Of buildings and interfaces more is read here than by a scan, such as floor_length and equal_terms.
    unused = [words for words in unused_keys(written) if words.startswith(("records.", "grid."))]
    notes = [
        *unused,
        *skipped.values(),
        *stated(study.uncertain, study.axes),
        *_assumptions(study, ensemble, subset, ranges),
        *_notes_on_runs(study, base, runs),
    ]
    return Advice(
        scene=study.name,
        gap=_gap_words(study),
        motions=tuple(motion.name for motion in subset.motions),
        cases=int(base["status"].size),
        touched=int(touched.any(axis=-1).sum()),
        lines=tuple(_interface_lines(study, ranges, influences)),
        ranges=ranges,
        influences=influences,
        now=_output_medians(study, base, touched),
        left_out=tuple(dict.fromkeys(notes)),
        finding=_finding(study, base, [influence for influence in influences if influence.place not in walls]),
    )


# ------------------------------------------------------------------------------------------------ the runs


def _scan_under(study: Scene, ensemble: MotionEnsemble) -> xr.Dataset:
    """The scan of a scene under these motions."""
    return Scan(study, RunOptions(Threads(cpu_count() or 1)), ensemble).in_memory()


class Run(NamedTuple):
    """What came of a trial: the dataset with the scene's own value, and one with each that was tried."""

    trial: Trial
    own: xr.Dataset
    tried: list[xr.Dataset]


def _trial_runs(
    study: Scene, base: xr.Dataset, trials: Sequence[Trial], ensemble: MotionEnsemble, progress: Progress | None
) -> list[Run]:
    """The scans of all trials; ``base`` is that of the scene itself, which is done."""
    report = progress or (lambda done, total: None)
    total, done = 1 + sum(scene is not study for trial in trials for scene in trial.scenes), 1
    report(done, total)
    runs = []
    for trial in trials:
        own, tried = base, []
        for scene in trial.scenes:
            tried.append(base if scene is study else _scan_under(scene, ensemble))
            if scene is not study:
                done += 1
                report(done, total)
        if trial.factor == LAW:
            own, *tried = [tried[0].sel(contact_model=[name]) for name in (study.contact_model, *trial.tried)]
        runs.append(Run(trial, own, tried))
    return runs


def _scene_of_one_case(study: Scene, gap: float | str | None) -> Scene:
    """The scene at one gap and one amplitude, with its own contact."""
    first = study.interfaces[0]
    width = first.gap if gap is None else si(gap, GAP, "advise: gap")
    if gap is None:  # each interface keeps its gap
        name = study.interface_names[0] if len(study.interfaces) > 1 else study.gridded_interface
        study = study.updated(gridded_interface=name)
    elif study.gridded_interface is None:
        study = study.updated(gap=width)
    else:
        index, interfaces = study.interface_names.index(study.gridded_interface), list(study.interfaces)
        interfaces[index] = interfaces[index].updated(gap=width)
        study = study.updated(interfaces=tuple(interfaces))
    grid = study.grid._replace(gaps=(width,), amplitudes=(own_amplitude(study),))
    grid = grid._replace(yield_forces=(first.yield_force,), contact_models=(study.contact_model,))
    return study.updated(grid=grid)


def _factor_trials(
    study: Scene, base: xr.Dataset, ranges: Sequence[StiffnessRange], fastest: float | None
) -> Iterator[Trial]:
    """The scenes of every factor, and with the proposed stiffness where that is another one than the scene's.

    Laws stand on equal terms, at the approach speed of the interface that is struck ``fastest`` [m/s], without
    yielding; None where no other law can be had.
    """
    scenes = []
    for multiple in MULTIPLES:
        stiff = [None if side.stiffness is None else multiple * side.stiffness for side in study.interfaces]
        scenes.append(study if multiple == 1.0 else _with_interface_values(study, stiffness=stiff))
    counts = tuple(1.0 / JUDGED <= multiple <= JUDGED for multiple in MULTIPLES)
    yield Trial(STIFFNESS, tuple(f"× {multiple:g}" for multiple in MULTIPLES), tuple(scenes), counts)

    scenes = [study.updated(restitution=constant(e), restitution_words=f"{e!r}") for e in RESTITUTIONS]
    yield Trial(RESTITUTION, tuple(f"{e:g}" for e in RESTITUTIONS), tuple(scenes), (True,) * len(scenes))

    yield _force_trial(study, base)
    if fastest is not None:
        grid = study.grid._replace(yield_forces=(inf,))
        elastic = _with_column_strengths(study, inf).updated(yield_force=inf, column_yield_force=inf, grid=grid)
        terms = None, None if study.equal_terms else fastest
        equal, _ = with_damping_relation(on_equal_terms(elastic, _other_contact_laws(elastic), None, terms), None)
        names = tuple(name for name in equal.grid.contact_models if name != study.contact_model)
        yield Trial(LAW, names, (equal,), (True,) * len(names))

    if any(band.recommended not in (None, band.own) for band in ranges):
        proposed = {band.interface: band.recommended or band.own for band in ranges}
        names_and_own = zip(study.interface_names, study.interfaces, strict=True)
        scene = _with_interface_values(
            study, stiffness=[proposed.get(name, interface.stiffness) for name, interface in names_and_own]
        )
        yield Trial(PROPOSED, ("as proposed",), (scene,), (True,))


def _force_trial(study: Scene, base: xr.Dataset) -> Trial:
    """Multiples of the scene's yield forces; where it has none, shares of the median peak force of each interface."""
    floors, columns = ([getattr(one, key) for one in study.interfaces] for key in ("yield_force", "column_yield_force"))
    strengths = [building.column_strength for building in study.buildings]
    multiples: tuple[float, ...] = FORCE_MULTIPLES
    tried = ["none" if multiple == inf else f"× {multiple:g}" for multiple in FORCE_MULTIPLES]
    if min(*floors, *columns, *strengths) == inf:
        multiples, tried = FORCE_SHARES, [f"{share:g} of the peak" for share in FORCE_SHARES]
        peaks, touched = _case_values(base, "peak_contact_force"), _case_values(base, "impact_count") > 0.0
        floors = columns = [
            float(np.median(peaks[touches, index])) if touches.any() else inf for index, touches in enumerate(touched.T)
        ]
    scenes = []
    for multiple in multiples:
        scene = _with_interface_values(
            _with_column_strengths(study, multiple),
            yield_force=[multiple * force for force in floors],
            column_yield_force=[multiple * force for force in columns],
        )
        scenes.append(scene.updated(grid=scene.grid._replace(yield_forces=(scene.interfaces[0].yield_force,))))
    return Trial(FORCE, tuple(tried), tuple(scenes), (True,) * len(scenes))


def _with_column_strengths(study: Scene, multiple: float) -> Scene:
    """The scene with a multiple of the column strengths of its buildings; infinite for none."""
    buildings = [
        replace(building, column_strength=multiple * building.column_strength)
        if isinstance(building, Storeys)
        else building
        for building in study.buildings
    ]
    return study.updated(buildings=tuple(buildings))


def _with_interface_values(study: Scene, **of_keys: Sequence[Any]) -> Scene:
    """The scene with other values of some keys of its interfaces, one for each."""
    interfaces = []
    for index, interface in enumerate(study.interfaces):
        interfaces.append(interface.updated(**{key: values[index] for key, values in of_keys.items()}))
    return study.updated(interfaces=tuple(interfaces))


def _other_contact_laws(study: Scene) -> tuple[str, ...]:
    """Those of `LAWS` that can stand in for the scene's own."""
    comparable = comparable_models(study)
    return tuple(name for name in LAWS if name in comparable and name != study.contact_model)


def _factors_not_varied(study: Scene) -> dict[str, str]:
    """The factors that are not varied, each with the sentence that says why."""
    laws = {name: known_law(name) for name in study.models_of(study.contact_model)}
    names = ", ".join(laws)
    jumps = [name for name, law in laws.items() if is_instant(law)]
    sentences = {}
    if jumps and len(jumps) == len(laws):
        finite = all(needs_floors(law) for law in laws.values())
        sentences[STIFFNESS] = f"stiffness: {names} has none, " + (
            "its force is that of waves in the floors"
            if finite
            else "its velocities jump, so that forces and accelerations of a touch are not finite; write "
            'contact_model = "jankowski" and a stiffness to have them'
        )
        sentences[LAW] = f"law: {names} cannot be calibrated to others, for want of a stiffness; see compare"
    if not any(law.needs_restitution for law in laws.values()):
        loops = any(is_path_dependent(law) for law in laws.values())
        elastic = "" if jumps or loops else "; it returns all energy of a touch below yielding"
        sentences[RESTITUTION] = f"restitution: {names} takes none{elastic}"
    if not any(law.capped for law in laws.values()):
        sentences[FORCE] = (
            f"F_E: {names} has no cap, so that F_E does not act; viscous_elastoplastic and van_mier yield"
        )
    if LAW not in sentences and any(interface.restitution.words == NO_RESTITUTION for interface in study.interfaces):
        sentences[LAW] = "law: the scene gives no restitution, which the laws that dissipate need to be compared"
    if LAW not in sentences and (jumps or not _other_contact_laws(study)):
        sentences[LAW] = "law: no other law that dissipates can be calibrated to this scene's; see compare"
    return sentences


def _has_stiffness(study: Scene, index: int) -> bool:
    interface = study.interfaces[index]
    return interface.stiffness is not None and not is_instant(known_law(interface.contact_model))


# ------------------------------------------------------------------------------------------------ what they say


def _case_values(dataset: xr.Dataset, name: str) -> NDArray[np.float64]:
    """Values of a variable (cases, places); NaN where a run failed or a count is not defined."""
    variable = dataset[name].isel(contact_model=0, gap=0, yield_force=0)
    status = dataset["status"].isel(contact_model=0, gap=0, yield_force=0).values.ravel()
    outputs = variable.values.astype(float).reshape(status.size, -1)
    counts = np.issubdtype(variable.dtype, np.integer)
    return np.where((status == COMPLETE)[:, None] & ~(counts & (outputs < 0.0)), outputs, np.nan)


def _hardest_strike(dataset: xr.Dataset, study: Scene, interface: int) -> tuple[int, float]:
    """The contact point of an interface that is struck hardest, floors first, and the median approach speed [m/s].

    That of the fastest touch of each case with contact; without any the speed is that of equal terms. Floors that no
    case strikes come after columns that some case does.
    """
    points = [k for k, point in enumerate(study.points) if point.interface == interface]
    if len(points) > 1:
        forces = np.nan_to_num(_case_values(dataset, "contact_point_peak_contact_force"))
        points = [k for k in points if forces[:, k].any()] or points
        points = [k for k in points if study.points[k].kind == FLOOR] or points
        hardest = max(reversed(points), key=lambda k: float(np.median(forces[:, k])))
    else:
        hardest = points[-1]
    speeds = _case_values(dataset, "peak_approach_speed")[:, interface]
    positive = speeds[speeds > 0.0]
    return hardest, float(np.median(positive)) if positive.size else USUAL_TERMS.speed


def _judged_outputs(study: Scene) -> Iterator[tuple[str, int, str, list[int]]]:
    """Output, index and name of its place, and the interfaces whose contact counts there.

    Without what says nothing new: a rigid building, and the shear of a single mass.
    """
    last = len(study.interfaces)
    for output in OUTPUTS:
        if output in OF_INTERFACES:
            yield from ((output, index, name, [index]) for index, name in enumerate(study.interface_names))
            continue
        for k, building in enumerate(study.buildings):
            if building.is_rigid or (output == SAME_AS_DISPLACEMENT and not isinstance(building, Storeys)):
                continue
            yield output, k, building.name, [index for index in (k - 1, k) if 0 <= index < last]


def _influences(study: Scene, run: Run, touched: NDArray[np.bool_]) -> Iterator[Influence]:
    """The changes of every output by the values that were tried, relative to the scene's own value."""
    trial = run.trial
    for output, k, name, interfaces in _judged_outputs(study):
        is_touched = touched[:, interfaces].any(axis=-1)
        own_values = _case_values(run.own, output)[is_touched, k]
        changes = []
        for dataset in run.tried:
            tried_values = _case_values(dataset, output)[is_touched, k]
            is_known = np.isfinite(own_values) & np.isfinite(tried_values) & (own_values > 0.0)
            changes.append(tried_values[is_known] / own_values[is_known] - 1.0)
        medians = tuple(float(np.median(change)) if change.size else np.nan for change in changes)
        judged = [change for change, counts in zip(changes, trial.counts, strict=True) if counts and change.size]
        largest = max((float(np.abs(change).max()) for change in judged), default=0.0)
        yield Influence(trial.factor, output, name, trial.tried, medians, largest, trial.counts)


def _output_medians(study: Scene, base: xr.Dataset, touched: NDArray[np.bool_]) -> dict[tuple[str, str], float]:
    medians = {}
    for output, k, name, interfaces in _judged_outputs(study):
        outputs = _case_values(base, output)[touched[:, interfaces].any(axis=-1), k]
        outputs = outputs[np.isfinite(outputs)]
        if outputs.size:
            medians[output, name] = float(np.median(outputs))
    return medians


# ------------------------------------------------------------------------------------------------ in words


def _gap_words(study: Scene) -> str:
    return ", ".join(dict.fromkeys(say(gap, GAP) for gap in study.interface_gaps(study.grid.gaps[0])))


def _assumptions(
    study: Scene, ensemble: MotionEnsemble, subset: MotionEnsemble, ranges: Sequence[StiffnessRange]
) -> Iterator[str]:
    """What was not run and what is assumed."""
    count, used_count = len(ensemble.motions), len(subset.motions)
    if used_count < count:
        names = ", ".join(motion.name for motion in subset.motions)
        yield f"records: {used_count} of {count} were run, {names}; the others, gaps and amplitudes are for scan"
    assumed = {name: band.assumed_length for band in ranges for name in band.assumed}
    if assumed:
        single = [b.name for b in study.buildings if b.name in assumed and not isinstance(b, Storeys)]
        repair = f", or write floor_length in [[building]] {' and '.join(single)}" if single else ""
        length = next(iter(assumed.values()))
        yield (
            f"floors of {', '.join(assumed)}: a length of {length:g} m is assumed, and waves of 3500 m/s, concrete; "
            f'give another one with --floor-length "15 m"{repair}'
        )
    for band in ranges:
        if duration := _yielding_duration(study, band):
            yield f"{band.interface}: yielding makes the contact of the scene's stiffness longer, {ms(duration)}"
        if band.wall:
            yield (
                f"{band.interface}: {band.wall} vibrates so fast that no contact is short beside its period; it counts "
                "as a wall, and the range is that of its neighbour"
            )
    if study.effects:
        yield "effects: they act in the runs, not in the isolated impact from which the range follows"


def _notes_on_runs(study: Scene, base: xr.Dataset, runs: Sequence[Run]) -> Iterator[str]:
    """What is to be known of the runs themselves; ``base`` are those of the scene."""
    has_laws = any(run.trial.factor == LAW for run in runs)
    if has_laws and any(known_law(name).capped for name in study.model_names):
        yield "law: set side by side without yielding, which most laws do not have; see F_E for what that changes"
    touched = (_case_values(base, "impact_count") > 0.0).any()
    if not touched and any(_has_stiffness(study, index) for index in range(len(study.interfaces))):
        yield f"approach speed: {USUAL_TERMS.speed:g} m/s is assumed, for want of a contact"
    datasets = [base, *(dataset for run in runs for dataset in run.tried if dataset is not base)]
    failed = sum(int((dataset["status"] != COMPLETE).sum()) for dataset in datasets)
    if failed:
        yield f"runs: {failed} of {sum(dataset['status'].size for dataset in datasets)} failed and count nowhere"


def _yielding_duration(study: Scene, stiffness_range: StiffnessRange) -> float:
    """Duration of the isolated impact under the scene's own law, where it yields in it [s]; else 0."""
    part = study.at(study.interface_names.index(stiffness_range.interface))
    interface = part.interfaces[0]
    columns = [part.column_force(point) for point in interface.points if point.kind == COLUMN]
    force = min(columns) if stiffness_range.is_column else interface.yield_force
    if not known_law(interface.contact_model).capped or force == inf:
        return 0.0
    blow = impact(
        part.law(),
        stiffness_range.speed,
        stiffness_range.mass,
        restitution=interface.restitution.rule,
        yield_force=force,
    )
    return blow.duration if blow.peak_force >= force * (1.0 - 1e-9) else 0.0


def _interface_lines(study: Scene, ranges: Sequence[StiffnessRange], influences: Sequence[Influence]) -> Iterator[Line]:
    """What to write, key by key."""
    own, walls = study.interfaces[0], {band.wall for band in ranges}
    defined = [influence for influence in influences if influence.verdict]
    for band in ranges:
        places, reason = {band.interface, *band.buildings} - walls, band.why
        judged = [influence for influence in defined if influence.factor == STIFFNESS and influence.place in places]
        yield Line(band.interface, band.line, f"{reason}. {_factor_words(judged, '')}" if judged else reason)
    defined = [influence for influence in defined if influence.place not in walls]
    if proposed := [influence for influence in defined if influence.factor == PROPOSED]:
        yield Line("", "", _proposed_stiffness_words(proposed))
    rule, relation = own.restitution.written(), own.restitution.relation
    exact = f'{{value = {shown(rule["value"])}, relation = "exact"}}' if relation != AS_PUBLISHED else shown(rule)
    force_key = "column_yield_force" if own.yield_force == inf and own.column_yield_force < inf else "yield_force"
    force = f'"{say(getattr(own, force_key), YIELD_FORCE)}"' if isfinite(getattr(own, force_key)) else '"inf"'
    for factor, key, setting, consequence in (
        (
            RESTITUTION,
            "restitution",
            exact,
            'run the scene with 0.5 and 0.75 too, or write "concrete", which falls with speed',
        ),
        (
            FORCE,
            force_key,
            force,
            "take it from the crushing of the floor's end, or the shear strength of the column",
        ),
        (LAW, "contact_model", shown(own.contact_model), "set the laws side by side with compare"),
    ):
        if judged := [influence for influence in defined if influence.factor == factor]:
            reason = _factor_words(judged, consequence)
            if len({getattr(interface, key) for interface in study.interfaces}) > 1:
                yield Line("", "", f"{key}, each interface's own: {reason}")
            else:
                yield Line("", f"{key} = {setting}", reason)
    laws = [known_law(name) for name in study.models_of(study.contact_model)]
    if laws and all(is_instant(law) for law in laws):
        yield Line("", f"contact_model = {shown(own.contact_model)}", "an instant impact takes no stiffness")


def _factor_words(judged: Sequence[Influence], consequence: str) -> str:
    """Which outputs depend on a factor, somewhat and not; what follows where one depends."""
    groups = {word: _outputs_by_verdict(judged, word) for word in (DEPENDS, SOMEWHAT, NOT)}
    first = judged[0]
    tried = ", ".join(setting for setting, counts in zip(first.tried, first.counts, strict=True) if counts)
    if not groups[DEPENDS] and not groups[SOMEWHAT]:
        return f"Keep it: the median of no output changes by {100 * LITTLE:.0f} % or more with {tried}"
    clauses = (
        f"it decides {groups[DEPENDS]}{f': {consequence}' if consequence else ''}" if groups[DEPENDS] else "",
        f"it moves {groups[SOMEWHAT]} somewhat" if groups[SOMEWHAT] else "",
        f"it does not move {groups[NOT]}" if groups[NOT] else "",
    )
    return f"Tried {tried}: {'; '.join(filter(None, clauses))}"


def _proposed_stiffness_words(influences: Sequence[Influence]) -> str:
    """What the proposed stiffness changes, each output where it changes most."""
    widest = _widest_influences(influences)
    changes = [
        f"{OUTPUTS[influence.output]} by {signed_percent(influence.medians[0])} % ({influence.place})"
        for influence in widest
        if influence.verdict != NOT
    ]
    steady = ", ".join(OUTPUTS[influence.output] for influence in widest if influence.verdict == NOT)
    small_changes = f"by less than {100 * LITTLE:.0f} %: {steady}" if steady else ""
    return f"The proposed stiffness changes {'; '.join(filter(None, [', '.join(changes), small_changes]))}"


def _widest_influences(influences: Sequence[Influence]) -> list[Influence]:
    """Of each output the influence at the place where it is largest, largest first."""
    widest: dict[str, Influence] = {}
    for influence in sorted(influences, key=lambda influence: -max(map(abs, influence.ends))):
        widest.setdefault(influence.output, influence)
    return list(widest.values())


def _outputs_by_verdict(influences: Sequence[Influence], verdict: str) -> str:
    """The outputs of a verdict with their changes, each judged where it changes most."""
    chosen = [influence for influence in _widest_influences(influences) if influence.verdict == verdict]
    return ", ".join(
        f"{OUTPUTS[influence.output]} ({influence.place}: {influence.range_words})" for influence in chosen
    )


def _finding(study: Scene, base: xr.Dataset, influences: Sequence[Influence]) -> str:
    """What the stiffness decides and what not, or the restitution where there is no stiffness; and the required gap."""
    if not (_case_values(base, "impact_count") > 0.0).any():
        needed = say(float(np.nanmax(base["peak_closing_free"].values)), GAP, 3)
        return (
            f"No contact at a gap of {_gap_words(study)} in any of {counted(int(base['status'].size), 'case')}; "
            f"nothing here depends on the contact; the largest closing is {needed}: to see contact, give a smaller gap"
        )
    alone = len(study.interfaces) == 1
    gap = f"the {'required gap' if alone else 'gap that motion without contact needs'} does not depend on the contact"
    judged = [influence for influence in influences if influence.verdict]
    factor = judged[0].factor if judged else ""
    judged = [influence for influence in judged if influence.factor == factor]
    if factor not in (STIFFNESS, RESTITUTION):
        return f"{study.contact_model} has no stiffness and no restitution to choose; {gap}"
    span = "A stiffness from a tenth to ten times the scene's" if factor == STIFFNESS else "A restitution of 0.5 to 0.8"
    most = max(judged, key=lambda influence: max(map(abs, influence.ends)))
    least = f"{100 * LITTLE:.0f} %"
    if most.verdict == NOT:
        return f"{span} changes no output by {least}; {gap}"
    steady = _outputs_by_verdict(judged, NOT)
    unchanged = f"it does not change {steady}" if steady else f"every output changes by {least} or more somewhere"
    return f"{span} changes {OUTPUTS[most.output]} by {most.range_words} ({most.place}); {unchanged}; {gap}"
