"""Which options do commands share, and how are they checked before any work?"""
