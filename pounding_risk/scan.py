import sys

from pounding_risk import ensemble as _now

sys.modules[__name__] = _now
