"""The physics, in scalars: contact laws, restitution, structures, the integration tableau."""
