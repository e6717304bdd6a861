"""Which motion nearest to the wanted one keeps every limit of the robot and the anatomy?"""
