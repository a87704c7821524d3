"""A program that reads the variables of one netCDF 4 file; `netcdf.read` runs it, and says why in a process of its own.

The file is its standard input. Its arguments are the bytes that samples may take, the seconds that it may compute and
the names of the variables that are wanted. To standard output go a line when it is ready, then a line of JSON,
``{"details": text, "channels": [[name, samples, unit], ...]}`` or ``{"error": text}``, then the samples as float64.
Before data are read, everything that says where and how many they are is held against the file: what stands in other
files, was never written or is more than the file can hold is refused.
"""

import io
import json
import math
import os
import sys

import h5py
import numpy as np

_MOST = 64  # variables, or characters and numbers in an attribute that counts
_TEXT = 1 << 16  # bytes of an attribute
_BUILT_IN = {1: "deflate", 2: "shuffle", 3: "fletcher32", 32000: "lzf"}
_NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable"
_DEFAULT_FILL = 9.969209968386869e36  # what netCDF libraries put where nothing was written


def contents(file, most, names):
    """Details (text), and a list of (name, samples, unit) of the variables of an open file.

    Samples of all together take at most ``most`` bytes; only those of ``names`` are read, others have none.
    """
    size = file.seek(0, os.SEEK_END)
    with h5py.File(file, "r") as opened:
        root, found = opened["/"], []
        for name in _names(root):
            variable = _dataset(root, name)
            if not _text(variable, "NAME").startswith(_NO_VARIABLE):
                found.append((name, variable))
        details = _text(root, "rigsim_record")
        wanted = [(name, variable) for name, variable in found if name in names]
        declared = sum(8 * _count(name, variable, size, most) for name, variable in wanted)
        if declared > most:
            raise ValueError(f"it declares {declared} bytes of samples; expected at most {most} in {size} bytes")
        samples = {name: _samples(name, variable) for name, variable in wanted}
        return details, [(name, samples.get(name, np.empty(0)), _text(variable, "units")) for name, variable in found]


def _names(root):
    names = []
    root.id.links.iterate(lambda name: names.append(name) or (len(names) > _MOST or None))
    if len(names) > _MOST:
        raise ValueError(f"it holds more than {_MOST} variables")
    return [name.decode("utf-8", "backslashreplace") for name in names]


def _dataset(root, name):
    """The dataset of that name, if its samples stand in this file as they are or by filters that are built in."""
    key = name.encode()
    kind = root.id.links.get_info(key).type
    if kind != h5py.h5l.TYPE_HARD:
        kinds = {h5py.h5l.TYPE_SOFT: "a soft link", h5py.h5l.TYPE_EXTERNAL: "a link to another file"}
        raise ValueError(f"variable {name!r} is {kinds.get(kind, 'a user-defined link')}; expected its samples here")
    if h5py.h5o.get_info(root.id, key).type != h5py.h5o.TYPE_DATASET:
        raise ValueError(f"{name!r} is a group or a type; expected variables only")
    variable = h5py.Dataset(h5py.h5d.open(root.id, key))
    properties = variable.id.get_create_plist()
    if properties.get_layout() == h5py.h5d.VIRTUAL:
        raise ValueError(f"variable {name!r} is virtual: its samples are in other files; expected them here")
    if properties.get_external_count():
        raise ValueError(f"variable {name!r} is external: its samples are in other files; expected them here")
    for index in range(properties.get_nfilters()):
        code = properties.get_filter(index)[0]
        if code not in _BUILT_IN:
            expected = f"one of {', '.join(_BUILT_IN.values())}"
            raise ValueError(f"variable {name!r} needs the filter of number {code}; expected {expected}")
    return variable


def _count(name, variable, size, most):
    """Samples of a variable; all of them must be in the file."""
    kind, space, place = variable.id.get_type(), variable.id.get_space(), variable.id.get_create_plist()
    if kind.get_class() not in (h5py.h5t.INTEGER, h5py.h5t.FLOAT) or kind.get_size() > 8:
        raise ValueError(f"variable {name!r} holds no real numbers of at most 8 bytes; expected such")
    if space.get_simple_extent_type() != h5py.h5s.SIMPLE or space.get_simple_extent_ndims() != 1:
        raise ValueError(f"variable {name!r} has not one dimension; expected samples over time")
    (count,), width = space.get_simple_extent_dims(), kind.get_size()
    layout = place.get_layout()
    if layout == h5py.h5d.CONTIGUOUS:
        begin = variable.id.get_offset()
        there = begin is not None and begin + count * width <= size
    elif layout == h5py.h5d.CHUNKED:
        there = _chunks_there(variable.id, count, place.get_chunk()[0], size) and place.get_chunk()[0] * width <= most
    else:
        there = count * width <= _TEXT
    if not there and count:
        raise ValueError(f"variable {name!r} declares {count} samples, which are not in the file")
    return count


def _chunks_there(variable, count, length, size):
    """Whether every chunk stands in the file, at a place of its own."""
    number, found = -(-count // length), []
    if number > size:
        return False
    variable.chunk_iter(lambda chunk: found.append(chunk) or (len(found) > number or None))
    inside = all(chunk.byte_offset is not None and chunk.byte_offset + chunk.size <= size for chunk in found)
    unlike = len({chunk.chunk_offset for chunk in found}) == number == len({chunk.byte_offset for chunk in found})
    return inside and unlike and len(found) == number and sum(chunk.size for chunk in found) <= size


def _samples(name, variable):
    """Samples as float64, as the attributes say they are packed; NaN where they say that there is none."""
    raw = np.empty(variable.shape)
    variable.id.read(h5py.h5s.ALL, h5py.h5s.ALL, raw)
    if _numbers(variable, "_Unsigned") is not None:
        raise ValueError(f"variable {name!r} has the attribute _Unsigned; expected samples that are as they are stored")
    low, high = _numbers(variable, "valid_range", 2) or (-np.inf, np.inf)
    (low,), (high,) = _numbers(variable, "valid_min") or (low,), _numbers(variable, "valid_max") or (high,)
    missing = (raw < low) | (raw > high)
    for key in ("_FillValue", "missing_value"):
        for fill in _numbers(variable, key, _MOST) or ():
            missing |= raw == fill
    if not h5py.h5a.exists(variable.id, b"_FillValue"):
        missing |= raw == _DEFAULT_FILL
    (scale,), (offset,) = _numbers(variable, "scale_factor") or (1.0,), _numbers(variable, "add_offset") or (0.0,)
    with np.errstate(all="ignore"):
        raw = raw * scale + offset if (scale, offset) != (1.0, 0.0) else raw
    raw[missing] = np.nan
    return raw


def _numbers(thing, name, most=1):
    """Numbers of an attribute (a list of float), None where there is no such attribute."""
    if not h5py.h5a.exists(thing.id, name.encode()):
        return None
    attribute = h5py.h5a.open(thing.id, name.encode())
    integer_or_float = attribute.get_type().get_class() in (h5py.h5t.INTEGER, h5py.h5t.FLOAT)
    if (
        name == "_Unsigned"
        or not integer_or_float
        or not 1 <= attribute.get_space().get_simple_extent_npoints() <= most
    ):
        raise ValueError(f"attribute {name} holds something else than {'a number' if most == 1 else 'numbers'}")
    return np.atleast_1d(thing.attrs[name]).astype(float).ravel().tolist()


def _text(thing, name):
    """Text of an attribute, empty where there is no such attribute."""
    if not h5py.h5a.exists(thing.id, name.encode()):
        return ""
    attribute = h5py.h5a.open(thing.id, name.encode())
    one = attribute.get_space().get_simple_extent_npoints() == 1
    if attribute.get_type().get_class() != h5py.h5t.STRING or not one or attribute.get_storage_size() > _TEXT:
        raise ValueError(f"attribute {name} holds something else than a text")
    value = np.ravel(thing.attrs[name])[0]
    value = value.decode("utf-8", "backslashreplace") if isinstance(value, bytes) else str(value)
    if len(value) > _TEXT:
        raise ValueError(f"attribute {name} is longer than {_TEXT} characters")
    return value


class Whole(io.BufferedReader):
    """A file whose reads give every byte or fail: HDF5 takes what it asked for as given."""

    def readinto(self, buffer):
        """Fill the buffer."""
        got = super().readinto(buffer)
        if got != len(buffer):
            raise OSError("the file ends before what it holds")
        return got


def limit(most, seconds):
    """Take from this process what reading does not need, where the platform can."""
    try:
        import resource
    except ImportError:
        return
    free = os.dup(0)
    os.close(free)
    used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    limits = {"RLIMIT_NOFILE": free, "RLIMIT_CORE": 0, "RLIMIT_CPU": math.ceil(used + seconds)}
    try:
        with open("/proc/self/statm") as file:
            pages = int(file.read().split()[0])
        limits["RLIMIT_AS"] = pages * resource.getpagesize() + 64_000_000 + 4 * most
    except OSError:
        pass
    for name, value in limits.items():
        try:
            resource.setrlimit(getattr(resource, name), (value, value))
        except (OSError, ValueError):
            continue


def rehearse():
    """Read a file made here: h5py and NumPy load the rest of themselves when first used, which `limit` would forbid."""
    with io.BytesIO() as file:
        with h5py.File(file, "w") as made:
            made.attrs["rigsim_record"] = "{}"
            force = made.create_dataset("force", data=np.ones(4), chunks=(2,), compression="gzip")
            force.attrs["NAME"], force.attrs["_FillValue"] = np.bytes_("force"), np.nan
            force.attrs.create("units", "N", dtype=h5py.string_dtype("ascii"))
        contents(file, 32, ["force"])


def answer(file, out, most, names):
    """Write the header to ``out``, then the samples; whatever happens, a header."""
    try:
        details, channels = contents(file, most, names)
        header = {"details": details, "channels": [[name, samples.size, unit] for name, samples, unit in channels]}
    except BaseException as error:
        channels, header = [], {"error": " ".join(f"{error or type(error).__name__}".split())[:400]}
    out.write(json.dumps(header).encode() + b"\n")
    for _, samples, _ in channels:
        out.write(samples)


def main(most, seconds, *names):
    """Say when all is loaded, then answer, on standard output."""
    out = sys.stdout.buffer
    rehearse()
    out.write(b"ready\n")
    out.flush()
    limit(int(most), float(seconds))
    with Whole(io.FileIO(0, closefd=False)) as file:
        answer(file, out, int(most), names)
    out.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
