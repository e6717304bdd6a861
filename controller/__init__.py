"""How should the tools move to carry out an instruction?"""
