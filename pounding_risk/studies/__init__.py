"""One module for each question: impact, simulate, compare, accuracy, effects, stability, and so on."""
