"""What can disturb an episode: the patient, the robot, or the loop between them?"""
