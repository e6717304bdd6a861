"""What is drawn in the 3D scene? Each file draws one kind of object."""
