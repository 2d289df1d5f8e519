# Written by bindings/python/stubs; do not edit.
from os import PathLike
from typing import Any, Generic, Iterable, Literal, Mapping, NamedTuple, Optional, Tuple, TypeVar, Union, overload

_Config = Union[None, str, PathLike[str], Mapping[str, Any]]

ExcavatorMethod = Literal["svf-rls", "multi-forgetting-rls", "auto", "posture-torque", "torque", "posture", "velocity"]
ExcavatorReason = Literal["", "slope", "losses", "friction", "gain", "delay", "offset", "damping", "unexplained", "disagreement", "limit", "content", "frozen", "sign", "method", "restarted", "jump", "contradiction", "hanging", "attachment"]
ExcavatorSignal = Literal["swing_velocity", "swing_angle", "swing_torque", "boom_angle", "arm_angle", "bucket_angle", "pitch", "roll", "boom_head_pressure", "boom_rod_pressure", "arm_head_pressure", "arm_rod_pressure", "truck"]

LoaderMethod = Literal["full-ekf", "ekf", "full", "isr-ukf", "isr-ukf-printed"]
LoaderReason = Literal["", "missing", "stuck speed", "stuck front wheel", "stuck rear wheel", "stuck front torque", "stuck rear torque", "stuck slope", "stuck acceleration", "unexplained", "latency", "stiffness", "brakes", "steering", "slope", "torque", "load", "disagreement", "limit", "restarted", "locked drive", "one way", "wheel radius", "lift cylinder", "accelerometer"]
LoaderSignal = Literal["speed", "front_wheel_speed", "rear_wheel_speed", "front_torque", "rear_torque", "slope", "acceleration", "mass", "spade_force_x", "spade_force_z", "articulation", "yaw_rate", "lift_angle", "tilt_angle", "lift_head_pressure", "lift_rod_pressure", "truck", "boom_moving", "brake"]

class ExcavatorEstimate(NamedTuple):
    """An estimate of an excavator."""
    t: float  # [s]
    inertia: float  # [kg m^2]
    inertia_std: float  # [kg m^2]
    damping: float  # [N m s/rad]
    damping_std: float  # [N m s/rad]
    torque: float  # [N m]
    torque_std: float  # [N m]
    payload: float  # [kg]
    payload_std: float  # [kg]
    velocity: float  # [rad/s]
    acceleration: float  # [rad/s^2]
    excited: bool
    consistent: bool
    fresh: bool
    converged: bool
    identifiable: bool
    held: bool
    changing: bool
    reset: bool
    trusted: bool
    friction: float  # [N m]
    friction_std: float  # [N m]
    offset: float  # [N m]
    offset_std: float  # [N m]
    refused: bool
    method: ExcavatorMethod
    reason: ExcavatorReason
    @property
    def why(self) -> str: ...
    def interval(self, quantity: Literal["inertia", "damping", "torque", "payload", "friction", "offset"] = ...) -> Tuple[float, float]: ...

class LoaderEstimate(NamedTuple):
    """An estimate of a loader."""
    t: float  # [s]
    speed: float  # [m/s]
    front_wheel_speed: float  # [rad/s]
    rear_wheel_speed: float  # [rad/s]
    slip_stiffness: float
    slip_stiffness_std: float
    cg_height: float  # [m]
    cg_height_std: float  # [m]
    cg_ratio: float
    cg_ratio_std: float
    cg_distance: float  # [m]
    spade_force_x: float  # [N]
    spade_force_x_std: float  # [N]
    slope_bias: float  # [rad]
    front_radius_scale: float
    rear_radius_scale: float
    nis: float
    excited_ratio: bool
    excited_height: bool
    consistent: bool
    fresh: bool
    converged_ratio: bool
    converged_height: bool
    frozen: bool
    reset: bool
    trusted_ratio: bool
    trusted_height: bool
    trusted_payload: bool
    payload: float  # [kg]
    payload_std: float  # [kg]
    refused: bool
    method: LoaderMethod
    reason: LoaderReason
    @property
    def why(self) -> str: ...
    def interval(self, quantity: Literal["slip_stiffness", "cg_height", "cg_ratio", "spade_force_x", "payload"] = ...) -> Tuple[float, float]: ...

_Row = TypeVar("_Row", ExcavatorEstimate, LoaderEstimate)

class Estimator(Generic[_Row]):
    """Steps through samples as they come, with the numbers of ``heft.estimate``, bit for bit."""
    @overload
    def __init__(
        self: Estimator[ExcavatorEstimate],
        machine: Literal["excavator"],
        *,
        signals: Iterable[ExcavatorSignal],
        config: _Config = ...,
        method: Optional[ExcavatorMethod] = ...,
    ) -> None: ...
    @overload
    def __init__(
        self: Estimator[LoaderEstimate],
        machine: Literal["loader"],
        *,
        signals: Iterable[LoaderSignal],
        config: _Config = ...,
        method: Optional[LoaderMethod] = ...,
    ) -> None: ...
    @overload
    def step(self: Estimator[ExcavatorEstimate], t: float, *, swing_velocity: Optional[float] = ..., swing_angle: Optional[float] = ..., swing_torque: Optional[float] = ..., boom_angle: Optional[float] = ..., arm_angle: Optional[float] = ..., bucket_angle: Optional[float] = ..., pitch: Optional[float] = ..., roll: Optional[float] = ..., boom_head_pressure: Optional[float] = ..., boom_rod_pressure: Optional[float] = ..., arm_head_pressure: Optional[float] = ..., arm_rod_pressure: Optional[float] = ..., truck: Optional[float] = ...) -> ExcavatorEstimate: ...
    @overload
    def step(self: Estimator[LoaderEstimate], t: float, *, speed: Optional[float] = ..., front_wheel_speed: Optional[float] = ..., rear_wheel_speed: Optional[float] = ..., front_torque: Optional[float] = ..., rear_torque: Optional[float] = ..., slope: Optional[float] = ..., acceleration: Optional[float] = ..., mass: Optional[float] = ..., spade_force_x: Optional[float] = ..., spade_force_z: Optional[float] = ..., articulation: Optional[float] = ..., yaw_rate: Optional[float] = ..., lift_angle: Optional[float] = ..., tilt_angle: Optional[float] = ..., lift_head_pressure: Optional[float] = ..., lift_rod_pressure: Optional[float] = ..., truck: Optional[float] = ..., boom_moving: Optional[float] = ..., brake: Optional[float] = ...) -> LoaderEstimate: ...
    def state(self) -> bytes:
        """The complete state with description, method and signals; see ``from_state``."""
    @classmethod
    def from_state(cls, state: bytes) -> Estimator[Any]:
        """The estimator that wrote this state; it goes on bit for bit."""
    @property
    def machine(self) -> str: ...
    @property
    def method(self) -> str: ...
    @property
    def signals(self) -> list[str]: ...
    @property
    def description(self) -> str: ...
    def __copy__(self) -> Estimator[_Row]: ...
    def __deepcopy__(self, _memo: Any) -> Estimator[_Row]: ...
