//! Stable sort of (key, value) by key. At capacity the entries beyond it do not exist.

/// The first `capacity` entries in the order of their keys.
pub fn sort(entries: &[(u64, u32)], capacity: usize) -> Vec<(u64, u32)> {
    let mut sorted = entries[..entries.len().min(capacity)].to_vec();
    sorted.sort_by_key(|e| e.0);
    sorted
}
