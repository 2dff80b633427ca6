//! The C functions: those linked into this program, which sanitizers and Miri can instrument, or those of a packaged library.
#![allow(unsafe_code, non_snake_case)]

use std::{
    ffi::{c_char, c_double, c_int, c_uint, c_void},
    path::Path,
};

use actuator_fmu::fmu::fmi2;
use fmi_export::abi::{CallbackFunctions, Component, SavedState, functions::EventInfo};
use libloading::Library;

type References = *const c_uint;
type Text = *const c_char;

macro_rules! functions {
    ($($name:ident($($kind:ty),*) -> $result:ty;)+) => {
        /// One pointer for each function of the standard.
        #[derive(Clone, Copy)]
        #[allow(missing_docs)]
        pub struct Functions {
            $(pub $name: extern "C-unwind" fn($($kind),*) -> $result,)+
        }

        impl Functions {
            /// Those linked into this program.
            #[must_use]
            pub fn linked() -> Self {
                Self { $($name: fmi2::$name,)+ }
            }

            /// Those of a library, which stays loaded while `library` lives.
            ///
            /// # Errors
            /// A library without one of the functions.
            pub fn of(library: &Library) -> Result<Self, libloading::Error> {
                // SAFETY: the types are those of the standard, which a library of an FMU 2.0 follows.
                Ok(unsafe { Self { $($name: *library.get(stringify!($name).as_bytes())?,)+ } })
            }
        }
    };
}

functions! {
    fmi2GetTypesPlatform() -> Text;
    fmi2GetVersion() -> Text;
    fmi2Instantiate(Text, c_int, Text, Text, *const CallbackFunctions, c_int, c_int) -> Component;
    fmi2FreeInstance(Component) -> ();
    fmi2SetDebugLogging(Component, c_int, usize, *const Text) -> c_int;
    fmi2SetupExperiment(Component, c_int, c_double, c_double, c_int, c_double) -> c_int;
    fmi2EnterInitializationMode(Component) -> c_int;
    fmi2ExitInitializationMode(Component) -> c_int;
    fmi2Terminate(Component) -> c_int;
    fmi2Reset(Component) -> c_int;
    fmi2GetReal(Component, References, usize, *mut c_double) -> c_int;
    fmi2GetInteger(Component, References, usize, *mut c_int) -> c_int;
    fmi2GetBoolean(Component, References, usize, *mut c_int) -> c_int;
    fmi2GetString(Component, References, usize, *mut Text) -> c_int;
    fmi2SetReal(Component, References, usize, *const c_double) -> c_int;
    fmi2SetInteger(Component, References, usize, *const c_int) -> c_int;
    fmi2SetBoolean(Component, References, usize, *const c_int) -> c_int;
    fmi2SetString(Component, References, usize, *const Text) -> c_int;
    fmi2GetFMUstate(Component, *mut SavedState) -> c_int;
    fmi2SetFMUstate(Component, SavedState) -> c_int;
    fmi2FreeFMUstate(Component, *mut SavedState) -> c_int;
    fmi2SerializedFMUstateSize(Component, SavedState, *mut usize) -> c_int;
    fmi2SerializeFMUstate(Component, SavedState, *mut c_char, usize) -> c_int;
    fmi2DeSerializeFMUstate(Component, Text, usize, *mut SavedState) -> c_int;
    fmi2GetDirectionalDerivative(Component, References, usize, References, usize, *const c_double, *mut c_double) -> c_int;
    fmi2SetRealInputDerivatives(Component, References, usize, *const c_int, *const c_double) -> c_int;
    fmi2GetRealOutputDerivatives(Component, References, usize, *const c_int, *mut c_double) -> c_int;
    fmi2DoStep(Component, c_double, c_double, c_int) -> c_int;
    fmi2CancelStep(Component) -> c_int;
    fmi2GetStatus(Component, c_int, *mut c_int) -> c_int;
    fmi2GetRealStatus(Component, c_int, *mut c_double) -> c_int;
    fmi2GetIntegerStatus(Component, c_int, *mut c_int) -> c_int;
    fmi2GetBooleanStatus(Component, c_int, *mut c_int) -> c_int;
    fmi2GetStringStatus(Component, c_int, *mut Text) -> c_int;
    fmi2EnterEventMode(Component) -> c_int;
    fmi2NewDiscreteStates(Component, *mut EventInfo) -> c_int;
    fmi2EnterContinuousTimeMode(Component) -> c_int;
    fmi2CompletedIntegratorStep(Component, c_int, *mut c_int, *mut c_int) -> c_int;
    fmi2SetTime(Component, c_double) -> c_int;
    fmi2SetContinuousStates(Component, *const c_double, usize) -> c_int;
    fmi2GetDerivatives(Component, *mut c_double, usize) -> c_int;
    fmi2GetEventIndicators(Component, *mut c_double, usize) -> c_int;
    fmi2GetContinuousStates(Component, *mut c_double, usize) -> c_int;
    fmi2GetNominalsOfContinuousStates(Component, *mut c_double, usize) -> c_int;
}

/// Loads a library.
///
/// # Errors
/// Those of the system.
pub fn load(path: &Path) -> Result<Library, libloading::Error> {
    // SAFETY: the library of an FMU of this project runs no code when it is loaded.
    unsafe { Library::new(path) }
}

/// The strings passed to the host's logger.
pub(crate) fn text(start: *const c_char) -> Option<String> {
    // SAFETY: not NULL, and an instance passes strings that end in a zero byte.
    (!start.is_null()).then(|| unsafe { std::ffi::CStr::from_ptr(start) }.to_string_lossy().into_owned())
}

/// An invalid pointer, as passed by hosts by mistake.
#[must_use]
pub fn invented(number: usize) -> *mut c_void {
    std::ptr::without_provenance_mut(number)
}
