//! `?check`: the bits of the browser's device against those of the CPU, which the page computes itself.

use rimline_models::check::{Report, Row, cases};
use web_sys::{Element, EventTarget};

use super::page::{Page, listen};

/// Checks scene after scene, and shows the table grow. `is_planted`: turns a bit over, to see that this is noticed.
pub(super) async fn run(page: &Page, is_planted: bool) -> Result<(), String> {
    let (_, gpu) = super::open(page, &super::instance(), None).await?;
    page.show("check");
    let copied = page.clone();
    listen(&page.element::<EventTarget>("copy")?, "click", move |_: web_sys::Event| {
        let page = copied.clone();
        wasm_bindgen_futures::spawn_local(async move {
            let table =
                page.element::<Element>("table").ok().and_then(|table| table.text_content()).unwrap_or_default();
            page.tell("copy", if page.copy(&table).await { "Copied" } else { "Select the table and copy it" });
        });
    });
    let browser = page.window.navigator().user_agent().unwrap_or_default();
    let mut report = Report { device: format!("{}\n{browser}", page.gpu().await), rows: Vec::new() };
    for case in cases() {
        let found = match case.on_gpu(&gpu.queue, &gpu.pipelines) {
            Ok(found) => found.await,
            Err(reason) => Err(reason),
        };
        let mut right = case.on_cpu();
        if is_planted && report.rows.is_empty() {
            right.plant();
        }
        let wrong_bits = found.map(|found| found.different(&right));
        report.rows.push(Row { scene: case.name.clone(), pairs: case.pairs(), wrong_bits });
        page.tell("table", &report.to_string());
    }
    page.tell("said", "The check is done.");
    Ok(())
}
