"""The excavator's filter from the page docs/theory/excavator-steps.md, in the standard library of Python alone.

    heft check --machine excavator --print > machine.toml
    heft estimate samples.csv --config machine.toml -o estimates.csv
    python3 excavator.py machine.toml samples.csv estimates.csv

`samples.csv` has rows at 100 Hz: t, swing_velocity, swing_torque, boom_angle, arm_angle, bucket_angle, pitch, roll (SI units).
Printed is how far both are apart, in heft's standard deviations.
Numbers (0) to (10) are those of the page.
"""

import csv
import math
import sys
import tomllib

N = 14  # states: the page's table, in its order
W, M, D, B, K, L, TF, P, Q, S, JU, MB, E, TAU = range(N)
G = 9.80665


class Machine:
    """The keys of a machine file that the filter reads."""

    def __init__(self, path):
        with open(path, "rb") as file:
            keys = tomllib.load(file)
        m, g, s = keys["machine"], keys["machine"]["geometry"], keys["sensors"]
        prior, e = keys["prior"], keys["estimator"]

        def stated(value, otherwise):
            return otherwise if value == "none" else value

        self.g, self.prior, self.e, self.upper = g, prior, e, m["upper_inertia"]
        self.friction, self.least = m["coulomb_friction"], m["inertia_min"]
        self.velocity_std, self.torque_std = s["swing_velocity_std"], s["swing_torque_std"]
        self.rated = prior["payload"] + 1.25 * prior["payload_std"]
        balance = self.inertia((0.96, -2.55, -1.48))["moment"]
        tolerance = m["mass_tolerance"]
        # (2): what is known at the start, with standard deviations.
        bucket = stated(m["bucket_tolerance"], 11 * tolerance) * g["bucket_mass"]
        sticks, sticks_std = (prior[key] * self.rated for key in ("carry_back", "carry_back_std"))
        self.sticking = 8 / 7 * sticks_std  # from load to load
        # Expected soil in the bucket, given the sum of bucket and soil; and the range of payloads.
        self.soil = lambda both: sticks + (sticks_std / math.hypot(bucket, sticks_std)) ** 2 * (both - sticks)
        most = prior["payload"] + 4 * prior["payload_std"]
        self.range = e["payload_min"], max(e["payload_max"], most)
        first = stated(m["upper_first_moment"], -1.15 * balance)
        self.start = {
            W: (0.0, 1e-3),
            M: (prior["payload"], prior["payload_std"]),
            D: (0.0, prior["torque_offset_std"]),
            B: (m["nominal_damping"], prior["damping_std"]),
            K: (0.0, stated(s["swing_torque_gain_std"], 0.05) or 0.05),
            L: (1 - m["drive_efficiency"], m["drive_efficiency_std"]),
            TF: (self.friction, stated(m["coulomb_friction_std"], prior["friction_std"])),
            P: (0.0, m["slope_std"]),
            Q: (0.0, m["slope_std"]),
            S: (first, stated(m["upper_first_moment_std"], 0.4 * balance)),
            JU: (0.0, stated(m["upper_tolerance"], 7 * tolerance) * self.upper),
            MB: (sticks, math.hypot(bucket, sticks_std)),
            E: (0.0, math.hypot(tolerance, 2 * m["geometry_tolerance"])),
            TAU: (0.0, math.hypot(s["swing_velocity_delay_std"], s["swing_torque_delay_std"])),
        }

    def inertia(self, joints):
        """(1): the inertia at a posture, and its parts."""
        g = self.g
        a1 = joints[0]
        a2 = a1 + joints[1]
        a3 = a2 + joints[2]
        cos, sin = [math.cos(a) for a in (a1, a2, a3)], [math.sin(a) for a in (a1, a2, a3)]
        arm_pin = g["boom_pin"] + g["boom_length"] * cos[0]
        bucket_pin = arm_pin + g["arm_length"] * cos[1]
        radii = (
            g["boom_pin"] + g["boom_centre"] * cos[0] - g["boom_rise"] * sin[0],
            arm_pin + g["arm_centre"] * cos[1],
            bucket_pin + g["bucket_centre"] * cos[2] - g["bucket_rise"] * sin[2],
        )
        load = bucket_pin + g["payload_centre"] * cos[2] - g["payload_rise"] * sin[2]
        names = ("boom", "arm", "bucket")
        masses = [g[f"{name}_mass"] for name in names]
        turned = [
            g[f"{name}_inertia"] * c * c + g[f"{name}_axial_inertia"] * s * s
            for name, c, s in zip(names, cos, sin)
        ]
        parts = [m * r * r + t for m, r, t in zip(masses, radii, turned)]
        return {
            "empty": self.upper + sum(parts),
            "load": load**2 + g["payload_gyration"] ** 2,
            "bucket": parts[2] / masses[2],
            "links": parts[0] + parts[1],
            "moment": sum(m * r for m, r in zip(masses, radii)),
            "radius": load,
            "bucket_radius": radii[2],
            "links_moment": masses[0] * radii[0] + masses[1] * radii[1],
        }


class Filter:
    """State, covariance, and the two operations on them."""

    def __init__(self, start):
        self.x = [start[i][0] for i in range(N)]
        self.p = [[start[i][1] ** 2 if i == j else 0.0 for j in range(N)] for i in range(N)]
        self.acceleration = 0.0

    def measure(self, row, innovation, variance, gate):
        """A scalar measurement; the innovation beyond the gate is weakened. Returns its normalised value before the gate."""
        column = [sum(a * self.p[j][i] for j, a in row.items()) for i in range(N)]
        predicted = sum(a * column[j] for j, a in row.items()) + variance
        divisor = max(predicted, innovation**2 / gate**2)
        for i in range(N):
            self.x[i] += column[i] / divisor * innovation
        for i in range(N):
            for j in range(N):
                self.p[i][j] -= column[i] * column[j] / divisor
        return innovation / math.sqrt(predicted)

    def set(self, i, value, variance):
        self.x[i] = value
        for j in range(N):
            self.p[i][j] = self.p[j][i] = 0.0
        self.p[i][i] = variance

    def fade(self, start, kept):
        """What was told of the constants fades towards their description."""
        constants = (K, JU, MB, E)
        for i in constants:
            self.x[i] = start[i][0] + kept * (self.x[i] - start[i][0])
            for j in range(N):
                self.p[i][j] *= kept
                self.p[j][i] *= kept
        for i in constants:
            self.p[i][i] += (1 - kept * kept) * start[i][1] ** 2


class Standstill:
    """(4): does the upper body stand?"""

    def __init__(self, machine, velocity_std):
        self.still, self.ring, self.large, self.torque = True, [], 0.0, 0.0
        self.friction, self.torque_std = machine.friction, machine.torque_std
        self.std, self.scale = velocity_std, velocity_std / 0.005

    def step(self, velocity, torque, dt):
        large = math.copysign(1, velocity) if abs(velocity) > 0.12 * self.scale else 0.0
        believed = large in (0.0, self.large)
        self.large = large
        measured = believed or not self.still
        if measured:
            self.ring = self.ring[-11:] + [velocity]
        gain = 1 - 0.65 ** (dt / 0.01)
        self.torque += gain * (torque - self.torque)
        noise = 3 * self.torque_std * math.sqrt(gain / (2 - gain))
        quiet = abs(self.torque) < max(self.friction, noise)
        if self.still:
            if len(self.ring) < 4:
                return "held", 0.0
            mean = sum(self.ring[-1:-5:-1]) / 4
            if abs(mean) > (0.012 if quiet else 0.03) * self.scale:
                self.still = False
                return "released", mean
            self.still = quiet
            return ("held" if quiet else "moving"), 0.0
        if quiet and measured and len(self.ring) == 12:
            mean = sum(self.ring) / 12
            std = math.sqrt(sum((y - mean) ** 2 for y in self.ring) / 11)
            self.still = abs(mean) < 0.006 * self.scale and std < 2 * self.std
        return ("held" if self.still else "moving"), 0.0


class Noise:
    """(8): factors of the variances by which the innovations are white."""

    def __init__(self):
        self.logs, self.sums = [0.0, 0.0], []
        self.rest()

    def rest(self):
        # The last sums stay in the ring, but four new ones are waited for.
        self.sum, self.count, self.filled = 0.0, 0, 0

    def push(self, z):
        self.sum += min(max(z, -4.0), 4.0)
        self.count += 1
        if self.count < 10:
            return
        self.sums = (self.sums + [self.sum / math.sqrt(10)])[-4:]
        self.sum, self.count, self.filled = 0.0, 0, self.filled + 1
        if self.filled < 4:
            return
        slow = sum(self.sums) ** 2 / 4
        fast = (sum(s * s for s in self.sums) - slow) / 3
        for i, (square, rates, most) in enumerate(((slow, (0.1, 0.1), 400.0), (fast, (0.3, 0.03), 36.0))):
            excess = min(square, 9.0) - 1
            log = self.logs[i] + rates[excess < 0] * excess
            self.logs[i] = min(max(log, math.log(0.25)), math.log(most))

    def torque(self):
        return math.exp(self.logs[0])

    def vibration(self):
        return math.exp(self.logs[1]) * 0.01**2


class Bucket:
    """(5): what the joints say about the content."""

    def __init__(self, threshold):
        self.threshold, self.ring, self.open, self.closed, self.rate = threshold, [], 0, 10**9, 0.0
        self.joints = self.stopped = None
        self.unlocked, self.emptied, self.least, self.most = True, False, math.inf, -math.inf

    def step(self, t, joints, share, stands):
        """Whether the content may be any."""
        rate = (joints[2] - self.ring[0][1]) / (t - self.ring[0][0]) if len(self.ring) == 10 else 0.0
        self.ring = self.ring[-9:] + [(t, joints[2])]
        self.open = 10 if rate > self.threshold else max(self.open - 1, 0)
        self.rate = max(rate, 0.0) if self.open else 0.0
        self.closed = 0 if self.open else self.closed + 1
        before = self.joints or joints
        self.joints = now = [b + share * (q - b) for b, q in zip(before, joints)]
        self.least, self.most = min(self.least, now[2]), max(self.most, now[2])
        if now[2] - self.least > 1.15:
            self.emptied, self.most, self.least = True, now[2], now[2] - 1.15
        if stands and self.most - now[2] > 0.4:
            self.emptied, self.least, self.most = False, now[2], now[2] + 0.4
        if not stands:
            self.stopped, self.unlocked = None, False
            return False
        self.stopped = self.stopped or now
        self.unlocked |= any(abs(a - b) > 0.03 for a, b in zip(now, self.stopped))
        return self.unlocked

    def is_emptied(self):
        return self.emptied and self.closed >= 20


class Estimator:
    """One step a row."""

    def __init__(self, machine, velocity_std):
        self.machine, self.filter = machine, Filter(machine.start)
        self.standstill, self.noise = Standstill(machine, velocity_std), Noise()
        self.bucket, self.variance = Bucket(machine.e["opening_rate"]), velocity_std**2
        self.before = self.torque_before = None
        self.turn = self.smoothed = self.largest = self.slow_for = self.w_before = self.gaining = self.unfaded = 0.0
        self.expected, self.tared, self.up, self.down = True, False, 0.0, 0.0

    def answer(self, now):
        """(10): inertia, and the payload with what sticks, which no bucket holds beyond a range."""
        f, (least, most) = self.filter, self.machine.range
        load = (1 + f.x[K]) * f.x[M]
        weight = load + self.machine.soil(f.x[MB])
        payload = min(max(weight, least), most)
        beside = f.x[JU] + f.x[MB] * now["bucket"] + f.x[E] * now["links"]
        return now["empty"] + (load + payload - weight) * now["load"] + beside, payload

    def step(self, t, dt, velocity, torque, joints, inclination):
        machine, f = self.machine, self.filter
        phase, mean = self.standstill.step(velocity, torque, dt)
        now = machine.inertia(joints)
        before, torque_before = self.before or now, torque if self.torque_before is None else self.torque_before
        self.before, self.torque_before = now, torque
        change, torque = torque - torque_before, (torque + torque_before) / 2
        kept = math.exp(-dt / 0.1)
        share = 1 - kept * kept
        self.gaining += (1 - kept) * ((f.x[W] - self.w_before) / dt - self.gaining)
        self.w_before = f.x[W]
        creeps = abs(f.x[W]) + 0.3 * abs(self.gaining) < 0.05
        self.slow_for = self.slow_for + dt if phase == "held" or creeps else 0.0
        unknown = self.bucket.step(t, joints, share, phase == "held" or self.slow_for > 0.3)
        self.hold(unknown)
        if phase == "held" and inclination:
            self.incline(*inclination)
        if phase == "moving":
            self.move(dt, velocity, (torque, change), now, before, share)
            return
        if phase == "held" and self.slow_for > 2:
            for i in (P, Q):
                anywhere = machine.start[i][1] ** 2
                if f.p[i][i] < anywhere:
                    f.p[i][i] += 0.02 * dt * anywhere
        # (4): w is known, and nothing else is learnt.
        f.set(W, mean, 1e-6 if phase == "held" else self.variance / 4 + 0.02**2)
        f.acceleration, self.up, self.down = 0.0, 0.0, 0.0
        self.noise.rest()
        if phase == "released":
            # The mean is late by tau of the acceleration that begins.
            a = torque / max(now["empty"] + (1 + f.x[K]) * f.x[M] * now["load"], machine.least)
            f.x[W] += a * f.x[TAU]
            variance = f.p[W][W] + a * a * f.p[TAU][TAU]
            for i in range(N):
                f.p[W][i] = f.p[i][W] = a * f.p[TAU][i]
            f.p[W][W] = variance

    def hold(self, unknown):
        """(5): the prior of a content counts for this content alone."""
        f, prior = self.filter, (self.machine.prior["payload"], self.machine.prior["payload_std"] ** 2)
        if self.expected and (unknown or self.bucket.open):
            self.expected = False
            if f.p[M][M] <= 0.5 * prior[1]:
                column, left, away = f.p[M][:], f.p[M][M] - prior[1], prior[0] - f.x[M]
                for i in range(N):
                    f.x[i] += column[i] / left * away
                for i in range(N):
                    for j in range(N):
                        f.p[i][j] -= column[i] * column[j] / left
        if unknown:
            f.set(M, *prior)
            self.tared, self.expected = False, True

    def incline(self, pitch, roll):
        """(6): pitch and roll of the standing machine."""
        sin, cos = math.sin(self.turn), math.cos(self.turn)
        f = self.filter
        for i, slope in ((P, roll * cos - pitch * sin), (Q, -roll * sin - pitch * cos)):
            if f.p[i][i] > 0.004**2:
                f.measure({i: 1.0}, slope - f.x[i], 0.03**2, 1e3)

    def move(self, dt, velocity, torques, now, before, share):
        torque, change = torques
        machine, f, e = self.machine, self.filter, self.machine.e
        x, p = f.x, f.p
        self.smoothed += share * (torque - self.smoothed)
        self.largest = max(self.largest, abs(self.smoothed))
        # (7): what wanders.
        p[K][K] += 0.001**2 * dt
        for i in (TF, B):
            p[i][i] += machine.start[i][1] ** 2 * dt / 60
        self.unfaded += dt
        if self.unfaded + dt / 2 >= 20:
            f.fade(machine.start, math.exp(-self.unfaded / 300))
            self.unfaded = 0.0
        braked = max(1 - abs(x[W]) / 0.04, 0.0) * (abs(torque) + machine.friction)
        ground = self.largest if self.slow_for > 0.3 else 0.0
        torque_variance = (
            (e["torque_noise_share"] * self.largest) ** 2 * self.noise.torque() * 0.01 / dt
            + machine.torque_std**2
            + change**2 / 4
            + braked**2 * 0.1 / dt
            + ground**2 * 0.3 / dt
        )
        opened, payload = self.bucket.rate * dt, max(x[M], 0.0)
        slides = 0.7 * dt if self.is_losing() else 0.0
        # (3): prediction.
        mean = {key: (now[key] + before[key]) / 2 for key in now}
        rate = {key: (now[key] - before[key]) / dt for key in now}

        gain = 1 + x[K]
        load = gain * x[M]

        def inertia(of):
            return of["empty"] + load * of["load"] + x[MB] * of["bucket"] + x[E] * of["links"]

        j, j_rate = max(inertia(mean) + x[JU], machine.least), inertia(rate)
        s, size = math.tanh(x[W] / e["friction_width"]), abs(torque)
        sin, cos = math.sin(self.turn), math.cos(self.turn)
        lean = G * (x[P] * cos - x[Q] * sin)
        moment = (
            x[S] + now["moment"] + load * now["radius"] + x[MB] * now["bucket_radius"] + x[E] * now["links_moment"]
        )
        lost = x[TF] + x[L] * size
        driving = torque + x[D] - lost * s - x[B] * x[W]
        acceleration = (gain * driving + lean * moment - j_rate * x[W]) / j
        steep = max(lost, 0.0) * (1 - s * s) / e["friction_width"]

        def heavier(radius, its_rate, its_inertia):
            return dt / j * (lean * radius - its_rate * x[W] - acceleration * its_inertia)

        row = [0.0] * N
        row[W] = math.exp(-dt / j * (gain * (x[B] + steep) + j_rate))
        per_load = heavier(now["radius"], rate["load"], mean["load"])
        row[M], row[K] = gain * per_load, dt / j * driving + x[M] * per_load
        row[MB] = heavier(now["bucket_radius"], rate["bucket"], mean["bucket"])
        row[E] = heavier(now["links_moment"], rate["links"], mean["links"])
        of_torque = gain * dt / j
        row[JU], row[D], row[B] = -dt / j * acceleration, of_torque, -of_torque * x[W]
        row[L], row[TF] = -of_torque * size * s, -of_torque * s
        row[P], row[Q], row[S] = dt / j * G * moment * cos, -dt / j * G * moment * sin, dt / j * lean
        column = [sum(row[k] * p[k][i] for k in range(N)) for i in range(N)]
        variance = sum(a * b for a, b in zip(row, column)) + torque_variance * of_torque**2
        x[W] += dt * acceleration
        f.acceleration = acceleration
        for i in range(N):
            p[W][i] = p[i][W] = column[i]
        p[W][W] = variance
        leaving = min(e["opening_decay"] * opened, 0.5)
        x[M] *= 1 - leaving
        for i in range(N):
            p[M][i] *= 1 - leaving
            p[i][M] *= 1 - leaving
        p[M][M] += 0.5 * payload**2 * (opened + slides) + e["q_m"] * machine.rated**2 * 1e-5 * dt
        self.turn += x[W] * dt
        # (9): correction by the velocity, which is late by tau.
        innovation = velocity - x[W] + x[TAU] * acceleration
        variance = self.variance + self.noise.vibration()
        z = f.measure({W: 1.0, TAU: -acceleration}, innovation, variance, e["gate"])
        self.noise.push(z)
        self.watch(z)
        self.tare()

    def watch(self, z):
        """(5): a payload that changes though no joint moved."""
        z = min(max(z, -3.0), 3.0)
        self.up, self.down = max(self.up + z - 0.5, 0.0), max(self.down - z - 0.5, 0.0)
        if max(self.up, self.down) > 10:
            self.up = self.down = 0.0
            self.filter.p[M][M] += 0.25 * self.machine.rated**2

    def weighs_empty(self):
        """(6): whether the weight of an emptied bucket is known."""
        return self.bucket.is_emptied() and self.filter.p[M][M] <= (0.15 * self.machine.rated) ** 2

    def is_losing(self):
        """(6): whether what an emptied bucket weighs may still slide out."""
        m, variance = self.filter.x[M], self.filter.p[M][M] + self.machine.sticking**2
        return self.weighs_empty() and self.bucket.closed < 200 and m > 0 and m * m > variance

    def tare(self):
        """(6): an emptied bucket weighs nothing beside what sticks."""
        f, own = self.filter, self.machine.sticking**2
        if self.tared or not self.weighs_empty() or self.is_losing():
            return
        if f.x[M] ** 2 < 4 * (f.p[M][M] + own):
            self.tared = True
            f.p[MB][MB] += own / 64
            f.measure({M: 1.0}, -f.x[M], own, self.machine.e["gate"])


def at_rest(rows, machine):
    """(0): bias and noise of the velocity, from the half second in which the machine stands."""
    still = [row["swing_velocity"] for row in rows if row["t"] < rows[0]["t"] + 0.495]
    bias = sum(still) / len(still)
    std = math.sqrt(sum((y - bias) ** 2 for y in still) / (len(still) - 1))
    ratio = std / machine.velocity_std
    return len(still), bias, machine.velocity_std * (min(ratio, 4.0) if ratio > 1.3 else 1.0)


def table(path):
    with open(path, newline="") as file:
        return [{k: float(v) for k, v in row.items() if number(v)} for row in csv.DictReader(file)]


def number(text):
    try:
        return math.isfinite(float(text))
    except (TypeError, ValueError):
        return False


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    machine = Machine(sys.argv[1])
    rows, heft = table(sys.argv[2]), table(sys.argv[3])
    stood, bias, std = at_rest(rows, machine)
    estimator, before, apart = Estimator(machine, std), rows[stood - 1]["t"], []
    for row, answer in zip(rows[stood:], heft[stood:], strict=True):
        joints = [row[f"{joint}_angle"] for joint in ("boom", "arm", "bucket")]
        inclination = (row["pitch"], row["roll"]) if "pitch" in row else None
        dt, before = row["t"] - before, row["t"]
        estimator.step(row["t"], dt, row["swing_velocity"] - bias, row["swing_torque"], joints, inclination)
        inertia, payload = estimator.answer(estimator.before)
        apart.append((inertia - answer["inertia"]) / answer["inertia_std"])
        apart.append((payload - answer["payload"]) / answer["payload_std"])
    worst = max(apart, key=abs)
    rms = math.sqrt(sum(a * a for a in apart) / len(apart))
    print(f"rows {len(apart) // 2}, apart by {rms:.1e} (rms) and {abs(worst):.1e} (largest) of heft's standard deviations")


if __name__ == "__main__":
    main()
