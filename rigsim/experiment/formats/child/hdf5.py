"""HDF5, and with it netCDF 4 and MAT 7.3, by h5py.

Before data are read, everything that says where and how many they are is held against the file: what stands in other
files, was never written or is more than the file can hold is refused.
"""

import io
import math

import h5py
import numpy as np

from .found import Found, columns, fitting, spoken

_MOST = 512  # things in a file
_DEEP = 5  # groups in groups
_FEW = 64  # characters and numbers in an attribute that counts
_TEXT = 1 << 16  # bytes of an attribute
_BUILT_IN = {1: "deflate", 2: "shuffle", 3: "fletcher32", 32000: "lzf"}
_NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable"
_DEFAULT_FILL = 9.969209968386869e36  # what netCDF libraries put where nothing was written
_UNITS = ("units", "unit", "Units", "Unit")


def contents(file, most):
    """Columns of an open file, those in groups by their paths, and what it says beside them."""
    size = file.seek(0, io.SEEK_END)
    opened = h5py.File(file, "r")  # open as long as its samples may be taken
    found, said = [], {}
    for name, group, key in _names(opened["/"], "", set()):
        try:
            variable = _dataset(group, key, name)
            if not _text(variable, "NAME").startswith(_NO_VARIABLE):
                found += _columns(name, variable, size, most, said)
        except ValueError as error:
            found.append(Found(name, 0, None, why=str(error)))
    own = _text(opened["/"], "rigsim_record")
    if own:
        return fitting(found, most, size), {"rigsim_record": own}
    for thing in (opened["/"], *(opened[one.name] for one in found[:3] if not one.why and one.name in opened)):
        for key in list(thing.attrs)[:_MOST]:
            value = _spoken(thing, key)
            if value is not None:
                said.setdefault(key, value)
    return fitting(found, most, size), spoken(said)


def _names(group, before, seen):
    """Path, group and key of everything that is no group, from the file's root."""
    names = []
    group.id.links.iterate(lambda name: names.append(name) or (len(names) > _MOST or None))
    for key in names:
        path = before + key.decode("utf-8", "backslashreplace")
        inner = None
        if group.id.links.get_info(key).type == h5py.h5l.TYPE_HARD:
            info = h5py.h5o.get_info(group.id, key)
            if info.type == h5py.h5o.TYPE_GROUP:
                inner = info.addr
        if inner is None:
            seen.add(path)
            yield path, group, key
        elif inner not in seen and before.count("/") < _DEEP and not path.startswith("#"):
            seen.add(inner)
            yield from _names(h5py.Group(h5py.h5o.open(group.id, key)), f"{path}/", seen)
        if len(seen) > _MOST:
            raise ValueError(f"it holds more than {_MOST} variables")


def _dataset(group, key, name):
    """The dataset of that name, if its samples stand in this file as they are or by filters that are built in."""
    kind = group.id.links.get_info(key).type
    if kind != h5py.h5l.TYPE_HARD:
        kinds = {h5py.h5l.TYPE_SOFT: "a soft link", h5py.h5l.TYPE_EXTERNAL: "a link to another file"}
        raise ValueError(f"variable {name!r} is {kinds.get(kind, 'a user-defined link')}; expected its samples here")
    if h5py.h5o.get_info(group.id, key).type != h5py.h5o.TYPE_DATASET:
        raise ValueError(f"{name!r} is a group or a type; expected variables only")
    variable = h5py.Dataset(h5py.h5d.open(group.id, key))
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


def _columns(name, variable, size, most, said):
    """`Found` of a variable; a single number or a text is said instead."""
    if variable.shape is not None and variable.size == 1 and (value := _spoken_value(variable)) is not None:
        said[name] = value
        return []
    if variable.dtype == np.uint16 and _text(variable, "MATLAB_class") == "char" and variable.size <= _FEW:
        said[name] = "".join(map(chr, variable[...].T.ravel()))
        return []
    shape = _shape(name, variable, size, most)
    unit = next((text for key in _UNITS if (text := _text(variable, key))), "")
    if len(shape) == 1 or sorted(shape)[0] == 1:
        return [Found(name, math.prod(shape), lambda: _samples(name, variable), unit)]
    plain = columns(name, np.broadcast_to(0.0, shape))
    for index, one in enumerate(plain):
        one.unit, one.take = unit, lambda index=index: columns(name, _samples(name, variable, shape))[index].take()
    return plain


def _shape(name, variable, size, most):
    """Shape of a variable; all its samples must be in the file."""
    kind, space, place = variable.id.get_type(), variable.id.get_space(), variable.id.get_create_plist()
    if kind.get_class() not in (h5py.h5t.INTEGER, h5py.h5t.FLOAT) or kind.get_size() > 8:
        raise ValueError(f"variable {name!r} holds no real numbers of at most 8 bytes; expected such")
    if space.get_simple_extent_type() != h5py.h5s.SIMPLE or space.get_simple_extent_ndims() not in (1, 2):
        raise ValueError(f"variable {name!r} has not one dimension or two; expected samples over time")
    shape, width = space.get_simple_extent_dims(), kind.get_size()
    count, layout = math.prod(shape), place.get_layout()
    if layout == h5py.h5d.CONTIGUOUS:
        begin = variable.id.get_offset()
        there = begin is not None and begin + count * width <= size
    elif layout == h5py.h5d.CHUNKED:
        chunk = place.get_chunk()
        there = _chunks_there(variable.id, shape, chunk, size) and math.prod(chunk) * width <= most
    else:
        there = count * width <= _TEXT
    if not there and count:
        raise ValueError(f"variable {name!r} declares {count} samples, which are not in the file")
    return shape


def _chunks_there(variable, shape, chunk, size):
    """Whether every chunk stands in the file, at a place of its own."""
    number, found = math.prod(-(-count // length) for count, length in zip(shape, chunk, strict=True)), []
    if number > size:
        return False
    variable.chunk_iter(lambda chunk: found.append(chunk) or (len(found) > number or None))
    inside = all(chunk.byte_offset is not None and chunk.byte_offset + chunk.size <= size for chunk in found)
    unlike = len({chunk.chunk_offset for chunk in found}) == number == len({chunk.byte_offset for chunk in found})
    return inside and unlike and len(found) == number and sum(chunk.size for chunk in found) <= size


def _samples(name, variable, shape=-1):
    """Samples as float64, in a row or of a ``shape``, unpacked as attributes say; NaN where they say there is none."""
    raw = np.empty(variable.shape)
    variable.id.read(h5py.h5s.ALL, h5py.h5s.ALL, raw)
    if _numbers(variable, "_Unsigned") is not None:
        raise ValueError(f"variable {name!r} has the attribute _Unsigned; expected samples that are as they are stored")
    low, high = _numbers(variable, "valid_range", 2) or (-np.inf, np.inf)
    (low,), (high,) = _numbers(variable, "valid_min") or (low,), _numbers(variable, "valid_max") or (high,)
    missing = (raw < low) | (raw > high)
    for key in ("_FillValue", "missing_value"):
        for fill in _numbers(variable, key, _FEW) or ():
            missing |= raw == fill
    if not h5py.h5a.exists(variable.id, b"_FillValue"):
        missing |= raw == _DEFAULT_FILL
    (scale,), (offset,) = _numbers(variable, "scale_factor") or (1.0,), _numbers(variable, "add_offset") or (0.0,)
    with np.errstate(all="ignore"):
        raw = raw * scale + offset if (scale, offset) != (1.0, 0.0) else raw
    raw[missing] = np.nan
    return raw.reshape(shape)


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


def _spoken(thing, name):
    """A number or a text of an attribute, None where it holds something else."""
    for read in (_numbers, _text):
        try:
            value = read(thing, name)
        except (ValueError, TypeError, OSError, KeyError):
            continue
        return value[0] if isinstance(value, list) else value
    return None


def _spoken_value(variable):
    """The number or the text that a variable of one value is, None where it is neither."""
    kind = variable.id.get_type().get_class()
    if kind not in (h5py.h5t.INTEGER, h5py.h5t.FLOAT, h5py.h5t.STRING) or variable.id.get_storage_size() > _TEXT:
        return None
    value = np.ravel(variable[()])[0]
    if isinstance(value, bytes):
        return value.decode("utf-8", "backslashreplace")[:_TEXT]
    return value[:_TEXT] if isinstance(value, str) else float(value)


def rehearse():
    """Load what reading needs."""
    with io.BytesIO() as file:
        with h5py.File(file, "w") as made:
            made.attrs["rigsim_record"] = "{}"
            force = made.create_dataset("force", data=np.ones(4), chunks=(2,), compression="gzip")
            force.attrs["NAME"], force.attrs["_FillValue"] = np.bytes_("force"), np.nan
            force.attrs.create("units", "N", dtype=h5py.string_dtype("ascii"))
            made["run/fs"], made["run/pairs"], made["run/name"] = 5.0, np.ones((4, 2)), "a"
        for one in contents(file, 1000)[0]:
            one.take()
