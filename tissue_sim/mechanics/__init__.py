"""How tissue moves: finite elements, springs and contact, one implicit step at a time."""
