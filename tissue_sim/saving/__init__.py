"""How are a world's state and its pictures saved, checked and restored?"""
