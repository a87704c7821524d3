"""Notebooks to offline pages; the only door to nbclient and nbconvert. What a page may hold, and how, belongs here."""
