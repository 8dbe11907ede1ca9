"""Peaks of two single masses with and without contact over the ratio of their periods and the gap.

`questions.amplification.amplification` is the call that users make.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.counted import counted, size_words
from pounding_risk._common.order import enough_for
from pounding_risk._common.progress import Progress
from pounding_risk.ensemble.chunks import Chunk, by_scene, joined
from pounding_risk.ensemble.job import ScanInput
from pounding_risk.ensemble.limits import check_memory
from pounding_risk.ensemble.pair_job import PairJob
from pounding_risk.ensemble.plausibility import of_input
from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.impulsive import is_instant
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.request import RecordRequest
from pounding_risk.results.attributes import as_text
from pounding_risk.results.variables import described
from pounding_risk.scene.interfaces import known_law
from pounding_risk.scene.records import Records, records_of
from pounding_risk.scene.scene import Scene, scene_of
from pounding_risk.scene.variants import check_one_scene
from pounding_risk.studies.spectra import SIDES, Shaking, spectra_attributes, with_amplitude
from pounding_risk.studies.study import Batches, motion_coordinates
from pounding_risk.units import MASS, PERIOD, Quantity, exact, shown, si

Array = NDArray[np.float64]

RATIO = Quantity("1", 0.0, np.inf, "period ratio", open_low=True, open_high=True, example="0.5")
SHARE = Quantity("1", 0.0, np.inf, "gap share", open_high=True, example="0.5")
MASS_RATIO = Quantity("1", 0.0, np.inf, "mass ratio", open_low=True, open_high=True, example="2")
USUAL_PERIOD = 0.5  # s, of the building that stays, where records are named and no scene
USUAL_MASS = 1e6  # kg: jumps in velocity depend on the ratio of the masses alone
USUAL_MODEL, USUAL_RESTITUTION = "stereomechanical", 0.65  # of records: it takes no stiffness
MOST_BYTES = 4e9  # of the peaks of all runs while their percentiles are taken
COPIES = 6  # of the peaks of one output at that time
# Outputs by the word in the names of the dataset: the peak of a run, and whether a jump in velocity leaves it finite.
PEAKS = {"displacement": "peak_displacement", "acceleration": "peak_floor_acceleration"}
JUMPS_LACK = ("acceleration",)


class Chart(NamedTuple):
    """What the axes of a dataset are."""

    periods: Array  # s, of the building that stays
    ratios: Array  # of the other's period to it, rising
    stays: int  # the building that stays, 0 or 1
    gap_axis: tuple[str, Array]  # its name, "gap" [m] or "gap_share" [1], and values
    gaps: Array  # m, by period, ratio and gap
    reference: Array  # m, by period and ratio: the gap that shares are of
    reference_words: str

    def periods_of(self) -> Array:
        """Periods [s] of both buildings, by period, ratio and building."""
        varied = self.periods[:, None] * self.ratios
        pair_periods = np.stack([varied, np.broadcast_to(self.periods[:, None], varied.shape)], axis=-1)
        return pair_periods if self.stays == 1 else pair_periods[..., ::-1]

    def pairs(self) -> list[tuple[Array, Array]]:
        """Both periods [s] of every pair with its gaps [m], the ratio fastest."""
        periods = self.periods_of().reshape(-1, 2)
        return list(zip(periods, self.gaps.reshape(len(periods), -1), strict=True))


# ----------------------------------------------------------------------------------------------------- the options


def pair_scene(source: Any, mass_ratio: Any) -> Scene:
    """The scene of a pair; of records two masses of this ratio whose velocities jump at a touch.

    Raises PoundingError for motions that were read already, and for a mass ratio beside a scene.
    """
    if isinstance(source, Scene):
        if mass_ratio is not None:
            raise PoundingError("mass_ratio: the scene has the masses of its buildings; change them there")
        check_one_scene(source, "amplification")
        return source
    if not isinstance(source, Records | RecordRequest):
        raise PoundingError(f"{shown(source)} is neither a scene nor records; give a scene or pr.Records")
    request = source.request() if isinstance(source, Records) else source
    ratio = 1.0 if mass_ratio is None else si(mass_ratio, MASS_RATIO, "mass_ratio")
    return scene_of(
        {
            "scene": {"name": "Two single masses"},
            "building": [
                {"name": side, "mass": exact(mass, MASS), "period": exact(USUAL_PERIOD, PERIOD)}
                for side, mass in zip(SIDES, (ratio * USUAL_MASS, USUAL_MASS), strict=True)
            ],
            "interface": [{"gap": "10 mm", "contact_model": USUAL_MODEL, "restitution": USUAL_RESTITUTION}],
            "records": records_of(request).written(),
        }
    )


def staying(name: str, study: Scene) -> int:
    """Which building of a pair stays as it is, by "left", "right" or its name; raises PoundingError."""
    names = [building.name for building in study.buildings]
    for labels in (names, list(SIDES)):
        if name in labels:
            return labels.index(name)
    choices = ", ".join(dict.fromkeys([*SIDES, *names]))
    raise PoundingError(f"fixed: {shown(name)} is no building of the pair; it may be {choices}")


def staying_periods(periods: Any, own_period: float) -> Array:
    """Periods [s] of the building that stays: its own, one, or several; raises PoundingError."""
    periods_tried: Any = own_period if periods is None else periods
    values = [periods_tried] if isinstance(periods_tried, str) or np.ndim(periods_tried) == 0 else list(periods_tried)
    seconds = [si(period, PERIOD, "periods") for period in values]
    if not seconds or len(set(seconds)) < len(seconds):
        raise PoundingError(f"periods: {shown(periods)}; give one period or more, each once")
    return np.array(seconds)


# ------------------------------------------------------------------------------------------------------ the runs


class PairsJob(Batches):
    """The grids of several pairs under the same motions, one after the other."""

    def __init__(self, scenes: Sequence[Scene], motions: tuple[Motion, ...]):
        self.jobs: list[PairJob] = []
        peaks: dict[Any, Any] = {}
        for number, scene in enumerate(scenes):
            job = PairJob(ScanInput(scene, motions))
            job.number, job.free_key, job.peaks = number, PairJob.alone_key(scene), peaks
            if self.jobs:
                job.caches, job.own_kernels = self.jobs[0].caches, self.jobs[0].own_kernels
            else:
                job.own_kernels = job.worth_kernels(len(scenes))
            self.jobs.append(job)
        self.each = self.jobs[0].batches
        self.batches = self.each * len(self.jobs)
        self.bytes_per_batch = self.jobs[0].bytes_per_batch

    def solve(self, batches: range, stop: Callable[[], bool]) -> Chunk | None:
        """Peaks of both buildings, touches and status of these batches; None where it was stopped."""
        chunks: list[Chunk] = []
        for number, scene_batches, _ in by_scene(batches, self.each):
            chunk = self.jobs[number].solve(scene_batches, stop)
            if chunk is None:
                return None
            outputs = self.jobs[number].writer().values(scene_batches, chunk)
            chunks.append({name: outputs[name][:, 0] for name in (*PEAKS.values(), "impact_count", "status")})
        return joined(chunks)


class Responses(NamedTuple):
    """What contact does in all runs; every array is by pair of periods, record, polarity and gap."""

    raised: dict[str, Array]  # by the words of `PEAKS`, and building: peak over that without contact; NaN of a failure
    touched: NDArray[np.bool_]
    failed: NDArray[np.bool_]


def responses(
    study: Scene,
    shaking: Shaking,
    pairs: Sequence[tuple[Array, Array]],
    workers: int | None = None,
    progress: Progress | None = None,
) -> Responses:
    """Run every pair of periods at its gaps under every motion, as a scan of a scene with these numbers.

    Raises PoundingError where the peaks take more than `MOST_BYTES`, and as a scan.
    """
    interface = study.interfaces[0]
    scenes = []
    for periods, gaps in pairs:
        grid = study.grid._replace(gaps=tuple(gaps.tolist()), amplitudes=(None,))
        grid = grid._replace(yield_forces=(interface.yield_force,), contact_models=(interface.contact_model,))
        buildings = (building._replace(period=float(time)) for building, time in zip(study.pair, periods, strict=True))
        scenes.append(study.updated(buildings=tuple(buildings), grid=grid))
    motions = shaking.motions
    shape = (len(pairs), len(motions), len(shaking.polarities), pairs[0][1].size)
    cases = int(np.prod(shape))
    if (needed := 8 * 2 * (len(PEAKS) + COPIES) * cases) > MOST_BYTES:
        raise PoundingError(
            f"num: {cases:,} runs take {size_words(needed)} of memory, more than {size_words(MOST_BYTES)}; take fewer "
            "ratios, gaps, periods or records"
        )
    check_memory(min(scenes, key=lambda scene: min(building.period for building in scene.pair)), motions)
    job = PairsJob(scenes, motions)
    output = job.solved(workers, progress)
    free_peaks = [pair.free_values() for pair in job.jobs]
    touched, failed = output["impact_count"].reshape(shape) > 0, output["status"].reshape(shape) != 0
    raised = {}
    for word, name in PEAKS.items():
        free = np.stack([peaks[name] for peaks in free_peaks]).reshape(*shape[:-1], 1, 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = output[name].reshape(*shape, 2) / free
        ratio = np.where(touched[..., None], ratio, 1.0)
        raised[word] = np.where(failed[..., None], np.nan, ratio)
    return Responses(raised, touched, failed)


# ---------------------------------------------------------------------------------------------------- the dataset


def outputs_of(study: Scene) -> tuple[str, ...]:
    """The words of `PEAKS` that a scene has: a model whose velocities jump has no finite acceleration."""
    jumps = is_instant(known_law(study.interfaces[0].contact_model))
    return tuple(word for word in PEAKS if not (jumps and word in JUMPS_LACK))


def amplification_dataset(
    study: Scene, shaking: Shaking, chart: Chart, peaks: Responses, percentiles: Sequence[float], keep_motions: bool
) -> xr.Dataset:
    """The dataset of all runs: percentiles [%] over records and polarities; with ``keep_motions`` each one's too."""
    name, gaps = chart.gap_axis
    places = (chart.periods.size, chart.ratios.size)
    pair_dims = ("fixed_period", "period_ratio", name)
    dims = (*pair_dims, "building")
    count = counted(len(shaking.motions) * len(shaking.polarities), "motion")
    variables: dict[str, Any] = {}
    for word in outputs_of(study):
        ratio = peaks.raised[word]  # pair, record, polarity, gap, building
        flat = np.moveaxis(ratio.reshape(len(ratio), -1, *ratio.shape[3:]), 1, 0).reshape(-1, *places, gaps.size, 2)
        known = np.isfinite(flat)
        table = enough_for(np.where(known, flat, np.nan), percentiles, axis=0)
        with np.errstate(invalid="ignore"):
            amplified = np.where(known.any(axis=0), (flat > 1.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1), np.nan)
        largest = np.where(known, flat, -np.inf).max(axis=0)
        largest = np.where(np.isfinite(largest), largest, np.nan)
        ratio_text = f"peak {word} with contact over that without"
        several_words = f"{ratio_text}, percentile over {count}; 1 where nothing touches"
        share_words = "share of the motions in which contact raises it"
        variables |= {
            f"{word}_amplification": (("percentile", *dims), table, described("1", several_words)),
            f"{word}_amplification_largest": (dims, largest, described("1", f"{ratio_text}, largest of {count}")),
            f"{word}_amplified": (dims, amplified, described("1", share_words)),
        }
        if keep_motions:
            by_motion = np.moveaxis(ratio, 0, 2).reshape(*ratio.shape[1:3], *places, gaps.size, 2)
            attributes = described("1", f"{ratio_text}, in each motion")
            variables[f"{word}_amplification_of_motion"] = (("record", "polarity", *dims), by_motion, attributes)
    touched = peaks.touched.reshape(*places, -1, gaps.size).mean(axis=2)
    variables["contact_share"] = (pair_dims, touched, described("1", "share of the motions in which they touch"))
    dataset = xr.Dataset(variables, _coordinates(study, shaking, chart, percentiles), spectra_attributes(shaking))
    notes = of_input(study, shaking.motions)
    dataset.attrs |= {
        "title": "Amplification of two buildings by pounding over the ratio of their periods and the gap",
        "source": "pounding_risk: runs of a pair with and without contact",
        "contact_model": study.interfaces[0].contact_model,
        **({"notes": as_text(list(notes))} if notes else {}),
        "failed_runs": int(peaks.failed.sum()),
    }
    return with_amplitude(dataset)


def _coordinates(study: Scene, shaking: Shaking, chart: Chart, percentiles: Sequence[float]) -> dict[str, Any]:
    name, distances = chart.gap_axis
    pair, pair_dims = study.pair, ("fixed_period", "period_ratio")
    names = [building.name for building in pair]
    fixed, varied = names[chart.stays], names[1 - chart.stays]
    masses, dampings = [building.mass for building in pair], [building.damping for building in pair]
    coords: dict[str, Any] = {
        "percentile": ("percentile", list(percentiles), described("%", "share of the motions that have no more")),
        "fixed_period": ("fixed_period", chart.periods, described("s", f"period of {fixed}, which stays")),
        "period_ratio": ("period_ratio", chart.ratios, described("1", f"period of {varied} over that of {fixed}")),
        "building": ("building", names, {"long_name": "building, left to right"}),
        "building_period": ((*pair_dims, "building"), chart.periods_of(), described("s", "period of each building")),
        "building_mass": ("building", masses, described("kg", "mass of the building")),
        "building_damping": ("building", dampings, described("1", "damping ratio of the building")),
        "reference_gap": (pair_dims, chart.reference, described("m", chart.reference_words)),
        **motion_coordinates(shaking.motions, shaking.polarities, shaking.level),
    }
    if name == "gap":
        coords["gap"] = ("gap", distances, described("m", "clear distance at rest"))
    else:
        coords[name] = (name, distances, described("1", f"gap over the {chart.reference_words}"))
        coords["gap"] = ((*pair_dims, name), chart.gaps, described("m", "clear distance at rest"))
    return coords
