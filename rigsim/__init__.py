"""rigsim: a virtual experiment on a coupled linear and nonlinear oscillator with detached resonance curves.

Everything public is importable from here and loaded when it is first asked for, so that
``import rigsim`` needs the standard library only and ``python3 -m rigsim`` runs on a fresh clone. What is not allowed
raises a `ValueError` that names the quantity, its value and what is expected.
"""

from importlib import import_module

__version__ = "0.1.0"

# Where each public name lives; "room:name" says that it is a module itself.
_HOME = {
    "OscillatorParameters": "parameters",
    "RigParameters": "parameters",
    "Status": "results",
    "cubic_law_error": "model.wires",
    "oscillator_modes": "model.oscillator",
    "static_equilibrium": "model.planar",
    "linear_modes": "model.planar",
    "Tap": "model.excitation",
    "ShakerDrive": "model.shaker",
    "frequency_response": "theory.amplitude",
    "FrequencyResponse": "theory.amplitude",
    "folds": "theory.detached",
    "Fold": "theory.detached",
    "jump_frequencies": "theory.detached",
    "detached_curves": "theory.detached",
    "DetachedCurve": "theory.detached",
    "force_scenario": "orbits.scenario",
    "ForceEvent": "theory.detached",
    "existence_chart": "design.charts",
    "margins": "design.margins",
    "tolerance_study": "design.tolerances",
    "design_for_detached_curve": "design.best",
    "wobbling_map": "design.wobbling",
    "periodic_orbits": "orbits.periodic_orbits",
    "response_sheet": "orbits.response_sheet",
    "continue_orbit": "orbits.periodic_orbits",
    "OrbitBranch": "orbits.branches",
    "SpecialPoint": "orbits.stability",
    "harmonics_worth": "orbits.convergence",
    "subharmonic_motions": "orbits.subharmonics",
    "attractors": "attraction.attractors",
    "basins": "attraction.basins",
    "tap_map": "attraction.taps",
    "smallest_tap": "attraction.taps",
    "integrity": "attraction.integrity",
    "Record": "experiment.record",
    "simulate": "experiment.random_test",
    "random_test": "experiment.random_test",
    "sine_test": "experiment.sine_test",
    "SineTest": "experiment.sine_test",
    "stepped_test": "experiment.protocols.stepped",
    "ramp_test": "experiment.protocols.stepped",
    "tapped_test": "experiment.protocols.stepped",
    "swept_test": "experiment.protocols.swept",
    "Sensors": "experiment.protocols.sensors",
    "feedback_test": "experiment.feedback.feedback_test",
    "phase_locked_test": "experiment.feedback.locked",
    "identify": "identification.identify",
    "Identification": "identification.result",
    "virtual_experiment": "paper.virtual_experiment",
    "overlay": "paper.virtual_experiment",
    "compare_tests": "paper.comparison",
    "compare_drives": "paper.drives",
    "Evidence": "paper.evidence",
    "ledger": "paper.ledger",
    "printed": "paper.printed",
    "response_slider": "present.moving.response_slider",
    "tap_slider": "present.moving.tap_slider",
    "rig_animation": "present.moving.rig",
    "explore": "present:explore",
}

__all__ = sorted(_HOME)


def __getattr__(name):
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home, _, room = _HOME[name].partition(":")
    module = import_module(f".{home}.{room}" if room else f".{home}", __name__)
    value = module if room else getattr(module, name)
    globals()[name] = value  # found once, then an ordinary attribute
    return value


def __dir__():
    return sorted({*globals(), *__all__})
