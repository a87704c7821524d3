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
    "Status": "results",
    "suspension_force": "model.wires",
    "cubic_law_error": "model.wires",
    "oscillator_modes": "model.oscillator",
    "static_equilibrium": "model.planar",
    "StaticEquilibrium": "model.planar",
    "linear_modes": "model.planar",
    "Modes": "model.modes",
    "Tap": "model.excitation",
    "frequency_response": "theory.amplitude",
    "FrequencyResponse": "theory.amplitude",
    "Piece": "theory.pieces",
    "folds": "theory.detached",
    "jump_frequencies": "theory.detached",
    "detached_curves": "theory.detached",
    "force_scenario": "theory.detached",
    "Fold": "theory.detached",
    "DetachedCurve": "theory.detached",
    "ForceEvent": "theory.detached",
    "periodic_orbits": "orbits.periodic_orbits",
    "continue_orbit": "orbits.periodic_orbits",
    "OrbitBranch": "orbits.periodic_orbits",
    "Disagreement": "orbits.periodic_orbits",
    "SpecialPoint": "orbits.stability",
    "harmonics_worth": "orbits.convergence",
    "HarmonicsWorth": "orbits.convergence",
    "orbits_figure": "present.figures.orbits",
    "shoot_orbit": "orbits.shooting",
    "ShotOrbit": "orbits.shooting",
    "existence_forces": "design.count",
    "existence_chart": "design.charts",
    "ExistenceChart": "design.charts",
    "margins": "design.margins",
    "Margins": "design.margins",
    "tolerance_study": "design.tolerances",
    "ToleranceStudy": "design.tolerances",
    "design_for_detached_curve": "design.best",
    "Design": "design.best",
    "attractors": "attraction.attractors",
    "Attractor": "attraction.attractors",
    "basins": "attraction.basins",
    "Basins": "attraction.basins",
    "tap_map": "attraction.taps",
    "TapMap": "attraction.taps",
    "smallest_tap": "attraction.taps",
    "SmallestTap": "attraction.taps",
    "subharmonic_motions": "orbits.subharmonics",
    "Subharmonics": "orbits.subharmonics",
    "SubharmonicFamily": "orbits.subharmonics",
    "integrity": "attraction.integrity",
    "Integrity": "attraction.integrity",
    "Record": "experiment.record",
    "simulate": "experiment.random_test",
    "random_test": "experiment.random_test",
    "sine_test": "experiment.sine_test",
    "SineTest": "experiment.sine_test",
    "identify": "identification.identify",
    "Identification": "identification.identify",
    "virtual_experiment": "paper.virtual_experiment",
    "overlay": "paper.virtual_experiment",
    "Overlay": "paper.virtual_experiment",
    "ledger": "paper.ledger",
    "Ledger": "paper.ledger",
    "response_slider": "present.moving.response_slider",
    "tap_slider": "present.moving.tap_slider",
    "force_scenario_figure": "present.figures.response",
    "response_surface_figure": "present.figures.surface",
    "rig_animation": "present.moving.rig",
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
