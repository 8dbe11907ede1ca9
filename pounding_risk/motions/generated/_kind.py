"""A kind of generated motion: its keys, the registry of kinds, and the form that a kind gives for values of keys."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from pounding_risk._common.plugins import Registry
from pounding_risk._common.words import nearest
from pounding_risk.errors import RecordError
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.units import EXAMPLES, STANDARD_GRAVITY, STEP, Quantity, QuantityError, exact, say, shown

MOST = 2_000_000  # samples of one motion
FADED = 1e-6  # of the peak: what is left at the end of a pulse that fades is zero
LONGEST = 0.01  # s: the longest time step that is chosen
REQUIRED = "required"
Number = Callable[[Any, Quantity], float]  # `parse` in files, where a number needs a unit; `si` in Python


class Unfit(RecordError):
    """A value that does not go with those of other keys: the key, and the sentence."""

    def __init__(self, key: str, sentence: str):
        self.key, self.sentence = key, sentence
        super().__init__(f"{key}: {sentence}")


class Option(NamedTuple):
    """A key of a kind of motion.

    ``allowed`` is a quantity, the words it may be, or None for text. ``default`` is in SI; None where the value follows
    from other keys, as ``absent`` says.
    """

    words: str
    allowed: Quantity | tuple[str, ...] | None
    default: Any = REQUIRED
    absent: str = ""
    whole: bool = False

    def read(self, value: Any, number: Number) -> Any:
        """The value in SI; raises QuantityError with what was found, what is allowed and the repair."""
        if self.allowed is None:
            if not isinstance(value, str) or not value.strip():
                raise QuantityError(f"{shown(value)} is not a name; write text in quotes")
            return value
        if not isinstance(self.allowed, Quantity):
            if value not in self.allowed:
                hint = nearest(value, self.allowed)
                words = " or ".join(map(shown, self.allowed))
                raise QuantityError(f"{shown(value)} is not one of its words{hint}; it may be {words}")
            return value
        parsed = number(value, self.allowed)
        if self.whole and parsed != int(parsed):
            raise QuantityError(f"{shown(value)} is not a whole number; write one such as {self.example}")
        return int(parsed) if self.whole else parsed

    def written(self, value: Any) -> Any:
        """A value in SI as a scene file has it; the very same number is read back."""
        return exact(float(value), self.allowed) if isinstance(self.allowed, Quantity) and not self.whole else value

    def said(self, value: Any) -> str:
        """A value in SI as an engineer writes it."""
        return say(value, self.allowed) if isinstance(self.allowed, Quantity) and not self.whole else str(value)

    @property
    def example(self) -> str:
        """A value as a scene file has it."""
        if not isinstance(self.allowed, Quantity):
            return shown(self.allowed[-1]) if self.allowed else '"pulse"'
        example = self.allowed.example or EXAMPLES[self.allowed.unit]
        return example if self.allowed.unit == "1" else shown(example)

    @property
    def default_words(self) -> str:
        """What holds without the key."""
        return self.absent or (REQUIRED if self.default == REQUIRED else self.said(self.default))


class Form(ABC):
    """What a kind gives for values of its keys: samples of a motion at any time step.

    A motion starts with the ground at rest.
    """

    duration: float  # s

    @abstractmethod
    def default_step(self) -> float:
        """The time step [s] that is chosen where none is given."""

    @abstractmethod
    def sampled(self, step: float, seed: int) -> Sampled:
        """The motion at a time step [s]; raises Unfit where the step is too long for it."""

    def check(self, step: float) -> None:
        """Raise Unfit for a time step [s] that is too long, or that makes more than `MOST` samples."""
        if self.duration / step > MOST:
            raise Unfit(
                "step",
                f"{step:g} s makes {self.duration / step:.3g} samples of a motion of {self.duration:g} s, "
                f"{MOST} are allowed; write a longer step or a shorter motion",
            )


class Sampled(NamedTuple):
    """Samples [m/s²], sentences about them, doubts, and the largest error of straight lines between them.

    ``error`` is a share of the largest acceleration; None where the motion between samples is not known.
    """

    samples: Samples
    sentences: tuple[str, ...]
    doubts: tuple[str, ...] = ()
    error: float | None = None


def closed(
    samples: Samples, step: float, sentences: tuple[str, ...], *, least: float = FADED, error: float | None = None
) -> Sampled:
    """Samples that end at zero, with a doubt about a jump at either end: above ``least`` of the peak it is one."""
    peak, doubts = float(np.abs(samples).max()), []
    first, last = (f"{value / STANDARD_GRAVITY:.4g} g" for value in (samples[0], samples[-1]))
    if abs(samples[0]) > least * peak:
        doubts.append(f"the acceleration starts with a jump from 0 to {first}, on ground at rest")
    if abs(samples[-1]) > least * peak:
        doubts.append(f"the acceleration falls from {last} to 0 within one step of {step:g} s at its end")
    if abs(samples[-1]) > FADED * peak:
        samples = np.append(samples, 0.0)
    return Sampled(samples, sentences, tuple(doubts), error)


def largest_in_g(samples: Samples) -> float:
    """Largest size of the samples [g], of samples in m/s²."""
    return float(np.abs(samples).max()) / STANDARD_GRAVITY


class Kind(NamedTuple):
    """A kind of the registry: the function that gives its form, and its keys."""

    name: str
    function: Callable[..., Form]
    options: Mapping[str, Option]
    amplitude: tuple[str, ...]  # the keys that set how strong it is, and nothing else; none of still ground
    named_by: tuple[str, ...]  # the keys whose values stand in the name of a motion

    @property
    def required(self) -> list[str]:
        """The keys without a default."""
        return [key for key, option in self.options.items() if option.default == REQUIRED]

    @property
    def words(self) -> str:
        """The first line of its docstring."""
        return (self.function.__doc__ or "").partition("\n")[0]

    @property
    def is_random(self) -> bool:
        """Whether motions of it differ by a seed."""
        return "seed" in self.options

    @property
    def needed(self) -> list[str]:
        """The keys that a motion has at least: those without a default, and one for its strength."""
        return list(dict.fromkeys((*self.required, *self.amplitude[:1])))

    def example(self) -> str:
        """The table of a motion as a scene file has it, with the keys that are needed."""
        keys = [f"{key} = {self.options[key].example}" for key in self.needed]
        return "{" + ", ".join([f'kind = "{self.name}"', *keys]) + "}"


KINDS = Registry("motions", arrange=sorted, folder=__package__ or "")
# The keys that every kind has, and those of every kind that differs by a seed.
OF_ALL = {
    "step": Option(
        "Time step of the samples, between which the acceleration is linear.",
        STEP._replace(example="0.005 s"),
        None,
        "chosen by the motion's fastest part, and stated",
    ),
    "name": Option("Name of the motion in results.", None, None, "the kind, and what distinguishes it"),
}
SEED = Quantity("1", 0.0, 2.0**53, "seed", example="7")
COUNT = Quantity("1", 1.0, 10_000.0, "number of motions", example="20")
OF_RANDOM = {
    "seed": Option("Seed of the random numbers: the same one gives the same motion.", SEED, 1, whole=True),
    "count": Option("How many motions, of this seed and those that follow.", COUNT, 1, whole=True),
}


def motion_kind(
    name: str, *, amplitude: tuple[str, ...], named_by: tuple[str, ...] = (), random: bool = False, **options: Option
) -> Callable[[Callable[..., Form]], Callable[..., Form]]:
    """Enter a function in the registry: it takes its keys in SI and returns the `Form` of a motion.

    Parameters
    ----------
    name : str
        The kind, as scenes name it.
    amplitude : tuple of str
        The keys that set the strength.
    named_by : tuple of str
        The keys whose values stand in the default name of a motion.
    random : bool
        Whether the motion follows from a seed; it has the keys ``seed`` and ``count`` then.
    **options
        Its own keys; ``step`` and ``name`` are added.
    """

    def enter(function: Callable[..., Form]) -> Callable[..., Form]:
        every = {**options, **(OF_RANDOM if random else {}), **OF_ALL}
        KINDS.enter(name, Kind(name, function, every, amplitude, named_by), function.__module__)
        return function

    return enter
