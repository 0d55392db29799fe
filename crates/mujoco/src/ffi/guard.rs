//! MuJoCo's errors and warnings, caught.
//!
//! Left to itself, MuJoCo prints its warnings, appends them to a file in the current folder, and ends the process at an
//! error. Its error handler must not return, so ours unwinds through MuJoCo's frames, which carry unwind tables and
//! nothing to drop, to [`guarded`]. Every function of MuJoCo is therefore declared `extern "C-unwind"`.

#![allow(unsafe_code, reason = "C calls these handlers with C strings")]

use std::cell::{Cell, RefCell};
use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicPtr, Ordering};

/// Type of MuJoCo's two handlers.
pub(super) type Handler = unsafe extern "C-unwind" fn(*const c_char);

/// An error MuJoCo raised, in its words.
pub(crate) struct Raised(pub(crate) String);

thread_local! {
    /// Number of [`guarded`] calls this thread is inside of.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
    /// The warnings of guarded calls that nobody has taken, oldest first.
    static WARNINGS: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Handlers somebody else in this process had set; calls that are not ours still go to them.
static OTHER_ERROR: AtomicPtr<()> = AtomicPtr::new(std::ptr::null_mut());
static OTHER_WARNING: AtomicPtr<()> = AtomicPtr::new(std::ptr::null_mut());

/// More warnings than this are not kept; of one simulation, MuJoCo gives each kind once until a reset.
const MOST_WARNINGS: usize = 64;

/// Makes `call`, in which MuJoCo may raise an error.
pub(super) fn guarded<R>(call: impl FnOnce() -> R) -> Result<R, Raised> {
    struct Inside;
    impl Drop for Inside {
        fn drop(&mut self) {
            DEPTH.set(DEPTH.get() - 1);
        }
    }
    DEPTH.set(DEPTH.get() + 1);
    let _inside = Inside;
    // MuJoCo's memory may be half written after an error; what owns it says how it becomes usable again.
    catch_unwind(AssertUnwindSafe(call)).map_err(|payload| match payload.downcast::<Raised>() {
        Ok(raised) => *raised,
        Err(ours) => resume_unwind(ours),
    })
}

/// The warnings of this thread's guarded calls since this was last asked, oldest first.
pub(crate) fn take_warnings() -> Vec<String> {
    WARNINGS.take()
}

/// Puts our handlers in the places a library has for them.
///
/// # Safety
/// `error` and `warning` must be the library's variables `mju_user_error` and `mju_user_warning`.
pub(super) unsafe fn install(error: *mut *mut (), warning: *mut *mut ()) {
    for (slot, ours, other) in [
        (error, on_error as Handler as *mut (), &OTHER_ERROR),
        (warning, on_warning as Handler as *mut (), &OTHER_WARNING),
    ] {
        // SAFETY: the variable is aligned and lives as long as the library, which is never unloaded. Another thread of
        // ours may write the same address into it at the same time, hence the atomic.
        let before = unsafe { AtomicPtr::from_ptr(slot) }.swap(ours, Ordering::SeqCst);
        if !before.is_null() && before != ours {
            other.store(before, Ordering::SeqCst);
        }
    }
}

unsafe extern "C-unwind" fn on_error(message: *const c_char) {
    // SAFETY: MuJoCo hands over a C string that stays valid during the call.
    let mut text = unsafe { read(message) };
    if text.is_empty() {
        text.push_str("no reason given");
    }
    if DEPTH.get() > 0 {
        // Not `panic!`: that would print.
        resume_unwind(Box::new(Raised(text)));
    }
    forward(&OTHER_ERROR, message, &text);
    // Somebody else's call: do what MuJoCo does where nobody handles its errors.
    std::process::exit(1);
}

unsafe extern "C-unwind" fn on_warning(message: *const c_char) {
    // SAFETY: MuJoCo hands over a C string that stays valid during the call.
    let text = unsafe { read(message) };
    if DEPTH.get() > 0 {
        WARNINGS.with_borrow_mut(|warnings| {
            // The first tell what went wrong, the last how it ended.
            warnings.truncate(MOST_WARNINGS - 1);
            warnings.push(text);
        });
    } else {
        forward(&OTHER_WARNING, message, &text);
    }
}

/// Gives a message of a call that is not ours to whoever handled such messages before, or prints it.
#[expect(clippy::print_stderr, reason = "what MuJoCo does with a message nobody handles")]
fn forward(other: &AtomicPtr<()>, message: *const c_char, text: &str) {
    let handler = other.load(Ordering::SeqCst);
    if handler.is_null() {
        eprintln!("MuJoCo: {text}");
    } else {
        // SAFETY: the address was in the library's variable, so it is a handler, and the message is still valid.
        unsafe { std::mem::transmute::<*mut (), Handler>(handler)(message) };
    }
}

/// MuJoCo's text on one line, empty if there is none.
///
/// # Safety
/// `message` must be null or a C string.
pub(super) unsafe fn read(message: *const c_char) -> String {
    if message.is_null() {
        return String::new();
    }
    // SAFETY: as demanded of the caller.
    tidy(unsafe { CStr::from_ptr(message) })
}

/// MuJoCo's text on one line.
pub(super) fn tidy(text: &CStr) -> String {
    text.to_string_lossy().lines().map(str::trim).filter(|l| !l.is_empty()).collect::<Vec<_>>().join("; ")
}
