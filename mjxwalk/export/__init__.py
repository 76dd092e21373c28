"""Walkers for other programs: the controller, the body, and how it walks."""
