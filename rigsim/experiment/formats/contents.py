"""What a reader finds in a file before anybody says what it means."""

from dataclasses import dataclass, field


@dataclass
class Column:
    """One channel of a file, as it stands there."""

    name: str
    unit: str = ""  # that the file says for it
    samples: int | None = None  # None: not counted yet
    interval: float | None = None  # s between samples, that the file says
    first: list = field(default_factory=list)  # values or texts
    why: str = ""  # why it cannot be a channel


@dataclass
class Contents:
    """Columns of an open file, and what else it says.

    ``values(indices, use)`` reads columns, once, and lists what ``use(index, array)`` makes of each (an array of its
    own, stamps in s); ``place(column, sample)`` names a sample as a person finds it; ``count()`` says how many samples
    a column has that does not know.
    """

    form: str
    columns: list
    values: object
    place: object
    details: dict = field(default_factory=dict)  # of a record that was saved here, or said beside the samples
    own: bool = False  # whether it is in the form that `Record.save` writes
    notes: list = field(default_factory=list)  # what reading had to guess
    count: object = None
    stamps: frozenset = frozenset()  # columns that are dates or times of day
