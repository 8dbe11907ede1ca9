"""Where laws and rules are from, and what it takes to run the study again."""

from __future__ import annotations

from pounding_risk.reports.content import MISSING, Block, facts, heading, listing, paragraph, source, table
from pounding_risk.reports.material import Material
from pounding_risk.separation_rules import RULES


def references(material: Material) -> list[Block]:
    """The sources of the contact laws and effects that took part, and of the rules of codes."""
    found = [each.strip() for each in str(material.results.attrs.get("references", "")).split(";")]
    return [
        paragraph("Contact laws and effects of this study:"),
        listing(dict.fromkeys(each for each in found if each)),
        paragraph("Rules of codes: clause, formula, and whether the clause was read or derived here:"),
        listing(_rules()),
    ]


def _rules() -> list[str]:
    told = []
    for rule in RULES.values():
        verified = "verified" if rule.verified else "NOT verified"
        told.append(f"{rule.title}: {rule.clause}; {rule.formula}; {verified}: {rule.source}.")
    return told


def provenance(material: Material) -> list[Block]:
    """The scene as written and as resolved, how it was run, versions, record files and what was done to them."""
    told = material.results.attrs
    blocks = [
        paragraph(
            "To run this study again, save the scene below under the name that the first command has for it, give the "
            "commands, and compare the checksums of the record files."
        ),
        source("Commands.", "\n".join(_commands(material))),
        source("The scene, as written.", str(told.get("scene", ""))),
        facts("Versions.", sorted(material.facts("versions", {}).items())),
        _files(material),
        heading("Origin and terms of the records", "origins"),
        listing(_origins(material)),
        heading("Processing", "processing"),
        listing(_steps(material)),
        source("The scene, every value stated.", str(told["scene_resolved"])),
    ]
    if material.checksum:
        blocks.append(facts("This report was written from", [("results file, sha256", material.checksum)]))
    return blocks


def _commands(material: Material) -> list[str]:
    """The command that made the dataset, where one did, or one that makes the same."""
    told = material.results.attrs
    if told.get("command"):
        scan = str(told["command"])
    else:
        changed = "".join(f" --set '{each}'" for each in material.facts("overrides", []))
        scan = f"pounding-risk scan scene.toml -o results.nc{changed}"
    return [scan, "pounding-risk report results.nc -o report.html"]


def _files(material: Material) -> Block:
    heads = [(words, "l") for words in ("record", "file", "format", "sha256")]
    rows = [
        [name, *(str(one.get(key) or MISSING) for key in ("file", "format", "sha256"))]
        for name, one in material.records.items()
    ]
    return table("Record files.", heads, rows)


def _origins(material: Material) -> list[str]:
    """Where records are from and on what terms; those from one place share a line."""
    alike: dict[str, list[str]] = {}
    for name, one in material.records.items():
        told = "; ".join(str(one[key]) for key in ("origin", "terms") if one.get(key))
        alike.setdefault(told or "not told by the file", []).append(name)
    return [f"{_who(names, material)}: {told}" for told, names in alike.items()]


def _who(names: list[str], material: Material) -> str:
    """Records by name, or all of them."""
    return "all records" if len(names) == len(material.records) > 1 else ", ".join(names)


def _steps(material: Material) -> list[str]:
    """What was done to each record; records treated alike share a line."""
    alike: dict[tuple[str, ...], list[str]] = {}
    for name, steps in material.facts("processing", {}).items():
        alike.setdefault(tuple(steps), []).append(name)
    return [f"{_who(names, material)}: {' → '.join(steps) or 'as found'}" for steps, names in alike.items()]
