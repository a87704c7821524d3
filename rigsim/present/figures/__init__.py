"""Figures, a file for each domain; the names here are those that results forward `.plot()` to."""

from .identification import (
    identification_figure,
    nonlinear_coefficient_figure,
    receptance_figure,
    singular_value_figure,
)
from .record import record_figure
from .response import force_scenario_figure, frequency_response_figure

__all__ = [
    "force_scenario_figure",
    "frequency_response_figure",
    "identification_figure",
    "nonlinear_coefficient_figure",
    "receptance_figure",
    "record_figure",
    "singular_value_figure",
]
