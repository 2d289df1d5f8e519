"""Reads a recording of heft with the packages `mcap` and `mcap-protobuf-support` from PyPI.

    pip install mcap mcap-protobuf-support
    python read_recording.py run.mcap

Prints, as JSON, the metadata and for each channel the number of messages, the fields with their
units, and the values of the last message.
"""

import json
import sys

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from google.protobuf.descriptor_pb2 import FileDescriptorSet


def units(schema):
    """Unit of each field, from the comments of the schema."""
    found = {}
    for file in FileDescriptorSet.FromString(schema.data).file:
        fields = file.message_type[0].field
        for location in file.source_code_info.location:
            comment = location.leading_comments
            if "Unit: " in comment:
                name = fields[location.path[3]].name
                found[name] = comment.rsplit("Unit: ")[1].strip().rstrip(".")
    return found


def main(path):
    channels = {}
    with open(path, "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            entry = channels.setdefault(
                channel.topic,
                {"type": schema.name, "messages": 0, "units": units(schema)},
            )
            entry["messages"] += 1
            entry["log_time"] = message.log_time
            entry["last"] = {f.name: getattr(decoded, f.name) for f in decoded.DESCRIPTOR.fields}
    print(json.dumps({"metadata": metadata, "channels": channels}, indent=1))


if __name__ == "__main__":
    main(sys.argv[1])
