"""The record of the hostile files in the forms of other programs, made with the packages that read them."""

import gzip
import io

import h5py
import numpy as np
import scipy.io

SAMPLES = 150
RATE = 2000.0


def channels(samples=SAMPLES):
    """Force (N), shaker and mass (m)."""
    force, shaker, mass = np.random.default_rng(5).normal(size=(3, samples))
    return {"force": force, "shaker": 1e-4 * shaker, "mass": 1e-4 * mass}


def rows(separator=",", decimal=".", columns=None, end="\n", form="%.9g"):
    """Lines of text."""
    columns = list(channels().values()) if columns is None else columns
    cells = lambda row: separator.join((form % value).replace(".", decimal) for value in row)  # noqa: E731
    return "".join(cells(row) + end for row in zip(*columns, strict=True))


def tables(path):
    """As LabVIEW, a German spreadsheet, an oscilloscope and NumPy write text."""
    time = np.arange(SAMPLES) / RATE
    timed = [time, *channels().values()]
    lvm = (
        "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n"
        "***End_of_Header***\t\n\t\nChannels\t3\t\t\t\nSamples\t150\t150\t150\t\nY_Unit_Label\tN\tm\tm\t\n"
        "Delta_X\t0.0005\t0.0005\t0.0005\t\n***End_of_Header***\t\t\t\t\nX_Value\tforce\tshaker\tmass\tComment\n"
    )
    german = "Zeit [s];Kraft [N];Shaker [mm];Mass [mm]\n"
    scope = "Model,MSO54\nSample Interval,0.0005,s\nRecord Length,150\n\nTIME,force,shaker,mass\ns,N,m,m\n"
    forms = [
        lvm + rows("\t", columns=timed, end="\t\n"),
        german + rows(";", ",", columns=[time, timed[1], 1e3 * timed[2], 1e3 * timed[3]]),
        scope + rows(columns=timed),
        "# time force shaker mass\n" + rows(" ", columns=timed, form="%.18e"),
    ]
    return [*map(str.encode, forms), forms[1].encode("utf-16")]


def zipped(path):
    """The same, compressed."""
    return [gzip.compress(form, mtime=0) for form in tables(path)]


def hdf5(path):
    """Datasets in a group, rows of a matrix, numbers beside them."""
    forms = []
    for options in ({}, {"chunks": (40,), "compression": "gzip", "shuffle": True}):
        with h5py.File(path, "w") as file:
            file.attrs["fs"] = RATE
            for name, values in channels().items():
                made = file.create_dataset(f"run/{name}", data=values, **options)
                made.attrs["units"] = "N" if name == "force" else "m"
        forms.append(path.read_bytes())
    return forms


def matlab(path):
    """Versions 4 to 7.3: variables and a structure."""
    forms = []
    for options in ({"format": "4"}, {}, {"do_compression": True}):
        held = channels() | {"fs": RATE}
        for one in (held, {"run": held})[: 1 if "format" in options else 2]:
            with io.BytesIO() as file:
                scipy.io.savemat(file, one, **options)
                forms.append(file.getvalue())
    return [*forms, matlab_7_3()]


def matlab_7_3():
    """As MATLAB lays it out: a block of text before HDF5, arrays of two dimensions."""
    with io.BytesIO() as file:
        with h5py.File(file, "w", userblock_size=512) as made:
            for name, values in (channels() | {"fs": RATE}).items():
                made.create_dataset(name, data=np.atleast_2d(values)).attrs["MATLAB_class"] = np.bytes_("double")
        content = file.getvalue()
    text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Mar 02 10:00:00 2026 HDF5 schema 1.00 ."
    return text.ljust(512) + content[512:]


def npz(path):
    """Arrays and a number, packed or not."""
    forms = []
    for save in (np.savez, np.savez_compressed):
        with io.BytesIO() as file:
            save(file, fs=RATE, **channels())
            forms.append(file.getvalue())
    return forms


def uff(path):
    """Data sets 58 and 58b."""
    import pyuff

    forms = []
    for binary in (0, 1):
        path.unlink(missing_ok=True)
        made = pyuff.UFF(str(path))
        for name, values in channels().items():
            made.write_sets(uff_set(name, values, binary), "add")
        forms.append(path.read_bytes())
    return forms


def uff_set(name, values, binary=0, unit=None, **changes):
    """A data set of pyuff's: a function of time."""
    unit = unit or ("N" if name == "force" else "m")
    return {
        "type": 58, "binary": binary, "id1": name, "func_type": 1, "rsp_node": 1, "rsp_dir": 3, "ref_node": 1,
        "ref_dir": 3, "data": values, "x": np.arange(values.size) / RATE, "abscissa_inc": 1 / RATE,
        "abscissa_spacing": 1, "ordinate_axis_units_lab": unit, "rsp_ent_name": "NONE", "ref_ent_name": "NONE",
        "abscissa_spec_data_type": 17, "ordinate_spec_data_type": 8, "orddenom_spec_data_type": 0,
    } | changes  # fmt: skip


def tdms(path):
    """Waveforms in a group, in one segment and in two."""
    from nptdms import ChannelObject, TdmsWriter

    forms = []
    for parts in (1, 2):
        with io.BytesIO() as file:
            with TdmsWriter(file) as writer:
                for part in range(parts):
                    writer.write_segment([tdms_channel(ChannelObject, name, np.array_split(values, parts)[part])
                                          for name, values in channels().items()])  # fmt: skip
            forms.append(file.getvalue())
    return forms


def tdms_channel(kind, name, values, unit=None, rate=RATE):
    """A channel of npTDMS's."""
    unit = unit or ("N" if name == "force" else "m")
    return kind("run", name, values, properties={"wf_increment": 1 / rate, "unit_string": unit})


MADE = {"table": tables, "zipped": zipped, "hdf5": hdf5, "matlab": matlab, "npz": npz, "uff": uff, "tdms": tdms}
NEEDS = dict.fromkeys(MADE, "") | {"uff": "pyuff", "tdms": "nptdms"}
