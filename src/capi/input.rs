//! Pointers of the caller as Rust references, checked as far as pointers can be.

use super::guard::Failure;
use ash::vk::Handle;
use std::mem::MaybeUninit;

fn check<T>(pointer: *const T, what: &str) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::argument(format!("{what} is a null pointer")));
    }
    if !pointer.is_aligned() {
        return Err(Failure::argument(format!("{what} is not aligned to {} bytes", align_of::<T>())));
    }
    Ok(())
}

/// A handle that must be there.
pub(super) fn present<H: Handle + Copy>(handle: H, what: &str) -> Result<H, Failure> {
    if handle.is_null() { Err(Failure::argument(format!("{what} is a null handle"))) } else { Ok(handle) }
}

/// Room for fields of later versions.
pub(super) fn zero(reserved: u32) -> Result<(), Failure> {
    if reserved == 0 { Ok(()) } else { Err(Failure::limit("reserved", reserved, "0")) }
}

/// # Safety
/// Null, or a valid `T` for as long as the reference is used.
pub(super) unsafe fn reference<'a, T>(pointer: *const T, what: &str) -> Result<&'a T, Failure> {
    check(pointer, what)?;
    // SAFETY: neither null nor misaligned; the caller vouches for the rest
    Ok(unsafe { &*pointer })
}

/// # Safety
/// As [`reference`], and nothing else refers to it.
pub(super) unsafe fn mutable<'a, T>(pointer: *mut T, what: &str) -> Result<&'a mut T, Failure> {
    check(pointer, what)?;
    // SAFETY: as above
    Ok(unsafe { &mut *pointer })
}

/// Where a result goes, which need not be initialised.
///
/// # Safety
/// Null, or writable room for a `T`.
pub(super) unsafe fn output<'a, T>(pointer: *mut T, what: &str) -> Result<&'a mut MaybeUninit<T>, Failure> {
    check(pointer, what)?;
    // SAFETY: as above
    Ok(unsafe { &mut *pointer.cast() })
}

/// `count` elements; of none the pointer may be null.
///
/// # Safety
/// Null, or `count` valid elements for as long as the slice is used.
pub(super) unsafe fn slice<'a, T>(pointer: *const T, count: usize, what: &str) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    check(pointer, what)?;
    if count.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return Err(Failure::argument(format!("{what} cannot have {count} elements")));
    }
    // SAFETY: neither null nor misaligned nor too long; the caller vouches for the rest
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

fn check_size<T>(size: usize, least: usize, what: &str) -> Result<(), Failure> {
    if (least..=size_of::<T>()).contains(&size) {
        return Ok(());
    }
    let text = format!("size of {what} is {size}, allowed is {least} to {}: sizeof of the struct", size_of::<T>());
    Err(Failure::argument(text))
}

/// A struct that begins with its size: an older caller's is shorter, the rest is as in `full`. `least`: the size that
/// it had at first.
///
/// # Safety
/// Null, or a struct as long as it says of itself. `T` is plain data whose first field is that size.
pub(super) unsafe fn sized<T: Copy>(pointer: *const T, mut full: T, least: usize, what: &str) -> Result<T, Failure> {
    check(pointer, what)?;
    // SAFETY: neither null nor misaligned, and the size is there in every version
    let size = unsafe { pointer.cast::<usize>().read() };
    check_size::<T>(size, least, what)?;
    // SAFETY: the caller's struct has that many bytes, and `T` has no fewer
    unsafe { std::ptr::copy_nonoverlapping(pointer.cast::<u8>(), (&raw mut full).cast(), size) };
    Ok(full)
}

/// Writes as much of `value` as the caller's struct holds.
///
/// # Safety
/// Null, or writable room for `size` bytes. `T` is plain data.
pub(super) unsafe fn fill<T: Copy>(
    to: *mut T,
    size: usize,
    value: &T,
    least: usize,
    what: &str,
) -> Result<(), Failure> {
    check(to, what)?;
    check_size::<T>(size, least, what)?;
    // SAFETY: both have that many bytes
    unsafe { std::ptr::copy_nonoverlapping((&raw const *value).cast::<u8>(), to.cast(), size) };
    Ok(())
}
