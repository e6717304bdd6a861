"""How is an episode recorded, and replayed identically to the bit?"""
