//! The lights: added, moved and removed between frames, each with an id that stays.

use super::constants::{History, light_record};
use crate::gpu::structs::{LightRecord, light_kind};
use crate::host::{FrameInput, SceneBuffers};
use crate::{Config, Error, Light};
use bytemuck::Zeroable;

/// Most lights: as many as page keys can tell apart.
pub(crate) const MAX_LIGHTS: u32 = 1365;

/// A light of an engine; stays the same until the light is removed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LightId {
    slot: u32,
    generation: u32,
}

impl LightId {
    /// Slot of the light: its place in the mask and what the lookup in a shader takes. Free again once the light is removed.
    pub fn slot(&self) -> u32 {
        self.slot
    }

    /// As one number: the slot in the low half, never 0.
    #[cfg(feature = "capi")]
    pub(crate) fn to_bits(self) -> u64 {
        u64::from(self.generation) << 32 | u64::from(self.slot)
    }

    /// What [`LightId::to_bits`] gave, or no light's.
    #[cfg(feature = "capi")]
    pub(crate) fn from_bits(bits: u64) -> Self {
        Self { slot: bits as u32, generation: (bits >> 32) as u32 }
    }
}

#[derive(Default)]
struct Entry {
    light: Option<Light>,
    /// Of the light that is or was last in this slot.
    generation: u32,
    /// Changes when pages drawn for the slot are worthless.
    revision: u32,
    /// Axes in the last frame.
    axes: Option<[[f32; 4]; 2]>,
}

pub(crate) struct Lights {
    entries: Vec<Entry>,
    revision: u32,
}

impl Lights {
    pub(crate) fn new(capacity: u32) -> Self {
        Self { entries: (0..capacity).map(|_| Entry::default()).collect(), revision: 0 }
    }

    pub(crate) fn add(&mut self, light: &Light) -> Result<LightId, Error> {
        check(light)?;
        let capacity = self.entries.len();
        let free = self.entries.iter().position(|entry| entry.light.is_none()).ok_or_else(|| Error::Limit {
            field: "lights",
            given: (capacity + 1).to_string(),
            limit: format!("at most {capacity}, as the configuration says"),
        })?;
        self.revision = self.revision.wrapping_add(1);
        let entry = &mut self.entries[free];
        *entry = Entry {
            light: Some(light.clone()),
            generation: entry.generation.wrapping_add(1),
            revision: self.revision,
            axes: None,
        };
        Ok(LightId { slot: free as u32, generation: entry.generation })
    }

    fn entry(&mut self, id: LightId) -> Result<&mut Entry, Error> {
        let entry = self.entries.get_mut(id.slot as usize);
        entry.filter(|entry| entry.light.is_some() && entry.generation == id.generation).ok_or_else(|| Error::Limit {
            field: "light id",
            given: format!("{} ({})", id.slot, id.generation),
            limit: "the id of a light that was added and not removed".into(),
        })
    }

    pub(crate) fn set(&mut self, id: LightId, light: &Light) -> Result<(), Error> {
        check(light)?;
        let next = self.revision.wrapping_add(1);
        let entry = self.entry(id)?;
        if entry.light.as_ref() != Some(light) {
            // pages of a directional light outlive small turns
            let turns = |light: Option<&Light>| matches!(light, Some(Light::Directional { .. }));
            if !(turns(entry.light.as_ref()) && turns(Some(light))) {
                (entry.revision, entry.axes) = (next, None);
            }
            entry.light = Some(light.clone());
            self.revision = next;
        }
        Ok(())
    }

    pub(crate) fn remove(&mut self, id: LightId) -> Result<(), Error> {
        self.entry(id)?.light = None;
        Ok(())
    }

    /// Slots up to the last light.
    pub(crate) fn used(&self) -> u32 {
        self.entries.iter().rposition(|entry| entry.light.is_some()).map_or(0, |last| last as u32 + 1)
    }

    /// Whether any light has a place.
    pub(crate) fn any_local(&self) -> bool {
        self.entries.iter().any(|e| matches!(e.light, Some(Light::Spot { .. } | Light::Point { .. })))
    }

    /// Adds one record for each slot in use, for one view.
    pub(crate) fn records(
        &self,
        config: &Config,
        scene: &SceneBuffers,
        input: &FrameInput,
        history: &History,
        list: &mut Vec<LightRecord>,
    ) -> Result<(), Error> {
        let bias = config.level_bias + history.bias;
        let record = |entry: &Entry| {
            let Some(light) = &entry.light else { return Ok(LightRecord::zeroed()) };
            let mut record = light_record(config, scene, light, input, bias)?;
            record.kind[2] = entry.revision;
            Ok(record)
        };
        for entry in &self.entries[..self.used() as usize] {
            list.push(record(entry)?);
        }
        Ok(())
    }

    /// Takes note of the axes of a frame and marks the directional lights that turned since the last; whether any did.
    pub(crate) fn turned(&mut self, records: &mut [LightRecord]) -> bool {
        let mut turned = false;
        for (entry, record) in self.entries.iter_mut().zip(records) {
            if record.kind[0] == light_kind::DIRECTIONAL {
                let axis = |v: [f32; 4]| [v[0], v[1], v[2], 0.0];
                let axes = [axis(record.axis_x), axis(record.axis_z)];
                record.kind[1] = u32::from(entry.axes.is_some_and(|before| before != axes));
                turned |= record.kind[1] != 0;
                entry.axes = Some(axes);
            }
        }
        turned
    }

    /// As if there had been no frame.
    pub(crate) fn forget(&mut self) {
        self.entries.iter_mut().for_each(|entry| entry.axes = None);
    }
}

/// Says which field of a light is not allowed.
fn check(light: &Light) -> Result<(), Error> {
    let limit = |ok: bool, field: &'static str, given: String, limit: &str| {
        if ok { Ok(()) } else { Err(Error::Limit { field, given, limit: limit.into() }) }
    };
    if light.has_extent() {
        return limit(false, "light", format!("{light:?}"), "a light without extent");
    }
    if let Light::Directional { direction, .. } | Light::Spot { direction, .. } = light {
        super::constants::light_axes(*direction)?;
    }
    if let Light::Spot { position, range, .. } | Light::Point { position, range } = light {
        limit(position.is_finite(), "light position", format!("{position}"), "a finite point")?;
        limit(*range > 0.0 && range.is_finite(), "light range", range.to_string(), "above 0 and finite")?;
    }
    if let Light::Spot { outer_angle_deg: angle, .. } = light {
        limit(*angle > 0.0 && *angle <= 90.0, "outer angle", angle.to_string(), "above 0 and up to 90 degrees")?;
    }
    Ok(())
}
