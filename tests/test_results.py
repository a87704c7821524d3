"""A status is an enumeration's member, its sentence, and words for a table."""

from rigsim import Status


def test_a_status_can_be_asked_for_words_of_its_sentence():
    assert "closes on itself" in Status.CLOSED and "closes" not in Status.STOPPED
    assert str(Status.LEAVES_THE_BAND) == "leaves the band" and str(Status.LEAVES_THE_BAND) not in Status.CLOSED
