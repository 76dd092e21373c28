"""A user's MJCF or URDF file, read by MuJoCo rewritten as one self-contained MJCF text.

`reader.read` is the way in.
"""
