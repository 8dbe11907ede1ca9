"""Answers of the reference integrator of rows, kept in a file: it takes seconds a row and says the same each time.

An answer is kept under a digest of all that was asked: buildings, contact points, ground, step, tolerance, integrator.
It counts as long as the integrator's sources are those that gave it. Whatever is not kept is integrated, so that a
changed row or another integrator costs time, and no test an old number.

``python tests/kept_references.py`` integrates all of them anew and writes the file, in some minutes.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from oracle_rows import Answer, Meeting, Row

KEPT = Path(__file__).parent / "data" / "row_references.json"
SOURCES = ("rows", "rows_motion", "contact", "flight", "laws", "stiff")  # of the integrator, oracle_….py
ASKED_BY = ("rows_against_scipy", "overdamped_contacts", "rows_against_opensees")
OF_TOWERS = ("mass", "spring", "shear", "damping", "strength", "hardening", "foundations")
DIGITS = 10  # of what is asked; further ones depend on the machine's linear algebra
recorded: dict[str, Any] | None = None  # answers by digest, while the file is made


def source() -> str:
    """Digest of the integrator's sources."""
    texts = [(Path(__file__).parent / f"oracle_{name}.py").read_text(encoding="utf-8") for name in SOURCES]
    return hashlib.sha256("".join(texts).encode()).hexdigest()[:24]


def digits(value: Any) -> Any:
    """What is asked as JSON takes it; of an array the digits that count beside its largest entry."""
    if isinstance(value, str):
        return value
    if isinstance(value, tuple | list):
        return [digits(item) for item in value]
    numbers = np.asarray(value, dtype=float)
    largest = np.abs(numbers[np.isfinite(numbers)]).max(initial=0.0)
    scaled = np.round(numbers / (largest or 1.0), DIGITS) + 0.0  # no −0
    return [f"{largest:.{DIGITS - 1}e}", numbers.shape, scaled.tolist()]


def question(towers: Sequence[Any], meetings: Sequence[Meeting], *more: Any) -> str:
    """Digest of what is asked; ``more`` is the ground [m/s²], its step [s], the tolerance and the integrator's name."""
    buildings = [[getattr(tower, name) for name in OF_TOWERS] for tower in towers]
    return hashlib.sha256(json.dumps(digits([buildings, list(meetings), *more])).encode()).hexdigest()[:24]


@cache
def kept() -> dict[str, Any]:
    """Answers by the digest of their question; none, where other sources gave them."""
    found = json.loads(KEPT.read_text(encoding="utf-8"))
    return found["answers"] if found["source"] == source() else {}


def reference(
    towers: Sequence[Any], meetings: Sequence[Meeting], acceleration: np.ndarray, dt: float, rtol: float = 1e-12,
    integrator: type[Row] = Row,
) -> Answer:  # fmt: skip
    """A row from rest under a_g [m/s²] sampled every dt [s], as `oracle_rows.integrate` gives it."""
    asked = question(towers, meetings, acceleration, dt, rtol, integrator.__name__)
    if recorded is None and asked in kept():
        answer = kept()[asked]
        points = {name: np.array(values) for name, values in answer["points"].items()}
        floors, rest = (np.array(answer[name]).reshape(-1, width) for name, width in (("floors", 4), ("rest", 2)))
        return Answer(points, floors, rest, answer["open_energy"], np.array(answer["state"]))
    found = integrator(towers, meetings, rtol).go(acceleration, dt)
    if recorded is not None:
        points = {name: values.tolist() for name, values in found.points.items()}
        recorded[asked] = {
            "points": points,
            "floors": found.floors.tolist(),
            "rest": found.rest.tolist(),
            "open_energy": float(found.open_energy),
            "state": found.state.tolist(),
        }
    return found


def main() -> None:
    """Let the tests ask, integrate each answer, and write all."""
    import kept_references  # as the tests import it
    import pytest

    kept_references.recorded = {}
    here = Path(__file__).parent / "solver"
    code = pytest.main(["-q", "-p", "no:cacheprovider", *(str(here / f"test_{name}.py") for name in ASKED_BY)])
    if code:
        raise SystemExit(code)
    answers = sorted(kept_references.recorded.items())
    lines = ",\n".join(f"{json.dumps(asked)}: {json.dumps(answer)}" for asked, answer in answers)
    KEPT.write_text(f'{{"source": "{source()}", "answers": {{\n{lines}\n}}}}\n', encoding="utf-8")


if __name__ == "__main__":
    main()
