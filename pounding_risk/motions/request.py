"""The request of a scene for ground motions, its table [records] in SI: which records, and how they are treated."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

from pounding_risk.motions.generated import Recipe
from pounding_risk.motions.processing import Step
from pounding_risk.motions.sites.places import Place
from pounding_risk.units import DAMPING, PERIOD, PGA, exact

AS_RECORDED, REVERSED = "as recorded", "reversed"
POLARITIES = (AS_RECORDED, REVERSED)
MEDIANS = ("pga", "pgv")  # what records can be brought to the ensemble's median of, beside Sa at a period
SOURCES = ("names", "files", "set", "manifest", "generated", "sites")  # a request has one of them
AMPLITUDES = ("manifest", "sites", "pga", "sa", "to_median")  # what sets the amplitude: one of them at most
INTENSITY = "intensity"  # levels of the grid, which a request does not hold; they set it too


class Spectral(NamedTuple):
    """Spectral acceleration at a period, with the value to reach where one is requested."""

    period: float  # s
    damping: float = 0.05
    value: float | None = None  # m/s²

    def written(self) -> dict[str, Any]:
        """The table as a scene file has it."""
        table = {} if self.value is None else {"value": exact(self.value, PGA)}
        return {**table, "period": exact(self.period, PERIOD), "damping": exact(self.damping, DAMPING)}


class RecordRequest(NamedTuple):
    """Which ground motions a scene uses, and how they are treated before a run."""

    names: tuple[str, ...] = ()  # ids of the catalogue
    files: tuple[str, ...] = ()  # names, patterns or folders, relative to the scene file's folder
    window: tuple[float, float] | None = None  # s; None keeps the whole record
    pga: float | None = None  # m/s²; None leaves the amplitude to the other ways of scaling
    scale: float | None = None  # factor; None where neither is given: as recorded
    polarities: tuple[str, ...] = (AS_RECORDED,)  # of POLARITIES
    processing: str | tuple[Step, ...] = "auto"  # or "none", or the steps in their order
    tail: float = 0.0  # s of free vibration after the record, at least
    set: str = ""  # name of a record set
    manifest: str = ""  # a list of records with their factors, relative to the scene file's folder
    unit: str = ""  # of files that do not state theirs, such as "cm/s^2"
    dt: float | None = None  # s, likewise
    direction: float | None = None  # of the row, degrees clockwise from north; None takes components as they are
    sa: Spectral | None = None  # every record is scaled to this spectral acceleration
    to_median: str | Spectral | None = None  # one of MEDIANS, or Sa at a period: every record to the ensemble's median
    generated: tuple[Recipe, ...] = ()  # motions that are no records
    sites: str = ""  # a grid of sites with their motions (`sites.event_grid`), relative to the scene file's folder
    place: Place | None = None  # where the row stands; the motions are those of the nearest site
    aftershock: tuple[str, ...] = ()  # a record that follows each motion: one for all, or one for each
    pause: float = 60.0  # s of still ground between the two
    aftershock_ratio: float | None = None  # of its PGA to that of the motion before; None keeps both as recorded
    both: bool = False  # whether the component across the direction stands beside each motion

    def given(self) -> tuple[str, ...]:
        """The keys of source, direction and amplitude that are given."""
        keys = dict.fromkeys((*SOURCES, "direction", *AMPLITUDES, "scale"))
        return tuple(key for key in keys if getattr(self, key) not in (None, "", ()))

    def unscaled(self) -> RecordRequest:
        """The request of the same records at their own amplitude."""
        return self._replace(pga=None, scale=None, sa=None, to_median=None)


def conflicts(keys: Collection[str], *, grid_pga: bool = False, is_factor: bool = False) -> Iterator[tuple[str, str]]:
    """Keys of [records] that exclude each other: the key that is to go, and a sentence.

    ``keys`` are those that are given, in a scene file or in a call, with `INTENSITY` where the grid has levels of
    intensity; with ``is_factor`` these are factors, which act as ``scale`` does. ``grid_pga``: the grid has amplitudes.
    """
    sources = [key for key in SOURCES if key in keys]
    if len(sources) > 1:
        hint = " (the file of a record in the catalogue can stand in files)" if sources == ["names", "files"] else ""
        yield sources[-1], f"{' and '.join(sources)} are both given; keep one{hint}"
    if "manifest" in keys and "direction" in keys:
        yield "direction", "a manifest names single components; remove direction, or name the files"
    if "generated" in keys and "direction" in keys:
        yield "direction", "a generated motion has one component, along the row; remove direction"
    factor = INTENSITY if is_factor else "scale"
    amplitudes = [key for key in (*AMPLITUDES, *([] if is_factor else [INTENSITY])) if key in keys]
    if len(amplitudes) > 1 and not set(amplitudes) <= set(SOURCES):
        several = "both" if len(amplitudes) == 2 else "all"
        words = " and ".join(amplitudes)
        yield amplitudes[-1], f"{words} are {several} given, and each sets the amplitude; keep one"
    # A common factor may follow the median or a choice: that is how a normalised set is scaled.
    rivals = [key for key in amplitudes if key in ("pga", "sa", INTENSITY)]
    both = "are both given, and each sets the amplitude; remove one"
    if INTENSITY in keys and "scale" in keys:
        yield "scale", f"{INTENSITY} and scale {both}"
    elif rivals and factor in keys:
        yield factor, f"{rivals[0]} and {factor} {both}"
    elif grid_pga:
        for key in ("scale", "sa", "to_median", "manifest", "sites", INTENSITY):
            if key in keys:
                yield key, f"the grid has a pga, which sets the amplitude; remove {key}, or pga from [grid]"
