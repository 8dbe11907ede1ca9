"""Published cases run and compared: each is one file of the folder `pounding_risk/verification`, or of a user's own."""

from pounding_risk.studies.verification.run import Check, Curve, Verification, verify

__all__ = ["Check", "Curve", "Verification", "verify"]
