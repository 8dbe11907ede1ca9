"""Scenes with uncertain numbers."""

from __future__ import annotations

from typing import Any

from axes import pair_text, row_text
from scenes import BOTH, scene_text

from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.toml import write_toml

PERIOD = {"distribution": "lognormal", "median": "0.5 s", "dispersion": 0.2}
MASS = {"distribution": "normal", "mean": "500 t", "cov": 0.1}
RESTITUTION = {"distribution": "uniform", "low": 0.4, "high": 0.8}
LEFT, RIGHT = "building.left.period", "building.right.period"
PERIODS = {
    LEFT: {"distribution": "lognormal", "dispersion": 0.3},
    RIGHT: {"distribution": "lognormal", "dispersion": 0.1},
}
PULSES = [{"kind": "ricker", "pga": "0.4 g", "period": f"{period} s"} for period in (0.4, 0.5, 0.6, 0.8, 1.0, 1.2, 1.5)]
THREE = {"building.left.period": PERIOD, "building.left.mass": MASS, "interface.restitution": RESTITUTION}


def uncertain_text(
    numbers: dict[str, Any] | None = None, samples: int = 4, axes: dict[str, Any] | None = None, **more: Any
) -> str:
    """A pair under a pulse at two gaps, with axes and uncertain numbers, beside which keys of [uncertain] may stand."""
    table = {"samples": samples} | (THREE if numbers is None else numbers)
    return f"{pair_text(axes or {}, **more)}\n{write_toml({'uncertain': table})}"


def uncertain_row_text(numbers: dict[str, Any], samples: int, grid: Any = None, interfaces: int = 1) -> str:
    """`row_text` with uncertain numbers, beside which keys of [uncertain] may stand."""
    return f"{row_text(grid or {}, interfaces)}\n{write_toml({'uncertain': {'samples': samples} | numbers})}"


def uncertain_pulses(
    numbers: dict[str, Any] | None = None, samples: int = 16, buildings: tuple = (), motions: str = "all", **more: Any
) -> Any:
    """A pair under pulses in both polarities, each its own recording, with uncertain numbers: both periods."""
    keys = {"samples": samples, "motions": motions} | (PERIODS if numbers is None else numbers)
    given = {"records": {"generated": PULSES, "polarity": BOTH}, "law": "linear", "gap": "80 mm"} | more
    return parse_scene(f"{scene_text(*buildings, **given)}\n{write_toml({'uncertain': keys})}")
