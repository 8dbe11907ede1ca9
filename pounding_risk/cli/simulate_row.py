"""What `simulate` prints of a row: what its interfaces, contact points and buildings went through."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pounding_risk.cli._common.tables import engineering, print_pairs, print_table, print_unused
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pathlib import Path

    from pounding_risk.scene.scene import Study

OF_BUILDINGS = {
    "peak_displacement": "m",
    "peak_drift": "m",
    "peak_storey_shear": "N",
    "peak_floor_acceleration": "m/s2",
}


def check_moving(study: Study, target: Path | None) -> Study:
    """The study; raises PoundingError for a pair that is to be animated."""
    if not study.is_row and target is not None:
        raise PoundingError(
            "--animation: shows a row, and this scene is a pair of single masses; draw its run with --figure run.png"
        )
    return study


def move(dataset: Any, target: Path | None) -> None:
    """Write the animation of a run where a file is named."""
    if target is not None:
        from pounding_risk.reports.animation import animate

        print(f"written: {animate(dataset, target)}")


def print_row_run(dataset: Any) -> None:
    """The case, then tables of interfaces, of the contact points that touch, and of buildings."""
    told = dataset.attrs
    print_pairs(
        [
            ("scene", told["title"]),
            ("record", f"{told['record']}, {told['polarity']}, PGA {engineering(told['pga'], 'm/s2')}"),
            ("contact model", told["contact_model"]),
            ("status", told["status"]),
        ]
    )
    print_unused(dataset)
    heads = ("impacts", "first", "peak force", "impulse", "reaches F_E")
    print()
    gaps = [engineering(float(gap), "m") for gap in dataset["interface_gap"].values]
    rows = [(str(name), gap) for name, gap in zip(dataset["interface"].values, gaps, strict=True)]
    lines = [(*row, *_touch(dataset.isel(interface=at), "")) for at, row in enumerate(rows)]
    print_table(("neighbours", "gap", *heads), lines, "lrrrrrr")
    print()
    _print_points(dataset, heads)
    print_table(
        ("building", *(name.replace("_", " ") for name in OF_BUILDINGS)),
        [
            (
                str(building),
                *(engineering(float(dataset[name].values[at]), unit) for name, unit in OF_BUILDINGS.items()),
            )
            for at, building in enumerate(dataset["building"].values)
        ],
        "lrrrr",
    )


def _print_points(dataset: Any, heads: tuple[str, ...]) -> None:
    touched = [at for at, count in enumerate(dataset["contact_point_impact_count"].values) if count > 0]
    if not touched:
        print("no contact\n")
        return
    points = dataset.isel(contact_point=touched)
    lines = [
        (
            str(name),
            str(points["contact_point_kind"].values[at]),
            *_touch(points.isel(contact_point=at), "contact_point_"),
        )
        for at, name in enumerate(points["contact_point"].values)
    ]
    print_table(("contact point", "kind", *heads), lines, "llrrrrr")
    print()


def _touch(one: Any, prefix: str) -> tuple[str, ...]:
    """Impacts, first touch, peak force, impulse, whether it reaches F_E; – for what a failed run does not have."""
    count, yields = (int(one[f"{prefix}{name}"]) for name in ("impact_count", "yield_exceedance"))
    values = (("first_impact_time", "s"), ("peak_contact_force", "N"), ("impulse", "N s"))
    numbers = [engineering(float(one[f"{prefix}{name}"]), unit) for name, unit in values]
    return (str(count) if count >= 0 else "–", *numbers, {0: "no", 1: "yes"}.get(yields, "–"))
