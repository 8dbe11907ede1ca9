"""The steps that turn a recorded acceleration into the input of a run: one function each, in one registry.

A step takes samples [m/s²] and the time step [s] and gives new samples and a sentence that says what it did.
A scene or a script asks for steps by name, ``[{"step": "mean"}, {"step": "bandpass", "low": "0.1 Hz"}]``;
`read_steps` turns that into steps with options in SI, or says what is wrong. To add a step is to write one
function under ``@step``.

Nothing here scales: that comes last, in `pounding_risk.motions`, on the samples that a run really sees.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from math import ceil, floor, inf
from typing import Any, NamedTuple

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.quantities import (
    TIME,
    Quantity,
    QuantityError,
    article,
    bounds,
    parse,
    repair,
    say,
    shown,
)
from pounding_risk.signals import Samples, butterworth, cosine_rise, onset, velocity_displacement

CORNER = Quantity("Hz", 0.0, inf, "corner frequency", example="0.1 Hz")
ORDER = Quantity("1", 1.0, 20.0, "order", example="5")

PRE_EVENT, WHOLE = "pre-event", "whole"
SHORTEST_PRE_EVENT = 1.0  # s: a mean over less says little about the baseline
PICK_MARGIN = 0.5  # s before the picked onset: an emergent first arrival starts before it is seen
LONGEST_LEAD, LONGEST_TAIL = 1.0, 5.0  # s of taper
LOW_CORNER = 0.08  # Hz, gmprocess' fallback where the noise says nothing
HIGHEST_CORNER, NYQUIST_SHARE = 40.0, 0.75  # Hz; of the Nyquist frequency
DRIFT_OF_PEAK = 0.05  # |d_end|/PGD and |v_end|/PGV above this are flagged
ENDS_OF_PEAK = 0.02  # |a| at the ends above this part of PGA is flagged


class Done(NamedTuple):
    """What a step gives: samples, its sentence, doubts, and how many samples it cut from the start."""

    samples: Samples
    sentence: str
    flags: tuple[str, ...] = ()
    cut: int = 0


class Step(NamedTuple):
    """A step asked for: its name and its options in SI."""

    name: str
    options: dict[str, Any]

    def apply(self, samples: Samples, dt: float) -> Done:
        """The step done to ``samples`` [m/s²] at every ``dt`` [s]."""
        return STEPS[self.name].function(samples, dt, **self.options)


class Known(NamedTuple):
    """A step of the registry: its function and, for each option, a Quantity or the words it may be."""

    function: Callable[..., Done]
    options: dict[str, Quantity | tuple[str, ...]]


STEPS: dict[str, Known] = {}
# What "auto" does to a raw record. Nothing in it needs a choice by the user; see field practice in each step.
DEFAULT_CHAIN: tuple[Step, ...] = (
    Step("mean", {}),
    Step("taper", {}),
    Step("bandpass", {}),
    Step("baseline", {}),
)


def step(name: str, **options: Quantity | tuple[str, ...]) -> Callable[[Callable[..., Done]], Callable[..., Done]]:
    """Enter a function in the registry under ``name``, with the options it takes."""

    def enter(function: Callable[..., Done]) -> Callable[..., Done]:
        STEPS[name] = Known(function, options)
        return function

    return enter


def read_steps(asked: Sequence[Mapping[str, Any]]) -> tuple[Step, ...]:
    """The steps of a list of tables: the key ``step``, and options as text with a unit or SI numbers.

    Raises RecordError for an unknown step or option, and for a value that an option cannot take.
    """
    return tuple(_read_step(number, table) for number, table in enumerate(asked, start=1))


def _read_step(number: int, table: Mapping[str, Any]) -> Step:
    place = f"processing, step {number}"
    if not isinstance(table, Mapping) or "step" not in table:
        raise RecordError(f'{place}: {shown(table)} names no step; write a table such as {{step = "mean"}}')
    name = table["step"]
    if not isinstance(name, str) or name not in STEPS:
        hint = _meant(name, STEPS)
        raise RecordError(f"{place}: {shown(name)} is not a step{hint}; it may be {', '.join(STEPS)}")
    known = STEPS[name].options
    options = {}
    for key, value in table.items():
        if key == "step":
            continue
        if key not in known:
            allowed = f"it takes {', '.join(known)}" if known else "it takes none"
            raise RecordError(f'{place}: "{name}" has no option {shown(key)}{_meant(key, known)}; {allowed}')
        options[key] = _option(f"{place}, {key}", value, known[key])
    return Step(name, options)


def _option(place: str, value: Any, kind: Quantity | tuple[str, ...]) -> Any:
    if not isinstance(kind, Quantity):
        if value not in kind:
            words = " or ".join(f'"{word}"' for word in kind)
            raise RecordError(f"{place}: {shown(value)} is not a choice; it may be {words}")
        return value
    try:
        return si(value, kind)
    except QuantityError as error:
        raise RecordError(f"{place}: {error}") from None


def si(value: Any, quantity: Quantity) -> float:
    """A number in SI as it is, text with a unit converted; raises QuantityError out of range."""
    if isinstance(value, str | bool):
        return parse(value, quantity)
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise QuantityError(f"{shown(value)} is not {article(quantity.words)}; {repair(quantity)}") from None
    if not quantity.allows(number):
        allowed = f"{article(quantity.words)} must be {bounds(quantity)}"
        raise QuantityError(f"{number:g} is out of range: {allowed}; {repair(quantity)}")
    return number


@step("window", start=TIME, end=TIME)
def window(samples: Samples, dt: float, *, start: float = 0.0, end: float = inf) -> Done:
    """Keep the samples from ``start`` to ``end`` [s], both included where they fall on a sample."""
    last = (len(samples) - 1) * dt
    if end <= start:
        raise RecordError(f"the window {start:g} s to {end:g} s is empty; write a start before the end")
    if start >= last:
        raise RecordError(f"the window starts at {start:g} s, the record ends at {last:g} s; write a start before that")
    first = ceil(start / dt - 1e-6)
    stop = min(len(samples), floor(min(end, last) / dt + 1e-6) + 1)
    if stop - first < 2:
        raise RecordError(
            f"the window {start:g} s to {end:g} s has fewer than 2 samples, {dt:g} s apart; write a later end"
        )
    flags: tuple[str, ...] = ()
    if last + dt / 2 < end < inf:
        flags = (f"the window asked for ends at {end:g} s, the record already at {last:g} s",)
    sentence = f"window: kept {first * dt:g} s to {(stop - 1) * dt:g} s ({stop - first} samples)"
    return Done(samples[first:stop].copy(), sentence, flags, first)


@step("mean", of=(PRE_EVENT, WHOLE))
def mean(samples: Samples, dt: float, *, of: str = PRE_EVENT) -> Done:
    """Subtract the mean before the earthquake arrives, or of the whole record.

    The first is the instrument's offset; it falls back to the second, flagged, without a second of quiet.
    """
    quiet = onset(samples, dt) - PICK_MARGIN
    flags: tuple[str, ...] = ()
    part, words = samples, "the whole record"
    if of == PRE_EVENT and quiet >= SHORTEST_PRE_EVENT:
        part, words = samples[: round(quiet / dt)], f"the {quiet:.2f} s before the earthquake arrives"
    elif of == PRE_EVENT:
        flags = ("less than 1 s before the earthquake arrives: the mean of the whole record was taken",)
    offset = float(part.mean())
    return Done(samples - offset, f"mean: subtracted {offset:.6g} m/s², the mean of {words}", flags)


@step("trend")
def trend(samples: Samples, dt: float) -> Done:
    """Subtract the straight line that fits the acceleration best (least squares)."""
    place = np.linspace(-1.0, 1.0, len(samples))
    slope = float(place @ samples / (place @ place))
    line = samples.mean() + slope * place
    rate = 2.0 * slope / ((len(samples) - 1) * dt)
    return Done(samples - line, f"trend: subtracted a straight line of {rate:.6g} m/s² per s")


@step("taper", lead=TIME, tail=TIME)
def taper(samples: Samples, dt: float, *, lead: float | None = None, tail: float | None = None) -> Done:
    """Bring both ends to zero by half a cosine wave of ``lead`` and ``tail`` [s].

    By time and not by a percentage, which would reach into the shaking of a record that starts late (5 % of
    RSN6-180 hides its peak). The lead stays within the quiet before the earthquake: half of it and at most
    1 s, none where it is shorter than a second; the tail is 5 s, or a tenth of a short record.
    """
    duration = (len(samples) - 1) * dt
    if lead is None:
        quiet = onset(samples, dt) - PICK_MARGIN
        lead = min(LONGEST_LEAD, quiet / 2) if quiet >= SHORTEST_PRE_EVENT else 0.0
    if tail is None:
        tail = min(LONGEST_TAIL, duration / 10)
    if lead + tail > duration:
        raise RecordError(
            f"a taper of {lead:g} s and {tail:g} s does not fit a record of {duration:g} s; write shorter"
        )
    time = np.arange(len(samples)) * dt
    weight = np.ones(len(samples))
    if lead > 0.0:
        weight *= cosine_rise(time / lead)
    if tail > 0.0:
        weight *= cosine_rise((duration - time) / tail)
    return Done(samples * weight, f"taper: cosine, first {lead:.3g} s and last {tail:.3g} s")


@step("bandpass", low=CORNER, high=CORNER, order=ORDER)
def bandpass(
    samples: Samples, dt: float, *, low: float = LOW_CORNER, high: float | None = None, order: float = 5
) -> Done:
    """Acausal Butterworth filter: the amplitude response, -3 dB at each corner [Hz], and no phase.

    |H(f)| = 1/sqrt(1 + (low/f)^2n) · 1/sqrt(1 + (f/high)^2n), once, in the frequency domain. A causal filter
    would move the peaks (+3 to +6 % in the gap that a pair needs), and pads of zeros keep the ends from
    wrapping round: 0.75 n/low seconds at each (Converse and Brady 1992; Boore 2005), stripped again. ``low``
    0 is a low-pass; ``high`` is 40 Hz unless given, and never above 3/4 of the Nyquist frequency by default.
    """
    nyquist = 0.5 / dt
    upper = min(HIGHEST_CORNER, NYQUIST_SHARE * nyquist) if high is None else high
    if not (low < upper and (upper < nyquist or (upper == inf and low > 0.0))):
        raise RecordError(
            f"the corners {low:g} and {upper:g} Hz do not fit a time step of {dt:g} s; they must rise and "
            f"stay below the Nyquist frequency of {nyquist:g} Hz (inf for no upper corner)"
        )
    pad = ceil(0.75 * order / (low or upper) / dt)
    padded = np.pad(samples, pad)
    size = 1 << (len(padded) - 1).bit_length()  # more zeros still, and a fast transform
    gain = butterworth(np.fft.rfftfreq(size, dt), low, upper, order)
    filtered = np.fft.irfft(np.fft.rfft(padded, size) * gain, size)[pad : pad + len(samples)]
    return Done(filtered, _filter_words(low, upper, order, pad * dt), _filter_flags(samples, dt, low))


@step("baseline", order=ORDER)
def baseline(samples: Samples, dt: float, *, order: float = 6) -> Done:
    """Subtract the second derivative of a polynomial fitted to the displacement.

    The constant and linear coefficients are zero, so the motion still starts from rest (PEER NGA-West2,
    Ancheta et al. 2013, with order 6). Time runs from 0 to 1 in the fit, which keeps it well-conditioned.
    The result is checked on velocity and displacement: what is left of them at the end is flagged.
    """
    degree = int(order)
    if degree != order or degree < 2:
        raise RecordError(f"the order of a baseline is {order:g}; it must be a whole number from 2 to 20")
    duration = (len(samples) - 1) * dt
    place = np.linspace(0.0, 1.0, len(samples))
    powers = np.arange(2, degree + 1)
    _, displacement = velocity_displacement(samples, dt)
    fit = np.linalg.lstsq(place[:, None] ** powers, displacement, rcond=None)[0]
    bend = (place[:, None] ** (powers - 2)) @ (fit * powers * (powers - 1)) / duration**2
    corrected = samples - bend
    sentence = f"baseline: subtracted the second derivative of an order-{degree} polynomial in displacement"
    words, flags = _ends(corrected, dt)
    return Done(corrected, f"{sentence}; {words}", flags)


def _ends(samples: Samples, dt: float) -> tuple[str, tuple[str, ...]]:
    """Peaks and last values of velocity and displacement in words; flags where they do not come to rest."""
    flags, words = [], []
    for name, trace, unit in zip(
        ("velocity", "displacement"), velocity_displacement(samples, dt), ("cm/s", "cm"), strict=True
    ):
        peak, last = 100.0 * float(np.abs(trace).max()), 100.0 * float(trace[-1])
        words.append(f"peak {name} {peak:.4g} {unit}, at the end {last:.3g}")
        if abs(last) > DRIFT_OF_PEAK * peak:
            share = 100.0 * abs(last) / peak
            flags.append(f"after baseline correction the {name} ends at {share:.0f} % of its peak")
    return ", ".join(words), tuple(flags)


def _filter_words(low: float, high: float, order: float, pad: float) -> str:
    corners = f"{low:g} to {high:g} Hz" if low and high < inf else f"above {low:g} Hz" if low else f"below {high:g} Hz"
    pads = f"{pad:.4g} s of zeros at both ends"
    return f"bandpass: acausal Butterworth of order {order:g}, {corners} (-3 dB), {pads}"


def _filter_flags(samples: Samples, dt: float, low: float) -> tuple[str, ...]:
    """Doubts about what went into the filter."""
    flags = []
    peak = float(np.abs(samples).max())
    if max(abs(samples[0]), abs(samples[-1])) > ENDS_OF_PEAK * peak:
        flags.append("the record was filtered with ends above 2 % of its peak: subtract the mean and taper before")
    duration = (len(samples) - 1) * dt
    if 0.0 < low < 1.0 / duration:
        flags.append(f"the lower corner {low:g} Hz is below one cycle in the record of {say(duration, TIME)}")
    return tuple(flags)


def _meant(name: Any, known: Mapping[str, Any]) -> str:
    near = get_close_matches(name, known, 1, 0.6) if isinstance(name, str) else []
    return f' (did you mean "{near[0]}"?)' if near else ""
