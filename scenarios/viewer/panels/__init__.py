"""Which panels stand beside the 3D scene? One panel a file."""
