"""What the `records` commands are given: which records, how to process them, where to write them."""

from __future__ import annotations

import glob
import shlex
from collections.abc import Iterator, Sequence
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk.cli_input import check_folder, read_option, writable
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pounding_risk.motions import Motion
    from pounding_risk.sources import Source
    from pounding_risk.targets import Target

BESIDE = ".xml"  # StationXML, which belongs to the records beside it


class Treatment(NamedTuple):
    """What is done to each record."""

    choices: dict[str, Any]  # keywords of `motions.read_motion`
    spectral: tuple[float, float] | None = None  # m/s² that Sa at a period [s] is brought to

    def motion(self, source: Source) -> Motion:
        """The motion of a record after it."""
        from pounding_risk.motions import read_motion

        motion = read_motion(source, **self.choices)
        if self.spectral is None:
            return motion
        from pounding_risk.scaling import to_spectral_acceleration

        return to_spectral_acceleration(motion, *self.spectral)

    def figure(self, source: Source) -> Figure:
        """The record before and after it."""
        from pounding_risk.figures import processing_figure
        from pounding_risk.motions import read_motion, read_trace

        whole: dict[str, Any] = {"processing": "none"}
        begun, begins = (read_trace(source, **choices).stats.starttime for choices in (whole, self.choices))
        return processing_figure(read_motion(source, **whole), self.motion(source), shift=float(begins - begun))


class Options(NamedTuple):
    """The options of a command that say how records are processed, as they were written."""

    processing: str | None
    step: Sequence[str]
    window: tuple[str, str] | None
    pga: str | None
    scale: str | None
    sa: tuple[str, str] | None


def treatment(asked: Options) -> Treatment:
    """The options in SI, before any record is read; raises PoundingError that names the option."""
    from pounding_risk.quantities import PERIOD, PGA, SCALE, TIME

    given = [name for name, value in (("--pga", asked.pga), ("--scale", asked.scale), ("--sa", asked.sa)) if value]
    if len(given) > 1:
        raise PoundingError(f"{' and '.join(given)} are given; a record is scaled by one of them: leave the others out")
    choices: dict[str, Any] = {"processing": _processing(asked.processing, asked.step)}
    if asked.window is not None:
        choices["window"] = tuple(read_option("--window", text, TIME) for text in asked.window)
    if asked.pga is not None:
        choices["pga"] = read_option("--pga", asked.pga, PGA)
    if asked.scale is not None:
        choices["scale"] = read_option("--scale", asked.scale, SCALE)
    if asked.sa is None:
        return Treatment(choices)
    value, period = asked.sa
    return Treatment(choices, (read_option("--sa", value, PGA), read_option("--sa", period, PERIOD)))


def _processing(word: str | None, steps: Sequence[str]) -> Any:
    """The steps written, or the word for a chain."""
    if not steps:
        if word not in (None, "auto", "none"):
            raise PoundingError(f'--processing: "{word}" is not one; it may be auto or none, or write --step')
        return word or "auto"
    if word is not None:
        raise PoundingError("--processing and --step are both given; the steps are the processing: leave one out")
    from pounding_risk.processing import read_steps

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
        return {"step": name} | dict(_pair(option) for option in options)
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
    from pounding_risk.quantities import STEP
    from pounding_risk.scene_keys import Unreadable
    from pounding_risk.scene_records import unit as known

    try:
        return Stated(None if unit is None else known(unit), None if dt is None else read_option("--dt", dt, STEP))
    except Unreadable as error:
        raise PoundingError(f"--unit: {error}") from None


def target_spectrum(text: str, damping: float) -> Target:
    """The target of ``--target``; raises PoundingError where it is for another damping than ``--damping``."""
    from pounding_risk.targets import read_target

    target = read_target(text, damping=damping)
    if target.damping != damping:
        raise PoundingError(
            f"--damping: {100.0 * damping:g} % is asked for, and {target.name} is for {100.0 * target.damping:g} %; "
            f"write --damping {target.damping:g}, or another target"
        )
    return target


def choices_of(
    periods: tuple[str, str], distance: tuple[str, str] | None, vs30: tuple[str, str] | None
) -> dict[str, Any]:
    """What a selection takes of options with units; raises PoundingError that names the option."""
    from pounding_risk.quantities import PERIOD, Quantity

    far = Quantity("m", 0.0, inf, "distance", example="10 km")
    soil = Quantity("m/s", 0.0, inf, "shear-wave velocity", example="360 m/s")
    found: dict[str, Any] = {"periods": tuple(read_option("--range", text, PERIOD) for text in periods)}
    if distance is not None:
        found["distance_km"] = tuple(read_option("--distance", text, far) / 1e3 for text in distance)
    if vs30 is not None:
        found["vs30"] = tuple(read_option("--vs30", text, soil) for text in vs30)
    return found


class Found(NamedTuple):
    """The records that were asked for, and a sentence for each file of a folder that is none."""

    sources: tuple[Source, ...]
    notes: tuple[str, ...]


def find(
    words: Sequence[str],
    set: str | None = None,
    say: Stated = UNSTATED,
    *,
    lenient: bool = False,
    horizontal: bool = False,
) -> Found:
    """The records of ``words`` (ids, files, file#component, patterns, folders) and of a record set.

    A file stands for all of its components; ``horizontal`` leaves verticals out where they are not named one by one.
    What is no record is left out of a folder, and with ``lenient`` a damaged one too; anywhere else both are errors.
    Raises PoundingError where nothing is asked for, or found.
    """
    if not words and set is None:
        raise PoundingError("no record is named; write ids of `pounding-risk records list`, files, a folder, or --set")
    notes: list[str] = []
    sources = [source for word in words for source in _named(word, say, notes, lenient)]
    if horizontal:
        sources = _horizontals(sources, notes)
    sources += _members(set)
    if not sources:
        raise PoundingError(f"{' '.join(words)}: holds no record; {notes[0] if notes else 'the folder is empty'}")
    return Found(tuple(sources), tuple(notes))


def _named(word: str, say: Stated, notes: list[str], lenient: bool) -> Iterator[Source]:
    """The records of one word; a sentence in ``notes`` for each file of a folder that is left out."""
    from pounding_risk.catalogue import entries
    from pounding_risk.formats import is_record
    from pounding_risk.record_request import matching
    from pounding_risk.sources import components, open_source

    in_folder = Path(word).is_dir()
    files = [] if any(each.id == word for each in entries()) else matching(Path(), word)
    if not files and glob.has_magic(word):
        raise PoundingError(f'no file answers to "{word}"; patterns are relative to this folder')
    if not files and not in_folder:
        yield open_source(word, **say._asdict())
    for file in files:
        if in_folder and not is_record(file):
            notes += [f"left out: {file} is not a record"] if file.suffix.lower() != BESIDE else []
            continue
        try:
            yield from components(file, **say._asdict()) if file.is_file() else [open_source(file, **say._asdict())]
        except PoundingError as error:
            if not (in_folder and lenient):
                raise
            notes.append(f"left out: {str(error).partition(';')[0]}")


def _horizontals(sources: Sequence[Source], notes: list[str]) -> list[Source]:
    """The records that may drive a row, or the one record that there is."""
    from pounding_risk.sources import is_vertical

    if len(sources) == 1:
        return list(sources)
    notes += [f"left out: {each.name} is vertical" for each in sources if is_vertical(each.record)]
    return [each for each in sources if not is_vertical(each.record)]


def _members(set: str | None) -> list[Source]:
    if set is None:
        return []
    from pounding_risk.record_sets import load, members
    from pounding_risk.sources import open_source

    return [open_source(load(member)) for member in members(set)]


def motion_targets(out: Path | None, sources: Sequence[Source]) -> list[Path | None]:
    """A file for each record: ``out`` itself for one, in the folder ``out`` for several; none where none is asked for.

    Raises PoundingError where one cannot be written, would replace a record that is read, or two have one name.
    """
    from pounding_risk.motion_files import SUFFIXES

    if out is None:
        return [None] * len(sources)
    if out.suffix.lower() in SUFFIXES and not out.is_dir():
        if len(sources) > 1:
            raise PoundingError(f"-o: {out} is one file for {len(sources)} records; name a folder")
        targets = [writable("-o", out, SUFFIXES) or out]
    elif out.suffix and not out.is_dir():
        raise PoundingError(f"-o: {out}: the name must end in {' or '.join(SUFFIXES)}; a folder has no suffix")
    else:
        check_folder(out)
        targets = [out / f"{plain_name(source)}.csv" for source in sources]
    for target in targets:
        if targets.count(target) > 1:
            raise PoundingError(f"-o: several of the records would be {target}; process them into folders of their own")
        if any(_is_file(source, target) for source in sources):
            raise PoundingError(f"-o: {target} is a record that is read; choose another name")
    return list(targets)


def plain_name(source: Source) -> str:
    """The id of a record as the name of a file."""
    return "".join(letter if letter.isalnum() or letter in "-_.+" else "-" for letter in str(source.record["id"]))


def _is_file(source: Source, target: Path) -> bool:
    file = str(source.record.get("file") or "")
    return bool(file) and Path(file).is_file() and target.is_file() and target.samefile(file)
