//! The C interface as far as it goes without a device; `tests/c/host.c` does the rest.

#[path = "capi/arguments.rs"]
mod arguments;
#[path = "capi/guard.rs"]
mod guard;
#[path = "capi/header.rs"]
mod header;
