"""Seismic pounding of adjacent buildings: from strong-motion records to an assessment of gaps.

Every command of the command line is one function here, under the same name. They are imported on first use, so
that ``import pounding_risk`` costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "demo": "paper",
    "validate": "plan",
    "impact": "collision",
    "contact_law": "own_law",
    "simulate": "history",
    "scan": "ensemble",
    "scan_shard": "ensemble",
    "rerun": "reruns",
    "histories": "case_histories",
    "compare": "comparison",
    "accuracy": "ladder",
    "stability": "hard",
    "effects": "effect_costs",
    "modes": "modal",
    "PoundingError": "errors",
    "Stopped": "errors",
    "read_scene": "scenario",
    "read_motion": "motions",
    "code_table": "separations",
    "assess": "assessment",
    "view": "explorer",
    "report": "reports",
    "draw": "row_pictures",
    "animate": "animation",
    "block": "blocks",
    "read_block": "blocks",
    "status": "study_status",
    "convert": "conversion",
    "summary": "summaries",
    "open_results": "results",
    "save": "results",
}

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
