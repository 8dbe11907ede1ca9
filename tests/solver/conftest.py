"""OpenSees, for the modules that hold the solver to it."""

from __future__ import annotations

from typing import Any

import pytest

from pounding_risk.errors import PoundingError
from pounding_risk.lab.accuracy_opensees import load


@pytest.fixture
def ops() -> Any:
    """Its module; where it is not installed a test is skipped, with the reason."""
    try:
        return load()
    except PoundingError as reason:
        pytest.skip(str(reason))
