"""One subspace identification by a peer, of inputs and outputs in an NPZ file: its seconds and its frequencies."""

import json
import sys
import time
import warnings

import numpy as np


def main():
    """Print what `peers_identification` reads."""
    warnings.simplefilter("ignore")
    request = json.load(sys.stdin)
    channels = np.load(request["file"])
    inputs, outputs = channels["inputs"], channels["outputs"]
    if request["peer"] == "llsi":
        from llsi import SysIdData
        from llsi.subspace import PO_MOESP

        names = {
            f"{kind}{i}": column for kind, part in (("u", inputs), ("y", outputs)) for i, column in enumerate(part.T)
        }
        data = SysIdData(t=np.arange(len(inputs)) / request["rate"], **names)
        step = PO_MOESP(data, ["y0", "y1"], ["u0", "u1"])
        begun = time.perf_counter()
        A = step.ident(request["order"]).A
    else:
        from sippy_unipi import system_identification

        begun, rows = time.perf_counter(), request["rows"]
        A = system_identification(
            outputs.T, inputs.T, "N4SID", SS_f=rows, SS_p=rows, SS_fixed_order=4, SS_D_required=True
        ).A
    seconds = time.perf_counter() - begun
    poles = np.log(np.linalg.eigvals(A).astype(complex)) * request["rate"]
    print(json.dumps({"seconds": seconds, "frequency": sorted(np.abs(poles[poles.imag > 0]) / (2 * np.pi))}))


if __name__ == "__main__":
    main()
