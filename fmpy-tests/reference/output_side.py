"""The output side of the chain: play, structural mode and sensor lag driven by the drive position d(t).

    backlash         y follows d with total free play gap, |d - y| <= gap/2;  y(0) = d(0)
    structural_mode  m'' = w_m^2 (y - m) - 2 z w_m m',  w_m = 2 pi f,  y2 = y + gain (m - y);  m(0) = y(0), m'(0) = 0
    sensor_lag       tau s' = y2 - s,  s(0) = y2(0)

Nothing here acts back on the loop, so that d(t) is complete, a polynomial per stretch, when it arrives. The play is
exact: a stretch is cut where d turns and where contact begins. The two filters are linear and are solved by the same
collocation as the loop, on pieces short enough for their own frequencies.
"""

import numpy as np

from . import spectral

# exp(-40) = 4e-18: the state of a lag that many time constants ago is forgotten.
FORGOTTEN = 40.0


class OutputSide:
    def __init__(self, effects, initial_d, refinement=1.0):
        self.half_gap = 0.5 * effects["backlash"]["gap"]
        mode = effects["structural_mode"]
        self.mode_gain, self.mode_damping = mode["gain"], mode["damping"]
        self.mode_frequency = 2.0 * np.pi * mode["frequency"]  # rad/s
        self.lag = effects["sensor_lag"]["time"]
        self.refinement = refinement
        self.y = self.m = self.deflection = self.measured = initial_d
        self.m_rate = 0.0

    def advance(self, stretch):
        """Follow one stretch of d; afterwards `deflection` and `measured` are those at its end."""
        for duration, y in self._play(stretch):
            self._filter(duration, y)

    def _play(self, stretch):
        """Cut the stretch into pieces (duration, y on the nodes) on which y is one polynomial."""
        if self.half_gap == 0.0:
            self.y = float(stretch.d[-1])
            yield stretch.duration, stretch.d
            return
        turns = [0.0, *spectral.sign_changes(stretch.v), 1.0]
        for start, end in zip(turns, turns[1:]):
            d = spectral.restriction(start, end) @ stretch.d
            duration = (end - start) * stretch.duration
            side = self.half_gap if d[-1] > d[0] else -self.half_gap
            # Positive: remaining distance of d from the side of the play that it moves towards.
            distance = (self.y + side - d) * np.sign(side)
            if distance[-1] >= 0.0:
                yield duration, np.full(len(d), self.y)
                continue
            contact = spectral.root_between(distance, 0.0, 1.0) if distance[0] > 0.0 else 0.0
            if contact > 0.0:
                yield contact * duration, np.full(len(d), self.y)
            self.y = float(d[-1] - side)
            yield (1.0 - contact) * duration, spectral.restriction(contact, 1.0) @ d - side

    def _filter(self, duration, y):
        if self.mode_gain == 0.0:
            self.deflection = float(y[-1])
            self._lag(duration, y)
            return
        count = int(np.ceil(self.refinement * duration * self.mode_frequency * max(1.0, 2.0 * self.mode_damping)
                            / spectral.LARGEST_PHASE)) or 1
        for i in range(count):
            part = spectral.restriction(i / count, (i + 1) / count) @ y
            deflection = part + self.mode_gain * (self._mode(duration / count, part) - part)
            self.deflection = float(deflection[-1])
            self._lag(duration / count, deflection)

    def _mode(self, h, y):
        """m on the nodes: a = m'' solves a + 2 z w m' + w^2 m = w^2 y."""
        w = self.mode_frequency
        damping = 2.0 * self.mode_damping * w
        matrix = spectral.IDENTITY + damping * h * spectral.INTEGRAL + (w * h) ** 2 * spectral.INTEGRAL_TWICE
        coasting = self.m + h * self.m_rate * spectral.NODES
        a = np.linalg.solve(matrix, w * w * (y - coasting) - damping * self.m_rate)
        m = coasting + h * h * (spectral.INTEGRAL_TWICE @ a)
        self.m, self.m_rate = float(m[-1]), float(self.m_rate + h * (spectral.INTEGRAL[-1] @ a))
        return m

    def _lag(self, duration, y):
        """s at the end: a = s' solves a + s / tau = y / tau. A start that is forgotten by then is skipped."""
        if self.lag == 0.0:
            self.measured = float(y[-1])
            return
        start = 0.0
        if duration > FORGOTTEN * self.lag:
            start = 1.0 - FORGOTTEN * self.lag / duration
            self.measured = float(spectral.interpolate(y, start))
        length = (1.0 - start) * duration
        count = int(np.ceil(self.refinement * length / self.lag / spectral.LARGEST_PHASE)) or 1
        h = length / count / self.lag
        for i in range(count):
            part = spectral.restriction(start + (1.0 - start) * i / count, start + (1.0 - start) * (i + 1) / count)
            matrix = spectral.IDENTITY + h * spectral.INTEGRAL
            a = np.linalg.solve(matrix, part @ y - self.measured)
            self.measured = float(self.measured + h * (spectral.INTEGRAL[-1] @ a))
