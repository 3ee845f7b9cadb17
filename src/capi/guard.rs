//! Result codes, the message of the last failure, and what keeps panics inside.

use crate::Error;
use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What a call came to: UMBRAGE_OK or one of UMBRAGE_ERROR_*. After an error outputs are unchanged, and
/// umbrage_last_error says what was wrong.
pub type UmbrageResult = i32;
/// Success.
pub const UMBRAGE_OK: UmbrageResult = 0;
/// The device, or what was enabled on it, lacks something.
pub const UMBRAGE_ERROR_UNSUPPORTED: UmbrageResult = 1;
/// A value is outside what is allowed; the message names it, what was given and what is allowed.
pub const UMBRAGE_ERROR_LIMIT: UmbrageResult = 2;
/// The device has no memory left; the message says for what, and how much it was.
pub const UMBRAGE_ERROR_OUT_OF_MEMORY: UmbrageResult = 3;
/// A Vulkan call failed; the message says which, and its result.
pub const UMBRAGE_ERROR_VULKAN: UmbrageResult = 4;
/// A pointer or a handle is null or misaligned, a struct has no known size, or an array is impossibly long.
pub const UMBRAGE_ERROR_ARGUMENT: UmbrageResult = 5;
/// A defect of the library. An engine to which this happened refuses all further calls but umbrage_engine_destroy.
pub const UMBRAGE_ERROR_PANIC: UmbrageResult = 6;

thread_local! {
    static MESSAGE: RefCell<Option<CString>> = const { RefCell::new(None) };
}

/// The message of the last failure on the calling thread: UTF-8, empty before the first one. It stays as it is until
/// another call fails on this thread; calls that succeed do not clear it. Never null.
#[unsafe(no_mangle)]
pub extern "C" fn umbrage_last_error() -> *const c_char {
    let last = MESSAGE.try_with(|message| message.borrow().as_ref().map_or(c"".as_ptr(), |text| text.as_ptr()));
    last.unwrap_or(c"the thread has ended".as_ptr())
}

/// Why a call failed.
#[doc(hidden)]
#[derive(Debug)]
pub struct Failure {
    pub(super) code: UmbrageResult,
    pub(super) text: String,
}

impl Failure {
    pub(super) fn argument(text: impl Into<String>) -> Self {
        Self { code: UMBRAGE_ERROR_ARGUMENT, text: text.into() }
    }

    pub(super) fn limit(field: &'static str, given: impl ToString, limit: impl Into<String>) -> Self {
        Error::Limit { field, given: given.to_string(), limit: limit.into() }.into()
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let code = match &error {
            Error::Unsupported { .. } => UMBRAGE_ERROR_UNSUPPORTED,
            Error::Limit { .. } => UMBRAGE_ERROR_LIMIT,
            Error::OutOfMemory { .. } => UMBRAGE_ERROR_OUT_OF_MEMORY,
            Error::Vulkan { .. } => UMBRAGE_ERROR_VULKAN,
        };
        Self { code, text: error.to_string() }
    }
}

/// Runs the body of a function of the interface: errors and panics become codes with a message.
#[doc(hidden)]
pub fn guard(run: impl FnOnce() -> Result<(), Failure>) -> UmbrageResult {
    let failure = match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(())) => return UMBRAGE_OK,
        Ok(Err(failure)) => failure,
        Err(panic) => Failure { code: UMBRAGE_ERROR_PANIC, text: format!("panicked: {}", panic_text(&*panic)) },
    };
    // texts have no zero bytes but where a driver's has
    let text = CString::new(failure.text.replace('\0', " ")).ok();
    // while a thread ends there is nowhere to put it
    let _ = MESSAGE.try_with(|message| message.replace(text));
    failure.code
}

fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

/// What a handle points to; refuses to be used once a call has panicked half-way.
#[doc(hidden)]
pub struct Guarded<T> {
    inner: T,
    broken: bool,
}

impl<T> Guarded<T> {
    #[doc(hidden)]
    pub fn new(inner: T) -> Self {
        Self { inner, broken: false }
    }

    #[doc(hidden)]
    pub fn read(&self) -> Result<&T, Failure> {
        if self.broken {
            let text = "an earlier call panicked: the engine can only be destroyed".into();
            return Err(Failure { code: UMBRAGE_ERROR_PANIC, text });
        }
        Ok(&self.inner)
    }

    #[doc(hidden)]
    pub fn change(&mut self, run: impl FnOnce(&mut T) -> Result<(), Failure>) -> Result<(), Failure> {
        self.read()?;
        self.broken = true;
        let result = run(&mut self.inner);
        self.broken = false;
        result
    }
}
