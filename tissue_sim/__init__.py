"""Which objects exist in the operating field, and how do they move?"""
