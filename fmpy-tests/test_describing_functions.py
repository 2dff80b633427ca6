"""The response of every nonlinearity to a sine is that of the literature: first harmonic within 0.1 %, third within 1 %.

The formulas and their sources are in `reference/describing_functions.py`: A sin(theta) gives the sum of Im(A N_n exp(i n theta)).
The FMU is stepped through a sine of straight pieces, 2000 a period, settled; N_n is read off the last period. Pieces weaken the
sine by sinc^2(1/2000) = 1 - 8e-7 and add nothing below the 1999th harmonic; kinks in the response cause an error of (1/2000)^2.
Jumps cause more: the quantiser gets 20 000 pieces, which leaves an error of some 1e-5 of the sine in its harmonics.

Three places, three ways to isolate the nonlinearity:

    ahead of the servo    position is the operator's output behind the linear response: divide by H(n f) of equation (1)
    behind the drive      the operator's input is the sine  A |H| sin(theta + arg H),  exactly
    inside the loop       by harmonic balance. With L(s) = 1 + 2 zeta s / omega + (s / omega)^2 the drive's equation is, order 2,
                              L d + nonlinear terms = x,  x = k c     hence at each n:   terms_n = X_n - L(i n w) D_n
                          where the drive is close enough to a sine: w well above omega, with a third harmonic below 1/1000
                          of the first. And quasi-statically, omega = 1e5 rad/s: then d is the static balance of forces, so that a
                          dead zone and friction act as play of twice their width, a stop as a saturation, a rate limit as a rate limiter.
"""

import numpy as np
import pytest

import bact
from reference import describing_functions as df

FIRST, THIRD = 1e-3, 1e-2  # relative to the harmonic itself
SERVO = bact.BY_NAME["te-late-unloaded"]
FREQUENCY_HZ = 2.0
SAMPLES, FEW_SAMPLES, MANY_SAMPLES = 2000, 500, 20_000
LIMITER_PERIODS = 16  # the initial state of a rate limiter decays by at least a half per period: to 1e-5
AMPLITUDES = (0.65, 1.0, 2.0, 5.0)  # relative to the operator's input; the harmonic itself is about one half
SLOW = {"source": "custom", "order": "second", "custom.k": 1.0, "custom.omega": 1e5, "custom.zeta": 0.7}
BALANCE = {"source": "custom", "order": "second", "custom.k": 1.0, "custom.omega": 50.0, "custom.zeta": 0.7}

every_amplitude = pytest.mark.parametrize("amplitude", AMPLITUDES)


def harmonics(actuator, parameters, amplitude, frequency_hz, numbers, periods=4, samples=SAMPLES, output="position"):
    """N_n for these n, of the last period; n = 0 is the mean over the amplitude."""
    theta = 2.0 * np.pi * np.arange(samples * periods + 1) / samples
    command = amplitude * np.sin(theta)
    h = 1.0 / (frequency_hz * samples)
    actuator.restart(parameters)
    found = actuator.run(command[:-1], h, np.diff(command) / h, outputs=(output,))[-samples:]
    angle = theta[-samples:]
    return [np.mean(found * np.exp(-1j * n * angle)) * (2j if n else 1.0) / amplitude for n in numbers]


def assert_harmonics(found, expected, tolerances=(FIRST, THIRD)):
    for measured, exact, tolerance in zip(found, expected, tolerances):
        assert abs(measured - exact) <= tolerance * abs(exact), (measured, exact)


# Ahead of the servo

AHEAD = {
    "command_limit": ({"min": -0.6, "max": 0.6}, lambda a, n: df.saturation(a, 0.6, n)),
    "command_dead_zone": ({"half_width": 0.4}, lambda a, n: df.dead_zone(a, 0.4, n)),
    "command_backlash": ({"gap": 0.8}, lambda a, n: df.play(a, 0.8, n)),
}


def parameters_of(effect, values, **more):
    return {f"{effect}.{name}": value for name, value in values.items()} | more


def ahead_of_the_servo(actuator, parameters, amplitude, frequency_hz, numbers, *settling):
    """The harmonics of the effect ahead of the servo: those of the position divided by the linear response."""
    found = harmonics(actuator, {"set_number": SERVO.number, **parameters}, amplitude, frequency_hz, numbers, *settling)
    return [value / bact.frequency_response(SERVO, bact.THIRD, n * frequency_hz) for value, n in zip(found, numbers)]


@every_amplitude
@pytest.mark.parametrize("effect", AHEAD)
def test_operators_on_the_command(shared, effect, amplitude):
    values, exact = AHEAD[effect]
    found = ahead_of_the_servo(shared, parameters_of(effect, values), amplitude, FREQUENCY_HZ, (1, 3))
    assert_harmonics(found, [exact(amplitude, n) for n in (1, 3)])


@every_amplitude
@pytest.mark.parametrize("ratio", [0.6, 1.4])
def test_the_one_sided_gain_makes_a_mean_and_even_harmonics(shared, ratio, amplitude):
    numbers = (1, 0, 2, 4)
    found = ahead_of_the_servo(shared, {"asymmetric_gain.ratio": ratio}, amplitude, FREQUENCY_HZ, numbers)
    assert_harmonics(found, [df.asymmetric_gain(amplitude, ratio, n) for n in numbers], (FIRST, FIRST, THIRD, THIRD))


@pytest.mark.parametrize("amplitude", [1.0, 6.0])
@pytest.mark.parametrize("multiple", [0.9, 1.1, 1.4, 1.8, 2.5, 4.0])
def test_the_rate_limit_of_the_command_below_its_onset_partly_and_fully_limiting(shared, multiple, amplitude):
    rate = 2.0 * np.pi * amplitude * FREQUENCY_HZ / multiple
    limits = {"command_rate_limit.up": rate, "command_rate_limit.down": rate}
    found = ahead_of_the_servo(shared, limits, amplitude, FREQUENCY_HZ, (1, 3), LIMITER_PERIODS, FEW_SAMPLES)
    exact = [df.rate_limiter(amplitude, FREQUENCY_HZ, rate, n) for n in (1, 3)]
    assert_harmonics(found, exact if multiple > 1 else exact[:1])


def test_a_delay_turns_every_sine_by_its_time(shared):
    """1e-6, due to the straight pieces alone."""
    for delay_s in (0.0007, 0.0123, 0.31):
        found = ahead_of_the_servo(shared, {"delay.time": delay_s}, 3.0, FREQUENCY_HZ, (1,))
        assert_harmonics(found, [np.exp(-2j * np.pi * FREQUENCY_HZ * delay_s)], [1e-6])


# Behind the drive


def behind_the_drive(amplitude, exact, numbers=(1, 3)):
    """Harmonics over the command's amplitude, for an operator on the drive position."""
    response = bact.frequency_response(SERVO, bact.THIRD, FREQUENCY_HZ)
    input_amplitude, phase = amplitude * abs(response), np.angle(response)
    return [abs(response) * exact(input_amplitude, n) * np.exp(1j * n * phase) for n in numbers]


@every_amplitude
@pytest.mark.parametrize("gap", [0.3, 0.8])
def test_the_free_play_of_the_surface(shared, gap, amplitude):
    found = harmonics(shared, {"set_number": SERVO.number, "backlash.gap": gap}, amplitude, FREQUENCY_HZ, (1, 3))
    assert_harmonics(found, behind_the_drive(amplitude, lambda a, n: df.play(a, gap, n)))


@pytest.mark.parametrize("step, amplitude", [(0.3, 0.65), (0.3, 1.0), (0.3, 2.0), (0.8, 0.65), (0.8, 1.0), (0.8, 5.0)])
def test_the_steps_of_the_measurement(shared, step, amplitude):
    """Amplitudes whose third harmonic does not nearly cancel: it is above 1e-2 of the sine."""
    parameters = {"set_number": SERVO.number, "quantisation.step": step}
    found = harmonics(shared, parameters, amplitude, FREQUENCY_HZ, (1, 3), 2, MANY_SAMPLES)
    assert_harmonics(found, behind_the_drive(amplitude, lambda a, n: df.quantiser(a, step, n)))


def test_the_lag_and_the_mode_have_their_transfer_functions(shared):
    """1 / (1 + i w tau)  and  1 + gain (w_m^2 / (w_m^2 - w^2 + 2 i z w_m w) - 1), within 1e-5 for the pieces."""
    w, tau, mode, damping, gain = 2.0 * np.pi * FREQUENCY_HZ, 0.03, 2.0 * np.pi * 3.0, 0.3, 0.7
    servo = bact.frequency_response(SERVO, bact.THIRD, FREQUENCY_HZ)
    surface = servo * (1.0 + gain * (mode**2 / (mode**2 - w**2 + 2j * damping * mode * w) - 1.0))
    parameters = {"set_number": SERVO.number, "sensor_lag.time": tau, "structural_mode.gain": gain,
                  "structural_mode.damping": damping, "structural_mode.frequency": mode / (2.0 * np.pi)}  # fmt: skip
    for output, exact in (("deflection", surface), ("position", surface / (1.0 + 1j * w * tau))):
        assert_harmonics(harmonics(shared, parameters, 3.0, FREQUENCY_HZ, (1,), periods=12, output=output), [exact], [1e-5])


# Inside the loop, quasi-statically

INSIDE = {
    "dead_zone": ({"half_width": 0.4}, lambda a, n: df.play(a, 0.8, n)),
    "coulomb_friction": ({"level": 0.4}, lambda a, n: df.play(a, 0.8, n)),
    "position_limit": ({"min": -0.6, "max": 0.6}, lambda a, n: df.saturation(a, 0.6, n)),
}


@every_amplitude
@pytest.mark.parametrize("effect", INSIDE)
def test_slowly_the_loop_is_a_balance_of_forces(shared, effect, amplitude):
    values, exact = INSIDE[effect]
    found = harmonics(shared, parameters_of(effect, values, **SLOW), amplitude, 1.0, (1, 3))
    assert_harmonics(found, [exact(amplitude, n) for n in (1, 3)])


@pytest.mark.parametrize("amplitude", [1.0, 6.0])
@pytest.mark.parametrize("multiple", [0.9, 1.1, 1.4, 1.8, 2.5, 4.0])
def test_slowly_the_rate_limit_is_a_rate_limiter(shared, multiple, amplitude):
    rate = 2.0 * np.pi * amplitude / multiple
    limits = {**SLOW, "rate_limit.up": rate, "rate_limit.down": rate}
    found = harmonics(shared, limits, amplitude, 1.0, (1, 3), LIMITER_PERIODS, FEW_SAMPLES)
    exact = [df.rate_limiter(amplitude, 1.0, rate, n) for n in (1, 3)]
    assert_harmonics(found, exact if multiple > 1 else exact[:1])


def onset(actuator, parameters, amplitude, expected_hz):
    """The lowest frequency, on a grid of 0.4 %, at which a sine saturates something in its second period."""
    theta = 2.0 * np.pi * np.arange(FEW_SAMPLES + 1) / FEW_SAMPLES
    values, differences = amplitude * np.sin(theta[:-1]), amplitude * np.diff(np.sin(theta))
    for frequency_hz in expected_hz * np.arange(0.98, 1.02, 0.004):
        h = 1.0 / (FEW_SAMPLES * frequency_hz)
        actuator.restart(parameters)
        actuator.run(values, h, differences / h)
        for value, difference in zip(values, differences):
            actuator.run([value], h, [difference / h])
            if actuator["saturated"]:
                return frequency_hz
    return np.inf


@pytest.mark.parametrize("rate", [30.0, 120.0])
@pytest.mark.parametrize("amplitude", [1.0, 4.0, 8.0])
def test_rate_limiting_begins_at_the_rate_over_the_largest_rate_of_the_sine(shared, amplitude, rate):
    """f = R / (2 pi A), within 1 % where the drive follows its command, omega = 1e5."""
    expected_hz = df.rate_limit_onset_frequency(amplitude, rate)
    found_hz = onset(shared, {**SLOW, "rate_limit.up": rate, "rate_limit.down": rate}, amplitude, expected_hz)
    assert abs(found_hz / expected_hz - 1.0) <= 0.01


def test_with_a_tabulated_servo_the_drive_makes_the_amplitude(shared):
    """The same with A |H(f)| for A: at 2 Hz the gain of this servo is 1.02. Within 1 %."""
    amplitude = 4.0
    at_the_drive = amplitude * abs(bact.frequency_response(SERVO, bact.THIRD, FREQUENCY_HZ))
    rate = 2.0 * np.pi * FREQUENCY_HZ * at_the_drive
    limits = {"set_number": SERVO.number, "rate_limit.up": rate, "rate_limit.down": rate}
    assert abs(onset(shared, limits, amplitude, FREQUENCY_HZ) / FREQUENCY_HZ - 1.0) <= 0.01


# Inside the loop, by harmonic balance


def balance(actuator, effect, values, amplitude, multiple, periods):
    """(w / omega, X_n and D_n [deg] for n = 1, 3) with the sine at so many times omega."""
    omega, samples = BALANCE["custom.omega"], 200
    frequency_hz = multiple * omega / (2.0 * np.pi)
    found = harmonics(actuator, parameters_of(effect, values, **BALANCE), amplitude, frequency_hz, (1, 3), periods, samples)
    return multiple, (amplitude * np.sinc(1.0 / samples) ** 2, 0.0), [amplitude * value for value in found]


def inertia_and_damping(ratio):
    """L - 1 at s = i w: the linear part of the drive's equation."""
    return 2j * BALANCE["custom.zeta"] * ratio - ratio**2


@pytest.mark.parametrize("amplitude", [0.8, 1.0, 1.5])
@pytest.mark.parametrize("effect, key, nonlinearity", [
    ("dead_zone", "half_width", df.dead_zone), ("acceleration_limit", "value", df.saturation)])  # fmt: skip
def test_the_nonlinear_drive_by_harmonic_balance(shared, effect, key, nonlinearity, amplitude):
    """(L - 1) d = drive of the error e = x - d. At 20 omega d is 1/400 of x, so the error is the sine, and e_3 = -d_3 is negligible."""
    width = 0.5
    value = width if effect == "dead_zone" else width * BALANCE["custom.omega"] ** 2
    ratio, x, d = balance(shared, effect, {key: value}, amplitude, 20.0, 200)
    error = x[0] - d[0]
    first = inertia_and_damping(ratio) * d[0] / error
    third = inertia_and_damping(3 * ratio) * d[1] / (error * (error / abs(error)) ** 2)
    assert_harmonics((first, third), [nonlinearity(abs(error), width, n) for n in (1, 3)])


@pytest.mark.parametrize("level", [0.002, 0.005, 0.01])
def test_friction_in_motion_by_harmonic_balance(shared, level):
    """L d + level sign(v) = x at 20 omega. Friction up to 1/400 of the command: its harmonics shift the phase of v by 0.3 of that share."""
    ratio, x, d = balance(shared, "coulomb_friction", {"level": level}, 4.0, 20.0, 200)
    first = (x[0] - (1.0 + inertia_and_damping(ratio)) * d[0]) / d[0]
    third = -(1.0 + inertia_and_damping(3 * ratio)) * d[1] / (d[0] * (d[0] / abs(d[0])) ** 2)
    assert_harmonics((first, third), [df.coulomb_friction(abs(d[0]), level, n) for n in (1, 3)])


@pytest.mark.parametrize("amplitude", [1.0, 2.0, 3.0])
@pytest.mark.parametrize("cubic", [0.05, -0.05])
def test_the_cubic_spring_by_harmonic_balance(shared, cubic, amplitude):
    """L d + cubic d^3 = x at 2 omega, where d is 1/4 of x: cubic d^2 stays below 0.03, and d_3 below 2e-4 of d_1."""
    ratio, x, d = balance(shared, "amplitude_gain", {"cubic": cubic}, amplitude, 2.0, 40)
    first = (x[0] - (1.0 + inertia_and_damping(ratio)) * d[0]) / d[0]
    third = -(1.0 + inertia_and_damping(3 * ratio)) * d[1] / (d[0] * (d[0] / abs(d[0])) ** 2)
    assert_harmonics((first, third), [df.cubic(abs(d[0]), cubic, n) for n in (1, 3)])
