"""From a law and a utility to a result: measured, judged against targets, claimed."""
