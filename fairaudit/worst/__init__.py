"""The utility of a class that makes a law look worst, between exact ends."""
