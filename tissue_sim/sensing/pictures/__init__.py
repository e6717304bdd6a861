"""What do cameras show, and with which errors?"""
