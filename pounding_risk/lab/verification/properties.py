"""The published relations that `verify` checks beside the cases, each a function that makes a `Property`."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from pounding_risk.lab.verification.contacts import (
    isolated_impacts,
    kelvin_voigt_laws,
    plateaus,
    twins_and_wall,
    yielding_contact,
)
from pounding_risk.lab.verification.noise import double_difference, first_passage
from pounding_risk.lab.verification.property import Property
from pounding_risk.lab.verification.pulses import self_similarity

PROPERTIES: Mapping[str, Callable[[], Property]] = {
    made.__name__: made
    for made in (
        isolated_impacts,
        kelvin_voigt_laws,
        twins_and_wall,
        plateaus,
        yielding_contact,
        self_similarity,
        double_difference,
        first_passage,
    )
}
