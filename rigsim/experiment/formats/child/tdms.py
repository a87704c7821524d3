"""LabVIEW's TDMS, by npTDMS."""

import io

import numpy as np
from nptdms import ChannelObject, TdmsFile, TdmsWriter

from .found import Found, fitting

_UNITS = ("unit_string", "NI_UnitDescription", "unit", "units", "Unit")


def contents(file, most):
    """Channels of a TDMS file by name, with their group's where it is needed to tell them apart."""
    size = file.seek(0, 2)
    file.seek(0)
    opened = TdmsFile.open(file)
    channels = [channel for group in opened.groups() for channel in group.channels()]
    names = [channel.name for channel in channels]
    found = []
    for channel in channels:
        name = channel.name if names.count(channel.name) == 1 else f"{channel.group_name}/{channel.name}"
        unit = next((str(channel.properties[key]) for key in _UNITS if key in channel.properties), "")
        step = channel.properties.get("wf_increment")
        interval = float(step) if step is not None and float(step) > 0 else None
        kind = np.dtype(channel.dtype).kind if channel.dtype is not None else "O"
        if kind not in "iufM":
            why = f"channel {name!r} holds no real numbers; expected such"
            found.append(Found(name, 0, None, why=why))
        else:
            found.append(Found(name, len(channel), lambda channel=channel: _numbers(channel), unit, interval))
    cut = opened.file_status.incomplete_final_segment
    return fitting(found, most, size), {"notes": ["a file whose end was never written"]} if cut else {}


def _numbers(channel):
    values = np.asarray(channel[:])
    if values.dtype.kind == "M":
        return (values - values[:1]) / np.timedelta64(1, "s")
    return values


def rehearse():
    """Load what reading needs."""
    with io.BytesIO() as file:
        with TdmsWriter(file) as writer:
            writer.write_segment([ChannelObject("a", "force", np.ones(4), properties={"wf_increment": 0.1})])
            writer.write_segment([ChannelObject("a", "force", np.ones(4))])
        for one in contents(io.BytesIO(file.getvalue()), 1000)[0]:
            one.take()
