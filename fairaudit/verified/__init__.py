"""What is done with certificates only after the checker has looked at them. This is the one folder that asks it."""
