"""Demonstrations on disk, in the layout of LeRobot's dataset v3, and back."""
