"""A second opinion on a walker: its trials again in C MuJoCo, in float64."""
