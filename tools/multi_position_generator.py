"""Logs turned by hand between still poses, by an independent generator (calibration.md, section 5).

Poses well spread over the sphere, rests of 2.5 to 5 s, turns of 1.2 to 2.6 s along smooth paths with a tremor of 7 to
12 Hz (0.2 degrees) and hand accelerations of 1 m/s^2; interval means at 100 Hz, computed from 16 steps a sample; noise
and LSB of an MPU-6050. With --knocks: 0.15 s of 25 to 30 Hz ringing in the middle of a rest, after which the pose is
turned by 0.1 degrees. With --walk: a random walk of the gyro bias of 3e-5 rad/s/sqrt(s).

Written without reading the product's source; the measurement model is y = b + (I + M) u + G f.
"""

import numpy as np

G0 = 9.80665
RATE = 100.0
FINE = 16
EARTH = 7.292115e-5


def rotation(vector):
    """Rotation matrices exp([v x]) of an (n, 3) array of rotation vectors."""
    v = np.atleast_2d(vector)
    angle = np.linalg.norm(v, axis=1)
    safe = np.where(angle < 1e-12, 1.0, angle)
    a = np.where(angle < 1e-4, 1 - angle**2 / 6, np.sin(safe) / safe)
    b = np.where(angle < 1e-4, 0.5 - angle**2 / 24, (1 - np.cos(safe)) / safe**2)
    k = np.zeros((len(v), 3, 3))
    k[:, 0, 1], k[:, 0, 2], k[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    k[:, 1, 0], k[:, 2, 0], k[:, 2, 1] = v[:, 2], -v[:, 1], v[:, 0]
    return np.eye(3) + a[:, None, None] * k + b[:, None, None] * (k @ k)


def spread_directions(rng, n):
    """n unit vectors well apart: a random start, then repelled from each other."""
    p = rng.normal(size=(n, 3))
    p /= np.linalg.norm(p, axis=1)[:, None]
    for _ in range(200):
        d = p[:, None] - p[None]
        r = np.linalg.norm(d, axis=2) + np.eye(n)
        p = p + 0.05 * (d / r[..., None] ** 3).sum(1) / n
        p /= np.linalg.norm(p, axis=1)[:, None]
    return p[rng.permutation(n)]


def smooth(t):
    """0 to 1 with zero rate and acceleration at the ends."""
    return t**3 * (10 - 15 * t + 6 * t**2)


def attitude_to(up, rng):
    """A body-from-world matrix whose body direction `up` points up, with a random heading."""
    z = np.array([0.0, 0.0, 1.0])
    axis = np.cross(z, up)
    s, c = np.linalg.norm(axis), up[2]
    turn = np.eye(3) if s < 1e-9 and c > 0 else (
        np.diag([1.0, -1.0, -1.0]) if s < 1e-9 else rotation(axis / s * np.arctan2(s, c))[0])
    return turn @ rotation([0, 0, rng.uniform(-np.pi, np.pi)])[0]


def log_of(r):
    """Rotation vector of a rotation matrix."""
    c = np.clip((np.trace(r) - 1) / 2, -1, 1)
    a = np.arccos(c)
    v = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    if a < 1e-8:
        return v / 2
    if np.pi - a < 1e-4:
        m = (r + np.eye(3)) / 2
        k = np.argmax(np.diag(m))
        u = m[:, k] / np.sqrt(m[k, k])
        return u * a
    return v * a / (2 * np.sin(a))


def path(rng, poses, knocks):
    """Body-from-world attitudes at the fine steps and hand accelerations (world), and where the rests are."""
    dt = 1 / (RATE * FINE)
    attitudes, pushes, rests = [], [], []
    ups = spread_directions(rng, poses)
    now = attitude_to(ups[0], rng)
    count = 0

    def whole(seconds):
        return int(round(seconds * RATE)) * FINE

    for i in range(poses):
        n = whole(rng.uniform(2.5, 5.0))
        start = count
        if knocks and rng.uniform() < 0.3 and n > whole(2.4):
            at, length = n // 2, whole(0.15)
            t = np.arange(length) * dt
            ring = np.sin(2 * np.pi * rng.uniform(25, 30) * t) * np.sin(np.pi * t / t[-1]) ** 2
            axis = rng.normal(size=3)
            axis /= np.linalg.norm(axis)
            final = np.radians(0.1) * smooth(np.arange(1, length + 1) / length)
            angle = ring * np.radians(0.5) + final
            moved = rotation(axis * angle[:, None]) @ now
            side = rng.normal(size=3)
            attitudes += [np.repeat(now[None], at, 0), moved, np.repeat(moved[-1][None], n - at - length, 0)]
            push = np.zeros((n, 3))
            push[at:at + length] = ring[:, None] * 5.0 * side / np.linalg.norm(side)
            pushes.append(push)
            now = moved[-1]
            rests.append((start, start + at))
            rests.append((start + at + length, start + n))
        else:
            attitudes.append(np.repeat(now[None], n, 0))
            pushes.append(np.zeros((n, 3)))
            rests.append((start, start + n))
        count += n
        if i + 1 == poses:
            break
        n = whole(rng.uniform(1.2, 2.6))
        target = attitude_to(ups[i + 1], rng)
        whole_turn = log_of(target @ now.T)
        s = smooth(np.arange(1, n + 1) / n)
        window = np.sin(np.pi * np.arange(1, n + 1) / n) ** 2
        t = np.arange(1, n + 1) * dt
        tremor = np.zeros((n, 3))
        for k in range(3):
            tremor[:, k] = np.radians(0.2) * np.sin(2 * np.pi * rng.uniform(7, 12) * t + rng.uniform(0, 2 * np.pi))
        side = np.cross(whole_turn, rng.normal(size=3))
        side *= rng.uniform(0.1, 0.4) / np.linalg.norm(side)
        bend = rotation((window[:, None]) * side + window[:, None] * tremor)
        attitudes.append(bend @ rotation(whole_turn * s[:, None]) @ now)
        push = np.zeros((n, 3))
        for k in range(3):
            f = rng.uniform(0.6, 2.5)
            push[:, k] = window * np.sin(2 * np.pi * f * t + rng.uniform(0, 2 * np.pi)) * rng.uniform(0.5, 1.4)
        pushes.append(push)
        now = target
        count += n
    return np.concatenate(attitudes), np.concatenate(pushes), rests


def truth(rng):
    accel = np.eye(3) + np.diag(rng.normal(0, 0.01, 3)) + np.tril(rng.normal(0, 0.01, (3, 3)), -1)
    gyro = np.eye(3) + rng.normal(0, 0.01, (3, 3))
    return {
        "accel_b": rng.normal(0, 0.2, 3), "accel_a": accel,
        "gyro_b": rng.normal(0, 0.02, 3), "gyro_a": gyro, "g": rng.normal(0, 5e-5, (3, 3)),
    }


def names(t):
    out = {}
    for i, a in enumerate("xyz"):
        out[f"accel.bias.{a}"] = t["accel_b"][i]
        out[f"gyro.bias.{a}"] = t["gyro_b"][i]
        for j, b in enumerate("xyz"):
            key = f"scale_factor.{a}" if i == j else f"misalignment.{a}{b}"
            out[f"accel.{key}"] = t["accel_a"][i, j] - (i == j)
            out[f"gyro.{key}"] = t["gyro_a"][i, j] - (i == j)
            out[f"gyro.g_sensitivity.{a}{b}"] = t["g"][i, j]
    return out


def make(seed, poses=24, knocks=False, walk=0.0, latitude=None, accel_noise=400e-6, gyro_noise=0.005):
    """Returns time, gyro (rad/s), accel (m/s^2) and the truth by parameter path."""
    rng = np.random.default_rng(seed)
    t = truth(rng)
    attitude, push, _ = path(rng, poses, knocks)
    n = len(attitude) // FINE
    dt = 1 / (RATE * FINE)
    if latitude is not None:
        # The world turns; the log's attitudes are against it.
        world_rate = EARTH * np.array([0.0, np.cos(latitude), np.sin(latitude)])
    else:
        world_rate = np.zeros(3)
    # Body rate from attitude differences: B_k = exp(-[w dt x]) B_{k-1}.
    before = np.concatenate([attitude[:1], attitude[:-1]])
    step = attitude @ np.transpose(before, (0, 2, 1))
    rate = -0.5 * np.stack([step[:, 2, 1] - step[:, 1, 2], step[:, 0, 2] - step[:, 2, 0],
                            step[:, 1, 0] - step[:, 0, 1]], 1) / dt
    size = np.linalg.norm(rate, axis=1) * dt
    rate *= np.where(size > 1e-9, np.arcsin(np.minimum(size, 1)) / np.where(size > 1e-9, size, 1), 1)[:, None]
    middle = 0.5 * (attitude + before)
    rate = rate + middle @ world_rate
    force = np.einsum("kij,kj->ki", middle, push + np.array([0, 0, G0]))
    rate = rate.reshape(n, FINE, 3).mean(1)
    force = force.reshape(n, FINE, 3).mean(1)
    # MPU-6050: 400 ug/sqrt(Hz) and 0.005 deg/s/sqrt(Hz), two-sided densities here; LSB 1/16384 g and 1/131 deg/s.
    accel = t["accel_b"] + force @ t["accel_a"].T + rng.normal(0, accel_noise * G0 * np.sqrt(RATE), (n, 3))
    gyro = t["gyro_b"] + rate @ t["gyro_a"].T + force @ t["g"].T
    gyro = gyro + rng.normal(0, np.radians(gyro_noise) * np.sqrt(RATE), (n, 3))
    if walk:
        steps = rng.normal(0, walk / np.sqrt(RATE), (n, 3))
        gyro = gyro + np.cumsum(steps, 0)
    lsb_a, lsb_g = G0 / 16384, np.radians(1 / 131)
    accel = np.round(accel / lsb_a) * lsb_a
    gyro = np.round(gyro / lsb_g) * lsb_g
    return np.arange(1, n + 1) / RATE, gyro, accel, names(t)


def write(path_, time, gyro, accel):
    """A structured .npy, the product's own column names."""
    header = ["time [s]"] + [f"gyro_{a} [rad/s]" for a in "xyz"] + [f"accel_{a} [m/s^2]" for a in "xyz"]
    data = np.zeros(len(time), dtype=[(name, "<f8") for name in header])
    for name, column in zip(header, [time, *gyro.T, *accel.T]):
        data[name] = column
    np.save(path_, data)
