"""Which parts of the tissue have a name? Tubes, gallbladder and the body that holds them."""
