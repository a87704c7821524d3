"""Has everything compiled that the notebooks use, by a small call of each kind: the last step of making ``.venv``."""

import rigsim


def calls():
    """What to call, by what a user would call it."""
    rig = rigsim.RigParameters()
    force, frequency = 3.18, 30.0
    return {
        "single-term responses": lambda: rigsim.frequency_response(rig, force, [frequency]).stable,
        "existence charts": lambda: rigsim.existence_chart(rig, force, "c", "cs", points=(3, 3)),
        "periodic orbits": lambda: [branch.special_points for branch in rigsim.periodic_orbits(rig, 16.0, (48, 58))],
        "basins": lambda: rigsim.basins(rig, force, frequency),
        "sine tests": lambda: rigsim.sine_test(rig, force, frequency, rigsim.Tap(time=0.1), 1).out_of_plane(),
        "linear modes": lambda: rigsim.linear_modes(rig),
        "identification": lambda: rigsim.identify(rigsim.random_test(rig, duration=5)).plot("detached curves"),
    }


if __name__ == "__main__":
    for name, call in calls().items():
        print(f"compiling for {name}", flush=True)
        call()
