"""The log: standard categories, which are respected; lines with the instance's name, the right category and a meaningful message."""

import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2Error

from actuator_fmu import Actuator

STANDARD_CATEGORIES = {  # FMI 2.0, table of log categories in section 2.2.4
    "logEvents", "logSingularLinearSystems", "logNonlinearSystems", "logDynamicStateSelection", "logStatusWarning",
    "logStatusDiscard", "logStatusError", "logStatusFatal", "logStatusPending", "logAll",
}  # fmt: skip
UNKNOWN_REFERENCE = 4_000_000_000


def provoke(actuator):
    """An error, and its lines in the log."""
    before = len(actuator.log)
    with pytest.raises(FMICallException) as error:
        actuator.fmu.getReal([UNKNOWN_REFERENCE])
    assert error.value.status == fmi2Error
    return actuator.log[before:]


def declared(package):
    return {category.name for category in package.description.logCategories}


def test_the_declared_categories_are_standard_ones_and_described(package):
    assert declared(package) and declared(package) <= STANDARD_CATEGORIES
    assert all(category.description for category in package.description.logCategories)


def test_an_error_is_logged_under_its_name_status_and_category(package):
    with Actuator(package, instance_name="left aileron") as actuator:
        (line,) = provoke(actuator)
    assert (line.instance, line.status, line.category) == ("left aileron", fmi2Error, "logStatusError")
    assert str(UNKNOWN_REFERENCE) in line.message


def test_lines_go_to_the_logger_of_their_instance(package):
    with Actuator(package, "one") as one, Actuator(package, "two") as two:
        provoke(one)
        assert len(one.log) == 1 and not two.log


def test_errors_are_heard_without_asking(package):
    """Importers instantiate with logging off by default; a refusal without a reason would not help their users."""
    with Actuator(package, logging=False) as actuator:
        assert [line.category for line in provoke(actuator)] == ["logStatusError"]


def test_logging_off_is_silent(actuator):
    actuator.fmu.setDebugLogging(False, [])
    assert not provoke(actuator)


@pytest.mark.parametrize("category, heard", [("logStatusError", True), ("logAll", True), ("logStatusWarning", False)])
def test_only_chosen_categories_are_heard(actuator, category, heard):
    if category not in declared(actuator.package):
        pytest.skip(f"{category} is not declared")
    actuator.fmu.setDebugLogging(False, [])
    actuator.fmu.setDebugLogging(True, [category])
    assert bool(provoke(actuator)) is heard


def test_logging_on_without_categories_means_all(actuator):
    actuator.fmu.setDebugLogging(False, [])
    actuator.fmu.setDebugLogging(True, [])
    assert provoke(actuator)


def test_a_good_run_is_quiet(actuator):
    """No line of status warning or worse."""
    actuator.initialize()
    actuator.run([1.0] * 10, 0.005)
    actuator.fmu.terminate()
    assert not [line for line in actuator.log if line.status > 0]
