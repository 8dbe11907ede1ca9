"""Shares of the parts of a run in its time: ``python benchmarks/profile_run.py [GAP_MM YIELD_KN]``.

Counts the calls of the kernels' parts in one run of the benchmark's pair, which is made uncompiled for this (some
seconds): flights and what they pass over, steps in contact, and the repeated steps that landings and local maxima take.
"""

from __future__ import annotations

import os

os.environ["NUMBA_DISABLE_JIT"] = "1"  # before numba is imported: a compiled call cannot be counted

import sys
from collections import Counter
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
from throughput import LAW, RESTITUTION, RTOL, make_bench

from pounding_risk.solver.counters import COUNT
from pounding_risk.solver.pair import contact, events, explicit, flight, peaks
from pounding_risk.solver.pair import run as runs
from pounding_risk.solver.pair.api import Interface, free_response, run

MODULES = (explicit, events, flight, peaks, runs, contact)
# What is counted: a part and who calls it, and what that means.
WORDS = {
    ("begin_contact", "march"): "contacts",
    ("take_step", "integrate_contact"): "accepted steps",
    ("attempt", "take_step"): "attempts at them",
    ("land", "end_on"): "landings on an event",
    ("attempt", "land"): "attempts for landings",
    ("local_maximum", "update_peaks"): "local maxima searched inside a step",
    ("read_between", "local_maximum"): "looks at a step between its ends for local maxima",
    ("read_between", "refine_event"): "looks at a step between its ends for landings",
    ("slopes", "explicit_attempt"): "evaluations of the force in all attempts",
    ("block_mask", "fly"): "blocks of 16 samples looked at in flight",
    ("search_mask", "fly"): "sample intervals looked at in flight",
    ("search_interval", "fly"): "sample intervals searched",
}


def counted(module: ModuleType, name: str, calls: Counter[tuple[str, str]]) -> None:
    """Count the calls of a function through this module's name for it, by caller."""
    inner: Callable[..., Any] = getattr(module, name)

    def outer(*arguments: Any) -> Any:
        calls[name, sys._getframe(1).f_code.co_name] += 1
        return inner(*arguments)

    setattr(module, name, outer)


def profile(gap: float, yield_force: float) -> Counter[tuple[str, str]]:
    """Calls by (part, caller) in one run; gap [m], yield force [N]."""
    bench = make_bench()
    free = free_response(bench.pair, bench.acceleration, bench.dt)
    calls: Counter[tuple[str, str]] = Counter()
    for module in MODULES:
        for name in {name for name, _ in WORDS} & set(vars(module)):
            counted(module, name, calls)
    raw = run(bench.pair, free, Interface(gap, LAW, RESTITUTION, yield_force), RTOL)
    calls["begin_contact", "march"] = int(raw[COUNT])
    return calls


def main(arguments: list[str]) -> int:
    """Print the counts, and each per contact."""
    gap, strength = (float(word) for word in arguments) if arguments else (20.0, np.inf)
    calls = profile(gap * 1e-3, strength * 1e3)
    contacts = max(calls["begin_contact", "march"], 1)
    print(f"gap {gap:g} mm, F_E {strength:g} kN, rtol {RTOL:g}\n")
    print("| part | calls | a contact |\n| --- | ---: | ---: |")
    for place, words in WORDS.items():
        print(f"| {words} | {calls[place]:,} | {calls[place] / contacts:.1f} |")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
