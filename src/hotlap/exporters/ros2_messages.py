"""ROS 2 messages as text: what their fields are, which a bag brings with it, so that any program can read it."""

from __future__ import annotations

from collections.abc import Mapping

RULE = "=" * 80
HEADER = "builtin_interfaces/Time stamp\nstring frame_id"
TIME = "int32 sec\nuint32 nanosec"
THREE = "float64 x\nfloat64 y\nfloat64 z"
FOUR = f"{THREE}\nfloat64 w"
FIELDS: Mapping[str, str] = {
    "builtin_interfaces/Time": TIME,
    "std_msgs/Header": HEADER,
    "geometry_msgs/Point": THREE,
    "geometry_msgs/Vector3": THREE,
    "geometry_msgs/Quaternion": FOUR,
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose",
    "geometry_msgs/PoseArray": "std_msgs/Header header\ngeometry_msgs/Pose[] poses",
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose\nfloat64[36] covariance",
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist\nfloat64[36] covariance",
    "nav_msgs/Path": "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses",
    "nav_msgs/Odometry": "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
    "geometry_msgs/TwistWithCovariance twist",
    "mavros_msgs/AttitudeTarget": "std_msgs/Header header\nuint8 type_mask\ngeometry_msgs/Quaternion orientation\n"
    "geometry_msgs/Vector3 body_rate\nfloat32 thrust",
}


def definition_of(kind: str) -> str:
    """The definition of a type, followed by those of all types that it is made of."""
    parts = [FIELDS[kind], *(f"MSG: {needed}\n{FIELDS[needed]}" for needed in _needed(kind))]
    return f"\n{RULE}\n".join(parts)


def _needed(kind: str) -> list[str]:
    """The types that a type is made of, each once."""
    found = dict[str, None]()
    for line in FIELDS[kind].splitlines():
        part = line.split()[0].removesuffix("[]")
        if part in FIELDS:
            found |= dict.fromkeys([part, *_needed(part)])
    return list(found)
