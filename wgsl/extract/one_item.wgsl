// Invocations that take one face or edge record of a single mesh each.

fn take_items(first: u32, step: u32) {
  if (first < chunk.count) {
    take_item(first, first);
  }
}
