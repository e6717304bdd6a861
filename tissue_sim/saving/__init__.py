"""How is a world's state saved, checked and restored?"""
