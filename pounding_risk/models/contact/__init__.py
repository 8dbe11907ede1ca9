"""Contact laws, models of instant impact, damping from restitution, registration of own laws."""
