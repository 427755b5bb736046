//! The viewer on a page: a canvas, files that are dropped, and with `?check` the check of the browser's device.
//!
//! `web/index.html` has the elements. `cargo xtask web` builds the page.

mod app;
mod check;
mod files;
mod input;
mod page;

use page::Page;

use crate::renderer::Gpu;

/// Runs what the address of the page asks for.
pub fn start() {
    let Some(page) = Page::of_window() else { return };
    let failed_page = page.clone();
    std::panic::set_hook(Box::new(move |panic| failed_page.stop(&format!("The viewer stopped: {panic}"))));
    wasm_bindgen_futures::spawn_local(async move {
        let query = page.query();
        let begun = if query.contains("check") {
            check::run(&page, query.contains("plant")).await
        } else {
            app::run(&page).await
        };
        if let Err(reason) = begun {
            page.show_fallback(&reason);
        }
    });
}

/// Seconds between looks at what no event tells.
const WATCH: f64 = 1.0;

/// The browser's device, whose loss or errors stop the page.
async fn open(
    page: &Page,
    instance: &wgpu::Instance,
    surface: Option<&wgpu::Surface<'_>>,
) -> Result<(wgpu::Adapter, Gpu), String> {
    let options = wgpu::RequestAdapterOptions {
        compatible_surface: surface,
        power_preference: wgpu::PowerPreference::HighPerformance,
        ..Default::default()
    };
    let adapter = instance.request_adapter(&options).await;
    let adapter = adapter.map_err(|error| format!("The browser gives no GPU to pages: {error}"))?;
    let gpu = Gpu::open(&adapter).await.map_err(|error| error.to_string())?;
    watch(page.clone(), gpu.clone());
    Ok((adapter, gpu))
}

/// Says so once the device is lost, or has refused something.
fn watch(page: Page, gpu: Gpu) {
    page.clone().after(WATCH, move || {
        if gpu.is_lost() {
            page.stop("The browser took the GPU back: the device was lost. Models were never sent anywhere; load the page again.");
        } else if let Err(error) = gpu.check() {
            page.stop(&format!("The viewer stopped: {error}"));
        } else {
            watch(page, gpu);
        }
    });
}

fn instance() -> wgpu::Instance {
    let backends = wgpu::Backends::BROWSER_WEBGPU;
    wgpu::Instance::new(wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() })
}
