"""What the `records` commands are given: which records, how to process them, where to write them."""

from __future__ import annotations

import glob
import shlex
from collections.abc import Iterator, Sequence
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from pounding_risk.cli._common.files import check_folder, writable
from pounding_risk.cli._common.options import read_option
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pounding_risk.motions.record import Source
    from pounding_risk.motions.request import RecordRequest
    from pounding_risk.motions.target_spectra import Target


class Options(NamedTuple):
    """The options of a command that say how records are processed, as they were written."""

    processing: str | None
    step: Sequence[str]
    window: tuple[str, str] | None
    pga: str | None
    scale: str | None
    sa: tuple[str, str] | None
    direction: str | None = None


WORDS = "ids, files, file#component, patterns or folders"

Sources = Annotated[list[str] | None, typer.Argument(metavar="SOURCE", help=f"Records: {WORDS}.", show_default=False)]

Set = Annotated[str | None, typer.Option("--set", help="A record set, such as fema-p695-farfield.", show_default=False)]

Unit = Annotated[
    str | None, typer.Option(help="Unit of files that do not state theirs, such as cm/s^2.", show_default=False)
]

Step = Annotated[
    str | None, typer.Option("--dt", help="Time step of files that do not state theirs.", show_default=False)
]

Processing = Annotated[
    str | None, typer.Option(help="auto processes raw records, none leaves all as they are.", show_default="auto")
]

Steps = Annotated[
    list[str],
    typer.Option(
        "--step", metavar="'NAME OPTION=VALUE'", help="A step, such as 'bandpass low=0.1Hz'; repeat, in order."
    ),
]

Window = Annotated[
    tuple[str, str] | None,
    typer.Option(metavar="START END", help="Keep this part, after processing.", show_default=False),
]

Bounds = Annotated[
    tuple[float, float] | None, typer.Option(metavar="LEAST MOST", help="Such as 6.5 7.5.", show_default=False)
]

Pga = Annotated[str | None, typer.Option(help="Scale to this peak ground acceleration.", show_default=False)]

Scale = Annotated[str | None, typer.Option(help="Scale by this factor.", show_default=False)]

Direction = Annotated[
    str | None,
    typer.Option(help="Turn both horizontals of each recording to this direction, such as 30deg.", show_default=False),
]

SpectralAcceleration = Annotated[
    tuple[str, str] | None,
    typer.Option(metavar="VALUE PERIOD", help="Scale to this Sa at a period, such as 0.5g 1s.", show_default=False),
]


def treatment(asked: Options) -> RecordRequest:
    """The options in SI, before any record is read; raises PoundingError that names the option."""
    from pounding_risk.motions.request import AS_RECORDED, RecordRequest, Spectral
    from pounding_risk.units import DIRECTION, PERIOD, PGA, SCALE, TIME

    given = [name for name, value in (("--pga", asked.pga), ("--scale", asked.scale), ("--sa", asked.sa)) if value]
    if len(given) > 1:
        raise PoundingError(f"{' and '.join(given)} are given; a record is scaled by one of them: leave the others out")
    spectral = None
    if asked.sa is not None:
        value, period = (read_option("--sa", text, kind) for text, kind in zip(asked.sa, (PGA, PERIOD), strict=True))
        spectral = Spectral(period, value=value)
    window = None
    if asked.window is not None:
        start, end = (read_option("--window", text, TIME) for text in asked.window)
        window = start, end
    return RecordRequest(
        names=(),
        files=(),
        window=window,
        pga=None if asked.pga is None else read_option("--pga", asked.pga, PGA),
        scale=None if asked.scale is None else read_option("--scale", asked.scale, SCALE),
        polarities=(AS_RECORDED,),
        processing=_processing(asked.processing, asked.step),
        tail=0.0,
        direction=None if asked.direction is None else read_option("--direction", asked.direction, DIRECTION),
        sa=spectral,
    )


def before_and_after(how: RecordRequest, group: tuple[Source, ...]) -> Figure:
    """The figure of a record, or of two components turned to the row, before and after its treatment."""
    from pounding_risk.figures import processing_figure
    from pounding_risk.motions.ensemble import treated
    from pounding_risk.motions.read import read_trace

    bare = how._replace(processing="none", window=None, pga=None, scale=None, sa=None)
    begun, begins = (
        read_trace(group[0], processing=each.processing, window=each.window).stats.starttime for each in (bare, how)
    )
    return processing_figure(treated(bare, group), treated(how, group), shift=float(begins - begun))


def _processing(word: str | None, steps: Sequence[str]) -> Any:
    """The steps written, or the word for a chain."""
    if not steps:
        if word not in (None, "auto", "none"):
            raise PoundingError(f'--processing: "{word}" is not one; it may be auto or none, or write --step')
        return word or "auto"
    if word is not None:
        raise PoundingError("--processing and --step are both given; the steps are the processing: leave one out")
    from pounding_risk.motions.processing.chain import read_steps

    tables = [_step(text) for text in steps]
    try:
        read_steps(tables)
    except PoundingError as error:
        raise PoundingError(f"--step: {error}") from None
    return tables


def _step(text: str) -> dict[str, str]:
    """``bandpass low=0.1Hz high="25 Hz"`` as the table of a scene."""
    try:
        name, *options = shlex.split(text)
        pairs = [_pair(option) for option in options]
        if len({key for key, _ in pairs}) < len(pairs):
            raise ValueError(text)
        return {"step": name, **dict(pairs)}
    except ValueError:
        raise PoundingError(
            f"--step: {text!r} is not a step with its options; write one such as 'bandpass low=0.1Hz high=25Hz'"
        ) from None


def _pair(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not (key and equals and value):
        raise ValueError(text)
    return key, value


class Stated(NamedTuple):
    """What the user says of files that do not say it."""

    unit: str | None = None
    dt: float | None = None  # s


UNSTATED = Stated()


def stated(unit: str | None, dt: str | None) -> Stated:
    """The options ``--unit`` and ``--dt``; raises PoundingError that names them."""
    from pounding_risk.scene.records import unit as known
    from pounding_risk.scene.values import Unreadable
    from pounding_risk.units import STEP

    try:
        return Stated(None if unit is None else known(unit), None if dt is None else read_option("--dt", dt, STEP))
    except Unreadable as error:
        raise PoundingError(f"--unit: {error}") from None


def target_spectrum(text: str, damping: float) -> Target:
    """The target of ``--target``; raises PoundingError where it is for another damping than ``--damping``."""
    from pounding_risk.motions.target_spectra import read_target

    target = read_target(text, damping=damping)
    if target.damping != damping:
        raise PoundingError(
            f"--damping: {100.0 * damping:g} % is asked for, and {target.name} is for {100.0 * target.damping:g} %; "
            f"write --damping {target.damping:g}, or another target"
        )
    return target


def choices_of(
    periods: tuple[str, str],
    distance: tuple[str, str] | None,
    vs30: tuple[str, str] | None,
    pga: tuple[str, str] | None,
) -> dict[str, Any]:
    """What a selection takes of options with units; raises PoundingError that names the option."""
    from pounding_risk.units import PERIOD, PGA, Quantity

    far = Quantity("m", 0.0, inf, "distance", example="10 km")
    soil = Quantity("m/s", 0.0, inf, "shear-wave velocity", example="360 m/s")
    found: dict[str, Any] = {"periods": tuple(read_option("--range", text, PERIOD) for text in periods)}
    if distance is not None:
        found["distance_km"] = tuple(read_option("--distance", text, far) / 1e3 for text in distance)
    if vs30 is not None:
        found["vs30"] = tuple(read_option("--vs30", text, soil) for text in vs30)
    if pga is not None:
        found["pga"] = tuple(read_option("--pga", text, PGA) for text in pga)
    return found


class Found(NamedTuple):
    """The records that were asked for, alone or in pairs, and a sentence for each file of a folder that is none."""

    groups: tuple[tuple[Source, ...], ...]
    left_out: tuple[str, ...]


def find(
    words: Sequence[str],
    set: str | None = None,
    say: Stated = UNSTATED,
    *,
    lenient: bool = False,
    horizontal: bool = False,
    in_pairs: bool = False,
) -> Found:
    """The records of ``words`` (ids, files, file#component, patterns, folders) and of a record set.

    A file stands for all of its components; ``horizontal`` leaves verticals out where they are not named one by one,
    and ``in_pairs`` too, which takes the two horizontals of each recording. What is no record is left out of a folder,
    and with ``lenient`` a damaged one too; anywhere else both are errors. Raises PoundingError where nothing is asked
    for, or found.
    """
    from pounding_risk.motions import ensemble as gather
    from pounding_risk.motions.record_sets import load, members
    from pounding_risk.motions.source import open_source

    if not words and set is None:
        raise PoundingError("no record is named; write ids of `pounding-risk records list`, files, a folder, or --set")
    left_out: list[str] = []
    sources = [source for word in words for source in _named(word, say, left_out, lenient)]
    if horizontal or in_pairs:
        sources = gather.horizontals(sources, left_out)
    sources += [] if set is None else [open_source(load(member)) for member in members(set)]
    sources = list({(source.record["file"], source.name): source for source in sources}.values())
    if not sources:
        why = f"left out: {left_out[0]}" if left_out else "the folder is empty"
        raise PoundingError(f"{' '.join(words)}: holds no record; {why}")
    groups = gather.pairs(sources) if in_pairs else [(source,) for source in sources]
    return Found(tuple(groups), tuple(left_out))


def _named(word: str, say: Stated, left_out: list[str], lenient: bool) -> Iterator[Source]:
    """The records of one word; a sentence in ``left_out`` for each file of a folder that is not taken."""
    from pounding_risk.motions.catalogue import entries
    from pounding_risk.motions.ensemble import sources_named
    from pounding_risk.motions.request import matching
    from pounding_risk.motions.source import open_source

    known = any(each.id == word for each in entries())
    if not known and (Path(word).is_dir() or matching(Path(), word)):
        yield from sources_named(word, Path(), left_out, **say._asdict(), lenient=lenient)
    elif glob.has_magic(word):
        raise PoundingError(f'no file answers to "{word}"; patterns are relative to this folder')
    else:
        yield open_source(word, **say._asdict())


def motion_targets(out: Path | None, groups: Sequence[tuple[Source, ...]]) -> list[Path | None]:
    """A file for each record: ``out`` itself for one, in the folder ``out`` for several; none where none is asked for.

    Raises PoundingError where one cannot be written, would replace a record that is read, or two have one name.
    """
    from pounding_risk.motions.write import SUFFIXES

    if out is None:
        return [None] * len(groups)
    if out.suffix.lower() in SUFFIXES and not out.is_dir():
        if len(groups) > 1:
            raise PoundingError(f"-o: {out} is one file for {len(groups)} records; name a folder")
        targets = [writable("-o", out, SUFFIXES) or out]
    elif out.suffix and not out.is_dir():
        raise PoundingError(f"-o: {out}: the name must end in {' or '.join(SUFFIXES)}; a folder has no suffix")
    else:
        check_folder(out)
        targets = [out / f"{plain_name(group)}.csv" for group in groups]
    for target in targets:
        if targets.count(target) > 1:
            raise PoundingError(f"-o: several of the records would be {target}; process them into folders of their own")
        if any(_is_file(source, target) for group in groups for source in group):
            raise PoundingError(f"-o: {target} is a record that is read; choose another name")
    return list(targets)


def plain_name(group: tuple[Source, ...]) -> str:
    """The ids of a record's components as the name of a file."""
    name = "+".join(str(source.record["id"]) for source in group)
    return "".join(letter if letter.isalnum() or letter in "-_.+" else "-" for letter in name)


def _is_file(source: Source, target: Path) -> bool:
    file = str(source.record.get("file") or "")
    return bool(file) and Path(file).is_file() and target.is_file() and target.samefile(file)
