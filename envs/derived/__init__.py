"""What follows from the MJCF text of a body alone: its tree of joints, legs, contact points,
motors and anatomy,
and settings that suit its weight and its height.
"""
