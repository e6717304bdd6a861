"""Perception: from pictures, encoders and motor currents to an observation. It knows no world."""
