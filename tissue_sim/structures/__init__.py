"""Which parts of the tissue have a name: tubes, gallbladder, and the body that holds them."""
