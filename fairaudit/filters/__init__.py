"""Which ε and which filter for a target: calibrated, or designed by linear programs."""
