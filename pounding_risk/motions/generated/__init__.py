"""Generated motions: a kind and values of its keys, in place of a record's file.

A kind is one function under ``@motion_kind`` in a module of this folder, a new one or the one of its family; nothing
else lists it. The function takes its keys in SI and returns the `Form` of a motion: `Wave` for a formula, `Noise` for
filtered white noise. From the declaration of its keys follow the reader of scenes, the sentences, the JSON schema and
the page of the docs.

    >>> from pounding_risk.motions.generated import recipe
    >>> recipe("ricker", pga="0.4 g", period="0.8 s").text()
    'ricker: pga=3.92266 m/s^2, period=0.8 s, shape=symmetric'
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from hashlib import sha256
from typing import Any, NamedTuple

from pounding_risk._common.plugins import Registry
from pounding_risk._common.words import nearest
from pounding_risk.errors import RecordError
from pounding_risk.motions.generated._forms import MOST, Form, Unfit
from pounding_risk.motions.generated._forms import Sampled as Sampled
from pounding_risk.motions.generated._forms import Wave as Wave
from pounding_risk.motions.processing.signals import velocity_displacement
from pounding_risk.motions.record import GENERATED, STATED, STILL, Source
from pounding_risk.units import EXAMPLES, STEP, Quantity, QuantityError, exact, say, shown, si, unknown

REQUIRED = "required"
Number = Callable[[Any, Quantity], float]  # `parse` in files, where a number needs a unit; `si` in Python
_TEXT = re.compile(r"\s*([A-Za-z]\w*)\s*:\s*(\w+\s*=.*)", re.DOTALL)  # "ricker: pga=0.4 g, period=0.8 s"


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


class Recipe(NamedTuple):
    """A request of a scene: a kind of motion and the values of its keys in SI.

    Defaults are among them, except for those that follow from other keys.
    """

    kind: str
    options: tuple[tuple[str, Any], ...]

    @property
    def about(self) -> Kind:
        """Its kind, of the registry."""
        return motion_kinds()[self.kind]

    def written(self) -> dict[str, Any]:
        """The table as a scene file has it: quantities as text, exact."""
        return {"kind": self.kind, **{key: self.about.options[key].written(option) for key, option in self.options}}

    def text(self) -> str:
        """The recipe as one line, from which `recipe_of` reads it back."""
        return f"{self.kind}: " + ", ".join(f"{key}={option}" for key, option in list(self.written().items())[1:])

    def form(self) -> Form:
        """The motion at any time step; raises Unfit where values of keys do not go together."""
        options, common = dict(self.options), {"step", "name", "seed", "count"}
        return self.about.function(**{key: options.get(key) for key in self.about.options if key not in common})

    def check(self) -> None:
        """Raise Unfit where values of keys do not go together, or the time step is too long."""
        form = self.form()
        form.check(self._step(form))

    def sources(self) -> tuple[Source, ...]:
        """The motions, one for each seed, as records that were read."""
        options, form = dict(self.options), self.form()
        first, count = options.get("seed", 0), options.get("count", 1)
        step = self._step(form)
        return tuple(self._opened(form, step, seed, count > 1) for seed in range(first, first + count))

    def finer(self, times: float) -> Recipe:
        """The motion in so many times as many samples, at most `MOST`; noise, which they would change, as it is."""
        if self.about.is_random:
            return self
        form = self.form()
        step = min(self._step(form), max(self._step(form) / times, form.duration / MOST))
        return Recipe(self.kind, _ordered(self.about, dict(self.options) | {"step": step}))

    def _step(self, form: Form) -> float:
        step = dict(self.options).get("step")
        return form.default_step() if step is None else float(step)

    def _opened(self, form: Form, step: float, seed: int, several: bool) -> Source:
        from obspy import Trace  # takes 0.2 s

        recipe = self
        if self.about.is_random:  # the recipe of one motion of several
            options = {key: option for key, option in self.options if key != "count"}
            recipe = Recipe(self.kind, _ordered(self.about, options | {"seed": seed}))
        motion = form.sampled(step, seed)
        velocity, displacement = velocity_displacement(motion.samples, step)
        last = _near(velocity[-1], velocity, "m/s"), _near(displacement[-1], displacement, "m")
        ends = f"the ground ends with the velocity {last[0]} at the displacement {last[1]}"
        trace = Trace(motion.samples, {"delta": step})
        trace.stats.processing = [f"generated {recipe.text()}", *motion.sentences, ends]
        facts: dict[str, Any] = {"id": recipe.name(several), "event": f"generated: {recipe._title()}"}
        facts |= {"date": "", "station": "", "component": "", "state": GENERATED, "format": GENERATED, "file": ""}
        digest = sha256(recipe.text().encode()).hexdigest()
        facts |= {"sha256": digest, "origin": f"generated {recipe.text()}", "terms": ""}
        if self.about.is_random:
            facts[STATED] = f"generated: {self.kind}, seed {seed}"  # one stream of random numbers, whatever the filter
        if not motion.samples.any():
            facts[STILL] = True
        if motion.error is not None:
            facts["interpolation_error"] = motion.error
        return Source(recipe.text(), trace, facts, "units: m/s², as generated", motion.doubts)

    def name(self, several: bool = False) -> str:
        """The name of a motion in results: that of the recipe, or its kind and what distinguishes it."""
        options = dict(self.options)
        if "name" not in options:
            return self._title()
        return f"{options['name']}-seed{options['seed']}" if several else str(options["name"])

    def _title(self) -> str:
        """The kind, and what distinguishes this motion of it."""
        kind, options = self.about, dict(self.options)
        words = [kind.options[key].said(options[key]).replace(" ", "") for key in kind.named_by if key in options]
        return "-".join([self.kind, *words, *([f"seed{options['seed']}"] if kind.is_random else [])])


def motion_kinds() -> Mapping[str, Kind]:
    """List the kinds of generated motions of all modules of this folder, of plug-ins, and those of a user's script.

    Returns
    -------
    mapping of str to Kind
        Function and keys of each kind by its name, in alphabetical order.
    """
    return KINDS


def known_kind(name: Any) -> Kind:
    """The kind of a name; raises Unfit for another one."""
    kinds = motion_kinds()
    if not isinstance(name, str) or name not in kinds:
        raise Unfit("kind", unknown(name, "not a kind of motion", kinds))
    return kinds[name]


def made(kind: Kind, options: Mapping[str, Any]) -> Recipe:
    """The recipe of values that have been read, with defaults in it and checked as a whole; raises Unfit."""
    stated = {key: option.default for key, option in kind.options.items() if option.default not in (REQUIRED, None)}
    recipe = Recipe(kind.name, _ordered(kind, stated | dict(options)))
    recipe.check()
    return recipe


def recipe(kind: str, /, **keys: Any) -> Recipe:
    """The recipe of a generated motion.

    Parameters
    ----------
    kind : str
        One of `motion_kinds`.
    **keys
        Its keys: floats in SI, or text with a unit.

    Returns
    -------
    Recipe
        As `pounding_risk.Records` takes it in its ``generated``.

    Raises
    ------
    RecordError
        For an unknown kind or key, a key that is missing, and values out of range or that do not go together.
    """
    about, options = known_kind(kind), {}
    for key, option in keys.items():
        if key not in about.options:
            raise RecordError(f"{kind}: no key {key}{nearest(key, about.options)}; {takes(about)}")
        try:
            options[key] = about.options[key].read(option, si)
        except QuantityError as error:
            raise RecordError(f"{kind}, {key}: {error}") from None
    if missing := [key for key in about.required if key not in options]:
        raise RecordError(f"{kind}: {missing[0]} is missing; write a motion such as {about.example()}")
    try:
        return made(about, options)
    except Unfit as error:
        raise RecordError(f"{kind}, {error}") from None


def is_recipe(text: str) -> bool:
    """Whether a text names a generated motion: a known kind and a colon, or a word, a colon and a key with a value."""
    kind, colon, _ = text.partition(":")
    return bool(colon) and (kind.strip() in motion_kinds() or bool(_TEXT.fullmatch(text)))


def recipe_of(text: str) -> Recipe:
    """The recipe of a line such as "ricker: pga=0.4 g, period=0.8 s"; raises RecordError as `recipe`."""
    kind, _, parameters = text.partition(":")
    pairs = [pair.partition("=") for pair in parameters.split(",") if pair.strip()]
    if any(not key.strip() or not option.strip() for key, _, option in pairs):
        raise RecordError(f'{shown(text)}: keys have values; write one such as "ricker: pga=0.4 g, period=0.8 s"')
    return recipe(kind.strip(), **{key.strip(): option.strip() for key, _, option in pairs})


def takes(kind: Kind) -> str:
    """Which keys a kind takes, for a sentence."""
    return f"{kind.name} takes {', '.join(kind.options)}"


def _ordered(kind: Kind, options: Mapping[str, Any]) -> tuple[tuple[str, Any], ...]:
    """Values in the order in which the kind declares its keys."""
    return tuple((key, options[key]) for key in kind.options if key in options)


def _near(end: float, trace: Any, unit: str) -> str:
    """A value at the end, 0 where it is nothing beside the peak."""
    return f"{0.0 if abs(end) <= 1e-4 * float(abs(trace).max()) else end:.4g} {unit}"
