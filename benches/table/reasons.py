"""Texts of the page that no run can measure: what a row does, and why ours is behind where it is (from profiles)."""

# By row.
NOTES = {
    "fmu": (
        "The unit in C (`benches/against_c/second_order.c`) checks nothing and is of second order; the FMU is as it starts, of third. The unit has "
        "neither effects nor a delay: those lines are held against its linear step, which is less work. Processor time; of two threads or processes "
        "the steps per time of one, by the clock, where more is better. What the instructions are spent on: [hard real time](real-time.md)."
    ),
    "fmpy": ("What fmpy itself takes in Python is its time with an FMU that does nothing (`benches/empty_fmu`); what is above that is ours."),
    "pythonfmu": ("Exact transitions on both sides, computed once for a step size."),
    "linear": (
        "Third order, command held, 200 samples/s. `lfilter` computes the position alone; the library position, deflection and rate. python-control "
        "is given the sampled system. In files, imports of Python are not counted, the start of the program is."
    ),
    "nonlinear": (
        "Runge-Kutta of order 4 in 5 inner steps of 1 ms with the limit or the play applied after each is an approximation; ours finds the instants "
        "at which the mode changes. `agreement` is what the approximation costs."
    ),
    "simulators": (
        "`actuator export` writes the model for both. JSBSim runs 5 frames of 1 ms for each sample, MuJoCo the steps that the export chose; ours is "
        "the FMU in fmpy, whose time is fmpy's."
    ),
    "frf": ("Ours checks and hashes the file and estimates by local polynomials with standard errors; theirs reads it and estimates by Welch's method."),
    "fit": (
        "Output error of k, omega, zeta on records with noise, coloured under load. Ours whitens the noise and states standard errors; theirs takes "
        "it as white. In memory: processor time, ours on one thread."
    ),
    "diagnosis": (
        "A search is one hypothesis from one start, by least squares, refits to all records but one among them. All of a diagnosis is divided by its "
        "searches: the screening of every effect on a ladder of starts, judging on unseen records, packaging and stepping two FMUs, and the page. "
        "Theirs is one search for each effect, on a servo in numba, and judges nothing. Processor time on one thread."
    ),
    "monte-carlo": ("k, omega and zeta spread by 10 %; a square wave of 2 deg for 1 s. No command of the program does this: it is the library, on all cores."),
    "program": ("Theirs is what a script pays before its first line, with its imports compiled and cached."),
    "growth-instances": (
        "Each time is that of all instances together, alive at once. An instance of ours has some 4 kB, one of the unit in C 72 bytes: beyond a "
        "thousand of them ours no longer lie in the caches next to the processor."
    ),
    "growth-effects": (
        "The first effect of the chain, the first two, and so on, each at a strength at which it acts; random commands of up to 8 deg at 200 Hz. "
        "Processor time."
    ),
    "growth-searches": ("A point is a case of the suite of hidden effects (one effect, two, something outside the library)."),
    "campaign": (
        "Records are generated before, and read from files. Responses, fits, their combination under 17 conditions, and the page; beyond 200 000 "
        "samples for a condition no diagnosis is made. Theirs is Welch's method and a fit of the same files, without the page, scaled from some of "
        "them."
    ),
}

# Solved to rounding error between located events.
_SEGMENTS = (
    "With effects, a step is divided into segments of at most 1.2 time constants and at events; the motion of each is a power series, in which "
    "the first event is searched. Of the samples of a profile of the unit's step 48 % fall on bounds and crossings, nearly half of those on locating "
    "them to rounding, 19 % on the coefficients of the motion, 11 % on the states at the ends of segments. The peer takes 5 short steps of fixed size, whatever happens in them."
)

_DIAGNOSIS = (
    "Two fifths of the samples of a profile (with pairs three fifths) are steps with effects, where no event is met one linear map each, else series over segments, "
    "each of which costs more than the inner steps of the peer (rate limit and backlash, above); the rest is spread over screening, whitening, regressions on unseen samples, inspection, and "
    "the compression of the FMUs."
)

_RESPONSE = (
    "At 1e4 samples a quarter of a profile is the kernel's: the start of the process, and memory that is touched for the first time. A fifth is "
    "the inspection of the record (a regression on Laguerre filters and its like), a tenth reading; local polynomials with standard errors are "
    "most of the rest. Theirs runs in a process that has started, and inspects nothing."
)

# By key of a line; stated only if that line is behind.
REASONS = {
    "fmu.step": (
        "Of the 355 instructions of set, step and get (callgrind; the unit in C takes 57) 259 are what the three calls check: handle, owner, phase, "
        "value references, type and range of the value, communication point, whether the output is finite. The model itself takes 96."
    ),
    "fmu.state": ("274 instructions against 34: both calls look up and check the instance and the state before they copy; the unit copies without looking."),
    "fmu.life": (
        "The unit calls calloc and free. Ours enters a handle into the table by which calls find it, takes over the start values of all variables "
        "into some 4 kB of memory, and works out the constants of the actuator. Not profiled part by part."
    ),
    "fmu.effects": ("The unit in C has no effects: what stands beside it is its linear step. 7 350 instructions a step: why: rate limit and backlash, below."),
    "fmu.delay": ("The unit in C has no delay: what stands beside it is its linear step."),
    "diagnosis.plain": _DIAGNOSIS,
    "diagnosis.pair": _DIAGNOSIS,
    "diagnosis.outside": _DIAGNOSIS,
    "diagnosis.outside-play": _DIAGNOSIS,
    "diagnosis.long": _DIAGNOSIS,
    "linear.scipy.signal.lfilter": (
        "Some 220 instructions a sample (callgrind): half of them ask whether anything but the linear part acts and move three states, a quarter "
        "stores position, deflection and rate, a sixth computes them. `lfilter` is one recursion of the position, and knows that nothing else can "
        "happen."
    ),
    "nonlinear.rate_limit": _SEGMENTS,
    "nonlinear.backlash": _SEGMENTS,
    "frf.1e+04": _RESPONSE,
    "frf.1e+05": _RESPONSE,
    "monte-carlo.nonlinear": _SEGMENTS,
    "monte-carlo.linear": (
        "Half of the samples of a profile fall on the general step, which asks whether effects, delay or failure act, 16 % on memory that is touched "
        "for the first time, 7 % on the constants of an actuator; numba inlines a recursion of two numbers."
    ),
    "program.library": (
        "The unit in C is one linear step. Ours also carries the 17 sets and model files, the effects with the instants of their events, model exchange, the "
        "serialized state, the checks of all arguments, and the part of Rust's standard library that these need; its bytes were not taken apart."
    ),
    "campaign.each": (
        "Of the samples of a profile (34 of these records) 44 % are simulations of the fit, with their sensitivities, some 20 % whitening and the regressions of "
        "its noise, some 3 % reading the files. Theirs fits once and takes the noise as white; ours inspects each record, estimates the response by local "
        "polynomials and the colour of the noise, and states standard errors."
    ),
    "fit.BFGS": (
        "45 % of the samples of a profile are simulations, 13 % memory touched for the first time, the rest regressions and whitening: ours also "
        "estimates the colour of the noise and standard errors, without which the estimates under turbulence have no intervals. Theirs ends with the "
        "mean square."
    ),
    "fit.one": (
        "A third of the samples of a profile are simulations; the record is first inspected (regressions on Laguerre filters and their like, some 15 "
        "%) and the noise whitened. Theirs takes the record as it is."
    ),
}
