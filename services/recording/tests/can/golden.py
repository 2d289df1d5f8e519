"""Makes golden.csv: random frames of each message of each DBC file here, and what cantools reads in them.

    pip install cantools && python golden.py > golden.csv
"""
import math
import pathlib
import random

import cantools

random.seed(1)
print("file,message,data,signal,value")
for path in sorted(pathlib.Path(__file__).parent.glob("*.dbc")):
    database = cantools.database.load_file(path, strict=False)
    for message in database.messages:
        for _ in range(24 if path.stem == "made_up" else 2):
            data = bytearray(random.randbytes(message.length))
            if message.is_multiplexed():
                data[0] = random.choice([1, 1, 2, 3, 5, 9, 200])
                data[1] = random.choice([7, 8, data[1]])
            try:
                found = message.decode(bytes(data), decode_choices=False)
            except Exception:  # a page that the file does not define
                continue
            for signal, value in found.items():
                value = float(value)
                if math.isfinite(value):
                    print(f"{path.name},{message.name},{data.hex()},{signal},{value!r}")
