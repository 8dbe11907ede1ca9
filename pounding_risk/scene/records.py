"""The table [records] of a scene: its keys from text to SI, and what they exclude or need of each other."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pounding_risk._common.words import nearest
from pounding_risk.errors import RecordError
from pounding_risk.motions.catalogue import entries, is_file, similar
from pounding_risk.motions.formats import matching, size_of_unit
from pounding_risk.motions.generated import Recipe, Unfit, known_kind, made, motion_kinds, takes
from pounding_risk.motions.levels import FACTOR, LEVEL_AXIS, Level
from pounding_risk.motions.processing import Step, known_steps, read_steps
from pounding_risk.motions.record_sets import SETS
from pounding_risk.motions.request import (
    AS_RECORDED,
    INTENSITY,
    MEDIANS,
    POLARITIES,
    SOURCES,
    RecordRequest,
    Spectral,
    conflicts,
)
from pounding_risk.motions.sites.places import Place
from pounding_risk.motions.sites.places import place as checked_place
from pounding_risk.scene import levels
from pounding_risk.scene.keys import (
    Draft,
    Key,
    Number,
    Several,
    Table,
    Unreadable,
    each,
    facts,
    list_of,
    measured,
    one_or_more,
    options,
    several,
    text,
)
from pounding_risk.scene.toml import Fault, KeyPath, as_list, table, tables
from pounding_risk.units import DAMPING, DIRECTION, PERIOD, PGA, SCALE, STEP, TAIL, TIME, Quantity, exact, parse, shown

STEPS_EXAMPLE = '[{step = "mean"}, {step = "bandpass", low = "0.1 Hz"}]'
MOST_HINTS = 3  # records with the same beginning that are named
RENAMED = {"polarity": "polarities"}  # keys that are called otherwise in a request
_STRINGS = {"type": "array", "items": {"type": "string"}}
_STEPS = {"type": "array", "items": {"type": "object", "required": ["step"]}}
_ONE_SOURCE = "one of names, files, set, manifest, sites and generated is required"
GENERATED_EXAMPLE = '[{kind = "ricker", pga = "0.4 g", period = "0.8 s"}]'


def catalogue_ids() -> list[str]:
    """The ids of the records that come with the project."""
    return [record.id for record in entries()]


def _window(value: Any, number: Number) -> tuple[float, float]:
    """Start and end of the part of a record that is kept [s]."""
    if not isinstance(value, list) or len(value) != 2:
        raise Unreadable(f'{shown(value)} is not a start and an end; write window = ["0 s", "6 s"]')
    start, end = each(value, lambda moment: number(moment, TIME))
    if end <= start:
        flaw = "is empty" if end == start else "ends before it starts"
        raise Unreadable(f'the window {shown(value)} {flaw}; write start and end, such as window = ["0 s", "6 s"]')
    return start, end


def _polarity(value: Any, number: Number) -> tuple[str, ...]:
    """ "as recorded", "reversed", or both as a list."""
    senses = value if isinstance(value, list) else [value]
    if not senses:
        raise Unreadable(f'the list is empty; write polarity = ["{AS_RECORDED}"]')

    def read(sense: Any) -> str:
        if not isinstance(sense, str) or sense not in POLARITIES:
            raise Unreadable(
                f'{shown(sense)} is not a polarity{nearest(sense, POLARITIES)}; it may be "as recorded", "reversed", '
                'or ["as recorded", "reversed"]'
            )
        return sense

    return tuple(each(senses, read, distinct=True))


def _processing(value: Any, number: Number) -> str | tuple[Step, ...]:
    """ "auto", "none", or a list of step tables, whose options are text with a unit."""
    if isinstance(value, list) and value:
        return tuple(each(value, lambda step: _step(step, number)))
    if isinstance(value, dict):
        raise Unreadable(f"{shown(value)} is one table; write the steps as a list, such as {STEPS_EXAMPLE}")
    if value not in ("auto", "none"):
        raise Unreadable(
            f'{shown(value)} is not a processing; it may be "auto" (raw records get the default chain, '
            f'processed ones are left alone), "none", or a list of steps such as {STEPS_EXAMPLE}'
        )
    return str(value)


def _step(step: Any, number: Number) -> Step:
    """A step of a list; the faults of all its options at once."""
    if isinstance(step, Step):
        return step
    has_name = isinstance(step, dict) and "step" in step
    if fault := _step_fault({"step": step["step"]} if has_name else step, number):
        raise Unreadable(fault)
    by_key = {key: {"step": step["step"], key: option} for key, option in step.items() if key != "step"}
    faults = [((key,), fault) for key, part in by_key.items() if (fault := _step_fault(part, number, key))]
    if faults:
        raise Several(list(faults))
    return read_steps([step])[0]


def _step_fault(step: Any, number: Number, key: str = "") -> str:
    """The fault of a step's table, or of its option ``key``; "" where there is none."""
    try:
        kind = known_steps()[step["step"]].options.get(key) if key else None
        if isinstance(kind, Quantity):
            number(step[key], kind)  # a bare number is SI to a script, but has no unit in a scene
        read_steps([step])
    except RecordError as error:
        return str(error).partition(": ")[2]  # without the number of the step, which stands in the path of the key
    except ValueError as error:
        return str(error)
    return ""


def _record_name(value: Any, number: Number) -> str:
    """An id of the catalogue."""
    known_ids = catalogue_ids()
    if not isinstance(value, str) or value not in known_ids:
        lower_text = str(value).lower()
        alike_ids = [id for id in known_ids if lower_text and id.lower().startswith(lower_text)][:MOST_HINTS]
        # Or else records with nearly these letters, or of a station or earthquake of that name.
        nearby_ids = alike_ids or (similar(value) if isinstance(value, str) else [])
        hint = f" (did you mean {' or '.join(map(shown, nearby_ids))}?)" if nearby_ids else ""
        raise Unreadable(
            f"{shown(value)} is not a record of the catalogue{hint}; "
            "`pounding-risk records` lists them, and a file of your own goes into files"
        )
    return value


def _record_set(value: Any, number: Number) -> str:
    """The name of a published record set."""
    if not isinstance(value, str) or value not in SETS:
        raise Unreadable(f"{shown(value)} is not a record set{nearest(value, SETS, 0.4)}; it may be {', '.join(SETS)}")
    return value


def read_unit(value: Any, number: Number = parse) -> str:
    """Reader of the unit of acceleration samples, such as "cm/s^2"."""
    try:
        size_of_unit(value, "")
    except RecordError as error:
        raise Unreadable(str(error).removeprefix(": ")) from None
    return str(value).strip()


def _spectral(value: Any, number: Number, example: str, *, with_value: bool) -> Spectral:
    """A table {value, period, damping}: spectral acceleration; ``value`` is needed or not allowed."""
    if isinstance(value, Spectral):
        return value
    if not isinstance(value, dict):
        raise Unreadable(f"{shown(value)} is not a table; write {example}")
    quantities = {**({"value": PGA} if with_value else {}), "period": PERIOD, "damping": DAMPING}
    kinds = {key: lambda item, quantity=quantity: number(item, quantity) for key, quantity in quantities.items()}
    needed = [key for key in kinds if key != "damping"]
    return Spectral(
        **options(value, kinds, needed, lambda key: f"missing; write {example}", f"it takes {', '.join(kinds)}")
    )


def _to_median(value: Any, number: Number) -> str | Spectral:
    """ "pga" or "pgv", or a table with the period of Sa."""
    example = '"pgv", or {period = "1 s"}'
    if isinstance(value, dict | Spectral):
        return _spectral(value, number, f"to_median = {example}", with_value=False)
    if value not in MEDIANS:
        raise Unreadable(f"{shown(value)} is not a measure of the records; write to_median = {example}")
    return str(value)


def _place(value: Any, number: Number) -> Place:
    """A table {longitude, latitude} of plain numbers, in degrees."""
    example = "write place = {longitude = 23.73, latitude = 37.98}, in degrees"
    if isinstance(value, Place):
        return value
    if not isinstance(value, dict):
        raise Unreadable(f"{shown(value)} is not a table; {example}")

    def degrees(coordinate: Any) -> float:
        if isinstance(coordinate, bool) or not isinstance(coordinate, int | float):
            raise Unreadable(f"{shown(coordinate)} is no number of degrees; {example}")
        return float(coordinate)

    kinds = {"longitude": degrees, "latitude": degrees}
    coordinates = options(value, kinds, list(kinds), lambda key: f"missing; {example}", f"it takes {', '.join(kinds)}")
    try:
        return checked_place(**coordinates, where="place")
    except RecordError as error:
        raise Unreadable(str(error).partition(": ")[2]) from None


def _generated(value: Any, number: Number) -> tuple[Recipe, ...]:
    """Generated motions: a list of tables with a kind and its keys."""
    if isinstance(value, dict):
        raise Unreadable("one table, where each motion is a table of a list; write [[records.generated]]")
    tables = list_of(value, f"generated = {GENERATED_EXAMPLE}")
    return tuple(each(tables, lambda table: _recipe(table, number), distinct=True))


def _recipe(table: Any, number: Number) -> Recipe:
    """One generated motion; all faults of its table at once, each with its key."""
    if isinstance(table, Recipe):
        return table
    if not isinstance(table, dict):
        raise Unreadable(f"{shown(table)} is not a table; write generated = {GENERATED_EXAMPLE}")
    if "kind" not in table:
        raise Several([(("kind",), f"missing; it may be {', '.join(motion_kinds())}")])
    try:
        kind = known_kind(table["kind"])
        values = {key: parameter for key, parameter in table.items() if key != "kind"}
        strays = [key for key in values if key not in kind.options and key in Records.model_fields]
        if strays:
            sentence = "a key of [records], not of a motion; write it above the first [[records.generated]]"
            raise Several([((key,), sentence) for key in strays])
        readers = {key: lambda word, option=option: option.read(word, number) for key, option in kind.options.items()}
        parameters = options(
            values,
            readers,
            kind.required,
            lambda key: f"missing; write {key} = {kind.options[key].example}",
            takes(kind),
        )
        return made(kind, parameters)
    except Unfit as error:
        raise Several([((error.key,), error.sentence)]) from None


def _generated_schema() -> dict[str, Any]:
    """The JSON schema of a generated motion: a table for each kind."""

    def described(option: Any) -> dict[str, Any]:
        notes = {"description": option.words, "x-example": option.example, "x-absent": option.default_words}
        if option.allowed is None:
            return {"type": "string", **notes}
        if not isinstance(option.allowed, Quantity):
            return {"enum": list(option.allowed), **notes}
        number = {"type": "integer"} if option.whole else {"type": ["number", "string"]}
        return {**(number if option.allowed.unit == "1" else {"type": "string"}), **facts(option.allowed), **notes}

    tables = [
        {
            "type": "object",
            "description": kind.words,
            "properties": {"kind": {"const": name}, **{key: described(option) for key, option in kind.options.items()}},
            "required": ["kind", *kind.required],
            "additionalProperties": False,
        }
        for name, kind in motion_kinds().items()
    ]
    return {"oneOf": tables}


PAUSE = TIME._replace(words="pause", high=3600.0, example="30 s")
AFTERSHOCK_RATIO = Quantity("1", 0.0, 10.0, "ratio of two PGAs", open_low=True, example="0.8")


class Records(Table):
    """Which ground motions a scene uses, and how they are treated before a run."""

    names: tuple[str, ...] = several(
        "names", _record_name, "Ids of the catalogue.", '["RSN6-180"]', _ONE_SOURCE
    ).defaults_to(())
    files: tuple[str, ...] = several(
        "files",
        text("", "my/*.AT2").read,
        "Files, patterns or folders, from the scene's folder; one component after #.",
        '["my/*.AT2"]',
        _ONE_SOURCE,
    ).defaults_to(())
    set: str = Key(
        "A published record set.", _record_set, '"fema-p695-farfield"', _ONE_SOURCE, schema={"type": "string"}
    ).defaults_to("")
    manifest: str = text("A list of records with their factors.", "selected.csv", _ONE_SOURCE).defaults_to("")
    sites: str = text(
        "A grid of sites with motions of their own, as SimCenter's EventGrid.csv; those of the nearest are taken.",
        "EventGrid.csv",
        _ONE_SOURCE,
    ).defaults_to("")
    place: Place | None = Key(
        "Where the row stands, for sites: degrees east and north.",
        _place,
        "{longitude = 23.73, latitude = 37.98}",
        "the only site",
        write=lambda place: dict(place._asdict()),
        schema={"type": "object"},
    ).defaults_to(None)
    unit: str = Key(
        "Unit of the samples of files that state none.",
        read_unit,
        '"cm/s^2"',
        "the files state it",
        schema={"type": "string"},
    ).defaults_to("")
    dt: float | None = measured(STEP, "Time step of files that state none.", absent="the files state it").defaults_to(
        None
    )
    direction: float | None = measured(
        DIRECTION,
        "Direction of the row; both horizontals of each recording are turned to it.",
        absent="components as they are",
    ).defaults_to(None)
    window: tuple[float, float] | None = Key(
        "The part of each record that is kept.",
        _window,
        '["0 s", "6 s"]',
        "all of it",
        write=lambda times: [exact(time, TIME) for time in times],
        schema=_STRINGS,
    ).defaults_to(None)
    pga: float | None = measured(PGA, "Every motion is scaled to this PGA.", absent="as recorded").defaults_to(None)
    sa: Spectral | None = Key(
        "Every motion is scaled to this spectral acceleration.",
        lambda value, number: _spectral(value, number, 'sa = {value = "0.4 g", period = "1 s"}', with_value=True),
        '{value = "0.4 g", period = "1 s"}',
        "as recorded",
        write=lambda spectral: spectral.written(),
        schema={"type": "object"},
    ).defaults_to(None)
    to_median: str | Spectral | None = Key(
        "Every recording is scaled to the ensemble's median PGA, PGV or Sa(T).",
        _to_median,
        '"pgv"',
        "as recorded",
        write=lambda median: median.written() if isinstance(median, Spectral) else median,
        schema={"anyOf": [{"enum": list(MEDIANS)}, {"type": "object"}]},
    ).defaults_to(None)
    scale: float | None = measured(
        SCALE, "A factor on every motion, after any other scaling.", absent="as recorded"
    ).defaults_to(None)
    intensity: tuple[Level, ...] = Key(
        "Levels of pga, pgv, sa, sa_avg or scale, to each of which every motion is scaled; a dimension of the dataset.",
        levels.read_levels,
        levels.EXAMPLE,
        "as recorded",
        write=levels.written_levels,
        schema=levels.SCHEMA,
    ).defaults_to(())
    polarity: tuple[str, ...] = Key(
        "As recorded, reversed, or both; a dimension of the dataset.",
        _polarity,
        '["as recorded", "reversed"]',
        f'"{AS_RECORDED}"',
        write=list,
        schema={"anyOf": [{"enum": list(POLARITIES)}, _STRINGS]},
    ).defaults_to((AS_RECORDED,))
    processing: str | tuple[Step, ...] = Key(
        "Steps from record to motion; auto processes raw records and leaves processed ones alone.",
        _processing,
        STEPS_EXAMPLE,
        '"auto"',
        write=lambda steps: steps if isinstance(steps, str) else [step.written() for step in steps],
        schema={"anyOf": [{"enum": ["auto", "none"]}, _STEPS]},
    ).defaults_to("auto")
    tail: float = measured(
        TAIL, "Free vibration after each record, at least; rounded up to whole time steps.", absent='"0 s"'
    ).defaults_to(0.0)
    aftershock: tuple[str, ...] = one_or_more(
        'names no record; write a file, an id of the catalogue such as "RSN753-000", or a list with one for each '
        "record of the scene",
        "A record that follows each motion, in one run with it: a file, an id of the catalogue or a generated "
        "motion as text, for all records of the scene, or a list with one for each. What has yielded, and "
        "permanent indentations, stay. It is processed as they are, without their window.",
        '"RSN753-000"',
        "nothing follows",
    ).defaults_to(())
    pause: float = measured(PAUSE, "Still ground between a motion and its aftershock.", absent='"60 s"').defaults_to(
        60.0
    )
    aftershock_ratio: float | None = measured(
        AFTERSHOCK_RATIO,
        "PGA of the aftershock over that of the motion before it.",
        absent="both as recorded, times the factor of the motion before",
    ).defaults_to(None)
    generated: tuple[Recipe, ...] = Key(
        "Motions that are no records, a table [[records.generated]] each: a kind and its keys, on their own page.",
        _generated,
        GENERATED_EXAMPLE,
        _ONE_SOURCE,
        write=lambda recipes: [recipe.written() for recipe in recipes],
        schema={"type": "array", "items": _generated_schema},
    ).defaults_to(())

    def request(self) -> RecordRequest:
        """The request of ground motions that `motions.ensemble.read_ensemble` takes, in SI."""
        request_keys = [key for key in self.key_names() if key != INTENSITY]  # whose levels are the grid's
        return RecordRequest(**{RENAMED.get(key, key): getattr(self, key) for key in request_keys})


def records_of(request: RecordRequest, amplitudes: tuple[Level | None, ...] = ()) -> Records:
    """The table of a request, with every value that is not absent; ``amplitudes`` are those of the grid."""
    request_keys = [key for key in Records.key_names() if key != INTENSITY]  # whose levels are the grid's
    settings = {key: getattr(request, RENAMED.get(key, key)) for key in request_keys}
    settings["pause"] = settings["pause"] if request.aftershock else None
    settings[INTENSITY] = tuple(level for level in amplitudes if level is not None and level.measure.axis == LEVEL_AXIS)
    return Records.from_values({key: setting for key, setting in settings.items() if setting not in (None, "", ())})


def record_checks(draft: Draft) -> Iterator[Fault]:
    """Keys of [records] that exclude or need each other, or a key of [grid]."""
    for keys in draft.tables("records"):
        if not any(key in keys for key in SOURCES):
            example = 'missing; write names = ["RSN6-180"], files = ["my/*.AT2"], or set = "fema-p695-farfield"'
            yield keys.fault("names", example, absent=True)
        if "place" in keys and "sites" not in keys:
            yield keys.fault(
                "place", 'there are no sites to choose from; write sites = "EventGrid.csv", or remove place'
            )
        for key in ("pause", "aftershock_ratio"):
            if key in keys and "aftershock" not in keys:
                yield keys.fault(key, 'no motion follows another; write aftershock = "RSN753-000", or remove it')
        is_factor = any(level.measure.name == FACTOR for level in (keys.get(INTENSITY) or ()))
        for key, sentence in conflicts(keys.raw, grid_pga="pga" in draft.table("grid"), is_factor=is_factor):
            yield keys.fault(key, sentence)


def missing_files(raw: Mapping[str, Any], folder: Path) -> Iterator[Fault]:
    """Faults for names and patterns without a file, of buildings too, and for a manifest that is not there."""
    for key in ("manifest", "sites"):
        file_name = table(raw, "records").get(key)
        if isinstance(file_name, str) and file_name.strip() and not (folder / file_name).is_file():
            sentence = f"no such file in {folder.resolve()}; files are relative to the scene file's folder"
            yield Fault(("records", key), sentence)
    for path, pattern in named_files(raw):
        try:
            if matching(folder, pattern):
                continue
        except RecordError as error:
            yield Fault(path, str(error))
            continue
        folder_beside = (folder / pattern).parent
        other_files = [entry.name for entry in folder_beside.iterdir()] if folder_beside.is_dir() else []
        hint = nearest(Path(pattern).name, other_files)
        yield Fault(
            path,
            f"no file answers to {shown(pattern)} in {folder.resolve()}{hint}; "
            "files are relative to the scene file's folder",
        )


def named_files(raw: Mapping[str, Any]) -> Iterator[tuple[KeyPath, str]]:
    """Every name or pattern of files in a scene's tables, with its path."""
    names: list[tuple[KeyPath, list[Any]]] = [(("records", "files"), as_list(table(raw, "records").get("files")))]
    shock = table(raw, "records").get("aftershock")
    names.append((("records", "aftershock"), shock if isinstance(shock, list) else [shock]))
    for index, building in tables(raw, "building"):
        for key in ("ground_record", "displacement_history"):
            value = building.get(key)
            names.append((("building", index, key), value if isinstance(value, list) else [value]))
    for path, patterns in names:
        for place, pattern in enumerate(patterns):
            if (
                isinstance(pattern, str)
                and pattern.strip()
                and (path[-1] not in ("ground_record", "aftershock") or is_file(pattern))
            ):
                yield (*path, place) if len(patterns) > 1 or path[0] == "records" else path, pattern
