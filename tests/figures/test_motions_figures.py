"""Figures of records: what is drawn is the motions' own data, and what captions say is true of it."""

import re
from dataclasses import replace

import numpy as np
import pytest
from figure_words import words_of
from sentences import refusal
from sweeps import sweep

from pounding_risk import figures
from pounding_risk.figures.motions import at_periods, corners, fourier_amplitude, longest_usable
from pounding_risk.motions import intensity as measures
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.processing.noise import signal_to_noise
from pounding_risk.motions.read import read_motion
from pounding_risk.motions.selection import select
from pounding_risk.motions.target_spectra import Target
from pounding_risk.units import STANDARD_GRAVITY

DT = 0.01
TARGET = Target("a target", np.array([0.1, 0.5, 5.0]), np.array([9.80665, 9.80665, 0.980665]))


def made(name: str, frequency: float, peak: float = 2.0, dt: float = DT) -> Motion:
    """Ten seconds of a sine under a bell, which starts and ends at rest."""
    time = np.arange(0.0, 10.0, dt)
    samples = peak * np.sin(2.0 * np.pi * frequency * time) * np.exp(-((time - 5.0) ** 2))
    record = {"event": "Here", "date": "1999-01-01", "station": "There", "component": "N", "state": "raw"}
    return Motion(name, samples, dt, record)


@pytest.fixture(scope="module")
def ridgecrest():
    return read_motion("CCC-HN1", processing="none"), read_motion("CCC-HN1")


@pytest.fixture(scope="module")
def processed(ridgecrest):
    return figures.processing_figure(*ridgecrest)


@pytest.fixture(scope="module")
def ensemble():
    return [
        made(f"R{k}", 0.7 * k, 1.0 + 0.3 * k, dt) for k, dt in zip(range(1, 6), (0.01, 0.005, 0.02) * 2, strict=False)
    ]


def lines(axes, label):
    return [line for line in axes.get_lines() if line.get_label() == label]


# --- before and after --------------------------------------------------------------------------------------


def test_histories_are_those_of_the_motions(ridgecrest, processed):
    """Both on the left, on one scale; on the right what is left. The raw displacement, of metres, is told in metres."""
    before, after = ridgecrest
    sizes = {"acceleration [g]": STANDARD_GRAVITY, "velocity [cm/s]": 0.01, "displacement [m]": 1.0}
    for row, (label, size) in enumerate(sizes.items()):
        left, right = processed.axes[2 * row : 2 * row + 2]
        assert left.get_ylabel() == label
        for line, motion in zip(left.get_lines(), (before, after), strict=True):
            samples = (motion.acceleration, *motion.velocity_displacement())[row]
            np.testing.assert_array_equal(line.get_ydata(), samples / size)
            np.testing.assert_array_equal(line.get_xdata(), motion.times)
        own = size if row < 2 else 0.01
        samples = (after.acceleration, *after.velocity_displacement())[row]
        np.testing.assert_array_equal(right.get_lines()[0].get_ydata(), samples / own)
        low, high = right.get_ylim()
        assert high - low < 4.0 * np.abs(samples).max() / own  # the later curve fills its panel


def test_peaks_are_marked_where_they_are(ridgecrest, processed):
    after = ridgecrest[1]
    histories, sizes = (after.acceleration, *after.velocity_displacement()), (STANDARD_GRAVITY, 0.01, 0.01)
    for row, (samples, size, unit) in enumerate(zip(histories, sizes, ("g", "cm/s", "cm"), strict=True)):
        axes = processed.axes[2 * row + 1]
        place = int(np.abs(samples).argmax())
        (time,), (value,) = axes.get_lines()[1].get_data()
        assert (time, value) == (place * DT, samples[place] / size)
        assert [text.get_text() for text in axes.texts] == [f"{abs(value):.3g} {unit} at {time:.4g} s"]


def test_the_title_has_peaks_and_the_caption_the_origin(ridgecrest, processed):
    headline, caption = words_of(processed).split("\n", 1)
    pattern = r"Processing of CCC-HN1 changes PGA from (.+) to (.+) g and PGD from (.+) to (.+) cm"
    changes = [float(number) for number in re.fullmatch(pattern, headline).groups()]
    of_raw = ridgecrest[0].pga / STANDARD_GRAVITY, 100.0 * np.abs(ridgecrest[0].velocity_displacement()[1]).max()
    np.testing.assert_allclose(changes[::2], of_raw, rtol=5e-3)
    after = ridgecrest[1].pga / STANDARD_GRAVITY, 100.0 * np.abs(ridgecrest[1].velocity_displacement()[1]).max()
    np.testing.assert_allclose(changes[1::2], after, rtol=5e-3)  # three digits
    assert "Ridgecrest, California, 2019-07-06" in caption and caption.endswith("component HN1")


def test_histories_of_motions_are_a_row_each(ensemble, says):
    """On axes with units, the largest value above each; more than a page holds are refused."""
    figure = figures.histories_figure(ensemble[:2])
    assert len(figure.axes) == 6
    sizes = {"a [g]": STANDARD_GRAVITY, "v [cm/s]": 0.01, "d [cm]": 0.01}
    for row, motion in enumerate(ensemble[:2]):
        histories = (motion.acceleration, *motion.velocity_displacement())
        for axis, samples, (label, size) in zip(figure.axes[3 * row :], histories, sizes.items(), strict=False):
            np.testing.assert_array_equal(axis.get_lines()[0].get_data(), (motion.times, samples / size))
            peak = f"{np.abs(samples).max() / size:.3g} {label[3:-1]}"
            assert (axis.get_ylabel(), axis.get_title(loc="right")) == (label, peak)
        assert figure.axes[3 * row].get_title(loc="left") == motion.name
    assert {axis.get_xlabel() for axis in figure.axes[3:]} == {"time [s]"}
    for count in (0, 13):
        says(refusal(figures.histories_figure, ensemble[:1] * count))


def test_a_drift_of_metres_is_written_in_full():
    moving = replace(read_motion("RSN6-180"), acceleration=np.full(600, 1.0))
    figure = figures.histories_figure([moving])
    assert figure.axes[2].get_title(loc="right") == "1790 cm"  # 5.99² / 2 m


def test_corners_are_those_of_the_filter():
    """Of both, one or no corner."""
    chosen = read_motion("CCC-HN1", processing=[{"step": "bandpass", "low": 0.12, "high": 21.5}])
    assert corners(chosen) == (0.12, 21.5)
    assert corners(read_motion("CCC-HN1", processing=[{"step": "bandpass", "low": 0.0, "high": 21.5}])) == (21.5,)
    assert corners(read_motion("CCC-HN1", processing=[{"step": "bandpass", "low": 0.12, "high": np.inf}])) == (0.12,)
    assert corners(made("R", 1.0)) == ()
    drawn = lines(
        figures.processing_figure(read_motion("CCC-HN1", processing="none"), chosen).axes[-1], "corners of the filter"
    )
    assert [line.get_xdata()[0] for line in drawn] == [0.12]


def test_the_noise_is_that_before_the_earthquake(ridgecrest, processed):
    """Drawn for a raw record, far below the earthquake; a processed one has no noise of its own to show."""
    (noise,) = lines(processed.axes[-1], "noise before the earthquake, smoothed")
    found = signal_to_noise(ridgecrest[0].acceleration, DT)
    np.testing.assert_array_equal(noise.get_data(), (found.frequency, found.noise))
    low, high = processed.axes[-1].get_ylim()
    assert low < noise.get_ydata().min() and noise.get_ydata().max() < high
    told = figures.processing_figure(read_motion("RSN6-180"), read_motion("RSN6-180")).axes[-1]
    assert lines(told, noise.get_label()) == []


def test_fourier_amplitude_of_a_sine_under_a_bell():
    """It peaks at the frequency of the sine, at half of the area under the bell."""
    motion = made("R", 2.0)
    frequency, amplitude = fourier_amplitude(motion.acceleration, motion.dt)
    assert frequency[amplitude.argmax()] == pytest.approx(2.0, rel=0.06)  # half the width of a bin
    # ∫|a e^{-2πift}|: half of the area under the bell at the sine's own frequency, peak · √π / 2.
    assert amplitude.max() == pytest.approx(2.0 * np.sqrt(np.pi) / 2.0, rel=0.05)  # its mean over a bin is lower


def test_a_window_stands_where_it_was_cut():
    before = made("R", 1.0)
    after = Motion("R", before.acceleration[300:700], DT, before.record)
    figure = figures.processing_figure(before, after, shift=3.0)
    line = figure.axes[0].get_lines()[1]
    assert (line.get_xdata()[0], line.get_ydata()[0] * STANDARD_GRAVITY) == (
        3.0,
        pytest.approx(before.acceleration[300]),
    )
    assert figure.axes[0].get_xlim() == (0.0, before.times[-1])


@pytest.mark.complete
def test_a_record_left_alone_is_stated():
    figure = figures.processing_figure(made("R", 1.0), made("R", 1.0), note="assumed: all")
    assert words_of(figure).splitlines()[::2] == ["Processing leaves R as it is", "assumed: all"]


# --- spectra -----------------------------------------------------------------------------------------------


def test_spectra_are_those_of_the_measures(ensemble):
    """Every record's own line, its median and percentiles, of motions with unlike time steps."""
    figure = figures.spectra_figure(ensemble, TARGET, percentiles=(10.0, 90.0))
    (axes,) = figure.axes
    grey, (median,), shares = (lines(axes, label) for label in ("5 records", "median", "10 and 90 %"))
    periods = median.get_xdata()
    assert (periods[0], periods[-1]) == (0.02, pytest.approx(10.0))
    alone = [
        measures.response_spectra(each.acceleration, each.dt, periods).pseudo_acceleration / STANDARD_GRAVITY
        for each in ensemble
    ]
    drawn = [line.get_ydata() for line in axes.get_lines()[:5]]
    np.testing.assert_allclose(drawn, alone, rtol=1e-12)  # one call for all is the same as one each
    np.testing.assert_allclose(median.get_ydata(), np.median(alone, axis=0), rtol=1e-12)
    np.testing.assert_allclose(shares[0].get_ydata(), np.percentile(alone, 10.0, axis=0), rtol=1e-12)
    assert len(grey) == 1 and axes.get_xscale() == axes.get_yscale() == "log"
    ratios = np.median(alone, axis=0) * STANDARD_GRAVITY / at_periods(TARGET, periods)
    found = re.match(r"Median Sa of 5 records is (.+) to (.+) times .* from 0.1 to 5 s", words_of(figure))
    np.testing.assert_allclose([*map(float, found.groups())], [np.nanmin(ratios), np.nanmax(ratios)], atol=5e-3)
    assert "Damping 5 %" in words_of(figure) and "10 to 90 %" in words_of(figure)


def test_a_target_is_straight_on_logarithmic_scales():
    """1/T between 0.5 and 5 s, as a code's branch is; nothing beyond its ends."""
    periods = np.array([0.05, 0.1, 0.3, 1.0, 5.0, 7.0])
    expected = STANDARD_GRAVITY * np.array([np.nan, 1.0, 1.0, 0.5, 0.1, np.nan])
    np.testing.assert_allclose(at_periods(TARGET, periods), expected, rtol=1e-12)  # rounding
    assert np.isnan(at_periods(TARGET, np.array([7.0, 9.0]))).all()


def test_the_longest_usable_period_is_that_of_the_strictest_filter():
    """From the file, or 1.25 times the lower corner of the file's or our own filter; the least of all is drawn."""
    told, filtered, silent = made("T", 1.0), made("F", 1.0), made("S", 1.0)
    told.record["lowest_usable_frequency"] = 0.25
    filtered.record["low_corner"] = 0.1
    own = read_motion("CCC-HN1", processing=[{"step": "bandpass", "low": 0.16, "high": 20.0}])
    assert [longest_usable(each) for each in (told, filtered, silent)] == [4.0, 8.0, None]
    assert longest_usable(own) == pytest.approx(5.0)
    (axes,) = figures.spectra_figure([told, filtered, own]).axes
    assert lines(axes, "usable up to 4 s: every record")[0].get_xdata()[0] == 4.0
    (axes,) = figures.spectra_figure([filtered, silent]).axes
    assert lines(axes, "usable up to 8 s: 1 of 2 records")
    assert not [each for each in figures.spectra_figure([silent]).axes[0].get_lines() if "usable" in each.get_label()]


def test_one_record_has_no_median():
    figure = figures.spectra_figure([made("R", 1.0)], damping=0.02)
    assert [text.get_text() for text in figure.axes[0].get_legend().get_texts()] == ["the record"]
    # A sine of 1 Hz under a bell.
    assert re.fullmatch(r"Sa of R is largest at (0.95|1) s: [0-9.]+ g\nDamping 2 %", words_of(figure))


@pytest.mark.filterwarnings("error")
@pytest.mark.complete
def test_motions_at_the_edge(says):
    """Two samples, and zeros throughout: drawn without a warning, but for a spectrum that no scale can show."""
    two, still = (Motion("R", np.array(each), DT, {"state": "raw"}) for each in ([0.1, -0.1], [0.0] * 50))
    for motion in (two, still):
        figures.processing_figure(motion, motion).draw_without_rendering()
    assert two.name in figures.spectra_figure([two]).get_suptitle()
    says(refusal(figures.spectra_figure, [two, still]), refusal(figures.spectra_figure, []))


# --- a selection -------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def chosen(ensemble):
    return select(ensemble, TARGET, periods=(0.3, 1.0), count=3, limits=(0.1, 8.0))


def test_a_selection_is_drawn_as_it_was_made(chosen):
    """Scaled spectra of the chosen ones, their geometric mean where it was compared, a bar of the misfit of each."""
    left, right = figures.selection_figure(chosen).axes
    scaled = [line.get_ydata() for line in left.get_lines()[:3]]
    periods = left.get_lines()[0].get_xdata()
    expected = [
        row.factor * measures.response_spectra(motion.acceleration, motion.dt, periods).pseudo_acceleration
        for row in chosen.rows
        for motion in row.motions
    ]
    np.testing.assert_allclose(scaled, np.array(expected) / STANDARD_GRAVITY, rtol=1e-9)  # spectra of scaled samples
    (mean,) = lines(left, "geometric mean of 3 components")
    np.testing.assert_array_equal(mean.get_xdata(), chosen.periods)
    logs = np.log(chosen.spectra / STANDARD_GRAVITY).mean(axis=0)
    np.testing.assert_allclose(mean.get_ydata(), np.exp(logs), rtol=1e-12)  # rounding
    assert [bar.get_width() for bar in right.patches] == [row.misfit for row in chosen.rows]
    assert [label.get_text() for label in right.get_yticklabels()] == [row.name for row in chosen.rows]
    assert [text.get_text() for text in right.texts] == [f"× {row.factor:.2f}" for row in chosen.rows]
    hatched = [bool(bar.get_hatch()) for bar in right.patches]
    assert hatched == [row.limited for row in chosen.rows] and ("hatched" in right.get_title()) == any(hatched)


def test_the_words_of_a_selection(chosen):
    factors = [row.factor for row in chosen.rows]
    ratios = np.exp(np.log(chosen.spectra).mean(axis=0)) / TARGET.at(chosen.periods)
    assert words_of(figures.selection_figure(chosen, note="assumed: all")).splitlines() == [
        f"3 of 5 candidates: their geometric mean is {ratios.min():.2f} to {ratios.max():.2f} times a target",
        f"Compared from 0.3 to 1 s; damping 5 %; factors {min(factors):.2f} to {max(factors):.2f}",
        "assumed: all",
    ]


def test_a_factor_at_its_limit_is_hatched(ensemble):
    tight = select(ensemble, TARGET, periods=(0.3, 1.0), count=5, limits=(1.0, 1.01))
    axes = figures.selection_figure(tight).axes[1]
    assert all(bar.get_hatch() for bar in axes.patches) and "hatched: at a limit" in axes.get_title()


# --- all of them -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sweep(["processing", "spectra", "one", "selection"], "selection"))
def test_axes_have_units_and_nothing_leaves_the_page(name, processed, ensemble, chosen):
    figure = {
        "processing": lambda: processed,
        "spectra": lambda: figures.spectra_figure(ensemble, TARGET),
        "one": lambda: figures.spectra_figure(ensemble[:1]),
        "selection": lambda: figures.selection_figure(chosen),
    }[name]()
    figure.draw_without_rendering()  # lays out
    for axes in figure.axes:
        assert "[" in axes.get_ylabel() or axes.patches  # bars of records have names instead
        assert any("[" in each.get_xlabel() for each in figure.axes)
        for text in (*axes.texts, axes.xaxis.label, axes.yaxis.label):
            box, page = text.get_window_extent(), figure.bbox
            assert page.x0 <= box.x0 and box.x1 <= page.x1 and page.y0 <= box.y0 and box.y1 <= page.y1, text.get_text()
    title = figure.findobj(lambda artist: getattr(artist, "get_text", str)().startswith(figure.get_suptitle()[:12]))[0]
    assert title.get_window_extent().width <= figure.bbox.width


@pytest.mark.complete
def test_spectra_of_pairs_are_drawn_where_pairs_were_compared():
    """Grey lines, percentiles and mean are of the same thing, so that the mean lies among them."""
    pairs = [
        replace(made(f"R{at}", 0.7 + 0.5 * at, 1.0, DT), record={"event": f"E{at // 2}", "station": "S"})
        for at in range(4)
    ]
    chosen = select(pairs, TARGET, periods=(0.2, 1.0), spectrum="rotd100", count=2)
    axis = figures.selection_figure(chosen).axes[0]
    lines = [line for line in axis.get_lines() if line.get_color() == "#b0b0b0"]
    assert len(lines) == len(chosen.rows)
    assert lines[0].get_label() == f"{len(chosen.rows)} pairs (rotd100), scaled"
    periods = np.asarray(lines[0].get_xdata())
    one, other = chosen.rows[0].motions
    turned = measures.rotated_spectra((one.acceleration, other.acceleration), one.dt, periods, TARGET.damping)
    expected = chosen.rows[0].factor * turned.rotd(100) / STANDARD_GRAVITY
    np.testing.assert_allclose(np.asarray(lines[0].get_ydata()), expected, rtol=1e-9)
