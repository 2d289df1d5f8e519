"""Decodes frames with cantools: `decode.py heft.dbc frames.csv`, rows `id,data,signal,wanted`; wanted is empty where the
signal must not be available. Prints how many were, and the largest error in bits."""
import csv
import sys

import cantools

database = cantools.database.load_file(sys.argv[1])
values, absent, worst = 0, 0, 0.0
for identifier, data, name, wanted in csv.reader(open(sys.argv[2])):
    message = database.get_message_by_frame_id(int(identifier))
    signal = message.get_signal_by_name(name)
    data = bytes.fromhex(data)
    if wanted == "":
        raw = message.decode(data, decode_choices=False, scaling=False)[name]
        assert raw == 2**signal.length - 1, f"{name} is {raw}, not all ones"
        assert float(message.decode(data, decode_choices=False)[name]) > signal.maximum, name
        absent += 1
    else:
        found = float(message.decode(data, decode_choices=False)[name])
        worst = max(worst, abs(found - float(wanted)) / signal.scale)
        values += 1
print(f"{values} values, {absent} not available, {worst:.6f} bits")
