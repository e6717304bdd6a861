"""What is drawn in the 3D scene? Each file draws objects of one kind."""
