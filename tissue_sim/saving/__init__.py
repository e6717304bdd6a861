"""How a world's state is saved, checked and restored."""
