"""What the scripts of this folder share: the rig comes on standard input, a timed curve leaves on standard output.

They run in an environment of their own, which has the peers and neither rigsim nor its versions of anything.
"""

import contextlib
import io
import json
import sys
import time


def report(curve, repeats=2):
    """Print, as JSON, the least seconds of several calls of ``curve(rig)`` and its points, (Hz, m) each."""
    rig = json.load(sys.stdin)
    seconds = []
    for _ in range(repeats + 1):  # the first one warms up
        begun = time.perf_counter()
        with contextlib.redirect_stdout(io.StringIO()):
            points = curve(rig)
        seconds.append(time.perf_counter() - begun)
    json.dump({"seconds": min(seconds[1:]), "points": [[float(f), float(z)] for f, z in points]}, sys.stdout)
