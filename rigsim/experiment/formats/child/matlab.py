"""MAT files up to version 7, by SciPy; those of 7.3 are HDF5."""

import io
import warnings

import numpy as np
from scipy.io import loadmat, savemat

from .found import arrays, fitting, spoken


def contents(file, most):
    """Columns of a MAT file, those of its structures by their paths, and what its single numbers and texts say."""
    size = file.seek(0, 2)
    file.seek(0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        held = loadmat(file, simplify_cells=True, verify_compressed_data_integrity=True)
    found, said = arrays({name: value for name, value in held.items() if not name.startswith("__")})
    return fitting(found, most, size), spoken(said)


def rehearse():
    """Load what reading needs."""
    with io.BytesIO() as file:
        savemat(file, {"run": {"force": np.ones(4), "fs": 5.0, "name": "a"}}, do_compression=True)
        contents(file, 1000)
