"""The case files that ship with the package."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

SUFFIX = ".toml"


def shipped() -> dict[str, Path]:
    """The case files of the package by name, in the order of their names."""
    folder = Path(str(files("pounding_risk.lab.verification") / "cases"))
    return {file.stem: file for file in sorted(folder.glob(f"*{SUFFIX}"))}
