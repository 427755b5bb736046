//! Compares what the stages need of a device with what the device has.

use super::bindings::{READ, entries};
use super::device_error::DeviceError;
use super::memory::{STAGING, any_error, buffer, mapped, scoped, write_mapped};
use super::timer::StageTimer;

/// A group of stages with equal requirements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Subject {
    Extract,
    Shadow,
    Query,
    Deform,
    #[cfg(any(feature = "depth-map", test))]
    DepthMap,
}

impl Subject {
    #[cfg(test)]
    pub(crate) const ALL: [Self; 5] = [Self::Extract, Self::Shadow, Self::Query, Self::Deform, Self::DepthMap];

    pub(crate) fn name(self) -> &'static str {
        [
            "extraction",
            "drawing shadow volumes or outlines",
            "the query of occluder counts",
            "deformation",
            "volumes from depth maps",
        ][self as usize]
    }
}

/// A field of [`wgpu::Limits`], and the value that each [`Subject`] needs.
pub(crate) struct Need {
    pub(crate) limit: &'static str,
    pub(crate) of: fn(&wgpu::Limits) -> u64,
    pub(crate) needed: [u64; 5],
}

macro_rules! need {
    ($limit:ident, $needed:expr) => {
        Need { limit: stringify!($limit), of: |limits| u64::from(limits.$limit), needed: $needed }
    };
}

/// The needs that do not depend on mesh, lights and options. A test takes the numbers from the WGSL.
/// [`super::memory::check`] covers sizes that grow with the mesh. The order is that of [`Subject`]: extract,
/// shadow, query, deform, depth maps.
pub(crate) const AT_LEAST: [Need; 19] = [
    // This comes first, because a device without compute shaders has 0 here.
    need!(max_compute_workgroups_per_dimension, [1, 32, 32, 1, 1]),
    need!(max_compute_invocations_per_workgroup, [256, 256, 64, 256, 256]),
    need!(max_compute_workgroup_size_x, [256, 256, 64, 256, 256]),
    need!(max_compute_workgroup_size_y, [1; 5]),
    need!(max_compute_workgroup_size_z, [1; 5]),
    need!(max_compute_workgroup_storage_size, [1536, 48, 1024, 0, 1024]),
    need!(max_storage_buffers_per_shader_stage, [8, 8, 8, 6, 5]),
    need!(max_sampled_textures_per_shader_stage, [0, 1, 0, 0, 12]),
    need!(max_storage_textures_per_shader_stage, [0, 0, 0, 0, 2]),
    need!(max_uniform_buffers_per_shader_stage, [2, 3, 3, 1, 2]),
    need!(max_buffers_and_acceleration_structures_per_shader_stage, [10, 11, 11, 7, 7]),
    need!(max_dynamic_uniform_buffers_per_pipeline_layout, [2, 2, 3, 1, 2]),
    need!(max_dynamic_storage_buffers_per_pipeline_layout, [0, 1, 0, 0, 0]),
    need!(max_bind_groups, [1, 2, 1, 1, 1]),
    need!(max_bind_groups_plus_vertex_buffers, [0, 2, 0, 0, 1]),
    need!(max_bindings_per_bind_group, [10, 10, 11, 7, 15]),
    need!(max_uniform_buffer_binding_size, [1184, 176, 1184, 16, 80]),
    need!(max_storage_buffer_binding_size, [512, 512, 464, 256, 256]),
    need!(max_buffer_size, [1184, 512, 1184, 256, 256]),
];

/// The limits that must not be larger: uniforms and the beginnings of dispatches lie at multiples of 256 bytes.
pub(crate) const AT_MOST: [Need; 2] =
    [need!(min_uniform_buffer_offset_alignment, [256; 5]), need!(min_storage_buffer_offset_alignment, [256; 5])];

/// Compares the limits of a device with the needs of a subject's stages.
pub(crate) fn check_limits(limits: &wgpu::Limits, subject: Subject) -> Result<(), DeviceError> {
    let name = subject.name();
    for Need { limit, of, needed } in AT_LEAST {
        let (needed, there) = (needed[subject as usize], of(limits));
        if there < needed {
            return Err(DeviceError::Limit { subject: name, limit, needed, there });
        }
    }
    for Need { limit, of, needed } in AT_MOST {
        let (needed, there) = (needed[subject as usize], of(limits));
        if there > needed {
            return Err(DeviceError::Alignment { subject: name, limit, needed, there });
        }
    }
    Ok(())
}

/// Compares a device with the needs of a subject's stages.
pub(crate) fn check_device(device: &wgpu::Device, subject: Subject) -> Result<(), DeviceError> {
    check_limits(&device.limits(), subject)?;
    // The GPU computes the workgroup count of a stage, or the results are drawn by an indirect draw.
    if subject != Subject::Deform {
        check_flag(device, subject, "INDIRECT_EXECUTION", || {
            drop(buffer(device, "indirect execution", 16, wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::STORAGE));
        })?;
    }
    // Vertex shaders read storage buffers.
    if !matches!(subject, Subject::Extract | Subject::Query | Subject::Deform) {
        check_flag(device, subject, "VERTEX_STORAGE", || {
            let entries = &entries(wgpu::ShaderStages::VERTEX, [(0, READ)]);
            let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some("vertex storage"), entries };
            drop(device.create_bind_group_layout(&descriptor));
        })?;
    }
    Ok(())
}

/// Tries what needs a downlevel flag.
fn check_flag(
    device: &wgpu::Device,
    subject: Subject,
    flag: &'static str,
    try_it: impl FnOnce(),
) -> Result<(), DeviceError> {
    let subject = subject.name();
    scoped(device, wgpu::ErrorFilter::Validation, try_it).map_err(|message| DeviceError::Downlevel {
        subject,
        flag,
        message,
    })
}

/// A fragment shader that runs for each sample, which only draws with several samples a pixel need.
pub(crate) const SAMPLE_SHADING: &str =
    "@fragment fn of_sample(@location(0) @interpolate(linear, sample) pixel: vec2<f32>) {}";

/// Compares a device with what draws with several samples a pixel need.
pub(crate) fn check_sample_shading(device: &wgpu::Device, subject: Subject) -> Result<(), DeviceError> {
    check_flag(device, subject, "MULTISAMPLED_SHADING", || {
        drop(device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("sample shading"),
            source: wgpu::ShaderSource::Wgsl(SAMPLE_SHADING.into()),
        }));
    })
}

/// Refuses a device that was lost or destroyed. wgpu calls only the caller's callback, but no buffer of a lost device
/// can be mapped. In a browser it can be mapped, so a lost device is not noticed there.
pub(crate) fn check_alive(device: &wgpu::Device) -> Result<(), DeviceError> {
    let make = || mapped(device, "alive", 4, STAGING);
    let buffer = any_error(device, make).map_err(|message| DeviceError::Refused { message })?;
    if write_mapped(&buffer, &[&[0; 4]]) { Ok(()) } else { Err(DeviceError::Lost) }
}

/// Refuses a timer of another device.
pub(crate) fn check_timer(timer: Option<&StageTimer>, device: &wgpu::Device) -> Result<(), DeviceError> {
    timer.map_or(Ok(()), |timer| check_same(["the timer", "the stages"], [&timer.device, device]))
}

/// Refuses objects of two devices.
pub(crate) fn check_same(
    [what, with]: [&'static str; 2],
    [given, expected]: [&wgpu::Device; 2],
) -> Result<(), DeviceError> {
    if given == expected { Ok(()) } else { Err(DeviceError::OtherDevice { what, with }) }
}

#[cfg(test)]
mod tests;
