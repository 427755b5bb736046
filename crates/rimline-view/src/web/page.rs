//! Elements of the page, and what the browser does for it.

use wasm_bindgen::closure::Closure;
use wasm_bindgen::{JsCast, JsValue};
use wasm_bindgen_futures::JsFuture;
use web_sys::{Document, Element, EventTarget, HtmlAnchorElement, Window};

/// The window with its document.
#[derive(Clone)]
pub(super) struct Page {
    pub(super) window: Window,
    pub(super) document: Document,
}

impl Page {
    pub(super) fn of_window() -> Option<Self> {
        let window = web_sys::window()?;
        Some(Self { document: window.document()?, window })
    }

    /// The part of the address from `?` on.
    pub(super) fn query(&self) -> String {
        self.window.location().search().unwrap_or_default()
    }

    pub(super) fn element<T: JsCast>(&self, id: &str) -> Result<T, String> {
        let element = self.document.get_element_by_id(id).and_then(|element| element.dyn_into().ok());
        element.ok_or_else(|| format!("The page has no element `{id}`; load it again"))
    }

    /// Writes text into an element.
    pub(super) fn tell(&self, id: &str, text: &str) {
        if let Ok(element) = self.element::<Element>(id) {
            element.set_text_content(Some(text));
        }
    }

    /// Shows an element that was hidden.
    pub(super) fn show(&self, id: &str) {
        if let Ok(element) = self.element::<Element>(id) {
            // The attribute may be absent already.
            let _ = element.remove_attribute("hidden");
        }
    }

    /// Says why there is no viewer, and shows pictures instead.
    pub(super) fn show_fallback(&self, reason: &str) {
        self.tell("why", reason);
        self.show("fallback");
    }

    /// Says why the viewer cannot go on, and offers to load the page again. The first reason stays: others follow from it.
    pub(super) fn stop(&self, reason: &str) {
        web_sys::console::error_1(&reason.into());
        let said = self.element::<Element>("reason").ok().and_then(|element| element.text_content());
        if said.is_none_or(|said| said.is_empty()) {
            self.tell("reason", reason);
            self.show("stopped");
        }
    }

    /// Seconds since the page was loaded.
    pub(super) fn now(&self) -> f64 {
        self.window.performance().map_or(0.0, |clock| clock.now() / 1e3)
    }

    /// Calls a function when the browser paints next.
    pub(super) fn at_next_frame(&self, call: impl FnOnce() + 'static) {
        let call = Closure::once_into_js(call);
        // Without a frame there is nothing to paint for.
        let _ = self.window.request_animation_frame(call.unchecked_ref());
    }

    /// Calls a function after some seconds.
    pub(super) fn after(&self, seconds: f64, call: impl FnOnce() + 'static) {
        let (call, milliseconds) = (Closure::once_into_js(call), (seconds * 1e3).clamp(0.0, 1e9) as i32);
        let _ = self.window.set_timeout_with_callback_and_timeout_and_arguments_0(call.unchecked_ref(), milliseconds);
    }

    /// Lets the browser save a PNG file.
    pub(super) fn download(&self, name: &str, bytes: &[u8]) -> Result<(), JsValue> {
        let parts = js_sys::Array::of1(&js_sys::Uint8Array::from(bytes));
        let options = web_sys::BlobPropertyBag::new();
        options.set_type("image/png");
        let blob = web_sys::Blob::new_with_u8_array_sequence_and_options(&parts, &options)?;
        let url = web_sys::Url::create_object_url_with_blob(&blob)?;
        let link: HtmlAnchorElement = self.document.create_element("a")?.unchecked_into();
        link.set_href(&url);
        link.set_download(name);
        link.click();
        // The browser reads it meanwhile.
        self.after(60.0, move || _ = web_sys::Url::revoke_object_url(&url));
        Ok(())
    }

    /// The maker and kind of the GPU that `super::open` opens, as far as the browser tells them.
    pub(super) async fn gpu(&self) -> String {
        let get = |object: &JsValue, name: &str| js_sys::Reflect::get(object, &name.into()).unwrap_or_default();
        let gpu = get(&self.window.navigator(), "gpu");
        let adapter = async {
            let request: js_sys::Function = get(&gpu, "requestAdapter").dyn_into().ok()?;
            // Another preference may name another GPU.
            let options = JsValue::from(js_sys::Object::new());
            js_sys::Reflect::set(&options, &"powerPreference".into(), &"high-performance".into()).ok()?;
            let promise: js_sys::Promise = request.call1(&gpu, &options).ok()?.dyn_into().ok()?;
            JsFuture::from(promise).await.ok()
        };
        let info = adapter.await.map(|adapter| get(&adapter, "info")).unwrap_or_default();
        let known =
            ["vendor", "architecture", "description"].map(|name| get(&info, name).as_string().unwrap_or_default());
        let known: Vec<&str> = known.iter().map(String::as_str).filter(|word| !word.is_empty()).collect();
        if known.is_empty() { "a GPU that the browser does not name".into() } else { known.join(" ") }
    }

    /// Puts text on the clipboard. Pages without https have none.
    pub(super) async fn copy(&self, text: &str) -> bool {
        let navigator = self.window.navigator();
        let is_there = js_sys::Reflect::get(&navigator, &"clipboard".into()).is_ok_and(|there| !there.is_undefined());
        is_there && JsFuture::from(navigator.clipboard().write_text(text)).await.is_ok()
    }
}

/// Calls a function at each event of a kind, as long as the page lives.
pub(super) fn listen<E: JsCast>(target: &EventTarget, kind: &str, mut hear: impl FnMut(E) + 'static) {
    let hear = Closure::<dyn FnMut(web_sys::Event)>::new(move |event: web_sys::Event| hear(event.unchecked_into()));
    // It fails only where the kind is no text.
    let _ = target.add_event_listener_with_callback(kind, hear.as_ref().unchecked_ref());
    hear.forget();
}

/// An error of the browser in words.
pub(super) fn words(error: &JsValue) -> String {
    error.dyn_ref::<js_sys::Error>().map_or_else(|| format!("{error:?}"), |error| String::from(error.message()))
}
