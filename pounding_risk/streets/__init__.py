"""A street's table or footprints as rows of buildings and scenes.

The names that scripts use stand here, beside `pounding_risk.read_block`: ``pr.streets.Contact(yield_force="5 MN")``.
They are imported on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOMES = {
    "Contact": "scenes",
    "horizontal_records": "scenes",
    "shares": "scenes",
    "Rules": "defaults",
    "Block": "rows",
    "read_inventory": "inventory",
}

__all__ = [*_HOMES]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
