"""rigsim: a virtual experiment on a coupled linear and nonlinear oscillator with detached resonance curves.

Everything public is importable from here and loaded when it is first asked for, so that
``import rigsim`` needs the standard library only and ``python3 -m rigsim`` runs on a fresh clone.
"""

from importlib import import_module

__version__ = "0.1.0"

# Where each public name lives.
_HOME = {
    "OscillatorParameters": "parameters",
    "RigParameters": "parameters",
    "Nondimensional": "parameters",
    "suspension_force": "model.wires",
    "cubic_law_error": "model.wires",
    "oscillator_modes": "model.oscillator",
    "static_equilibrium": "model.planar",
    "StaticEquilibrium": "model.planar",
    "linear_modes": "model.planar",
    "Modes": "model.modes",
    "Tap": "model.excitation",
    "frequency_response": "response.amplitude",
    "FrequencyResponse": "response.amplitude",
    "Piece": "response.pieces",
    "folds": "response.detached",
    "jump_frequencies": "response.detached",
    "detached_curves": "response.detached",
    "force_scenario": "response.detached",
    "Fold": "response.detached",
    "DetachedCurve": "response.detached",
    "ForceEvent": "response.detached",
    "periodic_orbits": "response.orbits",
    "continue_orbit": "response.orbits",
    "OrbitBranch": "response.orbits",
    "Disagreement": "response.orbits",
    "SpecialPoint": "response.stability",
    "harmonics_worth": "response.harmonics",
    "HarmonicsWorth": "response.harmonics",
    "orbits_figure": "present.figures.orbits",
    "shoot_orbit": "response.shooting",
    "ShotOrbit": "response.shooting",
    "classify": "response.classify",
    "existence_forces": "response.classify",
    "existence_chart": "response.charts",
    "ExistenceChart": "response.charts",
    "margins": "response.margins",
    "Margins": "response.margins",
    "tolerance_study": "response.tolerances",
    "ToleranceStudy": "response.tolerances",
    "design_for_detached_curve": "response.design",
    "Design": "response.design",
    "attractors": "response.attractors",
    "Attractor": "response.attractors",
    "basins": "response.basins",
    "Basins": "response.basins",
    "tap_map": "response.taps",
    "TapMap": "response.taps",
    "smallest_tap": "response.taps",
    "SmallestTap": "response.taps",
    "subharmonic_motions": "response.subharmonics",
    "Subharmonics": "response.subharmonics",
    "SubharmonicFamily": "response.subharmonics",
    "integrity": "response.integrity",
    "Integrity": "response.integrity",
    "Record": "experiment.record",
    "simulate": "experiment.random_test",
    "random_test": "experiment.random_test",
    "sine_test": "experiment.sine_test",
    "SineTest": "experiment.sine_test",
    "identify": "identification.identify",
    "Identification": "identification.identify",
    "virtual_experiment": "present.overlay",
    "overlay": "present.overlay",
    "Overlay": "present.overlay",
    "ledger": "present.ledger",
    "Ledger": "present.ledger",
    "response_slider": "present.response_slider",
    "tap_slider": "present.tap_slider",
    "force_scenario_figure": "present.figures.response",
    "response_surface_figure": "present.figures.surface",
    "rig_figure": "present.figures.rig",
    "rigs_figure": "present.figures.rig",
    "wire_law_figure": "present.figures.rig",
    "statics_figure": "present.figures.rig",
    "rig_animation": "present.animate",
    "rigs_animation": "present.animate",
}

__all__ = sorted(_HOME)


def __getattr__(name):
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOME[name]}", __name__), name)
    globals()[name] = value  # found once, then an ordinary attribute
    return value


def __dir__():
    return sorted({*globals(), *__all__})
