"""Separations that codes ask for and combinations of modal maxima suggest."""
