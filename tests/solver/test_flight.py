"""Flight between contacts is exact, no touch is missed, peaks are those of the continuous motion.

The witness is the closed form of an oscillator under a ground acceleration that is linear in time, worked in
extended precision and sampled densely, or a matrix exponential.
"""

from itertools import pairwise
from math import ceil, inf, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.optimize import minimize_scalar
from sweeps import examples, many

from pounding_risk.models.contact.laws import Jankowski
from pounding_risk.models.ground import UniformInterval
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver.pair import flight, taylor
from pounding_risk.solver.pair.api import Interface, free_response, oscillators, solve
from pounding_risk.solver.pair.flight import BLOCK, SIGNALS
from pounding_risk.solver.pair.taylor import bend_at, bend_within, first_rise, highest, slope_at, value_at
from pounding_risk.solver.workspace import LEFT, MAX_TERMS, RIGHT, SIGNAL, make_workspace

ROUNDING = 1e-13  # of a signal's size
LONGEST_TURN = 2.5  # rad of the stiffer building that one series spans


def building(period: float, damping: float = 0.05, mass: float = 5e5) -> Building:
    return Building("building", mass, period, damping)


def terms_for(angle: float) -> int:
    """So many terms that the rest of the series is below rounding: angle^n / n! < 1e-19."""
    terms, size = 4, 1.0
    while size > 1e-19 and terms < MAX_TERMS:
        size *= max(angle, 1e-3) / (terms - 3)
        terms += 1
    return terms


def closed_form(oscillator, place, speed, ramp, x):
    """u, u̇ at times x: ramp response + damped free vibration, in extended precision."""
    x = np.asarray(x, dtype=np.longdouble)
    if oscillator.inverse_omega == 0.0:
        return np.zeros_like(x), np.zeros_like(x)
    omega2, zeta_omega = np.longdouble(oscillator.omega2), np.longdouble(oscillator.two_zeta_omega) / 2
    a, b = (np.longdouble(oscillator.ground * part) for part in ramp[:2])
    rest, drift = -a / omega2 + 2 * zeta_omega * b / omega2**2, -b / omega2
    rate = np.sqrt(omega2 - zeta_omega**2)
    first = np.longdouble(place) - rest
    second = (np.longdouble(speed) - drift + zeta_omega * first) / rate
    decay, c, s = np.exp(-zeta_omega * x), np.cos(rate * x), np.sin(rate * x)
    u = rest + drift * x + decay * (first * c + second * s)
    v = drift + decay * ((second * rate - zeta_omega * first) * c - (first * rate + zeta_omega * second) * s)
    return u, v


def rounding_of(oscillator, place, speed, ramp, span) -> float:
    """What rounding may do to u on a segment: to the series, and to the witness that subtracts larger terms."""
    inverse = oscillator.inverse_omega
    pull = (abs(ramp[0]) + abs(ramp[1]) * span) * min(inverse, span) ** 2
    size = max(abs(place), abs(speed) * min(inverse, span), pull)
    witness = (abs(ramp[0]) + abs(ramp[1]) * inverse) * inverse**2 + abs(speed) * inverse
    return ROUNDING * size + 40.0 * float(np.finfo(np.longdouble).eps) * witness + 1e-300


# Random segments of flight: a stiff and a soft building, any state, a ground acceleration up to 3 g.

PERIODS = st.sampled_from([0.005, 0.02, 0.11, 0.208, 0.5, 1.0, 3.0])
DAMPINGS = st.sampled_from([0.0, 0.02, 0.05, 0.3, 0.9])
UNIT = st.integers(-1_000_000, 1_000_000).map(lambda number: 1e-6 * number)


@st.composite
def segments(draw):
    """(pair, state, span, terms, step): one node interval of two oscillators that end of it may cut short."""
    pair = oscillators(*(building(draw(PERIODS), draw(DAMPINGS)) for _ in range(2)))
    omega = max(1.0 / oscillator.inverse_omega for oscillator in pair)
    step = draw(st.sampled_from([0.3, 1.0])) * min(0.02, LONGEST_TURN / omega)
    size = draw(st.sampled_from([1e-6, 1e-3, 0.3]))
    state = tuple(size * draw(UNIT) for _ in range(2))
    # Speeds as they go with such displacements; sometimes as a fast contact has left them.
    fast = draw(st.sampled_from([0.0, 1.0, 30.0]))
    state += tuple(fast * size * draw(UNIT) / oscillator.inverse_omega for oscillator in pair)
    shake = draw(st.sampled_from([0.0, 1.0, 30.0]))
    ramp = (shake * draw(UNIT), shake * draw(UNIT) / step)
    length = step * draw(st.sampled_from([1.0, 0.37, 1e-3]))
    return pair, state, (*ramp, length), terms_for(omega * step)


def laid_out(segment):
    """A workspace with the series of both buildings and of the relative displacement."""
    pair, state, span, terms = segment
    workspace = make_workspace()
    ground = UniformInterval(span[0], span[1])
    flight.write_series(pair, state, ground, terms, workspace)
    flight.write_signal(0, pair, ground, workspace, terms)
    return workspace


def relative(segment, x):
    """Relative displacement and its rate at times x, and what rounding may do to it."""
    pair, state, span, _ = segment
    u, v = closed_form(pair[0], state[0], state[2], span, x)
    w, z = closed_form(pair[1], state[1], state[3], span, x)
    slack = sum(rounding_of(pair[i], state[i], state[2 + i], span, span[2]) for i in range(2))
    return u - w, v - z, 40.0 * slack


@examples(60, segments())
def test_the_series_is_the_closed_form(segment):
    pair, state, span, terms = segment
    workspace = laid_out(segment)
    x = np.linspace(0.0, span[2], 9)
    for row, side in ((LEFT, 0), (RIGHT, 1)):
        u, v = closed_form(pair[side], state[side], state[2 + side], span, x)
        slack = 20.0 * rounding_of(pair[side], state[side], state[2 + side], span, span[2])
        found = [value_at(workspace.search.series, row, terms, place) for place in x]
        assert np.abs(found - u).max() <= slack
        found = [slope_at(workspace.search.series, row, terms, place) for place in x]
        assert np.abs(found - v).max() <= slack / min(pair[side].inverse_omega, span[2])


test_many_series_are_the_closed_form = many(test_the_series_is_the_closed_form, 150)


@given(segments())
@settings(max_examples=30)
def test_sums_taken_in_one_loop_are_those_taken_alone(segment):
    """Bit by bit; the bound on the third derivative, which is nowhere taken alone, against the sum of its terms."""
    series, terms, end = laid_out(segment).search.series, segment[3], segment[2][2]
    for row in (LEFT, RIGHT, SIGNAL):
        x = 0.3 * end
        value, slope, bend = (each(series, row, terms, x) for each in (value_at, slope_at, bend_at))
        assert taylor.value_and_slope(series, row, terms, x) == (value, slope)
        assert taylor.slope_and_bend(series, row, terms, x) == (slope, bend)
        assert taylor.value_and_bounds(series, row, terms, x) == (value, slope, bend_within(series, row, terms, x))
        there, twist = taylor.bend_and_twist_within(series, row, terms, x, end)
        assert there == bend
        n = np.arange(3, terms)
        expected = np.sum(n * (n - 1) * (n - 2) * np.abs(series[row, 3:terms]) * end ** (n - 3))
        assert twist == pytest.approx(expected, rel=1e-13)


@given(segments())
@settings(max_examples=150)
def test_no_second_derivative_exceeds_its_bounds(segment):
    pair, state, span, terms = segment
    workspace = laid_out(segment)
    x = np.linspace(0.0, span[2], 200)
    for row, side in ((LEFT, 0), (RIGHT, 1)):
        oscillator = pair[side]
        place, speed = state[side], state[2 + side]
        u, v = closed_form(oscillator, place, speed, span, x)
        a_g = span[0] + span[1] * x
        bend = -(a_g + oscillator.two_zeta_omega * v + oscillator.omega2 * u)  # ü
        twist = -(span[1] + oscillator.two_zeta_omega * bend + oscillator.omega2 * v)
        shake = -oscillator.two_zeta_omega * twist - oscillator.omega2 * bend
        turn = flight.turn_bound(oscillator, place, speed, UniformInterval(span[0], span[1]).load_left(oscillator))
        slack = 1.0 + 1e-9
        assert np.abs(bend).max() <= turn * slack
        assert np.abs(shake).max() <= flight.shake_bound(oscillator, turn) * slack
        assert np.abs(bend).max() <= bend_within(workspace.search.series, row, terms, span[2]) * slack + 1e-12 * turn


@given(UNIT, UNIT, st.floats(1e-6, 1.0), st.floats(0.0, 1e6))
def test_the_crest_bound_is_the_crest_of_the_steepest_parabola(start, stop, span, bend):
    """The extreme f with |f''| ≤ bend is the parabola through both ends: its local maximum is the bound."""
    x = np.linspace(0.0, span, 2001)
    parabola = start + (stop - start) * x / span + 0.5 * bend * x * (span - x)
    bound = taylor.local_maximum_bound(start, stop, span, bend)
    scale = max(abs(start), abs(stop), bend * span * span)
    assert parabola.max() <= bound + 1e-14 * scale
    assert bound <= parabola.max() + bend * (span / 2000.0) ** 2 + 1e-14 * scale


MARGINS = st.sampled_from([0.0, 1e-15, 1e-9, 1e-4, 0.01, 0.1, 0.5, 0.9, 0.999999, 1.0, 1.000001, 2.0])


@examples(100, segments(), MARGINS)
def test_no_touch_is_missed_and_the_first_is_found(segment, share):
    """Gaps from the value at the start to past the local maximum, most of all just under and over it."""
    _, _, span, terms = segment
    workspace = laid_out(segment)
    x = np.linspace(0.0, span[2], 4001)
    value, rate, slack = relative(segment, x)
    level = float(value[0] + share * (value.max() - value[0]))
    level = max(level, float(workspace.search.series[SIGNAL, 0]))
    touch = first_rise(workspace.search, terms, level, span[2])
    if touch < 0.0:
        assert touch == -1.0
        assert value.max() <= level + slack
        return
    assert 0.0 <= touch <= span[2]
    assert value[x < touch].max(initial=-inf) <= level + slack
    at, slope, _ = relative(segment, touch)
    assert abs(at - level) <= slack
    assert slope >= -1e-6 * np.abs(rate).max()


test_of_many_touches_none_is_missed = many(test_no_touch_is_missed_and_the_first_is_found, 400)


def test_two_touches_in_one_interval_the_first_counts():
    """T = 0.005 s beside T = 3 s over 1.98 ms: 2.5 rad, the relative motion rises, falls and rises."""
    pair = oscillators(building(0.005, 0.0), building(3.0, 0.0))
    omega = 2.0 * pi / 0.005
    span, terms = (0.0, 0.0, LONGEST_TURN / omega), terms_for(LONGEST_TURN)
    # u = cos(ω x − 0.5): local maximum 1 at ω x = 0.5, back below 0.9 at ω x = 0.951.
    segment = pair, (np.cos(0.5), 0.0, omega * np.sin(0.5), 0.0), span, terms
    touch = first_rise(laid_out(segment).search, terms, 0.9, span[2])
    assert omega * touch == pytest.approx(0.5 - np.arccos(0.9), abs=1e-13)
    for level in (1.0 - 1e-6, 1.0 - 1e-12):
        assert omega * first_rise(laid_out(segment).search, terms, level, span[2]) == pytest.approx(
            0.5 - np.arccos(level), abs=1e-8
        )
    assert first_rise(laid_out(segment).search, terms, 1.0 + 1e-14, span[2]) == -1.0


def test_bodies_that_part_are_not_touching_again_at_once():
    """A start at the level itself: going down is no touch, coming back is one, and rest is none."""
    pair = oscillators(building(0.1, 0.0), Building.rigid("rock"))
    omega = 2.0 * pi / 0.1
    span, terms = (0.0, 0.0, 2.4 / omega), terms_for(2.4)
    segment = pair, (0.01, 0.0, -0.5, 0.0), span, terms
    assert first_rise(laid_out(segment).search, terms, 0.01, span[2]) == -1.0
    # A push of a_g < 0 brings it back: the closed form says when.
    segment = pair, (0.01, 0.0, -0.5, 0.0), (-300.0, 0.0, 2.4 / omega), terms
    touch = first_rise(laid_out(segment).search, terms, 0.01, span[2])
    assert touch > 0.0
    assert float(relative(segment, touch)[0]) == pytest.approx(0.01, rel=1e-13)
    dense = np.linspace(0.0, touch, 1001)[1:-1]
    assert float(relative(segment, dense)[0].max()) < 0.01
    rest = pair, (0.0, 0.0, 0.0, 0.0), span, terms
    assert first_rise(laid_out(rest).search, terms, 0.0, span[2]) == -1.0


def test_a_motion_that_is_not_finite_ends_the_search():
    pair = oscillators(building(0.1), building(0.2))
    for bad in (np.nan, inf, -inf):
        segment = pair, (bad, 0.0, 0.0, 0.0), (0.0, 0.0, 0.01), terms_for(1.0)
        assert first_rise(laid_out(segment).search, segment[3], 0.01, 0.01) <= 0.01
        highest(laid_out(segment).search, SIGNAL, segment[3], 1.0, 0.01, 0.0)


@given(segments(), st.sampled_from([1.0, -1.0]), st.integers(0, SIGNALS - 1))
@settings(max_examples=200)
def test_the_highest_value_is_the_highest(segment, sign, signal):
    pair, _, span, terms = segment
    workspace = laid_out(segment)
    row, count = flight.write_signal(signal, pair, UniformInterval(span[0], span[1]), workspace, terms)
    coefficients = workspace.search.series[row, :count].astype(np.longdouble)[::-1]
    x = np.linspace(0.0, span[2], 1001)
    values = sign * np.polyval(coefficients, x.astype(np.longdouble))
    found = highest(workspace.search, row, count, sign, span[2], -inf)
    powers = np.abs(coefficients[::-1]) * np.longdouble(span[2]) ** np.arange(count)
    slack = ROUNDING * float(powers.sum())
    assert found >= values.max() - slack
    top = int(values.argmax())
    around = (x[max(top - 1, 0)], x[min(top + 1, 1000)])
    refined = minimize_scalar(
        lambda place: -sign * float(np.polyval(coefficients, place)),
        bounds=around,
        method="bounded",
        options={"xatol": 1e-9 * span[2]},
    )
    assert found <= max(-refined.fun, float(values.max())) + slack + 1e-12 * abs(found)
    assert highest(workspace.search, row, count, sign, span[2], found + 1.0) == found + 1.0


# Whole records.


def noise(count: int, seed: int = 7, size: float = 3.0) -> np.ndarray:
    """A burst of noise [m/s²]."""
    shape = np.hanning(count)
    return size * shape * np.random.default_rng(seed).standard_normal(count)


def stepped(building: Building, ground: np.ndarray, dt: float, parts: int = 1) -> np.ndarray:
    """(u, u̇) at the samples and at ``parts`` - 1 places between them: SciPy's exponential of each step."""
    o = building.oscillator()
    a = np.zeros((4, 4))
    a[0, 1] = a[2, 3] = 1.0
    a[1] = -o.omega2, -o.two_zeta_omega, -o.ground, 0.0
    maps = [expm(a * (dt * part / parts)) for part in range(1, parts + 1)]
    states, here = [(0.0, 0.0)], np.zeros(2)
    if building.is_rigid:
        return np.zeros(((len(ground) - 1) * parts + 1, 2))
    for start, stop in pairwise(ground):
        full = np.array([*here, start, (stop - start) / dt])
        for exponential in maps:
            states.append(tuple((exponential @ full)[:2]))
        here = np.array(states[-1])
    return np.array(states)


PAIRS = [
    (building(0.208), building(0.007)),
    (building(0.005, 0.0), building(3.0, 0.02)),
    (building(0.5), building(1.0)),
    (building(2.0, 0.0), Building.rigid("rock")),
    (building(0.05, 0.9), building(0.06, 0.3)),
]


def watched(pair: tuple[Building, Building], ground: np.ndarray, dt: float, parts: int) -> np.ndarray:
    """The five watched signals of the free response, densely: shape (places, SIGNALS)."""
    left, right = (stepped(one, ground, dt, parts) for one in pair)
    shakes = [
        -one.oscillator().two_zeta_omega * states[:, 1] - one.oscillator().omega2 * states[:, 0]
        for one, states in zip(pair, (left, right), strict=True)
    ]
    return np.column_stack([left[:, 0] - right[:, 0], left[:, 0], right[:, 0], *shakes])


@pytest.mark.parametrize("pair", PAIRS)
def test_the_free_response_is_exact(pair):
    ground, dt = noise(300), 0.01
    free = free_response(oscillators(*pair), ground, dt)
    parts = (len(free.ground) - 1) // (len(ground) - 1)
    assert free.step * parts == pytest.approx(dt)
    states = free.states[::parts]
    for side, one in enumerate(pair):
        witness = stepped(one, ground, dt)
        # T = 0.005 s divides the step: its u̇ is zero at every sample, so that u must give the scale.
        size = max(np.abs(witness[:, 0]).max(), 1e-300)
        omega = 0.0 if one.is_rigid else 2.0 * pi / one.period
        for part, scale in enumerate((size, max(np.abs(witness[:, 1]).max(), omega * size))):
            assert np.abs(states[:, side + 2 * part] - witness[:, part]).max() <= 1e-10 * scale


@pytest.mark.parametrize("pair", PAIRS)
def test_block_extremes_hold_the_motion_between_nodes(pair):
    """No dense sample of a block is outside its extremes, and the extremes of the whole are reached."""
    ground, dt = noise(120), 0.01
    free = free_response(oscillators(*pair), ground, dt)
    nodes = (len(free.ground) - 1) // (len(ground) - 1)
    parts = nodes * ceil(200 / nodes)
    dense = watched(pair, ground, dt, parts)
    per_block = BLOCK * parts // nodes
    assert len(free.high) == ceil((len(free.ground) - 1) / BLOCK)
    scale = np.abs(dense).max(axis=0) + 1e-300
    for block in range(len(free.high)):
        values = dense[block * per_block : (block + 1) * per_block + 1]
        assert np.all(values.max(axis=0) <= free.high[block] + 1e-9 * scale)
        assert np.all(values.min(axis=0) >= free.low[block] - 1e-9 * scale)
    # A local maximum between two of the dense samples is at most this much higher.
    assert np.all(np.abs(free.high.max(axis=0) - dense.max(axis=0)) <= 1e-4 * scale)
    assert np.all(np.abs(free.low.min(axis=0) - dense.min(axis=0)) <= 1e-4 * scale)


def flown(pair, free, gap, start, state):
    """`fly` with a workspace without peaks: (node, offset, state), high, low."""
    workspace = make_workspace()
    node, offset, state = flight.fly(oscillators(*pair), free, gap, start, state, workspace)
    return (node, offset, state), workspace.high.copy(), workspace.low.copy()


def never_quiet(free):
    """The same free response, whose blocks claim to be so large that none is passed over."""
    return free._replace(high=np.full_like(free.high, inf), low=np.full_like(free.low, -inf))


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("share", [0.02, 0.3, 0.7, 0.95, 0.999999, 1.000001])
def test_the_first_touch_of_a_record(pair, share):
    """Against a dense sampling of the whole record; skipping blocks changes nothing."""
    ground, dt = noise(300, seed=11), 0.01
    free = free_response(oscillators(*pair), ground, dt)
    nodes = (len(free.ground) - 1) // (len(ground) - 1)
    parts = nodes * ceil(40 / nodes)
    dense = watched(pair, ground, dt, parts)[:, 0]
    gap = share * max(dense.max(), free.high[:, 0].max())
    (node, offset, _), high, low = flown(pair, free, gap, (0, 0.0), (0.0,) * 4)
    whole, high_too, low_too = flown(pair, never_quiet(free), gap, (0, 0.0), (0.0,) * 4)
    if share > 1.0:
        assert node == whole[0] == -1
    else:
        time, ours = node * free.step + offset, dt / parts
        assert whole[0] == node
        assert whole[1] == pytest.approx(offset, rel=1e-9, abs=1e-9 * free.step)
        above = np.flatnonzero(dense > gap * (1.0 + 1e-9))
        if share < 0.99:
            assert time <= above[0] * ours + 1e-9
        assert dense[: int(time / ours) + 1].max() <= gap * (1.0 + 1e-9)
    assert high == pytest.approx(high_too, rel=1e-9)
    assert low == pytest.approx(low_too, rel=1e-9)


@pytest.mark.parametrize("pair", PAIRS[:4])
@pytest.mark.parametrize("kick", [1e-6, 0.01, 3.0])
def test_peaks_after_a_contact_are_those_of_the_continuous_motion(pair, kick):
    """From a kick in mid-interval on: free response + free vibration, sampled densely from there."""
    ground, dt = noise(300, seed=5), 0.01
    free = free_response(oscillators(*pair), ground, dt)
    node = 3 * BLOCK + 5
    offset = 0.4 * free.step
    span = (free.ground[node], (free.ground[node + 1] - free.ground[node]) / free.step)
    state = []
    for side, oscillator in enumerate(oscillators(*pair)):
        u, v = closed_form(oscillator, *free.states[node, side::2], span, offset)
        state += [float(u), float(v) - kick * (1.0 - 2.0 * side) * (oscillator.ground > 0.0)]
    state = (state[0], state[2], state[1], state[3])
    _, high, low = flown(pair, free, inf, (node, offset), state)
    _, high_too, low_too = flown(pair, never_quiet(free), inf, (node, offset), state)
    assert high == pytest.approx(high_too, rel=1e-9, abs=1e-300)
    assert low == pytest.approx(low_too, rel=1e-9, abs=1e-300)
    dense, here = [], state
    starts = [(node, offset), *((n, 0.0) for n in range(node + 1, len(free.ground) - 1))]
    x = np.linspace(0.0, 1.0, 41)
    for n, begun in starts:
        slope = (free.ground[n + 1] - free.ground[n]) / free.step
        ramp, places = (free.ground[n] + slope * begun, slope), (free.step - begun) * x
        o, p = oscillators(*pair)
        u, v = (part.astype(float) for part in closed_form(o, here[0], here[2], ramp, places))
        w, z = (part.astype(float) for part in closed_form(p, here[1], here[3], ramp, places))
        dense.append(
            np.column_stack([u - w, u, w, -o.two_zeta_omega * v - o.omega2 * u, -p.two_zeta_omega * z - p.omega2 * w])
        )
        here = (u[-1], w[-1], v[-1], z[-1])
    samples = np.vstack(dense)
    scale = np.abs(samples).max(axis=0) + 1e-300
    # Peaks start from zero, as those of a run do.
    assert np.all(high >= samples.max(axis=0) - 1e-9 * scale)
    assert np.all(high <= np.maximum(samples.max(axis=0), 0.0) + 1e-3 * scale)
    assert np.all(low <= samples.min(axis=0) + 1e-9 * scale)
    assert np.all(low >= np.minimum(samples.min(axis=0), 0.0) - 1e-3 * scale)


@pytest.mark.parametrize("period", [0.005, 0.3])
def test_an_undamped_building_keeps_its_energy(period):
    """A pulse, then a minute of nothing: thousands of vibrations, the same energy."""
    ground = np.zeros(6001)
    ground[1:20] = 5.0 * np.sin(np.linspace(0.0, 2.0 * pi, 21))[1:-1]
    pair = oscillators(building(period, 0.0), Building.rigid("rock"))
    free = free_response(pair, ground, 0.01)
    after = free.states[ceil(0.25 / free.step) :]
    energy = 0.5 * (after[:, 2] ** 2 + pair[0].omega2 * after[:, 0] ** 2)
    assert energy[0] > 0.0
    assert np.abs(energy / energy[0] - 1.0).max() <= 1e-10


# Runs.

FRAME, MASONRY = building(0.5, mass=5e5), building(0.2, mass=8e5)
CONTACT = Interface(0.005, Jankowski(2.75e9), constant(0.65))


def agree(one: dict, other: dict, tolerance: float, apart: tuple[str, ...] = ()) -> None:
    for name in one.keys() - {"steps", *apart}:
        assert one[name] == pytest.approx(other[name], rel=tolerance, abs=1e-300, nan_ok=True), name


def test_a_record_cut_into_finer_samples_is_the_same_record():
    """a_g is linear between samples: samples laid between them change nothing."""
    ground = noise(200, seed=3)
    fine = np.interp(np.arange(199 * 4 + 1) / 4.0, np.arange(200), ground)
    one, other = (solve(FRAME, MASONRY, CONTACT, a, dt, rtol=1e-9) for a, dt in ((ground, 0.01), (fine, 0.0025)))
    assert one["impact_count"] >= 3.0
    agree(one, other, 1e-6, apart=("energy_residual",))


@pytest.mark.parametrize("rtol", [1e-2, 1e-3])
def test_steps_may_pass_nodes_within_a_sample(rtol):
    """The masonry turns by 9 rad within a sample, which is divided; the digits asked for are got."""
    ground = noise(200, seed=3)
    coarse, fine = (solve(FRAME, MASONRY, CONTACT, ground, 0.01, rtol=each) for each in (rtol, 1e-10))
    assert fine["impact_count"] >= 3.0
    agree(coarse, fine, 2.0 * rtol, apart=("energy_residual",))


@pytest.mark.parametrize("gap", [0.5, inf])
def test_a_gap_that_is_never_closed_leaves_two_free_buildings(gap):
    """Equal in bits to the response without contact."""
    ground = noise(300, seed=3)
    found = solve(FRAME, MASONRY, CONTACT._replace(gap=gap), ground, 0.01)
    free = free_response(oscillators(FRAME, MASONRY), ground, 0.01)
    assert found["impact_count"] == 0.0
    assert found["peak_closing"] == free.high[:, 0].max()
    assert found["peak_opening"] == -free.low[:, 0].min()
    for side, name in ((1, "left"), (2, "right")):
        assert found[f"peak_displacement_{name}"] == max(free.high[:, side].max(), -free.low[:, side].min())
