"""Options that several commands on records take: which records, and how they are processed and scaled."""

from __future__ import annotations

import glob
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from pounding_risk.cli._common.files import draw
from pounding_risk.cli._common.options import option, read_option, read_optional
from pounding_risk.errors import PoundingError
from pounding_risk.units import DIRECTION, PERIOD, PGA, SCALE, STEP, TIME

if TYPE_CHECKING:
    from pounding_risk._common.progress import Progress
    from pounding_risk.motions.motion import Motion
    from pounding_risk.motions.record import Source
    from pounding_risk.motions.request import RecordRequest
    from pounding_risk.motions.target_spectra import Target

WORDS = "ids, files, file#component, patterns, folders or generated motions"
Sources = Annotated[list[str] | None, typer.Argument(metavar="SOURCE", help=f"Records: {WORDS}.", show_default=False)]
Set = Annotated[str | None, typer.Option("--set", help="A record set, such as fema-p695-farfield.", show_default=False)]
Unit = Annotated[str | None, option("Unit of files that do not state theirs, such as cm/s^2.")]
Step = Annotated[
    str | None, typer.Option("--dt", help="Time step of files that do not state theirs.", show_default=False)
]
Processing = Annotated[str | None, option("auto processes raw records, none leaves all as they are.", "auto")]
Steps = Annotated[
    list[str],
    typer.Option(
        "--step", metavar="'NAME OPTION=VALUE'", help="A step, such as 'bandpass low=0.1Hz'; repeat, in order."
    ),
]
Window = Annotated[tuple[str, str] | None, option("Keep this part, after processing.", metavar="START END")]
Pga = Annotated[str | None, option("Scale to this peak ground acceleration.")]
Scale = Annotated[str | None, option("Scale by this factor.")]
SpectralAcceleration = Annotated[
    tuple[str, str] | None, option("Scale to this Sa at a period, such as 0.5g 1s.", metavar="VALUE PERIOD")
]
Direction = Annotated[str | None, option("Turn both horizontals of each recording to this direction, such as 30deg.")]
Poe = Annotated[
    str | None, option("Probability of a conditional spectrum with several: 0.02, or val1.", "its only one")
]
Damping = Annotated[str, option("Damping ratio of the spectra.")]


def record_request(
    processing: str | None,
    steps: Sequence[str] = (),
    window: tuple[str, str] | None = None,
    pga: str | None = None,
    scale: str | None = None,
    sa: tuple[str, str] | None = None,
    direction: str | None = None,
) -> RecordRequest:
    """How records are processed and scaled, from the texts of options, before any record is read.

    Raises PoundingError, which names the option.
    """
    from pounding_risk.motions.request import RecordRequest, Spectral

    scalings = [option for option, text in (("--pga", pga), ("--scale", scale), ("--sa", sa)) if text]
    if len(scalings) > 1:
        raise PoundingError(
            f"{' and '.join(scalings)} are given; a record is scaled by one of them: leave the others out"
        )
    return RecordRequest(
        window=window and (read_option("--window", window[0], TIME), read_option("--window", window[1], TIME)),
        pga=read_optional("--pga", pga, PGA),
        scale=read_optional("--scale", scale, SCALE),
        processing=_processing(processing, steps),
        direction=read_optional("--direction", direction, DIRECTION),
        sa=sa and Spectral(value=read_option("--sa", sa[0], PGA), period=read_option("--sa", sa[1], PERIOD)),
    )


def _processing(word: str | None, steps: Sequence[str]) -> Any:
    """The steps as tables of a scene, or the word for a chain of steps."""
    if not steps:
        if word not in (None, "auto", "none"):
            raise PoundingError(f'--processing: "{word}" is not one; it may be auto or none, or write --step')
        return word or "auto"
    if word is not None:
        raise PoundingError("--processing and --step are both given; the steps are the processing: leave one out")
    from pounding_risk.motions.processing import read_steps

    tables = [_step_table(text) for text in steps]
    try:
        read_steps(tables)
    except PoundingError as error:
        raise PoundingError(f"--step: {error}") from None
    return tables


def _step_table(text: str) -> dict[str, str]:
    """A step such as ``bandpass low=0.1Hz high="25 Hz"`` as the table that a scene has for it."""
    try:
        name, *options = shlex.split(text)
        pairs = [option.partition("=") for option in options]
        table = {key: value for key, _, value in pairs}
        if len(table) < len(pairs) or not all(key and value for key, _, value in pairs):
            raise ValueError(text)
        return {"step": name, **table}
    except ValueError:
        raise PoundingError(
            f"--step: {text!r} is not a step with its options; write one such as 'bandpass low=0.1Hz high=25Hz'"
        ) from None


def stated_facts(unit: str | None, dt: str | None) -> dict[str, Any]:
    """Unit and time step [s] of files that do not state theirs; raises PoundingError that names the option."""
    from pounding_risk.scene.keys import Unreadable
    from pounding_risk.scene.records import read_unit

    try:
        return {"unit": None if unit is None else read_unit(unit), "dt": read_optional("--dt", dt, STEP)}
    except Unreadable as error:
        raise PoundingError(f"--unit: {error}") from None


def target_spectrum(text: str, damping: float, poe: str | None = None) -> Target:
    """The target of ``--target``, of the probability ``--poe`` where it has several.

    Raises PoundingError where it is for another damping than ``--damping``.
    """
    from pounding_risk.motions.target_spectra import is_conditional, read_target

    if poe is not None and not is_conditional(Path(text)):
        raise PoundingError(f"--poe: is of a conditional spectrum of OpenQuake, and {text} is none; leave it out")
    target = read_target(text if poe is None else f"{text}#{poe}", damping=damping)
    if target.damping != damping:
        shape, _, _ = target.name.partition(",damping=")
        other = f'--target "{shape},damping={damping:g}"' if shape.startswith("ec8:") else "another target"
        raise PoundingError(
            f"--damping: {100.0 * damping:g} % is asked for, and {target.name} is for {100.0 * target.damping:g} %; "
            f"write --damping {target.damping:g}, or {other}"
        )
    return target


class SourceGroups(NamedTuple):
    """Records alone or in pairs of components, and a sentence for each file of a folder that is left out."""

    groups: tuple[tuple[Source, ...], ...]
    left_out: tuple[str, ...]


def find_sources(
    words: Sequence[str],
    record_set: str | None,
    facts: dict[str, Any],
    *,
    lenient: bool = False,
    horizontal: bool = False,
    in_pairs: bool = False,
) -> SourceGroups:
    """Open records by words, which are ids, files, file#component, patterns, folders or recipes, and those of a set.

    A file stands for all of its components; ``facts`` are what `stated_facts` returns. ``lenient`` leaves out damaged
    records of a folder, ``horizontal`` vertical components, unless they are named one by one, and ``in_pairs`` takes
    the two horizontal components of each recording as one group. Raises PoundingError where no record is named or
    found, and for a file that is no record, unless it is in a folder.
    """
    from pounding_risk.motions.ensemble import each_once, horizontals, pairs
    from pounding_risk.motions.read import open_source
    from pounding_risk.motions.record_sets import load, members

    if not words and record_set is None:
        raise PoundingError("no record is named; write ids of `pounding-risk records list`, files, a folder, or --set")
    left_out: list[str] = []
    sources = [source for word in words for source in _sources_of(word, facts, left_out, lenient)]
    if horizontal or in_pairs:
        sources = horizontals(sources, left_out)
    sources += [] if record_set is None else [open_source(load(member)) for member in members(record_set)]
    sources = each_once(sources)
    if not sources:
        reason = f"excluded: {left_out[0]}" if left_out else "the folder is empty"
        raise PoundingError(f"{' '.join(words)}: holds no record; {reason}")
    groups = pairs(sources) if in_pairs else [(source,) for source in sources]
    return SourceGroups(tuple(groups), tuple(left_out))


def _sources_of(word: str, facts: dict[str, Any], left_out: list[str], lenient: bool) -> Iterator[Source]:
    """Open the records of one word; a sentence is added to ``left_out`` for each file of a folder that is not taken."""
    from pounding_risk.motions.catalogue import entries
    from pounding_risk.motions.ensemble import sources_named
    from pounding_risk.motions.formats import matching
    from pounding_risk.motions.generated import is_recipe
    from pounding_risk.motions.read import generated_sources, open_source

    is_id = any(entry.id == word for entry in entries())
    if not is_id and (Path(word).is_dir() or matching(Path(), word)):
        yield from sources_named(word, Path(), left_out, **facts, lenient=lenient)
    elif is_recipe(word):
        yield from generated_sources(word)
    elif glob.has_magic(word):
        raise PoundingError(f'no file answers to "{word}"; patterns are relative to this folder')
    else:
        yield open_source(word, **facts)


def treat(request: RecordRequest, groups: Sequence[tuple[Source, ...]], progress: Progress) -> list[Motion]:
    """The motion of each group of sources, processed and scaled."""
    from pounding_risk.motions.ensemble import treated

    motions = []
    for group in groups:
        motions.append(treated(request, group))
        progress(len(motions), len(groups))
    return motions


def draw_before_and_after(target: Path, request: RecordRequest, group: tuple[Source, ...]) -> None:
    """Draw a record, or two components turned to one direction, before and after its processing."""
    from pounding_risk.motions.ensemble import treated
    from pounding_risk.motions.read import read_trace

    untreated = request._replace(processing="none", window=None, pga=None, scale=None, sa=None)
    start, start_after = (
        read_trace(group[0], processing=treatment.processing, window=treatment.window).stats.starttime
        for treatment in (untreated, request)
    )
    motions = treated(untreated, group), treated(request, group)
    draw(target, "motions.processing_figure", *motions, shift=float(start_after - start))
