"""What does the field look like? Surfaces, textures and light for the cameras."""
