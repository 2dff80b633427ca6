//! The C symbols.

/// Defines all functions of FMI 2.0, common, for co-simulation and for model exchange, as C symbols of the crate that calls it:
/// once, in the library of a model that implements [`Model`](crate::Model). The argument is the name of its type, in scope.
///
/// Calls that a model does not support are refused at run time, with a status and a line in the host's log.
#[macro_export]
macro_rules! export {
    ($model:ident) => {
        $crate::functions! { $model:
            fmi2GetTypesPlatform() -> *const c_char;
            fmi2GetVersion() -> *const c_char;
            fmi2Instantiate(name: *const c_char, kind: c_int, guid: *const c_char, resources: *const c_char,
                functions: *const CallbackFunctions, visible: c_int, logging_on: c_int) -> Component;
            fmi2FreeInstance(component: Component) -> ();
            fmi2SetDebugLogging(component: Component, logging_on: c_int, n: usize, categories: *const *const c_char) -> c_int;
            fmi2SetupExperiment(component: Component, tolerance_defined: c_int, tolerance: c_double, start: c_double,
                stop_defined: c_int, stop: c_double) -> c_int;
            fmi2EnterInitializationMode(component: Component) -> c_int;
            fmi2ExitInitializationMode(component: Component) -> c_int;
            fmi2Terminate(component: Component) -> c_int;
            fmi2Reset(component: Component) -> c_int;
            fmi2GetReal(component: Component, references: *const c_uint, n: usize, values: *mut c_double) -> c_int;
            fmi2GetInteger(component: Component, references: *const c_uint, n: usize, values: *mut c_int) -> c_int;
            fmi2GetBoolean(component: Component, references: *const c_uint, n: usize, values: *mut c_int) -> c_int;
            fmi2GetString(component: Component, references: *const c_uint, n: usize, values: *mut *const c_char) -> c_int;
            fmi2SetReal(component: Component, references: *const c_uint, n: usize, values: *const c_double) -> c_int;
            fmi2SetInteger(component: Component, references: *const c_uint, n: usize, values: *const c_int) -> c_int;
            fmi2SetBoolean(component: Component, references: *const c_uint, n: usize, values: *const c_int) -> c_int;
            fmi2SetString(component: Component, references: *const c_uint, n: usize, values: *const *const c_char) -> c_int;
            fmi2GetFMUstate(component: Component, state: *mut SavedState) -> c_int;
            fmi2SetFMUstate(component: Component, state: SavedState) -> c_int;
            fmi2FreeFMUstate(component: Component, state: *mut SavedState) -> c_int;
            fmi2SerializedFMUstateSize(component: Component, state: SavedState, size: *mut usize) -> c_int;
            fmi2SerializeFMUstate(component: Component, state: SavedState, bytes: *mut c_char, size: usize) -> c_int;
            fmi2DeSerializeFMUstate(component: Component, bytes: *const c_char, size: usize, state: *mut SavedState) -> c_int;
            fmi2GetDirectionalDerivative(component: Component, unknowns: *const c_uint, n_unknowns: usize,
                knowns: *const c_uint, n_knowns: usize, seed: *const c_double, sensitivity: *mut c_double) -> c_int;

            fmi2SetRealInputDerivatives(component: Component, references: *const c_uint, n: usize, orders: *const c_int,
                values: *const c_double) -> c_int;
            fmi2GetRealOutputDerivatives(component: Component, references: *const c_uint, n: usize, orders: *const c_int,
                values: *mut c_double) -> c_int;
            fmi2DoStep(component: Component, current: c_double, duration: c_double, no_set_state_prior: c_int) -> c_int;
            fmi2CancelStep(component: Component) -> c_int;
            fmi2GetStatus(component: Component, kind: c_int, value: *mut c_int) -> c_int;
            fmi2GetRealStatus(component: Component, kind: c_int, value: *mut c_double) -> c_int;
            fmi2GetIntegerStatus(component: Component, kind: c_int, value: *mut c_int) -> c_int;
            fmi2GetBooleanStatus(component: Component, kind: c_int, value: *mut c_int) -> c_int;
            fmi2GetStringStatus(component: Component, kind: c_int, value: *mut *const c_char) -> c_int;

            fmi2EnterEventMode(component: Component) -> c_int;
            fmi2NewDiscreteStates(component: Component, info: *mut EventInfo) -> c_int;
            fmi2EnterContinuousTimeMode(component: Component) -> c_int;
            fmi2CompletedIntegratorStep(component: Component, no_set_state_prior: c_int, enter_event_mode: *mut c_int,
                terminate: *mut c_int) -> c_int;
            fmi2SetTime(component: Component, time: c_double) -> c_int;
            fmi2SetContinuousStates(component: Component, states: *const c_double, n: usize) -> c_int;
            fmi2GetDerivatives(component: Component, derivatives: *mut c_double, n: usize) -> c_int;
            fmi2GetEventIndicators(component: Component, indicators: *mut c_double, n: usize) -> c_int;
            fmi2GetContinuousStates(component: Component, states: *mut c_double, n: usize) -> c_int;
            fmi2GetNominalsOfContinuousStates(component: Component, nominals: *mut c_double, n: usize) -> c_int;
        }
    };
}

/// Part of [`export!`](crate::export).
#[doc(hidden)]
#[macro_export]
macro_rules! functions {
    ($model:ident: $($name:ident($($argument:ident: $kind:ty),* $(,)?) -> $result:ty;)+) => {
        /// The functions of FMI 2.0.
        #[allow(unsafe_code, non_snake_case, missing_docs)]
        pub mod fmi2 {
            use $crate::libc::{c_char, c_double, c_int, c_uint};
            use $crate::abi::{CallbackFunctions, Component, Instances, SavedState, functions::EventInfo};

            static INSTANCES: Instances<super::$model> = Instances::new();

            $(
                // An exception of the host's logger passes through, hence `C-unwind`; there is nothing to clean up here.
                // SAFETY: the names are those of FMI 2.0; nothing else in this library defines them.
                #[unsafe(no_mangle)]
                pub extern "C-unwind" fn $name($($argument: $kind),*) -> $result {
                    #[inline(never)]
                    fn call($($argument: $kind),*) -> $result {
                        $crate::abi::functions::$name(&INSTANCES, $($argument),*)
                    }
                    $crate::abi::Returned::delivered(call($($argument),*))
                }
            )+
        }
    };
}
