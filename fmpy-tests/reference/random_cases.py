"""Random records for the reference: any effects together, any command, with failures and loads. Seeds are printed.

    python -m reference.random_cases 100 2 500     from seed 100, two effects each, 500 cases

runs each case twice, with two step sizes, and prints those that fail, are slow, or differ.
"""

import sys
import time as clock

import numpy as np

from .plant import simulate

# Ranges (lower, upper) that make an effect visible against commands of 0.5 to 8 deg; a third entry: logarithmic.
RANGES = {
    "delay": {"time": (0.001, 0.05)},
    "command_limit": {"min": (-8.0, -1.0), "max": (1.0, 8.0)},
    "command_rate_limit": {"up": (20.0, 200.0), "down": (20.0, 200.0)},
    "command_dead_zone": {"half_width": (0.05, 1.0)},
    "command_backlash": {"gap": (0.05, 2.0)},
    "asymmetric_gain": {"ratio": (0.5, 1.5)},
    "gain_drift": {"rate": (-0.3, 0.3)},
    "dead_zone": {"half_width": (0.02, 1.0)},
    "amplitude_gain": {"cubic": (-0.002, 0.01)},
    "hinge_load": {"stiffness": (-0.3, 0.5), "bias": (-1.0, 1.0)},
    "coulomb_friction": {"level": (0.02, 1.0)},
    "acceleration_limit": {"value": (3000.0, 60000.0)},
    "rate_limit": {"up": (20.0, 200.0), "down": (20.0, 200.0)},
    "position_limit": {"min": (-8.0, -1.0), "max": (1.0, 8.0)},
    "backlash": {"gap": (0.05, 2.0)},
    "structural_mode": {"frequency": (5.0, 80.0), "damping": (0.01, 0.2), "gain": (-0.5, 1.0)},
    "sensor_lag": {"time": (1e-4, 0.05, "logarithmic")},
    "sensor_bias": {"offset": (-1.0, 1.0), "drift": (-0.2, 0.2)},
    "chatter": {"amplitude": (0.05, 0.5), "frequency": (5.0, 30.0), "phase": (-3.0, 3.0)},
    "quantisation": {"step": (0.01, 0.2)},
}


def draw(seed, count, samples=200, sample_time=0.005):
    """One case: keyword arguments of simulate, with `count` random effects."""
    random = np.random.default_rng(seed)

    def value(lower, upper, kind=None):
        if kind:
            return float(np.exp(random.uniform(np.log(lower), np.log(upper))))
        return float(random.uniform(lower, upper))

    names = [str(name) for name in random.choice(list(RANGES), size=count, replace=False)]
    effects = {name: {key: value(*limits) for key, limits in RANGES[name].items()} for name in names}
    base = (value(0.7, 1.3), value(6898.0, 2.97e8, "logarithmic"), value(80.0, 300.0), value(0.3, 1.2))
    time = np.arange(samples) * sample_time
    size = value(0.5, 8.0)
    command = size * [
        lambda: np.sin(2.0 * np.pi * (value(0.3, 2.0) + value(0.5, 4.0) * time) * time),
        lambda: np.repeat(random.uniform(-1.0, 1.0, samples // 10 + 1), 10)[:samples],
        lambda: np.floor(time / value(0.1, 0.3)) % 2.0,
        lambda: 0.5 * random.standard_normal(samples),
    ][random.integers(4)]()
    load = failure = None
    if random.random() < 0.3:
        load = np.repeat(random.uniform(-2.0, 2.0, samples // 20 + 1), 20)[:samples]
    if random.random() < 0.3:
        failure = np.zeros(samples, int)
        begin, end = sorted(random.integers(0, samples, 2))
        failure[begin:end] = random.integers(1, 5 if "position_limit" in effects else 3)
    return dict(base=base, effects=effects, time=time, command=command, load=load, failure=failure,
                order=int(random.integers(2, 4)), initial_position=float(random.choice([0.0, value(-1.0, 1.0)])))


def difference(one, other):
    """Largest difference of drive and measured position, relative to the peak."""
    peak = max(np.abs(one["drive"]).max(), 1e-3)
    return max(np.abs(one[name] - other[name]).max() for name in ("drive", "deflection", "unquantised")) / peak


def main(first, count, cases):
    worst, longest = 0.0, 0.0
    for seed in range(first, first + cases):
        case = draw(seed, count)
        start = clock.perf_counter()
        try:
            result = simulate(**case)
            seconds = clock.perf_counter() - start
            change = difference(result, simulate(**case, refinement=1.7))
        except (RuntimeError, ArithmeticError, ValueError) as error:
            print(f"seed {seed}: {error!r} with {case['effects']}")
            continue
        worst, longest = max(worst, change), max(longest, seconds)
        if change > 1e-10 or seconds > 2.0:
            print(f"seed {seed}: changes by {change:.1e}, takes {seconds:.2f} s, with {case['effects']}")
    print(f"seeds {first}-{first + cases - 1}, {count} effects: largest change {worst:.1e}, longest {longest:.2f} s")


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:4]))
