//! Cuts work to a device's limits: chunks for arrays that a dispatch walks along, windows for arrays that it gathers
//! from.

use std::ops::Range;

use super::device_error::DeviceError;
use crate::turns::ITEMS;

/// The number of invocations of a workgroup, in every stage that works item by item.
pub(crate) const WORKGROUP: u32 = 256;

/// Whether a CPU executes the invocations.
pub(crate) fn is_software(device: &wgpu::Device) -> bool {
    device.adapter_info().device_type == wgpu::DeviceType::Cpu
}

/// The number of workgroups whose invocations take `items` in turn, at least 1. A CPU executes invocations without work
/// one after another, so it gets few.
pub(crate) fn loops(device: &wgpu::Device, items: u32) -> u32 {
    loops_of(device, items, ITEMS)
}

/// The same with at most `turns` items for each invocation.
pub(crate) fn loops_of(device: &wgpu::Device, items: u32, turns: u32) -> u32 {
    let few = if is_software(device) { 64 } else { 4096 };
    items.div_ceil(WORKGROUP).clamp(1, few).max(items.div_ceil(WORKGROUP * turns))
}

/// The number of workgroups of 64 invocations that take undecided faces in turn, of which there are few as a rule: up
/// to `turns` each if every one of `faces` is undecided. A workgroup without work costs time, too: on an NVIDIA H100,
/// 16,384 of them took longer than facing of their four million faces.
pub(crate) fn exact_workgroups(device: &wgpu::Device, faces: u32, turns: u32) -> u32 {
    let few = if is_software(device) { 0 } else { 1024 };
    faces.div_ceil(64 * 4).min(few).max(faces.div_ceil(64 * turns))
}

/// The number of bindings that a gathered array may span.
pub(crate) const WINDOWS: usize = 4;

/// The limits of a device that dispatches must keep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DispatchLimits {
    /// The largest size of a storage binding in bytes, a multiple of the offset alignment. Its words have 32-bit indices.
    pub(crate) binding: u64,
    pub(crate) buffer: u64,
    alignment: u64,
    pub(crate) workgroups: u64,
}

impl DispatchLimits {
    pub(crate) fn new(limits: &wgpu::Limits) -> Self {
        let alignment = u64::from(limits.min_storage_buffer_offset_alignment.max(4));
        let binding = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size).min(4 * u64::from(u32::MAX));
        Self {
            binding: binding / alignment * alignment,
            buffer: limits.max_buffer_size,
            alignment,
            workgroups: u64::from(limits.max_compute_workgroups_per_dimension),
        }
    }

    /// Cuts `items` into ranges that one dispatch can walk along. Each item takes up to `bytes_per_item` bytes of a
    /// binding. Ranges begin at multiples of the workgroup size, so that any array of words may be bound there.
    pub(crate) fn chunks(
        &self,
        what: &'static str,
        items: usize,
        bytes_per_item: u64,
    ) -> Result<Vec<Range<usize>>, DeviceError> {
        let workgroup = u64::from(WORKGROUP);
        let fitting = (self.binding / bytes_per_item.max(1)).min(self.workgroups * workgroup);
        let length = fitting / workgroup * workgroup;
        if length == 0 {
            return Err(DeviceError::BindingTooLarge { what, bytes: bytes_per_item * workgroup, limit: self.binding });
        }
        let length = length as usize;
        Ok((0..items).step_by(length).map(|first| first..(first + length).min(items)).collect())
    }

    /// Cuts `bytes` into [`WINDOWS`] bindings. All have the same length except the last one, and unused ones repeat the
    /// first. Also returns the number of words in a window, or 0 when one window holds everything.
    pub(crate) fn windows(&self, what: &'static str, bytes: u64) -> Result<Windows, DeviceError> {
        let limit = self.binding * WINDOWS as u64;
        if bytes > limit {
            return Err(DeviceError::GatheredTooLarge { what, bytes, limit });
        }
        let single = bytes <= self.binding;
        let ranges = std::array::from_fn(|window| {
            let begin = self.binding * window as u64;
            if begin < bytes { begin..bytes.min(begin + self.binding) } else { 0..bytes.min(self.binding) }
        });
        Ok(Windows { ranges, words: if single { 0 } else { (self.binding / 4) as u32 } })
    }

    /// The largest offset up to `offset` where a binding may begin.
    pub(crate) fn align_down(&self, offset: u64) -> u64 {
        offset / self.alignment * self.alignment
    }

    /// The smallest size from `bytes` on after which a binding may begin.
    pub(crate) fn align_up(&self, bytes: u64) -> u64 {
        bytes.next_multiple_of(self.alignment)
    }
}

/// The bindings of a gathered array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Windows {
    /// In bytes.
    pub(crate) ranges: [Range<u64>; WINDOWS],
    /// Words of a window, or 0 if the first one holds everything.
    pub(crate) words: u32,
}

impl Windows {
    /// The window that a shader names by `prefix` and its number.
    pub(crate) fn named(&self, prefix: &str, name: &str) -> Option<Range<u64>> {
        let number: usize = name.strip_prefix(prefix)?.parse().ok()?;
        self.ranges.get(number).cloned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Metal binds all of a buffer, of any size.
    #[test]
    fn words_of_a_binding_have_32_bit_indices() {
        let (max_storage_buffer_binding_size, max_buffer_size) = (u64::MAX, u64::MAX);
        let limits = wgpu::Limits { max_storage_buffer_binding_size, max_buffer_size, ..wgpu::Limits::default() };
        let DispatchLimits { binding, buffer, .. } = DispatchLimits::new(&limits);
        assert!(u32::try_from(binding / 4).is_ok() && binding > 1 << 33, "{binding}");
        assert_eq!(buffer, u64::MAX);
    }
}
