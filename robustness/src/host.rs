//! A host: instances of two models, with a logger that may free the calling instance.

use std::{
    cell::{Cell, RefCell},
    ffi::{CString, c_char, c_int, c_void},
    ptr::null,
};

use actuator_fmu::{
    fmu::{MODEL_RESOURCE, Start, guid},
    parameters::Model,
};
use fmi_export::abi::Component;
use tempfile::TempDir;

use crate::functions::{Functions, text};

/// Model exchange, as the value of `fmi2Type`.
pub const MODEL_EXCHANGE: c_int = 0;
/// Co-simulation, as the value of `fmi2Type`.
pub const CO_SIMULATION: c_int = 1;

/// A user's model with effects.
const OWN_MODEL: &str = r#"
[model]
name = "Stranger"
[base]
order = 2
k = { value = 1.1, unit = "deg/deg" }
omega = { value = 120.0, unit = "rad/s" }
zeta = { value = 0.6, unit = "1" }
[effects.backlash]
gap = { value = 0.2, unit = "deg" }
[effects.delay]
time = { value = 0.01, unit = "s" }
"#;

/// `fmi2CallbackFunctions`, with a logger without its variadic arguments.
#[repr(C)]
struct Callbacks {
    logger: Option<extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char)>,
    others: [*const c_void; 4],
}

thread_local! {
    /// Messages of this thread since the last count.
    static MESSAGES: Cell<usize> = const { Cell::new(0) };
    static LAST: RefCell<String> = const { RefCell::new(String::new()) };
    /// Instance freed by the next call of the logger.
    static FREES: Cell<Option<(extern "C-unwind" fn(Component), Component)>> = const { Cell::new(None) };
}

extern "C" fn logger(
    _: *mut c_void,
    name: *const c_char,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    let [name, category, message] = [name, category, message].map(|start| text(start).expect("a string"));
    assert!(!message.is_empty() && !category.is_empty() && (0..=4).contains(&status), "{name}: {message}");
    assert!(!message.replace("%%", "").contains('%'), "a percent sign that is a directive: {message}");
    assert!(!message.contains("internal error"), "{message}");
    MESSAGES.with(|count| count.set(count.get() + 1));
    LAST.with_borrow_mut(|last| *last = message);
    if let Some((free, component)) = FREES.take() {
        free(component);
    }
}

/// Number of messages since the last time, on this thread.
pub fn take_messages() -> usize {
    MESSAGES.take()
}

/// The last message on this thread.
#[must_use]
pub fn last_message() -> String {
    LAST.with_borrow(String::clone)
}

/// The next message on this thread frees this instance.
pub fn free_in_logger(functions: &Functions, component: Component) {
    FREES.set(Some((functions.fmi2FreeInstance, component)));
}

/// Messages no longer free anything.
pub fn free_nothing_in_logger() {
    FREES.set(None);
}

/// Source of instances.
pub struct Host {
    /// The functions.
    pub functions: Functions,
    /// For the default model, and for a model with a file in `resources`.
    guids: [CString; 2],
    resources: [CString; 2],
    _folder: TempDir,
}

impl Host {
    /// With these functions.
    #[must_use]
    pub fn new(functions: Functions) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let model = Model::parse(OWN_MODEL).expect("a model");
        std::fs::write(folder.path().join(MODEL_RESOURCE), OWN_MODEL).expect("a file");
        let guids =
            [Start::default(), Start::from_model(&model)].map(|start| CString::new(guid(&start)).expect("text"));
        let uri = format!("file://{}", folder.path().display());
        let resources = ["file:///nowhere".to_owned(), uri].map(|uri| CString::new(uri).expect("text"));
        let host = Self { functions, guids, resources, _folder: folder };
        // The first instance silences panic messages, including those of the checks here.
        (host.functions.fmi2FreeInstance)(host.instantiate(CO_SIMULATION, false, false));
        drop(std::panic::take_hook());
        host
    }

    /// An instance of one of the two models.
    #[must_use]
    pub fn instantiate(&self, kind: c_int, of_own_model: bool, logging_on: bool) -> Component {
        let model = usize::from(of_own_model);
        self.instantiate_with(
            c"robust".as_ptr(),
            kind,
            self.guids[model].as_ptr(),
            self.resources[model].as_ptr(),
            logging_on,
        )
    }

    /// An instance, or NULL, from these arguments.
    #[must_use]
    pub fn instantiate_with(
        &self,
        name: *const c_char,
        kind: c_int,
        guid: *const c_char,
        resources: *const c_char,
        logging_on: bool,
    ) -> Component {
        // Stable Rust cannot define a variadic logger, and Miri detects the mismatch.
        let callbacks = Callbacks { logger: (!cfg!(miri)).then_some(logger), others: [null(); 4] };
        (self.functions.fmi2Instantiate)(
            name,
            kind,
            guid,
            resources,
            (&raw const callbacks).cast(),
            0,
            logging_on.into(),
        )
    }

    /// An instance of the default model, initialized, with these values of its variables.
    #[must_use]
    pub fn initialized(&self, kind: c_int, values: &[(u32, f64)]) -> Component {
        let component = self.instantiate(kind, false, false);
        let f = &self.functions;
        assert!(!component.is_null(), "{}", last_message());
        assert_eq!((f.fmi2SetupExperiment)(component, 0, 0.0, 0.0, 0, 0.0), 0);
        assert_eq!((f.fmi2EnterInitializationMode)(component), 0);
        for (reference, value) in values {
            assert_eq!((f.fmi2SetReal)(component, reference, 1, value), 0, "{reference}");
        }
        assert_eq!((f.fmi2ExitInitializationMode)(component), 0);
        component
    }
}
