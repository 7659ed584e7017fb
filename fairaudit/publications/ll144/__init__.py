"""The publication that New York City's rule on automated employment decision tools asks for."""
