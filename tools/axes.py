"""Axes of sensor noise drawn exactly from their definitions, and what can be known of them. Shares no code with the product.

Samples are interval means at step dt:
  quantization  (q_k - q_{k-1})/dt, q uniform on +-sqrt(3) Q
  white         N/sqrt(dt) n_k
  flicker       first differences stationary with covariance (B^2/2pi) d4[k^2 ln|k|]: circulant embedding
  random walk   b_{k-1} + K sqrt(dt) (n1/2 + n2/(2 sqrt 3))
  ramp          R (t_k - dt/2)
  gauss_markov  exact pair (end value, interval mean), stationary start
  warm          a exp(-t/tau), averaged over each sample
  line          A sinc(f dt) sin(2 pi f (t_k - dt/2) + phase)
Bounds and clearness are those of reference spectra summed over the DCT-II frequencies (bins of 0.5 % above j = 400).
"""
import numpy as np
from scipy.fft import rfft, irfft, next_fast_len
from scipy.optimize import minimize_scalar, nnls
from scipy.signal import lfilter
from scipy.special import zeta

_flicker_roots = {}


def _embedding(n):
    """Square roots of the eigenvalues of the circulant that embeds the flicker differences' covariance."""
    if n not in _flicker_roots:
        m = next_fast_len(n, real=True)
        k = np.arange(m + 3, dtype=np.longdouble)
        g = np.zeros(m + 3, dtype=np.longdouble)
        g[1:] = k[1:] ** 2 * np.log(k[1:])
        at = lambda i: g[np.abs(i)]
        i = np.arange(m + 1)
        r = at(i - 2) - 4 * at(i - 1) + 6 * at(i) - 4 * at(i + 1) + at(i + 2)
        # For large k the differences cancel: series of the fourth derivative, -2/k^2 - 1/k^4...
        far = i > 2000
        x = i[far].astype(np.longdouble)
        r[far] = -2 / x**2 - 2 / x**4
        r = (r / (2 * np.pi)).astype(float)
        circle = np.concatenate([r, r[-2:0:-1]])
        eigen = rfft(circle).real
        assert eigen.min() > -1e-9 * eigen.max(), eigen.min()
        _flicker_roots.clear()
        _flicker_roots[n] = (len(circle), np.sqrt(np.maximum(eigen, 0)))
    return _flicker_roots[n]


def flicker(rng, n, b):
    size, root = _embedding(n)
    white = rfft(rng.standard_normal(size))
    differences = irfft(white * root, size)[: n - 1]
    return b * np.concatenate([[0.0], np.cumsum(differences)])


def random_walk(rng, n, k, dt):
    n1, n2 = rng.standard_normal(n), rng.standard_normal(n)
    end = np.cumsum(n1)
    return k * np.sqrt(dt) * (end - n1 + n1 / 2 + n2 / (2 * np.sqrt(3)))


def gauss_markov(rng, n, sigma, tc, dt):
    h = dt / tc
    phi = np.exp(-h)
    v1 = 1 - phi**2
    if h < 0.01:
        v2 = 2 * h / 3 - h**2 / 2 + 7 * h**3 / 30 - h**4 / 12
    else:
        v2 = (2 * h - 3 + 4 * phi - phi**2) / h**2
    c = (1 - phi) ** 2 / h
    e1 = np.sqrt(v1) * rng.standard_normal(n)
    e2 = c / v1 * e1 + np.sqrt(max(v2 - c * c / v1, 0)) * rng.standard_normal(n)
    x0 = rng.standard_normal()
    x, _ = lfilter([1], [1, -phi], e1, zi=[phi * x0])
    before = np.concatenate([[x0], x[:-1]])
    return sigma * (before * (1 - phi) / h + e2)


def draw(rng, n, dt, mix):
    """One axis; mix is a dict of Q, N, B, K, R, GM (list of pairs), line (list of pairs)."""
    y = np.zeros(n)
    if mix.get("N"):
        y += mix["N"] / np.sqrt(dt) * rng.standard_normal(n)
    if mix.get("Q"):
        q = rng.uniform(-np.sqrt(3), np.sqrt(3), n + 1) * mix["Q"]
        y += np.diff(q) / dt
    if mix.get("B"):
        y += flicker(rng, n, mix["B"])
    if mix.get("K"):
        y += random_walk(rng, n, mix["K"], dt)
    if mix.get("R"):
        y += mix["R"] * dt * (np.arange(n) + 0.5)
    for sigma, tc in mix.get("GM", []):
        y += gauss_markov(rng, n, sigma, tc, dt)
    if mix.get("warm"):
        a, tau = mix["warm"]
        e = np.exp(-dt * np.arange(n + 1) / tau)
        y += a * tau / dt * (e[:-1] - e[1:])
    for a, f in mix.get("line", []):
        t = dt * (np.arange(n) + 0.5)
        y += a * np.sinc(f * dt) * np.sin(2 * np.pi * f * t + rng.uniform(0, 2 * np.pi))
    return y


def temperature(rng, n, dt, mix):
    """What a thermometer says.

    While the axis warms up 25 C rising by 10 K with the warm-up's time and 0.02 K of noise; else about 25 C a sine of 5 K and
    1.3 periods, a ramp of 10 K (both with 0.01 K of noise) or a random walk of 0.1 K/sqrt(s).
    """
    t = dt * (np.arange(n) + 0.5)
    if mix.get("warm"):
        _, tau = mix["warm"]
        return 25 + 10 * (1 - np.exp(-t / tau)) + 0.02 * rng.standard_normal(n)
    profile = mix["temperature"][0]
    if profile == "walk":
        return 25 + 0.1 * np.sqrt(dt) * np.cumsum(rng.standard_normal(n))
    shape = np.sin(2.6 * np.pi * t / t[-1] + rng.uniform(0, 2 * np.pi)) * 5 if profile == "sine" else 10 * t / t[-1]
    return 25 + shape + 0.01 * rng.standard_normal(n)


# ---- what can be known -------------------------------------------------------------------------------------------

def frequencies(n):
    """u = f dt of every coefficient or narrow bin, and their number."""
    edges = [400]
    while edges[-1] < n - 1:
        edges.append(min(n - 1, max(edges[-1] + 1, int(edges[-1] * 1.005))))
    edges = np.array(edges)
    u = np.concatenate([np.arange(1, min(401, n)), (edges[:-1] + 1 + edges[1:]) / 2]) / (2 * n)
    w = np.concatenate([np.ones(min(400, n - 1)), np.diff(edges)])
    return u, w


def shape(term, u, dt, tc=None):
    """S(f)/theta^2 of a term."""
    s2 = np.sin(np.pi * u) ** 2
    if term == "Q":
        return 4 * s2 / dt
    if term == "N":
        return np.ones_like(u)
    if term == "B":
        return s2 * dt / (2 * np.pi**3) * (zeta(3, u) + zeta(3, 1 - u))
    if term == "K":
        return dt**2 * (1 / (4 * s2) - 1 / 6)
    h = dt / tc
    phi = np.exp(-h)
    c0 = 2 * (h - 1 + phi) / h**2 if h > 1e-4 else 1 - h / 3
    c1 = ((1 - phi) / h) ** 2
    return dt * (c0 + 2 * c1 * (np.cos(2 * np.pi * u) - phi) / ((1 - phi) ** 2 + 4 * phi * s2))


def parts(mix):
    out = [(t, mix[t], None) for t in "QNBK" if mix.get(t)]
    return out + [("GM", s, tc) for s, tc in mix.get("GM", [])]


def spectrum(mix, u, dt):
    return sum(v**2 * shape(t, u, dt, tc) for t, v, tc in parts(mix))


def bounds(mix, n, dt):
    """Relative Cramer-Rao bounds: names like Q, N, B, K, sigma1, Tc1."""
    u, w = frequencies(n)
    s = spectrum(mix, u, dt)
    names, columns = [], []
    gm = 0
    for t, v, tc in parts(mix):
        columns.append(2 * v**2 * shape(t, u, dt, tc) / s)
        if t == "GM":
            gm += 1
            names += [f"sigma{gm}", f"Tc{gm}"]
            e = 1e-4
            d = (shape(t, u, dt, tc * np.exp(e)) - shape(t, u, dt, tc * np.exp(-e))) / (2 * e)
            columns.append(v**2 * d / s)
        else:
            names.append(t)
    c = np.array(columns)
    j = 0.5 * (c * w) @ c.T
    return dict(zip(names, np.sqrt(np.diag(np.linalg.inv(j)))))


def clearness(mix, n, dt):
    """sqrt of the expected likelihood ratio of each term, the best rival of Q, N, B, K and the mixture's own GM."""
    u, w = frequencies(n)
    s = spectrum(mix, u, dt)
    out = {}
    gms = mix.get("GM", [])
    names = [t for t in "QNBK" if mix.get(t)] + [f"GM{i+1}" for i in range(len(gms))]
    for name in names:
        singles = [shape(t, u, dt) for t in "QNBK" if t != name]
        others = [tc for i, (_, tc) in enumerate(gms) if f"GM{i+1}" != name]

        def rival(times):
            basis = np.array(singles + [shape("GM", u, dt, tc) for tc in times]).T
            model = s.copy()
            best = np.inf
            for _ in range(60):
                weight = np.sqrt(w) / model
                scale = np.linalg.norm(basis * weight[:, None], axis=0)
                x, _ = nnls(basis * weight[:, None] / scale, s * weight)
                new = basis @ (x / scale)
                new = np.maximum(new, 1e-300)
                r = s / new
                value = np.sum(w * (r - 1 - np.log(r)))
                model = new
                if abs(best - value) < 1e-6 * (1 + value):
                    best = value
                    break
                best = value
            return best

        if not others:
            value = rival([])
        elif len(others) == 1:
            grid = np.log(np.geomspace(10 * dt, n * dt / 4, 30))
            values = [rival([np.exp(g)]) for g in grid]
            i = int(np.argmin(values))
            result = minimize_scalar(
                lambda g: rival([np.exp(g)]),
                bounds=(grid[max(i - 1, 0)], grid[min(i + 1, 29)]),
                method="bounded",
            )
            value = min(result.fun, values[i])
        else:
            value = rival(others)
        out[name] = float(np.sqrt(max(value, 0)))
    return out


if __name__ == "__main__":
    rng = np.random.default_rng(1)
    n, dt = 2**14, 0.02
    import allantools

    for mix, law in [
        ({"N": 1}, lambda t: 1 / t),
        ({"Q": 0.1}, lambda t: 3 * 0.01 / t**2),
        ({"B": 1}, lambda t: 2 * np.log(2) / np.pi + 0 * t),
        ({"K": 1}, lambda t: t / 3),
        ({"GM": [(1, 2.0)]}, lambda t: 4 / t * (1 - 1 / t * (3 - 4 * np.exp(-t / 2) + np.exp(-t)))),
    ]:
        total = 0
        for _ in range(60):
            y = draw(rng, n, dt, mix)
            tau, dev, _, _ = allantools.oadev(y, 1 / dt, "freq", [dt, 2 * dt, 8 * dt, 64 * dt])
            total = total + dev**2 / 60
        print(mix, total / law(tau))
    print(bounds({"N": 1, "B": 0.3, "K": 0.06}, 180000, 0.02))
    print(clearness({"N": 1, "B": 0.3, "K": 0.06}, 180000, 0.02))
    print(clearness({"N": 1, "GM": [(0.8, 5)]}, 180000, 0.02))
