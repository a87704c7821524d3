"""Results of tests as files: every number with its unit, and all that made them."""

import json

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from rigsim import RigParameters, Tap, feedback_test, phase_locked_test, sine_test, stepped_test

RIG = RigParameters()


@pytest.fixture(scope="module")
def made():
    return {
        "sine": sine_test([RIG, RIG.single_set()], 3.18, [20.0, 30.0], [None, Tap(time=0.1)], duration=1.0),
        "bench": stepped_test(RIG, 3.18, [20.0, 21.0], dwell=1.0),
        "held": feedback_test(RIG, 3.18, [36.0], design=RIG.oscillator, points=4),
        "locked": phase_locked_test(RIG, [0.05], design=RIG.oscillator),
    }


KINDS = pytest.mark.parametrize("kind", ["sine", "bench", "held", "locked"])


@KINDS
def test_netcdf_has_every_number_with_its_unit(made, kind, tmp_path):
    result = made[kind]
    result.save(tmp_path / "result.nc")
    with xr.open_dataset(tmp_path / "result.nc") as found:
        details = json.loads(found.attrs["rigsim"])
        for name, values in result.points().items():
            values = np.array([str(one) for one in values]) if name in ("status", "message") else np.stack(values)
            if np.iscomplexobj(values):
                np.testing.assert_array_equal(found[f"{name}_real"] + 1j * found[f"{name}_imaginary"], values)
                assert found[f"{name}_real"].attrs["units"]
            else:
                np.testing.assert_array_equal(found[name], values)
        assert found["frequency"].attrs["units"] == "Hz"
    assert details["kind"] == type(result).__name__
    assert {"rigsim", "pymunk", "numpy"} <= set(details["versions"])
    rig = details["settings"]["parameters"]
    assert RigParameters(**(rig[0] if isinstance(rig, list) else rig)) == RIG


@KINDS
def test_csv_is_read_by_anybody(made, kind, tmp_path):
    result = made[kind]
    result.save(tmp_path / "result.csv")
    table = pd.read_csv(tmp_path / "result.csv", comment="#")
    np.testing.assert_array_equal(table["frequency [Hz]"], np.array(result.points()["frequency"]))
    assert len(table) == len(result.points()["frequency"])
    assert not [name for name in table if name.startswith("trace")]
    first = (tmp_path / "result.csv").read_text().splitlines()[0]
    assert json.loads(first.removeprefix("#"))["kind"] == type(result).__name__


def test_another_suffix_is_refused_and_what_was_there_stays(made, tmp_path):
    (tmp_path / "result.txt").write_text("mine")
    with pytest.raises(ValueError, match=r"result.txt = '.txt' is not allowed; expected one of '.nc', '.csv'"):
        made["bench"].save(tmp_path / "result.txt")
    assert (tmp_path / "result.txt").read_text() == "mine"


def test_every_bench_keeps_its_rig(tmp_path):
    other = RIG.replace(m=0.006)
    stepped_test([RIG, other, RIG], 3.18, [20.0], dwell=1.0).save(tmp_path / "result.csv")
    details = json.loads((tmp_path / "result.csv").read_text().splitlines()[0].removeprefix("#"))
    assert [RigParameters(**rig) for rig in details["settings"]["parameters"]] == [RIG, other, RIG]
