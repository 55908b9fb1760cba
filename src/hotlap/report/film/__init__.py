"""Film: the flight with the tuned parameters as a film, beside the flight before tuning.

study -> flight_frames (states at the times of the frames) -> frames (matplotlib) -> recording (.gif, .mp4)
"""
