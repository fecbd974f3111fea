"""What corrects, bounds or doubts the raw answers of an engine, each amendment in a file of its own.

``amendment_list.py`` lists them in the order in which they act.
"""
