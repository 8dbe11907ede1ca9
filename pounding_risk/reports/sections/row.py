"""Section on a row: elevation, plan, contact points, storeys with and without pounding, its ends and its interior."""

from __future__ import annotations

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.assessment.row import RowCase, Touch, force_text, share_of_building
from pounding_risk.figures import row as drawn
from pounding_risk.questions.notes import OF_LINKS
from pounding_risk.render import sheet
from pounding_risk.reports.data import ReportData
from pounding_risk.results.attributes import isolated_of

TITLE = "The row"
ORDER = 50

OF_TOUCH = ["motions", "with contact [%]", "reach F_E [%]", "impacts, median", sheet.head("peak force, median", "N")]
POSITIONS = ("end", "interior")


def write(data: ReportData) -> list[sheet.Block]:
    """Drawings and tables of contact points and storeys; nothing where the interfaces say all."""
    if not data.has_points:
        return []
    case = data.row
    place = drawn.where_words(case)
    interface_rows = zip(case.interfaces, case.gaps, case.touches, strict=True)
    interfaces = [[name, sheet.number(gap, "m"), *_touch(touch)] for name, gap, touch in interface_rows]
    blocks = [
        sheet.paragraph(f"{contact_finding(case)}."),
        sheet.figure(
            "row-elevation",
            lambda: drawn.elevation_figure(case, titled=False),
            f"The row in elevation, {place}. Heights are to scale, widths nominal, gaps drawn larger. Colour: share of "
            "the motions with contact; a thick rim: some reach F_E.",
            f"Elevation of {len(case.buildings)} buildings with {len(case.points)} contact points. "
            f"{contact_finding(case)}. The tables below have the numbers.",
        ),
        sheet.table(f"Neighbours, {place}.", ["neighbours", sheet.head("gap", "m"), *OF_TOUCH], interfaces),
        _points(case, place),
    ]
    if len(case.buildings) > 2:  # of two it would say what the elevation says
        blocks[0] = sheet.paragraph(f"{contact_finding(case)}. {struck_finding(case)}.")
        blocks.append(
            sheet.figure(
                "row-plan",
                lambda: drawn.plan_figure(case, titled=False),
                f"The row in plan, {place}: share of the motions in which a building touches a neighbour, and in which "
                "a contact of it reaches F_E.",
                f"Plan of {len(case.buildings)} buildings. {struck_finding(case)}.",
            )
        )
    return blocks + _links(case, place) + _storeys(case, place)


def contact_finding(case: RowCase) -> str:
    """Sentence on where contact is most likely, with which force, and whether it reaches F_E."""
    shares = [touch.contact for touch in case.touches]
    if not any(touch.runs for touch in case.touches):
        return f"No run of {counted(case.motions, 'motion')} is complete"
    if not np.nanmax(shares) > 0.0:
        return f"No contact in {counted(case.motions, 'motion')}"
    # Of several that touch as often, the one that is struck hardest.
    ranked = [(np.nan_to_num(touch.contact), np.nan_to_num(touch.force)) for touch in case.touches]
    worst = max(range(len(ranked)), key=ranked.__getitem__)
    most, is_several = case.touches[worst], len(shares) > 1
    extent = f"at {sum(share > 0.0 for share in shares)} of {len(shares)} interfaces, most often " if is_several else ""
    motions = f"{round(most.contact * most.runs)} of {counted(most.runs, 'motion')}"
    force = force_text(most.force)
    finding = f"Contact {extent}between {drawn.between(case.interfaces[worst])}: {motions}, {force} in the median"
    yields = np.nan_to_num([touch.yielding for touch in case.touches])
    if yields.max() > 0.0:
        share = f"{100 * yields.max():.0f} %"
        at_which = drawn.between(case.interfaces[int(yields.argmax())])
        finding += f"; F_E reached in {f'up to {share} ({at_which})' if is_several else share}"
    return finding


def struck_finding(case: RowCase) -> str:
    """Sentence on how many buildings touch in more than half of the motions, and which is struck most."""
    shares = np.array([share_of_building(case, "impact_count", k) for k in range(len(case.buildings))])
    highest = np.nanmax(shares, initial=0.0)
    if not highest > 0.0:
        return f"No building touches a neighbour in {counted(case.motions, 'motion')}"
    names = [building.name for building, share in zip(case.buildings, shares, strict=True) if share == highest]
    name = names[0] if len(names) == 1 else f"{len(names)} of them"
    often = f"{(shares > 0.5).sum()} of {shares.size} buildings touch a neighbour in more than half of the motions"
    return f"{often}; {name} most often, in {100 * highest:.0f} %"


def drift_finding(case: RowCase) -> str:
    """Sentence on how contact changes the largest storey drift, at the ends of the row and inside it."""
    clauses = []
    ends = " at the row's ends" if len(case.buildings) > 2 else ""
    for position, place_text in (("end", ends), ("interior", " inside the row")):
        indices = [k for k, one in enumerate(case.buildings) if one.position == position and drawn.has_storeys(one)]
        ratios = np.array([drawn.amplification(case, k) for k in indices])
        if np.isfinite(ratios).any():
            clauses.append(f"{np.nanmedian(ratios):.2f} times{place_text}")
    if not clauses:
        return f"No building with storeys touches a neighbour in {counted(case.motions, 'motion')}"
    return f"With contact the {_drift_words(case)} is {' and '.join(clauses)} what it is without, in the median"


def _drift_words(case: RowCase) -> str:
    return f"largest storey drift{' above isolators' * bool(isolated_of(case.results))}"


def _touch(touch: Touch) -> sheet.Row:
    """Cells of a contact, as the columns of `OF_TOUCH`."""
    shares = [sheet.number(share, "%", 3) for share in (touch.contact, touch.yielding)]
    return [sheet.count(touch.runs), *shares, sheet.number(touch.impacts), sheet.number(touch.force, "N")]


def _points(case: RowCase, where: str) -> sheet.Block:
    heads = ["contact point", "left floor", "right floor", "kind", "level [m]"]
    rows = []
    for point in case.points:
        floors = [sheet.number(floor, digits=3) for floor in (point.left_floor, point.right_floor)]
        place = [point.name, *floors, point.kind, sheet.number(point.level)]
        rows.append([*place, *_touch(point.touch)])
    kept = sorted(range(len(rows)), key=lambda k: -np.nan_to_num(case.points[k].touch.contact))[: sheet.KEPT]
    columns = " Floor 2.4 is 0.4 up the columns of storey 3." * any(point.kind == "column" for point in case.points)
    caption = f"Contact points, {where}.{columns}"
    return sheet.table(caption, [*heads, *OF_TOUCH], rows, keep=sorted(kept), note="those with most contact")


def _links(case: RowCase, place: str) -> list[sheet.Block]:
    """Stretch and forces of the links between neighbours, and how many break; nothing without links."""
    rows: list[sheet.Row] = []
    for k, name in enumerate(case.interfaces):
        for output, (words, unit) in OF_LINKS.items():
            peaks = case.results[output].isel(interface=k).values if output in case.results else np.zeros(0)
            if (finite := peaks[np.isfinite(peaks)]).size:
                spread = sheet.middle(sheet.percentiles(finite), unit)
                rows.append(
                    [name, sheet.head(words, unit), spread, sheet.number(finite.max(), unit), sheet.count(finite.size)]
                )
    heads = ["neighbours", "largest of their links", "median (16 to 84 %)", "largest", "motions"]
    return [sheet.table(f"Springs and dampers between neighbours, {place}.", heads, rows)] if rows else []


def _storeys(case: RowCase, place: str) -> list[sheet.Block]:
    """Profiles, and the change of drift and acceleration by contact, building by building, ends and interiors apart."""
    raised = [drawn.amplification(case, k) for k in range(len(case.buildings))]
    if not np.isfinite(raised).any():
        return [sheet.paragraph("No building with storeys touches a neighbour; the buildings move as without contact.")]
    shaken = [drawn.amplification(case, k, "peak_floor_acceleration") for k in range(len(case.buildings))]
    rows: list[sheet.Row] = [
        [building.name, building.position, sheet.number(drift, digits=3), sheet.number(acceleration, digits=3)]
        for building, drift, acceleration in zip(case.buildings, raised, shaken, strict=True)
    ]
    for position in POSITIONS:
        indices = [k for k, building in enumerate(case.buildings) if building.position == position]
        if len(case.buildings) < 3 or not indices:  # two buildings are the table's own rows
            continue
        cells = [sheet.middle(sheet.percentiles([ratios[k] for k in indices]), "1") for ratios in (raised, shaken)]
        rows.append([f"{counted(len(indices), position)}: median (16 to 84 %)", "", *cells])
    impulse, energy = _of_runs(case, "row_impulse", "N s"), _of_runs(case, "row_energy_lost", "J")
    return [
        sheet.figure(
            "row-profiles",
            lambda: drawn.profiles_figure(case, titled=False),
            f"Storeys with and without contact, {place}, in the motions in which each building touches a neighbour."
            + (f" {note}." if (note := drawn.of_which_buildings(case)) else ""),
            f"Drift, shear and acceleration against height. {drift_finding(case)}.",
        ),
        sheet.paragraph(
            f"{drift_finding(case)}. Per motion the row's contacts have an impulse of {impulse} and dissipate {energy}."
        ),
        sheet.table(
            f"With contact over without, median of the motions in which the building touches, {place}.",
            ["building", "in the row", _drift_words(case), "largest acceleration"],
            rows,
            keep=[*range(min(len(case.buildings), 10)), *range(len(case.buildings), len(rows))],
            note="the first buildings and the summary",
        ),
    ]


def _of_runs(case: RowCase, name: str, unit: str) -> str:
    """Median of an output of the whole row, over the motions with contact anywhere."""
    outputs = case.results[name].where((case.results["impact_count"] > 0).any("interface")).values
    finite = outputs[np.isfinite(outputs)]
    return f"{sheet.amount(np.median(finite), unit)['text']} in the median" if finite.size else "nothing"
