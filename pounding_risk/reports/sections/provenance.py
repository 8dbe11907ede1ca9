"""Section on provenance: what it takes to run the study again."""

from __future__ import annotations

import shlex
from collections.abc import Iterator

from pounding_risk.assessment.annual_rates import read_rate
from pounding_risk.assessment.assess import Assessment
from pounding_risk.assessment.options import USUAL_CONFIDENCE, USUAL_PERCENTILE
from pounding_risk.motions.levels import PEAK
from pounding_risk.render.sheet import MISSING, Block, facts, head, heading, listing, number, paragraph, source, table
from pounding_risk.reports.data import ReportData
from pounding_risk.results.amplitudes import intensity_unit, intensity_words
from pounding_risk.results.opened import Results
from pounding_risk.statistics.required_gap import target_left_by
from pounding_risk.units import GAP, exact

TITLE = "Provenance"
ORDER = 110
MOST_GROUPS = 20  # of records, in each list; hundreds of generated motions would fill a book


def write(data: ReportData) -> list[Block]:
    """The scene as written and as resolved, commands, versions, record files and their processing."""
    attributes = data.results.attrs
    names = {"scene_sha256": "the scene, every value stated: sha256", "kernels_digest": "the solver's source"}
    digests = [(words, str(attributes[name])) for name, words in names.items() if name in attributes]
    file_keys = ("file", "format", "sha256")
    heads = ["record", *file_keys]
    files = [[name, *(str(record.get(key) or MISSING) for key in file_keys)] for name, record in data.records.items()]
    origins: dict[str, list[str]] = {}  # records from one place, and those treated alike, share a line
    for name, record in data.records.items():
        origin = "; ".join(str(record[key]) for key in ("origin", "terms") if record.get(key))
        origins.setdefault(origin or "not stated in the file", []).append(name)
    steps: dict[str, list[str]] = {}
    for name, of_record in data.facts("processing", {}).items():
        steps.setdefault(" → ".join(of_record) or "as found", []).append(name)
    blocks = [
        paragraph(
            "To run this study again, save the scene below under the name that the first command has for it, give the "
            "commands, and compare the checksums of the record files."
            + (" With the results file at hand, pounding-risk rerun does all of it." if "options" in attributes else "")
        ),
        source("Commands.", "\n".join(_commands(data))),
        source("The scene, as written.", str(attributes.get("scene", ""))),
        facts("Versions.", sorted(data.facts("versions", {}).items())),
        *([facts("Plug-ins.", sorted(data.facts("plugins", {}).items()))] if "plugins" in attributes else []),
        *([facts("Digests.", digests)] if digests else []),
        table("Record files.", heads, files),
        heading("Origin and terms of the records", "origins"),
        listing(_by_record(origins, data, "records")),
        heading("Processing", "processing"),
        listing(_by_record(steps, data, "processing")),
        source("The scene, every value stated.", str(attributes["scene_resolved"])),
    ]
    written_from = [("results file, sha256", data.checksum)] if data.checksum else []
    written_from += [
        (f"{kind}: {companion.attrs['file']}, sha256", str(companion.attrs["sha256"]))
        for kind, companion in data.others.items()
        if "file" in companion.attrs
    ]
    source_files = [facts("This report was written from", written_from)] if written_from else []
    return [*blocks, *_hazard_curve(data.assessment), *source_files]


def _hazard_curve(assessment: Assessment) -> Iterator[Block]:
    """The numbers of the hazard curve, where there is one, and how it was read."""
    if assessment.hazard_rows:
        unit = intensity_unit(assessment.intensity)
        heads = [head(intensity_words(assessment.intensity), unit), "exceeded a year"]
        rows = [[number(im, unit), number(rate)] for im, rate in assessment.hazard_rows]
        yield table(f"The hazard curve {assessment.hazard}.", heads, rows)
        if assessment.hazard_reading:
            yield paragraph(assessment.hazard_reading)


def _commands(data: ReportData) -> list[str]:
    """The command that made the dataset, where one did, or one that makes the same."""
    attributes = data.results.attrs
    if attributes.get("command"):
        scan = str(attributes["command"])
    else:
        overrides = "".join(f" --set '{override}'" for override in data.facts("overrides", []))
        scan = f"pounding-risk scan scene.toml -o results.nc{overrides}"
    words = shlex.split(scan)
    indices = [k + 1 for k, word in enumerate(words[:-1]) if word in ("-o", "--out")]
    out_names = [word.removeprefix("--out=") for word in words if word.startswith("--out=")]
    target = words[indices[-1]] if indices else out_names[-1] if out_names else "results.nc"
    return [scan, shlex.join(["pounding-risk", "report", target, "-o", f"report{data.suffix}", *_asked(data)])]


def _asked(data: ReportData) -> list[str]:
    """Options of the report that differ from the defaults."""
    assessment, interface, results = data.assessment, data.assessment.interfaces[0], Results(data.results)
    amplitudes = results.amplitudes
    level = "--pga" if amplitudes.measure == PEAK else "--intensity-level"
    own_level = amplitudes.values[results.scene_level] if len(amplitudes.values) > 1 else interface.amplitude
    asked_options = (  # each with its usual value, and how it is written
        ("--gap", interface.gap, results.scene_gap(0), lambda gap: exact(gap, GAP)),
        ("--percentile", assessment.percentile, USUAL_PERCENTILE, "{:.15g}".format),
        ("--confidence", assessment.confidence, USUAL_CONFIDENCE, repr),
        ("--target", assessment.target, target_left_by(assessment.percentile), repr),
        ("--intensity", assessment.intensity, results.usual_intensity, str),
        (level, interface.amplitude, own_level, lambda at: exact(at or 0.0, amplitudes.measure.quantity)),
    )
    options = []
    for option, value, usual, write_value in asked_options:
        options += [option, str(write_value(value))] if value != usual else []
    for name, words in data.signature.lines:
        options += [f"--{name}", words]
    for companion in data.others.values():
        options += ["--with", str(companion.attrs["file"])] if "file" in companion.attrs else []
    if assessment.hazard:
        options += ["--hazard", assessment.hazard]
    if assessment.target_rate is not None:
        words = assessment.target_rate_words  # rounded for a reader
        exactly = read_rate(words).rate == assessment.target_rate
        options += ["--target-rate", words if exactly else f"{assessment.target_rate!r} a year"]
    return options


def _by_record(groups: dict[str, list[str]], data: ReportData, attribute: str) -> list[str]:
    """What is said of records, alike ones together; of very many groups the first, and where the others stand."""
    lines = [f"{_who(names, data)}: {words}" for words, names in groups.items()]
    left = len(lines) - MOST_GROUPS
    rest = [f"{left} more: the attribute {attribute} of the dataset has them."] if left > 0 else []
    return lines[:MOST_GROUPS] + rest


def _who(names: list[str], data: ReportData) -> str:
    """Names of records, or "all records"."""
    return "all records" if len(names) == len(data.records) > 1 else ", ".join(names)
