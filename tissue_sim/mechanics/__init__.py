"""How does tissue move? Finite elements, springs and contact, one implicit step at a time."""
