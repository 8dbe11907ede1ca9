"""Figures from datasets alone: no solver runs. Each title states the finding, with numbers taken from the data.

A kind of figure is one module of this folder, and every function of these modules whose name ends in ``_figure`` is a
name of this package: ``figures.scan_figure(dataset)``. Modules are imported when a name is first asked for.
`results_figure` draws any dataset; `write` saves a figure. What a figure of one's own takes is here too: `blank`,
`title`, `styles` and `STYLES`, `law_words`, and `amplification`, by how much contact raises a building's response.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from typing import Any

from pounding_risk.figures.style import STYLES, blank, law_words, styles, title, write

__all__ = ["STYLES", "amplification", "blank", "law_words", "styles", "title", "write"]  # and what `__dir__` finds
_OTHERS = {"amplification": "row"}  # by the module that has it


def _find_figures() -> dict[str, Any]:
    """Every public function of the folder that makes a figure, by its name."""
    modules = [import_module(f"{__name__}.{module_info.name}") for module_info in iter_modules(__path__)]
    return {
        name: value
        for module in modules
        for name, value in vars(module).items()
        if name.endswith("_figure") and not name.startswith("_") and value.__module__ == module.__name__
    }


def __getattr__(name: str) -> Any:
    if name in _OTHERS:
        return getattr(import_module(f"{__name__}.{_OTHERS[name]}"), name)
    if name.endswith("_figure"):
        globals().update(_find_figures())
    if name not in globals():
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return globals()[name]


def __dir__() -> list[str]:
    return sorted({*globals(), *_OTHERS, *_find_figures()})
