"""Readers of binary files, run in a process of its own by `rigsim.experiment.formats.binary`: no file is trusted.

A module a format. ``contents(file, most)`` gives what an open file holds, a list of `Found` (their samples together
take at most ``most`` bytes), and what it says beside them (a dict); ``rehearse()`` reads a file made in memory, so that
all that reading needs is loaded before the process may open no more files.
"""
