"""Scenes with uncertain numbers."""

from __future__ import annotations

from typing import Any

from axes import pair_text

from pounding_risk.scene.toml import write_toml

PERIOD = {"distribution": "lognormal", "median": "0.5 s", "dispersion": 0.2}
MASS = {"distribution": "normal", "mean": "500 t", "cov": 0.1}
RESTITUTION = {"distribution": "uniform", "low": 0.4, "high": 0.8}
THREE = {"building.left.period": PERIOD, "building.left.mass": MASS, "interface.restitution": RESTITUTION}


def uncertain_text(
    numbers: dict[str, Any] | None = None, samples: int = 4, axes: dict[str, Any] | None = None, **more: Any
) -> str:
    """A pair under a pulse at two gaps, with axes and uncertain numbers, beside which keys of [uncertain] may stand."""
    table = {"samples": samples} | (THREE if numbers is None else numbers)
    return f"{pair_text(axes or {}, **more)}\n{write_toml({'uncertain': table})}"
