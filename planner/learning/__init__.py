"""What all learners share: how weights are fitted, and files of them."""
