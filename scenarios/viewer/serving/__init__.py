"""How is the page served, and to whom?"""
