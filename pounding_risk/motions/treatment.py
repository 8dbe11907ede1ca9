"""Treatment of a processed record before a run, in one order: window, polarity, amplitude, tail of zeros.

`read_motion`, the records of a scene and those of a manifest all pass `treated`; nothing else cuts or scales them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from pounding_risk.errors import RecordError
from pounding_risk.motions import scaling
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.processing.window import cut, doubts
from pounding_risk.motions.record import GENERATED, STILL, recording
from pounding_risk.motions.request import AS_RECORDED, REVERSED, RecordRequest, Spectral
from pounding_risk.motions.source import check_shaking


class Treatment(NamedTuple):
    """The treatment of a processed record, in SI; the fields stand in the order in which they act.

    Of ``pga``, ``sa`` and ``to_median`` one at most is given; ``scale`` stands alone or follows ``to_median``
    (`pounding_risk.motions.request.conflicts` has the rule).
    """

    window: tuple[float, float] | None = None  # s; None keeps the whole record
    polarity: str = AS_RECORDED
    pga: float | None = None  # m/s²
    sa: Spectral | None = None
    to_median: str | Spectral | None = None  # of the motions that are treated together
    scale: float | None = None  # factor
    tail: float = 0.0  # s of zeros after the motion, at least


def treatment_of(request: RecordRequest, *, scaled: bool = True) -> Treatment:
    """The treatment that a request asks for, in the records' own polarity; without ``scaled`` the amplitude is kept."""
    if not scaled:
        return Treatment(request.window, tail=request.tail)
    return Treatment(
        request.window,
        pga=request.pga,
        sa=request.sa,
        to_median=request.to_median,
        scale=request.scale,
        tail=request.tail,
    )


def treated(motions: Sequence[Motion], how: Treatment) -> list[Motion]:
    """Apply a treatment to motions, all at once where their median sets the amplitude.

    Parameters
    ----------
    motions : sequence of Motion
        Processed, and turned to the row where that is asked for; the ensemble, where there is a median to reach.
    how : Treatment
        What is done to each of them.

    Returns
    -------
    list of Motion
        The motions as runs take them.

    Raises
    ------
    RecordError
        For a window or tail out of range, a window without shaking, and an amplitude out of reach.
    """
    shaking = [_before_scaling(motion, how) for motion in motions]
    return [_as_seen(motion, how) for motion in _scaled(shaking, how)]


def _before_scaling(motion: Motion, how: Treatment) -> Motion:
    """The window of a motion, in the polarity asked for; raises RecordError where it holds no shaking."""
    where, repair = str(motion.record.get("source") or motion.name), "its processing"
    if how.window is not None:
        motion = motion.after(cut(motion.acceleration, motion.dt, how.window))
        where, repair = f"{where}, {how.window[0]:g} to {how.window[1]:g} s", "its window"
    if not motion.record.get(STILL):
        check_shaking(motion.acceleration, where, repair)
    return motion.reversed() if how.polarity == REVERSED else motion


def _scaled(motions: Sequence[Motion], how: Treatment) -> Sequence[Motion]:
    """The motions times their factors: that to the aim, and the common one after the median."""
    if how.pga is not None:
        motions = [scaling.to_pga(motion, how.pga) for motion in motions]
    if how.sa is not None:
        motions = [_to_spectral(motion, how.sa) for motion in motions]
    if how.to_median is not None:
        motions = _at_median(motions, how.to_median)
    if how.scale is not None:
        motions = [scaling.by_factor(motion, how.scale) for motion in motions]
    return motions


def _to_spectral(motion: Motion, aim: Spectral) -> Motion:
    if aim.value is None:
        raise RecordError("sa: names a period and no value to scale to; give one, such as 0.4 g")
    return scaling.to_spectral_acceleration(motion, aim.value, aim.period, aim.damping)


def _at_median(motions: Sequence[Motion], aim: str | Spectral) -> Sequence[Motion]:
    """The motions scaled to the median of their ensemble; both components of a recording share one factor."""
    measure = f"sa({aim.period!r} s)" if isinstance(aim, Spectral) else aim
    damping = aim.damping if isinstance(aim, Spectral) else 0.05
    groups = [recording(motion.record, motion.name) for motion in motions]
    return scaling.to_median(motions, measure, groups=groups, damping=damping)


def _as_seen(motion: Motion, how: Treatment) -> Motion:
    """The motion with flags about the samples that a run takes, and with the zeros after it."""
    if motion.record.get("state") != GENERATED or how.window is not None:  # which says itself how it starts
        motion = motion.doubted(doubts(motion.acceleration, motion.dt))
    return motion.with_tail(how.tail) if how.tail else motion
