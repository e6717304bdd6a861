"""How do people watch a procedure in a browser and correct it?"""
