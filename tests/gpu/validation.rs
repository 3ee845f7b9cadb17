//! Validation is on and sees things: otherwise its silence in the other tests would mean nothing.

use crate::bench::{Bench, lab};
use crate::scenes::sphere_on_plane;
use umbrage::lab::stages;

#[test]
fn a_missing_barrier_is_reported() {
    let (scene, view) = sphere_on_plane([16, 16]);
    let lab = lab(scene, view);
    stages::two_dispatches(&lab, false).unwrap();
    let messages = lab.validation_messages();
    assert!(messages.iter().any(|m| m.contains("SYNC-HAZARD")), "{messages:?}");
}

#[test]
fn the_same_dispatches_with_a_barrier_are_not() {
    let lab = Bench::plain();
    stages::two_dispatches(&lab, true).unwrap();
}

#[test]
fn a_buffer_of_no_bytes_is_reported() {
    let (scene, view) = sphere_on_plane([16, 16]);
    let lab = lab(scene, view);
    stages::empty_buffer(&lab);
    let messages = lab.validation_messages();
    assert!(messages.iter().any(|m| m.contains("VUID-VkBufferCreateInfo-size-00912")), "{messages:?}");
}

#[test]
#[should_panic(expected = "validation")]
fn a_bench_fails_on_messages() {
    let lab = Bench::plain();
    stages::empty_buffer(&lab);
}
