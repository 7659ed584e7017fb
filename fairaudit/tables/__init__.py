"""Readers that turn files into columns of text, from which `Law` and `Utility` are built."""
