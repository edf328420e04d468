//! Is there a graphics driver? Asked before Bevy does, which would panic if there is none.

use bevy::{render::settings::WgpuSettings, tasks::block_on};

/// A graphics driver that Bevy can draw with.
#[derive(Clone, Debug)]
pub struct Driver {
    /// Whether the device is the processor itself.
    pub software: bool,
}

/// The driver Bevy would pick, or why there is none.
pub fn find() -> Result<Driver, String> {
    let settings = WgpuSettings::default();
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: settings.backends.unwrap_or_default(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapter =
        block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: settings.power_preference,
            ..Default::default()
        }));
    let info = adapter.map_err(|_| missing())?.get_info();
    Ok(Driver { software: info.device_type == wgpu::DeviceType::Cpu })
}

/// What is missing, and what would help.
fn missing() -> String {
    if cfg!(target_os = "linux") {
        "there is no Vulkan driver (software drawing will do: package mesa-vulkan-drivers)".into()
    } else {
        "there is no graphics driver".into()
    }
}
