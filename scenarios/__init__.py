"""Set episodes up, run them and judge them."""
