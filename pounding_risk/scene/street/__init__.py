"""A street's table or footprints as rows of buildings and scenes."""
