"""How fast, accurate and robust is each part of Calot on this machine?

Each file is one bench; those of many patients are in `trials`.
"""
