"""How far instruments are from what they must not hit."""
