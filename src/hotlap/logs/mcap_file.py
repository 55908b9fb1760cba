"""MCAP: files of ROS 2, by mcap and mcap-ros2-support; one that was never closed is read as far as it goes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hotlap.logs.flight_log import FlightLog
from hotlap.logs.packages import load
from hotlap.logs.recording import Recording
from hotlap.logs.ros import TAKEN, Topics, short

KIND = "an MCAP file"


def read(path: Path, name: str, mapping: Mapping[str, Any] | None) -> FlightLog:
    """Read a log; see `readers.read`."""
    recording = Recording(name, KIND)
    records, streams = load("mcap.records", KIND, name), load("mcap.stream_reader", KIND, name)
    factory = load("mcap_ros2.decoder", KIND, name).DecoderFactory()
    broken = load("mcap.exceptions", KIND, name).McapError
    topics, schemas, channels = Topics(recording, mapping), dict[int, Any](), dict[int, tuple[str, str, Callable[[bytes], Any]]]()
    with path.open("rb") as file:
        try:
            for record in streams.StreamReader(file).records:
                if isinstance(record, records.Schema):
                    schemas[record.id] = record
                elif isinstance(record, records.Channel) and record.schema_id in schemas:
                    schema = schemas[record.schema_id]
                    topics.seen.add(f"{record.topic} ({short(schema.name)})")
                    decode = factory.decoder_for(record.message_encoding, schema) if short(schema.name) in TAKEN else None
                    if decode is not None:
                        channels[record.id] = (record.topic, short(schema.name), decode)
                elif isinstance(record, records.Message) and record.channel_id in channels:
                    topic, kind, decode = channels[record.channel_id]
                    topics.take(topic, kind, decode(record.data), 1e-9 * record.log_time)
        except (broken, EOFError, ValueError) as error:
            recording.note(f"the file is cut short or damaged: it was read as far as it goes ({type(error).__name__})")
    topics.finish()
    return recording.finish()
