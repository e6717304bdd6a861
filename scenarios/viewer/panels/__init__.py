"""Which panels stand beside the 3D scene? Each file holds panels of one kind."""
