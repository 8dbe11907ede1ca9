"""Effects that a scene may ask for: of the contact, of the building, of the ground."""
