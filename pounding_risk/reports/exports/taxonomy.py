"""A table of the buildings with what was found in the words of exposure models: GEM taxonomy 3.3, and OED's Pounding.

Positions and pounding potential are those of GEM's glossary, terms BPD and POP: a building adjoins another one whose
gap is less than 4 % of the height of the lower of both. POP is written by what the motions did, and not by that share.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isnan, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk._common.letters import csv_text
from pounding_risk._common.words import nearest
from pounding_risk._common.written import write_file
from pounding_risk.assessment.assess import Assessment, InterfaceAssessment, assess
from pounding_risk.assessment.options import percent_words
from pounding_risk.errors import PoundingError
from pounding_risk.reports.exports import Options, Written
from pounding_risk.reports.exports._layers import closing_motions, lost_words, not_run_words, share_of_building
from pounding_risk.results.attributes import read_attribute, tables_of
from pounding_risk.scene.sections import written_overrides
from pounding_risk.streets.inventory import read_inventory
from pounding_risk.streets.inventory.gem import read_taxonomy, with_found
from pounding_risk.units import GAP, say, shown

WORDS = "each building with its GEM taxonomy string (BP1, BP2, POP) and OED's code of pounding"
ENDINGS = (".csv",)
SOURCE = "results"
TAKES = ("gap", "pga", "intensity_level", "inventory")
ADJOINING = 0.04  # of the height of the lower building; a smaller gap adjoins
CODES = ((0.25, 1), (0.5, 2), (1.0, 3), (2.0, 4), (inf, 5))  # m; OED: 1 is 0 to 0.25 m, 5 is more than 2 m
HEADS = (
    *("building", "GEM taxonomy", "position", "POP", "OED Pounding", "nearest gap [m]", "nearest building"),
    *("P(contact)", "P(contact) low", "P(contact) high", "most contact with", "amplitude", "taxonomy of"),
    *("rule of the position", "rule of POP", "rule of OED Pounding"),
)
# Strings of typologies, of which a scene says no more.
STRINGS = {
    "concrete_frame": "CR/LFM",
    "steel_frame": "S/LFM",
    "braced_frame": "S/LFBR",
    "concrete_walls": "CR/LWAL",
    "masonry": "MUR/LWAL",
}


class Side(NamedTuple):
    """A neighbour in the row."""

    neighbour: str
    height: float  # m, NaN where the scene gives none
    interface: InterfaceAssessment


def write(results: xr.Dataset, target: Path, options: Options) -> Written:
    """Write the table at one gap and amplitude, as `assess` takes them; raises PoundingError as it does."""
    assessment = assess(results, gap=options.gap, pga=options.pga, intensity_level=options.intensity_level)
    names = [str(name) for name in results["building"].values]
    strings, without = _strings(results, names, options.inventory)
    column = results["building_height"].values if "building_height" in results.variables else np.full(len(names), nan)
    heights = [float(height) if height > 0.0 else nan for height in column]
    rows, closes = [], closing_motions(results, assessment)
    for number, name in enumerate(names):
        pairs = [(other, min(other, number)) for other in (number - 1, number + 1) if 0 <= other < len(names)]
        sides = tuple(Side(names[other], heights[other], assessment.interfaces[k]) for other, k in pairs)
        rows.append(_row(name, heights[number], sides, strings[name], closes[:, [k for _, k in pairs]], assessment))
    notes = [
        "positions are those in the row; what stands in front of a building and behind it is not in the results, so "
        "that BP3 is never written",
        f"POP is written where more than {percent_words(assessment.target)} of the motions close a gap of the building",
        *not_run_words(assessment),
        *without,
    ]
    if lost_count := int(np.isnan(closes[0]).any(axis=0).sum()):
        notes.append(lost_words(lost_count, closes.shape[-1]))
    unknown = [row[0] for row in rows if not row[2]]
    if unknown:
        notes.append(f"no position of {', '.join(unknown)}: the scene gives no height; write height in [[building]]")
    text = csv_text([HEADS, *rows])
    return Written((write_file(target, text),), tuple(notes))


def _row(
    name: str, height: float, sides: tuple[Side, ...], string: tuple[str, str], closes: Any, assessment: Assessment
) -> tuple[Any, ...]:
    """The cells of a building; ``closes`` as `closing_motions`, of its interfaces."""
    position, rule = _position(height, sides)
    governing = max(sides, key=lambda side: side.interface.contact_at_gap().probability)
    verdicts = [side.interface.verdict for side in sides]
    weight = min(verdict.independent / verdict.motions for verdict in verdicts)
    share, low, high = share_of_building(closes, weight, assessment.confidence)
    has_pounding = share > assessment.target
    may_pound = np.nan_to_num(closes[1], nan=1.0).max(axis=0).mean() > assessment.target
    closest = min(sides, key=lambda side: side.interface.gap)
    gap = closest.interface.gap
    target = percent_words(assessment.target)
    return (
        name,
        with_found(string[0], position, has_pounding),
        position,
        "yes" if has_pounding else "not known" if may_pound else "no",
        oed_code(gap),
        f"{gap:.6g}",
        closest.neighbour,
        *(f"{share:.6g}" for share in (share, low, high)),
        governing.neighbour,
        governing.interface.at,
        string[1],
        rule,
        f"written where more than {target} of the motions close a gap; {round(share * closes.shape[-1])} of "
        f"{closes.shape[-1]} do",
        f"nearest building of the row, {say(gap, GAP)} clear",
    )


def _position(height: float, sides: tuple[Side, ...]) -> tuple[str, str]:
    """The position of a building in its row, "" where a height that it hangs on is not known, and its rule."""
    adjoining = 0
    for side in sides:
        lower = nan if isnan(height) or isnan(side.height) else min(height, side.height)
        if side.interface.gap > 0.0 and isnan(lower):
            return "", "a height is not known"
        adjoining += side.interface.gap == 0.0 or side.interface.gap < ADJOINING * lower
    rule = f"sides in the row with a gap below {percent_words(ADJOINING)} of the height of the lower building"
    return (f"BP{adjoining}" if adjoining else "BPD"), rule


def oed_code(gap: float) -> int:
    """The code of OED for the distance [m] to the nearest building."""
    return next(code for limit, code in CODES if gap < limit)


def _strings(
    results: xr.Dataset, names: list[str], inventory: Path | None
) -> tuple[dict[str, tuple[str, str]], list[str]]:
    """The string of each building and where it is from, and a note on those without one in the inventory.

    That of an inventory where it has one, else that of its typology and storeys.
    """
    # A typology stands in the scene as it was written alone: of every value stated, its storeys are.
    written = written_overrides(str(results.attrs.get("scene", "")), read_attribute(results, "overrides", []), "scene")
    stated = tables_of(str(results.attrs.get("scene_resolved", "")))
    typologies = {
        str(table.get("name", "")): table.get("typology", "") for table in tables_of(written).get("building", [])
    }
    own_strings = {
        name: _of_scene(table, str(typologies.get(name, "")))
        for table in stated.get("building", [])
        if (name := str(table.get("name", "")))
    }
    by_name = {name: (own_strings.get(name, ""), "the scene") for name in names}
    if inventory is None:
        return by_name, []
    # Without names of its own it may have been joined to a map, which numbers buildings in another order.
    known = {str(one.values["name"]): one.taxonomy for one in read_inventory(inventory).entries if "name" in one.values}
    if not set(known) & set(names):
        hint = nearest(names[0], known)
        raise PoundingError(f"{inventory}: has none of the buildings, such as {shown(names[0])}{hint}; check the names")
    without = []
    for name in names:
        try:
            read_taxonomy(known.get(name, ""))
            by_name[name] = known[name], inventory.name
        except PoundingError:
            without.append(name)
    note = f"{counted(len(without), 'building')} without a GEM string in {inventory.name}: {', '.join(without)}"
    return by_name, [f"{note}; what the scene says is written"] if without else []


def _of_scene(table: Mapping[str, Any], typology: str) -> str:
    """Material, system and storeys of a building of a scene, as far as it says them."""
    kind = STRINGS.get(typology.removesuffix("_ec8"), "")
    lists = (len(numbers) for key, numbers in table.items() if key.startswith("storey_") and isinstance(numbers, list))
    storeys = table.get("storeys") or next(lists, 0)
    return "/".join(filter(None, (kind, f"H:{storeys}" if storeys else "")))
