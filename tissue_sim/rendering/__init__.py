"""How the field looks: surfaces, textures and light for cameras."""
