"""What a user writes; `mypy --strict` must pass."""

from pathlib import Path
from typing import Dict, Tuple

import heft
import numpy as np
import pandas


def live(t: float, velocity: float) -> Tuple[float, float]:
    estimator = heft.Estimator("excavator", signals=["swing_velocity", "swing_torque"], method="torque")
    estimate = estimator.step(t, swing_velocity=velocity, swing_torque=None)
    if estimate.trusted and estimate.reason != "slope":
        print(estimate.inertia, estimate.payload_std, estimate.why)
    again = heft.Estimator.from_state(estimator.state())
    again.step(t + 0.01)
    return estimate.interval("inertia")


def wheel_loader() -> float:
    loader = heft.Estimator("loader", signals=["speed"], config={"sensors.rate": 100})
    return loader.step(0.0, speed=1.0).t


def look_back(file: str) -> float:
    frame: pandas.DataFrame = heft.estimate(pandas.read_csv(file), "excavator")
    other = heft.estimate({"t": np.zeros(3), "swing_velocity": np.zeros(3)}, "excavator", method="auto")
    return float(frame["inertia"].iloc[-1]) + float(other["inertia"].iloc[0])


def calibrated(file: str) -> float:
    found = heft.calibrate("excavator", [file], "machine.toml", payload={"empty.csv": 0, file: "400±5"})
    weighed: Dict[str, int] = {"empty.csv": 0}
    found = heft.calibrate("excavator", [Path(file)], "machine.toml", payload=weighed, mass={Path(file): 5500})
    return found["machine.nominal_damping"].std
