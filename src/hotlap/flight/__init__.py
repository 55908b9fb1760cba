"""The flight core: closed-loop flights of controller and plant, many at once."""
