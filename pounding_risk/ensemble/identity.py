"""The identity of a scan: all that its numbers depend on, as plain tables. Scans of one identity share their results.

It holds the scene, the ground motions, the options, the program, and the code of the user's own contact laws; not the
machine, the number of workers, or the chunks.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pounding_risk.results.along import leaves_of
from pounding_risk.results.attributes import versions
from pounding_risk.scene.overrides import WITHOUT_RUNS

if TYPE_CHECKING:
    from pounding_risk.ensemble.job import ScanInput

LIBRARIES = ("pounding-risk", "numpy", "scipy", "numba")  # those that numbers go through
SHOWN = 6  # values of a list that a sentence still names one by one
LISTED = 8  # differences that are listed one by one
HISTORY = "displacement_history"  # the fact of a record on the histories beside it
ABSENT = object()
OWN_LAW, OTHERS_LAW = "one of your own, or of a plug-in", "this program's own, or none"
# The source that numbers of a dataset depend on: not commands, figures, reports and assessments.
SOURCES = ("_jit", "models", "motions", "scene", "solver", "ensemble", "results", "units.py")


def identity(scan_input: ScanInput, prepared: str = "") -> dict[str, Any]:
    """All that the numbers of a scan depend on, in types that JSON has; ``prepared`` is `Job.prepared`."""
    from pounding_risk.scene.scene import own_laws  # imports the models; the state of a scan is read without them

    records = [(motion.name, motion.record, motion.digest, list(motion.processing)) for motion in scan_input.motions]
    tables = {
        "scene": tables_of_runs(scan_input.study.resolved()),
        "records": [record_of(*facts) for facts in records],
        "options": {"screening": bool(scan_input.screening), "check_fraction": float(scan_input.check_fraction)},
        "program": program_of(versions(), package_digest()),
        "laws": own_laws(scan_input.study),
        "prepared": prepared,
    }
    return _plain_tables(tables)


def digest(identity: Mapping[str, Any]) -> str:
    """SHA-256 of an identity; the order of its keys does not count."""
    text = json.dumps(identity, ensure_ascii=False, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def difference(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[str]:
    """One sentence for each thing in which two identities differ: 'interface[0].gap: was "20 mm", is "25 mm"'."""
    old, new = _plain_tables(old), _plain_tables(new)
    programs, laws = ([one.get(key, {}) for one in (old, new)] for key in ("program", "laws"))
    sources = [program.pop("source", None) for program in programs]
    sentences = [
        *_changed_values(old.get("scene", {}), new.get("scene", {})),
        *_changed_records(old.get("records", []), new.get("records", [])),
        *_changed_values(old.get("options", {}), new.get("options", {})),
        *_changed_values(*programs),
    ]
    if sources[0] != sources[1]:
        sentence = f"its source was changed since, in what numbers depend on ({', '.join(SOURCES)})"
        sentences.append(f"pounding_risk: {sentence}")
    for name in dict.fromkeys((*laws[0], *laws[1])):
        label = name if name.startswith("effect ") else f"contact model {name}"  # as `own_laws` names both
        was, now = (law.get(name) for law in laws)
        if was is None or now is None:
            origins = (OTHERS_LAW if law is None else OWN_LAW for law in (was, now))
            sentences.append("{}: was {}, is {}".format(label, *origins))
        elif was != now:
            sentences.append(f"{label}: its code, which is not this program's own, was changed since")
    if not sentences and old.get("prepared") != new.get("prepared"):
        sentences.append(
            "the last digits of what is computed before the runs: another kind of processor, for which libraries "
            "compute in other ways; set the same OPENBLAS_CORETYPE on all machines, or use machines of one kind"
        )
    return sentences


def difference_lines(old: Mapping[str, Any], new: Mapping[str, Any]) -> str:
    """The differences of two identities as lines of a list; of many the first, and a count of the rest."""
    sentences = difference(old, new)
    more_line = [f"and {len(sentences) - LISTED} more"] if len(sentences) > LISTED else []
    return "".join(f"\n  - {sentence}" for sentence in (*sentences[:LISTED], *more_line))


def flattened(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Nested tables as one, to compare: "interface[0].gap" → its value; a list of plain values stays one value.

    >>> flattened({"interface": [{"gap": "20 mm"}], "grid": {"gap": ["0 mm", "5 mm"]}})
    {'interface[0].gap': '20 mm', 'grid.gap': ['0 mm', '5 mm']}
    """
    leaves = ((path, leaf) for path, leaf in leaves_of(tables) if path)
    return {
        "".join(f".{key}" if isinstance(key, str) else f"[{key}]" for key in path)[1:]: leaf for path, leaf in leaves
    }


def _plain_tables(tables: Mapping[str, Any]) -> dict[str, Any]:
    """As it comes back from a file: tuples are lists there, and numbers of NumPy's plain ones."""
    return json.loads(json.dumps(tables, default=lambda number: number.item()))


def tables_of_runs(tables: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of a scene that runs read: a title changes no number, and neither do states of damage."""
    return {key: table for key, table in tables.items() if key not in WITHOUT_RUNS}


def record_of(name: str, record: Mapping[str, Any], samples: str, processing: Sequence[str]) -> dict[str, Any]:
    """The facts that identify a motion, from its record and the digest of its ``samples``."""
    history = {HISTORY: record[HISTORY]} if HISTORY in record else {}
    sha256 = str(record.get("sha256", ""))
    return {"name": name, "sha256": sha256, "samples": samples, "processing": processing, **history}


def program_of(installed: Mapping[str, Any], source: str) -> dict[str, str]:
    """The versions of Python and of `LIBRARIES` among these, and the digest of a source."""
    python = ".".join(str(installed.get("python", "")).split(".")[:2])
    libraries = {name: str(installed[name]) for name in LIBRARIES if name in installed}
    return {"python": python, **libraries, "source": source}


def package_digest() -> str:
    """SHA-256 of the source that numbers come from: the folders and files of `SOURCES`."""
    package = Path(__file__).parents[1]
    digest = hashlib.sha256()
    sources = (package / name for name in SOURCES)
    for file in sorted(file for source in sources for file in ([source] if source.is_file() else source.rglob("*.py"))):
        digest.update(f"{file.relative_to(package).as_posix()}\0".encode() + file.read_bytes())
    return digest.hexdigest()


def _changed_values(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[str]:
    """Sentences on keys of two nested tables that differ; of long lists of one length on the first place that does."""
    before, after = flattened(old), flattened(new)
    for key in dict.fromkeys((*before, *after)):
        was, now = before.get(key, ABSENT), after.get(key, ABSENT)
        if was is not ABSENT and now is not ABSENT and _is_same(was, now):
            continue
        if isinstance(was, list) and isinstance(now, list) and len(was) == len(now) > SHOWN:
            places = [place for place in range(len(was)) if not _is_same(was[place], now[place])]
            more_text = f", and {len(places) - 1} more of its values" if len(places) > 1 else ""
            first = f"value {places[0] + 1} was {_setting_words(was[places[0]])}, is {_setting_words(now[places[0]])}"
            yield f"{key}: {first}{more_text}"
        else:
            yield f"{key}: was {_setting_words(was)}, is {_setting_words(now)}"


def _is_same(was: Any, now: Any) -> bool:
    return json.dumps(was) == json.dumps(now)  # 1 and true are equal, and are not the same


def _setting_words(setting: Any) -> str:
    if setting is ABSENT:
        return "absent"
    if isinstance(setting, list) and len(setting) > SHOWN:
        return f"{len(setting)} values from {_setting_words(setting[0])} to {_setting_words(setting[-1])}"
    return json.dumps(setting, ensure_ascii=False)


def _changed_records(old: Sequence[Mapping[str, Any]], new: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    before, after = _by_name(old), _by_name(new)
    for name in before:
        if name not in after:
            yield f"record {name}: was one of the study, is not now"
    for name, now in after.items():
        if name not in before:
            yield f"record {name}: was not one of the study, is now"
        elif before[name] != now:
            yield f"record {name}: {_changed_record(before[name], now)}"
    common = [name for name in before if name in after]
    if common != [name for name in after if name in before]:
        yield f"records: was the order {', '.join(common)}, is {', '.join(name for name in after if name in before)}"


def _by_name(records: Sequence[Mapping[str, Any]]) -> dict[str, Mapping[str, Any]]:
    """Records under their names; records of an equal name get a number after the first."""
    by_label: dict[str, Mapping[str, Any]] = {}
    for record in records:
        name, count = str(record["name"]), 1
        while (label := name if count == 1 else f"{name} ({count})") in by_label:
            count += 1
        by_label[label] = record
    return by_label


def _changed_record(was: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    if was["sha256"] != now["sha256"]:
        return "its file holds other bytes than before"
    if was.get(HISTORY) != now.get(HISTORY):
        return "the displacement_history of a building under it is another file, or holds other bytes than before"
    steps = [f'was "{step}"' for step in was["processing"] if step not in now["processing"]]
    steps += [f'is "{step}"' for step in now["processing"] if step not in was["processing"]]
    return f"the same file is processed or scaled otherwise{': ' if steps else ''}{'; '.join(steps)}"
