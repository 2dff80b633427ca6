"""The list of mistakes that a host may make; filled by `mistakes_*.py`."""

from collections.abc import Callable
from dataclasses import dataclass

from hostile_host import DISCARD, ERROR, FATAL, OK, WARNING, integers, reals

REFUSED = {DISCARD, ERROR}
WRONG = {ERROR}
NO_INSTANCE = {ERROR, FATAL}
FINE = {OK, WARNING}
SURVIVED = {OK, WARNING, DISCARD, ERROR, FATAL}
NOTHING = {None}  # fmi2Instantiate returned NULL

UNKNOWN_REFERENCE = 4_000_000_000
UNKNOWN = str(UNKNOWN_REFERENCE)
GARBAGE = 0xDEADBEE8  # an address that is not mapped
ABSURD_COUNT = 1 << 61


@dataclass
class Mistake:
    what: str
    make: Callable  # host -> status
    statuses: set  # the correct statuses
    words: tuple  # which the log must contain; none: no line is required


MISTAKES = []


def mistake(what, statuses, *words):
    """For a function of the host."""

    def register(make):
        MISTAKES.append(Mistake(what, make, statuses, words))
        return make

    return register


@dataclass(frozen=True)
class Reference:
    """Represents an array of one value reference, of a variable by name or of a number."""

    variable: object


def call(state, what, statuses, words, function, *arguments):
    """One C call of an instance in this state. `words`: a string or a list of them."""

    def make(host):
        instance = host.instance(state)
        return host.call(function, instance, *(host.reference(a.variable) if isinstance(a, Reference) else a for a in arguments))

    MISTAKES.append(Mistake(what, make, statuses, (words,) if isinstance(words, str) else tuple(words)))


def set_real(state, what, statuses, words, variable, value):
    call(state, what, statuses, words, "fmi2SetReal", Reference(variable), 1, reals(value))


def set_integer(state, what, statuses, words, variable, value):
    call(state, what, statuses, words, "fmi2SetInteger", Reference(variable), 1, integers(value))
