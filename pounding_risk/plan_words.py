"""What a run takes in words: cases, lines, chunks, bytes, memory, compiling and time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pounding_risk.plan import Plan

HERE = "`scan --plan`"
BESIDE = ", and the responses without contact"


def run_words(plan: Plan) -> Iterator[tuple[str, str]]:
    """What is to be run, and what that takes; one pair a line."""
    yield "cases", _cases(plan)
    yield "lines", _lines(plan)
    yield "dataset", f"{_bytes(plan.bytes)} before compression"
    if plan.chunks is not None:
        yield "chunks", f"about {plan.chunks}, each kept on disk as it is done"
    yield "memory", f"about {_bytes(plan.memory)}" + ("" if plan.screened is not None else BESIDE)
    yield "compiling", _compiling(plan)
    yield "time", _time(plan)
    for sentence in plan.changes:
        yield "changed", sentence


def _cases(plan: Plan) -> str:
    factors = [f"{count} {name.replace('_', ' ')}s" for name, count in plan.shape.items() if count > 1]
    factors = [factor.replace("polaritys", "polarities") for factor in factors]
    return f"{plan.cases} = {' × '.join(factors)}" if len(factors) > 1 else str(plan.cases)


def _lines(plan: Plan) -> str:
    """A line is what is solved at once: all yield forces of a gap."""
    width = plan.shape["yield_force"]
    each = f"{plan.lines}, each a motion, a contact model and a gap" + (f" with {width} yield forces" * (width > 1))
    if plan.screened is None:
        return f"{each}; how many of them touch is not known yet, {HERE} finds it"
    share = 100.0 * plan.screened / plan.lines
    return f"{each}; {plan.screened} ({share:.0f} %) close no gap and are known from the motion without contact"


def _compiling(plan: Plan) -> str:
    kernels = plan.kernels
    if kernels.interpreted:
        return "switched off by NUMBA_DISABLE_JIT: every line takes some hundred times as long"
    if kernels.whole:
        return "nothing: all is compiled"
    parts = [] if kernels.motion else ["the motion without contact"]
    parts += [] if kernels.solver else ["the solver of rows, once for all contact models"]
    if kernels.missing:
        when = " (by each process)" if kernels.at_each_start else ""
        parts.append(f"{kernels.missing} contact model{'s' * (kernels.missing > 1)}{when}")
    told = f"{_joined(parts)}: about {kernels.seconds:.0f} s"
    return f"compiled just now: {told}" if plan.compiled else f"not compiled yet: {told}"


def _joined(parts: list[str]) -> str:
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)


def _time(plan: Plan) -> str:
    if plan.seconds is None:
        if plan.kernels.interpreted:
            return f"not known, since nothing is compiled; {HERE} times a sample all the same"
        return f"not known, since not all is compiled; {HERE} compiles and times a sample"
    threads = f"on {plan.threads} thread{'s' * (plan.threads > 1)}"
    sample = f"{plan.sampled} line{'s' * (plan.sampled > 1)}"
    return (
        f"about {duration(plan.seconds)} {threads}, ± {duration(plan.error or 0.0)}: from {sample} solved here; "
        "without compiling and writing"
    )


def duration(seconds: float) -> str:
    """A time as one says it: 0.8 s, 42 s, 12 min, 3 h 20 min."""
    if seconds < 9.5:
        return f"{max(seconds, 0.1):.1f} s"
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    if minutes < 60:
        return f"{minutes} min"
    return f"{minutes // 60} h {minutes % 60} min" if minutes < 6000 else f"{minutes / 1440:.1f} days"


def _bytes(size: int) -> str:
    for unit, scale in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= scale:
            return f"{size / scale:.3g} {unit}"
    return f"{size} bytes"
