import sys

from pounding_risk import history as _now

sys.modules[__name__] = _now
