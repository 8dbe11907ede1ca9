"""Buildings: single masses, storeys, typologies, chains of masses, contact points."""
