"""Places, and what other programs state site by site: tables of hazard and motions, and the site that is nearest."""
