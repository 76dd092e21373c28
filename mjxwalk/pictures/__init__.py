"""Pictures of a body on its ground, drawn by MuJoCo without a screen."""
