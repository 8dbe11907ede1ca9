"""Figures from results alone: no solver, no scene. Titles state the finding with numbers taken from the data."""

from __future__ import annotations

from pounding_risk.figures_accuracy import accuracy_figure
from pounding_risk.figures_compare import agreement_figure, reference_figure
from pounding_risk.figures_effects import effects_figure
from pounding_risk.figures_records import processing_figure, selection_figure, spectra_figure
from pounding_risk.figures_runs import comparison_figure, impact_figure, parting, plateau, simulation_figure
from pounding_risk.figures_scans import ratio_figure, scan_figure, window_figure
from pounding_risk.figures_style import write

__all__ = [
    "accuracy_figure",
    "agreement_figure",
    "comparison_figure",
    "effects_figure",
    "impact_figure",
    "parting",
    "plateau",
    "processing_figure",
    "ratio_figure",
    "reference_figure",
    "scan_figure",
    "selection_figure",
    "simulation_figure",
    "spectra_figure",
    "window_figure",
    "write",
]
