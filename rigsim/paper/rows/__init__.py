"""The ledger's rows by what they are about, each with the function that computes it. A new claim belongs here."""

from . import identification, response, rig, sine_tests, wobbling

ROWS = (*rig.ROWS, *identification.ROWS, *response.ROWS, *sine_tests.ROWS, *wobbling.ROWS)
