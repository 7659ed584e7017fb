"""Streams of decisions: what was counted, what it shows at any moment, a state that survives, readers of growing files."""
