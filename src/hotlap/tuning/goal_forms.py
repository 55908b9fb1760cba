"""How a goal is written; imports nothing that takes time."""

FORMS = "completion=1, completion=0.95, mean_error<0.3, max_error<1.0 or none"
LAP_TIME = "lap_time"  # a goal that is not reached by parameters alone: the fastest plan that holds
