"""Tables of hazard as files, and fragilities, made for the tests of rates and scenarios."""

from __future__ import annotations

from pathlib import Path

from pounding_risk.assessment.fragility import Fragility


def fragility(median: float = 3.0, dispersion: float = 0.4, recordings: int = 10**6, **more: float) -> Fragility:
    """A curve of contact at a gap of 20 mm from so many recordings; ``more`` are other errors than the usual ones."""
    errors = {"se_median": 0.1, "se_dispersion": 0.05} | more
    by_recording = {f"{name}_recordings": value for name, value in errors.items()}
    about = ("contact", 0.02, None, None, "pga", "multiple stripes", median, dispersion)
    return Fragility(
        *about, **errors, **by_recording, correlation=0.0, fault="", note="", stripes=(), recordings=recordings
    )


def site_file(folder: Path, *lines: str) -> Path:
    """A table of hazard of these lines; a head alone has the rates 0.01 im^−2 from 0.1 to 100."""
    return written(folder / "site.csv", "\n".join(lines if len(lines) > 1 else [*lines, "0.1,1", "100,1e-6"]) + "\n")


def written(file: Path, text: str) -> Path:
    """The file, with this text in it."""
    file.write_text(text)
    return file
