"""How results reach the disk: whole, as strict JSON, with versions."""
