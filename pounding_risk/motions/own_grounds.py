"""Records beside and behind a motion: those of single buildings, and aftershocks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.models.ground import divided
from pounding_risk.motions.catalogue import is_file
from pounding_risk.motions.ensemble import read_ensemble
from pounding_risk.motions.generated import is_recipe
from pounding_risk.motions.motion import Motion, after_cut, seconds_after
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.motions.record import AFTERSHOCK, BESIDE, OF_BAND, OF_DIRECTION, OF_ORIGIN, OF_RECORDING, OWN_STEP
from pounding_risk.motions.request import RecordRequest
from pounding_risk.motions.rotation import OFF_GRID

WHOLE = 1e-9  # of a ratio of two time steps: so close to a whole number is one


def read_own(name: str, request: RecordRequest, folder: Path) -> Motion:
    """A record by its name, processed, turned and cut as ``request`` has it for all others, and not scaled.

    The name is an id of the catalogue, a generated motion as text, or a file below ``folder``; with a direction of the
    row two ids joined by "+", or a pattern that two files or components answer to. What the request says of source and
    amplitude plays no part. Raises RecordError as `read_ensemble`, and where the name is not that of one motion.
    """
    ids = (name,) if is_recipe(name) else tuple(name.split("+"))
    names, files = ((), (name,)) if is_file(name) else (ids, ())
    unscaled = request.unscaled()
    alone = unscaled._replace(names=names, files=files, set="", manifest="", generated=(), sites="", place=None)
    motions = read_ensemble(alone, folder).motions
    if len(motions) != 1:
        listed = f"it is {', '.join(motion.name for motion in motions)}" if motions else "nothing answers to it"
        raise RecordError(f"{name}: one record is needed here, and {listed}; name one file or component")
    return motions[0]


class _Laid(NamedTuple):
    """A record on the samples of several: as many steps of these make one of its own, and as many zeros come first."""

    record: Motion
    parts: int
    before: int

    @property
    def reach(self) -> int:
        """The number of these samples up to its end."""
        return self.before + (self.record.acceleration.size - 1) * self.parts + 1

    def drawn(self, count: int) -> Samples:
        """Its samples [m/s²] between zeros, so many in all."""
        samples = divided(self.record.acceleration, self.parts) if self.parts > 1 else self.record.acceleration
        return np.pad(samples, (self.before, count - self.reach))


def _laid(records: Sequence[Motion], dt: float) -> list[_Laid]:
    """Records on samples every ``dt`` [s]. What begins later than others follows zeros."""
    steps = [round(_begins(records[0], record) / dt) for record in records]
    before = [step - min(steps) for step in steps]
    return [_Laid(record, _parts(record, dt, records), zeros) for record, zeros in zip(records, before, strict=True)]


def _begins(motion: Motion, record: Motion) -> float:
    """How long after a motion a record begins [s]: by the starts that both state if they overlap then, else together.

    Together but for what was cut of each, or put before it.
    """
    later = seconds_after(motion.record, record.record)
    return later if -record.duration < later < motion.duration else _cut_after(motion, record)


def _cut_after(motion: Motion, record: Motion) -> float:
    """How long after a motion a record begins [s] that begins together with it, but for what was cut of each."""
    return float(record.record.get("cut_from_start", 0.0)) - float(motion.record.get("cut_from_start", 0.0))


def _doubts_of_start(motion: Motion, record: Motion, dt: float) -> list[str]:
    """Flags of a record that begins at another time than the motion, by their starts, on samples every ``dt`` [s]."""
    later, doubts = _begins(motion, record), []
    if abs(later - _cut_after(motion, record)) > 0.5 * dt:
        side = f"{abs(later):.4g} s {'after' if later > 0.0 else 'before'} {motion.name}"
        doubts.append(f"{record.name}, beside it: begins {side}, by the starts of both; the later one follows zeros")
    if (off := abs(later - round(later / dt) * dt)) > OFF_GRID * dt:
        doubts.append(f"{record.name}, beside it: is sampled {1e3 * off:.2g} ms apart, and was not interpolated")
    return doubts


def set_beside(motion: Motion, records: Sequence[Motion | None]) -> Motion:
    """The motion, scaled, with the records of single buildings beside it, on the samples of all of them.

    ``records`` has one by building, not scaled, None where it stands on ``motion``. Every record gets the factor of
    the motion. Of unlike time steps one has to be a whole multiple of the other, else RecordError: the coarser record
    is then divided on the straight lines between its samples, which changes nothing of it. Where both state when they
    start, and overlap then, they are at these times, to the nearest sample, else they begin together; zeros come before
    the later ones and after those that end first. A record that is the motion itself, to the bit, is none of its own.
    """
    others = [record for record in records if record is not None]
    dt = min(record.dt for record in (motion, *others))
    laid = _laid([motion, *others], dt)
    main, count = laid[0], max(one.reach for one in laid)
    shared, factor = main.drawn(count), motion.record.get("factor", 1.0)
    drawn = iter([factor * one.drawn(count) for one in laid[1:]])
    scaled = [None if record is None else next(drawn) for record in records]
    own_samples = tuple(None if samples is None or np.array_equal(samples, shared) else samples for samples in scaled)
    for samples in own_samples:
        if samples is not None:
            samples.flags.writeable = False
    sentences = [f"beside it: {record.name}, times {factor:g}" for record in others]
    if main.parts > 1:
        sentences.append(f"time step {motion.dt:g} s divided by {main.parts}, on straight lines")
    late = [one for one in laid if one.before]
    sentences += [f"zeros before {one.record.name} up to {one.before * dt:g} s, where it begins" for one in late]
    if count > main.reach:
        sentences.append(f"zeros up to {(count - 1) * dt:g} s, where the longest record beside it ends")
    beside = [{"building": place, **_facts(record)} for place, record in enumerate(records) if record is not None]
    flags = [f"{record.name}, beside it: {flag}" for record in others for flag in record.flags]
    flags += [doubt for record in others for doubt in _doubts_of_start(motion, record, dt)]
    return replace(
        motion,
        acceleration=shared,
        dt=dt,
        record={**after_cut(motion.record, -main.before * dt), OWN_STEP: motion.dt, BESIDE: beside},
        processing=(*motion.processing, *sentences),
        own_grounds=own_samples if any(samples is not None for samples in own_samples) else (),
        tail=count - main.reach + motion.tail * main.parts,
    ).doubted(flags)


def followed_by(motion: Motion, aftershock: Motion, pause: float, ratio: float | None, tail: float) -> Motion:
    """The motion, scaled, still ground, and an aftershock, not scaled, as one motion; time steps as in `set_beside`.

    ``pause`` [s] is from the last sample of the motion to the first of the aftershock, rounded up to whole time steps;
    zeros after the motion are part of it. ``ratio`` is the PGA of the aftershock over that of the motion; None gives it
    the factor of the motion. ``tail`` [s] of zeros follow.
    """
    motion = motion.without_tail()
    dt = min(motion.dt, aftershock.dt)
    steps, steps_after = (_parts(record, dt, [motion, aftershock]) for record in (motion, aftershock))
    before, after = divided(motion.acceleration, steps), divided(aftershock.acceleration, steps_after)
    factor = motion.record.get("factor", 1.0) if ratio is None else ratio * motion.pga / aftershock.pga
    # The factor over that of the motion, and the PGA before it: amplitudes of a grid scale the sequence later on.
    scaled = {"times": factor / motion.record.get("factor", 1.0), "pga": aftershock.pga}
    still = np.zeros(max(ceil(pause / dt - WHOLE) - 1, 1))
    begins = (before.size + still.size) * dt
    across = motion.across
    if across is not None and aftershock.across is not None:
        across = np.concatenate([divided(across, steps), still, factor * divided(aftershock.across, steps_after)])
    joined = replace(
        motion,
        acceleration=np.concatenate([before, still, factor * after]),
        across=across,
        dt=dt,
        record={**motion.record, OWN_STEP: motion.dt, AFTERSHOCK: _facts(aftershock) | scaled},
        processing=(*motion.processing, f"followed from {begins:g} s on by {aftershock.name}, times {factor:.6g}"),
        tail=0,
        late=0,
    ).doubted([f"{aftershock.name}, after it: {flag}" for flag in aftershock.flags])
    if factor * aftershock.pga > (1.0 + WHOLE) * motion.pga:
        joined = joined.doubted([f"its aftershock is stronger: PGA and spectra are those of {aftershock.name}"])
    return joined.with_tail(tail) if tail else joined


def _facts(record: Motion) -> dict[str, Any]:
    """The facts that it takes to find a record again, to know its recording, and to doubt it for some buildings."""
    facts = record.record
    known = {key: facts[key] for key in (*OF_RECORDING, *OF_DIRECTION, *OF_BAND, *OF_ORIGIN) if key in facts}
    found_again = {key: str(facts.get(key, "")) for key in ("source", "sha256")}
    return {**known, "name": record.name, **found_again, OWN_STEP: record.dt}


def _parts(record: Motion, dt: float, motions: Sequence[Motion]) -> int:
    """How many steps ``dt`` [s] a time step of the record is; raises RecordError where these are no whole number."""
    ratio = record.dt / dt
    if abs(ratio - round(ratio)) > WHOLE * ratio:
        finest = next(motion for motion in motions if motion.dt == dt)
        raise RecordError(
            f"{record.name}: its time step of {record.dt:g} s is no whole multiple of the {dt:g} s of {finest.name}, "
            "in the same run; resample one of them, such as with "
            f'processing = [{{step = "resample", dt = "{dt:g} s"}}]'
        )
    return round(ratio)
