"""What the jobs of all scenes share: the grid as batches, the tolerance check, and the template of the dataset.

A subclass has the compiled solver: how a motion without contact is computed, how a batch is solved, and what the chunks
of its results hold.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Hashable, Mapping
from functools import cached_property
from math import prod
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.once import Shared
from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.ensemble.job import Job, ScanInput, never
from pounding_risk.ensemble.tolerance_check import check_variables, drawn, not_recomputed, recomputed
from pounding_risk.models.ground import accelerations
from pounding_risk.motions.levels import driven
from pounding_risk.motions.motion import Motion
from pounding_risk.results import labels
from pounding_risk.results.layout import AMPLITUDE, AXES, CaseVariable, Slab, Template, bytes_per_case, slabs
from pounding_risk.results.tolerance_check import tighter
from pounding_risk.results.variables import own_dims
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.counters import USUAL_SENTENCES

Place = tuple[int, ...]  # record, polarity, amplitude
Array = NDArray[np.float64]
HOW = "simulated"
FREE_RESPONSES = 128  # motions whose response without contact is kept, some hundred kB each
RECORD_BYTES = 60 * 8  # of the spectrum of a record


class Sizes(NamedTuple):
    """Bytes of the variables of a dataset, before compression; coordinates, some bytes a label, are not counted."""

    case: int  # of a case, with the variables of the tolerance check
    motion: int  # of a record, polarity and amplitude: its response without contact
    chunk: int  # of a case in a chunk
    record: int = RECORD_BYTES

    def of(self, shape: Mapping[str, int]) -> int:
        """Size of a dataset with so many values along each of its axes."""
        # Along an axis of another number of the scene the motion without contact may change.
        motions = prod(size for axis, size in shape.items() if axis not in AXES[AMPLITUDE + 1 :])
        return self.case * prod(shape.values()) + self.motion * motions + self.record * shape["record"]


def peaks_under(study: Scene, motion: Motion) -> Array:
    """The peak of a_g under each building of a scene, in a motion as it drives them [m/s²]."""
    ground = accelerations(study.supports, motion.acceleration, motion.own_grounds)
    return np.broadcast_to(np.abs(ground).max(axis=-1), len(study.buildings))


class GridJob(Job):
    """The grid of a scene; see `job.Job`."""

    solver: ClassVar[str]  # its name
    has_storeys: ClassVar[bool]  # whether it runs effects that act on buildings
    at_once: ClassVar[int] = 1  # batches in one call of the solver

    def __init__(self, scan_input: ScanInput, laws: tuple[tuple[Any, ...], ...], places: tuple[Array, Array]):
        """``laws`` are by contact model and interface, ``places`` the arguments of `labels.places_of`."""
        study = self.study = scan_input.study
        self.scan_input, self._laws, self._places = scan_input, laws, places
        grid, motions = study.grid, len(scan_input.motions)
        self.motions_shape = (motions, len(study.records.polarities), len(grid.amplitudes))
        self.shape = (*self.motions_shape, len(laws), len(grid.gaps), len(grid.yield_forces))
        self.batches, self.width = int(np.prod(self.shape[:-1])), self.shape[-1]
        self.bytes_per_batch = self.width * self.sizes(study).chunk
        # Responses without contact. Jobs of one scan that differ in numbers of the scene share these caches, and find
        # in them what follows from their ``free_key`` alone.
        self.number = 0  # of the scene among the scenes of a scan
        self.free_key: Hashable = None
        self.caches: dict[str, Shared[Any]] = {}
        self.peaks: dict[Hashable, Any] = {}  # by `free_key` and motion

    @classmethod
    def unsolved(cls, study: Scene, law_name: str) -> str:
        """Why its solver cannot run a contact model in a scene; "" where it can."""
        return ""

    @classmethod
    @abstractmethod
    def outputs(cls, study: Scene) -> dict[str, Any]:
        """Every output of a case, with its unit and words, and ``whole`` of a count or flag."""

    @classmethod
    @abstractmethod
    def free_outputs(cls, study: Scene) -> dict[str, Any]:
        """The outputs that a motion without contact has too."""

    @classmethod
    @abstractmethod
    def sizes(cls, study: Scene) -> Sizes:
        """Sizes of the dataset of a study."""

    @classmethod
    @abstractmethod
    def closing(cls, study: Scene) -> Callable[[Motion], tuple[Array, Any]]:
        """A function of a motion without contact: how far it closes the tightest gap [m], by gap of the grid.

        It also returns the arrays of the response that a scan keeps.
        """

    @classmethod
    @abstractmethod
    def alone_key(cls, study: Scene) -> Hashable:
        """All values of a scene that its motions without contact depend on, beside the ground motions."""

    @classmethod
    def held_bytes(cls, motions: int, size: int) -> int:
        """Memory that the responses without contact to so many motions take, ``size`` bytes each."""
        return min(motions, FREE_RESPONSES) * size

    @abstractmethod
    def free(self, motion: Place) -> Any:
        """The response without contact to a motion of the grid."""

    @abstractmethod
    def solved(self, batches: range, stop: Callable[[], bool]) -> tuple[Chunk, NDArray[np.bool_]] | None:
        """Results of these batches, and which cases have a complete run of their own; None where ``stop`` was true."""

    @abstractmethod
    def repeated(self, slab: Slab, strength: int, rtol: float) -> Any:
        """The run of one case, made at another tolerance."""

    @abstractmethod
    def moves(self, chunk: Chunk, places: NDArray[np.bool_], repeated_runs: list[Any]) -> Mapping[str, Array]:
        """How far each run at ``places`` (batches, yield forces) moves to the one `repeated`, by output."""

    @abstractmethod
    def free_values(self) -> dict[str, Array]:
        """Values of `free_outputs` by record, polarity, amplitude and their own dimensions."""

    def ground(self, motion: Place) -> Motion:
        """A motion of the grid in its polarity and amplitude."""
        record, polarity, amplitude = motion
        study = self.study
        level = study.grid.amplitudes[amplitude]
        driving = driven(self.scan_input.motions[record], study.records.polarities[polarity], level)
        return driving.reaching(study.lag)  # along an axis it differs from that of ``scan_input.motions``

    def peaks_under(self) -> Array:
        """The peak of a_g under each building, by motion of the grid (record, polarity, amplitude, building) [m/s²]."""
        key = "a_g", self.study.supports
        if key not in self.peaks:
            peaks = [peaks_under(self.study, self.ground(motion)) for motion in np.ndindex(self.motions_shape)]
            self.peaks[key] = np.array(peaks).reshape(*self.motions_shape, -1)
        return self.peaks[key]

    def law_at(self, batch: int) -> int:
        return batch // self.shape[-2] % self.shape[-3]

    def solve(self, batches: range, stop: Callable[[], bool] = never) -> Chunk | None:
        """Results of these batches, and how far runs that are repeated move."""
        results = self.solved(batches, stop)
        if results is None:
            return None
        chunk, is_own = results
        if self.scan_input.check_fraction == 0.0:
            return chunk
        checked = self.checked(batches, chunk, drawn(batches, is_own, self.scan_input.check_fraction), stop)
        return None if checked is None else chunk | checked

    def slabs(self, batches: range) -> list[Slab]:
        """The batches as the solver takes them."""
        return list(slabs(batches, self.shape, self.at_once))

    def checked(
        self, batches: range, chunk: Chunk, places: NDArray[np.bool_], stop: Callable[[], bool]
    ) -> Chunk | None:
        """Repeat the runs at ``places`` (batches, yield forces) at the tighter tolerance, without screening."""
        if not places.any():
            return not_recomputed((len(batches), self.width))
        repeated_runs, rtol = [], self.study.rtol
        for batch, strength in np.argwhere(places):
            if stop():
                return None
            (slab,) = slabs(range(batches.start + batch, batches.start + batch + 1), self.shape, 1)
            repeated_runs.append(self.repeated(slab, int(strength), tighter(rtol)))
        return recomputed(places, self.moves(chunk, places, repeated_runs), rtol)

    own_kernels = False  # whether contact laws get kernels with their own code

    def worth_kernels(self, scenes: int) -> bool:
        """Whether contact laws should get such kernels, where so many scenes have such a grid."""
        return False

    def coordinates(self, whole: bool = False) -> dict[str, Any]:
        """Interfaces, contact points, buildings and storeys, with facts on each; as `labels.places_of`."""
        places = labels.places_of(self.study, *self._places, whole=whole)
        if not whole:
            return places
        key = "widenings", self.study.supports  # computed once for all scenes with equal grounds
        if key not in self.peaks:
            self.peaks[key] = labels.ground_widenings(self.study, self.scan_input.motions)
        return places | self.peaks[key]

    def numbers(self) -> dict[str, str]:
        """Attributes that differ along an axis of another number of the scene."""
        return labels.numbers_of(self.study, self._laws)

    @property
    def check_names(self) -> tuple[str, ...]:
        """Names of the variables of the tolerance check; none where no run is repeated."""
        return tuple(check_variables(self.study.rtol)) if self.scan_input.check_fraction > 0.0 else ()

    @cached_property
    def template(self) -> Template:
        study, motions = self.study, self.scan_input.motions
        peaks = self.free_values()
        free_variables = {name: (output, peaks[name]) for name, output in self.free_outputs(study).items()}
        skeleton = labels.skeleton(study, motions, free_variables, self.coordinates())
        skeleton = skeleton.assign_attrs(labels.attributes(study, motions, self._laws, self.solver))
        checks = check_variables(study.rtol)
        return Template(skeleton, self.variables(study) | {name: checks[name] for name in self.check_names}, self.shape)

    @classmethod
    def variables(cls, study: Scene) -> dict[str, CaseVariable]:
        """Every case variable of a study, except those of the tolerance check."""
        cases = {name: labels.case_variable(name, output) for name, output in cls.outputs(study).items()}
        return cases | labels.OUTCOME | {"status": labels.status_variable(cls.endings(study))}

    @classmethod
    def endings(cls, study: Scene) -> dict[int, str]:
        """How a run may end, by the code of its status."""
        return USUAL_SENTENCES

    @classmethod
    def sizes_along(cls, study: Scene, lengths: Mapping[str, int], chunk: int = 0) -> Sizes:
        """Sizes from the lengths of the places; a case in a chunk is by default as large as in the dataset."""
        case = bytes_per_case(cls.variables(study) | check_variables(study.rtol), lengths)
        free = (f"{name}_free" for name in cls.free_outputs(study))
        motion = 8 * sum(prod(lengths[dim] for dim in own_dims(name)) for name in free)
        return Sizes(case, motion, chunk or case)
