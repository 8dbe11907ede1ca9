"""Two linear buildings under stationary noise: how their motions are correlated, and when they first touch.

The published relations are those of random vibration. Ours are motions of `generated` noise through the solver; beside
them stand closed forms, integrals over frequency and an exact recursion of the same linear system, which shares no code
with the solver or with the generator.
"""

from __future__ import annotations

from itertools import chain, pairwise
from math import inf, nan, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.ensemble.scan import scan
from pounding_risk.lab.verification.property import BAND, POINTS, Panel, Property, Reading, series
from pounding_risk.scene.buildings import SingleMass
from pounding_risk.scene.interfaces import Interface
from pounding_risk.scene.records import Records
from pounding_risk.scene.scene import Scene
from pounding_risk.studies.simulate import simulate

Array = NDArray[np.float64]

MASS = 1e5  # kg; nothing depends on it
DAMPING = 0.05
DENSITY = 0.01  # m²/s³, S₀: two-sided, over angular frequency
GROUND = (2.5, 0.6)  # frequency [Hz] and damping of Kanai and Tajimi's layer: firm ground
OUTSIDE = 0.001  # share of the samples of a correct program that lie outside the bounds of 99.9 %
NORMAL = 3.2905267314919255  # of the normal distribution, for both ends of it

# The double difference: one building of 1 s beside others.
PERIODS = (1.0, 0.95, 0.9, 0.8, 0.7, 0.6, 0.5)  # s
SEEDS = tuple(range(1, 9))
LENGTH = 2000.0  # s, of one motion
STEP = 0.02  # s
START = 40.0  # s, until the motion is stationary to exp(-2 · 0.05 · 2π · 40) = 1e-11 of its variance
WINDOW = 20.0  # s, of which a peak is taken

# The first passage: two buildings at rest at first.
PASSAGE_PERIODS = (1.0, 0.6)  # s
PASSAGE_LENGTH = 20.0  # s
PASSAGE_STEP = 0.01  # s
MOTIONS, BATCH = 400, 50
LEVELS = (1.75, 2.0, 2.25, 2.5, 2.75, 3.0, 3.5)  # gaps over the stationary standard deviation of the closing
STATES = 5000  # motions of the recursion
STATES_SEED = 20121  # of its random numbers, PCG64


class Linear(NamedTuple):
    """Linear buildings behind a filter of white noise: dz = A z dt + b dW, whose variance is 2π S₀ dt."""

    drift: Array  # A
    drive: Array  # b
    closing: Array  # u_left − u_right of the state, and its rate: shape (2, n)
    filter_size: int  # of the states, those of the filter: 0 for white noise

    def covariance(self) -> Array:
        """Stationary covariance, from Lyapunov's equation."""
        from scipy.linalg import solve_continuous_lyapunov

        noise = 2.0 * pi * DENSITY * np.outer(self.drive, self.drive)
        return np.asarray(solve_continuous_lyapunov(self.drift, -noise), dtype=float)

    def after(self, time: float) -> Array:
        """exp(A t): what a state becomes in the time t [s], as a matrix."""
        from scipy.linalg import expm

        return expm(self.drift * time)


def linear(periods: tuple[float, float], ground: tuple[float, float] | None) -> Linear:
    """Two buildings of these periods under white noise, or behind a layer of this frequency and damping."""
    size = 0 if ground is None else 2
    drift, drive = np.zeros((size + 4, size + 4)), np.zeros(size + 4)
    forced = np.zeros(size + 4)  # −a_g in terms of the state
    if ground is None:
        drive[1] = drive[3] = -1.0
    else:
        rate = 2.0 * pi * ground[0]
        drift[0, 1] = 1.0
        drift[1, :2] = -(rate**2), -2.0 * ground[1] * rate
        drive[1] = -1.0
        forced[:2] = -drift[1, :2]
    for at, period in zip((size, size + 2), periods, strict=True):
        omega = 2.0 * pi / period
        drift[at, at + 1] = 1.0
        drift[at + 1] = forced
        drift[at + 1, at : at + 2] += -(omega**2), -2.0 * DAMPING * omega
    closing = np.zeros((2, size + 4))
    closing[0, [size, size + 2]] = closing[1, [size + 1, size + 3]] = 1.0, -1.0
    return Linear(drift, drive, closing, size)


# ---------------------------------------------------------------------------------------------- what is published


def correlation(left: float, right: float) -> float:
    """Correlation of two oscillators of these periods [s] under white noise, both of damping ratio `DAMPING`.

    The coefficient of the complete quadratic combination, Der Kiureghian (1981); for r the ratio of the periods
    8 ζ² (1 + r) r^1.5 / ((1 − r²)² + 4 ζ² r (1 + r)²).
    """
    r = left / right
    top = 8.0 * DAMPING**2 * (1.0 + r) * r**1.5
    return top / ((1.0 - r * r) ** 2 + 4.0 * DAMPING**2 * r * (1.0 + r) ** 2)


def white_variance(period: float) -> float:
    """Variance of the displacement under white noise, π S₀ / (2 ζ ω³) [m²]."""
    return pi * DENSITY / (2.0 * DAMPING * (2.0 * pi / period) ** 3)


def filtered(left: float, right: float) -> float:
    """Covariance of two displacements under Kanai and Tajimi's noise [m²]: the integral of H₁ H₂* S over frequency."""
    from scipy.integrate import quad

    rate, ratio = 2.0 * pi * GROUND[0], GROUND[1]

    def density(omega: float) -> float:
        r = omega / rate
        return DENSITY * (1.0 + (2.0 * ratio * r) ** 2) / ((1.0 - r * r) ** 2 + (2.0 * ratio * r) ** 2)

    def carried(omega: float) -> float:
        rates = (2.0 * pi / period for period in (left, right))
        first, second = (1.0 / (frequency**2 - omega**2 + 2j * DAMPING * frequency * omega) for frequency in rates)
        return density(omega) * (first * second.conjugate()).real

    ends = sorted({0.0, 2.0 * pi / left, 2.0 * pi / right, rate, 200.0})
    integrals = [quad(carried, *span, limit=400, epsrel=1e-10)[0] for span in pairwise(ends)]
    return 2.0 * float(sum(integrals) + quad(carried, ends[-1], inf, limit=400)[0])


class Moments(NamedTuple):
    """Published second moments of two buildings' displacements."""

    left: float  # m², variance
    right: float
    correlation: float

    @property
    def closing(self) -> float:
        """Variance of their difference, σ₁² + σ₂² − 2ρσ₁σ₂: the double-difference combination [m²]."""
        return self.left + self.right - 2.0 * self.correlation * sqrt(self.left * self.right)


def published(periods: tuple[float, float], ground: tuple[float, float] | None) -> Moments:
    """The moments by the closed form for white noise, or by integrals over frequency."""
    left, right = periods
    if ground is None:
        return Moments(white_variance(left), white_variance(right), correlation(left, right))
    first, second = filtered(left, left), filtered(right, right)
    return Moments(first, second, filtered(left, right) / sqrt(first * second))


# ----------------------------------------------------------------------------------------- the double difference


def noise_record(ground: tuple[float, float] | None, length: float, step: float, **keys: Any) -> Records:
    """The table `[[records.generated]]` of stationary noise, one motion for each seed."""
    entry: dict[str, Any] = {"duration": f"{length} s", "step": f"{step} s", "psd": f"{DENSITY} m^2/s^3"}
    if ground is None:
        entry |= {"kind": "white_noise"}
    else:
        entry |= {"kind": "kanai_tajimi", "frequency": f"{ground[0]} Hz", "damping": ground[1]}
    recipe: Any = {**entry, "envelope": "none", **keys}
    return Records(generated=(recipe,))


def row_response(ground: tuple[float, float] | None) -> tuple[Array, Array]:
    """Our motions of the buildings of `PERIODS` under every seed, from `START` on, as a row that never touches.

    Mean products u_i u_j (buildings, buildings), and the means over all windows of the largest |u| of each building and
    of the largest |u_first − u| (2, buildings).
    """
    buildings = [SingleMass(name=f"{period} s", mass=MASS, period=period, damping=DAMPING) for period in PERIODS]
    far = [Interface(gap=100.0, contact_model="linear", stiffness=1e8) for _ in PERIODS[1:]]
    products, peaks, count = np.zeros((len(PERIODS), len(PERIODS))), [], 0
    for seed in SEEDS:
        run = simulate(Scene(buildings, far, noise_record(ground, LENGTH, STEP, seed=seed)))
        motion = run["displacement"].values[..., 0]
        motion = motion[round(START / STEP) : round(LENGTH / STEP)]
        products += motion.T @ motion
        count += len(motion)
        windows = np.reshape(motion, (-1, round(WINDOW / STEP), len(PERIODS)))
        peaks.append([np.abs(one).max(axis=1) for one in (windows, windows[..., :1] - windows)])
    return products / count, np.concatenate(peaks, axis=1).mean(axis=1)


def freedom(system: Linear) -> float:
    """Degrees of freedom ν of the mean square of u_left − u_right: 2 σ⁴/ν is its variance over all seeds.

    With the correlation r_k of samples k steps apart, ν = n / (1 + 2 Σ r_k²) (Bartlett 1946; Satterthwaite 1946).
    """
    moved, move = system.covariance() @ system.closing[0], system.after(STEP)
    square, first = 0.0, float(system.closing[0] @ moved)
    for _ in range(round(START / STEP)):
        moved = move @ moved
        square += (float(system.closing[0] @ moved) / first) ** 2
    return len(SEEDS) * (LENGTH - START) / STEP / (1.0 + 2.0 * square)


def chi_square_bounds(degrees: float) -> tuple[float, float]:
    """What a mean square of so many degrees of freedom lies within, over its expectation, but for `OUTSIDE`."""
    from scipy.special import gammaincinv

    ends = (0.5 * OUTSIDE, 1.0 - 0.5 * OUTSIDE)
    low, high = (float(2.0 * gammaincinv(0.5 * degrees, share) / degrees) for share in ends)
    return low, high


def double_difference_under(words: str, ground: tuple[float, float] | None) -> tuple[list[Reading], Panel, list[float]]:
    """Readings and panel under one noise, and mean peaks of u1 − u2 over the rule's combination of mean peaks."""
    pairs = [(PERIODS[0], period) for period in PERIODS[1:]]
    products, (peaks, closing) = row_response(ground)
    moments = [published(pair, ground) for pair in pairs]
    bounds = [chi_square_bounds(freedom(linear(pair, ground))) for pair in pairs]
    squares = [float(products[0, 0] + products[at, at] - 2.0 * products[0, at]) for at in range(1, len(PERIODS))]
    readings = [
        Reading(
            f"variance of u1 − u2 over the published, {words}, {pair[0]:g} s beside {pair[1]:g} s",
            *(1.0, square / known.closing, low, high, ""),
            "99.9 % of the samples of a correct program: chi-square",
        )
        for pair, known, square, (low, high) in zip(pairs, moments, squares, bounds, strict=True)
    ]
    ratios = []
    for at, known in enumerate(moments, start=1):
        rule = sqrt(peaks[0] ** 2 + peaks[at] ** 2 - 2.0 * known.correlation * peaks[0] * peaks[at])
        ratios.append(float(closing[at] / rule))
    # Standard deviation of u1 − u2 over SRSS against the ratio of periods, published and ours, and mean peaks.
    ratio = np.array([right / left for left, right in pairs])
    srss = np.array([sqrt(known.left + known.right) for known in moments])
    deviations = np.array([sqrt(known.closing) for known in moments]) / srss
    ends = np.sqrt(np.array(bounds).T) * deviations
    drawn = (
        series("published: double difference", ratio, deviations),
        series("published: SRSS", ratio, np.ones_like(ratio)),
        series("standard deviation, ours", ratio, np.sqrt(squares) / srss, POINTS, (ends[0], ends[1])),
        series("mean peak, ours", ratio, closing[1:] / np.hypot(peaks[0], peaks[1:]), POINTS),
    )
    return readings, Panel(("ratio of the periods", "$u_1 - u_2$ over SRSS of $u_1$ and $u_2$"), drawn, words), ratios


def double_difference() -> Property:
    """Variance and mean peak of the relative displacement against the double-difference combination.

    A rule for peaks takes them as proportional to standard deviations. Peaks of a few periods are not quite: those of
    u1 − u2, a slow beat where the periods are near, are smaller. That is of the rule, so no bound is set on them.
    """
    grounds = ("white noise", None), ("Kanai and Tajimi's noise", GROUND)
    readings, panels, ratios = zip(*(double_difference_under(words, ground) for words, ground in grounds), strict=True)
    shares = list(chain.from_iterable(ratios))
    return Property(
        "double_difference",
        "Relative displacement of two buildings under stationary noise",
        "Jeng, Kasai and Maison (1992)",
        "Jeng, V., Kasai, K. and Maison, B. F. (1992), Earthquake Spectra 8(2); the coefficient is that of Der "
        "Kiureghian, A. (1981), Earthquake Engineering and Structural Dynamics 9; on its accuracy Lopez-Garcia and "
        "Soong (2009)",
        "",
        "derived",
        "the coefficient is that of two oscillators under white noise, derived again with Lyapunov's equation",
        "variance of u1 − u2 = σ1² + σ2² − 2 ρ σ1 σ2, with ρ of the two periods and dampings; the rule takes it for "
        "peaks too",
        tuple(chain.from_iterable(readings)),
        f"Variances of $u_1 - u_2$ are those of the double difference; mean peaks in {WINDOW:g} s are "
        f"{min(shares):.2f} to {max(shares):.2f} of the rule's",
        f"buildings of {PERIODS[1]:g} to {PERIODS[-1]:g} s beside one of {PERIODS[0]:g} s, damping "
        f"{100.0 * DAMPING:g} %; {len(SEEDS)} motions of {LENGTH:g} s, seeds {SEEDS[0]} to {SEEDS[-1]}; bars: 99.9 % "
        "of the samples of a correct program",
        panels,
    )


# ---------------------------------------------------------------------------------------------- the first passage


def closing_moments(system: Linear, times: Array) -> Array:
    """Variance of u_left − u_right, its covariance with its rate, and that one's variance, at equal times from rest.

    The buildings are at rest at first; shape (3, times).
    """
    stationary, start = system.covariance(), initial_covariance(system)
    moved, move = start - stationary, system.after(float(times[1] - times[0]))
    moments = np.zeros((3, len(times)))
    for at in range(1, len(times)):
        moved = move @ moved @ move.T
        (xx, xv), (_, vv) = system.closing @ (stationary + moved) @ system.closing.T
        moments[:, at] = xx, xv, vv
    return moments


def upcrossings(moments: Array, gap: float, times: Array) -> Array:
    """Mean number of upcrossings of the gap by u_left − u_right until each time: Rice (1945), for a Gaussian motion."""
    from scipy.special import ndtr

    xx, xv, vv = moments[:, 1:]
    mean, spread = xv / xx * gap, np.sqrt(np.maximum(vv - xv * xv / xx, 0.0))
    upward = spread * np.exp(-0.5 * (mean / spread) ** 2) / sqrt(2.0 * pi) + mean * ndtr(mean / spread)
    rates = np.append(0.0, upward * np.exp(-0.5 * gap * gap / xx) / np.sqrt(2.0 * pi * xx))
    return np.append(0.0, np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(times)))


def initial_covariance(system: Linear) -> Array:
    """Of the state at the start: the ground stationary, the buildings at rest."""
    covariance = np.zeros_like(system.drift)
    size = system.filter_size
    covariance[:size, :size] = system.covariance()[:size, :size]
    return covariance


def recursion_peaks(system: Linear) -> Array:
    """Largest u_left − u_right of `STATES` motions from rest, by the exact recursion of the linear system."""
    random = np.random.Generator(np.random.PCG64(STATES_SEED))
    stationary, move = system.covariance(), system.after(PASSAGE_STEP)
    spread = _root(stationary - move @ stationary @ move.T)
    state = _root(initial_covariance(system)) @ random.standard_normal((len(move), STATES))
    highest = np.zeros(STATES)
    for _ in range(round(PASSAGE_LENGTH / PASSAGE_STEP)):
        state = move @ state + spread @ random.standard_normal((spread.shape[1], STATES))
        np.maximum(highest, system.closing[0] @ state, out=highest)
    return highest


def _root(covariance: Array) -> Array:
    """A matrix whose product with its transpose is the covariance, which may be singular."""
    values, vectors = np.linalg.eigh(covariance)
    return vectors * np.sqrt(np.clip(values, 0.0, None))


def shares_of_contacts(gaps: Array) -> Array:
    """Share of `MOTIONS` motions with a contact, for each gap, from scans of `BATCH` motions.

    A scan compares its motions with one another, to find copies; small ones compare fewer pairs.
    """
    named = zip(("left", "right"), PASSAGE_PERIODS, strict=True)
    buildings = [SingleMass(name=name, mass=MASS, period=period, damping=DAMPING) for name, period in named]
    interface = Interface(gap=float(gaps[0]), contact_model="linear", stiffness=1e8)
    touched = []
    for seed in range(1, MOTIONS + 1, BATCH):
        records = noise_record(GROUND, PASSAGE_LENGTH, PASSAGE_STEP, seed=seed, count=BATCH)
        scene = Scene(buildings, [interface], records)
        scene = scene.updated(grid=scene.grid._replace(gaps=tuple(gaps.tolist())))
        contacts = scan(scene, check_fraction=0.0)["impact_count"] > 0
        touched.append(contacts.squeeze(drop=True).transpose("gap", "record").values)
    return np.concatenate(touched, axis=1).mean(axis=1)


def passage_readings(ours: Array, of_gaps: Array, reference: Array, reach: Array) -> tuple[Reading, ...]:
    """Shares of contacts by gap against the recursion, and the largest of them over the mean number of upcrossings."""
    readings = [
        Reading(
            f"P(contact) in {PASSAGE_LENGTH:g} s, gap of {level:g} standard deviations of u1 − u2",
            *(float(expected), float(share), float(expected - off), min(float(expected + off), 1.0), ""),
            "99.9 % of the samples of a correct program: binomial, of ours and of the recursion",
        )
        for level, share, expected, off in zip(LEVELS, ours, reference, reach, strict=True)
    ]
    far = of_gaps < 1.0
    bound = Reading(
        "P(contact) over the mean number of upcrossings, largest where that is below 1",
        *(nan, float((ours[far] / of_gaps[far]).max()), 0.0, 1.0, ""),
        "an upcrossing is needed for a contact",
    )
    return (*readings, bound)


def first_passage() -> Property:
    """P(contact) within a time under stationary noise, against an exact recursion and a bound of Rice's."""
    system = linear(PASSAGE_PERIODS, GROUND)
    deviation = sqrt(float(system.closing[0] @ system.covariance() @ system.closing[0]))
    gaps = deviation * np.array(LEVELS)
    ours = shares_of_contacts(gaps)
    highest = recursion_peaks(system)
    reference = (highest[:, None] > gaps).mean(axis=0)
    reach = NORMAL * np.sqrt(reference * (1.0 - reference) * (1.0 / MOTIONS + 1.0 / STATES))
    times = np.linspace(0.0, PASSAGE_LENGTH, 2001)
    fine = deviation * np.linspace(LEVELS[0], LEVELS[-1], 26)
    moments = closing_moments(system, times)
    counts = np.array([upcrossings(moments, float(gap), times)[-1] for gap in fine])
    of_gaps = np.array([upcrossings(moments, float(gap), times)[-1] for gap in gaps])
    drawn = (
        series("upper bound: mean upcrossings (Rice)", fine / deviation, np.minimum(counts, 1.0)),
        series("upcrossings as a Poisson process", fine / deviation, 1.0 - np.exp(-counts)),
        series("exact recursion", LEVELS, reference, BAND, (reference - reach, reference + reach)),
        series("ours: share of motions with a contact", LEVELS, ours, POINTS),
    )
    return Property(
        "first_passage",
        "Probability of a contact within a time under stationary noise",
        "Tubaldi, Barbato and Ghazizadeh (2012)",
        "Tubaldi, E., Barbato, M. and Ghazizadeh, S. (2012), A probabilistic performance-based risk assessment "
        "approach for seismic pounding with efficient application to linear systems, Structural Safety 36-37, 14-22; "
        "upcrossings: Rice, S. O. (1945), Bell System Technical Journal 24, 46-156",
        "https://pureportal.strath.ac.uk/en/publications/a-probabilistic-performance-based-risk-assessment-approach-for-se",
        "derived",
        "the abstract alone was reached: in kind, with parameters of ours; Rice's formula derived again",
        "pounding is the first passage of u1 − u2 beyond the gap; its probability is at most the mean number of "
        "upcrossings",
        passage_readings(ours, of_gaps, reference, reach),
        f"P(contact) falls from {100.0 * ours[0]:.2g} to {100.0 * ours[-1]:.2g} % along the gap as an exact recursion "
        "of the linear pair has it",
        f"periods {PASSAGE_PERIODS[0]:g} and {PASSAGE_PERIODS[1]:g} s, damping {100.0 * DAMPING:g} %, at rest at "
        f"first; {PASSAGE_LENGTH:g} s of Kanai and Tajimi's noise, {MOTIONS} motions of seeds 1 to {MOTIONS} against "
        f"{STATES} of the recursion, seed {STATES_SEED}; band: 99.9 % of the samples of a correct program",
        (Panel(("gap over the standard deviation of $u_1 - u_2$", "P(contact)"), drawn),),
    )
