//! The window's surface, and the device that draws onto it.

use std::sync::Arc;

use winit::window::Window;

use super::error::DesktopError;
use crate::renderer::Gpu;

/// A window with its surface and device.
pub(super) struct Screen {
    instance: wgpu::Instance,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    pub(super) window: Arc<Window>,
    pub(super) gpu: Gpu,
}

/// A texture of the surface, or why there is none now.
pub(super) enum Next {
    Texture(wgpu::SurfaceTexture),
    /// Nothing is seen; a later event tells when something is.
    Occluded,
    /// The surface was set up anew, so the frame is to be drawn again.
    Again,
}

impl Screen {
    /// Takes an adapter whose name has a part in it, or any.
    pub(super) fn open(window: Arc<Window>, device: Option<&str>) -> Result<Self, DesktopError> {
        let descriptor = wgpu::InstanceDescriptor::new_with_display_handle(Box::new(Arc::clone(&window))).with_env();
        let instance = wgpu::Instance::new(descriptor);
        let surface = match instance.create_surface(Arc::clone(&window)) {
            Ok(surface) => surface,
            // No backend is left where wgpu's variable says so.
            Err(_) if pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all())).is_empty() => {
                return Err(DesktopError::NoGpu);
            }
            Err(error) => return Err(DesktopError::Window(error.to_string())),
        };
        let adapter = pollster::block_on(adapter(&instance, &surface, device))?;
        let gpu = pollster::block_on(Gpu::open(&adapter))?;
        let capabilities = surface.get_capabilities(&adapter);
        // egui encodes colours itself, so a format that does not is wanted.
        let plain = capabilities.formats.iter().copied().find(|format| !format.is_srgb());
        let format = plain.or(capabilities.formats.first().copied());
        let size = window.inner_size();
        let found = || DesktopError::NoAdapter { found: gpu.name.clone() };
        let [width, height] = within(&gpu, [size.width, size.height]);
        let mut config = surface.get_default_config(&adapter, width, height).ok_or_else(found)?;
        config.format = format.unwrap_or(config.format).remove_srgb_suffix();
        config.present_mode = wgpu::PresentMode::AutoVsync;
        config.desired_maximum_frame_latency = 1;
        surface.configure(&gpu.device, &config);
        Ok(Self { instance, surface, config, window, gpu })
    }

    pub(super) fn format(&self) -> wgpu::TextureFormat {
        self.config.format
    }

    pub(super) fn size(&self) -> [u32; 2] {
        [self.config.width, self.config.height]
    }

    /// Takes another size. A minimised window has none.
    pub(super) fn resize(&mut self, width: u32, height: u32) {
        if width > 0 && height > 0 {
            [self.config.width, self.config.height] = within(&self.gpu, [width, height]);
            self.surface.configure(&self.gpu.device, &self.config);
        }
    }

    /// The next texture to paint.
    pub(super) fn next(&mut self) -> Result<Next, DesktopError> {
        use wgpu::CurrentSurfaceTexture as Current;
        match self.surface.get_current_texture() {
            Current::Success(texture) | Current::Suboptimal(texture) => Ok(Next::Texture(texture)),
            Current::Timeout | Current::Validation => Ok(Next::Again),
            Current::Occluded => Ok(Next::Occluded),
            Current::Outdated => {
                let size = self.window.inner_size();
                self.resize(size.width, size.height);
                Ok(if size.width == 0 || size.height == 0 { Next::Occluded } else { Next::Again })
            }
            Current::Lost => {
                let surface = self.instance.create_surface(Arc::clone(&self.window));
                self.surface = surface.map_err(|error| DesktopError::Window(error.to_string()))?;
                self.surface.configure(&self.gpu.device, &self.config);
                Ok(Next::Again)
            }
        }
    }
}

/// A size that surfaces of a device have: they refuse others.
fn within(gpu: &Gpu, size: [u32; 2]) -> [u32; 2] {
    let most = gpu.device.limits().max_texture_dimension_2d;
    size.map(|side| side.clamp(1, most))
}

/// An adapter that draws onto a surface: one with a name, or the one that wgpu prefers.
async fn adapter(
    instance: &wgpu::Instance,
    surface: &wgpu::Surface<'static>,
    device: Option<&str>,
) -> Result<wgpu::Adapter, DesktopError> {
    if device.is_none() {
        let options = wgpu::RequestAdapterOptions {
            compatible_surface: Some(surface),
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        if let Ok(adapter) = instance.request_adapter(&options).await {
            return Ok(adapter);
        }
    }
    let all = instance.enumerate_adapters(wgpu::Backends::all()).await;
    let name = |adapter: &wgpu::Adapter| format!("{} ({:?})", adapter.get_info().name, adapter.get_info().backend);
    let found: Vec<String> = all.iter().map(name).collect();
    if found.is_empty() {
        return Err(DesktopError::NoGpu);
    }
    let is_wanted =
        |adapter: &wgpu::Adapter| device.is_none_or(|part| name(adapter).to_lowercase().contains(&part.to_lowercase()));
    let wanted: Vec<wgpu::Adapter> = all.into_iter().filter(is_wanted).collect();
    if let Some(name) = device.filter(|_| wanted.is_empty()) {
        return Err(DesktopError::NotNamed { name: name.to_owned(), found });
    }
    let tried: Vec<String> = wanted.iter().map(name).collect();
    let mut fitting = wanted.into_iter().filter(|adapter| adapter.is_surface_supported(surface));
    fitting.next().ok_or_else(|| DesktopError::NoAdapter { found: tried.join(", ") })
}
