//! Panics and errors end at the border.

use std::ffi::CStr;
use umbrage::capi::*;

pub fn message() -> String {
    // SAFETY: never null, and no other call of this thread comes between
    unsafe { CStr::from_ptr(umbrage_last_error()) }.to_str().unwrap().to_string()
}

#[test]
fn a_panic_becomes_a_code_and_a_message() {
    assert_eq!(guard(|| panic!("number {}", 7)), UMBRAGE_ERROR_PANIC);
    assert_eq!(message(), "panicked: number 7");
    assert_eq!(guard(|| panic!("with a \0 in it")), UMBRAGE_ERROR_PANIC);
    assert_eq!(message(), "panicked: with a   in it");
    assert_eq!(guard(|| std::panic::panic_any(7)), UMBRAGE_ERROR_PANIC);
    assert_eq!(message(), "panicked: no message");
}

#[test]
fn messages_are_of_the_thread_and_stay() {
    assert_eq!(message(), "");
    assert_eq!(guard(|| panic!("first")), UMBRAGE_ERROR_PANIC);
    std::thread::spawn(|| assert_eq!(message(), "")).join().unwrap();
    assert_eq!(guard(|| Ok(())), UMBRAGE_OK);
    assert_eq!(message(), "panicked: first");
}

#[test]
fn what_panicked_half_way_is_used_no_more() {
    let mut guarded = Guarded::new(1);
    let mut add = |by: i32| {
        guard(|| {
            guarded.change(|value| {
                *value += by;
                assert!(by != 3, "three");
                Ok(())
            })
        })
    };
    assert_eq!([add(1), add(3), add(1)], [UMBRAGE_OK, UMBRAGE_ERROR_PANIC, UMBRAGE_ERROR_PANIC]);
    assert!(message().contains("only be destroyed"), "{}", message());
    assert!(guarded.read().is_err());
}
