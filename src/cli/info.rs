//! `umbrage info`: the devices and what each lacks.

use super::failure::Failure;
use super::print;
use umbrage::lab::{self, DeviceReport};

const NO_DEVICE: &str = "\
On Debian or Ubuntu `apt-get install libvulkan1 mesa-vulkan-drivers` brings the loader and lavapipe, a device in software.
";

/// Prints every device; that there is none is an answer too.
pub fn run() -> Result<(), Failure> {
    match lab::devices() {
        Ok(devices) if !devices.is_empty() => {
            print::out(&devices.iter().map(describe).collect::<String>());
            if devices.iter().all(|device| !device.missing.is_empty()) {
                print::out(&format!("No device is usable.\n{NO_DEVICE}"));
            }
        }
        Ok(_) => print::out(&format!("No Vulkan device was found.\n{NO_DEVICE}")),
        Err(error) => print::out(&format!("No Vulkan device was found: {error}.\n{NO_DEVICE}")),
    }
    Ok(())
}

fn describe(device: &DeviceReport) -> String {
    let DeviceReport { index, name, kind, api_version, driver, missing, notes } = device;
    let mut text = format!("{index}: {name} ({kind}), Vulkan {api_version}, driver {driver}\n");
    if missing.is_empty() {
        text += "   usable: lacks nothing\n";
    } else {
        text += &format!("   not usable: lacks {}\n", missing.join(", "));
    }
    notes.iter().for_each(|note| text += &format!("   {note}\n"));
    text
}
