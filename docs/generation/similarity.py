"""Self-similarity of buildings that pound under pulses (Dimitrakopoulos, Kappos and Makris 2009), as a figure.

Displacements over a_p T_p² and forces over m a_p, of a pulse of amplitude a_p and duration T_p, depend on dimensionless
groups alone: ratios of periods to T_p, of masses, of the gap to a_p T_p² and of the contact's stiffness. So peaks under
different pulses lie on one curve. Run as a script with a folder, this writes the figure there.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import pounding_risk as pr

PULSES = ((1.0, 0.5), (4.0, 0.5), (2.5, 1.25))  # a_p [m/s²], T_p [s]
RATIOS = np.geomspace(0.3, 2.0, 18)  # period of the left building over T_p; the right one's is 0.35 of that
MASSES = (2e5, 3e5)  # kg
GAP = 0.001  # of a_p T_p²
STIFFNESS = 4000.0  # of the left mass over T_p², and for Hertz over the root of a_p T_p² as well
STEPS = 64  # samples in the pulse; as many of rest behind it


def pulse(folder: Path, amplitude: float, duration: float) -> Path:
    """A record file of one cycle of a sine, and rest of twice its duration behind it."""
    times = np.arange(STEPS + 1) / STEPS
    samples = np.concatenate([amplitude * np.sin(2.0 * np.pi * times), np.zeros(2 * STEPS)])
    head = f"# unit = m/s^2\n# dt = {duration / STEPS!r} s\n"
    file = folder / f"pulse_{amplitude}_{duration}.txt"
    file.write_text(head + "\n".join(map(repr, samples.tolist())) + "\n")
    return file


def peaks(folder: Path, law: str, amplitude: float, duration: float, ratio: float) -> np.ndarray:
    """Peak displacements of both buildings [m], peak contact force [N] and number of contacts, under a pulse."""
    length = amplitude * duration**2
    power = length**0.5 if law == "jankowski" else 1.0
    stiffness = STIFFNESS * MASSES[0] / duration**2 / power
    scene = pr.Scene(
        [
            pr.SingleMass("left", mass=MASSES[0], period=ratio * duration, damping=0.05),
            pr.SingleMass("right", mass=MASSES[1], period=0.35 * ratio * duration, damping=0.05),
        ],
        [pr.Interface(gap=GAP * length, contact_model=law, stiffness=stiffness, restitution=0.65)],
        pr.Records(files=[str(pulse(folder, amplitude, duration))]),
        solver=pr.Solver(1e-9),
    )
    run = pr.simulate(scene)
    return np.array([*run.peak_displacement.values, run.peak_contact_force.item(), run.impact_count.item()])


def similarity_figure(folder: Path) -> object:
    """Peak contact force against the ratio of periods: as it is, and over the left building's mass times a_p."""
    figure, axes = pr.figures.blank(1, 2, (9.6, 4.2))
    collapsed = []
    for (colour, dash), (amplitude, duration) in zip(pr.figures.styles(len(PULSES)), PULSES, strict=True):
        found = np.array([peaks(folder, "kelvin_voigt", amplitude, duration, ratio)[2] for ratio in RATIOS])
        collapsed.append(found / (MASSES[0] * amplitude))
        look = {"color": colour, "linestyle": dash, "marker": "o", "markersize": 3.5, "markerfacecolor": "none"}
        axes[0, 0].plot(RATIOS, found * 1e-3, label=f"{amplitude:g} m/s², {duration:g} s", **look)
        axes[0, 1].plot(RATIOS, collapsed[-1], **look)
    axes[0, 0].set(xlabel="period of the left building over $T_p$", ylabel="peak contact force [kN]")
    axes[0, 1].set(xlabel="period of the left building over $T_p$", ylabel="peak contact force over $m a_p$")
    axes[0, 0].legend(fontsize=8, title="pulse $a_p$, $T_p$", title_fontsize=8)
    apart = max(float(np.abs(one / collapsed[0] - 1.0).max()) for one in collapsed)
    finding = f"Three pulses, one curve: peak forces over $m a_p$ agree to {apart:.0e}"
    condition = f"masses of 200 t and 300 t, Kelvin-Voigt contact, e = 0.65; gap {GAP:g} of $a_p T_p^2$"
    pr.figures.title(figure, finding, condition)
    return figure


if __name__ == "__main__":
    target = Path(sys.argv[1])
    pr.figures.write(similarity_figure(target), target / "similarity.png")
