"""Section on a row: elevation, plan, contact points, storeys with and without pounding, its ends and its interior."""

from __future__ import annotations

from math import nan

import numpy as np

from pounding_risk.assessment.row import ContactPoint, RowCase, Touch
from pounding_risk.figures.elevation import elevation_figure, elevation_finding, where_words
from pounding_risk.figures.plan_view import plan_figure, plan_finding
from pounding_risk.figures.storey_profiles import amplification, profiles_figure, profiles_finding
from pounding_risk.figures.style import svg_text
from pounding_risk.render.sheet import (
    Block,
    Cell,
    amount,
    count,
    figure,
    head,
    middle,
    number,
    paragraph,
    percentiles,
    table,
)
from pounding_risk.reports.data import ReportData

TITLE = "The row"
ORDER = 50

OF_TOUCH = [("motions", "r"), ("with contact [%]", "r"), ("reach F_E [%]", "r"), ("impacts, median", "r")]
OF_TOUCH += [(head("peak force, median", "N"), "r")]
POSITIONS = ("end", "interior")


def write(data: ReportData) -> list[Block]:
    """Drawings and tables of contact points and storeys; nothing where the interfaces say all."""
    if not data.has_points:
        return []
    case = data.row
    where = where_words(case)
    blocks = [
        paragraph(f"{elevation_finding(case)}."),
        figure(
            "row-elevation",
            svg_text(elevation_figure(case, titled=False)),
            f"The row in elevation, {where}. Heights are to scale, widths nominal, gaps drawn larger. Colour: share of "
            "the motions with contact; a thick rim: some reach F_E.",
            f"Elevation of {len(case.buildings)} buildings with {len(case.points)} contact points. "
            f"{elevation_finding(case)}. The tables below have the numbers.",
        ),
        table(f"Neighbours, {where}.", [("neighbours", "l"), (head("gap", "m"), "r"), *OF_TOUCH], _interfaces(case)),
        _points(case, where),
    ]
    if len(case.buildings) > 2:  # of two it would say what the elevation says
        blocks[0] = paragraph(f"{elevation_finding(case)}. {plan_finding([case])}.")
        blocks.append(
            figure(
                "row-plan",
                svg_text(plan_figure(case, titled=False)),
                f"The row in plan, {where}: share of the motions in which a building touches a neighbour, and in which "
                "a contact of it reaches F_E.",
                f"Plan of {len(case.buildings)} buildings. {plan_finding([case])}.",
            )
        )
    return blocks + _storeys(case, where)


def _interfaces(case: RowCase) -> list[list[Cell | str]]:
    return [
        [name, number(gap, "m"), *_touch(touch)]
        for name, gap, touch in zip(case.interfaces, case.gaps, case.touches, strict=True)
    ]


def _touch(touch: Touch) -> list[Cell | str]:
    """Cells of a contact, as the columns of `OF_TOUCH`."""
    shares = [number(share, "%", 3) for share in (touch.contact, touch.yielding)]
    return [count(touch.runs), *shares, number(touch.impacts), number(touch.force, "N")]


def _points(case: RowCase, where: str) -> Block:
    heads = [("neighbours", "l"), ("left floor", "r"), ("right floor", "r"), ("kind", "l"), ("level [m]", "r")]
    rows = [_point(case, point) for point in case.points]
    most = sorted(range(len(rows)), key=lambda at: -np.nan_to_num(case.points[at].touch.contact))[:12]
    return table(
        f"Contact points, {where}. Floor 2.4 is 0.4 up the columns of storey 3.",
        [*heads, *OF_TOUCH],
        rows,
        keep=sorted(most),
        note="those with most contact",
    )


def _point(case: RowCase, point: ContactPoint) -> list[Cell | str]:
    floors = [number(floor, digits=3) for floor in (point.left_floor, point.right_floor)]
    return [case.interfaces[point.interface], *floors, point.kind, number(point.level), *_touch(point.touch)]


def _storeys(case: RowCase, where: str) -> list[Block]:
    """Profiles, and the change of drift and acceleration by contact, building by building, ends and interiors apart."""
    raised = [amplification(case, at) for at in range(len(case.buildings))]
    if not np.isfinite(raised).any():
        return [paragraph("No building with storeys touches a neighbour; the buildings move as if alone.")]
    shaken = [amplification(case, at, "peak_floor_acceleration") for at in range(len(case.buildings))]
    rows: list[list[Cell | str]] = [
        [building.name, building.position, number(drift, digits=3), number(acceleration, digits=3)]
        for building, drift, acceleration in zip(case.buildings, raised, shaken, strict=True)
    ]
    for position in POSITIONS:
        same = [at for at, building in enumerate(case.buildings) if building.position == position]
        if len(case.buildings) < 3 or not same:  # two buildings are the table's own rows
            continue
        cells = [middle(percentiles([values[at] for at in same] or [nan]), "1") for values in (raised, shaken)]
        who = f"{len(same)} {position}{'s' if len(same) != 1 else ''}"
        rows.append([f"{who}: median (16 to 84 %)", "", *cells])
    impulse = _of_runs(case, "row_impulse", "N s")
    lost = _of_runs(case, "row_energy_lost", "J")
    return [
        figure(
            "row-profiles",
            svg_text(profiles_figure(case, titled=False)),
            f"Storeys with and without contact, {where}, in the motions in which each building touches a neighbour.",
            f"Drift, shear and acceleration against height. {profiles_finding(case)}.",
        ),
        paragraph(
            f"{profiles_finding(case)}. Per motion the row's contacts have an impulse of {impulse} and take {lost}."
        ),
        table(
            f"With contact over without, median of the motions in which the building touches, {where}.",
            [("building", "l"), ("in the row", "l"), ("largest storey drift", "r"), ("largest acceleration", "r")],
            rows,
            keep=[*range(min(len(case.buildings), 10)), *range(len(case.buildings), len(rows))],
            note="the first buildings and the summary",
        ),
    ]


def _of_runs(case: RowCase, name: str, unit: str) -> str:
    """Median of an output of the whole row, over the motions with contact anywhere."""
    touched = (case.results["impact_count"] > 0).any("interface")
    values = case.results[name].where(touched).values
    finite = values[np.isfinite(values)]
    return f"{amount(np.median(finite), unit)['text']} in the median" if finite.size else "nothing"
