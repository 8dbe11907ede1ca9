"""``python -m pounding_risk`` is ``pounding-risk``."""

from __future__ import annotations

from pounding_risk.cli import main

if __name__ == "__main__":
    main()
