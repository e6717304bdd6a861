"""Which hand-written rules change a chunk after the network?"""
