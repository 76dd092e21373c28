"""Many runs in one folder, on this machine or on a cluster."""

from mjxwalk.sweep.plan import FILE, Plan, PlannedRun, Resources

__all__ = ["FILE", "Plan", "PlannedRun", "Resources"]
