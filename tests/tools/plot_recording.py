#!/usr/bin/env python3
"""Plots a recording of heft with nothing of heft's own: the file describes itself.

    pip install mcap mcap-protobuf-support matplotlib
    python3 plot_recording.py run.mcap -o run.png

Prints what the recording holds (metadata, channels, messages); `--list` does only that and needs
no matplotlib.
"""

import argparse
import collections

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

# The plots: title with unit, channels, value and standard deviation, truth.
PLOTS = [
    ("Swing inertia [kg m²]", ["excavator/inertia_rls", "excavator/inertia_ukf"], "inertia", ("excavator/truth", "inertia")),
    ("Front-axle load fraction [–]", ["loader/cg_ekf", "loader/cg_ukf"], "cg_ratio", ("loader/truth", "cg_ratio")),
    ("Height of the centre of gravity [m]", ["loader/cg_ekf", "loader/cg_ukf"], "cg_height", ("loader/truth", "cg_height")),
]


def read(path):
    """Metadata, and the decoded messages by channel."""
    messages = collections.defaultdict(list)
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        metadata = {k: v for record in reader.iter_metadata() for k, v in record.metadata.items()}
        for decoded in reader.iter_decoded_messages():
            messages[decoded.channel.topic].append(decoded.decoded_message)
    return metadata, messages


def describe(metadata, messages):
    for name, value in metadata.items():
        print(f"{name}: {value.strip().splitlines()[0] if value.strip() else ''}")
    for channel, list_ in sorted(messages.items()):
        print(f"{channel}: {len(list_)} messages, {type(list_[0]).__name__}")


def plot(messages, output):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    wanted = [p for p in PLOTS if any(messages.get(c) for c in p[1])]
    figure, all_axes = pyplot.subplots(len(wanted), 1, squeeze=False, figsize=(10, 3.5 * len(wanted)), layout="constrained")
    for (title, channels, field, (truth, truth_field)), axes in zip(wanted, all_axes[:, 0]):
        for channel in channels:
            rows = messages.get(channel, [])
            t = [m.t for m in rows]
            value = [getattr(m, field) for m in rows]
            half = [1.96 * getattr(m, field + "_std") for m in rows]
            line, = axes.plot(t, value, label=channel, linewidth=1)
            axes.fill_between(t, [v - h for v, h in zip(value, half)], [v + h for v, h in zip(value, half)],
                              alpha=0.2, color=line.get_color(), linewidth=0)
        rows = messages.get(truth, [])
        axes.plot([m.t for m in rows], [getattr(m, truth_field) for m in rows], "k--", label="truth", linewidth=1)
        values = [getattr(m, field) for c in channels for m in messages.get(c, [])]
        room = 0.3 * (max(values) - min(values)) or 1.0
        axes.set(title=title, xlabel="Time [s]", ylim=(min(values) - room, max(values) + room))
        axes.legend(loc="upper right")
    figure.savefig(output, dpi=110)
    print(output)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording")
    parser.add_argument("-o", "--output", default="recording.png")
    parser.add_argument("--list", action="store_true", help="only say what is in it")
    options = parser.parse_args()
    metadata, messages = read(options.recording)
    describe(metadata, messages)
    if not options.list:
        plot(messages, options.output)


if __name__ == "__main__":
    main()
