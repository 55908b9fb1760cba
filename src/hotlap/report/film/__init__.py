"""Film: the flight of a study as a moving picture, beside what it was before.

study -> flights (flights, frame by frame) -> frames (matplotlib) -> recording (.gif, .mp4)
"""
