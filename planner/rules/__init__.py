"""Which hand-written rules overrule a network, and how often do they?"""
