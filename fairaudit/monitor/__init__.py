"""Streams of decisions: bounds that hold at every moment, a state that survives, readers of growing files."""
