"""Figures: all functions that draw plain data as a matplotlib figure."""

from hotlap.report.convergence import convergence
from hotlap.report.input_charts import inputs
from hotlap.report.sample_chart import samples
from hotlap.report.sensitivity_chart import sensitivity
from hotlap.report.time_charts import tracking_error
from hotlap.report.track_view import track
from hotlap.report.tuned_parameters import tuned_parameters

__all__ = ["convergence", "inputs", "samples", "sensitivity", "track", "tracking_error", "tuned_parameters"]
