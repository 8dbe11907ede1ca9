"""Small helpers without physics: atomic files, progress callbacks, shared values, words. Private."""
