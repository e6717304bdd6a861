"""Which command does a sentence in free text mean?"""
