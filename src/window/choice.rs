//! The methods to switch between, and the one that is shown.

use super::settings;
use crate::lab::{Lab, LabError};
use crate::methods::{self, Method, MethodSpec};

/// A method; made when first shown.
struct Entry {
    spec: MethodSpec,
    /// With a key changed; takes its place in the next frame.
    wanted: Option<MethodSpec>,
    method: Option<Box<dyn Method>>,
    /// Whether the method has made a frame.
    ran: bool,
}

impl Entry {
    fn new(spec: MethodSpec, method: Option<Box<dyn Method>>) -> Self {
        Self { spec, wanted: None, method, ran: false }
    }

    fn make(&mut self, lab: &Lab) -> Result<(), LabError> {
        if self.method.is_none() {
            self.method = Some(methods::create(&self.spec, lab)?);
        }
        Ok(())
    }
}

/// At least one method, of which the current one is made.
pub(super) struct Choice {
    entries: Vec<Entry>,
    current: usize,
}

impl Choice {
    /// Makes the first.
    pub(super) fn new(specs: &[MethodSpec], lab: &Lab) -> Result<Self, LabError> {
        let mut entries: Vec<_> = specs.iter().map(|spec| Entry::new(spec.clone(), None)).collect();
        let none = || LabError::Usage("no method was named; at least one is needed".into());
        entries.first_mut().ok_or_else(none)?.make(lab)?;
        Ok(Self { entries, current: 0 })
    }

    /// The place of the current one, from 0, and the number of all.
    pub(super) fn place(&self) -> [usize; 2] {
        [self.current, self.entries.len()]
    }

    /// The current one as it is shown.
    pub(super) fn spec(&self) -> &MethodSpec {
        &self.entries[self.current].spec
    }

    /// The current one with the changes that were asked for.
    pub(super) fn wanted(&self) -> &MethodSpec {
        let entry = &self.entries[self.current];
        entry.wanted.as_ref().unwrap_or(&entry.spec)
    }

    /// Whether the current one has pages.
    pub(super) fn paged(&self) -> bool {
        settings::paged(self.spec())
    }

    /// Whether it computes visibility on the CPU.
    pub(super) fn slow(&self) -> bool {
        self.entries[self.current].method.as_ref().is_some_and(|method| method.masks().is_none())
    }

    /// The current one, and whether it has made a frame.
    pub(super) fn method(&mut self) -> Option<(&mut dyn Method, &mut bool)> {
        let entry = &mut self.entries[self.current];
        let method = entry.method.as_mut()?;
        Some((method.as_mut(), &mut entry.ran))
    }

    /// Changes to another one; stays where that cannot be made.
    pub(super) fn switch(&mut self, to: usize, lab: &Lab) -> Result<(), LabError> {
        let count = self.entries.len();
        let missing = || LabError::Usage(format!("there is no method {}, allowed is 1 to {count}", to + 1));
        self.entries.get_mut(to).ok_or_else(missing)?.make(lab)?;
        self.current = to;
        Ok(())
    }

    /// Asks for changed keys of the current one. Nothing is made before the next frame, so that many changes cost one.
    pub(super) fn want(&mut self, spec: MethodSpec) -> Result<(), LabError> {
        methods::check(&spec)?;
        self.entries[self.current].wanted = Some(spec);
        Ok(())
    }

    /// Makes the current one with the keys that were asked for; keeps it as it is where that cannot be made. `false` when
    /// nothing was asked for.
    pub(super) fn replace(&mut self, lab: &Lab) -> Result<bool, LabError> {
        let entry = &mut self.entries[self.current];
        let Some(spec) = entry.wanted.take() else { return Ok(false) };
        let method = methods::create(&spec, lab)?;
        *entry = Entry::new(spec, Some(method));
        Ok(true)
    }

    /// Drops all of them before the lab gets another size.
    pub(super) fn drop_all(&mut self) {
        self.entries.iter_mut().for_each(|entry| (entry.method, entry.ran) = (None, false));
    }

    /// Makes the current one again.
    pub(super) fn make(&mut self, lab: &Lab) -> Result<(), LabError> {
        self.entries[self.current].make(lab)
    }
}
