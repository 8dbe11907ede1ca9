import sys

from pounding_risk.core import pound as _now

sys.modules[__name__] = _now
