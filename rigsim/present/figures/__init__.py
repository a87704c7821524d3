"""Figures, a file for each domain; the names here are those that results forward `.plot()` to.

Each takes a result and ``ax``, axes of a user's own (one for each panel, row by row) that are drawn into instead of a
new figure, and returns the `matplotlib.figure.Figure`.
"""

from .basins import attractors_figure, basins_figure, integrity_figure, tap_map_figure
from .design import design_figure, existence_chart_figure, margins_figure, tolerance_study_figure
from .errors import parameter_figure
from .feedback import (
    held_motion_figure,
    invasiveness_figure,
    measured_response_figure,
    measured_sheet_figure,
    phase_locked_figure,
    s_curves_figure,
)
from .identification import (
    identification_figure,
    nonlinear_coefficient_figure,
    receptance_figure,
    singular_value_figure,
)
from .modes import modes_figure
from .orbits import harmonics_figure, orbits_figure
from .order import stabilisation_figure
from .out_of_plane import growth_figure
from .overlay import branches_figure
from .probability import curve_probability_figure, detached_probability_figure
from .protocols import bench_test_figure, comparison_figure, waits_figure
from .readings import readings_figure
from .record import record_figure
from .residuals import prediction_figure, residual_figure
from .response import detached_curves_figure, force_scenario_figure, frequency_response_figure
from .rig import debug_figure, rig_figure
from .shaker import shaker_figure, shaker_waveform_figure
from .sheet import event_curves_figure, sheet_amplitude_figure, sheet_figure
from .sine_test import distortion_figure, out_of_plane_figure, sine_test_figure
from .spectrum import spectrum_figure
from .statics import statics_figure
from .subharmonics import subharmonics_figure
from .surface import response_surface_figure
from .wire_law import wire_law_figure
from .wobbling import wobbling_figure

__all__ = [
    "attractors_figure", "basins_figure", "bench_test_figure", "branches_figure", "comparison_figure",
    "curve_probability_figure", "debug_figure", "design_figure", "detached_curves_figure",
    "detached_probability_figure", "distortion_figure", "event_curves_figure", "existence_chart_figure",
    "force_scenario_figure", "frequency_response_figure", "growth_figure", "harmonics_figure", "held_motion_figure",
    "identification_figure", "integrity_figure", "invasiveness_figure", "margins_figure", "measured_response_figure",
    "measured_sheet_figure", "modes_figure", "nonlinear_coefficient_figure", "orbits_figure", "out_of_plane_figure",
    "parameter_figure", "phase_locked_figure", "prediction_figure", "readings_figure", "receptance_figure",
    "record_figure", "residual_figure", "response_surface_figure", "rig_figure", "s_curves_figure", "shaker_figure",
    "shaker_waveform_figure", "sheet_amplitude_figure", "sheet_figure", "sine_test_figure", "singular_value_figure",
    "spectrum_figure", "stabilisation_figure", "statics_figure", "subharmonics_figure", "tap_map_figure",
    "tolerance_study_figure", "waits_figure", "wire_law_figure", "wobbling_figure",
]  # fmt: skip
