"""How are the weights of a network trained, and how are they kept in a file?"""
