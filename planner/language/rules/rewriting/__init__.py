"""How is a sentence written out plainly before it is read?"""
