"""What do the results of many episodes say: rates, pairs, groups and predictions?"""
