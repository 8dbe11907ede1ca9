"""Generated pages, one module for each subject."""
