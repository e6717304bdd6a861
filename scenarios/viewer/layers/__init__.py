"""What is drawn in the 3D scene? One kind of object a file."""
