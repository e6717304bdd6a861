"""How fast, accurate and robust is the tissue on this machine?"""
