"""Target spectra: from a file, from the shapes of ASCE 7 and Eurocode 8, or the median of a published set.

    >>> from pounding_risk.motions.target_spectra import read_target
    >>> target = read_target("asce7:sds=1.0,sd1=0.6,tl=8")
    >>> (target.at([0.3, 1.2, 12.0]) / 9.80665).round(4).tolist()
    [1.0, 0.5, 0.0333]
    >>> read_target("ec8:ag=0.25 g,ground=B,type=1").name
    'ec8:ag=0.25 g,ground=B,type=1'

Ordinates are pseudo-spectral accelerations: codes go from them to displacements by (T/2π)².
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf, isclose, isfinite, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pounding_risk._common.inputs import SPECTRUM
from pounding_risk._common.tables import AGAIN, Row, Table, first_line, head_of, read_table, split_unit
from pounding_risk.errors import RecordError
from pounding_risk.motions import record_sets
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.motions.sites.places import split_site
from pounding_risk.units import PERIOD, PGA, STANDARD_GRAVITY, QuantityError, parse, shown

NODES = 200  # periods at which a shape is tabulated, besides its corners
SHORTEST, LONGEST, LONGEST_EC8 = 0.01, 10.0, 4.0  # s; EN 1998-1 ends at 4 s, and its annex A goes on
LEAST_ETA = 0.55
CONDITIONED = 0.02  # deviation of ln Sa at a period on which a spectrum is conditioned; rounding leaves up to 0.01
OF_MODELS = 0.05  # damping ratio of models of ground motion
# Columns of conditional spectra, by version of the OpenQuake engine.
WIDE = ("sa_period", "val0", "std0")
LONG = ("poe", "period", "mea", "std")
# EN 1998-1:2004, tables 3.2 and 3.3, recommended values: S, T_B, T_C, T_D [s] by type of spectrum and ground.
GROUNDS = {
    1: {
        "A": (1.0, 0.15, 0.4, 2.0),
        "B": (1.2, 0.15, 0.5, 2.0),
        "C": (1.15, 0.2, 0.6, 2.0),
        "D": (1.35, 0.2, 0.8, 2.0),
        "E": (1.4, 0.15, 0.5, 2.0),
    },
    2: {
        "A": (1.0, 0.05, 0.25, 1.2),
        "B": (1.35, 0.05, 0.25, 1.2),
        "C": (1.5, 0.1, 0.25, 1.2),
        "D": (1.8, 0.1, 0.3, 1.2),
        "E": (1.6, 0.05, 0.25, 1.2),
    },
}


@dataclass(frozen=True, eq=False)
class Target:
    """A target spectrum.

    Parameters
    ----------
    name : str
        Name, as in sentences.
    periods : array_like, shape (n,)
        Rising periods [s], from 0 up.
    acceleration : array_like, shape (n,)
        Pseudo-spectral accelerations [m/s²].
    damping : float
        Damping ratio.
    shape : callable, optional
        The formula of the ordinates [m/s²] over periods [s], where there is one.
    deviation : array_like, shape (n,), optional
        Standard deviation of ln Sa at the periods, where the target has one; its ordinates are medians then.
    origin : str
        Words on where it is from.

    Raises
    ------
    RecordError
        For arrays of different lengths, fewer than two periods, periods that do not rise from zero or above, and
        ordinates that are not above zero and finite.
    """

    name: str
    periods: Samples
    acceleration: Samples
    damping: float = 0.05
    shape: Callable[[Samples], Samples] | None = field(default=None, repr=False)  # the formula, where there is one
    deviation: Samples | None = field(default=None, repr=False)
    origin: str = ""

    def __post_init__(self) -> None:
        periods, values = (np.array(ordinates, dtype=np.float64) for ordinates in (self.periods, self.acceleration))
        if periods.ndim != 1 or periods.shape != values.shape or periods.size < 2:
            raise RecordError(
                f"{self.name}: {periods.size} periods and {values.size} ordinates; a target needs two or more of both"
            )
        if not (np.isfinite(periods).all() and periods[0] >= 0.0 and (np.diff(periods) > 0.0).all()):
            raise RecordError(f"{self.name}: the periods do not rise; sort them, each once, from 0 s up")
        if not (np.isfinite(values).all() and (values > 0.0).all()):
            raise RecordError(f"{self.name}: an ordinate is not above zero and finite; correct or leave it out")
        ordinates = {"periods": periods, "acceleration": values}
        if self.deviation is not None:
            ordinates["deviation"] = spread = np.array(self.deviation, dtype=np.float64)
            if spread.shape != periods.shape or not (np.isfinite(spread).all() and (spread >= 0.0).all()):
                raise RecordError(f"{self.name}: give a finite standard deviation of ln Sa, 0 or above, at each period")
        for key, value in ordinates.items():
            value.flags.writeable = False
            object.__setattr__(self, key, value)

    def at(self, periods: ArrayLike) -> Samples:
        """The ordinates [m/s²] at ``periods`` [s]: by the code's formula, or between tabulated ones.

        Those are joined by straight lines in logarithms, from a period of 0 by one in numbers. Raises RecordError for
        a period outside the target's.
        """
        at = np.asarray(periods, dtype=np.float64)
        outside = at[~((at >= self.periods[0] * (1 - 1e-12)) & (at <= self.periods[-1] * (1 + 1e-12)))]
        if outside.size:
            raise RecordError(
                f"{self.name}: is given from {self.periods[0]:g} to {self.periods[-1]:g} s, and {outside.flat[0]:g} s "
                "is requested; narrow the range of periods"
            )
        if self.shape:
            return self.shape(at)
        return self._joined(at, self.acceleration, np.log(self.acceleration), np.exp)

    @property
    def pivot(self) -> float | None:
        """The period [s] on whose Sa the target is conditioned, so that there is no deviation; None without one."""
        if self.deviation is None or self.deviation.min() > CONDITIONED:
            return None
        return float(self.periods[np.argmin(self.deviation)])

    def deviation_at(self, periods: ArrayLike) -> Samples:
        """The standard deviation of ln Sa, by straight lines over ln(period), and from a period of 0 over the period.

        Zero where the target has none; raises as `at`.
        """
        at = np.asarray(periods, dtype=np.float64)
        self.at(at)
        if self.deviation is None:
            return np.zeros(at.shape)
        return self._joined(at, self.deviation, self.deviation)

    def _joined(
        self, at: Samples, values: Samples, over_log: Samples, back: Callable[[Samples], Samples] = np.asarray
    ) -> Samples:
        """Values by straight lines of ``over_log`` over ln(period), and from a period of 0 over the period."""
        start = 1 if self.periods[0] == 0.0 else 0
        first = self.periods[start]
        joined = np.interp(np.log(np.maximum(at, first)), np.log(self.periods[start:]), over_log[start:])
        return np.where(at < first, np.interp(at, self.periods, values), back(joined))


def read_target(text: str | Path, *, damping: float = 0.05) -> Target:
    """Read the target spectrum that a text names.

    Parameters
    ----------
    text : str or Path
        One of

        - "asce7:sds=1.0,sd1=0.6,tl=8": the two-period design spectrum, S_DS and S_D1 in g, T_L in s;
        - "ec8:ag=0.25 g,ground=B,type=1": Eurocode 8, with ``damping=0.02`` for another than 5 %;
        - "fema-p695-farfield" or another published set: the geometric mean of its spectra as recorded;
        - a conditional spectrum that OpenQuake exported, with its deviation; after "#" the probability of exceedance
          where it has several, ``conditional-spectrum-0.csv#0.02``, or its column, ``#val1``;
        - a file: comma, semicolon or tab between two columns, and a first line that states both units, such as
          ``period [s], Sa [g]``; lines that begin with # are left out.
    damping : float
        Damping ratio of the spectrum of a file.

    Returns
    -------
    Target
        The target spectrum.

    Raises
    ------
    RecordError
        For what cannot be read, with the repair.
    """
    name = str(text)
    kind, _, parameters = name.partition(":")
    if kind.strip().lower() in SHAPES and isinstance(text, str):
        return _shape(name, kind.strip().lower(), parameters)
    if name in record_sets.SETS:
        carried = record_sets.carried_spectra(name)
        return Target(name, carried.periods, np.exp(np.log(carried.pseudo_acceleration).mean(axis=0)))
    file, poe = split_site(name)
    if not is_conditional(Path(file)):
        return _file(Path(text), damping)
    if damping != OF_MODELS:
        raise RecordError(f"{file}: is for {100 * OF_MODELS:g} % damping; leave the damping of {100 * damping:g} % out")
    periods, median, deviation, words = read_conditional(Path(file), poe)
    stem = f"{Path(file).stem}{f'#{poe}' if poe else ''}"
    return Target(stem, periods, median, damping, deviation=deviation, origin=words)


def asce7(sds: float, sd1: float, tl: float) -> Target:
    """Compute the two-period design spectrum of ASCE 7-16 for 5 % damping.

    Parameters
    ----------
    sds : float
        S_DS [g].
    sd1 : float
        S_D1 [g].
    tl : float
        T_L [s].

    Returns
    -------
    Target
        S_a = S_DS (0.4 + 0.6 T / T_0) to T_0 = 0.2 S_D1 / S_DS; S_DS to T_S = S_D1 / S_DS; S_D1 / T to T_L;
        S_D1 T_L / T² beyond. Times 1.5 it is that of the MCE_R (11.4.7).

    Raises
    ------
    RecordError
        For values that are not above zero, and T_L below T_S.

    References
    ----------
    ASCE 7-16, clause 11.4.6 (the same in ASCE 7-22, clause 11.4.5.2).
    """
    for key, value in (("sds", sds), ("sd1", sd1), ("tl", tl)):
        if not (isfinite(value) and value > 0.0):
            raise RecordError(f"asce7: {key} is {value:g}; it must be greater than 0 and finite")
    short = sd1 / sds
    if tl < short:
        raise RecordError(f"asce7: T_L is {tl:g} s, below T_S = sd1 / sds = {short:g} s; check the three values")

    def shape(period: Samples) -> Samples:
        safe = np.maximum(period, 0.2 * short)
        falling = np.where(safe <= tl, sd1 / safe, sd1 * tl / safe**2)
        rising = sds * (0.4 + 0.6 * period / (0.2 * short))
        return STANDARD_GRAVITY * np.where(period < 0.2 * short, rising, np.minimum(sds, falling))

    return _tabulated(
        f"asce7:sds={sds:g},sd1={sd1:g},tl={tl:g}", shape, (0.2 * short, short, tl), max(LONGEST, 2.0 * tl)
    )


def eurocode8(ag: float, ground: str, spectrum: int, damping: float = 0.05) -> Target:
    """Compute the horizontal elastic spectrum of EN 1998-1:2004 with the recommended values of S, T_B, T_C and T_D.

    Parameters
    ----------
    ag : float
        Design acceleration on type A ground [m/s²].
    ground : str
        Ground type, "A" to "E".
    spectrum : int
        Type of the spectrum, 1 or 2.
    damping : float
        Damping ratio.

    Returns
    -------
    Target
        S_e = a_g S [1 + T / T_B (2.5 η − 1)] to T_B; 2.5 a_g S η to T_C; 2.5 a_g S η T_C / T to T_D;
        2.5 a_g S η T_C T_D / T² to 4 s. η = sqrt(10 / (5 + ξ)) ≥ 0.55, ξ in per cent.

    Raises
    ------
    RecordError
        For another ground or type, and numbers out of range.

    References
    ----------
    EN 1998-1:2004, 3.2.2.2. National annexes have other values; Eurocode 8 of 2024 has another spectrum.
    """
    if spectrum not in GROUNDS or ground not in GROUNDS[spectrum]:
        raise RecordError(
            f"ec8: ground {shown(ground)} and type {shown(spectrum)} are not in tables 3.2 and 3.3; ground is A, B, C, "
            "D or E, type 1 (surface-wave magnitude above 5.5) or 2"
        )
    if not (isfinite(ag) and ag > 0.0 and 0.0 < damping < 1.0):
        raise RecordError(f"ec8: ag {ag:g} m/s² and damping {damping:g} must be greater than 0, damping below 1")
    soil, b, c, d = GROUNDS[spectrum][ground]
    eta = max(sqrt(10.0 / (5.0 + 100.0 * damping)), LEAST_ETA)
    plateau = 2.5 * eta * ag * soil

    def shape(period: Samples) -> Samples:
        safe = np.maximum(period, b)
        falling = np.where(safe <= d, plateau * c / safe, plateau * c * d / safe**2)
        rising = ag * soil * (1.0 + period / b * (2.5 * eta - 1.0))
        return np.where(period < b, rising, np.minimum(plateau, falling))

    name = f"ec8:ag={ag / STANDARD_GRAVITY:.6g} g,ground={ground},type={spectrum}"
    name += "" if damping == 0.05 else f",damping={damping:g}"
    return _tabulated(name, shape, (b, c, d), LONGEST_EC8, damping)


def _tabulated(
    name: str, shape: Callable[[Samples], Samples], corners: tuple[float, ...], longest: float, damping: float = 0.05
) -> Target:
    """A target with its formula, tabulated from period 0 with the corner periods among the nodes."""
    within = [corner for corner in corners if SHORTEST < corner < longest]
    periods = np.unique([0.0, *np.geomspace(SHORTEST, longest, NODES), *within])
    return Target(name, periods, shape(periods), damping, shape)


def _number(text: str) -> float:
    return float(text.removesuffix(" s").removesuffix(" g"))


# What a shape takes: how each key is read, in the order of the arguments, and its example. Only damping may be absent.
SHAPES: dict[str, tuple[Callable[..., Target], dict[str, Callable[[str], Any]], str]] = {
    "asce7": (asce7, {"sds": _number, "sd1": _number, "tl": _number}, "asce7:sds=1.0,sd1=0.6,tl=8"),
    "ec8": (
        eurocode8,
        # a_g is quoted in g as often as in m/s².
        {"ag": lambda text: parse(text, PGA), "ground": str.upper, "type": int, "damping": float},
        "ec8:ag=0.25 g,ground=B,type=1",
    ),
}


def _shape(name: str, kind: str, parameters: str) -> Target:
    make, readers, example = SHAPES[kind]
    values: dict[str, Any] = {}
    for setting in parameters.split(","):
        key, equals, value = (word.strip() for word in setting.partition("="))
        if not equals or key.lower() not in readers or key.lower() in values:
            raise RecordError(
                f'{name}: "{setting.strip()}" is not one of {", ".join(readers)}, once each; write "{example}"'
            )
        try:
            values[key.lower()] = readers[key.lower()](value)
        except (ValueError, QuantityError) as error:
            raise RecordError(f'{name}: {key} cannot be "{value}" ({error}); write "{example}"') from None
    absent = [key for key in readers if key not in values and key != "damping"]
    if absent:
        raise RecordError(f'{name}: says nothing of {" and ".join(absent)}; write "{example}"')
    return make(*(values[key] for key in readers if key in values))


def _file(path: Path, damping: float) -> Target:
    if not os.path.exists(path):  # False for a name that is too long, too
        shapes = " or ".join(shape[2] for shape in SHAPES.values())
        raise RecordError(f"{path}: no such file, and no shape; write {shapes}, or a file")
    repair = "write a header such as period [s], Sa [g], and a period and an ordinate in each row below"
    mark = next((mark for mark in ";\t" if mark in first_line(path)), ",")
    table = read_table(path, repair, error=RecordError, most=SPECTRUM, mark=mark)
    sizes = []
    for words, quantity in zip(table.head, (PERIOD, PGA), strict=False):
        _, unit = split_unit(words.replace("(", "[").replace(")", "]"))
        try:
            sizes.append(parse(f"1 {unit}", quantity) if unit else 0.0)
        except QuantityError as error:
            raise table.head_row.fault(f'the column "{words}": {error}') from None
    if len(table.head) != 2 or 0.0 in sizes:
        raise table.head_row.fault(
            f'the head is "{", ".join(table.head)}"; it must name two columns with their units in brackets, such as '
            "period [s], Sa [g]: units are not guessed"
        )
    values = np.array([[table.number(row, name) for name in table.head] for row in table.rows])
    _check_rows(table, values)
    return Target(path.stem, values[:, 0] * sizes[0], values[:, 1] * sizes[1], damping)


def _check_rows(table: Table, values: Samples) -> None:
    """Raise RecordError, with the line, for a period that is not above the one before, and an ordinate of no size."""
    if len(values) < 2:
        raise table.fault("has one row below its head; a target needs two periods or more, with an ordinate each")
    least = -inf
    for row, (period, ordinate) in zip(table.rows, values, strict=True):
        if not (period >= 0.0 and period > least):
            raise row.fault(f"{table.head[0]} is {row.cells[0]}; periods must rise from 0 s up: sort them, each once")
        if not ordinate > 0.0:
            raise row.fault(f"{table.head[1]} is {row.cells[1]}; it must be greater than 0: correct or leave it out")
        least = period


def is_conditional(path: Path) -> bool:
    """True for a conditional spectrum of OpenQuake."""
    head = head_of(path)
    return set(WIDE) <= set(head) or set(LONG) <= set(head)


def read_conditional(path: Path, poe: str = "") -> tuple[Samples, Samples, Samples, str]:
    """Periods [s], medians of Sa [m/s²] and deviations of ln Sa of a conditional spectrum, and where it is from.

    It is one that the OpenQuake engine exported. Versions up to 3.15 write ``sa_period,val0,std0,val1,std1`` with a
    pair of columns for each probability of exceedance; later ones a row for each probability and period,
    ``poe,stat,period,mea,std``. Sa in g is the exponential of the mean of ln Sa, and the deviation that of ln Sa
    (calculators/postproc/conditional_spectrum.py of github.com/gem/oq-engine).

    ``poe`` is one of the file's, or "val1" where it has columns without their probabilities; empty where it has one.
    Raises RecordError, with the line, for a damaged file, and for several probabilities of which none is chosen.
    """
    if set(WIDE) <= set(head_of(path)):
        table = read_table(path, error=RecordError, needed=WIDE)
        columns = [name for name in table.head if name.startswith("val")]
        name = _chosen(table, poe, columns)
        rows, median, deviation, period = list(table.rows), name, f"std{name[3:]}", "sa_period"
        if deviation not in table.head:
            raise table.fault(f"has {name} without {deviation}; {AGAIN}")
    else:
        table = read_table(path, error=RecordError, needed=LONG)
        name = _chosen(table, poe, list(dict.fromkeys(row.cells[table.head.index("poe")] for row in table.rows)))
        rows = [row for row in table.rows if row.cells[table.head.index("poe")] == name]
        rows, median, deviation, period = _means(table, rows), "mea", "std", "period"
    values = np.array([[table.number(row, key) for key in (period, median, deviation)] for row in rows])
    for row, (at, value, spread) in zip(rows, values, strict=True):
        if not (at >= 0.0 and value > 0.0 and spread >= 0.0):
            raise row.fault(f"period {at:g} s, Sa {value:g} g, deviation {spread:g}: one is out of range; {AGAIN}")
    site = f" at {table.facts['lon']}, {table.facts['lat']}" if {"lon", "lat"} <= set(table.facts) else ""
    which = f"{name} of {', '.join(columns)}" if "sa_period" in table.head else f"PoE {float(name):g}"
    words = f"conditional spectrum of OpenQuake{site}, {which}, {len(rows)} periods"
    return values[:, 0], STANDARD_GRAVITY * values[:, 1], values[:, 2], words


def _chosen(table: Table, wanted: str, known: list[str]) -> str:
    """The probability, or column, of a file that is requested; its only one where none is."""
    repair = f"choose one with --poe, or # after the name of the file: {', '.join(known)}"
    if not wanted:
        if len(known) != 1:
            raise table.fault(f"has spectra of {len(known)} probabilities of exceedance; {repair}")
        return known[0]
    for name in known:
        try:
            same = name == wanted or isclose(float(name), float(wanted), rel_tol=1e-6)
        except ValueError:
            same = False
        if same:
            return name
    raise table.fault(f"has no probability {shown(wanted)}; {repair}")


def _means(table: Table, rows: list[Row]) -> list[Row]:
    """The rows of the mean of the realisations; raises RecordError for several realisations without it."""
    for key in ("stat", "rlz_id", "rlz"):
        if key in table.head:
            at = table.head.index(key)
            kinds = list(dict.fromkeys(row.cells[at] for row in rows))
            if len(kinds) > 1 and "mean" not in kinds:
                raise table.fault(f"has spectra of {len(kinds)} realisations; export the mean, cs-stats")
            rows = [row for row in rows if row.cells[at] == ("mean" if "mean" in kinds else kinds[0])]
    return rows
