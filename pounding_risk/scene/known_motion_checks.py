"""Checks of the key ``displacement_history``, which more than one table of a scene takes part in."""

from __future__ import annotations

from collections.abc import Iterator

from pounding_risk.motions.request import REVERSED
from pounding_risk.scene.building_keys import INITIAL, OF_GROUND
from pounding_risk.scene.interface_checks import OF_LINKS
from pounding_risk.scene.keys import Draft
from pounding_risk.scene.toml import Fault

KEY = "displacement_history"  # of a building, and of the facts of a record that has histories beside it


def known_motion_checks(draft: Draft) -> Iterator[Fault]:
    """What a history does not go with: other motions of the building, own grounds, and motions that are not its own."""
    buildings = draft.tables("building")
    known = [keys for keys in buildings if KEY in keys]
    if not known:
        return
    name = known[0].raw.get("name", "a building")
    for keys in known:
        for key in INITIAL:
            if key in keys:
                yield keys.fault(key, f"the building begins as its {KEY} does; remove it")
    on_records = f"{name} has a {KEY}, which is relative to the ground of the records; remove it"
    for keys in buildings:
        yield from (keys.fault(key, on_records) for key in OF_GROUND if key in keys)
    for keys in draft.tables("interface"):
        for key in sorted(OF_LINKS & set(keys.raw)):
            if keys.get(key):
                yield keys.fault(key, f"{name} has a {KEY}, which no link can change; remove one of the two")
    if "wave_passage" in draft.table("effects").raw:
        yield Fault(("effects", "wave_passage"), on_records)
    records, grid = draft.table("records"), draft.table("grid")
    sentence = f"{name} has a {KEY}, which is its response to each record as it is"
    if REVERSED in records.get("polarity", ()):
        yield records.fault("polarity", f"{sentence}: how it responds to the reverse is not known; remove {REVERSED}")
    for table, key in ((grid, "pga"), (records, "intensity")):
        if len(table.get(key) or ()) > 1:
            yield table.fault(
                key, f"{sentence}, at one amplitude: it is never scaled; write one, or scan once for each"
            )
