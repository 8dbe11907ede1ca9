"""An example of a package that extends pounding_risk: one law, effect, motion, step, rule, format and command."""
