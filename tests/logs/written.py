"""One flight, written as each program writes it: what is read must be the same."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import numpy as np

DOWN = np.array([1.0, -1.0, -1.0])


@dataclass(frozen=True)
class Flown:
    """A flight in hotlap's units and frames."""

    times: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    attitude: np.ndarray
    rates: np.ndarray
    acceleration: np.ndarray
    rate_command: np.ndarray
    thrust: np.ndarray
    motors: np.ndarray
    volts: np.ndarray


def make_flight(count: int = 200) -> Flown:
    """Two seconds with a different motion on every axis."""
    t = np.arange(count) * 0.01
    waves = np.column_stack([np.sin(t + k) for k in range(3)])
    attitude = np.column_stack([np.cos(0.3 * np.sin(t)), np.sin(0.3 * np.sin(t)) * 0.6, 0 * t, np.sin(0.3 * np.sin(t)) * 0.8])
    return Flown(
        times=t,
        position=waves * [3, 2, 1] + [0, 0, 2],
        velocity=np.column_stack([np.cos(t + k) for k in range(3)]) * [3, 2, 1],
        attitude=attitude,
        rates=waves * [2.0, 1.0, 0.5],
        acceleration=waves + [0, 0, 9.81],
        rate_command=waves[:, ::-1] * [1.0, 2.0, 3.0],
        thrust=0.4 + 0.1 * waves[:, 0],
        motors=0.5 + 0.05 * np.column_stack([waves, waves[:, 0]]),
        volts=16 - 0.1 * t,
    )


def write_ulog(path: Path, flight: Flown, *, leave_out: tuple[str, ...] = (), version: int = 1, scale: float = 1.0) -> Path:
    """A ULog by hand: formats, parameters, subscriptions, data."""
    topics = {
        "vehicle_local_position": (["x", "y", "z", "vx", "vy", "vz"], np.hstack([flight.position * DOWN, flight.velocity * DOWN])),
        "vehicle_attitude": (["float[4] q"], flight.attitude * [1, 1, -1, -1]),
        "vehicle_angular_velocity": (["float[3] xyz"], flight.rates * DOWN * scale),
        "sensor_combined": (
            ["float[3] gyro_rad", "float[3] accelerometer_m_s2"],
            np.hstack([flight.rates * DOWN, flight.acceleration * DOWN]),
        ),
        "vehicle_rates_setpoint": (
            ["roll", "pitch", "yaw", "float[3] thrust_body"],
            np.column_stack([flight.rate_command * DOWN, 0 * flight.times, 0 * flight.times, -flight.thrust]),
        ),
        "actuator_motors": (["float[4] control"], flight.motors),
        "battery_status": (["voltage_v"], flight.volts[:, None]),
    }
    out = bytearray(b"ULog\x01\x12\x35" + bytes([version]) + struct.pack("<Q", 0))

    def add(kind: str, body: bytes) -> None:
        out.extend(struct.pack("<HB", len(body), ord(kind)) + body)

    kept = {name: topic for name, topic in topics.items() if name not in leave_out}
    add("B", bytes(40))
    for name, (fields, _) in kept.items():
        typed = [field if " " in field else f"float {field}" for field in fields if field not in leave_out]
        add("F", f"{name}:uint64_t timestamp;{';'.join(typed)};".encode())
    key = b"float MC_ROLLRATE_P"
    add("P", bytes([len(key)]) + key + struct.pack("<f", 0.15))
    for number, name in enumerate(kept):
        add("A", struct.pack("<BH", 0, number) + name.encode())
    for row, time in enumerate(flight.times):
        for number, (fields, values) in enumerate(kept.values()):
            gone = [i for i, field in enumerate(fields) if field in leave_out]
            numbers = np.delete(values[row], gone)
            add("D", struct.pack("<HQ", number, round(1e6 * time) + 5_000_000) + numbers.astype("<f4").tobytes())
    path.write_bytes(out)
    return path


def _unsigned(value: int) -> bytes:
    out = bytearray()
    while value > 127:
        out.append((value & 127) | 128)
        value >>= 7
    return bytes([*out, value])


def _signed(value: int) -> bytes:
    return _unsigned(((value << 1) ^ (value >> 63)) & 0xFFFFFFFF)


def write_blackbox(path: Path, flight: Flown, *, finer: bool = False, leave_out: tuple[str, ...] = (), end: bool = True) -> Path:
    """A blackbox by hand: headers, and a whole frame a sample."""
    degrees = np.degrees(1.0) * (10 if finer else 1)
    columns = {"loopIteration": np.arange(len(flight.times)), "time": flight.times * 1e6 + 3e6}
    for i in range(3):
        columns[f"gyroADC[{i}]"] = flight.rates[:, i] * degrees
        columns[f"setpoint[{i}]"] = flight.rate_command[:, i] * degrees
        columns[f"accSmooth[{i}]"] = flight.acceleration[:, i] / 9.80665 * 2048
    columns["setpoint[3]"] = flight.thrust * 1000
    columns["rcCommand[3]"] = (1000 + flight.thrust * 1000) * (10 if finer else 1)
    for i in range(4):
        columns[f"motor[{i}]"] = 158 + flight.motors[:, i] * (2047 - 158)
    columns["vbatLatest"] = flight.volts * 100
    columns = {name: column for name, column in columns.items() if name not in leave_out}
    unsigned = ["loopIteration", "time", "vbatLatest"]
    encodings = ",".join("1" if name in unsigned else "0" for name in columns)
    zeros = ",".join("0" for _ in columns)
    heads = {
        "Product": "Blackbox flight data recorder by Nicholas Sherlock",
        "Data version": "2",
        "I interval": "1",
        "P interval": "1",
        "Field I name": ",".join(columns),
        "Field I signed": zeros,
        "Field I predictor": zeros,
        "Field I encoding": encodings,
        "Field P predictor": zeros,
        "Field P encoding": encodings,
        "Firmware revision": "Betaflight 4.5.1 (77d01ba3b) STM32F7X2",
        "acc_1G": "2048",
        "motorOutput": "158,2047",
        "gyro_scale": "0x3f800000",
        "blackbox_high_resolution": "1" if finer else "0",
        "rollPID": "45,80,40",
    }
    out = bytearray("".join(f"H {key}:{value}\n" for key, value in heads.items()).encode())
    for row in range(len(flight.times)):
        out += b"I"
        for name, column in columns.items():
            value = round(float(column[row]))
            out += _unsigned(value) if name in unsigned else _signed(value)
    out += b"E\xffEnd of log\0" if end else b""
    path.write_bytes(out)
    return path


def write_dataflash(path: Path, flight: Flown, *, leave_out: tuple[str, ...] = ()) -> Path:
    """A dataflash log by hand: formats, then messages."""
    degrees = np.degrees(1.0)
    w, x, y, z = (flight.attitude * [1, 1, -1, -1]).T
    angles = np.column_stack([np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), np.arcsin(2 * (w * y - z * x))])
    angles = np.column_stack([angles, np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) % (2 * np.pi)]) * degrees
    core = np.zeros(len(flight.times))
    kinds = {
        "ATT": (129, "Qfff", "TimeUS,Roll,Pitch,Yaw", angles),
        "RATE": (
            130,
            "Qfffffff",
            "TimeUS,RDes,R,PDes,P,YDes,Y,AOut",
            np.column_stack(
                [
                    *np.stack([flight.rate_command * DOWN * degrees, flight.rates * DOWN * degrees], axis=2).reshape(-1, 6).T,
                    flight.thrust,
                ]
            ),
        ),
        "IMU": (
            131,
            "QBffffff",
            "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ",
            np.column_stack([core, flight.rates * DOWN, flight.acceleration * DOWN]),
        ),
        "RCOU": (132, "QHHHH", "TimeUS,C1,C2,C3,C4", 1000 + 1000 * flight.motors),
        "BAT": (133, "QBf", "TimeUS,Inst,Volt", np.column_stack([core, flight.volts])),
        "XKF1": (
            134,
            "QBffffff",
            "TimeUS,C,VN,VE,VD,PN,PE,PD",
            np.column_stack([core, flight.velocity * DOWN, flight.position * DOWN]),
        ),
    }
    sizes = {"Q": 8, "B": 1, "H": 2, "f": 4}
    out = bytearray()

    def describe(number: int, name: str, form: str, labels: str) -> None:
        length = 3 + sum(sizes.get(c, 0) for c in form)
        out.extend(b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", number, length, name.encode(), form.encode(), labels.encode()))

    out.extend(b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", 128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns"))
    kept = {name: kind for name, kind in kinds.items() if name not in leave_out}
    for name, (number, form, labels, _) in kept.items():
        describe(number, name, form, labels)
    for row, time in enumerate(flight.times):
        for number, form, _, values in kept.values():
            numbers = [round(v) if c in "BH" else float(v) for c, v in zip(form[1:], values[row], strict=True)]
            out.extend(b"\xa3\x95" + bytes([number]) + struct.pack("<" + form, round(1e6 * time) + 7_000_000, *numbers))
    path.write_bytes(out)
    return path


def write_csv(path: Path, flight: Flown, *, seconds: float = 1.0, turn: float = 1.0) -> Path:
    """A table whose columns have names of their own."""
    heads = "stamp,X,Y,Z,gx,gy,gz,ax,ay,az"
    rows = np.column_stack([flight.times / seconds, flight.position, flight.rates * turn, flight.acceleration])
    path.write_text("\n".join([heads, *(",".join(map(repr, row)) for row in rows.tolist())]) + "\n")
    return path


def write_dataflash_text(path: Path, flight: Flown) -> Path:
    """The same log as text, a message a line, as ArduPilot's tools write it."""
    reader = import_module("pymavlink.DFReader")
    log, lines = reader.DFReader_binary(str(write_dataflash(path.with_suffix(".bin"), flight))), []
    while (message := log.recv_msg()) is not None:
        fields = [getattr(message, name) for name in message.get_fieldnames()]
        lines.append(", ".join([message.get_type(), *map(str, fields)]))
    log.close()
    path.write_text("\n".join(lines) + "\n")
    return path
