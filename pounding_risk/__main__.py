"""Entry point of ``python -m pounding_risk``, the same as the command ``pounding-risk``."""

from __future__ import annotations

from pounding_risk.cli import main

if __name__ == "__main__":
    main()
