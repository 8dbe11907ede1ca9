"""The pages of record formats, generated motions, processing steps and quality checks, from their registries."""

from __future__ import annotations

import sys
from typing import Any

from generation.markdown import docstring, plain, table
from pounding_risk.motions.formats import formats
from pounding_risk.motions.generated import motion_kinds
from pounding_risk.motions.generated.noise import read_envelope
from pounding_risk.motions.processing import DEFAULT_CHAIN, known_steps
from pounding_risk.motions.quality import CHECKS
from pounding_risk.units import Quantity, bounds

FORMATS = """# Record formats

A file's format is seen from its content, not its name. Those that ObsPy lacks are its plugins once this package is
installed: `obspy.read` opens them in any script. [What each file needs beside it](../records.md).

"""


def formats_page() -> str:
    """Every format that is read."""
    rows = [
        (plain(kind.words), f"`{kind.name}`", " ".join(f"`{one}`" for one in kind.suffixes), _reader(kind))
        for kind in formats()
    ]
    text = FORMATS + table(("format", "ObsPy's name", "usual endings", "read by"), rows) + "\n"
    for kind in formats():
        module = sys.modules[kind.recognises.__module__]
        text += f"## {plain(kind.words.partition(' (')[0])}\n\n{docstring(module)}\n"
    return text


def _reader(kind: Any) -> str:
    return "ObsPy, checked here" if kind.native else "this package"


MOTIONS = """# Generated motions

Motions that are no records: a table `[[records.generated]]` of a scene each, or a call of `pr.generate_motion` with the
same keys. [How they are used](../records.md#generated-motions).

| kind | what |
|---|---|
"""


def motions_page() -> str:
    """Every kind of generated motion with its keys, formula and sources."""
    kinds = motion_kinds()
    text = MOTIONS + "".join(
        f"| [`{name}`](#{name.replace('_', '-')}) | {plain(kind.words)} |\n" for name, kind in kinds.items()
    )
    for name, kind in kinds.items():
        text += f"\n## {plain(name)}\n\n{docstring(kind.function)}\n"
        rows = [
            (f"`{key}`", plain(option.words), plain(_range(option)), f"`{option.example}`", plain(option.default_words))
            for key, option in kind.options.items()
        ]
        text += table(("key", "meaning", "unit and range", "example", "default"), rows)
    return f"{text}\n## Envelopes of noise\n\n{docstring(read_envelope)}\n## Noise\n\n{docstring(_noise())}"


def _range(option: Any) -> str:
    """Unit and bounds of a key, or the words it may be."""
    if isinstance(option.allowed, Quantity):
        return f"{option.allowed.unit}, {bounds(option.allowed)}".removeprefix("1, ")
    return ", ".join(f"`{word}`" for word in option.allowed or ())


def _noise() -> Any:
    """The module of the kinds of noise."""
    return sys.modules[motion_kinds()["white_noise"].function.__module__]


def steps_page() -> str:
    """Every processing step with its options."""
    chain = " · ".join(f"`{step.name}`" for step in DEFAULT_CHAIN)
    text = (
        "# Processing steps\n\n"
        f'`processing = "auto"` does {chain} to a raw record and nothing to a processed one. In a scene: '
        '`processing = [{step = "mean"}, {step = "bandpass", low = "0.1 Hz"}]`.\n\n'
    )
    for name, known in known_steps().items():
        text += f"## {plain(name)}\n\n{docstring(known.function)}\n"
        rows = [(f"`{key}`", *_option(allowed)) for key, allowed in known.options.items()]
        text += table(("option", "what", "unit and range"), rows) + "\n" if rows else "It has no option.\n\n"
    return text


def _option(allowed: Any) -> tuple[str, str]:
    if isinstance(allowed, Quantity):
        return plain(allowed.words), plain(f"{allowed.unit}, {bounds(allowed)}".removeprefix("1, "))
    return " or ".join(f'`"{word}"`' for word in allowed), ""


def checks_page() -> str:
    """Every check of quality."""
    heads = ("check", "concerns records that are", "what it looks at")
    rows = [
        (plain(name), " or ".join(states), docstring(function).replace("\n", " "))
        for name, (function, states) in CHECKS.items()
    ]
    return (
        "# Quality checks\n\n`pounding-risk records info` prints what each finds and what it allows; what lasts is a "
        f"flag of the motion and stands in the results.\n\n{table(heads, rows)}"
    )
