"""Tests of one rig that lie end to end in a record: where each begins, and how they are joined."""

import numpy as np

from .channels import UNITS


def slices(begins, size):
    """Slices of the samples from each first one to the next, the last up to ``size``."""
    return [slice(*ends) for ends in zip(begins, (*begins[1:], size), strict=True)]


def joined(records):
    """See `Record.joined`; the records are checked to be some."""
    for name in ("sample_rate", "hold", "kinds", "base"):
        values = [getattr(record, name) for record in records]
        other = next((value for value in values if value != values[0]), None)
        if other is not None:
            raise ValueError(f"{name} of the records = {values[0]} and {other}; expected one for all")
    if len(records) == 1:
        return records[0]
    names = [name for name in UNITS if all(name in record.channels for record in records)]
    channels = {name: np.concatenate([getattr(record, name) for record in records]) for name in names}
    ends = np.cumsum([0, *(record.force.size for record in records)])
    joints = [joint + end for record, end in zip(records, ends, strict=False) for joint in record.joints]
    same = records[0].parameters if all(r.parameters == records[0].parameters for r in records) else None
    unknown = dict.fromkeys(("seed", "start", "step", "tilt", "voltage", "slack"))
    return records[0].replace(**unknown | channels, parameters=same, joints=tuple(joints))
