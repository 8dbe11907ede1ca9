import sys

from pounding_risk.core import collide as _now

sys.modules[__name__] = _now
