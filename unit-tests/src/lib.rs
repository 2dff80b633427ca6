//! Nothing: the tests are those inside `actuator-fmu` and `identification`. Beside the optimised libraries, which programs and integration tests need,
//! an optimised test program of each would take as long to compile again, for tests that take seconds without optimisation.
