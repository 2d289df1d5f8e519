"""The wheel loader's filter from the page docs/theory/loader-steps.md, in the standard library of Python alone.

    heft check --machine loader --set prior.cg_ratio_std=0.1 --print > machine.toml
    heft estimate samples.csv --config machine.toml --method full-ekf -o estimates.csv
    python3 loader.py machine.toml samples.csv estimates.csv

`samples.csv` has rows at 100 Hz: t, speed, front_wheel_speed, rear_wheel_speed, front_torque, rear_torque, slope, acceleration, and
mass, spade_force_x, spade_force_z where they are known (SI units). The method `ekf` is followed as well.
Printed is how far both are apart, in standard deviations of the filter. Numbers (0) to (12) are those of the page.

The prior .1 of the load fraction is wider than the default, .06, on purpose. With a narrower one heft adds the stated ratio to the
filter's answer (docs/theory/loader-numbers.md). That is left out here: the difference is up to .03 with .06, and 1.4 with .03.
"""

import cmath
import csv
import math
import operator
import sys
import tomllib

STATES = ("v", "w_f", "w_r", "K", "h", "lam", "F_x", "d_f", "d_r", "b", "e", "tau")
V, WF, WR, K, H, LAM, FX, DF, DR, B, E, TAU = range(12)
WHEELS = (WF, WR)
G, G_OF_PAPER = 9.80665, 9.81
TINY = 1e-30  # of the complex step that differentiates: f'(x) = Im f(x + i TINY)/TINY


class Machine:
    """The keys of a machine file that the filter reads."""

    def __init__(self, path, paper):
        with open(path, "rb") as file:
            keys = tomllib.load(file)
        self.m, self.s, self.prior, self.e = (keys[name] for name in ("machine", "sensors", "prior", "estimator"))
        m, s, prior, e = self.m, self.s, self.prior, self.e
        followed = {"load_transfer": "physical", "tuning": "paper", "inputs": "auto", "substeps": 1}
        followed |= {"slope_delay": 0, "slope_acceleration_sensitivity": 0, "length": 0}
        for table in (e, s, m["lift_arm"]):
            for key in followed.keys() & table.keys():
                if table[key] != followed[key]:
                    sys.exit(f"{key} = {table[key]} is left out here")
        self.paper, self.n = paper, 6 if paper else 12
        if paper:  # (12)
            m |= {"friction": 0.0, "radius_load_sensitivity": 0.0}
            e |= {"q_speed": 5e-3, "q_wheel_speed": 1e-2, "q_slip_stiffness": 1e-3, "q_cg_height": 1e-4, "q_cg_ratio": 1e-4}
        self.mass = self.empty_mass = m["mass"]
        self.g = G_OF_PAPER if paper else G
        gain = math.sqrt(m["stiffness_ratio"])
        self.gains = gain, 1 / gain
        # (2): what is known at the start, with standard deviations, and the random walks of 10 ms.
        radii = [0.0, 0.0] if paper else [prior["front_radius_error"], prior["rear_radius_error"]]
        self.start = [0.0, 0.0, 0.0, prior["slip_stiffness"], prior["cg_height"], prior["cg_ratio"], 0.0, *radii]
        self.start += [0.0 if paper else prior["slope_bias"], 0.0, s["speed_delay"]]
        known = "speed wheel_speed wheel_speed slip_stiffness cg_height cg_ratio spade_force radius radius slope_bias"
        self.std = [prior[f"{name}_std"] for name in known.split()] + [1e-9, s["speed_delay_std"]]
        self.walk = [e[f"q_{name}"] for name in known.split()] + [0.0, e["q_speed_delay"]]
        bounded = (K, "slip_stiffness"), (H, "cg_height"), (LAM, "cg_ratio")
        self.bounds = {i: (e[f"{name}_min"], e[f"{name}_max"]) for i, name in bounded}

    def loads(self, p, a, u, sine, cosine):
        """(3): both axle loads at an acceleration, none below 2 % of the weight."""
        m, base = self.mass, self.m["wheelbase"]
        tr = -m * p[H] * (a + self.g * sine) / base
        lever = self.m["bucket_reach"] / base
        front = m * self.g * p[LAM] * cosine + u["F_z"] * (1 + lever) + tr
        rear = m * self.g * (1 - p[LAM]) * cosine - u["F_z"] * lever - tr
        return [larger(load, 0.02 * m * self.g) for load in (front, rear)]

    def advance(self, x, u, dt):
        """(3): v, w_f and w_r one step later, of real or complex states."""
        p = x + self.start[len(x) :]
        r, inertia, m = self.m["wheel_radius"], self.m["axle_inertia"], self.mass
        slope = u["th"] - p[B]
        sine, cosine = cmath.sin(slope), cmath.cos(slope)
        rolling = self.m["rolling_resistance"] * cmath.tanh(p[V] / 0.05) * (m * self.g * cosine + u["F_z"])
        drag = rolling + m * self.g * sine + p[FX] + u["F_x"]
        radii = [r * (1 + p[d]) for d in (DF, DR)]
        force = u["T_f"] / radii[0] + u["T_r"] / radii[1] - drag
        a = force / (m + inertia / radii[0] ** 2 + inertia / radii[1] ** 2)
        v, wheels = p[V], [p[WF], p[WR]]
        for _ in range(2):
            push, grips, pulls = -drag, 0.0, []
            for i, load in enumerate(self.loads(p, a, u, sine, cosine)):
                torque, old = (u["T_f"], u["T_r"])[i], p[WHEELS[i]]
                relative = 2 * load / (self.empty_mass * self.g)
                radius = r * (1 + p[(DF, DR)[i]] - (self.m["radius_load_sensitivity"] + p[E]) * (relative - 1))
                stiffness = p[K] * self.gains[i] * relative ** -self.m["stiffness_load_exponent"]
                if self.m["friction"] > 0:
                    used = absolute(torque - inertia * a / radius) / (self.m["friction"] * radius * load)
                    stiffness *= saturated(smaller(used, 0.995))
                slowest = larger(larger(absolute(v), absolute(radius * wheels[i])), self.e["v_min"])
                c = stiffness * load / slowest
                damped = 1 + dt * radius**2 * c / inertia
                push += c / damped * radius * (old + dt * torque / inertia)
                grips += c / damped
                pulls.append((old, torque, radius * c, damped))
            v = (p[V] + dt / m * push) / (1 + dt / m * grips)
            wheels = [(old + dt / inertia * (torque + pull * v)) / damped for old, torque, pull, damped in pulls]
            a = (v - p[V]) / dt
        return [v, *wheels]


def larger(a, b):
    return a if a.real > b.real else b


def smaller(a, b):
    return b if a.real > b.real else a


def absolute(a):
    return a if a.real > 0 else -a


def saturated(u):
    return u / cmath.atanh(u) if u.real > 1e-6 else 1.0


class Filter:
    """(4): state, covariance, and the two operations on them."""

    def __init__(self, machine):
        self.machine, n = machine, machine.n
        self.x = machine.start[:n]
        self.p = [[machine.std[i] ** 2 if i == j else 0.0 for j in range(n)] for i in range(n)]

    def ahead(self, u, dt):
        """v, w_f and w_r after the step, and their derivatives by the state."""
        by = [[0.0] * self.machine.n for _ in range(3)]
        for j in range(min(self.machine.n, TAU)):
            x = self.x[:]
            x[j] += TINY * 1j
            moved = self.machine.advance(x, u, dt)
            for k in range(3):
                by[k][j] = moved[k].imag / TINY
        return [value.real for value in moved], by

    def predict(self, moved, by, u, dt, noise):
        """Moves on; returns the predicted measurements, their covariances with the states, and among themselves."""
        n, p, old = self.machine.n, self.p, self.x
        # Of each measurement: value, derivatives by the state before, a state whose noise it sees, and by which factor.
        made = [(moved[i], by[i], i, 1.0) for i in range(3)]
        if not self.machine.paper:
            rate, slope = (moved[V] - old[V]) / dt, u["th"] - old[B]
            late, force = [(1 - old[TAU] / dt) * a for a in by[V]], [a / dt for a in by[V]]
            late[V] += old[TAU] / dt
            late[TAU] -= rate
            force[V] -= 1 / dt
            force[B] -= G * math.cos(slope)
            made[0] = moved[V] - old[TAU] * rate, late, V, 1.0
            made.append((rate + G * math.sin(slope), force, V, 1 / dt))

        def after(with_old):
            """Covariances with the states after the step, of those with the states before it."""
            return [dot(with_old, row) for row in by] + with_old[3:]

        cross, own = [], []
        for _, row, sees, factor in made:
            with_old = [dot(row, column) for column in p]
            cross.append(after(with_old))
            cross[-1][sees] += factor * noise[sees]
            own.append([dot(with_old, h) + (s == sees) * factor * c * noise[s] for _, h, s, c in made])
        rows = [after([dot(row, column) for column in p]) for row in by]
        self.p = rows + [[rows[k][i] for k in range(3)] + p[i][3:] for i in range(3, n)]
        for i in range(n):
            self.p[i][i] += noise[i]
        self.x = moved + old[3:]
        return [y for y, _, _, _ in made], cross, own

    def update(self, innovation, std, accepted, cross, own):
        """Takes the accepted measurements, one after the other; of each what those before it have told is left out."""
        taken = []
        for j in range(len(innovation)):
            if not accepted[j]:
                continue
            column, row, left = cross[j], own[j][:], innovation[j]
            row[j] += std[j] ** 2
            for before, shared, told in taken:
                share = shared[j]
                column = [a - share * b for a, b in zip(column, before)]
                row = [a - share * b for a, b in zip(row, shared)]
                left -= share * told
            root = math.sqrt(row[j])
            taken.append(([a / root for a in column], [a / root for a in row], left / root))
        for column, _, told in taken:
            for i, gain in enumerate(column):
                self.x[i] += gain * told
                self.p[i] = [a - gain * b for a, b in zip(self.p[i], column)]


def dot(a, b):
    return sum(map(operator.mul, a, b))


class Peak:
    """The largest value, which fades with .25 s."""

    def __init__(self):
        self.value = 0.0

    def step(self, value, dt):
        self.value = max(value, self.value * (1 - min(dt / 0.25, 1)))
        return self.value


class Gain:
    """(5): force on the body over that of the torques, by blocks in which the ground does not resist."""

    def __init__(self):
        self.x, self.p = [1.0, 0.2, 0.0], [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 1e-12 + 0.06**2]]
        self.sums, self.time, self.waiting = [0.0] * 3, 0.0, [None] * 5

    def step(self, felt, pull, v, counts, dt):
        if not counts:
            self.sums, self.time = [0.0] * 3, 0.0
            return
        self.sums = [s + a * dt for s, a in zip(self.sums, (felt, pull, 1.0 if v >= 0 else -1.0))]
        self.time += dt
        if self.time < 0.2 - dt / 2:
            return
        block = [s / self.time for s in self.sums]
        self.sums, self.time = [0.0] * 3, 0.0
        _, left, _, variance = self.expects(block)
        if abs(left) > 0.15 + 2 * math.sqrt(variance):
            if left < 0 <= v < 3:
                self.waiting = [None] * 5
                return
            self.p[0][0] = max(self.p[0][0], 0.01)
        if self.waiting[0]:
            self.take(self.waiting[0])
        self.waiting = [*self.waiting[1:], block]

    def expects(self, block):
        """Regressor, innovation, covariance with the states, and variance."""
        by = [block[1], -block[2], 1.0]
        column = [dot(row, by) for row in self.p]
        return by, block[0] - dot(self.x, by), column, dot(column, by) + 1.5 * 0.05**2

    def take(self, block):
        for i, walk in enumerate((0.001, 0.01, 0.01)):
            self.p[i][i] += walk**2 * 0.2
        _, left, column, variance = self.expects(block)
        if abs(left) <= 0.4:
            self.x = [x + c / variance * left for x, c in zip(self.x, column)]
            self.p = [[self.p[i][j] - column[i] / variance * column[j] for j in range(3)] for i in range(3)]


class SlipNoise:
    """(10): noise of a slip speed, from the Allan variance of its innovations."""

    def __init__(self):
        self.square, self.blocks = 0.004**2, 1.0
        self.interrupt()

    def interrupt(self):
        self.sum, self.time, self.last = 0.0, 0.0, None

    def step(self, value, dt):
        self.sum += value * dt
        self.time += dt
        if self.time < 0.25 - dt / 2:
            return
        mean, last = self.sum / self.time, self.last
        self.sum, self.time, self.last = 0.0, 0.0, mean
        if last is not None:
            self.blocks = min(self.blocks + 1, 80.0)
            self.square += (min(0.5 * (mean - last) ** 2, 9 * self.square) - self.square) / self.blocks

    def over(self, modelled, per, dt):
        """(7): the measured noise, if it exceeds twice the modelled one."""
        found = per * math.sqrt(self.square * max(0.25 / dt, 1.0))
        return found if found > 2 * modelled else modelled


class Forces:
    """(5): specific force that the torques do not explain."""

    def __init__(self, machine):
        self.machine, self.brake, self.force = machine, 0.0, Peak()
        self.gain, self.fast, self.beyond, self.changes = Gain(), 0.0, 0.0, 0.0
        self.short = self.long = 0.0
        self.square, self.time = 0.15**2, 2.0
        self.braking, self.slip = False, 0.0

    def step(self, v, stiffness, force, u, felt, dt):
        machine, keys = self.machine, self.machine.m
        mass = machine.mass + 2 * keys["axle_inertia"] / keys["wheel_radius"] ** 2
        pull = (u["T_f"] + u["T_r"]) / (keys["wheel_radius"] * mass)
        rolling = keys["rolling_resistance"] * math.tanh(v / 0.05) * machine.mass * G
        needed = felt + (rolling + u["F_x"]) / mass
        alone, fast = u["F_x"] == 0, abs(v) > 0.5
        left = needed - min(max(self.gain.x[0], 0.75), 1.33) * pull
        self.shake(min(max(left, -1.0), 1.0), alone and fast, dt)
        self.gain.step(felt, pull, v, alone and fast and pull * v > 0 and abs(pull) < 5 and abs(felt) < 5, dt)
        self.fast += min(dt / 0.05, 1) * (left - self.fast)
        explained = 0.05 + 0.05 * abs(felt)
        self.beyond = max(abs(self.fast) - explained, 0.0)
        not_followed = max(abs(self.fast + force / mass) - explained, 0.0)
        self.changes = math.hypot(not_followed, 0.3 * self.beyond)
        self.brake = 0.25 if self.beyond > 0.15 and self.fast * v < 0 else self.brake - dt
        self.braking = self.brake > dt / 2
        self.slip = 4 * self.force.step(self.beyond, dt) / (G * stiffness)

    def shake(self, left, counts, dt):
        """(5): what lies between 1 and 5 Hz is the accelerometer's."""
        short, long = 0.032, 0.16
        self.short += min(dt / short, 1) * (left - self.short)
        self.long += min(dt / long, 1) * (left - self.long)
        if counts:
            band = 0.5 / short + 0.5 / long - 2 / (short + long)
            self.time = min(self.time + dt, 20.0)
            self.square += min(dt / self.time, 1) * ((self.short - self.long) ** 2 / (band * dt) - self.square)

    def acceleration_std(self):
        found, stated = math.sqrt(self.square), self.machine.s["acceleration_std"]
        return found if found > 2 * stated else stated


class Slope:
    """(5): errors of the slope beside a constant bias."""

    def __init__(self):
        self.started, self.mean, self.variance = False, 0.0, 0.01**2

    def step(self, rim, acceleration, slope, dt):
        free = acceleration - G * math.sin(slope)
        if not self.started:
            self.started, self.speed, self.free = True, rim, free
        rate = (rim - self.speed) / 0.5
        self.speed += min(dt / 0.5, 1) * (rim - self.speed)
        self.free += min(dt / 0.5, 1) * (free - self.free)
        away = (self.free - rate) / G - self.mean
        self.mean += min(dt / 10, 1) * away
        self.variance += min(dt / 10, 1) * (away**2 - self.variance)

    def walk(self, dt):
        return math.sqrt(max(self.variance - 0.002**2, 0.0)) * math.sqrt(dt)


class Wheels:
    """(7), (10): noise of both wheel speeds, by sensor, tyre and road."""

    def __init__(self, machine):
        self.machine, self.lagged, self.last = machine, [0.0, 0.0], [None, None]
        self.quantum, self.sums = [math.inf, math.inf], [16 * 0.12**2, 16.0]
        self.torques, self.rates = None, [0.0, 0.0]
        self.common, self.apart = SlipNoise(), SlipNoise()

    def see_steps(self, speeds):
        for i, speed in enumerate(speeds):
            change = abs(speed - self.last[i]) if self.last[i] is not None else 0.0
            self.last[i] = speed
            if change > 1e-9:
                self.quantum[i] = min(self.quantum[i], change)

    def square(self):
        usual = self.machine.e["c_b"] ** 2
        return max((self.sums[0] + 100 * usual) / (self.sums[1] + 100), usual)

    def std(self, v, stiffness, u, is_held, dt):
        """Deviation of each wheel; keeps the parts of its variance."""
        keys, e = self.machine.m, self.machine.e
        v, r, usual = abs(v), keys["wheel_radius"], e["c_b"] ** 2
        q = max(v, e["v_min"]) / (r**2 * stiffness * 0.5 * self.machine.mass * G)
        rate = math.sqrt(max(0.01 / dt, 1.0))
        ripple = e["c_rho"] * max(abs(keys["radius_load_sensitivity"]), 0.002) * v / r
        settle = min(dt * max(v, 0.3) / 0.3, 1.0)
        counted = usual + max(0.4 / max(dt, 0.01), 1.0) * (self.square() - usual)
        stds, self.rows = [], []
        for i, torque in enumerate((u["T_f"], u["T_r"])):
            self.lagged[i] += settle * (torque - self.lagged[i])
            by_slip, lag = rate * torque * q, e["c_t"] * (torque - self.lagged[i]) * q
            quantum = self.quantum[i] if math.isfinite(self.quantum[i]) else 0.0
            sensor = self.machine.s["wheel_speed_std"] ** 2 + quantum**2 / 12
            variance = sensor + rate**2 * (ripple**2 + lag**2)
            self.rows.append((by_slip, variance))
            std = math.sqrt(variance + counted * by_slip**2)
            stds.append(self.apart.over(max(std, rate * 0.3) if is_held else std, 1 / r / math.sqrt(2), dt))
        return stds

    def by_itself(self, i):
        by_slip, variance = self.rows[i]
        return variance + self.square() * by_slip**2

    def windup(self, u, dt, stiffness, ratio):
        """(8): a wheel whose torque grows turns faster."""
        keys, faster = self.machine.m, []
        torques = u["T_f"], u["T_r"]
        before = self.torques or torques
        self.torques = torques
        for i, share in enumerate((ratio, 1 - ratio)):
            self.rates[i] += min(dt / 0.01, 1) * ((torques[i] - before[i]) / dt - self.rates[i])
            load = max(share, 0.1) * self.machine.mass * G
            faster.append(keys["relaxation_length"] * self.rates[i] / (keys["wheel_radius"] ** 2 * stiffness * load))
        return faster

    def learn(self, innovations, predicted, dt):
        """(10): how much slips fluctuate."""
        usual = self.machine.e["c_b"] ** 2
        self.sums = [s * (1 - min(dt / 20, 1)) for s in self.sums]
        for innovation, std, (by_slip, variance) in zip(innovations, predicted, self.rows):
            variance += std**2
            slip = by_slip**2
            most = 25 * (variance + self.square() * slip)
            weight = (usual * slip / (variance + usual * slip)) ** 2
            if weight > 0:
                self.sums[0] += weight * (min(innovation**2, most) - variance) / slip
                self.sums[1] += weight


class Lag:
    """(10): by how much the rear wheel speed comes later than the front one."""

    def __init__(self, machine):
        self.machine, prior = machine, machine.prior
        k, lam = prior["slip_stiffness"], prior["cg_ratio"]
        slip = 1 / k
        spread = [math.hypot(prior["slip_stiffness_std"] / k, prior["cg_ratio_std"] / x) for x in (lam, 1 - lam)]
        std = math.sqrt(2) * prior["radius_std"], slip * spread[0], slip * spread[1], 0.004, 0.01 / math.sqrt(6)
        self.theta = [0.0, slip, slip, 0.0, 0.0]
        self.p = [[std[i] ** 2 if i == j else 0.0 for j in range(5)] for i in range(5)]
        self.chi, self.time, self.value = 1.0, 0.0, 0.0

    def step(self, difference, v, v_before, u, lam, dt):
        if self.time == 0:
            self.begin, self.rows, self.sums = v_before, 0, [0.0] * 4
        lam = min(max(lam, 0.1), 0.9)
        self.sums = [s + a for s, a in zip(self.sums, (difference, v, u["T_f"] / lam, -u["T_r"] / (1 - lam)))]
        self.rows += 1
        self.time += dt
        if self.time >= 0.2 - dt / 2:
            self.absorb(*(s / self.rows for s in self.sums), (v - self.begin) / self.time)
            self.time = 0.0

    def absorb(self, difference, v, front, rear, a):
        if abs(v) < 0.5:
            return
        r = self.machine.m["wheel_radius"]
        per = abs(v) / (r * self.machine.mass * G)
        x = [v, per * front, per * rear, v * a, a]
        for i, walk in enumerate((0.001, 0.01, 0.01, 0.001, 0.001)):
            self.p[i][i] += walk**2 / 60 * self.time
        column = [dot(row, x) for row in self.p]
        variance = dot(column, x) + 0.002**2
        residual = r * difference - dot(self.theta, x)
        over = max(residual**2 / variance / 4, 1.0)
        self.theta = [t + c / (variance * over) * residual for t, c in zip(self.theta, column)]
        self.p = [[self.p[i][j] - column[i] * column[j] / (variance * over) for j in range(5)] for i in range(5)]
        self.chi += 0.2 / 20 * (residual**2 / variance / over - self.chi)
        tau, s = self.theta[4], min(1.5 * self.p[4][4] * max(self.chi, 0.3), 0.01**2 / 6)
        together = math.exp(-0.5 * tau**2 / s) / math.sqrt(2 * math.pi * s)
        apart = max(1 - abs(tau) / 0.01, 0.1) / 0.01 / 9
        self.value = apart / (apart + together) * tau


class Directions:
    """(11): whether the machine has driven both ways, and does of late."""

    def __init__(self):
        self.time, self.known = [0.0, 0.0], False

    def step(self, v, slowest, dt):
        self.time = [t * (1 - min(dt / 60, 1)) for t in self.time]
        if abs(v) > slowest:
            self.time[v < 0] += dt
        both = min(self.time) > 1
        first, self.known = both and not self.known, self.known or both
        return both, first


class Estimator:
    """One step a row."""

    def __init__(self, machine, row):
        self.machine, self.filter, self.before = machine, Filter(machine), row
        self.forces, self.slope, self.wheels, self.lag = Forces(machine), Slope(), Wheels(machine), Lag(machine)
        self.directions, self.digs = Directions(), 0.0
        self.more, self.learnt_at, self.way = [0.0] * machine.n, None, 0.0
        # (0)
        machine.mass = row.get("mass", machine.mass)
        if abs(machine.mass / machine.empty_mass - 1) < 0.05:
            machine.empty_mass = machine.mass
        self.filter.x[:3] = self.measured(row)[:3]

    def measured(self, row):
        felt = row.get("acceleration", 0.0) - self.machine.s["acceleration_offset"]
        return [row["speed"], row["front_wheel_speed"], row["rear_wheel_speed"], felt]

    def inputs(self, row):
        """(1): what a row says acts; of the six states none is the bias of the slope."""
        s = self.machine.s
        return {
            "T_f": row["front_torque"] / s["front_torque_gain"],
            "T_r": row["rear_torque"] / s["rear_torque_gain"],
            "F_x": row.get("spade_force_x", 0.0),
            "F_z": row.get("spade_force_z", 0.0),
            "th": row["slope"] - (self.machine.prior["slope_bias"] if self.machine.paper else 0.0),
        }

    def step(self, row):
        machine, before, self.before = self.machine, self.before, row
        dt, old, now = row["t"] - before["t"], self.inputs(before), self.inputs(row)
        measured = self.measured(row)
        machine.mass = row.get("mass", machine.mass)
        if machine.paper:
            self.step_of_paper(old, measured[:3], dt)
            return
        rim = 0.5 * machine.m["wheel_radius"] * (measured[WF] + measured[WR])
        self.slope.step(rim, measured[3], now["th"], dt)
        u = {key: 0.5 * (old[key] + now[key]) for key in now}
        measured[3] = 0.5 * (self.measured(before)[3] + measured[3])
        self.forces.step(self.filter.x[V], self.filter.x[K], self.filter.x[FX], u, measured[3], dt)
        self.update(u, measured, dt)

    def step_of_paper(self, u, measured, dt):
        """(12): held inputs, noise of the sensors, no gates."""
        f, s = self.filter, self.machine.s
        moved, by = f.ahead(u, dt)
        y, cross, own = f.predict(moved, by, u, dt, [q**2 for q in self.walks(dt)])
        std = s["speed_std"], s["wheel_speed_std"], s["wheel_speed_std"]
        f.update([a - b for a, b in zip(measured, y)], std, [True] * 3, cross, own)

    def walks(self, dt):
        machine = self.machine
        walks = [q * math.sqrt(dt / 0.01) for q in machine.walk[: machine.n]]
        walks[V] = max(walks[V], machine.g * machine.s["slope_std"] * dt)
        return walks

    def conditions(self, v, force, dt):
        """(6): whether parameters are held, and whether digging ends with this row."""
        e, digs, ends = self.machine.e, True, False
        if abs(force) > e["dig_force"]:
            self.digs = e["dig_hold"]
        elif self.digs > 0:
            self.digs -= dt
            ends = self.digs < 0.5 * dt
            self.digs = 0.0 if ends else self.digs
        else:
            digs = False
        return digs or abs(v) < e["v_freeze"], ends

    def noise(self, is_held, ends, dt):
        """(6): variances of the random walks."""
        machine, walks = self.machine, self.walks(dt)
        if is_held:
            walks[K] = walks[H] = walks[LAM] = 0.0
        if ends and machine.e["reopen"] > 0:
            walks[H], walks[LAM] = (machine.e["reopen"] * machine.std[i] for i in (H, LAM))
        walks[B] = max(walks[B], self.slope.walk(dt))
        walks[FX] = max(walks[FX], machine.mass * self.forces.changes * math.sqrt(2 * dt / 0.25))
        return [a**2 + b**2 for a, b in zip(walks, self.more)]

    def ground(self, slip, v, stiffness, dt):
        """(7): noise of a wheel that slips near the friction limit of the ground."""
        keys = self.machine.m
        used = stiffness * keys["wheel_radius"] * slip / (max(abs(v), self.machine.e["v_min"]) * keys["friction"])
        return 0.2 * slip * used**2 * (2 + 0.4 * used**2) / 3 * math.sqrt(max(0.4 / dt, 1.0))

    def update(self, u, measured, dt):
        machine, f, wheels, forces = self.machine, self.filter, self.wheels, self.forces
        before, radius, gate = f.x[:], machine.m["wheel_radius"], machine.e["gate"]
        variances = [f.p[i][i] for i in range(machine.n)]
        moved, by = f.ahead(u, dt)
        v = moved[V]
        is_held, ends = self.conditions(v, u["F_x"] + before[FX], dt)
        noise = self.noise(is_held, ends, dt)
        # (7)
        wheels.see_steps(measured[WF : WR + 1])
        by_wheel = wheels.std(v, before[K], u, is_held, dt)
        disturbed = forces.slip * abs(v) / radius
        by_ground = [self.ground(moved[i] - v / radius, v, before[K], dt) for i in WHEELS]
        std = [wheels.common.over(machine.s["speed_std"], 1, dt)]
        std += [math.hypot(a, b, disturbed) for a, b in zip(by_wheel, by_ground)]
        std.append(forces.acceleration_std())
        y, cross, own = f.predict(moved, by, u, dt, noise)
        predicted = [math.sqrt(own[j][j]) for j in range(4)]
        # (8)
        innovation = [a - b for a, b in zip(measured, y)]
        faster = wheels.windup(u, dt, before[K], before[LAM])
        later = 0.5 * (v - before[V]) / dt * self.lag.value / radius
        innovation[WF] -= faster[0] + later
        innovation[WR] -= faster[1] - later
        # (9)
        for i in WHEELS:
            variance = wheels.by_itself(i - 1) + predicted[i] ** 2 + disturbed**2
            std[i] *= max(abs(innovation[i]) / (3 * math.sqrt(variance)), 1.0)
        far = [abs(a) / math.hypot(b, c) for a, b, c in zip(innovation, std, predicted)]
        accepted = [a < machine.e["reject"] and not (forces.braking and j in WHEELS) for j, a in enumerate(far)]
        std = [b + abs(a) / gate if c > gate else b for a, b, c in zip(innovation, std, far)]
        if accepted[WF] and accepted[WR] and not is_held:
            wheels.learn([innovation[i] for i in WHEELS], [predicted[i] for i in WHEELS], dt)
            rims = [radius * innovation[i] for i in WHEELS]
            wheels.common.step(0.5 * (rims[0] + rims[1]) - innovation[V], dt)
            wheels.apart.step(rims[0] - rims[1], dt)
            self.lag.step(measured[WF] - measured[WR], v, before[V], u, before[LAM], dt)
        else:
            self.lag.time = 0.0
            wheels.common.interrupt()
            wheels.apart.interrupt()
        f.update(innovation, std, accepted, cross, own)
        for i, (least, most) in machine.bounds.items():
            f.x[i] = min(max(f.x[i], least), most)
        self.open(v, before[E], variances[E], dt)
        if forces.braking:
            for i in (K, H, LAM, DF, DR):
                lost = math.sqrt(max(variances[i] + noise[i] - f.p[i][i], 0.0))
                f.x[i], self.more[i] = before[i], math.hypot(self.more[i], lost)

    def open(self, v, e, e_variance, dt):
        """(11): what the next step may change more than usual."""
        machine, f = self.machine, self.filter
        self.relearn()
        both, first = self.directions.step(v, machine.e["v_freeze"], dt)
        if not both:
            f.x[E], self.more[E] = e, math.sqrt(max(e_variance - f.p[E][E], 0.0))
        elif first and max(machine.m["radius_load_sensitivity_std"], machine.e["load_sensitivity_floor"]) > 0:
            height = 0.005 * f.x[H] / abs(machine.m["radius_load_sensitivity"] + f.x[E])
            for i, std in ((E, 0.005), (LAM, 16 * 0.005 * f.x[LAM]), (H, min(height, machine.std[H]))):
                self.more[i] = math.hypot(self.more[i], std)

    def relearn(self):
        """(11): what the start has taught wrongly, and radii under a load that has shifted."""
        machine, f = self.machine, self.filter
        self.more = [0.0] * machine.n
        if self.learnt_at is None:
            if math.sqrt(f.p[LAM][LAM]) > 0.3 * machine.std[LAM]:
                return
            self.learnt_at = f.x[LAM]
            away = [(f.x[i] - machine.start[i]) / machine.std[i] for i in (K, LAM)]
            for i in (K, H, LAM, DF, DR):
                self.more[i] = min(machine.e["relearn"] * dot(away, away), 1.0) * machine.std[i]
        way = f.x[LAM] - self.learnt_at
        if abs(way - self.way) >= 0.02:
            sensitivity = min(machine.m["radius_load_sensitivity_std"], 0.001)
            for i in (DF, DR):
                self.more[i] = math.hypot(self.more[i], 2 * sensitivity * math.sqrt(abs(way**2 - self.way**2)))
            self.way = way


def apart(f, answer):
    """How far state and covariance are from what a row of heft says, in standard deviations, by column."""
    std = [math.sqrt(f.p[i][i]) for i in range(len(f.x))]
    said = {column: (f.x[i] + more, std[i]) for column, (i, more) in COLUMNS.items() if i < len(f.x)}
    said |= {name: (value, root) for name, value, root in zip(STATES, f.x, std)}
    said |= {f"{name}_std": (root, root) for name, root in zip(STATES, std)}
    return {column: abs(ours - answer[column]) / root for column, (ours, root) in said.items() if column in answer}


# Columns of heft's estimates, and what they are of the filter: a state, and what is added to it.
COLUMNS = {"speed": (V, 0), "front_wheel_speed": (WF, 0), "rear_wheel_speed": (WR, 0), "slip_stiffness": (K, 0)}
COLUMNS |= {"cg_height": (H, 0), "cg_ratio": (LAM, 0), "spade_force_x": (FX, 0), "slope_bias": (B, 0)}
COLUMNS |= {"front_radius_scale": (DF, 1), "rear_radius_scale": (DR, 1)}


def table(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return [{k: float(v) for k, v in row.items() if number(v)} for row in rows], rows[0].get("method")


def number(text):
    try:
        return math.isfinite(float(text))
    except (TypeError, ValueError):
        return False


# Signals that heft uses if they are measured, and this example does not.
OTHERS = ["articulation", "yaw_rate", "brake", "lift_angle", "tilt_angle", "lift_head_pressure", "lift_rod_pressure"]


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    (rows, _), (heft, method) = table(sys.argv[2]), table(sys.argv[3])
    if method not in ("ekf", "full-ekf"):
        sys.exit(f"{sys.argv[3]} is by {method}: this follows full-ekf and ekf (heft estimate --method full-ekf)")
    unused = [name for name in OTHERS if any(row.get(name) for row in rows)]
    if unused:
        print(f"heft uses these too, and the page's clean rows do not have them: {', '.join(unused)}")
    estimator = Estimator(Machine(sys.argv[1], method == "ekf"), rows[0])
    largest, squares = {}, []
    for row, answer in zip(rows[1:], heft[1:], strict=True):
        estimator.step(row)
        for column, by in apart(estimator.filter, answer).items():
            largest[column] = max(largest.get(column, 0.0), by)
            squares.append(by**2)
    rms, worst = math.sqrt(sum(squares) / len(squares)), max(largest, key=largest.get)
    print(f"rows {len(rows) - 1}, compared: {', '.join(largest)}; furthest apart is {worst}")
    print(f"apart by {rms:.1e} (rms) and {largest[worst]:.1e} (largest) of the filter's standard deviations")


if __name__ == "__main__":
    main()
