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
    held, refused = {}, []
    with np.load(file, allow_pickle=False) as opened:
        for name in opened.files:
            try:
                held[name] = opened[name]
            except ValueError as error:
                refused.append(Found(name, 0, None, why=f"variable {name!r}: {' '.join(str(error).split())}"))
    found, said = arrays(held)
    return fitting(found + refused, most, size), spoken(said)


def rehearse():
    """Load what reading needs."""
    with io.BytesIO() as file:
        np.savez_compressed(file, force=np.ones(4), names=np.array(["a"]))
        contents(file, 1000)
