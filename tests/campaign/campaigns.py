"""A campaign that other processes run, and one of a file: what tests kill, cancel, damage and share."""

import json
import sys
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from rigsim.campaign.run import run_chunks

COUNT, SIZE = 60, 200


def slow(chunk):
    """Numbers that depend on the chunk; who computes it leaves a line."""
    number, pause, log = chunk
    time.sleep(pause)
    if log:
        with open(log, "a") as file:
            file.write(f"{number}\n")
    return {"value": np.random.default_rng(number).normal(size=SIZE), "number": np.array([number])}


def chunks(pause=0.0, log=None, count=COUNT):
    """What the campaign is cut into."""
    return [(number, pause, log) for number in range(count)]


def right(results, count=COUNT):
    """Whether these are the campaign's results, to the last bit."""
    return len(results) == count and all(
        result["value"].tobytes() == np.random.default_rng(number).normal(size=SIZE).tobytes()
        and result["number"].tolist() == [number]
        for number, result in enumerate(results)
    )


def main(file, pause, log, count, pool):
    """Run it; one line says how it ended."""
    warnings.simplefilter("always")
    settings = {"checkpoint": file}
    parts = chunks(float(pause), log or None, int(count))
    if pool == "processes":
        with ProcessPoolExecutor(2) as settings["executor"]:
            results = run_chunks(slow, parts, **settings)
    else:
        results = run_chunks(slow, parts, **settings)
    print(json.dumps({"right": right(results, int(count))}), flush=True)


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[2]))
    main(*sys.argv[1:])
