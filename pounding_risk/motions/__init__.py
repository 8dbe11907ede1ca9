"""From the file of a record to a ground acceleration in m/s²: reading, processing, measures, scaling, selection.

The names that scripts use stand here. They are imported on first use, so that importing the package is cheap:

    >>> from pounding_risk import motions
    >>> motion = motions.read_motion("RSN6-180", pga="0.5 g")
    >>> round(motions.measure(motion.acceleration, motion.dt).arias, 2)
    4.89
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOMES = {
    "motion": ("Motion",),
    "read": ("read_motion", "read_trace", "read_stream", "generate_motion"),
    "generated": ("motion_kinds", "recipe"),
    "write": ("write_motion", "write_columns"),
    "processing": ("known_steps", "read_steps"),
    "intensity": (
        *("measure", "response_spectra", "rotated_spectra"),
        *("husid_curve", "cumulative_absolute_velocity", "significant_duration"),
    ),
    "scaling": (
        *("by_factor", "to_pga", "to_pgv"),
        *("to_spectral_acceleration", "to_mean_spectral_acceleration", "to_median"),
    ),
    "rotation": ("rotated",),
    "target_spectra": ("Target", "read_target", "asce7", "eurocode8"),
    "selection": ("select",),
    "manifest": ("read_manifest", "write_manifest", "check_manifest"),
    "catalogue": ("entries",),
    "record_sets": ("members",),
}
_MODULES = {name: module for module, names in _HOMES.items() for name in names}

__all__ = [*_MODULES]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
