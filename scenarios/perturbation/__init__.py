"""What disturbs an episode: the patient, the robot or the loop between them."""
