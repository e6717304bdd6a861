"""Which motion nearest to the wanted motion keeps every limit of the robot and the anatomy?"""
