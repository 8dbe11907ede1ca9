"""One module for each question: the sheet of its answer, which the terminal and the report show alike."""
