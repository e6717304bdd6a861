"""What can be observed of the field: points, forces and pictures."""
