"""Arrays that NumPy saved; what is pickled is refused."""

import io
import zipfile

import numpy as np

from .found import Found, arrays, fitting, spoken


def contents(file, most):
    """Columns of an ``.npz``, and what its single numbers and texts say."""
    size = file.seek(0, 2)
    file.seek(0)
    with zipfile.ZipFile(file) as archive:
        items = archive.infolist()
    if sum(item.file_size for item in items) > most + (1 << 16) or len(items) > 512:
        raise ValueError(f"it declares more than {most} bytes of samples or 512 arrays in {size} bytes")
    file.seek(0)
    held, others = {}, []
    opened = np.load(file, allow_pickle=False)  # open as long as its samples may be taken
    for name in opened.files:
        try:
            shape, kind = _header(opened, name)
            if len(shape) == 1 and shape[0] > 1 and kind in "iuf":
                others.append(Found(name, shape[0], lambda name=name: opened[name]))
            else:
                held[name] = opened[name]
        except (ValueError, KeyError) as error:
            others.append(Found(name, 0, None, why=f"variable {name!r}: {' '.join(str(error).split())}"))
    found, said = arrays(held)
    return fitting(found + others, most, size), spoken(said)


def _header(opened, name):
    """Shape of an array and the kind of its numbers, before it is read."""
    with opened.zip.open(f"{name}.npy") as file:
        version = np.lib.format.read_magic(file)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, _, dtype = read(file)
    return shape, dtype.kind


def rehearse():
    """Load what reading needs."""
    with io.BytesIO() as file:
        np.savez_compressed(file, force=np.ones(4), names=np.array(["a"]))
        contents(file, 1000)
