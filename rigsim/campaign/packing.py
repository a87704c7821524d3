"""Arrays of a finished chunk as bytes, and back: bit for bit, without pickles, and nothing believed that is not so."""

import hashlib
import json
import math

import numpy as np

MARK = "rigsim:52494753"  # stands in every row, so that a checkpoint is known as ours however damaged
_KINDS = "?biufcSUmM"


class Damaged(ValueError):
    """Bytes that are not what was written."""


def pack(arrays):
    """Form (text) and content (bytes) of a dict of arrays; `ValueError` if one holds Python objects or records."""
    for name, array in arrays.items():
        if array.dtype.kind not in _KINDS:
            raise ValueError(f"{name} has the type {array.dtype}; Objects and records cannot be kept, expected numbers")
    form = json.dumps({MARK: [[name, array.dtype.str, array.shape] for name, array in arrays.items()]})
    return form, b"".join(array.tobytes() for array in arrays.values())


def unpack(form, content):
    """The dict of arrays; `Damaged` if they are not exactly what the content holds."""
    arrays, at = {}, 0
    try:
        for name, kind, shape in json.loads(form)[MARK]:
            dtype = np.dtype(kind)
            size = math.prod(shape) * dtype.itemsize
            if dtype.kind not in _KINDS or not 0 <= size <= len(content) - at or min(shape, default=0) < 0:
                raise Damaged(f"{name} is not what it says")
            arrays[name] = np.frombuffer(content[at : at + size], dtype).reshape(shape).copy()
            at += size
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise Damaged(str(error)) from None
    if at != len(content):
        raise Damaged("something follows the arrays")
    return arrays


def digest(*parts):
    """SHA-256 (hexadecimal) of texts, numbers and bytes, one after the other and each told apart."""
    whole = hashlib.sha256()
    for part in parts:
        data = part if isinstance(part, bytes) else str(part).encode()
        whole.update(b"%d:" % len(data) + data)
    return whole.hexdigest()
