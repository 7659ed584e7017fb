"""Engines that hold logs, one module each: they count equal rows, and only those counts travel back."""
