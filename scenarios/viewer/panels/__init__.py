"""Which panels stand beside the 3D scene? Each file is one panel."""
