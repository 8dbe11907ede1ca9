"""Published cases run and compared: each is one file of the folder `pounding_risk/verification`, or of a user's own.

Published relations without a single number, the properties, are functions listed in `run`.
"""

from pounding_risk.lab.verification.property import Property, Reading
from pounding_risk.lab.verification.run import Check, Curve, Verification, verify

__all__ = ["Check", "Curve", "Property", "Reading", "Verification", "verify"]
