"""MuJoCo's own contacts, constraints and solver as a law, written for `lanes`."""
