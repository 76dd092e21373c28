"""Many runs in one folder: a grid of seeds and settings, on this machine or on a cluster."""

from mjxwalk.sweep.grid import grid
from mjxwalk.sweep.plan import FILE, Plan, PlannedRun, Resources

__all__ = ["FILE", "Plan", "PlannedRun", "Resources", "grid"]
