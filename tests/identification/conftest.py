"""One long clean record for the whole room."""

import pytest

from rigsim.identification.identify import identify
from tests.identification.cubic import cubic_record


@pytest.fixture(scope="session")
def clean_record():
    """100 s of the paper's test, force held at its value, without noise."""
    return cubic_record()


@pytest.fixture(scope="session")
def readings(clean_record):
    """Its identification in each of the three readings."""
    return {conversion: identify(clean_record, conversion=conversion) for conversion in ("force", "all", "none")}
